"""The parametric three-column semisubmersible: a few numbers become steel, ballast, hydrostatics, drag and moorings.

Geometry of the DeepCwind platform of OC4 (Robertson et al. 2014, NREL/TP-5000-60601) with free dimensions, as in the study of
column diameter, platform radius and draft for 10 MW: a central column under the tower, three offset columns on heave plates,
pontoons and braces whose lengths follow. One offset column lies at -x. Every dimension may be an array (...): designs.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np

from model.system.mooring import MooringSystem
from model.system.turbine import RigidBody

AZIMUTHS = np.pi + np.array([0.0, 2.0, 4.0]) * np.pi / 3
UPSCALE_KEPT = ("brace_diameter", "column_wall", "central_wall", "brace_wall")


@dataclass(frozen=True, eq=False, kw_only=True)
class SemiHull:
    """Dimensions of a three-column semisubmersible [m], each a number or an array (...) of designs.

    diameter of the offset columns; radius from the tower's axis to theirs; draft; plate_ratio of heave plate to column
    diameter; plate_height; central_diameter; column_freeboard and central_freeboard above still water; brace_diameter;
    wall thicknesses of offset columns and plates, central column, braces; densities of steel and ballast [kg/m3].
    """

    diameter: np.ndarray
    radius: np.ndarray
    draft: np.ndarray
    plate_ratio: float = 2.0
    plate_height: float = 6.0
    central_diameter: float = 8.3
    column_freeboard: float = 12.0
    central_freeboard: float = 10.0
    brace_diameter: float = 1.6
    column_wall: float = 0.06
    central_wall: float = 0.03
    brace_wall: float = 0.0175
    steel_density: float = 7850.0
    ballast_density: float = 2400.0

    def __post_init__(self):
        for field in fields(self):
            value = np.asarray(getattr(self, field.name), dtype=float)
            if np.any(~(value > 0)):
                raise ValueError(f"{field.name} is {value}; it must be positive [m, kg/m3]")
            object.__setattr__(self, field.name, value)

    @property
    def plate_diameter(self) -> np.ndarray:
        """Diameter of the heave plates (...) [m]."""
        return self.plate_ratio * self.diameter

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the designs, () for one."""
        return np.broadcast_shapes(*(getattr(self, f.name).shape for f in fields(self)))


OC4 = SemiHull(
    diameter=12.0, radius=50 / np.sqrt(3), draft=20.0, central_diameter=6.5, ballast_density=1025.0
)  # fmt: skip
"""The DeepCwind semisubmersible of OC4, 5 MW."""


def upscaled(hull: SemiHull, power_ratio: float, *, central_diameter: float | None = None) -> SemiHull:
    """Return a hull with every length times the square root of the ratio of rated powers; plates and braces keep their size.

    The central column follows the tower it carries, `central_diameter` [m]. Source: the usual rule, equation 6.1 of the
    study of 10 MW platforms; OC4 to 10 MW gives its table of dimensions.
    """
    scale = np.sqrt(power_ratio)
    lengths = {
        f.name: getattr(hull, f.name) * scale for f in fields(hull)
        if f.name not in UPSCALE_KEPT and "density" not in f.name and f.name != "plate_ratio"
    }  # fmt: skip
    out = replace(hull, **lengths)
    return out if central_diameter is None else replace(out, central_diameter=central_diameter)


@dataclass(frozen=True, eq=False, kw_only=True)
class Part:
    """Bodies placed with three-fold symmetry about the z axis: their mass (...) [kg], height of their centre (...) [m], and
    the moments (...) [kg m2] about the origin: horizontal (x or y axis) and vertical.
    """

    name: str
    mass: np.ndarray
    height: np.ndarray
    horizontal: np.ndarray
    vertical: np.ndarray


