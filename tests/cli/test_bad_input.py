"""Bad input: one clear message with file and line, exit status 1, no traceback, nothing written, existing results untouched."""

import re
import shutil
import warnings
from pathlib import Path

import pytest


def snapshot(folder: Path) -> dict[Path, bytes]:
    return {p: p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def edit(path: Path, old: str, new: str, count: int = 1) -> int:
    """Replace text that must be there; return the line of its first place, from 1."""
    text = path.read_text()
    assert old in text, f"{old!r} is not in {path.name}"
    path.write_text(text.replace(old, new, count))
    return text[: text.index(old)].count("\n") + 1


@pytest.fixture
def refused(cli):
    """Return a check that a run of a study is refused with a message that holds certain words, and leaves everything as it was."""

    def check(study: Path, *words: str) -> str:
        results = study.parent / "out"
        results.mkdir()
        (results / "results.nc").write_bytes(b"results of yesterday")
        before = snapshot(study.parent)
        for command in (("run", study, "-o", results, "--no-figures"), ("check", study)):
            found = cli(*command)
            assert found.code == 1, (command, found.out, found.err)
            assert found.out == ""
            assert found.err.startswith("error: ")
            assert "Traceback" not in found.err
            assert "internal error" not in found.err
            assert found.err.count("error: ") == 1
            for word in words:
                assert word in found.err, f"{word!r} is not in: {found.err}"
        assert snapshot(study.parent) == before
        assert not [p for p in study.parent.iterdir() if p.name.startswith(".")]
        return found.err

    return check


# --- files -----------------------------------------------------------------------------------------------------------


def test_study_that_is_not_there(cli, tmp_path):
    found = cli("run", tmp_path / "nothing.fowt")
    assert found.code == 1
    assert "nothing.fowt" in found.err
    assert "Traceback" not in found.err
    assert list(tmp_path.iterdir()) == []


def test_something_that_is_no_study(cli, tmp_path):
    other = tmp_path / "other.fowt"
    other.write_text("hello\nworld\n")
    found = cli("run", other)
    assert found.code == 1
    assert "other.fowt, line 1" in found.err
    assert "fowtio init" in found.err


@pytest.mark.parametrize("content", [b"", b"\x00\x01\x02\xff\xfe" * 100])
def test_empty_and_binary_studies(cli, tmp_path, content):
    other = tmp_path / "other.fowt"
    other.write_bytes(content)
    found = cli("run", other)
    assert found.code == 1
    assert "other.fowt" in found.err
    assert "internal error" not in found.err


def test_a_folder_in_place_of_a_study(cli, tmp_path):
    found = cli("run", tmp_path)
    assert found.code in (1, 2)
    assert "internal error" not in found.err


@pytest.mark.parametrize(
    "name", ["ElastoDyn.dat", "HydroDyn.dat", "SeaState.dat", "MAP.dat", "ElastoDyn_Tower.dat", "ElastoDyn_Blade.dat"]
)
def test_a_file_that_the_deck_names_is_missing(trial, refused, name):
    study = trial()
    (study.parent / "input" / name).unlink()
    found = refused(study, name)
    assert re.search(r"\.(fst|dat), line \d+", found)  # where it is named


@pytest.mark.parametrize("suffix", [".1", ".3", ".hst"])
def test_missing_coefficients(trial, refused, suffix):
    study = trial()
    (study.parent / "input" / "hydro" / f"oc4{suffix}").unlink()
    refused(study, suffix)


@pytest.mark.parametrize("suffix", [".1", ".3"])
@pytest.mark.parametrize("rows", [100, 101])
def test_truncated_coefficients(trial, refused, suffix, rows):
    """Cut between two lines, and in the middle of one."""
    study = trial()
    path = study.parent / "input" / "hydro" / f"oc4{suffix}"
    lines = path.read_text().splitlines(keepends=True)
    text = "".join(lines[:rows])
    path.write_text(text[:-30] if rows % 2 else text)
    refused(study, f"oc4{suffix}")


@pytest.mark.parametrize("suffix", [".1", ".3", ".hst"])
def test_nan_in_the_coefficients(trial, refused, suffix):
    """A number replaced by NaN is found at its line."""
    study = trial()
    path = study.parent / "input" / "hydro" / f"oc4{suffix}"
    lines = path.read_text().splitlines()
    k = len(lines) // 2
    lines[k] = " ".join([*lines[k].split()[:-1], "NaN"])
    path.write_text("\n".join(lines) + "\n")
    refused(study, f"oc4{suffix}, line {k + 1}")


def test_waves_from_where_there_are_no_data(trial, refused):
    """Headings of 0 and 30 degrees only; the study asks for 90."""
    study = trial(heading=90.0)
    path = study.parent / "input" / "hydro" / "oc4.3"
    rows = [line for line in path.read_text().splitlines() if abs(float(line.split()[1]) - 15.0) < 20.0]
    path.write_text("\n".join(rows) + "\n")
    line = next(i for i, text in enumerate(study.read_text().splitlines(), 1) if text.startswith("sea "))
    refused(study, f"trial.fowt, line {line}", "'sea'", "90 deg", "0 to 30 deg")


# --- the study -------------------------------------------------------------------------------------------------------


def test_misspelt_name(trial, refused):
    study = trial()
    line = edit(study, "NFreq ", "NFrek ")
    refused(study, f"trial.fowt, line {line}", "NFrek", "did you mean NFreq")


def test_misspelt_choice(trial, refused):
    study = trial()
    edit(study, "100              NFreq", '"realtive"       DragModel     - drag\n100              NFreq')
    refused(study, "trial.fowt, line ", "DragModel", "did you mean relative")


def test_deck_that_is_not_there(trial, refused):
    study = trial()
    line = edit(study, "input/oc4.fst", "input/oc5.fst")
    refused(study, f"trial.fowt, line {line}", "oc5.fst")


def test_several_problems_are_all_reported(trial, cli):
    study = trial()
    edit(study, "input/oc4.fst", "input/oc5.fst")
    edit(study, "NFreq ", "NFrek ")
    edit(study, "jonswap      2.0 ", "jonswop      2.0 ")
    edit(study, "7                DOFs", '"surge heive"    DOFs')
    found = cli("run", study)
    assert found.code == 1
    for word in ("oc5.fst", "NFrek", "jonswop", "heive"):
        assert word in found.err
    assert found.err.count("trial.fowt, line") == 4
    assert len(found.err.strip().splitlines()) == 4


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("jonswap      2.0 ", "jonswap      -2.0", ("significant_height", "-2")),
        ("jonswap      2.0       10.0", "jonswap      2.0       -   ", ("Tp", "missing")),
        ("jonswap      2.0       10.0", "jonswap      2.0       ten ", ("'ten'",)),
        ("100              NFreq", "10               NFreq", ("NFreq is 10",)),
        ("100              NFreq", "many             NFreq", ("NFreq", "many")),
        ("sea           0.0 ", "sea           11.0", ("11", "no linearisation")),
        ("7                DOFs", '"surge surge"    DOFs', ("once",)),
        ("7                DOFs", '"tower_fa1"      DOFs', ("at least one platform motion",)),
    ],
)
def test_values_that_cannot_be(trial, refused, old, new, words):
    study = trial()
    line = edit(study, old, new)
    refused(study, f"trial.fowt, line {line}", *words)


