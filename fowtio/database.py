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
import xarray as xr

from fowtio.bem import BemSettings, capytaine_body, extrapolated, load_capytaine, solve_frequency
from fowtio.errors import FormatError, ModelError
from fowtio.hulls import semi_mesh
from model.system.hydro_database import HydroDatabase

GRAVITY = 9.80665
FORM = "fowtio hydrodynamic database 1"
EMBEDDED = "semi_10mw/semi_database.nc"


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
    common = {
        "plate_diameter": plan.plate_ratio * diameter, "plate_thickness": plan.plate_thickness,
        "central_diameter": plan.central_diameter, "size": plan.panels, "around": plan.around,
    }  # fmt: skip
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


def solve_plan(plan: DatabasePlan, folder: str | Path, *, jobs: int = 2, dask: str | None = None, progress=None) -> None:
    """Solve what is missing of a plan, in parallel over hulls through joblib; a stopped run goes on where it was.

    dask is the address of a scheduler (host:port) whose workers see the folder; without it `jobs` processes run here.
    """
    from joblib import Parallel, delayed

    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    mark = folder / "plan.json"
    text = json.dumps({"fingerprint": fingerprint(plan), **asdict(plan)}, indent=1, default=str)
    if mark.exists() and json.loads(mark.read_text())["fingerprint"] != fingerprint(plan):
        raise ModelError(f"{folder} holds results of another plan; give another folder or remove it")
    mark.write_text(text + "\n", encoding="utf-8")
    todo = [(k, h) for k, h in tasks(plan) if not (folder / f"hull{k:04d}_depth{h:g}.npz").exists()]
    done = len(tasks(plan)) - len(todo)
    work = (delayed(run_task)(plan, k, h, str(folder)) for k, h in todo)
    for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(variable, "1")
    if progress:
        progress(done, len(tasks(plan)))
    if dask:
        _on_dask(work, dask)
        return
    for _ in Parallel(n_jobs=jobs, return_as="generator_unordered")(work):
        done += 1
        if progress:
            progress(done, len(tasks(plan)))


def _on_dask(work, address: str) -> None:
    """Run delayed tasks on the workers of a Dask scheduler."""
    try:
        from dask.distributed import Client
    except ImportError as error:
        raise ModelError("a Dask cluster needs the package distributed: pip install distributed") from error
    from joblib import Parallel, parallel_config

    with Client(address), parallel_config(backend="dask"):
        Parallel()(work)


def collect(plan: DatabasePlan, folder: str | Path) -> HydroDatabase:
    """Return the database of a solved plan; raises ModelError naming how much is missing."""
    folder, hulls = Path(folder), plan_nodes(plan)
    missing = [1 for k, h in tasks(plan) if not (folder / f"hull{k:04d}_depth{h:g}.npz").exists()]
    if missing:
        raise ModelError(f"{len(missing)} of {len(tasks(plan))} solutions are missing in {folder}; run fowtio database build again")
    headings = np.radians(plan.headings_deg)
    depths = sorted(plan.depths, reverse=True)
    values, infinite = [], []
    for depth in depths:
        rows = []
        for k, hull in enumerate(hulls):
            deep = dict(np.load(folder / f"hull{k:04d}_depthinf.npz"))
            here = dict(np.load(folder / f"hull{k:04d}_depth{depth:g}.npz"))["values"]
            here = np.where(np.isnan(here), deep["values"], here)
            rows.append(np.concatenate([_still_row(plan, hull, deep["zero"], len(headings))[None], here]))
            if depth == depths[0]:
                infinite.append(deep["infinite"])
        values.append(rows)
    axes = [chebyshev_points(*getattr(plan, name)) for name in ("diameter", "radius", "draft")]
    shape = tuple(len(a) for a in axes)
    values = np.array(values, dtype=np.float32)
    return HydroDatabase(
        diameter=axes[0], radius=axes[1], draft=axes[2], inverse_depth=1 / np.array(depths), heading=headings,
        scaled_frequency=np.concatenate([[0.0], plan.scaled_frequency]), values=values.reshape(len(depths), *shape, *values.shape[2:]),
        infinite=np.array(infinite, dtype=np.float32).reshape(*shape, 5), density=plan.density, gravity=GRAVITY,
    )  # fmt: skip


