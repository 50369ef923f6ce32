"""Code-to-code validation: the model beside time series of the same floater in the same sea."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fowtio.case import Reference
from fowtio.errors import ModelError
from fowtio.read.openfast_out import TimeSeries, read_openfast_out
from fowtio.workflow import Model, OperatingPoint, state_excitation
from model.response.identify import BANDS, WHOLE_BAND, Estimate, estimate, peak, rao_error, smooth_like_welch
from model.response.loads import channel_response
from model.response.nonlinear import record_channels, record_response
from model.response.solve import Excitation, prepare, solve

WAVE_CHANNELS = ("Wave1Elev",)
_TO_SI = {"deg": np.pi / 180, "kN": 1e3, "kN-m": 1e3, "kN·m": 1e3}


@dataclass(frozen=True, eq=False, kw_only=True)
class ChannelComparison:
    """One channel, model against reference: standard deviations, errors as fractions, coherence and resonance.

    band_errors (4) over the bands of `model.response.identify`; scatter is the reference's own, from seed to seed. The figures
    named nonlinear are those of the model with quadratic drag itself, driven by the reference's own waves (NaN when not asked for).
    """

    name: str
    unit: str
    std_model: float
    std_reference: float
    std_error: float
    std_error_same_waves: float
    std_error_nonlinear: float
    scatter: float
    mean_model: float
    mean_reference: float
    rao_error: float
    rao_error_nonlinear: float
    band_errors: tuple[float, ...]
    coherence_mean: float
    peak_frequency: float
    peak_frequency_error: float
    peak_error: float
    passed: bool


@dataclass(frozen=True, eq=False, kw_only=True)
class Validation:
    """A comparison of one state with its time series: channels, the estimate, the model's RAO smoothed and raw on the
    estimate's frequencies (n, c), that with quadratic drag itself, and reference channels that the model does not have.
    """

    state: str
    files: tuple[str, ...]
    channels: tuple[ChannelComparison, ...]
    estimate: Estimate
    model_rao: np.ndarray
    model_rao_raw: np.ndarray
    quadratic_rao: np.ndarray | None
    tolerance: float
    unmatched: tuple[str, ...]

    @property
    def passed(self) -> bool:
        """Whether every channel is within the tolerance on its standard deviation."""
        return all(c.passed for c in self.channels)


def validate(
    model: Model, reference: Reference, *, nonlinear: bool = True, progress: Callable[[str], None] = lambda text: None
) -> Validation:
    """Return the comparison of a state's model with reference time series of all seeds.

    nonlinear adds the model with quadratic drag itself on each record, which shows what the linearisation costs.
    Raises ModelError or FormatError.
    """
    state = next((s for s in model.states if s.name == reference.state), None)
    if state is None:
        raise ModelError(f"the reference names state {reference.state!r}, which the study does not have")
    progress(f"reading {len(reference.files)} time series")
    series = [read_openfast_out(path) for path in reference.files]
    point = model.at(state.wind_speed)
    names, unmatched = _common(point, series)
    wave = next((w for w in WAVE_CHANNELS if w.lower() in (n.lower() for n in series[0].names)), None)
    if wave is None:
        raise ModelError(f"{series[0].source} has no wave elevation channel ({', '.join(WAVE_CHANNELS)})")
    step = float(np.median(np.diff(series[0].time)))
    inputs, outputs = zip(*(_usable(s, wave, names, reference.discard) for s in series), strict=True)
    progress("estimating spectra")
    found = estimate(inputs, outputs, step)
    waves = estimate([s.channel(wave) for s in series], [s.channel(wave)[:, None] for s in series], step).input_spectrum
    progress("evaluating the model")
    fine = 1 / (10 * found.segment)
    hz = np.arange(1, int(0.5 / fine) + 1) * fine
    drive = state_excitation(model, state, 2 * np.pi * hz)
    transfer, mean = _transfer(model, point, drive, names)
    smooth, raw = _on_estimate(transfer, drive, found, fine, step)
    same_waves = _same_waves_std(hz, transfer, series, wave, reference.discard)
    exact = _with_quadratic_drag(model, point, drive, series, wave, names, reference.discard, progress) if nonlinear else None
    channels = _compare(model, point, names, found, waves, smooth, mean, same_waves, exact, reference.tolerance)
    return Validation(
        state=state.name, files=tuple(str(p) for p in reference.files), channels=channels, estimate=found, model_rao=smooth,
        model_rao_raw=raw, quadratic_rao=None if exact is None else exact.energy_rao, tolerance=reference.tolerance, unmatched=unmatched,
    )  # fmt: skip


def _common(point: OperatingPoint, series: list[TimeSeries]) -> tuple[list[str], tuple[str, ...]]:
    """Return the channels that model and all series have and that move in the reference, and the others of the reference."""
    in_all = set.intersection(*({n.lower() for n in s.names} for s in series))
    still = {n.lower() for n in series[0].names if np.ptp(series[0].channel(n)) == 0}
    names = [n for n in point.outputs.names if n.lower() in in_all - still and _excited(point, series, n)]
    if not names:
        raise ModelError(f"{series[0].source} has none of the model's channels ({', '.join(point.outputs.names)})")
    known = {n.lower() for n in names}
    return names, tuple(n for n in series[0].names if n.lower() not in known)


def _excited(point: OperatingPoint, series: list[TimeSeries], name: str) -> bool:
    """Tell whether a channel moves more than rounding: sway in head waves does not."""
    data = series[0].channel(name)
    of_kind = [np.std(series[0].channel(n)) for n in series[0].names if series[0].unit(n) == series[0].unit(name)]
    return float(np.std(data)) > 1e-3 * max(of_kind)


def _usable(series: TimeSeries, wave: str, names: list[str], discard: float) -> tuple[np.ndarray, np.ndarray]:
    """Return wave elevation (k) and channels (k, c) in SI after the transient."""
    keep = series.time >= series.time[0] + discard
    if keep.sum() < 100:
        raise ModelError(f"{series.source}: fewer than 100 samples remain after {discard:g} s are discarded")
    data = np.stack([series.channel(n) * _TO_SI.get(series.unit(n), 1.0) for n in names], axis=1)
    return series.channel(wave)[keep], data[keep]


def _transfer(model: Model, point: OperatingPoint, drive: Excitation, names: list[str]) -> tuple[np.ndarray, np.ndarray]:
    """Return the model's transfer functions (n, c) from wave elevation and its mean values (c)."""
    options = model.case.options
    grid = prepare(point.system, drive.omega, drive.heading, low_frequency=options.low_frequency_excitation)
    response = solve(point.system, point.mean, drive, grid=grid, drag=options.drag_model)
    channels = channel_response(point.outputs, response)
    index = [channels.index(n) for n in names]
    return channels.to_wave[0][:, index], channels.mean[index]


