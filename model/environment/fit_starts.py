"""First fits of a distribution: constant parameters of values, and forms over classes of another variable.

Least squares with weights and moments of logarithms; what likelihood starts from, and the thesis's own way of fitting.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import minimize_scalar

from model.environment.joint import family_log_density, form_value

ANY_SIGN = ("mean_log", "location")
_EXPONENTS = np.concatenate([np.linspace(-2, -0.05, 14), np.linspace(0.05, 5, 34)])


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
class Classes:
    """Separate fits in classes of the given variable: centre (c), states in each (c), each parameter (c) by name, and
    the span (2) of the given variable over all states, those outside every class too.
    """

    centre: np.ndarray
    count: np.ndarray
    parameters: Mapping[str, np.ndarray]
    span: np.ndarray


def checked_values(name: str, x) -> np.ndarray:
    """Return values as they can be fitted; raise ValueError saying what is wrong and how often."""
    x = np.asarray(x, dtype=float)
    if x.ndim != 1 or len(x) < 10:
        raise ValueError(f"{name}: {x.size} values are too few for a fit")
    bad, negative = int((~np.isfinite(x)).sum()), int((x < 0).sum())
    if bad or negative:
        raise ValueError(
            f"{name}: {bad} values are not finite and {negative} are negative; take these states out first"
        )
    if not np.ptp(x) > 0:
        raise ValueError(f"{name} is {x[0]:g} throughout; a constant column has no distribution")
    return np.maximum(x, 1e-9 * x.max())


def constant_fit(form: VariableForm, x, method: str) -> dict[str, tuple[float, ...]]:
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
    """Return scale and shape of a two-parameter Weibull distribution by maximum likelihood: Newton's steps for the
    shape.
    """
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

        found = minimize_scalar(
            lambda t: regress(known | {name: value(t)})[0], bounds=bounds, method="bounded", options={"xatol": 1e-6}
        )
        known |= {name: value(found.x)}
    scale, shape = regress(known)[1]
    return {"scale": (scale,), "shape": (shape,)} | {q: (v,) for q, v in known.items() if q in form.forms}


def fit_form(form: VariableForm, name: str, classes: Classes) -> tuple[float, ...]:
    """Return the coefficients of a parameter by least squares over classes, weighted by their counts.

    All forms are linear but for the third coefficient, which is scanned and then refined; so there is nothing to start
    from.
    """
    x, y, w = classes.centre, classes.parameters[name], np.sqrt(classes.count)
    kind = form.forms[name]
    fixed = {k: v for (p, k), v in form.fixed.items() if p == name}
    if kind == "constant":
        return (fixed.get(0, float(np.average(y, weights=classes.count))),)

    least = -np.inf if name in ANY_SIGN else 0.1 * y.min()

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
