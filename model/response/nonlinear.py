"""The same model with the drag force itself instead of its linearisation, for wave records: between time and frequency.

Everything but drag is linear and is solved in the frequency domain; drag is evaluated in time on the record's samples
and brought back by Fourier transform, until both agree (alternating frequency-time harmonic balance; Cameron and
Griffin, J. Appl. Mech. 56, 1989). The record is periodic, as OpenFAST's waves are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.conventions import PLATFORM_DOFS
from model.response.assemble import Equilibrium, System
from model.response.loads import LinearOutputs
from model.response.solve import Excitation, dynamic_stiffness, prepare, solve
from model.system.drag import element_motion


@dataclass(frozen=True, eq=False, kw_only=True)
class RecordModel:
    """A model made ready for records of `samples` values every `step` [s]: omega (k); receptance (k, q, q) with the linearised
    drag damping (r, r) of the platform motions kept; force (k, q) per metre; water velocity (2 s, k) per metre along the
    directions that the drag elements resist, motion (2 s, r) of the elements.
    """

    system: System
    samples: int
    step: float
    omega: np.ndarray
    receptance: np.ndarray
    damping: np.ndarray
    force: np.ndarray
    water: np.ndarray
    motion: np.ndarray


@dataclass(frozen=True, eq=False, kw_only=True)
class RecordResponse:
    """Response to one wave record: amplitudes (k, q) complex of the degrees of freedom on omega (k) [rad/s], of a record of
    `samples` values every `step` [s]; iterations that the drag force took, and the relative change of the last.
    """

    omega: np.ndarray
    amplitude: np.ndarray
    samples: int
    step: float
    iterations: int
    change: float


def record_model(
    system: System, mean: Equilibrium, samples: int, step: float, heading: float, drag_damping, *, highest: float = 2 * np.pi * 0.6,
    low_frequency: str = "hold",
) -> RecordModel:  # fmt: skip
    """Return a model made ready for wave records of a length, along one heading [rad].

    drag_damping (6, 6) is a linearised one that speeds up the iteration; highest [rad/s] above which nothing is solved.
    """
    omega = 2 * np.pi * np.fft.rfftfreq(samples, step)
    omega = omega[1 : int(np.searchsorted(omega, highest))]
    grid = prepare(system, omega, [heading], low_frequency=low_frequency)
    rows = [PLATFORM_DOFS.index(d) for d in system.dofs if d in PLATFORM_DOFS]
    here = system.platform
    damping = np.asarray(drag_damping)[np.ix_(rows, rows)]
    stiffness = dynamic_stiffness(system, mean, grid, here, rows)
    stiffness[:, np.asarray(here)[:, None], here] += 1j * omega[:, None, None] * damping
    force = np.zeros((len(omega), len(system.dofs)), dtype=complex)
    force[:, here] = grid.wave_force[0][:, rows]
    motion = element_motion(system.drag, grid.directions).reshape(-1, 6)
    return RecordModel(
        system=system, samples=samples, step=step, omega=omega, receptance=np.linalg.inv(stiffness), damping=damping, force=force,
        water=grid.water[0], motion=motion[:, rows],
    )  # fmt: skip


def solve_record(
    ready: RecordModel, elevation, *, start=None, tolerance: float = 1e-4, limit: int = 60
) -> RecordResponse:
    """Return the steady response to a periodic record of wave elevation with quadratic drag as it is.

    elevation (t) [m], as many values as the model was made ready for; start, amplitudes (k, q) to begin with. Raises ValueError
    when the iteration does not converge.
    """
    elevation = np.asarray(elevation, dtype=float)
    count = len(elevation)
    if count != ready.samples:
        raise ValueError(f"the model was made ready for {ready.samples} samples, the record has {count}")
    keep, omega, here = slice(1, 1 + len(ready.omega)), ready.omega, ready.system.platform
    waves = np.fft.rfft(elevation)[keep]
    force = ready.force * waves[:, None]
    water = _to_time(ready.water * waves, keep, count)
    amplitude = np.einsum("kij,kj->ki", ready.receptance, force) if start is None else start
    damping, receptance, share, change = ready.damping, ready.receptance, 1.0, np.inf
    for iterations in range(1, limit + 1):
        rate = (1j * omega[:, None] * amplitude[:, here]).T
        relative = water - ready.motion @ _to_time(rate, keep, count)
        total = force.copy()
        total[:, here] += (np.fft.rfft(_drag_force(ready.system, ready.motion, relative))[:, keep] + damping @ rate).T
        step = np.einsum("kij,kj->ki", receptance, total) - amplitude
        before, size = change, np.linalg.norm(amplitude + step, axis=0)
        change = float(np.max(np.linalg.norm(step, axis=0) / np.maximum(size, 1e-9 * np.linalg.norm(size))))
        if change < tolerance:
            amplitude = amplitude + step
            break
        if change > 0.9 * before:  # too weakly damped: go on with the damping that belongs to this very motion
            added = _equivalent_damping(ready.system, ready.motion, relative) - damping
            dynamic = np.linalg.inv(receptance)
            dynamic[:, np.asarray(here)[:, None], here] += 1j * omega[:, None, None] * added
            damping, receptance, share, change = damping + added, np.linalg.inv(dynamic), 0.6, np.inf
            step = (np.einsum("kij,kj->ki", receptance, force) - amplitude) / share
        amplitude = amplitude + share * step
    else:
        raise ValueError(f"drag did not converge on the wave record: change {change:.2g} after {limit} iterations")
    return RecordResponse(
        omega=omega, amplitude=amplitude, samples=count, step=ready.step, iterations=iterations, change=change
    )


def record_response(
    system: System, mean: Equilibrium, elevation, step: float, drive: Excitation, *, highest: float = 2 * np.pi * 0.6,
    low_frequency: str = "hold", tolerance: float = 1e-4, limit: int = 60,
) -> RecordResponse:  # fmt: skip
    """Return the steady response to one periodic record of wave elevation with quadratic drag as it is.

    elevation (t) [m] every step [s]; drive holds the heading and a spectrum for the linearisation that the iteration
    starts from; highest [rad/s] above which nothing is solved. For several records of one length, `record_model` and
    `solve_record` are faster. Raises ValueError when the iteration does not converge.
    """
    first = solve(system, mean, drive, grid=prepare(system, drive.omega, drive.heading, low_frequency=low_frequency))
    ready = record_model(
        system, mean, len(elevation), step, float(drive.heading[0]), first.drag_damping, highest=highest,
        low_frequency=low_frequency,
    )  # fmt: skip
    return solve_record(ready, elevation, tolerance=tolerance, limit=limit)


def record_channels(outputs: LinearOutputs, response: RecordResponse, names=None) -> np.ndarray:
    """Return the time series (t, c) of channels, deviations from the mean, by default all of them."""
    index = [outputs.names.index(n) for n in (names or outputs.names)]
    iw, x = 1j * response.omega[:, None], response.amplitude
    amplitude = (
        x @ outputs.position[index].T
        + iw * (x @ outputs.velocity[index].T)
        + iw**2 * (x @ outputs.acceleration[index].T)
    )
    return _to_time(amplitude.T, slice(1, 1 + len(response.omega)), response.samples).T


def _drag_force(system: System, motion: np.ndarray, relative: np.ndarray) -> np.ndarray:
    """Return the drag force (r, t) on the platform motions kept, for relative velocities (2 s, t) along the resisted directions."""
    pairs = relative.reshape(len(motion) // 2, 2, relative.shape[1])
    speed = np.sqrt(pairs[:, 0] ** 2 + pairs[:, 1] ** 2)
    speed *= system.drag.factor[:, None]
    return motion.T @ (speed[:, None] * pairs).reshape(relative.shape)


def _equivalent_damping(system: System, motion: np.ndarray, relative: np.ndarray) -> np.ndarray:
    """Return the damping (r, r) that does as much work as drag at the relative velocities (2 s, t): E[|u| u u] / E[u u] of each element."""
    pairs = relative.reshape(len(motion) // 2, 2, relative.shape[1])
    square = (pairs**2).sum(axis=1)
    per = system.drag.factor * (square**1.5).mean(axis=1) / np.maximum(square.mean(axis=1), 1e-300)
    return motion.T @ (per.repeat(2)[:, None] * motion)


def _to_time(amplitude: np.ndarray, keep: slice, count: int) -> np.ndarray:
    """Return the time series (..., t) of one-sided Fourier amplitudes (..., k)."""
    full = np.zeros((*amplitude.shape[:-1], count // 2 + 1), dtype=complex)
    full[..., keep] = amplitude
    return np.fft.irfft(full, count)
