"""GA-BP: a genetic algorithm chooses the network's size and start; it is then trained like BP."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fmu_compensator.fit.error_models.base import Task
from fmu_compensator.fit.error_models.options import whole, within
from fmu_compensator.fit.training import Array
from measurement.errors import BadInput, refuse_other
from studies.fit.bp import (
    DECAY,
    GOAL,
    MOST_TRAINING_ROWS,
    TRAINING_ITERATIONS,
    BackPropagation,
    Samples,
    hidden_layers,
    rows_wanted,
)
from studies.fit.by_run import FEWEST_TO_LEAVE_OUT as PARTS
from studies.fit.genetic import GeneticSettings, evolve
from studies.fit.network_training import Shape, levenberg_marquardt, nguyen_widrow

Rows = NDArray[np.bool_]

FEWEST_HIDDEN, MOST_HIDDEN = 3, 15
"""Range around the study's 10: a judgement, set on no data."""
TRIAL_ITERATIONS = 15
"""Iterations of training after which a number of hidden nodes is judged: set on no data."""
SIZE_SETTINGS = GeneticSettings(population=8, generations=4)
"""A judgement, set on no data: there are only thirteen sizes."""
WIDEST = 3.0
"""Weights and thresholds of the first generation are within plus or minus this [1]: a judgement,
set on no data."""
ROWS_FOR_FITNESS = 250
"""Limits the computing time; a judgement, set on no data."""
JUDGES = ("left_out", "training")


class GeneticBackPropagation(BackPropagation):
    """The fitness is the study's: 1 / sum abs(y - Q) for the size, 1 / sum (y - Q)^2 for the
    weights.
    """

    title = "GA-BP neural network"

    @classmethod
    def fit(
        cls,
        task: Task,
        *,
        hidden: Sequence[int] | int | None = None,
        population: int = 60,
        generations: int = 100,
        iterations: int = TRAINING_ITERATIONS,
        goal: float = GOAL,
        decay: float = DECAY,
        rows: int = MOST_TRAINING_ROWS,
        nodes_by: str = "left_out",
        seed: int = 0,
    ) -> GeneticBackPropagation:
        """Return the network trained on the task's runs.

        Parameters
        ----------
        task : Task
            Runs and names.
        hidden : int, optional
            Nodes of the hidden layer; by default the genetic algorithm chooses.
        population, generations : int
            Of the search for the initial weights.
        iterations, goal, decay, rows, seed
            As for `bp`.
        nodes_by : {"left_out", "training"}
            Criterion of the search for the number of nodes. ``training`` is the study's: the error
            of the training rows, which more nodes hardly ever increase, so that the search ends at
            or near the largest number. ``left_out``: the error in periods that were left out.

        Raises
        ------
        BadInput
            For a value that is not allowed, too few rows, or constant columns.
        """
        refuse_other("ga_bp", "nodes_by", nodes_by, JUDGES)
        settings = GeneticSettings(
            whole("ga_bp", "population", population, 4, 1000),
            whole("ga_bp", "generations", generations, 1, 10_000),
        )
        goal = within("ga_bp", "goal", goal, 0.0, 1.0)
        decay = within("ga_bp", "decay", decay, 0.0, 1e3)
        iterations = whole("ga_bp", "iterations", iterations, 1, 100_000)
        samples = Samples.of(task, rows_wanted("ga_bp", rows))
        random = np.random.default_rng(seed)
        tried: dict[int, float] = {}
        if hidden is None:
            nodes, tried = _number_of_nodes(samples, decay, nodes_by, random)
        else:
            layers = hidden_layers("ga_bp", hidden)
            if len(layers) > 1:
                raise BadInput("ga_bp", "hidden", "one hidden layer is allowed")
            nodes = layers[0]
        shape = Shape((samples.x.shape[1], nodes, samples.y.shape[1]))
        start, best = _start(samples, shape, settings, random)
        training = levenberg_marquardt(
            shape,
            start,
            samples.x,
            samples.y,
            samples.weights,
            iterations=iterations,
            goal=goal,
            decay=decay,
        )
        diagnostics = {
            "hidden_nodes_tried": {str(n): float(f"{f:.4g}") for n, f in sorted(tried.items())},
            "fitness_by_generation": [float(f"{value:.4g}") for value in best],
        }
        return cls(shape, training, samples.scales, diagnostics)


