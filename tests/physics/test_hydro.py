"""Hydrodynamic coefficients: interpolation, limits, headings and the transfer to another point."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fowtio.read.wamit import read_wamit
from model.conventions import move_force, point_motion, rigid_mass
from model.system.hydro import (
    HydroCoefficients,
    excitation_at,
    headings_cover,
    infinite_added_mass,
    radiation_at,
    refined,
    transfer,
)

OC4 = Path(__file__).parents[2] / "validation/oc4_deepcwind/input/hydro/oc4"
EXACT = 1e-12  # a few operations in double precision


def random_hydro(seed=0, n=6, headings=(0.0, 30.0, 60.0, 90.0), **changes) -> HydroCoefficients:
    """Return coefficients with symmetric added mass, symmetric non-negative damping and any excitation."""
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(2, n + 2, 6, 6))
    added, damping = root @ np.swapaxes(root, -1, -2)
    own = {
        "omega": np.sort(rng.uniform(0.1, 3.0, n)),
        "added_mass": added[2:],
        "radiation_damping": damping[2:],
        "added_mass_zero": added[0],
        "added_mass_infinite": added[1],
        "heading": np.radians(headings),
        "excitation": rng.normal(size=(len(headings), n, 6)) + 1j * rng.normal(size=(len(headings), n, 6)),
        "hydrostatic_stiffness": cylinder_stiffness((0.0, 0.0, 0.0)),
        "volume": VOLUME,
    }
    return HydroCoefficients(**(own | changes))


# a vertical cylinder off the origin: closed forms of its hydrostatics and of its strip-theory added mass
AXIS, RADIUS, DRAFT, DENSITY, GRAVITY = np.array([3.0, -2.0]), 4.0, 20.0, 1025.0, 9.80665
AREA = np.pi * RADIUS**2
VOLUME = AREA * DRAFT


def cylinder_stiffness(point) -> np.ndarray:
    """Return the buoyancy stiffness of the cylinder about a point: waterplane moments, and buoyancy about the point."""
    x, y, z = np.append(AXIS, -DRAFT / 2) - point
    second = np.pi * RADIUS**4 / 4
    c = np.zeros((6, 6))
    c[2, 2], c[2, 3], c[2, 4] = AREA, AREA * y, -AREA * x
    c[3, 3], c[3, 4], c[4, 4] = second + AREA * y**2, -AREA * x * y, second + AREA * x**2
    c = c + np.triu(c, 1).T
    c[3, 3], c[4, 4] = c[3, 3] + VOLUME * z, c[4, 4] + VOLUME * z
    c[3, 5], c[4, 5] = -VOLUME * x, -VOLUME * y
    return DENSITY * GRAVITY * c


def cylinder_added_mass(point) -> np.ndarray:
    """Return the strip-theory added mass of the cylinder about a point: rho A on every horizontal slice."""
    x, y, _ = np.append(AXIS, 0.0) - point
    bottom, top = -DRAFT - point[2], -point[2]
    m0, m1, m2 = (DENSITY * AREA * (top**k - bottom**k) / k for k in (1, 2, 3))
    a = np.zeros((6, 6))
    a[0, 0] = a[1, 1] = m0
    a[0, 4], a[1, 3] = m1, -m1
    a[0, 5], a[1, 5] = -m0 * y, m0 * x
    a[3, 3] = a[4, 4] = m2
    a[3, 5], a[4, 5] = -m1 * x, -m1 * y
    a[5, 5] = m0 * (x**2 + y**2)
    return a + np.triu(a, 1).T


points = st.tuples(*[st.floats(-50, 50)] * 3)
any_omega = st.lists(st.floats(0, 20), min_size=1, max_size=8)


@settings(max_examples=40, deadline=None)
@given(omega=any_omega, seed=st.integers(0, 50))
def test_interpolation_keeps_symmetry_and_non_negative_damping(omega, seed):
    added, damping = radiation_at(random_hydro(seed), omega)
    np.testing.assert_allclose(added, np.swapaxes(added, -1, -2), rtol=EXACT, atol=EXACT)
    # eigenvalues of a non-negative matrix of norm about 30 are rounded by 1e-16 of the norm, with room for six rows
    assert np.linalg.eigvalsh(damping).min() > -1e-12
    assert np.linalg.eigvalsh(added).min() > -1e-12  # these data's added mass is positive too


def test_the_data_themselves_and_their_limits():
    h = random_hydro()
    added, damping = radiation_at(h, h.omega)
    np.testing.assert_allclose(added, h.added_mass, rtol=EXACT)
    np.testing.assert_allclose(damping, h.radiation_damping, rtol=EXACT)
    added, damping = radiation_at(h, [0.0, 1e6])
    np.testing.assert_allclose(added[0], h.added_mass_zero, rtol=EXACT)
    np.testing.assert_allclose(damping[0], 0.0, atol=EXACT)
    # beyond the data the difference to the limit falls as omega^-2: (3 / 1e6)^2 is 1e-11 of elements of order 10
    np.testing.assert_allclose(added[1], h.added_mass_infinite, atol=1e-8)
    np.testing.assert_allclose(damping[1], 0.0, atol=1e-18)


@given(seed=st.integers(0, 1000))
@settings(max_examples=20, deadline=None)
def test_refined_coefficients_are_the_data_and_give_no_energy(seed):
    hydro = random_hydro(seed, n=9)
    fine = refined(hydro)
    at = np.searchsorted(fine.omega, hydro.omega)
    for name in ("added_mass", "radiation_damping"):
        assert np.allclose(getattr(fine, name)[at], getattr(hydro, name), rtol=1e-9, atol=1e-9)
    assert np.allclose(fine.excitation[:, at], hydro.excitation, rtol=1e-9, atol=1e-9)
    assert np.diff(fine.omega).max() <= 0.0125 * (1 + 1e-9)
    values = np.linalg.eigvalsh((fine.radiation_damping + np.swapaxes(fine.radiation_damping, 1, 2)) / 2)
    assert values.min() > -1e-9 * values.max()  # a spline between random data overshoots below zero; that is cut


def test_refined_coefficients_follow_a_cubic():
    """A spline through a cubic is that cubic."""
    omega = np.array([0.1, 0.3, 0.6, 0.7, 1.2, 1.5])
    shape = np.eye(6) * np.arange(1.0, 7.0)
    hydro = random_hydro(
        n=6, omega=omega, added_mass=(2 - omega**3)[:, None, None] * shape, radiation_damping=(omega + omega**3)[:, None, None] * shape
    )  # fmt: skip
    fine = refined(hydro)
    w = fine.omega[:, None, None]
    assert np.allclose(fine.added_mass, (2 - w**3) * shape, atol=1e-12)
    assert np.allclose(fine.radiation_damping, (w + w**3) * shape, atol=1e-12)


def test_a_spline_meets_left_out_data_better_than_straight_lines():
    """Every second frequency of the OC4 data left out, below 1.5 rad/s, and found again between the others."""
    hydro = read_wamit(OC4)
    low = hydro.omega < 1.51
    kept = np.flatnonzero(low)[::2]
    out = np.flatnonzero(low)[1:-1:2]
    forward = int(np.argmin(np.abs(hydro.heading)))
    coarse = replace(
        hydro, omega=hydro.omega[kept], added_mass=hydro.added_mass[kept], radiation_damping=hydro.radiation_damping[kept],
        excitation=hydro.excitation[:, kept],
    )  # fmt: skip
    for k in (0, 2, 4):
        error = []
        for body in (coarse, refined(coarse)):
            force = excitation_at(body, hydro.omega[out], 0.0)
            added, damping = radiation_at(body, hydro.omega[out])
            error.append([
                np.abs(force - hydro.excitation[forward, out])[:, k].std(),
                np.abs(added - hydro.added_mass[out])[:, k, k].std(), np.abs(damping - hydro.radiation_damping[out])[:, k, k].std(),
            ])  # fmt: skip
        assert np.all(np.array(error[1]) < 0.6 * np.array(error[0]))


def test_beyond_the_data_the_stated_powers_of_frequency():
    h = random_hydro()
    top = h.omega[-1]
    added, damping = radiation_at(h, [2 * top])
    np.testing.assert_allclose(
        added[0] - h.added_mass_infinite, (h.added_mass[-1] - h.added_mass_infinite) / 4, rtol=1e-9
    )
    np.testing.assert_allclose(damping[0], h.radiation_damping[-1] / 16, rtol=EXACT)
    # far beyond, what the slope at the end has left is a constant more that falls alike; near by, there is no bend
    far, further = excitation_at(h, [4 * top, 8 * top], 0.0)
    np.testing.assert_allclose(further, far / 4, rtol=1e-9)
    step = 1e-4 * top
    before, at, after = excitation_at(h, [top - step, top, top + step], 0.0)
    # second difference over first: step / (2 FADE), 1e-3 here, of the slope that fades; the rest from omega^-2
    assert np.abs(after - 2 * at + before).max() < 2e-3 * np.abs(after - before).max() + 4 * (step / top) ** 2 * np.abs(at).max()


def test_without_limits_the_ends_are_held():
    h = random_hydro(added_mass_zero=None, added_mass_infinite=None)
    added, _ = radiation_at(h, [0.0, h.omega[0] / 2, 10.0])
    np.testing.assert_allclose(added, h.added_mass[[0, 0, -1]], rtol=EXACT)
    np.testing.assert_array_equal(infinite_added_mass(h), h.added_mass[-1])


def test_halfway_between_two_frequencies_is_their_mean():
    h = random_hydro()
    middle = h.omega[2:4].mean()
    added, damping = radiation_at(h, [middle])
    np.testing.assert_allclose(added[0], h.added_mass[2:4].mean(axis=0), rtol=1e-9)
    np.testing.assert_allclose(damping[0], h.radiation_damping[2:4].mean(axis=0), rtol=1e-9)
    np.testing.assert_allclose(excitation_at(h, [middle], 0.0)[0], h.excitation[0, 2:4].mean(axis=0), rtol=1e-9)


def test_below_the_data_excitation_is_held_or_goes_to_the_hydrostatic_limit():
    h = random_hydro()
    low = h.omega[0]
    np.testing.assert_allclose(excitation_at(h, [0.0, low / 2], 0.0), h.excitation[0, [0, 0]], rtol=EXACT)
    f = excitation_at(h, [0.0, low / 2], 0.0, low_frequency="hydrostatic")
    # the long-wave limit: the water rises by one metre everywhere, so the force is the heave column of the stiffness
    np.testing.assert_allclose(f[0], h.hydrostatic_stiffness[:, 2], rtol=EXACT)
    np.testing.assert_allclose(f[1], (h.hydrostatic_stiffness[:, 2] + h.excitation[0, 0]) / 2, rtol=1e-9)


@pytest.mark.parametrize(
    ("change", "call", "words"),
    [
        ({}, {"low_frequency": "zero"}, "hold, hydrostatic"),
        ({"hydrostatic_stiffness": None}, {"low_frequency": "hydrostatic"}, "hydrostatic stiffness"),
        ({"heading": None, "excitation": None}, {}, "no excitation"),
        ({}, {"heading": np.radians(120.0)}, r"120\.0 deg.*0\.0 to 90\.0"),
    ],
)
def test_excitation_that_cannot_be_had_is_refused(change, call, words):
    with pytest.raises(ValueError, match=words):
        excitation_at(random_hydro(**change), [1.0], **({"heading": 0.0} | call))


def test_headings_wrap_round_the_turn():
    h = random_hydro(headings=np.arange(-180.0, 180.0, 45.0))  # a full turn but for the closing heading
    middle = np.radians(157.5)  # between 135 and 180 = -180
    want = (h.excitation[-1] + h.excitation[0]) / 2
    np.testing.assert_allclose(excitation_at(h, h.omega, middle), want, rtol=1e-9)
    for turns in (-2, -1, 1):
        np.testing.assert_allclose(excitation_at(h, h.omega, middle + 2 * np.pi * turns), want, rtol=1e-9)
    np.testing.assert_allclose(excitation_at(h, h.omega, np.pi), h.excitation[0], rtol=1e-9)
    assert np.all(headings_cover(h, np.linspace(-10, 10, 50)))


def test_headings_of_a_half_turn_do_not_close():
    h = random_hydro(headings=(0.0, 90.0, 180.0))
    assert headings_cover(h, np.radians([0.0, 180.0, 360.0, -90.0, 270.0])).tolist() == [True, True, True, False, False]


def test_headings_broadcast():
    h = random_hydro()
    f = excitation_at(h, h.omega, np.radians([[0.0, 30.0], [60.0, 15.0]]))
    assert f.shape == (2, 2, 6, 6)
    np.testing.assert_allclose(f[1, 0], h.excitation[2], rtol=1e-9)
    np.testing.assert_allclose(f[1, 1], h.excitation[:2].mean(axis=0), rtol=1e-9)


@settings(max_examples=40, deadline=None)
@given(point=points, seed=st.integers(0, 20))
def test_transfer_and_back_is_the_identity(point, seed):
    h = random_hydro(seed, n=2)
    back = transfer(transfer(h, point), (0.0, 0.0, 0.0))
    for name in ("added_mass", "radiation_damping", "added_mass_zero", "added_mass_infinite", "excitation"):
        want = getattr(h, name)
        # moments are lengths squared (up to 1e4 m2) times forces: rounding of those, not of the values
        np.testing.assert_allclose(getattr(back, name), want, atol=1e-11 * np.abs(want).max() * 1e4, err_msg=name)
    np.testing.assert_allclose(
        back.hydrostatic_stiffness, h.hydrostatic_stiffness, atol=1e-11 * np.abs(h.hydrostatic_stiffness).max() * 1e2
    )


@settings(max_examples=40, deadline=None)
@given(point=points)
def test_transferred_stiffness_is_that_of_the_cylinder_about_the_point(point):
    moved = transfer(random_hydro(), point)
    want = cylinder_stiffness(point)
    np.testing.assert_allclose(moved.hydrostatic_stiffness, want, atol=1e-11 * np.abs(want).max())


@settings(max_examples=40, deadline=None)
@given(point=points)
def test_transferred_added_mass_is_that_of_the_cylinder_about_the_point(point):
    strips = np.broadcast_to(cylinder_added_mass(np.zeros(3)), (6, 6, 6))
    moved = transfer(random_hydro(added_mass=strips), point)
    want = cylinder_added_mass(np.asarray(point))
    np.testing.assert_allclose(moved.added_mass[3], want, atol=1e-11 * np.abs(want).max())


@settings(max_examples=40, deadline=None)
@given(point=points, centre=points)
def test_transferred_matrix_of_a_rigid_body_is_its_own_about_the_point(point, centre):
    inertia = np.diag([2.0, 3.0, 4.0])
    mass = np.broadcast_to(rigid_mass(7.0, centre, inertia), (6, 6, 6))
    moved = transfer(random_hydro(added_mass=mass), point)
    want = rigid_mass(7.0, np.subtract(centre, point), inertia)
    np.testing.assert_allclose(moved.added_mass[0], want, atol=1e-11 * (1 + np.abs(want).max()))


@settings(max_examples=30, deadline=None)
@given(point=points, seed=st.integers(0, 20))
def test_transferred_forces_do_the_same_work(point, seed):
    """Virtual work: a force about one point and the motion of that point give the same power as about another."""
    h = random_hydro(seed, n=2)
    moved = transfer(h, point)
    motion = np.random.default_rng(seed).normal(size=6)
    at_point = np.concatenate([point_motion(point) @ motion, motion[3:]])
    np.testing.assert_allclose(moved.excitation @ at_point, h.excitation @ motion, atol=1e-9)
    np.testing.assert_allclose(
        at_point @ moved.added_mass @ at_point, motion @ h.added_mass @ motion, rtol=1e-6, atol=1e-6
    )


def test_a_transfer_without_volume_is_refused_and_no_transfer_is_not():
    h = random_hydro(volume=None)
    with pytest.raises(ValueError, match="volume"):
        transfer(h, (0.0, 0.0, -5.0))
    np.testing.assert_array_equal(transfer(h, (0.0, 0.0, 0.0)).hydrostatic_stiffness, h.hydrostatic_stiffness)
    assert transfer(replace(h, hydrostatic_stiffness=None), (0, 0, -5.0)).hydrostatic_stiffness is None


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"omega": [1.0, 1.0, 2.0, 3.0, 4.0, 5.0]}, "omega must ascend"),
        ({"omega": [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]}, "positive and finite"),
        ({"omega": [1.0, 2.0, 3.0, 4.0, 5.0, np.inf]}, "positive and finite"),
        ({"heading": [0.0, 1.0, 0.5, 2.0]}, "heading must ascend"),
        ({"heading": None}, "belong together"),
        ({"added_mass": np.zeros((5, 6, 6))}, "added_mass has shape"),
        ({"radiation_damping": np.full((6, 6, 6), np.nan)}, "radiation_damping has a value"),
    ],
)
def test_inconsistent_data_are_refused(change, words):
    with pytest.raises(ValueError, match=words):
        random_hydro(**change)


def test_arrays_cannot_be_written():
    with pytest.raises(ValueError, match="read-only"):
        random_hydro().added_mass[0, 0, 0] = 1.0


class TestCommittedOc4:
    """The coefficients that come with the package: physics that any diffraction result must show."""

    hydro = read_wamit(OC4, density=1025.0, gravity=9.80665, depth=200.0)

    def test_added_mass_is_symmetric(self):
        a = self.hydro.added_mass
        size = np.sqrt(np.einsum("nii,njj->nij", a, a))
        # a source method on 2816 panels: reciprocity holds to the discretisation, below 1 % of the diagonals
        assert (np.abs(a - np.swapaxes(a, -1, -2)) / size).max() < 1e-2

    def test_damping_is_not_negative(self):
        b = self.hydro.radiation_damping
        scale = np.sqrt(np.diagonal(b, axis1=1, axis2=2).max(axis=0))
        normed = (b + np.swapaxes(b, -1, -2)) / 2 / np.outer(scale, scale)
        # eigenvalues of the damping, each mode scaled by its largest: negative only by the discretisation
        assert np.linalg.eigvalsh(normed).min() > -1e-2

    def test_long_wave_forces_lead_by_a_quarter_in_surge_and_none_in_heave(self):
        f = excitation_at(self.hydro, self.hydro.omega[:1], 0.0)[0]
        # the long-wave surge force goes with the water's acceleration, whose phase at the origin is +90 deg (elevation
        # e^{i(omega t - k x)}, so pressure gradient +i k). Scattered waves enter with k a, 1e-2: half a degree
        assert np.degrees(np.angle(f[0])) == pytest.approx(90.0, abs=0.5)
        assert np.degrees(np.angle(f[2])) == pytest.approx(0.0, abs=0.5)

    def test_opposite_headings_conjugate_nothing_but_mirror(self):
        """The platform mirrors itself in y = 0: heading -b turns the signs of sway, roll and yaw."""
        f = excitation_at(self.hydro, self.hydro.omega, np.radians([30.0, -30.0]))
        mirror = np.array([1, -1, 1, -1, 1, -1])
        # the mesh is a mirror image too: six printed digits of the largest value
        np.testing.assert_allclose(f[1], f[0] * mirror, atol=1e-5 * np.abs(f).max())

    def test_haskind_damping_from_the_excitation(self):
        """Newman (1977) eq. 6.173: B_ii = k/(8 pi rho g c_g) times the integral of |X_i|^2 over the headings.

        Infinite depth above 0.6 rad/s at 200 m (k h > 7); the headings are 30 deg apart, so the trapezoidal rule on a
        smooth periodic function holds while k times the radius of the platform (41 m) is below half their number.
        """
        w = self.hydro.omega
        some = (w > 0.6) & (w < 1.0)
        omega, g, rho = w[some], self.hydro.gravity, self.hydro.density
        heading = np.radians(np.arange(0.0, 360.0, 30.0))
        force = excitation_at(self.hydro, omega, heading)
        mean_square = (np.abs(force) ** 2).mean(axis=0)
        k, group = omega**2 / g, g / (2 * omega)
        want = (k / (4 * rho * g * group))[:, None] * mean_square
        own = np.diagonal(self.hydro.radiation_damping[some], axis1=1, axis2=2)
        # both come from the same mesh by different integrals: 3 % of the mode's largest damping; in heave the forces
        # on columns and plates nearly cancel, so their discretisation errors show enlarged
        for mode, tolerance in ((0, 0.03), (1, 0.03), (2, 0.12), (5, 0.03)):
            np.testing.assert_allclose(
                own[:, mode], want[:, mode], atol=tolerance * own[:, mode].max(), err_msg=str(mode)
            )

    def test_moments_follow_their_reference_point(self):
        moved = transfer(replace(self.hydro, volume=13917.0), (0.0, 0.0, -13.46))
        np.testing.assert_allclose(moved.excitation, move_force(self.hydro.excitation, (0.0, 0.0, -13.46)), rtol=EXACT)
