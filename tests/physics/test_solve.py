"""Responses: oscillators, Borgman's fixed point in a narrow sea, symmetries of a three-fold floater."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import trapezoid
from scipy.optimize import brentq

from model.conventions import PLATFORM_DOFS, rigid_mass, rotation
from model.environment.sea import SeaState
from model.response.assemble import assemble, equilibrium
from model.response.solve import excitation, frequency_grid, prepare, solve
from model.system.contributions import hydrostatic_contribution, platform_contribution, turbine_contribution
from model.system.turbine import RigidBody, TurbineMatrices, platform_matrices

STILL = SeaState(kind="still")
G = 9.80665


def narrow_sea(omega, variance, width=1e-3):
    """A sea of one frequency nearly: a box of `width` times the frequency on 21 frequencies; and those frequencies."""
    grid = omega * (1 + width * np.linspace(-0.5, 0.5, 21))
    return grid, SeaState(kind="table", omega=grid, spectrum=np.full(21, variance / (grid[-1] - grid[0])))


def std(response, dof):
    drive = response.excitation
    place = response.dofs.index(dof)
    return np.sqrt(trapezoid(np.abs(response.to_wave[0, :, place]) ** 2 * drive.wave_spectrum[0], drive.omega))


# --- linear oscillators ----------------------------------------------------------------------------------------------


@given(
    st.floats(0.5, 5.0),
    st.floats(0.0, 5.0),
    st.floats(0.5, 5.0),
    st.floats(0.01, 1.0),
    st.complex_numbers(min_magnitude=0.1, max_magnitude=9),
)
@settings(max_examples=40)
def test_oscillator(simple_body, mass, added, stiffness, damping, force):
    """X / (k - w^2 (m + a) + i w c), amplitude and phase."""
    system = simple_body(
        mass=mass * np.eye(6), added_mass=added * np.eye(6), stiffness=stiffness * np.eye(6), damping=damping * np.eye(6),
        excitation=force * np.ones(6), dofs=("heave",),
    )  # fmt: skip
    omega = np.array([0.1, 0.7, np.sqrt(stiffness / (mass + added)), 5.0])
    response = solve(system, equilibrium(system), excitation(omega, STILL, None))
    exact = force / (stiffness - omega**2 * (mass + added) + 1j * omega * damping)
    # the added mass is interpolated between equal values: rounding only
    assert np.allclose(response.to_wave[0, :, 0], exact, rtol=1e-9)
    assert np.angle(response.to_wave[0, 2, 0] / force) == pytest.approx(-np.pi / 2)  # at resonance a quarter late
    assert np.allclose(response.dynamic_stiffness[:, 0, 0], force / exact, rtol=1e-9)


@pytest.mark.parametrize("ratio", [0.005, 0.05, 0.3])
def test_variance_in_white_noise(simple_body, ratio):
    """pi S / (2 c k) for a one-sided force spectrum S per rad/s: the textbook variance of an oscillator in white noise.

    The grid ends at 1/100 and 100 times the natural frequency; what lies below is 4 z / (100 pi) of it (0.4 % at z = 0.3),
    what lies above 1e-6 z. 600 points resolve the rest to 0.1 %.
    """
    mass, stiffness, force = 2.0, 3.0, 4.0
    natural = np.sqrt(stiffness / mass)
    damping = 2 * ratio * np.sqrt(stiffness * mass)
    system = simple_body(
        mass=mass * np.eye(6),
        stiffness=stiffness * np.eye(6),
        damping=damping * np.eye(6),
        excitation=force * np.ones(6),
        dofs=("heave",),
    )
    omega = frequency_grid(natural / 100, 100 * natural, 600, [natural], [ratio])
    sea = SeaState(kind="white_noise", level=2 * np.pi, band=(1e-6, 1e3))  # 1 m2/(rad/s)
    response = solve(system, equilibrium(system), excitation(omega, sea, None))
    exact = np.pi * force**2 / (2 * damping * stiffness)
    below = force**2 / stiffness**2 * natural / 100
    assert std(response, "heave") ** 2 + below == pytest.approx(exact, rel=1.5e-3)


def test_wind_force(simple_body):
    """Response to wind is Z^-1 times the wind force, in the degrees of freedom kept."""
    system = simple_body(
        mass=np.eye(6),
        stiffness=2 * np.eye(6),
        damping=0.1 * np.eye(6),
        wind_force=np.arange(1.0, 7.0),
        dofs=("pitch", "surge"),
    )
    omega = np.array([0.3, 1.0])
    response = solve(system, equilibrium(system), excitation(omega, STILL, None))
    z = 2 - omega**2 + 0.1j * omega
    assert np.allclose(response.to_wind, np.array([5.0, 1.0]) / z[:, None])


def test_responses_superpose_over_headings(oc4):
    """One solution for two headings equals two solutions with the same drag."""
    point = oc4.at(0.0)
    omega = np.linspace(0.2, 1.0, 9)
    both = excitation(omega, STILL, None, headings=[0.0, 0.5])
    one = excitation(omega, STILL, None, headings=[0.5])
    together = solve(point.system, point.mean, both, drag="none").to_wave
    alone = solve(point.system, point.mean, one, drag="none").to_wave
    assert np.allclose(together[1], alone[0], rtol=1e-10)


# --- drag ------------------------------------------------------------------------------------------------------------

M, C, K = 1000.0, 2000.0, 800.0  # kg, N/m, kg/m


@pytest.mark.parametrize("height", [0.2, 2.0, 10.0])
def test_fixed_point_of_the_bodys_own_velocity(simple_body, plate, height):
    """|x| |C - w^2 M + i w K sqrt(8/pi) sigma_v| = |X| s: solved for sigma_v by bisection.

    2e-3: the iteration stops when coefficients change by 1e-3. The sea is 0.1 % wide, far from resonance.
    """
    omega, force = 2.0, 5000.0
    grid, sea = narrow_sea(omega, height**2)
    system = simple_body(
        mass=M * np.eye(6), stiffness=C * np.eye(6), excitation=force * np.ones(6), dofs=("heave",), drag=plate(K)
    )
    response = solve(system, equilibrium(system), excitation(grid, sea, None), drag="body")

    def speed(sigma):
        return omega * force * height / abs(C - omega**2 * M + 1j * omega * K * np.sqrt(8 / np.pi) * sigma) - sigma

    exact = brentq(speed, 1e-9, 1e3)
    assert response.converged
    assert std(response, "heave") * omega == pytest.approx(exact, rel=2e-3)
    assert response.drag_damping[2, 2] == pytest.approx(K * np.sqrt(8 / np.pi) * exact, rel=2e-3)


@pytest.mark.parametrize("height", [0.2, 2.0, 10.0])
def test_fixed_point_of_the_relative_velocity(simple_body, plate, height):
    """The same with moving water: Z x = X + i w b w0, b = K sqrt(8/pi) sigma of (water - body)."""
    omega, force, depth = 2.0, 3000.0, 3.0
    grid, sea = narrow_sea(omega, height**2)
    system = simple_body(
        mass=M * np.eye(6),
        stiffness=C * np.eye(6),
        excitation=force * np.ones(6),
        dofs=("heave",),
        drag=plate(K, position=(0, 0, -depth)),
    )
    response = solve(system, equilibrium(system), excitation(grid, sea, None))
    water = 1j * omega * np.exp(-(omega**2) / G * depth)  # vertical velocity per metre, deep water

    def motion(sigma):
        b = K * np.sqrt(8 / np.pi) * sigma
        return (force + b * water) / (C - omega**2 * M + 1j * omega * b)

    sigma = brentq(lambda s: abs(water - 1j * omega * motion(s)) * height - s, 1e-9, 1e3)
    middle = response.to_wave[0, 10, 0]
    assert middle == pytest.approx(motion(sigma), rel=4e-3)  # amplitude and phase
    assert response.drag_damping[2, 2] == pytest.approx(K * np.sqrt(8 / np.pi) * sigma, rel=2e-3)


def test_a_body_of_drag_alone_moves_with_the_water(simple_body, plate):
    """When drag rules, the relative velocity vanishes: heave is the water's own, e^{kz} per metre, in phase."""
    omega = 1.0
    grid, sea = narrow_sea(omega, 1.0)
    system = simple_body(
        mass=np.eye(6), stiffness=2 * np.eye(6), dofs=("heave",), drag=plate(1e5, position=(0, 0, -5.0))
    )
    response = solve(system, equilibrium(system), excitation(grid, sea, None), limit=400)
    # K sqrt(8/pi) s^2 balances (C - w^2 M) times the motion, 0.6 N: a relative velocity s of 2e-3 m/s
    assert response.to_wave[0, 10, 0] == pytest.approx(np.exp(-(omega**2) / G * 5.0), abs=4e-3)


