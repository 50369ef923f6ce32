"""Results on disk: what is written equals what was computed, appears whole or not at all, and needs no network."""

from __future__ import annotations

import dataclasses
import hashlib
import html
import re
import shutil
import xml.etree.ElementTree as ElementTree

import numpy as np
import openpyxl
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

import fowtio
from fowtio.case import StateEntry
from fowtio.write import tables
from fowtio.write.atomic import atomic_file, atomic_folder
from fowtio.write.excel import write_excel
from fowtio.write.netcdf import complex_variable, dataset, write_netcdf
from fowtio.write.provenance import input_files, input_table, sha256
from fowtio.write.quantities import split_spectra
from fowtio.write.report import Section, report
from fowtio.write.resources import template_folder
from fowtio.write.results import write_results
from fowtio.write.style import COLOURS, Picture
from fowtio.write.table import ROW, Column, Table, joined, number
from model.environment.sea import SeaState
from model.system.hydro import infinite_added_mass


@pytest.fixture(scope="module")
def loads(oc4_loads):
    """A state with waves and turbulence, and one with oblique waves alone."""
    return [oc4_loads["operating"], oc4_loads["storm"]]


@pytest.fixture(scope="module")
def folder(oc4, loads, tmp_path_factory):
    """Everything written once."""
    path = tmp_path_factory.mktemp("results") / "oc4"
    written = write_results(oc4, loads, path)
    assert written
    assert all(p.is_file() for p in written)
    assert sorted(written) == sorted(p for p in path.rglob("*") if p.is_file())
    return path


@pytest.fixture(scope="module")
def page(folder):
    return (folder / "report.html").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def data(folder):
    with xr.open_dataset(folder / "results.nc", engine="h5netcdf") as data:
        return data.load()


@pytest.fixture(scope="module")
def book(folder):
    return openpyxl.load_workbook(folder / "results.xlsx")


def _half_a_file(path):
    with atomic_file(path) as temporary:
        temporary.write_text("half")
        raise KeyboardInterrupt


def _half_a_folder(path):
    with atomic_folder(path) as temporary:
        (temporary / "sub").mkdir()
        (temporary / "sub" / "a").write_text("half")
        raise RuntimeError


class TestAtomic:
    def test_file_appears_whole(self, tmp_path):
        with atomic_file(tmp_path / "new" / "a.txt") as temporary:
            temporary.write_text("all")
            assert not (tmp_path / "new" / "a.txt").exists()
        assert (tmp_path / "new" / "a.txt").read_text() == "all"
        assert [p.name for p in (tmp_path / "new").iterdir()] == ["a.txt"]

    def test_exception_keeps_the_old_file_and_leaves_nothing(self, tmp_path):
        (tmp_path / "a.txt").write_text("old")
        with pytest.raises(KeyboardInterrupt):
            _half_a_file(tmp_path / "a.txt")
        assert [p.name for p in tmp_path.iterdir()] == ["a.txt"]
        assert (tmp_path / "a.txt").read_text() == "old"

    def test_folder_exception_leaves_nothing(self, tmp_path):
        with pytest.raises(RuntimeError):
            _half_a_folder(tmp_path / "out")
        assert list(tmp_path.iterdir()) == []

    def test_folder_replaces_its_files_and_keeps_others(self, tmp_path):
        (tmp_path / "out" / "sub").mkdir(parents=True)
        (tmp_path / "out" / "mine").write_text("kept")
        (tmp_path / "out" / "sub" / "a").write_text("old")
        with atomic_folder(tmp_path / "out") as temporary:
            (temporary / "sub").mkdir()
            (temporary / "sub" / "a").write_text("new")
        assert (tmp_path / "out" / "mine").read_text() == "kept"
        assert (tmp_path / "out" / "sub" / "a").read_text() == "new"
        assert [p.name for p in tmp_path.iterdir()] == ["out"]

    @pytest.mark.parametrize("existing", [False, True])
    def test_results_fail_whole(self, oc4, loads, tmp_path, monkeypatch, existing):
        def broken(*_):
            raise OSError("no space left on device")

        monkeypatch.setattr("fowtio.write.report.write_report", broken)  # the last of all writers
        if existing:
            (tmp_path / "out").mkdir()
            (tmp_path / "out" / "results.nc").write_text("old")
        with pytest.raises(OSError, match="no space"):
            write_results(oc4, loads, tmp_path / "out", figures=False)
        left = [p for p in tmp_path.rglob("*") if p.is_file()]
        assert [p.read_text() for p in left] == (["old"] if existing else [])
        assert [p.name for p in tmp_path.iterdir()] == (["out"] if existing else [])

    def test_no_states_is_an_error(self, oc4, tmp_path):
        with pytest.raises(ValueError, match="no states"):
            write_results(oc4, [], tmp_path / "out")


