"""The turning rotor from its performance table: thrust and torque derivatives, and the turbine's matrices with them.

Quasi-steady: thrust and torque follow the wind, rotor speed and blade pitch of the moment, as a table of
coefficients over tip speed ratio and pitch gives them (an equilibrium wake). Thrust and torque act at the hub along the
tilted shaft and turn with it. References: Jonkman 2007, section 2; Bossanyi 2000, Wind Energy 3:149 (derivatives);
the gyroscopic moment is omega x H.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.interpolate import RectBivariateSpline

from model.conventions import freeze, point_motion, rotation, skew
from model.environment.rotor_wind import rotor_sensitivity
from model.system.tower import TowerModes, tower_modes
from model.system.turbine import TurbineMatrices, TurbineStructure, structural_matrices


@dataclass(frozen=True, eq=False, kw_only=True)
class RotorPerformance:
    """A rotor's coefficients: pitch (p) [rad] and tip_speed_ratio (t) [-] ascending; power and thrust coefficient (t, p) [-];
    radius [m] and air_density [kg/m3] by which they are made dimensional; source.
    """

    pitch: np.ndarray
    tip_speed_ratio: np.ndarray
    power: np.ndarray
    thrust: np.ndarray
    radius: float
    air_density: float = 1.225
    source: str = ""

    def __post_init__(self):
        freeze(self, pitch=("p",), tip_speed_ratio=("t",), power=("t", "p"), thrust=("t", "p"))
        if min(len(self.pitch), len(self.tip_speed_ratio)) < 4:
            raise ValueError(
                f"a rotor table needs 4 pitch angles and 4 tip speed ratios or more, not {self.power.shape[::-1]}"
            )
        if self.radius <= 0 or self.air_density <= 0:
            raise ValueError(f"radius {self.radius:g} m and air density {self.air_density:g} kg/m3 must be positive")

    @cached_property
    def thrust_spline(self) -> RectBivariateSpline:
        """Bicubic spline of the thrust coefficient over (tip speed ratio, pitch)."""
        return RectBivariateSpline(self.tip_speed_ratio, self.pitch, self.thrust)

    @cached_property
    def torque_spline(self) -> RectBivariateSpline:
        """Bicubic spline of the torque coefficient, power coefficient over tip speed ratio."""
        return RectBivariateSpline(self.tip_speed_ratio, self.pitch, self.power / self.tip_speed_ratio[:, None])

    @property
    def pressure_area(self) -> float:
        """Half air density times disk area [kg/m]: times wind squared and a coefficient it is a force."""
        return self.air_density * np.pi * self.radius**2 / 2


@dataclass(frozen=True, eq=False, kw_only=True)
class RotorDerivatives:
    """Thrust [N] and torque [N m] on the rotor at an operating point and their derivatives.

    wind_speed [m/s], rotor_speed [rad/s], pitch [rad]; by wind (_wind) per m/s, by rotor speed (_speed) per rad/s, by
    blade pitch (_pitch) per rad. The wind is the horizontal one at the hub.
    """

    wind_speed: float
    rotor_speed: float
    pitch: float
    thrust: float
    torque: float
    thrust_wind: float
    thrust_speed: float
    thrust_pitch: float
    torque_wind: float
    torque_speed: float
    torque_pitch: float
    source: str = ""


@dataclass(frozen=True, eq=False, kw_only=True)
class OperatingSchedule:
    """Operating points over wind_speed (n) [m/s]: rotor_speed (n) [rad/s], pitch (n) [rad], aerodynamic power (n) [W] and
    thrust (n) [N].
    """

    wind_speed: np.ndarray
    rotor_speed: np.ndarray
    pitch: np.ndarray
    power: np.ndarray
    thrust: np.ndarray

    def __post_init__(self):
        freeze(self, wind_speed=("n",), rotor_speed=("n",), pitch=("n",), power=("n",), thrust=("n",))


@dataclass(frozen=True, eq=False, kw_only=True)
class RotorFrame:
    """The hub in a turbine's degrees of freedom (q): axis (3), unit vector along the shaft downwind; hub (3) [m] from the reference
    point; translation and rotation (3, q) of the hub per unit of each; arm (3) from the tower top to the hub.
    """

    axis: np.ndarray
    hub: np.ndarray
    arm: np.ndarray
    translation: np.ndarray
    rotation: np.ndarray

    def __post_init__(self):
        freeze(self, axis=(3,), hub=(3,), arm=(3,), translation=(3, "q"), rotation=(3, "q"))

    @property
    def thrust_row(self) -> np.ndarray:
        """Motion (q) of the hub along the shaft: the generalised force of a unit thrust."""
        return self.axis @ self.translation

    @property
    def torque_row(self) -> np.ndarray:
        """Rotation (q) of the nacelle about the shaft: the generalised force of a unit torque on the rotor."""
        return self.axis @ self.rotation

    @property
    def motion(self) -> np.ndarray:
        """Translation and rotation (6, q): its transpose turns hub force and moment into generalised forces."""
        return np.vstack([self.translation, self.rotation])


def rotor_performance(table, radius: float, air_density: float, wind_speed: float | None = None) -> RotorPerformance:
    """Return the coefficients of a table with power and thrust (w, t, p) over wind_speed (w), at one of its wind speeds.

    radius [m] of the rotor's disk; air_density [kg/m3]; wind_speed [m/s] picks the nearest block, by default the first.
    """
    speeds = np.asarray(table.wind_speed, dtype=float)
    k = 0 if wind_speed is None else int(np.argmin(np.abs(speeds - wind_speed)))
    return RotorPerformance(
        pitch=table.pitch, tip_speed_ratio=table.tip_speed_ratio, power=table.power[k], thrust=table.thrust[k], radius=radius,
        air_density=air_density, source=table.source,
    )  # fmt: skip


def rotor_derivatives(rotor: RotorPerformance, wind_speed: float, rotor_speed: float, pitch: float) -> RotorDerivatives:
    """Return thrust, torque and their derivatives at an operating point, by bicubic splines through the table.

    wind_speed [m/s] at the hub; rotor_speed [rad/s]; pitch [rad]. Raises ValueError outside the table.
    """
    if wind_speed <= 0 or rotor_speed <= 0:
        raise ValueError(
            f"the rotor turns in wind: wind speed {wind_speed:g} m/s and rotor speed {rotor_speed:g} rad/s must be positive"
        )
    ratio = rotor_speed * rotor.radius / wind_speed
    _inside("tip speed ratio", ratio, rotor.tip_speed_ratio, 1.0, "")
    _inside("blade pitch", pitch, rotor.pitch, 180 / np.pi, " deg")
    force, r, u = rotor.pressure_area * wind_speed**2, rotor.radius, wind_speed
    out = {}
    for name, spline, scale in (("thrust", rotor.thrust_spline, force), ("torque", rotor.torque_spline, force * r)):
        c, by_ratio, by_pitch = (float(spline.ev(ratio, pitch, dx, dy)) for dx, dy in ((0, 0), (1, 0), (0, 1)))
        out[name] = scale * c
        out[f"{name}_wind"] = scale / u * (2 * c - ratio * by_ratio)
        out[f"{name}_speed"] = scale * by_ratio * r / u
        out[f"{name}_pitch"] = scale * by_pitch
    return RotorDerivatives(wind_speed=wind_speed, rotor_speed=rotor_speed, pitch=pitch, source=rotor.source, **out)


def operating_schedule(
    rotor: RotorPerformance,
    wind_speed,
    *,
    rated_power: float,
    rated_speed: float,
    minimum_speed: float = 0.0,
    fine_pitch: float | None = None,
) -> OperatingSchedule:
    """Return rotor speed and pitch over wind speeds (n) [m/s]: best tip speed ratio below rated, constant power above.

    rated_power [W] of the rotor (electrical power over all efficiencies); rated_speed and minimum_speed [rad/s]; fine_pitch
    [rad], by default that of the table's largest power coefficient. Pitch is fine below rated, at the minimum speed the one of
    most power; where that exceeds the rated power, pitch goes towards feather until power is the rated one. Raises
    ValueError when a wind speed leads outside the table or its pitch cannot hold the power.
    """
    wind = np.atleast_1d(np.asarray(wind_speed, dtype=float))
    best, fine = _best_point(rotor, fine_pitch)
    speed = np.clip(best * wind / rotor.radius, minimum_speed, rated_speed)
    ratio = speed * rotor.radius / wind
    for value in (ratio.min(), ratio.max()):
        _inside("tip speed ratio", value, rotor.tip_speed_ratio, 1.0, "")
    pitch = np.linspace(fine, rotor.pitch[-1], 4001)
    power = rotor.pressure_area * wind[:, None] ** 3 * ratio[:, None] * rotor.torque_spline.ev(ratio[:, None], pitch)
    start = np.where(best * wind / rotor.radius < minimum_speed, np.argmax(power, axis=1), 0)
    beyond = np.arange(len(pitch)) >= start[:, None]
    too_much = power[np.arange(len(wind)), start] > rated_power
    first = np.argmax(beyond & (power <= rated_power), axis=1)
    if np.any(too_much & (first == 0)):
        bad = wind[too_much & (first == 0)][0]
        raise ValueError(
            f"no pitch up to {np.degrees(rotor.pitch[-1]):g} deg holds {rated_power / 1e6:g} MW at {bad:g} m/s"
        )
    chosen = np.where(too_much, _crossing(power, pitch, first, rated_power), pitch[start])
    area, ratio_torque = rotor.pressure_area, ratio * rotor.torque_spline.ev(ratio, chosen)
    return OperatingSchedule(
        wind_speed=wind, rotor_speed=speed, pitch=chosen, power=area * wind**3 * ratio_torque,
        thrust=area * wind**2 * rotor.thrust_spline.ev(ratio, chosen),
    )  # fmt: skip


def spinning_inertia(structure: TurbineStructure) -> float:
    """Return the inertia of hub and blades about the shaft [kg m2]."""
    rotor = structure.rotor
    return float(rotor.hub_inertia + rotor.blades * rotor.node_mass @ (rotor.node_radius * np.cos(rotor.cone)) ** 2)


def rotor_frame(structure: TurbineStructure, modes: Sequence[str], deflection) -> RotorFrame:
    """Return the hub's place and motion with the tower bent by `deflection` (k) [m] of the named modes, the platform at rest."""
    shapes, fore_aft, turn = _modes(structure, modes)
    deflection = np.asarray(deflection, dtype=float)
    bent = rotation(turn @ deflection)
    tilt = structure.rotor.tilt
    axis, arm = bent @ [np.cos(tilt), 0.0, np.sin(tilt)], bent @ structure.rotor.apex
    top = _top_motion(shapes, fore_aft, deflection)
    sink = deflection @ shapes.top_shortening @ deflection / 2
    hub = arm + [deflection[fore_aft].sum(), deflection[~fore_aft].sum(), structure.tower.top_height - sink]
    return RotorFrame(
        axis=axis, hub=hub, arm=arm,
        translation=np.hstack([point_motion(hub), top + np.cross(turn, arm[:, None], axis=0)]),
        rotation=np.hstack([np.zeros((3, 3)), np.eye(3), turn]),
    )  # fmt: skip


