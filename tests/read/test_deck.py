"""Decks: the embedded one, layouts of OpenFAST 2 to 5 made from it, ballast, what is refused with file and line."""

import re

import numpy as np
import openfast_samples as samples
import pytest

from fowtio.errors import FormatError
from fowtio.read.hydrodyn import ballast, drag_members, read_hydrodyn
from fowtio.read.inflowwind import read_inflowwind
from fowtio.read.openfast_deck import deck_hydro, read_deck
from fowtio.read.openfast_input import read_input
from fowtio.read.seastate import deck_sea
from model.conventions import rigid_mass


@pytest.fixture
def fst(tmp_path):
    return samples.copy_deck(tmp_path / "deck")


def refused(fst, *parts, file="oc4.fst", line=None):
    """Reading the deck fails in this file, at this line, with all these words."""
    with pytest.raises(FormatError) as error:
        read_deck(fst)
    assert error.value.path.name == file, str(error.value)
    if line is not None:
        assert error.value.line == line, str(error.value)
    for part in parts:
        assert part in str(error.value), str(error.value)


def test_embedded_deck_says_what_the_reports_say(fst):
    # numbers of NREL/TP-5000-60601 (floater) and NREL/TP-500-38060 (turbine)
    deck = read_deck(fst)
    assert (deck.depth, deck.density, deck.gravity) == (200, 1025, 9.80665)
    assert deck.elastodyn.structure.platform.mass == 1.3473e7
    assert deck.elastodyn.structure.tower.top_height == 87.6
    assert deck.elastodyn.dofs == ("surge", "sway", "heave", "roll", "pitch", "yaw", "tower_fa1")
    assert deck.hydrodyn.volume == 13917
    assert len(deck.hydrodyn.members.names) == 25
    assert deck.has_drag
    assert deck.mooring.line_names == ("1", "2", "3")
    assert deck.sea.sea.significant_height == 2
    assert deck.notes == ()
    assert deck_hydro(deck).volume == 13917


@pytest.mark.parametrize("version", [2, 3, 4])
def test_layouts_of_older_versions_say_the_same(fst, version):
    new = read_deck(fst)
    samples.to_version(fst, version)
    old = read_deck(fst)
    same_deck(old, new)
    names = (fst.parent / "HydroDyn.dat").read_text()
    assert ("WaveMod" in names) == (version < 4)
    assert "NPropSets " in names
    assert (re.search(r"^0 0 0 0 0 0 +AddF0", names, re.MULTILINE) is not None) == (version == 2)


def same_deck(old, new):
    """Two decks of one case carry equal numbers."""
    for key in ("depth", "density", "gravity"):
        assert getattr(old, key) == getattr(new, key)
    for key in ("station", "mass_density", "stiffness_fa", "modes", "damping_ratio"):
        np.testing.assert_array_equal(
            getattr(old.elastodyn.structure.tower, key), getattr(new.elastodyn.structure.tower, key)
        )
    for body in ("platform", "nacelle"):
        pair = [getattr(d.elastodyn.structure, body) for d in (old, new)]
        np.testing.assert_array_equal(*(rigid_mass(b.mass, b.centre, b.inertia) for b in pair))
    np.testing.assert_array_equal(old.elastodyn.structure.rotor.node_mass, new.elastodyn.structure.rotor.node_mass)
    for key in ("preload", "stiffness", "damping", "quadratic_damping"):
        np.testing.assert_array_equal(getattr(old.hydrodyn, key), getattr(new.hydrodyn, key))
    for key in ("start", "end", "diameter", "drag_coefficient", "plate_area", "plate_coefficient", "thickness"):
        np.testing.assert_array_equal(getattr(old.hydrodyn.members, key), getattr(new.hydrodyn.members, key))
    np.testing.assert_array_equal(old.mooring.position, new.mooring.position)
    for key in ("kind", "significant_height", "peak_period", "gamma", "heading", "high_cutoff"):
        assert getattr(old.sea.sea, key) == getattr(new.sea.sea, key)


