"""A tower's natural frequencies and shapes from an ElastoDyn deck: what `fowtio tower` computes, prints and writes."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import matplotlib as mpl
import numpy as np

from fowtio.errors import FormatError, ModelError
from fowtio.read.elastodyn import read_elastodyn
from fowtio.read.openfast_deck import Deck, deck_hydro, read_deck
from fowtio.read.openfast_input import read_input
from fowtio.write.atomic import atomic_folder
from fowtio.write.style import BLUE, GREY, INK, ORANGE, RC, Drawing, grid, legend, save
from fowtio.write.table import Column, Table
from model.system.hydro import infinite_added_mass
from model.system.mooring import mooring_state
from model.system.tower import TOWER_MODES, polynomial
from model.system.tower_fe import (
    PolynomialFit,
    TowerShapes,
    bending_modes,
    clamped_frequencies,
    fit_polynomials,
    with_modes,
)
from model.system.turbine import RigidBody, TurbineStructure, platform_matrices, rotor_nacelle

GRAVITY = 9.80665
_GROUPS = {"tower_fa1": "TwFAM1Sh", "tower_fa2": "TwFAM2Sh", "tower_ss1": "TwSSM1Sh", "tower_ss2": "TwSSM2Sh"}
_LABELS = {"tower_fa1": "fore-aft 1", "tower_fa2": "fore-aft 2", "tower_ss1": "side-side 1", "tower_ss2": "side-side 2"}


@dataclass(frozen=True, eq=False, kw_only=True)
class TowerSet:
    """Bending modes on one base: shapes by finite elements, polynomials fitted to them, and the frequencies (4) [rad/s] that
    the fitted polynomials give on a clamped base.
    """

    shapes: TowerShapes
    fit: PolynomialFit
    fitted_frequency: np.ndarray


@dataclass(frozen=True, eq=False, kw_only=True)
class TowerReport:
    """What is known of a tower: file, structure, rotor-nacelle assembly about the tower top, modes on a clamped base and (with a
    floating deck) on its platform, frequencies (4) [rad/s] of the deck's own polynomials on a clamped base, in pairs and (first
    modes, 2) alone, notes.
    """

    path: Path
    structure: TurbineStructure
    head: RigidBody
    clamped: TowerSet
    floating: TowerSet | None
    deck_frequency: np.ndarray
    deck_first_alone: np.ndarray
    notes: tuple[str, ...]


def tower_report(path: str | Path) -> TowerReport:
    """Return the tower of an OpenFAST primary file (.fst) or an ElastoDyn file; raise FormatError or ModelError.

    With a primary file that has HydroDyn coefficients the modes on the floating platform are found too.
    """
    path = Path(path)
    source = read_input(path)
    if source.has("EDFile"):
        deck = read_deck(path)
        structure, notes = deck.elastodyn.structure, []
    elif source.has("TwrFile"):
        gravity = source.number("Gravity", GRAVITY)
        deck, structure = None, read_elastodyn(path, gravity).structure
        notes = (
            []
            if source.has("Gravity")
            else [f"gravity taken as {GRAVITY} m/s²: the primary file (.fst), which says it, was not given"]
        )
    else:
        raise FormatError(
            path, expected="an OpenFAST primary file (EDFile) or an ElastoDyn file (TwrFile)", found="neither"
        )
    head = rotor_nacelle(structure)
    if np.any(structure.tower.stiffness_tuner != 1):
        notes.append("the file's stiffness tuners act on its own polynomials only, not on the finite elements")
    try:
        clamped = _set(structure, bending_modes(structure.tower, head, structure.gravity))
        floating, more = _floating(structure, head, deck)
    except ValueError as error:
        raise ModelError(f"{path}: {error}") from None
    pairs = [clamped_frequencies(structure, TOWER_MODES[k : k + 2]) for k in (0, 2)]
    alone = [clamped_frequencies(structure, (name,))[0] for name in ("tower_fa1", "tower_ss1")]
    return TowerReport(
        path=path, structure=structure, head=head, clamped=clamped, floating=floating, deck_frequency=np.concatenate(pairs),
        deck_first_alone=np.array(alone), notes=(*notes, *more),
    )  # fmt: skip


def _set(structure: TurbineStructure, shapes: TowerShapes) -> TowerSet:
    fit = fit_polynomials(shapes)
    fitted = replace(structure, tower=with_modes(structure.tower, fit))
    pairs = [clamped_frequencies(fitted, TOWER_MODES[k : k + 2]) for k in (0, 2)]
    return TowerSet(shapes=shapes, fit=fit, fitted_frequency=np.concatenate(pairs))


def _floating(structure: TurbineStructure, head: RigidBody, deck: Deck | None) -> tuple[TowerSet | None, list[str]]:
    """Return the modes on the deck's platform: its mass, infinite-frequency added mass, hydrostatics, moorings at rest."""
    if deck is None or deck.hydrodyn is None or not deck.hydrodyn.floats:
        return None, []
    hydro = deck_hydro(deck)
    if hydro.hydrostatic_stiffness is None:
        return None, [
            "modes on the floating platform left out: the hydrodynamic coefficients hold no hydrostatic stiffness"
        ]
    mass, stiffness, _ = platform_matrices(structure.platform, structure.gravity)
    mass = mass + infinite_added_mass(hydro)
    stiffness = stiffness + hydro.hydrostatic_stiffness + deck.hydrodyn.stiffness
    if deck.mooring is not None:
        stiffness = stiffness + mooring_state(deck.mooring, np.zeros(6)).stiffness
    shapes = bending_modes(structure.tower, head, structure.gravity, platform_mass=mass, platform_stiffness=stiffness)
    return _set(structure, shapes), [
        "floating: platform with infinite-frequency added mass, hydrostatics and moorings at rest"
    ]


