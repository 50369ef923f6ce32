"""Panel meshes of floating hulls: surfaces of revolution, tubes and boxes, on the smallest part that symmetry needs.

Panels are arrays (p, 4, 3) of corner points [m], counter-clockwise seen from the water. Curved surfaces become polygons
with the area of the circle they stand for, so that volume and waterplane are exact at any fineness.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

WATERLINE_POWER = 1.4
SYMMETRIES = {"none": 1, "xz": 2, "xz yz": 4, "three-fold xz": 6}


@dataclass(frozen=True, eq=False, kw_only=True)
class HullMesh:
    """The wetted panels of one part of a hull, its lid, and how copies of the part make the whole.

    part (p, 4, 3), lid (l, 4, 3) panels at still water inside the hull (normals up, may be empty) [m];
    symmetry is one of SYMMETRIES: no copies, mirrored at y = 0, mirrored at y = 0 and x = 0, or mirrored at
    y = 0 and turned by 120 and 240 degrees.
    """

    part: np.ndarray
    lid: np.ndarray
    symmetry: str = "none"

    def __post_init__(self):
        if self.symmetry not in SYMMETRIES:
            raise ValueError(f"symmetry is {self.symmetry!r}, needs one of {', '.join(SYMMETRIES)}")
        for name in ("part", "lid"):
            panels = np.array(getattr(self, name), dtype=float).reshape(-1, 4, 3)
            panels.setflags(write=False)
            object.__setattr__(self, name, panels)
        if len(self.part) and self.part[..., 2].max() > 1e-6:
            raise ValueError(
                f"the mesh reaches {self.part[..., 2].max():.3g} m above still water; give the wetted part only (clip it at z = 0)"
            )


def whole(mesh: HullMesh, lid: bool = False) -> np.ndarray:
    """Return all panels (p, 4, 3) of the hull (or of its lid), copies included."""
    panels = mesh.lid if lid else mesh.part
    if mesh.symmetry == "none":
        return panels
    panels = np.concatenate([panels, mirrored(panels, 1)])
    if mesh.symmetry == "xz yz":
        return np.concatenate([panels, mirrored(panels, 0)])
    if mesh.symmetry == "three-fold xz":
        return np.concatenate([turned(panels, angle) for angle in (0.0, 2 * np.pi / 3, 4 * np.pi / 3)])
    return panels


def mirrored(panels: np.ndarray, axis: int) -> np.ndarray:
    """Return panels mirrored at the plane through the origin across an axis (0 or 1), still facing the water."""
    out = panels[:, ::-1].copy()
    out[..., axis] *= -1
    return out


def turned(panels: np.ndarray, angle: float) -> np.ndarray:
    """Return panels turned about the vertical axis by an angle [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    return panels @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]).T


def revolved(
    corners, size, around: int, *, refine: int = 1, centre=(0.0, 0.0), sector=(0.0, 2 * np.pi), power: float = WATERLINE_POWER
) -> np.ndarray:
    """Return panels of a surface of revolution about a vertical axis.

    corners (k, 2): radius and elevation [m] from the waterline down to the axis; size of panels along the profile [m], or their number on each piece;
    `around` panels on the full circle; refine divides every panel's side by a whole number; centre (2) [m]; sector of
    angles [rad]. Rows are finer near still water, where waves are, at depths that go with a power of their number.
    """
    profile = polyline(corners, size, refine, power)
    count = refine * max(1, round(around * (sector[1] - sector[0]) / (2 * np.pi)))
    angle = np.linspace(*sector, count + 1)
    step = angle[1] - angle[0]
    radius, z = profile[:, 0] * np.sqrt(step / np.sin(step)), profile[:, 1]
    x = centre[0] + radius[:, None] * np.cos(angle)
    y = centre[1] + radius[:, None] * np.sin(angle)
    points = np.stack([x, y, np.broadcast_to(z[:, None], x.shape)], axis=-1)
    return _quads(points)


def polyline(corners, size, refine: int = 1, power: float = WATERLINE_POWER) -> np.ndarray:
    """Return points along straight pieces between corners; a piece that starts at still water is finer there.

    size is a length [m], or the number of panels of every piece; power is that of `revolved`.
    """
    corners = np.asarray(corners, dtype=float)
    pieces = [corners[:1]]
    for k, (a, b) in enumerate(pairwise(corners)):
        count = refine * (max(1, round(np.linalg.norm(b - a) / size)) if np.isscalar(size) else size[k])
        u = np.linspace(0.0, 1.0, count + 1)[1:, None]
        at_surface = a[1] == 0 and b[1] < 0
        pieces.append(a + (u**power if at_surface else u) * (b - a))
    return np.concatenate(pieces)


def lid_disc(
    radius: float, rings: int, around: int, *, refine: int = 1, centre=(0.0, 0.0), sector=(0.0, 2 * np.pi)
) -> np.ndarray:
    """Return the panels of a lid at still water inside a round column, facing up like water above a body."""
    down = revolved([(radius, 0.0), (0.0, 0.0)], radius / rings, around, refine=refine, centre=centre, sector=sector)
    return down[:, ::-1]