# --- the deck --------------------------------------------------------------------------------------------------------


def test_a_line_that_cannot_reach(trial, refused):
    """Anchor and fairlead are 818 m apart; 300 m of chain would have to stretch to more than twice their length."""
    study = trial()
    edit(study.parent / "input" / "MAP.dat", "835.35", "300.00")
    refused(study, "MAP.dat", "line 1", "cannot reach", "300 m")


def test_a_floater_that_sinks(trial, refused):
    """A mass a hundred times too large: no mean offset with these moorings."""
    study = trial()
    path = study.parent / "input" / "ElastoDyn.dat"
    line = next(t for t in path.read_text().splitlines() if "PtfmMass " in t)
    edit(path, line.split()[0], "1.3473E+09")
    refused(study, "mean offset")


def test_a_floater_that_capsizes(trial, refused):
    """Centre of mass 40 m too high: statically unstable, said as such."""
    study = trial()
    path = study.parent / "input" / "ElastoDyn.dat"
    line = next(t for t in path.read_text().splitlines() if "PtfmCMzt" in t)
    edit(path, line, line.replace(line.split()[0], "30.0", 1))
    refused(study, "unstable")


# --- linearisations --------------------------------------------------------------------------------------------------

ROW = '{wind} "linearisation/turbine/U11/m.*.lin" {deck} {mass}'
COPY = ("turbine/U11", "turbine/ElastoDyn_Blade.dat", "turbine/ElastoDyn_Tower.dat", "turbine/SeaState.dat", "turbine/zero.1",
        "turbine/zero.3", "turbine/zero.hst")  # fmt: skip
DECK = '"linearisation/turbine/U11/turbine.fst"'


def test_this_linearisation_works_with_its_deck(trial, cli):
    """The same study that the tests below spoil."""
    study = trial(rows=[ROW.format(wind=11.0, deck=DECK, mass="auto")], copy=COPY, wind=11.0)
    assert cli("modes", study).code == 0
    study.write_text(study.read_text().replace(" auto", " deck"))
    assert cli("modes", study).code == 0


def test_mass_from_a_file_without_load_inputs(trial, refused):
    study = trial(rows=[ROW.format(wind=11.0, deck=DECK, mass="lin")], copy=COPY, wind=11.0)
    refused(study, "m.1.lin", "load inputs", "LinInputs = 2")


