"""Load cases: tables of sea and wind states with probabilities, from a joint distribution or as standards ask for them.

A table is what fatigue sums over and what ultimate loads are looked for in. Wind speeds are those at hub height; the
joint distribution may hold them at another height, `to_hub` is the factor between the two.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import ndtr, ndtri

from model.conventions import freeze
from model.environment.contours import HOURS_PER_YEAR, crest, design_points, level_range, reliability_index
from model.environment.joint import JointModel, parameters_at, variable_from_normal, variable_to_normal

TURBULENCE_MODELS = ("NTM", "ETM", "none")
PARKED_TURBULENCE = 0.11  # of the extreme wind model, IEC 61400-1 ed. 3, 6.3.2.1
_NODES = {n: np.polynomial.legendre.leggauss(n) for n in (2, 3, 4, 6)}


@dataclass(frozen=True, eq=False, kw_only=True)
class StateTable:
    """A table of n states.

    Parameters
    ----------
    name : of the table
    wind_speed : (n) at hub height [m/s]
    significant_height, peak_period : (n) [m], [s]
    probability : (n) share of time, adding up to one or less; nothing (zeros) where only the extreme counts
    heading : (n) direction that wind and waves go [rad]
    operating : (n) whether the turbine runs
    turbulence_model : "NTM" (normal), "ETM" (extreme) or "none"
    safety : partial safety factor on loads
    duration : [s] of a state
    """

    name: str
    wind_speed: np.ndarray
    significant_height: np.ndarray
    peak_period: np.ndarray
    probability: np.ndarray
    heading: np.ndarray
    operating: np.ndarray
    turbulence_model: str = "NTM"
    safety: float = 1.0
    duration: float = 3600.0

    def __post_init__(self):
        columns = ("wind_speed", "significant_height", "peak_period", "probability", "heading", "operating")
        freeze(self, **dict.fromkeys(columns, ("n",)))
        if self.turbulence_model not in TURBULENCE_MODELS:
            raise ValueError(
                f"table {self.name}: unknown turbulence model {self.turbulence_model!r}; use one of {', '.join(TURBULENCE_MODELS)}"
            )
        p = self.probability
        if len(p) and (not np.isfinite(p).all() or p.min() < 0 or p.sum() > 1 + 1e-6):
            raise ValueError(
                f"table {self.name}: probabilities add up to {p.sum():.6g} and the smallest is {p.min():.3g}; "
                "they are shares of time, from 0 to 1 together"
            )
        for what, values in (("wind_speed", self.wind_speed), ("significant_height", self.significant_height)):
            if len(values) and not (np.isfinite(values).all() and values.min() >= 0):
                raise ValueError(f"table {self.name}: {what} must be zero or more, not {values.min():g}")
        if len(p) and not (np.isfinite(self.peak_period).all() and self.peak_period.min() > 0):
            raise ValueError(f"table {self.name}: peak_period must be positive, not {self.peak_period.min():g}")

    def __len__(self) -> int:
        return len(self.wind_speed)

    @property
    def hours_per_year(self) -> np.ndarray:
        """Hours per year (n) of each state."""
        return self.probability * HOURS_PER_YEAR


def state_table(
    name: str, wind_speed, significant_height, peak_period, probability=None, *, heading=0.0, operating=True, **more
) -> StateTable:
    """Return a table of states from columns (n) or single values; probability None is zero throughout."""
    columns = np.broadcast_arrays(
        wind_speed, significant_height, peak_period, 0.0 if probability is None else probability, heading, operating
    )
    flat = [np.atleast_1d(np.asarray(c, dtype=float)) for c in columns]
    return StateTable(
        name=name,
        wind_speed=flat[0],
        significant_height=flat[1],
        peak_period=flat[2],
        probability=flat[3],
        heading=flat[4],
        operating=flat[5],
        **more,
    )


def binned_states(
    model: JointModel,
    to_hub: float,
    *,
    wind_edges=None,
    height_edges=None,
    period_edges=None,
    cut_in: float = 4.0,
    cut_out: float = 25.0,
    least: float = 0.0,
    name: str = "DLC 1.2",
) -> StateTable:
    """Return the joint distribution in bins: the states of power production and, parked, those outside it.

    The probability of a bin is integrated over the chain, bin by bin exactly in each distribution function; its state
    is the mean of the states within it.

    Parameters
    ----------
    model : wind speed, Hs given it, Tp given Hs
    to_hub : wind speed at hub height over that of the distribution
    wind_edges, height_edges, period_edges : edges of bins, hub wind speed [m/s], [m], [s]; by default 2 m/s, 1 m, 2 s.
        The outermost bins take what lies beyond them
    cut_in, cut_out : the turbine runs between them; a bin belongs where its mean is
    least : bins less probable than this are left out, and their probability is spread over the others
    name : of the table

    Returns
    -------
    StateTable whose probabilities add up to one
    """
    if len(model.variables) != 3:
        raise ValueError(f"a table needs wind speed, Hs and Tp; the distribution has {', '.join(model.names)}")
    wind_edges = np.append(np.arange(0.0, 31.0, 2.0), cut_out) if wind_edges is None else wind_edges
    wind_edges = np.unique(np.asarray(wind_edges, dtype=float))
    height_edges = np.arange(0.0, 15.0, 1.0) if height_edges is None else np.asarray(height_edges, dtype=float)
    period_edges = np.arange(0.0, 22.0, 2.0) if period_edges is None else np.asarray(period_edges, dtype=float)
    wind, height, period = model.variables
    u, pu = _split(wind, None, wind_edges / to_hub, 6)
    h, ph = _split(height, u, height_edges, 4)
    t, pt = _split(period, h, period_edges, 2)
    weight = pu[:, None, None] * ph[:, :, None] * pt
    grids = [np.broadcast_to(a, weight.shape) for a in (u[:, None, None] * to_hub, h[:, :, None], t)]
    shape = (len(wind_edges) - 1, 6, len(height_edges) - 1, 4, len(period_edges) - 1, 2)

    def over_bins(values):
        return values.reshape(shape).sum(axis=(1, 3, 5)).ravel()

    p = over_bins(weight)
    keep = p > max(least, 1e-300)
    means = [over_bins(weight * g)[keep] / p[keep] for g in grids]
    return state_table(name, *means, p[keep] / p[keep].sum(), operating=(means[0] >= cut_in) & (means[0] <= cut_out))


def _split(variable, given, edges, nodes: int):
    """Return values (..., bins * nodes) inside bins and their probabilities, given values (...) of another variable.

    Gauss's points in the distribution function, so that the probabilities of a bin's points add up to the bin's.
    """
    point, weight = _NODES[nodes]
    inner = np.asarray(edges, dtype=float)[1:-1]
    at = None if given is None else np.asarray(given)[..., None]
    z = variable_to_normal(variable, inner, at)
    ends = np.full((*z.shape[:-1], 1), np.inf)
    z = np.concatenate([-ends, z, ends], axis=-1)
    low, high = ndtr(z[..., :-1]), ndtr(z[..., 1:])
    sf_low, sf_high = ndtr(-z[..., :-1]), ndtr(-z[..., 1:])
    size = np.where(z[..., :-1] > 0, sf_low - sf_high, high - low)
    share = (point + 1) / 2
    below = low[..., None] + size[..., None] * share
    above = sf_high[..., None] + size[..., None] * (1 - share)
    with np.errstate(divide="ignore"):
        u = np.where(z[..., :-1, None] > 0, -ndtri(above), ndtri(below))
    u = np.clip(u, -8.0, 8.0).reshape(*size.shape[:-1], -1)
    p = (size[..., None] * weight / 2).reshape(*size.shape[:-1], -1)
    return variable_from_normal(variable, u, at), p


def crest_states(
    model: JointModel,
    to_hub: float,
    speeds: Sequence[float],
    return_period: float,
    *,
    state_duration: float = 1.0,
    kind: str = "max_hs",
    **more,
) -> StateTable:
    """Return the states of a contour with the largest height (or period) at hub wind speeds: thesis Tables 26 and 28.

    return_period [years]; state_duration [h]; more goes to `state_table` (name, turbulence_model, safety, ...).
    """
    beta = reliability_index(return_period, state_duration)
    points = np.array([crest(model, beta, speed / to_hub, kind) for speed in speeds])
    more.setdefault("name", f"contour of {return_period:g} years")
    return state_table(more.pop("name"), speeds, points[:, 1], points[:, 2], duration=3600 * state_duration, **more)


def expected_sea(model: JointModel, to_hub: float, speeds) -> tuple[np.ndarray, np.ndarray]:
    """Return the expected Hs (n) given hub wind speeds (n), and the median Tp (n) there."""
    speeds = np.asarray(speeds, dtype=float)
    _, height, period = model.variables
    share = (np.arange(400) + 0.5) / 400
    h = variable_from_normal(height, ndtri(share), speeds[:, None] / to_hub).mean(axis=-1)
    return h, variable_from_normal(period, 0.0, h)


def dlc_1_3(model: JointModel, to_hub: float, speeds: Sequence[float]) -> StateTable:
    """Return DLC 1.3 of IEC 61400-3: extreme turbulence with the expected sea at each wind speed; safety factor
    1.35.
    """
    h, t = expected_sea(model, to_hub, speeds)
    return state_table("DLC 1.3", speeds, h, t, turbulence_model="ETM", safety=1.35)


def dlc_1_6(
    model: JointModel,
    to_hub: float,
    speeds: Sequence[float],
    *,
    return_period: float = 50.0,
    state_duration: float = 1.0,
) -> StateTable:
    """Return DLC 1.6 of IEC 61400-3: normal turbulence with the severe sea, that of the contour at each wind speed."""
    return crest_states(
        model, to_hub, speeds, return_period, state_duration=state_duration, name="DLC 1.6", safety=1.35
    )


def dlc_6_1(
    model: JointModel, to_hub: float, *, return_period: float = 50.0, state_duration: float = 1.0
) -> StateTable:
    """Return DLC 6.1 of IEC 61400-3: parked, the extreme wind speed together with the sea of the largest Hs of the
    contour.
    """
    beta = reliability_index(return_period, state_duration)
    speed = level_range(model, beta)[1] * to_hub
    sea = design_points(model, beta)[0].state
    return state_table("DLC 6.1", speed, sea[1], sea[2], operating=False, safety=1.35, duration=3600 * state_duration)


def with_probability(table: StateTable, probability) -> StateTable:
    """Return a table with other probabilities (n)."""
    return replace(table, probability=np.broadcast_to(np.asarray(probability, dtype=float), table.wind_speed.shape))


def wind_probabilities(model: JointModel, to_hub: float, speeds: Sequence[float]) -> np.ndarray:
    """Return how often (n) the hub wind speed is nearest to each of rising speeds (n), the outer ones taking half a
    step more.
    """
    speeds = np.asarray(speeds, dtype=float)
    middle = (speeds[1:] + speeds[:-1]) / 2
    edges = np.concatenate([[2 * speeds[0] - middle[0]], middle, [2 * speeds[-1] - middle[-1]]])
    return np.diff(ndtr(variable_to_normal(model.variables[0], np.maximum(edges, 0.0) / to_hub)))


__all__ = [
    "StateTable",
    "binned_states",
    "crest_states",
    "dlc_1_3",
    "dlc_1_6",
    "dlc_6_1",
    "expected_sea",
    "parameters_at",
    "state_table",
    "wind_probabilities",
    "with_probability",
]
