"""A lifetime at a site: fatigue around the tower base and in the moorings, ultimate loads, and the check by rainflow."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from fowtio.case import Case
from fowtio.errors import ModelError
from fowtio.site import Site
from fowtio.state_loads import TableLoads, stress_spectra, table_loads
from model.design.load_cases import StateTable, binned_states, crest_states
from model.environment.contours import isoline, reliability_index
from model.response.extremes import expected_largest, long_term_extreme, mean_plus_deviation, short_term_fractile
from model.response.fatigue import (
    EnduranceCurve,
    TubeSection,
    equivalent_range,
    mooring_area,
    mooring_stress_curve,
    moments_around,
    range_distribution,
    sn_curve,
    stress_rows,
    synthesise,
    thickness_factor,
    weld_concentration,
)
from model.response.lifetime import Damage, lifetime_damage

STEEL_MODULUS, TOWER_DENSITY = 210e9, 8500.0  # of the NREL and DTU towers, paint and bolts in the density
CHAIN_MASS = 19.9e3  # kg/m per d^2 of studless chain
QUIET = lambda text: None  # noqa: E731


@dataclass(frozen=True, eq=False, kw_only=True)
class FatigueSettings:
    """What fatigue is reckoned with.

    Parameters
    ----------
    detail, environment : S-N curve of DNV-RP-C203
    years : life
    design_factor : what the damage is multiplied by before it is compared with one (DFF)
    section : of the tower base; None takes the tube of equal mass and stiffness as the deck's tower
    concentration : on stress; None is that of a girth weld (thesis eq. 8.8) as wide as the wall is thick
    points : around the tower
    method : of `range_distribution`
    mooring : component of DNV-OS-E301
    bounded : integrate up to the largest range expected in the life (thesis eq. 8.17) instead of to infinity
    """

    detail: str = "D"
    environment: str = "air"
    years: float = 25.0
    design_factor: float = 3.0
    section: TubeSection | None = None
    concentration: float | None = None
    points: int = 36
    method: str = "dirlik"
    mooring: str = "studless_chain"
    bounded: bool = False


@dataclass(frozen=True, eq=False, kw_only=True)
class UltimateLoads:
    """Ultimate loads of channels (c), about the sign of the mean: over the states of a table, with the state that governs each.

    objective, expected, fractile (c): mean plus deviation, expected largest and 90 % fractile of a state, the largest over
    the states; governing (c) the state of `expected`; long_term (c) the value once in `return_period` years over all
    states, None without probabilities; contour (c) the expected largest in the contour's states, and its state (c).
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


@dataclass(frozen=True, eq=False, kw_only=True)
class RainflowCheck:
    """Damage-equivalent ranges of the worst point by Dirlik and by rainflow of synthesised hours: states (k) of the table,
    spectral and counted (k, slopes) [Pa], slopes, hours of each state, and both over the whole life, weighted with time.
    """

    states: np.ndarray
    slopes: tuple[float, ...]
    spectral: np.ndarray
    counted: np.ndarray
    hours: int

    @property
    def error(self) -> np.ndarray:
        """Spectral over counted less one (k, slopes)."""
        return self.spectral / self.counted - 1


@dataclass(frozen=True, eq=False, kw_only=True)
class FatigueStudy:
    """A lifetime at a site: loads of all states, the tower's damage around angles (p) [rad], the lines' damage, ultimate loads."""

    site: Site
    settings: FatigueSettings
    loads: TableLoads
    section: TubeSection
    curve: EnduranceCurve
    factor: float
    angles: np.ndarray
    tower: Damage
    lines: Damage | None
    line_curve: EnduranceCurve | None
    line_diameter: np.ndarray | None
    ultimate: UltimateLoads
    check: RainflowCheck | None = None
    notes: tuple[str, ...] = field(default=())

    @property
    def worst(self) -> int:
        """Point with the largest damage."""
        return int(np.argmax(self.tower.total))


