"""An OpenFAST deck: the primary file (.fst) and every file it names that the model needs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fowtio.errors import FormatError
from fowtio.read.elastodyn import ElastoDyn, read_elastodyn
from fowtio.read.hydrodyn import HydroDyn, read_hydrodyn
from fowtio.read.map import map_mooring, read_map
from fowtio.read.openfast_input import InputFile, read_input
from fowtio.read.seastate import DeckSea, deck_sea
from fowtio.read.wamit import read_wamit
from model.system.hydro import HydroCoefficients
from model.system.mooring import MooringSystem

_MOORINGS = {0: "none", 1: "MAP++", 2: "FEAMooring", 3: "MoorDyn", 4: "OrcaFlex"}


@dataclass(frozen=True, eq=False, kw_only=True)
class Deck:
    """What an OpenFAST deck says: the environment, the turbine (ElastoDyn), the water (None on land), the moorings.

    gravity [m/s2], air_density and density [kg/m3], depth [m]; linearised tells whether the deck makes .lin files;
    wind_speed [m/s] of a steady InflowWind, else None.
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

    @property
    def has_drag(self) -> bool:
        """Whether any Morison member of the deck has drag."""
        return self.hydrodyn is not None and bool(
            np.any(self.hydrodyn.members.drag_coefficient) or np.any(self.hydrodyn.members.plate_coefficient)
        )


def read_deck(path: str | Path) -> Deck:
    """Return an OpenFAST deck, following every file that its primary file names; raise FormatError.

    Hydrodynamic coefficients are not read here (`deck_hydro` does), because a study may name others.
    """
    path = Path(path)
    primary = read_input(path)
    if not primary.has("EDFile"):
        raise FormatError(path, expected="an OpenFAST primary file (.fst) with EDFile", found="none")
    _refuse(primary, "CompElast", {1: "ElastoDyn"}, allow={1, 2})
    _refuse(primary, "CompSub", {1: "SubDyn", 2: "ExtPtfm"}, allow={0})
    gravity = primary.number("Gravity", None) if primary.has("Gravity") else None
    elasto_path = _named(primary, "EDFile")
    if gravity is None:
        gravity = read_input(elasto_path).number("Gravity")
    elastodyn = read_elastodyn(elasto_path, gravity)
    files = [path, *elastodyn.files]
    hydrodyn = sea = None
    if primary.integer("CompHydro", 0) == 1:
        hydrodyn = read_hydrodyn(_named(primary, "HydroFile"))
        files.append(hydrodyn.path)
        with_seastate = primary.has("CompSeaSt") and primary.integer("CompSeaSt") == 1
        source = read_input(_named(primary, "SeaStFile")) if with_seastate else hydrodyn.input
        files += [source.path] if with_seastate else []
        sea = deck_sea(source)
    depth, density = _water(primary, sea)
    mooring, mooring_path = _mooring(primary, depth, gravity, density)
    files += [mooring_path] if mooring_path else []
    wind, inflow_path = _wind(primary)
    files += [inflow_path] if inflow_path else []
    return Deck(
        path=path, title=primary.lines[1].strip() if len(primary.lines) > 1 else "", gravity=gravity,
        air_density=primary.number("AirDens", 1.225), density=density, depth=depth, elastodyn=elastodyn, hydrodyn=hydrodyn,
        sea=sea, mooring=mooring, mooring_path=mooring_path, wind_speed=wind,
        aerodynamics=primary.integer("CompAero", 0) != 0, files=tuple(files),
    )  # fmt: skip


def deck_hydro(deck: Deck, stem: Path | None = None) -> HydroCoefficients:
    """Return the hydrodynamic coefficients that the deck's HydroDyn names, or those of another stem, with its scales.

    The displaced volume and centre of buoyancy come from HydroDyn (PtfmVol0); raise FormatError.
    """
    from dataclasses import replace

    if deck.hydrodyn is None or not deck.hydrodyn.potential_flow:
        raise FormatError(deck.path, expected="a deck with HydroDyn and PotMod 1", found="none", hint="Name HydroFile in the study")
    length = deck.hydrodyn.length_scale if stem is None else 1.0
    hydro = read_wamit(stem or deck.hydrodyn.coefficients, length=length, density=deck.density, gravity=deck.gravity, depth=deck.depth)
    cob = np.append(deck.hydrodyn.centre_of_buoyancy, 0.0)
    return replace(hydro, volume=deck.hydrodyn.volume, centre_of_buoyancy=cob)


def _water(primary: InputFile, sea: DeckSea | None) -> tuple[float, float]:
    """Return depth and density: the sea's own when given, else the primary file's."""
    depth = sea.depth if sea is not None and sea.depth is not None else primary.number("WtrDpth", None) if primary.has("WtrDpth") else None
    density = sea.density if sea is not None and sea.density is not None else primary.number("WtrDens", None) if primary.has("WtrDens") else None
    if sea is not None and (depth is None or density is None):
        raise FormatError(primary.path, expected="WtrDens and WtrDpth in the primary or the sea's file", found="DEFAULT in both")
    return depth if depth is not None else np.inf, density if density is not None else 1025.0


def _mooring(primary: InputFile, depth, gravity, density) -> tuple[MooringSystem | None, Path | None]:
    kind = primary.integer("CompMooring", 0)
    if kind == 0:
        return None, None
    path = _named(primary, "MooringFile")
    if kind == 1:
        return map_mooring(read_map(path), depth=depth, gravity=gravity, density=density), path
    name = _MOORINGS.get(kind, str(kind))
    raise FormatError(primary.path, primary.line("CompMooring"), expected="MAP++ (1) or none (0)", found=f"{kind} ({name})")


def _wind(primary: InputFile) -> tuple[float | None, Path | None]:
    """Return the speed of a steady wind when the deck has one."""
    if primary.integer("CompInflow", 0) != 1:
        return None, None
    path = _named(primary, "InflowFile")
    inflow = read_input(path)
    steady = inflow.has("WindType") and inflow.integer("WindType") == 1
    return (inflow.number("HWindSpeed") if steady else None), path


def _named(primary: InputFile, name: str) -> Path:
    """Return the path of a file that the primary file names; raise FormatError with its line when it is not there."""
    text = primary.text(name)
    path = primary.path.parent / text.replace("\\", "/")
    if not path.is_file():
        raise FormatError(
            primary.path, primary.line(name), expected=f"an existing file for {name}", found=text,
            hint=f"Looked for {path}; paths are relative to the primary file",
        )  # fmt: skip
    return path


def _refuse(primary: InputFile, name: str, known: dict, allow: set) -> None:
    if primary.has(name) and primary.integer(name) not in allow:
        value = primary.integer(name)
        raise FormatError(
            primary.path, primary.line(name), expected=f"{name} in {sorted(allow)}", found=f"{value} ({known.get(value, 'unknown')})",
            hint="fowtio models a rigid floater with the turbine that ElastoDyn describes",
        )  # fmt: skip
