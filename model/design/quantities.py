"""Quantities of designs by name, for objectives, constraints and tables: what they are, in what unit, and what they take."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from model.design.evaluate import CHANNELS, Batch, lifetime_damages, relative_elevation, total_costs
from model.design.population import straight_distance
from model.response.extremes import expected_largest, mean_plus_deviation, upcrossing_rate
from model.response.fatigue import stress_moments
from model.response.peaks import resonance_peak

REST, MEAN, RESPONSE, LIFE = range(4)
_DEGREE = np.pi / 180


@dataclass(frozen=True, kw_only=True)
class Quantity:
    """A quantity: what it is, the unit that people see and the factor from SI to it, level of effort, and whether it needs a state.

    value(batch, state) gives it for every design (N) in SI.
    """

    text: str
    unit: str
    factor: float
    level: int
    value: Callable[[Batch, str], np.ndarray]

    @property
    def of_state(self) -> bool:
        """Whether the name needs a state behind a colon."""
        return self.level in (MEAN, RESPONSE)


def _rest(text, unit, value, factor=1.0):
    return Quantity(text=text, unit=unit, factor=factor, level=REST, value=lambda batch, _: value(batch))


def _mean(text, unit, value, factor=1.0):
    return Quantity(text=text, unit=unit, factor=factor, level=MEAN, value=value)


def _response(text, unit, value, factor=1.0):
    return Quantity(text=text, unit=unit, factor=factor, level=RESPONSE, value=value)


def _offset(dof: str):
    return lambda batch, state: batch.mean(state).offset[:, ("surge", "sway", "heave", "roll", "pitch", "yaw").index(dof)]


def _std(channel: str):
    return lambda batch, state: np.sqrt(_moments(batch, state, channel)[:, 0])


def _moments(batch: Batch, state: str, channel: str) -> np.ndarray:
    return stress_moments(batch.result(state).spectra[:, CHANNELS.index(channel)], batch.setting.omega)


def _channel_mean(channel: str):
    return lambda batch, state: batch.result(state).mean[:, CHANNELS.index(channel)]


def _deviation(channel: str):
    return lambda batch, state: mean_plus_deviation(_channel_mean(channel)(batch, state), _std(channel)(batch, state))


def _largest(channel: str):
    def value(batch, state):
        m = _moments(batch, state, channel)
        level = np.abs(_channel_mean(channel)(batch, state))
        return expected_largest(level, np.sqrt(m[:, 0]), upcrossing_rate(m[:, 0], m[:, 2]), batch.setting.duration)

    return value


def _peak(channel: str, place: int):
    def value(batch, state):
        magnitude = np.abs(batch.result(state).transfer[:, CHANNELS.index(channel), 0])
        return resonance_peak(batch.setting.omega, magnitude, 2 * np.pi / batch.periods(state)[:, place])[0]

    return value


def _air_gap(batch: Batch, state: str) -> np.ndarray:
    mean, spectra = relative_elevation(batch, state)
    m = stress_moments(spectra, batch.setting.omega)
    largest = expected_largest(mean, np.sqrt(m[..., 0]), upcrossing_rate(m[..., 0], m[..., 2]), batch.setting.duration)
    return batch.hull.column_freeboard - largest.max(axis=1)


def _life(batch: Batch, _) -> np.ndarray:
    return lifetime_damages(batch, [s.name for s in batch.setting.states if s.share > 0])


def _uplift(state) -> np.ndarray:
    return (state.anchor_vertical / np.maximum(state.anchor_horizontal, 1.0)).max(axis=1)


def _lying(state) -> np.ndarray:
    return state.grounded_length.min(axis=1)


QUANTITIES = {
    "platform_mass": _rest("mass of the platform with ballast", "t", lambda b: b.population.floating.mass, 1e-3),
    "total_mass": _rest("mass of platform and lines", "t", lambda b: b.platform_mass, 1e-3),
    "steel_mass": _rest("mass of the platform's steel", "t", lambda b: b.population.floating.steel_mass, 1e-3),
    "ballast_mass": _rest("mass of the ballast", "t", lambda b: b.population.floating.ballast_mass, 1e-3),
    "metacentric_height": _rest("metacentric height of platform and turbine", "m", lambda b: b.population.floating.metacentric_height),
    "centre_of_mass": _rest("height of the platform's centre of mass", "m", lambda b: b.population.floating.centre_of_mass),
    "line_slack": _rest("line length over the straight distance from fairlead to anchor", "-",
                        lambda b: b.population.length / straight_distance(b.hull, b.population.anchor_radius, b.population.depth)),
    "rest_grounded_share": _rest("part of a line that lies on the seabed at rest", "-", lambda b: _lying(b.population.at_rest) / b.population.length),
    "mooring_stiffness": _rest("surge stiffness of the moorings at rest", "kN/m", lambda b: b.population.at_rest.stiffness[:, 0, 0], 1e-3),
    "mean_surge": _mean("mean surge", "m", _offset("surge")),
    "mean_heave": _mean("mean heave", "m", _offset("heave")),
    "mean_pitch": _mean("mean pitch", "deg", lambda b, s: np.abs(_offset("pitch")(b, s)), 1 / _DEGREE),
    "offset_ratio": _mean("mean surge over water depth", "-", lambda b, s: np.abs(_offset("surge")(b, s)) / b.population.depth),
    "grounded_share": _mean("part of the tightest line that lies on the seabed", "-", lambda b, s: _lying(b.mean(s).mooring) / b.population.length),
    "anchor_uplift": _mean("vertical over horizontal load of the worst anchor", "-",
                           lambda b, s: _uplift(b.mean(s).mooring)),
    "mean_tension": _mean("mean tension of the most loaded fairlead", "kN", lambda b, s: b.mean(s).mooring.fairlead_tension.max(axis=1), 1e-3),
    "anchor_tension": _mean("mean tension of the most loaded anchor", "kN", lambda b, s: b.mean(s).mooring.anchor_tension.max(axis=1), 1e-3),
    "surge_period": _mean("natural period of surge", "s", lambda b, s: b.periods(s)[:, 0]),
    "heave_period": _mean("natural period of heave", "s", lambda b, s: b.periods(s)[:, 1]),
    "pitch_period": _mean("natural period of pitch", "s", lambda b, s: b.periods(s)[:, 2]),
    "cost": Quantity(text="cost of hull, ballast, lines and anchors", unit="MEUR", factor=1e-6, level=MEAN, value=lambda b, _: total_costs(b)),
    "surge_peak": _response("surge RAO at its eigenfrequency", "m/m", _peak("surge", 0)),
    "heave_peak": _response("heave RAO at its eigenfrequency", "m/m", _peak("heave", 1)),
    "pitch_peak": _response("pitch RAO at its eigenfrequency", "deg/m", _peak("pitch", 2), 1 / _DEGREE),
    "surge_std": _response("standard deviation of surge", "m", _std("surge")),
    "heave_std": _response("standard deviation of heave", "m", _std("heave")),
    "pitch_std": _response("standard deviation of pitch", "deg", _std("pitch"), 1 / _DEGREE),
    "tower_moment": _response("mean plus standard deviation of the fore-aft tower-base moment", "MN m", _deviation("tower_moment"), 1e-6),
    "tower_moment_mean": _response("mean fore-aft tower-base moment", "MN m", _channel_mean("tower_moment"), 1e-6),
    "tower_moment_std": _response("standard deviation of the fore-aft tower-base moment", "MN m", _std("tower_moment"), 1e-6),
    "extreme_tower_moment": _response("expected largest fore-aft tower-base moment", "MN m", _largest("tower_moment"), 1e-6),
    "nacelle_acceleration_std": _response("standard deviation of the nacelle's acceleration", "m/s2", _std("nacelle_acceleration")),
    "tension_std": _response("standard deviation of the most loaded fairlead's tension", "kN", _std("tension"), 1e-3),
    "extreme_tension": _response("expected largest tension of the most loaded fairlead", "kN", _largest("tension"), 1e-3),
    "air_gap": _response("column freeboard less the expected largest relative wave elevation", "m", _air_gap),
    "damage": Quantity(text="fatigue damage of the tower base over the life", unit="-", factor=1.0, level=LIFE, value=_life),
}  # fmt: skip
"""Every quantity that a study may name. `name:state` for those of a state."""


def split_name(text: str) -> tuple[str, str]:
    """Return the quantity and state of "quantity:state", the state "" without one."""
    name, _, state = text.partition(":")
    return name.strip(), state.strip()


def check_name(text: str, states: Sequence[str]) -> str | None:
    """Return what is wrong with a quantity's name in a study with these states, None when nothing is."""
    name, state = split_name(text)
    if name not in QUANTITIES:
        near = difflib.get_close_matches(name, QUANTITIES, n=1)
        return f"unknown quantity {name!r}" + (f"; did you mean {near[0]}?" if near else f"; there are {', '.join(QUANTITIES)}")
    if QUANTITIES[name].of_state and name != "cost":
        if state not in states:
            return f"{name} needs a state behind a colon, as {name}:{states[0] if states else 'STATE'}; there are {', '.join(states)}"
    elif state:
        return f"{name} takes no state, found {text!r}"
    return None


