"""What designs are worth: any quantity of the model by its name, for many designs at once.

Quantities come at four levels of effort: at rest, at the mean offset of a state, of the response to a state, over a life of states.
A batch remembers what it has computed, so that asking for a second quantity of the same state costs next to nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np

from model.conventions import PLATFORM_DOFS
from model.design.anchors import SAFETY, drag_anchor_mass, suction_pile_size
from model.design.cost import PlateLayout, Prices, Semisubmersible, cost_items, hull_plating, total_cost
from model.design.hull import SemiHull
from model.design.hull_drag import hull_elements
from model.design.population import (
    Carried,
    LineType,
    Population,
    fixed_matrices,
    populate,
    population_dynamics,
    population_offsets,
)
from model.environment.airy import wavenumber
from model.response.endurance import EnduranceCurve
from model.response.fatigue import SECONDS_PER_YEAR, damage_rate, range_distribution, stress_moments
from model.response.loads import tower_base_rows
from model.response.mean_offset import MeanOffsets
from model.response.population import ElementSet, PopulationResponse, element_set, solve_population
from model.response.solve import trapezoid_weights
from model.system.hydro_database import HydroBatch, HydroDatabase, interpolate
from model.system.mooring import MooringState
from model.system.turbine import TurbineMatrices


@dataclass(frozen=True, eq=False, kw_only=True)
class DesignState:
    """A sea and wind that designs are judged in: name; turbine at its operating point; heading [rad] of the waves; spectra (n) of
    wave [m2/(rad/s)], wind [(m/s)2/(rad/s)] and wind gradient [(m/s/m)2/(rad/s)]; share of the time in a life, 0 for none.
    """

    name: str
    turbine: TurbineMatrices
    wave_spectrum: np.ndarray
    wind_spectrum: np.ndarray
    gradient_spectrum: np.ndarray
    heading: float = 0.0
    share: float = 0.0


@dataclass(frozen=True, eq=False, kw_only=True)
class CostRules:
    """How cost is reckoned: the state whose mean load the anchors are for, prices, plate layout, kind of line ("chain", "wire") and
    anchor ("drag", "pile"), soil, safety on the anchor's load.
    """

    state: str
    prices: Prices
    layout: PlateLayout
    line: str = "chain"
    anchor: str = "drag"
    soil: str = "mk5_very_soft_clay"
    safety: float = SAFETY


@dataclass(frozen=True, eq=False, kw_only=True)
class FatigueRules:
    """How damage is reckoned: S-N curve, section modulus [m3], factor on stress, life [years], spectral method."""

    curve: EnduranceCurve
    modulus: float
    factor: float
    years: float
    method: str = "dirlik"


@dataclass(frozen=True, eq=False, kw_only=True)
class Setting:
    """All that designs have in common: frequencies omega (n) [rad/s], states, line type, depth [m], what the hull carries, base of
    the tower [m], acceleration of the nacelle per unit of motion (q), coefficient database, hull dimensions that are not varied,
    cost and fatigue rules, duration [s] of expected extremes, density [kg/m3], gravity [m/s2].
    """

    omega: np.ndarray
    states: tuple[DesignState, ...]
    line: LineType
    depth: float
    carried: Carried
    tower_base: float
    nacelle_motion: np.ndarray
    database: HydroDatabase
    hull: dict[str, float]
    cost: CostRules | None = None
    fatigue: FatigueRules | None = None
    duration: float = 3600.0
    density: float = 1025.0
    gravity: float = 9.80665

    def state(self, name: str) -> DesignState:
        """Return a state by its name; raise KeyError with those there are."""
        for state in self.states:
            if state.name == name:
                return state
        raise KeyError(f"no state {name!r}; there are {', '.join(s.name for s in self.states)}")

    def hulls(self, diameter, radius, draft) -> SemiHull:
        """Return hulls of these dimensions [m]."""
        return SemiHull(diameter=diameter, radius=radius, draft=draft, **self.hull)


CHANNELS = ("surge", "heave", "pitch", "tower_moment", "nacelle_acceleration", "tension")


@dataclass(frozen=True, eq=False, kw_only=True)
class StateResult:
    """Response of N designs to one state: transfer functions of the platform's motions and of the channels (tower-base moment,
    nacelle acceleration, fairlead tension of the most loaded line) to each input r, (N, c, r, n); mean (N, c), spectra (N, c, n);
    the solution.
    """

    mean: np.ndarray
    spectra: np.ndarray
    transfer: np.ndarray
    solution: PopulationResponse


class Batch:
    """N designs in a setting, with everything that has been computed for them so far."""

    def __init__(self, setting: Setting, population: Population, hydro: HydroBatch | None = None):
        self.setting, self.population, self.given_hydro = setting, population, hydro
        self._means: dict[str, MeanOffsets] = {}
        self._results: dict[str, StateResult] = {}
        self._elements: dict[float, ElementSet] = {}
        self._hydro: dict[float, HydroBatch] = {}

    def __len__(self) -> int:
        return len(self.population)

    @property
    def hull(self) -> SemiHull:
        """The hulls."""
        return self.population.hull

    def some(self, index) -> Batch:
        """Return the batch of some of the designs, with the mean offsets that are known."""
        p = self.population
        out = Batch(self.setting, _populated(self.setting, _hulls_of(self.hull, index), p.anchor_radius[index], p.length[index]), self.given_hydro)
        out._means = {k: _taken(m, index) for k, m in self._means.items()}
        return out

    def mean(self, name: str) -> MeanOffsets:
        """Return the mean offsets in a state."""
        if name not in self._means:
            s = self.setting
            self._means[name] = population_offsets(self.population, s.state(name).turbine, density=s.density, gravity=s.gravity)
        return self._means[name]

    def hydro(self, heading: float) -> HydroBatch:
        """Return the coefficients at the setting's frequencies for one heading [rad]."""
        if self.given_hydro is not None:
            return self.given_hydro
        if heading not in self._hydro:
            h = self.hull
            designs = np.stack(np.broadcast_arrays(h.diameter, h.radius, h.draft), axis=-1)
            self._hydro[heading] = interpolate(self.setting.database, designs, self.setting.omega, (heading,), depth=self.setting.depth)
        return self._hydro[heading]

    def elements(self, heading: float) -> ElementSet:
        """Return the drag elements for one heading [rad]."""
        if heading not in self._elements:
            s = self.setting
            members = hull_elements(self.hull, density=s.density)
            self._elements[heading] = element_set(members, len(self), s.omega, heading, s.depth, s.gravity)
        return self._elements[heading]

    def result(self, name: str) -> StateResult:
        """Return the response to a state."""
        if name not in self._results:
            self._results[name] = _solve_state(self, self.setting.state(name))
        return self._results[name]

    @cached_property
    def platform_mass(self) -> np.ndarray:
        """Mass of platform and lines (N) [kg]."""
        s = self.setting
        return self.population.floating.mass + 3 * s.line.mass_per_length * self.population.length

    def periods(self, name: str) -> np.ndarray:
        """Return the natural periods (N, 3) [s] of surge, heave and pitch about the mean offset of a state, undamped, with the added
        mass of each mode's own frequency.
        """
        return 2 * np.pi / natural_frequencies(self, self.setting.state(name))


