"""The cost file (.cost): hulls, moorings and prices; what each design costs, item by item, with its anchors."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np

from fowtio.errors import CaseError, FormatError, Problem
from fowtio.read.openfast_input import InputFile, read_input
from fowtio.site import shipped
from model.design.anchors import (
    DRAG_SOILS,
    PILE_SOILS,
    SAFETY,
    Anchor,
    SpreadLine,
    SpreadState,
    drag_anchor,
    spread_under_thrust,
    suction_pile,
)
from model.design.cost import (
    CostItem,
    PlateLayout,
    Plating,
    Prices,
    Semisubmersible,
    ballast_mass,
    cost_items,
    displaced_volume,
    hull_plating,
    total_cost,
)

SUFFIX = ".cost"
TITLE_RULE = "FOWTIO COST FILE"
STEEL_DENSITY = 7850.0
_HULL = {
    "MainDiameter": "main_diameter",
    "MainFreeboard": "main_freeboard",
    "NColumns": "columns",
    "ColumnFreeboard": "column_freeboard",
    "PlateHeight": "plate_height",
    "PlateDiameter": "plate_diameter",
    "BraceDiameter": "brace_diameter",
    "ColumnWall": "column_wall",
    "MainWall": "main_wall",
    "BraceWall": "brace_wall",
}
_PRICES = {
    "PriceSteel": "steel",
    "PriceConcrete": "concrete",
    "PriceLabour": "labour",
    "PriceChain": "chain",
    "PriceWire": "wire",
    "PriceDragAnchor": "drag_anchor",
    "PricePile": "pile",
    "PricePaint": "paint",
}
_SITE = {"WaterDepth": None, "WaterDensity": 1025.0, "Gravity": 9.80665, "TurbineMass": None, "Thrust": None}
_LINE = {"LineMass": None, "LineStiffness": None, "LineVolume": "steel"}
_OTHER = {"PlateLength": 10.0, "PlateWidth": 4.0, "Difficulty": 1.0, "AnchorSafety": SAFETY, "HangingShare": 0.15}
_WORDS = ("Line", "Anchor", "Soil")
_NAMES = (*_HULL, *_PRICES, *_SITE, *_LINE, *_OTHER, *_WORDS, "NDesigns")
_COLUMNS = ("Name", "ColumnDiameter", "Radius", "Draft", "AnchorRadius", "LineLength")


@dataclass(frozen=True, eq=False, kw_only=True)
class DesignCost:
    """One design: name, hull, its plating, the upwind line under the thrust, the anchor, ballast [kg], the account."""

    name: str
    hull: Semisubmersible
    plating: tuple[Plating, ...]
    spread: SpreadState
    anchor: Anchor
    ballast: float
    items: tuple[CostItem, ...]

    @property
    def total(self) -> float:
        """Cost [EUR]."""
        return total_cost(self.items)


@dataclass(frozen=True, eq=False, kw_only=True)
class CostStudy:
    """The designs of a cost file: path, title, designs, thrust [N] they stand under, kind of line."""

    path: Path
    title: str
    designs: tuple[DesignCost, ...]
    thrust: float
    line: str


def cost_study(name: str | Path) -> CostStudy:
    """Return the cost of every design of a cost file, or of one that comes with fowtio by its name.

    Raises CaseError with everything wrong at once, designs that cannot be among them; FormatError when the file cannot
    be read at all.
    """
    path = shipped(name, SUFFIX, "cost file")
    source = read_input(path)
    if TITLE_RULE not in source.lines[0].upper():
        raise FormatError(path, 1, expected=f"'--- {TITLE_RULE} ---'", found=source.lines[0])
    problems: list[Problem] = []
    _check_names(source, problems)
    settings = _settings(source, problems)
    designs = []
    if not problems:
        table = source.table("NDesigns")
        names, numbers = table.column("Name"), [table.numbers(c) for c in _COLUMNS[1:]]
        for k, line in enumerate(table.numbers_of_lines):
            try:
                designs.append(_design(names[k], [float(column[k]) for column in numbers], settings))
            except ValueError as error:
                problems.append(Problem(f"design {names[k]!r}: {error}", path, line))
    if problems:
        raise CaseError(list(dict.fromkeys(problems)))
    title = source.lines[1].strip() if len(source.lines) > 1 else path.stem
    return CostStudy(path=path, title=title, designs=tuple(designs), thrust=settings["Thrust"], line=settings["Line"])


def cost_settings(name: str | Path) -> dict:
    """Return what a cost file says above its table: hull dimensions, site, line, anchor, prices; raise as `cost_study`."""
    path = shipped(name, SUFFIX, "cost file")
    source, problems = read_input(path), []
    if TITLE_RULE not in source.lines[0].upper():
        raise FormatError(path, 1, expected=f"'--- {TITLE_RULE} ---'", found=source.lines[0])
    _check_names(source, problems)
    settings = _settings(source, problems)
    if problems:
        raise CaseError(list(dict.fromkeys(problems)))
    return settings


def _design(name: str, values: Sequence[float], settings: dict) -> DesignCost:
    """Return the cost of one row of the table; raise ValueError for what cannot be built or held."""
    diameter, radius, draft, anchor_radius, length = values
    hull = Semisubmersible(column_diameter=diameter, radius=radius, draft=draft, **settings["hull"])
    plating = hull_plating(hull)
    mass = settings["LineMass"]
    volume = mass / STEEL_DENSITY if settings["LineVolume"] is None else settings["LineVolume"]
    weight = (mass - settings["WaterDensity"] * volume) * settings["Gravity"]
    spread = spread_under_thrust(
        SpreadLine(
            count=hull.columns,
            anchor_radius=anchor_radius,
            fairlead_radius=hull.fairlead_radius,
            fairlead_height=settings["WaterDepth"] - hull.fairlead_depth,
            length=length,
            weight=weight,
            stiffness=settings["LineStiffness"],
        ),
        settings["Thrust"],
    )
    make = drag_anchor if settings["Anchor"] == "drag" else suction_pile
    anchor = make(spread.horizontal, max(spread.uplift, 0.0), settings["Soil"], settings["AnchorSafety"])
    lines = hull.columns * length * mass
    hanging = settings["HangingShare"] * hull.columns * length * weight / settings["Gravity"]
    carried = sum(p.mass for p in plating) + settings["TurbineMass"] + hanging
    ballast = ballast_mass(displaced_volume(hull), carried, settings["WaterDensity"])
    items = cost_items(
        plating,
        ballast,
        lines,
        hull.columns * anchor.mass,
        line=settings["Line"],
        anchor=anchor.kind,
        prices=settings["prices"],
        layout=settings["layout"],
    )
    return DesignCost(name=name, hull=hull, plating=plating, spread=spread, anchor=anchor, ballast=ballast, items=items)


def _settings(source: InputFile, problems: list[Problem]) -> dict:
    """Return everything above the table, defaults filled in; note what is wrong."""

    def value(name: str, default):
        try:
            out = source.number(name) if default is None else source.number(name, default)
        except FormatError as error:
            problems.append(Problem(str(error)))
            return 1.0
        if not (out > 0 or (name == "HangingShare" and out == 0)):
            problems.append(Problem(f"{name} is {out:g}, expected a number above zero", source.path, source.line(name)))
        return out

    hull_defaults = {f.name: f.default for f in fields(Semisubmersible)}
    hull = {}
    for name, attribute in _HULL.items():
        if not source.is_default(name):
            found = value(name, None)
            hull[attribute] = round(found) if attribute == "columns" else found
        elif attribute not in hull_defaults:
            problems.append(Problem(f"{name} is missing", source.path))
    prices = Prices(**{a: value(n, None) for n, a in _PRICES.items() if not source.is_default(n)})
    out = {name: value(name, default) for name, default in (_SITE | _OTHER).items()}
    out |= {name: value(name, None) for name in ("LineMass", "LineStiffness")}
    out["LineVolume"] = None if source.is_default("LineVolume") else value("LineVolume", None)
    out["Line"] = _word(source, "Line", ("chain", "wire"), "chain", problems)
    out["Anchor"] = _word(source, "Anchor", ("drag", "pile"), "drag", problems)
    soils = tuple(DRAG_SOILS if out["Anchor"] == "drag" else PILE_SOILS)
    out["Soil"] = _word(source, "Soil", soils, soils[0], problems)
    out["layout"] = PlateLayout(length=out["PlateLength"], width=out["PlateWidth"], difficulty=out["Difficulty"])
    return out | {"hull": hull, "prices": prices}


def _word(source: InputFile, name: str, known: Sequence[str], default: str, problems: list[Problem]) -> str:
    if source.is_default(name):
        return default
    text = source.text(name).lower()
    if text not in known:
        near = difflib.get_close_matches(text, known, n=1)
        hint = f"; did you mean {near[0]}?" if near else f", expected one of {', '.join(known)}"
        problems.append(Problem(f"{name} is {text!r}{hint}", source.path, source.line(name)))
        return default
    return text


def _check_names(source: InputFile, problems: list[Problem]) -> None:
    """Note every name of the file that fowtio does not know, with the nearest that it does."""
    known = {n.lower(): n for n in _NAMES}
    last = source.line("NDesigns")
    for key, (line, _, written) in source.entries.items():
        if key not in known and line <= last:
            near = difflib.get_close_matches(key, known, n=1)
            hint = f"; did you mean {known[near[0]]}?" if near else f"; known names are {', '.join(_NAMES)}"
            problems.append(Problem(f"unknown name {written}{hint}", source.path, line))


def ranking(study: CostStudy) -> list[str]:
    """Return the names of the designs, the cheapest first."""
    return [study.designs[k].name for k in np.argsort([d.total for d in study.designs], kind="stable")]
