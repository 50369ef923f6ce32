"""`fowtio bem`: one hull described in a small file, solved over its frequencies in parallel, resumable, written for OpenFAST.

A hull file is TOML: `kind` semi, spar, barge, tlp or mesh with the dimensions of that kind, and a table [bem].
"""

from __future__ import annotations

import hashlib
import json
import os
import tomllib
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from fowtio.bem import BemSettings, capytaine_body, extrapolated, far_field, load_capytaine, solve_frequency
from fowtio.errors import CaseError, FormatError, ModelError, Problem
from fowtio.hull_check import hull_problems
from fowtio.hull_mesh import HullMesh, whole
from fowtio.hulls import barge_mesh, semi_braces, semi_mesh, spar_mesh, tlp_mesh
from fowtio.write.hydro import write_capytaine, write_wamit
from model.design.hull import SemiHull
from model.system.hydro import HydroCoefficients

BEM_DEFAULTS = {
    "depth": 200.0, "density": 1025.0, "gravity": 9.80665, "frequency_low": 0.05, "frequency_high": 3.0, "frequency_count": 60,
    "headings": [0.0, 30.0, 60.0, 90.0, 120.0, 150.0, 180.0], "panel_size": 4.0, "around": 16, "method": "direct", "lid": True,
    "braces": True,
}  # fmt: skip
SOLUTION = 3  # the form of what is kept of a frequency
SUNK_DECK = 0.05
SHAPES = {
    "semi": ("diameter", "radius", "draft"), "spar": ("profile",), "barge": ("length", "width", "draft"), "tlp": ("diameter", "draft"),
    "mesh": ("file",),
}  # fmt: skip
OPTIONAL = {
    "semi": ("plate_ratio", "plate_height", "central_diameter", "column_freeboard", "central_freeboard", "brace_diameter"),
    "barge": ("moonpool", "moonpool_cap"), "tlp": ("pontoon_length", "pontoon_diameter", "pontoon_depth", "pontoons"), "spar": (), "mesh": ("scale",),
}  # fmt: skip


@dataclass(frozen=True, eq=False, kw_only=True)
class HullFile:
    """A hull file: path, title, kind, its dimensions [m], and the settings of the solution."""

    path: Path
    title: str
    kind: str
    shape: dict
    bem: dict


def read_hull(path: str | Path) -> HullFile:
    """Return a hull file, or a mesh file (.gdf, .stl, .msh, ...) with default settings; raise FormatError, or CaseError with all that cannot be."""
    path = Path(path)
    if path.suffix.lower() != ".toml":
        if not path.is_file():
            raise FormatError(path, expected="a hull file (.toml) or a mesh file", found="nothing there")
        return HullFile(path=path, title=path.stem, kind="mesh", shape={"file": path.name}, bem=dict(BEM_DEFAULTS))
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise FormatError(path, expected="TOML", found=str(error)) from None
    kind, bem, title = data.pop("kind", None), data.pop("bem", {}), data.pop("title", path.stem)
    if kind not in SHAPES:
        raise FormatError(path, expected=f"kind = one of {', '.join(SHAPES)}", found=repr(kind))
    known = SHAPES[kind] + OPTIONAL[kind]
    for name in data:
        if name not in known:
            raise FormatError(path, expected=f"a dimension of a {kind}: {', '.join(known)}", found=name)
    for name in SHAPES[kind]:
        if name not in data:
            raise FormatError(path, expected=f"{name}, which a {kind} needs", found="nothing")
    for name in bem:
        if name not in BEM_DEFAULTS:
            raise FormatError(path, expected=f"a setting of [bem]: {', '.join(BEM_DEFAULTS)}", found=name)
    hull = HullFile(path=path, title=title, kind=kind, shape=data, bem=BEM_DEFAULTS | bem)
    if problems := hull_problems(kind, hull.shape, hull.bem):
        raise CaseError([Problem(text, path) for text in problems])
    return hull


