"""The figures of an optimisation: how searches went, Pareto fronts, hulls and lines of the optima, costs, sensitivities."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Polygon
from matplotlib.ticker import MaxNLocator

from fowtio.optimise.run import OptimisationResult, StageResult, relative_values
from fowtio.optimise.sensitivity import Findings, Shown, relative_objectives, slack_of
from fowtio.optimise.tables import DIMENSION_LABELS, bound, label, lowered, relative_of, said, unit
from fowtio.write.style import AMBER, BLUE, COLOURS, GREEN, GREY, INK, ORANGE, SKY, Drawing, grid, legend
from model.design.evaluate import cost_account
from model.design.hull import AZIMUTHS, SemiHull, brace_lines
from model.design.space import DIMENSIONS
from model.system.mooring import line_profiles

SEABED = "#8C6D46"


def drawings(result: OptimisationResult, findings: Findings) -> Iterator[Drawing]:
    """Yield all figures of an optimisation."""
    for name, stage in result.stages.items():
        if stage.stage.method != "grid":
            yield evolution(result, name)
            yield variables(result, name)
        if len(stage.stage.objectives) > 1:
            yield pareto(result, findings, name)
            yield parallel(result, name)
        if name in findings.sensitivities:
            yield sensitivity(result, findings, name)
    yield hulls(findings)
    yield lines(result, findings)
    yield costs(findings)


def bests(stage: StageResult, objective: str) -> list[int | None]:
    """Return the row of the best feasible design of every generation, None where none is feasible."""
    return [stage.archive.best(objective, g) for g in stage.archive.generations]


def evolution(result: OptimisationResult, name: str) -> Drawing:
    """Return the best and the mean of the feasible designs of every generation, one panel an objective."""
    stage = result.stages[name]
    a, names = stage.archive, stage.stage.objectives
    figure, axes = grid(1, len(names), width=5.5 * max(len(names), 1) + 0.6, height=2.5, top=0.75, between=0.85)
    for ax, objective in zip(axes[0], names, strict=True):
        x = np.arange(1, len(a.generations) + 1)
        best = [np.nan if r is None else a.value(objective, r) for r in bests(stage, objective)]
        mean = [_mean(a.value(objective, g[a.feasible[g]])) for g in a.generations]
        handles = {"best": ax.plot(x, best, color=BLUE, marker="o", ms=4)[0], "mean of the feasible": ax.plot(x, mean, color=AMBER, marker="s", ms=3.5, lw=1.1)[0]}
        if stage.best is not None and result.study.polish:
            handles["after going downhill"] = ax.axhline(a.value(objective, stage.best), color=GREEN, lw=1.1, ls="--")
        if objective in result.reference_values:
            handles["reference"] = ax.axhline(result.reference_values[objective], color=INK, lw=1.1, ls=":")
        _generations(ax, len(x))
        ax.set_title(_with_unit(objective))
    legend(figure, list(handles.values()), list(handles))
    caption = "Objectives of the feasible designs of every generation."
    return Drawing(name=f"evolution_{name}", group=name, title=f"Stage {name}: the search", caption=caption, figure=figure)


def _mean(values) -> float:
    return float(np.mean(values)) if len(values) else float("nan")


def _with_unit(name: str) -> str:
    return f"{label(name)} [{unit(name)}]" if unit(name) else label(name)


def _generations(ax, count: int) -> None:
    ax.set_xlim(0.8, max(count, 2) + 0.2)
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    ax.set_xlabel("Generation")
    ax.yaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    ax.yaxis.get_major_formatter().set_useOffset(False)


def variables(result: OptimisationResult, name: str) -> Drawing:
    """Return the dimensions of the best design of every generation; lines with the straight distance that they must span."""
    stage = result.stages[name]
    a, names = stage.archive, stage.stage.objectives
    figure, axes = grid(1, 4, width=11.0, height=2.1, top=0.75, between=0.62)
    handles: dict[str, Line2D] = {}
    for k, objective in enumerate(names):
        rows = [(n, r) for n, r in enumerate(bests(stage, objective), start=1) if r is not None]
        x, designs, colour = [n for n, _ in rows], a.designs[[r for _, r in rows]], COLOURS[k % len(COLOURS)]
        of = f"least {lowered(label(objective, False).split(',')[0])}" if len(names) > 1 else "best design"
        for d, ax in enumerate(axes[0]):
            handles[of] = ax.plot(x, designs[:, d if d < 3 else 4], color=colour, marker="o", ms=4)[0]
        straight = designs[:, 4] / slack_of(result.setting, designs)
        axes[0, 3].plot(x, straight, color=colour, ls="--", marker="o", ms=3, lw=1.1, mfc="white")
    handles["straight distance from fairlead to anchor"] = Line2D([], [], color=GREY, ls="--", marker="o", ms=3, lw=1.1, mfc="white")
    for d, ax in enumerate(axes[0]):
        _generations(ax, len(a.generations))
        ax.set_title(f"{DIMENSION_LABELS[DIMENSIONS[d]]} [m]" if d < 3 else "Line length [m]")
        bounds = next(((v.lower, v.upper) for v in stage.space.variables if v.name == DIMENSIONS[d] and v.relative_to is None), None) if d < 3 else None
        if bounds:
            margin = 0.08 * max(bounds[1] - bounds[0], 0.5)
            ax.set_ylim(bounds[0] - margin, bounds[1] + margin)
            for b in bounds:
                ax.axhline(b, color=GREY, lw=0.9, ls=":")
    legend(figure, list(handles.values()), list(handles))
    caption = "Dimensions of the best design of every generation; dotted: bounds."
    return Drawing(name=f"variables_{name}", group=name, title=f"Stage {name}: dimensions", caption=caption, figure=figure)


def pareto(result: OptimisationResult, findings: Findings, name: str) -> Drawing:
    """Return the Pareto front in relative objectives with its picks, the reference, other stages' optima and the published designs."""
    stage = result.stages[name]
    s, a = stage.stage, stage.archive
    members = np.unique(np.concatenate(a.generations))
    feasible = members[a.feasible[members]]
    pairs = [(0, k) for k in range(1, len(s.objectives))]
    figure, axes = grid(1, len(pairs), width=max(8.0, 5.5 * len(pairs)), height=4.0, top=0.75, between=0.85)
    values = {text: relative_values(s, a, rows, result.stages) for text, rows in (("feasible designs", feasible), ("Pareto front", stage.front), ("picks", stage.picks))}
    base = _base(result, stage)
    styles = {
        "feasible designs": {"color": "#C9CDD3", "ms": 3, "marker": "."}, "Pareto front": {"color": BLUE, "ms": 4.5, "marker": "o"},
        "picks": {"color": "none", "mec": INK, "ms": 9, "marker": "o", "mew": 1.1}, "reference": {"color": INK, "ms": 7, "marker": "s"},
        "optima of other stages": {"color": GREEN, "ms": 7, "marker": "D"}, "published, evaluated here": {"color": ORANGE, "ms": 6, "marker": "^"}, "published, as printed": {"color": "none", "mec": ORANGE, "ms": 6, "marker": "^"},
    }  # fmt: skip
    values["reference"] = np.array([[result.reference_values.get(n, np.nan) for n in s.objectives]]) / base
    others = [d for d in findings.shown.values() if result.stages[d.stage].best is not None]
    values["optima of other stages"] = np.array([[d.value(n) for n in s.objectives] for d in others]).reshape(-1, len(base)) / base
    values |= _published_points(result, findings, name)
    for ax, (i, j) in zip(axes[0], pairs, strict=True):
        handles = {text: ax.plot(v[:, i], v[:, j], ls="", zorder=2 + k, **styles[text])[0] for k, (text, v) in enumerate(values.items()) if len(v)}
        if s.picks is not None:
            handles["bounds of the picks"] = ax.axvline(s.picks[i], color=GREY, lw=0.9, ls="--")
            ax.axhline(s.picks[j], color=GREY, lw=0.9, ls="--")
        over = f" over that of the optimum of stage {s.relative_to}" if s.relative_to in result.stages else ""
        ax.set_xlabel(f"{label(s.objectives[i])}{over}" if over else _with_unit(s.objectives[i]))
        ax.set_ylabel(f"{label(s.objectives[j])}{over}" if over else _with_unit(s.objectives[j]))
        bounds = [] if s.picks is None else [np.array([[s.picks[i], s.picks[j]]])]
        _pareto_limits(ax, [v[:, [i, j]] for text, v in values.items() if text != "feasible designs"] + bounds)
    figure.legend(list(handles.values()), list(handles), loc="upper left", bbox_to_anchor=(0.055, 1 - 0.06 / figure.get_size_inches()[1]), ncols=4, columnspacing=1.4, borderaxespad=0)
    caption = "Designs that no other betters in all objectives. Published designs twice: evaluated with the model here, and as printed, each over its own base."
    return Drawing(name=f"pareto_{name}", group=name, title=f"Stage {name}: Pareto front", caption=caption, figure=figure)


