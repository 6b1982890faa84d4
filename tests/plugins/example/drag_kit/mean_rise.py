"""Drift in proportion to the mean of the inputs, as an FMU predicts it: standard library only."""

from __future__ import annotations

from collections.abc import Sequence

from fmu_compensator.runtime.error_models.base import ErrorModel
from fmu_compensator.runtime.fields import Fields

LARGEST = 1e6


class MeanRise(ErrorModel):
    """y = b mean(x), one b per target [um/K, urad/K]."""

    def __init__(self, slopes: list[float]) -> None:
        self._slopes = slopes

    @classmethod
    def from_fields(cls, fields: Fields, inputs: int, targets: int) -> MeanRise:
        """Return the model that the file's numbers describe."""
        return cls(fields.numbers("slopes", targets, LARGEST))

    def predict(
        self,
        inputs: Sequence[float],
        elapsed_s: float = 0.0,
        speed: float = 0.0,
        measured: Sequence[float] | None = None,
    ) -> list[float]:
        """Return the predicted targets."""
        mean = sum(inputs) / len(inputs)
        return [slope * mean for slope in self._slopes]
