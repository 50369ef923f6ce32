"""WAMIT result files .1, .2, .3 and .hst: non-dimensional by density, gravity and a length, e^{+i omega t}.

Source of the format: WAMIT User Manual v7, chapters 3 to 5. The first column is the period unless the run was told
otherwise (IPEROUT); periods of 0 and -1 stand for infinite and zero frequency whatever the first column is
(section 4.2).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fowtio.errors import FormatError
from fowtio.read.hydro_common import (
    check_damping,
    coefficients,
    describe_hydro,
    hydro_problems,
    number_table,
    without_weight,
)
from fowtio.read.registry import Format, SeveralBodies, span
from fowtio.read.text import read_lines
from model.system.hydro import HydroCoefficients

SUFFIXES = (".1", ".2", ".3", ".hst")
FREQUENCIES = ("period", "omega")
_ROTATIONS = np.array([0, 0, 0, 1, 1, 1])


@dataclass(frozen=True, eq=False, kw_only=True)
class WamitRadiation:
    """A .1 file as it stands, non-dimensional: period (n) [s] (0 infinite, -1 zero frequency), A and B (n, 6, 6)."""

    period: np.ndarray
    added_mass: np.ndarray
    damping: np.ndarray


@dataclass(frozen=True, eq=False, kw_only=True)
class WamitExcitation:
    """A .2 or .3 file as it stands: period (n) [s], heading (m) [deg], force (m, n, 6) complex, non-dimensional."""

    period: np.ndarray
    heading: np.ndarray
    force: np.ndarray


def wamit_stem(path: str | Path) -> Path:
    """Return the path of a set of WAMIT files without the suffix of any of them."""
    path = Path(path)
    return path.with_suffix("") if path.suffix.lower() in SUFFIXES else path


def read_wamit_radiation(path: str | Path, *, body: int | None = None, frequency: str = "period") -> WamitRadiation:
    """Return added mass and damping of a .1 file, rows in any order; missing elements are zero.

    An element that only its mirror gives is set equal to it. body (from 1) of a file of several; frequency tells what
    the first column is, "period" [s] or "omega" [rad/s]. Raises FormatError.
    """
    table, lines = wamit_table(path, (4, 5), "a .1 row: period, i, j, A, B")
    table, lines = choose_modes(path, table, lines, (1, 2), body)
    period, where = np.unique(as_period(path, table[:, 0], frequency), return_inverse=True)
    i, j = (table[:, k].astype(int) - 1 for k in (1, 2))
    seen = np.zeros((len(period), 6, 6), dtype=int)
    np.add.at(seen, (where, i, j), 1)
    if seen.max() > 1:
        p, a, b = np.argwhere(seen > 1)[0]
        raise FormatError(
            path, expected="each element once per period", found=f"{a + 1},{b + 1} twice at period {period[p]:g}"
        )
    damping = table[:, 4] if table.shape[1] > 4 else np.full(len(table), np.nan)
    lacking = np.isnan(damping) & (period[where] > 0)
    if np.any(lacking):
        raise FormatError(path, lines[np.argmax(lacking)], expected="5 columns at a finite period", found="4 columns")
    out = np.zeros((2, len(period), 6, 6))
    out[:, where, i, j] = table[:, 3], np.nan_to_num(damping)
    added, damping = _fill_symmetric(out, seen)
    _check_complete(path, seen | np.swapaxes(seen, 1, 2), period, added)
    return WamitRadiation(period=period, added_mass=added, damping=damping)


def read_wamit_excitation(path: str | Path, *, body: int | None = None, frequency: str = "period") -> WamitExcitation:
    """Return the exciting forces of a .3 file (or .2, Haskind), rows in any order; arguments as read_wamit_radiation.

    Every period, heading and mode must be there once, and modulus and phase agree with real and imaginary part.
    Raises FormatError.
    """
    table, lines = wamit_table(path, (7,), "a .3 row: period, heading, i, modulus, phase, real, imaginary")
    table, lines = choose_modes(path, table, lines, (2,), body)
    period, p = np.unique(as_period(path, table[:, 0], frequency), return_inverse=True)
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
    check_polar(path, table[:, -4:], mode // 3, lines)
    force = np.zeros(seen.shape, dtype=complex)
    force[h, p, mode] = table[:, 5] + 1j * table[:, 6]
    return WamitExcitation(period=period, heading=heading, force=force)


def read_wamit_hydrostatics(path: str | Path, *, body: int | None = None) -> np.ndarray:
    """Return the (6, 6) non-dimensional stiffness of a .hst file (all elements or a triangle); raise FormatError."""
    table, lines = wamit_table(path, (3,), "a .hst row: i, j, C")
    table, lines = choose_modes(path, table, lines, (0, 1), body)
    i, j = (table[:, k].astype(int) - 1 for k in (0, 1))
    seen = np.zeros((1, 6, 6), dtype=int)
    np.add.at(seen[0], (i, j), 1)
    if seen.max() > 1 or not np.all(seen | np.swapaxes(seen, 1, 2)):
        found = "a repeated element" if seen.max() > 1 else f"{len(table)} rows"
        raise FormatError(
            path, expected="36 elements, each once, or one triangle", found=found, hint="Is the file complete?"
        )
    out = np.zeros((1, 6, 6))
    out[0, i, j] = table[:, 2]
    return _fill_symmetric(out, seen)[0]


def read_wamit(
    path: str | Path,
    *,
    length: float = 1.0,
    density: float = 1025.0,
    gravity: float = 9.80665,
    depth: float = np.inf,
    frequency: str = "period",
    body: int | None = None,
    weight: tuple | None = None,
) -> HydroCoefficients:
    """Return the hydrodynamic coefficients of a set of WAMIT files, dimensional.

    path of one of the files or their common stem; length WAMIT's ULEN [m]; density [kg/m3]; gravity [m/s2]; depth [m];
    frequency of the first column, "period" or "omega"; body (from 1) of a run with several. weight is the
    (mass [kg], centre (3) [m]) that the run knew, when its centre of gravity was not the origin: WAMIT's .hst then has
    the weight's share, and it is taken off. The .1 file must be there; .3 (or .2) and .hst are read when they are.
    Raises FormatError.
    """
    stem = wamit_stem(path)
    own = {"body": body, "frequency": frequency}
    radiation = read_wamit_radiation(_member(stem, ".1"), **own)
    out = dimensional_radiation(_member(stem, ".1"), radiation, length, density)
    suffix = next((s for s in (".3", ".2") if _member(stem, s).is_file()), None)
    if suffix:
        data = read_wamit_excitation(_member(stem, suffix), **own)
        out |= dimensional_excitation(_member(stem, suffix), data, out["omega"], length, density * gravity)
    if _member(stem, ".hst").is_file():
        powers = length ** (2.0 + _ROTATIONS[:, None] + _ROTATIONS[None, :])
        stiffness = density * gravity * powers * read_wamit_hydrostatics(_member(stem, ".hst"), body=body)
        if weight is not None:
            stiffness = without_weight(stiffness, weight[0], weight[1], np.zeros(3), gravity)
        out["hydrostatic_stiffness"] = stiffness
    return coefficients(_member(stem, ".1"), **out, density=density, gravity=gravity, depth=depth)


def dimensional_radiation(path, radiation: WamitRadiation, length: float, density: float) -> dict:
    """Return omega, added mass, damping and limits with dimensions: A by rho L^k, B by rho L^k omega, k = 3, 4, 5."""
    finite = radiation.period > 0
    if not np.any(finite):
        raise FormatError(path, expected="added mass and damping at finite periods", found="none")
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
    check_damping(path, out["radiation_damping"], out["omega"])
    return out


def dimensional_excitation(
    path, data: WamitExcitation, omega: np.ndarray, length: float, weight_density: float
) -> dict:
    """Return heading [rad] and excitation on the radiation's frequencies; weight_density is rho g [N/m3]."""
    finite = data.period > 0
    own = 2 * np.pi / data.period[finite]
    order = np.argsort(own)
    if len(own) != len(omega) or not np.allclose(own[order], omega, rtol=1e-4):
        raise FormatError(
            path,
            expected=f"the {len(omega)} finite periods of the added mass",
            found=f"{len(own)} periods, not the same",
        )
    scale = weight_density * length ** (2.0 + _ROTATIONS)
    return {"heading": np.radians(data.heading), "excitation": (data.force[:, finite] * scale)[:, order]}


