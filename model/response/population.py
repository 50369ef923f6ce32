"""Many designs in one sea state at once: drag to convergence for each, then motions, with arrays over designs and frequencies.

The same equations as `model.response.solve`, whose result each design has; there one design, here N that differ in everything
but the frequencies, the sea and the wind. A design that has converged keeps its solution, so it does not matter in what company
it is solved.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.environment.sea import wave_kinematics, wavenumber
from model.response.batch import eliminated
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
    field = wave_kinematics(omega, wavenumber(omega, depth, gravity), depth, members.position, np.array([[heading]])).velocity[0]
    water = (directions @ field.swapaxes(1, 2)).reshape(designs, -1, len(omega))
    return ElementSet(factor=members.factor.reshape(designs, -1), motion=motion, water=np.ascontiguousarray(water))


def solve_population(
    omega, dynamic, force, weight, elements: ElementSet, *, tolerance: float = 1e-9, limit: int = 60
) -> PopulationResponse:
    """Return the responses of N designs, drag linearised for the relative velocity and iterated to convergence.

    omega (n) [rad/s]; dynamic (N, q, q, n) stiffness without drag, platform motions first; force (N, q, r, n), waves first, then
    wind inputs; weight (r, n): spectrum of each input times the frequency step. tolerance on the change of any element's coefficient
    over the largest.
    """
    count, q, r, n = force.shape
    base = np.concatenate([dynamic, force], axis=2).transpose(1, 2, 0, 3)
    out = np.empty((count, q, r, n), dtype=complex)
    damping, steps, done = np.zeros((count, 6, 6)), np.full(count, limit), np.zeros(count, dtype=bool)
    index, some = np.arange(count), elements
    linear, history = borgman_coefficients(_water_covariance(some, weight[0])), []
    for step in range(1, limit + 1):
        per_velocity = np.einsum("neai,neab->nieb", _pairs(some), some.factor[..., None, None] * linear, optimize=True)
        per_velocity = per_velocity.reshape(len(index), 6, -1)
        now = per_velocity @ some.motion
        motion = _solved(base, index, now, _times(per_velocity, some.water), omega, q)
        new = borgman_coefficients(_relative_covariance(some, motion, weight, omega))
        change = np.abs(new - linear).max(axis=(1, 2, 3)) / np.maximum(np.abs(new).max(axis=(1, 2, 3)), 1e-300)
        ready = (change < tolerance) | (step == limit)
        at = index[ready]
        out[at], damping[at], steps[at], done[at] = motion[ready], now[ready], step, change[ready] < tolerance
        stay = ~ready
        if not stay.any():
            break
        history = [(a[stay], b[stay]) for a, b in [*history[-1:], (linear, new)]] if not ready.all() else []
        index = index[stay]
        some = some if stay.all() else some.some(stay)
        linear = _mixed(history)
    return PopulationResponse(motion=out, drag_damping=damping, iterations=steps, converged=done)


def _pairs(elements: ElementSet) -> np.ndarray:
    return elements.motion.reshape(*elements.factor.shape, 2, 6)


def _times(real: np.ndarray, field: np.ndarray) -> np.ndarray:
    """Return the product (N, i, n) of real (N, i, k) and complex (N, k, n) arrays."""
    return (real @ field.view(float)).view(complex)


def _solved(base, index, damping, wave_force, omega, q: int) -> np.ndarray:
    """Return motions (N, q, r, n) with drag damping (N, 6, 6) and the waves' drag force (N, 6, n) added to some of the equations."""
    n = len(omega)
    out = np.empty((len(index), q, base.shape[1] - q, n), dtype=complex)
    step = max(1, _CHUNK // n)
    for start in range(0, len(index), step):
        part = slice(start, start + step)
        work = base[:, :, index[part]]
        work[:6, :6] += damping[part].transpose(1, 2, 0)[..., None] * (1j * omega)
        work[:6, q] += wave_force[part].transpose(1, 0, 2)
        out[part] = eliminated(work, q).transpose(0, 2, 3, 1)
    return out


def _water_covariance(elements: ElementSet, weight) -> np.ndarray:
    """Return the covariances (N, e, 2, 2) of the water's velocity along the resisted directions."""
    v = elements.water.reshape(*elements.factor.shape, 2, -1) * np.sqrt(weight)
    return np.einsum("neak,nebk->neab", v.view(float), v.view(float), optimize=True)


def _relative_covariance(elements: ElementSet, motion, weight, omega) -> np.ndarray:
    """Return the covariances (N, e, 2, 2) of the relative velocity from all inputs."""
    rate = motion[:, :6] * (1j * omega) * np.sqrt(weight)
    count, e = elements.factor.shape
    flat = elements.motion
    relative = elements.water * np.sqrt(weight[0]) - _times(flat, np.ascontiguousarray(rate[:, :, 0]))
    out = _self_products(relative.reshape(count, e, 2, -1))
    if rate.shape[2] > 1:
        wind = np.ascontiguousarray(rate[:, :, 1:]).reshape(count, 6, -1).view(float)
        pairs = _pairs(elements)
        out = out + np.einsum("neap,npq,nebq->neab", pairs, wind @ wind.swapaxes(1, 2), pairs, optimize=True)
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
