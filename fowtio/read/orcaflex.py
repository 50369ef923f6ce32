"""OrcaFlex vessel types in a text data file (.yml), as OrcaFlex and OrcaWave write them.

Source of the format: OrcaFlex's help, pages on vessel types (conventions, structure, load RAOs, stiffness, added mass
and damping). SI there means tonnes, kilonewtons, metres. The file states its own conventions of frequency, phase and
sign, and they are obeyed. OrcaFlex's hydrostatic stiffness has the weight's share; it is taken off with the draught's
mass and centre of mass. OrcaFlex has no gravity setting in SI: 9.80665 m/s2.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from fowtio.errors import FormatError
from fowtio.read.hydro_common import (
    check_damping,
    choose_body,
    coefficients,
    describe_hydro,
    hydro_problems,
    phase_to_origin,
    wave_number,
)
from fowtio.read.registry import Format
from fowtio.read.text import number, read_lines
from model.conventions import move_force, weight_stiffness
from model.system.hydro import HydroCoefficients

GRAVITY = 9.80665
_KILO = 1000.0  # tonnes, kilonewtons
_MODES = ("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")
_AXES = ("X", "Y", "Z", "Rx", "Ry", "Rz")
_SIGNS = {
    "SurgePositive": ("forward", "aft"), "SwayPositive": ("port", "starboard"), "HeavePositive": ("up", "down"),
    "RollPositiveStarboard": ("down", "up"), "PitchPositiveBow": ("down", "up"),
    "YawPositiveBow": ("port", "starboard"),
}  # fmt: skip
_EVENTS = {"crest": 0.0, "zero up-crossing": 0.5 * np.pi, "trough": np.pi, "zero down-crossing": -0.5 * np.pi}
_KEY = re.compile(r"([^\s#:\[-][^:#]*?)\s*:(?:\s+(.*))?$")


def read_orcaflex(
    path: str | Path, *, body: str | int | None = None, draught: str | int | None = None, depth: float | None = None
) -> HydroCoefficients:
    """Return the coefficients of a vessel type of an OrcaFlex text file, about the vessel's origin, crest there.

    body names the vessel type (or its number from 1) and draught its draught, where there are several. depth [m] of the
    diffraction run, where it is not that of the file's Environment (the vessel type does not keep it). Raises
    FormatError, also for units other than SI and for constant added mass.
    """
    path = Path(path)
    tree = _Tree(path, read_lines(path)).parse()
    units = _get(path, tree, "General", "UnitsSystem")
    if units != "SI":
        raise FormatError(
            path, expected="UnitsSystem SI", found=str(units), hint="Change the units in OrcaFlex and save again"
        )
    types = _get(path, tree, "VesselTypes")
    vessel = types[choose_body(path, body, [t.get("Name") for t in types], "vessel type")]
    draughts = _get(path, vessel, "Draughts")
    own = draughts[choose_body(path, draught, [d.get("Name") for d in draughts], "draught")]
    density = _KILO * _number(path, _get(path, tree, "Environment", "Density"))
    depth = _number(path, _get(path, tree, "Environment", "WaterDepth")) if depth is None else depth
    to_omega = _frequency(path, vessel)
    point = _point(path, own, "ReferenceOrigin")
    radiation = _radiation(path, own, to_omega, _get(path, vessel, "WavesReferredToBy").startswith("period"))
    check_damping(path, radiation["radiation_damping"], radiation["omega"])
    volume = _number(path, _get(path, own, "DisplacedVolume"))
    buoyancy = _point(path, own, "CentreOfBuoyancy")
    stiffness = _stiffness(path, own, point, density * GRAVITY * volume, buoyancy)
    force = _load_raos(path, vessel, own, to_omega, radiation["omega"], depth, point)
    return coefficients(
        path, point=point, **radiation, **force, hydrostatic_stiffness=stiffness, volume=volume,
        centre_of_buoyancy=buoyancy, density=density, gravity=GRAVITY, depth=depth,
    )  # fmt: skip


class _Tree:
    """The part of YAML that OrcaFlex writes: nested keys, lists of '-', flow lists that may go on over lines."""

    def __init__(self, path: Path, lines: list[str]):
        self.path, self.items = path, []
        pending = None
        for k, line in enumerate(lines):
            text = line.strip()
            if pending is not None:
                pending[2] += " " + text
            elif not text or text.startswith(("#", "%", "---", "...")):
                continue
            else:
                pending = [k + 1, len(line) - len(line.lstrip(" ")), text]
            if pending[2].count("[") <= pending[2].count("]") or "[" not in self._value(pending[2])[:1]:
                self.items.append(tuple(pending))
                pending = None
        if pending is not None:
            raise FormatError(
                path, pending[0], expected="a list closed by ]", found=pending[2], hint="Is the file complete?"
            )
        self.at = 0

    @staticmethod
    def _value(text: str) -> str:
        """Return what follows a dash or a key."""
        text = re.sub(r"^(-\s+)+", "", text)
        key = _KEY.match(text) if not text.startswith("[") else None
        return (key.group(2) or "") if key else text

    def parse(self):
        """Return the whole as dictionaries, lists and texts."""
        out = self._block(self.items[0][1] if self.items else 0)
        if self.at < len(self.items):
            line, _, text = self.items[self.at]
            raise FormatError(self.path, line, expected="a key at the same indentation as its neighbours", found=text)
        if not isinstance(out, dict):
            raise FormatError(self.path, expected="keys of an OrcaFlex text file", found="none")
        return out

    def _block(self, indent: int):
        first = self.items[self.at][2] if self.at < len(self.items) else ""
        return self._list(indent) if first.startswith("-") else self._dict(indent)

    def _dict(self, indent: int) -> dict:
        out: dict = {}
        while self.at < len(self.items):
            line, own, text = self.items[self.at]
            if own != indent or text.startswith("- "):
                break
            key = _KEY.match(text)
            if key is None:
                raise FormatError(self.path, line, expected="'name: value'", found=text)
            self.at += 1
            out[key.group(1)] = self._rest(key.group(2), indent, line)
        return out

    def _list(self, indent: int) -> list:
        out: list = []
        while self.at < len(self.items):
            line, own, text = self.items[self.at]
            if own != indent or not text.startswith("-"):
                break
            rest = text[1:].lstrip()
            inner = indent + len(text) - len(rest)
            if rest and not rest.startswith(("[", '"')) and _KEY.match(rest):
                self.items[self.at] = (line, inner, rest)
                out.append(self._dict(inner))
            else:
                self.at += 1
                out.append(self._rest(rest, indent, line))
        return out

    def _rest(self, text: str | None, indent: int, line: int):
        """Return the value after a key or dash: what stands there, or the block below."""
        if text:
            return _flow(self.path, line, text) if text.startswith("[") else text.strip('"')
        if self.at < len(self.items):
            _, own, following = self.items[self.at]
            if own > indent or (own == indent and following.startswith("- ")):
                return self._block(own)
        return None


def _flow(path: Path, line: int, text: str) -> list:
    """Return a flow list of texts '[a, b, [c, d]]'; comments are not allowed inside."""
    stack: list[list] = [[]]
    for token in re.findall(r"\[|\]|[^\[\],]+", text):
        if token == "[":
            stack.append([])
        elif token == "]":
            if len(stack) < 2:
                raise FormatError(path, line, expected="a list in brackets", found=text)
            inner = stack.pop()
            stack[-1].append(inner)
        elif token.strip():
            stack[-1].append(token.strip())
    if len(stack) != 1 or len(stack[0]) != 1:
        raise FormatError(path, line, expected="a list in brackets", found=text)
    return stack[0][0]


def _get(path: Path, tree, *keys: str):
    for key in keys:
        if not isinstance(tree, dict) or tree.get(key) is None:
            raise FormatError(path, expected=f"'{key}:' with a value", found="none", hint="Is the file complete?")
        tree = tree[key]
    return tree


def _number(path: Path, text) -> float:
    if isinstance(text, float) or str(text) == "Infinity":
        return float(str(text).replace("Infinity", "inf"))
    try:
        return number(text)
    except (ValueError, AttributeError, TypeError):
        raise FormatError(path, expected="a number", found=str(text)) from None


def _point(path: Path, tree, key: str, otherwise=None) -> np.ndarray:
    """Return the point (3) [m] under a key; '~' stands for the coordinate of `otherwise` where that is given."""
    values = _get(path, tree, key)
    if not isinstance(values, list) or len(values) != 3:
        raise FormatError(path, expected=f"three coordinates under {key}", found=str(values))
    if otherwise is not None:
        values = [o if v == "~" else v for v, o in zip(values, otherwise, strict=True)]
    return np.array([_number(path, v) for v in values])


def _matrix(path: Path, tree, key: str, shape: tuple[int | None, int]) -> np.ndarray:
    """Return the table of numbers under a key; shape[0] None is any number of rows."""
    rows = _get(path, tree, key)
    widths = {len(r) if isinstance(r, list) else 0 for r in rows} if isinstance(rows, list) else {0}
    if widths != {shape[1]} or (shape[0] is not None and len(rows) != shape[0]):
        what = f"{shape[0] or 'rows'} x {shape[1]} numbers under {key.split(',')[0]}"
        raise FormatError(
            path, expected=what, found=f"{len(rows)} rows of {sorted(widths)}", hint="Is the file complete?"
        )
    try:
        return np.array([[number(v) for v in row] for row in rows])
    except (ValueError, AttributeError):
        raise FormatError(path, expected=f"numbers under {key.split(',')[0]}", found="others") from None


def _frequency(path: Path, vessel: dict):
    """Return the function from the file's frequency or period to omega."""
    text = _get(path, vessel, "WavesReferredToBy")
    functions = {
        "frequency (rad/s)": lambda w: w, "frequency (Hz)": lambda f: 2 * np.pi * f,
        "period (s)": lambda t: 2 * np.pi / np.where(np.asarray(t) == 0, 1e-300, t),
    }  # fmt: skip
    if text not in functions:
        raise FormatError(path, expected=" or ".join(functions), found=text)
    return functions[text]


