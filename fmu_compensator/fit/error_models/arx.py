"""ARX with the chosen temperatures as inputs, fitted for running without measurements."""

from __future__ import annotations

from typing import Any

import numpy as np

from fmu_compensator.fit.by_run import Block, Problem, Solution
from fmu_compensator.fit.error_models.base import FittedModel, Task
from fmu_compensator.fit.error_models.options import refuse_poor, refuse_unknown, within
from fmu_compensator.fit.training import Array, TrainingRun
from fmu_compensator.runtime.ticks import ticks
from measurement.errors import BadInput

MEMORIES_S = (0.0, 600.0, 1800.0, 3600.0, 7200.0, 14_400.0)
"""Time constants of the pole to choose from [s]; 0 is a map without memory."""
PENALTY = 1e-5
FEWEST_ROWS = 30
THIN_TO = 120
SHORTEST_STEP_S = 10.0


class AutoregressiveExogenous(FittedModel):
    """See its twin in the runtime for the equation.

    Parameters
    ----------
    step_s : float
        Length of a step [s].
    pole : array (m,)
        Weight of the drift one step before [1].
    now, before : array (m, k)
        Weights of the inputs at this step and the one before [um/K, urad/K].
    constant : array (m,)
        Constant part of each step [um, urad].
    """

    title = "ARX with temperatures"
    history = True
    uses_measured = True

    def __init__(
        self, step_s: float, pole: Array, now: Array, before: Array, constant: Array
    ) -> None:
        self.step_s, self.pole = step_s, pole
        self.now, self.before, self.constant = now, before, constant

    @classmethod
    def fit(
        cls,
        task: Task,
        *,
        step_s: float | None = None,
        estimator: str = "simulation",
        **options: Any,
    ) -> AutoregressiveExogenous:
        """Return the model fitted to the task's runs.

        Parameters
        ----------
        task : Task
            Runs and names.
        step_s : float, optional
            Length of a step; by default the usual sampling interval [s].
        estimator : {"simulation", "prediction"}
            ``prediction`` is the usual least squares on the measured past. It makes the next step
            right, and says nothing of a run without measurements, where its error adds up.
            ``simulation`` makes the free-running drift right: for each pole on a grid the rest is
            linear, and the pole that predicts left-out runs best is taken.

        Raises
        ------
        BadInput
            For an unknown option or value, too few rows, or constant columns.
        """
        refuse_unknown("arx", options, ("step_s", "estimator"))
        if estimator not in ("simulation", "prediction"):
            problem = f"{estimator!r} is not allowed: simulation, prediction"
            raise BadInput("arx", "estimator", problem)
        refuse_poor(task, FEWEST_ROWS)
        step = usual_step(task) if step_s is None else within("arx", "step_s", step_s, 0.1, 1e5)
        fit = _by_simulation if estimator == "simulation" else _by_prediction
        constant = task.input_form != "rise"
        found = [fit(task, step, target, constant) for target in range(len(task.target_names))]
        inputs = len(task.input_names)
        b = np.array([weights for _, weights in found])
        return cls(
            step,
            np.array([pole for pole, _ in found]),
            b[:, :inputs],
            b[:, inputs : 2 * inputs],
            b[:, 2 * inputs],
        )

    def predict(self, run: TrainingRun, measured: Array | None = None) -> Array:
        """Return the targets predicted for a run, shape (n, m) [um, urad]."""
        counts = step_counts(run.time_s, self.step_s)
        drift, last = np.zeros(len(self.pole)), run.inputs[0]
        predicted = np.zeros((len(counts), len(drift)))
        for k, count in enumerate(counts):
            if measured is not None and k and np.isfinite(measured[k - 1]).all():
                drift = measured[k - 1]
            for _ in range(count):
                push = self.now @ run.inputs[k] + self.before @ last + self.constant
                drift, last = self.pole * drift + push, run.inputs[k]
            predicted[k] = drift
        return predicted

    def table(self) -> dict[str, Any]:
        """Return the numbers for the compensator file."""
        arrays = ("pole", "now", "before", "constant")
        return {"step_s": self.step_s, **{name: getattr(self, name).tolist() for name in arrays}}

    def report(self) -> dict[str, Any]:
        """Return the poles and the time constants that they stand for."""
        memory = [-self.step_s / float(np.log(p)) if p > 0.0 else 0.0 for p in self.pole]
        return {"step_s": self.step_s, "pole": self.pole.tolist(), "memory_s": memory}


