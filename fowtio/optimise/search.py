"""Searches over the grid of designs: a genetic algorithm as the source study's, NSGA-II, every design, and the way downhill."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from fowtio.errors import ModelError
from fowtio.optimise.archive import Archive

_GRID_PART = 500


def search(
    archive: Archive, method: str, objectives: Sequence[str], *, population: int, generations: int, crossover: float, elite: int, seed: int,
    progress: Callable[[str], None],
) -> None:  # fmt: skip
    """Run a search to its end, every generation noted in the archive; method "ga", "nsga2" or "grid".

    Raises ModelError when the library of the genetic algorithms is not installed.
    """
    if method == "grid":
        every_design(archive, progress)
        return
    try:
        from fowtio.optimise.genetic import algorithm_of, evolve
    except ImportError as error:
        raise ModelError(f'the search needs pymoo ({error}); install it with: pip install "fowtio[design]"') from None

    def judge(places):
        rows = archive.rows(places)
        return np.stack([archive.value(n, rows) for n in objectives], axis=1), archive.violation[rows]

    def closed(places):
        members = archive.rows(places)
        archive.close_generation(members)
        progress(_told(archive, len(archive.generations), generations, objectives, members))

    evolve(algorithm_of(method, population, crossover, elite), archive.space.counts, len(objectives), generations, seed, judge, closed)


def _told(archive: Archive, number: int, total: int, objectives, members) -> str:
    feasible = members[archive.feasible[members]]
    best = ", ".join(f"{n} {archive.value(n, feasible).min():.4g}" for n in objectives) if len(feasible) else "none feasible yet"
    return f"generation {number} of {total}: {len(feasible)} of {len(members)} feasible, best {best}"


def every_design(archive: Archive, progress: Callable[[str], None]) -> None:
    """Evaluate every design of the space."""
    places = archive.space.every()
    for k in range(0, len(places), _GRID_PART):
        rows = archive.rows(places[k : k + _GRID_PART])
        archive.close_generation(rows)
        progress(f"{min(k + _GRID_PART, len(places))} of {len(places)} designs")


def polish(archive: Archive, objective: str, row: int, progress: Callable[[str], None]) -> int:
    """Return the row of the design that no neighbour on the grid betters, downhill from a row.

    Neighbours differ by one step in one or two variables.
    """
    space, here = archive.space, row
    moves = _moves(len(space.variables))
    while True:
        places = archive.places[here] + moves
        places = places[np.all((places >= 0) & (places < space.counts), axis=1)]
        best = archive.best(objective, archive.rows(places))
        if best is None or not archive.value(objective, best) < archive.value(objective, here):
            archive.save()
            return here
        here = best
        progress(f"downhill: {objective} {archive.value(objective, here):.5g}")


def polish_front(archive: Archive, objectives: Sequence[str], rows, progress: Callable[[str], None], rounds: int = 6) -> np.ndarray:
    """Return the rows of the Pareto front after neighbours of its members have been tried until none gets onto it.

    Neighbours differ by one step in one variable; at most so many rounds.
    """
    space, front, tried = archive.space, pareto_front(archive, objectives, rows), set()
    moves = np.concatenate([np.eye(len(space.variables), dtype=int), -np.eye(len(space.variables), dtype=int)])
    for _ in range(rounds):
        new = [r for r in front.tolist() if r not in tried]
        if not new:
            break
        tried.update(new)
        places = (archive.places[new][:, None] + moves).reshape(-1, len(space.variables))
        places = places[np.all((places >= 0) & (places < space.counts), axis=1)]
        front = pareto_front(archive, objectives, np.concatenate([front, archive.rows(places)]))
        progress(f"front of {len(front)} designs after the neighbours of {len(tried)}")
    archive.save()
    return front


def _moves(v: int) -> np.ndarray:
    steps = np.stack(np.meshgrid(*[[-1, 0, 1]] * v, indexing="ij"), axis=-1).reshape(-1, v)
    changed = np.abs(steps).sum(axis=1)
    return steps[(changed > 0) & (changed <= 2)]


def pareto_front(archive: Archive, objectives: Sequence[str], rows=None) -> np.ndarray:
    """Return the rows of the feasible designs that no other betters in all objectives, by the first objective."""
    rows = np.arange(len(archive.violation)) if rows is None else np.unique(rows)
    rows = rows[archive.feasible[rows]]
    values = np.stack([archive.value(n, rows) for n in objectives], axis=1)
    better = np.all(values[:, None] <= values[None], axis=2) & np.any(values[:, None] < values[None], axis=2)
    front = rows[~better.any(axis=0)]
    return front[np.argsort(archive.value(objectives[0], front), kind="stable")]
