"""Results as one netCDF file: everything needed to plot again, SI units, complex numbers as real and imaginary parts.

model and loads are those of `fowtio.workflow`: a Model, and a sequence of StateLoads.
"""

from __future__ import annotations

import datetime
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from fowtio import __version__
from fowtio.write.atomic import atomic_file
from fowtio.write.provenance import command
from fowtio.write.quantities import channel_label, dof_unit, people, split_spectra
from model.conventions import PLATFORM_DOFS
from model.response.assemble import all_parts
from model.system.hydro import infinite_added_mass, tabulated
from model.system.mooring import line_profiles
from model.system.mooring_curve import largest_offset, reachable_curve

CONVENTIONS = (
    "SI units, radians, rad/s. Complex amplitudes X in Re{X e^(+i omega t)}; phase 0 is a crest at the origin. "
    "Origin on the tower axis at still water, x downwind, z up; wave heading is the direction of propagation, "
    "counter-clockwise from +x. Spectra are one-sided, per rad/s. Channel names are those of OpenFAST; in SI units, "
    "so rotations in rad."
)
_PHASE = "Re{X e^(+i omega t)}"
_MATRIX_UNITS = "SI (N, m, rad) of row and column"


def write_netcdf(path: str | Path, model, loads: Sequence) -> Path:
    """Write the results of a study as netCDF (netCDF4 layout); the file appears whole or not at all."""
    data = dataset(model, loads)
    with atomic_file(path) as temporary:
        data.to_netcdf(temporary, engine="h5netcdf")
    return Path(path)


def dataset(model, loads: Sequence) -> xr.Dataset:
    """Return the results of a study as labelled arrays.

    Dimensions: state, operating_point, frequency, heading (the place among a state's own; not a number where it
    has fewer), dof, mode, channel, gradient, line, motion (the six of the platform), contribution, and those of the
    hydrodynamic coefficients.
    """
    out = xr.Dataset(coords=_coordinates(model, loads), attrs=_attributes(model, loads))
    for group in (
        _states(model, loads),
        _responses(loads),
        _statistics(loads),
        _points(model),
        _contributions(model),
        _hydro(model),
        _moorings(model),
    ):
        out = out.assign({name: (dims, np.asarray(values), attrs) for name, (dims, values, attrs) in group.items()})
    return out


def complex_variable(data: xr.Dataset, name: str) -> xr.DataArray:
    """Return a complex variable of a results file from its two parts."""
    return data[f"{name}_real"] + 1j * data[f"{name}_imag"]


def _attributes(model, loads) -> dict:
    now = datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
    return {
        "title": model.case.title, "study": model.case.path.name, "deck": model.deck.path.name,
        "deck_title": model.deck.title,
        "source": f"fowtio {__version__}", "history": f"{now} {command(model)}", "conventions": CONVENTIONS,
        "notes": "\n".join(model.notes), "gravity": model.deck.gravity, "water_density": model.deck.density,
        "water_depth": model.deck.depth, "statistics_duration": float(loads[0].statistics.duration),
    }  # fmt: skip


def _coordinates(model, loads) -> dict:
    dofs, names = model.points[0].system.dofs, loads[0].channels.names
    omega = loads[0].response.excitation.omega
    return {
        "state": ("state", [item.state.name for item in loads]),
        "operating_point": ("operating_point", [p.wind_speed for p in model.points], _about("mean wind", "m/s")),
        "frequency": ("frequency", omega / (2 * np.pi), _about("frequency", "Hz")),
        "omega": ("frequency", omega, _about("angular frequency", "rad/s")),
        "dof": ("dof", list(dofs)),
        "dof_column": ("dof_column", list(dofs)),
        "dof_unit": ("dof", [dof_unit(d) for d in dofs]),
        "mode": ("mode", _modes(model)),
        "gradient": ("gradient", ["vertical", "lateral"]),
        "motion": ("motion", list(PLATFORM_DOFS)),
        "motion_column": ("motion_column", list(PLATFORM_DOFS)),
        "channel": ("channel", list(names)),
        "channel_unit": ("channel", list(loads[0].channels.units)),
        "channel_people_unit": ("channel", [people(u)[0] for u in loads[0].channels.units]),
        "channel_label": ("channel", [channel_label(n) for n in names]),
    }  # fmt: skip


