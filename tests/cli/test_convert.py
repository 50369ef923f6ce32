"""fowtio convert: equivalents go to and fro, the impossible is refused with a reason, nothing is half written."""

import json
import shutil
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "read"))
import openfast_samples as samples
from every_format import every_format
from hydro_samples import assert_equal, put, synthetic
from hydro_writers import ah1_text, write_nemoh

import fowtio
from fowtio.errors import FormatError
from fowtio.read.hydro_any import read_hydro
from fowtio.read.map import map_mooring, read_map
from fowtio.read.moordyn import moordyn_mooring, read_moordyn
from fowtio.read.openfast_deck import deck_hydro, read_deck
from fowtio.read.openfast_out import read_openfast_out
from fowtio.write.hydro import write_capytaine
from fowtio.write.netcdf import write_netcdf

WATER = {"density": 1025.0, "gravity": 9.80665, "depth": 200.0}
OPTIONS = ("--density", 1025, "--gravity", 9.80665, "--depth", 200)


@pytest.fixture(scope="module")
def sample_files(tmp_path_factory):
    return every_format(tmp_path_factory.mktemp("formats"))


@pytest.fixture
def converted(cli):
    """Return a conversion that must succeed; its result is the JSON document."""

    def run(*arguments):
        found = cli("convert", *arguments, "--json")
        assert found.code == 0, found.err
        document = json.loads(found.out)
        assert all(Path(f).is_file() for f in document["files"])
        return document

    return run


@pytest.fixture
def refused(cli, tmp_path):
    """Return a conversion that must be refused without writing anything; its result is the message."""

    def run(*arguments):
        before = sorted(tmp_path.rglob("*"))
        found = cli("convert", *arguments)
        assert found.code == 1, found.out
        assert found.out == ""
        assert found.err.startswith("error: ")
        assert "internal error" not in found.err
        assert sorted(tmp_path.rglob("*")) == before
        return found.err

    return run


# --- hydrodynamic coefficients ----------------------------------------------------------------------------------------


def test_wamit_to_capytaine_and_back(converted, oc4_folder, tmp_path):
    source = oc4_folder / "input" / "hydro" / "oc4"
    first = read_hydro(source, **WATER)
    found = converted(source, tmp_path / "a.nc", *OPTIONS)
    assert found["written_as"] == "capytaine"
    assert "ULEN" in found["notes"][0]
    assert_equal(read_hydro(tmp_path / "a.nc"), first, 0.0)  # double precision throughout
    found = converted(tmp_path / "a.nc", tmp_path / "b", "--target-length", 10)
    assert [Path(f).suffix for f in found["files"]] == [".1", ".3", ".hst"]
    # seven digits of what had seven digits in other units
    assert_equal(read_hydro(tmp_path / "b", length=10.0, **WATER), first, 1e-6)


@pytest.mark.parametrize("target", ["b.nc", "b.1"])
def test_other_tools_files_become_ours(converted, tmp_path, target):
    want = synthetic(gravity=9.81)
    ah1 = put(tmp_path / "body.AH1", ah1_text(want))
    (tmp_path / "nemoh").mkdir()
    nemoh = write_nemoh(tmp_path / "nemoh", want)
    options = {} if target == "b.nc" else {"density": want.density, "gravity": want.gravity, "depth": want.depth}
    for source, tolerance in ((ah1, 2e-4), (nemoh, 1e-6)):  # digits of these formats: see test_hydro_equal
        converted(source, tmp_path / target)
        got = read_hydro(tmp_path / target.removesuffix(".1"), **options)
        lacking = {"added_mass_zero", "added_mass_infinite"} if source is nemoh else set()
        fields = (
            "omega",
            "added_mass",
            "radiation_damping",
            "excitation",
            "hydrostatic_stiffness",
            "added_mass_infinite",
        )
        assert_equal(got, want, tolerance, [f for f in fields if f not in lacking])


def test_one_body_of_several(converted, refused, tmp_path):
    source = put(tmp_path / "two.AH1", ah1_text(synthetic(gravity=9.81), structures=2))
    assert "--body" in refused(source, tmp_path / "a.nc")
    converted(source, tmp_path / "a.nc", "--body", 2)
    assert_equal(read_hydro(tmp_path / "a.nc"), read_hydro(source, body=2), 0.0)


def test_weight_is_taken_out_of_capytaine_hydrostatics(converted, tmp_path):
    """A stiffness with the weight of a mass m at height z has -m g z in pitch; Capytaine's says so unless it is told."""
    import xarray as xr

    want = synthetic()
    path = write_capytaine(want, tmp_path / "with.nc")
    data = xr.load_dataset(path)
    mass, height = 1.2e7, -9.0
    stiffness = want.hydrostatic_stiffness.copy()
    stiffness[[3, 4], [3, 4]] -= mass * want.gravity * height
    data["hydrostatic_stiffness"] = (("influenced_dof", "radiating_dof"), stiffness)
    data.to_netcdf(path, engine="h5netcdf")
    converted(path, tmp_path / "without.nc", "--mass", mass, "--centre", 0, 0, height)
    got = read_hydro(tmp_path / "without.nc").hydrostatic_stiffness
    np.testing.assert_allclose(got, want.hydrostatic_stiffness, rtol=1e-12, atol=1e-3)  # rounding of 1e9


