"""Inertia and buoyancy of slender members that are not in the potential flow (Morison), as HydroDyn has them.

Across its axis a strip has the added mass rho Ca A and, in the water's acceleration, the force rho (Ca + Cp) A; along it only
where it tapers. A joint has the dynamic pressure on the net area of the ends that meet there and the added mass of
half spheres on them. Each member floats as a closed body. Waves act up to still water.
Reference: Wang, Robertson, Jonkman et al., OpenFAST's HydroDyn theory manual, "strip theory".
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.conventions import freeze, point_motion, weight_stiffness
from model.environment.airy import wave_kinematics, wavenumber

_PANEL = 4.0  # m of a strip, two Gauss points each: short waves push on the top few metres
_CHUNK = 2_000_000  # numbers of a wave field held at once


@dataclass(frozen=True, eq=False, kw_only=True)
class InertiaElements:
    """Members outside the potential flow, s elements: position (s, 3) [m]; added_mass (s, 3, 3) [kg] that moves with them;
    inertia (s, 3, 3) [kg] that turns the water's acceleration into force; pressure_area (s, 3) [m2] that turns dynamic pressure
    into force; names of the members. Their buoyancy: volume [m3], centre (3) [m], stiffness (6, 6) about the origin.
    """

    position: np.ndarray
    added_mass: np.ndarray
    inertia: np.ndarray
    pressure_area: np.ndarray
    names: tuple[str, ...]
    volume: float
    centre: np.ndarray
    stiffness: np.ndarray

    def __post_init__(self):
        freeze(
            self, position=("s", 3), added_mass=("s", 3, 3), inertia=("s", 3, 3), pressure_area=("s", 3), centre=(3,), stiffness=(6, 6),
        )  # fmt: skip


def added_mass_of(elements: InertiaElements, reference=(0.0, 0.0, 0.0)) -> np.ndarray:
    """Return the added mass (6, 6) of all elements about a reference point (3) [m]."""
    motion = point_motion(elements.position - np.asarray(reference))
    return np.einsum("sai,sab,sbj->ij", motion, elements.added_mass, motion, optimize=True)


def wave_force_on(
    elements: InertiaElements, omega, heading, *, density: float, gravity: float, depth: float, reference=(0.0, 0.0, 0.0)
) -> np.ndarray:
    """Return the waves' force (..., n, 6) per metre of amplitude on all elements about a reference point (3) [m].

    omega (n) [rad/s]; heading (...) [rad]; density [kg/m3]; gravity [m/s2]; depth [m]. Phase zero is a crest at the origin.
    """
    omega, heading = np.asarray(omega, dtype=float), np.asarray(heading, dtype=float)
    motion = point_motion(elements.position - np.asarray(reference))
    from_acceleration = np.einsum("sai,sab->isb", motion, elements.inertia).reshape(6, -1)
    from_pressure = np.einsum("sai,sa->is", motion, elements.pressure_area) * density * gravity
    k = wavenumber(omega, depth, gravity)
    out = np.empty((heading.size, len(omega), 6), dtype=complex)
    count = max(1, _CHUNK // max(1, 3 * len(elements.position)))
    for row, angle in enumerate(heading.ravel()):
        for start in range(0, len(omega), count):
            part = slice(start, start + count)
            field = wave_kinematics(omega[part], k[part], depth, elements.position, angle)
            acceleration = field.acceleration.swapaxes(-1, -2).reshape(-1, field.pressure_head.shape[-1])
            out[row, part] = (from_acceleration @ acceleration + from_pressure @ field.pressure_head).T
    return out.reshape(*heading.shape, len(omega), 6)


def strips(
    start, end, diameter, *, added, pressure, axial_added, axial_pressure, density: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return position (s, 3), added mass and inertia (s, 3, 3) and pressure area (s, 3) of the wetted strips of a member.

    start, end (3) [m] of the axis, in any order; diameter (2) [m]; the coefficients Ca, Cp, AxCa, AxCp (2) at both ends;
    density [kg/m3].
    """
    start, end = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    full = np.linalg.norm(end - start)
    axis = (end - start) / full
    along, length = _wetted_points(start[2], end[2], full)

    def at(values):
        return values[0] + (values[1] - values[0]) * along

    radius, slope = at(diameter) / 2, (diameter[1] - diameter[0]) / (2 * full)
    lengthwise = np.outer(axis, axis)
    across = np.eye(3) - lengthwise
    mass = density * np.pi * radius**2 * length
    axial = (2 * at(axial_added) * abs(slope) * mass)[:, None, None] * lengthwise
    side = (2 * np.pi * radius * slope * length * at(axial_pressure))[:, None] * axis
    return (
        start + along[:, None] * (end - start), (at(added) * mass)[:, None, None] * across + axial,
        ((at(added) + at(pressure)) * mass)[:, None, None] * across + axial, side,
    )  # fmt: skip


