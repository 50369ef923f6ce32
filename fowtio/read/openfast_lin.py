"""OpenFAST linearisation files (.lin): state matrices with the names and operating points of their rows and columns.

Source of the format: the files that OpenFAST's glue code writes (FAST_Lin.f90), versions 2 to 5.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from fowtio.errors import FormatError
from fowtio.read.registry import Format, head_lines
from fowtio.read.text import number, number_table, numbers, read_lines
from model.system.linearisation import Linearisation

_COUNTS = {
    "states": "Number of continuous states:",
    "discrete": "Number of discrete states:",
    "constraints": "Number of constraint states:",
    "inputs": "Number of inputs:",
    "outputs": "Number of outputs:",
}
_SHAPES = {"A": ("states", "states"), "B": ("states", "inputs"), "C": ("outputs", "states"), "D": ("outputs", "inputs")}
_JACOBIANS = {
    "dXdx": ("states", "states"),
    "dXdu": ("states", "inputs"),
    "dYdx": ("outputs", "states"),
    "dYdu": ("outputs", "inputs"),
    "dUdu": ("inputs", "inputs"),
    "dUdy": ("inputs", "outputs"),
}
_SIZE = re.compile(r"^\s*(\w+)\s*:\s*(\d+)\s*x\s*(\d+)\s*$")
_DOF_INDEX = re.compile(r"internal DOF index = (DOF_\w+(?:\((\d+),\s*(\d+)\))?)\)")
_DOF_NAMES = {
    "DOF_Sg": "surge", "DOF_Sw": "sway", "DOF_Hv": "heave", "DOF_R": "roll", "DOF_P": "pitch", "DOF_Y": "yaw",
    "DOF_TFA1": "tower_fa1", "DOF_TFA2": "tower_fa2", "DOF_TSS1": "tower_ss1", "DOF_TSS2": "tower_ss2",
    "DOF_Yaw": "nacelle_yaw", "DOF_GeAz": "generator_azimuth", "DOF_DrTr": "drivetrain", "DOF_Teet": "teeter",
    "DOF_RFrl": "rotor_furl", "DOF_TFrl": "tail_furl",
}  # fmt: skip
_BLADE_NAMES = {"DOF_BF": "flap", "DOF_BE": "edge"}
_RATE = "First time derivative of "
_ROW = re.compile(r"^\s*(\d+)\s+(.*?)\s+([TF])\s+(.*)$")
_ABBREVIATION = re.compile(r"^[A-Z][A-Za-z]{1,5}(_\d+)? (?=[A-Z0-9])")


def read_openfast_lin(path: str | Path) -> Linearisation:
    """Return one OpenFAST linearisation record, of the whole system or of one module; raise FormatError.

    A file that is cut short, or whose counts, lists and matrices do not agree, is an error. Matrices besides A, B, C
    and D (LinOutJac: dUdu, dUdy, dXdx, ...; StateRotation) are in `jacobians` by name. An orientation's operating
    point is three numbers. Without inputs (LinInputs 0) or outputs (LinOutputs 0) the matrices have no columns or
    rows.
    """
    path = Path(path)
    lines = read_lines(path)
    if not any(line.strip().startswith("Linearized model") for line in lines[:5]):
        raise FormatError(path, 1, expected="'Linearized model: ...' of an OpenFAST .lin file", found=lines[0])
    counts = {name: _count(path, lines, label) for name, label in _COUNTS.items()}
    states = _signals(path, lines, "Order of continuous states:", counts["states"])
    inputs = _signals(path, lines, "Order of inputs:", counts["inputs"])
    outputs = _signals(path, lines, "Order of outputs:", counts["outputs"])
    matrices = _checked(path, lines, _matrices(path, lines), counts)
    return Linearisation(
        **{name: matrices.pop(name) for name in _SHAPES},
        state_names=states[0], input_names=inputs[0], output_names=outputs[0],
        state_point=[p if np.isscalar(p) else p[0] for p in states[1]], input_point=inputs[1], output_point=outputs[1],
        state_rotating=states[2], input_rotating=inputs[2], output_rotating=outputs[2],
        state_order=_orders(path, states), state_dof=tuple(state_dof(name) for name in states[0]),
        state_rate=[_RATE in name for name in states[0]],
        azimuth=_header(path, lines, "Azimuth:"), rotor_speed=_header(path, lines, "Rotor Speed:"),
        wind_speed=_header(path, lines, "Wind Speed:", 0.0),
        modules=_modules(lines), source=str(path), jacobians=matrices,
    )  # fmt: skip


def _count(path: Path, lines: list[str], label: str) -> int:
    """Return a whole number of the header."""
    value = _header(path, lines, label)
    if value != int(value) or value < 0:
        raise FormatError(path, expected=f"a whole number after '{label}'", found=f"{value:g}")
    return int(value)


def _checked(
    path: Path, lines: list[str], matrices: dict[str, np.ndarray], counts: dict[str, int]
) -> dict[str, np.ndarray]:
    """Return the matrices after checking that they are there and as large as the header's counts say."""
    for name, (row, column) in (_SHAPES | _JACOBIANS).items():
        shape = (counts[row], counts[column])
        if name not in matrices and name in _SHAPES:
            if 0 not in shape:
                raise FormatError(
                    path, len(lines), expected=f"matrix {name} ({shape[0]} x {shape[1]})", found="end of file",
                    hint="Is the file complete?",
                )  # fmt: skip
            matrices[name] = np.zeros(shape)
        if name in matrices and matrices[name].shape != shape:
            raise FormatError(
                path, expected=f"matrix {name} of {shape[0]} x {shape[1]}", found=f"{matrices[name].shape}"
            )
    return matrices


