"""Genetic algorithms on a grid of designs, with pymoo: one objective with elite count and crossover fraction, several with NSGA-II."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from pymoo.algorithms.base.genetic import GeneticAlgorithm
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.core.algorithm import Algorithm
from pymoo.core.evaluator import Evaluator
from pymoo.core.mating import Mating
from pymoo.core.mutation import Mutation
from pymoo.core.population import Population
from pymoo.core.problem import Problem
from pymoo.operators.crossover.ux import UniformCrossover
from pymoo.operators.sampling.rnd import IntegerRandomSampling
from pymoo.operators.selection.tournament import TournamentSelection
from pymoo.problems.static import StaticProblem

WORST = 1e30  # objective of a design that did not get so far


class Redraw(Mutation):
    """Draws each variable anew on the grid with a chance, one variable at the least."""

    def __init__(self, chance: float):
        super().__init__(prob=1.0)
        self.chance = chance

    def _do(self, problem, X, *args, random_state=None, **kwargs):
        x = X.astype(int)
        change = chosen(x.shape, self.chance, random_state)
        bounds = zip(problem.xl.astype(int), problem.xu.astype(int), strict=True)
        drawn = np.stack([random_state.integers(low, high + 1, size=len(x)) for low, high in bounds], axis=1)
        return np.where(change, drawn, x)


class Step(Mutation):
    """Moves half of the variables, one at the least, by normal steps of a part of their range."""

    def __init__(self, part: float):
        super().__init__(prob=1.0)
        self.part = part

    def _do(self, problem, X, *args, random_state=None, **kwargs):
        x = X.astype(int)
        change = chosen(x.shape, 0.5, random_state)
        step = np.round(random_state.normal(size=x.shape) * self.part * (problem.xu - problem.xl))
        return np.where(change, np.clip(x + step, problem.xl, problem.xu).astype(int), x)


class Breeding(Mating):
    """A fraction of the children by crossover alone, each variable from either parent; the others by mutation alone."""

    def __init__(self, fraction: float):
        super().__init__(TournamentSelection(func_comp=fittest, pressure=4), UniformCrossover(prob=1.0), Step(0.3))
        self.fraction = fraction

    def _do(self, problem, pop, n_offsprings, parents=None, random_state=None, **kwargs):
        crossed = round(self.fraction * n_offsprings)
        children, copies = Population.create(), Population.create()
        if crossed:
            pairs = self.selection(problem, pop, -(-crossed // 2), n_parents=2, random_state=random_state, **kwargs)
            children = self.crossover(problem, pairs, random_state=random_state, **kwargs)[:crossed]
        if crossed < n_offsprings:
            alone = self.selection(problem, pop, n_offsprings - crossed, n_parents=1, random_state=random_state, **kwargs)
            copies = Population.new("X", np.array([p[0].X for p in alone]))
            copies = self.mutation(problem, copies, random_state=random_state, **kwargs)
        return Population.merge(children, copies)


class Generational(GeneticAlgorithm):
    """A generation is the elite of the one before and its children, as MATLAB's `ga`."""

    def __init__(self, population: int, fraction: float, elite: int):
        super().__init__(
            pop_size=population, sampling=IntegerRandomSampling(), mating=Breeding(fraction), n_offsprings=population - elite,
            eliminate_duplicates=False,
        )  # fmt: skip
        self.elite = elite

    def _advance(self, infills=None, **kwargs):
        order = np.lexsort((self.pop.get("F")[:, 0], self.pop.get("CV")[:, 0]))
        self.pop = Population.merge(self.pop[order[: self.elite]], infills)


def chosen(shape: tuple[int, int], chance: float, random_state) -> np.ndarray:
    """Return which variables of which children (N, v) change: each with a chance, one of every child at the least."""
    out = random_state.random(shape) < chance
    out[np.arange(shape[0]), random_state.integers(shape[1], size=shape[0])] = True
    return out


def fittest(pop, groups, **_) -> np.ndarray:
    """Return the winner of each group: the least violation, then the smallest objective."""
    rank = np.empty(len(pop), dtype=int)
    rank[np.lexsort((pop.get("F")[:, 0], pop.get("CV")[:, 0]))] = np.arange(len(pop))
    return groups[np.arange(len(groups)), np.argmin(rank[groups], axis=1)][:, None]


def algorithm_of(method: str, population: int, fraction: float, elite: int) -> Algorithm:
    """Return the algorithm "ga" or "nsga2" (Deb et al. 2002; it keeps all that nothing betters and has no elite count)."""
    if method == "ga":
        return Generational(population, fraction, elite)
    return NSGA2(pop_size=population, sampling=IntegerRandomSampling(), crossover=UniformCrossover(prob=fraction), mutation=Redraw(0.2))


def evolve(
    algorithm: Algorithm, counts, objectives: int, generations: int, seed: int, judge: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]],
    closed: Callable[[np.ndarray], None],
) -> None:  # fmt: skip
    """Run an algorithm over places on a grid with `counts` (v) values a variable.

    judge gives objectives (N, objectives) and violation (N) of places (N, v); closed is told the members of every generation.
    """
    problem = Problem(n_var=len(counts), n_obj=objectives, n_ieq_constr=1, xl=np.zeros(len(counts)), xu=np.asarray(counts) - 1, vtype=int)
    algorithm.setup(problem, termination=("n_gen", generations), seed=seed)
    while algorithm.has_next():
        asked = algorithm.ask()
        values, violation = judge(asked.get("X").astype(int))
        found = StaticProblem(problem, F=np.where(violation[:, None] > 0, WORST, values), G=violation[:, None])
        Evaluator().eval(found, asked)
        algorithm.tell(infills=asked)
        closed(algorithm.pop.get("X").astype(int))
