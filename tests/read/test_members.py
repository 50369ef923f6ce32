"""Decks with members outside the potential flow: braces beside it, a whole spar of strips, what is refused."""

import shutil

import numpy as np
import openfast_samples as samples
import pytest

import fowtio
from fowtio.errors import FormatError
from fowtio.read.hydrodyn import drag_members
from fowtio.read.morison_elements import inertia_elements
from fowtio.read.openfast_deck import deck_hydro, read_deck
from fowtio.read.wamit import read_wamit
from fowtio.write.hydro import write_wamit
from model.system.hydro import excitation_at, radiation_at

BRACES = tuple(str(n) for n in (11, 12, 13, 17, 18, 19, 20, 21, 22))


def release(hydrodyn, names, coefficients=None):
    """Set PropPot False for members of a HydroDyn file, and columns of their coefficients (MCoefMod 3)."""
    out, columns = [], []
    for line in hydrodyn.read_text().splitlines():
        parts = line.split("!")[0].split()
        if parts[:2] == ["MemberID", "MemberCd1"]:
            columns = parts
        elif parts[-1:] == ["TRUE"] and len(parts) == 11 and parts[0] in names:
            line = "  ".join([*parts[:-1], "FALSE"])
        elif len(parts) == len(columns) > 11 and parts[0] in names:
            line = "  ".join(f"{(coefficients or {}).get(c.rstrip('12'), v)}" for c, v in zip(columns, parts, strict=True))
        out.append(line)
    hydrodyn.write_text("\n".join(out) + "\n")


@pytest.fixture
def fst(tmp_path):
    return samples.copy_deck(tmp_path / "deck")


def test_braces_float_as_the_hydrostatics_of_the_whole_hull_say(fst):
    # the embedded .hst is columns and braces by an independent integration (C33 380.10, C44 -37917, C55 -37917 over rho g); that
    # of the columns alone is 372.48, -33805.5, -33805.5; the published volume of 13917 m3 is rounded and counts no overlap twice
    release(fst.parent / "HydroDyn.dat", BRACES)
    braces = inertia_elements(read_deck(fst).hydrodyn.members, 1025.0, 9.80665)
    assert braces.names == BRACES
    found = braces.stiffness / (1025 * 9.80665)
    assert found[2, 2] == pytest.approx(380.1045 - 372.4751, rel=1e-4)  # figures as the files give them
    assert found[3, 3] == pytest.approx(-37917.19 + 33805.45, rel=1e-3)  # the leaning braces' cut is exact here
    assert found[4, 4] == pytest.approx(-37917.05 + 33805.45, rel=1e-3)
    assert braces.volume == pytest.approx(13917 - 13556.758, rel=0.01)


def test_nothing_is_counted_twice_when_members_leave_the_potential_flow(fst):
    before = deck_hydro(read_deck(fst))
    release(fst.parent / "HydroDyn.dat", BRACES, {"MemberCa": "0.63", "MemberCp": "1.0"})
    deck = read_deck(fst)
    after = deck_hydro(deck)
    members = inertia_elements(deck.hydrodyn.members, deck.density, deck.gravity)
    np.testing.assert_allclose(after.hydrostatic_stiffness - before.hydrostatic_stiffness, members.stiffness, atol=1e-6)
    assert after.volume - before.volume == pytest.approx(members.volume)
    omega = np.array([0.2, 0.6, 1.1])
    added, damping = (a - b for a, b in zip(radiation_at(after, omega), radiation_at(before, omega), strict=True))
    assert np.abs(damping).max() == 0
    # rho Ca pi D^2/4 L of three 26 m pontoons, three of 13.62 m and three 24.7 m braces at 0.79, all but horizontal: heave
    lengths = [np.linalg.norm(deck.hydrodyn.members.end[k] - deck.hydrodyn.members.start[k]) for k in range(25)]
    assert 0 < added[0, 2, 2] < 1025 * 0.63 * np.pi * 0.8**2 * sum(lengths)
    np.testing.assert_allclose(added[0], added[2], atol=1e-6 * np.abs(added).max())
    assert np.abs(excitation_at(after, omega, 0.0) - excitation_at(before, omega, 0.0)).max() > 0


def test_drag_does_not_ask_whether_a_member_is_in_the_potential_flow(fst):
    before = drag_members(read_deck(fst).hydrodyn.members, 1025.0)
    release(fst.parent / "HydroDyn.dat", BRACES)
    after = drag_members(read_deck(fst).hydrodyn.members, 1025.0)
    np.testing.assert_array_equal(after.factor, before.factor)
    np.testing.assert_array_equal(after.position, before.position)


