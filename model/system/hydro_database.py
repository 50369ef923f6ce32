"""Hydrodynamic coefficients of a family of hulls, interpolated in their dimensions, the frequency, the heading and the depth.

The family has three numbers (column diameter, platform radius, draft) and three-fold symmetry, so added mass and damping have five
numbers (11 = 22, 33, 55 = 44, 66, 15 = -24) and headings of 0 to 60 degrees say all. Polynomials through Chebyshev points in the
dimensions, at equal scaled frequency, of the values over the columns' diameter squared (their section, which all of them grow with),
and of the square root of the heave damping (the amplitude of the waves that heave makes); cubic splines in the scaled frequency,
trigonometric polynomials in the heading.

The scaled frequency s follows from omega sqrt(radius / g) = s + stretch s^2 (diameter / radius - MIDDLE_RATIO): without the stretch the phases
of the waves between the columns, exp(i k radius), are the same on all hulls; with it the resonances between the columns, which
thick columns move up, lie at the same s too.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline

from model.conventions import frozen
from model.system.haskind import turn as turned

REDUCED = (
    (0, 0, 0, 1),
    (1, 1, 0, 1),
    (2, 2, 1, 1),
    (3, 3, 2, 1),
    (4, 4, 2, 1),
    (5, 5, 3, 1),
    (0, 4, 4, 1),
    (4, 0, 4, 1),
    (1, 3, 4, -1),
    (3, 1, 4, -1),
)
MIRROR = np.array([1.0, -1, 1, -1, 1, -1])
TAIL_POWERS = (2.0, 4.0, 2.0)
MIDDLE_RATIO = 0.47
HEAVE_DAMPING = 6
_TABLES = 8


@dataclass(frozen=True, eq=False, kw_only=True)
class HydroDatabase:
    """Coefficients on a tensor grid.

    diameter (a), radius (b), draft (c): Chebyshev points [m]; inverse_depth (h) [1/m], 0 is deep water; scaled_frequency (n),
    starting at 0; heading (m) [rad] from 0 to 60 degrees; values (h, a, b, c, n, 10 + 12 m): five added masses, five dampings,
    real and imaginary parts of the excitation (m, 6); infinite (a, b, c, 5) added mass; density [kg/m3], gravity [m/s2];
    stretch of the scaled frequency with diameter / radius.
    """

    diameter: np.ndarray
    radius: np.ndarray
    draft: np.ndarray
    inverse_depth: np.ndarray
    scaled_frequency: np.ndarray
    heading: np.ndarray
    values: np.ndarray
    infinite: np.ndarray
    density: float
    gravity: float
    stretch: float = 0.0

    def __post_init__(self):
        for name in ("diameter", "radius", "draft", "inverse_depth", "scaled_frequency", "heading"):
            object.__setattr__(self, name, frozen(getattr(self, name)))
        grid = (len(self.diameter), len(self.radius), len(self.draft))
        want = (len(self.inverse_depth), *grid, len(self.scaled_frequency), 10 + 12 * len(self.heading))
        if np.shape(self.values) != want or np.shape(self.infinite) != (*grid, 5):
            raise ValueError(
                f"values have shape {np.shape(self.values)} and infinite {np.shape(self.infinite)}, need {want} and {(*grid, 5)}"
            )
        if not (np.all(np.isfinite(self.values)) and np.all(np.isfinite(self.infinite))):
            raise ValueError("the database has a value that is not a finite number; is it complete?")
        if self.scaled_frequency[0] != 0:
            raise ValueError(f"the scaled frequency starts at {self.scaled_frequency[0]}, it must start at 0")

    @cached_property
    def tables(self) -> dict[tuple, np.ndarray]:
        """Spline coefficients at the depths and headings that were asked for last."""
        return {}

    @cached_property
    def knots(self) -> np.ndarray:
        """Knots of the cubic splines along the scaled frequency."""
        return make_interp_spline(self.scaled_frequency, np.zeros(len(self.scaled_frequency)), k=3).t


@dataclass(frozen=True, eq=False, kw_only=True)
class HydroBatch:
    """Coefficients of N hulls: omega (n) [rad/s], heading (m) [rad], added_mass and radiation_damping (N, n, 6, 6),
    added_mass_zero and added_mass_infinite (N, 6, 6), excitation (N, m, n, 6) per metre of wave amplitude, e^{+i omega t},
    about the origin.
    """

    omega: np.ndarray
    heading: np.ndarray
    added_mass: np.ndarray
    radiation_damping: np.ndarray
    added_mass_zero: np.ndarray
    added_mass_infinite: np.ndarray
    excitation: np.ndarray


def interpolate(database: HydroDatabase, designs, omega, heading=(0.0,), *, depth: float = np.inf) -> HydroBatch:
    """Return the coefficients of hulls (N, 3) diameter, radius, draft [m] at frequencies (n) [rad/s] and headings (m) [rad].

    depth [m] between the shallowest of the database and infinity. Damping is made positive semi-definite; above the highest
    frequency of the data the distance to the infinite-frequency value falls as omega^-2 (added mass), omega^-4
    (damping), omega^-2 (excitation). Raises ValueError outside the family.
    """
    designs, omega, heading = _checked(database, designs, omega, heading)
    table = _table(database, depth, heading)
    weights, _ = _weights(database, designs)
    section = designs[:, :1] ** 2
    values = _at_frequencies(database, _of_hulls(weights, table), designs, omega)
    values[..., HEAVE_DAMPING] **= 2
    infinite = section * (weights @ _over_section(database, database.infinite).reshape(-1, 5))
    added, damping, excitation = _tails(database, values * section[..., None], infinite, designs, omega, len(heading))
    return HydroBatch(
        omega=omega, heading=heading, added_mass=full_matrix(added), radiation_damping=full_matrix(positive(damping, designs[:, 2])),
        added_mass_zero=full_matrix(section * (weights @ table[:, 0, :5])), added_mass_infinite=full_matrix(infinite), excitation=excitation,
    )  # fmt: skip


def derivative(
    database: HydroDatabase, designs, omega, heading=(0.0,), *, depth: float = np.inf
) -> dict[str, np.ndarray]:
    """Return the derivatives of the coefficients by diameter, radius and draft: added_mass, radiation_damping (3, N, n, 6, 6),
    excitation (3, N, m, n, 6), added_mass_infinite (3, N, 6, 6), each per metre.

    Exact derivatives of `interpolate` inside the data's frequencies, where damping needed no correction.
    """
    designs, omega, heading = _checked(database, designs, omega, heading)
    table, m = _table(database, depth, heading), len(heading)
    weights, slopes = _weights(database, designs)
    here = _of_hulls(weights, table)
    steep = _at_frequencies(database, here, designs, omega, order=1)
    here = _at_frequencies(database, here, designs, omega)
    moved = np.array([_at_frequencies(database, _of_hulls(s, table), designs, omega) for s in slopes])
    moved += _frequency_slopes(database, designs, omega)[..., None] * steep
    moved[..., HEAVE_DAMPING] *= 2 * here[..., HEAVE_DAMPING]
    here[..., HEAVE_DAMPING] **= 2
    moved = _with_section(moved, here, designs[:, 0, None, None])
    force = moved[..., 10 : 10 + 6 * m] + 1j * moved[..., 10 + 6 * m :]
    force = force.reshape(*moved.shape[:-1], m, 6)
    infinite = _over_section(database, database.infinite).reshape(-1, 5)
    limit = _with_section(np.array(slopes) @ infinite, weights @ infinite, designs[:, :1])
    return {
        "added_mass": full_matrix(moved[..., :5]), "radiation_damping": full_matrix(moved[..., 5:10]),
        "excitation": np.moveaxis(force, 3, 2), "added_mass_infinite": full_matrix(limit),
    }  # fmt: skip


def scaled_frequency(omega, diameter, radius, stretch: float, gravity: float) -> np.ndarray:
    """Return the scaled frequencies s of frequencies [rad/s] on hulls [m] (see the module's head)."""
    bare = omega * np.sqrt(radius / gravity)
    return 2 * bare / (1 + np.sqrt(1 + 4 * stretch * (diameter / radius - MIDDLE_RATIO) * bare))


def hull_frequency(s, diameter, radius, stretch: float, gravity: float) -> np.ndarray:
    """Return the frequencies [rad/s] of scaled frequencies on hulls [m]: the inverse of `scaled_frequency`."""
    return (s + stretch * (diameter / radius - MIDDLE_RATIO) * s**2) * np.sqrt(gravity / radius)


def full_matrix(reduced: np.ndarray) -> np.ndarray:
    """Return matrices (..., 6, 6) with three-fold symmetry from their five numbers (..., 5)."""
    out = np.zeros(reduced.shape[:-1] + (6, 6))
    for i, j, k, sign in REDUCED:
        out[..., i, j] = sign * reduced[..., k]
    return out


def positive(damping: np.ndarray, length: np.ndarray) -> np.ndarray:
    """Return dampings (N, n, 5) made positive semi-definite: the nearest such matrix, moments divided by a length (N) [m]."""
    out = np.maximum(damping, 0.0)
    scale = np.asarray(length, dtype=float)[:, None]
    a, b, c = damping[..., 0], damping[..., 4] / scale, damping[..., 2] / scale**2
    mean, half = (a + c) / 2, np.hypot((a - c) / 2, b)
    low, high = mean - half, np.maximum(mean + half, 0.0)
    fix = low < 0
    share = np.where(fix, high / np.where(half > 0, 2 * half, 1.0), 1.0)
    out[..., 0] = np.where(fix, share * (a - low), a)
    out[..., 2] = np.where(fix, share * (c - low), c) * scale**2
    out[..., 4] = np.where(fix, share * b, b) * scale
    return out


def lagrange(nodes: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the Lagrange polynomials of nodes (k) at x (N) and their derivatives, each (N, k)."""
    k = len(nodes)
    apart = nodes[:, None] - nodes + np.eye(k)
    factors = (x[:, None, None] - nodes) / apart
    factors[:, np.arange(k), np.arange(k)] = 1.0
    value, slope = factors.prod(axis=2), np.zeros((len(x), k))
    for j in range(k):
        without = factors.copy()
        without[:, :, j] = 1.0
        without[:, j, j] = 0.0
        slope += without.prod(axis=2) / apart[:, j]
    return value, slope


def heading_map(nodes: np.ndarray, heading: np.ndarray) -> np.ndarray:
    """Return the matrix (m, 6, k, 6) from excitation at headings (k) of 0 to 60 degrees [rad] to any headings (m) [rad].

    Mirror and three-fold symmetry give the full circle, on which a trigonometric polynomial interpolates.
    """
    step = nodes[1] - nodes[0]
    count = round(2 * np.pi / step)
    out = np.zeros((len(heading), 6, len(nodes), 6))
    for j in range(count):
        angle = j * step
        third = np.round(angle / (2 * np.pi / 3))
        rest = angle - third * 2 * np.pi / 3
        k = round(abs(rest) / step)
        turn = turned(third * 2 * np.pi / 3) @ (np.diag(MIRROR) if rest < -1e-9 else np.eye(6))
        out[:, :, k] += _dirichlet(heading - angle, count)[:, None, None] * turn
    return out


def _dirichlet(x: np.ndarray, count: int) -> np.ndarray:
    """Return the cardinal function of trigonometric interpolation on an even number of points."""
    half = np.remainder(x + np.pi, 2 * np.pi) - np.pi
    near = np.abs(half) < 1e-12
    safe = np.where(near, 1.0, half)
    return np.where(near, 1.0, np.sin(count * safe / 2) / np.tan(safe / 2) / count)


def _checked(database: HydroDatabase, designs, omega, heading):
    designs = np.atleast_2d(np.asarray(designs, dtype=float))
    if designs.shape[1:] != (3,):
        raise ValueError(f"designs have shape {designs.shape}; each needs diameter, radius and draft")
    for k, name in enumerate(("diameter", "radius", "draft")):
        nodes, x = getattr(database, name), designs[:, k]
        outside = (x < nodes[0] - 1e-9) | (x > nodes[-1] + 1e-9)
        if np.any(outside):
            raise ValueError(
                f"{name} {x[outside][0]:g} m lies outside the database ({nodes[0]:g} to {nodes[-1]:g} m); build one that reaches it"
            )
    return designs, np.atleast_1d(np.asarray(omega, dtype=float)), np.atleast_1d(np.asarray(heading, dtype=float))


def _table(database: HydroDatabase, depth: float, heading: np.ndarray) -> np.ndarray:
    """Return spline coefficients (a b c, n, 10 + 12 m) at one depth and for the headings wanted."""
    inverse = 1.0 / depth
    if not 0 <= inverse <= database.inverse_depth.max() * (1 + 1e-9):
        shallow = 1 / database.inverse_depth.max() if database.inverse_depth.max() > 0 else np.inf
        raise ValueError(
            f"the depth is {depth:g} m, the database holds {shallow:g} m and deeper; build one for that depth"
        )
    key = (float(depth), heading.tobytes())
    found = database.tables.get(key)
    if found is None:
        if len(database.tables) >= _TABLES:
            database.tables.clear()
        found = database.tables[key] = _fitted(database, inverse, heading)
    return found


def _fitted(database: HydroDatabase, inverse_depth: float, heading: np.ndarray) -> np.ndarray:
    share, _ = lagrange(database.inverse_depth, np.array([inverse_depth]))
    values = np.tensordot(share[0], np.asarray(database.values, dtype=float), axes=1)
    turn = heading_map(database.heading, heading).reshape(6 * len(heading), -1)
    half = 10 + 6 * len(database.heading)
    values = np.concatenate([values[..., :10], values[..., 10:half] @ turn.T, values[..., half:] @ turn.T], axis=-1)
    values = _over_section(database, values)
    values[..., HEAVE_DAMPING] = np.sqrt(np.maximum(values[..., HEAVE_DAMPING], 0.0))
    values = values.reshape(-1, *values.shape[3:])
    return np.ascontiguousarray(np.moveaxis(make_interp_spline(database.scaled_frequency, values, k=3, axis=1).c, 0, 1))


def _over_section(database: HydroDatabase, values: np.ndarray) -> np.ndarray:
    """Return values (a, b, c, ...) over the diameter squared."""
    return values / database.diameter.reshape(-1, *[1] * (values.ndim - 1)) ** 2


def _with_section(slopes: np.ndarray, values: np.ndarray, diameter: np.ndarray) -> np.ndarray:
    """Return the derivatives (3, ...) of the diameter squared times values from those of the values."""
    out = slopes * diameter**2
    out[0] += 2 * diameter * values
    return out


def _weights(database: HydroDatabase, designs: np.ndarray) -> tuple[np.ndarray, list[np.ndarray]]:
    """Return the weights (N, a b c) of the grid's hulls and their derivatives by the three dimensions."""
    parts = [lagrange(getattr(database, n), designs[:, k]) for k, n in enumerate(("diameter", "radius", "draft"))]

    def product(pick):
        a, b, c = (parts[k][pick[k]] for k in range(3))
        return (a[:, :, None, None] * b[:, None, :, None] * c[:, None, None, :]).reshape(len(designs), -1)

    return product((0, 0, 0)), [product(tuple(int(j == k) for j in range(3))) for k in range(3)]


def _of_hulls(weights: np.ndarray, table: np.ndarray) -> np.ndarray:
    return (weights @ table.reshape(len(table), -1)).reshape(len(weights), *table.shape[1:])


def _scaled(database: HydroDatabase, designs: np.ndarray, omega: np.ndarray) -> np.ndarray:
    return scaled_frequency(omega, designs[:, :1], designs[:, 1:2], database.stretch, database.gravity)


def _frequency_slopes(database: HydroDatabase, designs: np.ndarray, omega: np.ndarray) -> np.ndarray:
    """Return the derivatives (3, N, n) of the scaled frequency by diameter, radius and draft [1/m]."""
    s, (diameter, radius) = _scaled(database, designs, omega), designs.T[:2, :, None]
    steep = 1 + 2 * database.stretch * (diameter / radius - MIDDLE_RATIO) * s
    bare = omega * np.sqrt(radius / database.gravity)
    by_diameter = -database.stretch * s**2 / radius
    return np.array([by_diameter, bare / (2 * radius) - by_diameter * diameter / radius, np.zeros_like(s)]) / steep


def _at_frequencies(
    database: HydroDatabase, table: np.ndarray, designs: np.ndarray, omega: np.ndarray, order: int = 0
) -> np.ndarray:
    """Return values (N, frequencies, quantities), or their derivative by s, of spline coefficients (N, n, quantities)."""
    s = np.minimum(_scaled(database, designs, omega), database.scaled_frequency[-1])
    n = len(database.scaled_frequency)
    if order:
        pieces = BSpline(database.knots, np.eye(n), 3).derivative()
        basis = pieces(s.ravel())
    else:
        basis = BSpline.design_matrix(s.ravel(), database.knots, 3).toarray()
    return basis.reshape(*s.shape, n) @ table


def _tails(database: HydroDatabase, values, infinite, designs, omega, m: int):
    """Return added mass, damping (N, n, 5) and excitation (N, m, n, 6), with their decay above the data."""
    last = hull_frequency(database.scaled_frequency[-1], designs[:, :1], designs[:, 1:2], database.stretch, database.gravity)
    ratio = np.minimum(1.0, last / np.maximum(omega, 1e-12))[..., None]
    added = infinite[:, None] + (values[..., :5] - infinite[:, None]) * ratio ** TAIL_POWERS[0]
    damping = values[..., 5:10] * ratio ** TAIL_POWERS[1]
    force = (values[..., 10 : 10 + 6 * m] + 1j * values[..., 10 + 6 * m :]) * ratio ** TAIL_POWERS[2]
    return added, damping, np.moveaxis(force.reshape(*force.shape[:2], m, 6), 2, 1)
