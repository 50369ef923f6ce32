"""The shape of a registered format: how a file is recognised, read and described."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True, kw_only=True)
class Format:
    """One file format that fowtio reads.

    name as people call it; recognises(path, head) tells by content (head: the first 64 kB) and, only where content
    cannot tell, by suffix; read(path) returns typed data or raises FormatError; describe(data) returns what it holds as
    (label, text) rows: counts, ranges, units, conventions.
    """

    name: str
    recognises: Callable[[Path, bytes], bool]
    read: Callable[[Path], Any]
    describe: Callable[[Any], list[tuple[str, str]]]
