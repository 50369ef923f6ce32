# ruff: noqa: I001
"""The main job's speed on this machine: one evaluation, the whole run without figures, the help text."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from pathlib import Path

import fowtio.cli  # noqa: F401  one thread of linear algebra, as the commands have; before numpy
import numpy as np

from fowtio.bench import time_case
from fowtio.case import load
from fowtio.start import embedded_folder
from fowtio.workflow import build
from model.environment.sea import SeaState, wave_spectrum
from model.response.batch import batch_std, solve_many
from model.response.solve import prepare

STUDY = embedded_folder() / "oc4.fowt"


def _wall(*arguments: str) -> float:
    start = time.perf_counter()
    subprocess.run([sys.executable, "-m", "fowtio", *arguments], check=True, stdout=subprocess.DEVNULL)
    return time.perf_counter() - start


def _batch(count: int = 1000) -> float:
    """Return the seconds that `count` random sea states take in one call on the parked model (best of three)."""
    model = build(load(STUDY))
    point, rng = model.points[0], np.random.default_rng(1)
    heights, periods = rng.uniform(0.5, 9.0, count), rng.uniform(5.0, 16.0, count)
    seas = [SeaState(kind="jonswap", significant_height=h, peak_period=t, gamma=2.0) for h, t in zip(heights, periods, strict=True)]
    spectra = np.stack([wave_spectrum(sea, model.omega) for sea in seas])[:, None]
    grid = prepare(point.system, model.omega, np.array([0.0]))
    best = np.inf
    for _ in range(3):
        start = time.perf_counter()
        batch_std(point.outputs, solve_many(point.system, point.mean, grid, spectra))
        best = min(best, time.perf_counter() - start)
    return best


def main() -> None:
    """Print the timings."""
    print(f"{'':44}{'measured':>12}{'wanted':>12}")
    for name, seconds in time_case(STUDY):
        wanted = "10 ms" if name == "one evaluation in all" else ""
        print(f"{name:44}{seconds * 1e3:9.2f} ms{wanted:>12}")
    print(f"{'1,000 sea states in one call, all channels':44}{_batch():9.2f} s {'1 s':>12}")
    with tempfile.TemporaryDirectory() as folder:
        runs = [_wall("run", str(STUDY), "-o", str(Path(folder) / str(k)), "--no-figures", "--quiet") for k in range(3)]
        full = _wall("run", str(STUDY), "-o", str(Path(folder) / "full"), "--quiet")
    print(f"{'fowtio run without figures (warm)':44}{min(runs):9.2f} s {'3 s':>12}")
    print(f"{'fowtio run with figures and report':44}{full:9.2f} s ")
    print(f"{'fowtio --help':44}{min(_wall('--help') for _ in range(3)):9.2f} s {'0.5 s':>12}")


if __name__ == "__main__":
    main()
