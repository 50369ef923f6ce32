"""The report: one HTML file that needs nothing else, with figures, style and tables inside.

model and loads are those of `fowtio.workflow`: a Model, and a sequence of StateLoads.
"""

from __future__ import annotations

import datetime
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import jinja2
import numpy as np
from markupsafe import Markup

from fowtio import __version__
from fowtio.write import tables
from fowtio.write.atomic import atomic_file
from fowtio.write.provenance import command, input_table, versions
from fowtio.write.quantities import dof_label, point_label, spectra_group, state_label
from fowtio.write.resources import template_folder
from fowtio.write.style import Picture
from fowtio.write.table import Column, Table, number


@dataclass(frozen=True, kw_only=True)
class Section:
    """A section of a report: title and content, Tables, Pictures and trusted HTML; fold are Tables to unfold."""

    title: str
    content: tuple[Table | Picture | str, ...]
    fold: tuple[Table, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Card:
    """One key number of the summary box."""

    label: str
    value: str
    note: str = ""


def write_report(
    path: str | Path, model, loads: Sequence, pictures: Sequence[Picture] = (), extra_sections: Sequence[Section] = ()
) -> Path:
    """Write the report of a study with its figures; the file appears whole or not at all."""
    text = report(model, loads, pictures, extra_sections)
    with atomic_file(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return Path(path)


def report(model, loads: Sequence, pictures: Sequence[Picture] = (), extra_sections: Sequence[Section] = ()) -> str:
    """Return the report as HTML; extra_sections stand before conventions and provenance."""
    sections = [
        _model_section(model, pictures), _periods_section(model, loads), _rao_section(pictures),
        *(_state_section(item, pictures) for item in loads), _mooring_section(model, loads, pictures),
        _hull_section(model, pictures),
        *extra_sections, _conventions_section(), _provenance_section(model),
    ]  # fmt: skip
    sections = [s for s in sections if s.content]
    return environment().get_template("report.html.j2").render(
        title=model.case.title or model.case.path.stem, study=model.case.path.name, deck=model.deck.path.name,
        version=__version__,
        date=datetime.date.today().isoformat(), cards=cards(model, loads), summary=tables.summary(loads),
        conditions=tables.conditions(model), sections=[(f"part-{n}", s) for n, s in enumerate(sections, start=1)],
    )  # fmt: skip


def environment() -> jinja2.Environment:
    """Return the template environment: everything escaped, unknown names are errors."""
    out = jinja2.Environment(
        loader=jinja2.FileSystemLoader(template_folder("report")), autoescape=True, undefined=jinja2.StrictUndefined,
        trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip
    out.tests |= {
        "a_table": lambda x: isinstance(x, Table), "a_picture": lambda x: isinstance(x, Picture),
    }  # fmt: skip
    out.filters |= {"markup": Markup}
    return out


def cards(model, loads: Sequence) -> list[Card]:
    """Return the key numbers: natural periods, mean offset, largest tension and tower-base moment."""
    first, out = model.points[0], []
    modes = dict(zip(first.modes.names, first.modes.frequency, strict=True))
    for dof in ("surge", "heave", "pitch", "tower_fa1"):
        if modes.get(dof, 0.0) > 1e-6:
            label = "Tower" if dof == "tower_fa1" else dof_label(dof)
            value = (
                f"{number(float(modes[dof]) / (2 * np.pi), 'Hz', 3)} Hz"
                if dof == "tower_fa1"
                else f"{number(2 * np.pi / float(modes[dof]), 's', 1)} s"
            )
            out.append(
                Card(
                    label=f"{label}, natural {'frequency' if dof == 'tower_fa1' else 'period'}",
                    value=value,
                    note=point_label(first.wind_speed),
                )
            )
    names = loads[0].channels.names
    for name, label, factor, unit, decimals in (
        ("PtfmSurge", "Largest expected surge", 1.0, "m", 1),
        ("PtfmPitch", "Largest expected pitch", 180 / np.pi, "deg", 1),
        ("TwrBsMyt", "Largest expected tower-base moment", 1e-6, "MN m", 1),
    ):  # fmt: skip
        if name in names:
            k = names.index(name)
            value, item = max(
                ((abs(i.statistics.mean[k]) + i.statistics.extreme[k], i) for i in loads), key=lambda pair: pair[0]
            )
            out.append(
                Card(label=label, value=f"{number(float(value) * factor, unit, decimals)} {unit}", note=item.state.name)
            )
    tensions = tables.mooring_tensions(model, loads)
    if tensions is not None:
        row = max(zip(tensions.column("Expected max"), tensions.column("Line"), tensions.column("State"), strict=True))
        out.append(
            Card(
                label="Largest expected tension", value=f"{number(row[0], 'kN', 0)} kN", note=f"line {row[1]}, {row[2]}"
            )
        )
    return out


def description(model) -> Table:
    """Return the main data of turbine, floater and site."""
    structure, hydro, deck = model.deck.elastodyn.structure, model.hydro, model.deck
    mass = structure.platform.mass
    rows = [
        ("Turbine", "Rotor diameter", structure.rotor.diameter, "m"),
        ("Turbine", "Hub height above still water", structure.hub_height, "m"),
        ("Turbine", "Tower base to top", structure.tower.top_height - structure.tower.base_height, "m"),
        ("Floater", "Mass of the platform", mass * 1e-3, "t"),
        ("Floater", "Centre of mass, z", float(structure.platform.centre[2]), "m"),
        ("Floater", "Displaced volume", hydro.volume, "m³"),
        ("Site", "Water depth", deck.depth if np.isfinite(deck.depth) else None, "m"),
        ("Site", "Density of the water", deck.density, "kg/m³"),
    ]  # fmt: skip
    rows += [("Moorings", "Lines", float(len(deck.mooring.line_names)), "")] if deck.mooring is not None else []
    rows += [("Model", "Degrees of freedom", ", ".join(dof_label(d).lower() for d in model.points[0].system.dofs), "")]
    rows += [
        (
            "Model",
            "Frequencies",
            f"{len(model.omega)} from {model.omega[0] / (2 * np.pi):.3g} to {model.omega[-1] / (2 * np.pi):.3g} Hz",
            "",
        )
    ]
    columns = (Column(name="Part"), Column(name="Quantity"), Column(name="Value"))
    texts = tuple(
        (part, name, value if isinstance(value, str) else f"{number(value)} {unit}".strip())
        for part, name, value, unit in rows
    )
    return Table(name="description", title="Main data", columns=columns, rows=texts)


def _model_section(model, pictures) -> Section:
    notes = "".join(f"<li>{_escaped(n)}</li>" for n in tables.notes(model))
    held = tuple(t for p in model.points if (t := tables.contained(p)) is not None)
    return Section(
        title="Model", fold=held,
        content=(*(p for p in pictures if p.group == "system"), description(model), *map(tables.contributions, model.points), f"<h3>Assumptions</h3><ul>{notes}</ul>"),
    )  # fmt: skip


def _periods_section(model, loads) -> Section:
    return Section(
        title="Natural periods and mean offsets",
        content=tuple(t for t in (
            tables.natural_periods(model), tables.published_periods(model), tables.damping_with_drag(loads), tables.mean_offsets(model),
        ) if t is not None),
    )


def _rao_section(pictures) -> Section:
    return Section(title="Transfer functions", content=tuple(p for p in pictures if p.group.startswith("rao")))


def _state_section(item, pictures) -> Section:
    drag = f" Drag converged in {item.response.iterations} iterations." if item.response.iterations else ""
    words = f"<p>{_escaped(state_label(item.state))}.{drag}</p>"
    own = tuple(p for p in pictures if p.group == spectra_group(item))
    return Section(
        title=f"Responses and loads: {item.state.name}", content=(words, tables.state_statistics(item), *own)
    )


def _mooring_section(model, loads, pictures) -> Section:
    found = [t for t in (tables.mooring_tensions(model, loads), tables.mooring_lines(model)) if t is not None]
    return Section(title="Moorings", content=(*found, *(p for p in pictures if p.group == "moorings")))


def _hull_section(model, pictures) -> Section:
    own = [p for p in pictures if p.group == "hull"]
    return Section(
        title="Hull and matrices", content=("<p>Matrices of the equation of motion below, SI units.</p>", *own),
        fold=tuple(t for p in model.points for t in tables.matrices(p)),
    )  # fmt: skip


def _conventions_section() -> Section:
    rules = (
        "Origin on the tower axis at still water; x downwind, z up. Small rotations about the reference point.",
        "Wave heading is the direction of propagation: 0° towards +x, counter-clockwise seen from above.",
        "Amplitudes X in Re{X e^(+iωt)}; phase 0 when a crest is at the origin; a positive phase leads the crest.",
        "Spectra are one-sided; their integral over frequency is the variance.",
        "Expected extremes of a Gaussian process: σ (u + 0.5772/u), u = √(2 ln N), N upcrossings (Davenport 1964).",
        "Channel names are those of OpenFAST. Shear and moment of the tower base in axes that turn with the platform.",
        "Rotations in deg, forces in kN, moments in MN m; matrices and the netCDF file in SI units and radians.",
    )
    return Section(
        title="Conventions and units", content=("<ul>" + "".join(f"<li>{_escaped(r)}</li>" for r in rules) + "</ul>",)
    )


def _provenance_section(model) -> Section:
    words = f"<p>To make these results again, in the folder of the study:</p><pre>{_escaped(command(model))}</pre>"
    return Section(title="Versions and input files", content=(words, versions()), fold=(input_table(model),))


def _escaped(text: str) -> str:
    return str(Markup.escape(text))
