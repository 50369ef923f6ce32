"""The floating turbine's linear model as x' = A x + B u, y = y0 + C x + D u, its modal form, and balanced reduction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import cholesky, matrix_balance, solve_continuous_lyapunov, svd

from model.conventions import PLATFORM_DOFS, freeze, point_motion
from model.reduce.excitation import ExcitationFit
from model.reduce.radiation import RadiationFit
from model.response.assemble import Equilibrium, System
from model.response.loads import LinearOutputs
from model.system.hydro import infinite_added_mass
from model.system.tower import TOWER_MODES, tower_modes
from model.system.turbine import TurbineStructure, head_motion

INPUTS = ("elevation", "wave_force", "wind", "platform_force", "tower_force")
AXES = ("x", "y", "z", "xx", "yy", "zz")
_RATE = {"m": "m/s", "rad": "rad/s", "m/s": "m/s^2", "rad/s": "rad/s^2"}
WORST_CONDITION = 1e9


@dataclass(frozen=True, eq=False, kw_only=True)
class StateSpace:
    """x' = A x + B u, y = y0 + C x + D u.

    a (n, n), b (n, m), c (p, n), d (p, m), mean (p) = y0; names and units of inputs (m) and outputs (p). initial (n, k) gives the state
    for unit initial conditions named initial_names (k). time_shift [s]: by how much the response to an input named
    elevation is late.
    """

    a: np.ndarray
    b: np.ndarray
    c: np.ndarray
    d: np.ndarray
    mean: np.ndarray
    inputs: tuple[str, ...]
    input_units: tuple[str, ...]
    outputs: tuple[str, ...]
    output_units: tuple[str, ...]
    initial: np.ndarray
    initial_names: tuple[str, ...] = ()
    initial_units: tuple[str, ...] = ()
    time_shift: float = 0.0

    def __post_init__(self):
        m, p = len(self.inputs), len(self.outputs)
        freeze(
            self, a=("n", "n"), b=("n", m), c=(p, "n"), d=(p, m), mean=(p,), initial=("n", len(self.initial_names)),
        )  # fmt: skip

    @property
    def order(self) -> int:
        """Number of states."""
        return len(self.a)


@dataclass(frozen=True, eq=False, kw_only=True)
class ModalForm:
    """The same system with independent modes: z_k' = l_k z_k + b_k u for real poles, and for a pair l = -s + i w the real 2x2
    system [[-s, w], [-w, -s]].

    real (r), decay and frequency (k) [1/s, rad/s] of the pairs (states first all real ones, then pairs); b (n, m),
    c (p, n), d (p, m), mean (p), initial (n, i). condition: of the scaled eigenvectors; perturbation: relative change made to A so that it
    can be diagonalised (zero unless it is defective).
    """

    real: np.ndarray
    decay: np.ndarray
    frequency: np.ndarray
    b: np.ndarray
    c: np.ndarray
    d: np.ndarray
    mean: np.ndarray
    initial: np.ndarray
    condition: float
    perturbation: float

    @property
    def a(self) -> np.ndarray:
        """The matrix A (n, n), block diagonal."""
        r, k = len(self.real), len(self.frequency)
        out = np.zeros((r + 2 * k, r + 2 * k))
        out[range(r), range(r)] = self.real
        first = r + 2 * np.arange(k)
        out[first, first] = out[first + 1, first + 1] = -self.decay
        out[first, first + 1], out[first + 1, first] = self.frequency, -self.frequency
        return out


def transfer(system: StateSpace | ModalForm, omega) -> np.ndarray:
    """Return the transfer functions (n, p, m) of a system at omega (n) [rad/s], the time shift not taken out."""
    iw = 1j * np.asarray(omega, dtype=float)[:, None, None]
    return system.d + system.c @ np.linalg.solve(iw * np.eye(len(system.a)) - system.a, system.b + 0j)


def state_space(
    system: System,
    mean: Equilibrium,
    outputs: LinearOutputs,
    drag_damping,
    radiation: RadiationFit,
    *,
    excitation: ExcitationFit | None = None,
    structure: TurbineStructure | None = None,
    inputs: Sequence[str] = INPUTS,
) -> StateSpace:
    """Return the model about its mean offset as a state space.

    Parameters
    ----------
    system, mean, outputs : the assembled model, its mean offset, its channels
    drag_damping : (6, 6) of the solved response
    radiation, excitation : state spaces of the potential flow; excitation is needed for the input "elevation"
    structure : needed for the input "tower_force" and for the relative wind speed
    inputs : of INPUTS, in that order

    The states are deviations of the degrees of freedom, their rates, radiation and excitation states. Outputs are the
    channels, then rates and accelerations of the platform, then the wind speed relative to the moving hub. Raises ValueError
    for an input that cannot be made.
    """
    unknown = [i for i in inputs if i not in INPUTS]
    if unknown:
        raise ValueError(f"input {unknown[0]!r} is none of {', '.join(INPUTS)}")
    if "elevation" in inputs and excitation is None:
        raise ValueError("the input elevation needs a fit of the excitation; give it or leave the input out")
    if "tower_force" in inputs and structure is None:
        raise ValueError("the input tower_force needs the turbine's structure; give it or leave the input out")
    columns = [c for name in INPUTS if name in inputs for c in _columns(name, system, outputs, structure, excitation)]
    dynamic = _Dynamics(system, mean, drag_damping, radiation, excitation if "elevation" in inputs else None)
    force = np.stack([c.force for c in columns], axis=1) if columns else np.zeros((len(system.dofs), 0))
    wave = np.array([c.wave for c in columns])
    b = dynamic.inputs(force, wave)
    direct = np.stack([c.direct for c in columns], axis=1) if columns else np.zeros((len(outputs.names), 0))
    rows, names, units, level = _output_rows(system, mean, outputs, structure, direct, columns)
    c, d = dynamic.outputs(rows, force)
    initial, initial_names, initial_units = dynamic.initial()
    return StateSpace(
        a=dynamic.a, b=b, c=c, d=d, mean=level, inputs=tuple(c.name for c in columns), input_units=tuple(c.unit for c in columns),
        outputs=names, output_units=units, initial=initial, initial_names=initial_names, initial_units=initial_units,
        time_shift=excitation.shift if "elevation" in inputs else 0.0,
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Column:
    """One input: name, unit, force on the degrees of freedom (q), wave 1 for the elevation, direct part (c) in the channels,
    share in the relative wind."""

    name: str
    unit: str
    force: np.ndarray
    wave: float
    direct: np.ndarray
    wind: float = 0.0


@dataclass(frozen=True, eq=False)
class _Rows:
    """Outputs P x + V x' + A x'' + direct u."""

    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    direct: np.ndarray


