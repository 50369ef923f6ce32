"""What every text reader needs: lines in any encoding, numbers as Fortran writes them, errors with their place."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from fowtio.errors import FormatError

_MERGED = re.compile(r"(?<=[0-9.])(?=[+-]\d*\.)")  # -1.2E+00-5.6E+00: a sign after a digit begins a new number
_BARE_EXPONENT = re.compile(
    r"([+-]?(?:\d+\.\d*|\.\d+))([+-]\d{3})"
)  # 1.234-103: three-digit exponent without its letter
_PLAIN = re.compile(r"[0-9+\-.eEdD]+")


def read_bytes(path: str | Path) -> bytes:
    """Return the bytes of a file; raise FormatError when they cannot be had."""
    path = Path(path)
    try:
        return path.read_bytes()
    except FileNotFoundError:
        raise FormatError(path, hint="The file does not exist; check its name and folder") from None
    except OSError as error:
        raise FormatError(path, found=str(error), expected="a readable file") from None


def read_text(path: str | Path) -> str:
    """Return the text of a file, decoded as UTF-8 or, failing that, Latin-1; raise FormatError when it cannot be had."""
    data = read_bytes(path)
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return data.decode("utf-16", errors="replace")
    if b"\0" in data:
        raise FormatError(path, expected="a text file", found="binary data")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def read_lines(path: str | Path) -> list[str]:
    """Return the lines of a text file without line ends; raise FormatError when it is missing or empty."""
    text = read_text(path).replace("\r\n", "\n").replace("\r", "\n")
    lines = text.split("\n")
    if lines and not lines[-1]:
        lines.pop()
    if not any(line.strip() for line in lines):
        raise FormatError(path, expected="text", found="an empty file")
    return lines


def number(token: str) -> float:
    """Return the finite number that a token spells (Fortran D exponents too); raise ValueError otherwise."""
    if not _PLAIN.fullmatch(token):
        raise ValueError(f"{token!r} is not a finite number")
    try:
        value = float(token)
    except ValueError:
        text = token.replace("D", "E").replace("d", "e")
        bare = _BARE_EXPONENT.fullmatch(text)
        value = float(f"{bare[1]}E{bare[2]}" if bare else text)
    if not np.isfinite(value):
        raise ValueError(f"{token!r} is not a finite number")
    return value


def is_number(token: str) -> bool:
    """Return whether `number` reads this token."""
    try:
        number(token)
    except ValueError:
        return False
    return True


def numbers(line: str) -> list[float]:
    """Return the numbers of a line, apart by blanks, commas or only by their signs; raise ValueError if there are others."""
    tokens = line.replace(",", " ").split()
    try:
        return [number(t) for t in tokens]
    except ValueError:
        return [number(part) for t in tokens for part in _MERGED.split(t)]


def number_rows(path: Path, lines: Sequence[str], first: int, widths: Sequence[int], what: str) -> list[list[float]]:
    """Return the numbers of consecutive table lines, skipping blank ones.

    first is the line number (from 1) of lines[0]; widths are the allowed numbers of columns; what names a row
    in the message. Raises FormatError at the first bad line, naming the others.
    """
    rows, bad = [], []
    for offset, line in enumerate(lines):
        if not line.strip():
            continue
        try:
            row, wrong = numbers(line), ""
        except ValueError as error:
            row, wrong = [], str(error)
        if wrong or len(row) not in widths:
            bad.append((first + offset, line, wrong))
        rows.append(row)
    if bad:
        at, line, wrong = bad[0]
        columns = " or ".join(str(w) for w in widths)
        raise FormatError(
            path,
            at,
            expected=what if wrong else f"{what} ({columns} columns)",
            found=line,
            hint=_further(wrong, bad[1:]),
        )
    return rows


def _further(hint: str, bad: list) -> str:
    """Return a hint with the numbers of further bad lines."""
    listed = ", ".join(str(line) for line, *_ in bad[:8]) + (", ..." if len(bad) > 8 else "")
    more = f"{len(bad)} more such {'line' if len(bad) == 1 else 'lines'}: {listed}" if bad else ""
    return "; ".join(text for text in (hint, more) if text)


def number_table(path: Path, lines: Sequence[str], first: int, width: int, what: str) -> np.ndarray:
    """Return the (rows, width) numbers of consecutive table lines: at once when they are clean, else line by line.

    Parameters as of `number_rows`. Raises FormatError at the first bad line.
    """
    if not any(line.strip() for line in lines):
        return np.zeros((0, width))
    try:
        table = np.loadtxt(lines, comments=None, ndmin=2)
        if table.shape[1] == width and np.all(np.isfinite(table)):
            return table
    except ValueError:
        pass
    return np.array(number_rows(path, lines, first, (width,), what)).reshape(-1, width)
