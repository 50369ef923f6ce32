"""The tables of an optimisation: designs, quantities, constraints, costs, sensitivities, ours beside the published."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fowtio.optimise.archive import failed_constraints
from fowtio.optimise.run import SHOWN, OptimisationResult, StageResult, relative_values
from fowtio.optimise.sensitivity import Findings, binding, relative_objectives, shown_row, slack_of
from fowtio.write.table import ROW, Column, Table, number
from model.design.evaluate import cost_account
from model.design.quantities import QUANTITIES, split_name
from model.design.space import DIMENSIONS

DIMENSION_LABELS = {
    "diameter": "Column diameter", "radius": "Platform radius", "draft": "Draft", "anchor_radius": "Anchor radius", "line_length": "Line length",
}  # fmt: skip
_LABELS = {
    "tower_moment": "Tower-base moment, μ + σ", "tower_moment_mean": "Tower-base moment, μ", "tower_moment_std": "Tower-base moment, σ",
    "extreme_tower_moment": "Tower-base moment, expected largest", "offset_ratio": "Surge over depth", "grounded_share": "Line on seabed",
    "rest_grounded_share": "Line on seabed at rest", "surge_std": "Surge, σ", "heave_std": "Heave, σ", "pitch_std": "Pitch, σ", "tension_std": "Tension, σ",
    "surge_peak": "Surge RAO peak", "heave_peak": "Heave RAO peak", "pitch_peak": "Pitch RAO peak", "extreme_tension": "Tension, expected largest",
    "nacelle_acceleration_std": "Nacelle acceleration, σ", "line_slack": "Line over straight distance",
}  # fmt: skip
_UNITS = {"MEUR": "M€", "m2": "m²", "m/s2": "m/s²", "-": ""}
_SIGNS = {"<=": "≤", ">=": "≥"}


def label(name: str, state: bool = True) -> str:
    """Return a quantity's name for people, with its state unless told not to."""
    quantity, of = split_name(name)
    text = _LABELS.get(quantity, quantity.replace("_", " ").capitalize())
    return f"{text}, {of}" if of and state else text


def lowered(text: str) -> str:
    """Return a label for the middle of a sentence."""
    return text[:1].lower() + text[1:]


def said(name: str) -> str:
    """Return a quantity's name for the middle of a sentence."""
    return lowered(label(name))


def labels(names: Sequence[str]) -> dict[str, str]:
    """Return the names of quantities for people, without the state when all have the same."""
    several = len({split_name(n)[1] for n in names} - {""}) > 1
    return {n: label(n, several) for n in names}


def state_note(names: Sequence[str]) -> str:
    """Return which state quantities are of, when it is one and their labels do not say it."""
    states = {split_name(n)[1] for n in names} - {""}
    return f"Quantities of a sea and wind are those of state {states.pop()}." if len(states) == 1 else ""


def unit(name: str) -> str:
    """Return the unit of a quantity that people see."""
    text = QUANTITIES[split_name(name)[0]].unit
    return _UNITS.get(text, text)


def bound(constraint) -> str:
    """Return a constraint in words."""
    return f"{label(constraint.quantity)} {_SIGNS[constraint.relation]} {number(constraint.limit)} {unit(constraint.quantity)}".rstrip()


def why(broken) -> str:
    """Return constraints and sentences in one text."""
    return "; ".join(b if isinstance(b, str) else bound(b) for b in broken)


def percent(value, base) -> float | None:
    """Return the difference of a value from a base in per cent of it, None where there is none."""
    if value is None or base is None or not np.isfinite([value, base]).all() or base == 0:
        return None
    return float(100 * (value / base - 1))


def dimension_columns() -> list[Column]:
    """Return the columns of a design's dimensions."""
    return [Column(name=DIMENSION_LABELS[d], unit="m", decimals=2) for d in DIMENSIONS]


def quantity_columns(names: Sequence[str]) -> list[Column]:
    """Return the columns of quantities."""
    text = labels(names)
    return [Column(name=text[n], unit=unit(n), decimals={"M€": 3, "MN m": 2}.get(unit(n))) for n in names]


def optima_table(result: OptimisationResult, findings: Findings) -> Table:
    """Return the reference and the design of every stage with all objectives."""
    names = list(dict.fromkeys([*(n for s in result.stages.values() for n in s.stage.objectives), *(n.format(result.study.cost_state) for n in SHOWN)]))
    columns = (Column(name="Design"), *dimension_columns(), Column(name="Line over straight", decimals=3), *quantity_columns(names))
    rows = tuple((d.label, *d.design.tolist(), d.slack, *(d.value(n) for n in names)) for d in findings.designs)
    several = [n for n, s in result.stages.items() if s.best is None]
    note = f"Of stage {', '.join(several)} the pick nearest to the best of each objective. " if several else ""
    return Table(name="optima", title="Optima beside the reference", columns=columns, rows=rows, note=note + state_note(names))


