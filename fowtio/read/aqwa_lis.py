"""Ansys AQWA's listing (.LIS): SI, phases are lags in degrees.

Source of the format: AQWA's Reference and Theory Manuals and the listings that AQWA-Line writes (version 2023). All
matrices and forces are about the structure's centre of gravity, and the wave's crest is there too: forces are brought
to the origin with moment arms and with the wave's phase between the two. The stiffness about the centre of gravity is
the hydrostatic pressure's alone (Theory Manual, section 3.3): the weight has no moment there. "Low" and "high"
frequency (0.001 and 100 rad/s, option LHFR) are taken for zero and infinity.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from fowtio.errors import FormatError
from fowtio.read.hydro_common import (
    check_damping,
    choose_body,
    coefficients,
    describe_hydro,
    hydro_problems,
    number_at,
    phase_to_origin,
    wave_number,
)
from fowtio.read.registry import Format
from fowtio.read.text import numbers, read_lines
from model.system.hydro import HydroCoefficients

_LABELS = ("X", "Y", "Z", "RX", "RY", "RZ")
_NUMBER = r"([-+]?\d[\d.]*(?:[EeDd][-+]?\d+)?)"
_GRID_ROW = re.compile(r"\s*(?:(\d+)\s+)?(\d+)\s+(\d+\.\d+)\s+(\d+\.\d+)\s+(\d+\.\d+)\s")
_TOTAL = "FROUDE KRYLOV + DIFFRACTION FORCES-VARIATION WITH WAVE PERIOD/FREQUENCY"
_PARTS = ("FROUDE KRYLOV FORCES-VARIATION WITH WAVE PERIOD", "DIFFRACTION FORCES-VARIATION WITH WAVE PERIOD")


def read_aqwa_lis(path: str | Path, *, body: int | None = None) -> HydroCoefficients:
    """Return the coefficients of an AQWA .LIS file about the origin, waves e^{+i omega t}, crest at the origin.

    body is the structure (from 1) where there are several; the coupling with the others is left out. Matrices have five
    digits, forces three: the .AH1 file of the same run is finer. Raises FormatError.
    """
    path = Path(path)
    lines = read_lines(path)
    water = [
        _lis_value(path, lines, label) for label in ("WATER DEPTH", "DENSITY OF WATER", "ACCELERATION DUE TO GRAVITY")
    ]
    pages = _pages(lines)
    structures = sorted({page.structure for page in pages if page.kind == "parameters"})
    if not structures:
        raise FormatError(
            path, expected="HYDRODYNAMIC PARAMETERS FOR STRUCTURE n", found="none", hint="Did AQWA-Line run?"
        )
    wanted = structures[choose_body(path, body, structures, "structure")]
    own = [page for page in pages if page.structure == wanted]
    omega, heading = _lis_grid(path, lines, pages, wanted)
    statics = _lis_statics(path, lines, own)
    matrices = _lis_matrices(path, lines, own, omega)
    force = _lis_force(path, lines, own, heading, omega)
    depth, density, gravity = water
    return assemble(
        path,
        statics.pop("centre"),
        heading,
        omega,
        force,
        **matrices,
        **statics,
        density=density,
        gravity=gravity,
        depth=depth,
    )


def assemble(path, centre, heading, omega, force, **fields) -> HydroCoefficients:
    """Return the coefficients, and the force (m, n, 6) with its wave phase, about the origin."""
    check_damping(path, fields["radiation_damping"], omega)
    angle = np.radians(heading)
    k = wave_number(path, omega, fields["depth"], fields["gravity"])
    force = phase_to_origin(force, angle, k, centre)
    return coefficients(path, point=centre, omega=omega, heading=angle, excitation=force, **fields)


def from_lags(path, amplitude: np.ndarray, lag: np.ndarray, line) -> np.ndarray:
    """Return complex numbers of e^{+i omega t} from amplitudes and lags [deg]."""
    wrong = np.any((amplitude < 0) | (np.abs(lag) > 360.0), axis=1)
    if np.any(wrong):
        raise FormatError(
            path, int(line[np.argmax(wrong)]), expected="amplitudes from 0 and phases within 360 deg", found="others"
        )
    return amplitude * np.exp(-1j * np.radians(lag))


class _Page:
    """A page of the listing: its lines (first, last), its kind and its structure."""

    def __init__(self, first: int, last: int, kind: str, structure: int):
        self.first, self.last, self.kind, self.structure = first, last, kind, structure


_KINDS = {
    "HYDRODYNAMICPARAMETERSFORSTRUCTURE": "parameters",
    "HYDRODYNAMICPARAMETERSATLOW": "limits",
    "HYDROSTATICPROPERTIES": "statics",
    "WAVEFREQUENCIES/PERIODSANDDIRECTIONS": "grid",
}


def _pages(lines) -> list[_Page]:
    """Return the pages of the listing that matter; a page begins with a spaced-out title between asterisks."""
    titles = [k for k, line in enumerate(lines) if "* * *" in line]
    out: list[_Page] = []
    for k, last in zip(titles, [*titles[1:], len(lines)], strict=True):
        title = re.sub(r"[\s*]", "", lines[k])
        kind = next((v for text, v in _KINDS.items() if title.startswith(text)), None)
        own = re.search(r"FORSTRUCTURE(\d+)", title)
        if kind is None:
            if own and title.startswith("FORSTRUCTURE") and out and out[-1].structure == 0 and out[-1].last == k:
                out[-1].structure, out[-1].last = int(own.group(1)), last
            continue
        structure = int(own.group(1)) if own else _later_structure(lines, k, last)
        out.append(_Page(k + 1, last, kind, structure))
    return out


def _later_structure(lines, first: int, last: int) -> int:
    """Return the structure that a title below the page's own names, 0 when there is none."""
    for line in lines[first + 1 : min(first + 6, last)]:
        own = re.search(r"FORSTRUCTURE(\d+)", re.sub(r"[\s*]", "", line))
        if own:
            return int(own.group(1))
    return 0


