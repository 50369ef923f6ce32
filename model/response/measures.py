"""How far a model is from a reference: every error measure of a comparison, defined once (docs/validation.md has them in words)."""

from __future__ import annotations

import numpy as np
from scipy.stats import t as student

BANDS = ((0.006, 0.02), (0.02, 0.05), (0.05, 0.1), (0.1, 0.2))  # Hz
WHOLE_BAND = (0.006, 0.199)


def rao_error(model, reference, input_spectrum, frequency, band=WHOLE_BAND) -> np.ndarray:
    """Return the energy-weighted relative error (c) of RAO magnitudes (n, c) over a band [Hz].

    sqrt(sum (|H| - |H|2)^2 S / sum |H|2^2 S), S the input spectrum (n).
    """
    weight = np.sqrt(np.asarray(input_spectrum))[:, None]
    return amplitude_error(np.asarray(model) * weight, np.asarray(reference) * weight, frequency, band)


def amplitude_error(model, reference, frequency, band=WHOLE_BAND) -> np.ndarray:
    """Return the relative error (c) of amplitude spectra (n, c), roots of power spectra, over a band [Hz].

    sqrt(sum (a - a_ref)^2 / sum a_ref^2): with amplitudes |H| sqrt(S) the error of an RAO weighted by the response's energy.
    """
    inside = (frequency >= band[0]) & (frequency <= band[1])
    model, reference = np.nan_to_num(model[inside]), np.nan_to_num(reference[inside])
    total = np.maximum((reference**2).sum(axis=0), 1e-300)
    return np.sqrt(((model - reference) ** 2).sum(axis=0) / total)


def log_error(model, reference, coherence, frequency, band=WHOLE_BAND) -> np.ndarray:
    """Return the coherence-weighted logarithmic error (c) of magnitudes (n, c): sqrt(sum g (ln |H| / |H|ref)^2 / sum g).

    Unlike `rao_error` it counts the frequencies where little energy is. Those without a value do not count.
    """
    inside = (frequency >= band[0]) & (frequency <= band[1])
    a, b, weight = (np.asarray(x)[inside] for x in (model, reference, coherence))
    usable = np.isfinite(a) & np.isfinite(b) & (a > 0) & (b > 0)
    ratio = np.log(np.where(usable, a, 1.0) / np.where(usable, b, 1.0))
    weight = np.where(usable, weight, 0.0)
    return np.sqrt((weight * ratio**2).sum(axis=0) / np.maximum(weight.sum(axis=0), 1e-300))


def peak(values, frequency, band) -> tuple[np.ndarray, np.ndarray]:
    """Return frequency and height (c) of the largest value (n, c) inside a band [Hz], refined by a parabola."""
    inside = np.flatnonzero((frequency >= band[0]) & (frequency <= band[1]))
    columns = np.arange(values.shape[1])
    at = inside[np.argmax(values[inside], axis=0)].clip(1, len(frequency) - 2)
    a, b, c = (values[at + k, columns] for k in (-1, 0, 1))
    curve = a - 2 * b + c
    with np.errstate(divide="ignore", invalid="ignore"):
        shift = np.where(curve < 0, (a - c) / (2 * curve), 0.0).clip(-0.5, 0.5)
    return frequency[at] + shift * (frequency[1] - frequency[0]), b - (a - c) * shift / 4


def seed_interval(values, level: float = 0.95) -> np.ndarray:
    """Return the half width (...) of the confidence interval of the mean of records' values (s, ...), Student's t; NaN for one record."""
    values = np.asarray(values, dtype=float)
    count = len(values)
    if count < 2:
        return np.full(values.shape[1:], np.nan)
    return student.ppf((1 + level) / 2, count - 1) * values.std(axis=0, ddof=1) / np.sqrt(count)


def seen_by_record(frequency, duration: float) -> np.ndarray:
    """Return the share (n) of the variance at frequencies [Hz] that a record of a duration [s] has left when its mean is removed.

    1 - (sin(pi f T) / (pi f T))^2: the mean of T seconds takes with it what is slower than the record.
    """
    return 1 - np.sinc(np.asarray(frequency) * duration) ** 2


def relative_mean_error(model, reference, std) -> np.ndarray:
    """Return the error of means (c), relative to the reference's mean, or to its standard deviation where that is larger."""
    return (np.asarray(model) - reference) / np.maximum(np.maximum(np.abs(reference), std), 1e-300)
