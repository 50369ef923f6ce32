"""The flexible rotor of the embedded linearisation: whirling pairs, and the model with it condensed."""

from dataclasses import replace

import numpy as np
import pytest

import fowtio
from fowtio.kept_dofs import compare_kept, kept_section, whirling
from model.conventions import PLATFORM_DOFS


@pytest.fixture(scope="module")
def case(oc4_folder):
    return fowtio.load(oc4_folder / "oc4_flexible.fowt")


@pytest.fixture(scope="module")
def flexible(case):
    return fowtio.build(case)


@pytest.fixture(scope="module")
def results(flexible):
    return fowtio.loads(fowtio.solve(flexible))


def test_whirling_modes_of_a_real_linearisation_lie_two_rotor_speeds_apart(flexible):
    # a blade mode at w0 is w0 - Omega and w0 + Omega in the fixed frame; tower, drivetrain and air couple the three blade modes of
    # this rotor, which moves their distance by up to 2 % (flap, half of critical damping), so 3 %
    pairs = {p.name: p for p in whirling(flexible.points)}
    assert set(pairs) == {"flap1", "flap2", "edge1"}
    for pair in pairs.values():
        assert pair.rotor_speed == pytest.approx(11.89 / 60, rel=1e-3)  # the deck's 11.89 rpm
        assert pair.half_distance == pytest.approx(pair.rotor_speed, rel=0.03), pair
    # NREL/TP-500-38060, table 9-1: first asymmetric edge modes of the parked rotor at 1.08 Hz, between the two
    edge = pairs["edge1"]
    assert (edge.forward + edge.backward) / 2 == pytest.approx(1.08, rel=0.03)


def test_condensed_model_is_that_of_a_study_with_seven_dofs(case, flexible, results):
    found = compare_kept(flexible, results)
    assert len(found.dropped) == 10
    seven = replace(case, dofs=(*PLATFORM_DOFS, "tower_fa1"))
    own = next(i for i in fowtio.loads(fowtio.solve(fowtio.build(seven))) if i.state.name == found.state)
    expected = [own.statistics.std[own.channels.index(n)] for n in found.names]
    # the two studies have frequency grids of their own, 400 points that integrate to 0.5 %
    np.testing.assert_allclose(found.std_condensed, expected, rtol=0.01)
    assert found.wave_difference[0] < 0.01  # surge hardly feels blades
    assert found.wind_difference[found.names.index("TTDspFA")] > 0.02  # the tower's mode does


def test_a_study_without_flexible_rotor_has_no_such_section(oc4, oc4_loads):
    assert compare_kept(oc4, tuple(oc4_loads.values())) is None
    assert whirling(oc4.points) == ()


def test_run_says_it_by_itself(flexible, results):
    section = kept_section(compare_kept(flexible, results), whirling(flexible.points))
    assert [t.name for t in section.content[:2]] == ["kept_dofs", "whirl"]
    assert "<svg" in section.content[2].svg
