"""HydroDyn input files: potential-flow data, additional terms, and the Morison members as drag elements."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fowtio.errors import FormatError
from fowtio.read.openfast_input import InputFile, read_input
from model.conventions import freeze
from model.system.drag import DragMembers, no_drag

_STRIP_LENGTH = 10.0  # one Gauss point for about every 10 m of wetted length and one more


@dataclass(frozen=True, eq=False, kw_only=True)
class Members:
    """Morison members as the deck defines them: names; start, end (m, 3) [m]; diameter (m, 2) and drag coefficient (m, 2)
    at both ends; the ends' area vectors with axial drag: plate_position, plate_area (p, 3) [m2], plate_coefficient (p).
    """

    names: tuple[str, ...]
    start: np.ndarray
    end: np.ndarray
    diameter: np.ndarray
    drag_coefficient: np.ndarray
    potential: np.ndarray
    plate_position: np.ndarray
    plate_area: np.ndarray
    plate_coefficient: np.ndarray

    def __post_init__(self):
        freeze(
            self, start=("m", 3), end=("m", 3), diameter=("m", 2), drag_coefficient=("m", 2), potential=("m",),
            plate_position=("p", 3), plate_area=("p", 3), plate_coefficient=("p",),
        )  # fmt: skip


@dataclass(frozen=True, eq=False, kw_only=True)
class HydroDyn:
    """What a HydroDyn deck says: potential flow on or off, stem of its coefficient files and their length scale [m],
    displaced volume [m3] and centre of buoyancy (2) [m], whether waves excite and radiation acts, the additional preload
    (6), stiffness, linear and quadratic damping (6, 6), and the Morison members.
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


def read_hydrodyn(path: str | Path) -> HydroDyn:
    """Return a HydroDyn deck; raise FormatError, also for what fowtio does not model (several bodies, filled members)."""
    deck = read_input(path)
    potential = deck.integer("PotMod") == 1
    _refuse(deck, "NBody", 1, "one potential-flow body")
    for name in ("PtfmRefxt", "PtfmRefyt", "PtfmRefzt", "PtfmRefztRot", "PtfmRefY"):
        _refuse(deck, name, 0, "the body at the platform reference point")
    for name in ("NFillGroups", "NMGDepths"):
        _refuse(deck, name, 0, "ballast in ElastoDyn's platform mass and clean members")
    return HydroDyn(
        path=deck.path, potential_flow=potential,
        coefficients=deck.path.parent / deck.text("PotFile") if potential else None,
        length_scale=deck.number("WAMITULEN", 1.0), volume=deck.number("PtfmVol0", 0.0) if potential else 0.0,
        centre_of_buoyancy=np.array([deck.number("PtfmCOBxt", 0.0), deck.number("PtfmCOByt", 0.0)]),
        excitation_model=deck.integer("ExctnMod", 1), radiation_model=deck.integer("RdtnMod", 1),
        preload=deck.array("AddF0", 6, 1)[:, 0], stiffness=deck.array("AddCLin", 6, 6),
        damping=deck.array("AddBLin", 6, 6), quadratic_damping=deck.array("AddBQuad", 6, 6),
        members=_members(deck), input=deck,
    )  # fmt: skip


def drag_members(members: Members, density: float, *, water_level: float = 0.0) -> DragMembers:
    """Return the drag elements of the wetted members: Gauss points along each, and the end plates.

    density [kg/m3]; water_level z [m] up to which members are wetted. End plates follow HydroDyn: K = 1/4 rho AxCd A
    with A the sum of the area vectors of the member ends that meet in the joint.
    """
    parts = [_strips(members, i, density, water_level) for i in range(len(members.names))]
    area = np.linalg.norm(members.plate_area, axis=1)
    wet = (area > 1e-9) & (members.plate_position[:, 2] <= water_level)
    axis = members.plate_area[wet] / area[wet, None]
    parts.append(
        (members.plate_position[wet], axis, density / 4 * members.plate_coefficient[wet] * area[wet], np.ones(wet.sum()),
         np.sqrt(4 / np.pi * area[wet]), np.zeros(wet.sum()))
    )  # fmt: skip
    position, axis, factor, axial, diameter, length = (np.concatenate(column) for column in zip(*parts, strict=True))
    keep = factor > 0
    if not keep.any():
        return no_drag()
    return DragMembers(
        position=position[keep], axis=axis[keep], factor=factor[keep], axial=axial[keep], diameter=diameter[keep],
        length=length[keep],
    )  # fmt: skip


def _strips(members: Members, i: int, density: float, level: float) -> tuple[np.ndarray, ...]:
    """Return position, axis, factor, axial, diameter and length of one member's strips below the water level."""
    start, end = members.start[i], members.end[i]
    if start[2] > end[2]:
        start, end, order = end, start, slice(None, None, -1)
    else:
        order = slice(None)
    rise = end[2] - start[2]
    wet = 0.0 if start[2] >= level else (1.0 if end[2] <= level else (level - start[2]) / rise)
    full = np.linalg.norm(end - start)
    count = 0 if wet == 0 else (1 if wet * full < 1.0 else int(np.ceil(wet * full / _STRIP_LENGTH)) + 1)
    x, w = np.polynomial.legendre.leggauss(count) if count else (np.zeros(0), np.zeros(0))
    along = (x + 1) / 2 * wet
    length = w / 2 * wet * full
    diameter, drag = ((1 - along) * v[0] + along * v[1] for v in (members.diameter[i][order], members.drag_coefficient[i][order]))
    axis = np.broadcast_to((end - start) / full, (count, 3))
    position = start + along[:, None] * (end - start)
    return position, axis, density / 2 * drag * diameter * length, np.zeros(count), diameter, length


