"""From one file to an equivalent one: hydrodynamic coefficients, moorings, time series, metocean records, results."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from fowtio.errors import FormatError
from fowtio.read import recognise
from fowtio.read.hydro_any import hydro_options, is_hydro, read_hydro
from fowtio.read.wamit import wamit_stem
from fowtio.write.atomic import atomic_folder

_WATER = {"density": (1025.0, "kg/m3"), "gravity": (9.80665, "m/s2"), "depth": (np.inf, "m")}


@dataclass(frozen=True, kw_only=True)
class Conversion:
    """What a conversion read and wrote: names of the formats, files, and notes on what was assumed or left out."""

    source: Path
    read_as: str
    written_as: str
    files: tuple[Path, ...]
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class _Kind:
    """A family of equivalent formats: name, options, targets by name, and the target of a suffix ("" for others)."""

    name: str
    options: tuple[str, ...]
    targets: Mapping[str, Callable]
    suffixes: Mapping[str, str]
    read: Callable[[Path, dict], tuple[Any, list[str]]]


def convert(source: str | Path, target: str | Path, *, to: str | None = None, **options) -> Conversion:
    """Write what a file holds in another, equivalent format; every file appears whole or not at all.

    Parameters
    ----------
    source : a file, folder or stem of a set that fowtio reads
    target : the file, stem of a WAMIT set, or folder to write; its suffix tells the format
    to : the format where the suffix does not: wamit, capytaine; map, moordyn (version 2), moordyn1; outb, out, csv, netcdf
    options : body, length, density, gravity, depth, frequency, weight, volume of the source (see `fowtio.read_hydro`),
        target_length (WAMIT's ULEN to write) for coefficients; depth, gravity, density for moorings

    Raises
    ------
    FormatError : the source cannot be read, cannot become what is asked for, or does not take an option.
    ModelError : the format to write cannot say what the source says.
    """
    source, target = Path(source), Path(target)
    options = {name: value for name, value in options.items() if value is not None}
    kind, name = _kind(source)
    own = _target(kind, source, target, to)
    for option in options:
        if option not in kind.options:
            raise FormatError(
                source, expected=f"options of {kind.name}: {', '.join(kind.options) or 'none'}", found=option,
                hint=f"{option} says nothing for {name}",
            )  # fmt: skip
    if _place(source, own).resolve() == _place(target, own).resolve():
        raise FormatError(target, expected="another file to write than the one to read", found=str(source))
    data, notes = kind.read(source, options)
    files, more = kind.targets[own](data, target, options)
    return Conversion(source=source, read_as=name, written_as=own, files=tuple(files), notes=(*notes, *more))


def _place(path: Path, to: str) -> Path:
    """Return a path without the suffix of a WAMIT set where one is written: its files belong together."""
    return wamit_stem(path) if to == "wamit" else path


def _kind(source: Path) -> tuple[_Kind, str]:
    """Return the family of a file and the name of its format; raise FormatError when it has no equivalents."""
    own = recognise(source)
    if is_hydro(source):
        return _HYDRO, own.name
    kind = _KINDS.get(own.name)
    if kind is None:
        raise FormatError(
            source, expected="coefficients, moorings, a time series, a metocean record or fowtio's results", found=own.name,
            hint="There is no equivalent format to convert it to",
        )  # fmt: skip
    return kind, own.name


def _target(kind: _Kind, source: Path, target: Path, to: str | None) -> str:
    """Return the name of the format to write."""
    known = ", ".join(kind.targets)
    if to is not None:
        if to not in kind.targets:
            raise FormatError(source, expected=f"a format that {kind.name} can become: {known}", found=to)
        return to
    suffix = target.suffix.lower()
    own = kind.suffixes.get(suffix) or (kind.suffixes.get("*") if kind.name == "moorings" else None)
    if own is None:
        ends = ", ".join(f"{s or 'a name without suffix'} ({t})" for s, t in kind.suffixes.items() if s != "*")
        raise FormatError(
            target, expected=f"a name that ends as a format that {kind.name} can become: {ends}", found=suffix or "no suffix",
            hint=f"Or say which with --to: {known}",
        )  # fmt: skip
    return _other_mooring(source) if own == "other" else own


# --- hydrodynamic coefficients ----------------------------------------------------------------------------------------


def _read_hydro(source: Path, options: dict) -> tuple[Any, list[str]]:
    given = {name: value for name, value in options.items() if name != "target_length"}
    hydro = read_hydro(source, **given)
    assumed = [n for n in hydro_options(source) if n in _WATER and n not in given]
    notes = [f"{n} taken as {getattr(hydro, n):g} {_WATER[n][1]}, which the file does not say" for n in assumed]
    if "length" in hydro_options(source) and "length" not in given:
        notes.append("length scale (ULEN) taken as 1 m, which the file does not say")
    return hydro, notes


def _to_wamit(hydro, target: Path, options: dict) -> tuple[list[Path], list[str]]:
    from fowtio.write.hydro import write_wamit

    stem = wamit_stem(target)
    lacking = {".3": hydro.excitation, ".hst": hydro.hydrostatic_stiffness}
    for suffix in (s for s, value in lacking.items() if value is None):
        old = stem.with_name(stem.name + suffix)
        if old.exists():
            raise FormatError(
                old, expected="no older file of the set", found="one, which the source has nothing for",
                hint="Remove it, or choose another name: old and new would be read together",
            )  # fmt: skip
    length = options.get("target_length", 1.0)
    notes = [
        f"non-dimensional by density {hydro.density:g} kg/m3, gravity {hydro.gravity:g} m/s2 and length (ULEN) {length:g} m"
    ]
    notes += [f"no {suffix}: the source has none of it" for suffix, value in lacking.items() if value is None]
    if hydro.volume is not None:
        notes.append(f"WAMIT files do not hold the displaced volume, {hydro.volume:.8g} m3 (HydroDyn's PtfmVol0)")
    return write_wamit(hydro, stem, length=length), notes


def _to_capytaine(hydro, target: Path, options: dict) -> tuple[list[Path], list[str]]:
    from fowtio.write.hydro import write_capytaine

    if "target_length" in options:
        raise FormatError(target, expected="no length scale for a Capytaine file", found="--target-length")
    return [write_capytaine(hydro, target)], []


# --- moorings ---------------------------------------------------------------------------------------------------------


def _read_mooring(source: Path, options: dict) -> tuple[Any, list[str]]:
    """Return the mooring system; a MAP++ file, and a MoorDyn file without WtrDpth, needs the depth."""
    from fowtio.read.map import map_mooring, read_map
    from fowtio.read.moordyn import moordyn_mooring, read_moordyn

    is_map = recognise(source).name == "MAP++ input file"
    water = {name: options.get(name, value) for name, (value, _) in _WATER.items() if name != "depth"}
    if not is_map:
        system = moordyn_mooring(read_moordyn(source), depth=options.get("depth"), **water)
        return system, ["drag, added mass and damping of the lines are left out: the static system is converted"]
    if "depth" not in options:
        raise FormatError(
            source, expected="the water depth, which MAP++ files do not hold", found="none", hint="Give --depth"
        )
    notes = [
        f"{n} taken as {water[n]:g} {_WATER[n][1]}, which the file does not say" for n in water if n not in options
    ]
    return map_mooring(read_map(source), depth=options["depth"], **water), notes


def _other_mooring(source: Path) -> str:
    return "moordyn" if recognise(source).name == "MAP++ input file" else "map"


def _to_map(system, target: Path, options: dict) -> tuple[list[Path], list[str]]:
    from fowtio.write.mooring import write_map

    water = f"depth {system.depth:g} m, density {system.density:g} kg/m3 and gravity {system.gravity:g} m/s2"
    return [write_map(system, target)], [f"MAP++ takes {water} from the deck that names it"]


def _to_moordyn(version: int) -> Callable:
    def write(system, target: Path, options: dict) -> tuple[list[Path], list[str]]:
        from fowtio.write.mooring import write_moordyn

        note = "drag, added mass and damping of the lines are a chain's usual ones: set them before a dynamic run"
        if version == 1 and np.any(system.seabed_friction):
            system = replace(system, seabed_friction=np.zeros_like(system.seabed_friction))
            return [write_moordyn(system, target, version=1)], [
                note,
                "MoorDyn 1 has no seabed friction: it is left out",
            ]
        return [write_moordyn(system, target, version=version)], [note]

    return write


# --- time series, metocean records, results ---------------------------------------------------------------------------


def _read(source: Path, options: dict) -> tuple[Any, list[str]]:
    return recognise(source).read(source), []


def _series_writer(name: str) -> Callable:
    def write(series, target: Path, options: dict) -> tuple[list[Path], list[str]]:
        import fowtio.write.series as writers

        notes = [f"{series.trailing_bytes} bytes behind the last sample are left out"] if series.trailing_bytes else []
        path = getattr(writers, name)(series, target)
        if name == "write_outb" and not path.read_bytes().startswith(b"\x03\x00"):
            notes.append("16-bit integers: each channel keeps 1/65535 of its range")
        return [path], notes

    return write


def _to_metocean_csv(record, target: Path, options: dict) -> tuple[list[Path], list[str]]:
    from fowtio.read.metocean import metocean_problems
    from fowtio.write.metocean import write_metocean

    return [write_metocean(record, target)], [*metocean_problems(record), *record.report.notes]


def _to_tables(data, target: Path, options: dict) -> tuple[list[Path], list[str]]:
    """Write every variable of results as a long table, one CSV file each."""
    if target.is_file():
        raise FormatError(target, expected="a folder to write tables into", found="a file")
    with atomic_folder(target) as folder:
        for name in data.data_vars:
            table = data[[name]].reset_coords(drop=True)
            table = table if data[name].ndim else table.expand_dims("value")
            table.to_dataframe().reset_index().to_csv(folder / f"{name}.csv", index=False)
        names = sorted(p.name for p in folder.iterdir())
    return [target / name for name in names], []


_HYDRO = _Kind(
    name="coefficients",
    options=("body", "length", "target_length", "density", "gravity", "depth", "frequency", "weight", "volume"),
    targets={"wamit": _to_wamit, "capytaine": _to_capytaine},
    suffixes={"": "wamit", ".1": "wamit", ".3": "wamit", ".hst": "wamit", ".nc": "capytaine"},
    read=_read_hydro,
)
_MOORING = _Kind(
    name="moorings", options=("depth", "gravity", "density"),
    targets={"map": _to_map, "moordyn": _to_moordyn(2), "moordyn1": _to_moordyn(1)},
    suffixes={"*": "other"}, read=_read_mooring,
)  # fmt: skip
_SERIES = _Kind(
    name="time series", options=(),
    targets={f: _series_writer(w) for f, w in (
        ("outb", "write_outb"), ("out", "write_out"), ("csv", "write_series_csv"), ("netcdf", "write_series_netcdf"))},
    suffixes={".outb": "outb", ".out": "out", ".csv": "csv", ".nc": "netcdf"}, read=_read,
)  # fmt: skip
_METOCEAN = _Kind(
    name="a metocean record", options=(), targets={"csv": _to_metocean_csv}, suffixes={".csv": "csv"}, read=_read
)
_RESULTS = _Kind(name="results", options=(), targets={"csv": _to_tables}, suffixes={"": "csv"}, read=_read)
_KINDS = {
    "MAP++ input file": _MOORING,
    "MoorDyn input file": _MOORING,
    "OpenFAST time series (.outb, .out)": _SERIES,
    "time series (.csv)": _SERIES,
    "time series (.nc)": _SERIES,
    "Metocean record (CSV, TSV, text, xlsx, netCDF)": _METOCEAN,
    "fowtio results (.nc)": _RESULTS,
}
