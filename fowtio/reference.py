"""Time series of another code as records to compare with: channels found by name and pattern, SI units, transient cut."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fowtio.case_validation import Reference
from fowtio.errors import ModelError
from fowtio.read.openfast_out import TimeSeries

WAVE, WIND, THRUST = "Wave1Elev", "Wind1VelX", "RtAeroFxh"
FEWEST_SAMPLES = 100
_ALIASES = {
    "PtfmSurge": r"PtfmTDx[it]|(?:B1|PRP)Surge|Surge", "PtfmSway": r"PtfmTDy[it]|(?:B1|PRP)Sway|Sway",
    "PtfmHeave": r"PtfmTDz[it]|(?:B1|PRP)Heave|Heave", "PtfmRoll": r"PtfmRDxi|(?:B1|PRP)Roll|Roll",
    "PtfmPitch": r"PtfmRDyi|(?:B1|PRP)Pitch|Pitch", "PtfmYaw": r"PtfmRDzi|(?:B1|PRP)Yaw|Yaw",
    "TTDspFA": r"YawBrTDxt|TwrTpTDxt", "TTDspSS": r"YawBrTDyt|TwrTpTDyt", "NcIMUTAxs": r"NacIMUTAxs", "NcIMUTAys": r"NacIMUTAys",
    "TwrBsFxt": r"TwrBsFxt1|TwrBsShrFA|TwrBsFx", "TwrBsFyt": r"TwrBsFyt1|TwrBsFy", "TwrBsMyt": r"TwrBsMyt1|TwrBsMomFA|TwrBsMy",
    "TwrBsMxt": r"TwrBsMxt1|TwrBsMx", WAVE: r"WaveElev1?|Wave1Elv|Waves1Elev|WaveElevation", WIND: r"WindVxi|Wind1VelXi|WindHubVelX|HubWindX",
    THRUST: r"RtFldFxh|RtAeroFxhub|RotAeroThrust",
}  # fmt: skip
_LINE = r"T_?#|FairTen#|FairT#|(?:L|Line)_?#_?FairT(?:en|ension)?|Line#(?:_?Fair)?_?T(?:en|ension)?|(?:L|Line)#_?Fairlead_?Tension"
_ANCHOR = r"T_?a\[?#\]?|AnchTen#|AnchT#|(?:L|Line)_?#_?AnchT(?:en|ension)?"
_TO_SI = {
    "": 1.0, "-": 1.0, "m": 1.0, "cm": 1e-2, "mm": 1e-3, "ft": 0.3048, "rad": 1.0, "deg": np.pi / 180, "m/s": 1.0, "m/s2": 1.0, "g": 9.80665,
    "cm/s2": 1e-2, "n": 1.0, "kn": 1e3, "mn": 1e6, "lbf": 4.4482216, "kip": 4448.2216, "nm": 1.0, "knm": 1e3, "mnm": 1e6,
}  # fmt: skip
_KIND = {
    "m": "length", "cm": "length", "mm": "length", "ft": "length", "rad": "angle", "deg": "angle", "m/s2": "acceleration", "g": "acceleration",
    "cm/s2": "acceleration", "n": "force", "kn": "force", "mn": "force", "lbf": "force", "kip": "force", "nm": "moment", "knm": "moment",
    "mnm": "moment", "m/s": "speed",
}  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Finding:
    """Something about the reference that is wrong or worth knowing: severity "error" or "note", what it is about, in words."""

    severity: str
    subject: str
    text: str


@dataclass(frozen=True, eq=False, kw_only=True)
class Records:
    """Records of one state: files (s); step [s]; start, the first sample after the transient; waves: s arrays (t) [m]; wind: s arrays
    (t) [m/s] at the hub and thrust of the air: s arrays (t) [N], each or None; names, units (c) of the channels, channels: s arrays (t, c) in SI, whole records; written: name in the
    files of each channel; unmatched channels of the files; missing channels of the model; still, those that hardly move, with their
    standard deviation; what was noticed.
    """

    files: tuple[str, ...]
    step: float
    start: int
    waves: list[np.ndarray]
    wind: list[np.ndarray] | None
    thrust: list[np.ndarray] | None
    names: tuple[str, ...]
    units: tuple[str, ...]
    channels: list[np.ndarray]
    written: tuple[str, ...]
    unmatched: tuple[str, ...]
    missing: tuple[str, ...]
    still: tuple[tuple[str, float], ...]
    findings: tuple[Finding, ...]

    @property
    def shortest(self) -> float:
        """Length of the shortest record without its transient [s]."""
        return (min(len(w) for w in self.waves) - self.start) * self.step

    def cut(self, arrays: Sequence[np.ndarray]) -> list[np.ndarray]:
        """Return arrays of whole records without the transient."""
        return [a[self.start :] for a in arrays]


def find_channel(
    name: str, present: Sequence[str], own: Sequence[tuple[str, str, float]] = ()
) -> tuple[str, float, float] | None:
    """Return the name in a file of a channel, its sign, and the factor to SI (0: by the unit in the file); None when there is none.

    The study's own names come first (own: channel, name, factor, # for a number), then the channel's own name, then what other
    modules and versions call it. A leading - or _ turns the sign, as in OpenFAST's output lists.
    """
    for channel, written, factor in own:
        wanted = _instance(channel, written, name)
        found = None if wanted is None else next((p for p in present if p.lower() == wanted.lower()), None)
        if found is not None:
            return found, 1.0, factor
    for pattern in (re.escape(name), _pattern(name)):
        for sign, prefix in ((1.0, ""), (-1.0, "[-_]")):
            for p in present if pattern else ():
                if any(re.fullmatch(f"{prefix}(?:{pattern})", text, re.IGNORECASE) for text in (p, p.strip("[]"))):
                    return p, sign, 0.0
    return None


def _pattern(name: str) -> str:
    line = re.fullmatch(r"T(_a)?\[(\d+)\]", name)
    return (_ANCHOR if line[1] else _LINE).replace("#", line[2]) if line else _ALIASES.get(name, "")


def _instance(channel: str, written: str, name: str) -> str | None:
    """Return what the files call a channel by a row of the study's names, None when the row is of another one."""
    found = re.fullmatch(r"(\d+)".join(re.escape(p) for p in channel.split("#")), name, re.IGNORECASE)
    return None if found is None else written.replace("#", found[1]) if "#" in channel else written


