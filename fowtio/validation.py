"""Code-to-code validation: the model beside time series of the same floater in the same sea and wind."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.stats import kurtosis

from fowtio.case import StateEntry
from fowtio.case_validation import Reference
from fowtio.errors import ModelError
from fowtio.read.openfast_out import TimeSeries, read_openfast_out
from fowtio.reference import Finding, Records, records_of
from fowtio.reference_checks import agreement_findings, length_findings, sea_findings, still_findings
from fowtio.validation_lack import DecayComparison, compare_decay, lacking
from fowtio.validation_model import (
    THRUST_TOP,
    ModelSide,
    evaluate,
    hub_ratio,
    incoherent_rao,
    model_coherence,
    moving_mean,
    one_wave,
    own_waves,
    own_wind,
    phase_at,
    quadratic_drag,
    response_spectrum,
    rotor_wind,
    smoothed_rao,
    smoothed_spectrum,
)
from fowtio.validation_types import (
    NAN,
    NOT_JUDGED,
    OUTSIDE,
    SCATTER,
    WITHIN,
    ChannelComparison,
    Histories,
    Validation,
)
from fowtio.workflow import Model
from model.response.identify import SEGMENT, Estimate, choose_segment, estimate
from model.response.loads import channel_response, response_spectra
from model.response.measures import (
    BANDS,
    WHOLE_BAND,
    amplitude_error,
    log_error,
    peak,
    rao_error,
    relative_mean_error,
    seed_interval,
    seen_by_record,
)
from model.response.reconstruct import correlation, driven_by, with_phases_of
from model.response.statistics import statistics

HIGHEST = 0.45  # Hz, of reconstructed time histories
LIGHT = 0.02  # damping ratio that drag gives a resonance at least


def validate(
    model: Model, reference: Reference, *, nonlinear: bool = True, series: Sequence[TimeSeries] | None = None,
    progress: Callable[[str], None] = lambda text: None,
) -> Validation:  # fmt: skip
    """Return the comparison of a state's model with reference time series of all seeds.

    nonlinear adds the model with quadratic drag itself on each record, which shows what the linearisation costs (one long-crested
    sea, no wind, no current). series are the time series when they have been read already. Raises ModelError or FormatError.
    """
    state = next((s for s in model.states if s.name == reference.state), None)
    if state is None:
        raise ModelError(f"the reference names state {reference.state!r}, which the study does not have")
    progress(f"reading {len(reference.files)} time series")
    outputs = model.at(state.wind_speed).outputs
    series = [read_openfast_out(path) for path in reference.files] if series is None else series
    records = records_of(series, reference, outputs.names, outputs.units)
    if not any(np.ptp(w[records.start :]) > 0 for w in records.waves) and not _gusty(records):
        return _means_only(model, state, reference, records)
    progress("evaluating the model")
    segment = _segment(model, state, records)
    side = evaluate(model, state, records.names, segment, 0.5 / records.step)
    progress("estimating spectra")
    found = estimate(records.cut(records.waves), records.cut(records.channels), records.step, segment)
    compare = _compare_rao if one_wave(side.response.excitation) else _compare_spectra
    return compare(model, state, reference, records, side, found, nonlinear, progress)


def validate_study(
    model: Model, *, nonlinear: bool = True, progress: Callable[[str], None] = lambda text: None
) -> tuple[list[Validation], list[DecayComparison]]:
    """Return all comparisons that a study names: reference time series and decay tests. Raises ModelError or FormatError."""
    found = [validate(model, r, nonlinear=nonlinear, progress=progress) for r in model.case.references]
    return found, [compare_decay(model, d, progress=progress) for d in model.case.decays]


def _gusty(records: Records) -> bool:
    """Tell whether the hub's wind changes."""
    return records.wind is not None and any(np.std(w[records.start :]) > 1e-3 * abs(np.mean(w)) for w in records.wind)


