"""The experiments behind docs/validation.md on the embedded case.

    python benchmarks/validation_experiments.py drag      third-order drag against the drag force itself on made waves
    python benchmarks/validation_experiments.py memory    linear and third-order drag with HydroDyn's radiation memory, late by 0 to 1.5 steps
    python benchmarks/validation_experiments.py thrust    slope of the thrust over the hub's wind in the turbulent records
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

import fowtio
from fowtio.read.openfast_out import read_openfast_out
from fowtio.reference import records_of
from fowtio.validation import validate
from fowtio.validation_model import evaluate, rotor_wind
from fowtio.workflow import Model, state_excitation
from model.environment.wind import coherence_rate, wind_spectrum
from model.response.identify import estimate
from model.response.nonlinear import record_model, solve_record
from model.response.solve import prepare, solve
from model.system.convolution import convolved_radiation

CASE = Path(__file__).resolve().parents[1] / "validation" / "oc4_deepcwind" / "oc4.fowt"
SHOWN = {"PtfmSurge": "surge", "PtfmHeave": "heave", "PtfmPitch": "pitch", "TTDspFA": "tower_fa1"}


def with_drag(model: Model, drag: str) -> Model:
    """Return the model with another drag model."""
    return replace(model, case=replace(model.case, options=replace(model.case.options, drag_model=drag)))


def drag(model: Model, records: int = 40, count: int = 16000, step: float = 0.5) -> None:
    """Print RAO errors, coherence at the resonances and kurtosis against |u| u on waves with random phases."""
    point, state = model.at(0.0), model.states[0]
    drive = state_excitation(model, state, 2 * np.pi * np.arange(1, int(0.6 * count * step)) / (count * step))
    grid = prepare(point.system, drive.omega, drive.heading)
    answers = {d: solve(point.system, point.mean, drive, grid=grid, drag=d) for d in ("relative", "third_order")}
    ready = record_model(point.system, point.mean, count, step, 0.0, answers["relative"].drag_damping)
    hz = ready.omega / (2 * np.pi)
    inside = (hz > 0.005) & (hz < 0.2)
    rng = np.random.default_rng(1)
    transfer = []
    for _ in range(records):
        lines = np.where(inside, np.sqrt(2 * hz[0]) * count / 2, 0.0) * np.exp(2j * np.pi * rng.uniform(size=len(hz)))
        full = np.zeros(count // 2 + 1, complex)
        full[1 : 1 + len(lines)] = lines
        transfer.append(solve_record(ready, np.fft.irfft(full, count)).amplitude[inside] / lines[inside, None])
    transfer, hz = np.array(transfer), hz[inside]
    print(f"{records} records of {count * step:g} s; errors in per cent over 0.006 to 0.199 Hz, smoothed over {9 * (hz[1] - hz[0]):.4f} Hz")
    for dof in SHOWN.values():
        k = point.system.dofs.index(dof)
        whole, coherent = (np.abs(transfer[..., k]) ** 2).mean(axis=0), np.abs(transfer[..., k].mean(axis=0)) ** 2
        coherent = (coherent - whole / records) / (1 - 1 / records)
        for name, answer in answers.items():
            follows = np.interp(hz, drive.omega / (2 * np.pi), np.abs(answer.to_wave[0, :, k]) ** 2)
            rest = np.interp(hz, drive.omega / (2 * np.pi), answer.incoherent[:, k, k].real * 2 * np.pi)
            figures = [_error(a, b, hz) for a, b in ((follows + rest, whole), (follows, coherent))]
            at = np.argmax(np.convolve(whole, np.ones(9) / 9, "same"))
            near = slice(at - 4, at + 5)
            shares = [x[near].sum() / y[near].sum() for x, y in ((follows, follows + rest), (coherent, whole))]
            sigma = np.sqrt((follows + rest).sum() / whole.sum()) - 1
            print(f"{dof:10s} {name:12s} |H|2 {figures[0]:5.2f}  H1 {figures[1]:5.2f}  sigma {100 * sigma:+5.2f}  coherence at peak {shares[0]:.3f} (drag itself {shares[1]:.3f})")


def _error(model, truth, hz) -> float:
    band = (hz > 0.006) & (hz < 0.199)
    a, b = (np.sqrt(np.convolve(x, np.ones(9) / 9, "same"))[band] for x in (model, truth))
    return 100 * np.sqrt(((a - b) ** 2).sum() / (b**2).sum())


def memory(model: Model) -> None:
    """Print errors in white noise with the radiation of HydroDyn's convolution (60 s, 0.05 s) late by some steps."""
    for kind in ("relative", "third_order"):
        for lag in (None, 0.5, 1.0, 1.5):
            changed = with_drag(model, kind)
            if lag is not None:
                hydro = convolved_radiation(model.hydro, 60.0, 0.05, lag)
                points = tuple(replace(p, system=replace(p.system, hydro=hydro)) for p in model.points)
                changed = replace(changed, points=points, hydro=hydro)
            found = validate(changed, model.case.references[0], nonlinear=False)
            print(kind, "as the data" if lag is None else f"late by {lag} steps")
            for c in found.channels:
                if c.name in SHOWN:
                    bands = " ".join(f"{100 * b:5.2f}" for b in c.band_errors)
                    print(f"  {c.name:10s} sigma {100 * c.std_error:+5.2f}  RAO {100 * c.rao_error:5.2f}  bands {bands}  same waves {100 * c.rao_error_same_waves:5.2f}")


