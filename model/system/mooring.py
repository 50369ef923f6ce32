"""Quasi-static mooring systems: forces, tensions and stiffness on a platform at any offset.

Lines of `model.system.catenary` join points that are fixed to the seabed, carried by the platform ("vessel") or free
("connect", which the seabed holds from below). The six platform coordinates are surge, sway, heave of the reference
point (the origin at rest) and the rotation vector of `model.conventions.rotation`; forces and moments act on the
platform about its displaced reference point, in inertial axes.

Stiffness and tension gradients are exact derivatives with respect to these six coordinates. Off the rest position the
stiffness is not symmetric, frictionless or not: a moment about fixed axes is not conjugate to a rotation vector.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from model.conventions import frozen, rotation, rotation_rate, skew
from model.system.catenary import check_lines, line_profile, solve_lines

POINT_KINDS = ("fixed", "vessel", "connect")
SEABED_TOLERANCE = 0.01  # [m] a fixed or vessel point this close to the seabed lies on it
SETTLE_STEPS = 400
_ROTATIONS = np.array([0.0, 0, 0, 1, 1, 1])


@dataclass(frozen=True, eq=False, kw_only=True)
class MooringSystem:
    """Points and lines of a mooring system (p points, l lines).

    point_names (p); point_kind (p): "fixed", "vessel" or "connect"; position (..., p, 3) [m], of a vessel point in the
    body frame about the platform reference point, of a connect point where to look for its equilibrium;
    point_mass (p) [kg], point_volume (p) [m3], always under water, point_force (p, 3) [N]: of connect points (those of
    other points act on nothing), zero if left out;
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
    def _line_arrays(self) -> tuple[np.ndarray, ...]:
        return self.length, self.weight_per_length, self.axial_stiffness, self.seabed_friction

    @cached_property
    def _designs(self) -> tuple[int, ...]:
        """Leading axes of the designs."""
        return np.broadcast_shapes(self.position.shape[:-2], *(a.shape[:-1] for a in self._line_arrays))

    @cached_property
    def _index(self) -> dict[str, np.ndarray]:
        """Points of each kind, their seabed tolerance, and the matrices (p, l) that add line ends to points."""
        kind = np.array(self.point_kind, dtype=object)
        out = {name: np.flatnonzero(kind == name) for name in POINT_KINDS}
        eye = np.eye(len(kind))
        tolerance = np.where(kind == "connect", 0.0, SEABED_TOLERANCE)
        return out | {"to_a": eye[:, self.end_a], "to_b": eye[:, self.end_b], "tolerance": tolerance}

    @cached_property
    def _seat(self) -> float:
        """Stiffness [N/m] of the seabed under connect points; lines do not feel how far these sink in."""
        weight = np.abs(self.weight_per_length * self.length).sum(axis=-1).max() + np.abs(self.point_load).sum()
        return float(weight) or 1.0


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


def mooring_state(system: MooringSystem, offset, start=None) -> MooringState:
    """Return forces, tensions, stiffness and tension gradients of a mooring system at platform offsets.

    Connect points are brought to equilibrium first, and their freedom is in the stiffness and the gradients.

    Parameters: system; offset (..., 6), surge, sway, heave [m] and rotation vector [rad]; start (..., p, 3), point
    positions to look for the equilibrium of connect points from, e.g. those of a state nearby (default: the system's).
    Returns the MooringState, with the leading axes of offset and design broadcast together.
    Raises ValueError naming the lines that cannot reach, or the connect points without equilibrium.

    Source: the lines after Jonkman (2007), NREL/TP-500-41958, section 2.7; assembly from the point kinematics.
    """
    offset = np.asarray(offset, dtype=float)
    if offset.shape[-1:] != (6,):
        raise ValueError(f"offset has shape {offset.shape}, needs (..., 6): surge, sway, heave and a rotation vector")
    batch = np.broadcast_shapes(offset.shape[:-1], system._designs)
    arm, motion = _vessel_points(system, offset)
    position = _positions(system, offset, arm, batch, start)
    seated = None
    if system._index["connect"].size:
        position, seated = _settle(system, position)
    lines, basis, span = _lines(system, position)
    _check_reach(system, span)
    rate = _point_rates(system, position, motion, seated)
    return _assemble(system, offset, arm, position, lines, basis, rate, seated)


