"""From the responses of many states to what a lifetime of them does: cross-spectral moments, stresses, damage,
extremes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from model.response.batch import BatchResponse
from model.response.endurance import EnduranceCurve
from model.response.fatigue import ORDERS, SECONDS_PER_YEAR, damage_rate, equivalent_range, range_distribution
from model.response.loads import LinearOutputs
from model.response.solve import trapezoid_weights


def load_transfers(
    outputs: LinearOutputs, response: BatchResponse, names: Sequence[str]
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield, for every cause, the loads' transfer functions (s, n, c) and the spectrum (s, n) that drives them.

    Causes that are not correlated: waves of each heading, the wind of the whole rotor, its two gradients.
    """
    at = [outputs.names.index(name) for name in names]
    iw = 1j * response.omega[:, None, None]
    rows = outputs.position[at].T + iw * outputs.velocity[at].T + iw**2 * outputs.acceleration[at].T
    feeds = outputs.wind[at].T

    def apply(motion, feed):
        return np.matmul(motion.transpose(1, 0, 2), rows).transpose(1, 0, 2) + feed

    for k in range(response.to_wave.shape[1]):
        yield apply(response.to_wave[:, k], 0.0), response.wave_spectrum[:, k]
    if response.to_wind is not None:
        yield apply(response.to_wind, feeds[0]), response.wind_spectrum
    if response.to_gradients is not None:
        for k in (0, 1):
            yield apply(response.to_gradients[:, k], feeds[1 + k]), response.gradient_spectrum


def load_moments(outputs: LinearOutputs, response: BatchResponse, names: Sequence[str]) -> np.ndarray:
    """Return the real cross-spectral moments m0, m1, m2, m4 in Hz (s, 4, c, c) of c loads in s states, phases kept."""
    kernel = _kernel(response.omega)
    c, s = len(names), len(response.wave_spectrum)
    cross = np.zeros((s, len(ORDERS), c, c))
    for transfer, spectrum in load_transfers(outputs, response, names):
        for i in range(c):
            for j in range(i, c):
                a, b = transfer[..., i], transfer[..., j]
                cross[:, :, i, j] += ((a.real * b.real + a.imag * b.imag) * spectrum) @ kernel
    upper = np.triu_indices(c, 1)
    cross[:, :, upper[1], upper[0]] = cross[:, :, upper[0], upper[1]]
    return cross


def channel_moments(outputs: LinearOutputs, response: BatchResponse, names: Sequence[str]) -> np.ndarray:
    """Return the moments m0, m1, m2, m4 in Hz (s, c, 4) of channels in s states, each by itself."""
    kernel = _kernel(response.omega)
    out = 0.0
    for transfer, spectrum in load_transfers(outputs, response, names):
        power = (transfer.real**2 + transfer.imag**2) * spectrum[..., None]
        out = out + np.moveaxis(power, 1, -1) @ kernel
    return out


def combined_spectra(outputs: LinearOutputs, response: BatchResponse, names: Sequence[str], row) -> np.ndarray:
    """Return one-sided spectra (s, n) of one linear combination `row` (c) of loads: |row H|^2 S summed over causes."""
    return sum(np.abs(h @ np.asarray(row)) ** 2 * spectrum for h, spectrum in load_transfers(outputs, response, names))


def _kernel(omega) -> np.ndarray:
    """Return trapezoidal weights times powers of the frequency in Hz (n, 4)."""
    return (trapezoid_weights(omega) * (omega / (2 * np.pi)) ** np.array(ORDERS)[:, None]).T


@dataclass(frozen=True, eq=False, kw_only=True)
class Damage:
    """Fatigue of p points over a life: years; by_state (s, p) damage in the life of each state's share of time, total
    (p); moments (s, p, 4) of the stress; equivalent (p) damage-equivalent range over the life at `cycles` cycles, slope
    `power`.
    """

    years: float
    by_state: np.ndarray
    total: np.ndarray
    moments: np.ndarray
    equivalent: np.ndarray
    power: float
    cycles: float

    @property
    def life(self) -> np.ndarray:
        """Years (p) until the damage is one; infinite where there is none."""
        with np.errstate(divide="ignore"):
            return self.years / self.total


def lifetime_damage(
    moments,
    probability,
    curve: EnduranceCurve,
    *,
    factor: float = 1.0,
    years: float = 25.0,
    method: str = "dirlik",
    upper=None,
    cycles: float = 1e7,
    power: float | None = None,
) -> Damage:
    """Return the fatigue of p points over a life of s states.

    Parameters
    ----------
    moments : (s, p, 4) of the stress, or of the tension for a T-N curve, in Hz
    probability : (s) share of time of each state
    curve : S-N or T-N curve
    factor : on stresses: concentration times thickness effect
    years : life
    method : of `range_distribution`
    upper : (s, p) or None, largest range integrated to
    cycles, power : of the damage-equivalent range; power by default the curve's first slope

    Returns
    -------
    Damage
    """
    ranges = range_distribution(moments, method)
    seconds = np.asarray(probability, dtype=float) * years * SECONDS_PER_YEAR
    by_state = seconds[:, None] * damage_rate(ranges, curve, factor, upper)
    power = curve.slope if power is None else power
    sums = (seconds[:, None] * equivalent_range(ranges, power) ** power).sum(axis=0)
    return Damage(
        years=years,
        by_state=by_state,
        total=by_state.sum(axis=0),
        moments=np.asarray(moments),
        equivalent=(sums / cycles) ** (1 / power),
        power=power,
        cycles=cycles,
    )
