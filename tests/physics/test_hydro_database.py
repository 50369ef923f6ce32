"""Interpolation over a family of hulls: exact where theory says so, positive damping, right symmetry, right derivatives."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from model.system.hydro_database import (
    HydroDatabase,
    derivative,
    full_matrix,
    heading_map,
    hull_frequency,
    interpolate,
    lagrange,
    positive,
    scaled_frequency,
)

HEADING = np.radians(np.arange(0.0, 61.0, 10.0))
S = np.linspace(0.0, 4.0, 21)
STRETCH = 0.05
COLUMNS = 37.0 * np.array([[np.cos(a), np.sin(a)] for a in np.pi + np.array([0, 2, 4]) * np.pi / 3])


def cheb(low, high, count):
    return (low + high) / 2 - (high - low) / 2 * np.cos(np.pi * np.arange(count) / (count - 1))


def quantity(d, r, t, s, inverse_depth):
    """The diameter squared times a polynomial within the grid's degrees (3, 5, 4 in the dimensions, 3 in s, 1 in the depth)."""
    return d**2 * (1 + d**3 * 1e-3 + d * r**2 * 1e-4) * (2 + t**2 * 1e-2) * (5 + s**3 - 2 * s) * (1 + 30 * inverse_depth)


@pytest.fixture(scope="module")
def database():
    axes = cheb(14, 20, 4), cheb(30, 45, 6), cheb(20, 32, 5)
    h, d, r, t, s = np.meshgrid([0.0, 0.005], *axes, S, indexing="ij")
    base = quantity(d, r, t, s, h)
    ratio = np.concatenate([[1, 2, 300, 400, 5], [1, 2, 300, 400, 5], np.arange(1, 85)])
    return HydroDatabase(
        diameter=axes[0], radius=axes[1], draft=axes[2], inverse_depth=np.array([0.0, 0.005]), scaled_frequency=S, heading=HEADING,
        values=base[..., None] * ratio, infinite=quantity(d, r, t, 1.0, 0.0)[0, ..., 0, None] * ratio[:5], density=1025.0, gravity=9.80665,
        stretch=STRETCH,
    )  # fmt: skip


def root(omega, hull):
    """The scaled frequency of a frequency [rad/s] on a hull, by a root finder from its definition."""
    return brentq(lambda s: s + STRETCH * s**2 * (hull[0] / hull[1] - 0.47) - omega * np.sqrt(hull[1] / 9.80665), 0.0, 10.0)


def test_polynomials_of_the_grids_degree_are_interpolated_exactly(database):
    designs = np.array([[15.3, 33.1, 21.7], [19.2, 44.0, 30.9]])
    omega = np.array([0.2, 0.7, 1.5])
    got = interpolate(database, designs, omega, HEADING, depth=400.0)
    s = np.array([[root(w, hull) for w in omega] for hull in designs])
    want = quantity(*(designs[:, k, None] for k in range(3)), s, 1 / 400)
    # rounding of cubic splines and of polynomials of degree 5: 1e-10
    assert got.added_mass[..., 2, 2] == pytest.approx(2 * want, rel=1e-10)
    assert got.added_mass[..., 1, 3] == pytest.approx(-5 * want, rel=1e-10)
    # polynomials pass through the square root of the heave damping, which this one is not: a hundredth of the 1 % a database may err
    assert got.radiation_damping[..., 2, 2] == pytest.approx(2 * want, rel=1e-4)
    assert got.added_mass_infinite[:, 5, 5] == pytest.approx(400 * quantity(*designs.T, 1.0, 0.0), rel=1e-10)
    assert np.array_equal(got.added_mass, np.swapaxes(got.added_mass, -1, -2))


def test_at_the_nodes_the_data_come_back(database):
    k = (2, 4, 1)
    hull = [database.diameter[2], database.radius[4], database.draft[1]]
    omega = hull_frequency(S[3:9], *hull[:2], STRETCH, 9.80665)
    got = interpolate(database, hull, omega, HEADING[:1], depth=200.0)
    assert got.added_mass[0, :, 0, 0] == pytest.approx(database.values[(1, *k)][3:9, 0], rel=1e-10)
    assert got.radiation_damping[0, :, 2, 2] == pytest.approx(database.values[(1, *k)][3:9, 6], rel=1e-10)
    heave = database.values[(1, *k)][3:9, 12] + 1j * database.values[(1, *k)][3:9, 12 + 42]
    assert np.allclose(got.excitation[0, 0, :, 2], heave, rtol=1e-10)


