"""Weighted sum of temperatures and their lags: a linear map with a memory."""

from __future__ import annotations

from collections.abc import Sequence
from operator import mul
from statistics import median

from fmu_compensator.runtime.error_models.base import ErrorModel
from fmu_compensator.runtime.fields import Fields
from fmu_compensator.runtime.lags import known_speed, matrices_by_lag, share, taus
from fmu_compensator.runtime.sums import summed

SPEED_UNIT = 1000.0
"""Of the speeds in the compensator file, given by its form [rpm]."""


class ThermalStates(ErrorModel):
    r"""Drift = sum over rises, lagged rises, lagged levels and lagged speeds.

    .. math::
        y = A r + \sum_j (B_j L_j[r] + C_j L_j[v] + D_j L_j[(n, n^2)])

    r is the rise of each temperature above its first reading, v its level above the median of the
    chosen temperatures, n the speed in 1000 rpm, and L_j a first-order lag that starts at zero.

    A level that starts outside the range seen in training is taken for a sensor fault (calibration,
    wiring) and shifted to its usual start, so that a sensor that reads 30 K high from some day on
    does not spoil the drift.

    Parameters
    ----------
    lags_s : list of float
        Time constants [s].
    start_low, start_usual, start_high : list of float, one per input
        Range and usual value of the levels at the start [K].
    direct : list of list of float, targets x inputs
        A [um/K, urad/K].
    rise_lags, level_lags : list of matrices like *direct*, one per lag
        B and C [um/K, urad/K].
    speed_lags : list of matrices, targets x 2, one per lag
        D [um per 1000 rpm and its square].
    """

    other_fits = ("bayes", "lasso", "ridge")
    remembers = ("_started", "_speed", "_first", "_shift", "_lagged")

    def __init__(
        self,
        lags_s: list[float],
        start_low: list[float],
        start_usual: list[float],
        start_high: list[float],
        direct: list[list[float]],
        rise_lags: list[list[list[float]]],
        level_lags: list[list[list[float]]],
        speed_lags: list[list[list[float]]],
    ) -> None:
        self._lags_s = lags_s
        self._start = list(zip(start_low, start_usual, start_high, strict=True))
        self._inputs = len(direct[0])
        # Steps mostly have the same length: keep the lags' shares for it.
        self._elapsed_s, self._shares = 0.0, [0.0] * len(lags_s)
        # One row of weights per target, over: rises; per lag: rises, levels, speeds.
        self._weights = []
        for target, row in enumerate(direct):
            weights = list(row)
            for lag in range(len(lags_s)):
                weights += rise_lags[lag][target] + level_lags[lag][target]
                weights += speed_lags[lag][target]
            self._weights.append(weights)
        self._started = False
        self._speed = 0.0  # at the previous sample [1000 rpm]
        self._first, self._shift = [0.0] * self._inputs, [0.0] * self._inputs
        self._lagged = [[0.0] * (2 * self._inputs + 2) for _ in lags_s]

    @classmethod
    def from_fields(cls, fields: Fields, inputs: int, targets: int) -> ThermalStates:
        """Return the model that the file's numbers describe."""
        lags_s = taus(fields, "lags_s")
        names = ("start_low", "start_usual", "start_high")
        lows, usuals, highs = (fields.numbers(key, inputs, 1e4) for key in names)
        for index, (low, usual, high) in enumerate(zip(lows, usuals, highs, strict=True)):
            if not low <= usual <= high:
                problem = f"{usual:g} is not allowed: from start_low ({low:g}) to start_high"
                raise fields.refusal(f"start_usual.{index}", f"{problem} ({high:g})")
        return cls(
            lags_s,
            lows,
            usuals,
            highs,
            fields.matrix("direct", targets, inputs),
            matrices_by_lag(fields, "rise_lags", len(lags_s), targets, inputs),
            matrices_by_lag(fields, "level_lags", len(lags_s), targets, inputs),
            matrices_by_lag(fields, "speed_lags", len(lags_s), targets, 2),
        )

    def predict(
        self,
        inputs: Sequence[float],
        elapsed_s: float = 0.0,
        speed: float = 0.0,
        measured: Sequence[float] | None = None,
    ) -> list[float]:
        """Return the predicted targets; measurements are not used."""
        if not self._started:
            self._started, self._first = True, list(inputs)
            self._shift = [
                0.0 if low <= level <= high else usual - level
                for level, (low, usual, high) in zip(_levels(inputs), self._start, strict=True)
            ]
        mended = [value + shift for value, shift in zip(inputs, self._shift, strict=True)]
        rises = [value - first for value, first in zip(inputs, self._first, strict=True)]
        drives = [*rises, *_levels(mended), self._speed, self._speed**2]
        features = list(rises)
        if elapsed_s != self._elapsed_s:
            self._elapsed_s = elapsed_s
            self._shares = [share(elapsed_s, tau_s) for tau_s in self._lags_s]
        for lag, part in enumerate(self._shares):
            values = [
                value + part * (drive - value)
                for value, drive in zip(self._lagged[lag], drives, strict=True)
            ]
            self._lagged[lag] = values
            features += values
        self._speed = known_speed(speed, self._speed * SPEED_UNIT) / SPEED_UNIT
        return [summed(map(mul, weights, features)) for weights in self._weights]


def _levels(values: Sequence[float]) -> list[float]:
    middle = median(values)
    return [value - middle for value in values]
