"""Panel meshes of the usual floating hulls: semisubmersible, spar, barge and tension-leg platform."""

from __future__ import annotations

import numpy as np

from fowtio.hull_mesh import WATERLINE_POWER, HullMesh, box, box_lid, lid_disc, revolved, tube
from model.design.hull import SemiHull, wet_braces

SIXTH = (2 * np.pi / 3, np.pi)
HALF = (0.0, np.pi)
QUARTER = (0.0, np.pi / 2)


def semi_mesh(
    diameter: float, radius: float, draft: float, *, plate_diameter: float | None = None, plate_thickness: float = 6.0,
    central_diameter: float = 8.3, central_draft: float | None = None, size=6.0, around: int = 12, refine: int = 1,
    members=(), power: float = WATERLINE_POWER,
) -> HullMesh:  # fmt: skip
    """Return the mesh of a three-column semisubmersible with heave plates and a central column, one column at -x.

    Column diameter, radius of the platform (axis to column axis), draft, heave plate diameter (twice the column's when not
    given) and thickness, central column's diameter and draft [m]; panels of `size` [m] along the profile (or their
    numbers along column, plate top, plate side and bottom) and `around` on a circle, both divided by `refine`. members: pontoons and braces of one sixth of the hull, from
    `semi_braces`. power: how fine the columns are near still water, see `revolved`. Three-fold and mirror symmetry.
    """
    r, plate = diameter / 2, (2 * diameter if plate_diameter is None else plate_diameter) / 2
    top, centre = -draft + plate_thickness, (-radius, 0.0)
    column = [(r, 0.0), (r, top), (plate, top), (plate, -draft), (0.0, -draft)]
    deep = -(draft if central_draft is None else central_draft)
    middle = [(central_diameter / 2, 0.0), (central_diameter / 2, deep), (0.0, deep)]
    rings, inner, inner_around = 2, (size[0], 1) if not np.isscalar(size) else size, 6
    if np.isscalar(size):
        rings, inner_around = max(1, round(r / size)), 6 * max(1, round(np.pi * central_diameter / size / 6))
    parts = [
        revolved(column, size, around, refine=refine, centre=centre, sector=HALF, power=power),
        revolved(middle, inner, inner_around, refine=refine, sector=SIXTH, power=power),
    ]
    parts += [_brace(*m, refine, *_brace_panels(size, around)) for m in members]
    lid = [
        lid_disc(r, rings, around, refine=refine, centre=centre, sector=HALF),
        lid_disc(central_diameter / 2, 1, inner_around, refine=refine, sector=SIXTH),
    ]
    return HullMesh(part=np.concatenate(parts), lid=np.concatenate(lid), symmetry="three-fold xz")


