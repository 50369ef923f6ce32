"""One look for all figures: colours, axes, frequencies; no pyplot and no global state.

Colours are those of Okabe and Ito, which people with colour vision deficiencies can tell apart.
"""

from __future__ import annotations

import io
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, NullFormatter, NullLocator

BLUE, ORANGE, GREEN, SKY, PURPLE, AMBER, INK, GREY = (
    "#0072B2",
    "#D55E00",
    "#009E73",
    "#56B4E9",
    "#CC79A7",
    "#E69F00",
    "#222222",
    "#8A8F98",
)
COLOURS = (BLUE, ORANGE, GREEN, PURPLE, AMBER, SKY)
DASHES = ("-", "--", "-.", ":")
DPI = 150
RC = {
    "font.family": "sans-serif", "font.sans-serif": ["DejaVu Sans"], "font.size": 9, "axes.titlesize": 9.5,
    "axes.labelsize": 9,
    "xtick.labelsize": 8, "ytick.labelsize": 8, "legend.fontsize": 8.5, "axes.linewidth": 0.7, "axes.edgecolor": GREY,
    "axes.labelcolor": INK, "text.color": INK, "xtick.color": GREY, "ytick.color": GREY, "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "xtick.major.width": 0.7, "ytick.major.width": 0.7, "xtick.major.size": 3, "ytick.major.size": 3,
    "xtick.minor.size": 0,
    "ytick.minor.size": 0, "axes.grid": True, "grid.color": "#E6E8EB", "grid.linewidth": 0.7, "axes.axisbelow": True,
    "lines.linewidth": 1.5,
    "lines.solid_capstyle": "round", "legend.frameon": False, "axes.spines.top": False, "axes.spines.right": False,
    "figure.facecolor": "white",
    "svg.fonttype": "none", "axes.titlelocation": "left", "axes.titlepad": 5, "axes.titley": 1.0,
    "path.simplify_threshold": 0.2, "axes.unicode_minus": True,
}  # fmt: skip


@dataclass(frozen=True, eq=False, kw_only=True)
class Drawing:
    """A figure with what belongs to it: file name without suffix, group (by which reports place it), title, caption."""

    name: str
    group: str
    title: str
    caption: str
    figure: Figure


@dataclass(frozen=True, kw_only=True)
class Picture:
    """A figure that has been drawn: as in Drawing, with its SVG as text."""

    name: str
    group: str
    title: str
    caption: str
    svg: str


def grid(
    rows: int,
    columns: int,
    *,
    width: float = 11.0,
    height: float = 1.9,
    ratios=(1.0,),
    gaps=(0.5,),
    top: float = 0.55,
    between: float = 0.65,
):
    """Return a figure and its axes (rows, columns) with margins in inches, so that no layout has to be searched.

    width of all, height of a row of ratio 1, ratios of the rows and gaps below them (both repeated), top margin, gap
    between columns [in].
    """
    left, right, bottom = 0.7, 0.22, 0.5
    heights = [height * ratios[i % len(ratios)] for i in range(rows)]
    below = [gaps[i % len(gaps)] for i in range(rows - 1)] + [bottom]
    total = top + sum(heights) + sum(below)
    figure = Figure(figsize=(width, total))
    wide = (width - left - right - between * (columns - 1)) / columns
    axes = np.empty((rows, columns), dtype=object)
    y = total - top
    for i in range(rows):
        y -= heights[i]
        for j in range(columns):
            axes[i, j] = figure.add_axes(
                [(left + j * (wide + between)) / width, y / total, wide / width, heights[i] / total]
            )
        y -= below[i]
    return figure, axes


def save(drawing: Drawing, folder: Path) -> Picture:
    """Write a drawing as PNG and SVG into a folder and return it as a picture."""
    with mpl.rc_context({**RC, "svg.hashsalt": drawing.name}):
        drawing.figure.set_dpi(DPI)
        FigureCanvasAgg(drawing.figure).print_png(folder / f"{drawing.name}.png", pil_kwargs={"compress_level": 4})
        svg = _svg(drawing.figure)
    (folder / f"{drawing.name}.svg").write_text(svg, encoding="utf-8")
    return Picture(name=drawing.name, group=drawing.group, title=drawing.title, caption=drawing.caption, svg=svg)


def as_picture(drawing: Drawing) -> Picture:
    """Return a drawing as a picture without writing files."""
    with mpl.rc_context({**RC, "svg.hashsalt": drawing.name}):
        svg = _svg(drawing.figure)
    return Picture(name=drawing.name, group=drawing.group, title=drawing.title, caption=drawing.caption, svg=svg)


def _svg(figure: Figure) -> str:
    """Return a figure as SVG without prologue, metadata and names of groups: for a page, the same every time."""
    stream = io.StringIO()
    figure.set_dpi(72)
    FigureCanvasSVG(figure).print_svg(stream, metadata={"Date": None, "Creator": None})
    text = stream.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"\s*<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    return re.sub(r'<g id="[^"]*"', "<g", text)


def frequency_axis(ax: Axes, low: float, high: float, label: bool = True) -> None:
    """Make x a logarithmic frequency axis in Hz with plain numbers."""
    ax.set_xscale("log")
    ax.set_xlim(low, high)
    steps = (1,) if high / low > 400 else (1, 3) if high / low > 30 else (1, 2, 5)
    ticks = [t for t in (m * 10.0**e for e in range(-6, 4) for m in steps) if low * 0.999 <= t <= high * 1.001]
    ax.xaxis.set_major_locator(FixedLocator(ticks))
    ax.xaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
    ax.xaxis.set_minor_locator(NullLocator())
    if label:
        ax.set_xlabel("Frequency [Hz]")
    else:
        ax.xaxis.set_major_formatter(NullFormatter())


def log_axis(ax: Axes, values: np.ndarray, decades: float = 3.5, headroom: float = 2.0) -> None:
    """Make y logarithmic, from the largest of values (times headroom) down some decades, with plain numbers."""
    top = float(np.nanmax(values))
    ax.set_yscale("log")
    ax.set_ylim(top * 10**-decades, top * headroom)
    ax.yaxis.set_major_locator(LogLocator(numticks=6))
    ax.yaxis.set_minor_locator(NullLocator())
    ax.yaxis.set_major_formatter(FuncFormatter(plain))


def plain(value: float, _=None) -> str:
    """Return a number for a logarithmic axis: plain where short, else as 10 with an exponent."""
    if value <= 0:
        return "0"
    if 1e-3 <= value < 1e5:
        return f"{value:g}"
    exponent = round(math.log10(value))
    return "10" + "".join("⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".index(c)] for c in str(exponent))


def legend(figure: Figure, handles: Sequence, labels: Sequence[str]) -> None:
    """Put one legend for all axes at the top left of a figure."""
    height = figure.get_size_inches()[1]
    figure.legend(
        handles,
        labels,
        loc="upper left",
        bbox_to_anchor=(0.055, 1 - 0.04 / height),
        ncols=min(len(labels), 6),
        handlelength=2.0,
        borderaxespad=0.0,
        columnspacing=1.6,
    )


def unwrapped(phase: np.ndarray) -> np.ndarray:
    """Return phases [deg] with a gap where they jump from one end of the circle to the other."""
    out = np.array(phase)
    out[1:][np.abs(np.diff(phase)) > 180] = np.nan
    return out
