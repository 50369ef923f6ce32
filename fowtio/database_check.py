"""The error of the coefficient database: interpolated coefficients against fresh solutions of hulls that it has not seen."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from fowtio.database import DatabasePlan, fingerprint, low_rows, plan_frequencies, reduced, solve_hull
from model.system.hydro_database import HydroDatabase, interpolate


def held_out(
    database: HydroDatabase, plan: DatabasePlan, designs, *, depth: float = np.inf, jobs: int = 2, folder: str | Path | None = None
) -> list[dict]:
    """Return the errors of interpolated coefficients on hulls (N, 3) that the database has not seen, solved afresh.

    Solved half-way between the plan's frequencies and headings (and at heading 0), where interpolation is worst. For every
    hull the largest difference over all of them, as a share of the largest value of that coefficient on the hull, for the
    five added masses, the five dampings and the six excitations; both curves besides.
    """
    from joblib import Parallel, delayed

    designs, between = np.atleast_2d(designs), plan_between(plan)
    rows = None if np.isinf(depth) else low_rows(between)
    work = (delayed(_solved_before)(between, tuple(map(float, hull)), depth, rows, folder) for hull in designs)
    return [
        errors(database, between, hull, found, depth)
        for hull, found in zip(designs, Parallel(n_jobs=jobs)(work), strict=True)
    ]


def plan_between(plan: DatabasePlan) -> DatabasePlan:
    """Return the plan with frequencies and headings half-way between its own, and heading 0."""
    s, heading = np.array(plan.scaled_frequency), np.array(plan.headings_deg)
    return replace(
        plan, scaled_frequency=tuple(((s[1:] + s[:-1]) / 2).tolist()), headings_deg=(0.0, *((heading[1:] + heading[:-1]) / 2).tolist())
    )  # fmt: skip


def _solved_before(plan, hull, depth, rows, folder):
    """Solve a hull, or take it from the folder where it was solved before."""
    if folder is None:
        return solve_hull(plan, hull, depth, rows)
    Path(folder).mkdir(parents=True, exist_ok=True)
    path = Path(folder) / (f"test_{fingerprint(plan)}_" + "_".join(f"{x:.4f}" for x in hull) + f"_{depth:g}.npz")
    if not path.exists():
        np.savez(path, **solve_hull(plan, hull, depth, rows))
    return dict(np.load(path))


def errors(database: HydroDatabase, plan: DatabasePlan, hull, found: dict, depth: float) -> dict:
    """Return the errors of one hull (see `held_out`) from its solution at the frequencies and headings of a plan."""
    m, omega, values = len(plan.headings_deg), found["omega"], found["values"]
    heading = np.radians(plan.headings_deg)
    solved = (
        values[:, :5],
        values[:, 5:10],
        (values[:, 10 : 10 + 6 * m] + 1j * values[:, 10 + 6 * m :]).reshape(-1, m, 6),
    )
    guessed = _reduced_batch(interpolate(database, hull, omega, heading, depth=depth))
    largest = _reduced_batch(interpolate(database, hull, plan_frequencies(plan, hull), heading, depth=depth))
    out = {
        "hull": tuple(map(float, hull)),
        "depth": depth,
        "omega": omega,
        "curves": {"solved": solved, "interpolated": guessed},
    }
    for name, a, b, c, axes in zip(
        ("added_mass", "radiation_damping", "excitation"), guessed, solved, largest, (0, 0, (0, 1)), strict=True
    ):
        out[name] = (np.abs(a - b) / np.abs(c).max(axis=axes)).max(axis=axes)
    return out


def _reduced_batch(batch) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return one hull's added mass and damping (n, 5) and excitation (n, m, 6)."""
    added, damping = (np.array([reduced(x) for x in a[0]]) for a in (batch.added_mass, batch.radiation_damping))
    return added, damping, np.moveaxis(batch.excitation[0], 0, 1)
