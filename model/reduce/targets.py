"""The responses that a state space should have: those of the frequency-domain model, between the frequencies of the data too."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from model.conventions import PLATFORM_DOFS, freeze
from model.reduce.importance import excited
from model.reduce.radiation import RadiationFit, retardation_transform
from model.response.assemble import Equilibrium, System
from model.response.loads import LinearOutputs
from model.system.hydro import infinite_added_mass

COARSE, UNKNOWN = 0.08, 0.25  # rad/s between data, and what errors count where they are further apart
PHASE = 0.02 / np.radians(2.0)  # what an error of the phase [rad] counts beside a relative one of the magnitude


@dataclass(frozen=True, eq=False, kw_only=True)
class Targets:
    """Responses at omega (n) [rad/s] of those channels (c) that are excited: gain complex (n, c, 6) is what a unit wave force does to
    them in the state space, share complex (n, c) one over the response of the frequency-domain model, zero where it is too small
    to be compared; data (n) true at the frequencies of the hydrodynamic data, counts (n) what an error counts: less between data that
    are more than COARSE apart and beyond them, where the data do not tell what there is.
    """

    omega: np.ndarray
    gain: np.ndarray
    share: np.ndarray
    data: np.ndarray
    counts: np.ndarray

    def __post_init__(self):
        freeze(self, omega=("n",), gain=("n", "c", 6), share=("n", "c"), counts=("n",))


def force_gain(system: System, mean: Equilibrium, outputs: LinearOutputs, drag_damping, omega, radiation: RadiationFit | None = None):
    """Return what unit forces and moments on the platform do to the channels, complex (n, c, 6), at omega (n) [rad/s].

    drag_damping (6, 6); radiation, when given, takes the place of the radiation of the data.
    """
    omega = np.asarray(omega, dtype=float)
    here, rows = system.platform, [PLATFORM_DOFS.index(d) for d in system.dofs if d in PLATFORM_DOFS]
    memory = retardation_transform(system.hydro, omega) if radiation is None else radiation(omega)
    iw = 1j * omega[:, None, None]
    stiffness = mean.stiffness + iw * system.damping + iw**2 * system.mass
    water = iw * (memory + drag_damping) + iw**2 * infinite_added_mass(system.hydro)
    stiffness[:, np.asarray(here)[:, None], here] += water[:, np.asarray(rows)[:, None], rows]
    unit = np.zeros((len(system.dofs), 6))
    unit[here, rows] = 1.0
    motion = np.linalg.solve(stiffness, np.broadcast_to(unit + 0j, (len(omega), *unit.shape)))
    return (outputs.position + iw * outputs.velocity + iw**2 * outputs.acceleration) @ motion


def targets(
    system: System, mean: Equilibrium, outputs: LinearOutputs, drag_damping, radiation: RadiationFit, force, band, *, data=None,
    step: float = 0.01,
) -> Targets:  # fmt: skip
    """Return the targets in a band (low, high) [rad/s], at the frequencies of the data and in steps [rad/s] between them.

    force : function of omega (n) that gives the wave force (n, 6) of the frequency-domain model per metre of wave amplitude
    data : frequencies [rad/s] at which the coefficients were computed, by default all of the system's
    """
    data = np.array([w for w in (system.hydro.omega if data is None else data) if band[0] < w < band[1]])
    edges = np.concatenate([band[:1], data, band[1:]])
    pieces = [np.linspace(a, b, 1 + int(np.ceil((b - a) / min(step, a / 12)))) for a, b in pairwise(edges)]
    omega = np.unique(np.concatenate(pieces))
    response = np.einsum("nck,nk->nc", force_gain(system, mean, outputs, drag_damping, omega), force(omega))
    size, known = np.abs(response), np.isin(omega, data)
    # the peak of an undamped resonance depends on how closely one looks; at the frequencies of the data it is seldom met
    counts = excited(size, outputs.units, size[known].max(axis=0))
    used = counts.any(axis=0)
    share = np.where(counts, 1 / np.where(counts, response, 1.0), 0.0)[:, used]
    return Targets(
        omega=omega, gain=force_gain(system, mean, outputs, drag_damping, omega, radiation)[:, used], share=share, data=known,
        counts=np.where(known | resolved(omega, data), 1.0, UNKNOWN),
    )  # fmt: skip


def resolved(omega, data) -> np.ndarray:
    """Return whether frequencies (n) [rad/s] are below data (k), or between data that are no more than COARSE apart."""
    gap = np.concatenate([[0.0], np.diff(data), [np.inf]])
    return gap[np.searchsorted(data, omega)] <= COARSE
