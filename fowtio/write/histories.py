"""Time histories as a CSV file."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fowtio.write.atomic import atomic_file
from model.response.histories import Histories


def write_histories(series: Histories, path: str | Path) -> Path:
    """Write time, wave elevation, wind and every channel, SI units in the heading; the file appears whole or not at all."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    names = ["Time (s)", "Wave1Elev (m)", "RotorWind (m/s)", *(f"{n} ({u})" for n, u in zip(series.names, series.units, strict=True))]
    table = np.column_stack([series.time, series.elevation, series.wind, series.data])
    with atomic_file(path) as temporary:
        np.savetxt(temporary, table, fmt="%.7g", delimiter=",", header=",".join(names), comments="", encoding="utf-8")
    return path
