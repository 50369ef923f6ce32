"""fowtio's own results (results.nc): what a study gave, as labelled arrays."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from fowtio.errors import FormatError
from fowtio.read.registry import Format, span

if TYPE_CHECKING:
    import xarray as xr


def read_results(path: str | Path) -> xr.Dataset:
    """Return the results of a study as labelled arrays; raise FormatError."""
    import xarray as xr  # here, because it takes long

    path = Path(path)
    try:
        data = xr.load_dataset(path, engine="h5netcdf")
    except Exception as error:  # netCDF libraries raise many kinds for a damaged file
        raise FormatError(
            path, expected="a netCDF file", found=str(error).splitlines()[0] if str(error) else ""
        ) from None
    if not {"state", "channel", "frequency"} <= set(data.coords):
        raise FormatError(
            path,
            expected="results of fowtio with states, channels and frequencies",
            found=", ".join(map(str, data.coords)),
        )
    return data


def _recognises(path, head: bytes) -> bool:
    if not head.startswith(b"\x89HDF"):
        return False
    import h5py  # here, because only files of this kind need it

    try:
        with h5py.File(path) as file:
            source = file.attrs.get("source", b"")
            return (
                str(source.decode() if isinstance(source, bytes) else source).startswith("fowtio ")
                and "channel" in file
            )
    except (OSError, RuntimeError, UnicodeDecodeError):
        return False


def _describe(data: xr.Dataset) -> list[tuple[str, str]]:
    return [
        ("title", str(data.attrs.get("title", "none"))),
        ("written by", str(data.attrs.get("source", "not said"))),
        ("states", ", ".join(map(str, data["state"].values))),
        ("channels", f"{data.sizes['channel']}: {', '.join(map(str, data['channel'].values[:12]))}"),
        ("frequencies", f"{data.sizes['frequency']}, {span(data['frequency'].values, 'Hz')}"),
        ("variables", f"{len(data.data_vars)}: {', '.join(map(str, list(data.data_vars)[:12]))}, ..."),
        ("convention", "SI, radians, rad/s, Re{X e^{+i omega t}}, crest at the origin, one-sided spectra"),
    ]


RESULTS = Format(name="fowtio results (.nc)", recognises=_recognises, read=read_results, describe=_describe)
