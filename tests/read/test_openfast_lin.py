"""OpenFAST linearisation files of several versions: what is written comes back, what is cut short is refused."""

import os
import time
from pathlib import Path

import numpy as np
import pytest
from openfast_samples import LIN_FILE, OC4, lin_text

from fowtio.errors import FormatError
from fowtio.read.openfast_lin import read_openfast_lin

RNG = np.random.default_rng(7)
STATES = [
    ("ED Platform horizontal surge translation DOF (internal DOF index = DOF_Sg), m", 0.5, False, 2),
    ("ED 1st flapwise bending-mode DOF of blade 2 (internal DOF index = DOF_BF(2,1)), m", 1.5, True, 2),
    (
        "ED First time derivative of Platform horizontal surge translation DOF (internal DOF index = DOF_Sg), m/s",
        0.1,
        False,
        2,
    ),
    (
        "ED First time derivative of 1st flapwise bending-mode DOF of blade 2 (internal DOF index = DOF_BF(2,1)), m/s",
        0.2,
        True,
        2,
    ),
    ("HD Exctn 1, -", 0.0, False, 1),
]
INPUTS = [
    ("IfW Extended input: horizontal wind speed (steady/uniform wind), m/s", 11.0, False),
    ("HD Morison X orientation angle, node 1, rad", (1.0, -2e-6, 3e-3), False),
    ("ED Blade 1 pitch command, rad", 0.05, True),
]
OUTPUTS = [("ED PtfmSurge, (m)", 0.5, False), ("ED TwrBsMyt, (kN-m)", 34567.8, False)]


def matrices(*more):
    x, u, y = len(STATES), len(INPUTS), len(OUTPUTS)
    shapes = {
        "A": (x, x),
        "B": (x, u),
        "C": (y, x),
        "D": (y, u),
        "dUdu": (u, u),
        "dUdy": (u, y),
        "dXdx": (x, x),
        "dXdu": (x, u),
        "dYdx": (y, x),
        "dYdu": (y, u),
        "StateRotation": (3, 3),
    }
    return {
        name: RNG.normal(size=shapes[name]) * 10.0 ** RNG.integers(-9, 9, shapes[name])
        for name in ("A", "B", "C", "D", *more)
    }


def read(tmp_path, text, name="a.lin"):
    path = tmp_path / name
    path.write_bytes(text.encode("latin-1"))
    return read_openfast_lin(path)


@pytest.mark.parametrize("digits", [3, 6, 9, 17])
@pytest.mark.parametrize("order_column", [True, False])
def test_what_is_written_comes_back(tmp_path, digits, order_column):
    given = matrices("dUdu", "dUdy")
    lin = read(tmp_path, lin_text(given, STATES, INPUTS, OUTPUTS, digits=digits, order_column=order_column))
    for name in "ABCD":
        # a number written with d digits behind the point is wrong by half of its last digit at most
        np.testing.assert_allclose(getattr(lin, name), given[name], rtol=0.5 * 10.0**-digits + 1e-15)
    for name in ("dUdu", "dUdy"):
        np.testing.assert_allclose(lin.jacobians[name], given[name], rtol=0.5 * 10.0**-digits + 1e-15)
    assert lin.state_names == tuple(s[0] for s in STATES)
    assert lin.state_order.tolist() == [2, 2, 2, 2, 1]
    assert lin.state_rate.tolist() == [0, 0, 1, 1, 0]
    assert lin.state_dof == ("surge", "blade2_flap1", "surge", "blade2_flap1", "")
    assert lin.state_rotating.tolist() == [0, 1, 0, 1, 0]
    assert lin.input_names == tuple(s[0] for s in INPUTS)
    assert lin.input_point[1] == pytest.approx((1.0, -2e-6, 3e-3), rel=10.0**-digits)
    assert lin.input_rotating.tolist() == [0, 0, 1]
    assert lin.output_point == pytest.approx((0.5, 34567.8), rel=10.0**-digits)
    assert (lin.rotor_speed, lin.azimuth, lin.wind_speed) == (1.25, 0.5, 11.0)
    assert lin.modules == ("NWTC Subroutine Library", "ElastoDyn", "Some")


