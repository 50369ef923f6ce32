"""Free decay: period, linear and quadratic damping of a record by a fit, and what the model has at the same amplitudes.

A motion with the damping b1 v + b2 |v| v has, while it decays slowly, the equivalent damping ratio
zeta(a) = zeta1 + zeta2 a at the amplitude a, with zeta2 = 4 b2 / (3 pi m): the harmonic equivalent of |v| v at amplitude a is
8 / (3 pi) a omega v. Its amplitude obeys a' = -omega (zeta1 a + zeta2 a^2), which has a closed solution.
Reference: Faltinsen, "Sea Loads on Ships and Offshore Structures", 1990, section 7.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from scipy.signal import savgol_filter

from model.conventions import PLATFORM_DOFS
from model.response.assemble import Equilibrium, Modes, System, natural_modes
from model.system.drag import element_motion, linear_drag, resisted_directions


@dataclass(frozen=True, eq=False, kw_only=True)
class Decay:
    """A free decay: period [s] (damped), linear damping ratio and quadratic (per unit of amplitude), offset, first amplitude and phase [rad];
    mean amplitude (k), period (k) [s] and damping ratio (k) of the cycles by logarithmic decrement, over as many as lose a
    seventh of the amplitude; the fitted history (t) on time (t)
    [s]; residual, the part of the record's variance that the fit leaves.
    """

    period: float
    linear: float
    quadratic: float
    offset: float
    start: float
    phase: float
    amplitude: np.ndarray
    cycle_period: np.ndarray
    cycle_damping: np.ndarray
    time: np.ndarray
    fitted: np.ndarray
    residual: float

    def damping(self, amplitude):
        """Return the equivalent damping ratio at an amplitude."""
        return self.linear + self.quadratic * np.asarray(amplitude)


@dataclass(frozen=True, eq=False, kw_only=True)
class ModelDecay:
    """The model's mode at amplitudes (k): damped period (k) [s] and damping ratio (k), drag equivalent at each amplitude."""

    amplitude: np.ndarray
    period: np.ndarray
    damping: np.ndarray


