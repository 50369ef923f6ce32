"""The report of a lifetime: damage around the tower and in the moorings, ultimate loads, the check by rainflow."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib import cm
from matplotlib.colors import LogNorm, Normalize

from fowtio.write.document import bullet_list, write_document
from fowtio.write.quantities import people
from fowtio.write.report import Card, Section
from fowtio.write.style import AMBER, BLUE, GREY, INK, ORANGE, Drawing, grid, legend
from fowtio.write.table import ROW, Column, Table
from model.environment.contours import HOURS_PER_YEAR


def write_fatigue(
    study, folder: str | Path, *, figures: bool = True, progress: Callable[[str], None] = lambda text: None
) -> list[Path]:
    """Write report, workbook and figures of a FatigueStudy into a folder and return the files."""
    tower, lines, ultimate, check = tower_table(study), line_table(study), ultimate_table(study), check_table(study)
    states, by_speed = state_table(study), speed_table(study)
    basis = basis_table(study)

    def sections(pictures):
        at = lambda *names: tuple(pictures[n] for n in names if n in pictures)  # noqa: E731
        return [
            Section(title="Basis", content=(basis, bullet_list(study.notes))),
            Section(
                title="Fatigue of the tower base",
                content=(*at("damage_around"), by_speed, *at("damage_by_state")),
                fold=(tower,),
            ),
            Section(title="Fatigue of the moorings", content=(lines,) if lines else ()),
            Section(title="Check by rainflow counting", content=(check, *at("rainflow")) if check else ()),
            Section(title="Ultimate loads", content=(ultimate, *at("ultimate"))),
            Section(title="States", content=at("states"), fold=(states,)),
        ]

    sheets = [
        ("Basis", [basis]),
        ("Tower", [tower]),
        ("By wind speed", [by_speed]),
        ("Ultimate loads", [ultimate]),
        ("States", [states]),
    ]
    sheets += [("Moorings", [lines])] if lines else []
    sheets += [("Rainflow", [check])] if check else []
    case = study.loads.model.case
    return write_document(
        folder,
        name="fatigue",
        kind="Fatigue and ultimate loads over a lifetime",
        title=f"{case.title or case.path.stem} · {study.site.title}",
        origin=f"Study {case.path.name}, site {study.site.path.name}",
        cards=cards(study),
        drawings=lambda: drawings(study),
        sections=sections,
        sheets=sheets,
        figures=figures,
        progress=progress,
    )


def cards(study) -> list[Card]:
    """Return the key numbers."""
    worst, factor = study.worst, study.settings.design_factor
    out = [
        Card(
            label="Tower base, damage",
            value=f"{study.tower.total[worst]:.3g}",
            note=f"in {study.tower.years:g} years, without the design factor of {factor:g}",
        ),
        Card(
            label="Fatigue life",
            value=f"{study.tower.life[worst] / factor:.3g} years",
            note=f"design factor {factor:g} included",
        ),
        Card(
            label="Damage-equivalent stress range",
            value=f"{study.tower.equivalent[worst] / 1e6:.1f} MPa",
            note=f"{study.tower.cycles:.0e} cycles, m = {study.tower.power:g}",
        ),
    ]
    k = study.loads.index("TwrBsMyt")
    out.append(
        Card(
            label="Tower-base moment",
            value=f"{study.ultimate.long_term[k] / 1e6:.1f} MN m",
            note=f"once in {study.ultimate.return_period:g} years, all states",
        )
    )
    if study.lines is not None:
        out.append(
            Card(label="Moorings, largest damage", value=f"{study.lines.total.max():.3g}", note=study.line_curve.name)
        )
    return out


def basis_table(study) -> Table:
    """Return what the fatigue is reckoned with."""
    rows = [
        ("S–N curve", study.curve.name),
        (
            "Slopes",
            f"{study.curve.slope:g}"
            + (f", {study.curve.second_slope:g} below {study.curve.knee / 1e6:.1f} MPa" if study.curve.knee else ""),
        ),
        (
            "Section",
            f"{study.section.diameter:.3f} m by {1e3 * study.section.thickness:.1f} mm, modulus {study.section.modulus:.3f} m³",
        ),
        ("Factor on stress", f"{study.factor:.3f}: concentration and thickness"),
        ("Cycles", study.settings.method.replace("_", " ")),
        ("States", f"{len(study.loads.table)}, {100 * study.loads.table.probability.sum():.2f} % of the time"),
        ("Operating points", ", ".join(f"{p.wind_speed:g}" for p in study.loads.model.points) + " m/s"),
    ]
    return Table(name="basis", title="Basis", columns=(Column(name="Quantity"), Column(name="Value")), rows=tuple(rows))


def tower_table(study) -> Table:
    """Return the damage at every point of the section."""
    columns = (
        Column(name="Angle", unit="deg", decimals=0),
        Column(name="Damage", scientific=3),
        Column(name="Life", unit="years", decimals=1),
        Column(name="Equivalent stress range", unit="MPa", decimals=2),
    )
    rows = tuple(
        (float(a), float(d), float(life), float(e / 1e6))
        for a, d, life, e in zip(
            np.degrees(study.angles), study.tower.total, study.tower.life, study.tower.equivalent, strict=True
        )
    )
    note = f"Angles from downwind, counter-clockwise seen from above. Damage in {study.tower.years:g} years without design factor."
    return Table(name="tower_damage", title="Damage around the tower base", columns=columns, rows=rows, note=note)


def line_table(study) -> Table | None:
    """Return the damage of the mooring lines at their fairleads."""
    if study.lines is None:
        return None
    columns = (
        Column(name="Line"),
        Column(name="Nominal diameter", unit="mm", decimals=0),
        Column(name="Damage", scientific=3),
        Column(name="Life", unit="years", decimals=1),
        Column(name="Equivalent stress range", unit="MPa", decimals=2),
    )
    names = [n for n in study.loads.channels if n.startswith("T[")]
    rows = tuple(
        (n, float(1e3 * d), float(t), float(life), float(e / 1e6))
        for n, d, t, life, e in zip(
            names, study.line_diameter, study.lines.total, study.lines.life, study.lines.equivalent, strict=True
        )
    )
    note = f"{study.line_curve.name}; quasi-static tension at the fairlead on the nominal area, the diameter from the mass per length."
    return Table(name="line_damage", title="Damage of the mooring lines", columns=columns, rows=rows, note=note)


def speed_table(study) -> Table:
    """Return the share of every operating point in time and damage."""
    speeds = study.loads.point_speed
    columns = (
        Column(name="Operating point"),
        Column(name="Hours per year", decimals=1),
        Column(name="Damage", scientific=3),
        Column(name="Share of damage", unit="%", decimals=1),
        Column(name="σ of fore-aft moment", unit="MN m", decimals=2),
    )
    k, rows = study.loads.index("TwrBsMyt"), []
    part = study.tower.by_state[:, study.worst]
    p = study.loads.table.probability
    for speed in np.unique(speeds):
        here = speeds == speed
        std = np.sqrt(np.average(study.loads.std[here, k] ** 2, weights=p[here] + 1e-300))
        label = "parked" if speed == 0 else f"{speed:g} m/s"
        rows.append(
            (
                label,
                float(p[here].sum() * HOURS_PER_YEAR),
                float(part[here].sum()),
                float(100 * part[here].sum() / max(part.sum(), 1e-300)),
                std * 1e-6,
            )
        )
    return Table(name="damage_by_speed", title="Where the damage comes from", columns=columns, rows=tuple(rows))


def state_table(study) -> Table:
    """Return all states with their probability and damage."""
    t, k = study.loads.table, study.loads.index("TwrBsMyt")
    columns = (
        Column(name="Wind speed", unit="m/s", decimals=2),
        Column(name="Hs", unit="m", decimals=2),
        Column(name="Tp", unit="s", decimals=2),
        Column(name="Turbine"),
        Column(name="Hours per year", decimals=2),
        Column(name="Mean moment", unit="MN m", decimals=2),
        Column(name="σ of moment", unit="MN m", decimals=2),
        Column(name="Damage", scientific=3),
    )
    rows = tuple(
        (
            float(t.wind_speed[i]),
            float(t.significant_height[i]),
            float(t.peak_period[i]),
            "runs" if t.operating[i] else "parked",
            float(t.hours_per_year[i]),
            float(study.loads.mean[i, k] / 1e6),
            float(study.loads.std[i, k] / 1e6),
            float(study.tower.by_state[i, study.worst]),
        )
        for i in range(len(t))
    )
    return Table(
        name="states", title="States", columns=columns, rows=rows, note="Damage at the worst point of the tower base."
    )


def ultimate_table(study) -> Table:
    """Return the ultimate loads of all channels."""
    u, t = study.ultimate, study.loads.table
    years = f"{u.return_period:g} years"
    columns = (
        Column(name="Channel"),
        Column(name="Unit"),
        Column(name="|μ| + σ", unit=ROW),
        Column(name="Expected largest", unit=ROW),
        Column(name="90 % fractile", unit=ROW),
        Column(name="Governing state"),
        Column(name=f"Once in {years}, all states", unit=ROW),
        Column(name=f"Contour of {years}", unit=ROW),
        Column(name="Contour, 90 %", unit=ROW),
        Column(name="State of the contour"),
    )
    rows = []
    for k, name in enumerate(u.channels):
        unit, factor = people(u.units[k])
        values = [float(v[k] * factor) for v in (u.objective, u.expected, u.fractile)]
        later = [float(v[k] * factor) for v in (u.long_term, u.contour, u.contour_fractile)]
        rows.append(
            (
                name,
                unit,
                *values,
                _state_text(t, int(u.governing[k])),
                *later,
                _state_text(u.contour_table, int(u.contour_state[k])),
            )
        )
    note = "Largest in a state's duration, with the sign of the mean; without safety factors (IEC 61400-3: 1.35 on normal design situations)."
    return Table(name="ultimate", title="Ultimate loads", columns=columns, rows=tuple(rows), note=note)


def check_table(study) -> Table | None:
    """Return damage-equivalent ranges by Dirlik's formula and by rainflow counting."""
    c = study.check
    if c is None:
        return None
    columns = [
        Column(name="Wind speed", unit="m/s", decimals=1),
        Column(name="Hs", unit="m", decimals=2),
        Column(name="Tp", unit="s", decimals=2),
    ]
    for m in c.slopes:
        columns += [
            Column(name=f"Spectral, m = {m:g}", unit="MPa", decimals=2),
            Column(name="Rainflow", unit="MPa", decimals=2),
            Column(name="error", unit="%", decimals=1),
        ]
    t, rows = study.loads.table, []
    for k, state in enumerate(c.states):
        row = [float(t.wind_speed[state]), float(t.significant_height[state]), float(t.peak_period[state])]
        for j in range(len(c.slopes)):
            row += [float(c.spectral[k, j] / 1e6), float(c.counted[k, j] / 1e6), float(100 * c.error[k, j])]
        rows.append(tuple(row))
    note = f"Equivalent ranges at 1 Hz at the worst point, of the states that do most damage; {c.hours} synthesised hours each."
    return Table(
        name="rainflow",
        title="Spectral method against rainflow counting",
        columns=tuple(columns),
        rows=tuple(rows),
        note=note,
    )