def test_quadratic_damping_matrix_counts_as_drag(simple_body, plate):
    """A quadratic damping on heave equals an end plate of the same factor."""
    omega = 2.0
    grid, sea = narrow_sea(omega, 4.0)
    drive = excitation(grid, sea, None)
    quadratic = np.zeros((6, 6))
    quadratic[2, 2] = K
    common = {"mass": M * np.eye(6), "stiffness": C * np.eye(6), "excitation": 5000.0 * np.ones(6), "dofs": ("heave",)}
    by_matrix, by_plate = simple_body(**common, quadratic_damping=quadratic), simple_body(**common, drag=plate(K))
    a = solve(by_matrix, equilibrium(by_matrix), drive)
    b = solve(by_plate, equilibrium(by_plate), drive, drag="body")
    assert a.drag_damping[2, 2] == pytest.approx(b.drag_damping[2, 2], rel=2e-3)  # two iterations, each to 1e-3


def test_drag_models(simple_body, plate):
    system = simple_body(mass=np.eye(6), stiffness=np.eye(6), excitation=np.ones(6), drag=plate(1.0))
    grid, sea = narrow_sea(2.0, 1.0)
    drive, mean = excitation(grid, sea, None), equilibrium(system)
    none = solve(system, mean, drive, drag="none")
    assert not none.drag_damping.any()
    assert none.iterations == 0
    assert none.converged
    with pytest.raises(ValueError, match="drag model 'relativ' is none of relative, third_order, body, global, none"):
        solve(system, mean, drive, drag="relativ")