class TestTable:
    @pytest.mark.parametrize(
        ("value", "unit", "text"),
        [
            (-0.0016, "m", "−0.002"),
            (-1e-9, "m", "0.000"),
            (12345.678, "kN", "12 345.7"),
            (None, "s", "–"),
            (float("nan"), "s", "–"),
            (13917.0, "", "13 917"),
            (0.012364, "", "0.01236"),
            (90.0, "", "90"),
            (0.0, "", "0"),
        ],
    )
    def test_number(self, value, unit, text):
        assert number(value, unit).replace("\N{NARROW NO-BREAK SPACE}", " ") == text

    @given(st.floats(-1e9, 1e9, allow_nan=False), st.sampled_from(["m", "deg", "kN", "MN m", "Hz", "s", "t", ""]))
    def test_number_reads_back(self, value, unit):
        text = number(value, unit).replace("\N{NARROW NO-BREAK SPACE}", "").replace("−", "-")
        places = len(text.partition(".")[2])
        # fixed decimals lose half a unit of the last place; four significant digits at most 5e-4 of the value
        assert abs(float(text) - value) <= 0.5001 * 10.0**-places + (0 if unit else 6e-4 * abs(value))

    def test_row_of_wrong_length(self):
        with pytest.raises(ValueError, match="2 cells for 1 columns"):
            Table(name="x", title="x", columns=(Column(name="a"),), rows=((1.0, 2.0),))

    def test_unit_of_the_row(self):
        columns = (Column(name="Unit"), Column(name="Value", unit=ROW))
        table = Table(name="x", title="x", columns=columns, rows=(("m", 1.0), ("kN", 1.0)))
        assert [row[1] for row in table.text()] == ["1.000", "1.0"]

    def test_joined_tables_leave_gaps(self):
        a, b = Column(name="a"), Column(name="b")
        one = Table(name="1", title="", columns=(a,), rows=((1.0,),))
        two = Table(name="2", title="", columns=(a, b), rows=((2.0, 3.0),))
        both = joined("x", "X", "key", [("one", one), ("two", two)])
        assert both.rows == (("one", 1.0, None), ("two", 2.0, 3.0))


class TestTables:
    def test_statistics_in_peoples_units(self, loads):
        item = loads[0]
        table, s, names = tables.state_statistics(item), item.statistics, item.channels.names
        rows = dict(zip(table.column("Channel"), table.rows, strict=True))
        for name, factor in (("PtfmSurge", 1.0), ("PtfmPitch", 180 / np.pi), ("TwrBsMyt", 1e-6), ("T[2]", 1e-3)):
            k = names.index(name)
            expected = [factor * v for v in (s.mean[k], s.std[k], s.mean[k] + s.extreme[k], s.mean[k] - s.extreme[k])]
            assert rows[name][3:7] == pytest.approx(expected, rel=1e-12)  # rounding of one product

    def test_waves_and_wind_make_the_whole(self, loads):
        table = tables.state_statistics(loads[0])
        whole, waves, wind = (np.array(table.column(n)) for n in ("Std", "Std, waves", "Std, wind"))
        # variances of uncorrelated parts add; both come from the same quadrature, so to rounding
        np.testing.assert_allclose(waves**2 + wind**2, whole**2, rtol=1e-9)
        for item in loads:
            np.testing.assert_allclose(sum(split_spectra(item)), item.spectra, rtol=1e-12)

    def test_contributions_add_up(self, oc4):
        for point in oc4.points:
            total = tables.contributions(point).rows[-1]
            system, q = point.system, [point.system.dofs.index(d) for d in ("surge", "heave", "pitch")]
            mass = np.diag(system.mass)[q] + np.diag(infinite_added_mass(oc4.hydro))[[0, 2, 4]]
            # one sum in another order: rounding
            np.testing.assert_allclose(total[1:4], mass * [1e-3, 1e-3, 1e-9], rtol=1e-12)
            stiffness = np.diag(point.mean.stiffness)[q] * [1e-3, 1e-3, 1e-6]
            np.testing.assert_allclose(total[4:7], stiffness, rtol=1e-9)
            # equilibrium: the last Newton step was below 1e-6 m; times the largest stiffness, in kN and MN m
            np.testing.assert_allclose(total[7:10], 0.0, atol=0.1)

    def test_at_rest_has_no_period(self, loads, oc4_loads):
        rows = {row[0]: row for row in tables.state_statistics(oc4_loads["white_noise"]).rows}
        assert rows["PtfmSway"][7:9] == (None, None)  # head seas on a symmetric floater
        assert rows["PtfmHeave"][7] > 0

    def test_natural_periods(self, oc4):
        table, modes = tables.natural_periods(oc4), oc4.points[0].modes
        periods = table.column("Period")[: len(modes.names)]
        np.testing.assert_allclose(np.array(periods) * modes.frequency, 2 * np.pi, rtol=1e-12)