def level_of(text: str) -> int:
    """Return the level of effort of a quantity."""
    return QUANTITIES[split_name(text)[0]].level


def quantity_value(batch: Batch, text: str) -> np.ndarray:
    """Return a quantity (N) of a batch in the unit that people see."""
    name, state = split_name(text)
    found = QUANTITIES[name]
    return np.broadcast_to(found.factor * np.asarray(found.value(batch, state), dtype=float), (len(batch),))


@dataclass(frozen=True, kw_only=True)
class Constraint:
    """A bound on a quantity: its name, "<=" or ">=", the limit in the unit that people see."""

    quantity: str
    relation: str
    limit: float

    def excess(self, value) -> np.ndarray:
        """Return by how much values (N) break the bound over the limit's size, 0 where they keep it."""
        over = np.asarray(value) - self.limit if self.relation == "<=" else self.limit - np.asarray(value)
        return np.maximum(over, 0.0) / max(abs(self.limit), 1e-3)

    def reason(self, value: float) -> str:
        """Return why a value breaks the bound."""
        unit = QUANTITIES[split_name(self.quantity)[0]].unit
        return f"{self.quantity} {value:.4g} is not {self.relation} {self.limit:.4g} {unit}"


@dataclass(frozen=True, eq=False, kw_only=True)
class Evaluation:
    """What was found of N designs: names (k) of quantities and their values (N, k), NaN where a design did not get so far; violation
    (N), 0 for feasible designs, larger the earlier and the further a design fails; reason (N), empty for feasible ones.
    """

    names: tuple[str, ...]
    values: np.ndarray
    violation: np.ndarray
    reason: tuple[str, ...]


