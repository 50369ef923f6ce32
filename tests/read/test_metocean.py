"""Metocean records: columns, units, times, directions, and everything wrong with a record counted."""

import os
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from fowtio.errors import FormatError
from fowtio.read.metocean import read_metocean
from fowtio.read.metocean_columns import KNOT

N = 30
RNG = np.random.default_rng(5)
TIME = pd.date_range("2020-02-28 20:00", periods=N, freq="h")
SPEED, HEIGHT, PERIOD = (
    np.round(RNG.uniform(3, 25, N), 2),
    np.round(RNG.uniform(0.5, 8, N), 2),
    np.round(RNG.uniform(4, 15, N), 2),
)


def frame(**more):
    return pd.DataFrame(
        {"time": TIME.strftime("%Y-%m-%d %H:%M"), "wind speed (m/s)": SPEED, "Hs (m)": HEIGHT, "Tp (s)": PERIOD} | more
    )


def read(tmp_path, data, name="a.csv", sep=",", encoding="utf-8", **keywords):
    path = tmp_path / name
    text = data if isinstance(data, str) else data.to_csv(index=False, sep=sep)
    path.write_bytes(text.encode(encoding))
    return read_metocean(path, **keywords)


def check(record):
    np.testing.assert_allclose(record["wind_speed"], SPEED, rtol=1e-12)
    np.testing.assert_allclose(record["significant_height"], HEIGHT, rtol=1e-12)
    np.testing.assert_allclose(record["peak_period"], PERIOD, rtol=1e-12)
    assert record.time[0] == np.datetime64("2020-02-28T20:00")
    assert np.all(np.diff(record.time) == np.timedelta64(1, "h"))


@pytest.mark.parametrize("sep", [",", ";", "\t", " , "])
def test_separators(tmp_path, sep):
    record = read(tmp_path, frame().to_csv(index=False).replace(",", sep))
    check(record)
    assert record.report.clean
    assert record.report.step == 3600
    assert record.complete("wind_speed", "peak_period").shape == (N, 2)


def test_decimal_commas(tmp_path):
    check(read(tmp_path, frame().to_csv(index=False, sep=";", decimal=",")))


def test_windows_and_latin_1(tmp_path):
    text = "# Küste\n" + frame().to_csv(index=False)
    check(read(tmp_path, text.replace("\n", "\r\n"), encoding="latin-1"))


def test_xlsx(tmp_path):
    frame().assign(time=TIME).to_excel(tmp_path / "a.xlsx", index=False)
    check(read_metocean(tmp_path / "a.xlsx"))


def test_netcdf(tmp_path):
    data = (
        frame()
        .assign(time=TIME)
        .set_index("time")
        .rename(columns={"wind speed (m/s)": "ws", "Hs (m)": "swh", "Tp (s)": "pp1d"})
        .to_xarray()
    )
    data["ws"] = data["ws"] / KNOT
    data["ws"].attrs["units"] = "knots"
    data.expand_dims(latitude=[58.0]).to_netcdf(tmp_path / "a.nc", engine="h5netcdf")
    record = read_metocean(tmp_path / "a.nc")
    np.testing.assert_allclose(record["wind_speed"], SPEED, rtol=1e-12)
    np.testing.assert_allclose(record["peak_period"], PERIOD, rtol=1e-12)
    data.expand_dims(latitude=[58.0, 59.0]).to_netcdf(tmp_path / "b.nc", engine="h5netcdf")
    with pytest.raises(FormatError, match="one place"):
        read_metocean(tmp_path / "b.nc")


@pytest.mark.parametrize(
    ("headings", "units"),
    [
        (("time", "U10", "Hm0", "Tp"), ""),
        (("Timestamp", "WSPD", "WVHT", "DPD"), ""),
        (("date_time", "wind_speed_100m", "significant_wave_height", "peak_wave_period"), ""),
        (
            (
                "time(YYYY-MM-DD HH:MM)",
                "1-hour mean wind speed at 90m(m/s)",
                "Significant wave height(m)",
                "Peak period(s)",
            ),
            "",
        ),
    ],
)
def test_headings_in_use(tmp_path, headings, units):
    data = frame()
    data.columns = headings
    check(read(tmp_path, data))


@pytest.mark.parametrize(
    ("heading", "factor"),
    [
        ("wind speed (kn)", 1852 / 3600),
        ("wind speed [knots]", 1852 / 3600),
        ("wind speed (km/h)", 1 / 3.6),
        ("ws (mph)", 0.44704),
        ("ws (m s-1)", 1.0),
    ],
)
def test_units(tmp_path, heading, factor):
    data = frame().rename(columns={"wind speed (m/s)": heading})
    np.testing.assert_allclose(read(tmp_path, data)["wind_speed"], SPEED * factor, rtol=1e-12)


