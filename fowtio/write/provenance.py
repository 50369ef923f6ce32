"""Where results come from: versions, input files with their SHA-256, the command that makes the results again."""

from __future__ import annotations

import hashlib
import os
import platform
from collections.abc import Iterable
from importlib import metadata
from pathlib import Path

from fowtio import __version__
from fowtio.read.openfast_deck import Deck, read_deck
from fowtio.write.table import Column, Table

CHUNK = 1 << 20
LIBRARIES = ("numpy", "scipy", "xarray", "h5netcdf", "openpyxl", "matplotlib", "jinja2")


def versions() -> Table:
    """Return the versions of fowtio, Python and the libraries that results depend on."""
    rows = [
        ("fowtio", __version__),
        ("Python", platform.python_version()),
        ("System", f"{platform.system()} {platform.machine()}"),
    ]
    for name in LIBRARIES:
        try:
            rows.append((name, metadata.version(name)))
        except metadata.PackageNotFoundError:
            continue
    return Table(
        name="versions", title="Versions", columns=(Column(name="Software"), Column(name="Version")), rows=tuple(rows)
    )


def input_files(model) -> list[Path]:
    """Return every file that a study (a Model of `fowtio.workflow`) reads, each one once."""
    case = model.case
    files = [case.path, *model.deck.files, *_coefficients(model.deck, case.hydro)]
    for entry in case.linearisations:
        files += entry.files
        if entry.deck is not None:
            deck = read_deck(entry.deck)
            files += [*deck.files, *_coefficients(deck)]
    files += [entry.path for entry in (case.turbine, case.rotor) if entry is not None]
    for reference in case.references:
        files += reference.files
    return list({Path(os.path.abspath(f)): None for f in files if Path(f).is_file()})


def input_table(model) -> Table:
    """Return the input files with size and SHA-256, paths from the folder of the study."""
    root = Path(os.path.abspath(model.case.path)).parent
    columns = (Column(name="File"), Column(name="Size", unit="bytes"), Column(name="SHA-256"))
    rows = tuple((_relative(f, root), float(f.stat().st_size), sha256(f)) for f in input_files(model))
    return Table(
        name="input_files",
        title="Input files",
        columns=columns,
        rows=rows,
        note="Paths from the folder of the study file.",
    )


def sha256(path: Path) -> str:
    """Return the SHA-256 of a file's content."""
    digest = hashlib.sha256()
    with path.open("rb") as stream:
        while chunk := stream.read(CHUNK):
            digest.update(chunk)
    return digest.hexdigest()


def command(model) -> str:
    """Return the command that makes the results of a study again, from its folder."""
    name = model.case.path.name
    return f'fowtio run "{name}" -o results' if " " in name else f"fowtio run {name} -o results"


def _coefficients(deck: Deck, stem: Path | None = None) -> Iterable[Path]:
    """Return the files of the hydrodynamic coefficients: the one named, or all with its name and a suffix."""
    stem = stem or (deck.hydrodyn.coefficients if deck.hydrodyn is not None and deck.hydrodyn.potential_flow else None)
    if stem is None:
        return []
    return [stem] if stem.is_file() else sorted(stem.parent.glob(stem.name + ".*"))


def _relative(path: Path, root: Path) -> str:
    """Return a path from a folder with forward slashes; the name alone where there is no way from one to the other."""
    try:
        return Path(os.path.relpath(path, root)).as_posix()
    except ValueError:
        return path.name
