"""Ultimate loads: the largest response of a state, and of all states over the years.

A Gaussian response crosses a level x upwards at the rate nu exp(-(x - mu)^2 / (2 sigma^2)), nu the rate of upcrossings
of its mean; rare crossings come independently, so the largest value in a time T lies below x with the probability
exp(-nu T exp(-...)) (Naess and Moan 2012, ch. 10).
"""

from __future__ import annotations

import numpy as np

HOURS_PER_YEAR = 365.25 * 24


def mean_plus_deviation(mean, std, factor: float = 1.0) -> np.ndarray:
    """Return |mean| + factor std: with factor 1 the ultimate load of the source thesis (eq. 8.21, y_max)."""
    return np.abs(mean) + factor * np.asarray(std, dtype=float)


def upcrossing_rate(m0, m2) -> np.ndarray:
    """Return the rate of upcrossings of the mean [1/s] from moments (...) of the spectrum in Hz; 0 without variance."""
    m0, m2 = np.asarray(m0, dtype=float), np.asarray(m2, dtype=float)
    return np.sqrt(np.where(m0 > 0, m2 / np.where(m0 > 0, m0, 1.0), 0.0))


def peak_factor(rate, duration: float) -> np.ndarray:
    """Return how many deviations the expected largest value lies above the mean (Davenport 1964); rate (...) [1/s],
    duration [s].

    u + 0.5772 / u with u = sqrt(2 ln(rate duration)); fewer than e upcrossings are taken for e.
    """
    u = np.sqrt(2 * np.log(np.maximum(np.asarray(rate, dtype=float) * duration, np.e)))
    return u + np.euler_gamma / u


def expected_largest(mean, std, rate, duration: float) -> np.ndarray:
    """Return the expected largest value (...) in a duration [s] of responses with mean, std and upcrossing rate
    (...).
    """
    return np.asarray(mean) + peak_factor(rate, duration) * np.asarray(std)


def short_term_fractile(mean, std, rate, duration: float, fractile: float) -> np.ndarray:
    """Return the value (...) that the largest of a duration [s] stays below with the probability `fractile`.

    Raises ValueError for a fractile outside 0 to 1.
    """
    if not 0 < fractile < 1:
        raise ValueError(f"the fractile is {fractile:g}; it is a probability between 0 and 1, as 0.9")
    cycles = np.asarray(rate, dtype=float) * duration
    return np.asarray(mean) + np.asarray(std) * np.sqrt(2 * np.log(np.maximum(cycles / -np.log(fractile), 1.0)))


def exceedance(level, mean, std, rate, duration: float) -> np.ndarray:
    """Return the probability (...) that the largest value of a duration [s] lies above a level (...)."""
    std = np.asarray(std, dtype=float)
    away = np.asarray(level, dtype=float) - mean
    z = np.where(std > 0, away / np.where(std > 0, std, 1.0), np.where(away > 0, np.inf, -np.inf))
    crossings = np.asarray(rate) * duration * np.exp(-0.5 * np.maximum(z, 0.0) ** 2)
    return np.where(z > 0, -np.expm1(-crossings), 1.0)


def long_term_extreme(mean, std, rate, probability, return_period: float, state_duration: float = 3600.0) -> np.ndarray:
    """Return the response that is exceeded once in a return period, over all states.

    Solves sum_i p_i P(largest of state i > x) = 1 / n by bisection, n the number of states in the return period; every
    state contributes, however mild.

    Parameters
    ----------
    mean, std, rate : (s, ...) of the response in each state; rate of upcrossings [1/s]
    probability : (s) of the states; what is missing to one is taken as calm
    return_period : [years]
    state_duration : [s]

    Returns
    -------
    (...) response; the smallest comes from the negative of the mean

    Raises
    ------
    ValueError : probabilities that are negative or exceed one, or are too small altogether for the return period.
    """
    mean, std, rate = (np.asarray(a, dtype=float) for a in np.broadcast_arrays(mean, std, rate))
    p = np.asarray(probability, dtype=float)
    target = state_duration / (return_period * HOURS_PER_YEAR * 3600)
    if (p < 0).any() or p.sum() > 1 + 1e-6:
        raise ValueError(
            f"the probabilities add up to {p.sum():g}, the smallest is {p.min():g}; they must lie in 0 to 1 together"
        )
    if p.sum() <= target:
        raise ValueError(f"states of the probability {p.sum():.3g} in all do not come once in {return_period:g} years")
    weight = p.reshape(-1, *[1] * (mean.ndim - 1))
    low, high = mean.min(axis=0), (mean + 40 * std).max(axis=0)
    for _ in range(80):
        middle = (low + high) / 2
        above = (weight * exceedance(middle, mean, std, rate, state_duration)).sum(axis=0) > target
        low, high = np.where(above, middle, low), np.where(above, high, middle)
    return (low + high) / 2


def contributions(level, mean, std, rate, probability, state_duration: float = 3600.0) -> np.ndarray:
    """Return the share (s, ...) that each state has in the exceedance of a level (...): what governs the extreme."""
    mean = np.asarray(mean, dtype=float)
    weight = np.asarray(probability, dtype=float).reshape(-1, *[1] * (mean.ndim - 1))
    parts = weight * exceedance(level, mean, std, rate, state_duration)
    return parts / np.maximum(parts.sum(axis=0), 1e-300)
