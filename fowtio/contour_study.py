"""Contours of a site: isolines and design points at hub wind speeds, with the fit behind them and how sure it is."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from fowtio.case import Case
from fowtio.errors import FormatError, ModelError
from fowtio.read.metocean import Metocean, read_metocean
from fowtio.site import SUFFIX, Site, load_site, shipped_sites, site_of_record
from fowtio.ultimate import ResponseSearch, contour_search
from model.environment.contours import crest, iform_surface, isoline, level_range, reliability_index
from model.environment.joint import JointModel
from model.environment.metocean import Fit, bootstrap

QUIET = lambda text: None  # noqa: E731
REFERENCE_PERIOD = 1.0  # years: of the fatigue states of the thesis


@dataclass(frozen=True, eq=False, kw_only=True)
class Isoline:
    """One isoline: hub_wind_speed [m/s]; line (n, 3) of hub wind speed, Hs [m], Tp [s]; max_hs and max_tp, the states
    (3) with the largest height and period; max_hs_interval (2) of the bootstrap, None for given distributions.
    """

    hub_wind_speed: float
    line: np.ndarray
    max_hs: np.ndarray
    max_tp: np.ndarray
    max_hs_interval: np.ndarray | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class ContourStudy:
    """The contour of a site: return period [years], beta, isolines, those of one year beside them, the surface (k, l,
    3), range of hub wind speeds, search for the worst state of a response; fit, states and record of a fitted site
    (None of a given one).
    """

    site: Site
    return_period: float
    beta: float
    isolines: tuple[Isoline, ...]
    reference: tuple[Isoline, ...]
    surface: np.ndarray
    hub_range: tuple[float, float]
    search: ResponseSearch | None = None
    fit: Fit | None = None
    states: Mapping[str, np.ndarray] | None = None
    record: Metocean | None = None
    notes: tuple[str, ...] = ()


def contour_study(
    site: Site,
    return_period: float = 50.0,
    speeds: Sequence[float] | None = None,
    *,
    fit: Fit | None = None,
    states: Mapping[str, np.ndarray] | None = None,
    record: Metocean | None = None,
    replicates: int = 100,
    block_days: float = 30.0,
    case: Case | None = None,
    channel: str = "TwrBsMyt",
    progress: Callable[[str], None] = QUIET,
) -> ContourStudy:
    """Return the contour of a site.

    Parameters
    ----------
    site : given, or fitted with fit, states and record
    return_period : [years]
    speeds : hub wind speeds [m/s] of isolines, by default whole ones from cut-in to cut-out
    replicates, block_days : of the bootstrap of a fit by likelihood
    case, channel : study whose worst state on the contour is sought, None for none
    progress : told what is being done

    Raises
    ------
    ModelError : a return period too short, no speed on the contour, a distribution of other variables.
    """
    if len(site.model.variables) != 3:
        raise ModelError(
            f"{site.path}: a contour surface needs wind speed, Hs and Tp; there are {', '.join(site.model.names)}"
        )
    try:
        beta = reliability_index(return_period, site.state_duration)
    except ValueError as error:
        raise ModelError(str(error)) from None
    if speeds is None:
        speeds = [*np.arange(np.ceil(site.cut_in), np.floor(site.cut_out) + 0.5)]
    low, high = (value * site.to_hub for value in level_range(site.model, beta))
    reached = [float(s) for s in speeds if low < s < high]
    if not reached:
        raise ModelError(
            f"the contour goes from {low:.3g} to {high:.3g} m/s at hub height; none of the wind speeds lies on it"
        )
    notes = (
        [f"{len(speeds) - len(reached)} of {len(speeds)} wind speeds lie beyond the contour"]
        if len(reached) < len(speeds)
        else []
    )
    copies: tuple[JointModel, ...] = ()
    if fit is not None and all(v.method == "likelihood" for v in fit.variables):
        progress("bootstrap")
        copies = bootstrap(fit, states, replicates, max(1, round(block_days * 24 / site.state_duration)))
        notes.append(f"intervals: 95 % of {replicates} bootstrap replicates of blocks of {block_days:g} days")
    found = tuple(_isoline(site, beta, s, copies) for s in reached)
    search = None if case is None else contour_search(case, site, return_period, channel, progress=progress)
    surface = iform_surface(site.model, beta).copy()
    surface[..., 0] *= site.to_hub
    return ContourStudy(
        site=site,
        return_period=return_period,
        beta=beta,
        isolines=found,
        reference=_reference(site, return_period, reached),
        surface=surface,
        hub_range=(low, high),
        search=search,
        fit=fit,
        states=states,
        record=record,
        notes=tuple(notes),
    )


def open_site(
    name: str | Path,
    *,
    hub_height: float | None = None,
    depth: float | None = None,
    wind_height: float | None = None,
    shear: float | None = None,
    wind: str = "exponentiated",
    method: str = "likelihood",
) -> tuple[Site, Fit | None, Mapping[str, np.ndarray] | None, Metocean | None]:
    """Return the site of a site file, of a name that comes with fowtio, or fitted to a metocean record.

    hub_height and depth are needed with a record; with a site file they, wind_height and shear replace the file's.
    Returns the site, and of a record the fit, the states and the record. Raises FormatError, CaseError, ModelError.
    """
    path = Path(name)
    given = {"hub_height": hub_height, "depth": depth, "wind_height": wind_height, "shear": shear}
    given = {key: value for key, value in given.items() if value is not None}
    if path.suffix.lower() == SUFFIX or (not path.is_file() and (str(name) in shipped_sites() or not path.suffix)):
        return replace(load_site(name), **given), None, None, None
    if not path.is_file():
        raise FormatError(
            path,
            expected="a site file, a metocean record or the name of a site",
            found=str(name),
            hint=f"Sites: {', '.join(shipped_sites())}",
        )
    missing = [option for option, key in (("--hub-height", "hub_height"), ("--depth", "depth")) if key not in given]
    if missing:
        raise ModelError(f"{path} is a metocean record; a site also needs {' and '.join(missing)}")
    record = read_metocean(path)
    site, fit, states = site_of_record(record, wind=wind, method=method, **given)
    return site, fit, states, record


def _isoline(site: Site, beta: float, speed: float, copies: Sequence[JointModel] = ()) -> Isoline:
    at = speed / site.to_hub
    line = isoline(site.model, beta, at).copy()
    line[:, 0] = speed
    points = [crest(site.model, beta, at, kind).copy() for kind in ("max_hs", "max_tp")]
    for point in points:
        point[0] = speed
    interval = None
    if copies:
        heights = [_height(copy, beta, at) for copy in copies]
        interval = np.nanquantile(heights, [0.025, 0.975]) if np.isfinite(heights).any() else None
    return Isoline(hub_wind_speed=speed, line=line, max_hs=points[0], max_tp=points[1], max_hs_interval=interval)


def _height(model: JointModel, beta: float, at: float) -> float:
    try:
        return float(crest(model, beta, at)[1])
    except ValueError:  # a replicate whose contour ends below this wind speed
        return np.nan


def _reference(site: Site, return_period: float, speeds: Sequence[float]) -> tuple[Isoline, ...]:
    if return_period == REFERENCE_PERIOD:
        return ()
    beta = reliability_index(REFERENCE_PERIOD, site.state_duration)
    low, high = (value * site.to_hub for value in level_range(site.model, beta))
    return tuple(_isoline(site, beta, s) for s in speeds if low < s < high)