def test_order_of_sections_does_not_matter(fst):
    new = read_deck(fst)
    path = fst.parent / "HydroDyn.dat"
    title, *rest = samples.sections(path.read_text())
    path.write_text(title + "".join(reversed(rest)))
    same_deck(read_deck(fst), new)


@pytest.mark.parametrize("name", ["EDFile", "SeaStFile", "HydroFile", "MooringFile"])
def test_missing_file_is_named_with_the_line_of_the_fst(fst, name):
    line = samples.line_of(fst, name)
    samples.set_value(fst, name, '"nowhere\\gone file.dat"')
    refused(fst, name, "gone file.dat", line=line)


@pytest.mark.parametrize(("name", "value"), [("TwrFile", '"no.dat"'), ("BldFile(1)", '"no.dat"')])
def test_missing_file_of_elastodyn(fst, name, value):
    samples.set_value(fst.parent / "ElastoDyn.dat", name, value)
    refused(fst, name, file="ElastoDyn.dat", line=samples.line_of(fst.parent / "ElastoDyn.dat", name))


def test_files_in_folders_with_blanks_and_backslashes(fst):
    folder = fst.parent / "my modules" / "structure"
    folder.mkdir(parents=True)
    for name in ("ElastoDyn.dat", "ElastoDyn_Tower.dat", "ElastoDyn_Blade.dat"):
        (fst.parent / name).rename(folder / name)
    samples.set_value(fst, "EDFile", '"my modules\\structure\\ElastoDyn.dat"')
    assert read_deck(fst).elastodyn.structure.hub_height == pytest.approx(90.0, abs=0.01)  # NREL/TP-500-38060: 90 m


def test_aerodyn_and_servodyn_need_not_be_there(fst):
    samples.set_value(fst, "CompAero", "2")
    samples.set_value(fst, "AeroFile", '"AeroDyn that is nowhere.dat"')
    assert read_deck(fst).aerodynamics


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("CompSub", "1", "SubDyn"),
        ("CompElast", "3", "simplified ElastoDyn"),
        ("CompMooring", "2", "FEAMooring"),
        ("CompIce", "2", "IceDyn"),
        ("MHK", "2", "floating"),
        ("NRotors", "2", "NRotors"),
        ("CompSeaSt", "0", "CompSeaSt 1"),
        ("CompHydro", "NaN", "a whole number"),
        ("MSL2SWL", "1.5", "still water"),
        ("Gravity", "*****", "a number"),
    ],
)
def test_what_the_primary_file_may_not_ask(fst, name, value, words):
    samples.set_value(fst, name, value)
    refused(fst, words, line=samples.line_of(fst, name))


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("NBody", "2", "one potential-flow body"),
        ("PtfmRefzt", "-5", "reference point"),
        ("PotMod", "2", "WAMIT form"),
        ("NJoints", "43", "after 43 rows"),
        ("NJoints", "45", "44 rows"),
        ("NMembers", "24", "after 24 rows"),
        ("NPropSetsCyl", "3", "after 3 rows"),
        ("NAxCoef", "1", "after 1 rows"),
        ("NAddDOF", "1", "a rigid body"),
    ],
)
def test_what_hydrodyn_may_not_ask(fst, name, value, words):
    samples.set_value(fst.parent / "HydroDyn.dat", name, value)
    refused(fst, words, file="HydroDyn.dat")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            "     42     14.43376     25.00000    -19.94000          1",
            "     42     14.43376     25.00000    -19.94000          7",
            "JointAxID 7",
        ),
        ("     43    -28.86751", "     42    -28.86751", "every joint once"),
        ("      24        10        43 ", "      23        10        43 ", "every member once"),
        ("      24        10        43 ", "      24        10        99 ", "JointID 99"),
        ("      24        10        43 ", "      24        43        43 ", "of some length"),
        ("        1    6.50000     0.03000", "        1    6.50000     4.03000", "a wall within it"),
        ("        3           3        1         0.0", "        3           3        2         0.0", "Rectangular"),
        ("        3           3        1         0.0", "        3           9        1         0.0", "MPropSetID 9"),
        ("    1 0.56 0.56", "   26 0.56 0.56", "coefficients of member 1"),
    ],
)
def test_tables_of_hydrodyn_that_do_not_fit(fst, old, new, words):
    path = fst.parent / "HydroDyn.dat"
    text = path.read_text()
    assert old in text
    at = text[: text.index(old)].count("\n") + 1
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(FormatError, match=words) as error:
        read_hydrodyn(path)
    assert error.value.line is not None
    assert abs(error.value.line - at) <= 25 or "coefficients" in words  # the row itself, or the row that refers to it


