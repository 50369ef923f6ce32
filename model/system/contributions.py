"""Who contributes what to the equation of motion: named parts with their sums, so that nothing is counted twice."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from model.conventions import PLATFORM_DOFS, freeze
from model.system.hydro import HydroCoefficients, infinite_added_mass
from model.system.identified import SecondOrder, perturbation_error
from model.system.mooring import MooringSystem, mooring_state
from model.system.tower import TOWER_MODES
from model.system.turbine import RigidBody, TurbineMatrices, platform_matrices


@dataclass(frozen=True, eq=False, kw_only=True)
class Contribution:
    """One part of the equation of motion in its degrees of freedom: mass, damping, stiffness (q, q), and the force (q) that it
    exerts at `point` (q); force(x) = force - stiffness (x - point). source says where the numbers come from.
    """

    name: str
    source: str
    dofs: tuple[str, ...]
    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    force: np.ndarray
    point: np.ndarray

    def __post_init__(self):
        q = len(self.dofs)
        freeze(self, mass=(q, q), damping=(q, q), stiffness=(q, q), force=(q,), point=(q,))


def contribution(
    name: str, source: str, *, mass=None, damping=None, stiffness=None, force=None, point=None
) -> Contribution:
    """Return a contribution in the six platform motions; what is not given is zero."""
    square, line = np.zeros((6, 6)), np.zeros(6)
    return Contribution(
        name=name, source=source, dofs=PLATFORM_DOFS, mass=square if mass is None else mass,
        damping=square if damping is None else damping, stiffness=square if stiffness is None else stiffness,
        force=line if force is None else force, point=line if point is None else point,
    )  # fmt: skip


def platform_contribution(platform: RigidBody, gravity: float, source: str) -> Contribution:
    """Return the platform body: its mass, and the stiffness and force of its weight."""
    mass, stiffness, force = platform_matrices(platform, gravity)
    return contribution("platform mass and weight", source, mass=mass, stiffness=stiffness, force=force)


def hydrostatic_contribution(hydro: HydroCoefficients, source: str) -> Contribution:
    """Return hydrostatics: buoyancy's stiffness (no weight) and the force rho g V at the centre of buoyancy."""
    lift = hydro.density * hydro.gravity * (hydro.volume or 0.0)
    x, y = (0.0, 0.0) if hydro.centre_of_buoyancy is None else hydro.centre_of_buoyancy[:2]
    force = np.array([0.0, 0.0, lift, y * lift, -x * lift, 0.0])
    stiffness = np.zeros((6, 6)) if hydro.hydrostatic_stiffness is None else hydro.hydrostatic_stiffness
    return contribution("hydrostatics", source, stiffness=stiffness, force=force)


def added_mass_contribution(hydro: HydroCoefficients, source: str) -> Contribution:
    """Return the infinite-frequency added mass as a constant part (linearisations without radiation memory hold it)."""
    return contribution("infinite-frequency added mass", source, mass=infinite_added_mass(hydro))


def additional_contribution(preload, stiffness, damping, source: str) -> Contribution:
    """Return HydroDyn's additional preload (6), linear stiffness and damping (6, 6)."""
    return contribution("additional linear terms", source, damping=damping, stiffness=stiffness, force=preload)


def mooring_contribution(mooring: MooringSystem, offset, source: str) -> Contribution:
    """Return the moorings at an offset (6): force there and stiffness about it."""
    state = mooring_state(mooring, np.asarray(offset, dtype=float))
    return contribution("moorings", source, stiffness=state.stiffness, force=state.force, point=offset)


def turbine_contribution(turbine: TurbineMatrices) -> Contribution:
    """Return the turbine's matrices as a contribution."""
    return Contribution(
        name="turbine on its tower", source=turbine.source, dofs=turbine.dofs, mass=turbine.mass, damping=turbine.damping,
        stiffness=turbine.stiffness, force=turbine.force, point=turbine.point,
    )  # fmt: skip


def widen(part: Contribution, dofs: Sequence[str]) -> Contribution:
    """Return a contribution in the degrees of freedom of a larger (or smaller, others locked) model."""
    index = [dofs.index(d) if d in dofs else None for d in part.dofs]
    keep = [k for k, i in enumerate(index) if i is not None]
    to = [i for i in index if i is not None]

    def matrix(a):
        out = np.zeros((len(dofs), len(dofs)))
        out[np.ix_(to, to)] = a[np.ix_(keep, keep)]
        return out

    def vector(a):
        out = np.zeros(len(dofs))
        out[to] = a[keep]
        return out

    return Contribution(
        name=part.name, source=part.source, dofs=tuple(dofs), mass=matrix(part.mass), damping=matrix(part.damping),
        stiffness=matrix(part.stiffness), force=vector(part.force), point=vector(part.point),
    )  # fmt: skip


