"""What people are told of a boundary-element solution, of the database and of a parametric hull."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fowtio.bem_run import HullFile, closed_form
from fowtio.database import DIMENSIONS, database_plan, embedded_path, plan_frequencies, read_database
from fowtio.database_check import held_out
from fowtio.hull_system import SemiDesign, thesis_hull
from fowtio.hull_turbine import ten_megawatt
from fowtio.read.hydro_any import hydro_options, read_hydro
from model.system.hydro import HydroCoefficients
from model.system.mooring import mooring_state

NAMES = ("A11", "A33", "A55", "A66", "A15", "B11", "B33", "B55", "B66", "B15", "X1", "X2", "X3", "X4", "X5", "X6")


def bem_rows(hull: HullFile, hydro: HydroCoefficients, quality: dict, files) -> list[tuple[str, str]]:
    """Return labels and texts of a solution: meshes, hydrostatics, convergence, files."""
    exact = closed_form(hull)
    rows = [
        ("panels", " and ".join(map(str, quality["panels"]))),
        ("volume", f"{hydro.volume:.2f} m3" + (f" (closed form {exact['volume']:.2f})" if exact else "")),
        ("heave stiffness", f"{hydro.hydrostatic_stiffness[2, 2]:.5g} N/m" + (f" (closed form {exact['C33']:.5g})" if exact else "")),
        ("pitch stiffness", f"{hydro.hydrostatic_stiffness[4, 4]:.5g} N m/rad, buoyancy alone" + (f" (closed form {exact['C55']:.5g})" if exact else "")),
        ("asymmetry of A", f"{100 * quality['asymmetry']:.2f} % of its largest element, coarse mesh"),
        ("zero frequency", "deep water; surge A(0) differs from the lowest frequency by "
         f"{100 * quality['zero_frequency_gap'][0]:.2f} %, heave by {100 * quality['zero_frequency_gap'][2]:.2f} %"),
        ("infinite frequency", f"deep water; the bottom would change heave by about {100 * quality['bottom_at_infinite_frequency']:.2g} %"),
        ("damping", "from the excitation (Haskind); from the pressure on the hull it differs by "
         + ", ".join(f"{100 * quality['pressure_damping_gap'][k]:.1f} % in B{k + 1}{k + 1}" for k in (0, 2, 4)) + " of the peak"),
    ]  # fmt: skip
    for name, values in quality.get("mesh_change", {}).items():
        if name in ("A11", "A33", "A55", "B11", "B33", "B55"):
            what = "infinite frequency" if name[0] == "A" else "peak"
            rows.append((name, f"{what}: coarse {values[0]:.5g}, fine {values[1]:.5g}, extrapolated {values[2]:.5g}"))
    return rows + [("files", ", ".join(str(f) for f in files))]


def bem_json(hull: HullFile, hydro: HydroCoefficients, quality: dict, files) -> dict:
    """Return a solution's summary for programs."""
    return {
        "title": hull.title, "volume": hydro.volume, "heave_stiffness": float(hydro.hydrostatic_stiffness[2, 2]),
        "pitch_stiffness": float(hydro.hydrostatic_stiffness[4, 4]), "closed_form": closed_form(hull), "quality": quality,
        "files": [str(f) for f in files], "units": {"volume": "m3", "heave_stiffness": "N/m", "pitch_stiffness": "N m/rad"},
    }  # fmt: skip


def reference_hydro(hull: HullFile, path: Path) -> HydroCoefficients:
    """Return coefficients to compare with, in the hull's water where their file does not say it."""
    water = {name: hull.bem[name] for name in ("density", "gravity", "depth") if name in hydro_options(path)}
    return read_hydro(path, **water)


def draw_bem(hull: HullFile, hydro: HydroCoefficients, reference: HydroCoefficients | None, folder: str | Path) -> list[Path]:
    """Draw the fine mesh, and the coefficients beside a reference, into a folder; return the pictures' paths."""
    from fowtio.bem_figures import draw_comparison, draw_mesh

    out = [draw_mesh(hull, Path(folder) / "mesh.png")]
    if reference is not None:
        out.append(draw_comparison(hydro, reference, Path(folder) / "comparison.png", labels=("fowtio", "reference"), title=hull.title))
    return out


