"""Ansys AQWA's listing (.LIS) and hydrodynamic database (.AH1): SI, phases are lags in degrees.

Source of the formats: AQWA's Reference and Theory Manuals and the files that AQWA-Line writes (versions 14 to 2023).
All matrices and forces are about the structure's centre of gravity, and the wave's crest is there too: forces are brought to
the origin with moment arms and with the wave's phase between the two. The stiffness about the centre of gravity is the
hydrostatic pressure's alone (Theory Manual, section 3.3): the weight has no moment there. "Low" and "high" frequency
(0.001 and 100 rad/s, option LHFR) are taken for zero and infinity.
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
    number_at,
    number_table,
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


def read_aqwa(path: str | Path, *, body: int | None = None) -> HydroCoefficients:
    """Return the coefficients of an AQWA .AH1 or .LIS file, by its content; body as read_aqwa_ah1. Raises FormatError."""
    database = any(line.rstrip() in ("GENERAL", "ADDEDMASS", "FORCERAO") for line in read_lines(path))
    return (read_aqwa_ah1 if database else read_aqwa_lis)(path, body=body)


def read_aqwa_ah1(path: str | Path, *, body: int | None = None) -> HydroCoefficients:
    """Return the coefficients of an AQWA .AH1 file about the origin, waves e^{+i omega t}, crest at the origin.

    body is the structure (from 1) where there are several; the coupling with the others is left out. Five digits, phases
    to a hundredth of a degree. Raises FormatError.
    """
    path = Path(path)
    lines = read_lines(path)
    first = next((k for k, line in enumerate(lines) if line.strip() and not line.lstrip().startswith("*")), len(lines))
    sections, end = _sections(lines, first)
    heading, omega, count = _ah1_head(path, lines, first, end)
    place = choose_body(path, body, range(1, count + 1), "structure")
    general = _ah1_rows(path, lines, sections, "GENERAL", (3, 4, 5, 6, 7))[0]
    depth, density, gravity = general[1:4] if general[0] == 1 and len(general) > 3 else general[:3]
    centre = np.array(_ah1_rows(path, lines, sections, "COG", (4,))[place][1:])
    added = _ah1_matrices(path, lines, sections, "ADDEDMASS", count, len(omega), place)
    damping = _ah1_matrices(path, lines, sections, "DAMPING", count, len(omega), place)
    force = _ah1_force(path, lines, sections, count, len(heading), len(omega), place)
    volume = _ah1_rows(path, lines, sections, "DISPLACEMENT", (2,), needed=False)
    buoyancy = _ah1_rows(path, lines, sections, "COB", (4,), needed=False)
    limits = {
        name: _ah1_matrices(path, lines, sections, section, count, 1, place)[0] if section in sections else None
        for name, section in (("added_mass_zero", "ADDEDMASS_LF"), ("added_mass_infinite", "ADDEDMASS_HF"))
    }
    stiffness = None
    if "HYDSTIFFNESS" in sections and volume:
        stiffness = _ah1_blocks(path, lines, sections["HYDSTIFFNESS"], 1, count)[place]
    return _assemble(
        path, centre, heading, omega, force, added_mass=added, radiation_damping=damping, **limits,
        hydrostatic_stiffness=stiffness, volume=volume[place][1] if volume else None,
        centre_of_buoyancy=buoyancy[place][1:] if buoyancy else None, density=density, gravity=gravity, depth=depth,
    )  # fmt: skip


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
    return _assemble(
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


def _assemble(path, centre, heading, omega, force, **fields) -> HydroCoefficients:
    """Return the coefficients about the origin; the force (m, n, 6) is conjugated (lags) and its phase brought to the origin."""
    check_damping(path, fields["radiation_damping"], omega)
    angle = np.radians(heading)
    k = wave_number(path, omega, fields["depth"], fields["gravity"])
    force = phase_to_origin(force, angle, k, centre)
    return coefficients(path, point=centre, omega=omega, heading=angle, excitation=force, **fields)


def _sections(lines, first: int) -> tuple[dict[str, tuple[int, int]], int]:
    """Return {keyword: (first, last line)} of an .AH1 file, and where the first section begins."""
    marks = [k for k in range(first, len(lines)) if lines[k][:1].isalpha()]
    out = {lines[k].strip().upper(): (k + 1, last) for k, last in zip(marks, [*marks[1:], len(lines)], strict=False)}
    return out, marks[0] if marks else len(lines)


def _ah1_head(path, lines, first: int, end: int) -> tuple[np.ndarray, np.ndarray, int]:
    """Return headings [deg], frequencies [rad/s] and the number of structures of the first lines."""
    values: list[float] = []
    for k in range(first, end):
        values += _numbers(path, k, lines[k])
    if len(values) < 3:
        raise FormatError(path, first + 1, expected="numbers of structures, headings and frequencies", found="fewer")
    count, m, n = (int(v) for v in values[:3])
    if len(values) != 3 + m + n or min(count, m, n) < 1:
        raise FormatError(
            path, first + 1, expected=f"{m} headings and {n} frequencies", found=f"{len(values) - 3} numbers"
        )
    omega = np.array(values[3 + m :])
    if np.any(np.diff(omega) <= 0) or omega[0] <= 0:
        raise FormatError(path, first + 1, expected="frequencies that ascend from above zero", found=f"{omega}")
    return np.array(values[3 : 3 + m]), omega, count


def _ah1_rows(path, lines, sections, name: str, widths, needed: bool = True) -> list[list[float]]:
    """Return the rows of a small section, one a structure."""
    if name not in sections:
        if needed:
            raise FormatError(path, expected=f"a section {name}", found="none", hint="Is the file complete?")
        return []
    first, last = sections[name]
    rows = []
    for k in range(first, last):
        if lines[k].strip():
            row = _numbers(path, k, lines[k])
            if len(row) not in widths:
                raise FormatError(path, k + 1, expected=f"{widths[0]} numbers of section {name}", found=lines[k])
            rows.append(row)
    if not rows:
        raise FormatError(path, first + 1, expected=f"numbers of section {name}", found="none")
    return rows


def _ah1_blocks(path, lines, where: tuple[int, int], indices: int, count: int) -> np.ndarray:
    """Return `count` matrices (count, 6, 6): the first of each six rows begins with `indices` whole numbers."""
    table, _ = number_table(path, lines[slice(*where)], where[0] + 1, (6, 6 + indices), "a row of a 6 x 6 matrix")
    wide = np.isfinite(table[:, 6]) if table.shape[1] > 6 else np.zeros(len(table), dtype=bool)
    if len(table) != 6 * count or not np.array_equal(np.flatnonzero(wide), 6 * np.arange(count)):
        raise FormatError(
            path,
            where[0],
            expected=f"{count} matrices of 6 rows",
            found=f"{len(table)} rows",
            hint="Is the file complete?",
        )
    table[wide] = np.roll(table[wide], -indices, axis=1)
    return table[:, :6].reshape(count, 6, 6)


def _ah1_matrices(path, lines, sections, name: str, count: int, frequencies: int, place: int) -> np.ndarray:
    """Return the structure's own matrices (n, 6, 6) of a section; indices are structure, structure and frequency."""
    if name not in sections:
        raise FormatError(path, expected=f"a section {name}", found="none", hint="Is the file complete?")
    indices = 2 if name.endswith(("_LF", "_HF")) else 3
    blocks = _ah1_blocks(path, lines, sections[name], indices, count * count * frequencies)
    first = sections[name][0]
    given = [k for k in range(first, sections[name][1]) if lines[k].strip()][::6]
    index = np.array([_numbers(path, k, lines[k])[:indices] for k in given])
    want = np.indices((count, count, frequencies)[:indices]).reshape(indices, -1).T + 1
    _in_order(path, index, want, given)
    return blocks.reshape(count, count, frequencies, 6, 6)[place, place]


