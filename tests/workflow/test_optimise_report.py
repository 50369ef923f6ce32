"""The report of an optimisation: files, tables against the archive, JSON with its units, differences from a publication."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from openpyxl import load_workbook

from fowtio.optimise import tables
from fowtio.optimise.figures import shown_range
from fowtio.optimise.report import (
    assumptions,
    differences,
    optimisation_json,
    sensitivity_statement,
    summary_tables,
    write_optimisation,
)
from fowtio.optimise.run import optimise
from fowtio.optimise.sensitivity import findings_of, slack_of
from fowtio.optimise.study import FrequencyBand, Published, load_optimisation
from model.design.quantities import QUANTITIES, Constraint, split_name
from model.design.space import DIMENSIONS, DesignVariable

COARSE = (FrequencyBand(low=0.004, high=0.4, count=50),)  # the report is under test, not the physics


def small(**changes):
    """The shipped study of Tuscany with few frequencies, two states in a life, small populations and no polish."""
    study = load_optimisation("tuscany")
    sizes = {"ultimate": (16, 2), "pareto": (16, 2), "fatigue": (8, 2)}
    stages = tuple(replace(s, population=sizes[s.name][0], generations=sizes[s.name][1]) for s in study.stages)
    shares = {"u11": 0.5, "u17": 0.5}
    states = tuple(s for s in study.states if s.name in ("rated", *shares))
    limits = tuple(replace(c, factor=0.95) if (c.stage, c.quantity) == ("fatigue", "cost") else c for c in study.constraints)  # few designs: none cheaper
    return replace(study, **{"constraints": limits, "bands": COARSE, "states": states, "shares": shares, "stages": stages, "polish": False} | changes)


@pytest.fixture(scope="module")
def result():
    return optimise(small())


@pytest.fixture(scope="module")
def findings(result):
    return findings_of(result)


@pytest.fixture(scope="module")
def grid_result():
    """One stage, three variables, every design tried, no constraints, nothing published."""
    study = small()
    space = (
        DesignVariable(name="diameter", lower=15.0, upper=16.0, spacing=1.0), DesignVariable(name="radius", lower=42.0, upper=44.0, spacing=1.0),
        DesignVariable(name="draft", lower=24.0, upper=25.0, spacing=1.0),
    )  # fmt: skip
    stage = replace(study.stages[0], name="only", space="three", method="grid", objectives=("pitch_peak:rated",), relative_to=None)
    search = replace(stage, name="search", method="ga", population=6, generations=2)
    return optimise(replace(study, spaces={"three": space}, stages=(search, stage), constraints=(), published=()))


def test_report_workbook_and_figures_appear(result, findings, tmp_path):
    files = write_optimisation(result, tmp_path / "out", findings=findings)
    assert all(f.is_file() and f.stat().st_size > 0 for f in files)
    stems = {f.stem for f in files if f.suffix == ".png"}
    for stage in result.stages:
        assert {f"evolution_{stage}", f"variables_{stage}"} <= stems
    assert {"pareto_pareto", "parallel_pareto", "sensitivity_ultimate", "sensitivity_fatigue", "hulls", "lines", "cost"} <= stems
    text = next(f for f in files if f.suffix == ".html").read_text(encoding="utf-8")
    for sentence in (*differences(result, findings), *assumptions(result)):
        assert sentence.replace("<", "&lt;").replace(">", "&gt;").replace("'", "&#39;") in text
    for stem in stems:
        assert f'id="{stem}"' in text, f"{stem} is drawn but not in the report"
    book = load_workbook(next(f for f in files if f.suffix == ".xlsx"))
    assert book.sheetnames == ["Optima", "Stage ultimate", "Stage pareto", "Stage fatigue", "Sensitivities", "Cost", "Published"]


def test_optimum_table_holds_the_archive(result, findings):
    for name in ("ultimate", "fatigue"):
        stage, table = result.stages[name], tables.optimum_table(result, findings, name)
        rows = {row[0]: row for row in table.rows}
        for k, d in enumerate(DIMENSIONS):
            assert rows[tables.DIMENSION_LABELS[d]][2] == stage.archive.designs[stage.best, k]
        said = tables.labels(stage.archive.names)
        for n in stage.archive.names:
            row = rows[said[n]]
            assert row[2] == stage.archive.value(n, stage.best)
            base = result.reference_values[n]
            assert row[3] == base
            # the same arithmetic on the same numbers: rounding alone
            assert row[4] == pytest.approx(100 * (row[2] - base) / base, rel=1e-9, abs=1e-9)


def test_downhill_stands_beside_the_search(result, findings):
    """With another best design than the search's, both columns show theirs."""
    stage = result.stages["ultimate"]
    other = next(int(r) for r in np.flatnonzero(stage.archive.feasible) if r != stage.best)
    changed = replace(result, study=replace(result.study, polish=True), stages=result.stages | {"ultimate": replace(stage, best=other)})
    table = tables.optimum_table(changed, findings, "ultimate")
    moment = stage.archive.value("tower_moment:rated")
    assert tables.search_gap(changed, "ultimate") == pytest.approx((moment[stage.found] - moment[other]) / moment[other], rel=1e-12)
    row = next(r for r in table.rows if r[0] == "Cost")
    assert row[2] == stage.archive.value("cost", stage.found)
    assert row[3] == stage.archive.value("cost", other)


