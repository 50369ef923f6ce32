"""Results as one workbook for people: a sheet per result, units in the headings, numbers unrounded.

model and loads are those of `fowtio.workflow`: a Model, and a sequence of StateLoads.
"""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from openpyxl import Workbook
from openpyxl.cell import WriteOnlyCell
from openpyxl.styles import Alignment, Font, PatternFill
from openpyxl.utils import get_column_letter

from fowtio import __version__
from fowtio.write import tables
from fowtio.write.atomic import atomic_file
from fowtio.write.netcdf import CONVENTIONS
from fowtio.write.provenance import command
from fowtio.write.quantities import has_wind, main_headings, people, point_label, split_spectra, squared, state_label
from fowtio.write.table import Column, Table, excel_format, joined

_BOLD, _TITLE, _FILL = Font(bold=True), Font(bold=True, size=13), PatternFill("solid", fgColor="DCE6F1")
_WRAP = Alignment(wrap_text=True, vertical="top")
WIDEST = 60


def write_excel(path: str | Path, model, loads: Sequence) -> Path:
    """Write the results of a study as a workbook; the file appears whole or not at all."""
    book = _book(model, loads)
    with atomic_file(path) as temporary:
        book.save(temporary)
    return Path(path)


def _book(model, loads: Sequence) -> _Book:
    """Return the workbook of a study's results; all contents are made before any of it is written."""
    numbers = [(i.state.name, _rao(i), _spectra(i)) for i in loads]
    before, after = _first_sheets(model, loads), _last_sheets(model, loads)
    book = _Book()
    for name, found in before:
        book.sheet(name, found, title=model.case.title if name == "Summary" else "")
    for name, transfer, spectra in numbers:
        book.numbers(f"RAO {name}", *transfer)
        book.numbers(f"Spectra {name}", *spectra)
    for name, found in after:
        book.sheet(name, found)
    return book


def _first_sheets(model, loads) -> list[tuple[str, list[Table]]]:
    """Return names and tables of the sheets before the plain numbers."""
    by_state = [(i.state.name, tables.state_statistics(i)) for i in loads]
    moorings = (
        ("Mooring tensions", tables.mooring_tensions(model, loads)),
        ("Mooring lines", tables.mooring_lines(model)),
    )
    return [
        ("Summary", [tables.summary(loads)]),
        ("States", [tables.conditions(model)]),
        ("Natural periods", [tables.natural_periods(model)]),
        ("Damping with drag", [tables.damping_with_drag(loads)]),
        ("Mean offsets", [tables.mean_offsets(model)]),
        *((name, [table]) for name, table in moorings if table is not None),
        ("Statistics", [joined("statistics", "Statistics", "State", by_state)]),
    ]


def _last_sheets(model, loads) -> list[tuple[str, list[Table]]]:
    """Return names and tables of the sheets after the plain numbers."""
    at = [(point_label(p.wind_speed), p) for p in model.points]
    parts = [(label, tables.contributions(p)) for label, p in at]
    held = [(label, t) for label, p in at if (t := tables.contained(p)) is not None]
    title = "Held by the linearisations beside the turbine and taken out"
    return [
        ("Matrices", [t for p in model.points for t in tables.matrices(p)]),
        ("Contributions", [joined("contributions", "Who contributes what", "Operating point", parts)]),
        *([("Taken out", [joined("contained", title, "Operating point", held)])] if held else []),
        ("Notes", [_notes(model, loads)]),
    ]


