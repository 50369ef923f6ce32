"""Many designs in one sea state at once: drag to convergence for each, then motions, with arrays over designs and frequencies.

The same equations as `model.response.solve`, whose result each design has; there one design, here N that differ in everything
but the frequencies, the sea and the wind. A design that has converged keeps its solution, so it does not matter in what company
it is solved.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.environment.airy import wave_velocity, wavenumber
from model.response.batch import solve_equations
from model.system.drag import DragMembers, borgman_coefficients, element_motion, resisted_directions

_CHUNK = 4096  # equations solved together: bounds the memory they fill


@dataclass(frozen=True, eq=False, kw_only=True)
class ElementSet:
    """Drag elements of N designs, e each: factor (N, e), motion (N, 2 e, 6) along their resisted directions per unit of platform
    motion, water (N, 2 e, n) the water's velocity along them per metre of wave amplitude.
    """

    factor: np.ndarray
    motion: np.ndarray
    water: np.ndarray

    def some(self, index) -> ElementSet:
        """Return those of some designs."""
        return ElementSet(factor=self.factor[index], motion=self.motion[index], water=self.water[index])


@dataclass(frozen=True, eq=False, kw_only=True)
class PopulationResponse:
    """Motions (N, q, r, n) complex per unit of each input: the waves' amplitude, then the wind inputs; drag_damping (N, 6, 6);
    iterations (N) and converged (N) of the drag.
    """

    motion: np.ndarray
    drag_damping: np.ndarray
    iterations: np.ndarray
    converged: np.ndarray


def element_set(members: DragMembers, designs: int, omega, heading: float, depth: float, gravity: float) -> ElementSet:
    """Return the drag elements of N designs, listed design by design, on frequencies omega (n) [rad/s] in waves of a heading [rad]."""
    directions = resisted_directions(members)
    motion = element_motion(members, directions).reshape(designs, -1, 6)
    along, upward = wave_velocity(omega, wavenumber(omega, depth, gravity), depth, members.position, heading)
    level, rise = directions[..., 0] * np.cos(heading) + directions[..., 1] * np.sin(heading), directions[..., 2]
    water = level[..., None] * along[:, None]
    tilted = rise != 0  # of upright members neither direction is
    water[tilted] += rise[tilted][:, None] * upward[np.nonzero(tilted)[0]]
    return ElementSet(factor=members.factor.reshape(designs, -1), motion=motion, water=water.reshape(designs, -1, len(omega)))


def solve_population(
    omega, dynamic, force, weight, elements: ElementSet, *, tolerance: float = 3e-9, limit: int = 60
) -> PopulationResponse:
    """Return the responses of N designs, drag linearised for the relative velocity and iterated to convergence.

    omega (n) [rad/s]; dynamic (N, q, q, n) stiffness without drag, platform motions first; force (N, q, r, n), waves first, then
    wind inputs; weight (r, n): spectrum of each input times the frequency step. tolerance on the change of any element's coefficient
    over the largest.
    """
    count, _, r, n = force.shape
    base, follow = _without_followers(dynamic, force)
    out = np.empty((count, 6, r, n), dtype=complex)
    damping, steps, done = np.zeros((count, 6, 6)), np.full(count, limit), np.zeros(count, dtype=bool)
    index, some, history = np.arange(count), elements, []
    still = _water_covariance(some, weight[0])
    linear = borgman_coefficients(still)
    for step in range(1, limit + 1):
        per_velocity = np.einsum("neai,neab->nieb", _pairs(some), some.factor[..., None, None] * linear, optimize=True)
        per_velocity = per_velocity.reshape(len(index), 6, -1)
        now = per_velocity @ some.motion
        motion = _solved(base, index, now, _times(per_velocity, some.water), omega)
        new = borgman_coefficients(_relative_covariance(some, still, motion, weight, omega))
        change = np.abs(new - linear).max(axis=(1, 2, 3)) / np.maximum(np.abs(new).max(axis=(1, 2, 3)), 1e-300)
        ready = (change < tolerance) | (step == limit)
        at, stay = index[ready], ~ready
        out[at], damping[at], steps[at], done[at] = motion[ready], now[ready], step, change[ready] < tolerance
        if not stay.any():
            break
        history = [(a[stay], b[stay]) for a, b in [*history[-1:], (linear, new)]]
        if not stay.all():
            index, some, still = index[stay], some.some(stay), still[stay]
        linear = _mixed(history)
    return PopulationResponse(motion=follow(out), drag_damping=damping, iterations=steps, converged=done)


def _without_followers(dynamic, force):
    """Return the platform's equations (6, 6 + r, N, n), the other degrees of freedom eliminated, and the function that gives back
    all motions (N, q, r, n) from the platform's. Drag acts on the platform alone, so this is done once.
    """
    base = np.concatenate([dynamic, force], axis=2).transpose(1, 2, 0, 3).copy()
    q = len(base)
    for k in range(q - 1, 5, -1):
        base[k] /= base[k, k].copy()
        for i in range(k):
            base[i] -= base[i, k].copy() * base[k]
    platform = np.ascontiguousarray(base[:6, [*range(6), *range(q, base.shape[1])]])

    def follow(motion):
        full = np.empty((motion.shape[0], q, *motion.shape[2:]), dtype=complex)
        full[:, :6] = motion
        for k in range(6, q):
            full[:, k] = base[k, q:].transpose(1, 0, 2) - sum(base[k, j][:, None] * full[:, j] for j in range(k))
        return full

    return platform, follow


def _pairs(elements: ElementSet) -> np.ndarray:
    return elements.motion.reshape(*elements.factor.shape, 2, 6)


def _times(real: np.ndarray, field: np.ndarray) -> np.ndarray:
    """Return the product (N, i, n) of real (N, i, k) and complex (N, k, n) arrays."""
    return (real @ field.view(float)).view(complex)


def _solved(base, index, damping, wave_force, omega) -> np.ndarray:
    """Return the platform's motions (N, 6, r, n), drag damping (N, 6, 6) and the waves' drag force (N, 6, n) added to some of the
    equations.
    """
    n = len(omega)
    out = np.empty((len(index), 6, base.shape[1] - 6, n), dtype=complex)
    step = max(1, _CHUNK // n)
    for start in range(0, len(index), step):
        part = slice(start, start + step)

        def equations(part=part):
            work = base[:, :, index[part]]
            work[:, :6].imag += damping[part].transpose(1, 2, 0)[..., None] * omega
            work[:, 6] += wave_force[part].transpose(1, 0, 2)
            return work

        out[part] = solve_equations(equations).transpose(2, 0, 1, 3)
    return out


def _water_covariance(elements: ElementSet, weight) -> np.ndarray:
    """Return the covariances (N, e, 2, 2) of the water's velocity along the resisted directions."""
    v = (elements.water * np.sqrt(weight)).reshape(*elements.factor.shape, 2, -1)
    return _self_products(v)


