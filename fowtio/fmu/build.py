"""From a study to an FMU: fits, state space, sources, compiler, archive."""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
import zipfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from fowtio.case import StateEntry
from fowtio.errors import ModelError
from fowtio.fmu.describe import (
    GROUPS,
    SEA_TOP,
    Description,
    SeaTable,
    TurbulenceTable,
    describe,
    sea_table,
    turbulence_table,
)
from fowtio.fmu.sources import write_sources
from fowtio.workflow import Model, OperatingPoint, state_excitation
from fowtio.write.atomic import atomic_file
from model.environment.wind import WindState
from model.reduce.excitation import ExcitationFit, WaveForce, fit_wave_force, wave_force
from model.reduce.importance import importance
from model.reduce.radiation import RadiationFit, fit_radiation
from model.reduce.state_space import StateSpace, modal_form, reduce_balanced, state_space
from model.reduce.targets import paths
from model.response.drag_iteration import linear_drag_model
from model.response.solve import Excitation, Response, prepare, solve
from model.system.hydro import headings_cover

VERSIONS = ("2.0", "3.0")
BAND = (2 * np.pi * 0.005, 2 * np.pi * 0.5)  # rad/s in which the fits aim at the responses
CLOSE = 0.003  # rad/s between the frequencies at which the wave force is fitted
SEA_STEP = 0.05  # rad/s, largest step of the internal sea's table of forces
PLATFORMS = {
    "linux64": ("linux64", "x86_64-linux", ".so", ("gcc", "cc", "clang"), ("-fPIC",)),
    "win64": ("win64", "x86_64-windows", ".dll", ("x86_64-w64-mingw32-gcc",), ("-static-libgcc",)),
}  # fmt: skip
FLAGS = (
    "-std=c99",
    "-O3",
    "-Wall",
    "-Wextra",
    "-Wpedantic",
    "-Wshadow",
    "-Wstrict-prototypes",
    "-Werror",
    "-fvisibility=hidden",
)
_SPACE_GROUPS = {"elevation": "elevation", "wave_force": "wave_force", "sea": "wave_force", "wind": "wind", "turbulence": "wind",
                 "platform_force": "platform_force", "tower_force": "tower_force"}  # fmt: skip


@dataclass(frozen=True, eq=False, kw_only=True)
class Linearised:
    """A model as a state space about one state: the state, its point and response (the headings of the internal sea last among its
    own), the frequencies [rad/s] at which the coefficients were computed, fits of radiation and excitation, the space, the bound of its
    reduction (zero without).
    """

    state: StateEntry
    point: OperatingPoint
    response: Response
    column: int
    waves: WaveForce
    data: np.ndarray
    radiation: RadiationFit
    excitation: ExcitationFit | None
    space: StateSpace
    reduction_bound: float


@dataclass(frozen=True, eq=False, kw_only=True)
class Exported:
    """FMU files written, by FMI version, with their description and the model behind."""

    files: dict[str, Path]
    description: Description
    linearised: Linearised


def export_fmu(
    model: Model,
    path: str | Path,
    *,
    state: str | None = None,
    versions: Sequence[str] = ("2.0",),
    inputs: Sequence[str] = GROUPS,
    order: int | None = None,
    platform: str = "linux64",
    progress: Callable[[str], None] = lambda text: None,
) -> Exported:
    """Write the linear model about one state as an FMU.

    Parameters
    ----------
    model : an assembled study
    path : file to write; with several versions "_fmi2" and "_fmi3" are added to its stem
    state : name of the state whose operating point and drag are taken; None takes the first
    versions : of VERSIONS
    inputs : of GROUPS; those that the state cannot have (wind when it is calm) are left out
    order : number of states to keep by balanced reduction; None keeps all
    platform : of PLATFORMS

    Raises ModelError for an unknown name, or when no compiler for the platform is installed.
    """
    _check_names(inputs, versions, platform)
    compiler = find_compiler(platform)
    found = linearise(model, state, inputs=inputs, order=order, progress=progress)
    progress("splitting into modes")
    description = _describe(model, found, Path(path), inputs)
    files = {}
    for version in versions:
        progress(f"compiling for FMI {version}")
        place = Path(path) if len(versions) == 1 else Path(path).with_name(f"{Path(path).stem}_fmi{version[0]}.fmu")
        files[version] = write_fmu(description, place, version=version, platform=platform, compiler=compiler)
    return Exported(files=files, description=description, linearised=found)


