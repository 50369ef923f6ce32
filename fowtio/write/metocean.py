"""Metocean records as clean CSV: UTC, SI, ascending, each time once, missing values empty."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fowtio.read.metocean import Metocean
from fowtio.write.atomic import atomic_file

HEADINGS = {
    "wind_speed": "wind speed (m/s)",
    "wind_deviation": "standard deviation of wind speed (m/s)",
    "significant_height": "significant wave height (m)",
    "peak_period": "peak period (s)",
    "zero_crossing_period": "zero-up-crossing period (s)",
    "wind_heading": "wind from direction (deg)",
    "wave_heading": "wave from direction (deg)",
}


def write_metocean(record: Metocean, path: str | Path, *, x_bearing: float = 90.0) -> Path:
    """Write a metocean record as CSV and return its path.

    Directions are written as compass bearings that wind and waves come from; x_bearing is the bearing of the +x axis
    [deg], as the record was read with. Numbers are written in full, so that reading gives them back.
    """
    names = [name for name in HEADINGS if name in record.values]
    columns = [_column(record.values[name], name.endswith("heading"), x_bearing) for name in names]
    stamps = np.datetime_as_string(record.time, unit="s")
    with atomic_file(path) as temporary, temporary.open("w", encoding="utf-8") as stream:
        stream.write(",".join(["time (UTC)", *(HEADINGS[name] for name in names)]) + "\n")
        stream.writelines(",".join(row) + "\n" for row in zip((f"{t}Z" for t in stamps), *columns, strict=True))
    return Path(path)


def _column(values: np.ndarray, angle: bool, x_bearing: float) -> list[str]:
    """Return a quantity as texts, empty where it is missing."""
    numbers = np.mod(x_bearing - np.degrees(values) - 180.0, 360.0) if angle else values
    return ["" if v != v else repr(v) for v in numbers.tolist()]