def _on_estimate(transfer, drive: Excitation, found: Estimate, fine: float, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the model's RAO magnitude, smoothed by the estimate's window and raw, on the estimate's frequencies (n, c)."""
    spectrum = np.concatenate([[0.0], drive.wave_spectrum[0]])[:, None]
    magnitude = np.concatenate([np.abs(transfer[:1]), np.abs(transfer)])
    top = smooth_like_welch(magnitude**2 * spectrum, fine, found.segment, step)
    bottom = smooth_like_welch(spectrum, fine, found.segment, step)
    with np.errstate(divide="ignore", invalid="ignore"):
        smooth = np.sqrt(top / bottom)
    places = np.round(found.frequency / fine).astype(int)
    inside = places < len(magnitude)
    out = np.full((2, len(places), magnitude.shape[1]), np.nan)
    out[0, inside], out[1, inside] = smooth[places[inside]], magnitude[places[inside]]
    return out[0], out[1]


def _same_waves_std(hz, transfer, series: list[TimeSeries], wave: str, discard: float) -> np.ndarray:
    """Return standard deviations (c) of the model driven by the reference's own wave records, over the same part of each.

    The records are taken as periodic, as OpenFAST's waves are when the run is as long as the wave record.
    """
    variance = []
    for s in series:
        n = len(s.time) - 1
        step = (s.time[-1] - s.time[0]) / n
        spectrum = np.fft.rfft(s.channel(wave)[:n])
        f = np.fft.rfftfreq(n, step)
        h = np.stack([np.interp(f, hz, c.real) + 1j * np.interp(f, hz, c.imag) for c in transfer.T], axis=1)
        h[(f == 0) | (f > hz[-1])] = 0.0
        motion = np.fft.irfft(spectrum[:, None] * h, n, axis=0)
        variance.append(motion[int(round(discard / step)) :].var(axis=0))
    return np.sqrt(np.mean(variance, axis=0))


def _with_quadratic_drag(model: Model, point: OperatingPoint, drive, series, wave, names, discard, progress) -> Estimate:
    """Return the estimate from the model with quadratic drag itself, driven by each record's own waves, cut like the records."""
    inputs, outputs = [], []
    for k, s in enumerate(series, start=1):
        progress(f"quadratic drag on record {k} of {len(series)}")
        n = len(s.time) - 1
        step = (s.time[-1] - s.time[0]) / n
        elevation = s.channel(wave)[:n]
        try:
            response = record_response(point.system, point.mean, elevation, step, drive,
                                       low_frequency=model.case.options.low_frequency_excitation)  # fmt: skip
        except ValueError as error:
            raise ModelError(f"{s.source}: {error}") from None
        start = round(discard / step)
        inputs.append(elevation[start:])
        outputs.append(record_channels(point.outputs, response, names)[start:])
    return estimate(inputs, outputs, step)


def _compare(model, point, names, found: Estimate, waves, smooth, mean, same_waves, exact: Estimate | None, tolerance) -> tuple[ChannelComparison, ...]:
    f, step = found.frequency, found.frequency[1]
    band = (f >= WHOLE_BAND[0] / 3) & np.isfinite(smooth).all(axis=1)
    std_model = np.sqrt((smooth[band] ** 2 * waves[band, None]).sum(axis=0) * step)
    reference = np.nan_to_num(found.energy_rao)
    errors = rao_error(np.nan_to_num(smooth), reference, found.input_spectrum, f)
    lost = np.full(len(names), np.nan)
    nonlinear = lost if exact is None else exact.std / found.std - 1
    rao_nonlinear = lost if exact is None else rao_error(np.nan_to_num(exact.energy_rao), reference, found.input_spectrum, f)
    per_band = np.array([rao_error(np.nan_to_num(smooth), reference, found.input_spectrum, f, b) for b in BANDS])
    inside = (f >= WHOLE_BAND[0]) & (f <= WHOLE_BAND[1])
    coherence = found.coherence[inside].mean(axis=0)
    out = []
    for k, name in enumerate(names):
        near = _resonance(model, point, reference[:, k], f)
        (f_ref,), (h_ref,) = peak(reference[:, [k]], f, near)
        (f_model,), (h_model,) = peak(np.nan_to_num(smooth[:, [k]]), f, near)
        error = std_model[k] / found.std[k] - 1
        out.append(
            ChannelComparison(
                name=name, unit=point.outputs.units[point.outputs.names.index(name)], std_model=std_model[k],
                std_reference=found.std[k], std_error=error, std_error_same_waves=same_waves[k] / found.std[k] - 1,
                std_error_nonlinear=nonlinear[k], rao_error_nonlinear=rao_nonlinear[k],
                scatter=found.scatter[k], mean_model=mean[k], mean_reference=found.mean[k], rao_error=errors[k],
                band_errors=tuple(per_band[:, k]), coherence_mean=coherence[k], peak_frequency=f_ref,
                peak_frequency_error=f_model / f_ref - 1, peak_error=h_model / h_ref - 1, passed=bool(abs(error) <= tolerance),
            )
        )  # fmt: skip
    return tuple(out)


def _resonance(model: Model, point: OperatingPoint, reference: np.ndarray, f: np.ndarray) -> tuple[float, float]:
    """Return the band [Hz] around the natural frequency at which the reference's RAO of a channel is largest."""
    natural = point.modes.frequency / (2 * np.pi)
    natural = natural[(natural > WHOLE_BAND[0]) & (natural < WHOLE_BAND[1])]
    if not len(natural):
        return WHOLE_BAND
    heights = [reference[(f > 0.85 * n) & (f < 1.15 * n)].max(initial=0.0) for n in natural]
    best = natural[int(np.argmax(heights))]
    return 0.75 * best, 1.25 * best


def write_validation(found: list[Validation], folder, *, progress: Callable[[str], None] = lambda text: None) -> list:
    """Write the comparison: RAO figures as PNG and SVG, tables as CSV; return the files written."""
    from fowtio.write.validation import write_comparison

    progress("writing the comparison")
    return write_comparison(found, folder)
