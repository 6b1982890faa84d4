"""ARX: predicts the drift from its own past and the temperatures."""

from __future__ import annotations

from collections.abc import Sequence

from fmu_compensator.runtime.error_models.base import ErrorModel
from fmu_compensator.runtime.fields import Fields
from fmu_compensator.runtime.ticks import ticks


class AutoregressiveExogenous(ErrorModel):
    r"""One pole per target: y(k) = a y(k-1) + sum_l B_l u(k-l) + c, on an even clock.

    Without measurements it continues from its own prediction; a measurement replaces that.

    Parameters
    ----------
    step_s : float
        Length of a step [s].
    pole : list of float
        a, from 0 to below 1 [1].
    now, before : list of list of float, targets x inputs
        B_0 and B_1 [um/K, urad/K].
    constant : list of float
        c [um, urad].
    """

    uses_measured = True
    remembers = ("_started", "_age", "_last", "_drift")

    def __init__(
        self,
        step_s: float,
        pole: list[float],
        now: list[list[float]],
        before: list[list[float]],
        constant: list[float],
    ) -> None:
        self._step_s = step_s
        self._rows = list(zip(pole, now, before, constant, strict=True))
        self._inputs = len(now[0])
        self._started = False
        self._age = 0.0  # of the step [s]
        self._last = [0.0] * self._inputs
        self._drift = [0.0] * len(pole)

    @classmethod
    def from_fields(cls, fields: Fields, inputs: int, targets: int) -> AutoregressiveExogenous:
        """Return the model that the file's numbers describe."""
        pole = fields.numbers("pole", targets, 1.0)
        for index, value in enumerate(pole):
            if not 0.0 <= value < 1.0:
                problem = f"{value:g} is not allowed: from 0 to below 1"
                raise fields.refusal(f"pole.{index}", problem)
        return cls(
            fields.number("step_s", 0.1, 1e5),
            pole,
            fields.matrix("now", targets, inputs),
            fields.matrix("before", targets, inputs),
            fields.numbers("constant", targets),
        )

    def predict(
        self,
        inputs: Sequence[float],
        elapsed_s: float = 0.0,
        speed: float = 0.0,
        measured: Sequence[float] | None = None,
    ) -> list[float]:
        """Return the predicted targets."""
        if not self._started:
            self._started, self._last = True, list(inputs)
        if measured is not None:
            self._drift = list(measured)
        count, self._age = ticks(self._age + elapsed_s, self._step_s)
        for _ in range(count):
            for target, (pole, now, before, constant) in enumerate(self._rows):
                value = pole * self._drift[target] + constant
                for b0, b1, u, last in zip(now, before, inputs, self._last, strict=True):
                    value += b0 * u + b1 * last
                self._drift[target] = value
            self._last = list(inputs)
        return list(self._drift)
