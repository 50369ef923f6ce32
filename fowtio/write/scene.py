"""A floating turbine in three dimensions to scale: hull, tower, rotor, lines, still water."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from fowtio.bem_run import hull_meshes, read_hull
from fowtio.hull_mesh import whole
from fowtio.write.style import BLUE, INK, SKY, Drawing
from model.system.mooring import MooringSystem, line_profiles, mooring_state
from model.system.turbine import TurbineStructure

STEEL, TOWER, LINE = np.array([0.82, 0.71, 0.30]), "#6c7177", BLUE
LIGHT = np.array([0.4, -0.8, 0.45])
AROUND = 24
SLENDER = 0.03  # of the hull's reach: members below it are lines


@dataclass(frozen=True, eq=False, kw_only=True)
class Scene:
    """What is drawn: hull cylinders (m) from start to end (m, 3) [m] with diameters (m, 2) [m] there, further hull panels (p, 4, 3) [m],
    tower base, top and hub height [m], hub overhang [m] (negative: upwind), rotor diameter [m] and blades, mooring lines as
    points (k, 3) [m], water depth [m].
    """

    start: np.ndarray
    end: np.ndarray
    diameter: np.ndarray
    panels: np.ndarray
    tower: tuple[float, float]
    hub: tuple[float, float]
    rotor_diameter: float
    blades: int
    lines: Sequence[np.ndarray]
    depth: float


def scene(structure: TurbineStructure, start, end, diameter, mooring: MooringSystem | None, depth: float, panels=()) -> Scene:
    """Return the scene of a turbine on a hull of cylinders (and panels) with its lines at rest."""
    lines = () if mooring is None else tuple(line_profiles(mooring, mooring_state(mooring, np.zeros(6)))[0])
    rotor, tower = structure.rotor, structure.tower
    return Scene(
        start=np.reshape(start, (-1, 3)), end=np.reshape(end, (-1, 3)), diameter=np.reshape(diameter, (-1, 2)),
        panels=np.reshape(panels, (-1, 4, 3)), tower=(tower.base_height, tower.top_height), hub=(float(rotor.apex[0]), structure.hub_height),
        rotor_diameter=rotor.diameter, blades=rotor.blades, lines=lines, depth=depth,
    )  # fmt: skip


def model_scene(model) -> Scene:
    """Return the scene of a study (a Model of `fowtio.workflow`): HydroDyn's members, and the hull that the study names."""
    deck, panels = model.deck, ()
    if model.case.hull is not None:
        mesh = hull_meshes(read_hull(model.case.hull))[0]
        panels = np.concatenate([whole(mesh), whole(mesh, lid=True)])
    members = deck.hydrodyn.members
    return scene(deck.elastodyn.structure, members.start, members.end, members.diameter, deck.mooring, deck.depth, panels)


def scene_drawing(found: Scene) -> Drawing:
    """Return the picture of a scene, near and with the lines to the seabed, every axis to the same scale."""
    figure = Figure(figsize=(11.0, 5.6))
    points = np.concatenate([found.start, found.end, found.panels.reshape(-1, 3)])
    points = points if len(points) else np.zeros((1, 3))
    low, high = min(points[:, 2].min(), 0.0), found.hub[1] + found.rotor_diameter / 2
    flat = max(np.hypot(points[:, 0], points[:, 1]).max() + np.max(found.diameter, initial=0.0) / 2, found.rotor_diameter / 2) * 1.08
    reach = max([flat, *(1.02 * np.abs(line[:, :2]).max() for line in found.lines)])
    views = [(flat, low - 5, 1.02 * high), (reach, -found.depth, 1.02 * high)]
    for k, (view, title) in enumerate(zip(views, ("hull and turbine", "with the lines"), strict=True)):
        axes = figure.add_axes([0.01 + 0.47 * k, 0.04, 0.48, 0.88], projection="3d", proj_type="ortho")
        _draw(axes, found, *view, seabed=k == 1)
        figure.text(0.25 + 0.47 * k, 0.97, title, ha="center", va="top", fontsize=10)
    caption = f"To scale in all directions; lines at rest, water {found.depth:g} m deep. The hull is drawn from the cylinders that carry its drag."
    if len(found.panels):
        caption = caption.replace("from the cylinders", "from its panels below still water and from the cylinders")
    return Drawing(name="system", group="system", title="Hull, tower and lines", caption=caption, figure=figure)


