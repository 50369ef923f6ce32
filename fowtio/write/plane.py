"""The report of contours of two quantities."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.colors import LogNorm

from fowtio.write.document import bullet_list, write_document
from fowtio.write.report import Card, Section
from fowtio.write.site import LABELS, fit_table, qq
from fowtio.write.style import AMBER, BLUE, ORANGE, Drawing, grid
from fowtio.write.table import Column, Table
from model.environment.joint import UNITS

METHOD_LABELS = {"iform": "IFORM", "highest_density": "highest density", "direct_sampling": "direct sampling"}


def write_plane(
    study, folder: str | Path, *, figures: bool = True, progress: Callable[[str], None] = lambda text: None
) -> list[Path]:
    """Write report, workbook and figures of a PlaneStudy into a folder and return the files."""
    extremes, fits = extreme_table(study), fit_table(study)

    def sections(pictures):
        return [
            Section(title="Contours", content=(*(pictures[n] for n in ("contours",) if n in pictures), extremes)),
            Section(title="Fit", content=(fits, *(pictures[n] for n in ("fit_qq",) if n in pictures))),
            Section(title="Record and notes", content=(bullet_list(study.notes),)),
        ]

    source = Path(study.record.source).name
    return write_document(
        folder,
        name="contour",
        kind="Environmental contours of two quantities",
        title=f"{source}: {' and '.join(LABELS[n] for n in study.names)}",
        origin=f"Record {source}",
        cards=cards(study),
        drawings=lambda: [drawing(study), qq(study)],
        sections=sections,
        sheets=[("Extremes", [extremes]), ("Fit", [fits]), ("Contours", [points_table(study)])],
        figures=figures,
        progress=progress,
    )


def cards(study) -> list[Card]:
    """Return the key numbers."""
    out = [Card(label="Return period", value=f"{study.return_period:g} years", note=f"β = {study.beta:.3f}")]
    for name, line in study.contours.items():
        values = ", ".join(f"{v:.2f} {UNITS[n]}" for v, n in zip(line.max(axis=0), study.names, strict=True))
        out.append(Card(label=f"Extremes, {METHOD_LABELS[name]}", value=values, note="each the largest of its own"))
    return out


def extreme_table(study) -> Table:
    """Return the largest of both quantities on every contour, with the other one there."""
    first, second = (LABELS[n] for n in study.names)
    units = [UNITS[n] for n in study.names]
    columns = (
        Column(name="Method"),
        Column(name=f"Largest {first}", unit=units[0], decimals=2),
        Column(name=f"{second} there", unit=units[1], decimals=2),
        Column(name=f"Largest {second}", unit=units[1], decimals=2),
        Column(name=f"{first} there", unit=units[0], decimals=2),
    )
    rows = []
    for name, line in study.contours.items():
        a, b = line[np.argmax(line[:, 0])], line[np.argmax(line[:, 1])]
        rows.append((METHOD_LABELS[name], float(a[0]), float(a[1]), float(b[1]), float(b[0])))
    title = f"Extremes of the {study.return_period:g}-year contours"
    return Table(name="extremes", title=title, columns=columns, rows=tuple(rows))


def points_table(study) -> Table:
    """Return the points of all contours."""
    columns = (Column(name="Method"), *(Column(name=LABELS[n], unit=UNITS[n], decimals=3) for n in study.names))
    rows = tuple((METHOD_LABELS[n], *map(float, p)) for n, line in study.contours.items() for p in line)
    return Table(name="points", title="Contours", columns=columns, rows=rows)


def drawing(study) -> Drawing:
    """Return the contours over the record."""
    figure, axes = grid(1, 1, width=7.0, height=4.2, top=0.3)
    ax = axes[0, 0]
    first, second = study.names
    x, y = study.states[second], study.states[first]
    ax.hist2d(x, y, bins=70, norm=LogNorm(), cmap="Greys", rasterized=True)
    for (name, line), colour in zip(study.contours.items(), (BLUE, ORANGE, AMBER), strict=False):
        ax.plot(line[:, 1], line[:, 0], color=colour, label=METHOD_LABELS[name])
    ax.set_xlabel(f"{LABELS[second]} [{UNITS[second]}]")
    ax.set_ylabel(f"{LABELS[first]} [{UNITS[first]}]")
    ax.set_xlim(left=0)
    ax.set_ylim(bottom=0)
    ax.legend(loc="upper left")
    caption = f"Contours of {study.return_period:g} years over the states of the record (shade: how many)."
    return Drawing(name="contours", group="contour", title="Contours", caption=caption, figure=figure)
