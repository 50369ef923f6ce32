"""Fits of joint distributions to metocean records, how good they are, and how sure.

Every variable is fitted by itself, given at most one other. Maximum likelihood works on all states at once: the
derivatives of each state's log-likelihood with respect to all coefficients give both the steps (Berndt et al. 1974,
with Levenberg's damping) and the bootstrap. Weighted least squares fits quantiles, the large ones most (Haselsteiner
and Thoben 2020, Ocean Eng. 212:107576), and coefficients over classes of the other variable, as the source thesis does
in chapter 7.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import kolmogorov, ndtr, ndtri

from model.conventions import freeze
from model.environment.fit_starts import Classes, VariableForm, checked_values, constant_fit, fit_form
from model.environment.joint import (
    HEIGHT,
    PERIOD,
    WIND,
    JointModel,
    Variable,
    log_density,
    parameters_at,
    variable_from_normal,
    variable_to_normal,
)
from model.environment.likelihood import Likelihood

METHODS = ("likelihood", "least_squares")
CLASS_WIDTH = {WIND: 1.0, HEIGHT: 0.25}


@dataclass(frozen=True, eq=False, kw_only=True)
class Goodness:
    """How well a distribution fits: log-likelihood, number of free coefficients, Akaike's criterion, the
    Kolmogorov-Smirnov distance and the probability of a larger one (states taken as independent, which hours are not),
    and for a QQ plot the quantiles (p) of the model and of the data; of a conditional variable both in standard normal
    variables.
    """

    log_likelihood: float
    free: int
    aic: float
    ks_distance: float
    ks_probability: float
    model_quantiles: np.ndarray
    data_quantiles: np.ndarray

    def __post_init__(self):
        freeze(self, model_quantiles=("p",), data_quantiles=("p",))


@dataclass(frozen=True, eq=False, kw_only=True)
class FittedVariable:
    """One fitted variable: the distribution, its form, how good it is, the classes of a conditional one (else None),
    method.
    """

    variable: Variable
    form: VariableForm
    goodness: Goodness
    classes: Classes | None
    method: str


@dataclass(frozen=True, eq=False, kw_only=True)
class Fit:
    """A fitted joint distribution: model, its variables, and how many states it was fitted to."""

    model: JointModel
    variables: tuple[FittedVariable, ...]
    count: int


def thesis_form(wind: str = "exponentiated", zero_offset: bool = True) -> tuple[VariableForm, ...]:
    """Return the chain of the source thesis, section 7.3: wind speed, Hs given it, Tp given Hs.

    wind: "two_parameter", "three_parameter" or "exponentiated" Weibull; zero_offset leaves the constant out of the
    variance of ln Tp (eq. 7.12). Raises ValueError for another wind.
    """
    extra = {
        "two_parameter": {},
        "three_parameter": {"location": "constant"},
        "exponentiated": {"exponent": "constant"},
    }
    if wind not in extra:
        raise ValueError(f"unknown wind distribution {wind!r}; use one of {', '.join(extra)}")
    weibull = {"scale": "constant", "shape": "constant"}
    return (
        VariableForm(name=WIND, family="weibull", forms=weibull | extra[wind]),
        VariableForm(name=HEIGHT, family="weibull", forms={"scale": "power", "shape": "power"}, given=WIND),
        VariableForm(
            name=PERIOD,
            family="lognormal_variance",
            forms={"mean_log": "power", "variance_log": "exponential"},
            given=HEIGHT,
            fixed={("variance_log", 0): 0.0} if zero_offset else {},
        ),
    )


def fit_joint(
    states: Mapping[str, np.ndarray],
    forms: Sequence[VariableForm],
    method: str = "likelihood",
    widths: Mapping[str, float] | None = None,
) -> Fit:
    """Return a joint distribution fitted to states.

    Parameters
    ----------
    states : values (n) by name, all of one length, finite
    forms : what to fit, in the order of the chain
    method : "likelihood" or "least_squares"
    widths : width of classes by the name of the given variable, default CLASS_WIDTH (else a fortieth of the range)

    Returns
    -------
    Fit

    Raises
    ------
    ValueError : a variable missing, values that no distribution has, too few states, a method unknown.
    """
    if method not in METHODS:
        raise ValueError(f"unknown method {method!r}; use one of {', '.join(METHODS)}")
    lengths = {name: len(values) for name, values in states.items()}
    missing = [f.name for f in forms if f.name not in states]
    if missing or len(set(lengths.values())) != 1:
        raise ValueError(f"states hold {lengths}; the fit needs {', '.join(f.name for f in forms)}, all of one length")
    fitted = []
    for form in forms:
        given = states[form.given] if form.given else None
        width = (widths or {}).get(form.given or "", CLASS_WIDTH.get(form.given or ""))
        fitted.append(fit_variable(form, states[form.name], given, method, width))
    return Fit(
        model=JointModel(variables=tuple(f.variable for f in fitted)),
        variables=tuple(fitted),
        count=next(iter(lengths.values())),
    )


def fit_variable(
    form: VariableForm, x, given=None, method: str = "likelihood", width: float | None = None
) -> FittedVariable:
    """Return one variable fitted to values x (n), given those of another (n) where the form depends on it.

    width is that of the classes. Raises ValueError for values that the distribution cannot have, or that do not vary.
    """
    x = checked_values(form.name, x)
    given = checked_values(form.given, given) if form.given else None
    classes = None if given is None else classify(form, x, given, method, width)
    if classes is None:
        start = constant_fit(form, x, method)
    else:
        start = {p: fit_form(form, p, classes) for p in form.forms}
    engine = Likelihood(form, x, given, start)
    if method == "likelihood" and "location" not in form.forms:
        engine.maximise()
    variable = engine.variable()
    return FittedVariable(
        variable=variable, form=form, goodness=goodness(variable, x, given, engine.free), classes=classes, method=method
    )


def classify(
    form: VariableForm, x, given, method: str = "likelihood", width: float | None = None, least: int = 30
) -> Classes:
    """Return separate fits of a variable in classes of another: those with at least `least` states.

    Raises ValueError when fewer than three classes have enough.
    """
    width = width or float(np.ptp(given)) / 40
    number = np.floor(given / width + 0.5).astype(int) if form.given == WIND else np.floor(given / width).astype(int)
    order = np.argsort(number, kind="stable")
    _, start = np.unique(number[order], return_index=True)
    groups = [g for g in np.split(order, start[1:]) if len(g) >= least and np.ptp(x[g]) > 0]
    if len(groups) < 3:
        raise ValueError(
            f"{form.name}: only {len(groups)} classes of {form.given} of width {width:g} have {least} states or more; three are needed"
        )
    plain = VariableForm(
        name=form.name,
        family=form.family,
        forms=dict.fromkeys(form.forms, "constant"),
        fixed={key: value for key, value in form.fixed.items() if form.forms[key[0]] == "constant"},
    )
    found = [constant_fit(plain, x[g], method) for g in groups]
    return Classes(
        centre=np.array([given[g].mean() for g in groups]),
        count=np.array([len(g) for g in groups]),
        parameters={p: np.array([f[p][0] for f in found]) for p in form.forms},
        span=np.array([given.min(), given.max()]),
    )


def goodness(variable: Variable, x, given=None, free: int | None = None, points: int = 400) -> Goodness:
    """Return how well a distribution fits values x (n), given those of another (n); free coefficients default to all of
    them.
    """
    x = np.asarray(x, dtype=float)
    n = len(x)
    free = sum(len(d.coefficients) for d in variable.parameters.values()) if free is None else free
    total = float(log_density(variable, x, given).sum())
    u = np.sort(variable_to_normal(variable, x, given))
    p = ndtr(u)
    rank = np.arange(n)
    distance = float(max(np.max((rank + 1) / n - p), np.max(p - rank / n)))
    shares = (np.arange(points) + 0.5) / points
    tail = 1 - np.geomspace(1 / points, 0.5 / n, 60) if n > points else np.array([])
    shares = np.sort(np.concatenate([shares, tail]))
    if given is None:
        theory, data = variable_from_normal(variable, ndtri(shares)), np.quantile(x, shares)
    else:
        theory, data = ndtri(shares), np.quantile(u, shares)
    return Goodness(
        log_likelihood=total,
        free=free,
        aic=2 * free - 2 * total,
        ks_distance=distance,
        ks_probability=float(kolmogorov(np.sqrt(n) * distance)),
        model_quantiles=theory,
        data_quantiles=data,
    )


def bootstrap(
    fit: Fit, states: Mapping[str, np.ndarray], count: int = 200, block: int = 1, seed: int = 0
) -> tuple[JointModel, ...]:
    """Return joint distributions fitted to resampled states, for intervals of anything that follows from them.

    Blocks of `block` consecutive states are drawn with replacement (1: independent states; hourly records need days).
    Each replicate is one Newton step from the fit, with each state weighted by how often it was drawn: exact to first
    order in the deviation, and cheap (the one-step bootstrap). A location is kept.

    Parameters
    ----------
    fit, states : the fit by likelihood and what it was fitted to
    count : replicates
    block : states in a block
    seed : of the random numbers

    Returns
    -------
    (count) joint distributions

    Raises
    ------
    ValueError : the fit was by least squares.
    """
    if any(v.method != "likelihood" for v in fit.variables):
        raise ValueError("the bootstrap needs a fit by likelihood")
    rng, n = np.random.default_rng(seed), fit.count
    blocks = -(-n // block)
    drawn = np.stack([np.bincount(rng.integers(blocks, size=blocks), minlength=blocks) for _ in range(count)]).astype(
        float
    )
    replicates = []
    for v in fit.variables:
        given = states[v.form.given] if v.form.given else None
        start = {p: v.variable.parameters[p].coefficients for p in v.form.forms}
        engine = Likelihood(v.form, np.asarray(states[v.form.name], dtype=float), given, start)
        replicates.append(engine.replicates(drawn, block))
    return tuple(JointModel(variables=chain) for chain in zip(*replicates, strict=True))


def interval(values, level: float = 0.95) -> np.ndarray:
    """Return the bounds (2, ...) of the central interval of replicates (count, ...)."""
    return np.quantile(np.asarray(values, dtype=float), [(1 - level) / 2, (1 + level) / 2], axis=0)


def coefficients(variable: Variable) -> np.ndarray:
    """Return all coefficients of a variable in one row, parameter by parameter."""
    return np.concatenate([d.coefficients for d in variable.parameters.values()])


__all__ = [
    "METHODS",
    "Classes",
    "Fit",
    "FittedVariable",
    "Goodness",
    "VariableForm",
    "bootstrap",
    "classify",
    "coefficients",
    "fit_joint",
    "fit_variable",
    "goodness",
    "interval",
    "parameters_at",
    "thesis_form",
]
