"""Whether a cycle can be used: its time, its age, the machine's state, and a second gateway.

`supervision` checks frames and counts; this module compares a whole cycle with the clocks.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf, isnan

import can

from gateway.codec import high_raw, name_of
from gateway.database import Frame, key_of
from gateway.supervision import Cycle, Finding
from gateway.timebase import Timebase

RIVAL_S = 1.0
"""Two intact frames of another gateway within this time count, and they do for as long [s]."""


@dataclass(frozen=True)
class Verdict:
    """Whether a cycle can be used, what is wrong with it, and the machine's reported state."""

    usable: bool
    finding: Finding | None
    machine_state: str

    def finding_is(self, fault: str) -> bool:
        """Return whether a certain fault is what is wrong."""
        return self.finding is not None and self.finding.fault == fault


class Judge:
    """Compares the cycles of a machine with the clocks.

    Parameters
    ----------
    closing : Frame
        The machine's heartbeat.
    speed_up : float or None
        Seconds of the machine in a second of this computer's clock; None: the machine's time has
        nothing to do with this clock.
    timeout_s : float
        How old a cycle may be, and how late or early by the machine's own time [s].

    Attributes
    ----------
    raw : int
        The machine's time, as the newest cycle carries it.
    """

    def __init__(self, closing: Frame, speed_up: float | None, timeout_s: float) -> None:
        self._closing, self._timeout_s = closing, timeout_s
        self._states = closing.signals["machine_state"]
        self._time = closing.signals["machine_time"]
        self._times = high_raw(self._time) + 1  # the count wraps below the special codes
        self._timebase = speed_up and Timebase(self._times, self._time.scale, speed_up, timeout_s)
        self._expected: int | None = None
        self.raw = 0

    def forget(self) -> None:
        """Expect no particular time next: cycles were lost."""
        self._expected = None

    def judge(self, cycle: Cycle, arrived: float, now: float, *, begun: bool) -> Verdict:
        """Judge a cycle.

        Parameters
        ----------
        cycle : Cycle
            What the frames were found to be.
        arrived, now : float
            When its last frame arrived, and the present [s].
        begun : bool
            The compensator has begun.
        """
        beat = cycle.heartbeat
        state = name_of(self._states, beat["machine_state"])
        running = state == "running"
        wrong = self._time_fault(beat, arrived, running=running)
        if not cycle.usable:
            return Verdict(False, cycle.finding, state)
        if now - arrived > self._timeout_s:
            return Verdict(False, self._found("stale", f"waited {now - arrived:.3f} s"), state)
        if wrong is not None and (running or begun):
            return Verdict(False, wrong, state)
        if running:
            return Verdict(True, cycle.finding, state)
        finding = cycle.finding
        if not isnan(beat["machine_state"]) or finding is None:
            text = f"the machine is {state.replace('_', ' ')}"
            finding = Finding("machine_not_running", self._closing, text)
        return Verdict(False, finding, state)

    def _found(self, fault: str, text: str) -> Finding:
        return Finding(fault, self._closing, f"{self._closing.name} {text}")

    def _time_fault(
        self, beat: Mapping[str, float], arrived: float, *, running: bool
    ) -> Finding | None:
        """Judge the machine's time: by what was announced, and by this computer's clock."""
        jump = self._jump(beat)
        if not running or isnan(beat["machine_time"] + beat["machine_step"]):
            if self._timebase:
                self._timebase.restart()
            return jump
        if beat["machine_step"] <= 0.0:
            return self._found("time_stands", "has machine_step 0 while running")
        if not self._timebase:
            return jump
        found = self._timebase.judge(self.raw, arrived, jumped=jump is not None)
        # A machine that left cycles out is none the worse if its time fits this clock.
        return Finding(found[0], self._closing, found[1]) if found else None

    def _jump(self, beat: Mapping[str, float]) -> Finding | None:
        """Compare the machine's time with what it should be after the cycle before."""
        time_s, step_s = beat["machine_time"], beat["machine_step"]
        if isnan(time_s) or isnan(step_s):
            self._expected = None
            return self._found("not_available_value", "has no machine_time or machine_step")
        raw, step = round(time_s / self._time.scale), round(step_s / self._time.scale)
        expected, self._expected = self._expected, (raw + step) % self._times
        self.raw = raw
        if expected is None or raw == expected:
            return None
        wanted = expected * self._time.scale
        text = f"machine_time is {time_s:.3f} s, expected was {wanted:.3f} s"
        return Finding("time_jump", self._closing, text)


class Rival:
    """Listens for another gateway on the same bus.

    Parameters
    ----------
    frames : sequence of Frame
        What a gateway sends.
    """

    def __init__(self, frames: Sequence[Frame]) -> None:
        self._frames = {frame.key: frame for frame in frames}
        self._closing = frames[-1]
        self._heard_at, self._until = -inf, -inf

    def hear(self, message: can.Message, arrived: float) -> bool:
        """Return whether a message is a gateway's; own ones are not heard, so it is another's."""
        frame = self._frames.get(key_of(message))
        if frame is None:
            return False
        # One such frame may be chance: a random one in 256 fits its CRC.
        if len(message.data) == frame.size and frame.protection.intact(message.data):
            if arrived - self._heard_at <= RIVAL_S:
                self._until = arrived + RIVAL_S
            self._heard_at = arrived
        return True

    def finding(self, now: float) -> Finding | None:
        """Return the fault while another gateway is there."""
        if now >= self._until:
            return None
        return Finding("second_gateway", self._closing, "another gateway sends on this bus")