def test_more_waves_more_damping(oc4):
    point = oc4.at(0.0)
    found = [
        solve(
            point.system,
            point.mean,
            excitation(oc4.omega, SeaState(kind="jonswap", significant_height=h, peak_period=10.0), None),
        )
        for h in (1.0, 4.0, 8.0)
    ]
    assert all(r.converged for r in found)
    assert np.all(np.diff([r.drag_damping[2, 2] for r in found]) > 0)


def test_small_waves_are_linear(oc4):
    """Drag vanishes with the waves: at 1 mm it gives the response without drag, except for 1e-3 or so at resonance."""
    point = oc4.at(0.0)
    tiny = excitation(oc4.omega, SeaState(kind="jonswap", significant_height=1e-3, peak_period=10.0), None)
    with_drag, without = solve(point.system, point.mean, tiny), solve(point.system, point.mean, tiny, drag="none")
    assert std(with_drag, "surge") == pytest.approx(std(without, "surge"), rel=1e-2)


# --- grid ------------------------------------------------------------------------------------------------------------


@given(
    st.floats(1e-3, 0.5),
    st.floats(1.5, 1e3),
    st.integers(20, 600),
    st.lists(st.floats(0.01, 10.0), max_size=5),
    st.floats(1e-4, 2.0),
)
def test_grid_properties(low, span, count, natural, damping):
    high = low * span
    grid = frequency_grid(low, high, count, natural, [damping] * len(natural), edges=[low * span**0.5])
    assert len(grid) == count
    assert np.all(np.diff(grid) > 0)
    assert grid[0] == pytest.approx(low)
    assert grid[-1] == pytest.approx(high)
    near = grid[np.abs(grid / (low * span**0.5) - 1) < 1e-8]
    assert len(near) >= 2  # the edge of a spectrum from both sides


def test_grid_is_dense_where_modes_are():
    grid = frequency_grid(0.02, 4.0, 400, [0.5], [0.005])
    step = np.diff(grid)
    assert step[np.searchsorted(grid, 0.5)] < 0.005 * 0.5 / 10  # ten points in a half width


@pytest.mark.parametrize("arguments", [(0.0, 1.0, 100), (1.0, 0.5, 100), (0.1, 1.0, 5)])
def test_grids_that_make_no_sense(arguments):
    with pytest.raises(ValueError, match="a frequency grid needs 0 < low < high and 10 points"):
        frequency_grid(*arguments)


# --- symmetry of the three-column semisubmersible --------------------------------------------------------------------


@pytest.fixture(scope="module")
def symmetric(oc4):
    """The embedded floater with its turbine replaced by a rigid mass on the axis: three-fold and mirror symmetric."""
    mass, stiffness, force = platform_matrices(
        RigidBody(mass=6e5, centre=[0, 0, 70.0], inertia=np.diag([5e8, 5e8, 2.5e7])), G
    )
    zero = np.zeros((6, 6))
    turbine = TurbineMatrices(
        dofs=PLATFORM_DOFS,
        mass=mass,
        damping=zero,
        stiffness=stiffness,
        force=force,
        point=np.zeros(6),
        wind_force=np.zeros(6),
    )
    parts = [
        turbine_contribution(turbine),
        platform_contribution(oc4.deck.elastodyn.structure.platform, G, ""),
        hydrostatic_contribution(oc4.hydro, ""),
    ]
    system = assemble(PLATFORM_DOFS, turbine, parts, oc4.hydro, oc4.points[0].system.drag, oc4.deck.mooring)
    return system, equilibrium(system)


