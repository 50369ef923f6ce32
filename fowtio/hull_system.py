"""A semisubmersible of a few numbers as a complete 10 MW system: hull, database coefficients, moorings, turbine at any wind speed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from fowtio.database import read_database
from fowtio.errors import ModelError
from fowtio.hull_deck import STORM, DeckPlan, Line, Member, write_deck
from fowtio.hull_turbine import carried, ten_megawatt
from model.conventions import PLATFORM_DOFS, TOWER_FORE_AFT
from model.design.hull import (
    FloatingHull,
    SemiHull,
    float_hull,
    hydrostatic_stiffness,
    platform_body,
    three_line_mooring,
)
from model.design.hull_drag import DRAG, drag_members, wetted_members
from model.design.population import LineType, stiff_as
from model.response.assemble import System, assemble
from model.system.contributions import hydrostatic_contribution, platform_contribution, turbine_contribution
from model.system.hydro import HydroCoefficients
from model.system.hydro_database import HydroDatabase, interpolate
from model.system.mooring import MooringSystem, mooring_state

GRAVITY = 9.80665
CHAIN = {"mass_per_length": 226.7, "diameter": 0.1083, "axial_stiffness": 1.507e9}
WIRE = {"mass_per_length": 76.5, "diameter": 0.1215, "axial_stiffness": 1.353e9}
OMEGA = np.concatenate([np.arange(1, 41) * 0.0125, 0.5 + np.arange(1, 85) * 0.025])
HEADINGS = np.radians(np.arange(-180.0, 181.0, 15.0))
OPERATING = (("rated", 11.4, "B", "jonswap", 4.0, 9.0), ("cut_out", 25.0, "B", "jonswap", 7.0, 12.0), STORM)


@dataclass(frozen=True, eq=False, kw_only=True)
class SemiDesign:
    """One semisubmersible with its three lines: hull, anchor_radius and line length [m], depth [m], line (mass_per_length [kg/m],
    diameter [m], axial_stiffness [N]).

    CHAIN is OC4's chain with twice its section, as the thrust is twice; WIRE a spiral strand of 0.1215 m.
    """

    hull: SemiHull
    anchor_radius: float
    length: float
    depth: float = 200.0
    line: dict | None = None
    name: str = "semi"

    def mooring(self) -> MooringSystem:
        """Return the three lines."""
        return three_line_mooring(
            self.hull,
            anchor_radius=self.anchor_radius,
            length=self.length,
            depth=self.depth,
            gravity=GRAVITY,
            **(self.line or CHAIN),
        )

    def floating(self) -> FloatingHull:
        """Return the hull ballasted under the 10 MW turbine and the lines' pull at rest; raise ModelError when it cannot float."""
        mass, height = carried(ten_megawatt(0.0))
        try:
            pull = -float(mooring_state(self.mooring(), np.zeros(6)).force[2])
            return float_hull(self.hull, carried_mass=mass, carried_height=height, mooring_pull=pull)
        except ValueError as error:
            raise ModelError(f"{self.name}: {error}") from None


def thesis_hull(diameter: float, radius: float, draft: float) -> SemiHull:
    """Return a hull of the family of the database: heave plates twice the column's diameter and 6 m high, central column 8.3 m."""
    return SemiHull(diameter=diameter, radius=radius, draft=draft)


