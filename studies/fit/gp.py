"""Sparse Gaussian-process regression in which a run counts as only a few samples."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.spatial.distance import pdist

from fmu_compensator.fit.error_models.base import FittedModel, Task
from fmu_compensator.fit.error_models.options import refuse_poor, whole
from fmu_compensator.fit.training import Array, TrainingRun
from measurement.resampling import SLOW_S
from studies.fit.evidence import posterior
from studies.fit.lagged import lagged, thinned
from studies.fit.thermal_states import LAG_SETS_S


class GaussianProcess(FittedModel):
    r"""A Gaussian process with the kernel :math:`x^T x' + b^2 \exp(-|x - x'|^2 / (2 \ell^2))`.

    See its twin in the runtime for the prediction.

    Parameters
    ----------
    lags_s : sequence of float
        Time constants [s].
    length : float
        l [K].
    constant : array (m,)
    linear : array (m, p)
    centres : array (z, p)
    weights : array (m, z)
    diagnostics : dict
        Choices by the evidence.

    Notes
    -----
    The bumps are centred on some of the training samples, a subset of regressors (Quinonero-Candela
    and Rasmussen (2005), JMLR 6:1939), made independent by scikit-learn's `Nystroem`. The length is
    the samples' median distance, and so is b, or 0 if the evidence is larger without bumps. The
    noise maximises the evidence, with a run counting as four samples.
    """

    title = "Gaussian process on lagged temperatures"
    history = True
    usual_form = "rise"
    usual_points = "all"

    def __init__(
        self,
        lags_s: Sequence[float],
        length: float,
        constant: Array,
        linear: Array,
        centres: Array,
        weights: Array,
        diagnostics: dict[str, Any],
    ) -> None:
        self.lags_s, self.length, self.constant = list(lags_s), length, constant
        self.linear, self.centres, self.weights = linear, centres, weights
        self._diagnostics = diagnostics

    @classmethod
    def fit(cls, task: Task, *, centres: int = 40) -> GaussianProcess:
        """Return the process fitted to the task's runs.

        Parameters
        ----------
        task : Task
            Runs and names.
        centres : int
            Number of bumps, to which the cost of a step at run time is proportional.

        Raises
        ------
        BadInput
            For a value that is not allowed, too few rows, or constant columns.
        """
        wanted = whole("gp", "centres", centres, 1, 500)
        refuse_poor(task)
        from sklearn.kernel_approximation import Nystroem  # only here: it takes a second to load

        lags = LAG_SETS_S[0]
        rows, targets = [], []
        for run in task.runs:
            kept = thinned(run, SLOW_S)
            if len(kept):
                rows.append(_features(run, lags)[kept])
                targets.append(run.targets[kept])
        everything = np.concatenate(rows)
        fixed = task.input_form == "absolute"
        middle = np.mean([y.mean(axis=0) for y in targets], axis=0)
        constant = middle if fixed else np.zeros(targets[0].shape[1])
        shift = everything.mean(axis=0) if fixed else np.zeros(everything.shape[1])
        length = float(np.median(pdist(everything[::7]))) or 1.0
        bumps = Nystroem(
            gamma=0.5 / length**2, n_components=min(wanted, len(everything)), random_state=0
        ).fit(everything)
        solved, size = max(
            (
                (
                    posterior(
                        [np.hstack([x - shift, size * bumps.transform(x)]) for x in rows],
                        [y - constant for y in targets],
                    ),
                    size,
                )
                for size in (0.0, length)
            ),
            key=lambda found: found[0].log_evidence,
        )
        width = everything.shape[1]
        linear = solved.weights[:width].T
        diagnostics = {
            "length": round(length, 4),
            "bump_size": size / length,
            "centres": len(bumps.components_),
            "noise_over_prior": solved.ratio,
        }
        return cls(
            lags,
            length,
            constant - linear @ shift,
            linear,
            bumps.components_,
            size * solved.weights[width:].T @ bumps.normalization_,
            diagnostics,
        )

    def table(self) -> dict[str, Any]:
        """Return the numbers for the compensator file."""
        return {
            "lags_s": self.lags_s,
            "length": self.length,
            "constant": self.constant.tolist(),
            "linear": self.linear.tolist(),
            "centres": self.centres.tolist(),
            "weights": self.weights.tolist(),
        }

    def report(self) -> dict[str, Any]:
        """Return the choices by the evidence."""
        return self._diagnostics


def _features(run: TrainingRun, lags_s: Sequence[float]) -> Array:
    elapsed = np.diff(run.time_s, prepend=run.time_s[0])
    return np.hstack([run.inputs, *(lagged(run.inputs, elapsed, lag) for lag in lags_s)])
