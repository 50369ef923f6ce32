"""Ultimate loads: closed forms, simulation, and what cannot be."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from model.environment.sea import SeaState, wave_spectrum
from model.response.extremes import (
    contributions,
    exceedance,
    expected_largest,
    long_term_extreme,
    mean_plus_deviation,
    peak_factor,
    short_term_fractile,
    upcrossing_rate,
)
from model.response.fatigue import stress_moments, synthesise


def test_the_objective_of_the_thesis():
    assert mean_plus_deviation(-2.0, 0.5) == 2.5
    assert mean_plus_deviation([1.0, 2.0], 0.5, 3.0) == pytest.approx([2.5, 3.5])


def test_the_peak_factor_of_a_known_number_of_waves():
    # 360 waves: u = sqrt(2 ln 360) = 3.431, u + 0.5772/u = 3.599
    assert peak_factor(0.1, 3600.0) == pytest.approx(3.599, abs=1e-3)
    assert expected_largest(5.0, 2.0, 0.1, 3600.0) == pytest.approx(5 + 2 * 3.599, abs=2e-3)


def test_simulated_hours_have_the_expected_extremes():
    """400 Gaussian hours of a sea: mean largest value, its 90 % fractile and the rate of upcrossings."""
    omega = np.linspace(0.2, 3.0, 3000)
    spectrum = wave_spectrum(SeaState(significant_height=4.0, peak_period=9.0, gamma=1.0), omega)
    m0, _, m2, _ = stress_moments(spectrum, omega)
    rate, std = upcrossing_rate(m0, m2), np.sqrt(m0)
    x = synthesise(spectrum, omega, 3600.0, 0.25, np.random.default_rng(1), 400)
    counted = np.mean(np.sum((x[:, 1:] > 0) & (x[:, :-1] <= 0), axis=1)) / 3600
    assert counted == pytest.approx(rate, rel=0.01)  # 400 hours of 490 waves: 0.1 %, and the time step
    largest = x.max(axis=1)
    # the largest of 490 scatters by 0.4 sigma: 0.02 sigma over 400 hours, 4 times that; and 1 % for peaks between steps
    assert largest.mean() == pytest.approx(expected_largest(0.0, std, rate, 3600.0), abs=0.08 * std + 0.01 * 3.6 * std)
    fractile = short_term_fractile(0.0, std, rate, 3600.0, 0.9)
    # crossings in groups make the formula a little conservative; 400 hours know a probability of 0.1 to 0.015
    assert np.mean(largest > fractile) == pytest.approx(0.1, abs=0.05)


@given(st.floats(-5, 5), st.floats(0.1, 3), st.floats(0.02, 1), st.floats(1.1, 500))
@settings(max_examples=50, deadline=None)
def test_of_one_state_the_long_term_value_is_its_fractile(mean, std, rate, years):
    states = years * 8766
    alone = long_term_extreme([mean], [std], [rate], [1.0], years)
    # exceeded in one of n states: the fractile 1 - 1/n of the largest of a state
    assert alone == pytest.approx(short_term_fractile(mean, std, rate, 3600.0, 1 - 1 / states), rel=1e-6, abs=1e-6)


def test_rare_states_govern_when_they_are_worse():
    mean, std, rate, p = np.array([0.0, 0.0]), np.array([1.0, 5.0]), np.array([0.1, 0.1]), np.array([1 - 1e-4, 1e-4])
    x = long_term_extreme(mean, std, rate, p, 50.0)
    total = p @ exceedance(x, mean, std, rate, 3600.0)
    assert total == pytest.approx(1 / (50 * 8766), rel=1e-9)  # the equation itself
    share = contributions(x, mean, std, rate, p)
    assert share.sum() == pytest.approx(1.0)
    assert share[1] > 0.999
    assert x > long_term_extreme(mean[:1], std[:1], rate[:1], p[:1], 50.0)


def test_channels_are_treated_at_once_and_a_steady_one_keeps_its_mean():
    mean, std = np.array([[1.0, 3.0], [2.0, 3.0]]), np.array([[0.5, 0.0], [0.7, 0.0]])
    rate, p = np.full((2, 2), 0.1), np.array([0.5, 0.5])
    both = long_term_extreme(mean, std, rate, p, 50.0)
    assert both[0] == pytest.approx(long_term_extreme(mean[:, 0], std[:, 0], rate[:, 0], p, 50.0))
    assert both[1] == pytest.approx(3.0)
    assert upcrossing_rate(0.0, 0.0) == 0


@pytest.mark.parametrize(
    ("p", "words"),
    [([0.7, 0.7], "add up to 1.4"), ([-0.1, 0.5], "smallest is -0.1"), ([1e-9, 0.0], "do not come once")],
)
def test_probabilities_that_cannot_be_are_refused(p, words):
    with pytest.raises(ValueError, match=words):
        long_term_extreme([0.0, 0.0], [1.0, 1.0], [0.1, 0.1], p, 50.0)


def test_a_fractile_is_a_probability():
    with pytest.raises(ValueError, match="between 0 and 1"):
        short_term_fractile(0.0, 1.0, 0.1, 3600.0, 90)
