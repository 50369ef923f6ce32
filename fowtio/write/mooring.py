"""Mooring systems as MAP++ and MoorDyn (version 1 or 2) input files."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fowtio.errors import ModelError
from fowtio.write.atomic import atomic_file
from model.system.mooring import MooringSystem

_RULE = 80
_MOORDYN_KINDS = {
    1: {"fixed": "Fixed", "vessel": "Vessel", "connect": "Connect"},
    2: {"fixed": "Fixed", "vessel": "Coupled", "connect": "Free"},
}
_FAMILIES = ("length", "mass_per_length", "diameter", "axial_stiffness", "seabed_friction")


def map_text(system: MooringSystem) -> str:
    """Return a mooring system as the text of a MAP++ input file.

    Depth, gravity and water density are not in it (OpenFAST hands them over). Numbers are written so that reading gives
    them back exactly. Raises ModelError for a stack of designs.
    """
    _check_one(system)
    kinds, kind_of = _line_types(system)
    out = [_rule("LINE DICTIONARY"), "LineType  Diam  MassDenInAir  EA  CB  CIntDamp  Ca  Cdn  Cdt"]
    out += ["(-)  (m)  (kg/m)  (N)  (-)  (Pa-s)  (-)  (-)  (-)"]
    out += [f"type{k + 1}  {_row(row)}  0  0  0  0" for k, row in enumerate(kinds)]
    out += [
        _rule("NODE PROPERTIES"),
        "Node  Type  X  Y  Z  M  V  FX  FY  FZ",
        "(-)  (-)  (m)  (m)  (m)  (kg)  (m^3)  (N)  (N)  (N)",
    ]
    out += [_map_node(system, i) for i in range(len(system.point_names))]
    out += [
        _rule("LINE PROPERTIES"),
        "Line  LineType  UnstrLen  NodeAnch  NodeFair  Flags",
        "(-)  (-)  (m)  (-)  (-)  (-)",
    ]
    for j, kind in enumerate(kind_of):
        ends = f"{system.end_a[j] + 1}  {system.end_b[j] + 1}"
        out.append(f"{j + 1}  type{kind + 1}  {_text(system.length[j])}  {ends}  tension_fair tension_anch")
    out += [_rule("SOLVER OPTIONS"), "Option", "(-)", "outer_tol 1e-6"]
    return "\n".join(out) + "\n"


def moordyn_text(system: MooringSystem, *, version: int = 2, segments: int = 20) -> str:
    """Return a mooring system as the text of a MoorDyn input file.

    version 1 or 2; segments a line. Drag, added mass and damping, which a static system does not have, are written
    with the values in `_dynamics`. Raises ModelError for what the version cannot say: forces on points in version 2,
    friction in version 1, different friction of lines, a stack of designs.
    """
    _check_one(system)
    if version not in _MOORDYN_KINDS:
        raise ModelError(f"MoorDyn has input versions 1 and 2, not {version}")
    friction = _friction(system, version)
    kinds, kind_of = _line_types(system)
    out = [_rule(f"MoorDyn v{version} input"), "Static mooring system written by fowtio"]
    out += _moordyn_types(kinds, version)
    if version == 2:
        out += _EMPTY_SECTIONS
    out += _moordyn_points(system, version)
    out += _moordyn_lines(system, kind_of, version, segments)
    out += [_rule("OPTIONS" if version == 2 else "SOLVER OPTIONS")]
    values = [
        ("0.001", "dtM", "time step (s)"),
        ("3.0e6", "kBot", "seabed stiffness (Pa/m)"),
        ("3.0e5", "cBot", "seabed damping (Pa s/m)"),
    ]
    values += [
        (_text(system.gravity), "g", "gravity (m/s^2)"),
        (_text(system.density), "rhoW", "water density (kg/m^3)"),
    ]
    values += [(_text(system.depth), "WtrDpth", "water depth (m)")]
    values += [(_text(friction), "MU_KA", "axial friction of the seabed (-)")] if friction else []
    out += [f"{value}  {name}  - {what}" for value, name, what in values]
    out += [_rule("OUTPUTS"), *(f"FairTen{j + 1}" for j in range(len(kind_of))), "END", _rule("need this line")]
    return "\n".join(out) + "\n"


def write_map(system: MooringSystem, path: str | Path) -> Path:
    """Write a mooring system as a MAP++ input file and return its path; raise ModelError as `map_text`."""
    path = Path(path)
    _write(path, map_text(system))
    return path


def write_moordyn(system: MooringSystem, path: str | Path, *, version: int = 2, segments: int = 20) -> Path:
    """Write a mooring system as a MoorDyn input file and return its path; raise ModelError as `moordyn_text`."""
    path = Path(path)
    _write(path, moordyn_text(system, version=version, segments=segments))
    return path


def _write(path: Path, text: str) -> None:
    with atomic_file(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def _dynamics(version: int) -> str:
    """Return damping, bending stiffness, drag and added mass of a line type: a chain's, by its nominal diameter."""
    return "-1.0  1.0  0.5  2.4  1.15" if version == 1 else "-1.0  0.0  2.4  1.0  1.15  0.5"


