"""Ridge regression on temperatures and their first-order lags, which can follow hysteresis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from fmu_compensator.fit.error_models.base import FittedModel, Task
from fmu_compensator.fit.error_models.options import refuse_poor, within
from fmu_compensator.fit.training import Array
from measurement.errors import BadInput
from studies.fit.by_run import FEWEST_TO_LEAVE_OUT, NormalEquations, Solution
from studies.fit.lagged import blocks_of, learnt_from, start_range

LAG_SETS_S = ((2400.0,), (600.0, 2400.0), (600.0, 2400.0, 9600.0))
"""Each set contains the previous one, so the average of all needs no more lags than the last [s].
Set on no data."""
PENALTIES = (1e-5, 1e-4, 1e-3, 1e-2, 1e-1)
WALKS = (0.0, 0.5, 2.0)
"""Candidates that are averaged according to left-out runs: penalties, and random walk over noise
after an hour [1]: set on no data."""
REFERENCED = (False, True)
WORTH = 0.1
"""A candidate whose error on left-out runs is 10 % larger has 1/e of the weight in the average [1]:
set on no data."""
FEWEST_SHARE = 0.01
"""A candidate with less than this share of the best one's weight is left out of the average [1]:
set on no data."""
_Choices = tuple[
    tuple[tuple[float, ...], ...],
    tuple[bool, ...],
    tuple[float, ...],
    tuple[bool, ...],
    tuple[float, ...],
]


@dataclass(frozen=True)
class LagChoice:
    """One choice for one target, and its solution."""

    lags_s: tuple[float, ...]
    levels: bool
    walk: float
    referenced: bool
    penalty: float
    solution: Solution


Mix = list[tuple[float, LagChoice]]
"""Candidates and their weights; the average is again a model of the same form."""


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
    diagnostics : dict
        What was chosen, and its errors on left-out runs.
    """

    title = "Ridge on thermal states"
    history = True
    usual_form = "level"
    usual_points = "all"

    def __init__(
        self,
        lags_s: Sequence[float],
        start: tuple[Array, Array, Array],
        coefficients: Array,
        diagnostics: dict[str, Any],
    ) -> None:
        self.lags_s, self.start, self.coefficients = list(lags_s), start, coefficients
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
        referenced: bool | None = None,
        robust: bool = True,
        speed: bool = True,
        average: bool = True,
    ) -> ThermalStates:
        """Return the model fitted to the task's runs.

        Parameters
        ----------
        task : Task
            Runs and names.
        lags_s : sequence of float, optional
            Time constants [s]. Options not given are chosen by leaving out the training runs one
            by one, separately for each target.
        penalty : float, optional
            Weight of the squared coefficients [1].
        walk : float, optional
            Random walk of the residuals over white noise, after an hour [1].
        levels : bool, optional
            Use the lagged levels: the effect of the machine's state at the start on the drift. Not
            used by default in the rise form.
        referenced : bool, optional
            Include the noise of the sample that rises and drift count from.
        robust : bool
            Give less weight to runs that the others do not explain.
        speed : bool
            Use the lagged speed and its square, if every run has the speed.
        average : bool
            Average all candidates, weighted by their errors on left-out runs; else take the best.

        Raises
        ------
        BadInput
            For a value that is not allowed, too few rows, or constant columns.
        """
        kind = cls.kind()
        refuse_poor(task)
        choices: _Choices = (
            LAG_SETS_S if lags_s is None else (checked_lags(kind, lags_s),),
            (True, False) if levels is None and task.input_form != "rise" else (bool(levels),),
            WALKS if walk is None else (within(kind, "walk", walk, 0.0, 100.0),),
            REFERENCED if referenced is None else (bool(referenced),),
            PENALTIES if penalty is None else (checked_penalty(kind, penalty, 1e3),),
        )
        if len(task.runs) < FEWEST_TO_LEAVE_OUT:
            lag_sets, with_levels, walks, noises, penalties = choices
            few = lag_sets[-2:][:1], with_levels[-1:], walks[-2:][:1]
            choices = (*few, noises[-1:], penalties[-3:][:1])
        uses_speed = speed and all(np.isfinite(run.speed).any() for run in task.runs)
        candidates = _solved(task, choices, uses_speed, robust)
        mixed = averaged if average else best
        return cls._assembled(task, [mixed(of_target) for of_target in candidates], uses_speed)

    @classmethod
    def _assembled(cls, task: Task, mixes: list[Mix], uses_speed: bool) -> ThermalStates:
        """Combine the targets' solutions over the union of their lags."""
        lags = sorted({lag for mix in mixes for _, choice in mix for lag in choice.lags_s})
        inputs = len(task.input_names)
        block = 2 * inputs + 2
        coefficients = np.zeros((len(mixes), inputs + len(lags) * block))
        for row, mix in zip(coefficients, mixes, strict=True):
            for share, choice in mix:
                b = share * choice.solution.coefficients
                row[:inputs] += b[:inputs]
                for lag, part in zip(choice.lags_s, b[inputs:].reshape(-1, block), strict=True):
                    at = inputs + lags.index(lag) * block
                    row[at : at + block] += part
        chosen = [max(mix, key=lambda part: part[0])[1] for mix in mixes]
        names = [run.name for run in learnt_from(task)]
        diagnostics = {
            "speed": uses_speed,
            "targets": {
                name: {
                    "lags_s": list(choice.lags_s),
                    "levels": choice.levels,
                    "walk": choice.walk,
                    "referenced": choice.referenced,
                    "averaged": len(mix),
                    "penalty": choice.penalty,
                    "left_out_rms": _listed(choice.solution.left_out_rms),
                    "trust": dict(zip(names, _listed(choice.solution.trust), strict=True)),
                }
                for name, choice, mix in zip(task.target_names, chosen, mixes, strict=True)
            },
        }
        return cls(lags, start_range(task.runs), coefficients, diagnostics)

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
        }

    def report(self) -> dict[str, Any]:
        """Return what was chosen for each target, and its errors on left-out runs."""
        return self._diagnostics


