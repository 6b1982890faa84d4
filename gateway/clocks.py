"""The clocks that the gateway goes by: this computer's, the time of day, the machine's."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from math import isnan, nan

from gateway.state import Saved

_BOOT = getattr(time, "CLOCK_BOOTTIME", None)
LONGEST_GAP_S = 3600.0
"""A state is too old when the machine's time has gone on by more since it was saved [s]."""
AGREE_S = 10.0
"""By so much may the two ages of a state differ: the machine's and this computer's [s]."""
WALL_STEP_S = 2.0
"""A time of day that moves on by so much more than this computer's clock has been set, or has seen
time that the clock has not [s]."""


def steady() -> float:
    """Return a time that never goes back and, where the system can, goes on in a suspend [s]."""
    return time.monotonic() if _BOOT is None else time.clock_gettime(_BOOT)


class Hours:
    """What the machine's clock shows, and what the time of day has seen that no other clock has.

    Parameters
    ----------
    now : float
        The time of this computer's clock [s].
    speed_up : float
        Seconds of the machine in one of this clock.
    machine_clock : bool
        The machine's time has nothing to do with this clock.
    machine_time_s : float
        What the machine's clock showed last [s].
    wall : callable or None
        The time of day; None: not looked at.
    """

    def __init__(
        self,
        now: float,
        speed_up: float,
        machine_clock: bool,
        machine_time_s: float,
        wall: Callable[[], float] | None,
    ) -> None:
        self._speed_up, self._machine_clock = speed_up, machine_clock
        self._wall = None if machine_clock else wall
        self.machine_time_s, self._started_at, self._told_at = machine_time_s, now, now
        self._wall_offset_s = self._wall() - now if self._wall else 0.0

    def hear(self, beat: Mapping[str, float], now: float, *, sampled: bool) -> None:
        """Take note of a heartbeat; a machine whose frames are sampled has no time of its own."""
        if not isnan(beat.get("machine_time", nan)):
            self.machine_time_s, self._told_at = beat["machine_time"], now
        elif sampled:
            self.machine_time_s = (now - self._started_at) * self._speed_up
            self._told_at = now

    def machine_time_at(self, now: float) -> float:
        """Return what the machine's clock is likely to show at a time [s]."""
        gone_s = 0.0 if self._machine_clock else now - self._told_at
        return self.machine_time_s + gone_s * self._speed_up

    def too_old(self, saved: Saved, shown_s: float, period_s: float, now: float) -> str:
        """Return why a state that was restored is too old by the machine's clock; empty if not.

        Parameters
        ----------
        saved : Saved
            The state.
        shown_s : float
            What the machine's clock shows; NaN for a machine without one [s].
        period_s : float
            It starts anew after this time [s].
        now : float
            The present [s].
        """
        if isnan(shown_s):
            return ""
        age_s = (shown_s - saved.machine_time_s) % period_s
        own_s = (now - self._started_at + saved.age_s) * self._speed_up
        if self._machine_clock:
            own, old = "", age_s > LONGEST_GAP_S
        else:
            own = f", {own_s:.0f} s by this computer's"
            old = abs(age_s - own_s) > AGREE_S * self._speed_up
        return f"the state is too old: {age_s:.0f} s by the machine's clock{own}" if old else ""

    def unseen_s(self, now: float) -> float:
        """Return the machine's time that only the time of day has seen go by [s]."""
        if self._wall is None:
            return 0.0
        offset_s = self._wall() - now
        ahead_s, self._wall_offset_s = offset_s - self._wall_offset_s, offset_s
        return ahead_s * self._speed_up if ahead_s > WALL_STEP_S else 0.0
