"""The hydrodynamic coefficients of a deck: those its HydroDyn names, or any other file that fits its water."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fowtio.errors import FormatError
from fowtio.read.hydro_any import hydro_options, read_hydro
from fowtio.read.morison_elements import inertia_elements
from fowtio.read.wamit import read_wamit
from model.system.hydro import HydroCoefficients, of_members, with_members

if TYPE_CHECKING:
    from fowtio.read.openfast_deck import Deck

SAME_WATER = 0.01  # of density, gravity and depth: coefficients are proportional to the first two


def deck_hydro(deck: Deck, path: Path | None = None) -> HydroCoefficients:
    """Return the hydrodynamic coefficients that the deck's HydroDyn names, or those of any other file, folder or stem, and
    with them its members outside the potential flow (PropPot False; all of them with PotMod 0 and no such file).

    WAMIT files take density, gravity and depth from the deck, and the length scale WAMITULEN when they are the deck's own
    (1 m otherwise). Any other format carries its water, which must be the deck's within 1 %, and must have a hydrostatic
    stiffness. Displaced volume and centre of buoyancy come from the file when it has them, else from HydroDyn (PtfmVol0).
    Raises FormatError.
    """
    if deck.hydrodyn is None or not (deck.hydrodyn.floats or path):
        raise FormatError(
            deck.path, expected="a deck with HydroDyn, and potential flow (PotMod 1) or members (PropPot False) in it", found="none",
            hint="Without water forces nothing carries the floater",
        )  # fmt: skip
    water = {"density": deck.density, "gravity": deck.gravity, "depth": deck.depth}
    members = inertia_elements(deck.hydrodyn.members, deck.density, deck.gravity)
    if members is not None and members.position[:, 2].min() < -deck.depth:
        raise FormatError(
            deck.hydrodyn.path, expected=f"members above the seabed at {-deck.depth:g} m", found=f"one down to {members.position[:, 2].min():g} m"
        )
    if path is None and not deck.hydrodyn.potential_flow:
        return of_members(members, **water)
    potential = _potential_hydro(deck, path, water)
    if members is None:
        return potential
    if potential.excitation is None or potential.hydrostatic_stiffness is None:
        raise FormatError(
            path or deck.hydrodyn.coefficients, expected="excitation (.3) and hydrostatic stiffness (.hst)", found="not both"
        )
    return with_members(potential, members)


def _potential_hydro(deck: Deck, path: Path | None, water: dict[str, float]) -> HydroCoefficients:
    """Return the coefficients of the potential flow."""
    if path is None:
        hydro = read_wamit(deck.hydrodyn.coefficients, length=deck.hydrodyn.length_scale, **water)
    else:
        hydro = _other_hydro(deck, Path(path), water)
    if hydro.volume is not None and hydro.centre_of_buoyancy is not None:
        return hydro
    cob = np.append(deck.hydrodyn.centre_of_buoyancy, 0.0)
    return replace(hydro, volume=deck.hydrodyn.volume, centre_of_buoyancy=cob)


def _other_hydro(deck: Deck, path: Path, water: dict[str, float]) -> HydroCoefficients:
    """Return the coefficients of a file of any format, which must fit the deck."""
    known = hydro_options(path)
    hydro = read_hydro(path, **{name: value for name, value in water.items() if name in known})
    for name, unit in (("density", "kg/m3"), ("gravity", "m/s2"), ("depth", "m")):
        own, wanted = getattr(hydro, name), water[name]
        if own != wanted and not abs(own - wanted) <= SAME_WATER * wanted:
            raise FormatError(
                path, expected=f"coefficients for the deck's {name}, {wanted:g} {unit}", found=f"{own:g} {unit}",
                hint=f"The deck is {deck.path}; repeat the run of the coefficients with its water, or name the other deck",
            )  # fmt: skip
    if hydro.hydrostatic_stiffness is None:
        raise FormatError(
            path, expected="a hydrostatic stiffness", found="none",
            hint="A WAMIT set needs its .hst; a Capytaine file needs hydrostatics with the centre of mass; fowtio convert "
            "with --mass and --centre gives a file that has it",
        )  # fmt: skip
    return hydro
