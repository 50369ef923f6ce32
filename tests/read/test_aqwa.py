"""AQWA .AH1 and .LIS: reference point, wave phase, structures, damaged files."""

import os
from pathlib import Path

import numpy as np
import pytest
from hydro_samples import FIELDS, assert_equal, flips, put, synthetic, truncations, variants
from hydro_writers import ah1_text, lis_text

from fowtio.errors import FormatError
from fowtio.read.aqwa import AQWA_AH1, read_aqwa, read_aqwa_ah1
from fowtio.read.aqwa_lis import AQWA_LIS, read_aqwa_lis

CENTRE = (1.5, -2.5, -8.25)
AH1 = {"excitation": 2e-4}  # phases to a hundredth of a degree
LIS = {"excitation": 8e-3}  # three digits of amplitudes
FIVE = 1e-4  # five digits of matrices, and the moment arms of the move to the origin
TEXTS = {"AH1": (ah1_text, AH1), "LIS": (lis_text, LIS)}


def body(**changes):
    return synthetic(gravity=9.81, **changes)


@pytest.mark.parametrize("kind", TEXTS)
@pytest.mark.parametrize("centre", [(0.0, 0.0, 0.0), CENTRE])
def test_read(tmp_path, kind, centre):
    text, looser = TEXTS[kind]
    got = read_aqwa(put(tmp_path / f"a.{kind}", text(body(), centre)))
    assert_equal(got, body(), FIVE, **looser)
    assert got.volume == pytest.approx(12345.0, rel=1e-4)  # five digits
    np.testing.assert_allclose(got.centre_of_buoyancy, (0.5, -0.25, -9.0))
    np.testing.assert_array_equal(got.reference_point, 0)


@pytest.mark.parametrize("kind", TEXTS)
def test_many_headings_and_frequencies_go_on_over_lines(tmp_path, kind):
    want = body(n=13, headings=np.arange(-180.0, 181.0, 30.0))
    text, looser = TEXTS[kind]
    assert_equal(read_aqwa(put(tmp_path / "a", text(want, CENTRE))), want, FIVE, **looser)


def test_a_lag_of_ninety_degrees_is_a_lead_of_minus_ninety(tmp_path):
    """AQWA's surge force of long waves along +x has phase -90: the body is pushed before the crest comes."""
    lines = ah1_text(body(), (0.0, 0.0, 0.0)).splitlines()
    first = lines.index("FORCERAO") + 1 + 2 * 5  # the second heading is 0 deg, its first frequency
    assert float(lines[first + 1].split()[0]) == pytest.approx(-90, abs=15)  # slices up to 20 m from the origin
    got = read_aqwa(put(tmp_path / "a.AH1", "\n".join(lines)))
    assert np.degrees(np.angle(got.excitation[1, 0, 0])) == pytest.approx(90, abs=15)


def test_wave_phase_is_moved_from_the_centre_of_gravity(tmp_path):
    """A force in phase with a crest at (0, 2, -1), 90 deg heading, lags a crest at the origin by k times 2 m."""
    text = ah1_text(body(depth=1e6), (0.0, 0.0, 0.0)).replace(
        "COG\n  1             0.000       0.000", "COG\n  1             0.000       2.000"
    )
    plain = read_aqwa(put(tmp_path / "a.AH1", ah1_text(body(depth=1e6))))
    moved = read_aqwa(put(tmp_path / "b.AH1", text))
    k = plain.omega**2 / plain.gravity  # deep water
    ratio = moved.excitation[-1, :, 2] / plain.excitation[-1, :, 2]
    np.testing.assert_allclose(ratio, np.exp(-2j * k), atol=1e-9)
    np.testing.assert_allclose(moved.excitation[1, :, 2], plain.excitation[1, :, 2], rtol=1e-9)  # heading 0: no path