def _pareto_limits(ax, points) -> None:
    """Show all points but crowds far from the front, with a margin."""
    flat = np.concatenate(points)
    flat = flat[np.isfinite(flat).all(axis=1)]
    low, high = flat.min(axis=0), flat.max(axis=0)
    edge = 0.07 * np.maximum(high - low, 1e-3 * np.abs(high))
    ax.set_xlim(low[0] - edge[0], high[0] + edge[0])
    ax.set_ylim(low[1] - edge[1], high[1] + edge[1])


def _base(result: OptimisationResult, stage: StageResult) -> np.ndarray:
    """Return what the objectives of a stage are divided by."""
    base = result.stages.get(stage.stage.relative_to or "")
    if base is None or base.best is None:
        return np.ones(len(stage.stage.objectives))
    return np.array([base.archive.value(n, base.best) if n in base.archive.names else np.nan for n in stage.stage.objectives])


def _published_points(result: OptimisationResult, findings: Findings, name: str) -> dict[str, np.ndarray]:
    """Return the published designs of a stage in its relative objectives, evaluated here and as printed."""
    objectives, pairs = result.stages[name].stage.objectives, relative_objectives(result)
    listed = [f for f in findings.published if f.published.stage == name]
    if not listed:
        return {}
    found = [[relative_of(result, findings, f, n) if n in pairs else (f.values.get(n), None, f.published.values.get(n)) for n in objectives] for f in listed]
    values = np.array([[[np.nan if v is None else v for v in three] for three in row] for row in found], dtype=float)
    return {"published, evaluated here": values[..., 0], "published, as printed": values[..., 2]}


