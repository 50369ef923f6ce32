"""Steady current over depth, as OpenFAST's SeaState defines it: sub-surface, near-surface and depth-independent parts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, kw_only=True)
class Current:
    """A current: sub_surface speed at still water [m/s] with the 1/7 power law, near_surface speed falling linearly to zero at
    near_surface_depth [m], depth_independent speed; each with its direction of propagation [rad]; depth of the water [m].
    """

    sub_surface: float = 0.0
    sub_surface_heading: float = 0.0
    near_surface: float = 0.0
    near_surface_depth: float = 20.0
    near_surface_heading: float = 0.0
    depth_independent: float = 0.0
    depth_independent_heading: float = 0.0
    depth: float = np.inf

    @property
    def still(self) -> bool:
        """Whether there is no current at all."""
        return self.sub_surface == self.near_surface == self.depth_independent == 0.0


def current_velocity(current: Current, z) -> np.ndarray:
    """Return the current's velocity (..., 3) [m/s] at heights z (...) [m], zero above still water.

    Sub-surface V0 ((z + d) / d)^(1/7), near-surface V0 (z + h) / h above -h (SeaState theory manual, current section).
    """
    z = np.asarray(z, dtype=float)
    wet = z <= 0
    share = np.ones_like(z) if np.isinf(current.depth) else np.clip((z + current.depth) / current.depth, 0.0, 1.0)
    parts = (
        (current.sub_surface * share ** (1 / 7), current.sub_surface_heading),
        (current.near_surface * np.clip((z + current.near_surface_depth) / current.near_surface_depth, 0.0, 1.0), current.near_surface_heading),
        (current.depth_independent * np.ones_like(z), current.depth_independent_heading),
    )  # fmt: skip
    out = np.zeros((*z.shape, 3))
    for speed, heading in parts:
        out[..., 0] += wet * speed * np.cos(heading)
        out[..., 1] += wet * speed * np.sin(heading)
    return out
