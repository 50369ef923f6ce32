"""The reference hulls as ready studies: OC3 spar, ITI barge, MIT/NREL tension-leg platform, 10 MW semisubmersibles.

Numbers from the definitions of these platforms; the three 5 MW hulls carry the turbine and tower of OC3 and OC4 (base 10 m above
still water), whose linearisations come with the embedded case.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from fowtio.errors import ModelError
from fowtio.hull_deck import STORM, DeckPlan, Line, Member, write_deck
from fowtio.hull_system import CHAIN, WIRE, SemiDesign, design_deck, length_for_stiffness, thesis_hull
from fowtio.hull_turbine import reference_folder
from fowtio.read.openfast_deck import deck_hydro, read_deck
from fowtio.start import require_empty
from fowtio.write.atomic import atomic_folder
from model.design.hull import OC4, upscaled
from model.system.hydro import HydroCoefficients
from model.system.turbine import RigidBody

LINEARISATIONS = ((8.0, "U08"), (11.0, "U11"), (11.4, "U11p4"), (14.0, "U14"), (18.0, "U18"), (24.0, "U24"))
OC4_SURGE_STIFFNESS = 7.08e4
OPERATION = ("operating", 11.0, "B", "jonswap", 4.0, 9.0)
TUSCANY = (("rated", 11.0, "B", "jonswap", 4.93, 8.68), ("cut_out", 25.0, "B", "jonswap", 7.14, 10.47), STORM)
SARDINIA = (("rated", 11.0, "B", "jonswap", 5.60, 9.98), ("cut_out", 25.0, "B", "jonswap", 8.62, 12.11), STORM)
"""50-year seas of the thesis's table 28 at 11 and 25 m/s, and a parked storm."""


def _body(mass: float, height: float, roll: float, pitch: float, yaw: float) -> RigidBody:
    return RigidBody(mass=mass, centre=np.array([0.0, 0.0, height]), inertia=np.diag([roll, pitch, yaw]))


def _around(angles, inner: float, top: float, outer: float, bottom: float, *, lead_angles=None, **line) -> list[Line]:
    """Return lines from fairleads (radius inner, elevation top) to anchors (radius outer, elevation bottom) at angles [deg]."""
    out = []
    for a, b in zip(np.radians(angles), np.radians(angles if lead_angles is None else lead_angles), strict=True):
        out.append(Line(
            anchor=np.array([outer * np.cos(a), outer * np.sin(a), bottom]), fairlead=np.array([inner * np.cos(b), inner * np.sin(b), top]), **line
        ))  # fmt: skip
    return out


def oc3_spar(hydro: HydroCoefficients) -> DeckPlan:
    """Return the OC3-Hywind spar. Source: J. Jonkman 2010, NREL/TP-500-47535."""
    stiffness, damping = np.zeros((2, 6, 6))
    stiffness[5, 5] = 9.834e7
    damping[range(6), range(6)] = [1e5, 1e5, 1.3e5, 0.0, 0.0, 1.3e7]
    z = np.array([0.0, 0.0, 1.0])
    shape = ((-120.0, -12.0, 9.4), (-12.0, -4.0, 7.95), (-4.0, 2.0, 6.5))
    members = [
        Member(name=f"spar {k}", start=a * z, end=b * z, diameter=d, drag=0.6)
        for k, (a, b, d) in enumerate(shape, start=1)
    ]
    return DeckPlan(
        name="oc3", title="the OC3-Hywind spar, 320 m", turbine="nrel5mw", platform=_body(7.46633e6, -89.9155, 4.22923e9, 4.22923e9, 1.6423e8),
        hydro=hydro, members=members, depth=320.0, added_stiffness=stiffness, added_damping=damping, linearisations=LINEARISATIONS, states=(OPERATION, STORM),
        published=(("pitch", 29.4),),
        lines=_around([180.0, 60.0, -60.0], 5.2, -70.0, 853.87, -320.0, length=902.2, mass=77.7066, diameter=0.09, stiffness=3.84243e8),
    )  # fmt: skip


def iti_barge(hydro: HydroCoefficients) -> DeckPlan:
    """Return the ITI Energy barge; two lines a corner, 45 degrees apart. Source: J. Jonkman 2007, NREL/TP-500-41958.

    Anchors as in OpenFAST's r-test (5MW_ITIBarge_DLL_WTurb_WavesIrr), 386.92 and 171.98 m from the axes. The volume is 6000 m3 (with
    the moonpool), the coefficients those of the closed barge, as in the model in common use.
    """
    corners = np.repeat([45.0, 135.0, 225.0, 315.0], 2)
    anchors = corners + np.tile([-21.0356, 21.0356], 4)
    z = np.array([0.0, 0.0, 1.0])
    member = Member(name="bottom", start=-4.0 * z, end=-3.0 * z, diameter=40.0, drag=0.0)
    return DeckPlan(
        name="iti", title="the ITI Energy barge, 150 m", turbine="nrel5mw", platform=_body(5.452e6, -0.281768, 7.269e8, 7.269e8, 1.45393e9),
        hydro=replace(hydro, volume=6000.0), members=[member], depth=150.0, linearisations=LINEARISATIONS, states=(OPERATION, STORM),
        hull_file="iti_barge/hull.toml", published=(("surge", 131.0), ("heave", 7.8), ("pitch", 11.9)),
        lines=_around(anchors, 28.2843, -4.0, 423.42, -150.0, lead_angles=corners, length=473.312, mass=130.403, diameter=0.0809, stiffness=5.89e8),
    )  # fmt: skip


