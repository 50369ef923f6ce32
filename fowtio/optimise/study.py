"""The optimisation file (.opt): states, spaces of designs, constraints and stages of a search; every problem reported at once."""

from __future__ import annotations

import difflib
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fowtio.case import Problems, StateEntry, check_names, check_row_counts, read_states, without_rows
from fowtio.cost_study import cost_settings
from fowtio.errors import FormatError, FowtioError
from fowtio.read.openfast_input import InputFile, Table, read_input
from fowtio.read.text import number
from fowtio.site import shipped
from model.design.quantities import LIFE, check_name, level_of
from model.design.space import DIMENSIONS, DesignVariable

SUFFIX = ".opt"
TITLE_RULE = "FOWTIO OPTIMISATION FILE"
METHODS = ("ga", "nsga2", "grid")
TURBINES = ("dtu10mw",)
_COUNTS = ("NStates", "NVariables", "NConstraints", "NStages", "NPublished", "NFrequencies")
_NAMES = (
    "CostFile", "Turbine", "Database", "CostState", "RefAnchorRadius", "RefLineLength", "NoiseLow", "NoiseHigh", "Detail", "Environment",
    "Life", "TowerDiameter", "TowerWall", "Duration", "Polish", *_COUNTS,
)  # fmt: skip
_LIMIT = re.compile(r"(?:([A-Za-z_]\w*)\s*(?:\*\s*(\d[\d.eE+-]*))?|(-?[\d.][\d.eE+-]*))$")


@dataclass(frozen=True, kw_only=True)
class ConstraintEntry:
    """A row of the table of constraints: stage ("all" or its name), quantity, relation, limit: a number times the value of the
    reference or of a stage's optimum (of), None for none.
    """

    stage: str
    quantity: str
    relation: str
    factor: float
    of: str | None
    line: int


@dataclass(frozen=True, kw_only=True)
class Stage:
    """One search: name, space ("reduced:STAGE" for the box around that stage's picks), method, objectives, the stage whose optimum
    they are divided by (None), largest relative objectives of a pick (None), population, generations, crossover fraction, elite
    count, seed.
    """

    name: str
    space: str
    method: str
    objectives: tuple[str, ...]
    relative_to: str | None
    picks: tuple[float, ...] | None
    population: int
    generations: int
    crossover: float
    elite: int
    seed: int
    line: int


@dataclass(frozen=True, eq=False, kw_only=True)
class Published:
    """A design of a publication: name, stage, dimensions (5) [m] (NaN: as the stage's space holds it), values by quantity as printed."""

    name: str
    stage: str
    design: np.ndarray
    values: dict[str, float]


@dataclass(frozen=True, eq=False, kw_only=True)
class FrequencyBand:
    """Frequencies from low to high [Hz], count of them at equal ratios."""

    low: float
    high: float
    count: int


@dataclass(frozen=True, eq=False, kw_only=True)
class OptimisationStudy:
    """An optimisation file read: path, title, cost (what its cost file says), states with their share of the time, spaces of
    variables by name, constraints, stages, published designs to compare with, frequency bands, fatigue settings.
    """

    path: Path
    title: str
    cost: dict
    cost_state: str
    database: Path | None
    reference: tuple[float, float | None]
    states: tuple[StateEntry, ...]
    shares: dict[str, float]
    spaces: dict[str, tuple[DesignVariable, ...]]
    constraints: tuple[ConstraintEntry, ...]
    stages: tuple[Stage, ...]
    published: tuple[Published, ...]
    bands: tuple[FrequencyBand, ...]
    detail: str = "D"
    environment: str = "air"
    years: float = 25.0
    section: tuple[float, float] | None = None
    duration: float = 3600.0
    polish: bool = True

    def stage(self, name: str) -> Stage:
        """Return a stage by its name; raise KeyError."""
        return next(s for s in self.stages if s.name == name)


DEFAULT_BANDS = tuple(
    FrequencyBand(low=low, high=high, count=count)
    for low, high, count in (
        (0.0005, 0.003, 8), (0.0032, 0.03, 70), (0.0305, 0.075, 60), (0.077, 0.25, 24), (0.256, 0.4, 12), (0.404, 0.6, 36), (0.61, 1.0, 12)
    )
)  # fmt: skip


