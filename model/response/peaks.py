"""Heights of resonance peaks between the frequencies of a grid."""

from __future__ import annotations

import numpy as np


def resonance_peak(omega, magnitude, centre, span: float = 0.25) -> tuple[np.ndarray, np.ndarray]:
    """Return height and frequency (...) of the highest peak of transfer functions near a natural frequency.

    omega (n) [rad/s]; magnitude (..., n) [unit/m]; centre (...) natural frequency [rad/s]; the peak is sought within the factor
    1 + span of it. Between grid points 1 / |H|^2 is a parabola in omega^2, as a single oscillator's is exactly; without an inner
    maximum in the band, the largest value at its edge. A peak is at most 1.4 times the highest point: of a grid that needs more, refine.
    """
    omega, magnitude = np.asarray(omega, dtype=float), np.maximum(np.asarray(magnitude, dtype=float), 1e-150)
    centre = np.asarray(centre, dtype=float)[..., None]
    inside = (omega > centre / (1 + span)) & (omega < centre * (1 + span))
    nearest = np.argmin(np.abs(np.log(omega / centre)), axis=-1)
    inside |= np.arange(len(omega)) == nearest[..., None]
    top = np.clip(np.argmax(np.where(inside, magnitude, 0.0), axis=-1), 1, len(omega) - 2)
    places = top[..., None] + [-1, 0, 1]
    x, h = omega[places] ** 2, np.take_along_axis(magnitude, places, axis=-1)
    y = (h[..., 1:2] / h) ** 2
    left, right = (y[..., 1] - y[..., 0]) / (x[..., 1] - x[..., 0]), (y[..., 2] - y[..., 1]) / (x[..., 2] - x[..., 1])
    bend = (right - left) / (x[..., 2] - x[..., 0])
    inner = (left <= 0) & (right >= 0) & (bend > 0)
    slope = left + bend * (x[..., 1] - x[..., 0])  # at the middle point
    move = np.where(inner, -slope / np.where(inner, 2 * bend, 1.0), 0.0)
    least = 1 + move * (slope + bend * move)
    return h[..., 1] / np.sqrt(np.maximum(least, 0.5)), np.sqrt(x[..., 1] + move)
