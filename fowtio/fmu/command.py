"""What the commands `fmu` and `simulate` do and print."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import typer

from fowtio import terminal
from fowtio.errors import ModelError
from fowtio.fmu.build import VERSIONS, Exported, Linearised, export_fmu
from fowtio.fmu.check import Finding, check_fmu
from fowtio.fmu.describe import GROUPS
from fowtio.fmu.simulate import Simulation, read_unit, simulate, write_simulation
from fowtio.write.table import ROW, Column, Table
from model.conventions import PLATFORM_DOFS
from model.reduce.radiation import least_error

_FMI = {"2": ("2.0",), "2.0": ("2.0",), "3": ("3.0",), "3.0": ("3.0",), "both": VERSIONS}


def export(
    case: Path, out: Path | None, state: str | None, fmi: str, inputs: str, order: int | None, platform: str, check: bool,
    as_json: Callable[[dict], None] | None, quiet: bool, failed: int,
) -> None:  # fmt: skip
    """Export a study as an FMU, check it when asked to, print what was done; leave with `failed` when a check is not met."""
    from fowtio.case import load
    from fowtio.workflow import build

    if fmi not in _FMI:
        raise ModelError(f"FMI version is {fmi!r}; there are 2, 3 and both")
    groups = GROUPS if inputs == "all" else tuple(part.strip() for part in inputs.split(",") if part.strip())
    with terminal.Progress(quiet=quiet or as_json is not None) as say:
        model = build(load(case), progress=say)
        written = export_fmu(
            model,
            out or Path(f"{case.stem}.fmu"),
            state=state,
            versions=_FMI[fmi],
            inputs=groups,
            order=order,
            platform=platform,
            progress=say,
        )
        findings = check_fmu(written, progress=say) if check else []
    if as_json is not None:
        as_json(_export_json(written, findings))
    elif not quiet:
        terminal.show_rows(written.description.title, _rows(written))
        if findings:
            terminal.show_rows("checks", [(f.name, ("ok: " if f.passed else "NOT MET: ") + f.text) for f in findings])
    if not all(f.passed for f in findings):
        raise typer.Exit(failed)


def simulate_file(
    path: Path, out: Path | None, elevation: Path | None, duration, step, discard, start: Sequence[str] | None, figures: bool,
    as_json: Callable[[dict], None] | None, quiet: bool,
) -> None:  # fmt: skip
    """Simulate an FMU, write series, comparison and figure, print what was found."""
    with terminal.Progress(quiet=quiet or as_json is not None) as say:
        say("simulating")
        found = simulate(
            path, duration=duration, step=step, elevation=elevation, start=_parameters(start), discard=discard
        )
        files = write_simulation(found, out or Path("results") / path.stem, figures=figures)
    if as_json is not None:
        as_json(_simulation_json(found, files))
    elif not quiet:
        print(f"{path.name}, {found.time[-1]:g} s in steps of {found.time[1]:g} s")
        terminal.show_table(_comparison(found) if found.matches else _statistics(found))
        print()
        terminal.show_rows("written", [(f.name, str(f)) for f in files])


def _comparison(found: Simulation) -> Table:
    """Return the table of the channels beside those of the reference."""
    rows = []
    for m in found.matches:
        unit, factor = read_unit(m.unit)
        rows.append((m.name, m.channel, unit, m.std_fmu * factor, m.std_reference * factor, 100 * m.std_error, m.correlation))
    return Table(
        name="comparison", title="Beside the reference, driven by the same waves", rows=tuple(rows),
        columns=(
            Column(name="Output"), Column(name="Channel"), Column(name="Unit"), Column(name="σ FMU", unit=ROW), Column(name="σ reference", unit=ROW),
            Column(name="Difference", unit="%"), Column(name="Correlation", decimals=4),
        ), note=f"After the first {found.discard:g} s. The FMU's drag is linear; the reference's is not.",
    )  # fmt: skip


def _statistics(found: Simulation) -> Table:
    """Return the table of means and standard deviations."""
    rows = []
    for name, own, values in zip(found.names, found.units, found.values.T, strict=True):
        unit, factor = read_unit(own)
        rows.append((name, unit, float(values.mean()) * factor, float(values.std()) * factor))
    columns = (Column(name="Output"), Column(name="Unit"), Column(name="Mean", unit=ROW), Column(name="σ", unit=ROW))
    return Table(name="statistics", title="Mean and standard deviation", columns=columns, rows=tuple(rows))


def _short(names: Sequence[str]) -> str:
    """Return names of variables, the six components of a force and moment as one."""
    out = []
    for name in names:
        stem, _, axis = name.rpartition("Force")
        if stem and axis == "X":
            out.append(f"{stem}ForceX ... {stem.split('.')[-1]}MomentZ")
        elif not (stem and axis in ("Y", "Z")) and "Moment" not in name:
            out.append(name)
    return ", ".join(out) or "none"


def _parameters(given: Sequence[str] | None) -> dict[str, float]:
    """Return parameters from texts as Sea.Hs=3; raise ModelError for another form."""
    out = {}
    for text in given or ():
        name, _, value = text.partition("=")
        try:
            out[name.strip()] = float(value)
        except ValueError:
            raise ModelError(f"--start is {text!r}; expected a name and a number, as Sea.Hs=3") from None
    return out


def _rows(written: Exported) -> list[tuple[str, str]]:
    """Return what people should know of an export."""
    found, d = written.linearised, written.description
    radiation, excitation = found.radiation, found.excitation
    rows = [(f"FMI {v}", f"{p} ({p.stat().st_size / 1e3:.0f} kB)") for v, p in written.files.items()]
    rows += [
        ("states", f"{found.space.order}" + (f", error bound of the reduction {found.reduction_bound:.2g}" if found.reduction_bound else "")),
        ("inputs", _short([v.name for v in d.of_kind("input")])),
        ("radiation", "; ".join(f"{' and '.join(b)}: {o} poles" for b, o in zip(radiation.blocks, radiation.orders, strict=True))),
        ("radiation fit", _radiation_words(found)),
    ]  # fmt: skip
    if excitation is not None:
        rows.append(
            (
                "excitation fit",
                f"{len(excitation.a)} states, {excitation.shift:g} s late; largest error {100 * excitation.worst:.2f} % of a response",
            )
        )
    return rows


def _radiation_words(found: Linearised) -> str:
    """Return how well the radiation is fitted, and what any passive kernel would miss of a motion whose own error exceeds one per cent."""
    radiation = found.radiation
    out = f"largest error {100 * radiation.largest_error:.2f} % of a pair's peak; least damping {radiation.least_damping[1]:.1e} of the peak"
    for k, dof in enumerate(PLATFORM_DOFS):
        if radiation.error[k, k] > 0.01:
            floor = least_error(found.point.system.hydro, k)
            out += f"; {dof} {100 * radiation.error[k, k]:.2f} %, where added mass and damping leave any passive kernel {100 * floor:.2f} % at least"
    return out


def _export_json(written: Exported, findings: Sequence[Finding]) -> dict:
    d = written.description
    return {
        "files": {v: str(p) for v, p in written.files.items()}, "size_bytes": {v: p.stat().st_size for v, p in written.files.items()},
        "inputs": [v.name for v in d.of_kind("input")], "outputs": [v.name for v in d.of_kind("output")],
        "parameters": [v.name for v in (*d.of_kind("parameter"), *d.of_kind("integer"))], "time_shift": d.time_shift, "notes": d.notes,
        "checks": [{"name": f.name, "passed": f.passed, "text": f.text} for f in findings], "units": {"time_shift": "s"},
    }  # fmt: skip


def _simulation_json(found: Simulation, files: Sequence[Path]) -> dict:
    statistics = {
        n: {"mean": float(v.mean()), "std": float(v.std())} for n, v in zip(found.names, found.values.T, strict=True)
    }
    return {
        "fmu": str(found.path), "duration": float(found.time[-1]), "step": float(found.time[1]), "discard": found.discard, "statistics": statistics,
        "comparison": {
            m.name: {
                "channel": m.channel, "std": m.std_fmu, "std_reference": m.std_reference, "std_error": m.std_error, "correlation": m.correlation,
                "difference": m.difference,
            } for m in found.matches
        },
        "files": [str(f) for f in files],
        "units": {"duration": "s", "step": "s", "discard": "s", "statistics": dict(zip(found.names, found.units, strict=True))},
    }  # fmt: skip
