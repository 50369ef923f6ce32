"""From an optimisation study to what designs are judged by: turbine at every state, spectra, coefficients, costs, the reference."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fowtio.case import Options, StateEntry
from fowtio.database import read_database
from fowtio.errors import ModelError
from fowtio.fatigue_study import equal_tube
from fowtio.hull_references import OC4_SURGE_STIFFNESS
from fowtio.hull_turbine import carried, reference_folder, ten_megawatt, ten_megawatt_structure
from fowtio.optimise.study import OptimisationStudy
from fowtio.read.hydro_any import read_hydro
from fowtio.workflow import turbulent_wind, with_gradients
from model.design.cost import STEEL_DENSITY
from model.design.evaluate import Batch, CostRules, DesignState, FatigueRules, Setting, make_batch
from model.design.hull import OC4, SemiHull, upscaled
from model.design.population import Carried, LineType, populate, stiff_as, straight_distance
from model.design.space import DIMENSIONS, DesignSpace
from model.environment.rotor_wind import rotor_spectra
from model.environment.sea import wave_spectrum
from model.response.endurance import sn_curve, thickness_factor, weld_concentration
from model.response.fatigue import TubeSection
from model.system.hydro import HydroCoefficients, excitation_at, radiation_at
from model.system.hydro_database import HydroBatch
from model.system.tower import TOWER_MODES, tower_modes
from model.system.turbine import TurbineStructure, head_motion

CONCRETE = 2400.0  # kg/m3
REFERENCE_HYDRO = ("semi_10mw", "input/hydro/semi_10mw")


@dataclass(frozen=True, eq=False, kw_only=True)
class Reference:
    """The design that others are compared with: OC4 scaled to 10 MW, its dimensions (5) [m], and it alone as a batch."""

    design: np.ndarray
    batch: Batch


def setting_of(study: OptimisationStudy) -> Setting:
    """Return the setting of a study; raise ModelError for what its states ask of the turbine and it does not have."""
    structure = ten_megawatt_structure()
    omega = 2 * np.pi * np.concatenate([np.geomspace(b.low, b.high, b.count) for b in study.bands])
    states = tuple(design_state(s, structure, omega, study.shares.get(s.name, 0.0)) for s in study.states)
    mass, height = carried(ten_megawatt(0.0))
    cost, hull = study.cost, study.cost["hull"]
    volume = cost["LineVolume"] or cost["LineMass"] / STEEL_DENSITY
    walls = {"column_wall": "column_wall", "main_wall": "central_wall", "brace_wall": "brace_wall", "main_freeboard": "central_freeboard",
             "column_freeboard": "column_freeboard", "main_diameter": "central_diameter", "brace_diameter": "brace_diameter", "plate_height": "plate_height"}  # fmt: skip
    try:
        fatigue = _fatigue(study, structure)
    except ValueError as error:
        raise ModelError(f"{study.path}: {error}") from None
    return Setting(
        omega=omega, states=states, depth=cost["WaterDepth"], tower_base=structure.tower.base_height, nacelle_motion=_nacelle(structure),
        line=LineType(mass_per_length=cost["LineMass"], diameter=float(np.sqrt(4 * volume / np.pi)), axial_stiffness=cost["LineStiffness"]),
        carried=Carried(mass=mass, height=height), database=read_database(study.database) if study.database else read_database(),
        hull={to: hull[name] for name, to in walls.items() if name in hull} | {"ballast_density": CONCRETE},
        cost=CostRules(
            state=study.cost_state, prices=cost["prices"], layout=cost["layout"], line=cost["Line"], anchor=cost["Anchor"], soil=cost["Soil"],
            safety=cost["AnchorSafety"],
        ),
        fatigue=fatigue, duration=study.duration, density=cost["WaterDensity"], gravity=cost["Gravity"],
    )  # fmt: skip


def design_state(entry: StateEntry, structure: TurbineStructure, omega, share: float) -> DesignState:
    """Return a state of a study with the 10 MW turbine at its wind speed and the spectra on frequencies omega (n) [rad/s]."""
    if len(entry.seas) > 1 or entry.sea.spreading is not None:
        raise ModelError(f"state {entry.name!r}: designs are judged in one long-crested sea a state")
    turbine = ten_megawatt(entry.wind_speed)
    gusts, gradients = np.zeros((2, len(omega)))
    if entry.wind_speed > 0:
        turbine, rotor = with_gradients(turbine, structure, entry.wind_speed)
        wind = turbulent_wind(entry, structure, Options())
        if wind is not None:
            gusts, gradients = rotor_spectra(wind, rotor, omega)
    return DesignState(
        name=entry.name, turbine=turbine, wave_spectrum=wave_spectrum(entry.sea, omega), wind_spectrum=gusts, gradient_spectrum=gradients,
        heading=entry.sea.heading, share=share,
    )  # fmt: skip


def _nacelle(structure: TurbineStructure) -> np.ndarray:
    """Return the acceleration of the nacelle's accelerometer along the shaft per unit of platform motions and tower mode (7)."""
    modes = tower_modes(structure.tower, TOWER_MODES[:1])
    motion = head_motion(structure.tower.top_height, modes, structure.accelerometer)
    return np.array([np.cos(structure.rotor.tilt), 0.0, np.sin(structure.rotor.tilt)]) @ motion[:3]