def _segment(model: Model, state: StateEntry, records: Records) -> float:
    """Return the segments' length [s]: as the narrowest resonance needs and the shortest record allows."""
    modes = model.at(state.wind_speed).modes
    hertz = modes.frequency / (2 * np.pi)
    widths = 2 * np.maximum(modes.damping_ratio, LIGHT) * hertz
    inside = (hertz > WHOLE_BAND[0]) & (hertz < WHOLE_BAND[1])
    return choose_segment(records.shortest, float(widths[inside].min()) if inside.any() else None, longest=SEGMENT)


def _findings(
    model: Model, state: StateEntry, records: Records, side: ModelSide, found: Estimate
) -> tuple[Finding, ...]:
    """Return everything that is doubtful about the reference."""
    driven = [w for n, w in zip(side.modes.names, side.modes.frequency, strict=True) if _moves(n, records)]
    out = [*records.findings, *length_findings(records, found, 2 * np.pi / min(driven, default=2 * np.pi / 10))]
    outputs = side.point.outputs
    spectra = response_spectra(channel_response(outputs, side.response), side.response)
    std = statistics(spectra, side.response.excitation.omega, outputs.mean).std
    out += still_findings(records.still, outputs.names, std, outputs.units)
    if np.any(side.waves):
        out += sea_findings(records, side.waves.sum(axis=0), side.hz)
        of_waves, of_wind = (s.sum(axis=0) for s in response_spectrum(side, side.waves, side.wind, side.gradients))
        largest = {u: max(s for s, v in zip(std, outputs.units, strict=True) if v == u) for u in outputs.units}
        size = {n: s / largest[u] for n, s, u in zip(outputs.names, std, outputs.units, strict=True)}
        exact = [n for n, a, b in zip(records.names, of_waves, of_wind, strict=True) if a > 0.2 * b and size[n] > 0.02]
        out += agreement_findings(
            records, side.to_wave[side.main], side.hz, found.segment, model.deck.depth, model.deck.gravity, exact
        )
    return tuple(dict.fromkeys(out))


def _moves(mode: str, records: Records) -> bool:
    channel = {"tower_fa1": "TTDspFA", "tower_ss1": "TTDspSS"}.get(mode, f"Ptfm{mode.capitalize()}")
    return channel in records.names


def _compare_rao(
    model, state, reference, records: Records, side: ModelSide, found: Estimate, nonlinear, progress
) -> Validation:
    """Return the comparison for one long-crested sea: RAOs, and the model driven by the very waves of each record."""
    f, df = found.frequency, found.frequency[1]
    full = [w[:, None] for w in records.waves]
    waves = estimate(records.waves, full, records.step, found.segment).input_spectrum
    smooth, raw = smoothed_rao(side, found, records.step)
    band = (f >= WHOLE_BAND[0] / 3) & np.isfinite(smooth).all(axis=1)
    elsewhere = (side.incoherent - side.incoherent_in_waves).sum(axis=0) * side.step
    std_model = np.sqrt((smooth[band] ** 2 * waves[band, None]).sum(axis=0) * df + elsewhere)
    predicted = [_driven(w, records, side) for w in records.waves]
    linear = estimate(records.cut(records.waves), predicted, records.step, found.segment)
    same_waves = np.hypot(linear.energy_rao, incoherent_rao(side, found, records.step))
    exact = memory = None
    if nonlinear and side.point.system.current is None:
        series, convolved = quadratic_drag(model, side, records, progress)
        cut = [w[: len(s)] for w, s in zip(records.cut(records.waves), series, strict=True)]
        exact = estimate(cut, series, records.step, found.segment)
        memory = None if convolved is None else estimate(cut, convolved, records.step, found.segment)
    nominal, _ = response_spectrum(side, side.waves, side.wind, side.gradients)
    clean, target = np.nan_to_num(smooth), np.nan_to_num(found.energy_rao)

    def whole(magnitude):
        return rao_error(np.nan_to_num(magnitude), target, found.input_spectrum, f)

    empty = np.full(len(records.names), NAN)
    figures = {
        "std_model": std_model, "std_error": std_model / found.std - 1, "std_error_state": _std(nominal, side) / found.std - 1,
        "std_error_hub": empty, "std_error_same_waves": np.sqrt(linear.std**2 + side.incoherent.sum(axis=0) * side.step) / found.std - 1, "std_error_nonlinear": empty if exact is None else exact.std / found.std - 1,
        "std_error_memory": empty if memory is None else memory.std / found.std - 1, "rao_error": whole(smooth),
        "rao_error_same_waves": whole(same_waves), "rao_error_nonlinear": empty if exact is None else whole(exact.energy_rao),
        "rao_error_memory": empty if memory is None else whole(memory.energy_rao), "estimator_error": rao_error(clean, np.nan_to_num(same_waves), found.input_spectrum, f),
        "log_error": log_error(clean, target, found.coherence, f),
        "bands": np.array([rao_error(clean, target, found.input_spectrum, f, b) for b in BANDS]),
    }  # fmt: skip
    own = np.where(band[:, None], clean**2 * waves[:, None], 0.0)
    raw_spectrum = np.nan_to_num(raw) ** 2 * waves[:, None]
    fine = np.abs(side.to_wave[side.main]) ** 2 * np.interp(side.hz, f, waves)[:, None] + side.incoherent
    histories, phases, real = _histories(records, fine, side, predicted)
    channels = _channels(
        model,
        side,
        reference,
        records,
        found,
        figures,
        (target, clean, raw),
        fine,
        phases,
        real,
        side.mean,
        scatter_counts=False,
    )
    lack = lacking(side, records, found, waves=side.waves, wind=None)
    return Validation(
        **_common(state, "waves", reference, records, channels), estimate=found, model_rao=smooth, model_rao_raw=raw, model_phase=phase_at(side, found),
        model_coherence=model_coherence(side, found, records.step), quadratic_rao=None if exact is None else exact.energy_rao, memory_rao=None if memory is None else memory.energy_rao,
        model_spectrum=own, model_spectrum_raw=raw_spectrum, wave_part=own, **_distribution(records), narrowest=_narrowest(side, records),
        findings=_findings(model, state, records, side, found), lack=lack, histories=histories,
        wave_error=_input_error(records.cut(records.waves), side.waves.sum(axis=0), side),
    )  # fmt: skip


