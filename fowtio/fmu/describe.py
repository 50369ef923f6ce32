"""What an FMU offers: its variables, their names, units and start values, and the numbers behind them."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from model.conventions import frozen
from model.environment.rotor_wind import RotorSensitivity, rotor_spectra
from model.environment.sea import SeaState, default_gamma
from model.environment.wind import WindState
from model.reduce.excitation import WaveForce
from model.reduce.state_space import ModalForm, StateSpace

REPEAT_PERIOD = 3600.0  # s, after which internal sea and wind repeat
SEA_TOP, WIND_TOP = 1.0, 0.8  # Hz
LARGEST_PART = 0.1  # s: longest part of a step while sea or wind change inside it
LARGEST_SEED = 2**31 - 1
GROUPS = ("elevation", "wave_force", "sea", "wind", "turbulence", "platform_force", "tower_force")
UNITS = {
    "m": ({"m": 1}, {}), "s": ({"s": 1}, {}), "rad": ({"rad": 1}, {"deg": 180 / np.pi}), "m/s": ({"m": 1, "s": -1}, {}),
    "m/s2": ({"m": 1, "s": -2}, {}), "rad/s": ({"rad": 1, "s": -1}, {"deg/s": 180 / np.pi}), "rad/s2": ({"rad": 1, "s": -2}, {"deg/s2": 180 / np.pi}),
    "N": ({"kg": 1, "m": 1, "s": -2}, {"kN": 1e-3}), "N.m": ({"kg": 1, "m": 2, "s": -2}, {"kN.m": 1e-3}), "1/s": ({"s": -1}, {}), "1": ({}, {}),
}  # fmt: skip
DISPLAY = {"rad": "deg", "rad/s": "deg/s", "rad/s2": "deg/s2", "N": "kN", "N.m": "kN.m"}
_SI = {"m/s^2": "m/s2", "rad/s^2": "rad/s2", "N m": "N.m"}
_CHANNELS = {
    "PtfmSurge": ("Platform.Surge", "surge"), "PtfmSway": ("Platform.Sway", "sway"), "PtfmHeave": ("Platform.Heave", "heave"),
    "PtfmRoll": ("Platform.Roll", "roll"), "PtfmPitch": ("Platform.Pitch", "pitch"), "PtfmYaw": ("Platform.Yaw", "yaw"),
    "TTDspFA": ("Tower.TopDeflectionFA", "fore-aft deflection of the tower top"),
    "TTDspSS": ("Tower.TopDeflectionSS", "side-to-side deflection of the tower top"),
    "NcIMUTAxs": ("Nacelle.AccelerationFA", "acceleration of the nacelle along the shaft, downwind"),
    "NcIMUTAys": ("Nacelle.AccelerationSS", "sideways acceleration of the nacelle"),
    "TwrBsFxt": ("Tower.BaseShearFA", "fore-aft shear at the tower base"),
    "TwrBsFyt": ("Tower.BaseShearSS", "side-to-side shear at the tower base"),
    "TwrBsMyt": ("Tower.BaseMomentFA", "fore-aft moment at the tower base"),
    "TwrBsMxt": ("Tower.BaseMomentSS", "side-to-side moment at the tower base"),
    "relative_wind": ("Wind.RelativeSpeed", "wind speed relative to the moving hub"),
    "hub_wind": ("Wind.HubSpeed", "wind speed at the hub, turbulence included"),
    "sea_elevation": ("Sea.Elevation", "elevation of the internal sea at the reference point"),
}  # fmt: skip
_AXES = {"x": "ForceX", "y": "ForceY", "z": "ForceZ", "xx": "MomentX", "yy": "MomentY", "zz": "MomentZ"}
_FORCES = {
    "wave_force": ("Wave.", "wave force or moment about the platform reference point"),
    "platform_force": ("Platform.External", "external force or moment at the platform reference point"),
    "tower_force": ("Tower.Top", "external force or moment at the tower top"),
}  # fmt: skip
_INITIAL = {"fa1": "FA1", "fa2": "FA2", "ss1": "SS1", "ss2": "SS2"}
_WIND = {
    "wind": ("Wind.Speed", "wind speed of the whole rotor, at hub height"),
    "wind_vertical": ("Wind.VerticalGradient", "vertical gradient of the wind speed over the rotor, deviation from the mean"),
    "wind_lateral": ("Wind.LateralGradient", "lateral gradient of the wind speed over the rotor, deviation from the mean"),
}  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Variable:
    """One variable of the FMU. kind: time, input, parameter, integer, constant, output, state, derivative; index: its place among
    those of its kind. feeds: names of the inputs that act on it at once; channel: OpenFAST's name.
    """

    name: str
    kind: str
    index: int
    unit: str = "1"
    description: str = ""
    start: float | int | None = None
    low: float | None = None
    high: float | None = None
    feeds: tuple[str, ...] = ()
    channel: str = ""

    @property
    def causality(self) -> str:
        """Causality in the sense of FMI."""
        return {
            "time": "independent",
            "input": "input",
            "parameter": "parameter",
            "integer": "parameter",
            "constant": "output",
            "output": "output",
        }.get(self.kind, "local")

    @property
    def variability(self) -> str:
        """Variability in the sense of FMI."""
        return {"parameter": "fixed", "integer": "fixed", "constant": "constant"}.get(self.kind, "continuous")

    @property
    def initial(self) -> str | None:
        """The attribute `initial`, None for inputs and time, which have none."""
        return {"time": None, "input": None, "parameter": "exact", "integer": "exact", "constant": "exact"}.get(
            self.kind, "calculated"
        )

    @property
    def display_unit(self) -> str | None:
        """Unit that people read, None when it is the SI unit."""
        return DISPLAY.get(self.unit)


@dataclass(frozen=True, eq=False, kw_only=True)
class SeaTable:
    """Wave force per metre for the internal sea: omega (n) [rad/s], heading (m) [rad], force (m, n, 6); the sea it starts with."""

    omega: np.ndarray
    heading: np.ndarray
    force: np.ndarray
    start: SeaState


@dataclass(frozen=True, eq=False, kw_only=True)
class TurbulenceTable:
    """Amplitudes (2, n) [m/s, 1/s] of the wind and of each gradient for unit turbulence intensity, and the intensity to start with."""

    amplitude: np.ndarray
    intensity: float


@dataclass(frozen=True, eq=False, kw_only=True)
class Description:
    """All that goes into an FMU: identifier (a C name), title, variables, modal form, columns of its inputs (m) and for every external
    input its column and offset, sea and turbulence tables, notes for people, a token that changes with any number.
    """

    identifier: str
    title: str
    variables: tuple[Variable, ...]
    modal: ModalForm
    columns: tuple[str, ...]
    input_column: tuple[int, ...] = ()
    input_offset: tuple[float, ...] = ()
    sea: SeaTable | None = None
    turbulence: TurbulenceTable | None = None
    time_shift: float = 0.0
    notes: dict = field(default_factory=dict)

    def of_kind(self, kind: str) -> tuple[Variable, ...]:
        """Return the variables of one kind, in order."""
        return tuple(v for v in self.variables if v.kind == kind)

    def reference(self, name: str) -> int:
        """Return the value reference of a variable."""
        return next(k for k, v in enumerate(self.variables) if v.name == name)

    @property
    def token(self) -> str:
        """GUID or instantiation token: a fingerprint of all numbers and names."""
        digest = hashlib.sha256(
            repr(
                (self.identifier, self.title, self.variables, self.columns, self.input_column, self.input_offset)
            ).encode()
        )
        for array in (self.modal.a, self.modal.b, self.modal.c, self.modal.d, self.modal.mean, self.modal.initial):
            digest.update(np.ascontiguousarray(array).tobytes())
        for array in (
            None if self.sea is None else self.sea.force,
            None if self.turbulence is None else self.turbulence.amplitude,
        ):
            digest.update(b"" if array is None else np.ascontiguousarray(array).tobytes())
        h = digest.hexdigest()
        return f"{{{h[:8]}-{h[8:12]}-{h[12:16]}-{h[16:20]}-{h[20:32]}}}"


def describe(
    space: StateSpace,
    modal: ModalForm,
    *,
    identifier: str,
    title: str = "",
    inputs: Sequence[str] | None = None,
    wind_speed: float = 0.0,
    sea: SeaTable | None = None,
    turbulence: TurbulenceTable | None = None,
    notes: dict | None = None,
) -> Description:
    """Return the description of an FMU.

    Parameters
    ----------
    space, modal : the system and its modal form (`modal` of a reduced system too)
    identifier : a C identifier, the name of the binary
    inputs : names of those columns of the space that are inputs from outside; None means all
    wind_speed : of the operating point, which the input Wind.Speed starts from [m/s]
    sea, turbulence : tables of the internal sea and wind, which the columns wave_force_* and wind* then receive
    """
    outside = [n for n in space.inputs if inputs is None or n in inputs]
    space, modal = _with_signals(space, modal, sea, turbulence, outside, wind_speed)
    columns = space.inputs
    variables = [Variable(name="time", kind="time", index=0, unit="s", description="time")]
    for k, name in enumerate(outside):
        label, text = _input_name(name)
        start = wind_speed if name == "wind" else 0.0
        variables.append(
            Variable(
                name=label,
                kind="input",
                index=k,
                unit=_unit(space.input_units[columns.index(name)]),
                description=text,
                start=start,
            )
        )
    variables += _parameters(space, sea, turbulence, bool(outside))
    if space.time_shift:
        text = "the response to Wave.Elevation is this late: give the elevation this much earlier"
        variables.append(
            Variable(
                name="Wave.TimeShift", kind="constant", index=0, unit="s", description=text, start=space.time_shift
            )
        )
    labels = {n: _input_name(n)[0] for n in outside}
    for k, name in enumerate(space.outputs):
        label, text, channel = _output_name(name)
        feeds = tuple(labels[n] for n in outside if modal.d[k, columns.index(n)] != 0)
        variables.append(
            Variable(
                name=label,
                kind="output",
                index=k,
                unit=_unit(space.output_units[k]),
                description=text,
                feeds=feeds,
                channel=channel,
            )
        )
    for k in range(len(modal.a)):
        variables.append(
            Variable(name=f"State.Mode[{k + 1}]", kind="state", index=k, description=f"state {k + 1} in modal form")
        )
    for k in range(len(modal.a)):
        feeds = tuple(labels[n] for n in outside if modal.b[k, columns.index(n)] != 0)
        variables.append(
            Variable(
                name=f"der(State.Mode[{k + 1}])",
                kind="derivative",
                index=k,
                unit="1/s",
                description=f"time derivative of state {k + 1}",
                feeds=feeds,
            )
        )
    return Description(
        identifier=identifier, title=title or identifier, variables=tuple(variables), modal=modal, columns=columns,
        input_column=tuple(columns.index(n) for n in outside),
        input_offset=tuple(wind_speed if n == "wind" else 0.0 for n in outside), sea=sea, turbulence=turbulence,
        time_shift=space.time_shift, notes=notes or {},
    )  # fmt: skip


def _with_signals(
    space: StateSpace, modal: ModalForm, sea, turbulence, outside, wind_speed: float
) -> tuple[StateSpace, ModalForm]:
    """Return both with the outputs that only pass on what comes in: the internal sea's elevation and the wind at the hub."""
    b, c, d, mean = modal.b, modal.c, modal.d, modal.mean
    inputs, input_units, outputs, units = (
        list(space.inputs),
        list(space.input_units),
        list(space.outputs),
        list(space.output_units),
    )
    if sea is not None:
        inputs.append("sea_elevation")
        input_units.append("m")
        b, d = np.pad(b, ((0, 0), (0, 1))), np.pad(d, ((0, 0), (0, 1)))
        c, mean = np.pad(c, ((0, 1), (0, 0))), np.append(mean, 0.0)
        d = np.vstack([d, np.eye(len(inputs))[-1]])
        outputs.append("sea_elevation")
        units.append("m")
    if "wind" in inputs and ("wind" in outside or turbulence is not None):
        c, mean = np.pad(c, ((0, 1), (0, 0))), np.append(mean, wind_speed)
        d = np.vstack([d, np.eye(len(inputs))[inputs.index("wind")]])
        outputs.append("hub_wind")
        units.append("m/s")
    modal = replace(modal, b=b, c=c, d=d, mean=mean)
    wide = replace(
        space, b=np.pad(space.b, ((0, 0), (0, len(inputs) - len(space.inputs)))), c=np.pad(space.c, ((0, len(outputs) - len(space.outputs)), (0, 0))),
        d=d, mean=mean, inputs=tuple(inputs), input_units=tuple(input_units), outputs=tuple(outputs), output_units=tuple(units),
    )  # fmt: skip
    return wide, modal


