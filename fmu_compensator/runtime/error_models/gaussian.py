"""No mean function: the Gaussian, which every error model has, makes the whole prediction."""

from __future__ import annotations

from collections.abc import Sequence

from fmu_compensator.runtime.error_models.base import ErrorModel
from fmu_compensator.runtime.fields import Fields


class NoMean(ErrorModel):
    """Predicts zeros.

    Parameters
    ----------
    targets : int
        Number of targets.
    """

    linear = True

    def __init__(self, targets: int) -> None:
        self._targets = targets

    @classmethod
    def from_fields(cls, fields: Fields, inputs: int, targets: int) -> NoMean:
        """Return the model; it has no numbers in the file."""
        return cls(targets)

    def predict(
        self,
        inputs: Sequence[float],
        elapsed_s: float = 0.0,
        speed: float = 0.0,
        measured: Sequence[float] | None = None,
    ) -> list[float]:
        """Return zeros."""
        return [0.0] * self._targets