class _Book:
    """A workbook being written sheet by sheet, with one style record for each number format.

    Rows of plain numbers are kept aside as XML and put into their sheets at the end, since openpyxl takes
    five times as long for them.
    """

    def __init__(self):
        self.book, self.names, self.styles, self.rows = Workbook(write_only=True), set(), {}, {}

    def save(self, path: Path) -> None:
        """Write the workbook, the rows of plain numbers in their sheets."""
        plain = io.BytesIO()
        self.book.save(plain)
        with (
            zipfile.ZipFile(plain) as source,
            zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=2) as target,
        ):
            for name in source.namelist():
                content = source.read(name)
                if name in self.rows:
                    head, tail = content.split(b"</sheetData>")
                    content = head + self.rows[name] + b"</sheetData>" + tail
                target.writestr(name, content)

    def sheet(self, name: str, found: Sequence[Table], title: str = "") -> None:
        """Add a sheet of tables below each other; with one table its heading row stays in view."""
        sheet = self.book.create_sheet(self._name(name))
        self._widths(sheet, _table_widths(found))
        lead = (2 if title else 0) + 3
        sheet.freeze_panes = f"B{lead}" if len(found) == 1 else "B1"
        if title:
            sheet.append([self._text(sheet, title, _TITLE)])
            sheet.append([])
        for table in found:
            sheet.append([self._text(sheet, table.title, _BOLD)])
            sheet.append([self._heading(sheet, c.heading) for c in table.columns])
            for row in table.rows:
                sheet.append(
                    [
                        self._cell(sheet, v, excel_format(c, table.unit(row, k)))
                        for k, (v, c) in enumerate(zip(row, table.columns, strict=True))
                    ]
                )
            if table.note:
                sheet.append([table.note])
            sheet.append([])

    def numbers(self, name: str, headings: Sequence[str], values: np.ndarray, formats: Sequence[str]) -> None:
        """Add a sheet of plain numbers below one heading row, which stays in view."""
        sheet = self.book.create_sheet(self._name(name))
        self._widths(sheet, [13] * len(headings))
        sheet.freeze_panes = "B2"
        sheet.append([self._heading(sheet, h) for h in headings])
        styles = [self._style_number(sheet, f) for f in formats]
        cells = [(get_column_letter(k), s) for k, s in enumerate(styles, start=1)]
        place = f"xl/worksheets/sheet{len(self.book.worksheets)}.xml"
        self.rows[place] = "".join(_row(i, row, cells) for i, row in enumerate(values.tolist(), start=2)).encode()

    def _name(self, name: str) -> str:
        """Return a name that Excel takes (31 characters, some not allowed) and that no other sheet has."""
        clean = re.sub(r"[\[\]:*?/\\']", "_", name)[:31]
        out, k = clean, 2
        while out.lower() in self.names:
            out, k = f"{clean[:27]} ({k})", k + 1
        self.names.add(out.lower())
        return out

    def _style(self, sheet, number_format: str):
        if number_format not in self.styles:
            cell = WriteOnlyCell(sheet, 0.0)
            cell.number_format = number_format
            self.styles[number_format] = cell._style
        return self.styles[number_format]

    def _style_number(self, sheet, number_format: str) -> int:
        cell = WriteOnlyCell(sheet, 0.0)
        cell._style = self._style(sheet, number_format)
        return cell.style_id

    def _cell(self, sheet, value, number_format: str):
        """Return a number in its format, a text, or an empty cell for nothing and not-a-number."""
        if isinstance(value, str):
            return value
        if value is None or not np.isfinite(value):
            return None
        cell = WriteOnlyCell(sheet, value)
        cell._style = self._style(sheet, number_format)
        return cell

    @staticmethod
    def _text(sheet, text: str, font: Font):
        cell = WriteOnlyCell(sheet, text)
        cell.font = font
        return cell

    @staticmethod
    def _heading(sheet, text: str):
        cell = WriteOnlyCell(sheet, text)
        cell.font, cell.fill, cell.alignment = _BOLD, _FILL, _WRAP
        return cell

    @staticmethod
    def _widths(sheet, widths: Iterable[float]) -> None:
        for k, width in enumerate(widths, start=1):
            sheet.column_dimensions[get_column_letter(k)].width = width


def _row(i: int, values: list[float], cells: list[tuple[str, int]]) -> str:
    """Return the XML of row i of a sheet; not-a-number is an empty cell."""
    inner = "".join(
        f'<c r="{c}{i}" s="{s}"><v>{v!r}</v></c>' for v, (c, s) in zip(values, cells, strict=True) if v - v == 0
    )
    return f'<row r="{i}">{inner}</row>'


