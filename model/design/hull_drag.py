"""Drag elements of the parametric semisubmersible, for one design or many at once.

Members are those that a HydroDyn deck of the hull would hold, with the same Gauss points along each, so that a design
among many and the same design read from its deck have the same drag.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from model.design.hull import AZIMUTHS, SemiHull, wet_braces
from model.system.drag import DragMembers

DRAG = {"column": 0.61, "plate": 0.68, "central": 0.56, "brace": 0.63, "plate_axial": 9.6}
STRIP_LENGTH = 10.0  # m: one Gauss point for about every 10 m of wetted length and one more, as for decks
_TURNS = (0.0, 2 * np.pi / 3, 4 * np.pi / 3)


@dataclass(frozen=True, eq=False, kw_only=True)
class HullMember:
    """A cylinder of the hull: name, start (the lower) and end (..., 3) [m], wetted part only, diameter (...) [m], transverse drag
    coefficient, and axial drag coefficient (HydroDyn's AxCd) of its bottom.
    """

    name: str
    start: np.ndarray
    end: np.ndarray
    diameter: np.ndarray
    drag: float
    axial_drag: float = 0.0


def wetted_members(hull: SemiHull, coefficients: dict = DRAG) -> list[HullMember]:
    """Return the members of a hull below still water: central column, columns, heave plates, pontoons and braces.

    coefficients: transverse Cd of columns, plates (their sides), central column and braces; plate_axial is HydroDyn's AxCd of
    the plates' bottoms. The defaults are those of OC4 (Robertson et al. 2014), constant with size.
    """
    draft, radius, height, plate, column, central = np.broadcast_arrays(
        hull.draft, hull.radius, hull.plate_height, hull.plate_diameter, hull.diameter, hull.central_diameter
    )

    def point(angle, z):
        return np.stack([radius * np.cos(angle), radius * np.sin(angle), z], axis=-1)

    zero = np.zeros_like(draft)
    axis_low, axis_high = np.stack([zero, zero, -draft], axis=-1), np.zeros(draft.shape + (3,))
    out = [HullMember(name="central column", start=axis_low, end=axis_high, diameter=central, drag=coefficients["central"])]
    for k, a in enumerate(AZIMUTHS, start=1):
        shelf = point(a, height - draft)
        out.append(HullMember(name=f"column {k}", start=shelf, end=point(a, zero), diameter=column, drag=coefficients["column"]))
        out.append(HullMember(
            name=f"heave plate {k}", start=point(a, -draft), end=shelf, diameter=plate, drag=coefficients["plate"],
            axial_drag=coefficients["plate_axial"],
        ))  # fmt: skip
    for name, start, end in wet_braces(hull):
        for k, a in enumerate(_TURNS, start=1):
            turn = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1.0]])
            out.append(HullMember(
                name=f"{name} {k}", start=start @ turn.T, end=end @ turn.T, diameter=np.broadcast_to(hull.brace_diameter, draft.shape),
                drag=coefficients["brace"],
            ))  # fmt: skip
    return out


def hull_elements(hull: SemiHull, *, density: float = 1025.0, coefficients: dict = DRAG) -> DragMembers:
    """Return the drag elements of N designs (hull of shape (N,)), design by design, each with the same number of elements.

    Gauss points along every member and the bottoms of the heave plates; where a member needs fewer points than another
    design's, elements without drag fill up. K = 1/2 rho Cd D L of a strip, 1/4 rho AxCd A of a bottom.
    """
    parts = []
    for member in wetted_members(hull, coefficients):
        parts.append(_strips(member, density))
        if member.axial_drag:
            parts.append(_bottom(member, density))
    position, axis, factor, axial, diameter, length = (np.concatenate(column, axis=1) for column in zip(*parts, strict=True))
    return DragMembers(
        position=position.reshape(-1, 3), axis=axis.reshape(-1, 3), factor=factor.ravel(), axial=axial.ravel(),
        diameter=diameter.ravel(), length=length.ravel(),
    )  # fmt: skip


def drag_members(hull: SemiHull, *, density: float = 1025.0, coefficients: dict = DRAG) -> DragMembers:
    """Return one design's drag elements below still water; raise ValueError for several designs."""
    if hull.shape != ():
        raise ValueError(f"one design is needed, these are {hull.shape}")
    return hull_elements(hull, density=density, coefficients=coefficients)


@cache
def _gauss(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes and weights on [-1, 1]."""
    return np.polynomial.legendre.leggauss(count)


def _strips(member: HullMember, density: float):
    """Return position (N, k, 3), axis, factor (N, k), axial, diameter and length of one member's strips."""
    start, way = np.atleast_2d(member.start), np.atleast_2d(member.end - member.start)
    full = np.linalg.norm(way, axis=-1)
    count = np.where(full < 1.0, 1, np.ceil(full / STRIP_LENGTH).astype(int) + 1)
    along, weight = np.zeros((2, len(full), count.max()))
    for n in np.unique(count):
        x, w = _gauss(int(n))
        along[count == n, :n], weight[count == n, :n] = (x + 1) / 2, w / 2
    length = weight * full[:, None]
    diameter = np.broadcast_to(np.atleast_1d(member.diameter)[:, None], length.shape)
    axis = np.broadcast_to((way / full[:, None])[:, None], (*length.shape, 3))
    position = start[:, None] + along[..., None] * way[:, None]
    return position, axis, density / 2 * member.drag * diameter * length, np.zeros_like(length), diameter, length


def _bottom(member: HullMember, density: float):
    """Return the same of a member's bottom."""
    start, diameter = np.atleast_2d(member.start)[:, None], np.atleast_1d(member.diameter)[:, None]
    axis = np.broadcast_to([0.0, 0.0, 1.0], start.shape)
    one = np.ones_like(diameter)
    return start, axis, density * member.axial_drag * np.pi * diameter**2 / 16, one, diameter, 0 * one
