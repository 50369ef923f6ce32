"""The coupled solution: drag linearised to convergence, complex responses to wave and wind."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from model.conventions import PLATFORM_DOFS, freeze
from model.environment.rotor_wind import RotorSensitivity, rotor_spectra
from model.environment.sea import SeaState, directional_spectrum, wave_kinematics, wave_spectrum, wavenumber
from model.environment.wind import WindState, inflow_spectrum
from model.response.assemble import Equilibrium, System
from model.response.drag_iteration import (
    MODELS,
    DragProblem,
    Linearised,
    at_rest,
    change,
    coefficients,
    damping_and_force,
    drag_problem,
    mixed,
    trapezoid_weights,
)
from model.response.drag_residue import group_elements, residue
from model.system.drag import resisted_directions
from model.system.hydro import excitation_at, radiation_at

DRAG_MODELS = MODELS
_SETTLED = 0.02  # change of the incoherent motions' variance, itself a few per cent of the whole, at which the third order is left


@dataclass(frozen=True, eq=False, kw_only=True)
class Excitation:
    """What drives the model: omega (n), headings (m), wave spectra (m, n) [m2/(rad/s)], wind spectrum (n) [(m/s)2/(rad/s)] of the
    whole rotor, and the spectrum (n) [(m/s/m)2/(rad/s)] that the wind's vertical and its lateral gradient have each.
    """

    omega: np.ndarray
    heading: np.ndarray
    wave_spectrum: np.ndarray
    wind_spectrum: np.ndarray
    gradient_spectrum: np.ndarray

    def __post_init__(self):
        freeze(
            self, omega=("n",), heading=("m",), wave_spectrum=("m", "n"), wind_spectrum=("n",), gradient_spectrum=("n",),
        )  # fmt: skip


@dataclass(frozen=True, eq=False, kw_only=True)
class Response:
    """Complex transfer functions about the mean offset.

    dofs (q); to_wave (m, n, q) per metre of wave amplitude at each heading, to_wind (n, q) per m/s, to_gradients (2, n, q) per
    (m/s)/m of the vertical and lateral gradient; excitation; offset (q);
    drag_damping (6, 6) and drag iterations; dynamic stiffness (n, q, q) that was solved, drag included; incoherent (n, q, q), spectra of
    the motions that drag causes without coherence with any input, one-sided per rad/s (zero for linear drag).
    """

    dofs: tuple[str, ...]
    to_wave: np.ndarray
    to_wind: np.ndarray
    to_gradients: np.ndarray
    excitation: Excitation
    offset: np.ndarray
    drag_damping: np.ndarray
    iterations: int
    converged: bool
    dynamic_stiffness: np.ndarray
    incoherent: np.ndarray

    def __post_init__(self):
        q = len(self.dofs)
        freeze(
            self, to_wave=("m", "n", q), to_wind=("n", q), to_gradients=(2, "n", q), offset=(q,), drag_damping=(6, 6), dynamic_stiffness=("n", q, q),
            incoherent=("n", q, q),
        )  # fmt: skip


def excitation(
    omega, seas: SeaState | Sequence[SeaState], wind: WindState | None, headings=None, rotor: RotorSensitivity | None = None
) -> Excitation:
    """Return the spectra that drive the model on a frequency grid omega (n) [rad/s].

    seas: one or several; headings (m) [rad] to split a short-crested sea over, by default those of the seas themselves
    (long-crested). wind None is calm. rotor tells how a turning rotor samples the wind; without it the wind of
    the whole rotor has the spectrum that the wind's `averaging` says, and no gradients.
    """
    omega = np.asarray(omega, dtype=float)
    seas = [seas] if isinstance(seas, SeaState) else list(seas)
    if headings is None:
        spread = any(s.spreading is not None for s in seas)
        headings = np.linspace(-np.pi, np.pi, 24, endpoint=False) if spread else sorted({s.heading for s in seas})
    headings = np.asarray(headings, dtype=float)
    if len(seas) == 1 and len(headings) == 1:
        waves = wave_spectrum(seas[0], omega)[None]
    else:
        waves = directional_spectrum(seas, omega, headings)
    gusts, gradients = np.zeros((2, len(omega)))
    if wind is not None:
        gusts, gradients = rotor_spectra(wind, rotor, omega) if rotor else (inflow_spectrum(wind, omega), gradients)
    return Excitation(
        omega=omega, heading=headings, wave_spectrum=waves, wind_spectrum=gusts, gradient_spectrum=gradients
    )


@dataclass(frozen=True, eq=False, kw_only=True)
class Grid:
    """What depends on the frequencies and headings alone, to be reused by many solutions of one hull.

    omega (n), heading (m); added_mass, radiation_damping (n, 6, 6); wave_force (m, n, 6) per metre of amplitude;
    directions (s, 2, 3) that the drag elements resist, water (m, 2 s, n) the water's velocity along them per metre.
    """

    omega: np.ndarray
    heading: np.ndarray
    added_mass: np.ndarray
    radiation_damping: np.ndarray
    wave_force: np.ndarray
    directions: np.ndarray
    water: np.ndarray


def prepare(system: System, omega, heading, *, low_frequency: str = "hold") -> Grid:
    """Return coefficients and water kinematics on frequencies omega (n) [rad/s] and headings (m) [rad].

    low_frequency as in `excitation_at`. Raises ValueError for a heading outside the data.
    """
    hydro, omega, heading = system.hydro, np.asarray(omega, dtype=float), np.asarray(heading, dtype=float)
    added, damping = radiation_at(hydro, omega)
    directions = resisted_directions(system.drag)
    k = wavenumber(omega, hydro.depth, hydro.gravity)
    field = wave_kinematics(omega, k, hydro.depth, system.drag.position, heading[:, None]).velocity
    water = np.einsum("sak,msnk->msan", directions, field).reshape(len(heading), -1, len(omega))
    return Grid(
        omega=omega, heading=heading, added_mass=added, radiation_damping=damping, directions=directions, water=water,
        wave_force=excitation_at(hydro, omega, heading, low_frequency=low_frequency),
    )  # fmt: skip


def solve(
    system: System,
    mean: Equilibrium,
    drive: Excitation,
    *,
    grid: Grid | None = None,
    drag: str = "relative",
    tolerance: float = 1e-3,
    limit: int = 40,
) -> Response:
    """Return the response of the model about its mean offset.

    Drag is linearised for the Gaussian relative velocity between water and body ("relative"), the body's own
    velocity at every element ("body") or one for all strips and one for all end plates ("global", as the source
    thesis), or left out ("none"), and iterated until no element's coefficient changes by more than `tolerance` of the largest.
    "third_order" adds to "relative" what the linearisation leaves over, to third order (`drag_residue`); with a current
    it is the same as "relative". grid comes from `prepare`, with default settings when it is not given.
    Raises ValueError for an unknown drag model.
    """
    omega = drive.omega
    grid = grid or prepare(system, omega, drive.heading)
    here = system.platform
    rows = [PLATFORM_DOFS.index(d) for d in system.dofs if d in PLATFORM_DOFS]
    dynamic = dynamic_stiffness(system, mean, grid, here, rows)
    m, n, q = len(drive.heading), len(omega), len(system.dofs)
    winds = 3 if np.any(drive.gradient_spectrum) else 1
    force = np.zeros((n, q, m + winds), dtype=complex)
    force[:, here, :m] = np.moveaxis(grid.wave_force[..., rows], 0, -1)
    force[:, :, m:] = np.vstack([system.wind_force, system.gradient_force])[:winds].T
    problem = _problem(system, drive, grid, drag, rows)
    damping, iterations, converged = np.zeros((6, 6)), 0, True
    incoherent, added = np.zeros((n, q, q), dtype=complex), 0.0
    if problem.active:
        solution, damping, iterations, worst = iterate(problem, dynamic, force[None], here, tolerance=tolerance, limit=limit)
        if drag == "third_order" and problem.flow is None and len(system.drag):
            solution, damping, incoherent, added, worst = _third_order(
                problem, dynamic, force, solution, damping, here, tolerance=tolerance, limit=limit
            )
        solution, damping, converged = solution[0], damping[0], bool(worst[0] < tolerance)
    else:
        solution = np.linalg.solve(dynamic, force)
    full = _with_damping(dynamic, omega, here, damping[np.ix_(rows, rows)] + added)
    gradients = np.moveaxis(solution[:, :, m + 1 :], -1, 0) if winds == 3 else np.zeros((2, n, q), dtype=complex)
    return Response(
        dofs=system.dofs, to_wave=np.moveaxis(solution[:, :, :m], -1, 0), to_wind=solution[:, :, m], to_gradients=gradients, excitation=drive,
        offset=mean.offset, drag_damping=damping, iterations=iterations, converged=converged, dynamic_stiffness=full, incoherent=incoherent,
    )  # fmt: skip


def _third_order(problem: DragProblem, dynamic, force, solution, damping, here, *, tolerance: float, limit: int):
    """Return motions (1, n, q, r), drag damping (1, 6, 6), spectra (n, q, q) of the incoherent motions, the damping (n, p, p) that
    came in by the third order, and the last change (1), beginning with the solution of linear drag.
    """
    omega, places = problem.omega, np.asarray(here)
    inner, weights = np.ix_(problem.rows, problem.rows), trapezoid_weights(omega)[:, None, None]
    groups, added, size, worst = group_elements(problem, solution[0], here), 0.0, 0.0, np.zeros(1)
    if groups is None:
        return solution, damping, np.zeros_like(dynamic), added, worst
    for _ in range(limit):
        receptance = np.linalg.inv(_with_damping(dynamic, omega, here, damping[0][inner] + added))
        left = residue(problem, groups, solution[0], receptance, here)
        added, driven = left.damping, force.copy()
        driven[:, here, : len(left.wave_force)] += left.wave_force.transpose(1, 2, 0)
        reach = receptance[:, :, places]
        incoherent = reach @ left.force_spectrum @ reach.conj().swapaxes(1, 2)
        rates = incoherent[:, places[:, None], places] * (omega**2)[:, None, None] * weights
        problem = replace(problem, incoherent=rates)
        start, solved = coefficients(problem, solution, here), _with_damping(dynamic, omega, here, added)
        solution, damping, _, worst = iterate(problem, solved, driven[None], here, tolerance=tolerance, limit=limit, start=start)
        before, size = size, np.einsum("nii->i", rates).real
        if np.all(np.abs(size - before) < _SETTLED * size.clip(1e-300)):
            break
    return solution, damping, incoherent, added, worst


def _with_damping(dynamic, omega, here, damping) -> np.ndarray:
    """Return dynamic stiffness (n, q, q) with more damping (p, p) or (n, p, p) on the platform motions."""
    out = dynamic.copy()
    out[:, np.asarray(here)[:, None], here] += 1j * omega[:, None, None] * damping
    return out


def iterate(
    problem: DragProblem, dynamic, force, here, *, tolerance: float, limit: int, start: Linearised | None = None, solve_linear=None
) -> tuple[np.ndarray, np.ndarray, int, np.ndarray]:
    """Return motions (s, n, q, r), drag damping (s, 6, 6), iterations, and the last change (s) of the drag coefficients.

    dynamic (n, q, q) without drag; force (s or 1, n, q, r) of the waves at every heading and the wind inputs; start are
    coefficients to begin with, by default those of a body at rest; solve_linear replaces `solve_with_drag`.
    """
    solve_linear = solve_linear or solve_with_drag
    linear = start or at_rest(problem)
    if linear is None:
        undamped = np.linalg.solve(dynamic, force)
        linear = coefficients(problem, np.broadcast_to(undamped, (len(problem.wave_weight), *force.shape[1:])), here)
    history: list = []
    for step in range(1, limit + 1):
        damping, wave_force = damping_and_force(problem, linear)
        solution = solve_linear(problem, dynamic, damping, force, wave_force, here)
        new = coefficients(problem, solution, here)
        worst = change(linear, new)
        if worst.max() < tolerance:
            break
        history = [*history[-1:], (linear, new)]
        linear = mixed(history)
    return solution, damping, step, worst


def _problem(system: System, drive: Excitation, grid: Grid, drag: str, rows) -> DragProblem:
    """Return the drag problem of one state."""
    step = trapezoid_weights(drive.omega)
    winds = np.stack([drive.wind_spectrum, drive.gradient_spectrum, drive.gradient_spectrum]) * step
    return drag_problem(
        system.drag, grid.directions, grid.water, drive.omega, rows, drive.wave_spectrum[None] * step, winds[None],
        system.quadratic_damping, drag, system.current,
    )  # fmt: skip


def solve_with_drag(problem: DragProblem, dynamic, damping, force, wave_force, here) -> np.ndarray:
    """Return the motions (s, n, q, r) with drag damping (s, 6, 6) and the waves' drag force (s, m, 6, n)."""
    s, places, rows = len(damping), np.asarray(here), problem.rows
    z = np.repeat(dynamic[None], s, axis=0)
    z[:, :, places[:, None], places] += (1j * problem.omega)[:, None, None] * damping[:, None][..., np.ix_(rows, rows)[0], rows]
    f = np.repeat(force, s, axis=0) if len(force) != s else force.copy()
    if wave_force is not None:
        f[:, :, places, : wave_force.shape[1]] += wave_force[:, :, rows].transpose(0, 3, 2, 1)
    return np.linalg.solve(z, f)


