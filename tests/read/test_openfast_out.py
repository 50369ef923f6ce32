"""Time series of OpenFAST: binary forms 1 to 4 and text give back what was put in; damaged files are refused."""

import os
import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from openfast_samples import outb_bytes

from fowtio.errors import FormatError
from fowtio.read.openfast_out import read_openfast_out

NAMES, UNITS = ("PtfmSurge", "TwrBsMyt", "T[1]"), ("m", "kN-m", "N")
TIME = np.arange(200) * 0.05
DATA = np.stack([2 * np.sin(TIME), 3e4 * np.cos(3 * TIME) + 1e4, np.full(200, 7.5)], axis=1)


def read(tmp_path, content):
    path = tmp_path / "a.outb"
    path.write_bytes(content if isinstance(content, bytes) else content.encode("latin-1"))
    return read_openfast_out(path)


@pytest.mark.parametrize("form", [1, 2, 3, 4])
def test_binary_forms(tmp_path, form):
    series = read(tmp_path, outb_bytes(TIME, DATA, NAMES, UNITS, form))
    assert series.names == NAMES
    assert series.units == UNITS
    assert series.description == "made by the tests"
    assert series.trailing_bytes == 0
    # packed: half a step of 65535 over the channel's range, and single-precision slopes (2^-24 of the offset, which
    # is large
    # for a channel far from zero); plain doubles: exact
    tolerance = 0 if form == 3 else np.ptp(DATA, axis=0) / 65535 * 0.6 + 1e-6 * np.abs(DATA).max(axis=0)
    assert np.all(np.abs(series.data - DATA) <= tolerance)
    # packed time: 2^31 steps over the record; else first time plus steps
    np.testing.assert_allclose(series.time, TIME, atol=1e-8)
    assert series.unit("ptfmsurge") == "m"
    np.testing.assert_array_equal(series.channel("twrbsmyt"), series.data[:, 1])


def test_long_names(tmp_path):
    names = ("B1N001_FieldForceX", "x", "y")
    series = read(tmp_path, outb_bytes(TIME, DATA, names, UNITS, 4, width=20))
    assert series.names == names


@settings(deadline=None)
@given(st.integers(1, 4), st.lists(st.floats(-1e6, 1e6).map(lambda v: round(v, 3)), min_size=2, max_size=20))
def test_any_channel_within_its_quantisation(tmp_path_factory, form, values):
    data = np.array(values)[:, None]
    series = read(tmp_path_factory.mktemp("out"), outb_bytes(np.arange(len(values)) * 0.1, data, ("x",), ("m",), form))
    # half of a step of the range, plus single-precision slope and offset
    assert np.all(np.abs(series.data - data) <= np.ptp(data) / 65535 + 1e-6 * np.abs(data).max() + 1e-6)


@pytest.mark.parametrize("form", [1, 2, 3, 4])
def test_a_binary_file_cut_short_is_refused_anywhere(tmp_path, form):
    content = outb_bytes(TIME[:20], DATA[:20], NAMES, UNITS, form)
    for length in range(2, len(content), 7):
        with pytest.raises(FormatError):
            read(tmp_path, content[:length])


def test_bytes_behind_the_last_step_are_counted(tmp_path):
    assert read(tmp_path, outb_bytes(TIME, DATA, NAMES, UNITS, 2) + b"old run").trailing_bytes == 7


def test_damaged_binary_headers(tmp_path):
    good = bytearray(outb_bytes(TIME, DATA, NAMES, UNITS, 2))
    for at, kind, value, words in (
        (2, "<i", -1, "counts"),
        (6, "<i", 0, "counts"),
        (2, "<i", 2000, "values of"),
        (18, "<d", np.nan, "finite"),
        (26, "<f", 0.0, "slopes"),
        (26, "<f", np.nan, "slopes"),
        (18, "<d", -0.05, "ascends"),
        (50, "<i", -5, "values of"),
    ):
        bad = bytearray(good)
        struct.pack_into(kind, bad, at, value)
        with pytest.raises(FormatError, match=words):
            read(tmp_path, bytes(bad))


