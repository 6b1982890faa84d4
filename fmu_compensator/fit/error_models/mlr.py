"""Multiple linear regression by weighted least squares, with its diagnostics."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np

from fmu_compensator.fit.correlation import MOST_CANDIDATES
from fmu_compensator.fit.error_models.base import FittedModel, Task
from fmu_compensator.fit.error_models.options import refuse_poor
from fmu_compensator.fit.training import Array, TrainingRun
from measurement.errors import BadInput


class MultipleLinearRegression(FittedModel):
    r"""y = X b + e with b = argmin sum w e^2, one b per target.

    Parameters
    ----------
    intercept : array (m,)
        Constants [um, urad]; zero in the rise form, where no rise means no drift.
    coefficients : array (m, k)
        Weights of the inputs [um/K, urad/K]; zero for inputs that a target's subset leaves out.
    diagnostics : dict
        Condition number and variance inflation of the inputs, R2 and adjusted R2 per target.
    """

    title = "Multiple linear regression"

    def __init__(self, intercept: Array, coefficients: Array, diagnostics: dict[str, Any]) -> None:
        self.intercept, self.coefficients = intercept, coefficients
        self._diagnostics = diagnostics

    @classmethod
    def fit(
        cls,
        task: Task,
        *,
        subset: bool = True,
        intercept: bool | None = None,
    ) -> MultipleLinearRegression:
        """Return the regression fitted to the task's runs.

        Parameters
        ----------
        task : Task
            Runs and names.
        subset : bool
            For each target, choose among all 2^k - 1 subsets of the inputs the one with the
            largest adjusted R2. (Plain R2 never falls when an input is added.) With more than 12
            inputs all are used.
        intercept : bool, optional
            Whether to fit a constant. By default only for absolute temperatures.

        Raises
        ------
        BadInput
            For too few rows, a constant input or target, or collinear inputs.
        """
        refuse_poor(task)
        constant = task.input_form != "rise" if intercept is None else intercept
        inputs = np.concatenate([run.inputs for run in task.runs])
        targets = np.concatenate([run.targets for run in task.runs])
        weights = np.concatenate([run.weights for run in task.runs])
        problem = _Problem(task, inputs, targets, weights / weights.sum(), constant)
        problem.refuse()
        size = targets.shape[1], inputs.shape[1]
        b0, b = np.zeros(size[0]), np.zeros(size)
        per_target = {}
        for number, name in enumerate(task.target_names):
            chosen = problem.best_subset(number) if subset else list(range(size[1]))
            b0[number], b[number, chosen], figures = problem.solve(number, chosen)
            per_target[name] = {"inputs": [task.input_names[i] for i in chosen], **figures}
        diagnostics = {
            "rows": len(inputs),
            "intercept": constant,
            "condition_number": problem.condition_number(),
            "variance_inflation": problem.variance_inflation(),
            "targets": per_target,
        }
        return cls(b0, b, diagnostics)

    def predict(self, run: TrainingRun, measured: Array | None = None) -> Array:
        """Return the targets predicted for a run, shape (n, m) [um, urad]."""
        return np.asarray(self.intercept + run.inputs @ self.coefficients.T)

    def table(self) -> dict[str, Any]:
        """Return the numbers for the compensator file."""
        return {
            "intercept": self.intercept.tolist(),
            "coefficients": self.coefficients.tolist(),
        }

    def report(self) -> dict[str, Any]:
        """Return condition number, variance inflation factors, R2 and adjusted R2."""
        return self._diagnostics


class _Problem:
    """One regression's data: columns scaled to unit size, rows weighted to sum 1."""

    def __init__(
        self, task: Task, inputs: Array, targets: Array, weights: Array, constant: bool
    ) -> None:
        self._task, self._constant = task, constant
        root = np.sqrt(weights)[:, None]
        # Without a constant, columns, R2 and inflation are relative to zero instead of the mean.
        self._centre = weights @ inputs if constant else np.zeros(inputs.shape[1])
        self._target_centre = weights @ targets if constant else np.zeros(targets.shape[1])
        centred = inputs - self._centre
        self._scale = np.sqrt(weights @ centred**2)
        self._x = root * centred / np.where(self._scale > 0, self._scale, 1.0)
        self._y = root * (targets - self._target_centre)
        self._rows = len(inputs)

    def refuse(self) -> None:
        """Raise BadInput if the inputs are collinear."""
        names = self._task.input_names
        _, values, directions = np.linalg.svd(self._x, full_matrices=False)
        # Half of the digits are lost.
        if values[-1] < np.sqrt(np.finfo(float).eps) * values[0]:
            involved = [
                name
                for name, share in zip(names, np.abs(directions[-1]), strict=True)
                if share > 0.05
            ]
            raise BadInput(
                "training runs",
                ", ".join(involved),
                "determine each other (collinear): leave one of them out",
            )

    def solve(self, target: int, chosen: list[int]) -> tuple[float, Array, dict[str, float]]:
        """Return constant, coefficients and figures of one target on some of the inputs."""
        x, y = self._x[:, chosen], self._y[:, target]
        scaled = np.linalg.lstsq(x, y, rcond=None)[0]
        b = scaled / self._scale[chosen]
        b0 = (
            float(self._target_centre[target] - self._centre[chosen] @ b) if self._constant else 0.0
        )
        residual = float(np.sum((y - x @ scaled) ** 2))
        figures = {
            "r2": 1 - residual / float(y @ y),
            "r2_adjusted": self._adjusted(residual, float(y @ y), len(chosen)),
            "rms_residual": residual**0.5,
        }
        return b0, b, figures

    def _adjusted(self, residual: float, total: float, inputs: int) -> float:
        n = self._rows - self._constant
        return 1 - residual / total * n / max(n - inputs, 1)

    def best_subset(self, target: int) -> list[int]:
        """Return the inputs with the largest adjusted R2, from the normal equations."""
        count = self._x.shape[1]
        if count > MOST_CANDIDATES:
            return list(range(count))
        gram, moment = self._x.T @ self._x, self._x.T @ self._y[:, target]
        total = float(self._y[:, target] @ self._y[:, target])
        best: tuple[float, list[int]] = (-np.inf, [])
        for size in range(1, count + 1):
            for subset in combinations(range(count), size):
                chosen = list(subset)
                b = np.linalg.lstsq(gram[np.ix_(chosen, chosen)], moment[chosen], rcond=None)[0]
                residual = max(total - float(b @ moment[chosen]), 0.0)
                adjusted = self._adjusted(residual, total, size)
                if adjusted > best[0]:
                    best = adjusted, chosen
        return best[1]

    def condition_number(self) -> float:
        """Return the ratio of the largest to the smallest singular value of the scaled inputs."""
        values = np.linalg.svd(self._x, compute_uv=False)
        return float(values[0] / values[-1])

    def variance_inflation(self) -> dict[str, float]:
        """Return the variance inflation factor of each input due to correlation with the others."""
        inverse = np.linalg.inv(self._x.T @ self._x)
        # The columns have unit norm, so the diagonal of the inverse is 1 / (1 - R2_j).
        factors = np.diag(inverse)
        return {n: float(f) for n, f in zip(self._task.input_names, factors, strict=True)}
