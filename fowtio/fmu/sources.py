"""The files inside an FMU from its description: C tables, model description, build files."""

from __future__ import annotations

import json
from pathlib import Path

import jinja2
import numpy as np

import fowtio
from fowtio.errors import ModelError
from fowtio.fmu.describe import LARGEST_PART, REPEAT_PERIOD, SEA_TOP, UNITS, Description, Variable
from fowtio.write.resources import template_folder

LICENCE = "Apache-2.0 (code); the numbers belong to the study"
C_FILES = ("core.h", "instance.h")
_KINDS = {
    "time": "V_TIME", "input": "V_INPUT", "parameter": "V_PARAMETER", "integer": "V_INTEGER", "constant": "V_CONSTANT", "output": "V_OUTPUT",
    "state": "V_STATE", "derivative": "V_DERIVATIVE",
}  # fmt: skip


def write_sources(d: Description, version: str, folder: Path) -> None:
    """Write everything but the binary of an FMU of FMI version "2.0" or "3.0" into a folder."""
    templates = template_folder("fmu")
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(templates), keep_trailing_newline=True, undefined=jinja2.StrictUndefined
    )
    main = "fmi2.c" if version == "2.0" else "fmi3.c"
    sources = folder / "sources"
    sources.mkdir(parents=True)

    def render(template: str, place: Path, **values) -> None:
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(
            environment.get_template(template).render(d=d, version=fowtio.__version__, **values), encoding="utf-8"
        )

    for name in (*C_FILES, main, "LICENSE"):
        (sources / name).write_text((templates / name).read_text(encoding="utf-8"), encoding="utf-8")
    render("model_data.h.j2", sources / "model_data.h", **_c_tables(d))
    render("CMakeLists.txt.j2", sources / "CMakeLists.txt", source=main)
    structure = _structure(d)
    if version == "2.0":
        render("modelDescription2.xml.j2", folder / "modelDescription.xml", licence=LICENCE, **structure)
        licences = folder / "documentation"
    else:
        render("modelDescription3.xml.j2", folder / "modelDescription.xml", licence=LICENCE, **structure)
        render("buildDescription.xml.j2", sources / "buildDescription.xml")
        if terminals := _terminals(d):
            render(
                "terminalsAndIcons.xml.j2", folder / "terminalsAndIcons" / "terminalsAndIcons.xml", terminals=terminals
            )
        licences = folder / "documentation" / "licenses"
    licences.mkdir(parents=True)
    (licences / "license.txt").write_text((templates / "LICENSE").read_text(encoding="utf-8"), encoding="utf-8")
    resources = folder / "resources"
    resources.mkdir()
    about = {
        "fowtio": fowtio.__version__, "title": d.title, "time_shift_s": d.time_shift, "openfast_channels": {v.name: v.channel for v in d.variables if v.channel},
        "notes": d.notes,
    }  # fmt: skip
    (resources / "fowtio.json").write_text(json.dumps(about, indent=1, allow_nan=False), encoding="utf-8")


def _structure(d: Description) -> dict:
    """Return what the model descriptions need beside the variables: units, and the structure as places of variables."""
    place = {v.name: k for k, v in enumerate(d.variables)}
    states = [place[v.name] for v in d.of_kind("state")]
    used = {v.unit for v in d.variables}
    outputs = [
        (place[v.name], sorted(_states(d, v, states) + [place[n] for n in v.feeds])) for v in d.of_kind("output")
    ]
    constants = [(place[v.name], []) for v in d.of_kind("constant")]
    derivatives = [
        (place[v.name], sorted(_own(d, v.index, states) + [place[n] for n in v.feeds])) for v in d.of_kind("derivative")
    ]
    initial = sorted([p for p, _ in outputs] + states + [p for p, _ in derivatives])
    return {
        "units": [(name, UNITS[name]) for name in UNITS if name in used and name != "1"], "outputs": constants + outputs, "derivatives": derivatives,
        "initial": initial, "first_state": states[0] if states else 0,
    }  # fmt: skip


