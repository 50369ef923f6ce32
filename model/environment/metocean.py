"""Fits of joint distributions to metocean records, how good they are, and how sure.

Every variable is fitted by itself, given at most one other. Maximum likelihood works on all states at once: the derivatives
of each state's log-likelihood with respect to all coefficients give both the steps (Berndt et al. 1974, with Levenberg's
damping) and the bootstrap. Weighted least squares fits quantiles, the large ones most (Haselsteiner and Thoben 2020,
Ocean Eng. 212:107576), and coefficients over classes of the other variable, as the source thesis does in chapter 7.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.special import kolmogorov, ndtr, ndtri

from model.conventions import freeze
from model.environment.joint import (
    FORMS, HEIGHT, PERIOD, WIND, Dependence, JointModel, Variable, constant, family_log_density, family_score, form_gradient, form_value,
    log_density, parameters_at, variable_from_normal, variable_to_normal,
)  # fmt: skip

METHODS = ("likelihood", "least_squares")
CLASS_WIDTH = {WIND: 1.0, HEIGHT: 0.25}
_EXPONENTS = np.concatenate([np.linspace(-2, -0.05, 14), np.linspace(0.05, 5, 34)])
_STEPS = 200
_ANY_SIGN = ("mean_log", "location")


@dataclass(frozen=True, eq=False, kw_only=True)
class VariableForm:
    """What to fit to one variable.

    Parameters
    ----------
    name : of the variable
    family : distribution, as in `Variable`
    forms : form of each parameter, as in `Dependence`
    given : name of the variable that forms other than "constant" depend on
    fixed : values of coefficients that are known, by (parameter, place from 0)
    """

    name: str
    family: str
    forms: Mapping[str, str]
    given: str | None = None
    fixed: Mapping[tuple[str, int], float] = field(default_factory=dict)


@dataclass(frozen=True, eq=False, kw_only=True)
class Goodness:
    """How well a distribution fits: log-likelihood, number of free coefficients, Akaike's criterion, the Kolmogorov-Smirnov
    distance and the probability of a larger one (states taken as independent, which hours are not), and for a QQ plot the
    quantiles (p) of the model and of the data; of a conditional variable both in standard normal variables.
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
class Classes:
    """Separate fits in classes of the given variable: centre (c), states in each (c), each parameter (c) by name, and the
    span (2) of the given variable over all states, those outside every class too.
    """

    centre: np.ndarray
    count: np.ndarray
    parameters: Mapping[str, np.ndarray]
    span: np.ndarray


