"""Validation against time series made from the model itself, so that what is wrong with them is known."""

from dataclasses import replace

import numpy as np
import pytest

import fowtio
from fowtio import validation_model
from fowtio.case_validation import Reference, Tolerance
from fowtio.errors import ModelError
from fowtio.read.openfast_out import TimeSeries
from fowtio.reference import find_channel
from fowtio.validation_model import evaluate
from model.environment.sea import wavenumber
from model.response.reconstruct import driven_by

STEP, SECONDS, DISCARD = 0.5, 3000.0, 500.0
CHANNELS = {
    "PtfmSurge": "m",
    "PtfmHeave": "m",
    "PtfmPitch": "deg",
    "TTDspFA": "m",
    "TwrBsFxt": "kN",
    "TwrBsMyt": "kN-m",
    "T[1]": "N",
    "T[2]": "N",
    "T[3]": "N",
}
SI = {"deg": np.pi / 180, "kN": 1e3, "kN-m": 1e3}


@pytest.fixture(scope="module")
def oc4(oc4):
    """With linear drag: what follows the waves is then all of the response."""
    return replace(oc4, case=replace(oc4.case, options=replace(oc4.case.options, drag_model="relative")))


@pytest.fixture(scope="module", autouse=True)
def coarse_model():
    """The model on fewer frequencies, for speed: records and comparison are made from the same."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(validation_model, "POINTS", 400)
        yield


@pytest.fixture(scope="module")
def side(oc4, coarse_model):
    return evaluate(oc4, oc4.states[0], list(CHANNELS), 500.0, 0.5 / STEP)


def waves(seed):
    """White noise of 1 m2/Hz between 0.005 and 0.2 Hz with constant amplitudes, periodic, as OpenFAST makes it."""
    count = int(SECONDS / STEP)
    f = np.fft.rfftfreq(count, STEP)
    inside = (f >= 0.005) & (f <= 0.2)
    phases = np.exp(2j * np.pi * np.random.default_rng(seed).random(len(f)))
    x = np.fft.irfft(np.where(inside, np.sqrt(1.0 / (2 * count * STEP)) * count, 0.0) * phases, count)
    return np.append(x, x[0])


def made(side, seed, *, gain=1.0, noise=0.02):
    """A record of the linear model with a little foreign noise, in OpenFAST's units."""
    elevation = waves(seed)
    out = driven_by(elevation[:-1], STEP, side.to_wave[0], side.hz)
    out = np.concatenate([out, out[:1]]) * gain + side.mean
    out = out + noise * out.std(axis=0) * np.random.default_rng(seed + 99).normal(size=out.shape)
    data = np.column_stack([elevation, out / [SI.get(u, 1.0) for u in CHANNELS.values()]])
    return TimeSeries(
        time=np.arange(len(elevation)) * STEP,
        data=data,
        names=("Wave1Elev", *CHANNELS),
        units=("m", *CHANNELS.values()),
        source=f"seed{seed}.outb",
    )


@pytest.fixture(scope="module")
def good(side):
    return [made(side, 1), made(side, 2)]


def changed(series, channel, function):
    data = series.data.copy()
    k = series.names.index(channel)
    data[:, k] = function(data[:, k])
    return replace(series, data=data)


def compare(oc4, series, *, channels=(), discard=DISCARD, **tolerances):
    reference = Reference(
        state="white_noise", files=(), discard=discard, tolerance=0.02, channels=channels, **tolerances
    )
    return fowtio.validate(oc4, reference, nonlinear=False, series=series)


def errors(found):
    return [(f.subject, f.text) for f in found.findings if f.severity == "error"]


# --- a perfect reference ---------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def perfect(oc4, good):
    return compare(oc4, good)


def test_the_model_agrees_with_itself(perfect):
    """The same waves leave nothing but the foreign noise (0.02 % of the variance) and the transient of a periodic record."""
    assert errors(perfect) == []
    for c in perfect.channels:
        assert abs(c.std_error_same_waves) < 2e-3, c.name
        assert c.correlation_same_waves > 0.999, c.name
        assert c.rao_error < 0.12  # two records of five segments: chance alone, see the estimator's own error
        assert c.rao_error_same_waves < 0.01
    assert perfect.passed == all(abs(c.std_error) <= 0.02 for c in perfect.channels)


def test_nothing_is_missing_in_a_perfect_model(perfect):
    """Damping and stiffness to add are a few per cent of the model's own damping: chance, with errors of the same size."""
    lack = perfect.lack
    assert lack.terms.dofs == ("surge", "heave", "pitch")
    assert np.all(np.abs(lack.terms.damping / lack.critical) < 0.3 * lack.damping_ratio)
    assert np.all(np.abs(lack.terms.stiffness / lack.restoring) < 0.02)