def load_optimisation(name: str | Path) -> OptimisationStudy:
    """Return an optimisation study from its file, or by the name of one that comes with fowtio.

    Raises CaseError with every problem of the file at once, FormatError when it cannot be read at all.
    """
    path = shipped(name, SUFFIX, "optimisation file")
    source = read_input(path)
    if TITLE_RULE not in source.lines[0].upper():
        raise FormatError(path, 1, expected=f"'--- {TITLE_RULE} ---'", found=source.lines[0])
    source = without_rows(source, _COUNTS)
    problems = Problems(source)
    check_names(source, problems, _NAMES, _COUNTS)
    check_row_counts(source, problems, _COUNTS)
    states = problems.get(lambda: read_states(source, problems), ())
    if not states and not problems.found:
        problems.add("the file names no states (NStates)")
    names = [s.name for s in states]
    stages = problems.get(lambda: _stages(source, problems), ())
    settings = problems.get(lambda: _numbers(source, problems), {})
    study = OptimisationStudy(
        path=path, title=source.lines[1].strip() if len(source.lines) > 1 else path.stem, cost=problems.get(lambda: _cost(source), {}),
        cost_state=source.text("CostState", names[0] if names else ""), database=problems.get(lambda: _database(source)),
        states=states, shares=problems.get(lambda: _shares(source, problems), {}), spaces=problems.get(lambda: _spaces(source, problems), {}),
        constraints=problems.get(lambda: _constraints(source, problems), ()), stages=stages,
        published=problems.get(lambda: _published(source, problems, names), ()), bands=problems.get(lambda: _bands(source, problems), DEFAULT_BANDS),
        **settings,
    )  # fmt: skip
    _check(study, source, problems)
    problems.raise_all()
    return study


def _cost(source: InputFile) -> dict:
    text = source.text("CostFile")
    beside = source.path.parent / text
    try:
        return cost_settings(beside if beside.is_file() else text)
    except FowtioError as error:
        raise FormatError(source.path, source.line("CostFile"), expected="a cost file that can be read", found=text, hint=str(error)) from None


def _database(source: InputFile) -> Path | None:
    return None if source.is_default("Database") else source.file("Database")


def _numbers(source: InputFile, problems: Problems) -> dict:
    """Return the single values of the file."""
    turbine = source.text("Turbine", TURBINES[0]).lower()
    if turbine not in TURBINES:
        problems.add(f"Turbine is {turbine!r}, expected one of {', '.join(TURBINES)}", source.line("Turbine"))
    given = [not source.is_default(n) for n in ("TowerDiameter", "TowerWall")]
    if given[0] != given[1]:
        problems.add("give TowerDiameter and TowerWall of the tower base, or neither")
    out = {
        "reference": (source.number("RefAnchorRadius"), None if source.is_default("RefLineLength") else source.number("RefLineLength")),
        "detail": source.text("Detail", "D"), "environment": source.text("Environment", "air").lower(), "years": source.number("Life", 25.0),
        "section": (source.number("TowerDiameter"), source.number("TowerWall")) if all(given) else None,
        "duration": source.number("Duration", 3600.0), "polish": source.flag("Polish", True),
    }  # fmt: skip
    for name, value in (("Life", out["years"]), ("Duration", out["duration"]), ("RefAnchorRadius", out["reference"][0])):
        if not value > 0:
            problems.add(f"{name} is {value:g}, expected a number above zero", source.line(name))
    return out


def _shares(source: InputFile, problems: Problems) -> dict[str, float]:
    """Return the share of the time of every state that has one."""
    table = source.table("NStates")
    if "share" not in [c.lower() for c in table.columns]:
        return {}
    out = {}
    for name, text, line in zip(table.column("Name"), table.column("Share"), table.numbers_of_lines, strict=True):
        if text == "-":
            continue
        value = _number(text, f"state {name!r}: Share", line, problems)
        if value is not None and not 0 <= value <= 1:
            problems.add(f"state {name!r}: Share is {value:g}, expected a fraction of the time from 0 to 1", line)
        out[name] = value
    return out