def force_offset_curve(system: MooringSystem, direction, offsets) -> tuple[np.ndarray, MooringState]:
    """Return the restoring force of a mooring system as the platform is moved along one direction.

    Parameters: system; direction, a heading [rad] in the water plane or six platform coordinates, taken as they are;
    offsets (...) along it [m], broadcast with the designs.
    Returns the restoring force (...) [N], positive against a positive offset, and the MooringState of all offsets.
    Raises ValueError as `mooring_state`.
    """
    way = np.asarray(direction, dtype=float)
    if way.ndim == 0:
        way = np.array([np.cos(way), np.sin(way), 0, 0, 0, 0])
    if way.shape != (6,):
        raise ValueError(f"direction has shape {way.shape}, needs a heading [rad] or six platform coordinates")
    state = mooring_state(system, np.asarray(offsets, dtype=float)[..., None] * way)
    return -state.force @ way, state


def line_profiles(system: MooringSystem, state: MooringState, n: int = 101) -> tuple[np.ndarray, np.ndarray]:
    """Return shape and tension along all lines at n points, equally spaced in unstretched length from end a.

    Parameters: system; state of it; n points a line.
    Returns coordinates (..., l, n, 3) [m] and tension (..., l, n) [N].
    """
    lines, basis, span = _lines(system, state.point_position)
    x, z, tension = line_profile(lines, *span, system.length, system.axial_stiffness, system.seabed_friction, n)
    origin = state.point_position[..., system.end_a, :][..., None, :]
    return origin + x[..., None] * basis[..., None, :, 0] + z[..., None] * basis[..., None, :, 1], tension


def _check_system(system: MooringSystem) -> None:
    unknown = sorted(set(system.point_kind) - set(POINT_KINDS))
    if unknown or len(system.point_kind) != len(system.point_names):
        raise ValueError(
            f"point_kind needs one of {POINT_KINDS} for each of the {len(system.point_names)} points: {unknown}"
        )
    ends = np.stack([system.end_a, system.end_b])
    if ends.shape != (2, len(system.line_names)) or ends.min() < 0 or ends.max() >= len(system.point_names):
        raise ValueError(f"end_a and end_b need {len(system.line_names)} indices of points from 0, are {ends.tolist()}")
    same = [name for name, a, b in zip(system.line_names, *ends, strict=True) if a == b]
    if same:
        raise ValueError(f"line {', '.join(map(str, same))}: both ends are the same point")
    low = [
        name
        for i, name in enumerate(system.point_names)
        if system.point_kind[i] == "fixed" and np.any(system.position[..., i, 2] < -system.depth - SEABED_TOLERANCE)
    ]
    if low:
        raise ValueError(f"point {', '.join(map(str, low))} is below the seabed at z = {-system.depth:g} m: raise it")
    length, _, ea, cb = np.broadcast_arrays(*system._line_arrays)
    check_lines(0 * length, 0 * length, length, 0 * length, ea, cb, system.line_names)


# --- kinematics -----------------------------------------------------------------------------------------------------


def _vessel_points(system, offset):
    """Return arms from the displaced reference point (..., v, 3) and point motions per offset (..., v, 3, 6)."""
    body = system.position[..., system._index["vessel"], :]
    turn = rotation(offset[..., 3:])
    arm = (turn[..., None, :, :] @ body[..., None])[..., 0]
    motion = np.zeros(arm.shape + (6,))
    motion[..., :3] = np.eye(3)
    motion[..., 3:] = -skew(arm) @ rotation_rate(offset[..., 3:])[..., None, :, :]
    return arm, motion


def _positions(system, offset, arm, batch, start):
    """Return the positions of all points (..., p, 3), of connect points those to start from."""
    position = np.array(np.broadcast_to(system.position, batch + system.position.shape[-2:]))
    position[..., system._index["vessel"], :] = offset[..., None, :3] + arm
    if start is not None:
        free = system._index["connect"]
        position[..., free, :] = np.asarray(start)[..., free, :]
    return position


