"""The likelihood of a distribution's coefficients, climbed with the derivatives of every state, and its bootstrap."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from model.environment.fit_starts import ANY_SIGN, VariableForm
from model.environment.joint import (
    FORMS,
    Dependence,
    Variable,
    constant,
    family_log_density,
    family_score,
    form_gradient,
    form_value,
)

_STEPS = 200


class Likelihood:
    """The likelihood of one variable's coefficients, with its derivatives state by state.

    It works in coordinates in which the likelihood is nearly quadratic: a form c1 + c2 g(x)^c3 that is nearly
    logarithmic has huge c1 and c2 that all but cancel, so (value at a middle x0, slope there, c3) stand for (c1, c2,
    c3) where all three are free.
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
        self.turned = [
            p
            for p in self.names
            if form.forms[p] in ("power", "exponential") and not any(key[0] == p for key in form.fixed)
        ]
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
            out[p] = (
                _middle_value(kind, part, self.given, self.middle)
                if p in self.turned
                else form_value(kind, part, self.given)
            )
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
            out[p] = (
                constant(part[0])
                if kind == "constant"
                else Dependence(form=kind, coefficients=part, given=self.form.given)
            )
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
            while (
                _out_of_range(self.parameters(t)) and share > 1e-3
            ):  # a step out of the range is taken back part of the way
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
    """Return the coefficients of a form from its value, slope and c3; c3 is kept off zero, where the form is a
    logarithm.
    """
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
    return any(np.any(~(v > 0)) for name, v in p.items() if name not in ANY_SIGN)
