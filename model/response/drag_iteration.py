"""Quadratic drag linearised to convergence, for one or many sea states on one model at once.

The covariance of every element's relative velocity is a sum of three parts: the water's own, its covariance with the
motions, and the motions' own; the first does not change in the iteration, the others are matrix products.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.system.drag import DragMembers, borgman_coefficients, element_motion, linear_drag, mean_flow_coefficients

MODELS = ("relative", "third_order", "body", "global", "none")


def linear_drag_model(model: str) -> str:
    """Return the drag model with constant coefficients that a model is built on: "relative" for "third_order", else itself."""
    return "relative" if model == "third_order" else model


@dataclass(frozen=True, eq=False, kw_only=True)
class DragProblem:
    """What stays the same in the iteration.

    members; motion (e, 2, 6) of the elements along their resisted directions; water (m, 2 e, n) the water's velocity along them per
    metre of wave amplitude, zero unless drag is relative; omega (n); rows (p) of the platform motions that are kept; weights of the
    wave spectra (s, m, n) and wind inputs (s, w, n), spectrum times step; quadratic (6, 6) damping; model, one of MODELS; flow (e, 2) steady current along the resisted
    directions, None without; incoherent (n, p, p) spectra times step of the platform velocities that no input drives linearly (one
    state only), None without.
    """

    members: DragMembers
    motion: np.ndarray
    water: np.ndarray
    omega: np.ndarray
    rows: list[int]
    wave_weight: np.ndarray
    wind_weight: np.ndarray
    quadratic: np.ndarray
    model: str
    flow: np.ndarray | None = None
    incoherent: np.ndarray | None = None

    @property
    def waves_drive(self) -> bool:
        """Whether drag takes the water's velocity."""
        return linear_drag_model(self.model) == "relative"

    @property
    def active(self) -> bool:
        """Whether there is any quadratic drag to linearise."""
        return self.model != "none" and (len(self.members) > 0 or bool(np.any(self.quadratic)))


@dataclass(frozen=True, eq=False, kw_only=True)
class Linearised:
    """Coefficients of the states: b (s, e, 2, 2) of the elements and own (s, 6) of the quadratic damping matrix."""

    b: np.ndarray
    own: np.ndarray

    def flat(self) -> np.ndarray:
        """Return all coefficients as (s, k)."""
        return np.concatenate([self.b.reshape(len(self.b), -1), self.own], axis=1)


def drag_problem(
    members: DragMembers, directions, water, omega, rows, wave_weight, wind_weight, quadratic, model: str, current=None
) -> DragProblem:
    """Return the drag problem of some states; see DragProblem for shapes.

    current (e, 3) is the steady water velocity at the elements [m/s], None without. Raises ValueError for an unknown model.
    """
    if model not in MODELS:
        raise ValueError(f"drag model {model!r} is none of {', '.join(MODELS)}")
    moving = np.ascontiguousarray(water if linear_drag_model(model) == "relative" else np.zeros_like(water), dtype=complex)
    return DragProblem(
        members=members, motion=element_motion(members, directions), water=moving, omega=omega, rows=list(rows),
        wave_weight=wave_weight, wind_weight=wind_weight, quadratic=quadratic, model=model,
        flow=None if current is None or model == "global" else np.einsum("eak,ek->ea", directions, current),
    )  # fmt: skip


def at_rest(problem: DragProblem) -> Linearised | None:
    """Return coefficients for a body at rest in the waves, None when the water does not move it."""
    if not np.any(problem.wave_weight) or not np.any(problem.water):
        return None
    own = np.zeros((len(problem.wave_weight), 6))
    return Linearised(b=_borgman(problem, _water_covariance(problem)), own=own)


def coefficients(problem: DragProblem, solution: np.ndarray, here) -> Linearised:
    """Return the coefficients for the motions of a solution (s, n, q, m + w), platform motions at places `here`."""
    rate = solution[:, :, here, :] * (1j * problem.omega[:, None, None])
    own_covariance = _rate_covariance(problem, rate)
    own = np.zeros((len(rate), 6))
    own[:, problem.rows] = np.sqrt(8 / np.pi * np.diagonal(own_covariance, axis1=1, axis2=2))
    return Linearised(b=_borgman(problem, _covariance(problem, rate, own_covariance)), own=own)


def velocity_covariance(problem: DragProblem, solution: np.ndarray, here) -> np.ndarray:
    """Return the covariances (s, e, 2, 2) of the elements' relative velocity for a solution (s, n, q, m + w)."""
    rate = solution[:, :, here, :] * (1j * problem.omega[:, None, None])
    return _covariance(problem, rate, _rate_covariance(problem, rate))


def _rate_covariance(problem: DragProblem, rate: np.ndarray) -> np.ndarray:
    """Return the covariance (s, p, p) of the platform velocities (s, n, p, m + w)."""
    weights = np.concatenate([problem.wave_weight, problem.wind_weight], axis=1)[:, : rate.shape[-1]]
    scaled = rate * np.sqrt(weights).transpose(0, 2, 1)[:, :, None, :]
    columns = scaled.transpose(0, 2, 1, 3).reshape(len(rate), rate.shape[2], -1)
    numbers = np.ascontiguousarray(columns).view(float)  # the real part of a product with the conjugate is one of real matrices
    out = numbers @ numbers.swapaxes(1, 2)
    return out if problem.incoherent is None else out + problem.incoherent.sum(axis=0).real


