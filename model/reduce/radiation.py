"""Radiation memory as a state space: passive rational fit of K(i omega) = B(omega) + i omega (A(omega) - A_inf).

K is the transform of the retardation functions (Cummins 1957; Ogilvie 1964). K(0) = 0 and K falls as 1/s, so K = s G with a
G that falls as s^-2; that is built into the fit, and the added mass at low frequency comes from G itself.
Reference for the properties: Perez and Fossen, Modeling, Identification and Control 30(1), 2009.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import block_diag, eigvals
from scipy.optimize import nnls
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from model.conventions import PLATFORM_DOFS, freeze
from model.reduce.importance import Importance, pooled
from model.reduce.rational import RationalFit, admissible, fit, partial_fractions, realisation, starting_poles
from model.system.hydro import HydroCoefficients, infinite_added_mass, radiation_at

ABSENT = (
    1e-4  # of the largest translation or rotation: a smaller diagonal term is rounding (yaw of a body of revolution)
)
SIGNIFICANT = 0.01  # of the geometric mean of the two diagonal peaks
TARGET = 0.005  # of the peak, and of any response
PASSIVE = 1e-5  # largest negative eigenvalue of the scaled damping matrix that counts as rounding
RESPONSE = 0.58  # what a relative error of a response counts beside an error of K relative to its peak
MOST = 1000.0  # that responses may raise the weight of an error above that of a fraction of the peak
ORDERS = (8, 12, 14, 16, 18, 20, 22, 24, 26, 28)
PATIENCE = 8  # fits tried without a tenth of gain before more poles are held to be of no use


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


def fit_radiation(
    hydro: HydroCoefficients, matters: Importance | None = None, *, target: float = TARGET, orders=ORDERS
) -> RadiationFit:
    """Return a stable, passive state space of the radiation of a body.

    Parameters
    ----------
    hydro : coefficients about the platform reference point
    matters : what errors do to the responses; where they do much, the fit is closer
    target : largest error sought, a fraction of each pair's peak, and of any response
    orders : numbers of poles tried in turn for each block until the target is reached; the best one stays otherwise
    """
    omega = hydro.omega
    low, high = omega[0], omega[-1]
    natural = [] if matters is None else [w for w in matters.natural if low < w < high]
    grid = np.unique(
        np.concatenate([[low / 4, low / 2], omega, natural, high * np.array([1.05, 1.1, 1.2, 1.35, 1.5, 2.0])])
    )
    urgent = np.zeros((len(grid), 6, 6)) if matters is None else pooled(matters.omega, matters.radiation, grid)
    data = retardation_transform(hydro, grid)
    inside = (grid >= low * (1 - 1e-9)) & (grid <= high * (1 + 1e-9))
    peak = np.abs(data[inside]).max(axis=0)
    diagonal = np.diag(peak)
    significant = peak > SIGNIFICANT * np.sqrt(np.outer(diagonal, diagonal))
    largest = np.array([diagonal[:3].max()] * 3 + [diagonal[3:].max()] * 3)
    rounding = 1e-12 * high * np.abs(np.diag(infinite_added_mass(hydro)))
    dead = (diagonal <= ABSENT * largest) | (diagonal <= rounding)  # a hull of strips alone has no radiation
    significant &= (peak > 0) & ~dead & ~dead[:, None]
    parts, names, found, least = [], [], [], []
    for block in _blocks(significant):
        best = _fit_block(grid, data[:, block][:, :, block], urgent[:, block][:, :, block], inside, target, orders)
        parts.append((block, *_realise(best.found, best.found.coefficients)))
        names.append(tuple(PLATFORM_DOFS[k] for k in block))
        found.append(best.found.order)
        exact, _ = least_damping(*parts[-1][1:], np.sqrt(np.diag(peak)[block]), high)
        least.append((best.before, exact))
    a, b, c = _stack(parts)
    out = RadiationFit(
        a=a,
        b=b,
        c=c,
        error=np.zeros((6, 6)),
        blocks=tuple(names),
        orders=tuple(found),
        least_damping=tuple(float(v) for v in np.min(least, axis=0)) if least else (0.0, 0.0),
    )
    together = np.zeros((6, 6), dtype=bool)
    for block, *_ in parts:
        together[np.ix_(block, block)] = True
    with np.errstate(divide="ignore", invalid="ignore"):
        error = np.abs(out(omega) - retardation_transform(hydro, omega)).max(axis=0) / peak
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
    k = c @ np.linalg.solve(1j * grid[:, None, None] * np.eye(n) - a, b + 0j)
    lowest = np.linalg.eigvalsh((k.real + np.swapaxes(k.real, 1, 2)) / 2 / np.outer(scale, scale))[:, 0]
    turn = np.flatnonzero((lowest[1:-1] < lowest[:-2]) & (lowest[1:-1] <= lowest[2:])) + 1
    return float(lowest.min()), [float(w) for w in grid[turn[lowest[turn] < 0]]]


def _blocks(significant: np.ndarray) -> list[list[int]]:
    """Return the groups of degrees of freedom that significant pairs connect."""
    count, label = connected_components(coo_array(significant), directed=False)
    groups = [list(np.flatnonzero(label == k)) for k in range(count)]
    return [g for g in groups if significant[np.ix_(g, g)].any()]


@dataclass(frozen=True, eq=False)
class _Passive:
    """A passive fit of a block: the fit of G, its largest error, least damping eigenvalue before and after."""

    found: RationalFit
    error: float
    before: float
    after: float


def _fit_block(omega, data, urgent, inside, target: float, orders) -> _Passive:
    """Return the passive fit of G = K / (i omega) of one block (n, m, m) with the lowest order that reaches the target.

    Data that are not quite causal or passive themselves may not let any order reach it; then the lowest order within
    two per cent of the best error is taken.
    """
    rows, columns = np.triu_indices(data.shape[1])
    values = data[:, rows, columns]
    peak = np.maximum(np.abs(values[inside]).max(axis=0), 1e-300)
    need = np.clip(RESPONSE * urgent[:, rows, columns] * peak, 1.0, MOST) / peak
    weight = _weights(omega, values, inside, peak, need)
    part = np.where(inside, omega, 0.0)[:, None] * need
    g = values / (1j * omega[:, None])
    low, high = omega[inside][0], omega[inside][-1]
    scale = np.sqrt(peak[rows == columns])
    tried = []
    for order in orders:
        for real in (2, 0):
            found, _ = fit(omega, g, weight, starting_poles(order, 4 * low, high, real), order="fast", part=part)
            tried.append(_enforce_passivity(omega, g, weight, part, found.poles, scale))
        errors = [_rank(t)[1] + 10.0 * _rank(t)[0] for t in tried]
        if min(errors) <= target or min(errors) > 0.9 * min(errors[:-PATIENCE], default=np.inf):
            break
    enough = max(target, 1.02 * min(errors))
    return next(t for t, e in zip(tried, errors, strict=True) if e <= enough)


def _rank(fit: _Passive) -> tuple[bool, float]:
    """Order fits: passive ones first, then by error."""
    return fit.after < -PASSIVE, fit.error


def _weights(omega, values, inside, peak, need) -> np.ndarray:
    """Return weights (2, n, c) of G's real part (added mass) and imaginary part (damping).

    An error of K counts as `need` says, at least as a fraction of the peak; where the damping is small (at low frequency, where drag-damped
    modes live) its own error counts for more; beyond the data everything counts little.
    """
    damping = np.abs(values.real) / peak
    added = np.maximum(omega, omega[inside][0] * 4)[:, None] * need
    small = added * (1 + 0.06 / (0.003 + damping))
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


def _enforce_passivity(omega, g, weight, part, poles, scale, rounds: int = 12) -> _Passive:
    """Return the best fit of G (n, c) with given poles whose damping matrix is nowhere negative.

    Least squares under the linear conditions u^T Re K(i omega) u >= 0, u the eigenvector of a negative minimum, which are
    added until no negative minimum is left (cutting planes; the set of passive coefficients is convex). Between rounds
    points with large errors gain weight. Cf. Gustavsen, IEEE Trans. Power Delivery 23(4), 2008.
    """
    space = admissible(poles, "fast")
    basis = partial_fractions(1j * omega, poles) @ space
    check = _check_grid(poles, omega)
    now, best, chosen, before = weight, None, weight, None
    planes = np.zeros((0, g.shape[1] * space.shape[1]))
    for _ in range(rounds):
        tried, planes = _passive_fit(basis, g, now, part, poles, space, check, scale, planes)
        before = tried.before if before is None else before
        if best is None or _rank(tried) < _rank(best):
            best, chosen = tried, now
        error = np.abs(basis @ (space.T @ tried.found.coefficients) - g) * part
        gain = np.sqrt(0.1 * error.max() + error)
        now = now * (gain / gain.mean())
    for _ in range(8):  # dips narrower than the grid
        exact, dips = least_damping(*_realise(best.found, best.found.coefficients), scale, omega.max() / 2)
        best = replace(best, before=before, after=exact)
        if exact > -PASSIVE or not dips:
            break
        check = np.union1d(check, dips)
        best, planes = _passive_fit(basis, g, chosen, part, poles, space, check, scale, planes)
    return replace(best, before=before)


def _passive_fit(basis, g, weight, part, poles, space, check, scale, planes) -> tuple[_Passive, np.ndarray]:
    """Return the least-squares fit of G (n, c) that is passive on a check grid (w) [rad/s], and the planes that hold it."""
    rows = (1j * check[:, None] * (partial_fractions(1j * check, poles) @ space)).real
    free, roots = _least_squares(basis, g, weight)
    z, planes, lowest = _cutting_planes(free, roots, rows, scale, planes)
    error = float((np.abs(basis @ z - g) * part).max())
    return _Passive(RationalFit(poles=poles, coefficients=space @ z), error, *lowest), planes


def _check_grid(poles, omega) -> np.ndarray:
    """Return frequencies [rad/s] that see every pole's peak and both ends."""
    top, size = omega.max(), np.abs(poles)[:, None]
    near = size * (1 - poles.real[:, None] / size * np.linspace(-4, 4, 17))
    near = near[(near > 0) & (near < 50 * top)]
    return np.unique(np.concatenate([np.geomspace(omega[0] / 10, 50 * top, 200), np.linspace(0, top, 1200)[1:], near]))


