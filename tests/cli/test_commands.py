"""The commands as a user sees them: output, JSON, exit statuses, files."""

import json
import re
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import numpy as np
import pytest

COMMANDS = ("init", "run", "check", "modes", "validate", "bench")


def document(result):
    """The one JSON document on standard output; json.loads refuses anything before or after it, and NaN is refused here."""

    def refuse(name):
        raise AssertionError(f"{name} is no JSON")

    return json.loads(result.out, parse_constant=refuse)


def program(*arguments, **options):
    """Run the command line as a program of its own."""
    return subprocess.run(
        [sys.executable, "-m", "fowtio", *map(str, arguments)], capture_output=True, text=True, timeout=60, **options
    )


# --- help and usage --------------------------------------------------------------------------------------------------


def test_help_is_quick():
    """Below half a second (best of five, so that a busy machine does not fail it): no numerical library is imported for it."""
    best = float("inf")
    for _ in range(5):
        start = time.perf_counter()
        done = program("--help")
        best = min(best, time.perf_counter() - start)
        if best < 0.4:
            break
    assert done.returncode == 0
    assert best < 0.5
    for name in COMMANDS:
        assert name in done.stdout


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_explains_itself(cli, command):
    found = cli(command, "--help")
    assert found.code == 0
    assert "--json" in found.out
    assert "--quiet" in found.out


@pytest.mark.parametrize(
    "arguments",
    [("frobnicate",), ("run",), ("run", "a.fowt", "--frobnicate"), ("modes", "a.fowt", "--wind-speed", "fast")],
)
def test_wrong_usage_exits_with_two(cli, arguments):
    found = cli(*arguments)
    assert found.code == 2
    assert found.out == ""
    assert found.err


# --- init ------------------------------------------------------------------------------------------------------------


def test_init_writes_a_study_that_runs(cli, tmp_path):
    found = cli("init", tmp_path / "new", "--json")
    study = Path(document(found)["study"])
    assert found.code == 0
    assert study.is_file()
    assert (study.parent / "input" / "oc4.fst").is_file()
    assert cli("modes", study).code == 0
    assert [p.name for p in tmp_path.iterdir()] == ["new"]  # nothing left beside it


def test_init_says_what_to_do_next(cli, tmp_path):
    found = cli("init", tmp_path / "new")
    assert "fowtio run" in found.out
    assert cli("init", tmp_path / "other", "--quiet").out == ""


def test_init_takes_an_empty_folder_and_refuses_any_other(cli, tmp_path):
    (tmp_path / "empty").mkdir()
    assert cli("init", tmp_path / "empty").code == 0
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "mine.txt").write_text("keep")
    found = cli("init", tmp_path / "full")
    assert found.code == 1
    assert "full exists and is not empty" in found.err
    assert [p.name for p in (tmp_path / "full").iterdir()] == ["mine.txt"]
    (tmp_path / "file").write_text("keep")
    assert cli("init", tmp_path / "file").code == 1
    assert (tmp_path / "file").read_text() == "keep"


# --- modes -----------------------------------------------------------------------------------------------------------


def test_modes_json(cli, oc4_folder):
    found = document(cli("modes", oc4_folder / "oc4.fowt", "--json"))
    by_name = {m["name"]: m for m in found["modes"]}
    assert set(by_name) == {"surge", "sway", "heave", "roll", "pitch", "yaw", "tower_fa1"}
    for mode in found["modes"]:
        assert mode["frequency_hz"] * mode["period_s"] == pytest.approx(1.0)
        assert mode["damping_ratio"] < 1
    assert by_name["heave"]["period_s"] == pytest.approx(17.064, rel=0.02)  # free decay, OpenFAST 5.0 reference run
    assert [p["wind_speed"] for p in found["operating_points"]] == [0.0, 11.0]
    assert found["units"]["period_s"] == "s"


def test_modes_at_any_wind_speed(cli, oc4_folder):
    found = document(cli("modes", oc4_folder / "oc4.fowt", "--json", "--wind-speed", 9.5))
    assert [p["wind_speed"] for p in found["operating_points"]] == [9.5]
    assert any("interpolated" in note for note in found["notes"])
    outside = cli("modes", oc4_folder / "oc4.fowt", "--wind-speed", 30)
    assert outside.code == 1
    assert "no linearisation at 30 m/s" in outside.err