def test_an_older_set_is_not_mixed_with_a_new_one(refused, converted, tmp_path):
    bare = write_capytaine(replace(synthetic(), hydrostatic_stiffness=None), tmp_path / "bare.nc")
    converted(write_capytaine(synthetic(), tmp_path / "full.nc"), tmp_path / "set")
    assert "set.hst" in refused(bare, tmp_path / "set")
    (tmp_path / "set.hst").unlink()
    assert "no .hst: the source has none of it" in converted(bare, tmp_path / "set")["notes"]


def test_a_file_is_not_written_over_itself(refused, oc4_folder, tmp_path):
    for suffix in (".1", ".3", ".hst"):
        shutil.copy(oc4_folder / "input" / "hydro" / f"oc4{suffix}", tmp_path)
    for source, target in (("oc4", "oc4.1"), ("oc4.1", "oc4"), ("oc4.3", "oc4")):
        assert "another file" in refused(tmp_path / source, tmp_path / target)


# --- moorings ---------------------------------------------------------------------------------------------------------


def test_map_to_moordyn_and_back(converted, refused, oc4_folder, tmp_path):
    source = oc4_folder / "input" / "MAP.dat"
    want = map_mooring(read_map(source), **WATER)
    assert "--depth" in refused(source, tmp_path / "md.dat")
    found = converted(source, tmp_path / "md.dat", "--depth", 200)
    assert found["written_as"] == "moordyn"
    assert converted(tmp_path / "md.dat", tmp_path / "map.dat")["written_as"] == "map"
    again = map_mooring(read_map(tmp_path / "map.dat"), **WATER)
    middle = moordyn_mooring(read_moordyn(tmp_path / "md.dat"))
    for name in ("position", "length", "mass_per_length", "diameter", "axial_stiffness", "seabed_friction"):
        np.testing.assert_array_equal(getattr(again, name), getattr(want, name))
        np.testing.assert_array_equal(getattr(middle, name), getattr(want, name))
    found = converted(source, tmp_path / "md1.dat", "--depth", 200, "--to", "moordyn1")
    assert any("seabed friction" in note for note in found["notes"])
    old = moordyn_mooring(read_moordyn(tmp_path / "md1.dat"), depth=200.0)
    np.testing.assert_array_equal(old.position, want.position)


# --- time series, metocean records, results ---------------------------------------------------------------------------


def test_time_series_through_all_forms(converted, oc4_folder, tmp_path):
    source = oc4_folder / "reference" / "wn7_s1.outb"
    want, before = read_openfast_out(source), source
    for name in ("a.csv", "b.nc", "c.out", "d.outb"):
        converted(before, tmp_path / name)
        before = tmp_path / name
    got = read_openfast_out(tmp_path / "d.outb")
    assert got.names == want.names
    assert got.units == want.units
    np.testing.assert_allclose(got.time, want.time, atol=1e-4)  # nine digits of 8000 s in the text form
    size = np.ptp(want.data, axis=0)
    size = np.where(size > 0, size, np.abs(want.data).max(axis=0) + 1e-300)
    assert (np.abs(got.data - want.data) / size).max() < 1e-5  # half of 1/65535 of the range


def test_metocean_record_becomes_clean(converted, sample_files, tmp_path):
    text = "time,Hs (m)\n2020-01-01 01:00,1.5\n2020-01-01 00:00,-999\n2020-01-01 00:00,-999\n"
    found = converted(put(tmp_path / "a.csv", text), tmp_path / "b.csv")
    assert (tmp_path / "b.csv").read_text() == (
        "time (UTC),significant wave height (m)\n2020-01-01T00:00:00Z,\n2020-01-01T01:00:00Z,1.5\n"
    )
    assert any("repeating another" in note for note in found["notes"])


def test_results_become_tables(converted, oc4, oc4_loads, tmp_path):
    """The committed study's own results: every variable a long table with the number of its values."""
    import pandas as pd

    loads = list(oc4_loads.values())
    path = write_netcdf(tmp_path / "results.nc", oc4, loads)
    found = converted(path, tmp_path / "tables")
    assert "channel_to_wave_real" in {Path(f).stem for f in found["files"]}
    table = pd.read_csv(tmp_path / "tables" / "std.csv", index_col=["state", "channel"], float_precision="round_trip")[
        "std"
    ]
    for item in loads:
        for name, value in zip(item.channels.names, item.statistics.std, strict=True):
            assert table[item.state.name, name] == value  # CSV holds numbers in full


