"""MoorDyn files of versions 1 and 2 as static mooring systems, and the way back."""

import os
from pathlib import Path

import numpy as np
import pytest
from test_map import WATER, equal
from test_map import mooring as map_sample

from fowtio.errors import FormatError, ModelError
from fowtio.read.moordyn import moordyn_mooring, read_moordyn
from fowtio.write.mooring import moordyn_text, write_moordyn
from model.system.mooring import MooringSystem, mooring_state

V1 = """\
--------------------- MoorDyn sample of version 1 --------------------------
made by the tests
FALSE    Echo      - echo
----------------------- LINE TYPES ------------------------------------------
2        NTypes    - number of types
Name   Diam   MassDen   EA        BA/-zeta  Can  Cat  Cdn  Cdt
(-)    (m)    (kg/m)    (N)       (N-s/-)   (-)  (-)  (-)  (-)
Chain  0.08   120.5     8.0E+08   -1.0      1.0  0.5  2.4  1.5
rope   0.2    30        1.0D+08   -1.0      1.0  0.5  2.4  1.5
---------------------- CONNECTION PROPERTIES --------------------------------
3        NConnects - number of connections
Node  Type     X      Y     Z       M     V    FX  FY  FZ  CdA CA
(-)   (-)     (m)    (m)   (m)     (kg)  (m^3) (N) (N) (N) (m^2) (-)
1     Fixed   800     0    -200      0     0    0   0   0   0   0
2     Connect 400     0    -150   2000    1.5  10   0 -20   0   0
3     Vessel  40.0    0    -14       0     0    0   0   0   0   0
---------------------- LINE PROPERTIES --------------------------------------
2        NLines    - number of lines
Line  LineType  UnstrLen  NumSegs   NodeAnch  NodeFair  Outputs  CtrlChan
(-)   (-)       (m)       (-)       (-)       (-)       (-)      (-)
1     chain     450       100       1         2         -        0
2     ROPE      370       50        2         3         pt       0
---------------------- SOLVER OPTIONS ---------------------------------------
0.001    dtM       - time step
3e6      kbot      - bottom stiffness
200      WtrDpth   - depth
1025.0   rhoW
9.80665  g
------------------------ OUTPUTS --------------------------------------------
FairTen1
END
------------------------- need this line --------------------------------------
"""

V2 = """\
MoorDyn sample of version 2
made by the tests
---------------------- LINE TYPES -------------------------------------------
TypeName  Diam  Mass/m  EA      BA/-zeta  EI   Cd   Ca   CdAx  CaAx
(name)    (m)   (kg/m)  (N)     (N-s/-)   (N-m^2) (-) (-) (-) (-)
Chain     0.08  120.5   8.0e8   -1.0      0.0  1.2  1.0  0.2  0.0
rope      0.2   30      1.0e8   -1.0      0.0  1.2  1.0  0.2  0.0   # a comment
---------------------- ROD TYPES --------------------------------------------
TypeName  Diam  Mass/m  Cd  Ca  CdEnd CaEnd
(name)    (m)   (kg/m)  (-) (-) (-)   (-)
---------------------- BODIES -----------------------------------------------
ID  Attachment  X0  Y0  Z0  r0  p0  y0  Mass  CG*  I*  Volume  CdA*  Ca*
(#)  (-)        (m) (m) (m) (deg) (deg) (deg) (kg) (m) (kg-m^2) (m^3) (m^2) (-)
1    coupled    30  0   -10  0  0  90  0  0|0|1  0  0  0  0
---------------------- POINTS -----------------------------------------------
ID  Attachment  X    Y    Z    Mass  Volume  CdA  Ca
(#)  (-)       (m)  (m)  (m)   (kg)  (m^3)  (m^2) (-)
1    Fixed     800   0   -200    0     0     0     0
2    Free      400   0   -150  2000   1.5    0     0
3    Body1     0   -10   -4      0     0     0     0   ! on the body
---------------------- LINES ------------------------------------------------
ID  LineType  AttachA  AttachB  UnstrLen  NumSegs  LineOutputs
(#)  (name)   (#)      (#)      (m)       (-)      (-)
1    Chain    1        2        450       20       p
2    rope     2        3        370       20       -
---------------------- OPTIONS ----------------------------------------------
200    WtrDpth   - depth
0.7    MU_KA     - axial friction
---------------------- OUTPUTS ----------------------------------------------
FAIRTEN1
---------------------- need this line ---------------------------------------
"""