def _radiation(path: Path, own: dict, to_omega, period: bool) -> dict:
    """Return omega, added mass, damping and limits; frequency zero and infinity are the limits."""
    method = _get(path, own, "AMDMethod")
    if method != "Frequency dependent":
        raise FormatError(path, expected="AMDMethod 'Frequency dependent'", found=method)
    blocks = _get(path, own, "FrequencyDependentAddedMassAndDamping")
    values, added, damping = [], [], []
    for block in blocks:
        values.append(_number(path, _get(path, block, "AMDPeriodOrFrequency")))
        added.append(_matrix(path, block, ", ".join(f"AddedMassMatrix{a}" for a in _AXES), (6, 6)))
        damping.append(_matrix(path, block, ", ".join(f"Damping{a}" for a in _AXES), (6, 6)))
    values, added, damping = np.array(values), _KILO * np.array(added), _KILO * np.array(damping)
    infinite, zero = (values == 0, np.isinf(values)) if period else (np.isinf(values), values == 0)
    finite = ~(infinite | zero)
    if np.any(values < 0) or not np.any(finite):
        raise FormatError(path, expected="added mass and damping at finite frequencies", found=f"{values}")
    return {
        "omega": np.asarray(to_omega(values[finite]), dtype=float), "added_mass": added[finite],
        "radiation_damping": damping[finite], "added_mass_zero": added[zero][0] if np.any(zero) else None,
        "added_mass_infinite": added[infinite][0] if np.any(infinite) else None,
    }  # fmt: skip


