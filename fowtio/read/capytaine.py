"""Capytaine's netCDF results: labelled arrays with dimensions, convention e^{-i omega t}.

Source of the format: Capytaine's documentation, versions 1.5 to 3 (data sets of `assemble_dataset`). Complex numbers
are a dimension "re", "im" (separate_complex_values); added mass and damping are labelled by radiating and influenced
DoF; the excitation is Froude-Krylov plus diffraction. The crest is at the origin, moments are about rotation_center.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fowtio.errors import FormatError
from fowtio.read.hydro_common import (
    check_damping,
    choose_body,
    coefficients,
    describe_hydro,
    hydro_problems,
    without_weight,
)
from fowtio.read.registry import Format
from model.conventions import PLATFORM_DOFS
from model.system.hydro import HydroCoefficients

if TYPE_CHECKING:
    import xarray as xr

_FREQUENCY_DIMS = ("omega", "period", "freq", "wavenumber", "wavelength")
_EXTRA_DIMS = ("water_depth", "rho", "g", "body_name", "forward_speed")


def read_capytaine(
    path: str | Path, *, body: str | int | None = None, weight: tuple | None = None, volume: float | None = None
) -> HydroCoefficients:
    """Return the coefficients of a Capytaine netCDF file, about the origin, waves e^{+i omega t}.

    body by name or number (from 1) of a file with several; the coupling with the others is left out. Capytaine's
    hydrostatic stiffness has the weight's share: it is taken off when the file has the centre of mass, or weight is
    given, the (mass [kg], centre (3) [m]) that the run knew; when neither is there, no stiffness is returned. volume
    [m3] is needed only when the file has none and the rotation centre is not the origin. Raises FormatError.
    """
    path = Path(path)
    data = _open(path)
    if "added_mass" not in data or "radiation_damping" not in data:
        raise FormatError(
            path, expected="added_mass and radiation_damping of Capytaine", found=", ".join(data) or "nothing"
        )
    data = _single_problem(path, data)
    frequency, omega = _omega(path, data)
    radiating = _bodies(data["radiating_dof"].values)
    names = list(radiating)
    place = choose_body(path, body, names)
    name = names[place]
    labels = _six(path, radiating[name], name)
    force_labels = _six(path, _bodies(data["influenced_dof"].values).get(name, {}), name)
    select = {"radiating_dof": labels, "influenced_dof": force_labels}
    dims = (frequency, "influenced_dof", "radiating_dof")
    added = data["added_mass"].sel(select).transpose(*dims).values.astype(float)
    damping = data["radiation_damping"].sel(select).transpose(*dims).values.astype(float)
    finite = np.isfinite(omega) & (omega > 0)
    point = _centre(path, data, "rotation_center", place, name)
    fields = {
        "omega": omega[finite], "added_mass": added[finite], "radiation_damping": damping[finite],
        "added_mass_zero": _limit(added, omega == 0), "added_mass_infinite": _limit(added, np.isinf(omega)),
        "density": float(data["rho"]), "gravity": float(data["g"]), "depth": float(data["water_depth"]),
        "volume": volume if volume is not None else _scalar(data, "disp_volume", place),
        "centre_of_buoyancy": _centre(path, data, "center_of_buoyancy", place, name),
    }  # fmt: skip
    check_damping(path, fields["radiation_damping"], fields["omega"])
    force = _excitation(path, data, frequency, force_labels)
    if force is not None:
        fields |= {
            "heading": data["wave_direction"].values.astype(float).ravel(),
            "excitation": np.conj(force[:, finite]),
        }
    point = np.zeros(3) if point is None else point
    fields["hydrostatic_stiffness"] = _stiffness(path, data, select, place, name, weight, point, fields["gravity"])
    return coefficients(path, point=point, **fields)


def _open(path: Path) -> xr.Dataset:
    import xarray as xr  # here, because it takes long and most files are not of this format

    if not path.is_file():
        raise FormatError(path, hint="The file does not exist; check its name and folder")
    try:
        return xr.load_dataset(path)
    except Exception as error:  # netCDF libraries raise many kinds for a damaged file
        raise FormatError(
            path, expected="a netCDF file", found=str(error).splitlines()[0] if str(error) else ""
        ) from None


def _single_problem(path, data: xr.Dataset) -> xr.Dataset:
    """Return the data without dimensions of length one; several depths, densities or speeds are refused."""
    for name in _EXTRA_DIMS:
        if name in data.dims and data.sizes[name] > 1:
            raise FormatError(
                path, expected=f"one {name}", found=f"{data.sizes[name]}", hint="Select one and save it apart"
            )
    data = data.squeeze([d for d in _EXTRA_DIMS if d in data.dims])
    for name in ("rho", "g", "water_depth"):
        if name not in data or data[name].size != 1:
            raise FormatError(path, expected=f"one {name}", found="none" if name not in data else f"{data[name].size}")
    if "forward_speed" in data and np.any(data["forward_speed"].values != 0):
        raise FormatError(path, expected="forward_speed 0", found=str(data["forward_speed"].values))
    return data


def _omega(path, data: xr.Dataset) -> tuple[str, np.ndarray]:
    """Return the frequency dimension and omega [rad/s] on it, which may hold zero and infinity."""
    name = next((d for d in _FREQUENCY_DIMS if d in data["added_mass"].dims), None)
    if name is None:
        raise FormatError(
            path, expected=f"a dimension {', '.join(_FREQUENCY_DIMS)}", found=", ".join(data["added_mass"].dims)
        )
    with np.errstate(divide="ignore"):
        if "omega" in data.coords:
            omega = data["omega"].values
        elif "period" in data.coords:
            omega = 2 * np.pi / data["period"].values
        elif "freq" in data.coords:
            omega = 2 * np.pi * data["freq"].values
        else:
            raise FormatError(path, expected="a coordinate omega, period or freq", found=name)
    return name, np.atleast_1d(omega.astype(float))


def _bodies(labels) -> dict[str, dict[str, str]]:
    """Return the labels of each body: {body: {dof: label}}; 'Body__Surge', or 'Surge' of a single body."""
    out: dict[str, dict[str, str]] = {}
    for label in labels:
        body, _, dof = str(label).rpartition("__")
        out.setdefault(body or "body", {})[dof.casefold()] = label
    return out


def _six(path, own: dict[str, str], name: str) -> list[str]:
    lacking = [dof for dof in PLATFORM_DOFS if dof not in own]
    if lacking:
        raise FormatError(
            path,
            expected=f"the six rigid degrees of freedom of {name!r}",
            found=f"no {', '.join(lacking)} among {', '.join(own)}",
        )
    return [own[dof] for dof in PLATFORM_DOFS]


def _excitation(path, data: xr.Dataset, frequency: str, labels: list[str]) -> np.ndarray | None:
    """Return the excitation (m, n, 6) as the file has it, e^{-i omega t}, or the sum of its parts."""
    parts = [_complex(data[n], frequency, labels) for n in ("Froude_Krylov_force", "diffraction_force") if n in data]
    total = _complex(data["excitation_force"], frequency, labels) if "excitation_force" in data else None
    if total is None and len(parts) < 2:
        return None
    if total is not None and len(parts) == 2:
        with np.errstate(invalid="ignore"):
            error = np.nanmax(np.abs(total - parts[0] - parts[1])) / np.nanmax(np.abs(total))
        if error > 1e-4:
            raise FormatError(
                path, expected="excitation_force equal to Froude_Krylov_force + diffraction_force",
                found=f"a difference of {error:.2g} of the largest", hint="Were the parts edited?",
            )  # fmt: skip
    return parts[0] + parts[1] if total is None else total


def _complex(array: xr.DataArray, frequency: str, labels: list[str]) -> np.ndarray:
    if "complex" in array.dims:
        array = array.sel(complex="re", drop=True) + 1j * array.sel(complex="im", drop=True)
    if "wave_direction" not in array.dims:
        array = array.expand_dims("wave_direction")
    return array.sel(influenced_dof=labels).transpose("wave_direction", frequency, "influenced_dof").values


def _stiffness(path, data, select, place, name, weight, point, gravity) -> np.ndarray | None:
    """Return the stiffness (6, 6) about the rotation centre without the weight's share, None when that is not known."""
    if "hydrostatic_stiffness" not in data:
        return None
    array = data["hydrostatic_stiffness"]
    matrix = array.sel(select).transpose("influenced_dof", "radiating_dof").values.astype(float)
    if array.attrs.get("weight") == "excluded":
        return matrix
    if weight is None:
        centre = _centre(path, data, "center_of_mass", place, name)
        mass = _scalar(data, "disp_mass", place)
        if mass is None and "inertia_matrix" in data:
            inertia = data["inertia_matrix"].sel(select).transpose("influenced_dof", "radiating_dof").values
            mass = float(inertia[2, 2])
        if centre is None or mass is None:
            return None
        weight = (mass, centre)
    return without_weight(matrix, weight[0], weight[1], point, gravity)


