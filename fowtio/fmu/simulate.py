"""Simulate an FMU: time series, a figure, and a comparison with a reference record driven by the same waves."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from fowtio.errors import FormatError
from fowtio.fmu.runner import Runner
from fowtio.read.openfast_out import TimeSeries, read_openfast_out
from fowtio.write.atomic import atomic_folder
from fowtio.write.quantities import people
from fowtio.write.style import BLUE, INK, RC, Drawing, grid, legend, save

WAVE = "Wave1Elev"
TO_SI = {"deg": np.pi / 180, "kN": 1e3, "kN-m": 1e3, "kN·m": 1e3}
SMALL = 0.1  # s
SHOWN = 600.0  # s of the figure
STILL = 1e-3  # of the largest of its kind: a channel that moves less is not compared
_WRITTEN = {"N.m": "N m", "m/s2": "m/s^2", "rad/s2": "rad/s²"}  # units of FMI, as written elsewhere


@dataclass(frozen=True, kw_only=True)
class ChannelMatch:
    """One channel beside the reference after the transient: standard deviations, error of the first as a fraction, correlation, and
    the root mean square of the difference over the reference's standard deviation.
    """

    name: str
    channel: str
    unit: str
    std_fmu: float
    std_reference: float
    std_error: float
    correlation: float
    difference: float


@dataclass(frozen=True, eq=False, kw_only=True)
class Simulation:
    """Time series of an FMU: time (t) [s], names, units, values (t, c); the reference record (None without one), the first seconds that
    are not compared, the channels compared.
    """

    path: Path
    time: np.ndarray
    names: tuple[str, ...]
    units: tuple[str, ...]
    values: np.ndarray
    reference: TimeSeries | None
    discard: float
    matches: tuple[ChannelMatch, ...]
    openfast: dict[str, str]


def simulate(
    path: str | Path,
    *,
    duration: float | None = None,
    step: float | None = None,
    elevation: str | Path | None = None,
    start: Mapping[str, float] | None = None,
    outputs: Sequence[str] | None = None,
    discard: float | None = None,
) -> Simulation:
    """Return the time series of an FMU in co-simulation.

    Parameters
    ----------
    path : the FMU
    duration, step : [s]; by default 600 s in steps of 0.1 s; with a record its own duration, and a whole fraction of its own step
    elevation : an OpenFAST .outb or .out file whose wave elevation (Wave1Elev) drives the FMU, earlier by the FMU's time shift
    start : parameters by name, as Sea.Hs
    outputs : names; None takes all
    discard : seconds at the start that are not compared; None takes 2000, or half of a shorter record

    Raises FormatError for a file, an FMU or a name that is not what it should be.
    """
    record = None if elevation is None else read_openfast_out(elevation)
    with Runner(path) as runner:
        inputs: dict[str, np.ndarray] = {}
        if record is not None:
            own = float(np.median(np.diff(record.time)))
            step = own / max(1, round(own / (step or SMALL)))
            duration = duration or float(record.time[-1] - record.time[0])
        step, duration = step or SMALL, duration or 600.0
        steps = max(1, round(duration / step))
        time = np.arange(steps + 1) * step
        if record is not None:
            if "Wave.Elevation" not in runner.variables:
                raise FormatError(
                    path,
                    expected="an FMU with the input Wave.Elevation",
                    found=", ".join(runner.names("input")) or "no input",
                )
            inputs["Wave.Elevation"] = _early(record, step, steps, runner.constant("Wave.TimeShift"))
        names = tuple(
            outputs
            or [
                v.name
                for v in runner.description.modelVariables
                if v.causality == "output" and v.variability != "constant"
            ]
        )
        values = runner.run(steps, step, inputs, names, start)
        units = tuple(runner.variables[n].unit or "1" for n in names)
    channels = openfast_channels(path)
    discard = discard if discard is not None else min(2000.0, duration / 2)
    matches = () if record is None else _compare(time, names, units, values, record, channels, discard)
    return Simulation(
        path=Path(path),
        time=time,
        names=names,
        units=units,
        values=values,
        reference=record,
        discard=discard,
        matches=matches,
        openfast=channels,
    )


def read_unit(unit: str) -> tuple[str, float]:
    """Return the unit that people read for a unit of an FMU, and the factor to it."""
    return people(_WRITTEN.get(unit, unit))


def openfast_channels(path: str | Path) -> dict[str, str]:
    """Return OpenFAST's channel name of each output of an FMU that fowtio wrote; empty for others."""
    with zipfile.ZipFile(path) as archive:
        if "resources/fowtio.json" not in archive.namelist():
            return {}
        return dict(json.loads(archive.read("resources/fowtio.json"))["openfast_channels"])