def linearise(
    model: Model, state: str | None = None, *, inputs: Sequence[str] = GROUPS, order: int | None = None,
    progress: Callable[[str], None] = lambda text: None,
) -> Linearised:  # fmt: skip
    """Return the state space of a model about one of its states."""
    entry = _state(model, state)
    point = model.at(entry.wind_speed)
    progress(f"solving {entry.name}")
    response, column, low_frequency = _respond(model, entry, point)
    waves = wave_force(point.system.hydro, response, low_frequency=low_frequency)
    own = _own_part(response, column)
    matters = importance(point.outputs, own, point.modes.frequency, BAND)
    progress("fitting radiation")
    aims = partial(
        paths, point.system, point.mean, point.outputs, response.drag_damping, lambda omega: waves.at(omega, column), BAND,
        data=model.hydro.omega, natural=point.modes.frequency,
    )  # fmt: skip
    radiation = fit_radiation(point.system.hydro, matters, aims(), data=model.hydro.omega)
    excitation = None
    if "elevation" in inputs:
        progress("fitting excitation")
        close = aims(step=CLOSE)
        excitation = fit_wave_force(waves, column, close.targets(radiation(close.omega)))
    groups = {_SPACE_GROUPS[g] for g in inputs if entry.wind_speed > 0 or g not in ("wind", "turbulence")}
    space = state_space(
        point.system, point.mean, point.outputs, response.drag_damping, radiation, excitation=excitation,
        structure=model.deck.elastodyn.structure, inputs=tuple(groups),
    )  # fmt: skip
    bound = 0.0
    if order is not None:
        try:
            space, _, bound = reduce_balanced(space, order)
        except ValueError as error:
            raise ModelError(str(error)) from None
    return Linearised(
        state=entry, point=point, response=response, column=column, waves=waves, data=model.hydro.omega, radiation=radiation,
        excitation=excitation, space=space, reduction_bound=bound,
    )  # fmt: skip


def write_fmu(
    description: Description,
    path: str | Path,
    *,
    version: str = "2.0",
    platform: str = "linux64",
    compiler: str | None = None,
) -> Path:
    """Write an FMU from a description and return its path; the same description gives the same bytes."""
    compiler = compiler or find_compiler(platform)
    path = Path(path)
    with tempfile.TemporaryDirectory() as scratch, atomic_file(path) as temporary:
        folder = Path(scratch) / "fmu"
        write_sources(description, version, folder)
        two, three, suffix, _, _ = PLATFORMS[platform]
        binary = folder / "binaries" / (two if version == "2.0" else three) / (description.identifier + suffix)
        binary.parent.mkdir(parents=True)
        compile_library(folder / "sources", binary, compiler, platform)
        _pack(folder, temporary)
    return path


def compile_library(
    sources: Path, binary: Path, compiler: str, platform: str = "linux64", flags: Sequence[str] = FLAGS
) -> None:
    """Compile the sources of an FMU; raise ModelError with the compiler's words."""
    main = sources / ("fmi2.c" if (sources / "fmi2.c").is_file() else "fmi3.c")
    strip = () if any(f.startswith(("-g", "-fsanitize")) for f in flags) else ("-s",)
    command = [compiler, *flags, *PLATFORMS[platform][4], "-shared", *strip, "-o", str(binary), main.name, "-lm"]
    done = subprocess.run(command, cwd=sources, capture_output=True, text=True, check=False)
    if done.returncode:
        raise ModelError(f"{compiler} could not compile the FMU:\n{done.stderr.strip()[:2000]}")


