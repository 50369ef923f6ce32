"""Rotor speed and controller: gains of a published turbine, poles, elimination, and what the platform feels."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from model.conventions import PLATFORM_DOFS
from model.response.assemble import assemble, equilibrium, natural_modes
from model.response.solve import Excitation, solve
from model.system.aero import RotorDerivatives, operating_turbine, spinning_inertia
from model.system.contributions import turbine_contribution
from model.system.controller import (
    ROTOR_AZIMUTH,
    Controller,
    controlled_turbine,
    pitch_gains,
    rotor_impedance,
    torque_slope,
)

GENERATOR = 97**2 * 534.116
RATED = 12.1 * np.pi / 30
# The shape of a rotor above rated wind, of the size of the NREL 5 MW turbine: torque and thrust fall with pitch.
ABOVE = RotorDerivatives(
    wind_speed=16.0, rotor_speed=RATED, pitch=0.2, thrust=3.8e5, torque=4.1e6, thrust_wind=7.6e4, thrust_speed=-3.6e5,
    thrust_pitch=-3.5e6, torque_wind=1.1e6, torque_speed=-7.3e6, torque_pitch=-3.3e7,
)  # fmt: skip
BELOW = replace(
    ABOVE, wind_speed=8.0, rotor_speed=0.96, pitch=0.0, thrust=3.8e5, torque=1.9e6, thrust_wind=6.4e4, thrust_speed=2.6e5,
    torque_wind=7e5, torque_speed=-1.9e6, torque_pitch=-1e6,
)  # fmt: skip


def gains(frequency=0.6, ratio=0.7, **change):
    inertia = 3.87e7 + GENERATOR
    kp, ki = pitch_gains(ABOVE, inertia, frequency, ratio)
    return Controller(pitch_proportional=kp, pitch_integral=ki, **change)


@pytest.fixture(scope="module")
def structure(oc4):
    return oc4.deck.elastodyn.structure


def test_published_gains():
    """Jonkman 2007, section 7.5: I 43,784,725 kg m2, 12.1 rpm, dP/dtheta -25.52e6 W/rad, 0.6 rad/s and 0.7 give, by generator
    speed (gear ratio 97), KP 0.01882681 s and KI 0.008068634; damping by the rotor's own torque is left out there.
    """
    plain = replace(ABOVE, rotor_speed=1.26711, torque_pitch=-25.52e6 / 1.26711, torque_speed=0.0)
    kp, ki = pitch_gains(plain, 43_784_725.0, 0.6, 0.7)
    assert np.isclose(kp / 97, 0.01882681, rtol=1e-3)  # 25.52 has four digits
    assert np.isclose(ki / 97, 0.008068634, rtol=1e-3)


@settings(max_examples=30, deadline=None)
@given(st.floats(0.1, 1.5), st.floats(0.2, 1.2), st.sampled_from(["constant_power", "constant_torque"]))
def test_the_speed_loop_has_the_poles_asked_for(structure, frequency, ratio, law):
    """With the platform held: I s2 + B s + C has natural frequency and damping ratio as designed, whatever the torque law."""
    slope = torque_slope(law, ABOVE)
    inertia = spinning_inertia(structure) + GENERATOR
    kp, ki = pitch_gains(ABOVE, inertia, frequency, ratio, slope=slope)
    controller = Controller(pitch_proportional=kp, pitch_integral=ki, torque_slope=slope)
    t = controlled_turbine(structure, (), ABOVE, controller, generator_inertia=GENERATOR)
    assert t.dofs[-1] == ROTOR_AZIMUTH
    m, b, c = t.mass[-1, -1], t.damping[-1, -1], t.stiffness[-1, -1]
    assert np.isclose(np.sqrt(c / m), frequency, rtol=1e-9)
    assert np.isclose(b / (2 * np.sqrt(c * m)), ratio, rtol=1e-9)


def test_torque_laws():
    """Derivatives of k Omega^2, P / Omega and a constant at the point where they equal the aerodynamic torque."""
    assert np.isclose(torque_slope("optimal", BELOW), 2 * BELOW.torque / BELOW.rotor_speed)
    assert np.isclose(torque_slope("constant_power", BELOW), -BELOW.torque / BELOW.rotor_speed)
    assert torque_slope("constant_torque", BELOW) == 0
    with pytest.raises(ValueError, match="none of optimal"):
        torque_slope("best", BELOW)
    with pytest.raises(ValueError, match="above rated wind"):
        pitch_gains(replace(ABOVE, torque_pitch=1.0), 4e7, 0.6, 0.7)


@settings(max_examples=20, deadline=None)
@given(st.floats(0.05, 3.0))
def test_elimination_is_the_inverse_of_the_inverse(structure, omega):
    """The motion of platform and tower under a force and a wind is the same with the azimuth kept as with it eliminated."""
    t = controlled_turbine(structure, ("tower_fa1",), ABOVE, gains(platform_feedback=0.01), generator_inertia=GENERATOR)
    held = 1e7 * np.eye(7)
    z = t.stiffness - omega**2 * t.mass + 1j * omega * t.damping
    z[:7, :7] += held
    reduced, wind = rotor_impedance(t, [omega])
    full = np.linalg.solve(z, t.wind_force)[:7]
    assert np.allclose(np.linalg.solve(reduced[0] + held, wind[0]), full, rtol=1e-6, atol=1e-9 * np.abs(full).max())


def level(structure):
    """The turbine with a level shaft: thrust along surge and nothing else."""
    return replace(structure, rotor=replace(structure.rotor, tilt=0.0))


def test_a_fast_pitch_controller_takes_the_damping_away(structure):
    """Larsen and Hanson 2007: where pitch holds the speed, thrust falls with wind, by dT/dU - dT/dtheta (dQ/dU) / (dQ/dtheta)."""
    t = controlled_turbine(
        level(structure), (), ABOVE, gains(frequency=20.0), generator_inertia=GENERATOR, gradient_arm=0.0
    )
    omega = 0.05
    z, wind = rotor_impedance(t, [omega])
    closed = ABOVE.thrust_wind - ABOVE.thrust_pitch * ABOVE.torque_wind / ABOVE.torque_pitch
    assert closed < 0
    # the loop is 400 times faster than the motion; its lag leaves about 2 zeta omega / frequency = 0.4 % of either term
    assert np.isclose(z[0, 0, 0].imag / omega, closed, atol=0.01 * ABOVE.thrust_wind)
    assert np.isclose(wind[0, 0], closed, atol=0.01 * ABOVE.thrust_wind)


def test_floating_feedback_gives_it_back(structure):
    """Pitch in proportion to the hub's velocity adds -dT/dtheta times its gain to the damping where speed is not regulated."""
    plain = replace(ABOVE, torque_pitch=0.0)
    both = [
        controlled_turbine(
            level(structure), (), plain, Controller(platform_feedback=k), generator_inertia=GENERATOR, gradient_arm=0.0
        )
        for k in (0.0, 0.02)
    ]
    added = both[1].damping - both[0].damping
    assert np.isclose(added[0, 0], -ABOVE.thrust_pitch * 0.02, rtol=1e-9)
    assert np.isclose(added[0, 4], -ABOVE.thrust_pitch * 0.02 * structure.hub_height, rtol=1e-9)
    assert np.allclose(added[-1], 0.0, atol=1e-6)


