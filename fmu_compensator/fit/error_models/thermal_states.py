"""Ridge regression on temperatures and their first-order lags: follows hysteresis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from fmu_compensator.fit.by_run import Block, Problem, Solution
from fmu_compensator.fit.error_models.base import FittedModel, Task
from fmu_compensator.fit.error_models.options import refuse_poor, refuse_unknown, within
from fmu_compensator.fit.training import Array, TrainingRun
from measurement.errors import BadInput

SPEED_UNIT = 1000.0
THIN_S = 300.0
"""Rows closer together say the same; they are thinned to this for fitting [s]."""
LAGS_S = ((1800.0,), (900.0, 3600.0), (600.0, 2400.0, 9600.0))
PENALTIES = (1e-5, 1e-4, 1e-3, 1e-2, 1e-1)
WALKS = (0.0, 0.5, 2.0)
_Choices = tuple[
    tuple[tuple[float, ...], ...], tuple[bool, ...], tuple[float, ...], tuple[float, ...]
]
FEWEST_TO_CHOOSE = 3
OPTIONS = ("lags_s", "penalty", "walk", "levels", "robust", "speed")
FEWEST_ROWS = 30
START_MARGIN, SMALLEST_START_MARGIN_K = 0.5, 2.0
"""By how much the range of levels at the start is widened: share of it [1], at least [K]."""
SMALLEST_NOISE = 0.2
"""No displacement sensor is believed to better than this [um, urad]."""


@dataclass(frozen=True)
class _Candidate:
    """One choice for one target, and its solution."""

    lags_s: tuple[float, ...]
    levels: bool
    walk: float
    penalty: float
    solution: Solution


class ThermalStates(FittedModel):
    """See its twin in the runtime for the equation.

    Parameters
    ----------
    lags_s : sequence of float
        Time constants [s].
    start : tuple of array (k,)
        Lowest, usual and highest level at the start [K].
    coefficients : array (m, k + lags * (2 k + 2))
        Weights of rises, then for each lag of lagged rises, levels, and speed and its square.
    walk, noise : array (m,)
        Of the bias that measurements correct [um^2/h], [um^2].
    diagnostics : dict
        What was chosen, and how well it did on runs left out.
    """

    title = "Ridge on thermal states"
    history = True
    uses_measured = True
    usual_form = "level"
    usual_points = "all"

    def __init__(
        self,
        lags_s: Sequence[float],
        start: tuple[Array, Array, Array],
        coefficients: Array,
        walk: Array,
        noise: Array,
        diagnostics: dict[str, Any],
    ) -> None:
        self.lags_s, self.start, self.coefficients = list(lags_s), start, coefficients
        self.walk, self.noise = walk, noise
        self._diagnostics = diagnostics

    @classmethod
    def fit(
        cls,
        task: Task,
        *,
        lags_s: Sequence[float] | None = None,
        penalty: float | None = None,
        walk: float | None = None,
        levels: bool | None = None,
        robust: bool = True,
        speed: bool = True,
        **options: Any,
    ) -> ThermalStates:
        """Return the model fitted to the task's runs.

        Parameters
        ----------
        task : Task
            Runs and names.
        lags_s : sequence of float, optional
            Time constants [s]. What is not given is chosen by leaving out the training runs one
            by one, for each target apart.
        penalty : float, optional
            Weight of the squared coefficients [1].
        walk : float, optional
            Random walk of what the model misses, over white noise, after an hour [1].
        levels : bool, optional
            Use the lagged levels: what the machine's state at the start does to the drift. In the
            rise form there are none by default.
        robust : bool
            Trust runs less that the others do not explain.
        speed : bool
            Use the lagged speed and its square, where every run has the speed.

        Raises
        ------
        BadInput
            For an unknown option or value, too few rows, or constant columns.
        """
        refuse_unknown("thermal_states", options, OPTIONS)
        refuse_poor(task, FEWEST_ROWS)
        for value in lags_s or ():
            within("thermal_states", "lags_s", value, 1.0, 1e7)
        if lags_s is not None and not 1 <= len(lags_s) <= 6:
            raise BadInput("thermal_states", "lags_s", "1 to 6 time constants are needed")
        choices: _Choices = (
            LAGS_S if lags_s is None else (tuple(map(float, lags_s)),),
            (True, False) if levels is None and task.input_form != "rise" else (bool(levels),),
            WALKS if walk is None else (within("thermal_states", "walk", walk, 0.0, 100.0),),
            PENALTIES
            if penalty is None
            else (within("thermal_states", "penalty", penalty, 1e-12, 1e3),),
        )
        if len(task.runs) < FEWEST_TO_CHOOSE:
            lag_sets, with_levels, walks, penalties = choices
            choices = (lag_sets[-2:][:1], with_levels[-1:], walks[-2:][:1], penalties[-3:][:1])
        uses_speed = speed and all(np.isfinite(run.speed).any() for run in task.runs)
        candidates = _solved(task, choices, uses_speed, robust)
        return cls._assembled(task, [_best(found) for found in candidates], uses_speed)

    @classmethod
    def _assembled(cls, task: Task, chosen: list[_Candidate], uses_speed: bool) -> ThermalStates:
        """Put the targets' solutions over the union of their lags."""
        lags = sorted({lag for one in chosen for lag in one.lags_s})
        inputs = len(task.input_names)
        block = 2 * inputs + 2
        coefficients = np.zeros((len(chosen), inputs + len(lags) * block))
        for row, one in zip(coefficients, chosen, strict=True):
            b = one.solution.coefficients
            row[:inputs] = b[:inputs]
            for lag, part in zip(one.lags_s, b[inputs:].reshape(-1, block), strict=True):
                at = inputs + lags.index(lag) * block
                row[at : at + block] = part
        left_out = np.array([np.median(one.solution.left_out_rms) for one in chosen])
        # The error of an unseen run wanders to its usual size within an hour.
        walk = np.where(np.isfinite(left_out), left_out, 1.0) ** 2
        names = [run.name for run in task.runs]
        diagnostics = {
            "speed": uses_speed,
            "targets": {
                name: {
                    "lags_s": list(one.lags_s),
                    "levels": one.levels,
                    "walk": one.walk,
                    "penalty": one.penalty,
                    "left_out_rms": _listed(one.solution.left_out_rms),
                    "trust": dict(zip(names, _listed(one.solution.trust), strict=True)),
                }
                for name, one in zip(task.target_names, chosen, strict=True)
            },
        }
        start = start_range(task.runs)
        noise = _sensor_noise(task.runs, len(chosen))
        return cls(lags, start, coefficients, np.maximum(walk, 1e-6), noise, diagnostics)

    def predict(self, run: TrainingRun, measured: Array | None = None) -> Array:
        """Return the targets predicted for a run, shape (n, m) [um, urad]."""
        regressors = features(run, self.lags_s, uses_speed=True, start=self.start)
        raw = regressors @ self.coefficients.T
        if measured is None:
            return np.asarray(raw)
        return np.asarray(raw + self._biases(run.time_s, measured - raw))

    def _biases(self, time_s: Array, missed: Array) -> Array:
        """Return the bias in force at each row: a Kalman filter of a random walk."""
        hours = np.diff(time_s, prepend=time_s[0]) / 3600.0
        bias, variance = np.zeros(missed.shape[1]), np.zeros(missed.shape[1])
        biases = np.zeros_like(missed)
        for k in range(1, len(missed)):
            if np.isfinite(missed[k - 1]).all():
                gain = variance / (variance + self.noise)
                bias = bias + gain * (missed[k - 1] - bias)
                variance = variance * (1.0 - gain)
            variance = variance + self.walk * hours[k]
            biases[k] = bias
        return biases

    def table(self) -> dict[str, Any]:
        """Return the numbers for the compensator file."""
        lags = len(self.lags_s)
        inputs = (self.coefficients.shape[1] - 2 * lags) // (1 + 2 * lags)
        parts: dict[str, list[Any]] = {"rise_lags": [], "level_lags": [], "speed_lags": []}
        at = inputs
        for _ in range(lags):
            for name, width in (("rise_lags", inputs), ("level_lags", inputs), ("speed_lags", 2)):
                parts[name].append(self.coefficients[:, at : at + width].tolist())
                at += width
        return {
            "lags_s": self.lags_s,
            "start_low": self.start[0].tolist(),
            "start_usual": self.start[1].tolist(),
            "start_high": self.start[2].tolist(),
            "direct": self.coefficients[:, :inputs].tolist(),
            **parts,
            "walk": self.walk.tolist(),
            "noise": self.noise.tolist(),
        }

    def report(self) -> dict[str, Any]:
        """Return what was chosen for each target, and how it did on runs left out."""
        return self._diagnostics


