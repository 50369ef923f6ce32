"""An OpenFAST deck: the primary file (.fst) and every file it names that the model needs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from fowtio.errors import FormatError
from fowtio.read.deck_hydro import deck_hydro as deck_hydro  # part of this module's interface
from fowtio.read.elastodyn import ElastoDyn, read_elastodyn
from fowtio.read.hydrodyn import HydroDyn, ballast, read_hydrodyn
from fowtio.read.inflowwind import InflowWind, read_inflowwind
from fowtio.read.map import map_mooring, read_map
from fowtio.read.moordyn import moordyn_mooring, read_moordyn
from fowtio.read.openfast_input import InputFile, names_in, read_input
from fowtio.read.registry import Format
from fowtio.read.seastate import DeckSea, deck_sea
from model.system.mooring import MooringSystem
from model.system.turbine import RigidBody

STANDARD_GRAVITY = 9.80665  # m/s2; for an ElastoDyn file read without its primary file
_MODULES = {
    "NRotors": ({}, {1}),
    "CompElast": ({3: "simplified ElastoDyn"}, {1, 2}),
    "CompSub": ({1: "SubDyn", 2: "ExtPtfm"}, {0}),
    "CompHydro": ({}, {0, 1}),
    "CompIce": ({1: "IceFloe", 2: "IceDyn"}, {0}),
    "MHK": ({1: "fixed", 2: "floating"}, {0}),
}
_MOORINGS = {0: "none", 1: "MAP++", 2: "FEAMooring", 3: "MoorDyn", 4: "OrcaFlex"}


@dataclass(frozen=True, eq=False, kw_only=True)
class Deck:
    """What an OpenFAST deck says: the environment, the turbine (ElastoDyn), the water (None on land), the moorings.

    gravity [m/s2], air_density and density [kg/m3], depth [m]; wind_speed [m/s] of a steady InflowWind, else None;
    inflow is all that InflowWind says (None without it). The platform of elastodyn.structure holds the ballast of
    filled members. notes say what of the deck is simplified.
    """

    path: Path
    title: str
    gravity: float
    air_density: float
    density: float
    depth: float
    elastodyn: ElastoDyn
    hydrodyn: HydroDyn | None
    sea: DeckSea | None
    mooring: MooringSystem | None
    mooring_path: Path | None
    wind_speed: float | None
    aerodynamics: bool
    files: tuple[Path, ...]
    inflow: InflowWind | None = None
    notes: tuple[str, ...] = ()

    @property
    def has_drag(self) -> bool:
        """Whether any Morison member of the deck has drag."""
        return self.hydrodyn is not None and bool(
            np.any(self.hydrodyn.members.drag_coefficient) or np.any(self.hydrodyn.members.plate_coefficient)
        )


def read_deck(path: str | Path) -> Deck:
    """Return an OpenFAST deck of version 2 to 5, following the files of its primary file that the model needs.

    AeroDyn's and ServoDyn's files are not opened and need not be there. Hydrodynamic coefficients are not read here
    (`deck_hydro` does), because a study may name others. Raises FormatError.
    """
    path = Path(path)
    primary = read_input(path)
    if not primary.has("EDFile"):
        raise FormatError(path, expected="an OpenFAST primary file (.fst) with EDFile", found="none")
    for name, (known, allow) in _MODULES.items():
        _refuse(primary, name, known, allow)
    errors = _Errors()
    gravity, elastodyn = errors.get(lambda: _turbine(primary), (STANDARD_GRAVITY, None))
    hydrodyn, sea, wet_files = errors.get(lambda: _water_modules(primary), (None, None, []))
    depth, density = errors.get(lambda: _water(primary, sea), (np.inf, 1025.0))
    mooring, mooring_path = errors.get(lambda: _mooring(primary, depth, gravity, density, errors), (None, None))
    inflow = errors.get(lambda: _inflow(primary))
    errors.raise_all()
    if hydrodyn is not None:
        elastodyn = _with_ballast(elastodyn, ballast(hydrodyn, density))
    files = [path, *elastodyn.files, *wet_files, mooring_path, inflow.path if inflow else None]
    notes = hydrodyn.notes if hydrodyn is not None else ()
    if primary.integer("CompElast", 1) == 2:
        notes = (*notes, "blades of BeamDyn: their mass is taken from ElastoDyn's blade file")
    return Deck(
        path=path,
        title=primary.lines[1].strip() if len(primary.lines) > 1 else "",
        gravity=gravity,
        air_density=primary.number("AirDens", 1.225),
        density=density,
        depth=depth,
        elastodyn=elastodyn,
        hydrodyn=hydrodyn,
        sea=sea,
        mooring=mooring,
        mooring_path=mooring_path,
        wind_speed=inflow.speed if inflow else None,
        aerodynamics=primary.integer("CompAero", 0) != 0,
        files=tuple(f for f in files if f),
        inflow=inflow,
        notes=notes,
    )


class DeckError(FormatError):
    """Several files of a deck that cannot be read; errors are theirs, path and line those of the first."""

    def __init__(self, errors: list[FormatError]):
        first = errors[0]
        super().__init__(first.path, first.line, first.expected, first.found, first.hint)
        self.errors = tuple(errors)
        self.args = ("\n".join(str(e) for e in errors),)


class _Errors:
    """Collects the errors of the files of a deck, so that all are said at once."""

    def __init__(self):
        self.found: list[FormatError] = []

    def get(self, read: Callable, default=None):
        """Return what read() gives, or the default when it raises FormatError."""
        try:
            return read()
        except FormatError as error:
            self.found.append(error)
            return default

    def raise_all(self) -> None:
        """Raise what was collected, one error as it is."""
        if len(self.found) == 1:
            raise self.found[0]
        if self.found:
            raise DeckError(self.found)


def _turbine(primary: InputFile) -> tuple[float, ElastoDyn]:
    """Return gravity, of the primary file or (OpenFAST 2) of ElastoDyn's, and ElastoDyn."""
    path = primary.file("EDFile")
    gravity = primary.number("Gravity") if primary.has("Gravity") else read_input(path).number("Gravity")
    return gravity, read_elastodyn(path, gravity)