def _number_of_nodes(
    samples: Samples, decay: float, nodes_by: str, random: np.random.Generator
) -> tuple[int, dict[int, float]]:
    """Return the number of hidden nodes found by the search, and those that it tried."""
    thin = max(1, len(samples.x) // ROWS_FOR_FITNESS)
    tried: dict[int, float] = {}
    # One seed for all sizes: each size has its own start, the same at every trial.
    seed = int(random.integers(2**31))
    whole = np.ones(len(samples.x), dtype=bool)
    fold = _folds(samples.counts)
    splits = (
        [(whole, whole)]
        if nodes_by == "training"
        else [(fold != k, fold == k) for k in range(PARTS)]
    )

    def missed(nodes: int, learnt: Rows, judged: Rows) -> float:
        x, y, weights = (part[learnt][::thin] for part in (samples.x, samples.y, samples.weights))
        shape = Shape((x.shape[1], nodes, y.shape[1]))
        trained = levenberg_marquardt(
            shape,
            nguyen_widrow(shape, np.random.default_rng([seed, nodes])),
            x,
            y,
            weights / weights.sum(),
            iterations=TRIAL_ITERATIONS,
            goal=0.0,
            decay=decay,
        )
        predicted = shape.outputs(trained.theta, samples.x[judged])
        return float(np.abs(predicted - samples.y[judged]).sum())

    def fitness_of(nodes: int) -> float:
        if nodes not in tried:
            total = sum(missed(nodes, *split) for split in splits)
            tried[nodes] = 1.0 / max(total, 1e-12)
        return tried[nodes]

    def fitness(people: Array) -> Array:
        return np.array([fitness_of(round(float(genes[0]))) for genes in people])

    first = random.uniform(FEWEST_HIDDEN, MOST_HIDDEN, (SIZE_SETTINGS.population, 1))
    best, _ = evolve(first, fitness, FEWEST_HIDDEN, MOST_HIDDEN, SIZE_SETTINGS, random)
    return round(float(best[0])), tried


def _folds(counts: Sequence[int]) -> NDArray[np.intp]:
    """Return the fold of every row: whole runs, or periods of time if there are few runs.

    With fewer runs than parts, each is cut into twice as many periods, which alternate.
    """
    if len(counts) >= PARTS:
        return np.repeat(np.arange(len(counts)) % PARTS, counts)
    parts = [np.arange(count) * 2 * PARTS // max(count, 1) % PARTS for count in counts]
    return np.concatenate(parts)


def _start(
    samples: Samples, shape: Shape, settings: GeneticSettings, random: np.random.Generator
) -> tuple[Array, list[float]]:
    """Return the initial weights and thresholds found by the search."""
    thin = max(1, len(samples.x) // ROWS_FOR_FITNESS)
    x, y = samples.x[::thin], samples.y[::thin]

    def fitness(people: Array) -> Array:
        missed = np.sum((shape.outputs(people, x) - y) ** 2, axis=(1, 2))
        return np.asarray(1.0 / np.maximum(missed, 1e-12))

    first = random.uniform(-1.0, 1.0, (settings.population, shape.size))
    # Half of the first generation are starts as for BP, because pure chance takes too long.
    for person in range(0, settings.population, 2):
        first[person] = nguyen_widrow(shape, random)
    return evolve(np.clip(first, -WIDEST, WIDEST), fitness, -WIDEST, WIDEST, settings, random)