def frequency_table(report: TowerReport) -> Table:
    """Return natural frequencies by base and by kind of shape."""
    columns = [
        Column(name="Mode"),
        Column(name="clamped", unit="Hz"),
        Column(name="deck's polynomials, clamped", unit="Hz"),
    ]
    columns += [Column(name="fitted polynomials, clamped", unit="Hz")]
    values = [report.clamped.shapes.frequency, report.deck_frequency, report.clamped.fitted_frequency]
    if report.floating is not None:
        columns.append(Column(name="on the platform", unit="Hz"))
        values.append(report.floating.shapes.frequency)
    rows = tuple(
        (_LABELS[n], *(float(v[k]) / (2 * np.pi) for v in values)) for k, n in enumerate(report.clamped.shapes.names)
    )
    fa, ss = report.deck_first_alone / (2 * np.pi)
    note = f"The deck's first polynomials alone (only TwFADOF1, only TwSSDOF1): {fa:.4f} and {ss:.4f} Hz. Blades rigid, no air."
    return Table(name="frequencies", title="Tower natural frequencies", columns=tuple(columns), rows=rows, note=note)


def head_table(report: TowerReport) -> Table:
    """Return mass properties of the rotor-nacelle assembly."""
    body, top = report.head, report.structure.tower.top_height
    about = body.inertia + body.mass * (body.centre @ body.centre * np.eye(3) - np.outer(body.centre, body.centre))
    rows = [
        ("mass", "t", body.mass / 1e3),
        *(
            (f"centre of mass, {a} from the tower top", "m", float(x))
            for a, x in zip(("downwind", "lateral", "up"), body.centre, strict=True)
        ),
        ("centre of mass above still water", "m", float(top + body.centre[2])),
        ("hub height", "m", report.structure.hub_height),
        *(
            (f"inertia about its centre, {a}", "10⁶ t m²", float(body.inertia[k, k]) / 1e9)
            for k, a in enumerate(("roll", "pitch", "yaw"))
        ),
        *(
            (f"inertia about the tower top, {a}", "10⁶ t m²", float(about[k, k]) / 1e9)
            for k, a in enumerate(("roll", "pitch", "yaw"))
        ),
    ]
    columns = (Column(name="Rotor-nacelle assembly"), Column(name="Unit"), Column(name="value", unit="unit of the row"))
    return Table(name="rotor_nacelle", title="Rotor-nacelle assembly", columns=columns, rows=tuple(rows))