def test_a_free_rotor_at_constant_torque(structure):
    """Slow wind changes speed until torque is what it was: thrust by wind is dT/dU - dT/dOmega (dQ/dU) / (dQ/dOmega)."""
    t = controlled_turbine(level(structure), (), BELOW, Controller(), generator_inertia=GENERATOR, gradient_arm=0.0)
    omega = 2e-3  # the rotor follows in I/B = 23 s: the real part is off by (omega I/B)2 = 0.2 %
    _, wind = rotor_impedance(t, [omega])
    closed = BELOW.thrust_wind - BELOW.thrust_speed * BELOW.torque_wind / BELOW.torque_speed
    assert np.isclose(wind[0, 0].real, closed, rtol=5e-3)


def test_a_heavy_rotor_holds_its_speed(structure):
    """With a generator of enormous inertia the rotor turns as at fixed speed: matrices and wind force are those."""
    t = controlled_turbine(structure, ("tower_fa1",), ABOVE, Controller(), generator_inertia=1e16)
    fixed = operating_turbine(structure, ("tower_fa1",), ABOVE)
    z, wind = rotor_impedance(t, [0.4])
    assert np.allclose(z[0].imag / 0.4, fixed.damping, atol=1e-6 * fixed.damping.max())
    assert np.allclose(wind[0], fixed.wind_force, rtol=1e-6, atol=1e-3)


@pytest.mark.parametrize(("rotor", "controller"), [(ABOVE, gains()), (BELOW, Controller(torque_slope=4e6))])
def test_it_joins_the_whole_model(oc4, structure, rotor, controller):
    """With the azimuth among the degrees of freedom the assembled floater has a mean offset and a response, and that response is
    the one of the eliminated rotor.
    """
    point = oc4.at(11.0)
    turbine = controlled_turbine(structure, ("tower_fa1",), rotor, controller, generator_inertia=GENERATOR)
    others = [p for p in point.system.parts if p.name != "turbine on its tower"]
    dofs = (*PLATFORM_DOFS, "tower_fa1", ROTOR_AZIMUTH)
    system = assemble(
        dofs, turbine, [turbine_contribution(turbine), *others], oc4.hydro, point.system.drag, oc4.deck.mooring
    )
    mean = equilibrium(system)
    assert 0.02 < mean.offset[4] < 0.12  # pitch under 380 kN at 90 m, some degrees
    if not controller.pitch_integral:
        assert abs(mean.offset[-1]) < 1e-6
    assert "pitch" in natural_modes(system, mean).names
    drive = replace(_waves(oc4), wind_spectrum=np.ones(3))
    response = solve(system, mean, drive, drag="none")
    z = response.dynamic_stiffness
    eliminated = z[:, :7, :7] - z[:, :7, 7:] @ z[:, 7:, :7] / z[:, 7:, 7:]
    wind = turbine.wind_force[:7] - z[:, :7, 7] / z[:, 7, 7:] * turbine.wind_force[7]
    assert np.allclose(np.linalg.solve(eliminated, wind[..., None])[..., 0], response.to_wind[:, :7], rtol=1e-6)


def _waves(oc4):
    omega = np.array([0.05, 0.2, 1.0])
    return Excitation(
        omega=omega,
        heading=[0.0],
        wave_spectrum=np.ones((1, 3)),
        wind_spectrum=np.zeros(3),
        gradient_spectrum=np.zeros(3),
    )


def test_misuse_is_explained(oc4, structure):
    with pytest.raises(ValueError, match="close the loop first"):
        rotor_impedance(oc4.at(11.0).turbine, [1.0])
