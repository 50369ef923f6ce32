"""Joint distributions of sea and wind: a chain of variables, each given at most one before it.

A chain is what the Rosenblatt transformation needs: with u = Phi^-1(F(x | what it is given)), variable by variable, the
states become independent standard normal variables (Rosenblatt 1952, Ann. Math. Stat. 23:470). Distributions are
written directly between x and u, through logarithms of probabilities, so that states of 10 000 years keep their digits.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
from scipy.special import log_ndtr, ndtri_exp

FORMS = {"constant": 1, "power": 3, "exponential": 3, "hyperbolic": 3}
FAMILIES = {
    "weibull": (("scale", "shape"), {"location": 0.0, "exponent": 1.0}),
    "lognormal": (("mean_log", "std_log"), {}),
    "lognormal_variance": (("mean_log", "variance_log"), {}),
}
WIND, HEIGHT, PERIOD = "wind_speed", "significant_height", "peak_period"
UNITS = {WIND: "m/s", HEIGHT: "m", PERIOD: "s", "zero_crossing_period": "s", "turbulence": "m/s"}
_TINY = np.finfo(float).tiny


@dataclass(frozen=True, eq=False, kw_only=True)
class Dependence:
    """How a parameter of a distribution follows from another variable x.

    Parameters
    ----------
    form : "constant" c1, "power" c1 + c2 x^c3, "exponential" c1 + c2 exp(c3 x), or "hyperbolic" c1 + c2 / (1 + c3 x)
    coefficients : c1, c2, c3
    given : name of the variable x; None with "constant"

    Raises
    ------
    ValueError : an unknown form, or coefficients that do not fit it.
    """

    form: str
    coefficients: tuple[float, ...]
    given: str | None = None

    def __post_init__(self):
        if self.form not in FORMS:
            raise ValueError(f"unknown form {self.form!r}; use one of {', '.join(FORMS)}")
        values = tuple(float(c) for c in self.coefficients)
        if len(values) != FORMS[self.form] or not np.isfinite(values).all():
            raise ValueError(f"the {self.form} form needs {FORMS[self.form]} finite coefficients, not {values}")
        if (self.given is None) != (self.form == "constant"):
            raise ValueError(
                f"the {self.form} form {'depends on nothing' if self.given else 'needs the name of what it depends on'}"
            )
        object.__setattr__(self, "coefficients", values)

    def __call__(self, x=None) -> np.ndarray:
        """Return the parameter at x (...)."""
        return form_value(self.form, self.coefficients, x)


def constant(value: float) -> Dependence:
    """Return a parameter that depends on nothing."""
    return Dependence(form="constant", coefficients=(value,))


def form_value(form: str, c, x=None) -> np.ndarray:
    """Return a form with coefficients c at x (...)."""
    if form == "constant":
        return np.asarray(c[0], dtype=float)
    x = np.asarray(x, dtype=float)
    if form == "power":
        return c[0] + c[1] * np.maximum(x, 0.0) ** c[2]
    if form == "exponential":
        return c[0] + c[1] * np.exp(c[2] * x)
    return c[0] + c[1] / (1 + c[2] * x)


def form_gradient(form: str, c, x=None, count: int = 1) -> np.ndarray:
    """Return the derivatives (n, k) of a form with respect to its coefficients at x (n); count is n for a constant."""
    if form == "constant":
        return np.ones((count, 1))
    x = np.asarray(x, dtype=float)
    one = np.ones_like(x)
    if form == "power":
        g = np.maximum(x, 0.0) ** c[2]
        return np.stack([one, g, c[1] * g * np.log(np.maximum(x, _TINY))], axis=-1)
    if form == "exponential":
        g = np.exp(c[2] * x)
        return np.stack([one, g, c[1] * x * g], axis=-1)
    g = 1 / (1 + c[2] * x)
    return np.stack([one, g, -c[1] * x * g**2], axis=-1)


@dataclass(frozen=True, eq=False, kw_only=True)
class Variable:
    """One variable of a joint distribution.

    Parameters
    ----------
    name : wind_speed, significant_height, peak_period, ... ; unit for people
    family : "weibull" (scale, shape, and if not 0 and 1 location and exponent: F = (1 - exp(-((x -
        location)/scale)^shape))^exponent), "lognormal" (mean_log, std_log) or "lognormal_variance" (mean_log,
        variance_log)
    parameters : Dependence by the name of the parameter

    Raises
    ------
    ValueError : an unknown family, a parameter missing or of no use, or parameters given different variables.
    """

    name: str
    family: str
    parameters: Mapping[str, Dependence]
    unit: str = field(default="")

    def __post_init__(self):
        if self.family not in FAMILIES:
            raise ValueError(f"{self.name}: unknown distribution {self.family!r}; use one of {', '.join(FAMILIES)}")
        needed, optional = FAMILIES[self.family]
        missing = [p for p in needed if p not in self.parameters]
        unused = [p for p in self.parameters if p not in needed and p not in optional]
        if missing or unused:
            raise ValueError(
                f"{self.name}: a {self.family} distribution has {', '.join(needed + tuple(optional))}; "
                + (f"{' and '.join(missing)} missing" if missing else f"{' and '.join(unused)} is not among them")
            )
        if len(self.given) > 1:
            raise ValueError(
                f"{self.name}: its parameters depend on {' and '.join(self.given)}; one of them is what fowtio models"
            )
        object.__setattr__(self, "parameters", MappingProxyType(dict(self.parameters)))
        object.__setattr__(self, "unit", self.unit or UNITS.get(self.name, ""))

    @property
    def given(self) -> tuple[str, ...]:
        """Names of what it depends on: none or one."""
        return tuple(dict.fromkeys(d.given for d in self.parameters.values() if d.given is not None))


@dataclass(frozen=True, eq=False, kw_only=True)
class JointModel:
    """A joint distribution: variables in the order of the chain, each given none or one of those before it."""

    variables: tuple[Variable, ...]

    def __post_init__(self):
        known: list[str] = []
        for v in self.variables:
            for name in v.given:
                if name not in known:
                    raise ValueError(
                        f"{v.name} depends on {name}, which does not come before it ({', '.join(known) or 'nothing does'})"
                    )
            if v.name in known:
                raise ValueError(f"two variables are named {v.name}")
            known.append(v.name)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the variables in order."""
        return tuple(v.name for v in self.variables)

    def index(self, name: str) -> int:
        """Return the place of a variable; raise ValueError with the known names."""
        if name not in self.names:
            raise ValueError(f"no variable {name}; there are {', '.join(self.names)}")
        return self.names.index(name)


