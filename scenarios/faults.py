"""Sensor faults: what happens to a reading between the plant and the compensator."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, model_validator

from measurement.errors import BadInput
from measurement.resampling import past_rounding
from measurement.units import UNITS, split_column
from scenarios.signals.base import Duration, Seconds, Value

Kind = Literal["missing", "frozen", "offset", "spike", "drift", "stuck-at"]
NEEDS_VALUE = ("offset", "spike", "drift", "stuck-at")


class SensorFault(BaseModel):
    """One fault of one sensor, in force from *start_s* until just before *end_s*.

    Attributes
    ----------
    sensor : str
        The disturbed compensator input, for example ``T1``.
    kind : str
        ``missing``: no value (NaN). ``frozen``: repeats the reading at *start_s*. ``offset``:
        *value* too high. ``spike``: *value* too high for one step, at *start_s* and then every
        *every_s*. ``drift``: drifts by *value* per hour. ``stuck-at``: reads *value*.
    start_s, end_s : float
        Start and end; without *end_s* it lasts to the end of the run [s].
    value : float
        See *kind* [the sensor's unit, or unit/h for a drift].
    every_s : float
        Time between two spikes [s].
    """

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)

    sensor: Annotated[str, Field(min_length=1, max_length=100)]
    kind: Kind
    start_s: Seconds
    end_s: Duration | None = None
    value: Value | None = None
    every_s: Duration | None = None

    @model_validator(mode="after")
    def _fits(self) -> SensorFault:
        if self.end_s is not None and self.end_s <= self.start_s:
            raise ValueError(f"end_s, {self.end_s:g}, must be after start_s, {self.start_s:g}")
        if (self.value is None) == (self.kind in NEEDS_VALUE):
            word = "needs" if self.value is None else "takes no"
            raise ValueError(f"a fault of kind {self.kind} {word} value")
        if self.every_s is not None and self.kind != "spike":
            raise ValueError(f"a fault of kind {self.kind} takes no every_s")
        return self


class FaultLine:
    """Applies faults to the compensator's inputs at each communication point.

    Parameters
    ----------
    faults : iterable of SensorFault
        In the order in which they act on a sensor that has several.
    columns : sequence of str
        The compensator's inputs, or the machine's readings, in the order of the values, each with
        its unit: ``T1_degC``.
    source : str or path
        The scenario, for refusals.

    Raises
    ------
    BadInput
        If a fault is of another sensor, or takes every reading out of its unit's range.
    """

    def __init__(
        self, faults: Iterable[SensorFault], columns: Sequence[str], source: str | Path = ""
    ) -> None:
        units = dict(map(split_column, columns))
        names = list(units)
        self._faults: list[tuple[int, SensorFault]] = []
        for i, fault in enumerate(faults):
            if fault.sensor not in names:
                problem = f"{fault.sensor!r} is not one of {', '.join(names)}"
                raise BadInput(source, f"faults.{i}.sensor", problem)
            unit = UNITS[units[fault.sensor]]
            low, high, value = unit.low, unit.high, fault.value or 0.0
            if fault.kind != "stuck-at":  # the value is a change
                low, high = low - high, high - low
            if fault.kind != "drift" and not low <= value <= high:
                problem = f"{value:g} is outside {low:g}..{high:g} {unit.suffix}"
                raise BadInput(source, f"faults.{i}.value", problem)
            self._faults.append((names.index(fault.sensor), fault))
        self._held: dict[int, float] = {}

    def apply(self, time_s: float, step_s: float, values: NDArray[Any]) -> None:
        """Disturb *values* in place, as seen at *time_s* with a step of *step_s* [s].

        Parameters
        ----------
        time_s : float
            The communication point [s].
        step_s : float
            Time to the next one [s].
        values : array, shape (names,)
            Readings in the order of the names; changed in place.
        """
        time_s = past_rounding(time_s)
        for number, (place, fault) in enumerate(self._faults):
            end_s = math.inf if fault.end_s is None else fault.end_s
            if not fault.start_s <= time_s < end_s:
                continue
            value, elapsed = fault.value or 0.0, time_s - fault.start_s
            match fault.kind:
                case "missing":
                    values[place] = math.nan
                case "frozen":
                    values[place] = self._held.setdefault(number, float(values[place]))
                case "offset":
                    values[place] += value
                case "drift":
                    values[place] += value * elapsed / 3600.0
                case "stuck-at":
                    values[place] = value
                case "spike":
                    # One step long: its phase within the repetition is less than one step.
                    phase = math.fmod(elapsed, fault.every_s or math.inf)
                    values[place] += value * (phase < step_s * (1.0 - 1e-9))