def records_of(
    series: Sequence[TimeSeries], reference: Reference, names: Sequence[str], units: Sequence[str]
) -> Records:
    """Return the records of a reference with those of the model's channels (names, SI units) that all files have and that move.

    Raises ModelError when nothing can be compared.
    """
    findings: list[Finding] = []
    step = _common_step(series, findings)
    series = [_even(s, step, findings) for s in series]
    start = round(reference.discard / step)
    late = sorted({round(float(s.time[0]), 3) for s in series})
    if late != [0.0]:
        severity = "note" if len(late) == 1 else "error"
        findings.append(
            Finding(
                severity=severity,
                subject="time axis",
                text=f"records begin at {', '.join(f'{t:g}' for t in late)} s; the transient is counted from there",
            )
        )
    if min(len(s.time) for s in series) - start < FEWEST_SAMPLES:
        raise ModelError(
            f"{series[0].source}: fewer than {FEWEST_SAMPLES} samples remain after {reference.discard:g} s are discarded"
        )
    own = reference.channels
    places = {n: [find_channel(n, s.names, own) for s in series] for n in (*names, WAVE, WIND, THRUST)}
    for name, found in places.items():
        _note_partly_missing(name, found, series, findings)
    if any(p is None for p in places[WAVE]):
        lacking = next(s.source for s, p in zip(series, places[WAVE], strict=True) if p is None)
        raise ModelError(f"{lacking} has no wave elevation channel ({WAVE}); name it in the study (table NChan)")
    present = [n for n in names if all(p is not None for p in places[n])]
    data = {
        n: [in_si(s, p, u, findings) for s, p in zip(series, places[n], strict=True)]
        for n, u in zip(names, units, strict=True)
        if n in present
    }
    moving = _moving(data, dict(zip(names, units, strict=True)), start)
    if not moving:
        raise ModelError(f"{series[0].source} has none of the model's channels ({', '.join(names)}) in motion")
    inputs = [n for n in (WAVE, WIND, THRUST) if all(p is not None for p in places[n])]
    used = {p[0].lower() for n in (*moving, *inputs) for p in places[n] if p is not None}
    unmatched = tuple(dict.fromkeys(n for s in series for n in s.names if n.lower() not in used))

    def read(name, unit):
        return (
            [in_si(s, p, unit, findings) for s, p in zip(series, places[name], strict=True)] if name in inputs else None
        )

    missing = tuple(n for n in names if n not in present)
    still = tuple((n, max(float(np.std(r[start:])) for r in data[n])) for n in present if n not in moving)
    return Records(
        files=tuple(s.source for s in series), step=step, start=start, waves=read(WAVE, "m"), wind=read(WIND, "m/s"),
        thrust=read(THRUST, "N"), names=tuple(moving),
        units=tuple(units[names.index(n)] for n in moving),
        channels=[np.stack([data[n][k] for n in moving], axis=1) for k in range(len(series))], written=tuple(places[n][0][0] for n in moving),
        unmatched=unmatched, missing=missing, still=still, findings=tuple(dict.fromkeys(findings)),
    )  # fmt: skip