def write_simulation(found: Simulation, folder: str | Path, *, figures: bool = True) -> list[Path]:
    """Write the time series as CSV, the comparison as CSV, and a figure; return the files."""
    folder = Path(folder)
    with atomic_folder(folder) as inside:
        head = ",".join(["time [s]", *(f"{n} [{u}]" for n, u in zip(found.names, found.units, strict=True))])
        np.savetxt(
            inside / "series.csv",
            np.column_stack([found.time, found.values]),
            fmt="%.9g",
            delimiter=",",
            header=head,
            comments="",
        )
        if found.matches:
            lines = ["output,channel,unit,std_fmu,std_reference,std_error,correlation,difference"]
            lines += [",".join([m.name, m.channel, m.unit, *(f"{getattr(m, f):.6g}" for f in ("std_fmu", "std_reference", "std_error", "correlation", "difference"))])
                      for m in found.matches]  # fmt: skip
            (inside / "comparison.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
        if figures:
            save(draw(found), inside)
        written = sorted(p.name for p in inside.iterdir())
    return [folder / name for name in written]


def draw(found: Simulation) -> Drawing:
    """Return the figure: the last minutes of the channels, the reference beside them."""
    matched = {m.name: m for m in found.matches}
    shown = list(matched) or [n for n in found.names if not n.endswith(("Velocity", "Acceleration"))]
    shown = [n for n in shown if np.ptp(found.values[:, found.names.index(n)]) > 0][:8] or list(found.names[:1])
    with rc_context(RC):
        figure = _panels(found, shown, matched)
    beside = " beside a reference driven by the same waves" if matched else ""
    return Drawing(
        name="series",
        group="simulation",
        title="Time series",
        caption=f"The last minutes of the FMU's simulation{beside}.",
        figure=figure,
    )


def _panels(found: Simulation, shown: Sequence[str], matched: Mapping[str, ChannelMatch]) -> Figure:
    """Return a figure with one panel for each output shown."""
    figure, axes = grid(len(shown), 1, height=1.15, gaps=(0.42,))
    late = found.time >= found.time[-1] - SHOWN
    for row, name in enumerate(shown):
        ax, k = axes[row, 0], found.names.index(name)
        unit, factor = read_unit(found.units[k])
        if name in matched:
            time, data = _reference_series(found.reference, matched[name].channel)
            inside = time >= found.time[-1] - SHOWN
            ax.plot(time[inside], data[inside] * factor, color=INK, linewidth=1.0, label="reference")
        ax.plot(found.time[late], found.values[late, k] * factor, color=BLUE, linewidth=1.1, label="FMU")
        ax.set_title(f"{name} [{unit}]")
        ax.set_xlim(found.time[late][0], found.time[-1])
        if row < len(shown) - 1:
            ax.xaxis.set_major_formatter(NullFormatter())
    axes[-1, 0].set_xlabel("Time [s]")
    unique = {h.get_label(): h for ax in axes[:, 0] for h in ax.get_lines()}
    legend(figure, list(unique.values()), list(unique))
    return figure


def _early(record: TimeSeries, step: float, steps: int, shift: float) -> np.ndarray:
    """Return the record's wave elevation `shift` seconds ahead (steps + 1), repeated at its end as OpenFAST's waves are.

    Between its samples by its Fourier series: straight lines would take energy from the short waves.
    """
    count = len(record.time) - 1
    own = (record.time[-1] - record.time[0]) / count
    finer = max(1, round(own / step))
    spectrum = np.fft.rfft(record.channel(WAVE)[:count])
    spectrum = spectrum * np.exp(2j * np.pi * np.fft.rfftfreq(count, own) * shift)
    period = np.fft.irfft(spectrum, count * finer) * finer
    return period[np.arange(steps + 1) % len(period)]


def _reference_series(record: TimeSeries, channel: str) -> tuple[np.ndarray, np.ndarray]:
    return record.time - record.time[0], record.channel(channel) * TO_SI.get(record.unit(channel), 1.0)


def _compare(
    time, names, units, values, record: TimeSeries, channels: dict[str, str], discard: float
) -> tuple[ChannelMatch, ...]:
    """Return the outputs beside the channels of the same name that move."""
    known = {n.lower() for n in record.names}
    late = time >= discard
    rows = []
    for k, name in enumerate(names):
        channel = channels.get(name, "")
        if channel.lower() not in known:
            continue
        at, data = _reference_series(record, channel)
        rows.append((k, name, channel, np.interp(time[late], at, data)))
    largest = {}
    for k, _, _, data in rows:
        largest[units[k]] = max(largest.get(units[k], 0.0), float(data.std()))
    out = []
    for k, name, channel, data in rows:
        if data.std() <= STILL * largest[units[k]] or data.std() == 0:
            continue
        own = values[late, k]
        difference = (own - own.mean()) - (data - data.mean())
        correlation = float(np.corrcoef(own, data)[0, 1]) if own.std() > 0 else 0.0
        out.append(
            ChannelMatch(
                name=name, channel=channel, unit=units[k], std_fmu=float(own.std()), std_reference=float(data.std()),
                std_error=float(own.std() / data.std() - 1), correlation=correlation, difference=float(difference.std() / data.std()),
            )
        )  # fmt: skip
    return tuple(out)
