"""Environmental contours: closed forms, sampling, the published tables of the thesis, and another code."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from model.environment.contours import (
    crest,
    design_points,
    direct_sampling_contour,
    exceedance_probability,
    highest_density_contour,
    highest_density_level,
    iform_contour,
    iform_surface,
    isoline,
    level_range,
    outside_fraction,
    outside_probability,
    reliability_index,
    sampled_contour,
    unit_directions,
    wind_factor,
    worst_state,
)
from model.environment.joint import (
    HEIGHT,
    PERIOD,
    WIND,
    Dependence,
    JointModel,
    Variable,
    constant,
    density,
    sample,
    to_physical,
    to_standard,
)


def power(c1, c2, c3, given_by):
    return Dependence(form="power", coefficients=(c1, c2, c3), given=given_by)


def chain(wind, scale, shape, mean_log, variance_log) -> JointModel:
    """Return the joint distribution of the thesis: exponentiated Weibull wind, Weibull Hs, lognormal Tp."""
    return JointModel(
        variables=(
            Variable(name=WIND, family="weibull", parameters={k: constant(v) for k, v in wind.items()}),
            Variable(
                name=HEIGHT, family="weibull", parameters={"scale": power(*scale, WIND), "shape": power(*shape, WIND)}
            ),
            Variable(
                name=PERIOD,
                family="lognormal_variance",
                parameters={
                    "mean_log": power(*mean_log, HEIGHT),
                    "variance_log": Dependence(form="exponential", coefficients=variance_log, given=HEIGHT),
                },
            ),
        )
    )


# thesis Tables 17, 19 and 20, with the columns of the Mediterranean sites in the order that reproduces its own results
TUSCANY = chain(
    {"scale": 3.0253, "shape": 1.2404, "exponent": 2.1546},
    (0.3559, 0.0487, 1.5708),
    (1.4002, 0.0199, 1.7865),
    (-69.5990, 71.0447, 0.0064),
    (0.0, 0.1768, -0.7260),
)
SARDINIA = chain(
    {"scale": 6.9253, "shape": 1.8745},
    (0.4702, 0.0319, 1.7488),
    (1.5012, 0.0079, 2.0727),
    (-54.6469, 56.1314, 0.0083),
    (0.0, 0.1018, -0.6182),
)
TABLE_26 = {  # hub wind speed: (Tp, Hs), one year
    "tuscany": {
        9: (7.83, 3.77),
        11: (8.15, 4.11),
        13: (8.41, 4.41),
        15: (8.65, 4.69),
        17: (8.87, 4.95),
        19: (9.07, 5.21),
        21: (9.25, 5.44),
        23: (9.40, 5.64),
        25: (9.47, 5.72),
    },
    "sardinia": {
        9: (8.62, 4.17),
        11: (9.12, 4.69),
        13: (9.53, 5.16),
        15: (9.89, 5.59),
        17: (10.22, 6.00),
        19: (10.53, 6.39),
        21: (10.83, 6.78),
        23: (11.11, 7.17),
        25: (11.38, 7.55),
    },
}
TABLE_28 = {
    "tuscany": {11: (8.68, 4.93), 25: (10.47, 7.14)},
    "sardinia": {11: (9.98, 5.60), 25: (12.11, 8.62)},
}  # 50 years
SITES = {"tuscany": TUSCANY, "sardinia": SARDINIA}
TO_HUB = wind_factor(10.0, 119.0, 0.14)
NORMAL = JointModel(
    variables=tuple(
        Variable(name=n, family="lognormal", parameters={"mean_log": constant(0.0), "std_log": constant(1.0)})
        for n in "abc"
    )
)


@pytest.mark.parametrize(("years", "beta"), [(50, 4.584), (1, 3.686)])
def test_the_reliability_index_of_hourly_states(years, beta):
    # thesis errata, equation 7.2: three digits printed
    assert reliability_index(years) == pytest.approx(beta, abs=5e-4)
    assert exceedance_probability(reliability_index(years)) == pytest.approx(1 / (years * 8766), rel=1e-9)


def test_three_hour_states_make_a_smaller_contour_and_absurd_periods_are_refused():
    assert reliability_index(50, 3.0) < reliability_index(50, 1.0)
    with pytest.raises(ValueError, match="more than two states"):
        reliability_index(1e-5)
    with pytest.raises(ValueError, match="more than two states"):
        reliability_index(50, 0)


@pytest.mark.parametrize("site", SITES)
@pytest.mark.parametrize(("table", "years"), [(TABLE_26, 1), (TABLE_28, 50)])
def test_the_tables_of_the_thesis_are_reproduced(site, table, years):
    beta = reliability_index(years)
    for hub, (period, height) in table[site].items():
        _, hs, tp = crest(SITES[site], beta, hub * TO_HUB)
        # the thesis reads its values off a contour drawn with finite steps: 2 % (its own two tables differ by 1.5 % in
        # Tp)
        assert hs == pytest.approx(height, rel=0.02)
        assert tp == pytest.approx(period, rel=0.02)


def test_the_50_year_mean_wind_speeds_of_the_thesis():
    # thesis Tables 14 and 16, from the two-parameter Weibull: three digits printed
    for scale, shape, speed in ((9.4599, 2.1849, 30.6), (6.9253, 1.8745, 27.20)):
        wind = Variable(name=WIND, family="weibull", parameters={"scale": constant(scale), "shape": constant(shape)})
        assert to_physical(JointModel(variables=(wind,)), [reliability_index(50)])[0] == pytest.approx(speed, abs=0.05)


def test_ten_million_states_fall_outside_as_often_as_they_should():
    """Weibull and lognormal numbers come from numpy's own generators, not from the transformation under test."""
    beta, rng, batch, batches = reliability_index(1), np.random.default_rng(20), 1_000_000, 10
    outside = beyond = 0
    for _ in range(batches):
        wind = 6.9253 * rng.weibull(1.8745, batch)
        height = (0.4702 + 0.0319 * wind**1.7488) * rng.weibull(1.5012 + 0.0079 * wind**2.0727)
        std = np.sqrt(0.1018 * np.exp(-0.6182 * height))
        period = rng.lognormal(-54.6469 + 56.1314 * height**0.0083, std)
        part = outside_fraction(SARDINIA, beta, np.stack([wind, height, period], axis=-1))
        outside, beyond = outside + part[0] * batch, beyond + part[1] * batch
    n = batch * batches
    for found, probability in ((outside, outside_probability(beta, 3)), (beyond, exceedance_probability(beta))):
        # binomial scatter; four standard deviations are passed by chance once in 16 000
        assert abs(found - n * probability) < 4 * np.sqrt(n * probability)


