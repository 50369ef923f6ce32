"""MoorDyn input files, versions 1 and 2, as a static mooring system.

Of a dynamic mooring model the static part is kept: weight, buoyancy, axial stiffness, seabed friction (MU_KA), point
masses, volumes and constant forces. Source of the format: MoorDyn's documentation, Hall et al., input files v1 and
v2.
"""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fowtio.errors import FormatError
from fowtio.read.openfast_input import tokens
from fowtio.read.registry import Format, head_lines
from fowtio.read.text import is_number, number, read_lines
from model.system.mooring import MooringSystem

_SECTIONS = {
    "line types": "types",
    "line dictionary": "types",
    "rod types": "rod types",
    "rod dictionary": "rod types",
    "bodies": "bodies",
    "body list": "bodies",
    "body properties": "bodies",
    "rods": "rods",
    "rod list": "rods",
    "rod properties": "rods",
    "points": "points",
    "point list": "points",
    "point properties": "points",
    "connection properties": "points",
    "connections": "points",
    "connects": "points",
    "node properties": "points",
    "lines": "lines",
    "line list": "lines",
    "line properties": "lines",
    "failure": "failure",
    "control": "control",
    "external loads": "loads",
    "options": "options",
    "solver options": "options",
    "outputs": "outputs",
    "output": "outputs",
}
_KINDS = {
    "fixed": "fixed",
    "fix": "fixed",
    "anchor": "fixed",
    "vessel": "vessel",
    "ves": "vessel",
    "coupled": "vessel",
    "cpld": "vessel",
    "fairlead": "vessel",
    "connect": "connect",
    "con": "connect",
    "free": "connect",
    "point": "connect",
    "p": "connect",
}
_TABLES = {"types": 4, "points": 7, "lines": 6}
_REFUSED = {
    "rods": "rods", "loads": "external loads", "failure": "lines that fail",
}  # fmt: skip
_COLUMN_NAMES = {
    "length": ("unstrlen", "length"), "a": ("attacha", "nodeanch", "nodea", "enda", "anch"),
    "b": ("attachb", "nodefair", "nodeb", "endb", "fair"), "kind": ("linetype", "type"),
}  # fmt: skip


@dataclass(frozen=True, eq=False, kw_only=True)
class MoorDynFile:
    """A MoorDyn file as it stands: columns (lower case) and rows of (line number, tokens) by section; units of the
    columns; options by lower-case name as (line number, text).
    """

    path: Path
    columns: dict[str, list[str]]
    units: dict[str, list[str]]
    rows: dict[str, list[tuple[int, list[str]]]]
    options: dict[str, tuple[int, str]]


def read_moordyn(path: str | Path) -> MoorDynFile:
    """Return the sections of a MoorDyn input file of version 1 or 2; raise FormatError."""
    path = Path(path)
    found = _split(path)
    columns, units, rows = {}, {}, {}
    for name, lines in found.items():
        if name not in ("options", "outputs"):
            columns[name], units[name], rows[name] = _table(path, name, lines)
    for name, width in _TABLES.items():
        if not rows.get(name):
            raise FormatError(path, expected=f"a section of {name} with rows in a MoorDyn file", found="none")
        for i, row in rows[name]:
            if len(row) < width:
                raise FormatError(
                    path, i, expected=f"at least {width} columns in the section of {name}", found=" ".join(row)
                )
    options = {}
    for i, text in found.get("options", []):
        parts = tokens(text)
        if len(parts) < 2:
            raise FormatError(path, i, expected="an option: value, name", found=text)
        options[parts[1].lower()] = (i, parts[0].strip("\"'"))
    return MoorDynFile(path=path, columns=columns, units=units, rows=rows, options=options)