def _parameters(
    space: StateSpace, sea: SeaTable | None, turbulence: TurbulenceTable | None, has_inputs: bool
) -> list[Variable]:
    """Return the parameters, real ones and integers, in the order of their places."""
    real, integer = [], []

    def add_integer(name: str, start: int, low: int, high: int, text: str) -> None:
        integer.append(Variable(name=name, kind="integer", index=len(integer), start=start, low=low, high=high, description=text))

    if sea is not None:
        first = sea.start
        period = first.peak_period or 10.0
        height = first.significant_height or 0.0
        gamma = first.gamma or (default_gamma(height, period) if height else 3.3)
        low, high = (-2 * np.pi, 2 * np.pi) if _full_turn(sea.heading) else (sea.heading[0], sea.heading[-1])
        real += [
            Variable(name="Sea.Hs", kind="parameter", index=0, unit="m", start=height, low=0.0, high=30.0, description="significant wave height of the internal sea; 0: none"),
            Variable(name="Sea.Tp", kind="parameter", index=1, unit="s", start=period, low=1.0, high=60.0, description="peak period of the internal sea"),
            Variable(name="Sea.Gamma", kind="parameter", index=2, unit="1", start=gamma, low=1.0, high=7.0, description="JONSWAP peak factor of the internal sea"),
            Variable(name="Sea.Heading", kind="parameter", index=3, unit="rad", start=float(np.clip(first.heading, low, high)), low=float(low), high=float(high), description="direction the internal sea goes to, 0 downwind, counter-clockwise"),
        ]  # fmt: skip
        add_integer("Sea.Seed", 1, 0, LARGEST_SEED, "seed of the internal sea's phases")
    if turbulence is not None:
        real += [
            Variable(name="Wind.MeanOffset", kind="parameter", index=len(real), unit="m/s", start=0.0, low=-10.0, high=10.0, description="added to the wind speed of the operating point"),
            Variable(name="Wind.TurbulenceIntensity", kind="parameter", index=len(real) + 1, unit="1", start=turbulence.intensity, low=0.0, high=1.0, description="of the internal wind; 0: steady"),
        ]  # fmt: skip
        add_integer("Wind.Seed", 1, 0, LARGEST_SEED, "seed of the internal wind's phases")
    for name, unit in zip(space.initial_names, space.initial_units, strict=True):
        label = "Initial." + "".join(_INITIAL.get(part, part.capitalize()) for part in name.split("_"))
        what = name.replace("_", " ")
        real.append(
            Variable(
                name=label,
                kind="parameter",
                index=len(real),
                unit=_unit(unit),
                start=0.0,
                description=f"{what} at the start, deviation from the mean",
            )
        )
    if has_inputs:
        text = "co-simulation inputs within a step: 0 held (or along the derivatives given), 1 linear from their values at the last communication point"
        add_integer("Settings.InputInterpolation", 0, 0, 1, text)
    return real + integer