@given(st.floats(-8, 8), st.floats(-8, 8), st.floats(-6, 6), st.sampled_from(["tuscany", "sardinia"]))
@settings(max_examples=60, deadline=None)
def test_states_and_standard_variables_are_inverse(a, b, c, site):
    u = np.array([a, b, c])
    x = to_physical(SITES[site], u)
    # rounding; with probabilities instead of their logarithms all digits are gone at u = 8
    assert to_standard(SITES[site], x) == pytest.approx(u, abs=1e-8)


def test_the_contour_lies_on_its_sphere_and_its_isolines_on_it():
    beta = reliability_index(50)
    for points in (
        iform_contour(TUSCANY, beta, 300),
        isoline(TUSCANY, beta, 8.0, 50),
        iform_surface(TUSCANY, beta, 9, 12)[1:-1],
    ):
        assert np.linalg.norm(to_standard(TUSCANY, points), axis=-1) == pytest.approx(beta, rel=1e-6)  # rounding
    assert isoline(TUSCANY, beta, 8.0)[:, 0] == pytest.approx(8.0)


def test_a_lognormal_contour_has_the_closed_form():
    assert iform_contour(JointModel(variables=NORMAL.variables[:2]), 2.0, 101) == pytest.approx(
        np.exp(2 * unit_directions(2, 101))
    )
    assert level_range(NORMAL, 3.0) == pytest.approx((np.exp(-3), np.exp(3)))


