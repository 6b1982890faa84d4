"""ARX with the chosen temperatures as inputs, fitted for running without measurements."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fmu_compensator.fit.error_models.base import FittedModel, Task
from fmu_compensator.fit.error_models.options import (
    FEWEST_ROWS,
    refuse_poor,
    within,
)
from fmu_compensator.fit.training import Array
from fmu_compensator.runtime.ticks import ticks
from measurement.errors import BadInput, refuse_other, shown
from studies.fit.by_run import (
    FEWEST_TO_LEAVE_OUT,
    RIDGE,
    Block,
    NormalEquations,
    Solution,
)

MEMORIES_S = (0.0, 600.0, 1800.0, 3600.0, 7200.0, 14_400.0)
"""Candidate time constants of the pole [s]; 0 is a map without memory. Set on no data."""
THIN_TO = 120
"""Rows per run for choosing the pole: neighbouring rows of a slow drift are redundant. Set on no
data."""
SHORTEST_STEP_S = 10.0
"""A judgement, set on no data: drift over hours hardly changes in less [s]."""
ESTIMATORS = ("simulation", "prediction", "armax")
LAGS = (0, 1, "choose")
MOST_MOVING, ARMAX_ROUNDS = 2, 10
"""Highest moving-average order tried, and rounds for the residuals to settle. Set on no data."""


class AutoregressiveExogenous(FittedModel):
    """See its twin in the runtime for the equation.

    Parameters
    ----------
    step_s : float
        Length of a step [s].
    pole : array (m,)
        Weight of the drift at the previous step [1].
    now, before : array (m, k)
        Weights of the inputs at this step and the previous one [um/K, urad/K].
    constant : array (m,)
        Constant part of each step [um, urad].
    diagnostics : dict
        For the report.
    """

    title = "ARX with temperatures"
    history = True
    uses_measured = True

    def __init__(
        self,
        step_s: float,
        pole: Array,
        now: Array,
        before: Array,
        constant: Array,
        diagnostics: dict[str, Any] | None = None,
    ) -> None:
        self.step_s, self.pole = step_s, pole
        self.now, self.before, self.constant = now, before, constant
        self._diagnostics = diagnostics or {}

    @classmethod
    def fit(
        cls,
        task: Task,
        *,
        step_s: float | None = None,
        estimator: str = "simulation",
        lags: int | str = 1,
    ) -> AutoregressiveExogenous:
        """Return the model fitted to the task's runs.

        Parameters
        ----------
        task : Task
            Runs and names.
        step_s : float, optional
            Length of a step; by default the usual sampling interval [s].
        estimator : {"simulation", "prediction", "armax"}
            ``prediction`` is the usual least squares on the measured past. It optimises the next
            step, but not runs without measurements, in which its errors accumulate.
            ``simulation`` optimises the free-running drift: for each pole on a grid the problem is
            linear, and the pole that predicts left-out runs best is chosen. ``armax`` is
            ``prediction`` with a moving average of the residuals, which removes the effect of
            sensor noise on the pole; its order, 0 to 2, has the smallest AIC. Without measurements
            past residuals are unknown with zero mean, so that at run time it is an ARX.
        lags : {0, 1, "choose"}
            Number of previous steps of the inputs to use; ``choose`` takes, for each target, the
            number that predicts left-out runs best (with fewer than three runs, by AIC).
            ``simulation`` also tries a pole of 0, that is, not to use the previous drift.

        Raises
        ------
        BadInput
            For a value that is not allowed, too few rows, or constant columns.
        """
        refuse_other("arx", "estimator", estimator, ESTIMATORS)
        if lags not in LAGS or isinstance(lags, bool):
            allowed = ", ".join(map(str, LAGS))
            raise BadInput("arx", "lags", f"{shown(lags)} is not allowed: {allowed}")
        refuse_poor(task)
        step = usual_step(task) if step_s is None else within("arx", "step_s", step_s, 0.1, 1e5)
        fit = _by_simulation if estimator == "simulation" else _by_prediction
        constant = task.input_form != "rise"
        moving = MOST_MOVING if estimator == "armax" else 0
        tried = LAGS[:2] if lags == "choose" else (int(lags),)
        fits = [
            min(
                (fit(task, step, target, constant, lag, moving) for lag in tried),
                key=lambda fitted: fitted.score,
            )
            for target in range(len(task.target_names))
        ]
        inputs = len(task.input_names)
        b = np.array([fitted.weights for fitted in fits])
        orders = {
            name: [int(fitted.pole > 0.0), fitted.lags, fitted.moving]
            for name, fitted in zip(task.target_names, fits, strict=True)
        }
        return cls(
            step,
            np.array([fitted.pole for fitted in fits]),
            b[:, :inputs],
            b[:, inputs : 2 * inputs],
            b[:, 2 * inputs],
            {"orders": orders},
        )

    def table(self) -> dict[str, Any]:
        """Return the numbers for the compensator file."""
        arrays = ("pole", "now", "before", "constant")
        return {"step_s": self.step_s, **{name: getattr(self, name).tolist() for name in arrays}}

    def report(self) -> dict[str, Any]:
        """Return the poles, their time constants, and the orders.

        An order is the number of previous steps of drift, inputs or residuals in use.
        """
        memory = [-self.step_s / float(np.log(p)) if p > 0.0 else 0.0 for p in self.pole]
        return {"step_s": self.step_s, "pole": self.pole.tolist(), "memory_s": memory} | (
            self._diagnostics
        )


def usual_step(task: Task) -> float:
    """Return the usual sampling interval of the runs, at least 10 s [s]."""
    steps = [float(np.median(np.diff(run.time_s))) for run in task.runs if len(run.time_s) > 1]
    return max(float(np.median(steps)), SHORTEST_STEP_S)


def step_counts(time_s: Array, step_s: float) -> NDArray[np.intp]:
    """Return how many steps of the even clock end at each row."""
    counts, age = np.zeros(len(time_s), dtype=np.intp), 0.0
    for row, elapsed in enumerate(np.diff(time_s, prepend=time_s[0])):
        counts[row], age = ticks(age + float(elapsed), step_s)
    return counts


def _row_before(counts: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return the row at which the step before each row ended: not the row before if they are closer
    than a step.
    """
    ended = np.maximum.accumulate(np.where(counts > 0, np.arange(len(counts)), 0))
    return np.concatenate([[0], ended[:-1]])