def _compare_spectra(
    model, state, reference, records: Records, side: ModelSide, found: Estimate, nonlinear, progress
) -> Validation:
    """Return the comparison for wind and waves: spectra, standard deviations, means; nothing can be driven by the very wind."""
    f = found.frequency
    felt = rotor_wind(side, records, model.deck.elastodyn.structure)
    waves, wind, ratio = (
        own_waves(side, found),
        own_wind(side, records, felt, found.segment),
        hub_ratio(side, records, found.segment),
    )
    of_waves, of_wind = response_spectrum(side, waves, wind, side.gradients)
    spectrum, nominal = of_waves + of_wind, sum(response_spectrum(side, side.waves, side.wind, side.gradients))
    seen = seen_by_record(side.hz, records.shortest)[:, None]
    smooth, raw = smoothed_spectrum(side, spectrum, found, records.step)
    wave_part, _ = smoothed_spectrum(side, of_waves, found, records.step)
    amplitude, target = np.sqrt(np.nan_to_num(smooth)), np.sqrt(found.output_spectrum)
    empty = np.full(len(records.names), NAN)
    at_hub = (
        empty
        if ratio is None
        else _std(sum(response_spectrum(side, waves, side.wind * ratio, side.gradients * ratio)) * seen, side)
    )
    predicted = None if felt is None or len(side.waves) > 1 else [
        _driven(w, records, side) + _cut_driven(u, records, side) for w, u in zip(records.waves, felt, strict=True)
    ]  # fmt: skip
    linear = None if predicted is None else np.sqrt(np.mean([p.var(axis=0) for p in predicted], axis=0) + side.incoherent.sum(axis=0) * side.step)
    std_model = _std(spectrum * seen, side)
    figures = {
        "std_model": std_model, "std_error": std_model / found.std - 1, "std_error_state": _std(nominal * seen, side) / found.std - 1,
        "std_error_hub": at_hub / found.std - 1, "std_error_same_waves": empty if linear is None else linear / found.std - 1,
        **dict.fromkeys(("std_error_nonlinear", "std_error_memory", "rao_error_same_waves", "rao_error_nonlinear", "rao_error_memory"), empty),
        "rao_error": amplitude_error(amplitude, target, f), "estimator_error": np.full(len(empty), 0.5 / np.sqrt(found.averages)),
        "log_error": log_error(amplitude, target, np.ones_like(target), f),
        "bands": np.array([amplitude_error(amplitude, target, f, b) for b in BANDS]),
    }  # fmt: skip
    histories, phases, real = _histories(records, spectrum, side, predicted)
    channels = _channels(model, side, reference, records, found, figures, (target, amplitude, np.sqrt(np.nan_to_num(raw))),
                         spectrum, phases, real, moving_mean(side, records, model.deck.elastodyn.structure), scatter_counts=True)  # fmt: skip
    lack = lacking(side, records, found, waves=waves, wind=wind)
    rao, rao_raw = smoothed_rao(side, found, records.step)
    return Validation(
        **_common(state, "spectra", reference, records, channels), estimate=found, model_rao=rao, model_rao_raw=rao_raw, model_phase=phase_at(side, found), model_spectrum=smooth,
        model_spectrum_raw=raw, wave_part=wave_part, **_distribution(records), narrowest=_narrowest(side, records),
        findings=_findings(model, state, records, side, found), lack=lack, histories=histories, felt_wind=felt is not None,
        wave_error=_input_error(records.cut(records.waves), side.waves.sum(axis=0), side),
        wind_error=NAN if records.wind is None else _input_error(records.cut(records.wind), side.hub * seen[:, 0], side),
        felt_error=NAN if felt is None else _input_error(records.cut(felt), np.where(side.hz < THRUST_TOP, side.wind, 0.0) * seen[:, 0], side),
    )  # fmt: skip


