"""Metocean records, wind and waves over time, from CSV, TSV, blank-separated text, xlsx and netCDF.

Whatever is wrong with a record is counted in a report, and a doubtful value becomes NaN: it is never used silently.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from fowtio.errors import FormatError
from fowtio.read.metocean_columns import HEADINGS, QUANTITIES, direction_sense, quantities_of, split_heading
from fowtio.read.metocean_table import is_heading, read_table, split_line
from fowtio.read.metocean_time import TIME_PARTS, is_time, time_parts, times
from fowtio.read.registry import Format, head_lines, span

_MISSING_TEXT = {"", "nan", "na", "n/a", "null", "none", "-", "--", "mm", "nat"}
SENTINELS = (
    -999.0,
    -9999.0,
    -99.0,
    -999.9,
    -9999.9,
    -32767.0,
    -32768.0,
    99.0,
    999.0,
    9999.0,
    99.9,
    999.9,
    9999.9,
    1e20,
    9.969209968386869e36,
)


@dataclass(frozen=True, kw_only=True)
class MetoceanReport:
    """What was found in a record and what was done: rows read; columns as (quantity, heading, unit, factor to SI);
    counts by quantity of values missing, sentinel (such as -999), out_of_range and unreadable, all NaN now;
    bad_times, rows dropped because their time cannot be read; duplicates, rows dropped because they repeat
    another; conflicting, rows dropped because they contradict another of the same time, which is NaN now;
    unsorted, rows that stood before an earlier one; step [s] most often found; gaps and missing_steps; notes of
    what was assumed.
    """

    rows: int
    columns: tuple[tuple[str, str, str, float], ...]
    missing: Mapping[str, int]
    sentinel: Mapping[str, int]
    out_of_range: Mapping[str, int]
    unreadable: Mapping[str, int]
    bad_times: int
    duplicates: int
    conflicting: int
    unsorted: int
    step: float
    gaps: int
    missing_steps: int
    notes: tuple[str, ...] = ()

    @property
    def clean(self) -> bool:
        """Whether nothing at all was wrong."""
        counts = (self.bad_times, self.duplicates, self.conflicting, self.unsorted, self.gaps)
        return not any(counts) and not any(
            n for m in (self.missing, self.sentinel, self.out_of_range, self.unreadable) for n in m.values()
        )


@dataclass(frozen=True, eq=False, kw_only=True)
class Metocean:
    """A metocean record: time (n), UTC, ascending; values by quantity (n), SI, NaN where doubtful; its report; source.

    Quantities: wind_speed, wind_deviation [m/s], significant_height [m], peak_period, zero_crossing_period [s],
    wind_heading, wave_heading [rad] of propagation, 0 along +x, counter-clockwise, in [0, 2 pi).
    """

    time: np.ndarray
    values: Mapping[str, np.ndarray]
    report: MetoceanReport
    source: str = ""

    def __getitem__(self, quantity: str) -> np.ndarray:
        """Return one quantity; raise FormatError naming those there are."""
        if quantity not in self.values:
            raise FormatError(self.source, expected=f"a column of {quantity}", found=", ".join(self.values))
        return self.values[quantity]

    def complete(self, *quantities: str) -> np.ndarray:
        """Return the rows (m, k) in which all the quantities (default: all) are there."""
        names = quantities or tuple(self.values)
        table = np.stack([self[name] for name in names], axis=1)
        return table[np.isfinite(table).all(axis=1)]


@dataclass
class _Count:
    """Counts of what is wrong, by quantity."""

    missing: dict = field(default_factory=dict)
    sentinel: dict = field(default_factory=dict)
    out_of_range: dict = field(default_factory=dict)
    unreadable: dict = field(default_factory=dict)
    notes: list = field(default_factory=list)


def read_metocean(
    path: str | Path, *, columns: Mapping[str, str] | None = None, units: Mapping[str, str] | None = None,
    direction: str | None = None, x_bearing: float = 90.0, time_zone: str = "UTC", day_first: bool | None = None,
    sentinels: tuple[float, ...] = SENTINELS,
) -> Metocean:  # fmt: skip
    """Return a metocean record with a report of everything wrong in it.

    Parameters
    ----------
    path : CSV, TSV or blank-separated text, xlsx or netCDF
    columns : heading by quantity ("wind_speed", ...) and of "time"; default: found by common names
    units : unit by quantity; default: what the heading says in brackets (netCDF: the attribute), else SI and degrees
    direction : "from" or "to", what directions in the file mean; default: what headings say, else "from", with a note
    x_bearing : compass bearing of the +x axis [deg, clockwise from north]; 90 puts x to the east and y to the north
    time_zone : of times without their own
    day_first : whether 01/02/2020 is 1 February; needed only where both readings are possible
    sentinels : numbers that stand for missing values; those within the believable range of a quantity are kept

    Raises
    ------
    FormatError : no column of time or of any quantity, two columns for one quantity, an unknown unit, unreadable times.
    """
    path = Path(path)
    table, attributes = read_table(path)
    given = dict(columns or {})
    clock = set() if "time" in given else set(time_parts(table).values())
    names = _chosen(path, [h for h in table if h not in clock], given)
    count = _Count()
    time = times(path, table, given.get("time"), time_zone, day_first, count.notes)
    values, used = {}, []
    for quantity, heading in names.items():
        unit, factor = _unit(path, quantity, heading, (units or {}).get(quantity) or attributes.get(heading, ""))
        raw = _numbers(table[heading], quantity, count)
        values[quantity] = _believable(raw, factor, quantity, sentinels, count)
        used.append((quantity, heading, unit, factor))
    for quantity in HEADINGS:
        if quantity in values:
            sense = direction or direction_sense(names[quantity])
            if not sense:
                count.notes.append(
                    f"{names[quantity]}: taken as the direction it comes from; say direction='to' if not"
                )
            bearing = np.degrees(values[quantity]) + (0.0 if sense == "to" else 180.0)
            values[quantity] = np.radians((x_bearing - bearing) % 360)
    return _ordered(path, time, values, tuple(used), count, len(table))


# --- columns ----------------------------------------------------------------------------------------------------------


def _chosen(path: Path, headings: list[str], given: dict[str, str]) -> dict[str, str]:
    """Return the heading of each quantity, given or found."""
    out = {}
    for quantity, heading in given.items():
        if quantity not in (*QUANTITIES, "time"):
            raise FormatError(path, expected=f"quantities {', '.join(QUANTITIES)}", found=quantity)
        if heading not in headings:
            raise FormatError(path, expected=f"a column {heading!r} for {quantity}", found=", ".join(headings))
    for quantity in QUANTITIES:
        if quantity in given:
            out[quantity] = given[quantity]
            continue
        found = [h for h in headings if quantity in quantities_of(h) and h not in given.values()]
        found = [h for h in found if len(quantities_of(h)) == 1] or found
        if len(found) > 1:
            hint = f"Choose one: columns={{{quantity!r}: {found[0]!r}}}"
            raise FormatError(
                path, expected=f"one column of {QUANTITIES[quantity].what}", found=", ".join(found), hint=hint
            )
        if found and found[0] not in out.values():
            out[quantity] = found[0]
    if not out:
        raise FormatError(
            path, expected="columns of wind or waves", found=", ".join(headings), hint="Name them with columns={...}"
        )
    return out


def _unit(path: Path, quantity: str, heading: str, given: str) -> tuple[str, float]:
    """Return the unit of a column and its factor to SI."""
    known = QUANTITIES[quantity].units
    unit = (given or split_heading(heading)[1]).lower().strip()
    if not unit or unit in ("-", "1"):
        unit = "deg" if quantity in HEADINGS else next(iter(known))
    if unit not in known:
        raise FormatError(
            path, expected=f"a unit of {quantity}: {', '.join(known)}", found=unit, hint="Give it with units={...}"
        )
    return unit, known[unit]


def _numbers(column, quantity: str, count: _Count) -> np.ndarray:
    """Return a column as numbers; what is no number is NaN and counted, missing apart from unreadable."""
    import pandas as pd

    values = pd.to_numeric(column, errors="coerce").to_numpy(dtype=float)
    bad = ~np.isfinite(values)
    text = column[bad].map(lambda t: str(t).strip().lower())
    missing = int(text.isin(_MISSING_TEXT).sum())
    count.missing[quantity], count.unreadable[quantity] = missing, int(bad.sum()) - missing
    return np.where(bad, np.nan, values)


def _believable(
    raw: np.ndarray, factor: float, quantity: str, sentinels: tuple[float, ...], count: _Count
) -> np.ndarray:
    """Return values in SI; sentinels and what is out of the believable range are NaN and counted."""
    q = QUANTITIES[quantity]
    values = raw * factor
    outside = (values < q.low) | (values > q.high)
    sentinel = outside & np.isclose(raw[:, None], np.array(sentinels), rtol=1e-6, atol=0).any(axis=1)
    count.sentinel[quantity] = int(sentinel.sum())
    count.out_of_range[quantity] = int((outside & ~sentinel).sum())
    return np.where(outside, np.nan, values)


# --- order ------------------------------------------------------------------------------------------------------------


def _ordered(path: Path, time: np.ndarray, values: dict, used: tuple, count: _Count, rows: int) -> Metocean:
    """Return the record sorted by time, each time once, with its report."""
    bad = np.isnat(time)
    if bad.all():
        raise FormatError(path, expected="times that can be read", found="none in the column of time")
    time, values = time[~bad], {k: v[~bad] for k, v in values.items()}
    unsorted = int(np.sum(np.diff(time) < np.timedelta64(0)))
    order = np.argsort(time, kind="stable")
    time, values = time[order], {k: v[order] for k, v in values.items()}
    time, values, duplicates, conflicting = _single(time, values)
    seconds = np.diff(time) / np.timedelta64(1, "s")
    step = float(np.median(seconds)) if len(seconds) else 0.0
    holes = np.round(seconds / step).astype(int) - 1 if step > 0 else np.zeros(0, dtype=int)
    report = MetoceanReport(
        rows=rows,
        columns=used,
        missing=count.missing,
        sentinel=count.sentinel,
        out_of_range=count.out_of_range,
        unreadable=count.unreadable,
        bad_times=int(bad.sum()),
        duplicates=duplicates,
        conflicting=conflicting,
        unsorted=unsorted,
        step=step,
        gaps=int(np.sum(holes > 0)),
        missing_steps=int(holes[holes > 0].sum()),
        notes=tuple(count.notes),
    )
    for array in (time, *values.values()):
        array.setflags(write=False)
    return Metocean(time=time, values=values, report=report, source=str(path))


def _single(time: np.ndarray, values: dict) -> tuple:
    """Return the record with every time once; where rows of one time differ the quantity is NaN."""
    unique, first, inverse, times = np.unique(time, return_index=True, return_inverse=True, return_counts=True)
    if len(unique) == len(time):
        return time, values, 0, 0
    table = np.stack([*values.values()], axis=1)
    reference = table[first][inverse]
    differs = ~((table == reference) | (np.isnan(table) & np.isnan(reference)))
    clash = np.zeros((len(unique), table.shape[1]), dtype=bool)
    np.logical_or.at(clash, inverse, differs)
    out = np.where(clash, np.nan, table[first])
    conflicting = int((times[clash.any(axis=1)] - 1).sum())
    return unique, dict(zip(values, out.T.copy(), strict=True)), len(time) - len(unique) - conflicting, conflicting


def _recognises(path, head: bytes) -> bool:
    if head.startswith((b"CDF", b"\x89HDF")):
        return True
    if head.startswith(b"PK\x03\x04"):
        return Path(path).suffix.lower() in (".xlsx", ".xlsm")
    for line in head_lines(head)[:50]:
        if is_heading(line):
            separator = next((s for s in ("\t", ";", ",") if s in line), None)
            parts = split_line(line.lstrip("# "), separator)
            return any(is_time(p) or split_heading(p)[0] in TIME_PARTS["year"] for p in parts) and any(
                quantities_of(p) for p in parts
            )
    return False


def _describe(record: Metocean) -> list[tuple[str, str]]:
    r = record.report
    first, last = (_day(t) for t in record.time[[0, -1]])
    rows = [
        ("time", f"{first} to {last} UTC"),
        ("rows", f"{r.rows} read, {len(record.time)} kept, one every {r.step:g} s"),
    ]
    for quantity, heading, unit, factor in r.columns:
        unit_si, scale = ("deg", 180 / np.pi) if quantity in HEADINGS else (next(iter(QUANTITIES[quantity].units)), 1.0)
        column = f"column {heading!r}, {unit}" + ("" if factor == 1 or quantity in HEADINGS else f" x {factor:.6g}")
        values = span(record.values[quantity], unit_si, scale)
        rows.append(
            (quantity.replace("_", " "), f"{values}, {np.isfinite(record.values[quantity]).sum()} values ({column})")
        )
    headings = [q for q in HEADINGS if q in record.values]
    if headings:
        rows.append(("directions", "of propagation, 0 towards +x (east), counter-clockwise"))
    return rows + [("assumed", note) for note in r.notes]


_WRONG = {
    "missing": "blank or marked as missing",
    "sentinel": "a number that stands for a missing one (such as -999)",
    "out_of_range": "beyond belief",
    "unreadable": "no number",
}


def metocean_problems(record: Metocean) -> list[str]:
    """Return everything that is wrong with a record, with counts."""
    r, out = record.report, []
    for quantity, *_ in r.columns:
        name, known = quantity.replace("_", " "), QUANTITIES[quantity]
        for what, text in _WRONG.items():
            number = getattr(r, what)[quantity]
            limits = (
                f", outside {known.low:g} to {known.high:g} {next(iter(known.units))}" if what == "out_of_range" else ""
            )
            if number:
                out.append(f"{name}, {_count(number, 'value')}: {text}{limits}; taken as missing")
        empty = np.flatnonzero(np.isnan(record.values[quantity]))
        if len(empty):
            out.append(f"{name}: missing at {_count(len(empty), 'time')}, first {_day(record.time[empty[0]])}")
    rows = {
        "without a time that can be read; left out": r.bad_times,
        "repeating another; left out": r.duplicates,
        "contradicting another of the same time; the value is taken as missing": r.conflicting,
        "standing before an earlier one; put in order": r.unsorted,
    }
    out += [f"{_count(n, 'row')} {text}" for text, n in rows.items() if n]
    if r.gaps:
        steps = np.diff(record.time)
        longest = ", ".join(
            f"{_day(record.time[k])} to {_day(record.time[k + 1])}" for k in np.argsort(-steps)[: min(3, r.gaps)]
        )
        out.append(f"{_count(r.gaps, 'gap')}, {_count(r.missing_steps, 'step')} missing; the longest: {longest}")
    return out


def _count(number: int, what: str) -> str:
    return f"{number} {what}" if number == 1 else f"{number} {what}s"


def _day(time: np.datetime64) -> str:
    return str(np.datetime_as_string(time, unit="m")).replace("T", " ")


METOCEAN = Format(
    name="Metocean record (CSV, TSV, text, xlsx, netCDF)",
    recognises=_recognises,
    read=read_metocean,
    describe=_describe,
    problems=metocean_problems,
)
