"""Tower and rotor-nacelle assembly from structural data: cantilevers, rigid bodies, OpenFAST's own matrices."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial import Polynomial

from model.conventions import PLATFORM_DOFS, rigid_mass, weight_stiffness
from model.system.tower import TOWER_MODES, Tower, polynomial, tower_modes
from model.system.turbine import (
    RigidBody,
    Rotor,
    TurbineStructure,
    gradient_forces,
    head_motion,
    rotor_nacelle,
    structural_matrices,
)

G = 9.80665
LENGTH, EI, MU = 80.0, 5e11, 4000.0  # m, N m2, kg/m
BEAM = (
    2.0,
    -4 / 3,
    1 / 3,
    0.0,
    0.0,
)  # static deflection of a uniform cantilever under its own distributed load: 6 x2 - 4 x3 + x4, over 3


def uniform(modes=BEAM, nodes=200, **change) -> Tower:
    values = {
        "base_height": 10.0, "top_height": 10.0 + LENGTH, "station": [0.0, 1.0], "mass_density": [MU, MU],
        "stiffness_fa": [EI, EI], "stiffness_ss": [EI, EI], "modes": modes if np.ndim(modes) == 2 else [modes] * 4, "damping_ratio": [0.01] * 4, "nodes": nodes,
    }  # fmt: skip
    return Tower(**(values | change))


def head(mass=0.0, centre=(0.0, 0.0, 0.0), inertia=0.0):
    return RigidBody(mass=mass, centre=centre, inertia=inertia * np.eye(3))


def rotor(blades=3, tilt=0.0, cone=0.0, mass=0.0):
    return Rotor(
        blades=blades, apex=[-5.0, 0.0, 2.0], tilt=tilt, cone=cone, hub_mass=3 * mass, hub_inertia=2 * mass, hub_offset=0.3,
        node_radius=np.linspace(1.0, 60.0, 12), node_mass=np.linspace(mass, mass / 10, 12), diameter=120.0,
    )  # fmt: skip


def structure(tower=None, nacelle=None, blades=None) -> TurbineStructure:
    return TurbineStructure(
        tower=tower or uniform(),
        nacelle=nacelle or head(),
        rotor=blades or rotor(),
        platform=head(),
        accelerometer=np.zeros(3),
        gravity=G,
    )


# --- tower modes -----------------------------------------------------------------------------------------------------


@given(st.lists(st.floats(-2, 2), min_size=5, max_size=5), st.integers(0, 3))
def test_polynomials_and_their_derivatives(coefficients, derivative):
    x = np.linspace(0, 1, 7)
    exact = Polynomial([0.0, 0.0, *coefficients])
    assert np.allclose(
        polynomial([coefficients], x, derivative)[:, 0],
        exact.deriv(derivative)(x) if derivative else exact(x),
        atol=1e-12,
    )


def test_stiffness_integral():
    """EI / L^3 times the integral of (phi'')^2, 16/5 for 4 (1 - x)^2, the curvature of this shape.

    Midpoint sums over 200 elements lack (1/200)^2 / 24 times 64, the change of the integrand's slope: 2.1e-5 of it.
    """
    found = tower_modes(uniform(), ("tower_fa1",))
    assert found.stiffness[0, 0] == pytest.approx(EI / LENGTH**3 * 16 / 5, rel=3e-5)


def test_first_frequency_of_a_cantilever():
    """Rayleigh's quotient of the static shape is 3.530 sqrt(EI / (mu L^4)), 0.4 % above the exact 3.516 and never below it."""
    found = tower_modes(uniform(), ("tower_fa1",))
    frequency = np.sqrt(found.stiffness[0, 0] / (found.mass @ found.shape[:, 0] ** 2))
    factor = frequency / np.sqrt(EI / (MU * LENGTH**4))
    assert 3.5160 < factor < 3.5160 * 1.005
    assert factor == pytest.approx(np.sqrt(16 / 5 / (104 / 405)), rel=1e-4)  # the same integrals by hand


def test_damping_is_that_of_the_bare_tower():
    """ElastoDyn: c = 2 zeta k / omega with omega of the tower alone."""
    found = tower_modes(uniform(), ("tower_fa1",))
    mass = found.mass @ found.shape[:, 0] ** 2
    assert found.damping[0, 0] / (2 * np.sqrt(found.stiffness[0, 0] * mass)) == pytest.approx(0.01)


