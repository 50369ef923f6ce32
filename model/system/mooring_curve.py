"""Force and tensions of moorings against a horizontal offset, over a range that the lines can reach."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

import numpy as np

from model.system.mooring import MooringState, MooringSystem, force_offset_curve


def largest_offset(system: MooringSystem, offsets: Sequence[np.ndarray]) -> float:
    """Return how far [m] a curve should reach: half as far again as the mean offsets (6), at least a twentieth of the depth."""
    reach = 1.5 * max(float(np.abs(np.asarray(o)[:2]).max()) for o in offsets)
    return max(reach, 0.05 * system.depth if np.isfinite(system.depth) else 10.0)


def reachable_curve(system: MooringSystem, heading: float, reach: float) -> tuple[np.ndarray, np.ndarray, MooringState]:
    """Return 61 offsets [m], restoring force [N] and state along a heading [rad], less far where lines cannot follow."""
    for _ in range(6):
        offsets = np.linspace(-reach, reach, 61)
        with suppress(ValueError):
            return offsets, *force_offset_curve(system, heading, offsets)
        reach /= 2
    return np.zeros(1), *force_offset_curve(system, heading, np.zeros(1))
