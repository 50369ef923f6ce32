"""What fowtio says when something is wrong: what, where, what was expected, what to do."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


class FowtioError(Exception):
    """Any problem a user can mend; the command line prints it without a traceback and exits with 1."""


class FormatError(FowtioError):
    """A file that cannot be read as what it should be.

    Parameters: path of the file; line number from 1 (None when the whole file is meant);
    what was expected and what was found there; hint, what to do about it.
    """

    def __init__(self, path: str | Path, line: int | None = None, expected: str = "", found: str = "", hint: str = ""):
        self.path, self.line, self.expected, self.found, self.hint = Path(path), line, expected, found, hint
        where = f"{path}" if line is None else f"{path}, line {line}"
        parts = [f"expected {expected}" if expected else "", f"found {_shorten(found)}" if found else ""]
        text = ", ".join(p for p in parts if p) or "cannot be read"
        super().__init__(f"{where}: {text}" + (f". {hint}" if hint else ""))


@dataclass(frozen=True)
class Problem:
    """One thing wrong in a study, with its place."""

    text: str
    path: Path | None = None
    line: int | None = None

    def __str__(self) -> str:
        where = "" if self.path is None else f"{self.path}" + (f", line {self.line}" if self.line else "") + ": "
        return where + self.text


class CaseError(FowtioError):
    """Everything wrong with a study, reported at once."""

    def __init__(self, problems: list[Problem]):
        self.problems = tuple(problems)
        super().__init__("\n".join(str(p) for p in problems))


class ModelError(FowtioError):
    """The input is readable but describes something that cannot be (a line too short, a floater that sinks)."""


def _shorten(text: str, width: int = 80) -> str:
    text = " ".join(str(text).split())
    return repr(text if len(text) <= width else text[: width - 1] + "…")
