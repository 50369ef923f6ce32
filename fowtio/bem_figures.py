"""Pictures of hulls and coefficients: a floating turbine in three dimensions to scale, and checks of the database."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fowtio.bem_run import hull_meshes
from fowtio.hull_mesh import whole

INK = "#222222"


def _plt():
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    return plt


def draw_system(design, path: str | Path) -> Path:
    """Draw hull, tower, rotor and lines of a semisubmersible in three dimensions, all axes to the same scale; return the path."""
    from fowtio.hull_turbine import ten_megawatt_structure
    from fowtio.write.scene import scene, scene_drawing

    start, end, diameter = zip(*_cylinders(design.hull), strict=True)
    found = scene(ten_megawatt_structure(), start, end, np.repeat(diameter, 2), design.mooring(), design.depth)
    return _saved(scene_drawing(found).figure, path)


def _cylinders(hull) -> list[tuple]:
    """Return start, end (3) [m] and diameter [m] of columns, plates, pontoons and braces above and below still water."""
    from model.design.hull import AZIMUTHS, brace_lines

    keel, shelf, z = -float(hull.draft), float(hull.plate_height - hull.draft), np.array([0.0, 0.0, 1.0])
    out = [(keel * z, hull.central_freeboard * z, hull.central_diameter)]
    for a in AZIMUTHS:
        p = hull.radius * np.array([np.cos(a), np.sin(a), 0.0])
        out += [(p + shelf * z, p + hull.column_freeboard * z, hull.diameter), (p + keel * z, p + shelf * z, hull.plate_diameter)]
    for _, start, end in brace_lines(hull):
        for a in (0.0, 2 * np.pi / 3, 4 * np.pi / 3):
            turn = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1.0]])
            out.append((turn @ start, turn @ end, hull.brace_diameter))
    return out


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
            unit = ("kg" if k < 3 else "kg m²") + ("/s" if letter == "B" else "")
            axes.set_title(f"{letter}{k + 1}{k + 1} ({unit})", fontsize=9)
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