def _columns(name: str, system: System, outputs: LinearOutputs, structure, excitation) -> list[_Column]:
    """Return the columns of one group of inputs."""
    q, none = len(system.dofs), np.zeros(len(outputs.names))
    if name == "elevation":
        return [_Column("elevation", "m", np.zeros(q), 1.0, none)]
    if name == "wind":
        forces = np.vstack([system.wind_force, system.gradient_force])
        labels, units = ("wind", "wind_vertical", "wind_lateral"), ("m/s", "1/s", "1/s")
        return [_Column(labels[k], units[k], forces[k], 0.0, outputs.wind[:, k], float(k == 0)) for k in range(3)]
    unit_forces = np.zeros((6, q))
    if name == "tower_force":
        modes = tuple(d for d in system.dofs if d in TOWER_MODES)
        motion = head_motion(structure.tower.top_height, tower_modes(structure.tower, modes), np.zeros(3))
        for k, dof in enumerate(PLATFORM_DOFS + modes):
            if dof in system.dofs:
                unit_forces[:, system.dofs.index(dof)] = motion[:, k]
        direct = _tower_base_share(outputs, structure)
    else:
        for k, dof in enumerate(PLATFORM_DOFS):
            if dof in system.dofs:
                unit_forces[k, system.dofs.index(dof)] = 1.0
        direct = np.zeros((6, len(none)))
    units = ("N",) * 3 + ("N m",) * 3
    return [_Column(f"{name}_{AXES[k]}", units[k], unit_forces[k], 0.0, direct[k]) for k in range(6)]