def _in_order(path, index: np.ndarray, want: np.ndarray, lines: list[int]) -> None:
    wrong = np.any(index != want, axis=1)
    if np.any(wrong):
        k = int(np.argmax(wrong))
        text = " ".join(f"{v:g}" for v in want[k])
        raise FormatError(
            path, lines[k] + 1, expected=f"the indices {text}", found=" ".join(f"{v:g}" for v in index[k])
        )


def _ah1_force(path, lines, sections, count, headings: int, frequencies: int, place: int) -> np.ndarray:
    """Return the structure's force (m, n, 6), e^{+i omega t}: a row of amplitudes with indices, a row of lags [deg]."""
    if "FORCERAO" not in sections:
        raise FormatError(path, expected="a section FORCERAO", found="none", hint="Is the file complete?")
    where = sections["FORCERAO"]
    table, line = number_table(
        path, lines[slice(*where)], where[0] + 1, (6, 9), "a row of amplitudes (9) or phases (6)"
    )
    wide = np.isfinite(table[:, -1]) if table.shape[1] == 9 else np.zeros(len(table), dtype=bool)
    total = count * headings * frequencies
    if len(table) != 2 * total or not np.array_equal(np.flatnonzero(wide), 2 * np.arange(total)):
        raise FormatError(
            path, where[0], expected=f"{total} pairs of rows", found=f"{len(table)} rows", hint="Is the file complete?"
        )
    want = np.indices((count, headings, frequencies)).reshape(3, -1).T + 1
    _in_order(path, table[::2, :3], want, (line[::2] - 1).tolist())
    force = _from_lags(path, table[::2, 3:9], table[1::2, :6], line[1::2])
    return force.reshape(count, headings, frequencies, 6)[place]


def _from_lags(path, amplitude: np.ndarray, lag: np.ndarray, line) -> np.ndarray:
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
            return _numbers(path, k, line.split("=")[1])[0]
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
    """Return the forces (m, n, 6) of the tables of that title, e^{+i omega t}; a heading is named in its first row only."""
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
            path, where[-1] + 1, expected=f"{len(heading)} x {len(omega)} rows of {title.lower()}", found=f"{len(rows)}",
            hint="Is the file complete?",
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
    force = _from_lags(path, table[:, 2::2], table[:, 3::2], np.array(where) + 1)
    return force.reshape(len(heading), len(omega), 6)


def _maybe(text: str) -> list[float] | None:
    """Return the numbers of a line, None when it holds anything else."""
    try:
        return numbers(text)
    except ValueError:
        return None


def _numbers(path, k: int, text: str) -> list[float]:
    try:
        return numbers(text)
    except ValueError as error:
        raise FormatError(path, k + 1, expected="numbers", found=text, hint=str(error)) from None


def _is_lis(path, head: bytes) -> bool:
    return b"DECK" in head and (b"AQWA" in head.upper() or b"H Y D R O D Y N A M I C" in head)


def _is_ah1(path, head: bytes) -> bool:
    return head.lstrip(b"\xef\xbb\xbf")[:1] == b"*" and b"AQWA" in head[:2000] and b"GENERAL" in head


AQWA_LIS = Format(name="AQWA listing (.LIS)", recognises=_is_lis, read=read_aqwa_lis, describe=describe_hydro)
AQWA_AH1 = Format(name="AQWA database (.AH1)", recognises=_is_ah1, read=read_aqwa_ah1, describe=describe_hydro)