def test_too_little_response_is_seen(oc4, side):
    """A reference 10 % larger: standard deviations 9 % low, outside; RAO error of the same size where chance allows."""
    found = compare(oc4, [made(side, 1, gain=1.1), made(side, 2, gain=1.1)])
    for c in found.channels:
        assert c.std_error_same_waves == pytest.approx(1 / 1.1 - 1, abs=2e-3)
        assert c.std_verdict == "outside"
    assert not found.passed


def test_tolerances_are_by_channel(oc4, side):
    """The last row that names a channel counts; without a tolerance nothing is judged."""
    rows = (
        Tolerance(channel="*", std=0.2),
        Tolerance(channel="Ptfm*", std=None),
        Tolerance(channel="T[2]", std=0.001, rao=0.5),
    )
    found = {
        c.name: c for c in compare(oc4, [made(side, 1, gain=1.1), made(side, 2, gain=1.1)], tolerances=rows).channels
    }
    assert found["PtfmHeave"].verdict == "not judged"
    assert found["TwrBsMyt"].verdict == "within"
    assert found["T[2]"].std_verdict == "outside"
    assert found["T[2]"].rao_verdict == "within"
    assert found["T[1]"].tolerance.std == 0.2


# --- wrong references ------------------------------------------------------------------------------------------------


def rolled(steps):
    return lambda x: np.roll(x, steps)


def gauge(distance):
    """The elevation some way down the waves."""

    def move(x):
        spectrum = np.fft.rfft(x[:-1])
        k = wavenumber(2 * np.pi * np.maximum(np.fft.rfftfreq(len(x) - 1, STEP), 1e-6), 200.0, 9.80665)
        y = np.fft.irfft(np.where(k < 1, spectrum * np.exp(-1j * k * distance), 0), len(x) - 1)
        return np.append(y, y[0])

    return move


@pytest.mark.parametrize(
    ("channel", "function", "both", "subject", "words"),
    [
        ("PtfmHeave", np.negative, True, "PtfmHeave", "wrong sign"),
        ("PtfmPitch", np.negative, False, "PtfmPitch", "wrong sign in seed1.outb alone"),
        ("Wave1Elev", np.negative, True, "Wave1Elev", "the wave elevation has the other sign"),
        ("PtfmPitch", np.degrees, True, "PtfmPitch", "degrees taken for radians"),
        ("TwrBsFxt", lambda x: x / 1000, True, "TwrBsFxt", "factor of 1/1000"),
        ("Wave1Elev", rolled(-8), False, "seed1.outb", "the channels come 4.0 s after"),
        ("Wave1Elev", rolled(2), True, "seed2.outb", "the channels come 1.0 s before"),
        ("Wave1Elev", gauge(60.0), True, "seed1.outb", "60 m down the waves"),
        ("Wave1Elev", lambda x: waves(7), False, "seed1.outb", "not what drove this record"),
        ("Wave1Elev", lambda x: 1.4 * x, True, "Wave1Elev", "waves of another height"),
    ],
)
def test_a_wrong_reference_is_named(oc4, good, channel, function, both, subject, words):
    series = [changed(good[0], channel, function), changed(good[1], channel, function) if both else good[1]]
    found = compare(oc4, series)
    assert any(s == subject and words in text for s, text in errors(found)), errors(found)
    assert not found.passed


def test_a_missing_channel_is_named(oc4, good):
    k = good[0].names.index("TTDspFA")
    short = replace(good[0], data=np.delete(good[0].data, k, axis=1), names=tuple(n for n in good[0].names if n != "TTDspFA"),
                    units=tuple(u for n, u in zip(good[0].names, good[0].units, strict=True) if n != "TTDspFA"))  # fmt: skip
    found = compare(oc4, [short, good[1]])
    assert ("TTDspFA", "channel missing in seed1.outb, present in the other records; it is not compared") in errors(
        found
    )
    assert "TTDspFA" not in [c.name for c in found.channels]


def test_a_record_too_short_is_named(oc4, good):
    found = compare(oc4, [replace(s, time=s.time[:4001], data=s.data[:4001]) for s in good])
    assert any("too short: 1500 s remain, 13" in text for _, text in errors(found))
    with pytest.raises(ModelError, match="fewer than 100 samples"):
        compare(oc4, good, discard=2990.0)