def _still_row(plan: DatabasePlan, hull, zero: np.ndarray, headings: int) -> np.ndarray:
    """Return the row of zero frequency: added mass of still deep water, no damping, the waterplane's stiffness as excitation."""
    area = np.pi / 4 * (3 * hull[0] ** 2 + plan.central_diameter**2)
    force = np.zeros((headings, 6))
    force[:, 2] = plan.density * GRAVITY * area
    return np.concatenate([zero, np.zeros(5), force.ravel(), np.zeros(6 * headings)])


def write_database(database: HydroDatabase, path: str | Path, plan: DatabasePlan) -> Path:
    """Write a database as netCDF with the plan, the solver's version and a checksum; finite depths as differences from deep water."""
    path = Path(path)
    values = np.asarray(database.values, dtype=np.float32)
    change = values[1:] - values[0]
    felt = np.flatnonzero(np.any(change != 0, axis=(0, 1, 2, 3, 5)))
    rows = int(felt.max()) + 1 if len(felt) else 0
    grid = ("diameter", "radius", "draft")
    data = xr.Dataset(
        {
            "deep": ((*grid, "scaled_frequency", "quantity"), values[0]),
            "change": (("finite_depth", *grid, "low_frequency", "quantity"), change[..., :rows, :]),
            "infinite": ((*grid, "matrix"), np.asarray(database.infinite, dtype=np.float32)),
        },
        coords={name: database.__dict__[name] for name in (*grid, "scaled_frequency")}
        | {"inverse_depth": ("finite_depth", database.inverse_depth[1:]), "heading": database.heading},
        attrs={
            "form": FORM, "solver": f"Capytaine {load_capytaine().__version__}", "plan": json.dumps(asdict(plan), default=str),
            "density": database.density, "gravity": database.gravity,
            "quantities": "added mass 11 33 55 66 15, damping alike, real and imaginary excitation (heading, 6), SI, e^{+i omega t}",
        },
    )  # fmt: skip
    data.attrs["checksum"] = checksum(data)
    part = path.with_suffix(".part")
    packed = {name: {"zlib": True, "complevel": 6, "shuffle": True} for name in ("deep", "change", "infinite")}
    data.to_netcdf(part, engine="h5netcdf", encoding=packed)
    os.replace(part, path)
    return path


def read_database(path: str | Path | None = None) -> HydroDatabase:
    """Return a database from its file (the one that comes with fowtio when no path is given); its checksum is verified."""
    path = embedded_path() if path is None else Path(path)
    try:
        with xr.open_dataset(path, engine="h5netcdf") as file:
            data = file.load()
    except OSError as error:
        raise FormatError(path, expected="a coefficient database (netCDF)", found=str(error)) from None
    if data.attrs.get("form") != FORM:
        raise FormatError(path, expected=FORM, found=str(data.attrs.get("form")), hint="fowtio database build writes one")
    if checksum(data) != data.attrs["checksum"]:
        raise FormatError(path, expected=f"checksum {data.attrs['checksum']}", found=checksum(data), hint="The file is damaged; build or fetch it again")
    deep = data["deep"].values
    values = np.repeat(deep[None], 1 + data.sizes["finite_depth"], axis=0)
    change = data["change"].values
    values[1:, ..., : change.shape[-2], :] += change
    return HydroDatabase(
        **{name: data[name].values for name in ("diameter", "radius", "draft", "scaled_frequency", "heading")},
        inverse_depth=np.concatenate([[0.0], data["inverse_depth"].values]), values=values, infinite=data["infinite"].values,
        density=data.attrs["density"], gravity=data.attrs["gravity"],
    )  # fmt: skip


def database_plan(path: str | Path | None = None) -> DatabasePlan:
    """Return the plan that a database was built from."""
    with xr.open_dataset(embedded_path() if path is None else path, engine="h5netcdf") as file:
        stored = json.loads(file.attrs["plan"])
    return DatabasePlan(**{k: tuple(float(x) for x in v) if k == "depths" else tuple(v) if isinstance(v, list) else v for k, v in stored.items()})


def embedded_path() -> Path:
    """Return the path of the database that comes with fowtio."""
    from importlib.resources import files

    path = Path(str(files("fowtio.cases"))) / EMBEDDED
    if not path.is_file():
        raise ModelError("no coefficient database is installed; build one: fowtio database build")
    return path


def checksum(data: xr.Dataset) -> str:
    """Return the SHA-256 of the numbers of a database's file."""
    digest = hashlib.sha256()
    for name in sorted(map(str, data.variables)):
        digest.update(np.ascontiguousarray(data[name].values).tobytes())
    return digest.hexdigest()