def features(
    run: TrainingRun,
    lags_s: Sequence[float],
    *,
    uses_speed: bool,
    uses_levels: bool = True,
    start: tuple[Array, Array, Array] | None = None,
) -> Array:
    """Return the regressors of every row, shape (n, k + lags * (2 k + 2)).

    *start* is the range of levels at the start, low, usual, high; None takes them as they are.
    """
    rises = run.inputs - run.inputs[0]
    mended = run.inputs
    if start is not None:
        low, usual, high = start
        level = _levels(run.inputs[:1])[0]
        mended = mended + np.where((level < low) | (level > high), usual - level, 0.0)
    speed = np.zeros(len(run.time_s))
    last = 0.0
    for k in range(1, len(speed)):  # of the sample before, the last one known
        last = abs(run.speed[k - 1]) / SPEED_UNIT if np.isfinite(run.speed[k - 1]) else last
        speed[k] = last
    drives = np.column_stack([rises, _levels(mended), speed, speed**2])
    if not uses_speed:
        drives[:, -2:] = 0.0
    if not uses_levels:
        drives[:, rises.shape[1] : -2] = 0.0
    elapsed = np.diff(run.time_s, prepend=run.time_s[0])
    return np.column_stack([rises, *(lagged(drives, elapsed, lag) for lag in lags_s)])