_EMPTY_SECTIONS = [
    f"{' ROD TYPES ':-^{_RULE}}",
    "TypeName  Diam  Mass/m  Cd  Ca  CdEnd  CaEnd",
    "(name)  (m)  (kg/m)  (-)  (-)  (-)  (-)",
    f"{' BODIES ':-^{_RULE}}",
    "ID  Attachment  X0  Y0  Z0  r0  p0  y0  Mass  CG  I  Volume  CdA  Ca",
    "(#)  (word)  (m)  (m)  (m)  (deg)  (deg)  (deg)  (kg)  (m)  (kg-m^2)  (m^3)  (m^2)  (-)",
    f"{' RODS ':-^{_RULE}}",
    "ID  RodType  Attachment  Xa  Ya  Za  Xb  Yb  Zb  NumSegs  RodOutputs",
    "(#)  (name)  (word)  (m)  (m)  (m)  (m)  (m)  (m)  (-)  (-)",
]


def _moordyn_types(kinds: np.ndarray, version: int) -> list[str]:
    columns = "BA/-zeta  Can  Cat  Cdn  Cdt" if version == 1 else "BA/-zeta  EI  Cd  Ca  CdAx  CaAx"
    units = "(N-s)  (-)  (-)  (-)  (-)" if version == 1 else "(N-s)  (N-m^2)  (-)  (-)  (-)  (-)"
    out = [_rule("LINE TYPES"), f"Name  Diam  MassDen  EA  {columns}", f"(name)  (m)  (kg/m)  (N)  {units}"]
    return out + [f"type{k + 1}  {_row(row[:3])}  {_dynamics(version)}" for k, row in enumerate(kinds)]


def _moordyn_points(system: MooringSystem, version: int) -> list[str]:
    forces, units = ("FX  FY  FZ  ", "(N)  (N)  (N)  ") if version == 1 else ("", "")
    title = "POINTS" if version == 2 else "CONNECTION PROPERTIES"
    out = [
        _rule(title),
        f"ID  Attachment  X  Y  Z  Mass  Volume  {forces}CdA  Ca",
        f"(#)  (word)  (m)  (m)  (m)  (kg)  (m^3)  {units}(m^2)  (-)",
    ]
    for i, kind in enumerate(system.point_kind):
        values = [
            *system.position[i],
            system.point_mass[i],
            system.point_volume[i],
            *(system.point_force[i] if version == 1 else ()),
        ]
        out.append(f"{i + 1}  {_MOORDYN_KINDS[version][kind]}  {_row(values)}  0  0")
    return out


def _moordyn_lines(system: MooringSystem, kind_of, version: int, segments: int) -> list[str]:
    if version == 1:
        out = [
            _rule("LINE PROPERTIES"),
            "Line  LineType  UnstrLen  NumSegs  NodeAnch  NodeFair  Outputs",
            "(-)  (-)  (m)  (-)  (-)  (-)  (-)",
        ]
    else:
        out = [
            _rule("LINES"),
            "ID  LineType  AttachA  AttachB  UnstrLen  NumSegs  LineOutputs",
            "(#)  (name)  (#)  (#)  (m)  (-)  (-)",
        ]
    for j, kind in enumerate(kind_of):
        ends, length = f"{system.end_a[j] + 1}  {system.end_b[j] + 1}", _text(system.length[j])
        body = f"{length}  {segments}  {ends}" if version == 1 else f"{ends}  {length}  {segments}"
        out.append(f"{j + 1}  type{kind + 1}  {body}  -")
    return out


def _map_node(system: MooringSystem, i: int) -> str:
    """Return one row of MAP++'s node table: '#' marks what MAP++ finds."""
    kind = system.point_kind[i]
    place = [_text(v) for v in system.position[i]]
    if kind == "connect":
        place, force = [f"#{v}" for v in place], _row(system.point_force[i])
    else:
        place[2] = "depth" if kind == "fixed" and system.position[i, 2] == -system.depth else place[2]
        force = "#  #  #"
    word = {"fixed": "Fix", "vessel": "Vessel", "connect": "Connect"}[kind]
    return f"{i + 1}  {word}  {'  '.join(place)}  {_row([system.point_mass[i], system.point_volume[i]])}  {force}"


def _line_types(system: MooringSystem) -> tuple[np.ndarray, np.ndarray]:
    """Return the different line types (k, 4: diameter, mass per length, EA, friction) and the type of each line."""
    table = np.stack([system.diameter, system.mass_per_length, system.axial_stiffness, system.seabed_friction], axis=1)
    _, first, kind_of = np.unique(table, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    return table[first[order]], np.argsort(order)[kind_of.ravel()]


def _friction(system: MooringSystem, version: int) -> float:
    """Return the one friction coefficient of all lines."""
    values = np.unique(system.seabed_friction)
    if len(values) > 1:
        raise ModelError(f"MoorDyn has one seabed friction for all lines; this system has {values.tolist()}")
    if version == 1 and np.any(values):
        raise ModelError(
            f"MoorDyn 1 has no seabed friction; this system has {values[0]:g}. Write version 2, or set it to zero"
        )
    if version == 2 and np.any(system.point_force):
        raise ModelError("MoorDyn 2 has no constant forces on points in its list of points; write version 1")
    return float(values[0]) if len(values) else 0.0


def _check_one(system: MooringSystem) -> None:
    if system.position.ndim != 2 or any(getattr(system, name).ndim != 1 for name in _FAMILIES):
        raise ModelError("a mooring file holds one design; this system is a stack of several")


def _rule(title: str) -> str:
    return f"{f' {title} ':-^{_RULE}}"


def _row(values) -> str:
    return "  ".join(_text(v) for v in values)


def _text(value: float) -> str:
    """Return the shortest text that reads back as the same number."""
    return repr(float(value))
