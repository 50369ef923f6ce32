"""ElastoDyn input files (main, tower, blade) as the structure of a turbine."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fowtio.errors import FormatError
from fowtio.read.openfast_input import InputFile, Table, read_input
from model.conventions import PLATFORM_DOFS
from model.system.tower import TOWER_MODES, Tower
from model.system.turbine import RigidBody, Rotor, TurbineStructure

_PLATFORM_FLAGS = ("PtfmSgDOF", "PtfmSwDOF", "PtfmHvDOF", "PtfmRDOF", "PtfmPDOF", "PtfmYDOF")
_TOWER_FLAGS = ("TwFADOF1", "TwFADOF2", "TwSSDOF1", "TwSSDOF2")


@dataclass(frozen=True, eq=False, kw_only=True)
class ElastoDyn:
    """What an ElastoDyn deck says: the structure, the degrees of freedom it switches on (our names), rotor speed
    [rad/s], blade pitch [rad], the files it is made of.
    """

    path: Path
    structure: TurbineStructure
    dofs: tuple[str, ...]
    rotor_speed: float
    blade_pitch: float
    files: tuple[Path, ...]


def read_elastodyn(path: str | Path, gravity: float) -> ElastoDyn:
    """Return an ElastoDyn deck with its tower and blade files; gravity [m/s2] is given; raise FormatError."""
    deck = read_input(path)
    for name in ("PtfmRefxt", "PtfmRefyt", "PtfmRefzt"):
        if deck.has(name) and deck.number(name) != 0.0:
            hint = "fowtio keeps the platform reference point at the tower axis and still water"
            raise FormatError(deck.path, deck.line(name), expected=f"{name} = 0", found=deck.text(name), hint=hint)
    blades = deck.integer("NumBl")
    if not 1 <= blades <= 3:
        raise FormatError(deck.path, deck.line("NumBl"), expected="1 to 3 blades", found=deck.text("NumBl"))
    tower_path = deck.file("TwrFile")
    names = [f"BldFile({k + 1})" if deck.has(f"BldFile({k + 1})") else f"BldFile{k + 1}" for k in range(blades)]
    blade_paths = [deck.file(name) for name in names]
    for name, other in zip(names, blade_paths, strict=True):
        if other != blade_paths[0]:
            raise FormatError(
                deck.path, deck.line(name), expected="the same blade file for all blades", found=deck.text(name)
            )
    structure = TurbineStructure(
        tower=_tower(deck, read_input(tower_path)),
        nacelle=_nacelle(deck),
        rotor=_rotor(deck, read_input(blade_paths[0])),
        platform=_platform(deck),
        accelerometer=[deck.number(n) for n in ("NcIMUxn", "NcIMUyn", "NcIMUzn")],
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
    _ascending(table, "HtFract")
    if not deck.number("TowerBsHt") < deck.number("TowerHt"):
        line = deck.line("TowerHt")
        raise FormatError(
            deck.path,
            line,
            expected=f"TowerHt above TowerBsHt ({deck.number('TowerBsHt'):g})",
            found=deck.text("TowerHt"),
        )
    if not 1 <= deck.integer("TwrNodes") <= 10_000:
        raise FormatError(
            deck.path, deck.line("TwrNodes"), expected="1 to 10000 tower nodes", found=deck.text("TwrNodes")
        )
    groups = ("TwFAM1Sh", "TwFAM2Sh", "TwSSM1Sh", "TwSSM2Sh")
    modes = np.array([[tower.number(f"{group}({k})") for k in range(2, 7)] for group in groups])
    for group, row in zip(groups, modes, strict=True):
        if abs(row.sum() - 1) > 1e-3:
            raise FormatError(
                tower.path,
                tower.line(f"{group}(2)"),
                expected=f"coefficients of {group} that sum to 1",
                found=f"{row.sum():g}",
            )
    damping = [tower.number(f"Twr{d}Dmp({k})") / 100 for d in ("FA", "SS") for k in (1, 2)]
    tuner = [tower.number(f"{d}StTunr({k})") for d in ("FA", "SS") for k in (1, 2)]
    return Tower(
        base_height=deck.number("TowerBsHt"), top_height=deck.number("TowerHt"), station=table.numbers("HtFract"),
        mass_density=_positive(table, "TMassDen") * tower.number("AdjTwMa"),
        stiffness_fa=_positive(table, "TwFAStif") * tower.number("AdjFASt"),
        stiffness_ss=_positive(table, "TwSSStif") * tower.number("AdjSSSt"),
        modes=modes, damping_ratio=damping, stiffness_tuner=tuner, nodes=deck.integer("TwrNodes"),
    )  # fmt: skip


def _ascending(table: Table, name: str) -> None:
    """Refuse a table of distributed properties whose stations do not go from 0 to 1."""
    values = table.numbers(name)
    if len(values) < 2:
        at = table.numbers_of_lines[0] if len(table) else None
        raise FormatError(table.path, at, expected=f"two rows or more in the table of {name}", found=str(len(values)))
    if abs(values[0]) > 1e-6 or abs(values[-1] - 1) > 1e-6:
        raise FormatError(
            table.path,
            table.numbers_of_lines[0],
            expected=f"{name} from 0 to 1",
            found=f"{values[0]:g} to {values[-1]:g}",
        )
    steps = np.diff(values)
    if np.any(steps < 0):
        k = int(np.argmax(steps < 0)) + 1
        raise FormatError(table.path, table.numbers_of_lines[k], expected=f"ascending {name}", found=f"{values[k]:g}")


def _positive(table: Table, name: str) -> np.ndarray:
    values = table.numbers(name)
    if np.any(values <= 0):
        k = int(np.argmax(values <= 0))
        raise FormatError(table.path, table.numbers_of_lines[k], expected=f"{name} above zero", found=f"{values[k]:g}")
    return values


def _nacelle(deck: InputFile) -> RigidBody:
    """Return nacelle and yaw bearing, on the tower top, as one body; the file's yaw inertia is about the yaw axis."""
    mass, bearing = deck.number("NacMass"), deck.number("YawBrMass")
    centre = np.array([deck.number(n) for n in ("NacCMxn", "NacCMyn", "NacCMzn")])
    yaw = deck.number("NacYIner") - mass * (centre[0] ** 2 + centre[1] ** 2)
    if yaw < 0:
        raise FormatError(
            deck.path,
            deck.line("NacYIner"),
            expected=f"at least {deck.number('NacYIner') - yaw:.4g} (mass times offset squared)",
            found=deck.text("NacYIner"),
        )
    total = mass + bearing
    joint = mass * centre / total if total > 0 else centre
    spread = mass * (centre - joint)[:, None] * (centre - joint) + bearing * joint[:, None] * joint
    return RigidBody(mass=total, centre=joint, inertia=np.diag([0, 0, yaw]) + np.trace(spread) * np.eye(3) - spread)


