"""What people see in the terminal: progress on standard error, tables on standard output."""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fowtio.write import tables
from fowtio.write.table import Table
from model.response.cummins import consistency_rows
from model.system.hydro import HydroCoefficients
from model.system.morison import added_mass_of

if TYPE_CHECKING:
    from fowtio.validation import Validation


class Progress:
    """Says on standard error what is being done; on a terminal the line is replaced, else nothing under two seconds is said."""

    def __init__(self, quiet: bool):
        self.quiet, self.live, self.start = quiet, sys.stderr.isatty(), time.monotonic()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.live and not self.quiet:
            print("\r\033[K", end="", file=sys.stderr)

    def __call__(self, text: str) -> None:
        if self.quiet:
            return
        if self.live:
            print(f"\r\033[K{text} ...", end="", file=sys.stderr, flush=True)
        elif time.monotonic() - self.start > 2:
            print(f"{text} ...", file=sys.stderr, flush=True)


def show_table(table: Table | None) -> None:
    """Print a table, numbers aligned to the right, units in the heading."""
    if table is None or not table.rows:
        return
    body = table.text()
    cells = [[c.heading for c in table.columns], *body]
    widths = [max(len(row[k]) for row in cells) for k in range(len(table.columns))]
    left = [all(isinstance(row[k], str) for row in table.rows) for k in range(len(table.columns))]

    def line(row):
        return "  ".join(c.ljust(w) if to_left else c.rjust(w) for c, w, to_left in zip(row, widths, left, strict=True)).rstrip()

    print(f"\n{table.title}")
    print(line(cells[0]))
    print("─" * (sum(widths) + 2 * (len(widths) - 1)))
    for row in body:
        print(line(row))
    if table.note:
        print(table.note)


def show_rows(title: str, rows: Sequence[tuple[str, str]]) -> None:
    """Print labels and texts in two columns."""
    print(title)
    width = max((len(label) for label, _ in rows), default=0)
    for label, text in rows:
        print(f"  {label.ljust(width)}  {text}")


def show_notes(model) -> None:
    """Print what was assumed."""
    if model.notes:
        print("\nNotes")
        for note in model.notes:
            print(f"  - {note}")


def show_run(model, results, folder: Path, files: Sequence[Path], kept=None, pairs=()) -> None:
    """Print the summary of the main job; kept and pairs come from `fowtio.kept_dofs`, None without a flexible rotor."""
    print(model.case.title)
    show_table(tables.natural_periods(model))
    show_table(tables.published_periods(model))
    show_table(tables.mean_offsets(model))
    show_table(tables.summary(results))
    if kept is not None:
        from fowtio.kept_dofs import kept_table, whirl_table

        show_table(kept_table(kept))
        show_table(whirl_table(pairs) if pairs else None)
    show_notes(model)
    report = next((f for f in files if f.suffix == ".html"), None)
    print(f"\n{len(files)} files in {folder}" + (f"; the report is {report}" if report else ""))


def show_check(model) -> None:
    """Print what a study holds, and who contributes what at every operating point."""
    deck, hydro = model.deck, model.hydro
    first = model.points[0].system
    show_rows(
        f"{model.case.path}: {model.case.title}",
        [
            ("deck", f"{deck.path}, {len(deck.files)} files"),
            ("water", f"depth {deck.depth:g} m, density {deck.density:g} kg/m³, gravity {deck.gravity:g} m/s²"),
            ("hydrodynamics", f"{len(hydro.omega)} frequencies {hydro.omega[0]:.3g} to {hydro.omega[-1]:.3g} rad/s, {len(hydro.heading)} headings"),
            *([] if hydro.members is None else [("members beside it", members_row(hydro))]),
            ("drag elements", f"{len(first.drag)} ({int(first.drag.axial.sum())} end plates)"),
            ("moorings", "none" if deck.mooring is None else f"{len(deck.mooring.line_names)} lines ({deck.mooring_path.name})"),
            ("degrees of freedom", ", ".join(first.dofs)),
            ("states", ", ".join(s.name for s in model.states)),
        ],
    )
    rows = consistency_rows(hydro)
    if rows:
        print()
        show_rows("radiation", rows)
    show_table(tables.conditions(model))
    for point in model.points:
        show_table(tables.contained(point))
        show_table(tables.contributions(point))
    show_notes(model)


def members_row(hydro: HydroCoefficients) -> str:
    """Return what the members outside the potential flow have of the sums below."""
    found, mass = hydro.members, np.diag(added_mass_of(hydro.members)) / 1e3
    names = ", ".join(found.names) if len(found.names) <= 12 else f"{', '.join(found.names[:3])} ... {found.names[-1]}"
    return (
        f"{len(found.names)} (PropPot False: {names}); volume {found.volume:.1f} m³, C33 {found.stiffness[2, 2] / 1e3:.1f} kN/m, "
        f"A11 {mass[0]:.0f} t, A22 {mass[1]:.0f} t, A33 {mass[2]:.0f} t, in the hydrostatics and added mass below"
    )


def show_modes(model) -> None:
    """Print the natural modes of every operating point."""
    show_table(tables.natural_periods(model))
    show_table(tables.published_periods(model))
    show_notes(model)


def show_validation(found: Sequence[Validation], files: Sequence[Path], decays: Sequence = ()) -> None:
    """Print the comparisons with the reference time series, decay tests, and what is doubtful about the references."""
    from fowtio.write import validation_tables

    for item in found:
        for table in (*validation_tables.channels(item), validation_tables.lack(item)):
            show_table(table)
        if item.unmatched:
            print(f"reference channels without a counterpart, or at rest: {', '.join(item.unmatched)}")
        if item.missing:
            print(f"channels of the model that the reference lacks: {', '.join(item.missing)}")
    show_table(validation_tables.decay_table(decays))
    show_table(validation_tables.findings(found, decays))
    report = next((f for f in files if f.suffix == ".html"), None)
    if files:
        print(f"\n{len(files)} files in {files[0].parent}" + (f"; the report is {report}" if report else ""))
