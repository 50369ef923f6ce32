"""The coefficient database: a family of hulls solved on a tensor grid of Chebyshev points, resumable, checked, packed.

The family is the three-column semisubmersible (column diameter, platform radius, draft). Frequencies are chosen for every
hull as omega = s sqrt(g / radius) with common s: the phases of the waves between the columns, exp(i k radius), are then the
same on all hulls, and what is left varies smoothly with the geometry.
"""

from __future__ import annotations

import hashlib
import json
import os
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from fowtio.bem import BemSettings, capytaine_body, extrapolated, load_capytaine, solve_frequency
from fowtio.hulls import semi_mesh

GRAVITY = 9.80665


@dataclass(frozen=True, kw_only=True)
class DatabasePlan:
    """What is computed: bounds [m] and numbers of Chebyshev points of diameter, radius and draft; water depths [m];
    scaled frequencies s; headings [rad]; panels (numbers along column, plate top, plate side, bottom; around; central column).
    """

    diameter: tuple[float, float, int] = (14.0, 20.0, 4)
    radius: tuple[float, float, int] = (30.0, 45.0, 6)
    draft: tuple[float, float, int] = (20.0, 32.0, 5)
    depths: tuple[float, ...] = (200.0, np.inf, 370.0)
    scaled_frequency: tuple[float, ...] = tuple(np.round(np.r_[np.arange(1, 35) * 0.1, 3.4 + np.arange(1, 9) * 0.15], 3))
    headings_deg: tuple[float, ...] = (0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0)
    central_diameter: float = 8.3
    plate_ratio: float = 2.0
    plate_thickness: float = 6.0
    panels: tuple[int, ...] = (4, 2, 1, 3)
    around: int = 14
    density: float = 1025.0
    method: str = "direct"


def chebyshev_points(low: float, high: float, count: int) -> np.ndarray:
    """Return the Chebyshev points of the second kind (count) on [low, high], ascending, ends included."""
    return (low + high) / 2 - (high - low) / 2 * np.cos(np.pi * np.arange(count) / (count - 1))


def plan_nodes(plan: DatabasePlan) -> np.ndarray:
    """Return the hulls (k, 3) of a plan: diameter, radius, draft [m], draft running fastest."""
    axes = [chebyshev_points(*getattr(plan, name)) for name in ("diameter", "radius", "draft")]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


def plan_meshes(plan: DatabasePlan, diameter: float, radius: float, draft: float) -> list:
    """Return the coarse and the fine mesh of one hull, with the same number of panels for every hull."""
    common = dict(
        plate_diameter=plan.plate_ratio * diameter, plate_thickness=plan.plate_thickness,
        central_diameter=plan.central_diameter, size=plan.panels, around=plan.around,
    )  # fmt: skip
    return [semi_mesh(diameter, radius, draft, refine=refine, **common) for refine in (1, 2)]


def solve_hull(plan: DatabasePlan, hull, depth: float) -> dict[str, np.ndarray]:
    """Return the packed coefficients of one hull: values (frequency, quantity), see `pack`; deep rows first solved elsewhere.

    In a finite depth only the frequencies that feel the bottom (k h < 5) are solved; the others are not a number.
    """
    settings = BemSettings(
        depth=depth, density=plan.density, gravity=GRAVITY, method=plan.method,
        headings=tuple(np.radians(plan.headings_deg)),
    )  # fmt: skip
    bodies = [capytaine_body(m) for m in plan_meshes(plan, *hull)]
    solver = load_capytaine().BEMSolver(method=plan.method)
    omega = np.array(plan.scaled_frequency) * np.sqrt(GRAVITY / hull[1])
    rows = []
    for w in omega:
        if np.isfinite(depth) and w**2 * depth / GRAVITY > 5.0:
            rows.append(np.full(10 + 12 * len(plan.headings_deg), np.nan))
            continue
        rows.append(pack(*(solve_frequency(b, w, settings, solver) for b in bodies)))
    out = {"values": np.array(rows), "omega": omega}
    if not np.isfinite(depth):
        for name, w in (("zero", 0.0), ("infinite", np.inf)):
            coarse, fine = (solve_frequency(b, w, settings, solver) for b in bodies)
            out[name] = reduced(extrapolated(coarse["added_mass"], fine["added_mass"]))
    return out


def pack(coarse: dict, fine: dict) -> np.ndarray:
    """Return one row: five added masses, five dampings (11, 33, 55, 66, 15) and excitation (real, imaginary) by heading and motion."""
    added, damping, force = (
        extrapolated(coarse[name], fine[name]) for name in ("added_mass", "radiation_damping", "excitation")
    )
    return np.concatenate([reduced(added), reduced(damping), force.real.ravel(), force.imag.ravel()])


def reduced(matrix: np.ndarray) -> np.ndarray:
    """Return the five numbers of a matrix with three-fold symmetry: 11 = 22, 33, 55 = 44, 66, 15 = -24."""
    m = matrix
    return np.array([
        (m[0, 0] + m[1, 1]) / 2, m[2, 2], (m[3, 3] + m[4, 4]) / 2, m[5, 5], (m[0, 4] + m[4, 0] - m[1, 3] - m[3, 1]) / 4
    ])  # fmt: skip


def tasks(plan: DatabasePlan) -> list[tuple[int, float]]:
    """Return (hull number, depth) of everything to solve, deep water first."""
    order = sorted(plan.depths, key=lambda h: (np.isfinite(h), h))
    return [(k, h) for h in order for k in range(len(plan_nodes(plan)))]


def run_task(plan: DatabasePlan, number: int, depth: float, folder: str | Path) -> Path:
    """Solve one hull in one depth and keep it in the folder; a result that is already there is left alone."""
    path = Path(folder) / f"hull{number:04d}_depth{depth:g}.npz"
    if path.exists():
        return path
    found = solve_hull(plan, plan_nodes(plan)[number], depth)
    part = path.with_suffix(f".{os.getpid()}.tmp")
    with open(part, "wb") as file:
        np.savez(file, **found)
    os.replace(part, path)
    return path


def fingerprint(plan: DatabasePlan) -> str:
    """Return the checksum of a plan: results in a folder belong to one plan only."""
    return hashlib.sha256(json.dumps(asdict(plan), sort_keys=True, default=str).encode()).hexdigest()[:16]


def solve_plan(plan: DatabasePlan, folder: str | Path, *, jobs: int = 2, progress=None) -> None:
    """Solve what is missing of a plan, in parallel over hulls through joblib; a stopped run goes on where it was."""
    from joblib import Parallel, delayed

    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    mark = folder / "plan.json"
    text = json.dumps({"fingerprint": fingerprint(plan), **asdict(plan)}, indent=1, default=str)
    if mark.exists() and json.loads(mark.read_text())["fingerprint"] != fingerprint(plan):
        from fowtio.errors import ModelError

        raise ModelError(f"{folder} holds results of another plan; give another folder or remove it")
    mark.write_text(text + "\n", encoding="utf-8")
    todo = [(k, h) for k, h in tasks(plan) if not (folder / f"hull{k:04d}_depth{h:g}.npz").exists()]
    done = len(tasks(plan)) - len(todo)
    work = (delayed(run_task)(plan, k, h, str(folder)) for k, h in todo)
    for _ in Parallel(n_jobs=jobs, return_as="generator_unordered")(work):
        done += 1
        if progress:
            progress(done, len(tasks(plan)))
