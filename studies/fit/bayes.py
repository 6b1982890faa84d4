"""Bayesian ridge regression on rises of temperature and their first-order lags."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fmu_compensator.fit.error_models.base import Task
from fmu_compensator.fit.error_models.options import refuse_poor
from studies.fit import thermal_states
from studies.fit.evidence import SAMPLES_PER_RUN, posterior
from studies.fit.lagged import blocks_of, learnt_from, start_range
from studies.fit.thermal_states import ThermalStates, checked_lags

LAG_SETS_S = thermal_states.LAG_SETS_S[::2]
"""Sets of time constants, of which the evidence chooses one [s]."""


class Bayes(ThermalStates):
    """All temperatures with one prior: weights that the runs do not determine stay zero.

    A run counts as four independent samples, whatever its number of rows; lags and the strength of
    the prior maximise the evidence, without leaving runs out.
    """

    title = "Bayesian ridge on lagged temperatures"
    usual_form = "rise"

    @classmethod
    def fit(  # type: ignore[override]  # fewer options
        cls, task: Task, *, lags_s: Sequence[float] | None = None
    ) -> Bayes:
        """Return the regression fitted to the task's runs.

        Parameters
        ----------
        task : Task
            Runs and names.
        lags_s : sequence of float, optional
            Time constants [s]; by default one or three, by evidence.

        Raises
        ------
        BadInput
            For a value that is not allowed, too few rows, or constant columns.
        """
        refuse_poor(task)
        sets = LAG_SETS_S if lags_s is None else (checked_lags("bayes", lags_s),)
        inputs = len(task.input_names)
        solutions = []
        for lags in sets:
            blocks = blocks_of(task, lags, uses_speed=False, uses_levels=False)
            used = _rises(inputs, len(lags))
            solved = posterior(
                [block.features[:, used] for block in blocks], [block.targets for block in blocks]
            )
            solutions.append((lags, used, solved))
        lags, used, solved = max(solutions, key=lambda solution: solution[2].log_evidence)
        coefficients = np.zeros((len(task.target_names), inputs + len(lags) * (2 * inputs + 2)))
        coefficients[:, used] = solved.weights.T
        diagnostics = {
            "lags_s": list(lags),
            "samples_per_run": SAMPLES_PER_RUN,
            "noise_over_prior": solved.ratio,
            "determined": round(float(np.sum(solved.values / (solved.values + solved.ratio))), 2),
            "trust": {
                run.name: round(float(value), 3)
                for run, value in zip(learnt_from(task), solved.trust, strict=True)
            },
        }
        return cls(lags, start_range(task.runs), coefficients, diagnostics)


def _rises(inputs: int, lags: int) -> list[int]:
    """Return the columns of rises and lagged rises among those of `features`."""
    block = 2 * inputs + 2
    return [
        *range(inputs),
        *(inputs + lag * block + place for lag in range(lags) for place in range(inputs)),
    ]
