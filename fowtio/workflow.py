"""The pipelines from files to answers, each readable from top to bottom."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from fowtio.case import ALL_DOFS, EXTREME, Case, LinearisationEntry, Options, StateEntry
from fowtio.errors import CaseError, FormatError, ModelError, Problem
from fowtio.read.hydrodyn import drag_members
from fowtio.read.openfast_deck import Deck, deck_hydro, read_deck
from fowtio.read.openfast_lin import read_openfast_lin
from fowtio.rotor import gusty_turbine, rotor_turbine
from model.conventions import PLATFORM_DOFS
from model.environment.current import current_velocity
from model.environment.rotor_wind import RotorSensitivity, rotor_sensitivity
from model.environment.sea import SeaState
from model.environment.wind import WindState, standard_deviation
from model.response.assemble import Equilibrium, Modes, System, assemble, equilibrium, natural_modes
from model.response.histories import Histories, synthesise
from model.response.loads import ChannelResponse, LinearOutputs, channel_response, linear_outputs, response_spectra
from model.response.sections import ExtraOutputs, with_extras
from model.response.solve import Excitation, Grid, Response, excitation, frequency_grid, prepare, solve
from model.response.statistics import Statistics, statistics
from model.system.blade_wind import blade_wind, sensitivity
from model.system.contributions import (
    Contribution,
    added_mass_contribution,
    additional_contribution,
    condense,
    contribution,
    hydrostatic_contribution,
    mooring_contribution,
    platform_contribution,
    turbine_contribution,
    turbine_of_linearisation,
    widen,
)
from model.system.controller import ROTOR_AZIMUTH
from model.system.drag import DragMembers, steady_drag
from model.system.hydro import HydroCoefficients, headings_cover, refined
from model.system.identified import SecondOrder, has_load_inputs, second_order
from model.system.linearisation import Linearisation
from model.system.tower import TOWER_MODES, top_place, tower_modes
from model.system.turbine import TurbineMatrices, TurbineStructure, gradient_forces, head_motion, structural_matrices
from model.system.turbine_table import turbine_at

SAME_SPEED = 0.05  # m/s
STRETCHED = 0.02  # strain of a line above which a note is due; chain and wire break below it


@dataclass(frozen=True, eq=False, kw_only=True)
class OperatingPoint:
    """The model at one wind speed [m/s]: turbine, how its rotor samples the wind (None when parked), assembled system,
    mean offset, natural modes, standard channels.

    contained are the parts that its linearisation held beside the turbine (empty without one).
    """

    wind_speed: float
    turbine: TurbineMatrices
    rotor: RotorSensitivity | None
    system: System
    mean: Equilibrium
    modes: Modes
    outputs: LinearOutputs
    contained: tuple[Contribution, ...]


@dataclass(frozen=True, eq=False, kw_only=True)
class Model:
    """A study read and assembled: deck, coefficients, states, the operating points they need, the frequency grid omega (n)
    [rad/s], and notes on what was assumed.
    """

    case: Case
    deck: Deck
    hydro: HydroCoefficients
    states: tuple[StateEntry, ...]
    points: tuple[OperatingPoint, ...]
    omega: np.ndarray
    notes: tuple[str, ...]

    def at(self, wind_speed: float) -> OperatingPoint:
        """Return the operating point of a wind speed [m/s]; raise ModelError when the study has none."""
        for point in self.points:
            if abs(point.wind_speed - wind_speed) < SAME_SPEED:
                return point
        raise ModelError(f"no operating point at {wind_speed:g} m/s; there are {[p.wind_speed for p in self.points]}")


@dataclass(frozen=True, eq=False, kw_only=True)
class StateResponse:
    """The response to one state about its operating point."""

    state: StateEntry
    point: OperatingPoint
    response: Response


@dataclass(frozen=True, eq=False, kw_only=True)
class StateLoads:
    """Channels of one state: transfer functions, response spectra (n, c) and statistics."""

    state: StateEntry
    point: OperatingPoint
    response: Response
    channels: ChannelResponse
    spectra: np.ndarray
    statistics: Statistics


def build(case: Case, *, progress: Callable[[str], None] = lambda text: None, speeds: Sequence[float] | None = None) -> Model:
    """Return the assembled model of a study at the wind speeds that its states need.

    speeds [m/s] replaces those, with the thrust's slope in steady wind. progress is told what is being done. Raises FormatError, CaseError or ModelError.
    """
    progress("reading the deck")
    deck = read_deck(case.deck)
    hydro = deck_hydro(deck, case.hydro)
    states = case.states or (_deck_state(deck),)
    _check_headings(hydro, states, case.path)
    dofs = deck.elastodyn.dofs if case.dofs is None else case.dofs
    parts, notes = _fixed_parts(deck, hydro)
    fine = refined(hydro)
    drag = drag_members(deck.hydrodyn.members, deck.density)
    flow = _current(deck, drag)
    if flow is not None:
        parts.append(contribution("steady current", "the deck's sea (CurrMod), in still water", force=steady_drag(drag, flow)))
    points = []
    for speed in sorted({s.wind_speed for s in states} if speeds is None else set(speeds)):
        progress(f"operating point at {speed:g} m/s" if speed else "parked operating point")
        turbine, contained, more = _turbine(case, deck, None if dofs == ALL_DOFS else dofs, speed)
        notes += more
        if case.thrust_table is not None and speeds is None:
            turbine, more = _gusty(case, deck, turbine, states, speed)
            notes += more
        kept = turbine.dofs if dofs == ALL_DOFS else dofs
        if case.rotor is not None and speed == 0:
            kept = tuple(d for d in kept if d != ROTOR_AZIMUTH)
        points.append(_operating_point(speed, turbine, contained, kept, parts, fine, drag, flow, deck, case.options.extras))
        notes += _stretched(points[-1])
    omega = _omega(case, states, points)
    return Model(
        case=case, deck=deck, hydro=hydro, states=tuple(states), points=tuple(points), omega=omega, notes=tuple(dict.fromkeys(notes))
    )


def solve_states(
    model: Model, states: Sequence[StateEntry] | None = None, *, progress: Callable[[str], None] = lambda text: None
) -> tuple[StateResponse, ...]:
    """Return the responses to the states, by default those of the study; raise ModelError when drag does not converge."""
    grids: dict[tuple, Grid] = {}
    out = []
    for state in model.states if states is None else states:
        progress(f"solving {state.name}")
        point = model.at(state.wind_speed)
        drive = state_excitation(model, state)
        key = tuple(drive.heading)
        if key not in grids:
            grids[key] = _prepare(point.system, drive, model)
        options = model.case.options
        response = solve(point.system, point.mean, drive, grid=grids[key], drag=options.drag_model, tolerance=options.drag_tolerance)
        if not response.converged:
            raise ModelError(f"state {state.name!r}: drag did not converge in {response.iterations} iterations")
        out.append(StateResponse(state=state, point=point, response=response))
    return tuple(out)


def loads(responses: Sequence[StateResponse], duration: float = 3600.0) -> tuple[StateLoads, ...]:
    """Return channels, spectra and statistics of responses; duration [s] is that of the expected extremes."""
    out = []
    for item in responses:
        channels = channel_response(item.point.outputs, item.response)
        spectra = response_spectra(channels, item.response)
        figures = statistics(spectra, item.response.excitation.omega, channels.mean, duration)
        out.append(
            StateLoads(
                state=item.state, point=item.point, response=item.response, channels=channels, spectra=spectra, statistics=figures
            )
        )
    return tuple(out)


def state_history(
    case: Case, name: str | None, duration: float, step: float, seed: int, *, progress: Callable[[str], None] = lambda text: None
) -> tuple[str, Histories]:
    """Return the name of a state (None: the first) and one realisation of all its channels; raise ModelError."""
    model = build(case, progress=progress)
    chosen = next((s for s in model.states if name in (None, s.name)), None)
    if chosen is None:
        raise ModelError(f"no state {name!r}; there are {', '.join(s.name for s in model.states)}")
    item = loads(solve_states(model, [chosen], progress=progress))[0]
    try:
        return chosen.name, synthesise(item.channels, item.response, duration, step, seed)
    except ValueError as error:
        raise ModelError(str(error)) from None


def state_excitation(model: Model, state: StateEntry, omega=None) -> Excitation:
    """Return the spectra of a state on the model's frequencies, or on others (n) [rad/s]."""
    wind, rotor = state_wind(model, state), model.at(state.wind_speed).rotor
    return excitation(model.omega if omega is None else omega, state.seas, wind, rotor=rotor)