def test_members_without_hydrostatics_do_not_float(fst):
    path = fst.parent / "HydroDyn.dat"
    release(path, BRACES)
    lines = [ln.split("!")[0].split() for ln in path.read_text().splitlines()]
    text = path.read_text().splitlines()
    for k, parts in enumerate(lines):
        if len(parts) == 11 and parts[-1] == "FALSE":
            text[k] = "  ".join([*parts[:9], "0", parts[10]])  # MHstLMod 0
    path.write_text("\n".join(text) + "\n")
    members = inertia_elements(read_deck(fst).hydrodyn.members, 1025.0, 9.80665)
    assert members.volume == 0
    assert not members.stiffness.any()


def test_diffraction_of_maccamy_and_fuchs_is_refused(fst):
    path = fst.parent / "HydroDyn.dat"
    release(path, BRACES)
    text = path.read_text().splitlines()
    at = next(k for k, line in enumerate(text) if line.startswith("SimplCd SimplCdMG"))
    text[at : at + 3] = [f"{text[at]} SimplMCF", f"{text[at + 1]} (-)", f"{text[at + 2]} T"]
    path.write_text("\n".join(text) + "\n")
    with pytest.raises(FormatError, match=r"HydroDyn.dat, line \d+: .*SimplMCF False.*PropPot True"):
        read_deck(fst)


def test_members_below_the_seabed_are_refused(fst):
    path = fst.parent / "HydroDyn.dat"
    release(path, ("1",))
    samples.replace(path, "0.00000      0.00000    -20.00000", "0.00000      0.00000   -220.00000")
    with pytest.raises(FormatError, match="above the seabed at -200 m"):
        deck_hydro(read_deck(fst))


@pytest.fixture(scope="module")
def strip_spar(tmp_path_factory, oc4_folder):
    """The OC3 spar without potential flow: three strips that share joints, added-mass coefficient of the definition of OC3; a disk's 4/3 rho R^3 at the end."""
    folder = tmp_path_factory.mktemp("spar")
    shutil.copytree(oc4_folder.parent / "oc3_spar" / "input", folder / "input")
    path = folder / "input" / "HydroDyn.dat"
    samples.set_value(path, "PotMod", "0")
    samples.replace(path, "    1     0.00     0.00     1.00 ", "    1     0.00     0.64     1.00 ")
    samples.replace(path, "       3         5         6           1           1 ", "       3         4         6           1           1 ")
    samples.replace(path, "       2         3         4           2           2 ", "       2         2         4           3           1 ")
    release(path, (), None)
    names = ("1", "2", "3")
    release(path, names, {"MemberCa": "0.969954", "MemberCp": "1.0", "MemberAxCp": "1.0"})
    return folder / "input" / "oc3.fst"


def test_a_spar_of_strips_has_the_published_periods(strip_spar):
    # NREL/TP-500-47535 gives Ca 0.969954 for the strip-theory form of this spar and a displaced volume of 8029 m3; periods of the
    # whole system published for OC3: surge 125, heave 30.9, pitch 29.5 s
    model = fowtio.build(fowtio.load(strip_spar))
    assert model.hydro.volume == pytest.approx(8029, rel=1e-3)
    modes = dict(zip(model.points[0].modes.names, 2 * np.pi / model.points[0].modes.frequency, strict=True))
    for name, published in (("surge", 125.0), ("heave", 30.9), ("pitch", 29.5)):
        assert modes[name] == pytest.approx(published, rel=0.03), (name, modes[name])


def test_strips_and_potential_flow_agree_on_a_slender_spar(strip_spar, oc4_folder):
    # k times the radius below 0.1: diffraction is within 2 % of the long-wave limit that strips have, Ca 0.97 against 0.98 to 1.0 by potential flow
    strips = deck_hydro(read_deck(strip_spar))
    panels = deck_hydro(read_deck(oc4_folder.parent / "oc3_spar" / "input" / "oc3.fst"))
    omega = np.array([0.2, 0.3, 0.4])
    a, b = (excitation_at(h, omega, 0.0) for h in (strips, panels))
    np.testing.assert_allclose(a[:, [0, 4]], b[:, [0, 4]], atol=0.05 * np.abs(b[:, [0, 4]]).max(axis=0).max())
    a, b = (radiation_at(h, omega)[0] for h in (strips, panels))
    assert a[0, 0, 0] == pytest.approx(b[0, 0, 0], rel=0.04)
    # strips know nothing of the flow around the lower end, which takes 5 % off in pitch, where its arm is longest
    assert a[0, 4, 4] == pytest.approx(b[0, 4, 4], rel=0.07)


def test_written_coefficients_hold_the_members(strip_spar, tmp_path):
    spar = deck_hydro(read_deck(strip_spar))
    write_wamit(spar, tmp_path / "spar")
    back = read_wamit(tmp_path / "spar", density=spar.density, gravity=spar.gravity, depth=spar.depth)
    omega, heading = spar.omega[[3, 11, 20]], spar.heading[[2, 6]]
    a, b = (excitation_at(h, omega, heading) for h in (spar, back))
    np.testing.assert_allclose(b, a, atol=2e-6 * np.abs(a).max())  # seven digits in the files
