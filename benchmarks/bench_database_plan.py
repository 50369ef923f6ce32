"""What each choice of the database's plan brings: errors of interpolation on the coarse mesh, a thirteenth of the cost.

    python benchmarks/bench_database_plan.py [--hulls 16] [--seed 5] [--jobs 2] [--only NAME ...]

Every plan's hulls and the random ones are solved on the coarse mesh alone; the table gives the largest error, in % of a coefficient's
largest value on a hull, from the polynomials in the dimensions (at the plan's frequencies and headings) and with the splines
and headings (half-way between them), and where it lies. 5 to 8 minutes of processor time a plan.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import replace

import numpy as np
from joblib import Parallel, delayed

from fowtio.bem_report import NAMES, random_hulls
from fowtio.database import DatabasePlan, plan_nodes, solve_hull
from fowtio.database_assemble import assembled
from fowtio.database_check import errors, plan_between

PLAN = replace(DatabasePlan(), depths=(np.inf,))
EVEN = tuple(np.round(np.arange(1, 48) * 0.1, 3).tolist())
PLANS = {
    "the plan": PLAN,
    "no stretch": replace(PLAN, stretch=0.0),
    "four diameters": replace(PLAN, diameter=(14.0, 20.0, 4)),
    "panels of 1.4": replace(PLAN, waterline_power=1.4),
    "steps of 0.1 in s": replace(PLAN, scaled_frequency=EVEN),
    "steps of 10 deg": replace(PLAN, headings_deg=tuple(np.arange(0.0, 61.0, 10.0).tolist())),
}


def solved(plan: DatabasePlan, hulls, jobs: int) -> list[dict]:
    """Return the solutions of hulls on the coarse mesh in deep water."""
    return list(Parallel(n_jobs=jobs)(delayed(solve_hull)(plan, tuple(map(float, h)), np.inf, coarse=True) for h in hulls))


def worst(found: list[dict]) -> str:
    """Return the three coefficients with the largest errors."""
    largest = np.max([np.concatenate([r[n] for n in ("added_mass", "radiation_damping", "excitation")]) for r in found], axis=0)
    return ", ".join(f"{NAMES[k]} {100 * largest[k]:.2f}" for k in np.argsort(-largest)[:4])


def main() -> None:
    """Print one line a plan."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name, default in (("hulls", 16), ("seed", 5), ("jobs", 2)):
        parser.add_argument(f"--{name}", type=int, default=default)
    parser.add_argument("--only", nargs="*", choices=list(PLANS), default=list(PLANS))
    args = parser.parse_args()
    print(f"{'':18s} {'dimensions alone':42s} with frequencies and headings")
    for name in args.only:
        plan, start = PLANS[name], time.perf_counter()
        database = assembled(plan, solved(plan, plan_nodes(plan), args.jobs))
        hulls = random_hulls(database, args.hulls, args.seed)
        texts = []
        for tested in (plan, plan_between(plan)):
            texts.append(worst([errors(database, tested, h, f, np.inf) for h, f in zip(hulls, solved(tested, hulls, args.jobs), strict=True)]))
        print(f"{name:18s} {texts[0]:42s} {texts[1]}   ({time.perf_counter() - start:.0f} s)", flush=True)


if __name__ == "__main__":
    main()
