"""What a linear model lacks is found when it is known."""

import numpy as np
import pytest

from model.response.equivalent import missing_terms

OMEGA = 2 * np.pi * np.arange(1, 2001) * 1e-4
M = np.array([[2.0e7, -1.0e8], [-1.0e8, 1.6e10]])
B = np.diag([1.0e5, 2.4e8])
C = np.diag([7.0e4, 1.0e9])
FORCE = np.array([1.0e6, 3.0e7])


def dynamic(damping, stiffness):
    w = OMEGA[:, None, None]
    return -(w**2) * M + 1j * w * damping + stiffness


def spectra(damping, stiffness):
    x = np.linalg.solve(dynamic(damping, stiffness), np.broadcast_to(FORCE, (len(OMEGA), 2))[..., None])
    return x, np.abs(x[..., 0]) ** 2


def fit(reference, smoothing):
    x, _ = spectra(B, C)
    critical = 2 * np.sqrt(np.diag(C) * np.diag(M))
    return missing_terms(
        ("surge", "pitch"),
        [0, 1],
        OMEGA,
        dynamic(B, C),
        x,
        np.ones((len(OMEGA), 1)),
        smoothing,
        smoothing @ reference,
        critical,
        np.diag(C),
    )


@pytest.fixture(scope="module")
def smoothing():
    """A moving average over 1 mHz at every fifth frequency."""
    out = np.zeros((380, len(OMEGA)))
    for row in range(380):
        out[row, 5 * row + 25 : 5 * row + 35] = 0.1
    return out


def test_known_terms_come_back(smoothing):
    """Added to both motions; least squares converge to the exact answer when the reference has no noise."""
    added, harder = np.array([5e4, -8e7]), np.array([1.5e3, -2e7])
    _, reference = spectra(B + np.diag(added), C + np.diag(harder))
    found = fit(reference, smoothing)
    assert found.damping == pytest.approx(added, rel=1e-4)
    assert found.stiffness == pytest.approx(harder, rel=1e-4)
    assert np.all(found.error_after < 1e-6)
    assert np.all(found.error_before > 0.01)


def test_a_perfect_model_lacks_nothing(smoothing):
    found = fit(spectra(B, C)[1], smoothing)
    assert np.abs(found.damping / np.diag(B)).max() < 1e-6
    assert np.abs(found.stiffness / np.diag(C)).max() < 1e-6


def test_noise_is_reported_as_a_standard_error(smoothing):
    """15 % noise on each line: within six of its own standard errors (neighbouring averages share half of their lines) and a bias of 1 %
    of the stiffness, since the root of a noisy spectrum is a little low.
    """
    added = np.array([5e4, 8e7])
    _, reference = spectra(B + np.diag(added), C)
    noisy = reference * (1 + 0.15 * np.random.default_rng(3).normal(size=reference.shape))
    found = fit(noisy, smoothing)
    assert np.all(np.abs(found.damping - added) < 6 * found.damping_error)
    assert np.all(found.damping_error < 0.5 * added)
    assert np.all(np.abs(found.stiffness) < 6 * found.stiffness_error + 0.01 * np.diag(C))
