"""The report of what designs cost, item by item."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from fowtio.write.document import write_document
from fowtio.write.report import Card, Section
from fowtio.write.style import COLOURS, GREY, Drawing, grid, legend
from fowtio.write.table import Column, Table

MILLION = 1e-6


def write_cost(
    study, folder: str | Path, *, figures: bool = True, progress: Callable[[str], None] = lambda text: None
) -> list[Path]:
    """Write report, workbook and figures of a CostStudy into a folder and return the files."""
    overview, items, plates = cost_table(study), items_table(study), plating_table(study)

    def sections(pictures):
        return [
            Section(title="Cost of the designs", content=(overview, *pictures.values())),
            Section(title="Accounts", content=(items,), fold=(plates,)),
        ]

    return write_document(
        folder,
        name="cost",
        kind="Cost of floating foundations",
        title=study.title,
        origin=f"Cost file {study.path.name}",
        cards=cards(study),
        drawings=lambda: [bars(study)],
        sections=sections,
        sheets=[("Designs", [overview]), ("Accounts", [items]), ("Plating", [plates])],
        figures=figures,
        progress=progress,
    )


def cards(study) -> list[Card]:
    """Return the key numbers."""
    ordered = sorted(study.designs, key=lambda d: d.total)
    low, high = ordered[0], ordered[-1]
    return [
        Card(label="Cheapest design", value=f"{low.total * MILLION:.3f} M€", note=low.name),
        Card(label="Dearest design", value=f"{high.total * MILLION:.3f} M€", note=high.name),
        Card(label="Thrust", value=f"{study.thrust / 1e3:.0f} kN", note="for offsets and anchor loads"),
    ]


def cost_table(study) -> Table:
    """Return all designs with dimensions, anchors and total."""
    columns = (
        Column(name="Design"),
        Column(name="d", unit="m", decimals=1),
        Column(name="r", unit="m", decimals=1),
        Column(name="draft", unit="m", decimals=1),
        Column(name="Steel", unit="t"),
        Column(name="Ballast", unit="t"),
        Column(name="Offset", unit="m", decimals=2),
        Column(name="Anchor load", unit="kN", decimals=0),
        Column(name="Uplift", unit="kN", decimals=0),
        Column(name="Anchor", unit="t", decimals=2),
        Column(name="Cost", unit="M€", decimals=3),
    )
    rows = tuple(
        (
            d.name,
            d.hull.column_diameter,
            d.hull.radius,
            d.hull.draft,
            sum(p.mass for p in d.plating) / 1e3,
            d.ballast / 1e3,
            d.spread.offset,
            d.spread.horizontal / 1e3,
            max(d.spread.uplift, 0.0) / 1e3,
            d.anchor.mass / 1e3,
            d.total * MILLION,
        )
        for d in study.designs
    )
    note = "Offset and anchor load of the upwind line under the steady thrust; anchors with their safety factor."
    return Table(name="designs", title="Designs", columns=columns, rows=rows, note=note)


def items_table(study) -> Table:
    """Return the account of every design."""
    columns = (
        Column(name="Design"),
        Column(name="Item"),
        Column(name="Quantity", decimals=0),
        Column(name="Unit of quantity"),
        Column(name="Price", unit="€", decimals=3),
        Column(name="Cost", unit="€", decimals=0),
        Column(name="Share", unit="%", decimals=1),
    )
    rows = tuple(
        (d.name, i.name, float(i.quantity), i.unit, i.price, float(i.cost), float(100 * i.cost / d.total))
        for d in study.designs
        for i in d.items
    )
    return Table(name="accounts", title="Accounts", columns=columns, rows=rows)


def plating_table(study) -> Table:
    """Return the surfaces of every hull."""
    columns = (
        Column(name="Design"),
        Column(name="Part"),
        Column(name="Area", unit="m²", decimals=0),
        Column(name="Thickness", unit="mm"),
        Column(name="Steel", unit="t"),
    )
    rows = tuple((d.name, p.name, p.area, 1e3 * p.thickness, p.mass / 1e3) for d in study.designs for p in d.plating)
    return Table(name="plating", title="Plating", columns=columns, rows=rows)


def bars(study) -> Drawing:
    """Return the accounts as stacked bars, the cheapest design first."""
    ordered = sorted(study.designs, key=lambda d: d.total)
    figure, axes = grid(1, 1, width=9.0, height=3.0, top=0.55)
    ax, x, base = axes[0, 0], np.arange(len(ordered)), np.zeros(len(ordered))
    handles, labels = [], [i.name for i in ordered[0].items]
    for k, colour in zip(range(len(labels)), (*COLOURS, GREY), strict=False):
        part = np.array([d.items[k].cost for d in ordered]) * MILLION
        handles.append(ax.bar(x, part, 0.65, bottom=base, color=colour, lw=0))
        base += part
    for place, total in zip(x, base, strict=True):
        ax.text(place, total + 0.01 * base.max(), f"{total:.2f}", ha="center", va="bottom", fontsize=8)
    ax.set_xticks(x)
    ax.set_xticklabels([d.name for d in ordered])
    ax.set_ylabel("Cost [M€]")
    ax.set_ylim(0, 1.1 * base.max())
    ax.grid(axis="x", visible=False)
    legend(figure, handles, labels)
    return Drawing(
        name="cost",
        group="cost",
        title="Cost by item",
        caption="Cost of every design by item, the cheapest first.",
        figure=figure,
    )