def hub_sensitivity(
    frame: RotorFrame, rotor: RotorDerivatives, gradient_arm: float, radius: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return hub force and moment per wind at the hub (6, 3) and per rotation rate of the nacelle (6, 3), in the nacelle's frame.

    Summed over three or more equal blades whose elements answer their own axial and tangential wind: collective axial wind
    and rotor speed give thrust and torque; wind along the disk gives a moment of half of dT/dOmega about its own
    direction and a force along it; a tilt or yaw rate makes a gradient of axial wind, damped by gradient_arm [m2] times
    dT/dU, and a force of half of dQ/dU. The force along the disk is -dQ/dOmega / (2 r2) with r2 = radius2 / 3,
    drag spread evenly along the blades: the one assumption that the table does not bear out.
    """
    n = frame.axis
    along, across = np.outer(n, n), np.eye(3) - np.outer(n, n)
    side = -rotor.torque_speed / (2 * radius**2 / 3)
    by_wind = np.vstack([
        rotor.thrust_wind / n[0] * along + side * across,
        rotor.torque_wind / n[0] * along + rotor.thrust_speed / 2 * across,
    ])  # fmt: skip
    by_rate = np.vstack([
        rotor.thrust_speed * along + rotor.torque_wind / 2 * across,
        rotor.torque_speed * along - gradient_arm * rotor.thrust_wind * across,
    ])  # fmt: skip
    return by_wind, by_rate


def gradient_sensitivity(frame: RotorFrame, rotor: RotorDerivatives, gradient_arm: float) -> np.ndarray:
    """Return hub force and moment (6, 3) per gradient vector [(m/s)/m] of the axial wind over the disk, as `hub_sensitivity`."""
    n = skew(frame.axis)
    return np.vstack([rotor.torque_wind / 2 * n, -gradient_arm * rotor.thrust_wind * n])


def gyroscopic_matrix(frame: RotorFrame, momentum: float) -> np.ndarray:
    """Return the gyroscopic matrix (q, q), antisymmetric, of an angular momentum [kg m2/s] along the shaft."""
    return -frame.rotation.T @ skew(momentum * frame.axis) @ frame.rotation


def follower_stiffness(
    structure: TurbineStructure, modes: Sequence[str], frame: RotorFrame, rotor: RotorDerivatives
) -> np.ndarray:
    """Return the stiffness (q, q) of mean thrust and torque that turn with the nacelle.

    Forces are in space, moments about the moving reference point, as in a linearisation: heave by pitch is +T, sway
    by yaw -T.
    """
    shapes, _, turn = _modes(structure, modes)
    thrust, torque = rotor.thrust * frame.axis, rotor.torque * frame.axis
    moment = np.cross(frame.hub, thrust) + torque
    out = np.zeros((frame.rotation.shape[1],) * 2)
    out[:3, 3:6], out[3:6, 3:6] = skew(thrust), skew(moment)
    turned, twisted = np.cross(turn, thrust[:, None], axis=0), np.cross(turn, torque[:, None], axis=0)
    moved = frame.translation[:, 6:]
    out[:3, 6:] = -turned
    out[3:6, 6:] = -(np.cross(moved, thrust[:, None], axis=0) + np.cross(frame.hub[:, None], turned, axis=0) + twisted)
    bend = np.cross(turn[:, :, None], np.cross(turn, frame.arm[:, None], axis=0)[:, None, :], axis=0)
    second = (bend + bend.swapaxes(1, 2)) / 2
    second[2] -= shapes.top_shortening
    out[6:, 6:] = -(moved.T @ turned + np.einsum("i,ikl->kl", thrust, second) + turn.T @ twisted)
    return out


def operating_turbine(
    structure: TurbineStructure, modes: Sequence[str], rotor: RotorDerivatives, *, gradient_arm: float | None = None
) -> TurbineMatrices:
    """Return the turbine at an operating point from its deck and rotor table: fixed rotor speed and pitch, blades rigid.

    Structure, gravity and structural damping as parked; aerodynamic damping and stiffness, gyroscopic moments, mean thrust
    and torque, wind force. gradient_arm [m2] by default is that of a well-designed blade (`rotor_sensitivity`). The tower
    is bent by weight and thrust; the matrices hold there.
    """
    if gradient_arm is None:
        blades = structure.rotor
        gradient_arm = rotor_sensitivity(
            blades.diameter, blades.blades, rotor.rotor_speed, rotor.wind_speed
        ).gradient_arm
    modes, bent = tuple(modes), np.zeros(len(modes))
    for _ in range(4):  # the deflection changes the matrices by its own slope, about 1e-2, so four steps reach rounding
        turbine = _at_operating_point(structure, modes, rotor, bent, gradient_arm)
        if modes:
            bent = bent + np.linalg.solve(turbine.stiffness[6:, 6:], turbine.force[6:])
    return turbine


def _at_operating_point(structure, modes, rotor: RotorDerivatives, deflection, gradient_arm: float) -> TurbineMatrices:
    """Return the matrices with the tower bent by `deflection` (k) [m]."""
    still = structural_matrices(structure, modes, deflection)
    frame = rotor_frame(structure, modes, deflection)
    by_wind, by_rate = hub_sensitivity(frame, rotor, gradient_arm, structure.rotor.diameter / 2)
    hub = frame.motion
    damping = hub.T @ (by_wind @ frame.translation - by_rate @ frame.rotation)
    damping += gyroscopic_matrix(frame, spinning_inertia(structure) * rotor.rotor_speed)
    leaning = -rotor.wind_speed * hub.T @ by_wind @ skew([1.0, 0.0, 0.0]) @ frame.rotation
    return replace(
        still, damping=still.damping + damping,
        stiffness=still.stiffness + follower_stiffness(structure, modes, frame, rotor) + leaning,
        force=still.force + rotor.thrust * frame.thrust_row + rotor.torque * frame.torque_row,
        wind_force=hub.T @ by_wind[:, 0],
        gradient_force=(hub.T @ gradient_sensitivity(frame, rotor, gradient_arm)[:, [2, 1]]).T,
        wind_speed=rotor.wind_speed, rotor_speed=rotor.rotor_speed,
        source=f"structural data of the deck and rotor table {rotor.source}".strip(),
    )  # fmt: skip


def _modes(structure: TurbineStructure, modes: Sequence[str]) -> tuple[TowerModes, np.ndarray, np.ndarray]:
    """Return the tower modes, which are fore-aft, and the top's rotation (3, k) per unit of each."""
    shapes = tower_modes(structure.tower, tuple(modes))
    fore_aft = np.array([name.startswith("tower_fa") for name in shapes.names], dtype=bool)
    turn = np.zeros((3, len(shapes.names)))
    turn[1, fore_aft], turn[0, ~fore_aft] = shapes.top_slope[fore_aft], -shapes.top_slope[~fore_aft]
    return shapes, fore_aft, turn


def _top_motion(shapes: TowerModes, fore_aft: np.ndarray, deflection: np.ndarray) -> np.ndarray:
    """Return the translation (3, k) of the tower top per unit of each mode, sinking as the axis bends."""
    out = np.zeros((3, len(shapes.names)))
    out[0, fore_aft], out[1, ~fore_aft] = 1.0, 1.0
    out[2] = -shapes.top_shortening @ deflection
    return out


def _best_point(rotor: RotorPerformance, fine_pitch: float | None) -> tuple[float, float]:
    """Return tip speed ratio and pitch of the largest power coefficient, at the fine pitch when it is given."""
    ratio = np.linspace(rotor.tip_speed_ratio[0], rotor.tip_speed_ratio[-1], 600)
    pitch = np.linspace(rotor.pitch[0], rotor.pitch[-1], 600) if fine_pitch is None else np.array([fine_pitch])
    _inside("fine pitch", pitch[0], rotor.pitch, 180 / np.pi, " deg")
    power = ratio[:, None] * rotor.torque_spline(ratio, pitch)
    i, j = np.unravel_index(np.argmax(power), power.shape)
    return float(ratio[i]), float(pitch[j])


def _crossing(power: np.ndarray, pitch: np.ndarray, first: np.ndarray, level: float) -> np.ndarray:
    """Return the pitch (n) where power (n, p) falls to a level, between the places first - 1 and first."""
    rows, before = np.arange(len(first)), np.maximum(first - 1, 0)
    high, low = power[rows, before], power[rows, first]
    share = np.where(high > low, (high - level) / np.where(high > low, high - low, 1.0), 0.0)
    return pitch[before] + share * (pitch[first] - pitch[before])


def _inside(what: str, value: float, grid: np.ndarray, scale: float, unit: str) -> None:
    """Refuse a value outside a table's range."""
    if not grid[0] - 1e-9 <= value <= grid[-1] + 1e-9:
        raise ValueError(
            f"{what} {value * scale:.4g} lies outside the rotor table ({grid[0] * scale:g} to {grid[-1] * scale:g}{unit})"
        )