def _spaces(source: InputFile, problems: Problems) -> dict[str, tuple[DesignVariable, ...]]:
    table = source.table("NVariables")
    out: dict[str, list[DesignVariable]] = {}
    columns = {c: table.column(c) for c in ("Space", "Variable", "RelativeTo")} | {c: table.numbers(c) for c in ("Lower", "Upper", "Spacing")}
    for k, line in enumerate(table.numbers_of_lines):
        row = {name: values[k] for name, values in columns.items()}
        name, of = row["Variable"], None if row["RelativeTo"] == "-" else row["RelativeTo"]
        for what, value in (("Variable", name), *((("RelativeTo", of),) if of else ())):
            if value not in DIMENSIONS:
                near = difflib.get_close_matches(str(value), DIMENSIONS, n=1)
                problems.add(f"{what} is {value!r}" + (f"; did you mean {near[0]}?" if near else f", expected one of {', '.join(DIMENSIONS)}"), line)
        low, high, step = (float(row[c]) for c in ("Lower", "Upper", "Spacing"))
        if not step > 0 or high < low or abs((high - low) / step - round((high - low) / step)) > 1e-6:
            problems.add(f"{name}: from {low:g} to {high:g} in steps of {step:g} is no whole number of steps", line)
        variable = DesignVariable(name=name, lower=low, upper=high, spacing=step if step > 0 else 1.0, relative_to=of)
        if any(v.name == name for v in out.get(row["Space"], [])):
            problems.add(f"{name} stands twice in space {row['Space']!r}", line)
        out.setdefault(row["Space"], []).append(variable)
    return {name: tuple(variables) for name, variables in out.items()}


def _constraints(source: InputFile, problems: Problems) -> tuple[ConstraintEntry, ...]:
    if not source.has("NConstraints"):
        return ()
    table = source.table("NConstraints")
    out = []
    for row, line in _rows(table, ("Stage", "Quantity", "Relation", "Limit")):
        found = _LIMIT.match(row["Limit"])
        if row["Relation"] not in ("<=", ">="):
            problems.add(f"Relation is {row['Relation']!r}, expected <= or >=", line)
        if found is None:
            problems.add(f"Limit is {row['Limit']!r}, expected a number, reference, reference*0.98, or STAGE*1.15", line)
            continue
        of, factor, plain = found.groups()
        value = _number(plain or factor or "1", "Limit", line, problems)
        out.append(ConstraintEntry(stage=row["Stage"], quantity=row["Quantity"], relation=row["Relation"], factor=value or 0.0, of=of, line=line))
    return tuple(out)


def _stages(source: InputFile, problems: Problems) -> tuple[Stage, ...]:
    table = source.table("NStages")
    out = []
    wanted = ("Stage", "Space", "Method", "Objectives", "RelativeTo", "Picks", "Population", "Generations", "Crossover", "Elite", "Seed")
    for row, line in _rows(table, wanted):
        numbers = {c: _number(row[c], f"stage {row['Stage']!r}: {c}", line, problems) for c in wanted[6:] if row[c] != "-"}
        picks = None if row["Picks"] == "-" else tuple(_number(t, "Picks", line, problems) for t in row["Picks"].split())
        objectives = tuple(row["Objectives"].split())
        if row["Method"] not in METHODS:
            problems.add(f"Method is {row['Method']!r}, expected one of {', '.join(METHODS)}", line)
        if (len(objectives) > 1) != (row["Method"] == "nsga2"):
            problems.add(f"stage {row['Stage']!r}: {len(objectives)} objectives with method {row['Method']}; ga and grid take one, nsga2 two or more", line)
        if picks is not None and len(picks) != len(objectives):
            problems.add(f"stage {row['Stage']!r}: Picks needs one number for each of the {len(objectives)} objectives", line)
        crossover, elite, population = numbers.get("Crossover", 0.8), numbers.get("Elite", 1), numbers.get("Population", 200)
        if crossover is not None and not 0 <= crossover <= 1:
            problems.add(f"stage {row['Stage']!r}: Crossover is {crossover:g}, expected a fraction from 0 to 1", line)
        if None not in (elite, population) and not 0 <= elite < population:
            problems.add(f"stage {row['Stage']!r}: Elite is {elite:g} of a population of {population:g}", line)
        whole = {k: int(numbers.get(k.title()) or d) for k, d in (("population", 200), ("generations", 4), ("elite", 0), ("seed", 1))}
        out.append(Stage(
            name=row["Stage"], space=row["Space"], method=row["Method"], objectives=objectives, picks=picks, line=line,
            relative_to=None if row["RelativeTo"] == "-" else row["RelativeTo"], crossover=crossover or 0.0, **whole,
        ))  # fmt: skip
    if not out:
        problems.add("the file names no stages (NStages)")
    return tuple(out)