def test_front_table_holds_front_and_picks(result):
    stage, base = result.stages["pareto"], result.stages["ultimate"]
    whole, picked = (tables.front_table(result, "pareto", picked=p) for p in (False, True))
    assert (len(whole.rows), len(picked.rows)) == (len(stage.front), len(stage.picks))
    costs = stage.archive.value("cost", stage.front)
    assert whole.column("Cost") == costs.tolist()
    assert np.allclose(whole.column("f2"), costs / base.archive.value("cost", base.best), rtol=1e-12)  # one division


def test_margin_and_failures_count(result, findings):
    assert tables.margin(Constraint(quantity="cost", relation="<=", limit=8.0), 6.0) == 25.0
    assert tables.margin(Constraint(quantity="cost", relation=">=", limit=8.0), 6.0) == -25.0
    for stage in result.stages.values():
        table = tables.failure_table(stage)
        assert sum(table.column("Designs")) == len(stage.archive.violation)
        assert table.column("Designs")[0] == (stage.archive.violation == 0).sum()


def test_two_bounds_on_one_quantity_are_counted_apart(result):
    """The stage of fatigue bounds the cost twice; designs that fail at the tighter bound are not counted at the other."""
    stage = result.stages["fatigue"]
    archive = stage.archive
    limits = [c for c in stage.constraints if c.quantity == "cost"]
    loose, tight = sorted(limits, key=lambda c: -c.limit)
    reasons = [loose.reason(loose.limit + 1), tight.reason(tight.limit + 0.1), tight.reason(tight.limit + 0.2)]
    kept, archive.reason = archive.reason, reasons + [""] * (len(archive.reason) - 3)
    try:
        counted = dict(zip(*(tables.failure_table(stage).column(c) for c in ("Outcome", "Designs")), strict=True))
    finally:
        archive.reason = kept
    assert counted[f"breaks {tables.bound(loose)}"] == 1
    assert counted[f"breaks {tables.bound(tight)}"] == 2


def test_published_differences(result, findings):
    """Differences are those of our values from the printed ones; relative values use the base they say."""
    first = next(f for f in findings.published if f.published.name == "first")
    one = next(f for f in findings.published if f.published.name == "1")
    rows = [r for r in tables.published_table(findings).rows if r[0] == "1" and r[2] == "Cost"]
    assert len(rows) == 1
    _, _, _, _, here, printed, difference = rows[0]
    assert (here, printed) == (one.values["cost"], 4.660)
    assert difference == pytest.approx(100 * (here / 4.660 - 1), rel=1e-9)  # rounding alone
    ours, same, as_printed = tables.relative_of(result, findings, one, "cost")
    base = result.stages["ultimate"]
    assert ours == pytest.approx(one.values["cost"] / base.archive.value("cost", base.best), rel=1e-12)
    assert same == pytest.approx(one.values["cost"] / first.values["cost"], rel=1e-12)
    # table 32 of the source thesis prints 0.553 for this design: three digits of 4.660 / 8.420
    assert as_printed == pytest.approx(0.553, abs=6e-4)


