"""The figures of a study: transfer functions, spectra, hull coefficients, moorings.

model and loads are those of `fowtio.workflow`: a Model, and a sequence of StateLoads. Every function returns a Drawing.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import matplotlib as mpl
import numpy as np
from matplotlib.ticker import MaxNLocator, MultipleLocator

from fowtio.write.quantities import (
    CHANNEL_DOFS,
    MOTIONS,
    TOWER_BASE,
    channel_label,
    has_wind,
    main_headings,
    panel_label,
    people,
    point_label,
    slug,
    spectra_group,
    split_spectra,
    squared,
    state_label,
    tension_channels,
    worth_drawing,
)
from fowtio.write.scene import model_scene, scene_drawing
from fowtio.write.style import (
    BLUE,
    COLOURS,
    DASHES,
    GREY,
    INK,
    ORANGE,
    RC,
    Drawing,
    frequency_axis,
    grid,
    legend,
    log_axis,
    unwrapped,
)
from model.system.hydro import excitation_at, infinite_added_mass, radiation_at
from model.system.mooring import line_profiles
from model.system.mooring_curve import largest_offset, reachable_curve

NACELLE = ("NcIMUTAxs", "NcIMUTAys")
HULL = (("surge", 0), ("heave", 2), ("pitch", 4))
COLUMNS = 4  # panels beside each other
SPECTRUM_DECADES = 4.5


def drawings(model, loads: Sequence) -> Iterator[Drawing]:
    """Give all figures of a study, one after the other, each with a name of its own."""
    used: set[str] = set()
    with mpl.rc_context(RC):
        for drawing in _drawings(model, loads):
            name, k = drawing.name, 2
            while name in used:
                name, k = f"{drawing.name}_{k}", k + 1
            used.add(name)
            yield replace(drawing, name=name)


def _drawings(model, loads: Sequence) -> Iterator[Drawing]:
    for found in _groups(loads):
        yield rao_waves(found, MOTIONS, "motions", "Motions")
        yield rao_waves(found, (*TOWER_BASE, *NACELLE, *_tensions(found[0][0])), "loads", "Loads")
    for point in model.points:
        windy = [item for item in loads if item.point is point and has_wind(item)]
        if windy:
            yield rao_wind(windy)
    for item in loads:
        yield spectra(item, (*MOTIONS, *NACELLE), "motions", "motions")
        yield spectra(item, (*TOWER_BASE, *_tensions(item)), "loads", "tower base and moorings")
    yield scene_drawing(model_scene(model))
    yield hull(model)
    if model.deck.mooring is not None:
        yield mooring_layout(model)
        yield mooring_curve(model)


def _groups(loads: Sequence) -> list[list[tuple]]:
    """Return (state, place of the heading) together that share an operating point and a heading."""
    found: dict[tuple, list] = {}
    for item in loads:
        degrees = np.degrees(item.response.excitation.heading)
        for k in main_headings(item):
            found.setdefault((item.point.wind_speed, round(float(degrees[k]), 3)), []).append((item, k))
    return list(found.values())


def _tensions(item) -> tuple[str, ...]:
    names = item.channels.names
    return tuple(names[k] for k in tension_channels(names))


def rao_waves(found: Sequence[tuple], channels: Sequence[str], kind: str, title: str) -> Drawing:
    """Return magnitude and phase of channels per metre of wave amplitude, a line for each (state, heading)."""
    item, k = found[0]
    heading = float(np.degrees(item.response.excitation.heading[k]))
    values = [i.channels.to_wave[h] for i, h in found]
    where = f"{point_label(item.point.wind_speed)}, waves {heading:g}°"
    figure, few = _transfer([i for i, _ in found], values, channels, "m")
    caption = (
        "Per metre of wave amplitude; drag as linearised in each state. Grey lines: natural frequencies, dashed "
        f"where the motion is its own.{few}"
    )
    return Drawing(
        name=f"rao_{kind}_{slug(point_label(item.point.wind_speed))}_{slug(f'{heading:g}deg')}", group=f"rao_{kind}",
        title=f"{title} in waves: {where}", caption=caption, figure=figure,
    )  # fmt: skip


def rao_wind(items: Sequence) -> Drawing:
    """Return magnitude and phase of motions and loads per m/s of the wind that the rotor sees."""
    speed = items[0].point.wind_speed
    tensions = sorted(_tensions(items[0]), key=lambda n: -items[0].statistics.std[items[0].channels.index(n)])
    chosen = ("PtfmSurge", "PtfmPitch", "PtfmYaw", "TTDspFA", "TwrBsFxt", "TwrBsMyt", "NcIMUTAxs", *tensions[:1])
    figure, few = _transfer(items, [i.channels.to_wind for i in items], chosen, "(m/s)")
    return Drawing(
        name=f"rao_wind_{slug(point_label(speed))}", group="rao_wind",
        title=f"Motions and loads from wind: {point_label(speed)}",
        caption=f"Per metre per second of the wind that the whole rotor sees; its gradients are not drawn.{few}",
        figure=figure,
    )  # fmt: skip


def _transfer(items: Sequence, values: Sequence[np.ndarray], channels: Sequence[str], per: str):
    """Return a figure with magnitude above phase for each channel worth drawing, and a sentence on those left out."""
    names, units = items[0].channels.names, items[0].channels.units
    wanted = [names.index(c) for c in channels if c in names]
    size = np.abs(np.stack(values))[..., wanted].max(axis=(0, 1))
    shown = worth_drawing([names[k] for k in wanted], [units[k] for k in wanted], size)
    left_out = [channel_label(names[k]).lower() for i, k in enumerate(wanted) if i not in shown]
    shown = [wanted[i] for i in shown]
    blocks = -(-len(shown) // COLUMNS)
    columns = max(2, -(-len(shown) // blocks))
    figure, axes = grid(2 * blocks, columns, height=1.7, ratios=(1.0, 0.5), gaps=(0.13, 0.78))
    hertz = [i.response.excitation.omega / (2 * np.pi) for i in items]
    handles = []
    for panel in range(blocks * columns):
        upper, lower = axes[2 * (panel // columns), panel % columns], axes[2 * (panel // columns) + 1, panel % columns]
        if panel >= len(shown):
            upper.remove()
            lower.remove()
            continue
        k = shown[panel]
        unit, factor = people(units[k])
        magnitude = [np.abs(v[:, k]) * factor for v in values]
        handles = [
            upper.plot(f, m, color=COLOURS[n % 6], ls=DASHES[n // 6 % 4])[0] for n,
            (f, m) in enumerate(zip(hertz, magnitude, strict=True))
        ]  # fmt: skip
        log_axis(upper, np.concatenate(magnitude))
        upper.set_title(f"{panel_label(names[k])} [{unit}/{per}]")
        for n, (f, v, m) in enumerate(zip(hertz, values, magnitude, strict=True)):
            phase = np.where(m > m.max() * 1e-4, np.degrees(np.angle(v[:, k])), np.nan)
            lower.plot(f, unwrapped(phase), color=COLOURS[n % 6], ls=DASHES[n // 6 % 4], lw=1.1)
        lower.set_ylim(-190, 190)
        lower.yaxis.set_major_locator(MultipleLocator(180))
        if panel % columns == 0:
            lower.set_ylabel("Phase [deg]")
            upper.set_ylabel("Magnitude")
        for ax in (upper, lower):
            frequency_axis(ax, *_range(items[0]), label=ax is lower)
            _mark_modes(ax, items[0].point.modes, CHANNEL_DOFS.get(names[k]))
    legend(figure, handles, [i.state.name for i in items])
    return figure, f" Not drawn, below 2 % of the largest: {', '.join(left_out)}." if left_out else ""


def _range(item) -> tuple[float, float]:
    """Return the frequencies [Hz] to draw: from a tenth of the lowest natural frequency to the highest of the grid."""
    omega = item.response.excitation.omega
    return max(omega[0], 0.1 * item.point.modes.frequency.min()) / (2 * np.pi), omega[-1] / (2 * np.pi)


def _mark_modes(ax, modes, own: str | None) -> None:
    """Draw the natural frequencies behind the lines, the channel's own dashed."""
    for name, omega in zip(modes.names, modes.frequency, strict=True):
        style = {"color": GREY, "lw": 0.9, "ls": (0, (4, 3))} if name == own else {"color": "#D3D6DB", "lw": 0.7}
        ax.axvline(omega / (2 * np.pi), zorder=0.8, **style)