def _states(model, loads) -> dict:
    drives = [item.response.excitation for item in loads]
    seas = [item.state.sea for item in loads]

    def sea(name):
        return [np.nan if getattr(s, name) is None else getattr(s, name) for s in seas]

    by_state, by_heading, by_frequency = ("state",), ("state", "heading"), ("state", "frequency")
    turbulence = [str(item.state.turbulence or "none") for item in loads]
    rotor = "wind speed spectrum of the whole rotor"
    gradient = "spectrum of the wind's vertical and lateral gradients, each"
    damping = [item.response.drag_damping for item in loads]
    return {
        "state_wind_speed": (by_state, [item.state.wind_speed for item in loads], _about("mean wind", "m/s")),
        "state_turbulence": (by_state, turbulence, _about("turbulence class or intensity", "")),
        "sea_kind": (by_state, [s.kind for s in seas], _about("wave spectrum", "")),
        "significant_height": (by_state, sea("significant_height"), _about("significant wave height", "m")),
        "wave_peak_period": (by_state, sea("peak_period"), _about("peak period of the waves", "s")),
        "sea_heading": (by_state, sea("heading"), _about("mean direction of wave propagation", "rad")),
        "wave_heading": (by_heading, _padded([d.heading for d in drives]), _about("direction of propagation", "rad")),
        "wave_spectrum": (
            (*by_heading, "frequency"), _padded([d.wave_spectrum for d in drives]),
            _about("wave spectrum of each heading", "m2/(rad/s)"),
        ),
        "wind_spectrum": (by_frequency, [d.wind_spectrum for d in drives], _about(rotor, "(m/s)2/(rad/s)")),
        "gradient_spectrum": (by_frequency, [d.gradient_spectrum for d in drives], _about(gradient, "(1/s)2/(rad/s)")),
        "drag_damping": (("state", "motion", "motion_column"), damping, _about("linearised drag", _MATRIX_UNITS)),
        "drag_iterations": (by_state, [item.response.iterations for item in loads], _about("drag iterations", "")),
    }  # fmt: skip


def _responses(loads) -> dict:
    out = {}
    for name, place, of in (("dof", "dof", "response"), ("channel", "channel", "channels")):
        waves = _padded([getattr(item, of).to_wave for item in loads])
        out |= _complex(
            f"{name}_to_wave",
            ("state", "heading", "frequency", place),
            waves,
            f"transfer function of each {name} to a wave of unit amplitude",
            f"unit of the {name} per m",
        )
        wind = np.array([getattr(item, of).to_wind for item in loads])
        out |= _complex(
            f"{name}_to_wind",
            ("state", "frequency", place),
            wind,
            f"transfer function of each {name} to the wind speed",
            f"unit of the {name} per (m/s)",
        )
        slopes = np.array([getattr(item, of).to_gradients for item in loads])
        out |= _complex(
            f"{name}_to_gradients",
            ("state", "gradient", "frequency", place),
            slopes,
            f"transfer function of each {name} to a gradient of the wind",
            f"unit of the {name} per (m/s/m)",
        )
    parts = [split_spectra(item) for item in loads]
    dims, unit = ("state", "frequency", "channel"), "(unit of the channel)2/(rad/s)"
    return out | {
        "spectrum": (dims, [item.spectra for item in loads], _about("response spectrum", unit)),
        "spectrum_waves": (dims, [p[0] for p in parts], _about("part of the response spectrum that waves cause", unit)),
        "spectrum_wind": (dims, [p[1] for p in parts], _about("part of the response spectrum that wind causes", unit)),
    }


