"""A hull as a ready study: an OpenFAST deck with coefficients, members, moorings and turbine, and the study file.

The files of the embedded case serve as the form; values and tables are replaced by name.
"""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fowtio.hull_turbine import MATRICES, reference_folder
from fowtio.start import embedded_folder
from fowtio.write.hydro import write_wamit
from model.system.hydro import HydroCoefficients
from model.system.turbine import RigidBody

STORM = ("storm", 0.0, "none", "jonswap", 7.0, 12.0)
LINEARISED = "oc4_deepcwind/linearisation/turbine"
TURBINES = {"nrel5mw": ("oc4_deepcwind", "NREL 5 MW"), "dtu10mw": ("dtu10mw", "DTU 10 MW")}


@dataclass(frozen=True, eq=False, kw_only=True)
class Member:
    """A cylinder with strip drag: name, start and end (3) [m] (start is the lower), diameter [m], Cd, and AxCd at its start."""

    name: str
    start: np.ndarray
    end: np.ndarray
    diameter: float
    drag: float
    axial_drag: float = 0.0


@dataclass(frozen=True, eq=False, kw_only=True)
class Line:
    """A mooring line: anchor and fairlead (3) [m], length [m], mass per length in air [kg/m], diameter [m], EA [N]."""

    anchor: np.ndarray
    fairlead: np.ndarray
    length: float
    mass: float
    diameter: float
    stiffness: float


@dataclass(frozen=True, eq=False, kw_only=True)
class DeckPlan:
    """What a deck and its study say of a floating hull; turbine is a key of TURBINES; added_stiffness and added_damping (6, 6) are
    HydroDyn's; linearisations are wind speeds [m/s] and their folders in LINEARISED (none: the turbine's matrices by wind speed, where there
    are); states are name, wind speed, turbulence, spectrum, significant height [m] and peak period [s];
    hull_file, of the reference data, is drawn where members do not tell the hull's shape; published are natural periods [s] by mode.
    """

    name: str
    title: str
    turbine: str
    platform: RigidBody
    hydro: HydroCoefficients
    members: Sequence[Member]
    lines: Sequence[Line]
    depth: float
    added_stiffness: np.ndarray | None = None
    added_damping: np.ndarray | None = None
    linearisations: Sequence[tuple[float, str]] = ()
    states: Sequence[tuple[str, float, str, str, float, float]] = (STORM,)
    hull_file: str | None = None
    published: Sequence[tuple[str, float]] = ()


def write_deck(plan: DeckPlan, folder: str | Path) -> Path:
    """Write deck, coefficients and study of a hull into a folder and return the study file."""
    folder = Path(folder)
    inputs = folder / "input"
    (inputs / "hydro").mkdir(parents=True, exist_ok=True)
    write_wamit(plan.hydro, inputs / "hydro" / plan.name)
    form = embedded_folder() / "input"
    own = reference_folder(TURBINES[plan.turbine][0]) / "input"
    for name in ("ElastoDyn_Blade.dat", "ElastoDyn_Tower.dat"):
        shutil.copyfile(own / name, inputs / name)
    for name in ("SeaState.dat", "InflowWind.dat"):
        shutil.copyfile(form / name, inputs / name)
    _write(inputs / "ElastoDyn.dat", _elastodyn(plan, (own / "ElastoDyn.dat").read_text()))
    _write(inputs / "HydroDyn.dat", _hydrodyn(plan, (form / "HydroDyn.dat").read_text()))
    _write(inputs / "MAP.dat", _moorings(plan, (form / "MAP.dat").read_text()))
    main = set_values((form / "oc4.fst").read_text(), {"WtrDpth": f"{plan.depth:g}"})
    _write(
        inputs / f"{plan.name}.fst", _titled(main, f"{TURBINES[plan.turbine][1]} on {plan.title}, parked, JONSWAP sea")
    )
    study = folder / f"{plan.name}.fowt"
    _write(study, _study(plan, folder))
    return study


def set_values(text: str, values: dict[str, str]) -> str:
    """Return an input file's text with values replaced by their names; raise KeyError for a name that is not there."""
    for name, value in values.items():
        pattern = re.compile(rf"^(\s*)(\"[^\"]*\"|\S+)(\s+{re.escape(name)}\s+-)", re.MULTILINE)
        text, count = pattern.subn(
            lambda m, v=value: f"{v:>{max(len(m.group(1) + m.group(2)), len(v))}}{m.group(3)}", text
        )
        if not count:
            raise KeyError(f"no value named {name} in the file")
    return text


def plain(value: float) -> str:
    """Return a number as the shortest text that reads back as the same number."""
    text = repr(float(value))
    return text[:-2] if text.endswith(".0") and "e" not in text else text


