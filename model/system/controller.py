"""Rotor speed as a degree of freedom, and a linear torque and pitch controller closed around it.

The rotor's azimuth beside the nacelle becomes a degree of freedom, `generator_azimuth` [rad, about the shaft, positive as
the rotor turns]: its rate is the deviation of the rotor's speed, and the integral term of a pitch controller is a spring on
it. So the closed loop stays in second-order form and joins any model like a structural mode.
References: Jonkman 2007, section 3.3 (gain-scheduled PI); Larsen and Hanson 2007, J. Phys. Conf. Ser. 75:012073;
Abbas et al. 2022, Wind Energ. Sci. 7:53 (floating feedback).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from model.environment.rotor_wind import rotor_sensitivity
from model.system.aero import RotorDerivatives, RotorFrame, operating_turbine, rotor_frame, spinning_inertia
from model.system.turbine import TurbineMatrices, TurbineStructure

ROTOR_AZIMUTH = "generator_azimuth"
TORQUE_LAWS = ("optimal", "constant_power", "constant_torque")
_LOOSE = 1e-4  # rad/s: natural frequency of the azimuth where nothing brings it back, far below every motion


@dataclass(frozen=True, kw_only=True)
class Controller:
    """A linear controller on the slow shaft, about an operating point.

    pitch_proportional [rad per rad/s] and pitch_integral [rad per rad] of the rotor's speed deviation; platform_feedback [rad per
    m/s]: pitch to feather per downwind velocity of the hub along the shaft, positive adds damping; torque_slope
    [N m per rad/s]: generator torque, on the slow shaft, by rotor speed.
    """

    pitch_proportional: float = 0.0
    pitch_integral: float = 0.0
    platform_feedback: float = 0.0
    torque_slope: float = 0.0


def torque_slope(law: str, rotor: RotorDerivatives) -> float:
    """Return the slope of generator torque by rotor speed [N m per rad/s, slow shaft] of a torque law at an operating point.

    "optimal": torque as the square of speed; "constant_power": as its inverse; "constant_torque": zero. Generator torque
    equals the aerodynamic one there. Raises ValueError for another law.
    """
    if law not in TORQUE_LAWS:
        raise ValueError(f"torque law {law!r} is none of {', '.join(TORQUE_LAWS)}")
    order = {"optimal": 2.0, "constant_power": -1.0, "constant_torque": 0.0}[law]
    return order * rotor.torque / rotor.rotor_speed


def pitch_gains(
    rotor: RotorDerivatives, inertia: float, frequency: float, damping_ratio: float, *, slope: float = 0.0
) -> tuple[float, float]:
    """Return proportional and integral gain that give the rotor's speed loop a natural frequency and damping ratio.

    inertia [kg m2] of rotor and generator on the slow shaft; frequency [rad/s]; slope [N m per rad/s] of the generator
    torque. The platform is taken as fixed. Reference: Jonkman 2007, equations 3-8 to 3-12. Raises ValueError where pitch does
    not reduce torque.
    """
    if rotor.torque_pitch >= 0:
        raise ValueError(
            f"torque does not fall with pitch (dQ/dtheta = {rotor.torque_pitch:.4g} N m/rad): pitch control works above rated wind"
        )
    power = -rotor.torque_pitch
    return (
        2 * damping_ratio * frequency * inertia + rotor.torque_speed - slope
    ) / power, frequency**2 * inertia / power


def close_loop(
    turbine: TurbineMatrices,
    frame: RotorFrame,
    rotor: RotorDerivatives,
    controller: Controller,
    inertia: float,
    generator_inertia: float = 0.0,
) -> TurbineMatrices:
    """Return a turbine with the rotor's azimuth as last degree of freedom and a controller closed around its speed.

    turbine and frame at the operating point with fixed speed and pitch; inertia [kg m2] of hub and blades about the shaft, which
    the turbine's mass holds as if locked; generator_inertia [kg m2] on the slow shaft (gear ratio squared times its own), turning
    against the nacelle. Without an integral gain nothing but the speed matters: the azimuth has a spring of no
    consequence, so that a mean offset exists.
    """
    t, r = frame.thrust_row, frame.torque_row
    q = len(r)
    if len(turbine.dofs) != q:
        raise ValueError(
            f"the rotor frame has {q} degrees of freedom, the turbine {len(turbine.dofs)}: use the same tower modes"
        )
    spin = np.append(r, 1.0)
    wide_t = np.append(t, 0.0)
    load_pitch = rotor.thrust_pitch * wide_t + rotor.torque_pitch * spin
    pitch_rate = controller.pitch_proportional * _unit(q + 1) + controller.platform_feedback * wide_t
    mass, damping, stiffness = (_widen(m) for m in (turbine.mass, turbine.damping, turbine.stiffness))
    mass[:q, q] = mass[q, :q] = inertia * r
    mass[q, q] = inertia + generator_inertia
    by_motion = rotor.torque_wind * t / frame.axis[0] - rotor.torque_speed * r
    damping[q, :q] = by_motion
    damping[:q, q] = -(rotor.thrust_speed * t + rotor.torque_speed * r)
    damping[q, q] = controller.torque_slope - rotor.torque_speed
    damping -= np.outer(load_pitch, pitch_rate)
    if controller.pitch_integral:
        leaning = np.cross(frame.axis, [1.0, 0.0, 0.0]) @ frame.rotation
        stiffness[q, :q] = -rotor.wind_speed / frame.axis[0] * rotor.torque_wind * leaning
        stiffness -= np.outer(load_pitch, controller.pitch_integral * _unit(q + 1))
    else:
        stiffness[q, q] = mass[q, q] * _LOOSE**2
    return replace(
        turbine, dofs=(*turbine.dofs, ROTOR_AZIMUTH), mass=mass, damping=damping, stiffness=stiffness,
        force=np.append(turbine.force, 0.0), point=np.append(turbine.point, 0.0), wind_force=np.append(turbine.wind_force, rotor.torque_wind),
        gradient_force=np.hstack([turbine.gradient_force, np.zeros((2, 1))]), source=f"{turbine.source}, rotor speed free",
    )  # fmt: skip


def controlled_turbine(
    structure: TurbineStructure,
    modes: Sequence[str],
    rotor: RotorDerivatives,
    controller: Controller,
    *,
    generator_inertia: float = 0.0,
    gradient_arm: float | None = None,
) -> TurbineMatrices:
    """Return the turbine at an operating point with free rotor speed and its controller, from deck and rotor table alone.

    As `operating_turbine`, then `close_loop`; generator_inertia [kg m2] on the slow shaft.
    """
    if gradient_arm is None:
        blades = structure.rotor
        gradient_arm = rotor_sensitivity(
            blades.diameter, blades.blades, rotor.rotor_speed, rotor.wind_speed
        ).gradient_arm
    turbine = operating_turbine(structure, modes, rotor, gradient_arm=gradient_arm)
    frame = rotor_frame(structure, modes, turbine.point[6:])
    return close_loop(turbine, frame, rotor, controller, spinning_inertia(structure), generator_inertia)


def rotor_impedance(turbine: TurbineMatrices, omega) -> tuple[np.ndarray, np.ndarray]:
    """Return the dynamic stiffness (n, q, q) and wind force (n, q) with the rotor's speed following, its azimuth eliminated.

    turbine has `generator_azimuth` as last degree of freedom; omega (n) [rad/s]. Its real and imaginary part show what the
    controller does to stiffness and damping at each frequency. Raises ValueError for a turbine without it.
    """
    if turbine.dofs[-1] != ROTOR_AZIMUTH:
        raise ValueError(
            f"the last degree of freedom is {turbine.dofs[-1]!r}, needs {ROTOR_AZIMUTH!r}: close the loop first"
        )
    w = np.asarray(omega, dtype=float)[:, None, None]
    z = turbine.stiffness - w**2 * turbine.mass + 1j * w * turbine.damping
    by_own = z[:, :-1, -1] / z[:, -1, -1, None]
    wind = turbine.wind_force[:-1] - by_own * turbine.wind_force[-1]
    return z[:, :-1, :-1] - by_own[:, :, None] * z[:, -1:, :-1], wind


def _widen(matrix: np.ndarray) -> np.ndarray:
    """Return a matrix with one more row and column of zeros."""
    return np.pad(matrix, ((0, 1), (0, 1)))


def _unit(size: int) -> np.ndarray:
    """Return the unit vector (size) of the last degree of freedom."""
    out = np.zeros(size)
    out[-1] = 1.0
    return out