def _published(source: InputFile, problems: Problems, states) -> tuple[Published, ...]:
    if not source.has("NPublished"):
        return ()
    table = source.table("NPublished")
    known = ("Name", "Stage", *DIMENSIONS)
    quantities = [c for c in table.columns if c.lower() not in [k.lower() for k in known]]
    for c in quantities:
        wrong = check_name(c, states)
        if wrong:
            problems.add(f"published designs: {wrong}", source.line("NPublished") + 1)
    out = []
    for row, line in _rows(table, (*known, *quantities)):
        design = [np.nan if row[d] == "-" else _number(row[d], d, line, problems) for d in DIMENSIONS]
        values = {q: _number(row[q], q, line, problems) for q in quantities if row[q] != "-"}
        out.append(Published(name=row["Name"], stage=row["Stage"], design=np.array(design, dtype=float), values=values))
    return tuple(out)


def _bands(source: InputFile, problems: Problems) -> tuple[FrequencyBand, ...]:
    if not source.has("NFrequencies"):
        return DEFAULT_BANDS
    out, last = [], 0.0
    for row, line in _rows(source.table("NFrequencies"), ("Low", "High", "Count")):
        low, high, count = (_number(row[c], c, line, problems) for c in ("Low", "High", "Count"))
        if None in (low, high, count) or not last < low < high or count < 2:
            problems.add("frequency bands need Low < High, Count of 2 or more, each band above the one before", line)
            continue
        out.append(FrequencyBand(low=low, high=high, count=int(count)))
        last = high
    return tuple(out) or DEFAULT_BANDS


def _rows(table: Table, columns) -> list[tuple[dict[str, str], int]]:
    """Return the rows of a table as dictionaries with their lines; raise FormatError for a column that is not there."""
    found = {c: table.column(c) for c in columns}
    return [({c: v[k].strip("\"'") for c, v in found.items()}, line) for k, line in enumerate(table.numbers_of_lines)]


def _number(text: str, what: str, line: int, problems: Problems) -> float | None:
    try:
        return number(text)
    except ValueError:
        problems.add(f"{what} is {text!r}, expected a number", line)
        return None


def _check(study: OptimisationStudy, source: InputFile, problems: Problems) -> None:
    """Note what only shows when the parts are seen together."""
    states, stages = [s.name for s in study.states], [s.name for s in study.stages]
    if study.cost_state not in states and states:
        problems.add(f"CostState is {study.cost_state!r}; states are {', '.join(states)}", source.line("CostState") if source.has("CostState") else None)
    for k, stage in enumerate(study.stages):
        before = stages[:k]
        for text in stage.objectives:
            _note(check_name(text, states), f"stage {stage.name!r}", stage.line, problems)
        _check_life(stage.objectives, study, stage.line, problems)
        kind, _, of = stage.space.partition(":")
        if kind == "reduced" and of not in before:
            problems.add(f"stage {stage.name!r}: space is reduced from {of!r}, which is no stage before it", stage.line)
        elif kind != "reduced" and stage.space not in study.spaces:
            problems.add(f"stage {stage.name!r}: no space {stage.space!r} in the table of variables; there are {', '.join(study.spaces)}", stage.line)
        if stage.relative_to is not None and stage.relative_to not in (*before, "reference"):
            problems.add(f"stage {stage.name!r}: RelativeTo is {stage.relative_to!r}, expected reference or a stage before it", stage.line)
        if stages.index(stage.name) != k:
            problems.add(f"two stages are named {stage.name!r}", stage.line)
    for c in study.constraints:
        _note(check_name(c.quantity, states), "constraint", c.line, problems)
        _check_life((c.quantity,), study, c.line, problems)
        if c.stage != "all" and c.stage not in stages:
            problems.add(f"constraint on {c.quantity}: no stage {c.stage!r}; there are {', '.join(stages)}, or all", c.line)
        if c.of is not None and c.of not in ("reference", *stages):
            problems.add(f"constraint on {c.quantity}: Limit names {c.of!r}, expected reference or a stage", c.line)
    for name in study.shares:
        if name not in states:
            problems.add(f"Share of an unknown state {name!r}")


def _check_life(names, study: OptimisationStudy, line: int, problems: Problems) -> None:
    if any(check_name(n, [s.name for s in study.states]) is None and level_of(n) == LIFE for n in names) and not any(study.shares.values()):
        problems.add("damage needs states with a Share of the time", line)


def _note(wrong: str | None, where: str, line: int, problems: Problems) -> None:
    if wrong:
        problems.add(f"{where}: {wrong}", line)