def parallel(result: OptimisationResult, name: str) -> Drawing:
    """Return the Pareto front in parallel coordinates: variables, then objectives; picks stand out."""
    stage = result.stages[name]
    a, s = stage.archive, stage.stage
    order = [DIMENSIONS.index(v.name) for v in stage.space.variables]
    columns = [a.designs[stage.front][:, k] for k in order] + [a.value(n, stage.front) for n in s.objectives]
    heads = [f"{DIMENSION_LABELS[DIMENSIONS[k]]}\n[m]" for k in order] + [f"{label(n, False)}\n[{unit(n) or '-'}]" for n in s.objectives]
    values = np.stack(columns, axis=1)
    low, high = values.min(axis=0), values.max(axis=0)
    scaled = np.where(high > low, (values - low) / np.where(high > low, high - low, 1.0), 0.5)
    figure, axes = grid(1, 1, width=11.0, height=3.1, top=1.0)
    ax, x = axes[0, 0], np.arange(values.shape[1])
    picked = np.isin(stage.front, stage.picks)
    for line, pick in zip(scaled, picked, strict=True):
        ax.plot(x, line, color=ORANGE if pick else SKY, lw=1.5 if pick else 0.9, alpha=0.95 if pick else 0.8, zorder=3 if pick else 2)
    for k in x:
        ax.plot([k, k], [0, 1], color=INK, lw=0.8, zorder=4)
        for y, v, side in ((0, low[k], "top"), (1, high[k], "bottom")):
            ax.text(k, y + (-0.03 if side == "top" else 0.03), f"{v:.4g}", ha="center", va=side, fontsize=8)
        ax.text(k, 1.13, heads[k], ha="center", va="bottom", fontsize=8.5)
    ax.set(xlim=(-0.4, x[-1] + 0.4), ylim=(-0.1, 1.1))
    ax.axis("off")
    legend(figure, [Line2D([], [], color=ORANGE, lw=1.6), Line2D([], [], color=SKY, lw=1.2)], ["picks", "others of the front"])
    caption = "Every line is a design of the front; axes run from the least to the largest value."
    return Drawing(name=f"parallel_{name}", group=name, title=f"Stage {name}: the front in parallel coordinates", caption=caption, figure=figure)


