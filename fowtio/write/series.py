"""Writers of time series: OpenFAST's .outb and .out, CSV and netCDF."""

from __future__ import annotations

import csv
from collections.abc import Callable
from io import StringIO
from pathlib import Path

import numpy as np

from fowtio.errors import ModelError
from fowtio.read.openfast_out import TimeSeries
from fowtio.write.atomic import atomic_file

SHORT_NAME = 10  # characters of a channel's name and unit in FileFmtID 1 to 3
NETCDF_CONTENT = "time series of channels"
_LOW, _RANGE = -32768, 65535  # of 16-bit integers


def write_outb(series: TimeSeries, path: str | Path) -> Path:
    """Write a time series as OpenFAST's binary output file and return its path.

    Packed 16-bit integers as OpenFAST writes by default (FileFmtID 2, or 4 where a name is longer than ten characters):
    a channel keeps 1/65535 of its range. Doubles (FileFmtID 3) where a channel's range is too small beside its mean for
    that, packed time (FileFmtID 1) where time steps vary. Raises ModelError where no form fits.
    """
    return _write(path, lambda target: target.write_bytes(outb_bytes(series)))


def outb_bytes(series: TimeSeries) -> bytes:
    """Return a time series as the content of an .outb file; form and errors as of `write_outb`."""
    width = max(len(text.encode("latin-1", "replace")) for text in (*series.names, *(f"({u})" for u in series.units)))
    even = _even(series.time)
    slope, offset, packed = _packed(series.data)
    exact = np.all(np.abs((packed - offset) / slope - series.data) <= 0.51 * _resolution(series.data), axis=0)
    form = (4 if width > SHORT_NAME else 2) if even and exact.all() else 3 if even else 1
    if form in (1, 3) and (width > SHORT_NAME or (form == 1 and not exact.all())):
        raise ModelError(
            "no form of .outb takes names of more than 10 characters together with varying time steps, nor with a range far below "
            "the mean; write .csv, .nc or .out"
        )
    width = max(width, SHORT_NAME) if form == 4 else SHORT_NAME
    count, channels = series.data.shape
    out = [np.int16(form).tobytes()] + ([np.int16(width).tobytes()] if form == 4 else [])
    out.append(np.array([channels, count], dtype="<i4").tobytes())
    scale, start, time = _packed_time(series.time) if form == 1 else (None, None, None)
    step = (series.time[-1] - series.time[0]) / (count - 1) if count > 1 else 1.0
    out.append(np.array([scale, start] if form == 1 else [series.time[0], step], dtype="<f8").tobytes())
    if form != 3:
        out += [slope.astype("<f4").tobytes(), offset.astype("<f4").tobytes()]
    text = series.description.encode("latin-1", "replace")
    out += [np.int32(len(text)).tobytes(), text]
    out += [_field(n, width) for n in ("Time", *series.names)]
    out += [_field(f"({u})", width) for u in ("s", *series.units)]
    if form == 1:
        out.append(time.tobytes())
    out.append(series.data.astype("<f8").tobytes() if form == 3 else packed.astype("<i2").tobytes())
    return b"".join(out)


def write_out(series: TimeSeries, path: str | Path) -> Path:
    """Write a time series as OpenFAST's text output file (between tabs, nine digits) and return its path."""
    for name in (*series.names, *series.units):
        if "\t" in name or "\n" in name:
            raise ModelError(f"the name {name!r} has a tab or line end, which a text output file cannot hold")
    description = " ".join(series.description.split())
    head = "\t".join(["Time", *series.names]) + "\n" + "\t".join(f"({u})" for u in ("s", *series.units))
    table = np.column_stack([series.time, series.data])

    def write(target: Path) -> None:
        with target.open("w", encoding="utf-8") as stream:
            stream.write(
                f"\n  {description if not description.lower().startswith('time') else ': ' + description}\n\n{head}\n"
            )
            np.savetxt(stream, table, fmt="%.9g", delimiter="\t")

    return _write(path, write)


