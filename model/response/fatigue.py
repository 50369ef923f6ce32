"""Fatigue in the frequency domain: stress ranges from spectra, S-N and T-N curves, damage over many states.

All spectral methods here give the range of a cycle as a mixture of Weibull distributions (Rayleigh is shape 2, exponential
shape 1), so one set of formulas in gamma functions gives damage under curves of one or two slopes, up to any largest range,
for any number of states and points at once. Moments are those of the one-sided spectrum in Hz.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import gamma, gammainc

from model.environment.sea import moments

RANGE_METHODS = ("dirlik", "tovo_benasciutti", "zhao_baker", "narrow_band")
ORDERS = (0, 1, 2, 4)
SECONDS_PER_YEAR = 365.25 * 86400
_NARROW = 1e-9  # 1 - irregularity below which a process is narrow-banded


@dataclass(frozen=True, eq=False, kw_only=True)
class RangeDistribution:
    """Stress ranges of processes (...): rate of cycles (...) [1/s], and k Weibull parts with weight (..., k), scale (..., k)
    [stress] and shape (..., k).
    """

    rate: np.ndarray
    weight: np.ndarray
    scale: np.ndarray
    shape: np.ndarray


@dataclass(frozen=True, eq=False, kw_only=True)
class EnduranceCurve:
    """Cycles to failure N = 10^intercept (range / unit)^-slope, with a second slope beyond a number of cycles.

    Parameters
    ----------
    name : of the curve
    slope, intercept : m and log10 a of the steep part
    unit : in which the intercept takes the range: 1e6 Pa for S-N curves, the breaking strength [N] for T-N curves
    second_slope, second_intercept : beyond `knee` cycles; None for one slope
    thickness_exponent, reference_thickness : k and t_ref [m] of the thickness effect

    Raises
    ------
    ValueError : a slope or unit that is not positive, or only one of the second slope and intercept.
    """

    name: str
    slope: float
    intercept: float
    unit: float = 1e6
    second_slope: float | None = None
    second_intercept: float | None = None
    thickness_exponent: float = 0.0
    reference_thickness: float = 0.025

    def __post_init__(self):
        if not (self.slope > 0 and self.unit > 0 and (self.second_slope is None or self.second_slope > 0)):
            raise ValueError(f"curve {self.name}: slopes and unit must be positive")
        if (self.second_slope is None) != (self.second_intercept is None):
            raise ValueError(f"curve {self.name}: the second slope needs its intercept, and the other way round")

    @property
    def knee(self) -> float:
        """Range at which the two lines meet, in the curve's own units times `unit`; 0 for one slope."""
        if self.second_slope is None or self.second_slope == self.slope:
            return 0.0
        return self.unit * 10 ** ((self.second_intercept - self.intercept) / (self.second_slope - self.slope))


# DNV-RP-C203 (2016 and 2019 editions), tables 2-1 (air), 2-2 (sea water with cathodic protection), 2-4 (free corrosion):
# m1, log a1, log a2 with m2 = 5; thickness exponent by class. Stress ranges in MPa.
_CLASSES = {
    "B1": (4.0, 15.117, 14.917, 12.436, 17.146, 0.0), "B2": (4.0, 14.885, 14.685, 12.262, 16.856, 0.0),
    "C": (3.0, 12.592, 12.192, 12.115, 16.320, 0.05), "C1": (3.0, 12.449, 12.049, 11.972, 16.081, 0.10),
    "C2": (3.0, 12.301, 11.901, 11.824, 15.835, 0.15), "D": (3.0, 12.164, 11.764, 11.687, 15.606, 0.20),
    "E": (3.0, 12.010, 11.610, 11.533, 15.350, 0.20), "F": (3.0, 11.855, 11.455, 11.378, 15.091, 0.25),
    "F1": (3.0, 11.699, 11.299, 11.222, 14.832, 0.25), "F3": (3.0, 11.546, 11.146, 11.068, 14.576, 0.25),
    "G": (3.0, 11.398, 10.998, 10.921, 14.330, 0.25), "W1": (3.0, 11.261, 10.861, 10.784, 14.101, 0.25),
    "W2": (3.0, 11.107, 10.707, 10.630, 13.845, 0.25), "W3": (3.0, 10.970, 10.570, 10.493, 13.617, 0.25),
}  # fmt: skip
ENVIRONMENTS = ("air", "seawater", "free_corrosion")
# T-N curves of API RP 2SK (2005), table 7: N (range of tension / breaking strength)^M = K; wire with the mean load L over
# the breaking strength. Stress-based curves of DNV-OS-E301 (2010), table F1: N = a s^-m with s in MPa.
_TENSION = {
    "studlink_chain": (3.0, 1000.0, 0.0), "studless_chain": (3.0, 316.0, 0.0), "kenter_shackle": (3.0, 178.0, 0.0),
    "six_strand_wire": (4.09, 10**3.20, -2.79), "spiral_strand_wire": (5.05, 10**3.25, -3.43),
}  # fmt: skip
_MOORING_STRESS = {"studlink_chain": (3.0, 1.2e11), "studless_chain": (3.0, 6.0e10), "six_strand_wire": (4.0, 3.4e14), "spiral_strand_wire": (4.8, 1.7e17)}


