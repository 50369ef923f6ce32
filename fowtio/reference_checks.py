"""Does the reference fit the question? Signs, units, time axes, wave channels, record lengths; each doubt is named."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np
from scipy.integrate import trapezoid

from fowtio.reference import WAVE, Finding, Records
from model.environment.sea import wavenumber
from model.response.identify import Estimate, estimate

FACTORS = {
    180 / np.pi: "degrees taken for radians", np.pi / 180: "radians taken for degrees", 1e3: "a factor of 1000 (kN for N?)",
    1e-3: "a factor of 1/1000 (N for kN?)", 9.81: "multiples of g taken for m/s² (or the reverse)", 1 / 9.81: "m/s² taken for multiples of g",
    1e6: "a factor of a million (MN for N?)", 1e-6: "a factor of a millionth (N for MN?)", 3.28: "feet taken for metres", 1 / 3.28: "metres taken for feet",
}  # fmt: skip
LEAST_PERIODS, LEAST_AVERAGES = 20.0, 10.0
_REACH, _FINE = 400.0, 0.2  # s
_CLEAR, _LATE = 0.03, 0.3


def length_findings(records: Records, found: Estimate, longest_period: float) -> list[Finding]:
    """Return what is to be said about the length of the records: periods of the slowest motion [s], averages, records given twice."""
    out = []
    if records.shortest < LEAST_PERIODS * longest_period:
        out.append(Finding(severity="error", subject="record length", text=(
            f"too short: {records.shortest:.0f} s remain, {records.shortest / longest_period:.1f} periods of the slowest motion "
            f"({longest_period:.0f} s); {LEAST_PERIODS:.0f} are needed")))  # fmt: skip
    if found.averages < LEAST_AVERAGES:
        out.append(Finding(severity="error", subject="record length", text=(
            f"too few averages: all records together give {found.averages:.1f} independent segments of {found.segment:g} s; "
            f"{LEAST_AVERAGES:.0f} are needed")))  # fmt: skip
    names = [_name(f) for f in records.files]
    for i, a in enumerate(records.waves):
        for j in range(i):
            b = records.waves[j]
            if np.ptp(a) > 0 and len(a) == len(b) and np.array_equal(a, b):
                out.append(
                    Finding(
                        severity="error",
                        subject=names[i],
                        text=f"the same waves as {names[j]}: not an independent record",
                    )
                )
    return out


def sea_findings(records: Records, spectrum: np.ndarray, hz: np.ndarray) -> list[Finding]:
    """Return where the waves of the records are not those of the state: its spectrum (n) per Hz on hz (n)."""
    expected = trapezoid(spectrum, hz)
    variance = float(np.mean([w[records.start :].var() for w in records.waves]))
    if expected <= 0 or variance <= 0:
        return []
    out, ratio = [], np.sqrt(variance / expected)
    if abs(ratio - 1) > 0.1:
        out.append(Finding(severity="error", subject=WAVE, text=(
            f"waves of another height: 4σ is {4 * np.sqrt(variance):.3g} m in the records, {4 * np.sqrt(expected):.3g} m in the state")))  # fmt: skip
    own = estimate(
        records.cut(records.waves),
        [w[:, None] for w in records.cut(records.waves)],
        records.step,
        min(200.0, records.shortest),
    )
    means = [trapezoid(f * s, f) / trapezoid(s, f) for f, s in ((hz, spectrum), (own.frequency, own.input_spectrum))]
    if abs(means[1] / means[0] - 1) > 0.1:
        out.append(Finding(severity="error", subject=WAVE, text=(
            f"waves of another period: mean frequency {means[1]:.4g} Hz in the records, {means[0]:.4g} Hz in the state")))  # fmt: skip
    return out


def agreement_findings(
    records: Records,
    transfer: np.ndarray,
    hz: np.ndarray,
    segment: float,
    depth: float,
    gravity: float,
    exact: Sequence[str],
) -> list[Finding]:
    """Return what does not fit between waves and channels of each record: shifted axes, other wave places, signs, units.

    transfer (n, c) is the model's from wave elevation on hz (n); depth [m] and gravity of the water; exact names the channels whose
    size the waves determine, so that units can be told.
    """
    out: list[Finding] = []
    each = [
        estimate([w], [y], records.step, segment)
        for w, y in zip(records.cut(records.waves), records.cut(records.channels), strict=True)
    ]
    aligned = [_Alignment(e, transfer, hz, depth, gravity) for e in each]
    for file, a in zip(records.files, aligned, strict=True):
        out += _shift_findings(_name(file), a)
    usable = [a for a in aligned if a.belongs]
    if not usable:
        return out
    score = np.median([a.score for a in usable], axis=0)
    if np.all(score < -0.5):
        return [
            *out,
            Finding(
                severity="error",
                subject=WAVE,
                text="wrong sign: every channel moves against the model's; the wave elevation has the other sign",
            ),
        ]
    size, sure = np.median([a.size for a in usable], axis=0), np.median([a.shares for a in usable], axis=0) > 0.3
    for k, name in enumerate(records.names):
        if not sure[k]:
            continue
        turned = [a.belongs and a.score[k] < -0.5 for a in aligned]
        if all(t for t, a in zip(turned, aligned, strict=True) if a.belongs):
            out.append(
                Finding(
                    severity="error",
                    subject=name,
                    text=f"wrong sign: its part that follows the waves is the model's turned round (correlation {score[k]:.2f})",
                )
            )
        elif any(turned):
            alone = ", ".join(_name(f) for f, t in zip(records.files, turned, strict=True) if t)
            out.append(Finding(severity="error", subject=name, text=f"wrong sign in {alone} alone"))
        elif score[k] < 0.5 and name in exact:
            out.append(
                Finding(
                    severity="note",
                    subject=name,
                    text=f"does not follow the waves as the model does (correlation of the coherent parts {score[k]:.2f})",
                )
            )
        out += _size_finding(name, float(size[k]), name in exact)
        for file, a in zip(records.files, aligned, strict=True):
            if a.belongs and name in exact and not 0.5 < a.size[k] / size[k] < 2:
                out.append(
                    Finding(
                        severity="error",
                        subject=name,
                        text=f"in {_name(file)} {a.size[k] / size[k]:.3g} times the size of the other records",
                    )
                )
    return out


def still_findings(
    still: Sequence[tuple[str, float]], names: Sequence[str], std: np.ndarray, units: Sequence[str]
) -> list[Finding]:
    """Return channels that hardly move in the records (name, σ) though the model's do: names, std, units (c) are the model's."""
    out = []
    for name, found in still:
        k = names.index(name)
        largest = max(s for s, u in zip(std, units, strict=True) if u == units[k])
        if std[k] > 0.05 * largest:
            ratio = found / std[k]
            words = next((f": {text}" for factor, text in FACTORS.items() if abs(ratio / factor - 1) < 0.3), "")
            out.append(
                Finding(
                    severity="error",
                    subject=name,
                    text=f"hardly moves: σ is {found:.3g} {units[k]} in the records, {std[k]:.3g} in the model{words}; it is not compared",
                )
            )
    return out


class _Alignment:
    """One record beside the model: by how much its channels are late, or its wave gauge away, and how well they then agree."""

    def __init__(self, found: Estimate, transfer, hz, depth: float, gravity: float):
        f, s = found.frequency, found.input_spectrum
        inside = (s > 1e-2 * s.max()) & (f >= 0.006) & (f <= hz[-1])
        f, s = f[inside], s[inside]
        cross = found.cross_spectrum[inside]
        model = np.stack([np.interp(f, hz, c.real) + 1j * np.interp(f, hz, c.imag) for c in transfer.T], axis=1)
        coherent, own = (np.abs(cross) ** 2 / s[:, None]).sum(axis=0), (np.abs(model) ** 2 * s[:, None]).sum(axis=0)
        product = model.conj() * cross / np.sqrt(np.maximum(coherent * own, 1e-300))
        output = found.output_spectrum[inside]
        self.shares = coherent / output.sum(axis=0)
        self.coherence = float(self.shares.max())
        self.size = np.sqrt(coherent / np.maximum(own, 1e-300))
        late = np.arange(-_REACH, _REACH + _FINE / 2, _FINE)
        self.late, in_time = _best(product, np.exp(2j * np.pi * np.outer(late, f)), late)
        away = np.arange(-300.0, 300.25, 0.5)
        self.away, in_place = _best(
            product, np.exp(-1j * np.outer(away, wavenumber(2 * np.pi * f, depth, gravity))), away
        )
        now = np.abs(product.sum(axis=0).real).mean()
        self.gain_time, self.gain_place = in_time - now, in_place - now
        turn = 1.0
        if self.is_late:
            turn = np.exp(2j * np.pi * f * self.late)[:, None]
        elif self.is_away:
            turn = np.exp(-1j * wavenumber(2 * np.pi * f, depth, gravity) * self.away)[:, None]
        self.score = (product * turn).sum(axis=0).real
        self.belongs = self.coherence > 0.35 and np.abs(self.score).max() > 0.5

    @property
    def is_late(self) -> bool:
        return self.gain_time > _CLEAR and abs(self.late) > _LATE and self.gain_time >= self.gain_place - 0.002

    @property
    def is_away(self) -> bool:
        return not self.is_late and self.gain_place > _CLEAR and abs(self.away) > 2.0


def _best(product: np.ndarray, turns: np.ndarray, values: np.ndarray) -> tuple[float, float]:
    """Return the value whose turn (v, n) of the products (n, c) agrees best over all channels, signs aside, and the agreement."""
    agreement = np.abs((turns @ product).real).mean(axis=1)
    at = int(np.argmax(agreement))
    return float(values[at]), float(agreement[at])


def _shift_findings(file: str, a: _Alignment) -> list[Finding]:
    if not a.belongs:
        return [Finding(severity="error", subject=file, text=(
            f"the wave channel is not what drove this record: coherence {a.coherence:.2f} at most; waves of another record, or a time axis "
            f"shifted by more than {_REACH:.0f} s"))]  # fmt: skip
    if a.is_late:
        word = "after" if a.late > 0 else "before"
        return [
            Finding(
                severity="error",
                subject=file,
                text=f"time axis shifted: the channels come {abs(a.late):.1f} s {word} what the waves say",
            )
        ]
    if a.is_away:
        where = "down" if a.away > 0 else "up"
        return [Finding(severity="error", subject=file, text=(
            f"another wave channel: the elevation is that {abs(a.away):.0f} m {where} the waves from the platform's origin"))]  # fmt: skip
    return []


def _size_finding(name: str, ratio: float, exact: bool) -> list[Finding]:
    """Return what the size of a channel over the model's tells."""
    if not exact or 0.55 < ratio < 1.8:
        return []
    words = next((text for factor, text in FACTORS.items() if abs(ratio / factor - 1) < 0.15), None)
    text = f"{ratio:.3g} times the model's response to waves" + (
        f": {words}" if words else "; is it the same quantity?"
    )
    return [Finding(severity="error" if words else "note", subject=name, text=text)]


def _name(path: str) -> str:
    return re.split(r"[\\/]", path)[-1]
