"""Anchors: published piles and curves, inversion, and what a drag anchor cannot hold."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from model.design.anchors import (
    DRAG_SOILS,
    PILE_SOILS,
    SpreadLine,
    drag_anchor,
    drag_capacity,
    pile_capacity,
    spread_under_thrust,
    suction_pile,
)
from model.system.catenary import catenary


@pytest.mark.parametrize(
    ("length", "diameter"), [(12.319, 2.129), (12.059, 2.089), (12.479, 2.154), (12.536, 2.162)]
)  # thesis Table 39
def test_the_piles_of_the_thesis(length, diameter):
    load = pile_capacity(length)
    pile = suction_pile(load, safety=1.0)
    assert pile.length == pytest.approx(length, rel=1e-12)
    assert pile.diameter == pytest.approx(diameter, rel=0.0005)  # printed to a millimetre of two metres
    assert pile.wall == pytest.approx(0.014, abs=0.0005)  # printed to a millimetre


def test_the_capacity_of_the_first_pile():
    # thesis errata 8.2: 12.319 m is 2804 kN, with a wall of 14.2 mm
    assert pile_capacity(12.319) == pytest.approx(2804e3, rel=0.001)
    assert suction_pile(2804e3, safety=1.0).wall == pytest.approx(0.0142, abs=5e-5)


@given(st.floats(1e5, 5e7), st.floats(1.0, 3.0), st.sampled_from(list(DRAG_SOILS)))
def test_drag_anchors_invert_exactly(load, safety, soil):
    anchor = drag_anchor(load, 0.0, soil, safety)
    assert drag_capacity(anchor.mass, soil) == pytest.approx(safety * load, rel=1e-12)
    assert anchor.capacity == pytest.approx(safety * load, rel=1e-12)


def test_the_drag_anchor_of_the_thesis():
    # errata 8.1 inverted: W [t] = (UHC [kN] / 392.28)^(1/0.92); 1 t holds 392.28 kN
    assert drag_capacity(1000.0) == pytest.approx(392.28e3)
    assert drag_anchor(2000e3).mass == pytest.approx(1e3 * (3000 / 392.28) ** (1 / 0.92))


def test_a_drag_anchor_refuses_uplift_and_a_pile_takes_it():
    with pytest.raises(ValueError, match=r"pulls a drag anchor up with 600\.0 kN"):
        drag_anchor(2000e3, 600e3)
    pile = suction_pile(2000e3, 600e3)
    assert pile.capacity == pytest.approx(1.5 * np.hypot(2000e3, 600e3))
    assert drag_anchor(2000e3, 1e3).kind == "drag"  # rounding of a line that rests on the seabed


def test_the_mass_of_a_pile_is_that_of_its_shell():
    pile = suction_pile(2804e3, safety=1.0)
    shell = 7850 * np.pi / 4 * (pile.diameter**2 - (pile.diameter - 2 * pile.wall) ** 2) * pile.length
    assert pile.mass == pytest.approx(shell)
    lid = 7850 * np.pi / 4 * pile.diameter**2 * pile.wall
    assert suction_pile(2804e3, safety=1.0, lid=True).mass == pytest.approx(shell + lid)


def test_softer_clay_needs_more():
    for load in (1e6, 3e6, 1e7):
        assert suction_pile(load, soil="soft_clay").mass > suction_pile(load, soil="medium_clay").mass
        assert drag_anchor(load, soil="mk6_soft_clay").mass > drag_anchor(load, soil="mk6_sand").mass


def test_problems_are_named():
    with pytest.raises(ValueError, match=", ".join(DRAG_SOILS)):
        drag_anchor(1e6, soil="rock")
    with pytest.raises(ValueError, match=", ".join(PILE_SOILS)):
        suction_pile(1e6, soil="rock")
    with pytest.raises(ValueError, match="load is 0 N"):
        drag_anchor(0.0)


SPREAD = SpreadLine(
    count=3,
    anchor_radius=800.0,
    fairlead_radius=60.0,
    fairlead_height=180.0,
    length=790.0,
    weight=1900.0,
    stiffness=1e9,
)


def test_a_spread_balances_the_thrust():
    """Two lines at 60 degrees from downwind are alike; the three horizontal forces add up to the thrust."""
    thrust = 1.5e6
    state = spread_under_thrust(SPREAD, thrust)
    assert state.offset > 0
    along, across = 740.0 * 0.5 - state.offset, 740.0 * np.sqrt(0.75)
    reach = np.hypot(along, across)
    slack = catenary(reach, 180.0, 790.0, 1900.0, 1e9).horizontal
    pull = catenary(740.0 + state.offset, 180.0, 790.0, 1900.0, 1e9).horizontal
    assert pull - 2 * slack * along / reach == pytest.approx(thrust, rel=1e-5)  # bisected to a micrometre
    assert state.horizontal == pytest.approx(pull, rel=1e-6)
    assert spread_under_thrust(SPREAD, 0.0).offset == pytest.approx(0.0, abs=1e-4)


def test_a_thrust_that_lines_cannot_hold_is_refused():
    with pytest.raises(ValueError, match="cannot hold 50000 kN"):
        spread_under_thrust(SPREAD, 5e7)
