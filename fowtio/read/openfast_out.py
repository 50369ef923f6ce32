"""Time series of OpenFAST and its modules: binary .outb (FileFmtID 1 to 4), text .out (HydroDyn, MoorDyn, MAP).

Source of the binary layout: WrBinFAST in the NWTC Library's documentation (little-endian; packed 16-bit integers with
a slope and an offset per channel, or plain doubles).
"""

from __future__ import annotations

import struct
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from fowtio.errors import FormatError
from fowtio.read.registry import Format, head_lines
from fowtio.read.text import number_table, numbers, read_bytes, read_lines

_WITH_TIME, _WITHOUT_TIME, _UNCOMPRESSED, _LONG_NAMES = 1, 2, 3, 4


@dataclass(frozen=True, eq=False, kw_only=True)
class TimeSeries:
    """Channels over time: names, units as written, data (samples, channels), time [s], source names the file.

    trailing_bytes counts what a binary file holds behind its last step, as when it was written over a longer one.
    """

    time: np.ndarray
    data: np.ndarray
    names: tuple[str, ...]
    units: tuple[str, ...]
    description: str = ""
    source: str = ""
    trailing_bytes: int = 0

    def channel(self, name: str) -> np.ndarray:
        """Return one channel by its name (any case); raise FormatError when there is none."""
        lower = [n.lower() for n in self.names]
        if name.lower() not in lower:
            raise FormatError(self.source, expected=f"a channel {name}", found=", ".join(self.names[:12]) + " ...")
        return self.data[:, lower.index(name.lower())]

    def unit(self, name: str) -> str:
        """Return the unit of a channel as written, without brackets; raise FormatError when there is no such channel."""
        self.channel(name)
        return self.units[[n.lower() for n in self.names].index(name.lower())]


def read_openfast_out(path: str | Path) -> TimeSeries:
    """Return the time series of an OpenFAST .outb or .out file, told apart by content; raise FormatError."""
    path = Path(path)
    data = read_bytes(path)
    return _read_binary(path, data) if is_outb(data) else _read_text(path)


def is_outb(head: bytes) -> bool:
    """Tell by the first bytes of a file whether it is a binary output file of OpenFAST."""
    return len(head) > 1 and struct.unpack("<h", head[:2])[0] in (_WITH_TIME, _WITHOUT_TIME, _UNCOMPRESSED, _LONG_NAMES)


class _Buffer:
    """Reads values one after another and says what was being read when the file ends."""

    def __init__(self, path: Path, data: bytes):
        self.path, self.data, self.at = path, data, 0

    def take(self, kind: str, count: int, what: str) -> np.ndarray:
        dtype = np.dtype(kind)
        end = self.at + count * dtype.itemsize
        if count < 0 or end > len(self.data):
            raise FormatError(
                self.path,
                expected=f"{count} values of {what} at byte {self.at}",
                found=f"a file of {len(self.data)} bytes",
                hint="Is the file complete?",
            )
        out = np.frombuffer(self.data, dtype, count, self.at)
        self.at = end
        return out

    def one(self, kind: str, what: str):
        return self.take(kind, 1, what)[0]

    def text(self, length: int, what: str) -> str:
        return self.take("<u1", length, what).tobytes().decode("latin-1").strip()


def _read_binary(path: Path, content: bytes) -> TimeSeries:
    buffer = _Buffer(path, content)
    form = int(buffer.one("<i2", "FileFmtID"))
    width = int(buffer.one("<i2", "name length")) if form == _LONG_NAMES else 10
    channels, samples = (int(buffer.one("<i4", what)) for what in ("number of channels", "number of time steps"))
    if not (0 < channels < 100_000 and 0 < samples < 2**31 and 0 < width < 1000):
        raise FormatError(path, expected="counts of an .outb header", found=f"{channels} channels, {samples} steps")
    if form == _WITH_TIME:
        time_scale, time_offset = _finite(path, buffer.take("<f8", 2, "time scale and offset"), "time scale and offset")
        if time_scale == 0:
            raise FormatError(path, expected="a time scale other than zero", found="0")
    else:
        time_start, time_step = _finite(
            path, buffer.take("<f8", 2, "first time and time step"), "first time and time step"
        )
    if form != _UNCOMPRESSED:
        with np.errstate(invalid="ignore"):  # NaN is refused below
            slope = buffer.take("<f4", channels, "channel slopes").astype(float)
            offset = buffer.take("<f4", channels, "channel offsets").astype(float)
    description = buffer.text(int(buffer.one("<i4", "length of the description")), "description")
    names = [buffer.text(width, "channel names") for _ in range(channels + 1)]
    units = [buffer.text(width, "channel units").strip("()[]") for _ in range(channels + 1)]
    if form == _WITH_TIME:
        packed_time = buffer.take("<i4", samples, "packed time")
    kind = "<f8" if form == _UNCOMPRESSED else "<i2"
    packed = buffer.take(kind, samples * channels, "channel data").reshape(samples, channels)
    if form == _WITH_TIME:
        time = (packed_time - time_offset) / time_scale
    else:
        time = time_start + time_step * np.arange(samples)
    if form != _UNCOMPRESSED:
        if np.any(slope == 0) or not np.all(np.isfinite([slope, offset])):
            raise FormatError(
                path, expected="finite channel slopes other than zero and offsets", found="zero, NaN or infinity"
            )
        data = (packed - offset) / slope
    else:
        data = packed.astype(float)
    series = checked_series(path, time, data, names[1:], units[1:], description)
    return replace(series, trailing_bytes=len(content) - buffer.at)