def test_unknown_unit_and_given_unit(tmp_path):
    data = frame().rename(columns={"Hs (m)": "Hs (fathoms)"})
    with pytest.raises(FormatError, match="fathoms"):
        read(tmp_path, data)
    record = read(tmp_path, data, units={"significant_height": "ft"})
    np.testing.assert_allclose(record["significant_height"], HEIGHT * 0.3048, rtol=1e-12)


@pytest.mark.parametrize(
    ("form", "zone", "shift"),
    [
        ("%Y-%m-%d-%H", "UTC", 0),
        ("%Y-%m-%dT%H:%M:%SZ", "Europe/Oslo", 0),
        ("%Y-%m-%dT%H:%M:%S+02:00", "UTC", -2),
        ("%Y-%m-%d %H:%M", "Europe/Oslo", -1),
        ("%Y%m%d%H", "UTC", 0),
        ("%Y%m%d%H%M", "UTC", 0),
        ("%d/%m/%Y %H:%M", "UTC", 0),
        ("%d.%m.%Y %H:%M", "UTC", 0),
        ("%m/%d/%Y %H:%M", "UTC", 0),
    ],
)
def test_times_and_zones(tmp_path, form, zone, shift):
    record = read(tmp_path, frame(time=TIME.strftime(form)), time_zone=zone)
    np.testing.assert_array_equal(record.time, (TIME + pd.Timedelta(hours=shift)).to_numpy())


def test_day_and_month_that_can_be_read_both_ways(tmp_path):
    times = pd.date_range("2020-03-04", periods=N, freq="h").strftime("%d/%m/%Y %H:%M")
    with pytest.raises(FormatError, match="day_first"):
        read(tmp_path, frame(time=times))
    assert read(tmp_path, frame(time=times), day_first=True).time[0] == np.datetime64("2020-03-04")
    assert read(tmp_path, frame(time=times), day_first=False).time[0] == np.datetime64("2020-04-03")


def test_the_hour_that_summer_time_repeats_is_not_guessed(tmp_path):
    times = ["2020-10-25 01:00", "2020-10-25 02:00", "2020-10-25 02:00", "2020-10-25 03:00"]
    data = frame().head(4).assign(time=times)
    record = read(tmp_path, data, time_zone="Europe/Oslo")
    assert record.report.bad_times == 2
    assert len(record.time) == 2


def test_buoy_files_of_columns_for_year_to_minute(tmp_path):
    head = "#YY  MM DD hh mm WDIR WSPD GST  WVHT   DPD   APD MWD   PRES\n#yr  mo dy hr mn degT m/s  m/s     m   sec   sec degT   hPa\n"
    rows = "2020 01 02 03 50 180  7.2  9.0   2.50 10.00  6.50 270 1013.0\n2020 01 02 04 50 999 99.0 99.0  99.00 99.00 99.00 999 9999.0\n2020 01 02 05 50 MM   MM   MM    MM    MM    MM   MM     MM\n"
    record = read(tmp_path, head + rows, name="buoy.txt", x_bearing=90.0)
    assert record.time[0] == np.datetime64("2020-01-02T03:50")
    assert record["significant_height"][0] == 2.5
    assert record["peak_period"][0] == 10
    assert record["zero_crossing_period"][0] == 6.5
    assert np.isnan(record["significant_height"][1:]).all()
    assert record.report.sentinel == dict.fromkeys(record.values, 1)
    assert record.report.missing == dict.fromkeys(record.values, 1)
    # wind from the south (180) blows north: +y with x to the east; waves from the west (270) run east: +x
    assert np.degrees(record["wind_heading"][0]) == pytest.approx(90)
    assert np.degrees(record["wave_heading"][0]) % 360 == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize(
    ("heading", "keywords", "expected", "noted"),
    [
        # compass bearing 30: from there, running to 210 degrees; to there, 30. Heading = bearing of x (90) minus
        # bearing
        ("wave direction (deg)", {}, 240.0, True),
        ("wave from direction (deg)", {}, 240.0, False),
        ("wave direction, coming from (deg)", {}, 240.0, False),
        ("wave to direction (deg)", {}, 60.0, False),
        ("wave direction (deg)", {"direction": "to"}, 60.0, False),
        ("wave direction (deg)", {"direction": "from", "x_bearing": 0.0}, 150.0, False),
        ("wave direction (rad)", {"direction": "to"}, 60.0, False),
    ],
)
def test_directions_become_headings_of_propagation(tmp_path, heading, keywords, expected, noted):
    value = np.radians(30.0) if "rad" in heading else 30.0
    record = read(tmp_path, frame(**{heading: np.full(N, value)}), sep=";", **keywords)
    np.testing.assert_allclose(np.degrees(record["wave_heading"]), expected, rtol=1e-9)
    assert bool(record.report.notes) == noted


