"""Times of metocean records: which columns give them, how they are written, and in which zone."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from fowtio.errors import FormatError
from fowtio.read.metocean_columns import split_heading

_TIME_NAMES = ("time", "date", "datetime", "timestamp", "date time", "valid time", "time utc", "zeit")
TIME_PARTS = {
    "year": ("year", "yyyy", "yy", "yr"),
    "month": ("month", "mm", "mo", "mon"),
    "day": ("day", "dd", "dy"),
    "hour": ("hour", "hh", "hr"),
    "minute": ("minute", "mn", "min", "mm"),
}


def is_time(heading: str) -> bool:
    """Tell whether a heading means a time or date."""
    name = split_heading(heading)[0]
    return name in _TIME_NAMES or name.startswith(("time", "date"))


def times(path: Path, table, given: str | None, zone: str, day_first: bool | None, notes: list[str]) -> np.ndarray:
    """Return the times (n) of the rows as datetime64[ns] in UTC, NaT where they cannot be read."""
    import pandas as pd

    parts = time_parts(table)
    if given is None and "year" in parts:
        frame = pd.DataFrame({k: pd.to_numeric(table[h], errors="coerce") for k, h in parts.items()})
        frame["year"] = frame["year"].where(
            frame["year"] > 99, frame["year"] + np.where(frame["year"] < 70, 2000, 1900)
        )
        stamps = pd.to_datetime(frame, errors="coerce")
    else:
        found = [h for h in table if is_time(h)]
        heading = given or (found[0] if found else None)
        if heading is None:
            raise FormatError(
                path, expected="a column of time", found=", ".join(table), hint="Name it with columns={'time': ...}"
            )
        stamps = _stamps(path, table[heading], day_first, notes)
    if getattr(stamps.dtype, "tz", None) is None:
        try:
            local = stamps.dt.tz_localize(zone, ambiguous="NaT", nonexistent="NaT")
        except Exception as error:  # pandas passes on the errors of the library of time zones
            raise FormatError(
                path, expected="a time zone such as 'UTC' or 'Europe/Oslo'", found=zone, hint=str(error)
            ) from None
    else:
        local = stamps
    return local.dt.tz_convert("UTC").dt.tz_localize(None).to_numpy(dtype="datetime64[ns]")


def time_parts(table) -> dict[str, str]:
    """Return the headings of year, month, day, hour and minute where the file has a column for each."""
    plain = {}
    for heading in table:
        plain.setdefault(heading.strip("# "), heading)
    exact = {"YY": "year", "YYYY": "year", "MM": "month", "DD": "day", "hh": "hour", "mm": "minute"}
    out = {part: plain[name] for name, part in exact.items() if name in plain}
    if {"year", "month", "day"} <= set(out):
        return out
    lower = {split_heading(h)[0]: h for h in table}
    out = {part: next((lower[n] for n in names if n in lower), None) for part, names in TIME_PARTS.items()}
    return {k: v for k, v in out.items() if v is not None} if out["year"] and out["month"] and out["day"] else {}


def _stamps(path: Path, column, day_first: bool | None, notes: list[str]):
    """Return a column of times as pandas timestamps."""
    import pandas as pd

    if column.dtype.kind == "M" or not all(isinstance(t, str) for t in column.head(20)):
        stamps = pd.to_datetime(
            column, errors="coerce", utc=column.map(lambda t: getattr(t, "tzinfo", None) is not None).any()
        )
        if pd.api.types.is_numeric_dtype(pd.to_numeric(column, errors="coerce")) and column.dtype.kind in "if":
            raise FormatError(
                path,
                expected="dates",
                found=f"numbers such as {column.iloc[0]}",
                hint="Write times as year-month-day hour:minute",
            )
        return stamps
    text = column.str.strip()
    first = text.iloc[0]
    if re.fullmatch(r"-?\d+ days?.*", first):
        notes.append("times count from 1970-01-01: the file gives durations")
        return pd.Timestamp(0) + pd.to_timedelta(text, errors="coerce")
    if re.fullmatch(r"\d{4}-\d{2}-\d{2}-\d{2}", first):
        return pd.to_datetime(text, format="%Y-%m-%d-%H", errors="coerce")
    if re.match(r"\d{1,2}[/.-]\d{1,2}[/.-]\d{2,4}", first):
        return _day_and_month(path, text, day_first)
    if re.fullmatch(r"[-+]?\d+(\.\d*)?", first) and len(first.split(".")[0]) not in (8, 10, 12, 14):
        raise FormatError(
            path, expected="dates", found=f"numbers such as {first}", hint="Write times as year-month-day hour:minute"
        )
    form = (
        {8: "%Y%m%d", 10: "%Y%m%d%H", 12: "%Y%m%d%H%M", 14: "%Y%m%d%H%M%S"}.get(len(first))
        if first.isdigit()
        else "ISO8601"
    )
    zoned = text.str.contains(r"(?:Z|[+-]\d{2}:?\d{2})$")
    stamps = pd.to_datetime(text, format=form, errors="coerce", utc=True)
    return stamps.where(zoned) if zoned.any() else stamps.dt.tz_localize(None)


def _day_and_month(path: Path, text, day_first: bool | None):
    """Return dates of the form 01/02/2020; raise FormatError where both readings are possible and none is chosen."""
    import pandas as pd

    if day_first is None:
        first, second = (pd.to_numeric(text.str.split(r"[/.-]", regex=True).str[k], errors="coerce") for k in (0, 1))
        if first.max() > 12:
            day_first = True
        elif second.max() > 12:
            day_first = False
        else:
            raise FormatError(
                path,
                expected="dates that can be read in one way",
                found=text.iloc[0],
                hint="Say day_first=True or False",
            )
    return pd.to_datetime(text, dayfirst=day_first, errors="coerce", format="mixed")
