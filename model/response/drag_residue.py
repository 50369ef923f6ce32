"""Drag to third order: what the linearisation of |u| u leaves over, and what it does to the floater.

For a Gaussian velocity of standard deviation s, |u| u = s^2 (c1 He1 + c3 He3 + ...)(u / s) in Hermite polynomials, c1^2 = 8 / pi, c3^2 = 2 / (9 pi).
The first term is Borgman's linear drag. The third is a force of its own, not coherent with the waves, whose covariance between two
elements is 6 c3^2 K s^2 K' s'^2 rho^3 (Borgman 1967). It moves the floater, that motion changes the drag, and one part of the change
follows the waves again: a linear memory force with the kernel -(4 / pi) K s K' s' y rho^2, where y is the velocity at one element
after an impulse on the other. It takes damping away at the resonances, because drag limits the largest motions most.

That is the first order of a series which overshoots where drag is the only damping. Its excess kurtosis k1 is therefore closed
to k1 / (1 + beta |k1|) with the beta that gives an oscillator damped by |v| v alone, in white noise, its exact kurtosis
(stochastic averaging; Roberts and Spanos, Random Vibration and Statistical Linearization, 1990, ch. 7), and forces likewise.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array
from scipy.special import gamma

from model.response.drag_iteration import DragProblem, trapezoid_weights, velocity_covariance

C3 = np.sqrt(2 / np.pi) / 3
_EXACT = 3 - 1.5 * gamma(2) * gamma(2 / 3) / gamma(4 / 3) ** 2  # minus the excess kurtosis of v when |v| v is the only damping
BETA = 1 / _EXACT - 4 / 3  # first order says 3/4 there
ALIKE = 0.9  # elements whose velocities correlate more than this count as one
LAGS = 1024
_BLOCK = 64
_ENERGY = 0.999  # share of the velocities' variance below half the highest frequency that the lags resolve


@dataclass(frozen=True, eq=False, kw_only=True)
class Residue:
    """What drag adds to its linearisation, on the platform motions kept (p) and the problem's frequencies (n): damping (n, p, p) complex,
    the waves' force (m, n, p) per metre, force_spectrum (n, p, p) one-sided per rad/s of the incoherent force; kurtosis (g), the
    excess kurtosis of the groups' velocities.
    """

    damping: np.ndarray
    wave_force: np.ndarray
    force_spectrum: np.ndarray
    kurtosis: np.ndarray


@dataclass(frozen=True, eq=False, kw_only=True)
class Groups:
    """Elements that move alike, each along the direction in which it moves most: water (g, m, n) velocity per metre, motion (g, p) per
    unit of platform motion, factor (g) sum of K [kg/m]; lattice of their lags.
    """

    water: np.ndarray
    motion: np.ndarray
    factor: np.ndarray
    lattice: Lattice


@dataclass(frozen=True, eq=False, kw_only=True)
class Lattice:
    """Uniform frequencies and lags beside the problem's own frequencies omega (n): lags of `step` [s], `count` of them on both sides;
    shares (n, count / 2 + 1) of what is at omega that go to the uniform frequencies next to it, width (n) [rad/s] of omega.
    """

    omega: np.ndarray
    width: np.ndarray
    step: float
    count: int
    shares: csr_array

    def series(self, values) -> np.ndarray:
        """Return Re sum of values (..., n) e^{i omega t} at the lags (..., t), those before zero in the second half."""
        lines = (self.shares.T @ values.reshape(-1, values.shape[-1]).T).T
        return np.fft.irfft(lines, self.count).reshape(*values.shape[:-1], self.count) * (self.count / 2)

    def impulse(self, transfer) -> np.ndarray:
        """Return the causal impulse response (..., t / 2) of transfer functions (..., n), halved at zero lag for sums."""
        out = self.series(transfer.real * self.width)[..., : self.count // 2] * (2 / np.pi)
        out[..., 0] /= 2
        return out

    def transform(self, kernel) -> np.ndarray:
        """Return the integral of causal kernels (..., t / 2) with e^{-i omega t} on omega (..., n)."""
        return self._at(np.fft.rfft(kernel, self.count) * self.step)

    def spectrum(self, covariance) -> np.ndarray:
        """Return one-sided spectra (..., n) per rad/s of covariances (..., t)."""
        return self._at(np.fft.rfft(covariance) * (self.step / np.pi))

    def _at(self, lines) -> np.ndarray:
        """Return values (..., n) on omega between those on the uniform frequencies (..., k), zero above them."""
        return (self.shares @ lines.reshape(-1, lines.shape[-1]).T).T.reshape(*lines.shape[:-1], -1)


def group_elements(problem: DragProblem, solution, here, lags: int = LAGS) -> Groups | None:
    """Return the elements of one state grouped by how they move in a solution (n, q, m + w) with linear drag, None when none moves."""
    rate = 1j * problem.omega[:, None, None] * solution[:, here]
    variance, axes = np.linalg.eigh(velocity_covariance(problem, solution[None], here)[0])
    std, along = np.sqrt(variance[:, 1]), axes[..., 1]
    if not std.max(initial=0.0) > 0:
        return None
    motion = np.einsum("ea,eai->ei", along, problem.motion)[:, problem.rows]
    water = np.einsum("ea,mean->emn", along, problem.water.reshape(-1, len(std), 2, len(problem.omega)))
    velocity = _relative(water, motion, rate)
    share, factor = _shares(problem.members.factor, std, _scaled(problem, velocity))
    water, motion = np.einsum("ge,emn->gmn", share, water), share @ motion
    power = (np.abs(_scaled(problem, _relative(water, motion, rate))) ** 2).sum(axis=1)
    return Groups(water=water, motion=motion, factor=factor, lattice=_lattice(problem.omega, power, lags))


def residue(problem: DragProblem, groups: Groups, solution, receptance, here) -> Residue:
    """Return what drag adds to its linearisation in one state.

    solution (n, q, m + w) at the inputs' frequencies, receptance (n, q, q) of the same equations, platform motions at places `here`.
    """
    lattice, motion, places = groups.lattice, groups.motion, np.asarray(here)
    iw = 1j * problem.omega[:, None, None]
    rho, std = _correlation(problem, groups, iw * solution[:, places])
    impulse = lattice.impulse(np.moveaxis(iw * receptance[:, places[:, None], places], 0, -1))
    between = _both(motion, impulse)
    square = rho * rho
    cube, ahead = square * rho, slice(0, between.shape[-1])
    strength = groups.factor * std
    first = -24 * C3 / std * ((between * cube[..., ahead]).sum(axis=-1) @ (strength * std)) * lattice.step
    strength = strength / np.sqrt(1 + BETA * np.abs(first))
    kernel = between * square[..., ahead] * (-18 * C3**2 * np.outer(strength, strength))[..., None]
    memory = lattice.transform((motion.T @ kernel.swapaxes(0, 1)).swapaxes(0, 1))
    push = (strength * std)[:, None] * motion
    covariance = 6 * C3**2 * _both(push.T, cube)
    return Residue(
        damping=np.einsum("ihn,hj->nij", memory, motion), wave_force=np.einsum("ihn,hmn->mni", memory, groups.water),
        force_spectrum=np.moveaxis(lattice.spectrum(covariance), -1, 0), kurtosis=first / (1 + BETA * np.abs(first)),
    )  # fmt: skip


def _both(left, series) -> np.ndarray:
    """Return left (a, i) times series (i, j, t) times left transposed, (a, b, t), in products too small for threads to pay."""
    return left @ (left @ series.swapaxes(0, 1)).swapaxes(0, 1)


def _relative(water, motion, rate) -> np.ndarray:
    """Return relative velocities (e, m + w, n) of elements per input, from water (e, m, n), motion (e, p) and platform rates (n, p, m + w)."""
    out = -np.einsum("ep,npi->ein", motion, rate)
    out[:, : water.shape[1]] += water
    return out


def _scaled(problem: DragProblem, velocity) -> np.ndarray:
    """Return velocities (e, m + w, n) per input times the root of the inputs' energies."""
    return velocity * np.sqrt(np.concatenate([problem.wave_weight[0], problem.wind_weight[0]])[: velocity.shape[1]])


