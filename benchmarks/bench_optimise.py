"""Speed of the optimisation on this machine: one design among 200, stages, whole studies; with --exhaustive the genetic algorithm
against every design of the three-variable space.
"""

from __future__ import annotations

import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

import fowtio
from fowtio.optimise.archive import in_chunks
from fowtio.optimise.export import export_design
from fowtio.optimise.run import ChunkJudge, optimise
from fowtio.optimise.setting import setting_of
from fowtio.optimise.study import load_optimisation
from fowtio.optimise.workers import workers

PEAKS = ("surge_peak:parked", "heave_peak:parked", "pitch_peak:parked")


def one_design(jobs: int) -> float:
    """Return the milliseconds of wall time that a design takes among 200, moment, cost and displacements at rated (best of five)."""
    study = load_optimisation("tuscany")
    setting = setting_of(study)
    rng = np.random.default_rng(1)
    anchor = rng.uniform(600, 900, 200)
    designs = np.column_stack([rng.uniform(14, 20, 200), rng.uniform(38, 45, 200), rng.uniform(20, 32, 200), anchor, anchor])
    judge = ChunkJudge(setting=setting, names=("tower_moment:rated", "cost", "mean_surge:rated", "mean_pitch:rated", "grounded_share:rated"), constraints=())
    best = np.inf
    with workers(jobs) as spread:
        for _ in range(5):
            start = time.perf_counter()
            found = in_chunks(judge, designs, spread)
            best = min(best, time.perf_counter() - start)
    assert np.isfinite(found.values).all()
    return best / 200 * 1e3


def stage(name: str, stages, jobs: int = 2) -> tuple[float, object]:
    """Return the seconds of wall time of stages of a shipped study, going downhill included, and the result."""
    study = load_optimisation(name)
    start = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder, workers(jobs) as spread:
        result = optimise(study, Path(folder), stages=stages, mapper=spread)
    return time.perf_counter() - start, result


def same_by_the_main_job(result) -> float:
    """Return the largest relative difference of moment and mean offset between the search and `fowtio run` on the exported optimum."""
    worst = 0.0
    for name, found in result.stages.items():
        if found.best is None:
            continue
        with tempfile.TemporaryDirectory() as folder:
            model = fowtio.build(fowtio.load(export_design(result, name, found.optimum, Path(folder) / "design")))
            item = next(x for x in fowtio.loads(fowtio.solve(model)) if x.state.name == "rated")
            k = item.channels.index("TwrBsMyt")
            moment = (abs(item.statistics.mean[k]) + item.statistics.std[k]) * 1e-6
        value = {n: float(found.archive.value(n, found.best)) for n in found.archive.names}
        pairs = ((moment, value["tower_moment:rated"]), (item.point.mean.offset[0], value["mean_surge:rated"]))
        worst = max(worst, *(abs(a / b - 1) for a, b in pairs))
    return worst


def exhaustive() -> None:
    """Print how close the genetic algorithm comes to the best of all 10,075 designs of three variables, for ten seeds."""
    study = load_optimisation("rao_peaks")
    first = study.stage("surge3")
    grid = replace(study, stages=tuple(replace(first, name=f"grid {n}", method="grid", objectives=(n,)) for n in PEAKS), published=())
    with workers(2) as spread:
        start = time.perf_counter()
        whole = {n: optimise(grid, mapper=spread, stages=[f"grid {n}"]).stages[f"grid {n}"] for n in PEAKS}
        print(f"every design of the space, three times: {time.perf_counter() - start:.0f} s")
        for n, every in whole.items():
            gaps = []
            for seed in range(1, 11):
                tried = replace(study, stages=(replace(first, objectives=(n,), seed=seed),), polish=False, published=())
                found = optimise(tried, mapper=spread).stages["surge3"]
                gaps.append(100 * (found.archive.value(n, found.found) / every.archive.value(n, every.best) - 1))
            print(f"{n:20} every design {every.archive.value(n, every.best):.4f} at {every.optimum[:3]}, genetic algorithm {gaps[0]:+.2f} % (seed 1), ten seeds mean {np.mean(gaps):+.2f} %, worst {max(gaps):+.2f} %")


def main() -> None:
    """Print the timings."""
    print(f"{'':58}{'measured':>12}{'wanted':>12}")
    print(f"{'one design among 200, objectives of stage 1, two threads':58}{one_design(2):9.2f} ms{'2 ms':>12}")
    print(f"{'the same, one thread':58}{one_design(1):9.2f} ms")
    seconds, _ = stage("tuscany", ["ultimate"])
    print(f"{'stage 1 of Tuscany (4 x 200), going downhill included':58}{seconds:9.1f} s {'10 s':>12}")
    seconds, _ = stage("rao_peaks", ["surge5"])
    print(f"{'chapter 6, five variables (4 x 500), downhill included':58}{seconds:9.1f} s {'20 s':>12}")
    seconds, result = stage("tuscany", None)
    print(f"{'all of Tuscany, three stages, nine fatigue states':58}{seconds:9.1f} s {'180 s':>12}")
    print(f"{'optimum by the main job against the search, worst':58}{same_by_the_main_job(result):12.1e}{'1e-8':>10}")
    if "--exhaustive" in sys.argv:
        exhaustive()


if __name__ == "__main__":
    main()