def checked_lags(kind: str, lags_s: Sequence[float]) -> tuple[float, ...]:
    """Return the time constants given by a caller after checking them.

    Raises
    ------
    BadInput
        If there are more than six, or one is not a valid time constant.
    """
    if len(lags_s) > 6:
        raise BadInput(kind, "lags_s", "6 time constants at most")
    return tuple(float(within(kind, "lags_s", value, 1.0, 1e7)) for value in lags_s)


def checked_penalty(kind: str, penalty: float, highest: float) -> float:
    """Return the penalty given by a caller after checking it.

    Raises
    ------
    BadInput
        If it is out of range.
    """
    return float(within(kind, "penalty", penalty, 1e-12, highest))


def _solved(task: Task, choices: _Choices, uses_speed: bool, robust: bool) -> list[list[LagChoice]]:
    """Return every candidate of each target, judged on left-out training runs."""
    lag_sets, with_levels, walks, noises, penalties = choices
    candidates: list[list[LagChoice]] = [[] for _ in task.target_names]
    for lags, levels in product(lag_sets, with_levels):
        blocks = blocks_of(task, lags, uses_speed=uses_speed, uses_levels=levels)
        for walk, noise in product(walks, noises):
            problem = NormalEquations(blocks, walk, referenced=noise)
            for penalty, target in product(penalties, range(len(candidates))):
                solution = problem.solve(target, penalty, robust=robust)
                candidates[target].append(LagChoice(lags, levels, walk, noise, penalty, solution))
    return candidates


def best(candidates: list[LagChoice]) -> Mix:
    """Return only the candidate with the smallest error on left-out runs."""
    if len(candidates) == 1:
        return [(1.0, candidates[0])]
    return [(1.0, min(candidates, key=lambda choice: choice.solution.score))]


def averaged(candidates: list[LagChoice]) -> Mix:
    """Return all candidates that do nearly as well as the best on left-out runs.

    The best of many is partly the luckiest; their average has smaller errors on further runs.
    """
    if len(candidates) == 1:
        return best(candidates)
    scores = np.array([choice.solution.score for choice in candidates])
    shares = np.exp(-(scores - scores.min()) / WORTH)
    shares[shares < FEWEST_SHARE] = 0.0
    shares /= shares.sum()
    return [
        (float(share), choice)
        for share, choice in zip(shares, candidates, strict=True)
        if share > 0.0
    ]


def _listed(values: Array) -> list[float | None]:
    return [round(float(value), 4) if np.isfinite(value) else None for value in values]