@dataclass(frozen=True, eq=False, kw_only=True)
class FittedVariable:
    """One fitted variable: the distribution, its form, how good it is, the classes of a conditional one (else None), method."""

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

    wind: "two_parameter", "three_parameter" or "exponentiated" Weibull; zero_offset leaves the constant out of the variance of
    ln Tp (eq. 7.12). Raises ValueError for another wind.
    """
    extra = {"two_parameter": {}, "three_parameter": {"location": "constant"}, "exponentiated": {"exponent": "constant"}}
    if wind not in extra:
        raise ValueError(f"unknown wind distribution {wind!r}; use one of {', '.join(extra)}")
    weibull = {"scale": "constant", "shape": "constant"}
    return (
        VariableForm(name=WIND, family="weibull", forms=weibull | extra[wind]),
        VariableForm(name=HEIGHT, family="weibull", forms={"scale": "power", "shape": "power"}, given=WIND),
        VariableForm(
            name=PERIOD, family="lognormal_variance", forms={"mean_log": "power", "variance_log": "exponential"}, given=HEIGHT,
            fixed={("variance_log", 0): 0.0} if zero_offset else {},
        ),
    )  # fmt: skip


def fit_joint(states: Mapping[str, np.ndarray], forms: Sequence[VariableForm], method: str = "likelihood", widths: Mapping[str, float] | None = None) -> Fit:
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
    return Fit(model=JointModel(variables=tuple(f.variable for f in fitted)), variables=tuple(fitted), count=next(iter(lengths.values())))


def fit_variable(form: VariableForm, x, given=None, method: str = "likelihood", width: float | None = None) -> FittedVariable:
    """Return one variable fitted to values x (n), given those of another (n) where the form depends on it.

    width is that of the classes. Raises ValueError for values that the distribution cannot have, or that do not vary.
    """
    x = _checked(form.name, x)
    given = _checked(form.given, given) if form.given else None
    classes = None if given is None else classify(form, x, given, method, width)
    if classes is None:
        start = _marginal_start(form, x, method)
    else:
        start = {p: _fit_form(form, p, classes) for p in form.forms}
    engine = _Likelihood(form, x, given, start)
    if method == "likelihood" and "location" not in form.forms:
        engine.maximise()
    variable = engine.variable()
    return FittedVariable(variable=variable, form=form, goodness=goodness(variable, x, given, engine.free), classes=classes, method=method)


def classify(form: VariableForm, x, given, method: str = "likelihood", width: float | None = None, least: int = 30) -> Classes:
    """Return separate fits of a variable in classes of another: those with at least `least` states.

    Raises ValueError when fewer than three classes have enough.
    """
    width = width or float(np.ptp(given)) / 40
    number = np.floor(given / width + 0.5).astype(int) if form.given == WIND else np.floor(given / width).astype(int)
    order = np.argsort(number, kind="stable")
    labels, start = np.unique(number[order], return_index=True)
    groups = [g for g in np.split(order, start[1:]) if len(g) >= least and np.ptp(x[g]) > 0]
    if len(groups) < 3:
        raise ValueError(f"{form.name}: only {len(groups)} classes of {form.given} of width {width:g} have {least} states or more; three are needed")
    plain = VariableForm(name=form.name, family=form.family, forms=dict.fromkeys(form.forms, "constant"), fixed={
        key: value for key, value in form.fixed.items() if form.forms[key[0]] == "constant"
    })  # fmt: skip
    found = [_marginal_start(plain, x[g], method) for g in groups]
    return Classes(
        centre=np.array([given[g].mean() for g in groups]), count=np.array([len(g) for g in groups]),
        parameters={p: np.array([f[p][0] for f in found]) for p in form.forms}, span=np.array([given.min(), given.max()]),
    )  # fmt: skip


def goodness(variable: Variable, x, given=None, free: int | None = None, points: int = 400) -> Goodness:
    """Return how well a distribution fits values x (n), given those of another (n); free coefficients default to all of them."""
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
        log_likelihood=total, free=free, aic=2 * free - 2 * total, ks_distance=distance,
        ks_probability=float(kolmogorov(np.sqrt(n) * distance)), model_quantiles=theory, data_quantiles=data,
    )  # fmt: skip


def bootstrap(fit: Fit, states: Mapping[str, np.ndarray], count: int = 200, block: int = 1, seed: int = 0) -> tuple[JointModel, ...]:
    """Return joint distributions fitted to resampled states, for intervals of anything that follows from them.

    Blocks of `block` consecutive states are drawn with replacement (1: independent states; hourly records need days). Each
    replicate is one Newton step from the fit, with each state weighted by how often it was drawn: exact to first order in
    the deviation, and cheap (the one-step bootstrap). A location is kept.

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
    drawn = np.stack([np.bincount(rng.integers(blocks, size=blocks), minlength=blocks) for _ in range(count)]).astype(float)
    replicates = []
    for v in fit.variables:
        given = states[v.form.given] if v.form.given else None
        start = {p: v.variable.parameters[p].coefficients for p in v.form.forms}
        engine = _Likelihood(v.form, np.asarray(states[v.form.name], dtype=float), given, start)
        replicates.append(engine.replicates(drawn, block))
    return tuple(JointModel(variables=chain) for chain in zip(*replicates, strict=True))


def interval(values, level: float = 0.95) -> np.ndarray:
    """Return the bounds (2, ...) of the central interval of replicates (count, ...)."""
    return np.quantile(np.asarray(values, dtype=float), [(1 - level) / 2, (1 + level) / 2], axis=0)