@pytest.mark.parametrize("kind", TEXTS)
def test_several_structures_are_chosen_or_refused(tmp_path, kind):
    text, looser = TEXTS[kind]
    path = put(tmp_path / f"a.{kind}", text(body(), CENTRE, structures=2))
    with pytest.raises(FormatError, match="body="):
        read_aqwa(path)
    for structure in (1, 2):
        assert_equal(read_aqwa(path, body=structure), body(), FIVE, **looser)
    with pytest.raises(FormatError, match="structure 3"):
        read_aqwa(path, body=3)


def test_old_general_line_without_the_structure(tmp_path):
    text = ah1_text(body(), CENTRE).replace("GENERAL\n  1  ", "GENERAL\n     ")
    assert_equal(read_aqwa(put(tmp_path / "a.AH1", text)), body(), FIVE, **AH1)


def test_without_limits_and_parts(tmp_path):
    got = read_aqwa(put(tmp_path / "a.LIS", lis_text(body(), CENTRE, limits=False, parts=False)))
    assert got.added_mass_zero is None
    assert got.added_mass_infinite is None
    text = ah1_text(body(), CENTRE)
    a, b = text.index("ADDEDMASS_LF"), text.index("FIDD")
    assert read_aqwa(put(tmp_path / "a.AH1", text[:a] + text[b:])).added_mass_infinite is None


def test_parts_that_do_not_add_up_are_noticed(tmp_path):
    text = lis_text(body(), CENTRE)
    mark = text.index("DIFFRACTION FORCES-VARIATION")
    row = text.index("20.94", mark)  # the period of 0.3 rad/s
    end = text.index("\n", row)
    words = text[row:end].split()
    words[5] = f"{10 * float(words[5]):.2E}"  # sway amplitude at heading -90
    with pytest.raises(FormatError, match="sum of Froude-Krylov"):
        read_aqwa(put(tmp_path / "a.LIS", text[:row] + "  ".join(words) + text[end:]))


@pytest.mark.parametrize("kind", TEXTS)
def test_texts_of_other_systems(tmp_path, kind):
    text, looser = TEXTS[kind]
    for name, data in variants(text(body(), CENTRE)):
        assert_equal(read_aqwa(put(tmp_path / name, data)), body(), FIVE, **looser)
    latin = text(body(), CENTRE).replace("DATE", "DAT\xe9").replace("JOB AQWA", "JOB AQW\xc5")
    assert_equal(read_aqwa(put(tmp_path / "latin", latin)), body(), FIVE, **looser)


def test_every_truncation_of_the_database_is_noticed(tmp_path):
    text = ah1_text(body(n=3), CENTRE)
    for _, cut in truncations(text):
        with pytest.raises(FormatError):
            read_aqwa_ah1(put(tmp_path / "a.AH1", cut))


def test_truncations_of_the_listing_are_noticed_or_harmless(tmp_path):
    """What comes last (motions, the limits) may be missing; nothing else may change."""
    text = lis_text(body(n=3), CENTRE)
    whole = read_aqwa_lis(put(tmp_path / "a.LIS", text))
    total = text[: text.index("R.A.O.S-VARIATION")].count("\n")
    for count, cut in truncations(text, step=2):
        try:
            got = read_aqwa_lis(put(tmp_path / "a.LIS", cut))
        except FormatError:
            continue
        assert count >= total - 6  # all rows of the table of forces
        assert_equal(got, whole, 0.0, [f for f in FIELDS if f not in ("added_mass_zero", "added_mass_infinite")])


@pytest.mark.parametrize("kind", TEXTS)
def test_flipped_characters_give_errors_or_coefficients(tmp_path, kind):
    text = TEXTS[kind][0](body(n=3), CENTRE)
    whole = read_aqwa(put(tmp_path / "whole", text))
    noticed = 0
    for _, bent in flips(text, 120, seed=11):
        try:
            got = read_aqwa(put(tmp_path / "bent", bent))
        except FormatError:
            noticed += 1
            continue
        assert got.added_mass.shape == whole.added_mass.shape
        np.testing.assert_allclose(got.heading, whole.heading, atol=4)  # a digit of a heading, in one place only
    assert noticed > 10