def _stiffness(path: Path, own: dict, point, lift: float, buoyancy) -> np.ndarray:
    """Return the buoyancy stiffness (6, 6) about the reference origin.

    The file has the heave, roll and pitch columns of weight and buoyancy together; the weight's share is taken off and
    the yaw column of the buoyancy added, which moves nothing but is part of a buoyancy alone.
    """
    matrix = np.zeros((6, 6))
    key = "HydrostaticStiffnessz, HydrostaticStiffnessRx, HydrostaticStiffnessRy"
    matrix[2:5, 2:5] = _KILO * _matrix(path, own, key, (3, 3))
    mass = _KILO * _number(path, _get(path, own, "Mass"))
    centre = _point(path, own, "CentreOfMass")
    matrix[2:5, 2:5] -= weight_stiffness(mass, centre - point, GRAVITY)[2:5, 2:5]
    matrix[3:5, 5] = weight_stiffness(-lift, buoyancy - point, 1.0)[3:5, 5]
    return matrix


def _load_raos(path: Path, vessel: dict, own: dict, to_omega, omega, depth: float, point) -> dict:
    """Return heading and excitation (m, n, 6) about `point`, crest at the vessel's origin; {} when there are none."""
    raos = _get(path, own, "LoadRAOs")
    tables = raos.get("RAOs")
    if not tables:
        return {}
    names = ", ".join(["RAOPeriodOrFrequency", *(f"RAO{m}{part}" for m in _MODES for part in ("Amp", "Phase"))])
    origin = _point(path, raos, "RAOOrigin")
    phase_origin = _point(path, raos, "PhaseOrigin", origin)
    heading, force = [], []
    for table in tables:
        heading.append(_number(path, _get(path, table, "RAODirection")))
        rows = _matrix(path, table, names, (None, 13))
        own_omega = np.asarray(to_omega(rows[:, 0]), dtype=float)
        order, want = np.argsort(own_omega), np.argsort(omega)
        if len(rows) != len(omega) or not np.allclose(own_omega[order], omega[want], rtol=1e-6):
            raise FormatError(
                path, expected=f"load RAOs at the {len(omega)} frequencies of the added mass", found=f"at {len(rows)}"
            )
        sorted_rows = np.empty_like(rows)
        sorted_rows[want] = rows[order]
        force.append(_phasors(path, vessel, sorted_rows[:, 1::2], sorted_rows[:, 2::2]))
    angle = np.radians(heading)
    excitation = move_force(np.array(force), point - origin)
    return {
        "heading": angle,
        "excitation": phase_to_origin(excitation, angle, wave_number(path, omega, depth, GRAVITY), phase_origin),
    }


