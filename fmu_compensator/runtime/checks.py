"""Checks whether temperature readings can be used.

A reading is bad if it is missing, implausible, changes faster than heat can, or stays constant for
longer than a live sensor does. Only the sensors that the error model uses are checked.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Any

from fmu_compensator.runtime.fields import Fields

MISSING, IMPLAUSIBLE, TOO_FAST, STALE = 1, 2, 3, 4
"""The last digit of a status: given by the FMU's interface."""
SPAN_S = 300.0
"""Rates of change are taken over this span, in which noise and quantisation hardly count; it also
bounds how far real warming may have moved a sensor when it returns from a jump [s]. Given by
`measurement.resampling.SLOW_S`, which is not part of an FMU."""
ALIVE_AFTER = 20
"""A sensor whose reading has changed this often is alive, so that standing still is suspicious. Set
on no data; a test bench's constants never change."""


@dataclass(frozen=True, slots=True)
class Sensor:
    """One temperature input of the compensator.

    Attributes
    ----------
    name : str
        The signal's name.
    low, high : float
        Plausible readings [degC].
    rate_per_s : float
        Fastest real change of temperature [K/s].
    noise : float
        Largest jump between two readings that noise and quantisation explain [K].
    stale_after_s : float or None
        A reading that stays exactly the same for longer is stale, provided that the sensor has
        changed before [s]; None: never.
    trained_low, trained_high : float
        Range of the model's input seen in training, in the file's input form [degC or K]; not used
        at run time.
    """

    name: str
    low: float
    high: float
    rate_per_s: float
    noise: float
    stale_after_s: float | None
    trained_low: float
    trained_high: float

    @classmethod
    def from_fields(cls, fields: Fields) -> Sensor:
        """Return the sensor of a file's table."""
        name = fields.name("name")
        fields.choice("unit", ("degC",))
        low, high = fields.range("low", "high", -60, 400)
        trained_low = fields.number("trained_low", -1000, 1000)
        sensor = cls(
            name,
            low,
            high,
            fields.number("rate_per_s", 1e-9, 1e3),
            fields.number("noise", 0, 400),
            None
            if fields.raw("stale_after_s") is None
            else fields.number("stale_after_s", 1e-3, 1e7),
            trained_low,
            fields.number("trained_high", trained_low, 1000),
        )
        fields.done()
        return sensor


@dataclass(frozen=True, slots=True)
class Fault:
    """Why the inputs cannot be used: cause code 1 to 4, 1-based sensor (0: none), and a text."""

    cause: int
    sensor: int
    text: str


class SensorCheck:
    """Checks the readings of one sensor.

    The rate check compares a reading with the last good one, not with the previous one, so that
    a single spike is one bad reading and not two. A reading is good within a corridor around the
    last good one: the sensor's noise plus its rate limit times the time between them. Noise is a
    separate term because a quantised sensor shows its whole step in an arbitrarily short time.
    A reading that was *seen* to jump out of the corridor must come back to it: the corridor stops
    widening after `SPAN_S`, or a shifted sensor would be trusted again after a while. After a
    gap without readings it keeps widening, because the change may have been slow.

    Noise always moves a live sensor. A constant one is therefore stale, but only if its reading has
    changed `ALIVE_AFTER` times before. The constants of a test bench never do that.
    """

    __slots__ = (
        "_good",
        "_index",
        "_jumped_after",
        "_last",
        "_moves",
        "_sensor",
        "_since_good",
        "_unchanged",
    )

    def __init__(self, sensor: Sensor, index: int) -> None:
        self._sensor, self._index = sensor, index
        self.reset()

    def reset(self) -> None:
        """Forget all readings."""
        self._good: float | None = None  # the last good reading [degC]
        self._since_good = 0.0  # [s]
        self._jumped_after: float | None = None  # age of the last good one at the jump [s]
        self._last: float | None = None  # the last reading of any kind [degC]
        self._unchanged = 0.0  # for how long it has been the same [s]
        self._moves = 0  # how often it has changed, counted up to ALIVE_AFTER

    def look(self, value: float, elapsed_s: float) -> Fault | None:
        """Return the fault of a reading [degC] *elapsed_s* after the previous one; None if good."""
        sensor = self._sensor
        self._since_good += elapsed_s
        if value == self._last:
            self._unchanged += elapsed_s
        elif isfinite(value):
            if self._last is not None and self._moves < ALIVE_AFTER:
                self._moves += 1
            self._last, self._unchanged = value, 0.0
        else:
            self._last = None
            return self._fault(MISSING, f"{sensor.name} is missing")
        # A value that was good before is good again, unless it is stale.
        fault = None if value == self._good else self._elsewhere(value)
        if fault is not None:
            return fault
        limit_s = sensor.stale_after_s if self._moves == ALIVE_AFTER else None
        if limit_s is not None and self._unchanged > limit_s:
            return self._fault(
                STALE,
                f"{sensor.name} {value:.1f} degC is unchanged for {self._unchanged:.0f} s, "
                f"{limit_s:g} s allowed",
            )
        self._good, self._since_good, self._jumped_after = value, 0.0, None
        return None

    def _elsewhere(self, value: float) -> Fault | None:
        """Return the fault of a reading that differs from the last good one [degC]."""
        sensor, span = self._sensor, self._since_good
        away = allowed = 0.0
        if self._good is not None:
            if self._jumped_after is not None:
                span = min(span, max(SPAN_S, self._jumped_after))
            away, allowed = abs(value - self._good), sensor.noise + sensor.rate_per_s * span
            if away > allowed and self._jumped_after is None:
                self._jumped_after = self._since_good
        if not sensor.low <= value <= sensor.high:
            limit = f"below {sensor.low:g}" if value < sensor.low else f"above {sensor.high:g}"
            return self._fault(IMPLAUSIBLE, f"{sensor.name} {value:.1f} degC is {limit} degC")
        if away > allowed:
            text = f"{value:.1f} degC jumped by {away:.1f} K, {allowed:.2g} K allowed"
            return self._fault(TOO_FAST, f"{sensor.name} {text}")
        return None

    @property
    def stands(self) -> bool:
        """Whether the last reading equals the previous one."""
        return self._unchanged > 0.0

    def _fault(self, cause: int, text: str) -> Fault:
        return Fault(cause, self._index, text)

    def state(self) -> list[float | None]:
        """Return the memory, for JSON."""
        timing = [self._since_good, self._jumped_after, self._last, self._unchanged]
        return [self._good, *timing, self._moves]

    def restore(self, state: Sequence[Any]) -> None:
        """Restore what `state` returned."""
        self._good, self._since_good, self._jumped_after, self._last = state[:4]
        self._unchanged, self._moves = state[4:]
