"""What the commands contour, fatigue and cost save, show and print as JSON."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from fowtio import __version__
from fowtio.contour_study import ContourStudy
from fowtio.cost_study import CostStudy, ranking
from fowtio.fatigue_study import FatigueStudy
from fowtio.plane_contour import PlaneStudy
from fowtio.site import SUFFIX, record_notes, write_site
from fowtio.terminal import show_rows, show_table
from model.environment.joint import UNITS, JointModel

Say = Callable[[str], None]


def save_contour(study: ContourStudy, folder: Path | None, figures: bool, say: Say) -> list[Path]:
    """Write the report of a contour, and the site file of a fitted one; nothing without a folder unless it was fitted
    or sought.
    """
    if folder is None:
        return []
    from fowtio.write.site import write_contour

    files = write_contour(study, folder, figures=figures, progress=say)
    if study.fit is not None:
        files.append(write_site(study.site, folder / f"{study.site.path.stem}{SUFFIX}"))
    return files


def save_plane(study: PlaneStudy, folder: Path | None, figures: bool, say: Say) -> list[Path]:
    """Write the report of contours of two quantities; nothing without a folder."""
    if folder is None:
        return []
    from fowtio.write.plane import write_plane

    return write_plane(study, folder, figures=figures, progress=say)


def save_fatigue(study: FatigueStudy, folder: Path | None, figures: bool, say: Say) -> list[Path]:
    """Write the report of a lifetime, by default into results/."""
    from fowtio.write.fatigue import write_fatigue

    target = folder or Path("results") / f"{study.loads.model.case.path.stem}_{study.site.path.stem}_fatigue"
    return write_fatigue(study, target, figures=figures, progress=say)


def save_cost(study: CostStudy, folder: Path | None, figures: bool, say: Say) -> list[Path]:
    """Write the report of a cost file; nothing without a folder."""
    if folder is None:
        return []
    from fowtio.write.cost import write_cost

    return write_cost(study, folder, figures=figures, progress=say)


def contour_json(study: ContourStudy, files: Sequence[Path]) -> dict:
    """Return a contour; `isolines` are in the order of the wind speeds."""
    site = study.site
    lines = []
    for item in study.isolines:
        row = {
            "hub_wind_speed": item.hub_wind_speed,
            "max_hs": float(item.max_hs[1]),
            "tp_at_max_hs": float(item.max_hs[2]),
            "max_tp": float(item.max_tp[2]),
            "hs_at_max_tp": float(item.max_tp[1]),
        }
        if item.max_hs_interval is not None:
            row["max_hs_interval"] = [float(v) for v in item.max_hs_interval]
        lines.append(row)
    out = {
        "site": str(site.path),
        "title": site.title,
        "version": __version__,
        "return_period": study.return_period,
        "beta": study.beta,
        "state_duration_h": site.state_duration,
        "hub_wind_speed_range": list(study.hub_range),
        "isolines": lines,
        "distribution": _distribution(site.model),
        "files": [str(f) for f in files],
        "notes": [*study.notes, *(record_notes(study.record) if study.record is not None else [])],
        "units": {
            "hub_wind_speed": "m/s",
            "max_hs": "m",
            "tp_at_max_hs": "s",
            "max_tp": "s",
            "hs_at_max_tp": "m",
            "return_period": "years",
            "hub_wind_speed_range": "m/s",
            "max_hs_interval": "m",
        },
    }
    if study.fit is not None:
        out["fit"] = [
            {
                "variable": v.variable.name,
                "method": v.method,
                "log_likelihood": v.goodness.log_likelihood,
                "aic": v.goodness.aic,
                "ks_distance": v.goodness.ks_distance,
                "ks_probability": v.goodness.ks_probability,
                "states": study.fit.count,
            }
            for v in study.fit.variables
        ]
    if study.record is not None:
        report = study.record.report
        out["record"] = {
            "rows": report.rows,
            "missing": dict(report.missing),
            "sentinel": dict(report.sentinel),
            "out_of_range": dict(report.out_of_range),
            "unreadable": dict(report.unreadable),
            "bad_times": report.bad_times,
            "duplicates": report.duplicates,
            "conflicting": report.conflicting,
            "unsorted": report.unsorted,
            "gaps": report.gaps,
            "missing_steps": report.missing_steps,
            "clean": report.clean,
        }
    if study.search is not None:
        s = study.search
        out["worst"] = {
            "channel": s.channel,
            "unit": s.unit,
            "hub_wind_speed": float(s.state[0]),
            "hs": float(s.state[1]),
            "tp": float(s.state[2]),
            "expected_largest": s.value,
        }
    return out


def plane_json(study: PlaneStudy, files: Sequence[Path]) -> dict:
    """Return contours of two quantities; points are in the order of `variables`."""
    return {
        "record": study.record.source,
        "version": __version__,
        "return_period": study.return_period,
        "beta": study.beta,
        "variables": list(study.names),
        "contours": {name: line.tolist() for name, line in study.contours.items()},
        "largest": {name: line.max(axis=0).tolist() for name, line in study.contours.items()},
        "distribution": _distribution(study.fit.model),
        "notes": list(study.notes),
        "files": [str(f) for f in files],
        "units": {"variables": [UNITS[n] for n in study.names], "return_period": "years"},
    }


def _distribution(model: JointModel) -> list[dict]:
    return [
        {
            "variable": v.name,
            "family": v.family,
            "parameters": {
                p: {"form": d.form, "given": d.given, "coefficients": list(d.coefficients)}
                for p, d in v.parameters.items()
            },
        }
        for v in model.variables
    ]


def fatigue_json(study: FatigueStudy, files: Sequence[Path]) -> dict:
    """Return a lifetime's fatigue and ultimate loads."""
    worst, u = study.worst, study.ultimate
    ultimate = {
        name: {
            "unit": u.units[k],
            "mean_plus_std": float(u.objective[k]),
            "expected_largest": float(u.expected[k]),
            "fractile_90": float(u.fractile[k]),
            "long_term": float(u.long_term[k]),
            "contour": float(u.contour[k]),
            "contour_fractile_90": float(u.contour_fractile[k]),
        }
        for k, name in enumerate(u.channels)
    }
    out = {
        "case": str(study.loads.model.case.path),
        "site": str(study.site.path),
        "version": __version__,
        "life_years": study.tower.years,
        "design_factor": study.settings.design_factor,
        "curve": study.curve.name,
        "states": len(study.loads.table),
        "tower": {
            "angle": study.angles.tolist(),
            "damage": study.tower.total.tolist(),
            "equivalent_range": study.tower.equivalent.tolist(),
            "worst_angle": float(study.angles[worst]),
            "worst_damage": float(study.tower.total[worst]),
            "fatigue_life_years": float(study.tower.life[worst] / study.settings.design_factor),
            "slope": study.tower.power,
            "cycles": study.tower.cycles,
            "diameter": float(study.section.diameter),
            "wall": float(study.section.thickness),
            "factor": float(study.factor),
        },
        "ultimate": ultimate,
        "return_period": u.return_period,
        "files": [str(f) for f in files],
        "notes": list(study.notes),
        "units": {
            "angle": "rad",
            "damage": "-",
            "equivalent_range": "Pa",
            "worst_angle": "rad",
            "diameter": "m",
            "wall": "m",
            "return_period": "years",
            "ultimate": "that of each channel",
        },
    }
    if study.lines is not None:
        names = [n for n in study.loads.channels if n.startswith("T[")]
        out["moorings"] = {
            "curve": study.line_curve.name,
            "damage": dict(zip(names, study.lines.total.tolist(), strict=True)),
        }
    if study.check is not None:
        c = study.check
        out["rainflow"] = {
            "slopes": list(c.slopes),
            "hours": c.hours,
            "spectral": c.spectral.tolist(),
            "counted": c.counted.tolist(),
            "largest_error": float(np.abs(c.error).max()),
        }
    return out