def test_everything_wrong_is_counted_and_nothing_of_it_used(tmp_path):
    data = frame().astype(object)
    data.iloc[2, 1] = -999  # sentinel
    data.iloc[3, 1] = 140.0  # no wind blows so
    data.iloc[4, 2] = ""  # missing
    data.iloc[5, 2] = "1.2.3"  # unreadable
    data.iloc[6, 3] = -9999.0  # sentinel
    data.iloc[7, 0] = "yesterday"  # bad time
    again = data.iloc[[10]].copy()  # the same row twice
    clash = data.iloc[[12]].copy()  # the same time, another wave height
    clash.iloc[0, 2] = float(HEIGHT[12]) + 1
    data = pd.concat([data.iloc[:20], again, clash, data.iloc[22:]])  # and two hours are not there
    record = read(tmp_path, data)
    report = record.report
    assert report.rows == N
    assert dict(report.sentinel) == {"wind_speed": 1, "significant_height": 0, "peak_period": 1}
    assert report.out_of_range["wind_speed"] == 1
    assert (report.missing["significant_height"], report.unreadable["significant_height"]) == (1, 1)
    assert (report.bad_times, report.duplicates, report.conflicting, report.unsorted) == (1, 1, 1, 1)
    assert (report.gaps, report.missing_steps) == (2, 3)  # the bad time, and two hours
    assert not report.clean
    assert len(record.time) == N - 3
    hour = (record.time - TIME[0].to_numpy()) / np.timedelta64(1, "h")
    assert np.isnan(record["wind_speed"][np.isin(hour, [2, 3])]).all()
    assert np.isnan(record["significant_height"][np.isin(hour, [4, 5, 12])]).all()
    assert record["wind_speed"][hour == 12] == SPEED[12]
    good = ~np.isin(hour, [2, 3, 4, 5, 6, 12])
    np.testing.assert_array_equal(record["significant_height"][good], HEIGHT[hour[good].astype(int)])
    assert len(record.complete()) == good.sum()


def test_a_believable_sentinel_is_kept(tmp_path):
    record = read(tmp_path, frame(**{"wave direction (deg)": np.full(N, 99.0)}), direction="to")
    assert record.report.sentinel["wave_heading"] == 0
    np.testing.assert_allclose(np.degrees(record["wave_heading"]), 351.0)  # 90 - 99


def test_unsorted_rows_are_sorted_and_counted(tmp_path):
    record = read(tmp_path, frame().iloc[::-1])
    check(record)
    assert record.report.unsorted == N - 1


def test_two_columns_for_one_quantity(tmp_path):
    data = frame(**{"wind_speed_100m": SPEED + 1})
    with pytest.raises(FormatError, match="wind_speed_100m"):
        read(tmp_path, data)
    record = read(tmp_path, data, columns={"wind_speed": "wind_speed_100m"})
    np.testing.assert_allclose(record["wind_speed"], SPEED + 1)


@pytest.mark.parametrize(
    ("columns", "words"),
    [({"wind_speed": "no such"}, "no such"), ({"temperature": "Hs (m)"}, "temperature"), ({"time": "clock"}, "clock")],
)
def test_columns_that_are_not_there(tmp_path, columns, words):
    with pytest.raises(FormatError, match=words):
        read(tmp_path, frame(), columns=columns)


@pytest.mark.parametrize(
    "content",
    [
        "",
        "a,b\n1,2\n",
        "time,Hs\n",
        "time,Hs\n2020-01-01,1,2\n",
        "x,Hs\n2020-01-01,1\n",
        "time,Hs\n12.5,1\n",
        "time,Hs\nnever,1\n",
        "time,Hs,Hs\n2020-01-01,1,2\n",
    ],
)
def test_what_is_no_record(tmp_path, content):
    with pytest.raises(FormatError):
        read(tmp_path, content)


def test_damaged_binary_files(tmp_path):
    for name, start in (("a.xlsx", b"PK\x03\x04"), ("a.nc", b"\x89HDF\r\n\x1a\n")):
        (tmp_path / name).write_bytes(start + b"rubbish" * 50)
        with pytest.raises(FormatError):
            read_metocean(tmp_path / name)


def test_asking_for_a_quantity_that_is_not_there(tmp_path):
    with pytest.raises(FormatError, match="wind_speed"):
        read(tmp_path, frame())["wave_heading"]


def test_unknown_time_zone(tmp_path):
    with pytest.raises(FormatError, match="time zone"):
        read(tmp_path, frame(), time_zone="Middle/Earth")


@pytest.mark.reference
@pytest.mark.skipif("FOWTIO_METOCEAN" not in os.environ, reason="FOWTIO_METOCEAN names no folder of sample files")
def test_real_files():
    folder = Path(os.environ["FOWTIO_METOCEAN"])
    a = read_metocean(folder / "ec-benchmark_dataset_A_1year.txt")
    assert len(a.time) + a.report.missing_steps == 366 * 24  # every hour of 1996 is there or counted as missing
    assert read_metocean(folder / "coastDat2_oneyear.csv").report.clean