@pytest.mark.parametrize(
    ("file", "name", "value", "words"),
    [
        ("ElastoDyn.dat", "NumBl", "4", "1 to 3 blades"),
        ("ElastoDyn.dat", "TipRad", "1", "TipRad above HubRad"),
        ("ElastoDyn.dat", "TowerHt", "5", "TowerHt above"),
        ("ElastoDyn.dat", "PtfmRefzt", "-3", "PtfmRefzt = 0"),
        ("ElastoDyn.dat", "PreCone(2)", "-3", "equal PreCone"),
        ("ElastoDyn.dat", "NacYIner", "1", "at least"),
        ("ElastoDyn_Tower.dat", "NTwInpSt", "10", "after 10 rows"),
        ("ElastoDyn_Tower.dat", "NTwInpSt", "12", "11 rows"),
        ("ElastoDyn_Blade.dat", "NBlInpSt", "48", "after 48 rows"),
    ],
)
def test_what_the_structure_may_not_be(fst, file, name, value, words):
    samples.set_value(fst.parent / file, name, value)
    refused(fst, words, file=file)


def test_station_out_of_order(fst):
    samples.replace(fst.parent / "ElastoDyn_Tower.dat", "    0.5000     3170.400", "    0.3500     3170.400")
    refused(fst, "ascending HtFract", file="ElastoDyn_Tower.dat")


@pytest.mark.parametrize("model", [1, 2])
def test_the_three_coefficient_models(fst, model):
    """Model 1 gives every member one coefficient, model 2 interpolates over depth; model 3 is the embedded deck."""
    path = fst.parent / "HydroDyn.dat"
    text = path.read_text()
    if model == 1:
        text = text.replace("\n0.00 0.00 0.00 0.00 1.00 1.00", "\n0.75 0.00 0.00 0.00 1.00 1.00", 1)
    else:
        table = "3   NCoefDpthCyl - rows\nDpth DpthCd\n(m) (-)\n0 0.5\n10 0.7\n20 1.7\n"
        text = re.sub(r"0 +NCoefDpthCyl.*\nDpth DpthCd\n\(m\) \(-\)\n", table, text)
    path.write_text(re.sub(r"(        3        1    TRUE)", f"        {model}        1    TRUE", text))
    members = read_hydrodyn(path).members
    if model == 1:
        assert np.all(members.drag_coefficient == 0.75)
    else:
        # the main column: from 20 m below (1.7) to 10 m above, where the shallowest row holds: |z| is the depth
        assert members.drag_coefficient[0].tolist() == [1.7, 0.5]
        assert members.drag_coefficient[1, 0] == pytest.approx(0.7 + 0.4 * 1.0, rel=1e-12)  # at 14 m, exact


def filled(fst, rows):
    """Put rows into the table of filled members."""
    path = fst.parent / "HydroDyn.dat"
    table = f"{len(rows)}  NFillGroups - groups\nFillNumM FillMList FillFSLoc FillDens\n(-) (-) (m) (kg/m^3)\n"
    new, count = re.subn(r"0 +NFillGroups.*\n.*\n.*\n", table + "".join(f"{row}\n" for row in rows), path.read_text())
    assert count == 1
    path.write_text(new)
    return path