def _centre(path, data: xr.Dataset, variable: str, place: int, name: str) -> np.ndarray | None:
    """Return the point (3) of one body, or None."""
    if variable not in data:
        return None
    array = data[variable]
    if array.ndim == 2:
        component = next(d for d in array.dims if d != "point_coordinates")
        labels = [str(v) for v in data[component].values] if component in data.coords else []
        array = array.isel({component: labels.index(name) if name in labels else place})
    values = np.asarray(array.values, dtype=float)
    if values.shape != (3,) or not np.all(np.isfinite(values)):
        raise FormatError(path, expected=f"three coordinates of {variable}", found=str(array.values))
    return values


def _scalar(data: xr.Dataset, variable: str, place: int) -> float | None:
    if variable not in data:
        return None
    values = np.atleast_1d(data[variable].values)
    return float(values[place if values.size > 1 else 0])


def _limit(values: np.ndarray, mask: np.ndarray) -> np.ndarray | None:
    return values[mask][0] if np.any(mask) and np.all(np.isfinite(values[mask][0])) else None


def _recognises(path, head: bytes) -> bool:
    netcdf = head[:3] == b"CDF" or head[:8] == b"\x89HDF\r\n\x1a\n"
    if not netcdf:
        return False
    if b"radiating_dof" in head:
        return True
    import xarray as xr

    try:
        with xr.open_dataset(path) as data:
            return "radiating_dof" in data.dims
    except Exception:
        return False


CAPYTAINE = Format(
    name="Capytaine netCDF (.nc)",
    recognises=_recognises,
    read=read_capytaine,
    describe=describe_hydro,
    problems=hydro_problems,
)
