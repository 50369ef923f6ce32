"""Comparisons with time series as plain tables in people's units: terminal, report and workbook show the same.

found are `fowtio.validation.Validation`, decays `fowtio.validation_lack.DecayComparison`.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from fowtio.write.provenance import input_table, sha256
from fowtio.write.quantities import channel_label, dof_label, people
from fowtio.write.table import Column, Table
from model.response.measures import BANDS, WHOLE_BAND

VERDICT = "Verdict"
KINDS = {"waves": "RAOs", "spectra": "spectra", "mean": "means"}


def title(item) -> str:
    """Return what a comparison is of, in a few words."""
    return f"{item.state}, {KINDS[item.kind]}"


def overview(found: Sequence, decays: Sequence = ()) -> Table:
    """Return every judged figure of every channel with its verdict: the traffic lights."""
    columns = (
        Column(name="Comparison"), Column(name="Channel"), Column(name=VERDICT), Column(name="σ error", unit="%", decimals=2),
        Column(name="σ allowed", unit="%", decimals=1), Column(name="σ error, state's spectra", unit="%", decimals=2), Column(name="95 % of seeds", unit="±%", decimals=1), Column(name="mean error", unit="%", decimals=2),
        Column(name="mean allowed", unit="%", decimals=1), Column(name="RAO error", unit="%", decimals=2), Column(name="RAO allowed", unit="%", decimals=1),
        Column(name="period error", unit="%", decimals=2), Column(name="period allowed", unit="%", decimals=1),
    )  # fmt: skip
    rows = []
    for item in found:
        for c in item.channels:
            t = c.tolerance
            rows.append((
                title(item), c.name, c.verdict, _percent(c.std_error), _percent(t.std), _percent(c.std_error_state), _percent(c.interval), _percent(c.mean_error) if t.mean else None,
                _percent(t.mean), _percent(c.rao_error), _percent(t.rao), None, None,
            ))  # fmt: skip
    for d in decays:
        rows.append(
            (
                f"decay, {d.wind_speed:g} m/s",
                d.channel,
                "within" if d.passed else "outside",
                *([None] * 8),
                _percent(d.period_error),
                _percent(d.tolerance),
            )
        )
    note = (
        "Model over reference less one; σ in the reference's own waves (and wind that its rotor felt). Within: inside the tolerance of the study; "
        "within scatter: outside, but inside the 95 % interval of the reference's own seeds; not judged: the study names no tolerance."
    )
    return Table(name="overview", title="Every judged figure", columns=columns, rows=tuple(rows), note=note)


def wave_channels(item) -> tuple[Table, Table]:
    """Return the figures of a comparison of RAOs: standard deviations, and RAOs."""
    columns = (
        Column(name="Channel"), Column(name="Unit"), Column(name="σ model", decimals=4), Column(name="σ reference", decimals=4),
        *(Column(name=n, unit="%", decimals=2) for n in ("σ error", "same waves", "quadratic drag", "and memory")),
        Column(name="seed scatter", unit="%", decimals=1), Column(name="state's spectrum", unit="%", decimals=2), Column(name=VERDICT),
    )  # fmt: skip
    rows = []
    for c in item.channels:
        unit, factor = people(c.unit)
        rows.append((c.name, unit, c.std_model * factor, c.std_reference * factor, *map(_percent, (
            c.std_error, c.std_error_same_waves, c.std_error_nonlinear, c.std_error_memory, c.scatter, c.std_error_state)), c.verdict))  # fmt: skip
    note = (
        "σ error: model in the reference's wave spectrum; same waves: driven by the reference's wave records; quadratic drag: likewise, with the drag force "
        "itself; and memory: with the radiation memory as HydroDyn convolves it too; state's spectrum: nothing taken from the records. "
        "Definitions in docs/validation.md."
    )
    heading = f"State {item.state}: model against {len(item.files)} time series"
    first = Table(name="validation", title=heading, columns=columns, rows=tuple(rows), note=note)
    columns = (
        Column(name="Channel"), *(Column(name=n, unit="%", decimals=2) for n in ("RAO error", "same waves", "quadratic drag", "and memory", "estimator")),
        Column(name="peak", unit="Hz", decimals=4), Column(name="peak shift", unit="%", decimals=2), Column(name="peak height", unit="%", decimals=1),
        Column(name="coherence", decimals=2),
    )  # fmt: skip
    rows = tuple(
        (c.name, *map(_percent, (c.rao_error, c.rao_error_same_waves, c.rao_error_nonlinear, c.rao_error_memory, c.estimator_error)), c.peak_frequency,
         _percent(c.peak_frequency_error), _percent(c.peak_error), c.coherence_mean) for c in item.channels
    )  # fmt: skip
    note = "Estimator: RAO error of the model's own RAO when it is estimated from its response to the same waves, what chance leaves."
    return first, Table(name="validation_rao", title=f"State {item.state}: RAOs", columns=columns, rows=rows, note=note)


def wind_channels(item) -> tuple[Table, Table]:
    """Return the figures of a comparison of spectra: standard deviations and spectra, and means and extremes."""
    columns = (
        Column(name="Channel"), Column(name="Unit"), Column(name="σ model", decimals=4), Column(name="σ reference", decimals=4),
        *(Column(name=n, unit="%", decimals=2) for n in ("σ error", "state's spectra", "hub's wind", "same waves and wind")),
        Column(name="95 % of seeds", unit="±%", decimals=1), Column(name="spectrum error", unit="%", decimals=1), Column(name="correlation", decimals=3),
        Column(name=VERDICT),
    )  # fmt: skip
    first, second = [], []
    for c in item.channels:
        unit, factor = people(c.unit)
        first.append((c.name, unit, c.std_model * factor, c.std_reference * factor, *map(_percent, (
            c.std_error, c.std_error_state, c.std_error_hub, c.std_error_same_waves, c.interval, c.rao_error)), c.correlation_same_waves, c.verdict))  # fmt: skip
        second.append((c.name, unit, c.mean_model * factor, c.mean_reference * factor, *map(_percent, (c.mean_error, c.mean_error_rest, c.mean_interval)),
                       c.extreme_model * factor, c.extreme_reference * factor, c.excess_kurtosis))  # fmt: skip
    own = "the wind that the reference's rotor felt (from its thrust)" if item.felt_wind else "the state's wind"
    note = (
        f"σ error: in the reference's waves and {own}; state's spectra: nothing taken from the records; hub's wind: the state's wind scaled to the reference's "
        "spectrum at the hub; same waves and wind: driven by both as time series, without gradients and blade passing; correlation: of that prediction "
        "with the reference. 95 % of seeds: half width of the reference's own interval (Student's t)."
    )
    heading = f"State {item.state}: model against {len(item.files)} time series"
    one = Table(name="validation", title=heading, columns=columns, rows=tuple(first), note=note)
    columns = (
        Column(name="Channel"), Column(name="Unit"), Column(name="mean model", decimals=4), Column(name="mean reference", decimals=4),
        Column(name="mean error", unit="%", decimals=2), Column(name="at rest", unit="%", decimals=2), Column(name="95 % of seeds", unit="±%", decimals=1),
        Column(name="largest, model", decimals=3), Column(name="largest, reference", decimals=3), Column(name="excess kurtosis", decimals=2),
    )  # fmt: skip
    note = (
        f"Mean error: with the moorings' mean force while the floater moves{' and the mean thrust of the records' if item.felt_wind else ''}; at rest: the mean "
        "position of the model without. Largest: deviation from the mean in a record, expected by the model and found."
    )
    return one, Table(
        name="validation_means",
        title=f"State {item.state}: means and extremes",
        columns=columns,
        rows=tuple(second),
        note=note,
    )


def mean_channels(item) -> Table:
    """Return the figures of a comparison of means alone."""
    columns = (Column(name="Channel"), Column(name="Unit"), Column(name="mean model", decimals=4), Column(name="mean reference", decimals=4),
               Column(name="mean error", unit="%", decimals=2), Column(name=VERDICT))  # fmt: skip
    rows = []
    for c in item.channels:
        unit, factor = people(c.unit)
        rows.append((c.name, unit, c.mean_model * factor, c.mean_reference * factor, _percent(c.mean_error), c.verdict))
    note = "Error over the reference's mean, or over its standard deviation where that is larger."
    return Table(
        name="validation",
        title=f"State {item.state}: means in steady wind and still water",
        columns=columns,
        rows=tuple(rows),
        note=note,
    )


def channels(item) -> tuple[Table, ...]:
    """Return the figures of every channel of a comparison, one table or two."""
    return {"waves": wave_channels, "spectra": wind_channels, "mean": lambda i: (mean_channels(i),)}[item.kind](item)


def bands(item) -> Table:
    """Return the errors band by band, the logarithmic error and what the window does to the peaks."""
    columns = (
        Column(name="Channel"), *(Column(name=f"{a:g} to {b:g} Hz", unit="%", decimals=2) for a, b in (WHOLE_BAND, *BANDS)),
        Column(name="logarithmic", unit="%", decimals=1), Column(name="peak lowered by the window", unit="%", decimals=1),
        Column(name="correlation, reference's phases", decimals=3), Column(name="correlation, same waves", decimals=3),
    )  # fmt: skip
    rows = tuple(
        (
            c.name,
            _percent(c.rao_error),
            *map(_percent, c.band_errors),
            _percent(c.log_error),
            _percent(c.peak_leakage),
            c.correlation,
            c.correlation_same_waves,
        )
        for c in item.channels
    )
    note = "Amplitude errors weighted by the reference's energy; logarithmic: root mean square of ln(model/reference) weighted by coherence."
    return Table(name="bands", title=f"State {item.state}: errors by band", columns=columns, rows=rows, note=note)


def lack(item) -> Table | None:
    """Return the damping and stiffness that would make the linear model fit best, None without."""
    if item.lack is None:
        return None
    columns = (
        Column(name="Motion"), Column(name="Natural frequency", unit="Hz", decimals=5), Column(name="Damping ratio", unit="%", decimals=2),
        Column(name="Damping to add", unit="% of critical", decimals=3), Column(name="standard error", unit="%", decimals=3), Column(name="of the model's", unit="%", decimals=1),
        Column(name="Stiffness to add", unit="%", decimals=2), Column(name="its standard error", unit="%", decimals=2),
        Column(name="Error before", unit="%", decimals=2), Column(name="after", unit="%", decimals=2),
        Column(name="Damping to add, SI", scientific=3), Column(name="Stiffness to add, SI", scientific=3),
    )  # fmt: skip
    found, m, rows = item.lack, item.lack.terms, []
    for k, dof in enumerate(m.dofs):
        ratio, restoring, critical = found.damping_ratio[k], found.restoring[k], found.critical[k]
        added = m.damping[k] / critical
        rows.append((
            dof_label(dof), float(found.frequency[k]), 100 * ratio, 100 * added, 100 * m.damping_error[k] / critical, 100 * added / ratio,
            100 * m.stiffness[k] / restoring, 100 * m.stiffness_error[k] / restoring, _percent(m.error_before[k]), _percent(m.error_after[k]),
            float(m.damping[k]), float(m.stiffness[k]),
        ))  # fmt: skip
    note = (
        "Linear terms on each motion's own diagonal that bring the model's smoothed spectra closest to the reference's (least squares of amplitudes, "
        "all motions at once), with standard errors. Damping that is missing is positive; a negative value says that the model damps too much."
    )
    return Table(
        name="lack",
        title=f"State {item.state}: what the linear model lacks",
        columns=columns,
        rows=tuple(rows),
        note=note,
    )


def decay_table(decays: Sequence) -> Table | None:
    """Return the decay tests beside the model, None without."""
    if not decays:
        return None
    columns = (
        Column(name="Channel"), Column(name="Unit"), Column(name="from", decimals=3), Column(name="Period, reference", unit="s", decimals=3),
        Column(name="Period, model", unit="s", decimals=3), Column(name="error", unit="%", decimals=2), Column(name="Linear, reference", unit="%", decimals=3),
        Column(name="Linear, model", unit="%", decimals=3), Column(name="Quadratic, reference", unit="% per unit", decimals=4),
        Column(name="Quadratic, model", unit="% per unit", decimals=4), Column(name="Damping at half amplitude, error", unit="%", decimals=1),
        Column(name="left by the fit", unit="%", decimals=3), Column(name=VERDICT),
    )  # fmt: skip
    rows = []
    for d in decays:
        unit, factor = people(d.unit)
        rows.append((
            d.channel, unit, abs(d.found.start) * factor, d.found.period, float(d.model.period[0]), _percent(d.period_error), 100 * d.found.linear, 100 * d.model_linear,
            100 * d.found.quadratic / factor, 100 * d.model_quadratic / factor, _percent(d.damping_error), 100 * d.found.residual, "within" if d.passed else "outside",
        ))  # fmt: skip
    note = "Damping ratio = linear + quadratic × amplitude. The model's quadratic part is its drag, linearised for harmonic motion in the mode's shape."
    return Table(name="decays", title="Decay tests", columns=columns, rows=tuple(rows), note=note)


def findings(found: Sequence, decays: Sequence = ()) -> Table | None:
    """Return what is doubtful about the references, None when nothing is."""
    rows = [(title(i), f.severity, f.subject, f.text) for i in found for f in i.findings]
    rows += [(f"decay {d.channel}", f.severity, f.subject, f.text) for d in decays for f in d.findings]
    columns = (Column(name="Comparison"), Column(name="Kind"), Column(name="Where"), Column(name="What"))
    return (
        Table(name="findings", title="Doubts about the reference", columns=columns, rows=tuple(rows)) if rows else None
    )


def mapping(item) -> Table:
    """Return which channel of the files was taken for which, and those without a counterpart."""
    rows = [(c.name, channel_label(c.name), c.written, c.unit) for c in item.channels]
    note = f"Channels of the files without a counterpart, or at rest: {', '.join(item.unmatched) or 'none'}."
    if item.missing:
        note += f" Channels of the model that the files lack: {', '.join(item.missing)}."
    columns = (Column(name="Channel"), Column(name="Meaning"), Column(name="In the files"), Column(name="Unit, SI"))
    return Table(name="mapping", title=f"State {item.state}: channels", columns=columns, rows=tuple(rows), note=note)


def settings(found: Sequence) -> Table:
    """Return how the spectra of every comparison were estimated, and how the inputs compare."""
    columns = (
        Column(name="Comparison"), Column(name="Records", decimals=0), Column(name="Length each", unit="s", decimals=0), Column(name="Discarded", unit="s", decimals=0),
        Column(name="Step", unit="s", decimals=3), Column(name="Segments", unit="s", decimals=0), Column(name="Independent averages", decimals=1),
        Column(name="Degrees of freedom", decimals=0), Column(name="Window's width", unit="Hz", decimals=5), Column(name="Narrowest peak", unit="Hz", decimals=5),
        Column(name="Waves, state over records", unit="%", decimals=1), Column(name="Hub wind, state over records", unit="%", decimals=1),
        Column(name="Rotor wind, state over records", unit="%", decimals=1),
    )  # fmt: skip
    rows = []
    for i in found:
        e = i.estimate
        rows.append((
            title(i), float(len(i.files)), i.duration, i.discard, i.step, *((None,) * 5 if e is None else (
                e.segment, e.averages, e.degrees_of_freedom, 1.44 / e.segment, i.narrowest)), *map(_percent, (i.wave_error, i.wind_error, i.felt_error)),
        ))  # fmt: skip
    note = (
        "Welch's method, Hann window, half overlap. Widths at half power. A peak narrower than the window is lowered by it in model and reference alike, since the "
        "model is seen through the same window; docs/validation.md."
    )
    return Table(name="settings", title="How it was measured", columns=columns, rows=tuple(rows), note=note)


def files(model, found: Sequence, decays: Sequence = ()) -> Table:
    """Return every input file of the study and every time series, with size and SHA-256."""
    table = input_table(model)
    root = Path(os.path.abspath(model.case.path)).parent
    known = {row[0] for row in table.rows}
    rows = []
    for f in dict.fromkeys([f for i in found for f in i.files] + [d.file for d in decays]):
        name = _relative(Path(f), root)
        if name not in known and Path(f).is_file():
            rows.append((name, float(Path(f).stat().st_size), sha256(Path(f))))
    return Table(name=table.name, title=table.title, columns=table.columns, rows=(*table.rows, *rows), note=table.note)


def spectra_numbers(item) -> tuple[list[str], np.ndarray, list[str]]:
    """Return headings, values and number formats of the estimate beside the model: per channel reference, bounds, model, coherence."""
    f = item.estimate.frequency
    top = 0.2 if item.kind == "waves" else 0.5 / item.step
    inside = (f > 0.5 / item.estimate.segment) & (f <= top)
    headings, values = ["Frequency [Hz]"], [f[inside]]
    low, high = item.estimate.energy_bounds() if item.kind == "waves" else (None, None)
    for k, c in enumerate(item.channels):
        unit, factor = people(c.unit)
        if item.kind == "waves":
            parts = [("|H|₂", item.estimate.energy_rao, 1), ("low", low, 1), ("high", high, 1), ("|H₁|", np.abs(item.estimate.coherent_rao), 1),
                     ("model", item.model_rao, 1), ("model unsmoothed", item.model_rao_raw, 1), ("quadratic drag", item.quadratic_rao, 1)]  # fmt: skip
            per = f"{unit}/m"
        else:
            parts = [
                ("reference", item.estimate.output_spectrum, 2),
                ("model", item.model_spectrum, 2),
                ("model, waves alone", item.wave_part, 2),
            ]
            per = f"({unit})²/Hz"
        for label, array, power in parts:
            if array is not None:
                headings.append(f"{c.name} {label} [{per}]")
                values.append(array[inside, k] * factor**power)
        headings.append(f"{c.name} coherence with waves")
        values.append(item.estimate.coherence[inside, k])
    return headings, np.stack(values, axis=1), ["0.0000", *["0.0000E+00"] * (len(headings) - 1)]


def _percent(value) -> float | None:
    return None if value is None or not np.isfinite(value) else 100 * float(value)


def _relative(path: Path, root: Path) -> str:
    try:
        return Path(os.path.relpath(os.path.abspath(path), root)).as_posix()
    except ValueError:
        return path.name
