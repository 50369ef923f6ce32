"""The turbulence that a turning rotor feels: its collective part and its gradients, sampled by the blades.

Blades pass through eddies that change more slowly than they turn, so that part of the energy moves to multiples of the
blade-passing frequency. The field over the disk is taken apart into azimuthal modes u_k(r, t) e^{i k theta}, which are
uncorrelated by symmetry; B blades at equal spacing let through, for a collective load, the modes k = B j at the
frequency shifted by B j Omega, and for a load with one lobe (tilt or yaw moment) the modes k = B j - 1 and B j + 1.
References: Kristensen and Frandsen, "Model for power spectra of the blade of a wind turbine measured from the moving
frame of reference", J. Wind Eng. Ind. Aerodyn. 10, 1982; Connell, Solar Energy 29, 1982.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from model.conventions import freeze
from model.environment.wind import WindState, coherence_rate, wind_spectrum

_HARMONICS = 2
_ROOT = 0.15
_RADII, _THETA = 14, 48


@dataclass(frozen=True, eq=False, kw_only=True)
class RotorSensitivity:
    """How strongly the wind at a radius drives a blade's thrust: radius (r) [m], weight (r) per length, relative; quadrature
    step (r) [m]; the number of blades; rotor_speed [rad/s], zero without rotational sampling.
    """

    radius: np.ndarray
    weight: np.ndarray
    step: np.ndarray
    blades: int
    rotor_speed: float

    def __post_init__(self):
        freeze(self, radius=("r",), weight=("r",), step=("r",))

    @cached_property
    def mode_tables(self) -> tuple[_ModeTable, _ModeTable]:
        """Weighted coherence of the azimuthal modes, for collective loads and for moments."""
        orders = self.blades * _HARMONICS + 1
        return _ModeTable(self, 0, orders), _ModeTable(self, 1, orders)

    @property
    def gradient_arm(self) -> float:
        """Moment about the hub of a unit gradient over thrust of a unit wind [m2]: integral w r2 / (2 integral w)."""
        share = self.weight * self.step
        return float(share @ self.radius**2 / (2 * share.sum()))


def rotor_sensitivity(diameter: float, blades: int, rotor_speed: float, mean_speed: float) -> RotorSensitivity:
    """Return the sensitivity of a well-designed blade: in proportion to the radius, less Prandtl's tip loss, nothing at the root.

    diameter [m]; rotor_speed [rad/s]; mean_speed [m/s]. The inflow angle of the tip loss is that of the optimum
    rotor, 2/3 of the wind over the blade's own speed.
    """
    tip = diameter / 2
    nodes, weights = np.polynomial.legendre.leggauss(_RADII)
    low = _ROOT * tip
    radius = low + (nodes + 1) / 2 * (tip - low)
    loss = np.ones_like(radius)
    if rotor_speed > 0 and blades > 0:
        angle = np.arctan2(2 / 3 * mean_speed, rotor_speed * radius)
        loss = 2 / np.pi * np.arccos(np.exp(-blades / 2 * (tip - radius) / (radius * np.sin(angle))))
    return RotorSensitivity(
        radius=radius, weight=radius * loss, step=weights / 2 * (tip - low), blades=blades, rotor_speed=rotor_speed
    )


def rotor_spectra(wind: WindState, rotor: RotorSensitivity, omega) -> tuple[np.ndarray, np.ndarray]:
    """Return the spectra (n), (n) of the rotor's effective wind and of its gradients, one-sided.

    The collective wind [(m/s)2/(rad/s)] gives the same thrust on a rotor of this sensitivity as the field does; the
    gradients [(m/s/m)2/(rad/s)], vertical and lateral alike, give the same tilt and yaw moments. The three are
    uncorrelated. With wind.averaging "point" the collective wind is that at the hub and there are no gradients.
    """
    omega = np.asarray(omega, dtype=float)
    if wind.averaging == "point" or wind.spectrum == "none":
        return wind_spectrum(wind, omega), np.zeros_like(omega)
    harmonics = range(-_HARMONICS, _HARMONICS + 1) if rotor.rotor_speed > 0 else (0,)
    step = rotor.blades * rotor.rotor_speed
    collective, gradient = np.zeros((2, len(omega)))
    modes = rotor.mode_tables
    for j in harmonics:
        shifted = np.abs(omega - j * step)
        shifted = np.maximum(shifted, omega.min())
        spectrum, rate = wind_spectrum(wind, shifted), coherence_rate(wind, shifted)
        collective += spectrum * modes[0](rotor.blades * j, rate)
        gradient += spectrum * (modes[1](rotor.blades * j - 1, rate) + modes[1](rotor.blades * j + 1, rate))
    share = rotor.weight * rotor.step
    per_gradient = share @ rotor.radius**2
    return collective / share.sum() ** 2, gradient / per_gradient**2


class _ModeTable:
    """Weighted coherence of the azimuthal modes, tabulated over the coherence rate: the only thing that frequency changes."""

    def __init__(self, rotor: RotorSensitivity, power: int, orders: int):
        share = rotor.weight * rotor.step * rotor.radius**power
        theta = (np.arange(_THETA) + 0.5) * np.pi / _THETA
        r, s = rotor.radius[:, None, None], rotor.radius[None, :, None]
        distance = np.sqrt(np.maximum(r**2 + s**2 - 2 * r * s * np.cos(theta), 0.0))
        self.rate = np.geomspace(1e-5, 10.0, 120)
        pairs = np.outer(share, share)
        cosines = np.cos(np.outer(np.arange(orders + 1), theta)) / _THETA
        self.values = np.array([
            np.einsum("rs,rst,kt->k", pairs, np.exp(-rate * distance), cosines, optimize=True) for rate in self.rate
        ])  # fmt: skip

    def __call__(self, order: int, rate: np.ndarray) -> np.ndarray:
        """Return the weighted coherence of mode +-order at coherence rates (n) [1/m]."""
        return np.interp(np.log(np.clip(rate, 1e-5, 10.0)), np.log(self.rate), self.values[:, abs(order)])
