"""The turbine at any wind speed from its deck and a rotor performance table, as a study's names ask for it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fowtio.errors import FormatError, ModelError
from fowtio.read.openfast_deck import Deck
from fowtio.read.openfast_input import InputFile, read_input
from fowtio.read.rotor_table import read_rotor_table
from model.system.aero import (
    RotorDerivatives,
    operating_schedule,
    operating_turbine,
    rotor_derivatives,
    rotor_performance,
    spinning_inertia,
)
from model.system.controller import (
    ROTOR_AZIMUTH,
    TORQUE_LAWS,
    Controller,
    controlled_turbine,
    pitch_gains,
    torque_slope,
)
from model.system.gusts import gust_thrust, in_turbulence
from model.system.tower import TOWER_MODES
from model.system.turbine import TurbineMatrices

ROTOR_NAMES = (
    "RotorTable",
    "RotorPower",
    "RatedSpeed",
    "MinSpeed",
    "FinePitch",
    "TorqueLaw",
    "SpeedLoopFreq",
    "SpeedLoopDamp",
    "FloatGain",
)


@dataclass(frozen=True, kw_only=True)
class RotorEntry:
    """A rotor table and how the turbine is run: rated_power [W] of the rotor, rated_speed and minimum_speed [rad/s], fine_pitch
    [rad] (None: the table's best); above rated the torque law, and the speed loop's frequency [rad/s] and damping ratio;
    platform_feedback [rad per m/s].
    """

    path: Path
    rated_power: float
    rated_speed: float
    minimum_speed: float = 0.0
    fine_pitch: float | None = None
    torque_law: str = "constant_power"
    loop_frequency: float = 0.2
    loop_damping: float = 0.7
    platform_feedback: float = 0.0


def rotor_entry(source: InputFile) -> RotorEntry | None:
    """Return what a study says of its rotor table, None when it names none; raise FormatError.

    RotorPower in MW, speeds in rpm, FinePitch in deg, SpeedLoopFreq in rad/s, FloatGain in deg per m/s.
    """
    if source.is_default("RotorTable") or source.text("RotorTable").lower() in ("none", "-"):
        return None
    path = source.file("RotorTable")
    law = "constant_power" if source.is_default("TorqueLaw") else source.text("TorqueLaw").lower()
    if law not in TORQUE_LAWS:
        raise FormatError(source.path, source.line("TorqueLaw"), expected=f"one of {', '.join(TORQUE_LAWS)}", found=law)
    return RotorEntry(
        path=path, rated_power=1e6 * _positive(source, "RotorPower"), rated_speed=_positive(source, "RatedSpeed") * np.pi / 30,
        minimum_speed=_positive(source, "MinSpeed", 0.0) * np.pi / 30, torque_law=law,
        fine_pitch=None if source.is_default("FinePitch") else np.radians(source.number("FinePitch")),
        loop_frequency=_positive(source, "SpeedLoopFreq", 0.2), loop_damping=_positive(source, "SpeedLoopDamp", 0.7),
        platform_feedback=np.radians(source.number("FloatGain", 0.0)),
    )  # fmt: skip


def thrust_table(source: InputFile) -> Path | None:
    """Return the rotor table that a study names for its thrust in turbulence, None when it names none; raise FormatError."""
    if source.is_default("ThrustTable") or source.text("ThrustTable").lower() in ("none", "-"):
        return None
    return source.file("ThrustTable")


def gusty_turbine(path: Path, deck: Deck, turbine: TurbineMatrices, hub_row, std: float) -> tuple[TurbineMatrices, str]:
    """Return a turbine with its thrust in turbulence of a standard deviation [m/s] at a point, and a note; raise ModelError.

    hub_row (q) is the hub's translation downwind per unit of each of its degrees of freedom.
    """
    rotor, speed = deck.elastodyn.structure.rotor, turbine.wind_speed
    performance = rotor_performance(read_rotor_table(path), rotor.diameter / 2, deck.air_density, speed)
    try:
        gust = gust_thrust(performance, speed, turbine.rotor_speed, float(turbine.force[0]) / np.cos(rotor.tilt), std)
    except ValueError as error:
        raise ModelError(f"{path}: {error}") from None
    note = (
        f"thrust at {speed:g} m/s in turbulence of {std:.2f} m/s: slope {gust.gain:.3f} of that in steady wind, mean {gust.change / 1e3:+.1f} kN "
        f"({path.name} at pitch {np.degrees(gust.pitch):.2f} deg)"
    )
    return in_turbulence(turbine, gust, hub_row), note


def rotor_turbine(
    entry: RotorEntry, deck: Deck, dofs: Sequence[str] | None, wind_speed: float
) -> tuple[TurbineMatrices, list[str]]:
    """Return the turbine at a wind speed [m/s] and notes on what was assumed; raise ModelError where the table does not reach.

    The rotor's speed is free, with its controller, when `generator_azimuth` is among the degrees of freedom; else speed and
    pitch are held. dofs None takes the deck's.
    """
    structure = deck.elastodyn.structure
    modes = tuple(d for d in (deck.elastodyn.dofs if dofs is None else dofs) if d in TOWER_MODES)
    free = dofs is not None and ROTOR_AZIMUTH in dofs
    try:
        point, above = _point(entry, deck, wind_speed)
        where = (
            f"{entry.path.name} at {point.rotor_speed * 30 / np.pi:.2f} rpm, pitch {np.degrees(point.pitch):.2f} deg"
        )
        if not free:
            return operating_turbine(structure, modes, point), [
                f"turbine at {wind_speed:g} m/s from {where}, speed and pitch held"
            ]
        rotating = read_input(deck.elastodyn.path)
        generator = rotating.number("GenIner", 0.0) * rotating.number("GBRatio", 1.0) ** 2
        controller = _controller(entry, point, above, spinning_inertia(structure) + generator)
        turbine = controlled_turbine(structure, modes, point, controller, generator_inertia=generator)
    except ValueError as error:
        raise ModelError(f"{entry.path}, {wind_speed:g} m/s: {error}") from None
    region = f"{entry.torque_law} and pitch control" if above else "optimal torque"
    return turbine, [f"turbine at {wind_speed:g} m/s from {where}, rotor speed free, {region}"]


def _point(entry: RotorEntry, deck: Deck, wind_speed: float) -> tuple[RotorDerivatives, bool]:
    """Return the derivatives at the operating point of a wind speed, and whether the power is held there."""
    performance = rotor_performance(
        read_rotor_table(entry.path), deck.elastodyn.structure.rotor.diameter / 2, deck.air_density, wind_speed
    )
    run = operating_schedule(
        performance, wind_speed, rated_power=entry.rated_power, rated_speed=entry.rated_speed, minimum_speed=entry.minimum_speed,
        fine_pitch=entry.fine_pitch,
    )  # fmt: skip
    point = rotor_derivatives(performance, wind_speed, float(run.rotor_speed[0]), float(run.pitch[0]))
    return point, bool(run.power[0] > 0.999 * entry.rated_power)


def _controller(entry: RotorEntry, point: RotorDerivatives, above: bool, inertia: float) -> Controller:
    """Return the controller at an operating point: torque alone below rated, pitch with the speed loop's poles above."""
    if not above:
        return Controller(torque_slope=torque_slope("optimal", point))
    slope = torque_slope(entry.torque_law, point)
    proportional, integral = pitch_gains(point, inertia, entry.loop_frequency, entry.loop_damping, slope=slope)
    return Controller(
        pitch_proportional=proportional,
        pitch_integral=integral,
        platform_feedback=entry.platform_feedback,
        torque_slope=slope,
    )


def _positive(source: InputFile, name: str, default: float | None = None) -> float:
    """Return a number above zero (a default may be zero)."""
    if default is not None and source.is_default(name):
        return default
    value = source.number(name)
    if value <= 0:
        raise FormatError(source.path, source.line(name), expected=f"{name} above zero", found=f"{value:g}")
    return value