def sea_table(waves: WaveForce, columns: Sequence[int], omega, start: SeaState) -> SeaTable:
    """Return the wave force from some headings of `waves` at omega (n) [rad/s], between which it is taken as linear."""
    chosen = [list(columns)[k] for k in np.argsort(waves.heading[list(columns)])]
    force = np.stack([waves.at(omega, column) for column in chosen])
    return SeaTable(
        omega=frozen(omega), heading=frozen(waves.heading[chosen]), force=frozen(force, dtype=complex), start=start
    )


def turbulence_table(wind: WindState, rotor: RotorSensitivity, intensity: float) -> TurbulenceTable:
    """Return amplitudes of the wind that the rotor feels, for unit turbulence intensity, every 1/REPEAT_PERIOD up to WIND_TOP."""
    unit = replace(wind, turbulence_class=None, turbulence_intensity=0.5)
    omega = 2 * np.pi * np.arange(1, int(WIND_TOP * REPEAT_PERIOD) + 1) / REPEAT_PERIOD
    collective, gradient = rotor_spectra(unit, rotor, omega)
    step = 2 * np.pi / REPEAT_PERIOD
    return TurbulenceTable(
        amplitude=frozen(2 * np.sqrt(2 * step * np.stack([collective, gradient]))), intensity=intensity
    )


