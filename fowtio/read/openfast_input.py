"""The text form that OpenFAST's modules (and fowtio's study file) share: `value  Name  - description` lines and tables.

Names decide, never line numbers, so one reader serves the layouts of many versions.
"""

from __future__ import annotations

import difflib
import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from fowtio.errors import FormatError
from fowtio.read.registry import Format, head_lines
from fowtio.read.text import number, numbers, read_lines

_TOKEN = re.compile(r'"[^"]*"|\'[^\']*\'|[^\s,]+')
_NAME = re.compile(r"[A-Za-z_][\w]*(\([\w, ]+\))?%?")
_OVERFLOW = re.compile(
    r"\*+\s+[A-Za-z_][\w()]*\s+-\s"
)  # a value of stars, as Fortran writes one too long for its field
_TRUE, _FALSE = {"true", "t", ".true."}, {"false", "f", ".false."}
_NAMED = re.compile(r"""\s*(?:"[^"]*"|'[^']*'|\S+)\s+([A-Za-z_][\w()]*)\s+-""")
_MISSING = object()


def tokens(line: str) -> list[str]:
    """Return the blank- or comma-separated tokens of a line, quoted strings whole."""
    return _TOKEN.findall(line)


def unquote(token: str) -> str:
    """Return a token without its quotation marks."""
    return token[1:-1].strip() if len(token) > 1 and token[0] == token[-1] and token[0] in "\"'" else token


def is_comment(line: str) -> bool:
    """Tell whether a line is a comment."""
    return line.lstrip().startswith(("!", "#", "%"))


def is_rule(line: str) -> bool:
    """Tell whether a line is a section rule or a comment."""
    text = line.lstrip()
    return is_comment(line) or (text.startswith(("---", "===", "***")) and not _OVERFLOW.match(text))


