"""The Cummins view of radiation: retardation functions, added mass from damping and back, decay in the time domain.

Damping is taken linear between its frequencies, from zero at zero frequency, and falling as omega^-4 beyond the last,
as everywhere in the model (`radiation_at`); all integrals over it are exact. References: Cummins 1962, Schiffstechnik 9:101;
Ogilvie 1964, Fifth Symposium on Naval Hydrodynamics; Filon's quadrature for what is piecewise linear.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import sici

from model.conventions import PLATFORM_DOFS, freeze
from model.response.assemble import Equilibrium, Modes, System
from model.system.hydro import HydroCoefficients, infinite_added_mass, radiation_at

_SIGNIFICANT = 1e-3


@dataclass(frozen=True, eq=False, kw_only=True)
class RadiationConsistency:
    """How well added mass and damping belong together, by pair of motions (6, 6).

    infinite: infinite-frequency added mass that the added mass at the data's frequencies and the damping imply; spread, its
    standard deviation over the frequencies; zero: zero-frequency added mass that follows from `given_infinite` and
    the damping; misfit: root mean square of A(omega) minus what the damping implies, over that of A(omega) minus its mean, nan
    where there is neither. given_infinite and given_zero are those of the data (None when the data lack them).
    """

    infinite: np.ndarray
    spread: np.ndarray
    zero: np.ndarray
    misfit: np.ndarray
    given_infinite: np.ndarray | None
    given_zero: np.ndarray | None

    def __post_init__(self):
        freeze(
            self, infinite=(6, 6), spread=(6, 6), zero=(6, 6), misfit=(6, 6), given_infinite=(6, 6), given_zero=(6, 6),
        )  # fmt: skip


@dataclass(frozen=True, eq=False, kw_only=True)
class Decay:
    """A free decay: time (t) [s], motion (t, q) about the mean offset, in the degrees of freedom of the system."""

    dofs: tuple[str, ...]
    time: np.ndarray
    motion: np.ndarray

    def __post_init__(self):
        freeze(self, time=("t",), motion=("t", len(self.dofs)))


def retardation(hydro: HydroCoefficients, time) -> np.ndarray:
    """Return the retardation functions K (t, 6, 6) [N/m and so on] at times (t) [s], not negative.

    K(t) = 2/pi times the integral of B(omega) cos(omega t). Raises ValueError for a negative time.
    """
    time = np.asarray(time, dtype=float)
    if np.any(time < 0):
        raise ValueError(f"retardation functions are causal: time {time.min():g} s is negative, give zero or more")
    grid, values = _extended(hydro)
    out = _cosine_transform(grid, values, time)
    out += np.multiply.outer(grid[-1] * _tail_cosine(grid[-1] * time), values[-1])
    return 2 / np.pi * out


def retardation_transform(hydro: HydroCoefficients, omega) -> np.ndarray:
    """Return K (n, 6, 6) = B + i omega (A - A_inf), symmetric, at omega (n) [rad/s]: the transform of the retardation functions."""
    added, damping = radiation_at(hydro, omega)
    k = damping + 1j * np.asarray(omega)[:, None, None] * (added - infinite_added_mass(hydro))
    return (k + np.swapaxes(k, 1, 2)) / 2


def added_mass_of_damping(hydro: HydroCoefficients, omega) -> np.ndarray:
    """Return A(omega) minus its infinite-frequency value (k, 6, 6), as the radiation damping implies it, at omega (k) [rad/s].

    2/pi times the principal value of the integral of B(x) / (x2 - omega2): Ogilvie's relation without the detour through
    time. Raises ValueError for a frequency that is not above zero (`zero_added_mass_of_damping` is for zero).
    """
    omega = np.asarray(omega, dtype=float)
    if np.any(omega <= 0):
        raise ValueError(f"frequencies must be above zero, the lowest is {omega.min():g} rad/s")
    grid, values = _extended(hydro)
    slope = np.diff(values, axis=0) / np.diff(grid)[:, None, None]
    bend = np.concatenate([-slope[:1], slope[:-1] - slope[1:]])
    w = np.where(np.min(np.abs(grid - omega[:, None]), axis=1) < 1e-9 * omega, omega * (1 + 1e-8), omega)[:, None]
    minus, plus = w - grid[:-1], w + grid[:-1]
    weight = (minus * np.log(np.abs(minus)) + plus * np.log(plus)) / (2 * w)
    out = np.tensordot(weight, bend, axes=1)
    end, last = grid[-1], values[-1]
    w = w[:, 0]
    ratio, log_sum = np.log(np.abs(end - w) / (end + w)) / (2 * w), np.log(np.abs(end**2 - w**2)) / 2
    start = last - slope[-1] * end
    out += np.multiply.outer(ratio, start) + np.multiply.outer(log_sum, slope[-1])
    return 2 / np.pi * (out + np.multiply.outer(_tail_ogilvie(w / end) / end, last))


def zero_added_mass_of_damping(hydro: HydroCoefficients) -> np.ndarray:
    """Return A(0) minus its infinite-frequency value (6, 6): 2/pi times the integral of B(x) / x2.

    Below the data damping is taken as quadratic here. In shallow water heave's is linear, and its added mass has no limit.
    """
    grid, values = hydro.omega, hydro.radiation_damping
    slope = np.diff(values, axis=0) / np.diff(grid)[:, None, None]
    start = values[:-1] - slope * grid[:-1, None, None]
    between = np.tensordot(1 / grid[:-1] - 1 / grid[1:], start, axes=1) + np.tensordot(
        np.log(grid[1:] / grid[:-1]), slope, axes=1
    )
    return 2 / np.pi * (values[0] / grid[0] + between + values[-1] / (5 * grid[-1]))


def radiation_of_retardation(time, kernel, omega) -> tuple[np.ndarray, np.ndarray]:
    """Return A(omega) minus its infinite-frequency value, and B(omega), (k, 6, 6) each, of retardation functions.

    time (t) [s] ascending from zero; kernel (t, ...), linear between the times and zero after the last; omega (k) [rad/s]
    above zero. Reference: Ogilvie 1964, A = A_infinite - 1/omega integral K sin, B = integral K cos.
    """
    time, kernel, omega = np.asarray(time, dtype=float), np.asarray(kernel, dtype=float), np.asarray(omega, dtype=float)
    if np.any(omega <= 0):
        raise ValueError(f"frequencies must be above zero, the lowest is {omega.min():g} rad/s")
    scale = (slice(None),) + (None,) * (kernel.ndim - 1)
    return -_sine_transform(time, kernel, omega) / omega[scale], _cosine_transform(time, kernel, omega)


def radiation_consistency(hydro: HydroCoefficients) -> RadiationConsistency:
    """Return how well a set of coefficients agrees with itself: causality binds added mass and damping."""
    implied = added_mass_of_damping(hydro, hydro.omega)
    estimate = hydro.added_mass - implied
    weight = np.gradient(hydro.omega) / np.gradient(hydro.omega).sum()
    infinite = np.tensordot(weight, estimate, axes=1)
    given = hydro.added_mass_infinite
    reference = infinite if given is None else given
    spread = np.sqrt(np.tensordot(weight, (estimate - infinite) ** 2, axes=1))
    gap = np.sqrt(np.tensordot(weight, (estimate - reference) ** 2, axes=1))
    change = np.sqrt(
        np.tensordot(weight, (hydro.added_mass - np.tensordot(weight, hydro.added_mass, axes=1)) ** 2, axes=1)
    )
    own = np.abs(np.diag(infinite))
    own = np.maximum(own, 1e-9 * np.repeat([own[:3].max(), own[3:].max()], 3))  # yaw of a body of revolution is rounding
    size = np.sqrt(np.outer(own, own))
    matters = change > _SIGNIFICANT * size
    misfit = np.where(matters, gap / np.where(matters, change, 1.0), np.nan)
    return RadiationConsistency(
        infinite=infinite, spread=spread, zero=reference + zero_added_mass_of_damping(hydro), misfit=misfit,
        given_infinite=given, given_zero=hydro.added_mass_zero,
    )  # fmt: skip


def consistency_rows(hydro: HydroCoefficients) -> tuple[tuple[str, str], ...]:
    """Return what the Cummins view says of a set of coefficients, as labels and texts: one row for each pair that radiates."""
    found = radiation_consistency(hydro)
    rows = []
    for i, j in zip(*np.nonzero(np.isfinite(found.misfit) & (np.tri(6).T > 0)), strict=True):
        text = (
            f"A and B differ by {100 * found.misfit[i, j]:.1f} % of A's variation; infinite {found.infinite[i, j]:.4g}"
        )
        if found.given_infinite is not None:
            text += f" (data {found.given_infinite[i, j]:.4g})"
        text += f", zero {found.zero[i, j]:.4g}"
        if found.given_zero is not None:
            text += f" (data {found.given_zero[i, j]:.4g})"
        name = PLATFORM_DOFS[i] if i == j else f"{PLATFORM_DOFS[i]}-{PLATFORM_DOFS[j]}"
        rows.append((f"radiation, {name}", text))
    return tuple(rows)


def free_decay(
    system: System,
    mean: Equilibrium,
    start,
    *,
    duration: float,
    step: float,
    memory: float = 100.0,
    rate=None,
    drag_damping=None,
) -> Decay:
    """Return the motion of the linear model after release, by convolution of velocities with the retardation functions.

    start (q) is the offset from the mean position, rate (q) its velocity; duration and step [s]; memory [s], after which the
    retardation functions are cut; drag_damping (6, 6) is added when given. Integrated with Newmark's constant
    average acceleration, velocities before the release zero. Raises ValueError when the step is not below the duration.
    """
    if not 0 < step < duration:
        raise ValueError(f"step {step:g} s must be positive and below the duration {duration:g} s")
    lags = int(min(memory, duration) / step)
    kernel = _kernel(system, step * np.arange(lags + 1)) * step
    kernel[0] /= 2
    here = np.ix_(system.platform, system.platform)
    mass, damping = system.mass.copy(), system.damping.copy()
    rows = [PLATFORM_DOFS.index(d) for d in system.dofs if d in PLATFORM_DOFS]
    mass[here] += infinite_added_mass(system.hydro)[np.ix_(rows, rows)]
    if drag_damping is not None:
        damping[here] += np.asarray(drag_damping)[np.ix_(rows, rows)]
    past = np.ascontiguousarray(kernel[:0:-1].transpose(1, 0, 2)).reshape(len(system.dofs), -1)
    return _newmark(system.dofs, mass, damping + kernel[0], mean.stiffness, past, lags, start, rate, duration, step)


def decay_period(time, signal) -> float:
    """Return the mean period [s] of a decaying signal by its upward and downward crossings of zero; nan with fewer than four."""
    time, signal = np.asarray(time), np.asarray(signal)
    k = np.flatnonzero(np.signbit(signal[1:]) != np.signbit(signal[:-1]))
    if len(k) < 4:
        return np.nan
    crossing = time[k] + (time[k + 1] - time[k]) * signal[k] / (signal[k] - signal[k + 1])
    return float(2 * (crossing[-1] - crossing[1]) / (len(crossing) - 2))


def decay_rows(system: System, mean: Equilibrium, modes: Modes, *, cycles: float = 6.0) -> tuple[tuple[str, str], ...]:
    """Return the periods of free decays in the time domain beside those of the modes, as labels and texts.

    Each decay starts in its mode's shape; modes damped by a third of critical or more are left out.
    """
    rows = []
    for k, name in enumerate(modes.names):
        if modes.damping_ratio[k] > 1 / 3 or name not in system.dofs:
            continue
        damped = modes.frequency[k] * np.sqrt(1 - modes.damping_ratio[k] ** 2)
        period = 2 * np.pi / damped
        found = mode_decay_period(system, mean, modes, k, cycles=cycles)
        rows.append(
            (
                f"decay, {name}",
                f"period {found:.3f} s in the time domain, {period:.3f} s by the modes ({100 * (found / period - 1):+.2f} %)",
            )
        )
    return tuple(rows)


def mode_decay_period(system: System, mean: Equilibrium, modes: Modes, k: int, *, cycles: float = 6.0) -> float:
    """Return the period [s] of a decay in the time domain that starts in the shape and with the velocity of mode k."""
    ratio, omega = modes.damping_ratio[k], modes.frequency[k]
    damped = omega * np.sqrt(1 - ratio**2)
    period, shape = 2 * np.pi / damped, modes.shape[:, k]
    lead = system.dofs.index(modes.names[k])
    start, rate = shape.real, (shape * (-ratio * omega + 1j * damped)).real
    run = free_decay(system, mean, start, rate=rate, duration=cycles * period, step=period / 200)
    return decay_period(run.time, run.motion[:, lead])


def _newmark(dofs, mass, damping, stiffness, past, lags, start, rate, duration, step) -> Decay:
    """Integrate the motion; past (q, lags q) are the retardation functions times the step, oldest first."""
    q, count = len(dofs), int(np.ceil(duration / step))
    motion, speed = np.zeros((count + 1, q)), np.zeros((count + 1 + lags, q))
    motion[0] = start
    speed[lags] = 0.0 if rate is None else rate
    acceleration = -np.linalg.solve(mass, damping @ speed[lags] + stiffness @ motion[0])
    inverse = np.linalg.inv(mass + step / 2 * damping + step**2 / 4 * stiffness)
    for n in range(count):
        v = speed[lags + n]
        reach = v + step / 2 * acceleration
        ahead = motion[n] + step * v + step**2 / 4 * acceleration
        memory = past @ speed[n + 1 : n + 1 + lags].ravel()
        acceleration = -inverse @ (memory + damping @ reach + stiffness @ ahead)
        speed[lags + n + 1] = reach + step / 2 * acceleration
        motion[n + 1] = ahead + step**2 / 4 * acceleration
    return Decay(dofs=dofs, time=step * np.arange(count + 1), motion=motion)


def _kernel(system: System, time: np.ndarray) -> np.ndarray:
    """Return the retardation functions (t, q, q) in the degrees of freedom of a system."""
    rows = [PLATFORM_DOFS.index(d) for d in system.dofs if d in PLATFORM_DOFS]
    here = np.asarray(system.platform)
    out = np.zeros((len(time), len(system.dofs), len(system.dofs)))
    out[:, here[:, None], here] = retardation(system.hydro, time)[:, rows][:, :, rows]
    return out


def _extended(hydro: HydroCoefficients) -> tuple[np.ndarray, np.ndarray]:
    """Return frequencies and damping with the zero at zero frequency in front."""
    return np.concatenate([[0.0], hydro.omega]), np.concatenate([np.zeros((1, 6, 6)), hydro.radiation_damping])


def _cosine_transform(x: np.ndarray, values: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the integral of values(x) cos(x y) over x (n), values linear between them, at every y (k); exact."""
    slope, middle, half, first = _pieces(x, values, y)
    bend = -2 * np.sin(middle * y[:, None]) * half * np.sinc(half * y[:, None] / np.pi)
    edges = _times(x[-1] * np.sinc(x[-1] * y / np.pi), values[-1]) - _times(first, values[0])
    safe = np.where(y > 0, y, 1.0)
    out = edges + np.tensordot(bend / safe[:, None], slope, axes=1)
    still = np.trapezoid(values, x, axis=0)
    return np.where((y > 0)[(slice(None),) + (None,) * (values.ndim - 1)], out, still)


