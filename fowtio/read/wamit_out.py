"""WAMIT's formatted output file .out: coefficients, excitation and hydrostatics of one run in one text.

Source of the format: WAMIT User Manual v7, section 5.1. Non-dimensional as the numeric files, but with length scale,
gravity and depth in its head. The hydrostatics include the weight (of the displaced mass, at the centre of gravity that
the run was given); it is taken off here. Phases are whole degrees: the .3 file of the same run is finer.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from fowtio.errors import FormatError
from fowtio.read.hydro_common import (
    coefficients,
    describe_hydro,
    hydro_problems,
    number_at,
    number_table,
    without_weight,
)
from fowtio.read.registry import Format, SeveralBodies
from fowtio.read.text import numbers, read_lines
from fowtio.read.wamit import (
    WamitExcitation,
    WamitRadiation,
    check_polar,
    choose_modes,
    dimensional_excitation,
    dimensional_radiation,
)  # fmt: skip
from model.system.hydro import HydroCoefficients

_PERIOD = re.compile(r"Wave period\s*(?:\(sec\))?\s*=\s*(\S+)")
_SOLVED = re.compile(r"\s+-?\d+\.\d+\s+\d\d:\d\d:\d\d\s")
_NUMBER = r"([-+]?\d[\d.]*(?:[EeDd][-+]?\d+)?)"


def read_wamit_out(
    path: str | Path, *, density: float = 1025.0, body: int | None = None, excitation: str = "diffraction"
) -> HydroCoefficients:
    """Return the coefficients of a WAMIT .out file, dimensional, about the origin.

    density [kg/m3]; body (from 1) of a run with several; excitation "diffraction" or "haskind" (the other one is taken
    when the run has only that). Raises FormatError, also for a body turned against the global axes.
    """
    path = Path(path)
    lines = read_lines(path)
    head = _head(path, lines)
    place = _body_place(path, head["bodies"], body)
    blocks = _blocks(path, lines)
    radiation = _radiation(path, lines, blocks, body)
    length, gravity = head["length"], head["gravity"]
    out = dimensional_radiation(path, radiation, length, density)
    data = _excitation(path, lines, blocks, excitation, body)
    origin = head["bodies"][place]["origin"]
    if data is not None:
        out |= dimensional_excitation(path, data, out["omega"], length, density * gravity)
    return coefficients(
        path, point=origin, **out, **_hydrostatics(head["bodies"][place], length, density, gravity),
        density=density, gravity=gravity, depth=head["depth"],
    )  # fmt: skip


def _head(path, lines) -> dict:
    """Return gravity, length scale, depth and what the head says of each body."""
    head = {"bodies": []}
    for k, line in enumerate(lines):
        if line.lstrip().startswith("Wave period"):
            break
        if match := re.search(rf"Gravity:\s+{_NUMBER}\s+Length scale:\s+{_NUMBER}", line):
            head["gravity"], head["length"] = (number_at(path, k + 1, g) for g in match.groups())
        elif "Water depth:" in line:
            text = (line.split("Water depth:")[1].split() or [""])[0]
            head["depth"] = np.inf if text.lower().startswith("inf") else _value(path, k, text)
        elif "XBODY =" in line:
            values = [_value(path, k, v) for v in re.findall(r"=\s*([-+\d.EeDd]+)", line)]
            if len(values) != 4 or values[3] != 0:
                hint = "Turned bodies are not read; repeat the run with PHIBODY = 0"
                raise FormatError(path, k + 1, expected="XBODY, YBODY, ZBODY and PHIBODY = 0", found=line, hint=hint)
            head["bodies"].append({"origin": np.array(values[:3])})
        elif head["bodies"]:
            _body_line(path, k, lines, head["bodies"][-1])
    for name, label in (("gravity", "Gravity:"), ("depth", "Water depth:")):
        if name not in head:
            raise FormatError(path, expected=f"'{label}' in the head of a WAMIT .out file", found="none")
    if not head["bodies"]:
        raise FormatError(path, expected="'XBODY =' in the head of a WAMIT .out file", found="none")
    return head


def _body_line(path, k: int, lines, body: dict) -> None:
    """Add what one line of the head says of a body: volumes, centres, restoring coefficients."""
    line = lines[k]
    for label, name, count in (
        ("Volumes (VOLX,VOLY,VOLZ):", "volumes", 3),
        ("Center of Buoyancy (Xb,Yb,Zb):", "buoyancy", 3),
        ("Center of Gravity  (Xg,Yg,Zg):", "gravity", 3),
    ):
        if label in line:
            body[name] = np.array(_values(path, k, line.split(label)[1], count))
    if "C(3,3),C(3,4),C(3,5):" in line:
        first = _values(path, k, line.split(":")[1], 3)
        following = [*lines[k + 1 : k + 3], "", ""]
        second = _values(path, k + 1, following[0].split(":")[-1], 3)
        third = _values(path, k + 2, following[1].split(":")[-1], 2)
        c = np.zeros((6, 6))
        c[2, 2:5], c[3, 3:6], c[4, 4:6] = first, second, third
        c[3, 2], c[4, 2], c[4, 3] = c[2, 3], c[2, 4], c[3, 4]
        body["stiffness"] = c


def _hydrostatics(body: dict, length: float, density: float, gravity: float) -> dict:
    """Return stiffness without weight, volume and centre of buoyancy of a body about its origin, as far as given.

    The head prints lengths and volumes with dimensions; the restoring coefficients are over rho g L^2, L^3, L^4.
    """
    if "volumes" not in body:
        return {}
    volume = float(np.median(body["volumes"]))
    out = {"volume": volume}
    if "buoyancy" in body:
        out["centre_of_buoyancy"] = body["buoyancy"] + body["origin"]
    if "stiffness" in body and "gravity" in body:
        rotations = np.repeat([0, 1], 3)
        c = density * gravity * length ** (2.0 + rotations[:, None] + rotations) * body["stiffness"]
        out["hydrostatic_stiffness"] = without_weight(c, density * volume, body["gravity"], np.zeros(3), gravity)
    return out


def _blocks(path, lines) -> list[tuple[float, int, int]]:
    """Return (period, first, last line) of every block that starts with 'Wave period'; 0 and -1 are the limits."""
    starts = [k for k, line in enumerate(lines) if line.lstrip().startswith("Wave period")]
    if not starts:
        raise FormatError(
            path, expected="blocks that start with 'Wave period'", found="none", hint="Did FORCE run to its end?"
        )
    announced = sum(bool(_SOLVED.match(line)) for line in lines[: starts[0]])
    if announced > len(starts):
        raise FormatError(
            path,
            expected=f"{announced} periods, as the head announces",
            found=f"{len(starts)}",
            hint="Is the file complete?",
        )
    names = {"infinite": -1.0, "zero": 0.0}
    out = []
    for first, last in zip(starts, [*starts[1:], len(lines)], strict=True):
        text = _PERIOD.search(lines[first])
        period = names.get(text.group(1)) if text else None
        out.append((_value(path, first, text.group(1) if text else "") if period is None else period, first, last))
    return out


def _section(lines, first: int, last: int, title: str) -> int | None:
    """Return the line after the title within a block."""
    return next((k + 1 for k in range(first, last) if title in lines[k]), None)


def _rows(lines, start: int, last: int) -> tuple[int, int]:
    """Return first and last line of the table that follows: it begins with a digit and ends at a blank line."""
    first = next((k for k in range(start, last) if lines[k].strip()[:1].lstrip("-").isdigit()), last)
    end = next((k for k in range(first, last) if not lines[k].strip()), last)
    return first, end


def _radiation(path, lines, blocks, body) -> WamitRadiation:
    periods, matrices = [], []
    for period, first, last in blocks:
        start = _section(lines, first, last, "ADDED-MASS")
        if start is None:
            raise FormatError(path, first + 1, expected="added-mass coefficients of this period", found="none")
        begin, end = _rows(lines, start, last)
        width = 4 if period > 0 else 3
        table, where = number_table(path, lines[begin:end], begin + 1, (width,), "a row: i, j, A, B")
        table, where = choose_modes(path, table, where, (0, 1), body)
        out = np.zeros((2, 6, 6))
        i, j = (table[:, c].astype(int) - 1 for c in (0, 1))
        out[:, i, j] = table[:, 2:].T if width == 4 else table[:, 2]
        if width == 3:
            out[1] = 0.0
        periods.append(period)
        matrices.append((out, frozenset(zip(i.tolist(), j.tolist(), strict=True)), len(table)))
    _same_elements(path, blocks, [(set(m[1]), m[2]) for m in matrices])
    order = np.argsort(periods)
    stack = np.array([m[0] for m in matrices])[order]
    return WamitRadiation(period=np.array(periods)[order], added_mass=stack[:, 0], damping=stack[:, 1])


def _same_elements(path, blocks, given) -> None:
    for (_, first, _), (elements, count) in zip(blocks, given, strict=True):
        if elements != given[0][0] or count != len(elements):
            raise FormatError(
                path, first + 1, expected=f"the {len(given[0][0])} elements of the first block, each once",
                found=f"{count}", hint="Is the file complete?",
            )  # fmt: skip


def _excitation(path, lines, blocks, kind: str, body) -> WamitExcitation | None:
    titles = {"diffraction": "DIFFRACTION EXCITING FORCES", "haskind": "HASKIND EXCITING FORCES"}
    if kind not in titles:
        raise FormatError(path, expected='excitation "diffraction" or "haskind"', found=kind)
    finite = [b for b in blocks if b[0] > 0]
    for title in (titles.pop(kind), *titles.values()):
        starts = [_section(lines, first, last, title) for _, first, last in finite]
        if any(s is not None for s in starts):
            break
    else:
        return None
    if None in starts:
        first = finite[starts.index(None)][1]
        raise FormatError(
            path, first + 1, expected="exciting forces of this period", found="none", hint="Is the file complete?"
        )
    rows = [_headings(path, lines, s, last, body) for s, (_, _, last) in zip(starts, finite, strict=True)]
    heading = np.array(sorted(rows[0]))
    for row, (_, first, _) in zip(rows, finite, strict=True):
        if sorted(row) != heading.tolist():
            raise FormatError(
                path, first + 1, expected=f"{len(heading)} headings as in the first block", found=f"{len(row)}"
            )
    period = np.array([b[0] for b in finite])
    force = np.array([[row[h] for row in rows] for h in heading])
    return WamitExcitation(period=period, heading=heading, force=force)


def _headings(path, lines, start: int, last: int, body) -> dict[float, np.ndarray]:
    """Return the force (6) of every heading of one block."""
    out = {}
    end = (
        _section(lines, start, last, "EXCITING FORCES")
        or _section(lines, start, last, "RESPONSE AMPLITUDE")
        or last + 1
    )
    marks = [k for k in range(start, min(end - 1, last)) if "Wave Heading (deg)" in lines[k]]
    for mark in marks:
        heading = _value(path, mark, lines[mark].split(":")[-1])
        begin, stop = _rows(lines, mark + 1, last)
        table, where = number_table(path, lines[begin:stop], begin + 1, (3, 5), "a row: i, modulus, phase")
        table, where = choose_modes(path, table, where, (0,), body)
        if sorted(table[:, 0]) != [1, 2, 3, 4, 5, 6] or heading in out:
            raise FormatError(path, mark + 1, expected="modes 1 to 6, once per heading", found=f"{len(table)} rows")
        if table.shape[1] == 5:
            check_polar(path, table[:, 1:], np.zeros(len(table), dtype=int), where)
        out[heading] = (table[:, 1] * np.exp(1j * np.radians(table[:, 2])))[np.argsort(table[:, 0])]
    return out


def _body_place(path, bodies, body) -> int:
    if len(bodies) > 1 and body is None:
        raise SeveralBodies(path, [str(k + 1) for k in range(len(bodies))])
    if body is not None and not 1 <= body <= len(bodies):
        raise FormatError(path, expected=f"body {body}", found=f"{len(bodies)} bodies")
    return (body or 1) - 1


def _value(path, k: int, text: str) -> float:
    return _values(path, k, text, 1)[0]


def _values(path, k: int, text: str, count: int) -> list[float]:
    """Return the numbers of a piece of line k (from 0); raise FormatError when there are not so many."""
    try:
        values = numbers(text)
    except ValueError as error:
        raise FormatError(path, k + 1, expected=f"{count} numbers", found=text, hint=str(error)) from None
    if len(values) != count:
        raise FormatError(path, k + 1, expected=f"{count} numbers", found=text)
    return values


WAMIT_OUTPUT = Format(
    name="WAMIT .out (formatted output)",
    recognises=lambda path, head: b"WAMIT" in head and b"Period       Time" in head,
    read=read_wamit_out,
    describe=describe_hydro,
    problems=hydro_problems,
)
