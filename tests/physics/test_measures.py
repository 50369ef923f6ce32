"""Error measures on numbers whose answer is known, and intervals that hold what they promise."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import lfilter

from model.response.measures import (
    amplitude_error,
    log_error,
    rao_error,
    relative_mean_error,
    seed_interval,
    seen_by_record,
)

F = np.linspace(0.0, 0.25, 251)


@given(st.floats(0.3, 3.0), st.floats(0.1, 10.0))
def test_errors_of_a_scaled_response(factor, size):
    """A model that is everywhere `factor` times the reference: |factor - 1|, whatever the spectrum; logarithm likewise."""
    reference = (1 + F[:, None]) * size
    spectrum = 1 + np.sin(40 * F) ** 2
    assert rao_error(factor * reference, reference, spectrum, F)[0] == pytest.approx(abs(factor - 1))
    assert amplitude_error(factor * reference, reference, F)[0] == pytest.approx(abs(factor - 1))
    assert log_error(factor * reference, reference, np.ones_like(reference), F)[0] == pytest.approx(abs(np.log(factor)))


def test_logarithmic_error_leaves_out_what_has_no_coherence_or_no_value():
    reference = np.ones((251, 1))
    model = np.where(F[:, None] > 0.1, 5.0, 1.0)
    coherence = np.where(F[:, None] > 0.1, 0.0, 1.0)
    assert log_error(model, reference, coherence, F)[0] == 0.0
    assert log_error(np.full((251, 1), np.nan), reference, np.ones((251, 1)), F)[0] == 0.0


def test_interval_holds_the_mean_in_95_per_cent_of_the_trials():
    """Three values, 20 000 trials: 95 % give or take 0.15 %, so 0.8 % is five times that."""
    values = np.random.default_rng(1).normal(7.0, 2.0, (3, 20_000))
    inside = np.abs(values.mean(axis=0) - 7.0) < seed_interval(values)
    assert inside.mean() == pytest.approx(0.95, abs=0.008)
    assert np.all(np.isnan(seed_interval(values[:1])))


def test_variance_that_a_record_without_its_mean_keeps():
    """A slow first-order process (correlation time 100 s) cut into records of 300 s: theory against 1000 records.

    Spectrum of the process 2 T / (1 + (2 pi f T)^2) per Hz of half range; the variance of 1000 records scatters by 2.5 %.
    """
    decay, length = 100.0, 300
    a = np.exp(-1 / decay)
    x = lfilter([np.sqrt(1 - a**2)], [1, -a], np.random.default_rng(2).normal(size=1000 * length + 5000))[5000:]
    found = x.reshape(1000, length).var(axis=1).mean()
    f = np.arange(0.5, 200_000) * 2.5e-6
    spectrum = 4 * decay / (1 + (2 * np.pi * f * decay) ** 2)
    expected = (spectrum * seen_by_record(f, length)).sum() * 2.5e-6
    assert found == pytest.approx(expected, rel=0.08)
    assert expected < 0.7  # a third and more is lost: the test sees the effect


def test_mean_errors_are_relative_to_what_is_large():
    assert relative_mean_error([8.2, 0.01], np.array([8.0, 0.0]), np.array([2.0, 1.0])) == pytest.approx([0.025, 0.01])
