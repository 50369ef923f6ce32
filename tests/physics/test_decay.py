"""Free decay against integrated equations of motion, and the model's against closed forms."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from model.response.assemble import equilibrium, natural_modes
from model.response.decay import extremes, free_decay, model_decay

MASS, STIFFNESS = 2.0e6, 8.0e4
OMEGA = np.sqrt(STIFFNESS / MASS)  # 0.2 rad/s


def integrated(linear, quadratic, start, cycles=12, step=0.5):
    """m x'' + b1 x' + b2 |x'| x' + c x = 0 from rest at `start`."""
    time = np.arange(0, cycles * 2 * np.pi / OMEGA, step)

    def rates(_, y):
        return [y[1], -(linear * y[1] + quadratic * abs(y[1]) * y[1] + STIFFNESS * y[0]) / MASS]

    return time, solve_ivp(rates, (0, time[-1]), [start, 0.0], t_eval=time, rtol=1e-9, atol=1e-9).y[0]


@pytest.mark.parametrize(("ratio", "quadratic"), [(0.03, 0.0), (0.0, 4e4), (0.01, 6e4), (0.004, 0.0)])
def test_linear_and_quadratic_damping_come_back(ratio, quadratic):
    """zeta1 is exact; zeta2 = 4 b2 / (3 pi m) holds for slow decay: 3 % where a cycle loses up to a fifth."""
    time, motion = integrated(2 * ratio * MASS * OMEGA, quadratic, 4.0)
    found = free_decay(time, motion + 1.3, 2 * np.pi / OMEGA * 1.02)
    expected = 4 * quadratic / (3 * np.pi * MASS)
    amplitude = abs(found.start)
    assert found.damping(amplitude / 2) == pytest.approx(ratio + expected * amplitude / 2, rel=0.03, abs=1e-4)
    assert found.linear == pytest.approx(ratio, abs=0.1 * expected * amplitude / 2 + 1e-4)
    assert found.period == pytest.approx(2 * np.pi / OMEGA / np.sqrt(1 - ratio**2), rel=2e-3)
    assert found.offset == pytest.approx(1.3, abs=0.01)
    assert found.residual < 1e-3


def test_cycles_show_the_same_damping():
    """Logarithmic decrement of the extremes beside the fit: both see linear damping exactly, sampling at 0.5 s costs 1 %."""
    time, motion = integrated(2 * 0.03 * MASS * OMEGA, 0.0, 4.0)
    found = free_decay(time, motion, 2 * np.pi / OMEGA)
    assert found.cycle_damping == pytest.approx(np.full(len(found.cycle_damping), 0.03), rel=0.05)
    assert found.cycle_period == pytest.approx(np.full(len(found.cycle_period), found.period), rel=0.01)
    assert np.all(np.diff(found.amplitude) < 0)


def test_a_fast_motion_on_top_does_not_make_extremes():
    time, motion = integrated(2 * 0.02 * MASS * OMEGA, 0.0, 4.0)
    where, value = extremes(time, motion + 0.1 * np.sin(2.5 * time), 2 * np.pi / OMEGA)
    assert np.diff(where) == pytest.approx(np.pi / OMEGA, rel=0.15)
    assert np.all(value[:-1] * value[1:] < 0)


def test_nothing_that_decays_is_refused():
    time = np.arange(0, 20, 0.5)
    with pytest.raises(ValueError, match="three extremes"):
        free_decay(time, np.exp(-time / 10), 31.0)


def test_damping_of_the_model_is_that_of_its_plate(simple_body, plate):
    """A body that heaves on a spring with one plate K |v| v: zeta = b1 / (2 m w) + 4 K a / (3 pi m), exactly."""
    factor, damping = 5e4, 1.2e4
    mass = np.diag([1e9, 1e9, MASS, 1e12, 1e12, 1e12])
    stiffness = np.diag([1e9, 1e9, STIFFNESS, 1e12, 1e12, 1e12])
    body = simple_body(mass=mass, stiffness=stiffness, damping=np.diag([0, 0, damping, 0, 0, 0.0]), drag=plate(factor))
    mean = equilibrium(body)
    amplitudes = np.array([0.0, 0.5, 2.0])
    found = model_decay(body, mean, natural_modes(body, mean), "heave", amplitudes)
    expected = damping / (2 * MASS * OMEGA) + 4 * factor * amplitudes / (3 * np.pi * MASS)
    assert found.damping == pytest.approx(expected, rel=1e-6)
    assert found.period == pytest.approx(2 * np.pi / OMEGA / np.sqrt(1 - expected**2), rel=1e-6)
    with pytest.raises(ValueError, match="no mode led by tower_fa1"):
        model_decay(body, mean, natural_modes(body, mean), "tower_fa1", amplitudes)


def test_quadratic_damping_matrix_counts_too(simple_body):
    factor = 5e4
    mass, stiffness = np.diag([1e9, 1e9, MASS, 1e12, 1e12, 1e12]), np.diag([1e9, 1e9, STIFFNESS, 1e12, 1e12, 1e12])
    body = simple_body(mass=mass, stiffness=stiffness, quadratic_damping=np.diag([0, 0, factor, 0, 0, 0.0]))
    mean = equilibrium(body)
    found = model_decay(body, mean, natural_modes(body, mean), "heave", [2.0])
    assert found.damping[0] == pytest.approx(4 * factor * 2.0 / (3 * np.pi * MASS), rel=1e-6)
