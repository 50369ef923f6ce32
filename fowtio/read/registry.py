"""The registry of formats: what a format is, which there are, and how a file is recognised, read and described."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from fowtio.errors import FormatError


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


MODULES = (
    "openfast_deck",
    "openfast_lin",
    "fast7_lin",
    "openfast_out",
    "turbsim",
    "moordyn",
    "map",
    "rotor_table",
    "wamit",
    "wamit_extra",
    "wamit_out",
    "aqwa",
    "aqwa_lis",
    "nemoh",
    "orcaflex",
    "capytaine",
    "openfast_input",
    "metocean",
)
_MAGIC = {"capytaine": (b"CDF", b"\x89HDF")}  # imported only for files that begin so: its libraries are slow to import
INTERNAL = (
    "registry",
    "text",
    "elastodyn",
    "hydrodyn",
    "seastate",
    "inflowwind",
    "metocean_columns",
    "metocean_table",
    "metocean_time",
    "morison",
    "hydro_any",
    "hydro_common",
)
HEAD = 65536


def formats() -> tuple[Format, ...]:
    """Return every registered format, in the order in which files are tried on them; imports all readers."""
    return tuple(f for module in MODULES for f in formats_of(module))


def recognise(path: str | Path) -> Format:
    """Return the format of a file, folder or stem of a set, told by content; raise FormatError when it is none."""
    path = Path(path)
    head = _head(path)
    for module in MODULES:
        if module in _MAGIC and not head.startswith(_MAGIC[module]):
            continue
        for own in formats_of(module):
            if own.recognises(path, head):
                return own
    if not path.exists():
        raise FormatError(path, hint="The file does not exist; check its name and folder")
    names = ", ".join(f.name for f in formats())
    raise FormatError(path, expected="a file of a known format", found=repr(head[:40]), hint=f"Known: {names}")


def read_any(path: str | Path) -> Any:
    """Return what any supported file holds, as the typed data of its format; raise FormatError."""
    return recognise(path).read(Path(path))


def describe(path: str | Path) -> list[tuple[str, str]]:
    """Return what any supported file is and holds, as (label, text) rows; raise FormatError."""
    own = recognise(path)
    return [("format", own.name), *own.describe(own.read(Path(path)))]


def formats_of(module: str) -> tuple[Format, ...]:
    """Return the formats that a reader module defines, in its order, importing it."""
    name = f"{__package__}.{module}"
    found = (value for value in vars(import_module(name)).values() if isinstance(value, Format))
    return tuple(own for own in found if own.recognises.__module__ == name)


def _head(path: Path) -> bytes:
    """Return the first bytes of a file, none of a folder or of what is not there."""
    if not path.is_file():
        return b""
    try:
        with path.open("rb") as stream:
            return stream.read(HEAD)
    except OSError as error:
        raise FormatError(path, expected="a readable file", found=str(error)) from None


def head_lines(head: bytes) -> list[str]:
    """Return the lines of the first bytes of a text file, none of a binary file."""
    if b"\0" in head and head[:2] not in (b"\xff\xfe", b"\xfe\xff"):
        return []
    text = head.decode("utf-16", errors="replace") if head[:2] in (b"\xff\xfe", b"\xfe\xff") else head.decode("latin-1")
    return text.replace("\r\n", "\n").replace("\r", "\n").split("\n")


def span(values, unit: str, factor: float = 1.0) -> str:
    """Return the range of finite values as text, such as '0 to 60 s'; 'none' when there are none."""
    finite = [float(v) * factor for v in values if v == v]
    return f"{min(finite):.6g} to {max(finite):.6g} {unit}".strip() if finite else "none"
