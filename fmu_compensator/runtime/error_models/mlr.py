"""Multiple linear regression."""

from __future__ import annotations

from collections.abc import Sequence

from fmu_compensator.runtime.error_models.base import ErrorModel
from fmu_compensator.runtime.fields import Fields
from fmu_compensator.runtime.sums import written_out


class MultipleLinearRegression(ErrorModel):
    r"""Each target is a constant plus a weighted sum of the inputs: y = b0 + sum(b_i x_i).

    Parameters
    ----------
    intercept : list of float, one per target [um, urad]
    coefficients : list of list of float, one row per target, one column per input [um/K, urad/K]
    """

    linear = True

    def __init__(self, intercept: list[float], coefficients: list[list[float]]) -> None:
        self._predicted = written_out(intercept, coefficients)

    @classmethod
    def from_fields(cls, fields: Fields, inputs: int, targets: int) -> MultipleLinearRegression:
        """Return the model that the file's numbers describe."""
        return cls(
            fields.numbers("intercept", targets),
            fields.matrix("coefficients", targets, inputs),
        )

    def predict(
        self,
        inputs: Sequence[float],
        elapsed_s: float = 0.0,
        speed: float = 0.0,
        measured: Sequence[float] | None = None,
    ) -> list[float]:
        """Return the predicted targets; time, speed and measurements are not used."""
        return self._predicted(inputs)