def test_a_record_given_twice_is_named(oc4, good):
    assert any(
        "the same waves as seed1.outb" in text
        for _, text in errors(compare(oc4, [good[0], replace(good[0], source="copy.outb")]))
    )


def test_an_uneven_time_axis_is_named(oc4, good):
    keep = np.delete(np.arange(6001), slice(3000, 3010))
    broken = replace(good[0], time=good[0].time[keep], data=good[0].data[keep])
    assert any("time axis uneven: a step of 5.5 s" in text for _, text in errors(compare(oc4, [broken, good[1]])))


# --- other models' time series ---------------------------------------------------------------------------------------


def test_channels_of_other_modules_and_units(oc4, good, perfect):
    """MoorDyn's tensions, HydroDyn's motions in radians, loads in MN: found by name and pattern, the same figures, the rest listed."""
    names = {
        "T[1]": "[FAIRTEN1]",
        "T[2]": "[FAIRTEN2]",
        "T[3]": "[FAIRTEN3]",
        "PtfmPitch": "PRPPitch",
        "Wave1Elev": "WaveElev",
        "TwrBsMyt": "-TwrBsMyt",
    }
    factors, units = {"PtfmPitch": np.pi / 180, "TwrBsMyt": -1e-3}, {"PtfmPitch": "rad", "TwrBsMyt": "MN-m"}
    series = []
    for s in good:
        data = s.data * [factors.get(n, 1.0) for n in s.names]
        series.append(replace(s, data=np.column_stack([data, data[:, 1]]), names=(*(names.get(n, n) for n in s.names), "RotSpeed"),
                              units=(*(units.get(n, u) for n, u in zip(s.names, s.units, strict=True)), "rpm")))  # fmt: skip
    found = compare(oc4, series)
    assert errors(found) == []
    assert found.unmatched == ("RotSpeed",)
    written = {c.name: c.written for c in found.channels}
    assert (written["T[2]"], written["PtfmPitch"], written["TwrBsMyt"]) == ("[FAIRTEN2]", "PRPPitch", "-TwrBsMyt")
    assert [c.std_reference for c in found.channels] == pytest.approx([c.std_reference for c in perfect.channels])


def test_names_that_the_study_gives(oc4, good):
    """Names of another code, one row for all lines, and a factor where its unit is not known."""
    names = {"T[1]": "MooringA_1", "T[2]": "MooringA_2", "T[3]": "MooringA_3", "PtfmSurge": "X_cog"}
    series = [replace(s, names=tuple(names.get(n, n) for n in s.names), units=tuple("daN" if n.startswith("T[") else u for n, u in zip(s.names, s.units, strict=True)),
                      data=s.data / [10.0 if n.startswith("T[") else 1.0 for n in s.names]) for s in good]  # fmt: skip
    found = compare(oc4, series, channels=(("T[#]", "MooringA_#", 10.0), ("PtfmSurge", "X_cog", 0.0)))
    assert errors(found) == []
    assert {"T[1]", "T[3]", "PtfmSurge"} <= {c.name for c in found.channels}
    unknown = compare(
        oc4,
        [
            replace(s, units=tuple("furlong" if n == "PtfmHeave" else u for n, u in zip(s.names, s.units, strict=True)))
            for s in good
        ],
    )
    assert any(s == "PtfmHeave" and "'furlong' is not known" in text for s, text in errors(unknown))


@pytest.mark.parametrize(
    ("name", "present", "expected"),
    [
        ("T[2]", ["FairTen1", "FairTen2"], "FairTen2"), ("T[1]", ["L1FairTen", "T[10]"], "L1FairTen"), ("T[12]", ["FAIRTEN1", "FAIRTEN12"], "FAIRTEN12"),
        ("T[1]", ["T_a[1]", "T[1]"], "T[1]"), ("T_a[3]", ["AnchTen3", "FairTen3"], "AnchTen3"), ("PtfmSurge", ["PtfmTDxi"], "PtfmTDxi"),
        ("PtfmSurge", ["B1Surge", "ptfmsurge"], "ptfmsurge"), ("PtfmYaw", ["PtfmRDzi"], "PtfmRDzi"), ("TTDspFA", ["YawBrTDxt"], "YawBrTDxt"),
        ("T[1]", ["AnchTen1"], None),
    ],
)  # fmt: skip
def test_names_by_pattern(name, present, expected):
    found = find_channel(name, present)
    assert (found and found[0]) == expected


def test_without_a_wave_channel_nothing_can_be_said(oc4, good):
    with pytest.raises(ModelError, match=r"no wave elevation channel .*NChan"):
        compare(oc4, [replace(s, names=("Nothing", *s.names[1:])) for s in good])