def _levels(inputs: Array) -> Array:
    return np.asarray(inputs - np.median(inputs, axis=1, keepdims=True))


def start_range(runs: Sequence[TrainingRun]) -> tuple[Array, Array, Array]:
    """Return the range of levels at the start over all runs, widened, and their middle [K]."""
    levels = np.concatenate([_levels(run.inputs[:1]) for run in runs])
    low, high = levels.min(axis=0), levels.max(axis=0)
    margin = np.maximum(START_MARGIN * (high - low), SMALLEST_START_MARGIN_K)
    return low - margin, np.median(levels, axis=0), high + margin


def lagged(drives: Array, elapsed_s: Array, tau_s: float) -> Array:
    """Return each column behind a first-order lag that starts at zero, shape of *drives*."""
    shares = -np.expm1(-elapsed_s / tau_s)
    values = np.zeros_like(drives)
    value = np.zeros(drives.shape[1])
    for k, (drive, part) in enumerate(zip(drives, shares, strict=True)):
        value = value + part * (drive - value)
        values[k] = value
    return values


def thinned(run: TrainingRun, step_s: float) -> np.ndarray[Any, np.dtype[np.intp]]:
    """Return the rows with targets, no two closer than *step_s*."""
    kept: list[int] = []
    for row in np.flatnonzero(run.known):
        if not kept or run.time_s[row] - run.time_s[kept[-1]] >= step_s:
            kept.append(int(row))
    return np.array(kept, dtype=np.intp)


def _solved(
    task: Task, choices: _Choices, uses_speed: bool, robust: bool
) -> list[list[_Candidate]]:
    """Return every candidate of each target, judged on training runs left out."""
    lag_sets, with_levels, walks, penalties = choices
    rows = [thinned(run, THIN_S) for run in task.runs]
    used = [(run, row) for run, row in zip(task.runs, rows, strict=True) if len(row) > 1]
    found: list[list[_Candidate]] = [[] for _ in task.target_names]
    for lags, levels in product(lag_sets, with_levels):
        blocks = [
            Block(
                (run.time_s[row] - run.time_s[0]) / 3600.0,
                features(run, lags, uses_speed=uses_speed, uses_levels=levels)[row],
                run.targets[row],
            )
            for run, row in used
        ]
        for walk in walks:
            problem = Problem(blocks, walk)
            for penalty, target in product(penalties, range(len(found))):
                solution = problem.solve(target, penalty, robust=robust)
                found[target].append(_Candidate(lags, levels, walk, penalty, solution))
    return found


def _sensor_noise(runs: Sequence[TrainingRun], targets: int) -> Array:
    """Return the variance of a measured target: half of that from one sample to the next."""
    steps = [np.diff(run.targets[run.known], axis=0) for run in runs if run.known.sum() > 1]
    variance = np.median([np.mean(step**2, axis=0) / 2.0 for step in steps], axis=0)
    return np.asarray(np.maximum(np.broadcast_to(variance, targets), SMALLEST_NOISE**2))


def _best(candidates: list[_Candidate]) -> _Candidate:
    """Return the candidate with the smallest error on runs left out."""
    if len(candidates) == 1:
        return candidates[0]
    return min(candidates, key=lambda one: one.solution.score)


def _listed(values: Array) -> list[float | None]:
    return [round(float(value), 4) if np.isfinite(value) else None for value in values]
