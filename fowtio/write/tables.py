"""Results as plain tables in people's units: made once, shown in the terminal, the report and the workbook.

model and loads are those of `fowtio.workflow`: a Model, and a sequence of StateLoads.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fowtio.write.quantities import (
    SEAS,
    WINDS,
    at_rest,
    channel_label,
    dof_label,
    dof_unit,
    has_wind,
    people,
    point_label,
    slug,
    split_spectra,
    tension_channels,
    turbulence_label,
)
from fowtio.write.table import ROW, Column, Table
from model.conventions import PLATFORM_DOFS
from model.response.assemble import all_parts, natural_modes
from model.response.statistics import statistics
from model.system.contributions import Contribution

TONNES, MEGATONNES = 1e-3, 1e-9  # of kg and kg m2: t, 10^6 t m2


def conditions(model) -> Table:
    """Return the sea and wind states."""
    columns = (
        Column(name="State"), Column(name="Wind", unit="m/s"), Column(name="Turbulence"), Column(name="Sea"),
        Column(name="Hs", unit="m"),
        Column(name="Tp", unit="s"), Column(name="Gamma"), Column(name="Heading", unit="deg", decimals=1),
        Column(name="Spreading"),
    )  # fmt: skip
    rows = []
    for state in model.states:
        sea, still = state.sea, state.sea.kind == "still"
        spreading = "–" if still else "long-crested" if sea.spreading is None else f"cos²ˢ, s = {sea.spreading:g}"
        heading = None if still else float(np.degrees(sea.heading))
        rows.append((
            state.name, float(state.wind_speed) or None, turbulence_label(state), SEAS.get(sea.kind, sea.kind),
            sea.significant_height,
            sea.peak_period, sea.gamma, heading, spreading,
        ))  # fmt: skip
    return Table(name="conditions", title="Sea and wind states", columns=columns, rows=tuple(rows))


def summary(loads: Sequence) -> Table:
    """Return the key figures of every state: mean and deviation of the main motions, tower-base moment, tension."""
    wanted = [("PtfmSurge", True), ("PtfmHeave", False), ("PtfmPitch", True), ("TTDspFA", False), ("TwrBsMyt", False)]
    names = loads[0].channels.names
    wanted = [(n, mean) for n, mean in wanted if n in names]
    columns = [Column(name="State")]
    for name, with_mean in wanted:
        unit = people(loads[0].channels.units[names.index(name)])[0]
        label = channel_label(name)
        columns += [Column(name=f"{label}, mean", unit=unit)] if with_mean else []
        columns.append(Column(name=f"{label}, std", unit=unit))
    lines = tension_channels(names)
    columns += [Column(name="Largest expected tension", unit="kN")] if lines else []
    rows = []
    for item in loads:
        row = [item.state.name]
        for name, with_mean in wanted:
            k = names.index(name)
            factor = people(item.channels.units[k])[1]
            row += [float(item.statistics.mean[k]) * factor] if with_mean else []
            row.append(float(item.statistics.std[k]) * factor)
        row += [float((item.statistics.mean + item.statistics.extreme)[lines].max()) * 1e-3] if lines else []
        rows.append(tuple(row))
    return Table(
        name="summary", title="Key figures", columns=tuple(columns), rows=tuple(rows), note=_extremes(loads[0])
    )


def natural_periods(model) -> Table:
    """Return the natural modes of every operating point about its mean offset."""
    columns = (
        Column(name="Operating point"), Column(name="Mode"), Column(name="Period", unit="s"),
        Column(name="Frequency", unit="Hz"),
        Column(name="Damping without drag", unit="%"),
        Column(name="Period with infinite-frequency added mass", unit="s"),
    )  # fmt: skip
    rows = [
        (point_label(p.wind_speed), dof_label(name), _period(w), float(w) / (2 * np.pi), 100 * float(z), _period(high))
        for p in model.points for m in [p.modes]
        for name, w, z, high in zip(m.names, m.frequency, m.damping_ratio, m.frequency_infinite, strict=True)
    ]  # fmt: skip
    note = (
        "Undamped natural periods, with added mass and radiation damping of each mode's own frequency; damping of "
        "radiation, structure and air."
    )
    return Table(name="natural_periods", title="Natural periods", columns=columns, rows=tuple(rows), note=note)


def published_periods(model) -> Table | None:
    """Return the natural periods of the first operating point beside the published ones that the study names, None without any."""
    modes = model.points[0].modes
    own = {n: (2 * np.pi / float(w), 2 * np.pi / float(h)) for n, w, h in zip(modes.names, modes.frequency, modes.frequency_infinite, strict=True)}
    rows = tuple(
        (dof_label(n), period, *(v for p in own[n] for v in (p, 100 * (p / period - 1)))) for n, period in model.case.published if n in own
    )
    columns = (
        Column(name="Mode"), Column(name="Published", unit="s"), Column(name="Period", unit="s"),
        Column(name="Difference", unit="%", decimals=1), Column(name="With infinite-frequency added mass", unit="s"),
        Column(name="Its difference", unit="%", decimals=1),
    )  # fmt: skip
    note = (
        f"{point_label(model.points[0].wind_speed)}. Published periods that come from a linearisation without radiation memory have the "
        "infinite-frequency added mass; those from decay tests that of the mode's own frequency."
    )
    return Table(name="published_periods", title="Natural periods against published ones", columns=columns, rows=rows, note=note) if rows else None


def damping_with_drag(loads: Sequence) -> Table:
    """Return the damping ratios of the natural modes with the drag that was linearised for each state."""
    names = tuple(dict.fromkeys(n for item in loads for n in item.point.modes.names))
    rows = []
    for item in loads:
        modes = natural_modes(item.point.system, item.point.mean, item.response.drag_damping)
        found = dict(zip(modes.names, modes.damping_ratio, strict=True))
        rows.append((item.state.name, *(100 * float(found[n]) if n in found else None for n in names)))
    columns = (Column(name="State"), *(Column(name=dof_label(n), unit="%") for n in names))
    note = "Per cent of critical; the drag is linearised for the motions of each state."
    return Table(
        name="damping_with_drag", title="Damping ratios with drag", columns=columns, rows=tuple(rows), note=note
    )


def mean_offsets(model) -> Table:
    """Return the mean position of every operating point."""
    units = [people(dof_unit(d)) for d in model.points[0].system.dofs]
    columns = [Column(name="Operating point")]
    columns += [Column(name=dof_label(d), unit=u) for d, (u, _) in zip(model.points[0].system.dofs, units, strict=True)]
    rows = [
        (point_label(p.wind_speed), *(float(x) * f for x, (_, f) in zip(p.mean.offset, units, strict=True)))
        for p in model.points
    ]
    return Table(name="mean_offsets", title="Mean offsets", columns=tuple(columns), rows=tuple(rows))


def mooring_tensions(model, loads: Sequence) -> Table | None:
    """Return mean, deviation and expected extremes of every fairlead tension, None without moorings."""
    if model.deck.mooring is None:
        return None
    columns = (
        Column(name="State"), Column(name="Line"), Column(name="Mean", unit="kN"), Column(name="Std", unit="kN"),
        Column(name="Expected max", unit="kN"), Column(name="Expected min", unit="kN"),
        Column(name="Anchor, mean", unit="kN"),
        Column(name="Anchor uplift", unit="deg", decimals=1), Column(name="On seabed", unit="m", decimals=1),
    )  # fmt: skip
    rows = []
    for item in loads:
        state, s = item.point.mean.mooring, item.statistics
        for line, k in enumerate(tension_channels(item.channels.names)):
            rows.append((
                item.state.name, str(model.deck.mooring.line_names[line]),
                *(1e-3 * float(v) for v in (s.mean[k], s.std[k], s.mean[k] + s.extreme[k], s.mean[k] - s.extreme[k])),
                1e-3 * float(state.anchor_tension[line]),
                float(np.degrees(state.anchor_uplift_angle[line])), float(state.grounded_length[line]),
            ))  # fmt: skip
    note = f"Tension at the fairlead; anchor, uplift and length on the seabed at the mean offset. {_extremes(loads[0])}"
    return Table(name="mooring_tensions", title="Mooring tensions", columns=columns, rows=tuple(rows), note=note)


def mooring_lines(model) -> Table | None:
    """Return the mooring lines as the deck defines them, None without moorings."""
    system = model.deck.mooring
    if system is None:
        return None
    columns = (
        Column(name="Line"), Column(name="Length", unit="m"), Column(name="Diameter", unit="mm"),
        Column(name="Mass in air", unit="kg/m"),
        Column(name="EA", unit="MN"), Column(name="Anchor x", unit="m"), Column(name="Anchor y", unit="m"),
        Column(name="Anchor z", unit="m"),
        Column(name="Fairlead x", unit="m"), Column(name="Fairlead y", unit="m"), Column(name="Fairlead z", unit="m"),
    )  # fmt: skip
    rows = [
        (str(name), float(system.length[k]), 1e3 * float(system.diameter[k]), float(system.mass_per_length[k]),
         1e-6 * float(system.axial_stiffness[k]),
         *(float(v) for end in (system.end_a, system.end_b) for v in system.position[end[k]]))
        for k, name in enumerate(system.line_names)
    ]  # fmt: skip
    return Table(
        name="mooring_lines", title="Mooring lines", columns=columns, rows=tuple(rows), note="Platform at zero offset."
    )


def state_statistics(item) -> Table:
    """Return the statistics of every channel of one state, with what waves and wind give where there is turbulence."""
    s, windy = item.statistics, has_wind(item)
    columns = [
        Column(name="Channel"), Column(name="Quantity"), Column(name="Unit"), Column(name="Mean", unit=ROW),
        Column(name="Std", unit=ROW),
        Column(name="Expected max", unit=ROW), Column(name="Expected min", unit=ROW),
        Column(name="Zero-crossing period", unit="s"),
        Column(name="Spectrum peak period", unit="s"),
    ]  # fmt: skip
    columns += [Column(name="Std, waves", unit=ROW), Column(name="Std, wind", unit=ROW)] if windy else []
    omega = item.response.excitation.omega
    parts = [statistics(p, omega, s.mean, s.duration).std for p in split_spectra(item)] if windy else []
    rows = []
    for k, name in enumerate(item.channels.names):
        unit, factor = people(item.channels.units[k])
        mean, std, extreme = (float(v[k]) * factor for v in (s.mean, s.std, s.extreme))
        periods = (
            (None, None) if at_rest(std, unit) else (float(s.zero_crossing_period[k]), _peak(s.peak_period[k], omega))
        )
        rows.append((
            name, channel_label(name), unit, mean, std, mean + extreme, mean - extreme, *periods,
            *(float(p[k]) * factor for p in parts),
        ))  # fmt: skip
    return Table(
        name=f"statistics_{slug(item.state.name)}", title=f"Statistics, {item.state.name}", columns=tuple(columns),
        rows=tuple(rows),
        note=f"{_extremes(item)} No peak period: at rest, or a spectrum that still rises at the lowest frequency.",
    )  # fmt: skip


def matrices(point) -> list[Table]:
    """Return the mass, infinite-frequency added mass, and stiffness of every part and in total, SI units."""
    parts = all_parts(point.system, point.mean)
    added = [p for p in parts if "added mass" in p.name]
    out = [_matrix("Mass without added mass", point.system.mass, point)]
    out += [_matrix("Added mass at infinite frequency", sum(p.mass for p in added), point)] if added else []
    out += [_matrix(f"Stiffness of {p.name}", p.stiffness, point) for p in parts if np.any(p.stiffness)]
    return [
        *out,
        _matrix("Total stiffness", point.mean.stiffness, point),
        _matrix("Damping without radiation and drag", point.system.damping, point),
    ]


def contributions(point) -> Table:
    """Return who contributes what at an operating point: masses, stiffnesses, forces at the mean offset, sums."""
    parts = all_parts(point.system, point.mean)
    rows = [_contribution_row(p, p.force - p.stiffness @ (point.mean.offset - p.point)) for p in parts]
    total = ("Sum", *(sum(r[k] for r in rows) for k in range(1, 10)), "forces balance at the mean offset")
    return Table(
        name=f"contributions_{slug(point_label(point.wind_speed))}",
        title=f"Who contributes what, {point_label(point.wind_speed)}",
        columns=_contribution_columns(), rows=(*rows, total),
        note="About the platform reference point; forces at the mean offset.",
    )  # fmt: skip


def contained(point) -> Table | None:
    """Return what the linearisation of an operating point held beside the turbine, taken out; None without one."""
    if not point.contained:
        return None
    rows = tuple(
        _contribution_row(p, p.force) for p in point.contained if any(np.any(a) for a in (p.mass, p.stiffness, p.force))
    )
    return Table(
        name=f"contained_{slug(point_label(point.wind_speed))}",
        title=f"Held by the linearisation beside the turbine and taken out, {point_label(point.wind_speed)}",
        columns=_contribution_columns(), rows=rows, note="Forces as they act at the linearisation's own point.",
    )  # fmt: skip


def notes(model) -> list[str]:
    """Return what was assumed, of the model and of its options."""
    options = model.case.options
    drag = {
        "relative": "Drag is linearised for the Gaussian relative velocity of water and body, iterated in each state.",
        "third_order": "Drag is linearised for the Gaussian relative velocity of water and body, iterated in each state; what that leaves over "
        "is taken to third order.",
        "body": "Drag is linearised for the body's own velocity; the waves' drag force is left out.",
        "global": "Drag is linearised for one velocity of all strips and one of all end plates; the waves' drag force is left out.",
        "none": "Drag is left out.",
    }[options.drag_model]  # fmt: skip
    low = {
        "hold": "Below the lowest frequency of the coefficients the excitation keeps its lowest value, as in HydroDyn.",
        "hydrostatic": "Below the lowest frequency of the coefficients the excitation goes to its hydrostatic limit.",
    }[options.low_frequency_excitation]
    seen = "as the turning rotor sees it" if options.wind_averaging == "rotor" else "of one point"
    wind = [f"Turbulence: {WINDS[options.wind_spectrum]} spectrum, {seen}."]
    common = [
        "Responses are linear about the mean offset, Gaussian; waves and wind are uncorrelated.",
        drag, low, *(wind if any(s.turbulence is not None for s in model.states) else []),
        "Moorings are quasi-static; their stiffness is exact at the mean offset.",
    ]  # fmt: skip
    return [*common, *(n[0].upper() + n[1:] + ("" if n.endswith(".") else ".") for n in model.notes)]


def _extremes(item) -> str:
    seconds = f"{item.statistics.duration:g} s"
    return f"Expected largest and smallest value of a Gaussian response in {seconds} (Davenport 1964)."


def _period(omega: float) -> float | None:
    """Return a period [s], None for a motion that nothing holds."""
    return 2 * np.pi / float(omega) if omega > 1e-6 else None


def _peak(period: float, omega: np.ndarray) -> float | None:
    """Return a peak period [s], None where the spectrum has its largest value at the lowest frequency."""
    return float(period) if 2 * np.pi / period > 1.0001 * omega[0] else None


def _matrix(title: str, values: np.ndarray, point) -> Table:
    """Return a matrix with rounding, 1e-12 of the largest values in row and column, as zero."""
    dofs = point.system.dofs
    size = np.sqrt(np.abs(values).max(axis=1))
    values = np.where(np.abs(values) > 1e-12 * size[:, None] * size, values, 0.0)
    columns = (Column(name=""), *(Column(name=dof_label(d), scientific=4) for d in dofs))
    rows = tuple((dof_label(d), *(float(v) for v in row)) for d, row in zip(dofs, values, strict=True))
    where = point_label(point.wind_speed)
    return Table(
        name=slug(f"{title}_{where}"),
        title=f"{title}, {where}",
        columns=columns,
        rows=rows,
        note="SI units: kg, m, rad, N.",
    )


def _contribution_columns() -> tuple[Column, ...]:
    named = (
        ("M11", "t"),
        ("M33", "t"),
        ("M55", "10⁶ t m²"),
        ("C11", "kN/m"),
        ("C33", "kN/m"),
        ("C55", "MN m/rad"),
        ("Fx", "kN"),
        ("Fz", "kN"),
        ("My", "MN m"),
    )
    return (Column(name="Contribution"), *(Column(name=n, unit=u) for n, u in named), Column(name="Source"))


def _contribution_row(part: Contribution, force: np.ndarray) -> tuple:
    """Return one part of the equation of motion, with its force (q)."""
    place = {d: part.dofs.index(d) for d in PLATFORM_DOFS if d in part.dofs}

    def of(array, *dofs):
        at = tuple(place.get(d) for d in dofs)
        return 0.0 if None in at else float(array[at])

    return (
        part.name,
        *(of(part.mass, d, d) * f for d, f in (("surge", TONNES), ("heave", TONNES), ("pitch", MEGATONNES))),
        *(of(part.stiffness, d, d) * f for d, f in (("surge", 1e-3), ("heave", 1e-3), ("pitch", 1e-6))),
        *(of(force, d) * f for d, f in (("surge", 1e-3), ("heave", 1e-3), ("pitch", 1e-6))),
        part.source,
    )  # fmt: skip