def _sine_transform(x: np.ndarray, values: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the integral of values(x) sin(x y) over x (n), values linear between them, at every y (k) above zero; exact."""
    slope, middle, half, _ = _pieces(x, values, y)
    bend = 2 * np.cos(middle * y[:, None]) * half * np.sinc(half * y[:, None] / np.pi)
    edges = _times(np.cos(x[0] * y) / y, values[0]) - _times(np.cos(x[-1] * y) / y, values[-1])
    return edges + np.tensordot(bend / y[:, None], slope, axes=1)


def _pieces(x, values, y):
    """Return slopes, midpoints and half lengths of the pieces, and the transform of a unit edge at the first point."""
    step = np.diff(x)
    slope = np.diff(values, axis=0) / step[(slice(None),) + (None,) * (values.ndim - 1)]
    return slope, (x[1:] + x[:-1]) / 2, step / 2, x[0] * np.sinc(x[0] * y / np.pi)


def _times(weights: np.ndarray, values: np.ndarray) -> np.ndarray:
    return np.multiply.outer(weights, values)


def _tail_cosine(z: np.ndarray) -> np.ndarray:
    """Return the integral of cos(z x) / x^4 over x from 1 to infinity, for z (t) not negative.

    Three integrations by parts lead to the sine integral; beyond z = 200, where they cancel, the asymptotic series.
    """
    near = np.minimum(z, 200.0)
    sine, cosine = np.sin(near), np.cos(near)
    closed = cosine / 3 - near * sine / 6 - near**2 * cosine / 6 + near**3 / 6 * (np.pi / 2 - sici(near)[0])
    far = np.maximum(z, 200.0)
    series = -np.sin(far) * (1 / far - 20 / far**3) + np.cos(far) * (4 / far**2 - 120 / far**4)
    return np.where(z < 200, closed, series)


def _tail_ogilvie(r: np.ndarray) -> np.ndarray:
    """Return the principal value of the integral of x^-4 / (x^2 - r^2) over x from 1 to infinity."""
    small = np.minimum(r, 0.2)
    series = sum(small ** (2 * k) / (2 * k + 5) for k in range(8))
    big = np.maximum(r, 0.2)
    closed = np.log(np.abs(1 + big) / np.abs(1 - big)) / (2 * big**5) - 1 / big**4 - 1 / (3 * big**2)
    return np.where(r < 0.2, series, closed)
