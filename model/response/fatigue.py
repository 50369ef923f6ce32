"""Fatigue in the frequency domain: stress ranges from spectra, S-N and T-N curves, damage over many states.

All spectral methods here give the range of a cycle as a mixture of Weibull distributions (Rayleigh is shape 2,
exponential shape 1), so one set of formulas in gamma functions gives damage under curves of one or two slopes, up to
any largest range, for any number of states and points at once. Moments are those of the one-sided spectrum in Hz.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import gamma, gammainc

from model.environment.sea import moments
from model.response.endurance import EnduranceCurve

RANGE_METHODS = ("dirlik", "tovo_benasciutti", "zhao_baker", "narrow_band")
ORDERS = (0, 1, 2, 4)
SECONDS_PER_YEAR = 365.25 * 86400
_NARROW = 1e-9  # 1 - irregularity below which a process is narrow-banded


@dataclass(frozen=True, eq=False, kw_only=True)
class RangeDistribution:
    """Stress ranges of processes (...): rate of cycles (...) [1/s], and k Weibull parts with weight (..., k), scale
    (..., k) [stress] and shape (..., k).
    """

    rate: np.ndarray
    weight: np.ndarray
    scale: np.ndarray
    shape: np.ndarray


# --- from spectra to ranges -------------------------------------------------------------------------------------------


def stress_moments(spectrum, omega) -> np.ndarray:
    """Return the moments m0, m1, m2, m4 in Hz (..., 4) of one-sided spectra (..., n) [unit2/(rad/s)] on omega (n)
    [rad/s].
    """
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
        rate=np.where(alive, rate, 0.0),
        weight=weight,
        scale=scale * 2 * np.sqrt(np.where(alive, m[..., 0], 0.0))[..., None],
        shape=np.broadcast_to(shape, weight.shape),
    )


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

    Of the peaks a fraction a2 are cycles of the narrow-band distribution in level crossing, and all are cycles of a
    Rayleigh distribution smaller by a2 in range counting; b is how far the one is from the other.
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


_PARTS = {
    "dirlik": _dirlik_parts,
    "tovo_benasciutti": _tovo_parts,
    "zhao_baker": _zhao_parts,
    "narrow_band": _narrow_parts,
}


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
    top = (
        range_moment(ranges, curve.slope, low=below, high=upper)
        if upper is not None
        else (range_moment(ranges, curve.slope) - range_moment(ranges, curve.slope, high=below))
    )
    return ranges.rate * (small + first * top)


def equivalent_range(ranges: RangeDistribution, power: float, cycle_rate: float = 1.0, upper=None) -> np.ndarray:
    """Return the damage-equivalent range (...): constant ranges at a rate [1/s] that do the same damage at slope
    `power`.
    """
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

    Moments [N m] are those of the part above on the part below, about x and y; tension is positive: (Mx sin - My cos) /
    W.
    """
    angles = np.asarray(angles, dtype=float)
    return np.stack([np.sin(angles), -np.cos(angles)], axis=-1) / section.modulus


def moments_around(rows, cross) -> np.ndarray:
    """Return stress moments (..., p, 4) at the points of rows (p, c) from cross-spectral moments (..., 4, c, c) of the
    loads.

    The stress spectrum is L S L^H, and only the real part of S counts for real L, so the moments need not be formed
    anew at every point: they are quadratic forms of the same few matrices.
    """
    out = np.einsum("pi,...kij,pj->...pk", rows, cross, rows, optimize=True)
    return np.maximum(out, 0.0)


def cross_moments(transfers, spectra, omega) -> np.ndarray:
    """Return real cross-spectral moments m0, m1, m2, m4 in Hz (..., 4, c, c) of loads that several causes drive.

    transfers (k, n, c) complex, of causes that are not correlated; spectra (..., k, n) one-sided [unit2/(rad/s)]; omega
    (n) [rad/s]. Phases between loads are kept: this is the real part of sum_k H S H^H.
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
    """Return histories (count, n) of a Gaussian process with a one-sided spectrum (m) [unit2/(rad/s)] on omega (m)
    [rad/s].

    duration and step [s], n the number of steps. Each harmonic has the variance of its band, the integral of the
    spectrum from half a harmonic below to half above, so narrow peaks lose nothing; real and imaginary parts are
    normal.
    """
    n = round(duration / step)
    spectrum, omega = np.asarray(spectrum, dtype=float), np.asarray(omega, dtype=float)
    total = np.concatenate([[0.0], np.cumsum((spectrum[1:] + spectrum[:-1]) / 2 * np.diff(omega))])
    edges = 2 * np.pi * (np.arange(n // 2 + 2) - 0.5) / (n * step)
    variance = np.diff(np.interp(edges, omega, total))
    variance[0] = 0.0
    amplitude = (
        np.sqrt(variance)
        / np.sqrt(2)
        * (rng.standard_normal((count, len(variance))) + 1j * rng.standard_normal((count, len(variance))))
    )
    return np.fft.irfft(amplitude * n / np.sqrt(2), n=n, axis=-1)