def _point_rates(system, position, motion, seated):
    """Return d(position) / d(platform coordinates, free coordinates) of all points (..., p, 3, 6 + 3c)."""
    free = system._index["connect"]
    rate = np.zeros(position.shape + (6 + 3 * free.size,))
    rate[..., system._index["vessel"], :, :6] = motion
    if free.size:
        rate[..., 6:] = _free_rates(system, seated)
    return rate


def _free_rates(system, seated):
    """Return d(position) / d(free coordinates) (..., p, 3, 3c); points that lie on the seabed stay on it."""
    free = system._index["connect"]
    rate = np.zeros(seated.shape[:-1] + (len(system.point_names), 3, free.size, 3))
    for i, point in enumerate(free):
        rate[..., point, [0, 1, 2], i, [0, 1, 2]] = 1.0
        rate[..., point, 2, i, 2] = np.where(seated[..., i], 0.0, 1.0)
    return rate.reshape(rate.shape[:-2] + (-1,))


# --- connect points -------------------------------------------------------------------------------------------------


def _settle(system, position):
    """Return the positions with all connect points in equilibrium, and which of these (..., c) lie on the seabed.

    The energy of lines, weights and seabed is convex in the free coordinates (friction aside, which is weak), so
    damped Newton steps always get there: the damping grows until a step goes downhill and fades afterwards.
    """
    free = system._index["connect"]
    position = np.array(position)
    longest = system.length.max()
    force, stiffness, scale, lines = _balance(system, position)
    damping = np.zeros(force.shape[:-1])
    moving = np.ones(force.shape[:-1], dtype=bool)
    for _ in range(SETTLE_STEPS):
        step = _damped_step(force, stiffness, damping, 0.3 * longest)
        trial = np.array(position)
        trial[..., free, :] += step.reshape(step.shape[:-1] + (-1, 3))
        near = lines if np.abs(step).max() < 0.01 * longest else None
        new_force, new_stiffness, new_scale, lines = _balance(system, trial, near)
        before, after = (force * step).sum(-1), (new_force * step).sum(-1)
        good = moving & ((after >= -0.3 * before) | (_size(new_force) < _size(force)))
        position = np.where(good[..., None, None], trial, position)
        force = np.where(good[..., None], new_force, force)
        stiffness = np.where(good[..., None, None], new_stiffness, stiffness)
        scale = np.where(good, new_scale, scale)
        near_zero = np.where(damping > 0, 1e-10, 1e-7) * scale  # below this rounding may turn any step uphill
        small = (_size(step) <= 1e-11 * longest) & (_size(force) <= near_zero)
        moving = moving & ~(small | (_size(force) <= 1e-14 * scale))
        if not moving.any():
            break
        stiff = np.trace(new_stiffness, axis1=-2, axis2=-1) / step.shape[-1]
        relaxed = np.where(damping > 1e-6 * stiff, 0.1 * damping, 0.0)
        damping = np.where(good, relaxed, np.maximum(8 * damping, 1e-3 * stiff))
    _check_settled(system, force, scale)
    seated = position[..., free, 2] <= -system.depth
    position[..., free, 2] = np.maximum(position[..., free, 2], -system.depth)
    return position, seated


def _size(vector):
    return np.abs(vector).max(-1)


def _damped_step(force, stiffness, damping, longest):
    """Return the Newton step of the free coordinates, no longer than `longest` in any of them."""
    n = force.shape[-1]
    floor = 1e-10 * np.trace(stiffness, axis1=-2, axis2=-1) / n + 1e-6  # slack lines leave directions without stiffness
    matrix = stiffness + (damping + floor)[..., None, None] * np.eye(n)
    step = np.linalg.solve(matrix, force[..., None])[..., 0]
    return step * np.minimum(1.0, longest / np.maximum(_size(step), 1e-300))[..., None]


