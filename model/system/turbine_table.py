"""The turbine's matrices tabulated over the wind speed, and at any speed between."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.conventions import PLATFORM_DOFS, freeze
from model.system.turbine import TurbineMatrices

_SAME_SPEED = 1e-9


@dataclass(frozen=True, eq=False, kw_only=True)
class TurbineTable:
    """Matrices of a turbine on its tower at p operating points, about the reference point, as in TurbineMatrices.

    dofs (q) names, the six platform motions first; wind_speed (p) [m/s] ascending, 0 is parked; rotor_speed (p) [rad/s];
    blade_pitch (p) [rad]; mass, damping, stiffness (p, q, q); force (p, q) at the place point (p, q); wind_force (p, q) per
    m/s; source.
    """

    dofs: tuple[str, ...]
    wind_speed: np.ndarray
    rotor_speed: np.ndarray
    blade_pitch: np.ndarray
    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    force: np.ndarray
    point: np.ndarray
    wind_force: np.ndarray
    source: str = ""

    def __post_init__(self):
        q = len(self.dofs)
        if self.dofs[: len(PLATFORM_DOFS)] != PLATFORM_DOFS:
            raise ValueError(f"degrees of freedom are {', '.join(self.dofs)}; the six platform motions come first")
        freeze(
            self, wind_speed=("p",), rotor_speed=("p",), blade_pitch=("p",), mass=("p", q, q), damping=("p", q, q),
            stiffness=("p", q, q), force=("p", q), point=("p", q), wind_force=("p", q),
        )  # fmt: skip
        if np.any(np.diff(self.wind_speed) <= 0):
            raise ValueError("wind speeds must ascend")

    def covers(self, wind_speed: float) -> bool:
        """Whether matrices follow at a wind speed [m/s]: tabulated, or between two operating points with wind."""
        windy = self.wind_speed[self.wind_speed > 0]
        inside = len(windy) > 0 and windy[0] <= wind_speed <= windy[-1]
        return bool(inside or np.any(np.abs(self.wind_speed - wind_speed) < _SAME_SPEED))

    @property
    def span(self) -> str:
        """The wind speeds covered, in words."""
        windy = self.wind_speed[self.wind_speed > 0]
        parts = ["0 (parked)"] if self.wind_speed[0] == 0 else []
        return " and ".join([*parts, f"{windy[0]:g} to {windy[-1]:g} m/s"] if len(windy) else parts)


def turbine_at(table: TurbineTable, wind_speed: float) -> TurbineMatrices:
    """Return the turbine at a wind speed [m/s] at hub height, linear between operating points; raises ValueError elsewhere."""
    if not table.covers(wind_speed):
        raise ValueError(f"the wind speed is {wind_speed:g} m/s; {table.source} has data at {table.span}")
    speeds = table.wind_speed
    high = int(np.searchsorted(speeds, wind_speed - _SAME_SPEED))
    low = high if abs(speeds[high] - wind_speed) < _SAME_SPEED else high - 1
    share = 0.0 if low == high else (wind_speed - speeds[low]) / (speeds[high] - speeds[low])
    names = ("mass", "damping", "stiffness", "force", "point", "wind_force")
    values = {n: (1 - share) * getattr(table, n)[low] + share * getattr(table, n)[high] for n in names}
    return TurbineMatrices(
        dofs=table.dofs, **values, wind_speed=wind_speed,
        rotor_speed=float((1 - share) * table.rotor_speed[low] + share * table.rotor_speed[high]),
        source=table.source + ("" if low == high else f", between {speeds[low]:g} and {speeds[high]:g} m/s"),
    )  # fmt: skip