def _full_turn(heading) -> bool:
    return bool(heading[-1] - heading[0] > 2 * np.pi - 1e-6)


def _unit(unit: str) -> str:
    out = _SI.get(unit, unit)
    if out not in UNITS:
        raise ValueError(f"unit {unit!r} is none of {', '.join(UNITS)}")
    return out


def _input_name(name: str) -> tuple[str, str]:
    """Return the FMU's name and the description of a column."""
    if name == "elevation":
        return "Wave.Elevation", "wave elevation at the reference point, earlier by Wave.TimeShift"
    if name in _WIND:
        return _WIND[name]
    stem, _, axis = name.rpartition("_")
    if stem in _FORCES:
        prefix, text = _FORCES[stem]
        return prefix + _AXES[axis], text
    return name, name


def _output_name(name: str) -> tuple[str, str, str]:
    """Return the FMU's name, the description, and OpenFAST's channel name if there is one."""
    if name in _CHANNELS:
        label, text = _CHANNELS[name]
        own = name if name[0].isupper() else ""
        return label, text + (f" (OpenFAST's {own})" if own else ""), own
    if name.startswith("T["):
        line = name[2:-1]
        return f"Mooring.FairleadTension[{line}]", f"fairlead tension of line {line} (MAP's {name})", name
    dof, _, what = name.rpartition("_")
    if what in ("velocity", "acceleration"):
        return f"Platform.{dof.capitalize()}{what.capitalize()}", f"{dof} {what} of the platform", ""
    return name, name, ""