def parameters_at(variable: Variable, given=None) -> dict[str, np.ndarray]:
    """Return the parameters of a variable by name, at values (...) of what it is given."""
    return {name: d(given if d.given else None) for name, d in variable.parameters.items()}


def to_standard(model: JointModel, x) -> np.ndarray:
    """Return the independent standard normal variables (..., d) of states x (..., d); outside a distribution they are
    infinite.
    """
    x = np.asarray(x, dtype=float)
    out = np.empty_like(x)
    for k, variable in enumerate(model.variables):
        out[..., k] = variable_to_normal(variable, x[..., k], _given(model, variable, x))
    return out


def to_physical(model: JointModel, u) -> np.ndarray:
    """Return the states x (..., d) of independent standard normal variables u (..., d)."""
    u = np.asarray(u, dtype=float)
    out = np.empty_like(u)
    for k, variable in enumerate(model.variables):
        out[..., k] = variable_from_normal(variable, u[..., k], _given(model, variable, out))
    return out


def density(model: JointModel, x) -> np.ndarray:
    """Return the joint density at states x (..., d), per product of the units."""
    x = np.asarray(x, dtype=float)
    log = 0.0
    for k, variable in enumerate(model.variables):
        log = log + log_density(variable, x[..., k], _given(model, variable, x))
    return np.exp(log)


def sample(model: JointModel, count: int, rng: np.random.Generator) -> np.ndarray:
    """Return `count` independent states (count, d)."""
    return to_physical(model, rng.standard_normal((count, len(model.variables))))


def _given(model: JointModel, variable: Variable, x):
    return x[..., model.index(variable.given[0])] if variable.given else None


