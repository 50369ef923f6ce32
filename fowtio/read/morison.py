"""Morison members of a HydroDyn deck: cylinders with their coefficients, the joints where they meet, ballast inside."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fowtio.errors import FormatError
from fowtio.read.openfast_input import InputFile, unquote
from fowtio.read.text import number
from model.conventions import freeze

_INERTIA = {
    "added_mass_coefficient": "Ca", "pressure_coefficient": "Cp", "axial_added_mass": "AxCa", "axial_pressure": "AxCp",
    "buoyancy_coefficient": "Cb",
}  # fmt: skip
_ABSENT = {"AxCa": 0.0, "AxCp": 1.0, "Cb": 1.0}  # HydroDyn's values before it had the columns


@dataclass(frozen=True, eq=False, kw_only=True)
class Members:
    """Morison members as the deck defines them: names; start, end (m, 3) [m]; diameter (m, 2) and drag coefficient
    (m, 2) at both ends; the ends' area vectors with axial drag: plate_position, plate_area (p, 3) [m2],
    plate_coefficient (p); wall thickness (m, 2) [m].

    potential (m) is 1 for members in the potential flow. For the others, zero otherwise: coefficients (m, 2) at both ends
    added_mass (Ca), pressure (Cp), axial_added_mass (AxCa), axial_pressure (AxCp) and buoyancy (Cb, zero without hydrostatics); and the
    joints where such members end: joint_position (j, 3) [m], joint_area (j, 3) [m2] sum of their outward area vectors, joint_volume
    (j, 3) [m3] of half spheres on them, joint_added_mass (AxCa) and joint_pressure (AxCp) (j).
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
    added_mass_coefficient: np.ndarray
    pressure_coefficient: np.ndarray
    axial_added_mass: np.ndarray
    axial_pressure: np.ndarray
    buoyancy_coefficient: np.ndarray
    joint_position: np.ndarray
    joint_area: np.ndarray
    joint_volume: np.ndarray
    joint_added_mass: np.ndarray
    joint_pressure: np.ndarray
    thickness: np.ndarray | None = None

    def __post_init__(self):
        freeze(
            self,
            **dict.fromkeys(_INERTIA, ("m", 2)), joint_position=("j", 3), joint_area=("j", 3), joint_volume=("j", 3),
            joint_added_mass=("j",), joint_pressure=("j",),
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


def read_members(deck: InputFile, potential_flow: bool = True) -> Members:
    """Return the members of a HydroDyn deck; raise FormatError, also for rectangular ones.

    Without potential flow (PotMod 0) no member is in it, whatever PropPot says, as in HydroDyn.
    """
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
    flags = [potential_flow and f.lower().strip(".")[:1] == "t" for f in table.column("PropPot")] if n else []
    outside = ~np.array(flags, dtype=bool)
    ends_at = _Ends(place=place, joints=ends, outward=_outward(deck, start, end), diameter=diameter)
    return Members(
        names=tuple(str(i) for i in table.integers("MemberID")) if n else (), start=start, end=end, diameter=diameter,
        drag_coefficient=_coefficients(deck, table, start, end, "Cd"), potential=np.array(flags, dtype=float),
        thickness=thickness, **_joints(deck, joints, ends_at, outside), **_inertia(deck, table, start, end, outside),
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


def _coefficients(deck: InputFile, table, start: np.ndarray, end: np.ndarray, name: str, absent=None) -> np.ndarray:
    """Return a coefficient at both ends of each member after its coefficient model: 1 simple, 2 by depth, 3 by member.

    absent is its value where a table has no such column; None makes that an error.
    """
    out = np.zeros((len(table), 2))
    if not len(table):
        return out
    model = table.integers("MCoefMod")

    def numbers(source, column):
        known = absent is None or column.lower() in [c.lower() for c in source.columns]
        return source.numbers(column) if known else np.full(len(source), absent)

    if np.any(model == 1):
        out[model == 1] = numbers(deck.table(header="SimplCd", rows=1), f"Simpl{name}")[0]
    if np.any(model == 2):
        depth = deck.table("NCoefDpthCyl" if deck.has("NCoefDpthCyl") else "NCoefDpth")
        z, values = -np.abs(depth.numbers("Dpth")), numbers(depth, f"Dpth{name}")
        order = np.argsort(z)
        for k, point in enumerate((start, end)):
            out[model == 2, k] = np.interp(point[model == 2, 2], z[order], values[order])
    if np.any(model == 3):
        own = deck.table("NCoefMembersCyl" if deck.has("NCoefMembersCyl") else "NCoefMembers")
        pairs = zip(numbers(own, f"Member{name}1"), numbers(own, f"Member{name}2"), strict=True)
        given = dict(zip(own.integers("MemberID").tolist(), pairs, strict=True))
        for row in np.flatnonzero(model == 3):
            member = table.integers("MemberID")[row]
            if member not in given:
                raise FormatError(
                    deck.path,
                    table.numbers_of_lines[row],
                    expected=f"coefficients of member {member} (MCoefMod 3)",
                    found="none",
                )
            out[row] = given[member]
    return out


def _inertia(deck: InputFile, table, start, end, outside: np.ndarray) -> dict[str, np.ndarray]:
    """Return the coefficients of inertia and buoyancy by field, zero for members in the potential flow."""
    out = {field: np.zeros((len(table), 2)) for field in _INERTIA}
    if not outside.any():
        return out
    _refuse_diffraction(deck)
    for field, name in _INERTIA.items():
        out[field][outside] = _coefficients(deck, table, start, end, name, _ABSENT.get(name))[outside]
    if "mhstlmod" in [c.lower() for c in table.columns]:
        out["buoyancy_coefficient"][table.integers("MHstLMod") == 0] = 0.0
    return out


def _refuse_diffraction(deck: InputFile) -> None:
    """Refuse members whose wave force HydroDyn scales after MacCamy and Fuchs."""
    tables = [deck.table(header="SimplCd", rows=1)]
    tables += [deck.table(n) for n in ("NCoefDpthCyl", "NCoefDpth", "NCoefMembersCyl", "NCoefMembers") if deck.has(n)]
    for table in tables:
        for name in (c for c in table.columns if c.lower().endswith("mcf")):
            for value, line in zip(table.column(name), table.numbers_of_lines, strict=True):
                if value.lower().strip(".")[:1] in ("t", "1"):
                    raise FormatError(
                        deck.path, line, expected=f"{name} False", found=value,
                        hint="Diffraction after MacCamy and Fuchs is not modelled; give the member to the potential flow (PropPot True)",
                    )  # fmt: skip


@dataclass(frozen=True)
class _Ends:
    """Where members end: places of the joints by number, joints of both ends, outward axes (2, m, 3), diameter (m, 2)."""

    place: dict[str, np.ndarray]
    joints: list[list[str]]
    outward: np.ndarray
    diameter: np.ndarray

    def summed(self, size: np.ndarray, counted: np.ndarray) -> dict[str, np.ndarray]:
        """Return by joint the sum of the outward axes times sizes (m, 2) of the members that are counted."""
        out = {joint: np.zeros(3) for joint in self.place}
        for k in (0, 1):
            for row in np.flatnonzero(counted):
                joint = self.joints[k][row]
                out[joint] = out[joint] + self.outward[k, row] * size[row, k]
        return out


def _outward(deck: InputFile, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Return the outward axes (2, m, 3) of members at both ends; raise FormatError for one without length."""
    direction = end - start
    length = np.linalg.norm(direction, axis=1, keepdims=True)
    if np.any(length == 0):
        line = deck.table("NMembers").numbers_of_lines[int(np.argmax(length == 0))]
        raise FormatError(deck.path, line, expected="a member of some length", found="two equal ends")
    return np.stack([-direction / length, direction / length])


def _joints(deck: InputFile, joints, ends: _Ends, outside: np.ndarray) -> dict[str, np.ndarray]:
    """Return the plates with axial drag, of all members, and the joints of members outside the potential flow, by field."""
    axial = deck.table("NAxCoef")
    rows = {str(i): row for row, i in enumerate(axial.integers("AxCoefID"))} if len(axial) else {}
    use = dict(zip(ends.place, (str(i) for i in joints.integers("JointAxID")), strict=True))
    for joint, line in zip(use, joints.numbers_of_lines, strict=True):
        if use[joint] not in rows:
            raise FormatError(
                deck.path, line, expected="an axial coefficient of the table", found=f"JointAxID {use[joint]}"
            )

    def picked(values, of):
        return np.array([values[j] for j in of]).reshape(len(of), 3)

    def coefficient(name, of):
        values = axial.numbers(name) if of else np.zeros(0)
        return np.array([values[rows[use[j]]] for j in of])

    area = np.pi / 4 * ends.diameter**2
    drag = dict(zip(use, coefficient("AxCd", list(use)), strict=True))
    plates = [j for j in use if drag[j] > 0]
    free = [j for j in use if any(outside[row] for k in (0, 1) for row, at in enumerate(ends.joints[k]) if at == j)]
    return {
        "plate_position": picked(ends.place, plates), "plate_coefficient": np.array([drag[j] for j in plates]),
        "plate_area": picked(ends.summed(area, np.ones(len(area), bool)), plates),
        "joint_position": picked(ends.place, free), "joint_area": picked(ends.summed(area, outside), free),
        "joint_volume": picked(ends.summed(np.pi / 12 * ends.diameter**3, outside), free),
        "joint_added_mass": coefficient("AxCa", free), "joint_pressure": coefficient("AxCp", free),
    }  # fmt: skip
