"""Tables of metocean records as text, spreadsheet or netCDF, columns by heading; nothing is interpreted yet."""

from __future__ import annotations

import re
from pathlib import Path

from fowtio.errors import FormatError
from fowtio.read.metocean_columns import quantities_of, split_heading
from fowtio.read.metocean_time import TIME_PARTS, is_time
from fowtio.read.text import read_bytes, read_lines


def read_table(path: Path) -> tuple:
    """Return a pandas table of text or numbers by heading, and the units that headings have as attributes."""
    head = read_bytes(path)[:8]
    if head[:4] == b"PK\x03\x04":
        return _spreadsheet(path), {}
    if head[:3] == b"CDF" or head[:4] == b"\x89HDF":
        return _netcdf(path)
    return _text(path), {}


def _text(path: Path):
    """Return the table of a text file: separator, heading and line of units are found by looking."""
    import pandas as pd

    lines = read_lines(path)
    start = next((i for i, line in enumerate(lines) if is_heading(line)), None)
    if start is None or start + 1 >= len(lines):
        raise FormatError(path, 1, expected="a line of headings and rows below it", found=lines[0])
    separator = next((s for s in ("\t", ";", ",") if s in lines[start]), None)
    headings = split_line(lines[start].lstrip("# "), separator)
    body = start + 1
    while (
        body < len(lines) and (lines[body].startswith("#") or not re.search(r"\d", lines[body])) and lines[body].strip()
    ):
        body += 1
    rows = []
    for i, line in enumerate(lines[body:], start=body + 1):
        if not line.strip() or line.startswith("#"):
            continue
        row = split_line(line, separator)
        if len(row) != len(headings):
            raise FormatError(path, i, expected=f"{len(headings)} columns", found=line)
        rows.append(row)
    if not rows:
        raise FormatError(path, start + 1, expected="rows below the headings", found="none")
    if len(set(headings)) < len(headings):
        raise FormatError(path, start + 1, expected="different headings", found=lines[start])
    table = pd.DataFrame(rows, columns=headings, dtype=object)
    if separator == ";":
        table = table.map(lambda t: t.replace(",", ".") if re.fullmatch(r"[-+]?\d+,\d+", t) else t)
    return table


def is_heading(line: str) -> bool:
    """Tell whether a line has two words or more that are no numbers and mean a time or a quantity."""
    separator = next((s for s in ("\t", ";", ",") if s in line), None)
    parts = split_line(line.lstrip("# "), separator)
    known = [p for p in parts if quantities_of(p) or is_time(p) or split_heading(p)[0] in TIME_PARTS["year"]]
    return len(parts) > 1 and bool(known) and not re.match(r"\s*[-+]?\d", line.lstrip("#"))


def split_line(line: str, separator: str | None) -> list[str]:
    """Return the parts of a line between separators (None: blanks), without quotation marks."""
    parts = line.split(separator) if separator else line.split()
    return [p.strip().strip('"').strip() for p in parts]


def _spreadsheet(path: Path):
    import pandas as pd

    try:
        table = pd.read_excel(path, dtype=object)
    except Exception as error:  # openpyxl has no common class of errors for damaged files
        raise FormatError(path, expected="a readable spreadsheet", found=str(error)) from None
    if table.empty:
        raise FormatError(path, expected="rows in the first sheet", found="none")
    return table.rename(columns=str)


def _netcdf(path: Path) -> tuple:
    import xarray as xr

    try:
        with xr.open_dataset(path) as source:
            data = source.load().squeeze(drop=True)
    except Exception as error:  # the back ends raise errors of many kinds for damaged files
        raise FormatError(path, expected="a readable netCDF file", found=str(error)) from None
    time = next((n for n in data.variables if is_time(n) or data[n].dtype.kind == "M"), None)
    if time is None:
        raise FormatError(path, expected="a variable of time", found=", ".join(map(str, data.variables)))
    wide = [str(n) for n in data.data_vars if data[n].ndim > 1 and quantities_of(str(n))]
    if wide:
        dims = ", ".join(f"{d} ({s})" for d, s in data.sizes.items())
        raise FormatError(
            path, expected="one place", found=f"{', '.join(wide)} over {dims}", hint="Select one point first"
        )
    keep = [n for n in data.data_vars if data[n].dims == data[time].dims and n != time]
    units = {str(n): str(data[n].attrs.get("units", "")).lower() for n in keep}
    table = data[[*keep]].to_dataframe().reset_index().rename(columns=str)
    return table, units
