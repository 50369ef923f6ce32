"""A study to start from: the embedded case copied into a folder of the user's."""

from __future__ import annotations

import shutil
from importlib.resources import as_file, files
from pathlib import Path

from fowtio.errors import FowtioError

EMBEDDED = "oc4_deepcwind"
_PARTS = ("oc4.fowt", "README.md", "input", "linearisation", "reference")


def embedded_folder() -> Path:
    """Return the folder of the embedded case, in a checkout or an installed package."""
    checkout = Path(__file__).resolve().parent.parent / "validation" / EMBEDDED
    if checkout.is_dir():
        return checkout
    with as_file(files("fowtio.cases") / EMBEDDED) as folder:
        return Path(folder)


def require_empty(folder: str | Path) -> Path:
    """Return a folder that is new or empty; raise FowtioError otherwise."""
    folder = Path(folder)
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise FowtioError(f"{folder} exists and is not empty; name a new folder")
    return folder


def copy_embedded_case(folder: Path) -> Path:
    """Copy the embedded case into a new or empty folder and return its study file; raise FowtioError otherwise."""
    folder = require_empty(folder)
    source = embedded_folder()
    staging = folder.parent / f".{folder.name}.partial"
    shutil.rmtree(staging, ignore_errors=True)
    try:
        staging.mkdir(parents=True)
        for name in _PARTS:
            part = source / name
            if part.is_dir():
                shutil.copytree(part, staging / name)
            elif part.is_file():
                shutil.copy(part, staging / name)
        if not any((staging / "reference").glob("*")):
            _without_references(staging / "oc4.fowt")
        if folder.exists():
            folder.rmdir()
        staging.rename(folder)
    finally:
        shutil.rmtree(staging, ignore_errors=True)
    return folder / "oc4.fowt"


def _without_references(study: Path) -> None:
    """Take the tables of reference time series and decay tests out, which an installed package does not carry."""
    head, rule, _ = study.read_text().partition("---------------------- REFERENCE TIME SERIES")
    if rule:
        study.write_text(head + "END of study\n")