def mit_tlp(hydro: HydroCoefficients) -> DeckPlan:
    """Return the MIT/NREL tension-leg platform. Source: D. Matha 2010, NREL/SR-500-45891."""
    z = np.array([0.0, 0.0, 1.0])
    member = Member(name="column", start=-47.89 * z, end=2.0 * z, diameter=18.0, drag=0.6)
    angles = np.repeat([0.0, 90.0, 180.0, 270.0], 2)
    return DeckPlan(
        name="tlp", title="the MIT/NREL tension-leg platform, 200 m", turbine="nrel5mw", platform=_body(8.6e6, -40.612, 5.716e8, 5.716e8, 3.614e8),
        hydro=hydro, members=[member], depth=200.0, linearisations=LINEARISATIONS, states=(OPERATION, STORM),
        published=(("surge", 60.6), ("heave", 2.3), ("pitch", 4.5), ("yaw", 10.3)),
        lines=_around(angles, 27.0, -47.89, 27.0, -200.0, length=151.73, mass=116.027, diameter=0.127, stiffness=1.5e9),
    )  # fmt: skip


def semi_designs() -> dict[str, SemiDesign]:
    """Return the 10 MW semisubmersibles: the upscaled one, and the thesis's optima (tables 31, 34, 38) with their lines.

    The upscaled one has OC4's anchor radius and the line length that gives OC4's surge stiffness.
    """
    big = replace(upscaled(OC4, 2.0, central_diameter=8.3), ballast_density=np.array(2400.0))
    up = SemiDesign(hull=big, anchor_radius=837.6, length=835.0, line=CHAIN, name="semi_10mw")
    return {
        "semi_10mw": length_for_stiffness(up, OC4_SURGE_STIFFNESS),
        "table31": SemiDesign(
            hull=thesis_hull(20.0, 45.0, 31.5), anchor_radius=840.0, length=825.0, line=CHAIN, name="table31"
        ),
        "table34": SemiDesign(
            hull=thesis_hull(14.5, 44.5, 24.0), anchor_radius=850.0, length=845.0, line=CHAIN, name="table34"
        ),
        "table38": SemiDesign(
            hull=thesis_hull(14.0, 45.0, 24.5),
            anchor_radius=810.0,
            length=840.0,
            depth=370.0,
            line=WIRE,
            name="table38",
        ),
    }


TITLES = {
    "semi_10mw": "the upscaled OC4 semisubmersible", "table31": "the optimum of table 31", "table34": "the optimum of table 34",
    "table38": "the optimum of table 38",
}  # fmt: skip
MAKERS = {"oc3_spar": oc3_spar, "iti_barge": iti_barge, "mit_tlp": mit_tlp}
REFERENCES = (*MAKERS, *TITLES)


def write_reference(name: str, folder: str | Path, hydro: HydroCoefficients | None = None) -> Path:
    """Write one of REFERENCES as a study into a folder and return its study file; raise ModelError for another name.

    hydro replaces its coefficients: those that come with fowtio, of the optima those of the database.
    """
    if name not in REFERENCES:
        raise ModelError(f"no reference study {name!r}; there are {', '.join(REFERENCES)}")
    if hydro is None and not name.startswith("table"):
        hydro = _stored(name)
    if name in MAKERS:
        return write_deck(MAKERS[name](hydro), folder)
    states = SARDINIA if name == "table38" else TUSCANY
    return design_deck(semi_designs()[name], folder, title=TITLES[name], hydro=hydro, states=states)


def start_reference(name: str, folder: str | Path, hydro: str | Path | None = None) -> Path:
    """Write a reference study into a new or empty folder and return its study file; hydro names coefficients to put into it."""
    folder = require_empty(folder)
    with atomic_folder(folder) as temporary:
        study = write_reference(name, temporary, None if hydro is None or name not in REFERENCES else _stored(name, hydro))
    return folder / study.name


def _stored(name: str, hydro: str | Path | None = None) -> HydroCoefficients:
    """Return the coefficients of a reference study's deck, or others in its water."""
    folder = reference_folder(f"thesis_optima/{name}" if name.startswith("table") else name)
    return deck_hydro(read_deck(next((folder / "input").glob("*.fst"))), None if hydro is None else Path(hydro))