def optimum_table(result: OptimisationResult, findings: Findings, name: str) -> Table:
    """Return what a stage with one objective found: the search's best, the best after going downhill, the reference, and the change."""
    stage = result.stages[name]
    a = stage.archive
    base, change = findings.reference.design, Column(name="Change from reference", unit="%", decimals=1)
    heads, at = (["Every design"] if stage.stage.method == "grid" else ["Search"]), [stage.found]
    if result.study.polish and stage.stage.method != "grid":
        heads, at = [*heads, "Downhill"], [stage.found, stage.best]
    columns = (Column(name="Quantity"), Column(name="Unit"), *(Column(name=h, unit=ROW) for h in (*heads, "Reference")), change)
    best = a.designs[stage.best]
    rows = [(DIMENSION_LABELS[d], "m", *a.designs[at, k].tolist(), float(base[k]), percent(best[k], base[k])) for k, d in enumerate(DIMENSIONS)]
    slack = *slack_of(result.setting, a.designs[at]).tolist(), findings.reference.slack
    rows.append((label("line_slack"), "", *slack, percent(*slack[-2:])))
    text = labels(a.names)
    for n in a.names:
        rows.append((text[n], unit(n), *a.value(n, at).tolist(), result.reference_values.get(n), percent(a.value(n, stage.best), result.reference_values.get(n))))
    note = "Downhill: from the search's best to the design that none of its neighbours on the grid betters." if len(heads) > 1 else ""
    return Table(name=f"optimum_{name}", title=f"Stage {name}: optimum", columns=columns, rows=tuple(rows), note=f"{state_note(a.names)} {note}".strip())


def front_table(result: OptimisationResult, name: str, *, picked: bool) -> Table:
    """Return the Pareto front of a stage, or its picks alone, with dimensions, relative objectives and quantities."""
    stage = result.stages[name]
    rows_of, a = (stage.picks if picked else stage.front), stage.archive
    relative = relative_values(stage.stage, a, rows_of, result.stages)
    base = stage.stage.relative_to if stage.stage.relative_to in result.stages else None
    columns = [Column(name="Design", decimals=0), *dimension_columns()]
    columns += [Column(name=f"f{k + 1}", decimals=3) for k in range(len(stage.stage.objectives))] if base else []
    columns += quantity_columns(a.names)
    rows = [
        (float(k + 1), *a.designs[r].tolist(), *(relative[k].tolist() if base else ()), *a.values[r].tolist()) for k, r in enumerate(rows_of)
    ]
    what = "; ".join(f"f{k + 1}: {said(n)} over that of the optimum of stage {base}" for k, n in enumerate(stage.stage.objectives)) if base else ""
    kind, title = ("picks", "picked designs") if picked else ("front", "Pareto front")
    note = ". ".join(t for t in (what, state_note(a.names).rstrip(".")) if t)
    return Table(name=f"{kind}_{name}", title=f"Stage {name}: {title}", columns=tuple(columns), rows=tuple(rows), note=note + "." if note else "")


def constraint_table(result: OptimisationResult, findings: Findings, name: str) -> Table:
    """Return the constraints of a stage with the value of its design, the margin, and how many designs failed at each."""
    stage = result.stages[name]
    row = shown_row(stage)
    columns = (
        Column(name="Constraint"), Column(name="Bound"), Column(name="Unit"), Column(name="Limit", unit=ROW), Column(name=findings.shown[name].label, unit=ROW),
        Column(name="Margin", unit="%", decimals=1),
    )  # fmt: skip
    rows = []
    for c in stage.constraints:
        value = float(stage.archive.value(c.quantity, row))
        rows.append((label(c.quantity), _SIGNS[c.relation], unit(c.quantity), float(c.limit), value, margin(c, value)))
    return Table(name=f"constraints_{name}", title=f"Stage {name}: constraints", columns=columns, rows=tuple(rows), note="Margin in per cent of the limit.")


def margin(constraint, value: float) -> float:
    """Return how far a value keeps from a constraint's limit in per cent of it, negative when it breaks it."""
    over = constraint.limit - value if constraint.relation == "<=" else value - constraint.limit
    return float(100 * over / abs(constraint.limit)) if constraint.limit else float("nan")


def failure_table(stage: StageResult) -> Table:
    """Return for what reason designs of a stage failed."""
    total = len(stage.archive.violation)
    kept = int(stage.archive.feasible.sum())
    rows = [("keeps all constraints", float(kept), 100 * kept / total)]
    words = {f"{c.quantity} {c.relation} {c.limit:.4g}": f"breaks {bound(c)}" for c in stage.constraints}
    rows += [(words.get(text, text), float(n), 100 * n / total) for text, n in failed_constraints(stage.archive, stage.constraints)]
    columns = (Column(name="Outcome"), Column(name="Designs", decimals=0), Column(name="Share", unit="%", decimals=1))
    note = "A design is judged from what is cheap to what is dear and counts where it first failed."
    name = stage.stage.name
    return Table(name=f"failures_{name}", title=f"Stage {name}: {total} designs evaluated", columns=columns, rows=tuple(rows), note=note)


