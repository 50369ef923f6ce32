"""The sea: wave spectra and directional spreading; linear waves come from airy.py.

Spectra are one-sided in m2/(rad/s), so that the variance of the elevation is their integral over omega and
m0 = Hs^2/16. Headings are directions of propagation. All spectra with a peak are sums of at most two wave systems,
each a generalised gamma shape x^-n exp(-(n/m) x^-m) of x = omega / peak frequency, normalised to unit area:
n = 5, m = 4 is Pierson-Moskowitz.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.integrate import trapezoid
from scipy.special import betainc, gammaln

from model.conventions import freeze
from model.environment.airy import WaveKinematics, wave_kinematics, wavenumber

__all__ = [
    "KINDS",
    "SeaState",
    "WaveKinematics",
    "default_gamma",
    "directional_spectrum",
    "moments",
    "most_probable_systems",
    "significant_height",
    "spreading_weights",
    "wave_kinematics",
    "wave_spectrum",
    "wavenumber",
]

KINDS = ("jonswap", "pierson_moskowitz", "white_noise", "torsethaugen", "ochi_hubble", "table", "still")
STANDARD_GRAVITY = 9.80665  # m/s2; enters the Torsethaugen peakedness only
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(100)


@dataclass(frozen=True, eq=False, kw_only=True)
class SeaState:
    """One sea: a spectrum, a heading and a spreading.

    Parameters
    ----------
    kind : one of KINDS
    significant_height : Hs = 4 sqrt(m0) [m]; for all kinds but table and still (white_noise: this or level)
    peak_period : Tp [s]; for jonswap, pierson_moskowitz and torsethaugen
    gamma : JONSWAP peak factor [-]; None takes `default_gamma`
    normalisation : "iec" (factor 1 - 0.287 ln gamma of IEC 61400-3, as in OpenFAST; m0 is Hs^2/16 within
        0.5 % for gamma up to 5, 2 % at 7) or "exact" (m0 = Hs^2/16 exactly); for jonswap
    heading : direction of propagation [rad]
    spreading : exponent s of cos^2s((theta - heading)/2) [-]; None is a long-crested sea
    level : one-sided level of white noise [m2/Hz], over `band`
    band : lowest and highest frequency of white noise [Hz]
    systems : (2, 3) rows (Hs [m], Tp [s], lambda [-]) of swell and wind sea; for ochi_hubble, None takes the most
        probable values for significant_height
    omega, spectrum : (n) [rad/s], (n) [m2/(rad/s)], interpolated linearly, zero outside; for table
    low_cutoff, high_cutoff : the spectrum is zero below and above [rad/s] (WvLowCOff, WvHiCOff of OpenFAST)

    Raises
    ------
    ValueError : a parameter is missing, of no use for the kind, or out of range.
    """

    kind: str = "jonswap"
    significant_height: float | None = None
    peak_period: float | None = None
    gamma: float | None = None
    normalisation: str = "iec"
    heading: float = 0.0
    spreading: float | None = None
    level: float | None = None
    band: tuple[float, float] | None = None
    systems: np.ndarray | None = None
    omega: np.ndarray | None = None
    spectrum: np.ndarray | None = None
    low_cutoff: float = 0.0
    high_cutoff: float = np.inf

    def __post_init__(self):
        freeze(self, systems=(2, 3), omega=("n",), spectrum=("n",))
        if self.kind not in KINDS:
            raise ValueError(f"unknown kind of sea {self.kind!r}; use one of {', '.join(KINDS)}")
        _check_parameters(self)
        _check_ranges(self)
        if self.kind == "table":
            _check_table(self.omega, self.spectrum)


_NEEDED = {
    "jonswap": ("significant_height", "peak_period"),
    "pierson_moskowitz": ("significant_height", "peak_period"),
    "torsethaugen": ("significant_height", "peak_period"),
    "table": ("omega", "spectrum"),
    "white_noise": ("band",),
}
_OPTIONAL = {
    "jonswap": ("gamma",),
    "white_noise": ("level", "significant_height"),
    "ochi_hubble": ("significant_height", "systems"),
}
_SPECIFIC = ("significant_height", "peak_period", "gamma", "level", "band", "systems", "omega", "spectrum")
_ONE_OF = {"white_noise": ("level", "significant_height"), "ochi_hubble": ("significant_height", "systems")}


def _check_parameters(sea: SeaState) -> None:
    """Raise ValueError for what is missing and for what the kind of sea would silently ignore."""
    needed, optional = _NEEDED.get(sea.kind, ()), _OPTIONAL.get(sea.kind, ())
    given = [name for name in _SPECIFIC if getattr(sea, name) is not None]
    missing = [name for name in needed if name not in given]
    if missing:
        raise ValueError(f"a {sea.kind} sea needs {' and '.join(missing)}")
    unused = [name for name in given if name not in needed + optional]
    if unused:
        raise ValueError(f"a {sea.kind} sea does not use {', '.join(unused)}; leave it out or choose another kind")
    choice = _ONE_OF.get(sea.kind, ())
    if choice and sum(name in given for name in choice) != 1:
        raise ValueError(f"a {sea.kind} sea needs either {choice[0]} or {choice[1]}, not both or neither")


def _check_ranges(sea: SeaState) -> None:
    """Raise ValueError for numbers that no sea can have."""
    for name in ("significant_height", "level"):
        value = getattr(sea, name)
        if value is not None and not (np.isfinite(value) and value >= 0):
            raise ValueError(f"{name} is {value}; it must be zero or more (a sea without waves is kind='still')")
    if sea.peak_period is not None and not (np.isfinite(sea.peak_period) and sea.peak_period > 0):
        raise ValueError(f"peak_period is {sea.peak_period} s; it must be positive")
    if sea.normalisation not in ("iec", "exact"):
        raise ValueError(f"normalisation is {sea.normalisation!r}; use 'iec' or 'exact'")
    if sea.gamma is not None and not sea.gamma >= 1:
        raise ValueError(f"gamma is {sea.gamma}; it must be 1 (Pierson-Moskowitz) or more")
    if sea.gamma is not None and sea.gamma > 7 and sea.normalisation == "iec":
        raise ValueError(f"gamma is {sea.gamma}; above 7 the IEC factor no longer holds, use normalisation='exact'")
    if not np.isfinite(sea.heading):
        raise ValueError(f"heading is {sea.heading}; give the direction of propagation in rad")
    if sea.spreading is not None and not sea.spreading > 0:
        raise ValueError(f"spreading is {sea.spreading}; the exponent s must be positive, None is long-crested")
    if sea.band is not None and not 0 <= sea.band[0] < sea.band[1] < np.inf:
        raise ValueError(f"band is {sea.band}; give the lowest and the highest frequency in Hz")
    if not 0 <= sea.low_cutoff < sea.high_cutoff:
        raise ValueError(f"cut-offs are {sea.low_cutoff} and {sea.high_cutoff} rad/s; they must rise from zero or more")
    if sea.systems is not None and not ((sea.systems[:, 0] >= 0).all() and (sea.systems[:, 1:] > 0).all()):
        raise ValueError("systems holds rows (Hs, Tp, lambda); Hs must not be negative, Tp and lambda positive")


def _check_table(omega, spectrum) -> None:
    if omega.size < 2 or not (np.diff(omega) > 0).all() or omega[0] < 0:
        raise ValueError("the omega of a table must rise from zero or more and have at least two values")
    if not (np.isfinite(spectrum).all() and (spectrum >= 0).all()):
        raise ValueError("the spectrum of a table must be finite and not negative")


# --- spectra ---------------------------------------------------------------------------------------------------------


def default_gamma(significant_height: float, peak_period: float) -> float:
    """Return the JONSWAP peak factor recommended for a sea state.

    significant_height [m], peak_period [s]. Source: IEC 61400-3:2009 annex B (OpenFAST's WavePkShp DEFAULT): 5 for
    Tp/sqrt(Hs) up to 3.6, 1 from 5, exp(5.75 - 1.15 Tp/sqrt(Hs)) between.
    """
    if significant_height == 0:
        return 1.0
    steepness = peak_period / np.sqrt(significant_height)
    if steepness <= 3.6:
        return 5.0
    return 1.0 if steepness >= 5 else float(np.exp(5.75 - 1.15 * steepness))


def wave_spectrum(sea: SeaState, omega) -> np.ndarray:
    """Return the one-sided spectrum of the wave elevation [m2/(rad/s)], all headings together.

    Parameters
    ----------
    sea : SeaState
    omega : (...) frequencies [rad/s]

    Returns
    -------
    (...) spectrum, zero at and below zero frequency and outside the cut-offs.

    References
    ----------
    IEC 61400-3:2009 annex B (JONSWAP); Torsethaugen and Haver (2004), ISOPE 2004-JSC-193 (simplified double peak);
    Ochi and Hubble (1976), Coastal Engineering 1(15), ch. 18.
    """
    omega = np.asarray(omega, dtype=float)
    if sea.kind == "still":
        values = np.zeros(omega.shape)
    elif sea.kind == "white_noise":
        values = _white_noise(sea, omega)
    elif sea.kind == "table":
        values = np.interp(omega, sea.omega, sea.spectrum, left=0.0, right=0.0)
    else:
        systems = _SYSTEMS[sea.kind](sea)
        values = sum((_system_spectrum(omega, *system) for system in systems), np.zeros(omega.shape))
    kept = (omega >= sea.low_cutoff) & (omega <= sea.high_cutoff) & (omega >= 0)
    return np.where(kept, values, 0.0)


def _white_noise(sea: SeaState, omega):
    low, high = 2 * np.pi * np.asarray(sea.band)
    if sea.level is not None:
        level = sea.level / (2 * np.pi)
    else:
        level = sea.significant_height**2 / 16 / (high - low)
    # the band's own ends, converted from Hz, must not fall out by rounding
    slack = 1e-12 * high
    return np.where((omega >= low - slack) & (omega <= high + slack), level, 0.0)


def _system_spectrum(omega, height, period, n, m, gamma, factor):
    """Return the spectrum of one wave system: Hs^2/16 times the unit shape with its peak enhanced."""
    if height == 0:
        return np.zeros(omega.shape)
    peak = 2 * np.pi / period
    # below 0.05 of the peak frequency the shape is zero in double precision; the clip avoids 0 times infinity
    x = np.maximum(omega / peak, 0.05)
    values = height**2 / 16 / peak * factor * _unit_shape(x, n, m) * _enhancement(x, gamma)
    return np.where(omega > 0.05 * peak, values, 0.0)


def _unit_shape(x, n, m):
    """Return the generalised gamma shape with its peak at x = 1 and unit integral over (0, inf)."""
    c = (n - 1) / m
    log_scale = np.log(m) + c * np.log(n / m) - gammaln(c)
    return np.exp(log_scale - n * np.log(x) - n / m * x**-m)


def _enhancement(x, gamma):
    """Return the JONSWAP peak enhancement gamma^exp(-(x - 1)^2 / (2 width^2)), width 0.07 below the peak, else 0.09."""
    width = np.where(x <= 1, 0.07, 0.09)
    return gamma ** np.exp(-0.5 * ((x - 1) / width) ** 2)


def _exact_factor(n, m, gamma):
    """Return the factor that keeps the area of an enhanced unit shape at one."""
    if gamma == 1:
        return 1.0
    added = 0.0
    for start, stop in ((1 - 8 * 0.07, 1.0), (1.0, 1 + 8 * 0.09)):  # beyond 8 widths the enhancement is 1 + 1e-14
        x = start + (stop - start) * (_NODES + 1) / 2
        added += (stop - start) / 2 * np.sum(_WEIGHTS * _unit_shape(x, n, m) * (_enhancement(x, gamma) - 1))
    return 1 / (1 + added)


def _jonswap_systems(sea: SeaState):
    height, period = sea.significant_height, sea.peak_period
    gamma = default_gamma(height, period) if sea.gamma is None else sea.gamma
    factor = _exact_factor(5, 4, gamma) if sea.normalisation == "exact" else 1 - 0.287 * np.log(gamma)
    return [(height, period, 5, 4, gamma, factor)]


def _pierson_moskowitz_systems(sea: SeaState):
    return [(sea.significant_height, sea.peak_period, 5, 4, 1.0, 1.0)]


def _ochi_hubble_systems(sea: SeaState):
    systems = most_probable_systems(sea.significant_height) if sea.systems is None else sea.systems
    return [(height, period, 4 * shape + 1, 4, 1.0, 1.0) for height, period, shape in systems]


def most_probable_systems(significant_height: float) -> np.ndarray:
    """Return the most probable Ochi-Hubble parameters of a sea: (2, 3) rows (Hs [m], Tp [s], lambda [-]).

    significant_height [m]. Swell first. Source: Ochi and Hubble (1976), table 2b; their 0.54 for the wind sea's share
    of the height is the rounded sqrt(1 - 0.84^2), used here so that the two systems add up to the sea.
    """
    h = significant_height
    swell = (0.84 * h, 2 * np.pi / (0.70 * np.exp(-0.046 * h)), 3.0)
    wind = (np.sqrt(1 - 0.84**2) * h, 2 * np.pi / (1.15 * np.exp(-0.039 * h)), 1.54 * np.exp(-0.062 * h))
    return np.array([swell, wind])


def _torsethaugen_systems(sea: SeaState):
    """Return primary and secondary system; the primary is wind sea up to the fully developed period, swell above."""
    height, period = sea.significant_height, sea.peak_period
    if height == 0:
        return []
    developed = 6.6 * height ** (1 / 3)
    if period <= developed:
        lack = min((developed - period) / (developed - 2 * np.sqrt(height)), 1.0)
        share = 0.7 + 0.3 * np.exp(-((lack / 0.5) ** 2))
        gamma = 35 * (2 * np.pi / STANDARD_GRAVITY * share * height / period**2) ** (6 / 7)
        other_period = developed + 2
    else:
        excess = min((period - developed) / (25 - developed), 1.0)
        share = 0.6 + 0.4 * np.exp(-((excess / 0.3) ** 2))
        gamma = 35 * (2 * np.pi / STANDARD_GRAVITY * height / developed**2) ** (6 / 7) * (1 + 6 * excess)
        other_period = None
    gamma = max(gamma, 1.0)
    other = np.sqrt(1 - share**2) * height
    other_period = 6.6 * other ** (1 / 3) if other_period is None else other_period
    return [(share * height, period, 4, 4, gamma, _exact_factor(4, 4, gamma)), (other, other_period, 4, 4, 1.0, 1.0)]


_SYSTEMS = {
    "jonswap": _jonswap_systems,
    "pierson_moskowitz": _pierson_moskowitz_systems,
    "ochi_hubble": _ochi_hubble_systems,
    "torsethaugen": _torsethaugen_systems,
}


def moments(spectrum, omega, orders) -> np.ndarray:
    """Return spectral moments, the trapezoidal integrals of omega^order times the spectrum.

    spectrum (..., n) [unit^2/(rad/s)], omega (n) [rad/s], orders: one order or a sequence of k orders; returns (...)
    or (..., k) [unit^2 (rad/s)^order].
    """
    spectrum, omega, orders = np.asarray(spectrum, dtype=float), np.asarray(omega, dtype=float), np.asarray(orders)
    values = trapezoid(spectrum[..., None, :] * omega ** orders.reshape(-1, 1), omega, axis=-1)
    return values[..., 0] if orders.ndim == 0 else values


def significant_height(spectrum, omega) -> np.ndarray:
    """Return the significant wave height 4 sqrt(m0) [m] of spectra (..., n) [m2/(rad/s)] on omega (n) [rad/s]."""
    return 4 * np.sqrt(moments(spectrum, omega, 0))


# --- directions ------------------------------------------------------------------------------------------------------


def spreading_weights(sea: SeaState, headings) -> np.ndarray:
    """Return the share of a sea's energy that each heading stands for.

    Each heading stands for the arc up to halfway to its neighbours, over which cos^2s is integrated exactly; at the
    ends of a set that does not go round the arc is symmetric, and the shares are scaled to sum to one. A long-crested
    sea goes to its own heading, or is divided linearly between the two nearest.

    Parameters
    ----------
    sea : SeaState
    headings : (m) directions of propagation [rad], in any order; two that are equal modulo 2 pi share their arc

    Returns
    -------
    (m) weights that sum to one.

    Raises
    ------
    ValueError : the sea lies outside the set (in a gap of more than 90 degrees).
    """
    headings = np.atleast_1d(np.asarray(headings, dtype=float))
    offset = _wrap(headings - sea.heading)
    order = np.argsort(offset)
    ahead = np.empty(headings.size)  # distance to the next heading
    ahead[order] = np.diff(offset[order], append=offset[order[0]] + 2 * np.pi)
    behind = np.empty(headings.size)
    behind[order] = np.roll(ahead[order], 1)
    weights = _share_of_one_heading(offset) if sea.spreading is None else _share_of_arcs(offset, ahead, behind, sea)
    if not weights.sum() > 0:
        raise ValueError(
            f"no energy of the sea heading {np.degrees(sea.heading):.1f} deg falls on headings "
            f"{np.degrees(headings.min()):.1f} to {np.degrees(headings.max()):.1f} deg; add headings around it"
        )
    return weights / weights.sum()


def _wrap(angle):
    """Return angles in [-pi, pi)."""
    return (angle + np.pi) % (2 * np.pi) - np.pi


def _share_of_one_heading(offset):
    """Return linear shares between the nearest headings on either side of zero."""
    same = np.abs(offset) < 1e-9
    if same.any():
        return same.astype(float)
    below, above = offset[offset < 0], offset[offset > 0]
    if not (below.size and above.size) or above.min() - below.max() > np.pi / 2 + 1e-6:
        return np.zeros(offset.size)
    low, high = below.max(), above.min()
    at_low, at_high = np.abs(offset - low) < 1e-9, np.abs(offset - high) < 1e-9
    return at_low / at_low.sum() * high / (high - low) - at_high / at_high.sum() * low / (high - low)


def _share_of_arcs(offset, ahead, behind, sea: SeaState):
    """Return the integral of cos^2s(angle/2) over the arc of each heading, as a part of the full circle."""
    if offset.size == 1:
        return np.where(np.abs(offset) <= np.pi / 4, 1.0, 0.0)
    widest = np.pi / 2 + 1e-6  # a wider gap is taken for the end of the set
    open_ahead, open_behind = ahead > widest, behind > widest
    upper = np.where(open_ahead, np.where(open_behind, 0.0, behind), ahead) / 2
    lower = np.where(open_behind, np.where(open_ahead, 0.0, ahead), behind) / 2
    return _spread_below(offset + upper, sea.spreading) - _spread_below(offset - lower, sea.spreading)


def _spread_below(angle, s):
    """Return the integral of the normalised cos^2s(angle/2) from -pi to the angle, continued beyond +-pi."""
    turns = np.floor((angle + np.pi) / (2 * np.pi))
    half = (angle - 2 * np.pi * turns) / 2
    return turns + 0.5 + 0.5 * np.sign(half) * betainc(0.5, s + 0.5, np.sin(half) ** 2)


def directional_spectrum(seas: SeaState | Sequence[SeaState], omega, headings) -> np.ndarray:
    """Return the spectrum that several simultaneous, independent seas put on each heading.

    seas: one SeaState or several; omega (n) [rad/s]; headings (m) [rad]. Returns (m, n) [m2/(rad/s)]; the sum over
    the headings is the spectrum of the elevation. Raises ValueError where `spreading_weights` does.
    """
    seas = [seas] if isinstance(seas, SeaState) else seas
    headings, omega = np.atleast_1d(headings), np.atleast_1d(omega)
    total = np.zeros((headings.size, omega.size))
    for sea in seas:
        if sea.kind != "still":
            total += spreading_weights(sea, headings)[:, None] * wave_spectrum(sea, omega)
    return total