def semi_hydro(
    floating: FloatingHull, depth: float, *, database: HydroDatabase | None = None, omega=OMEGA, heading=HEADINGS
) -> HydroCoefficients:
    """Return the coefficients of one hull from the database, with its hydrostatics (pontoons and braces included there only)."""
    hull, data = floating.hull, database or read_database()
    for name, value in (("plate_ratio", 2.0), ("plate_height", 6.0), ("central_diameter", 8.3)):
        if abs(float(getattr(hull, name)) - value) > 1e-6:
            raise ModelError(
                f"{name} is {float(getattr(hull, name)):g}, the database holds hulls with {value:g}; solve this one with fowtio bem"
            )
    try:
        batch = interpolate(data, [hull.diameter, hull.radius, hull.draft], omega, heading, depth=depth)
    except ValueError as error:
        raise ModelError(str(error)) from None
    return HydroCoefficients(
        omega=batch.omega, added_mass=batch.added_mass[0], radiation_damping=batch.radiation_damping[0], added_mass_zero=batch.added_mass_zero[0],
        added_mass_infinite=batch.added_mass_infinite[0], heading=batch.heading, excitation=batch.excitation[0],
        hydrostatic_stiffness=hydrostatic_stiffness(floating), volume=float(floating.volume),
        centre_of_buoyancy=np.array([0.0, 0.0, float(floating.centre_of_buoyancy)]), density=data.density, gravity=data.gravity, depth=depth,
    )  # fmt: skip


def semi_system(
    design: SemiDesign, wind_speed: float = 0.0, *, database: HydroDatabase | None = None, hydro: HydroCoefficients | None = None,
    dofs=(*PLATFORM_DOFS, TOWER_FORE_AFT),
) -> System:  # fmt: skip
    """Return the assembled model of a design with the 10 MW turbine, parked (0) or at 4 to 25 m/s."""
    floating, turbine = design.floating(), ten_megawatt(wind_speed)
    hydro = hydro or semi_hydro(floating, design.depth, database=database)
    parts = [
        turbine_contribution(turbine), platform_contribution(platform_body(floating), GRAVITY, "parametric hull"),
        hydrostatic_contribution(hydro, "parametric hull"),
    ]  # fmt: skip
    return assemble(dofs, turbine, parts, hydro, drag_members(design.hull), design.mooring())


def length_for_stiffness(design: SemiDesign, stiffness: float) -> SemiDesign:
    """Return the design with the line length at which the surge stiffness at rest [N/m] is the one given (shorter is stiffer)."""
    line = LineType(**(design.line or CHAIN))
    length = float(stiff_as(design.hull, design.anchor_radius, stiffness, line=line, depth=design.depth, gravity=GRAVITY))
    if np.isnan(length):
        raise ModelError(
            f"no line length gives a surge stiffness of {stiffness:g} N/m at an anchor radius of {design.anchor_radius:g} m"
        )
    return replace(design, length=length)


def design_deck(
    design: SemiDesign, folder: str | Path, *, title: str, hydro: HydroCoefficients | None = None, states=OPERATING
) -> Path:  # fmt: skip
    """Write an OpenFAST deck and a study of a design into a folder and return the study file.

    states are those of the study beside a parked one in white noise, as in DeckPlan.
    """
    floating = design.floating()
    hull, system = design.hull, design.mooring()
    anchor, lead = (np.asarray(system.position)[k : k + 3] for k in (0, 3))
    line = design.line or CHAIN
    plan = DeckPlan(
        name=design.name, title=title, turbine="dtu10mw", platform=platform_body(floating), depth=design.depth,
        hydro=hydro or semi_hydro(floating, design.depth, omega=OMEGA[1::2], heading=HEADINGS[::2]), members=hull_members(hull),
        lines=[
            Line(anchor=a, fairlead=f, length=design.length, mass=line["mass_per_length"], diameter=line["diameter"], stiffness=line["axial_stiffness"])
            for a, f in zip(anchor, lead, strict=True)
        ],
        states=states,
    )  # fmt: skip
    return write_deck(plan, folder)


def hull_members(hull: SemiHull, drag: dict = DRAG) -> list[Member]:
    """Return the strip members of a hull for a deck; those that end at still water but for braces go on 2 m above it."""
    out = []
    for m in wetted_members(hull, drag):
        above = 2.0 if m.end[2] == 0 and m.start[0] == m.end[0] else 0.0
        out.append(
            Member(
                name=m.name, start=m.start, end=m.end + [0.0, 0.0, above], diameter=float(m.diameter), drag=m.drag, axial_drag=m.axial_drag
            )
        )
    return out