class TestNetcdf:
    def test_responses_round_trip(self, data, loads):
        to_wave, to_wind = complex_variable(data, "channel_to_wave"), complex_variable(data, "dof_to_wind")
        for item in loads:
            name = item.state.name
            np.testing.assert_array_equal(to_wave.sel(state=name).values, item.channels.to_wave)
            np.testing.assert_array_equal(to_wind.sel(state=name).values, item.response.to_wind)
            np.testing.assert_array_equal(data.spectrum.sel(state=name).values, item.spectra)
            np.testing.assert_array_equal(data["std"].sel(state=name).values, item.statistics.std)
            assert data.wave_heading.sel(state=name).values == item.response.excitation.heading

    def test_model_round_trip(self, data, oc4):
        for k, point in enumerate(oc4.points):
            np.testing.assert_array_equal(data.mean_offset.values[k], point.mean.offset)
            np.testing.assert_array_equal(data.stiffness.values[k], point.mean.stiffness)
            mass = data.contribution_mass.values[k].sum(axis=0)
            mass[:6, :6] -= infinite_added_mass(oc4.hydro)
            # rounding of a sum of 1e10 kg m2
            np.testing.assert_allclose(mass, point.system.mass, rtol=0, atol=1e-4)
            found = data.natural_frequency.isel(operating_point=k).sel(mode=list(point.modes.names))
            np.testing.assert_array_equal(found.values, point.modes.frequency)
        np.testing.assert_array_equal(data.added_mass.values, oc4.hydro.added_mass)
        np.testing.assert_array_equal(complex_variable(data, "excitation").values, oc4.hydro.excitation)

    def test_spectrum_integrates_to_variance(self, data):
        variance = np.trapezoid(data.spectrum.values, data.omega.values, axis=1)
        # the same trapezoids as the statistics: rounding, and channels at rest
        np.testing.assert_allclose(variance, data["std"].values ** 2, rtol=1e-9, atol=1e-20)

    def test_frequency_in_both_units(self, data):
        np.testing.assert_allclose(2 * np.pi * data.frequency.values, data.omega.values, rtol=1e-14)

    def test_every_number_has_unit_and_name(self, data):
        bare = {"omega", "frequency"}
        for name, variable in data.variables.items():
            if variable.dtype.kind == "f":
                assert "long_name" in variable.attrs, name
                assert "units" in variable.attrs, name
        for name in data.data_vars:
            if name.endswith(("_real", "_imag")):
                assert data[name].attrs["convention"] == "Re{X e^(+i omega t)}"
        assert bare <= set(data.coords)
        assert data.attrs["study"] == "oc4.fowt"
        assert "title" in data.attrs
        assert data.attrs["source"] == f"fowtio {fowtio.__version__}"

    def test_short_crested_beside_long_crested(self, oc4, tmp_path):
        spread = SeaState(kind="jonswap", significant_height=2.0, peak_period=10.0, spreading=4.0)
        states = [
            StateEntry(name="spread", wind_speed=0.0, turbulence=None, sea=spread),
            StateEntry(name="one", wind_speed=0.0, turbulence=None, sea=dataclasses.replace(spread, spreading=None)),
        ]
        found = fowtio.loads(fowtio.solve(oc4, states))
        data = dataset(oc4, found)
        several = len(found[0].response.excitation.heading)
        assert several > 1
        assert data.sizes["heading"] == several
        assert np.isfinite(data.wave_heading.sel(state="one").values).sum() == 1
        np.testing.assert_array_equal(
            complex_variable(data, "dof_to_wave").sel(state="spread").values, found[0].response.to_wave
        )
        assert write_netcdf(tmp_path / "a.nc", oc4, found).is_file()


