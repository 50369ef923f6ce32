"""Pictures of hulls and coefficients: a floating turbine in three dimensions to scale, and checks of the database."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fowtio.bem_run import hull_meshes
from fowtio.hull_mesh import area_vectors, whole

WATER, STEEL, LINE, INK = "#9cc3d5", "#c9b458", "#444444", "#222222"


def _plt():
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    return plt


def draw_system(design, path: str | Path, *, wind_speed: float = 0.0) -> Path:
    """Draw hull, tower, rotor and lines of a semisubmersible in three dimensions, all axes to the same scale; return the path."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    from fowtio.hull_turbine import ten_megawatt_structure
    from model.design.hull import brace_lines
    from model.system.mooring import line_profiles, mooring_state

    plt = _plt()
    figure = plt.figure(figsize=(12, 6.2))
    hull, structure, system = design.hull, ten_megawatt_structure(), design.mooring()
    lines, _ = line_profiles(system, mooring_state(system, np.zeros(6)))
    for k, (box, title) in enumerate((("near", "hull and turbine"), ("all", "with the lines"))):
        axes = figure.add_subplot(1, 2, k + 1, projection="3d", proj_type="ortho", computed_zorder=True)
        panels = _hull_panels(hull)
        shade = 0.55 + 0.45 * np.clip(_unit(area_vectors(panels)) @ _unit(np.array([0.4, -0.8, 0.5])), 0, 1)
        colours = np.clip(np.array([0.82, 0.71, 0.30]) * shade[:, None], 0, 1)
        axes.add_collection3d(Poly3DCollection(panels, facecolors=colours, edgecolors="none"))
        for _, start, end in brace_lines(hull):
            for a in (0.0, 2 * np.pi / 3, 4 * np.pi / 3):
                turn = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1.0]])
                axes.plot(*zip(turn @ start, turn @ end, strict=True), color="#a08c3c", lw=1.0)
        _draw_turbine(axes, structure, hull)
        if box == "all":
            for points in lines:
                axes.plot(*points.T, color=LINE, lw=0.9)
            reach = design.anchor_radius
            limits = ((-reach, reach), (-reach, reach), (-design.depth, 210))
        else:
            limits = ((-100, 100), (-100, 100), (-float(hull.draft) - 5, 212))
            for points in lines:
                near = np.linalg.norm(points[:, :2], axis=1) < 105
                axes.plot(*points[near].T, color=LINE, lw=0.9)
        corner = np.array([[limits[0][i], limits[1][j], 0.0] for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))])
        axes.add_collection3d(Poly3DCollection([corner], facecolors=WATER, alpha=0.22, edgecolors="none"))
        axes.set(xlim=limits[0], ylim=limits[1], zlim=limits[2], title=title)
        axes.set_box_aspect([high - low for low, high in limits], zoom=(0.92, 1.15)[k])
        axes.view_init(elev=12, azim=-62)
        axes.set_xlabel("x (m)", labelpad=4)
        axes.set_ylabel("y (m)", labelpad=4)
        axes.tick_params(labelsize=7, pad=0)
    figure.subplots_adjust(left=0.0, right=0.94, bottom=0.03, top=0.92, wspace=0.12)
    figure.suptitle(
        f"column {float(hull.diameter):g} m, radius {float(hull.radius):g} m, draft {float(hull.draft):g} m, depth {design.depth:g} m",
        fontsize=10,
    )
    return _saved(figure, path)


def _unit(v):
    return v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-300)


def _hull_panels(hull) -> np.ndarray:
    """Return panels of columns and plates above and below still water, for drawing."""
    from fowtio.hull_mesh import revolved
    from model.design.hull import AZIMUTHS

    r, plate, keel = float(hull.diameter) / 2, float(hull.plate_diameter) / 2, -float(hull.draft)
    top, deck, shelf = float(hull.column_freeboard), float(hull.central_freeboard), keel + float(hull.plate_height)
    column = [(0.0, top), (r, top), (r, shelf), (plate, shelf), (plate, keel), (0.0, keel)]
    middle = [
        (0.0, deck),
        (float(hull.central_diameter) / 2, deck),
        (float(hull.central_diameter) / 2, keel),
        (0.0, keel),
    ]
    parts = [revolved(middle, 6.0, 18)]
    parts += [revolved(column, 6.0, 28, centre=float(hull.radius) * np.array([np.cos(a), np.sin(a)])) for a in AZIMUTHS]
    return np.concatenate(parts)