def _statistics(loads) -> dict:
    about = {
        "mean": ("mean", "unit of the channel"), "std": ("standard deviation", "unit of the channel"),
        "extreme": ("expected largest deviation from the mean in statistics_duration", "unit of the channel"),
        "zero_crossing_period": ("mean zero-upcrossing period", "s"),
        "peak_period": ("period of the spectrum's largest value", "s"),
    }  # fmt: skip
    return {
        name: (("state", "channel"), [getattr(item.statistics, name) for item in loads], _about(*text))
        for name, text in about.items()
    }


def _points(model) -> dict:
    points, names = model.points, _modes(model)
    square = ("operating_point", "dof", "dof_column")
    shape = np.full((len(points), len(model.points[0].system.dofs), len(names)), np.nan, dtype=complex)
    frequency, infinite, damping = np.full((3, len(points), len(names)), np.nan)
    for i, point in enumerate(points):
        at = [names.index(n) for n in point.modes.names]
        frequency[i, at], infinite[i, at] = point.modes.frequency, point.modes.frequency_infinite
        damping[i, at], shape[i][:, at] = point.modes.damping_ratio, point.modes.shape
    return {
        "mean_offset": (
            ("operating_point", "dof"),
            [p.mean.offset for p in points],
            _about("mean offset", "unit of the dof"),
        ),
        "rotor_speed": (("operating_point",), [p.turbine.rotor_speed for p in points], _about("rotor speed", "rad/s")),
        "mass": (square, [p.system.mass for p in points], _about("mass without added mass", _MATRIX_UNITS)),
        "damping": (
            square,
            [p.system.damping for p in points],
            _about("damping without radiation and drag", _MATRIX_UNITS),
        ),
        "stiffness": (
            square,
            [p.mean.stiffness for p in points],
            _about("total stiffness about the mean offset", _MATRIX_UNITS),
        ),
        "natural_frequency": (("operating_point", "mode"), frequency, _about("undamped natural frequency", "rad/s")),
        "natural_frequency_infinite": (
            ("operating_point", "mode"),
            infinite,
            _about("undamped natural frequency with the added mass at infinite frequency", "rad/s"),
        ),
        "damping_ratio": (("operating_point", "mode"), damping, _about("damping ratio without drag", "1")),
        **_complex("mode_shape", ("operating_point", "dof", "mode"), shape, "natural mode", "unit of the dof"),
    }


def _contributions(model) -> dict:
    """Return the parts of the equation of motion, zero where an operating point has no such part."""
    found = [{p.name: p for p in all_parts(point.system, point.mean)} for point in model.points]
    names = list(dict.fromkeys(n for parts in found for n in parts))
    q = len(model.points[0].system.dofs)

    def stacked(attribute, shape):
        return [[getattr(parts[n], attribute) if n in parts else np.zeros(shape) for n in names] for parts in found]

    square = ("operating_point", "contribution", "dof", "dof_column")
    line = ("operating_point", "contribution", "dof")
    return {
        "contribution": (("contribution",), names, {}),
        "contribution_source": (
            ("operating_point", "contribution"),
            [[parts[n].source if n in parts else "" for n in names] for parts in found],
            {},
        ),
        "contribution_mass": (square, stacked("mass", (q, q)), _about("mass of each part", _MATRIX_UNITS)),
        "contribution_damping": (square, stacked("damping", (q, q)), _about("damping of each part", _MATRIX_UNITS)),
        "contribution_stiffness": (
            square,
            stacked("stiffness", (q, q)),
            _about("stiffness of each part", _MATRIX_UNITS),
        ),
        "contribution_force": (line, stacked("force", q), _about("force of each part at its point", "N, N m")),
        "contribution_point": (line, stacked("point", q), _about("offset at which that force acts", "unit of the dof")),
    }


