"""Plain tables with units, and how their numbers are written for people."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

ROW = "unit of the row"  # unit of a column whose rows have units of their own, named in the column "Unit"

DECIMALS = {
    "m": 3, "deg": 3, "s": 2, "Hz": 4, "%": 2, "kN": 1, "MN m": 3, "m/s²": 4, "m/s": 1, "t": 0, "10⁶ t m²": 3,
    "kN/m": 1, "MN m/rad": 1, "rpm": 2, "kg/m": 1, "MN": 1, "m³": 0, "kg/m³": 1, "bytes": 0, "mm": 1,
}  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Column:
    """A column: name; unit ("" for none, ROW when rows have their own); decimals (None: as suits the unit), or digits
    after the point of scientific notation.
    """

    name: str
    unit: str = ""
    decimals: int | None = None
    scientific: int | None = None

    @property
    def heading(self) -> str:
        """Name and unit in one."""
        return f"{self.name} [{self.unit}]" if self.unit not in ("", ROW) else self.name


@dataclass(frozen=True, kw_only=True)
class Table:
    """A table: name for files, title, columns, rows of text, numbers and None (nothing to say), a note below."""

    name: str
    title: str
    columns: tuple[Column, ...]
    rows: tuple[tuple, ...]
    note: str = ""

    def __post_init__(self):
        for row in self.rows:
            if len(row) != len(self.columns):
                raise ValueError(f"table {self.name!r}: a row has {len(row)} cells for {len(self.columns)} columns")

    def unit(self, row: tuple, k: int) -> str:
        """Return the unit of cell k of a row."""
        unit = self.columns[k].unit
        if unit != ROW:
            return unit
        return row[next(i for i, c in enumerate(self.columns) if c.name == "Unit")]

    def numeric(self, k: int) -> bool:
        """Tell whether column k holds numbers."""
        return self.columns[k].unit != "" or all(not isinstance(row[k], str) for row in self.rows)

    def column(self, name: str) -> list:
        """Return the cells of a column; raise KeyError with the known names."""
        names = [c.name for c in self.columns]
        if name not in names:
            raise KeyError(f"no column {name!r} in {self.name!r}; there are {', '.join(names)}")
        return [row[names.index(name)] for row in self.rows]

    def text(self) -> list[list[str]]:
        """Return the rows as people read them."""
        return [[self._cell(row, k) for k in range(len(row))] for row in self.rows]

    def _cell(self, row: tuple, k: int) -> str:
        value, column = row[k], self.columns[k]
        if isinstance(value, str):
            return value
        if column.scientific is not None:
            return scientific(value, column.scientific)
        return number(value, self.unit(row, k), column.decimals)


def joined(name: str, title: str, label: str, tables: Sequence[tuple[str, Table]]) -> Table:
    """Return tables of one kind as one, with a first column that tells them apart; missing columns are empty."""
    columns = tuple(dict.fromkeys(c for _, t in tables for c in t.columns))
    rows = []
    for key, table in tables:
        at = [table.columns.index(c) if c in table.columns else None for c in columns]
        rows += [(key, *(None if k is None else row[k] for k in at)) for row in table.rows]
    return Table(
        name=name, title=title, columns=(Column(name=label), *columns), rows=tuple(rows), note=tables[0][1].note
    )


def number(value, unit: str = "", decimals: int | None = None) -> str:
    """Return a number with the decimals given or those of its unit, thousands apart; a dash for None and not-a-number.

    Units without an entry have four significant digits.
    """
    if value is None or not math.isfinite(value):
        return "–"
    places = DECIMALS.get(unit) if decimals is None else decimals
    if places is None:
        places = 3 if value == 0 else min(max(0, 3 - math.floor(math.log10(abs(value)))), 6)
        text = f"{value:,.{places}f}"
        text = text.rstrip("0").rstrip(".") if "." in text else text
    else:
        text = f"{value:,.{places}f}"
    if not any(c in "123456789" for c in text):
        text = text.lstrip("-")
    return text.replace(",", "\N{NARROW NO-BREAK SPACE}").replace("-", "−")


def scientific(value, digits: int) -> str:
    """Return a number in scientific notation, "0" for zero and a dash for None."""
    if value is None or not math.isfinite(value):
        return "–"
    return "0" if value == 0 else f"{value:.{digits}e}".replace("-", "−")


def excel_format(column: Column, unit: str) -> str:
    """Return the number format of a spreadsheet cell."""
    if column.scientific is not None:
        return "0." + "0" * column.scientific + "E+00"
    places = DECIMALS.get(unit) if column.decimals is None else column.decimals
    if places is None:
        return "General"
    return "#,##0" + ("." + "0" * places if places else "")