# --- what is refused --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["ROTOR_TABLE", "OPENFAST_LIN", "TURBSIM", "ELASTODYN", "WAMIT_DRIFT", "FAST7_LIN"])
def test_what_has_no_equivalent(refused, sample_files, tmp_path, name):
    assert "no equivalent" in refused(sample_files[name], tmp_path / "a.csv")


def test_what_cannot_be(refused, sample_files, tmp_path):
    body = sample_files["CAPYTAINE"]
    assert "--to: wamit, capytaine" in refused(body, tmp_path / "a.xyz")
    assert "wamit, capytaine" in refused(body, tmp_path / "a.nc", "--to", "csv")
    assert "density" in refused(body, tmp_path / "a", "--density", 1000)
    assert "depth" in refused(sample_files["SERIES_CSV"], tmp_path / "a.nc", "--depth", 10)
    assert "does not exist" in refused(tmp_path / "nothing", tmp_path / "a.nc")
    assert "known format" in refused(put(tmp_path / "b.txt", "hello"), tmp_path / "a.nc")


def test_a_folder_that_cannot_be_written(refused, sample_files, tmp_path):
    (tmp_path / "file").write_text("in the way")
    assert "file" in refused(sample_files["SERIES_CSV"], tmp_path / "file" / "a.nc")


def test_mass_and_centre_belong_together(cli, sample_files, tmp_path):
    assert cli("convert", sample_files["CAPYTAINE"], tmp_path / "a", "--mass", 1e7).code == 2


def test_words_for_people(cli, sample_files, tmp_path):
    found = cli("convert", sample_files["SERIES_CSV"], tmp_path / "a.outb")
    assert "written as outb" in found.out
    assert "a.outb" in found.out
    assert cli("convert", sample_files["SERIES_CSV"], tmp_path / "a.outb", "--quiet").out == ""


# --- a study with converted files -------------------------------------------------------------------------------------


def test_study_with_moordyn_and_capytaine_has_the_same_periods(converted, trial, oc4_folder):
    """The embedded deck with its moorings as MoorDyn and its coefficients as Capytaine netCDF: the same model."""
    study = trial()
    want = fowtio.build(fowtio.load(study)).points[0]
    folder = study.parent / "input"
    converted(folder / "MAP.dat", folder / "MoorDyn.dat", "--depth", 200)
    converted(folder / "hydro" / "oc4", folder / "oc4.nc", *OPTIONS)
    shutil.rmtree(folder / "hydro")
    (folder / "MAP.dat").unlink()
    samples.set_value(folder / "oc4.fst", "CompMooring", "3")
    samples.set_value(folder / "oc4.fst", "MooringFile", '"MoorDyn.dat"')
    study.write_text(study.read_text().replace('"DEFAULT"  ', '"input/oc4.nc"'))
    model = fowtio.build(fowtio.load(study))
    got = model.points[0]
    assert model.deck.mooring_path.name == "MoorDyn.dat"
    # numbers are written in full in both formats: what differs is rounding
    np.testing.assert_allclose(got.modes.frequency, want.modes.frequency, rtol=1e-9)
    np.testing.assert_allclose(got.mean.offset, want.mean.offset, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(
    ("name", "value"), [("density", 1000.0), ("gravity", 9.6), ("depth", np.inf), ("depth", 196.0)]
)
def test_coefficients_of_other_water_are_refused(oc4_folder, tmp_path, name, value):
    deck = read_deck(oc4_folder / "input" / "oc4.fst")
    own = replace(deck_hydro(deck), **{name: value})
    path = write_capytaine(own, tmp_path / "other.nc")
    with pytest.raises(FormatError, match=rf"other\.nc.*deck's {name}.*oc4\.fst"):
        deck_hydro(deck, path)


def test_coefficients_of_nearly_the_same_water_are_taken(oc4_folder, tmp_path):
    deck = read_deck(oc4_folder / "input" / "oc4.fst")
    own = replace(deck_hydro(deck), gravity=9.81, depth=200.5, volume=14000.0, centre_of_buoyancy=(0.0, 0.0, -13.0))
    got = deck_hydro(deck, write_capytaine(own, tmp_path / "near.nc"))
    assert got.volume == 14000.0  # the file's own, before the deck's
    bare = replace(own, volume=None, centre_of_buoyancy=None)
    assert deck_hydro(deck, write_capytaine(bare, tmp_path / "bare.nc")).volume == deck.hydrodyn.volume


def test_coefficients_without_stiffness_are_refused(oc4_folder, tmp_path):
    deck = read_deck(oc4_folder / "input" / "oc4.fst")
    own = replace(deck_hydro(deck), hydrostatic_stiffness=None)
    with pytest.raises(FormatError, match=r"hydrostatic stiffness.*\.hst"):
        deck_hydro(deck, write_capytaine(own, tmp_path / "bare.nc"))
