"""LASSO regression on rises of temperature and their first-order lags, selecting few of them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fmu_compensator.fit.error_models.base import Task
from fmu_compensator.fit.error_models.options import refuse_poor
from fmu_compensator.fit.training import Array
from studies.fit.by_run import (
    FEWEST_TO_LEAVE_OUT,
    RIDGE,
    Block,
    NormalEquations,
    Solution,
)
from studies.fit.lagged import blocks_of
from studies.fit.thermal_states import (
    LAG_SETS_S,
    LagChoice,
    ThermalStates,
    best,
    checked_lags,
    checked_penalty,
)

PENALTIES = tuple(float(value) for value in np.logspace(-0.5, -4.5, 17))
"""Candidates as shares of the largest penalty, above which no input remains [1]; with too few runs
to choose by, the middle one is used."""


class Lasso(ThermalStates):
    """The sum of the absolute weights is penalised, so that most of them are zero."""

    title = "LASSO on lagged temperatures"
    usual_form = "rise"

    @classmethod
    def fit(  # type: ignore[override]  # fewer options
        cls,
        task: Task,
        *,
        lags_s: Sequence[float] | None = None,
        penalty: float | None = None,
    ) -> Lasso:
        """Return the regression fitted to the task's runs.

        Parameters
        ----------
        task : Task
            Runs and names.
        lags_s : sequence of float, optional
            Time constants [s]. Options not given are chosen by leaving out the training runs one
            by one, separately for each target.
        penalty : float, optional
            Penalty, as a share of the smallest one that leaves no input [1].

        Raises
        ------
        BadInput
            For a value that is not allowed, too few rows, or constant columns.

        Notes
        -----
        The whole path of penalties comes from the normal equations by least-angle regression
        (scikit-learn), with equal weight for every run.
        """
        refuse_poor(task)
        lag_sets = LAG_SETS_S if lags_s is None else (checked_lags("lasso", lags_s),)
        shares = PENALTIES if penalty is None else (checked_penalty("lasso", penalty, 1.0),)
        if len(task.runs) < FEWEST_TO_LEAVE_OUT:
            lag_sets = lag_sets[-2:][:1]
            shares = shares[len(shares) // 2 :][:1]
        of_targets: list[list[LagChoice]] = [[] for _ in task.target_names]
        for lags in lag_sets:
            blocks = blocks_of(task, lags, uses_speed=False, uses_levels=False)
            for target, candidates in enumerate(of_targets):
                solutions = _path(blocks, target, shares)
                candidates += [
                    LagChoice(lags, False, 0.0, False, share, solution)
                    for share, solution in zip(shares, solutions, strict=True)
                ]
        fitted = cls._assembled(task, [best(candidates) for candidates in of_targets], False)
        assert isinstance(fitted, cls)
        return fitted


def _path(blocks: Sequence[Block], target: int, shares: Sequence[float]) -> list[Solution]:
    """Return the regression at each penalty, with its errors on left-out runs."""
    gram, moment, scale = NormalEquations(blocks, 0.0).normal_equations(target)
    count = len(blocks)
    missed = np.full((len(shares), count), np.nan)
    for out in range(count) if count > 1 else ():
        others = np.arange(count) != out
        weights = _weights(gram[others].mean(axis=0), moment[others].mean(axis=0), shares) / scale
        left = blocks[out].targets[:, [target]] - blocks[out].features @ weights.T
        missed[:, out] = np.sqrt(np.mean(left**2, axis=0))
    weights = _weights(gram.mean(axis=0), moment.mean(axis=0), shares) / scale
    return [Solution(b, np.ones(count), rms) for b, rms in zip(weights, missed, strict=True)]


def _weights(gram: Array, moment: Array, shares: Sequence[float]) -> Array:
    """Return the scaled weights at each penalty, shape (penalties, features)."""
    largest = float(np.abs(moment).max())
    if largest == 0.0:
        return np.zeros((len(shares), len(moment)))
    from sklearn.linear_model import lars_path_gram  # only here: it takes a second to load

    alphas, _, path = lars_path_gram(
        Xy=moment,
        Gram=gram + RIDGE * np.eye(len(gram)),
        n_samples=1,
        method="lasso",
        alpha_min=0.5 * min(shares) * largest,
    )
    # The path is piecewise linear; alphas decrease along it.
    wanted = np.array(shares) * largest
    return np.column_stack([np.interp(wanted, alphas[::-1], row[::-1]) for row in path])