def turbine_of_linearisation(
    found: SecondOrder, contained: Sequence[Contribution], *, gravity: float, source: str, rigid_mass=None, hub_motion=None
) -> TurbineMatrices:
    """Return the turbine alone: a linearisation less everything else that it holds.

    contained are the parts that the linearised deck held beside the turbine (platform body, hydrostatics, moorings,
    infinite-frequency added mass, additional springs and dampers). The force on the turbine at the operating point
    follows from equilibrium there. ElastoDyn's finite rotation step is taken out of the stiffness; for that
    rigid_mass (r, r), the structural mass in platform motions and tower modes, is needed where there are other degrees
    of freedom, and hub_motion (3, r), the hub's motion, where there is a mean aerodynamic force.
    """
    parts = [widen(p, found.dofs) for p in contained]
    structural = found.mass - sum((p.mass for p in parts if "added mass" in p.name), np.zeros_like(found.mass))
    q = len(found.dofs)
    zero = np.zeros((q, q))
    others = sum((p.force - p.stiffness @ (found.point - p.point) for p in parts), np.zeros(q))
    step_error = _rotation_step_error(found.dofs, structural, rigid_mass, gravity, -others, parts, hub_motion)
    return TurbineMatrices(
        dofs=found.dofs,
        mass=found.mass - sum((p.mass for p in parts), zero),
        damping=found.damping - sum((p.damping for p in parts), zero),
        stiffness=found.stiffness - sum((p.stiffness for p in parts), zero) - step_error,
        force=-others, point=found.point, wind_force=found.wind_force, wind_speed=found.wind_speed,
        rotor_speed=found.rotor_speed, source=source,
    )  # fmt: skip


def _rotation_step_error(dofs, structural, rigid_mass, gravity: float, force, parts, hub_motion) -> np.ndarray:
    """Return the stiffness error (q, q) of ElastoDyn's finite rotation step, by the accelerations of the rigid part.

    force (q) is the turbine's at the operating point; less its weight it is the mean aerodynamic force.
    """
    rigid = [k for k, d in enumerate(dofs) if d in PLATFORM_DOFS + TOWER_MODES]
    names = tuple(dofs[k] for k in rigid)
    if rigid_mass is None:
        if len(rigid) < len(dofs):
            return np.zeros_like(structural)
        rigid_mass = structural
    thrust = None
    if hub_motion is not None and all(d in names for d in PLATFORM_DOFS[:3]):
        own = rigid_mass[2, 2] - sum(p.mass[2, 2] for p in parts if "added mass" not in p.name)
        thrust = np.array([force[dofs.index(d)] for d in PLATFORM_DOFS[:3]]) + [0.0, 0.0, own * gravity]
    error = perturbation_error(np.asarray(rigid_mass), names, gravity, thrust, hub_motion)
    out = np.zeros_like(structural)
    out[:, rigid] = structural[:, rigid] @ np.linalg.solve(rigid_mass, error)
    return out


def condense(turbine: TurbineMatrices, keep: Sequence[str]) -> TurbineMatrices:
    """Return the turbine with the degrees of freedom not kept following statically.

    keep names those that stay, in their order in the turbine. The others move as their own static equations say; forces on them
    are passed on (Guyan 1965, with left and right transformation because the stiffness need not be symmetric).
    """
    stay = [k for k, d in enumerate(turbine.dofs) if d in keep]
    go = [k for k, d in enumerate(turbine.dofs) if d not in keep]
    if not go:
        return turbine
    c = turbine.stiffness
    right, left = np.zeros((len(turbine.dofs), len(stay))), np.zeros((len(stay), len(turbine.dofs)))
    right[stay], left[:, stay] = np.eye(len(stay)), np.eye(len(stay))
    right[go] = -np.linalg.solve(c[np.ix_(go, go)], c[np.ix_(go, stay)])
    left[:, go] = -np.linalg.solve(c[np.ix_(go, go)].T, c[np.ix_(stay, go)].T).T
    return replace(
        turbine, dofs=tuple(turbine.dofs[k] for k in stay), mass=left @ turbine.mass @ right, damping=left @ turbine.damping @ right,
        stiffness=left @ c @ right, force=left @ turbine.force, point=turbine.point[stay], wind_force=left @ turbine.wind_force,
        gradient_force=turbine.gradient_force @ left.T, source=f"{turbine.source}, {len(go)} degrees of freedom condensed",
    )  # fmt: skip
