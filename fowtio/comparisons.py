"""Modelling choices side by side against the same time series: drag linearisations, and ways to the tower-base loads."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from fowtio.case import Reference
from fowtio.validation import Validation, validate
from fowtio.workflow import Model

DRAG = {
    "relative": "relative velocity, element by element", "body": "body velocity, element by element",
    "global": "body velocity, one for all strips and one for all plates",
}  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class DragComparison:
    """RAO errors of one channel for each drag model: over the whole band, and within 15 % of its resonance."""

    channel: str
    whole: dict[str, float]
    resonance: dict[str, float]
    frequency: float


def compare_drag_models(
    model: Model, reference: Reference, *, progress: Callable[[str], None] = lambda text: None
) -> tuple[DragComparison, ...]:
    """Return RAO errors against time series for every drag linearisation; raise what `validate` raises."""
    found: dict[str, Validation] = {}
    for drag in DRAG:
        progress(f"drag model {drag}")
        options = replace(model.case.options, drag_model=drag)
        found[drag] = validate(replace(model, case=replace(model.case, options=options)), reference, nonlinear=False)
    first = next(iter(found.values()))
    return tuple(
        DragComparison(
            channel=channel.name, frequency=channel.peak_frequency,
            whole={d: v.channels[k].rao_error for d, v in found.items()},
            resonance={d: _near(v, k, channel.peak_frequency) for d, v in found.items()},
        ) for k, channel in enumerate(first.channels)
    )  # fmt: skip


def _near(found: Validation, k: int, frequency: float) -> float:
    """Return the energy-weighted RAO error of a channel within 15 % of a frequency [Hz]."""
    f = found.estimate.frequency
    inside = np.abs(f / frequency - 1) < 0.15
    reference, model = found.estimate.energy_rao[inside, k], found.model_rao[inside, k]
    weight = found.estimate.input_spectrum[inside]
    return float(np.sqrt(np.nansum((model - reference) ** 2 * weight) / np.nansum(reference**2 * weight)))


def drag_table(rows: tuple[DragComparison, ...]):
    """Return the comparison of drag models as a table for people."""
    from fowtio.write.table import Column, Table

    columns = [Column(name="Channel"), Column(name="Resonance", unit="Hz", decimals=4)]
    for part in ("whole band", "at resonance"):
        columns += [Column(name=f"{d}, {part}", unit="%", decimals=1) for d in DRAG]
    body = tuple(
        (r.channel, r.frequency, *(100 * r.whole[d] for d in DRAG), *(100 * r.resonance[d] for d in DRAG)) for r in rows
    )
    note = "RAO error; " + "; ".join(f"{d}: {text}" for d, text in DRAG.items())
    return Table(name="drag_models", title="Drag linearisations against the time series", columns=tuple(columns), rows=body, note=note)