def modal_table(found: TowerSet, title: str) -> Table:
    """Return modal mass, stiffness and coupling with the platform motions of a set of modes."""
    columns = (
        Column(name="Mode"), Column(name="mass", unit="t", decimals=1), Column(name="elastic stiffness", unit="kN/m"),
        Column(name="weight's stiffness", unit="kN/m"), Column(name="with surge or sway", unit="t", decimals=1),
        Column(name="with heave", unit="t", decimals=1), Column(name="with pitch or −roll", unit="t m", decimals=0),
        Column(name="weight, with pitch or −roll", unit="kN/rad", decimals=0),
    )  # fmt: skip
    s, rows = found.shapes, []
    for k, name in enumerate(s.names):
        turn, sign = (4, 1.0) if name[6:8] == "fa" else (3, -1.0)
        values = (
            s.modal_mass[k], s.modal_stiffness[k], s.gravity_stiffness[k], s.mass_coupling[0 if turn == 4 else 1, k], s.mass_coupling[2, k],
            sign * s.mass_coupling[turn, k], sign * s.gravity_coupling[turn, k],
        )  # fmt: skip
        rows.append((_LABELS[name], *(float(v) / 1e3 for v in values)))
    return Table(
        name="modal",
        title=title,
        columns=columns,
        rows=tuple(rows),
        note="Shapes are 1 at the tower top; about the reference point.",
    )


def polynomial_text(fit: PolynomialFit) -> str:
    """Return fitted polynomials as lines of an ElastoDyn tower file."""
    titles = {0: "FORE-AFT", 2: "SIDE-SIDE"}
    lines = []
    for k, (name, row) in enumerate(zip(fit.names, fit.coefficients, strict=True)):
        if k in titles:
            lines.append(f"---------------------- MODE SHAPES, {titles[k]} ".ljust(80, "-"))
        rounded = np.round(row, 6)
        rounded[-1] = np.round(1 - rounded[:-1].sum(), 6)
        lines += [
            f"{c:14.6f}   {_GROUPS[name]}({p})    - mode {name[-1]}, x^{p}" for p, c in enumerate(rounded, start=2)
        ]
    return "\n".join(lines)


def shapes_figure(report: TowerReport) -> Drawing:
    """Return the figure of mode shapes over height: finite elements, their fit, and the deck's polynomials."""
    found = report.floating or report.clamped
    names = found.shapes.names
    figure, axes = grid(1, len(names), height=3.4, between=0.45)
    x, z = found.shapes.station, found.shapes.height
    own = polynomial(report.structure.tower.modes, x)
    handles: dict = {}
    for k, name in enumerate(names):
        ax = axes[0, k]
        ax.axvline(0, color=GREY, lw=0.7)
        if report.floating is not None:
            handles["finite elements, clamped"] = ax.plot(report.clamped.shapes.shape[:, k], z, color=GREY, lw=1.2)[0]
        label = "finite elements, on the platform" if report.floating is not None else "finite elements, clamped"
        handles[label] = ax.plot(found.shapes.shape[:, k], z, color=BLUE, lw=2.2)[0]
        handles["fitted polynomial"] = ax.plot(
            polynomial(found.fit.coefficients, x)[:, k], z, color=INK, ls="--", lw=1.0
        )[0]
        handles["polynomial of the deck"] = ax.plot(own[:, k], z, color=ORANGE, ls=":", lw=1.6)[0]
        ax.set_title(f"{_LABELS[name]}, {found.shapes.frequency[k] / (2 * np.pi):.3f} Hz")
        ax.set_xlabel("Deflection [-]")
        ax.set_ylim(z[0], z[-1])
    axes[0, 0].set_ylabel("Height above still water [m]")
    legend(figure, list(handles.values()), list(handles))
    caption = "Deflection relative to the tower base, 1 at the top; rotor-nacelle assembly rigid, weight included."
    return Drawing(name="tower_modes", group="tower", title="Tower mode shapes", caption=caption, figure=figure)


