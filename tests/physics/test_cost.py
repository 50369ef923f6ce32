"""Cost: the thesis's designs, hand calculations, properties.

The thesis does not say how thick walls are or which chain Tuscany has. With its prices and dimensions, what reproduces
both its costs and its mean offsets is: side columns and heave plates of 33 mm (60 mm, the 0.06 m of OC4, in the
upscaled hull), main column 30 mm, braces 17.5 mm (both OC4), concrete ballast to the draft, fairleads at the heave
plates' edge, and a studless chain of 230 kg/m (0.1075 m).
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from model.design.anchors import SpreadLine, drag_anchor, spread_under_thrust, suction_pile
from model.design.cost import (
    PlateLayout,
    Plating,
    Prices,
    Semisubmersible,
    ballast_mass,
    cost_items,
    displaced_volume,
    hull_plating,
    total_cost,
    weld_times,
)

THRUST = 1656.90e3  # thesis Table 27, 11 m/s
TURBINE = 1.305e6  # kg: DTU 10 MW, rotor and nacelle 677 t, tower 628 t
CHAIN = {"mass": 230.0, "stiffness": 90e9 * 230 / 19.9e3}  # studless: 19.9e3 d^2 kg/m, 0.9e11 d^2 N (Orcina, R4)
WIRE = {"mass": 76.5, "stiffness": 1353e6}  # thesis Table 22
UPSCALED = {
    "column_diameter": 16.97,
    "radius": 28.87 * np.sqrt(2),
    "draft": 28.30,
    "main_freeboard": 14.14,
    "column_freeboard": 16.97,
    "plate_height": 8.48,
    "plate_diameter": 33.94,
    "column_wall": 0.060,
}
# thesis Tables 32 and 36: d, r, draft, anchor radius, line length, mean surge, cost
TUSCANY = {
    1: (14, 44.5, 24.5, 730, 730, 24.30, 4.660e6),
    3: (15, 44.5, 20.5, 780, 780, 25.10, 4.778e6),
    7: (14.5, 45, 23, 850, 850, 25.93, 4.882e6),
    15: (14, 44.5, 25, 720, 715, 20.56, 4.690e6),
    16: (15, 45, 24, 790, 785, 21.28, 5.082e6),
    26: (15, 44.5, 20.5, 780, 775, 21.16, 4.783e6),
    30: (14.5, 45, 23.5, 860, 860, 26.18, 4.934e6),
}
SARDINIA = {
    1: (14, 44.5, 24.5, 810, 855, 24.57, 4.193e6),
    5: (15, 44.5, 20.5, 850, 895, 28.01, 4.263e6),
    9: (14.5, 45, 23, 910, 950, 28.40, 4.311e6),
    11: (14, 41.5, 21.5, 860, 915, 36.08, 3.953e6),
    12: (14, 42.5, 24.5, 830, 875, 24.32, 4.186e6),
    27: (15.5, 44.5, 21, 850, 900, 33.71, 4.490e6),
    37: (15, 44.5, 20.5, 840, 885, 27.22, 4.260e6),
    41: (14.5, 45, 24.5, 820, 860, 22.13, 4.396e6),
}
FIRST = {
    "tuscany": (20, 45, 31.5, 840, 825, 19.87, 8.42e6),
    "sardinia": (20, 45, 32, 800, 840, 28.94, 7.8794e6),
}  # Tables 31 and 35


def design(site, dimensions, anchor_radius, length):
    """Return the account and the mean offset of a hull with three lines at a site."""
    hull = Semisubmersible(**dimensions)
    line, depth, kind = (CHAIN, 200.0, "chain") if site == "tuscany" else (WIRE, 370.0, "wire")
    submerged = 1 - 1025 / 7850 if kind == "chain" else 0.85
    spread = spread_under_thrust(
        SpreadLine(
            count=3,
            anchor_radius=anchor_radius,
            fairlead_radius=hull.fairlead_radius,
            fairlead_height=depth - hull.fairlead_depth,
            length=length,
            weight=line["mass"] * submerged * 9.80665,
            stiffness=line["stiffness"],
        ),
        THRUST,
    )
    make = drag_anchor if site == "tuscany" else suction_pile
    anchor = make(spread.horizontal, spread.uplift)
    plating = hull_plating(hull)
    carried = (
        sum(p.mass for p in plating) + TURBINE + 3 * line["mass"] * submerged * 0.15 * length
    )  # the part of lines that hangs
    items = cost_items(
        plating,
        ballast_mass(displaced_volume(hull), carried),
        3 * length * line["mass"],
        3 * anchor.mass,
        line=kind,
        anchor=anchor.kind,
    )
    return items, spread.offset


def row(site, d, r, draft, anchor_radius, length, *_):
    return design(site, {"column_diameter": d, "radius": r, "draft": draft}, anchor_radius, length)


@pytest.mark.parametrize(("site", "table"), [("tuscany", TUSCANY), ("sardinia", SARDINIA)])
def test_the_second_stage_designs_cost_what_the_thesis_says(site, table):
    for values in table.values():
        items, offset = row(site, *values)
        assert total_cost(items) == pytest.approx(values[-1], rel=0.10)  # the project's own target for open assumptions
        # mean surge of the thesis, at its thrust; it adds pitch and its own wire's weight, which are left out here
        assert offset == pytest.approx(values[-2], rel=0.10 if site == "tuscany" else 0.15)


def test_the_designs_of_table_32_come_in_its_order():
    order = sorted(TUSCANY, key=lambda k: total_cost(row("tuscany", *TUSCANY[k])[0]))
    # designs 3 and 26 are one hull, with lines of 780 and 775 m: the shorter chain saves less than its larger anchor
    # costs
    assert order == sorted(TUSCANY, key=lambda k: TUSCANY[k][-1])


@pytest.mark.parametrize(
    ("site", "anchor_radius", "length", "cost", "share"),
    [("tuscany", 846.0, 840.0, 8.59e6, 0.98), ("sardinia", 1180.0, 1205.0, 8.15e6, 0.9673)],
)
def test_the_upscaled_hull_and_the_first_stage(site, anchor_radius, length, cost, share):
    upscaled, _ = design(site, UPSCALED, anchor_radius, length)
    first, _ = row(site, *FIRST[site])
    assert total_cost(upscaled) == pytest.approx(cost, rel=0.10)
    assert total_cost(first) == pytest.approx(FIRST[site][-1], rel=0.10)
    assert total_cost(first) / total_cost(upscaled) == pytest.approx(share, abs=0.05)


def test_the_upscaled_hull_weighs_what_the_thesis_says():
    # Table 8: 3.846e7 kg with ballast
    hull = Semisubmersible(**UPSCALED)
    platform = 1025 * displaced_volume(hull) - TURBINE - 0.5e6  # turbine and the lines' pull
    assert platform == pytest.approx(3.846e7, rel=0.03)  # braces of the thesis are not itemised


def test_one_plate_by_hand():
    """40 m2 of 20 mm: one raw plate of 6280 kg; 14 m of weld 20 mm wide."""
    plate = Plating(name="test", area=40.0, thickness=0.020)
    assert plate.mass == pytest.approx(6280.0)
    times = weld_times([plate])
    assert times.preparation == pytest.approx(np.sqrt(6280.0))
    assert times.welding == pytest.approx(0.1053 * 20**1.94 * 14)
    assert times.hours == pytest.approx((times.preparation + 1.3 * times.welding) / 60)
    items = {i.name: i.cost for i in cost_items([plate], 1000.0, 2000.0, 3000.0, line="wire", anchor="suction pile")}
    assert items["Steel of the hull"] == pytest.approx(3140.0)
    assert items["Concrete ballast"] == pytest.approx(100.0)
    assert items["Mooring lines (wire)"] == pytest.approx(3200.0)
    assert items["Anchors (suction pile)"] == pytest.approx(30750.0)
    assert items["Paint"] == pytest.approx(500.0)
    assert items["Welding"] == pytest.approx(17.05 * times.hours)


def test_the_surfaces_of_a_hull_by_hand():
    """Two columns of 10 m on plates of 20 m by 5 m, 20 m deep, 10 m of freeboard."""
    hull = Semisubmersible(
        column_diameter=10,
        radius=30,
        draft=20,
        columns=2,
        column_freeboard=10,
        plate_height=5,
        main_diameter=6,
        main_freeboard=8,
    )
    areas = {p.name: p.area for p in hull_plating(hull)}
    assert areas["Side columns"] == pytest.approx(2 * (np.pi * 10 * 25 + np.pi * 25))
    assert areas["Heave plates"] == pytest.approx(2 * (np.pi * 20 * 5 + np.pi * 100 + np.pi * 75))
    assert areas["Main column"] == pytest.approx(np.pi * 6 * 28 + 2 * np.pi * 9)
    braces = np.pi / 4 * 1.6**2 * hull.brace_length / 2
    assert displaced_volume(hull) == pytest.approx(2 * (np.pi * 100 * 5 + np.pi * 25 * 15) + np.pi * 9 * 20 + braces)
    assert hull.fairlead_radius == 40
    assert hull.fairlead_depth == 15


@given(st.floats(14, 20), st.floats(35, 45), st.floats(20, 32), st.floats(1.01, 1.5))
def test_more_of_anything_costs_more(d, r, draft, factor):
    def cost(**change):
        values = {"column_diameter": d, "radius": r, "draft": draft} | change
        return total_cost(cost_items(hull_plating(Semisubmersible(**values)), 1e7, 1e6, 1e4))

    assert cost(column_wall=0.033 * factor) > cost()
    assert cost(draft=draft * factor) > cost()
    assert cost(radius=r * factor) > cost()


def test_prices_and_layout_are_inputs():
    plating = [Plating(name="test", area=400.0, thickness=0.020)]
    base = total_cost(cost_items(plating, 0.0, 0.0, 0.0))
    steel = total_cost(cost_items(plating, 0.0, 0.0, 0.0, prices=Prices(steel=1.0)))
    assert steel - base == pytest.approx(0.5 * 7850 * 8)
    assert weld_times(plating, PlateLayout(length=20, width=8)).welding == pytest.approx(
        weld_times(plating).welding / 2
    )


def test_what_cannot_be_built_is_refused():
    with pytest.raises(ValueError, match="radius is -1"):
        Semisubmersible(column_diameter=14, radius=-1, draft=20)
    with pytest.raises(ValueError, match="do not fit a draft"):
        Semisubmersible(column_diameter=14, radius=40, draft=5)
    with pytest.raises(ValueError, match="overlap at a radius of 15"):
        Semisubmersible(column_diameter=14, radius=15, draft=20)
    with pytest.raises(ValueError, match="narrower than their columns"):
        Semisubmersible(column_diameter=14, radius=40, draft=20, plate_diameter=10)
    with pytest.raises(ValueError, match="do not float"):
        ballast_mass(1000.0, 2e6)
    with pytest.raises(ValueError, match="chain, wire"):
        cost_items([], 0, 0, 0, line="rope")
    with pytest.raises(ValueError, match="drag, suction pile"):
        cost_items([], 0, 0, 0, anchor="hope")
