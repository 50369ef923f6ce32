"""Quadratic drag of slender members and heave plates, linearised for a Gaussian relative velocity (Borgman).

Every element resists one projection of the relative velocity u (water minus body): F = K |P u| P u, with
P = 1 - a a' across a member's axis a and P = a a' along it at an end plate.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.conventions import freeze, point_motion

_ANGLES = (np.arange(12) + 0.5) * np.pi / 12
_SQUARES = np.stack([np.cos(_ANGLES) ** 2, np.sin(_ANGLES) ** 2])
_ROOTS, _ROOT_WEIGHTS = np.polynomial.hermite_e.hermegauss(16)
_HERMITE = np.stack(np.meshgrid(_ROOTS, _ROOTS, indexing="ij"), axis=-1).reshape(-1, 2)
_HERMITE_WEIGHT = np.outer(_ROOT_WEIGHTS, _ROOT_WEIGHTS).ravel() / (2 * np.pi)
_CUBE_MEAN = 3 * np.sqrt(np.pi / 2)


@dataclass(frozen=True, eq=False, kw_only=True)
class DragMembers:
    """Drag elements: position (s, 3) [m], axis (s, 3) unit vectors, factor K (s) [kg/m], axial (s) true for end plates.

    K is 1/2 rho Cd D L of a strip. HydroDyn's end drag is K = 1/4 rho AxCd A. diameter and length (s) [m] are
    kept for what people read (0 for an end plate's length).
    """

    position: np.ndarray
    axis: np.ndarray
    factor: np.ndarray
    axial: np.ndarray
    diameter: np.ndarray
    length: np.ndarray

    def __post_init__(self):
        freeze(
            self, position=("s", 3), axis=("s", 3), factor=("s",), axial=("s",), diameter=("s",), length=("s",),
        )  # fmt: skip

    def __len__(self) -> int:
        return len(self.factor)


def no_drag() -> DragMembers:
    """Return a body without drag elements."""
    return DragMembers(
        position=np.zeros((0, 3)), axis=np.zeros((0, 3)), factor=np.zeros(0), axial=np.zeros(0), diameter=np.zeros(0),
        length=np.zeros(0),
    )  # fmt: skip


def resisted_directions(members: DragMembers) -> np.ndarray:
    """Return for each element two orthonormal directions (s, 2, 3) that it resists; the second is zero for an end plate."""
    a = members.axis
    helper = np.where(np.abs(a[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    first = np.cross(a, helper)
    first /= np.maximum(np.linalg.norm(first, axis=1, keepdims=True), 1e-300)
    second = np.cross(a, first)
    axial = members.axial[:, None] > 0
    return np.stack([np.where(axial, a, first), np.where(axial, 0.0, second)], axis=1)


def element_motion(members: DragMembers, directions: np.ndarray) -> np.ndarray:
    """Return the motion (s, 2, 6) of the elements along their resisted directions per unit of platform motion."""
    return directions @ point_motion(members.position)


def borgman_coefficients(covariance: np.ndarray) -> np.ndarray:
    """Return the linear coefficients (..., 2, 2) with |u| u ~ b u in the mean square, for a Gaussian 2-D velocity u.

    covariance (..., 2, 2) [m2/s2] of u. In one dimension b = sqrt(8/pi) sigma (Borgman 1967); in two the expectation
    E[|u| u u'] over the direction is done by quadrature and multiplied with the inverse covariance.
    """
    c11, c22, c12 = covariance[..., 0, 0], covariance[..., 1, 1], covariance[..., 0, 1]
    middle, half = (c11 + c22) / 2, (c11 - c22) / 2
    radius = np.hypot(half, c12)
    s1, s2 = (np.maximum(middle + sign * radius, 0.0)[..., None] for sign in (-1, 1))
    size = np.sqrt(s1 * _SQUARES[0] + s2 * _SQUARES[1])
    b1, b2 = _CUBE_MEAN / len(_ANGLES) * (size @ _SQUARES[0]), _CUBE_MEAN / len(_ANGLES) * (size @ _SQUARES[1])
    mean, slope = (b1 + b2) / 2, (b2 - b1) / np.where(radius > 0, 2 * radius, 1.0)
    out = np.empty(covariance.shape)
    out[..., 0, 0], out[..., 1, 1] = mean + slope * half, mean - slope * half
    out[..., 0, 1] = out[..., 1, 0] = slope * c12
    return out


def mean_flow_coefficients(covariance: np.ndarray, mean: np.ndarray) -> np.ndarray:
    """Return the linear coefficients (..., 2, 2) of |v| v for v = mean + u, u Gaussian: what multiplies u in the mean square.

    covariance (..., 2, 2) [m2/s2] of u; mean (..., 2) [m/s]. E[|v| v u'] times the inverse covariance, by Gauss-Hermite
    quadrature in two dimensions. Without a mean it is `borgman_coefficients`; with a mean alone, d(|v| v)/dv.
    """
    size = np.trace(covariance, axis1=-2, axis2=-1) + 1e-3 * np.sum(mean**2, axis=-1) + 1e-12
    root = np.linalg.cholesky(covariance + 1e-6 * size[..., None, None] * np.eye(2))
    v = mean[..., None, :] + np.einsum("...ij,kj->...ki", root, _HERMITE)
    force = np.linalg.norm(v, axis=-1, keepdims=True) * v
    moment = np.einsum("k,...ki,kj->...ij", _HERMITE_WEIGHT, force, _HERMITE)
    return moment @ np.linalg.inv(root)


def steady_drag(members: DragMembers, velocity: np.ndarray) -> np.ndarray:
    """Return the force (6) on a body at rest in a steady flow with velocity (s, 3) [m/s] at the elements."""
    directions = resisted_directions(members)
    along = np.einsum("sak,sk->sa", directions, velocity)
    force = members.factor[:, None] * np.linalg.norm(along, axis=1, keepdims=True) * along
    return np.einsum("sai,sa->i", element_motion(members, directions), force)


def linear_drag(members: DragMembers, motion: np.ndarray, coefficients: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the 6x6 drag damping (..., 6, 6) and the drag force per unit of water velocity (..., 6, s, 2).

    motion (s, 2, 6) of the elements; coefficients (..., s, 2, 2) from `borgman_coefficients`.
    """
    scaled = members.factor[:, None, None] * coefficients
    per_velocity = np.einsum("sai,...sab->...isb", motion, scaled)
    flat = per_velocity.reshape(*per_velocity.shape[:-2], -1)
    return flat @ motion.reshape(-1, 6), per_velocity