def _balance(system, position, near=None):
    """Return force (..., 3c) and stiffness (..., 3c, 3c) of the connect points, the size of forces there, the lines."""
    free = system._index["connect"]
    depth_in = np.maximum(-system.depth - position[..., free, 2], 0.0)
    seated = position[..., free, 2] <= -system.depth
    lifted = np.array(position)
    lifted[..., free, 2] += depth_in
    lines, basis, _ = _lines(system, lifted, near)
    rates = _line_rates(system, lines, basis, _free_rates(system, seated), lifted)
    force, rate = _point_forces(system, lines, basis, rates)
    force = force[..., free, :] + system.point_load[free]
    force[..., 2] += system._seat * depth_in
    scale = lines.tension.max(-1) + np.abs(lines.weight * system.length).max(-1) + np.abs(system.point_load).max()
    return force.reshape(force.shape[:-2] + (-1,)), _free_stiffness(system, rate, seated), scale, lines


def _free_stiffness(system, rate, seated):
    """Return -d(force on connect points) / d(coordinates) (..., 3c, n) with the seabed under those that lie on it."""
    free = system._index["connect"]
    out = -rate[..., free, :, :]
    for i in range(free.size):
        out[..., i, 2, -3 * free.size + 3 * i + 2] += system._seat * seated[..., i]
    return out.reshape(out.shape[:-3] + (3 * free.size, -1))


def _check_settled(system, force, scale):
    lost = ~(np.abs(force) <= 1e-6 * scale[..., None])
    if lost.any():
        points = np.flatnonzero(lost.reshape(-1, force.shape[-1]).any(axis=0).reshape(-1, 3).any(axis=1))
        names = ", ".join(str(system.point_names[system._index["connect"][i]]) for i in points)
        raise ValueError(f"point {names}: no equilibrium found; check its lines, mass, volume and force")


# --- lines ----------------------------------------------------------------------------------------------------------


def _lines(system, position, start=None):
    """Return the LineState of all lines, their bases (..., l, 3, 3) and (x, z) spans.

    The columns of a basis are the horizontal direction from anchor to fairlead, up, and the horizontal normal.
    """
    a, b = position[..., system.end_a, :], position[..., system.end_b, :]
    way = b - a
    x = np.sqrt(way[..., 0] ** 2 + way[..., 1] ** 2)
    z = way[..., 2]
    height = position[..., 2] + system.depth
    height = np.where(height <= system._index["tolerance"], 0.0, height)
    clearance = np.minimum(height[..., system.end_a], height[..., system.end_b])
    line = np.broadcast_arrays(x, *system._line_arrays)[1:] if x.ndim > 1 else system._line_arrays
    state = solve_lines(x, z, *line, clearance, start)
    basis = np.zeros(x.shape + (3, 3))
    safe = np.where(x > 0, x, 1.0)
    cosine, sine = np.where(x > 0, way[..., 0] / safe, 1.0), way[..., 1] / safe
    basis[..., 0, 0] = basis[..., 1, 2] = cosine
    basis[..., 1, 0], basis[..., 0, 2] = sine, -sine
    basis[..., 2, 1] = 1.0
    return state, basis, (x, z)


def _check_reach(system, span):
    x, z = span
    if not (x * x + z * z <= 4 * system.length**2).all():
        w = np.zeros(x.shape)
        check_lines(*np.broadcast_arrays(x, z, system.length, w, w + 1, w), system.line_names)


def _line_rates(system, lines, basis, rate, position):
    """Return d(fairlead H, V, side, anchor H, V, side) / d(coordinates) of the lines (..., l, 6, n)."""
    local = np.zeros(lines.lateral.shape + (6, 3))
    local[..., :2, :2], local[..., 3:5, :2] = lines.stiffness, lines.anchor_stiffness
    local[..., 2, 2], local[..., 5, 2] = lines.lateral, lines.anchor_lateral
    way = rate[..., system.end_b, :, :] - rate[..., system.end_a, :, :]
    out = local @ (basis.swapaxes(-1, -2) @ way)
    if lines.clearance_stiffness is not None:
        lower = position[..., system.end_a, 2] <= position[..., system.end_b, 2]
        heave = np.where(lower[..., None], rate[..., system.end_a, 2, :], rate[..., system.end_b, 2, :])
        out[..., [0, 1, 3, 4], :] += lines.clearance_stiffness[..., None] * heave[..., None, :]
    return out


