"""Radiation memory as a state space: passive rational fit of K(i omega) = B(omega) + i omega (A(omega) - A_inf).

K is the transform of the retardation functions (Cummins 1957; Ogilvie 1964). K(0) = 0 and K falls as 1/s, so K = s G with a
G that falls as s^-2; that is built into the fit, and the added mass at low frequency comes from G itself.
Reference for the properties: Perez and Fossen, Modeling, Identification and Control 30(1), 2009.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag, eigvals
from scipy.optimize import nnls
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from model.conventions import PLATFORM_DOFS, freeze
from model.reduce.rational import RationalFit, admissible, fit, partial_fractions, realisation, starting_poles
from model.system.hydro import HydroCoefficients, infinite_added_mass, radiation_at

SIGNIFICANT = 0.01  # of the geometric mean of the two diagonal peaks
TARGET = 0.007  # of the peak; leaves room for the passivity correction below one per cent
ORDERS = range(4, 26, 2)


@dataclass(frozen=True, eq=False, kw_only=True)
class RadiationFit:
    """Radiation force -(C z), z' = A z + B v for platform velocities v (6): a (r, r), b (r, 6), c (6, r).

    error (6, 6): largest |K_fit - K| over the data as a fraction of the pair's largest |K|, NaN where the pair is not significant
    and left out; blocks are the degrees of freedom that belong together and orders their pole counts. least_damping is the
    lowest eigenvalue of the damping matrix over frequency, with degrees of freedom scaled by the root of their peaks:
    before (first) and after (second) passivity was enforced.
    """

    a: np.ndarray
    b: np.ndarray
    c: np.ndarray
    error: np.ndarray
    blocks: tuple[tuple[str, ...], ...]
    orders: tuple[int, ...]
    least_damping: tuple[float, float]

    def __post_init__(self):
        freeze(self, a=("r", "r"), b=("r", 6), c=(6, "r"), error=(6, 6))

    @property
    def largest_error(self) -> float:
        """Largest error of all significant pairs, a fraction of the pair's peak."""
        return float(np.nanmax(self.error, initial=0.0))

    def __call__(self, omega) -> np.ndarray:
        """Return K (n, 6, 6) at omega (n) [rad/s]."""
        s = 1j * np.asarray(omega, dtype=float)[:, None, None]
        return self.c @ np.linalg.solve(s * np.eye(len(self.a)) - self.a, self.b + 0j)


def retardation_transform(hydro: HydroCoefficients, omega) -> np.ndarray:
    """Return K (n, 6, 6) = B + i omega (A - A_inf), symmetric, at omega (n) [rad/s]."""
    added, damping = radiation_at(hydro, omega)
    k = damping + 1j * np.asarray(omega)[:, None, None] * (added - infinite_added_mass(hydro))
    return (k + np.swapaxes(k, 1, 2)) / 2


