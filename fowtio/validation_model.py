"""The model's side of a comparison: transfer functions, spectra in the reference's own waves and wind, and drag as it is."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import get_window

from fowtio.case import StateEntry
from fowtio.errors import FormatError, ModelError
from fowtio.read.openfast_input import read_input
from fowtio.reference import Records
from fowtio.workflow import Model, OperatingPoint, state_excitation, state_wind
from model.environment.wind import wind_spectrum
from model.response.assemble import Modes, natural_modes
from model.response.identify import Estimate, estimate, smooth_like_welch
from model.response.loads import channel_response
from model.response.mean_shift import mooring_shift, motion_covariance
from model.response.nonlinear import record_channels, record_model, solve_record
from model.response.solve import Excitation, Response, frequency_grid, prepare, solve
from model.system.convolution import convolved_radiation

POINTS = 1500
THRUST_TOP = 0.2  # Hz
WORKERS = 2


@dataclass(frozen=True, eq=False, kw_only=True)
class ModelSide:
    """The model for one state: its response, its modes with drag; on uniform frequencies hz (n) from `step`: channels' transfer
    functions to the waves (m, n, c), the wind (n, c) and its gradients (2, n, c), mean (c), and the state's spectra per Hz: waves
    (m, n), wind and gradients (n), wind at the hub (n); incoherent (n, c), spectra of the channels that drag causes without
    coherence with waves or wind.
    """

    point: OperatingPoint
    response: Response
    modes: Modes
    hz: np.ndarray
    to_wave: np.ndarray
    to_wind: np.ndarray
    to_gradients: np.ndarray
    mean: np.ndarray
    waves: np.ndarray
    wind: np.ndarray
    gradients: np.ndarray
    hub: np.ndarray
    incoherent: np.ndarray

    @property
    def step(self) -> float:
        """Spacing of the frequencies [Hz]."""
        return float(self.hz[0])

    @property
    def main(self) -> int:
        """Place of the heading with the most wave energy."""
        return int(np.argmax(self.waves.sum(axis=1)))

    @property
    def incoherent_in_waves(self) -> np.ndarray:
        """The incoherent spectra (n, c) where the waves have energy (1e-4 of their largest), zero elsewhere."""
        waves = self.waves[self.main]
        return self.incoherent * (waves > 1e-4 * waves.max())[:, None]

    def place(self, frequency) -> np.ndarray:
        """Return the places among (0, *hz) of frequencies [Hz] that are multiples of the spacing."""
        return np.round(np.asarray(frequency) / self.step).astype(int)


def evaluate(model: Model, state: StateEntry, names: Sequence[str], segment: float, top: float) -> ModelSide:
    """Return the model's side for channels by name; segment [s] of the estimate, top [Hz] the highest frequency."""
    point, options = model.at(state.wind_speed), model.case.options
    m = point.modes
    damping = np.maximum(m.damping_ratio, [0.004 if n.startswith("tower") else 0.02 for n in m.names])
    order = np.argsort(m.frequency)
    edges = sorted({2 * np.pi * f for sea in state.seas if sea.band is not None for f in sea.band})
    omega = frequency_grid(
        2 * np.pi * options.frequency_low, 2 * np.pi * top, POINTS, m.frequency[order], damping[order], edges=edges
    )
    drive = state_excitation(model, state, omega)
    grid = prepare(point.system, omega, drive.heading, low_frequency=options.low_frequency_excitation)
    response = solve(point.system, point.mean, drive, grid=grid, drag=options.drag_model)
    channels = channel_response(point.outputs, response)
    index = [channels.index(n) for n in names]
    spacing = 1 / (10 * segment)
    hz = np.arange(1, round(top / spacing) + 1) * spacing
    even = state_excitation(model, state, 2 * np.pi * hz)
    gusts = state_wind(model, state)
    hub = np.zeros_like(hz) if gusts is None else wind_spectrum(gusts, 2 * np.pi * hz) * 2 * np.pi
    return ModelSide(
        point=point, response=response, modes=natural_modes(point.system, point.mean, response.drag_damping), hz=hz,
        to_wave=on_grid(channels.to_wave[..., index], omega, hz), to_wind=on_grid(channels.to_wind[:, index], omega, hz),
        to_gradients=on_grid(channels.to_gradients[..., index], omega, hz), mean=channels.mean[index], waves=even.wave_spectrum * 2 * np.pi,
        wind=even.wind_spectrum * 2 * np.pi, gradients=even.gradient_spectrum * 2 * np.pi, hub=hub,
        incoherent=on_grid(channels.incoherent[:, index] * 2 * np.pi, omega, hz),
    )  # fmt: skip


