"""ElastoDyn input files (main, tower, blade) as the structure of a turbine."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fowtio.errors import FormatError
from fowtio.read.openfast_input import InputFile, read_input
from model.conventions import PLATFORM_DOFS
from model.system.tower import TOWER_MODES, Tower
from model.system.turbine import RigidBody, Rotor, TurbineStructure

_PLATFORM_FLAGS = ("PtfmSgDOF", "PtfmSwDOF", "PtfmHvDOF", "PtfmRDOF", "PtfmPDOF", "PtfmYDOF")
_TOWER_FLAGS = ("TwFADOF1", "TwFADOF2", "TwSSDOF1", "TwSSDOF2")


@dataclass(frozen=True, eq=False, kw_only=True)
class ElastoDyn:
    """What an ElastoDyn deck says: the structure, the degrees of freedom it switches on (our names), rotor speed [rad/s],
    blade pitch [rad], the files it is made of.
    """

    path: Path
    structure: TurbineStructure
    dofs: tuple[str, ...]
    rotor_speed: float
    blade_pitch: float
    files: tuple[Path, ...]


def read_elastodyn(path: str | Path, gravity: float) -> ElastoDyn:
    """Return an ElastoDyn deck with its tower and blade files; gravity [m/s2] from the primary file; raise FormatError."""
    deck = read_input(path)
    for name in ("PtfmRefxt", "PtfmRefyt", "PtfmRefzt"):
        if deck.number(name, 0.0) != 0.0:
            hint = "fowtio keeps the platform reference point at the tower axis and still water"
            raise FormatError(deck.path, deck.line(name), expected=f"{name} = 0", found=deck.text(name), hint=hint)
    tower_path = deck.path.parent / deck.text("TwrFile")
    blade_paths = [deck.path.parent / deck.text(f"BldFile({k + 1})" if deck.has(f"BldFile({k + 1})") else f"BldFile{k + 1}")
                   for k in range(deck.integer("NumBl"))]  # fmt: skip
    structure = TurbineStructure(
        tower=_tower(deck, read_input(tower_path)),
        nacelle=_nacelle(deck),
        rotor=_rotor(deck, [read_input(p) for p in dict.fromkeys(blade_paths)]),
        platform=_platform(deck),
        accelerometer=[deck.number(n, 0.0) for n in ("NcIMUxn", "NcIMUyn", "NcIMUzn")],
        gravity=gravity,
    )
    on = [name for name, flag in zip(PLATFORM_DOFS, _PLATFORM_FLAGS, strict=True) if deck.flag(flag)]
    on += [name for name, flag in zip(TOWER_MODES, _TOWER_FLAGS, strict=True) if deck.flag(flag)]
    return ElastoDyn(
        path=deck.path, structure=structure, dofs=tuple(on), rotor_speed=deck.number("RotSpeed") * np.pi / 30,
        blade_pitch=np.radians(deck.number("BlPitch(1)")), files=(deck.path, tower_path, *dict.fromkeys(blade_paths)),
    )  # fmt: skip


def _tower(deck: InputFile, tower: InputFile) -> Tower:
    table = tower.table(header="HtFract", rows=tower.integer("NTwInpSt"))
    groups = ("TwFAM1Sh", "TwFAM2Sh", "TwSSM1Sh", "TwSSM2Sh")
    modes = np.array([[tower.number(f"{group}({k})") for k in range(2, 7)] for group in groups])
    for group, row in zip(groups, modes, strict=True):
        if abs(row.sum() - 1) > 1e-3:
            raise FormatError(
                tower.path, tower.line(f"{group}(2)"), expected=f"coefficients of {group} that sum to 1", found=f"{row.sum():g}"
            )  # fmt: skip
    damping = [tower.number(f"Twr{d}Dmp({k})") / 100 for d in ("FA", "SS") for k in (1, 2)]
    tuner = [tower.number(f"{d}StTunr({k})", 1.0) for d in ("FA", "SS") for k in (1, 2)]
    return Tower(
        base_height=deck.number("TowerBsHt"), top_height=deck.number("TowerHt"), station=table.numbers("HtFract"),
        mass_density=_positive(table, "TMassDen") * tower.number("AdjTwMa", 1.0),
        stiffness_fa=_positive(table, "TwFAStif") * tower.number("AdjFASt", 1.0),
        stiffness_ss=_positive(table, "TwSSStif") * tower.number("AdjSSSt", 1.0),
        modes=modes, damping_ratio=damping, stiffness_tuner=tuner, nodes=deck.integer("TwrNodes"),
    )  # fmt: skip


def _positive(table, name: str) -> np.ndarray:
    values = table.numbers(name)
    if np.any(values <= 0):
        k = int(np.argmax(values <= 0))
        raise FormatError(table.path, table.numbers_of_lines[k], expected=f"{name} above zero", found=f"{values[k]:g}")
    return values


def _nacelle(deck: InputFile) -> RigidBody:
    """The nacelle's mass and its yaw inertia, which the file gives about the yaw axis; the yaw bearing sits on the tower top."""
    mass, bearing = deck.number("NacMass"), deck.number("YawBrMass", 0.0)
    centre = np.array([deck.number(n) for n in ("NacCMxn", "NacCMyn", "NacCMzn")])
    yaw = deck.number("NacYIner") - mass * (centre[0] ** 2 + centre[1] ** 2)
    if yaw < 0:
        raise FormatError(
            deck.path, deck.line("NacYIner"), expected=f"at least {deck.number('NacYIner') - yaw:.4g} (mass times offset squared)",
            found=deck.text("NacYIner"),
        )  # fmt: skip
    total = mass + bearing
    joint = mass * centre / total if total > 0 else centre
    spread = mass * (centre - joint)[:, None] * (centre - joint) + bearing * joint[:, None] * joint
    return RigidBody(mass=total, centre=joint, inertia=np.diag([0, 0, yaw]) + np.trace(spread) * np.eye(3) - spread)