class TestWorkbook:
    def test_sheets(self, book):
        wanted = {"Summary", "Natural periods", "Mean offsets", "Statistics", "RAO operating", "Spectra operating"}
        wanted |= {"RAO storm", "Spectra storm", "Matrices", "Contributions", "Notes"}
        assert wanted <= set(book.sheetnames)

    def test_transfer_functions_round_trip(self, book, loads):
        for item in loads:
            rows = list(book[f"RAO {item.state.name}"].values)
            headings, values = rows[0], np.array(rows[1:], dtype=float)
            assert headings[0] == "Frequency [Hz]"
            np.testing.assert_array_equal(values[:, 0], item.response.excitation.omega / (2 * np.pi))
            for name, unit, factor in (("PtfmPitch", "deg/m", 180 / np.pi), ("TwrBsMyt", "MN m/m", 1e-6)):
                k = item.channels.index(name)
                column = headings.index(f"{name} [{unit}]")
                # numbers are written with all their digits; one product is rounded
                np.testing.assert_allclose(
                    values[:, column], np.abs(item.channels.to_wave[0, :, k]) * factor, rtol=1e-14
                )
                phase = values[:, column + 1]
                assert headings[column + 1] == f"{name} phase [deg]"
                np.testing.assert_allclose(
                    np.radians(phase), np.angle(item.channels.to_wave[0, :, k]), rtol=0, atol=1e-13
                )

    def test_spectra_per_hertz(self, book, loads):
        item = loads[0]
        rows = list(book["Spectra operating"].values)
        hertz, surge = (
            np.array([r[rows[0].index(n)] for r in rows[1:]]) for n in ("Frequency [Hz]", "PtfmSurge [m²/Hz]")
        )
        # the same trapezoids in another unit of frequency: rounding
        assert np.trapezoid(surge, hertz) == pytest.approx(item.statistics.std[0] ** 2, rel=1e-9)

    def test_tables_round_trip(self, book, loads):
        rows = list(book["Statistics"].values)
        column = rows[1].index("Std")
        found = {(r[0], r[1]): r[column] for r in rows[2:] if r[1]}
        for item in loads:
            k = item.channels.index("PtfmSurge")
            assert found[item.state.name, "PtfmSurge"] == pytest.approx(item.statistics.std[k], rel=1e-14)

    def test_headings_stay_in_view(self, book):
        assert book["RAO operating"].freeze_panes == "B2"
        assert book["Statistics"].freeze_panes == "B3"
        assert book["Statistics"]["A2"].value == "State"
        assert book["Statistics"]["E3"].number_format == "#,##0.000"
        assert book["RAO storm"]["B2"].number_format == "0.0000E+00"

    def test_names_that_excel_refuses(self, oc4, loads, tmp_path):
        names = ["wind/wave: [case] that goes on and on 1", "wind/wave: [case] that goes on and on 2"]
        renamed = [
            dataclasses.replace(i, state=dataclasses.replace(i.state, name=n))
            for i, n in zip(loads, names, strict=True)
        ]
        book = openpyxl.load_workbook(write_excel(tmp_path / "a.xlsx", oc4, renamed), read_only=True)
        found = [n for n in book.sheetnames if n.startswith("RAO")]
        assert len(set(found)) == 2
        assert all(len(n) <= 31 for n in found)


class TestFigures:
    def test_every_picture_shows_something(self, folder):
        found = sorted((folder / "figures").glob("*.png"))
        assert len(found) > 10
        for path in found:
            image = Image.open(path)
            assert round(image.info["dpi"][0]) == 150, path.name
            grey = np.asarray(image.convert("L"), dtype=float)
            dark = (grey < 200).mean()
            # lines and text cover some of the sheet, not most of it
            assert 0.003 < dark < 0.3, path.name
            colours = np.asarray(image.convert("RGB")).reshape(-1, 3)
            blue = np.array([int(COLOURS[0][i : i + 2], 16) for i in (1, 3, 5)])
            assert (np.abs(colours.astype(int) - blue).sum(axis=1) < 30).sum() > 100, path.name

    def test_svg_is_sound_and_beside_each_png(self, folder):
        names = {p.stem for p in (folder / "figures").glob("*.png")}
        assert names == {p.stem for p in (folder / "figures").glob("*.svg")}
        for path in (folder / "figures").glob("*.svg"):
            root = ElementTree.fromstring(path.read_text(encoding="utf-8"))
            texts = [e.text for e in root.iter("{http://www.w3.org/2000/svg}text")]
            assert any("[" in (t or "") for t in texts), f"{path.name} names no unit"

    def test_wanted_figures(self, folder):
        names = {p.stem for p in (folder / "figures").glob("*.png")}
        wanted = ["rao_motions_11_m_s_0deg", "rao_motions_parked_no_wind_30deg", "rao_wind_11_m_s", "hull", "moorings"]
        for part in [*wanted, "spectra_motions_storm", "spectra_loads_operating", "mooring_curve"]:
            assert part in names

    def test_no_global_state(self, folder):
        import matplotlib as mpl

        assert mpl.rcParams["svg.fonttype"] == mpl.rcParamsDefault["svg.fonttype"]


