"""MAP++ files: what they say, the way `repeat` turns, and what is refused."""

import numpy as np
import openfast_samples as samples
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fowtio.errors import FormatError, ModelError
from fowtio.read.map import map_mooring, read_map
from fowtio.write.mooring import map_text, write_map
from model.system.mooring import MooringSystem

WATER = {"depth": 200.0, "gravity": 9.80665, "density": 1025.0}
SAMPLE = """\
---------------------- LINE DICTIONARY ---------------------------------------
LineType  Diam      MassDenInAir  EA   CB  CIntDamp Ca Cdn Cdt
(-)       (m)       (kg/m)        (N)  (-) (Pa-s) (-) (-) (-)
Chain     0.0766    113.35        7.536E8  1.0  1e8 0.6 -1 0.05
rope      0.2       30            1.0D8    0.1  1e8 0.6 -1 0.05
---------------------- NODE PROPERTIES ---------------------------------------
Node Type X Y Z M B FX FY FZ
(-) (-) (m) (m) (m) (kg) (m^3) (N) (N) (N)
1 Fix     800   0  depth  0 0 # # #
! a comment
2 Connect #400 #0 #-150  2000 1.5 10 0 -20
3 VESSEL  40.0  0  -14    0 0 #0 # #
---------------------- LINE PROPERTIES ---------------------------------------
Line LineType UnstrLen NodeAnch NodeFair Flags
(-) (-) (m) (-) (-) (-)
1 chain 450  1 2 tension_fair gx_pos
2 ROPE  370  2 3 altitude
---------------------- SOLVER OPTIONS ----------------------------------------
Option
(-)
 help
 outer_tol 1e-5
 ref_position 0 0 0
 repeat 120
 repeat 240
"""


def mooring(tmp_path, text=SAMPLE):
    path = tmp_path / "map.dat"
    path.write_text(text)
    return map_mooring(read_map(path), **WATER)


def test_what_a_file_says(tmp_path):
    system = mooring(tmp_path)
    assert system.point_kind[:3] == ("fixed", "connect", "vessel")
    np.testing.assert_array_equal(system.position[:3], [[800, 0, -200], [400, 0, -150], [40, 0, -14]])
    assert system.point_mass[1] == 2000
    assert system.point_volume[1] == 1.5
    np.testing.assert_array_equal(system.point_force[1], [10, 0, -20])
    assert system.length[:2].tolist() == [450, 370]
    assert system.mass_per_length[:2].tolist() == [113.35, 30]
    assert system.axial_stiffness[:2].tolist() == [7.536e8, 1e8]
    assert system.seabed_friction[:2].tolist() == [1.0, 0.1]
    assert len(system.line_names) == 6
    assert (system.end_a[2], system.end_b[2]) == (3, 4)


def test_repeat_turns_clockwise(tmp_path):
    # OpenFAST 5 with MAP++: a line towards 60 degrees with `repeat 240 120` has T[2] along 180 and T[3] towards 300
    # degrees
    x, y = float(800 * np.cos(np.pi / 3)), float(800 * np.sin(np.pi / 3))
    text = SAMPLE.replace("1 Fix     800   0", f"1 Fix {x!r} {y!r}").replace(
        " repeat 120\n repeat 240", " repeat 240 120"
    )
    system = mooring(tmp_path, text)
    anchors = system.position[[0, 3, 6]]
    towards = np.degrees(np.arctan2(anchors[:, 1], anchors[:, 0])) % 360
    np.testing.assert_allclose(towards, [60, 180, 300], atol=1e-9)  # rounding of a rotation


def test_repeat_turns_forces_too(tmp_path):
    forces = mooring(tmp_path).point_force[[1, 4, 7]]
    # (10, 0) turned clockwise by 120 and 240 degrees
    np.testing.assert_allclose(forces, [[10, 0, -20], [-5, -8.660254, -20], [-5, 8.660254, -20]], rtol=1e-6)


def test_embedded_file(tmp_path):
    path = samples.OC4 / "input" / "MAP.dat"
    system = map_mooring(read_map(path), **WATER)
    anchor = system.position[[0, 2, 4]]
    # README of the case: anchors at (418.8, 725.4), (-837.6, 0), (418.8, -725.4) m, given to a decimetre
    np.testing.assert_allclose(anchor[:, :2], [[418.8, 725.4], [-837.6, 0], [418.8, -725.4]], atol=0.05)


