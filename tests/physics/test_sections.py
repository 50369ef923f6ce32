"""Tower sections, modal loads, anchor tensions, relative elevation, histories: statics by hand and limits."""

import numpy as np
import pytest

from model.response.histories import along_record, synthesise
from model.response.loads import channel_response, response_spectra
from model.response.sections import ExtraOutputs, with_extras
from model.response.statistics import statistics


def extended(model, point, **wanted):
    return with_extras(point.outputs, point.system, point.mean, model.deck.elastodyn.structure, ExtraOutputs(**wanted))


def test_the_section_at_the_base_is_the_base(oc4):
    point = oc4.at(11.0)
    outputs = extended(oc4, point, tower_sections=(10.0,))
    for name, base in (("TwrFx@10m", "TwrBsFxt"), ("TwrMy@10m", "TwrBsMyt")):
        i, j = outputs.names.index(name), outputs.names.index(base)
        for field in ("position", "velocity", "acceleration", "wind", "mean"):
            np.testing.assert_allclose(getattr(outputs, field)[i], getattr(outputs, field)[j], rtol=1e-9, atol=1e-6)


def test_just_below_the_top_only_the_head_is_left(oc4):
    """Shear from surge acceleration tends to the mass of rotor and nacelle, 349 390 kg for the blades' nodes of this deck.

    At 1 mm below the top no tower is left above; the head's mass is that of `rotor_nacelle`, tested on its own.
    """
    from model.system.turbine import rotor_nacelle

    structure = oc4.deck.elastodyn.structure
    outputs = extended(oc4, oc4.at(0.0), tower_sections=(87.599,))
    k = outputs.names.index("TwrFx@87.599m")
    head = rotor_nacelle(structure)
    assert -outputs.acceleration[k, 0] == pytest.approx(head.mass, rel=1e-3)  # tower mass from its 20 nodes against the .lin's
    assert outputs.position[k, 4] == pytest.approx(head.mass * structure.gravity, rel=1e-3)  # weight along the tilted section


def test_sections_join_up_with_equilibrium(oc4):
    """dM/dz = -S + weight terms: between close sections the moment falls by shear times distance in the static limit.

    For a unit surge acceleration the moment's slope is the shear: M(z) - M(z + dz) = S dz + inertia of the slice (second order).
    """
    dz = 0.1
    outputs = extended(oc4, oc4.at(0.0), tower_sections=(40.0, 40.0 + dz))
    m0, m1, s0 = (outputs.acceleration[outputs.names.index(n), 0] for n in ("TwrMy@40m", f"TwrMy@{40 + dz:g}m", "TwrFx@40m"))
    assert m0 - m1 == pytest.approx(s0 * dz, rel=1e-3)


def test_section_outside_the_tower_is_refused(oc4):
    with pytest.raises(ValueError, match=r"outside the tower \(10 to 87.6 m\)"):
        extended(oc4, oc4.at(0.0), tower_sections=(9.0,))


def test_modal_loads_are_the_stiffness_alone(oc4):
    point = oc4.at(0.0)
    outputs = extended(oc4, point, modal_tower_loads=True)
    k = outputs.names.index("TwrBsMyt modal")
    stiffness = point.system.stiffness[6, 6]
    np.testing.assert_allclose(outputs.position[k], np.r_[np.zeros(6), stiffness * 77.6], rtol=1e-12)


def test_anchor_tension_is_the_moorings(oc4):
    point = oc4.at(11.0)
    outputs = extended(oc4, point, anchor_tensions=True)
    for line in range(3):
        k = outputs.names.index(f"T_a[{line + 1}]")
        assert outputs.mean[k] == point.mean.mooring.anchor_tension[line]
        np.testing.assert_array_equal(outputs.position[k, :6], point.mean.mooring.anchor_tension_gradient[line])


def test_relative_elevation_in_long_and_short_waves(oc4, oc4_loads):
    """In waves much longer than the floater it heaves with them (relative elevation small); in short ones it stays, and the wave is left."""
    item = oc4_loads["white_noise"]
    point = (0.0, 0.0, 10.0)
    outputs = extended(oc4, item.point, air_gap_points=(point,))
    channels = channel_response(outputs, item.response)
    size = np.abs(channels.to_wave[0][:, outputs.names.index("RelElev1")])
    omega = item.response.excitation.omega
    assert size[np.argmin(np.abs(omega - 0.08))] < 0.1  # heave RAO is 0.97 there
    assert size[np.argmin(np.abs(omega - 3.0))] == pytest.approx(1.0, abs=0.02)  # the floater moves less than 1 % of the wave


def test_synthesised_histories_have_the_spectra(oc4, oc4_loads):
    """Variance is the sum of the lines' squares; waves, wind and gradients on one line add with random phases, and the surge peak
    has some 30 lines in four hours, so a standard deviation scatters by 0.5 / sqrt(30) = 9 %; three quarters of that are allowed.
    """
    item = oc4_loads["operating"]
    history = synthesise(item.channels, item.response, 4 * 3600.0, 0.5, seed=4)
    moving = item.statistics.std > 1e-3 * item.statistics.std.max()
    np.testing.assert_allclose(history.data.std(axis=0)[moving], item.statistics.std[moving], rtol=0.07)
    np.testing.assert_allclose(history.data.mean(axis=0)[moving], item.channels.mean[moving], rtol=1e-6, atol=1e-6)
    assert history.elevation.std() == pytest.approx(0.5, rel=0.01)  # Hs 2 m
    again = synthesise(item.channels, item.response, 4 * 3600.0, 0.5, seed=4)
    np.testing.assert_array_equal(again.data, history.data)


def test_a_record_of_one_wave_gives_amplitude_and_phase_of_the_rao(oc4_loads):
    item = oc4_loads["white_noise"]
    count, step, line = 4096, 0.25, 100
    omega = 2 * np.pi * line / (count * step)
    time = np.arange(count) * step
    history = along_record(item.channels, item.response, 2.0 * np.cos(omega * time), step, ["PtfmHeave"])
    grid = item.response.excitation.omega
    rao = item.channels.to_wave[0][:, item.channels.index("PtfmHeave")]
    at = np.interp(omega, grid, rao.real) + 1j * np.interp(omega, grid, rao.imag)
    expected = (2.0 * at * np.exp(1j * omega * time)).real + item.channels.mean[item.channels.index("PtfmHeave")]
    np.testing.assert_allclose(history.data[:, 0], expected, atol=1e-10)


def test_spectra_of_extras_are_those_of_the_channels(oc4, oc4_loads):
    """Adding channels changes none of the standard ones."""
    item = oc4_loads["operating"]
    outputs = extended(oc4, item.point, tower_sections=(30.0,), air_gap_points=((1.0, 2.0, 3.0),), anchor_tensions=True)
    channels = channel_response(outputs, item.response)
    std = statistics(response_spectra(channels, item.response), item.response.excitation.omega, channels.mean).std
    np.testing.assert_allclose(std[: len(item.statistics.std)], item.statistics.std, rtol=1e-12)
