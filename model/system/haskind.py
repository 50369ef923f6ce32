"""Radiation damping from the waves that a body makes far away: Haskind's relation."""

from __future__ import annotations

import numpy as np

from model.environment.airy import wavenumber

MIRROR_Y = np.diag([1.0, -1, 1, -1, 1, -1])
MIRROR_X = np.diag([-1.0, 1, 1, 1, -1, -1])


def turn(angle: float) -> np.ndarray:
    """Return the matrix (6, 6) that turns forces and moments about the vertical axis by an angle [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    return np.kron(np.eye(2), np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]))


SYMMETRIES = {
    "none": (2 * np.pi, (np.eye(6),)),
    "xz": (np.pi, (np.eye(6), MIRROR_Y)),
    "xz yz": (np.pi / 2, (np.eye(6), MIRROR_Y, MIRROR_X, MIRROR_X @ MIRROR_Y)),
    "three-fold xz": (np.pi / 3, tuple(turn(k * 2 * np.pi / 3) @ m for k in range(3) for m in (np.eye(6), MIRROR_Y))),
}
"""Of each symmetry of a hull: the sector of headings [rad] that says all, and the images that fill the circle."""


def sector_headings(symmetry: str, step: float) -> np.ndarray:
    """Return headings (b) [rad], ends included, that divide the sector of a symmetry in steps of about `step` [rad]."""
    return np.linspace(0.0, SYMMETRIES[symmetry][0], round(SYMMETRIES[symmetry][0] / step) + 1)


def far_field_damping(force, symmetry: str, omega: float, *, depth: float, density: float, gravity: float) -> np.ndarray:
    """Return the radiation damping (6, 6) from the excitation of waves from all around.

    B = k / (8 pi rho g c_g) times the integral of X X^H over the heading; positive semi-definite as it stands.

    force (b, 6): excitation per metre at `sector_headings` of the hull's symmetry; omega [rad/s]; depth [m] (inf is deep).
    The trapezoidal rule is exact once 2 pi over the step exceeds twice the harmonics of X, about k times the hull's radius.
    Source: J. N. Newman, The exciting forces on fixed bodies in waves, J. Ship Research 6 (1962) 10; Marine Hydrodynamics (1977), 6.18.
    """
    weight = np.ones(len(force))
    if symmetry == "none":
        weight[-1] = 0.0  # the first heading again
    else:
        weight[[0, -1]] = 0.5
    mean = np.einsum("b,bi,bj->ij", weight, force, np.conj(force)).real / weight.sum()
    images = SYMMETRIES[symmetry][1]
    mean = sum(image @ mean @ image.T for image in images) / len(images)
    k, speed = _dispersion(omega, depth, gravity)
    return k / (4 * density * gravity * speed) * mean


def _dispersion(omega: float, depth: float, gravity: float) -> tuple[float, float]:
    """Return wavenumber [1/m] and group velocity [m/s]."""
    if np.isinf(depth):
        return omega**2 / gravity, gravity / (2 * omega)
    k = float(np.asarray(wavenumber(np.array([omega]), depth, gravity))[0])
    kh = k * depth
    return k, omega / (2 * k) * (1 + (2 * kh / np.sinh(2 * kh) if kh < 300 else 0.0))
