"""The direct route: an oscillator in closed form, with a radiation state, and what it refuses."""

import numpy as np
import pytest

from model.response.direct import direct_transfer, wave_input
from model.system.linearisation import Linearisation

M, B, C = 2.0, 0.3, 5.0
WAVE = "HD Extended input: wave elevation at platform ref point, m"


def record(inputs=(WAVE,), b=None):
    """An oscillator whose damping force follows a first-order lag of its velocity (a radiation state, pole -0.8)."""
    a = [[0, 1, 0], [-C / M, -B / M, -1 / M], [0, 0.5, -0.8]]
    b = [[0], [1 / M], [0]] if b is None else b
    return Linearisation(
        A=a, B=b, C=[[57.29577951308232, 0, 0]], D=[[0]], state_names=("x", "v", "r"), input_names=inputs, output_names=("ED PtfmPitch, (deg)",),
        state_point=[0, 0, 0], input_point=(0.0,), output_point=(0.0,), state_rotating=[0, 0, 0], input_rotating=[0], output_rotating=[0],
        state_order=[2, 2, 1], state_dof=("pitch", "pitch", ""), state_rate=[0, 1, 0], source="a.lin",
    )  # fmt: skip


def test_closed_form():
    omega = np.linspace(0.05, 4, 60)
    found = direct_transfer(record(), omega, wave_input(record()))[:, 0]
    memory = 0.5 / (1j * omega + 0.8)
    expected = 180 / np.pi / (-(omega**2) * M + 1j * omega * (B + memory) + C)
    np.testing.assert_allclose(found, expected, rtol=1e-10)


def test_a_record_without_waves_is_refused():
    with pytest.raises(ValueError, match="no wave-elevation input"):
        wave_input(record(inputs=("ED Platform X force, node 1, N",)))
    with pytest.raises(ValueError, match="drives nothing"):
        wave_input(record(b=[[0], [0], [0]]))
