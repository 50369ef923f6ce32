"""A lifetime at a site: fatigue around the tower base and in the moorings, ultimate loads, and the check by
rainflow.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from fowtio.case import Case
from fowtio.errors import ModelError
from fowtio.site import Site
from fowtio.state_loads import TableLoads, stress_spectra, table_loads
from fowtio.ultimate import UltimateLoads, ultimate_loads
from model.design.load_cases import StateTable, binned_states
from model.response.endurance import (
    EnduranceCurve,
    mooring_area,
    mooring_stress_curve,
    sn_curve,
    thickness_factor,
    weld_concentration,
)
from model.response.fatigue import (
    SECONDS_PER_YEAR,
    TubeSection,
    equivalent_range,
    largest_range,
    moments_around,
    range_distribution,
    stress_rows,
    synthesise,
)
from model.response.lifetime import Damage, lifetime_damage
from model.system.tower import Tower

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
class RainflowCheck:
    """Damage-equivalent ranges of the worst point by Dirlik and by rainflow of synthesised hours: states (k) of the
    table, spectral and counted (k, slopes) [Pa], slopes, hours of each state, and both over the whole life, weighted
    with time.
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
    """A lifetime at a site: loads of all states, the tower's damage around angles (p) [rad], the lines' damage,
    ultimate loads.
    """

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
    case: Case,
    site: Site,
    *,
    settings: FatigueSettings | None = None,
    table: StateTable | None = None,
    return_period: float = 50.0,
    verify: int = 0,
    seed: int = 1,
    progress: Callable[[str], None] = QUIET,
) -> FatigueStudy:
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
    table = (
        table
        if table is not None
        else binned_states(site.model, site.to_hub, cut_in=site.cut_in, cut_out=site.cut_out, least=1e-5)
    )
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
        site=site,
        settings=settings,
        loads=loads,
        section=section,
        curve=curve,
        factor=factor,
        angles=angles,
        tower=tower,
        lines=lines,
        line_curve=line_curve,
        line_diameter=diameter,
        ultimate=ultimate,
        check=check,
        notes=(*loads.notes, *notes),
    )


def _damage(moments, table: StateTable, curve: EnduranceCurve, factor: float, settings: FatigueSettings) -> Damage:
    upper = None
    if settings.bounded:
        upper = largest_range(range_distribution(moments, settings.method), settings.years * SECONDS_PER_YEAR)
    return lifetime_damage(
        moments, table.probability, curve, factor=factor, years=settings.years, method=settings.method, upper=upper
    )


def _section(loads: TableLoads, settings: FatigueSettings) -> tuple[TubeSection, list[str]]:
    """Return the section of the tower base: the one given, or the tube of equal mass and bending stiffness."""
    if settings.section is not None:
        return settings.section, []
    section = equal_tube(loads.model.deck.elastodyn.structure.tower)
    note = (
        f"tower base as a tube of {section.diameter:.3g} m by {1e3 * section.thickness:.3g} mm, of the mass and stiffness of the deck's tower "
        f"with steel of {STEEL_MODULUS / 1e9:g} GPa and {TOWER_DENSITY:g} kg/m³"
    )
    return section, [note]


def equal_tube(tower: Tower) -> TubeSection:
    """Return the tube of the mass and bending stiffness of a tower's base."""
    area = tower.mass_density[0] / TOWER_DENSITY
    middle = 2 * float(np.sqrt(2 * tower.stiffness_fa[0] / STEEL_MODULUS / area))
    wall = area / (np.pi * middle)
    return TubeSection(diameter=middle + wall, thickness=wall)


def _lines(
    loads: TableLoads, settings: FatigueSettings
) -> tuple[Damage | None, EnduranceCurve | None, np.ndarray | None]:
    """Return the damage at the fairleads, its curve, and the nominal diameters, which follow from the mass per
    length.
    """
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


def rainflow_check(
    loads: TableLoads,
    tower: Damage,
    row,
    point: int,
    *,
    hours: int = 5,
    most: int = 10,
    slopes: Sequence[float] = (3.0, 4.0, 5.0),
    seed: int = 1,
    step: float = 0.1,
    progress: Callable[[str], None] = QUIET,
) -> RainflowCheck:
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


def settings_of(
    *,
    detail: str,
    environment: str,
    years: float,
    design_factor: float,
    diameter: float | None,
    wall: float | None,
    concentration: float | None,
    method: str,
    mooring: str,
) -> FatigueSettings:
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
        detail=detail,
        environment=environment,
        years=years,
        design_factor=design_factor,
        section=section,
        concentration=concentration,
        method=method,
        mooring=mooring,
    )
