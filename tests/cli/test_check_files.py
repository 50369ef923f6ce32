"""fowtio check FILE: every format is recognised and described, problems are listed, damaged files give one clear message."""

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "read"))
import openfast_samples as samples
from every_format import every_format
from hydro_samples import put, synthetic

from fowtio.write.hydro import write_capytaine

DECK = ".fst"  # a deck is built as a study, not described as a file


@pytest.fixture(scope="module")
def sample_files(tmp_path_factory):
    return every_format(tmp_path_factory.mktemp("formats"))


def test_every_format_for_people_and_for_programs(cli, sample_files):
    for name, path in sample_files.items():
        if path.suffix == DECK:
            continue
        found = cli("check", path)
        assert found.code == 0, (name, found.err)
        lines = found.out.splitlines()
        assert lines[0] == str(path)
        assert max(map(len, lines[1:])) <= 120, name  # folded, but for the path
        assert found.out.count("problem") >= 1, name
        document = json.loads(cli("check", path, "--json").out)
        assert document["file"] == str(path)
        assert lines[1].split(maxsplit=1) == ["format", document["format"]]
        assert isinstance(document["problems"], list)
        assert len(document) > 4, name
        assert cli("check", path, "--quiet").out == ""


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("WAMIT_SET", ("rad/s", "kg/m3", "heave", "N/m", "e^{+i omega t}", "deg")),
        ("CAPYTAINE", ("5, 0.3 to 1.5 rad/s", "4, -90 to 90 deg", "zero and infinite", "12345 m3", "depth 80 m")),
        ("OPENFAST_LIN", ("states", "operating point", "rad/s", "m/s")),
        ("OPENFAST_OUT", ("0 to 0.1 s", "2 samples", "PtfmSurge (m)")),
        ("MOORDYN", ("version", "line types", "points", "lines")),
        ("MAP", ("line types", "nodes", "deck")),
        ("TURBSIM", ("grid", "m/s", "hub")),
        ("METOCEAN", ("UTC", "column 'Hs (m)'", "1.5 to 1.6 m")),
        ("ROTOR_TABLE", ("tip speed ratio", "deg")),
    ],
)
def test_what_is_said(cli, sample_files, name, words):
    found = cli("check", sample_files[name]).out
    for word in words:
        assert word in found, (word, found)


RECORD = """time,Hs (m),Tp (s),wind speed (m/s)
2020-01-01 00:00,1.0,7,8
2020-01-01 01:00,-999,7,8
2020-01-01 03:00,abc,7,250
2020-01-01 02:00,1.1,,8
2020-01-01 02:00,1.1,,8
2020-01-01 04:00,1.2,7,8
2020-01-01 04:00,1.3,7,8
whenever,1.2,7,8
2020-01-01 08:00,1.2,7,8
"""


def test_every_problem_of_a_metocean_record(cli, tmp_path):
    """Each kind once, with its count: sentinel, unreadable, beyond belief, blank, repeated, contradictory, no time, order, gap."""
    found = json.loads(cli("check", put(tmp_path / "a.csv", RECORD), "--json").out)
    text = "\n".join(found["problems"])
    for words in (
        "significant height, 1 value: a number that stands for a missing one",
        "significant height, 1 value: no number",
        "significant height: missing at 3 times, first 2020-01-01 01:00",
        "peak period, 2 values: blank",
        "wind speed, 1 value: beyond belief, outside 0 to 80 m/s",
        "1 row without a time that can be read",
        "1 row repeating another",
        "1 row contradicting another",
        "1 row standing before an earlier one",
        "1 gap, 3 steps missing; the longest: 2020-01-01 04:00 to 2020-01-01 08:00",
    ):
        assert words in text, (words, text)


def test_problems_of_coefficients(cli, tmp_path):
    want = synthetic()
    damping = want.radiation_damping.copy()
    damping[2, 2, 2] = -0.05 * damping[:, 2, 2].max()
    added = want.added_mass.copy()
    added[:, 0, 4] += 0.2 * np.sqrt(added[:, 0, 0] * added[:, 4, 4])
    bent = replace(want, radiation_damping=damping, added_mass=added, added_mass_zero=None)
    found = json.loads(cli("check", write_capytaine(bent, tmp_path / "a.nc"), "--json").out)
    assert [p.split(";")[0].split(":")[0] for p in found["problems"]] == [
        "no zero-frequency added mass",
        "the radiation damping in heave is negative at 1 frequency, down to -5 % of its largest",
        "the added mass is not symmetric",
    ]


def test_every_bad_file_of_a_deck_is_named(cli, tmp_path):
    fst = samples.copy_deck(tmp_path / "deck")
    for name, word in (("ElastoDyn.dat", "PtfmMass"), ("HydroDyn.dat", "PtfmVol0"), ("MAP.dat", None)):
        path = fst.parent / name
        text = path.read_text()
        path.write_text(text.replace(word, "Nonsense") if word else text[: len(text) // 2])
    found = cli("check", fst)
    assert found.code == 1
    for name in ("ElastoDyn.dat", "HydroDyn.dat", "MAP.dat"):
        assert name in found.err
    assert "internal error" not in found.err


def test_damaged_files_give_one_message(cli, sample_files, tmp_path):
    """Each sample cut in half, emptied, and with its middle overwritten, 3 x 28 files: status 0 or 1, never a traceback."""
    tried = 0
    for name, source in sample_files.items():
        if not source.is_file():
            continue
        content, half = source.read_bytes(), source.stat().st_size // 2
        for label, data in (
            ("half", content[:half]),
            ("empty", b""),
            ("overwritten", content[:half] + b"*" * 40 + content[half + 40 :]),
        ):
            path = tmp_path / f"{label}{source.suffix}"
            path.write_bytes(data)
            found = cli("check", path)
            assert found.code in (0, 1), (name, label)
            assert "internal error" not in found.err, (name, label, found.err)
            assert "Traceback" not in found.err
            assert found.err.count("error: ") == (found.code == 1), (name, label, found.err)
            if label == "empty":
                assert found.code == 1
            tried += 1
    assert tried > 75
