"""Wind spectra at a point and over the rotor, against closed forms, published values and brute force."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.special import gamma, iv, modstruve

from model.environment.wind import (
    WindState,
    coherence,
    coherence_rate,
    gradient_coherence,
    gradient_spectrum,
    inflow_spectrum,
    mean_coherence,
    rotor_averaged_spectrum,
    standard_deviation,
    turbulence_scale,
    turbulence_sigma,
    wind_spectrum,
)

OMEGA = np.linspace(0.0, 4.0, 50)


def wind(**parameters):
    defaults = {"mean_speed": 12.0, "hub_height": 90.0, "rotor_diameter": 126.0}
    if parameters.get("spectrum", "kaimal") not in ("none", "api") and "turbulence_intensity" not in parameters:
        defaults["turbulence_class"] = "B"
    return WindState(**defaults | parameters)


def in_hz(state, frequency):
    return 2 * np.pi * wind_spectrum(state, 2 * np.pi * np.asarray(frequency))


def variance_up_to(state, top):
    """The integral of the spectrum up to a frequency [Hz], by adaptive quadrature in the logarithm of frequency."""
    return quad(lambda y: float(in_hz(state, np.exp(y))) * np.exp(y), -35, np.log(top), limit=400)[0]


# --- the standard's numbers


def test_normal_turbulence():
    """IEC 61400-1 ed. 3, eq. 11; its figure 1b puts class A at 15 m/s at an intensity of 18 %."""
    assert turbulence_sigma("A", "NTM", 15.0) / 15.0 == pytest.approx(0.18, abs=0.005)  # read off a figure
    assert turbulence_sigma("B", "NTM", 12.0) == pytest.approx(0.14 * 14.6, rel=1e-14)
    assert standard_deviation(wind()) == pytest.approx(0.14 * 14.6, rel=1e-14)


def test_extreme_turbulence():
    """IEC 61400-1 ed. 3, eq. 19, by hand: class I has 10 m/s annual mean, so 0.072 (5 + 3)(12/2 - 4) + 10 = 11.152."""
    assert turbulence_sigma("B", "ETM", 12.0) == pytest.approx(2 * 0.14 * 11.152, rel=1e-14)
    assert turbulence_sigma("B", "ETM", 12.0, "III") == pytest.approx(2 * 0.14 * (0.072 * 6.75 * 2 + 10), rel=1e-14)
    state = wind(turbulence_model="ETM")
    assert standard_deviation(state) == pytest.approx(2 * 0.14 * 11.152, rel=1e-14)


def test_turbulence_scale():
    assert [turbulence_scale(z) for z in (30.0, 60.0, 119.0)] == pytest.approx([21.0, 42.0, 42.0])


@pytest.mark.parametrize("spectrum", ["kaimal", "von_karman"])
def test_high_frequencies_follow_the_inertial_subrange(spectrum):
    """IEC 61400-1 ed. 3, eq. 6: S1 tends to 0.05 sigma1^2 (Lambda1/U)^(-2/3) f^(-5/3)."""
    state, f = wind(spectrum=spectrum), 100.0
    expected = 0.05 * standard_deviation(state) ** 2 * (42.0 / 12.0) ** (-2 / 3) * f ** (-5 / 3)
    assert in_hz(state, f) == pytest.approx(expected, rel=0.01)  # 0.05 is printed to one digit; the forms give 0.0498


# --- at a point


@pytest.mark.parametrize("hub_height", [40.0, 90.0])
def test_kaimal_variance(hub_height):
    state, top = wind(hub_height=hub_height), 1000.0
    time = 8.1 * 0.7 * min(hub_height, 60.0) / 12.0
    tail = (1 + 6 * top * time) ** (-2 / 3)  # the part of the variance above `top`, by integration
    variance = standard_deviation(state) ** 2
    assert variance_up_to(state, top) == pytest.approx(variance * (1 - tail), rel=1e-7)  # 1e-8 asked of quad
    assert tail < 0.01


def test_kaimal_at_zero_frequency_and_against_the_formula():
    state = wind(turbulence_intensity=0.1)
    time = 8.1 * 42.0 / 12.0
    assert in_hz(state, 0.0) == pytest.approx(4 * 1.2**2 * time, rel=1e-14)
    assert in_hz(state, 0.05) == pytest.approx(4 * 1.2**2 * time / (1 + 0.3 * time) ** (5 / 3), rel=1e-14)


def test_von_karman_variance():
    """The integral of 4/(1 + 71 x^2)^(5/6) is 0.9985: the standard rounds 70.8 to 71."""
    state, top = wind(spectrum="von_karman"), 1e4
    share = 4 / np.sqrt(71) * np.sqrt(np.pi) / 2 * gamma(1 / 3) / gamma(5 / 6)
    time = 3.5 * 42.0 / 12.0
    tail = 4 / 71 ** (5 / 6) * 1.5 * (top * time) ** (-2 / 3)
    got = variance_up_to(state, top) / standard_deviation(state) ** 2
    assert got == pytest.approx(share - tail, rel=1e-6)  # next term of the tail is (top * time)^-2 smaller
    assert share == pytest.approx(1.0, abs=0.002)


def test_api_spectrum():
    """ISO 19901-1, A.7.4: 320 (U0/10)^2 (z/10)^0.45 at zero frequency, U(z) = U0 (1 + C ln(z/10))."""
    at_ten = wind(spectrum="api", hub_height=10.0, mean_speed=10.0)
    assert in_hz(at_ten, 0.0) == pytest.approx(320.0, rel=1e-12)
    expected = 320 / (1 + 17.2**0.468) ** (5 / 3 / 0.468)
    assert in_hz(at_ten, 0.1) == pytest.approx(expected, rel=1e-12)
    hub = 14.0 * (1 + 0.0573 * np.sqrt(1 + 0.15 * 14.0) * np.log(10.0))
    aloft = wind(spectrum="api", hub_height=100.0, mean_speed=hub)
    assert in_hz(aloft, 0.0) == pytest.approx(320 * 1.4**2 * 10**0.45, rel=1e-9)  # the root finder's tolerance, 1e-12


@pytest.mark.parametrize("intensity", [None, 0.12])
def test_api_variance(intensity):
    state, top = wind(spectrum="api", turbulence_intensity=intensity), 1e7
    # the tail above `top` falls as (172 f)^(-2/3), 2e-6 of the variance, and quad is asked for 1e-8
    assert variance_up_to(state, top) == pytest.approx(standard_deviation(state) ** 2, rel=1e-5)
    if intensity:
        assert standard_deviation(state) == pytest.approx(1.44)


def test_steady_wind_has_no_spectrum():
    calm = wind(spectrum="none", mean_speed=0.0)
    for function in (wind_spectrum, rotor_averaged_spectrum, gradient_spectrum, inflow_spectrum):
        assert not function(calm, OMEGA).any()
    assert standard_deviation(calm) == 0


# --- over the rotor


def test_coherence_is_the_standards():
    state, f, r = wind(), 0.08, 30.0
    expected = np.exp(-12 * np.sqrt((f * r / 12.0) ** 2 + (0.12 * r / (8.1 * 42.0)) ** 2))
    assert coherence(state, 2 * np.pi * f, r) == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize("decay", [0.5, 1.0, 2.0, 5.0, 10.0])
def test_mean_coherence_closed_form(decay):
    """Modified Struve and Bessel functions, as the rotor average is written in RAFT (IECKaimal).

    That form loses all digits to cancellation at large decay, so it is compared where it is good to 1e-10.
    """
    x = decay / 2
    closed = modstruve(1, decay) - iv(1, decay) - 2 / np.pi
    closed += x * (-2 * modstruve(-2, decay) + 2 * iv(2, decay) + 1)
    assert mean_coherence(decay) == pytest.approx(2 / x**3 * closed, rel=1e-10)


def test_mean_coherence_limits():
    assert mean_coherence(0.0) == pytest.approx(1, abs=1e-14)
    # the mean distance of two points of a disk is 128 R/(45 pi); the next term is decay^2 x^2/2 < 1e-8
    assert mean_coherence(1e-4) == pytest.approx(1 - 1e-4 * 64 / (45 * np.pi), abs=1e-8)
    # for fast decay only near pairs count: the integral of 2 pi r exp(-r/l) over the area, 8/decay^2, less a 1/decay
    assert mean_coherence(1e5) == pytest.approx(8e-10, rel=1e-4)


@given(st.floats(0, 1e4), st.floats(0.001, 1))
def test_mean_coherence_falls_smoothly(decay, step):
    """Also across the switch at 40, where the range of integration begins to shrink."""
    here, further = mean_coherence(decay), mean_coherence(decay + step)
    assert 0 < further < here <= 1 + 1e-14
    # the derivative is at most the mean distance times the coherence, below one
    assert here - further < step


def test_mean_coherence_against_random_pairs():
    generator = np.random.default_rng(1)
    radius, angle = np.sqrt(generator.random((2, 400_000))) / 2, 2 * np.pi * generator.random((2, 400_000))
    place = radius * np.exp(1j * angle)
    for decay in (0.7, 6.0, 40.0):
        sample = np.exp(-decay * np.abs(place[0] - place[1]))
        error = sample.std() / np.sqrt(sample.size)
        assert mean_coherence(decay) == pytest.approx(sample.mean(), abs=4 * error)  # four standard errors


def disk_points():
    """Points and area weights on a disk of unit diameter: Gauss-Legendre in radius, equal steps in angle."""
    nodes, weights = np.polynomial.legendre.leggauss(20)
    radius, part = (nodes + 1) / 4, weights / 4 * (nodes + 1) / 4
    angle = 2 * np.pi * (np.arange(60) + 0.5) / 60
    place = (radius[:, None] * np.exp(1j * angle)).ravel()
    weight = np.repeat(part, 60) * 2 * np.pi / 60
    return place, weight / weight.sum()


@pytest.mark.parametrize("decay", [0.3, 2.0, 10.0])
def test_average_and_slopes_against_a_plane_fitted_on_points(decay):
    """The least-squares plane through the wind on 1200 points, its covariance from the coherence of every pair."""
    place, weight = disk_points()
    columns = np.stack([np.ones(place.size), place.real, place.imag], axis=1)
    fit = np.linalg.solve(columns.T @ (weight[:, None] * columns), columns.T * weight)
    covariance = fit @ np.exp(-decay * np.abs(place[:, None] - place)) @ fit.T
    # 0.5 %: the cusp of the coherence at zero distance, smeared over the spacing of 0.03
    assert mean_coherence(decay) == pytest.approx(covariance[0, 0], rel=5e-3)
    assert gradient_coherence(decay) == pytest.approx(covariance[1, 1], rel=5e-3)
    assert gradient_coherence(decay) == pytest.approx(covariance[2, 2], rel=5e-3)
    off_diagonal = covariance - np.diag(np.diag(covariance))
    assert np.abs(off_diagonal).max() < 1e-12  # uncorrelated by symmetry


def test_gradient_limits():
    assert gradient_coherence(0.0) == pytest.approx(0, abs=1e-13)  # a uniform field has no slope
    assert gradient_coherence(1e-3) == pytest.approx(10 * gradient_coherence(1e-4), rel=1e-3)  # linear at first
    # white noise of strength 8/decay^2 of the mean, over the disk's second moment 1/16: 16 times the mean
    assert gradient_coherence(1e5) == pytest.approx(16 * mean_coherence(1e5), rel=1e-3)


def test_rotor_average_with_infinite_scale_tends_to_the_point():
    state = wind(coherence_scale=np.inf)
    assert coherence_rate(state, 0.0) == 0
    ratio = rotor_averaged_spectrum(state, OMEGA) / wind_spectrum(state, OMEGA)
    assert ratio[0] == pytest.approx(1, abs=1e-14)
    assert (np.diff(ratio) < 0).all()
    finite = rotor_averaged_spectrum(wind(), OMEGA) / wind_spectrum(wind(), OMEGA)
    assert (finite < ratio).all()


def test_rotor_average_and_gradient_scale_with_the_diameter():
    state, f = wind(), 0.05
    decay = 126.0 * 12 * np.hypot(f / 12.0, 0.12 / (8.1 * 42.0))
    point = in_hz(state, f)
    averaged = 2 * np.pi * rotor_averaged_spectrum(state, 2 * np.pi * f)
    slope = 2 * np.pi * gradient_spectrum(state, 2 * np.pi * f)
    assert averaged == pytest.approx(point * mean_coherence(decay), rel=1e-13)
    assert slope == pytest.approx(point * gradient_coherence(decay) / 126.0**2, rel=1e-13)


def test_averaging_choice():
    np.testing.assert_array_equal(inflow_spectrum(wind(), OMEGA), rotor_averaged_spectrum(wind(), OMEGA))
    np.testing.assert_array_equal(inflow_spectrum(wind(averaging="point"), OMEGA), wind_spectrum(wind(), OMEGA))


def test_equal_bands_are_the_uniform_average():
    state = wind()
    bands = ([10.0, 25.0, 40.0, 63.0], [2.0, 2.0, 2.0, 2.0])
    np.testing.assert_allclose(
        rotor_averaged_spectrum(state, OMEGA, bands), rotor_averaged_spectrum(state, OMEGA), rtol=1e-12
    )


@pytest.mark.parametrize("decay", [0.3, 2.0, 10.0])
def test_bands_against_points(decay):
    """Annuli with weights as on a rotor, on a disk of unit diameter, against the sum over every pair of points."""
    edges, weights = np.array([0.2, 0.35, 0.5]), np.array([0.3, 1.0, 0.6])
    nodes, parts = np.polynomial.legendre.leggauss(8)
    inner = np.array([0.0, 0.2, 0.35])
    radius = (inner[:, None] + (edges - inner)[:, None] * (nodes + 1) / 2).ravel()
    part = ((edges - inner)[:, None] * parts * weights[:, None]).ravel() * radius
    place = (radius[:, None] * np.exp(2j * np.pi * np.arange(60) / 60)).ravel()
    share = np.repeat(part, 60)
    share /= share.sum()
    expected = share @ np.exp(-decay * np.abs(place[:, None] - place)) @ share
    state = wind(rotor_diameter=1.0, mean_speed=12.0, coherence_scale=np.inf)
    omega = 2 * np.pi * decay  # 12 f/U with U = 12 m/s
    got = rotor_averaged_spectrum(state, omega, (edges, weights)) / wind_spectrum(state, omega)
    assert got == pytest.approx(expected, rel=5e-3)  # the cusp, as for the plane fit


@pytest.mark.parametrize("decay", [0.5, 3.0, 8.0])
def test_a_thin_band_is_a_ring(decay):
    """Two points of a ring lie 2 R sin(angle/2) apart: the average is I0 - L0 (Bessel, Struve) of kappa times 2 R."""
    state = wind(rotor_diameter=1.0, mean_speed=12.0, coherence_scale=np.inf)
    omega = 2 * np.pi * decay
    got = rotor_averaged_spectrum(state, omega, ([0.4998, 0.5], [0.0, 1.0])) / wind_spectrum(state, omega)
    # the ring's mean radius is 2e-4 below the rim; differences of disks cost four more digits
    assert got == pytest.approx(iv(0, decay) - modstruve(0, decay), rel=2e-3)


@pytest.mark.parametrize(
    "bands", [([5.0, 4.0], [1.0, 1.0]), ([0.0, 4.0], [1.0, 1.0]), ([5.0], [1.0, 1.0]), ([5.0, 9.0], [0.0, 0.0])]
)
def test_bands_that_cannot_be(bands):
    with pytest.raises(ValueError, match="bands"):
        rotor_averaged_spectrum(wind(), OMEGA, bands)


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"spectrum": "frost"}, "unknown wind spectrum"),
        ({"averaging": "disk"}, "averaging"),
        ({"turbulence_intensity": 14.0}, "fraction"),
        ({"turbulence_intensity": 0.1, "turbulence_class": "A"}, "either"),
        ({"turbulence_class": None}, "either"),
        ({"turbulence_class": "D"}, "unknown turbulence_class"),
        ({"turbulence_model": "EWM"}, "unknown turbulence_model"),
        ({"wind_class": "IV"}, "unknown wind_class"),
        ({"spectrum": "api", "turbulence_class": "A"}, "own level"),
        ({"mean_speed": 0.0}, "calm"),
        ({"mean_speed": -3.0}, "zero or more"),
        ({"hub_height": 0.0}, "hub_height"),
        ({"rotor_diameter": -1.0}, "rotor_diameter"),
        ({"coherence_scale": 0.0}, "coherence_scale"),
    ],
)
def test_what_no_wind_can_be(parameters, message):
    with pytest.raises(ValueError, match=message):
        wind(**parameters)