def state_wind(model: Model, state: StateEntry) -> WindState | None:
    """Return the turbulent wind of a state, None when it is calm or steady."""
    return turbulent_wind(state, model.deck.elastodyn.structure, model.case.options)


def turbulent_wind(state: StateEntry, structure: TurbineStructure, options: Options) -> WindState | None:
    """Return the turbulent wind of a state at a turbine's rotor, None when it is calm or steady."""
    if state.wind_speed == 0 or state.turbulence is None:
        return None
    if isinstance(state.turbulence, str):
        model_of = "ETM" if state.turbulence.startswith(EXTREME) else "NTM"
        kind = {"turbulence_class": state.turbulence.removeprefix(EXTREME), "turbulence_model": model_of, "wind_class": options.wind_class.upper()}
    else:
        kind = {"turbulence_intensity": state.turbulence}
    return WindState(
        mean_speed=state.wind_speed, hub_height=structure.hub_height, rotor_diameter=structure.rotor.diameter,
        spectrum=options.wind_spectrum, averaging=options.wind_averaging, **kind,
    )  # fmt: skip


def _gusty(case: Case, deck: Deck, turbine: TurbineMatrices, states: Sequence[StateEntry], speed: float) -> tuple[TurbineMatrices, list[str]]:
    """Return the turbine with its thrust in the turbulence of the states at a wind speed (their root mean square), and a note."""
    winds = [turbulent_wind(s, deck.elastodyn.structure, case.options) for s in states if abs(s.wind_speed - speed) < SAME_SPEED]
    found = [standard_deviation(w) for w in winds if w is not None]
    if not found:
        return turbine, []
    row = np.zeros(len(turbine.dofs))
    row[[d in PLATFORM_DOFS + TOWER_MODES for d in turbine.dofs]] = _hub_motion(deck.elastodyn.structure, turbine.dofs)[0]
    gusty, note = gusty_turbine(case.thrust_table, deck, turbine, row, float(np.sqrt(np.mean(np.square(found)))))
    return gusty, [note]


