"""The comparison with time series: RAO figures, a workbook and a netCDF-free table that people can hand on."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np

from fowtio.write.atomic import atomic_folder
from fowtio.write.quantities import people, slug
from fowtio.write.style import AMBER, BLUE, GREY, INK, RC, Drawing, frequency_axis, grid, legend, save
from model.response.identify import WHOLE_BAND

_ROWS = 2


def write_comparison(found: Sequence, folder) -> list[Path]:
    """Write figures (PNG, SVG) and tables (CSV) of validations into a folder; return the files. Nothing is left on failure."""
    folder = Path(folder)
    names: list[str] = []
    with atomic_folder(folder) as inside:
        for item in found:
            with mpl.rc_context(RC):
                drawing = rao_comparison(item)
            save(drawing, inside)
            _table(item).to_csv(inside / f"{slug(item.state)}_rao.csv", index=False, float_format="%.6g")
            _summary(item).to_csv(inside / f"{slug(item.state)}_summary.csv", index=False, float_format="%.6g")
            names += [f"{drawing.name}.png", f"{drawing.name}.svg", f"{slug(item.state)}_rao.csv", f"{slug(item.state)}_summary.csv"]
    return [folder / name for name in names]


def rao_comparison(item) -> Drawing:
    """Return the figure of RAO magnitudes: reference with its confidence band, model, and model with quadratic drag; coherence."""
    f = item.estimate.frequency
    inside = (f >= WHOLE_BAND[0]) & (f <= WHOLE_BAND[1])
    f = f[inside]
    count = len(item.channels)
    columns = min(3, count)
    rows = -(-count // columns)
    figure, axes = grid(_ROWS * rows, columns, ratios=(1.0, 0.35), gaps=(0.12, 0.62))
    spread = 1.96 * np.sqrt((1 - item.estimate.coherence[inside]).clip(0) / (2 * item.estimate.averages))
    handles: dict = {}
    for k, channel in enumerate(item.channels):
        top, low = axes[_ROWS * (k // columns), k % columns], axes[_ROWS * (k // columns) + 1, k % columns]
        unit, factor = people(channel.unit)
        reference = item.estimate.energy_rao[inside, k] * factor
        handles["OpenFAST ± 95 %"] = top.fill_between(f, reference * (1 - spread[:, k]), reference * (1 + spread[:, k]), color=GREY, alpha=0.35, lw=0)
        handles["OpenFAST |H|₂"] = top.plot(f, reference, color=INK, lw=1.0)[0]
        handles["model"] = top.plot(f, item.model_rao[inside, k] * factor, color=BLUE)[0]
        if item.quadratic_rao is not None:
            handles["model, quadratic drag"] = top.plot(f, item.quadratic_rao[inside, k] * factor, color=AMBER, ls="--", lw=1.2)[0]
        top.set_title(f"{channel.name} [{unit}/m], σ {100 * channel.std_error:+.1f} %")
        top.set_ylim(bottom=0)
        frequency_axis(top, f[0], f[-1], label=False)
        low.plot(f, item.estimate.coherence[inside, k], color=GREY, lw=1.0)
        low.set_ylim(0, 1.02)
        low.set_yticks([0, 1])
        low.set_ylabel("γ²")
        frequency_axis(low, f[0], f[-1])
        if k + columns < count:
            low.set_xlabel("")
    for k in range(count, rows * columns):
        for r in range(_ROWS):
            axes[_ROWS * (k // columns) + r, k % columns].set_visible(False)
    legend(figure, list(handles.values()), list(handles))
    caption = (
        f"RAO magnitudes of state {item.state}: {len(item.files)} OpenFAST records, √(Syy/Sηη), Hann segments of "
        f"{item.estimate.segment:.0f} s, about {item.estimate.averages:.0f} independent averages; the model smoothed with the same window. "
        "Below: coherence of the reference."
    )
    title = "RAOs against OpenFAST"
    return Drawing(name=f"validation_{slug(item.state)}", group="validation", title=title, caption=caption, figure=figure)


def _table(item):
    """Return frequency, reference and model RAO magnitudes and coherence of every channel, SI per metre."""
    import pandas as pd

    f = item.estimate.frequency
    inside = (f >= WHOLE_BAND[0]) & (f <= WHOLE_BAND[1])
    data = {"frequency (Hz)": f[inside]}
    for k, channel in enumerate(item.channels):
        unit = f"({channel.unit}/m)"
        data[f"{channel.name} reference {unit}"] = item.estimate.energy_rao[inside, k]
        data[f"{channel.name} model {unit}"] = item.model_rao[inside, k]
        data[f"{channel.name} model unsmoothed {unit}"] = item.model_rao_raw[inside, k]
        if item.quadratic_rao is not None:
            data[f"{channel.name} quadratic drag {unit}"] = item.quadratic_rao[inside, k]
        data[f"{channel.name} coherence (-)"] = item.estimate.coherence[inside, k]
    return pd.DataFrame(data)


def _summary(item):
    """Return the figures of every channel."""
    import pandas as pd

    rows = []
    for c in item.channels:
        bands = {f"RAO error band {k + 1} (-)": e for k, e in enumerate(c.band_errors)}
        rows.append({
            "channel": c.name, "unit": c.unit, "std model": c.std_model, "std reference": c.std_reference, "std error (-)": c.std_error,
            "std error same waves (-)": c.std_error_same_waves, "std error quadratic drag (-)": c.std_error_nonlinear,
            "seed scatter (-)": c.scatter, "mean model": c.mean_model, "mean reference": c.mean_reference, "RAO error (-)": c.rao_error,
            "RAO error quadratic drag (-)": c.rao_error_nonlinear, **bands, "coherence (-)": c.coherence_mean, "peak (Hz)": c.peak_frequency,
            "peak shift (-)": c.peak_frequency_error, "peak height (-)": c.peak_error, "within tolerance": c.passed,
        })  # fmt: skip
    return pd.DataFrame(rows)