def coefficients(variable: Variable) -> np.ndarray:
    """Return all coefficients of a variable in one row, parameter by parameter."""
    return np.concatenate([d.coefficients for d in variable.parameters.values()])


# --- starting values and least squares --------------------------------------------------------------------------------


def _checked(name: str, x) -> np.ndarray:
    """Return values as they can be fitted; raise ValueError saying what is wrong and how often."""
    x = np.asarray(x, dtype=float)
    if x.ndim != 1 or len(x) < 10:
        raise ValueError(f"{name}: {x.size} values are too few for a fit")
    bad, negative = int((~np.isfinite(x)).sum()), int((x < 0).sum())
    if bad or negative:
        raise ValueError(f"{name}: {bad} values are not finite and {negative} are negative; take these states out first")
    if not np.ptp(x) > 0:
        raise ValueError(f"{name} is {x[0]:g} throughout; a constant column has no distribution")
    return np.maximum(x, 1e-9 * x.max())


def _marginal_start(form: VariableForm, x, method: str) -> dict[str, tuple[float, ...]]:
    """Return constant parameters for values x (n): maximum likelihood of a Weibull or lognormal, or least squares."""
    if form.family != "weibull":
        log = np.log(x)
        known = {"mean_log": log.mean(), "std_log": log.std(), "variance_log": log.var()}
        out = {p: (float(known[p]),) for p in form.forms}
    elif method == "least_squares":
        out = _weibull_least_squares(form, x)
    else:
        out = _weibull_start(form, x)
    return out | {p: (value,) for (p, _), value in form.fixed.items() if form.forms[p] == "constant"}


def _weibull_start(form: VariableForm, x) -> dict[str, tuple[float, ...]]:
    location = form.fixed.get(("location", 0), 0.0)
    if "location" in form.forms and ("location", 0) not in form.fixed:
        location = _likely_location(x)
    scale, shape = _weibull_likelihood(x - location)
    out = {"scale": (scale,), "shape": (shape,)}
    out |= {"location": (location,)} if "location" in form.forms else {}
    return out | ({"exponent": (1.0,)} if "exponent" in form.forms else {})


def _weibull_likelihood(x, steps: int = 40) -> tuple[float, float]:
    """Return scale and shape of a two-parameter Weibull distribution by maximum likelihood: Newton's steps for the shape."""
    top = x.max()
    y = np.maximum(x / top, 1e-12)
    log = np.log(y)
    mean, k = log.mean(), float(np.clip(1.28 / max(log.std(), 1e-6), 0.2, 50.0))
    for _ in range(steps):
        p = y**k
        s0, s1, s2 = p.sum(), (p * log).sum(), (p * log**2).sum()
        error = s1 / s0 - 1 / k - mean
        slope = s2 / s0 - (s1 / s0) ** 2 + 1 / k**2
        change = float(np.clip(error / slope, -k / 2, k))
        k -= change
        if abs(change) < 1e-10 * k:
            break
    return float(top * np.mean(y**k) ** (1 / k)), k


def _likely_location(x) -> float:
    """Return the location of the largest likelihood, the two other parameters at their best for it."""
    least, span = float(x.min()), float(x.mean() - x.min())

    def loss(log_gap):
        location = least - np.exp(log_gap)
        scale, shape = _weibull_likelihood(x - location)
        return -family_log_density("weibull", x, {"scale": scale, "shape": shape, "location": location}).sum()

    # closer to the smallest value than the spacing of values there, the likelihood of a shape below 1 has no bound
    low = np.log(max(span / len(x), 1e-6 * span))
    found = minimize_scalar(loss, bounds=(low, np.log(5 * span)), method="bounded", options={"xatol": 1e-4})
    return least - float(np.exp(found.x))


