"""Modelling choices side by side: what the tables hold, and that the validation report shows them."""

import pytest

from fowtio.comparisons import DragComparison, TowerComparison, choices_section, compare_tower_loads
from fowtio.write.validation import report


@pytest.fixture(scope="module")
def section():
    drag = DragComparison(
        channel="PtfmHeave", frequency=0.0582, whole={"third_order": 0.014, "relative": 0.025, "body": 0.059, "global": 0.0594},
        resonance={"third_order": 0.018, "relative": 0.033, "body": 0.077, "global": 0.0771},
    )  # fmt: skip
    tower = TowerComparison(state="sea", channel="TwrBsMyt", band=(0.1, 0.2), full=0.036, modal=0.0777, full_way=0.008, modal_way=0.046, share=0.77)
    return choices_section((drag,), (tower,))


def test_report_shows_every_drag_model_and_both_ways_to_the_tower_loads(section, oc4, oc4_validation):
    page = report(oc4, (oc4_validation,), extra_sections=(section,))
    assert "Modelling choices side by side" in page
    for text in ("third_order, whole band", "relative, at resonance", "body, whole band", "global, at resonance", "Modal stiffness", "7.8"):
        assert text in page, text


def test_integrated_loads_are_the_better_way_in_every_band_of_white_noise(oc4, oc4_validation):
    """Six seeds of OpenFAST: the way from the tower's deflection to the loads, band by band, energy-bearing ones (1 % and more)."""
    rows = [r for r in compare_tower_loads(oc4, oc4_validation) if r.share > 0.01]
    assert {r.channel for r in rows} == {"TwrBsFxt", "TwrBsMyt"}
    for row in rows:
        assert row.full_way < row.modal_way, row
        assert row.full < row.modal, row


def test_nothing_to_compare_is_no_section():
    assert choices_section((), ()) is None
