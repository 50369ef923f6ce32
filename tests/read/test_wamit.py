"""WAMIT .1, .2, .3, .hst: scales, conventions, orders, damaged files."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hydro_samples import assert_equal, flips, put, synthetic, truncations, variants

from fowtio.errors import FormatError
from fowtio.read.wamit import (
    WAMIT_EXCITATION,
    WAMIT_HYDROSTATICS,
    WAMIT_RADIATION,
    WAMIT_SET,
    read_wamit,
    read_wamit_excitation,
    read_wamit_hydrostatics,
    read_wamit_radiation,
)
from fowtio.write.hydro import write_wamit
from model.conventions import weight_stiffness

# seven printed digits: half a unit in the last place of a mantissa near 1, for A, and for B also that of the period
SEVEN = 1e-6
WATER = {"density": 1025.0, "gravity": 9.80665, "depth": 80.0}


@pytest.fixture
def stem(tmp_path):
    write_wamit(synthetic(), tmp_path / "body")
    return tmp_path / "body"


def edit(stem: Path, suffix: str, change) -> None:
    path = Path(f"{stem}{suffix}")
    path.write_text("\n".join(change(path.read_text().splitlines())) + "\n")


def test_written_files_read_back(stem):
    assert_equal(read_wamit(stem, **WATER), synthetic(), SEVEN)


@pytest.mark.parametrize("suffix", [".1", ".3", ".hst", ".HST", ""])
def test_any_member_names_the_set(stem, suffix):
    assert_equal(read_wamit(f"{stem}{suffix}", **WATER), synthetic(), SEVEN)


def test_length_density_gravity_scale_as_the_manual_says(tmp_path):
    """A file of ones: A = rho L^k, k = 3, 4, 5; B = rho L^k omega; X = rho g L^2 or L^3; C = rho g L^(k - 1)."""
    pairs = [(i, j) for i in range(1, 7) for j in range(1, 7)]
    put(tmp_path / "one.1", "".join(f"{t} {i} {j} 1.0 1.0\n" for t in (4.0, 8.0) for i, j in pairs))
    put(tmp_path / "one.3", "".join(f"{t} 0.0 {i} 1.0 90.0 0.0 1.0\n" for t in (4.0, 8.0) for i in range(1, 7)))
    put(tmp_path / "one.hst", "".join(f"{i} {j} 1.0\n" for i, j in pairs))
    length, density, gravity = 3.0, 1000.0, 10.0
    h = read_wamit(tmp_path / "one", length=length, density=density, gravity=gravity)
    rotations = np.repeat([0, 1], 3)
    k = rotations[:, None] + rotations
    omega = 2 * np.pi / np.array([8.0, 4.0])
    np.testing.assert_allclose(h.omega, omega)
    np.testing.assert_allclose(h.added_mass[0], density * length ** (3.0 + k))
    np.testing.assert_allclose(h.radiation_damping[1], density * omega[1] * length ** (3.0 + k))
    np.testing.assert_allclose(h.excitation[0, 0], 1j * density * gravity * length ** (2.0 + rotations))
    np.testing.assert_allclose(h.hydrostatic_stiffness, density * gravity * length ** (2.0 + k))


def test_a_length_scale_and_its_inverse(tmp_path):
    want = synthetic(density=1000.0, gravity=9.81)
    write_wamit(want, tmp_path / "scaled", length=7.5)
    assert_equal(read_wamit(tmp_path / "scaled", length=7.5, density=1000.0, gravity=9.81, depth=80.0), want, SEVEN)


@pytest.mark.parametrize("seed", range(3))
def test_rows_in_any_order(stem, seed):
    for suffix in (".1", ".3", ".hst"):
        edit(stem, suffix, lambda lines: list(np.random.default_rng(seed).permutation(lines)))
    assert_equal(read_wamit(stem, **WATER), synthetic(), SEVEN)


@pytest.mark.parametrize("keep", [np.less_equal, np.greater_equal])
def test_a_triangle_is_filled_from_its_mirror(stem, keep):
    def triangle(columns):
        return lambda lines: [x for x in lines if keep(*(int(x.split()[c]) for c in columns))]

    edit(stem, ".1", triangle((1, 2)))
    assert_equal(read_wamit(stem, **WATER), synthetic(), SEVEN)
    full = read_wamit_hydrostatics(f"{stem}.hst")
    edit(stem, ".hst", triangle((0, 1)))
    half = read_wamit_hydrostatics(f"{stem}.hst")
    np.testing.assert_array_equal(half, half.T)
    kept = keep(*np.indices((6, 6)))
    np.testing.assert_array_equal(half[kept], full[kept])


def test_limits_may_be_missing(stem):
    edit(stem, ".1", lambda lines: [x for x in lines if float(x.split()[0]) > 0])
    h = read_wamit(stem, **WATER)
    assert h.added_mass_zero is None
    assert h.added_mass_infinite is None


def test_period_zero_is_infinite_frequency_and_minus_one_zero_frequency(stem):
    data, want = read_wamit_radiation(f"{stem}.1"), synthetic()
    np.testing.assert_allclose(data.added_mass[data.period == 0][0] * 1025, want.added_mass_infinite, rtol=SEVEN)
    np.testing.assert_allclose(data.added_mass[data.period == -1][0] * 1025, want.added_mass_zero, rtol=SEVEN)


def test_exchanged_limits_are_noticed(stem):
    swap = {"-1.000000E+00": " 0.000000E+00", "0.000000E+00": "-1.000000E+00"}
    edit(stem, ".1", lambda lines: [swap.get(x.split()[0], x.split()[0]) + x[14:] for x in lines])
    with pytest.raises(FormatError, match="exchanged"):
        read_wamit(stem, **WATER)


def test_first_column_in_radians_per_second(stem):
    def to_omega(lines):
        return [
            f"{2 * np.pi / t if t > 0 else t:.9E} {rest}" for t, rest in ((float(x.split()[0]), x[14:]) for x in lines)
        ]

    edit(stem, ".1", to_omega)
    edit(stem, ".3", to_omega)
    assert_equal(read_wamit(stem, frequency="omega", **WATER), synthetic(), SEVEN)


@pytest.mark.parametrize("frequency", ["wavenumber", "Hz"])
def test_wave_numbers_are_refused(stem, frequency):
    with pytest.raises(FormatError, match="IPEROUT"):
        read_wamit(stem, frequency=frequency, **WATER)


def test_headings_are_degrees_and_phases_lead(stem):
    data = read_wamit_excitation(f"{stem}.3")
    np.testing.assert_allclose(data.heading, [-90, 0, 45, 90])
    h = read_wamit(stem, **WATER)
    np.testing.assert_allclose(h.heading, np.radians([-90, 0, 45, 90]))
    columns = np.loadtxt(f"{stem}.3")
    surge = columns[(columns[:, 1] == 0) & (columns[:, 2] == 1)]
    # long waves push surge a quarter before the crest reaches the origin: the phase column says about +90 deg
    assert abs(surge[0, 4] - 90) < 15  # the synthetic slices lie up to 20 m off the origin: k x at 0.3 rad/s is 0.2 rad
    force = h.excitation[1, :, 0]
    np.testing.assert_allclose(np.degrees(np.angle(force)), surge[:, 4], atol=1e-4)  # seven digits of 90 deg


def test_haskind_file_is_used_when_there_is_no_other(stem):
    Path(f"{stem}.3").rename(f"{stem}.2")
    assert_equal(read_wamit(stem, **WATER), synthetic(), SEVEN)


def test_weight_in_the_hydrostatics_is_taken_off(tmp_path):
    want = synthetic()
    mass, centre = 1.1e7, (1.0, -2.0, -13.0)
    with_weight = replace(
        want, hydrostatic_stiffness=want.hydrostatic_stiffness + weight_stiffness(mass, centre, 9.80665)
    )
    write_wamit(with_weight, tmp_path / "body")
    assert_equal(
        read_wamit(tmp_path / "body", weight=(mass, centre), **WATER), want, 1e-5
    )  # a difference of larger numbers


def renumbered(lines, columns, shift):
    """Return rows whose mode columns are raised by `shift`: the same body as the second of two."""
    rows = [x.split() for x in lines]
    for row in rows:
        for c in columns:
            row[c] = str(int(row[c]) + shift)
    return ["  ".join(row) for row in rows]


def test_several_bodies_are_chosen_or_refused(stem):
    for suffix, columns in ((".1", (1, 2)), (".3", (2,)), (".hst", (0, 1))):
        edit(stem, suffix, lambda lines, c=columns: lines + renumbered(lines, c, 6))
    with pytest.raises(FormatError, match=r"line \d+.*body="):
        read_wamit(stem, **WATER)
    for body in (1, 2):
        assert_equal(read_wamit(stem, body=body, **WATER), synthetic(), SEVEN)
    with pytest.raises(FormatError, match="modes of body 1, 2 only"):
        read_wamit(stem, body=3, **WATER)


def test_only_added_mass_is_needed(stem):
    Path(f"{stem}.3").unlink()
    Path(f"{stem}.hst").unlink()
    h = read_wamit(stem, **WATER)
    assert h.excitation is None
    assert h.hydrostatic_stiffness is None
    Path(f"{stem}.1").unlink()
    with pytest.raises(FormatError, match="does not exist"):
        read_wamit(stem, **WATER)


def test_other_periods_in_the_excitation_are_refused(stem):
    edit(stem, ".3", lambda lines: lines[: len(lines) * 4 // 5])  # the last of five frequencies is gone as a whole
    with pytest.raises(FormatError, match="5 finite periods"):
        read_wamit(stem, **WATER)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("E+0", "D+0"),  # Fortran double precision
        (" ", "\t"),
        ("E-01 ", "e-01 "),
    ],
)
def test_other_spellings_of_numbers(stem, old, new):
    for suffix in (".1", ".3", ".hst"):
        edit(stem, suffix, lambda lines: [x.replace(old, new) for x in lines])
    assert_equal(read_wamit(stem, **WATER), synthetic(), SEVEN)


def test_merged_columns_and_bare_exponents(stem):
    text = Path(f"{stem}.3").read_text()
    parts = [x.split() for x in text.splitlines()]
    merged = ["  ".join(p[:5]) + "  " + "".join(f"{float(v):+.6E}" for v in p[5:]) for p in parts]
    edit(stem, ".3", lambda _: merged)
    assert_equal(read_wamit(stem, **WATER), synthetic(), SEVEN)
    # row 71 is element 6,5 of the infinite-frequency added mass
    edit(stem, ".1", lambda lines: [" 0.0 6 5 1.25-101" if k == 70 else x for k, x in enumerate(lines)])
    data = read_wamit_radiation(f"{stem}.1")
    assert data.added_mass[data.period == 0][0, 5, 4] == 1.25e-101


def test_heading_line_and_other_systems_text(stem):
    for suffix in (".1", ".3", ".hst"):
        path = Path(f"{stem}{suffix}")
        text = " WAMIT Numeric Output -- Filename  body\xe9.1    06-Dec-2016  12:55:04\n" + path.read_text()
        put(path, text)  # Latin-1
    assert_equal(read_wamit(stem, **WATER), synthetic(), SEVEN)


def test_line_ends_and_marks_of_other_systems(stem):
    texts = {s: Path(f"{stem}{s}").read_text() for s in (".1", ".3", ".hst")}
    for kind in ("crlf", "bom", "no last line end"):
        for suffix, text in texts.items():
            put(Path(f"{stem}{suffix}"), dict(variants(text))[kind])
        assert_equal(read_wamit(stem, **WATER), synthetic(), SEVEN)


@pytest.mark.parametrize(
    ("suffix", "line", "old", "new", "words"),
    [
        (".1", 80, None, " 5.0 1 2 NaN 1.0", "line 80.*finite"),
        (".1", 80, None, " 5.0 1 2 ***** 1.0", "line 80"),
        (".1", 80, None, " 5.0 1 2 1.0", "line 80.*5 columns"),
        (".1", 80, None, " 5.0 0 2 1.0 1.0", "line 80.*mode number"),
        (".1", 80, None, " 5.0 1.5 2 1.0 1.0", "line 80.*mode number"),
        (".1", 80, None, " 5.0 1 7 1.0 1.0", "line 80.*modes 1 to 6.*mode 7"),
        (".3", 7, None, " 1.0 0.0 1 2.0", "line 7.*7 columns"),
        (".3", 7, None, "spam", "line 7"),
        (".hst", 5, None, " 1 5", "line 5"),
    ],
)
def test_a_bad_line_is_named(stem, suffix, line, old, new, words):
    edit(stem, suffix, lambda lines: lines[: line - 1] + [new] + lines[line:])
    with pytest.raises(FormatError, match=words):
        read_wamit(stem, **WATER)


def test_a_repeated_element_is_refused(stem):
    edit(stem, ".1", lambda lines: lines + lines[100:101])
    with pytest.raises(FormatError, match="twice"):
        read_wamit(stem, **WATER)


def test_every_truncation_is_noticed(stem):
    text = Path(f"{stem}.3").read_text()
    whole = read_wamit(stem, **WATER)
    for _, cut in truncations(text):
        put(Path(f"{stem}.3"), cut)
        with pytest.raises(FormatError):
            read_wamit(stem, **WATER)
    put(Path(f"{stem}.3"), text)
    text = Path(f"{stem}.1").read_text()
    for _, cut in truncations(text):
        put(Path(f"{stem}.1"), cut)
        with pytest.raises(FormatError):
            read_wamit(stem, **WATER)  # at whole periods the .3 file has more of them
    put(Path(f"{stem}.1"), text)
    text = Path(f"{stem}.hst").read_text()
    for _, cut in truncations(text):
        put(Path(f"{stem}.hst"), cut)
        with pytest.raises(FormatError):
            read_wamit(stem, **WATER)
    put(Path(f"{stem}.hst"), text)
    assert_equal(read_wamit(stem, **WATER), whole, 0.0)


def test_a_flipped_character_of_the_excitation_is_noticed_or_harmless(stem):
    """Modulus and phase against the parts, counts and indices leave nothing beyond the 1 % that the check allows."""
    path = Path(f"{stem}.3")
    text, want = path.read_text(), read_wamit_excitation(path)
    noticed = 0
    for place, bent in flips(text, 300):
        put(path, bent)
        try:
            got = read_wamit_excitation(path)
        except FormatError:
            noticed += 1
            continue
        assert got.force.shape == want.force.shape, place
        allowed = 1e-2 * np.abs(want.force) + 1e-5 * np.abs(want.force).max()
        assert np.all(np.abs(got.force - want.force) <= 1.1 * allowed), place
        np.testing.assert_array_equal(got.heading, want.heading)
    assert noticed > 100


def test_a_flipped_character_of_the_added_mass_is_an_error_or_a_number(stem):
    """Nothing but FormatError comes out; indices and periods cannot change without notice."""
    path = Path(f"{stem}.1")
    text, want = path.read_text(), read_wamit_radiation(path)
    for _, bent in flips(text, 300, seed=3):
        put(path, bent)
        try:
            got = read_wamit_radiation(path)
        except FormatError:
            continue
        np.testing.assert_array_equal(got.period, want.period)
        different = (got.added_mass != want.added_mass) | (got.damping != want.damping)
        assert np.count_nonzero(different) <= 1  # one number bent, not two exchanged


def test_one_bent_coupling_is_noticed(tmp_path):
    want = synthetic(n=9)
    added = np.array(want.added_mass)
    added[4, 0, 1] += 0.5 * np.sqrt(added[4, 0, 0] * added[4, 1, 1])
    write_wamit(replace(want, added_mass=added), tmp_path / "body")
    with pytest.raises(FormatError, match="added mass 1,2 and 2,1"):
        read_wamit(tmp_path / "body", **WATER)


def test_a_negative_damping_is_noticed(tmp_path):
    want = synthetic()
    write_wamit(replace(want, radiation_damping=-want.radiation_damping), tmp_path / "body")
    with pytest.raises(FormatError, match="not negative"):
        read_wamit(tmp_path / "body", **WATER)


def test_recognition_and_description(stem):
    formats = {".1": WAMIT_RADIATION, ".3": WAMIT_EXCITATION, ".hst": WAMIT_HYDROSTATICS}
    for suffix, own in formats.items():
        path = Path(f"{stem}{suffix}")
        head = path.read_bytes()[:65536]
        assert [f for f in formats.values() if f.recognises(path, head)] == [own]
        assert all(isinstance(text, str) for _, text in own.describe(own.read(path)))
    assert WAMIT_SET.recognises(stem, b"")
    rows = dict(WAMIT_SET.describe(read_wamit(stem, **WATER)))
    assert rows["frequencies"] == "5, 0.3 to 1.5 rad/s"
    assert rows["limits of added mass"] == "zero and infinite frequency"
    assert rows["headings"] == "4, -90 to 90 deg"


@pytest.mark.reference
@pytest.mark.skipif("FOWTIO_FORMATS" not in os.environ, reason="FOWTIO_FORMATS names no folder")
@pytest.mark.parametrize("name", ["ellipsoid", "iti_barge", "oc3_spar", "oc4_marin_semi"])
def test_real_files(name):
    h = read_wamit(Path(os.environ["FOWTIO_FORMATS"]) / "wamit" / name, density=1025.0)
    diagonal = np.abs(np.diagonal(h.added_mass, axis1=1, axis2=2)).max(axis=0)  # a moonpool's may be negative somewhere
    size = np.sqrt(np.outer(diagonal, diagonal)) + 1e-9 * diagonal.max()
    # reciprocity, to the discretisation of those runs
    assert (np.abs(h.added_mass - np.swapaxes(h.added_mass, 1, 2)) / size).max() < 0.05
    if h.excitation is not None:
        at = int(np.argmin(np.abs(h.heading)))
        assert np.degrees(np.angle(h.excitation[at, 0, 0])) == pytest.approx(90, abs=1)
        # long waves lift with the waterplane: the heave force is the heave stiffness, to k times the draft and to the
        # heave added mass (at 0.05 rad/s and 120 m of draft 3 %)
        assert h.excitation[at, 0, 2].real == pytest.approx(h.hydrostatic_stiffness[2, 2], rel=0.1)
