"""Ultimate loads: over the states of a lifetime, once in a return period, on a contour, and the worst state of the contour."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fowtio.case import Case
from fowtio.errors import ModelError
from fowtio.site import Site
from fowtio.state_loads import TableLoads, table_loads
from model.design.load_cases import StateTable, crest_states, state_table
from model.environment.contours import level_range, reliability_index
from model.environment.joint import to_physical, to_standard
from model.response.extremes import expected_largest, long_term_extreme, mean_plus_deviation, short_term_fractile

QUIET = lambda text: None  # noqa: E731


@dataclass(frozen=True, eq=False, kw_only=True)
class UltimateLoads:
    """Ultimate loads of channels (c), about the sign of the mean: over the states of a table, with the state that
    governs each.

    objective, expected, fractile (c): mean plus deviation, expected largest and 90 % fractile of a state, the largest
    over the states; governing (c) the state of `expected`; long_term (c) the value once in `return_period` years over
    all states, None without probabilities; contour (c) the expected largest in the contour's states, and its state (c).
    """

    channels: tuple[str, ...]
    units: tuple[str, ...]
    objective: np.ndarray
    expected: np.ndarray
    fractile: np.ndarray
    governing: np.ndarray
    return_period: float
    long_term: np.ndarray
    contour: np.ndarray
    contour_fractile: np.ndarray
    contour_state: np.ndarray
    contour_table: StateTable


def ultimate_loads(
    case: Case, site: Site, loads: TableLoads, return_period: float, progress: Callable[[str], None] = QUIET
) -> UltimateLoads:
    """Return the ultimate loads: over the states of a table, once in a return period, and in the contour's states."""
    table = loads.table
    speeds = np.unique(loads.point_speed[loads.point_speed > 0])
    low, high = _reached(site, return_period)
    speeds = speeds[(speeds > low) & (speeds < high)]
    contour = crest_states(
        site.model,
        site.to_hub,
        speeds,
        return_period,
        state_duration=site.state_duration,
        name=f"contour, {return_period:g} years",
        safety=1.35,
    )
    severe = table_loads(
        case, contour, turbulence=site.turbulence, gamma=site.gamma, model=loads.model, progress=progress
    )
    sign = np.where(_weighted_mean(loads) < 0, -1.0, 1.0)

    def largest(item: TableLoads, fractile: float | None = None):
        duration = item.table.duration
        if fractile is None:
            return expected_largest(sign * item.mean, item.std, item.rate, duration)
        return short_term_fractile(sign * item.mean, item.std, item.rate, duration, fractile)

    expected = largest(loads)
    there = largest(severe)
    long = long_term_extreme(sign * loads.mean, loads.std, loads.rate, table.probability, return_period, table.duration)
    return UltimateLoads(
        channels=loads.channels,
        units=loads.units,
        return_period=return_period,
        objective=sign * mean_plus_deviation(loads.mean, loads.std).max(axis=0),
        expected=sign * expected.max(axis=0),
        fractile=sign * largest(loads, 0.9).max(axis=0),
        governing=expected.argmax(axis=0),
        long_term=sign * long,
        contour=sign * there.max(axis=0),
        contour_fractile=sign * largest(severe, 0.9).max(axis=0),
        contour_state=there.argmax(axis=0),
        contour_table=contour,
    )


def _weighted_mean(loads: TableLoads) -> np.ndarray:
    """Return the mean of each channel (c) in the state where it is largest in size."""
    return np.take_along_axis(loads.mean, np.abs(loads.mean).argmax(axis=0)[None], axis=0)[0]


def _reached(site: Site, return_period: float) -> tuple[float, float]:
    """Return the range of hub wind speeds of the contour."""
    low, high = level_range(site.model, reliability_index(return_period, site.state_duration))
    return low * site.to_hub, high * site.to_hub


@dataclass(frozen=True, eq=False, kw_only=True)
class ResponseSearch:
    """The state (hub wind speed, Hs, Tp) of a contour that makes a channel largest: expected largest value there, and
    per operating point (k) the worst state (k, 3) and value (k).
    """

    channel: str
    unit: str
    state: np.ndarray
    value: float
    by_speed: np.ndarray
    values: np.ndarray


def contour_search(
    case: Case,
    site: Site,
    return_period: float,
    channel: str = "TwrBsMyt",
    *,
    around: int = 24,
    refinements: int = 2,
    progress: Callable[[str], None] = QUIET,
) -> ResponseSearch:
    """Return the state of the contour surface that makes a channel largest, found with the model itself.

    On the isoline of every operating point `around` states are solved, then as many between the best one's neighbours.

    Raises ModelError for a channel that the study does not have, or when no operating point lies on the contour.
    """
    known = case.wind_speeds
    low, high = _reached(site, return_period)
    speeds = [s for s in known if low < s < high and site.cut_in <= s <= site.cut_out]
    if not speeds:
        raise ModelError(
            f"no wind speed of the study's turbine lies on the contour ({low:.3g} to {high:.3g} m/s at hub height)"
        )
    beta = reliability_index(return_period, site.state_duration)
    centre, half = np.zeros(len(speeds)), np.full(len(speeds), np.pi)
    model, best, value = None, np.zeros((len(speeds), 3)), np.full(len(speeds), -np.inf)
    unit = ""
    for round_ in range(1 + refinements):
        angle = centre[:, None] + half[:, None] * np.linspace(-1, 1, around, endpoint=round_ > 0)
        states = np.stack([_on_isoline(site, beta, s, a) for s, a in zip(speeds, angle, strict=True)]).reshape(-1, 3)
        table = _free_table(states, site)
        loads = table_loads(case, table, turbulence=site.turbulence, gamma=site.gamma, model=model, progress=progress)
        model, k = loads.model, loads.index(channel)
        unit = loads.units[k]
        sign = -1.0 if loads.mean[np.abs(loads.mean[:, k]).argmax(), k] < 0 else 1.0
        found = expected_largest(sign * loads.mean[:, k], loads.std[:, k], loads.rate[:, k], table.duration)
        found = found.reshape(len(speeds), around)
        at = found.argmax(axis=1)
        rows = np.arange(len(speeds))
        better = found[rows, at] > value
        value = np.where(better, found[rows, at], value)
        best[better] = states.reshape(len(speeds), around, 3)[rows, at][better]
        centre, half = np.where(better, angle[rows, at], centre), half * 2 / around
    top = int(value.argmax())
    return ResponseSearch(
        channel=channel, unit=unit, state=best[top], value=float(sign * value[top]), by_speed=best, values=sign * value
    )


def _on_isoline(site: Site, beta: float, speed: float, angles) -> np.ndarray:
    """Return states (k, 3) at angles of the isoline of a hub wind speed, the wind at hub height."""
    first = float(to_standard(site.model, np.full(3, speed / site.to_hub))[0])
    radius = np.sqrt(max(beta**2 - first**2, 0.0))
    u = np.stack([np.full(len(angles), first), radius * np.cos(angles), radius * np.sin(angles)], axis=-1)
    states = to_physical(site.model, u)
    states[:, 0] = speed
    return states


def _free_table(states: np.ndarray, site: Site) -> StateTable:
    period = np.clip(states[:, 2], 1.5, None)  # shorter waves than this carry nothing at the heights that go with them
    return state_table("contour", states[:, 0], states[:, 1], period, duration=3600 * site.state_duration)
