"""Radiation as a time-domain code has it: a memory kernel of finite length, convolved in steps.

The kernel follows from the damping, K(t) = 2/pi integral B cos(omega t) (Ogilvie 1964), on the frequencies pi/T that a kernel of
length T needs; its transform back gives the added mass and damping that the time-domain code works with, which agree with
the data only as far as the data agree with each other (Kramers and Kronig) and the kernel is long enough.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from model.system.hydro import HydroCoefficients, excitation_at, infinite_added_mass, radiation_at

HYDRODYN_LAG = 1.5  # steps by which the memory force of OpenFAST 5's HydroDyn comes late; docs/validation.md shows how it was found


def memory_kernel(hydro: HydroCoefficients, length: float, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Return times (k) [s] and the radiation kernel (k, 6, 6) of a length [s] in steps [s]; data above the highest frequency count as zero."""
    if not 0 < step < length:
        raise ValueError(f"a kernel of {length:g} s cannot have steps of {step:g} s; it needs 0 < step < length")
    spacing = np.pi / length
    omega = np.arange(0, int(hydro.omega[-1] / spacing) + 1) * spacing
    damping = radiation_at(hydro, np.maximum(omega, 1e-9))[1].reshape(len(omega), 36)
    time = np.arange(0, round(length / step) + 1) * step
    weight = np.full(len(omega), spacing)
    weight[0] /= 2
    return time, (2 / np.pi * np.cos(np.outer(time, omega)) @ (weight[:, None] * damping)).reshape(-1, 6, 6)


def convolved_radiation(
    hydro: HydroCoefficients, length: float, step: float, lag: float = HYDRODYN_LAG, count: int = 600
) -> HydroCoefficients:
    """Return coefficients whose added mass and damping are those of a convolution in the time domain.

    length and step [s] of the kernel; lag, by how many steps the force comes late; count, how many frequencies up to the highest
    of the data. Excitation and everything else stay as they are. Raises ValueError for a step that is not below the length.
    """
    time, kernel = memory_kernel(hydro, length, step)
    omega = np.linspace(hydro.omega[0] / 5, hydro.omega[-1], count)
    weight = np.full(len(time), step)
    weight[[0, -1]] /= 2
    memory = np.exp(-1j * np.outer(omega, time + lag * step)) @ (weight[:, None] * kernel.reshape(-1, 36))
    added = (memory.imag / omega[:, None]).reshape(-1, 6, 6) + infinite_added_mass(hydro)
    return replace(
        hydro, omega=omega, added_mass=added, radiation_damping=memory.real.reshape(-1, 6, 6), added_mass_zero=added[0],
        excitation=None if hydro.excitation is None else excitation_at(replace(hydro, members=None), omega, hydro.heading),
    )  # fmt: skip