class TestReport:
    def test_needs_no_network(self, page):
        outside = set(re.findall(r"https?://[^\"'<>\s)]+", page))
        assert outside <= {"http://www.w3.org/2000/svg", "http://www.w3.org/1999/xlink"}  # names, not addresses
        assert not re.search(r"<(script|link|iframe|img)\b", page)
        assert "@import" not in page
        assert "url(#" in page or "url(" not in page

    def test_links_and_ids(self, page):
        ids = re.findall(r'\sid="([^"]+)"', page)
        assert len(ids) == len(set(ids))
        assert set(re.findall(r'href="#([^"]+)"', page)) <= set(ids)

    def test_holds_the_key_numbers(self, page, oc4, loads):
        assert html.escape(oc4.case.title) in page
        k = loads[0].channels.index("PtfmSurge")
        assert f"{loads[0].statistics.std[k]:.3f}" in page
        assert "fowtio run oc4.fowt" in page
        assert hashlib.sha256(oc4.case.path.read_bytes()).hexdigest() in page
        assert page.count("<svg") > 10

    def test_no_path_of_this_machine(self, page, oc4, folder):
        assert str(oc4.case.path.resolve().parent) not in page
        text = (folder / "results.nc").read_bytes()
        assert str(oc4.case.path.resolve().parent).encode() not in text

    def test_text_is_escaped(self, oc4, loads):
        named = dataclasses.replace(oc4, case=dataclasses.replace(oc4.case, title="<script>alert(1)</script> & Co"))
        item = dataclasses.replace(loads[1], state=dataclasses.replace(loads[1].state, name="<b>bold</b>"))
        text = report(named, [item])
        assert "<script" not in text
        assert "<b>bold" not in text
        assert "&lt;script&gt;alert(1)&lt;/script&gt; &amp; Co" in text

    def test_extra_section(self, oc4, loads):
        table = Table(name="check", title="Errors", columns=(Column(name="Channel"),), rows=(("PtfmSurge",),))
        picture = Picture(name="p", group="validation", title="RAOs", caption="beside", svg="<svg><g/></svg>")
        text = report(
            oc4,
            loads[1:],
            extra_sections=[Section(title="Validation", content=("<p>one <em>word</em></p>", table, picture))],
        )
        for part in ("Validation</h2>", "<p>one <em>word</em></p>", "Errors", "<svg><g/></svg>"):
            assert part in text

    def test_without_moorings_and_wind(self, oc4_folder, tmp_path):
        shutil.copytree(oc4_folder / "input", tmp_path / "input")
        deck = tmp_path / "input" / "oc4.fst"
        text = deck.read_text()
        free = re.sub(r"^(\s*)1(\s+CompMooring)", r"\g<1>0\2", text, flags=re.MULTILINE)
        assert free != text
        deck.write_text(free)
        model = fowtio.build(fowtio.load(deck))
        written = write_results(model, fowtio.loads(fowtio.solve(model)), tmp_path / "out", figures=False)
        page = next(p for p in written if p.suffix == ".html").read_text(encoding="utf-8")
        assert "drifts freely" in page
        assert "Mooring tensions" not in page


class TestProvenance:
    def test_sha256_of_a_published_message(self, tmp_path):
        (tmp_path / "a").write_bytes(b"abc")  # FIPS 180-2, appendix B.1
        assert sha256(tmp_path / "a") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"

    def test_every_input_once(self, oc4):
        files = input_files(oc4)
        assert len(files) == len(set(files))
        names = {p.name for p in files}
        assert {"oc4.fowt", "oc4.fst", "HydroDyn.dat", "ElastoDyn.dat", "MAP.dat", "oc4.1", "oc4.3", "oc4.hst"} <= names
        assert sum(p.suffix == ".lin" for p in files) == sum(len(e.files) for e in oc4.case.linearisations)
        assert "input/oc4.fst" in input_table(oc4).column("File")

    def test_templates(self):
        assert (template_folder("report") / "report.html.j2").is_file()
        with pytest.raises(FileNotFoundError, match="no templates"):
            template_folder("nothing")