@dataclass(frozen=True)
class _Fit:
    """One target's pole, weights of the regressors and orders; a smaller score is better."""

    score: float
    pole: float
    weights: Array
    lags: int
    moving: int = 0


def _regressors(inputs: Array, before: Array, constant: bool, lags: int) -> Array:
    """Return the inputs at each row and one step earlier, and the constant, shape (n, 2 k + 1)."""
    ones = np.full((len(inputs), 1), float(constant))
    return np.column_stack([inputs, before * lags, ones])


def _by_simulation(
    task: Task, step_s: float, target: int, constant: bool, lags: int, moving: int
) -> _Fit:
    best: tuple[float, float, Array] | None = None
    numbers = (lags + 1) * len(task.input_names) + 1
    for memory in MEMORIES_S:
        pole = float(np.exp(-step_s / memory)) if memory else 0.0
        blocks = []
        for run in task.runs:
            counts, u = step_counts(run.time_s, step_s), run.inputs
            first = _regressors(u, u[_row_before(counts)], constant, lags)
            x = _driven(first, _regressors(u, u, constant, lags), counts, pole)
            rows = np.flatnonzero(run.known)
            rows = rows[:: max(1, len(rows) // THIN_TO)]
            if len(rows):
                hours = (run.time_s[rows] - run.time_s[0]) / 3600.0
                blocks.append(Block(hours, x[rows], run.targets[rows][:, [target]]))
        solution = NormalEquations(blocks, 0.0).solve(0, RIDGE, robust=False)
        score = (
            solution.score
            if len(blocks) >= FEWEST_TO_LEAVE_OUT
            else _aic(blocks, solution, numbers)
        )
        if best is None or score < best[0]:
            best = score, pole, solution.coefficients
    assert best is not None
    return _Fit(*best, lags)


def _aic(blocks: list[Block], solution: Solution, numbers: int) -> float:
    """Return Akaike's criterion of a fit."""
    left = [block.targets[:, 0] - block.features @ solution.coefficients for block in blocks]
    mean = float(np.mean([np.mean(errors**2) for errors in left]))
    return sum(map(len, left)) * float(np.log(max(mean, 1e-30))) + 2.0 * numbers


def _driven(first: Array, later: Array, counts: NDArray[np.intp], pole: float) -> Array:
    """Return the response of the drift at each row to a unit weight of each regressor.

    If several steps end at a row, *first* holds the regressors of the first one.
    """
    value, values = np.zeros(first.shape[1]), np.zeros_like(first)
    for k, count in enumerate(counts.tolist()):
        for step in range(count):
            value = pole * value + (later if step else first)[k]
        values[k] = value
    return values


def _by_prediction(
    task: Task, step_s: float, target: int, constant: bool, lags: int, moving: int
) -> _Fit:
    """Return the fit of the next step with up to *moving* past residuals, chosen by AIC."""
    parts = []
    for run in task.runs:
        counts, y = step_counts(run.time_s, step_s), run.targets[:, target]
        before = _row_before(counts)
        there = (counts == 1) & run.known & run.known[before]
        x = _regressors(run.inputs, run.inputs[before], constant, lags)
        columns = np.column_stack([x, y[before]])
        x, y = np.where(there[:, None], columns, 0.0), np.where(there, y, 0.0)
        parts.append((x, y, there, before))
    rows = sum(int(there.sum()) for _, _, there, _ in parts)
    if rows < FEWEST_ROWS:
        raise BadInput("training runs", "", f"{rows} rows one step apart are too few")
    tried = [_moving_average(parts, order, lags) for order in range(moving + 1)]
    return min(tried, key=lambda fitted: fitted.score)


def _moving_average(
    parts: list[tuple[Array, Array, NDArray[np.bool_], NDArray[np.intp]]], order: int, lags: int
) -> _Fit:
    """Return the next step's fit with *order* past residuals: extended least squares.

    The residuals of a round are regressors of the next one.
    """
    residuals = [np.zeros(len(y)) for _, y, _, _ in parts]
    b, inputs = np.zeros(0), parts[0][0].shape[1]
    for _ in range(ARMAX_ROUNDS if order else 1):
        wide = []
        for (x, _, _, before), left in zip(parts, residuals, strict=True):
            past = [left]
            for _ in range(order):
                past.append(past[-1][before])
            wide.append(np.column_stack([x, *past[1:]]))
        chosen = [there for _, _, there, _ in parts]
        x = np.concatenate([w[rows] for w, rows in zip(wide, chosen, strict=True)])
        y = np.concatenate([part[1][part[2]] for part in parts])
        scale = np.sqrt(np.mean(x**2, axis=0))
        scale[scale == 0.0] = 1.0
        gram = (x / scale).T @ (x / scale) / len(x)
        b = np.linalg.solve(gram + 1e-9 * np.eye(len(gram)), (x / scale).T @ y / len(x)) / scale
        residuals = [
            np.where(there, y_of_run - w @ b, 0.0)
            for (_, y_of_run, there, _), w in zip(parts, wide, strict=True)
        ]
    left_over = float(np.mean((y - x @ b) ** 2))
    numbers = int(np.count_nonzero(x.any(axis=0)))
    aic = len(y) * float(np.log(max(left_over, 1e-30))) + 2.0 * numbers
    return _Fit(aic, float(np.clip(b[inputs - 1], 0.0, 0.9999)), b[: inputs - 1], lags, order)
