"""The coupled solution: drag linearised to convergence, complex responses to wave and wind."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from model.conventions import PLATFORM_DOFS, freeze
from model.environment.rotor_wind import RotorSensitivity, rotor_spectra
from model.environment.sea import SeaState, directional_spectrum, wave_kinematics, wave_spectrum, wavenumber
from model.environment.wind import WindState, inflow_spectrum
from model.response.assemble import Equilibrium, System
from model.system.drag import borgman_coefficients, element_motion, linear_drag, resisted_directions
from model.system.hydro import excitation_at, radiation_at

DRAG_MODELS = ("relative", "body", "none")


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
    drag_damping (6, 6) and drag iterations; dynamic stiffness (n, q, q) that was solved, drag included.
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

    def __post_init__(self):
        q = len(self.dofs)
        freeze(
            self, to_wave=("m", "n", q), to_wind=("n", q), to_gradients=(2, "n", q), offset=(q,), drag_damping=(6, 6), dynamic_stiffness=("n", q, q),
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
    velocity ("body", as the source thesis), or left out ("none"), and iterated until no element's coefficient changes
    by more than `tolerance` of the largest. grid comes from `prepare`, with default settings when it is not given.
    Raises ValueError for an unknown drag model.
    """
    if drag not in DRAG_MODELS:
        raise ValueError(f"drag model {drag!r} is none of {', '.join(DRAG_MODELS)}")
    omega = drive.omega
    grid = grid or prepare(system, omega, drive.heading)
    here = system.platform
    rows = [PLATFORM_DOFS.index(d) for d in system.dofs if d in PLATFORM_DOFS]
    dynamic = _dynamic_stiffness(system, mean, grid, here, rows)
    m, n, q = len(drive.heading), len(omega), len(system.dofs)
    winds = 3 if np.any(drive.gradient_spectrum) else 1
    force = np.zeros((n, q, m + winds), dtype=complex)
    force[:, here, :m] = np.moveaxis(grid.wave_force[..., rows], 0, -1)
    force[:, :, m:] = np.vstack([system.wind_force, system.gradient_force])[:winds].T
    linear = _Drag(system, drive, grid, drag, here, rows)
    damping, iterations, converged = np.zeros((6, 6)), 0, True
    solution = None
    if linear.active:
        coefficients = linear.start(dynamic, force)
        converged = False
        for iterations in range(1, limit + 1):
            damping, wave_force = linear.evaluate(coefficients)
            solution = _solve(dynamic, damping, force, wave_force, omega, here, rows)
            new = linear.coefficients(solution)
            change = np.abs(new - coefficients).max() / max(np.abs(new).max(), 1e-300)
            coefficients = linear.accelerate(coefficients, new)
            if change < tolerance:
                converged = True
                break
    if solution is None:
        solution = np.linalg.solve(dynamic, force)
    full = dynamic.copy()
    full[:, np.asarray(here)[:, None], here] += 1j * omega[:, None, None] * damping[np.ix_(rows, rows)]
    gradients = np.moveaxis(solution[:, :, m + 1 :], -1, 0) if winds == 3 else np.zeros((2, n, q), dtype=complex)
    return Response(
        dofs=system.dofs, to_wave=np.moveaxis(solution[:, :, :m], -1, 0), to_wind=solution[:, :, m], to_gradients=gradients, excitation=drive,
        offset=mean.offset, drag_damping=damping, iterations=iterations, converged=converged, dynamic_stiffness=full,
    )  # fmt: skip


def _dynamic_stiffness(system: System, mean: Equilibrium, grid: Grid, here, rows) -> np.ndarray:
    """Return -omega^2 (M + A) + i omega (B0 + B) + C (n, q, q), without drag."""
    w = grid.omega[:, None, None]
    out = (mean.stiffness - w**2 * system.mass) + 1j * (w * system.damping)
    inner = np.ix_(rows, rows)
    radiation = -(w**2) * grid.added_mass + 1j * w * grid.radiation_damping
    out[:, np.asarray(here)[:, None], here] += radiation[(slice(None), *inner)]
    return out


def _solve(dynamic, damping, force, wave_force, omega, here, rows) -> np.ndarray:
    """Return the motions (n, q, m + winds) with drag damping (6, 6) and the waves' drag force (m, 6, n)."""
    z = dynamic.copy()
    z[:, np.asarray(here)[:, None], here] += 1j * omega[:, None, None] * damping[np.ix_(rows, rows)]
    f = force.copy()
    f[:, here, : wave_force.shape[0]] += np.moveaxis(wave_force[:, rows], -1, 0).swapaxes(1, 2)
    return np.linalg.solve(z, f)