def _tower_base_share(outputs: LinearOutputs, structure: TurbineStructure) -> np.ndarray:
    """Return what unit forces and moments at the tower top (6) add directly to the channels: (6, c), the tower base's only."""
    base, top = structure.tower.base_height, structure.tower.top_height
    about_origin = point_motion(np.array([0.0, 0.0, top]))  # (3, 6): its transpose takes forces to the origin
    load = np.zeros((6, 6))
    load[:3] = about_origin
    load[3:, 3:] = np.eye(3)
    shear_x, shear_y = load[:, 0], load[:, 1]
    share = {
        "TwrBsFxt": shear_x, "TwrBsFyt": shear_y, "TwrBsMyt": load[:, 4] - base * shear_x, "TwrBsMxt": load[:, 3] + base * shear_y,
    }  # fmt: skip
    return np.stack([share.get(n, np.zeros(6)) for n in outputs.names], axis=1)


def _output_rows(system: System, mean: Equilibrium, outputs: LinearOutputs, structure, direct, columns):
    """Return the rows of all outputs, their names, units and mean values."""
    q, here = len(system.dofs), system.platform
    names, units, level = list(outputs.names), list(outputs.units), list(outputs.mean)
    blocks = [_Rows(outputs.position, outputs.velocity, outputs.acceleration, direct)]
    eye, zero, no_direct = np.eye(q)[here], np.zeros((len(here), q)), np.zeros((len(here), len(columns)))
    blocks += [_Rows(zero, eye, zero, no_direct), _Rows(zero, zero, eye, no_direct)]
    for suffix in ("velocity", "acceleration"):
        for k in here:
            dof = system.dofs[k]
            unit = "m" if dof in PLATFORM_DOFS[:3] else "rad"
            names.append(f"{dof}_{suffix}")
            units.append(_RATE[unit] if suffix == "velocity" else _RATE[_RATE[unit]])
    level += [0.0] * (2 * len(here))
    if structure is not None and any(c.wind for c in columns):
        modes = tuple(d for d in system.dofs if d in TOWER_MODES)
        hub = head_motion(structure.tower.top_height, tower_modes(structure.tower, modes), structure.rotor.apex)
        row = np.zeros((1, q))
        for k, dof in enumerate(PLATFORM_DOFS + modes):
            if dof in system.dofs:
                row[0, system.dofs.index(dof)] = -hub[0, k]
        blocks.append(_Rows(np.zeros((1, q)), row, np.zeros((1, q)), np.array([[c.wind for c in columns]])))
        names.append("relative_wind")
        units.append("m/s")
        level.append(system.turbine.wind_speed)
    rows = _Rows(
        *(np.concatenate([getattr(r, f) for r in blocks]) for f in ("position", "velocity", "acceleration", "direct"))
    )
    return rows, tuple(names), tuple(units), np.array(level)


