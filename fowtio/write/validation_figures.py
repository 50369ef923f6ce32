"""Figures of comparisons with time series: RAOs with confidence bounds, spectra with histories and histograms, decay tests.

found are `fowtio.validation.Validation`, decays `fowtio.validation_lack.DecayComparison`. Every function returns a Drawing.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.ticker import MultipleLocator
from scipy.stats import chi2, norm

from fowtio.write.quantities import panel_label, people, slug, squared, tension_channels
from fowtio.write.style import (
    AMBER,
    BLUE,
    GREEN,
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
from model.response.decay import amplitude_history
from model.response.measures import WHOLE_BAND

MOTIONS, LOADS = ("PtfmSurge", "PtfmHeave", "PtfmPitch"), ("TTDspFA", "TwrBsFxt", "TwrBsMyt", "NcIMUTAxs")
THESIS = {
    "rigid": {"PtfmSurge": 32, "PtfmHeave": 33, "PtfmPitch": 34, "tension": 35},
    "tower": {"PtfmSurge": 36, "PtfmHeave": 37, "PtfmPitch": 38, "tension": 39, "TTDspFA": 40, "TwrBsFxt": 41, "TwrBsMyt": 42},
    "wind": {"PtfmSurge": 45, "PtfmHeave": 46, "PtfmPitch": 47, "TTDspFA": 48, "TwrBsFxt": 49, "TwrBsMyt": 50, "tension": 51},
}  # fmt: skip
WINDOW = 600.0  # s of a history


def drawings(found: Sequence, decays: Sequence = (), *, thesis: bool = False) -> Iterator[Drawing]:
    """Give all figures of comparisons; thesis adds the numbers of the source thesis's figures that show the same."""
    with mpl.rc_context(RC):
        for item in found:
            numbers = _numbers(item) if thesis else {}
            if item.kind == "waves":
                for names, label in _groups(item):
                    yield rao_figure(item, names, label, numbers)
                yield history_figure(item, _present(item, (*MOTIONS, *LOADS[:1])), numbers)
            elif item.kind == "spectra":
                for names, label in _groups(item):
                    yield spectra_figure(item, names, label, numbers)
        if decays:
            yield decay_figure(decays)


def main_tension(item) -> str | None:
    """Return the fairlead tension that moves most, as the upwind line's does."""
    names = [c.name for c in item.channels]
    lines = tension_channels(names)
    return names[max(lines, key=lambda k: item.channels[k].std_reference)] if lines else None


def _numbers(item) -> dict[str, int]:
    """Return the numbers of the thesis's figures by channel."""
    kind = "wind" if item.kind == "spectra" else "tower" if any(c.name == "TTDspFA" for c in item.channels) else "rigid"
    return {main_tension(item) if k == "tension" else k: v for k, v in THESIS[kind].items()}


def _present(item, names) -> list[str]:
    known = [c.name for c in item.channels]
    return [n for n in names if n in known]


def _groups(item) -> list[tuple[list[str], str]]:
    """Return the channels of each figure with a label: motions and mooring, tower, the others."""
    tension = main_tension(item)
    first, second = _present(item, (*MOTIONS, tension)), _present(item, LOADS)
    rest = [c.name for c in item.channels if c.name not in (*first, *second)]
    named = ((first, "motions"), (second, "tower"), (rest, "other channels"))
    return [(names, label) for names, label in named if names]


def _titled(item, name: str, unit: str, numbers: dict[str, int]) -> str:
    number = f"  (thesis Fig. {numbers[name]})" if name in numbers else ""
    return f"{panel_label(name)} [{unit}]{number}"


