"""HydroDyn input files: potential-flow data, additional terms and the Morison members.

Names decide, so the layouts of OpenFAST 2 to 5 are read alike.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fowtio.errors import FormatError
from fowtio.read.morison import Filling, Members, read_fillings, read_members
from fowtio.read.morison_elements import ballast_body, drag_members
from fowtio.read.openfast_input import InputFile, read_input
from model.system.turbine import RigidBody

__all__ = ["Filling", "HydroDyn", "Members", "ballast", "drag_members", "read_hydrodyn"]


@dataclass(frozen=True, eq=False, kw_only=True)
class HydroDyn:
    """What a HydroDyn deck says: potential flow on or off, stem of its coefficient files and their length scale [m],
    displaced volume [m3] and centre of buoyancy (2) [m], whether waves excite and radiation acts, the additional
    preload (6), stiffness, linear and quadratic damping (6, 6), the Morison members and their fillings; notes say
    what of the deck is simplified here.
    """

    path: Path
    potential_flow: bool
    coefficients: Path | None
    length_scale: float
    volume: float
    centre_of_buoyancy: np.ndarray
    excitation_model: int
    radiation_model: int
    preload: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    quadratic_damping: np.ndarray
    members: Members
    input: InputFile
    fillings: tuple[Filling, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def floats(self) -> bool:
        """Whether the deck has potential flow, or members outside it in the water."""
        low = np.minimum(self.members.start[:, 2], self.members.end[:, 2])
        return self.potential_flow or bool(np.any((self.members.potential == 0) & (low < 0)))


def read_hydrodyn(path: str | Path) -> HydroDyn:
    """Return a HydroDyn deck of OpenFAST 2 to 5; raise FormatError, also for what fowtio does not model: several
    bodies, bodies off the reference point, load flags switched off, marine growth, rectangular members.
    """
    deck = read_input(path)
    potential = _potential_flow(deck)
    _refuse_what_is_not_modelled(deck)
    members = read_members(deck, potential)
    return HydroDyn(
        path=deck.path, potential_flow=potential,
        coefficients=_stem(deck) if potential else None,
        length_scale=deck.number("WAMITULEN") if potential else 1.0, volume=deck.number("PtfmVol0") if potential else 0.0,
        centre_of_buoyancy=np.array([deck.number(n) if potential else 0.0 for n in ("PtfmCOBxt", "PtfmCOByt")]),
        excitation_model=deck.integer("ExctnMod", 1), radiation_model=deck.integer("RdtnMod", 1),
        preload=_preload(deck), stiffness=deck.array("AddCLin", 6, 6),
        damping=deck.array("AddBLin", 6, 6), quadratic_damping=deck.array("AddBQuad", 6, 6),
        members=members, input=deck, fillings=read_fillings(deck, members), notes=_notes(deck),
    )  # fmt: skip


def ballast(hydrodyn: HydroDyn, density: float) -> RigidBody | None:
    """Return the fluid in filled members as a rigid body; density [kg/m3] of the sea, for fillings that take it."""
    return ballast_body(hydrodyn.members, hydrodyn.fillings, density)


def _potential_flow(deck: InputFile) -> bool:
    """Tell whether coefficients of WAMIT form are used (PotMod 1, in early versions HasWAMIT)."""
    if not deck.has("PotMod") and deck.has("HasWAMIT"):
        return deck.flag("HasWAMIT")
    model = deck.integer("PotMod")
    if model not in (0, 1):
        raise FormatError(
            deck.path, deck.line("PotMod"), expected="PotMod 0 (none) or 1 (WAMIT form)", found=deck.text("PotMod")
        )
    return model == 1


def _stem(deck: InputFile) -> Path:
    """Return the root name of the coefficient files."""
    text = deck.text("PotFile") if deck.has("PotFile") else deck.text("WAMITFile")
    path = deck.path.parent / text
    return (
        path
        if "\\" not in text or path.with_name(path.name + ".1").exists()
        else deck.path.parent / text.replace("\\", "/")
    )


def _preload(deck: InputFile) -> np.ndarray:
    """Return AddF0 (6): six numbers on the line of its name, or one there and five below."""
    if len(deck.values("AddF0")) >= 6:
        return deck.array("AddF0", 1, 6)[0]
    return deck.array("AddF0", 6, 1)[:, 0]


def _refuse_what_is_not_modelled(deck: InputFile) -> None:
    _refuse(deck, "NBody", 1, "one potential-flow body")
    for name in ("PtfmRefxt", "PtfmRefyt", "PtfmRefzt", "PtfmRefztRot", "PtfmRefY"):
        _refuse(deck, name, 0, "the body at the platform reference point")
    _refuse(deck, "NAddDOF", 0, "a rigid body")
    for name in ("PtfmSgF", "PtfmSwF", "PtfmHvF", "PtfmRF", "PtfmPF", "PtfmYF"):
        if deck.has(name) and not deck.flag(name):
            raise FormatError(
                deck.path, deck.line(name), expected=f"{name} True", found="False", hint="fowtio keeps all six loads"
            )
    growth = deck.table("NMGDepths") if deck.has("NMGDepths") else None
    if growth is not None and len(growth) and np.any(growth.numbers("MGThck") != 0):
        at = int(np.argmax(growth.numbers("MGThck") != 0))
        raise FormatError(
            deck.path,
            growth.numbers_of_lines[at],
            expected="members without marine growth (MGThck 0)",
            found=" ".join(growth.rows[at]),
            hint="Put the thicker diameter and its coefficients in the tables of members, and the mass in ElastoDyn",
        )


def _notes(deck: InputFile) -> tuple[str, ...]:
    """Return what of the deck is simplified, in sentences."""
    out = []
    axial = deck.table("NAxCoef")
    if (
        len(axial)
        and "axfdmod" in [c.lower() for c in axial.columns]
        and np.any((axial.numbers("AxFDMod") != 0) & (axial.numbers("AxCd") > 0))
    ):
        out.append("end drag with AxFDMod 1 is taken as with AxFDMod 0, not filtered")
    if any(deck.has(n) and deck.integer(n) != 0 for n in ("MnDrift", "NewmanApp", "DiffQTF", "SumQTF")):
        out.append("second-order wave forces of the deck are left out")
    if deck.has("NFillGroups") and deck.integer("NFillGroups") > 0:
        out.append("ballast of filled members is added to the platform's mass")
    return tuple(out)


def _refuse(deck: InputFile, name: str, allowed: float, what: str) -> None:
    if deck.has(name) and not deck.is_default(name) and deck.number(name) != allowed:
        raise FormatError(
            deck.path,
            deck.line(name),
            expected=f"{name} = {allowed}",
            found=deck.text(name),
            hint=f"fowtio takes {what}",
        )