def fatigue_study(
    case: Case, site: Site, *, settings: FatigueSettings | None = None, table: StateTable | None = None,
    return_period: float = 50.0, verify: int = 0, seed: int = 1, progress: Callable[[str], None] = QUIET,
) -> FatigueStudy:  # fmt: skip
    """Return the fatigue and ultimate loads of a study's turbine over a lifetime at a site.

    Parameters
    ----------
    case, site : what stands where
    settings : of the fatigue
    table : states with probabilities; by default the joint distribution in bins
    return_period : of the ultimate loads [years]
    verify : hours to synthesise of each of the ten states that do most damage, for rainflow; 0 for none
    seed : of those
    progress : told what is being done

    Raises
    ------
    FormatError, CaseError, ModelError : the study cannot be built or solved, or lacks a tower.
    """
    settings = settings or FatigueSettings()
    table = table if table is not None else binned_states(
        site.model, site.to_hub, cut_in=site.cut_in, cut_out=site.cut_out, least=1e-5
    )  # fmt: skip
    loads = table_loads(case, table, turbulence=site.turbulence, gamma=site.gamma, progress=progress)
    if not loads.tower.any():
        raise ModelError(f"{case.path}: no tower-base moments; the study has no turbine")
    section, notes = _section(loads, settings)
    curve = sn_curve(settings.detail, settings.environment)
    weld = settings.concentration
    weld = weld_concentration(section.thickness, section.diameter, section.thickness) if weld is None else weld
    factor = weld * thickness_factor(curve, section.thickness)
    angles = 2 * np.pi * np.arange(settings.points) / settings.points
    stress = moments_around(stress_rows(section, angles), loads.tower)
    progress("damage")
    tower = _damage(stress, table, curve, factor, settings)
    lines, line_curve, diameter = _lines(loads, settings)
    ultimate = ultimate_loads(case, site, loads, return_period, progress)
    check = None
    if verify:
        point = int(np.argmax(tower.total))
        row = stress_rows(section, angles)[point]
        check = rainflow_check(loads, tower, row, point, hours=verify, seed=seed, progress=progress)
    return FatigueStudy(
        site=site, settings=settings, loads=loads, section=section, curve=curve, factor=factor, angles=angles, tower=tower,
        lines=lines, line_curve=line_curve, line_diameter=diameter, ultimate=ultimate, check=check, notes=(*loads.notes, *notes),
    )  # fmt: skip


def _damage(moments, table: StateTable, curve: EnduranceCurve, factor: float, settings: FatigueSettings) -> Damage:
    upper = None
    if settings.bounded:
        from model.response.fatigue import SECONDS_PER_YEAR, largest_range

        upper = largest_range(range_distribution(moments, settings.method), settings.years * SECONDS_PER_YEAR)
    return lifetime_damage(
        moments, table.probability, curve, factor=factor, years=settings.years, method=settings.method, upper=upper
    )


def _section(loads: TableLoads, settings: FatigueSettings) -> tuple[TubeSection, list[str]]:
    """Return the section of the tower base: the one given, or the tube of equal mass and bending stiffness."""
    if settings.section is not None:
        return settings.section, []
    tower = loads.model.deck.elastodyn.structure.tower
    area = tower.mass_density[0] / TOWER_DENSITY
    inertia = tower.stiffness_fa[0] / STEEL_MODULUS
    middle = 2 * float(np.sqrt(2 * inertia / area))
    wall = area / (np.pi * middle)
    section = TubeSection(diameter=middle + wall, thickness=wall)
    note = (
        f"tower base as a tube of {section.diameter:.3g} m by {1e3 * wall:.3g} mm, of the mass and stiffness of the deck's tower "
        f"with steel of {STEEL_MODULUS / 1e9:g} GPa and {TOWER_DENSITY:g} kg/m³"
    )
    return section, [note]


