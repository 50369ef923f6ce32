"""Time the interpolation of all coefficients of many hulls at many frequencies.

    python benchmarks/bench_database.py [DATABASE] [--hulls 1000] [--frequencies 100] [--headings 1]

Without a database file the one that comes with fowtio is taken, or one of the same size with random numbers when there is none.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

from fowtio.database import DIMENSIONS, DatabasePlan, plan_axes, read_database
from fowtio.errors import FowtioError
from model.system.hydro_database import HydroDatabase, interpolate


def random_database(plan: DatabasePlan) -> HydroDatabase:
    """Return a database of a plan's size with random numbers."""
    axes, rng = plan_axes(plan), np.random.default_rng(1)
    shape = tuple(len(a) for a in axes)
    n, m = 1 + len(plan.scaled_frequency), len(plan.headings_deg)
    return HydroDatabase(
        **dict(zip(DIMENSIONS, axes, strict=True)), inverse_depth=1 / np.array(plan.depths), heading=np.radians(plan.headings_deg),
        scaled_frequency=np.concatenate([[0.0], plan.scaled_frequency]), values=rng.random((len(plan.depths), *shape, n, 10 + 12 * m)),
        infinite=rng.random((*shape, 5)), density=1025.0, gravity=9.80665, stretch=plan.stretch,
    )  # fmt: skip


def main() -> None:
    """Time the first call (which fits the splines of these headings), then the best of five."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("database", nargs="?")
    for name, default in (("hulls", 1000), ("frequencies", 100), ("headings", 1)):
        parser.add_argument(f"--{name}", type=int, default=default)
    args = parser.parse_args()
    try:
        database = read_database(args.database)
    except FowtioError as error:
        print(f"{error}: random numbers instead")
        database = random_database(DatabasePlan())
    low, high = (np.array([getattr(database, n)[k] for n in DIMENSIONS]) for k in (0, -1))
    designs = low + np.random.default_rng(0).random((args.hulls, 3)) * (high - low)
    omega, heading = np.linspace(0.05, 2.5, args.frequencies), np.linspace(0.0, np.pi / 2, args.headings)
    times = []
    for _ in range(6):
        start = time.perf_counter(), time.process_time()
        interpolate(database, designs, omega, heading, depth=200.0)
        times.append((time.perf_counter() - start[0], time.process_time() - start[1]))
    print(
        f"{args.hulls} hulls, {args.frequencies} frequencies, {args.headings} headings: first {times[0][0]:.3f} s, then {min(t for t, _ in times[1:]):.3f} s"
        f" (processor time {times[0][1]:.3f} and {min(t for _, t in times[1:]):.3f} s)"
    )


if __name__ == "__main__":
    main()