def _write(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")


def _titled(text: str, title: str) -> str:
    lines = text.split("\n")
    return "\n".join([lines[0], title, *lines[2:]])


def _elastodyn(plan: DeckPlan, text: str) -> str:
    body = plan.platform
    values = {
        "PtfmMass": plain(body.mass), "PtfmCMzt": plain(body.centre[2]), "PtfmRIner": plain(body.inertia[0, 0]),
        "PtfmPIner": plain(body.inertia[1, 1]), "PtfmYIner": plain(body.inertia[2, 2]),
    }  # fmt: skip
    return _titled(set_values(text, values), f"{TURBINES[plan.turbine][1]} on {plan.title}, parked")


def _hydrodyn(plan: DeckPlan, text: str) -> str:
    hydro = plan.hydro
    text = set_values(
        text,
        {
            "PotFile": f'"hydro/{plan.name}"',
            "PtfmVol0": plain(hydro.volume),
            "NExctnHdg": str(len(hydro.heading) - 1),
        },
    )
    for name, matrix in (("AddCLin", plan.added_stiffness), ("AddBLin", plan.added_damping)):
        if matrix is not None:
            text = _set_matrix(text, name, np.asarray(matrix))
    joints, members, coefficients, sections, axial = _member_tables(plan.members)
    for count, rows in (
        ("NAxCoef", axial),
        ("NJoints", joints),
        ("NPropSetsCyl", sections),
        ("NCoefMembersCyl", coefficients),
        ("NMembers", members),
    ):
        text = _set_table(text, count, rows)
    return _titled(text, f"{plan.title}: potential flow, strip drag on its members")


def _set_matrix(text: str, name: str, matrix: np.ndarray) -> str:
    lines = text.split("\n")
    at = next(i for i, line in enumerate(lines) if f" {name} " in line and "- " in line)
    tail = lines[at][lines[at].index(name) :]
    for k in range(6):
        lines[at + k] = " ".join(f"{v:12.5E}" for v in matrix[k]) + (f"   {tail}" if k == 0 else "")
    return "\n".join(lines)


def _set_table(text: str, count: str, rows: list[str]) -> str:
    """Return the text with the rows of the table below a count replaced (two header lines stay)."""
    lines = text.split("\n")
    at = next(i for i, line in enumerate(lines) if re.search(rf"\b{count}\b\s+-", line))
    old = int(lines[at].split()[0])
    lines[at] = re.sub(r"^(\s*)\d+", lambda m: f"{len(rows):>{len(m.group(0))}}", lines[at])
    return "\n".join(lines[: at + 3] + rows + lines[at + 3 + old :])


def _member_tables(plan_members: Sequence[Member]):
    """Return the rows of HydroDyn's tables: joints, members, drag coefficients, sections, axial coefficients."""
    axial_values = sorted({m.axial_drag for m in plan_members} | {0.0})
    diameters = sorted({m.diameter for m in plan_members})
    joints, members, coefficients = [], [], []
    for k, m in enumerate(plan_members, start=1):
        for end, (point, coefficient) in enumerate(((m.start, m.axial_drag), (m.end, 0.0))):
            number = 2 * k - 1 + end
            place = " ".join(f"{plain(v):>12}" for v in point)
            joints.append(f"{number:7d} {place} {axial_values.index(coefficient) + 1:11d}           0")
        size = diameters.index(m.diameter) + 1
        members.append(
            f"{k:8d} {2 * k - 1:9d} {2 * k:9d} {size:11d} {size:11d}        1         0.0 {max(2.0, m.diameter / 4):8.2f}        3        1    TRUE   ! {m.name}"
        )
        coefficients.append(f"{k:5d} {plain(m.drag)} {plain(m.drag)}" + " 0.00" * 22 + " 1.00" * 4)
    sections = [f"{k:9d} {plain(d):>10}     0.06000" for k, d in enumerate(diameters, start=1)]
    axial = [
        f"{k:5d} {plain(v):>8}     0.00     1.00      0        0.00       1.00" for k, v in enumerate(axial_values, start=1)
    ]
    return joints, members, coefficients, sections, axial


def _moorings(plan: DeckPlan, text: str) -> str:
    """Return a MAP++ file with every line of the plan."""
    kinds = list(dict.fromkeys((line.diameter, line.mass, line.stiffness) for line in plan.lines))
    lines = text.split("\n")
    heads = [i for i, line in enumerate(lines) if line.startswith("---")]

    def head(k):
        return lines[heads[k] : heads[k] + 3]

    dictionary = [
        f"line{k}  {plain(d):>10} {plain(m):>10} {plain(s):>12}      1.0    0        0    0        0"
        for k, (d, m, s) in enumerate(kinds, start=1)
    ]
    nodes, rows = [], []
    for k, line in enumerate(plan.lines, start=1):
        anchor = " ".join(f"{plain(v):>11}" for v in line.anchor[:2])
        floor = abs(line.anchor[2] + plan.depth) < 1e-6
        nodes.append(
            f"{2 * k - 1:4d} fix    {anchor} {'depth' if floor else plain(line.anchor[2]):>11}   0     0     #     #     #"
        )
        nodes.append(f"{2 * k:4d} Vessel {' '.join(f'{plain(v):>11}' for v in line.fairlead)}   0     0     #     #     #")
        kind = kinds.index((line.diameter, line.mass, line.stiffness)) + 1
        rows.append(
            f"{k:3d} line{kind}  {plain(line.length):>12} {2 * k - 1:6d} {2 * k:6d}   tension_fair h_fair v_fair tension_anch"
        )
    return "\n".join(
        [*head(0), *dictionary, *head(1), *nodes, *head(2), *rows, *lines[heads[3] : heads[3] + 3], "help", ""]
    ).replace("\nhelp\n", "\n")


def _study(plan: DeckPlan, folder: Path) -> str:
    """Return the text of the study file."""
    matrices, rows = None, ""
    if plan.linearisations:
        files = _at_hand(LINEARISED, folder, "linearisation")
        rows = "".join(f'{speed:<6g}     "{files}/{name}/m.*.lin"  "{files}/{name}/turbine.fst"  auto\n' for speed, name in plan.linearisations)
    elif (reference_folder(TURBINES[plan.turbine][0]) / MATRICES).is_file():
        matrices = _at_hand(f"{TURBINES[plan.turbine][0]}/{MATRICES}", folder, f"input/{MATRICES}")
    hull = f'"{_at_hand(plan.hull_file, folder, "hull.toml")}"  HullFile      - shape of the hull, for the picture\n' if plan.hull_file else ""
    named = f'"{matrices}"  TurbineFile   - matrices of the turbine by wind speed\n' if matrices else ""
    known = "".join(f"{mode:<10}  {period:g}\n" for mode, period in plan.published)
    published = f"""---------------------- PUBLISHED NATURAL PERIODS -------------------------------
{len(plan.published)}                NPub          - rows of the table
Mode        Period
(-)         (s)
{known}""" if known else ""
    states = [_state_row(*state) for state in (("white_noise", 0.0, "none", "white_noise", 1.766352, "-"), *plan.states)]
    return f"""------- FOWTIO STUDY FILE ------------------------------------------------------
{TURBINES[plan.turbine][1]} on {plan.title}
---------------------- MODEL ---------------------------------------------------
"input/{plan.name}.fst"  Deck          - OpenFAST primary file (quoted string)
"DEFAULT"        HydroFile     - hydrodynamic coefficients; DEFAULT: what the deck names
{named}{hull}7                DOFs          - six platform motions and the tower's first fore-aft mode
---------------------- LINEARISATIONS ------------------------------------------
{len(plan.linearisations)}                NLin          - operating points with linearisation files
WindSpeed  LinFiles  LinDeck  MassMatrix
(m/s)      (-)       (-)      (-)
{rows}---------------------- SEA AND WIND STATES -------------------------------------
{len(states)}                NStates       - rows of the table
Name          WindSpeed  Turbulence  Spectrum     Hs        Tp    Gamma  WaveDir
(-)           (m/s)      (- or %)    (-)          (m)       (s)   (-)    (deg)
{chr(10).join(states)}
---------------------- OPTIONS -------------------------------------------------
"hydrostatic"    LowFreqExctn  - excitation below the data: hold (lowest value, as HydroDyn) or hydrostatic (its limit)
{published}END of study
"""


def _state_row(name: str, wind: float, turbulence: str, spectrum: str, height: float, period: float | str) -> str:
    return f"{name:<13} {wind:<10.1f} {turbulence:<11} {spectrum:<12} {height:<9.7g} {period!s:<5} -      0.0"


def _at_hand(data: str, folder: Path, place: str) -> str:
    """Return the path from a study's folder to reference data: to where they lie when the study is a reference too, else to a copy."""
    root = reference_folder("").resolve()
    if folder.resolve().is_relative_to(root):
        return Path(os.path.relpath(root / data, folder.resolve())).as_posix()
    copy = shutil.copytree if (root / data).is_dir() else shutil.copyfile
    if not (folder / place).exists():
        copy(root / data, folder / place)
    return place
