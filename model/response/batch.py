"""Many sea states on one model in one call: the same solution, arranged so that all states and frequencies go together."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from model.conventions import PLATFORM_DOFS
from model.response.assemble import Equilibrium, System
from model.response.drag_iteration import DragProblem, coefficients, damping_and_force, drag_problem
from model.response.loads import LinearOutputs
from model.response.solve import Grid, dynamic_stiffness, iterate, trapezoid_weights

_CHUNK = 2048
_COARSE = 2
_STATES = 32  # at a time, so that their motions stay in the processor's memory


@dataclass(frozen=True, eq=False, kw_only=True)
class BatchResponse:
    """Responses of s states on omega (n): to_wave (s, m, n, q), to_wind (s, n, q), to_gradients (s, 2, n, q) or None without
    turbulence; spectra that drove them, wave (s, m, n), wind and gradient (s, n); drag_damping (s, 6, 6); change (s) of the last
    drag iteration.
    """

    omega: np.ndarray
    to_wave: np.ndarray
    to_wind: np.ndarray | None
    to_gradients: np.ndarray | None
    wave_spectrum: np.ndarray
    wind_spectrum: np.ndarray
    gradient_spectrum: np.ndarray
    drag_damping: np.ndarray
    change: np.ndarray


def solve_many(
    system: System,
    mean: Equilibrium,
    grid: Grid,
    wave_spectrum,
    wind_spectrum=None,
    gradient_spectrum=None,
    *,
    drag: str = "relative",
    tolerance: float = 1e-3,
    limit: int = 40,
    workers: int = 2,
) -> BatchResponse:
    """Return the responses of many states about one mean offset.

    wave_spectrum (s, m, n) [m2/(rad/s)] at the grid's headings; wind_spectrum and gradient_spectrum (s, n), left out when calm.
    Drag is iterated on every second frequency, which gives its coefficients to some 1e-3, and the motions are then solved on
    all of them. workers threads share the states. Raises ValueError when drag does not converge for a state.
    """
    waves = np.asarray(wave_spectrum, dtype=float)
    s, n = len(waves), len(grid.omega)
    calm = wind_spectrum is None
    wind = np.zeros((s, n)) if calm else np.asarray(wind_spectrum, dtype=float)
    gradient = np.zeros((s, n)) if gradient_spectrum is None else np.asarray(gradient_spectrum, dtype=float)
    parts = np.array_split(np.arange(s), max(1, min(workers * 4, s // 32)))

    def one(part):
        return _solve_part(system, mean, grid, waves[part], wind[part], gradient[part], calm, drag, tolerance, limit)

    if len(parts) == 1 or workers < 2:
        done = [one(part) for part in parts]
    else:
        with ThreadPoolExecutor(workers) as pool:
            done = list(pool.map(one, parts))
    solution, damping, last = (np.concatenate(x) for x in zip(*done, strict=True))
    if last.max() >= tolerance:
        raise ValueError(f"drag did not converge for state {int(np.argmax(last))}: last change {last.max():.2g}")
    m = waves.shape[1]
    return BatchResponse(
        omega=grid.omega, to_wave=np.moveaxis(solution[..., :m], -1, 1), to_wind=None if calm else solution[..., m],
        to_gradients=np.moveaxis(solution[..., m + 1 :], -1, 1) if not calm and np.any(gradient) else None, wave_spectrum=waves,
        wind_spectrum=wind, gradient_spectrum=gradient, drag_damping=damping, change=last,
    )  # fmt: skip


def batch_spectra(outputs: LinearOutputs, response: BatchResponse, names: Sequence[str] | None = None) -> np.ndarray:
    """Return the response spectra (s, n, c) of channels, by default all, of a batch of states."""
    index = [outputs.names.index(name) for name in (names or outputs.names)]
    iw = 1j * response.omega[:, None, None]
    rows = outputs.position[index].T + iw * outputs.velocity[index].T + iw**2 * outputs.acceleration[index].T

    def power(motion, feed, spectrum):
        channel = np.matmul(motion.transpose(1, 0, 2), rows).transpose(1, 0, 2) + feed
        return (channel.real**2 + channel.imag**2) * spectrum[..., None]

    feeds = outputs.wind[index].T
    out = sum(power(response.to_wave[:, k], 0.0, response.wave_spectrum[:, k]) for k in range(response.to_wave.shape[1]))
    if response.to_wind is not None:
        out = out + power(response.to_wind, feeds[0], response.wind_spectrum)
    if response.to_gradients is not None:
        out = out + sum(power(response.to_gradients[:, k], feeds[1 + k], response.gradient_spectrum) for k in (0, 1))
    return out


def batch_std(outputs: LinearOutputs, response: BatchResponse, names: Sequence[str] | None = None) -> np.ndarray:
    """Return the standard deviations (s, c) of channels of a batch of states.

    A channel is a row on motions, rates, accelerations and the input itself; its variance is the quadratic form of their
    covariance, which is a matrix product over the frequencies.
    """
    index = [outputs.names.index(name) for name in (names or outputs.names)]
    rows = np.stack([outputs.position[index], outputs.velocity[index], outputs.acceleration[index]])
    drives = [(response.to_wave[:, k], response.wave_spectrum[:, k], np.zeros(len(index))) for k in range(response.to_wave.shape[1])]
    if response.to_wind is not None:
        drives.append((response.to_wind, response.wind_spectrum, outputs.wind[index, 0]))
    if response.to_gradients is not None:
        drives += [(response.to_gradients[:, k], response.gradient_spectrum, outputs.wind[index, 1 + k]) for k in (0, 1)]
    variance = sum(_variance(rows, feed, motion, spectrum, response.omega) for motion, spectrum, feed in drives)
    return np.sqrt(np.maximum(variance, 0.0))


def _variance(rows, feed, motion, spectrum, omega) -> np.ndarray:
    """Return the variances (s, c) of channels from one input: rows (3, c, q) on x, x', x'' and feed (c) on the input itself."""
    used = [(order, k) for order in range(3) for k in range(rows.shape[2]) if np.any(rows[order, :, k])]
    matrix = np.column_stack([*(rows[order, :, k] for order, k in used), feed])
    rate = [(1j * omega) ** order for order in range(3)]
    amplitude = np.sqrt(spectrum * trapezoid_weights(omega))
    out = np.empty((len(motion), len(feed)))
    for start in range(0, len(motion), _STATES):
        part = slice(start, start + _STATES)
        weighed = motion[part].transpose(0, 2, 1) * amplitude[part, None]
        terms = np.empty((len(weighed), len(used) + 1, len(omega)), dtype=complex)
        for row, (order, k) in enumerate(used):
            np.multiply(weighed[:, k], rate[order], out=terms[:, row])
        terms[:, -1] = amplitude[part]
        numbers = terms.view(float)  # the real part of a product with the conjugate, as a product of real matrices
        covariance = numbers @ numbers.swapaxes(1, 2)
        out[part] = np.sum((matrix @ covariance) * matrix, axis=-1)
    return out