def _deck_state(deck: Deck) -> StateEntry:
    """Return the sea of the deck as the only state, without wind."""
    sea = deck.sea.sea if deck.sea is not None else SeaState(kind="still")
    if sea is None:
        raise FormatError(
            deck.path, expected="a deck with still water, JONSWAP or white-noise waves (WaveMod 0, 2, 3)",
            found=f"WaveMod {deck.sea.wave_model}", hint="Name the sea states in a study file",
        )  # fmt: skip
    return StateEntry(name="deck", wind_speed=0.0, turbulence=None, sea=sea)


def _check_headings(hydro: HydroCoefficients, states: Sequence[StateEntry], path: Path) -> None:
    """Report every state whose waves come from where the coefficients have no data."""
    if hydro.heading is None:
        raise CaseError([Problem("the hydrodynamic coefficients hold no excitation (is the .3 file missing?)", path)])
    low, high = np.degrees(hydro.heading[[0, -1]])
    bad = [(s, sea) for s in states for sea in s.seas if sea.kind != "still" and not headings_cover(hydro, sea.heading)]
    if bad:
        raise CaseError([
            Problem(f"state {s.name!r}: wave heading {np.degrees(sea.heading):g} deg lies outside the excitation data ({low:g} to {high:g} deg)",
                    path, s.line or None) for s, sea in bad
        ])  # fmt: skip