def find_compiler(platform: str) -> str:
    """Return the compiler of a platform; raise ModelError saying what to install."""
    names = PLATFORMS[platform][3]
    for name in names:
        if shutil.which(name):
            return name
    hint = (
        "on Debian: apt-get install gcc-mingw-w64-x86-64" if platform == "win64" else "on Debian: apt-get install gcc"
    )
    raise ModelError(f"no compiler for {platform} is installed ({', '.join(names)}); {hint}")


def _check_names(inputs: Sequence[str], versions: Sequence[str], platform: str) -> None:
    for given, known, what in (
        (inputs, GROUPS, "group of inputs"),
        (versions, VERSIONS, "FMI version"),
        ([platform], tuple(PLATFORMS), "platform"),
    ):
        for name in given:
            if name not in known:
                raise ModelError(f"{what} {name!r} is unknown; there are {', '.join(known)}")


def _state(model: Model, name: str | None) -> StateEntry:
    if name is None:
        return model.states[0]
    for entry in model.states:
        if entry.name == name:
            return entry
    raise ModelError(f"no state is named {name!r}; there are {', '.join(s.name for s in model.states)}")


def _respond(model: Model, entry: StateEntry, point: OperatingPoint) -> tuple[Response, int, str]:
    """Return the response of a state with more headings of no energy after its own: the state's heading, then the data's."""
    drive, options = state_excitation(model, entry), model.case.options
    hydro = point.system.hydro
    more = np.concatenate([[entry.sea.heading], _headings(hydro)])
    wide = Excitation(
        omega=drive.omega, heading=np.concatenate([drive.heading, more]), wind_spectrum=drive.wind_spectrum,
        gradient_spectrum=drive.gradient_spectrum, wave_spectrum=np.concatenate([drive.wave_spectrum, np.zeros((len(more), len(drive.omega)))]),
    )  # fmt: skip
    grid = prepare(point.system, wide.omega, wide.heading, low_frequency=options.low_frequency_excitation)
    response = solve(point.system, point.mean, wide, grid=grid, drag=linear_drag_model(options.drag_model))
    if not response.converged:
        raise ModelError(f"state {entry.name!r}: drag did not converge in {response.iterations} iterations")
    return response, len(drive.heading), options.low_frequency_excitation


def _headings(hydro) -> np.ndarray:
    """Return the headings of the internal sea: those of the data, closed to a full turn where the data go round."""
    heading = hydro.heading
    closes = len(heading) > 2 and np.all(headings_cover(hydro, np.linspace(-np.pi, np.pi, 73)))
    if closes and heading[-1] - heading[0] < 2 * np.pi - 1e-6:
        heading = np.append(heading, heading[0] + 2 * np.pi)
    return heading


def _own_part(response: Response, column: int) -> Response:
    """Return the response to the state's own heading alone."""
    drive = response.excitation
    drive = replace(drive, heading=drive.heading[[column]], wave_spectrum=drive.wave_spectrum[[column]])
    return replace(response, to_wave=response.to_wave[[column]], excitation=drive)


