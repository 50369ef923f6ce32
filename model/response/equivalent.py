"""What a linear model lacks: the damping and stiffness that would have to be added for it to fit a reference best."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares


@dataclass(frozen=True, eq=False, kw_only=True)
class Missing:
    """Linear damping and stiffness (p) to add to degrees of freedom, in SI units, with their standard errors (p), and the
    amplitude error before and after (p), a fraction.
    """

    dofs: tuple[str, ...]
    damping: np.ndarray
    stiffness: np.ndarray
    damping_error: np.ndarray
    stiffness_error: np.ndarray
    error_before: np.ndarray
    error_after: np.ndarray


def missing_terms(
    dofs, places, omega, dynamic, transfer, spectra, smoothing, reference, critical, restoring
) -> Missing:
    """Return the linear damping and stiffness of each degree of freedom that bring a model's spectra closest to a reference.

    Parameters
    ----------
    dofs, places : names (p) and rows (p) of the degrees of freedom to fit, each by terms of its own
    omega : (n) frequencies [rad/s]
    dynamic : (n, q, q) dynamic stiffness, drag included
    transfer : (n, q, r) motions per unit of each input
    spectra : (n, r) input spectra
    smoothing : (m, n) weights that bring model spectra to the reference's frequencies and resolution
    reference : (m, p) reference spectra of the same motions, in the units that smoothing @ model gives
    critical : (p) critical damping, and
    restoring : (p) stiffness, both used as scales

    Returns
    -------
    Missing : least squares of sqrt(S) - sqrt(S_ref), every motion weighted by one over its reference energy

    Notes
    -----
    With Z the dynamic stiffness, X = Z^-1 F the motions and D = diag(dC + i omega dB), the motions with D added are
    (1 + G D)^-1 X, where G holds the rows and columns of Z^-1 that are fitted. No linear system of full size is solved again.
    """
    places, count = np.asarray(places), len(places)
    unit = np.zeros((*dynamic.shape[:2], count), dtype=complex)
    unit[:, places, np.arange(count)] = 1.0
    receptance = np.linalg.solve(dynamic, unit)[:, places]
    motion = transfer[:, places]
    target = np.sqrt(reference)
    scale = np.sqrt((target**2).sum(axis=0))
    eye = np.eye(count)

    def amplitudes(x):
        added = x[count:] * restoring + 1j * omega[:, None] * x[:count] * critical
        changed = np.linalg.solve(eye + receptance * added[:, None, :], motion)
        return np.sqrt(smoothing @ np.einsum("npr,nr->np", np.abs(changed) ** 2, spectra))

    def residual(x):
        return ((amplitudes(x) - target) / scale).ravel()

    found = least_squares(residual, np.zeros(2 * count), x_scale=np.r_[np.full(count, 0.01), np.full(count, 0.01)])
    spread = _standard_errors(found.jac, found.fun)
    before, after = (np.linalg.norm((amplitudes(x) - target) / scale, axis=0) for x in (np.zeros(2 * count), found.x))
    return Missing(
        dofs=tuple(dofs), damping=found.x[:count] * critical, stiffness=found.x[count:] * restoring,
        damping_error=spread[:count] * critical, stiffness_error=spread[count:] * restoring, error_before=before, error_after=after,
    )  # fmt: skip


def _standard_errors(jacobian: np.ndarray, residual: np.ndarray) -> np.ndarray:
    """Return the standard errors of least-squares parameters from the residual's own size."""
    freedom = max(len(residual) - jacobian.shape[1], 1)
    covariance = np.linalg.pinv(jacobian.T @ jacobian) * (residual @ residual) / freedom
    return np.sqrt(np.diag(covariance))