def _hydro(model) -> dict:
    hydro = tabulated(model.hydro)
    square = ("hydro_frequency", "motion", "motion_column")
    out = {
        "hydro_frequency": (
            ("hydro_frequency",),
            hydro.omega,
            _about("angular frequency of the hydrodynamic coefficients", "rad/s"),
        ),
        "added_mass": (square, hydro.added_mass, _about("added mass", _MATRIX_UNITS)),
        "radiation_damping": (square, hydro.radiation_damping, _about("radiation damping", _MATRIX_UNITS)),
        "added_mass_infinite": (
            square[1:],
            infinite_added_mass(hydro),
            _about("added mass at infinite frequency", _MATRIX_UNITS),
        ),
    }
    if hydro.hydrostatic_stiffness is not None:
        out["hydrostatic_stiffness"] = (
            square[1:],
            hydro.hydrostatic_stiffness,
            _about("stiffness of buoyancy, without weight", _MATRIX_UNITS),
        )
    if hydro.excitation is not None:
        out["hydro_heading"] = (("hydro_heading",), hydro.heading, _about("wave heading of the excitation", "rad"))
        out |= _complex(
            "excitation",
            ("hydro_heading", "hydro_frequency", "motion"),
            hydro.excitation,
            "wave excitation",
            "N/m, N m/m",
        )
    return out


def _moorings(model) -> dict:
    system, states = model.deck.mooring, [p.mean.mooring for p in model.points]
    if system is None:
        return {}
    dims = ("operating_point", "line")
    return {
        "line": (("line",), [str(n) for n in system.line_names], _about("mooring line", "")),
        "fairlead_tension": (dims, [s.fairlead_tension for s in states], _about("mean tension at the fairlead", "N")),
        "anchor_tension": (dims, [s.anchor_tension for s in states], _about("mean tension at the anchor", "N")),
        "grounded_length": (dims, [s.grounded_length for s in states], _about("length on the seabed", "m")),
        "tension_gradient": (
            (*dims, "motion"),
            [s.tension_gradient for s in states],
            _about("fairlead tension per platform motion", "N/m, N/rad"),
        ),
        "mooring_force": (
            ("operating_point", "motion"),
            [s.force for s in states],
            _about("force of the moorings on the platform", "N, N m"),
        ),
        "mooring_stiffness": (
            ("operating_point", "motion", "motion_column"),
            [s.stiffness for s in states],
            _about("stiffness of the moorings", _MATRIX_UNITS),
        ),
        "line_position": (
            (*dims, "line_node", "axis"),
            [line_profiles(system, s)[0] for s in states],
            _about("shape of the lines, x, y, z", "m"),
        ),
        "line_tension": (
            (*dims, "line_node"),
            [line_profiles(system, s)[1] for s in states],
            _about("mean tension along the lines, from their first ends", "N"),
        ),
        **_offset_curve(system, [p.mean.mooring for p in model.points]),
    }


def _offset_curve(system, states) -> dict:
    """Return restoring force and fairlead tensions of a platform that is moved along x without rotation."""
    offset, force, moved = reachable_curve(system, 0.0, largest_offset(system, [s.offset for s in states]))
    return {
        "mooring_offset": (("mooring_offset",), offset, _about("platform moved along x", "m")),
        "mooring_offset_force": (("mooring_offset",), force, _about("restoring force of the moorings", "N")),
        "mooring_offset_tension": (
            ("mooring_offset", "line"),
            moved.fairlead_tension,
            _about("fairlead tension of the platform moved along x", "N"),
        ),
    }


def _about(text: str, units: str) -> dict:
    return {"long_name": text, "units": units} if units else {"long_name": text}


def _complex(name: str, dims: tuple, values: np.ndarray, text: str, units: str) -> dict:
    """Return real and imaginary part as two variables."""
    attrs = [_about(f"{text}, {part} part", units) | {"convention": _PHASE} for part in ("real", "imaginary")]
    return {f"{name}_real": (dims, values.real, attrs[0]), f"{name}_imag": (dims, values.imag, attrs[1])}


def _padded(arrays: Sequence[np.ndarray]) -> np.ndarray:
    """Return arrays (m, ...) of different m in one, not a number where a state has fewer headings."""
    longest = max(len(a) for a in arrays)
    return np.array([np.concatenate([a, np.full((longest - len(a), *a.shape[1:]), np.nan)]) for a in arrays])


def _modes(model) -> list[str]:
    return list(dict.fromkeys(n for p in model.points for n in p.modes.names))