def fit_radiation(hydro: HydroCoefficients, *, target: float = TARGET, orders=ORDERS) -> RadiationFit:
    """Return a stable, passive state space of the radiation of a body.

    Parameters
    ----------
    hydro : coefficients about the platform reference point
    target : largest error sought, a fraction of each pair's peak
    orders : numbers of poles tried in turn for each block until the target is reached; the best one stays otherwise
    """
    omega = hydro.omega
    low, high = omega[0], omega[-1]
    grid = np.concatenate([[low / 4, low / 2], omega, high * np.array([1.05, 1.1, 1.2, 1.35, 1.5, 2.0])])
    data = retardation_transform(hydro, grid)
    inside = (grid >= low) & (grid <= high)
    peak = np.abs(data[inside]).max(axis=0)
    diagonal = np.diag(peak)
    significant = peak > SIGNIFICANT * np.sqrt(np.outer(diagonal, diagonal))
    significant &= peak > 0
    parts, names, found, least = [], [], [], [(0.0, 0.0)]
    for block in _blocks(significant):
        best = _fit_block(grid, data[:, block][:, :, block], inside, target, orders)
        coefficients, before, after = _enforce_passivity(grid, best, inside, peak[np.ix_(block, block)])
        parts.append((block, *_realise(best, coefficients)))
        names.append(tuple(PLATFORM_DOFS[k] for k in block))
        found.append(best.order)
        least.append((before, after))
    a, b, c = _stack(parts)
    out = RadiationFit(a=a, b=b, c=c, error=np.zeros((6, 6)), blocks=tuple(names), orders=tuple(found), least_damping=tuple(np.min(least, axis=0)))
    together = np.zeros((6, 6), dtype=bool)
    for block, *_ in parts:
        together[np.ix_(block, block)] = True
    with np.errstate(divide="ignore", invalid="ignore"):
        error = np.abs(out(omega) - data[inside]).max(axis=0) / peak
    object.__setattr__(out, "error", np.where(significant & together, error, np.nan))
    return out


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
    weight = np.concatenate([np.ones(2 * n), 1 / scale])  # rows and columns of the ports, so that the pencil is balanced
    pencil = pencil * weight[:, None] * weight
    values = eigvals(pencil, block_diag(np.eye(2 * n), np.zeros((m, m))))
    values = values[np.isfinite(values)]
    crossings = np.abs(values.imag[np.abs(values.real) < 1e-6 * np.abs(values)])
    crossings = np.unique(crossings[(crossings > 0) & (crossings < 100 * top)])
    between = (crossings[1:] + crossings[:-1]) / 2
    grid = np.unique(np.concatenate([np.geomspace(top / 1e4, 100 * top, 4000), between]))
    k = c @ np.linalg.solve(1j * grid[:, None, None] * np.eye(n) - a, b + 0j)
    lowest = np.linalg.eigvalsh((k.real + np.swapaxes(k.real, 1, 2)) / 2 / np.outer(scale, scale))[:, 0]
    turn = np.flatnonzero((lowest[1:-1] < lowest[:-2]) & (lowest[1:-1] <= lowest[2:])) + 1
    return float(lowest.min()), [float(w) for w in grid[turn[lowest[turn] < 0]]]


def _blocks(significant: np.ndarray) -> list[list[int]]:
    """Return the groups of degrees of freedom that significant pairs connect."""
    count, label = connected_components(coo_array(significant), directed=False)
    groups = [list(np.flatnonzero(label == k)) for k in range(count)]
    return [g for g in groups if significant[np.ix_(g, g)].any()]


def _fit_block(omega, data, inside, target: float, orders) -> RationalFit:
    """Return the fit of G = K / (i omega) of one block (n, m, m), upper triangle, with the lowest order that reaches the target."""
    rows, columns = np.triu_indices(data.shape[1])
    values = data[:, rows, columns]
    peak = np.maximum(np.abs(values[inside]).max(axis=0), 1e-300)
    weight = _weights(omega, values, inside, peak)
    part = np.where(inside, omega, 0.0)[:, None] / peak
    g = values / (1j * omega[:, None])
    low, high = omega[inside][0], omega[inside][-1]
    best = None
    for order in orders:
        for real in (2, 0):
            poles = starting_poles(order, 4 * low, high, real)
            found, error = fit(omega, g, weight, poles, order="fast", part=part)
            if best is None or error < best[1]:
                best = found, error
        if best[1] <= target:
            break
    return best[0]


def _weights(omega, values, inside, peak) -> np.ndarray:
    """Return weights (2, n, c) of G's real part (added mass) and imaginary part (damping).

    An error of K counts as a fraction of the peak; where the damping is small (at low frequency, where drag-damped
    modes live) its own error counts for more; beyond the data everything counts little.
    """
    damping = np.abs(values.real) / peak
    added = np.maximum(omega, omega[inside][0] * 4)[:, None] / peak
    small = omega[:, None] / peak * (1 + 0.06 / (0.02 + damping))
    return np.stack([added, small]) * np.where(inside, 1.0, 0.1)[:, None]


