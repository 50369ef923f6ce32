"""The report of an optimisation: HTML, workbook and figures; the same as JSON; what goes to the terminal; differences in sentences."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from fowtio import __version__
from fowtio.optimise import tables
from fowtio.optimise.archive import failed_constraints
from fowtio.optimise.run import OptimisationResult, relative_values
from fowtio.optimise.sensitivity import Findings, Sensitivity, binding, findings_of, relative_objectives, slack_of
from fowtio.optimise.tables import (
    DIMENSION_LABELS,
    bound,
    label,
    lowered,
    percent,
    relative_of,
    said,
    search_gap,
    unit,
    variable_label,
    why,
)
from fowtio.write.document import bullet_list, write_document
from fowtio.write.report import Card, Section
from fowtio.write.table import Table, number
from model.design.evaluate import cost_account
from model.design.quantities import LIFE, QUANTITIES, level_of, split_name
from model.design.space import DIMENSIONS

SLIGHT = 0.5  # per cent of the objective: a variable that changes it less is said to matter hardly
_SI = {"t": "kg", "deg": "rad", "deg/m": "rad/m", "MN m": "N m", "kN": "N", "kN/m": "N/m", "MEUR": "EUR"}


def write_optimisation(
    result: OptimisationResult, folder: str | Path, *, findings: Findings | None = None, figures: bool = True,
    progress: Callable[[str], None] = lambda text: None,
) -> list[Path]:  # fmt: skip
    """Write report, workbook and figures of an optimisation into a folder and return the files.

    findings are those of `findings_of(result)`, looked for without them.
    """
    found = findings or findings_of(result, progress)
    stages = {n: stage_tables(result, found, n) for n in result.stages}
    optima, searches, cost, bought = tables.optima_table(result, found), tables.search_table(result), tables.cost_table(found), tables.quantity_table(found)
    compared = [t for t in (tables.beside_table(result, found), tables.relative_table(result, found), tables.published_table(found)) if t]

    def drawn():
        from fowtio.optimise.figures import drawings

        return list(drawings(result, found))

    def sections(pictures):
        at = lambda *names: tuple(pictures[n] for n in names if n in pictures)  # noqa: E731
        out = [Section(title="Optima beside the reference", content=(optima, *at("hulls", "lines"), searches))]
        for n, (shown, folded) in stages.items():
            drawings = at(*(f"{kind}_{n}" for kind in ("evolution", "variables", "pareto", "parallel")))
            out.append(Section(title=f"Stage {n}", content=(*shown, *drawings), fold=folded))
        moved = [tables.sensitivity_table(result, found, n) for n in found.sensitivities]
        words = [sensitivity_statement(result, found, n) for n in found.sensitivities]
        pictured = at(*(f"sensitivity_{n}" for n in found.sensitivities))
        out.append(Section(title="Around the optima", content=(bullet_list(words), *pictured) if words else (), fold=tuple(moved)))
        out.append(Section(title="Cost", content=(cost, *at("cost")), fold=(bought,)))
        out.append(Section(title="Ours and the published", content=(bullet_list(differences(result, found)), *compared) if compared else ()))
        return [*out, Section(title="Assumptions", content=(bullet_list(assumptions(result)),))]

    sheets = [("Optima", [optima, searches]), *((f"Stage {n}"[:31], [*shown, *folded]) for n, (shown, folded) in stages.items())]
    sheets += [("Sensitivities", [tables.sensitivity_table(result, found, n) for n in found.sensitivities])] if found.sensitivities else []
    sheets += [("Cost", [cost, bought])] + ([("Published", compared)] if compared else [])
    return write_document(
        folder, name="optimisation", kind="Design optimisation", title=result.study.title, origin=f"Optimisation file {result.study.path.name}",
        cards=cards(result, found), drawings=drawn, sections=sections, sheets=sheets, figures=figures, progress=progress,
    )  # fmt: skip


def stage_tables(result: OptimisationResult, findings: Findings, name: str) -> tuple[tuple[Table, ...], tuple[Table, ...]]:
    """Return the tables of a stage that stand open, and those to unfold."""
    stage = result.stages[name]
    limits = (tables.constraint_table(result, findings, name),) if stage.constraints else ()
    if stage.best is not None:
        return (tables.optimum_table(result, findings, name), *limits), (tables.failure_table(stage),)
    picks, front = (tables.front_table(result, name, picked=p) for p in (True, False))
    return (picks, *limits), (front, tables.failure_table(stage))


def summary_tables(result: OptimisationResult, findings: Findings | None = None) -> list[Table]:
    """Return the tables for the terminal: searches, optima beside the reference, cost, published designs with relative objectives."""
    found = findings or findings_of(result)
    compared = [t for t in (tables.relative_table(result, found), tables.published_table(found)) if t]
    return [tables.search_table(result), tables.optima_table(result, found), tables.cost_table(found), *compared]


def cards(result: OptimisationResult, findings: Findings) -> list[Card]:
    """Return the key numbers: the optimum or the range of the picks of every stage, how much was evaluated."""
    out = []
    for name, stage in result.stages.items():
        for objective in stage.stage.objectives:
            base = result.reference_values.get(objective)
            rows = [stage.best] if stage.best is not None else stage.picks
            values = stage.archive.value(objective, rows)
            change = " to ".join(dict.fromkeys(_signed(percent(v, base)) for v in (values.min(), values.max())))
            shown = " to ".join(dict.fromkeys(number(float(v), "", None) for v in (values.min(), values.max())))
            kind = "optimum" if stage.best is not None else f"{len(rows)} picks"
            out.append(Card(label=f"{label(objective, False)} ({name})", value=f"{shown} {unit(objective)}".strip(), note=f"{kind}, {change} from the reference"))
    total = sum(len(s.archive.violation) for s in result.stages.values())
    out.append(Card(label="Designs evaluated", value=number(float(total), "", 0), note=f"in {sum(s.seconds for s in result.stages.values()):.0f} s, designs known before included"))
    return out


def _signed(value: float | None, decimals: int = 1) -> str:
    """Return a difference in per cent with its sign."""
    if value is None:
        return "–"
    text = f"{value:+.{decimals}f} %".replace("-", "−")
    return text if any(c in "123456789" for c in text) else text[1:]


def _span(values, decimals: int = 1) -> str:
    """Return a range of differences in per cent, or the one difference."""
    low, high = _signed(min(values), decimals), _signed(max(values), decimals)
    return low if low == high else f"{low} to {high}"


def sensitivity_statement(result: OptimisationResult, findings: Findings, name: str) -> str:
    """Return what moving each variable alone shows, in a sentence."""
    objective, moved = result.stages[name].stage.objectives[0], findings.sensitivities[name]
    spans = {lowered(variable_label(s.variable)) + _slack_span(result, s): 100 * s.change(objective)[np.isfinite(s.change(objective))] for s in moved}
    much = [f"{_span(v)} with {text}" for text, v in spans.items() if np.abs(v).max() >= SLIGHT]
    little = [f"{text} ({_span(v, 2)})" for text, v in spans.items() if np.abs(v).max() < SLIGHT]
    parts = [f"by {'; '.join(much)}"] if much else []
    parts += [f"by less than {SLIGHT:g} % with {'; '.join(little)}"] if little else []
    near = "; ".join(bound(c) for c in binding(result.stages[name], moved))
    return f"Stage {name}, up to {max(int(np.abs(s.step).max()) for s in moved)} steps to either side: {said(objective)} changes {', and '.join(parts)}. " + (f"Binding or close by: {near}." if near else "No constraint binds.")


def _slack_span(result: OptimisationResult, moved: Sensitivity) -> str:
    """Return how taut the lines are over the range of a line length, in words; empty for other variables."""
    if moved.variable.name != "line_length":
        return ""
    slack = slack_of(result.setting, moved.designs)
    return f" (to lines of {slack.min():.3f} to {slack.max():.3f} straight distances)"


def differences(result: OptimisationResult, findings: Findings) -> list[str]:
    """Return how our results differ from the published, in sentences made from the numbers."""
    out = []
    for name, stage in result.stages.items():
        group = [f for f in findings.published if f.published.stage == name]
        if not group:
            continue
        for quantity in dict.fromkeys(n for f in group for n in f.published.values):
            out += _value_difference(name, quantity, [f for f in group if quantity in f.published.values])
        for quantity, of in relative_objectives(result).items():
            out += _relative_difference(result, findings, name, quantity, of, group)
        out += [f"Stage {name}: published design {f.published.name} is not allowed here: {why(f.broken)}." for f in group if f.broken]
        out += _optimum_difference(result, findings, name, group) if stage.best is not None else _front_difference(result, name, group)
    return out


def _value_difference(name: str, quantity: str, group) -> list[str]:
    pairs = [(f, f.values[quantity], f.published.values[quantity]) for f in group if np.isfinite(f.values[quantity])]
    if not pairs:
        return []
    f, here, printed = pairs[0]
    one = f"design {f.published.name}: {number(here)} here, {number(printed)} printed"
    span = _span([percent(h, p) for _, h, p in pairs])
    of = f"of {len(pairs)} published designs " if len(pairs) > 1 else ""
    return [f"Stage {name}: {said(quantity)} [{unit(quantity) or '-'}] {of}{span} against print ({one})."]


def _relative_difference(result, findings, name: str, quantity: str, of: str, group) -> list[str]:
    """Say how relative values of published designs compare, like for like: over the published base evaluated here, and as printed."""
    found = [(f, *relative_of(result, findings, f, quantity)) for f in group if f.published.stage != of]
    found = [x for x in found if None not in x]
    if not found:
        return []
    f, ours, same, printed = found[0]
    span = _span([percent(x[2], x[3]) for x in found])
    return [
        f"Stage {name}: {said(quantity)} relative to the published optimum of stage {of}, {span} against print "
        f"(design {f.published.name}: {same:.3f} here, {printed:.3f} printed; {ours:.3f} relative to our optimum)."
    ]


def _optimum_difference(result, findings, name: str, group) -> list[str]:
    """Say how our optimum differs from the published one."""
    stage, shown, out = result.stages[name], findings.shown[name], []
    for f in group:
        p = f.published
        moved = [f"{lowered(DIMENSION_LABELS[d])} {shown.design[k]:.4g} m here, {f.design[k]:.4g} m published" for k, d in enumerate(DIMENSIONS)
                 if abs(shown.design[k] - f.design[k]) > 1e-6]  # fmt: skip
        out.append(f"Stage {name}, optimum: {'; '.join(moved) or 'the published design'}.")
        objective = stage.stage.objectives[0]
        change = percent(shown.value(objective), f.values.get(objective))
        if change is not None:
            out.append(f"Stage {name}: {said(objective)} of our optimum {_signed(change)} from that of published design {p.name}, both evaluated here.")
        if not {"anchor_radius", "line_length"} & {v.name for v in stage.space.variables}:
            continue
        ours, theirs = shown.slack, float(slack_of(result.setting, f.design[None])[0])
        word = "slacker" if ours > theirs else "tauter"
        out.append(f"Stage {name}: line over straight distance {ours:.4f} here, {theirs:.4f} in published design {p.name}: lines {word} here.{_slack_before(result, findings, name)}{_slack_effect(result, findings, name)}")
    return out


def _slack_before(result: OptimisationResult, findings: Findings, name: str) -> str:
    """Return how taut the picks are from which a reduced space came."""
    kind, _, of = result.stages[name].stage.space.partition(":")
    if kind != "reduced" or not len(result.stages[of].picks):
        return ""
    slack = slack_of(result.setting, result.stages[of].archive.designs[result.stages[of].picks])
    listed = np.array([f.design for f in findings.published if f.published.stage == of])
    theirs = slack_of(result.setting, listed) if len(listed) else None
    text = f" Picks of stage {of}: {slack.min():.4f} to {slack.max():.4f} here"
    return text + (f", {theirs.min():.4f} to {theirs.max():.4f} published." if theirs is not None else ".")


def _slack_effect(result: OptimisationResult, findings: Findings, name: str) -> str:
    """Return what the line length alone does to the objective around our optimum."""
    objective = result.stages[name].stage.objectives[0]
    moved = [s for s in findings.sensitivities[name] if s.variable.name == "line_length"]
    changes = [100 * c for s in moved for c in s.change(objective) if np.isfinite(c)]
    return f" The length of our lines alone, moved{_slack_span(result, moved[0])}, changes {said(objective)} by {_span(changes, 2)}." if changes else ""


def _front_difference(result, name: str, group) -> list[str]:
    """Say how our picks and front stand to the published designs evaluated here."""
    stage = result.stages[name]
    s, a = stage.stage, stage.archive
    relative = relative_values(s, a, stage.picks, result.stages)
    out = []
    if s.relative_to in result.stages:
        spans = "; ".join(f"{said(n)} {_span([100 * (v - 1) for v in relative[:, k]])}" for k, n in enumerate(s.objectives))
        out.append(f"Stage {name}: our {len(stage.picks)} picks relative to the optimum of stage {s.relative_to}: {spans}.")
    theirs = np.array([[f.values.get(n, np.nan) for n in s.objectives] for f in group])
    front = np.stack([a.value(n, stage.front) for n in s.objectives], axis=1)
    beaten = np.all(front[:, None] <= theirs, axis=2) & np.any(front[:, None] < theirs, axis=2)
    beats = np.all(theirs <= front[:, None], axis=2) & np.any(theirs < front[:, None], axis=2)
    allowed = np.array([not f.broken for f in group])
    out.append(
        f"Stage {name}: of {len(group)} published designs evaluated here, {int((beats.any(axis=0) & allowed).sum())} keep the constraints and better a design of our front "
        f"in all objectives; our front betters {int(beaten.any(axis=0).sum())}."
    )
    return out


def assumptions(result: OptimisationResult) -> list[str]:
    """Return what the numbers rest on; beside a publication, where its assumptions are known to differ."""
    study, setting = result.study, result.setting
    names = {*result.reference_values, *(n for s in result.stages.values() for n in s.archive.names)}
    theirs = lambda text: f"; the publication: {text}" if study.published else ""  # noqa: E731
    out = []
    if any(np.any(s.wind_spectrum) for s in setting.states):
        out.append(f"Wind acts over the whole turning rotor, with the harmonics of its three blades{theirs('the spectrum of one point at the hub')}.")
        kinds = sorted({str(s.turbulence) for s in study.states if s.turbulence is not None})
        out.append(f"Turbulence (class of IEC 61400-1, or intensity): {', '.join(kinds)}.")
    if any("tower_moment" in n for n in names):
        out.append(f"The tower-base moment sums the loads above the tower base{theirs('from the modal stiffness of the tower')}.")
    if any(split_name(n)[0].endswith("_peak") for n in names):
        out.append(f"Drag is linearised strip by strip for the velocity of the water over the hull, with the waves' drag force{theirs('for the velocity of the hull, with coefficients of the whole hull')}.")
    out.append("Walls and ballast of the hull are those of the cost file" + (", inferred where the publication does not print them." if study.published else "."))
    if setting.cost is not None and "cost" in names:
        out.append(f"Anchors are sized by {setting.cost.safety:g} times the mean load in state {setting.cost.state}.")
    out.append(f"Friction of the lines on the seabed: coefficient {setting.line.seabed_friction:g}, of the source model.")
    if any(level_of(n) == LIFE for n in names):
        seas = ", whose seas are extremes of one year as in the publication," if study.published else ""
        out.append(f"Damage weights the study's states{seas} with their share of the time: it ranks designs and is no lifetime.")
    return out


def si(name: str, value) -> float | None:
    """Return a quantity in SI from the unit that people see; None for what is not known."""
    return None if value is None or not np.isfinite(value) else float(value) / QUANTITIES[split_name(name)[0]].factor


def si_unit(name: str) -> str:
    """Return the SI unit of a quantity."""
    text = QUANTITIES[split_name(name)[0]].unit
    return _SI.get(text, text)


def optimisation_json(result: OptimisationResult, files: Sequence[Path], findings: Findings | None = None) -> dict:
    """Return an optimisation in SI with the units of all that is in it."""
    found = findings or findings_of(result)
    names = sorted({*result.reference_values, *(n for s in result.stages.values() for n in s.archive.names), *(n for f in found.published for n in f.values)})
    return {
        "file": str(result.study.path), "title": result.study.title, "version": __version__,
        "reference": {**_dimensions(found.reference.design), "values": {n: si(n, v) for n, v in result.reference_values.items()}, "cost_items": _items(found.reference)},
        "stages": {n: _stage_json(result, found, n) for n in result.stages},
        "published": [_published_json(result, found, f) for f in found.published],
        "differences": differences(result, found), "assumptions": assumptions(result), "files": [str(f) for f in files],
        "units": {
            **dict.fromkeys(DIMENSIONS, "m"), "values": {n: si_unit(n) for n in names}, "cost_items": "EUR", "seconds": "s", "ga_gap": "-", "relative": "-",
            "relative_difference": "-", "limit": "that of its quantity", "value": "that of its quantity", "margin": "-", "objective": "that of the stage's objective",
            "variable_value": "m", "step": "steps of the grid", "evaluations": "designs", "feasible": "designs", "generations": "-", "seed": "-", "designs": "designs",
        },
    }  # fmt: skip


def _dimensions(design) -> dict[str, float]:
    return {d: float(v) for d, v in zip(DIMENSIONS, design, strict=True)}


def _items(shown) -> dict[str, float]:
    return {i.name: float(np.ravel(i.cost)[0]) for i in cost_account(shown.batch)}


def _design_json(stage, row: int) -> dict:
    a = stage.archive
    return {**_dimensions(a.designs[row]), "values": {n: si(n, float(a.value(n, row))) for n in a.names}}


def _stage_json(result: OptimisationResult, found: Findings, name: str) -> dict:
    stage = result.stages[name]
    s, a, shown = stage.stage, stage.archive, found.shown[name]
    front = relative_values(s, a, stage.front, result.stages) if len(stage.front) else np.zeros((0, len(s.objectives)))
    related = s.relative_to in result.stages
    pareto = [
        _design_json(stage, r) | ({"relative": dict(zip(s.objectives, front[k].tolist(), strict=True))} if related else {}) for k, r in enumerate(stage.front)
    ]  # fmt: skip
    at = {int(r): k for k, r in enumerate(stage.front)}
    best = None if stage.best is None else _design_json(stage, stage.best)
    return {
        "method": s.method, "objectives": list(s.objectives), "space": s.space,
        "optimum": None if best is None else {d: best[d] for d in DIMENSIONS}, "values": None if best is None else best["values"],
        "search_best": None if stage.found is None else _design_json(stage, stage.found), "ga_gap": search_gap(result, name),
        "evaluations": len(a.violation), "feasible": int(a.feasible.sum()), "generations": len(a.generations), "seed": s.seed, "seconds": float(stage.seconds),
        "constraints": [_constraint_json(c, shown) for c in stage.constraints],
        "failures": [{"reason": text, "designs": n} for text, n in failed_constraints(a, stage.constraints)],
        "pareto": pareto, "picks": [pareto[at[int(r)]] for r in stage.picks],
        "sensitivity": [_sensitivity_json(s.objectives[0], m) for m in found.sensitivities.get(name, ())],
        "cost_items": _items(shown),
    }  # fmt: skip


def _constraint_json(c, shown) -> dict:
    value = shown.value(c.quantity)
    margin = tables.margin(c, value) / 100
    return {
        "quantity": c.quantity, "relation": c.relation, "limit": si(c.quantity, c.limit), "value": si(c.quantity, value),
        "margin": margin if np.isfinite(margin) else None,
    }  # fmt: skip


def _sensitivity_json(objective: str, moved: Sensitivity) -> dict:
    v = moved.variable
    return {
        "variable": v.name, "relative_to": v.relative_to, "step": moved.step.tolist(), "variable_value": moved.value.tolist(),
        "objective": [si(objective, x) for x in moved.of(objective)], "not_allowed": [why(b) for b in moved.broken],
    }  # fmt: skip


def _published_json(result: OptimisationResult, found: Findings, f) -> dict:
    p = f.published
    relative = {n: dict(zip(("here", "same_base", "printed"), relative_of(result, found, f, n), strict=True)) for n in relative_objectives(result)}
    values = {}
    for n, printed in p.values.items():
        change = percent(f.values[n], printed)
        values[n] = {"here": si(n, f.values[n]), "printed": si(n, printed), "relative_difference": None if change is None else change / 100}
    return {"name": p.name, "stage": p.stage, **_dimensions(f.design), "values": values, "relative": relative, "broken": [why((b,)) for b in f.broken]}
