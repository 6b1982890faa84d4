"""The conditions of a run, compared with those of the training runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fmu_compensator.fit.training import Array
from measurement.runs import Run


@dataclass(frozen=True)
class Condition:
    """One condition of a run.

    Attributes
    ----------
    name, unit : str
        Name of the condition and its unit.
    value : float
        Value of the run.
    low, high : float
        Range of the training runs.
    """

    name: str
    unit: str
    value: float
    low: float
    high: float

    @property
    def _shown(self) -> tuple[str, str, str]:
        """Value and range of training in three digits: a run is never known more exactly."""
        value, low, high = (
            np.format_float_positional(number, 3, unique=False, fractional=False, trim="-")
            for number in (self.value, self.low, self.high)
        )
        return value, low, high

    @property
    def is_new(self) -> bool:
        """Whether it is outside the range of training, as shown; a shorter run is not."""
        value, low, high = map(float, self._shown)
        return value > high or (value < low and self.unit != "h")

    @property
    def text(self) -> str:
        """The condition in one phrase."""
        value, low, high = self._shown
        return f"{self.name} {value} {self.unit} (training {low} to {high})"


NAMES = (
    ("temperature at the start", "degC"),
    ("largest rise of the median thermometer", "K"),
    ("mean speed", "rpm"),
    ("duration", "h"),
)


def values_of(run: Run, sensors: Sequence[str]) -> list[float]:
    """Return a run's conditions, in the order of `NAMES`; NaN if unknown."""
    columns = [run.frame[f"{name}_degC"].to_numpy(float) for name in sensors]
    speed = run.frame["speed_rpm"].to_numpy(float) if "speed_rpm" in run.frame else np.zeros(0)
    return conditions_in(np.column_stack(columns), speed, run.time_s)


def conditions_in(temperatures: Array, speed: Array, time_s: Array) -> list[float]:
    """Return the conditions from a run's columns, in the order of `NAMES`; NaN if unknown.

    Parameters
    ----------
    temperatures : array (n, k)
        Their median is used [degC].
    speed : array
        [rpm]
    time_s : array (n,)
        [s]
    """
    rows = temperatures[np.isfinite(temperatures).any(axis=1)]
    middle = np.nanmedian(rows, axis=1) if len(rows) else np.array([np.nan])
    known = speed[np.isfinite(speed)]
    return [
        float(middle[0]),
        float(np.max(middle) - middle[0]),
        float(np.mean(np.abs(known))) if len(known) else float("nan"),
        float(time_s[-1] - time_s[0]) / 3600.0,
    ]


def ranges_of(runs: Sequence[Run], sensors: Sequence[str]) -> list[list[float] | None]:
    """Return the smallest and the largest value of each condition, in the order of `NAMES`.

    Parameters
    ----------
    runs : sequence of Run
        Training runs.
    sensors : sequence of str
        Thermometers that the compensator uses.
    """
    ranges: list[list[float] | None] = []
    for column in np.array([values_of(run, sensors) for run in runs]).T:
        known = column[np.isfinite(column)]
        ranges.append([float(known.min()), float(known.max())] if len(known) else None)
    return ranges


def conditions_of(
    run: Run, sensors: Sequence[str], ranges: Sequence[Sequence[float] | None]
) -> list[Condition]:
    """Return a run's conditions together with training's, if both are known.

    Parameters
    ----------
    run : Run
    sensors : sequence of str
        Thermometers that the compensator uses.
    ranges : sequence
        Result of `ranges_of` for the training runs.
    """
    conditions = []
    for (name, unit), value, bounds in zip(NAMES, values_of(run, sensors), ranges, strict=False):
        if bounds is not None and np.isfinite(value):
            conditions.append(Condition(name, unit, value, *bounds))
    return conditions