def search_table(result: OptimisationResult) -> Table:
    """Return how every stage was searched."""
    columns = (
        Column(name="Stage"), Column(name="Objectives"), Column(name="Method"), Column(name="Space", decimals=0), Column(name="Evaluated", decimals=0),
        Column(name="Feasible", decimals=0), Column(name="Generations", decimals=0), Column(name="Seed", decimals=0),
        Column(name="Search over best known", unit="%", decimals=3), Column(name="Time", unit="s", decimals=1),
    )  # fmt: skip
    rows = []
    for name, s in result.stages.items():
        gap = search_gap(result, name)
        rows.append((
            name, "; ".join(label(n) for n in s.stage.objectives), s.stage.method, float(s.space.size), float(len(s.archive.violation)),
            float(s.archive.feasible.sum()), float(len(s.archive.generations)), None if s.stage.method == "grid" else float(s.stage.seed),
            None if gap is None else 100 * gap, s.seconds,
        ))  # fmt: skip
    note = "Best known: of the same space in full where a stage tried every design, else after going downhill. Time of this run, without designs known before."
    return Table(name="stages", title="Stages", columns=columns, rows=tuple(rows), note=note)


def search_gap(result: OptimisationResult, name: str) -> float | None:
    """Return by how much the genetic algorithm's best is worse than the best design known, over the latter.

    None for other methods, and where neither a stage tried every design of the same space nor the search went downhill.
    """
    stage = result.stages[name]
    same = (stage.stage.space, stage.stage.objectives, stage.constraints)
    tried = [o for o in result.stages.values() if o.stage.method == "grid" and (o.stage.space, o.stage.objectives, o.constraints) == same]
    if stage.stage.method != "ga" or not (tried or result.study.polish):
        return None
    objective = stage.stage.objectives[0]
    best = float(min(o.archive.value(objective, o.best) for o in (stage, *tried)))
    return float(stage.archive.value(objective, stage.found) - best) / abs(best)


def cost_table(findings: Findings) -> Table:
    """Return the account of every design, item by item."""
    accounts = {d.label: cost_account(d.batch) for d in findings.designs}
    columns = (Column(name="Item"), Column(name="Unit"), *(Column(name=n, unit=ROW, decimals=3) for n in accounts))
    first = next(iter(accounts.values()))
    rows = [(i.name, "M€", *(_cost(a[k]) for a in accounts.values())) for k, i in enumerate(first)]
    rows.append(("Sum", "M€", *(sum(_cost(i) for i in a) for a in accounts.values())))
    return Table(name="cost", title="Cost by item", columns=columns, rows=tuple(rows))


def quantity_table(findings: Findings) -> Table:
    """Return the quantities that are bought: steel, ballast, hours, paint, lines, anchors."""
    accounts = {d.label: cost_account(d.batch) for d in findings.designs}
    first = next(iter(accounts.values()))
    scale = {"kg": ("t", 1e-3), "m2": ("m²", 1.0)}
    columns = (Column(name="Item"), Column(name="Unit"), *(Column(name=n, unit=ROW, decimals=1) for n in accounts))
    rows = []
    for k, item in enumerate(first):
        shown, factor = scale.get(item.unit, (item.unit, 1.0))
        rows.append((item.name, shown, *(float(np.ravel(a[k].quantity)[0]) * factor for a in accounts.values())))
    return Table(name="bought", title="Quantities behind the cost", columns=columns, rows=tuple(rows))


def _cost(item) -> float:
    return float(np.ravel(item.cost)[0]) * 1e-6


def sensitivity_table(result: OptimisationResult, findings: Findings, name: str) -> Table:
    """Return what moving each variable alone does to the objective and to the constraints that bind."""
    stage, moved = result.stages[name], findings.sensitivities[name]
    objective = stage.stage.objectives[0]
    near = [c.quantity for c in binding(stage, moved) if c.quantity != objective]
    near = list(dict.fromkeys(near))
    columns = [
        Column(name="Variable"), Column(name="Steps", decimals=0), Column(name="Value", unit="m", decimals=2), *quantity_columns([objective]),
        Column(name="Change", unit="%", decimals=2), *quantity_columns(near), Column(name="Not allowed because"),
    ]  # fmt: skip
    rows = []
    for s in moved:
        change = s.change(objective)
        rows += [
            (variable_label(s.variable), float(s.step[k]), float(s.value[k]), float(s.of(objective)[k]), float(100 * change[k]),
             *(float(s.of(n)[k]) for n in near), why(s.broken[k]))
            for k in range(len(s.step))
        ]  # fmt: skip
    note = f"One variable moved by steps of its grid, the others held. {state_note([objective, *near])}".strip()
    return Table(name=f"sensitivity_{name}", title=f"Stage {name}: every variable moved alone", columns=tuple(columns), rows=tuple(rows), note=note)