def _covariance(problem: DragProblem, rate: np.ndarray, own: np.ndarray) -> np.ndarray:
    """Return the covariances (s, e, 2, 2) of the relative velocity for platform velocities (s, n, p, m + w) of covariance (s, p, p)."""
    s, _, p, _ = rate.shape
    flat = problem.motion.reshape(-1, 6)[:, problem.rows]
    cross = np.zeros((s, len(flat), p))
    if np.any(problem.water):
        for k, waves in enumerate(problem.wave_weight.swapaxes(0, 1)):
            driven = np.ascontiguousarray((rate[..., k] * waves[:, :, None]).transpose(0, 2, 1)).view(float).reshape(s * p, -1)
            cross += (driven @ problem.water[k].view(float).T).reshape(s, p, -1).swapaxes(1, 2)
    return _assembled(problem, flat, own, cross)


def damping_and_force(problem: DragProblem, linear: Linearised) -> tuple[np.ndarray, np.ndarray | None]:
    """Return the drag damping (s, 6, 6) and the waves' drag force (s, m, 6, n), None when drag takes no part of the waves."""
    damping, per_velocity = linear_drag(problem.members, problem.motion, linear.b)
    damping = damping + problem.quadratic * linear.own[:, None, :]
    if not problem.waves_drive:
        return damping, None
    s, e = len(linear.b), len(problem.members)
    per = per_velocity.reshape(s * 6, 2 * e)
    force = np.stack([(per @ water.view(float)).view(complex).reshape(s, 6, -1) for water in problem.water], axis=1)
    return damping, force


def mixed(history: list[tuple[Linearised, Linearised]]) -> Linearised:
    """Return the next coefficients from the last (old, new) pairs: Anderson mixing of depth one, for each state apart.

    A state whose extrapolation would drive an element's coefficient below zero takes its last values unmixed.
    """
    new = history[-1][1]
    if len(history) < 2:
        return new
    (x0, g0), (x1, g1) = [(a.flat(), b.flat()) for a, b in history[-2:]]
    f1 = g1 - x1
    difference = f1 - (g0 - x0)
    size = np.einsum("sk,sk->s", difference, difference)
    share = np.einsum("sk,sk->s", f1, difference) / np.where(size > 0, size, 1.0)
    share = np.clip(share, -0.9, 0.9)[:, None]
    flat = g1 - share * (g1 - g0)
    diagonal = flat[:, :-6].reshape(len(flat), -1, 4)[:, :, ::3]
    driving = (diagonal.min(axis=(1, 2), initial=0.0) < 0) | (flat[:, -6:].min(axis=1) < 0)
    flat = np.where(driving[:, None], g1, flat)
    return Linearised(b=flat[:, :-6].reshape(new.b.shape), own=flat[:, -6:])


def trapezoid_weights(omega: np.ndarray) -> np.ndarray:
    """Return trapezoidal weights of a frequency grid."""
    step = np.diff(omega)
    out = np.zeros_like(omega)
    out[:-1] += step / 2
    out[1:] += step / 2
    return out


def change(old: Linearised, new: Linearised) -> np.ndarray:
    """Return the largest change of any coefficient over the largest coefficient, (s)."""
    a, b = old.flat(), new.flat()
    return np.abs(b - a).max(axis=1) / np.maximum(np.abs(b).max(axis=1), 1e-300)


def _water_covariance(problem: DragProblem) -> np.ndarray:
    """Return the covariances (s, e, 2, 2) of the water's velocity along the resisted directions."""
    e, n = len(problem.members), len(problem.omega)
    out = np.zeros((len(problem.wave_weight), e, 2, 2))
    for k, water in enumerate(problem.water):
        v = water.reshape(e, 2, n)
        square = (v.real**2 + v.imag**2).reshape(2 * e, n)
        cross = v[:, 0].real * v[:, 1].real + v[:, 0].imag * v[:, 1].imag
        weight = problem.wave_weight[:, k].T
        own, mixed_part = (square @ weight).T.reshape(-1, e, 2), (cross @ weight).T
        out[..., 0, 0] += own[..., 0]
        out[..., 1, 1] += own[..., 1]
        out[..., 0, 1] += mixed_part
        out[..., 1, 0] += mixed_part
    return out


def _assembled(problem: DragProblem, flat: np.ndarray, own: np.ndarray, cross: np.ndarray) -> np.ndarray:
    """Return the covariances (s, e, 2, 2) of the relative velocity from its three parts."""
    g = flat.reshape(-1, 2, flat.shape[1])
    moved = np.einsum("eap,spq,ebq->seab", g, own, g, optimize=True)
    c = cross.reshape(len(cross), -1, 2, flat.shape[1])
    mixed_part = np.einsum("seap,ebp->seab", c, g, optimize=True)
    water = _water_covariance(problem) if np.any(problem.water) else 0.0
    out = water + moved - mixed_part - mixed_part.swapaxes(-1, -2)
    for k in (0, 1):  # where water and body move nearly alike, rounding must not make the difference vanish
        largest = moved[..., k, k] + (water[..., k, k] if np.ndim(water) else 0.0)
        out[..., k, k] = np.maximum(out[..., k, k], 1e-13 * largest)
    return out


def _borgman(problem: DragProblem, covariance: np.ndarray) -> np.ndarray:
    """Return the elements' coefficients; "global" has one velocity for all strips and one for all end plates."""
    if problem.flow is not None:
        return mean_flow_coefficients(covariance, np.broadcast_to(problem.flow, covariance.shape[:-1]))
    if problem.model != "global":
        return borgman_coefficients(covariance)
    out = np.zeros_like(covariance)
    axial = problem.members.axial > 0
    for group, directions in ((axial, 1), (~axial, 2)):
        if group.any():
            share = problem.members.factor[group] / problem.members.factor[group].sum()
            variance = np.einsum("e,sekk->s", share, covariance[:, group]) / directions
            b = np.sqrt(8 / np.pi * variance)
            out[:, group] = b[:, None, None, None] * np.diag([1.0, 1.0 if directions == 2 else 0.0])
    return out
