"""The wind of a turning rotor: without rotation the averages of wind.py, with it the same energy moved to 3P; sampling by Monte Carlo."""

import numpy as np
import pytest

from model.environment.rotor_wind import RotorSensitivity, rotor_sensitivity, rotor_spectra
from model.environment.wind import WindState, coherence_rate, gradient_spectrum, rotor_averaged_spectrum, wind_spectrum

OMEGA = 2 * np.pi * np.geomspace(1e-3, 1.5, 200)


def wind(**changes):
    values = {"mean_speed": 11.0, "turbulence_class": "B", "hub_height": 90.0, "rotor_diameter": 126.0}
    return WindState(**(values | changes))


def uniform_disk(diameter=126.0, rate=0.0, count=40):
    """Sensitivity in proportion to the radius from the centre to the tip: every area counts alike."""
    x, w = np.polynomial.legendre.leggauss(count)
    radius = (x + 1) / 2 * diameter / 2
    return RotorSensitivity(radius=radius, weight=radius, step=w / 2 * diameter / 2, blades=3, rotor_speed=rate)


def test_standing_rotor_is_the_disk_average():
    """wind.py gets the same by the density of distances in a disk; theta and radius quadrature differ by 0.5 % (kinks of exp(-d) at d = 0)."""
    low = 2 * np.pi * 0.3 > OMEGA  # above, a coherence length is shorter than the quadrature's steps
    collective, gradient = rotor_spectra(wind(), uniform_disk(), OMEGA[low])
    np.testing.assert_allclose(collective, rotor_averaged_spectrum(wind(), OMEGA[low]), rtol=0.02)
    np.testing.assert_allclose(gradient, gradient_spectrum(wind(), OMEGA[low]), rtol=0.02)


def test_rotation_moves_energy_to_blade_passing_and_leaves_the_low_end():
    rate = 1.245
    still, turning = (rotor_spectra(wind(), uniform_disk(rate=r), OMEGA)[0] for r in (0.0, rate))
    slow = 0.3 * rate > OMEGA
    near = np.abs(OMEGA - 3 * rate) < 0.15 * rate
    np.testing.assert_allclose(turning[slow], still[slow], rtol=0.05)  # harmonics of 3P reach down this far only weakly
    assert np.all(turning[near] > 5 * still[near])


def test_point_averaging_has_the_point_spectrum_and_no_gradients():
    collective, gradient = rotor_spectra(wind(averaging="point"), uniform_disk(rate=1.2), OMEGA)
    np.testing.assert_array_equal(collective, wind_spectrum(wind(), OMEGA))
    assert not gradient.any()


def test_coherent_wind_is_seen_as_at_a_point():
    """When eddies are far larger than the rotor all blades see one wind: no 3P, no gradients."""
    state = wind(rotor_diameter=0.5)
    collective, _ = rotor_spectra(state, uniform_disk(diameter=0.5, rate=1.2), OMEGA[:100])
    np.testing.assert_allclose(collective, wind_spectrum(state, OMEGA[:100]), rtol=0.02)  # coherence over 0.5 m is above 0.98


def test_blade_sampling_against_simulated_points():
    """A ring of points with the model's coherence, sampled by three turning blades in time.

    The field at n azimuths of one radius is synthesised with the exact cross-spectra; blades interpolate it. The step is fine
    enough for the high azimuthal modes, which would alias, and the coherence decays slowly enough (2 instead of 12) for the
    points, 5 m apart, to resolve it. 24 records of 512 s with 15 lines or more in a band scatter
    by 1 / sqrt(24 * 15) = 5 %; the tolerance is three of these.
    """
    rng = np.random.default_rng(3)
    rate, radius, points, step, count, records = 1.2, 50.0, 64, 0.0625, 8192, 24
    omega = 2 * np.pi * np.fft.rfftfreq(count, step)[1:]
    used = omega < 2 * np.pi * 3.0
    theta = 2 * np.pi * np.arange(points) / points
    distance = 2 * radius * np.abs(np.sin((theta[:, None] - theta) / 2))
    state = wind(coherence_decay=2.0)
    roots = np.linalg.cholesky(np.exp(-coherence_rate(state, omega[used])[:, None, None] * distance) + 1e-9 * np.eye(points))
    size = np.sqrt(2 * wind_spectrum(state, omega[used]) * omega[0])
    at = (rate * np.arange(count) * step + 2 * np.pi * np.arange(3)[:, None] / 3) / (2 * np.pi) * points
    low, part, rows = np.floor(at).astype(int), at - np.floor(at), np.arange(count)
    power = np.zeros(len(omega))
    for _ in range(records):
        phase = rng.standard_normal((used.sum(), points, 2)) @ [1, 1j] / np.sqrt(2)
        lines = np.zeros((count // 2 + 1, points), dtype=complex)
        lines[1 : 1 + used.sum()] = size[:, None] * np.einsum("fij,fj->fi", roots, phase)
        field = np.fft.irfft(lines * count / 2, count, axis=0)
        seen = ((1 - part) * field[rows, low % points] + part * field[rows, (low + 1) % points]).mean(axis=0)
        power += np.abs(np.fft.rfft(seen * np.sqrt(8 / 3) * np.hanning(count))[1:]) ** 2
    estimate = power / records * 2 * step / count / (2 * np.pi)
    ring = RotorSensitivity(radius=[radius], weight=[1.0], step=[1.0], blades=3, rotor_speed=rate)
    expected = rotor_spectra(state, ring, omega)[0]
    for first, last in ((0.02, 0.05), (0.05, 0.1), (0.15, 0.3), (0.45, 0.7)):
        band = (omega > 2 * np.pi * first) & (omega < 2 * np.pi * last)
        assert estimate[band].sum() == pytest.approx(expected[band].sum(), rel=0.15)


def test_tip_loss_and_root():
    """Weight grows with the radius in the middle of the blade and falls towards the tip; nothing inside 15 % of the radius."""
    rotor = rotor_sensitivity(126.0, 3, 1.245, 11.0)
    middle = (rotor.radius > 20) & (rotor.radius < 45)
    np.testing.assert_allclose(rotor.weight[middle] / rotor.radius[middle], 1.0, atol=0.03)  # Prandtl's factor there
    assert rotor.radius.min() > 0.15 * 63
    assert rotor.weight[-1] < 0.5 * rotor.radius[-1]


def test_gradient_arm_of_the_uniform_disk():
    """Integral of r3 over twice that of r: R2 / 4."""
    assert uniform_disk().gradient_arm == pytest.approx(63.0**2 / 4, rel=1e-12)
