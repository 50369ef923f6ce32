"""A design that was found, as a study and an OpenFAST deck of its own: the same numbers by the one-design path."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np

from fowtio.case import StateEntry
from fowtio.hull_deck import DeckPlan, Line, plain, write_deck
from fowtio.hull_system import HEADINGS, hull_members
from fowtio.hull_turbine import turbine_folder
from fowtio.optimise.run import OptimisationResult
from fowtio.optimise.setting import batch_of
from fowtio.write.atomic import atomic_folder
from fowtio.write.hydro import write_capytaine
from model.design.evaluate import Batch, Setting
from model.design.hull import hydrostatic_stiffness
from model.system.hydro import HydroCoefficients
from model.system.hydro_database import interpolate
from model.system.turbine import RigidBody


def export_design(result: OptimisationResult, name: str, design: np.ndarray, folder: str | Path) -> Path:
    """Write a design (5) [m] as deck and study into a folder and return the study file.

    The deck has platform values, members, WAMIT coefficients (seven digits) and moorings; the study names coefficients in double
    precision, the turbine's matrices, the states and frequencies of the search, so that `fowtio run` gives the search's numbers.
    """
    setting, folder = result.setting, Path(folder)
    batch = batch_of(setting, np.atleast_2d(design))
    hydro = design_hydro(setting, batch)
    plan = DeckPlan(
        name=name, title=f"{name}, found by fowtio optimise", turbine="dtu10mw", platform=_platform(batch), depth=setting.depth, hydro=hydro,
        members=hull_members(setting.hulls(*design[:3])), lines=_lines(setting, batch),
    )  # fmt: skip
    with atomic_folder(folder) as inside:
        study = write_deck(plan, inside)
        shutil.copyfile(turbine_folder() / "turbine.json", inside / "input" / "turbine.json")
        write_capytaine(hydro, inside / "input" / "hydro" / f"{name}.nc", body_name=name)
        hertz = "\n".join(plain(f) for f in setting.omega / (2 * np.pi))
        (inside / "input" / "frequencies.txt").write_text(f"! frequencies of the search [Hz]\n{hertz}\n", encoding="utf-8")
        study.write_text(_study(result, name, design), encoding="utf-8")
        (inside / "hull.toml").write_text(_hull_file(setting, name, batch), encoding="utf-8")
    return folder / f"{name}.fowt"


def design_hydro(setting: Setting, batch: Batch) -> HydroCoefficients:
    """Return the coefficients of one design at the frequencies of the search and headings all around, with its hydrostatics."""
    hull, floating, data = batch.hull, batch.population.floating, setting.database
    dimensions = [float(np.ravel(v)[0]) for v in (hull.diameter, hull.radius, hull.draft)]
    found = interpolate(data, dimensions, setting.omega, HEADINGS[::2], depth=setting.depth)
    return HydroCoefficients(
        omega=found.omega, added_mass=found.added_mass[0], radiation_damping=found.radiation_damping[0], added_mass_zero=found.added_mass_zero[0],
        added_mass_infinite=found.added_mass_infinite[0], heading=found.heading, excitation=found.excitation[0],
        hydrostatic_stiffness=hydrostatic_stiffness(floating, density=setting.density, gravity=setting.gravity)[0], volume=float(floating.volume[0]),
        centre_of_buoyancy=np.array([0.0, 0.0, float(floating.centre_of_buoyancy[0])]), density=setting.density, gravity=setting.gravity,
        depth=setting.depth,
    )  # fmt: skip


def _platform(batch: Batch) -> RigidBody:
    floating = batch.population.floating
    return RigidBody(
        mass=float(floating.mass[0]), centre=np.array([0.0, 0.0, float(floating.centre_of_mass[0])]), inertia=np.diag(floating.inertia[0])
    )


def _lines(setting: Setting, batch: Batch) -> list[Line]:
    mooring, line = batch.population.mooring, setting.line
    anchors, leads = (mooring.position[0, k : k + 3] for k in (0, 3))
    length = float(batch.population.length[0])
    return [
        Line(anchor=a, fairlead=f, length=length, mass=line.mass_per_length, diameter=line.diameter, stiffness=line.axial_stiffness)
        for a, f in zip(anchors, leads, strict=True)
    ]


def _study(result: OptimisationResult, name: str, design: np.ndarray) -> str:
    """Return the text of the study file: states as in the optimisation file."""
    d, r, draft, anchor, length = (plain(v) for v in design)
    states = result.study.states
    band = next((s.sea.band for s in states if s.sea.band is not None), None)
    noise = "".join(f"{plain(v):<16} {n:<13} - band of white noise (Hz)\n" for n, v in zip(("NoiseLow", "NoiseHigh"), band or (), strict=False))
    rows = "\n".join(_state_row(s) for s in states)
    return f"""------- FOWTIO STUDY FILE ------------------------------------------------------