def make_batch(setting: Setting, diameter, radius, draft, anchor_radius, length, hydro: HydroBatch | None = None) -> Batch:
    """Return designs (N) as a batch; dimensions [m]. hydro replaces the database. Raises ValueError when a line cannot reach."""
    return Batch(setting, _populated(setting, setting.hulls(diameter, radius, draft), anchor_radius, length), hydro)


def _populated(setting: Setting, hull: SemiHull, anchor_radius, length) -> Population:
    return populate(
        hull, anchor_radius, length, line=setting.line, carried=setting.carried, depth=setting.depth, density=setting.density, gravity=setting.gravity
    )


def _hulls_of(hull: SemiHull, index) -> SemiHull:
    whole = hull.shape
    return replace(hull, **{f.name: np.broadcast_to(getattr(hull, f.name), whole)[index] for f in fields(hull) if getattr(hull, f.name).shape})


def _taken(means: MeanOffsets, index) -> MeanOffsets:
    mooring = MooringState(**{f.name: getattr(means.mooring, f.name)[index] for f in fields(MooringState)})
    return replace(means, offset=means.offset[index], stiffness=means.stiffness[index], converged=means.converged[index], mooring=mooring)


def _solve_state(batch: Batch, state: DesignState) -> StateResult:
    setting, mean, hydro = batch.setting, batch.mean(state.name), batch.hydro(state.heading)
    omega, turbine = setting.omega, state.turbine
    dynamic = population_dynamics(batch.population, turbine, mean.stiffness, hydro, density=setting.density, gravity=setting.gravity)
    winds = _inputs(state) - 1
    weight = np.stack([state.wave_spectrum, state.wind_spectrum, *[state.gradient_spectrum] * 2][: 1 + winds]) * trapezoid_weights(omega)
    n, q = len(batch), len(turbine.dofs)
    force = np.zeros((n, q, 1 + winds, len(omega)), dtype=complex)
    force[:, :6, 0] = np.moveaxis(hydro.excitation[:, 0], 1, -1)
    force[:, :, 1:] = np.vstack([turbine.wind_force, turbine.gradient_force])[:winds].T[None, :, :, None]
    solution = solve_population(omega, dynamic, force, weight, batch.elements(state.heading))
    transfer, level = _channels(batch, state, mean, solution.motion)
    spectra = (np.abs(transfer) ** 2 * (weight / trapezoid_weights(omega))).sum(axis=2)
    return StateResult(mean=level, spectra=spectra, transfer=transfer, solution=solution)