def sn_curve(detail: str, environment: str = "air", two_slopes: bool = True) -> EnduranceCurve:
    """Return a curve of DNV-RP-C203 (2016): detail B1 ... W3; environment of ENVIRONMENTS; stress ranges in Pa.

    two_slopes False keeps the first slope throughout; free corrosion has one. Raises ValueError for an unknown name.
    """
    if detail not in _CLASSES:
        raise ValueError(f"unknown S-N curve {detail!r}; DNV-RP-C203 has {', '.join(_CLASSES)}")
    if environment not in ENVIRONMENTS:
        raise ValueError(f"unknown environment {environment!r}; use one of {', '.join(ENVIRONMENTS)}")
    slope, air, sea, free, second, exponent = _CLASSES[detail]
    name = f"DNV-RP-C203 {detail}, {environment.replace('_', ' ')}"
    if environment == "free_corrosion":
        return EnduranceCurve(name=name, slope=3.0, intercept=free, thickness_exponent=exponent)
    pair = (5.0, second) if two_slopes else (None, None)
    return EnduranceCurve(
        name=name, slope=slope, intercept=air if environment == "air" else sea, second_slope=pair[0], second_intercept=pair[1],
        thickness_exponent=exponent,
    )  # fmt: skip


def tn_curve(component: str, breaking_strength: float, mean_load: float = 0.3) -> EnduranceCurve:
    """Return a T-N curve of API RP 2SK: component, breaking strength [N], mean load over it [-] (wire only).

    Raises ValueError for an unknown component.
    """
    if component not in _TENSION:
        raise ValueError(f"unknown mooring component {component!r}; use one of {', '.join(_TENSION)}")
    slope, k, fall = _TENSION[component]
    return EnduranceCurve(
        name=f"API RP 2SK {component.replace('_', ' ')}", slope=slope, intercept=float(np.log10(k) + fall * mean_load), unit=breaking_strength,
    )  # fmt: skip


def mooring_stress_curve(component: str) -> EnduranceCurve:
    """Return a curve of DNV-OS-E301 on the nominal stress range [Pa]: tension over pi d^2/2 of chain, pi d^2/4 of wire.

    Raises ValueError for an unknown component.
    """
    if component not in _MOORING_STRESS:
        raise ValueError(f"unknown mooring component {component!r}; use one of {', '.join(_MOORING_STRESS)}")
    slope, a = _MOORING_STRESS[component]
    return EnduranceCurve(name=f"DNV-OS-E301 {component.replace('_', ' ')}", slope=slope, intercept=float(np.log10(a)))


def mooring_area(component: str, diameter: float) -> float:
    """Return the nominal steel area [m2] of a chain or wire of nominal diameter [m] (DNV-OS-E301)."""
    return np.pi * diameter**2 / (2 if "chain" in component else 4)


def cycles_to_failure(curve: EnduranceCurve, stress_range, thickness: float | None = None) -> np.ndarray:
    """Return the cycles (...) to failure at ranges (...) in the curve's unit of load; thickness [m] adds its effect."""
    s = np.asarray(stress_range, dtype=float) * thickness_factor(curve, thickness)
    with np.errstate(divide="ignore"):
        first = 10**curve.intercept * (s / curve.unit) ** -curve.slope
        if not curve.knee:
            return first
        return np.where(s < curve.knee, 10**curve.second_intercept * (s / curve.unit) ** -curve.second_slope, first)


def thickness_factor(curve: EnduranceCurve, thickness: float | None) -> float:
    """Return the factor on stress of a wall thicker than the reference thickness (thesis eq. 8.7): (t / t_ref)^k, or 1."""
    return 1.0 if thickness is None else max(thickness / curve.reference_thickness, 1.0) ** curve.thickness_exponent


