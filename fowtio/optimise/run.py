"""An optimisation from its file to its results, stage by stage."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fowtio import __version__
from fowtio.errors import ModelError
from fowtio.optimise.archive import Archive, failed_constraints, in_chunks
from fowtio.optimise.search import pareto_front, polish, polish_front, search
from fowtio.optimise.setting import Reference, batch_of, reference_of, setting_of, shortfall, space_of
from fowtio.optimise.study import OptimisationStudy, Stage
from model.design.evaluate import Setting
from model.design.quantities import LIFE, QUANTITIES, Constraint, Evaluation, evaluate, level_of, quantity_value
from model.design.space import DesignSpace

MOST_PICKS = 12
SHOWN = ("cost", "total_mass", "mean_surge:{0}", "mean_pitch:{0}")


@dataclass(frozen=True, eq=False, kw_only=True)
class StageResult:
    """What a stage found: its space, resolved constraints, archive, row of the best design of the search and of the best after going
    downhill from it (None where several objectives), rows of the Pareto front and of the picks, whether every design was tried.
    """

    stage: Stage
    space: DesignSpace
    constraints: tuple[Constraint, ...]
    archive: Archive
    found: int | None
    best: int | None
    front: np.ndarray
    picks: np.ndarray
    seconds: float

    @property
    def optimum(self) -> np.ndarray | None:
        """Dimensions (5) [m] of the best design."""
        return None if self.best is None else self.archive.designs[self.best]


@dataclass(frozen=True, eq=False, kw_only=True)
class OptimisationResult:
    """A study run: study, setting, the reference and its values by quantity, results of the stages by name."""

    study: OptimisationStudy
    setting: Setting
    reference: Reference
    reference_values: dict[str, float]
    stages: dict[str, StageResult]


def optimise(
    study: OptimisationStudy, folder: Path | None = None, *, stages: Sequence[str] | None = None, fresh: bool = False, mapper: Callable | None = None,
    progress: Callable[[str], None] = lambda text: None,
) -> OptimisationResult:  # fmt: skip
    """Return the results of all stages of a study, or of some and those they build on.

    folder keeps the history, and a run in the same folder goes on from it unless `fresh`; mapper maps a function over chunks of
    designs, by default one after the other. Raises ModelError when a stage finds no design that keeps its constraints.
    """
    import time

    progress("reading coefficients and turbine")
    setting = setting_of(study)
    reference = reference_of(study, setting)
    values: dict[str, float] = {}
    done: dict[str, StageResult] = {}
    wanted = _with_their_bases(study, stages)
    digest = study_digest(study, setting)
    for stage in (s for s in study.stages if s.name in wanted):
        start = time.perf_counter()
        constraints = tuple(_resolved(c, study, reference, values, done) for c in study.constraints if c.stage in ("all", stage.name))
        space = _space(study, stage, setting, reference, done)
        names = tuple(dict.fromkeys([*stage.objectives, *(c.quantity for c in constraints), *(n.format(study.cost_state) for n in SHOWN)]))
        path = None if folder is None else Path(folder) / "history" / f"{stage.name}.nc"
        if fresh and path is not None:
            path.unlink(missing_ok=True)
        judge = _judge(setting, names, constraints, mapper)
        archive = Archive(space=space, names=names, evaluate=judge, digest=f"{digest} {stage_digest(stage, space, constraints)}", path=path)
        resumed = f", {len(archive.violation)} designs known" if len(archive.violation) else ""
        progress(f"stage {stage.name}: {space.size:,} designs in its space{resumed}")
        search(
            archive, stage.method, stage.objectives, population=stage.population, generations=stage.generations, crossover=stage.crossover,
            elite=stage.elite, seed=stage.seed, progress=lambda text, n=stage.name: progress(f"stage {n}: {text}"),
        )  # fmt: skip
        done[stage.name] = _result(stage, space, constraints, archive, study, done, progress, start)
    for name in _reference_names(study):
        values.setdefault(name, reference_value(reference, name))
    return OptimisationResult(study=study, setting=setting, reference=reference, reference_values=values, stages=done)


def _judge(setting: Setting, names, constraints, mapper) -> Callable[[np.ndarray], Evaluation]:
    def judge(designs):
        return in_chunks(ChunkJudge(setting=setting, names=names, constraints=constraints), designs, mapper or map)

    return judge


@dataclass(frozen=True, eq=False, kw_only=True)
class ChunkJudge:
    """Evaluates a chunk of designs (N, 5); a plain object, so that it can travel to other processes."""

    setting: Setting
    names: tuple[str, ...]
    constraints: tuple[Constraint, ...]

    def __call__(self, designs: np.ndarray) -> Evaluation:
        reach = shortfall(self.setting, designs)
        return evaluate(lambda some: batch_of(self.setting, some), designs, reach, self.names, self.constraints)


def _result(stage, space, constraints, archive: Archive, study, done, progress, start) -> StageResult:
    import time

    objective = stage.objectives[0]
    members = np.unique(np.concatenate(archive.generations)) if archive.generations else np.zeros(0, dtype=int)
    if not archive.feasible[members].any():
        raise ModelError(f"stage {stage.name}: no design keeps all constraints; of {len(archive.violation)} designs " + "; ".join(f"{n} fail at {what}" for what, n in failed_constraints(archive, constraints)[:4]))
    found = best = None
    front, picks = np.zeros(0, dtype=int), np.zeros(0, dtype=int)
    if len(stage.objectives) == 1:
        found = best = archive.best(objective, members)
        if study.polish and stage.method != "grid":
            best = polish(archive, objective, found, lambda text: progress(f"stage {stage.name}: {text}"))
    else:
        front = pareto_front(archive, stage.objectives, sorted(archive.visited))  # a history may hold more: what came after
        if study.polish:
            front = polish_front(archive, stage.objectives, front, lambda text: progress(f"stage {stage.name}: {text}"))
        picks = _picks(stage, archive, front, done)
    return StageResult(
        stage=stage, space=space, constraints=constraints, archive=archive, found=found, best=best, front=front, picks=picks,
        seconds=time.perf_counter() - start,
    )  # fmt: skip


def _picks(stage: Stage, archive: Archive, front: np.ndarray, done: dict[str, StageResult]) -> np.ndarray:
    """Return designs of the front within the picks' bounds, relative to the optimum of the stage before, evenly thinned where there are
    many; failing that the five nearest to the best of both.
    """
    values = relative_values(stage, archive, front, done)
    if stage.picks is not None:
        inside = np.all(values <= np.array(stage.picks), axis=1)
        if inside.any():
            few = front[inside]
            return few[np.unique(np.round(np.linspace(0, len(few) - 1, MOST_PICKS)).astype(int))]
    scaled = (values - values.min(axis=0)) / np.maximum(np.ptp(values, axis=0), 1e-12)
    return front[np.argsort((scaled**2).sum(axis=1), kind="stable")[:5]]


def relative_values(stage: Stage, archive: Archive, rows, done: dict[str, StageResult]) -> np.ndarray:
    """Return the objectives (N, k) of rows over those of the optimum that the stage is relative to (1 without one)."""
    values = np.stack([archive.value(n, rows) for n in stage.objectives], axis=1)
    base = done.get(stage.relative_to or "")
    if base is None or base.best is None:
        return values
    return values / np.array([base.archive.value(n, base.best) if n in base.archive.names else np.nan for n in stage.objectives])


def _space(study, stage: Stage, setting, reference, done) -> DesignSpace:
    kind, _, of = stage.space.partition(":")
    if kind != "reduced":
        return space_of(study, stage.space, setting, reference)
    base = done[of]
    rows = base.picks if len(base.picks) else [base.best]
    return base.space.reduced(base.archive.designs[rows])


def _resolved(entry, study, reference, values, done) -> Constraint:
    """Return a constraint with its limit as a number."""
    if entry.of is None:
        return Constraint(quantity=entry.quantity, relation=entry.relation, limit=entry.factor)
    if entry.of == "reference":
        if entry.quantity not in values:
            values[entry.quantity] = reference_value(reference, entry.quantity)
        base = values[entry.quantity]
    else:
        result = done.get(entry.of)
        if result is None or result.best is None or entry.quantity not in result.archive.names:
            raise ModelError(
                f"{study.path}, line {entry.line}: {entry.quantity} of stage {entry.of} is not known where it is needed; the stage must come before, "
                "with one objective, and know that quantity"
            )
        base = float(result.archive.value(entry.quantity, result.best))
    return Constraint(quantity=entry.quantity, relation=entry.relation, limit=entry.factor * base)


def reference_value(reference: Reference, name: str) -> float:
    """Return a quantity of the reference design in the unit that people see."""
    return float(quantity_value(reference.batch, name)[0])


def _reference_names(study: OptimisationStudy) -> list[str]:
    names = [n for s in study.stages for n in s.objectives] + [c.quantity for c in study.constraints] + [n.format(study.cost_state) for n in SHOWN]
    names += [q for p in study.published for q in p.values]
    return list(dict.fromkeys(n for n in names if n.split(":")[0] in QUANTITIES and (level_of(n) < LIFE or any(study.shares.values()))))


def _with_their_bases(study: OptimisationStudy, stages: Sequence[str] | None) -> set[str]:
    """Return the names of the stages wanted and of those that they build on."""
    if stages is None:
        return {s.name for s in study.stages}
    known = [s.name for s in study.stages]
    for name in stages:
        if name not in known:
            raise ModelError(f"{study.path}: no stage {name!r}; there are {', '.join(known)}")
    out, todo = set(), list(stages)
    while todo:
        name = todo.pop()
        if name in out:
            continue
        out.add(name)
        stage = study.stage(name)
        todo += [t for t in (stage.space.partition(":")[2], stage.relative_to) if t in known]
        todo += [c.of for c in study.constraints if c.stage in ("all", name) and c.of in known]
    return out


def study_digest(study: OptimisationStudy, setting: Setting) -> str:
    """Return a digest of what all evaluations depend on: version, setting with its matrices, spectra, coefficients and costs."""
    digest = hashlib.sha256(__version__.encode())
    for state in setting.states:
        for array in (state.wave_spectrum, state.wind_spectrum, state.gradient_spectrum, state.turbine.mass, state.turbine.damping, state.turbine.stiffness, state.turbine.force, state.turbine.wind_force):
            digest.update(np.ascontiguousarray(array).tobytes())
        digest.update(repr((state.name, state.heading, state.share)).encode())
    for array in (setting.omega, setting.database.values, setting.database.infinite, setting.nacelle_motion):
        digest.update(np.ascontiguousarray(array).tobytes())
    plain = (setting.line, setting.depth, setting.carried, setting.tower_base, sorted(setting.hull.items()), vars(setting.cost) if setting.cost else None,
             vars(setting.fatigue) if setting.fatigue else None, setting.duration, setting.density, setting.gravity, study.reference)  # fmt: skip
    digest.update(repr(plain).encode())
    return digest.hexdigest()[:16]


def stage_digest(stage: Stage, space: DesignSpace, constraints: Sequence[Constraint]) -> str:
    """Return a digest of a stage's objectives, space and constraints (not of its population: more generations go on from fewer)."""
    return hashlib.sha256(repr((stage.objectives, space.variables, sorted(space.fixed.items()), constraints)).encode()).hexdigest()[:16]