def _inputs(state: DesignState) -> int:
    """Return how many inputs drive a state: waves, wind, its two gradients."""
    if not np.any(state.wind_spectrum):
        return 1
    return 4 if np.any(state.gradient_spectrum) else 2


def _channels(batch: Batch, state: DesignState, mean: MeanOffsets, motion) -> tuple[np.ndarray, np.ndarray]:
    """Return the transfer functions (N, c, r, n) and mean (N, c) of CHANNELS."""
    setting, turbine, omega = batch.setting, state.turbine, batch.setting.omega
    dofs, q = turbine.dofs, motion.shape[1]
    base = tower_base_rows(turbine, dofs, mean.offset, setting.tower_base)
    count = len(batch)
    position, velocity, acceleration = np.zeros((3, count, len(CHANNELS), q))
    for c, dof in enumerate(("surge", "heave", "pitch")):
        position[:, c, dofs.index(dof)] = 1.0
    position[:, 3], velocity[:, 3], acceleration[:, 3] = base.position[:, 2], base.velocity[2], base.acceleration[2]
    acceleration[:, 4] = setting.nacelle_motion[:q]
    tension = mean.mooring.fairlead_tension
    line = np.argmax(tension, axis=1)
    every = np.arange(count)
    position[:, 5, :6] = mean.mooring.tension_gradient[every, line]
    iw = 1j * omega
    flat = motion.reshape(count, q, -1)
    shape = (count, len(CHANNELS), *motion.shape[2:])
    out = (position @ flat).reshape(shape) + iw * (velocity @ flat).reshape(shape) + iw**2 * (acceleration @ flat).reshape(shape)
    out[:, 3, 1:] += base.wind[2, : motion.shape[2] - 1][:, None]
    places = [dofs.index(d) for d in ("surge", "heave", "pitch")]
    level = np.column_stack([mean.offset[:, places], base.mean[:, 2], np.zeros(count), tension[every, line]])
    return out, level


def natural_frequencies(batch: Batch, state: DesignState) -> np.ndarray:
    """Return the undamped natural frequencies (N, 3) [rad/s] of surge, heave and pitch about the mean offset of a state.

    The symmetric parts of the matrices with the added mass of the mode's own frequency, iterated; a mode is the one in which its
    motion has the largest part of the kinetic energy.
    """
    setting, mean, hydro = batch.setting, batch.mean(state.name), batch.hydro(state.heading)
    q = len(state.turbine.dofs)
    mass = np.repeat(state.turbine.mass[None], len(batch), axis=0)
    mass[:, :6, :6] += fixed_matrices(batch.population, density=setting.density, gravity=setting.gravity)[0]
    stiffness = (mean.stiffness + mean.stiffness.swapaxes(1, 2)) / 2
    out = np.zeros((len(batch), 3))
    for c, dof in enumerate(("surge", "heave", "pitch")):
        k = PLATFORM_DOFS.index(dof)
        added, found = hydro.added_mass_infinite, None
        for _ in range(4):
            total = mass.copy()
            total[:, :6, :6] += added
            root = np.linalg.cholesky((total + total.swapaxes(1, 2)) / 2)
            inverse = np.linalg.inv(root)
            values, vectors = np.linalg.eigh(inverse @ stiffness @ inverse.swapaxes(1, 2))
            shapes = inverse.swapaxes(1, 2) @ vectors
            energy = total[:, k, k, None] * shapes[:, k] ** 2
            if q > 6:
                energy = np.where(values > (2 * np.pi) ** 2 * 0.04, 0.0, energy)  # the tower's mode is not one of the platform's
            mode = np.argmax(energy, axis=1)
            found = np.sqrt(np.maximum(values[np.arange(len(batch)), mode], 1e-12))
            added = _added_mass_at(hydro, setting.omega, found)
        out[:, c] = found
    return out


