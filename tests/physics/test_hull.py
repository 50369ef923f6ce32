"""The parametric semisubmersible against the published OC4 platform, closed forms and itself."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from model.conventions import rigid_mass
from model.design.hull import (
    OC4,
    SemiHull,
    brace_lines,
    cylinder,
    displaced,
    fairleads,
    float_hull,
    hydrostatic_stiffness,
    platform_body,
    steel_parts,
    three_line_mooring,
    tube_part,
    upscaled,
    waterplane,
    wet_braces,
)
from model.design.hull_drag import drag_members

RNA_AND_TOWER = 599_718.0  # kg, NREL 5 MW on its tower (NREL/TP-500-47535)
OC4_PULL = 1.84e6  # N, the lines' vertical pull at rest (NREL/TP-5000-60601, MAP)
TEN_MW = {"carried_mass": 1.556e6, "carried_height": 83.08}


def oc4_floating():
    return float_hull(OC4, carried_mass=RNA_AND_TOWER, carried_height=70.0, mooring_pull=OC4_PULL)


def test_oc4_displaces_its_published_volume():
    # NREL/TP-5000-60601 gives 13,917 m3; the same joints' overlaps are counted a little differently: 0.05 %
    assert displaced(OC4)[0] == pytest.approx(13_917.0, rel=5e-4)


def test_oc4_hydrostatics_equal_the_wamit_file_in_common_use():
    # marin_semi.hst: C33 380.06 m2, C55 -37,875 m4, braces included; its panels are polygons: 0.2 %
    floating = oc4_floating()
    stiffness = hydrostatic_stiffness(floating) / (1025 * 9.80665)
    assert stiffness[2, 2] == pytest.approx(380.06, rel=2e-3)
    assert stiffness[4, 4] == pytest.approx(-37_875.0, rel=2e-3)


def test_oc4_masses_are_the_published_ones():
    floating = oc4_floating()
    # 13,473 t with ballast: what the water carries less turbine and lines; volume and pull are known to 0.1 %
    assert floating.mass == pytest.approx(13.473e6, rel=2e-3)
    # 3,852 t of steel; bare plates without stiffeners and joints are lighter: 4 %
    assert floating.steel_mass == pytest.approx(3.8522e6, rel=0.04)
    # inertias 6.827e9 and 1.226e10: ours fill the plates first, OC4 part of plates and columns: 5 %
    assert floating.inertia[0] == pytest.approx(6.827e9, rel=0.05)
    assert floating.inertia[2] == pytest.approx(1.226e10, rel=0.05)


def test_brace_lengths_and_fairleads_follow_geometry():
    lengths = {name: float(np.linalg.norm(end - start)) for name, start, end in brace_lines(OC4)}
    published = {  # NREL/TP-5000-60601, lengths of pontoons and braces, to the centimetre
        "lower delta pontoons": 26.0, "upper delta pontoons": 38.0, "lower Y pontoons": 13.62, "upper Y pontoons": 19.62, "cross braces": 32.04,
    }  # fmt: skip
    for name, value in published.items():
        assert lengths[name] == pytest.approx(value, abs=0.02), name
    lead = fairleads(OC4)
    assert np.hypot(lead[:, 0], lead[:, 1]) == pytest.approx(40.868, abs=1e-3)
    assert lead[:, 2] == pytest.approx(-14.0)


def test_upscaling_gives_the_tabulated_10_mw_platform():
    hull = upscaled(OC4, 2.0, central_diameter=8.3)
    # the thesis's table of dimensions, rounded to the centimetre (it prints 8.48 for 8.485)
    assert float(hull.draft) == pytest.approx(28.30, abs=0.02)
    assert float(hull.diameter) == pytest.approx(16.97, abs=0.01)
    assert float(hull.plate_diameter) == pytest.approx(33.94, abs=0.01)
    assert float(hull.plate_height) == pytest.approx(8.48, abs=0.01)
    assert float(hull.central_freeboard) == pytest.approx(14.14, abs=0.01)
    assert float(hull.column_freeboard) == pytest.approx(16.97, abs=0.01)
    assert float(hull.column_freeboard + hull.draft - hull.plate_height) == pytest.approx(36.77, abs=0.01)
    assert float(hull.brace_diameter) == 1.6
    # total mass 3.846e7 kg there; buoyancy less turbine and lines gives 2 % less or, with the turbine, 2 % more:
    # the table does not say what its total counts
    floating = float_hull(replace(hull, ballast_density=np.array(2400.0)), mooring_pull=2.5e6, **TEN_MW)
    assert floating.mass == pytest.approx(3.846e7, rel=0.03)
    # 21.27 m below still water there; concrete at the bottom lies lower, water higher
    water = float_hull(replace(hull, ballast_density=np.array(1025.0)), mooring_pull=2.5e6, **TEN_MW)
    assert floating.centre_of_mass < -21.27 < water.centre_of_mass


@settings(max_examples=60, deadline=None)
@given(st.floats(14, 20), st.floats(30, 45), st.floats(20, 32), st.floats(0, 4e6))
def test_the_draft_is_kept_and_the_stability_is_that_of_the_sum(diameter, radius, draft, pull):
    hull = SemiHull(diameter=diameter, radius=radius, draft=draft)
    f = float_hull(hull, mooring_pull=pull, **TEN_MW)
    weight = 9.80665 * (f.steel_mass + f.ballast_mass + TEN_MW["carried_mass"]) + pull
    assert weight == pytest.approx(1025 * 9.80665 * f.volume, rel=1e-12)  # identity, rounding only
    # rotational stiffness of buoyancy and weights = (mass g) GM, plus what the lines' pull takes: an identity
    weights = -9.80665 * (f.mass * f.centre_of_mass + TEN_MW["carried_mass"] * TEN_MW["carried_height"])
    total = hydrostatic_stiffness(f)[4, 4] + weights
    mass = f.mass + TEN_MW["carried_mass"]
    area, moment = waterplane(hull)
    lever = (moment / f.volume + f.centre_of_buoyancy) * (1025 * f.volume - mass) * 9.80665
    assert total == pytest.approx(mass * 9.80665 * f.metacentric_height + lever, rel=1e-9)
    assert area == pytest.approx(hydrostatic_stiffness(f)[2, 2] / (1025 * 9.80665))


def test_cylinders_and_tubes_have_the_moments_of_bodies():
    part = cylinder(1000.0, 2.0, -5.0, 3.0, 10.0, 3)
    one = 1000 * np.pi * 4 * 8
    inertia = np.diag([one * (3 * 4 + 64) / 12] * 2 + [one * 4 / 2])
    places = [10 * np.array([np.cos(a), np.sin(a), -0.1]) for a in np.pi + np.array([0, 2, 4]) * np.pi / 3]
    whole = sum(rigid_mass(one, p, inertia) for p in places)
    assert part.mass == pytest.approx(whole[0, 0])
    assert part.horizontal == pytest.approx(whole[3, 3])
    assert part.horizontal == pytest.approx(whole[4, 4])
    assert part.vertical == pytest.approx(whole[5, 5])
    start, end = np.array([3.0, 1.0, -7.0]), np.array([9.0, 4.0, 2.0])
    tube = tube_part(7850.0, 0.8, 0.0175, start, end)
    axis = (end - start) / np.linalg.norm(end - start)
    right = np.cross(axis, [0, 0, 1.0])
    right /= np.linalg.norm(right)
    up = np.cross(axis, right)
    angle = (np.arange(40) + 0.5) * np.pi / 20
    ring = np.sqrt((0.8**2 + 0.7825**2) / 2) * (np.cos(angle)[:, None] * right + np.sin(angle)[:, None] * up)
    share = (np.arange(400) + 0.5)[:, None, None] / 400
    points = (start + share * (end - start) + ring).reshape(-1, 3)
    point_mass = tube.mass / 3 / len(points)
    # 400 slices of a line 11 m long: the midpoint rule is good to 1e-6
    assert tube.vertical == pytest.approx(3 * point_mass * np.sum(points[:, :2] ** 2), rel=1e-5)
    both = point_mass * np.array(
        [np.sum(points[:, 1] ** 2 + points[:, 2] ** 2), np.sum(points[:, 0] ** 2 + points[:, 2] ** 2)]
    )
    assert tube.horizontal == pytest.approx(3 * both.mean(), rel=1e-5)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"radius": 15.0}, "overlap"),
        ({"radius": 17.5, "plate_ratio": 2.0}, "central column"),
        ({"draft": 5.0}, "heave plates' height"),
        ({"column_wall": 0.9}, "displaced water"),
        (
            {"radius": 30.0, "diameter": 6.0, "plate_ratio": 1.5, "ballast_density": 9000.0},
            "metacentric height|displaced water",
        ),
        ({"ballast_density": 200.0}, "does not fit"),
    ],
)
def test_what_cannot_float_upright_is_refused_with_the_reason(change, reason):
    values = {"diameter": 14.0, "radius": 35.0, "draft": 24.0} | change
    with pytest.raises(ValueError, match=reason):
        float_hull(SemiHull(**values), **TEN_MW)


def test_many_designs_at_once_equal_one_by_one():
    d, r, t = np.array([14.0, 17.0, 20.0]), np.array([30.0, 12.0, 45.0]), np.array([20.0, 26.0, 32.0])
    many = float_hull(SemiHull(diameter=d, radius=r, draft=t), **TEN_MW)
    assert many.possible.tolist() == [True, False, True]
    for k in (0, 2):
        one = float_hull(SemiHull(diameter=d[k], radius=r[k], draft=t[k]), **TEN_MW)
        assert many.mass[k] == pytest.approx(one.mass, rel=1e-14)
        assert many.inertia[k] == pytest.approx(one.inertia, rel=1e-14)
        assert many.metacentric_height[k] == pytest.approx(one.metacentric_height, rel=1e-12)


def test_drag_members_equal_the_members_of_the_oc4_deck(oc4):
    # the deck of the embedded case has the same coefficients and wet lengths, cut into other strips
    ours, deck = drag_members(OC4), oc4.points[0].system.drag
    for axial in (0.0, 1.0):
        mine, theirs = (m.factor[m.axial == axial].sum() for m in (ours, deck))
        assert mine == pytest.approx(theirs, rel=5e-3)  # OC4's braces start 0.05 m elsewhere
    first = [np.sum(m.factor * m.position[:, 2] * (m.axial == 0)) for m in (ours, deck)]
    assert first[0] == pytest.approx(first[1], rel=5e-3)


def test_steel_and_lines_are_where_they_belong():
    assert {p.name for p in steel_parts(OC4)} >= {"offset columns", "cross braces", "heave plate bottoms"}
    assert all(end[2] <= 1e-12 for _, _, end in wet_braces(OC4))
    lines = three_line_mooring(
        OC4,
        anchor_radius=837.6,
        length=835.35,
        mass_per_length=113.35,
        diameter=0.0766,
        axial_stiffness=7.536e8,
        depth=200.0,
    )
    from model.system.mooring import mooring_state

    state = mooring_state(lines, np.zeros(6))
    # NREL/TP-5000-60601: linearised surge stiffness 7.08e4 N/m
    assert state.stiffness[0, 0] == pytest.approx(7.08e4, rel=0.01)
    # OpenFAST v5.0.0 with MAP++ at the equilibrium of the parked turbine (2 mm and 0.08 deg away): 1,107,308 N
    assert state.fairlead_tension == pytest.approx(1.1073e6, rel=2e-3)
    body = platform_body(
        float_hull(OC4, carried_mass=RNA_AND_TOWER, carried_height=70.0, mooring_pull=-float(state.force[2]))
    )
    assert body.centre[2] < -10
