"""Nemoh's result folders, versions 2 and 3: dimensional, e^{-i omega t}, phases in radians.

Source of the format: Nemoh's manual (input and output files) and the files it writes. A folder holds Nemoh.cal,
Results/ with RadiationCoefficients.tec and ExcitationForce.tec, and Mesh/ with KH.dat and Hydrostatics.dat where they
were made.
Nemoh's stiffness is about the centre of gravity, where the weight has no share; it is brought to the origin here.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from fowtio.errors import FormatError
from fowtio.read.hydro_common import (
    check_damping,
    coefficients,
    describe_hydro,
    hydro_problems,
    number_at,
    number_table,
    phase_to_origin,
    stiffness_about,
    wave_number,
)
from fowtio.read.registry import Format, SeveralBodies
from fowtio.read.text import numbers, read_lines
from model.system.hydro import HydroCoefficients

_UNITS = {"rad/s": lambda w: w, "Hz": lambda f: 2 * np.pi * f, "(s)": lambda t: 2 * np.pi / t}
_BETA = re.compile(r"beta\s*=\s*([-+\d.EeDd]+)")


def read_nemoh(path: str | Path, *, body: int | None = None) -> HydroCoefficients:
    """Return the coefficients of a Nemoh folder, about the origin, waves e^{+i omega t} with the crest at the origin.

    path of the folder, or of a file in it; body (from 1) of a run with several, the coupling with the others left out.
    Hydrostatics are read when Mesh/ has them. Raises FormatError.
    """
    folder = _folder(Path(path))
    case = _read_cal(_find(folder, "Nemoh.cal"))
    place = _place(folder, case, body)
    own = case["bodies"][place]
    results = _find(folder, "Results", directory=True)
    radiation = _find(results, "RadiationCoefficients.tec")
    omega, added, damping = _radiation(radiation, case, place)
    _check_frequencies(radiation, case, omega)
    check_damping(radiation, damping, omega)
    fields = {"omega": omega, "added_mass": added, "radiation_damping": damping}
    excitation = _find(results, "ExcitationForce.tec", needed=False)
    if excitation:
        fields |= _excitation(excitation, results, case, place, omega)
    statics = _statics(folder, len(case["bodies"]), place)
    hydro = coefficients(
        folder, point=own["point"], **fields, density=case["density"], gravity=case["gravity"], depth=case["depth"],
        volume=statics.get("volume"), centre_of_buoyancy=statics.get("centre_of_buoyancy"),
    )  # fmt: skip
    if "stiffness" not in statics:
        return hydro
    lift = hydro.density * hydro.gravity * statics["volume"]
    stiffness = stiffness_about(statics["stiffness"], statics["centre_of_gravity"], np.zeros(3), lift)
    fields = {name: getattr(hydro, name) for name in hydro.__dataclass_fields__}
    return HydroCoefficients(**(fields | {"hydrostatic_stiffness": stiffness}))


def _folder(path: Path) -> Path:
    folder = path if path.is_dir() else path.parent
    if folder.name.lower() in ("results", "mesh") and not _find(folder, "Nemoh.cal", needed=False):
        folder = folder.parent
    return folder


def _find(folder: Path, name: str, *, directory: bool = False, needed: bool = True) -> Path | None:
    """Return the file or folder of that name, whatever its case; raise FormatError when it is needed and not there."""
    if folder.is_dir():
        for path in sorted(folder.iterdir()):
            if path.name.lower() == name.lower() and path.is_dir() == directory:
                return path
    if needed:
        raise FormatError(folder, expected=f"{name} in a Nemoh folder", found="none")
    return None


class _Cal:
    """The lines of Nemoh.cal, taken one after another without their comments."""

    def __init__(self, path: Path):
        self.path, self.lines, self.at = path, read_lines(path), 0

    def row(self, what: str, count: int | tuple[int, ...]) -> list[float]:
        """Return the numbers of the next line; raise FormatError when there are not `count`."""
        counts = (count,) if isinstance(count, int) else count
        text = self.next(what)
        tokens = text.split("!")[0].replace(",", " ").split()
        values: list[float] = []
        for token in tokens:  # words after the numbers are a comment too
            try:
                values += numbers(token)
            except ValueError:
                break
        if ("!" in text and len(tokens) != len(values)) or not counts[0] <= len(values):
            raise FormatError(self.path, self.at, expected=f"{what} ({counts[0]} numbers)", found=text)
        return values[: counts[-1]]

    def next(self, what: str) -> str:
        if self.at >= len(self.lines):
            raise FormatError(self.path, self.at, expected=what, found="end of file")
        self.at += 1
        return self.lines[self.at - 1]

    def rule(self) -> None:
        text = self.next("a section rule (---)")
        if not text.lstrip().startswith("-"):
            raise FormatError(self.path, self.at, expected="a section rule (---)", found=text)


def _read_cal(path: Path) -> dict:
    """Return what Nemoh.cal says: water, wave reference point, bodies, numbers of frequencies and headings."""
    cal = _Cal(path)
    cal.rule()
    case = {"density": cal.row("water density", 1)[0], "gravity": cal.row("gravity", 1)[0]}
    depth = cal.row("water depth", 1)[0]
    case["depth"] = depth if depth > 0 else np.inf  # 0 means infinite
    case["wave_point"] = np.array(cal.row("wave measurement point x, y", 2))
    cal.rule()
    count = int(cal.row("number of bodies", 1)[0])
    case["bodies"] = [_body(cal) for _ in range(count)]
    cal.rule()
    first = cal.row("number of frequencies, first, last", (3, 4))
    kind = int(first.pop(0)) if len(first) == 4 else 1  # version 3 puts the unit before
    convert = dict(zip((1, 2, 3), _UNITS.values(), strict=True)).get(kind)
    if convert is None or first[0] < 1:
        raise FormatError(
            path, cal.at, expected="frequency unit 1, 2 or 3 and a number of frequencies", found=str(first)
        )
    case["frequencies"] = int(first[0])
    case["range"] = sorted(convert(w) for w in first[1:] if w != 0)
    case["headings"] = int(cal.row("number of wave directions, first, last", 3)[0])
    return case


def _body(cal: _Cal) -> dict:
    cal.rule()
    cal.next("name of the mesh file")
    cal.row("number of points and panels", 2)
    motions = [
        cal.row("a degree of freedom (7 numbers)", 7) for _ in range(int(cal.row("number of degrees of freedom", 1)[0]))
    ]
    forces = [cal.row("a force (7 numbers)", 7) for _ in range(int(cal.row("number of forces", 1)[0]))]
    for _ in range(int(cal.row("number of additional lines", 1)[0])):
        cal.next("an additional line")
    modes = [_mode(cal, row) for row in motions]
    directions = [_mode(cal, row) for row in forces]
    points = {tuple(row[4:]) for row in motions + forces if row[0] == 2}
    if len(points) > 1:
        raise FormatError(
            cal.path, cal.at, expected="one point for all rotations and moments of a body", found=f"{sorted(points)}"
        )
    point = np.array(points.pop()) if points else np.zeros(3)
    return {"modes": modes, "forces": directions, "point": point}


def _mode(cal: _Cal, row: list[float]) -> int:
    """Return the place (0 to 5) of a rigid motion along or about a global axis."""
    kind, axis = int(row[0]), np.array(row[1:4])
    if kind not in (1, 2) or sorted(axis) != [0, 0, 1]:
        text = " ".join(f"{v:g}" for v in row)
        raise FormatError(cal.path, cal.at, expected="a translation (1) or rotation (2) along x, y or z", found=text)
    return 3 * (kind - 1) + int(np.argmax(axis))


def _place(folder: Path, case: dict, body: int | None) -> int:
    count = len(case["bodies"])
    if body is None and count > 1:
        raise SeveralBodies(folder, [str(k + 1) for k in range(count)])
    place = (body or 1) - 1
    if not 0 <= place < count:
        raise FormatError(folder, expected=f"body {body}", found=f"{count} bodies")
    own = case["bodies"][place]
    if sorted(own["modes"]) != list(range(6)) or sorted(own["forces"]) != list(range(6)):
        raise FormatError(folder, expected="the six rigid motions and forces of the body", found=f"{own['modes']}")
    return place


def _zones(path: Path, columns: int, count: int) -> tuple[np.ndarray, list[str], np.ndarray]:
    """Return frequencies (n) [rad/s], zone titles (z) and numbers (z, n, columns) of a Tecplot file."""
    lines = read_lines(path)
    unit = next((u for u in _UNITS if u in lines[0]), None)
    if unit is None:
        raise FormatError(path, 1, expected='VARIABLES="w (rad/s)", Hz or s', found=lines[0])
    starts = [k for k, line in enumerate(lines) if line.lstrip().lower().startswith("zone")]
    if len(starts) != count:
        raise FormatError(
            path,
            expected=f"{count} zones, as Nemoh.cal announces",
            found=f"{len(starts)}",
            hint="Is the file complete?",
        )
    tables = []
    for first, last in zip(starts, [*starts[1:], len(lines)], strict=True):
        table, _ = number_table(path, lines[first + 1 : last], first + 2, (columns,), f"a row of {columns} numbers")
        announced = re.search(r"I\s*=\s*(\d+)", lines[first])
        if announced and int(announced.group(1)) != len(table):
            raise FormatError(
                path, first + 1, expected=f"{announced.group(1)} rows in this zone", found=f"{len(table)}"
            )
        if tables and (len(table) != len(tables[0]) or not np.array_equal(table[:, 0], tables[0][:, 0])):
            raise FormatError(path, first + 1, expected="the frequencies of the first zone", found="others")
        tables.append(table)
    values = np.array(tables)
    column = values[0, :, 0]
    if np.any(column <= 0):
        raise FormatError(path, starts[0] + 2, expected="frequencies above zero", found=f"{column.min():g}")
    return _UNITS[unit](column), [lines[k] for k in starts], values[:, :, 1:]


def _radiation(path: Path, case: dict, place: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return omega and the body's added mass and damping (n, 6, 6): a zone a motion, two columns a force."""
    forces = sum(len(b["forces"]) for b in case["bodies"])
    motions = sum(len(b["modes"]) for b in case["bodies"])
    omega, _, values = _zones(path, 1 + 2 * forces, motions)
    order = np.argsort(omega)
    rows, columns = _own(case, place, "modes"), _own(case, place, "forces")
    pairs = values.reshape(motions, len(omega), forces, 2)[rows][:, :, columns][:, order]
    added, damping = np.moveaxis(pairs, -1, 0).transpose(0, 2, 3, 1)
    return omega[order], added, damping