def report_json(report: TowerReport, files: Sequence[Path] = ()) -> dict:
    """Return everything as one JSON document, SI."""
    head = report.head
    return {
        "file": str(report.path),
        "clamped": _set_json(report.clamped),
        "floating": None if report.floating is None else _set_json(report.floating),
        "deck_polynomials": {
            "frequency_hz": dict(zip(TOWER_MODES, map(float, report.deck_frequency / (2 * np.pi)), strict=True)),
            "first_alone_hz": dict(zip(("tower_fa1", "tower_ss1"), map(float, report.deck_first_alone / (2 * np.pi)), strict=True)),
        },
        "rotor_nacelle": {"mass": head.mass, "centre": head.centre.tolist(), "inertia": head.inertia.tolist(), "hub_height": report.structure.hub_height},
        "notes": list(report.notes),
        "files": [str(f) for f in files],
        "units": {
            "frequency_hz": "Hz", "mass": "kg", "centre": "m from the tower top", "inertia": "kg m2 about the centre", "hub_height": "m",
            "modal_mass": "kg", "modal_stiffness": "N/m", "gravity_stiffness": "N/m", "mass_coupling": "kg, kg m", "gravity_coupling": "N/m, N/rad",
            "height": "m", "residual": "-",
        },
    }  # fmt: skip


def write_tower(report: TowerReport, folder: str | Path) -> list[Path]:
    """Write figure (PNG, SVG), polynomials and JSON into a folder; return the files. Nothing is left on failure."""
    folder, names = Path(folder), []
    with atomic_folder(folder) as inside:
        with mpl.rc_context(RC):
            drawing = shapes_figure(report)
        save(drawing, inside)
        names += [f"{drawing.name}.png", f"{drawing.name}.svg"]
        for base, found in (("clamped", report.clamped), ("floating", report.floating)):
            if found is not None:
                (inside / f"polynomials_{base}.dat").write_text(polynomial_text(found.fit) + "\n", encoding="utf-8")
                names.append(f"polynomials_{base}.dat")
        (inside / "tower.json").write_text(
            json.dumps(report_json(report), indent=1, allow_nan=False) + "\n", encoding="utf-8"
        )
        names.append("tower.json")
    return [folder / name for name in names]


def show_tower(report: TowerReport, files: Sequence[Path] = ()) -> None:
    """Print the report."""
    from fowtio.terminal import show_table

    found, base = (
        (report.clamped, "clamped base") if report.floating is None else (report.floating, "on the floating platform")
    )
    show_table(frequency_table(report))
    show_table(head_table(report))
    show_table(modal_table(report.clamped, "Modal quantities of the clamped modes"))
    print(f"\nPolynomials for ElastoDyn's tower file ({base})\n" + polynomial_text(found.fit))
    worst = ", ".join(f"{_LABELS[n]} {100 * r:.3f} %" for n, r in zip(found.fit.names, found.fit.residual, strict=True))
    print(f"largest departure from the finite-element shape: {worst} of the shape's largest deflection")
    for note in report.notes:
        print(f"note: {note}")
    for file in files:
        print(file)


def _set_json(found: TowerSet) -> dict:
    s = found.shapes
    return {
        "frequency_hz": dict(zip(s.names, map(float, s.frequency / (2 * np.pi)), strict=True)),
        "modes": [
            {
                "name": name, "frequency_hz": float(s.frequency[k] / (2 * np.pi)),
                "fitted_polynomial_clamped_hz": float(found.fitted_frequency[k] / (2 * np.pi)),
                "polynomial": found.fit.coefficients[k].tolist(), "residual": float(found.fit.residual[k]),
                "modal_mass": float(s.modal_mass[k]), "modal_stiffness": float(s.modal_stiffness[k]),
                "gravity_stiffness": float(s.gravity_stiffness[k]), "mass_coupling": s.mass_coupling[:, k].tolist(),
                "gravity_coupling": s.gravity_coupling[:, k].tolist(), "shape": s.shape[:, k].tolist(), "slope": s.slope[:, k].tolist(),
            } for k, name in enumerate(s.names)
        ],
        "height": s.height.tolist(),
    }  # fmt: skip
