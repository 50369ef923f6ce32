"""Small systems with closed-form answers, to be made into FMUs."""

from __future__ import annotations

import numpy as np

from fowtio.fmu.describe import describe
from model.reduce.state_space import StateSpace, modal_form

OMEGA, ZETA, MASS = 0.8, 0.05, 250.0


def oscillator(omega=OMEGA, zeta=ZETA, mass=MASS) -> StateSpace:
    """A mass on a spring and a damper, driven by a force: position, velocity and acceleration."""
    a = np.array([[0.0, 1.0], [-(omega**2), -2 * zeta * omega]])
    b = np.array([[0.0], [1 / mass]])
    return StateSpace(
        a=a, b=b, c=np.vstack([np.eye(2), a[1]]), d=np.array([[0.0], [0.0], [1 / mass]]), mean=np.array([2.0, 0.0, 0.0]), inputs=("Force",),
        input_units=("N",), outputs=("Position", "Velocity", "Acceleration"), output_units=("m", "m/s", "m/s^2"), initial=np.eye(2),
        initial_names=("position", "velocity"), initial_units=("m", "m/s"),
    )  # fmt: skip


def absorber(omega=OMEGA, zeta=0.1, mass=10.0) -> StateSpace:
    """A tuned mass on a spring and a damper: base position and velocity in, the force on the base out."""
    k, c = mass * omega**2, 2 * zeta * omega * mass
    a = np.array([[0.0, 1.0], [-k / mass, -c / mass]])
    b = np.array([[0.0, 0.0], [k / mass, c / mass]])
    return StateSpace(
        a=a, b=b, c=np.array([[k, c]]), d=np.array([[-k, -c]]), mean=np.zeros(1), inputs=("BasePosition", "BaseVelocity"),
        input_units=("m", "m/s"), outputs=("BaseForce",), output_units=("N",), initial=np.eye(2), initial_names=("position", "velocity"),
        initial_units=("m", "m/s"),
    )  # fmt: skip


def make(space: StateSpace, identifier: str, **more):
    """Return the description of a space's FMU."""
    return describe(space, modal_form(space), identifier=identifier, **more)
