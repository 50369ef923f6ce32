"""Panel meshes of the usual floating hulls: semisubmersible, spar, barge and tension-leg platform."""

from __future__ import annotations

import numpy as np

from fowtio.hull_mesh import HullMesh, box, box_lid, lid_disc, revolved, tube

SIXTH = (2 * np.pi / 3, np.pi)
HALF = (0.0, np.pi)
QUARTER = (0.0, np.pi / 2)


def semi_mesh(
    diameter: float, radius: float, draft: float, *, plate_diameter: float | None = None, plate_thickness: float = 6.0,
    central_diameter: float = 8.3, central_draft: float | None = None, size=6.0, around: int = 12, refine: int = 1,
    members=(),
) -> HullMesh:  # fmt: skip
    """Return the mesh of a three-column semisubmersible with heave plates and a central column, one column at -x.

    Column diameter, radius of the platform (axis to column axis), draft, heave plate diameter (twice the column's when not
    given) and thickness, central column's diameter and draft [m]; panels of `size` [m] along the profile (or their
    numbers along column, plate top, plate side and bottom) and `around` on a circle, both divided by `refine`. members: pontoons and braces (start (3), end (3), diameter) of one sixth of the hull
    (see `semi_braces`). Three-fold and mirror symmetry.
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
        revolved(column, size, around, refine=refine, centre=centre, sector=HALF),
        revolved(middle, inner, inner_around, refine=refine, sector=SIXTH),
    ]
    parts += [_member(m, refine) for m in members]
    lid = [
        lid_disc(r, rings, around, refine=refine, centre=centre, sector=HALF),
        lid_disc(central_diameter / 2, 1, inner_around, refine=refine, sector=SIXTH),
    ]
    return HullMesh(part=np.concatenate(parts), lid=np.concatenate(lid), symmetry="three-fold xz")


def spar_mesh(profile, *, size: float = 4.0, around: int = 16, refine: int = 1) -> HullMesh:
    """Return the mesh of a body of revolution about the z axis: profile (k, 2) radius and elevation [m] from the waterline down.

    A closing disc is added when the profile does not end on the axis. Two planes of symmetry.
    """
    profile = [tuple(p) for p in profile]
    if profile[-1][0] > 0:
        profile.append((0.0, profile[-1][1]))
    lid = lid_disc(profile[0][0], max(1, round(profile[0][0] / size)), around, refine=refine, sector=QUARTER)
    return HullMesh(part=revolved(profile, size, around, refine=refine, sector=QUARTER), lid=lid, symmetry="xz yz")


def barge_mesh(
    length: float, width: float, draft: float, *, moonpool: float = 0.0, size: float = 4.0, refine: int = 1
) -> HullMesh:
    """Return the mesh of a box barge [m] with a square moonpool (side, 0 is none); two planes of symmetry."""
    shape = (length / 2, width / 2)
    return HullMesh(
        part=box(*shape, draft, size, refine=refine, moonpool=moonpool),
        lid=box_lid(*shape, size, refine=refine, moonpool=moonpool), symmetry="xz yz",
    )  # fmt: skip
