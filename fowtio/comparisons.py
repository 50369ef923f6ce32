"""Modelling choices side by side against the same time series: drag linearisations, and ways to the tower-base loads."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fowtio.case import Reference
from fowtio.validation import Validation, validate
from fowtio.workflow import Model

DRAG = {
    "third_order": "relative velocity, to third order", "relative": "relative velocity, element by element", "body": "body velocity, element by element",
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


def compare_choices(
    model: Model, found: Sequence[Validation], *, progress: Callable[[str], None] = lambda text: None
) -> tuple[tuple[DragComparison, ...], tuple[TowerComparison, ...]]:
    """Return drag models against the first reference of waves alone, and ways to the tower loads against all references."""
    waves = next((r for r, v in zip(model.case.references, found, strict=True) if v.kind == "waves"), None)
    drag = compare_drag_models(model, waves, progress=progress) if waves is not None else ()
    return drag, tuple(row for v in found for row in compare_tower_loads(model, v))


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


TOWER_BANDS = ((0.002, 0.006), (0.006, 0.02), (0.02, 0.05), (0.05, 0.1), (0.1, 0.2), (0.2, 0.5), (0.5, 0.8))  # Hz
_SECTIONS = {"TwrBsFxt": "shear", "TwrBsMyt": "moment"}


@dataclass(frozen=True, kw_only=True)
class TowerComparison:
    """Error of a tower-base load's spectrum in one band [Hz]: integrated loads, and modal stiffness alone; and of both ways alone, from
    the reference's own tower-top deflection instead of the model's."""

    state: str
    channel: str
    band: tuple[float, float]
    full: float
    modal: float
    full_way: float
    modal_way: float
    share: float


def compare_tower_loads(model: Model, found: Validation) -> tuple[TowerComparison, ...]:
    """Return band by band how the two ways to the tower-base loads agree with a reference.

    Errors are sqrt(sum (sqrt(S) - sqrt(S_ref))^2 / sum S_ref) over the bands in which the reference has more than 1e-5 of its variance;
    the modal version is C77 q7 and that times the tower's length (thesis eq. 5.7, 5.8).
    """
    names = [c.name for c in found.channels]
    if found.model_spectrum is None or "TTDspFA" not in names:
        return ()
    state = next(s for s in model.states if s.name == found.state)
    point = model.at(state.wind_speed)
    stiffness = point.system.stiffness[point.system.dofs.index("tower_fa1"), point.system.dofs.index("tower_fa1")]
    length = model.deck.elastodyn.structure.tower.length
    f, top = found.estimate.frequency, found.model_spectrum[:, names.index("TTDspFA")]
    to_reference = found.estimate.output_spectrum[:, names.index("TTDspFA")] / np.where(top > 0, top, np.nan)
    out = []
    for name in (n for n in _SECTIONS if n in names):
        k = names.index(name)
        reference, full = found.estimate.output_spectrum[:, k], found.model_spectrum[:, k]
        modal = top * (stiffness * (length if name == "TwrBsMyt" else 1.0)) ** 2
        for band in TOWER_BANDS:
            inside = (f >= band[0]) & (f < band[1])
            energy = np.nansum(reference[inside])
            if energy < 1e-5 * np.nansum(reference):
                continue
            errors = [
                float(np.sqrt(np.nansum((np.sqrt(s[inside]) - np.sqrt(reference[inside])) ** 2) / energy))
                for s in (full, modal, full * to_reference, modal * to_reference)
            ]
            out.append(
                TowerComparison(
                    state=found.state, channel=name, band=band, full=errors[0], modal=errors[1], full_way=errors[2], modal_way=errors[3],
                    share=float(energy / np.nansum(reference)),
                )
            )  # fmt: skip
    return tuple(out)


def tower_table(rows: tuple[TowerComparison, ...]):
    """Return the comparison of tower-base loads as a table for people."""
    from fowtio.write.table import Column, Table

    columns = (
        Column(name="State"), Column(name="Load"), Column(name="From", unit="Hz", decimals=3), Column(name="To", unit="Hz", decimals=3),
        Column(name="Share of variance", unit="%", decimals=1), Column(name="Integrated", unit="%", decimals=1),
        Column(name="Modal stiffness", unit="%", decimals=1), Column(name="Integrated, way alone", unit="%", decimals=1),
        Column(name="Modal, way alone", unit="%", decimals=1),
    )  # fmt: skip
    body = tuple((r.state, r.channel, *r.band, *(100 * v for v in (r.share, r.full, r.modal, r.full_way, r.modal_way))) for r in rows)
    note = (
        "Error of the spectrum's root in each band; integrated: inertia, gravity and air above the section. Way alone: from the reference's "
        "own tower-top deflection, so that errors of the motion do not hide or heal those of the way to the load."
    )
    return Table(name="tower_loads", title="Tower-base loads: two ways, against the time series", columns=columns, rows=body, note=note)


def choices_section(drag: Sequence[DragComparison], tower: Sequence[TowerComparison]):
    """Return the report section of both comparisons, None when there is nothing to compare."""
    from fowtio.write.report import Section

    tables = tuple(make(tuple(rows)) for make, rows in ((drag_table, drag), (tower_table, tower)) if rows)
    return Section(title="Modelling choices side by side", content=tables) if tables else None
