"""The registry of formats: what a format is, which there are, and how a file is recognised, read and described."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import Any

from fowtio.errors import FormatError


@dataclass(frozen=True, kw_only=True)
class Format:
    """One file format that fowtio reads.

    name as people call it; recognises(path, head) tells by content (head: the first 64 kB) and, only where content
    cannot tell, by suffix; read(path) returns typed data or raises FormatError; describe(data) returns what it holds as
    (label, text) rows: counts, ranges, units, conventions; problems(data) returns what is doubtful or missing in data
    that can be read all the same.
    """

    name: str
    recognises: Callable[[Path, bytes], bool]
    read: Callable[[Path], Any]
    describe: Callable[[Any], list[tuple[str, str]]]
    problems: Callable[[Any], list[str]] = lambda data: []


class SeveralBodies(FormatError):
    """A file of several bodies of which none was chosen; names are the bodies', in the order of the file."""

    def __init__(self, path, names: Sequence[str], line: int | None = None, found: str = "", what: str = "body"):
        self.names = tuple(map(str, names))
        listing = ", ".join(f"{k}: {name}" if name != str(k) else name for k, name in enumerate(self.names, start=1))
        hint = f"Choose with body=... (--body on the command line): {listing}"
        super().__init__(path, line, expected=f"one {what}", found=found or f"{len(self.names)}: {listing}", hint=hint)


@dataclass(frozen=True, kw_only=True)
class Inspection:
    """What a file is and holds: the name of its format, (label, text) rows and problems."""

    path: Path
    format: str
    rows: tuple[tuple[str, str], ...]
    problems: tuple[str, ...]


