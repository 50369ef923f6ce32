"""The site file (.site): where a turbine stands, and the joint distribution of its wind and waves, given or fitted.

The form is that of study files: `value  Name  - description` lines and a table, so a fit can be read, changed and kept.
"""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import as_file, files
from pathlib import Path

import numpy as np

from fowtio.errors import CaseError, FormatError, ModelError, Problem
from fowtio.read.metocean import Metocean, MetoceanReport
from fowtio.read.openfast_input import InputFile, read_input
from fowtio.read.text import number
from fowtio.write.atomic import atomic_file
from model.environment.contours import wind_factor
from model.environment.joint import FAMILIES, FORMS, WIND, Dependence, JointModel, Variable, constant
from model.environment.metocean import Fit, VariableForm, fit_joint, thesis_form

SUFFIX = ".site"
TITLE_RULE = "FOWTIO SITE FILE"
_COLUMNS = ("Variable", "Family", "Parameter", "Form", "Given", "C1", "C2", "C3")


@dataclass(frozen=True, eq=False, kw_only=True)
class Site:
    """A site.

    Parameters
    ----------
    path, title : of the file
    model : joint distribution, wind speed first
    depth : of the water [m]
    wind_height, hub_height : where the distribution has its wind speed, where the turbine meets it [m]
    shear : exponent of the power law between the two [-]
    state_duration : [h]
    cut_in, cut_out : of the turbine [m/s]
    gamma : JONSWAP peak factor [-]; None: that of each sea state
    turbulence : class "A+", "A", "B", "C" of IEC 61400-1, or intensity as a fraction
    report : of the record that the distribution was fitted to, None for a given one
    """

    path: Path
    title: str
    model: JointModel
    depth: float
    wind_height: float
    hub_height: float
    shear: float
    state_duration: float = 1.0
    cut_in: float = 4.0
    cut_out: float = 25.0
    gamma: float | None = None
    turbulence: str | float = "B"
    report: MetoceanReport | None = None

    @property
    def to_hub(self) -> float:
        """Wind speed at hub height over that of the distribution."""
        return 1 / wind_factor(self.wind_height, self.hub_height, self.shear)


_NUMBERS = {
    "WaterDepth": ("depth", None),
    "WindHeight": ("wind_height", 10.0),
    "HubHeight": ("hub_height", None),
    "ShearExp": ("shear", 0.14),
    "StateDuration": ("state_duration", 1.0),
    "CutIn": ("cut_in", 4.0),
    "CutOut": ("cut_out", 25.0),
}
_NAMES = (*_NUMBERS, "Gamma", "Turbulence", "NPar")


def shipped_sites(suffix: str = SUFFIX) -> dict[str, Path]:
    """Return the site files (or those of another suffix) that come with fowtio, by name."""
    checkout = Path(__file__).resolve().parent.parent / "validation" / "sites"
    if checkout.is_dir():
        folder = checkout
    else:
        with as_file(files("fowtio.cases") / "sites") as packaged:
            folder = Path(packaged)
    return {p.stem: p for p in sorted(folder.glob(f"*{suffix}"))}


def shipped(name: str | Path, suffix: str, what: str) -> Path:
    """Return the file of a path, or of the name of one that comes with fowtio; raise FormatError when there is none."""
    path = Path(name)
    if path.is_file():
        return path
    known = shipped_sites(suffix)
    if str(name) in known:
        return known[str(name)]
    near = difflib.get_close_matches(str(name), known, n=1)
    hint = f"Did you mean {near[0]}?" if near else f"Those that come with fowtio: {', '.join(known)}"
    raise FormatError(path, expected=f"a {what}, or the name of one that comes with fowtio", found=str(name), hint=hint)


def load_site(name: str | Path) -> Site:
    """Return a site from its file, or by the name of one that comes with fowtio.

    Raises CaseError with every problem of the file at once, FormatError when it cannot be read at all.
    """
    path = shipped(name, SUFFIX, "site file")
    source = read_input(path)
    if TITLE_RULE not in source.lines[0].upper():
        hint = "fowtio contour RECORD fits a distribution to a metocean record and writes such a file"
        raise FormatError(path, 1, expected=f"'--- {TITLE_RULE} ---'", found=source.lines[0], hint=hint)
    problems: list[Problem] = []
    _check_names(source, problems)
    values = {attribute: _number(source, name, default, problems) for name, (attribute, default) in _NUMBERS.items()}
    gamma = None if source.is_default("Gamma") else _number(source, "Gamma", None, problems)
    turbulence = _turbulence(source, problems)
    model = _model(source, problems)
    _check_ranges(source, values, problems)
    if problems:
        raise CaseError(list(dict.fromkeys(problems)))
    title = source.lines[1].strip() if len(source.lines) > 1 else path.stem
    return Site(path=path, title=title, model=model, gamma=gamma, turbulence=turbulence, **values)