def evaluate(make: Callable[[np.ndarray], Batch], designs: np.ndarray, reach: np.ndarray, wanted: Sequence[str], constraints: Sequence[Constraint]) -> Evaluation:
    """Return quantities and feasibility of designs (N, v): level by level, and only those still feasible go on to the next.

    make turns designs into a batch; reach (N) is how far the line falls short of its straight distance over that, 0 when it reaches;
    wanted are quantities beside those of the constraints.
    """
    names = tuple(dict.fromkeys([*(c.quantity for c in constraints), *wanted]))
    values = np.full((len(designs), len(names)), np.nan)
    violation, reason = 1e5 * (reach > 0) * (1 + reach), np.array([""] * len(designs), dtype=object)
    reason[reach > 0] = "the line is shorter than the straight distance from fairlead to anchor"
    alive = np.flatnonzero(reach <= 0)
    batch = make(designs[alive]) if len(alive) else None
    if batch is not None:
        alive, batch = _afloat(batch, alive, violation, reason)
    for level in range(LIFE + 1):
        here = [k for k, n in enumerate(names) if level_of(n) == level]
        if not here or not len(alive):
            continue
        if level == MEAN:
            alive, batch = _held(batch, alive, _states_of(names), violation, reason)
            if not len(alive):
                break
        for k in here:
            values[alive, k] = quantity_value(batch, names[k])
        broken = np.zeros(len(alive))
        for c in (c for c in constraints if level_of(c.quantity) == level):
            found = values[alive, names.index(c.quantity)]
            excess = np.where(np.isfinite(found), c.excess(found), 1.0)
            for j in np.flatnonzero((excess > 0) & (broken == 0)):
                reason[alive[j]] = c.reason(found[j])
            broken += excess
        violation[alive] += np.where(broken > 0, 10.0 ** (LIFE - level) * (1 + broken), 0.0)
        keep = broken == 0
        if not keep.all():
            alive = alive[keep]
            batch = batch.some(keep) if len(alive) else batch
    return Evaluation(names=names, values=values, violation=violation, reason=tuple(reason))


def _states_of(names: Sequence[str]) -> list[str]:
    """Return the states that quantities at a mean offset need, the cost's among them."""
    found = [split_name(n) for n in names if level_of(n) == MEAN]
    return sorted({state for _, state in found if state})


def _held(batch: Batch, alive, states, violation, reason):
    """Return what remains when the designs whose moorings cannot hold the mean force of a state are put aside."""
    bad = np.zeros(len(batch), dtype=bool)
    for state in states:
        bad |= ~batch.mean(state).converged
    for j in np.flatnonzero(bad):
        reason[alive[j]] = "the moorings cannot hold the mean force of a state"
    violation[alive[bad]] += 500.0
    if bad.any():
        alive = alive[~bad]
        batch = batch.some(~bad) if len(alive) else batch
    return alive, batch


def _afloat(batch: Batch, alive, violation, reason):
    """Return what remains when the designs that cannot float are put aside with the reason."""
    floating = batch.population.floating
    bad = ~np.broadcast_to(floating.possible, (len(batch),))
    for mask, text in floating.problems:
        for j in np.flatnonzero(np.broadcast_to(mask, bad.shape) & (reason[alive] == "")):
            reason[alive[j]] = str(text[j]).split(";")[0]
    violation[alive[bad]] += 5e4
    if bad.any():
        alive = alive[~bad]
        batch = batch.some(~bad) if len(alive) else batch
    return alive, batch