def _describe(model: Model, found: Linearised, path: Path, inputs: Sequence[str]) -> Description:
    """Return the description of the FMU of a linearised model."""
    entry, point = found.state, found.point
    windy = entry.wind_speed > 0
    outside = [n for n in found.space.inputs if _group(n) in inputs]
    sea = _sea(found, inputs) if "sea" in inputs else None
    turbulence = (
        _turbulence(model, entry, point, inputs)
        if windy and "turbulence" in inputs and point.rotor is not None
        else None
    )
    radiation, excitation = found.radiation, found.excitation
    notes = {
        "study": model.case.title, "state": entry.name, "wind_speed_m_s": entry.wind_speed, "states": found.space.order,
        "radiation_error_of_peak": radiation.largest_error, "radiation_blocks": [list(b) for b in radiation.blocks],
        "radiation_orders": list(radiation.orders), "radiation_least_damping": radiation.least_damping[1],
        "excitation_error_of_peak": None if excitation is None else float(excitation.error.max()),
        "excitation_shift_s": None if excitation is None else excitation.shift, "reduction_bound": found.reduction_bound,
        "wave_heading_rad": float(entry.sea.heading),
    }  # fmt: skip
    title = f"{model.case.title}, state {entry.name}" + (f", {entry.wind_speed:g} m/s" if windy else ", parked")
    return describe(
        found.space, modal_form(found.space), identifier=re.sub(r"\W|^(?=\d)", "_", path.stem), title=title, inputs=outside,
        wind_speed=entry.wind_speed, sea=sea, turbulence=turbulence, notes=notes,
    )  # fmt: skip


def _group(column: str) -> str:
    """Return the group of inputs that a column of the state space belongs to."""
    return (
        "wind"
        if column.startswith("wind")
        else column.rsplit("_", 1)[0]
        if column.startswith(("wave", "platform", "tower"))
        else column
    )


def _sea(found: Linearised, inputs: Sequence[str]) -> SeaTable:
    """Return the table of the internal sea, calm at the start where waves can come from outside."""
    start = found.state.sea
    if start.kind not in ("jonswap", "pierson_moskowitz") or {"elevation", "wave_force"} & set(inputs):
        start = replace(
            start,
            kind="jonswap",
            significant_height=0.0,
            peak_period=start.peak_period or 10.0,
            gamma=None,
            level=None,
            band=None,
            systems=None,
            omega=None,
            spectrum=None,
        )
    gaps = zip(found.data, found.data[1:], strict=False)
    own = [np.linspace(a, b, 1 + int(np.ceil((b - a) / SEA_STEP))) for a, b in gaps]
    omega = np.unique(np.concatenate([[0.01, 0.03], *own, np.linspace(found.data[-1], 2 * np.pi * SEA_TOP, 12)]))
    omega = omega[(omega >= found.waves.omega[0]) & (omega <= found.waves.omega[-1])]
    return sea_table(found.waves, range(found.column + 1, len(found.waves.heading)), omega, start)


def _turbulence(model: Model, entry: StateEntry, point: OperatingPoint, inputs: Sequence[str]) -> TurbulenceTable:
    """Return the table of the internal wind, steady at the start where the wind can come from outside."""
    structure, options = model.deck.elastodyn.structure, model.case.options
    wind = WindState(
        mean_speed=entry.wind_speed, hub_height=structure.hub_height, rotor_diameter=structure.rotor.diameter,
        spectrum="kaimal" if options.wind_spectrum == "api" else options.wind_spectrum, averaging=options.wind_averaging, turbulence_intensity=0.5,
    )  # fmt: skip
    intensity = 0.0
    if "wind" not in inputs and entry.turbulence is not None:
        from model.environment.wind import turbulence_sigma

        given = entry.turbulence
        intensity = (
            turbulence_sigma(given, "NTM", entry.wind_speed) / entry.wind_speed
            if isinstance(given, str)
            else float(given)
        )
    return turbulence_table(wind, point.rotor, intensity)


def _pack(folder: Path, path: Path) -> None:
    """Write the archive, files in order and without times, so that equal FMUs are equal files."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for file in sorted(p for p in folder.rglob("*") if p.is_file()):
            info = zipfile.ZipInfo(file.relative_to(folder).as_posix(), (1980, 1, 1, 0, 0, 0))
            info.compress_type = zipfile.ZIP_DEFLATED
            info.external_attr = (0o755 if file.suffix in (".so", ".dll") else 0o644) << 16
            archive.writestr(info, file.read_bytes())