def test_modes_for_people(cli, oc4_folder):
    found = cli("modes", oc4_folder / "oc4.fowt")
    assert found.code == 0
    for word in ("Surge", "Heave", "Tower fore-aft 1", "17.07", "11 m/s"):
        assert word in found.out
    assert found.err == ""  # nothing to say below two seconds


# --- run -------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def finished(oc4_folder, tmp_path_factory):
    """One run of the embedded study as a program, without figures: its document, its folder, what it said on the side."""
    folder = tmp_path_factory.mktemp("run") / "results"
    done = program("run", oc4_folder / "oc4.fowt", "--json", "--no-figures", "-o", folder)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout), folder, done.stderr


def test_run_json(finished, oc4_loads):
    found, _, _ = finished
    assert set(found["states"]) == {"white_noise", "operating", "storm"}
    assert found["state"] == "white_noise"
    assert found["statistics"] == found["states"]["white_noise"]["statistics"]
    assert np.shape(found["mooring"]["stiffness"]) == (6, 6)
    assert len(found["mooring"]["fairlead_tension"]) == 3
    for name in (
        "PtfmSurge",
        "PtfmHeave",
        "PtfmPitch",
        "TTDspFA",
        "TwrBsFxt",
        "TwrBsMyt",
        "NcIMUTAxs",
        "T[1]",
        "T[2]",
        "T[3]",
    ):
        item = oc4_loads["white_noise"]
        assert found["statistics"][name]["std"] == pytest.approx(
            item.statistics.std[item.channels.index(name)], rel=1e-6
        )
        assert found["units"]["statistics"][name]
    assert found["states"]["operating"]["mean_offset"]["surge"] == pytest.approx(
        8.2782, rel=0.015
    )  # OpenFAST 5.0 reference run
    assert set(found["mean_offset"]) == set(found["units"]["mean_offset"])


def test_run_is_silent_on_the_side(finished):
    assert finished[2] == ""


def test_run_without_figures_writes_tables_only(finished):
    found, folder, _ = finished
    assert found["files"]
    written = sorted(p for p in folder.rglob("*") if p.is_file())
    assert sorted(Path(f) for f in found["files"]) == written
    assert not any(p.suffix in (".png", ".svg", ".html") for p in written)
    assert [p.name for p in folder.parent.iterdir()] == ["results"]  # no temporary folder is left


def test_results_can_be_read_back(finished):
    """The netCDF file holds what the document says."""
    xarray = pytest.importorskip("xarray")
    found, folder, _ = finished
    with xarray.open_dataset(next(folder.rglob("*.nc")), engine="h5netcdf") as data:
        values = [np.ravel(v.values) for v in data.data_vars.values() if np.issubdtype(v.dtype, np.number)]
    surge = found["statistics"]["PtfmSurge"]["std"]
    assert any(np.any(np.isclose(np.real(v), surge, rtol=1e-6)) for v in values)


def test_run_with_figures(cli, trial):
    study = trial()
    found = cli("run", study, "-o", study.parent / "out")
    assert found.code == 0
    report = study.parent / "out" / "report.html"
    assert str(report) in found.out
    text = report.read_text()
    assert text.lstrip().lower().startswith("<!doctype html")
    assert not re.search(r'(src|href)="(?!#|data:)', text)  # self-contained
    assert any(p.suffix == ".png" for p in (study.parent / "out").rglob("*"))


def test_quiet_run_says_nothing_and_a_second_one_replaces_the_first(cli, trial):
    study = trial()
    out = study.parent / "out"
    first = cli("run", study, "-o", out, "--quiet", "--no-figures")
    assert (first.code, first.out, first.err) == (0, "", "")
    (out / "mine.txt").write_text("keep")
    before = {p.name: p.stat().st_mtime_ns for p in out.iterdir()}
    assert cli("run", study, "-o", out, "--quiet", "--no-figures").code == 0
    after = {p.name: p.stat().st_mtime_ns for p in out.iterdir()}
    assert set(after) == set(before)
    assert after.pop("mine.txt") == before.pop("mine.txt")
    assert all(after[name] > before[name] for name in before)


def test_default_folder_is_beside_the_user(cli, trial, tmp_path, monkeypatch):
    study = trial()
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    assert cli("run", study, "--no-figures", "--quiet").code == 0
    assert any((tmp_path / "here" / "results" / "trial").iterdir())
    assert not (study.parent / "results").exists()