def _draw(axes, found: Scene, half: float, low: float, high: float, *, seabed: bool) -> None:
    """Draw a scene inside a box: half its width, lowest and highest elevation [m]."""
    slender = found.diameter.max(axis=1, initial=0.0) < SLENDER * half
    solids = [_cylinder(*part) for part, thin in zip(zip(found.start, found.end, found.diameter, strict=True), slender, strict=True) if not thin]
    panels = np.concatenate([*solids, found.panels]) if solids or len(found.panels) else np.zeros((0, 4, 3))
    if len(panels):
        normal = np.cross(panels[:, 2] - panels[:, 0], panels[:, 3] - panels[:, 1])
        bright = 0.55 + 0.45 * np.clip(_unit(normal) @ _unit(LIGHT), 0, 1)
        colours = np.clip(STEEL * bright[:, None], 0, 1)
        axes.add_collection3d(Poly3DCollection(panels, facecolors=colours, edgecolors=colours, linewidths=0.25))
    for a, b in zip(found.start[slender], found.end[slender], strict=True):
        axes.plot(*zip(a, b, strict=True), color=0.8 * STEEL, lw=1.0)
    axes.plot([0, 0], [0, 0], [0, found.tower[0]], color=0.8 * STEEL, lw=3.0, solid_capstyle="butt")
    axes.plot([0, 0], [0, 0], found.tower, color="#8a8f94", lw=2.6, solid_capstyle="butt")
    x, z = found.hub
    axes.plot([-x / 2, x], [0, 0], [z, z], color=TOWER, lw=3.4)
    for angle in np.pi / 2 + 2 * np.pi * np.arange(found.blades) / max(found.blades, 1):
        tip = found.rotor_diameter / 2 * np.array([np.cos(angle), np.sin(angle)])
        axes.plot([x, x], [0, tip[0]], [z, z + tip[1]], color=INK, lw=1.4)
    for line in found.lines:
        inside = np.all(np.abs(line[:, :2]) <= half, axis=1) & (line[:, 2] >= low)
        axes.plot(*line[inside].T, color=LINE, lw=0.9)
    for level, colour in ((0.0, SKY), (-found.depth, "#8C6D46"))[: 1 + seabed]:
        corners = half * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) + [0, 0, level]
        axes.add_collection3d(Poly3DCollection([corners], facecolors=colour, alpha=0.16, edgecolors="none"))
    _frame(axes, half, low, high)


def _frame(axes, half: float, low: float, high: float) -> None:
    axes.set(xlim=(-half, half), ylim=(-half, half), zlim=(low, high), xlabel="x [m]", ylabel="y [m]", zlabel="z [m]")
    axes.zaxis.labelpad = 2
    axes.set_box_aspect((2 * half, 2 * half, high - low), zoom=0.9)
    axes.view_init(elev=12, azim=-62)
    axes.tick_params(labelsize=7, pad=-1)
    axes.xaxis.labelpad = axes.yaxis.labelpad = 0
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.set_pane_color((1, 1, 1, 0))
        axis.set_major_locator(MaxNLocator(5))


def _cylinder(start, end, diameter) -> np.ndarray:
    """Return the panels (p, 4, 3) of a closed cylinder or cone, normals outwards; ends as quarters that meet on the axis."""
    axis = _unit(end - start)
    side = _unit(np.cross(axis, [0.0, 0.0, 1.0] if abs(axis[2]) < 0.9 else [1.0, 0.0, 0.0]))
    up = np.cross(axis, side)
    angle = np.linspace(0, 2 * np.pi, AROUND + 1)
    circle = np.cos(angle)[:, None] * side + np.sin(angle)[:, None] * up
    low, high = (p + d / 2 * circle for p, d in ((start, diameter[0]), (end, diameter[1])))
    wall = np.stack([low[:-1], low[1:], high[1:], high[:-1]], axis=1)
    ends = [np.stack([np.broadcast_to(p, r[:-1].shape), r[a], r[b], r[b]], axis=1) for p, r, a, b in (
        (start, low, slice(1, None), slice(None, -1)), (end, high, slice(None, -1), slice(1, None))
    )]  # fmt: skip
    return np.concatenate([wall, *ends])


def _unit(v):
    return v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-300)
