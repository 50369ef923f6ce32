"""Contours of two quantities, from records that have no more: waves alone, or wind and wave height."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fowtio.errors import ModelError
from fowtio.read.metocean import Metocean, read_metocean
from fowtio.site import describe_report
from model.environment.contours import (
    exceedance_probability,
    highest_density_contour,
    iform_contour,
    reliability_index,
    sampled_contour,
)
from model.environment.joint import HEIGHT, PERIOD, WIND
from model.environment.metocean import Fit, VariableForm, fit_joint, thesis_form

CROSSING = "zero_crossing_period"
PAIRS = ((WIND, HEIGHT), (HEIGHT, PERIOD), (HEIGHT, CROSSING))
METHODS = ("iform", "highest_density", "direct_sampling")
_LEAST = 500


@dataclass(frozen=True, eq=False, kw_only=True)
class PlaneStudy:
    """Contours (n, 2) of two quantities by method, the fit behind them, the states and the record it was fitted to."""

    names: tuple[str, str]
    return_period: float
    beta: float
    contours: Mapping[str, np.ndarray]
    fit: Fit
    states: Mapping[str, np.ndarray]
    record: Metocean
    notes: tuple[str, ...]


def plane_record(name: str | Path) -> tuple[Metocean, tuple[str, str]] | None:
    """Return a record and its two quantities when it has no three that make a site; None for anything else."""
    path = Path(name)
    if not path.is_file() or path.suffix.lower() == ".site":
        return None
    record = read_metocean(path)
    if {WIND, HEIGHT, PERIOD} <= set(record.values):
        return None
    for pair in PAIRS:
        if set(pair) <= set(record.values):
            return record, pair
    return None


def plane_study(
    record: Metocean,
    names: tuple[str, str],
    return_period: float = 50.0,
    *,
    wind: str = "exponentiated",
    method: str = "likelihood",
    contours: tuple[str, ...] = METHODS,
    seed: int = 1,
    progress: Callable[[str], None] = lambda text: None,
) -> PlaneStudy:
    """Return the contours of two quantities of a record.

    Parameters
    ----------
    record, names : what was measured and which two quantities of it, the first one given nothing
    return_period : [years]
    wind, method : as in `thesis_form` and `fit_joint`
    contours : of METHODS
    seed : of the direct sampling
    progress : told what is being done

    Raises
    ------
    ModelError : too few complete states, values that no distribution has, a return period too short.
    """
    rows = record.complete(*names)
    if len(rows) < _LEAST:
        words = describe_report(record.report)
        raise ModelError(
            f"{record.source}: {len(rows)} states have {' and '.join(names)}; {_LEAST} are needed ({words})"
        )
    states = {name: rows[:, k] for k, name in enumerate(names)}
    hours = record.report.step / 3600 or 1.0
    try:
        fit = fit_joint(states, pair_forms(names, wind), method)
        beta = reliability_index(return_period, hours)
    except ValueError as error:
        raise ModelError(f"{record.source}: {error}") from None
    probability = exceedance_probability(beta)
    make = {
        "iform": lambda: iform_contour(fit.model, beta, 181),
        "highest_density": lambda: highest_density_contour(fit.model, probability),
        "direct_sampling": lambda: sampled_contour(fit.model, probability, np.random.default_rng(seed)),
    }
    found, notes = {}, [f"beta = {beta:.4g} for {return_period:g} years of states of {hours:g} h"]
    for name in contours:
        progress(f"contour: {name.replace('_', ' ')}")
        try:
            found[name] = make[name]()
        except ValueError as error:
            notes.append(f"no {name.replace('_', ' ')} contour: {error}")
    return PlaneStudy(
        names=names,
        return_period=return_period,
        beta=beta,
        contours=found,
        fit=fit,
        states=states,
        record=record,
        notes=(*notes, f"{record.report.rows} rows: {describe_report(record.report)}", *record.report.notes),
    )


def pair_forms(names: tuple[str, str], wind: str) -> tuple[VariableForm, ...]:
    """Return what is fitted to two quantities: the thesis's wind and Hs given it, or Hs and a lognormal period given it.

    Hs alone is a three-parameter Weibull, the period's mean of logarithms a power and its deviation an exponential of
    Hs (DNV-RP-C205, section 3.6).
    """
    if names == (WIND, HEIGHT):
        return thesis_form(wind)[:2]
    height = VariableForm(
        name=HEIGHT, family="weibull", forms={"scale": "constant", "shape": "constant", "location": "constant"}
    )
    period = VariableForm(
        name=names[1],
        family="lognormal",
        forms={"mean_log": "power", "std_log": "exponential"},
        given=HEIGHT,
        fixed={("std_log", 0): 0.005},
    )
    return height, period
