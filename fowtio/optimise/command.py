"""What the command `optimise` does and prints."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from fowtio import terminal
from fowtio.optimise.export import export_design
from fowtio.optimise.report import optimisation_json, summary_tables, write_optimisation
from fowtio.optimise.run import OptimisationResult, optimise
from fowtio.optimise.sensitivity import findings_of
from fowtio.optimise.study import load_optimisation
from fowtio.optimise.workers import workers


def run_study(
    name: str, out: Path | None, stages: Sequence[str], *, jobs: int, cluster: str | None, fresh: bool, fmu: bool, figures: bool,
    as_json: Callable[[dict], None] | None, quiet: bool,
) -> None:  # fmt: skip
    """Run an optimisation study, write history, report and the designs found, print what was found."""
    study = load_optimisation(name)
    folder = out or Path("results") / study.path.stem
    with terminal.Progress(quiet=quiet or as_json is not None) as say, _stoppable(folder), workers(jobs, cluster) as spread:
        result = optimise(study, folder, stages=stages or None, fresh=fresh, mapper=spread, progress=say)
        found = findings_of(result, say)
        files = write_optimisation(result, folder, findings=found, figures=figures, progress=say)
        designs = export_optima(result, folder, fmu=fmu, progress=say)
    if as_json is not None:
        as_json(optimisation_json(result, files, found) | {"designs": {n: str(p) for n, p in designs.items()}})
    elif not quiet:
        print(study.title)
        for table in summary_tables(result, found):
            terminal.show_table(table)
        terminal.show_rows("\nwritten", [("report", str(folder / "optimisation.html")), ("history", str(folder / "history")), *((f"design of {n}", str(p)) for n, p in designs.items())])


def export_optima(result: OptimisationResult, folder: Path, *, fmu: bool, progress: Callable[[str], None]) -> dict[str, Path]:
    """Write the optimum of every stage with one objective as a study with its deck, with an FMU when asked, and return the studies."""
    out = {}
    for name, stage in result.stages.items():
        if stage.best is None:
            continue
        progress(f"writing the design of stage {name}")
        out[name] = export_design(result, name, stage.optimum, folder / "designs" / name)
        if fmu:
            _export_fmu(out[name], progress)
    return out


def _export_fmu(study: Path, progress: Callable[[str], None]) -> None:
    from fowtio.case import load
    from fowtio.fmu.build import export_fmu
    from fowtio.workflow import build

    progress(f"building the FMU of {study.stem}")
    export_fmu(build(load(study)), study.with_suffix(".fmu"), progress=progress)


@contextmanager
def _stoppable(folder: Path) -> Iterator[None]:
    """Turn a request to terminate into an interruption, and say how to go on."""
    def stop(*_):
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, stop)
    try:
        yield
    except KeyboardInterrupt:
        raise SystemExit(_told(folder)) from None
    finally:
        signal.signal(signal.SIGTERM, before)


def _told(folder: Path) -> int:
    import sys

    print(f"stopped; every finished generation is in {folder / 'history'}, the same command goes on from there", file=sys.stderr)
    return 143