def _means_only(model: Model, state: StateEntry, reference: Reference, records: Records) -> Validation:
    """Return the comparison of means in steady wind and still water."""
    outputs = model.at(state.wind_speed).outputs
    cut = records.cut(records.channels)
    means, std = np.array([c.mean(axis=0) for c in cut]), np.sqrt(np.mean([c.var(axis=0) for c in cut], axis=0))
    at = [outputs.names.index(n) for n in records.names]
    error = relative_mean_error(outputs.mean[at], means.mean(axis=0), std)
    nothing = dict.fromkeys((
        "std_model", "std_error", "std_error_state", "std_error_hub", "std_error_same_waves", "std_error_nonlinear", "std_error_memory", "scatter", "interval",
        "rao_error", "rao_error_same_waves", "rao_error_nonlinear", "rao_error_memory", "estimator_error", "log_error", "coherence_mean",
        "peak_frequency", "peak_frequency_error", "peak_error", "peak_leakage", "extreme_model", "extreme_reference", "excess_kurtosis",
        "correlation", "correlation_same_waves",
    ), NAN)  # fmt: skip
    channels = []
    for k, name in enumerate(records.names):
        tolerance = reference.tolerance_of(name)
        channels.append(ChannelComparison(
            **nothing, name=name, unit=records.units[k], written=records.written[k], std_reference=float(std[k]), mean_model=float(outputs.mean[at[k]]),
            mean_reference=float(means.mean(axis=0)[k]), mean_error=float(error[k]), mean_error_rest=float(error[k]), mean_interval=NAN, band_errors=(NAN,) * len(BANDS), tolerance=tolerance,
            std_verdict=NOT_JUDGED, state_verdict=NOT_JUDGED, mean_verdict=_verdict(error[k], tolerance.mean, 0.0), rao_verdict=NOT_JUDGED,
        ))  # fmt: skip
    return Validation(**_common(state, "mean", reference, records, tuple(channels)), findings=records.findings)


def _common(state, kind: str, reference, records: Records, channels) -> dict:
    return {
        "state": state.name, "kind": kind, "files": records.files, "channels": channels, "tolerance": reference.tolerance,
        "discard": reference.discard, "duration": records.shortest, "step": records.step, "unmatched": records.unmatched, "missing": records.missing,
    }  # fmt: skip


