"""Decay tests beside the model, and the damping and stiffness that the linear model lacks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fowtio.case_validation import DecayReference
from fowtio.errors import ModelError
from fowtio.read.openfast_out import read_openfast_out
from fowtio.reference import Finding, Records, find_channel, in_si
from fowtio.validation_model import ModelSide, on_grid, window_matrix
from fowtio.workflow import Model
from model.response.decay import Decay, ModelDecay, free_decay, model_decay
from model.response.equivalent import Missing, missing_terms
from model.response.identify import Estimate
from model.response.loads import MOTION_CHANNELS
from model.response.solve import Response

FITTED = ("surge", "sway", "heave", "roll", "pitch", "yaw")
BAND = (0.003, 0.22)  # Hz


@dataclass(frozen=True, eq=False, kw_only=True)
class DecayComparison:
    """A decay test beside the model: channel, unit, degree of freedom, wind speed [m/s], the record in time (t) [s], what it shows, the
    model at amplitudes from zero to the record's first, errors of the period and of the damping ratio at half of that
    amplitude, tolerance on the period.
    """

    channel: str
    unit: str
    dof: str
    wind_speed: float
    file: str
    time: np.ndarray
    motion: np.ndarray
    found: Decay
    model: ModelDecay
    period_error: float
    damping_error: float
    tolerance: float
    findings: tuple[Finding, ...] = ()

    @property
    def model_linear(self) -> float:
        """The model's damping ratio without drag."""
        return float(self.model.damping[0])

    @property
    def model_quadratic(self) -> float:
        """The model's damping ratio per unit of amplitude."""
        return float((self.model.damping[-1] - self.model.damping[0]) / self.model.amplitude[-1])

    @property
    def passed(self) -> bool:
        """Whether the period is within its tolerance."""
        return abs(self.period_error) <= self.tolerance


@dataclass(frozen=True, eq=False, kw_only=True)
class Lack:
    """What the linear model lacks: the terms, and of each motion (p) the model's natural frequency [Hz], damping ratio with drag, critical
    damping and stiffness (SI).
    """

    terms: Missing
    frequency: np.ndarray
    damping_ratio: np.ndarray
    critical: np.ndarray
    restoring: np.ndarray


def compare_decay(
    model: Model, reference: DecayReference, *, progress: Callable[[str], None] = lambda text: None
) -> DecayComparison:
    """Return a decay test beside the model; raise ModelError when channel or mode is not there, or nothing decays."""
    progress(f"decay of {reference.channel}")
    point = model.at(reference.wind_speed)
    dof = next((d for d, (channel, _) in MOTION_CHANNELS.items() if channel.lower() == reference.channel.lower()), None)
    if dof is None or dof not in point.modes.names:
        modes = ", ".join(MOTION_CHANNELS[n][0] for n in point.modes.names if n in MOTION_CHANNELS)
        raise ModelError(f"no mode of the model belongs to channel {reference.channel!r}; there are {modes}")
    channel, unit = MOTION_CHANNELS[dof]
    series = read_openfast_out(reference.file)
    place = find_channel(channel, series.names, reference.channels)
    if place is None:
        raise ModelError(f"{series.source} has no channel {channel}; it has {', '.join(series.names[:12])} ...")
    findings: list[Finding] = []
    motion = in_si(series, place, unit, findings)
    natural = 2 * np.pi / point.modes.frequency[point.modes.names.index(dof)]
    try:
        found = free_decay(series.time, motion, natural)
    except ValueError as error:
        raise ModelError(f"{series.source}: {error}") from None
    ours = model_decay(point.system, point.mean, point.modes, dof, np.linspace(0.0, abs(found.start), 6))
    half = abs(found.start) / 2
    theirs = float(found.damping(half))
    return DecayComparison(
        channel=channel, unit=unit, dof=dof, wind_speed=reference.wind_speed, file=str(reference.file), time=series.time, motion=motion, found=found, model=ours,
        period_error=float(ours.period[0] / found.period - 1),
        damping_error=float(np.interp(half, ours.amplitude, ours.damping)) / theirs - 1 if theirs > 0 else float("nan"),
        tolerance=reference.tolerance, findings=tuple(findings),
    )  # fmt: skip


