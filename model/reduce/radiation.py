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
from model.reduce.rational import RationalFit, admissible, columns, fit, rational, realisation, starting_poles
from model.response.cummins import added_mass_of_damping
from model.system.hydro import HydroCoefficients, infinite_added_mass, radiation_at

ABSENT = (
    1e-4  # of the largest translation or rotation: a smaller diagonal term is rounding (yaw of a body of revolution)
)
SIGNIFICANT = 0.01  # of the geometric mean of the two diagonal peaks
TARGET = 0.005  # of the peak, and of any response
PASSIVE = 1e-5  # largest negative eigenvalue of the scaled damping matrix that counts as rounding
RESPONSE = 0.58  # what a relative error of a response counts beside an error of K relative to its peak
BETWEEN, BEYOND = 0.1, 0.01  # what an error of K counts between the frequencies of the data and outside them
MOST = 1000.0  # that responses may raise the weight of an error above that of a fraction of the peak
TOP = 3.3  # rad/s, up to which responses count
FEWEST, MORE, MANY = 8, 2, 30  # poles to begin with, added at a time, at most
PATIENCE = 5  # fits tried without a tenth of gain before more poles are held to be of no use


@dataclass(frozen=True, eq=False, kw_only=True)
class RadiationFit:
    """Radiation force -(C z), z' = A z + B v for platform velocities v (6): a (r, r), b (r, 6), c (6, r).

    added_mass_change (6, 6) is what the infinite-frequency added mass of the data is changed by: panel codes give it to a few parts in
    ten thousand, and where added mass and damping disagree by that much no kernel fits both. error (6, 6): largest |K_fit - K| over the data as a fraction of the pair's largest |K|, NaN where the pair is not significant
    and left out; blocks are the degrees of freedom that belong together and orders their pole counts. least_damping is the
    lowest eigenvalue of the damping matrix over frequency, with degrees of freedom scaled by the root of their peaks:
    before (first) and after (second) passivity was enforced.
    """

    a: np.ndarray
    b: np.ndarray
    c: np.ndarray
    added_mass_change: np.ndarray
    error: np.ndarray
    blocks: tuple[tuple[str, ...], ...]
    orders: tuple[int, ...]
    least_damping: tuple[float, float]

    def __post_init__(self):
        freeze(self, a=("r", "r"), b=("r", 6), c=(6, "r"), added_mass_change=(6, 6), error=(6, 6))

    @property
    def largest_error(self) -> float:
        """Largest error of all significant pairs, a fraction of the pair's peak."""
        return float(np.nanmax(self.error, initial=0.0))

    def __call__(self, omega) -> np.ndarray:
        """Return K (n, 6, 6) at omega (n) [rad/s], about the infinite-frequency added mass of the data."""
        s = 1j * np.asarray(omega, dtype=float)[:, None, None]
        memory = self.c @ np.linalg.solve(s * np.eye(len(self.a)) - self.a, self.b + 0j)
        return memory + s * self.added_mass_change


def retardation_transform(hydro: HydroCoefficients, omega) -> np.ndarray:
    """Return K (n, 6, 6) = B + i omega (A - A_inf), symmetric, at omega (n) [rad/s]."""
    added, damping = radiation_at(hydro, omega)
    k = damping + 1j * np.asarray(omega)[:, None, None] * (added - infinite_added_mass(hydro))
    return (k + np.swapaxes(k, 1, 2)) / 2


def disagreement(hydro: HydroCoefficients) -> np.ndarray:
    """Return by how much added mass and damping of a body's data disagree, as fractions of the peaks of |K| (6, 6).

    The largest difference between the added mass of the data and the one that causality lets follow from the damping, with the
    infinite-frequency added mass that makes it smallest in the mean square; zero where there is no radiation. About half
    of it is left in any causal fit.
    """
    omega = hydro.omega
    implied = omega[:, None, None] * (hydro.added_mass - infinite_added_mass(hydro) - added_mass_of_damping(hydro, omega))
    change = np.tensordot(omega, implied, axes=1) / np.sum(omega**2)
    rest = np.abs(implied - omega[:, None, None] * change).max(axis=0)
    peak = np.abs(retardation_transform(hydro, omega)).max(axis=0)
    return np.where(_significant(peak, omega[-1] * np.abs(np.diag(infinite_added_mass(hydro)))), rest / np.maximum(peak, 1e-300), 0.0)