def _inflow(primary: InputFile) -> InflowWind | None:
    return read_inflowwind(primary.file("InflowFile")) if primary.integer("CompInflow", 0) == 1 else None


def _water_modules(primary: InputFile) -> tuple[HydroDyn | None, DeckSea | None, list[Path]]:
    """Return HydroDyn and the sea, of SeaState's file or (up to OpenFAST 3) of HydroDyn's, and the files read."""
    if primary.integer("CompHydro", 0) == 0:
        return None, None, []
    hydrodyn = read_hydrodyn(primary.file("HydroFile"))
    if hydrodyn.input.has("WaveMod"):
        source = hydrodyn.input
    elif primary.has("CompSeaSt") and primary.integer("CompSeaSt") == 1:
        source = read_input(primary.file("SeaStFile"))
    else:
        line = primary.line("CompSeaSt") if primary.has("CompSeaSt") else primary.line("CompHydro")
        raise FormatError(
            primary.path,
            line,
            expected="CompSeaSt 1 with HydroDyn",
            found="no waves in HydroDyn's file and no SeaState",
        )
    sea = deck_sea(source)
    level = sea.level_offset or (primary.number("MSL2SWL", 0.0) if primary.has("MSL2SWL") else 0.0)
    if level != 0:
        where = source if sea.level_offset else primary
        raise FormatError(
            where.path,
            where.line("MSL2SWL"),
            expected="MSL2SWL 0",
            found=f"{level:g}",
            hint="Heights are from still water here",
        )
    return hydrodyn, sea, list(dict.fromkeys([hydrodyn.path, source.path]))


def _with_ballast(elastodyn: ElastoDyn, body: RigidBody | None) -> ElastoDyn:
    """Return the deck with a body added to its platform."""
    if body is None:
        return elastodyn
    platform = elastodyn.structure.platform
    mass = platform.mass + body.mass
    centre = (platform.mass * platform.centre + body.mass * body.centre) / mass
    inertia = np.zeros((3, 3))
    for part in (platform, body):
        arm = part.centre - centre
        inertia += part.inertia + part.mass * ((arm @ arm) * np.eye(3) - np.outer(arm, arm))
    joint = RigidBody(mass=mass, centre=centre, inertia=inertia)
    return replace(elastodyn, structure=replace(elastodyn.structure, platform=joint))


def _water(primary: InputFile, sea: DeckSea | None) -> tuple[float, float]:
    """Return depth and density: the sea's own when given, else the primary file's."""
    depth = (
        sea.depth
        if sea is not None and sea.depth is not None
        else primary.number("WtrDpth", None)
        if primary.has("WtrDpth")
        else None
    )
    density = (
        sea.density
        if sea is not None and sea.density is not None
        else primary.number("WtrDens", None)
        if primary.has("WtrDens")
        else None
    )
    if sea is not None and (depth is None or density is None):
        raise FormatError(
            primary.path, expected="WtrDens and WtrDpth in the primary or the sea's file", found="DEFAULT in both"
        )
    return depth if depth is not None else np.inf, density if density is not None else 1025.0


def _mooring(primary: InputFile, depth, gravity, density, errors) -> tuple[MooringSystem | None, Path | None]:
    """Return the mooring system and its file; without the water, which an error of another file hides, only its form is read."""
    kind = primary.integer("CompMooring", 0)
    if kind == 0:
        return None, None
    if kind not in (1, 3):
        name = _MOORINGS.get(kind, "unknown")
        raise FormatError(
            primary.path,
            primary.line("CompMooring"),
            expected="MAP++ (1), MoorDyn (3) or none (0)",
            found=f"{kind} ({name})",
        )
    path = primary.file("MooringFile")
    if errors.found:
        (read_map if kind == 1 else read_moordyn)(path)
        return None, path
    if kind == 1:
        return map_mooring(read_map(path), depth=depth, gravity=gravity, density=density), path
    return moordyn_mooring(read_moordyn(path), depth=depth, gravity=gravity, density=density), path


