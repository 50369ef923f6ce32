"""Radiation memory as a state space: passive rational fit of K(i omega) = B(omega) + i omega (A(omega) - A_inf).

K is the transform of the retardation functions (Cummins 1957; Ogilvie 1964). K(0) = 0 and K falls as 1/s, so K = s G with a
G that falls as s^-2; that is built into the fit, and the added mass at low frequency comes from G itself.
Reference for the properties: Perez and Fossen, Modeling, Identification and Control 30(1), 2009.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag
from scipy.optimize import linprog
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from model.conventions import PLATFORM_DOFS, freeze
from model.reduce.importance import Importance, pooled
from model.reduce.joint import KnownRadiation, meet_responses
from model.reduce.passivity import Ports, check_grid, nearest_passive, realise, symmetric
from model.reduce.rational import RationalFit, admissible, columns, fit, frequency_response, rational, starting_poles
from model.reduce.targets import Paths
from model.response.cummins import retardation_transform
from model.system.hydro import HydroCoefficients, infinite_added_mass

ABSENT = (
    1e-4  # of the largest translation or rotation: a smaller diagonal term is rounding (yaw of a body of revolution)
)
SIGNIFICANT = 0.01  # of the geometric mean of the two diagonal peaks
TARGET = 0.005  # of the peak, and of any response
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
        omega = np.asarray(omega, dtype=float)
        return frequency_response(self.a, self.b, self.c, omega) + 1j * omega[:, None, None] * self.added_mass_change


def least_error(hydro: HydroCoefficients, dof: int) -> float:
    """Return the least largest error that any passive kernel has of a motion's own K, a fraction of its peak.

    Damping that is nowhere negative, linear between the frequencies of the data and some beyond, and the added mass that causality lets
    follow from it, but for the one of infinite frequency, which is free: a linear programme, the modulus by sixteen directions. Above
    zero where added mass and damping of the data contradict each other.
    """
    omega = hydro.omega
    known = retardation_transform(hydro, omega)[:, dof, dof] / np.abs(retardation_transform(hydro, omega)[:, dof, dof]).max()
    grid = np.concatenate([[0.0], omega[0] * np.array([0.3, 0.6]), omega, omega[-1] * np.geomspace(1.02, 15, 50)])
    implied = omega[:, None] * _added_mass_of_hats(grid, omega)
    own = (grid[1:-1] == omega[:, None]).astype(float)
    turn = np.exp(-1j * np.arange(16) * np.pi / 8)[:, None, None]
    each = np.concatenate([own + 1j * implied, 1j * omega[:, None]], axis=1)
    rows = (turn * each).real.reshape(-1, each.shape[1])
    limit = np.concatenate([rows, -np.ones((len(rows), 1))], axis=1)
    cost = np.zeros(limit.shape[1])
    cost[-1] = 1.0
    bounds = [(0, None)] * (len(grid) - 2) + [(None, None), (0, None)]
    found = linprog(cost, A_ub=limit, b_ub=(turn[..., 0] * known).real.ravel(), bounds=bounds)
    return float(found.fun)


def _added_mass_of_hats(grid, omega) -> np.ndarray:
    """Return A - A_inf (n, k) at omega (n), not beyond the grid, of damping that is one at one inner point of a grid (k + 2) and falls
    linearly to zero at its neighbours: 2/pi times the principal value of the integral of B(x) / (x2 - omega2)."""
    w, x = omega[:, None], grid[None]
    with np.errstate(divide="ignore"):
        minus, plus = np.log(np.maximum(np.abs(x - w), 1e-14)), np.log(x + w)
    even, odd = np.diff((minus - plus) / (2 * w), axis=1), np.diff(minus + plus, axis=1) / 2  # integrals of 1 and x over each interval
    slope = 1 / np.diff(grid)
    rise = slope[:-1] * (odd[:, :-1] - grid[:-2] * even[:, :-1])
    fall = slope[1:] * (grid[2:] * even[:, 1:] - odd[:, 1:])
    return 2 / np.pi * (rise + fall)


def fit_radiation(
    hydro: HydroCoefficients, matters: Importance | None = None, responses: Paths | None = None, *, data=None, target: float = TARGET,
    most: int = MANY,
) -> RadiationFit:  # fmt: skip
    """Return a stable, passive state space of the radiation of a body.

    Parameters
    ----------
    hydro : coefficients about the platform reference point
    matters : what errors do to the responses; where they do much, poles are placed
    responses : to be met with the coefficients of all blocks together (`joint`)
    data : frequencies [rad/s] at which the coefficients were computed, by default all of `hydro`
    target : largest error sought, a fraction of each pair's peak at the frequencies of the data, and of any response everywhere
    most : number of poles up to which poles are added to each block until the target is reached; the best fit stays otherwise
    """
    omega, floor = _fitting_grid(hydro.omega if data is None else data, () if matters is None else matters.natural)
    urgent = np.zeros((len(omega), 6, 6)) if matters is None else pooled(matters.omega, matters.radiation, omega)
    known, nodes = retardation_transform(hydro, omega), floor == 1
    peak = np.abs(known[nodes]).max(axis=0)
    significant = _significant(peak, omega[nodes][-1] * np.abs(np.diag(infinite_added_mass(hydro))))
    blocks = _blocks(significant)
    parts = [np.ix_(block, block) for block in blocks]
    fits = [_fit_block(omega, known[:, *here], urgent[:, *here], floor, target, most) for here in parts]
    found, after = meet_responses([f.found for f in fits], blocks, KnownRadiation(omega=omega, k=known, floor=floor), responses)
    change, together = np.zeros((6, 6)), np.zeros((6, 6), dtype=bool)
    for here, f in zip(parts, found, strict=True):
        change[here], together[here] = symmetric(f.constant), True
    a, b, c = _stack([(block, *realise(f)) for block, f in zip(blocks, found, strict=True)])
    out = RadiationFit(
        a=a, b=b, c=c, added_mass_change=change, error=np.zeros((6, 6)), orders=tuple(f.order for f in found),
        blocks=tuple(tuple(PLATFORM_DOFS[k] for k in block) for block in blocks),
        least_damping=(min((f.before for f in fits), default=0.0), after),
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


def _blocks(significant: np.ndarray) -> list[list[int]]:
    """Return the groups of degrees of freedom that significant pairs connect."""
    count, label = connected_components(coo_array(significant), directed=False)
    groups = [list(np.flatnonzero(label == k)) for k in range(count)]
    return [g for g in groups if significant[np.ix_(g, g)].any()]


@dataclass(frozen=True, eq=False)
class _Passive:
    """A passive fit of a block: the fit of G, its largest error, the least damping eigenvalue before it was made passive."""

    found: RationalFit
    error: float
    before: float


def _fit_block(omega, data, urgent, floor, target: float, most: int) -> _Passive:
    """Return the passive fit of G = K / (i omega) of one block (n, m, m) with the fewest poles that reach the target.

    Poles are added where the error is largest; a single pair is cheap enough to start afresh each time besides. Data that are not
    quite causal or passive themselves may not let any number reach the target; then the fewest poles within two per cent of the best error are taken.
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
    return next(t for t, e in zip(tried, errors, strict=True) if e <= enough)


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

    Least squares; between rounds points with large errors gain weight.
    """
    now, best, before = problem.weight, None, None
    space, check = admissible(poles, "fast"), check_grid(poles, problem.omega)
    basis = columns(1j * problem.omega, poles, space, "fast")
    rows = (1j * check[:, None] * columns(1j * check, poles, space, "fast")).real
    ports, planes = Ports(rows, problem.scale, slice(0, basis.shape[1] * problem.g.shape[1])), None
    for _ in range(rounds):
        free, root = _least_squares(basis, problem.g, now)
        z, planes, (low, _) = nearest_passive(free, root, [ports], planes)
        coefficients = z.reshape(-1, basis.shape[1]).T
        error = np.abs(basis @ coefficients - problem.g) * problem.part
        before = low if before is None else before
        if best is None or error.max() < best.error:
            best = _Passive(rational(poles, space, coefficients, "fast"), float(error.max()), before)
        gain = np.sqrt(0.1 * error.max() + error)
        now = now * (gain / gain.mean())
    return best


def _least_squares(basis, g, weight) -> tuple[np.ndarray, np.ndarray]:
    """Return free coefficients (c f), response by response, and the inverse root of the normal equations."""
    out, roots = [], []
    for k in range(g.shape[1]):
        tall = np.concatenate([weight[0][:, [k]] * basis.real, weight[1][:, [k]] * basis.imag])
        target = np.concatenate([weight[0][:, k] * g[:, k].real, weight[1][:, k] * g[:, k].imag])
        q, r = np.linalg.qr(tall)
        inverse = np.linalg.pinv(r, rcond=1e-10)
        out.append(inverse @ (q.T @ target))
        roots.append(inverse)
    return np.concatenate(out), block_diag(*roots)