def weld_concentration(thickness: float, diameter: float, weld_width: float, misalignment: float | None = None) -> float:
    """Return the stress concentration of a girth weld between plates out of line (thesis eq. 8.8; DNV-RP-C203).

    thickness, outer diameter, width of the weld [m]; misalignment [m] is 0.15 of the thickness when not given.
    """
    offset = 0.15 * thickness if misalignment is None else misalignment
    return float(1 + 3 * offset / thickness * np.exp(-0.91 * weld_width / np.sqrt((diameter - thickness) * thickness)))


# --- from spectra to ranges -------------------------------------------------------------------------------------------


def stress_moments(spectrum, omega) -> np.ndarray:
    """Return the moments m0, m1, m2, m4 in Hz (..., 4) of one-sided spectra (..., n) [unit2/(rad/s)] on omega (n) [rad/s]."""
    return moments(spectrum, omega, np.array(ORDERS)) / (2 * np.pi) ** np.array(ORDERS)


def range_distribution(m, method: str = "dirlik") -> RangeDistribution:
    """Return the distribution of stress ranges of Gaussian processes.

    Parameters
    ----------
    m : (..., 4) moments m0, m1, m2, m4 in Hz
    method : "dirlik" (1985), "tovo_benasciutti" (2005), "zhao_baker" (1992), "narrow_band" (Rayleigh at the rate of
        upcrossings)

    Returns
    -------
    RangeDistribution of (...); a process without variance has the rate 0

    Raises
    ------
    ValueError : an unknown method.
    """
    if method not in RANGE_METHODS:
        raise ValueError(f"unknown method {method!r}; use one of {', '.join(RANGE_METHODS)}")
    m = np.asarray(m, dtype=float)
    alive = m[..., 0] > 0
    m0, m1, m2, m4 = (np.where(alive, m[..., k], 1.0) for k in range(4))
    irregularity = np.clip(m2 / np.sqrt(m0 * m4), 1e-12, 1.0)
    weight, scale, shape = _PARTS[method](m0, m1, m2, m4, irregularity)
    rate = np.sqrt(m2 / m0 if method == "narrow_band" else m4 / m2)
    return RangeDistribution(
        rate=np.where(alive, rate, 0.0), weight=weight, scale=scale * 2 * np.sqrt(np.where(alive, m[..., 0], 0.0))[..., None],
        shape=np.broadcast_to(shape, weight.shape),
    )  # fmt: skip


def _narrow_parts(m0, m1, m2, m4, irregularity):
    one = np.ones_like(irregularity)[..., None]
    return one, np.sqrt(2) * one, 2.0 * one


def _dirlik_parts(m0, m1, m2, m4, irregularity):
    """Exponential and two Rayleigh parts; Dirlik (1985), as thesis eq. 8.10 to 8.14 with D3 in the third term."""
    g, x = irregularity, m1 / m0 * np.sqrt(m2 / m4)
    narrow = 1 - g < _NARROW
    g, x = np.where(narrow, 0.5, g), np.where(narrow, 0.4, x)
    d1 = 2 * (x - g**2) / (1 + g**2)
    r = (g - x - d1**2) / (1 - g - d1 + d1**2)
    gap = np.where(np.abs(1 - r) < 1e-12, 1e-12, 1 - r)
    d2 = (1 - g - d1 + d1**2) / gap
    d3 = 1 - d1 - d2
    q = 1.25 * (g - d3 - d2 * r) / np.where(np.abs(d1) < 1e-14, 1e-14, d1)
    weight = np.stack([np.where(narrow, 0.0, d1), np.where(narrow, 0.0, d2), np.where(narrow, 1.0, d3)], axis=-1)
    scale = np.stack([np.maximum(q, 0.0), np.sqrt(2) * np.abs(r), np.broadcast_to(np.sqrt(2), g.shape)], axis=-1)
    return weight, scale, np.array([1.0, 2.0, 2.0])


def _tovo_parts(m0, m1, m2, m4, irregularity):
    """Between level-crossing and range counting; Tovo and Benasciutti, Int. J. Fatigue 27 (2005) 867.

    Of the peaks a fraction a2 are cycles of the narrow-band distribution in level crossing, and all are cycles of a Rayleigh
    distribution smaller by a2 in range counting; b is how far the one is from the other.
    """
    a2 = irregularity
    a1 = np.clip(m1 / np.sqrt(m0 * m2), 1e-12, 1.0)
    rest = np.maximum((1 - a2) ** 2, 1e-30)
    b = (a1 - a2) * (1.112 * (1 + a1 * a2 - (a1 + a2)) * np.exp(2.11 * a2) + (a1 - a2)) / rest
    b = np.where(1 - a2 < 1e-7, 1.0, b)
    weight = np.stack([b * a2, 1 - b], axis=-1)
    return weight, np.sqrt(2) * np.stack([np.ones_like(a2), a2], axis=-1), np.array([2.0, 2.0])