def write_series_csv(series: TimeSeries, path: str | Path) -> Path:
    """Write a time series as CSV, a heading `name (unit)` for each column and numbers in full, and return its path."""
    head = StringIO()
    csv.writer(head, lineterminator="\n").writerow(
        f"{n} ({u})" for n, u in zip(("Time", *series.names), ("s", *series.units), strict=True)
    )

    def write(target: Path) -> None:
        with target.open("w", encoding="utf-8", newline="") as stream:
            stream.write(head.getvalue())
            table = np.column_stack([series.time, series.data])
            stream.writelines(",".join(map(repr, row)) + "\n" for row in table.tolist())

    return _write(path, write)


def write_series_netcdf(series: TimeSeries, path: str | Path) -> Path:
    """Write a time series as netCDF, a variable with its unit for each channel over time, and return its path."""
    import xarray as xr  # here, because it takes long

    bad = [n for n in series.names if "/" in n or n.lower() == "time" or n != n.strip() or not n]
    if bad or len(set(series.names)) < len(series.names):
        raise ModelError(
            f"netCDF takes different names without '/', and none called time; found {', '.join(bad[:5]) or 'a name twice'}"
        )
    columns = zip(series.names, series.units, series.data.T, strict=True)
    data = xr.Dataset(
        {name: ("time", values, {"units": unit}) for name, unit, values in columns},
        coords={"time": ("time", series.time, {"units": "s"})},
        attrs={"content": NETCDF_CONTENT, "written_by": "fowtio", "description": series.description},
    )

    def write(target: Path) -> None:
        data.to_netcdf(target, engine="h5netcdf")

    return _write(path, write)


def _write(path: str | Path, write: Callable[[Path], object]) -> Path:
    with atomic_file(path) as temporary:
        write(temporary)
    return Path(path)


def _resolution(data: np.ndarray) -> np.ndarray:
    """Return what one step of a packed integer is worth for each channel; for a constant one single precision."""
    return np.maximum(np.ptp(data, axis=0) / _RANGE, 2.0**-23 * np.abs(data).max(axis=0) * (np.ptp(data, axis=0) == 0))


def _packed(data: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return slope and offset (single precision as stored) and integers for each channel: value = (integer - offset)/slope."""
    low, extent = data.min(axis=0), np.ptp(data, axis=0)
    size = np.abs(low)
    flat = np.where(size > 0, 16384 / np.where(size > 0, size, 1.0), 1.0)  # a constant is 16384 steps, zero is none
    varies = extent > 0
    with np.errstate(over="ignore"):
        slope = np.where(varies, _RANGE / np.where(varies, extent, 1.0), flat).astype(np.float32).astype(float)
        slope = np.where(np.isfinite(slope), slope, 1.0)
        offset = np.where(varies, _LOW - slope * low, 0.0).astype(np.float32).astype(float)
        packed = np.clip(np.round(slope * data + offset), _LOW, _LOW + _RANGE)
    return np.where(slope == 0, 1.0, slope), offset, packed


def _even(time: np.ndarray) -> bool:
    """Tell whether times are first + step x number, to a thousandth of a step."""
    if len(time) < 2:
        return True
    step = (time[-1] - time[0]) / (len(time) - 1)
    return bool(np.abs(time - time[0] - step * np.arange(len(time))).max() < 1e-3 * step)


def _packed_time(time: np.ndarray) -> tuple[float, float, np.ndarray]:
    """Return scale, offset and 32-bit integers of times, with time = (integer - offset)/scale."""
    scale = (2.0**32 - 2) / max(time[-1] - time[0], 1e-9)
    offset = -(2.0**31 - 1) - scale * time[0]
    return scale, offset, np.round(scale * time + offset).astype("<i4")


def _field(text: str, width: int) -> bytes:
    return text.encode("latin-1", "replace")[:width].ljust(width)
