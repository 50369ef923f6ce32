"""Rotations, rigid-body transforms and weights: definitions and properties."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from model.conventions import (
    DOF_UNITS,
    PLATFORM_DOFS,
    freeze,
    frozen,
    move_force,
    move_matrix,
    point_motion,
    rigid_mass,
    rotation,
    rotation_rate,
    skew,
    weight_stiffness,
)

G = 9.80665


def vectors(size, limit):
    return st.lists(st.floats(-limit, limit), min_size=size, max_size=size).map(np.array)


angles = vectors(3, 2.0)
places = vectors(3, 50.0)
motions = vectors(6, 1.0)


def inertias():
    """Inertia matrices of sets of point masses: what a body can have."""
    return st.lists(places, min_size=4, max_size=4).map(lambda r: sum((p @ p) * np.eye(3) - np.outer(p, p) for p in r))


@given(angles, angles)
def test_skew_is_the_cross_product(v, u):
    assert np.allclose(skew(v) @ u, np.cross(v, u))


@given(angles)
def test_rotations_are_orthogonal_and_keep_their_axis(v):
    r = rotation(v)
    # a few products of numbers of size one: rounding of 1e-16 each
    assert np.allclose(r @ r.T, np.eye(3), atol=1e-14)
    assert np.linalg.det(r) == pytest.approx(1.0, abs=1e-14)
    assert np.allclose(r @ v, v, atol=1e-14)


@pytest.mark.parametrize(("axis", "moved", "to"), [(0, 1, 2), (1, 2, 0), (2, 0, 1)])
def test_right_hand_turns(axis, moved, to):
    """Roll takes y to z, pitch z to x, yaw x to y; a positive pitch lowers the bow, which points to +x."""
    turn = rotation(np.eye(3)[axis] * np.pi / 2)
    assert np.allclose(turn @ np.eye(3)[moved], np.eye(3)[to], atol=1e-15)


def test_small_rotation_to_second_order():
    """1 + S + S^2 / 2; the next term is of third order, angle^3 / 6 = 2e-10 at 1e-3 rad."""
    v = np.array([0.7, -0.4, 0.5]) * 1e-3
    s = skew(v)
    assert np.abs(rotation(v) - (np.eye(3) + s + s @ s / 2)).max() < 2e-10


@pytest.mark.parametrize("size", [0.0, 1e-12, 1e-8, 1e-7, 1e-5, 1e-4, 1e-3])
def test_no_step_where_formulas_for_small_angles_take_over(size):
    v = np.array([0.6, 0.0, 0.8]) * size
    c, s, axis = np.cos(size), np.sin(size), np.array([0.6, 0.0, 0.8])
    exact = c * np.eye(3) + s * skew(axis) + (1 - c) * np.outer(axis, axis)
    assert np.allclose(rotation(v), exact, atol=2e-16)
    # left Jacobian about an axis: sin a / a across it, 1 along it, (1 - cos a) / a couples; series to angle^3
    series = np.eye(3) + skew(v) / 2 + skew(v) @ skew(v) / 6 - size**2 * skew(v) / 24
    # (1 - cos a) / a^2 loses digits to cancellation, 1e-16 / a^2, where the exact formula begins (a = 1e-4)
    assert np.allclose(rotation_rate(v), series, atol=1e-11)


@given(angles, angles)
def test_rotation_rate_by_differences(v, direction):
    h = 1e-5
    derivative = (rotation(v + h * direction) - rotation(v - h * direction)) / (2 * h)
    # central differences: third derivative of size 20 times h^2 / 6 = 4e-10, and rounding 1e-16 / h = 1e-11
    assert np.allclose(derivative, skew(rotation_rate(v) @ direction) @ rotation(v), atol=5e-9)


def test_stacks_of_vectors():
    v = np.random.default_rng(1).normal(size=(4, 2, 3))
    for function, shape in ((skew, (3, 3)), (rotation, (3, 3)), (rotation_rate, (3, 3)), (point_motion, (3, 6))):
        out = function(v)
        assert out.shape == (4, 2, *shape)
        assert np.array_equal(out[2, 1], function(v[2, 1]))


@given(places, motions)
def test_point_motion_is_the_motion_of_a_rigid_body(r, q):
    assert np.allclose(point_motion(r) @ q, q[:3] + np.cross(q[3:], r))


def test_pitch_moves_a_high_point_downwind():
    assert np.allclose(point_motion([0.0, 0.0, 90.0])[:, 4], [90.0, 0.0, 0.0])


@given(st.floats(1.0, 1e3), places, inertias(), motions)
def test_kinetic_energy_of_a_rigid_body(mass, centre, inertia, rate):
    """T = m v^2 / 2 of the centre plus the rotation's: the mass matrix gives the same, is symmetric, and positive."""
    matrix = rigid_mass(mass, centre, inertia)
    velocity = rate[:3] + np.cross(rate[3:], centre)
    energy = mass * velocity @ velocity + rate[3:] @ inertia @ rate[3:]
    assert np.allclose(matrix, matrix.T)
    assert rate @ matrix @ rate == pytest.approx(energy, rel=1e-9, abs=1e-6 * mass)
    assert np.linalg.eigvalsh(matrix).min() > -1e-9 * np.abs(matrix).max()