def test_design_points_are_the_extremes_of_a_dense_isoline():
    beta, line = reliability_index(50), isoline(SARDINIA, reliability_index(50), 15.0, 20001)
    points = {p.kind: p.state for p in design_points(SARDINIA, beta, 15.0)}
    assert points["max_hs"][1] == pytest.approx(
        line[:, 1].max(), rel=1e-6
    )  # 20 000 points miss the top by 1e-8 of its curvature
    assert points["max_tp"][2] == pytest.approx(line[:, 2].max(), rel=1e-6)
    assert points["min_tp"][2] == pytest.approx(line[:, 2].min(), rel=1e-6)
    with pytest.raises(ValueError, match="max_hs, max_tp or min_tp"):
        crest(SARDINIA, beta, 15.0, "largest")


def test_beyond_the_contour_there_is_no_isoline():
    with pytest.raises(ValueError, match="does not reach a wind speed of 40"):
        isoline(SARDINIA, reliability_index(50), 40.0)


def test_the_search_finds_the_worst_state_of_a_known_response():
    # of a linear response a.u on a sphere: beta |a|, at beta a / |a|
    a = np.array([0.3, 1.0, -0.5])
    found = worst_state(NORMAL, 4.0, lambda x: np.log(x) @ a)
    assert found.response == pytest.approx(4 * np.linalg.norm(a), rel=1e-4)  # last cap is 1e-3 rad wide: (1e-3)^2
    assert np.log(found.state) == pytest.approx(4 * a / np.linalg.norm(a), abs=0.05)
    limited = worst_state(NORMAL, 4.0, lambda x: np.where(x[:, 0] < np.exp(1.0), np.log(x) @ a, np.nan))
    assert np.log(limited.state)[0] < 1.0
    with pytest.raises(ValueError, match="no state of the contour has a response"):
        worst_state(NORMAL, 4.0, lambda x: np.full(len(x), np.nan))


def test_highest_density_encloses_the_right_probability():
    """Of the normal distribution in u = ln x the region is not a sphere, since the density is per x: so it is
    sampled.
    """
    rng = np.random.default_rng(4)
    for model, points, probability in ((SARDINIA, 101, 1e-2), (JointModel(variables=NORMAL.variables[:2]), 401, 1e-3)):
        x = sample(model, 400_000, rng)
        below = np.mean(density(model, x) < highest_density_level(model, probability, points))
        scatter = np.sqrt(probability / len(x))
        # four standard deviations of the sample, and 1 % for the grid
        assert abs(below - probability) < 4 * scatter + 0.01 * probability


def test_the_highest_density_contour_has_one_density():
    model = JointModel(variables=(SARDINIA.variables[0], SARDINIA.variables[1]))
    line = highest_density_contour(model, 1e-4, 60)
    values = density(model, line)
    # where a ray leaves the range of a distribution (Hs towards zero) the density stays above the level or falls at
    # once
    assert np.median(values) == pytest.approx(highest_density_level(model, 1e-4, 401), rel=1e-6)


def test_a_contour_by_direct_sampling_of_a_normal_sample_is_a_circle():
    x = np.random.default_rng(5).standard_normal((400_000, 2))
    line = direct_sampling_contour(x, 1e-3, 37)
    radius = np.hypot(*line.T)
    # each tangent is an order statistic of 400 states beyond: 1/sqrt(400) of the spacing 1/beta, 1.6 %, of 36 together 0.3 %
    assert radius.mean() == pytest.approx(stats.norm.isf(1e-3) / np.cos(np.pi / 36), rel=0.015)
    assert radius.std() < 0.1
    along = np.diff(line, axis=0)
    turns = along[:-1, 0] * along[1:, 1] - along[:-1, 1] * along[1:, 0]
    assert (turns > 0).all()  # convex, counter-clockwise
    with pytest.raises(ValueError, match="too few"):
        direct_sampling_contour(x[:100], 1e-3)


