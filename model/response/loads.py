"""Linear outputs of a response: motions, tower-top deflection and acceleration, tower-base loads, mooring tensions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.conventions import PLATFORM_DOFS, freeze
from model.environment.sea import wavenumber
from model.response.assemble import Equilibrium, System
from model.response.solve import Response
from model.system.tower import TOWER_MODES, tower_modes
from model.system.turbine import TurbineMatrices, TurbineStructure, head_motion

MOTION_CHANNELS = {
    "surge": ("PtfmSurge", "m"), "sway": ("PtfmSway", "m"), "heave": ("PtfmHeave", "m"), "roll": ("PtfmRoll", "rad"),
    "pitch": ("PtfmPitch", "rad"), "yaw": ("PtfmYaw", "rad"), "tower_fa1": ("TTDspFA", "m"), "tower_ss1": ("TTDspSS", "m"),
}  # fmt: skip


@dataclass(frozen=True, eq=False, kw_only=True)
class LinearOutputs:
    """Channels y = mean + P x + V x' + A x'' + w u of the degrees of freedom's deviation x and the wind's u.

    names, units (c); position, velocity, acceleration (c, q); wind (c, 3) for the wind of the whole rotor and its
    vertical and lateral gradient; mean (c). wave_point (c, 2), when given, is the place [m] whose undisturbed wave elevation
    a channel holds too (NaN for none), and then depth [m] and gravity [m/s2] of the water.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    wind: np.ndarray
    mean: np.ndarray
    wave_point: np.ndarray | None = None
    depth: float = np.inf
    gravity: float = 9.80665

    def __post_init__(self):
        freeze(
            self, wave_point=("c", 2), position=("c", "q"), velocity=("c", "q"), acceleration=("c", "q"), wind=("c", 3), mean=("c",),
        )  # fmt: skip


@dataclass(frozen=True, eq=False, kw_only=True)
class ChannelResponse:
    """Channels of a response: to_wave (m, n, c) per metre of wave amplitude, to_wind (n, c) per m/s, to_gradients (2, n, c) per
    (m/s)/m, mean (c), names, units; incoherent (n, c), spectra that no input causes linearly, one-sided per rad/s.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    to_wave: np.ndarray
    to_wind: np.ndarray
    to_gradients: np.ndarray
    mean: np.ndarray
    incoherent: np.ndarray

    def index(self, name: str) -> int:
        """Return the place of a channel; raise KeyError with the known names."""
        if name not in self.names:
            raise KeyError(f"no channel {name}; there are {', '.join(self.names)}")
        return self.names.index(name)


def linear_outputs(system: System, mean: Equilibrium, structure: TurbineStructure | None) -> LinearOutputs:
    """Return the standard channels of a model about its mean offset.

    Motions and tower-top deflections of the degrees of freedom kept; with a structure, the nacelle's acceleration and
    the tower-base shear and moment; with moorings, the fairlead tension of every line.
    """
    q = len(system.dofs)
    rows = [_motions(system, mean)]
    if structure is not None:
        rows += [_nacelle(system, structure), _tower_base(system, mean, structure)]
    if mean.mooring is not None:
        rows.append(_tensions(system, mean))
    names, units, position, velocity, acceleration, wind, level = ([x for r in rows for x in r[k]] for k in range(7))

    def stacked(values):
        return np.array(values, dtype=float).reshape(len(names), q)

    return LinearOutputs(
        names=tuple(names), units=tuple(units), position=stacked(position), velocity=stacked(velocity),
        acceleration=stacked(acceleration), wind=np.array(wind).reshape(-1, 3), mean=np.array(level),
    )  # fmt: skip


def channel_response(outputs: LinearOutputs, response: Response) -> ChannelResponse:
    """Return the channels' transfer functions, phases kept."""
    iw = 1j * response.excitation.omega[:, None]

    def apply(x):
        return x @ outputs.position.T + iw * (x @ outputs.velocity.T) + iw**2 * (x @ outputs.acceleration.T)

    return ChannelResponse(
        names=outputs.names, units=outputs.units, to_wave=apply(response.to_wave) + _elevation(outputs, response),
        to_wind=apply(response.to_wind) + outputs.wind[:, 0], mean=outputs.mean,
        to_gradients=apply(response.to_gradients) + outputs.wind[:, 1:].T[:, None], incoherent=_incoherent(outputs, response),
    )  # fmt: skip