def hull_meshes(hull: HullFile, omega: float = 1.0) -> list[HullMesh]:
    """Return the coarse and the fine mesh of a hull at a frequency [rad/s] (a mesh file gives one mesh only)."""
    if hull.kind == "mesh":
        return [file_mesh(hull.path.parent / hull.shape["file"], hull.shape.get("scale", 1.0))]
    size, around = hull.bem["panel_size"], hull.bem["around"]
    if hull.kind == "semi":
        semi = SemiHull(**hull.shape)
        members = semi_braces(semi) if hull.bem["braces"] else ()
        common = {
            "plate_diameter": float(semi.plate_diameter), "plate_thickness": float(semi.plate_height),
            "central_diameter": float(semi.central_diameter), "members": members, "size": size, "around": around,
        }  # fmt: skip
        return [
            semi_mesh(float(semi.diameter), float(semi.radius), float(semi.draft), refine=k, **common) for k in (1, 2)
        ]
    if hull.kind == "spar":
        return [spar_mesh(hull.shape["profile"], size=size, around=around, refine=k) for k in (1, 2)]
    if hull.kind == "barge":
        shape = {name: hull.shape[name] for name in ("length", "width", "draft")}
        deck = {"moonpool": hull.shape.get("moonpool", 0.0), "cap": _deck_depth(hull, omega)}
        return [barge_mesh(**shape, **deck, size=size, refine=k) for k in (1, 2)]
    return [tlp_mesh(**hull.shape, size=size, around=around, refine=k) for k in (1, 2)]


def _deck_depth(hull: HullFile, omega: float) -> float | None:
    """Return how far below still water a deck closes the moonpool [m], None without one.

    At infinite frequency the Green function vanishes at still water: a deck there is solved SUNK_DECK below.
    """
    cap = hull.shape.get("moonpool_cap")
    return SUNK_DECK if cap == 0 and np.isinf(omega) else cap


def file_mesh(path: Path, scale: float = 1.0) -> HullMesh:
    """Return the wetted part of a mesh file that Capytaine reads (GDF, STL, MSH, ...), lengths times `scale`, with a lid."""
    cpt = load_capytaine()
    if not path.is_file():
        raise FormatError(path, expected="a mesh file", found="nothing there")
    try:
        mesh = cpt.load_mesh(_gmsh(path) if path.suffix.lower() == ".msh" else str(path))
    except Exception as error:
        lacking = path.suffix.lower() in (".stl", ".msh") and find_spec("meshio") is None
        hint = 'STL and MSH need meshio: pip install "fowtio[bem]"' if lacking or isinstance(error, ImportError) else ""
        raise FormatError(path, expected="a mesh that Capytaine reads", found=f"{type(error).__name__}: {error}", hint=hint) from None
    mesh = mesh.merged() if hasattr(mesh, "merged") else mesh
    wet = mesh.immersed_part()
    if not wet.nb_faces:
        raise FormatError(path, expected="panels below still water (z < 0)", found=f"{mesh.nb_faces} panels, none of them wet")
    lid = wet.generate_lid()
    panels = [np.asarray(m.vertices)[np.asarray(m.faces)] * scale for m in (wet, lid)]
    return HullMesh(part=panels[0], lid=panels[1], symmetry="none")


def _gmsh(path: Path):
    """Return a mesh of Gmsh's; Capytaine 3.0 asks meshio for its format by a name that meshio does not know."""
    import meshio

    return meshio.read(path)


def hydrostatics(mesh: HullMesh, density: float, gravity: float) -> tuple[np.ndarray, float, np.ndarray]:
    """Return hydrostatic stiffness (6, 6) of buoyancy, volume [m3] and centre of buoyancy (3) [m] of a mesh, about the origin.

    Integrals over the wetted panels (divergence theorem), exact for plane panels.
    """
    panels = whole(mesh)
    first, second = panels[:, [0, 1, 2]], panels[:, [0, 2, 3]]
    triangles = np.concatenate([first, second])
    area = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]) / 2
    middle = (triangles + np.roll(triangles, 1, axis=1)) / 2
    down = -area[:, 2]

    def integral(values):
        return float(np.sum(down * values.mean(axis=1)))

    x, y, z = (middle[..., k] for k in range(3))
    size = integral(-z)
    centre = np.array([integral(-x * z), integral(-y * z), integral(-(z**2) / 2)]) / size
    waterplane = {
        name: integral(v)
        for name, v in (("1", np.ones_like(x)), ("x", x), ("y", y), ("xx", x * x), ("xy", x * y), ("yy", y * y))
    }
    out = np.zeros((6, 6))
    out[2, 2], out[2, 3], out[2, 4] = waterplane["1"], waterplane["y"], -waterplane["x"]
    out[3, 3], out[4, 4] = waterplane["yy"] + size * centre[2], waterplane["xx"] + size * centre[2]
    out[3, 4] = -waterplane["xy"]
    out = out + np.triu(out, 1).T
    out[3, 5], out[4, 5] = -size * centre[0], -size * centre[1]
    return density * gravity * out, size, centre


def frequencies(bem: dict) -> np.ndarray:
    """Return the frequencies of a solution [rad/s], evenly spaced, with zero first and infinity last."""
    grid = np.linspace(bem["frequency_low"], bem["frequency_high"], int(bem["frequency_count"]))
    return np.concatenate([[0.0], grid, [np.inf]])