def moordyn_mooring(
    file: MoorDynFile, *, depth: float | None = None, gravity: float = 9.80665, density: float = 1025.0
) -> MooringSystem:
    """Return the mooring system of a MoorDyn file.

    depth [m], gravity [m/s2] and density [kg/m3] hold where the file has no option WtrDpth, g or rhoW. Coupled and
    vessel points, and points on coupled bodies, are fairleads; points on fixed bodies are anchors. Raises
    FormatError, also for what fowtio does not model (rods, free bodies, several turbines, viscoelastic or tabulated
    stiffness, a bathymetry file).
    """
    _refuse(file)
    depth = _depth(file, depth)
    gravity, density = _option(file, ("g",), gravity), _option(file, ("rhow", "rho", "wtrdens"), density)
    friction = _option(file, ("mu_ka", "frictioncoefficient"), 0.0)
    types = {row[0].lower(): _line_type(file, i, row) for i, row in file.rows["types"]}
    bodies = {row[0]: _body(file, i, row) for i, row in file.rows.get("bodies", [])}
    points = [_point(file, i, row, bodies) for i, row in file.rows["points"]]
    ids = _ids(file, "points")
    lines = [_line(file, i, row, types, ids) for i, row in file.rows["lines"]]
    a, b, length, kind = zip(*lines, strict=True)
    diameter, mass, stiffness = np.array(kind).T
    try:
        return MooringSystem(
            point_names=tuple(ids),
            point_kind=tuple(p[0] for p in points),
            position=[p[1] for p in points],
            point_mass=[p[2] for p in points],
            point_volume=[p[3] for p in points],
            point_force=[p[4] for p in points],
            line_names=tuple(_ids(file, "lines")),
            end_a=a,
            end_b=b,
            length=length,
            mass_per_length=mass,
            diameter=diameter,
            axial_stiffness=stiffness,
            seabed_friction=np.full(len(lines), friction),
            depth=depth,
            gravity=gravity,
            density=density,
        )
    except ValueError as error:
        raise FormatError(file.path, expected="a mooring system that can be", hint=str(error)) from None


def _split(path: Path) -> dict[str, list[tuple[int, str]]]:
    """Return the lines of each known section with their numbers, comments cut off."""
    found: dict[str, list[tuple[int, str]]] = {}
    section = None
    for i, line in enumerate(read_lines(path), start=1):
        if line.strip().startswith("---"):
            title = " ".join(line.strip("- \t").lower().split())
            section = next((key for name, key in _SECTIONS.items() if title == name), None)
            section = section or next((key for name, key in _SECTIONS.items() if title.startswith(name + " ")), None)
            if section in found:
                raise FormatError(path, i, expected="every section once", found=line)
            if section:
                found[section] = []
            continue
        text = re.split(r"[!#%]", line)[0] if not line.lstrip().startswith("(") else line
        if section and text.strip():
            found[section].append((i, text))
    return found


def _table(path: Path, name: str, lines: list[tuple[int, str]]) -> tuple[list[str], list[str], list]:
    """Return columns, units and rows of a section; a line with the number of rows above them is checked."""
    count = None
    if lines and re.match(r"\s*\d+\s+N[A-Za-z]+(\s+-|\s*$)", lines[0][1]):
        count, lines = int(lines[0][1].split()[0]), lines[1:]
    if len(lines) < 2 or not lines[1][1].lstrip().startswith("("):
        if not lines:
            return [], [], []
        at = lines[min(1, len(lines) - 1)]
        raise FormatError(
            path, at[0], expected=f"column names and units in brackets in the section of {name}", found=at[1]
        )
    rows = [(i, tokens(text)) for i, text in lines[2:]]
    if count is not None and count != len(rows):
        raise FormatError(
            path, lines[0][0] - 1, expected=f"{count} rows in the section of {name}", found=f"{len(rows)} rows"
        )
    return [c.lower() for c in lines[0][1].split()], lines[1][1].lower().split(), rows


def _refuse(file: MoorDynFile) -> None:
    for name, what in _REFUSED.items():
        for i, row in file.rows.get(name, []):
            raise FormatError(file.path, i, expected=f"a mooring system without {what}", found=" ".join(row))


def _depth(file: MoorDynFile, given: float | None) -> float:
    """Return the water depth of the file, which must be that of the deck, or the deck's."""
    for name in ("wtrdpth", "depth", "seafloorfile", "bathymetryfile"):
        if name in file.options:
            i, text = file.options[name]
            try:
                own = number(text)
            except ValueError:
                hint = "A bathymetry file is not modelled; fowtio takes a flat seabed"
                raise FormatError(file.path, i, expected="the water depth as a number", found=text, hint=hint) from None
            if given is not None and np.isfinite(given) and abs(own - given) > 1e-3 * given:
                raise FormatError(file.path, i, expected=f"the deck's water depth, {given:g} m", found=f"{own:g} m")
            return own
    if given is None:
        raise FormatError(file.path, expected="an option WtrDpth", found="none", hint="Name the water depth")
    return given


