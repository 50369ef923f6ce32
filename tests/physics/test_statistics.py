"""Statistics of Gaussian responses against closed forms and Rayleigh's distribution of maxima."""

import numpy as np
import pytest
from scipy.integrate import quad

from model.response.statistics import statistics


def narrow(peak=0.5, width=0.002, variance=4.0):
    """A Gaussian spectrum of known area about a peak frequency."""
    omega = np.linspace(peak - 10 * width, peak + 10 * width, 2001)
    return omega, variance * np.exp(-0.5 * ((omega - peak) / width) ** 2) / (width * np.sqrt(2 * np.pi))


def test_narrow_band():
    omega, spectrum = narrow()
    found = statistics(spectrum[:, None], omega, [1.5], 3600.0)
    assert found.std[0] == pytest.approx(2.0, rel=1e-9)
    assert found.mean[0] == 1.5
    assert found.peak_period[0] == pytest.approx(2 * np.pi / 0.5)
    # second moment is peak^2 + width^2: relative 1.6e-5
    assert found.zero_crossing_period[0] == pytest.approx(2 * np.pi / np.hypot(0.5, 0.002), rel=1e-6)


@pytest.mark.parametrize("cycles", [100, 1000, 10_000])
def test_expected_extreme_of_narrow_band_maxima(cycles):
    """Mean of the largest of N Rayleigh maxima, by integration; Davenport's asymptote is 1 % off at 100, less above."""
    omega, spectrum = narrow()
    period = 2 * np.pi / np.hypot(0.5, 0.002)
    found = statistics(spectrum[:, None], omega, [0.0], cycles * period)
    exact = 2.0 * quad(lambda x: 1 - (1 - np.exp(-(x**2) / 2)) ** cycles, 0, 20, limit=200)[0]
    assert found.extreme[0] == pytest.approx(exact, rel=0.01)


def test_published_peak_factor():
    """Davenport 1964: g = sqrt(2 ln N) + 0.577 / sqrt(2 ln N); N = 600 gives 3.577 + 0.161 = 3.738."""
    omega, spectrum = narrow()
    found = statistics(spectrum[:, None], omega, [0.0], 600 * 2 * np.pi / np.hypot(0.5, 0.002))
    assert found.extreme[0] / found.std[0] == pytest.approx(3.738, abs=1e-3)


def test_extremes_grow_with_duration():
    omega, spectrum = narrow()
    values = [statistics(spectrum[:, None], omega, [0.0], t).extreme[0] for t in (1.0, 600.0, 3600.0, 10800.0)]
    assert np.all(np.diff(values) > 0)


def test_many_channels_one_of_them_at_rest():
    """A channel that does not move has no extreme and no warning; others are not touched by it."""
    omega, spectrum = narrow()
    with np.errstate(all="raise"):
        found = statistics(np.stack([spectrum, 0 * spectrum, 9 * spectrum], axis=1), omega, [0.0, 3.0, 0.0])
    assert found.std[1] == 0.0
    assert found.extreme[1] == 0.0
    assert found.std[2] == pytest.approx(3 * found.std[0])
    assert found.extreme[2] == pytest.approx(3 * found.extreme[0])
    assert found.zero_crossing_period[2] == pytest.approx(found.zero_crossing_period[0])


def test_flat_band():
    """White between 1 and 2 rad/s: m0 = S, m2 = 7/3 S, so Tz = 2 pi / sqrt(7/3)."""
    omega = np.linspace(1.0, 2.0, 1001)
    found = statistics(np.full((1001, 1), 3.0), omega, [0.0])
    # trapezium of omega^2: step^2 / 12 * 2 = 2e-7
    assert found.std[0] == pytest.approx(np.sqrt(3.0))
    assert found.zero_crossing_period[0] == pytest.approx(2 * np.pi / np.sqrt(7 / 3), rel=1e-6)