def test_sampling_a_distribution_comes_close_to_its_iform_contour():
    """Half-planes of states instead of standard normal variables: the same for a nearly linear transformation."""
    narrow = {"mean_log": constant(0.0), "std_log": constant(0.02)}
    model = JointModel(variables=tuple(Variable(name=n, family="lognormal", parameters=narrow) for n in "ab"))
    line = sampled_contour(model, 1e-3, np.random.default_rng(6))
    beta = stats.norm.isf(1e-3)
    # 50 states beyond each tangent, 14 % of a probability, 1.5 % of beta; exp(0.02 u) bends by 3 %
    assert np.log(line).max(axis=0) / 0.02 == pytest.approx(beta, rel=0.06)
    assert np.hypot(*(np.log(line) / 0.02).T) == pytest.approx(beta, rel=0.08)
    with pytest.raises(ValueError, match="not rare"):
        sampled_contour(model, 0.5, np.random.default_rng(6))


def test_a_chain_that_does_not_hold_together_is_refused():
    wind, height, period = SARDINIA.variables
    with pytest.raises(ValueError, match="does not come before"):
        JointModel(variables=(height, wind, period))
    with pytest.raises(ValueError, match="two variables are named wind_speed"):
        JointModel(variables=(wind, wind))
    with pytest.raises(ValueError, match="shape missing"):
        Variable(name=WIND, family="weibull", parameters={"scale": constant(1.0)})
    with pytest.raises(ValueError, match="skew is not among them"):
        Variable(
            name=WIND,
            family="weibull",
            parameters={"scale": constant(1.0), "shape": constant(1.0), "skew": constant(1.0)},
        )
    with pytest.raises(ValueError, match="one of them is what fowtio models"):
        Variable(
            name=PERIOD,
            family="lognormal",
            parameters={"mean_log": power(1, 1, 1, HEIGHT), "std_log": power(1, 1, 1, WIND)},
        )
    with pytest.raises(ValueError, match="needs 3 finite coefficients"):
        power(1.0, np.nan, 1.0, WIND)


def test_virocon_gives_the_same_contours():
    """Same distribution, another code: 2-D IFORM and highest density."""
    virocon = pytest.importorskip("virocon", reason="virocon is not installed")
    mu, sigma = (1.4, 0.25, 0.9), (0.03, 0.28, -0.4)
    height = virocon.WeibullDistribution(alpha=1.1, beta=1.25, gamma=0.15)
    descriptions = [
        {"distribution": height},
        {
            "distribution": virocon.LogNormalDistribution(),
            "conditional_on": 0,
            "parameters": {
                "mu": virocon.DependenceFunction(lambda x, a, b, c: a + b * x**c),
                "sigma": virocon.DependenceFunction(lambda x, a, b, c: a + b * np.exp(c * x)),
            },
        },
    ]
    theirs = virocon.GlobalHierarchicalModel(descriptions)
    for key, values in (("mu", mu), ("sigma", sigma)):
        theirs.distributions[1].conditional_parameters[key].parameters = dict(zip("abc", values, strict=True))
    ours = JointModel(
        variables=(
            Variable(
                name=HEIGHT,
                family="weibull",
                parameters={"scale": constant(1.1), "shape": constant(1.25), "location": constant(0.15)},
            ),
            Variable(
                name=PERIOD,
                family="lognormal",
                parameters={
                    "mean_log": power(*mu, HEIGHT),
                    "std_log": Dependence(form="exponential", coefficients=sigma, given=HEIGHT),
                },
            ),
        )
    )
    alpha = virocon.calculate_alpha(1, 50)
    line = iform_contour(ours, stats.norm.isf(alpha), 1801)
    for point in virocon.IFORMContour(theirs, alpha, n_points=90).coordinates:
        # 1801 points: their chords stay within 2e-6 of the line
        assert _distance(line, point) < 1e-4 * np.linalg.norm(point)
    line = highest_density_contour(ours, 1e-2, 721)
    for point in virocon.HighestDensityContour(theirs, 1e-2, limits=[(0, 8), (0, 16)], deltas=[0.05, 0.05]).coordinates:
        # their contour follows the cells of a grid of 0.05 m and 0.05 s
        assert _distance(line, point) < 0.075


def _distance(line, point) -> float:
    """Return the distance of a point to a closed line of points."""
    along = np.diff(line, axis=0)
    share = np.clip(np.sum((point - line[:-1]) * along, axis=1) / np.maximum(np.sum(along**2, axis=1), 1e-300), 0, 1)
    return float(np.linalg.norm(point - line[:-1] - share[:, None] * along, axis=1).min())