@pytest.mark.parametrize(
    ("kind", "old", "new", "words"),
    [
        ("AH1", "GENERAL", "GENERIC", "GENERAL"),
        ("AH1", "FORCERAO\n  1  1   1", "FORCERAO\n  1  1   2", "indices 1 1 1"),
        ("AH1", "ADDEDMASS\n  1  1   1", "ADDEDMASS\n  1  2   1", "indices 1 1 1"),
        ("AH1", "DAMPING\n", "DAMPING\n\n  1 2 3\n", "matrix"),
        ("AH1", "  1  4   5", "  1  4   6", "6 frequencies"),
        ("AH1", "E+06", "*****", "line"),
        ("LIS", "WATER  DEPTH", "WATER  TABLE", "WATER DEPTH"),
        ("LIS", "MESH BASED", "MASS BASED", "MESH BASED DISPLACEMENT"),
        ("LIS", "CENTRE OF GRAVITY", "MIDDLE OF GRAVITY", "CENTRE OF GRAVITY"),
        ("LIS", "           RX", "           RQ", "row RX"),
    ],
)
def test_what_is_wrong_is_said(tmp_path, kind, old, new, words):
    text = TEXTS[kind][0](body(), CENTRE)
    assert old in text
    with pytest.raises(FormatError, match=words):
        read_aqwa(put(tmp_path / f"a.{kind}", text.replace(old, new, 1)))


def test_other_texts_are_refused(tmp_path):
    with pytest.raises(FormatError, match="WATER DEPTH"):
        read_aqwa(put(tmp_path / "a.LIS", "hello\nworld\n"))


def test_recognition(tmp_path):
    for kind, own, other in (("AH1", AQWA_AH1, AQWA_LIS), ("LIS", AQWA_LIS, AQWA_AH1)):
        path = put(tmp_path / "a.dat", TEXTS[kind][0](body()))
        assert own.recognises(path, path.read_bytes()[:65536])
        assert not other.recognises(path, path.read_bytes()[:65536])
        assert all(isinstance(text, str) for _, text in own.describe(own.read(path)))


@pytest.mark.reference
@pytest.mark.skipif("FOWTIO_FORMATS" not in os.environ, reason="FOWTIO_FORMATS names no folder")
def test_real_listing_of_a_box():
    """A box of 2 x 2 m, 2 m deep, centred at (0, 2): hydrostatics in closed form, forces by its symmetry."""
    h = read_aqwa(Path(os.environ["FOWTIO_FORMATS"]) / "aqwa/box1.LIS")
    weight = h.density * h.gravity
    c = np.zeros((6, 6))
    c[2, 2], c[2, 3], c[3, 2] = 4, 8, 8
    c[3, 3], c[4, 4], c[4, 5] = 4 / 3 + 16 - 8, 4 / 3 - 8, -16
    np.testing.assert_allclose(
        h.hydrostatic_stiffness, weight * c, atol=1e-4 * weight
    )  # its mesh gives 1e-6 of asymmetry
    at = {round(np.degrees(b)): m for m, b in enumerate(h.heading)}
    # with the crest at the origin the two headings along y differ by the path to y = 2, twice k y
    k = h.omega**2 / h.gravity
    deep = slice(2, None)  # at 70 m the two higher frequencies are in deep water to 0.1 %
    path = np.angle(h.excitation[at[-90], deep, 2] / h.excitation[at[90], deep, 2])
    np.testing.assert_allclose(path, 4 * k[deep], rtol=5e-3)  # phases of 0.01 deg of 11 deg, depth
    surge = np.degrees(np.angle(h.excitation[at[0], :, 0]))
    np.testing.assert_allclose(surge, 90, atol=0.25)