def _realise(found: RationalFit, coefficients) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return A, B, C of one block: one copy of the poles for each input; coefficients (b, m (m + 1) / 2) of G."""
    a, b = realisation(found.poles)
    m = int((np.sqrt(8 * coefficients.shape[1] + 1) - 1) / 2)
    rows, columns = np.triu_indices(m)
    c = np.zeros((m, m, len(a)))
    c[rows, columns] = c[columns, rows] = coefficients.T @ a
    return np.kron(np.eye(m), a), np.kron(np.eye(m), b[:, None]), c.reshape(m, -1)


def _stack(parts) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return A, B (r, 6), C (6, r) of all blocks, each state scaled so that input and output have the same size."""
    count = sum(len(a) for _, a, _, _ in parts)
    a, b, c, at = np.zeros((count, count)), np.zeros((count, 6)), np.zeros((6, count)), 0
    for block, a_block, b_block, c_block in parts:
        own = slice(at, at + len(a_block))
        a[own, own], b[own, block], c[block, own] = a_block, b_block, c_block
        at += len(a_block)
    return a, b, c


def _enforce_passivity(omega, found: RationalFit, inside, peak) -> tuple[np.ndarray, float, float]:
    """Return coefficients of a passive G, and the least damping eigenvalue before and after.

    The smallest change (in the norm of the fit) that lifts every negative minimum of the damping's eigenvalue to zero, as
    far as first-order sensitivity tells; repeated until none is left (Gustavsen, IEEE Trans. Power Delivery 23(4), 2008).
    """
    m, top = len(peak), omega[inside][-1]
    scale = np.sqrt(np.diag(peak))
    rows, columns = np.triu_indices(m)
    space = admissible(found.poles, "fast")
    basis = partial_fractions(1j * omega, found.poles) @ space * omega[:, None]
    tall = np.concatenate([basis.real, basis.imag])[np.tile(inside, 2)]
    roots = [np.linalg.qr(tall / peak[i, j], mode="r") for i, j in zip(rows, columns, strict=True)]
    size = space.shape[1]
    z, places = space.T @ found.coefficients, []
    before, minima = least_damping(*_realise(found, space @ z), scale, top)
    after, original = before, z
    for attempt in range(30):
        if not minima:
            break
        places += minima
        values = _damping_rows(found, space, np.array(places))
        k = np.einsum("wf,fc->wc", values, original)
        matrices = np.zeros((len(places), m, m))
        matrices[:, rows, columns] = matrices[:, columns, rows] = k
        lowest, vectors = np.linalg.eigh(matrices / np.outer(scale, scale))
        u = vectors[:, :, 0] / scale
        share = np.where(rows == columns, 1.0, 2.0) * u[:, rows] * u[:, columns]
        sensitivity = (share[:, :, None] * values[:, None, :]).reshape(len(places), -1)
        z = original + _least_change(roots, sensitivity, 1e-7 * (1 + attempt) - lowest[:, 0], size).T
        after, minima = least_damping(*_realise(found, space @ z), scale, top)
    return space @ z, before, after


def _damping_rows(found: RationalFit, space, omega) -> np.ndarray:
    """Return the rows (w, f) that give the damping of K = s G from coefficients in the admissible space."""
    return ((1j * omega[:, None]) * (partial_fractions(1j * omega, found.poles) @ space)).real


def _least_change(roots, sensitivity, lift, size: int) -> np.ndarray:
    """Return changes (c, f) of least norm sum |R_c d_c|^2 with sensitivity (w, c f) . d >= lift (w).

    Least distance programming by non-negative least squares (Lawson and Hanson, Solving Least Squares Problems, ch. 23).
    """
    inverse = [np.linalg.pinv(r, rcond=1e-10) for r in roots]
    g = np.concatenate([sensitivity[:, k * size : (k + 1) * size] @ inv for k, inv in enumerate(inverse)], axis=1)
    length = np.maximum(np.linalg.norm(g, axis=1), 1e-300)
    g, h = g / length[:, None], lift / length
    stacked = np.concatenate([g.T, h[None]])
    target = np.zeros(len(stacked))
    target[-1] = 1.0
    u, _ = nnls(stacked, target, maxiter=50 * len(h) + 100)
    r = stacked @ u - target
    y = -r[:-1] / r[-1]
    return np.stack([inv @ part for inv, part in zip(inverse, y.reshape(len(roots), -1), strict=True)])