def _table_widths(found: Sequence[Table]) -> list[float]:
    """Return column widths: the longest text of each column, headings broken over two lines."""
    count = max(len(t.columns) for t in found)
    out = []
    for k in range(count):
        cells = [len(row[k]) for t in found for row in t.text() if k < len(row)]
        cells += [
            max(max(len(w) for w in t.columns[k].heading.split() or [""]), len(t.columns[k].heading) / 2)
            for t in found
            if k < len(t.columns)
        ]
        out.append(min(max(cells) + 2.5, WIDEST))
    return out


def _rao(item) -> tuple[list[str], np.ndarray, list[str]]:
    """Return headings, magnitudes and phases of all channels per wave amplitude (main heading) and per wind speed."""
    channels, drive = item.channels, item.response.excitation
    main = main_headings(item)
    degrees = np.degrees(drive.heading)
    blocks = [(f"{degrees[k]:g}°" if len(main) > 1 else "", "m", channels.to_wave[k]) for k in main]
    blocks += [("wind", "(m/s)", channels.to_wind)] if has_wind(item) else []
    headings, columns = ["Frequency [Hz]"], [drive.omega / (2 * np.pi)]
    for label, per, values in blocks:
        phases = np.degrees(np.angle(values))
        for k, name in enumerate(channels.names):
            unit, factor = people(channels.units[k])
            place = f" {label}" if label else ""
            headings += [f"{name}{place} [{unit}/{per}]", f"{name}{place} phase [deg]"]
            columns += [np.abs(values[:, k]) * factor, phases[:, k]]
    formats = ["0.00000", *(["0.0000E+00", "0.0"] * ((len(headings) - 1) // 2))]
    return headings, np.stack(columns, axis=1), formats


def _spectra(item) -> tuple[list[str], np.ndarray, list[str]]:
    """Return headings and spectra per Hz of waves, wind and all channels, and what wind gives of each."""
    drive, channels = item.response.excitation, item.channels
    per_hertz = 2 * np.pi
    headings = ["Frequency [Hz]", "Waves [m²/Hz]"]
    columns = [drive.omega / per_hertz, drive.wave_spectrum.sum(axis=0) * per_hertz]
    wind = split_spectra(item)[1] if has_wind(item) else None
    if wind is not None:
        headings.append("Wind [(m/s)²/Hz]")
        columns.append(drive.wind_spectrum * per_hertz)
    for k, name in enumerate(channels.names):
        unit, factor = people(channels.units[k])
        for label, values in ((name, item.spectra), (f"{name} of wind", wind)):
            if values is not None:
                headings.append(f"{label} [{squared(unit)}/Hz]")
                columns.append(values[:, k] * factor**2 * per_hertz)
    return headings, np.stack(columns, axis=1), ["0.00000", *(["0.0000E+00"] * (len(headings) - 1))]


def _notes(model, loads) -> Table:
    """Return conventions, assumptions, states in words, and where the numbers come from."""
    rows = [
        ("Study", f"{model.case.path.name}: {model.case.title}"),
        ("Deck", f"{model.deck.path.name}: {model.deck.title}"),
    ]
    rows += [("Software", f"fowtio {__version__}"), ("To make these results again", command(model))]
    rows += [(f"State {item.state.name}", state_label(item.state)) for item in loads]
    rows += [("Assumption", n) for n in tables.notes(model)]
    rows += [("Convention", s.strip(". ") + ".") for s in CONVENTIONS.split(". ")]
    rows += [
        (
            "Units",
            "Rotations in deg, forces in kN, moments in MN m; matrices in SI. Phases in deg, of Re{X e^(+i omega t)}: "
            "positive is ahead of the wave crest. Transfer functions of the main heading; the netCDF file has all.",
        )
    ]
    return Table(name="notes", title="Notes", columns=(Column(name="Subject"), Column(name="Text")), rows=tuple(rows))