def test_run_of_a_deck_alone(cli, trial):
    study = trial()
    found = document(
        cli("run", study.parent / "input" / "oc4.fst", "--json", "--no-figures", "-o", study.parent / "out")
    )
    assert list(found["states"]) == ["deck"]


# --- check -----------------------------------------------------------------------------------------------------------


def test_check_changes_nothing(cli, trial):
    study = trial()
    before = sorted(study.parent.rglob("*"))
    found = document(cli("check", study, "--json"))
    assert sorted(study.parent.rglob("*")) == before
    assert found["depth"] == 200.0
    assert found["headings"] == 13
    assert found["frequencies"] == 69
    names = [c["name"] for c in found["operating_points"][0]["contributions"]]
    assert len(names) == len(set(names))
    total = sum(np.array(c["mass"]) for c in found["operating_points"][0]["contributions"])
    assert np.allclose(total, found["operating_points"][0]["sum"]["mass"])


def test_check_says_who_contributes_what(cli, oc4_folder):
    found = cli("check", oc4_folder / "oc4.fowt")
    assert found.code == 0
    for word in (
        "turbine on its tower",
        "platform mass and weight",
        "hydrostatics",
        "moorings",
        "infinite-frequency added mass",
    ):
        assert word in found.out


@pytest.mark.parametrize(
    "name", ["input/MAP.dat", "input/hydro/oc4.1", "linearisation/parked/main.1.lin", "reference/wn7_s1.outb"]
)
def test_check_of_a_single_file(cli, oc4_folder, name):
    found = cli("check", oc4_folder / name)
    assert found.code == 0, found.err
    assert "format" in found.out
    assert document(cli("check", oc4_folder / name, "--json"))["file"].endswith(name.split("/")[-1])


# --- validate --------------------------------------------------------------------------------------------------------


def one_reference(oc4_folder, folder, tolerance):
    """The embedded study with one reference file and one tolerance [%], without those of single channels."""
    for part in ("input", "linearisation", "reference"):
        (folder / part).symlink_to(oc4_folder / part)
    text = (oc4_folder / "oc4.fowt").read_text()
    assert "wn7_s*" in text
    assert "2000     2.0" in text
    rows, count = re.subn(r"^white_noise +\S+ +[\d.]+ +- +\S+\n", "", text, flags=re.MULTILINE)
    assert (count, "14               NTol" in rows) == (6, True)
    text = rows.replace("14               NTol", "8                NTol")
    study = folder / "one.fowt"
    study.write_text(text.replace("wn7_s*", "wn7_s1").replace("2000     2.0", f"2000     {tolerance}"))
    return study


def test_validate_json_and_tolerance_met(cli, oc4_folder, tmp_path):
    study = one_reference(oc4_folder, tmp_path, 10.0)  # one seed scatters by 5 %
    result = cli("validate", study, "--json", "-o", tmp_path / "out")
    assert result.code == 0, result.err
    found = document(result)
    assert found["passed"] is True
    channel = found["channels"]["PtfmPitch"]
    for key in ("std_error", "rao_error", "peak_error", "peak_frequency_error", "coherence_mean"):
        assert isinstance(channel[key], float)
    assert channel["scatter"] is None  # one seed has no scatter
    assert all(Path(f).is_file() for f in found["files"])


def test_validate_with_a_tolerance_not_met_exits_with_three(cli, oc4_folder, tmp_path, monkeypatch):
    """The comparison is written all the same. (Quadratic drag on the record, slow, is left out here.)"""
    import fowtio.validation as module

    monkeypatch.setattr(module, "validate", partial(module.validate, nonlinear=False))
    study = one_reference(oc4_folder, tmp_path, 0.001)
    found = cli("validate", study, "-o", tmp_path / "out")
    assert found.code == 3
    assert "outside" in found.out
    assert any((tmp_path / "out").iterdir())


def test_validate_needs_references(cli, trial):
    study = trial()
    found = cli("validate", study)
    assert found.code == 1
    assert "names no reference time series" in found.err


# --- bench -----------------------------------------------------------------------------------------------------------


def test_bench(cli, trial):
    found = document(cli("bench", trial(), "--json"))
    assert all(seconds > 0 for seconds in found["timings_s"].values())
