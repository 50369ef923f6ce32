"""Quadratic drag itself, against integrated equations of motion and the linear limit."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from model.environment.sea import SeaState
from model.response.assemble import equilibrium
from model.response.loads import linear_outputs
from model.response.mean_shift import mooring_shift
from model.response.nonlinear import record_channels, record_model, record_response, solve_record
from model.response.solve import excitation
from model.system.drag import no_drag
from model.system.mooring import mooring_state

MASS, STIFFNESS, LINEAR, PUSH, FACTOR = 2.0e6, 8.0e4, 1.2e4, 3.0e4, 4.0e4
STEP, COUNT = 0.5, 2000


@pytest.fixture(scope="module")
def body(simple_body, plate):
    """A body that heaves on a spring with one plate so deep that the water there is at rest."""
    big = np.diag([1e12, 1e12, MASS, 1e15, 1e15, 1e15])
    return simple_body(mass=big, stiffness=np.diag([1e12, 1e12, STIFFNESS, 1e15, 1e15, 1e15]), damping=np.diag([0, 0, LINEAR, 0, 0, 0.0]),
                       excitation=[0, 0, PUSH, 0, 0, 0], drag=plate(FACTOR, position=(0.0, 0.0, -5000.0)))  # fmt: skip


def drive():
    return excitation(
        np.linspace(0.02, 3.0, 300), SeaState(kind="white_noise", significant_height=2.0, band=(0.01, 0.2)), None
    )


def waves(amplitude, omega):
    count = round(omega * COUNT * STEP / (2 * np.pi))
    time = np.arange(COUNT) * STEP
    return amplitude * np.cos(2 * np.pi * count / (COUNT * STEP) * time), 2 * np.pi * count / (COUNT * STEP)


def heave(body, elevation):
    mean = equilibrium(body)
    found = record_response(body, mean, elevation, STEP, drive())
    return record_channels(linear_outputs(body, mean, None), found, ["PtfmHeave"])[:, 0], found


@pytest.mark.parametrize("frequency", [0.12, 0.2, 0.35])
def test_regular_waves_against_time_integration(body, frequency):
    """Below, at and above resonance; 1 %: samples every 0.5 s alias the drag's seventh harmonic and above."""
    elevation, omega = waves(2.0, frequency)
    ours, _ = heave(body, elevation)

    def rates(t, y):
        return [
            y[1],
            (2.0 * PUSH * np.cos(omega * t) - LINEAR * y[1] - FACTOR * abs(y[1]) * y[1] - STIFFNESS * y[0]) / MASS,
        ]

    period = COUNT * STEP
    settled = solve_ivp(
        rates, (0, 2 * period), [0.0, 0.0], t_eval=period + np.arange(COUNT) * STEP, rtol=1e-8, atol=1e-8
    ).y[0]
    assert np.abs(ours - settled).max() < 0.01 * np.abs(settled).max()


def test_without_drag_it_is_the_linear_response(body):
    elevation, omega = waves(2.0, 0.3)
    free = replace(body, drag=no_drag())
    ours, found = heave(free, elevation)
    expected = 2.0 * PUSH / abs(STIFFNESS - omega**2 * MASS + 1j * omega * LINEAR)
    assert np.abs(ours).max() == pytest.approx(expected, rel=1e-3)
    assert found.iterations <= 2


def test_a_start_from_the_answer_is_the_answer(body):
    """Prepared once for many records; from the solution the iteration ends at once."""
    mean = equilibrium(body)
    ready = record_model(body, mean, COUNT, STEP, 0.0, np.zeros((6, 6)) + np.diag([0, 0, 3e4, 0, 0, 0]))
    elevation, _ = waves(2.0, 0.2)
    first = solve_record(ready, elevation)
    again = solve_record(ready, elevation, start=first.amplitude)
    assert again.iterations == 1
    assert np.allclose(first.amplitude, again.amplitude, rtol=1e-3, atol=1e-4 * np.abs(first.amplitude).max())
    with pytest.raises(ValueError, match="ready for 2000 samples, the record has 100"):
        solve_record(ready, elevation[:100])


def test_moorings_of_a_moving_floater_pull_harder(oc4):
    """Mean mooring force and tension over 4000 Gaussian positions, less those at rest: 10 % (the fourth derivative, and the sample's scatter)."""
    point = oc4.at(11.0)
    covariance = np.zeros((7, 7))
    covariance[:6, :6] = np.diag([2.0, 0.6, 0.09, 2.6e-3, 1.1e-2, 2.1e-2]) ** 2
    shift, pulled = mooring_shift(point.system, point.mean, covariance)
    moves = np.random.default_rng(5).normal(size=(2000, 6)) * np.sqrt(np.diag(covariance)[:6])
    moves = np.concatenate([moves, -moves])
    states = [mooring_state(point.system.mooring, point.mean.offset[:6] + s * x) for x in moves[::4] for s in (-1, 1)]
    forces, tensions = (np.mean([getattr(m, n) for m in states], axis=0) for n in ("force", "fairlead_tension"))
    assert shift[0] == pytest.approx(forces[0] - point.mean.mooring.force[0], rel=0.1)
    assert np.allclose(pulled, tensions - point.mean.mooring.fairlead_tension, rtol=0.1)
    assert shift[0] < -5e3
    assert shift[6] == 0.0