def rao_figure(item, names: Sequence[str], label: str, numbers: dict[str, int]) -> Drawing:
    """Return RAO magnitudes and phases with confidence bounds, and coherences."""
    e = item.estimate
    inside = (e.frequency >= WHOLE_BAND[0]) & (e.frequency <= WHOLE_BAND[1])
    f = e.frequency[inside]
    low, high = (b[inside] for b in e.energy_bounds())
    h1, radius = e.coherent_rao[inside], e.coherent_radius()[inside]
    columns = 2 if len(names) > 1 else 1
    figure, axes = grid(
        3 * -(-len(names) // columns), columns, height=2.5, ratios=(1.0, 0.36, 0.26), gaps=(0.1, 0.1, 0.62)
    )
    handles: dict = {}
    for n, name in enumerate(names):
        k = next(i for i, c in enumerate(item.channels) if c.name == name)
        unit, factor = people(item.channels[k].unit)
        top, middle, bottom = (axes[3 * (n // columns) + r, n % columns] for r in range(3))
        handles["reference, 95 %"] = top.fill_between(
            f, low[:, k] * factor, high[:, k] * factor, color=GREY, alpha=0.35, lw=0
        )
        handles["reference |H|₂"] = top.plot(f, e.energy_rao[inside, k] * factor, color=INK, lw=0.9, zorder=4)[0]
        handles["model, unsmoothed"] = top.plot(
            f, item.model_rao_raw[inside, k] * factor, color=BLUE, lw=0.7, alpha=0.55, ls=":"
        )[0]
        handles["model"] = top.plot(f, item.model_rao[inside, k] * factor, color=BLUE, lw=2.2)[0]
        for array, text, colour in (
            (item.quadratic_rao, "quadratic drag", AMBER),
            (item.memory_rao, "and HydroDyn's memory", ORANGE),
        ):
            if array is not None:
                handles[text] = top.plot(f, array[inside, k] * factor, color=colour, ls=(0, (4, 2)), lw=1.0)[0]
        c = item.channels[k]
        top.set_title(_titled(item, name, f"{unit}/m", numbers))
        left = np.log(f[np.nanargmax(e.energy_rao[inside, k])] / f[0]) > 0.6 * np.log(f[-1] / f[0])  # the side without the peak
        top.text(
            0.02 if left else 0.985,
            0.96,
            f"σ {_signed(c.std_error)} %\nRAO error {100 * c.rao_error:.1f} %",
            transform=top.transAxes,
            ha="left" if left else "right",
            va="top",
            fontsize=8.5,
        )
        top.set_ylim(bottom=0)
        phase = np.degrees(np.angle(h1[:, k]))
        ratio = np.clip(radius[:, k] / np.maximum(np.abs(h1[:, k]), 1e-300), 0, 1)
        spread = np.degrees(np.arcsin(ratio))
        gap = np.isnan(unwrapped(phase)) | np.isnan(unwrapped(phase[::-1])[::-1])
        middle.fill_between(f, phase - spread, phase + spread, where=~gap, color=GREY, alpha=0.35, lw=0)
        if item.model_phase is not None:
            middle.plot(f, unwrapped(np.degrees(item.model_phase[inside, k])), color=BLUE, lw=2.0)
        middle.plot(f, unwrapped(phase), color=INK, lw=0.9)
        middle.set_ylim(-190, 190)
        middle.yaxis.set_major_locator(MultipleLocator(180))
        if item.model_coherence is not None:
            bottom.plot(f, item.model_coherence[inside, k], color=BLUE, lw=2.0)
        bottom.plot(f, e.coherence[inside, k], color=INK, lw=0.9)
        bottom.set_ylim(0, 1.05)
        bottom.set_yticks([0, 1])
        if n % columns == 0:
            top.set_ylabel("Magnitude")
            middle.set_ylabel("Phase [deg]")
            bottom.set_ylabel("γ²")
        for ax in (top, middle, bottom):
            frequency_axis(ax, f[0], f[-1], label=ax is bottom)
    _hide(axes, 3, columns, len(names))
    legend(figure, list(handles.values()), list(handles))
    caption = (
        f"State {item.state}: {len(item.files)} records of {item.duration:.0f} s, {e.averages:.0f} independent averages of {e.segment:g} s. Magnitude √(Syy/Sηη) with "
        "95 % bounds, phase of Sηy/Sηη, coherence γ²; the model seen through the same window."
    )
    return Drawing(
        name=f"validation_{slug(item.state)}_{slug(label)}",
        group=f"validation {item.state}",
        title=f"RAOs against time series: {label}",
        caption=caption,
        figure=figure,
    )


def spectra_figure(item, names: Sequence[str], label: str, numbers: dict[str, int]) -> Drawing:
    """Return spectra with confidence bounds, a part of the history and the distribution of every channel, a row each."""
    e, h = item.estimate, item.histories
    n = e.degrees_of_freedom
    low, high = n / chi2.ppf(0.975, n), n / chi2.ppf(0.025, n)
    top = min(0.5 / item.step, 1.0)
    inside = (e.frequency >= 1.5 / e.segment) & (e.frequency <= top)
    f = e.frequency[inside]
    figure, axes = grid(len(names), 3, height=1.75, gaps=(0.62,), between=0.6)
    _widen(axes, (0.40, 0.42, 0.18))
    handles: dict = {}
    for row, name in enumerate(names):
        k = next(i for i, c in enumerate(item.channels) if c.name == name)
        c = item.channels[k]
        unit, factor = people(c.unit)
        left, middle, right = axes[row]
        reference = e.output_spectrum[inside, k] * factor**2
        handles["reference, 95 %"] = left.fill_between(
            f, reference * low, reference * high, color=GREY, alpha=0.35, lw=0
        )
        handles["reference"] = left.plot(f, reference, color=INK, lw=1.0)[0]
        handles["model"] = left.plot(f, item.model_spectrum[inside, k] * factor**2, color=BLUE, lw=1.4)[0]
        handles["model, waves alone"] = left.plot(
            f, item.wave_part[inside, k] * factor**2, color=GREEN, lw=1.0, ls=(0, (4, 2))
        )[0]
        log_axis(left, reference, 5.5, headroom=30)
        frequency_axis(left, f[0], f[-1], label=row == len(names) - 1)
        left.set_title(_titled(item, name, f"{squared(unit)}/Hz", numbers))
        left.text(
            0.985, 0.95, f"σ {_signed(c.std_error)} %", transform=left.transAxes, ha="right", va="top", fontsize=8.5
        )
        part = h.time < h.time[0] + WINDOW
        middle.plot(h.time[part], h.reference[part, k] * factor, color=INK, lw=0.9)
        handles["model, phases of the reference"] = middle.plot(
            h.time[part], h.phases[part, k] * factor, color=BLUE, lw=0.9, alpha=0.85
        )[0]
        if np.isfinite(h.predicted[0, k]):
            handles["model, same waves and rotor wind"] = middle.plot(
                h.time[part], h.predicted[part, k] * factor, color=ORANGE, lw=0.9, ls=(0, (4, 2))
            )[0]
        middle.set_title(
            f"History [{unit}], correlation {c.correlation:.2f}"
            + (f" and {c.correlation_same_waves:.2f}" if np.isfinite(c.correlation_same_waves) else "")
        )
        middle.set_xlim(h.time[0], h.time[0] + WINDOW)
        _histogram(right, item, k, c)
        if row == len(names) - 1:
            middle.set_xlabel("Time [s]")
            right.set_xlabel("Deviation / σ")
    legend(figure, list(handles.values()), list(handles))
    caption = (
        f"State {item.state}: {len(item.files)} records of {item.duration:.0f} s. Spectra with 95 % bounds ({n:.0f} degrees of freedom), the model in the reference's own waves"
        f"{' and the wind that its rotor felt' if item.felt_wind else ''}; first {WINDOW:.0f} s of the first record; distribution of all records beside the normal one (line)."
    )
    return Drawing(
        name=f"validation_{slug(item.state)}_{slug(label)}",
        group=f"validation {item.state}",
        title=f"Wind and waves against time series: {label}",
        caption=caption,
        figure=figure,
    )


def history_figure(item, names: Sequence[str], numbers: dict[str, int]) -> Drawing:
    """Return parts of the first record's histories beside the model driven by the same waves."""
    h = item.histories
    figure, axes = grid(len(names), 2, height=1.25, gaps=(0.5,), between=0.6)
    _widen(axes, (0.8, 0.2))
    handles: dict = {}
    part = h.time < h.time[0] + WINDOW
    for row, name in enumerate(names):
        k = next(i for i, c in enumerate(item.channels) if c.name == name)
        c = item.channels[k]
        unit, factor = people(c.unit)
        left, right = axes[row]
        handles["reference"] = left.plot(h.time[part], h.reference[part, k] * factor, color=INK, lw=1.0)[0]
        handles["model, same waves"] = left.plot(
            h.time[part], h.predicted[part, k] * factor, color=ORANGE, lw=1.0, ls=(0, (4, 2))
        )[0]
        left.set_title(f"{panel_label(name)} [{unit}], correlation {c.correlation_same_waves:.3f}")
        left.set_xlim(h.time[0], h.time[0] + WINDOW)
        _histogram(right, item, k, c)
    axes[-1, 0].set_xlabel("Time [s]")
    axes[-1, 1].set_xlabel("Deviation / σ")
    legend(figure, list(handles.values()), list(handles))
    caption = f"State {item.state}: first {WINDOW:.0f} s of the first record after the transient, deviations from the mean; distribution of all records beside the normal one (line)."
    return Drawing(
        name=f"validation_{slug(item.state)}_histories",
        group=f"validation {item.state}",
        title="Time histories",
        caption=caption,
        figure=figure,
    )


def decay_figure(decays: Sequence) -> Drawing:
    """Return the histories of decay tests and the damping ratio against the amplitude."""
    figure, axes = grid(len(decays), 2, height=1.7, gaps=(0.78,), between=0.75)
    _widen(axes, (0.62, 0.38))
    handles: dict = {}
    for row, d in enumerate(decays):
        unit, factor = people(d.unit)
        left, right = axes[row]
        found = d.found
        handles["reference"] = left.plot(d.time, (d.motion - found.offset) * factor, color=INK, lw=1.0)[0]
        own = amplitude_history(
            found.time,
            2 * np.pi / float(d.model.period[0]),
            d.model_linear,
            d.model_quadratic,
            found.start,
            found.phase,
        )
        handles["model, from the first extreme on"] = left.plot(
            found.time, own * factor, color=BLUE, lw=1.0, ls=(0, (4, 2))
        )[0]
        left.set_title(
            f"{panel_label(d.channel)} [{unit}], period {found.period:.2f} s, model {_signed(d.period_error, 2)} %"
        )
        left.set_xlim(d.time[0], min(d.time[-1], d.time[0] + 25 * found.period))
        handles["reference, by cycle"] = right.plot(
            found.amplitude * factor, 100 * found.cycle_damping, "o", color=GREY, ms=3.5
        )[0]
        line = d.model.amplitude
        handles["reference, fit"] = right.plot(line * factor, 100 * found.damping(line), color=INK, lw=1.0)[0]
        right.plot(line * factor, 100 * d.model.damping, color=BLUE, lw=1.2, ls=(0, (4, 2)))
        right.set_title("Damping ratio [%]")
        right.set_xlim(left=0)
        right.set_ylim(0, max(1.25 * 100 * float(d.model.damping.max()), 0.1))
        if row == len(decays) - 1:
            left.set_xlabel("Time [s]")
        right.set_xlabel(f"Amplitude [{unit}]")
    legend(figure, list(handles.values()), list(handles))
    caption = "Free decay in still water. The model's drag is linearised for harmonic motion at each amplitude; its radiation and structural damping do not depend on it."
    return Drawing(name="validation_decays", group="decays", title="Decay tests", caption=caption, figure=figure)


def _histogram(ax, item, k: int, c) -> None:
    edges = item.histogram_edges
    ax.stairs(item.histograms[:, k], edges, color=GREY, fill=True, alpha=0.5)
    x = np.linspace(-4.5, 4.5, 91)
    ax.plot(x, norm.pdf(x), color=INK, lw=0.9)
    ax.set_xlim(-4.5, 4.5)
    ax.set_yticks([])
    ax.set_title(f"kurtosis {_signed(c.excess_kurtosis / 100, 2)}")


def _widen(axes, shares: Sequence[float]) -> None:
    """Give the columns of a grid other widths, as shares of their sum."""
    boxes = [ax.get_position() for ax in axes[0]]
    gap = boxes[1].x0 - boxes[0].x1
    total = sum(b.width for b in boxes)
    for row in axes:
        x = boxes[0].x0
        for ax, share in zip(row, shares, strict=True):
            box = ax.get_position()
            ax.set_position([x, box.y0, total * share, box.height])
            x += total * share + gap


def _hide(axes, rows: int, columns: int, count: int) -> None:
    for n in range(count, len(axes) // rows * columns):
        for r in range(rows):
            axes[rows * (n // columns) + r, n % columns].set_visible(False)


def _signed(fraction: float, places: int = 1) -> str:
    """Return a fraction in per cent with its sign."""
    return f"{100 * fraction:+.{places}f}".replace("-", "−")
