"""What a report evaluates beside the search: optima alone, each variable moved around them, the designs of a publication."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from fowtio.optimise.archive import in_chunks
from fowtio.optimise.run import ChunkJudge, OptimisationResult, StageResult
from fowtio.optimise.setting import batch_of
from fowtio.optimise.study import Published
from model.design.evaluate import Batch, Setting
from model.design.population import straight_distance
from model.design.quantities import Constraint, Evaluation, quantity_value
from model.design.space import DesignSpace, DesignVariable

STEPS = 3  # of the grid to either side
OUTSIDE = "outside the stage's reduced space"
NEAR = 0.02  # relative distance to its limit within which a constraint binds


@dataclass(frozen=True, eq=False, kw_only=True)
class Shown:
    """A design that tables and pictures stand beside others: label, stage ("" for the reference), dimensions (5) [m], it alone."""

    label: str
    stage: str
    design: np.ndarray
    batch: Batch

    def value(self, name: str) -> float:
        """Return a quantity in the unit that people see."""
        return float(quantity_value(self.batch, name)[0])

    @property
    def slack(self) -> float:
        """Line length over the straight distance from fairlead to anchor."""
        return self.value("line_slack")


@dataclass(frozen=True, eq=False, kw_only=True)
class Sensitivity:
    """One variable moved alone around an optimum: step (k) on the grid, value (k) [m] of the variable (over that of the dimension it
    is relative to), designs (k, 5) [m], quantities with their values (k, q) in the units that people see, why a design is none that the stage allows (k):
    the constraints that it breaks, or a sentence; nothing when it is one.
    """

    variable: DesignVariable
    step: np.ndarray
    value: np.ndarray
    designs: np.ndarray
    names: tuple[str, ...]
    values: np.ndarray
    broken: tuple[tuple[Constraint | str, ...], ...]

    def of(self, name: str) -> np.ndarray:
        """Return a quantity (k)."""
        return self.values[:, self.names.index(name)]

    def change(self, name: str) -> np.ndarray:
        """Return the relative change (k) of a quantity from the optimum."""
        here = self.of(name)
        base = here[self.step == 0][0]
        return here / base - 1


@dataclass(frozen=True, eq=False, kw_only=True)
class PublishedFinding:
    """A published design evaluated here: dimensions (5) [m] with what it leaves open as the stage's space holds it, quantities by name in the units that people see (NaN where it did not get so far), and the
    constraints of its stage that it breaks here, or a sentence why it cannot be judged.
    """

    published: Published
    design: np.ndarray
    values: dict[str, float]
    broken: tuple[Constraint | str, ...]


@dataclass(frozen=True, eq=False, kw_only=True)
class Findings:
    """What a report needs beside a result: the reference and one design of every stage, sensitivities by stage, published designs."""

    reference: Shown
    shown: dict[str, Shown]
    sensitivities: dict[str, tuple[Sensitivity, ...]]
    published: tuple[PublishedFinding, ...]

    @property
    def designs(self) -> tuple[Shown, ...]:
        """The reference and the designs of the stages."""
        return (self.reference, *self.shown.values())


def findings_of(result: OptimisationResult, progress: Callable[[str], None] = lambda text: None) -> Findings:
    """Return what a report needs beside the result of an optimisation."""
    reference = Shown(label="Reference", stage="", design=result.reference.design, batch=result.reference.batch)
    shown, moved = {}, {}
    for name, stage in result.stages.items():
        design = stage.archive.designs[shown_row(stage)]
        label = f"{name}, optimum" if stage.best is not None else f"{name}, pick {1 + list(stage.picks).index(shown_row(stage))}"
        shown[name] = Shown(label=label, stage=name, design=design, batch=batch_of(result.setting, design[None]))
        if stage.best is not None:
            progress(f"moving every variable around the optimum of stage {name}")
            moved[name] = sensitivities(result, name)
    progress("evaluating the published designs")
    return Findings(reference=reference, shown=shown, sensitivities=moved, published=published_findings(result))


def slack_of(setting: Setting, designs: np.ndarray) -> np.ndarray:
    """Return the line length over the straight distance from fairlead to anchor of designs (N, 5)."""
    return designs[:, 4] / straight_distance(setting.hulls(*designs[:, :3].T), designs[:, 3], setting.depth)


def shown_row(stage: StageResult) -> int:
    """Return the row of the design that stands for a stage: its optimum, or of several objectives the pick nearest to the best of each."""
    if stage.best is not None:
        return stage.best
    front, picks = (np.stack([stage.archive.value(n, rows) for n in stage.stage.objectives], axis=1) for rows in (stage.front, stage.picks))
    scaled = (picks - front.min(axis=0)) / np.maximum(np.ptp(front, axis=0), 1e-12)
    return int(stage.picks[np.argmin((scaled**2).sum(axis=1))])


def widest_space(result: OptimisationResult, name: str) -> DesignSpace:
    """Return the space of a stage, or the one that it was reduced from."""
    kind, _, of = result.stages[name].stage.space.partition(":")
    return widest_space(result, of) if kind == "reduced" else result.stages[name].space


def judged(result: OptimisationResult, designs: np.ndarray, names: Sequence[str]) -> Evaluation:
    """Return quantities of designs (N, 5) whatever constraints they break."""
    return in_chunks(ChunkJudge(setting=result.setting, names=tuple(dict.fromkeys(names)), constraints=()), designs, map)


def broken(constraints: Sequence[Constraint], found: Evaluation, row: int) -> tuple[Constraint | str, ...]:
    """Return the constraints that a row of an evaluation breaks, or a sentence why it did not get so far."""
    if found.reason[row]:
        return (found.reason[row],)
    return tuple(c for c in constraints if c.excess(found.values[row, found.names.index(c.quantity)]) != 0)


def sensitivities(result: OptimisationResult, name: str, steps: int = STEPS) -> tuple[Sensitivity, ...]:
    """Return what happens when each variable of a stage moves alone around its optimum, up to some steps of the grid to either side.

    Others keep their values; a dimension relative to the one that moves keeps its own difference to it. Designs outside the stage's
    reduced space, where the space it came from has them, are evaluated and marked.
    """
    stage, space = result.stages[name], widest_space(result, name)
    objective, centre = stage.stage.objectives[0], space.places(stage.optimum)[0]
    names = tuple(dict.fromkeys([objective, *(c.quantity for c in stage.constraints)]))
    moves = [np.array([s for s in range(-steps, steps + 1) if 0 <= centre[k] + s < v.count]) for k, v in enumerate(space.variables)]
    places = np.concatenate([centre + np.outer(m, np.eye(len(centre), dtype=int)[k]) for k, m in enumerate(moves)])
    designs = space.designs(places)
    found = judged(result, designs, names)
    inside = np.all(np.isclose(stage.space.designs(stage.space.places(designs)), designs, equal_nan=True), axis=1)
    out, start = [], 0
    for k, (variable, move) in enumerate(zip(space.variables, moves, strict=True)):
        rows = np.arange(start, start + len(move))
        start += len(move)
        why = tuple(broken(stage.constraints, found, r) + (() if inside[r] else (OUTSIDE,)) for r in rows)
        out.append(Sensitivity(
            variable=variable, step=move, value=variable.lower + variable.spacing * places[rows, k], designs=designs[rows], names=names, broken=why,
            values=found.values[rows][:, [found.names.index(n) for n in names]],
        ))  # fmt: skip
    return tuple(out)


def binding(stage: StageResult, moved: Sequence[Sensitivity]) -> tuple[Constraint, ...]:
    """Return the constraints that bind at an optimum: within 2 % of their limit there, or broken by one of the designs around it."""
    out = []
    for c in stage.constraints:
        values = np.concatenate([s.of(c.quantity) for s in moved])
        at = stage.archive.value(c.quantity, stage.best)
        if abs(at - c.limit) <= NEAR * abs(c.limit) or np.any(c.excess(values[np.isfinite(values)]) > 0):
            out.append(c)
    return tuple(out)


def relative_objectives(result: OptimisationResult) -> dict[str, str]:
    """Return the objectives that stages divide by those of another stage's optimum: that stage by quantity."""
    stages = [s.stage for s in result.stages.values()]
    return {n: s.relative_to for s in stages if s.relative_to in result.stages and result.stages[s.relative_to].best is not None for n in s.objectives}


def published_findings(result: OptimisationResult) -> tuple[PublishedFinding, ...]:
    """Return the published designs evaluated here: printed quantities, objectives and constraints of their stage."""
    listed = [p for p in result.study.published if p.stage in result.stages]
    out = []
    for name in dict.fromkeys(p.stage for p in listed):
        stage, group = result.stages[name], [p for p in listed if p.stage == name]
        wanted = [q for p in group for q in p.values] + list(stage.stage.objectives) + [c.quantity for c in stage.constraints]
        wanted += relative_objectives(result)
        designs = stage.space.completed(np.stack([p.design for p in group]))
        found = judged(result, designs, wanted)
        out += [
            PublishedFinding(published=p, design=designs[k], values=dict(zip(found.names, found.values[k].tolist(), strict=True)), broken=broken(stage.constraints, found, k))
            for k, p in enumerate(group)
        ]
    return tuple(out)