def _state_text(table, k: int) -> str:
    text = f"{table.wind_speed[k]:.1f} m/s, {table.significant_height[k]:.2f} m, {table.peak_period[k]:.1f} s"
    return text if table.operating[k] else f"parked, {text}"


def drawings(study) -> list[Drawing]:
    """Return all figures of a lifetime."""
    out = [around(study), by_state(study), ultimate(study), scatter(study)]
    return [*out, rainflow(study)] if study.check is not None else out


def around(study) -> Drawing:
    """Return the damage around the tower, seen from above, and by wind speed."""
    figure, axes = grid(1, 2, width=9.5, height=3.0, top=0.5, between=0.9)
    left = axes[0, 0]
    place = left.get_position()
    left.remove()
    ax = figure.add_axes([place.x0 - 0.02, place.y0 - 0.02, place.width, place.height * 1.0], projection="polar")
    angle = np.append(study.angles, study.angles[:1])
    ax.plot(angle, np.append(study.tower.total, study.tower.total[:1]), color=BLUE)
    ax.fill(angle, np.append(study.tower.total, study.tower.total[:1]), color=BLUE, alpha=0.15)
    ax.plot(study.angles[study.worst], study.tower.total[study.worst], color=ORANGE, marker="o", ms=5)
    ax.set_xticks(np.radians([0, 90, 180, 270]))
    ax.set_xticklabels(["downwind", "90°", "upwind", "270°"])
    ax.set_rlabel_position(45)
    ax.tick_params(labelsize=8)
    ax.tick_params(axis="x", pad=6)
    for label, side in zip(ax.get_xticklabels(), ("left", "center", "right", "center"), strict=True):
        label.set_horizontalalignment(side)
    ax.set_title(f"Damage in {study.tower.years:g} years", pad=14)
    bars = axes[0, 1]
    table = speed_table(study)
    labels, share = table.column("Operating point"), table.column("Share of damage")
    time = 100 * np.array(table.column("Hours per year")) / HOURS_PER_YEAR
    x = np.arange(len(labels))
    handles = [bars.bar(x - 0.2, share, 0.4, color=BLUE, lw=0), bars.bar(x + 0.2, time, 0.4, color=GREY, lw=0)]
    bars.set_xticks(x)
    bars.set_xticklabels([t.removesuffix(" m/s") for t in labels])
    bars.set_xlabel("Operating point [m/s]")
    bars.set_ylabel("%")
    bars.grid(axis="x", visible=False)
    bars.legend(handles, ["of the damage", "of the time"], loc="upper right")
    bars.set_title("Where the damage at the worst point comes from")
    caption = (
        "Fatigue damage around the tower base seen from above, without design factor, and its share by operating point."
    )
    return Drawing(
        name="damage_around", group="fatigue", title="Damage around the tower base", caption=caption, figure=figure
    )


