"""The compensator's time, from three clocks: this computer's, the machine's and the time of day.

The compensator is stepped by this computer's clock or by the machine's. Time that has passed on
only one of the clocks counts as time without inputs.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from math import isnan, nan
from typing import TYPE_CHECKING

from gateway.codec import CountedTime
from gateway.state import OLDEST_S, Saved

if TYPE_CHECKING:
    from gateway.unit import CompensatorUnit

_BOOT = getattr(time, "CLOCK_BOOTTIME", None)


AGREE_S = 10.0
"""Largest difference between a state's age by the machine's clock and by this computer's [s]: set
on no data."""


def steady() -> float:
    """Return a monotonic time that, if the system supports it, also counts while suspended [s]."""
    return time.monotonic() if _BOOT is None else time.clock_gettime(_BOOT)


class Stepper:
    """Steps the compensator over the machine's cycles, over silence, and over unseen time.

    Parameters
    ----------
    unit : CompensatorUnit
        The compensator, started.
    speed_up : float
        Seconds of the compensator per second of this computer's clock.
    machine_clock : bool
        Whether to step by the machine's count of time, which is independent of this clock.
    cycle_s, timeout_s : float
        The period of cycles, and the time without one after which inputs are missing [s].
    now : float
        The time of this computer's clock [s].
    warm : Saved or None
        The state that the compensator was restored from.
    wall : callable or None
        The time of day; None: not used.

    Attributes
    ----------
    machine_time_s : float
        The last reading of the machine's clock [s].
    tool_length_mm : float
        The last tool length received; NaN before the first [mm].
    steps : int
        Number of steps taken.
    """

    def __init__(
        self,
        unit: CompensatorUnit,
        speed_up: float,
        machine_clock: bool,
        cycle_s: float,
        timeout_s: float,
        now: float,
        warm: Saved | None,
        wall: Callable[[], float] | None,
    ) -> None:
        self._unit, self._speed_up, self._machine_clock = unit, speed_up, machine_clock
        self._cycle_s, self._timeout_s = cycle_s, timeout_s
        self._wall = None if machine_clock else wall
        self._wall_offset_s = self._wall() - now if self._wall else 0.0
        self._stepped_at = now - (warm.age_s if warm and not machine_clock else 0.0)
        self._fresh = warm is None  # no step yet, so no time since the last one
        # Machine time up to which the compensator has been stepped [s].
        self._covered = warm.machine_time_s if warm else None
        self.machine_time_s = warm.machine_time_s if warm else 0.0
        self._started_at = self._heard_at = now
        self.tool_length_mm, self.steps = nan, 0

    def hear(self, beat: Mapping[str, float], now: float, *, sampled: bool) -> None:
        """Take the time of a heartbeat; a machine with sampled frames has no time of its own."""
        if not isnan(beat.get("machine_time", nan)):
            self.machine_time_s, self._heard_at = beat["machine_time"], now
        elif sampled:
            self.machine_time_s = (now - self._started_at) * self._speed_up
            self._heard_at = now

    def machine_time_at(self, now: float) -> float:
        """Return what the machine's clock probably shows at a time [s]."""
        gone_s = 0.0 if self._machine_clock else now - self._heard_at
        return self.machine_time_s + gone_s * self._speed_up

    def too_old(self, saved: Saved, shown_s: float, counted: CountedTime | None, now: float) -> str:
        """Return why a restored state is too old by the machine's clock; empty if it is not.

        Parameters
        ----------
        saved : Saved
            The state.
        shown_s : float
            What the machine's clock shows; NaN for a machine without one [s].
        counted : CountedTime or None
            How frames count this time; None for a machine without a clock.
        now : float
            The present [s].
        """
        if isnan(shown_s) or counted is None:
            return ""
        age_s = (shown_s - saved.machine_time_s) % counted.period_s
        own_s = (now - self._started_at + saved.age_s) * self._speed_up
        if self._machine_clock:
            own, old = "", age_s > OLDEST_S
        else:
            own = f", {own_s:.0f} s by this computer's"
            old = abs(age_s - own_s) > AGREE_S * self._speed_up
        return f"the state is too old: {age_s:.0f} s by the machine's clock{own}" if old else ""

    def unseen_s(self, now: float) -> float:
        """Return the machine's time that has passed by the time of day only [s]."""
        if self._wall is None:
            return 0.0
        offset_s = self._wall() - now
        ahead_s, self._wall_offset_s = offset_s - self._wall_offset_s, offset_s
        return ahead_s * self._speed_up if ahead_s > self._timeout_s else 0.0

    def renew(self) -> None:
        """Forget everything: the next step is the first."""
        self._unit.renew()
        self._fresh, self._covered = True, None

    def silence(self, unseen_s: float, now: float) -> None:
        """Step over the time since the last step, and over time that only one clock has seen.

        Parameters
        ----------
        unseen_s : float
            Time that only one clock has seen [s].
        now : float
            The present [s].
        """
        step_s = self._own(now) + unseen_s
        if self._covered is not None:
            self._covered += step_s
        self._step({}, step_s, now)

    def advance(
        self, values: Mapping[str, float], beat: Mapping[str, float], now: float, unseen_s: float
    ) -> None:
        """Step over a cycle of the machine.

        Time in which nothing came, or that only one clock has seen, counts as time without inputs.

        Parameters
        ----------
        values : mapping of str to float
            The inputs.
        beat : mapping of str to float
            The machine's heartbeat.
        now : float
            The present [s].
        unseen_s : float
            Time that only one clock has seen [s].
        """
        step_s = self._own(now)
        if not self._machine_clock:
            if now - self._stepped_at > self._timeout_s and not self._fresh:
                cycle_s = self._cycle_s * self._speed_up
                unseen_s, step_s = max(unseen_s, step_s - cycle_s), cycle_s
        elif not isnan(beat["machine_time"] + beat["machine_step"]):
            step_s, begins_s = beat["machine_step"], beat["machine_time"]
            unseen_s = begins_s - self._covered if self._covered is not None else 0.0
            self._covered = begins_s + step_s
        if unseen_s > 1e-6:
            # In two steps, because a single missing sample could be a slip.
            last_s = min(unseen_s, self._cycle_s * self._speed_up)
            self._step({}, unseen_s - last_s, now)
            self._step({}, last_s, now)
        self._step(values, step_s, now)

    def _own(self, now: float) -> float:
        """Return the time since the last step by this computer's clock [s]."""
        elapsed_s = self._cycle_s if self._fresh else now - self._stepped_at
        return elapsed_s * self._speed_up

    def _step(self, values: Mapping[str, float], step_s: float, now: float) -> None:
        self._stepped_at, self._fresh = now, False
        if step_s > 0.0:
            self._unit.step(values, step_s)
            self.steps += 1
            length = values.get("tool_length", nan)
            self.tool_length_mm = self.tool_length_mm if isnan(length) else length
