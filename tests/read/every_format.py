"""One small file of every format, written by us and true to the format: for the registry and the command line."""

from pathlib import Path

import numpy as np
import openfast_samples as samples
from hydro_samples import put, synthetic
from hydro_writers import ah1_text, lis_text, orcaflex_text, write_nemoh
from test_fast7 import SAMPLE as FAST7_TEXT
from test_map import SAMPLE as MAP_TEXT
from test_moordyn import V1, V2
from test_rotor_table import text as rotor_text
from test_turbine_table import text as turbine_text
from test_wamit_extra import out_text

from fowtio.read.openfast_out import TimeSeries
from fowtio.write.hydro import write_capytaine
from fowtio.write.series import write_series_netcdf

OUT_TEXT = "Time\tPtfmSurge\n(s)\t(m)\n0.0\t1.5\n0.1\t1.6\n"
CSV = "time,Hs (m),wind speed (m/s)\n2020-01-01 00:00,1.5,8\n2020-01-01 01:00,1.6,9\n"
SERIES_CSV = "Time (s),PtfmSurge (m),T[1] (N)\n0.0,1.5,1e6\n0.1,1.6,1.1e6\n"
_POLAR = " 1.000000E+00 0.000000E+00 1.000000E+00 0.000000E+00\n"


def every_format(folder: Path) -> dict[str, Path]:
    """Write one file of every format and return its path by the name of its constant (and a word where there are more)."""
    return _openfast(folder) | _texts(folder) | _binaries(folder) | _hydro(folder / "hydro")


def _openfast(folder: Path) -> dict[str, Path]:
    fst = samples.copy_deck(folder / "deck")
    files = {
        "ELASTODYN": "ElastoDyn.dat",
        "HYDRODYN": "HydroDyn.dat",
        "SEASTATE": "SeaState.dat",
        "INFLOWWIND": "InflowWind.dat",
        "OPENFAST_INPUT": "ElastoDyn_Tower.dat",
        "WAMIT_RADIATION": "hydro/oc4.1",
        "WAMIT_EXCITATION": "hydro/oc4.3",
        "WAMIT_HYDROSTATICS": "hydro/oc4.hst",
        "WAMIT_SET": "hydro/oc4",
    }
    return {name: fst.parent / file for name, file in files.items()} | {
        "OPENFAST_DECK": fst,
        "OPENFAST_LIN": samples.LIN_FILE,
    }


def _texts(folder: Path) -> dict[str, Path]:
    text = {
        "FAST7_LIN": FAST7_TEXT,
        "MAP": MAP_TEXT,
        "MOORDYN": V2,
        "MOORDYN 1": V1,
        "ROTOR_TABLE": rotor_text(),
        "TURBINE_TABLE": turbine_text(),
        "OPENFAST_OUT": OUT_TEXT,
        "METOCEAN": CSV,
        "SERIES_CSV": SERIES_CSV,
    }
    return {name: put(folder / f"{name.lower().replace(' ', '_')}.dat", content) for name, content in text.items()}


def _binaries(folder: Path) -> dict[str, Path]:
    wind = np.random.default_rng(1).normal(12, 1, (4, 9, 7, 3))
    outb = samples.outb_bytes([0, 0.1], [[1.0], [2.0]], ("x",), ("m",), 2)
    series = TimeSeries(time=np.array([0.0, 0.1]), data=np.array([[1.0], [2.0]]), names=("x",), units=("m",))
    return {
        "TURBSIM": put(folder / "turbsim.bin", samples.bts_bytes(wind)),
        "OPENFAST_OUT 2": put(folder / "out_2.bin", outb),
        "SERIES_NETCDF": write_series_netcdf(series, folder / "series.nc"),
        "RESULTS": _results(folder / "results.nc"),
    }


def _results(path: Path) -> Path:
    """Write what tells fowtio's results: states, channels, frequencies, and the program's name."""
    import xarray as xr

    size = {"state": ["calm"], "channel": ["PtfmSurge", "PtfmPitch"], "frequency": [0.1, 0.2, 0.3]}
    data = {"channel_spectrum": (tuple(size), np.ones((1, 2, 3)))}
    xr.Dataset(data, coords=size, attrs={"source": "fowtio 0", "title": "trial"}).to_netcdf(path, engine="h5netcdf")
    return path


def _hydro(folder: Path) -> dict[str, Path]:
    folder.mkdir()
    body = synthetic(gravity=9.81)
    rows = {
        "WAMIT_MOTION": (".4", " {t} 0.0 3"),
        "WAMIT_DRIFT": (".8", " {t} 0.0 0.0 1"),
        "WAMIT_SECOND_ORDER": (".12d", " {t} {t} 0.0 0.0 1"),
    }
    out = {
        name: put(folder / f"extra{suffix}", "".join(row.format(t=t) + _POLAR for t in (5.0, 9.0)))
        for name, (suffix, row) in rows.items()
    }
    nemoh = folder / "nemoh"
    nemoh.mkdir()
    return out | {
        "WAMIT_OUTPUT": put(folder / "body.out", out_text(body)),
        "AQWA_AH1": put(folder / "body.AH1", ah1_text(body)),
        "AQWA_LIS": put(folder / "body.LIS", lis_text(body)),
        "NEMOH": write_nemoh(nemoh, body),
        "ORCAFLEX": put(folder / "body.yml", orcaflex_text(body, mass=1e7, centre=(0.0, 0.0, -8.0)).encode()),
        "CAPYTAINE": write_capytaine(body, folder / "body.nc"),
    }