@dataclass(frozen=True, eq=False, kw_only=True)
class FloatingHull:
    """A hull that floats at its draft: what the frequency-domain model and the design checks need, arrays (...) of designs.

    volume [m3]; centre_of_buoyancy height [m]; waterplane_area [m2]; waterplane_moment [m4]; steel_mass, ballast_mass,
    mass [kg] of the platform; ballast_level [m] above the keel; centre_of_mass height [m] of the platform; inertia (..., 3)
    about that centre [kg m2] roll, pitch, yaw; metacentric_height [m] of platform and turbine together; problems: masks (...) of
    designs with the reason (...) of each.
    """

    hull: SemiHull
    volume: np.ndarray
    centre_of_buoyancy: np.ndarray
    waterplane_area: np.ndarray
    waterplane_moment: np.ndarray
    steel_mass: np.ndarray
    ballast_mass: np.ndarray
    mass: np.ndarray
    ballast_level: np.ndarray
    centre_of_mass: np.ndarray
    inertia: np.ndarray
    metacentric_height: np.ndarray
    problems: tuple[tuple[np.ndarray, np.ndarray], ...] = ()

    @property
    def possible(self) -> np.ndarray:
        """Whether each design (...) floats upright at its draft."""
        bad = np.zeros(self.hull.shape, dtype=bool)
        for mask, _ in self.problems:
            bad = bad | mask
        return ~bad


def float_hull(
    hull: SemiHull,
    *,
    carried_mass: float,
    carried_height: float,
    mooring_pull=0.0,
    density: float = 1025.0,
    gravity: float = 9.80665,
) -> FloatingHull:
    """Return the hull ballasted to float at its draft under a turbine and moorings.

    carried_mass [kg] of tower, nacelle and rotor and height [m] of their centre; mooring_pull [N] downwards. One design that
    cannot float upright raises ValueError with the reason; of several, `possible` and `problems` tell.
    """
    steel = combined("steel", steel_parts(hull))
    volume, buoyancy_height = displaced(hull)
    area, moment = waterplane(hull)
    mass = density * volume - carried_mass - np.asarray(mooring_pull) / gravity
    ballast_mass = mass - steel.mass
    ballast, level, room = ballast_part(hull, np.maximum(ballast_mass, 0.0))
    body = combined("platform", [steel, ballast])
    lateral = body.horizontal - body.mass * body.height**2
    inertia = np.stack(np.broadcast_arrays(lateral, lateral, body.vertical), axis=-1)
    total = body.mass + carried_mass
    centre = (body.mass * body.height + carried_mass * carried_height) / total
    metacentric = moment / volume + buoyancy_height - centre
    out = FloatingHull(
        hull=hull, volume=volume, centre_of_buoyancy=buoyancy_height, waterplane_area=area, waterplane_moment=moment,
        steel_mass=steel.mass, ballast_mass=ballast_mass, mass=mass, ballast_level=level, centre_of_mass=body.height,
        inertia=inertia, metacentric_height=metacentric, problems=tuple(_problems(hull, ballast_mass, room, metacentric)),
    )  # fmt: skip
    if hull.shape == () and not out.possible:
        raise ValueError("the hull cannot float upright as described: " + "; ".join(str(t) for m, t in out.problems if m))
    return out


def geometry_problems(hull: SemiHull):
    """Yield (mask of designs, reason) of everything in the dimensions that cannot be built, whatever it weighs."""
    r, plate = hull.radius, hull.plate_diameter
    yield _told(hull, hull.draft <= hull.plate_height, "the draft {:.1f} m is not above the heave plates' height {:.1f} m; take a larger draft",
                hull.draft, hull.plate_height)  # fmt: skip
    yield _told(hull, plate >= np.sqrt(3) * r, "heave plates of {:.1f} m overlap each other at a radius of {:.1f} m; take a larger radius or smaller plates",
                plate, r)  # fmt: skip
    yield _told(hull, plate / 2 + hull.central_diameter / 2 >= r,
                "heave plates of {:.1f} m reach the central column at a radius of {:.1f} m; take a larger radius", plate, r)  # fmt: skip
    yield _told(hull, 2 * hull.column_wall >= hull.diameter, "walls of {:.3f} m fill the columns of {:.1f} m", hull.column_wall, hull.diameter)


def _told(hull: SemiHull, mask, text: str, *values):
    """Return a mask over designs and, where it is true, the text with the design's values."""
    mask = np.broadcast_to(mask, hull.shape)
    values, shown = [np.broadcast_to(v, hull.shape) for v in values], np.full(hull.shape, "", dtype=object)
    for at in map(tuple, np.argwhere(mask)):
        shown[at] = text.format(*(float(v[at]) for v in values))
    return mask, shown


