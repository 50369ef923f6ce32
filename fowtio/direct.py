"""The direct route beside the assembled model: the transfer functions that a full-system linearisation holds itself."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from fowtio.errors import ModelError
from fowtio.read.openfast_lin import read_openfast_lin
from fowtio.workflow import Model, StateResponse
from model.response.direct import direct_transfer, wave_input
from model.response.loads import channel_response
from model.system.mbc import azimuth_average

_NAME = re.compile(r"^\w+ (.+?),\s*[\[(](.*)[\])]$")
_TO_SI = {"deg": np.pi / 180, "kN": 1e3, "kN-m": 1e3}


@dataclass(frozen=True, eq=False, kw_only=True)
class DirectComparison:
    """Transfer functions to wave elevation of the direct route and of the assembled model, (n, c) complex, SI, on omega (n)
    [rad/s]; names, units (c); error (c), energy-weighted over the model's wave spectrum; source of the linearisation.
    """

    omega: np.ndarray
    names: tuple[str, ...]
    units: tuple[str, ...]
    direct: np.ndarray
    assembled: np.ndarray
    spectrum: np.ndarray
    error: np.ndarray
    source: str


def compare_direct(model: Model, item: StateResponse) -> DirectComparison:
    """Return the direct route of the study's DirectLin beside one state's response.

    The linearisation has no quadratic drag, so a state without drag, or small waves, is the fair comparison. Raises ModelError
    when the files lack a wave-elevation input or share no channel with the model.
    """
    records = [read_openfast_lin(path) for path in model.case.direct]
    try:
        record = azimuth_average(records, model.deck.elastodyn.structure.rotor.blades)
        column = wave_input(record)
    except ValueError as error:
        raise ModelError(str(error)) from None
    channels = channel_response(item.point.outputs, item.response)
    found = [(k, *_parsed(name)) for k, name in enumerate(record.output_names)]
    shared = [(k, name, unit) for k, name, unit in found if name in channels.names]
    if not shared:
        raise ModelError(f"{record.source} has none of the model's channels among its outputs")
    drive = item.response.excitation
    direct = direct_transfer(record, drive.omega, column, [k for k, _, _ in shared])
    direct = direct * [_TO_SI.get(unit, 1.0) for _, _, unit in shared]
    index = [channels.index(name) for _, name, _ in shared]
    assembled = channels.to_wave[0][:, index]
    weight = (drive.wave_spectrum[0] * np.gradient(drive.omega))[:, None]
    size = (np.abs(assembled) ** 2 * weight).sum(axis=0)
    error = np.sqrt((np.abs(direct - assembled) ** 2 * weight).sum(axis=0) / np.maximum(size, 1e-300))
    return DirectComparison(
        omega=drive.omega, names=tuple(name for _, name, _ in shared), units=tuple(channels.units[i] for i in index), direct=direct,
        assembled=assembled, spectrum=drive.wave_spectrum[0], error=error, source=record.source,
    )  # fmt: skip


def direct_section(comparison: DirectComparison):
    """Return the report section: errors and figure."""
    from fowtio.write.report import Section
    from fowtio.write.style import as_picture
    from fowtio.write.table import Column, Table

    rows = tuple((n, u, 100 * e) for n, u, e in zip(comparison.names, comparison.units, comparison.error, strict=True))
    columns = (Column(name="Channel"), Column(name="Unit"), Column(name="Difference", unit="%", decimals=2))
    note = "Energy-weighted over the state's wave spectrum, phases included; the linearisation holds no quadratic drag."
    table = Table(name="direct", title="Direct route against the assembled model", columns=columns, rows=rows, note=note)
    return Section(title="Direct route", content=(table, as_picture(_drawing(comparison))))


def _drawing(comparison: DirectComparison):
    import matplotlib as mpl

    from fowtio.write.quantities import people
    from fowtio.write.style import BLUE, INK, RC, Drawing, frequency_axis, grid, legend

    hz = comparison.omega / (2 * np.pi)
    count = len(comparison.names)
    with mpl.rc_context(RC):
        columns = min(3, count)
        figure, axes = grid(-(-count // columns), columns)
        for k, ax in enumerate(axes.ravel()):
            if k >= count:
                ax.set_visible(False)
                continue
            unit, factor = people(comparison.units[k])
            one = ax.plot(hz, np.abs(comparison.direct[:, k]) * factor, color=INK, lw=1.0)[0]
            two = ax.plot(hz, np.abs(comparison.assembled[:, k]) * factor, color=BLUE, ls="--")[0]
            ax.set_title(f"{comparison.names[k]} [{unit}/m]")
            frequency_axis(ax, max(hz[0], 1e-3), hz[-1])
        legend(figure, [one, two], ["linearisation itself", "assembled model"])
    caption = f"Transfer functions of {comparison.source.rsplit('/', 1)[-1]}, C (iω − A)⁻¹ B + D, beside the assembled model's."
    return Drawing(name="direct_route", group="direct", title="Direct route", caption=caption, figure=figure)


def _parsed(name: str) -> tuple[str, str]:
    """Return the channel name and unit of an output, 'ED PtfmPitch, (deg)'."""
    match = _NAME.match(name)
    return (match[1], match[2]) if match else (name, "")