def sensitivity(result: OptimisationResult, findings: Findings, name: str) -> Drawing:
    """Return the change of the objective when each variable moves alone around the optimum."""
    moved, objective = findings.sensitivities[name], result.stages[name].stage.objectives[0]
    figure, axes = grid(1, len(moved), width=11.0, height=2.3, top=0.75, between=0.32)
    changes = [100 * s.change(objective) for s in moved]
    low, high = shown_range(np.concatenate(changes))
    blocked = set()
    for k, (ax, s, change) in enumerate(zip(axes[0], moved, changes, strict=True)):
        kept = np.array([not b for b in s.broken])
        ax.plot(s.value, change, color=BLUE, lw=1.1, zorder=2)
        ax.plot(s.value[kept], change[kept], ls="", marker="o", ms=5, color=BLUE, zorder=3)
        ax.plot(s.value[~kept], change[~kept], ls="", marker="o", ms=5, mfc="white", mec=ORANGE, zorder=3)
        ax.plot(s.value[s.step == 0], change[s.step == 0], ls="", marker="o", ms=8, color=INK, zorder=4)
        ax.set_ylim(low, high)
        beyond = [f"{y:+.0f} %".replace("-", "−") for y in change if np.isfinite(y) and not low <= y <= high]
        if beyond:
            ax.text(0.97, 0.97, "beyond: " + ", ".join(beyond), transform=ax.transAxes, ha="right", va="top", fontsize=7.5, bbox={"fc": "white", "ec": "none", "pad": 1.5})
        ax.set_title(DIMENSION_LABELS[s.variable.name], fontsize=8.5)
        ax.set_xlabel("[m]" if s.variable.relative_to is None else f"less {lowered(DIMENSION_LABELS[s.variable.relative_to])} [m]")
        ax.set_xlim(s.value[s.step == 0][0] - 3.4 * s.variable.spacing, s.value[s.step == 0][0] + 3.4 * s.variable.spacing)
        ax.xaxis.set_major_locator(MaxNLocator(4))
        ax.yaxis.set_major_locator(MaxNLocator(5))
        if k:
            ax.set_yticklabels([])
        blocked |= {b if isinstance(b, str) else bound(b) for why in s.broken for b in why}
    axes[0, 0].set_ylabel("Change [%]")
    handles = [Line2D([], [], ls="", marker="o", ms=m, mfc=f, mec=e) for m, f, e in ((8, INK, INK), (5, BLUE, BLUE), (5, "white", ORANGE))]
    legend(figure, handles, ["optimum", "allowed", "not allowed"])
    caption = f"Change of {said(objective)} from the optimum, one variable moved by steps of its grid, up to its bounds."
    caption += f" What is not allowed breaks: {'; '.join(sorted(blocked))}." if blocked else ""
    return Drawing(name=f"sensitivity_{name}", group=name, title=f"Stage {name}: every variable moved alone", caption=caption, figure=figure)


def shown_range(values) -> tuple[float, float]:
    """Return limits that show all values but a few far off: those beyond four times what nine of ten keep to."""
    values = values[np.isfinite(values)]
    far = max(4 * np.percentile(np.abs(values), 90), 0.05)
    low, high = max(values.min(), -far), min(values.max(), far)
    edge = 0.1 * max(high - low, 0.05)
    return low - edge, high + edge


