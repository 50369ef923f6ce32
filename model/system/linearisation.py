"""One linearised model as a simulation code wrote it: x' = A x + B u, y = C x + D u, with names and operating point."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from model.conventions import freeze


@dataclass(frozen=True, eq=False, kw_only=True)
class Linearisation:
    """One linearisation record, units as written (states SI, outputs as named).

    A (x, x), B (x, u), C (y, x), D (y, u); the names, operating points and rotating-frame flags of states, inputs
    and outputs; derivative order of the states (2 for positions and velocities, 1 for first-order states);
    azimuth [rad], rotor_speed [rad/s], wind_speed [m/s]; modules that were linked; source names the file.
    state_dof names the degree of freedom of each state ("" when it has none), state_rate is 1 for velocities.
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray
    state_names: tuple[str, ...]
    input_names: tuple[str, ...]
    output_names: tuple[str, ...]
    state_point: np.ndarray
    input_point: tuple
    output_point: tuple
    state_rotating: np.ndarray
    input_rotating: np.ndarray
    output_rotating: np.ndarray
    state_order: np.ndarray
    state_dof: tuple[str, ...]
    state_rate: np.ndarray
    azimuth: float = 0.0
    rotor_speed: float = 0.0
    wind_speed: float = 0.0
    modules: tuple[str, ...] = ()
    source: str = ""
    jacobians: dict = field(default_factory=dict)

    def __post_init__(self):
        freeze(
            self, A=("x", "x"), B=("x", "u"), C=("y", "x"), D=("y", "u"), state_point=("x",), state_rotating=("x",),
            input_rotating=("u",), output_rotating=("y",), state_order=("x",), state_rate=("x",),
        )  # fmt: skip
        counts = (len(self.state_names), len(self.input_names), len(self.output_names))
        if counts != (self.A.shape[0], self.B.shape[1], self.C.shape[0]):
            raise ValueError(f"{counts} names of states, inputs, outputs do not fit A, B, C")
