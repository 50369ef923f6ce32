"""Assembly: parts to the frequency-domain model, its mean offset and its natural modes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import linear_sum_assignment

from model.conventions import PLATFORM_DOFS, freeze
from model.response.mean_offset import mean_offsets
from model.system.contributions import Contribution, added_mass_contribution, contribution, widen
from model.system.drag import DragMembers
from model.system.hydro import HydroCoefficients, infinite_added_mass, radiation_at
from model.system.mooring import MooringState, MooringSystem
from model.system.tower import TOWER_MODES
from model.system.turbine import TurbineMatrices

DRIFT = 2 * np.pi / 3600  # rad/s


@dataclass(frozen=True, eq=False, kw_only=True)
class System:
    """The assembled model of a floating turbine for any number q of degrees of freedom.

    dofs (q); the constant parts, moorings not among them; turbine (for its wind force and loads); hydro; drag;
    mooring (None for a free floater); quadratic_damping (6, 6); wind_force (q) per m/s, gradient_force (2, q) per (m/s)/m;
    current (s, 3) [m/s] at the drag elements, None without.
    """

    dofs: tuple[str, ...]
    parts: tuple[Contribution, ...]
    turbine: TurbineMatrices
    hydro: HydroCoefficients
    drag: DragMembers
    mooring: MooringSystem | None
    wind_force: np.ndarray
    gradient_force: np.ndarray
    quadratic_damping: np.ndarray
    current: np.ndarray | None = None

    def __post_init__(self):
        q = len(self.dofs)
        freeze(self, wind_force=(q,), gradient_force=(2, q), quadratic_damping=(6, 6))

    @property
    def platform(self) -> list[int]:
        """Places of the platform motions that are kept, among the degrees of freedom."""
        return [self.dofs.index(d) for d in PLATFORM_DOFS if d in self.dofs]

    @property
    def mass(self) -> np.ndarray:
        """Constant mass (q, q), without added mass."""
        return sum(p.mass for p in self.parts)

    @property
    def damping(self) -> np.ndarray:
        """Constant damping (q, q), without radiation and drag."""
        return sum(p.damping for p in self.parts)

    @property
    def stiffness(self) -> np.ndarray:
        """Constant stiffness (q, q), without moorings."""
        return sum(p.stiffness for p in self.parts)


@dataclass(frozen=True, eq=False, kw_only=True)
class Equilibrium:
    """The mean position: offset (q), the moorings there (None when there are none), total stiffness (q, q), Newton steps."""

    offset: np.ndarray
    mooring: MooringState | None
    stiffness: np.ndarray
    iterations: int


@dataclass(frozen=True, eq=False, kw_only=True)
class Modes:
    """Natural modes: name (k) of the degree of freedom that leads, frequency (k) [rad/s], damping_ratio (k), shape (q, k)
    complex, largest motion 1 after rotations are scaled by `lever` metres. frequency_infinite (k) is what the mode would
    have with the infinite-frequency added mass, as a linearisation without radiation memory sees it.
    """

    names: tuple[str, ...]
    frequency: np.ndarray
    damping_ratio: np.ndarray
    shape: np.ndarray
    frequency_infinite: np.ndarray


def assemble(
    dofs: Sequence[str],
    turbine: TurbineMatrices,
    parts: Sequence[Contribution],
    hydro: HydroCoefficients,
    drag: DragMembers,
    mooring: MooringSystem | None,
    quadratic_damping=None,
    current=None,
) -> System:
    """Return the model in the degrees of freedom named, all others locked.

    parts are all constant contributions, the turbine's among them. Raises ValueError for a degree of freedom that no part has.
    """
    known = list(dict.fromkeys(d for p in parts for d in p.dofs))
    for dof in dofs:
        if dof not in known:
            raise ValueError(f"degree of freedom {dof!r} is in no part of the model; there are {', '.join(known)}")
    winds = np.vstack([turbine.wind_force, turbine.gradient_force])
    winds = np.stack([winds[:, turbine.dofs.index(d)] if d in turbine.dofs else np.zeros(3) for d in dofs], axis=1)
    return System(
        dofs=tuple(dofs), parts=tuple(widen(p, dofs) for p in parts), turbine=turbine, hydro=hydro, drag=drag,
        mooring=mooring, wind_force=winds[0], gradient_force=winds[1:],
        quadratic_damping=np.zeros((6, 6)) if quadratic_damping is None else quadratic_damping, current=current,
    )  # fmt: skip


def to_platform(system: System, offset) -> np.ndarray:
    """Return the six platform motions (..., 6) of offsets (..., q); locked ones are zero."""
    offset = np.asarray(offset)
    out = np.zeros(offset.shape[:-1] + (6,), dtype=offset.dtype)
    for k, dof in enumerate(PLATFORM_DOFS):
        if dof in system.dofs:
            out[..., k] = offset[..., system.dofs.index(dof)]
    return out


def equilibrium(system: System, *, tolerance: float = 1e-10, limit: int = 50) -> Equilibrium:
    """Return the mean offset: Newton on constant forces, linear stiffness and the moorings' force.

    Constant parts are linear about their own points, the moorings exact. A step is at most 10 m and 0.2 rad.
    Raises ValueError when it does not converge (moorings that cannot hold the mean force), or nothing holds that force.
    """
    constant, stiffness = _constant_force(system), system.stiffness
    offset = np.zeros(len(system.dofs))
    if system.mooring is None:
        held = np.abs(np.diag(stiffness)) > 1e-6 * np.abs(stiffness).max()
        _check_held(system, constant, held)
        offset[held] = np.linalg.solve(stiffness[np.ix_(held, held)], constant[held])
        return Equilibrium(offset=offset, mooring=None, stiffness=stiffness, iterations=1)
    try:
        found = mean_offsets(system.dofs, constant, stiffness, system.mooring, tolerance=tolerance, limit=limit)
    except np.linalg.LinAlgError:
        found = None
    if found is None or not found.converged:
        last = "singular" if found is None else np.round(found.offset, 3)
        raise ValueError(
            f"no mean offset within {limit} steps (last {last}); can the moorings hold the mean force "
            f"{np.round(constant[:3] / 1e3, 1)} kN, and does the buoyancy carry the weight?"
        )
    return Equilibrium(
        offset=found.offset, mooring=found.mooring, stiffness=found.stiffness, iterations=found.iterations
    )


def _check_held(system: System, force: np.ndarray, held: np.ndarray) -> None:
    """Raise ValueError when a mean force of any size (against the weight) acts where nothing holds the floater."""
    weight = max(np.abs(p.force).max() for p in system.parts)
    for dof, f, hold in zip(system.dofs, force, held, strict=True):
        if not hold and dof in PLATFORM_DOFS[:2] and abs(f) > 1e-4 * weight:
            raise ValueError(f"no mean offset: nothing holds the mean force of {f / 1e3:.1f} kN in {dof}; it needs moorings")


def _constant_force(system: System) -> np.ndarray:
    """Return the force (q) of the constant parts at zero offset."""
    return sum(p.force + p.stiffness @ p.point for p in system.parts)


def all_parts(system: System, mean: Equilibrium) -> list[Contribution]:
    """Return every contribution, moorings at the mean offset and infinite-frequency added mass too, for people to read."""
    out = list(system.parts)
    out.append(widen(added_mass_contribution(system.hydro, "hydrodynamic coefficients"), system.dofs))
    if mean.mooring is not None:
        at = to_platform(system, mean.offset)
        moorings = contribution("moorings", "mooring file, at the mean offset", stiffness=mean.mooring.stiffness,
                                force=mean.mooring.force, point=at)  # fmt: skip
        out.append(widen(moorings, system.dofs))
    return out


def natural_modes(system: System, mean: Equilibrium, drag_damping=None, *, lever: float = 50.0) -> Modes:
    """Return the natural modes about the mean offset with the added mass and radiation damping of their own frequency.

    drag_damping (6, 6) is added when given. Each mode is iterated: complex eigenvalues of the second-order system with
    A(omega) and B(omega) at the mode's last frequency; one that is damped beyond oscillating has its undamped frequency
    and modal damping. Motions that nothing brings back within an hour are drift and left out. lever [m] weighs
    rotations against translations for the names. Raises ValueError for a floater that is statically unstable.
    """
    scale = np.array([lever if d in PLATFORM_DOFS[3:] else 1.0 for d in system.dofs])
    here = np.ix_(system.platform, system.platform)
    rows = [PLATFORM_DOFS.index(d) for d in system.dofs if d in PLATFORM_DOFS]
    inner = np.ix_(rows, rows)

    def matrices(omega):
        added, radiated = radiation_at(system.hydro, np.array([omega]))
        mass, damping = system.mass.copy(), system.damping.copy()
        mass[here] += added[0][inner]
        damping[here] += radiated[0][inner] + (0 if drag_damping is None else drag_damping[inner])
        return mass, damping

    ordinary = all(d in PLATFORM_DOFS + TOWER_MODES for d in system.dofs)
    if ordinary:
        start, first = _undamped_modes(system, mean, here, inner)
    else:  # blades in multi-blade coordinates: gyroscopic, the matrices not symmetric
        values, first = _complex_modes(*matrices(1e3), mean.stiffness)
        start = np.abs(values)
    found = [_mode(matrices, mean.stiffness, w, x, scale) for w, x in zip(start, first.T, strict=True)]
    values = np.array([w for w, _, _ in found])
    order = np.argsort(values)
    values, ratios, start = values[order], np.array([z for _, z, _ in found])[order], start[order]
    shapes = np.array([x for _, _, x in found]).reshape(len(found), len(system.dofs)).T[:, order]
    names = _names(system.dofs, shapes * scale[:, None], values, mean, system)
    size = (shapes * scale[:, None])[np.argmax(np.abs(shapes * scale[:, None]), axis=0), np.arange(len(values))]
    return Modes(names=names, frequency=values, damping_ratio=ratios, shape=shapes / size, frequency_infinite=start)


def _mode(matrices, stiffness, start: float, shape, scale) -> tuple[float, float, np.ndarray]:
    """Return frequency, damping ratio and shape (q) of the mode that is nearest to an undamped one."""
    mass, damping = matrices(start)
    ratio = (shape.conj() @ damping @ shape / (2 * start * (shape.conj() @ mass @ shape))).real
    if ratio >= 1 and np.isrealobj(shape):
        return start, ratio, shape.astype(complex)
    value = start
    for _ in range(30):
        eigenvalues, vectors = _complex_modes(*matrices(abs(value)), stiffness)
        if not len(eigenvalues):
            return start, ratio, shape.astype(complex)
        near = np.argmax(_alike(vectors, shape, scale))
        done = abs(eigenvalues[near] - value) < 1e-9 * abs(value)
        value, shape = eigenvalues[near], vectors[:, near]
        if done:
            break
    return abs(value), -value.real / abs(value), shape


def _undamped_modes(system: System, mean: Equilibrium, here, inner) -> tuple[np.ndarray, np.ndarray]:
    """Return frequencies and shapes without damping, infinite-frequency added mass and the symmetric part of the stiffness."""
    mass = (system.mass + system.mass.T) / 2
    mass[here] += infinite_added_mass(system.hydro)[inner]
    values, shapes = eigh((mean.stiffness + mean.stiffness.T) / 2, mass)
    if values[0] < -(DRIFT**2):
        leads = np.argmax(np.abs(shapes[:, 0]) * np.sqrt(np.diag(mass)))
        raise ValueError(
            f"the floater is statically unstable in {system.dofs[leads]} about its mean offset (stiffness "
            f"{mean.stiffness[leads, leads]:.4g}); check the centre of mass, the hydrostatic stiffness and the moorings"
        )
    kept = values > DRIFT**2
    return np.sqrt(values[kept]), shapes[:, kept]


def _complex_modes(mass, damping, stiffness) -> tuple[np.ndarray, np.ndarray]:
    """Return eigenvalues with positive imaginary part and their shapes (q, k), or all real ones as they are."""
    q = len(mass)
    inverse = np.linalg.inv(mass)
    state = np.block([[np.zeros((q, q)), np.eye(q)], [-inverse @ stiffness, -inverse @ damping]])
    values, vectors = np.linalg.eig(state)
    keep = values.imag > 1e-9
    return values[keep], vectors[:q, keep]


def _alike(vectors, shape, scale) -> np.ndarray:
    a, b = vectors * scale[:, None], shape * scale
    return np.abs(a.conj().T @ b) / np.linalg.norm(a, axis=0) / np.linalg.norm(b)


def _names(dofs, shapes, values, mean, system) -> tuple[str, ...]:
    """Give every mode the degree of freedom with the largest part of its kinetic energy, each one once."""
    mass = system.mass.copy()
    rows = [PLATFORM_DOFS.index(d) for d in system.dofs if d in PLATFORM_DOFS]
    mass[np.ix_(system.platform, system.platform)] += infinite_added_mass(system.hydro)[np.ix_(rows, rows)]
    own = np.sqrt(np.diag(mean.stiffness).clip(1e-12) / np.diag(mass))
    cost = np.abs(np.log(np.abs(values)[None, :] / own[:, None]))
    energy = np.abs(np.diag(mass)[:, None] * np.abs(shapes) ** 2)
    cost = cost - np.log(energy / energy.sum(axis=0) + 1e-6)
    rows, columns = linear_sum_assignment(cost)
    out = [""] * shapes.shape[1]
    for r, c in zip(rows, columns, strict=True):
        out[c] = dofs[r]
    return tuple(out)