MODULES = (
    "openfast_deck",
    "openfast_lin",
    "fast7_lin",
    "openfast_out",
    "series_table",
    "results",
    "turbsim",
    "moordyn",
    "map",
    "rotor_table",
    "turbine_table",
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
_BY_SUFFIX = {
    ".fst": "openfast_deck:OPENFAST_DECK", ".lin": "openfast_lin:OPENFAST_LIN", ".outb": "openfast_out:OPENFAST_OUT",
    ".out": "openfast_out:OPENFAST_OUT", ".bts": "turbsim:TURBSIM", ".1": "wamit:WAMIT_RADIATION",
    ".2": "wamit:WAMIT_EXCITATION", ".3": "wamit:WAMIT_EXCITATION", ".hst": "wamit:WAMIT_HYDROSTATICS",
    ".4": "wamit_extra:WAMIT_MOTION", ".8": "wamit_extra:WAMIT_DRIFT", ".9": "wamit_extra:WAMIT_DRIFT",
    ".12d": "wamit_extra:WAMIT_SECOND_ORDER", ".12s": "wamit_extra:WAMIT_SECOND_ORDER", ".ah1": "aqwa:AQWA_AH1",
    ".lis": "aqwa_lis:AQWA_LIS", ".yml": "orcaflex:ORCAFLEX", ".csv": "metocean:METOCEAN", ".tsv": "metocean:METOCEAN",
    ".xlsx": "metocean:METOCEAN",
}  # fmt: skip
_UNREAD = {
    ".qtf": "AQWA's second-order forces (.QTF) are not read",
    ".sum": "Summaries are not read; give the file that the summary tells of",
    ".gdf": "Panel meshes are not read; give the results of the run",
    ".sim": "OrcaFlex's binary files are not read; export the vessel type as text (.yml)",
    ".owr": "OrcaWave's binary results are not read; export them as text (.yml)",
    ".mat": "Matlab files are not read; export them as CSV or netCDF",
    ".h5": "BEMIO's HDF5 files are not read; give the files that they were made of",
}
_MAGIC = {"capytaine": (b"CDF", b"\x89HDF")}  # imported only for files that begin so: its libraries are slow to import
INTERNAL = (
    "registry",
    "text",
    "deck_hydro",
    "elastodyn",
    "hydrodyn",
    "seastate",
    "inflowwind",
    "metocean_columns",
    "metocean_table",
    "metocean_time",
    "morison",
    "morison_elements",
    "hydro_any",
    "hydro_common",
)
HEAD = 65536


def formats() -> tuple[Format, ...]:
    """Return every registered format, in the order in which files are tried on them; imports all readers."""
    return tuple(f for module in MODULES for f in formats_of(module))


def recognise(path: str | Path) -> Format:
    """Return the format of a file, folder or stem of a set, told by content; raise FormatError when it is none.

    Where the content tells nothing (a damaged file, or another kind) the suffix does, so that the reader says what is wrong.
    """
    path = Path(path)
    head = _head(path)
    for module in MODULES:
        if module in _MAGIC and not head.startswith(_MAGIC[module]):
            continue
        for own in formats_of(module):
            if own.recognises(path, head):
                return own
    if not path.exists():
        raise FormatError(path, hint="The file does not exist, nor a set of that stem; check its name and folder")
    if path.suffix.lower() in _BY_SUFFIX and path.is_file():
        return _by_suffix(path.suffix.lower())
    raise _unknown(path, head)


def _by_suffix(suffix: str) -> Format:
    """Return the format that a suffix promises, its reader adding that to what it has to say."""
    module, _, constant = _BY_SUFFIX[suffix].partition(":")
    own = getattr(import_module(f"{__package__}.{module}"), constant)

    def read(path):
        try:
            return own.read(path)
        except FormatError as error:
            doubt = f"The content is of no known format; it was read as {own.name} because of its suffix"
            hint = f"{error.hint.rstrip('.')}. {doubt}" if error.hint else doubt
            raise FormatError(error.path, error.line, error.expected, error.found, hint) from None

    return replace(own, read=read)


def _unknown(path: Path, head: bytes) -> FormatError:
    """Return the error of a file or folder of no known format: what it begins with, and what was tried."""
    names = f"Tried by content: {', '.join(f.name for f in formats())}"
    if path.is_dir():
        return FormatError(
            path,
            expected="a file of a known format or a folder of Nemoh results",
            found="a folder without Nemoh.cal",
            hint="Name a file in it",
        )
    if not head:
        return FormatError(path, expected="a file of a known format", found="an empty file")
    begin = next((line.strip() for line in head_lines(head) if line.strip()), "") or f"binary data, {head[:12]!r}"
    unread = _UNREAD.get(path.suffix.lower(), "")
    return FormatError(path, expected="a file of a known format", found=begin, hint=unread or names)


def read_any(path: str | Path) -> Any:
    """Return what any supported file holds, as the typed data of its format; raise FormatError."""
    return recognise(path).read(Path(path))


def inspect(path: str | Path) -> Inspection:
    """Return what any supported file is and holds, every body of a file of several; raise FormatError."""
    path = Path(path)
    own = recognise(path)
    try:
        data = own.read(path)
    except SeveralBodies as several:
        rows, problems = _every_body(own, path, several.names)
    else:
        rows, problems = own.describe(data), own.problems(data)
    return Inspection(path=path, format=own.name, rows=tuple(rows), problems=tuple(problems))


def _every_body(own: Format, path: Path, names: Sequence[str]) -> tuple[list, list[str]]:
    """Return rows and problems of a file of several bodies, one body after another."""
    rows, problems = [("bodies", f"{len(names)}: {', '.join(names)}; one at a time is read (body, --body)")], []
    for k in range(1, len(names) + 1):
        try:
            data = own.read(path, body=k)
        except FormatError as error:
            problems.append(f"body {k}: {error}")
            continue
        rows += [(f"body {k}: {label}", text) for label, text in own.describe(data)]
        problems += [f"body {k}: {text}" for text in own.problems(data)]
    return rows, problems


def describe(path: str | Path) -> list[tuple[str, str]]:
    """Return what any supported file is and holds, as (label, text) rows; raise FormatError."""
    found = inspect(path)
    return [("format", found.format), *found.rows, *(("problem", text) for text in found.problems)]


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
    if not finite:
        return "none"
    low, high = f"{min(finite):.6g}", f"{max(finite):.6g}"
    return f"{low if low == high else f'{low} to {high}'} {unit}".strip()