def _shares(factor, std, velocity) -> tuple[np.ndarray, np.ndarray]:
    """Return the shares (g, e) of elements in the groups, weighted by K s and with the sign of their correlation, and sums (g) of K."""
    flat = np.ascontiguousarray(velocity).reshape(len(std), -1).view(float)
    parts = [flat[:, k : k + _BLOCK] for k in range(0, flat.shape[1], _BLOCK)]
    alike = sum(x @ x.T for x in parts) / np.maximum(np.outer(std, std), 1e-300)
    left = np.argsort(-factor * std**2)
    left = left[std[left] > 1e-6 * std.max()]
    shares, factors = [], []
    while len(left):
        inside = np.abs(alike[left[0], left]) > ALIKE
        members, weight = left[inside], np.zeros(len(std))
        weight[members] = factor[members] * std[members]
        shares.append(np.sign(alike[left[0]]) * weight / weight.sum())
        factors.append(weight.sum() ** 2 / (weight @ std))
        left = left[~inside]
    return np.array(shares), np.array(factors)


def _lattice(omega, power, count: int) -> Lattice:
    """Return lags and frequencies that resolve twice the frequencies where velocities of powers (g, n) have their energy."""
    share = np.cumsum((power / power.sum(axis=1, keepdims=True)).max(axis=0))
    highest = omega[np.searchsorted(share, _ENERGY * share[-1])]
    step = np.pi / (2 * highest)
    at = omega * step * count / (2 * np.pi)
    inside = np.flatnonzero(at < count // 2)
    low = at[inside].astype(int)
    part = at[inside] - low
    shares = csr_array(
        (np.concatenate([1 - part, part]), (np.tile(inside, 2), np.concatenate([low, low + 1]))), shape=(len(omega), count // 2 + 1)
    )
    return Lattice(omega=omega, width=trapezoid_weights(omega), step=step, count=count, shares=shares)


def _correlation(problem: DragProblem, groups: Groups, rate) -> tuple[np.ndarray, np.ndarray]:
    """Return the correlation coefficients (g, g, t) of the groups' velocities, those of the first index later by the lag, and their
    standard deviations (g).
    """
    scaled = np.ascontiguousarray(_scaled(problem, _relative(groups.water, groups.motion, rate)).transpose(2, 0, 1))
    cross = scaled @ scaled.conj().swapaxes(1, 2)
    if problem.incoherent is not None:
        cross = cross + groups.motion @ problem.incoherent @ groups.motion.T
    out = groups.lattice.series(np.moveaxis(cross, 0, -1))
    std = np.sqrt(np.einsum("ggt->gt", out)[:, 0])
    out /= np.outer(std, std)[..., None]
    return out, std
