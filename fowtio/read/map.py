"""MAP++ input files: line dictionary, nodes, lines and the repeat option, as a mooring system.

Source of the format: MAP++ documentation (input file and line flags), Masciola, National Renewable Energy Laboratory.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fowtio.errors import FormatError
from fowtio.read.openfast_input import tokens
from fowtio.read.registry import Format, head_lines
from fowtio.read.text import number, read_lines
from model.system.mooring import MooringSystem

_SECTIONS = {
    "line dictionary": "dictionary", "line types": "dictionary", "node properties": "nodes", "line properties": "lines",
    "solver options": "options",
}  # fmt: skip
_KINDS = {"fix": "fixed", "fixed": "fixed", "vessel": "vessel", "connect": "connect"}
_COLUMNS = {"dictionary": 5, "nodes": 10, "lines": 5}
_REFUSED_FLAGS = {
    "linear_spring": "lines are elastic catenaries here", "omit_contact": "every line feels the seabed here",
    "damage_time": "lines do not break here",
}  # fmt: skip


@dataclass(frozen=True, eq=False, kw_only=True)
class MapFile:
    """A MAP++ file as it stands: rows of (line number, tokens) by section, and the angles of repeat [deg]."""

    path: Path
    rows: dict[str, list[tuple[int, list[str]]]]
    repeat: tuple[float, ...]


def read_map(path: str | Path) -> MapFile:
    """Return the sections of a MAP++ input file; raise FormatError."""
    path = Path(path)
    rows: dict[str, list] = {name: [] for name in _SECTIONS.values()}
    section, heading = None, 0
    for i, line in enumerate(read_lines(path), start=1):
        text = line.strip()
        if text.startswith("---"):
            section, heading = _SECTIONS.get(_title(text)), 0
            continue
        if not text or text.startswith("!") or section is None:
            continue
        heading += 1
        if heading == 2 and not text.startswith("("):
            raise FormatError(path, i, expected="a line of units in brackets below the column names", found=text)
        if heading > 2:
            rows[section].append((i, tokens(line.split("!")[0])))
    for name, width in _COLUMNS.items():
        if not rows[name]:
            raise FormatError(path, expected=f"rows in the section of {name} of a MAP++ file", found="none")
        for i, row in rows[name]:
            if len(row) < width:
                raise FormatError(
                    path, i, expected=f"at least {width} columns in the section of {name}", found=" ".join(row)
                )
    repeat = tuple(_number(path, i, t) for i, row in rows["options"] if row[0].lower() == "repeat" for t in row[1:])
    return MapFile(path=path, rows=rows, repeat=repeat)


def _title(text: str) -> str:
    """Return the known section whose name begins a rule, or the rule's own title."""
    title = " ".join(text.strip("- ").lower().split())
    return next((name for name in _SECTIONS if title.startswith(name)), title)


def map_mooring(file: MapFile, *, depth: float, gravity: float, density: float) -> MooringSystem:
    """Return the mooring system of a MAP++ file; depth [m], gravity [m/s2] and water density [kg/m3] from the deck.

    Lines are named 1, 2, ... in the order of MAP++'s tensions T[1], T[2], ...; raise FormatError, also for what
    fowtio does not model (line flags LINEAR_SPRING, OMIT_CONTACT and DAMAGE_TIME, lengths or masses to be found by
    iteration).
    """
    path = file.path
    _once(path, file.rows["dictionary"], "line type")
    _once(path, file.rows["nodes"], "node")
    kinds = {row[0].lower(): (i, row) for i, row in file.rows["dictionary"]}
    ids = [row[0] for _, row in file.rows["nodes"]]
    points = [_node(path, i, row, depth) for i, row in file.rows["nodes"]]
    lines = [_line(path, i, row, kinds, ids) for i, row in file.rows["lines"]]
    angles = (0.0, *file.repeat)
    try:
        return _repeated(points, ids, lines, np.radians(angles), depth, gravity, density)
    except ValueError as error:
        raise FormatError(path, expected="a mooring system that can be", hint=str(error)) from None


def _once(path: Path, rows: Sequence, what: str) -> None:
    count = Counter(row[0].lower() for _, row in rows)
    for i, row in reversed(rows):
        if count[row[0].lower()] > 1:
            raise FormatError(path, i, expected=f"every {what} once", found=f"{row[0]} {count[row[0].lower()]} times")


def _node(path: Path, i: int, row: list[str], depth: float) -> tuple:
    """Return kind, position, mass, volume and force of one node."""
    kind = _KINDS.get(row[1].lower())
    if kind is None:
        raise FormatError(path, i, expected="Fix, Vessel or Connect", found=row[1])
    place = [-depth if v.lower().lstrip("#") == "depth" else _number(path, i, v.lstrip("#") or "0") for v in row[2:5]]
    extra = [_number(path, i, v.lstrip("#") or "0") for v in row[5:10]]
    marked = [v for v in row[5:10] if v.startswith("#")]
    if kind == "connect" and marked:
        raise FormatError(
            path, i, expected="numbers for mass, volume and forces of a Connect node", found=" ".join(marked)
        )
    if kind == "vessel" and (extra[0] or extra[1]):
        raise FormatError(
            path,
            i,
            expected="mass 0 and volume 0 of a Vessel node",
            found=" ".join(row[5:7]),
            hint="Count them in the platform's mass",
        )
    return kind, np.array(place), extra[0], extra[1], np.array(extra[2:5]) * (kind == "connect")