def _std(spectrum: np.ndarray, side: ModelSide) -> np.ndarray:
    """Return standard deviations (c) from spectra (n, c) per Hz."""
    return np.sqrt(spectrum.sum(axis=0) * side.step)


def _input_error(series: Sequence[np.ndarray], spectrum: np.ndarray, side: ModelSide) -> float:
    """Return the standard deviation of a state's wave or wind over that of the records, less one."""
    measured = np.sqrt(np.mean([s.var() for s in series]))
    return float(np.sqrt(spectrum.sum() * side.step) / measured - 1) if measured > 0 else NAN


def _driven(wave: np.ndarray, records: Records, side: ModelSide) -> np.ndarray:
    """Return the linear model's channels (t, c) for a record's own waves after the transient; the record is periodic without its last sample."""
    out = driven_by(wave[:-1], records.step, side.to_wave[side.main], side.hz)
    return np.concatenate([out, out[:1]])[records.start :]


def _cut_driven(wind: np.ndarray, records: Records, side: ModelSide) -> np.ndarray:
    """Return the linear model's channels (t, c) for the rotor's wind of a record after the transient."""
    out = driven_by(wind[:-1], records.step, side.to_wind, side.hz)
    return np.concatenate([out, out[:1]])[records.start :]


def _histories(records: Records, spectrum, side: ModelSide, predicted) -> tuple[Histories, np.ndarray, np.ndarray]:
    """Return histories of the first record, and the correlation coefficients (c) over all records."""
    real, borrowed, from_waves = [], [], []
    for k, y in enumerate(records.cut(records.channels)):
        y = y - y.mean(axis=0)
        own = np.stack(
            [with_phases_of(y[:, c], records.step, spectrum[:, c], side.hz, HIGHEST) for c in range(y.shape[1])], axis=1
        )
        borrowed.append(correlation(own, y))
        from_waves.append(correlation(predicted[k], y) if predicted is not None else np.full(y.shape[1], NAN))
        if k == 0:
            real = [y, own, predicted[0] - predicted[0].mean(axis=0) if predicted is not None else np.full_like(y, NAN)]
    time = (records.start + np.arange(len(real[0]))) * records.step
    return (
        Histories(time=time, reference=real[0], phases=real[1], predicted=real[2]),
        np.mean(borrowed, axis=0),
        np.mean(from_waves, axis=0),
    )


def _distribution(records: Records) -> dict:
    """Return the histograms of the reference's channels about their means, in standard deviations."""
    pooled = np.concatenate([(y - y.mean(axis=0)) / y.std(axis=0) for y in records.cut(records.channels)])
    edges = np.linspace(-5, 5, 51)
    counts = np.stack([np.histogram(c, edges, density=True)[0] for c in pooled.T], axis=1)
    return {"histogram_edges": edges, "histograms": counts}


def _narrowest(side: ModelSide, records: Records) -> float:
    """Return the smallest half-power width [Hz] of a resonance of the channels that move, inside the band of errors."""
    hertz = side.modes.frequency / (2 * np.pi)
    widths = [2 * z * f for n, z, f in zip(side.modes.names, side.modes.damping_ratio, hertz, strict=True)
              if _moves(n, records) and WHOLE_BAND[0] < f < WHOLE_BAND[1]]  # fmt: skip
    return float(min(widths, default=NAN))


