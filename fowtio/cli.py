"""The command line: thin sub-commands over the workflow; errors without tracebacks; JSON on request."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Annotated

import typer

# matrices here are small and many: threads of the linear algebra only stand in each other's way (set before numpy is imported)
for _name in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

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
    study: Annotated[str, typer.Option(help="oc4, oc3_spar, iti_barge, mit_tlp, semi_10mw, table31, table34 or table38")] = "oc4",
    hydro: Annotated[Path | None, typer.Option(help="coefficients to put into it: file, folder or stem; not with oc4", show_default=False)] = None,
    quiet: QUIET = False, json: JSON = False, verbose: VERBOSE = False,
) -> None:  # fmt: skip
    """Write a study to start from: the embedded OC4 semisubmersible with its deck and linearisations, or another reference hull."""
    from fowtio.hull_references import start_reference
    from fowtio.start import copy_embedded_case

    if study == "oc4" and hydro is not None:
        raise typer.BadParameter("the embedded case keeps its coefficients; name others in its study file (HydroFile)", param_hint="--hydro")
    written = copy_embedded_case(folder) if study == "oc4" else start_reference(study, folder, hydro)
    if json:
        _print_json({"study": str(written)})
    elif not quiet:
        print(f"{written}\nnext: fowtio check {written}    fowtio run {written}")


@app.command()
def run(
    case: CASE, out: OUT = None, json: JSON = False, quiet: QUIET = False, verbose: VERBOSE = False,
    figures: Annotated[bool, typer.Option(help="draw figures and write the report")] = True,
) -> None:  # fmt: skip
    """The main job: model, natural periods, RAOs, responses and loads; tables, figures, report."""
    from fowtio import report_data, terminal
    from fowtio.case import load
    from fowtio.direct import compare_direct, direct_section
    from fowtio.kept_dofs import compare_kept, kept_section, whirling
    from fowtio.workflow import build, loads, solve_states
    from fowtio.write.results import write_results

    with terminal.Progress(quiet=quiet or json) as say:
        study = load(case)
        model = build(study, progress=say)
        responses = solve_states(model, progress=say)
        results = loads(responses, study.options.duration)
        folder = out or Path("results") / case.stem
        direct = compare_direct(model, responses[0]) if study.direct else None
        kept, pairs = compare_kept(model, results), whirling(model.points)
        sections = [direct_section(direct)] if direct is not None and figures else []
        sections += [kept_section(kept, pairs)] if kept is not None and figures else []
        files = write_results(
            model, results, folder, figures=figures, report=figures, extra_sections=sections, progress=say
        )
    if json:
        _print_json(report_data.run_json(model, results, folder, files) | report_data.kept_json(kept, pairs))
    elif not quiet:
        terminal.show_run(model, results, folder, files, kept, pairs)


@app.command()
def check(
    path: Annotated[Path, typer.Argument(help="study, deck, or any single file fowtio reads", show_default=False)],
    json: JSON = False, quiet: QUIET = False, verbose: VERBOSE = False,
) -> None:  # fmt: skip
    """Read everything, say what was understood and who contributes what; change nothing."""
    if path.suffix.lower() not in (".fowt", ".fst"):
        from fowtio.file_report import inspection_json, show_inspection
        from fowtio.read import inspect

        found = inspect(path)
        if json:
            _print_json(inspection_json(found))
        elif not quiet:
            show_inspection(found)
        return
    from fowtio import report_data, terminal
    from fowtio.case import load
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
    figures: Annotated[bool, typer.Option(help="draw figures")] = True,
    choices: Annotated[bool, typer.Option(help="also set drag linearisations and ways to the tower loads side by side")] = False,
) -> None:  # fmt: skip
    """Compare with the reference time series that the study names: RAOs, spectra, means, decay tests; report and workbook."""
    from fowtio import report_data, terminal
    from fowtio.case import load
    from fowtio.comparisons import choices_section, compare_choices, drag_table, tower_table
    from fowtio.errors import CaseError, Problem
    from fowtio.validation import validate_study, write_validation
    from fowtio.workflow import build

    study = load(case)
    if not study.references and not study.decays:
        raise CaseError([Problem("the study names no reference time series (table NRef)", case)])
    with terminal.Progress(quiet=quiet or json) as say:
        model = build(study, progress=say)
        found, decays = validate_study(model, nonlinear=quadratic, progress=say)
        folder = out or Path("results") / f"{case.stem}_validation"
        drag, tower = compare_choices(model, found, progress=say) if choices else ((), ())
        extra = [s for s in (choices_section(drag, tower),) if s is not None]
        files = write_validation(found, folder, model=model, decays=decays, figures=figures, extra_sections=extra, progress=say)
    if json:
        document = report_data.validation_json(found, files, decays)
        _print_json(document | ({"drag_models": list(map(vars, drag)), "tower_loads": list(map(vars, tower))} if choices else {}))
    elif not quiet:
        terminal.show_validation(found, files, decays)
        for table in (drag_table(drag), tower_table(tower)) if choices else ():
            terminal.show_table(table)
    if not all(v.passed for v in (*found, *decays)):
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


@app.command()
def bem(
    hull: Annotated[Path, typer.Argument(help="hull file (.toml) or a mesh (.gdf, .stl, .msh)", show_default=False)],
    out: OUT = None, jobs: Annotated[int, typer.Option(help="processes")] = 2,
    against: Annotated[Path | None, typer.Option("--compare", help="coefficients of the same hull: file, folder or stem", show_default=False)] = None,
    figures: Annotated[bool, typer.Option(help="draw the mesh, and the comparison")] = True,
    json: JSON = False, quiet: QUIET = False, verbose: VERBOSE = False,
) -> None:  # fmt: skip
    """Hydrodynamic coefficients of one hull by the boundary-element method (needs the extra bem); a stopped run goes on."""
    from fowtio import terminal
    from fowtio.bem_compare import compare, compare_json, compare_rows
    from fowtio.bem_report import bem_json, bem_rows, draw_bem, reference_hydro
    from fowtio.bem_run import read_hull, run_bem, write_results

    described = read_hull(hull)
    reference = None if against is None else reference_hydro(described, against)
    folder = out or Path("results") / f"{hull.stem}_bem"
    with terminal.Progress(quiet=quiet or json) as say:
        hydro, quality = run_bem(described, folder, jobs=jobs, progress=lambda done, total: say(f"frequency {done} of {total}"))
        files = write_results(described, hydro, folder)
        files += draw_bem(described, hydro, reference, folder) if figures else []
    found = [] if reference is None else compare(hydro, reference)
    if json:
        _print_json(bem_json(described, hydro, quality, files) | ({"comparison": compare_json(found)} if found else {}))
    elif not quiet:
        terminal.show_rows(described.title, bem_rows(described, hydro, quality, files))
        if found:
            terminal.show_rows(f"Differences from {against}", compare_rows(found))


database_app = typer.Typer(help="Coefficients over a grid of hulls: build, check, describe.", no_args_is_help=True)
app.add_typer(database_app, name="database")
DATABASE = Annotated[Path | None, typer.Argument(help="database file; by default the one that comes with fowtio", show_default=False)]


@database_app.command("build")
def database_build(
    out: Annotated[Path, typer.Option("-o", "--out", help="file to write")] = Path("semi_database.nc"),
    folder: Annotated[Path, typer.Option(help="folder of the solutions; a stopped build goes on there")] = Path("database_work"),
    jobs: Annotated[int, typer.Option(help="processes")] = 2,
    dask: Annotated[str | None, typer.Option(help="address of a Dask scheduler, host:port", show_default=False)] = None,
    plan: Annotated[Path | None, typer.Option(help="TOML file of another plan: bounds, points, depths, frequencies, panels", show_default=False)] = None,
    json: JSON = False, quiet: QUIET = False, verbose: VERBOSE = False,
) -> None:  # fmt: skip
    """Solve the family of semisubmersibles (needs the extra bem) and pack it into one file; under an hour on two cores."""
    from fowtio import terminal
    from fowtio.database import DatabasePlan, processor_time, read_plan, solve_plan, write_database
    from fowtio.database_assemble import collect

    plan = read_plan(plan) if plan else DatabasePlan()
    with terminal.Progress(quiet=quiet or json) as say:
        solve_plan(plan, folder, jobs=jobs, dask=dask, progress=lambda done, total: say(f"hull {done} of {total}"))
        path = write_database(collect(plan, folder), out, plan)
    if json:
        _print_json({
            "database": str(path), "size": path.stat().st_size, "processor_time": processor_time(plan, folder), "units": {"size": "byte", "processor_time": "s"}
        })  # fmt: skip
    elif not quiet:
        spent = processor_time(plan, folder)
        print(f"{path} ({path.stat().st_size / 1e6:.1f} MB, {spent:.0f} s of processor time)\nnext: fowtio database check {path}")


@database_app.command("check")
def database_check(
    path: DATABASE = None, hulls: Annotated[int, typer.Option(help="random hulls that the database has not seen")] = 4,
    seed: Annotated[int, typer.Option(help="of the random hulls")] = 1,
    depth: Annotated[float, typer.Option(help="water depth (m), inf is deep")] = 200.0,
    tolerance: Annotated[float, typer.Option(help="largest error allowed (% of each coefficient's maximum)")] = 1.0,
    folder: Annotated[Path | None, typer.Option(help="keep the solutions here", show_default=False)] = None,
    out: OUT = None, jobs: Annotated[int, typer.Option(help="processes")] = 2,
    json: JSON = False, quiet: QUIET = False, verbose: VERBOSE = False,
) -> None:  # fmt: skip
    """Solve random hulls afresh (needs the extra bem) and report the errors of interpolated coefficients and RAOs."""
    from fowtio import terminal
    from fowtio.bem_report import check_database, check_json, check_rows

    with terminal.Progress(quiet=quiet or json) as say:
        say(f"solving {hulls} hulls")
        found = check_database(path, hulls=hulls, seed=seed, depth=depth, jobs=jobs, folder=folder, out=out)
    if json:
        _print_json(check_json(found))
    elif not quiet:
        terminal.show_rows("Interpolated coefficients against solutions (% of each coefficient's maximum)", check_rows(found))
    if max(row["worst"] for row in found) > tolerance / 100:
        raise typer.Exit(EXIT_CHECK)


@database_app.command("info")
def database_info(path: DATABASE = None, json: JSON = False, quiet: QUIET = False, verbose: VERBOSE = False) -> None:
    """Say what a database holds and verify its checksum."""
    from fowtio import terminal
    from fowtio.bem_report import info_rows

    rows = info_rows(path)
    if json:
        _print_json(dict(rows))
    else:
        terminal.show_rows("Coefficient database", rows)


@app.command()
def semi(
    diameter: Annotated[float, typer.Argument(help="of the offset columns (m)", show_default=False)],
    radius: Annotated[float, typer.Argument(help="tower axis to offset columns (m)", show_default=False)],
    draft: Annotated[float, typer.Argument(help="(m)", show_default=False)],
    anchor: Annotated[float, typer.Option(help="anchor radius (m)")] = 837.6,
    length: Annotated[float, typer.Option(help="unstretched line length (m)")] = 835.0,
    depth: Annotated[float, typer.Option(help="water depth (m)")] = 200.0,
    wire: Annotated[bool, typer.Option("--wire", help="spiral strand wire instead of chain")] = False,
    figure: Annotated[Path | None, typer.Option(help="picture to draw: hull, tower and lines to scale", show_default=False)] = None,
    out: OUT = None, json: JSON = False, quiet: QUIET = False, verbose: VERBOSE = False,
) -> None:  # fmt: skip
    """A semisubmersible under the 10 MW turbine from a few numbers: masses, ballast, stability; with -o a deck and a study."""
    from fowtio import terminal
    from fowtio.bem_report import semi_rows
    from fowtio.hull_system import CHAIN, WIRE, SemiDesign, design_deck, thesis_hull

    design = SemiDesign(
        hull=thesis_hull(diameter, radius, draft), anchor_radius=anchor, length=length, depth=depth, line=WIRE if wire else CHAIN
    )
    rows = semi_rows(design)
    if figure is not None:
        from fowtio.bem_figures import draw_system

        draw_system(design, figure)
    study = None if out is None else design_deck(design, out, title=f"a semisubmersible {diameter:g} x {radius:g} x {draft:g} m")
    if json:
        _print_json({name: value for name, _, value, _ in rows} | {"units": {n: u for n, _, _, u in rows}, "study": str(study) if study else None})
    elif not quiet:
        terminal.show_rows("Semisubmersible", [(label, f"{value:.5g} {unit}") for _, label, value, unit in rows] + ([("study", str(study))] if study else []))


@app.command()
def convert(
    source: Annotated[Path, typer.Argument(help="file, folder, or stem of a WAMIT set", show_default=False)],
    target: Annotated[Path, typer.Argument(help="file, stem or folder to write; its suffix tells the format", show_default=False)],
    to: Annotated[str | None, typer.Option(help="wamit, capytaine; map, moordyn, moordyn1; outb, out, csv, netcdf", show_default=False)] = None,
    body: Annotated[int | None, typer.Option(help="of a file of several, from 1", show_default=False)] = None,
    length: Annotated[float | None, typer.Option(help="ULEN of the WAMIT files read (m)", show_default=False)] = None,
    target_length: Annotated[float | None, typer.Option(help="ULEN of the WAMIT files written (m)", show_default=False)] = None,
    density: Annotated[float | None, typer.Option(help="of the water (kg/m3)", show_default=False)] = None,
    gravity: Annotated[float | None, typer.Option(help="m/s2", show_default=False)] = None,
    depth: Annotated[float | None, typer.Option(help="of the water (m)", show_default=False)] = None,
    frequency: Annotated[str | None, typer.Option(help="first column of WAMIT files: period or omega", show_default=False)] = None,
    volume: Annotated[float | None, typer.Option(help="displaced (m3), where a file lacks it", show_default=False)] = None,
    mass: Annotated[float | None, typer.Option(help="that the source's hydrostatics include the weight of (kg)", show_default=False)] = None,
    centre: Annotated[tuple[float, float, float] | None, typer.Option(help="of that mass, x y z (m)", show_default=False)] = None,
    json: JSON = False, quiet: QUIET = False, verbose: VERBOSE = False,
) -> None:  # fmt: skip
    """Write a file in an equivalent format: coefficients, moorings, time series, metocean records, results."""
    from fowtio.convert import convert as change
    from fowtio.file_report import show_files

    if (mass is None) != (centre is None):
        raise typer.BadParameter("--mass and --centre belong together")
    found = change(
        source, target, to=to, body=body, length=length, target_length=target_length, density=density, gravity=gravity, depth=depth,
        frequency=frequency, volume=volume, weight=None if mass is None else (mass, centre),
    )  # fmt: skip
    if json:
        files = [str(f) for f in found.files]
        _print_json({"source": str(source), "read_as": found.read_as, "written_as": found.written_as, "files": files, "notes": list(found.notes)})
    elif not quiet:
        show_files(f"{source}: {found.read_as}, written as {found.written_as}", [*map(str, found.files), *(f"note: {n}" for n in found.notes)])


@app.command()
def contour(
    site: Annotated[str, typer.Argument(help="site file (.site), name of a site that comes with fowtio, or metocean record to fit", show_default=False)],
    return_period: Annotated[float, typer.Option("--return-period", help="years")] = 50.0,
    speed: Annotated[list[float] | None, typer.Option(help="hub wind speed of an isoline, m/s; may be repeated", show_default=False)] = None,
    hub_height: Annotated[float | None, typer.Option(help="m; needed with a record", show_default=False)] = None,
    depth: Annotated[float | None, typer.Option(help="m; needed with a record", show_default=False)] = None,
    wind_height: Annotated[float | None, typer.Option(help="of the record's wind speed, m (default 10)", show_default=False)] = None,
    shear: Annotated[float | None, typer.Option(help="exponent of the power law (default 0.14)", show_default=False)] = None,
    wind: Annotated[str, typer.Option(help="two_parameter, three_parameter or exponentiated Weibull for a record's wind")] = "exponentiated",
    method: Annotated[str, typer.Option(help="likelihood or least_squares")] = "likelihood",
    case: Annotated[Path | None, typer.Option(help="study whose worst state on the contour is sought", show_default=False)] = None,
    channel: Annotated[str, typer.Option(help="channel that is to be largest, with --case")] = "TwrBsMyt",
    figures: Annotated[bool, typer.Option(help="draw figures")] = True,
    out: OUT = None, json: JSON = False, quiet: QUIET = False, verbose: VERBOSE = False,
) -> None:  # fmt: skip
    """Environmental contour of a site: isolines and design points at hub wind speeds; fits a metocean record when given one."""
    from fowtio import site_report, terminal
    from fowtio.case import load
    from fowtio.contour_study import contour_study, open_site
    from fowtio.plane_contour import plane_record, plane_study

    with terminal.Progress(quiet=quiet or json) as say:
        pair = plane_record(site)
        if pair is not None:
            plane = plane_study(*pair, return_period, wind=wind, method=method, progress=say)
            files = site_report.save_plane(plane, out, figures, say)
    if pair is not None:
        if json:
            _print_json(site_report.plane_json(plane, files))
        elif not quiet:
            site_report.show_plane(plane, files)
        return
    with terminal.Progress(quiet=quiet or json) as say:
        place, fit, states, record = open_site(
            site, hub_height=hub_height, depth=depth, wind_height=wind_height, shear=shear, wind=wind, method=method
        )
        study = contour_study(
            place, return_period, speed, fit=fit, states=states, record=record, case=None if case is None else load(case),
            channel=channel, progress=say,
        )  # fmt: skip
        files = site_report.save_contour(study, out, figures, say)
    if json:
        _print_json(site_report.contour_json(study, files))
    elif not quiet:
        site_report.show_contour(study, files)


@app.command()
def fatigue(
    case: CASE,
    site: Annotated[str, typer.Option(help="site file (.site) or name of a site that comes with fowtio", show_default=False)],
    curve: Annotated[str, typer.Option(help="S-N curve of DNV-RP-C203: B1 to W3")] = "D",
    environment: Annotated[str, typer.Option(help="air, seawater (cathodic protection) or free_corrosion")] = "air",
    life: Annotated[float, typer.Option(help="years")] = 25.0,
    design_factor: Annotated[float, typer.Option(help="what damage is multiplied by (DFF)")] = 3.0,
    diameter: Annotated[float | None, typer.Option(help="of the tower base, m; by default from the deck", show_default=False)] = None,
    wall: Annotated[float | None, typer.Option(help="of the tower base, m; by default from the deck", show_default=False)] = None,
    concentration: Annotated[float | None, typer.Option(help="on stress; by default of a girth weld", show_default=False)] = None,
    method: Annotated[str, typer.Option(help="dirlik, tovo_benasciutti, zhao_baker or narrow_band")] = "dirlik",
    mooring: Annotated[str, typer.Option(help="studless_chain, studlink_chain, six_strand_wire or spiral_strand_wire")] = "studless_chain",
    return_period: Annotated[float, typer.Option("--return-period", help="of the ultimate loads, years")] = 50.0,
    verify: Annotated[bool, typer.Option("--verify", help="check the ten worst states by rainflow counting")] = False,
    hours: Annotated[int, typer.Option(help="synthesised of each of them")] = 5,
    figures: Annotated[bool, typer.Option(help="draw figures")] = True,
    out: OUT = None, json: JSON = False, quiet: QUIET = False, verbose: VERBOSE = False,
) -> None:  # fmt: skip
    """Lifetime at a site: fatigue around the tower base and in the moorings, and ultimate loads."""
    from fowtio import site_report, terminal
    from fowtio.case import load
    from fowtio.fatigue_study import fatigue_study, settings_of
    from fowtio.site import load_site

    chosen = settings_of(
        detail=curve, environment=environment, years=life, design_factor=design_factor, diameter=diameter, wall=wall,
        concentration=concentration, method=method, mooring=mooring,
    )  # fmt: skip
    with terminal.Progress(quiet=quiet or json) as say:
        study = fatigue_study(
            load(case), load_site(site), settings=chosen, return_period=return_period, verify=hours if verify else 0, progress=say
        )
        files = site_report.save_fatigue(study, out, figures, say)
    if json:
        _print_json(site_report.fatigue_json(study, files))
    elif not quiet:
        site_report.show_fatigue(study, files)


@app.command()
def cost(
    designs: Annotated[str, typer.Argument(help="cost file (.cost), or name of one that comes with fowtio", show_default=False)],
    figures: Annotated[bool, typer.Option(help="draw figures")] = True,
    out: OUT = None, json: JSON = False, quiet: QUIET = False, verbose: VERBOSE = False,
) -> None:  # fmt: skip
    """Cost of floating foundations, itemised, with their anchors."""
    from fowtio import site_report, terminal
    from fowtio.cost_study import cost_study

    with terminal.Progress(quiet=quiet or json) as say:
        study = cost_study(designs)
        files = site_report.save_cost(study, out, figures, say)
    if json:
        _print_json(site_report.cost_json(study, files))
    elif not quiet:
        site_report.show_cost(study, files)


@app.command("optimise")
def optimise_command(
    study: Annotated[str, typer.Argument(help="optimisation file (.opt), or name of one that comes with fowtio", show_default=False)],
    out: OUT = None,
    stage: Annotated[list[str] | None, typer.Option(help="only this stage and those it builds on; may be given again", show_default=False)] = None,
    jobs: Annotated[int, typer.Option(help="threads")] = 2,
    dask: Annotated[str | None, typer.Option(help="address of a Dask scheduler, host:port", show_default=False)] = None,
    fresh: Annotated[bool, typer.Option("--fresh", help="forget the history in the folder")] = False,
    fmu: Annotated[bool, typer.Option("--fmu", help="also build the FMUs of the designs found")] = False,
    figures: Annotated[bool, typer.Option(help="draw figures")] = True,
    json: JSON = False, quiet: QUIET = False, verbose: VERBOSE = False,
) -> None:  # fmt: skip
    """Search hull and moorings stage by stage; report, history, and the optima as studies with their decks (needs the extra design)."""
    from fowtio.optimise.command import run_study

    run_study(
        study, out, stage or [], jobs=jobs, cluster=dask, fresh=fresh, fmu=fmu, figures=figures, as_json=_print_json if json else None, quiet=quiet
    )


@app.command()
def fmu(
    case: CASE,
    out: Annotated[Path | None, typer.Option("-o", "--out", help="FMU to write; by default named after the study", show_default=False)] = None,
    state: Annotated[str | None, typer.Option(help="state whose operating point and drag are taken; by default the first", show_default=False)] = None,
    fmi: Annotated[str, typer.Option(help="FMI version: 2, 3 or both")] = "2",
    inputs: Annotated[str, typer.Option(help="groups of inputs, by commas: elevation, wave_force, sea, wind, turbulence, platform_force, tower_force; or all")] = "all",
    order: Annotated[int | None, typer.Option(help="states to keep by balanced reduction; by default all", show_default=False)] = None,
    platform: Annotated[str, typer.Option(help="linux64 or win64")] = "linux64",
    check: Annotated[bool, typer.Option("--check", help="validate the FMU and compare it with the frequency-domain model")] = False,
    json: JSON = False, quiet: QUIET = False, verbose: VERBOSE = False,
) -> None:  # fmt: skip
    """Export the linear model about one state as an FMU for co-simulation and model exchange."""
    from fowtio.fmu import command

    command.export(case, out, state, fmi, inputs, order, platform, check, _print_json if json else None, quiet, EXIT_CHECK)


@app.command()
def simulate(
    path: Annotated[Path, typer.Argument(help="an FMU", show_default=False)],
    out: OUT = None, json: JSON = False, quiet: QUIET = False, verbose: VERBOSE = False,
    elevation: Annotated[Path | None, typer.Option(help="OpenFAST .outb or .out whose Wave1Elev drives the FMU; its channels are compared", show_default=False)] = None,
    duration: Annotated[float | None, typer.Option(help="s; by default 600, or the record's", show_default=False)] = None,
    step: Annotated[float | None, typer.Option(help="s; by default 0.1", show_default=False)] = None,
    discard: Annotated[float | None, typer.Option(help="s at the start that are not compared; by default 2000, or half of a shorter record", show_default=False)] = None,
    start: Annotated[list[str] | None, typer.Option(help="parameter and value, as Sea.Hs=3; may be repeated", show_default=False)] = None,
    figures: Annotated[bool, typer.Option(help="draw the figure")] = True,
) -> None:  # fmt: skip
    """Simulate an FMU: time series, a figure, and a comparison with OpenFAST's record for the same waves."""
    from fowtio.fmu import command

    command.simulate_file(path, out, elevation, duration, step, discard, start, figures, _print_json if json else None, quiet)


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
            kept = sys.argv[1:2] in (["bem"], ["optimise"]) or sys.argv[1:3] == ["database", "build"]
            print("interrupted; " + ("what is done is kept, the same command goes on from there" if kept else "nothing was written"), file=sys.stderr)
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
