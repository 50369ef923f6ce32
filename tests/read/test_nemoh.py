"""Nemoh folders: versions, units, points, several bodies, damaged files; the same ellipsoid from WAMIT."""

import os
import shutil
from pathlib import Path

import numpy as np
import pytest
from hydro_samples import assert_equal, flips, put, synthetic, truncations, variants
from hydro_writers import write_nemoh

from fowtio.errors import FormatError
from fowtio.read.nemoh import NEMOH, read_nemoh
from fowtio.read.wamit import read_wamit

SEVEN = 2e-7  # seven digits after the point of a leading digit: half a unit, twice for parts and arms
FIELDS = ("omega", "heading", "added_mass", "radiation_damping", "excitation", "hydrostatic_stiffness")
# the centre of gravity is the point of Nemoh's stiffness; three decimals hold these
CENTRE = (1.5, -2.5, -8.25)


@pytest.fixture
def folder(tmp_path):
    return write_nemoh(tmp_path / "run", synthetic(), centre=CENTRE)


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("point", [(0.0, 0.0, 0.0), (0.5, 0.25, -3.0)])
@pytest.mark.parametrize("wave_point", [(0.0, 0.0), (4.0, -1.0)])
def test_read(tmp_path, version, point, wave_point):
    run = write_nemoh(tmp_path / "run", synthetic(), point=point, centre=CENTRE, wave_point=wave_point, version=version)
    got = read_nemoh(run)
    assert_equal(got, synthetic(), SEVEN, FIELDS)
    assert got.volume == pytest.approx(12345.0)
    np.testing.assert_allclose(got.centre_of_buoyancy, (0.5, -0.25, -9.0))
    assert got.added_mass_infinite is None


@pytest.mark.parametrize("unit", ["rad/s", "Hz", "s"])
def test_units_of_the_first_column(tmp_path, unit):
    assert_equal(read_nemoh(write_nemoh(tmp_path / "run", synthetic(), unit=unit)), synthetic(), SEVEN, FIELDS)


def test_infinite_depth_is_written_as_zero(tmp_path):
    want = synthetic(depth=np.inf)
    got = read_nemoh(write_nemoh(tmp_path / "run", want, wave_point=(4.0, -1.0)))
    assert got.depth == np.inf
    assert_equal(got, want, SEVEN, FIELDS)


@pytest.mark.parametrize("name", ["Nemoh.cal", "results/ExcitationForce.tec", "results", "mesh/KH.dat"])
def test_any_file_of_the_folder_names_it(folder, name):
    assert_equal(read_nemoh(folder / name), synthetic(), SEVEN, FIELDS)


def test_phases_in_the_file_are_those_of_minus_i_omega_t(folder):
    """The long-wave surge force has phase -pi/2 in Nemoh's files and +pi/2 here."""
    lines = (folder / "results/ExcitationForce.tec").read_text().splitlines()
    row = lines[next(k for k, x in enumerate(lines) if "beta =   0.000" in x) + 1].split()
    assert float(row[2]) == pytest.approx(-np.pi / 2, abs=0.25)  # slices up to 20 m off the origin
    got = read_nemoh(folder)
    assert np.angle(got.excitation[1, 0, 0]) == pytest.approx(-float(row[2]), abs=1e-6)


def test_several_bodies_are_chosen_or_refused(tmp_path):
    run = write_nemoh(tmp_path / "run", synthetic(), centre=CENTRE, bodies=2)
    with pytest.raises(FormatError, match=r"one body.*2: 1, 2.*body="):
        read_nemoh(run)
    for body in (1, 2):
        assert_equal(read_nemoh(run, body=body), synthetic(), SEVEN, FIELDS)
    with pytest.raises(FormatError, match="body 3"):
        read_nemoh(run, body=3)


def test_what_is_not_there_is_left_out_or_refused(folder):
    shutil.rmtree(folder / "mesh")
    got = read_nemoh(folder)
    assert got.hydrostatic_stiffness is None
    assert got.volume is None
    (folder / "results/FKForce.tec").unlink()
    assert_equal(read_nemoh(folder), synthetic(), SEVEN, FIELDS[:-1])
    (folder / "results/ExcitationForce.tec").unlink()
    assert read_nemoh(folder).excitation is None
    (folder / "results/RadiationCoefficients.tec").unlink()
    with pytest.raises(FormatError, match=r"RadiationCoefficients\.tec"):
        read_nemoh(folder)


@pytest.mark.parametrize(
    ("name", "old", "new", "words"),
    [
        ("Nemoh.cal", "2 1. 0. 0.", "2 1. 1. 0.", "along x, y or z"),
        ("Nemoh.cal", "0.000000 0.000000 0.000000 ! about", "0.0 0.0 -9.0 ! about", "one point for all"),
        ("Nemoh.cal", "1 5\t", "1 6\t", "6 frequencies"),
        ("Nemoh.cal", "1.500000 !", "2.500000 !", "up to 2.5"),
        ("Nemoh.cal", "4 -90", "3 -90", "3 zones"),
        ("Nemoh.cal", "9.806650 !", "g !", "gravity"),
        ("results/RadiationCoefficients.tec", "w (rad/s)", "w", "rad/s"),
        ("results/RadiationCoefficients.tec", "I=     5", "I=     6", "6 rows"),
        ("results/ExcitationForce.tec", "beta", "alpha", "beta ="),
        ("mesh/Hydrostatics.dat", "ZG", "WG", "ZG"),
    ],
)
def test_what_is_wrong_is_said(folder, name, old, new, words):
    path = folder / name
    text = path.read_text()
    assert old in text
    if "about" in old:  # the last force only
        head, _, tail = text.rpartition(old)
        path.write_text(head + new + tail)
    else:
        path.write_text(text.replace(old, new, 1))
    with pytest.raises(FormatError, match=words):
        read_nemoh(folder)