def free_decay(time, motion, period: float) -> Decay:
    """Return what a record of free decay shows; time (t) [s], motion (t), period [s] a first guess.

    The first half cycle is left out: other motions start with it. Raises ValueError when the record holds fewer than three extremes.
    """
    time, motion = np.asarray(time, dtype=float), np.asarray(motion, dtype=float)
    where, value = extremes(time, motion, period)
    if len(where) < 3:
        raise ValueError(
            f"a decay record needs three extremes or more; this one of {time[-1] - time[0]:.0f} s has {len(where)}"
        )
    keep = time >= where[0]
    time, motion = time[keep], motion[keep]
    half = np.abs(np.diff(value)) / 2
    centre = np.median(motion[-len(motion) // 3 :])
    fall = np.log(half[0] / np.maximum(half[-1], 1e-9 * half[0])) / (np.pi * max(len(half) - 1, 1))
    guess = [2 * np.pi / period, np.clip(fall, 1e-3, 0.3), 0.0, half[0], 0.0 if value[0] > centre else np.pi, centre]
    scale = [2 * np.pi / period, 0.01, 0.01 / half[0], half[0], 1.0, half[0]]

    def residual(x):
        return (_history(x, time) - motion) / half[0]

    x = least_squares(residual, guess, x_scale=scale).x
    left = np.var(_history(x, time) - motion) / np.var(motion)
    apart = int(np.clip(np.ceil(0.15 / (np.pi * max(x[1] + x[2] * half.mean(), 1e-4))), 1, max(len(half) - 2, 1)))
    first, last = half[:-apart], half[apart:]
    large = last > 0.03 * half[0]
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.log(first / last) / (apart * np.pi)
    periods = (where[1 + apart :] - where[: -1 - apart]) * 2 / (1 + apart)
    return Decay(
        period=2 * np.pi / x[0], linear=x[1], quadratic=x[2], offset=x[5], start=x[3], phase=x[4],
        amplitude=np.sqrt(first * last)[large], cycle_period=periods[large], cycle_damping=ratio[large],
        time=time, fitted=_history(x, time), residual=float(left),
    )  # fmt: skip


def _history(x, time) -> np.ndarray:
    w, z1, z2, start, phase, offset = x
    return offset + amplitude_history(time, w, z1, z2, start, phase)


def amplitude_history(time, w: float, z1: float, z2: float, start: float, phase: float) -> np.ndarray:
    """Return a decaying motion (t) of frequency w [rad/s] whose amplitude obeys a' = -w (z1 a + z2 a^2) from `start` on."""
    elapsed = time - time[0]
    gone = np.exp(-np.clip(z1 * w * elapsed, -50, 50))
    growth = (1 - gone) / z1 if abs(z1) > 1e-9 else w * elapsed
    amplitude = start * gone / np.maximum(1 + z2 * start * growth, 0.05)
    return amplitude * np.cos(w * elapsed + phase)


def extremes(time, motion, period: float) -> tuple[np.ndarray, np.ndarray]:
    """Return times (k) and values (k) of the extremes of a motion of about this period [s], one in each half cycle.

    The record is smoothed over a tenth of a period, then extremes less than a third of a period apart give way to the larger.
    """
    step = float(np.median(np.diff(time)))
    window = max(int(0.1 * period / step) // 2 * 2 + 1, 3)
    smooth = savgol_filter(motion, window, 2) if window > 3 else np.asarray(motion)
    turn = np.flatnonzero(np.diff(np.sign(np.diff(smooth))) != 0) + 1
    kept: list[int] = []
    centre = np.median(smooth[-len(smooth) // 3 :])
    for k in turn:
        up = smooth[k] > smooth[k - 1]
        if (kept and (smooth[kept[-1]] > smooth[kept[-1] - 1]) == up) or (
            kept and time[k] - time[kept[-1]] < period / 3
        ):
            if abs(smooth[k] - centre) > abs(smooth[kept[-1]] - centre):
                kept[-1] = k
        elif time[k] - time[0] > period / 8:
            kept.append(k)
    at = np.array(kept, dtype=int)
    a, b, c = smooth[at - 1], smooth[at], smooth[at + 1]
    curve = np.where(a - 2 * b + c == 0, 1.0, a - 2 * b + c)
    shift = np.where(a - 2 * b + c == 0, 0.0, (a - c) / (2 * curve)).clip(-0.5, 0.5)
    return time[at] + shift * step, b - (a - c) * shift / 4


def model_decay(system: System, mean: Equilibrium, modes: Modes, dof: str, amplitude) -> ModelDecay:
    """Return damped period and damping ratio of the mode that a degree of freedom leads, at amplitudes (k) of that motion.

    Drag is linearised for harmonic motion in the mode's shape, 8 / (3 pi) |v| for every element. Raises ValueError without that mode.
    """
    if dof not in modes.names:
        raise ValueError(f"the model has no mode led by {dof}; there are {', '.join(modes.names)}")
    place, row = modes.names.index(dof), system.dofs.index(dof)
    shape = modes.shape[:, place] / modes.shape[row, place]
    rows = [PLATFORM_DOFS.index(d) for d in system.dofs if d in PLATFORM_DOFS]
    body = np.zeros(6, dtype=complex)
    body[rows] = shape[system.platform]
    motion = element_motion(system.drag, resisted_directions(system.drag))
    speed = modes.frequency[place] * np.sqrt((np.abs(motion @ body) ** 2).sum(axis=1))
    own = modes.frequency[place] * np.abs(body)
    periods, ratios = [], []
    for a in np.atleast_1d(amplitude):
        each = 8 / (3 * np.pi) * a * speed
        damping, _ = linear_drag(system.drag, motion, each[:, None, None] * np.eye(2))
        damping = damping + system.quadratic_damping * (8 / (3 * np.pi) * a * own)[None, :]
        found = natural_modes(system, mean, damping)
        at = found.names.index(dof)
        ratios.append(found.damping_ratio[at])
        periods.append(2 * np.pi / found.frequency[at] / np.sqrt(max(1 - found.damping_ratio[at] ** 2, 1e-6)))
    return ModelDecay(
        amplitude=np.atleast_1d(amplitude).astype(float), period=np.array(periods), damping=np.array(ratios)
    )
