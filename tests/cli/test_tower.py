"""fowtio tower: what it prints, what its JSON holds, what it writes, what it says of files that are not a tower's."""

import json
from pathlib import Path

import numpy as np
import pytest

from fowtio.read.elastodyn import read_elastodyn

VALIDATION = Path(__file__).resolve().parents[2] / "validation"
DTU = VALIDATION / "dtu10mw" / "input" / "ElastoDyn.dat"


def test_clamped_frequencies_of_the_dtu_10_mw(cli):
    """OpenFAST gives 0.394 and 2.305 Hz for this tower and rotor-nacelle assembly; within 0.5 %, and half of that here."""
    run = cli("tower", DTU, "--json")
    assert run.code == 0
    found = json.loads(run.out)
    for source in (found["clamped"]["frequency_hz"], found["deck_polynomials"]["frequency_hz"]):
        assert np.isclose(source["tower_fa1"], 0.394, rtol=2.5e-3)
        assert np.isclose(source["tower_fa2"], 2.305, rtol=2.5e-3)
    assert found["floating"] is None
    # nacelle 446,006 kg, hub 105,520 kg and three blades of 41.7 t (Bak et al. 2013)
    assert np.isclose(found["rotor_nacelle"]["mass"], 446_006 + 105_520 + 3 * 41_716, rtol=1e-3)
    assert np.isclose(found["rotor_nacelle"]["hub_height"], 119.0, atol=0.01)
    assert "gravity" in found["notes"][0]
    assert found["units"]["frequency_hz"] == "Hz"


def test_a_floating_deck_has_both_bases(cli, oc4_folder):
    found = json.loads(cli("tower", oc4_folder / "input" / "oc4.fst", "--json").out)
    clamped, floating = (found[k]["frequency_hz"]["tower_fa1"] for k in ("clamped", "floating"))
    assert np.isclose(floating, 1 / 2.309, rtol=3e-3)  # OpenFAST's decay of the tower on this floater
    assert clamped < floating


def test_polynomials_go_back_into_a_tower_file(cli, tmp_path):
    """Pasted over those of the deck, the lines give a deck that reads, whose own polynomials then have the fitted frequencies."""
    out = tmp_path / "out"
    assert cli("tower", DTU, "-o", out, "--quiet").out == ""
    lines = (out / "polynomials_clamped.dat").read_text().splitlines()
    folder = tmp_path / "deck"
    folder.mkdir()
    for file in DTU.parent.iterdir():
        (folder / file.name).write_bytes(file.read_bytes())
    tower = folder / "ElastoDyn_Tower.dat"
    old = tower.read_text().splitlines()
    start = next(k for k, line in enumerate(old) if "MODE SHAPES" in line)
    end = next(k for k, line in enumerate(old) if "POINT MASSES" in line)
    tower.write_text("\n".join([*old[:start], *lines, *old[end:]]) + "\n")
    assert np.allclose(
        read_elastodyn(folder / "ElastoDyn.dat", 9.80665).structure.tower.modes.sum(axis=1), 1.0, atol=1e-9
    )
    again = json.loads(cli("tower", folder / "ElastoDyn.dat", "--json").out)
    for name, hz in again["clamped"]["frequency_hz"].items():
        assert np.isclose(
            again["deck_polynomials"]["frequency_hz"][name], hz, rtol=1e-3
        )  # a polynomial is not quite the mode


def test_printed_and_written(cli, tmp_path, oc4_folder):
    run = cli("tower", oc4_folder / "input" / "oc4.fst", "-o", tmp_path / "out")
    assert run.code == 0
    for text in ("fore-aft 1", "TwFAM1Sh(2)", "Rotor-nacelle assembly", "infinite-frequency added mass"):
        assert text in run.out
    names = {p.name for p in (tmp_path / "out").iterdir()}
    assert names == {
        "tower_modes.png",
        "tower_modes.svg",
        "polynomials_clamped.dat",
        "polynomials_floating.dat",
        "tower.json",
    }
    assert json.loads((tmp_path / "out" / "tower.json").read_text())["clamped"]["modes"][0]["name"] == "tower_fa1"


@pytest.mark.parametrize(
    ("text", "say"), [("nothing here\n", "expected an OpenFAST primary file"), ("1 TwrFile - x\n", "TwrFile")]
)
def test_files_that_are_no_tower(cli, tmp_path, text, say):
    file = tmp_path / "x.dat"
    file.write_text(text)
    run = cli("tower", file)
    assert run.code == 1
    assert "error:" in run.err or say in run.err
    assert "Traceback" not in run.err


def test_a_tower_too_weak_for_its_load(cli, tmp_path):
    """A thousandth of the stiffness: the tower buckles, and the message says so."""
    for file in DTU.parent.iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    tower = tmp_path / "ElastoDyn_Tower.dat"
    tower.write_text(tower.read_text().replace("1   AdjFASt", "1e-3   AdjFASt"))
    run = cli("tower", tmp_path / "ElastoDyn.dat")
    assert run.code == 1
    assert "buckles" in run.err
