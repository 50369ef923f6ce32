"""The turbine on its tower as matrices in the platform's motions and the tower's modes: from structural data."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.conventions import PLATFORM_DOFS, freeze, point_motion, rigid_mass, rotation, weight_stiffness
from model.environment.rotor_wind import RotorSensitivity
from model.system.tower import TOWER_MODES, Tower, TowerModes, tower_modes


@dataclass(frozen=True, eq=False, kw_only=True)
class RigidBody:
    """A rigid body: mass [kg], centre of mass (3) [m], inertia (3, 3) about it [kg m2]."""

    mass: float
    centre: np.ndarray
    inertia: np.ndarray

    def __post_init__(self):
        freeze(self, centre=(3,), inertia=(3, 3))


@dataclass(frozen=True, eq=False, kw_only=True)
class Rotor:
    """Rotor geometry and masses: blades (number); apex (3) [m from the tower top]; tilt, cone [rad, ElastoDyn's signs];
    hub_mass [kg], hub_inertia [kg m2] about the shaft, hub_offset [m] of its mass from the apex; blade nodes' radius (b) [m
    from the apex] and mass (b) [kg], tip included; diameter [m].
    """

    blades: int
    apex: np.ndarray
    tilt: float
    cone: float
    hub_mass: float
    hub_inertia: float
    hub_offset: float
    node_radius: np.ndarray
    node_mass: np.ndarray
    diameter: float

    def __post_init__(self):
        freeze(self, apex=(3,), node_radius=("b",), node_mass=("b",))


@dataclass(frozen=True, eq=False, kw_only=True)
class TurbineStructure:
    """Everything a deck says of a turbine's structure: tower, nacelle (about the tower top), rotor, platform body
    (about the reference point), position of the nacelle's accelerometer from the tower top, gravity [m/s2].
    """

    tower: Tower
    nacelle: RigidBody
    rotor: Rotor
    platform: RigidBody
    accelerometer: np.ndarray
    gravity: float

    def __post_init__(self):
        freeze(self, accelerometer=(3,))

    @property
    def hub_height(self) -> float:
        """Height of the hub above still water [m]."""
        return self.tower.top_height + float(self.rotor.apex[2])


@dataclass(frozen=True, eq=False, kw_only=True)
class TurbineMatrices:
    """The turbine (tower and what it carries, no platform) in its degrees of freedom, about the platform reference point.

    dofs (q) names; mass, damping, stiffness (q, q); force (q) [N, N m] that it exerts at `point` (q), weight and thrust;
    wind_force (q) per m/s of wind over the whole rotor; gradient_force (2, q) per (m/s)/m of its vertical and lateral
    gradient, zero when not given; wind_speed [m/s]; rotor_speed [rad/s]; source; sampling, how strongly each radius drives the
    thrust, None when not known.
    """

    dofs: tuple[str, ...]
    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    force: np.ndarray
    point: np.ndarray
    wind_force: np.ndarray
    gradient_force: np.ndarray | None = None
    wind_speed: float = 0.0
    rotor_speed: float = 0.0
    source: str = ""
    sampling: RotorSensitivity | None = None

    def __post_init__(self):
        q = len(self.dofs)
        if self.gradient_force is None:
            object.__setattr__(self, "gradient_force", np.zeros((2, q)))
        freeze(
            self, mass=(q, q), damping=(q, q), stiffness=(q, q), force=(q,), point=(q,), wind_force=(q,), gradient_force=(2, q),
        )  # fmt: skip


def gradient_forces(structure: TurbineStructure, turbine: TurbineMatrices, arm: float) -> np.ndarray:
    """Return the generalised forces (2, q) per (m/s)/m of the wind's vertical and lateral gradient over the rotor.

    A blade element at radius r and azimuth psi lies r cos(psi) above the hub; its thrust makes a tilt moment, and in the same
    way a yaw moment. arm [m2] is the moment of a unit gradient over the thrust of a unit wind.
    """
    modes = tuple(d for d in turbine.dofs if d in TOWER_MODES)
    motion = head_motion(structure.tower.top_height, tower_modes(structure.tower, modes), structure.rotor.apex)
    known = PLATFORM_DOFS + modes
    tilt = structure.rotor.tilt
    thrust = turbine.wind_force[turbine.dofs.index("surge")] / np.cos(tilt) if "surge" in turbine.dofs else 0.0
    rotations = np.stack([motion[4], -np.sin(tilt) * motion[3] + np.cos(tilt) * motion[5]])
    out = np.zeros((2, len(turbine.dofs)))
    for k, dof in enumerate(known):
        if dof in turbine.dofs:
            out[:, turbine.dofs.index(dof)] = rotations[:, k]
    return thrust * arm * out * [[1.0], [-1.0]]


def rotor_nacelle(structure: TurbineStructure) -> RigidBody:
    """Return nacelle, hub and rigid blades as one body about the tower top (independent of azimuth for 3 and more blades)."""
    rotor = structure.rotor
    axis = np.array([np.cos(rotor.tilt), 0.0, np.sin(rotor.tilt)])
    lateral = np.array([0.0, 1.0, 0.0])
    upward = np.cross(axis, lateral)
    azimuth = 2 * np.pi * np.arange(rotor.blades) / max(rotor.blades, 1)
    radial = np.cos(azimuth)[:, None] * upward + np.sin(azimuth)[:, None] * lateral
    blade_axis = np.cos(rotor.cone) * radial + np.sin(rotor.cone) * axis
    nodes = rotor.apex + blade_axis[:, None, :] * rotor.node_radius[:, None]
    parts = [
        (rotor.node_mass[None, :].repeat(rotor.blades, 0).ravel(), nodes.reshape(-1, 3), None),
        (
            np.array([rotor.hub_mass]),
            (rotor.apex + rotor.hub_offset * axis)[None],
            rotor.hub_inertia * np.outer(axis, axis),
        ),
        (np.array([structure.nacelle.mass]), structure.nacelle.centre[None], structure.nacelle.inertia),
    ]
    masses = np.concatenate([p[0] for p in parts])
    places = np.concatenate([p[1] for p in parts])
    total = masses.sum()
    centre = masses @ places / total if total > 0 else np.zeros(3)
    r = places - centre
    inertia = np.einsum("n,nk,nk->", masses, r, r) * np.eye(3) - np.einsum("n,ni,nj->ij", masses, r, r)
    return RigidBody(mass=total, centre=centre, inertia=inertia + sum(p[2] for p in parts if p[2] is not None))


def platform_matrices(platform: RigidBody, gravity: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return mass (6, 6), weight stiffness (6, 6) and weight force (6) of the platform body."""
    weight = np.array([0.0, 0.0, -platform.mass * gravity])
    force = np.concatenate([weight, np.cross(platform.centre, weight)])
    mass = rigid_mass(platform.mass, platform.centre, platform.inertia)
    return mass, weight_stiffness(platform.mass, platform.centre, gravity), force