def _refuse(primary: InputFile, name: str, known: dict, allow: set) -> None:
    if primary.has(name) and primary.integer(name) not in allow:
        value = primary.integer(name)
        raise FormatError(
            primary.path,
            primary.line(name),
            expected=f"{name} in {sorted(allow)}",
            found=f"{value} ({known.get(value, 'unknown')})",
            hint="fowtio models a rigid floater with the turbine that ElastoDyn describes",
        )


# --- formats ----------------------------------------------------------------------------------------------------------


def _with(*names: str):
    """Return a function that tells an input file by names it must give."""
    return lambda path, head: {n.lower() for n in names} <= names_in(head)


def _describe_deck(deck: Deck) -> list[tuple[str, str]]:
    sea = deck.sea.sea if deck.sea else None
    wave = "none" if sea is None else f"{sea.kind}, Hs {sea.significant_height}, Tp {sea.peak_period}"
    return [
        ("title", deck.title),
        (
            "environment",
            f"gravity {deck.gravity:g} m/s2, air {deck.air_density:g} kg/m3, water {deck.density:g} kg/m3, depth {deck.depth:g} m",
        ),
        *_describe_elastodyn(deck.elastodyn),
        *(_describe_hydrodyn(deck.hydrodyn) if deck.hydrodyn else [("hydrodynamics", "none")]),
        ("sea", wave),
        ("wind", f"{deck.inflow.kind}, {deck.inflow.speed} m/s" if deck.inflow else "none"),
        ("moorings", f"{len(deck.mooring.line_names)} lines ({deck.mooring_path.name})" if deck.mooring else "none"),
        ("files", ", ".join(f.name for f in deck.files)),
    ]


def _deck_problems(deck: Deck) -> list[str]:
    """Return what of the deck is simplified."""
    return [f"simplified: {note}" for note in deck.notes]


def _describe_elastodyn(deck: ElastoDyn) -> list[tuple[str, str]]:
    s = deck.structure
    return [
        ("degrees of freedom", ", ".join(deck.dofs) or "none"),
        ("tower", f"{s.tower.base_height:g} to {s.tower.top_height:g} m, hub at {s.hub_height:.4g} m"),
        ("rotor", f"{s.rotor.blades} blades, diameter {s.rotor.diameter:.4g} m"),
        ("platform", f"{s.platform.mass:.6g} kg, centre ({', '.join(f'{v:g}' for v in s.platform.centre)}) m"),
    ]


def _describe_hydrodyn(deck: HydroDyn) -> list[tuple[str, str]]:
    return [
        (
            "potential flow",
            f"{deck.coefficients.name}, length {deck.length_scale:g} m, volume {deck.volume:g} m3"
            if deck.potential_flow
            else "none",
        ),
        (
            "members",
            f"{len(deck.members.names)}, end plates {len(deck.members.plate_coefficient)}, filled {sum(len(f.members) for f in deck.fillings)}",
        ),
        (
            "added matrices",
            ", ".join(n for n in ("preload", "stiffness", "damping", "quadratic_damping") if np.any(getattr(deck, n)))
            or "none",
        ),
    ]


def _describe_sea(sea: DeckSea) -> list[tuple[str, str]]:
    s = sea.sea
    kind = f"WaveMod {sea.wave_model}" + (
        ", not modelled" if s is None else f", {s.kind}, Hs {s.significant_height}, Tp {s.peak_period}"
    )
    return [
        ("sea", kind),
        ("current", "steady" if sea.current else "none"),
        ("depth", f"{sea.depth} m" if sea.depth else "of the primary file"),
    ]


def _describe_inflow(wind: InflowWind) -> list[tuple[str, str]]:
    return [
        ("wind", wind.kind),
        ("speed", f"{wind.speed:g} m/s" if wind.speed is not None else "in its files"),
        ("direction", f"{wind.direction:g} deg"),
    ]


OPENFAST_DECK = Format(
    name="OpenFAST deck (.fst)", recognises=_with("EDFile", "CompElast"), read=read_deck, describe=_describe_deck,
    problems=_deck_problems,
)  # fmt: skip
ELASTODYN = Format(
    name="ElastoDyn input file",
    recognises=_with("TwrFile", "PtfmMass"),
    read=lambda path: read_elastodyn(path, STANDARD_GRAVITY),
    describe=_describe_elastodyn,
)
HYDRODYN = Format(
    name="HydroDyn input file", recognises=_with("NJoints", "NMembers"), read=read_hydrodyn, describe=_describe_hydrodyn
)
SEASTATE = Format(
    name="SeaState input file",
    recognises=_with("WaveMod", "WaveHs"),
    read=lambda path: deck_sea(read_input(path)),
    describe=_describe_sea,
)
INFLOWWIND = Format(
    name="InflowWind input file",
    recognises=_with("WindType", "HWindSpeed"),
    read=read_inflowwind,
    describe=_describe_inflow,
)