def test_nodes_slopes_and_shortening():
    """Elements' midpoints; the top's slope; the axis shortens by half the integral of slope squared."""
    found = tower_modes(uniform(), ("tower_fa1",))
    assert found.height[0] == pytest.approx(10.0 + LENGTH / 400)
    assert found.mass.sum() == pytest.approx(MU * LENGTH)
    assert found.top_slope[0] == pytest.approx(4 / 3 / LENGTH)  # phi'(1) of 2 x2 - 4/3 x3 + x4/3
    # integral of (4 x - 4 x2 + 4/3 x3)^2: 16/3 - 8 + (16 + 32/3)/5 - 32/18 + 16/63 = 1.142857
    assert found.top_shortening[0, 0] == pytest.approx(1.142857 / LENGTH, rel=1e-4)
    assert found.shortening[-1, 0, 0] < found.top_shortening[0, 0]
    assert np.all(np.diff(found.shortening[:, 0, 0]) > 0)


def test_stiffness_tuner_scales_the_stiffness_alone():
    plain, tuned = (tower_modes(uniform(stiffness_tuner=[t] * 4), ("tower_fa1",)) for t in (1.0, 1.21))
    assert tuned.stiffness == pytest.approx(1.21 * plain.stiffness)
    assert np.array_equal(tuned.mass, plain.mass)


def test_fore_aft_and_sideways_do_not_mix():
    tower = uniform(stiffness_ss=[2 * EI, 2 * EI], modes=[BEAM, (0.0, 4.0, -3.0, 0, 0), BEAM, (0.0, 4.0, -3.0, 0, 0)])
    found = tower_modes(tower, TOWER_MODES)
    assert not found.stiffness[:2, 2:].any()
    assert found.stiffness[0, 1] != 0  # two polynomials of one plane are not orthogonal
    assert np.allclose(found.stiffness[2:, 2:], 2 * found.stiffness[:2, :2])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"top_height": 5.0}, "tower top at 5.0 m is not above its base"),
        ({"station": [0.0, 0.0]}, "stations that ascend"),
        ({"nodes": 0}, "at least one node"),
        ({"modes": np.zeros((4, 4))}, "modes has shape"),
    ],
)
def test_impossible_towers(change, message):
    with pytest.raises(ValueError, match=message):
        uniform(**change)


def test_unknown_mode():
    with pytest.raises(ValueError, match="unknown tower mode 'tower_fa3', known are tower_fa1"):
        tower_modes(uniform(), ("tower_fa3",))


# --- rotor and nacelle -----------------------------------------------------------------------------------------------


def spinning(r: Rotor, azimuth: float) -> RigidBody:
    """The blades of a rotor turned by an azimuth, summed node by node."""
    axis = np.array([np.cos(r.tilt), 0, np.sin(r.tilt)])
    up = np.cross(axis, [0, 1, 0])
    total, first, second = 0.0, np.zeros(3), np.zeros((3, 3))
    for k in range(r.blades):
        psi = azimuth + 2 * np.pi * k / r.blades
        radial = np.cos(psi) * up + np.sin(psi) * np.array([0, 1.0, 0])
        along = np.cos(r.cone) * radial + np.sin(r.cone) * axis
        for radius, m in zip(r.node_radius, r.node_mass, strict=True):
            p = r.apex + radius * along
            total, first = total + m, first + m * p
            second += m * ((p @ p) * np.eye(3) - np.outer(p, p))
    centre = first / total
    return RigidBody(
        mass=total, centre=centre, inertia=second - total * ((centre @ centre) * np.eye(3) - np.outer(centre, centre))
    )


@given(st.floats(0, 2 * np.pi), st.floats(-0.2, 0.2), st.floats(-0.2, 0.2), st.integers(3, 5))
@settings(max_examples=30)
def test_three_and_more_blades_are_a_disk(azimuth, tilt, cone, blades):
    """At any azimuth the blades have the same mass matrix: that of rotor_nacelle, built at azimuth zero."""
    r = replace(rotor(blades, tilt, cone, 1000.0), hub_mass=0.0, hub_inertia=0.0)
    still, turned = rotor_nacelle(structure(blades=r)), spinning(r, azimuth)
    assert still.mass == pytest.approx(turned.mass)
    assert np.allclose(still.centre, turned.centre, atol=1e-9)
    assert np.allclose(still.inertia, turned.inertia, rtol=1e-9, atol=1e-3)


def test_two_blades_are_not_a_disk():
    r = replace(rotor(2, 0.0, 0.0, 1000.0), hub_mass=0.0, hub_inertia=0.0)
    assert not np.allclose(spinning(r, 0.0).inertia, spinning(r, 1.0).inertia, rtol=1e-2)


