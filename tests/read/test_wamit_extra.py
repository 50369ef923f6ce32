"""WAMIT .4, .8, .9, .12d, .12s and .out."""

import os
from pathlib import Path

import numpy as np
import pytest
from hydro_samples import assert_equal, flips, put, synthetic, truncations

from fowtio.errors import FormatError
from fowtio.read.wamit import read_wamit
from fowtio.read.wamit_extra import (
    WAMIT_DRIFT,
    WAMIT_MOTION,
    WAMIT_SECOND_ORDER,
    read_wamit_drift,
    read_wamit_motion,
    read_wamit_second_order,
)
from fowtio.read.wamit_out import WAMIT_OUTPUT, read_wamit_out
from model.conventions import weight_stiffness


def polar(z: complex) -> str:
    return f" {abs(z):13.6E} {np.degrees(np.angle(z)):13.6E} {z.real:13.6E} {z.imag:13.6E}\n"


@pytest.fixture
def numbers():
    rng = np.random.default_rng(5)
    return lambda *shape: rng.normal(size=shape) + 1j * rng.normal(size=shape)


def motion_text(values) -> str:
    """Return a .4 file of motions (heading, period, mode 9): a heave of a second body, periods descending."""
    rows = [(t, b) for t in (20.0, 10.0, 5.0) for b in (0.0, 30.0)]
    return "".join(f" {t:13.6E} {b:13.6E} {9:5d}{polar(values[int(b > 0), int(np.log2(t / 5))])}" for t, b in rows)


def test_motions_as_they_stand(tmp_path, numbers):
    values = numbers(2, 3)
    path = put(tmp_path / "a.4", motion_text(values))
    data = read_wamit_motion(path)
    assert data.modes == (9,)
    np.testing.assert_allclose(data.period, [5, 10, 20])
    np.testing.assert_allclose(data.heading, [0, 30])
    np.testing.assert_allclose(data.motion[..., 0], values, atol=1e-6)  # seven digits of numbers near 1
    assert WAMIT_MOTION.recognises(path, path.read_bytes())
    assert dict(WAMIT_MOTION.describe(data))["modes"] == "9"


def test_damaged_motions(tmp_path, numbers):
    text = motion_text(numbers(2, 3))
    want = read_wamit_motion(put(tmp_path / "a.4", text)).motion
    for _, cut in truncations(text):
        count = cut.count("\n")
        path = put(tmp_path / "a.4", cut)
        if count in (1, 2, 4):  # whole periods (or a single row): a complete, smaller table
            assert read_wamit_motion(path).motion.size == count
        else:
            with pytest.raises(FormatError):
                read_wamit_motion(path)
    for _, bent in flips(text, 200):
        try:
            got = read_wamit_motion(put(tmp_path / "a.4", bent))
        except FormatError:
            continue
        if got.motion.shape == want.shape:  # the check allows 1 % between polar and parts
            assert np.abs(np.sort_complex(got.motion.ravel()) - np.sort_complex(want.ravel())).max() < 0.05


def test_mean_drift(tmp_path, numbers):
    values = numbers(3, 2, 2)
    pairs = [(0.0, 0.0), (0.0, 90.0), (90.0, 90.0)]
    rows = [(p, n, k) for n in range(2) for p in range(3) for k in range(2)]
    text = "".join(
        f" {(8.0, 4.0)[n]} {pairs[p][0]} {pairs[p][1]} {(1, 6)[k]}{polar(values[p, n, k])}" for p, n, k in rows
    )
    for suffix in (".8", ".9"):
        path = put(tmp_path / f"a{suffix}", text)
        data = read_wamit_drift(path)
        assert data.modes == (1, 6)
        np.testing.assert_allclose(data.headings, pairs)
        np.testing.assert_allclose(data.force, values[:, ::-1], atol=1e-6)
        assert WAMIT_DRIFT.recognises(path, path.read_bytes())
    with pytest.raises(FormatError, match="1 fewer"):
        read_wamit_drift(put(tmp_path / "a.8", "".join(text.splitlines(keepends=True)[:-1])))