def _states(d: Description, output: Variable, states: list[int]) -> list[int]:
    return [p for p, c in zip(states, d.modal.c[output.index], strict=True) if c != 0]


def _own(d: Description, index: int, states: list[int]) -> list[int]:
    real = len(d.modal.real)
    first = index if index < real else real + 2 * ((index - real) // 2)
    return states[first : first + (1 if index < real else 2)]


def _terminals(d: Description) -> list[tuple[str, str, list[str]]]:
    """Return the connectors of FMI 3: what a controller, a mooring model or a power take-off joins on to."""
    names = [v.name for v in d.variables if v.causality in ("input", "output") and v.kind != "constant"]

    def those(*starts: str) -> list[str]:
        return [n for n in names if n.startswith(starts)]

    groups = [
        ("PlatformPoint", "platform reference point: external forces, motion", [n for n in those("Platform.") if "External" in n or not n.endswith("Acceleration")], "Platform.External"),
        ("TowerTop", "tower top: external forces, motion", those("Tower.Top", "Nacelle."), "Tower.TopForce"),
        ("WaveLoad", "generalised wave forces", those("Wave.Force", "Wave.Moment"), "Wave.Force"),
    ]  # fmt: skip
    return [
        (name, text, members) for name, text, members, needed in groups if any(m.startswith(needed) for m in members)
    ]


def _c_tables(d: Description) -> dict:
    """Return sizes and arrays of model_data.h."""
    m, inputs, real, integer = d.modal, d.of_kind("input"), d.of_kind("parameter"), d.of_kind("integer")
    first_initial = next((v.index for v in real if v.name.startswith("Initial.")), len(real))
    place = {v.name: v.index for v in real + integer}
    sizes = [
        ("N_REAL", len(m.real)), ("N_PAIR", len(m.frequency)), ("N_STATE", len(m.a)), ("N_COLUMN", len(d.columns)), ("N_INPUT", len(inputs)),
        ("N_OUTPUT", len(m.mean)), ("N_PARAMETER", len(real)), ("N_INTEGER", len(integer)), ("N_INITIAL", len(real) - first_initial),
        ("N_VARIABLE", len(d.variables)), ("P_INITIAL", first_initial), ("I_INTERPOLATION", place.get("Settings.InputInterpolation", len(integer))),
        ("HAS_SEA", int(d.sea is not None)), ("HAS_TURBULENCE", int(d.turbulence is not None)), ("REPEAT_PERIOD", f"{REPEAT_PERIOD:.1f}"),
        ("LARGEST_PART", LARGEST_PART),
    ]  # fmt: skip
    arrays = [
        _array("double", "pole_real", m.real, "N_REAL"), _array("double", "pole_decay", m.decay, "N_PAIR"), _array("double", "pole_frequency", m.frequency, "N_PAIR"),
        _array("double", "matrix_b", m.b.T, "N_COLUMN", "N_STATE"), _array("double", "matrix_c", m.c.T, "N_STATE", "N_OUTPUT"),
        _array("double", "matrix_d", m.d.T, "N_COLUMN", "N_OUTPUT"), _array("double", "matrix_initial", m.initial.T, "N_INITIAL", "N_STATE"),
        _array("double", "output_mean", m.mean, "N_OUTPUT"), _array("short", "input_column", d.input_column, "N_INPUT"),
        _array("double", "input_offset", d.input_offset, "N_INPUT"), _array("double", "input_start", [v.start for v in inputs], "N_INPUT"),
        _array("double", "parameter_start", [v.start for v in real], "N_PARAMETER"),
        _array("double", "parameter_least", [-1e300 if v.low is None else v.low for v in real], "N_PARAMETER"),
        _array("double", "parameter_most", [1e300 if v.high is None else v.high for v in real], "N_PARAMETER"),
        _array("int32_t", "integer_start", [v.start for v in integer], "N_INTEGER"), _array("int32_t", "integer_least", [v.low for v in integer], "N_INTEGER"),
        _array("int32_t", "integer_most", [v.high for v in integer], "N_INTEGER"),
        _array("double", "constant", [v.start for v in d.of_kind("constant")], "N_CONSTANT"),
    ]  # fmt: skip
    sizes.append(("N_CONSTANT", len(d.of_kind("constant"))))
    if d.sea is not None:
        force = np.stack([d.sea.force.real, d.sea.force.imag], axis=-1).reshape(*d.sea.force.shape[:2], 12)
        names = ("Sea.Hs", "Sea.Tp", "Sea.Gamma", "Sea.Heading")
        sizes += [(f"P_SEA_{k}", place[n]) for k, n in zip(("HS", "TP", "GAMMA", "HEADING"), names, strict=True)]
        sizes += [
            ("I_SEA_SEED", place["Sea.Seed"]), ("COLUMN_WAVE", d.columns.index("wave_force_x")), ("COLUMN_SEA", d.columns.index("sea_elevation")),
            ("N_HEADING", len(d.sea.heading)), ("N_SEA_OMEGA", len(d.sea.omega)), ("SEA_TOP", SEA_TOP),
        ]  # fmt: skip
        arrays += [
            _array("double", "sea_heading", d.sea.heading, "N_HEADING"), _array("double", "sea_omega", d.sea.omega, "N_SEA_OMEGA"),
            _array("float", "sea_force", force, "N_HEADING", "N_SEA_OMEGA", 12),
        ]  # fmt: skip
    if d.turbulence is not None:
        sizes += [
            ("P_WIND_OFFSET", place["Wind.MeanOffset"]), ("P_WIND_TI", place["Wind.TurbulenceIntensity"]), ("I_WIND_SEED", place["Wind.Seed"]),
            ("COLUMN_WIND", d.columns.index("wind")), ("N_WIND", d.turbulence.amplitude.shape[1]),
        ]  # fmt: skip
        arrays.append(_array("float", "wind_amplitude", d.turbulence.amplitude, 2, "N_WIND"))
    kinds = "{" + ", ".join(_KINDS[v.kind] for v in d.variables) + "}"
    indices = "{" + ", ".join(str(v.index) for v in d.variables) + "}"
    return {
        "title": d.title.replace("*/", "* /"),
        "token": d.token,
        "sizes": sizes,
        "arrays": arrays,
        "kinds": kinds,
        "indices": indices,
    }


def _array(kind: str, name: str, values, *lengths) -> tuple[str, str]:
    """Return declaration and initialiser of a C array; every named length has one to spare, so that none is empty."""
    array = np.asarray(values, dtype=float)
    if not np.all(np.isfinite(array)):
        raise ModelError(f"the state space holds a number in {name} that is not finite")
    shape = "".join(f"[{n} + 1]" if isinstance(n, str) else f"[{n}]" for n in lengths)
    if kind == "double":
        write = repr if len(lengths) == 1 else "{:.11g}".format  # the poles to the last digit
    elif kind == "float":
        write = "{:.5e}f".format
    else:

        def write(x):
            return str(int(x))

    def nested(a: np.ndarray, ends: str) -> str:
        if a.ndim == 1:
            return "{" + ", ".join(write(float(x)) for x in a) + "}" if len(a) else "{0}"
        return (
            "{" + (",\n" if a.ndim == 2 else ",\n\n").join(nested(row, "") for row in a) + "}"
            if len(a)
            else "{" * a.ndim + "0" + "}" * a.ndim
        )

    if array.ndim > 1 and array.shape[-1] == 0:
        array = np.zeros((*array.shape[:-1], 1))
    return f"static const {kind} {name}{shape}", nested(array, "")