def _fixed_parts(deck: Deck, hydro: HydroCoefficients) -> tuple[list[Contribution], list[str]]:
    """Return the contributions that no operating point changes, and notes."""
    hydrodyn, notes = deck.hydrodyn, []
    parts = [
        platform_contribution(deck.elastodyn.structure.platform, deck.gravity, f"{deck.elastodyn.path.name} (PtfmMass, PtfmCM, inertias)"),
        hydrostatic_contribution(hydro, f"hydrodynamic coefficients and {hydrodyn.path.name} (PtfmVol0)"),
    ]
    if np.any(hydrodyn.preload) or np.any(hydrodyn.stiffness) or np.any(hydrodyn.damping):
        parts.append(additional_contribution(hydrodyn.preload, hydrodyn.stiffness, hydrodyn.damping, f"{hydrodyn.path.name} (AddF0, AddCLin, AddBLin)"))
    if hydro.hydrostatic_stiffness is None:
        raise ModelError("the hydrodynamic coefficients hold no hydrostatic stiffness (is the .hst file missing?)")
    if deck.mooring is None:
        notes.append("the deck has no moorings: the floater drifts freely in surge, sway and yaw")
    return parts, notes


def _current(deck: Deck, drag: DragMembers) -> np.ndarray | None:
    """Return the steady current (s, 3) [m/s] at the drag elements, None without."""
    if deck.sea is None or deck.sea.current is None:
        return None
    return current_velocity(replace(deck.sea.current, depth=deck.depth), drag.position[:, 2])


def _turbine(case: Case, deck: Deck, dofs: Sequence[str], speed: float) -> tuple[TurbineMatrices, tuple[Contribution, ...], list[str]]:
    """Return the turbine at a wind speed: from its linearisation, between two of them, or parked from the deck alone."""
    entries = {e.wind_speed: e for e in case.linearisations}
    near = next((e for s, e in entries.items() if abs(s - speed) < SAME_SPEED), None)
    by_blades = speed > 0 and case.options.wind_inputs == "blades"
    if near is not None:
        return _linearised_turbine(near, deck, dofs, by_blades)
    if by_blades and (case.turbine is not None or case.rotor is not None):
        raise ModelError(f"WindInputs blades needs linearisations with node inputs (LinInputs = 2); there is none at {speed:g} m/s")
    if case.turbine is not None and case.turbine.table.covers(speed):
        return _kept(turbine_at(case.turbine.table, speed), dofs), (), []
    if speed == 0:
        modes = tuple(d for d in deck.elastodyn.dofs if d in TOWER_MODES) if dofs is None else tuple(d for d in dofs if d in TOWER_MODES)
        note = "parked turbine from the deck's structural data; blades rigid, no air"
        if deck.aerodynamics and not entries:
            note += " (the deck has aerodynamics: name linearisations at its wind speed in a study to have the wind)"
        return structural_matrices(deck.elastodyn.structure, modes), (), [note]
    if case.rotor is not None:
        turbine, notes = rotor_turbine(case.rotor, deck, dofs, speed)
        return turbine, (), notes
    below = [s for s in entries if 0 < s < speed]
    above = [s for s in entries if s > speed]
    if not below or not above:
        raise ModelError(f"no linearisation at {speed:g} m/s, nor below and above it; name its files in the study's table")
    low, high = max(below), min(above)
    (a, held, _), (b, _, _) = (_linearised_turbine(entries[s], deck, dofs, by_blades) for s in (low, high))
    note = f"turbine at {speed:g} m/s interpolated linearly between its linearisations at {low:g} and {high:g} m/s"
    return _between(a, b, (speed - low) / (high - low), speed), held, [note]