def test_published_designs_are_the_very_same_designs(result, findings):
    """The published design of the third stage as a pick of the archive's judge has the values of the table."""
    third = findings.published[-1]
    found = result.stages["fatigue"].archive.evaluate(third.published.design[None])
    assert third.values["cost"] == pytest.approx(found.values[0, found.names.index("cost")], rel=1e-12)  # the same computation


def test_sensitivity_moves_one_variable_alone(result, findings):
    stage = result.stages["ultimate"]
    for s in findings.sensitivities["ultimate"]:
        assert len(s.step) >= 4
        assert s.of("tower_moment:rated")[s.step == 0] == pytest.approx(stage.archive.value("tower_moment:rated", stage.best), rel=1e-9)  # iterated to 1e-10
        assert s.change("tower_moment:rated")[s.step == 0] == 0
        changed = {DIMENSIONS[k] for k in range(5) if np.ptp(s.designs[:, k]) > 0}
        # the line's length is given relative to the anchor radius and keeps its difference
        assert changed == ({"anchor_radius", "line_length"} if s.variable.name == "anchor_radius" else {s.variable.name})
        for k, why in enumerate(s.broken):
            for c in stage.constraints:
                assert (c in why) == bool(c.excess(s.of(c.quantity)[k]) > 0 or np.isnan(s.of(c.quantity)[k]))


def test_sensitivity_statement_names_what_hardly_matters(result, findings):
    text = sensitivity_statement(result, findings, "fatigue")
    assert text.startswith("Stage fatigue, up to 3 steps")
    much, slight = text.split("by less than 0.5 % with ")
    for s in findings.sensitivities["fatigue"]:
        change = 100 * s.change("damage")
        slightly = bool(re.search(rf"(^|; ){tables.lowered(tables.variable_label(s.variable))} \(", slight))
        assert slightly == (np.nanmax(np.abs(change)) < 0.5)
        assert bool(re.search(rf" with {tables.lowered(tables.variable_label(s.variable))}", much)) != slightly


def test_far_values_do_not_flatten_the_figure():
    near = np.linspace(-1.0, 2.0, 29)
    low, high = shown_range(near)
    assert low < -1.0
    assert 2.0 < high < 3.0
    low, high = shown_range(np.append(near, 195.0))
    assert low < -1.0
    assert 2.0 < high < 195.0


def test_slack_is_line_over_straight_distance(result):
    """By hand for a hull: fairlead at radius + plate radius, on top of the plate of 6 m."""
    design = np.array([[14.0, 44.5, 24.5, 730.0, 730.0]])
    depth = result.setting.depth
    straight = np.hypot(730.0 - (44.5 + 14.0), depth - 24.5 + 6.0)
    assert slack_of(result.setting, design)[0] == pytest.approx(730.0 / straight, rel=1e-12)


def numbers(node, key=""):
    """Every number of a JSON document with the last word key above it."""
    if isinstance(node, dict):
        for k, v in node.items():
            yield from numbers(v, k)
    elif isinstance(node, list):
        for v in node:
            yield from numbers(v, key)
    elif isinstance(node, int | float) and not isinstance(node, bool):
        yield key, node


def test_json_has_units_for_all_numbers(result, findings, tmp_path):
    out = optimisation_json(result, [tmp_path / "x"], findings)
    json.dumps(out, allow_nan=False)
    units = out["units"]
    known = {*units, *units["values"], *out["reference"]["cost_items"], "here", "printed", "same_base"}
    assert {k for k, _ in numbers({k: v for k, v in out.items() if k != "units"})} <= known
    stage, found = out["stages"]["ultimate"], result.stages["ultimate"]
    assert stage["optimum"] == dict(zip(DIMENSIONS, found.optimum.tolist(), strict=True))
    for n, value in stage["values"].items():
        factor = QUANTITIES[split_name(n)[0]].factor
        assert value * factor == pytest.approx(found.archive.value(n, found.best), rel=1e-12)
    assert units["values"]["tower_moment:rated"] == "N m"
    assert 1e8 < stage["values"]["tower_moment:rated"] < 1e9  # a moment of hundreds of MN m in N m
    assert stage["ga_gap"] is None  # nothing to tell it by: no polish, no stage that tried every design
    assert out["stages"]["pareto"]["optimum"] is None
    assert len(out["stages"]["pareto"]["pareto"]) == len(result.stages["pareto"].front)
    assert all(p in out["stages"]["pareto"]["pareto"] for p in out["stages"]["pareto"]["picks"])
    assert len(out["published"]) == 9