def _draw_turbine(axes, structure, hull) -> None:
    """Draw tower and rotor as lines to scale."""
    base, top = float(hull.central_freeboard), structure.tower.top_height
    axes.plot([0, 0], [0, 0], [base, top], color="#8a8f94", lw=3.0, solid_capstyle="butt")
    hub = np.array([structure.rotor.apex[0], 0.0, structure.hub_height])
    axes.plot([4, hub[0]], [0, 0], [hub[2], hub[2]], color="#6c7177", lw=4.0)
    span = structure.rotor.diameter / 2
    for a in np.radians([90.0, 210.0, 330.0]):
        axes.plot([hub[0], hub[0]], [0, span * np.cos(a)], [hub[2], hub[2] + span * np.sin(a)], color=INK, lw=1.6)


def draw_check(found: list[dict], folder: Path) -> Path:
    """Draw solved and interpolated coefficients of held-out hulls into a folder; return the picture's path."""
    plt = _plt()
    folder.mkdir(parents=True, exist_ok=True)
    names = (
        ("A11", 0, 0),
        ("A33", 0, 1),
        ("A55", 0, 2),
        ("B11", 1, 0),
        ("B33", 1, 1),
        ("B55", 1, 2),
        ("|X1|", 2, 0),
        ("|X3|", 2, 2),
        ("|X5|", 2, 4),
    )
    figure, grid = plt.subplots(3, 3, figsize=(11, 8), sharex=True, constrained_layout=True)
    for axes, (name, part, k) in zip(grid.ravel(), names, strict=True):
        for number, row in enumerate(found[:4]):
            solved, guessed = (
                np.abs(row["curves"][w][part][:, 0, k]) if part == 2 else row["curves"][w][part][:, k]
                for w in ("solved", "interpolated")
            )
            colour = f"C{number}"
            axes.plot(
                row["omega"],
                guessed,
                color=colour,
                lw=1.2,
                label="d {:.1f}, r {:.1f}, draft {:.1f} m".format(*row["hull"]),
            )
            axes.plot(row["omega"], solved, ".", color=colour, ms=3.5)
        axes.set_title(name, fontsize=9)
        axes.tick_params(labelsize=7)
        axes.grid(alpha=0.25)
    grid[0, 0].legend(fontsize=6, title="line: interpolated, dots: solved", title_fontsize=6)
    for axes in grid[-1]:
        axes.set_xlabel("frequency (rad/s)", fontsize=8)
    figure.suptitle("Hulls that the database has not seen, deep water, heading 0 (SI units)", fontsize=10)
    return _saved(figure, folder / "database_check.png")


def draw_comparison(own, reference, path: str | Path, *, labels=("fowtio", "WAMIT"), title: str = "") -> Path:
    """Draw added mass and damping of two solutions of the same hull; return the path."""
    plt = _plt()
    figure, grid = plt.subplots(2, 3, figsize=(11, 5.6), sharex=True, constrained_layout=True)
    for column, k in zip(grid.T, (0, 2, 4), strict=True):
        for axes, name, letter in zip(column, ("added_mass", "radiation_damping"), "AB", strict=True):
            keep = reference.omega <= own.omega[-1]
            axes.plot(reference.omega[keep], getattr(reference, name)[keep, k, k], color=INK, lw=1.0, label=labels[1])
            axes.plot(own.omega, getattr(own, name)[:, k, k], ".", color="C3", ms=4, label=labels[0])
            axes.set_title(f"{letter}{k + 1}{k + 1}", fontsize=9)
            axes.tick_params(labelsize=7)
            axes.grid(alpha=0.25)
    grid[0, 0].legend(fontsize=8)
    for axes in grid[1]:
        axes.set_xlabel("frequency (rad/s)", fontsize=8)
    figure.suptitle(title, fontsize=10)
    return _saved(figure, path)


def draw_mesh(hull, path: str | Path) -> Path:
    """Draw the fine mesh of a hull file; return the path."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    plt = _plt()
    panels = whole(hull_meshes(hull)[-1])
    figure = plt.figure(figsize=(6, 5))
    axes = figure.add_subplot(projection="3d", proj_type="ortho")
    axes.add_collection3d(Poly3DCollection(panels, facecolors="#d8c46a", edgecolors="#6b6130", linewidths=0.2))
    low, high = panels.reshape(-1, 3).min(axis=0), panels.reshape(-1, 3).max(axis=0)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_title(hull.title, fontsize=9)
    axes.tick_params(labelsize=7)
    axes.locator_params(axis="z", nbins=4)
    axes.set_box_aspect(high - low)
    return _saved(figure, path)


def _saved(figure, path: str | Path) -> Path:
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=140)
    _plt().close(figure)
    return path