def _lines(loads: TableLoads, settings: FatigueSettings) -> tuple[Damage | None, EnduranceCurve | None, np.ndarray | None]:
    """Return the damage at the fairleads, its curve, and the nominal diameters, which follow from the mass per length."""
    mooring = loads.model.deck.mooring
    names = [n for n in loads.channels if n.startswith("T[")]
    if mooring is None or not names:
        return None, None, None
    mass = np.atleast_1d(mooring.mass_per_length)[: len(names)]
    density = CHAIN_MASS if "studless" in settings.mooring else 21.9e3 if "chain" in settings.mooring else 5.2e3
    diameter = np.sqrt(mass / density)
    area = np.array([mooring_area(settings.mooring, d) for d in diameter])
    at = [loads.index(n) for n in names]
    curve = mooring_stress_curve(settings.mooring)
    return _damage(loads.moments[:, at] / area[:, None] ** 2, loads.table, curve, 1.0, settings), curve, diameter


def ultimate_loads(
    case: Case, site: Site, loads: TableLoads, return_period: float, progress: Callable[[str], None] = QUIET
) -> UltimateLoads:
    """Return the ultimate loads: over the states of a table, once in a return period, and in the contour's states."""
    table = loads.table
    speeds = np.unique(loads.point_speed[loads.point_speed > 0])
    low, high = _reached(site, return_period)
    speeds = speeds[(speeds > low) & (speeds < high)]
    contour = crest_states(
        site.model, site.to_hub, speeds, return_period, state_duration=site.state_duration, name=f"contour, {return_period:g} years", safety=1.35
    )
    severe = table_loads(case, contour, turbulence=site.turbulence, gamma=site.gamma, model=loads.model, progress=progress)
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
        channels=loads.channels, units=loads.units, return_period=return_period,
        objective=sign * mean_plus_deviation(loads.mean, loads.std).max(axis=0), expected=sign * expected.max(axis=0),
        fractile=sign * largest(loads, 0.9).max(axis=0), governing=expected.argmax(axis=0), long_term=sign * long,
        contour=sign * there.max(axis=0), contour_fractile=sign * largest(severe, 0.9).max(axis=0), contour_state=there.argmax(axis=0),
        contour_table=contour,
    )  # fmt: skip


def _weighted_mean(loads: TableLoads) -> np.ndarray:
    """Return the mean of each channel (c) in the state where it is largest in size."""
    return np.take_along_axis(loads.mean, np.abs(loads.mean).argmax(axis=0)[None], axis=0)[0]


def _reached(site: Site, return_period: float) -> tuple[float, float]:
    """Return the range of hub wind speeds of the contour."""
    from model.environment.contours import level_range

    low, high = level_range(site.model, reliability_index(return_period, site.state_duration))
    return low * site.to_hub, high * site.to_hub


def rainflow_check(
    loads: TableLoads, tower: Damage, row, point: int, *, hours: int = 5, most: int = 10, slopes: Sequence[float] = (3.0, 4.0, 5.0),
    seed: int = 1, step: float = 0.1, progress: Callable[[str], None] = QUIET,
) -> RainflowCheck:  # fmt: skip
    """Return damage-equivalent ranges by Dirlik and by rainflow counting of synthesised hours.

    Parameters
    ----------
    loads, tower : of the study; row (2) and point, where the stress is taken
    hours : synthesised of each state; most : of the states that do most damage; slopes : of the equivalent ranges
    seed, step : of the histories [s]

    Returns
    -------
    RainflowCheck
    """
    import fatpack

    states = np.argsort(tower.by_state[:, point])[::-1][:most]
    states = states[tower.by_state[states, point] > 0]
    progress("stress histories for rainflow")
    spectra = stress_spectra(loads, states.tolist(), row)
    rng = np.random.default_rng(seed)
    counted = np.zeros((len(states), len(slopes)))
    for k, spectrum in enumerate(spectra):
        progress(f"rainflow of {k + 1} of {len(states)} states")
        histories = synthesise(spectrum, loads.model.omega, 3600.0, step, rng, hours)
        ranges = [fatpack.find_rainflow_ranges(x, k=256) for x in histories]
        counted[k] = [(sum((r**m).sum() for r in ranges) / (3600 * hours)) ** (1 / m) for m in slopes]
    found = range_distribution(tower.moments[states, point])
    spectral = np.stack([equivalent_range(found, m) for m in slopes], axis=-1)
    return RainflowCheck(states=states, slopes=tuple(slopes), spectral=spectral, counted=counted, hours=hours)


