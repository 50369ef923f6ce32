"""Statistics of Gaussian responses from their spectra."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.environment.sea import moments


@dataclass(frozen=True, eq=False, kw_only=True)
class Statistics:
    """Per channel (c): mean, std, zero_crossing_period [s], peak_period [s], and the expected largest deviation from the mean
    in `duration` [s].
    """

    mean: np.ndarray
    std: np.ndarray
    zero_crossing_period: np.ndarray
    peak_period: np.ndarray
    extreme: np.ndarray
    duration: float


def statistics(spectra, omega, mean, duration: float = 3600.0) -> Statistics:
    """Return the statistics of channels from one-sided spectra (n, c) on omega (n) [rad/s].

    The expected largest value of a Gaussian process in `duration` [s] is sigma (u + 0.5772 / u) with u = sqrt(2 ln N), N the
    number of zero upcrossings (Davenport 1964).
    """
    m0, m2 = moments(np.asarray(spectra).T, omega, (0, 2)).T
    std = np.sqrt(m0)
    with np.errstate(divide="ignore", invalid="ignore"):
        period = 2 * np.pi * np.sqrt(m0 / m2)
        cycles = np.maximum(duration / period, np.e)
        u = np.sqrt(2 * np.log(cycles))
        extreme = np.where(std > 0, std * (u + np.euler_gamma / u), 0.0)
    peak = 2 * np.pi / np.asarray(omega)[np.argmax(spectra, axis=0)]
    return Statistics(
        mean=np.asarray(mean), std=std, zero_crossing_period=period, peak_period=peak, extreme=extreme, duration=duration
    )