def _fatigue(study: OptimisationStudy, structure: TurbineStructure) -> FatigueRules:
    """Return the rules of fatigue: the tower base given, or the tube of the mass and stiffness of the deck's tower."""
    section = TubeSection(diameter=study.section[0], thickness=study.section[1]) if study.section else equal_tube(structure.tower)
    curve = sn_curve(study.detail, study.environment)
    factor = weld_concentration(section.thickness, section.diameter, section.thickness) * thickness_factor(curve, section.thickness)
    return FatigueRules(curve=curve, modulus=section.modulus, factor=float(factor), years=study.years)


def reference_of(study: OptimisationStudy, setting: Setting) -> Reference:
    """Return the upscaled platform on the study's lines: OC4's lengths times the square root of two, OC4's walls (60, 30, 17.5 mm).

    Without a line length of its own the lines have the surge stiffness of OC4's, 70.8 kN/m. Its coefficients are solved with
    pontoons and braces in 200 m of water.
    """
    hull = replace(upscaled(OC4, 2.0, central_diameter=float(setting.hull["central_diameter"])), ballast_density=CONCRETE)
    one = SemiHull(**{k: np.atleast_1d(v) for k, v in vars(hull).items()})
    anchor, length = study.reference
    if length is None:
        length = float(stiff_as(one, anchor, OC4_SURGE_STIFFNESS, line=setting.line, depth=setting.depth)[0])
    if not length > straight_distance(one, np.array([anchor]), setting.depth)[0]:
        raise ModelError(f"{study.path}: lines of {length:g} m do not reach the reference from an anchor radius of {anchor:g} m")
    population = populate(
        one, np.array([anchor]), np.array([length]), line=setting.line, carried=setting.carried, depth=setting.depth, density=setting.density,
        gravity=setting.gravity,
    )  # fmt: skip
    folder, stem = REFERENCE_HYDRO
    hydro = on_grid(read_hydro(reference_folder(folder) / stem), setting.omega)
    design = np.array([float(hull.diameter), float(hull.radius), float(hull.draft), anchor, length])
    return Reference(design=design, batch=Batch(setting, population, hydro))


def on_grid(hydro: HydroCoefficients, omega, heading: float = 0.0) -> HydroBatch:
    """Return one hull's coefficients on frequencies omega (n) [rad/s] at one heading [rad]."""
    added, damping = radiation_at(hydro, omega)
    force = excitation_at(hydro, omega, np.array([heading]), low_frequency="hydrostatic")
    return HydroBatch(
        omega=omega, heading=np.array([heading]), added_mass=added[None], radiation_damping=damping[None], added_mass_zero=hydro.added_mass_zero[None],
        added_mass_infinite=hydro.added_mass_infinite[None], excitation=force[None],
    )  # fmt: skip


def space_of(study: OptimisationStudy, name: str, setting: Setting, reference: Reference) -> DesignSpace:
    """Return a space of the study; an anchor radius or line length that it does not vary follows the reference: the same radius,
    the length of equal surge stiffness at rest.
    """
    variables = study.spaces[name]
    varied = {v.name for v in variables}
    missing = [d for d in DIMENSIONS[:3] if d not in varied]
    if missing:
        raise ModelError(f"{study.path}: space {name!r} lacks {', '.join(missing)}; give equal bounds to hold a dimension")
    fixed = {} if "anchor_radius" in varied else {"anchor_radius": float(reference.design[3])}
    rule = None
    if "line_length" not in varied:
        stiffness = float(reference.batch.population.at_rest.stiffness[0, 0, 0])

        def rule(designs):
            return stiff_as(setting.hulls(*designs[:, :3].T), designs[:, 3], stiffness, line=setting.line, depth=setting.depth)

    return DesignSpace(variables=variables, fixed=fixed, length_rule=rule)


def batch_of(setting: Setting, designs: np.ndarray) -> Batch:
    """Return designs (N, 5) as a batch."""
    return make_batch(setting, *designs.T)


def shortfall(setting: Setting, designs: np.ndarray) -> np.ndarray:
    """Return how far the line of each design (N, 5) falls short of reaching, over the straight distance; 0 when it reaches."""
    straight = straight_distance(setting.hulls(*designs[:, :3].T), designs[:, 3], setting.depth)
    length = np.nan_to_num(designs[:, 4], nan=0.0)
    return np.maximum(0.0, 1.0005 - length / straight)
