"""Morison members of a HydroDyn deck: cylinders with drag, end plates at their joints, ballast inside.

Ballast in filled members is taken as frozen: its mass moves with the platform, as in HydroDyn, which lets the fluid in a
member move with it and keeps its surface in place.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fowtio.errors import FormatError
from fowtio.read.openfast_input import InputFile, unquote
from fowtio.read.text import number
from model.conventions import freeze
from model.system.drag import DragMembers, no_drag
from model.system.turbine import RigidBody

_STRIP_LENGTH = 10.0  # one Gauss point for about every 10 m of wetted length and one more


@dataclass(frozen=True, eq=False, kw_only=True)
class Members:
    """Morison members as the deck defines them: names; start, end (m, 3) [m]; diameter (m, 2) and drag coefficient
    (m, 2) at both ends; the ends' area vectors with axial drag: plate_position, plate_area (p, 3) [m2],
    plate_coefficient (p); wall thickness (m, 2) [m].
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
    thickness: np.ndarray | None = None

    def __post_init__(self):
        freeze(
            self,
            start=("m", 3),
            end=("m", 3),
            diameter=("m", 2),
            drag_coefficient=("m", 2),
            potential=("m",),
            thickness=("m", 2),
            plate_position=("p", 3),
            plate_area=("p", 3),
            plate_coefficient=("p",),
        )


@dataclass(frozen=True, kw_only=True)
class Filling:
    """Ballast of a group of members: their rows, the level z [m] they are filled to, density [kg/m3], None of water."""

    members: tuple[int, ...]
    level: float
    density: float | None
    line: int


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
        (
            members.plate_position[wet],
            axis,
            density / 4 * members.plate_coefficient[wet] * area[wet],
            np.ones(wet.sum()),
            np.sqrt(4 / np.pi * area[wet]),
            np.zeros(wet.sum()),
        )
    )
    position, axis, factor, axial, diameter, length = (np.concatenate(column) for column in zip(*parts, strict=True))
    keep = factor > 0
    if not keep.any():
        return no_drag()
    return DragMembers(
        position=position[keep], axis=axis[keep], factor=factor[keep], axial=axial[keep], diameter=diameter[keep],
        length=length[keep],
    )  # fmt: skip


def ballast_body(members: Members, fillings: tuple[Filling, ...], density: float) -> RigidBody | None:
    """Return the fluid in filled members as a rigid body about the platform reference point, None without any.

    density [kg/m3] of the sea, for fillings that take it. A member is full between its walls from its lower end to
    where its axis crosses the level; sections normal to the axis are disks, integrated exactly for straight and
    conical members.
    """
    parts = [_filled(members, i, f, density) for f in fillings for i in f.members]
    mass = np.concatenate([p[0] for p in parts]) if parts else np.zeros(0)
    if not mass.sum() > 0:
        return None
    place, own = (np.concatenate([p[k] for p in parts]) for k in (1, 2))
    centre = mass @ place / mass.sum()
    arm = place - centre
    square = np.einsum("s,si,sj->ij", mass, arm, arm)
    return RigidBody(mass=mass.sum(), centre=centre, inertia=own.sum(axis=0) + np.trace(square) * np.eye(3) - square)