def fit_radiation(
    hydro: HydroCoefficients, matters: Importance | None = None, *, data=None, target: float = TARGET, most: int = MANY
) -> RadiationFit:
    """Return a stable, passive state space of the radiation of a body.

    Parameters
    ----------
    hydro : coefficients about the platform reference point
    matters : what errors do to the responses; where they do much, the fit is closer
    data : frequencies [rad/s] at which the coefficients were computed, by default all of `hydro`
    target : largest error sought, a fraction of each pair's peak at the frequencies of the data, and of any response everywhere
    most : number of poles up to which poles are added to each block until the target is reached; the best fit stays otherwise
    """
    omega, floor = _fitting_grid(hydro.omega if data is None else data, () if matters is None else matters.natural)
    urgent = np.zeros((len(omega), 6, 6)) if matters is None else pooled(matters.omega, matters.radiation, omega)
    known, nodes = retardation_transform(hydro, omega), floor == 1
    peak = np.abs(known[nodes]).max(axis=0)
    significant = _significant(peak, omega[nodes][-1] * np.abs(np.diag(infinite_added_mass(hydro))))
    parts, names, found, least = [], [], [], []
    change, together = np.zeros((6, 6)), np.zeros((6, 6), dtype=bool)
    for block in _blocks(significant):
        here = np.ix_(block, block)
        best = _fit_block(omega, known[:, *here], urgent[:, *here], floor, target, most)
        parts.append((block, *_realise(best.found)))
        names.append(tuple(PLATFORM_DOFS[k] for k in block))
        found.append(best.found.order)
        least.append((best.before, best.after))
        change[here], together[here] = _symmetric(best.found.constant), True
    a, b, c = _stack(parts)
    out = RadiationFit(
        a=a, b=b, c=c, added_mass_change=change, error=np.zeros((6, 6)), blocks=tuple(names), orders=tuple(found),
        least_damping=tuple(float(v) for v in np.min(least, axis=0)) if least else (0.0, 0.0),
    )  # fmt: skip
    with np.errstate(divide="ignore", invalid="ignore"):
        error = np.abs(out(omega[nodes]) - known[nodes]).max(axis=0) / peak
    object.__setattr__(out, "error", np.where(significant & together, error, np.nan))
    return out


def _fitting_grid(data, natural) -> tuple[np.ndarray, np.ndarray]:
    """Return frequencies [rad/s] to fit at and what an error of K counts there at least: the data's (1), between and beyond them."""
    low, high = data[0], data[-1]
    natural = np.outer(np.asarray(natural), [0.985, 1.0, 1.015]).ravel()  # resonances, and how they rise and fall
    between = np.concatenate([(data[1:] + data[:-1]) / 2, [w for w in natural if low < w < high]])
    tail = np.linspace(high, max(1.35 * high, TOP), 16)[1:]
    beyond = np.concatenate([[low / 4, low / 2], [w for w in natural if not low < w < high], tail, high * np.array([1.5, 2.0])])
    floor = np.repeat([1.0, BETWEEN, BEYOND], [len(data), len(between), len(beyond)])
    omega, first = np.unique(np.concatenate([data, between, beyond]), return_index=True)
    return omega, floor[first]


def _significant(peak, inertia) -> np.ndarray:
    """Return which pairs (6, 6) radiate, from the peaks (6, 6) of their |K| and what rounding is measured by (6)."""
    diagonal = np.diag(peak)
    largest = np.array([diagonal[:3].max()] * 3 + [diagonal[3:].max()] * 3)
    dead = (diagonal <= ABSENT * largest) | (diagonal <= 1e-12 * inertia)  # a hull of strips alone has no radiation
    return (peak > SIGNIFICANT * np.sqrt(np.outer(diagonal, diagonal))) & (peak > 0) & ~dead & ~dead[:, None]


def _symmetric(upper) -> np.ndarray:
    """Return the symmetric matrix (..., m, m) of upper triangles (..., m (m + 1) / 2)."""
    upper = np.asarray(upper)
    m = int((np.sqrt(8 * upper.shape[-1] + 1) - 1) / 2)
    i, j = np.triu_indices(m)
    out = np.zeros((*upper.shape[:-1], m, m), dtype=upper.dtype)
    out[..., i, j] = out[..., j, i] = upper
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
    """A passive fit of a block: the fit of G, the weights that made it, its largest error, least damping eigenvalue before and after."""

    found: RationalFit
    weight: np.ndarray
    error: float
    before: float
    after: float