def _own(case: dict, place: int, what: str) -> list[int]:
    """Return where the body's six motions or forces are, in the order surge to yaw."""
    start = sum(len(b[what]) for b in case["bodies"][:place])
    own = case["bodies"][place][what]
    return [start + own.index(k) for k in range(6)]


def _force(path: Path, case: dict, place: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return omega, heading [deg] and the body's force (m, n, 6) as the file has it, e^{-i omega t}."""
    forces = sum(len(b["forces"]) for b in case["bodies"])
    omega, titles, values = _zones(path, 1 + 2 * forces, case["headings"])
    found = [_BETA.search(t) for t in titles]
    if None in found:
        raise FormatError(path, expected="'beta =' in the title of every zone", found=titles[found.index(None)])
    heading = np.array([number_at(path, None, f.group(1)) for f in found])
    polar = values.reshape(len(titles), len(omega), forces, 2)[:, :, _own(case, place, "forces")]
    if np.any(np.abs(polar[..., 1]) > 2 * np.pi + 1e-3):
        raise FormatError(path, expected="phases in radians", found=f"{np.abs(polar[..., 1]).max():g}")
    order = np.argsort(omega)
    return omega[order], heading, (polar[..., 0] * np.exp(1j * polar[..., 1]))[:, order]


def _excitation(path: Path, results: Path, case: dict, place: int, omega: np.ndarray) -> dict:
    """Return heading and excitation, conjugated and with the crest at the origin; checked against its two parts."""
    own, heading, force = _force(path, case, place)
    if len(own) != len(omega) or not np.allclose(own, omega, rtol=1e-5):
        raise FormatError(
            path, expected=f"the {len(omega)} frequencies of the radiation", found=f"{len(own)}, not the same"
        )
    parts = [_find(results, name, needed=False) for name in ("FKForce.tec", "DiffractionForce.tec")]
    if all(parts):
        total = sum(_force(p, case, place)[2] for p in parts)
        error = np.abs(total - force).max(axis=(0, 1)) / np.repeat(np.abs(force).reshape(-1, 2, 3).max(axis=(0, 2)), 3)
        if error.max() > 1e-3:
            raise FormatError(
                path, expected="the sum of FKForce.tec and DiffractionForce.tec",
                found=f"{error.max():.2g} of the largest off", hint="One of the three is corrupt or of another run",
            )  # fmt: skip
    angle = np.radians(heading)
    k = wave_number(path, omega, case["depth"], case["gravity"])
    return {"heading": angle, "excitation": phase_to_origin(np.conj(force), angle, k, case["wave_point"])}


def _check_frequencies(path: Path, case: dict, omega: np.ndarray) -> None:
    wrong_range = case["range"] and not np.isclose(omega[-1], case["range"][-1], rtol=1e-3)
    if len(omega) != case["frequencies"] or wrong_range:
        raise FormatError(
            path, expected=f"{case['frequencies']} frequencies up to {case['range'][-1]:g} rad/s, as in Nemoh.cal",
            found=f"{len(omega)} up to {omega[-1]:g}", hint="Do the results belong to this Nemoh.cal?",
        )  # fmt: skip


def _statics(folder: Path, count: int, place: int) -> dict:
    """Return volume, centres and the stiffness about the centre of gravity, as far as Mesh/ has them."""
    mesh = _find(folder, "Mesh", directory=True, needed=False)
    if mesh is None:
        return {}
    tag = "" if count == 1 else f"_{place}"
    summary = _find(mesh, f"Hydrostatics{tag}.dat", needed=False)
    if summary is None:
        return {}
    out = _summary(summary)
    matrix = _find(mesh, f"KH{tag}.dat", needed=False)
    if matrix:
        table, _ = number_table(matrix, read_lines(matrix), 1, (6,), "a row of 6 numbers")
        if table.shape != (6, 6):
            raise FormatError(matrix, expected="6 rows of 6 numbers", found=f"{len(table)} rows")
        out["stiffness"] = table
    return out


def _summary(path: Path) -> dict:
    text = "\n".join(read_lines(path))
    number = r"\s*=\s*([-+]?[\d.]+(?:[EeDd][-+]?\d+)?)"
    found = {}
    for label in ("XF", "YF", "ZF", "XG", "YG", "ZG", "Displacement"):
        match = re.search(label + number, text)
        if match is None:
            raise FormatError(path, expected=f"'{label} = ' with a number", found="none", hint="Is the file complete?")
        found[label] = number_at(path, None, match.group(1))
    return {
        "volume": found["Displacement"],
        "centre_of_buoyancy": np.array([found[c + "F"] for c in "XYZ"]),
        "centre_of_gravity": np.array([found[c + "G"] for c in "XYZ"]),
    }


def _recognises(path, head: bytes) -> bool:
    path = Path(path)
    if path.is_dir():
        return _find(path, "Nemoh.cal", needed=False) is not None
    return path.name.lower() == "nemoh.cal" or (
        path.suffix.lower() == ".tec" and b"VARIABLES=" in head and b'"w (rad' in head
    )


NEMOH = Format(
    name="Nemoh result folder",
    recognises=_recognises,
    read=read_nemoh,
    describe=describe_hydro,
    problems=hydro_problems,
)
