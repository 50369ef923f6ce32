"""What an error of a fitted force does to the responses: how much each frequency and degree of freedom matters."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.conventions import PLATFORM_DOFS, freeze
from model.response.loads import LinearOutputs, channel_response
from model.response.solve import Response

FAINT = 0.02  # of its peak: where a response is smaller, its relative error does not count
DEAD = (
    1e-3  # of the largest channel of the same unit: a channel with a smaller peak is not excited (sway in head waves)
)


@dataclass(frozen=True, eq=False, kw_only=True)
class Importance:
    """Largest relative change of any channel's response, at omega (n) [rad/s], per newton (newton metre) of wave force: force (n, 6)
    per metre of wave amplitude, and per unit error of K: radiation (n, 6, 6). natural: frequencies of the peaks (k) [rad/s].
    """

    omega: np.ndarray
    force: np.ndarray
    radiation: np.ndarray
    natural: np.ndarray

    def __post_init__(self):
        freeze(self, omega=("n",), force=("n", 6), radiation=("n", 6, 6), natural=("k",))


def importance(outputs: LinearOutputs, response: Response, natural, band) -> Importance:
    """Return what errors of wave force and radiation do to the channels of a response.

    natural (k) [rad/s] of the modes; band (low, high) [rad/s] outside which nothing counts.
    """
    omega, q = response.excitation.omega, len(response.dofs)
    channels = channel_response(outputs, response)
    compliance = np.linalg.inv(response.dynamic_stiffness)
    iw = 1j * omega[:, None, None]
    gain = np.abs((outputs.position + iw * outputs.velocity + iw**2 * outputs.acceleration) @ compliance)
    inside = (omega >= band[0]) & (omega <= band[1])
    here = [(PLATFORM_DOFS.index(d), response.dofs.index(d)) for d in response.dofs if d in PLATFORM_DOFS]
    rows, places = (np.array([pair[k] for pair in here]) for k in (0, 1))
    force, radiation = np.zeros((len(omega), q)), np.zeros((len(omega), 6, 6))
    causes = [(w, x) for w, x in zip(channels.to_wave, response.to_wave, strict=True)]
    by_wave = len(causes)
    if np.any(response.to_wind):
        causes.append((channels.to_wind, response.to_wind))
    for k, (rao, motion) in enumerate(causes):
        share = _relative(np.abs(rao), inside, outputs.units)  # (n, c): 1/|response| where it counts
        per_force = (gain * share[..., None]).max(axis=1)
        if k < by_wave:
            force = np.maximum(force, per_force)
        rate = omega[:, None] * np.abs(motion[:, places])
        each = per_force[:, places][:, :, None] * rate[:, None, :]
        radiation[np.ix_(range(len(omega)), rows, rows)] = np.maximum(
            radiation[np.ix_(range(len(omega)), rows, rows)], each
        )
    by_platform = np.zeros((len(omega), 6))
    by_platform[:, rows] = force[:, places]
    both = np.maximum(radiation, np.swapaxes(radiation, 1, 2))
    return Importance(omega=omega, force=by_platform, radiation=both, natural=np.asarray(natural, dtype=float))


def pooled(importance_omega, values, nodes) -> np.ndarray:
    """Return the largest of values (n, ...) within the half intervals around each of the nodes (k) [rad/s]: (k, ...)."""
    edges = np.concatenate([[0.0], (nodes[1:] + nodes[:-1]) / 2, [np.inf]])
    place = np.clip(np.searchsorted(edges, importance_omega, side="right") - 1, 0, len(nodes) - 1)
    out = np.zeros((len(nodes), *values.shape[1:]))
    np.maximum.at(out, place, values)
    return out


def excited(size: np.ndarray, units, peak=None) -> np.ndarray:
    """Return where responses of a size (n, c) are large enough to be compared: above FAINT of their peak, in channels that waves move.

    peak (c): by default the largest of `size`.
    """
    peak = size.max(axis=0) if peak is None else peak
    of_unit = np.array([max(p for p, other in zip(peak, units, strict=True) if other == u) for u in units])
    return (size > FAINT * peak) & (peak > DEAD * of_unit) & (size > 0)


def _relative(size: np.ndarray, inside: np.ndarray, units) -> np.ndarray:
    """Return 1/size (n, c) where a channel is excited, inside the band; zero elsewhere."""
    counts = inside[:, None] & excited(np.where(inside[:, None], size, 0.0), units)
    return np.where(counts, 1 / np.where(counts, size, 1.0), 0.0)