DTU 10 MW on {name}: columns {d} m, radius {r} m, draft {draft} m, anchors at {anchor} m, lines {length} m
---------------------- MODEL ---------------------------------------------------
"input/{name}.fst"  Deck          - OpenFAST primary file (quoted string)
"input/hydro/{name}.nc"  HydroFile     - hydrodynamic coefficients in double precision; the deck's WAMIT files hold seven digits of them
"input/turbine.json"  TurbineFile   - matrices of the turbine by wind speed
7                DOFs          - six platform motions and the tower's first fore-aft mode
---------------------- LINEARISATIONS ------------------------------------------
0                NLin          - operating points with linearisation files
WindSpeed  LinFiles  LinDeck  MassMatrix
(m/s)      (-)       (-)      (-)
---------------------- SEA AND WIND STATES -------------------------------------
{len(states)}                NStates       - rows of the table
Name          WindSpeed  Turbulence  Spectrum     Hs        Tp    Gamma  WaveDir
(-)           (m/s)      (- or %)    (-)          (m)       (s)   (-)    (deg)
{rows}
---------------------- OPTIONS -------------------------------------------------
"input/frequencies.txt"  FreqFile      - frequencies of the search (Hz)
3e-9             DragTol       - as in the search
"relative"       DragModel     - as in the search
"hydrostatic"    LowFreqExctn  - excitation below the data: hold (lowest value, as HydroDyn) or hydrostatic (its limit)
{plain(result.setting.duration):<16} Duration      - time that expected extremes are given for (s)
{noise}END of study
"""


def _hull_file(setting: Setting, name: str, batch: Batch) -> str:
    """Return the hull for `fowtio bem`, which solves it afresh."""
    hull = batch.hull
    rows = [f"{n} = {plain(np.ravel(getattr(hull, n))[0])}" for n in ("diameter", "radius", "draft", "plate_ratio", "plate_height", "central_diameter")]
    return f"""# the hull of {name}, found by fowtio optimise; without pontoons and braces, as in the database of hulls
title = "{name}"
kind = "semi"
{chr(10).join(rows)}

[bem]
depth = {float(setting.depth)}
frequency_low = 0.05
frequency_high = 2.1
frequency_count = 42
headings = [0.0]
panel_size = 6.0
around = 14
braces = false
"""


def _state_row(state: StateEntry) -> str:
    sea, turbulence = state.sea, state.turbulence
    wind = "none" if turbulence is None else turbulence if isinstance(turbulence, str) else plain(100 * turbulence)
    cells = [plain(v) if v is not None else "-" for v in (sea.significant_height, sea.peak_period, sea.gamma)]
    spectrum = {"pierson_moskowitz": "pm"}.get(sea.kind, sea.kind)
    return f"{state.name:<13} {plain(state.wind_speed):<10} {wind:<11} {spectrum:<12} {cells[0]:<9} {cells[1]:<5} {cells[2]:<6} {plain(np.degrees(sea.heading))}"