def _problems(hull: SemiHull, ballast, room, metacentric):
    """Yield (mask of designs, reason) of everything that keeps a hull from floating upright."""
    yield from geometry_problems(hull)
    yield _told(
        hull,
        ballast < 0,
        "steel and carried loads weigh {:.3g} kg more than the displaced water; take a larger diameter or draft",
        -ballast,
    )
    yield _told(hull, ballast > room, "ballast of {:.3g} kg does not fit below the columns' tops ({:.3g} kg); take a heavier ballast or a smaller hull",
                ballast, room)  # fmt: skip
    yield _told(
        hull,
        metacentric <= 0,
        "the metacentric height is {:.2f} m; take a larger radius or diameter, or denser ballast",
        metacentric,
    )


def cylinder(density, radius, bottom, top, distance=0.0, count: int = 1, name: str = "") -> Part:
    """Return solid upright cylinders: one on the axis, or `count` evenly around it at a distance [m] (3 for this hull)."""
    height = top - bottom
    mass = count * density * np.pi * radius**2 * height
    centre = (top + bottom) / 2
    horizontal = mass * (radius**2 / 4 + height**2 / 12 + centre**2 + (np.asarray(distance) ** 2 / 2))
    return Part(
        name=name,
        mass=mass,
        height=centre,
        horizontal=horizontal,
        vertical=mass * (radius**2 / 2 + np.asarray(distance) ** 2),
    )


def tube_part(density, radius, wall, start, end, name: str = "") -> Part:
    """Return three thin tubes from start (..., 3) to end (..., 3) [m], turned by 120 degrees each."""
    start, end = np.broadcast_arrays(np.asarray(start, dtype=float), np.asarray(end, dtype=float))
    length = np.linalg.norm(end - start, axis=-1)
    mass = 3 * density * np.pi * (radius**2 - (radius - wall) ** 2) * length
    square = (start**2 + start * end + end**2) / 3
    section = (radius**2 + (radius - wall) ** 2) / 4
    axis = (end - start)[..., 2] ** 2 / np.maximum(length**2, 1e-300)
    horizontal = mass * (square[..., :2].sum(-1) / 2 + square[..., 2] + section * (1.5 - axis / 2))
    vertical = mass * (square[..., :2].sum(-1) + section * (1 + axis))
    return Part(name=name, mass=mass, height=(start + end)[..., 2] / 2, horizontal=horizontal, vertical=vertical)


def combined(name: str, parts) -> Part:
    """Return several parts as one."""
    mass = sum(p.mass for p in parts)
    moment = sum(p.mass * p.height for p in parts)
    safe = np.where(mass == 0, 1.0, mass)
    return Part(
        name=name,
        mass=mass,
        height=moment / safe,
        horizontal=sum(p.horizontal for p in parts),
        vertical=sum(p.vertical for p in parts),
    )


def _shell(density, radius, wall, bottom, top, distance, count, name):
    outer = cylinder(density, radius, bottom, top, distance, count, name)
    inner = cylinder(-np.asarray(density), radius - wall, bottom, top, distance, count, name)
    return combined(name, [outer, inner])


def steel_parts(hull: SemiHull) -> list[Part]:
    """Return the steel of the hull: plates of the given thickness on every surface, tubes for pontoons and braces."""
    rho, t, r = hull.steel_density, hull.column_wall, hull.radius
    column, plate, keel = hull.diameter / 2, hull.plate_diameter / 2, -hull.draft
    shelf, top, deck = keel + hull.plate_height, hull.column_freeboard, hull.central_freeboard
    central, tc = hull.central_diameter / 2, hull.central_wall
    annulus = combined("heave plate top", [
        cylinder(rho, plate, shelf - t, shelf, r, 3), cylinder(-rho, column, shelf - t, shelf, r, 3)
    ])  # fmt: skip
    parts = [
        _shell(rho, column, t, shelf, top, r, 3, "offset columns"),
        cylinder(rho, column, top - t, top, r, 3, "column tops"),
        _shell(rho, plate, t, keel, shelf, r, 3, "heave plate sides"),
        cylinder(rho, plate, keel, keel + t, r, 3, "heave plate bottoms"),
        annulus,
        _shell(rho, central, tc, keel, deck, 0.0, 1, "central column"),
        cylinder(rho, central, deck - tc, deck, 0.0, 1, "central top"),
        cylinder(rho, central, keel, keel + tc, 0.0, 1, "central bottom"),
    ]
    for name, start, end in brace_lines(hull):
        parts.append(tube_part(rho, hull.brace_diameter / 2, hull.brace_wall, start, end, name))
    return parts