class _Dynamics:
    """The matrices of motion, radiation and excitation in the order [x, x', radiation, excitation]."""

    def __init__(
        self, system: System, mean: Equilibrium, drag_damping, radiation: RadiationFit, excitation: ExcitationFit | None
    ):
        q, here = len(system.dofs), system.platform
        rows = [PLATFORM_DOFS.index(d) for d in system.dofs if d in PLATFORM_DOFS]
        mass, damping = system.mass.copy(), system.damping.copy()
        infinite = infinite_added_mass(system.hydro) + radiation.added_mass_change
        mass[np.ix_(here, here)] += infinite[np.ix_(rows, rows)]
        damping[np.ix_(here, here)] += np.asarray(drag_damping)[np.ix_(rows, rows)]
        live = np.flatnonzero(_reachable(radiation.a, np.any(radiation.b[:, rows] != 0, axis=1)))
        r, e = len(live), 0 if excitation is None else len(excitation.a)
        self.system, self.q, self.places = (
            system,
            q,
            (slice(0, q), slice(q, 2 * q), slice(2 * q, 2 * q + r), slice(2 * q + r, 2 * q + r + e)),
        )
        position, rate, memory, wave = self.places
        self.inverse = np.linalg.inv(mass)
        from_memory, into_memory = np.zeros((q, r)), np.zeros((r, q))
        from_memory[here], into_memory[:, here] = radiation.c[np.ix_(rows, live)], radiation.b[np.ix_(live, rows)]
        self.a = np.zeros((2 * q + r + e,) * 2)
        self.a[position, rate] = np.eye(q)
        self.a[rate, position] = -self.inverse @ mean.stiffness
        self.a[rate, rate] = -self.inverse @ damping
        self.a[rate, memory] = -self.inverse @ from_memory
        self.a[memory, rate] = into_memory
        self.a[memory, memory] = radiation.a[np.ix_(live, live)]
        self.wave_input = np.zeros(len(self.a))
        if excitation is not None:
            from_wave = np.zeros((q, e))
            from_wave[here] = excitation.c[rows]
            self.a[rate, wave] = self.inverse @ from_wave
            self.a[wave, wave] = excitation.a
            self.wave_input[wave] = excitation.b

    def inputs(self, force: np.ndarray, wave: np.ndarray) -> np.ndarray:
        """Return B (n, m) of forces (q, m) on the degrees of freedom and wave inputs (m)."""
        b = np.outer(self.wave_input, wave)
        b[self.places[1]] += self.inverse @ force
        return b

    def outputs(self, rows: _Rows, force: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return C (p, n) and D (p, m)."""
        c = rows.acceleration @ self.a[self.places[1]]
        c[:, self.places[0]] += rows.position
        c[:, self.places[1]] += rows.velocity
        return c, rows.direct + rows.acceleration @ self.inverse @ force

    def initial(self) -> tuple[np.ndarray, tuple[str, ...], tuple[str, ...]]:
        """Return the states for unit deviations and rates of the degrees of freedom, names and units."""
        dofs = self.system.dofs
        units = ["rad" if d in PLATFORM_DOFS[3:] else "m" for d in dofs]
        return (
            np.eye(len(self.a))[:, : 2 * self.q],
            (*dofs, *(f"{d}_velocity" for d in dofs)),
            (*units, *(_RATE[u] for u in units)),
        )


def _reachable(a: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Return which states (n) the states to start from (n) drive, directly or through others."""
    linked = (a != 0) | np.eye(len(a), dtype=bool)
    while True:
        more = linked @ start
        if np.array_equal(more, start):
            return start
        start = more


def modal_form(system: StateSpace, *, worst: float = WORST_CONDITION) -> ModalForm:
    """Return the modal form of a system, from which its exact response over any time step follows mode by mode.

    Where A has (nearly) equal poles with one eigenvector only, it is changed in its last digits, by as little as brings the
    condition of its eigenvectors below `worst`; the change is in the result.
    """
    if system.order == 0:
        empty = np.zeros(0)
        return ModalForm(
            real=empty, decay=empty, frequency=empty, b=system.b, c=system.c, d=system.d, mean=system.mean, initial=system.initial,
            condition=1.0, perturbation=0.0,
        )  # fmt: skip
    _, (scale, _) = matrix_balance(system.a, permute=False, separate=True)
    balanced = system.a / scale[:, None] * scale
    noise = np.random.default_rng(0).standard_normal(balanced.shape) * np.abs(balanced).max()
    for perturbation in (0.0, 1e-15, 1e-14, 1e-13, 1e-12, 1e-11, 1e-10):
        values, vectors = np.linalg.eig(balanced + perturbation * noise)
        condition = float(np.linalg.cond(vectors))
        if condition < worst:
            break
    else:
        raise ValueError(
            f"the state space cannot be split into modes (condition {condition:.1g}); leave a degree of freedom out"
        )
    real = np.flatnonzero(values.imag == 0)
    pairs = np.flatnonzero(values.imag > 0)
    real, pairs = real[np.argsort(-values[real].real)], pairs[np.argsort(np.abs(values[pairs]))]
    basis = np.zeros(balanced.shape)
    r = len(real)
    basis[:, :r] = vectors[:, real].real
    basis[:, r::2], basis[:, r + 1 :: 2] = vectors[:, pairs].real, vectors[:, pairs].imag
    left, basis = np.linalg.inv(basis) / scale, basis * scale[:, None]
    c = system.c @ basis
    size = np.maximum(
        np.linalg.norm(c / np.maximum(np.abs(system.c).max(axis=1, keepdims=True), 1e-300), axis=0), 1e-300
    )
    size[r::2] = size[r + 1 :: 2] = np.hypot(size[r::2], size[r + 1 :: 2])
    return ModalForm(
        real=values[real].real, decay=-values[pairs].real, frequency=values[pairs].imag, b=(left @ system.b) * size[:, None],
        c=c / size, d=system.d, mean=system.mean, initial=(left @ system.initial) * size[:, None], condition=condition,
        perturbation=perturbation,
    )  # fmt: skip


def reduce_balanced(
    system: StateSpace, order: int | None = None, tolerance: float = 1e-3
) -> tuple[StateSpace, np.ndarray, float]:
    """Return a system with fewer states, its Hankel singular values (n) and the bound of its error.

    Balanced truncation of the system with inputs and outputs scaled to the size of their transfer functions. The bound, twice the
    sum of the values left out, holds for the largest singular value of the scaled error at any frequency (Glover, Int. J.
    Control 39(6), 1984). order: states kept; None keeps as many as bring the bound below `tolerance` times the largest
    value. Raises ValueError for a system that is not stable.
    """
    if np.linalg.eigvals(system.a).real.max(initial=-1.0) >= 0:
        raise ValueError(
            "balanced reduction needs a stable system; are there moorings, and damping in every degree of freedom?"
        )
    gain = np.abs(transfer(system, np.geomspace(1e-3, 10, 200)) - system.d).max(axis=0)
    out_scale = np.maximum(gain.max(axis=1), 1e-300)
    in_scale = np.maximum((gain / out_scale[:, None]).max(axis=0), 1e-300)
    _, (states, _) = matrix_balance(system.a, permute=False, separate=True)
    a = system.a / states[:, None] * states
    b, c = system.b / states[:, None] / in_scale, system.c * states / out_scale[:, None]
    controllability, observability = (
        _root(solve_continuous_lyapunov(a, -b @ b.T)),
        _root(solve_continuous_lyapunov(a.T, -c.T @ c)),
    )
    u, values, vt = svd(observability.T @ controllability)
    bound = 2 * (values.sum() - np.cumsum(values))
    keep = order or int(np.argmax(bound <= tolerance * values[0])) + 1
    keep = min(keep, int(np.sum(values > 1e-14 * values[0])))
    root = np.sqrt(values[:keep])
    right = (controllability @ vt[:keep].T / root) * states[:, None]
    left = (observability @ u[:, :keep] / root).T / states
    reduced = replace(
        system, a=left @ system.a @ right, b=left @ system.b, c=system.c @ right, initial=left @ system.initial
    )
    return reduced, values, float(bound[keep - 1])


def _root(gramian: np.ndarray) -> np.ndarray:
    """Return a root L (n, n) with L L' = a symmetric, non-negative matrix."""
    symmetric = (gramian + gramian.T) / 2
    try:
        return cholesky(symmetric, lower=True)
    except np.linalg.LinAlgError:
        values, vectors = np.linalg.eigh(symmetric)
        return vectors * np.sqrt(np.maximum(values, 0.0))