def random_hulls(database, count: int, seed: int) -> np.ndarray:
    """Return hulls (count, 3) drawn evenly from the space of a database."""
    low, high = (np.array([getattr(database, n)[k] for n in DIMENSIONS]) for k in (0, -1))
    return low + np.random.default_rng(seed).random((count, 3)) * (high - low)


def check_database(path=None, *, hulls: int, seed: int, depth: float, jobs: int, folder=None, out=None) -> list[dict]:
    """Return the errors of interpolation on random hulls, those of the RAOs among them, and draw them into a folder."""
    database, plan = read_database(path), database_plan(path)
    found = held_out(database, plan, random_hulls(database, hulls, seed), jobs=jobs, folder=folder)
    if np.isfinite(depth):
        shallow = held_out(database, plan, random_hulls(database, hulls, seed), depth=depth, jobs=jobs, folder=folder)
    for k, row in enumerate(found):
        row["rao"] = rao_errors(database, plan, row)
        if np.isfinite(depth):
            row["rao"] = np.maximum(row["rao"], rao_errors(database, plan, shallow[k]))
            for name in ("added_mass", "radiation_damping", "excitation"):
                row[f"{name}_depth"] = shallow[k][name]
        row["worst"] = float(
            max(
                np.max(v)
                for n, v in row.items()
                if n.split("_depth")[0] in ("added_mass", "radiation_damping", "excitation", "rao")
            )
        )
    if out is not None:
        from fowtio.bem_figures import draw_check

        draw_check(found, Path(out))
    return found


def rao_errors(database, plan, row: dict) -> np.ndarray:
    """Return the error of the surge, heave and pitch RAO at their peaks (wave periods of 4 to 60 s among those solved, heading 0),
    with the parked turbine, three lines and 5 per cent of critical damping besides radiation.
    """
    curves, omega = row["curves"], row["omega"]
    pick = (omega > 2 * np.pi / 60) & (omega < 2 * np.pi / 4)
    raos = [
        np.abs(_rao(database, row, *(c[pick] for c in curves[kind]), omega[pick]))
        for kind in ("solved", "interpolated")
    ]
    return np.abs(raos[1].max(axis=0) / raos[0].max(axis=0) - 1)


