"""What `fowtio check FILE` says of a single file: for people on the terminal, and as JSON."""

from __future__ import annotations

import shutil
import textwrap
from collections.abc import Sequence

from fowtio.read import Inspection

WIDEST = 120


def inspection_json(found: Inspection) -> dict:
    """Return what a file is and holds as JSON data: file, format, a key for every label, and the list of problems."""
    holds: dict[str, str | list[str]] = {}
    for label, text in found.rows:
        before = holds.get(label)
        holds[label] = text if before is None else [*([before] if isinstance(before, str) else before), text]
    return {"file": str(found.path), "format": found.format, **holds, "problems": list(found.problems)}


def show_inspection(found: Inspection) -> None:
    """Print what a file is and holds, and its problems, folded to the width of the terminal."""
    print(found.path)
    width = min(shutil.get_terminal_size((WIDEST, 24)).columns, WIDEST)
    rows = [("format", found.format), *found.rows]
    labels = max(len(label) for label, _ in rows)
    for label, text in rows:
        print(_folded(text, f"  {label.ljust(labels)}  ", width))
    count = len(found.problems)
    print(f"\n{count} {'problem' if count == 1 else 'problems'}" if count else "\nno problems")
    for text in found.problems:
        print(_folded(text, "  - ", width))


def show_files(head: str, rows: Sequence[str]) -> None:
    """Print a line and what belongs to it below, indented."""
    print(head)
    for text in rows:
        print(f"  {text}")


def _folded(text: str, head: str, width: int) -> str:
    return textwrap.fill(
        text,
        width,
        initial_indent=head,
        subsequent_indent=" " * len(head),
        break_long_words=False,
        break_on_hyphens=False,
    )