def on_grid(values: np.ndarray, omega: np.ndarray, hz: np.ndarray) -> np.ndarray:
    """Return complex values (..., n, c) on omega (n) interpolated to frequencies hz (k) [Hz], (..., k, c)."""
    at = np.clip(np.searchsorted(omega, 2 * np.pi * hz) - 1, 0, len(omega) - 2)
    w = np.clip((2 * np.pi * hz - omega[at]) / (omega[at + 1] - omega[at]), 0.0, 1.0)[:, None]
    return (1 - w) * values[..., at, :] + w * values[..., at + 1, :]


def smoothed_rao(side: ModelSide, found: Estimate, sample: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the model's RAO magnitude |H|2 for its main heading on the estimate's frequencies (n, c), seen through its window, and raw.

    All of the response's energy, with the incoherent part where the waves have energy.
    """
    spectrum = side.waves[side.main][:, None]
    power = np.abs(side.to_wave[side.main]) ** 2 * spectrum + side.incoherent_in_waves
    with np.errstate(divide="ignore", invalid="ignore"):
        magnitude = np.where(spectrum > 0, np.sqrt(power / spectrum), np.abs(side.to_wave[side.main]))
    magnitude, power = (np.concatenate([x[:1], x]) for x in (magnitude, power))
    spectrum = np.concatenate([[[0.0]], spectrum])
    top = smooth_like_welch(power, side.step, found.segment, sample)
    bottom = smooth_like_welch(spectrum, side.step, found.segment, sample)
    with np.errstate(divide="ignore", invalid="ignore"):
        smooth = np.sqrt(top / bottom)
    return at_estimate(smooth, side, found), at_estimate(magnitude, side, found)


def incoherent_rao(side: ModelSide, found: Estimate, sample: float) -> np.ndarray:
    """Return what the incoherent part adds to |H|2 in the square, as a magnitude on the estimate's frequencies (n, c), through its window."""
    power = np.concatenate([side.incoherent[:1], side.incoherent_in_waves])
    waves = np.concatenate([[0.0], side.waves[side.main]])[:, None]
    top, bottom = (smooth_like_welch(x, side.step, found.segment, sample) for x in (power, waves))
    with np.errstate(divide="ignore", invalid="ignore"):
        return at_estimate(np.sqrt(top / bottom), side, found)


def model_coherence(side: ModelSide, found: Estimate, sample: float) -> np.ndarray:
    """Return the coherence (n, c) that the model expects with its main heading's waves, seen through the estimate's window.

    Below one where drag answers the waves incoherently, and where the window spans a turning phase.
    """
    waves, transfer = side.waves[side.main][:, None], side.to_wave[side.main]
    spectra = transfer * waves, np.abs(transfer) ** 2 * waves + side.incoherent_in_waves, waves
    cross, power, waves = (smooth_like_welch(np.concatenate([0 * x[:1], x]), side.step, found.segment, sample) for x in spectra)
    with np.errstate(divide="ignore", invalid="ignore"):
        return at_estimate(np.abs(cross) ** 2 / (power * waves), side, found)


def phase_at(side: ModelSide, found: Estimate) -> np.ndarray:
    """Return the phase [rad] of the model's response to its main heading on the estimate's frequencies (n, c)."""
    turns = side.to_wave[side.main]
    return np.angle(at_estimate(np.concatenate([turns[:1], turns]), side, found))


def smoothed_spectrum(
    side: ModelSide, spectrum: np.ndarray, found: Estimate, sample: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return spectra (n, c) on the side's frequencies as the estimate's window shows them, on its frequencies, and raw."""
    full = np.concatenate([spectrum[:1], spectrum])
    return at_estimate(smooth_like_welch(full, side.step, found.segment, sample), side, found), at_estimate(
        full, side, found
    )


def at_estimate(values: np.ndarray, side: ModelSide, found: Estimate) -> np.ndarray:
    """Return values (n + 1, c), from zero frequency, on an estimate's frequencies (k, c); NaN above the model's."""
    places = side.place(found.frequency)
    out = np.full((len(places), values.shape[1]), np.nan, dtype=values.dtype)
    inside = places < len(values)
    out[inside] = values[places[inside]]
    return out


def response_spectrum(
    side: ModelSide, waves: np.ndarray, wind: np.ndarray, gradients: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return response spectra (n, c) per Hz from wave spectra (m, n) and drag's incoherent part, and from spectra of the rotor's wind and its
    gradients (n).
    """
    of_waves = np.einsum("mnc,mn->nc", np.abs(side.to_wave) ** 2, waves) + side.incoherent
    of_gradients = (np.abs(side.to_gradients) ** 2).sum(axis=0) * gradients[:, None]
    return of_waves, np.abs(side.to_wind) ** 2 * wind[:, None] + of_gradients


def own_waves(side: ModelSide, found: Estimate) -> np.ndarray:
    """Return the wave spectra (m, n) of the records, shared between headings as in the state."""
    total = side.waves.sum(axis=0)
    measured = np.interp(side.hz, found.frequency, found.input_spectrum)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(total > 0, side.waves / total * measured, 0.0)


def hub_ratio(side: ModelSide, records: Records, segment: float) -> np.ndarray | None:
    """Return the spectrum of the records' wind at the hub over that of the state (n), None without either."""
    if records.wind is None or not np.any(side.hub):
        return None
    seen = _spectrum(records.cut(records.wind), records.step, segment)
    smooth, _ = smoothed_spectrum(side, side.hub[:, None], seen, records.step)
    usable = (seen.frequency >= 2 / segment) & np.isfinite(smooth[:, 0]) & (seen.frequency < 0.2 / records.step)
    return np.interp(side.hz, seen.frequency[usable], seen.input_spectrum[usable] / smooth[usable, 0])


def rotor_wind(side: ModelSide, records: Records, structure) -> list[np.ndarray] | None:
    """Return the wind (t) [m/s] that the rotor of each record felt, as its thrust and its hub's motion tell; None without them.

    The thrust is F = F0 + k (u - v) with the model's own thrust per wind speed k and the hub's velocity v: u = (F - F0) / k + v. Up to
    0.2 Hz, below the blades' passing.
    """
    per_speed = float(side.point.system.wind_force[0])
    if records.thrust is None or "PtfmSurge" not in records.names or per_speed <= 0:
        return None
    arms = {"PtfmSurge": 1.0, "PtfmPitch": structure.hub_height, "TTDspFA": 1.0}
    out = []
    for thrust, channels in zip(records.thrust, records.channels, strict=True):
        hub = sum(channels[:, records.names.index(n)] * a for n, a in arms.items() if n in records.names)
        count = len(thrust) - 1
        hertz = np.fft.rfftfreq(count, records.step)
        force = np.fft.rfft(thrust[:count] * np.cos(structure.rotor.tilt))
        felt = force / per_speed + 2j * np.pi * hertz * np.fft.rfft(hub[:count])
        felt[(hertz == 0) | (hertz > THRUST_TOP)] = 0.0
        wind = np.fft.irfft(felt, count)
        out.append(np.concatenate([wind, wind[:1]]))
    return out


def own_wind(side: ModelSide, records: Records, felt: list[np.ndarray] | None, segment: float) -> np.ndarray:
    """Return the spectrum (n) per Hz of the rotor's wind in the records: that felt, the state's above 0.2 Hz and where none was felt."""
    if felt is None:
        return side.wind
    seen = _spectrum(records.cut(felt), records.step, segment)
    return np.where(side.hz < THRUST_TOP, np.interp(side.hz, seen.frequency[1:], seen.input_spectrum[1:]), side.wind)


def _spectrum(series: list[np.ndarray], step: float, segment: float) -> Estimate:
    return estimate(series, [s[:, None] for s in series], step, segment)


def moving_mean(side: ModelSide, records: Records, structure) -> np.ndarray:
    """Return the means (c) of the channels with what the mean position at rest leaves out: the moorings' mean force and tensions while the
    floater moves, and the mean thrust of the records (where they have it) instead of that in steady wind.
    """
    point = side.point
    outputs, index = point.outputs, [point.outputs.names.index(n) for n in records.names]
    force, tension = mooring_shift(point.system, point.mean, motion_covariance(side.response))
    more = {f"T[{k}]": t for k, t in enumerate(tension, start=1)}
    change, per_speed = 0.0, float(point.system.wind_force[0])
    if records.thrust is not None and per_speed > 0 and point.mean.mooring is not None and "PtfmPitch" in records.names:
        pitch = np.mean([c[:, records.names.index("PtfmPitch")].mean() for c in records.cut(records.channels)])
        thrust = np.mean([t.mean() for t in records.cut(records.thrust)]) * np.cos(structure.rotor.tilt - pitch)
        change = (thrust + point.mean.mooring.force[0]) / per_speed
    offset = np.linalg.solve(point.mean.stiffness, force + point.system.wind_force * change)
    pulled = np.array([more.get(n, 0.0) for n in records.names])
    return side.mean + outputs.position[index] @ offset + outputs.wind[index, 0] * change + pulled


def window_matrix(hz: np.ndarray, frequency: np.ndarray, segment: float, sample: float) -> np.ndarray:
    """Return the weights (k, n) with which a Hann segment shows spectra on uniform hz (n) at frequencies (k)."""
    step = hz[1] - hz[0]
    length = round(segment / sample)
    reach = np.arange(-round(8 / segment / step), round(8 / segment / step) + 1)
    power = (
        np.abs(np.exp(-2j * np.pi * np.outer(reach * step, np.arange(length) * sample)) @ get_window("hann", length))
        ** 2
    )
    power /= power.sum()
    out = np.zeros((len(frequency), len(hz)))
    for row, f in enumerate(frequency):
        columns = round((f - hz[0]) / step) + reach
        inside = (columns >= 0) & (columns < len(hz))
        out[row, columns[inside]] = power[inside]
    return out


def quadratic_drag(
    model: Model, side: ModelSide, records: Records, progress: Callable[[str], None]
) -> tuple[list[np.ndarray], list[np.ndarray] | None]:
    """Return the channels' series (t, c) of every record from the model with drag as it is, without the transient; and the same
    with the radiation memory as the deck's HydroDyn convolves it, None where the deck has no memory.

    Raises ModelError when an iteration does not converge.
    """
    point, options = side.point, model.case.options
    heading = float(side.response.excitation.heading[side.main])
    systems = [point.system]
    convolution = radiation_settings(model)
    if convolution is not None:
        systems.append(replace(point.system, hydro=convolved_radiation(point.system.hydro, *convolution)))
    ready = {
        n: [
            record_model(s, point.mean, n, records.step, heading, side.response.drag_damping, low_frequency=options.low_frequency_excitation)
            for s in systems
        ] for n in {len(w) - 1 for w in records.waves}
    }  # fmt: skip

    def one(k: int) -> list[np.ndarray]:
        progress(f"quadratic drag on record {k + 1} of {len(records.waves)}")
        out, start, elevation = [], None, records.waves[k][:-1]
        for r in ready[len(elevation)]:
            try:
                found = solve_record(r, elevation, start=start)
            except ValueError as error:
                raise ModelError(f"{records.files[k]}: {error}") from None
            start = found.amplitude
            out.append(record_channels(point.outputs, found, records.names)[records.start :])
        return out

    with ThreadPoolExecutor(WORKERS) as pool:
        found = list(pool.map(one, range(len(records.waves))))
    return [f[0] for f in found], [f[1] for f in found] if convolution is not None else None


def radiation_settings(model: Model) -> tuple[float, float] | None:
    """Return length and step [s] of the deck's radiation memory, None when it has none or they are not said."""
    hydrodyn = model.deck.hydrodyn
    if hydrodyn is None or hydrodyn.radiation_model != 1:
        return None
    try:
        length = hydrodyn.input.number("RdtnTMax", 0.0)
        step = None if hydrodyn.input.is_default("RdtnDT") else hydrodyn.input.number("RdtnDT")
        step = read_input(model.deck.path).number("DT") if step is None else step
    except FormatError:
        return None
    return (length, step) if 0 < step < length else None


def one_wave(drive: Excitation) -> bool:
    """Tell whether one long-crested sea and nothing else drives a model."""
    return len(drive.heading) == 1 and not np.any(drive.wind_spectrum) and bool(np.any(drive.wave_spectrum))