def dynamic_stiffness(system: System, mean: Equilibrium, grid: Grid, here, rows) -> np.ndarray:
    """Return -omega^2 (M + A) + i omega (B0 + B) + C (n, q, q), without drag."""
    w = grid.omega[:, None, None]
    out = (mean.stiffness - w**2 * system.mass) + 1j * (w * system.damping)
    inner = np.ix_(rows, rows)
    radiation = -(w**2) * grid.added_mass + 1j * w * grid.radiation_damping
    out[:, np.asarray(here)[:, None], here] += radiation[(slice(None), *inner)]
    return out


def frequency_grid(
    low: float, high: float, count: int, natural=(), damping=(), *, edges=(), share: float = 0.5
) -> np.ndarray:
    """Return `count` frequencies from low to high [rad/s], logarithmic, denser around natural frequencies.

    natural (k) [rad/s] with their damping ratios (k); `share` of the points follow Lorentzian clusters as wide as the
    peaks, so that narrow resonances are resolved by the same number of points as broad ones. edges [rad/s]
    (cut-offs of a spectrum) become grid points on both sides. Raises ValueError when low, high or count are not sensible.
    """
    if not 0 < low < high or count < 10:
        raise ValueError(f"a frequency grid needs 0 < low < high and 10 points or more, not {low:g}, {high:g}, {count}")
    edges = [e for e in edges if low < e < high]
    natural, damping = np.asarray(natural, dtype=float), np.asarray(damping, dtype=float)
    inside = (natural > low) & (natural < high)
    natural, damping = natural[inside], np.clip(damping[inside], 1e-3, 0.3)
    fine = np.unique(np.concatenate([np.geomspace(low, high, 4000), *(
        w * (1 + z * np.linspace(-20, 20, 801)) for w, z in zip(natural, damping, strict=True)
    )]))  # fmt: skip
    fine = fine[(fine >= low) & (fine <= high)]
    density = 1 / fine / np.log(high / low)
    if len(natural):
        width = natural * damping
        peaks = sum(1 / (np.pi * w * (1 + ((fine - c) / w) ** 2)) for c, w in zip(natural, width, strict=True)) / len(natural)
        density = (1 - share) * density + share * peaks
    total = np.concatenate([[0.0], np.cumsum((density[1:] + density[:-1]) / 2 * np.diff(fine))])
    grid = np.interp(np.linspace(0, total[-1], count - 2 * len(edges)), total, fine)
    sides = [e * (1 + s) for e in edges for s in (-1e-9, 1e-9)]
    return np.sort(np.concatenate([grid, sides]))
