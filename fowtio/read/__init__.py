"""Readers: one module a format, each returning what the file says; `read_any` takes any of them, told by content.

Importing this package imports no reader: each is loaded when it is first needed.
"""

from __future__ import annotations

import sys
import types

from fowtio.read.registry import Format, Inspection, describe, formats, inspect, read_any, recognise

__all__ = ["FORMATS", "Format", "Inspection", "describe", "formats", "inspect", "read_any", "recognise"]


def __getattr__(name: str):
    """Return FORMATS, every registered format, importing the readers when it is first asked for."""
    if name == "FORMATS":
        return formats()
    raise AttributeError(f"module 'fowtio.read' has no attribute {name!r}")


class _Callable(types.ModuleType):
    """The package itself can be called: `fowtio.read(path)` is `read_any(path)`."""

    def __call__(self, path):
        """Return the typed data of any supported file."""
        return read_any(path)


sys.modules[__name__].__class__ = _Callable
