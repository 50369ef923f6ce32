"""The coefficient database: a family of hulls solved on a tensor grid of Chebyshev points, resumable, checked, packed.

The family is the three-column semisubmersible (column diameter, platform radius, draft). Every hull is solved at the same scaled
frequencies (`model.system.hydro_database`): the phases of the waves between the columns and the resonances between them are then at
the same place on all hulls, and what is left varies smoothly with the geometry.
"""

from __future__ import annotations

import hashlib
import json
import os
import time
import tomllib
from contextlib import contextmanager, nullcontext
from dataclasses import asdict, dataclass, fields
from pathlib import Path

import numpy as np
import xarray as xr

from fowtio.bem import DEEP, BemSettings, capytaine_body, extrapolated, far_field, load_capytaine, solve_frequency
from fowtio.errors import FormatError, ModelError
from fowtio.hulls import semi_mesh
from model.system.hydro_database import HydroDatabase, hull_frequency

DIMENSIONS = ("diameter", "radius", "draft")
FIXED_LENGTH = (*DIMENSIONS, "depth_points", "panels")
GRAVITY = 9.80665
FORM = "fowtio hydrodynamic database 2"
EMBEDDED = "semi_database.nc"


@dataclass(frozen=True, kw_only=True)
class DatabasePlan:
    """What is computed: bounds [m] and numbers of Chebyshev points of diameter, radius and draft; water depths [m], deep
    first; numbers of points on which the change from deep water is computed; scaled frequencies s and their stretch with
    diameter / radius; headings [deg]; panels (numbers along column, plate top, plate side, bottom; around) and how much finer
    they are near still water.
    """

    diameter: tuple[float, float, int] = (14.0, 20.0, 5)
    radius: tuple[float, float, int] = (30.0, 45.0, 6)
    draft: tuple[float, float, int] = (20.0, 32.0, 5)
    depths: tuple[float, ...] = (np.inf, 370.0, 200.0)
    depth_points: tuple[int, int, int] = (3, 3, 3)
    scaled_frequency: tuple[float, ...] = tuple(
        np.round(np.sort(np.r_[0.1, 0.2, 0.3, 0.4, np.arange(10, 95) * 0.05, 2.175, 2.225, 2.275, 2.425, 4.175, 4.225, 4.575]), 3).tolist()
    )
    stretch: float = 0.05
    headings_deg: tuple[float, ...] = tuple(np.arange(0.0, 61.0, 5.0).tolist())
    central_diameter: float = 8.3
    plate_ratio: float = 2.0
    plate_thickness: float = 6.0
    panels: tuple[int, ...] = (4, 2, 1, 3)
    around: int = 14
    waterline_power: float = 1.7
    density: float = 1025.0
    method: str = "direct"


def chebyshev_points(low: float, high: float, count: int) -> np.ndarray:
    """Return the Chebyshev points of the second kind (count) on [low, high], ascending, ends included (one: the middle)."""
    if count == 1:
        return np.array([(low + high) / 2])
    return (low + high) / 2 - (high - low) / 2 * np.cos(np.pi * np.arange(count) / (count - 1))


def plan_axes(plan: DatabasePlan, counts=None) -> list[np.ndarray]:
    """Return the Chebyshev points of diameter, radius and draft [m], by default the plan's numbers of them."""
    bounds = [getattr(plan, name) for name in DIMENSIONS]
    return [
        chebyshev_points(low, high, n)
        for (low, high, _), n in zip(bounds, counts or [b[2] for b in bounds], strict=True)
    ]


def plan_nodes(plan: DatabasePlan, counts=None) -> np.ndarray:
    """Return the hulls (k, 3) of a plan: diameter, radius, draft [m], draft running fastest."""
    return np.stack(np.meshgrid(*plan_axes(plan, counts), indexing="ij"), axis=-1).reshape(-1, 3)


def low_rows(plan: DatabasePlan) -> int:
    """Return how many of the scaled frequencies feel the bottom of the shallowest water on some hull (k h < 5)."""
    longest = (plan.diameter[0], plan.radius[1])
    return int(np.sum(plan_frequencies(plan, longest) ** 2 / GRAVITY * min(plan.depths) <= DEEP))


def plan_frequencies(plan: DatabasePlan, hull) -> np.ndarray:
    """Return the frequencies [rad/s] at which a hull (diameter, radius, ... [m]) is solved."""
    return hull_frequency(np.array(plan.scaled_frequency), *hull[:2], plan.stretch, GRAVITY)


def plan_meshes(plan: DatabasePlan, diameter: float, radius: float, draft: float) -> list:
    """Return the coarse and the fine mesh of one hull, with the same number of panels for every hull."""
    common = {
        "plate_diameter": plan.plate_ratio * diameter, "plate_thickness": plan.plate_thickness,
        "central_diameter": plan.central_diameter, "size": plan.panels, "around": plan.around,
        "power": plan.waterline_power,
    }  # fmt: skip
    return [semi_mesh(diameter, radius, draft, refine=refine, **common) for refine in (1, 2)]