def _option(file: MoorDynFile, names: tuple[str, ...], default: float) -> float:
    for name in names:
        if name in file.options:
            return _number(file.path, *file.options[name])
    return default


def _ids(file: MoorDynFile, section: str) -> list[str]:
    """Return the identifiers of a section, each of which must be there once."""
    ids = [row[0] for _, row in file.rows[section]]
    for name, times in Counter(ids).items():
        if times > 1:
            line = [i for i, row in file.rows[section] if row[0] == name][-1]
            raise FormatError(
                file.path, line, expected=f"every number once among {section}", found=f"{name} {times} times"
            )
    return ids


def _line_type(file: MoorDynFile, i: int, row: list[str]) -> tuple[float, float, float]:
    """Return diameter, mass per length and axial stiffness of a line type."""
    if "|" in row[3] or not is_number(row[3]):
        raise FormatError(
            file.path, i, expected="one number for EA", found=row[3],
            hint="Viscoelastic (with bars) and tabulated stiffness are not modelled; give the static stiffness",
        )  # fmt: skip
    diameter, mass, stiffness = (_number(file.path, i, t) for t in row[1:4])
    return diameter, mass, stiffness


def _body(file: MoorDynFile, i: int, row: list[str]) -> tuple[str, np.ndarray, np.ndarray]:
    """Return kind, position and orientation (rotation matrix) of a fixed or coupled body."""
    kind = _KINDS.get(row[1].lower())
    if kind not in ("fixed", "vessel"):
        raise FormatError(
            file.path, i, expected="a body that is Fixed or Coupled", found=row[1], hint="Free bodies are not modelled"
        )
    values = [_number(file.path, i, t) for t in row[2:9]]
    if len(values) < 7 or (kind == "vessel" and (values[6] or (len(row) > 11 and _number(file.path, i, row[11])))):
        raise FormatError(
            file.path,
            i,
            expected="a coupled body without mass and volume",
            found=" ".join(row),
            hint="Count them in the platform's mass",
        )
    r, p, y = np.radians(values[3:6])
    about_x = np.array([[1, 0, 0], [0, np.cos(r), -np.sin(r)], [0, np.sin(r), np.cos(r)]])
    about_y = np.array([[np.cos(p), 0, np.sin(p)], [0, 1, 0], [-np.sin(p), 0, np.cos(p)]])
    about_z = np.array([[np.cos(y), -np.sin(y), 0], [np.sin(y), np.cos(y), 0], [0, 0, 1]])
    if np.count_nonzero(values[3:6]) > 1:
        raise FormatError(file.path, i, expected="a body turned about one axis at most", found=" ".join(row[5:8]))
    return kind, np.array(values[:3]), about_x @ about_y @ about_z


def _point(file: MoorDynFile, i: int, row: list[str], bodies: dict) -> tuple:
    """Return kind, position, mass, volume and force of a point."""
    place = np.array([_number(file.path, i, t) for t in row[2:5]])
    mass, volume = (_number(file.path, i, t) for t in row[5:7])
    word = row[1].lower()
    on_body, turbine = re.fullmatch(r"b(?:ody)?(\d+)", word), re.fullmatch(r"t(?:urbine)?(\d+)", word)
    if on_body:
        if on_body[1] not in bodies:
            raise FormatError(file.path, i, expected="a body of the list of bodies", found=row[1])
        kind, origin, turn = bodies[on_body[1]]
        place = origin + turn @ place
    elif turbine:
        if turbine[1] != "1":
            raise FormatError(
                file.path,
                i,
                expected="one turbine",
                found=row[1],
                hint="Moorings shared between turbines are not modelled",
            )
        kind = "vessel"
    elif word in _KINDS:
        kind = _KINDS[word]
    else:
        raise FormatError(file.path, i, expected="Fixed, Vessel (Coupled), Connect (Free) or a body", found=row[1])
    if kind == "vessel" and (mass or volume):
        raise FormatError(
            file.path,
            i,
            expected="mass 0 and volume 0 of a coupled point",
            found=" ".join(row[5:7]),
            hint="Count them in the platform's mass",
        )
    return kind, place, mass, volume, _force(file, i, row) * (kind == "connect")