def mooring(tmp_path, text, **keywords):
    path = tmp_path / "md.dat"
    path.write_text(text)
    return moordyn_mooring(read_moordyn(path), **keywords)


def test_version_1(tmp_path):
    system = mooring(tmp_path, V1)
    assert system.point_kind == ("fixed", "connect", "vessel")
    np.testing.assert_array_equal(system.position, [[800, 0, -200], [400, 0, -150], [40, 0, -14]])
    assert (system.point_mass[1], system.point_volume[1]) == (2000, 1.5)
    np.testing.assert_array_equal(system.point_force[1], [10, 0, -20])
    assert system.length.tolist() == [450, 370]
    assert system.axial_stiffness.tolist() == [8e8, 1e8]
    assert (system.end_a.tolist(), system.end_b.tolist()) == ([0, 1], [1, 2])
    assert system.seabed_friction.tolist() == [0, 0]
    assert (system.depth, system.density, system.gravity) == (200, 1025, 9.80665)


def test_version_2_with_a_body(tmp_path):
    system = mooring(tmp_path, V2, gravity=9.81, density=1000.0)
    assert system.point_kind == ("fixed", "connect", "vessel")
    # (0, -10, -4) on a body turned 90 degrees about z at (30, 0, -10): (10, 0, -4) further; rounding of a rotation
    np.testing.assert_allclose(system.position[2], [40, 0, -14], atol=1e-12)
    assert system.seabed_friction.tolist() == [0.7, 0.7]
    assert (system.gravity, system.density) == (9.81, 1000)


def test_both_versions_give_one_equilibrium(tmp_path):
    # the same mooring but for the friction and the constant force
    one = mooring(tmp_path, V1.replace("1.5  10   0 -20", "1.5  0   0 0"))
    two = mooring(tmp_path, V2.replace("0.7    MU_KA", "0.0    MU_KA"), gravity=9.80665)
    a, b = (mooring_state(s, np.zeros(6)) for s in (one, two))
    np.testing.assert_allclose(a.fairlead_tension, b.fairlead_tension, rtol=1e-9)  # same equations, same solver


@pytest.mark.parametrize("word", ["Vessel", "Coupled", "Fairlead", "Turbine1", "T1"])
def test_words_for_a_fairlead(tmp_path, word):
    assert mooring(tmp_path, V1.replace("3     Vessel", f"3     {word}")).point_kind[2] == "vessel"


@pytest.mark.parametrize(
    ("text", "old", "new", "line", "words"),
    [
        (V1, "8.0E+08", "8e8|9e8", 8, "Viscoelastic"),
        (V1, "8.0E+08", "table.txt", 8, "tabulated"),
        (V1, "2        NTypes", "3        NTypes", 5, "3 rows"),
        (V1, "200      WtrDpth", "sea.txt  WtrDpth", 26, "bathymetry"),
        (V1, "1     chain", "1     wire", 21, "a line type"),
        (V1, "100       1         2", "100       1         7", 21, "a point"),
        (V1, "1     Fixed", "1     Turbine2", 14, "one turbine"),
        (V1, "3     Vessel", "3     Rod1", 16, "a body"),
        (V1, "3     Vessel", "3     Body4", 16, "a body"),
        (V1, "40.0    0    -14       0", "40.0    0    -14       5", 16, "platform's mass"),
        (V1, "3     Vessel", "1     Vessel", 16, "every number once"),
        (V1, "(kg)  (m^3) (N)", "(kg)  (m^3) (kN)", 15, "newtons"),
        (V1, "120.5", "NaN", 8, "a number"),
        (V1, "(-)    (m)    (kg/m)", "-    (m)    (kg/m)", 7, "units"),
        (V1, "NodeAnch  NodeFair", "From  To", 21, "attacha"),
        (V2, "coupled    30", "free    30", 14, "Free bodies"),
        (V2, "0  0  90  0", "0  0  90  50", 14, "platform's mass"),
        (V2, "0  0  90", "10  0  90", 14, "one axis"),
        (V2, "0.7    MU_KA", "x    MU_KA", 28, "a number"),
    ],
)
def test_what_is_refused_with_its_line(tmp_path, text, old, new, line, words):
    assert old in text
    with pytest.raises(FormatError) as error:
        mooring(tmp_path, text.replace(old, new, 1))
    assert error.value.line == line, str(error.value)
    assert words in str(error.value)


