"""Ridge regression on rises of temperature and their first-order lags."""

from __future__ import annotations

from collections.abc import Sequence

from fmu_compensator.fit.error_models.base import Task
from studies.fit.thermal_states import ThermalStates


class Ridge(ThermalStates):
    """Thermal states without levels, speed, noise model, distrust of runs, or averaging."""

    title = "Ridge on lagged temperatures"
    usual_form = "rise"

    @classmethod
    def fit(  # type: ignore[override]  # fewer options
        cls,
        task: Task,
        *,
        lags_s: Sequence[float] | None = None,
        penalty: float | None = None,
    ) -> Ridge:
        """Return the regression fitted to the task's runs.

        Parameters
        ----------
        task : Task
            Runs and names.
        lags_s : sequence of float, optional
            Time constants [s]. Options not given are chosen by leaving out the training runs one
            by one, separately for each target.
        penalty : float, optional
            Weight of the squared coefficients at unit size of the inputs [1].

        Raises
        ------
        BadInput
            For a value that is not allowed, too few rows, or constant columns.
        """
        fitted = super().fit(
            task,
            lags_s=lags_s,
            penalty=penalty,
            walk=0.0,
            levels=False,
            referenced=False,
            robust=False,
            speed=False,
            average=False,
        )
        assert isinstance(fitted, cls)
        return fitted
