"""Loads of a whole table of states: operating points at whole wind speeds, all states of each solved at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from fowtio.case import Case
from fowtio.errors import ModelError
from fowtio.workflow import Model, OperatingPoint, build
from model.design.load_cases import StateTable
from model.environment.rotor_wind import rotor_spectra
from model.environment.sea import SeaState, wave_spectrum
from model.environment.wind import WindState, inflow_spectrum, turbulence_sigma
from model.response.batch import BatchResponse, solve_many
from model.response.extremes import upcrossing_rate
from model.response.lifetime import channel_moments, combined_spectra, load_moments
from model.response.solve import prepare
from model.system.hydro import headings_cover

TOWER = ("TwrBsMxt", "TwrBsMyt")
SPEED_STEP = 1.0  # m/s between operating points
_PART = 256  # states solved at once: bounds the memory


@dataclass(frozen=True, eq=False, kw_only=True)
class Group:
    """States that share an operating point, a wind and a heading: point, indices (k) into the table, the wind (None:
    calm).
    """

    point: OperatingPoint
    states: np.ndarray
    wind: WindState | None
    heading: float


@dataclass(frozen=True, eq=False, kw_only=True)
class TableLoads:
    """Loads of the s states of a table.

    model; table; groups; channels (c) with units, mean (s, c), moments (s, c, 4) in Hz; tower (s, 4, 2, 2), the
    cross-spectral moments of the tower-base moments about x and y; point_speed (s), the wind speed [m/s] of each
    state's operating point; notes on what was assumed.
    """

    model: Model
    table: StateTable
    gamma: float | None
    groups: tuple[Group, ...]
    channels: tuple[str, ...]
    units: tuple[str, ...]
    mean: np.ndarray
    moments: np.ndarray
    tower: np.ndarray
    point_speed: np.ndarray
    notes: tuple[str, ...]

    @property
    def std(self) -> np.ndarray:
        """Standard deviations (s, c)."""
        return np.sqrt(np.maximum(self.moments[..., 0], 0.0))

    @property
    def rate(self) -> np.ndarray:
        """Rates of upcrossings of the mean (s, c) [1/s]."""
        return upcrossing_rate(self.moments[..., 0], self.moments[..., 2])

    def index(self, channel: str) -> int:
        """Return the place of a channel; raise ModelError with the known names."""
        if channel not in self.channels:
            raise ModelError(f"no channel {channel}; there are {', '.join(self.channels)}")
        return self.channels.index(channel)


def table_loads(
    case: Case,
    table: StateTable,
    *,
    turbulence: str | float = "B",
    gamma: float | None = None,
    model: Model | None = None,
    progress: Callable[[str], None] = lambda text: None,
) -> TableLoads:
    """Return the loads of a study's turbine in all states of a table.

    The model is linearised at whole wind speeds. Winds slower or faster than the study's linearisations take the
    nearest one with their own turbulence, the slower ones with smaller gusts in proportion. Parked states have waves
    only.

    Parameters
    ----------
    case : study
    table : states
    turbulence : class of IEC 61400-1 or intensity as a fraction; the table says which turbulence model
    gamma : JONSWAP peak factor, None for that of each sea state
    model : an already built model, whose operating points are used where they fit
    progress : told what is being done

    Raises
    ------
    FormatError, CaseError, ModelError : the study cannot be built at a wind speed, drag does not converge.
    """
    speeds, notes = _point_speeds(case, table)
    model = _built(case, model, sorted(set(speeds)), progress)
    for heading in set(table.heading.tolist()):
        if not headings_cover(model.hydro, heading):
            raise ModelError(f"the waves' heading of {np.degrees(heading):g} deg lies outside the hydrodynamic data")
    groups = _groups(model, table, speeds, turbulence)
    outputs = model.points[0].outputs
    loads = [k for k, name in enumerate(outputs.names) if name not in ("PtfmYaw", "PtfmSway", "PtfmRoll")]
    names = tuple(outputs.names[k] for k in loads)
    s, c = len(table), len(names)
    mean, moments, tower = np.zeros((s, c)), np.zeros((s, c, 4)), np.zeros((s, 4, 2, 2))
    done = 0
    for group in groups:
        mean[group.states] = group.point.outputs.mean[loads]
        for part in _parts(group.states):
            progress(f"{done} of {s} states solved")
            response = solve_group(model, table, group, part, gamma)
            moments[part] = channel_moments(group.point.outputs, response, names)
            if set(TOWER) <= set(names):
                tower[part] = load_moments(group.point.outputs, response, TOWER)
            done += len(part)
    return TableLoads(
        model=model,
        table=table,
        gamma=gamma,
        groups=groups,
        channels=names,
        units=tuple(outputs.units[k] for k in loads),
        mean=mean,
        moments=moments,
        tower=tower,
        point_speed=speeds,
        notes=(*model.notes, *notes),
    )


def solve_group(model: Model, table: StateTable, group: Group, states, gamma: float | None) -> BatchResponse:
    """Return the responses to some states (indices into the table) of one group; raise ModelError when drag does not
    converge.
    """
    system, omega, options = group.point.system, model.omega, model.case.options
    grid = prepare(system, omega, [group.heading], low_frequency=options.low_frequency_excitation)
    waves = np.array([wave_spectrum(_sea(table, k, gamma), omega) for k in states])[:, None]
    wind = gradient = None
    if group.wind is not None:
        if group.point.rotor is None:
            wind = inflow_spectrum(group.wind, omega)
        else:
            wind, gradient = rotor_spectra(group.wind, group.point.rotor, omega)
    wide = [None if a is None else np.broadcast_to(a, (len(states), len(omega))) for a in (wind, gradient)]
    try:
        return solve_many(system, group.point.mean, grid, waves, *wide, drag=options.drag_model)
    except ValueError as error:
        raise ModelError(f"{table.name}: {error}") from None


def stress_spectra(loads: TableLoads, states: Sequence[int], row) -> np.ndarray:
    """Return the spectra (k, n) [unit2/(rad/s)] of one linear combination `row` (2) of the tower-base moments in some
    states.
    """
    out = np.empty((len(states), len(loads.model.omega)))
    for group in loads.groups:
        here = [k for k, state in enumerate(states) if state in set(group.states.tolist())]
        if here:
            part = np.array([states[k] for k in here])
            response = solve_group(loads.model, loads.table, group, part, loads.gamma)
            out[here] = combined_spectra(group.point.outputs, response, TOWER, row)
    return out


def _sea(table: StateTable, k: int, gamma: float | None) -> SeaState:
    return SeaState(
        significant_height=float(table.significant_height[k]),
        peak_period=float(table.peak_period[k]),
        gamma=gamma,
        heading=float(table.heading[k]),
    )


def _point_speeds(case: Case, table: StateTable) -> tuple[np.ndarray, list[str]]:
    """Return the wind speed (s) of each state's operating point, 0 for parked ones, and notes."""
    known = case.wind_speeds
    runs = table.operating > 0
    if runs.any() and not known:
        raise ModelError(
            f"{case.path}: the turbine runs in {int(runs.sum())} states, but the study names no turbine at a wind speed (linearisations or TurbineFile)"
        )
    speeds = np.round(table.wind_speed / SPEED_STEP) * SPEED_STEP
    notes = []
    scaled = {
        "below": ", its gusts reduced as the thrust's slope is (thrust grows with the square of the wind)",
        "above": "",
    }
    if runs.any():
        low, high = known[0], known[-1]
        clipped = np.clip(speeds, low, high)
        for beyond, words, bound in ((speeds < low, "below", low), (speeds > high, "above", high)):
            share = float(table.probability[beyond & runs].sum())
            if (beyond & runs).any():
                notes.append(
                    f"{int((beyond & runs).sum())} states ({100 * share:.2g} % of the time) have winds {words} the linearisations; "
                    f"they take the one at {bound:g} m/s with their own turbulence" + scaled[words]
                )
        speeds = np.where(runs, clipped, 0.0)
    else:
        speeds = np.zeros(len(table))
    if not runs.all():
        notes.append(f"{int((~runs).sum())} states are parked: waves only, no wind on tower and rotor")
    return speeds, notes


