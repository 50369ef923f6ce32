"""Environmental contours: states that are exceeded, in the sense of each method, once in a return period.

IFORM (Winterstein et al. 1993): the sphere of radius beta in the space of independent standard normal variables,
brought back to states. A half-space that touches it has the probability Phi(-beta), one state in the return period; the
outside of the whole sphere has more. Highest-density contours (Haselsteiner et al. 2017) enclose all but that
probability; contours by direct sampling (Huseby et al. 2013) have it beyond every tangent, from a sample alone.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial import HalfspaceIntersection
from scipy.special import chdtrc, log_ndtr, ndtri

from model.conventions import freeze
from model.environment.joint import WIND, JointModel, density, to_physical, to_standard

HOURS_PER_YEAR = 365.25 * 24
GOLDEN = np.pi * (3 - np.sqrt(5))


@dataclass(frozen=True, eq=False, kw_only=True)
class DesignPoint:
    """A state that a contour singles out: kind says why, state (d) in the order of the variables."""

    kind: str
    state: np.ndarray

    def __post_init__(self):
        freeze(self, state=(None,))


def reliability_index(return_period: float, state_duration: float = 1.0) -> float:
    """Return beta, the radius of the contour.

    return_period [years], state_duration [hours]; Phi^-1(1 - 1/n) of n states in the return period (thesis eq. 7.2).
    Raises ValueError when the return period is no longer than two states.
    """
    states = return_period * HOURS_PER_YEAR / state_duration if state_duration > 0 else 0.0
    if not states > 2:
        raise ValueError(
            f"a return period of {return_period:g} years and states of {state_duration:g} h make no rare state; give more than two states"
        )
    return float(-ndtri(1 / states))


def exceedance_probability(beta: float) -> float:
    """Return the probability of the half-space beyond a contour of radius beta, per state."""
    return float(np.exp(log_ndtr(-beta)))


def outside_probability(beta: float, variables: int) -> float:
    """Return the probability of the whole outside of an IFORM contour, per state: that of chi-squared beyond beta
    squared.
    """
    return float(chdtrc(variables, beta**2))


def unit_directions(variables: int, count: int) -> np.ndarray:
    """Return `count` directions (count, variables), evenly spread: round a circle (closed), or over a sphere.

    Three variables take the Fibonacci lattice. Raises ValueError for another number of variables.
    """
    if variables == 2:
        angle = np.linspace(0, 2 * np.pi, count)
        return np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    if variables != 3:
        raise ValueError(f"contours have two or three variables, not {variables}")
    k = np.arange(count)
    height = 1 - (2 * k + 1) / count
    ring = np.sqrt(1 - height**2)
    return np.stack([height, ring * np.cos(GOLDEN * k), ring * np.sin(GOLDEN * k)], axis=-1)


def iform_contour(model: JointModel, beta: float, count: int = 2000) -> np.ndarray:
    """Return `count` states (count, d) of the IFORM contour: a closed line of two variables, scattered over the surface
    of three.
    """
    return to_physical(model, beta * unit_directions(len(model.variables), count))


def iform_surface(model: JointModel, beta: float, levels: int = 61, around: int = 73) -> np.ndarray:
    """Return the IFORM surface of three variables as a grid (levels, around, 3): isolines of the first variable,
    closed.
    """
    polar = np.linspace(0, np.pi, levels)[:, None]
    angle = np.linspace(0, 2 * np.pi, around)
    u = np.stack(
        np.broadcast_arrays(-np.cos(polar), np.sin(polar) * np.cos(angle), np.sin(polar) * np.sin(angle)), axis=-1
    )
    return to_physical(model, beta * u)


def isoline(model: JointModel, beta: float, value: float, count: int = 181) -> np.ndarray:
    """Return the states (count, 3) of the IFORM surface at one value of the first variable, a closed line.

    Raises ValueError when the contour does not reach the value.
    """
    first, radius = _circle(model, beta, value)
    circle = radius * unit_directions(2, count)
    return to_physical(model, np.concatenate([np.full((count, 1), first), circle], axis=-1))


def crest(model: JointModel, beta: float, value: float, kind: str = "max_hs") -> np.ndarray:
    """Return the state (3) with the largest second ("max_hs") or third variable ("max_tp", "min_tp") on an isoline.

    The largest second variable stands at the median of the third, since it does not depend on it.
    """
    first, radius = _circle(model, beta, value)
    if kind == "max_hs":
        return to_physical(model, np.array([first, radius, 0.0]))
    sign = {"max_tp": 1.0, "min_tp": -1.0}
    if kind not in sign:
        raise ValueError(f"unknown kind of design point {kind!r}; use max_hs, max_tp or min_tp")
    angle = _maximise_on_circle(
        lambda u: sign[kind] * to_physical(model, np.insert(u, 0, first, axis=-1))[..., 2], radius
    )
    return to_physical(model, np.array([first, radius * np.cos(angle), radius * np.sin(angle)]))


def level_range(model: JointModel, beta: float) -> tuple[float, float]:
    """Return the lowest and highest value of the first variable on the contour."""
    u = np.zeros((2, len(model.variables)))
    u[:, 0] = -beta, beta
    low, high = to_physical(model, u)[:, 0]
    return float(low), float(high)


def design_points(model: JointModel, beta: float, value: float | None = None) -> tuple[DesignPoint, ...]:
    """Return the states of largest height and of largest and smallest period: of the whole contour, or of one
    isoline.
    """
    kinds = ("max_hs", "max_tp", "min_tp")
    if value is not None:
        return tuple(DesignPoint(kind=k, state=crest(model, beta, value, k)) for k in kinds)
    out = []
    for kind, sign, k in (("max_hs", 1, -2), ("max_tp", 1, -1), ("min_tp", -1, -1)):
        found = worst_state(model, beta, lambda x, sign=sign, k=k: sign * x[..., k])
        out.append(DesignPoint(kind=kind, state=found.state))
    return tuple(out)


@dataclass(frozen=True, eq=False, kw_only=True)
class WorstState:
    """The state (d) of a contour with the largest response, the response there, and how many states were tried."""

    state: np.ndarray
    response: float
    evaluations: int


def worst_state(
    model: JointModel,
    beta: float,
    response: Callable[[np.ndarray], np.ndarray],
    *,
    count: int = 400,
    refinements: int = 14,
    batch: int = 24,
) -> WorstState:
    """Return the state of the IFORM contour with the largest response: inverse FORM with the model itself.

    Parameters
    ----------
    model, beta : joint distribution and radius of the contour
    response : takes states (k, d), returns responses (k), not-a-number where it has none (wind beyond cut-out, say)
    count : states of the first round, spread over the contour
    refinements, batch : further rounds of `batch` states in a cap about the best, halved each time

    Returns
    -------
    WorstState

    Raises
    ------
    ValueError : no state of the first round has a response.
    """
    at = unit_directions(len(model.variables), count)
    found = np.asarray(response(to_physical(model, beta * at)), dtype=float)
    if not np.isfinite(found).any():
        raise ValueError("no state of the contour has a response; widen the range of wind speeds that the model covers")
    best = int(np.nanargmax(found))
    centre, value, tried = at[best], found[best], count
    size = 2.5 * np.sqrt(4 * np.pi / count) if at.shape[1] == 3 else 2.5 * 2 * np.pi / count
    for _ in range(refinements):
        near = _cap(centre, size, batch)
        got = np.asarray(response(to_physical(model, beta * near)), dtype=float)
        tried += len(near)
        if np.isfinite(got).any() and np.nanmax(got) > value:
            best = int(np.nanargmax(got))
            centre, value = near[best], got[best]
        size *= 0.6
    return WorstState(state=to_physical(model, beta * centre), response=float(value), evaluations=tried)


def highest_density_level(model: JointModel, probability: float, points: int = 121) -> float:
    """Return the density below which states have this probability in all.

    The density is evaluated on a grid of the standard normal variables (points each way, out to 8) and ranked, so that
    the tail is integrated, not sampled.
    """
    d = len(model.variables)
    axis = np.linspace(-8, 8, points)
    weight = np.exp(-0.5 * axis**2)
    weight /= weight.sum()
    grid = np.stack(np.meshgrid(*[axis] * d, indexing="ij"), axis=-1)
    values = density(model, to_physical(model, grid)).ravel()
    share = weight
    for _ in range(d - 1):
        share = np.multiply.outer(share, weight)
    order = np.argsort(values)
    below = np.cumsum(share.ravel()[order])
    values = values[order]
    positive = values > 0
    return float(np.exp(np.interp(np.log(probability), np.log(below[positive]), np.log(values[positive]))))


def highest_density_contour(model: JointModel, probability: float, count: int = 181) -> np.ndarray:
    """Return the states (count, 2) of the highest-density contour of two variables that leaves `probability` outside.

    Along rays from the mode in the space of standard normal variables the density falls to its level once.
    """
    level = np.log(highest_density_level(model, probability, 401))
    direction = unit_directions(2, count)

    def log_density(radius):
        with np.errstate(divide="ignore"):
            return np.log(density(model, to_physical(model, centre + radius[:, None] * direction)))

    axis = np.linspace(-4, 4, 161)
    grid = np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1)
    centre = grid.reshape(-1, 2)[np.argmax(density(model, to_physical(model, grid)))]
    low, high = np.zeros(count), np.full(count, 12.0)
    for _ in range(50):
        middle = (low + high) / 2
        inside = log_density(middle) > level
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    return to_physical(model, centre + low[:, None] * direction)


def direct_sampling_contour(states, probability: float, count: int = 181, total: int | None = None) -> np.ndarray:
    """Return the contour (k, 2) of two variables from a sample: the polygon of `count` tangents that leave `probability`
    beyond each, a closed line.

    states (n, 2), a sample of the joint distribution or the record itself; of a sample of `total` states those that can
    lie beyond a tangent are enough. Raises ValueError for fewer than ten states beyond. Source: Huseby, Vanem and Natvig
    (2013), Ocean Eng. 60:124.
    """
    states = np.asarray(states, dtype=float)
    total = len(states) if total is None else total
    if total * probability < 10:
        raise ValueError(
            f"{total} states are too few for a probability of {probability:.3g}; sample {10 / probability:.0f} or more"
        )
    mean, std = states.mean(axis=0), states.std(axis=0)
    scaled = (states - mean) / std
    angle = np.linspace(0, 2 * np.pi, count)
    rank = len(states) - max(int(np.floor(total * probability)), 1)
    cos, sin = np.cos(angle), np.sin(angle)
    along = (scaled[:, 0] * c + scaled[:, 1] * s for c, s in zip(cos[:-1], sin[:-1], strict=True))
    tangent = np.array([np.partition(a, rank)[rank] for a in along])
    planes = np.stack([cos[:-1], sin[:-1], -tangent], axis=-1)
    corner = HalfspaceIntersection(planes, np.zeros(2)).intersections
    corner = corner[np.argsort(np.arctan2(corner[:, 1], corner[:, 0]))]
    return mean + std * np.vstack([corner, corner[:1]])


def sampled_contour(model: JointModel, probability: float, rng: np.random.Generator, count: int = 91) -> np.ndarray:
    """Return the contour by direct sampling (k, 2) of a joint distribution of two variables, a closed line.

    Draws fifty states beyond each tangent, at most twenty million in all; those near the middle (within 2 of the
    standard normal variables) are thrown away at once, since no rare half-plane holds them. Raises ValueError for a
    probability above 0.01 or too small for that many draws.
    """
    if not 0 < probability <= 0.01:
        raise ValueError(f"a probability of {probability:g} per state is not rare; give 0.01 or less")
    total, kept, done = min(int(50 / probability), 20_000_000), [], 0
    while done < total:
        u = rng.standard_normal((min(1_000_000, total - done), 2))
        done += len(u)
        kept.append(to_physical(model, u[(u**2).sum(axis=1) > 4.0]))
    return direct_sampling_contour(np.concatenate(kept), probability, count, total)


def outside_fraction(model: JointModel, beta: float, states) -> tuple[float, float]:
    """Return the fraction of states (n, d) outside the IFORM contour, and that beyond its largest first variable."""
    u = to_standard(model, states)
    return float(np.mean((u**2).sum(axis=-1) > beta**2)), float(np.mean(u[..., 0] > beta))


def wind_factor(height: float, hub_height: float, exponent: float) -> float:
    """Return the ratio of the wind speed at a height [m] to that at hub height [m] in a power law."""
    if not (height > 0 and hub_height > 0):
        raise ValueError(f"heights are {height:g} and {hub_height:g} m; both must be positive")
    return (height / hub_height) ** exponent


def _circle(model: JointModel, beta: float, value: float) -> tuple[float, float]:
    """Return the first standard normal variable of an isoline and the radius left for the others."""
    if len(model.variables) != 3:
        raise ValueError(f"an isoline needs three variables; the joint distribution has {', '.join(model.names)}")
    state = np.full(3, value, dtype=float)
    first = float(to_standard(model, state)[0])
    if not abs(first) <= beta:
        low, high = level_range(model, beta)
        what = "wind speed" if model.names[0] == WIND else model.names[0]
        raise ValueError(
            f"the contour does not reach a {what} of {value:g}: it goes from {low:.4g} to {high:.4g} (at the height of the fit)"
        )
    return first, float(np.sqrt(beta**2 - first**2))


def _maximise_on_circle(function: Callable[[np.ndarray], np.ndarray], radius: float) -> float:
    """Return the angle of the largest value of a smooth function of points (k, 2) of a circle."""
    centre, half = 0.0, np.pi
    for _ in range(12):
        angle = centre + half * np.linspace(-1, 1, 65)
        values = function(radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1))
        centre, half = float(angle[np.argmax(values)]), half / 16
    return centre


def _cap(centre: np.ndarray, size: float, count: int) -> np.ndarray:
    """Return unit vectors (count, d) within an angle `size` of a direction, evenly spread."""
    d = len(centre)
    if d == 2:
        angle = np.arctan2(centre[1], centre[0]) + size * np.linspace(-1, 1, count)
        return np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    k = np.arange(count)
    tilt, turn = size * np.sqrt((k + 0.5) / count), GOLDEN * k
    other = np.eye(3)[np.argmin(np.abs(centre))]
    a = np.cross(centre, other)
    a /= np.linalg.norm(a)
    b = np.cross(centre, a)
    return np.cos(tilt)[:, None] * centre + np.sin(tilt)[:, None] * (
        np.cos(turn)[:, None] * a + np.sin(turn)[:, None] * b
    )