def _linearised_turbine(
    entry: LinearisationEntry, deck: Deck, dofs: Sequence[str] | None, by_blades: bool = False
) -> tuple[TurbineMatrices, tuple[Contribution, ...], list[str]]:
    """Return the turbine of a linearisation, less what else the deck that made it held, blades condensed unless kept.

    by_blades takes the wind's gradients and the sampling of the rotor from the linearisation's node inputs.
    """
    records = [read_openfast_lin(path) for path in entry.files]
    made_by, note = _deck_of(entry, deck)
    _check_modules(records[0], made_by)
    structure = made_by.elastodyn.structure
    try:
        mass = _given_mass(entry, records[0], made_by)
        found = second_order(records, _top_place(structure, records), mass, structure.rotor.blades)
        held = _contained(found, made_by)
        rigid = _rigid_mass(made_by, found.dofs, found.point)
        turbine = turbine_of_linearisation(
            found, held, gravity=made_by.gravity, source=_span(entry.files), rigid_mass=rigid,
            hub_motion=_hub_motion(structure, found.dofs),
        )  # fmt: skip
        if by_blades:
            wind = blade_wind(records, found, structure.rotor.blades)
            turbine = replace(turbine, gradient_force=wind.gradient_force, sampling=sensitivity(wind, found.rotor_speed))
            note = [*note, f"{_span(entry.files)}: gradients and sampling of the wind from the inputs of {len(wind.radius)} nodes a blade"]
        turbine = _kept(turbine, dofs)
    except ValueError as error:
        raise ModelError(str(error)) from None
    return replace(turbine, wind_speed=entry.wind_speed), held, note


def _kept(turbine: TurbineMatrices, dofs: Sequence[str] | None) -> TurbineMatrices:
    """Return a turbine whose blades and drivetrain follow statically unless they are among the degrees of freedom (None: all are)."""
    return turbine if dofs is None else condense(turbine, [d for d in turbine.dofs if d in dofs or d in PLATFORM_DOFS + TOWER_MODES])


def _deck_of(entry: LinearisationEntry, deck: Deck) -> tuple[Deck, list[str]]:
    """Return the deck that made a linearisation: the one named, the one beside it, or the study's own."""
    if entry.deck is not None:
        return read_deck(entry.deck), []
    beside = entry.files[0].with_name(entry.files[0].name.split(".")[0] + ".fst")
    if beside.is_file():
        return read_deck(beside), [f"{_span(entry.files)}: made by the deck beside it, {beside.name}"]
    return deck, [f"{_span(entry.files)}: no LinDeck named, taken as made by the study's own deck"]


def _check_modules(record: Linearisation, made_by: Deck) -> None:
    """The modules that the file says were linked must be those of the deck."""
    if not record.modules:
        return
    linked = {name.lower().split()[0] for name in record.modules}
    wanted = ((("HydroDyn",), made_by.hydrodyn is not None), (("MAP++", "MoorDyn"), made_by.mooring is not None))
    for names, present in wanted:
        there = any(name.lower() in linked for name in names)
        if there != present:
            has, not_ = ("was", "does not use it") if there else ("was not", "does")
            raise FormatError(
                record.source, expected=f"the modules of {made_by.path}", found=", ".join(record.modules),
                hint=f"{' or '.join(names)} {has} linked, but the deck {not_}; name in LinDeck the deck that made the file",
            )  # fmt: skip


def _given_mass(entry: LinearisationEntry, record: Linearisation, made_by: Deck) -> np.ndarray | None:
    """Return the mass matrix from the deck where the linearisation has no load inputs (or the study asks for it)."""
    if entry.mass == "lin" or (entry.mass == "auto" and has_load_inputs(record)):
        return None
    if entry.mass == "auto" and entry.deck is None:
        raise FormatError(
            record.source, expected="ElastoDyn's platform load inputs, from which the mass matrix follows", found="none",
            hint="Linearise with LinInputs = 2, or name the deck that made it (LinDeck), or set MassMatrix to deck",
        )  # fmt: skip
    dofs = tuple(d for d, rate in zip(record.state_dof, record.state_rate, strict=True) if d and not rate)
    other = [d for d in dofs if d not in PLATFORM_DOFS + TOWER_MODES]
    if other:
        raise FormatError(
            record.source, expected="ElastoDyn's platform load inputs", found="none", hint=f"The mass of {other[0]} cannot come from "
            "the deck; linearise with LinInputs = 2",
        )  # fmt: skip
    mass = _rigid_mass(made_by, dofs, record.state_point[[record.state_dof.index(d) for d in dofs]])
    if made_by.hydrodyn is not None and made_by.hydrodyn.floats:
        mass = mass + widen(added_mass_contribution(deck_hydro(made_by), ""), dofs).mass
    return mass