@given(st.floats(1.0, 1e3), places, inertias(), motions, motions, places)
def test_moving_the_reference_point_conserves_power(mass, centre, inertia, load, rate, offset):
    """The same body about another point: the same energy of the same motion, the same power of the same load."""
    there = point_motion(offset) @ rate
    moved_rate = np.concatenate([there, rate[3:]])
    matrix = rigid_mass(mass, centre, inertia)
    energy = rate @ matrix @ rate
    size = np.abs(matrix).max()
    assert moved_rate @ move_matrix(matrix, offset) @ moved_rate == pytest.approx(energy, rel=1e-9, abs=1e-10 * size)
    assert move_force(load, offset) @ moved_rate == pytest.approx(load @ rate, abs=1e-10)
    assert np.allclose(move_matrix(matrix, offset), rigid_mass(mass, centre - offset, inertia), atol=1e-10 * size)


@given(motions, places)
def test_moving_there_and_back(load, offset):
    matrix = np.outer(load, np.arange(6.0)) + np.eye(6)
    assert np.allclose(move_matrix(move_matrix(matrix, offset), -offset), matrix, atol=1e-9)
    assert np.allclose(move_force(move_force(load, offset), -offset), load, atol=1e-10)


def test_forces_of_many_frequencies_move_together_and_stay_complex():
    load = np.random.default_rng(2).normal(size=(5, 7, 6)) * (1 + 2j)
    out = move_force(load, [1.0, 2.0, 3.0])
    assert out.shape == load.shape
    assert np.allclose(out[3, 4], move_force(load[3, 4], [1.0, 2.0, 3.0]))
    assert np.allclose(out[..., 3:], load[..., 3:] - np.cross([1.0, 2.0, 3.0], load[..., :3]))


@given(places, st.integers(3, 5))
def test_weight_stiffness_by_differences(centre, axis):
    """Minus the change of the weight's moment about the moving origin, as the body turns."""
    mass, h = 100.0, 1e-5

    def moment(angle):
        turned = rotation(np.eye(3)[axis - 3] * angle) @ centre
        return np.cross(turned, [0.0, 0.0, -mass * G])

    column = -(moment(h) - moment(-h)) / (2 * h)
    # rounding 1e-16 times the moment (5e4) over h is 1e-6; the third-order term m g r h^2 / 6 is as small
    assert np.allclose(weight_stiffness(mass, centre, G)[3:, axis], column, atol=1e-4)
    assert not weight_stiffness(mass, centre, G)[:3].any()


def test_a_high_centre_of_mass_overturns():
    assert weight_stiffness(10.0, [0.0, 0.0, 2.0], G)[4, 4] == pytest.approx(-10.0 * G * 2.0)


class Record:
    def __init__(self, **values):
        self.__dict__.update(values)


def test_frozen_arrays_cannot_be_written_and_are_copies():
    source = np.arange(3.0)
    array = frozen(source)
    source[0] = 9.0
    assert array[0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        array[0] = 1.0


def test_freeze_checks_shapes():
    record = Record(a=[1.0, 2.0], b=np.zeros((2, 3)), c=None, d=[1j, 2.0])
    freeze(record, a=("n",), b=("n", 3), c=(4,), d=("n",))
    assert record.c is None
    assert record.d.dtype == complex
    with pytest.raises(ValueError, match="read-only"):
        record.b[0, 0] = 1.0
    with pytest.raises(ValueError, match=r"b has shape \(2, 3\)"):
        freeze(record, b=(2, 2))
    with pytest.raises(ValueError, match="a needs 2 axes, has 1"):
        freeze(record, a=("n", "n"))
    with pytest.raises(ValueError, match="b has shape"):
        freeze(record, a=("n",), b=("m", "n"))


def test_order_and_units_of_the_degrees_of_freedom():
    """OpenFAST's order; translations in metres, rotations in radians."""
    assert PLATFORM_DOFS == ("surge", "sway", "heave", "roll", "pitch", "yaw")
    assert [DOF_UNITS[d] for d in PLATFORM_DOFS] == ["m"] * 3 + ["rad"] * 3
