"""Linearised drag: Borgman's coefficients against their definition, and what elements resist."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import ellipe

from model.conventions import rotation
from model.system.drag import (
    DragMembers,
    borgman_coefficients,
    element_motion,
    linear_drag,
    no_drag,
    resisted_directions,
)

angles = st.lists(st.floats(-2, 2), min_size=3, max_size=3).map(np.array)


def test_one_direction_is_borgman():
    """sqrt(8/pi) sigma: Borgman 1967, the least-squares factor of |u| u for a Gaussian u."""
    sigma = 0.7
    b = borgman_coefficients(np.diag([sigma**2, 0.0]))
    # midpoint quadrature of |cos|^3 over 12 angles: error below 1e-3 (the kink), measured against the closed form here
    assert b[0, 0] == pytest.approx(np.sqrt(8 / np.pi) * sigma, rel=1e-3)


def test_equal_in_all_directions():
    """E[u^3] of a Rayleigh speed over 2 sigma^2: 3/2 sqrt(pi/2) sigma."""
    assert np.allclose(borgman_coefficients(np.eye(2) * 0.49), np.eye(2) * 1.5 * np.sqrt(np.pi / 2) * 0.7, rtol=1e-12)


@given(st.floats(0.05, 1.0), st.floats(0.0, np.pi))
def test_two_unequal_directions(ratio, turn):
    """E[|u| u u'] in principal axes by elliptic integrals; the coefficients turn with the axes."""
    r = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    b = r.T @ borgman_coefficients(r @ np.diag([1.0, ratio**2]) @ r.T) @ r
    theta = (np.arange(4000) + 0.5) * np.pi / 4000
    size = np.sqrt(np.cos(theta) ** 2 + ratio**2 * np.sin(theta) ** 2)
    mean_size = 2 / np.pi * ellipe(1 - ratio**2)
    assert size.mean() == pytest.approx(mean_size, rel=1e-6)  # the fine quadrature is right
    exact = 3 * np.sqrt(np.pi / 2) * np.array([(size * np.cos(theta) ** 2).mean(), (size * np.sin(theta) ** 2).mean()])
    # 12 angles meet a kink where the ellipse is nearly flat: 4e-3 of the lesser coefficient for an axis ratio of 1/16
    assert np.allclose(np.diag(b), exact, rtol=6e-3)
    assert abs(b[0, 1]) < 1e-9


def test_least_squares_fit_of_samples():
    """The definition itself: b minimises E | |u|u - b u |^2. 4e5 samples scatter by about 0.3 %, so 1 %."""
    covariance = np.array([[0.5, 0.2], [0.2, 0.3]])
    u = np.random.default_rng(5).multivariate_normal([0, 0], covariance, 400_000)
    force = np.linalg.norm(u, axis=1)[:, None] * u
    fit = np.linalg.solve(u.T @ u, u.T @ force).T
    assert np.allclose(borgman_coefficients(covariance), fit, rtol=0.01, atol=0.005)


@given(st.floats(0.1, 10.0))
def test_coefficients_grow_with_speed(factor):
    covariance = np.array([[0.5, 0.2], [0.2, 0.3]])
    assert np.allclose(borgman_coefficients(factor**2 * covariance), factor * borgman_coefficients(covariance))


def members(axis, axial, position=(0.0, 0.0, 0.0)):
    return DragMembers(
        position=[position], axis=[axis], factor=[2.0], axial=[float(axial)], diameter=[1.0], length=[1.0]
    )


@given(angles)
def test_strips_resist_across_and_plates_along_their_axis(turn):
    axis = rotation(turn) @ [0.0, 0.0, 1.0]
    strip, plate = resisted_directions(members(axis, False))[0], resisted_directions(members(axis, True))[0]
    # unit vectors from a normalised cross product; the least sine of the helper angle is 0.44, so rounding stays at 1e-15
    assert np.allclose(strip.T @ strip, np.eye(3) - np.outer(axis, axis), atol=1e-12)
    assert np.allclose(plate.T @ plate, np.outer(axis, axis), atol=1e-12)


@given(angles)
def test_any_two_directions_of_a_strip_give_the_same_damping(turn):
    """The pair of directions across the axis is arbitrary: the damping of an isotropic velocity is K b (1 - a a')."""
    axis = rotation(turn) @ [0.0, 0.0, 1.0]
    strip = members(axis, False)
    damping, _ = linear_drag(strip, element_motion(strip, resisted_directions(strip)), np.eye(2)[None] * 3.0)
    assert np.allclose(damping[:3, :3], 2.0 * 3.0 * (np.eye(3) - np.outer(axis, axis)), atol=1e-12)


def test_a_heave_plate_off_the_axis_damps_heave_roll_and_pitch():
    plate = members([0.0, 0.0, 1.0], True, position=(20.0, -5.0, -14.0))
    damping, force = linear_drag(plate, element_motion(plate, resisted_directions(plate)), np.diag([4.0, 0.0])[None])
    arm = np.array([0.0, 0.0, 1.0, -5.0, -20.0, 0.0])  # heave + roll y - pitch x
    assert np.allclose(damping, 8.0 * np.outer(arm, arm))
    assert np.allclose(force[:, 0, 0], 8.0 * arm)
    assert not force[:, 0, 1].any()


@given(st.integers(0, 1000))
def test_drag_only_dissipates(seed):
    rng = np.random.default_rng(seed)
    axes = rng.normal(size=(5, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    several = DragMembers(
        position=rng.normal(size=(5, 3)) * 30, axis=axes, factor=rng.uniform(0, 9, 5), axial=rng.integers(0, 2, 5).astype(float),
        diameter=np.ones(5), length=np.ones(5),
    )  # fmt: skip
    root = rng.normal(size=(5, 2, 2))
    b = borgman_coefficients(root @ root.swapaxes(1, 2))
    damping, _ = linear_drag(several, element_motion(several, resisted_directions(several)), b)
    assert np.allclose(damping, damping.T, rtol=1e-9, atol=1e-9 * np.abs(damping).max())
    assert np.linalg.eigvalsh(damping).min() > -1e-9 * np.abs(damping).max()


def test_a_body_without_elements():
    none = no_drag()
    damping, force = linear_drag(none, element_motion(none, resisted_directions(none)), np.zeros((0, 2, 2)))
    assert len(none) == 0
    assert damping.shape == (6, 6)
    assert not damping.any()
    assert force.shape == (6, 0, 2)
