"""Identification from time series: spectra, transfer functions and coherence of noise-driven records, with their confidence.

References: Ramachandran, Robertson, Jonkman, Masciola, "Investigation of response amplitude operators for floating
offshore wind turbines", ISOPE 2013; Bendat and Piersol, "Random data", 4th ed., chapters 6, 9 and 11.5.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import csd, get_window, welch
from scipy.stats import f as fisher
from scipy.stats import norm

SEGMENT = 1000.0  # s
FEWEST = 3.5  # segments that a record must be long
_OVERLAP = 1 / 36  # squared correlation of neighbouring Hann segments with half overlap: (1/6)^2


@dataclass(frozen=True, eq=False, kw_only=True)
class Estimate:
    """Averaged spectra of an input x and outputs y (c): frequency (n) [Hz]; input_spectrum (n), output_spectrum (n, c), one-sided per
    Hz; cross_spectrum (n, c) = E[conj(X) Y]; averages, the equivalent number of independent segments; segment [s]; std (c) of the
    outputs over all records and its scatter (c) from record to record, relative; std_each (s, c), mean_each (s, c) of the records.
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
    std_each: np.ndarray
    mean_each: np.ndarray

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

    @property
    def degrees_of_freedom(self) -> float:
        """Degrees of freedom of every spectral value, two for each independent segment."""
        return 2 * self.averages

    def energy_bounds(self, level: float = 0.95) -> tuple[np.ndarray, np.ndarray]:
        """Return lower and upper confidence bounds (n, c) of |H|2.

        The logarithm of S_yy / S_xx, two spectra of coherence gamma^2, has the variance 2 (1 - gamma^2) / averages.
        """
        spread = np.exp(norm.ppf((1 + level) / 2) * np.sqrt(self._log_variance()))
        return self.energy_rao / spread, self.energy_rao * spread

    def coherent_radius(self, level: float = 0.95) -> np.ndarray:
        """Return the radius (n, c) of the circle around H1 in the complex plane that holds the true value.

        r^2 = 2 / (n - 2) F(2, n - 2) (1 - gamma^2) S_yy / S_xx with n degrees of freedom (Bendat and Piersol, eq. 9.78 f.).
        """
        n = self.degrees_of_freedom
        scale = 2 / (n - 2) * fisher.ppf(level, 2, n - 2)
        return np.sqrt(scale * (1 - self.coherence).clip(0)) * self.energy_rao

    def expected_error(self, band) -> np.ndarray:
        """Return the `rao_error` (c) over a band [Hz] that a perfect model would have: the estimator's own scatter."""
        inside = (self.frequency >= band[0]) & (self.frequency <= band[1])
        energy = self.output_spectrum[inside]
        return np.sqrt((energy * self._log_variance()[inside]).sum(axis=0) / np.maximum(energy.sum(axis=0), 1e-300))

    def _log_variance(self) -> np.ndarray:
        return (1 - self.coherence).clip(0) / (2 * self.averages)


def choose_segment(shortest: float, narrowest: float | None = None, longest: float = SEGMENT) -> float:
    """Return the length of the segments [s] for records of which the shortest is so long [s].

    As long as the narrowest peak needs (four over its half-power bandwidth `narrowest` [Hz], so that the window widens it by
    a few per cent), but such that the shortest record holds 3.5 segments, and no longer than `longest`; one of the series
    1, 2, 5, 10, ... s. Raises ValueError when the record is too short for any.
    """
    limit = min(longest, shortest / FEWEST, np.inf if narrowest is None else 4 / narrowest)
    if limit < 10:
        raise ValueError(f"a record of {shortest:.0f} s is too short for spectra; it needs some thousand seconds")
    power = 10.0 ** np.floor(np.log10(limit))
    return float(max(m for m in (power, 2 * power, 5 * power) if m <= limit * (1 + 1e-9)))


def independent_segments(count) -> np.ndarray:
    """Return how many independent segments a number of half-overlapping Hann segments is worth (Welch 1967)."""
    count = np.asarray(count, dtype=float)
    return count / (1 + 2 * _OVERLAP * (count - 1) / np.maximum(count, 1))


def estimate(inputs, outputs, step: float, segment: float = SEGMENT) -> Estimate:
    """Return the averaged spectra of records: Welch, Hann window, half overlap, averaged over records.

    inputs: list of (k) arrays, outputs: list of (k, c) arrays; step [s]; segment [s]. The mean is removed
    from each segment. Raises ValueError when a record is shorter than a segment.
    """
    length = round(segment / step)
    if any(len(x) < length for x in inputs):
        raise ValueError(
            f"a record of {min(len(x) for x in inputs) * step:.0f} s is shorter than a segment of {segment:.0f} s"
        )
    options = {"fs": 1 / step, "window": "hann", "nperseg": length, "noverlap": length // 2}
    count = np.array([(len(x) - length) // (length - length // 2) + 1 for x in inputs], dtype=float)
    share = count / count.sum()
    sxx = sum(w * welch(x, **options)[1] for w, x in zip(share, inputs, strict=True))
    syy = sum(w * welch(y, axis=0, **options)[1] for w, y in zip(share, outputs, strict=True))
    sxy = sum(w * csd(x[:, None], y, axis=0, **options)[1] for w, x, y in zip(share, inputs, outputs, strict=True))
    each = np.array([y.std(axis=0) for y in outputs])
    means = np.array([y.mean(axis=0) for y in outputs])
    pooled = np.sqrt((each**2).mean(axis=0))
    with np.errstate(divide="ignore", invalid="ignore"):
        scatter = each.std(axis=0, ddof=1) / pooled if len(each) > 1 else np.full(each.shape[1], np.nan)
    return Estimate(
        frequency=np.fft.rfftfreq(length, step), input_spectrum=sxx, output_spectrum=syy, cross_spectrum=sxy,
        averages=float(independent_segments(count).sum()), segment=segment, std=pooled, scatter=scatter,
        mean=means.mean(axis=0), std_each=each, mean_each=means,
    )  # fmt: skip


def smooth_like_welch(spectrum, step_hz: float, segment: float, sample: float) -> np.ndarray:
    """Return spectra (n, ...), cross-spectra too, on a uniform grid of step_hz [Hz] from zero, as a Hann-windowed segment would show them.

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
    mirrored = np.concatenate([spectrum[reach:0:-1].conj(), spectrum, np.zeros((reach, *spectrum.shape[1:]))])
    out = np.zeros_like(spectrum)
    for k, weight in enumerate(power):
        out += weight * mirrored[k : k + len(spectrum)]
    return out


def _ratio(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return a / b where the input has energy (above 1e-4 of its largest value), NaN elsewhere."""
    energy = b > 1e-4 * b.max()
    out = np.full(a.shape, np.nan, dtype=a.dtype)
    out[energy] = a[energy] / b[energy, None]
    return out