def wamit_table(path: str | Path, widths: tuple[int, ...], what: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the numbers of a WAMIT file and their line numbers, passing over a heading line; raise FormatError."""
    lines = read_lines(path)
    start = 1 if any(c.isalpha() and c not in "EeDd" for c in lines[0].split("!")[0]) else 0
    return number_table(path, lines[start:], start + 1, widths, what)


def as_period(path, column: np.ndarray, frequency: str) -> np.ndarray:
    """Return the first column as periods [s]; 0 and below mean infinite and zero frequency in both conventions."""
    if frequency not in FREQUENCIES:
        raise FormatError(
            path, expected="frequency 'period' or 'omega'", found=frequency,
            hint="Wave numbers (IPEROUT 3, 4) are not read; repeat the run with IPEROUT = 1",
        )  # fmt: skip
    if frequency == "omega":
        return np.where(column > 0, 2 * np.pi / np.where(column > 0, column, 1.0), column)
    return column


def choose_modes(path, table, lines, columns, body: int | None) -> tuple[np.ndarray, np.ndarray]:
    """Return the rows whose mode columns belong to one body, its modes counted from 1 to 6; raise FormatError."""
    modes = table[:, columns]
    wrong = np.any((modes < 1) | (modes != np.round(modes)), axis=1)
    if np.any(wrong):
        k = int(np.argmax(wrong))
        raise FormatError(
            path, lines[k], expected="a mode number from 1", found=" and ".join(f"{m:g}" for m in modes[k])
        )
    if body is None:
        if modes.max() > 6:
            k = int(np.argmax(modes.max(axis=1) > 6))
            bodies = [str(n + 1) for n in range(int(np.ceil(modes.max() / 6)))]
            raise SeveralBodies(path, bodies, lines[k], f"mode {modes[k].max():g}", "body (modes 1 to 6)")
        return table, lines
    own = np.all((modes > 6 * (body - 1)) & (modes <= 6 * body), axis=1)
    if not np.any(own):
        found = ", ".join(str(int(n)) for n in np.unique(np.ceil(modes / 6)))
        raise FormatError(
            path, expected=f"modes {6 * body - 5} to {6 * body} of body {body}", found=f"modes of body {found} only"
        )
    table = table[own]
    table[:, columns] -= 6 * (body - 1)
    return table, lines[own]


def check_polar(path, columns: np.ndarray, group: np.ndarray, lines) -> None:
    """Modulus and phase [deg] must agree with real and imaginary part (rows, 4): a corrupted number shows here.

    Within 1 % of the modulus (files of three digits) and 1e-6 of the largest of the same group (noise, whose phase
    WAMIT prints for another value than the parts).
    """
    modulus, phase, real, imaginary = columns.T
    size = np.array([np.abs(modulus[group == g]).max(initial=0.0) for g in range(group.max() + 1)])[group]
    wrong = (
        np.abs(modulus * np.exp(1j * np.radians(phase)) - real - 1j * imaginary) > 1e-2 * np.abs(modulus) + 1e-6 * size
    )
    if np.any(wrong):
        k = int(np.argmax(wrong))
        polar = modulus[k] * np.exp(1j * np.radians(phase[k]))
        raise FormatError(
            path, lines[k], expected="modulus and phase equal to real and imaginary part",
            found=f"{polar.real:g}, {polar.imag:g} against {real[k]:g}, {imaginary[k]:g}",
            hint="One of the numbers is corrupt",
        )  # fmt: skip


def _check_complete(path, seen, period, added) -> None:
    """Every period must have the same elements, but for negligible ones: in a file cut short the last one does not.

    A file may leave out elements below a threshold at some periods; such an element is small (1e-3 of the geometric
    mean of its diagonals) where it is given.
    """
    given = seen > 0
    lacking = ~given & given.any(axis=0)
    diagonal = np.abs(np.diagonal(added, axis1=1, axis2=2)).max(axis=0)
    small = np.abs(added).max(axis=0) <= 1e-3 * np.sqrt(diagonal[:, None] * diagonal)
    np.fill_diagonal(small, False)
    lacking &= ~small
    if np.any(lacking):
        p, i, j = np.argwhere(lacking)[0]
        raise FormatError(
            path, expected=f"element {i + 1},{j + 1} at every period", found=f"none at period {period[p]:g}",
            hint="Is the file complete?",
        )  # fmt: skip


def _fill_symmetric(values: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """Return the matrices with an element that only its mirror gives set equal to the mirror."""
    missing = (seen == 0) & (np.swapaxes(seen, -1, -2) > 0)
    return np.where(missing, np.swapaxes(values, -1, -2), values)


def _at(values: np.ndarray, mask: np.ndarray) -> np.ndarray | None:
    return values[mask][0] if np.any(mask) else None


def _member(stem: Path, suffix: str) -> Path:
    return stem.with_name(stem.name + suffix)


def _describe_radiation(data: WamitRadiation) -> list[tuple[str, str]]:
    finite = data.period[data.period > 0]
    limits = [name for name, mask in (("zero", data.period < 0), ("infinite", data.period == 0)) if np.any(mask)]
    return [
        ("periods", f"{len(finite)}, {span(finite, 's')}" if len(finite) else "none"),
        ("limits", " and ".join(limits) or "none"),
        ("convention", "non-dimensional (density, ULEN, omega)"),
    ]


def _describe_excitation(data: WamitExcitation) -> list[tuple[str, str]]:
    return [
        ("periods", f"{len(data.period)}, {span(data.period, 's')}"),
        ("headings", f"{len(data.heading)}, {span(data.heading, 'deg')}"),
        ("convention", "non-dimensional (density, gravity, ULEN), e^{+i omega t}, crest at the origin"),
    ]


def _describe_hydrostatics(data: np.ndarray) -> list[tuple[str, str]]:
    return [
        ("heave, roll, pitch", ", ".join(f"{data[k, k]:.5g}" for k in (2, 3, 4))),
        (
            "convention",
            "non-dimensional (density, gravity, ULEN); with the weight's share unless the run's was at the origin",
        ),
    ]


def numeric_head(head: bytes, widths: tuple[int, ...], integers: tuple[int, ...]) -> bool:
    """Tell whether the second line of a file is a row of numbers of these widths with integers in these columns."""
    lines = [line.split() for line in head.decode("latin-1").splitlines()[1:3] if line.strip()]
    row = lines[0] if lines else []
    return len(row) in widths and all(row[k].lstrip("-").isdigit() for k in integers)


def _suffix(*suffixes: str, widths, integers):
    return lambda path, head: Path(path).suffix.lower() in suffixes and numeric_head(head, widths, integers)


WAMIT_RADIATION = Format(
    name="WAMIT .1 (added mass, radiation damping)",
    recognises=_suffix(".1", widths=(4, 5), integers=(1, 2)), read=read_wamit_radiation, describe=_describe_radiation,
)  # fmt: skip
WAMIT_EXCITATION = Format(
    name="WAMIT .2, .3 (exciting force)",
    recognises=_suffix(".2", ".3", widths=(7,), integers=(2,)), read=read_wamit_excitation,
    describe=_describe_excitation,
)  # fmt: skip
WAMIT_HYDROSTATICS = Format(
    name="WAMIT .hst (hydrostatic stiffness)",
    recognises=_suffix(".hst", widths=(3,), integers=(0, 1)), read=read_wamit_hydrostatics,
    describe=_describe_hydrostatics,
)  # fmt: skip
WAMIT_SET = Format(
    name="WAMIT set (.1, .3, .hst by their stem)",
    recognises=lambda path, head: not Path(path).exists() and _member(Path(path), ".1").is_file(),
    read=read_wamit, describe=describe_hydro, problems=hydro_problems,
)  # fmt: skip