@dataclass(frozen=True, eq=False, kw_only=True)
class ResponseSearch:
    """The state (hub wind speed, Hs, Tp) of a contour that makes a channel largest: expected largest value there, and per
    operating point (k) the worst state (k, 3) and value (k).
    """

    channel: str
    unit: str
    state: np.ndarray
    value: float
    by_speed: np.ndarray
    values: np.ndarray


def contour_search(
    case: Case, site: Site, return_period: float, channel: str = "TwrBsMyt", *, around: int = 24, refinements: int = 2,
    progress: Callable[[str], None] = QUIET,
) -> ResponseSearch:  # fmt: skip
    """Return the state of the contour surface that makes a channel largest, found with the model itself.

    On the isoline of every operating point `around` states are solved, then as many between the best one's neighbours.

    Raises ModelError for a channel that the study does not have, or when no operating point lies on the contour.
    """
    known = sorted(e.wind_speed for e in case.linearisations if e.wind_speed > 0)
    low, high = _reached(site, return_period)
    speeds = [s for s in known if low < s < high and site.cut_in <= s <= site.cut_out]
    if not speeds:
        raise ModelError(f"no linearisation of the study lies on the contour ({low:.3g} to {high:.3g} m/s at hub height)")
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
    return ResponseSearch(channel=channel, unit=unit, state=best[top], value=float(sign * value[top]), by_speed=best, values=sign * value)


def _on_isoline(site: Site, beta: float, speed: float, angles) -> np.ndarray:
    """Return states (k, 3) at angles of the isoline of a hub wind speed, the wind at hub height."""
    from model.environment.joint import to_physical, to_standard

    first = float(to_standard(site.model, np.full(3, speed / site.to_hub))[0])
    radius = np.sqrt(max(beta**2 - first**2, 0.0))
    u = np.stack([np.full(len(angles), first), radius * np.cos(angles), radius * np.sin(angles)], axis=-1)
    states = to_physical(site.model, u)
    states[:, 0] = speed
    return states


def _free_table(states: np.ndarray, site: Site) -> StateTable:
    from model.design.load_cases import state_table

    period = np.clip(states[:, 2], 1.5, None)  # shorter waves than this carry nothing at the heights that go with them
    return state_table("contour", states[:, 0], states[:, 1], period, duration=3600 * site.state_duration)


def isolines(site: Site, return_period: float, speeds: Sequence[float], count: int = 181) -> dict[float, np.ndarray]:
    """Return the isolines (count, 3) of a contour at hub wind speeds, with the wind at hub height; those it does not reach left out."""
    beta = reliability_index(return_period, site.state_duration)
    low, high = _reached(site, return_period)
    out = {}
    for speed in speeds:
        if low < speed < high:
            line = isoline(site.model, beta, speed / site.to_hub, count).copy()
            line[:, 0] = speed
            out[float(speed)] = line
    return out


def settings_of(
    *, detail: str, environment: str, years: float, design_factor: float, diameter: float | None, wall: float | None,
    concentration: float | None, method: str, mooring: str,
) -> FatigueSettings:  # fmt: skip
    """Return checked settings; diameter and wall [m] of the tower base come together or not at all.

    Raises ModelError saying what is wrong.
    """
    if (diameter is None) != (wall is None):
        raise ModelError("give the diameter and the wall of the tower base, or neither")
    for name, value in (("life", years), ("design factor", design_factor), ("concentration", concentration)):
        if value is not None and not value > 0:
            raise ModelError(f"the {name} is {value:g}; it must be positive")
    try:
        section = None if diameter is None else TubeSection(diameter=diameter, thickness=wall)
        sn_curve(detail, environment)
        mooring_stress_curve(mooring)
        range_distribution(np.ones(4), method)
    except ValueError as error:
        raise ModelError(str(error)) from None
    return FatigueSettings(
        detail=detail, environment=environment, years=years, design_factor=design_factor, section=section,
        concentration=concentration, method=method, mooring=mooring,
    )  # fmt: skip
