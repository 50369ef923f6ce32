"""Linear hydrodynamic coefficients of one floating body, and what is done with them: interpolation and transfer."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicSpline

from model.conventions import freeze, move_force, move_matrix, weight_stiffness
from model.system.morison import InertiaElements, added_mass_of, wave_force_on


@dataclass(frozen=True, eq=False, kw_only=True)
class HydroCoefficients:
    """Potential-flow coefficients of one body about its reference point.

    omega (n) [rad/s] ascending, without zero and infinity; heading (m) [rad] ascending, directions of propagation;
    added_mass, radiation_damping (n, 6, 6); added_mass_zero, added_mass_infinite (6, 6) or None;
    excitation complex (m, n, 6) per metre of wave amplitude; hydrostatic_stiffness (6, 6), buoyancy only (no weight);
    volume [m3] and centre_of_buoyancy (3) [m] of the body at rest; reference_point (3) [m]; density [kg/m3];
    gravity [m/s2]; depth [m]. members outside the potential flow, None without: all fields but the excitation hold their part
    already (`with_members`), their wave force is exact at any frequency and heading.
    """

    omega: np.ndarray
    added_mass: np.ndarray
    radiation_damping: np.ndarray
    added_mass_zero: np.ndarray | None = None
    added_mass_infinite: np.ndarray | None = None
    heading: np.ndarray | None = None
    excitation: np.ndarray | None = None
    hydrostatic_stiffness: np.ndarray | None = None
    volume: float | None = None
    centre_of_buoyancy: np.ndarray | None = None
    reference_point: np.ndarray = (0.0, 0.0, 0.0)
    density: float = 1025.0
    gravity: float = 9.80665
    depth: float = np.inf
    members: InertiaElements | None = None

    def __post_init__(self):
        freeze(
            self, omega=("n",), heading=("m",), added_mass=("n", 6, 6), radiation_damping=("n", 6, 6),
            added_mass_zero=(6, 6), added_mass_infinite=(6, 6), excitation=("m", "n", 6),
            hydrostatic_stiffness=(6, 6), centre_of_buoyancy=(3,), reference_point=(3,),
        )  # fmt: skip
        for name, values in (("omega", self.omega), ("heading", self.heading)):
            if values is not None and not np.all(np.diff(values) > 0):
                raise ValueError(f"{name} must ascend without repetition")
        if np.any(self.omega <= 0) or not np.all(np.isfinite(self.omega)):
            raise ValueError(
                f"omega runs from {self.omega.min()} to {self.omega.max()} rad/s; it must be positive and finite: "
                "zero and infinity have their own fields, added_mass_zero and added_mass_infinite"
            )
        if (self.excitation is None) != (self.heading is None):
            raise ValueError("excitation and heading belong together; give both or neither")
        for field in fields(self):
            value = getattr(self, field.name)
            if isinstance(value, np.ndarray) and not np.all(np.isfinite(value)):
                raise ValueError(f"{field.name} has a value that is not a finite number")


def infinite_added_mass(hydro: HydroCoefficients) -> np.ndarray:
    """Return the infinite-frequency added mass (6, 6), that of the highest frequency where the data lack it."""
    return hydro.added_mass[-1] if hydro.added_mass_infinite is None else hydro.added_mass_infinite


def with_members(hydro: HydroCoefficients, members: InertiaElements) -> HydroCoefficients:
    """Return the coefficients of a body with members outside the potential flow added to it.

    Their added mass does not depend on frequency; buoyancy goes to stiffness, volume and centre. Raises ValueError for a body
    that has members already, has no excitation, or whose reference point is not the origin.
    """
    if hydro.members is not None or hydro.excitation is None or np.any(hydro.reference_point):
        raise ValueError("members are added once, to coefficients with excitation about the origin")
    mass = added_mass_of(members)
    volume = (hydro.volume or 0.0) + members.volume
    own = np.zeros(3) if hydro.centre_of_buoyancy is None else hydro.centre_of_buoyancy
    centre = ((hydro.volume or 0.0) * own + members.volume * members.centre) / volume if volume > 0 else own

    def heavier(matrix):
        return None if matrix is None else matrix + mass

    return replace(
        hydro, members=members, volume=volume, centre_of_buoyancy=centre, added_mass=heavier(hydro.added_mass),
        added_mass_zero=heavier(hydro.added_mass_zero), added_mass_infinite=heavier(hydro.added_mass_infinite),
        hydrostatic_stiffness=None if hydro.hydrostatic_stiffness is None else hydro.hydrostatic_stiffness + members.stiffness,
    )  # fmt: skip


def of_members(
    members: InertiaElements, *, density: float, gravity: float, depth: float, omega=None
) -> HydroCoefficients:
    """Return the coefficients of a body of members alone, without potential flow.

    omega (n) [rad/s] to list the coefficients at, which do not depend on it; by default 0.05 to 3.2.
    """
    omega = np.arange(1, 65) / 20 if omega is None else np.asarray(omega, dtype=float)
    heading = np.radians(np.arange(-180, 181, 30))
    zero = np.zeros((len(omega), 6, 6))
    empty = HydroCoefficients(
        omega=omega, heading=heading, added_mass=zero, radiation_damping=zero, added_mass_zero=zero[0], added_mass_infinite=zero[0],
        excitation=np.zeros((len(heading), len(omega), 6), dtype=complex), hydrostatic_stiffness=np.zeros((6, 6)), volume=0.0,
        centre_of_buoyancy=np.zeros(3), density=density, gravity=gravity, depth=depth,
    )  # fmt: skip
    return with_members(empty, members)


def tabulated(hydro: HydroCoefficients) -> HydroCoefficients:
    """Return the coefficients with the wave force of members in the table of excitation, at its own frequencies and headings."""
    if hydro.members is None:
        return hydro
    return replace(hydro, members=None, excitation=excitation_at(hydro, hydro.omega, hydro.heading))


LOW_FREQUENCY = ("hold", "hydrostatic")
FADE = 0.1  # rad/s within which the slope of the excitation fades beyond the data


def radiation_at(hydro: HydroCoefficients, omega) -> tuple[np.ndarray, np.ndarray]:
    """Return added mass and radiation damping (k, 6, 6) at frequencies omega (k) [rad/s].

    Linear between the data, so symmetry and a non-negative damping are kept (a convex combination). Below the data:
    towards the zero-frequency added mass and no damping. Above: added mass tends to its infinite-frequency
    value as omega^-2 and damping falls as omega^-4 (without that value both are held, damping falling alike).
    """
    omega = np.asarray(omega, dtype=float)
    low = hydro.added_mass[0] if hydro.added_mass_zero is None else hydro.added_mass_zero
    high = infinite_added_mass(hydro)
    grid = np.concatenate([[0.0], hydro.omega])
    index, weight = _bracket(grid, np.minimum(omega, grid[-1]))
    beyond = np.minimum(1.0, grid[-1] / np.maximum(omega, 1e-12)) ** 2
    added = _lerp(np.concatenate([low[None], hydro.added_mass]), index, weight)
    damping = _lerp(np.concatenate([np.zeros((1, 6, 6)), hydro.radiation_damping]), index, weight)
    beyond = beyond[:, None, None]
    return high + (added - high) * beyond, damping * beyond**2


def excitation_at(hydro: HydroCoefficients, omega, heading, *, low_frequency: str = "hold") -> np.ndarray:
    """Return the excitation (..., k, 6) [N/m, N m/m] at frequencies omega (k) and headings (...) [rad].

    Linear in frequency and heading, real and imaginary parts apart, as OpenFAST's HydroDyn does. Below the lowest
    frequency of the data `low_frequency` = "hold" keeps the lowest value, as HydroDyn does, and "hydrostatic"
    goes linearly to the hydrostatic limit C[:, 2]; above the highest the excitation falls as omega^-2, after its slope there has faded
    within FADE. What members outside the potential flow add is not interpolated.
    Raises ValueError for a heading outside the data.
    """
    if hydro.excitation is None:
        raise ValueError("these hydrodynamic coefficients hold no excitation")
    if low_frequency not in LOW_FREQUENCY:
        raise ValueError(f"low_frequency is {low_frequency!r}, needs one of {', '.join(LOW_FREQUENCY)}")
    omega = np.asarray(omega, dtype=float)
    at_heading = _at_heading(hydro, np.asarray(heading, dtype=float))
    lowest = at_heading[..., :1, :]
    if low_frequency == "hydrostatic":
        if hydro.hydrostatic_stiffness is None:
            raise ValueError('low_frequency "hydrostatic" needs the hydrostatic stiffness')
        limit = hydro.hydrostatic_stiffness[:, 2] - (0 if hydro.members is None else hydro.members.stiffness[:, 2])
        lowest = np.broadcast_to(limit.astype(complex), lowest.shape)
    values = np.concatenate([lowest, at_heading], axis=-2)
    grid = np.concatenate([[0.0], hydro.omega])
    index, weight = _bracket(grid, np.minimum(omega, grid[-1]))
    beyond = np.minimum(1.0, grid[-1] / np.maximum(omega, 1e-12)) ** 2
    w = weight[:, None]
    potential = ((1 - w) * values[..., index, :] + w * values[..., index + 1, :] + _run_out(grid, values, omega)) * beyond[:, None]
    if hydro.members is None:
        return potential
    return potential + wave_force_on(
        hydro.members, omega, heading, density=hydro.density, gravity=hydro.gravity, depth=hydro.depth, reference=hydro.reference_point
    )  # fmt: skip


def _run_out(grid, values, omega) -> np.ndarray | float:
    """Return what the slope at the last of the frequencies grid (n) adds to values (..., n, 6) beyond, so that there is no bend."""
    more = np.maximum(omega - grid[-1], 0.0)
    if not np.any(more) or len(grid) < 3:
        return 0.0
    slope = (values[..., -1, :] - values[..., -2, :]) / (grid[-1] - grid[-2]) + 2 * values[..., -1, :] / grid[-1]
    return slope[..., None, :] * (FADE * -np.expm1(-more / FADE))[:, None]


def refined(hydro: HydroCoefficients, step: float = 0.0125) -> HydroCoefficients:
    """Return the same coefficients with more frequencies between the data's, at most `step` [rad/s] apart, on cubic splines.

    Coefficients turn over a few hundredths of a rad/s where columns interfere; a straight line between coarse data cuts the
    corners. What a spline makes negative in the damping matrix is cut, so that no motion gains energy.
    """
    omega = hydro.omega
    if len(omega) < 4 or np.diff(omega).max() <= step:
        return hydro
    pieces = [np.linspace(a, b, 1 + int(np.ceil((b - a) / step - 1e-9))) for a, b in pairwise(omega)]
    fine = np.unique(np.concatenate(pieces))
    between = ~np.isin(fine, omega)

    def spline(values, axis: int = 0):
        return CubicSpline(omega, values, axis=axis)(fine)

    damping = spline(hydro.radiation_damping)
    damping[between] = _without_gain(damping[between], np.abs(np.einsum("nii->ni", hydro.radiation_damping)).max(axis=0))
    return replace(
        hydro, omega=fine, added_mass=spline(hydro.added_mass), radiation_damping=damping,
        excitation=None if hydro.excitation is None else spline(hydro.excitation, axis=1),
    )  # fmt: skip


def _without_gain(damping: np.ndarray, peak: np.ndarray) -> np.ndarray:
    """Return damping matrices (n, 6, 6) without the negative part of their symmetric part, motions scaled by the root of peak (6)."""
    scale = np.sqrt(np.where(peak > 0, peak, 1.0))
    whole = np.outer(scale, scale)
    values, vectors = np.linalg.eigh((damping + np.swapaxes(damping, 1, 2)) / 2 / whole)
    return damping - (vectors * np.minimum(values, 0.0)[:, None, :]) @ np.swapaxes(vectors, 1, 2) * whole


def headings_cover(hydro: HydroCoefficients, heading) -> np.ndarray:
    """Tell for each heading [rad] whether the data reach it (a set that spans a full turn reaches all)."""
    grid, angle = _full_turn(hydro), _wrap(np.asarray(heading, dtype=float), hydro.heading[0])
    return (angle >= grid[0] - 1e-9) & (angle <= grid[-1] + 1e-9)


def transfer(hydro: HydroCoefficients, point) -> HydroCoefficients:
    """Return the same body's coefficients about another reference point (3) [m]; waves keep their phase origin.

    The buoyancy acts through the body, so the moment about a point that moves with the body changes with the point:
    the stiffness is that of rho g volume as a negative weight at the old point, besides the congruence of the others.
    Raises ValueError when there is a hydrostatic stiffness and no volume.
    """
    offset = np.asarray(point, dtype=float) - hydro.reference_point

    def moved(matrix):
        return None if matrix is None else move_matrix(matrix, offset)

    stiffness = moved(hydro.hydrostatic_stiffness)
    if stiffness is not None and np.any(offset != 0):
        if hydro.volume is None:
            raise ValueError(
                "the hydrostatic stiffness cannot go to another point without the displaced volume; "
                "give it: dataclasses.replace(hydro, volume=...)"
            )
        stiffness = stiffness + weight_stiffness(hydro.density * hydro.volume, offset, hydro.gravity)

    return replace(
        hydro,
        reference_point=np.asarray(point, dtype=float),
        added_mass=moved(hydro.added_mass),
        radiation_damping=moved(hydro.radiation_damping),
        added_mass_zero=moved(hydro.added_mass_zero),
        added_mass_infinite=moved(hydro.added_mass_infinite),
        excitation=None if hydro.excitation is None else move_force(hydro.excitation, offset),
        hydrostatic_stiffness=stiffness,
    )


def _at_heading(hydro: HydroCoefficients, heading: np.ndarray) -> np.ndarray:
    """Return the excitation (..., n, 6) at headings of any shape."""
    if not np.all(headings_cover(hydro, heading)):
        bad = np.degrees(heading[~headings_cover(hydro, heading)]).ravel()[0]
        low, high = np.degrees(hydro.heading[[0, -1]])
        raise ValueError(
            f"heading {bad:.1f} deg lies outside the excitation data ({low:.1f} to {high:.1f} deg); "
            "compute the coefficients for that heading"
        )
    grid = _full_turn(hydro)
    values = (
        hydro.excitation if len(grid) == len(hydro.heading) else np.concatenate([hydro.excitation] * 2)[: len(grid)]
    )
    if len(grid) == 1:
        return np.broadcast_to(values[0], heading.shape + values.shape[1:])
    index, weight = _bracket(grid, np.clip(_wrap(heading, grid[0]), grid[0], grid[-1]))
    w = weight[..., None, None]
    return (1 - w) * values[index] + w * values[index + 1]


def _full_turn(hydro: HydroCoefficients) -> np.ndarray:
    """Return the headings, closed to a full turn when the gap that remains is no wider than the widest step."""
    grid = hydro.heading
    gap = grid[0] + 2 * np.pi - grid[-1]
    if len(grid) > 2 and 1e-9 < gap <= np.diff(grid).max() + 1e-9:
        return np.concatenate([grid, [grid[0] + 2 * np.pi]])
    return grid


def _wrap(angle: np.ndarray, start: float) -> np.ndarray:
    """Return angles shifted by whole turns into [start, start + 2 pi)."""
    return start + np.mod(angle - start + 1e-12, 2 * np.pi) - 1e-12


def _bracket(grid: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the index of the interval and the weight of its upper end, for points inside the grid."""
    index = np.clip(np.searchsorted(grid, x, side="right") - 1, 0, len(grid) - 2)
    return index, (x - grid[index]) / (grid[index + 1] - grid[index])


def _lerp(values: np.ndarray, index: np.ndarray, weight: np.ndarray) -> np.ndarray:
    w = weight[:, None, None]
    return (1 - w) * values[index] + w * values[index + 1]