def _top_place(structure: TurbineStructure, records: Sequence[Linearisation]) -> np.ndarray:
    """Return the place (3) of the tower top at the operating point of linearisation records."""
    first = records[0]
    modes = tuple(d for d, rate in zip(first.state_dof, first.state_rate, strict=True) if d in TOWER_MODES and not rate)
    bent = np.mean([[r.state_point[r.state_dof.index(m)] for m in modes] for r in records], axis=0)
    return top_place(structure.tower, modes, bent)


def _hub_motion(structure: TurbineStructure, dofs: Sequence[str]) -> np.ndarray:
    """Return the hub's translation (3, r) in those of the degrees of freedom that are platform motions or tower modes."""
    rigid = [d for d in dofs if d in PLATFORM_DOFS + TOWER_MODES]
    modes = tuple(d for d in rigid if d in TOWER_MODES)
    motion = head_motion(structure.tower.top_height, tower_modes(structure.tower, modes), structure.rotor.apex)[:3]
    known = PLATFORM_DOFS + modes
    return motion[:, [known.index(d) for d in rigid]]


def _rigid_mass(made_by: Deck, dofs: Sequence[str], point: np.ndarray) -> np.ndarray:
    """Return the structural mass of a deck in those of the degrees of freedom that are platform motions or tower modes."""
    rigid = [d for d in dofs if d in PLATFORM_DOFS + TOWER_MODES]
    modes = tuple(d for d in rigid if d in TOWER_MODES)
    turbine = structural_matrices(made_by.elastodyn.structure, modes, [point[list(dofs).index(m)] for m in modes])
    parts = (turbine_contribution(turbine), platform_contribution(made_by.elastodyn.structure.platform, made_by.gravity, ""))
    return sum(widen(p, rigid).mass for p in parts)


def _contained(found: SecondOrder, made_by: Deck) -> tuple[Contribution, ...]:
    """Return what a linearised deck held beside the turbine."""
    out = [platform_contribution(made_by.elastodyn.structure.platform, made_by.gravity, made_by.elastodyn.path.name)]
    hydrodyn = made_by.hydrodyn
    if hydrodyn is not None and hydrodyn.floats:
        hydro = deck_hydro(made_by)
        out.append(hydrostatic_contribution(hydro, hydrodyn.path.name))
        out.append(added_mass_contribution(hydro, hydrodyn.path.name))
    if hydrodyn is not None:
        out.append(additional_contribution(hydrodyn.preload, hydrodyn.stiffness, hydrodyn.damping, hydrodyn.path.name))
    if made_by.mooring is not None:
        at = [found.point[found.dofs.index(d)] if d in found.dofs else 0.0 for d in PLATFORM_DOFS]
        out.append(mooring_contribution(made_by.mooring, at, made_by.mooring_path.name))
    return tuple(out)


def _between(a: TurbineMatrices, b: TurbineMatrices, share: float, speed: float) -> TurbineMatrices:
    """Return matrices a share of the way from one operating point to the next."""
    if a.dofs != b.dofs:
        raise ModelError(f"linearisations {a.source} and {b.source} have different degrees of freedom")
    names = ("mass", "damping", "stiffness", "force", "point", "wind_force", "gradient_force", "rotor_speed")
    values = {n: (1 - share) * getattr(a, n) + share * getattr(b, n) for n in names}
    return replace(a, **values, wind_speed=speed, source=f"{a.source} and {b.source}, interpolated")


