"""How far the compensator is stepped, and over which time without inputs."""

from __future__ import annotations

from collections.abc import Mapping
from math import isnan, nan

from gateway.answering import Unit
from gateway.state import Saved


class Stepper:
    """Steps the compensator over cycles of the machine, and over silence.

    Parameters
    ----------
    unit : Unit
        The compensator, started.
    speed_up : float
        Its seconds in one of this computer's clock.
    machine_clock : bool
        It is stepped by the machine's count of time.
    cycle_s, timeout_s : float
        How often cycles come, and after which time without one inputs are missing [s].
    now : float
        The time of this computer's clock [s].
    warm : Saved or None
        The state that it was restored from.

    Attributes
    ----------
    tool_length_mm : float
        The newest that was heard; NaN before one was [mm].
    steps : int
        How many were taken.
    """

    def __init__(
        self,
        unit: Unit,
        speed_up: float,
        machine_clock: bool,
        cycle_s: float,
        timeout_s: float,
        now: float,
        warm: Saved | None,
    ) -> None:
        self._unit, self._speed_up, self._machine_clock = unit, speed_up, machine_clock
        self._cycle_s, self._timeout_s = cycle_s, timeout_s
        self._stepped_at = now - (warm.age_s if warm and not machine_clock else 0.0)
        self._fresh = warm is None  # no step yet: nothing to measure one from
        # Machine time that it has been stepped to [s].
        self._covered = warm.machine_time_s if warm else None
        self.tool_length_mm, self.steps = nan, 0

    def renew(self) -> None:
        """Forget everything: the next step is the first."""
        self._unit.renew()
        self._fresh, self._covered = True, None

    def silence(self, unseen_s: float, now: float) -> None:
        """Step over the time since the step before, and over time that no clock but one has seen.

        Parameters
        ----------
        unseen_s : float
            That time [s].
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

        Time in which nothing came, or that one clock has seen and the others have not, counts as
        time without inputs.

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
            # In two steps: only a second sample that is missing shows that the first was no slip.
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
