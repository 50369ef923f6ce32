"""Loads on the tower base, accelerations and tensions: static limits, Newton's law, differences."""

from dataclasses import replace

import numpy as np
import pytest

from model.environment.sea import SeaState
from model.response.loads import channel_response, linear_outputs, response_spectra
from model.response.solve import excitation, solve
from model.system.mooring import mooring_state

G = 9.80665
# Tower and rotor-nacelle assembly of the embedded turbine as OpenFAST 5.0 has them: mass, first and second moment about the
# waterline, read from the mass matrix of its linearisation (M11, M15, M55; OpenFAST 5.0 reference run)
MASS, FIRST, SECOND = 599_107.8, 4.212162e7, 3.414907e9
BASE = 10.0  # m, OC3-Hywind/OC4 tower


@pytest.fixture(scope="module")
def point(oc4):
    return oc4.at(0.0)


def row(point, name, kind="position"):
    return getattr(point.outputs, kind)[point.outputs.names.index(name)]


def test_static_tilt_loads_the_tower_base_with_its_weight(point):
    """Held still at an angle: shear W times angle along the section, moment W (z_G - base) times angle.

    5e-4: the linearisation's stiffness against the closed form, and the centre of mass at the bent position.
    """
    weight, centre = MASS * G, FIRST / MASS
    assert row(point, "TwrBsFxt")[4] == pytest.approx(weight, rel=5e-4)
    assert row(point, "TwrBsMyt")[4] == pytest.approx(weight * (centre - BASE), rel=5e-4)
    assert row(point, "TwrBsFyt")[3] == pytest.approx(-weight, rel=5e-4)
    assert row(point, "TwrBsMxt")[3] == pytest.approx(weight * (centre - BASE), rel=5e-4)


def test_inertia_loads(point):
    """Accelerated in surge: minus mass times acceleration, at the height of the centre of mass; in pitch the second moment."""
    shear, moment = row(point, "TwrBsFxt", "acceleration"), row(point, "TwrBsMyt", "acceleration")
    assert shear[0] == pytest.approx(-MASS, rel=1e-5)
    assert shear[4] == pytest.approx(-FIRST, rel=1e-5)
    assert moment[0] == pytest.approx(-(FIRST - BASE * MASS), rel=1e-5)
    assert moment[4] == pytest.approx(-(SECOND - BASE * FIRST), rel=1e-5)


def test_translations_do_not_load_the_tower_statically(point):
    """A shifted floater carries the same loads: below 1e-4 of the weight per metre (the linearisation's rounding is 25 N/m)."""
    for name in ("TwrBsFxt", "TwrBsFyt", "TwrBsMyt", "TwrBsMxt"):
        assert np.abs(row(point, name)[:3]).max() < 1e-4 * MASS * G


def test_a_bent_tower_leans_its_weight(point):
    """Static tower-top deflection: the moment at the base is weight times the shift of the centre of mass, no shear.

    The shift per metre is minus C57 / g (weight's coupling of deflection and pitch), 4.2304e6 / g in the linearisation with the
    OC3-Hywind tower file, 0.1 % apart from this tower's.
    """
    assert row(point, "TwrBsMyt")[6] == pytest.approx(4.2304e6, rel=2e-3)
    assert abs(row(point, "TwrBsFxt")[6]) < 1e-4 * row(point, "TwrBsMyt")[6]


def test_mean_loads_of_the_operating_turbine(oc4_loads):
    """OpenFAST 5.0 reference run, 11 m/s steady wind: 1026.3 kN, 75 017 kN m, fairlead tensions, motions; 1.5 %."""
    item = oc4_loads["operating"]
    mean = dict(zip(item.channels.names, item.channels.mean, strict=True))
    reference = {
        "PtfmSurge": 8.2782, "PtfmHeave": -0.0380, "PtfmPitch": np.radians(3.3121), "TTDspFA": 0.39216, "TwrBsFxt": 1026.3e3,
        "TwrBsMyt": 75_017e3, "T[1]": 939.73e3, "T[2]": 1616.0e3, "T[3]": 942.11e3,
    }  # fmt: skip
    for name, value in reference.items():
        assert mean[name] == pytest.approx(value, rel=0.015), name


def test_the_tower_base_carries_what_the_platform_needs(oc4, point):
    """Newton's law of the platform: what moorings, water and inertia lack is what the tower gives, at every frequency.

    The tower's side comes from the turbine's matrices, the platform's from all others; in fixed axes about the origin.
    """
    sea = SeaState(kind="jonswap", significant_height=4.0, peak_period=9.0, heading=0.6)
    omega = np.linspace(0.1, 2.0, 25)
    response = solve(point.system, point.mean, excitation(omega, sea, None), drag="none")
    channels = channel_response(point.outputs, response)
    motions = response.to_wave[0]
    turbine = point.system.parts[0]
    assert "turbine" in turbine.name
    own = turbine.stiffness - omega[:, None, None] ** 2 * turbine.mass + 1j * omega[:, None, None] * turbine.damping
    rest = np.einsum("nij,nj->ni", response.dynamic_stiffness - own, motions)
    from model.system.hydro import excitation_at

    gap = rest[:, :6] - excitation_at(point.system.hydro, omega, np.array([0.6]))[0]
    weight = MASS * G
    shear = gap[:, 0] + weight * motions[:, 4]
    moment = gap[:, 4] - BASE * shear
    side = gap[:, 1] - weight * motions[:, 3]
    roll = gap[:, 3] + BASE * side
    for name, value in (("TwrBsFxt", shear), ("TwrBsMyt", moment), ("TwrBsFyt", side), ("TwrBsMxt", roll)):
        found = channels.to_wave[0, :, channels.index(name)]
        # the weight is that of the reference; the rest is rounding
        assert np.abs(found - value).max() < 1e-4 * np.abs(value).max(), name