def brace_lines(hull: SemiHull) -> list[tuple[str, np.ndarray, np.ndarray]]:
    """Return name, start and end (..., 3) [m] of one of each three pontoons and braces, the layout of OC4 with lengths that follow."""
    d, r, plate = hull.diameter / 2, hull.radius, hull.plate_diameter / 2
    central, low = hull.central_diameter / 2, -hull.draft + hull.plate_height / 2
    high = hull.central_freeboard
    unit = np.array([np.cos(AZIMUTHS[0]), np.sin(AZIMUTHS[0])])
    along = np.array([np.cos(AZIMUTHS[1]), np.sin(AZIMUTHS[1])]) - unit
    along = along / np.linalg.norm(along)

    def point(distance, z, shift=0.0):
        d_, z_, s_ = np.broadcast_arrays(distance, z, shift)
        flat = d_[..., None] * unit + s_[..., None] * along
        return np.concatenate([flat, z_[..., None]], axis=-1)

    gap = np.sqrt(3) * r
    return [
        ("lower delta pontoons", point(r, low, plate), point(r, low, gap - plate)),
        ("lower Y pontoons", point(central, low), point(r - plate, low)),
        ("upper delta pontoons", point(r, high, d), point(r, high, gap - d)),
        ("upper Y pontoons", point(central, high), point(r - d, high)),
        ("cross braces", point(central, -hull.draft + 0.633 * hull.plate_height), point(r - d, high - 0.87)),
    ]


def ballast_part(hull: SemiHull, mass) -> tuple[Part, np.ndarray, np.ndarray]:
    """Return ballast (...) [kg] in heave plates and columns from the bottom up, its level above the keel [m], and how much fits [kg]."""
    rho, t, r, keel = hull.ballast_density, hull.column_wall, hull.radius, -hull.draft
    wide, narrow = hull.plate_diameter / 2 - t, hull.diameter / 2 - t
    floor, shelf = keel + t, keel + hull.plate_height - t
    full = 3 * rho * np.pi * wide**2 * (shelf - floor)
    room = full + 3 * rho * np.pi * narrow**2 * (hull.column_freeboard - t - shelf)
    low = np.minimum(mass, full)
    first = floor + low / (3 * rho * np.pi * wide**2)
    second = shelf + (mass - low) / (3 * rho * np.pi * narrow**2)
    parts = [cylinder(rho, wide, floor, first, r, 3), cylinder(rho, narrow, shelf, second, r, 3)]
    level = np.where(mass > full, second, first) - keel
    return combined("ballast", parts), level, room


def displaced(hull: SemiHull) -> tuple[np.ndarray, np.ndarray]:
    """Return displaced volume (...) [m3] and height of its centre (...) [m]: columns, plates and what of the braces is wet."""
    r, keel = hull.radius, -hull.draft
    shelf = keel + hull.plate_height
    parts = [
        cylinder(1.0, hull.diameter / 2, shelf, 0.0, r, 3), cylinder(1.0, hull.plate_diameter / 2, keel, shelf, r, 3),
        cylinder(1.0, hull.central_diameter / 2, keel, 0.0),
    ]  # fmt: skip
    section = hull.brace_diameter / 2
    for name, start, end in wet_braces(hull):
        parts.append(tube_part(1.0, section, section, start, end, name))
    body = combined("water", parts)
    return body.mass, body.height


def wet_braces(hull: SemiHull) -> list[tuple[str, np.ndarray, np.ndarray]]:
    """Return the parts of pontoons and braces below still water."""
    out = []
    for name, start, end in brace_lines(hull):
        start, end = np.broadcast_arrays(start, end)
        if np.all(start[..., 2] >= 0):
            continue
        share = np.clip(-start[..., 2] / np.where(end[..., 2] > 0, end[..., 2] - start[..., 2], np.inf), 0.0, None)
        cut = np.where(end[..., 2:] > 0, start + share[..., None] * (end - start), end)
        out.append((name, start, cut))
    return out


