"""A real-coded genetic algorithm: roulette selection, single-point crossover, mutation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fmu_compensator.fit.training import Array


@dataclass(frozen=True)
class GeneticSettings:
    """How a population evolves.

    Attributes
    ----------
    population, generations : int
        Number of individuals and of generations.
    crossover, mutation : float
        Probabilities that a pair exchanges a part, and that an individual changes one gene [1].
    """

    population: int = 60
    generations: int = 100
    crossover: float = 0.7
    mutation: float = 0.2


def evolve(
    first: Array,
    fitness: Callable[[Array], Array],
    low: float,
    high: float,
    settings: GeneticSettings,
    random: np.random.Generator,
) -> tuple[Array, list[float]]:
    """Return the best individual, and the best fitness of every generation.

    Parameters
    ----------
    first : array (population, genes)
        The first generation.
    fitness : callable
        Maps a generation (population, genes) to the fitness of each individual, above 0.
    low, high : float
        Bounds of the genes.
    settings : GeneticSettings
        How a population evolves.
    random : Generator
        Source of random numbers.

    Returns
    -------
    best : array, shape (genes,)
    history : list of float
        Best fitness of each generation.

    Notes
    -----
    The best individual survives unchanged (elitism), so the best fitness never falls.
    """
    people, count, genes = first.copy(), *first.shape
    value = fitness(people)
    best = [float(value.max())]
    for _ in range(settings.generations):
        elite = people[value.argmax()].copy()
        # Roulette: the probability of becoming a parent is proportional to fitness.
        parents = people[random.choice(count, size=count, p=value / value.sum())]
        children = parents.copy()
        pairs = np.arange(0, count - 1, 2)
        crossed = pairs[random.random(len(pairs)) < settings.crossover]
        points = random.integers(1, genes, len(crossed)) if genes > 1 else np.zeros(len(crossed))
        tail = np.arange(genes)[None, :] >= points[:, None]
        children[crossed] = np.where(tail, parents[crossed + 1], parents[crossed])
        children[crossed + 1] = np.where(tail, parents[crossed], parents[crossed + 1])
        mutated = np.flatnonzero(random.random(count) < settings.mutation)
        place = random.integers(0, genes, len(mutated))
        shift = 0.3 * random.standard_normal(len(mutated)) * (high - low) / 2.0
        children[mutated, place] = np.clip(children[mutated, place] + shift, low, high)
        children[0] = elite
        people, value = children, fitness(children)
        best.append(float(value.max()))
    return people[value.argmax()], best
