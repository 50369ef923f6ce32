"""Many semisubmersibles on three lines as models: hull, ballast, moorings, mean offset and dynamic stiffness, arrays over designs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.conventions import PLATFORM_DOFS
from model.design.hull import FloatingHull, SemiHull, fairleads, float_hull, hydrostatic_stiffness, three_line_mooring
from model.response.mean_offset import MeanOffsets, mean_offsets
from model.system.hydro_database import HydroBatch
from model.system.mooring import MooringState, MooringSystem, mooring_state
from model.system.turbine import TurbineMatrices


@dataclass(frozen=True, kw_only=True)
class LineType:
    """A mooring line: mass_per_length in air [kg/m], diameter (of its volume) [m], axial_stiffness [N], seabed_friction [-]."""

    mass_per_length: float
    diameter: float
    axial_stiffness: float
    seabed_friction: float = 1.0


@dataclass(frozen=True, kw_only=True)
class Carried:
    """What the hull carries: mass [kg] of tower, nacelle and rotor, height [m] of their centre."""

    mass: float
    height: float


@dataclass(frozen=True, eq=False, kw_only=True)
class Population:
    """N floating designs: hull (N), line length and anchor_radius (N) [m], depth [m], the floating hull with its ballast, moorings,
    and their state at rest.
    """

    anchor_radius: np.ndarray
    length: np.ndarray
    depth: float
    floating: FloatingHull
    mooring: MooringSystem
    at_rest: MooringState

    def __len__(self) -> int:
        return len(self.length)

    @property
    def hull(self) -> SemiHull:
        """The hulls."""
        return self.floating.hull


def straight_distance(hull: SemiHull, anchor_radius, depth: float) -> np.ndarray:
    """Return the distance (N) [m] from fairlead to anchor at rest (equation 6.6 of the study of 10 MW platforms)."""
    lead = fairleads(hull)[..., 0, :]
    return np.hypot(anchor_radius - np.hypot(lead[..., 0], lead[..., 1]), depth + lead[..., 2])


def populate(
    hull: SemiHull, anchor_radius, length, *, line: LineType, carried: Carried, depth: float, density: float = 1025.0, gravity: float = 9.80665
) -> Population:  # fmt: skip
    """Return N designs ballasted to their draft under the turbine and the lines' pull at rest.

    hull of shape (N,); anchor_radius and length (N) [m]. Designs that cannot float are marked by `floating.possible`. Raises
    ValueError when a line cannot reach at rest (see `straight_distance`).
    """
    mooring = three_line_mooring(
        hull, anchor_radius=anchor_radius, length=length, depth=depth, gravity=gravity, density=density, **vars(line)
    )
    rest = mooring_state(mooring, np.zeros((len(length), 6)))
    floating = float_hull(
        hull, carried_mass=carried.mass, carried_height=carried.height, mooring_pull=-rest.force[:, 2], density=density, gravity=gravity
    )
    return Population(
        anchor_radius=np.asarray(anchor_radius), length=np.asarray(length), depth=depth, floating=floating, mooring=mooring, at_rest=rest
    )


def stiff_as(hull: SemiHull, anchor_radius, stiffness: float, *, line: LineType, depth: float, gravity: float = 9.80665, density: float = 1025.0):
    """Return the line lengths (N) [m] at which the moorings' surge stiffness at rest is the one given [N/m], NaN where none is.

    The longest such length (the slack branch is monotonic: shorter is stiffer), by bisection to a micrometre.
    """
    anchor_radius = np.broadcast_to(np.asarray(anchor_radius, dtype=float), hull.shape)
    lead = fairleads(hull)[..., 0, :]
    short = straight_distance(hull, anchor_radius, depth) * 1.001
    long = (anchor_radius - np.hypot(lead[..., 0], lead[..., 1]) + depth + lead[..., 2]) * 0.999

    def over(length):
        mooring = three_line_mooring(
            hull, anchor_radius=anchor_radius, length=length, depth=depth, gravity=gravity, density=density, **vars(line)
        )
        return mooring_state(mooring, np.zeros(hull.shape + (6,))).stiffness[..., 0, 0] - stiffness

    found = (over(short) > 0) & (over(long) < 0)
    for _ in range(28):
        middle = (short + long) / 2
        stiff = over(middle) > 0
        short, long = np.where(stiff, middle, short), np.where(stiff, long, middle)
    return np.where(found, (short + long) / 2, np.nan)


def fixed_matrices(population: Population, *, density: float = 1025.0, gravity: float = 9.80665) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return mass (N, 6, 6), stiffness (N, 6, 6) and force (N, 6) of platform and hydrostatics about the origin."""
    f, n = population.floating, len(population)
    mass, stiffness, force = np.zeros((n, 6, 6)), hydrostatic_stiffness(f, density=density, gravity=gravity), np.zeros((n, 6))
    z, m = f.centre_of_mass, f.mass
    for k in range(3):
        mass[:, k, k] = m
        mass[:, 3 + k, 3 + k] = f.inertia[:, k] + (m * z**2 if k < 2 else 0.0)
    mass[:, 0, 4] = mass[:, 4, 0] = m * z
    mass[:, 1, 3] = mass[:, 3, 1] = -m * z
    stiffness[:, 3, 3] -= m * gravity * z
    stiffness[:, 4, 4] -= m * gravity * z
    force[:, 2] = density * gravity * f.volume - m * gravity
    return mass, stiffness, force


def population_offsets(population: Population, turbine: TurbineMatrices, *, density: float = 1025.0, gravity: float = 9.80665) -> MeanOffsets:
    """Return the mean offsets (N, q) of designs under a turbine at its operating point."""
    _, stiffness, force = fixed_matrices(population, density=density, gravity=gravity)
    n, q = len(population), len(turbine.dofs)
    c, f = np.zeros((n, q, q)), np.zeros((n, q))
    c[:] = turbine.stiffness
    c[:, :6, :6] += stiffness
    f[:] = turbine.force + turbine.stiffness @ turbine.point
    f[:, :6] += force
    return mean_offsets(turbine.dofs, f, c, population.mooring)


def population_dynamics(
    population: Population, turbine: TurbineMatrices, stiffness: np.ndarray, hydro: HydroBatch, *, density: float = 1025.0, gravity: float = 9.80665
) -> np.ndarray:  # fmt: skip
    """Return the dynamic stiffness (N, q, q, n) without drag; stiffness (N, q, q) with moorings at the mean offset.

    The turbine's first six degrees of freedom are the platform's.
    """
    if turbine.dofs[:6] != PLATFORM_DOFS:
        raise ValueError(f"the turbine's degrees of freedom are {turbine.dofs}; the first six must be the platform's")
    mass = np.repeat(turbine.mass[None], len(population), axis=0)
    mass[:, :6, :6] += fixed_matrices(population, density=density, gravity=gravity)[0]
    w = hydro.omega
    out = (stiffness[..., None] - w**2 * mass[..., None]) + 1j * w * turbine.damping[..., None]
    out[:, :6, :6] += np.moveaxis(-(w[:, None, None] ** 2) * hydro.added_mass + 1j * w[:, None, None] * hydro.radiation_damping, 1, -1)
    return out