def _weibull_least_squares(form: VariableForm, x) -> dict[str, tuple[float, ...]]:
    """Return Weibull parameters by least squares of quantiles with weights x^2, the third parameter by search."""
    x = np.sort(x)
    p = (np.arange(len(x)) + 0.5) / len(x)
    free = [q for q in ("location", "exponent") if q in form.forms and (q, 0) not in form.fixed]
    known = {q: form.fixed[q, 0] for q in ("location", "exponent") if (q, 0) in form.fixed}

    def regress(values):
        location, exponent = values.get("location", 0.0), values.get("exponent", 1.0)
        y, z = np.log(x - location), np.log(-np.log1p(-(p ** (1 / exponent))))
        w = x**2 / np.sum(x**2)
        my, mz = w @ y, w @ z
        slope = (w @ ((z - mz) * (y - my))) / (w @ (z - mz) ** 2)
        predicted = location + np.exp(my + slope * (z - mz))
        return float(w @ (predicted - x) ** 2), (float(np.exp(my - slope * mz)), 1 / float(slope))

    if free:
        name = free[0]
        bounds = (np.log(0.05), np.log(50.0)) if name == "exponent" else (np.log(1e-6 * x.mean()), np.log(5 * x.mean()))

        def value(t):
            return float(np.exp(t)) if name == "exponent" else float(x[0] - np.exp(t))

        found = minimize_scalar(lambda t: regress(known | {name: value(t)})[0], bounds=bounds, method="bounded", options={"xatol": 1e-6})
        known |= {name: value(found.x)}
    scale, shape = regress(known)[1]
    return {"scale": (scale,), "shape": (shape,)} | {q: (v,) for q, v in known.items() if q in form.forms}


def _fit_form(form: VariableForm, name: str, classes: Classes) -> tuple[float, ...]:
    """Return the coefficients of a parameter by least squares over classes, weighted by their counts.

    All forms are linear but for the third coefficient, which is scanned and then refined; so there is nothing to start from.
    """
    x, y, w = classes.centre, classes.parameters[name], np.sqrt(classes.count)
    kind = form.forms[name]
    fixed = {k: v for (p, k), v in form.fixed.items() if p == name}
    if kind == "constant":
        return (fixed.get(0, float(np.average(y, weights=classes.count))),)

    least = -np.inf if name in _ANY_SIGN else 0.1 * y.min()

    def solve(third):
        g, ends = (form_value(kind, (0.0, 1.0, third), at) for at in (x, classes.span))
        basis, c = np.stack([np.ones_like(g), g], axis=-1), np.array([fixed.get(0, 0.0), fixed.get(1, 0.0)])
        free = [k for k in (0, 1) if k not in fixed]
        if free:
            c[free] = np.linalg.lstsq(w[:, None] * basis[:, free], w * (y - basis @ c), rcond=None)[0]
        low = ends[np.argmin(c[0] + c[1] * ends)]  # forms are monotonic: an end of the span decides
        if c[0] + c[1] * low < least and len(free) == 2:
            away = w * (g - low)
            c[1] = (away @ (w * (y - least))) / (away @ away)
            c[0] = least - c[1] * low
        loss = np.sum((w * (y - basis @ c)) ** 2) if np.min(c[0] + c[1] * ends) > 0 or least < 0 else 1e300
        return float(loss), (float(c[0]), float(c[1]), float(third))

    if 2 in fixed:
        return solve(fixed[2])[1]
    scale = 1.0 if kind == "power" else 1 / max(x.mean(), 1e-12)
    grid = np.unique(np.abs(_EXPONENTS)) * scale if kind == "hyperbolic" else _EXPONENTS * scale
    best = int(np.argmin([solve(t)[0] for t in grid]))
    low, high = grid[max(best - 1, 0)], grid[min(best + 1, len(grid) - 1)]
    if low < 0 < high:  # 0 makes a constant of any form
        low, high = (low, -1e-3 * scale) if grid[best] < 0 else (1e-3 * scale, high)
    found = minimize_scalar(lambda t: solve(t)[0], bounds=(low, high), method="bounded", options={"xatol": 1e-8})
    return min(solve(found.x), solve(grid[best]))[1]


# --- likelihood -------------------------------------------------------------------------------------------------------


