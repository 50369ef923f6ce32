"""`fowtio optimise` as a user sees it: files, JSON, what it says when something is wrong, stopping it and going on."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import fowtio
from fowtio.optimise.study import load_optimisation

SITES = Path(__file__).resolve().parents[2] / "validation" / "sites"
BANDS = """2            NFrequencies
Low    High  Count
(Hz)   (Hz)  (-)
0.003  0.07  24
0.08   0.6   16
"""


@pytest.fixture
def small_study(tmp_path):
    """The Tuscany study with few frequencies and two stages of small populations, in a folder of its own."""
    text = (SITES / "tuscany.opt").read_text()
    rows = text[text.index("7            NFrequencies") : text.index("------- DESIGN VARIABLES")]
    text = text.replace(rows, BANDS).replace("200         4  ", "8           3  ").replace("200         3  ", "12          2  ")
    path = tmp_path / "study" / "small.opt"
    path.parent.mkdir()
    path.write_text(text.replace("------- FATIGUE", "False        Polish          - going downhill from what the search found\n------- FATIGUE", 1))
    shutil.copyfile(SITES / "tuscany.cost", path.parent / "tuscany.cost")
    return path


def test_report_history_and_designs(cli, small_study, tmp_path):
    folder = tmp_path / "out"
    result = cli("optimise", small_study, "-o", folder, "--stage", "ultimate", "--json", "--jobs", 1)
    assert result.code == 0, result.err
    found = json.loads(result.out)
    files = {p.name for p in folder.rglob("*") if p.is_file()}
    assert {"optimisation.html", "optimisation.xlsx", "ultimate.nc", "ultimate.fowt", "ultimate.fst"} <= files
    assert found["designs"] == {"ultimate": str(folder / "designs" / "ultimate" / "ultimate.fowt")}
    optimum = found["stages"]["ultimate"]["optimum"]
    assert 14 <= optimum["diameter"] <= 20
    assert found["units"]


def test_the_design_by_the_main_job_has_the_numbers_of_the_search(cli, small_study, tmp_path):
    folder = tmp_path / "out"
    found = json.loads(cli("optimise", small_study, "-o", folder, "--stage", "ultimate", "--json", "--no-figures").out)
    values = found["stages"]["ultimate"]["values"]
    model = fowtio.build(fowtio.load(found["designs"]["ultimate"]))
    item = next(x for x in fowtio.loads(fowtio.solve(model)) if x.state.name == "rated")
    index = item.channels.index("TwrBsMyt")
    moment = abs(item.statistics.mean[index]) + item.statistics.std[index]
    # files in full precision and drag iterated to 3e-9 on both ways: what is asked is 1e-8
    assert moment == pytest.approx(values["tower_moment:rated"], rel=1e-8)
    assert item.point.mean.offset[0] == pytest.approx(values["mean_surge:rated"], rel=1e-8)
    assert item.point.mean.offset[4] == pytest.approx(values["mean_pitch:rated"], rel=1e-8)


def test_unknown_studies_and_stages_are_said(cli, small_study, tmp_path):
    result = cli("optimise", "tuscani")
    assert result.code == 1
    assert "Did you mean tuscany?" in result.err
    result = cli("optimise", small_study, "--stage", "first", "-o", tmp_path / "out")
    assert result.code == 1
    assert "no stage 'first'" in result.err
    assert "Traceback" not in result.err


def test_stopped_and_gone_on(small_study, tmp_path):
    """Terminated after its first generation, the run says how to go on, and the same command comes to the result of an undisturbed run."""

    def start(folder):
        return subprocess.Popen(
            [sys.executable, "-m", "fowtio", "optimise", str(small_study), "-o", str(folder), "--stage", "ultimate", "--json", "--no-figures"],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env={**os.environ, "OMP_NUM_THREADS": "1"},
        )  # fmt: skip

    whole = start(tmp_path / "whole")
    stopped = start(tmp_path / "stopped")
    history = tmp_path / "stopped" / "history" / "ultimate.nc"
    deadline = time.monotonic() + 60
    while not history.is_file() and time.monotonic() < deadline:
        time.sleep(0.01)
    stopped.send_signal(signal.SIGTERM)
    _, error = stopped.communicate(timeout=60)
    assert stopped.returncode == 143
    assert "goes on from there" in error
    again, _ = start(tmp_path / "stopped").communicate(timeout=120)
    undisturbed, _ = whole.communicate(timeout=120)
    a, b = (json.loads(text)["stages"]["ultimate"] for text in (again, undisturbed))
    assert a["optimum"] == b["optimum"]
    assert a["values"] == b["values"]
    assert a["evaluations"] == b["evaluations"]


def test_the_shipped_studies_say_what_they_hold():
    study = load_optimisation("tuscany")
    assert [s.name for s in study.stages] == ["ultimate", "pareto", "fatigue"]
    # table 26: nine speeds from 9 to 25 m/s, weighted with the time at each; the site's wind is below 8 m/s for 77 % of it
    assert np.isclose(sum(study.shares.values()), 0.229, atol=0.001)