def _finite(path: Path, values: np.ndarray, what: str) -> np.ndarray:
    if not np.all(np.isfinite(values)):
        raise FormatError(path, expected=f"finite {what}", found="NaN or infinity")
    return values


def _read_text(path: Path) -> TimeSeries:
    lines = read_lines(path)
    head = next(
        (i for i, line in enumerate(lines[:50]) if line.split()[:1] and line.split()[0].lower() == "time"), None
    )
    if head is None or head + 1 >= len(lines):
        raise FormatError(
            path, expected="a heading line that begins with Time", found=next(x for x in lines if x.strip())
        )
    names = _columns(lines[head])
    first = head + 1
    try:
        numbers(lines[first])
        units = [""] * len(names)
    except ValueError:
        units = [u.strip("()[]") for u in _columns(lines[first])]
        first += 1
    if len(units) != len(names):
        raise FormatError(path, first, expected=f"{len(names)} units", found=lines[first - 1])
    table = number_table(path, lines[first:], first + 1, len(names), "a row of time series")
    if not table.size:
        raise FormatError(path, first, expected="rows of numbers", found="none")
    return checked_series(path, table[:, 0], table[:, 1:], names[1:], units[1:], " ".join(lines[:head]).strip())


def _columns(line: str) -> list[str]:
    """Return the headings of a line, between tabs when it has any."""
    return [part.strip() for part in line.strip().split("\t")] if "\t" in line.strip() else line.split()


def checked_series(path, time, data, names, units, description) -> TimeSeries:
    """Return a time series after the checks that all its forms share; raise FormatError."""
    if len(time) > 1 and np.any(np.diff(time) <= 0):
        k = int(np.argmax(np.diff(time) <= 0))
        raise FormatError(path, expected="time that ascends", found=f"{time[k + 1]:g} s after {time[k]:g} s")
    bad = ~np.isfinite(data).all(axis=0)
    if np.any(bad):
        raise FormatError(path, expected="finite numbers", found=f"NaN or infinity in {names[int(np.argmax(bad))]}")
    if len({n.lower() for n in names}) < len(names):
        twice = next(n for k, n in enumerate(names) if n.lower() in [m.lower() for m in names[:k]])
        if not np.array_equal(*(data[:, [k for k, n in enumerate(names) if n.lower() == twice.lower()][:2]]).T):
            raise FormatError(
                path, expected="channels of different names", found=f"{twice} twice with different values"
            )
    for array in (time, data):
        array.setflags(write=False)
    return TimeSeries(
        time=time, data=data, names=tuple(names), units=tuple(units), description=description, source=str(path)
    )


def _recognises(path, head: bytes) -> bool:
    if is_outb(head):
        at = 4 if head[:2] == b"\x04\x00" else 2
        channels, steps = struct.unpack_from("<ii", head, at) if len(head) >= at + 8 else (0, 0)
        return 0 < channels < 100_000 and steps > 0
    lines = head_lines(head)
    at = next((i for i, line in enumerate(lines[:50]) if line.split()[:1] and line.split()[0].lower() == "time"), None)
    if at is None or at + 1 >= len(lines) or len(_columns(lines[at])) < 2:
        return False
    units = _columns(lines[at + 1])
    return len(units) == len(_columns(lines[at])) and units[0].strip("()[]").lower() in ("s", "sec")


def describe_series(series: TimeSeries) -> list[tuple[str, str]]:
    """Return what a time series holds, as (label, text) rows."""
    step = float(np.median(np.diff(series.time))) if len(series.time) > 1 else 0.0
    names = ", ".join(f"{n} ({u})" if u else n for n, u in zip(series.names[:8], series.units, strict=False))
    return [
        ("time", f"{series.time[0]:g} to {series.time[-1]:g} s, {len(series.time)} samples, step {step:g} s"),
        ("channels", f"{len(series.names)}: {names}" + (", ..." if len(series.names) > 8 else "")),
        ("description", series.description or "none"),
    ]


def series_problems(series: TimeSeries) -> list[str]:
    """Return what is doubtful in a time series: bytes behind its end, steps that vary, channels without units."""
    out, steps = [], np.diff(series.time)
    if series.trailing_bytes:
        out.append(
            f"{series.trailing_bytes} bytes behind the last sample that the header counts: written over a longer file?"
        )
    if len(steps) and np.ptp(steps) > 1e-3 * np.median(steps):
        out.append(f"the time step varies from {steps.min():g} to {steps.max():g} s")
    bare = [n for n, u in zip(series.names, series.units, strict=True) if not u]
    if bare:
        out.append(
            f"{len(bare)} {'channel' if len(bare) == 1 else 'channels'} without a unit: {', '.join(bare[:6])}{', ...' if len(bare) > 6 else ''}"
        )
    return out


OPENFAST_OUT = Format(
    name="OpenFAST time series (.outb, .out)",
    recognises=_recognises,
    read=read_openfast_out,
    describe=describe_series,
    problems=series_problems,
)