def spectra(item, channels: Sequence[str], kind: str, title: str) -> Drawing:
    """Return response spectra of a state with the parts that waves and wind cause, and the standard deviations."""
    names, units, drive = item.channels.names, item.channels.units, item.response.excitation
    hertz, factor = drive.omega / (2 * np.pi), 2 * np.pi
    std = item.statistics.std
    wanted = [names.index(c) for c in channels if c in names]
    shown = [wanted[i] for i in worth_drawing([names[k] for k in wanted], [units[k] for k in wanted], std[wanted])]
    waves, wind = split_spectra(item)
    panels = [("Wave elevation", "m", drive.wave_spectrum.sum(axis=0) * factor, None, None)]
    if has_wind(item):
        panels.append(("Wind at the rotor", "m/s", None, drive.wind_spectrum * factor, None))
    for k in shown:
        unit, scale = people(units[k])
        scale = scale**2 * factor
        panels.append(
            (
                panel_label(names[k]),
                unit,
                waves[:, k] * scale,
                wind[:, k] * scale if has_wind(item) else None,
                std[k] * people(units[k])[1],
            )
        )
    rows = -(-len(panels) // COLUMNS)
    columns = -(-len(panels) // rows)
    figure, axes = grid(rows, columns)
    span = _content(hertz, panels)
    for place, ax in enumerate(axes.flat):
        if place >= len(panels):
            ax.remove()
            continue
        _spectrum(ax, hertz, *panels[place])
        frequency_axis(ax, *span, label=place >= len(panels) - columns)
    handles = [mpl.lines.Line2D([], [], color=c, lw=w) for c, w in ((INK, 1.6), (BLUE, 1.3), (ORANGE, 1.3))]
    if has_wind(item):
        legend(figure, handles, ["total", "from waves", "from wind"])
    else:
        legend(figure, handles[1:2], ["from waves"])
    return Drawing(
        name=f"spectra_{kind}_{slug(item.state.name)}", group=spectra_group(item),
        title=f"Response spectra, {title}: {item.state.name}",
        caption=f"{state_label(item.state)}. One-sided spectra; σ is the standard deviation.", figure=figure,
    )  # fmt: skip


def _content(hertz: np.ndarray, panels: Sequence[tuple]) -> tuple[float, float]:
    """Return the frequencies [Hz] between which the spectra of panels have something to show."""
    inside = np.zeros(len(hertz), dtype=bool)
    for _, _, waves, wind, _ in panels:
        total = sum(p for p in (waves, wind) if p is not None)
        inside |= total > total.max() * 10**-SPECTRUM_DECADES
    found = hertz[inside] if np.any(inside) else hertz
    return max(found[0] * 0.8, hertz[0]), min(found[-1] * 1.1, hertz[-1])


def _spectrum(ax, hertz, label: str, unit: str, waves, wind, std: float | None) -> None:
    """Draw one spectrum with its two parts."""
    parts = [p for p in (waves, wind) if p is not None]
    total = sum(parts)
    if not np.any(total):
        ax.set_title(f"{label}: none")
        return
    if len(parts) == 2:
        ax.plot(hertz, total, color=INK, lw=1.6)
    for part, colour in ((waves, BLUE), (wind, ORANGE)):
        if part is not None and np.any(part):
            ax.plot(hertz, np.where(part > 0, part, np.nan), color=colour, lw=1.3)
    log_axis(ax, total, SPECTRUM_DECADES, headroom=20)
    ax.set_title(f"{label} [{squared(unit)}/Hz]")
    if std is not None:
        ax.text(0.985, 0.95, f"σ = {std:.3g} {unit}", transform=ax.transAxes, ha="right", va="top", fontsize=8.5)


def hull(model) -> Drawing:
    """Return added mass, radiation damping and excitation of the hull in surge, heave and pitch."""
    hydro = model.hydro
    omega = np.linspace(hydro.omega[0], min(hydro.omega[-1], 2 * np.pi * 0.35), 400)
    hertz = omega / (2 * np.pi)
    added, damping = radiation_at(hydro, omega)
    headings = sorted({float(s.sea.heading) for s in model.states if s.sea.kind != "still"} or {0.0})
    force = np.abs(excitation_at(hydro, omega, np.array(headings)))
    figure, axes = grid(3, 3, height=1.7, between=0.75)
    for j, (dof, k) in enumerate(HULL):
        turn = dof == "pitch"
        scale, mass_unit, damping_unit, force_unit = (
            (1e-9, "10⁶ t m²", "GN m s", "MN m/m") if turn else (1e-3, "t", "kN s/m", "kN/m")
        )
        label = dof.capitalize()
        axes[0, j].plot(hertz, added[:, k, k] * scale, color=BLUE)
        axes[0, j].axhline(infinite_added_mass(hydro)[k, k] * scale, color=GREY, lw=1, ls=(0, (4, 3)))
        axes[0, j].set_title(f"{label} added mass [{mass_unit}]")
        axes[1, j].plot(hertz, damping[:, k, k] * scale, color=BLUE)
        axes[1, j].set_title(f"{label} radiation damping [{damping_unit}]")
        handles = [
            axes[2, j].plot(hertz, f[:, k] * (1e-6 if turn else 1e-3), color=COLOURS[n % 6], ls=DASHES[n // 6 % 4])[0]
            for n, f in enumerate(force)
        ]
        axes[2, j].set_title(f"{label} excitation [{force_unit}]")
        axes[2, j].set_xlabel("Frequency [Hz]")
        for ax in axes[:, j]:
            low, high = (f([f(line.get_ydata()) for line in ax.lines]) for f in (min, max))
            ax.set_ylim(1.08 * min(low, 0.0), 1.08 * high or 1.0)
            ax.set_xlim(0, hertz[-1])
            ax.yaxis.set_major_locator(MaxNLocator(4))
            ax.xaxis.set_major_formatter("{x:g}")
    legend(figure, handles, [f"waves {np.degrees(h):g}°" for h in headings])
    caption = "About the reference point. Dashed: infinite frequency. Excitation per metre of wave amplitude."
    return Drawing(
        name="hull",
        group="hull",
        title="Hull: added mass, radiation damping, excitation",
        caption=caption,
        figure=figure,
    )


def mooring_layout(model) -> Drawing:
    """Return the moorings from the side and from above, at rest and at every mean offset."""
    system = model.deck.mooring
    figure, axes = grid(1, 2, height=3.9, between=0.8)
    side, plan = axes[0]
    handles = []
    for n, point in enumerate(model.points):
        state, colour = point.mean.mooring, COLOURS[n % 6]
        place = state.offset[:3]
        for line, shape in enumerate(line_profiles(system, state)[0]):
            for ax, k in ((plan, 1), (side, 2)):
                handle = ax.plot(shape[:, 0], shape[:, k], color=colour, lw=1.3)[0]
                if system.point_kind[system.end_b[line]] == "vessel":
                    ax.plot([shape[-1, 0], place[0]], [shape[-1, k], place[k]], color=colour, lw=0.8, alpha=0.6)
        for ax, k in ((plan, 1), (side, 2)):
            ax.plot(place[0], place[k], "o", color=colour, ms=4)
        handles.append(handle)
    side.axhline(0, color="#56B4E9", lw=1)
    side.axhline(-system.depth, color="#8C6D46", lw=1.2, zorder=0.9)
    side.set(xlabel="x [m]", title="From the side, z [m]", ylim=(-1.08 * system.depth, 0.15 * system.depth))
    plan.set(xlabel="x [m]", title="From above, y [m]")
    plan.set_aspect("equal", adjustable="datalim")
    for k, name in enumerate(system.line_names):
        far, near = (system.position[end[k], :2] for end in (system.end_a, system.end_b))
        way = (near - far) / max(np.hypot(*(near - far)), 1e-9)
        plan.annotate(
            str(name),
            far + 0.12 * (near - far),
            xytext=(-9 * way[1], 9 * way[0]),
            textcoords="offset points",
            ha="center",
            va="center",
        )
    legend(figure, handles, [point_label(p.wind_speed) for p in model.points])
    caption = (
        "Lines at the mean offset of each operating point, thin lines from the fairleads to the reference point. "
        "Vertical scale of the side view enlarged."
    )
    return Drawing(
        name="moorings", group="moorings", title="Moorings at the mean offsets", caption=caption, figure=figure
    )


def mooring_curve(model) -> Drawing:
    """Return the restoring force and the tensions of the moorings against horizontal offsets."""
    system = model.deck.mooring
    reach = largest_offset(system, [p.mean.mooring.offset for p in model.points])
    figure, axes = grid(1, 2, height=2.8, top=0.35, between=0.8)
    force_axis, tension_axis = axes[0]
    for name, heading, colour in (("x", 0.0, BLUE), ("y", np.pi / 2, ORANGE)):
        offsets, force, state = reachable_curve(system, heading, reach)
        force_axis.plot(offsets, force * 1e-3, color=colour, label=f"along {name}")
        if name == "x":
            for k, line in enumerate(system.line_names):
                tension_axis.plot(
                    offsets,
                    state.fairlead_tension[:, k] * 1e-3,
                    color=COLOURS[k % 6],
                    ls=DASHES[k % 4],
                    label=f"line {line}",
                )
    for point in model.points:
        at = (point.mean.mooring.offset[0], -point.mean.mooring.force[0] * 1e-3)
        force_axis.plot(*at, "o", color=INK, ms=4)
        force_axis.annotate(point_label(point.wind_speed), at, xytext=(7, -9), textcoords="offset points", fontsize=8)
    force_axis.set(xlabel="Offset [m]", title="Restoring force [kN]")
    tension_axis.set(xlabel="Offset along x [m]", title="Fairlead tension [kN]")
    force_axis.legend(loc="upper left")
    tension_axis.legend(loc="upper center", ncols=min(len(system.line_names), 3))
    caption = "Platform moved horizontally without rotation. Dots: mean offsets of the operating points."
    return Drawing(
        name="mooring_curve",
        group="moorings",
        title="Moorings: force and tension against offset",
        caption=caption,
        figure=figure,
    )