def _rao(database, row, added, damping, force, omega) -> np.ndarray:
    from model.design.hull import hydrostatic_stiffness, platform_body
    from model.system.contributions import platform_contribution, turbine_contribution
    from model.system.hydro_database import full_matrix

    design = SemiDesign(hull=thesis_hull(*row["hull"]), anchor_radius=837.6, length=835.0)
    floating, turbine = design.floating(), turbine_contribution(ten_megawatt(0.0))
    body = platform_contribution(platform_body(floating), database.gravity, "")
    stiffness = hydrostatic_stiffness(floating) + body.stiffness + turbine.stiffness[:6, :6]
    stiffness = stiffness + mooring_state(design.mooring(), np.zeros(6)).stiffness
    mass = body.mass + turbine.mass[:6, :6]
    total = mass + full_matrix(added)
    keep = [0, 2, 4]
    extra = 0.05 * 2 * np.sqrt(np.abs(np.diag(stiffness)[keep] * np.diag(total[len(total) // 2])[keep]))
    matrix = (-(omega[:, None, None] ** 2) * total + 1j * omega[:, None, None] * full_matrix(damping) + stiffness)[
        :, keep
    ][:, :, keep]
    matrix = matrix + 1j * omega[:, None, None] * np.diag(extra)
    return np.linalg.solve(matrix, force[:, 0, keep, None])[..., 0]


def check_rows(found: list[dict]) -> list[tuple[str, str]]:
    """Return one row a hull, and one with the largest of each coefficient."""
    rows = []
    for row in found:
        values = _coefficients(row)
        text = "  ".join(f"{n} {100 * v:.2f}" for n, v in zip(NAMES, values, strict=True))
        rao = ", ".join(f"{100 * v:.2f}" for v in row["rao"])
        rows.append(("d {:.2f} r {:.2f} draft {:.2f} m".format(*row["hull"]), f"{text}; RAO surge, heave, pitch {rao}"))
    worst = np.max([_coefficients(r) for r in found], axis=0)
    rows.append(("largest", "  ".join(f"{n} {100 * v:.2f}" for n, v in zip(NAMES, worst, strict=True))))
    return rows


def _coefficients(row: dict) -> np.ndarray:
    parts = ("added_mass", "radiation_damping", "excitation")
    deep = np.concatenate([row[n] for n in parts])
    return np.maximum(deep, np.concatenate([row[f"{n}_depth"] for n in parts])) if "added_mass_depth" in row else deep


def check_json(found: list[dict]) -> dict:
    """Return the errors for programs, as shares of each coefficient's maximum."""
    return {
        "hulls": [
            {"diameter": r["hull"][0], "radius": r["hull"][1], "draft": r["hull"][2], "worst": r["worst"], "rao": [float(v) for v in r["rao"]],
             "errors": {n: float(v) for n, v in zip(NAMES, _coefficients(r), strict=True)}}
            for r in found
        ],
        "units": {"diameter": "m", "radius": "m", "draft": "m", "errors": "share of the maximum"},
    }  # fmt: skip


def info_rows(path=None) -> list[tuple[str, str]]:
    """Return what a database holds; reading it verifies its checksum."""
    import xarray as xr

    path = embedded_path() if path is None else Path(path)
    database = read_database(path)
    with xr.open_dataset(path, engine="h5netcdf") as file:
        solver, mark = file.attrs["solver"], file.attrs["checksum"]
    spans = [
        (n, f"{getattr(database, n)[0]:g} to {getattr(database, n)[-1]:g} m, {len(getattr(database, n))} points")
        for n in DIMENSIONS
    ]
    with np.errstate(divide="ignore"):
        depths = ", ".join(f"{1 / h:g} m" if h else "deep" for h in database.inverse_depth)
    last = plan_frequencies(database_plan(path), (database.diameter[0], database.radius[-1]))[-1]
    return [
        ("file", f"{path.name}, {path.stat().st_size / 1e6:.2f} MB"), *spans, ("depths", depths),
        ("frequencies", f"{len(database.scaled_frequency)}, to {last:.2f} rad/s and more"),
        ("headings", f"{len(database.heading)}, all others by symmetry"), ("solver", solver), ("checksum", f"{mark[:16]}, verified"),
    ]  # fmt: skip


def semi_rows(design: SemiDesign) -> list[tuple[str, str, float, str]]:
    """Return key, label, value and unit of a parametric semisubmersible under the 10 MW turbine."""
    f = design.floating()
    state = mooring_state(design.mooring(), np.zeros(6))
    rows = [
        ("displaced_volume", "displaced volume", f.volume, "m3"), ("steel_mass", "steel", f.steel_mass, "kg"),
        ("ballast_mass", "ballast", f.ballast_mass, "kg"), ("ballast_level", "ballast level above the keel", f.ballast_level, "m"),
        ("platform_mass", "platform", f.mass, "kg"), ("centre_of_mass", "its centre of mass above still water", f.centre_of_mass, "m"),
        ("centre_of_buoyancy", "centre of buoyancy above still water", f.centre_of_buoyancy, "m"),
        ("roll_inertia", "roll and pitch inertia about the centre of mass", f.inertia[0], "kg m2"),
        ("yaw_inertia", "yaw inertia", f.inertia[2], "kg m2"), ("metacentric_height", "metacentric height with the turbine", f.metacentric_height, "m"),
        ("mooring_surge_stiffness", "mooring surge stiffness at rest", state.stiffness[0, 0], "N/m"),
        ("mooring_pull", "pull of the lines downwards", -state.force[2], "N"),
    ]  # fmt: skip
    return [(key, label, float(value), unit) for key, label, value, unit in rows]