class _Likelihood:
    """The likelihood of one variable's coefficients, with its derivatives state by state.

    It works in coordinates in which the likelihood is nearly quadratic: a form c1 + c2 g(x)^c3 that is nearly logarithmic has
    huge c1 and c2 that all but cancel, so (value at a middle x0, slope there, c3) stand for (c1, c2, c3) where all three are free.
    """

    def __init__(self, form: VariableForm, x, given, start: Mapping[str, Sequence[float]]):
        self.form, self.x, self.given = form, np.asarray(x, dtype=float), given
        self.middle = None if given is None else float(np.median(given))
        self.names = tuple(form.forms)
        values = [list(start[p]) for p in self.names]
        self.slices = np.cumsum([0] + [len(v) for v in values])
        c = np.concatenate(values).astype(float)
        places = [(p, k) for p in self.names for k in range(FORMS[form.forms[p]])]
        for k, key in enumerate(places):
            c[k] = form.fixed.get(key, c[k])
        held = [key in form.fixed or key[0] == "location" for key in places]
        self.turned = [p for p in self.names if form.forms[p] in ("power", "exponential") and not any(key[0] == p for key in form.fixed)]
        self.moving = np.flatnonzero(~np.array(held))
        self.free = int(np.sum([key not in form.fixed for key in places]))
        self.t = self._turn(c, _to_middle)

    def _turn(self, values, change) -> np.ndarray:
        """Return coefficients in the other coordinates."""
        out = np.array(values, dtype=float)
        for k, p in enumerate(self.names):
            if p in self.turned:
                part = slice(self.slices[k], self.slices[k + 1])
                out[part] = change(self.form.forms[p], out[part], self.middle)
        return out

    def parameters(self, t) -> dict[str, np.ndarray]:
        """Return the parameters of the distribution at every state."""
        out = {}
        for k, p in enumerate(self.names):
            part, kind = t[self.slices[k] : self.slices[k + 1]], self.form.forms[p]
            out[p] = _middle_value(kind, part, self.given, self.middle) if p in self.turned else form_value(kind, part, self.given)
        return out

    def value(self, t) -> float:
        """Return the log-likelihood; minus infinity where a parameter is out of its range."""
        p = self.parameters(t)
        if _out_of_range(p):
            return -np.inf
        total = float(family_log_density(self.form.family, self.x, p).sum())
        return total if np.isfinite(total) else -np.inf

    def scores(self, t) -> np.ndarray:
        """Return the derivatives (n, k) of every state's log-likelihood with respect to the moving coordinates."""
        native = family_score(self.form.family, self.x, self.parameters(t))
        blocks = []
        for k, p in enumerate(self.names):
            part, kind = t[self.slices[k] : self.slices[k + 1]], self.form.forms[p]
            if p in self.turned:
                inner = _middle_gradient(kind, part, self.given, self.middle)
            else:
                inner = form_gradient(kind, part, None if kind == "constant" else self.given)
            blocks.append(np.asarray(native[p])[..., None] * inner)
        return np.concatenate([np.broadcast_to(b, (len(self.x), b.shape[-1])) for b in blocks], axis=1)[:, self.moving]

    def maximise(self) -> None:
        """Climb to the largest likelihood with damped steps."""
        damping, value = 1e-4, self.value(self.t)
        for _ in range(_STEPS):
            s = self.scores(self.t)
            gradient, information = s.sum(axis=0), s.T @ s
            scale = np.sqrt(np.diag(information)) + 1e-300
            for _ in range(30):
                matrix = information / np.outer(scale, scale) + damping * np.eye(len(scale))
                trial = self.t.copy()
                trial[self.moving] += np.linalg.solve(matrix, gradient / scale) / scale
                new = self.value(trial)
                if new > value:
                    break
                damping = max(damping * 6, 1e-8)
            else:
                return
            gain, self.t, value = new - value, trial, new
            damping = max(damping / 6, 1e-10)
            if gain < 1e-7:
                return

    def variable(self, t=None) -> Variable:
        """Return the distribution at coordinates t, by default the best found."""
        c = self._turn(self.t if t is None else t, _from_middle)
        out = {}
        for k, p in enumerate(self.names):
            kind, part = self.form.forms[p], tuple(c[self.slices[k] : self.slices[k + 1]])
            out[p] = constant(part[0]) if kind == "constant" else Dependence(form=kind, coefficients=part, given=self.form.given)
        return Variable(name=self.form.name, family=self.form.family, parameters=out)

    def replicates(self, drawn: np.ndarray, block: int) -> list[Variable]:
        """Return the distribution refitted by one Newton step to each row of block counts (count, blocks)."""
        s = self.scores(self.t)
        gradient = drawn @ np.add.reduceat(s, np.arange(0, len(s), block), axis=0)
        steps = np.linalg.solve(self._curvature(), gradient.T).T
        out = []
        for step in steps:
            t, share = self.t.copy(), 1.0
            t[self.moving] += step
            while _out_of_range(self.parameters(t)) and share > 1e-3:  # a step out of the range is taken back part of the way
                share /= 2
                t[self.moving] = self.t[self.moving] + share * step
            out.append(self.variable(t))
        return out

    def _curvature(self) -> np.ndarray:
        """Return minus the second derivatives of the log-likelihood, by central differences of the gradient."""
        s = self.scores(self.t)
        size = 1e-4 / np.sqrt(np.mean(s**2, axis=0))
        out = np.empty((len(self.moving),) * 2)
        for k, h in enumerate(size):
            ends = []
            for sign in (1, -1):
                t = self.t.copy()
                t[self.moving[k]] += sign * h
                ends.append(self.scores(t).sum(axis=0))
            out[k] = -(ends[0] - ends[1]) / (2 * h)
        return (out + out.T) / 2


