"""Many sea states on one model in one call: the same solution, arranged so that all states and frequencies go together."""

from __future__ import annotations

from collections.abc import Sequence
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
    """Return the standard deviations (s, c) of channels of a batch of states."""
    return np.sqrt(np.einsum("snc,n->sc", batch_spectra(outputs, response, names), trapezoid_weights(response.omega)))


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
            solution, _, _, last = iterate(problem, dynamic, force, here, tolerance=tolerance, limit=limit, solve_linear=eliminate)
            linear = coefficients(problem, solution, here)
        else:
            damping, wave_force = damping_and_force(problem, linear)
            solution = eliminate(problem, dynamic, damping, force, wave_force, here)
    return solution, damping, last


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

    Without pivoting, which dynamic stiffness with damping does not need; equations whose residual shows that it did are
    solved again with it.
    """
    n, q = dynamic.shape[:2]
    r = force.shape[-1]
    out = np.empty((len(damping), n, q, r), dtype=complex)
    base = np.ascontiguousarray(np.concatenate([np.broadcast_to(dynamic, (1, n, q, q)), force], axis=-1)[0].transpose(1, 2, 0))
    rate = 1j * problem.omega
    count = max(1, _CHUNK // n)
    for start in range(0, len(damping), count):
        part = slice(start, start + count)
        some = damping[part]
        work = np.repeat(base[:, :, None, :], len(some), axis=2)
        for i, row in zip(here, problem.rows, strict=True):
            for j, column in zip(here, problem.rows, strict=True):
                work[i, j] += some[:, row, column, None] * rate
            if wave_force is not None:
                work[i, q : q + wave_force.shape[1]] += wave_force[part, :, row].transpose(1, 0, 2)
        out[part] = eliminated(work, q)
    return out


def eliminated(work: np.ndarray, q: int) -> np.ndarray:
    """Return the solutions (s, n, q, r) of equations (q, q + r, s, n), the right sides behind the matrices."""
    original = work.copy()
    with np.errstate(all="ignore"):
        for k in range(q - 1):
            factor = work[k + 1 :, k] / work[k, k]
            for i in range(q - 1 - k):
                work[k + 1 + i, k + 1 :] -= factor[i] * work[k, k + 1 :]
        x = work[:, q:]
        for k in range(q - 1, -1, -1):
            for j in range(k + 1, q):
                x[k] -= work[k, j] * x[j]
            x[k] /= work[k, k]
        residual = sum(original[0, j] * x[j] for j in range(q)) - original[0, q:]
        bad = ~(np.abs(residual).max(axis=0) <= 1e-8 * np.abs(original[:, q:]).max(axis=(0, 1)).clip(1e-300))
    out = x.transpose(2, 3, 0, 1)
    if bad.any():
        out = out.copy()
        a, b = (np.moveaxis(m[:, :, bad], -1, 0) for m in (original[:, :q], original[:, q:]))
        out[bad] = np.linalg.solve(a, b)
    return out