def waterplane(hull: SemiHull) -> tuple[np.ndarray, np.ndarray]:
    """Return area (...) [m2] and second moment about a horizontal axis (...) [m4] of the waterplane: columns and braces."""
    d, c, r = hull.diameter, hull.central_diameter, hull.radius
    area = 3 * np.pi * d**2 / 4 + np.pi * c**2 / 4
    moment = 3 * np.pi * d**4 / 64 + np.pi * c**4 / 64 + 3 * np.pi * d**2 / 4 * r**2 / 2
    for _, start, end in brace_lines(hull):
        start, end = np.broadcast_arrays(start, end)
        pierces = (start[..., 2] < 0) & (end[..., 2] > 0)
        rise = np.where(pierces, end[..., 2] - start[..., 2], 1.0)
        at = start + (-start[..., 2:] / rise[..., None]) * (end - start)
        section = np.pi * hull.brace_diameter**2 / 4 * np.linalg.norm(end - start, axis=-1) / rise
        area = area + np.where(pierces, 3 * section, 0.0)
        moment = moment + np.where(pierces, 3 * section * (at[..., :2] ** 2).sum(-1) / 2, 0.0)
    return area, moment


def hydrostatic_stiffness(floating: FloatingHull, *, density: float = 1025.0, gravity: float = 9.80665) -> np.ndarray:
    """Return the hydrostatic stiffness (..., 6, 6) of buoyancy about the origin (no weight)."""
    f = floating
    out = np.zeros(np.broadcast_shapes(f.hull.shape) + (6, 6))
    out[..., 2, 2] = density * gravity * f.waterplane_area
    out[..., 3, 3] = out[..., 4, 4] = density * gravity * (f.waterplane_moment + f.volume * f.centre_of_buoyancy)
    return out


def platform_body(floating: FloatingHull) -> RigidBody:
    """Return one design's platform (steel and ballast, no turbine) as a rigid body."""
    if floating.hull.shape != ():
        raise ValueError(f"one design is needed, these are {floating.hull.shape}")
    return RigidBody(
        mass=float(floating.mass),
        centre=np.array([0.0, 0.0, float(floating.centre_of_mass)]),
        inertia=np.diag(floating.inertia),
    )


def fairleads(hull: SemiHull) -> np.ndarray:
    """Return the fairleads (..., 3, 3) [m], on the outer edge of the heave plates' tops, one a column."""
    reach = hull.radius + hull.plate_diameter / 2
    height = -hull.draft + hull.plate_height
    reach, height = np.broadcast_arrays(reach, height)
    flat = reach[..., None, None] * np.stack([np.cos(AZIMUTHS), np.sin(AZIMUTHS)], axis=-1)
    return np.concatenate([flat, np.broadcast_to(height[..., None, None], flat.shape[:-1] + (1,))], axis=-1)


def three_line_mooring(
    hull: SemiHull, *, anchor_radius, length, mass_per_length: float, diameter: float, axial_stiffness: float, depth: float,
    seabed_friction: float = 1.0, gravity: float = 9.80665, density: float = 1025.0,
) -> MooringSystem:  # fmt: skip
    """Return three catenary lines from the hull's fairleads outwards to anchors at a radius (...) [m] on the seabed."""
    lead = fairleads(hull)
    anchor_radius, length = np.asarray(anchor_radius, dtype=float), np.asarray(length, dtype=float)
    flat = anchor_radius[..., None, None] * np.stack([np.cos(AZIMUTHS), np.sin(AZIMUTHS)], axis=-1)
    anchor = np.concatenate([flat, np.full(flat.shape[:-1] + (1,), -depth)], axis=-1)
    shape = np.broadcast_shapes(lead.shape[:-2], anchor.shape[:-2])
    position = np.concatenate([np.broadcast_to(anchor, shape + (3, 3)), np.broadcast_to(lead, shape + (3, 3))], axis=-2)
    three = np.ones(3)
    return MooringSystem(
        point_names=("anchor 1", "anchor 2", "anchor 3", "fairlead 1", "fairlead 2", "fairlead 3"),
        point_kind=("fixed",) * 3 + ("vessel",) * 3, position=position, line_names=("1", "2", "3"),
        end_a=np.array([0, 1, 2]), end_b=np.array([3, 4, 5]), length=length[..., None] * three,
        mass_per_length=mass_per_length * three, diameter=diameter * three, axial_stiffness=axial_stiffness * three,
        seabed_friction=seabed_friction * three, depth=depth, gravity=gravity, density=density,
    )  # fmt: skip