def _least_squares(basis, g, weight) -> tuple[np.ndarray, list[np.ndarray]]:
    """Return free coefficients (f, c) and the triangular roots of the normal equations, one for each response."""
    out, roots = [], []
    for k in range(g.shape[1]):
        tall = np.concatenate([weight[0][:, [k]] * basis.real, weight[1][:, [k]] * basis.imag])
        target = np.concatenate([weight[0][:, k] * g[:, k].real, weight[1][:, k] * g[:, k].imag])
        q, r = np.linalg.qr(tall)
        inverse = np.linalg.pinv(r, rcond=1e-10)
        out.append(inverse @ (q.T @ target))
        roots.append(inverse)
    return np.stack(out, axis=1), roots


def _cutting_planes(free, roots, rows, scale, planes, limit: int = 40):
    """Return the passive coefficients (f, c) nearest to free ones, the planes (k, c f) that hold them, and the least damping
    eigenvalue before and after.

    roots: inverse roots of the norm for each response; rows (w, f) give the damping of K on a check grid; scale (m) of the
    ports; planes (k, c f) to start with, from a nearby problem.
    """
    i, j = np.triu_indices(len(scale))
    z, first = free, None
    for _ in range(limit):
        damping = np.zeros((len(rows), len(scale), len(scale)))
        damping[:, i, j] = damping[:, j, i] = rows @ z / (scale[i] * scale[j])
        values, vectors = np.linalg.eigh(damping)
        low = float(values[:, 0].min())
        first = low if first is None else first
        if low > -2e-6:
            break
        cuts = [planes]
        for mode in range(len(scale)):
            lowest = np.concatenate([[np.inf], values[:, mode], [np.inf]])
            dip = np.flatnonzero((lowest[1:-1] < -1e-7) & (lowest[1:-1] <= lowest[:-2]) & (lowest[1:-1] < lowest[2:]))
            u = vectors[dip, :, mode] / scale
            share = np.where(i == j, 1.0, 2.0) * u[:, i] * u[:, j]
            cuts.append((share[:, :, None] * rows[dip][:, None, :]).reshape(len(dip), planes.shape[1]))
        planes = np.concatenate(cuts)
        change, active = _least_change(roots, planes, 3e-5 - planes @ free.T.ravel())
        z, planes = free + change.T, planes[active]
    return z, planes, (first, low)


def _least_change(roots, planes, levels) -> tuple[np.ndarray, np.ndarray]:
    """Return changes (c, f) of least norm with planes (w, c f) . change >= levels (w), and which planes are active (w).

    Least distance programming by non-negative least squares (Lawson and Hanson, Solving Least Squares Problems, ch. 23).
    """
    size = len(roots[0])
    g = np.concatenate([planes[:, k * size : (k + 1) * size] @ inv for k, inv in enumerate(roots)], axis=1)
    length = np.maximum(np.linalg.norm(g, axis=1), 1e-300)
    h = levels / length
    reach = max(np.abs(h).max(), 1e-300)  # so that the solution is of order one
    stacked = np.concatenate([(g / length[:, None]).T, h[None] / reach])
    target = np.zeros(len(stacked))
    target[-1] = 1.0
    u, _ = nnls(stacked, target, maxiter=200 * len(h) + 200)
    r = stacked @ u - target
    y = -reach * r[:-1] / r[-1]
    return np.stack([inv @ part for inv, part in zip(roots, y.reshape(len(roots), -1), strict=True)]), u > 0