def joint_end(area, volume, *, added: float, pressure: float, density: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return added mass and inertia (3, 3) and pressure area (3) of the member ends that meet in a joint.

    area (3) [m2] sum of their outward area vectors; volume (3) [m3] sum of half spheres on them, along the same normals; added,
    pressure: AxCa, AxCp.
    """
    volume = np.asarray(volume, dtype=float)
    size = np.linalg.norm(volume)
    mass = added * density * np.outer(volume, volume) / size if size > 1e-9 else np.zeros((3, 3))
    return mass, mass, -pressure * np.asarray(area, dtype=float)


def buoyancy(start, end, diameter, *, density: float, gravity: float) -> tuple[float, np.ndarray, np.ndarray]:
    """Return volume [m3], centre (3) [m] and stiffness (6, 6) of the wetted part of a closed member.

    start, end (3) [m]; diameter (2) [m]. Exact for a cylinder that the water line cuts across its axis at any angle below
    the horizontal; a cone has there the section of its diameter at the water line.
    """
    low, high = (start, end) if start[2] <= end[2] else (end, start)
    diameter = np.asarray(diameter, dtype=float) / 2 if start[2] <= end[2] else np.asarray(diameter, dtype=float)[::-1] / 2
    low, high = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    full, rise = np.linalg.norm(high - low), high[2] - low[2]
    wet = 0.0 if low[2] >= 0 else min(1.0, -low[2] / rise) if high[2] > 0 else 1.0
    length, axis = wet * full, (high - low) / full
    r0, r1 = diameter[0], diameter[0] + wet * (diameter[1] - diameter[0])
    volume = np.pi * length * (r0**2 + r0 * r1 + r1**2) / 3
    moment = low * volume + axis * np.pi * length**2 * (r0**2 + 2 * r0 * r1 + 3 * r1**2) / 12
    stiffness = np.zeros((6, 6))
    if wet > 0 and high[2] > 0:
        moment = moment + _oblique_cut(axis, r1)
        stiffness = _waterplane(low + length * axis, axis, r1, density * gravity)
    centre = moment / volume if volume > 0 else low
    return volume, centre, stiffness + weight_stiffness(-density * volume, centre, gravity)


def _wetted_points(z0: float, z1: float, full: float) -> tuple[np.ndarray, np.ndarray]:
    """Return places along a member (0 to 1) and lengths [m] of Gauss points on its wetted part."""
    if min(z0, z1) >= 0:
        return np.zeros(0), np.zeros(0)
    cut = z0 / (z0 - z1) if max(z0, z1) > 0 else None
    first, last = (0.0, 1.0) if cut is None else (0.0, cut) if z0 < 0 else (cut, 1.0)
    count = int(np.ceil((last - first) * full / _PANEL))
    x, w = np.polynomial.legendre.leggauss(2)
    step = (last - first) / count
    along = first + step * (np.arange(count)[:, None] + (x + 1) / 2).ravel()
    return along, np.tile(w / 2, count) * step * full


def _oblique_cut(axis: np.ndarray, radius: float) -> np.ndarray:
    """Return the first moment (3) that a level cut has beyond one normal to the axis through the same point; no volume changes.

    The axis points up. On the side towards which the member leans the section lies lower and the wetted part reaches further.
    """
    lean = np.hypot(axis[0], axis[1])
    if lean < 1e-12:
        return np.zeros(3)
    tangent, quarter = lean / axis[2], np.pi * radius**4 / 4
    towards = np.append(axis[:2] / lean, 0.0) - lean * axis  # times the cosine of the lean, in the section
    return towards / axis[2] * tangent * quarter + axis * tangent**2 * quarter / 2


def _waterplane(point: np.ndarray, axis: np.ndarray, radius: float, weight: float) -> np.ndarray:
    """Return the stiffness (6, 6) of the ellipse in which a leaning cylinder cuts still water; weight [N/m3] is rho g."""
    area = np.pi * radius**2 / axis[2]
    lean = np.hypot(axis[0], axis[1])
    e = axis[:2] / lean if lean > 1e-12 else np.array([1.0, 0.0])
    long, short = area * (radius / axis[2]) ** 2 / 4, area * radius**2 / 4
    second = short * np.eye(2) + (long - short) * np.outer(e, e) + area * np.outer(point[:2], point[:2])
    x, y = area * point[:2]
    out = np.zeros((6, 6))
    out[2, 2:5] = out[2:5, 2] = area, y, -x
    out[3, 3], out[4, 4] = second[1, 1], second[0, 0]
    out[3, 4] = out[4, 3] = -second[0, 1]
    return weight * out
