"""Back-propagation network, trained by Levenberg-Marquardt."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from fmu_compensator.fit.error_models.base import FittedModel, Task
from fmu_compensator.fit.error_models.options import (
    FEWEST_ROWS,
    refuse_poor,
    whole,
    within,
)
from fmu_compensator.fit.training import Array
from measurement.errors import BadInput
from studies.fit.network_training import (
    Shape,
    Training,
    levenberg_marquardt,
    nguyen_widrow,
    scaling,
)

MOST_TRAINING_ROWS = 800
"""Rows are thinned to about this number: training time grows with it, and neighbouring rows of a
slow drift are redundant. The option ``rows`` sets another number; 0 keeps every row. Set on no
data."""
HIDDEN = (10,)
"""Given by the jig-borer study of GA-BP, whose network is 4-10-3."""
TRAINING_ITERATIONS, GOAL, DECAY = 200, 1e-3, 1e-3
"""Set on no data; docs/studies.md has rows with and without DECAY."""


@dataclass(frozen=True)
class Samples:
    """A task's rows, scaled to -1 to 1.

    Attributes
    ----------
    x, y : arrays (n, k), (n, m)
        Inputs and targets [1].
    weights : array (n,)
        Time that each row represents, sum 1 [1].
    scales : tuple of arrays
        Middle and half range of inputs, then of targets.
    counts : list of int
        Rows of each run.
    """

    x: Array
    y: Array
    weights: Array
    scales: tuple[Array, Array, Array, Array]
    counts: list[int]

    @classmethod
    def of(cls, task: Task, rows: int) -> Samples:
        """Return the samples of a task, thinned to about *rows* rows; 0 keeps all."""
        refuse_poor(task)
        runs = [run.at(run.known) for run in task.runs]
        step = max(1, -(-sum(len(run.time_s) for run in runs) // rows)) if rows else 1
        x0, x1 = scaling([run.inputs for run in runs])
        y0, y1 = scaling([run.targets for run in runs])
        x = np.concatenate([run.inputs[::step] for run in runs])
        y = np.concatenate([run.targets[::step] for run in runs])
        weights = np.concatenate([run.weights[::step] for run in runs])
        return cls(
            (x - x0) / x1,
            (y - y0) / y1,
            weights / weights.sum(),
            (x0, x1, y0, y1),
            [len(run.time_s[::step]) for run in runs],
        )


class BackPropagation(FittedModel):
    """A trained network.

    Parameters
    ----------
    shape : Shape
        Nodes per layer.
    training : Training
        The trained weights and the course of training.
    scales : tuple of arrays
        Of `Samples`.
    diagnostics : dict
        For the report.
    """

    title = "BP neural network"
    variants: ClassVar[Mapping[str, tuple[str, Mapping[str, Any]]]] = {
        "bp_5_5": ("BP neural network, two hidden layers of 5", {"hidden": (5, 5)})
    }

    def __init__(
        self,
        shape: Shape,
        training: Training,
        scales: tuple[Array, Array, Array, Array],
        diagnostics: dict[str, Any],
    ) -> None:
        self.shape, self.training, self._scales = shape, training, scales
        self._diagnostics = diagnostics

    @classmethod
    def fit(
        cls,
        task: Task,
        *,
        hidden: Sequence[int] | int = HIDDEN,
        iterations: int = TRAINING_ITERATIONS,
        goal: float = GOAL,
        decay: float = DECAY,
        rows: int = MOST_TRAINING_ROWS,
        seed: int = 0,
    ) -> BackPropagation:
        """Return the network trained on the task's runs.

        Parameters
        ----------
        task : Task
            Runs and names.
        hidden : sequence of int, or int
            Nodes of each hidden layer, or of the only one: 10 is the study's 4-10-3, (5, 5) its
            5-5-5-3.
        iterations : int
            Maximum number of iterations.
        goal : float
            Mean squared error, at unit half range, that counts as converged [1].
        decay : float
            Weight decay, which the studies do not have; 0 trains as they did [1].
        rows : int
            Approximate number of rows to thin to; 0 trains on all.
        seed : int
            Seed of the random start.

        Raises
        ------
        BadInput
            For a value that is not allowed, too few rows, or constant columns.
        """
        layers = hidden_layers("bp", hidden)
        samples = Samples.of(task, rows_wanted("bp", rows))
        shape = Shape((samples.x.shape[1], *layers, samples.y.shape[1]))
        start = nguyen_widrow(shape, np.random.default_rng(seed))
        training = levenberg_marquardt(
            shape,
            start,
            samples.x,
            samples.y,
            samples.weights,
            iterations=whole("bp", "iterations", iterations, 1, 100_000),
            goal=within("bp", "goal", goal, 0.0, 1.0),
            decay=within("bp", "decay", decay, 0.0, 1e3),
        )
        return cls(shape, training, samples.scales, {})

    def table(self) -> dict[str, Any]:
        """Return the numbers for the compensator file."""
        names = ("input_middle", "input_half", "output_middle", "output_half")
        layers = [
            {"weights": weights.tolist(), "biases": thresholds.tolist()}
            for weights, thresholds in self.shape.layers(self.training.theta)
        ]
        scales = dict(zip(names, (values.tolist() for values in self._scales), strict=True))
        return {**scales, "layers": layers}

    def report(self) -> dict[str, Any]:
        """Return the network's size and its convergence."""
        return {
            "nodes": list(self.shape.nodes),
            "weights_and_thresholds": self.shape.size,
            "iterations": len(self.training.curve) - 1,
            "goal_reached_at": self.training.reached,
            "curve": [float(f"{value:.4g}") for value in self.training.curve],
            **self._diagnostics,
        }


def rows_wanted(kind: str, rows: int) -> int:
    """Return the number of rows to thin to; 0 for all.

    Raises
    ------
    BadInput
        If it is neither 0 nor enough to train on.
    """
    if rows == 0 and not isinstance(rows, bool):
        return 0
    return whole(kind, "rows", rows, FEWEST_ROWS, 1_000_000)


def hidden_layers(kind: str, hidden: Sequence[int] | int) -> tuple[int, ...]:
    """Return the number of nodes of each hidden layer; a single number is one layer.

    Raises
    ------
    BadInput
        If there is no layer, or one has no or very many nodes.
    """
    layers = tuple(hidden) if isinstance(hidden, list | tuple) else (hidden,)
    if not 1 <= len(layers) <= 3:
        raise BadInput(kind, "hidden", f"{len(layers)} hidden layers are not allowed: 1 to 3")
    return tuple(whole(kind, "hidden", nodes, 1, 50) for nodes in layers)