def test_nacelle_acceleration(point):
    """OpenFAST's xs is along the shaft, downwind and 5 degrees down; the accelerometer is at (-3.09528, 0, 87.6 + 2.23336) m."""
    rate = row(point, "NcIMUTAxs", "acceleration")
    c, s, x, z = np.cos(np.radians(5)), np.sin(np.radians(5)), -3.09528, 87.6 + 2.23336
    assert np.allclose(rate[:6], [c, 0, -s, 0, c * z + s * x, 0])
    assert 1.0 < rate[6] / c < 1.1  # the tower mode's unit is the top's; the accelerometer is above it
    assert not row(point, "NcIMUTAxs").any()  # gravity is not sensed
    assert np.allclose(row(point, "NcIMUTAys", "acceleration")[:6], [0, 1, 0, -z, 0, x])


def test_tension_gradients_by_differences(oc4, point):
    """Tension of each line by central differences of the exact mooring, 1 cm and 1e-4 rad."""
    mean = point.mean.offset
    for k, h in enumerate((0.01, 0.01, 0.01, 1e-4, 1e-4, 1e-4)):
        step = np.zeros(6)
        step[k] = h
        low, high = (mooring_state(oc4.deck.mooring, mean[:6] + s * step).fairlead_tension for s in (-1, 1))
        for line in range(3):
            # the catenary's third derivative over 1 cm: 1e-4 of the largest gradient
            assert row(point, f"T[{line + 1}]")[k] == pytest.approx(
                (high - low)[line] / (2 * h), rel=1e-3, abs=5.0 * (1 if k < 3 else 40)
            )


def test_acceleration_channel_is_the_second_derivative(point):
    omega = np.array([0.3, 1.1])
    response = solve(point.system, point.mean, excitation(omega, SeaState(kind="still"), None), drag="none")
    channels = channel_response(point.outputs, response)
    motion = row(point, "NcIMUTAxs", "acceleration") @ response.to_wave[0].T
    assert np.allclose(channels.to_wave[0, :, channels.index("NcIMUTAxs")], -(omega**2) * motion)


def test_wind_acts_on_the_section_directly(oc4):
    """At zero frequency in effect (1e-4 rad/s) a gust on a held turbine is carried by the tower base: thrust and its moment.

    With every motion stiff, dFx/du = wind force, and the moment is taken about the base.
    """
    point = oc4.at(11.0)
    stiff = replace(point.mean, stiffness=point.mean.stiffness + 1e16 * np.eye(7))
    omega = np.array([1e-4, 2e-4])
    response = solve(point.system, stiff, excitation(omega, SeaState(kind="still"), None), drag="none")
    channels = channel_response(linear_outputs(point.system, point.mean, oc4.deck.elastodyn.structure), response)
    force = point.turbine.wind_force
    assert channels.to_wind[0, channels.index("TwrBsFxt")] == pytest.approx(force[0], rel=1e-3)
    assert channels.to_wind[0, channels.index("TwrBsMyt")] == pytest.approx(force[4] - BASE * force[0], rel=1e-3)


def test_spectra_of_waves_and_wind_add(oc4, oc4_loads):
    """Uncorrelated causes: the spectrum with both is the sum of the two alone about the same linear model, drag's incoherent part once."""
    item = oc4_loads["operating"]
    drive = item.response.excitation
    zero = np.zeros_like(drive.omega)
    calm = replace(drive, wind_spectrum=zero, gradient_spectrum=zero)
    still = replace(drive, wave_spectrum=np.zeros_like(drive.wave_spectrum))
    parts = [response_spectra(item.channels, replace(item.response, excitation=d)) for d in (calm, still)]
    assert np.allclose(sum(parts) - item.channels.incoherent, item.spectra, rtol=1e-12)
    assert np.all(item.spectra >= 0)
    expected = np.abs(item.channels.to_wave[0]) ** 2 * drive.wave_spectrum[0][:, None]
    assert np.allclose(parts[0], expected + item.channels.incoherent)


def test_channels_follow_the_degrees_of_freedom(oc4, point):
    """A rigid tower has no deflection channel; without structure there are no tower loads; an unknown channel is named."""
    assert "TTDspFA" in point.outputs.names
    bare = linear_outputs(point.system, point.mean, None)
    assert not any(n.startswith(("TwrBs", "NcIMU")) for n in bare.names)
    response = solve(
        point.system, point.mean, excitation(np.array([0.3, 0.4]), SeaState(kind="still"), None), drag="none"
    )
    with pytest.raises(KeyError, match="no channel TwrBsFzt; there are PtfmSurge"):
        channel_response(bare, response).index("TwrBsFzt")