@pytest.mark.parametrize(
    ("old", "new", "line", "words"),
    [
        ("2 ROPE ", "2 wire ", 17, "a line type"),
        ("370  2 3", "370  2 9", 17, "a node"),
        ("450  1 2 tension_fair gx_pos", "450  1", 16, "5 columns"),
        ("1 chain 450", "1 chain #450", 16, "iteration"),
        ("gx_pos", "OMIT_CONTACT", 16, "seabed"),
        ("altitude", "LINEAR_SPRING", 17, "catenaries"),
        ("gx_pos", "DAMAGE_TIME 100", 16, "break"),
        ("2 Connect", "2 Conect", 11, "Fix, Vessel or Connect"),
        ("2000 1.5 10", "2000 1.5 #", 11, "Connect node"),
        ("-14    0 0", "-14    50 0", 12, "platform's mass"),
        ("3 VESSEL", "2 VESSEL", 12, "every node once"),
        ("rope      0.2", "CHAIN   0.2", 5, "every line type once"),
        ("113.35", "NaN", 4, "a number"),
        ("1.0D8", "*****", 5, "a number"),
        ("(-)       (m)", "x       (m)", 3, "units"),
        ("repeat 240", "repeat x", 25, "a number"),
        ("Fix     800   0  depth", "Fix     800   0  -250", None, "seabed"),
        ("1 chain 450", "1 chain -450", None, "length"),
    ],
)
def test_what_is_refused_with_its_line(tmp_path, old, new, line, words):
    assert old in SAMPLE
    with pytest.raises(FormatError) as error:
        mooring(tmp_path, SAMPLE.replace(old, new, 1))
    assert error.value.line == line, str(error.value)
    assert words in str(error.value)


@pytest.mark.parametrize("title", ["LINE DICTIONARY", "NODE PROPERTIES", "LINE PROPERTIES"])
def test_a_missing_section(tmp_path, title):
    with pytest.raises(FormatError, match="none"):
        mooring(tmp_path, SAMPLE.replace(title, "OTHER THINGS"))


@pytest.mark.parametrize("dress", ["crlf", "tabs", "latin-1"])
def test_other_dress(tmp_path, dress):
    text = {
        "crlf": SAMPLE.replace("\n", "\r\n"),
        "tabs": SAMPLE.replace("  ", "\t"),
        "latin-1": SAMPLE.replace("a comment", "Länge"),
    }
    path = tmp_path / "map.dat"
    path.write_bytes(text[dress].encode("latin-1"))
    np.testing.assert_array_equal(map_mooring(read_map(path), **WATER).position, mooring(tmp_path).position)


def equal(a: MooringSystem, b: MooringSystem) -> None:
    """Two systems of equal numbers; names may differ."""
    assert a.point_kind == b.point_kind
    for name in ("position", "point_mass", "point_volume", "point_force", "end_a", "end_b", "length", "mass_per_length",
                 "diameter", "axial_stiffness", "seabed_friction", "depth"):  # fmt: skip
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name), err_msg=name)


def test_round_trip(tmp_path):
    system = mooring(tmp_path)
    again = map_mooring(read_map(write_map(system, tmp_path / "again.dat")), **WATER)
    equal(again, system)
    assert map_text(again) == map_text(system)


@given(
    st.floats(1e-3, 1),
    st.floats(1, 2000),
    st.floats(1e6, 1e10),
    st.floats(0, 2),
    st.floats(10, 3000),
    st.floats(-1e3, 1e3),
)
def test_round_trip_of_any_numbers(tmp_path_factory, diameter, mass, stiffness, friction, length, x):
    system = MooringSystem(
        point_names=("a", "f"),
        point_kind=("fixed", "vessel"),
        position=[[x, 1 / 3, -200], [x / 7, 0, -14.1]],
        line_names=("l",),
        end_a=[0],
        end_b=[1],
        length=[length],
        mass_per_length=[mass],
        diameter=[diameter],
        axial_stiffness=[stiffness],
        seabed_friction=[friction],
        **WATER,
    )
    path = tmp_path_factory.mktemp("map") / "any.dat"
    equal(map_mooring(read_map(write_map(system, path)), **WATER), system)


def test_a_stack_of_designs_is_not_a_file(tmp_path):
    system = mooring(tmp_path)
    values = {n: getattr(system, n) for n in system.__dataclass_fields__}
    stack = MooringSystem(**(values | {"length": np.stack([system.length, system.length])}))
    with pytest.raises(ModelError, match="stack"):
        map_text(stack)