def cost_json(study: CostStudy, files: Sequence[Path]) -> dict:
    """Return the accounts of all designs."""
    designs = [
        {
            "name": d.name,
            "cost": d.total,
            "items": {
                i.name: {"quantity": float(i.quantity), "unit": i.unit, "price": i.price, "cost": float(i.cost)}
                for i in d.items
            },
            "offset": d.spread.offset,
            "anchor_load": d.spread.horizontal,
            "anchor_uplift": d.spread.uplift,
            "anchor_mass": d.anchor.mass,
            "anchor_capacity": d.anchor.capacity,
            "ballast": d.ballast,
            "anchor_dimensions": None
            if d.anchor.length is None
            else [d.anchor.length, d.anchor.diameter, d.anchor.wall],
        }
        for d in study.designs
    ]
    units = {
        "cost": "EUR",
        "offset": "m",
        "anchor_load": "N",
        "anchor_uplift": "N",
        "anchor_mass": "kg",
        "anchor_capacity": "N",
        "ballast": "kg",
        "anchor_dimensions": "m",
    }
    return {
        "file": str(study.path),
        "title": study.title,
        "version": __version__,
        "designs": designs,
        "ranking": ranking(study),
        "files": [str(f) for f in files],
        "units": units,
    }


def show_contour(study: ContourStudy, files: Sequence[Path]) -> None:
    """Print a contour in the terminal."""
    from fowtio.write.site import fit_table, isoline_table, notes_of, search_tables, summary_rows

    show_rows(study.site.title, summary_rows(study))
    if study.fit is not None:
        show_table(fit_table(study))
    show_table(isoline_table(study))
    for table in search_tables(study):
        show_table(table)
    _notes(notes_of(study))
    _files(files)


def show_plane(study: PlaneStudy, files: Sequence[Path]) -> None:
    """Print contours of two quantities in the terminal."""
    from fowtio.write.plane import extreme_table
    from fowtio.write.site import fit_table

    show_table(fit_table(study))
    show_table(extreme_table(study))
    _notes(study.notes)
    _files(files)


def show_fatigue(study: FatigueStudy, files: Sequence[Path]) -> None:
    """Print a lifetime in the terminal."""
    from fowtio.write.fatigue import basis_table, cards, check_table, line_table, speed_table, ultimate_table

    show_rows(
        f"{study.loads.model.case.path.name} at {study.site.title}",
        [(c.label, f"{c.value}, {c.note}") for c in cards(study)],
    )
    for table in (basis_table(study), speed_table(study), line_table(study), check_table(study), ultimate_table(study)):
        show_table(table)
    _notes(study.notes)
    _files(files)


def show_cost(study: CostStudy, files: Sequence[Path]) -> None:
    """Print accounts in the terminal."""
    from fowtio.write.cost import cost_table, items_table

    print(study.title)
    show_table(cost_table(study))
    show_table(items_table(study))
    _files(files)


def _notes(notes: Sequence[str]) -> None:
    if notes:
        print("\nNotes")
        for note in notes:
            print(f"  - {note}")


def _files(files: Sequence[Path]) -> None:
    report = next((f for f in files if f.suffix == ".html"), None)
    if files:
        print(f"\n{len(files)} files in {files[0].parent}" + (f"; the report is {report}" if report else ""))