def plan_settings(plan: DatabasePlan, depth: float) -> BemSettings:
    """Return the solver's settings of a plan in one depth [m]."""
    return BemSettings(
        depth=depth, density=plan.density, gravity=GRAVITY, method=plan.method, headings=tuple(np.radians(plan.headings_deg))
    )


def solve_hull(plan: DatabasePlan, hull, depth: float, rows: int | None = None, *, coarse: bool = False) -> dict[str, np.ndarray]:
    """Return the packed coefficients of one hull: values (frequency, quantity), see `pack`, for the first `rows` frequencies.

    All rows also give the added mass at zero (in deep water) and infinite frequency. coarse takes the coarse mesh as it is.
    """
    settings = plan_settings(plan, depth)
    meshes = plan_meshes(plan, *hull)
    bodies = [capytaine_body(m) for m in (meshes[:1] if coarse else meshes)]
    solver = load_capytaine().BEMSolver(method=plan.method)
    omega = plan_frequencies(plan, hull)[:rows]
    out = {
        "values": np.array([pack([solve_frequency(b, w, settings, solver) for b in bodies], w, settings) for w in omega]),
        "omega": omega,
    }
    if rows is None:
        for name, w in (("zero", 0.0), ("infinite", np.inf)):
            found = [solve_frequency(b, w, settings, solver)["added_mass"] for b in bodies]
            out[name] = reduced(extrapolated(found[0], found[-1]))
    return out


def pack(found: list[dict], omega: float, settings: BemSettings) -> np.ndarray:
    """Return one row of the solutions on one mesh, or extrapolated from those on two: five added masses, five dampings (11, 33,
    55, 66, 15) and excitation (real, imaginary) by heading and motion.
    """
    added, force, circle = (extrapolated(found[0][name], found[-1][name]) for name in ("added_mass", "excitation", "circle"))
    damping = far_field(circle, "three-fold xz", omega, settings)
    return np.concatenate([reduced(added), reduced(damping), force.real.ravel(), force.imag.ravel()])


def reduced(matrix: np.ndarray) -> np.ndarray:
    """Return the five numbers of a matrix with three-fold symmetry: 11 = 22, 33, 55 = 44, 66, 15 = -24."""
    m = matrix
    return np.array([
        (m[0, 0] + m[1, 1]) / 2, m[2, 2], (m[3, 3] + m[4, 4]) / 2, m[5, 5], (m[0, 4] + m[4, 0] - m[1, 3] - m[3, 1]) / 4
    ])  # fmt: skip


def tasks(plan: DatabasePlan) -> list[tuple[str, int, float]]:
    """Return everything to solve: ("hull", number, inf) on the grid, then ("depth", number, depth) on the coarser one."""
    depth = [("depth", k, h) for h in plan.depths[1:] for k in range(int(np.prod(plan.depth_points)))]
    return [("hull", k, np.inf) for k in range(len(plan_nodes(plan)))] + depth


def task_path(folder: str | Path, task: tuple[str, int, float]) -> Path:
    """Return the file of one task's results."""
    kind, number, depth = task
    return Path(folder) / f"{kind}{number:04d}_depth{depth:g}.npz"


def run_task(plan: DatabasePlan, task: tuple[str, int, float], folder: str | Path) -> Path:
    """Solve one hull in one depth and keep it in the folder; a result that is already there is left alone."""
    path, (kind, number, depth), start = task_path(folder, task), task, time.process_time()
    if path.exists():
        return path
    if kind == "hull":
        found = solve_hull(plan, plan_nodes(plan)[number], depth)
    else:
        found = solve_hull(plan, plan_nodes(plan, plan.depth_points)[number], depth, low_rows(plan))
    part = path.with_suffix(f".{os.getpid()}.tmp")
    with open(part, "wb") as file:
        np.savez(file, **found, processor_time=time.process_time() - start)
    os.replace(part, path)
    return path


def processor_time(plan: DatabasePlan, folder: str | Path) -> float:
    """Return the processor time [s] that the solutions of a plan took, over all runs and processes."""
    return float(sum(np.load(task_path(folder, task))["processor_time"] for task in tasks(plan)))


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
    todo = [task for task in tasks(plan) if not task_path(folder, task).exists()]
    done = len(tasks(plan)) - len(todo)
    work = (delayed(run_task)(plan, task, str(folder)) for task in todo)
    for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(variable, "1")
    if progress:
        progress(done, len(tasks(plan)))
    with nullcontext() if dask is None else _dask_workers(dask):
        for _ in Parallel(n_jobs=jobs if dask is None else -1, return_as="generator_unordered")(work):
            done += 1
            if progress:
                progress(done, len(tasks(plan)))


@contextmanager
def _dask_workers(address: str):
    """Let joblib use the workers of a Dask scheduler (host:port)."""
    try:
        from dask.distributed import Client
    except ImportError as error:
        raise ModelError('a Dask cluster needs Dask: pip install "fowtio[cluster]"') from error
    from joblib import parallel_config

    try:
        client = Client(address, timeout=10)
    except OSError as error:
        raise ModelError(f"no Dask scheduler answers at {address}: {error}") from None
    with client, parallel_config(backend="dask"):
        yield