@dataclass
class InputFile:
    """One OpenFAST-style input file, its values found by name.

    path, lines as read; entries maps a lower-case name to (line number from 1, value tokens, name as written), the
    first when a name is given again; repeated maps it to the first line that gives it another value.
    """

    path: Path
    lines: list[str]
    entries: dict[str, tuple[int, list[str], str]] = field(default_factory=dict)
    repeated: dict[str, int] = field(default_factory=dict)

    def has(self, name: str) -> bool:
        """Tell whether the file gives a value under this name."""
        return name.lower() in self.entries

    def line(self, name: str) -> int:
        """Return the line number of a name; raise FormatError with the nearest known name when it is not there."""
        if not self.has(name):
            near = difflib.get_close_matches(name.lower(), self.entries, n=1, cutoff=0.75)
            hint = (
                f"Nearest name in the file: {self.entries[near[0]][2]}" if near else "Is this the right kind of file?"
            )
            raise FormatError(self.path, expected=f"a line with the value of {name}", found="none", hint=hint)
        return self.entries[name.lower()][0]

    def values(self, name: str) -> list[str]:
        """Return the value tokens that stand before a name; raise FormatError when it is given two values."""
        first = self.line(name)
        if name.lower() in self.repeated:
            again = self.repeated[name.lower()]
            raise FormatError(
                self.path, again, expected=f"{name} once (line {first} gives it too)", found=self.lines[again - 1]
            )
        return self.entries[name.lower()][1]

    def text(self, name: str, default=_MISSING) -> str:
        """Return the value of a name as text without quotes."""
        if default is not _MISSING and not self.has(name):
            return default
        values = self.values(name)
        if not values:
            raise FormatError(self.path, self.line(name), expected=f"a value before {name}", found="none")
        return unquote(values[0])

    def file(self, name: str) -> Path:
        """Return the path of the file a name gives, relative to this one; raise FormatError when it is not there."""
        text = self.text(name)
        path = self.path.parent / text
        if not path.is_file():
            path = self.path.parent / text.replace("\\", "/")
        if path.is_file():
            return path
        twin = _other_case(path)
        hint = (
            f"There is {twin}: mind upper and lower case"
            if twin
            else f"Looked for {path}; paths are relative to {self.path.name}"
        )
        raise FormatError(self.path, self.line(name), expected=f"an existing file for {name}", found=text, hint=hint)

    def is_default(self, name: str) -> bool:
        """Tell whether a name is absent or its value is DEFAULT."""
        return not self.has(name) or self.text(name).lower() == "default"

    def _typed(self, name, default, convert, expected):
        if default is not _MISSING and self.is_default(name):
            return default
        text = self.text(name)
        try:
            return convert(text)
        except (ValueError, KeyError):
            raise FormatError(self.path, self.line(name), expected=f"{expected} for {name}", found=text) from None

    def number(self, name: str, default=_MISSING) -> float:
        """Return the value of a name as a finite number; `default` stands for an absent name or DEFAULT."""
        return self._typed(name, default, number, "a number")

    def integer(self, name: str, default=_MISSING) -> int:
        """Return the value of a name as a whole number."""

        def convert(text):
            value = number(text)
            if value != int(value):
                raise ValueError
            return int(value)

        return self._typed(name, default, convert, "a whole number")

    def flag(self, name: str, default=_MISSING) -> bool:
        """Return the value of a name as True or False."""
        return self._typed(name, default, _flag, "True or False")

    def array(self, name: str, rows: int, columns: int) -> np.ndarray:
        """Return a (rows, columns) matrix whose first row stands on the line of the name and the others below it."""
        first = self.line(name)
        try:
            out = [[number(t) for t in self.values(name)[:columns]]]
        except ValueError:
            out = [[]]
        for i in range(first, first + rows - 1):
            line = self.lines[i] if i < len(self.lines) else ""
            try:
                out.append(numbers(" ".join(tokens(line)[:columns])))
            except ValueError:
                out.append([])
        for offset, row in enumerate(out):
            if len(row) != columns:
                found = self.lines[first - 1 + offset] if first - 1 + offset < len(self.lines) else "end of file"
                raise FormatError(
                    self.path, first + offset, expected=f"{columns} numbers (row {offset + 1} of {name})", found=found
                )
        return np.array(out)

    def table(self, count: str = "", header: str = "", rows: int | None = None) -> Table:
        """Return the table below the line of `count`, which gives its rows, or with `header` as its first column."""
        if count:
            rows = self.integer(count)
            start = self.line(count)
        else:
            start = next(
                (i for i, ln in enumerate(self.lines) if ln.split()[:1] and ln.split()[0].lower() == header.lower()),
                None,
            )
            if start is None:
                raise FormatError(self.path, expected=f"a table whose first column is {header}", found="none")
        if rows < 0:
            raise FormatError(self.path, start, expected=f"{count} of at least 0", found=str(rows))
        return _table(self, start, rows, count or header)


@dataclass(frozen=True)
class Table:
    """A table of an input file: column names, rows of tokens, and the line number of each row."""

    path: Path
    columns: list[str]
    rows: list[list[str]]
    numbers_of_lines: list[int]

    def __len__(self) -> int:
        return len(self.rows)

    def column(self, name: str) -> list[str]:
        """Return the tokens of a column; raise FormatError when the table lacks it."""
        lower = [c.lower() for c in self.columns]
        if name.lower() not in lower:
            at = self.numbers_of_lines[0] if self.numbers_of_lines else None
            raise FormatError(self.path, at, expected=f"a table with column {name}", found=" ".join(self.columns))
        j = lower.index(name.lower())
        for row, line in zip(self.rows, self.numbers_of_lines, strict=True):
            if len(row) <= j:
                raise FormatError(self.path, line, expected=f"a value for column {name}", found=" ".join(row))
        return [unquote(row[j]) for row in self.rows]

    def numbers(self, name: str) -> np.ndarray:
        """Return a column as numbers."""
        out = []
        for token, line in zip(self.column(name), self.numbers_of_lines, strict=True):
            try:
                out.append(number(token))
            except ValueError:
                raise FormatError(self.path, line, expected=f"a number in column {name}", found=token) from None
        return np.array(out)

    def integers(self, name: str) -> np.ndarray:
        """Return a column as whole numbers."""
        values = self.numbers(name)
        for value, line in zip(values, self.numbers_of_lines, strict=True):
            if value != int(value):
                raise FormatError(self.path, line, expected=f"a whole number in column {name}", found=str(value))
        return values.astype(int)


