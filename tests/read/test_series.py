"""Time series and metocean records written and read again: OpenFAST's binary and text form, CSV, netCDF."""

import struct
from dataclasses import replace

import numpy as np
import pytest
from hydro_samples import flips, put, truncations, variants

from fowtio.errors import FormatError, FowtioError, ModelError
from fowtio.read import read_any, recognise
from fowtio.read.metocean import read_metocean
from fowtio.read.openfast_out import TimeSeries, read_openfast_out, series_problems
from fowtio.read.series_table import read_series_csv, read_series_netcdf
from fowtio.write.metocean import write_metocean
from fowtio.write.series import outb_bytes, write_out, write_outb, write_series_csv, write_series_netcdf

RNG = np.random.default_rng(3)
NAMES, UNITS = ("PtfmSurge", "GenPwr", "T[1]", "still", "none"), ("m", "kW", "N", "m", "")


def series(time=None, names=NAMES) -> TimeSeries:
    """Return channels of very different sizes, one constant and one zero."""
    time = np.arange(200) * 0.05 + 10.0 if time is None else time
    data = RNG.normal(size=(len(time), 5)) * [1.0, 5e3, 1e5, 0.0, 0.0] + [3.0, 5e3, 9e5, 1e6 + 0.123, 0.0]
    return TimeSeries(time=time, data=data, names=names, units=UNITS, description="made by a test")


def same(got: TimeSeries, want: TimeSeries, tolerance, time=1e-9) -> None:
    """tolerance [relative to the range of a channel, to its value where it is constant]"""
    assert got.names == want.names
    assert got.units == want.units
    assert np.abs(got.time - want.time).max() <= time
    size = np.where(np.ptp(want.data, axis=0) > 0, np.ptp(want.data, axis=0), np.abs(want.data).max(axis=0) + 1e-300)
    assert (np.abs(got.data - want.data) / size).max() <= tolerance


def form(content: bytes) -> int:
    return struct.unpack("<h", content[:2])[0]


# 16 bits: half of 1/65535 of the range, and single precision (2^-24) of slope and of an offset some ranges away
PACKED = 0.5 / 65535 * 1.02 + 2.0**-22


@pytest.mark.parametrize(
    ("kind", "names", "time"),
    [
        (2, NAMES, None),
        (4, ("a name longer than ten characters", *NAMES[1:]), None),
        (1, NAMES, np.cumsum(np.linspace(0.01, 0.1, 150))),
    ],
)
def test_outb_to_and_fro(tmp_path, kind, names, time):
    want = series(time, names)
    assert form(outb_bytes(want)) == kind
    got = read_openfast_out(write_outb(want, tmp_path / "a.outb"))
    same(got, want, PACKED, time=1e-8)  # packed times: a duration of 8 s over 2^32
    assert got.description == want.description
    assert got.trailing_bytes == 0


def test_a_small_range_beside_a_large_mean_is_kept_in_doubles(tmp_path):
    """Single precision of the offset would lose it: 1e6 + 1e-3 sin."""
    want = series()
    data = want.data.copy()
    data[:, 0] = 1e6 + 1e-3 * np.sin(want.time)
    want = replace(want, data=data)
    assert form(outb_bytes(want)) == 3
    same(read_openfast_out(write_outb(want, tmp_path / "a.outb")), want, 0.0)
    with pytest.raises(ModelError, match=r"write \.csv"):
        outb_bytes(replace(want, names=("a name longer than ten characters", *NAMES[1:])))
    assert [p.name for p in tmp_path.iterdir()] == ["a.outb"]


def test_out_csv_and_netcdf_to_and_fro(tmp_path):
    want = series()
    text = read_openfast_out(write_out(want, tmp_path / "a.out"))
    # nine digits of a value that may be 10 times the range of its channel
    same(replace(text, units=want.units), want, 1e-8)
    assert text.description == want.description
    csv = read_series_csv(write_series_csv(want, tmp_path / "a.csv"))
    same(csv, want, 0.0, time=0.0)
    netcdf = read_series_netcdf(write_series_netcdf(want, tmp_path / "a.nc"))
    same(netcdf, want, 0.0, time=0.0)
    assert netcdf.description == want.description
    for path in tmp_path.iterdir():
        assert isinstance(read_any(path), TimeSeries), path
    assert series_problems(csv) == ["1 channel without a unit: none"]


def test_a_title_that_begins_with_time_is_no_heading(tmp_path):
    want = replace(series(), description="Time series of a test")
    same(read_openfast_out(write_out(want, tmp_path / "a.out")), want, 1e-8)


def test_names_that_a_format_cannot_hold(tmp_path):
    with pytest.raises(ModelError, match="without '/'"):
        write_series_netcdf(series(names=("a/b", *NAMES[1:])), tmp_path / "a.nc")
    with pytest.raises(ModelError, match="tab"):
        write_out(series(names=("a\tb", *NAMES[1:])), tmp_path / "a.out")
    assert list(tmp_path.iterdir()) == []


def test_csv_in_other_dress_and_damaged(tmp_path):
    """Every cut (12) and 400 flips give an error, or the table with single numbers changed that no redundancy shows."""
    want = series(np.arange(12) * 0.1)
    path = write_series_csv(want, tmp_path / "a.csv")
    text = path.read_text()
    for _, content in variants(text):
        same(read_series_csv(put(path, content)), want, 0.0)
        assert recognise(path).name == "time series (.csv)"
    for count, cut in truncations(text):
        if count == 1:
            with pytest.raises(FormatError, match="rows below"):
                read_series_csv(put(path, cut))
        else:
            assert len(read_series_csv(put(path, cut)).time) == count - 1
    bad = 0
    for _, changed in flips(text, 400):
        try:
            got = read_series_csv(put(path, changed))
        except FowtioError:
            bad += 1
            continue
        assert np.isfinite(got.data).all()
        assert np.count_nonzero(got.data != want.data) + np.count_nonzero(got.time != want.time) <= 1
    assert bad > 100  # letters, blanks, stars, commas: about half of the alphabet


def test_damaged_netcdf(tmp_path):
    path = write_series_netcdf(series(np.arange(12) * 0.1), tmp_path / "a.nc")
    content = path.read_bytes()
    for size in np.linspace(10, len(content) - 10, 12).astype(int):
        with pytest.raises(FormatError):
            read_series_netcdf(put(path, content[:size]))


METOCEAN = """time,wind speed (knots),Hs (m),Tp (s),wave direction from (deg),sigma (m/s)
2020-01-01 02:00,20,1.5,9,90,1.1
2020-01-01 00:00,10,-999,8,350,1.2
2020-01-01 01:00,NA,1.2,8.5,10,1.3
2020-01-01 01:00,NA,1.2,8.5,10,1.3
2020-01-01 05:00,12,1.4,9.5,0,1.4
"""


def test_metocean_record_to_and_fro(tmp_path):
    first = read_metocean(put(tmp_path / "a.csv", METOCEAN))
    second = read_metocean(write_metocean(first, tmp_path / "b.csv"))
    np.testing.assert_array_equal(second.time, first.time)
    assert list(second.values) == list(first.values)
    for name, values in first.values.items():
        turned = name.endswith("heading")  # through degrees and back: rounding of 2 pi
        np.testing.assert_allclose(second[name], values, rtol=0, atol=1e-14 if turned else 0.0)
    assert second.report.duplicates == second.report.unsorted == 0
    assert first.report.duplicates == 1
    assert (tmp_path / "b.csv").read_text().splitlines()[1] == "2020-01-01T00:00:00Z,5.144444444444445,1.2,,8.0,350.0"