def _members(deck: InputFile) -> Members:
    joints = deck.table("NJoints")
    ids = [str(i) for i in joints.integers("JointID")]
    place = dict(zip(ids, np.stack([joints.numbers(f"Joint{c}i") for c in "xyz"], axis=1), strict=True))
    diameter_of = _diameters(deck)
    table = deck.table("NMembers")
    ends = [[str(i) for i in table.integers(f"MJointID{k}")] for k in (1, 2)]
    sets = [[str(i) for i in table.integers(f"MPropSetID{k}")] for k in (1, 2)]
    for row, line in enumerate(table.numbers_of_lines):
        for k in (0, 1):
            if ends[k][row] not in place:
                raise FormatError(deck.path, line, expected="a joint of the joint table", found=f"JointID {ends[k][row]}")
            if sets[k][row] not in diameter_of:
                raise FormatError(
                    deck.path, line, expected="a cylindrical property set", found=f"MPropSetID {sets[k][row]}",
                    hint="Rectangular members are not modelled",
                )  # fmt: skip
    n = len(table)
    start, end = (np.array([place[j] for j in ends[k]]).reshape(n, 3) for k in (0, 1))
    diameter = np.array([[diameter_of[s] for s in sets[k]] for k in (0, 1)]).reshape(2, n).T
    plates = _plates(deck, joints, place, ends, start, end, diameter)
    flags = [f.lower().strip(".")[:1] == "t" for f in table.column("PropPot")] if n else []
    return Members(
        names=tuple(table.column("MemberID")) if n else (), start=start, end=end, diameter=diameter,
        drag_coefficient=_drag_coefficients(deck, table, start, end), potential=np.array(flags, dtype=float),
        plate_position=plates[0], plate_area=plates[1], plate_coefficient=plates[2],
    )  # fmt: skip


def _diameters(deck: InputFile) -> dict[str, float]:
    table = deck.table("NPropSetsCyl" if deck.has("NPropSetsCyl") else "NPropSets")
    if not len(table):
        return {}
    return dict(zip((str(i) for i in table.integers("PropSetID")), table.numbers("PropD"), strict=True))


def _drag_coefficients(deck: InputFile, table, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Return Cd at both ends of each member after its coefficient model: 1 simple, 2 by depth, 3 by member."""
    if not len(table):
        return np.zeros((0, 2))
    model = table.integers("MCoefMod")
    out = np.zeros((len(table), 2))
    if np.any(model == 1):
        out[model == 1] = deck.table(header="SimplCd", rows=1).numbers("SimplCd")[0]
    if np.any(model == 2):
        depth = deck.table("NCoefDpthCyl" if deck.has("NCoefDpthCyl") else "NCoefDpth")
        z, cd = -np.abs(depth.numbers("Dpth")), depth.numbers("DpthCd")
        order = np.argsort(z)
        for k, point in enumerate((start, end)):
            out[model == 2, k] = np.interp(point[model == 2, 2], z[order], cd[order])
    if np.any(model == 3):
        own = deck.table("NCoefMembersCyl" if deck.has("NCoefMembersCyl") else "NCoefMembers")
        given = dict(zip(own.column("MemberID"), zip(own.numbers("MemberCd1"), own.numbers("MemberCd2"), strict=True), strict=True))
        for row in np.flatnonzero(model == 3):
            name = table.column("MemberID")[row]
            if name not in given:
                raise FormatError(deck.path, table.numbers_of_lines[row], expected=f"coefficients of member {name} (MCoefMod 3)", found="none")
            out[row] = given[name]
    return out


def _plates(deck, joints, place, ends, start, end, diameter) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return position, area vector and axial drag coefficient of the joints that have one."""
    axial = deck.table("NAxCoef")
    coefficient = dict(zip((str(i) for i in axial.integers("AxCoefID")), axial.numbers("AxCd"), strict=True)) if len(axial) else {}
    use = dict(zip(place, (str(i) for i in joints.integers("JointAxID")), strict=True))
    direction = end - start
    length = np.linalg.norm(direction, axis=1, keepdims=True)
    if np.any(length == 0):
        raise FormatError(deck.path, deck.line("NMembers"), expected="members of some length", found="two equal ends")
    outward = {1: direction / length, 0: -direction / length}
    area = {joint: np.zeros(3) for joint in place}
    for k in (0, 1):
        for row, joint in enumerate(ends[k]):
            area[joint] = area[joint] + outward[k][row] * np.pi / 4 * diameter[row, k] ** 2
    chosen = [j for j in place if coefficient.get(use[j], 0.0) > 0]
    n = len(chosen)
    return (
        np.array([place[j] for j in chosen]).reshape(n, 3), np.array([area[j] for j in chosen]).reshape(n, 3),
        np.array([coefficient[use[j]] for j in chosen]),
    )  # fmt: skip


def _refuse(deck: InputFile, name: str, allowed: float, what: str) -> None:
    if deck.has(name) and not deck.is_default(name) and deck.number(name) != allowed:
        raise FormatError(
            deck.path, deck.line(name), expected=f"{name} = {allowed}", found=deck.text(name), hint=f"fowtio takes {what}"
        )