def _built(case: Case, model: Model | None, speeds: Sequence[float], progress) -> Model:
    """Return a model with operating points at the speeds: the one given, when it has them all."""
    if model is not None:
        have = {p.wind_speed for p in model.points}
        if set(speeds) <= have:
            return model
    return build(case, progress=progress, speeds=speeds)


def _groups(model: Model, table: StateTable, speeds: np.ndarray, turbulence: str | float) -> tuple[Group, ...]:
    """Return the states sorted by operating point, wind and heading."""
    rounded = np.where(speeds > 0, np.round(table.wind_speed / SPEED_STEP) * SPEED_STEP, 0.0)
    keys = np.stack([speeds, rounded, table.heading], axis=-1)
    found, number = np.unique(keys, axis=0, return_inverse=True)
    out = []
    for k, (speed, actual, heading) in enumerate(found):
        wind = _wind(model, speed, actual, turbulence, table.turbulence_model) if speed > 0 else None
        states = np.flatnonzero(number.ravel() == k)
        out.append(Group(point=model.at(speed), states=states, wind=wind, heading=float(heading)))
    return tuple(out)


def _wind(model: Model, speed: float, actual: float, turbulence: str | float, kind: str) -> WindState | None:
    """Return the turbulent wind at an operating point's speed with the standard deviation of the actual speed.

    Below the lowest operating point thrust is taken as proportional to the square of the wind, so its slope as
    proportional to the wind: gusts are reduced by that ratio.
    """
    if kind == "none" or (not isinstance(turbulence, str) and turbulence == 0):
        return None
    actual = max(actual, SPEED_STEP)
    sigma = turbulence_sigma(turbulence, kind, actual) if isinstance(turbulence, str) else turbulence * actual
    sigma *= min(actual / speed, 1.0)
    structure, options = model.deck.elastodyn.structure, model.case.options
    return WindState(
        mean_speed=speed,
        hub_height=structure.hub_height,
        rotor_diameter=structure.rotor.diameter,
        spectrum=options.wind_spectrum,
        averaging=options.wind_averaging,
        turbulence_intensity=sigma / speed,
    )


def _parts(states: np.ndarray) -> list[np.ndarray]:
    return np.array_split(states, max(1, -(-len(states) // _PART)))