def test_unknown_mass_without_load_inputs_and_without_deck(trial, refused):
    """No deck named and none beside the files: the study's own cannot be taken for a turbine on springs."""
    study = trial(rows=[ROW.format(wind=11.0, deck="-", mass="auto")], copy=COPY, wind=11.0)
    (study.parent / "linearisation" / "turbine" / "U11" / "turbine.fst").unlink()
    refused(study, "m.1.lin", "LinDeck")


def test_nan_in_a_linearisation(trial, refused):
    study = trial(rows=[ROW.format(wind=11.0, deck=DECK, mass="auto")], copy=COPY, wind=11.0)
    path = study.parent / "linearisation" / "turbine" / "U11" / "m.3.lin"
    lines = path.read_text().splitlines(keepends=True)
    k = next(i for i, t in enumerate(lines) if t.startswith("A:")) + 9
    numbers = lines[k].split()
    lines[k] = " ".join([*numbers[:3], "NaN", *numbers[4:]]) + "\n"
    path.write_text("".join(lines))
    refused(study, f"m.3.lin, line {k + 1}")


def test_truncated_linearisation(trial, refused):
    study = trial(rows=[ROW.format(wind=11.0, deck=DECK, mass="auto")], copy=COPY, wind=11.0)
    path = study.parent / "linearisation" / "turbine" / "U11" / "m.3.lin"
    text = path.read_text()
    path.write_text(text[: len(text) // 2])
    refused(study, "m.3.lin")


def test_pattern_that_matches_nothing(trial, refused):
    study = trial(rows=[ROW.format(wind=11.0, deck=DECK, mass="auto").replace("m.*", "n.*")], copy=COPY, wind=11.0)
    refused(study, "trial.fowt, line ", "no file matches", "n.*.lin")


def test_deck_of_another_model(trial, refused):
    """The file was made with HydroDyn but without moorings; the study's own deck has them."""
    study = trial(rows=[ROW.format(wind=11.0, deck='"input/oc4.fst"', mass="auto")], copy=COPY, wind=11.0)
    refused(study, "m.1.lin", "MAP++", "LinDeck")


# --- writing ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("blow", [KeyboardInterrupt, OSError(28, "No space left on device"), RuntimeError("bug")])
@pytest.mark.parametrize("there_before", [True, False])
def test_interrupted_writing_leaves_nothing(trial, cli, monkeypatch, blow, there_before):
    """The workbook, second of two files, fails: no file of the new run appears, those of the old stay, no temporary folder stays."""
    import fowtio.write.results as results

    study = trial()
    out = study.parent / "out"
    if there_before:
        out.mkdir()
        (out / "results.nc").write_bytes(b"results of yesterday")

    def fail(path, *_):
        Path(path).write_bytes(b"half")
        raise blow

    monkeypatch.setattr(results, "write_excel", fail)
    before = snapshot(study.parent)
    found = cli("run", study, "-o", out, "--no-figures")
    assert found.code == (130 if blow is KeyboardInterrupt else 1)
    assert found.err
    assert "Traceback" not in found.err
    assert snapshot(study.parent) == before
    assert not [p for p in study.parent.iterdir() if p.name.startswith(".")]
    assert out.exists() == there_before


def test_interrupted_init_leaves_nothing(cli, tmp_path, monkeypatch):
    copied = []

    def fail(source, target):
        copied.append(target)
        Path(target).mkdir(parents=True)
        raise KeyboardInterrupt

    monkeypatch.setattr(shutil, "copytree", fail)
    assert cli("init", tmp_path / "new").code == 130
    assert copied
    assert list(tmp_path.iterdir()) == []


def test_results_that_cannot_be_written(trial, cli):
    """A file where the results folder should be."""
    study = trial()
    (study.parent / "out").write_text("keep")
    found = cli("run", study, "-o", study.parent / "out", "--no-figures")
    assert found.code == 1
    assert "Traceback" not in found.err
    assert "internal error" not in found.err
    assert (study.parent / "out").read_text() == "keep"


def test_json_of_a_refused_study_stays_empty(trial, cli):
    """Whoever reads the document gets none, and the status says why."""
    study = trial()
    edit(study, "NFreq ", "NFrek ")
    found = cli("run", study, "--json")
    assert found.code == 1
    assert found.out == ""
    assert "NFrek" in found.err


def test_a_still_sea(trial, cli):
    """Nothing moves: no warning, no NaN in the document."""
    study = trial()
    edit(study, "jonswap      2.0       10.0  3.3 ", "still        -         -     -   ")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = cli("run", study, "--json", "--no-figures", "-o", study.parent / "out")
    assert found.code == 0, found.err
    assert '"std": 0.0' in found.out
    assert "NaN" not in found.out