def test_nan_in_doubles_names_the_channel(tmp_path):
    data = DATA.copy()
    data[17, 1] = np.nan
    with pytest.raises(FormatError, match="TwrBsMyt"):
        read(tmp_path, outb_bytes(TIME, data, NAMES, UNITS, 3))


def text(delimiter="\t", units=True, title=True):
    rows = [
        f"{t:10.4f}{delimiter}" + delimiter.join(f"{v:15.7E}" for v in row) for t, row in zip(TIME, DATA, strict=True)
    ]
    head = ["", "Predictions were made by the tests", ""] if title else []
    head += [delimiter.join(("Time", *NAMES))] + ([delimiter.join(f"({u})" for u in ("s", *UNITS))] if units else [])
    return "\n".join([*head, *rows]) + "\n"


@pytest.mark.parametrize("delimiter", ["\t", "   "])
@pytest.mark.parametrize(("units", "title"), [(True, True), (True, False), (False, False)])
def test_text_of_openfast_and_its_modules(tmp_path, delimiter, units, title):
    series = read(tmp_path, text(delimiter, units, title))
    assert series.names == NAMES
    assert series.units == (UNITS if units else ("", "", ""))
    # eight digits of the data, four decimals of the time were written
    np.testing.assert_allclose(series.data, DATA, rtol=1e-7, atol=1e-12)
    np.testing.assert_allclose(series.time, TIME, atol=5e-5)


@pytest.mark.parametrize("dress", ["crlf", "merged", "d exponents", "latin-1"])
def test_text_in_other_dress(tmp_path, dress):
    plain = text("   ")
    body = plain.replace("   -", "-") if dress == "merged" else plain
    body = {
        "crlf": body.replace("\n", "\r\n"),
        "d exponents": body.replace("E+", "D+"),
        "latin-1": body.replace("tests", "Prüfung"),
    }.get(dress, body)
    np.testing.assert_array_equal(read(tmp_path, body).data, read(tmp_path, plain).data)


@pytest.mark.parametrize("bad", ["NaN", "*********", "1.5E", "1 2"])
def test_text_names_the_bad_line(tmp_path, bad):
    lines = text().split("\n")
    lines[30] = lines[30].rsplit("\t", 1)[0] + "\t" + bad
    with pytest.raises(FormatError) as error:
        read(tmp_path, "\n".join(lines))
    assert error.value.line == 31


def test_text_without_data_or_heading(tmp_path):
    for content in ("", "x y\n1 2\n", "\n".join(text().split("\n")[:5])):
        with pytest.raises(FormatError):
            read(tmp_path, content)


def test_time_must_ascend(tmp_path):
    lines = text().split("\n")
    lines[20], lines[21] = lines[21], lines[20]
    with pytest.raises(FormatError, match="ascends"):
        read(tmp_path, "\n".join(lines))


def test_unknown_channel(tmp_path):
    series = read(tmp_path, text())
    for ask in (series.channel, series.unit):
        with pytest.raises(FormatError, match="PtfmSurge"):
            ask("Nothing")


def test_two_channels_of_one_name(tmp_path):
    with pytest.raises(FormatError, match="twice"):
        read(tmp_path, text().replace("TwrBsMyt", "PtfmSurge"))


@pytest.mark.reference
@pytest.mark.skipif("FOWTIO_FORMATS" not in os.environ, reason="FOWTIO_FORMATS names no folder of sample files")
def test_real_files():
    folder = Path(os.environ["FOWTIO_FORMATS"]) / "openfast_out"
    series = read_openfast_out(folder / "fastout_allnodes.outb")
    assert series.data.shape == (101, 258)
    assert len(read_openfast_out(folder / "demo.outb").names) == 131