def _operating_point(
    speed, turbine, contained, dofs, parts, hydro, drag, flow, deck: Deck, extras: ExtraOutputs
) -> OperatingPoint:
    structure, rotor = deck.elastodyn.structure, None
    if speed > 0:
        turbine, rotor = with_gradients(turbine, structure, speed)
    try:
        system = assemble(
            dofs, turbine, [turbine_contribution(turbine), *parts], hydro, drag, deck.mooring, deck.hydrodyn.quadratic_damping, flow
        )
        mean = equilibrium(system)
    except ValueError as error:
        raise ModelError(f"{deck.mooring_path or deck.path}: {error}") from None
    try:
        modes = natural_modes(system, mean)
        outputs = with_extras(linear_outputs(system, mean, structure), system, mean, structure, extras)
    except ValueError as error:
        raise ModelError(f"{deck.path}: {error}") from None
    return OperatingPoint(
        wind_speed=speed, turbine=turbine, rotor=rotor, system=system, mean=mean, modes=modes, outputs=outputs, contained=contained,
    )  # fmt: skip


def with_gradients(turbine: TurbineMatrices, structure: TurbineStructure, speed: float) -> tuple[TurbineMatrices, RotorSensitivity]:
    """Return a turbine at a wind speed [m/s] with the forces of the wind's gradients, and how its rotor samples the wind."""
    rotor = turbine.sampling or rotor_sensitivity(structure.rotor.diameter, structure.rotor.blades, turbine.rotor_speed, speed)
    if np.any(turbine.gradient_force):
        return turbine, rotor
    return replace(turbine, gradient_force=_gradient_forces(structure, turbine, rotor)), rotor


def _stretched(point: OperatingPoint) -> list[str]:
    """Return a note on lines that are stretched more than steel allows at the mean offset."""
    if point.mean.mooring is None:
        return []
    strain = point.mean.mooring.fairlead_tension / point.system.mooring.axial_stiffness
    names = [n for n, e in zip(point.system.mooring.line_names, strain, strict=True) if e > STRETCHED]
    return [f"line {', '.join(names)} stretched by {100 * strain.max():.0f} % at {point.wind_speed:g} m/s: is it long enough?"] if names else []


def _gradient_forces(structure: TurbineStructure, turbine: TurbineMatrices, rotor: RotorSensitivity) -> np.ndarray:
    """Return the forces (2, q) of the wind's gradients; blades that are kept follow, as in the condensed turbine."""
    rigid = condense(turbine, [d for d in turbine.dofs if d in PLATFORM_DOFS + TOWER_MODES])
    out = np.zeros((2, len(turbine.dofs)))
    out[:, [turbine.dofs.index(d) for d in rigid.dofs]] = gradient_forces(structure, rigid, rotor.gradient_arm)
    return out


def _omega(case: Case, states: Sequence[StateEntry], points: Sequence[OperatingPoint]) -> np.ndarray:
    """Return one frequency grid for all states: the study's own, or dense around the natural frequencies of all operating points."""
    if case.options.frequencies:
        return 2 * np.pi * np.array(case.options.frequencies)
    natural = np.concatenate([p.modes.frequency for p in points])
    damping = np.maximum(np.concatenate([p.modes.damping_ratio for p in points]), [0.004 if n == "tower_fa1" else 0.02 for p in points for n in p.modes.names])
    order = np.argsort(natural)
    natural, damping = natural[order], damping[order]
    apart = np.concatenate([[True], np.diff(np.log(natural)) > 0.02])
    edges = sorted({2 * np.pi * f for s in states if s.sea.band is not None for f in s.sea.band})
    options = case.options
    return frequency_grid(
        2 * np.pi * options.frequency_low, 2 * np.pi * options.frequency_high, options.frequency_count,
        natural[apart], damping[apart], edges=edges,
    )  # fmt: skip


def _prepare(system: System, drive: Excitation, model: Model) -> Grid:
    return prepare(system, drive.omega, drive.heading, low_frequency=model.case.options.low_frequency_excitation)


def _span(files: Sequence[Path]) -> str:
    """Return a short name for one or several files."""
    return files[0].name if len(files) == 1 else f"{files[0].parent.name}/{files[0].name} to {files[-1].name} ({len(files)} azimuths)"