def spar_mesh(profile, *, size=4.0, around: int = 16, refine: int = 1) -> HullMesh:
    """Return the mesh of a body of revolution about the z axis: profile (k, 2) radius and elevation [m] from the waterline down.

    size [m], or the number of panels on every piece. A closing disc is added when the profile does not end on the axis. Two planes of symmetry.
    """
    profile = [tuple(p) for p in profile]
    if profile[-1][0] > 0:
        profile.append((0.0, profile[-1][1]))
    rings = max(1, round(profile[0][0] / size)) if np.isscalar(size) else max(1, around // 8)
    lid = lid_disc(profile[0][0], rings, around, refine=refine, sector=QUARTER)
    return HullMesh(part=revolved(profile, size, around, refine=refine, sector=QUARTER), lid=lid, symmetry="xz yz")


def barge_mesh(
    length: float,
    width: float,
    draft: float,
    *,
    moonpool: float = 0.0,
    cap: float | None = None,
    size: float = 4.0,
    refine: int = 1,
) -> HullMesh:
    """Return the mesh of a box barge [m] with a square moonpool (side, 0 is none), closed `cap` [m] below still water when given.

    Two planes of symmetry. A deck under little water needs panels as small as the water is thin; one at still water (0) needs none.
    """
    shape = (length / 2, width / 2)
    return HullMesh(
        part=box(*shape, draft, size, refine=refine, moonpool=moonpool, cap=cap),
        lid=box_lid(*shape, size, refine=refine, moonpool=0.0 if cap else moonpool), symmetry="xz yz",
    )  # fmt: skip


def semi_braces(hull: SemiHull) -> list[tuple]:
    """Return the wet pontoons and braces of one sixth of a hull for `semi_mesh`: (start, end, radius, side, start and end surface).

    They end on the columns' and plates' walls and at still water; their joints' small openings stay in the walls.
    """
    plate, centre = hull.plate_diameter / 2, np.array([-float(hull.radius), 0.0])
    central = ("wall", np.zeros(2), float(hull.central_diameter) / 2)
    outer = ("wall", centre, float(plate))
    half = (-np.pi / 2, np.pi / 2)
    out = []
    for name, start, end in wet_braces(hull):
        start, end = (np.array(np.broadcast_to(p, (3,)), dtype=float) for p in (start, end))
        if "delta" in name:
            start, end = start * [1, -1, 1], end * [1, -1, 1]
            out.append((start, (start + end) / 2, float(hull.brace_diameter) / 2, (0.0, 2 * np.pi), outer, None))
        else:
            last = ("surface",) if abs(end[2]) < 1e-9 else outer
            out.append((start, end, float(hull.brace_diameter) / 2, half, central, last))
    return out


def _brace_panels(size, around: int) -> tuple[float, int]:
    """Return the length of a slender member's panels [m] and their number on its circle, finer with the hull's."""
    return (min(3.0, 0.6 * size) if np.isscalar(size) else 3.0), 2 * max(3, round(3 * around / 16))


def _brace(start, end, radius, side, first, last, refine: int, size: float, around: int) -> np.ndarray:
    """Return the panels of one pontoon or brace between two surfaces."""
    length = np.linalg.norm(end - start)

    def trim(lines, direction):
        reach = [_reach(lines, direction, surface, nominal) for surface, nominal in ((first, 0.0), (last, length))]
        return np.stack(reach, axis=1)

    along = refine * max(2, round(length / size))
    return tube(start, end, radius, along, around * refine, side=side, trim=trim)


def _reach(lines, direction, surface, nominal: float) -> np.ndarray:
    """Return how far along lines (k, 3) a surface lies, nearest to a nominal distance [m]."""
    if surface is None:
        return np.full(len(lines), nominal)
    if surface[0] == "surface":
        return -lines[:, 2] / direction[2]
    _, axis, radius = surface
    flat = lines[:, :2] - axis
    a, b = direction[:2] @ direction[:2], flat @ direction[:2]
    root = np.sqrt(b**2 - a * (np.sum(flat**2, axis=1) - radius**2))
    both = np.stack([(-b - root) / a, (-b + root) / a], axis=1)
    return both[np.arange(len(lines)), np.argmin(np.abs(both - nominal), axis=1)]


def tlp_mesh(
    diameter: float, draft: float, *, pontoon_length: float = 0.0, pontoon_diameter: float = 0.0, pontoon_depth: float | None = None,
    pontoons: int = 4, size: float = 4.0, around: int = 16, refine: int = 1,
) -> HullMesh:  # fmt: skip
    """Return the mesh of a tension-leg platform: a round column and round pontoons along +-x and +-y from its wall.

    Diameter and draft of the column, length (from the wall), diameter and axis depth of the pontoons [m]; 0 or 4 pontoons.
    """
    column = spar_mesh([(diameter / 2, 0.0), (diameter / 2, -draft)], size=size, around=around, refine=refine)
    if not pontoon_length:
        return column
    if pontoons != 4:
        raise ValueError(f"pontoons is {pontoons}; the mesh has two planes of symmetry and takes 4")
    r, h = pontoon_diameter / 2, -(draft - pontoon_diameter / 2 if pontoon_depth is None else pontoon_depth)
    wall, half = ("wall", np.zeros(2), diameter / 2), (-np.pi / 2, np.pi / 2)
    parts, panels = [column.part], _brace_panels(size, around)
    for direction, side in (((1.0, 0.0, 0.0), (np.pi / 2, 3 * np.pi / 2)), ((0.0, 1.0, 0.0), half)):
        d = np.array(direction)
        start, end = d * diameter / 2 + [0, 0, h], d * (diameter / 2 + pontoon_length) + [0, 0, h]
        parts.append(_brace(start, end, r, side, wall, None, refine, *panels))
        parts.append(_cap(end, d, r, side, refine, panels[1] // 2))
    return HullMesh(part=np.concatenate(parts), lid=column.lid, symmetry="xz yz")


def _cap(centre, direction, radius: float, side, refine: int, around: int) -> np.ndarray:
    """Return the half disc that closes a pontoon's free end."""
    right = np.cross(direction, [0.0, 0.0, 1.0])
    upper = np.cross(right, direction)
    angle = np.linspace(*side, around * refine + 1)
    step = angle[1] - angle[0]
    rings = radius * np.sqrt(step / np.sin(step)) * np.linspace(1.0, 0.0, refine + 1)
    points = centre + rings[:, None, None] * (np.cos(angle)[:, None] * right + np.sin(angle)[:, None] * upper)
    lower, inner = points[:-1], points[1:]
    return np.stack([inner[:, :-1], lower[:, :-1], lower[:, 1:], inner[:, 1:]], axis=2).reshape(-1, 4, 3)