def _filled(members: Members, i: int, filling: Filling, density: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return mass (s), place (s, 3) and own inertia (s, 3, 3) of Gauss slices of the fluid in one member."""
    rows = (0, 1) if members.start[i, 2] <= members.end[i, 2] else (1, 0)
    low, high = ((members.start[i], members.end[i])[k] for k in rows)
    inner = (members.diameter[i] - 2 * members.thickness[i])[list(rows)]
    rise = high[2] - low[2]
    full = float(np.clip((filling.level - low[2]) / rise, 0, 1)) if rise > 1e-9 else float(low[2] <= filling.level)
    x, w = np.polynomial.legendre.leggauss(6)
    along = (x + 1) / 2 * full
    length = np.linalg.norm(high - low)
    diameter = inner[0] + along * (inner[1] - inner[0])
    rho = density if filling.density is None else filling.density
    mass = rho * np.pi / 4 * diameter**2 * w / 2 * full * length
    axis = (high - low) / length
    disk = np.eye(3) + np.outer(axis, axis)
    return mass, low + along[:, None] * (high - low), (mass * diameter**2 / 16)[:, None, None] * disk


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
    diameter, drag = (
        (1 - along) * v[0] + along * v[1] for v in (members.diameter[i][order], members.drag_coefficient[i][order])
    )
    axis = np.broadcast_to((end - start) / full, (count, 3))
    position = start + along[:, None] * (end - start)
    return position, axis, density / 2 * drag * diameter * length, np.zeros(count), diameter, length


def read_members(deck: InputFile) -> Members:
    """Return the members of a HydroDyn deck; raise FormatError, also for rectangular ones."""
    joints = deck.table("NJoints")
    ids = [str(i) for i in joints.integers("JointID")]
    for row, line in enumerate(joints.numbers_of_lines):
        if ids[row] in ids[:row]:
            raise FormatError(deck.path, line, expected="every joint once", found=f"JointID {ids[row]} again")
    place = dict(zip(ids, np.stack([joints.numbers(f"Joint{c}i") for c in "xyz"], axis=1), strict=True))
    section_of = _sections(deck)
    table = deck.table("NMembers")
    ends = [[str(i) for i in table.integers(f"MJointID{k}")] for k in (1, 2)]
    sets = [[str(i) for i in table.integers(f"MPropSetID{k}")] for k in (1, 2)]
    for row, line in enumerate(table.numbers_of_lines):
        for k in (0, 1):
            if ends[k][row] not in place:
                raise FormatError(
                    deck.path, line, expected="a joint of the joint table", found=f"JointID {ends[k][row]}"
                )
            if sets[k][row] not in section_of:
                raise FormatError(
                    deck.path, line, expected="a cylindrical property set", found=f"MPropSetID {sets[k][row]}",
                    hint="Rectangular members are not modelled",
                )  # fmt: skip
    n = len(table)
    _check_members(deck, table)
    start, end = (np.array([place[j] for j in ends[k]]).reshape(n, 3) for k in (0, 1))
    section = np.array([[section_of[s] for s in sets[k]] for k in (0, 1)]).reshape(2, n, 2)
    diameter, thickness = section[..., 0].T, section[..., 1].T
    plates = _plates(deck, joints, place, ends, start, end, diameter)
    flags = [f.lower().strip(".")[:1] == "t" for f in table.column("PropPot")] if n else []
    return Members(
        names=tuple(str(i) for i in table.integers("MemberID")) if n else (), start=start, end=end, diameter=diameter,
        drag_coefficient=_drag_coefficients(deck, table, start, end), potential=np.array(flags, dtype=float),
        plate_position=plates[0], plate_area=plates[1], plate_coefficient=plates[2], thickness=thickness,
    )  # fmt: skip


def _sections(deck: InputFile) -> dict[str, tuple[float, float]]:
    """Return diameter and wall thickness of the cylindrical property sets by number."""
    table = deck.table("NPropSetsCyl" if deck.has("NPropSetsCyl") else "NPropSets")
    if not len(table):
        return {}
    diameter, thickness = table.numbers("PropD"), table.numbers("PropThck")
    wrong = (diameter <= 0) | (thickness < 0) | (2 * thickness > diameter)
    if np.any(wrong):
        k = int(np.argmax(wrong))
        found = f"diameter {diameter[k]:g}, thickness {thickness[k]:g}"
        raise FormatError(
            deck.path, table.numbers_of_lines[k], expected="a diameter above zero and a wall within it", found=found
        )
    return dict(zip((str(i) for i in table.integers("PropSetID")), zip(diameter, thickness, strict=True), strict=True))


def read_fillings(deck: InputFile, members: Members) -> tuple[Filling, ...]:
    """Return the groups of filled members; a row is the number of members, their numbers, level and density."""
    if not deck.has("NFillGroups") or deck.integer("NFillGroups") == 0:
        return ()
    table = deck.table("NFillGroups")
    index = {name: i for i, name in enumerate(members.names)}
    out: list[Filling] = []
    for row, line in zip(table.rows, table.numbers_of_lines, strict=True):
        try:
            count = int(row[0])
            names = [str(int(t)) for t in row[1 : 1 + count]]
            level, density = (
                None if unquote(t).lower() == "default" else number(t) for t in row[1 + count : 3 + count]
            )
        except ValueError:
            raise FormatError(
                deck.path,
                line,
                expected="number of members, their numbers, filling level, density",
                found=" ".join(row),
            ) from None
        used = [i for f in out for i in f.members]
        for k, name in enumerate(names):
            if name not in index or index[name] in used or name in names[:k]:
                raise FormatError(
                    deck.path, line, expected="members of the table of members, each once", found=f"member {name}"
                )
        out.append(Filling(members=tuple(index[n] for n in names), level=level or 0.0, density=density, line=line))
    return tuple(out)


def _check_members(deck: InputFile, table) -> None:
    """Refuse members that are rectangular, numbered twice, or of an unknown coefficient model."""
    if not len(table):
        return
    for name, allowed, hint in (
        ("MSecGeom", (1,), "Rectangular members are not modelled"),
        ("MCoefMod", (1, 2, 3), ""),
    ):
        if name.lower() in [c.lower() for c in table.columns]:
            for value, line in zip(table.integers(name), table.numbers_of_lines, strict=True):
                if value not in allowed:
                    raise FormatError(deck.path, line, expected=f"{name} in {allowed}", found=str(value), hint=hint)
    ids = table.integers("MemberID").tolist()
    for row, line in enumerate(table.numbers_of_lines):
        if ids[row] in ids[:row]:
            raise FormatError(deck.path, line, expected="every member once", found=f"member {ids[row]} again")


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
        given = dict(
            zip(
                own.integers("MemberID").tolist(),
                zip(own.numbers("MemberCd1"), own.numbers("MemberCd2"), strict=True),
                strict=True,
            )
        )
        for row in np.flatnonzero(model == 3):
            name = table.integers("MemberID")[row]
            if name not in given:
                raise FormatError(
                    deck.path,
                    table.numbers_of_lines[row],
                    expected=f"coefficients of member {name} (MCoefMod 3)",
                    found="none",
                )
            out[row] = given[name]
    return out


def _plates(deck, joints, place, ends, start, end, diameter) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return position, area vector and axial drag coefficient of the joints that have one."""
    axial = deck.table("NAxCoef")
    coefficient = (
        dict(zip((str(i) for i in axial.integers("AxCoefID")), axial.numbers("AxCd"), strict=True))
        if len(axial)
        else {}
    )
    use = dict(zip(place, (str(i) for i in joints.integers("JointAxID")), strict=True))
    for joint, line in zip(use, joints.numbers_of_lines, strict=True):
        if use[joint] not in coefficient:
            raise FormatError(
                deck.path, line, expected="an axial coefficient of the table", found=f"JointAxID {use[joint]}"
            )
    direction = end - start
    length = np.linalg.norm(direction, axis=1, keepdims=True)
    if np.any(length == 0):
        line = deck.table("NMembers").numbers_of_lines[int(np.argmax(length == 0))]
        raise FormatError(deck.path, line, expected="a member of some length", found="two equal ends")
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