@pytest.mark.parametrize("kind", ["difference", "sum"])
def test_second_order_forces_and_their_mirrors(tmp_path, numbers, kind):
    """Half of the pairs of periods is in the file; the definition of the transfer functions gives the other half."""
    periods, full = [5.0, 7.0, 9.0], numbers(3, 3, 2)
    full = full + np.swapaxes(full, 0, 1).conj() if kind == "difference" else full + np.swapaxes(full, 0, 1)
    rows = [(i, j, k) for i in range(3) for j in range(i, 3) for k in range(2)]
    text = "".join(f" {periods[i]} {periods[j]} 0.0 0.0 {k + 1}{polar(full[i, j, k])}" for i, j, k in rows)
    path = put(tmp_path / f"a.12{kind[0]}", text)
    data = read_wamit_second_order(path)
    assert data.kind == kind
    np.testing.assert_allclose(data.force[0], full, atol=2e-6)  # seven digits of numbers up to 10
    assert WAMIT_SECOND_ORDER.recognises(path, path.read_bytes())
    assert dict(WAMIT_SECOND_ORDER.describe(data))["frequencies"] == f"{kind}, 100 % of the pairs of periods"


def test_second_order_of_two_headings(tmp_path):
    """The mirror of element (i, j) of headings (0, 30) is element (j, i) of headings (30, 0)."""
    path = put(tmp_path / "a.12d", f" 5 7 0 30 1{polar(1 + 2j)} 7 5 0 30 1{polar(3j)}")
    data = read_wamit_second_order(path)
    assert np.isnan(data.force).sum() == 2
    path = put(tmp_path / "a.12d", f" 5 7 0 30 1{polar(1 + 2j)} 7 5 0 30 1{polar(3j)} 5 5 30 0 1{polar(4j)}")
    data = read_wamit_second_order(path)
    np.testing.assert_allclose(data.force[1, 1, 0, 0], 1 - 2j)
    np.testing.assert_allclose(data.force[1, 0, 1, 0], -3j)
    np.testing.assert_allclose(data.force[0, 0, 0, 0], -4j)


def test_other_suffixes_are_refused(tmp_path):
    with pytest.raises(FormatError, match=r"\.12d"):
        read_wamit_second_order(put(tmp_path / "a.12", " 5 7 0 30 1 1 0 1 0\n"))


# the formatted output: a text of our own in the shape the manual describes
def out_text(hydro, centre=(0.0, 0.0, 0.0), bodies=1, excitation="DIFFRACTION", length=1.0) -> str:
    rho, g = hydro.density, hydro.gravity
    rotations = np.repeat([0, 1], 3)
    powers = length ** (rotations[:, None] + rotations)
    weight = weight_stiffness(rho * hydro.volume, centre, g)
    c = (hydro.hydrostatic_stiffness + weight) / (rho * g * length**2 * powers)
    lines = ["", "                        WAMIT  Version 7.0", "", "   Period       Time           RAD      DIFF"]
    lines += [f" {t:9.4f}    12:00:00          -1      -1" for t in (-1.0, 0.0, *(2 * np.pi / hydro.omega))] + [""]
    lines += [f" Gravity:     {g:.5f}                Length scale:        {length:.5f}"]
    lines += [f" Water depth:        {'infinite' if np.isinf(hydro.depth) else f'{hydro.depth:.5f}'}", ""]
    for _ in range(bodies):
        lines += [" XBODY =    0.0000 YBODY =    0.0000 ZBODY =    0.0000 PHIBODY =   0.0"]
        lines += [" Volumes (VOLX,VOLY,VOLZ): " + " ".join(f"{v:13.4f}" for v in (hydro.volume,) * 3)]
        lines += [" Center of Buoyancy (Xb,Yb,Zb): " + " ".join(f"{v:12.6f}" for v in hydro.centre_of_buoyancy)]
        lines += [" Hydrostatic and gravitational restoring coefficients:"]
        lines += [" C(3,3),C(3,4),C(3,5): " + " ".join(f"{v:14.7E}" for v in c[2, 2:5])]
        lines += [" C(4,4),C(4,5),C(4,6):      " + " ".join(f"{v:14.7E}" for v in c[3, 3:6])]
        lines += ["        C(5,5),C(5,6):                   " + " ".join(f"{v:14.7E}" for v in c[4, 4:6])]
        lines += [" Center of Gravity  (Xg,Yg,Zg): " + " ".join(f"{v:12.6f}" for v in centre), ""]
    for period in (-1.0, 0.0, *(2 * np.pi / hydro.omega)):
        name = {-1.0: "= infinite", 0.0: "= zero"}.get(period, f"(sec) = {period:13.6E}")
        lines += ["", f" Wave period {name}        Wavenumber (kL) = 1", "", "", "    ADDED-MASS COEFFICIENTS"]
        lines += ["     I     J         A(I,J)", ""]
        lines += _out_radiation(hydro, period, rho * length**3 * powers, bodies) + ["", ""]
        if period > 0:
            lines += [f"    {excitation} EXCITING FORCES AND MOMENTS", ""]
            lines += _out_excitation(hydro, period, rho * g * length ** (2.0 + rotations), bodies)
    return "\n".join(lines) + "\n"


