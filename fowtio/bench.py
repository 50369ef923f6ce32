"""Timings of the model on this machine."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

from fowtio.case import load
from fowtio.workflow import Model, build, state_excitation
from model.response.assemble import equilibrium
from model.response.loads import channel_response, linear_outputs, response_spectra
from model.response.solve import prepare, solve
from model.response.statistics import statistics


def time_case(path: Path, repeat: int = 20) -> list[tuple[str, float]]:
    """Return (what, seconds): reading and assembly once, the parts of one evaluation as the best of `repeat` runs."""
    start = time.perf_counter()
    model = build(load(path))
    rows = [("read and assemble", time.perf_counter() - start)]
    point, state = model.points[0], model.states[0]
    drive = state_excitation(model, state)
    rows.append(("coefficients on the frequency grid", _best(lambda: prepare(point.system, drive.omega, drive.heading), repeat)))
    rows.append(("mean offset", _best(lambda: equilibrium(point.system), repeat)))
    grid = prepare(point.system, drive.omega, drive.heading)
    rows.append(("drag and motions", _best(lambda: solve(point.system, point.mean, drive, grid=grid), repeat)))
    rows.append(("the same with drag to third order", _best(lambda: solve(point.system, point.mean, drive, grid=grid, drag="third_order"), repeat)))
    rows.append(("one evaluation in all", _best(lambda: evaluate(model, grid), repeat)))
    return rows


def evaluate(model: Model, grid) -> object:
    """Return the statistics of one evaluation of the first state: mean offset, drag to convergence, motions, loads."""
    point, state = model.points[0], model.states[0]
    mean = equilibrium(point.system)
    drive = state_excitation(model, state)
    response = solve(point.system, mean, drive, grid=grid)
    outputs = linear_outputs(point.system, mean, model.deck.elastodyn.structure)
    channels = channel_response(outputs, response)
    return statistics(response_spectra(channels, response), drive.omega, channels.mean)


def _best(function: Callable, repeat: int) -> float:
    best = float("inf")
    for _ in range(repeat):
        start = time.perf_counter()
        function()
        best = min(best, time.perf_counter() - start)
    return best