def variable_label(variable) -> str:
    """Return a design variable for people; one that is relative to another as a difference."""
    text = DIMENSION_LABELS[variable.name]
    return text if variable.relative_to is None else f"{text} less {lowered(DIMENSION_LABELS[variable.relative_to])}"


def published_table(findings: Findings) -> Table | None:
    """Return the published designs: printed values, ours for the very same design, the difference."""
    if not findings.published:
        return None
    columns = (
        Column(name="Design"), Column(name="Stage"), Column(name="Quantity"), Column(name="Unit"), Column(name="Here", unit=ROW), Column(name="Printed", unit=ROW),
        Column(name="Difference", unit="%", decimals=1),
    )  # fmt: skip
    names = list(dict.fromkeys(n for f in findings.published for n in f.published.values))
    text = labels(names)
    rows = tuple(
        (f.published.name, f.published.stage, text[n], unit(n), _number(f.values[n]), printed, percent(f.values[n], printed))
        for f in findings.published
        for n, printed in f.published.values.items()
    )
    return Table(name="published", title="Published designs evaluated here", columns=columns, rows=rows, note=state_note(names))


def relative_table(result: OptimisationResult, findings: Findings) -> Table | None:
    """Return the published designs with their objectives relative to a stage's optimum: ours, the published one, and as printed."""
    pairs = relative_objectives(result)
    if not findings.published:
        return None
    columns = [Column(name="Design"), Column(name="Stage"), *dimension_columns()]
    for k, name in enumerate(pairs):
        columns += [Column(name=f"f{k + 1} {text}", decimals=3) for text in ("here", "same base", "printed")]
    columns.append(Column(name="Constraints here"))
    rows = tuple(
        (f.published.name, f.published.stage, *f.design.tolist(), *(v for n in pairs for v in relative_of(result, findings, f, n)), why(f.broken) or "kept")
        for f in findings.published
    )
    what = "; ".join(f"f{k + 1}: {said(n)} over that of stage {base}" for k, (n, base) in enumerate(pairs.items()))
    note = f"{what}. Here: over our optimum; same base: over the published optimum evaluated here; printed: both as printed." if pairs else ""
    return Table(name="relative", title="Published designs, relative objectives and constraints", columns=tuple(columns), rows=rows, note=note)


def relative_of(result: OptimisationResult, findings: Findings, item, name: str) -> tuple[float | None, float | None, float | None]:
    """Return a quantity of a published design over that of our optimum, of the published optimum evaluated here, and as printed."""
    of = relative_objectives(result)[name]
    base = result.stages[of]
    ours = float(base.archive.value(name, base.best)) if name in base.archive.names else None
    theirs = next((f for f in findings.published if f.published.stage == of), None)
    here, printed = item.values.get(name), item.published.values.get(name)
    return (
        _ratio(here, ours), _ratio(here, theirs.values.get(name) if theirs else None), _ratio(printed, theirs.published.values.get(name) if theirs else None)
    )  # fmt: skip


def _ratio(value, base) -> float | None:
    if value is None or base is None or not np.isfinite([value, base]).all() or not base:
        return None
    return float(value / base)


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def beside_table(result: OptimisationResult, findings: Findings) -> Table | None:
    """Return our optima beside the published ones, all evaluated here, with printed values below."""
    stages = [s for s in result.stages.values() if s.best is not None and any(f.published.stage == s.stage.name for f in findings.published)]
    if not stages:
        return None
    names = list(dict.fromkeys(n for f in findings.published for n in (*result.stages[f.published.stage].stage.objectives, *f.published.values)))
    columns = (Column(name="Stage"), Column(name="Design"), *dimension_columns(), Column(name="Line over straight", decimals=4), *quantity_columns(names))
    rows = []
    for s in stages:
        name = s.stage.name
        shown = findings.shown[name]
        rows.append((name, "optimum here", *shown.design.tolist(), shown.slack, *(shown.value(n) for n in names)))
        for f in (f for f in findings.published if f.published.stage == name):
            p = f.published
            slack = float(slack_of(result.setting, f.design[None])[0])
            rows.append((name, f"{p.name}, evaluated here", *f.design.tolist(), slack, *(_number(f.values.get(n, np.nan)) for n in names)))
            rows.append((name, f"{p.name}, printed", *f.design.tolist(), slack, *(p.values.get(n) for n in names)))
    return Table(name="beside", title="Our optima beside the published ones", columns=columns, rows=tuple(rows), note=state_note(names))
