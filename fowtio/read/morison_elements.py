"""Morison members as elements: strips and end plates with drag, inertia and buoyancy of those outside the potential flow,
ballast inside.

Ballast in filled members is taken as frozen: its mass moves with the platform, as in HydroDyn, which lets the fluid in a
member move with it and keeps its surface in place.
"""

from __future__ import annotations

import numpy as np

from fowtio.read.morison import Filling, Members
from model.system.drag import DragMembers, no_drag
from model.system.morison import InertiaElements, buoyancy, joint_end, strips
from model.system.turbine import RigidBody

_STRIP_LENGTH = 10.0  # one Gauss point for about every 10 m of wetted length and one more


def drag_members(members: Members, density: float, *, water_level: float = 0.0) -> DragMembers:
    """Return the drag elements of the wetted members: Gauss points along each, and the end plates.

    density [kg/m3]; water_level z [m] up to which members are wetted. End plates follow HydroDyn: K = 1/4 rho AxCd A
    with A the sum of the area vectors of the member ends that meet in the joint.
    """
    parts = [_strips(members, i, density, water_level) for i in range(len(members.names))]
    area = np.linalg.norm(members.plate_area, axis=1)
    wet = (area > 1e-9) & (members.plate_position[:, 2] <= water_level)
    axis = members.plate_area[wet] / area[wet, None]
    parts.append(
        (
            members.plate_position[wet],
            axis,
            density / 4 * members.plate_coefficient[wet] * area[wet],
            np.ones(wet.sum()),
            np.sqrt(4 / np.pi * area[wet]),
            np.zeros(wet.sum()),
        )
    )
    position, axis, factor, axial, diameter, length = (np.concatenate(column) for column in zip(*parts, strict=True))
    keep = factor > 0
    if not keep.any():
        return no_drag()
    return DragMembers(
        position=position[keep], axis=axis[keep], factor=factor[keep], axial=axial[keep], diameter=diameter[keep],
        length=length[keep],
    )  # fmt: skip


def ballast_body(members: Members, fillings: tuple[Filling, ...], density: float) -> RigidBody | None:
    """Return the fluid in filled members as a rigid body about the platform reference point, None without any.

    density [kg/m3] of the sea, for fillings that take it. A member is full between its walls from its lower end to
    where its axis crosses the level; sections normal to the axis are disks, integrated exactly for straight and
    conical members.
    """
    parts = [_filled(members, i, f, density) for f in fillings for i in f.members]
    mass = np.concatenate([p[0] for p in parts]) if parts else np.zeros(0)
    if not mass.sum() > 0:
        return None
    place, own = (np.concatenate([p[k] for p in parts]) for k in (1, 2))
    centre = mass @ place / mass.sum()
    arm = place - centre
    square = np.einsum("s,si,sj->ij", mass, arm, arm)
    return RigidBody(mass=mass.sum(), centre=centre, inertia=own.sum(axis=0) + np.trace(square) * np.eye(3) - square)


def _filled(members: Members, i: int, filling: Filling, density: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return mass (s), place (s, 3) and own inertia (s, 3, 3) of Gauss slices of the fluid in one member."""
    rows = (0, 1) if members.start[i, 2] <= members.end[i, 2] else (1, 0)
    low, high = ((members.start[i], members.end[i])[k] for k in rows)
    inner = (members.diameter[i] - 2 * members.thickness[i])[list(rows)]
    rise = high[2] - low[2]
    full = float(np.clip((filling.level - low[2]) / rise, 0, 1)) if rise > 1e-9 else float(low[2] <= filling.level)
    x, w = np.polynomial.legendre.leggauss(6)
    along = (x + 1) / 2 * full
    length = np.linalg.norm(high - low)
    diameter = inner[0] + along * (inner[1] - inner[0])
    rho = density if filling.density is None else filling.density
    mass = rho * np.pi / 4 * diameter**2 * w / 2 * full * length
    axis = (high - low) / length
    disk = np.eye(3) + np.outer(axis, axis)
    return mass, low + along[:, None] * (high - low), (mass * diameter**2 / 16)[:, None, None] * disk


def _strips(members: Members, i: int, density: float, level: float) -> tuple[np.ndarray, ...]:
    """Return position, axis, factor, axial, diameter and length of one member's strips below the water level."""
    start, end = members.start[i], members.end[i]
    if start[2] > end[2]:
        start, end, order = end, start, slice(None, None, -1)
    else:
        order = slice(None)
    rise = end[2] - start[2]
    wet = 0.0 if start[2] >= level else (1.0 if end[2] <= level else (level - start[2]) / rise)
    full = np.linalg.norm(end - start)
    count = 0 if wet == 0 else (1 if wet * full < 1.0 else int(np.ceil(wet * full / _STRIP_LENGTH)) + 1)
    x, w = np.polynomial.legendre.leggauss(count) if count else (np.zeros(0), np.zeros(0))
    along = (x + 1) / 2 * wet
    length = w / 2 * wet * full
    diameter, drag = (
        (1 - along) * v[0] + along * v[1] for v in (members.diameter[i][order], members.drag_coefficient[i][order])
    )
    axis = np.broadcast_to((end - start) / full, (count, 3))
    position = start + along[:, None] * (end - start)
    return position, axis, density / 2 * drag * diameter * length, np.zeros(count), diameter, length


def inertia_elements(members: Members, density: float, gravity: float) -> InertiaElements | None:
    """Return the wetted members outside the potential flow (PropPot False) as elements, None when there are none.

    density [kg/m3], gravity [m/s2]. Ends in still water or above have no pressure, as in HydroDyn.
    """
    wet = np.minimum(members.start[:, 2], members.end[:, 2]) < 0
    chosen = np.flatnonzero((members.potential == 0) & wet) if len(members.names) else np.zeros(0, int)
    if not len(chosen):
        return None
    parts = [
        strips(
            members.start[i], members.end[i], members.diameter[i], added=members.added_mass_coefficient[i],
            pressure=members.pressure_coefficient[i], axial_added=members.axial_added_mass[i],
            axial_pressure=members.axial_pressure[i], density=density,
        ) for i in chosen
    ]  # fmt: skip
    for k in np.flatnonzero(members.joint_position[:, 2] <= 0):
        end = joint_end(
            members.joint_area[k], members.joint_volume[k], added=members.joint_added_mass[k],
            pressure=members.joint_pressure[k], density=density,
        )  # fmt: skip
        parts.append((members.joint_position[k, None], *(x[None] for x in end)))
    floats = [
        buoyancy(
            members.start[i], members.end[i], members.diameter[i] * np.sqrt(members.buoyancy_coefficient[i]),
            density=density, gravity=gravity,
        ) for i in chosen
    ]  # fmt: skip
    volume = sum(v for v, _, _ in floats)
    position, added, inertia, area = (np.concatenate(column) for column in zip(*parts, strict=True))
    return InertiaElements(
        position=position, added_mass=added, inertia=inertia, pressure_area=area, names=tuple(members.names[i] for i in chosen),
        volume=volume, centre=sum(v * c for v, c, _ in floats) / volume if volume > 0 else np.zeros(3),
        stiffness=sum(s for _, _, s in floats),
    )  # fmt: skip