def _force(file: MoorDynFile, i: int, row: list[str]) -> np.ndarray:
    """Return the constant force on a point [N], of version 1 only."""
    columns = file.columns["points"]
    if "fx" not in columns:
        return np.zeros(3)
    k = columns.index("fx")
    force = np.array([_number(file.path, i, t) for t in row[k : k + 3]])
    if len(force) < 3:
        raise FormatError(file.path, i, expected="FX, FY and FZ", found=" ".join(row))
    units = file.units["points"]
    if np.any(force) and len(units) > k and "kn" in units[k]:
        raise FormatError(
            file.path,
            i,
            expected="forces in N",
            found=" ".join(row[k : k + 3]),
            hint="MoorDyn takes newtons; the heading says kN",
        )
    return force


def _line(file: MoorDynFile, i: int, row: list[str], types: dict, ids: list[str]) -> tuple:
    """Return both ends, length and type of a line."""
    at = {key: _column(file, names) for key, names in _COLUMN_NAMES.items()}
    if len(row) <= max(at.values()):
        raise FormatError(file.path, i, expected=f"{len(file.columns['lines'])} columns", found=" ".join(row))
    kind = row[at["kind"]].lower()
    if kind not in types:
        raise FormatError(
            file.path, i, expected="a line type of the list", found=row[at["kind"]], hint=f"Known: {', '.join(types)}"
        )
    for end in ("a", "b"):
        if row[at[end]] not in ids:
            raise FormatError(file.path, i, expected="a point of the list of points", found=row[at[end]])
    return ids.index(row[at["a"]]), ids.index(row[at["b"]]), _number(file.path, i, row[at["length"]]), types[kind]


def _column(file: MoorDynFile, names: tuple[str, ...]) -> int:
    """Return the place of a column of the list of lines: its order differs between versions, so names decide."""
    for name in names:
        if name in file.columns["lines"]:
            return file.columns["lines"].index(name)
    first = file.rows["lines"][0][0]
    raise FormatError(
        file.path,
        first,
        expected=f"a column {' or '.join(names)} in the list of lines",
        found=" ".join(file.columns["lines"]),
    )


def _number(path: Path, line: int, text: str) -> float:
    try:
        return number(text)
    except ValueError:
        raise FormatError(path, line, expected="a number", found=text) from None


def _recognises(path, head: bytes) -> bool:
    titles = {
        " ".join(line.strip("- \t").lower().split()) for line in head_lines(head) if line.strip().startswith("---")
    }
    found = {_SECTIONS[t] for t in titles if t in _SECTIONS}
    return {"types", "points", "lines"} <= found and b"numsegs" in head.lower()


def _describe(file: MoorDynFile) -> list[tuple[str, str]]:
    kinds = Counter(row[1] for _, row in file.rows["points"])
    return [
        ("version", "1" if "fx" in file.columns["points"] or "nodeanch" in file.columns["lines"] else "2"),
        ("line types", ", ".join(row[0] for _, row in file.rows["types"])),
        ("points", ", ".join(f"{n} {kind}" for kind, n in kinds.items())),
        ("lines", str(len(file.rows["lines"]))),
        ("options", ", ".join(f"{name} {text}" for name, (_, text) in file.options.items()) or "none"),
    ]


def _problems(file: MoorDynFile) -> list[str]:
    """Return why the file is no static mooring system of one floater, if it is none."""
    own = any(name in file.options for name in ("wtrdpth", "depth", "seafloorfile", "bathymetryfile"))
    try:
        deepest = max(-_number(file.path, i, row[4]) for i, row in file.rows["points"])
        moordyn_mooring(file, depth=None if own else deepest)
    except FormatError as error:
        return [str(error)]
    return []


MOORDYN = Format(
    name="MoorDyn input file", recognises=_recognises, read=read_moordyn, describe=_describe, problems=_problems
)