def _line(path: Path, i: int, row: list[str], kinds: dict, ids: list[str]) -> tuple:
    """Return name, ends, length, mass per length, diameter, axial stiffness and seabed friction of one line."""
    if row[1].lower() not in kinds:
        raise FormatError(
            path, i, expected="a line type of the dictionary", found=row[1], hint=f"Known: {', '.join(kinds)}"
        )
    for k in (3, 4):
        if row[k] not in ids:
            raise FormatError(path, i, expected="a node of the node table", found=row[k])
    for flag in row[5:]:
        if flag.lower() in _REFUSED_FLAGS:
            raise FormatError(
                path,
                i,
                expected="line flags that fowtio models",
                found=flag,
                hint=_REFUSED_FLAGS[flag.lower()].capitalize(),
            )
    if row[2].startswith("#"):
        raise FormatError(
            path,
            i,
            expected="an unstretched length",
            found=row[2],
            hint="A length to be found by iteration is not modelled",
        )
    at, kind = kinds[row[1].lower()]
    diameter, mass, stiffness, friction = (_number(path, at, v) for v in kind[1:5])
    return row[0], ids.index(row[3]), ids.index(row[4]), _number(path, i, row[2]), mass, diameter, stiffness, friction


def _repeated(points, ids, lines, angles, depth, gravity, density) -> MooringSystem:
    """Return the system with all points and lines copied around the vertical axis.

    MAP++ turns the copies clockwise seen from above: a line towards 60 degrees repeated at 240 goes towards 180.
    """
    turn = [np.array([[np.cos(a), np.sin(a), 0], [-np.sin(a), np.cos(a), 0], [0, 0, 1]]) for a in angles]
    copies = range(len(angles))
    n = len(points)
    columns = list(zip(*lines, strict=True))

    def tiled(k):
        return np.tile(np.array(columns[k], dtype=float), len(angles))

    return MooringSystem(
        point_names=tuple(f"{name}" if k == 0 else f"{name}.{k + 1}" for k in copies for name in ids),
        point_kind=tuple(p[0] for _ in copies for p in points),
        position=np.concatenate([[t @ p[1] for p in points] for t in turn]),
        point_mass=np.tile([p[2] for p in points], len(angles)),
        point_volume=np.tile([p[3] for p in points], len(angles)),
        point_force=np.concatenate([[t @ p[4] for p in points] for t in turn]),
        line_names=tuple(str(k * len(lines) + j + 1) for k in copies for j in range(len(lines))),
        end_a=np.concatenate([np.array(columns[1]) + k * n for k in copies]),
        end_b=np.concatenate([np.array(columns[2]) + k * n for k in copies]),
        length=tiled(3),
        mass_per_length=tiled(4),
        diameter=tiled(5),
        axial_stiffness=tiled(6),
        seabed_friction=tiled(7),
        depth=depth,
        gravity=gravity,
        density=density,
    )


def _number(path: Path, line: int, text: str) -> float:
    try:
        return number(text)
    except ValueError:
        raise FormatError(path, line, expected="a number", found=text) from None


def _recognises(path, head: bytes) -> bool:
    titles = [_title(line) for line in head_lines(head) if line.startswith("---")]
    return "node properties" in titles and "line properties" in titles and b"numsegs" not in head.lower()


def _describe(file: MapFile) -> list[tuple[str, str]]:
    kinds = Counter(row[1].lower() for _, row in file.rows["nodes"])
    return [
        ("line types", ", ".join(row[0] for _, row in file.rows["dictionary"])),
        ("nodes", ", ".join(f"{n} {kind}" for kind, n in kinds.items())),
        (
            "lines",
            f"{len(file.rows['lines'])}, repeated at {', '.join(f'{a:g}' for a in file.repeat) or 'no'} deg (clockwise)",
        ),
        ("water", "depth, density and gravity come from the deck"),
    ]


def _problems(file: MapFile) -> list[str]:
    """Return why the file is no mooring system that is modelled here, if it is none."""
    heights = [row[4].lstrip("#") for _, row in file.rows["nodes"]]
    if any(h.lower() == "depth" for h in heights):
        return []  # the depth is the deck's
    try:
        deepest = max(-_number(file.path, i, row[4].lstrip("#") or "0") for i, row in file.rows["nodes"])
        map_mooring(file, depth=deepest, gravity=9.80665, density=1025.0)
    except FormatError as error:
        return [str(error)]
    return []


MAP = Format(name="MAP++ input file", recognises=_recognises, read=read_map, describe=_describe, problems=_problems)