def test_hub_and_nacelle_join_by_the_parallel_axis_theorem():
    """Two point masses and inertias: Steiner. The hub lies 0.3 m from the apex along the shaft."""
    r = replace(rotor(0), hub_mass=50.0, hub_inertia=7.0, tilt=0.1)
    body = rotor_nacelle(structure(nacelle=head(100.0, (1.0, 0.0, 2.0), 9.0), blades=r))
    axis = np.array([np.cos(0.1), 0.0, np.sin(0.1)])
    hub = r.apex + 0.3 * axis
    centre = (100.0 * np.array([1.0, 0, 2.0]) + 50.0 * hub) / 150.0
    between = hub - [1.0, 0.0, 2.0]
    reduced = 100.0 * 50.0 / 150.0
    inertia = (
        9.0 * np.eye(3)
        + 7.0 * np.outer(axis, axis)
        + reduced * ((between @ between) * np.eye(3) - np.outer(between, between))
    )
    assert body.mass == 150.0
    assert np.allclose(body.centre, centre)
    assert np.allclose(body.inertia, inertia)


# --- matrices --------------------------------------------------------------------------------------------------------


def test_rigid_tower_is_a_rigid_body():
    """Without modes: the mass matrix and the weight's stiffness of one rigid body."""
    nacelle = head(2e5, (1.0, 0.5, 2.0), 1e6)
    found = structural_matrices(structure(nacelle=nacelle, blades=rotor(mass=0.0)), ())
    tower = rigid_mass(MU * LENGTH, [0, 0, 50.0])
    # midpoint nodes are 200 points: their own inertia is mu L^3 / 12 less (1/200)^2
    tower[3, 3] += MU * LENGTH**3 / 12
    tower[4, 4] += MU * LENGTH**3 / 12
    top = rigid_mass(2e5, [1.0, 0.5, 92.0], 1e6 * np.eye(3))
    assert np.allclose(found.mass, tower + top, rtol=1e-4, atol=1.0)
    exact = weight_stiffness(MU * LENGTH, [0, 0, 50.0], G) + weight_stiffness(2e5, [1.0, 0.5, 92.0], G)
    assert np.allclose(found.stiffness, exact, rtol=1e-12, atol=1e-3)
    weight = (MU * LENGTH + 2e5) * G
    assert np.allclose(found.force, [0, 0, -weight, -0.5 * 2e5 * G, 1.0 * 2e5 * G, 0])


def test_heavy_top_on_a_light_cantilever():
    """Top mass m on a massless tower of shape x^2: k = 4 EI / L^3 less the weight's m g times 4/(3 L), coupling m g with pitch."""
    tower = uniform(modes=(1.0, 0, 0, 0, 0), mass_density=[1e-9, 1e-9])
    found = structural_matrices(structure(tower, head(3e5)))
    assert found.stiffness[6, 6] == pytest.approx(4 * EI / LENGTH**3 - 3e5 * G * 4 / (3 * LENGTH), rel=1e-5)
    assert found.stiffness[4, 6] == pytest.approx(-3e5 * G)
    assert found.mass[6, 6] == pytest.approx(3e5)
    assert found.mass[0, 6] == pytest.approx(3e5)
    assert found.mass[4, 6] == pytest.approx(3e5 * 90.0)


def test_an_eccentric_top_bends_the_tower():
    """Weight off the axis turns the top: generalised force m g x times the slope, balanced by the static deflection."""
    found = structural_matrices(structure(uniform(mass_density=[1e-9, 1e-9]), head(1e5, (-0.5, 0, 0))))
    slope = 4 / 3 / LENGTH
    stiffness = EI / LENGTH**3 * 16 / 5 - 1e5 * G * 1.142857 / LENGTH
    # linear at the straight tower
    assert found.point[6] == pytest.approx(1e5 * G * -0.5 * slope / stiffness, rel=1e-3)
    # at that point weight and elastic force balance but for terms of second order in the deflection
    assert abs(found.force[6]) < 1e-3 * 1e5 * G * 0.5 * slope


@given(
    st.floats(1e3, 1e6),
    st.floats(-8, 8),
    st.floats(-2, 2),
    st.floats(0, 5),
    st.floats(-0.15, 0.15),
    st.floats(-0.1, 0.1),
    st.floats(10, 1e4),
)
@settings(max_examples=40)
def test_mass_is_symmetric_and_positive(mass, x, y, z, tilt, cone, blade):
    s = structure(uniform(nodes=20), head(mass, (x, y, z), mass * 10), rotor(3, tilt, cone, blade))
    matrix = structural_matrices(s, ("tower_fa1", "tower_ss1")).mass
    assert np.allclose(matrix, matrix.T, rtol=1e-12, atol=1e-9 * np.abs(matrix).max())
    scale = np.sqrt(np.diag(matrix))
    assert np.linalg.eigvalsh(matrix / np.outer(scale, scale)).min() > 0