def _point_forces(system, lines, basis, line_rates):
    """Return the forces of the lines on all points (..., p, 3) and their derivatives (..., p, 3, n)."""
    n = line_rates.shape[-1]
    at_b = np.stack([-lines.horizontal, -lines.vertical], -1)
    at_a = np.stack([lines.anchor_horizontal, lines.anchor_vertical], -1)
    plane = basis[..., :2]
    force = (
        system._index["to_b"] @ (plane @ at_b[..., None])[..., 0]
        + system._index["to_a"] @ (plane @ at_a[..., None])[..., 0]
    )
    rows = line_rates.shape[:-2] + (3 * n,)
    rate_b, rate_a = (basis @ line_rates[..., :3, :]).reshape(rows), (basis @ line_rates[..., 3:, :]).reshape(rows)
    rate = system._index["to_a"] @ rate_a - system._index["to_b"] @ rate_b
    return force, rate.reshape(rate.shape[:-1] + (3, n))


# --- the whole system -----------------------------------------------------------------------------------------------


def _assemble(system, offset, arm, position, lines, basis, rate, seated):
    """Add the line forces to platform forces, stiffness and tension gradients."""
    line_rates = _line_rates(system, lines, basis, rate, position)
    force, force_rate = _point_forces(system, lines, basis, line_rates)
    if seated is not None:
        follow = _follow(_free_stiffness(system, force_rate, seated))[..., None, :, :]
        line_rates, force_rate = line_rates @ follow, force_rate @ follow
    vessel = system._index["vessel"]
    on_vessel, vessel_rate = force[..., vessel, :], -force_rate[..., vessel, :, :]
    lever = skew(arm)
    total = np.concatenate([on_vessel.sum(axis=-2), (lever @ on_vessel[..., None])[..., 0].sum(axis=-2)], axis=-1)
    turning = lever @ vessel_rate + skew(on_vessel) @ rate[..., vessel, :, :6] * _ROTATIONS
    stiffness = np.concatenate([vessel_rate.sum(axis=-3), turning.sum(axis=-3)], axis=-2)
    fairlead, anchor = lines.tension, lines.anchor_tension
    return MooringState(
        offset=np.array(np.broadcast_to(offset, total.shape)),
        force=total,
        stiffness=stiffness,
        fairlead_tension=fairlead,
        anchor_tension=anchor,
        fairlead_horizontal=lines.horizontal,
        fairlead_vertical=lines.vertical,
        anchor_horizontal=lines.anchor_horizontal,
        anchor_vertical=lines.anchor_vertical,
        grounded_length=lines.grounded,
        tension_gradient=_tension_gradient(fairlead, lines.horizontal, lines.vertical, line_rates[..., :2, :]),
        anchor_tension_gradient=_tension_gradient(
            anchor, lines.anchor_horizontal, lines.anchor_vertical, line_rates[..., 3:5, :]
        ),
        point_position=position,
    )


def _follow(stiffness):
    """Return d(platform and free coordinates) / d(platform coordinates) (..., 6 + 3c, 6): free points keep balance."""
    own, coupling = stiffness[..., 6:], stiffness[..., :6]
    try:
        free = -np.linalg.solve(own, coupling)
    except np.linalg.LinAlgError:  # points held by slack lines only: they stay
        free = -np.linalg.pinv(own, rcond=1e-14) @ coupling
    return np.concatenate([np.broadcast_to(np.eye(6), free.shape[:-2] + (6, 6)), free], axis=-2)


def _tension_gradient(tension, horizontal, vertical, rates):
    """Return d(tension) / d(coordinates) (..., l, n) from the rates of its two parts."""
    safe = np.where(tension > 0, tension, 1.0)
    return (horizontal / safe)[..., None] * rates[..., 0, :] + (vertical / safe)[..., None] * rates[..., 1, :]
