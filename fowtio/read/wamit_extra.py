"""WAMIT result files that are kept as they stand: motions (.4), mean drift (.8, .9), second-order forces (.12d, .12s).

Source of the formats: WAMIT User Manual v7, chapters 4, 5 and 11. All are non-dimensional: motions by the wave
amplitude over ULEN^n (n = 0 translations, 1 rotations), drift and second-order forces by rho g ULEN^k (k = 1 forces,
2 moments) and the amplitude squared. e^{+i omega t}.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fowtio.errors import FormatError
from fowtio.read.registry import Format, span
from fowtio.read.wamit import as_period, check_polar, numeric_head, wamit_table


@dataclass(frozen=True, eq=False, kw_only=True)
class WamitMotion:
    """A .4 file: period (n) [s], heading (m) [deg], modes (k) as numbered in the file, motion (m, n, k) complex."""

    period: np.ndarray
    heading: np.ndarray
    modes: tuple[int, ...]
    motion: np.ndarray


@dataclass(frozen=True, eq=False, kw_only=True)
class WamitDrift:
    """A .8 (momentum) or .9 (pressure) file: period (n) [s], headings (p, 2) [deg] of the two waves, modes (k).

    force (p, n, k), complex as the file has it.
    """

    period: np.ndarray
    headings: np.ndarray
    modes: tuple[int, ...]
    force: np.ndarray


@dataclass(frozen=True, eq=False, kw_only=True)
class WamitSecondOrder:
    """A .12d (difference) or .12s (sum) file: quadratic transfer functions.

    kind "difference" or "sum"; period (n) [s]; headings (p, 2) [deg]; modes (k); force (p, n, n, k) complex, NaN where
    the file has neither the element nor its mirror: force[j, i] is the conjugate of force[i, j] for a difference and
    equal to it for a sum, the two headings exchanged.
    """

    kind: str
    period: np.ndarray
    headings: np.ndarray
    modes: tuple[int, ...]
    force: np.ndarray


def read_wamit_motion(path: str | Path, *, frequency: str = "period") -> WamitMotion:
    """Return the motions of a .4 file; every period, heading and mode once. Raises FormatError."""
    table, lines = wamit_table(path, (7,), "a .4 row: period, heading, i, modulus, phase, real, imaginary")
    period, n = np.unique(as_period(path, table[:, 0], frequency), return_inverse=True)
    heading, m = np.unique(table[:, 1], return_inverse=True)
    modes, k = _modes(path, table[:, 2], lines)
    check_polar(path, table[:, 3:], np.zeros(len(table), dtype=int), lines)
    motion = _scatter(path, (len(heading), len(period), len(modes)), (m, n, k), table)
    _complete(path, motion, "period, heading and mode")
    return WamitMotion(period=period, heading=heading, modes=modes, motion=motion)


def read_wamit_drift(path: str | Path, *, frequency: str = "period") -> WamitDrift:
    """Return the mean drift forces of a .8 or .9 file, every row once; raise FormatError."""
    table, lines = wamit_table(path, (8,), "a drift row: period, heading, heading, i, modulus, phase, real, imaginary")
    period, n = np.unique(as_period(path, table[:, 0], frequency), return_inverse=True)
    headings, p = np.unique(table[:, 1:3], axis=0, return_inverse=True)
    modes, k = _modes(path, table[:, 3], lines)
    check_polar(path, table[:, 4:], np.zeros(len(table), dtype=int), lines)
    force = _scatter(path, (len(headings), len(period), len(modes)), (p.ravel(), n, k), table)
    _complete(path, force, "period, pair of headings and mode")
    return WamitDrift(period=period, headings=headings, modes=modes, force=force)


def read_wamit_second_order(path: str | Path, *, frequency: str = "period") -> WamitSecondOrder:
    """Return the second-order forces of a .12d or .12s file; the suffix tells which. Raises FormatError."""
    kind = {"d": "difference", "s": "sum"}.get(Path(path).suffix.lower()[-1:])
    if kind is None:
        raise FormatError(path, expected="a name that ends in .12d (difference) or .12s (sum)", found=Path(path).name)
    table, lines = wamit_table(
        path, (9,), "a .12 row: period, period, heading, heading, i, modulus, phase, real, imaginary"
    )
    period, pair = np.unique(as_period(path, table[:, :2], frequency), return_inverse=True)
    headings, p = np.unique(table[:, 2:4], axis=0, return_inverse=True)
    modes, k = _modes(path, table[:, 4], lines)
    check_polar(path, table[:, 5:], np.zeros(len(table), dtype=int), lines)
    i, j = pair.reshape(-1, 2).T
    force = _scatter(path, (len(headings), len(period), len(period), len(modes)), (p.ravel(), i, j, k), table)
    return WamitSecondOrder(
        kind=kind, period=period, headings=headings, modes=modes, force=_mirrored(force, headings, kind)
    )


def _mirrored(force: np.ndarray, headings: np.ndarray, kind: str) -> np.ndarray:
    """Return the transfer functions with what only the mirror element gives."""
    order = {tuple(pair): n for n, pair in enumerate(headings)}
    swapped = [order.get((b, a)) for a, b in headings]
    out = force.copy()
    for n, other in enumerate(swapped):
        if other is not None:
            mirror = np.swapaxes(force[other], 0, 1)
            mirror = np.conj(mirror) if kind == "difference" else mirror
            out[n] = np.where(np.isnan(out[n]), mirror, out[n])
    return out


def _modes(path, column: np.ndarray, lines) -> tuple[tuple[int, ...], np.ndarray]:
    wrong = (column != np.round(column)) | (column == 0) | (np.abs(column) > 999)
    if np.any(wrong):
        raise FormatError(
            path, lines[np.argmax(wrong)], expected="a mode number", found=f"{column[np.argmax(wrong)]:g}"
        )
    modes, index = np.unique(column.astype(int), return_inverse=True)
    return tuple(int(m) for m in modes), index


def _scatter(path, shape, index, table) -> np.ndarray:
    """Return the complex numbers of the last two columns in their places, NaN elsewhere; refuse a repetition."""
    count = np.zeros(shape, dtype=int)
    np.add.at(count, index, 1)
    if count.max() > 1:
        raise FormatError(path, expected="each element once", found=f"{np.count_nonzero(count > 1)} more than once")
    out = np.full(shape, complex(np.nan, np.nan))
    out[index] = table[:, -2] + 1j * table[:, -1]
    return out


def _complete(path, values: np.ndarray, what: str) -> None:
    lacking = np.count_nonzero(np.isnan(values))
    if lacking:
        raise FormatError(
            path, expected=f"a row for every {what}", found=f"{lacking} fewer", hint="Is the file complete?"
        )


def _describe(data) -> list[tuple[str, str]]:
    rows = [
        ("periods", f"{len(data.period)}, {span(data.period, 's')}"),
        ("modes", ", ".join(map(str, data.modes))),
        ("convention", "non-dimensional, e^{+i omega t}, crest at the origin"),
    ]
    if isinstance(data, WamitMotion):
        return [*rows, ("headings", f"{len(data.heading)}, {span(data.heading, 'deg')}")]
    rows.append(("pairs of headings", f"{len(data.headings)}"))
    if isinstance(data, WamitSecondOrder):
        given = np.count_nonzero(~np.isnan(data.force)) / data.force.size
        rows.append(("frequencies", f"{data.kind}, {100 * given:.0f} % of the pairs of periods"))
    return rows


def _by_suffix(suffixes, width: int, integer: int):
    return lambda path, head: Path(path).suffix.lower() in suffixes and numeric_head(head, (width,), (integer,))


WAMIT_MOTION = Format(
    name="WAMIT .4 (motions)", recognises=_by_suffix((".4",), 7, 2), read=read_wamit_motion, describe=_describe
)
WAMIT_DRIFT = Format(
    name="WAMIT .8, .9 (mean drift)",
    recognises=_by_suffix((".8", ".9"), 8, 3),
    read=read_wamit_drift,
    describe=_describe,
)
WAMIT_SECOND_ORDER = Format(
    name="WAMIT .12d, .12s (second-order forces)",
    recognises=_by_suffix((".12d", ".12s"), 9, 4),
    read=read_wamit_second_order,
    describe=_describe,
)