OMEGA = np.linspace(0.2, 1.2, 41)


def response_at(symmetric, heading):
    sea = SeaState(kind="jonswap", significant_height=4.0, peak_period=10.0, heading=np.radians(heading))
    return solve(*symmetric, excitation(OMEGA, sea, None)).to_wave[0]


@pytest.mark.parametrize("heading", np.arange(15.0, 180.0, 15.0))
def test_mirrored_waves_mirror_the_response(symmetric, heading):
    """Waves from the other side: surge, heave, pitch alike, sway, roll, yaw opposite.

    The coefficients of negative headings are mirror images, written with six digits; drag stops at 1e-3 in both alike.
    """
    mirror = np.array([1, -1, 1, -1, 1, -1.0])
    a, b = response_at(symmetric, heading), response_at(symmetric, -heading)
    size = np.abs(a).max(axis=0)
    assert np.all(np.abs(a - mirror * b).max(axis=0) < 1e-4 * size)


def test_head_waves_do_not_move_it_sideways(symmetric):
    a = response_at(symmetric, 0.0)
    assert np.abs(a[:, [1, 3, 5]]).max() < 1e-4 * np.abs(a[:, [0, 4]]).max()


@pytest.mark.parametrize("turn", [120.0, -120.0])
@pytest.mark.parametrize("heading", np.arange(0.0, 360.0, 30.0))
def test_turning_the_waves_by_120_degrees_turns_the_response(symmetric, heading, turn):
    """Three columns and three lines at 120 degrees. The panels of the mesh are not turned with the columns, so excitation and
    added mass of equal columns differ by a per cent or so: 3 % of each motion's largest value.
    """
    r = rotation([0, 0, np.radians(turn)])
    turned = np.kron(np.eye(2), r)
    a, b = response_at(symmetric, heading), response_at(symmetric, heading + turn)
    expected = a @ turned.T
    size = np.abs(expected).max(axis=0)
    size = np.concatenate(
        [[size[:2].max()] * 2, [size[2]], [size[3:5].max()] * 2, [max(size[5], 1e-3 * size[3:5].max())]]
    )
    difference = np.abs(b - expected).max(axis=0)
    assert np.all(difference[:5] < 0.03 * size[:5])


def test_a_spread_sea_is_the_sum_of_its_headings(oc4):
    """The variance of a short-crested sea lies between those of its headings; sway appears, surge gets less."""
    point = oc4.at(0.0)
    omega = OMEGA
    common = {"kind": "jonswap", "significant_height": 3.0, "peak_period": 10.0}
    long_crested = solve(point.system, point.mean, excitation(omega, SeaState(**common), None), drag="none")
    spread = excitation(omega, SeaState(**common, spreading=5.0), None)
    response = solve(point.system, point.mean, spread, drag="none")
    variance = trapezoid(np.einsum("mnq,mn->nq", np.abs(response.to_wave) ** 2, spread.wave_spectrum), omega, axis=0)
    assert spread.wave_spectrum.sum(axis=0) == pytest.approx(long_crested.excitation.wave_spectrum[0])
    assert variance[0] < std(long_crested, "surge") ** 2
    assert variance[1] > 0.05 * variance[0]


def test_a_heading_without_data_is_refused(symmetric):
    system, _ = symmetric
    hydro = replace(system.hydro, heading=system.hydro.heading[6:8], excitation=system.hydro.excitation[6:8])
    with pytest.raises(ValueError, match=r"heading 90.0 deg lies outside the excitation data \(0.0 to 30.0 deg\)"):
        prepare(replace(system, hydro=hydro), OMEGA, [np.pi / 2])


def test_rigid_mass_is_what_the_platform_part_holds():
    body = RigidBody(mass=3.0, centre=[1.0, 2.0, 3.0], inertia=np.eye(3))
    mass, _, force = platform_matrices(body, G)
    assert np.allclose(mass, rigid_mass(3.0, [1, 2, 3], np.eye(3)))
    assert np.allclose(force, [0, 0, -3 * G, -2 * 3 * G, 3 * G, 0])