def _channels(
    model,
    side,
    reference,
    records,
    found: Estimate,
    figures,
    magnitudes,
    spectrum,
    phases,
    real,
    means,
    *,
    scatter_counts,
) -> tuple[ChannelComparison, ...]:
    """Return all figures of every channel; magnitudes are those of reference, model and model unsmoothed, RAOs or amplitude spectra."""
    f = found.frequency
    target, smooth, raw = magnitudes
    inside = (f >= WHOLE_BAND[0]) & (f <= WHOLE_BAND[1])
    coherence = found.coherence[inside].mean(axis=0)
    cut = [y - y.mean(axis=0) for y in records.cut(records.channels)]
    largest = np.mean([np.abs(y).max(axis=0) for y in cut], axis=0)
    expected = statistics(spectrum / (2 * np.pi), 2 * np.pi * side.hz, side.mean, records.shortest).extreme
    tails = kurtosis(np.concatenate([y / y.std(axis=0) for y in cut]), axis=0)
    mean_rest, mean_error = (relative_mean_error(m, found.mean, found.std) for m in (side.mean, means))
    size = np.maximum(np.abs(found.mean), found.std)
    interval, mean_interval = seed_interval(found.std_each) / found.std, seed_interval(found.mean_each) / size
    out = []
    for k, name in enumerate(records.names):
        near = _resonance(side, target[:, k], f)
        (f_ref,), (h_ref,) = peak(target[:, [k]], f, near)
        (f_model,), (h_model,) = peak(smooth[:, [k]], f, near)
        (_, (h_raw,)) = peak(np.nan_to_num(raw[:, [k]]), f, near)
        tolerance = reference.tolerance_of(name)
        allowed = (
            (float(np.nan_to_num(interval[k])), float(np.nan_to_num(mean_interval[k])))
            if scatter_counts
            else (0.0, 0.0)
        )
        driven = np.isfinite(figures["std_error_same_waves"][k])
        std_verdict = _verdict(figures["std_error"][k], tolerance.std, 0.0 if driven else allowed[0])
        state_verdict = _verdict(figures["std_error_state"][k], tolerance.std if scatter_counts else None, allowed[0])
        out.append(ChannelComparison(
            **{key: float(figures[key][k]) for key in figures if key != "bands"}, name=name, unit=records.units[k], written=records.written[k],
            std_reference=float(found.std[k]), scatter=float(found.scatter[k]), interval=float(interval[k]), mean_model=float(means[k]),
            mean_reference=float(found.mean[k]), mean_error=float(mean_error[k]), mean_error_rest=float(mean_rest[k]), mean_interval=float(mean_interval[k]),
            band_errors=tuple(float(b) for b in figures["bands"][:, k]), coherence_mean=float(coherence[k]), peak_frequency=float(f_ref),
            peak_frequency_error=float(f_model / f_ref - 1), peak_error=float(h_model / h_ref - 1), peak_leakage=float(1 - h_model / h_raw),
            extreme_model=float(expected[k]), extreme_reference=float(largest[k]), excess_kurtosis=float(tails[k]), correlation=float(phases[k]),
            correlation_same_waves=float(real[k]), tolerance=tolerance, std_verdict=std_verdict, state_verdict=state_verdict,
            mean_verdict=_verdict(mean_error[k], tolerance.mean, allowed[1]), rao_verdict=_verdict(figures["rao_error"][k], tolerance.rao, 0.0),
        ))  # fmt: skip
    return tuple(out)


def _verdict(error: float, tolerance: float | None, scatter: float) -> str:
    """Return the verdict on an error: within the tolerance, else within the reference's own 95 % interval, else outside."""
    if tolerance is None:
        return NOT_JUDGED
    return WITHIN if abs(error) <= tolerance else SCATTER if abs(error) <= scatter else OUTSIDE


def _resonance(side: ModelSide, reference: np.ndarray, f: np.ndarray) -> tuple[float, float]:
    """Return the band [Hz] around the natural frequency at which the reference's magnitude of a channel is largest."""
    natural = side.point.modes.frequency / (2 * np.pi)
    natural = natural[(natural > WHOLE_BAND[0]) & (natural < WHOLE_BAND[1])]
    if not len(natural):
        return WHOLE_BAND
    heights = [reference[(f > 0.85 * n) & (f < 1.15 * n)].max(initial=0.0) for n in natural]
    best = natural[int(np.argmax(heights))]
    return 0.75 * best, 1.25 * best


def write_validation(
    found: Sequence[Validation], folder, *, progress: Callable[[str], None] = lambda text: None, **more
) -> list:
    """Write the comparison: report, workbook, figures as PNG and SVG, tables as CSV; return the files written.

    more: model (for report and workbook), decays, figures and extra_sections, as in `fowtio.write.validation.write_comparison`.
    """
    from fowtio.write.validation import write_comparison

    progress("writing the comparison")
    return write_comparison(found, folder, progress=progress, **more)