def site_of_record(
    record: Metocean,
    *,
    hub_height: float,
    depth: float,
    wind_height: float = 10.0,
    shear: float = 0.14,
    wind: str = "exponentiated",
    method: str = "likelihood",
    forms: Sequence[VariableForm] | None = None,
    title: str = "",
) -> tuple[Site, Fit, dict[str, np.ndarray]]:
    """Return the site of a metocean record, the fit, and the states (by name) it was fitted to.

    Parameters
    ----------
    record : with wind speed, significant height and peak period; rows in which one of them is missing are left out
    hub_height, depth, wind_height, shear : as of Site
    wind : distribution of the wind speed, as in `thesis_form`; method : "likelihood" or "least_squares"
    forms : another chain instead

    Raises
    ------
    ModelError : too few complete states, or values that no distribution has.
    """
    chosen = thesis_form(wind) if forms is None else tuple(forms)
    names = [f.name for f in chosen]
    rows = record.complete(*names)
    if len(rows) < 500:
        raise ModelError(
            f"{record.source}: {len(rows)} of {len(record.time)} states have {', '.join(names)}; 500 are needed to fit a "
            f"distribution ({describe_report(record.report)})"
        )
    flat = [n for k, n in enumerate(names) if np.ptp(rows[:, k]) == 0]
    if flat:
        raise ModelError(f"{record.source}: {', '.join(flat)} is constant throughout; that is no measurement")
    states = {name: rows[:, k] for k, name in enumerate(names)}
    try:
        fit = fit_joint(states, chosen, method)
    except ValueError as error:
        raise ModelError(f"{record.source}: {error}") from None
    hours = record.report.step / 3600
    site = Site(
        path=Path(record.source),
        title=title or Path(record.source).stem,
        model=fit.model,
        depth=depth,
        wind_height=wind_height,
        hub_height=hub_height,
        shear=shear,
        state_duration=hours if 0 < hours <= 24 else 1.0,
        report=record.report,
    )
    return site, fit, states


def describe_report(report: MetoceanReport) -> str:
    """Return what was found wrong in a record in one line, with counts; "nothing wrong" for a clean one."""
    found = []
    for words, counts in (
        ("missing", report.missing),
        ("sentinels", report.sentinel),
        ("out of range", report.out_of_range),
        ("unreadable", report.unreadable),
    ):
        found += [f"{count} {quantity.replace('_', ' ')} {words}" for quantity, count in counts.items() if count]
    for words, count in (
        ("unreadable times", report.bad_times),
        ("duplicated rows", report.duplicates),
        ("rows that contradict another", report.conflicting),
        ("rows out of order", report.unsorted),
    ):
        found += [f"{count} {words}"] if count else []
    if report.gaps:
        found.append(f"{report.gaps} gaps of {report.missing_steps} steps in all")
    return "; ".join(found) or "nothing wrong"


def record_notes(record: Metocean) -> list[str]:
    """Return what was found and assumed in a record, in sentences."""
    return [f"{record.report.rows} rows: {describe_report(record.report)}", *record.report.notes]


def write_site(site: Site, path: str | Path) -> Path:
    """Write a site as a file that `load_site` reads; it appears whole or not at all."""
    with atomic_file(path) as temporary:
        temporary.write_text(site_text(site), encoding="utf-8")
    return Path(path)


def site_text(site: Site) -> str:
    """Return a site as the text of its file; numbers in full, so that reading gives the same site."""
    turbulence = f'"{site.turbulence}"' if isinstance(site.turbulence, str) else f"{100 * site.turbulence:.12g}"
    lines = [
        _rule(f"{TITLE_RULE} "),
        site.title,
        _rule(" SITE "),
        _line(site.depth, "WaterDepth", "depth of the water (m)"),
        _line(site.wind_height, "WindHeight", "height above still water of the wind speed below (m)"),
        _line(site.hub_height, "HubHeight", "height of the turbine's hub (m)"),
        _line(site.shear, "ShearExp", "exponent of the power law between the two (-)"),
        _line(site.state_duration, "StateDuration", "duration of a state (h)"),
        _line(site.cut_in, "CutIn", "wind speed at hub height from which the turbine runs (m/s)"),
        _line(site.cut_out, "CutOut", "and up to which (m/s)"),
        _line(
            '"DEFAULT"' if site.gamma is None else site.gamma,
            "Gamma",
            "JONSWAP peak factor; DEFAULT: that of each sea state (-)",
        ),
        _line(turbulence, "Turbulence", "class A+, A, B, C of IEC 61400-1, or intensity (%)"),
        _rule(" JOINT DISTRIBUTION "),
    ]
    rows = [(v, p, d) for v in site.model.variables for p, d in v.parameters.items()]
    lines.append(
        _line(len(rows), "NPar", "rows of the table; forms: constant c1, power c1+c2 x^c3, exponential c1+c2 exp(c3 x)")
    )
    cells = [_COLUMNS, ("(-)",) * len(_COLUMNS)]
    for v, parameter, d in rows:
        coefficients = [f"{c:.12g}" for c in d.coefficients] + ["-"] * (3 - len(d.coefficients))
        cells.append((v.name, v.family, parameter, d.form, d.given or "-", *coefficients))
    widths = [max(len(row[k]) for row in cells) + 2 for k in range(len(_COLUMNS))]
    lines += ["".join(c.ljust(w) for c, w in zip(row, widths, strict=True)).rstrip() for row in cells]
    return "\n".join([*lines, "END of site", ""])