def test_cost_items_sum_to_the_cost(result, findings):
    table = tables.cost_table(findings)
    sums = table.rows[-1][2:]
    assert sums[0] == pytest.approx(result.reference_values["cost"], rel=1e-9)  # the same account
    assert sums[1] == pytest.approx(result.stages["ultimate"].archive.value("cost", result.stages["ultimate"].best), rel=1e-9)


def test_every_design_of_a_small_space_without_publication(grid_result, tmp_path):
    findings = findings_of(grid_result)
    files = write_optimisation(grid_result, tmp_path / "out", findings=findings)
    stems = {f.stem for f in files if f.suffix == ".png"}
    assert stems == {"evolution_search", "variables_search", "sensitivity_search", "sensitivity_only", "hulls", "lines", "cost"}
    assert differences(grid_result, findings) == []
    assert tables.relative_table(grid_result, findings) is None
    out = optimisation_json(grid_result, files, findings)
    only = grid_result.stages["only"]
    assert out["stages"]["only"]["evaluations"] == 12
    assert out["stages"]["only"]["ga_gap"] is None
    least = only.archive.value("pitch_peak:rated").min()
    mine = grid_result.stages["search"].archive.value("pitch_peak:rated", grid_result.stages["search"].found)
    # against every design of the space, though the stage itself never went downhill
    assert out["stages"]["search"]["ga_gap"] == pytest.approx(mine / least - 1, abs=1e-12)
    assert "published" not in " ".join(assumptions(grid_result))
    assert len(summary_tables(grid_result, findings)) == 3


def test_a_published_design_is_completed_by_the_space(grid_result):
    """What a publication leaves open is what the space holds: the reference's anchor radius, lines of the reference's surge stiffness."""
    study = small()
    printed = Published(name="p", stage="only", design=np.array([15.0, 43.0, 24.0, np.nan, np.nan]), values={"pitch_peak:rated": 2.0, "mooring_stiffness": 1.0})
    found = findings_of(replace(grid_result, study=replace(study, published=(printed,)))).published[0]
    assert found.design[3] == grid_result.reference.design[3]
    only = grid_result.stages["only"].archive
    row = np.flatnonzero(np.all(only.designs[:, :3] == [15.0, 43.0, 24.0], axis=1))[0]
    assert found.values["pitch_peak:rated"] == pytest.approx(only.value("pitch_peak:rated", row), rel=1e-9)  # iterated to 1e-10
    # bisected to a micrometre of some 830 m of line
    assert found.values["mooring_stiffness"] == pytest.approx(grid_result.reference.batch.population.at_rest.stiffness[0, 0, 0] * 1e-3, rel=1e-5)


def test_two_objectives_alone_without_picks(tmp_path):
    study = small()
    pair = replace(study.stages[1], relative_to=None, picks=None)
    result = optimise(replace(study, stages=(pair,), published=(), constraints=study.constraints[:1]))
    files = write_optimisation(result, tmp_path / "out")
    assert {"pareto_pareto", "parallel_pareto"} <= {f.stem for f in files}
    table = tables.front_table(result, "pareto", picked=True)
    assert 1 <= len(table.rows) <= 5
    assert "f1" not in [c.name for c in table.columns]


def test_without_figures(grid_result, tmp_path):
    files = write_optimisation(grid_result, tmp_path / "out", figures=False)
    assert sorted(f.name for f in files) == ["optimisation.html", "optimisation.xlsx"]