def _solve_part(system, mean, grid: Grid, waves, wind, gradient, calm: bool, drag: str, tolerance, limit):
    """Return motions, drag damping and last change of some states: drag on coarse frequencies, then motions on all."""
    rows = [PLATFORM_DOFS.index(d) for d in system.dofs if d in PLATFORM_DOFS]
    here, linear, last = system.platform, None, np.zeros(len(waves))
    coarse = np.unique(np.append(np.arange(0, len(grid.omega), _COARSE), len(grid.omega) - 1))
    for places in (coarse, slice(None)):
        omega = grid.omega[places]
        step = trapezoid_weights(omega)
        part = Grid(
            omega=omega, heading=grid.heading, added_mass=grid.added_mass[places], radiation_damping=grid.radiation_damping[places],
            wave_force=grid.wave_force[:, places], directions=grid.directions, water=grid.water[:, :, places],
        )  # fmt: skip
        dynamic = dynamic_stiffness(system, mean, part, here, rows)
        force = _forces(system, part, here, rows, calm, bool(np.any(gradient)))
        winds = np.stack([wind, gradient, gradient], axis=1)[:, :, places] * step
        problem = drag_problem(
            system.drag, part.directions, part.water, omega, rows, waves[:, :, places] * step, winds, system.quadratic_damping,
            drag, system.current,
        )  # fmt: skip
        if not problem.active:
            solution, damping = np.repeat(np.linalg.solve(dynamic, force), len(waves), axis=0), np.zeros((len(waves), 6, 6))
        elif places is coarse:
            solution, _, _, last = iterate(problem, dynamic, force, _places(here), tolerance=tolerance, limit=limit, solve_linear=eliminate)
            linear = coefficients(problem, solution, _places(here))
        else:
            damping, wave_force = damping_and_force(problem, linear)
            solution = eliminate(problem, dynamic, damping, force, wave_force, here)
    return solution, damping, last


def _places(index: list[int]) -> slice | list[int]:
    """Return places as a slice when they are next to each other, which numpy takes without a copy."""
    together = index == list(range(index[0], index[0] + len(index))) if index else False
    return slice(index[0], index[-1] + 1) if together else index


