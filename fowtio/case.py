"""The study file (.fowt): what to model and in which seas and winds; every problem is reported at once."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from fowtio.case_validation import TABLES, DecayReference, Reference, decays, references
from fowtio.errors import CaseError, FormatError, Problem
from fowtio.read.openfast_input import InputFile, read_input
from fowtio.read.text import is_number, number, read_lines
from fowtio.read.turbine_table import read_turbine_table
from fowtio.rotor import ROTOR_NAMES, RotorEntry, rotor_entry, thrust_table
from model.conventions import PLATFORM_DOFS
from model.environment.sea import SeaState
from model.response.sections import ExtraOutputs
from model.response.solve import DRAG_MODELS
from model.system.hydro import LOW_FREQUENCY
from model.system.tower import TOWER_MODES
from model.system.turbine_table import TurbineTable

SUFFIX = ".fowt"
SPECTRA = {
    "jonswap": "jonswap", "pm": "pierson_moskowitz", "pierson_moskowitz": "pierson_moskowitz", "white_noise": "white_noise",
    "torsethaugen": "torsethaugen", "ochi_hubble": "ochi_hubble", "still": "still",
}  # fmt: skip
EXTREME = "ETM-"  # before a turbulence class: the extreme turbulence model of IEC 61400-1
WIND_SPECTRA = ("kaimal", "von_karman", "api")
MASS_SOURCES = ("auto", "lin", "deck")
TITLE_RULE = "FOWTIO STUDY FILE"


@dataclass(frozen=True, kw_only=True)
class LinearisationEntry:
    """Linearisation files of one wind speed [m/s], the deck that made them (None: unknown), where their mass matrix comes from."""

    wind_speed: float
    files: tuple[Path, ...]
    deck: Path | None
    mass: str = "auto"
    line: int = 0


@dataclass(frozen=True, eq=False, kw_only=True)
class TurbineEntry:
    """A file of turbine matrices by wind speed, and the table that it holds."""

    path: Path
    table: TurbineTable


@dataclass(frozen=True, eq=False, kw_only=True)
class StateEntry:
    """One sea and wind: name, wind_speed at hub height [m/s] (0: calm, the turbine parked), turbulence (a class, ETM- before
    it for the extreme model, an intensity as a fraction, or None for a steady wind), the sea, and further seas at the same time (swell).
    """

    name: str
    wind_speed: float
    turbulence: str | float | None
    sea: SeaState
    more_seas: tuple[SeaState, ...] = ()
    line: int = 0

    @property
    def seas(self) -> tuple[SeaState, ...]:
        """All seas of the state."""
        return (self.sea, *self.more_seas)


@dataclass(frozen=True, kw_only=True)
class Options:
    """Settings with their defaults: frequency grid [Hz] (frequencies, when given, are the grid), models, duration of the statistics
    [s], largest change of a drag coefficient over the largest at which the iteration ends.
    """

    frequency_low: float = 0.0003
    frequency_high: float = 1.0
    frequency_count: int = 400
    drag_model: str = "third_order"
    low_frequency_excitation: str = "hold"
    wind_spectrum: str = "kaimal"
    wind_averaging: str = "rotor"
    wind_inputs: str = "rotor"
    wind_class: str = "i"
    duration: float = 3600.0
    drag_tolerance: float = 1e-3
    frequencies: tuple[float, ...] = ()
    extras: ExtraOutputs = field(default_factory=ExtraOutputs)


@dataclass(frozen=True, eq=False, kw_only=True)
class Case:
    """A study: its file, title, deck, hydrodynamic coefficients (None: the deck's), degrees of freedom (None: the deck's),
    linearisations, states (empty: the deck's own sea), options, references and decay tests for validation; the turbine's
    matrices by wind speed, or a rotor table, for wind speeds without a linearisation; a hull or mesh file for the picture;
    published natural periods [s] by mode.
    """

    path: Path
    title: str
    deck: Path
    hydro: Path | None = None
    dofs: tuple[str, ...] | None = None
    linearisations: tuple[LinearisationEntry, ...] = ()
    states: tuple[StateEntry, ...] = ()
    options: Options = field(default_factory=Options)
    references: tuple[Reference, ...] = ()
    decays: tuple[DecayReference, ...] = ()
    direct: tuple[Path, ...] = ()
    rotor: RotorEntry | None = None
    turbine: TurbineEntry | None = None
    hull: Path | None = None
    thrust_table: Path | None = None
    published: tuple[tuple[str, float], ...] = ()

    @property
    def wind_speeds(self) -> tuple[float, ...]:
        """The wind speeds above 0 [m/s] whose turbine the study names, by linearisations or a table of matrices; ascending."""
        named = {e.wind_speed for e in self.linearisations} | (set() if self.turbine is None else set(self.turbine.table.wind_speed.tolist()))
        return tuple(sorted(s for s in named if s > 0))


ALL_DOFS = ("all",)
_TURBINE_DOFS = tuple(
    f"{kind}_{part}" for kind in ("flap1", "flap2", "edge1") for part in ("collective", "cosine", "sine")
) + ("drivetrain", "generator_azimuth", "nacelle_yaw")  # fmt: skip

_OPTIONS = {
    "FreqMin": ("frequency_low", float), "FreqMax": ("frequency_high", float), "NFreq": ("frequency_count", int),
    "DragModel": ("drag_model", DRAG_MODELS), "LowFreqExctn": ("low_frequency_excitation", LOW_FREQUENCY),
    "WindSpectrum": ("wind_spectrum", WIND_SPECTRA), "WindAveraging": ("wind_averaging", ("rotor", "point")),
    "WindInputs": ("wind_inputs", ("rotor", "blades")), "WindClass": ("wind_class", ("i", "ii", "iii")), "Duration": ("duration", float),
    "DragTol": ("drag_tolerance", float),
}  # fmt: skip
_EXTRAS = ("TowerSections", "ModalTowerLoads", "AnchorTensions", "AirGapPoints", "DirectLin", "FreqFile")
_NAMES = ("Deck", "HydroFile", "DOFs", "NLin", "NStates", "NoiseLow", "NoiseHigh", "NPub", "TurbineFile", "HullFile", "ThrustTable", *TABLES, *_EXTRAS, *ROTOR_NAMES, *_OPTIONS)
_TABLES = ("NLin", "NStates", "NPub", *TABLES)
_COLUMNS = ("WindSpeed", "LinFiles", "LinDeck", "MassMatrix", "Name", "Turbulence", "Spectrum", "State", "RefFiles", "Mode", "Period", "(m/s)", "(-)")


def load(path: str | Path) -> Case:
    """Return a study from its file, or the study of a deck alone from a primary file (.fst).

    Raises CaseError with every problem of the file at once, FormatError when it cannot be read at all.
    """
    path = Path(path)
    if path.suffix.lower() == ".fst":
        return Case(path=path, title=path.stem, deck=path)
    source = read_input(path)
    if TITLE_RULE not in source.lines[0].upper():
        raise FormatError(
            path, 1, expected=f"'--- {TITLE_RULE} ---' or an OpenFAST primary file (.fst)", found=source.lines[0],
            hint="fowtio init DIR writes a study to start from",
        )  # fmt: skip
    source = without_rows(source, _TABLES)
    problems = Problems(source)
    check_names(source, problems, _NAMES, _TABLES)
    check_row_counts(source, problems, _TABLES)
    case = Case(
        path=path, title=source.lines[1].strip() if len(source.lines) > 1 else "",
        deck=problems.get(lambda: _file(source, "Deck"), path),
        hydro=problems.get(lambda: None if source.is_default("HydroFile") else _stem(source, "HydroFile")),
        dofs=problems.get(lambda: _dofs(source)),
        linearisations=problems.get(lambda: _linearisations(source, problems), ()),
        states=problems.get(lambda: read_states(source, problems), ()),
        options=_options(source, problems),
        references=problems.get(lambda: references(source, problems, _glob), ()),
        decays=problems.get(lambda: decays(source, problems, _glob), ()),
        direct=problems.get(lambda: _direct(source, problems), ()),
        rotor=problems.get(lambda: rotor_entry(source)),
        turbine=problems.get(lambda: _turbine_entry(source)),
        hull=problems.get(lambda: _file(source, "HullFile") if _names(source, "HullFile") else None),
        thrust_table=problems.get(lambda: thrust_table(source)),
        published=problems.get(lambda: _published(source, problems), ()),
    )  # fmt: skip
    _check_consistency(case, problems)
    problems.raise_all()
    return case


class Problems:
    """Collects what is wrong while reading goes on."""

    def __init__(self, source: InputFile):
        self.source, self.found = source, []

    def add(self, text: str, line: int | None = None) -> None:
        """Note a problem at a line of the file."""
        self.found.append(Problem(text, self.source.path, line))

    def get(self, read: Callable, default=None):
        """Return what `read` gives, or the default after noting its error."""
        try:
            return read()
        except FormatError as error:
            self.found.append(Problem(str(error)))
        except ValueError as error:
            self.add(str(error))
        return default

    def raise_all(self) -> None:
        """Raise CaseError with everything that was noted, if anything was."""
        if self.found:
            raise CaseError(list(dict.fromkeys(self.found)))


def check_names(source: InputFile, problems: Problems, names: Sequence[str], counts: Sequence[str]) -> None:
    """Note every name of the file outside its tables (below `counts`) that is not among names, with the nearest that is."""
    known = {n.lower(): n for n in names}
    tables = _table_lines(source, counts)
    for key, (line, _, written) in source.entries.items():
        if key in known or line in tables or source.lines[line - 1].upper().startswith("END"):
            continue
        near = difflib.get_close_matches(key, known, n=1, cutoff=0.6)
        hint = f"; did you mean {known[near[0]]}?" if near else f"; known names are {', '.join(names)}"
        problems.add(f"unknown name {written}{hint}", line)


def without_rows(source: InputFile, counts: Sequence[str]) -> InputFile:
    """Return the file without the values that rows of its tables seem to give (a row that ends in "deck" is no Deck)."""
    rows = _table_lines(source, counts)
    return replace(
        source, entries={k: v for k, v in source.entries.items() if v[0] not in rows},
        repeated={k: line for k, line in source.repeated.items() if line not in rows},
    )  # fmt: skip


def _table_lines(source: InputFile, counts: Sequence[str]) -> set[int]:
    """Return the lines of the tables: from below a count to the next rule."""
    out = set()
    for count in counts:
        if source.has(count):
            i = source.line(count)
            while i < len(source.lines) and not source.lines[i].startswith("---"):
                i += 1
                out.add(i)
    return out


def check_row_counts(source: InputFile, problems: Problems, counts: Sequence[str]) -> None:
    """Note tables that have more rows than their count says: the rest would be passed over."""
    for count in counts:
        try:
            table = source.table(count) if source.has(count) else None
        except FormatError:
            continue  # noted where the table is read
        if table is None:
            continue
        first = (table.numbers_of_lines[-1] if len(table) else source.line(count) + 2) + 1
        for i in range(first, len(source.lines) + 1):
            text = source.lines[i - 1].strip()
            if text.startswith("---") or text.upper().startswith("END"):
                break
            if text and not text.startswith("!") and (len(table) or not text.startswith("(")):
                problems.add(f"a row more than {count} = {len(table)} says; change {count} or remove the row", i)
                break


def _file(source: InputFile, name: str) -> Path:
    path = source.path.parent / source.text(name)
    if not path.is_file():
        raise FormatError(source.path, source.line(name), expected=f"an existing file for {name}", found=source.text(name), hint=f"Looked for {path}")
    return path


def _stem(source: InputFile, name: str) -> Path:
    path = source.path.parent / source.text(name)
    if not path.exists() and not any(path.parent.glob(path.name + ".*")):
        raise FormatError(source.path, source.line(name), expected=f"existing files for {name}", found=source.text(name), hint=f"Looked for {path} and {path}.*")
    return path


def _dofs(source: InputFile) -> tuple[str, ...] | None:
    if source.is_default("DOFs"):
        return None
    text = source.text("DOFs")
    if text in ("6", "7"):
        return PLATFORM_DOFS + (("tower_fa1",) if text == "7" else ())
    names = tuple(text.replace(",", " ").split())
    if names == ALL_DOFS:
        return ALL_DOFS
    known = PLATFORM_DOFS + TOWER_MODES + _TURBINE_DOFS
    for name in names:
        if name not in known:
            near = difflib.get_close_matches(name, known, n=1)
            raise FormatError(
                source.path, source.line("DOFs"), expected="6, 7, all or names of degrees of freedom", found=name,
                hint=f"Did you mean {near[0]}?" if near else f"Known: {', '.join(known)}",
            )  # fmt: skip
    if len(set(names)) < len(names):
        raise FormatError(source.path, source.line("DOFs"), expected="each degree of freedom once", found=text)
    if not set(names) & set(PLATFORM_DOFS):
        raise FormatError(source.path, source.line("DOFs"), expected="at least one platform motion", found=text)
    return names


def _options(source: InputFile, problems: Problems) -> Options:
    values = {}
    for name, (attribute, kind) in _OPTIONS.items():
        if source.is_default(name):
            continue
        if isinstance(kind, tuple):
            value = source.text(name).lower()
            if value not in kind:
                near = difflib.get_close_matches(value, kind, n=1)
                hint = f"; did you mean {near[0]}?" if near else ""
                problems.add(f"{name} is {value!r}, expected one of {', '.join(kind)}{hint}", source.line(name))
                continue
        else:
            value = problems.get(lambda n=name, k=kind: source.integer(n) if k is int else source.number(n))
            if value is None:
                continue
            if value <= 0:
                problems.add(f"{name} is {value:g}, expected a number above zero", source.line(name))
                continue
        values[attribute] = value
    values["frequencies"] = problems.get(lambda: _frequencies(source), ())
    values["extras"] = problems.get(lambda: _extras(source), ExtraOutputs())
    out = Options(**values)
    if out.frequency_low >= out.frequency_high:
        problems.add(f"FreqMin {out.frequency_low:g} is not below FreqMax {out.frequency_high:g}", source.line("FreqMin") if source.has("FreqMin") else None)
    if out.frequency_count < 50:
        problems.add(f"NFreq is {out.frequency_count}, expected 50 or more", source.line("NFreq"))
    return out


def _frequencies(source: InputFile) -> tuple[float, ...]:
    """Return the frequencies [Hz] of a file that names one a line, none when the study names no such file."""
    if source.is_default("FreqFile"):
        return ()
    path = source.file("FreqFile")
    out: list[float] = []
    for line, text in enumerate(read_lines(path), start=1):
        text = text.split("!")[0].split("#")[0].strip()
        if not text:
            continue
        value = number(text) if is_number(text) else np.nan
        if not value > (out[-1] if out else 0.0):
            raise FormatError(path, line, expected="one frequency [Hz] a line, above zero and ascending", found=text)
        out.append(value)
    if len(out) < 10:
        raise FormatError(path, expected="10 frequencies or more", found=f"{len(out)}")
    return tuple(out)


def _extras(source: InputFile) -> ExtraOutputs:
    """Return the further outputs that the study asks for."""

    def listed(name):
        text = source.text(name, "")
        try:
            return [] if _blank(text) or text.lower() == "none" else [[number(t) for t in part.replace(",", " ").split()] for part in text.split(";")]
        except ValueError as error:
            raise FormatError(source.path, source.line(name), expected=f"numbers for {name}", found=text, hint=str(error)) from None

    points = listed("AirGapPoints")
    if any(len(p) != 3 for p in points):
        raise FormatError(source.path, source.line("AirGapPoints"), expected='points "x y z; x y z" [m]', found=source.text("AirGapPoints"))
    return ExtraOutputs(
        tower_sections=tuple(h for row in listed("TowerSections") for h in row),
        modal_tower_loads=source.flag("ModalTowerLoads", False), anchor_tensions=source.flag("AnchorTensions", False),
        air_gap_points=tuple(tuple(p) for p in points),
    )  # fmt: skip


def _direct(source: InputFile, problems: Problems) -> tuple[Path, ...]:
    """Return the full-system linearisations of the direct route."""
    text = source.text("DirectLin", "")
    if _blank(text) or text.lower() == "none":
        return ()
    files = _glob(source, text)
    if not files:
        problems.add(f"no file matches {text!r} (DirectLin, looked in {source.path.parent})", source.line("DirectLin"))
    return files


def _linearisations(source: InputFile, problems: Problems) -> tuple[LinearisationEntry, ...]:
    if not source.has("NLin"):
        return ()
    table = source.table("NLin")
    if not len(table):
        return ()
    speeds, patterns, decks = table.numbers("WindSpeed"), table.column("LinFiles"), table.column("LinDeck")
    masses = table.column("MassMatrix") if "massmatrix" in [c.lower() for c in table.columns] else ["auto"] * len(table)
    out = []
    for speed, pattern, deck, mass, line in zip(speeds, patterns, decks, masses, table.numbers_of_lines, strict=True):
        files = _glob(source, pattern)
        if not files:
            problems.add(f"no file matches {pattern!r} (LinFiles, looked in {source.path.parent})", line)
        made_by = None if _blank(deck) else source.path.parent / deck
        if made_by is not None and not made_by.is_file():
            problems.add(f"LinDeck {deck!r} does not exist (looked for {made_by})", line)
        if mass.lower() not in MASS_SOURCES:
            problems.add(f"MassMatrix is {mass!r}, expected one of {', '.join(MASS_SOURCES)}", line)
        out.append(LinearisationEntry(wind_speed=float(speed), files=files, deck=made_by, mass=mass.lower(), line=line))
    for a, b in zip(sorted(out, key=_speed), sorted(out, key=_speed)[1:], strict=False):
        if abs(a.wind_speed - b.wind_speed) < 0.05:
            problems.add(f"two linearisations at {a.wind_speed:g} m/s", b.line)
    return tuple(sorted(out, key=_speed))


def _names(source: InputFile, name: str) -> bool:
    """Whether a study names a file."""
    return not source.is_default(name) and source.text(name).lower() not in ("none", "-")


def _turbine_entry(source: InputFile) -> TurbineEntry | None:
    """Return the turbine's matrices by wind speed, None when the study names none."""
    if not _names(source, "TurbineFile"):
        return None
    path = _file(source, "TurbineFile")
    return TurbineEntry(path=path, table=read_turbine_table(path))


def _published(source: InputFile, problems: Problems) -> tuple[tuple[str, float], ...]:
    """Return published natural periods [s] by mode, from the table of NPub."""
    if not source.has("NPub"):
        return ()
    table, out = source.table("NPub"), []
    for mode, period, line in zip(table.column("Mode"), table.numbers("Period"), table.numbers_of_lines, strict=True):
        if mode not in PLATFORM_DOFS + TOWER_MODES:
            problems.add(f"Mode is {mode!r}, expected one of {', '.join(PLATFORM_DOFS + TOWER_MODES)}", line)
        elif not period > 0:
            problems.add(f"Period of {mode} is {period:g} s, expected a number above zero", line)
        else:
            out.append((mode, float(period)))
    return tuple(out)


def read_states(source: InputFile, problems: Problems) -> tuple[StateEntry, ...]:
    """Return the table of states of a study (NStates), noting what is wrong with its rows."""
    if not source.has("NStates"):
        return ()
    table = source.table("NStates")
    if not len(table):
        return ()
    band = (source.number("NoiseLow", 0.005), source.number("NoiseHigh", 0.2))
    columns = {name: table.column(name) for name in ("Name", "WindSpeed", "Turbulence", "Spectrum", "Hs", "Tp", "Gamma", "WaveDir")}
    lower = [c.lower() for c in table.columns]
    columns["Spreading"] = table.column("Spreading") if "spreading" in lower else ["-"] * len(table)
    out = []
    for k, line in enumerate(table.numbers_of_lines):
        row = {name: values[k] for name, values in columns.items()}
        try:
            out.append(_state(row, band, line, source.path.parent))
        except FormatError as error:
            problems.add(f"state {row['Name']!r}: {error}", line)
        except ValueError as error:
            problems.add(f"state {row['Name']!r}: {error}", line)
    return _combined(out, problems)


def _combined(rows: list[StateEntry], problems: Problems) -> tuple[StateEntry, ...]:
    """Return the states; rows of one name are seas at the same time (wind sea and swell) in one wind."""
    out: dict[str, StateEntry] = {}
    for row in rows:
        first = out.get(row.name)
        if first is not None and (first.wind_speed, first.turbulence) != (row.wind_speed, row.turbulence):
            problems.add(f"two rows are named {row.name!r} but have different winds; seas of one state share its wind", row.line)
        out[row.name] = row if first is None else replace(first, more_seas=(*first.more_seas, row.sea))
    return tuple(out.values())


def _state(row: dict[str, str], band: tuple[float, float], line: int, folder: Path) -> StateEntry:
    """Return one row of the table of states; raise ValueError saying which column is wrong, FormatError for a file of a spectrum."""
    kind = "table" if "." in row["Spectrum"] else SPECTRA.get(row["Spectrum"].lower())
    if kind is None:
        near = difflib.get_close_matches(row["Spectrum"].lower(), SPECTRA, n=1)
        raise ValueError(f"Spectrum is {row['Spectrum']!r}" + (f"; did you mean {near[0]}?" if near else f", expected one of {', '.join(SPECTRA)}"))
    values: dict = {"kind": kind, "heading": np.radians(_cell(row, "WaveDir", 0.0))}
    if kind == "table":
        values["omega"], values["spectrum"] = _spectrum_table(folder / row["Spectrum"])
    elif kind != "still":
        values["significant_height"] = _cell(row, "Hs")
    if kind in ("jonswap", "pierson_moskowitz", "torsethaugen"):
        values["peak_period"] = _cell(row, "Tp")
    if kind == "jonswap" and not _blank(row["Gamma"]):
        values["gamma"] = _cell(row, "Gamma")
    if kind == "white_noise":
        values["band"] = band
    if not _blank(row["Spreading"]):
        values["spreading"] = _cell(row, "Spreading")
    speed = _cell(row, "WindSpeed", 0.0)
    if speed < 0:
        raise ValueError(f"WindSpeed is {speed:g}, expected zero (parked) or more")
    return StateEntry(name=row["Name"], wind_speed=speed, turbulence=_turbulence(row["Turbulence"]), sea=SeaState(**values), line=line)


def _spectrum_table(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Return omega [rad/s] and spectrum [m2/(rad/s)] of a text file of two columns, frequency [Hz] and m2/Hz."""
    rows: list[list[float]] = []
    for at, line in enumerate(read_lines(path), start=1):
        parts = line.split("#")[0].replace(",", " ").replace(";", " ").split()
        if not parts or (not rows and not parts[0][0].isdigit() and parts[0][0] not in ".+-"):
            continue  # a comment, or a heading
        try:
            frequency, density = map(number, parts)
        except ValueError:
            raise FormatError(path, at, expected="two numbers, frequency in Hz and spectrum in m2/Hz", found=line.strip()) from None
        rows.append([frequency, density])
    found = np.array(rows).reshape(-1, 2).T
    return 2 * np.pi * found[0], found[1] / (2 * np.pi)


def _turbulence(text: str) -> str | float | None:
    if _blank(text) or text.lower() == "none":
        return None
    if text.upper().removeprefix(EXTREME) in ("A+", "A", "B", "C"):
        return text.upper()
    try:
        value = number(text)
    except ValueError:
        raise ValueError(f"Turbulence is {text!r}, expected a class (A+, A, B, C; ETM-A for the extreme turbulence model), an intensity in per cent, or none") from None
    if not 0 <= value <= 100:
        raise ValueError(f"Turbulence is {value:g} %, expected 0 to 100")
    return value / 100 or None


def _check_consistency(case: Case, problems: Problems) -> None:
    """Note what only shows when the parts of a study are seen together."""
    names = [s.name for s in case.states]
    for reference in case.references:
        if names and reference.state not in names:
            problems.add(f"the reference names state {reference.state!r}; states are {', '.join(names)}", reference.line)
    if case.turbine is not None and case.rotor is not None:
        problems.add("TurbineFile and RotorTable both give the turbine in wind; name one of them", problems.source.line("RotorTable"))
    speeds = [e.wind_speed for e in case.linearisations if e.wind_speed > 0]
    for state in case.states if case.rotor is None else ():
        if state.wind_speed == 0 or (speeds and min(speeds) - 0.05 <= state.wind_speed <= max(speeds) + 0.05):
            continue
        if case.turbine is not None:
            table = case.turbine.table
            if not table.covers(state.wind_speed):
                problems.add(f"state {state.name!r}: wind speed {state.wind_speed:g} m/s; {table.source} has data at {table.span}", state.line)
        elif not speeds:
            problems.add(f"state {state.name!r} has wind ({state.wind_speed:g} m/s), but the study names no linearisation at a wind speed above 0, no TurbineFile and no RotorTable", state.line)
        else:
            problems.add(
                f"state {state.name!r}: wind speed {state.wind_speed:g} m/s lies outside the linearisations "
                f"({min(speeds):g} to {max(speeds):g} m/s)", state.line,
            )  # fmt: skip


def _glob(source: InputFile, pattern: str) -> tuple[Path, ...]:
    """Return the files that a pattern names, numbers in their names in numeric order."""
    pattern = pattern.replace("\\", "/")
    path = Path(pattern)
    root = Path(path.anchor) if path.is_absolute() else source.path.parent
    relative = str(path.relative_to(path.anchor)) if path.is_absolute() else pattern
    return tuple(sorted(root.glob(relative), key=lambda p: [int(t) if t.isdigit() else t for t in p.name.replace(".", " . ").split()]))


def _cell(row: dict[str, str], name: str, default: float | None = None) -> float:
    if _blank(row[name]):
        if default is None:
            raise ValueError(f"{name} is missing")
        return default
    try:
        return number(row[name])
    except ValueError:
        raise ValueError(f"{name} is {row[name]!r}, expected a number") from None


def _blank(text: str) -> bool:
    return text.lower() in ("-", "", "default", "unknown")


def _speed(entry: LinearisationEntry) -> float:
    return entry.wind_speed
