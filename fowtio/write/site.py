"""The report of a site: joint distribution and its fit, contour surface, isolines, design points."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib import cm
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from fowtio.write.document import bullet_list, write_document
from fowtio.write.report import Card, Section
from fowtio.write.style import AMBER, BLUE, GREY, INK, ORANGE, Drawing, grid, legend
from fowtio.write.table import Column, Table, number
from model.environment.joint import UNITS, log_density, parameters_at, variable_to_normal

LABELS = {"wind_speed": "Wind speed", "significant_height": "Hs", "peak_period": "Tp", "zero_crossing_period": "Tz"}
PARAMETER_LABELS = {
    "scale": "scale",
    "shape": "shape",
    "exponent": "exponent",
    "location": "location",
    "mean_log": "mean of ln Tp",
    "std_log": "std of ln Tp",
    "variance_log": "variance of ln Tp",
}


def write_contour(
    study, folder: str | Path, *, figures: bool = True, progress: Callable[[str], None] = lambda text: None
) -> list[Path]:
    """Write report, workbook and figures of a ContourStudy into a folder and return the files."""
    site = study.site
    tables = [
        isoline_table(study),
        distribution_table(study),
        *([fit_table(study)] if study.fit else []),
        *search_tables(study),
    ]
    notes = notes_of(study)

    def sections(pictures):
        at = lambda *names: tuple(pictures[n] for n in names if n in pictures)  # noqa: E731
        return [
            Section(title="Design points", content=(tables[0], *at("isolines_plan", "contour_surface"))),
            Section(title="Isolines by wind speed", content=at("isolines_panels")),
            Section(title="Worst state of a response", content=tuple(search_tables(study))),
            Section(
                title="Joint distribution",
                content=(distribution_table(study), *at("fit_marginals", "fit_conditionals")),
            ),
            Section(title="Goodness of fit", content=((fit_table(study), *at("fit_qq")) if study.fit else ())),
            Section(title="Record and notes", content=(bullet_list(notes),) if notes else ()),
        ]

    return write_document(
        folder,
        name="contour",
        kind="Environmental contour of a site",
        title=site.title,
        origin=f"Site {site.path.name}",
        cards=cards(study),
        drawings=lambda: drawings(study),
        sections=sections,
        sheets=[("Design points", [tables[0]]), ("Distribution", tables[1:]), ("Isolines", [lines_table(study)])],
        figures=figures,
        progress=progress,
    )


def notes_of(study) -> list[str]:
    """Return what was assumed and found, in sentences."""
    from fowtio.site import record_notes

    site = study.site
    out = [
        f"wind speed of the distribution at {site.wind_height:g} m, at the hub ({site.hub_height:g} m) {site.to_hub:.4g} times that "
        f"(power law, exponent {site.shear:g})",
        f"IFORM, beta = {study.beta:.4g} for {study.return_period:g} years of {site.state_duration:g}-hour states",
        *study.notes,
    ]
    return out + (record_notes(study.record) if study.record is not None else [])


def cards(study) -> list[Card]:
    """Return the key numbers."""
    top = max(study.isolines, key=lambda i: i.max_hs[1])
    return [
        Card(label="Return period", value=f"{study.return_period:g} years", note=f"β = {study.beta:.3f}"),
        Card(
            label="Largest Hs, turbine running",
            value=f"{top.max_hs[1]:.2f} m",
            note=f"Tp {top.max_hs[2]:.2f} s at {top.hub_wind_speed:g} m/s",
        ),
        Card(label="Wind speed at the hub", value=f"{study.hub_range[1]:.1f} m/s", note="the contour's largest"),
        Card(label="Hs of the whole contour", value=f"{study.surface[..., 1].max():.2f} m", note="at any wind speed"),
    ]


def isoline_table(study) -> Table:
    """Return the design points of all isolines."""
    columns = [
        Column(name="Hub wind speed", unit="m/s", decimals=1),
        Column(name="Largest Hs", unit="m", decimals=2),
        Column(name="Tp there", unit="s", decimals=2),
        Column(name="Largest Tp", unit="s", decimals=2),
        Column(name="Hs there", unit="m", decimals=2),
    ]
    one_year = {i.hub_wind_speed: i.max_hs for i in study.reference}
    if one_year:
        columns += [Column(name="Hs, 1 year", unit="m", decimals=2), Column(name="Tp, 1 year", unit="s", decimals=2)]
    sure = any(i.max_hs_interval is not None for i in study.isolines)
    if sure:
        columns += [Column(name="Hs from", unit="m", decimals=2), Column(name="Hs to", unit="m", decimals=2)]
    rows = []
    for item in study.isolines:
        row = [item.hub_wind_speed, item.max_hs[1], item.max_hs[2], item.max_tp[2], item.max_tp[1]]
        row += list(one_year.get(item.hub_wind_speed, (None,) * 3)[1:]) if one_year else []
        row += (list(item.max_hs_interval) if item.max_hs_interval is not None else [None, None]) if sure else []
        rows.append(tuple(None if v is None else float(v) for v in row))
    return Table(
        name="isolines",
        title=f"Design points of the {study.return_period:g}-year contour",
        columns=tuple(columns),
        rows=tuple(rows),
        note="The largest Hs at a wind speed stands with the median Tp given it.",
    )


def lines_table(study) -> Table:
    """Return the points of all isolines."""
    columns = (
        Column(name="Hub wind speed", unit="m/s", decimals=1),
        Column(name="Hs", unit="m", decimals=3),
        Column(name="Tp", unit="s", decimals=3),
    )
    rows = tuple(tuple(float(v) for v in point) for item in study.isolines for point in item.line)
    return Table(name="lines", title="Isolines", columns=columns, rows=rows)


def distribution_table(study) -> Table:
    """Return the joint distribution as formulas with their coefficients."""
    columns = tuple(Column(name=n) for n in ("Variable", "Distribution", "Parameter", "Form", "c1", "c2", "c3"))
    rows = []
    for v in study.site.model.variables:
        for p, d in v.parameters.items():
            words = d.form if d.given is None else f"{d.form} in {LABELS.get(d.given, d.given)}"
            values = [f"{c:.6g}".replace("-", "−") for c in d.coefficients] + [""] * (3 - len(d.coefficients))
            rows.append(
                (
                    LABELS.get(v.name, v.name),
                    v.family.replace("_variance", ""),
                    PARAMETER_LABELS.get(p, p),
                    words,
                    *values,
                )
            )
    note = "constant c1; power c1 + c2 x^c3; exponential c1 + c2 exp(c3 x); hyperbolic c1 + c2/(1 + c3 x)"
    return Table(name="distribution", title="Joint distribution", columns=columns, rows=tuple(rows), note=note)


def fit_table(study) -> Table:
    """Return how well every variable fits."""
    columns = (
        Column(name="Variable"),
        Column(name="Method"),
        Column(name="States", decimals=0),
        Column(name="Coefficients", decimals=0),
        Column(name="Log-likelihood", decimals=0),
        Column(name="AIC", decimals=0),
        Column(name="KS distance", decimals=4),
        Column(name="p of KS", decimals=3),
    )
    rows = tuple(
        (
            LABELS.get(v.variable.name, v.variable.name),
            v.method.replace("_", " "),
            float(study.fit.count),
            float(v.goodness.free),
            v.goodness.log_likelihood,
            v.goodness.aic,
            v.goodness.ks_distance,
            v.goodness.ks_probability,
        )
        for v in study.fit.variables
    )
    note = "Kolmogorov–Smirnov probabilities take states as independent, which hours are not: small ones are usual of long records."
    return Table(name="goodness", title="Goodness of fit", columns=columns, rows=rows, note=note)


def search_tables(study) -> list[Table]:
    """Return the worst states of the response that was sought, if any."""
    if study.search is None:
        return []
    from fowtio.write.quantities import people

    unit, factor = people(study.search.unit)
    columns = (
        Column(name="Hub wind speed", unit="m/s", decimals=1),
        Column(name="Hs", unit="m", decimals=2),
        Column(name="Tp", unit="s", decimals=2),
        Column(name=f"{study.search.channel}, expected largest", unit=unit),
    )
    rows = tuple(
        (*map(float, s), float(v * factor)) for s, v in zip(study.search.by_speed, study.search.values, strict=True)
    )
    return [
        Table(
            name="search",
            title=f"States of the contour that make {study.search.channel} largest",
            columns=columns,
            rows=rows,
        )
    ]


def drawings(study) -> list[Drawing]:
    """Return all figures of a site."""
    out = [plan(study), surface(study), panels(study), marginals(study), conditionals(study)]
    return [*out, qq(study)] if study.fit else out


def plan(study) -> Drawing:
    """Return the isolines in the plane of Tp and Hs with the largest heights."""
    figure, axes = grid(1, 1, width=7.5, height=4.2, top=0.35)
    ax = axes[0, 0]
    norm = Normalize(study.isolines[0].hub_wind_speed, study.isolines[-1].hub_wind_speed)
    for item in study.isolines:
        ax.plot(item.line[:, 2], item.line[:, 1], color=cm.viridis(norm(item.hub_wind_speed)), lw=1.1)
    crests = np.array([i.max_hs for i in study.isolines])
    ax.plot(
        crests[:, 2],
        crests[:, 1],
        color=INK,
        lw=0.9,
        marker="o",
        ms=3,
        label=f"largest Hs, {study.return_period:g} years",
    )
    if study.reference:
        year = np.array([i.max_hs for i in study.reference])
        ax.plot(year[:, 2], year[:, 1], color=ORANGE, lw=0.9, marker="o", ms=3, label="largest Hs, 1 year")
    if study.search is not None:
        ax.plot(
            *study.search.state[[2, 1]],
            color=ORANGE,
            marker="*",
            ms=12,
            ls="",
            label=f"worst of {study.search.channel}",
        )
    ax.set_xlabel("Peak period [s]")
    ax.set_ylabel("Significant wave height [m]")
    ax.set_xlim(left=0)
    ax.set_ylim(bottom=0)
    ax.legend(loc="upper left")
    left, bottom, wide, high = ax.get_position().bounds
    ax.set_position([left, bottom, wide - 0.11, high])
    side = figure.add_axes([left + wide - 0.09, bottom, 0.018, high])
    bar = figure.colorbar(cm.ScalarMappable(norm=norm, cmap="viridis"), cax=side)
    bar.set_label("Wind speed at hub height [m/s]")
    bar.outline.set_visible(False)
    caption = f"Isolines of the {study.return_period:g}-year contour surface at constant wind speed, with the states of largest significant height."
    return Drawing(name="isolines_plan", group="contour", title="Isolines", caption=caption, figure=figure)


def surface(study) -> Drawing:
    """Return the contour surface in space."""
    figure = Figure(figsize=(7.5, 5.0))
    ax = figure.add_axes([0.0, 0.0, 0.96, 1.08], projection="3d")
    x = study.surface
    norm = Normalize(x[..., 0].min(), x[..., 0].max())
    ax.plot_surface(
        x[..., 2],
        x[..., 1],
        x[..., 0],
        facecolors=cm.viridis(norm(x[..., 0])),
        rstride=1,
        cstride=1,
        lw=0,
        alpha=0.75,
        antialiased=False,
        shade=False,
        rasterized=True,
    )
    for item in (study.isolines[0], study.isolines[-1]):
        ax.plot(item.line[:, 2], item.line[:, 1], item.line[:, 0], color=INK, lw=1.2)
    ax.set_xlabel("Tp [s]")
    ax.set_ylabel("Hs [m]")
    ax.set_zlabel("Wind speed at the hub [m/s]")
    ax.view_init(22, -125)
    caption = "The contour surface; black: isolines at the lowest and the highest wind speed of the tables."
    return Drawing(name="contour_surface", group="contour", title="Contour surface", caption=caption, figure=figure)


def panels(study, columns: int = 6) -> Drawing:
    """Return the isolines of both return periods, a panel for every wind speed."""
    items = study.isolines
    count = len(items)
    columns = min(columns, count)
    rows = -(-count // columns)
    figure, axes = grid(rows, columns, width=11.0, height=1.35, gaps=(0.38,), top=0.75, between=0.28)
    one_year = {i.hub_wind_speed: i for i in study.reference}
    right, top = max(i.line[:, 2].max() for i in items), max(i.line[:, 1].max() for i in items)
    handles: dict = {}
    for k, item in enumerate(items):
        ax = axes[k // columns, k % columns]
        handles[f"{study.return_period:g} years"] = ax.plot(item.line[:, 2], item.line[:, 1], color=INK, lw=1.2)[0]
        other = one_year.get(item.hub_wind_speed)
        if other is not None:
            handles["1 year"] = ax.plot(other.line[:, 2], other.line[:, 1], color=BLUE, lw=1.2)[0]
            handles["largest Hs"] = ax.plot(*other.max_hs[[2, 1]], color=ORANGE, marker="o", ms=3.5, ls="")[0]
        handles["largest Hs"] = ax.plot(*item.max_hs[[2, 1]], color=ORANGE, marker="o", ms=3.5, ls="")[0]
        ax.set_title(f"{item.hub_wind_speed:g} m/s")
        ax.set_xlim(0, right * 1.03)
        ax.set_ylim(0, top * 1.08)
        if k % columns:
            ax.set_yticklabels([])
        else:
            ax.set_ylabel("Hs [m]")
        if k + columns >= count:
            ax.set_xlabel("Tp [s]")
        else:
            ax.set_xticklabels([])
    for k in range(count, rows * columns):
        axes[k // columns, k % columns].set_visible(False)
    legend(figure, list(handles.values()), list(handles))
    caption = "Isolines at every wind speed at hub height, with the states of largest significant height."
    return Drawing(
        name="isolines_panels", group="contour", title="Isolines by wind speed", caption=caption, figure=figure
    )


def marginals(study) -> Drawing:
    """Return density and exceedance of the first variable, with the record's."""
    figure, axes = grid(1, 2, width=9.0, height=2.4, top=0.55)
    variable = study.site.model.variables[0]
    data = None if study.states is None else study.states[variable.name]
    top = float(_quantile(variable, 4.8)) if data is None else max(float(_quantile(variable, 4.8)), float(data.max()))
    x = np.linspace(top / 2000, top, 1200)
    pdf, tail = axes[0]
    handles = {}
    if data is not None:
        handles["record"] = pdf.hist(data, bins=60, density=True, color=GREY, alpha=0.4)[2][0]
        ordered = np.sort(data)
        left = 1 - (np.arange(len(ordered)) + 0.5) / len(ordered)
        keep = np.unique(
            np.append(
                np.arange(0, len(ordered), max(1, len(ordered) // 800)),
                np.arange(max(0, len(ordered) - 200), len(ordered)),
            )
        )
        tail.plot(ordered[keep], left[keep], color=GREY, marker=".", ms=3, ls="")
    handles["distribution"] = pdf.plot(x, np.exp(log_density(variable, x)), color=BLUE)[0]
    from scipy.special import ndtr

    tail.plot(x, ndtr(-variable_to_normal(variable, x)), color=BLUE)
    tail.set_yscale("log")
    tail.set_ylim(1e-7, 1.5)
    label = (
        f"{LABELS.get(variable.name, variable.name)} at {study.site.wind_height:g} m [{UNITS.get(variable.name, '')}]"
    )
    for ax, name in ((pdf, "Density"), (tail, "Probability of exceedance")):
        ax.set_xlabel(label)
        ax.set_title(name)
        ax.set_xlim(0, top)
    legend(figure, list(handles.values()), list(handles))
    caption = "Wind speed at the height of the distribution: density, and exceedance on a logarithmic axis, where the tail shows."
    return Drawing(name="fit_marginals", group="fit", title="Wind speed", caption=caption, figure=figure)


def conditionals(study) -> Drawing:
    """Return the parameters of the conditional distributions over what they are given, with those of separate
    classes.
    """
    wanted = [
        (k, v, p)
        for k, v in enumerate(study.site.model.variables)
        for p, d in v.parameters.items()
        if d.given is not None
    ]
    figure, axes = grid(1, len(wanted), width=11.0, height=2.2, top=0.55, between=0.75)
    handles: dict = {}
    for ax, (k, variable, parameter) in zip(axes[0], wanted, strict=True):
        given = variable.parameters[parameter].given
        classes = study.fit.variables[k].classes if study.fit is not None else None
        top = classes.span[1] if classes is not None else (30.0 if given == "wind_speed" else 12.0)
        x = np.linspace(0.02 * top, top, 300)
        handles["fit"] = ax.plot(x, np.broadcast_to(parameters_at(variable, x)[parameter], x.shape), color=BLUE)[0]
        if classes is not None:
            handles["classes (size: states)"] = ax.scatter(
                classes.centre,
                classes.parameters[parameter],
                s=4 + 30 * np.sqrt(classes.count / classes.count.max()),
                color=AMBER,
                zorder=3,
                lw=0,
            )
        ax.set_xlabel(f"{LABELS.get(given, given)} [{UNITS.get(given, '')}]")
        ax.set_title(f"{LABELS.get(variable.name, variable.name)}: {PARAMETER_LABELS.get(parameter, parameter)}")
    legend(figure, list(handles.values()), list(handles))
    caption = "How the distributions of Hs and Tp follow what they are given."
    return Drawing(
        name="fit_conditionals", group="fit", title="Conditional distributions", caption=caption, figure=figure
    )


def qq(study) -> Drawing:
    """Return quantiles of the record over those of the fit, one panel a variable."""
    figure, axes = grid(1, len(study.fit.variables), width=10.0, height=2.9, top=0.4, between=0.75)
    for ax, item in zip(axes[0], study.fit.variables, strict=True):
        g = item.goodness
        conditional = bool(item.variable.given)
        ends = [min(g.model_quantiles[0], g.data_quantiles[0]), max(g.model_quantiles[-1], g.data_quantiles[-1])]
        ax.plot(ends, ends, color=GREY, lw=0.9)
        ax.plot(g.model_quantiles, g.data_quantiles, color=BLUE, marker=".", ms=3, ls="")
        unit = "standard normal" if conditional else UNITS.get(item.variable.name, "")
        ax.set_title(
            f"{LABELS.get(item.variable.name, item.variable.name)}{' given ' + LABELS.get(item.variable.given[0], '') if conditional else ''}"
        )
        ax.set_xlabel(f"distribution [{unit}]")
        ax.set_ylabel(f"record [{unit}]")
    caption = (
        "Quantiles of the record over those of the fit; conditional variables after the Rosenblatt transformation."
    )
    return Drawing(name="fit_qq", group="fit", title="Quantiles", caption=caption, figure=figure)


def _quantile(variable, u: float):
    from model.environment.joint import variable_from_normal

    return variable_from_normal(variable, u)


def summary_rows(study) -> list[tuple[str, str]]:
    """Return the site in labels and texts, for the terminal."""
    site = study.site
    return [
        ("depth", f"{number(site.depth, 'm', 0)} m"),
        ("return period", f"{study.return_period:g} years, β = {study.beta:.4f}"),
        ("hub wind speeds", f"{study.hub_range[0]:.2f} to {study.hub_range[1]:.2f} m/s"),
    ]