def _incoherent(outputs: LinearOutputs, response: Response) -> np.ndarray:
    """Return the spectra (n, c) of the channels for the incoherent part of the motions."""
    omega = response.excitation.omega[:, None, None]
    if not np.any(response.incoherent):
        return np.zeros((len(omega), len(outputs.names)))
    rows = outputs.position + 1j * omega * outputs.velocity - omega**2 * outputs.acceleration
    return ((rows @ response.incoherent) * rows.conj()).sum(axis=-1).real


def _elevation(outputs: LinearOutputs, response: Response) -> np.ndarray | float:
    """Return the wave elevation (m, n, c) at the channels' places per metre of amplitude at the origin."""
    if outputs.wave_point is None:
        return 0.0
    drive = response.excitation
    k = wavenumber(drive.omega, outputs.depth, outputs.gravity)
    x, y = np.nan_to_num(outputs.wave_point).T
    along = np.cos(drive.heading)[:, None] * x + np.sin(drive.heading)[:, None] * y
    return np.exp(-1j * k[:, None] * along[:, None, :]) * np.isfinite(outputs.wave_point[:, 0])


def response_spectra(channels: ChannelResponse, response: Response) -> np.ndarray:
    """Return one-sided response spectra (n, c) [unit2/(rad/s)]: waves of all headings, wind and its gradients, uncorrelated."""
    return sum(spectra_by_cause(channels, response))


def spectra_by_cause(channels: ChannelResponse, response: Response) -> tuple[np.ndarray, np.ndarray]:
    """Return the parts (n, c), (n, c) of the response spectra that waves, with drag's incoherent part, and wind cause."""
    drive = response.excitation
    waves = np.einsum("mnc,mn->nc", np.abs(channels.to_wave) ** 2, drive.wave_spectrum) + channels.incoherent
    gusts = np.abs(channels.to_wind) ** 2 * drive.wind_spectrum[:, None]
    gradients = (np.abs(channels.to_gradients) ** 2).sum(axis=0) * drive.gradient_spectrum[:, None]
    return waves, gusts + gradients


def _blank(count: int, q: int) -> list[list]:
    return [[0.0] * q for _ in range(count)]


def _motions(system: System, mean: Equilibrium) -> tuple[list, ...]:
    q = len(system.dofs)
    named = [d for d in system.dofs if d in MOTION_CHANNELS]
    unit = [list(np.eye(q)[system.dofs.index(d)]) for d in named]
    names, units = ([MOTION_CHANNELS[d][k] for d in named] for k in (0, 1))
    level = [float(mean.offset[system.dofs.index(d)]) for d in named]
    n = len(named)
    return names, units, unit, _blank(n, q), _blank(n, q), _blank(n, 3), level


def _nacelle(system: System, structure: TurbineStructure) -> tuple[list, ...]:
    """Acceleration of the nacelle's accelerometer along the tilted shaft, downwind, and sideways (gravity not sensed, as in
    OpenFAST 5), in axes at rest.
    """
    q, tilt = len(system.dofs), structure.rotor.tilt
    axes = np.array([[np.cos(tilt), 0.0, np.sin(tilt)], [0.0, 1.0, 0.0]])
    modes = tuple(d for d in system.dofs if d in TOWER_MODES)
    motion = head_motion(structure.tower.top_height, tower_modes(structure.tower, modes), structure.accelerometer)
    known = PLATFORM_DOFS + modes
    full = np.zeros((2, q))
    for k, dof in enumerate(known):
        if dof in system.dofs:
            full[:, system.dofs.index(dof)] = axes @ motion[:3, k]
    return (
        ["NcIMUTAxs", "NcIMUTAys"], ["m/s^2"] * 2, _blank(2, q), _blank(2, q), [list(r) for r in full], _blank(2, 3), [0.0] * 2,
    )  # fmt: skip


