"""MAP++ input files: line dictionary, nodes, lines and the repeat option, as a mooring system.

Source of the format: MAP++ documentation (input file and line flags), Masciola, National Renewable Energy Laboratory.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fowtio.errors import FormatError
from fowtio.read.openfast_input import tokens
from fowtio.read.text import number, read_lines
from model.system.mooring import MooringSystem

_SECTIONS = {"line dictionary": "dictionary", "node properties": "nodes", "line properties": "lines", "solver options": "options"}
_KINDS = {"fix": "fixed", "fixed": "fixed", "vessel": "vessel", "connect": "connect"}
_COLUMNS = {"dictionary": 5, "nodes": 10, "lines": 5}


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
            title = text.strip("- ").lower()
            section = next((s for key, s in _SECTIONS.items() if title.startswith(key)), None)
            heading = 0
            continue
        if not text or text.startswith("!") or section is None:
            continue
        heading += 1
        if heading > 2 or (section == "options" and heading > 1 and not text.startswith("(")):
            rows[section].append((i, tokens(line.split("!")[0])))
    for name in ("dictionary", "nodes", "lines"):
        if not rows[name]:
            raise FormatError(path, expected=f"rows in the section of {name} of a MAP++ file", found="none")
        for i, row in rows[name]:
            if len(row) < _COLUMNS[name]:
                raise FormatError(path, i, expected=f"at least {_COLUMNS[name]} columns in the section of {name}", found=" ".join(row))
    repeat = tuple(_number(path, i, t) for i, row in rows["options"] if row[0].lower() == "repeat" for t in row[1:])
    return MapFile(path=path, rows=rows, repeat=repeat)


def map_mooring(file: MapFile, *, depth: float, gravity: float, density: float) -> MooringSystem:
    """Return the mooring system of a MAP++ file; depth [m], gravity [m/s2] and water density [kg/m3] from the deck."""
    path = file.path
    kinds = {row[0].lower(): (i, row) for i, row in file.rows["dictionary"]}
    ids, points = [], []
    for i, row in file.rows["nodes"]:
        kind = _KINDS.get(row[1].lower())
        if kind is None:
            raise FormatError(path, i, expected="Fix, Vessel or Connect", found=row[1])
        place = [-depth if v.lower().lstrip("#") == "depth" else _number(path, i, v.lstrip("#") or "0") for v in row[2:5]]
        extra = [_number(path, i, v.lstrip("#") or "0") for v in row[5:10]]
        ids.append(row[0])
        points.append((kind, np.array(place), extra[0], extra[1], np.array(extra[2:5]) * (kind == "connect")))
    lines = []
    for i, row in file.rows["lines"]:
        if row[1].lower() not in kinds:
            raise FormatError(path, i, expected="a line type of the dictionary", found=row[1])
        for k in (3, 4):
            if row[k] not in ids:
                raise FormatError(path, i, expected="a node of the node table", found=row[k])
        at, kind = kinds[row[1].lower()]
        diameter, mass, stiffness, friction = (_number(path, at, v) for v in kind[1:5])
        lines.append((row[0], ids.index(row[3]), ids.index(row[4]), _number(path, i, row[2]), mass, diameter, stiffness, friction))
    angles = (0.0, *file.repeat)
    try:
        return _repeated(points, ids, lines, np.radians(angles), depth, gravity, density)
    except ValueError as error:
        raise FormatError(path, expected="a mooring system that can be", hint=str(error)) from None


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
        length=tiled(3), mass_per_length=tiled(4), diameter=tiled(5), axial_stiffness=tiled(6), seabed_friction=tiled(7),
        depth=depth, gravity=gravity, density=density,
    )  # fmt: skip


def _number(path: Path, line: int, text: str) -> float:
    try:
        return number(text)
    except ValueError:
        raise FormatError(path, line, expected="a number", found=text) from None