def _fit_block(omega, data, urgent, floor, target: float, most: int) -> _Passive:
    """Return the passive fit of G = K / (i omega) of one block (n, m, m) with the fewest poles that reach the target.

    Poles are added where the error is largest; a single pair is cheap enough to start afresh each time besides. Data that are not quite causal or passive themselves may not let any number reach
    the target; then the fewest poles within two per cent of the best error are taken.
    """
    rows, columns_ = np.triu_indices(data.shape[1])
    values, nodes = data[:, rows, columns_], floor == 1
    peak = np.maximum(np.abs(values[nodes]).max(axis=0), 1e-300)
    share = RESPONSE * np.where(nodes, 1.0, 0.6)[:, None]
    need = np.clip(share * urgent[:, rows, columns_] * peak, floor[:, None], MOST) / peak
    problem = _Problem(
        omega=omega, g=values / (1j * omega[:, None]), weight=_weights(omega, values, nodes, peak, need), part=omega[:, None] * need,
        scale=np.sqrt(peak[rows == columns_]),
    )  # fmt: skip
    low, high = omega[nodes][[0, -1]]
    order, grown, tried = FEWEST, None, []
    while True:
        starts = [starting_poles(order, 4 * low, high, 2)] if grown is None or len(rows) == 1 else []
        fits = [_from(problem, poles) for poles in [*starts, *([] if grown is None else [grown])]]
        tried.append(min(fits, key=lambda f: f.error))
        errors = [t.error for t in tried]
        stuck = min(errors) > 0.9 * min(errors[:-PATIENCE], default=np.inf)
        order += MORE
        if errors[-1] <= target or stuck or order > most:
            break
        worst = np.abs(tried[-1].found(omega) - problem.g) * problem.part
        grown = np.append(tried[-1].found.poles, (-0.05 + 1j) * omega[worst.max(axis=1).argmax()])
    enough = max(target, 1.02 * min(errors))
    return _exactly_passive(problem, next(t for t, e in zip(tried, errors, strict=True) if e <= enough))


def _from(problem: _Problem, poles) -> _Passive:
    """Return the passive fit with the poles that vector fitting finds from some to start from."""
    found, _ = fit(problem.omega, problem.g, problem.weight, poles, kind="fast", rounds=3, iterations=5, part=problem.part)
    return _passive(problem, found.poles)


def _weights(omega, values, nodes, peak, need) -> np.ndarray:
    """Return weights (2, n, c) of G's real part (added mass) and imaginary part (damping).

    An error of K counts as `need` says; where the damping is small (at low frequency, where drag-damped modes live) its own error
    counts for more.
    """
    damping = np.abs(values.real) / peak
    added = np.maximum(omega, omega[nodes][0] * 4)[:, None] * need
    return np.stack([added, added * (1 + 0.06 / (0.003 + damping))])


def _realise(found: RationalFit) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return A, B, C of one block: one copy of the poles for each input; coefficients (b, m (m + 1) / 2) of G."""
    a, b = realisation(found.poles)
    c = np.swapaxes(_symmetric((found.coefficients.T @ a).T), 0, -1)
    m = len(c)
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


@dataclass(frozen=True, eq=False, kw_only=True)
class _Problem:
    """G (n, c) of one block at omega (n) [rad/s], weight (2, n, c) of the least squares, part (n, c) of the error judged, scale (m)
    of the degrees of freedom."""

    omega: np.ndarray
    g: np.ndarray
    weight: np.ndarray
    part: np.ndarray
    scale: np.ndarray


def _passive(problem: _Problem, poles, rounds: int = 6) -> _Passive:
    """Return the best fit with given poles whose damping matrix is nowhere negative on a grid.

    Least squares under the linear conditions u^T Re K(i omega) u >= 0, u the eigenvector of a negative minimum, which are
    added until no negative minimum is left (cutting planes; the set of passive coefficients is convex). Between rounds
    points with large errors gain weight. Cf. Gustavsen, IEEE Trans. Power Delivery 23(4), 2008.
    """
    now, best, before = problem.weight, None, None
    check, planes = _check_grid(poles, problem.omega), None
    for _ in range(rounds):
        tried, planes = _passive_fit(problem, now, poles, check, planes)
        before = tried.before if before is None else before
        if best is None or tried.error < best.error:
            best = tried
        error = np.abs(tried.found(problem.omega) - problem.g) * problem.part
        gain = np.sqrt(0.1 * error.max() + error)
        now = now * (gain / gain.mean())
    return replace(best, before=before)


def _exactly_passive(problem: _Problem, best: _Passive) -> _Passive:
    """Return a fit without the dips of the damping that are narrower than the grid of `_passive`."""
    check, planes, before = _check_grid(best.found.poles, problem.omega), None, best.before
    for _ in range(8):
        exact, dips = least_damping(*_realise(best.found), problem.scale, problem.omega.max() / 2)
        best = replace(best, before=before, after=exact)
        if exact > -PASSIVE or not dips:
            break
        check = np.union1d(check, dips)
        best, planes = _passive_fit(problem, best.weight, best.found.poles, check, planes)
    return best


def _passive_fit(problem: _Problem, weight, poles, check, planes) -> tuple[_Passive, np.ndarray]:
    """Return the least-squares fit of G (n, c) that is passive on a check grid (w) [rad/s], and the planes that hold it."""
    space = admissible(poles, "fast")
    basis = columns(1j * problem.omega, poles, space, "fast")
    rows = (1j * check[:, None] * columns(1j * check, poles, space, "fast")).real
    free, roots = _least_squares(basis, problem.g, weight)
    if planes is None:
        planes = np.zeros((0, free.size))
    z, planes, lowest = _cutting_planes(free, roots, rows, problem.scale, planes)
    error = float((np.abs(basis @ z - problem.g) * problem.part).max())
    return _Passive(rational(poles, space, z, "fast"), weight, error, *lowest), planes


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