def test_early_file_without_wind_speed(tmp_path):
    assert read(tmp_path, lin_text(matrices(), STATES, INPUTS, OUTPUTS, wind_speed=False)).wind_speed == 0


@pytest.mark.parametrize(("inputs", "outputs"), [(0, 0), (0, 2), (3, 0)])
def test_without_inputs_or_outputs(tmp_path, inputs, outputs):
    given = matrices()
    if not inputs:
        given = {k: v for k, v in given.items() if k not in "BD"}
    if not outputs:
        given = {k: v for k, v in given.items() if k not in "CD"}
    lin = read(tmp_path, lin_text(given, STATES, INPUTS[:inputs], OUTPUTS[:outputs]))
    assert lin.B.shape == (5, inputs)
    assert lin.C.shape == (outputs, 5)
    assert lin.D.shape == (outputs, inputs)


def test_module_file_with_all_jacobians(tmp_path):
    given = matrices("dXdx", "dXdu", "dYdx", "dYdu", "StateRotation")
    lin = read(tmp_path, lin_text(given, STATES, INPUTS, OUTPUTS), name="a.ED.lin")
    assert sorted(lin.jacobians) == ["StateRotation", "dXdu", "dXdx", "dYdu", "dYdx"]
    np.testing.assert_allclose(lin.jacobians["StateRotation"], given["StateRotation"], rtol=1e-9)


def test_module_without_states(tmp_path):
    given = {"D": np.ones((2, 3))}
    lin = read(tmp_path, lin_text(given, [], INPUTS, OUTPUTS))
    assert lin.A.shape == (0, 0)
    assert np.all(lin.D == 1)


SAMPLE = lin_text(matrices("dUdu"), STATES, INPUTS, OUTPUTS)


@pytest.mark.parametrize("dress", ["crlf", "tabs", "d exponents", "merged columns"])
def test_other_dress(tmp_path, dress):
    plain = read(tmp_path, SAMPLE)
    head, body = SAMPLE.split("Linearized state matrices:")
    text = {
        "crlf": SAMPLE.replace("\n", "\r\n"), "tabs": head + "Linearized state matrices:" + body.replace(" -", "\t-"),
        "d exponents": head + "Linearized state matrices:" + body.replace("E+", "D+"),
        "merged columns": head + "Linearized state matrices:" + body.replace(" -", "-"),
    }[dress]  # fmt: skip
    other = read(tmp_path, text)
    for name in "ABCD":
        np.testing.assert_array_equal(getattr(other, name), getattr(plain, name))


def test_every_line_cut_off_is_noticed(tmp_path):
    """A file that ends early is refused wherever it is cut, but for the blank lines at its end."""
    lines = SAMPLE.rstrip("\n").split("\n")
    for k in range(len(lines)):
        with pytest.raises(FormatError):
            read(tmp_path, "\n".join(lines[:k]) + "\n")
    assert read(tmp_path, "\n".join(lines))


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("Linearized model", "Some model", "Linearized model"),
        ("continuous states:   5", "continuous states:   4", "matrix A"),
        ("continuous states:   5", "continuous states:   *****", "a number"),
        ("continuous states:   5", "continuous states:   5.5", "whole number"),
        ("inputs:   3", "inputs:   2", "matrix B"),
        ("outputs:   2", "outputs:   3", "row 3 of 3"),
        ("A: 5 x 5", "A: 5 x 4", "a row of A"),
        ("A: 5 x 5", "A: 4 x 5", "matrix A"),
        ("B: 5 x 3", "A: 5 x 3", "matrix A"),
        ("dUdu: 3 x 3", "dUdu: 3 x 9", "a row of dUdu"),
        ("Azimuth:   0.5000", "Azimuth:   NaN", "a number"),
        ("Order of inputs:", "Order of things:", "Order of inputs"),
        ("          2   1.500000000E+00", "          3   1.500000000E+00", "row 2 of 5"),
        ("1.500000000E+00", "1.5x", "operating point"),
        ("1.500000000E+00", "1.5, 2.5", "three of an orientation"),
        ("T      2     ED 1st", "T      7     ED 1st", "derivative order"),
    ],
)
def test_what_does_not_fit_is_refused(tmp_path, old, new, words):
    assert old in SAMPLE
    with pytest.raises(FormatError) as error:
        read(tmp_path, SAMPLE.replace(old, new, 1))
    assert words in str(error.value), str(error.value)