def structural_matrices(
    structure: TurbineStructure, modes: tuple[str, ...] = ("tower_fa1",), deflection=None
) -> TurbineMatrices:
    """Return the parked turbine's matrices from its structure alone: mass, structural damping, elastic and gravity stiffness.

    modes names the tower modes kept beside the six platform motions. Gravity enters by the second derivatives of
    the potential: weight times height lost by rotation, deflection and the shortening of the bent axis. Blades
    are rigid. The matrices hold at the tower's deflection (k) [m], by default the static one under its own weight;
    `point` gives it.
    Reference: Kane's equations as in Jonkman 2007, section 2.
    """
    shapes = tower_modes(structure.tower, tuple(modes))
    if deflection is not None:
        return _at_deflection(structure, shapes, np.asarray(deflection, dtype=float))
    straight = _at_deflection(structure, shapes, np.zeros(len(shapes.names)))
    bent = np.linalg.solve(straight.stiffness[6:, 6:], straight.force[6:]) if shapes.names else np.zeros(0)
    return _at_deflection(structure, shapes, bent)


def _at_deflection(structure: TurbineStructure, shapes: TowerModes, deflection: np.ndarray) -> TurbineMatrices:
    """Return the matrices with the tower bent by `deflection` (k) [m]."""
    head = rotor_nacelle(structure)
    fore_aft = np.array([name.startswith("tower_fa") for name in shapes.names], dtype=bool)
    tower_motion, nodes = _node_motion(shapes, fore_aft, deflection)
    lowered = deflection @ shapes.top_shortening @ deflection / 2
    shift = np.array([deflection[fore_aft].sum(), deflection[~fore_aft].sum(), -lowered])
    turn = rotation(_top_rotation(shapes, fore_aft) @ deflection)
    head = RigidBody(mass=head.mass, centre=shift + turn @ head.centre, inertia=turn @ head.inertia @ turn.T)
    head_motion = _head_motion(structure.tower.top_height, shapes, fore_aft, head.centre, shift)
    head_motion[2, 6:] -= shapes.top_shortening @ deflection
    q = 6 + len(shapes.names)
    mass = np.einsum("n,nki,nkj->ij", shapes.mass, tower_motion, tower_motion)
    mass += head_motion[:3].T @ head_motion[:3] * head.mass + head_motion[3:].T @ head.inertia @ head_motion[3:]
    damping, stiffness = np.zeros((2, q, q))
    damping[6:, 6:], stiffness[6:, 6:] = shapes.damping, shapes.stiffness
    gravity, force = _gravity(structure, shapes, head, fore_aft, nodes, tower_motion, head_motion)
    force[6:] -= shapes.stiffness @ deflection
    return TurbineMatrices(
        dofs=PLATFORM_DOFS + shapes.names, mass=mass, damping=damping, stiffness=stiffness + gravity, force=force,
        point=np.concatenate([np.zeros(6), deflection]), wind_force=np.zeros(q), source="structural data of the deck",
    )  # fmt: skip