def _to_middle(kind: str, c, x0: float) -> np.ndarray:
    """Return (value at x0, slope there with respect to ln x or x, c3) of c1 + c2 x^c3 or c1 + c2 exp(c3 x)."""
    g = form_value(kind, (0.0, 1.0, c[2]), x0)
    return np.array([c[0] + c[1] * g, c[1] * c[2] * g, c[2]])


def _from_middle(kind: str, t, x0: float) -> np.ndarray:
    """Return the coefficients of a form from its value, slope and c3; c3 is kept off zero, where the form is a logarithm."""
    third = t[2] if abs(t[2]) > 1e-6 else 1e-6
    g = form_value(kind, (0.0, 1.0, third), x0)
    return np.array([t[0] - t[1] / third, t[1] / (third * g), third])


def _middle_value(kind: str, t, x, x0: float) -> np.ndarray:
    s = _distance(kind, x, x0)
    return t[0] + t[1] * s * _expm1_ratio(t[2] * s)


def _middle_gradient(kind: str, t, x, x0: float) -> np.ndarray:
    s = _distance(kind, x, x0)
    y = t[2] * s
    ratio = _expm1_ratio(y)
    small = np.abs(y) < 1e-4
    slope = np.where(small, 0.5 + y / 3, (np.exp(y) - ratio) / np.where(small, 1.0, y))
    return np.stack([np.ones_like(s), s * ratio, t[1] * s**2 * slope], axis=-1)


def _distance(kind: str, x, x0: float) -> np.ndarray:
    return np.log(np.maximum(x, 1e-12) / x0) if kind == "power" else np.asarray(x, dtype=float) - x0


def _expm1_ratio(y) -> np.ndarray:
    """Return (e^y - 1)/y, 1 at zero."""
    return np.where(np.abs(y) < 1e-12, 1.0, np.expm1(y) / np.where(y == 0, 1.0, y))


def _out_of_range(p: Mapping[str, np.ndarray]) -> bool:
    """Tell whether a parameter that must be positive is not, at any state."""
    return any(np.any(~(v > 0)) for name, v in p.items() if name not in _ANY_SIGN)


__all__ = [
    "METHODS", "Classes", "Fit", "FittedVariable", "Goodness", "VariableForm", "bootstrap", "classify", "coefficients", "fit_joint",
    "fit_variable", "goodness", "interval", "parameters_at", "thesis_form",
]  # fmt: skip