def variable_to_normal(variable: Variable, x, given=None) -> np.ndarray:
    """Return the standard normal variable of a value x (...) given another (...)."""
    p = parameters_at(variable, given)
    x = np.asarray(x, dtype=float)
    with np.errstate(divide="ignore", invalid="ignore"):
        if variable.family != "weibull":
            return np.where(x > 0, (np.log(np.maximum(x, _TINY)) - p["mean_log"]) / _std(p), -np.inf)
        y = np.maximum(x - p.get("location", 0.0), 0.0) / p["scale"]
        log_cdf = p.get("exponent", 1.0) * _log_of_rest(-(y ** p["shape"]))
        upper = log_cdf > np.log(0.5)
        low = ndtri_exp(np.where(upper, np.log(0.5), log_cdf))
        high = -ndtri_exp(np.where(upper, _log_of_rest(np.where(upper, log_cdf, -1.0)), np.log(0.5)))
        return np.where(upper, high, low)


def variable_from_normal(variable: Variable, u, given=None) -> np.ndarray:
    """Return the value of a standard normal variable u (...) given another value (...)."""
    p = parameters_at(variable, given)
    u = np.asarray(u, dtype=float)
    if variable.family != "weibull":
        return np.exp(p["mean_log"] + _std(p) * u)
    with np.errstate(divide="ignore"):
        z = -_log_of_rest(log_ndtr(u) / p.get("exponent", 1.0))
    return p.get("location", 0.0) + p["scale"] * np.maximum(z, 0.0) ** (1 / p["shape"])


def log_density(variable: Variable, x, given=None) -> np.ndarray:
    """Return the logarithm of the density of a value x (...) given another (...), minus infinity where there is
    none.
    """
    return family_log_density(variable.family, np.asarray(x, dtype=float), parameters_at(variable, given))


def family_log_density(family: str, x, p: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return the logarithm of a density at x (...) with parameters p (...); minus infinity outside its range."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        if family != "weibull":
            std = _std(p)
            log_x = np.log(np.maximum(x, _TINY))
            out = -0.5 * ((log_x - p["mean_log"]) / std) ** 2 - np.log(std) - log_x - 0.5 * np.log(2 * np.pi)
            return np.where(x > 0, out, -np.inf)
        y = (x - p.get("location", 0.0)) / p["scale"]
        log_y = np.log(np.where(y > 0, y, 1.0))
        z = np.exp(p["shape"] * log_y)
        out = np.log(p["shape"] / p["scale"]) + (p["shape"] - 1) * log_y - z
        if "exponent" in p:
            out = out + np.log(p["exponent"]) + (p["exponent"] - 1) * _log_of_rest(-z)
        return np.where(y > 0, out, -np.inf)


def family_score(family: str, x, p: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the derivatives (...) of `family_log_density` with respect to each parameter."""
    if family != "weibull":
        std = _std(p)
        r = (np.log(x) - p["mean_log"]) / std
        out = {"mean_log": r / std}
        if "std_log" in p:
            return out | {"std_log": (r**2 - 1) / std}
        return out | {"variance_log": (r**2 - 1) / (2 * std**2)}
    k, lift = p["shape"], p.get("exponent", 1.0) - 1
    away = x - p.get("location", 0.0)
    log_y = np.log(away / p["scale"])
    z = np.exp(k * log_y)
    if "exponent" not in p:
        t = z - 1
        log_lower = 0.0
    else:
        t = z - 1 - lift * np.where(z > 0, z / np.where(z > 0, np.expm1(np.minimum(z, 700.0)), 1.0), 1.0)
        log_lower = _log_of_rest(-z)
    out = {"scale": k * t / p["scale"], "shape": (1 / k - log_y * t)}
    if "exponent" in p:
        out["exponent"] = 1 / p["exponent"] + log_lower
    if "location" in p:
        out["location"] = (k * t + 1) / away
    return out


def _std(p: Mapping[str, np.ndarray]) -> np.ndarray:
    return p["std_log"] if "std_log" in p else np.sqrt(p["variance_log"])


def _log_of_rest(t) -> np.ndarray:
    """Return ln(1 - e^t) of negative t (...) without loss of digits at either end."""
    t = np.asarray(t, dtype=float)
    near = t > -0.7
    return np.where(near, np.log(-np.expm1(np.where(near, t, -1.0))), np.log1p(-np.exp(np.where(near, -1.0, t))))