def state_dof(name: str) -> str:
    """Return our name of the degree of freedom behind a state of ElastoDyn, or "" when the state is none of its."""
    match = _DOF_INDEX.search(name)
    if match is None:
        return ""
    if match[2]:
        kind = _BLADE_NAMES.get(match[1].split("(")[0])
        return f"blade{match[2]}_{kind}{match[3]}" if kind else ""
    return _DOF_NAMES.get(match[1], "")


def _header(path: Path, lines: list[str], label: str, default: float | None = None) -> float:
    """Return the number behind a label of the 'Simulation information' block."""
    for i, line in enumerate(lines[:60], start=1):
        if line.strip().startswith(label):
            text = line.strip()[len(label) :].split()
            try:
                return number(text[0])
            except (ValueError, IndexError):
                raise FormatError(path, i, expected=f"a number after '{label}'", found=line) from None
    if default is not None:
        return default
    raise FormatError(path, expected=f"a line '{label}'", found="none in the first 60 lines")


def _modules(lines: list[str]) -> tuple[str, ...]:
    """Return the names of the modules that the header says were linked."""
    for line in lines[:6]:
        text = line.strip()
        if text.startswith("linked with"):
            names = [re.sub(r"\(.*?\)", "", part).strip() for part in text[len("linked with") :].split(";")]
            return tuple(name for name in names if name)
    return ()


def _signals(path: Path, lines: list[str], title: str, count: int) -> tuple[tuple, tuple, list, list]:
    """Return names, operating points, rotating-frame flags and the text before the names of one list."""
    if count == 0:
        return (), (), [], []
    start = next((i for i, line in enumerate(lines) if line.strip() == title), None)
    if start is None:
        raise FormatError(path, expected=f"'{title}'", found="none")
    heading = lines[start + 1] if start + 1 < len(lines) else ""
    has_order = "Derivative Order" in heading
    names, points, rotating, orders = [], [], [], []
    for k in range(count):
        i = start + 3 + k
        match = _ROW.match(lines[i]) if i < len(lines) else None
        if match is None or int(match[1]) != k + 1:
            found = lines[i] if i < len(lines) else "end of file"
            raise FormatError(path, i + 1, expected=f"row {k + 1} of {count} under '{title}'", found=found)
        points.append(_point(path, i + 1, match[2]))
        rotating.append(match[3] == "T")
        parts = match[4].split(None, 1)
        if has_order and len(parts) < 2:
            raise FormatError(path, i + 1, expected="a derivative order and a description", found=lines[i])
        order, name = parts if has_order else (None, match[4])
        orders.append(order)
        names.append(name.strip())
    return tuple(names), tuple(points), rotating, orders


