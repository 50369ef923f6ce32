"""Passivity of rational radiation kernels: where the damping matrix is negative, and the nearest coefficients for which it is not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag, eigvals
from scipy.optimize import nnls

from model.reduce.rational import RationalFit, frequency_response, realisation

PASSIVE = 1e-5  # largest negative eigenvalue of the scaled damping matrix that counts as rounding
LEVEL = 3e-5  # of the scaled damping matrix, at which a plane holds its eigenvalue


@dataclass(frozen=True, eq=False)
class Ports:
    """Damping of one block of m degrees of freedom: its triangle is rows (w, f) times coefficients (f, m (m + 1) / 2) on a check grid,
    scale (m) of the degrees of freedom, and place of the coefficients, triangle entry by triangle entry, among all unknowns."""

    rows: np.ndarray
    scale: np.ndarray
    place: slice

    def damping(self, unknowns) -> np.ndarray:
        """Return the scaled damping matrices (w, m, m)."""
        i, j = np.triu_indices(len(self.scale))
        values = self.rows @ unknowns[self.place].reshape(len(i), -1).T / (self.scale[i] * self.scale[j])
        out = np.zeros((len(self.rows), len(self.scale), len(self.scale)))
        out[:, i, j] = out[:, j, i] = values
        return out

    def cuts(self, values, vectors, count: int) -> np.ndarray:
        """Return a plane (k, count) of all unknowns for each negative minimum of the eigenvalues (w, m) with their vectors (w, m, m)."""
        i, j = np.triu_indices(len(self.scale))
        out = []
        for mode in range(len(self.scale)):
            lowest = np.concatenate([[np.inf], values[:, mode], [np.inf]])
            dip = np.flatnonzero((lowest[1:-1] < -1e-7) & (lowest[1:-1] <= lowest[:-2]) & (lowest[1:-1] < lowest[2:]))
            u = vectors[dip, :, mode] / self.scale
            share = np.where(i == j, 1.0, 2.0) * u[:, i] * u[:, j]
            plane = np.zeros((len(dip), count))
            plane[:, self.place] = (share[:, :, None] * self.rows[dip][:, None, :]).reshape(len(dip), self.place.stop - self.place.start)
            out.append(plane)
        return np.concatenate(out)


def symmetric(upper) -> np.ndarray:
    """Return the symmetric matrix (..., m, m) of upper triangles (..., m (m + 1) / 2)."""
    upper = np.asarray(upper)
    m = int((np.sqrt(8 * upper.shape[-1] + 1) - 1) / 2)
    i, j = np.triu_indices(m)
    out = np.zeros((*upper.shape[:-1], m, m), dtype=upper.dtype)
    out[..., i, j] = out[..., j, i] = upper
    return out


def realise(found: RationalFit) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return A, B, C of one block: one copy of the poles for each input; coefficients (b, m (m + 1) / 2) of G."""
    a, b = realisation(found.poles)
    c = np.swapaxes(symmetric((found.coefficients.T @ a).T), 0, -1)
    m = len(c)
    return np.kron(np.eye(m), a), np.kron(np.eye(m), b[:, None]), c.reshape(m, -1)


def least_damping(a, b, c, scale, top: float) -> tuple[float, list[float]]:
    """Return the least eigenvalue of the scaled damping matrix over all frequencies and the frequencies [rad/s] of local minima.

    a (r, r), b (r, m), c (m, r) of K; scale (m) divides rows and columns; top [rad/s] ends the search grid. Where the
    eigenvalue changes sign follows exactly from the imaginary eigenvalues of the pencil of K(s) + K(-s)^T, so that no
    narrow gap between grid points stays unseen.
    """
    n, m = b.shape
    pencil = np.block([
        [a, np.zeros((n, n)), b], [np.zeros((n, n)), -a.T, -c.T], [c, b.T, np.zeros((m, m))]
    ])  # fmt: skip
    weight = np.concatenate(
        [np.ones(2 * n), 1 / scale]
    )  # rows and columns of the ports, so that the pencil is balanced
    pencil = pencil * weight[:, None] * weight
    values = eigvals(pencil, block_diag(np.eye(2 * n), np.zeros((m, m))))
    values = values[np.isfinite(values)]
    crossings = np.abs(values.imag[np.abs(values.real) < 1e-6 * np.abs(values)])
    crossings = np.unique(crossings[(crossings > 0) & (crossings < 100 * top)])
    between = (crossings[1:] + crossings[:-1]) / 2
    grid = np.unique(np.concatenate([np.geomspace(top / 1e4, 100 * top, 4000), between]))
    k = frequency_response(a, b, c, grid)
    lowest = np.linalg.eigvalsh((k.real + np.swapaxes(k.real, 1, 2)) / 2 / np.outer(scale, scale))[:, 0]
    turn = np.flatnonzero((lowest[1:-1] < lowest[:-2]) & (lowest[1:-1] <= lowest[2:])) + 1
    return float(lowest.min()), [float(w) for w in grid[turn[lowest[turn] < 0]]]


def check_grid(poles, omega) -> np.ndarray:
    """Return frequencies [rad/s] that see every pole's peak and both ends."""
    top, size = omega.max(), np.abs(poles)[:, None]
    near = size * (1 - poles.real[:, None] / size * np.linspace(-4, 4, 17))
    near = near[(near > 0) & (near < 50 * top)]
    return np.unique(np.concatenate([np.geomspace(omega[0] / 10, 50 * top, 200), np.linspace(0, top, 1200)[1:], near]))


def nearest_passive(free, root, ports: Sequence[Ports], planes=None, limit: int = 40):
    """Return the coefficients nearest to free ones (u) for which no damping is negative on the check grids, the planes (k, u) that hold
    them, and the least eigenvalue of the scaled damping matrices before and after.

    root (u, u): inverse root of the norm in which nearest is meant; planes to start with, from a nearby problem. Planes
    u^T Re K(i omega) u >= 0, u the eigenvector of a negative minimum, are added until no negative minimum is left (the set of passive
    coefficients is convex). Cf. Gustavsen, IEEE Trans. Power Delivery 23(4), 2008.
    """
    z, first = free, None
    planes = np.zeros((0, len(free))) if planes is None else planes
    for _ in range(limit):
        spectra = [np.linalg.eigh(p.damping(z)) for p in ports]
        low = min(float(values[:, 0].min()) for values, _ in spectra)
        first = low if first is None else first
        if low > -2e-6:
            break
        planes = np.concatenate([planes, *(p.cuts(*s, len(z)) for p, s in zip(ports, spectra, strict=True))])
        change, active = _least_change(root, planes, LEVEL - planes @ free)
        z, planes = free + change, planes[active]
    return z, planes, (first, low)


def _least_change(root, planes, levels) -> tuple[np.ndarray, np.ndarray]:
    """Return the change (u) of least norm with planes (w, u) . change >= levels (w), and which planes are active (w).

    Least distance programming by non-negative least squares (Lawson and Hanson, Solving Least Squares Problems, ch. 23).
    """
    g = planes @ root
    length = np.maximum(np.linalg.norm(g, axis=1), 1e-300)
    h = levels / length
    reach = max(np.abs(h).max(), 1e-300)  # so that the solution is of order one
    stacked = np.concatenate([(g / length[:, None]).T, h[None] / reach])
    target = np.zeros(len(stacked))
    target[-1] = 1.0
    u, _ = nnls(stacked, target, maxiter=200 * len(h) + 200)
    r = stacked @ u - target
    return root @ (-reach * r[:-1] / r[-1]), u > 0