def usual_step(task: Task) -> float:
    """Return the usual sampling interval of the runs, at least 10 s [s]."""
    steps = [float(np.median(np.diff(run.time_s))) for run in task.runs if len(run.time_s) > 1]
    return max(float(np.median(steps)), SHORTEST_STEP_S)


def step_counts(time_s: Array, step_s: float) -> list[int]:
    """Return how many steps of the even clock end at each row."""
    counts, age = [], 0.0
    for elapsed in np.diff(time_s, prepend=time_s[0]):
        count, age = ticks(age + float(elapsed), step_s)
        counts.append(count)
    return counts


def _regressors(run: TrainingRun, constant: bool) -> Array:
    """Return the inputs now and one row before, and the constant, shape (n, 2 k + 1)."""
    before = np.vstack([run.inputs[:1], run.inputs[:-1]])
    one = np.full((len(run.time_s), 1), float(constant))
    return np.column_stack([run.inputs, before, one])


def _by_simulation(task: Task, step_s: float, target: int, constant: bool) -> tuple[float, Array]:
    best: tuple[float, float, Solution] | None = None
    for memory in MEMORIES_S:
        pole = float(np.exp(-step_s / memory)) if memory else 0.0
        blocks = []
        for run in task.runs:
            x = _driven(_regressors(run, constant), step_counts(run.time_s, step_s), pole)
            rows = np.flatnonzero(run.known)
            rows = rows[:: max(1, len(rows) // THIN_TO)]
            if len(rows):
                hours = (run.time_s[rows] - run.time_s[0]) / 3600.0
                blocks.append(Block(hours, x[rows], run.targets[rows][:, [target]]))
        solution = Problem(blocks, 0.0).solve(0, PENALTY, robust=False)
        score = solution.score if len(blocks) > 2 else _misfit(blocks, solution)
        if best is None or score < best[0]:
            best = score, pole, solution
    assert best is not None
    return best[1], best[2].coefficients


def _misfit(blocks: list[Block], solution: Solution) -> float:
    return float(
        sum(
            np.mean((block.targets[:, 0] - block.features @ solution.coefficients) ** 2)
            for block in blocks
        )
    )


def _driven(x: Array, counts: list[int], pole: float) -> Array:
    """Return what a unit weight of each regressor has made of the drift by each row."""
    value, values = np.zeros(x.shape[1]), np.zeros_like(x)
    for k, (row, count) in enumerate(zip(x, counts, strict=True)):
        for _ in range(count):
            value = pole * value + row
        values[k] = value
    return values


def _by_prediction(task: Task, step_s: float, target: int, constant: bool) -> tuple[float, Array]:
    rows, right = [], []
    for run in task.runs:
        x, y = _regressors(run, constant), run.targets[:, target]
        one = np.array(step_counts(run.time_s, step_s)) == 1
        there = one & run.known & np.concatenate([[False], run.known[:-1]])
        rows.append(np.column_stack([x, np.concatenate([[0.0], y[:-1]])])[there])
        right.append(y[there])
    x, y = np.concatenate(rows), np.concatenate(right)
    if len(x) < FEWEST_ROWS:
        raise BadInput("training runs", "", f"{len(x)} rows one step apart are too few")
    scale = np.sqrt(np.mean(x**2, axis=0))
    scale[scale == 0.0] = 1.0
    gram = (x / scale).T @ (x / scale) / len(x)
    b = np.linalg.solve(gram + 1e-9 * np.eye(len(gram)), (x / scale).T @ y / len(x)) / scale
    return float(np.clip(b[-1], 0.0, 0.9999)), b[:-1]