def tube(start, end, radius: float, along: int, around: int, *, side=(0.0, 2 * np.pi), trim=None) -> np.ndarray:
    """Return the open tube of a slender member between two points [m].

    side is the sector of its circumference [rad] (0 is horizontal to the right of the direction, pi/2 the upper side);
    trim(points_start (k, 3), direction (3)) may return, for every line along the tube, the distances (k, 2) from
    `start` where it begins and ends (at a column's wall, at still water).
    """
    start, end = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    length = np.linalg.norm(end - start)
    direction = (end - start) / length
    right = np.cross(direction, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    upper = np.cross(right, direction)
    count = max(1, round(around * (side[1] - side[0]) / (2 * np.pi)))
    angle = np.linspace(*side, count + 1)
    step = angle[1] - angle[0]
    radius = radius * np.sqrt(step / np.sin(step))
    lines = start + radius * (np.cos(angle)[:, None] * right + np.sin(angle)[:, None] * upper)
    reach = np.broadcast_to([0.0, length], (len(lines), 2)) if trim is None else trim(lines, direction)
    t = np.linspace(0.0, 1.0, along + 1)
    distance = reach[:, :1] + t * (reach[:, 1:] - reach[:, :1])
    points = lines[:, None] + distance[..., None] * direction
    return _quads(np.swapaxes(points, 0, 1))


def box(
    half_length: float, half_width: float, draft: float, size: float, *, refine: int = 1, moonpool: float = 0.0,
    cap: float | None = None,
) -> np.ndarray:  # fmt: skip
    """Return a quarter (x, y >= 0) of a box barge, with a square moonpool of side `moonpool` [m] in its middle.

    cap [m] closes the moonpool that far below still water by a deck: no water column moves in it. A shallow hull has three rows of panels or more on its sides, finer near still water.
    """
    z = -draft * np.linspace(0.0, 1.0, refine * max(3, round(draft / size)) + 1) ** WATERLINE_POWER
    pool = moonpool / 2
    x, y = (_with_pool(half, pool, size, refine) for half in (half_length, half_width))
    side_x = _wall(x[x <= half_length + 1e-9], z, lambda s: (s, half_width))[:, ::-1]
    side_y = _wall(y, z, lambda s: (half_length, s))
    bottom = _quads(np.stack([*np.meshgrid(x, y, indexing="ij"), np.full((len(x), len(y)), -draft)], axis=-1))
    centre = bottom.mean(axis=1)
    bottom = bottom[~((centre[:, 0] < pool) & (centre[:, 1] < pool))][:, ::-1]
    parts = [side_x, side_y, bottom]
    if pool:
        inside = z if cap is None else np.concatenate([[-cap], z[z < -cap - 1e-9]])
        parts += [
            _wall(x[x <= pool + 1e-9], inside, lambda s: (s, pool)),
            _wall(y[y <= pool + 1e-9], inside, lambda s: (pool, s))[:, ::-1],
        ]
    if pool and cap is not None:
        x, y = (axis[axis <= pool + 1e-9] for axis in (x, y))
        parts.append(
            _quads(np.stack([*np.meshgrid(x, y, indexing="ij"), np.full((len(x), len(y)), -cap)], axis=-1))[:, ::-1]
        )
    return np.concatenate(parts)


def box_lid(
    half_length: float, half_width: float, size: float, *, refine: int = 1, moonpool: float = 0.0
) -> np.ndarray:
    """Return a quarter of the lid of a box barge at still water, without the moonpool."""
    pool = moonpool / 2
    x, y = (_with_pool(half, pool, size, refine) for half in (half_length, half_width))
    panels = _quads(np.stack([*np.meshgrid(x, y, indexing="ij"), np.zeros((len(x), len(y)))], axis=-1))
    centre = panels.mean(axis=1)
    return panels[~((centre[:, 0] < pool) & (centre[:, 1] < pool))]


def volume(panels: np.ndarray) -> float:
    """Return the volume [m3] that closed panels (with still water as their top) enclose, by the divergence theorem."""
    area, centre = area_vectors(panels), panels.mean(axis=1)
    return float(np.sum(area[:, 2] * _centroid_z(panels, centre)))


def area_vectors(panels: np.ndarray) -> np.ndarray:
    """Return the area vectors (p, 3) [m2] of panels, pointing into the water."""
    return np.cross(panels[:, 2] - panels[:, 0], panels[:, 3] - panels[:, 1]) / 2


def _centroid_z(panels: np.ndarray, fallback: np.ndarray) -> np.ndarray:
    """Return the elevation of the area centroid of each panel (two triangles; exact for plane quadrilaterals)."""
    first = np.linalg.norm(np.cross(panels[:, 1] - panels[:, 0], panels[:, 2] - panels[:, 0]), axis=1)
    second = np.linalg.norm(np.cross(panels[:, 2] - panels[:, 0], panels[:, 3] - panels[:, 0]), axis=1)
    total = first + second
    z1, z2 = panels[:, [0, 1, 2], 2].mean(axis=1), panels[:, [0, 2, 3], 2].mean(axis=1)
    safe = np.where(total > 0, total, 1.0)
    return np.where(total > 0, (first * z1 + second * z2) / safe, fallback[:, 2])


def _with_pool(half: float, pool: float, size: float, refine: int) -> np.ndarray:
    """Return points from the middle of a barge to its side, with one at the wall of the moonpool."""
    outer = np.linspace(pool, half, refine * max(1, round((half - pool) / size)) + 1)
    inner = np.linspace(0.0, pool, refine * max(1, round(pool / size)) + 1)[:-1] if pool else []
    return np.concatenate([inner, outer])


def _wall(s: np.ndarray, z: np.ndarray, place) -> np.ndarray:
    points = np.array([[(*place(v), h) for v in s] for h in z])
    return _quads(points)


def _quads(points: np.ndarray) -> np.ndarray:
    """Return panels (p, 4, 3) of a grid of points (rows downward, columns counter-clockwise)."""
    lower, upper = points[1:], points[:-1]
    panels = np.stack([lower[:, :-1], lower[:, 1:], upper[:, 1:], upper[:, :-1]], axis=2)
    return panels.reshape(-1, 4, 3)
