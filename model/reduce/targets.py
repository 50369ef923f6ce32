"""The responses that a state space should have: those of the frequency-domain model, between the frequencies of the data too."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from model.conventions import PLATFORM_DOFS, freeze
from model.reduce.importance import excited
from model.response.assemble import Equilibrium, System
from model.response.cummins import retardation_transform
from model.response.loads import LinearOutputs
from model.system.hydro import infinite_added_mass

PHASE = 0.02 / np.radians(2.0)  # what an error of the phase [rad] counts beside a relative one of the magnitude
LOSS, SHARP = (5e-5, 2e-3), 0.3  # a resonance is too sharp to be followed where this hysteretic damping changes it (channels, own) by that
UNITS = ("m",) * 3 + ("rad",) * 3  # of the platform's motions
ENDS = 1 + np.linspace(-0.02, 0.02, 17)  # of where the data begin and end
FLANKS = 1 + np.array([-0.03, -0.015, -0.007, -0.003, -0.001, -0.0003, 0.0, 0.0003, 0.001, 0.003, 0.007, 0.015, 0.03])  # of a resonance, looked at besides


@dataclass(frozen=True, eq=False, kw_only=True)
class Targets:
    """Responses at omega (n) [rad/s] of those channels (c) that waves excite: gain complex (n, c, 6) is what a unit wave force does to
    them in the state space, share complex (n, c) one over the response of the frequency-domain model, zero where it is too small
    to be compared; data (n) true at the frequencies of the hydrodynamic data.
    """

    omega: np.ndarray
    gain: np.ndarray
    share: np.ndarray
    data: np.ndarray

    def __post_init__(self):
        freeze(self, omega=("n",), gain=("n", "c", 6), share=("n", "c"))


@dataclass(frozen=True, eq=False, kw_only=True)
class Paths:
    """What an error of the radiation does to responses (r) of the frequency-domain model at omega (n) [rad/s].

    Channels to waves (by_waves (r) true) and to wind, and each motion of the platform to a force in its own direction. gain complex
    (n, r, 6): response to unit forces on the platform; motion complex (n, r, 6): of the platform, along with that response; share
    complex (n, r): one over the response, zero where it is too small to be compared; compliance complex (n, 6, 6): motion of the platform
    under unit forces; memory complex (n, 6, 6): K of the data; data (n) true at the frequencies of the hydrodynamic data.
    """

    omega: np.ndarray
    gain: np.ndarray
    motion: np.ndarray
    share: np.ndarray
    by_waves: np.ndarray
    compliance: np.ndarray
    memory: np.ndarray
    data: np.ndarray

    def __post_init__(self):
        freeze(
            self, omega=("n",), gain=("n", "r", 6), motion=("n", "r", 6), share=("n", "r"), compliance=("n", 6, 6),
            memory=("n", 6, 6),
        )  # fmt: skip

    def gain_with(self, memory) -> np.ndarray:
        """Return the gain (n, r, 6) when K (n, 6, 6) takes the place of the data's."""
        more = 1j * self.omega[:, None, None] * (memory - self.memory)
        return self.gain @ np.linalg.inv(np.eye(6) + more @ self.compliance)

    def targets(self, memory) -> Targets:
        """Return the responses to waves as targets of the wave force, for a state space whose radiation is K (n, 6, 6)."""
        return Targets(
            omega=self.omega, gain=self.gain_with(memory)[:, self.by_waves], share=self.share[:, self.by_waves], data=self.data
        )


def force_gain(system: System, mean: Equilibrium, outputs: LinearOutputs, drag_damping, omega) -> np.ndarray:
    """Return what unit forces and moments on the platform do to the channels, complex (n, c, 6), at omega (n) [rad/s].

    drag_damping (6, 6) of the solved response.
    """
    omega = np.asarray(omega, dtype=float)
    return _rows(outputs, omega) @ _under(system, mean, drag_damping, omega, _unit_forces(system))