def _added_mass_at(hydro: HydroBatch, omega, at) -> np.ndarray:
    """Return the added mass (N, 6, 6) at a frequency of each design (N) [rad/s], linear between grid points."""
    high = np.clip(np.searchsorted(omega, at), 1, len(omega) - 1)
    share = np.clip((at - omega[high - 1]) / (omega[high] - omega[high - 1]), 0.0, 1.0)[:, None, None]
    every = np.arange(len(at)) if len(hydro.added_mass) > 1 else np.zeros(len(at), dtype=int)
    return (1 - share) * hydro.added_mass[every, high - 1] + share * hydro.added_mass[every, high]


def cost_account(batch: Batch) -> tuple:
    """Return the items of the account of each design, quantities (N); drag anchors and piles hold the mean load of the cost state."""
    setting, rules, hull = batch.setting, batch.setting.cost, batch.hull
    priced = Semisubmersible(
        column_diameter=hull.diameter, radius=hull.radius, draft=hull.draft, main_diameter=hull.central_diameter, main_freeboard=hull.central_freeboard,
        column_freeboard=hull.column_freeboard, plate_height=hull.plate_height, plate_diameter=hull.plate_diameter, brace_diameter=hull.brace_diameter,
        column_wall=hull.column_wall, main_wall=hull.central_wall, brace_wall=hull.brace_wall,
    )  # fmt: skip
    load = rules.safety * batch.mean(rules.state).mooring.anchor_tension.max(axis=1)
    drag = rules.anchor == "drag"
    anchor = drag_anchor_mass(load, rules.soil) if drag else suction_pile_size(load, rules.soil)[3]
    return cost_items(
        hull_plating(priced), batch.population.floating.ballast_mass, 3 * batch.population.length * setting.line.mass_per_length, 3 * anchor,
        line=rules.line, anchor="drag" if drag else "suction pile", prices=rules.prices, layout=rules.layout,
    )  # fmt: skip


def total_costs(batch: Batch) -> np.ndarray:
    """Return the cost of each design (N) [EUR]."""
    return np.asarray(total_cost(cost_account(batch)), dtype=float)


def lifetime_damages(batch: Batch, names: Sequence[str]) -> np.ndarray:
    """Return the fatigue damage (N) of the tower base fore-aft over the life, states weighted with their share of the time."""
    rules, total = batch.setting.fatigue, 0.0
    for name in names:
        state = batch.setting.state(name)
        spectrum = batch.result(name).spectra[:, CHANNELS.index("tower_moment")] / rules.modulus**2
        ranges = range_distribution(stress_moments(spectrum, batch.setting.omega), rules.method)
        total = total + state.share * rules.years * SECONDS_PER_YEAR * damage_rate(ranges, rules.curve, rules.factor)
    return np.asarray(total)


def relative_elevation(batch: Batch, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Return mean (N, 3) [m] and spectra (N, 3, n) of the wave elevation over the hull at its three columns, undisturbed waves."""
    state, mean, result = batch.setting.state(name), batch.mean(name), batch.result(name)
    dofs, omega = state.turbine.dofs, batch.setting.omega
    azimuth = np.pi + np.array([0.0, 2.0, 4.0]) * np.pi / 3
    radius = np.broadcast_to(batch.hull.radius, (len(batch),))[:, None]
    x, y = radius * np.cos(azimuth), radius * np.sin(azimuth)
    rows = np.zeros((len(batch), 3, len(dofs)))
    for dof, value in (("heave", 1.0), ("roll", y), ("pitch", -x)):
        rows[..., dofs.index(dof)] = value
    motion = result.solution.motion
    raised = (rows @ motion.reshape(len(batch), len(dofs), -1)).reshape(len(batch), 3, *motion.shape[2:])
    k = wavenumber(omega, batch.setting.depth, batch.setting.gravity)
    along = (x * np.cos(state.heading) + y * np.sin(state.heading))[..., None] * k
    raised = -raised
    raised[:, :, 0] += np.exp(-1j * along)
    drive = np.stack([state.wave_spectrum, state.wind_spectrum, *[state.gradient_spectrum] * 2][: motion.shape[2]])
    return -np.einsum("ncq,nq->nc", rows, mean.offset), (np.abs(raised) ** 2 * drive).sum(axis=2)
