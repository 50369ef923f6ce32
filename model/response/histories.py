"""Time histories of Gaussian responses: synthesised with random phases, or driven by a given wave record."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from model.response.loads import ChannelResponse
from model.response.solve import Response


@dataclass(frozen=True, eq=False, kw_only=True)
class Histories:
    """Channels over time: time (t) [s]; elevation (t) [m] at the origin; wind (t) [m/s] of the whole rotor, about its mean;
    data (t, c) with names and units, mean and dynamic part.
    """

    time: np.ndarray
    elevation: np.ndarray
    wind: np.ndarray
    data: np.ndarray
    names: tuple[str, ...]
    units: tuple[str, ...]


def synthesise(
    channels: ChannelResponse, response: Response, duration: float, step: float, seed: int, names: Sequence[str] | None = None
) -> Histories:
    """Return one realisation of a state's channels, all of the same waves and wind; drag's incoherent part is not in it.

    duration [s], step [s]; seed of the random phases, uniform with the amplitudes of the spectra (as OpenFAST with WaveNDAmp
    False); names of channels, by default all. Raises ValueError for a duration shorter than ten steps.
    """
    count = round(duration / step)
    if count < 10:
        raise ValueError(f"{duration:g} s in steps of {step:g} s are {count} samples; ten or more are needed")
    rng = np.random.default_rng(seed)
    omega = 2 * np.pi * np.fft.rfftfreq(count, step)[1:]
    width = omega[0]
    drive = response.excitation
    index = [channels.index(n) for n in (names or channels.names)]
    total = np.zeros((len(omega), len(index)), dtype=complex)
    elevation, wind = np.zeros((2, len(omega)), dtype=complex)
    for k, spectrum in enumerate(drive.wave_spectrum):
        amplitude = _amplitudes(rng, omega, drive.omega, spectrum, width)
        elevation += amplitude
        total += amplitude[:, None] * _on_grid(omega, drive.omega, channels.to_wave[k][:, index])
    for transfer, spectrum, is_wind in (
        (channels.to_wind, drive.wind_spectrum, True), *((g, drive.gradient_spectrum, False) for g in channels.to_gradients)
    ):  # fmt: skip
        amplitude = _amplitudes(rng, omega, drive.omega, spectrum, width)
        wind += amplitude * is_wind
        total += amplitude[:, None] * _on_grid(omega, drive.omega, transfer[:, index])
    return _histories(channels, index, total, elevation, wind, count, step)


def along_record(channels: ChannelResponse, response: Response, elevation, step: float, names: Sequence[str] | None = None) -> Histories:
    """Return the channels' response to a given periodic record of wave elevation (t) [m] every step [s], at the first heading."""
    elevation = np.asarray(elevation, dtype=float)
    count = len(elevation)
    omega = 2 * np.pi * np.fft.rfftfreq(count, step)[1:]
    waves = np.fft.rfft(elevation)[1:] * 2 / count
    index = [channels.index(n) for n in (names or channels.names)]
    total = waves[:, None] * _on_grid(omega, response.excitation.omega, channels.to_wave[0][:, index])
    return _histories(channels, index, total, waves, np.zeros_like(waves), count, step)


def _histories(channels, index, total, elevation, wind, count, step) -> Histories:
    stacked = np.concatenate([elevation[:, None], wind[:, None], total], axis=1)
    spectrum = np.concatenate([np.zeros((1, stacked.shape[1])), stacked]) * count / 2
    series = np.fft.irfft(spectrum, count, axis=0)
    return Histories(
        time=np.arange(count) * step, elevation=series[:, 0], wind=series[:, 1], data=series[:, 2:] + channels.mean[index],
        names=tuple(channels.names[i] for i in index), units=tuple(channels.units[i] for i in index),
    )  # fmt: skip


def _amplitudes(rng, omega, grid, spectrum, width) -> np.ndarray:
    """Return complex amplitudes of random phase whose squares are twice the spectrum over a line."""
    density = np.interp(omega, grid, spectrum, left=0.0, right=0.0)
    return np.sqrt(2 * density * width) * np.exp(1j * rng.uniform(0, 2 * np.pi, len(omega)))


def _on_grid(omega, grid, transfer) -> np.ndarray:
    """Return transfer functions (n, c) at other frequencies, zero outside the grid."""
    return np.stack(
        [np.interp(omega, grid, t.real, left=0, right=0) + 1j * np.interp(omega, grid, t.imag, left=0, right=0) for t in transfer.T],
        axis=1,
    )