def _rule(text: str) -> str:
    return f"------{text if text.startswith(' ') else ' ' + text}".ljust(80, "-")


def _line(value, name: str, words: str) -> str:
    text = value if isinstance(value, str) else f"{value:.12g}"
    return f"{text:<12} {name:<14} - {words}"


def _check_names(source: InputFile, problems: list[Problem]) -> None:
    """Note every name of the file that fowtio does not know, with the nearest that it does."""
    known = {n.lower(): n for n in _NAMES}
    table = source.line("NPar") if source.has("NPar") else len(source.lines)
    for key, (line, _, written) in source.entries.items():
        if key in known or line > table:
            continue
        near = difflib.get_close_matches(key, known, n=1)
        hint = f"; did you mean {known[near[0]]}?" if near else f"; known names are {', '.join(_NAMES)}"
        problems.append(Problem(f"unknown name {written}{hint}", source.path, line))


def _number(source: InputFile, name: str, default: float | None, problems: list[Problem]) -> float:
    try:
        return source.number(name) if default is None else source.number(name, default)
    except FormatError as error:
        problems.append(Problem(str(error)))
        return 1.0


def _turbulence(source: InputFile, problems: list[Problem]) -> str | float:
    text = source.text("Turbulence", "B")
    if text.upper() in ("A+", "A", "B", "C"):
        return text.upper()
    try:
        value = number(text)
    except ValueError:
        value = -1.0
    if not 0 < value < 100:
        words = f"Turbulence is {text!r}, expected a class (A+, A, B, C) or an intensity in per cent"
        problems.append(Problem(words, source.path, source.line("Turbulence")))
    return value / 100


def _check_ranges(source: InputFile, values: Mapping[str, float], problems: list[Problem]) -> None:
    for name, (attribute, _) in _NUMBERS.items():
        value, least = values[attribute], 0.0
        if value < least or (value == 0 and attribute not in ("shear", "cut_in")):
            line = source.line(name) if source.has(name) else None
            problems.append(Problem(f"{name} is {value:g}, expected a number above zero", source.path, line))
    if values["cut_in"] >= values["cut_out"]:
        problems.append(Problem(f"CutIn {values['cut_in']:g} is not below CutOut {values['cut_out']:g}", source.path))


def _model(source: InputFile, problems: list[Problem]) -> JointModel | None:
    """Return the joint distribution of the table; note what is wrong with its rows."""
    try:
        table = source.table("NPar")
        columns = [table.column(c) for c in _COLUMNS]
    except FormatError as error:
        problems.append(Problem(str(error)))
        return None
    found: dict[str, tuple[str, dict[str, Dependence]]] = {}
    for row, line in zip(zip(*columns, strict=True), table.numbers_of_lines, strict=True):
        try:
            name, family, parameter, dependence = _row(row)
            known = found.setdefault(name, (family, {}))
            if known[0] != family:
                raise ValueError(f"{name} is {known[0]} above and {family} here")
            if parameter in known[1]:
                raise ValueError(f"{parameter} of {name} is given twice")
            known[1][parameter] = dependence
        except ValueError as error:
            problems.append(Problem(str(error), source.path, line))
    try:
        model = JointModel(variables=tuple(Variable(name=n, family=f, parameters=p) for n, (f, p) in found.items()))
        if not model.variables or model.names[0] != WIND:
            raise ValueError(f"the first variable must be {WIND}, not {model.names[0] if model.variables else 'none'}")
        return model
    except ValueError as error:
        problems.append(Problem(str(error), source.path, source.line("NPar")))
        return None


def _row(row: Sequence[str]) -> tuple[str, str, str, Dependence]:
    """Return variable, family, parameter and dependence of a row; raise ValueError saying which cell is wrong."""
    name, family, parameter, form, given, *cells = row
    for value, known, what in ((family, FAMILIES, "Family"), (form, FORMS, "Form")):
        if value not in known:
            near = difflib.get_close_matches(value, known, n=1)
            raise ValueError(
                f"{what} is {value!r}"
                + (f"; did you mean {near[0]}?" if near else f", expected one of {', '.join(known)}")
            )
    coefficients = []
    for k, cell in enumerate(cells[: FORMS[form]], start=1):
        try:
            coefficients.append(number(cell))
        except ValueError:
            raise ValueError(f"C{k} is {cell!r}, expected a number (the {form} form has {FORMS[form]})") from None
    if form == "constant":
        return name, family, parameter, constant(coefficients[0])
    return (
        name,
        family,
        parameter,
        Dependence(form=form, coefficients=tuple(coefficients), given=None if given == "-" else given),
    )