def _phasors(path: Path, vessel: dict, amplitude: np.ndarray, phase: np.ndarray) -> np.ndarray:
    """Return complex forces [N, N m per metre of amplitude] by the conventions that the vessel type states."""
    phase = (
        np.radians(phase)
        if _choice(path, vessel, "RAOPhaseUnitsConvention", ("degrees", "radians")) == "degrees"
        else phase
    )
    lead = 1.0 if _choice(path, vessel, "RAOPhaseConvention", ("leads", "lags")) == "leads" else -1.0
    event = _EVENTS[_choice(path, vessel, "RAOPhaseRelativeToConvention", tuple(_EVENTS))]
    half = 1.0 if _choice(path, vessel, "RAOWaveUnit", ("amplitude", "double amplitude")) == "amplitude" else 2.0
    signs = [1.0 if _choice(path, vessel, key, values) == values[0] else -1.0 for key, values in _SIGNS.items()]
    return _KILO * half * np.array(signs) * amplitude * np.exp(1j * (lead * phase + event))


def _choice(path: Path, vessel: dict, key: str, values: tuple[str, ...]) -> str:
    text = _get(path, vessel, key)
    if text not in values:
        raise FormatError(path, expected=f"{key}: {' or '.join(values)}", found=text)
    return text


def _recognises(path, head: bytes) -> bool:
    return b"OrcaFlex" in head[:400] and Path(path).suffix.lower() in (".yml", ".yaml")


ORCAFLEX = Format(
    name="OrcaFlex vessel type (.yml)",
    recognises=_recognises,
    read=read_orcaflex,
    describe=describe_hydro,
    problems=hydro_problems,
)
