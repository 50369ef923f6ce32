"""Damping from the excitation all around: a body of known waves, symmetry, positive definiteness."""

import numpy as np
import pytest

from model.conventions import PLATFORM_DOFS
from model.environment.airy import wavenumber
from model.system.haskind import MIRROR_X, MIRROR_Y, SYMMETRIES, far_field_damping, sector_headings, turn

STEP = np.radians(5.0)
WATER = {"depth": np.inf, "density": 1025.0, "gravity": 9.80665}


def columns(symmetry: str) -> np.ndarray:
    """Places (c, 3) of point columns that have a symmetry."""
    point = np.array([11.0, 6.0, -10.0])
    if symmetry == "three-fold xz":
        return np.array([turn(k * 2 * np.pi / 3)[:3, :3] @ m[:3, :3] @ point for k in range(3) for m in (np.eye(6), MIRROR_Y)])
    images = {"none": (np.eye(6),), "xz": (np.eye(6), MIRROR_Y), "xz yz": (np.eye(6), MIRROR_Y, MIRROR_X, MIRROR_X @ MIRROR_Y)}
    return np.array([m[:3, :3] @ point for m in images[symmetry]])


def excitation(places, k: float, heading: float) -> np.ndarray:
    """Froude-Krylov-like force of point columns in a plane wave."""
    direction = np.array([np.cos(heading), np.sin(heading), 0.0])
    out = np.zeros(6, dtype=complex)
    for p in places:
        force = np.array([1j * direction[0], 1j * direction[1], 2.0]) * np.exp(-1j * k * direction @ p)
        out += np.concatenate([force, np.cross(p, force)])
    return out


@pytest.mark.parametrize("symmetry", SYMMETRIES)
def test_the_sector_gives_the_same_as_the_whole_circle(symmetry):
    omega = 1.1
    places = columns(symmetry)
    k = omega**2 / 9.80665

    def damping(kind):
        force = np.array([excitation(places, k, b) for b in sector_headings(kind, STEP)])
        return far_field_damping(force, kind, omega, **WATER)

    whole = damping("none")
    # trapezoidal sums of smooth periodic functions: rounding
    assert np.allclose(damping(symmetry), whole, atol=1e-10 * np.abs(whole).max())
    assert np.allclose(whole, whole.T)
    assert np.linalg.eigvalsh(whole).min() > -1e-12 * np.linalg.eigvalsh(whole).max()


def test_an_axisymmetric_body_has_newmans_damping():
    # X3 the same from all headings, X1 its cosine: B33 = k |X3|^2 / (4 rho g c_g), B11 = k |X1|^2 / (8 rho g c_g)
    omega, depth = 0.5, 40.0
    heading = sector_headings("xz yz", STEP)
    force = np.zeros((len(heading), 6), dtype=complex)
    force[:, 0], force[:, 1], force[:, 2] = 3e6j * np.cos(heading), 3e6j * np.sin(heading), 5e6
    got = far_field_damping(force, "xz yz", omega, depth=depth, density=1025.0, gravity=9.80665)
    k = float(np.asarray(wavenumber(np.array([omega]), depth, 9.80665))[0])
    step = 1e-4  # the group velocity d omega / d k, by a central difference
    speed = 2 * step / np.diff([float(np.asarray(wavenumber(np.array([w]), depth, 9.80665))[0]) for w in (omega - step, omega + step)])[0]
    assert got[2, 2] == pytest.approx(k * 25e12 / (4 * 1025 * 9.80665 * speed), rel=1e-6)
    assert got[0, 0] == pytest.approx(k * 9e12 / (8 * 1025 * 9.80665 * speed), rel=1e-6)
    assert got[1, 1] == pytest.approx(got[0, 0])
    assert len(got) == len(PLATFORM_DOFS)