def _node_motion(shapes: TowerModes, fore_aft: np.ndarray, deflection: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the translation (n, 3, q) of the bent tower's nodes per unit of each degree of freedom, and their places (n, 3)."""
    bending = np.zeros((len(shapes.height), 3, len(shapes.names)))
    bending[:, 0, fore_aft], bending[:, 1, ~fore_aft] = shapes.shape[:, fore_aft], shapes.shape[:, ~fore_aft]
    position = bending @ deflection
    position[:, 2] = shapes.height - deflection @ shapes.shortening @ deflection / 2
    bending[:, 2] = -shapes.shortening @ deflection
    return np.concatenate([point_motion(position), bending], axis=2), position


def head_motion(top_height: float, shapes: TowerModes, position) -> np.ndarray:
    """Return translation and rotation (6, q) of a point fixed to the tower top, `position` (3) [m] from it."""
    fore_aft = np.array([name.startswith("tower_fa") for name in shapes.names], dtype=bool)
    return _head_motion(top_height, shapes, fore_aft, np.asarray(position, dtype=float))


def _head_motion(top_height, shapes: TowerModes, fore_aft, position: np.ndarray, shift: np.ndarray | float = 0.0):
    """Return the motion (6, q) of a point `position` from the undeflected tower top; `shift` (3) is that of the top itself."""
    turn = _top_rotation(shapes, fore_aft)
    top = np.zeros((3, len(shapes.names)))
    top[0, fore_aft], top[1, ~fore_aft] = 1.0, 1.0
    out = np.zeros((6, 6 + len(shapes.names)))
    out[:3, :6] = point_motion(position + [0.0, 0.0, top_height])
    out[3:, 3:6] = np.eye(3)
    out[:3, 6:] = top + np.cross(turn, (position - shift)[:, None], axis=0)
    out[3:, 6:] = turn
    return out


def _top_rotation(shapes: TowerModes, fore_aft: np.ndarray) -> np.ndarray:
    """Return the rotation (3, k) of the tower top per unit of each mode."""
    turn = np.zeros((3, len(shapes.names)))
    turn[1, fore_aft], turn[0, ~fore_aft] = shapes.top_slope[fore_aft], -shapes.top_slope[~fore_aft]
    return turn


def _gravity(structure, shapes, head, fore_aft, nodes, tower_motion, head_motion) -> tuple[np.ndarray, np.ndarray]:
    """Return stiffness (q, q) and generalised force (q) of the weights of tower and rotor-nacelle assembly."""
    g, q = structure.gravity, 6 + len(shapes.names)
    moved = np.einsum("n,nki->ki", shapes.mass, tower_motion) + head.mass * head_motion[:3]
    force = -g * moved[2]
    centre = shapes.mass @ nodes
    centre = centre + head.mass * (head.centre + [0.0, 0.0, structure.tower.top_height])
    out = np.zeros((q, q))
    out[3, 3] = out[4, 4] = -g * centre[2]
    out[3, 5], out[4, 5] = g * centre[0], g * centre[1]
    out[3, 6:], out[4, 6:] = g * moved[1, 6:], -g * moved[0, 6:]
    out[6:, 3:5] = out[3:5, 6:].T
    turn = _top_rotation(shapes, fore_aft)
    lost = np.einsum("n,nij->ij", shapes.mass, shapes.shortening) + head.mass * shapes.top_shortening
    out[6:, 6:] = -g * (lost + head.mass * head.centre[2] * turn.T @ turn)
    return out, force