def paths(
    system: System, mean: Equilibrium, outputs: LinearOutputs, drag_damping, force, band, *, data=None, natural=(), step: float = 0.01
) -> Paths:
    """Return the responses in a band (low, high) [rad/s] at the frequencies of the data, in steps [rad/s] between them, and about
    resonances.

    force : function of omega (n) that gives the wave force (n, 6) of the frequency-domain model per metre of wave amplitude
    data : frequencies [rad/s] at which the coefficients were computed, by default all of the system's
    natural : frequencies [rad/s] of the modes
    """
    data = np.array([w for w in (system.hydro.omega if data is None else data) if band[0] < w < band[1]])
    omega = _grid(data, band, natural, step)
    known, rows = np.isin(omega, data), _rows(outputs, omega)
    unit = _unit_forces(system)
    wind = system.wind_force[:, None] if np.any(system.wind_force) else np.zeros((len(system.dofs), 0))
    forces, waves = np.concatenate([unit, wind], axis=1), force(omega)
    moved = _under(system, mean, drag_damping, omega, forces)
    gain, compliance = rows @ moved[..., :6], unit.T @ moved[..., :6]
    motions = [np.einsum("nij,nj->ni", compliance, waves), *np.moveaxis(unit.T @ moved[..., 6:], 2, 0)]

    def found(x):
        own = np.einsum("nii->ni", unit.T @ x[..., :6])
        return [np.einsum("ncj,nj->nc", rows @ x[..., :6], waves), *np.moveaxis(rows @ x[..., 6:], 2, 0) + outputs.wind[:, 0], own]

    true, little, much = found(moved), *(found(_under(system, mean, drag_damping, omega, forces, k)) for k in LOSS)
    lossy = [*little[:-1], much[-1]]
    sure = [np.abs(y - x) < SHARP * np.abs(x) for x, y in zip(true, lossy, strict=True)]
    sure[-1] &= (omega <= data[-1])[:, None]
    parts = [_counted(y, s, outputs.units, known) for y, s in zip(true[:-1], sure[:-1], strict=True)]
    gains = [gain[:, used] for used, _ in parts]
    driven = [np.broadcast_to(x[:, None], g.shape) for x, g in zip(motions, gains, strict=True)]
    own, share = _counted(true[-1], sure[-1], UNITS, known)
    return Paths(
        omega=omega, gain=np.concatenate([*gains, compliance[:, own]], axis=1),
        motion=np.concatenate([*driven, np.swapaxes(compliance, 1, 2)[:, own]], axis=1),
        share=np.concatenate([*(p[1] for p in parts), share], axis=1), by_waves=np.arange(sum(g.shape[1] for g in gains) + own.sum()) < gains[0].shape[1],
        compliance=compliance, memory=retardation_transform(system.hydro, omega), data=known,
    )  # fmt: skip


def _grid(data, band, natural, step: float) -> np.ndarray:
    """Return the frequencies (n) [rad/s] to look at."""
    edges = np.concatenate([band[:1], data, band[1:]])
    pieces = [np.linspace(a, b, 1 + int(np.ceil((b - a) / min(step, 8 * step * a)))) for a, b in pairwise(edges)]
    near = np.concatenate([np.outer(np.asarray(natural, dtype=float), FLANKS).ravel(), np.outer(data[[0, -1]], ENDS).ravel()])
    return np.unique(np.concatenate([*pieces, near[(near > band[0]) & (near < band[1])]]))


def _rows(outputs: LinearOutputs, omega) -> np.ndarray:
    """Return the channels (n, c, q) per unit motion of the degrees of freedom."""
    iw = 1j * omega[:, None, None]
    return outputs.position + iw * outputs.velocity + iw**2 * outputs.acceleration


def _unit_forces(system: System) -> np.ndarray:
    """Return unit forces on the platform (q, 6); zero columns where it is not free."""
    unit = np.zeros((len(system.dofs), 6))
    unit[system.platform, [PLATFORM_DOFS.index(d) for d in system.dofs if d in PLATFORM_DOFS]] = 1.0
    return unit


def _under(system: System, mean: Equilibrium, drag_damping, omega, force, loss: float = 0.0) -> np.ndarray:
    """Return the motions (n, q, k) under forces (q, k); loss is a share of the stiffness that is added as hysteretic damping."""
    here, rows = system.platform, [PLATFORM_DOFS.index(d) for d in system.dofs if d in PLATFORM_DOFS]
    iw = 1j * omega[:, None, None]
    stiffness = (1 + 1j * loss) * mean.stiffness + iw * system.damping + iw**2 * system.mass
    water = iw * (retardation_transform(system.hydro, omega) + drag_damping) + iw**2 * infinite_added_mass(system.hydro)
    stiffness[:, np.asarray(here)[:, None], here] += water[:, np.asarray(rows)[:, None], rows]
    return np.linalg.solve(stiffness, np.broadcast_to(force + 0j, (len(omega), *force.shape)))


def _counted(response, sure, units, known) -> tuple[np.ndarray, np.ndarray]:
    """Return which of the responses (n, c) to one cause count anywhere, and the share (n, used) of those.

    The peak of an undamped resonance depends on how closely one looks; at the frequencies of the data it is seldom met.
    """
    size = np.abs(response)
    counts = excited(size, units, size[known].max(axis=0)) & sure
    used = counts.any(axis=0)
    return used, np.where(counts, 1 / np.where(counts, response, 1.0), 0.0)[:, used]
