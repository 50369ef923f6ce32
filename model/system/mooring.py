"""Quasi-static mooring systems: forces, tensions and stiffness on a platform at any offset.

Lines of `model.system.catenary` join points that are fixed to the seabed, carried by the platform ("vessel") or free
("connect"). The six platform coordinates are surge, sway, heave of the reference point (the origin at rest) and the
rotation vector of `model.conventions.rotation`; forces and moments act on the platform about its displaced reference
point, in inertial axes. Derivatives are exact with respect to the six coordinates, so the stiffness is symmetric at
rest without pretension moments only; away from rest a rotation vector is not conjugate to a spatial moment.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from model.conventions import frozen, rotation, rotation_rate, skew
from model.system.catenary import _check, solve_lines

POINT_KINDS = ("fixed", "vessel", "connect")
SEABED_TOLERANCE = 0.01  # [m] a point this close to the seabed lies on it


@dataclass(frozen=True, eq=False, kw_only=True)
class MooringSystem:
    """Points and lines of a mooring system (p points, l lines).

    point_names (p); point_kind (p): "fixed", "vessel" or "connect"; position (..., p, 3) [m], of a vessel point in the
    body frame about the platform reference point, of a connect point where to look for its equilibrium;
    point_mass (p) [kg], point_volume (p) [m3], point_force (p, 3) [N]: of connect points, zero if left out;
    line_names (l); end_a (l), end_b (l): point indices of anchor and fairlead; length (..., l) unstretched [m];
    mass_per_length (..., l) in air [kg/m]; diameter (..., l) [m]; axial_stiffness (..., l) [N];
    seabed_friction (..., l) [-]; depth [m]; gravity [m/s2]; density of the water [kg/m3].
    Leading axes (...) are designs; they broadcast with each other and with the offsets.
    """

    point_names: tuple[str, ...]
    point_kind: tuple[str, ...]
    position: np.ndarray
    line_names: tuple[str, ...]
    end_a: np.ndarray
    end_b: np.ndarray
    length: np.ndarray
    mass_per_length: np.ndarray
    diameter: np.ndarray
    axial_stiffness: np.ndarray
    seabed_friction: np.ndarray
    depth: float
    gravity: float
    density: float
    point_mass: np.ndarray | None = None
    point_volume: np.ndarray | None = None
    point_force: np.ndarray | None = None

    def __post_init__(self) -> None:
        p, n = len(self.point_names), len(self.line_names)
        shapes = {"position": (p, 3), "point_mass": (p,), "point_volume": (p,), "point_force": (p, 3)}
        shapes |= dict.fromkeys(("length", "mass_per_length", "diameter", "axial_stiffness", "seabed_friction"), (n,))
        for name, shape in shapes.items():
            value = getattr(self, name)
            array = frozen(np.zeros(shape) if value is None else value)
            if array.shape[-len(shape) :] != shape:
                raise ValueError(f"{name} has shape {array.shape}, needs (...{', '.join(map(str, ('',) + shape))})")
            object.__setattr__(self, name, array)
        for name in ("point_names", "point_kind", "line_names"):
            object.__setattr__(self, name, tuple(getattr(self, name)))
        for name in ("end_a", "end_b"):
            object.__setattr__(self, name, frozen(getattr(self, name), dtype=int))
        _check_system(self)

    @cached_property
    def weight_per_length(self) -> np.ndarray:
        """Submerged weight per length (..., l) [N/m]; negative for a buoyant line."""
        return frozen((self.mass_per_length - self.density * np.pi / 4 * self.diameter**2) * self.gravity)

    @cached_property
    def point_load(self) -> np.ndarray:
        """Force on the points (p, 3) [N]: their own plus buoyancy minus weight."""
        load = np.array(self.point_force)
        load[..., 2] += (self.density * self.point_volume - self.point_mass) * self.gravity
        return frozen(load)

    @cached_property
    def _index(self) -> dict[str, np.ndarray]:
        """Points of each kind, and the matrices (p, l) that add line ends to points."""
        kind = np.array(self.point_kind, dtype=object)
        out = {name: np.flatnonzero(kind == name) for name in POINT_KINDS}
        eye = np.eye(len(kind))
        return out | {"to_a": eye[:, self.end_a], "to_b": eye[:, self.end_b]}


@dataclass(frozen=True, eq=False, kw_only=True)
class MooringState:
    """A mooring system at offsets of the platform (leading axes ..., l lines, p points).

    offset (..., 6) [m, rad]; force (..., 6) on the platform about its displaced reference point [N, N m];
    stiffness (..., 6, 6) = -d(force) / d(offset); tensions, their horizontal parts (towards the other end) and vertical
    parts (fairlead: down on the fairlead; anchor: up on the anchor, the uplift) (..., l) [N]; grounded_length (..., l)
    [m]; tension gradients (..., l, 6) = d(tension) / d(offset) [N/m, N/rad]; point_position (..., p, 3) [m].
    "Anchor" is end_a of a line and "fairlead" its end_b, whatever these are joined to.
    """

    offset: np.ndarray
    force: np.ndarray
    stiffness: np.ndarray
    fairlead_tension: np.ndarray
    anchor_tension: np.ndarray
    fairlead_horizontal: np.ndarray
    fairlead_vertical: np.ndarray
    anchor_horizontal: np.ndarray
    anchor_vertical: np.ndarray
    grounded_length: np.ndarray
    tension_gradient: np.ndarray
    anchor_tension_gradient: np.ndarray
    point_position: np.ndarray

    def __post_init__(self) -> None:
        for value in vars(self).values():
            value.setflags(write=False)

    @property
    def anchor_uplift_angle(self) -> np.ndarray:
        """Angle of the line with the horizontal at the anchor, upward positive (..., l) [rad]."""
        return np.arctan2(self.anchor_vertical, self.anchor_horizontal)


def mooring_state(system: MooringSystem, offset) -> MooringState:
    """Return forces, tensions, stiffness and tension gradients of a mooring system at platform offsets.

    Parameters: system; offset (..., 6), surge, sway, heave [m] and rotation vector [rad].
    Returns the MooringState, with the leading axes of offset and design broadcast together.
    Raises ValueError naming the lines that cannot reach.

    Source: the lines after Jonkman (2007), NREL/TP-500-41958, section 2.7; assembly from the point kinematics.
    """
    offset = np.asarray(offset, dtype=float)
    if offset.shape[-1:] != (6,):
        raise ValueError(f"offset has shape {offset.shape}, needs (..., 6): surge, sway, heave and a rotation vector")
    arm, motion = _vessel_points(system, offset)
    position = _positions(system, offset, arm)
    lines, direction = _lines(system, position)
    _check_reach(system, position)
    return _assemble(system, offset, arm, motion, position, lines, direction)
