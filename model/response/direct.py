"""The direct route: transfer functions of a linearisation that holds the waves itself, C (i omega - A)^-1 B + D."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from model.system.linearisation import Linearisation

WAVE_INPUTS = (
    "SEA Extended input: wave elevation", "HD Extended input: wave elevation", "HD Wave elevation",
)  # fmt: skip


def wave_input(record: Linearisation) -> int:
    """Return the place of the wave-elevation input; raise ValueError when the record has none, or it drives nothing."""
    places = [k for k, n in enumerate(record.input_names) if n.startswith(WAVE_INPUTS)]
    for place in places:
        if np.any(record.B[:, place]) or np.any(record.D[:, place]):
            return place
    raise ValueError(
        f"{record.source} has {'a wave-elevation input that drives nothing' if places else 'no wave-elevation input'}: "
        "linearise with HydroDyn's state-space excitation (ExctnMod 2) and radiation (RdtnMod 2)"
    )


def direct_transfer(record: Linearisation, omega, column: int, outputs: Sequence[int] | None = None) -> np.ndarray:
    """Return the transfer functions (n, y) of outputs to one input, in the record's own units.

    omega (n) [rad/s]; column of the input; outputs their places, by default all. The whole linearised system is solved as it stands,
    with first-order states of radiation and excitation, independently of any assembly. Solved through the eigenvectors of A
    where these are well conditioned, else frequency by frequency.
    """
    omega = np.asarray(omega, dtype=float)
    rows = slice(None) if outputs is None else list(outputs)
    c, d, b = record.C[rows], record.D[rows, column], record.B[:, column]
    values, vectors = np.linalg.eig(record.A)
    if len(values) and np.linalg.cond(vectors) < 1e10:
        modal = np.linalg.solve(vectors, b.astype(complex))
        states = modal / (1j * omega[:, None] - values)
        return states @ (c @ vectors).T + d
    system = 1j * omega[:, None, None] * np.eye(len(record.A)) - record.A
    return np.linalg.solve(system, np.broadcast_to(b[:, None].astype(complex), (len(omega), len(b), 1)))[..., 0] @ c.T + d
