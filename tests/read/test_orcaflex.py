"""OrcaFlex vessel types in text files: conventions, points, damaged files."""

import os
from pathlib import Path

import numpy as np
import pytest
from hydro_samples import assert_equal, flips, put, synthetic, truncations
from hydro_writers import orcaflex_text

from fowtio.errors import FormatError
from fowtio.read.orcaflex import ORCAFLEX, read_orcaflex

# seventeen digits in the file; the arms of the move and the weight taken off are rounded in double precision
ROUNDING = 1e-13
CENTRE = (1.5, -2.5, -13.0)


def write(path: Path, text: str) -> Path:
    path.write_bytes(text.encode("utf-8"))
    return path


@pytest.mark.parametrize("point", [(0.0, 0.0, 0.0), (3.0, -2.0, -5.0)])
def test_read(tmp_path, point):
    got = read_orcaflex(write(tmp_path / "a.yml", orcaflex_text(synthetic(), point=point, centre=CENTRE)))
    assert_equal(got, synthetic(), ROUNDING)
    assert (got.density, got.depth, got.volume) == (1025.0, 80.0, 12345.0)
    np.testing.assert_array_equal(got.reference_point, 0)


@pytest.mark.parametrize(
    "conventions",
    [
        {"WavesReferredToBy": "period (s)"},
        {"WavesReferredToBy": "frequency (Hz)"},
        {"RAOPhaseConvention": "lags"},
        {"RAOPhaseUnitsConvention": "radians"},
        {"RAOPhaseRelativeToConvention": "trough"},
        {"RAOPhaseRelativeToConvention": "zero up-crossing"},
        {"RAOPhaseRelativeToConvention": "zero down-crossing", "RAOPhaseConvention": "lags"},
        {"RAOWaveUnit": "double amplitude"},
        {"SwayPositive": "starboard", "RollPositiveStarboard": "up", "HeavePositive": "down"},
        {"SurgePositive": "aft", "PitchPositiveBow": "up", "YawPositiveBow": "starboard"},
    ],
)
def test_the_conventions_that_the_file_states(tmp_path, conventions):
    got = read_orcaflex(write(tmp_path / "a.yml", orcaflex_text(synthetic(), conventions=conventions)))
    assert_equal(got, synthetic(), ROUNDING)


def test_wave_phase_at_another_origin(tmp_path):
    text = orcaflex_text(synthetic(depth=np.inf)).replace("PhaseOrigin: [~, ~, ~]", "PhaseOrigin: [0, 2, 0]")
    got = read_orcaflex(write(tmp_path / "a.yml", text))
    want = synthetic(depth=np.inf)
    k = want.omega**2 / want.gravity
    # heading 90 deg: the crest reaches y = 2 later than the origin, so forces timed by it lag by k times 2 m
    np.testing.assert_allclose(got.excitation[-1], want.excitation[-1] * np.exp(-2j * k)[:, None], rtol=1e-9)


def test_several_vessel_types_are_chosen_or_refused(tmp_path):
    path = write(tmp_path / "a.yml", orcaflex_text(synthetic(), types=("Barge", "Floater")))
    with pytest.raises(FormatError, match="1: Barge, 2: Floater"):
        read_orcaflex(path)
    assert_equal(read_orcaflex(path, body="Floater"), synthetic(), ROUNDING)
    assert_equal(read_orcaflex(path, body=1), synthetic(), ROUNDING)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("UnitsSystem: SI", "UnitsSystem: US", "UnitsSystem SI"),
        ("AMDMethod: Frequency dependent", "AMDMethod: Constant", "Frequency dependent"),
        ("RAOPhaseConvention: leads", "RAOPhaseConvention: ahead", "leads or lags"),
        ("WavesReferredToBy: frequency (rad/s)", "WavesReferredToBy: wave number", "period"),
        ("DisplacedVolume: 12345.0", "DisplacedVolume: many", "a number"),
        ("AMDPeriodOrFrequency: 0.3", "AMDPeriodOrFrequency: 0.31", "frequencies of the added mass"),
        ("    Draughts:", "   Draughts:", "indentation|expected"),
        ("VesselTypes:", "Vessel types:", "VesselTypes"),
    ],
)
def test_what_is_wrong_is_said(tmp_path, old, new, words):
    text = orcaflex_text(synthetic())
    assert old in text
    with pytest.raises(FormatError, match=words):
        read_orcaflex(write(tmp_path / "a.yml", text.replace(old, new, 1)))


def test_truncations_are_noticed(tmp_path):
    text = orcaflex_text(synthetic(n=3))
    whole = read_orcaflex(write(tmp_path / "a.yml", text))
    end = text.count("\n") - 5  # what follows the last damping matrix is not needed
    for count, cut in truncations(text):
        try:
            got = read_orcaflex(write(tmp_path / "a.yml", cut))
        except FormatError:
            assert count < end
            continue
        # the last block is the zero-frequency limit; without it as a whole the rest stands
        assert_equal(
            got, whole, 0.0, ("omega", "added_mass", "radiation_damping", "excitation", "hydrostatic_stiffness")
        )


def test_flipped_characters_give_errors_or_coefficients(tmp_path):
    text = orcaflex_text(synthetic(n=3))[1:]
    shape = synthetic(n=3).added_mass.shape
    for _, bent in flips(text, 200, seed=4, alphabet="0123456789.-+E:[] ,#"):
        try:
            got = read_orcaflex(write(tmp_path / "a.yml", bent))
        except FormatError:
            continue
        assert got.added_mass.shape == shape


def test_other_systems_and_recognition(tmp_path):
    text = orcaflex_text(synthetic())
    path = write(tmp_path / "a.yml", text.replace("\n", "\r\n"))
    assert_equal(read_orcaflex(path), synthetic(), ROUNDING)
    assert ORCAFLEX.recognises(path, path.read_bytes()[:65536])
    assert not ORCAFLEX.recognises(put(tmp_path / "b.yml", "a: 1\n"), b"a: 1\n")
    assert dict(ORCAFLEX.describe(read_orcaflex(path)))["headings"] == "4, -90 to 90 deg"


@pytest.mark.reference
@pytest.mark.skipif("FOWTIO_FORMATS" not in os.environ, reason="FOWTIO_FORMATS names no folder")
def test_real_file_of_a_box():
    """A box of 7 x 7 m, 10 m deep, at (-18.5, 18.5): hydrostatics in closed form, long waves by their path."""
    h = read_orcaflex(Path(os.environ["FOWTIO_FORMATS"]) / "orcaflex/orcawave_result.yml")
    weight = h.density * h.gravity
    assert h.hydrostatic_stiffness[2, 2] == pytest.approx(49 * weight, rel=1e-9)
    assert h.hydrostatic_stiffness[2, 3] == pytest.approx(49 * 18.5 * weight, rel=1e-9)
    assert h.hydrostatic_stiffness[3, 3] == pytest.approx(
        (7**4 / 12 + 49 * 18.5**2 - 490 * 5) * weight, rel=1e-3
    )  # mesh
    # heading 0, the box 18.5 m up-wave: the crest is there first, and the force leads by k x. That run was in deep
    # water, which the file's Environment (100 m) does not say
    force = h.excitation[0, 0]
    assert np.angle(force[2]) == pytest.approx(18.5 * h.omega[0] ** 2 / h.gravity, rel=1e-2)
    assert np.angle(force[0]) - np.angle(force[2]) == pytest.approx(np.pi / 2, abs=1e-3)
