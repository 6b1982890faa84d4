"""Back-propagation network: tansig hidden layers, linear output layer."""

from __future__ import annotations

from collections.abc import Sequence
from math import tanh

from fmu_compensator.runtime.error_models.base import ErrorModel
from fmu_compensator.runtime.fields import Fields
from fmu_compensator.runtime.sums import summed

Layer = tuple[list[list[float]], list[float]]


class NeuralNetwork:
    """A network with scaled inputs and outputs.

    Parameters
    ----------
    input_middle, input_half : list of float
        An input x is scaled to (x - middle) / half [1].
    layers : list of (weights, biases)
        Weights: one row per node, one column per node of the previous layer.
    output_middle, output_half : list of float
        An output y of the last layer is scaled to middle + half * y.
    """

    def __init__(
        self,
        input_middle: list[float],
        input_half: list[float],
        layers: list[Layer],
        output_middle: list[float],
        output_half: list[float],
    ) -> None:
        self._input = list(zip(input_middle, input_half, strict=True))
        self._layers = [list(zip(weights, biases, strict=True)) for weights, biases in layers]
        self._output = list(zip(output_middle, output_half, strict=True))

    @classmethod
    def from_fields(cls, fields: Fields, inputs: int, outputs: int) -> NeuralNetwork:
        """Return the network that the file's numbers describe.

        Parameters
        ----------
        fields : Fields
            The table of the network.
        inputs, outputs : int
            Required number of inputs of the first layer and outputs of the last.

        Raises
        ------
        ModelFileError
            For a number that is missing or out of range, and for a layer of the wrong width.
        """
        layers: list[Layer] = []
        width = inputs
        tables = fields.tables("layers", "layers", 1)
        for number, table in enumerate(tables, 1):
            nodes = len(table.items("biases", "numbers", 1))
            if number == len(tables) and nodes != outputs:
                raise table.refusal("biases", f"{nodes} are not allowed: must be {outputs}")
            weights = table.matrix("weights", nodes, width)
            layers.append((weights, table.numbers("biases", nodes)))
            table.done()
            width = nodes
        return cls(
            fields.numbers("input_middle", inputs),
            _halves(fields, "input_half", inputs),
            layers,
            fields.numbers("output_middle", outputs),
            _halves(fields, "output_half", outputs),
        )

    def outputs(self, inputs: Sequence[float]) -> list[float]:
        """Return the network's outputs.

        Parameters
        ----------
        inputs : sequence of float
            In the units that the network was trained in.
        """
        values = [
            (x - middle) / half for x, (middle, half) in zip(inputs, self._input, strict=True)
        ]
        last = len(self._layers) - 1
        for number, layer in enumerate(self._layers):
            sums = [
                bias + summed(weight * value for weight, value in zip(weights, values, strict=True))
                for weights, bias in layer
            ]
            values = sums if number == last else [tanh(total) for total in sums]
        return [
            middle + half * value
            for value, (middle, half) in zip(values, self._output, strict=True)
        ]


class BackPropagation(ErrorModel):
    """Feed-forward network from the chosen temperatures to all targets.

    Parameters
    ----------
    network : NeuralNetwork
        See there for the numbers in the file.
    """

    other_fits = ("ga_bp",)

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
        """Return the predicted targets; time, speed and measurements are not used."""
        return self._network.outputs(inputs)


def _halves(fields: Fields, key: str, count: int) -> list[float]:
    values = fields.numbers(key, count)
    for index, value in enumerate(values):
        if value < 1e-9:
            raise fields.refusal(f"{key}.{index}", f"{value:g} is not allowed: above 1e-9")
    return values
