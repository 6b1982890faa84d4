"""Whether a cycle can be used: is it proven fresh, is the machine running, do the clocks agree?

`reception` checks frames and counts; this module judges whole cycles. If a machine does not send a
proof, a time or a state, that check is left out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf, isnan, nan

import can

from gateway.codec import CountedTime, Finding, decode, name_of
from gateway.database import MACHINE, NOT_AVAILABLE, Database, Frame, key_of
from gateway.proof import Challenges
from gateway.reception import Cycle
from gateway.timebase import Timebase


class Judge:
    """Judges the cycles of a machine.

    Parameters
    ----------
    database : Database
        Its frames; what they do not carry is not judged.
    speed_up : float or None
        Seconds of the machine per second of this computer's clock; None: the machine's time is
        independent of this clock.
    timeout_s : float
        How old a cycle may be, and how late or early by the machine's own time [s].
    challenges : Challenges
        The challenges that a proof may answer.

    Attributes
    ----------
    time : CountedTime or None
        How the machine counts its time.
    time_s : float
        The machine's time in the newest cycle [s].
    machine_state : str
        The machine's state in the newest cycle.
    proven : bool
        Whether the newest cycle is proven to be fresh.
    unseen_s : float
        Time that has passed by the machine's clock but not by this computer's, at the latter's
        rate [s].
    in_time : bool
        Whether both clocks agree on the time since the previous cycle.
    """

    def __init__(
        self, database: Database, speed_up: float | None, timeout_s: float, challenges: Challenges
    ) -> None:
        self._closing, self._timeout_s = database.closing(MACHINE), timeout_s
        signals = {signal.name: signal for _, signal in database.signals(MACHINE)}
        self._proof: Frame | None = database.proof
        self._challenges = challenges
        self._states = signals.get("machine_state")
        self._timebase: Timebase | None = None
        timed = "machine_time" in signals
        self.time = CountedTime(signals["machine_time"]) if timed else None
        if self.time and speed_up:
            # A proof bounds how late a cycle is; only the clock's rate remains to be judged.
            tolerance_s = timeout_s if self._proof is None else challenges.young_s
            self._timebase = Timebase(self.time.count, self.time.scale, speed_up, tolerance_s)
        self._expected_s: float | None = None
        self.time_s = self.unseen_s = 0.0
        self.machine_state, self.proven, self.in_time = NOT_AVAILABLE, False, False

    def forget(self) -> None:
        """Expect no particular time next, because cycles were lost."""
        self._expected_s = None

    def judge(self, cycle: Cycle, arrived: float, now: float) -> tuple[bool, Finding | None]:
        """Return whether a cycle can be used, and the problem if there is one.

        Parameters
        ----------
        cycle : Cycle
            The cycle, from `reception`.
        arrived, now : float
            When its last frame arrived, and the present [s].
        """
        said, state = cycle.heartbeat.get("machine_state", nan), "running"
        if self._states is not None:
            state = name_of(self._states, said)
        self.machine_state, self.proven = state, self._is_proven(cycle, arrived)
        if not isnan(time_s := cycle.heartbeat.get("machine_time", nan)):
            self.time_s = time_s
        if self._timebase:
            self._timebase.tell_nothing()
        # A cycle that may be old says nothing about the machine's clock.
        telling = self.proven or self._proof is None
        wrong = self._time_fault(cycle.heartbeat, arrived) if telling else None
        if self._timebase:
            self.unseen_s, self.in_time = self._timebase.unseen_s, self._timebase.in_time
        if not cycle.usable:
            return False, cycle.finding
        if now - arrived > self._timeout_s:
            return False, self._found("stale", f"waited {now - arrived:.3f} s")
        if self._proof is not None and not self.proven:
            text = f"{self._proof.name} does not prove that its cycle is fresh"
            return False, Finding("not_fresh", self._proof, text)
        if state == "running":
            return wrong is None, wrong or cycle.finding
        if isnan(said) and cycle.finding is not None:
            return False, cycle.finding
        text = f"the machine is {state.replace('_', ' ')}"
        return False, Finding("machine_not_running", self._closing, text)

    def _is_proven(self, cycle: Cycle, arrived: float) -> bool:
        if self._proof is None or self._proof.key not in cycle.frames:
            return False
        proof = decode(self._proof, cycle.frames[self._proof.key]).values
        others = [data for key, data in sorted(cycle.frames.items()) if key != self._proof.key]
        return self._challenges.proven(proof, others, arrived)

    def _found(self, fault: str, text: str) -> Finding:
        return Finding(fault, self._closing, f"{self._closing.name} {text}")

    def _time_fault(self, beat: Mapping[str, float], arrived: float) -> Finding | None:
        """Check the machine's time against the announced time and this computer's clock."""
        timebase, state, proven = self._timebase, self.machine_state, self.proven
        if not self.time or not beat:
            return None
        jump = self._jump(beat, self.time)
        if timebase and (state == "starting" or (proven and state != "running")):
            timebase.restart(proven=proven)
        if state != "running" or isnan(beat["machine_time"] + beat["machine_step"]):
            return jump
        if beat["machine_step"] <= 0.0:
            return self._found("time_stands", "has machine_step 0 while running")
        if not timebase:
            return jump
        fault = timebase.judge(
            self.time.raw(self.time_s), arrived, jumped=jump is not None, proven=proven
        )
        # A machine may leave out cycles if its time agrees with this clock.
        return Finding(fault[0], self._closing, fault[1]) if fault else None

    def _jump(self, beat: Mapping[str, float], time: CountedTime) -> Finding | None:
        """Compare the machine's time with the one that the previous cycle announced."""
        time_s, step_s = beat["machine_time"], beat["machine_step"]
        if isnan(time_s) or isnan(step_s):
            self._expected_s = None
            return self._found("not_available_value", "has no machine_time or machine_step")
        expected_s, self._expected_s = self._expected_s, time.carried_s(time_s + step_s)
        if expected_s is None or not time.since_s(expected_s, time_s):
            return None
        text = f"machine_time is {time_s:.3f} s, expected was {expected_s:.3f} s"
        return Finding("time_jump", self._closing, text)


class Rival:
    """Listens for another gateway on the same bus.

    Parameters
    ----------
    frames : sequence of Frame
        The frames that a gateway sends.
    """

    def __init__(self, frames: Sequence[Frame]) -> None:
        self._frames = {frame.key: frame for frame in frames}
        self._closing = frames[-1]
        self._heard_at, self._until = -inf, -inf

    def hear(self, message: can.Message, arrived: float) -> bool:
        """Return whether a message is another gateway's; this one's own are never received."""
        frame = self._frames.get(key_of(message))
        if frame is None:
            return False
        # A single frame may be chance: one random frame in 256 fits its CRC.
        if len(message.data) == frame.size and frame.protection.intact(message.data):
            if arrived - self._heard_at <= self._closing.timeout_s:
                self._until = arrived + self._closing.timeout_s
            self._heard_at = arrived
        return True

    def finding(self, now: float) -> Finding | None:
        """Return the fault while another gateway is present."""
        if now >= self._until:
            return None
        return Finding("second_gateway", self._closing, "another gateway sends on this bus")