def _point(path: Path, line: int, text: str) -> float | tuple[float, ...]:
    """Return an operating point: one number, or three for an orientation."""
    try:
        values = numbers(text)
    except ValueError as error:
        raise FormatError(path, line, expected="an operating point", found=text, hint=str(error)) from None
    if len(values) not in (1, 3):
        raise FormatError(
            path, line, expected="an operating point of one number, or three of an orientation", found=text
        )
    return values[0] if len(values) == 1 else tuple(values)


def _orders(path: Path, states: tuple) -> list[int]:
    """Return the derivative order of each state; without a column of it, 2 for a position and its rate, else 1."""
    names, _, _, orders = states
    if orders and orders[0] is not None:
        if any(order not in ("0", "1", "2") for order in orders):
            bad = next(order for order in orders if order not in ("0", "1", "2"))
            raise FormatError(path, expected="a derivative order 1 or 2 for each state", found=bad)
        return [int(order) for order in orders]
    plain = [_ABBREVIATION.sub("", name.split(",")[0]) for name in names]
    rates = {name.replace(_RATE, "") for name in plain if _RATE in name}
    return [2 if name.replace(_RATE, "") in rates else 1 for name in plain]


def _matrices(path: Path, lines: list[str]) -> dict[str, np.ndarray]:
    """Return every matrix of the file by name, of which a name, a size and as many lines of numbers are read."""
    out = {}
    i = 0
    while i < len(lines):
        match = _SIZE.match(lines[i])
        i += 1
        if not match:
            continue
        name, rows, columns = match[1], int(match[2]), int(match[3])
        if name in out:
            raise FormatError(path, i, expected=f"matrix {name} once", found=lines[i - 1])
        out[name] = _matrix(path, lines[i : i + rows], i + 1, (rows, columns), name)
        i += rows
    return out


def _matrix(path: Path, block: list[str], first: int, shape: tuple[int, int], name: str) -> np.ndarray:
    """Return one matrix of consecutive lines; a line that is not a row of it is named in the error."""
    what = f"a row of {name}, {shape[1]} finite numbers"
    if 0 in shape:
        return np.zeros(shape)
    for k, line in enumerate(block):
        if not line.strip():
            raise FormatError(path, first + k, expected=what, found="a blank line")
    table = number_table(path, block, first, shape[1], what)
    if len(table) != shape[0]:
        raise FormatError(path, first + len(table), expected=what, found="end of file", hint="Is the file complete?")
    return table


def _recognises(path, head: bytes) -> bool:
    return any(line.strip().startswith("Linearized model:") for line in head_lines(head)[:5])


def _describe(lin: Linearisation) -> list[tuple[str, str]]:
    first = int(np.sum(lin.state_order == 1))
    dofs = ", ".join(dict.fromkeys(d for d in lin.state_dof if d))
    more = ", ".join(f"{name} {m.shape[0]} x {m.shape[1]}" for name, m in lin.jacobians.items())
    return [
        ("modules", ", ".join(lin.modules) or "not said"),
        (
            "states",
            f"{len(lin.state_names)}, {first} of first order; degrees of freedom {dofs or 'not known'}",
        ),
        ("inputs, outputs", f"{len(lin.input_names)}, {len(lin.output_names)}"),
        (
            "operating point",
            f"wind {lin.wind_speed:g} m/s, rotor {lin.rotor_speed:g} rad/s, azimuth {np.degrees(lin.azimuth):.4g} deg",
        ),
        ("other matrices", more or "none"),
    ]


OPENFAST_LIN = Format(
    name="OpenFAST linearisation (.lin)", recognises=_recognises, read=read_openfast_lin, describe=_describe
)