@dataclass(frozen=True, eq=False, kw_only=True)
class TowerBaseRows:
    """TwrBsFxt, TwrBsFyt, TwrBsMyt, TwrBsMxt as linear outputs: position (..., 4, q), velocity and acceleration (4, q), wind (4, 3),
    mean (..., 4), leading axes as the offsets'.
    """

    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    wind: np.ndarray
    mean: np.ndarray


def tower_base_rows(turbine: TurbineMatrices, dofs, offset, base_height: float) -> TowerBaseRows:
    """Return shear and moment on the tower base: inertia, gravity, damping and aerodynamic load of all that stands above it.

    offset (..., q) of the degrees of freedom `dofs` (q); base_height [m]. The turbine's own equations give the force that it
    exerts on the platform in fixed directions about the reference point; the section's axes turn with the platform, so the weight
    appears in the shear, and the moment is brought up to the base.
    """
    offset, q = np.asarray(offset, dtype=float), len(dofs)
    at = np.stack([offset[..., dofs.index(d)] if d in dofs else np.full(offset.shape[:-1], turbine.point[k]) for k, d in enumerate(turbine.dofs)], axis=-1)
    load = turbine.force - (at - turbine.point) @ turbine.stiffness.T
    weight = -load[..., 2]
    up = np.zeros((4, 6))  # from force and moment about the reference point to the base
    up[0, 0] = up[1, 1] = up[2, 4] = up[3, 3] = 1.0
    up[2, 0], up[3, 1] = -base_height, base_height
    take = [turbine.dofs.index(d) for d in dofs if d in turbine.dofs]
    to = [k for k, d in enumerate(dofs) if d in turbine.dofs]
    matrices = np.zeros((3, 4, q))
    matrices[:, :, to] = -up @ np.stack([m[:6][:, take] for m in (turbine.stiffness, turbine.damping, turbine.mass)])
    turn, angles = np.zeros((4, q)), np.zeros(offset.shape[:-1] + (2,))  # the weight along the section's own axes
    for k, (axis, sign) in enumerate((("pitch", 1.0), ("roll", -1.0))):
        if axis in dofs:
            turn[:, dofs.index(axis)] = sign * up[:, k]
            angles[..., k] = sign * offset[..., dofs.index(axis)]
    wind = up @ np.vstack([turbine.wind_force, turbine.gradient_force])[:, :6].T
    return TowerBaseRows(
        position=matrices[0] + weight[..., None, None] * turn, velocity=matrices[1], acceleration=matrices[2], wind=wind,
        mean=load[..., :6] @ up.T + weight[..., None] * (angles @ up[:, :2].T),
    )  # fmt: skip


def _tower_base(system: System, mean: Equilibrium, structure: TurbineStructure) -> tuple[list, ...]:
    """Shear and moment on the tower base."""
    rows = tower_base_rows(system.turbine, system.dofs, mean.offset, structure.tower.base_height)
    lists = (list(x) for x in (rows.position, rows.velocity, rows.acceleration, rows.wind, rows.mean))
    return ["TwrBsFxt", "TwrBsFyt", "TwrBsMyt", "TwrBsMxt"], ["N", "N", "N m", "N m"], *lists


def _tensions(system: System, mean: Equilibrium) -> tuple[list, ...]:
    state, q = mean.mooring, len(system.dofs)
    lines = state.fairlead_tension.shape[-1]
    gradient = np.zeros((lines, q))
    for k, dof in enumerate(PLATFORM_DOFS):
        if dof in system.dofs:
            gradient[:, system.dofs.index(dof)] = state.tension_gradient[:, k]
    names = [f"T[{k + 1}]" for k in range(lines)]
    level = [float(t) for t in state.fairlead_tension]
    return names, ["N"] * lines, [list(r) for r in gradient], _blank(lines, q), _blank(lines, q), _blank(lines, 3), level