def test_ballast_is_a_cylinder_of_fluid(fst):
    # upper column 1: vertical, z from -14 to 12, outer diameter 12 m, wall 0.06 m; full to z = -4: a cylinder of 10 m
    hydro = read_hydrodyn(filled(fst, [" 1   2   -4.0  1100.0"]))
    body = ballast(hydro, 1025.0)
    diameter, height = 12 - 0.12, 10.0
    mass = 1100 * np.pi / 4 * diameter**2 * height
    assert body.mass == pytest.approx(mass, rel=1e-12)
    np.testing.assert_allclose(body.centre, [14.43376, 25.0, -9.0], rtol=1e-12)
    across = mass * (diameter**2 / 16 + height**2 / 12)
    # Gauss's rule is exact for these polynomials: rounding only
    np.testing.assert_allclose(
        body.inertia, np.diag([across, across, mass * diameter**2 / 8]), rtol=1e-10, atol=across * 1e-12
    )
    assert any("ballast" in note for note in hydro.notes)


def test_ballast_is_added_to_the_platform(fst):
    before = read_deck(fst).elastodyn.structure.platform
    filled(fst, [" 3   2 3 4   -4.0  DEFAULT"])
    deck = read_deck(fst)
    water = ballast(deck.hydrodyn, deck.density)
    after = deck.elastodyn.structure.platform
    assert water.mass == pytest.approx(3 * 1025 * np.pi / 4 * 11.88**2 * 10, rel=1e-12)
    total = rigid_mass(before.mass, before.centre, before.inertia) + rigid_mass(water.mass, water.centre, water.inertia)
    np.testing.assert_allclose(rigid_mass(after.mass, after.centre, after.inertia), total, rtol=1e-10, atol=1e-3)
    assert deck.notes


def test_ballast_of_a_sloping_cone_and_of_dry_members(tmp_path, fst):
    # brace 20 slopes from z = -16.2 to 9.13; the part below -3.535 (half its length) holds half its volume
    half = ballast(read_hydrodyn(filled(fst, [" 1   20   -3.535  1000.0"])), 1025.0)
    inner = 1.6 - 0.035
    length = np.linalg.norm([11.43376 - 1.625, 19.80385 - 2.815, 9.13 + 16.2])
    assert half.mass == pytest.approx(1000 * np.pi / 4 * inner**2 * length / 2, rel=1e-12)
    other = samples.copy_deck(tmp_path / "other")
    assert ballast(read_hydrodyn(filled(other, [" 1   2   -20.0  1000.0"])), 1025.0) is None


@pytest.mark.parametrize(
    "row", [" 1   99   -4.0  1000", " 2   2 2   -4.0  1000", " 2   2   -4.0  1000", " 1  2  x 1000", " 1 2 -4"]
)
def test_fillings_that_do_not_fit(fst, row):
    with pytest.raises(FormatError) as error:
        read_hydrodyn(filled(fst, [row]))
    assert error.value.line is not None


@pytest.mark.parametrize(("thickness", "fits"), [("0.0", True), ("0.1", False)])
def test_marine_growth_is_refused_only_where_there_is_some(fst, thickness, fits):
    path = fst.parent / "HydroDyn.dat"
    table = f"2  NMGDepths - rows\nMGDpth MGThck MGDens\n(m) (m) (kg/m^3)\n-30 0 1300\n0 {thickness} 1300\n"
    new, count = re.subn(r"0 +NMGDepths.*\n.*\n.*\n", table, path.read_text())
    assert count == 1
    path.write_text(new)
    if fits:
        assert read_hydrodyn(path).members.names
    else:
        with pytest.raises(FormatError, match="marine growth") as error:
            read_hydrodyn(path)
        assert path.read_text().splitlines()[error.value.line - 1] == "0 0.1 1300"


def test_a_load_flag_that_is_off_is_refused(fst):
    samples.to_version(fst, 2)
    samples.set_value(fst.parent / "HydroDyn.dat", "PtfmHvF", "False")
    refused(fst, "PtfmHvF", file="HydroDyn.dat")