def _common_step(series, findings) -> float:
    steps = [float(np.median(np.diff(s.time))) if len(s.time) > 1 else 0.0 for s in series]
    if max(steps) > 1.001 * min(steps):
        findings.append(
            Finding(
                severity="note",
                subject="time step",
                text=f"records have steps of {min(steps):g} to {max(steps):g} s; all are taken at {max(steps):g} s",
            )
        )
    return max(steps)


def _even(series: TimeSeries, step: float, findings) -> TimeSeries:
    """Return a series on even steps; one whose axis has gaps, or another step, is interpolated and that is said."""
    steps = np.diff(series.time)
    if np.abs(steps - step).max() < 0.01 * step:
        return series
    if np.abs(steps - np.median(steps)).max() > 0.01 * np.median(steps):
        at = series.time[int(np.argmax(np.abs(steps - np.median(steps))))]
        findings.append(
            Finding(
                severity="error",
                subject=_name(series),
                text=f"time axis uneven: a step of {np.abs(steps).max():g} s at {at:g} s where {np.median(steps):g} s is usual",
            )
        )
    time = np.arange(series.time[0], series.time[-1] + step / 2, step)
    data = np.stack([np.interp(time, series.time, c) for c in series.data.T], axis=1)
    return TimeSeries(
        time=time,
        data=data,
        names=series.names,
        units=series.units,
        description=series.description,
        source=series.source,
    )


def _note_partly_missing(name, found, series, findings) -> None:
    lacking = [_name(s) for s, p in zip(series, found, strict=True) if p is None]
    if lacking and len(lacking) < len(series):
        findings.append(
            Finding(
                severity="error",
                subject=name,
                text=f"channel missing in {', '.join(lacking)}, present in the other records; it is not compared",
            )
        )


def in_si(series: TimeSeries, place, unit: str, findings: list[Finding]) -> np.ndarray:
    """Return a channel (t) in SI; a unit that is unknown or of another kind is said."""
    name, sign, factor = place
    written = series.unit(name)
    plain = re.sub(r"[\s·*^-]|(?<=s)\^", "", written.replace("²", "2")).lower()
    kind, expected = _KIND.get(plain), _KIND.get(unit.replace(" ", "").replace("^", "").lower())
    if factor:
        return series.channel(name) * sign * factor
    if plain not in _TO_SI:
        findings.append(
            Finding(
                severity="error",
                subject=name,
                text=f"unit {written!r} is not known; taken as {unit}. Give a factor in the study (table NChan)",
            )
        )
    elif kind and expected and kind != expected:
        findings.append(
            Finding(severity="error", subject=name, text=f"unit {written!r} is of {kind}, expected {expected} ({unit})")
        )
    elif not plain.strip("-"):
        findings.append(Finding(severity="note", subject=name, text=f"no unit in {_name(series)}; taken as {unit}"))
    return series.channel(name) * sign * _TO_SI.get(plain, 1.0)


def _moving(data: dict[str, list[np.ndarray]], units: dict[str, str], start: int) -> list[str]:
    """Return the channels that move by more than a thousandth of the largest of their unit: sway in head waves does not."""
    std = {n: max(float(np.std(r[start:])) for r in records) for n, records in data.items()}
    largest = {u: max(s for n, s in std.items() if units[n] == u) for u in {units[n] for n in std}}
    return [n for n, s in std.items() if s > 1e-3 * largest[units[n]] and s > 0]


def _name(series: TimeSeries) -> str:
    return re.split(r"[\\/]", series.source)[-1]
