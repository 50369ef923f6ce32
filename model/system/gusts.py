"""Thrust in turbulence: what the curvature of the thrust over the wind makes of its mean and of its slope.

A turbine's linearisation belongs to a steady wind. In turbulence every blade section meets a Gaussian wind of the standard deviation of
a point, and the slope that fits best in the mean square is E[T(U + u) u] / E[u^2] (statistical linearisation; Roberts and Spanos,
1990), with the thrust curve at the rotor speed and blade pitch of the operating point: gusts stall the blades. The wake is taken as
in balance with the wind at each section, as quasi-steady blade-element momentum theory has it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from model.system.aero import RotorPerformance
from model.system.turbine import TurbineMatrices

_NODES, _WEIGHTS = np.polynomial.hermite_e.hermegauss(32)
_WEIGHTS = _WEIGHTS / _WEIGHTS.sum()


@dataclass(frozen=True, kw_only=True)
class GustThrust:
    """Thrust in turbulence of a standard deviation [m/s] at a point: gain, its slope over that in steady wind; change [N] of its mean;
    pitch [rad] at which the table was read.
    """

    std: float
    gain: float
    change: float
    pitch: float


def gust_thrust(rotor: RotorPerformance, wind_speed: float, rotor_speed: float, thrust: float, std: float) -> GustThrust:
    """Return the thrust's gain and the change of its mean in turbulence.

    wind_speed and std [m/s], rotor_speed [rad/s], thrust [N] in steady wind, which says at what blade pitch the table is read.
    Raises ValueError where the table does not reach.
    """
    pitch = _pitch_of_thrust(rotor, wind_speed, rotor_speed, thrust)
    speeds = wind_speed + std * _NODES
    values = _thrust(rotor, np.maximum(speeds, 1e-3), rotor_speed, pitch)
    mean, slope = float(_WEIGHTS @ values), float(_WEIGHTS @ (values * _NODES)) / std
    near = 0.01 * wind_speed
    low, middle, high = _thrust(rotor, wind_speed + near * np.array([-1.0, 0.0, 1.0]), rotor_speed, pitch)
    return GustThrust(std=std, gain=slope / ((high - low) / (2 * near)), change=mean - float(middle), pitch=pitch)


def in_turbulence(turbine: TurbineMatrices, gust: GustThrust, hub_row) -> TurbineMatrices:
    """Return a turbine whose wind forces, and the damping by its hub's motion against the wind, have the gain of turbulence.

    hub_row (q) is the hub's translation downwind per unit of each degree of freedom. The mean force stays that of steady wind.
    """
    less = gust.gain - 1
    return replace(
        turbine, damping=turbine.damping + less * np.outer(turbine.wind_force, hub_row), wind_force=gust.gain * turbine.wind_force,
        gradient_force=gust.gain * turbine.gradient_force,
    )  # fmt: skip


def _thrust(rotor: RotorPerformance, speeds, rotor_speed: float, pitch: float) -> np.ndarray:
    """Return the thrust (k) [N] at wind speeds (k); the coefficient keeps its edge values outside the table's tip speed ratios."""
    ratio = np.clip(rotor_speed * rotor.radius / speeds, rotor.tip_speed_ratio[0], rotor.tip_speed_ratio[-1])
    return rotor.pressure_area * speeds**2 * rotor.thrust_spline.ev(ratio, np.full_like(ratio, pitch))


def _pitch_of_thrust(rotor: RotorPerformance, wind_speed: float, rotor_speed: float, thrust: float) -> float:
    """Return the blade pitch [rad] towards feather at which the table has a thrust, that of its largest thrust when it has less."""
    ratio = rotor_speed * rotor.radius / wind_speed
    if not rotor.tip_speed_ratio[0] <= ratio <= rotor.tip_speed_ratio[-1]:
        raise ValueError(f"tip speed ratio {ratio:.2f} is outside the rotor table ({rotor.tip_speed_ratio[0]:g} to {rotor.tip_speed_ratio[-1]:g})")

    def excess(pitch):
        return float(_thrust(rotor, np.array([wind_speed]), rotor_speed, pitch)[0]) - thrust

    over = np.array([excess(p) for p in rotor.pitch])
    first = int(np.argmax(over))
    if over[first] <= 0:
        return float(rotor.pitch[first])
    below = np.flatnonzero(over[first:] < 0)
    if not len(below):
        raise ValueError(f"the rotor table has no blade pitch with a thrust as small as {thrust / 1e3:.0f} kN at {wind_speed:g} m/s")
    last = first + int(below[0])
    return float(brentq(excess, rotor.pitch[last - 1], rotor.pitch[last]))
