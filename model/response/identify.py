"""Identification from time series: spectra, transfer functions and coherence of noise-driven records, and error measures.

Reference: Ramachandran, Robertson, Jonkman, Masciola, "Investigation of response amplitude operators for floating
offshore wind turbines", ISOPE 2013; Bendat and Piersol, "Random data", 4th ed., chapters 6, 7 and 9.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import csd, get_window, welch

SEGMENT = 1000.0  # s
BANDS = ((0.006, 0.02), (0.02, 0.05), (0.05, 0.1), (0.1, 0.2))  # Hz
WHOLE_BAND = (0.006, 0.199)


@dataclass(frozen=True, eq=False, kw_only=True)
class Estimate:
    """Averaged spectra of an input x and outputs y (c): frequency (n) [Hz]; input_spectrum (n), output_spectrum (n, c), one-sided per
    Hz; cross_spectrum (n, c) = E[conj(X) Y]; averages, the equivalent number of independent segments; segment [s]; std (c) of the
    outputs over all records and its scatter (c) from record to record, relative.
    """

    frequency: np.ndarray
    input_spectrum: np.ndarray
    output_spectrum: np.ndarray
    cross_spectrum: np.ndarray
    averages: float
    segment: float
    std: np.ndarray
    scatter: np.ndarray
    mean: np.ndarray

    @property
    def coherence(self) -> np.ndarray:
        """Coherence gamma^2 (n, c)."""
        with np.errstate(divide="ignore", invalid="ignore"):
            out = np.abs(self.cross_spectrum) ** 2 / (self.input_spectrum[:, None] * self.output_spectrum)
        return np.nan_to_num(out)

    @property
    def coherent_rao(self) -> np.ndarray:
        """H1 = S_xy / S_xx (n, c) complex, the coherent part with its phase."""
        return _ratio(self.cross_spectrum, self.input_spectrum)

    @property
    def energy_rao(self) -> np.ndarray:
        """|H|2 = sqrt(S_yy / S_xx) (n, c), all of the response's energy."""
        return np.sqrt(np.abs(_ratio(self.output_spectrum, self.input_spectrum)))


def estimate(inputs, outputs, step: float, segment: float = SEGMENT) -> Estimate:
    """Return the averaged spectra of records: Welch, Hann window, half overlap, averaged over records.

    inputs: list of (k) arrays, outputs: list of (k, c) arrays; step [s]; segment [s]. The mean is removed
    from each segment. Raises ValueError when a record is shorter than a segment.
    """
    length = round(segment / step)
    if any(len(x) < length for x in inputs):
        raise ValueError(f"a record of {min(len(x) for x in inputs) * step:.0f} s is shorter than a segment of {segment:.0f} s")
    options = {"fs": 1 / step, "window": "hann", "nperseg": length, "noverlap": length // 2}
    count = np.array([(len(x) - length) // (length - length // 2) + 1 for x in inputs], dtype=float)
    share = count / count.sum()
    sxx = sum(w * welch(x, **options)[1] for w, x in zip(share, inputs, strict=True))
    syy = sum(w * welch(y, axis=0, **options)[1] for w, y in zip(share, outputs, strict=True))
    sxy = sum(w * csd(x[:, None], y, axis=0, **options)[1] for w, x, y in zip(share, inputs, outputs, strict=True))
    each = np.array([y.std(axis=0) for y in outputs])
    pooled = np.sqrt((each**2).mean(axis=0))
    with np.errstate(divide="ignore", invalid="ignore"):
        scatter = each.std(axis=0, ddof=1) / pooled if len(each) > 1 else np.full(each.shape[1], np.nan)
    return Estimate(
        frequency=np.fft.rfftfreq(length, step), input_spectrum=sxx, output_spectrum=syy, cross_spectrum=sxy,
        averages=float(count.sum() * 9 / 11), segment=segment, std=pooled, scatter=scatter,
        mean=np.mean([y.mean(axis=0) for y in outputs], axis=0),
    )  # fmt: skip


def smooth_like_welch(spectrum, step_hz: float, segment: float, sample: float) -> np.ndarray:
    """Return spectra (n, ...) on a uniform grid of step_hz [Hz] from zero, as a Hann-windowed segment would show them.

    The convolution with the window's power, sampled every `sample` seconds over `segment` seconds. Leakage
    around narrow peaks is then the same in model and estimate.
    """
    length = round(segment / sample)
    reach = int(np.ceil(8 / segment / step_hz))
    offsets = np.arange(-reach, reach + 1) * step_hz
    window = get_window("hann", length)
    power = np.abs(np.exp(-2j * np.pi * np.outer(offsets, np.arange(length) * sample)) @ window) ** 2
    power /= power.sum()
    spectrum = np.asarray(spectrum)
    mirrored = np.concatenate([spectrum[reach:0:-1], spectrum, np.zeros((reach, *spectrum.shape[1:]))])
    out = np.zeros_like(spectrum)
    for k, weight in enumerate(power):
        out += weight * mirrored[k : k + len(spectrum)]
    return out


def rao_error(model, reference, input_spectrum, frequency, band=WHOLE_BAND) -> np.ndarray:
    """Return the energy-weighted relative error (c) of RAO magnitudes (n, c) over a band [Hz].

    sqrt(sum (|H| - |H|2)^2 S / sum |H|2^2 S), S the input spectrum (n).
    """
    inside = (frequency >= band[0]) & (frequency <= band[1])
    weight = input_spectrum[inside, None]
    difference = ((model[inside] - reference[inside]) ** 2 * weight).sum(axis=0)
    return np.sqrt(difference / np.maximum((reference[inside] ** 2 * weight).sum(axis=0), 1e-300))


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


def _ratio(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return a / b where the input has energy (above 1e-4 of its largest value), NaN elsewhere."""
    energy = b > 1e-4 * b.max()
    out = np.full(a.shape, np.nan, dtype=a.dtype)
    out[energy] = a[energy] / b[energy, None]
    return out
