"""Ansys AQWA's hydrodynamic database (.AH1): SI, phases are lags in degrees.

Source of the format: AQWA's Reference Manual and the files that AQWA-Line writes (versions 14 to 2020). Reference
point, wave phase, stiffness and limits are as in the listing: see fowtio.read.aqwa_lis.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fowtio.errors import FormatError
from fowtio.read.aqwa_lis import assemble, from_lags, numbers_of, read_aqwa_lis
from fowtio.read.hydro_common import choose_body, describe_hydro, hydro_problems, number_table
from fowtio.read.registry import Format
from fowtio.read.text import read_lines
from model.system.hydro import HydroCoefficients


def read_aqwa(path: str | Path, *, body: int | None = None) -> HydroCoefficients:
    """Return the coefficients of an AQWA .AH1 or .LIS file, told apart by content; raise FormatError."""
    database = any(line.rstrip() in ("GENERAL", "ADDEDMASS", "FORCERAO") for line in read_lines(path))
    return (read_aqwa_ah1 if database else read_aqwa_lis)(path, body=body)


def read_aqwa_ah1(path: str | Path, *, body: int | None = None) -> HydroCoefficients:
    """Return the coefficients of an AQWA .AH1 file about the origin, waves e^{+i omega t}, crest at the origin.

    body is the structure (from 1) where there are several; the coupling with the others is left out. The file has five
    digits, phases to a hundredth of a degree. Raises FormatError.
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
    return assemble(
        path, centre, heading, omega, force, added_mass=added, radiation_damping=damping, **limits,
        hydrostatic_stiffness=stiffness, volume=volume[place][1] if volume else None,
        centre_of_buoyancy=buoyancy[place][1:] if buoyancy else None, density=density, gravity=gravity, depth=depth,
    )  # fmt: skip


def _sections(lines, first: int) -> tuple[dict[str, tuple[int, int]], int]:
    """Return {keyword: (first, last line)} of an .AH1 file, and where the first section begins."""
    marks = [k for k in range(first, len(lines)) if lines[k][:1].isalpha()]
    out = {lines[k].strip().upper(): (k + 1, last) for k, last in zip(marks, [*marks[1:], len(lines)], strict=False)}
    return out, marks[0] if marks else len(lines)


def _ah1_head(path, lines, first: int, end: int) -> tuple[np.ndarray, np.ndarray, int]:
    """Return headings [deg], frequencies [rad/s] and the number of structures of the first lines."""
    values: list[float] = []
    for k in range(first, end):
        values += numbers_of(path, k, lines[k])
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
            row = numbers_of(path, k, lines[k])
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
    index = np.array([numbers_of(path, k, lines[k])[:indices] for k in given])
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
    force = from_lags(path, table[::2, 3:9], table[1::2, :6], line[1::2])
    return force.reshape(count, headings, frequencies, 6)[place]


def _is_ah1(path, head: bytes) -> bool:
    return head.lstrip(b"\xef\xbb\xbf")[:1] == b"*" and b"AQWA" in head[:2000] and b"GENERAL" in head


AQWA_AH1 = Format(
    name="AQWA database (.AH1)",
    recognises=_is_ah1,
    read=read_aqwa_ah1,
    describe=describe_hydro,
    problems=hydro_problems,
)