def _zhao_parts(m0, m1, m2, m4, irregularity):
    """Weibull and Rayleigh parts; Zhao and Baker, Int. J. Fatigue 14 (1992) 121."""
    g = irregularity
    a, b = 8 - 7 * g, np.where(g < 0.9, 1.1, 1.1 + 9 * (g - 0.9))
    bottom = 1 - np.sqrt(2 / np.pi) * gamma(1 + 1 / b) * a ** (-1 / b)
    w = np.clip((1 - g) / bottom, 0.0, 1.0)
    weight = np.stack([w, 1 - w], axis=-1)
    scale = np.stack([a ** (-1 / b), np.broadcast_to(np.sqrt(2), g.shape)], axis=-1)
    return weight, scale, np.stack([b, np.broadcast_to(2.0, g.shape)], axis=-1)


_PARTS = {"dirlik": _dirlik_parts, "tovo_benasciutti": _tovo_parts, "zhao_baker": _zhao_parts, "narrow_band": _narrow_parts}


def range_moment(ranges: RangeDistribution, power: float, low=None, high=None) -> np.ndarray:
    """Return E[S^power] (...) of the ranges between low and high (...) [stress], by default all of them.

    Each Weibull part gives scale^m Gamma(1 + m/shape) P(1 + m/shape, (s/scale)^shape), P the incomplete gamma function.
    """
    order = 1 + power / ranges.shape
    whole = ranges.weight * ranges.scale**power * gamma(order)
    part = 1.0
    if high is not None:
        part = gammainc(order, _reduced(ranges, high))
    if low is not None:
        part = part - gammainc(order, _reduced(ranges, low))
    return np.sum(whole * part, axis=-1)


def _reduced(ranges: RangeDistribution, level) -> np.ndarray:
    level = np.asarray(level, dtype=float)[..., None]
    safe = np.where(ranges.scale > 0, ranges.scale, 1.0)
    return np.where(ranges.scale > 0, np.minimum(level / safe, 1e100) ** ranges.shape, np.inf)


def exceedance_fraction(ranges: RangeDistribution, level) -> np.ndarray:
    """Return the fraction (...) of cycles with a range above a level (...)."""
    with np.errstate(over="ignore"):
        return np.sum(ranges.weight * np.exp(-_reduced(ranges, level)), axis=-1)


def largest_range(ranges: RangeDistribution, duration: float, expected: float = 1.0) -> np.ndarray:
    """Return the range (...) that is exceeded `expected` times in a duration [s]: the upper bound of thesis eq. 8.17.

    0 where there are fewer cycles than that.
    """
    target = expected / np.maximum(ranges.rate * duration, expected)
    low = np.zeros(ranges.rate.shape)
    high = 12.0 * ranges.scale.max(axis=-1) + 1e-300
    for _ in range(60):
        middle = (low + high) / 2
        above = exceedance_fraction(ranges, middle) > target
        low, high = np.where(above, middle, low), np.where(above, high, middle)
    return high * (ranges.rate * duration > expected)


def damage_rate(ranges: RangeDistribution, curve: EnduranceCurve, factor=1.0, upper=None) -> np.ndarray:
    """Return the damage (...) per second: the rate of cycles times E[1 / N(S)], after Miner.

    Parameters
    ----------
    ranges : distribution of nominal ranges (...)
    curve : S-N or T-N curve
    factor : (...) on the ranges: stress concentration times thickness effect
    upper : (...) largest nominal range that is integrated to, None for infinity

    Returns
    -------
    (...) [1/s]
    """
    factor = np.asarray(factor, dtype=float)
    first = (factor / curve.unit) ** curve.slope * 10**-curve.intercept
    if not curve.knee:
        return ranges.rate * first * range_moment(ranges, curve.slope, high=upper)
    with np.errstate(divide="ignore"):
        knee = curve.knee / factor
    knee = np.broadcast_to(knee, ranges.rate.shape)
    below = knee if upper is None else np.minimum(knee, upper)
    second = (factor / curve.unit) ** curve.second_slope * 10**-curve.second_intercept
    small = second * range_moment(ranges, curve.second_slope, high=below)
    top = range_moment(ranges, curve.slope, low=below, high=upper) if upper is not None else (
        range_moment(ranges, curve.slope) - range_moment(ranges, curve.slope, high=below)
    )
    return ranges.rate * (small + first * top)