@pytest.mark.parametrize("bad", ["NaN", "Infinity", "**********", "1.2E+00-", ""])
def test_a_bad_number_is_named_with_its_line(tmp_path, bad):
    lines = SAMPLE.split("\n")
    at = next(i for i, line in enumerate(lines) if line.startswith("C: ")) + 2
    parts = lines[at].split()
    lines[at] = "  ".join([*parts[:2], bad, *parts[3:]])
    with pytest.raises(FormatError) as error:
        read(tmp_path, "\n".join(lines))
    assert error.value.line == at + 1
    assert "a row of C" in str(error.value)


@pytest.mark.parametrize("text", ["", "\n\n", "Linearized model: one line", "1 2 3\n" * 50])
def test_no_linearisation_at_all(tmp_path, text):
    with pytest.raises(FormatError):
        read(tmp_path, text)


def test_embedded_files_hold_second_order_systems():
    """Rows of A that belong to positions say that their derivative is the velocity: a property of any such file."""
    for path in (LIN_FILE, OC4 / "linearisation" / "parked" / "main.1.lin"):
        lin = read_openfast_lin(path)
        q = len(lin.state_dof) // 2
        np.testing.assert_array_equal(lin.A[:q], np.hstack([np.zeros((q, q)), np.eye(q)]))
        assert lin.state_dof[:q] == lin.state_dof[q:] == ("surge", "sway", "heave", "roll", "pitch", "yaw", "tower_fa1")
        assert lin.state_rate.tolist() == [0] * q + [1] * q
    assert lin.D.shape == (29, 1679)
    rotated = [np.linalg.norm(p) for p in lin.input_point if not np.isscalar(p)]
    assert len(rotated) % 3 == 0
    np.testing.assert_allclose(rotated, 1, atol=1e-6)  # rows of rotation matrices, written with eight digits


def test_speed(tmp_path):
    """A file of 300 kB is read in less than 30 ms of processor time (best of five, the target on two cores)."""
    states = [(f"{'First time derivative of ' if k >= 70 else ''}state {k % 70}, m", 0.0, False, 2) for k in range(140)]
    path = tmp_path / "big.lin"
    path.write_text(lin_text({"A": RNG.normal(size=(140, 140))}, states, [], []))
    assert path.stat().st_size > 300_000

    def once():
        start = time.process_time()
        read_openfast_lin(path)
        return time.process_time() - start

    assert min(once() for _ in range(5)) < 0.03


@pytest.mark.reference
@pytest.mark.skipif("FOWTIO_FORMATS" not in os.environ, reason="FOWTIO_FORMATS names no folder of sample files")
def test_real_files():
    folder = Path(os.environ["FOWTIO_FORMATS"]) / "openfast_lin"
    shapes = {path.name: read_openfast_lin(path) for path in sorted(folder.glob("*.lin"))}
    assert shapes["Standstill_old.1.lin"].D.shape == (91, 6)  # version 2.3: no column of derivative orders
    assert set(shapes["Standstill_old.1.lin"].state_order) == {2}
    hydro = shapes["StandstillSemi_ForID_EDHD.1.lin"]
    assert hydro.A.shape == (134, 134)
    assert 0 < np.sum(hydro.state_order == 1) < 134
    assert all("HD" in name for name, order in zip(hydro.state_names, hydro.state_order, strict=True) if order == 1)
