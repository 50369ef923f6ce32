"""Radiation as a convolution, against a kernel whose transforms are known."""

import numpy as np
import pytest

from model.system.convolution import convolved_radiation, memory_kernel
from model.system.hydro import HydroCoefficients

RATE, LEVEL = 0.5, 3e5  # 1/s, N/m: K(t) = LEVEL exp(-RATE t) (1 - RATE t), whose integral is zero as B(0) is


def exact(omega):
    """One-sided transform of the kernel: B + i omega (A - Ainf)."""
    s = 1j * omega + RATE
    return LEVEL * 1j * omega / s**2


@pytest.fixture(scope="module")
def hydro():
    """Data up to 40 rad/s, where the damping has fallen to 1e-3 of its peak."""
    omega = np.linspace(0.02, 40.0, 4000)
    memory = exact(omega)
    unit = np.eye(6)
    return HydroCoefficients(
        omega=omega, radiation_damping=memory.real[:, None, None] * unit, added_mass=(1e6 + memory.imag / omega)[:, None, None] * unit,
        added_mass_infinite=1e6 * unit, added_mass_zero=(1e6 + (exact(1e-6).imag / 1e-6)) * unit, heading=[0.0],
        excitation=np.ones((1, len(omega), 6), dtype=complex),
    )  # fmt: skip


def test_kernel_of_known_damping(hydro):
    """B ends at 40 rad/s with a tail of 2 LEVEL RATE / omega^2: 1.6 % of the kernel's start is left out, less later on."""
    time, kernel = memory_kernel(hydro, 40.0, 0.1)
    wanted = LEVEL * np.exp(-RATE * time) * (1 - RATE * time)
    assert np.abs(kernel[5:, 2, 2] - wanted[5:]).max() < 0.01 * LEVEL
    assert np.abs(kernel[:, 0, 1]).max() == 0.0


def test_long_and_fine_without_lag_gives_the_data_back(hydro):
    """Step 0.02 s: the trapezoidal sum is off by (omega step)^2 / 12."""
    found = convolved_radiation(hydro, 40.0, 0.02, lag=0.0)
    low = found.omega < 2.0
    memory = exact(found.omega[low])
    assert found.radiation_damping[low, 2, 2] == pytest.approx(memory.real, abs=0.01 * memory.real.max())
    assert found.added_mass[low, 2, 2] - 1e6 == pytest.approx(memory.imag / found.omega[low], abs=0.02 * 1e6)


def test_lag_turns_the_memory_force(hydro):
    """Late by n steps: the memory's transform times exp(-i omega n step), exactly."""
    early, late = (convolved_radiation(hydro, 40.0, 0.05, lag=n) for n in (0.0, 1.5))
    for case, other in ((late, early),):
        w = case.omega
        a = case.radiation_damping[:, 4, 4] + 1j * w * (case.added_mass[:, 4, 4] - 1e6)
        b = other.radiation_damping[:, 4, 4] + 1j * w * (other.added_mass[:, 4, 4] - 1e6)
        assert a == pytest.approx(b * np.exp(-1j * w * 0.075), rel=1e-9)


def test_excitation_stays(hydro):
    found = convolved_radiation(hydro, 40.0, 0.05)
    assert np.allclose(found.excitation, 1.0)


def test_a_step_as_long_as_the_kernel_is_refused(hydro):
    with pytest.raises(ValueError, match="0 < step < length"):
        memory_kernel(hydro, 1.0, 2.0)