def hulls(findings: Findings) -> Drawing:
    """Return plan and side view of the reference and of every stage's design, all to one scale, with the lines near them."""
    shown = findings.designs
    one = [_hull_of(d) for d in shown]
    reach = 1.14 * max(float(h.radius + h.plate_diameter / 2) for h in one)
    keel, top = max(float(h.draft) for h in one) + 9.0, max(float(h.column_freeboard) for h in one) + 9.0
    across = min(len(shown), 5)
    rows, wide = -(-len(shown) // across), min((10.08 - 0.3 * (across - 1)) / across, 3.6)
    figure, axes = grid(
        2 * rows, across, width=0.92 + wide * across + 0.3 * (across - 1), height=wide, ratios=(1.0, (keel + top) / (2 * reach)), gaps=(0.3, 0.95), top=0.62,
        between=0.3,
    )  # fmt: skip
    for ax in axes[-2:, len(shown) - across * (rows - 1):].ravel():
        ax.remove()
    for k, (d, h) in enumerate(zip(shown, one, strict=True)):
        plan, side = axes[2 * (k // across) : 2 * (k // across) + 2, k % across]
        colour = COLOURS[(k - 1) % len(COLOURS)] if k else GREY
        _draw_plan(plan, h, colour)
        _draw_side(side, h, colour)
        for profile in _profiles(d, None)[0]:
            plan.plot(profile[:, 0], profile[:, 1], color=INK, lw=0.9)
            side.plot(profile[:, 0], profile[:, 2], color=INK, lw=0.9)
        _hull_axes(plan, side, reach, keel, top, first=k % across == 0)
        plan.set_title(f"{d.label}\nd {float(h.diameter):.1f}, r {float(h.radius):.1f}, draft {float(h.draft):.1f} m", fontsize=8.5 if across < 5 else 7.5)
    caption = "From above and from the side, all to one scale; waves and wind along x. Lines at rest."
    return Drawing(name="hulls", group="designs", title="Hulls of the optima beside the reference", caption=caption, figure=figure)


def _hull_axes(plan, side, reach: float, keel: float, top: float, *, first: bool) -> None:
    """Give plan and side view the scale of all, labels in the first column alone."""
    plan.set(xlim=(-reach, reach), ylim=(-reach, reach))
    side.set(xlim=(-reach, reach), ylim=(-keel, top), xlabel="x [m]")
    for ax, name, ticks in ((plan, "y [m]", 5), (side, "z [m]", 4)):
        ax.grid(False)
        ax.xaxis.set_major_locator(MaxNLocator(4))
        ax.yaxis.set_major_locator(MaxNLocator(ticks))
        if first:
            ax.set_ylabel(name)
        else:
            ax.set_yticklabels([])
    plan.set_xticklabels([])


def _hull_of(shown: Shown) -> SemiHull:
    """Return the one hull of a design with plain numbers."""
    return SemiHull(**{k: float(np.ravel(v)[0]) for k, v in vars(shown.batch.hull).items()})


def _turns() -> np.ndarray:
    return np.array([[[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]] for a in (0.0, 2 * np.pi / 3, 4 * np.pi / 3)])


def _draw_plan(ax, hull: SemiHull, colour: str) -> None:
    for _, start, end in brace_lines(hull):
        for turn in _turns():
            ax.plot(*np.stack([turn @ start, turn @ end])[:, :2].T, color=GREY, lw=1.2, zorder=1.5)
    for a in AZIMUTHS:
        centre = float(hull.radius) * np.array([np.cos(a), np.sin(a)])
        ax.add_patch(Circle(centre, float(hull.plate_diameter) / 2, fc=colour, alpha=0.25, ec=colour, lw=0.8))
        ax.add_patch(Circle(centre, float(hull.diameter) / 2, fc=colour, alpha=0.75, ec=INK, lw=0.8, zorder=2))
    ax.add_patch(Circle((0, 0), float(hull.central_diameter) / 2, fc=colour, alpha=0.75, ec=INK, lw=0.8, zorder=2))


def _draw_side(ax, hull: SemiHull, colour: str) -> None:
    ax.axhline(0, color=SKY, lw=1.1, zorder=3)
    for _, start, end in brace_lines(hull):
        for turn in _turns():
            ax.plot(*np.stack([turn @ start, turn @ end])[:, [0, 2]].T, color=GREY, lw=1.2, zorder=1.5)
    keel, shelf = -float(hull.draft), -float(hull.draft) + float(hull.plate_height)
    places = sorted({round(float(hull.radius) * float(np.cos(a)), 6) for a in AZIMUTHS})
    for x in places:
        for half, low, high, alpha in ((float(hull.plate_diameter) / 2, keel, shelf, 0.45), (float(hull.diameter) / 2, shelf, float(hull.column_freeboard), 0.75)):
            ax.add_patch(_box(x, half, low, high, colour, alpha))
    ax.add_patch(_box(0.0, float(hull.central_diameter) / 2, keel, float(hull.central_freeboard), colour, 0.75))


def _box(x, half, low, high, colour, alpha) -> Polygon:
    return Polygon([(x - half, low), (x + half, low), (x + half, high), (x - half, high)], fc=colour, alpha=alpha, ec=INK, lw=0.7, zorder=2)


def _profiles(shown: Shown, state: str | None) -> np.ndarray:
    """Return the shapes (1, l, n, 3) of a design's lines at rest, or at the mean offset of a state."""
    p = shown.batch.population
    found = p.at_rest if state is None else shown.batch.mean(state).mooring
    return line_profiles(p.mooring, found, 301)[0]


def lines(result: OptimisationResult, findings: Findings) -> Drawing:
    """Return the most loaded line of every design at rest and at the mean offset, seen from its anchor."""
    shown, state = findings.designs, result.study.cost_state
    rows = -(-len(shown) // 2)
    figure, axes = grid(rows, min(len(shown), 2), width=11.0, height=1.55, gaps=(0.55,), top=0.72, between=0.45)
    reach = max(float(np.hypot(*(_profiles(d, s)[0, 0, -1, :2] - _profiles(d, s)[0, 0, 0, :2]))) for d in shown for s in (None, state))
    for k, ax in enumerate(axes.ravel()):
        if k >= len(shown):
            ax.remove()
            continue
        _draw_line(ax, shown[k], state, COLOURS[(k - 1) % len(COLOURS)] if k else INK)
        depth = shown[k].batch.population.depth
        ax.set(xlim=(-0.02 * reach, 1.04 * reach), ylim=(-0.13 * depth, 1.12 * depth))
        ax.axhline(depth, color=SKY, lw=1.0)
        ax.axhline(0, color=SEABED, lw=1.2, zorder=0.9)
        ax.yaxis.set_major_locator(MaxNLocator(4))
        if k >= len(shown) - axes.shape[1]:
            ax.set_xlabel("Distance from the anchor [m]")
        d = shown[k]
        ax.set_title(f"{d.label}: line {d.design[4]:.4g} m, {d.slack:.3f} times the straight distance", fontsize=8.5)
    for ax in axes[:, 0]:
        ax.set_ylabel("Height [m]")
    handles = [Line2D([], [], color=INK, lw=1.2, ls=(0, (4, 2))), Line2D([], [], color=INK, lw=1.4), Line2D([], [], color="black", lw=3.2), Line2D([], [], color=SKY)]
    legend(figure, handles, ["at rest", f"mean offset, state {state}", "on the seabed (upper: at rest)", "still water"])
    caption = f"The most loaded line of every design, in its plane from the anchor towards the platform, at rest and at the mean offset of state {state}. Heights enlarged."
    return Drawing(name="lines", group="designs", title="Lines of the optima beside the reference", caption=caption, figure=figure)


def _draw_line(ax, shown: Shown, state: str, colour: str) -> None:
    """Draw the most loaded line of a design in a state, at rest dashed; what lies on the seabed thick and black."""
    mean = shown.batch.mean(state).mooring
    line = int(np.argmax(mean.fairlead_tension[0]))
    depth = shown.batch.population.depth
    for k, (of, dash) in enumerate(((None, (0, (4, 2))), (state, "-"))):
        points = _profiles(shown, of)[0, line]
        along, up = np.hypot(*(points[:, :2] - points[0, :2]).T), points[:, 2] + depth
        ax.plot(along, up, color=colour, ls=dash, lw=1.4, zorder=3)
        lying = up < 1e-6 * depth
        ax.plot(along[lying], up[lying] - (0.035 + 0.05 * k) * depth, color="black", lw=3.0, ls="-" if k else (0, (1.2, 0.6)), zorder=2, solid_capstyle="butt")


def costs(findings: Findings) -> Drawing:
    """Return the account of every design as stacked bars."""
    shown = findings.designs
    accounts = [cost_account(d.batch) for d in shown]
    figure, axes = grid(1, 1, width=9.0, height=3.0, top=0.75)
    ax, x, base = axes[0, 0], np.arange(len(shown)), np.zeros(len(shown))
    handles, names = [], [i.name for i in accounts[0]]
    for k, colour in zip(range(len(names)), (*COLOURS, GREY), strict=False):
        part = np.array([float(np.ravel(a[k].cost)[0]) for a in accounts]) * 1e-6
        handles.append(ax.bar(x, part, 0.6, bottom=base, color=colour, lw=0))
        base += part
    for place, total in zip(x, base, strict=True):
        ax.text(place, total + 0.01 * base.max(), f"{total:.2f}", ha="center", va="bottom", fontsize=8)
    ax.set_xticks(x)
    ax.set_xticklabels([d.label.replace(", ", ",\n") for d in shown])
    ax.set_ylabel("Cost [M€]")
    ax.set_ylim(0, 1.1 * base.max())
    ax.set_xlim(-0.6, len(shown) - 0.4)
    ax.grid(axis="x", visible=False)
    figure.legend(handles, names, loc="upper left", bbox_to_anchor=(0.055, 1 - 0.05 / figure.get_size_inches()[1]), ncols=3, columnspacing=1.4, borderaxespad=0)
    return Drawing(name="cost", group="designs", title="Cost by item", caption="Cost of the optima and of the reference by item.", figure=figure)