def write_database(database: HydroDatabase, path: str | Path, plan: DatabasePlan) -> Path:
    """Write a database as netCDF with the plan, the solver's version and a checksum; finite depths as differences from deep water.

    Numbers are rounded to 4 parts in a million, for a file of half the size.
    """
    path = Path(path)
    values = np.asarray(database.values)
    change = values[1:] - values[0]
    felt = np.flatnonzero(np.any(change != 0, axis=(0, 1, 2, 3, 5)))
    rows = int(felt.max()) + 1 if len(felt) else 0
    grid = ("diameter", "radius", "draft")
    data = xr.Dataset(
        {
            "deep": ((*grid, "scaled_frequency", "quantity"), _rounded(values[0])),
            "change": (("finite_depth", *grid, "low_frequency", "quantity"), _rounded(change[..., :rows, :])),
            "infinite": ((*grid, "matrix"), _rounded(database.infinite)),
        },
        coords={name: database.__dict__[name] for name in (*grid, "scaled_frequency")}
        | {"inverse_depth": ("finite_depth", database.inverse_depth[1:]), "heading": database.heading},
        attrs={
            "form": FORM, "solver": f"Capytaine {load_capytaine().__version__}", "plan": json.dumps(asdict(plan), default=str),
            "density": database.density, "gravity": database.gravity, "stretch": database.stretch,
            "quantities": "added mass 11 33 55 66 15, damping alike, real and imaginary excitation (heading, 6), SI, e^{+i omega t}",
        },
    )  # fmt: skip
    data.attrs["checksum"] = checksum(data)
    part = path.with_suffix(".part")
    packed = {name: {"zlib": True, "complevel": 6, "shuffle": True} for name in ("deep", "change", "infinite")}
    data.to_netcdf(part, engine="h5netcdf", encoding=packed)
    os.replace(part, path)
    return path


def _rounded(values: np.ndarray) -> np.ndarray:
    """Return 32-bit numbers with the last 6 of their 24 binary digits zero: they pack better."""
    bits = np.array(values, dtype=np.float32).view(np.uint32)
    return ((bits + np.uint32(32)) & np.uint32(0xFFFFFFC0)).view(np.float32)


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
        raise FormatError(
            path, expected=f"checksum {data.attrs['checksum']}", found=checksum(data), hint="The file is damaged; build or fetch it again"
        )  # fmt: skip
    deep = data["deep"].values
    values = np.repeat(deep[None], 1 + data.sizes["finite_depth"], axis=0)
    change = data["change"].values
    values[1:, ..., : change.shape[-2], :] += change
    return HydroDatabase(
        **{name: data[name].values for name in ("diameter", "radius", "draft", "scaled_frequency", "heading")},
        inverse_depth=np.concatenate([[0.0], data["inverse_depth"].values]), values=values, infinite=data["infinite"].values,
        density=data.attrs["density"], gravity=data.attrs["gravity"], stretch=data.attrs["stretch"],
    )  # fmt: skip


def database_plan(path: str | Path | None = None) -> DatabasePlan:
    """Return the plan that a database was built from."""
    with xr.open_dataset(embedded_path() if path is None else path, engine="h5netcdf") as file:
        return _plan(json.loads(file.attrs["plan"]))


def read_plan(path: str | Path) -> DatabasePlan:
    """Return the plan of a TOML file: fields of DatabasePlan, those not given as by default; raise FormatError."""
    try:
        data = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise FormatError(path, expected="TOML", found=str(error)) from None
    known = {f.name: f.default for f in fields(DatabasePlan)}
    for name, value in data.items():
        if name not in known:
            raise FormatError(path, expected=f"fields of a plan: {', '.join(known)}", found=name)
        listed, wanted = isinstance(value, list), known[name]
        if listed != isinstance(wanted, tuple) or (name in FIXED_LENGTH and len(value) != len(wanted)):
            raise FormatError(path, expected=f"{name} like {wanted}", found=str(value))
    return _plan(data)


def _plan(data: dict) -> DatabasePlan:
    tuples = {k: tuple(v) for k, v in data.items() if isinstance(v, list)}
    if "depths" in tuples:
        tuples["depths"] = tuple(map(float, tuples["depths"]))
    return DatabasePlan(**data | tuples)


def embedded_path() -> Path:
    """Return the path of the database that comes with fowtio."""
    from fowtio.hull_turbine import reference_folder

    path = reference_folder("semi_10mw") / EMBEDDED
    if not path.is_file():
        raise ModelError("no coefficient database is installed; build one: fowtio database build")
    return path


def checksum(data: xr.Dataset) -> str:
    """Return the SHA-256 of the numbers of a database's file."""
    digest = hashlib.sha256()
    for name in sorted(map(str, data.variables)):
        digest.update(np.ascontiguousarray(data[name].values).tobytes())
    return digest.hexdigest()