def _lis_value(path, lines, label: str) -> float:
    for k, line in enumerate(lines):
        if label in re.sub(r"\s+", " ", line) and "=" in line:
            return numbers_of(path, k, line.split("=")[1])[0]
    raise FormatError(path, expected=f"'{label} . . . ='", found="none", hint="Is this the listing of AQWA-Line?")


def _lis_grid(path, lines, pages, structure: int) -> tuple[np.ndarray, np.ndarray]:
    """Return frequencies [rad/s] and headings [deg] of the table of frequencies, periods and directions."""
    page = next((p for p in pages if p.kind == "grid"), None)
    if page is None:
        raise FormatError(path, expected="the table of wave frequencies and directions", found="none")
    omega, heading, current, directions = [], [], 0, False
    for k in range(page.first, page.last):
        frequency = _GRID_ROW.match(lines[k])
        if "DIRECTIONS" in lines[k]:
            directions = True
        elif frequency:
            own, index, *values = frequency.groups()
            current, directions = int(own) if own else current, False
            number, _, period = (float(v) for v in values)
            if current == structure:
                if int(index) != len(omega) + 1 or abs(number * period / (2 * np.pi) - 1) > 0.01:
                    raise FormatError(
                        path, k + 1, expected=f"frequency {len(omega) + 1} and its period", found=lines[k]
                    )
                omega.append(number)
        elif directions and current == structure and "." in lines[k]:  # a lone 1 is the next page
            heading += _maybe(lines[k]) or []
    if not omega or not heading:
        raise FormatError(
            path, page.first, expected=f"frequencies and directions of structure {structure}", found="none"
        )
    return np.array(omega), np.array(heading)


def _lis_statics(path, lines, own: Iterable[_Page]) -> dict:
    """Return centre of gravity and, of the hydrostatics, volume, centre of buoyancy and stiffness about the former."""
    out: dict = {}
    for page in own:
        text = "\n".join(lines[page.first : page.last])
        if page.kind == "statics":
            volume = re.search(rf"MESH BASED DISPLACEMENT[ .]*=\s*{_NUMBER}", text)
            buoyancy = [re.search(rf"B{c}\s*=\s*{_NUMBER}", text) for c in "XYZ"]
            if volume is None or None in buoyancy:
                raise FormatError(path, page.first, expected="MESH BASED DISPLACEMENT, BX, BY and BZ", found="fewer")
            out["volume"] = number_at(path, page.first, volume.group(1))
            out["centre_of_buoyancy"] = np.array([number_at(path, page.first, b.group(1)) for b in buoyancy])
        match = re.search(rf"CENTRE OF GRAVITY\s+AT \(\s*{_NUMBER},\s*{_NUMBER},\s*{_NUMBER}\)", text)
        if page.kind == "parameters" and match:
            out["centre"] = np.array([number_at(path, page.first, g) for g in match.groups()])
            start = _after(lines, page, "STIFFNESS MATRIX")
            if start is not None:
                out["hydrostatic_stiffness"], _ = _matrix(path, lines, start, page.last)
    if "centre" not in out:
        raise FormatError(path, expected="'THE CENTRE OF GRAVITY AT (...)'", found="none", hint="Is the file complete?")
    if "volume" not in out:
        out.pop("hydrostatic_stiffness", None)
    return out


def _lis_matrices(path, lines, own, omega) -> dict:
    """Return added mass and damping on the frequencies, and the limits where the listing has them."""
    found: dict[float, tuple[np.ndarray, np.ndarray]] = {}
    out = {"added_mass_zero": None, "added_mass_infinite": None}
    for page in own:
        for k in range(page.first, page.last):
            value = re.search(rf"WAVE FREQUENCY =\s*{_NUMBER}", lines[k])
            if not value or (page.kind == "parameters" and "WAVE PERIOD" not in lines[k]):
                continue
            frequency = number_at(path, k + 1, value.group(1))
            start = _after(lines, page, "ADDED ", k)
            if page.kind == "parameters":
                if start is None or (after := _after(lines, page, "DAMPING", k)) is None:
                    raise FormatError(
                        path, k + 1, expected="added mass and damping", found="fewer", hint="Is the file complete?"
                    )
                found[frequency] = _matrix(path, lines, start, page.last)[0], _matrix(path, lines, after, page.last)[0]
            elif page.kind == "limits" and start is not None:
                name = "added_mass_zero" if frequency < omega[0] else "added_mass_infinite"
                out[name] = _matrix(path, lines, start, page.last)[0]
    given = np.array(list(found))
    if len(given) != len(omega) or not np.allclose(given, omega, atol=6e-5):  # four decimals against five
        raise FormatError(
            path,
            expected=f"added mass and damping at {len(omega)} frequencies",
            found=f"at {len(given)}",
            hint="Is the file complete?",
        )
    out["added_mass"], out["radiation_damping"] = (np.array(list(m)) for m in zip(*found.values(), strict=True))
    return out


