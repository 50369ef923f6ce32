"""Linear (Airy) waves: dispersion and kinematics of a regular wave of unit amplitude, in any depth."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


def wavenumber(omega, depth: float, gravity: float) -> np.ndarray:
    """Return the wavenumber k [1/m] of linear waves: omega^2 = g k tanh(k depth).

    omega (...) [rad/s]; depth [m], may be infinite; gravity [m/s2]. Zero at zero frequency. Newton's method from
    Eckart's approximation (within 5 %), to machine precision. Raises ValueError for a depth that is not positive.
    """
    if not depth > 0:
        raise ValueError(f"depth is {depth} m; it must be positive (numpy.inf for deep water)")
    omega = np.asarray(omega, dtype=float)
    if np.isinf(depth):
        return omega**2 / gravity
    a = omega**2 * depth / gravity
    safe = np.where(a > 0, a, 1.0)
    x = safe / np.sqrt(np.tanh(safe))
    for _ in range(4):  # the relative error falls from 5e-2 to 5e-4, 7e-8, 2e-15, rounding
        t = np.tanh(x)
        x = x - (x * t - safe) / (t + x * (1 - t**2))
    return np.where(a > 0, x, 0.0) / depth


class WaveKinematics(NamedTuple):
    """Complex amplitudes per metre of wave amplitude.

    velocity (..., n, 3) [1/s], acceleration (..., n, 3) [1/s2], pressure_head (..., n) [-]: dynamic pressure over
    density times gravity.
    """

    velocity: np.ndarray
    acceleration: np.ndarray
    pressure_head: np.ndarray


def wave_kinematics(omega, wavenumber, depth: float, position, heading=0.0) -> WaveKinematics:
    """Return velocity, acceleration and dynamic pressure of linear (Airy) waves of unit amplitude.

    The elevation is Re{e^{i(omega t - k (x cos b + y sin b))}}: a crest at the origin at time zero. Points above
    still water take the values at z = 0 (no stretching). At zero frequency velocity and acceleration are zero.

    Parameters
    ----------
    omega, wavenumber : (n) [rad/s], (n) [1/m], the latter from `wavenumber`
    depth : [m], may be infinite
    position : (..., 3) points [m]
    heading : direction of propagation b [rad], a scalar or an array that broadcasts with the leading axes of position

    Returns
    -------
    WaveKinematics with leading axes (..., n).

    Raises
    ------
    ValueError : a point lies below the seabed.
    """
    omega = np.atleast_1d(np.asarray(omega, dtype=float))
    heading = np.asarray(heading, dtype=float)
    along, vertical, pressure = _fields(omega, wavenumber, depth, position, heading)
    parts = along * np.cos(heading)[..., None], along * np.sin(heading)[..., None], vertical
    velocity = np.stack(np.broadcast_arrays(*parts), axis=-1)
    return WaveKinematics(velocity, 1j * omega[:, None] * velocity, pressure)


def wave_velocity(omega, wavenumber, depth: float, position, heading=0.0) -> tuple[np.ndarray, np.ndarray]:
    """Return the velocities (..., n) along the heading and upwards of `wave_kinematics`, which says what goes in."""
    return _fields(np.atleast_1d(np.asarray(omega, dtype=float)), wavenumber, depth, position, np.asarray(heading, dtype=float))[:2]


def _fields(omega, wavenumber, depth, position, heading) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return velocity along the heading, upwards, and pressure head (..., n)."""
    k, position = np.atleast_1d(np.asarray(wavenumber, dtype=float)), np.asarray(position, dtype=float)
    z = np.minimum(position[..., 2], 0.0)
    if (z < -depth * (1 + 1e-9)).any():
        raise ValueError(
            f"a point at z = {z.min():g} m lies below the seabed at {-depth:g} m; check depth and position"
        )
    along = (position[..., 0] * np.cos(heading) + position[..., 1] * np.sin(heading))[..., None] * k
    phase = np.empty(along.shape, dtype=complex)
    phase.real, phase.imag = np.cos(along), -np.sin(along)
    horizontal, vertical, head = _depth_profiles(k, np.maximum(z, -depth)[..., None], depth)
    return phase * (omega * horizontal), phase * (1j * omega * vertical), phase * head


def _depth_profiles(k, z, depth):
    """Return cosh k(z+h)/sinh kh, sinh k(z+h)/sinh kh and cosh k(z+h)/cosh kh, without overflow; 0, 0, 1 for k = 0."""
    decay = np.exp(k * z)
    if np.isinf(depth):
        still = k > 0
        return decay * still, decay * still, decay
    up, down = np.exp(-2 * k * (z + depth)), np.exp(-2 * k * depth)
    sink = np.where(k > 0, -np.expm1(-2 * k * depth), np.inf)
    both = decay * (1 + up)
    return both / sink, decay * (1 - up) / sink, both / (1 + down)
