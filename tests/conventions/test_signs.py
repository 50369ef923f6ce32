"""Signs and phases that differ between programs, seen through the whole chain: each a trap of its own."""

import numpy as np
import pytest

from model.environment.sea import SeaState, wave_kinematics, wave_spectrum, wavenumber
from model.response.assemble import equilibrium
from model.response.solve import excitation, solve

STILL = SeaState(kind="still")


def test_phase_zero_is_a_crest_at_the_origin():
    """Elevation Re{e^{i(omega t - k x)}}: under the crest the water moves with the wave, and it rises a quarter period before."""
    omega = np.array([0.7])
    k = wavenumber(omega, 200.0, 9.80665)
    velocity = wave_kinematics(omega, k, 200.0, np.array([[0.0, 0.0, -1.0]]), 0.0).velocity
    horizontal, _, vertical = np.ravel(velocity)
    assert horizontal.real > 0
    assert abs(horizontal.imag) < 1e-12
    assert vertical.imag > 0  # i omega times the displacement: rising before the crest comes
    assert abs(vertical.real) < 1e-12


@pytest.mark.parametrize("heading", [0.0, 0.6, -2.0])
def test_heading_is_where_waves_go(heading):
    """Downwave the crest arrives later: the phase lags by k times the distance."""
    omega = np.array([0.7])
    k = wavenumber(omega, 200.0, 9.80665)
    place = 30.0 * np.array([np.cos(heading), np.sin(heading), 0.0]) - [0, 0, 1.0]
    field = wave_kinematics(omega, k, 200.0, np.array([[0.0, 0.0, -1.0], place]), heading).velocity
    here, there = np.squeeze(field)
    assert np.allclose(there, here * np.exp(-1j * k * 30.0))
    assert here[:2].real @ [np.cos(heading), np.sin(heading)] > 0


def test_positive_damping_makes_the_response_lag(simple_body):
    """Re{X e^{+i omega t}}: a lag is a negative imaginary part. With e^{-i omega t} by mistake it would lead."""
    system = simple_body(
        mass=np.eye(6), damping=0.2 * np.eye(6), stiffness=np.eye(6), excitation=np.ones(6), dofs=("heave",)
    )
    omega = np.array([0.5, 1.0, 2.0])
    response = solve(system, equilibrium(system), excitation(omega, STILL, None))
    assert np.all(response.to_wave[0, :, 0].imag < 0)
    assert np.angle(response.to_wave[0, 1, 0]) == pytest.approx(-np.pi / 2)


def test_spectra_are_one_sided_per_radian():
    """White noise of 1 m2/Hz is 1/(2 pi) m2/(rad/s); its variance is level times bandwidth."""
    level = wave_spectrum(SeaState(kind="white_noise", level=1.0, band=(0.005, 0.2)), np.array([0.5]))
    assert level[0] == pytest.approx(1 / (2 * np.pi))


def test_light_surge_body_follows_long_waves(oc4):
    """Long waves carry a floater around: surge follows the water's horizontal motion, -i times coth(kh) for a crest at the origin.

    At 0.15 rad/s the wave is over 1.5 km long, so the platform (81 m) is small; surge is well above its own frequency (0.055 rad/s),
    but still feels the moorings there by (0.055/0.15)^2 = 13 %, hence 20 %.
    """
    point = oc4.at(0.0)
    response = solve(
        point.system, point.mean, excitation(np.array([0.15, 0.1501]), SeaState(kind="still"), None), drag="none"
    )
    surge = response.to_wave[0, 0, 0]
    k = wavenumber(np.array([0.15]), 200.0, 9.80665)[0]
    assert surge / (-1j / np.tanh(k * 200.0)) == pytest.approx(1.0, abs=0.2)


def test_heave_follows_long_waves_in_phase(oc4):
    """Far below its natural frequency a floater rides on the crest: heave 1 m per metre, in phase.

    At 0.1 rad/s, 0.27 of the natural frequency: dynamic amplification 1/(1 - 0.27^2) = 1.08 less the wave's decay with draught, hence 10 %.
    """
    point = oc4.at(0.0)
    response = solve(
        point.system, point.mean, excitation(np.array([0.1, 0.1001]), SeaState(kind="still"), None), drag="none"
    )
    assert response.to_wave[0, 0, 2] == pytest.approx(1.0, abs=0.1)


def test_pitch_leans_with_the_wave_slope_and_the_tower_lags_outwards(oc4_loads):
    """A mean wind along +x pushes the floater downwind, pitches it positive and bends the tower forward; the upwind line is tightest."""
    item = oc4_loads["operating"]
    mean = dict(zip(item.channels.names, item.channels.mean, strict=True))
    assert mean["PtfmSurge"] > 0
    assert mean["PtfmPitch"] > 0
    assert mean["TTDspFA"] > 0
    assert mean["TwrBsFxt"] > 0
    assert mean["TwrBsMyt"] > 0
    assert mean["T[2]"] > max(mean["T[1]"], mean["T[3]"])  # the line along -x


def test_tower_top_deflection_is_relative_to_the_platform(oc4):
    """TTDspFA leaves out the platform's motion: a unit of the mode is a metre at the top whatever the platform does."""
    point = oc4.at(0.0)
    names = point.outputs.names
    row = point.outputs.position[names.index("TTDspFA")]
    assert np.array_equal(row, np.eye(7)[6])
