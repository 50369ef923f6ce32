"""From the solved hulls of a plan to the coefficient database: deep water, and the changes to finite depths."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fowtio.database import GRAVITY, DatabasePlan, plan_axes, plan_nodes, task_path, tasks
from fowtio.errors import ModelError
from model.system.hydro_database import HydroDatabase, lagrange


def collect(plan: DatabasePlan, folder: str | Path) -> HydroDatabase:
    """Return the database of a solved plan; raises ModelError naming how much is missing."""
    folder = Path(folder)
    missing = [task for task in tasks(plan) if not task_path(folder, task).exists()]
    if missing:
        raise ModelError(f"{len(missing)} of {len(tasks(plan))} solutions are missing in {folder}; run fowtio database build again")
    solved = [dict(np.load(task_path(folder, ("hull", k, np.inf)))) for k in range(len(plan_nodes(plan)))]
    deep = np.array([d["values"] for d in solved])
    return assembled(plan, solved, [_change(plan, folder, depth, deep) for depth in plan.depths[1:]])


def assembled(plan: DatabasePlan, solved: list[dict], changes=()) -> HydroDatabase:
    """Return the database of a plan's hulls as `solve_hull` gives them, and of the changes (hull, row, quantity) to its other depths."""
    hulls, headings, axes = plan_nodes(plan), np.radians(plan.headings_deg), plan_axes(plan)
    rows = [
        np.concatenate([_still_row(plan, h, d["zero"], len(headings))[None], d["values"]])
        for h, d in zip(hulls, solved, strict=True)
    ]
    shape, deep = tuple(len(a) for a in axes), np.array(rows)
    values = [deep]
    for change in changes:
        here = deep.copy()
        here[:, 1 : 1 + change.shape[1]] += change
        values.append(here)
    values = np.array(values).reshape(len(values), *shape, *deep.shape[1:])
    infinite = np.array([d["infinite"] for d in solved]).reshape(*shape, 5)
    return HydroDatabase(
        diameter=axes[0], radius=axes[1], draft=axes[2], inverse_depth=1 / np.array(plan.depths), heading=headings,
        scaled_frequency=np.concatenate([[0.0], plan.scaled_frequency]), values=values, infinite=infinite, density=plan.density,
        gravity=GRAVITY, stretch=plan.stretch,
    )  # fmt: skip


def _change(plan: DatabasePlan, folder: Path, depth: float, deep: np.ndarray) -> np.ndarray:
    """Return the change of the low rows (hull, row, quantity) from deep water (hull, row, quantity) to a depth, from the coarser grid of hulls."""
    coarse, fine = plan_axes(plan, plan.depth_points), plan_axes(plan)
    tasks_here = [("depth", k, depth) for k in range(int(np.prod(plan.depth_points)))]
    here = np.array([np.load(task_path(folder, task))["values"] for task in tasks_here])
    return _between_grids(here - _between_grids(deep[:, : here.shape[1]], fine, coarse), coarse, fine)


def _between_grids(values: np.ndarray, given: list[np.ndarray], wanted: list[np.ndarray]) -> np.ndarray:
    """Return values (hull, ...) of one grid of hulls on another, by polynomials through them over the diameter squared."""
    weights = [lagrange(g, w)[0] for g, w in zip(given, wanted, strict=True)]
    tail = values.shape[1:]
    values = values.reshape(*map(len, given), -1) / given[0][:, None, None, None] ** 2
    values = np.einsum("ai,bj,ck,ijkq->abcq", *weights, values) * wanted[0][:, None, None, None] ** 2
    return values.reshape(-1, *tail)


def _still_row(plan: DatabasePlan, hull, zero: np.ndarray, headings: int) -> np.ndarray:
    """Return the row of zero frequency: added mass of still deep water, no damping, the waterplane's stiffness as excitation."""
    area = np.pi / 4 * (3 * hull[0] ** 2 + plan.central_diameter**2)
    force = np.zeros((headings, 6))
    force[:, 2] = plan.density * GRAVITY * area
    return np.concatenate([zero, np.zeros(5), force.ravel(), np.zeros(6 * headings)])