def _relative_covariance(elements: ElementSet, still, motion, weight, omega) -> np.ndarray:
    """Return the covariances (N, e, 2, 2) of the relative velocity: the water's own (still), the motions', less those of both."""
    rate = motion * (1j * omega)
    driven = np.ascontiguousarray(rate[:, :, 0] * weight[0]).view(float)
    cross = elements.water.view(float) @ driven.swapaxes(1, 2)
    scaled = (rate * np.sqrt(weight)).reshape(len(rate), 6, -1).view(float)
    pairs = _pairs(elements)
    own = scaled @ scaled.swapaxes(1, 2)
    moved = (pairs @ own[:, None]) @ pairs.swapaxes(2, 3)
    mixed = cross.reshape(*elements.factor.shape, 2, 6) @ pairs.swapaxes(2, 3)
    out = still + moved - mixed - mixed.swapaxes(2, 3)
    for k in (0, 1):  # where water and body move nearly alike, rounding must not make the difference vanish
        out[..., k, k] = np.maximum(out[..., k, k], 1e-13 * (moved[..., k, k] + still[..., k, k]))
    return out


def _self_products(v: np.ndarray) -> np.ndarray:
    """Return the covariances (N, e, 2, 2) of pairs (N, e, 2, n) of complex amplitudes."""
    x, y = v[:, :, 0].view(float), v[:, :, 1].view(float)
    out = np.empty((*x.shape[:2], 2, 2))
    out[..., 0, 0], out[..., 1, 1] = np.einsum("nek,nek->ne", x, x), np.einsum("nek,nek->ne", y, y)
    out[..., 0, 1] = out[..., 1, 0] = np.einsum("nek,nek->ne", x, y)
    return out


def _mixed(history) -> np.ndarray:
    """Return the next coefficients from the last (old, new) pairs: Anderson mixing of depth one, each design apart.

    A design whose extrapolation would drive a coefficient below zero takes its last values unmixed.
    """
    new = history[-1][1]
    if len(history) < 2:
        return new
    (x0, g0), (x1, g1) = history
    f1 = g1 - x1
    difference = f1 - (g0 - x0)
    size = np.einsum("neab,neab->n", difference, difference)
    share = np.einsum("neab,neab->n", f1, difference) / np.where(size > 0, size, 1.0)
    mixed = g1 - np.clip(share, -0.9, 0.9)[:, None, None, None] * (g1 - g0)
    driving = np.minimum(mixed[..., 0, 0], mixed[..., 1, 1]).min(axis=1) < 0
    return np.where(driving[:, None, None, None], g1, mixed)
