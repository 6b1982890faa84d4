"""Back-propagation network."""

from __future__ import annotations

from collections.abc import Sequence

from fmu_compensator.runtime.error_models.base import ErrorModel
from fmu_compensator.runtime.fields import Fields
from fmu_compensator.runtime.neural import NeuralNetwork


class BackPropagation(ErrorModel):
    """Feed-forward network from the chosen temperatures to all targets.

    Parameters
    ----------
    network : NeuralNetwork
        See there for the numbers in the file.
    """

    def __init__(self, network: NeuralNetwork) -> None:
        self._network = network

    @classmethod
    def from_fields(cls, fields: Fields, inputs: int, targets: int) -> BackPropagation:
        """Return the model that the file's numbers describe."""
        return cls(NeuralNetwork.from_fields(fields, inputs, targets))

    def predict(
        self,
        inputs: Sequence[float],
        elapsed_s: float = 0.0,
        speed: float = 0.0,
        measured: Sequence[float] | None = None,
    ) -> list[float]:
        """Return the predicted targets; time, speed and measurements have no part in them."""
        return self._network.outputs(inputs)