def by_state(study) -> Drawing:
    """Return the damage over Hs and Tp, and over wind speed and Hs."""
    t, part = study.loads.table, study.tower.by_state[:, study.worst]
    shown = part > part.max() * 1e-5
    norm = LogNorm(part.max() * 1e-4, part.max())
    figure, axes = grid(1, 2, width=9.5, height=2.7, top=0.4, between=0.75)
    for ax, (x, y, name_x, name_y) in zip(
        axes[0],
        (
            (t.peak_period, t.significant_height, "Tp [s]", "Hs [m]"),
            (t.wind_speed, t.significant_height, "Wind speed at the hub [m/s]", "Hs [m]"),
        ),
        strict=True,
    ):
        ax.scatter(x[shown], y[shown], s=14, c=np.maximum(part[shown], norm.vmin), norm=norm, cmap="viridis", lw=0)
        ax.set_xlabel(name_x)
        ax.set_ylabel(name_y)
        ax.set_xlim(left=0)
        ax.set_ylim(bottom=0)
    left, bottom, wide, high = axes[0, 1].get_position().bounds
    axes[0, 1].set_position([left, bottom, wide - 0.09, high])
    bar = figure.colorbar(
        cm.ScalarMappable(norm=norm, cmap="viridis"), cax=figure.add_axes([left + wide - 0.07, bottom, 0.014, high])
    )
    bar.set_label(f"Damage in {study.tower.years:g} years")
    bar.outline.set_visible(False)
    caption = "Damage of every state at the worst point of the tower base."
    return Drawing(name="damage_by_state", group="fatigue", title="Damage by state", caption=caption, figure=figure)


