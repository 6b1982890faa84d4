"""What a measurement now and then says of the error: a bias that is believed less and less."""

from __future__ import annotations

from collections.abc import Sequence
from math import exp, sqrt

from fmu_compensator.runtime.fields import Fields
from fmu_compensator.runtime.lags import checked_state

FURTHEST = 4.0
"""A measurement that is off by more standard deviations must be confirmed by the next one [1]."""


class Correction:
    r"""The error of a prediction as an Ornstein-Uhlenbeck process, filtered (Kalman).

    .. math::
        b \leftarrow b e^{-t/\tau}, \quad u \leftarrow 1 - (1 - u) e^{-2t/\tau}; \qquad
        g = \frac{u v}{u v + R}, \quad b \leftarrow b + g\,e, \quad u \leftarrow (1 - g) u

    b is the bias, v the error's variance before any measurement, u the share of it that is left,
    R the variance of a measurement, and e what the corrected prediction missed. A measurement
    further off than `FURTHEST` standard deviations changes nothing until the next one agrees with
    it to that many: a chip under the probe does no harm, and an error that is real is taken in
    with the second probe that shows it.

    Parameters
    ----------
    memory_s : float
        tau: how long the error stays alike [s].
    spread : list of float, one per target
        Standard deviation of the error at growth 1 [um, urad].
    noise : list of float, one per target
        R [um^2, urad^2].
    fast : float
        Share of the error's variance that comes and goes too fast for a measurement to help [1]:
        the doubt never falls below it.
    """

    def __init__(
        self, memory_s: float, spread: list[float], noise: list[float], fast: float = 0.0
    ) -> None:
        self._memory_s, self._spread, self._noise, self._fast = memory_s, spread, noise, fast
        self.reset()

    @classmethod
    def from_fields(cls, fields: Fields, targets: int) -> Correction:
        """Return the correction of a file's table.

        Raises
        ------
        ModelFileError
            For the first field that is missing or out of range.
        """
        memory_s = fields.number("memory_s", 1.0, 1e9)
        spread, noise = (fields.numbers(key, targets, 1e9) for key in ("spread", "noise"))
        for key, values in (("spread", spread), ("noise", noise)):
            for index, value in enumerate(values):
                if value <= 0.0:
                    raise fields.refusal(f"{key}.{index}", f"{value:g} is not allowed: above 0")
        fast = fields.number("fast", 0.0, 1.0) if fields.has("fast") else 0.0
        fields.done()
        return cls(memory_s, spread, noise, fast)

    def take(
        self, missed: Sequence[float], growth: float, predicted: Sequence[float] | None = None
    ) -> None:
        """Move the bias towards a measurement.

        Parameters
        ----------
        missed : sequence of float
            Measured minus predicted, the bias in force included [um, urad].
        growth : float
            Standard deviation of the error, over its spread [1].
        predicted : sequence of float, optional
            What it was measured against [um, urad]; zeros without it.
        """
        for target, value in enumerate(missed):
            variance = (self._spread[target] * growth) ** 2
            left = self._doubt[target] * variance
            gain = left / (left + self._noise[target])
            furthest = FURTHEST * sqrt(left + self._noise[target])
            whole = self.bias[target] + value
            confirmed = (
                self._suspected[target] > 0.0 and abs(whole - self._suspect[target]) <= furthest
            )
            if abs(value) <= furthest or confirmed:
                self.bias[target] += gain * value
                self._doubt[target] *= 1.0 - gain
                self._suspect[target], self._suspected[target] = 0.0, 0.0
                base = 0.0 if predicted is None else predicted[target]
                self.held[target] = base + gain * value
            else:
                self._suspect[target], self._suspected[target] = whole, 1.0

    def wait(self, elapsed_s: float) -> None:
        """Let time pass: the bias fades and the doubt grows."""
        if max(self._doubt) >= 1.0:
            return
        kept = exp(-elapsed_s / self._memory_s)
        for target, doubt in enumerate(self._doubt):
            self.bias[target] *= kept
            self._doubt[target] = 1.0 - (1.0 - doubt) * kept * kept

    @property
    def doubt(self) -> float:
        """Share of the error's variance that is left since the last measurement, 0 to 1."""
        return self._fast + (1.0 - self._fast) * max(self._doubt)

    def reset(self) -> None:
        """Forget all measurements."""
        self.bias = [0.0] * len(self._spread)
        self._doubt = [1.0] * len(self._spread)
        # What the last measurement said the target was: zero before the first.
        self.held = [0.0] * len(self._spread)
        # What the last measurement says the whole error is, where it waits to be confirmed.
        self._suspect = [0.0] * len(self._spread)
        self._suspected = [0.0] * len(self._spread)

    def state(self) -> list[float]:
        """Return what is remembered."""
        return [*self.bias, *self._doubt, *self._suspect, *self._suspected, *self.held]

    def restore(self, state: Sequence[float]) -> None:
        """Take up the state that `state` returned."""
        values = iter(checked_state(state, 5 * len(self._spread)))
        for row in (self.bias, self._doubt, self._suspect, self._suspected, self.held):
            row[:] = [next(values) for _ in row]
