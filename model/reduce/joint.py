"""Coefficients of the radiation fit of all degrees of freedom together, from what they do to the responses.

With the poles given, K is linear in its coefficients, and so is, about any fit, the relative error of a response: minus gain times
i omega dK times the platform's motion. The largest of all errors, of pairs and of responses, each as a fraction of what is allowed,
is made small by reweighted least squares (Lawson 1961) under the linear conditions of passivity.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, replace

import numpy as np

from model.reduce.passivity import PASSIVE, Ports, check_grid, least_damping, nearest_passive, realise
from model.reduce.rational import RationalFit, admissible, columns, orthogonal, pole_at, rational
from model.reduce.targets import PHASE, Paths

ALLOWED_PAIR, ALLOWED_RESPONSE = 0.009, 0.013  # of the peak; relative, phases counting by PHASE
SLACK = 0.77  # of a pair's error to start from is allowed, where that is larger
ROUNDS, FEW = 12, 6  # of reweighting, with the poles to start from and with more
ENOUGH = 0.8  # of what is allowed
GROWTH, PATIENCE = 12, 4  # poles added at most, and tried without gain before a pair is let be
DECAYS = (0.05, 0.15, 0.1)  # of the poles added, relative to their frequency
LIGHT = 0.003  # least weight beside the largest, so that nothing is let go
LEAN = 0.01  # what errors between and beyond the data count beside those that are limited


@dataclass(frozen=True, eq=False, kw_only=True)
class KnownRadiation:
    """K (n, 6, 6) at omega (n) [rad/s], and what its error counts there at least: floor (n) 1 at the frequencies of the data, less elsewhere."""

    omega: np.ndarray
    k: np.ndarray
    floor: np.ndarray

    @property
    def nodes(self) -> np.ndarray:
        """True (n) at the frequencies of the data."""
        return self.floor == 1


def meet_responses(
    fits: Sequence[RationalFit], blocks: Sequence[Sequence[int]], known: KnownRadiation, paths: Paths | None
) -> tuple[list[RationalFit], float]:
    """Return fits of G = K / (i omega) of all blocks with the same poles, which make the largest error of any pair or response small,
    and the least eigenvalue of their scaled damping matrices.

    fits : to start from (passive), one for each block of degrees of freedom (places among six)
    paths : responses; None for the pairs alone
    """
    if not fits:
        return [], 0.0
    problem = _Joint(fits, blocks, known, _nothing() if paths is None else paths)
    weights = problem.even_weights()
    best = _lawson(problem, weights, ROUNDS)
    now, idle = best, 0
    for _ in range(GROWTH):
        if now.errors.worst <= 1:
            break
        now = _lawson(now.problem.with_pole(now.z, *now.problem.where(now.z, now.errors)), now.weights, FEW)
        idle = 0 if now.errors.worst < best.errors.worst else idle + 1
        best = best if idle else now
        if idle == PATIENCE:
            now = best = best.relaxed()
            idle = 0
    return _exactly_passive(best.problem, best.z, best.equations)


@dataclass(frozen=True, eq=False)
class _Solved:
    """Coefficients with the smallest largest error, the equations that gave them, their errors, and weights to go on with."""

    problem: _Joint
    z: np.ndarray
    equations: tuple
    errors: _Errors
    weights: tuple

    def relaxed(self) -> _Solved:
        """Return the same where the pair that errs most is allowed to: more poles do not help it."""
        pair = self.errors.pair.max(axis=0)
        allowed = self.problem.allowed * np.where(pair == pair.max(), np.maximum(pair, 1.0), 1.0)
        problem = self.problem.allowing(allowed)
        return replace(self, problem=problem, errors=problem.errors(self.z))


def _lawson(problem: _Joint, weights, rounds: int) -> _Solved:
    """Return the best of some rounds of reweighting."""
    z, planes, best = problem.start, None, None
    for _ in range(rounds):
        equations = problem.equations(z, *weights)
        z, planes = _solve(*equations, problem.ports, planes)
        found = problem.errors(z)
        if best is None or found.worst < best.errors.worst:
            best = _Solved(problem, z, equations, found, weights)
        if found.worst < ENOUGH:
            break
        weights = _reweighted(weights, found)
    return replace(best, weights=weights)


def _exactly_passive(problem: _Joint, z, equations) -> tuple[list[RationalFit], float]:
    """Return the fits without the dips of the damping that are narrower than the check grids, and the least eigenvalue left."""
    ports, planes, top = problem.ports, None, problem.known.omega.max() / 2
    for _ in range(8):
        fits = problem.fits(z)
        seen = [least_damping(*realise(f), p.scale, top) for f, p in zip(fits, ports, strict=True)]
        if all(low > -PASSIVE or not dips for low, dips in seen):
            break
        ports = [problem.look_at(k, dips) for k, (_, dips) in enumerate(seen)]
        z, planes = _solve(*equations, ports, planes)
    return fits, min(low for low, _ in seen)


def _nothing() -> Paths:
    """Return paths of one response that does not count."""
    none = np.zeros((1, 1, 6), dtype=complex)
    return Paths(
        omega=np.ones(1), gain=none, motion=none, share=none[..., 0], by_waves=np.ones(1, dtype=bool), compliance=np.zeros((1, 6, 6)) + 0j,
        memory=np.zeros((1, 6, 6)) + 0j, data=np.zeros(1, dtype=bool),
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Errors:
    """Errors as fractions of what is allowed: of responses (n, 2 r), real parts first, and of pairs at the data (k, p)."""

    response: np.ndarray
    pair: np.ndarray

    @property
    def worst(self) -> float:
        return float(max(self.response.max(initial=0.0), self.pair.max(initial=0.0)))


class _Joint:
    """All pairs (p) of all blocks: where their coefficients stand among the unknowns, bases at the data and at the responses."""

    def __init__(self, fits, blocks, known: KnownRadiation, paths: Paths, allowed=None):
        self.first, self.blocks, self.known, self.paths = fits, blocks, known, paths
        self.spaces = [admissible(f.poles, "fast") for f in fits]
        both = np.concatenate([known.omega, paths.omega])
        self.turns = [orthogonal(self._basis_of(both, k))[1] for k in range(len(fits))]
        self.pairs, self.places, self.ports, self.checks, start, at = [], [], [], [], [], 0
        for b, (f, block) in enumerate(zip(fits, blocks, strict=True)):
            free = np.linalg.lstsq(self.turns[b], np.concatenate([self.spaces[b].T @ f.coefficients, f.constant[None]]), rcond=None)[0]
            each, count = free.shape
            self.pairs += [(block[i], block[j]) for i, j in zip(*np.triu_indices(len(block)), strict=True)]
            self.places += [slice(at + k * each, at + (k + 1) * each) for k in range(count)]
            scale = np.sqrt(np.abs(known.k[known.nodes][:, block, block]).max(axis=0))
            self.checks.append(check_grid(f.poles, known.omega))
            self.ports.append(Ports(self._turned(self.checks[-1], b).real, scale, slice(at, at + free.size)))
            start.append(free.T.ravel())
            at += free.size
        self.start, self.count = np.concatenate(start), at
        self.i, self.j = np.array(self.pairs).T
        self.here, self.there = self._basis(known.omega), self._basis(paths.omega)
        self.k = known.k[:, self.i, self.j]
        self.peak = np.abs(self.k[known.nodes]).max(axis=0)
        own = np.abs(self._memory(self.start, self.here) - self.k)[known.nodes].max(axis=0) / self.peak
        self.allowed = np.maximum(ALLOWED_PAIR, SLACK * own) if allowed is None else allowed
        self.lean = self._lean_rows()

    def where(self, z, found: _Errors) -> tuple[int, float]:
        """Return the block and the frequency [rad/s] of the largest error."""
        owner = np.concatenate([[b] * (len(block) * (len(block) + 1) // 2) for b, block in enumerate(self.blocks)])
        if found.pair.max() >= found.response.max():
            node, pair = np.unravel_index(found.pair.argmax(), found.pair.shape)
            return int(owner[pair]), float(self.known.omega[self.known.nodes][node])
        n, r = np.unravel_index(found.response.argmax(), found.response.shape)
        slope, change = self._slope(z)
        share = np.abs(slope[n, r % slope.shape[1]] * change[n])
        return int(np.argmax(np.bincount(owner, share))), float(self.paths.omega[n])

    def with_pole(self, z, block: int, omega: float) -> _Joint:
        """Return the problem with one pair of poles more in a block, starting from coefficients z."""
        fits = self.fits(z)
        old = fits[block]
        pole = pole_at(omega, omega * np.array(DECAYS), old.poles)
        more = np.concatenate([old.coefficients, np.zeros((2, old.coefficients.shape[1]))])
        fits[block] = replace(old, poles=np.append(old.poles, pole), coefficients=more)
        return _Joint(fits, self.blocks, self.known, self.paths, self.allowed)

    def allowing(self, allowed) -> _Joint:
        """Return the problem with other errors of the pairs (p) allowed."""
        out = copy(self)
        out.allowed = allowed
        return out

    def even_weights(self) -> tuple[np.ndarray, np.ndarray]:
        """Return weights of responses (n, 2 r) and pairs (k, p)."""
        return np.ones((len(self.paths.omega), 2 * self.paths.share.shape[1])), np.ones((int(self.known.nodes.sum()), len(self.pairs)))

    def errors(self, z) -> _Errors:
        """Return the errors of the responses and pairs."""
        slope, change = self._slope(z)
        response = np.einsum("nrp,np->nr", slope, change) / ALLOWED_RESPONSE
        pair = np.abs(self._memory(z, self.here) - self.k)[self.known.nodes] / (self.peak * self.allowed)
        return _Errors(np.abs(np.concatenate([response.real, PHASE * response.imag], axis=1)), pair)

    def equations(self, z, by_response, by_pair) -> tuple[np.ndarray, np.ndarray]:
        """Return matrix (e, u) and target (e) of the least squares about the coefficients z; weights as of `even_weights`.

        The responses of each frequency are first reduced to as many rows as there are unknown forces.
        """
        slope, _ = self._slope(z)
        rows = np.concatenate(
            [np.concatenate([slope.real, -slope.imag], axis=2), PHASE * np.concatenate([slope.imag, slope.real], axis=2)], axis=1
        )
        memory = self.paths.memory[:, self.i, self.j]
        known = np.einsum("nij,nj->ni", rows, np.concatenate([memory.real, memory.imag], axis=1))
        weighted = np.concatenate([rows, known[..., None]], axis=2) * (by_response / ALLOWED_RESPONSE)[..., None]
        triangle = np.linalg.qr(weighted, mode="r")
        tall = np.empty((*triangle.shape[:2], self.count))
        for p, (place, basis) in enumerate(zip(self.places, self.there, strict=True)):
            real, imaginary = triangle[:, :, p, None], triangle[:, :, len(self.pairs) + p, None]
            tall[..., place] = real * basis.real[:, None] + imaginary * basis.imag[:, None]
        nodes, each = self.known.nodes, by_pair / (self.peak * self.allowed)
        mine = self._pair_rows(nodes, [np.stack([w, w]) for w in each.T])
        parts = [(tall.reshape(-1, self.count), triangle[..., -1].ravel()), self.lean, mine]
        return np.concatenate([m for m, _ in parts]), np.concatenate([t for _, t in parts])

    def fits(self, z) -> list[RationalFit]:
        """Return the fits of the blocks with coefficients z."""
        out = []
        for f, space, turn, ports in zip(self.first, self.spaces, self.turns, self.ports, strict=True):
            pairs = len(ports.scale) * (len(ports.scale) + 1) // 2
            out.append(rational(f.poles, space, turn @ z[ports.place].reshape(pairs, -1).T, "fast"))
        return out

    def look_at(self, block: int, more: Sequence[float]) -> Ports:
        """Return the ports of a block with more frequencies [rad/s] in its check grid, which stay there."""
        self.checks[block] = np.union1d(self.checks[block], more)
        self.ports[block] = replace(self.ports[block], rows=self._turned(self.checks[block], block).real)
        return self.ports[block]

    def _basis_of(self, omega, block: int) -> np.ndarray:
        """Return K (n, f) of a block per coefficient of G."""
        return 1j * omega[:, None] * columns(1j * omega, self.first[block].poles, self.spaces[block], "fast")

    def _turned(self, omega, block: int) -> np.ndarray:
        """Return K (n, f) of a block per unknown."""
        return self._basis_of(omega, block) @ self.turns[block]

    def _basis(self, omega) -> list[np.ndarray]:
        """Return K (n, f) per unknown for each pair."""
        return [basis for k, block in enumerate(self.blocks) for basis in [self._turned(omega, k)] * (len(block) * (len(block) + 1) // 2)]

    def _memory(self, z, bases) -> np.ndarray:
        """Return K (n, p) of the pairs."""
        return np.stack([basis @ z[place] for basis, place in zip(bases, self.places, strict=True)], axis=1)

    def _slope(self, z) -> tuple[np.ndarray, np.ndarray]:
        """Return the relative change of the responses per change of K (n, r, p), exact for the change (n, p) that z makes."""
        memory, paths, i, j = self._memory(z, self.there), self.paths, self.i, self.j
        whole = paths.memory.copy()
        whole[:, i, j] = whole[:, j, i] = memory
        gain, rate = paths.gain_with(whole), 1j * paths.omega[:, None, None] * paths.motion
        across = np.where(i != j, gain[..., j] * rate[..., i], 0.0)
        return -paths.share[..., None] * (gain[..., i] * rate[..., j] + across), memory - paths.memory[:, i, j]

    def _pair_rows(self, where, weights) -> tuple[np.ndarray, np.ndarray]:
        """Return rows (e, u) and targets (e) of K at frequencies `where` (n): weights (2, k) of real and imaginary parts, for each pair."""
        rows, targets = [], []
        for p, (basis, place, w) in enumerate(zip(self.here, self.places, weights, strict=True)):
            own, values = np.zeros((2 * w.shape[1], self.count)), self.k[where, p]
            own[:, place] = np.concatenate([w[0][:, None] * basis[where].real, w[1][:, None] * basis[where].imag])
            rows.append(own)
            targets.append(np.concatenate([w[0] * values.real, w[1] * values.imag]))
        return np.concatenate(rows), np.concatenate(targets)

    def _lean_rows(self) -> tuple[np.ndarray, np.ndarray]:
        """Return rows of K everywhere with little weight, its damping with more where it is small (where drag-damped modes live)."""
        damping = np.abs(self.k.real) / self.peak
        weight = LEAN / ALLOWED_PAIR * self.known.floor[:, None] / self.peak
        both = np.stack([weight * (1 + 0.06 / (0.003 + damping)), weight])
        return self._pair_rows(np.ones(len(self.known.omega), dtype=bool), list(np.moveaxis(both, 2, 0)))


def _solve(matrix, target, ports, planes) -> tuple[np.ndarray, np.ndarray]:
    """Return the passive least-squares coefficients and the planes that hold them."""
    size = np.maximum(np.linalg.norm(matrix, axis=0), 1e-300)
    matrix = matrix / size
    values, vectors = np.linalg.eigh(matrix.T @ matrix)
    kept = values > 1e-13 * values[-1]
    root = vectors[:, kept] / np.sqrt(values[kept])
    free, root = root @ (root.T @ (matrix.T @ target)) / size, root / size[:, None]
    z, planes, _ = nearest_passive(free, root, ports, planes)
    return z, planes


def _reweighted(weights, found: _Errors) -> tuple[np.ndarray, np.ndarray]:
    """Return weights that grow where errors are large."""
    grown = [w * (0.05 * found.worst + e) ** 0.6 for w, e in zip(weights, (found.response, found.pair), strict=True)]
    largest = max(w.max(initial=0.0) for w in grown)
    return tuple(np.maximum(w / largest, LIGHT) for w in grown)