def equivalent_range(ranges: RangeDistribution, power: float, cycle_rate: float = 1.0, upper=None) -> np.ndarray:
    """Return the damage-equivalent range (...): constant ranges at a rate [1/s] that do the same damage at slope `power`."""
    return (ranges.rate / cycle_rate * range_moment(ranges, power, high=upper)) ** (1 / power)


# --- sections ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False, kw_only=True)
class TubeSection:
    """A circular tube: outer diameter and wall thickness [m]."""

    diameter: float
    thickness: float

    def __post_init__(self):
        if not 0 < self.thickness <= self.diameter / 2:
            raise ValueError(f"a tube of diameter {self.diameter:g} m cannot have a wall of {self.thickness:g} m")

    @property
    def area(self) -> float:
        """Area of the steel [m2]."""
        return float(np.pi * self.thickness * (self.diameter - self.thickness))

    @property
    def second_moment(self) -> float:
        """Second moment of area about a diameter [m4]."""
        return float(np.pi / 64 * (self.diameter**4 - (self.diameter - 2 * self.thickness) ** 4))

    @property
    def modulus(self) -> float:
        """Section modulus of the outer fibre [m3]."""
        return 2 * self.second_moment / self.diameter


def stress_rows(section: TubeSection, angles) -> np.ndarray:
    """Return L (p, 2) with (stress at the outside) = L (Mx, My): points at angles (p) from downwind, counter-clockwise.

    Moments [N m] are those of the part above on the part below, about x and y; tension is positive: (Mx sin - My cos) / W.
    """
    angles = np.asarray(angles, dtype=float)
    return np.stack([np.sin(angles), -np.cos(angles)], axis=-1) / section.modulus


def moments_around(rows, cross) -> np.ndarray:
    """Return stress moments (..., p, 4) at the points of rows (p, c) from cross-spectral moments (..., 4, c, c) of the loads.

    The stress spectrum is L S L^H, and only the real part of S counts for real L, so the moments need not be formed anew at
    every point: they are quadratic forms of the same few matrices.
    """
    out = np.einsum("pi,...kij,pj->...pk", rows, cross, rows, optimize=True)
    return np.maximum(out, 0.0)


def cross_moments(transfers, spectra, omega) -> np.ndarray:
    """Return real cross-spectral moments m0, m1, m2, m4 in Hz (..., 4, c, c) of loads that several causes drive.

    transfers (k, n, c) complex, of causes that are not correlated; spectra (..., k, n) one-sided [unit2/(rad/s)]; omega (n)
    [rad/s]. Phases between loads are kept: this is the real part of sum_k H S H^H.
    """
    omega = np.asarray(omega, dtype=float)
    transfers = np.asarray(transfers)
    step = np.zeros_like(omega)
    step[:-1] += np.diff(omega) / 2
    step[1:] += np.diff(omega) / 2
    pair = np.einsum("kni,knj->knij", transfers, transfers.conj()).real
    orders = np.array(ORDERS)[:, None]
    kernel = (step * (omega / (2 * np.pi)) ** orders)[:, None, :, None, None] * pair
    c = transfers.shape[-1]
    flat = np.asarray(spectra).reshape(*np.shape(spectra)[:-2], -1) @ np.moveaxis(kernel, 0, 2).reshape(-1, 4 * c * c)
    return flat.reshape(*flat.shape[:-1], 4, c, c)


# --- histories --------------------------------------------------------------------------------------------------------


def synthesise(spectrum, omega, duration: float, step: float, rng: np.random.Generator, count: int = 1) -> np.ndarray:
    """Return histories (count, n) of a Gaussian process with a one-sided spectrum (m) [unit2/(rad/s)] on omega (m) [rad/s].

    duration and step [s], n the number of steps. Each harmonic has the variance of its band, the integral of the spectrum
    from half a harmonic below to half above, so narrow peaks lose nothing; real and imaginary parts are normal.
    """
    n = round(duration / step)
    spectrum, omega = np.asarray(spectrum, dtype=float), np.asarray(omega, dtype=float)
    total = np.concatenate([[0.0], np.cumsum((spectrum[1:] + spectrum[:-1]) / 2 * np.diff(omega))])
    edges = 2 * np.pi * (np.arange(n // 2 + 2) - 0.5) / (n * step)
    variance = np.diff(np.interp(edges, omega, total))
    variance[0] = 0.0
    amplitude = np.sqrt(variance) / np.sqrt(2) * (rng.standard_normal((count, len(variance))) + 1j * rng.standard_normal((count, len(variance))))
    return np.fft.irfft(amplitude * n / np.sqrt(2), n=n, axis=-1)