def bem_settings(hull: HullFile) -> BemSettings:
    """Return the solver's settings of a hull file."""
    b = hull.bem
    return BemSettings(
        depth=float(b["depth"]), density=b["density"], gravity=b["gravity"], method=b["method"], lid=b["lid"],
        headings=tuple(np.radians(b["headings"])),
    )  # fmt: skip


def solve_one(hull: HullFile, omega: float, folder: str) -> Path:
    """Solve one frequency on all meshes and keep the results in the folder; what is already there is left alone."""
    path = Path(folder) / f"omega_{omega:.6f}.npz"
    if path.exists():
        return path
    settings, out = bem_settings(hull), {}
    for k, mesh in enumerate(hull_meshes(hull, omega)):
        found = solve_frequency(capytaine_body(mesh, lid=settings.lid), omega, settings)
        out |= {f"{name}_{k}": value for name, value in found.items()}
    part = path.with_suffix(f".{os.getpid()}.tmp")
    with open(part, "wb") as file:
        np.savez(file, **out)
    os.replace(part, path)
    return path


def run_bem(hull: HullFile, folder: str | Path, *, jobs: int = 1, progress=None) -> tuple[HydroCoefficients, dict]:
    """Return the coefficients of a hull and what is known of their errors; solutions are kept in folder/solved and go on there.

    Parallel over frequencies through joblib. Two meshes are solved and extrapolated; a mesh file is solved as it is.
    """
    from joblib import Parallel, delayed

    solved = Path(folder) / "solved"
    solved.mkdir(parents=True, exist_ok=True)
    _same_hull(hull, solved)
    for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(variable, "1")
    grid = frequencies(hull.bem)
    todo = [w for w in grid if not (solved / f"omega_{w:.6f}.npz").exists()]
    done = len(grid) - len(todo)
    if progress:
        progress(done, len(grid))
    work = (delayed(solve_one)(hull, w, str(solved)) for w in todo)
    for _ in Parallel(n_jobs=jobs, return_as="generator_unordered")(work):
        done += 1
        if progress:
            progress(done, len(grid))
    return gather(hull, solved)


def _same_hull(hull: HullFile, solved: Path) -> None:
    """A folder of solutions belongs to one hull: refuse another."""
    text = json.dumps([SOLUTION, hull.kind, hull.shape, hull.bem], sort_keys=True)
    if hull.kind == "mesh":
        text += hashlib.sha256((hull.path.parent / hull.shape["file"]).read_bytes()).hexdigest()
    mark = solved / "hull.json"
    if mark.exists() and mark.read_text(encoding="utf-8") != text:
        raise ModelError(
            f"{solved} holds solutions of another hull or other settings; give another folder (-o) or remove it"
        )
    mark.write_text(text, encoding="utf-8")


def gather(hull: HullFile, solved: Path) -> tuple[HydroCoefficients, dict]:
    """Return the coefficients from the solutions of all frequencies, and the differences between meshes."""
    meshes, settings, grid = hull_meshes(hull), bem_settings(hull), frequencies(hull.bem)
    rows = [dict(np.load(solved / f"omega_{w:.6f}.npz")) for w in grid]

    def stacked(name, keep=slice(None)):
        values = [np.array([r[f"{name}_{k}"] for r in rows[keep]]) for k in range(len(meshes))]
        return (extrapolated(*values) if len(values) == 2 else values[0]), values

    added, all_added = stacked("added_mass")
    pressure, _ = stacked("pressure_damping")
    force, _ = stacked("excitation", slice(1, -1))
    circle, each = stacked("circle", slice(1, -1))
    damping, *all_damping = (
        np.array([far_field(c, meshes[0].symmetry, w, settings) for c, w in zip(one, grid[1:-1], strict=True)]) for one in (circle, *each)
    )
    heading, force = full_circle(np.radians(hull.bem["headings"]), np.swapaxes(force, 0, 1), meshes[0].symmetry)
    stiffness, size, centre = hydrostatics(meshes[-1], settings.density, settings.gravity)
    hydro = HydroCoefficients(
        omega=grid[1:-1], added_mass=added[1:-1], radiation_damping=damping, added_mass_zero=added[0],
        added_mass_infinite=added[-1], heading=heading, excitation=force, hydrostatic_stiffness=stiffness, volume=size,
        centre_of_buoyancy=centre, density=settings.density, gravity=settings.gravity, depth=settings.depth,
    )  # fmt: skip
    quality = {
        "panels": [len(whole(m)) for m in meshes],
        "asymmetry": float(max(r["asymmetry_0"] for r in rows)),
        "pressure_damping_gap": _gap(damping, pressure[1:-1]),
        "zero_frequency_gap": [float(abs(added[0, k, k] / added[1, k, k] - 1)) for k in range(6)],
        "bottom_at_infinite_frequency": _bottom_share(added[-1, 2, 2] / settings.density, size, settings.depth),
    }
    if len(meshes) == 2:
        quality["mesh_change"] = {
            f"A{k + 1}{k + 1}": [float(v[-1, k, k]) for v in all_added] + [float(added[-1, k, k])] for k in range(6)
        } | {
            f"B{k + 1}{k + 1}": [float(v[:, k, k].max()) for v in all_damping] + [float(damping[:, k, k].max())]
            for k in range(6)
        }
    return hydro, quality