def ultimate(study) -> Drawing:
    """Return the ultimate loads relative to the long-term value."""
    u = study.ultimate
    wanted = [
        k
        for k, n in enumerate(u.channels)
        if n in ("PtfmSurge", "PtfmPitch", "NcIMUTAxs", "TwrBsFxt", "TwrBsMyt") or n.startswith("T[")
    ]
    figure, axes = grid(1, 1, width=9.0, height=2.6, top=0.55)
    ax, x = axes[0, 0], np.arange(len(wanted))
    series = (
        ("|μ| + σ", u.objective, GREY),
        ("expected largest, all states", u.expected, BLUE),
        ("contour, expected", u.contour, AMBER),
        ("contour, 90 %", u.contour_fractile, ORANGE),
    )
    handles = []
    for j, (_, values, colour) in enumerate(series):
        handles.append(
            ax.bar(x + 0.2 * (j - 1.5), [values[k] / u.long_term[k] for k in wanted], 0.19, color=colour, lw=0)
        )
    handles.append(ax.axhline(1.0, color=INK, lw=1.0))
    ax.set_xticks(x)
    ax.set_xticklabels([u.channels[k] for k in wanted])
    ax.set_ylabel("over the long-term value")
    ax.grid(axis="x", visible=False)
    legend(figure, handles, [s[0] for s in series] + [f"once in {u.return_period:g} years over all states"])
    caption = f"Ultimate loads in several senses over the value that is exceeded once in {u.return_period:g} years over all states."
    return Drawing(name="ultimate", group="ultimate", title="Ultimate loads", caption=caption, figure=figure)


