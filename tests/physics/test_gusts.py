"""Thrust in turbulence against thrust curves with known means, and the embedded turbine against OpenFAST in turbulent wind."""

from pathlib import Path

import numpy as np
import pytest

import fowtio
from model.system.aero import RotorPerformance
from model.system.gusts import gust_thrust, in_turbulence
from model.system.turbine import TurbineMatrices

VALIDATION = Path(__file__).resolve().parents[2] / "validation"
RATIO, PITCH = np.linspace(2.0, 14.0, 49), np.radians(np.linspace(-5.0, 25.0, 31))
SPEED, STD, ROTOR = 11.0, 1.5, 1.2


def rotor(coefficient):
    """A rotor of 60 m with a thrust coefficient of tip speed ratio (t, 1) and pitch (1, p)."""
    thrust = coefficient(RATIO[:, None], PITCH[None]) * np.ones((len(RATIO), len(PITCH)))
    return RotorPerformance(pitch=PITCH, tip_speed_ratio=RATIO, power=0.5 * thrust, thrust=thrust, radius=60.0)


def steady(curve, pitch=0.05):
    ratio = ROTOR * 60.0 / SPEED
    return curve.pressure_area * SPEED**2 * float(curve.thrust_spline(ratio, pitch)[0, 0])


def test_thrust_with_the_square_of_the_wind():
    """A constant coefficient: E (U + u)^2 = U^2 + s^2, and the slope stays 2 U."""
    curve = rotor(lambda ratio, pitch: 0.8 - 0.5 * pitch)
    found = gust_thrust(curve, SPEED, ROTOR, steady(curve), STD)
    assert found.pitch == pytest.approx(0.05, abs=1e-9)
    assert found.gain == pytest.approx(1.0, abs=1e-9)
    assert found.change == pytest.approx(curve.pressure_area * (0.8 - 0.5 * 0.05) * STD**2)


def test_thrust_with_the_cube_of_the_wind():
    """A coefficient with the wind, 1 / tip speed ratio: slope 3 U^2 + 3 s^2, mean U^3 + 3 U s^2."""
    curve = rotor(lambda ratio, pitch: (1 - pitch) / ratio)
    thrust = steady(curve)
    found = gust_thrust(curve, SPEED, ROTOR, thrust, STD)
    # bicubic spline of 1 / ratio with steps of 0.25, and winds beyond the table's edge (3 standard deviations) with its edge value
    assert found.gain == pytest.approx(1 + STD**2 / SPEED**2, rel=2e-3)
    assert found.change == pytest.approx(3 * thrust * STD**2 / SPEED**2, rel=5e-3)


def test_calm_air_is_the_limit():
    curve = rotor(lambda ratio, pitch: 0.9 * np.exp(-((ratio - 6) ** 2) / 20) - pitch)
    found = gust_thrust(curve, SPEED, ROTOR, steady(curve), 0.01)
    assert found.gain == pytest.approx(1.0, abs=1e-3)  # slope by a difference over 1 % of the wind
    assert found.change == pytest.approx(0.0, abs=1e-4 * steady(curve))


def test_what_the_table_does_not_have_is_named():
    curve = rotor(lambda ratio, pitch: 0.8 - 0.5 * pitch)
    with pytest.raises(ValueError, match=r"tip speed ratio 36\.00 is outside the rotor table"):
        gust_thrust(curve, 2.0, ROTOR, 1e5, 0.5)
    with pytest.raises(ValueError, match="no blade pitch with a thrust as small as 1 kN"):
        gust_thrust(curve, SPEED, ROTOR, 1e3, STD)


def test_a_hub_that_moves_with_the_wind_feels_none():
    """Wind force and damping change together: without wind and rotor damping alone, u = v leaves no force."""
    force, row = np.array([8e4, 0, 0, 0, 7e6, 0]), np.array([1.0, 0, 0, 0, 90.0, 0])
    zero = np.zeros((6, 6))
    turbine = TurbineMatrices(
        dofs=("surge", "sway", "heave", "roll", "pitch", "yaw"), mass=zero, damping=np.outer(force, row), stiffness=zero,
        force=np.zeros(6), point=np.zeros(6), wind_force=force,
    )  # fmt: skip
    curve = rotor(lambda ratio, pitch: (1 - pitch) / ratio)
    found = in_turbulence(turbine, gust_thrust(curve, SPEED, ROTOR, steady(curve), STD), row)
    rate = np.array([0.3, 0, 0, 0, 0.01, 0])
    assert np.allclose(found.wind_force * (row @ rate), found.damping @ rate)
    assert found.wind_force[0] > force[0]


def test_openfasts_thrust_in_turbulence_is_smaller_on_average():
    """The embedded turbine at 11 m/s: mean thrust of three turbulent records less that of steady wind."""
    model = fowtio.build(fowtio.load(VALIDATION / "oc4_deepcwind" / "oc4.fowt"))
    note = next(n for n in model.notes if n.startswith("thrust at 11 m/s"))
    predicted = 1e3 * float(note.split("mean ")[1].split(" kN")[0])
    folder = VALIDATION / "oc4_deepcwind" / "reference"
    records = [fowtio.read_timeseries(folder / f"ww11_s{k}.outb") for k in (1, 2, 3)]
    means = np.array([_thrust(r).mean() for r in records])
    calm = _thrust(fowtio.read_timeseries(folder / "steady.outb")).mean()
    # the records' mean winds differ by chance: three standard errors of three seeds, some 4 kN, against a change of 10
    assert predicted == pytest.approx(means.mean() - calm, abs=3 * means.std(ddof=1) / np.sqrt(3))
    assert predicted < -5e3


def _thrust(series):
    return series.data[series.time >= 1000.0, series.names.index("RtAeroFxh")]
