"""The wind: turbulence spectra at a point, averaged over the rotor, and of its gradients over the rotor.

Spectra of the longitudinal component are one-sided in (m/s)^2/(rad/s); the standards give them in Hz, and
S(omega) = S(f) / (2 pi). Two points of the rotor a distance r apart have the cross-spectrum S(f) exp(-kappa(f) r), with
kappa = a sqrt((f/U)^2 + (0.12/Lc)^2) (IEC 61400-1 ed. 3, annex B.2). Any average over the disk is then an integral over
the distance r alone: the density of the distance between two points of the disk, times the exponential.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.special import beta

SPECTRA = ("kaimal", "von_karman", "api", "none")
REFERENCE_INTENSITY = {"A+": 0.18, "A": 0.16, "B": 0.14, "C": 0.12}  # IEC 61400-1 table 1; A+ from ed. 4
REFERENCE_SPEED = {"I": 50.0, "II": 42.5, "III": 37.5}  # m/s, IEC 61400-1 table 1
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(64)


@dataclass(frozen=True, eq=False, kw_only=True)
class WindState:
    """One wind: the mean speed and the turbulence around it.

    Parameters
    ----------
    mean_speed : mean at hub height [m/s], of ten minutes (of one hour for api)
    hub_height : above still water [m]
    rotor_diameter : [m]
    spectrum : one of SPECTRA; "none" is a steady wind
    turbulence_intensity : standard deviation over mean speed, a fraction [-]; this or turbulence_class ("api": this or
        none, the spectrum then has its own level)
    turbulence_class : "A+", "A", "B" or "C" of IEC 61400-1
    turbulence_model : "NTM" (normal) or "ETM" (extreme), with turbulence_class
    wind_class : "I", "II" or "III" of IEC 61400-1; the extreme turbulence depends on it
    averaging : "rotor" (what the whole rotor sees) or "point" (hub height), used by `inflow_spectrum`
    coherence_decay : a [-]
    coherence_scale : Lc [m]; None takes 8.1 Lambda1, infinity leaves the decay with frequency only

    Raises
    ------
    ValueError : a parameter is missing, contradicts another, or is out of range.
    """

    mean_speed: float
    hub_height: float
    rotor_diameter: float
    spectrum: str = "kaimal"
    turbulence_intensity: float | None = None
    turbulence_class: str | None = None
    turbulence_model: str = "NTM"
    wind_class: str = "I"
    averaging: str = "rotor"
    coherence_decay: float = 12.0
    coherence_scale: float | None = None

    def __post_init__(self):
        if self.spectrum not in SPECTRA:
            raise ValueError(f"unknown wind spectrum {self.spectrum!r}; use one of {', '.join(SPECTRA)}")
        if self.averaging not in ("rotor", "point"):
            raise ValueError(f"averaging is {self.averaging!r}; use 'rotor' or 'point'")
        for name in ("hub_height", "rotor_diameter", "coherence_decay", "coherence_scale"):
            value = getattr(self, name)
            if value is not None and not value > 0:
                raise ValueError(f"{name} is {value}; it must be positive")
        if not (np.isfinite(self.mean_speed) and self.mean_speed >= 0):
            raise ValueError(f"mean_speed is {self.mean_speed} m/s; it must be zero or more")
        if self.spectrum != "none":
            _check_turbulence(self)


def _check_turbulence(wind: WindState) -> None:
    if wind.mean_speed == 0:
        raise ValueError("turbulence needs a mean wind speed above zero; use spectrum='none' for a calm")
    given = (wind.turbulence_intensity is not None) + (wind.turbulence_class is not None)
    if wind.spectrum == "api":
        if wind.turbulence_class is not None:
            raise ValueError("the api spectrum has its own level: leave turbulence_class out")
    elif given != 1:
        raise ValueError("give either turbulence_intensity or turbulence_class (or spectrum='none')")
    if wind.turbulence_intensity is not None and not 0 <= wind.turbulence_intensity < 1:
        raise ValueError(f"turbulence_intensity is {wind.turbulence_intensity}; it is a fraction, as 0.14 for 14 %")
    if wind.turbulence_class is not None:
        turbulence_sigma(wind.turbulence_class, wind.turbulence_model, wind.mean_speed, wind.wind_class)


# --- what the standards prescribe ------------------------------------------------------------------------------------


def turbulence_sigma(turbulence_class: str, turbulence_model: str, mean_speed: float, wind_class: str = "I") -> float:
    """Return the representative standard deviation of the longitudinal turbulence sigma1 [m/s].

    turbulence_class "A+", "A", "B", "C"; turbulence_model "NTM" or "ETM"; mean_speed at hub height [m/s]; wind_class
    "I", "II", "III" for ETM (annual mean 0.2 Vref). Source: IEC 61400-1 ed. 3, eq. 11 and 19 (c = 2 m/s). Raises
    ValueError for an unknown name.
    """
    for name, value, known in (
        ("turbulence_class", turbulence_class, tuple(REFERENCE_INTENSITY)),
        ("turbulence_model", turbulence_model, ("NTM", "ETM")),
        ("wind_class", wind_class, tuple(REFERENCE_SPEED)),
    ):
        if value not in known:
            raise ValueError(f"unknown {name} {value!r}; use one of {', '.join(known)}")
    reference = REFERENCE_INTENSITY[turbulence_class]
    if turbulence_model == "NTM":
        return reference * (0.75 * mean_speed + 5.6)
    c, annual = 2.0, 0.2 * REFERENCE_SPEED[wind_class]
    return c * reference * (0.072 * (annual / c + 3) * (mean_speed / c - 4) + 10)


def turbulence_scale(hub_height: float) -> float:
    """Return the longitudinal turbulence scale Lambda1 [m]: 0.7 z up to 60 m, 42 m above (IEC 61400-1, eq. 5)."""
    return 0.7 * min(hub_height, 60.0)


def standard_deviation(wind: WindState) -> float:
    """Return the standard deviation of the longitudinal turbulence at a point [m/s]."""
    if wind.spectrum == "none":
        return 0.0
    if wind.turbulence_intensity is not None:
        return wind.turbulence_intensity * wind.mean_speed
    if wind.spectrum == "api":
        return float(np.sqrt(_api_variance(wind)))
    return turbulence_sigma(wind.turbulence_class, wind.turbulence_model, wind.mean_speed, wind.wind_class)


# --- at a point ------------------------------------------------------------------------------------------------------


def wind_spectrum(wind: WindState, omega) -> np.ndarray:
    """Return the spectrum of the longitudinal wind speed at a point at hub height.

    Parameters
    ----------
    wind : WindState
    omega : (...) frequencies [rad/s]

    Returns
    -------
    (...) one-sided spectrum [(m/s)^2/(rad/s)]. Its integral is the variance: exactly for kaimal, less 0.2 % for
    von_karman (the standard's rounded factor 71).

    References
    ----------
    Kaimal: IEC 61400-1 ed. 3, annex B.2, L = 8.1 Lambda1. Von Karman: IEC 61400-1 ed. 2, annex B, L = 3.5
    Lambda1, as TurbSim's IECVKM. API: ISO 19901-1:2005, A.7.4 (Froya).
    """
    frequency = np.abs(np.asarray(omega, dtype=float)) / (2 * np.pi)
    return _POINT_SPECTRA[wind.spectrum](wind, frequency) / (2 * np.pi)


def _kaimal(wind: WindState, frequency):
    time = 8.1 * turbulence_scale(wind.hub_height) / wind.mean_speed
    return 4 * standard_deviation(wind) ** 2 * time / (1 + 6 * frequency * time) ** (5 / 3)


def _von_karman(wind: WindState, frequency):
    time = 3.5 * turbulence_scale(wind.hub_height) / wind.mean_speed
    return 4 * standard_deviation(wind) ** 2 * time / (1 + 71 * (frequency * time) ** 2) ** (5 / 6)


_API_EXPONENT = 0.468


def _api_constants(wind: WindState):
    """Return level [m2/s] and time [s] of the API spectrum level / (1 + (time f)^n)^(5/(3 n)).

    They go with the hourly mean at 10 m, found from the hub's mean by the logarithmic profile of the same standard.
    """
    height = np.log(wind.hub_height / 10)

    def excess(speed):
        return speed * (1 + 0.0573 * np.sqrt(1 + 0.15 * speed) * height) - wind.mean_speed

    speed = brentq(excess, 0.0, 2 * wind.mean_speed + 1) if height != 0 else wind.mean_speed
    level = 320 * (speed / 10) ** 2 * (wind.hub_height / 10) ** 0.45
    return level, 172 * (wind.hub_height / 10) ** (2 / 3) * (speed / 10) ** -0.75


def _api_variance(wind: WindState):
    """Return the integral of the API spectrum over all frequencies [(m/s)^2]."""
    level, time = _api_constants(wind)
    return level / time / _API_EXPONENT * beta(1 / _API_EXPONENT, 2 / (3 * _API_EXPONENT))


def _api(wind: WindState, frequency):
    level, time = _api_constants(wind)
    if wind.turbulence_intensity is not None:
        level *= standard_deviation(wind) ** 2 / _api_variance(wind)
    return level / (1 + (time * frequency) ** _API_EXPONENT) ** (5 / (3 * _API_EXPONENT))


_POINT_SPECTRA = {
    "kaimal": _kaimal,
    "von_karman": _von_karman,
    "api": _api,
    "none": lambda wind, frequency: np.zeros(frequency.shape),
}


# --- over the rotor --------------------------------------------------------------------------------------------------


def coherence_rate(wind: WindState, omega) -> np.ndarray:
    """Return the rate kappa [1/m] at which coherence decays with distance; omega (...) [rad/s].

    Source: IEC 61400-1 ed. 3, eq. B.16: coherence exp(-a sqrt((f r/U)^2 + (0.12 r/Lc)^2)).
    """
    scale = 8.1 * turbulence_scale(wind.hub_height) if wind.coherence_scale is None else wind.coherence_scale
    frequency = np.asarray(omega, dtype=float) / (2 * np.pi)
    return wind.coherence_decay * np.hypot(frequency / wind.mean_speed, 0.12 / scale)


def coherence(wind: WindState, omega, distance) -> np.ndarray:
    """Return the coherence (cross-spectrum over spectrum) of two points of the rotor plane.

    omega (...) [rad/s] and distance (...) [m] broadcast together.
    """
    return np.exp(-coherence_rate(wind, omega) * np.asarray(distance, dtype=float))


def inflow_spectrum(wind: WindState, omega) -> np.ndarray:
    """Return the wind spectrum that drives the rotor, as `averaging` says: (...) [(m/s)^2/(rad/s)]."""
    return wind_spectrum(wind, omega) if wind.averaging == "point" else rotor_averaged_spectrum(wind, omega)


def rotor_averaged_spectrum(wind: WindState, omega, bands=None) -> np.ndarray:
    """Return the spectrum of the wind speed averaged over the rotor disk.

    The point spectrum times the coherence averaged over all pairs of points of the disk.

    Parameters
    ----------
    wind : WindState
    omega : (...) frequencies [rad/s]
    bands : None weighs the disk uniformly; (radius, weight) weighs the annulus up to each outer radius (b) [m], rising
        from the innermost, by weight (b) per unit area [-] (where the thrust is sensitive to the wind)

    Returns
    -------
    (...) [(m/s)^2/(rad/s)]
    """
    point = wind_spectrum(wind, omega)
    if wind.spectrum == "none":
        return point
    rate = coherence_rate(wind, omega)
    if bands is None:
        return point * mean_coherence(rate * wind.rotor_diameter)
    return point * _banded_coherence(rate, *bands)


def gradient_spectrum(wind: WindState, omega) -> np.ndarray:
    """Return the spectrum of the turbulent shear over the rotor: the slope of the plane that fits the wind speed.

    The plane is the least-squares fit of u over the disk. Its vertical and lateral slopes have this same spectrum, and
    by symmetry neither is correlated with the other nor with the rotor average.

    Parameters
    ----------
    wind : WindState
    omega : (...) frequencies [rad/s]

    Returns
    -------
    (...) [(m/s per m)^2/(rad/s)]
    """
    point = wind_spectrum(wind, omega)
    if wind.spectrum == "none":
        return point
    return point * gradient_coherence(coherence_rate(wind, omega) * wind.rotor_diameter) / wind.rotor_diameter**2


def mean_coherence(decay) -> np.ndarray:
    """Return exp(-decay x) averaged over pairs of points of a disk, x their distance over the diameter.

    decay (...) [-], kappa times the diameter. The density of x is (16/pi) x (acos x - x sqrt(1 - x^2)): the overlap of
    the disk with itself displaced by x.
    """
    return _over_distance(decay, lambda x, angle, root: 16 / np.pi * x * (angle - x * root))


def gradient_coherence(decay) -> np.ndarray:
    """Return the variance of the slope of a plane fitted over a disk of unit diameter, for a field of unit variance.

    decay (...) [-] as in `mean_coherence`. The slope is 4/(pi R^4) times the integral of u y over the disk, so the
    variance holds the mean of y1 y2 over pairs at a distance x, which by symmetry is half the mean of the product
    r1 . r2: the integral of |c|^2 - x^2/4 over the overlap, c from its centre, is (acos x - x sqrt(1 - x^2)(3 - 2 x^2))
    R^4.
    """
    values = _over_distance(decay, lambda x, angle, root: 256 / np.pi * x * (angle - x * root * (3 - 2 * x**2)))
    return np.maximum(values, 0.0)  # rounding where it vanishes, at no decay


def _over_distance(decay, density):
    """Return the integral over x from 0 to 1 of density(x, acos x, sqrt(1 - x^2)) exp(-decay x).

    With x = cos(angle) the integrand is smooth; the range is cut where the exponential has fallen below 1e-17, so that
    64 Gauss-Legendre nodes give full precision at any decay.
    """
    decay = np.asarray(decay, dtype=float)[..., None]
    start = np.arccos(np.minimum(1.0, 40 / np.maximum(decay, 40.0)))
    half = (np.pi / 2 - start) / 2
    angle = start + half * (1 + _NODES)
    x, root = np.cos(angle), np.sin(angle)
    return np.sum(_WEIGHTS * half * root * density(x, angle, root) * np.exp(-decay * x), axis=-1)


def _banded_coherence(rate, radius, weight):
    """Return the coherence averaged over pairs of points of a disk of weighted annuli; rate (...) [1/m].

    An annulus is the difference of two disks, so the average is a sum over pairs of concentric disks.
    """
    radius, weight = np.asarray(radius, dtype=float), np.asarray(weight, dtype=float)
    if radius.ndim != 1 or radius.shape != weight.shape or not (np.diff(radius, prepend=0.0) > 0).all():
        raise ValueError("bands needs outer radii that rise from above zero and as many weights")
    area = np.pi * radius**2
    amount = -np.diff(weight, append=0.0)  # of each full disk
    total = amount @ area
    if not total > 0:
        raise ValueError("the weights of the bands add up to nothing; they must have a positive mean over the disk")
    shares = amount * area / total
    out = sum(a**2 * mean_coherence(2 * rate * r) for a, r in zip(shares, radius, strict=True))
    for i, j in zip(*np.triu_indices(radius.size, 1), strict=True):
        out = out + 2 * shares[i] * shares[j] * _disk_to_disk(rate, radius[i], radius[j])
    return out


def _disk_to_disk(rate, small, large):
    """Return exp(-rate d) averaged over the distance d from a point of a disk to one of a larger, concentric disk."""
    rate = np.asarray(rate, dtype=float)[..., None]
    reach = 40 / np.maximum(rate, 1e-12)
    # up to large - small the displaced small disk lies inside the large one, and the density is 2 d / large^2
    near = np.minimum(large - small, reach) / 2
    d = near * (1 + _NODES)
    inner = np.sum(_WEIGHTS * near * 2 * d * np.exp(-rate * d), axis=-1) / large**2
    # beyond, the overlap is a lens; with d = large - small cos(angle) it is smooth at both ends
    stop = np.arccos(np.maximum(1 - reach / small, -1.0))
    angle = stop / 2 * (1 + _NODES)
    d = large - small * np.cos(angle)
    values = 2 * d * _lens(d, small, large) / (np.pi * small**2 * large**2) * np.exp(-rate * d)
    return inner + np.sum(_WEIGHTS * stop / 2 * small * np.sin(angle) * values, axis=-1)


def _lens(d, small, large):
    """Return the area common to two circles whose centres lie d apart [m2]."""
    at_small = np.arccos(np.clip((d**2 + small**2 - large**2) / (2 * d * small), -1, 1))
    at_large = np.arccos(np.clip((d**2 + large**2 - small**2) / (2 * d * large), -1, 1))
    kite = small * d * np.sin(at_small)
    return small**2 * at_small + large**2 * at_large - kite
