"""Hydrodynamic coefficients of any supported format, found by content."""

from __future__ import annotations

from inspect import signature
from pathlib import Path

from fowtio.errors import FormatError
from fowtio.read.aqwa import AQWA_AH1
from fowtio.read.aqwa_lis import AQWA_LIS
from fowtio.read.capytaine import CAPYTAINE
from fowtio.read.nemoh import NEMOH
from fowtio.read.orcaflex import ORCAFLEX
from fowtio.read.registry import Format
from fowtio.read.wamit import WAMIT_EXCITATION, WAMIT_HYDROSTATICS, WAMIT_RADIATION, WAMIT_SET, read_wamit
from fowtio.read.wamit_out import WAMIT_OUTPUT
from model.system.hydro import HydroCoefficients

HYDRO_FORMATS: tuple[Format, ...] = (WAMIT_OUTPUT, AQWA_AH1, AQWA_LIS, CAPYTAINE, ORCAFLEX, NEMOH, WAMIT_SET)
_MEMBERS = (WAMIT_RADIATION, WAMIT_EXCITATION, WAMIT_HYDROSTATICS)


def read_hydro(path: str | Path, **options) -> HydroCoefficients:
    """Return the hydrodynamic coefficients of a file, folder or stem, dimensional and about the origin.

    path of a WAMIT set (its stem or .1, .3, .hst) or .out, an AQWA .AH1 or .LIS, a Capytaine netCDF, a Nemoh folder or
    an OrcaFlex .yml; options go to the format's own reader: `body` for all; `density` for WAMIT, and `length`,
    `gravity`, `depth`, `frequency`, `weight` for a WAMIT set. The other formats carry their water themselves; an option
    that a format does not know, or a file that is none of these, raises FormatError.
    """
    path = Path(path)
    read, name = _reader(path)
    known = hydro_options(path)
    unknown = [option for option in options if option not in known]
    if unknown:
        hint = f"It takes {', '.join(known)}; water and gravity are in the file unless named here"
        raise FormatError(
            path, expected=f"no option {', '.join(unknown)} for {name}", found=", ".join(unknown), hint=hint
        )
    return read(path, **options)


def hydro_options(path: str | Path) -> list[str]:
    """Return the names of the options that the reader of a file takes; raise FormatError as `read_hydro`."""
    return [p for p in signature(_reader(Path(path))[0]).parameters if p != "path"]


def is_hydro(path: str | Path) -> bool:
    """Tell whether a file, folder or stem holds hydrodynamic coefficients."""
    try:
        _reader(Path(path))
    except FormatError:
        return False
    return True


def _reader(path: Path):
    """Return the reader of a path and the name of its format."""
    head = b""
    if path.is_file():
        with open(path, "rb") as file:
            head = file.read(65536)
        if any(f.recognises(path, head) for f in _MEMBERS):
            return read_wamit, WAMIT_SET.name
    elif not path.exists() and not WAMIT_SET.recognises(path, b""):
        raise FormatError(path, hint="The file does not exist, nor a WAMIT set of that stem; check name and folder")
    for own in HYDRO_FORMATS:
        if own.recognises(path, head):
            return own.read, own.name
    names = "; ".join(f.name for f in HYDRO_FORMATS)
    raise FormatError(path, expected=f"one of: {names}", found="none of these")
