"""Writers of hydrodynamic coefficients: WAMIT .1, .3, .hst and Capytaine's netCDF."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fowtio.errors import ModelError
from fowtio.write.atomic import atomic_file
from model.environment.airy import wavenumber
from model.system.hydro import HydroCoefficients, tabulated

_ROTATIONS = np.array([0, 0, 0, 1, 1, 1])
_DOFS = ["Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw"]


def write_wamit(hydro: HydroCoefficients, stem: str | Path, *, length: float = 1.0) -> list[Path]:
    """Write coefficients as WAMIT files (period first, all 36 elements) and return their paths.

    stem is the path without suffix, as HydroDyn's PotFile; length is WAMIT's ULEN [m]. Writes .1, and .3 and .hst when
    there is excitation and hydrostatic stiffness; -1 and 0 rows for the zero- and infinite-frequency added mass.
    Seven digits. The .hst has no weight. Raises ModelError unless the coefficients are about the origin.
    """
    if np.any(hydro.reference_point != 0):
        raise ModelError(
            f"WAMIT files are written about the origin, these coefficients are about {tuple(hydro.reference_point)} m; "
            "transfer them first (model.system.hydro.transfer)"
        )
    stem, hydro = Path(stem), tabulated(hydro)
    files = {".1": _radiation_rows(hydro, length)}
    if hydro.excitation is not None:
        files[".3"] = _excitation_rows(hydro, length)
    if hydro.hydrostatic_stiffness is not None:
        powers = hydro.density * hydro.gravity * length ** (2.0 + _ROTATIONS[:, None] + _ROTATIONS)
        files[".hst"] = _matrix_rows(hydro.hydrostatic_stiffness / powers)
    paths = [stem.with_name(stem.name + suffix) for suffix in files]
    for path, rows in zip(paths, files.values(), strict=True):
        with atomic_file(path) as temporary:
            temporary.write_text("\n".join(rows) + "\n", encoding="ascii")
    return paths


def _radiation_rows(hydro: HydroCoefficients, length: float) -> list[str]:
    powers = hydro.density * length ** (3.0 + _ROTATIONS[:, None] + _ROTATIONS)
    rows = []
    for period, matrix in ((-1.0, hydro.added_mass_zero), (0.0, hydro.added_mass_infinite)):
        if matrix is not None:
            rows += [f" {period:13.6E}{row}" for row in _matrix_rows(matrix / powers)]
    added = hydro.added_mass / powers
    damping = hydro.radiation_damping / powers / hydro.omega[:, None, None]
    for period, a, b in zip(2 * np.pi / hydro.omega, added, damping, strict=True):
        pairs = zip(_matrix_rows(a), b.ravel(), strict=True)
        rows += [f" {period:13.6E}{row} {value:13.6E}" for row, value in pairs]
    return rows


def _excitation_rows(hydro: HydroCoefficients, length: float) -> list[str]:
    force = hydro.excitation / (hydro.density * hydro.gravity * length ** (2.0 + _ROTATIONS))
    modulus, phase = np.abs(force), np.degrees(np.angle(force))
    rows = []
    for n, period in enumerate(2 * np.pi / hydro.omega):
        for m, heading in enumerate(np.degrees(hydro.heading)):
            rows += [
                f" {period:13.6E} {heading:13.6E} {mode + 1:5d} {modulus[m, n, mode]:13.6E} {phase[m, n, mode]:13.6E}"
                f" {force[m, n, mode].real:13.6E} {force[m, n, mode].imag:13.6E}"
                for mode in range(6)
            ]
    return rows


def _matrix_rows(matrix: np.ndarray) -> list[str]:
    """Return the rows 'i j value' of a 6 x 6 matrix."""
    return [f" {i + 1:5d} {j + 1:5d} {matrix[i, j]:13.6E}" for i in range(6) for j in range(6)]


def write_capytaine(hydro: HydroCoefficients, path: str | Path, *, body_name: str = "floater") -> Path:
    """Write coefficients as a netCDF file in the layout of Capytaine (2 and 3) and return its path.

    Complex numbers as a dimension re, im and in Capytaine's convention e^{-i omega t}; frequencies zero and infinite
    carry the limits of the added mass, their excitation is not a number. Double precision. The hydrostatic stiffness
    is that of buoyancy alone and says so in its attribute `weight`, besides volume and centre of buoyancy.
    """
    import xarray as xr  # here, because it takes long

    path, hydro = Path(path), tabulated(hydro)
    ends = [(0.0, hydro.added_mass_zero)], [(np.inf, hydro.added_mass_infinite)]
    low, high = ([(w, a) for w, a in end if a is not None] for end in ends)
    omega = np.concatenate([[w for w, _ in low], hydro.omega, [w for w, _ in high]])
    pad = (len(low), len(high))
    added = np.concatenate([np.array([a for _, a in end]).reshape(-1, 6, 6) for end in (low, [], high)])
    added = np.concatenate([added[: pad[0]], hydro.added_mass, added[pad[0] :]])
    damping = np.pad(hydro.radiation_damping, (pad, (0, 0), (0, 0)))
    matrix = ("omega", "radiating_dof", "influenced_dof")
    data = {
        "added_mass": (matrix, np.swapaxes(added, 1, 2)),
        "radiation_damping": (matrix, np.swapaxes(damping, 1, 2)),
        "rotation_center": (("point_coordinates",), hydro.reference_point),
    }
    coordinates = {
        "omega": omega, "radiating_dof": _DOFS, "influenced_dof": _DOFS, "g": hydro.gravity, "rho": hydro.density,
        "water_depth": hydro.depth, "body_name": body_name, "forward_speed": 0.0,
    }  # fmt: skip
    finite = np.isfinite(omega)
    number = np.full(len(omega), np.inf)
    number[finite] = wavenumber(omega[finite], hydro.depth, hydro.gravity)
    coordinates |= {"wavenumber": ("omega", number)}
    if hydro.excitation is not None:
        data["excitation_force"] = _complex_force(hydro, pad)
        coordinates |= {"complex": ["re", "im"], "wave_direction": hydro.heading}
    if hydro.hydrostatic_stiffness is not None:
        dims = ("influenced_dof", "radiating_dof")
        data["hydrostatic_stiffness"] = (dims, hydro.hydrostatic_stiffness, {"weight": "excluded"})
    if hydro.volume is not None:
        data["disp_volume"] = hydro.volume
    if hydro.centre_of_buoyancy is not None:
        data["center_of_buoyancy"] = (("point_coordinates",), hydro.centre_of_buoyancy)
    attributes = {"time_convention": "exp(-i omega t)", "written_by": "fowtio"}
    with atomic_file(path) as temporary:
        xr.Dataset(data, coords=coordinates, attrs=attributes).to_netcdf(temporary, engine="h5netcdf")
    return path


def _complex_force(hydro: HydroCoefficients, pad: tuple[int, int]) -> tuple:
    """Return the excitation as Capytaine stores it: (complex, omega, wave_direction, influenced_dof)."""
    force = np.pad(np.conj(hydro.excitation), ((0, 0), pad, (0, 0)), constant_values=np.nan).swapaxes(0, 1)
    return ("complex", "omega", "wave_direction", "influenced_dof"), np.stack([force.real, force.imag])
