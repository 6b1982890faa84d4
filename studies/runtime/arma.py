"""Time series: ARMA of the differenced, standardised drift. It needs measurements."""

from __future__ import annotations

from collections.abc import Sequence

from fmu_compensator.runtime.error_models.base import ErrorModel, Remembering
from fmu_compensator.runtime.fields import LARGEST, Fields
from fmu_compensator.runtime.sums import summed
from fmu_compensator.runtime.ticks import ticks

MOST_DIFFERENCES = 2
"""Given by what is remembered of a target: a level and a rate."""


class Series(Remembering):
    r"""One target: w = (difference of order d of y - mean) / scale is an ARMA(p, q).

    .. math::
        w(k) = \sum_i \phi_i w(k-i) + e(k) + \sum_j \theta_j e(k-j)

    Parameters
    ----------
    differences : int
        d.
    mean, scale : float
        Of the differenced series.
    ar, ma : list of float
        phi and theta.
    """

    remembers = ("held", "synced", "tails", "past", "errors")

    def __init__(
        self, differences: int, mean: float, scale: float, ar: list[float], ma: list[float]
    ) -> None:
        self.mean, self.scale, self.ar, self.ma = mean, scale, ar, ma
        self.tails = [0.0] * differences  # last value of each lower-order difference
        self.past = [0.0] * len(ar)
        self.errors = [0.0] * len(ma)
        self.held = 0.0
        self.synced = 1.0  # whether the last step was measured

    @classmethod
    def from_fields(cls, fields: Fields) -> Series:
        """Return the series of a file's table."""
        differences = fields.integer("differences", 0, MOST_DIFFERENCES)
        scale = fields.number("scale", 1e-9, LARGEST)
        mean = fields.number("mean", -LARGEST, LARGEST)
        parts = []
        for key in ("ar", "ma"):
            count = len(fields.items(key, "numbers"))
            parts.append(fields.numbers(key, count, 100.0))
        fields.done()
        return cls(differences, mean, scale, *parts)

    def forecast(self) -> float:
        """Return the next standardised difference, predicted from the past."""
        return summed(a * w for a, w in zip(self.ar, self.past, strict=True)) + summed(
            b * e for b, e in zip(self.ma, self.errors, strict=True)
        )

    def level(self, w: float) -> float:
        """Return the level that follows from a standardised difference."""
        value = self.mean + self.scale * w
        for tail in self.tails:
            value += tail
        return min(max(value, -LARGEST), LARGEST)

    def take(self, measured: float | None) -> None:
        """Advance by one step, with its measurement or with the forecast."""
        expected = self.forecast()
        w = expected
        reached = self.level(expected)
        if measured is not None:
            if self.synced or not self.tails:
                w = (measured - summed(self.tails) - self.mean) / self.scale
            # After steps without measurement, the whole error would look like one step's jump.
            reached = measured
        self._advance(w, w - expected, reached, measured is not None)

    def _advance(self, w: float, error: float, reached: float, measured: bool) -> None:
        rate = min(max(self.mean + self.scale * w, -LARGEST), LARGEST)
        if len(self.tails) == 2:
            self.tails[1] = min(max(self.tails[1] + rate, -LARGEST), LARGEST)
        if self.tails:
            self.tails[0] = reached
        if self.past:
            self.past = [min(max(w, -LARGEST), LARGEST), *self.past[:-1]]
        if self.errors:
            self.errors = [min(max(error, -LARGEST), LARGEST), *self.errors[:-1]]
        self.synced = float(measured)


class AutoregressiveMovingAverage(ErrorModel):
    """One series per target on an even clock; temperatures are not used.

    Parameters
    ----------
    step_s : float
        Length of a step [s].
    series : list of Series
        One per target.
    """

    uses_measured = True
    remembers = ("_waiting", "_age", "_measured", "_series")

    def __init__(self, step_s: float, series: list[Series]) -> None:
        self._step_s, self._series = step_s, series
        self._waiting = True  # the first sample measures zero
        self._age = 0.0  # of the step [s]
        self._measured = [0.0] * len(series)

    @classmethod
    def from_fields(cls, fields: Fields, inputs: int, targets: int) -> AutoregressiveMovingAverage:
        """Return the model that the file's numbers describe."""
        tables = fields.tables("series", "series", targets, targets)
        return cls(
            fields.number("step_s", 0.1, 1e5), [Series.from_fields(table) for table in tables]
        )

    def predict(
        self,
        inputs: Sequence[float],
        elapsed_s: float = 0.0,
        speed: float = 0.0,
        measured: Sequence[float] | None = None,
    ) -> list[float]:
        """Return the predicted targets."""
        count, self._age = ticks(self._age + elapsed_s, self._step_s)
        if measured is not None:
            self._waiting, self._measured = True, list(measured)
        for tick in range(count):
            # A step starts from the measurement at the previous one; the drift starts at zero.
            measured_now = self._measured if tick == 0 and self._waiting else None
            for target, series in enumerate(self._series):
                series.take(None if measured_now is None else measured_now[target])
                series.held = series.level(series.forecast())
            self._waiting = False
        return [series.held for series in self._series]

    def reset(self) -> None:
        """Forget everything: the drift starts at zero."""
        super().reset()
        self._waiting = True
        for series in self._series:
            series.synced = 1.0