def scatter(study) -> Drawing:
    """Return the states with their probability."""
    t = study.loads.table
    figure, axes = grid(1, 2, width=9.5, height=2.5, top=0.4, between=0.75)
    size = 3 + 160 * t.probability / t.probability.max()
    speeds = Normalize(0, max(float(t.wind_speed.max()), 1.0))
    axes[0, 0].scatter(
        t.peak_period, t.significant_height, s=size, c=t.wind_speed, norm=speeds, cmap="viridis", lw=0, alpha=0.8
    )
    axes[0, 0].set_xlabel("Tp [s]")
    axes[0, 1].scatter(
        t.wind_speed, t.significant_height, s=size, c=t.wind_speed, norm=speeds, cmap="viridis", lw=0, alpha=0.8
    )
    axes[0, 1].set_xlabel("Wind speed at the hub [m/s]")
    for ax in axes[0]:
        ax.set_ylabel("Hs [m]")
        ax.set_xlim(left=0)
        ax.set_ylim(bottom=0)
    caption = "States of the table: area proportional to probability, colour to the wind speed."
    return Drawing(name="states", group="states", title="States", caption=caption, figure=figure)


def rainflow(study) -> Drawing:
    """Return equivalent ranges of the spectral method over those of rainflow counting."""
    c = study.check
    figure, axes = grid(1, 1, width=5.0, height=3.6, top=0.35)
    ax = axes[0, 0]
    top = 1.08 * max(c.spectral.max(), c.counted.max()) / 1e6
    ax.fill_between([0, top], [0, 0.9 * top], [0, 1.1 * top], color=GREY, alpha=0.2, lw=0, label="± 10 %")
    for j, (m, colour) in enumerate(zip(c.slopes, (BLUE, AMBER, ORANGE, INK), strict=False)):
        ax.plot(
            c.counted[:, j] / 1e6, c.spectral[:, j] / 1e6, color=colour, marker="o", ms=4, ls="", label=f"m = {m:g}"
        )
    ax.plot([0, top], [0, top], color=INK, lw=0.8)
    ax.set_xlim(0, top)
    ax.set_ylim(0, top)
    ax.set_xlabel("Rainflow [MPa]")
    ax.set_ylabel("Spectral [MPa]")
    ax.legend(loc="upper left")
    caption = f"Damage-equivalent stress ranges at 1 Hz at the worst point: {study.settings.method.replace('_', ' ')} against rainflow counting of {c.hours} synthesised hours a state."
    return Drawing(name="rainflow", group="check", title="Check by rainflow counting", caption=caption, figure=figure)