def _out_radiation(hydro, period, scale, bodies) -> list[str]:
    if period > 0:
        n = int(np.argmin(np.abs(2 * np.pi / hydro.omega - period)))
        a, b = hydro.added_mass[n] / scale, hydro.radiation_damping[n] / scale / hydro.omega[n]
        values = [[f"{a[i, j]:14.6E} {b[i, j]:14.6E}" for j in range(6)] for i in range(6)]
    else:
        a = (hydro.added_mass_zero if period < 0 else hydro.added_mass_infinite) / scale
        values = [[f"{a[i, j]:14.6E}" for j in range(6)] for i in range(6)]
    return [
        f"{6 * s + i + 1:6d}{6 * s + j + 1:6d} {values[i][j]}"
        for s in range(bodies)
        for i in range(6)
        for j in range(6)
    ]


def _out_excitation(hydro, period, scale, bodies) -> list[str]:
    n = int(np.argmin(np.abs(2 * np.pi / hydro.omega - period)))
    lines = []
    for m, heading in enumerate(np.degrees(hydro.heading)):
        lines += [f"  Wave Heading (deg) : {heading:6.0f}", "", "     I     Mod[Xh(I)]     Pha[Xh(I)]", ""]
        f = hydro.excitation[m, n] / scale
        for s in range(bodies):
            lines += [f"{6 * s + i + 1:6d} {abs(f[i]):14.6E} {np.degrees(np.angle(f[i])):14.0f}" for i in range(6)]
        lines += ["", ""]
    return lines


# whole degrees: half a degree is 0.0087 rad, of the modulus
DEGREE = {"excitation": 0.009}


@pytest.mark.parametrize("excitation", ["DIFFRACTION", "HASKIND"])
@pytest.mark.parametrize(("centre", "length"), [((0.0, 0.0, 0.0), 1.0), ((1.0, -2.0, -13.0), 5.0)])
def test_out(tmp_path, centre, length, excitation):
    want = synthetic()
    path = put(tmp_path / "a.out", out_text(want, centre, excitation=excitation, length=length))
    got = read_wamit_out(path)
    # seven digits; the stiffness is left when the weight is taken off, of about its size, with six decimals of centres
    assert_equal(got, want, 1e-6, hydrostatic_stiffness=1e-4, **DEGREE)
    assert got.depth == 80.0
    assert got.volume == pytest.approx(want.volume)
    assert WAMIT_OUTPUT.recognises(path, path.read_bytes())


def test_out_of_several_bodies(tmp_path):
    want = synthetic()
    path = put(tmp_path / "a.out", out_text(want, bodies=2))
    with pytest.raises(FormatError, match=r"one body.*2: 1, 2.*body="):
        read_wamit_out(path)
    for body in (1, 2):
        assert_equal(read_wamit_out(path, body=body), want, 1e-6, hydrostatic_stiffness=1e-4, **DEGREE)
    with pytest.raises(FormatError, match="body 3"):
        read_wamit_out(path, body=3)


def test_out_infinite_depth_and_turned_body(tmp_path):
    want = synthetic(depth=np.inf)
    assert read_wamit_out(put(tmp_path / "a.out", out_text(want))).depth == np.inf
    turned = out_text(want).replace("PHIBODY =   0.0", "PHIBODY =  30.0")
    with pytest.raises(FormatError, match="PHIBODY"):
        read_wamit_out(put(tmp_path / "a.out", turned))


def test_damaged_out(tmp_path):
    text = out_text(synthetic(n=3))
    whole = read_wamit_out(put(tmp_path / "a.out", text))
    for _, cut in truncations(text.rstrip() + "\n"):
        with pytest.raises(FormatError):
            read_wamit_out(put(tmp_path / "a.out", cut))
    for _, bent in flips(text, 150):
        try:
            got = read_wamit_out(put(tmp_path / "a.out", bent))
        except FormatError:
            continue
        assert got.added_mass.shape == whole.added_mass.shape


@pytest.mark.reference
@pytest.mark.skipif("FOWTIO_FORMATS" not in os.environ, reason="FOWTIO_FORMATS names no folder")
def test_real_out_equals_its_numeric_files():
    folder = Path(os.environ["FOWTIO_FORMATS"]) / "wamit"
    got = read_wamit_out(folder / "ellipsoid.out", density=1000.0)
    want = read_wamit(folder / "ellipsoid", density=1000.0, gravity=9.81)
    assert_equal(got, want, 1e-9, hydrostatic_stiffness=1e-4, **DEGREE)  # five digits in the .out
    assert read_wamit_motion(folder / "only_RAO.4").modes == (9,)