def read_input(path: str | Path) -> InputFile:
    """Return an OpenFAST-style input file with its values by name; raise FormatError when it cannot be read."""
    path = Path(path)
    out = InputFile(path, read_lines(path))
    for i, line in enumerate(out.lines, start=1):
        is_title = i == 2 and is_rule(out.lines[0])
        entry = None if is_title or is_rule(line) else _entry(tokens(line))
        if entry is not None:
            name = entry[1].lower()
            if out.entries.setdefault(name, (i, *entry))[1] != entry[0] and entry[0]:
                out.repeated.setdefault(name, i)
    return out


def _other_case(path: Path) -> str:
    """Return the name of a file in the same folder that differs in upper and lower case only, or ""."""
    if not path.parent.is_dir():
        return ""
    return next((p.name for p in path.parent.iterdir() if p.name.lower() == path.name.lower()), "")


def _entry(parts: list[str]) -> tuple[list[str], str] | None:
    """Return (values, name) of a `values  Name - description` line, or None when it is not one."""
    if len(parts) >= 2 and parts[1] in "-–" and _NAME.fullmatch(parts[0]):
        return [], parts[0]
    for i, part in enumerate(parts[1:], start=1):
        if part[0] in "\"'" or _is_number(part) or (part.lower() in _TRUE | _FALSE and i < 4):
            continue
        return (parts[:i], part) if _NAME.fullmatch(part) else None
    return None


def _table(source: InputFile, start: int, rows: int, what: str) -> Table:
    """Read header, units and rows of a table that begins at or below line index `start`."""
    i = start
    while i < len(source.lines) and (not source.lines[i].strip() or is_rule(source.lines[i])):
        i += 1
    columns = source.lines[i].split() if i < len(source.lines) else []
    i += 1
    if i < len(source.lines) and source.lines[i].lstrip().startswith("("):
        i += 1
    found, where = [], []
    while len(found) < rows:
        line = source.lines[i] if i < len(source.lines) else "---"
        if is_rule(line) and not is_comment(line):
            place = min(i + 1, len(source.lines))
            raise FormatError(
                source.path, place, expected=f"{rows} rows in the table of {what}", found=f"{len(found)} rows"
            )
        if line.strip() and not is_comment(line):
            found.append(tokens(line.split("!")[0]))
            where.append(i + 1)
        i += 1
    _check_end(source, i, columns, rows, what)
    return Table(source.path, columns, found, where)


def _check_end(source: InputFile, i: int, columns: list[str], rows: int, what: str) -> None:
    """Raise FormatError when the line behind a table looks like one more row: the count is then wrong."""
    while i < len(source.lines) and is_comment(source.lines[i]):
        i += 1
    parts = tokens(source.lines[i].split("!")[0]) if i < len(source.lines) else []
    if (
        parts
        and len(parts) >= len(columns)
        and _is_number(parts[0])
        and _is_number(parts[1] if len(parts) > 1 else "0")
    ):
        raise FormatError(
            source.path, i + 1, expected=f"the end of the table of {what} after {rows} rows", found=source.lines[i]
        )


def _is_number(text: str) -> bool:
    try:
        float(text.replace("D", "E").replace("d", "e"))
    except ValueError:
        return False
    return True


def _flag(text: str) -> bool:
    if text.lower() not in _TRUE | _FALSE:
        raise ValueError(text)
    return text.lower() in _TRUE


def names_in(head: bytes) -> set[str]:
    """Return the lower-case names that `value  Name - description` lines of a file's beginning give values to."""
    found = (_NAMED.match(line) for line in head_lines(head))
    return {match[1].lower() for match in found if match}


def _describe(source: InputFile) -> list[tuple[str, str]]:
    given = [name for _, values, name in source.entries.values() if values]
    return [("title", source.lines[1].strip() if len(source.lines) > 1 else ""), ("names", ", ".join(given[:20]))]


OPENFAST_INPUT = Format(
    name="OpenFAST-style input file",
    recognises=lambda path, head: len(names_in(head)) >= 5,
    read=read_input,
    describe=_describe,
)
