"""Time histories from amplitude spectra: with the phases of a measured record, or of the waves that drove it."""

from __future__ import annotations

import numpy as np


def with_phases_of(record, step: float, spectrum, frequency, highest: float = 0.45) -> np.ndarray:
    """Return a time history (t) of zero mean with the amplitudes of a model and the phases of a record (t).

    spectrum (n) is the model's, one-sided per Hz, on frequency (n) [Hz]; harmonics above highest [Hz] are left out. A smooth
    spectrum has a correlation of at most sqrt(pi)/2 = 0.886 with a record of Gaussian noise, whose own amplitudes scatter.
    """
    record = np.asarray(record, dtype=float)
    count = len(record)
    hertz = np.fft.rfftfreq(count, step)
    found = np.fft.rfft(record)
    amplitude = np.sqrt(np.interp(hertz, frequency, spectrum, left=0.0, right=0.0) / (2 * count * step)) * count
    amplitude[(hertz == 0) | (hertz > highest)] = 0.0
    return np.fft.irfft(amplitude * np.exp(1j * np.angle(found)), count)


def driven_by(record, step: float, transfer, frequency) -> np.ndarray:
    """Return the response (t, c) of transfer functions (n, c) on frequency (n) [Hz] to a record (t), taken as periodic."""
    record = np.asarray(record, dtype=float)
    hertz = np.fft.rfftfreq(len(record), step)
    h = np.stack(
        [np.interp(hertz, frequency, c.real) + 1j * np.interp(hertz, frequency, c.imag) for c in transfer.T], axis=1
    )
    h[(hertz == 0) | (hertz > frequency[-1])] = 0.0
    return np.fft.irfft(np.fft.rfft(record)[:, None] * h, len(record), axis=0)


def correlation(a, b) -> np.ndarray:
    """Return the correlation coefficients (...) of time histories (t, ...) about their means; NaN for one at rest."""
    a, b = (np.asarray(x) - np.mean(x, axis=0) for x in (a, b))
    with np.errstate(divide="ignore", invalid="ignore"):
        return (a * b).sum(axis=0) / np.sqrt((a**2).sum(axis=0) * (b**2).sum(axis=0))
