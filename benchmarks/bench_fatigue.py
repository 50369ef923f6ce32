"""Times fits, contours, sampling and lifetime damage: python benchmarks/bench_fatigue.py [--large] [--study STUDY].

Damage: states x 36 points from transfer functions of two correlated moments and one spectrum per state and cause, the
stress moments, Dirlik's distribution, a two-slope curve. With --study the loads of the study's own states are solved
too.
"""

from __future__ import annotations

import argparse
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from fowtio.site import load_site
from model.environment.contours import iform_contour, outside_fraction, reliability_index
from model.environment.joint import sample
from model.environment.metocean import fit_joint, thesis_form
from model.response.endurance import sn_curve
from model.response.fatigue import (
    TubeSection,
    cross_moments,
    damage_rate,
    moments_around,
    range_distribution,
    stress_rows,
)

ROWS = stress_rows(TubeSection(diameter=6.5, thickness=0.027), np.linspace(0, 2 * np.pi, 36, endpoint=False))
CURVE = sn_curve("D")


def timed(name: str, call, repeat: int = 3):
    """Print the best of several times of a call and return its result."""
    best, out = np.inf, None
    for _ in range(repeat):
        start = time.perf_counter()
        out = call()
        best = min(best, time.perf_counter() - start)
    print(f"{name:62s} {best * 1e3:10.1f} ms", flush=True)
    return out


def damage(cross) -> np.ndarray:
    """Return the damage per second (s, 36) of states from the cross moments of their loads (s, 4, 2, 2)."""
    return damage_rate(range_distribution(moments_around(ROWS, cross)), CURVE, 1.3)


def lifetime(count: int, frequencies: int = 400) -> float:
    """Return the mean damage of random states, from transfer functions and spectra, two threads over parts."""
    omega = np.linspace(0.01, 4.0, frequencies)
    rng = np.random.default_rng(1)
    transfers = 1e6 * (rng.normal(size=(4, frequencies, 2)) + 1j * rng.normal(size=(4, frequencies, 2)))

    def part(size: int) -> float:
        own = np.random.default_rng(size)
        spectra = own.random((size, 4, frequencies), dtype=np.float32)
        return float(damage(cross_moments(transfers, spectra, omega)).sum())

    sizes = [len(p) for p in np.array_split(np.arange(count), max(1, count // 1000))]
    with ThreadPoolExecutor(2) as pool:
        return sum(pool.map(part, sizes)) / count


def main() -> None:
    """Run the timings."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--large", action="store_true", help="100 000 states, ten million draws")
    parser.add_argument("--study", help="study (.fowt) whose lifetime is timed, at Sardinia")
    options = parser.parse_args()
    site = load_site("sardinia")
    x = sample(site.model, 27 * 8766, np.random.default_rng(1))
    states = {name: x[:, k] for k, name in enumerate(site.model.names)}
    timed("fit of 27 years of hours, three variables, likelihood", lambda: fit_joint(states, thesis_form()))
    timed("3-D IFORM contour, 2000 points", lambda: iform_contour(site.model, reliability_index(50), 2000))
    cross = np.random.default_rng(2).random((500, 4, 2, 2)) * 1e13 * np.array([1, 0.1, 0.02, 0.002])[:, None, None]
    cross = cross + cross.swapaxes(-1, -2) + 2e13 * np.eye(2) * np.array([1, 0.1, 0.02, 0.002])[:, None, None]
    timed("lifetime damage, 500 states x 36 points, loads given", lambda: damage(cross))
    timed("the same from transfer functions and spectra", lambda: lifetime(500))
    if options.large:
        timed("100 000 states x 36 points from transfer functions", lambda: lifetime(100_000), 1)

        def draws() -> float:
            beta, rng = reliability_index(1), np.random.default_rng(3)
            return sum(outside_fraction(site.model, beta, sample(site.model, 1_000_000, rng))[0] for _ in range(10))

        timed("ten million draws against the contour", draws, 1)
    if options.study:
        import fowtio
        from fowtio.fatigue_study import fatigue_study

        case = fowtio.load(options.study)
        found = timed("whole lifetime study with ultimate loads", lambda: fatigue_study(case, site), 1)
        print(f"{'':4s}{len(found.loads.table)} states, {len(found.loads.model.points)} operating points")


if __name__ == "__main__":
    main()
