"""Wind node by node: a rotor of known thrusts in closed form, and the embedded linearisation with AeroDyn's node inputs."""

from dataclasses import replace

import numpy as np
import pytest

import fowtio
from fowtio.errors import ModelError
from fowtio.read.openfast_lin import read_openfast_lin
from model.environment.rotor_wind import rotor_sensitivity
from model.system.blade_wind import blade_wind, has_blade_inputs, sensitivity
from model.system.identified import SecondOrder, second_order
from model.system.linearisation import Linearisation

MASS = np.diag([2e6, 3e9])
HUB, RADII, SHARE = 90.0, np.array([10.0, 30.0, 55.0]), np.array([1e4, 3e4, 2e4])


def record(azimuth: float, blades: int = 3) -> Linearisation:
    """A rigid rotor without tilt on a platform that surges and pitches: node k of every blade gives SHARE[k] N per m/s at RADII[k]."""
    names = [f"AD Blade {b} X translation velocity, node {n}, m/s" for b in range(1, blades + 1) for n in (1, 2, 3)]
    psi = azimuth + 2 * np.pi * np.repeat(np.arange(blades), 3) / blades
    thrust, arm = np.tile(SHARE, blades), HUB + np.tile(RADII, blades) * np.cos(psi)
    b = np.vstack([np.zeros((2, len(names))), -np.linalg.solve(MASS, np.stack([thrust, thrust * arm]))])
    n = len(names)
    return Linearisation(
        A=np.zeros((4, 4)), B=b, C=np.zeros((0, 4)), D=np.zeros((0, n)), state_names=("x",) * 4, input_names=tuple(names), output_names=(),
        state_point=np.zeros(4), input_point=(0.0,) * n, output_point=(), state_rotating=np.zeros(4), input_rotating=np.zeros(n),
        output_rotating=(), state_order=np.full(4, 2), state_dof=("surge", "pitch") * 2, state_rate=[0, 0, 1, 1], azimuth=azimuth, rotor_speed=1.2,
    )  # fmt: skip


def form(dofs=("surge", "pitch")) -> SecondOrder:
    zero = np.zeros((2, 2))
    return SecondOrder(
        dofs=dofs, mass=MASS, damping=zero, stiffness=zero, wind_force=[0, 0], point=[0, 0], wind_speed=11.0, rotor_speed=1.2, mass_source="",
    )  # fmt: skip


@pytest.mark.parametrize("blades", [3, 4])
def test_closed_form(blades):
    records = [record(psi, blades) for psi in np.arange(4) * np.pi / 6]
    found = blade_wind(records, form(), blades)
    np.testing.assert_allclose(found.radius, RADII, rtol=1e-9)
    np.testing.assert_allclose(found.thrust, blades * SHARE, rtol=1e-9)
    np.testing.assert_allclose(found.uniform_force, blades * SHARE.sum() * np.array([1, HUB]), rtol=1e-9)
    # a vertical gradient: sum over the blades of w r^2 cos^2 = B/2 w r^2 of tilt moment, no thrust; a lateral one neither
    np.testing.assert_allclose(found.gradient_force[0], [0, blades / 2 * SHARE @ RADII**2], rtol=1e-9, atol=1e-3)
    np.testing.assert_allclose(found.gradient_force[1], 0, atol=1e-3)
    assert sensitivity(found, 1.2).gradient_arm == pytest.approx(SHARE @ RADII**2 / 2 / SHARE.sum())


def test_what_is_refused():
    with pytest.raises(ValueError, match="rigid blades"):
        blade_wind([record(0.0)], form(("surge", "flap1_cosine")))
    with pytest.raises(ValueError, match="LinInputs = 2"):
        blade_wind([replace(record(0.0), input_names=tuple("abcdefghi"))], form())


@pytest.fixture(scope="module")
def embedded(oc4_folder):
    records = [read_openfast_lin(oc4_folder / "linearisation" / "op11_blades" / f"main.{k}.lin") for k in (1, 2, 3, 4)]
    found = second_order(records, 87.6)
    return found, blade_wind(records, found)


def test_nodes_together_are_the_uniform_wind(embedded):
    # AeroDyn perturbs nodes and the wind by steps of their own (0.2 degrees of a blade's length, 0.035 m/s): some 0.3 %
    found, wind = embedded
    for dof in ("surge", "heave", "pitch", "tower_fa1"):
        k = found.dofs.index(dof)
        assert wind.uniform_force[k] == pytest.approx(found.wind_force[k], rel=5e-3), dof


def test_radii_are_those_of_the_blade(embedded):
    # NREL/TP-500-38060, table 3-1: aerodynamic nodes of the inner part of the working blade, radii in m; tilt and cone move the arm by 1 %
    radius = embedded[1].radius
    for node in (11.75, 15.85, 19.95, 24.05, 28.15, 32.25, 36.35, 40.45, 44.55, 48.65, 52.75):
        assert np.abs(radius / node - 1).min() < 0.03, node


def test_theory_of_the_rotor_against_its_nodes(embedded):
    # the theoretical blade (thrust in proportion to the radius, Prandtl's tip loss) has an arm of 944 m2; the real one, thinner outside, 7 % less
    wind = sensitivity(embedded[1], 1.245)
    assert wind.gradient_arm == pytest.approx(rotor_sensitivity(126.0, 3, 1.245, 11.0).gradient_arm, rel=0.08)


def test_study_takes_gradients_from_the_nodes(oc4_folder):
    case = fowtio.load(oc4_folder / "oc4_blades.fowt")
    model = fowtio.build(case)
    point = model.at(11.0)
    roll, pitch, yaw = (point.system.dofs.index(d) for d in ("roll", "pitch", "yaw"))
    assert len(point.rotor.radius) == 17
    theory = fowtio.build(replace(case, options=replace(case.options, wind_inputs="rotor"))).at(11.0)
    for row, k in ((0, pitch), (1, yaw)):  # tilt and yaw moments: what theory has too, within the difference of the arms
        assert abs(point.system.gradient_force[row, k]) == pytest.approx(abs(theory.system.gradient_force[row, k]), rel=0.1)
    # a vertical gradient also changes the blades' torque with azimuth: a force to the side and a roll moment, which theory leaves out
    assert abs(point.system.gradient_force[0, roll]) > 0.3 * abs(point.system.gradient_force[0, pitch])
    assert theory.system.gradient_force[0, roll] == 0


def test_study_without_node_inputs_is_told_how_to_get_them(oc4_folder):
    case = fowtio.load(oc4_folder / "oc4.fowt")
    assert not has_blade_inputs(read_openfast_lin(oc4_folder / "linearisation" / "turbine" / "U11" / "m.1.lin"))
    with pytest.raises(ModelError, match="LinInputs = 2"):
        fowtio.build(replace(case, options=replace(case.options, wind_inputs="blades")), speeds=[11.0])
