"""White-noise identification against systems whose transfer function is known."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.signal import freqz, lfilter, welch

from model.response.identify import choose_segment, estimate, independent_segments, smooth_like_welch
from model.response.measures import BANDS, peak, rao_error

STEP, SEGMENT = 0.5, 250.0


def noise(seed, seconds=100_000.0):
    return np.random.default_rng(seed).normal(size=int(seconds / STEP))


def test_known_filter():
    """A first-order lag: magnitude and phase. 900 averages scatter by 1/sqrt(2 * 800) = 2.5 % at worst, less here where coherence is 1."""
    b, a = [0.2], [1.0, -0.8]
    inputs = [noise(1), noise(2)]
    outputs = [lfilter(b, a, x)[:, None] for x in inputs]
    found = estimate(inputs, outputs, STEP, SEGMENT)
    band = slice(5, len(found.frequency) - 5)
    exact = freqz(b, a, 2 * np.pi * found.frequency[band] * STEP)[1]
    assert np.abs(found.coherent_rao[band, 0] / exact - 1).max() < 0.02
    assert np.abs(found.energy_rao[band, 0] / np.abs(exact) - 1).max() < 0.02
    assert found.coherence[band].min() > 0.99
    assert np.angle(found.coherent_rao[20, 0]) < 0  # the output lags


def test_a_delay_turns_the_phase_backwards():
    x = noise(3)
    y = np.roll(x, 8)[:, None]  # four seconds later
    found = estimate([x], [y], STEP, SEGMENT)
    band = slice(2, 20)
    # 4 s of a 250 s window are lost: 3 % at worst
    assert np.abs(found.coherent_rao[band, 0] - np.exp(-2j * np.pi * found.frequency[band] * 4.0)).max() < 0.05


def test_coherence_of_a_noisy_output():
    """Equal powers of signal and foreign noise: coherence 1/2, H1 keeps the signal, |H|2 sees both (sqrt 2)."""
    x = noise(4)
    y = (3 * x + 3 * noise(5))[:, None]
    found = estimate([x], [y], STEP, SEGMENT)
    # means over 490 lines of 790 segments: scatter below 0.3 %
    assert found.coherence[5:-5].mean() == pytest.approx(0.5, rel=0.01)
    assert np.abs(found.coherent_rao[5:-5]).mean() == pytest.approx(3.0, rel=0.01)
    assert found.energy_rao[5:-5].mean() == pytest.approx(3 * np.sqrt(2), rel=0.01)


def test_levels_standard_deviations_and_seed_scatter():
    inputs = [noise(s, 10_000.0) for s in range(6)]
    outputs = [np.stack([2 * x + 7, x], axis=1) for x in inputs]
    found = estimate(inputs, outputs, STEP, SEGMENT)
    assert found.std == pytest.approx([2.0, 1.0], rel=0.02)  # 120 000 samples: 0.2 %
    assert found.mean == pytest.approx([7.0, 0.0], abs=0.03)
    assert found.output_spectrum[3:-3, 1].mean() == pytest.approx(
        2 * STEP, rel=0.02
    )  # one-sided: variance over half the sampling rate
    assert found.scatter[0] == pytest.approx(found.scatter[1])
    assert 0.001 < found.scatter[0] < 0.02  # 1/sqrt(2 * 20 000) = 0.5 %


def test_records_of_any_length_weigh_by_their_segments():
    """One long record and the same cut in two give the same average where segments coincide."""
    x = noise(6, 5000.0)
    half = len(x) // 2
    y = x[:, None]
    whole = estimate([x], [y], STEP, SEGMENT)
    parts = estimate([x[:half], x[half:]], [y[:half], y[half:]], STEP, SEGMENT)
    assert whole.averages > parts.averages  # the segment across the cut is missing
    assert parts.input_spectrum.mean() == pytest.approx(whole.input_spectrum.mean(), rel=0.05)


def test_a_record_shorter_than_a_segment_is_refused():
    with pytest.raises(ValueError, match="200 s is shorter than a segment of 250 s"):
        estimate([noise(7, 200.0)], [noise(7, 200.0)[:, None]], STEP, SEGMENT)


def test_frequencies_without_input_have_no_rao():
    x = np.sin(2 * np.pi * 0.1 * np.arange(100_000) * STEP)
    found = estimate([x], [x[:, None]], STEP, SEGMENT)
    assert np.isnan(found.energy_rao[-1, 0])
    near = np.argmin(np.abs(found.frequency - 0.1))
    assert found.energy_rao[near, 0] == pytest.approx(1.0)


def test_smoothing_keeps_the_area():
    """A convolution with weights that sum to one; the peak lies 100 windows away from both ends."""
    f = np.arange(0, 1.0, 1e-4)
    spectrum = np.exp(-0.5 * ((f - 0.4) / 1e-3) ** 2)
    smooth = smooth_like_welch(spectrum, 1e-4, 1000.0, 0.5)
    assert smooth.sum() == pytest.approx(spectrum.sum(), rel=1e-9)
    assert smooth.max() < spectrum.max()
    assert smooth.min() >= 0


def test_smoothing_looks_like_welch():
    """A line at 0.1 Hz: the Hann window shows it over three bins with 1, 1/4, 1/4 of the power (times 2/3)."""
    f = np.arange(0, 0.3, 1e-4)
    line = np.zeros_like(f)
    line[1000] = 1 / 1e-4
    smooth = smooth_like_welch(line, 1e-4, 1000.0, 0.5)
    t = np.arange(0, 1000.0, 0.5)
    seen = welch(np.sqrt(2) * np.sin(2 * np.pi * 0.1 * t + 0.3), fs=2.0, window="hann", nperseg=2000, detrend=False)[1]
    assert smooth[[990, 1000, 1010]] == pytest.approx(seen[[99, 100, 101]], rel=0.01)
    assert smooth[1000] / smooth[990] == pytest.approx(4.0, rel=0.01)


def test_smoothing_of_several_columns_and_of_a_constant():
    flat = np.ones((3000, 2)) * [1.0, 5.0]
    smooth = smooth_like_welch(flat, 1e-4, 1000.0, 0.5)
    # mirrored at zero frequency, so the constant stays one there; the far end runs out of data
    assert np.allclose(smooth[:2900], flat[:2900], rtol=1e-9)


def test_parabola_finds_the_vertex():
    f = np.linspace(0.0, 1.0, 101)
    values = np.stack([3 - (f - 0.4037) ** 2, 7 - 2 * (f - 0.2512) ** 2], axis=1)
    where, height = peak(values, f, (0.1, 0.9))
    assert where == pytest.approx([0.4037, 0.2512])
    assert height == pytest.approx([3.0, 7.0])


def test_peak_inside_its_band_only():
    f = np.linspace(0.0, 1.0, 101)
    values = (np.exp(-(((f - 0.2) / 0.05) ** 2)) + 5 * np.exp(-(((f - 0.8) / 0.05) ** 2)))[:, None]
    where, _ = peak(values, f, (0.1, 0.4))
    assert where[0] == pytest.approx(0.2, abs=0.002)


def test_rao_error_of_a_scaled_rao():
    f = np.linspace(0.0, 0.25, 251)
    reference = np.stack([1 + f, 2 - f], axis=1)
    error = rao_error(reference * [1.1, 0.7], reference, np.ones_like(f), f)
    assert error == pytest.approx([0.1, 0.3])


def test_rao_error_outside_the_band_or_without_energy_does_not_count():
    f = np.linspace(0.0, 0.25, 251)
    reference = np.ones((251, 1))
    wrong = np.where((f > 0.02) & (f < 0.05), 1.0, 9.0)[:, None]
    assert rao_error(wrong, reference, np.ones_like(f), f, (0.021, 0.049))[0] == 0.0
    assert rao_error(wrong, reference, np.where((f > 0.02) & (f < 0.05), 1.0, 0.0), f)[0] == 0.0


def test_bands_follow_each_other():
    assert all(a[1] == b[0] for a, b in pairwise(BANDS))


# --- confidence: a statistical test with many bins -------------------------------------------------------------------


@pytest.fixture(scope="module")
def many_estimates():
    """Thirty experiments of three records: a first-order lag of white noise plus foreign noise, from 30 to 99 % coherent.

    The lag is wide (0.1 Hz) beside the window (0.006 Hz), so there is no bias to speak of.
    """
    b, a = [0.2], [1.0, -0.8]
    out = []
    for trial in range(30):
        inputs = [noise(1000 + 10 * trial + k, 6000.0) for k in range(3)]
        outputs = [
            (lfilter(b, a, x) + 0.15 * noise(5000 + 10 * trial + k, 6000.0))[:, None] for k, x in enumerate(inputs)
        ]
        out.append(estimate(inputs, outputs, STEP, SEGMENT))
    band = slice(4, len(out[0].frequency) - 4, 3)  # every third line: neighbours share the window
    exact = freqz(b, a, 2 * np.pi * out[0].frequency[band] * STEP)[1]
    return out, band, exact


def share(inside):
    return np.mean(inside), np.sqrt(0.95 * 0.05 / np.size(inside))


def test_the_true_transfer_function_lies_inside_the_circle_in_95_per_cent_of_the_bins(many_estimates):
    """2430 bins: 95 % give or take 0.44 %. Four of these, and half a per cent for segments that are not quite independent."""
    found, band, exact = many_estimates
    inside = [np.abs(e.coherent_rao[band, 0] - exact) < e.coherent_radius()[band, 0] for e in found]
    covered, scatter = share(inside)
    assert abs(covered - 0.95) < 4 * scatter + 0.005


def test_the_true_energy_lies_inside_the_bounds_in_95_per_cent_of_the_bins(many_estimates):
    """|H|2 of signal and foreign noise together; the bounds are asymptotic (66 averages): one per cent more."""
    found, band, exact = many_estimates
    truth = np.sqrt(np.abs(exact) ** 2 + 0.15**2)
    inside = []
    for e in found:
        low, high = e.energy_bounds()
        inside.append((low[band, 0] < truth) & (truth < high[band, 0]))
    covered, scatter = share(inside)
    assert abs(covered - 0.95) < 4 * scatter + 0.01


def test_too_narrow_bounds_would_be_noticed(many_estimates):
    """The same test with bounds made for 80 %: the fraction follows, so the test can fail."""
    found, band, exact = many_estimates
    inside = [np.abs(e.coherent_rao[band, 0] - exact) < e.coherent_radius(0.80)[band, 0] for e in found]
    assert np.mean(inside) == pytest.approx(0.80, abs=0.03)


def test_independent_segments_by_the_scatter_of_spectra():
    """White noise: the variance of a Welch spectrum is its square over the number of independent segments (to 10 %: 200 trials of 240 lines)."""
    spectra = [estimate([noise(s, 2000.0)], [noise(s, 2000.0)[:, None]], STEP, SEGMENT) for s in range(200)]
    values = np.array([e.input_spectrum[4:-4] for e in spectra])
    assert (values.mean() ** 2 / values.var(axis=0)).mean() == pytest.approx(spectra[0].averages, rel=0.1)
    assert independent_segments(1) == 1.0


def test_expected_error_is_what_a_perfect_model_finds(many_estimates):
    found, _, _ = many_estimates
    f = found[0].frequency
    truth = np.sqrt(np.abs(freqz([0.2], [1.0, -0.8], 2 * np.pi * f * STEP)[1]) ** 2 + 0.15**2)[:, None]
    got = [rao_error(truth, e.energy_rao, e.input_spectrum, f, (0.05, 0.9))[0] for e in found]
    # 30 experiments of 200 lines each: their mean scatters by a few per cent
    assert np.mean(got) == pytest.approx(np.mean([e.expected_error((0.05, 0.9))[0] for e in found]), rel=0.1)


@pytest.mark.parametrize(
    ("shortest", "narrowest", "seconds"),
    [
        (6000, None, 1000),
        (3600, None, 1000),
        (3000, None, 500),
        (1000, None, 200),
        (6000, 0.02, 200),
        (6000, 1e-4, 1000),
    ],
)
def test_segments_as_long_as_needed_and_possible(shortest, narrowest, seconds):
    """3.5 segments in the shortest record, four over the width of the narrowest peak, 1000 s at most, in steps of 1, 2, 5."""
    assert choose_segment(shortest, narrowest) == seconds


def test_a_record_too_short_for_any_spectrum():
    with pytest.raises(ValueError, match="20 s is too short for spectra"):
        choose_segment(20.0)
