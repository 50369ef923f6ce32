"""The command line: thin sub-commands over the workflow; errors without tracebacks; JSON on request."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(
    name="fowtio", add_completion=False, no_args_is_help=True, rich_markup_mode=None, pretty_exceptions_enable=False,
    help="Frequency-domain model of a floating wind turbine, read from its OpenFAST deck.",
)  # fmt: skip

CASE = Annotated[Path, typer.Argument(help="study file (.fowt) or OpenFAST primary file (.fst)", show_default=False)]
OUT = Annotated[Path | None, typer.Option("-o", "--out", help="folder for results", show_default=False)]
JSON = Annotated[bool, typer.Option("--json", help="one JSON document on standard output, nothing else there")]
QUIET = Annotated[bool, typer.Option("--quiet", help="no progress and no notes")]
VERBOSE = Annotated[bool, typer.Option("--verbose", help="tracebacks for errors inside fowtio")]
EXIT_INPUT, EXIT_CHECK, EXIT_INTERRUPTED = 1, 3, 130


@app.command()
def init(
    folder: Annotated[Path, typer.Argument(help="a new or empty folder", show_default=False)],
    quiet: QUIET = False, json: JSON = False, verbose: VERBOSE = False,
) -> None:  # fmt: skip
    """Write a study to start from: the embedded OC4 semisubmersible with its deck and linearisations."""
    from fowtio.start import copy_embedded_case

    study = copy_embedded_case(folder)
    if json:
        _print_json({"study": str(study)})
    elif not quiet:
        print(f"{study}\nnext: fowtio check {study}    fowtio run {study}")


@app.command()
def run(
    case: CASE, out: OUT = None, json: JSON = False, quiet: QUIET = False, verbose: VERBOSE = False,
    figures: Annotated[bool, typer.Option(help="draw figures and write the report")] = True,
) -> None:  # fmt: skip
    """The main job: model, natural periods, RAOs, responses and loads; tables, figures, report."""
    from fowtio import report_data, terminal
    from fowtio.case import load
    from fowtio.direct import compare_direct, direct_section
    from fowtio.workflow import build, loads, solve_states
    from fowtio.write.results import write_results

    with terminal.Progress(quiet=quiet or json) as say:
        study = load(case)
        model = build(study, progress=say)
        responses = solve_states(model, progress=say)
        results = loads(responses, study.options.duration)
        folder = out or Path("results") / case.stem
        direct = compare_direct(model, responses[0]) if study.direct else None
        sections = [direct_section(direct)] if direct is not None and figures else []
        files = write_results(
            model, results, folder, figures=figures, report=figures, extra_sections=sections, progress=say
        )
    if json:
        _print_json(report_data.run_json(model, results, folder, files))
    elif not quiet:
        terminal.show_run(model, results, folder, files)


@app.command()
def check(
    path: Annotated[Path, typer.Argument(help="study, deck, or any single file fowtio reads", show_default=False)],
    json: JSON = False, quiet: QUIET = False, verbose: VERBOSE = False,
) -> None:  # fmt: skip
    """Read everything, say what was understood and who contributes what; change nothing."""
    from fowtio import report_data, terminal
    from fowtio.case import SUFFIX, load

    if path.suffix.lower() not in (SUFFIX, ".fst"):
        from fowtio.read import describe

        rows = describe(path)
        if json:
            _print_json({"file": str(path), **{label: text for label, text in rows}})
        else:
            terminal.show_rows(str(path), rows)
        return
    from fowtio.workflow import build

    with terminal.Progress(quiet=quiet or json) as say:
        model = build(load(path), progress=say, speeds=report_data.all_speeds(load(path)))
    if json:
        _print_json(report_data.check_json(model))
    else:
        terminal.show_check(model)


@app.command()
def modes(
    case: CASE, json: JSON = False, quiet: QUIET = False, verbose: VERBOSE = False,
    wind_speed: Annotated[float | None, typer.Option(help="m/s; by default every wind speed of the states", show_default=False)] = None,
) -> None:  # fmt: skip
    """Natural periods, damping and shapes about the mean offset."""
    from fowtio import report_data, terminal
    from fowtio.case import load
    from fowtio.workflow import build

    with terminal.Progress(quiet=quiet or json) as say:
        model = build(load(case), progress=say, speeds=None if wind_speed is None else [wind_speed])
    if json:
        _print_json(report_data.modes_json(model))
    else:
        terminal.show_modes(model)


@app.command()
def validate(
    case: CASE, out: OUT = None, json: JSON = False, quiet: QUIET = False, verbose: VERBOSE = False,
    quadratic: Annotated[bool, typer.Option(help="also solve with quadratic drag itself on every record")] = True,
) -> None:  # fmt: skip
    """Compare RAOs and standard deviations with the reference time series that the study names."""
    from fowtio import report_data, terminal
    from fowtio.case import load
    from fowtio.errors import CaseError, Problem
    from fowtio.validation import validate as compare
    from fowtio.validation import write_validation
    from fowtio.workflow import build

    study = load(case)
    if not study.references:
        raise CaseError([Problem("the study names no reference time series (table NRef)", case)])
    with terminal.Progress(quiet=quiet or json) as say:
        model = build(study, progress=say)
        found = [compare(model, reference, nonlinear=quadratic, progress=say) for reference in study.references]
        files = write_validation(found, out or Path("results") / f"{case.stem}_validation", progress=say)
    if json:
        _print_json(report_data.validation_json(found, files))
    elif not quiet:
        terminal.show_validation(found, files)
    if not all(v.passed for v in found):
        raise typer.Exit(EXIT_CHECK)


@app.command()
def history(
    case: CASE, out: OUT = None, json: JSON = False, quiet: QUIET = False, verbose: VERBOSE = False,
    state: Annotated[str | None, typer.Option(help="name of the state; by default the first", show_default=False)] = None,
    duration: Annotated[float, typer.Option(help="s")] = 3600.0,
    step: Annotated[float, typer.Option(help="s")] = 0.5,
    seed: Annotated[int, typer.Option(help="of the random phases")] = 1,
) -> None:  # fmt: skip
    """Synthesise time histories of every channel of a state, all of the same waves and wind (CSV)."""
    from fowtio import terminal
    from fowtio.case import load
    from fowtio.workflow import state_history
    from fowtio.write.histories import write_histories

    with terminal.Progress(quiet=quiet or json) as say:
        name, series = state_history(load(case), state, duration, step, seed, progress=say)
        file = write_histories(series, (out or Path("results") / case.stem) / f"history_{name}_seed{seed}.csv")
    if json:
        std = dict(zip(series.names, map(float, series.data.std(axis=0)), strict=True))
        _print_json({"file": str(file), "state": name, "std": std, "units": {"std": dict(zip(series.names, series.units, strict=True))}})
    elif not quiet:
        print(f"{file}: {len(series.names)} channels, {len(series.time)} samples of {step:g} s")


@app.command()
def bench(case: CASE, json: JSON = False, quiet: QUIET = False, verbose: VERBOSE = False) -> None:
    """Time the model on this machine: reading, one evaluation, loads."""
    from fowtio import terminal
    from fowtio.bench import time_case

    rows = time_case(case)
    if json:
        _print_json({"timings_s": dict(rows), "units": {"timings_s": "s"}})
    else:
        terminal.show_rows(f"timings of {case}", [(name, f"{seconds * 1e3:9.2f} ms") for name, seconds in rows])


@app.command()
def tower(
    deck: Annotated[Path, typer.Argument(help="OpenFAST primary file (.fst) or ElastoDyn file", show_default=False)],
    out: OUT = None, json: JSON = False, quiet: QUIET = False, verbose: VERBOSE = False,
) -> None:  # fmt: skip
    """Tower natural frequencies and shapes by finite elements; polynomials for ElastoDyn's tower file."""
    from fowtio.tower_report import report_json, show_tower, tower_report, write_tower

    found = tower_report(deck)
    files = write_tower(found, out) if out is not None else []
    if json:
        _print_json(report_json(found, files))
    elif not quiet:
        show_tower(found, files)


def main() -> None:
    """Run the command line; say what is wrong without a traceback and exit with 1."""
    from fowtio.errors import FowtioError

    try:
        app()
    except FowtioError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(EXIT_INPUT)
    except (KeyboardInterrupt, SystemExit) as stop:
        code = EXIT_INTERRUPTED if isinstance(stop, KeyboardInterrupt) else stop.code
        if code == EXIT_INTERRUPTED:
            print("interrupted; nothing was written", file=sys.stderr)
        sys.exit(code)
    except OSError as error:
        print(f"error: {error.filename or ''}: {error.strerror or error}", file=sys.stderr)
        sys.exit(EXIT_INPUT)
    except Exception as error:
        if "--verbose" in sys.argv:
            raise
        print(
            f"internal error: {type(error).__name__}: {error}\nThis is a fault of fowtio's; --verbose shows where. Nothing was written.",
            file=sys.stderr,
        )
        sys.exit(EXIT_INPUT)


def _print_json(document: dict) -> None:
    import json as json_module

    print(json_module.dumps(document, indent=1, allow_nan=False))
