"""What the readers of hydrodynamic coefficients share: number tables, phase references, checks, a description."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
from pathlib import Path

import numpy as np

from fowtio.errors import FormatError
from fowtio.read.registry import SeveralBodies, span
from fowtio.read.text import number, number_rows
from model.conventions import PLATFORM_DOFS, move_matrix, weight_stiffness
from model.environment.airy import wavenumber
from model.system.hydro import HydroCoefficients, transfer


def number_table(
    path: str | Path, lines: Sequence[str], first: int, widths: Sequence[int], what: str
) -> tuple[np.ndarray, np.ndarray]:
    """Return the numbers (rows, widest) of consecutive table lines and their line numbers (rows).

    Blank lines are passed over; a row shorter than the widest ends in NaN. first is the line number (from 1) of
    lines[0], widths the allowed numbers of columns, what names a row in the message. Raises FormatError at the
    first bad line.
    """
    tokens = [line.split() for line in lines]
    count = np.fromiter(map(len, tokens), dtype=int, count=len(tokens))
    where = first + np.flatnonzero(count)
    count = count[count > 0]
    if len(count) == 0:
        raise FormatError(path, expected=what, found="no row")
    flat = _plain_numbers(tokens) if np.all(np.isin(count, widths)) else None
    if flat is None:  # the slow way: mends Fortran's spellings, or says where the bad line is
        rows = number_rows(Path(path), lines, first, widths, what)
        count = np.array([len(row) for row in rows])
        flat = np.array(list(chain.from_iterable(rows)))
    table = np.full((len(count), max(count)), np.nan)
    table[np.arange(table.shape[1]) < count[:, None]] = flat
    check_size(path, table, where)
    return table, where


def check_size(path, values: np.ndarray, lines=None) -> None:
    """Raise FormatError for a number beyond 1e60, which no coefficient is: its exponent is corrupt."""
    beyond = np.abs(values) > 1e60
    if np.any(beyond):
        at = int(np.argwhere(beyond)[0][0])
        raise FormatError(
            path, None if lines is None else lines[at], expected="numbers below 1e60", found=f"{values[beyond][0]:g}"
        )


def _plain_numbers(tokens: list[list[str]]) -> np.ndarray | None:
    """Return the numbers of all tokens, or None when one is not a plain finite number."""
    flat = list(chain.from_iterable(tokens))
    try:
        values = np.fromiter(map(float, flat), dtype=float, count=len(flat))
    except ValueError:
        return None
    return values if np.all(np.isfinite(values)) and "_" not in "".join(flat) else None


def number_at(path, line: int | None, text: str) -> float:
    """Return the one number that a piece of a line (from 1) spells; raise FormatError."""
    try:
        return number(text.strip())
    except ValueError as error:
        raise FormatError(path, line, expected="a number", found=text, hint=str(error)) from None


def wave_number(path, omega, depth: float, gravity: float) -> np.ndarray:
    """Return the wavenumber [1/m] of linear waves; raise FormatError for a depth or gravity that is not positive."""
    if not (depth > 0 and gravity > 0):
        raise FormatError(path, expected="a positive water depth and gravity", found=f"{depth:g} m, {gravity:g} m/s2")
    return wavenumber(omega, depth, gravity)


def phase_to_origin(force: np.ndarray, heading, wavenumber, point) -> np.ndarray:
    """Return forces (m, n, 6) that refer to a crest at `point` (x, y, ...) [m], referred to a crest at the origin.

    heading (m) [rad]; wavenumber (n) [1/m]; convention e^{+i omega t}.
    """
    heading = np.asarray(heading)[:, None]
    path = np.cos(heading) * point[0] + np.sin(heading) * point[1]
    return force * np.exp(-1j * np.asarray(wavenumber) * path)[..., None]


def stiffness_about(stiffness, centre, point, displaced_weight: float) -> np.ndarray:
    """Return a buoyancy stiffness (6, 6), known about `centre` (3) [m], about `point` (3) [m].

    The displaced weight [N] acts upwards through the body, so the moment about a point moves with the point; about a
    point below, the roll and pitch stiffness is larger by the weight times the distance.
    """
    offset = np.asarray(point, dtype=float) - np.asarray(centre, dtype=float)
    return move_matrix(stiffness, offset) + weight_stiffness(displaced_weight, offset, 1.0)


def without_weight(stiffness, mass: float, centre, point, gravity: float) -> np.ndarray:
    """Return a hydrostatic stiffness (6, 6) about `point` without the share of the weight of a mass at `centre`."""
    return np.asarray(stiffness) - weight_stiffness(
        mass, np.asarray(centre, dtype=float) - np.asarray(point, dtype=float), gravity
    )


def check_limits(path, added_mass: np.ndarray, zero, infinite) -> None:
    """Raise FormatError when the zero- and infinite-frequency added mass are plainly in each other's place.

    added_mass (n, 6, 6) ascending in frequency; surge, sway and heave are compared with the ends of the data.
    """
    if zero is None or infinite is None or len(added_mass) < 2:
        return

    def distance(a, b):
        return np.linalg.norm(np.diagonal(a - b)[:3])

    low, high = added_mass[0], added_mass[-1]
    straight = distance(zero, low) + distance(infinite, high)
    crossed = distance(zero, high) + distance(infinite, low)
    if crossed < 0.3 * straight:
        raise FormatError(
            path, expected="the zero-frequency added mass near that of the lowest frequency",
            found="it near that of the highest, and the infinite-frequency one near the lowest",
            hint="The rows of zero and infinite frequency look exchanged",
        )  # fmt: skip


def check_damping(path, damping: np.ndarray, omega: np.ndarray) -> None:
    """Raise FormatError when a diagonal radiation damping (n, 6, 6) is far below zero: it must not be negative.

    A few per cent of the largest are allowed (irregular frequencies and coarse meshes give that).
    """
    diagonal = np.diagonal(damping, axis1=1, axis2=2)
    wrong = diagonal < -0.2 * np.abs(diagonal).max(axis=0) - 1e-9 * np.abs(damping).max()
    if np.any(wrong):
        n, mode = np.argwhere(wrong)[0]
        raise FormatError(
            path, expected=f"a radiation damping in {PLATFORM_DOFS[mode]} that is not negative",
            found=f"{diagonal[n, mode]:.4g} at {omega[n]:.4g} rad/s",
            hint="Is the sign or the column order that of this format?",
        )  # fmt: skip


def check_mirror(path, values: np.ndarray, omega: np.ndarray, what: str) -> None:
    """Raise FormatError when one element (n, 6, 6) disagrees with its mirror at single frequencies: a corrupt number.

    Reciprocity makes added mass and damping symmetric. Data that are unsymmetric throughout pass: that is the run's
    fault, not the file's.
    """
    if len(values) < 3:
        return
    diagonal = np.abs(np.diagonal(values, axis1=1, axis2=2)).max(axis=0)
    scale = np.sqrt(np.outer(diagonal, diagonal)) + 1e-300
    error = np.abs(values - np.swapaxes(values, 1, 2)) / scale
    wrong = (error > 0.3) & (np.median(error, axis=0) < 0.03)
    if np.any(wrong):
        n, i, j = np.argwhere(wrong)[0]
        raise FormatError(
            path, expected=f"{what} {i + 1},{j + 1} and {j + 1},{i + 1} alike at {omega[n]:.4g} rad/s, as elsewhere",
            found=f"{values[n, i, j]:.4g} and {values[n, j, i]:.4g}", hint="One of the numbers is corrupt",
        )  # fmt: skip


def choose_body(path, wanted, names: Sequence, what: str = "body") -> int:
    """Return the place (from 0) of the wanted body (a name, or a number from 1); by default of the only one."""
    names = [str(name) for name in names]
    if wanted is None:
        if len(names) == 1:
            return 0
        raise SeveralBodies(path, names, what=what)
    if isinstance(wanted, str) and wanted in names:
        return names.index(wanted)
    if not isinstance(wanted, str) and 1 <= wanted <= len(names):
        return int(wanted) - 1
    listing = ", ".join(f"{k + 1}: {name}" if name != str(k + 1) else name for k, name in enumerate(names))
    raise FormatError(path, expected=f"{what} {wanted}", found=listing, hint="Choose one of these")


def describe_hydro(hydro: HydroCoefficients) -> list[tuple[str, str]]:
    """Return what a set of coefficients holds, as (label, text) rows."""
    have = [("zero", hydro.added_mass_zero), ("infinite", hydro.added_mass_infinite)]
    limits = " and ".join(name for name, value in have if value is not None) or "none"
    stiffness, centre = hydro.hydrostatic_stiffness, hydro.centre_of_buoyancy
    c = None if stiffness is None else np.diagonal(stiffness)
    return [
        ("frequencies", f"{len(hydro.omega)}, {span(hydro.omega[[0, -1]], 'rad/s')}" if len(hydro.omega) else "none"),
        ("limits of added mass", f"{limits} frequency" if limits != "none" else limits),
        ("headings", "no excitation" if hydro.heading is None else f"{len(hydro.heading)}, {span(np.degrees(hydro.heading), 'deg')}"),
        ("water", f"{hydro.density:g} kg/m3, g {hydro.gravity:g} m/s2, depth {'infinite' if np.isinf(hydro.depth) else f'{hydro.depth:g} m'}"),
        ("hydrostatic stiffness", "none" if c is None else f"heave {c[2]:.5g} N/m, roll {c[3]:.5g}, pitch {c[4]:.5g} N m/rad, of buoyancy alone"),
        ("displaced volume", "not in the file" if hydro.volume is None else f"{hydro.volume:.6g} m3"),
        *([] if centre is None else [("centre of buoyancy", "({:.5g}, {:.5g}, {:.5g}) m".format(*centre))]),
        ("reference point", "({:g}, {:g}, {:g}) m".format(*hydro.reference_point)),
        ("convention", "SI, Re{X e^{+i omega t}}, crest at the origin, headings towards, counter-clockwise from +x"),
    ]  # fmt: skip


def hydro_problems(hydro: HydroCoefficients) -> list[str]:
    """Return what is missing or doubtful in a set of coefficients."""
    missing = (
        (hydro.excitation, "no exciting forces"),
        (hydro.hydrostatic_stiffness, "no hydrostatic stiffness"),
        (hydro.added_mass_zero, "no zero-frequency added mass; that of the lowest frequency is held below it"),
        (hydro.added_mass_infinite, "no infinite-frequency added mass; that of the highest frequency is taken"),
    )
    out = [text for value, text in missing if value is None]
    diagonal = np.diagonal(hydro.radiation_damping, axis1=1, axis2=2)
    share = diagonal.min(axis=0) / np.maximum(diagonal.max(axis=0), 1e-300)
    for mode in np.flatnonzero(share < -1e-3):
        count = int(np.sum(diagonal[:, mode] < 0))
        at = "1 frequency" if count == 1 else f"{count} frequencies"
        out.append(
            f"the radiation damping in {PLATFORM_DOFS[mode]} is negative at {at}, "
            f"down to {100 * share[mode]:.2g} % of its largest"
        )
    for name, values in (("added mass", hydro.added_mass), ("radiation damping", hydro.radiation_damping)):
        out += _asymmetry(name, values)
    return out


def _asymmetry(name: str, values: np.ndarray) -> list[str]:
    """Return a text when matrices (n, 6, 6) are unsymmetric by more than 3 % of their diagonals, with the worst element."""
    size = np.abs(np.diagonal(values, axis1=1, axis2=2)).max(axis=0)
    scale = np.sqrt(np.outer(size, size))
    error = np.abs(values - np.swapaxes(values, 1, 2)).max(axis=0) / np.where(scale > 0, scale, np.inf)
    i, j = np.unravel_index(np.argmax(error), (6, 6))
    if error[i, j] < 0.03:
        return []
    return [
        f"the {name} is not symmetric: {PLATFORM_DOFS[i]}-{PLATFORM_DOFS[j]} by {100 * error[i, j]:.2g} % of the diagonal"
    ]


def coefficients(path, *, point=(0.0, 0.0, 0.0), **fields) -> HydroCoefficients:
    """Return coefficients given about `point` (3) [m], about the origin; raise FormatError when they are inconsistent.

    fields are those of HydroCoefficients; frequencies and headings may come in any order, excitation with them.
    """
    fields = {name: value for name, value in fields.items() if value is not None}
    for value in fields.values():
        check_size(path, np.atleast_1d(np.where(np.isinf(value), 0, value)))
    order = np.argsort(fields["omega"])
    for name in ("omega", "added_mass", "radiation_damping"):
        fields[name] = np.asarray(fields[name])[order]
    if "excitation" in fields:
        by_heading = np.argsort(fields["heading"])
        fields["heading"] = np.asarray(fields["heading"])[by_heading]
        fields["excitation"] = np.asarray(fields["excitation"])[by_heading][:, order]
    try:
        hydro = HydroCoefficients(reference_point=point, **fields)
        hydro = transfer(hydro, np.zeros(3)) if np.any(hydro.reference_point != 0) else hydro
    except ValueError as error:
        raise FormatError(path, expected="consistent coefficients", found=str(error)) from None
    check_limits(path, hydro.added_mass, hydro.added_mass_zero, hydro.added_mass_infinite)
    check_mirror(path, hydro.added_mass, hydro.omega, "added mass")
    check_mirror(path, hydro.radiation_damping, hydro.omega, "damping")
    return hydro