def test_moordyn_instead_of_map(fst):
    from fowtio.write.mooring import write_moordyn

    with_map = read_deck(fst).mooring
    write_moordyn(with_map, fst.parent / "MoorDyn.dat")
    samples.set_value(fst, "CompMooring", "3")
    samples.set_value(fst, "MooringFile", '"MoorDyn.dat"')
    mooring = read_deck(fst).mooring
    np.testing.assert_array_equal(mooring.position, with_map.position)
    samples.set_value(fst, "WtrDpth", "190")
    refused(fst, "190 m", file="MoorDyn.dat")


def test_drag_of_a_whole_column_is_a_half_rho_cd_d_l(fst):
    hydro = read_hydrodyn(fst.parent / "HydroDyn.dat")
    drag = drag_members(hydro.members, 1025.0)
    at_main = np.hypot(drag.position[:, 0], drag.position[:, 1]) < 1e-6
    # main column, -20 to 0: 1/2 rho Cd D L (NREL/TP-5000-60601: Cd 0.56, diameter 6.5 m)
    assert drag.factor[at_main].sum() == pytest.approx(0.5 * 1025 * 0.56 * 6.5 * 20, rel=1e-12)
    assert drag.length[at_main].sum() == pytest.approx(20, rel=1e-12)


def test_sea_of_a_deck(fst):
    path = fst.parent / "SeaState.dat"
    samples.set_value(path, "WaveMod", "0")
    assert deck_sea(read_input(path)).sea.kind == "still"
    samples.set_value(path, "WaveMod", "3")
    assert deck_sea(read_input(path)).sea.kind == "white_noise"
    samples.set_value(path, "WaveMod", "1P45")
    assert deck_sea(read_input(path)).sea is None
    samples.set_value(path, "WaveMod", "x")
    with pytest.raises(FormatError, match="WaveMod"):
        deck_sea(read_input(path))


@pytest.mark.parametrize("exponent", [1.0, 3.0])
def test_spreading_over_the_full_circle_keeps_its_exponent(fst, exponent):
    path = fst.parent / "SeaState.dat"
    for name, value in (("WaveDirMod", "1"), ("WaveDirSpread", str(exponent)), ("WaveDirRange", "360")):
        samples.set_value(path, name, value)
    # over 360 degrees OpenFAST's cos^2S(pi x / range) is cos^2S(x / 2); the midpoint rule is exact for it
    assert deck_sea(read_input(path)).sea.spreading == pytest.approx(exponent, rel=1e-9)


def test_spreading_over_a_quarter_has_the_same_variance(fst):
    path = fst.parent / "SeaState.dat"
    for name, value in (("WaveDirMod", "1"), ("WaveDirSpread", "1"), ("WaveDirRange", "90")):
        samples.set_value(path, name, value)
    s = deck_sea(read_input(path)).sea.spreading
    # mean of cos x of cos^2(2x) between -45 and 45 degrees: (4/pi) [sin(45) + (sin(225)/5 + sin(135)/3)/2 ...] in
    # closed form
    a = np.pi / 4
    mean = (np.sin(a) + (np.sin(5 * a) / 5 + np.sin(3 * a) / 3) / 2) / a
    assert s / (s + 1) == pytest.approx(mean, rel=1e-5)  # 2000 steps of the midpoint rule


def test_inflow_kinds(fst):
    path = fst.parent / "InflowWind.dat"
    assert read_inflowwind(path).speed == 11.0
    samples.set_value(path, "WindType", "3")
    samples.set_value(path, "FileName_BTS", '"wind\\a.bts"')
    assert read_inflowwind(path).turbsim == fst.parent / "wind" / "a.bts"
    samples.to_version(fst, 2)
    assert read_inflowwind(path).turbsim == fst.parent / "wind" / "a.bts"
    samples.set_value(path, "WindType", "9")
    with pytest.raises(FormatError, match="WindType"):
        read_inflowwind(path)


def test_no_deck_at_all(tmp_path):
    with pytest.raises(FormatError, match="does not exist"):
        read_deck(tmp_path / "no.fst")
    (tmp_path / "other.fst").write_text("1  Speed - a number\n")
    with pytest.raises(FormatError, match="EDFile"):
        read_deck(tmp_path / "other.fst")