@given(st.floats(-2.0, 2.0), st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
@settings(max_examples=20)
def test_stiffness_is_symmetric_but_for_yaw(deflection, x, y):
    """Weight has a potential: among deflections, roll and pitch the stiffness is symmetric; yaw has no row (fixed directions)."""
    s = structure(uniform(nodes=20), head(2e5, (x, y, 2.0)))
    k = structural_matrices(s, ("tower_fa1", "tower_ss1"), (deflection, -deflection)).stiffness
    keep = [3, 4, 6, 7]
    assert np.allclose(k[np.ix_(keep, keep)], k[np.ix_(keep, keep)].T, rtol=1e-9, atol=1e-3)
    assert not k[5].any()
    assert not k[:3].any()


def test_side_to_side_mirrors_fore_aft():
    """A symmetric turbine: sway, roll and the sideways mode are surge, pitch and the fore-aft mode with the signs of the turn."""
    found = structural_matrices(structure(nacelle=head(3e5, (0, 0, 2.0), 1e6)), ("tower_fa1", "tower_ss1"))
    for matrix in (found.mass, found.stiffness):
        assert matrix[0, 0] == pytest.approx(matrix[1, 1])
        assert matrix[0, 4] == pytest.approx(-matrix[1, 3])
        assert matrix[6, 6] == pytest.approx(matrix[7, 7])
        assert matrix[4, 6] == pytest.approx(-matrix[3, 7])
        assert matrix[6, 7] == pytest.approx(0, abs=1e-6)


def test_motion_of_a_point_on_the_top():
    """A metre of the mode moves a point 3 m above the top by 1 m and 3 m times the slope, and turns it."""
    shapes = tower_modes(uniform(), ("tower_fa1",))
    motion = head_motion(90.0, shapes, [0.0, 0.0, 3.0])
    slope = 4 / 3 / LENGTH
    assert np.allclose(motion[:, 6], [1 + 3 * slope, 0, 0, 0, slope, 0])
    assert np.allclose(motion[:3, 4], [93.0, 0, 0])


def test_gradients_of_the_wind_make_moments():
    """More wind above pushes the top of the disk: positive pitch. More wind at +y turns the disk about -z: negative yaw."""
    s = structure(nacelle=head(1e5))
    turbine = replace(structural_matrices(s), wind_force=np.array([1e5, 0, 0, 0, 9e6, 0, 1e5]))
    force = gradient_forces(s, turbine, 1000.0)
    assert force[0, 4] == pytest.approx(1e8)
    assert force[1, 5] == pytest.approx(-1e8)
    assert force[0, 6] == pytest.approx(1e8 * 4 / 3 / LENGTH)
    assert np.allclose(force[:, :3], 0, atol=1e-6)


# --- against OpenFAST ------------------------------------------------------------------------------------------------


def test_masses_of_the_embedded_turbine(oc4):
    """OC3/OC4 documents: tower 249 718 kg, hub height 90 m, rotor-nacelle assembly 350 000 kg (rotor 110 000, nacelle 240 000)."""
    s = oc4.deck.elastodyn.structure
    assert tower_modes(s.tower, ()).mass.sum() == pytest.approx(249_718, rel=1e-3)
    # blades are lumped at 17 nodes: 0.3 %
    assert rotor_nacelle(s).mass == pytest.approx(350_000, rel=3e-3)
    assert s.hub_height == pytest.approx(90.0, abs=0.01)
    assert s.rotor.diameter == pytest.approx(126.0 * np.cos(np.radians(2.5)), abs=0.01)  # swept by the coned blades


def test_dofs_and_rest_of_the_embedded_turbine(oc4):
    found = structural_matrices(oc4.deck.elastodyn.structure)
    assert found.dofs == (*PLATFORM_DOFS, "tower_fa1")
    assert found.wind_speed == 0
    assert not found.wind_force.any()
    # pure gravity: the pitch stiffness is minus g times the first moment, by definition
    assert found.stiffness[4, 4] == pytest.approx(-G * found.mass[0, 4], rel=1e-12)
    assert found.stiffness[4, 4] == pytest.approx(
        -4.13072e8, rel=1e-4
    )  # hand calculation beside OpenFAST 5.0 reference run