def test_derivatives_equal_differences(database):
    hull, omega, h = np.array([16.2, 38.0, 25.0]), np.array([0.3, 0.9]), 1e-4
    slope = derivative(database, hull, omega, [0.2], depth=300.0)
    for k in range(3):
        step = np.eye(3)[k] * h
        up, down = (interpolate(database, hull + sign * step, omega, [0.2], depth=300.0) for sign in (1, -1))
        for name in ("added_mass", "radiation_damping", "excitation", "added_mass_infinite"):
            difference = (getattr(up, name) - getattr(down, name)) / (2 * h)
            # central difference of step 1e-4 m: rounding 1e-16 / 1e-4 of the values, 1e-7 of the slopes
            assert np.allclose(slope[name][k], difference, rtol=1e-6, atol=1e-7 * np.abs(difference).max())


@given(st.floats(0.0, 3.0), st.floats(14, 20), st.floats(30, 45))
def test_scaled_frequencies_go_back_and_forth(omega, diameter, radius):
    s = scaled_frequency(omega, diameter, radius, STRETCH, 9.80665)
    assert hull_frequency(s, diameter, radius, STRETCH, 9.80665) == pytest.approx(omega, rel=1e-13, abs=1e-13)


def three_columns(k: float, heading: float) -> np.ndarray:
    """Froude-Krylov-like force of three point columns and a central one: it has the hull's symmetry by construction."""
    direction = np.array([np.cos(heading), np.sin(heading)])
    out = np.zeros(6, dtype=complex)
    for x, y in [*COLUMNS, (0.0, 0.0)]:
        phase = np.exp(-1j * k * (direction @ [x, y]))
        force = np.array([1j * direction[0], 1j * direction[1], 2.0]) * phase
        out[:3] += force
        out[3:] += np.cross([x, y, -10.0], force)
    return out


@pytest.mark.parametrize("heading", np.radians([-170.0, -97.0, -25.0, 13.0, 77.5, 133.0, 180.0]))
def test_any_heading_follows_from_those_of_a_sixth(heading):
    k = 0.15  # k r = 5.6: harmonics above 18 are below J_18(5.6) = 1e-8, times 4 columns
    given_forces = np.array([three_columns(k, b) for b in HEADING])
    turn = heading_map(HEADING, np.array([heading]))[0]
    got = np.einsum("ikj,kj->i", turn, given_forces)
    assert np.allclose(got, three_columns(k, heading), atol=1e-6 * np.abs(given_forces).max())


@settings(max_examples=100, deadline=None)
@given(st.lists(st.floats(-10, 10), min_size=5, max_size=5), st.floats(10, 40))
def test_damping_becomes_positive_semi_definite_and_good_damping_stays(values, length):
    reduced = np.array(values) * [1, 1, 400, 400, 20]
    fixed = positive(reduced[None, None], np.array([length]))[0, 0]
    eigen = np.linalg.eigvalsh(full_matrix(fixed))
    assert eigen.min() >= -1e-9 * max(1.0, np.abs(eigen).max())  # rounding of the projection
    if np.linalg.eigvalsh(full_matrix(reduced)).min() >= 0:
        assert np.allclose(fixed, reduced, rtol=1e-12, atol=1e-12)


def test_above_the_data_the_coefficients_decay(database):
    hull, last = np.array([17.0, 40.0, 25.0]), hull_frequency(S[-1], 17.0, 40.0, STRETCH, 9.80665)
    got = interpolate(database, hull, [last, 2 * last], [0.0])
    gap = got.added_mass[0, :, 2, 2] - got.added_mass_infinite[0, 2, 2]
    assert gap[1] == pytest.approx(gap[0] / 4)
    assert got.radiation_damping[0, 1, 2, 2] == pytest.approx(got.radiation_damping[0, 0, 2, 2] / 16)
    assert got.excitation[0, 0, 1, 2] == pytest.approx(got.excitation[0, 0, 0, 2] / 4)


def test_lagrange_polynomials_are_one_at_their_node_and_sum_to_one():
    nodes = cheb(30, 45, 6)
    value, slope = lagrange(nodes, np.array([nodes[2], 36.3]))
    assert np.allclose(value[0], np.eye(6)[2], atol=1e-14)
    assert value.sum(axis=1) == pytest.approx(1.0)
    assert slope.sum(axis=1) == pytest.approx(0.0, abs=1e-12)


def test_outside_the_family_is_refused(database):
    with pytest.raises(ValueError, match="radius 46 m lies outside"):
        interpolate(database, [17.0, 46.0, 25.0], [1.0])
    with pytest.raises(ValueError, match="depth is 100 m"):
        interpolate(database, [17.0, 40.0, 25.0], [1.0], depth=100.0)
    with pytest.raises(ValueError, match="not a finite number"):
        replace(database, infinite=np.full_like(database.infinite, np.nan))
