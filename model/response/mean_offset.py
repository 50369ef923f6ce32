"""The mean offset of one floating turbine or of many: Newton on constant forces, linear stiffness and the moorings' exact force."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from model.conventions import PLATFORM_DOFS
from model.system.mooring import MooringState, MooringSystem, mooring_state

_LARGEST_STEP = (10.0, 0.2)  # m, rad


@dataclass(frozen=True, eq=False, kw_only=True)
class MeanOffsets:
    """Mean offsets (..., q) of designs with their moorings there, total stiffness (..., q, q), Newton steps, and whether each (...)
    has converged.
    """

    offset: np.ndarray
    mooring: MooringState
    stiffness: np.ndarray
    iterations: int
    converged: np.ndarray


def mean_offsets(
    dofs: Sequence[str], force, stiffness, mooring: MooringSystem, *, tolerance: float = 1e-10, limit: int = 50
) -> MeanOffsets:
    """Return where the constant force at zero offset (..., q), linear stiffness (..., q, q) and moorings balance.

    The leading axes are designs, those of the moorings too. A step is at most 10 m and 0.2 rad; a design has converged when its
    next step is below `tolerance` of that. Raises ValueError when a line cannot reach on the way.
    """
    force, stiffness = np.asarray(force, dtype=float), np.asarray(stiffness, dtype=float)
    here = [k for k, d in enumerate(dofs) if d in PLATFORM_DOFS]
    rows = [PLATFORM_DOFS.index(dofs[k]) for k in here]
    largest = np.array([_LARGEST_STEP[d in PLATFORM_DOFS[3:]] for d in dofs])
    offset = np.zeros(force.shape)
    for step in range(1, limit + 1):
        platform = np.zeros(force.shape[:-1] + (6,))
        platform[..., rows] = offset[..., here]
        state = mooring_state(mooring, platform)
        residual = force - (stiffness @ offset[..., None])[..., 0]
        residual[..., here] += state.force[..., rows]
        total = stiffness.copy()
        total[..., np.array(here)[:, None], here] += state.stiffness[..., np.array(rows)[:, None], rows]
        change = np.linalg.solve(total, residual[..., None])[..., 0]
        size = np.max(np.abs(change) / largest, axis=-1)
        if np.all(size < tolerance) or step == limit:
            break
        offset = offset + change / np.maximum(1.0, size)[..., None]
    return MeanOffsets(offset=offset, mooring=state, stiffness=total, iterations=step, converged=size < tolerance)