def _rotor(deck: InputFile, blades: list[InputFile]) -> Rotor:
    if len(blades) > 1:
        raise FormatError(deck.path, deck.line("BldFile(2)"), expected="the same blade file for all blades", found=deck.text("BldFile(2)"))
    hub_radius, tip_radius, nodes = deck.number("HubRad"), deck.number("TipRad"), deck.integer("BldNodes")
    blade = blades[0]
    table = blade.table(header="BlFract", rows=blade.integer("NBlInpSt"))
    density = table.numbers("BMassDen") * blade.number("AdjBlMs", 1.0)
    x = (np.arange(nodes) + 0.5) / nodes
    step = (tip_radius - hub_radius) / nodes
    tilt = np.radians(deck.number("ShftTilt"))
    overhang = deck.number("OverHang")
    return Rotor(
        blades=deck.integer("NumBl"), tilt=tilt, cone=np.radians(deck.number("PreCone(1)")),
        apex=[overhang * np.cos(tilt), 0.0, deck.number("Twr2Shft") + overhang * np.sin(tilt)],
        hub_mass=deck.number("HubMass"), hub_inertia=deck.number("HubIner"), hub_offset=deck.number("HubCM"),
        node_radius=np.append(hub_radius + x * (tip_radius - hub_radius), tip_radius),
        node_mass=np.append(np.interp(x, table.numbers("BlFract"), density) * step, deck.number("TipMass(1)", 0.0)),
        diameter=2 * tip_radius * np.cos(np.radians(deck.number("PreCone(1)"))),
    )  # fmt: skip


def _platform(deck: InputFile) -> RigidBody:
    inertia = np.diag([deck.number(n) for n in ("PtfmRIner", "PtfmPIner", "PtfmYIner")])
    for name, (i, j) in {"PtfmXYIner": (0, 1), "PtfmYZIner": (1, 2), "PtfmXZIner": (0, 2)}.items():
        inertia[i, j] = inertia[j, i] = deck.number(name, 0.0)
    centre = [deck.number(n) for n in ("PtfmCMxt", "PtfmCMyt", "PtfmCMzt")]
    return RigidBody(mass=deck.number("PtfmMass"), centre=centre, inertia=inertia)
