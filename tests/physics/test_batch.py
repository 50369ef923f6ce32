"""Many states at once give what one by one gives; the elimination solves what LAPACK solves."""

import numpy as np
import pytest

from model.environment.sea import SeaState, wave_spectrum
from model.environment.wind import WindState
from model.response.batch import batch_std, eliminate, solve_many
from model.response.drag_iteration import drag_problem
from model.response.loads import channel_response, response_spectra
from model.response.solve import excitation, prepare, solve
from model.response.statistics import statistics
from model.system.drag import no_drag


@pytest.mark.parametrize("speed", [0.0, 11.0])
def test_batch_equals_single_states(oc4, speed):
    """Both iterate drag to 1e-3 of its largest coefficient from different starts; responses then agree to a few 1e-4."""
    point, heading = oc4.at(speed), np.array([0.0])
    seas = [SeaState(kind="jonswap", significant_height=h, peak_period=t, gamma=2.0) for h, t in ((1.0, 7.0), (4.0, 10.0), (9.0, 14.0))]
    wind = None if speed == 0 else WindState(mean_speed=speed, turbulence_class="B", hub_height=90.0, rotor_diameter=126.0)
    grid = prepare(point.system, oc4.omega, heading)
    drives = [excitation(oc4.omega, sea, wind, rotor=point.rotor) for sea in seas]
    waves = np.stack([d.wave_spectrum for d in drives])
    winds = {} if wind is None else {
        "wind_spectrum": np.stack([d.wind_spectrum for d in drives]), "gradient_spectrum": np.stack([d.gradient_spectrum for d in drives]),
    }  # fmt: skip
    std = batch_std(point.outputs, solve_many(point.system, point.mean, grid, waves, **winds, workers=1))
    for k, drive in enumerate(drives):
        channels = channel_response(point.outputs, one := solve(point.system, point.mean, drive, grid=grid))
        expected = statistics(response_spectra(channels, one), oc4.omega, channels.mean).std
        np.testing.assert_allclose(std[k], expected, rtol=2e-3, atol=1e-6 * np.abs(expected).max())


def test_threads_change_nothing(oc4):
    point = oc4.at(0.0)
    spectra = np.stack([
        wave_spectrum(SeaState(kind="jonswap", significant_height=h, peak_period=10.0, gamma=1.0), oc4.omega) for h in np.linspace(1, 8, 70)
    ])[:, None]  # fmt: skip
    grid = prepare(point.system, oc4.omega, np.array([0.0]))
    one, two = (solve_many(point.system, point.mean, grid, spectra, workers=w).to_wave for w in (1, 2))
    np.testing.assert_allclose(two, one, rtol=2e-3, atol=1e-3 * np.abs(one).max())  # groups of states stop iterating together


def _random_problem(rng, n, q):
    problem = drag_problem(
        no_drag(), np.zeros((0, 2, 3)), np.zeros((1, 0, n)), rng.uniform(0.1, 2, n), list(range(min(q, 6))), np.ones((3, 1, n)),
        np.zeros((3, 3, n)), np.zeros((6, 6)), "relative",
    )  # fmt: skip
    return problem


@pytest.mark.parametrize("q", [1, 3, 6, 8])
def test_elimination_equals_lapack(q):
    rng = np.random.default_rng(q)
    n, states, r = 50, 3, 2
    here = list(range(min(q, 6)))
    problem = _random_problem(rng, n, q)
    matrices = rng.standard_normal((n, q, q)) + 1j * rng.standard_normal((n, q, q)) + 4 * q * np.eye(q)
    force = rng.standard_normal((1, n, q, r)) + 0j
    damping = rng.standard_normal((states, 6, 6))
    found = eliminate(problem, matrices, damping, force, None, here)
    for s in range(states):
        full = matrices.copy()
        full[:, : len(here), : len(here)] += 1j * problem.omega[:, None, None] * damping[s][: len(here), : len(here)]
        np.testing.assert_allclose(found[s], np.linalg.solve(full, force[0]), rtol=1e-8)


def test_elimination_falls_back_where_a_pivot_vanishes():
    """A matrix that needs pivoting (zero on the diagonal) is solved again with it."""
    rng = np.random.default_rng(1)
    problem = _random_problem(rng, 4, 2)
    matrices = np.tile(np.array([[0, 1.0], [2.0, 0]], dtype=complex), (4, 1, 1))
    force = np.ones((1, 4, 2, 1), dtype=complex)
    found = eliminate(problem, matrices, np.zeros((3, 6, 6)), force, None, [0, 1])
    np.testing.assert_allclose(found[0, :, :, 0], np.tile([0.5, 1.0], (4, 1)), rtol=1e-12)
