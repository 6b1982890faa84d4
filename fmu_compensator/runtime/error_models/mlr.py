"""Multiple linear regression."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from fmu_compensator.runtime.error_models.base import ErrorModel
from fmu_compensator.runtime.fields import Fields


class MultipleLinearRegression(ErrorModel):
    r"""Each target is a constant and a weighted sum of the inputs: y = b0 + sum(b_i x_i).

    Parameters
    ----------
    intercept : list of float, one per target [um, urad]
    coefficients : list of list of float, one row per target, one column per input [um/K, urad/K]
    """

    linear = True

    def __init__(self, intercept: list[float], coefficients: list[list[float]]) -> None:
        self._predicted = _written_out(intercept, coefficients)

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
        """Return the predicted targets; time, speed and measurements have no part in them."""
        return self._predicted(inputs)


def _written_out(
    intercept: Sequence[float], coefficients: Sequence[Sequence[float]]
) -> Callable[[Sequence[float]], list[float]]:
    """Return the sums as a function without loops: they were half of what a step cost.

    The terms are added in the order of the inputs, as the twin in C does. Numbers are written as
    `repr` does, which reads back as the same number.
    """
    names = [f"x{place}" for place in range(len(coefficients[0]))]
    lines = ["def predicted(inputs):", f"    [{', '.join(names)}] = inputs"]
    for target, (constant, weights) in enumerate(zip(intercept, coefficients, strict=True)):
        lines.append(f"    y{target} = {float(constant)!r}")
        lines += [
            f"    y{target} += {float(weight)!r} * {name}"
            for weight, name in zip(weights, names, strict=True)
        ]
    lines.append(f"    return [{', '.join(f'y{target}' for target in range(len(intercept)))}]")
    made: dict[str, Callable[[Sequence[float]], list[float]]] = {}
    exec("\n".join(lines), made)
    return made["predicted"]