def _matrix(path, lines, start: int, last: int) -> tuple[np.ndarray, int]:
    """Return the next matrix (6, 6), rows labelled X to RZ, and the line after it."""
    rows = []
    for k in range(start, last):
        label, _, rest = lines[k].strip().partition(" ")
        values = _maybe(rest) if label == _LABELS[len(rows)] else None
        if values is None:
            if rows and lines[k].strip():
                raise FormatError(path, k + 1, expected=f"row {_LABELS[len(rows)]} of a matrix", found=lines[k])
            continue
        if len(values) != 6:
            raise FormatError(path, k + 1, expected=f"6 numbers of row {label}", found=lines[k])
        rows.append(values)
        if len(rows) == 6:
            return np.array(rows), k + 1
    raise FormatError(
        path, start + 1, expected="a matrix of 6 rows", found=f"{len(rows)} rows", hint="Is the file complete?"
    )


def _after(lines, page: _Page, text: str, first: int | None = None) -> int | None:
    """Return the line after the first that has `text` (blanks taken together) within a page."""
    for k in range(page.first if first is None else first, page.last):
        if re.sub(r"\s+", " ", lines[k]).strip().startswith(text.strip()):
            return k + 1
    return None


def _lis_force(path, lines, own, heading, omega) -> np.ndarray:
    """Return the sum of Froude-Krylov and diffraction force (m, n, 6), checked against the two when they are there."""
    total = _lis_table(path, lines, own, _TOTAL, heading, omega)
    if total is None:
        raise FormatError(path, expected=_TOTAL.capitalize(), found="none", hint="Is the file complete?")
    parts = [_lis_table(path, lines, own, title, heading, omega) for title in _PARTS]
    if all(p is not None for p in parts):
        scale = np.repeat(np.abs(total).reshape(-1, 2, 3).max(axis=(0, 2)), 3)
        error = (np.abs(parts[0] + parts[1] - total) / scale).max()
        if error > 0.02:  # three digits of each
            raise FormatError(
                path,
                expected="the sum of Froude-Krylov and diffraction forces",
                found=f"{error:.2g} of the largest off",
            )
    return total


def _lis_table(path, lines, own, title: str, heading, omega) -> np.ndarray | None:
    """Return the forces (m, n, 6) of the tables of that title; a heading is named in its first row only."""
    rows, where = [], []
    for page in own:
        start = _after(lines, page, title) if page.kind == "parameters" else None
        for k in range(start or page.last, page.last):
            row = _maybe(lines[k])
            if row and len(row) in (14, 15):
                rows.append(row)
                where.append(k)
    if not rows:
        return None
    if len(rows) != len(heading) * len(omega):
        raise FormatError(
            path, where[-1] + 1, expected=f"{len(heading)} x {len(omega)} rows of {title.lower()}",
            found=f"{len(rows)}", hint="Is the file complete?",
        )  # fmt: skip
    for k, (row, line) in enumerate(zip(rows, where, strict=True)):
        m, n = divmod(k, len(omega))
        wrong = len(row) == 15 and abs(row.pop(2) - heading[m]) > 0.006
        if wrong or abs(row[1] - omega[n]) > 6e-4:
            found = f"heading or frequency of {lines[line].strip()[:30]}"
            raise FormatError(
                path, line + 1, expected=f"heading {heading[m]:g} deg, frequency {omega[n]:g} rad/s", found=found
            )
    table = np.array(rows)
    force = from_lags(path, table[:, 2::2], table[:, 3::2], np.array(where) + 1)
    return force.reshape(len(heading), len(omega), 6)


def _maybe(text: str) -> list[float] | None:
    """Return the numbers of a line, None when it holds anything else."""
    try:
        return numbers(text)
    except ValueError:
        return None


def numbers_of(path, k: int, text: str) -> list[float]:
    """Return the numbers of a piece of line k (from 0); raise FormatError."""
    try:
        return numbers(text)
    except ValueError as error:
        raise FormatError(path, k + 1, expected="numbers", found=text, hint=str(error)) from None


def _is_lis(path, head: bytes) -> bool:
    return b"DECK" in head and (b"AQWA" in head.upper() or b"H Y D R O D Y N A M I C" in head)


AQWA_LIS = Format(
    name="AQWA listing (.LIS)", recognises=_is_lis, read=read_aqwa_lis, describe=describe_hydro, problems=hydro_problems
)
