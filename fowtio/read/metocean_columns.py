"""Columns of metocean records: what quantity a heading means, in which unit, and what of a value is believable."""

from __future__ import annotations

import re
from dataclasses import dataclass

KNOT = 1852 / 3600
_DEG = 3.141592653589793 / 180


@dataclass(frozen=True, kw_only=True)
class Quantity:
    """A quantity of a record: headings that mean it (regular expressions, whole heading, lower case, words apart by
    single blanks), units by lower-case name with their factor to SI, the believable range in SI, and what it is in
    words.
    """

    patterns: tuple[str, ...]
    units: dict[str, float]
    low: float
    high: float
    what: str


_SPEED = {
    "m/s": 1.0,
    "m s-1": 1.0,
    "m s**-1": 1.0,
    "ms-1": 1.0,
    "m.s-1": 1.0,
    "kn": KNOT,
    "kt": KNOT,
    "kts": KNOT,
    "knot": KNOT,
    "knots": KNOT,
    "km/h": 1 / 3.6,
    "kmh": 1 / 3.6,
    "mph": 0.44704,
    "ft/s": 0.3048,
}
_LENGTH = {"m": 1.0, "metre": 1.0, "metres": 1.0, "meter": 1.0, "meters": 1.0, "cm": 0.01, "ft": 0.3048, "feet": 0.3048}
_TIME = {"s": 1.0, "sec": 1.0, "second": 1.0, "seconds": 1.0}
_ANGLE = {
    "deg": _DEG,
    "degree": _DEG,
    "degrees": _DEG,
    "°": _DEG,
    "degt": _DEG,
    "degrees_true": _DEG,
    "degree_true": _DEG,
    "rad": 1.0,
    "radians": 1.0,
}

_HEIGHT = r"( (at )?\d+ ?m?( height)?)?"
QUANTITIES = {
    "wind_speed": Quantity(
        patterns=(
            rf"u\d*{_HEIGHT}",
            r"ws\d*",
            "wspd",
            "wind",
            r"ff\d*",
            r"wnd",
            rf"(\d+[ -]?h(ou)?r )?(mean |hub |average )*wind ?speed( mean| avg)?{_HEIGHT}",
            r"u ?hub",
            r"uw",
            r"wind_?speed_?\d*m?",
        ),
        units=_SPEED,
        low=0.0,
        high=80.0,
        what="wind speed",
    ),
    "significant_height": Quantity(
        patterns=(
            "hs",
            "hm0",
            "swh",
            "wvht",
            "vhm0",
            "h ?1/3",
            "(combined |total )?significant (wave )?height.*",
            "sea surface wave significant height",
            "wave ?height",
            "hsig",
        ),
        units=_LENGTH,
        low=0.0,
        high=35.0,
        what="significant wave height",
    ),
    "peak_period": Quantity(
        patterns=(
            "tp",
            "dpd",
            "pp1d",
            "vtpk",
            "peak (wave |spectral )?period",
            "(wave |spectral )?peak period",
            "dominant (wave )?period",
            "sea surface wave period at variance spectral density maximum",
            "tpeak",
        ),
        units=_TIME,
        low=0.5,
        high=40.0,
        what="peak period",
    ),
    "zero_crossing_period": Quantity(
        patterns=(
            "tz",
            "t02",
            "tm02",
            "mp2",
            "vtm02",
            "apd",
            "zero[ -]?(up|down)?[ -]?crossing (wave )?period",
            "mean zero.*period",
        ),
        units=_TIME,
        low=0.5,
        high=40.0,
        what="zero-up-crossing period",
    ),
    "wind_deviation": Quantity(
        patterns=(
            "sigma",
            "std",
            "sigma ?u",
            "wind ?speed ?(std|sd|sigma)",
            "standard deviation( of wind speed)?",
            "ws ?std",
        ),
        units=_SPEED,
        low=0.0,
        high=20.0,
        what="standard deviation of the wind speed",
    ),
    "wind_heading": Quantity(
        patterns=(
            "wdir",
            "wd",
            "dd",
            r"wind (from |to |coming from |going to )?dir(ection)?.*",
            r"wind_?dir(ection)?.*",
        ),
        units=_ANGLE,
        low=-2 * 180 * _DEG,
        high=4 * 180 * _DEG,
        what="wind direction",
    ),
    "wave_heading": Quantity(
        patterns=(
            "mwd",
            "dirm",
            "vmdr",
            "thq",
            "pdir",
            "wavedir.*",
            r"(mean |peak )?(sea surface )?wave (from |to |coming from |going to )?dir(ection)?.*",
            "dp",
            "dir",
        ),
        units=_ANGLE,
        low=-2 * 180 * _DEG,
        high=4 * 180 * _DEG,
        what="wave direction",
    ),
}
HEADINGS = ("wind_heading", "wave_heading")
_TOWARDS = re.compile(r"\b(to|towards?|going to|propagation)\b")
_FROM = re.compile(r"\b(from|coming)\b|^mwd$|^wdir$|^vmdr$")
_UNIT = re.compile(r"[\[(]\s*([^\[\]()]*?)\s*[\])]\s*$")


def split_heading(heading: str) -> tuple[str, str]:
    """Return a heading as lower-case words apart by single blanks, and the unit in brackets it ends with, or ""."""
    found = _UNIT.search(heading)
    unit = found[1].strip().lower() if found else ""
    name = _UNIT.sub("", heading) if found else heading
    return " ".join(name.replace("_", " ").lower().split()), unit


def quantities_of(heading: str) -> list[str]:
    """Return the quantities that a heading may mean: none, one, or more when it is ambiguous."""
    name, _ = split_heading(heading)
    return [key for key, q in QUANTITIES.items() if any(re.fullmatch(p, name) for p in q.patterns)]


def direction_sense(heading: str) -> str:
    """Return "from" or "to" where a heading says so, else ""."""
    name, unit = split_heading(heading)
    text = f"{name} {unit}"
    if _TOWARDS.search(text):
        return "to"
    return "from" if _FROM.search(text) or _FROM.search(name) else ""
