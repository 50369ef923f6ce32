"""The tables of a study file that only validation reads: reference time series, tolerances, decay tests, channel names."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from fowtio.read.openfast_input import InputFile
from fowtio.read.text import number

TABLES = ("NRef", "NTol", "NDecay", "NChan")


@dataclass(frozen=True, kw_only=True)
class Tolerance:
    """Tolerances (fractions, None: not judged) of the channels that a name or pattern with * names."""

    channel: str
    std: float | None
    mean: float | None = None
    rao: float | None = None

    def names(self, channel: str) -> bool:
        """Tell whether a channel is meant."""
        return matches(self.channel, channel)


@dataclass(frozen=True, kw_only=True)
class Reference:
    """Time series to compare a state with: state name, files, transient to discard [s], tolerance on standard deviations of the
    channels that no row of tolerances names, those rows, and names that channels have in these files.
    """

    state: str
    files: tuple[Path, ...]
    discard: float
    tolerance: float
    line: int = 0
    tolerances: tuple[Tolerance, ...] = ()
    channels: tuple[tuple[str, str, float], ...] = ()

    def tolerance_of(self, channel: str) -> Tolerance:
        """Return the tolerances of a channel: the last row that names it, else the general one on its standard deviation."""
        named = [t for t in self.tolerances if t.names(channel)]
        return named[-1] if named else Tolerance(channel=channel, std=self.tolerance)


@dataclass(frozen=True, kw_only=True)
class DecayReference:
    """A free decay: file, the channel that decays, wind speed [m/s] of the operating point, tolerance on the period (a fraction)."""

    file: Path
    channel: str
    wind_speed: float
    tolerance: float
    line: int = 0
    channels: tuple[tuple[str, str, float], ...] = ()


def matches(pattern: str, name: str) -> bool:
    """Tell whether a name is the pattern, in which * stands for anything; capitals do not matter."""
    return re.fullmatch(".*".join(re.escape(p) for p in pattern.split("*")), name, re.IGNORECASE) is not None


def references(source: InputFile, problems, find: Callable) -> tuple[Reference, ...]:
    """Return the reference time series with their tolerances and channel names; problems are noted."""
    table = _table(source, "NRef")
    if table is None:
        return ()
    tolerances, channels = _tolerances(source, problems), channel_names(source, problems)
    discards, general = table.numbers("Discard"), table.numbers("Tolerance")
    out = []
    for state, pattern, discard, tolerance, line in zip(
        table.column("State"), table.column("RefFiles"), discards, general, table.numbers_of_lines, strict=True
    ):
        files = find(source, pattern)
        if not files:
            problems.add(f"no file matches {pattern!r} (RefFiles, looked in {source.path.parent})", line)
        own = tuple(t for s, t in tolerances if matches(s, state))
        out.append(Reference(state=state, files=files, discard=float(discard), tolerance=float(tolerance) / 100, line=line,
                             tolerances=own, channels=channels))  # fmt: skip
    known = {r.state for r in out}
    for state, _ in tolerances:
        if not any(matches(state, k) for k in known):
            problems.add(
                f"tolerances name state {state!r}; references are of {', '.join(sorted(known))}", source.line("NTol")
            )
    return tuple(out)


def decays(source: InputFile, problems, find: Callable) -> tuple[DecayReference, ...]:
    """Return the decay tests; problems are noted."""
    table = _table(source, "NDecay")
    if table is None:
        return ()
    names, out = channel_names(source, problems), []
    for channel, pattern, speed, tolerance, line in zip(
        table.column("Channel"), table.column("DecayFile"), table.numbers("WindSpeed"), table.numbers("Tolerance"),
        table.numbers_of_lines, strict=True,
    ):  # fmt: skip
        files = find(source, pattern)
        if len(files) != 1:
            problems.add(f"{len(files)} files match {pattern!r} (DecayFile), expected one", line)
            continue
        out.append(DecayReference(file=files[0], channel=channel, wind_speed=float(speed), tolerance=float(tolerance) / 100,
                                  line=line, channels=names))  # fmt: skip
    return tuple(out)


def channel_names(source: InputFile, problems) -> tuple[tuple[str, str, float], ...]:
    """Return (channel, name in the files, factor to SI; 0 where the unit in the file decides); # in both stands for a number."""
    table = _table(source, "NChan")
    if table is None:
        return ()
    out = []
    for channel, name, factor, line in zip(
        table.column("Channel"), table.column("NameInFile"), table.column("Factor"), table.numbers_of_lines, strict=True
    ):
        value = problems.get(lambda f=factor: 0.0 if f in ("-", "") else number(f), None)
        if value is None:
            continue
        if ("#" in channel) != ("#" in name):
            problems.add(f"channel {channel!r} and {name!r}: # must stand in both or in none", line)
        out.append((channel, name, float(value)))
    return tuple(out)


def _tolerances(source: InputFile, problems) -> list[tuple[str, Tolerance]]:
    table = _table(source, "NTol")
    if table is None:
        return []
    out = []
    for row in zip(
        *(table.column(c) for c in ("State", "Channel", "Std", "Mean", "RAO")), table.numbers_of_lines, strict=True
    ):
        values = [problems.get(lambda t=text: None if t in ("-", "") else number(t) / 100) for text in row[2:5]]
        if any(v is not None and v <= 0 for v in values):
            problems.add(f"a tolerance of {row[1]!r} is not above zero", row[5])
        out.append((row[0], Tolerance(channel=row[1], std=values[0], mean=values[1], rao=values[2])))
    return out


def _table(source: InputFile, count: str):
    """Return a table of the study, None when it is not there or empty."""
    if not source.has(count):
        return None
    table = source.table(count)
    return table if len(table) else None