def thrust(model: Model) -> None:
    """Print spectrum and slope of the rotor's wind (thrust over its slope in steady wind, plus the hub's motion), records over model."""
    reference, state = model.case.references[1], model.states[1]
    steady = fowtio.build(replace(model.case, thrust_table=None))
    point = steady.at(state.wind_speed)
    records = records_of([read_openfast_out(p) for p in reference.files], reference, point.outputs.names, point.outputs.units)
    side = evaluate(steady, state, records.names, 1000.0, 0.5 / records.step)
    felt = rotor_wind(side, records, model.deck.elastodyn.structure)
    found = estimate(records.cut(records.wind), [f[:, None] for f in records.cut(felt)], records.step, 500.0)
    f = found.frequency[1:]
    wind = fowtio.workflow.state_wind(steady, state)
    hub = wind_spectrum(wind, 2 * np.pi * f) * 2 * np.pi
    share = point.rotor.weight * point.rotor.step
    follows = np.exp(-np.outer(coherence_rate(wind, 2 * np.pi * f), point.rotor.radius)) @ share / share.sum()
    print("band [Hz]        hub's spectrum  rotor's spectrum  slope over hub's wind   coherence of both (model's)")
    for low, high in ((0.001, 0.003), (0.003, 0.006), (0.006, 0.01), (0.01, 0.015), (0.015, 0.02), (0.02, 0.03), (0.03, 0.06)):
        i = (f >= low) & (f < high)
        seen, rotor, cross = (x[1:][i].sum(axis=0) for x in (found.input_spectrum, found.output_spectrum[:, 0], found.cross_spectrum[:, 0]))
        expected, shared = np.interp(f[i], side.hz, side.wind).sum(), (follows[i] * hub[i]).sum()
        slope, coherence = np.abs(cross) / seen / (shared / hub[i].sum()), np.abs(cross) ** 2 / (seen * rotor)
        print(f"{low:.3f} to {high:.3f}   {seen / hub[i].sum():8.3f}        {rotor / expected:8.3f}          {slope:8.3f}               {coherence:.3f} ({shared**2 / hub[i].sum() / expected:.3f})")
    print(*(n for n in model.notes if n.startswith("thrust")), sep="\n")


if __name__ == "__main__":
    {"drag": drag, "memory": memory, "thrust": thrust}[sys.argv[1]](fowtio.build(fowtio.load(CASE)))
