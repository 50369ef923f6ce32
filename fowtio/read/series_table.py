"""Time series as fowtio writes them: CSV with headings `name (unit)`, and netCDF with a variable for each channel."""

from __future__ import annotations

import csv
import re
from pathlib import Path

import numpy as np

from fowtio.errors import FormatError
from fowtio.read.openfast_out import TimeSeries, checked_series, describe_series, series_problems
from fowtio.read.registry import Format, head_lines
from fowtio.read.text import number, number_rows, read_lines

_HEADING = re.compile(r"^(.*?)\s*(?:\(([^()]*)\))?$")
_SECONDS = ("s", "sec", "seconds", "second")
_CONTENT = "time series of channels"


def read_series_csv(path: str | Path) -> TimeSeries:
    """Return the time series of a CSV file whose first column is the time in seconds; raise FormatError."""
    path = Path(path)
    lines = read_lines(path)
    names, units = _headings(lines[0])
    if not _is_time(names, units):
        raise FormatError(path, 1, expected="'Time (s)' and other headings, apart by commas", found=lines[0])
    rows = lines[1:]
    for i, line in enumerate(rows, start=2):
        if line.count(",") != len(names) - 1:
            raise FormatError(path, i, expected=f"{len(names)} columns", found=line)
    if not rows:
        raise FormatError(path, 1, expected="rows below the headings", found="none")
    try:
        table = np.loadtxt(rows, delimiter=",", comments=None, ndmin=2)
        fine = bool(np.all(np.isfinite(table)))
    except ValueError:
        fine = False
    if not fine:
        table = np.array(number_rows(path, rows, 2, (len(names),), f"{len(names)} finite numbers"))
    return checked_series(path, table[:, 0], np.ascontiguousarray(table[:, 1:]), names[1:], units[1:], "")


def read_series_netcdf(path: str | Path) -> TimeSeries:
    """Return the time series of a netCDF file written by fowtio; raise FormatError."""
    import xarray as xr  # here, because it takes long

    path = Path(path)
    try:
        data = xr.load_dataset(path, engine="h5netcdf", decode_times=False)
    except Exception as error:  # netCDF libraries raise many kinds for a damaged file
        raise FormatError(
            path, expected="a netCDF file", found=str(error).splitlines()[0] if str(error) else ""
        ) from None
    names = list(map(str, data.data_vars))
    if "time" not in data.coords or not names or any(data[n].dims != ("time",) for n in names):
        raise FormatError(path, expected="variables over time", found=", ".join(names) or "none")
    table = np.stack([data[n].values.astype(float) for n in names], axis=1)
    units = [str(data[n].attrs.get("units", "")) for n in names]
    time = data["time"].values.astype(float)
    if not np.all(np.isfinite(time)):
        raise FormatError(path, expected="finite times", found="NaN or infinity")
    return checked_series(path, time, table, names, units, str(data.attrs.get("description", "")))


def _headings(line: str) -> tuple[list[str], list[str]]:
    """Return names and units of a line of headings."""
    cells = next(csv.reader([line]), [])
    found = [_HEADING.match(cell.strip()) for cell in cells]
    return [m[1] for m in found if m], [m[2] or "" for m in found if m]


def _is_time(names: list[str], units: list[str]) -> bool:
    return len(names) > 1 and names[0].lower() == "time" and units[0].lower() in _SECONDS


def _is_csv(path, head: bytes) -> bool:
    lines = head_lines(head)
    if len(lines) < 2 or "," not in lines[0] or not _is_time(*_headings(lines[0].lstrip("\ufeffï»¿"))):
        return False
    try:
        number(lines[1].split(",")[0].strip())
    except ValueError:
        return False
    return True


def _is_netcdf(path, head: bytes) -> bool:
    if not head.startswith(b"\x89HDF"):
        return False
    import h5py  # here, because only files of this kind need it

    try:
        with h5py.File(path) as file:
            content = file.attrs.get("content", b"")
    except (OSError, RuntimeError):
        return False
    return (content.decode("latin-1") if isinstance(content, bytes) else str(content)) == _CONTENT


SERIES_CSV = Format(
    name="time series (.csv)",
    recognises=_is_csv,
    read=read_series_csv,
    describe=describe_series,
    problems=series_problems,
)
SERIES_NETCDF = Format(
    name="time series (.nc)",
    recognises=_is_netcdf,
    read=read_series_netcdf,
    describe=describe_series,
    problems=series_problems,
)