def _rotor(deck: InputFile, blade: InputFile) -> Rotor:
    hub_radius, tip_radius, nodes = deck.number("HubRad"), deck.number("TipRad"), deck.integer("BldNodes")
    if not 0 <= hub_radius < tip_radius:
        raise FormatError(
            deck.path, deck.line("TipRad"), expected=f"TipRad above HubRad ({hub_radius:g})", found=deck.text("TipRad")
        )
    if not 1 <= nodes <= 10_000:
        raise FormatError(
            deck.path, deck.line("BldNodes"), expected="1 to 10000 blade nodes", found=deck.text("BldNodes")
        )
    for k in range(2, deck.integer("NumBl") + 1):
        for name in ("PreCone", "TipMass"):
            if deck.number(f"{name}({k})") != deck.number(f"{name}(1)"):
                line = deck.line(f"{name}({k})")
                raise FormatError(
                    deck.path, line, expected=f"equal {name} of all blades", found=deck.text(f"{name}({k})")
                )
    table = blade.table(header="BlFract", rows=blade.integer("NBlInpSt"))
    _ascending(table, "BlFract")
    density = table.numbers("BMassDen") * blade.number("AdjBlMs")
    x = (np.arange(nodes) + 0.5) / nodes
    step = (tip_radius - hub_radius) / nodes
    tilt = np.radians(deck.number("ShftTilt"))
    overhang = deck.number("OverHang")
    return Rotor(
        blades=deck.integer("NumBl"), tilt=tilt, cone=np.radians(deck.number("PreCone(1)")),
        apex=[overhang * np.cos(tilt), 0.0, deck.number("Twr2Shft") + overhang * np.sin(tilt)],
        hub_mass=deck.number("HubMass"), hub_inertia=deck.number("HubIner"), hub_offset=deck.number("HubCM"),
        node_radius=np.append(hub_radius + x * (tip_radius - hub_radius), tip_radius),
        node_mass=np.append(np.interp(x, table.numbers("BlFract"), density) * step, deck.number("TipMass(1)")),
        diameter=2 * tip_radius * np.cos(np.radians(deck.number("PreCone(1)"))),
    )  # fmt: skip


def _platform(deck: InputFile) -> RigidBody:
    inertia = np.diag([deck.number(n) for n in ("PtfmRIner", "PtfmPIner", "PtfmYIner")])
    for name, (i, j) in {"PtfmXYIner": (0, 1), "PtfmYZIner": (1, 2), "PtfmXZIner": (0, 2)}.items():
        inertia[i, j] = inertia[j, i] = deck.number(name, 0.0)
    centre = [deck.number(n) for n in ("PtfmCMxt", "PtfmCMyt", "PtfmCMzt")]
    return RigidBody(mass=deck.number("PtfmMass"), centre=centre, inertia=inertia)
