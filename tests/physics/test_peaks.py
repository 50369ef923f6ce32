"""Peaks between grid points: a single oscillator has them in closed form."""

import numpy as np
import pytest

from model.response.peaks import resonance_peak


def test_the_peak_of_an_oscillator_between_the_points_of_a_grid():
    # |H| of x'' + 2 z w0 x' + w0^2 x = f has its peak 1 / (2 z sqrt(1 - z^2)) / w0^2 at w0 sqrt(1 - 2 z^2)
    ratio, natural = np.array([0.02, 0.05, 0.1]), np.array([0.2, 0.05, 1.0])
    omega = np.geomspace(0.01, 3.0, 150)  # 4 % apart, wider than the narrowest peak; the parabola is exact, what is left is rounding
    h = 1 / np.abs(natural[:, None] ** 2 - omega**2 + 2j * ratio[:, None] * natural[:, None] * omega)
    height, at = resonance_peak(omega, h, natural)
    assert height * natural**2 == pytest.approx(1 / (2 * ratio * np.sqrt(1 - ratio**2)), rel=1e-9)
    assert at == pytest.approx(natural * np.sqrt(1 - 2 * ratio**2), rel=1e-9)


def test_only_the_band_around_the_natural_frequency_counts():
    omega = np.geomspace(0.1, 10, 400)
    low, high = (1 / np.abs(w**2 - omega**2 + 0.2j * w * omega) for w in (0.5, 3.0))
    height, at = resonance_peak(omega, low + 0.5 * high, 3.0)
    assert 2.5 < at < 3.5
    assert height < 0.6 * low.max()


def test_without_a_maximum_inside_the_largest_value_of_the_band():
    omega = np.linspace(1, 2, 101)
    height, at = resonance_peak(omega, 1 / omega, 1.5, span=0.2)
    assert at == pytest.approx(1.26)  # the first point above 1.5 / 1.2
    assert height == pytest.approx(1 / at)