@pytest.mark.parametrize("section", ["RODS", "EXTERNAL LOADS", "FAILURE"])
def test_sections_that_are_refused(tmp_path, section):
    rows = f"---------------------- {section} ------------\nID A B\n(#) (-) (-)\n1 a b\n"
    with pytest.raises(FormatError, match="without"):
        mooring(tmp_path, V2.replace("---------------------- OPTIONS", rows + "---------------------- OPTIONS"))


def test_depth_of_the_deck(tmp_path):
    without = V1.replace("200      WtrDpth   - depth\n", "")
    assert mooring(tmp_path, without, depth=200.0).depth == 200
    with pytest.raises(FormatError, match="WtrDpth"):
        mooring(tmp_path, without)
    with pytest.raises(FormatError, match="190"):
        mooring(tmp_path, V1, depth=190.0)


@pytest.mark.parametrize("dress", ["crlf", "tabs", "latin-1"])
def test_other_dress(tmp_path, dress):
    text = {
        "crlf": V1.replace("\n", "\r\n"),
        "tabs": V1.replace("  ", "\t"),
        "latin-1": V1.replace("time step", "größe"),
    }
    path = tmp_path / "other.dat"
    path.write_bytes(text[dress].encode("latin-1"))
    equal(moordyn_mooring(read_moordyn(path)), mooring(tmp_path, V1))


@pytest.mark.parametrize("version", [1, 2])
def test_round_trip(tmp_path, version):
    system = mooring(tmp_path, V1 if version == 1 else V2)
    path = write_moordyn(system, tmp_path / "again.dat", version=version)
    equal(moordyn_mooring(read_moordyn(path)), system)


def test_map_to_moordyn_keeps_the_system(tmp_path):
    system = map_sample(tmp_path)
    values = {n: getattr(system, n) for n in system.__dataclass_fields__}
    plain = MooringSystem(**(values | {"seabed_friction": np.full(6, 0.3), "point_force": None}))
    path = write_moordyn(plain, tmp_path / "md.dat")
    equal(moordyn_mooring(read_moordyn(path), depth=WATER["depth"]), plain)


def test_what_a_version_cannot_say(tmp_path):
    system = map_sample(tmp_path)
    with pytest.raises(ModelError, match="friction"):
        moordyn_text(system)
    values = {n: getattr(system, n) for n in system.__dataclass_fields__}
    with pytest.raises(ModelError, match="forces"):
        moordyn_text(MooringSystem(**(values | {"seabed_friction": np.zeros(6)})))
    with pytest.raises(ModelError, match="friction"):
        moordyn_text(MooringSystem(**(values | {"seabed_friction": np.ones(6)})), version=1)
    with pytest.raises(ModelError, match="versions 1 and 2"):
        moordyn_text(system, version=3)


@pytest.mark.reference
@pytest.mark.skipif("FOWTIO_FORMATS" not in os.environ, reason="FOWTIO_FORMATS names no folder of sample files")
def test_real_files():
    folder = Path(os.environ["FOWTIO_FORMATS"]) / "moordyn"
    system = moordyn_mooring(read_moordyn(folder / "nautilus_moordyn_v1.dat"), depth=130.0)
    tension = mooring_state(system, np.zeros(6)).fairlead_tension
    assert np.ptp(tension) < 1e-6 * tension.mean()  # four equal lines on a square
    for name, words in (("semi_taut_v2.dat", "Viscoelastic"), ("shared_mooring.dat", "one turbine")):
        with pytest.raises(FormatError, match=words):
            moordyn_mooring(read_moordyn(folder / name))
