"""The commands fmu and simulate."""

import json
import shutil

import numpy as np
import pytest

from fowtio.fmu.build import PLATFORMS


def test_simulate_writes_series_and_figure(cli, spring, tmp_path):
    done = cli(
        "simulate",
        spring["3.0"],
        "-o",
        tmp_path / "out",
        "--duration",
        20,
        "--step",
        0.5,
        "--start",
        "Initial.Position=1",
        "--json",
    )
    assert done.code == 0, done.err
    document = json.loads(done.out)
    assert document["duration"] == 20.0
    assert document["step"] == 0.5
    table = np.loadtxt(tmp_path / "out" / "series.csv", delimiter=",", skiprows=1)
    assert table.shape == (41, 4)
    assert table[0, 1] == 3.0  # the mean of 2 m and the metre asked for
    assert (tmp_path / "out" / "series.png").stat().st_size > 5000


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--start", "Initial.Position"), "Sea.Hs=3"),
        (("--start", "Sea.Hs=1"), "Sea.Hs"),
        (("--elevation", "REFERENCE"), "Wave.Elevation"),
    ],
)
def test_simulate_says_what_is_wrong(cli, spring, oc4_folder, tmp_path, arguments, words):
    arguments = [oc4_folder / "reference" / "wn7_s1.outb" if a == "REFERENCE" else a for a in arguments]
    done = cli("simulate", spring["2.0"], "-o", tmp_path / "out", *arguments)
    assert done.code == 1
    assert words in done.err
    assert not (tmp_path / "out").exists()


def test_what_is_no_fmu_is_said(cli, tmp_path):
    (tmp_path / "no.fmu").write_text("not an archive")
    done = cli("simulate", tmp_path / "no.fmu", "-o", tmp_path / "out")
    assert done.code == 1
    assert "FMU" in done.err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--state", "calm"), "white_noise"),
        (("--inputs", "waves"), "elevation"),
        (("--fmi", "1"), "both"),
        (("--platform", "mac"), "linux64"),
    ],
)
def test_export_says_what_is_wrong(cli, oc4_folder, tmp_path, arguments, words):
    done = cli("fmu", oc4_folder / "oc4.fowt", "-o", tmp_path / "x.fmu", *arguments)
    assert done.code == 1
    assert words in done.err
    assert not (tmp_path / "x.fmu").exists()


@pytest.mark.skipif(shutil.which(PLATFORMS["win64"][3][0]) is not None, reason="a cross-compiler is installed")
def test_a_missing_cross_compiler_is_said(cli, oc4_folder, tmp_path):
    done = cli("fmu", oc4_folder / "oc4.fowt", "-o", tmp_path / "x.fmu", "--platform", "win64")
    assert done.code == 1
    assert "mingw" in done.err


@pytest.mark.skipif(shutil.which(PLATFORMS["win64"][3][0]) is None, reason="no cross-compiler")
def test_a_library_for_windows(spring, tmp_path):
    import zipfile

    from fmu_samples import make, oscillator

    from fowtio.fmu.build import write_fmu

    path = write_fmu(make(oscillator(), "Spring"), tmp_path / "w.fmu", platform="win64")
    with zipfile.ZipFile(path) as archive:
        assert archive.read("binaries/win64/Spring.dll")[:2] == b"MZ"


@pytest.mark.slow
def test_export_and_check(cli, oc4_folder, tmp_path):
    done = cli(
        "fmu", oc4_folder / "oc4.fowt", "-o", tmp_path / "oc4.fmu", "--inputs", "wave_force", "--check", "--json"
    )
    assert done.code == 0, done.err
    document = json.loads(done.out)
    assert all(c["passed"] for c in document["checks"])
    assert "Wave.ForceX" in document["inputs"]
    assert "Wave.Elevation" not in document["inputs"]