def lacking(
    side: ModelSide, records: Records, found: Estimate, *, waves: np.ndarray, wind: np.ndarray | None
) -> Lack | None:
    """Return damping and stiffness that the linear model lacks, for motions whose resonance the reference shows, None without any.

    waves (m, n) and wind (n, None without) are spectra per Hz on the side's frequencies.
    """
    response, point = side.response, side.point
    hertz = dict(zip(side.modes.names, side.modes.frequency / (2 * np.pi), strict=True))
    ratios = dict(zip(side.modes.names, side.modes.damping_ratio, strict=True))
    chosen = [
        d for d in FITTED if hertz.get(d, 0) > BAND[0] and hertz[d] < 0.2 and MOTION_CHANNELS[d][0] in records.names
    ]
    if wind is not None:
        chosen = [d for d in chosen if d in ("surge", "heave", "pitch")]
    if not chosen:
        return None
    inside = (side.hz >= 0.5 * BAND[0]) & (side.hz <= 1.1 * BAND[1])
    hz, omega = side.hz[inside], response.excitation.omega
    z = response.dynamic_stiffness
    dynamic = on_grid(z.reshape(len(z), -1)[None], omega, hz)[0].reshape(-1, *z.shape[1:])
    inputs = [response.to_wave[k] for k in range(len(response.to_wave))]
    spectra = [w[inside] for w in waves]
    if wind is not None:
        inputs += [response.to_wind, *response.to_gradients]
        spectra += [wind[inside], *[side.gradients[inside]] * 2]
    transfer = np.stack([on_grid(x[None], omega, hz)[0] for x in inputs], axis=-1)
    if np.any(response.incoherent):
        columns = _independent_causes(response, hz)
        transfer = np.concatenate([transfer, columns], axis=-1)
        spectra += [np.ones(len(hz))] * columns.shape[-1]
    at = np.flatnonzero((found.frequency >= BAND[0]) & (found.frequency <= BAND[1]))
    weights = window_matrix(hz, found.frequency[at], found.segment, records.step)
    reference = found.output_spectrum[np.ix_(at, [records.names.index(MOTION_CHANNELS[d][0]) for d in chosen])]
    if wind is None:  # like is compared with like: the model's RAO through the window, times the waves that were there
        total = weights @ waves.sum(axis=0)[inside]
        energy = found.input_spectrum[at]
        usable = (energy > 1e-2 * energy.max()) & (total > 1e-6 * total.max())
        weights, reference = weights[usable] * (energy / np.where(total > 0, total, 1))[usable, None], reference[usable]
    places = [point.system.dofs.index(d) for d in chosen]
    restoring = np.diag(point.mean.stiffness)[places]
    critical = 2 * restoring / (2 * np.pi * np.array([hertz[d] for d in chosen]))
    terms = missing_terms(
        chosen,
        places,
        2 * np.pi * hz,
        dynamic,
        transfer,
        np.stack(spectra, axis=1),
        weights,
        reference,
        critical,
        restoring,
    )
    return Lack(
        terms=terms, frequency=np.array([hertz[d] for d in chosen]), damping_ratio=np.array([ratios[d] for d in chosen]), critical=critical,
        restoring=restoring,
    )  # fmt: skip


def _independent_causes(response: Response, hz: np.ndarray) -> np.ndarray:
    """Return motions (n, q, k) per unit of independent inputs with a spectrum of one per Hz that give the incoherent motions at hz (n)."""
    flat = response.incoherent.reshape(1, len(response.incoherent), -1) * 2 * np.pi
    spectra = on_grid(flat, response.excitation.omega, hz)[0].reshape(len(hz), *response.incoherent.shape[1:])
    values, vectors = np.linalg.eigh(spectra)
    columns = vectors * np.sqrt(values.clip(0))[:, None, :]
    largest = np.abs(columns).max(axis=(0, 1))
    return columns[..., largest > 1e-6 * largest.max()]