def _forces(system: System, grid: Grid, here, rows, calm: bool, with_gradients: bool) -> np.ndarray:
    """Return the forces (1, n, q, r) of the waves at every heading and of the wind inputs there are."""
    winds = 0 if calm else (3 if with_gradients else 1)
    m = len(grid.heading)
    out = np.zeros((1, len(grid.omega), len(system.dofs), m + winds), dtype=complex)
    out[0][:, here, :m] = np.moveaxis(grid.wave_force[..., rows], 0, -1)
    if winds:
        out[0][:, :, m:] = np.vstack([system.wind_force, system.gradient_force])[:winds].T
    return out


def eliminate(problem: DragProblem, dynamic, damping, force, wave_force, here) -> np.ndarray:
    """Return what `solve_with_drag` does, by elimination across states and frequencies at once.

    Motions that drag does not act on are eliminated first, once for all states; the platform's then without pivoting, which
    dynamic stiffness with damping does not need; equations whose residual shows that it did are solved again with it.
    """
    everything = list(range(dynamic.shape[1]))
    here = everything[here] if isinstance(here, slice) else list(here)
    if not here:
        return np.repeat(np.linalg.solve(dynamic, force), len(damping), axis=0)
    rest = [k for k in everything if k not in here]
    p, n, r = len(here), len(dynamic), force.shape[-1]
    inner, right = dynamic[:, here][:, :, here], force[0][:, here]
    if rest:
        follow = np.linalg.solve(dynamic[:, rest][:, :, rest], np.concatenate([dynamic[:, rest][:, :, here], force[0][:, rest]], axis=-1))
        coupling = dynamic[:, here][:, :, rest]
        inner, right = inner - coupling @ follow[..., :p], right - coupling @ follow[..., p:]
    base = np.ascontiguousarray(np.concatenate([inner, right], axis=-1).transpose(1, 2, 0))
    out = np.empty((len(damping), p + len(rest), r, n), dtype=complex)
    count = max(1, _CHUNK // n)
    rows = np.asarray(problem.rows)
    for start in range(0, len(damping), count):
        part = slice(start, start + count)
        drag = damping[part][:, rows[:, None], rows], None if wave_force is None else wave_force[part][:, :, rows]
        x = solve_equations(lambda drag=drag: _with_drag(base, *drag, problem.omega))
        for k, place in enumerate(here):
            out[part, place] = x[k].swapaxes(0, 1)
        for k, place in enumerate(rest):
            moved = follow[:, k, p:].T[:, None] - sum(follow[:, k, j] * x[j] for j in range(p))
            out[part, place] = moved.swapaxes(0, 1)
    return out.transpose(0, 3, 1, 2)


def _with_drag(base, damping, wave_force, omega) -> np.ndarray:
    """Return equations (p, p + r, s, n), the right sides behind the matrices: base (p, p + r, n) with drag of s states added."""
    p = len(base)
    work = np.empty((p, base.shape[1], len(damping), len(omega)), dtype=complex)
    work.real[:], work.imag[:, p:] = base.real[:, :, None], base.imag[:, p:, None]
    np.add(damping.transpose(1, 2, 0)[..., None] * omega, base.imag[:, :p, None], out=work.imag[:, :p])
    if wave_force is not None:
        work[:, p : p + wave_force.shape[1]] += wave_force.transpose(2, 1, 0, 3)
    return work


def solve_equations(make: Callable[[], np.ndarray]) -> np.ndarray:
    """Return the solutions (p, r, s, n) of equations (p, p + r, s, n), the right sides behind the matrices, across s and n at once.

    make gives the equations anew each time. By elimination without pivoting, with it where a pivot was too small.
    """
    work = make()
    p = len(work)
    x = _eliminated(work, p)
    if x is None:
        work = make()
        x = np.moveaxis(np.linalg.solve(*(np.moveaxis(m, (0, 1), (2, 3)) for m in (work[:, :p], work[:, p:]))), (2, 3), (0, 1))
    return x


def _eliminated(work: np.ndarray, p: int) -> np.ndarray | None:
    """Return the solutions (p, r, s, n) of equations (p, p + r, s, n), which are overwritten; None when a pivot was too small."""
    first, inverse = work[0, p:].copy(), np.empty((p, *work.shape[2:]), dtype=complex)
    with np.errstate(all="ignore"):
        for k in range(p):
            inverse[k] = 1 / work[k, k]
            factor = work[k + 1 :, k] * inverse[k]
            for i in range(p - 1 - k):
                work[k + 1 + i, k + 1 :] -= factor[i] * work[k, k + 1 :]
        x = work[:, p:]
        for k in range(p - 1, -1, -1):
            for j in range(k + 1, p):
                x[k] -= work[k, j] * x[j]
            x[k] *= inverse[k]
        residual = np.abs(sum(work[0, j] * x[j] for j in range(p)) - first).max(initial=0.0)
    return x if residual <= 1e-8 * np.abs(first).max(initial=1e-300) else None
