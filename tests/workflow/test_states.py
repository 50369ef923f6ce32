"""What the table of states may hold beside the common spectra: a spectrum from a file, the extreme turbulence model."""

import numpy as np
import pytest

import fowtio
from fowtio.errors import CaseError
from fowtio.workflow import state_wind
from model.environment.sea import SeaState, wave_spectrum
from model.environment.wind import turbulence_sigma


def rewrite(study, old, new):
    text = study.read_text()
    assert old in text
    study.write_text(text.replace(old, new))


def test_a_spectrum_from_a_file_is_that_sea(trial):
    study = trial(height=2.0)
    expected = fowtio.loads(fowtio.solve(fowtio.build(fowtio.load(study))))[0].statistics.std
    hertz = np.linspace(0.02, 0.9, 3000)
    density = wave_spectrum(SeaState(kind="jonswap", significant_height=2.0, peak_period=10.0, gamma=3.3), 2 * np.pi * hertz) * 2 * np.pi
    (study.parent / "buoy.csv").write_text("f (Hz),S (m2/Hz)\n# made by a test\n" + "\n".join(f"{f:.8g},{s:.8g}" for f, s in zip(hertz, density, strict=True)))
    rewrite(study, "jonswap      2.0       10.0  3.3", '"buoy.csv"   -         -     -')
    model = fowtio.build(fowtio.load(study))
    assert model.states[0].sea.kind == "table"
    found = fowtio.loads(fowtio.solve(model))[0].statistics.std
    np.testing.assert_allclose(found, expected, rtol=0.01, atol=1e-6 * expected.max())  # cut at 0.02 and 0.9 Hz, drag to 1e-3


@pytest.mark.parametrize(("text", "words"), [("0.1 2\n0.2 x\n", "line 2: expected two numbers"), ("0.2 1\n0.1 1\n", "must rise"), (None, "does not exist")])
def test_a_bad_file_is_named(trial, text, words):
    study = trial()
    if text is not None:
        (study.parent / "buoy.csv").write_text(text)
    rewrite(study, "jonswap      2.0       10.0  3.3", '"buoy.csv"   -         -     -')
    with pytest.raises(CaseError, match=words):
        fowtio.load(study)


def test_extreme_turbulence(oc4_folder, tmp_path):
    text = (oc4_folder / "oc4.fowt").read_text()
    for part in ("input", "linearisation", "reference"):
        (tmp_path / part).symlink_to(oc4_folder / part)
    old = "operating     11.0       B           jonswap"
    assert old in text
    (tmp_path / "x.fowt").write_text(text.replace(old, old.replace("B    ", "ETM-B")))
    model = fowtio.build(fowtio.load(tmp_path / "x.fowt"), speeds=[11.0])
    state = next(s for s in model.states if s.name == "operating")
    assert state.turbulence == "ETM-B"
    wind = state_wind(model, state)
    # IEC 61400-1 ed. 3 eq. 19: sigma1 = c Iref (0.072 (Vave/c + 3)(Vhub/c - 4) + 10), c = 2 m/s, class I: Vave = 10 m/s, Iref = 0.14
    expected = 2 * 0.14 * (0.072 * (10 / 2 + 3) * (11 / 2 - 4) + 10)
    assert turbulence_sigma(wind.turbulence_class, wind.turbulence_model, wind.mean_speed, wind.wind_class) == pytest.approx(expected, rel=1e-12)


def test_published_periods_stand_beside_the_models(cli, oc4_folder):
    found = cli("modes", oc4_folder.parent / "mit_tlp" / "tlp.fowt")
    assert found.code == 0
    table = found.out[found.out.index("Natural periods against published ones") :]
    row = next(line for line in table.splitlines() if line.startswith("Surge")).replace("−", "-").split()
    published, own, own_difference, infinite, infinite_difference = map(float, row[1:6])
    assert published == 60.6
    assert own_difference == pytest.approx(100 * (own / published - 1), abs=0.1)
    assert infinite_difference == pytest.approx(100 * (infinite / published - 1), abs=0.1)


def test_a_published_period_of_no_mode_is_named(trial):
    study = trial()
    rewrite(study, "END of study", "------ PUBLISHED\n2  NPub - rows\nMode  Period\n(-)  (s)\nsurge  125\nsurgee  0\nEND of study")
    with pytest.raises(CaseError, match="Mode is 'surgee', expected one of surge"):
        fowtio.load(study)
