"""WAMIT result files .1, .3 and .hst: non-dimensional by density, gravity and a length, e^{+i omega t}.

Source of the format: WAMIT User Manual v7, chapters 4 and 10. Periods of 0 and -1 stand for infinite and zero frequency.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fowtio.errors import FormatError
from fowtio.read.text import number_rows, read_lines
from model.system.hydro import HydroCoefficients

SUFFIXES = (".1", ".3", ".hst")
_ROTATIONS = np.array([0, 0, 0, 1, 1, 1])


@dataclass(frozen=True, eq=False, kw_only=True)
class WamitRadiation:
    """A .1 file as it stands: period (n) [s] (0 infinite, -1 zero frequency), A (n, 6, 6) and B (n, 6, 6), non-dimensional."""

    period: np.ndarray
    added_mass: np.ndarray
    damping: np.ndarray


@dataclass(frozen=True, eq=False, kw_only=True)
class WamitExcitation:
    """A .3 file as it stands: period (n) [s], heading (m) [deg], force (m, n, 6) complex, non-dimensional."""

    period: np.ndarray
    heading: np.ndarray
    force: np.ndarray


def wamit_stem(path: str | Path) -> Path:
    """Return the path of a set of WAMIT files without the suffix of any of them."""
    path = Path(path)
    return path.with_suffix("") if path.suffix.lower() in SUFFIXES else path


def read_wamit_radiation(path: str | Path) -> WamitRadiation:
    """Return added mass and damping of a .1 file; missing elements are zero; raise FormatError."""
    rows, lines = _rows(path, (4, 5), "a .1 row: period, i, j, A, B")
    _check_indices(path, rows, lines, (1, 2))
    period = np.array([r[0] for r in rows])
    unique, where = np.unique(period, return_inverse=True)
    i, j = (np.array([int(r[k]) - 1 for r in rows]) for k in (1, 2))
    seen = np.zeros((len(unique), 6, 6), dtype=int)
    np.add.at(seen, (where, i, j), 1)
    if seen.max() > 1:
        p, a, b = np.argwhere(seen > 1)[0]
        raise FormatError(path, expected="each element once per period", found=f"{a + 1},{b + 1} twice at period {unique[p]:g}")
    _check_complete(path, seen, unique, "period")
    added, damping = np.zeros((2, len(unique), 6, 6))
    added[where, i, j] = [r[3] for r in rows]
    damping[where, i, j] = [r[4] if len(r) > 4 else 0.0 for r in rows]
    lacking = [k for k, r in enumerate(rows) if len(r) == 4 and r[0] > 0]
    if lacking:
        raise FormatError(path, lines[lacking[0]], expected="5 columns at a finite period", found="4 columns")
    added, damping = (_fill_symmetric(x, seen) for x in (added, damping))
    return WamitRadiation(period=unique, added_mass=added, damping=damping)


def read_wamit_excitation(path: str | Path) -> WamitExcitation:
    """Return the exciting forces of a .3 file (any order of rows); raise FormatError."""
    rows, lines = _rows(path, (7,), "a .3 row: period, heading, i, modulus, phase, real, imaginary")
    _check_indices(path, rows, lines, (2,))
    table = np.array(rows)
    period, p = np.unique(table[:, 0], return_inverse=True)
    heading, h = np.unique(table[:, 1], return_inverse=True)
    mode = table[:, 2].astype(int) - 1
    seen = np.zeros((len(heading), len(period), 6), dtype=int)
    np.add.at(seen, (h, p, mode), 1)
    if np.any(seen != 1):
        m, n, k = np.argwhere(seen != 1)[0]
        raise FormatError(
            path,
            expected="one row for every period, heading and mode",
            found=f"{seen[m, n, k]} rows at period {period[n]:g} s, heading {heading[m]:g} deg, mode {k + 1}",
            hint="Is the file complete?",
        )
    _check_modulus(path, table, lines)
    force = np.zeros(seen.shape, dtype=complex)
    force[h, p, mode] = table[:, 5] + 1j * table[:, 6]
    return WamitExcitation(period=period, heading=heading, force=force)


def read_wamit_hydrostatics(path: str | Path) -> np.ndarray:
    """Return the (6, 6) non-dimensional hydrostatic stiffness of a .hst file; raise FormatError."""
    rows, lines = _rows(path, (3,), "a .hst row: i, j, C")
    _check_indices(path, rows, lines, (0, 1))
    out = np.zeros((6, 6))
    for i, j, value in rows:
        out[int(i) - 1, int(j) - 1] = value
    return out


def read_wamit(
    path: str | Path,
    *,
    length: float = 1.0,
    density: float = 1025.0,
    gravity: float = 9.80665,
    depth: float = np.inf,
) -> HydroCoefficients:
    """Return the hydrodynamic coefficients of a set of WAMIT files, dimensional.

    path of one of the files or their common stem; length WAMIT's ULEN [m]; density [kg/m3]; gravity [m/s2]; depth [m].
    The .1 file must be there; .3 and .hst are read when they are. Raises FormatError.
    """
    stem = wamit_stem(path)
    radiation = read_wamit_radiation(_member(stem, ".1"))
    finite = radiation.period > 0
    omega = 2 * np.pi / radiation.period[finite]
    order = np.argsort(omega)
    powers = length ** (3.0 + _ROTATIONS[:, None] + _ROTATIONS[None, :])
    added, damping = density * powers * radiation.added_mass, density * powers * radiation.damping
    out = {
        "omega": omega[order],
        "added_mass": added[finite][order],
        "radiation_damping": (damping[finite] * omega[:, None, None])[order],
        "added_mass_zero": _at(added, radiation.period < 0),
        "added_mass_infinite": _at(added, radiation.period == 0),
    }
    if _exists(stem, ".3"):
        out |= _excitation(stem, omega[order], density * gravity * length ** (2.0 + _ROTATIONS))
    if _exists(stem, ".hst"):
        powers = length ** (2.0 + _ROTATIONS[:, None] + _ROTATIONS[None, :])
        out["hydrostatic_stiffness"] = density * gravity * powers * read_wamit_hydrostatics(_member(stem, ".hst"))
    return HydroCoefficients(**out, density=density, gravity=gravity, depth=depth)


def _excitation(stem: Path, omega: np.ndarray, scale: np.ndarray) -> dict:
    """Return heading [rad] and excitation of the .3 file on the frequencies of the .1 file."""
    path = _member(stem, ".3")
    data = read_wamit_excitation(path)
    finite = data.period > 0
    own = 2 * np.pi / data.period[finite]
    order = np.argsort(own)
    if len(own) != len(omega) or not np.allclose(own[order], omega, rtol=1e-4):
        raise FormatError(
            path, expected=f"the {len(omega)} periods of the .1 file", found=f"{len(own)} periods, not the same"
        )
    return {"heading": np.radians(data.heading), "excitation": (data.force[:, finite] * scale)[:, order]}


def _rows(path: str | Path, widths: tuple[int, ...], what: str) -> tuple[list[list[float]], list[int]]:
    """Return the numeric rows of a WAMIT file and their line numbers, passing over a heading line."""
    path = Path(path)
    lines = read_lines(path)
    start = 1 if any(c.isalpha() and c not in "EeDd" for c in lines[0].split("!")[0]) else 0
    rows = number_rows(path, lines[start:], start + 1, widths, what)
    if not rows:
        raise FormatError(path, expected=what, found="no row")
    return rows, [start + 1 + k for k, line in enumerate(lines[start:]) if line.strip()]


def _check_indices(path, rows, lines, columns) -> None:
    for row, line in zip(rows, lines, strict=True):
        for k in columns:
            if row[k] not in (1, 2, 3, 4, 5, 6):
                found = f"{row[k]:g}"
                hint = "Modes above 6 are further bodies or flexible modes; fowtio takes one rigid body" if row[k] > 6 else ""
                raise FormatError(path, line, expected="a mode from 1 to 6", found=found, hint=hint)


def _check_complete(path, seen, period, what) -> None:
    """Every period must have the same diagonal elements: in a file cut short the last one does not."""
    diagonal = np.diagonal(seen, axis1=1, axis2=2) > 0
    differs = np.any(diagonal != diagonal.any(axis=0), axis=1)
    if np.any(differs):
        bad = period[differs][0]
        raise FormatError(path, expected=f"the same diagonal elements at every {what}", found=f"fewer at {what} {bad:g}", hint="Is the file complete?")


def _check_modulus(path, table, lines) -> None:
    """Modulus and phase must agree with real and imaginary part: a corrupted number shows here."""
    size = np.maximum(table[:, 3], np.abs(table[:, 5:]).max(axis=1))
    wrong = np.abs(np.hypot(table[:, 5], table[:, 6]) - table[:, 3]) > 1e-3 * size + 1e-3 * np.abs(table[:, 3]).max() * 1e-3
    if np.any(wrong):
        k = int(np.argmax(wrong))
        raise FormatError(
            path, lines[k], expected="modulus equal to that of real and imaginary part",
            found=f"{table[k, 3]:g} against {np.hypot(table[k, 5], table[k, 6]):g}",
        )  # fmt: skip


def _fill_symmetric(values: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """Return the matrices with an element that only its mirror gives set equal to the mirror."""
    missing = (seen == 0) & (np.swapaxes(seen, 1, 2) > 0)
    return np.where(missing, np.swapaxes(values, 1, 2), values)


def _at(values: np.ndarray, mask: np.ndarray) -> np.ndarray | None:
    return values[mask][0] if np.any(mask) else None


def _member(stem: Path, suffix: str) -> Path:
    return stem.with_name(stem.name + suffix)


def _exists(stem: Path, suffix: str) -> bool:
    return _member(stem, suffix).is_file()
