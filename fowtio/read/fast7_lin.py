"""FAST v7 linearisation files (.lin): all azimuths in one, of first order (A, B, C, D) or of second (M, C, K, F).

Each block has one line a row, its groups of columns separated by bars: operating points, then matrices. Wind
disturbances come after the control inputs. Source of the layout: J. M. Jonkman and M. L. Buhl, FAST User's Guide,
NREL/EL-500-38230, 2005, chapter on linearisation, and what FAST v7 writes.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from fowtio.errors import FormatError
from fowtio.read.openfast_lin import state_dof
from fowtio.read.registry import Format
from fowtio.read.text import is_number, number, numbers, read_lines
from model.system.linearisation import Linearisation

_COUNTS = {
    "azimuths": "Number of equally-sp",
    "order": "Order of linearized model",
    "dofs": "Number of active (enabled) DOFs",
    "controls": "Number of control inputs",
    "winds": "Number of input wind disturbances",
    "outputs": "Number of output measurements",
}
_LISTS = {
    "dofs": ("Order of States in Linearized State Matrices", "Row/column"),
    "controls": ("Order of Control Inputs in Linearized State Matrices", "Column"),
    "winds": ("Order of Input Wind Disturbances in Linearized State Matrices", "Column"),
    "outputs": ("Order of Output Measurements in Linearized State Matrices", "Row"),
}
_AZIMUTH = re.compile(r"Azimuth\s*=\s*([-+.\dEe]+).*AzimB1Up\s*=\s*([-+.\dEe]+)", re.IGNORECASE)
_ITEM = re.compile(r"^(?:Row/column|Column|Row)\s+(\d+)\s*=\s*(.*)$")
_VALUE = re.compile(r"\s([-+]?\d\.\d+E[-+]\d+)\s+op$")


def read_fast7_lin(path: str | Path) -> tuple[Linearisation, ...]:
    """Return the records of a FAST v7 linearisation file, one an azimuth; raise FormatError.

    States are the displacements, then the velocities of the degrees of freedom; inputs the controls, then the wind
    disturbances. A second-order file is turned into first order, x'' = M^-1 (F u - C x' - K x); its matrices M, C, K, F
    and Fd are in `jacobians`. FAST v7 does not say which outputs turn with the rotor: all are marked as not.
    """
    path = Path(path)
    lines = read_lines(path)
    counts = {name: _count(path, lines, label) for name, label in _COUNTS.items()}
    if counts["order"] not in (1, 2):
        raise FormatError(path, expected="a model of order 1 or 2", found=str(counts["order"]))
    names = {key: _names(path, lines, key, counts[key]) for key in _LISTS}
    speed = _labelled(path, lines, "Azimuth-average rotor speed")
    starts = [i for i, line in enumerate(lines) if _AZIMUTH.search(line)]
    if len(starts) != counts["azimuths"]:
        raise FormatError(
            path,
            len(lines),
            expected=f"{counts['azimuths']} azimuths",
            found=str(len(starts)),
            hint="Is the file complete?",
        )
    return tuple(_record(path, lines, start, counts, names, number(speed)) for start in starts)


def _labelled(path: Path, lines: list[str], label: str) -> str:
    """Return the first number behind a label, as text."""
    for i, line in enumerate(lines, start=1):
        if line.strip().startswith(label):
            found = next((t for t in line.strip()[len(label) :].split() if is_number(t)), None)
            if found is None:
                raise FormatError(path, i, expected=f"a number after '{label} ...'", found=line)
            return found
    raise FormatError(path, expected=f"a line '{label} ...' of a FAST v7 linearisation file", found="none")


def _count(path: Path, lines: list[str], label: str) -> int:
    text = _labelled(path, lines, label)
    if not text.isdigit():
        raise FormatError(path, expected=f"a whole number after '{label} ...'", found=text)
    return int(text)


def _names(path: Path, lines: list[str], key: str, count: int) -> tuple[tuple[str, float], ...]:
    """Return (name, operating point) of the items of one list."""
    title, kind = _LISTS[key]
    start = next((i for i, line in enumerate(lines) if line.strip().startswith(title)), None)
    if start is None:
        raise FormatError(path, expected=f"'{title}:'", found="none")
    i, out = start + 1, []
    while i < len(lines) and not lines[i].strip():
        i += 1
    for k in range(count):
        text = lines[i + k].strip() if i + k < len(lines) else "end of file"
        match = _ITEM.match(text)
        if not match or int(match[1]) != k + 1 or not text.startswith(kind):
            raise FormatError(path, i + k + 1, expected=f"{kind} {k + 1} of {count} under '{title}'", found=text)
        value = _VALUE.search(match[2])
        name = _VALUE.sub("", match[2]) if value else match[2].split(" : ")[0].split(" :See")[0]
        out.append((" ".join(name.split()), number(value[1]) if value else np.nan))
    return tuple(out)


def _record(path, lines, start, counts, names, speed) -> Linearisation:
    """Return the record of the azimuth whose title stands at line index `start`."""
    q, u, w, y = (counts[k] for k in ("dofs", "controls", "winds", "outputs"))
    title = _AZIMUTH.search(lines[start])
    if counts["order"] == 1:
        widths, rows = [1, 1, 2 * q, u, w], 2 * q
        out_widths = [1, 0, 2 * q, u, w]
    else:
        widths, rows = [1, 1, 1, q, q, q, u, w], q
        out_widths = [1, 0, 0, 0, q, q, u, w]
    keep = [k for k in range(len(widths)) if widths[k] or k < len(widths) - 2]
    at = start + 3
    state = _block(path, lines, at, rows, [widths[k] for k in keep])
    output = (
        _block(path, lines, at + rows + 3, y, [out_widths[k] for k in keep])
        if y
        else [np.zeros((0, out_widths[k])) for k in keep]
    )
    full, full_out = (dict(zip(keep, block, strict=True)) for block in (state, output))
    for k in range(len(widths)):
        full.setdefault(k, np.zeros((rows, 0)))
        full_out.setdefault(k, np.zeros((y, 0)))
    model = _first_order(full, full_out) if counts["order"] == 1 else _second_order(path, start + 1, full, full_out, q)
    return _linearisation(path, model, names, title, speed, q)


def _block(path: Path, lines: list[str], first: int, rows: int, widths: list[int]) -> list[np.ndarray]:
    """Return the groups of columns of consecutive lines, each (rows, width)."""
    out = [np.zeros((rows, width)) for width in widths]
    for r in range(rows):
        i = first + r
        line = lines[i] if i < len(lines) else "end of file"
        parts = line.split("|")
        try:
            values = [numbers(part) for part in parts]
        except ValueError:
            values = []
        if [len(v) for v in values] != widths:
            want = " | ".join(str(w) for w in widths)
            raise FormatError(
                path, i + 1, expected=f"row {r + 1} of {rows} with groups of {want} finite numbers", found=line
            )
        for k, v in enumerate(values):
            out[k][r] = v
    return out


def _first_order(state, output) -> dict:
    return {
        "A": state[2], "B": np.hstack([state[3], state[4]]), "C": output[2], "D": np.hstack([output[3], output[4]]),
        "point": state[1][:, 0], "output": output[0][:, 0], "jacobians": {},
    }  # fmt: skip


def _second_order(path, line, state, output, q) -> dict:
    mass, damping, stiffness = state[3], state[4], state[5]
    force = np.hstack([state[6], state[7]])
    try:
        solved = np.linalg.solve(mass, np.hstack([stiffness, damping, force]))
    except np.linalg.LinAlgError:
        raise FormatError(path, line, expected="a mass matrix that can be inverted", found="a singular one") from None
    rates = np.hstack([np.zeros((q, q)), np.eye(q)])
    return {
        "A": np.vstack([rates, -solved[:, : 2 * q]]), "B": np.vstack([np.zeros_like(force), solved[:, 2 * q :]]),
        "C": np.hstack([output[5], output[4]]), "D": np.hstack([output[6], output[7]]),
        "point": np.concatenate([state[2][:, 0], state[1][:, 0]]), "output": output[0][:, 0],
        "jacobians": {"M": mass, "C": damping, "K": stiffness, "F": state[6], "Fd": state[7]},
    }  # fmt: skip


def _linearisation(path, model, names, title, speed, q) -> Linearisation:
    dofs = tuple(name for name, _ in names["dofs"])
    inputs = names["controls"] + names["winds"]
    turns = ["blade" in name.lower() for name in dofs]
    return Linearisation(
        A=model["A"],
        B=model["B"],
        C=model["C"],
        D=model["D"],
        state_names=dofs + tuple(f"First time derivative of {name}" for name in dofs),
        input_names=tuple(name for name, _ in inputs),
        output_names=tuple(name for name, _ in names["outputs"]),
        state_point=model["point"],
        input_point=tuple(value for _, value in inputs),
        output_point=tuple(model["output"]),
        state_rotating=turns * 2,
        input_rotating=["pitch of blade" in name for name, _ in inputs],
        output_rotating=[False] * len(names["outputs"]),
        state_order=[2] * (2 * q),
        state_dof=tuple(state_dof(name) for name in dofs) * 2,
        state_rate=[False] * q + [True] * q,
        azimuth=float(np.radians(number(title[1]) - number(title[2]))) % (2 * np.pi),
        rotor_speed=speed,
        modules=("FAST v7",),
        source=str(path),
        jacobians=model["jacobians"],
    )


def _recognises(path, head: bytes) -> bool:
    return b"Order of linearized model, MdlOrder" in head


def _describe(records: tuple[Linearisation, ...]) -> list[tuple[str, str]]:
    first = records[0]
    return [
        ("azimuths", ", ".join(f"{np.degrees(r.azimuth):.4g}" for r in records) + " deg"),
        ("order", "second: M, C, K and F are in the file" if first.jacobians else "first"),
        ("degrees of freedom", ", ".join(first.state_dof[: len(first.state_dof) // 2])),
        ("inputs, outputs", f"{len(first.input_names)}, {len(first.output_names)}"),
        ("rotor speed", f"{first.rotor_speed:g} rad/s"),
    ]


FAST7_LIN = Format(name="FAST v7 linearisation (.lin)", recognises=_recognises, read=read_fast7_lin, describe=_describe)