def _bottom_share(added: float, size: float, depth: float) -> float:
    """Return the share by which a bottom would change the heave added mass of infinite frequency, solved in deep water.

    added mass over density and volume [m3]; hull and image above still water are a dipole, its images below the bottom lie 2 depth away.
    """
    return float((added + size) ** 2 / (4 * np.pi * depth**3 * added))


def _gap(damping: np.ndarray, pressure: np.ndarray) -> list[float]:
    """Return the largest difference of the damping from the pressure on the hull, as a share of the damping's peak, by motion."""
    peak, gap = (np.abs(np.diagonal(x, axis1=1, axis2=2)).max(axis=0) for x in (damping, pressure - damping))
    return [float(x) for x in gap / np.where(peak > 0, peak, 1.0)]


def full_circle(heading: np.ndarray, force: np.ndarray, symmetry: str) -> tuple[np.ndarray, np.ndarray]:
    """Return headings [rad] ascending and excitation (m, n, 6), with the mirror images where the hull is symmetric about y = 0."""
    order = np.argsort(heading)
    heading, force = heading[order], force[order]
    if symmetry == "none" or heading[0] < -1e-9:
        return heading, force
    inner = (heading > 1e-9) & (heading <= np.pi + 1e-9)
    mirrored = force[inner][::-1] * np.array([1.0, -1, 1, -1, 1, -1])
    return np.concatenate([-heading[inner][::-1], heading]), np.concatenate([mirrored, force])


def write_results(hull: HullFile, hydro: HydroCoefficients, folder: str | Path) -> list[Path]:
    """Write netCDF and WAMIT files (.1, .3, .hst for OpenFAST) of a solved hull into a folder."""
    folder = Path(folder)
    stem = folder / hull.path.stem
    return [write_capytaine(hydro, stem.with_suffix(".nc"), body_name=hull.path.stem), *write_wamit(hydro, stem)]


def closed_form(hull: HullFile) -> dict[str, float]:
    """Return volume, heave stiffness and pitch stiffness of the hull's shape in closed form where there is one (not for mesh files)."""
    b, s = hull.bem, hull.shape
    weight = b["density"] * b["gravity"]
    if hull.kind == "barge":
        pool = s.get("moonpool", 0.0)
        area = s["length"] * s["width"] - pool**2
        moment = s["length"] ** 3 * s["width"] / 12 - pool**4 / 12
        size, height = area * s["draft"], -s["draft"] / 2
        if "moonpool_cap" in s:
            cap, inner = s["moonpool_cap"], pool**2
            height = (size * height - inner * cap * cap / 2) / (size + inner * cap)
            size, area, moment = size + inner * cap, area + inner, moment + pool**4 / 12
    elif hull.kind == "spar":
        size, moment_z = 0.0, 0.0
        for (r1, z1), (r2, z2) in zip(s["profile"][:-1], s["profile"][1:], strict=True):
            part = np.pi * (z1 - z2) * (r1**2 + r1 * r2 + r2**2) / 3
            size += part
            moment_z += (
                np.pi
                * (z1 - z2)
                * ((z1 * (3 * r1**2 + 2 * r1 * r2 + r2**2) + z2 * (r1**2 + 2 * r1 * r2 + 3 * r2**2)) / 12)
            )
        height, radius = moment_z / size, s["profile"][0][0]
        area, moment = np.pi * radius**2, np.pi * radius**4 / 4
    elif hull.kind == "semi":
        from model.design.hull import displaced, waterplane

        semi = SemiHull(**s) if b["braces"] else SemiHull(**(s | {"brace_diameter": 1e-6}))
        (size, height), (area, moment) = displaced(semi), waterplane(semi)
    else:
        return {}
    return {"volume": float(size), "C33": float(weight * area), "C55": float(weight * (moment + size * height))}
