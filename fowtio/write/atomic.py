"""Results appear whole or not at all: everything is written beside its place first, then moved there."""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def atomic_file(path: str | Path) -> Iterator[Path]:
    """Give a temporary path in the same folder; on success it replaces `path`, on an exception nothing is left."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = _beside(path)
    try:
        yield temporary
        os.replace(temporary, path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


@contextmanager
def atomic_folder(folder: str | Path) -> Iterator[Path]:
    """Give a temporary folder beside `folder`; on success its files move there, on any exception nothing is left of it.

    A new folder appears at once. In one that exists already each file is replaced at once and others are left alone.
    """
    folder = Path(folder)
    folder.parent.mkdir(parents=True, exist_ok=True)
    temporary = _beside(folder)
    temporary.mkdir()
    try:
        yield temporary
        if folder.exists():
            _merge(temporary, folder)
        else:
            os.replace(temporary, folder)
    except BaseException:
        shutil.rmtree(temporary, ignore_errors=True)
        raise


def _merge(source: Path, target: Path) -> None:
    """Move every file below source to its place below target, then remove source."""
    for path in sorted(p for p in source.rglob("*") if p.is_file()):
        place = target / path.relative_to(source)
        place.parent.mkdir(parents=True, exist_ok=True)
        os.replace(path, place)
    shutil.rmtree(source)


def _beside(path: Path) -> Path:
    """Return a new hidden name in the same folder, its suffix kept."""
    return path.absolute().with_name(f".{path.stem}.{secrets.token_hex(4)}{path.suffix}")