def test_degrees_are_noticed(folder):
    path = folder / "results/ExcitationForce.tec"
    rows = [line if not line.strip()[:1].isdigit() else _in_degrees(line) for line in path.read_text().splitlines()]
    path.write_text("\n".join(rows) + "\n")
    with pytest.raises(FormatError, match="radians"):
        read_nemoh(folder)


def _in_degrees(line: str) -> str:
    values = np.array([float(v) for v in line.split()])
    values[2::2] = np.degrees(values[2::2])
    return "".join(f"{v:16.7E}" for v in values)


@pytest.mark.parametrize(
    "name",
    [
        "results/RadiationCoefficients.tec",
        "results/ExcitationForce.tec",
        "Nemoh.cal",
        "mesh/KH.dat",
        "mesh/Hydrostatics.dat",
    ],
)
def test_every_truncation_is_noticed(folder, name):
    path = folder / name
    text = path.read_text()
    needed = text.count("\n")
    if name == "Nemoh.cal":  # what follows the load cases is not needed
        needed -= 1
    if name == "mesh/Hydrostatics.dat":  # nor is the waterplane area
        needed -= 1
    for count, cut in truncations(text):
        put(path, cut)
        if count >= needed:
            read_nemoh(folder)
            continue
        with pytest.raises(FormatError):
            read_nemoh(folder)


def test_flipped_characters_of_the_excitation_are_noticed(folder):
    """The two parts and the total: what passes is small."""
    path = folder / "results/ExcitationForce.tec"
    text, want = path.read_text(), read_nemoh(folder)
    start = text.index("Zone")
    noticed = 0
    scale = np.repeat(np.abs(want.excitation).reshape(-1, 2, 3).max(axis=(0, 2)), 3)
    for _, bent in flips(text[start:], 150, seed=2):
        put(path, text[:start] + bent)
        try:
            got = read_nemoh(folder)
        except FormatError:
            noticed += 1
            continue
        if np.allclose(got.heading, want.heading):  # titles carry the heading once: a flip there cannot be seen
            assert (np.abs(got.excitation - want.excitation) / scale).max() < 2e-3  # twice the tolerance of the sum
    assert noticed > 50


def test_other_systems_and_spellings(folder):
    texts = {p: p.read_text() for p in folder.rglob("*") if p.is_file()}
    for kind in ("crlf", "bom", "no last line end"):
        for path, text in texts.items():
            put(path, dict(variants(text))[kind])
        assert_equal(read_nemoh(folder), synthetic(), SEVEN, FIELDS)
    for path, text in texts.items():
        if path.suffix == ".tec":
            start = text.index("Zone")
            put(path, text[:start] + text[start:].replace("E+", "D+").replace("E-", "D-"))
    assert_equal(read_nemoh(folder), synthetic(), SEVEN, FIELDS)


def test_recognition(folder):
    assert NEMOH.recognises(folder, b"")
    assert NEMOH.recognises(folder / "Nemoh.cal", b"")
    assert not NEMOH.recognises(folder / "mesh", b"")
    assert dict(NEMOH.describe(NEMOH.read(folder)))["headings"] == "4, -90 to 90 deg"


@pytest.mark.reference
@pytest.mark.skipif("FOWTIO_FORMATS" not in os.environ, reason="FOWTIO_FORMATS names no folder")
def test_the_same_ellipsoid_in_nemoh_and_wamit():
    """Two codes, two meshes: the sign convention shows, and the rest to the discretisation.

    Medians over the frequencies, because Nemoh has irregular frequencies at the upper end and WAMIT's run removed them.
    """
    root = Path(os.environ["FOWTIO_FORMATS"])
    nemoh = read_nemoh(root / "nemoh/ellipsoid")
    wamit = read_wamit(root / "wamit/ellipsoid", density=1000.0, gravity=9.81)
    np.testing.assert_allclose(nemoh.omega, wamit.omega, rtol=1e-5)
    for name, tolerance in (("added_mass", 0.01), ("radiation_damping", 0.015)):
        for i in range(5):
            a, b = getattr(nemoh, name)[:, i, i], getattr(wamit, name)[:, i, i]
            assert np.median(np.abs(a - b)) < tolerance * np.abs(b).max(), (name, i)
    for mode in (0, 2, 4):
        a, b = nemoh.excitation[0, :, mode], wamit.excitation[0, :, mode]
        assert np.median(np.abs(a - b)) < 0.005 * np.abs(b).max()
        assert np.median(np.abs(np.conj(a) - b)) > 0.02 * np.abs(b).max()  # the other sign would be plainly worse