class _Drag:
    """The drag iteration of one solution: the elements' kinematics once, their covariances at every step."""

    def __init__(self, system: System, drive: Excitation, grid: Grid, model: str, here, rows):
        self.members, self.model = system.drag, model
        self.quadratic = system.quadratic_damping
        self.active = model != "none" and (len(system.drag) > 0 or bool(np.any(self.quadratic)))
        self.omega, self.here, self.rows = drive.omega, here, rows
        if not self.active:
            return
        self.motion = element_motion(self.members, grid.directions)
        self.flat = self.motion.reshape(2 * len(self.members), 6)[:, rows]
        self.water = np.zeros_like(grid.water) if model == "body" else grid.water
        step = _weights(drive.omega)
        self.wave_weight = drive.wave_spectrum * step
        self.wind_weight = [w * step for w in (drive.wind_spectrum, drive.gradient_spectrum, drive.gradient_spectrum)]
        self.history: list = []

    def start(self, dynamic, force) -> np.ndarray:
        """Return first coefficients: those of the water's velocity with the body at rest, or of undamped motions without waves."""
        if not np.any(self.wave_weight) or not np.any(self.water):
            return self.coefficients(np.linalg.solve(dynamic, force))
        covariance = sum(self._covariance(u, w) for u, w in zip(self.water, self.wave_weight, strict=True))
        return np.concatenate([borgman_coefficients(covariance).ravel(), np.zeros(6)])

    def coefficients(self, solution: np.ndarray) -> np.ndarray:
        """Return the linear coefficients for the motions of a solution (n, q, m + winds)."""
        rate = np.ascontiguousarray(solution[:, self.here].T) * (1j * self.omega)
        covariance, variance = np.zeros((len(self.members), 2, 2)), np.zeros(len(self.rows))
        drivers = [(rate[k], self.water[k], weight) for k, weight in enumerate(self.wave_weight)]
        m = len(self.wave_weight)
        drivers += [(r, 0.0, w) for r, w in zip(rate[m:], self.wind_weight, strict=False) if np.any(w)]
        for motion, water, weight in drivers:
            covariance += self._covariance(water - self.flat @ motion, weight)
            variance += (motion.real**2 + motion.imag**2) @ weight
        own = np.zeros(6)
        own[self.rows] = np.sqrt(8 / np.pi * variance)
        return np.concatenate([borgman_coefficients(covariance).ravel(), own])

    def evaluate(self, packed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the drag damping (6, 6) and the waves' drag force (m, 6, n) of packed coefficients."""
        s = len(self.members)
        b = packed[: 4 * s].reshape(s, 2, 2)
        damping, per_velocity = linear_drag(self.members, self.motion, b)
        damping = damping + self.quadratic * packed[4 * s :]
        if self.model == "body":
            return damping, np.zeros((len(self.water), 6, len(self.omega)))
        return damping, per_velocity.reshape(6, 2 * s) @ self.water

    def accelerate(self, old: np.ndarray, new: np.ndarray) -> np.ndarray:
        """Return the next coefficients: one-step Anderson mixing of the fixed-point iteration."""
        self.history = [*self.history[-1:], (old, new)]
        if len(self.history) < 2:
            return new
        (x0, g0), (x1, g1) = self.history
        f0, f1 = g0 - x0, g1 - x1
        df = f1 - f0
        size = df @ df
        mix = float(np.clip((f1 @ df) / size, -0.9, 0.9)) if size > 0 else 0.0
        return g1 - mix * (g1 - g0)

    def _covariance(self, velocity: np.ndarray, weight: np.ndarray) -> np.ndarray:
        """Return the covariances (s, 2, 2) of velocities (2 s, n) per unit of a spectrum with weights (n)."""
        v = velocity.reshape(len(self.members), 2, len(weight))
        square = (v.real**2 + v.imag**2) @ weight
        cross = (v[:, 0].real * v[:, 1].real + v[:, 0].imag * v[:, 1].imag) @ weight
        return np.stack([square[:, 0], cross, cross, square[:, 1]], axis=-1).reshape(-1, 2, 2)


def _weights(omega: np.ndarray) -> np.ndarray:
    """Return trapezoidal weights of a frequency grid."""
    step = np.diff(omega)
    out = np.zeros_like(omega)
    out[:-1] += step / 2
    out[1:] += step / 2
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
