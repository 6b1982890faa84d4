"""The other end of the bus: a control that sends readings, receives offsets and moves its axes."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import inf, isnan, nan
from typing import TYPE_CHECKING

import can

from fmu_compensator.runtime.fmi_slave import HALF_WIDTHS
from gateway.codec import CountedTime, Sender, Value, name_of
from gateway.control import OffsetFollower
from gateway.database import (
    COMPENSATOR,
    FAREWELLS,
    MACHINE,
    NOT_AVAILABLE,
    OFFSETS,
    Database,
    key_of,
)
from gateway.link import Link
from gateway.probes import LATEST_STEPS, TAKEN, ProbeSender
from gateway.proof import CHALLENGE, ECHO, PROOF
from gateway.reception import Cycle, Reception

if TYPE_CHECKING:
    from gateway.linuxcnc.component import ControlPins
    from gateway.plant import MachinePlant

STALE_CYCLES = LATEST_STEPS + 1.0
"""An answer to readings older than this many cycles is not used; the way back takes one."""


@dataclass(frozen=True)
class Pace:
    """How fast the machine runs.

    Attributes
    ----------
    lockstep : bool
        The next cycle begins when the gateway has answered; otherwise when it is due.
    wait_s : float
        How long a gateway may take to appear [s]; then the machine begins without one.
    hold_s : float
        How long offsets are held without a gateway, in the machine's time [s].
    timeout_s : float or None
        The silence after which an answer is late, and in lockstep the longest wait for one; None:
        from the DBC file [s].
    """

    lockstep: bool = False
    wait_s: float = 10.0
    hold_s: float = 60.0
    timeout_s: float | None = None


class AnswerReceiver:
    """Receives the gateway's newest answer, and the time of the readings that it answers.

    Parameters
    ----------
    database : Database
        The frames.
    clock : callable
        Monotonic time [s].
    timeout_s : float, optional
        Silence after which an answer is late; by default from the DBC file [s].
    """

    def __init__(
        self,
        database: Database,
        clock: Callable[[], float],
        timeout_s: float | None = None,
    ) -> None:
        frames, closing = database.of(COMPENSATOR), database.closing(COMPENSATOR)
        self._words = {s.name: s for _, s in database.signals(COMPENSATOR) if s.is_enumeration}
        self.timed = database.every_s is None
        if self.timed:
            self._time = CountedTime(database.signal("machine_time"))
            self._answered = CountedTime(closing.signals["answered_time"])
        # A gateway sends its frames together, though not always protected as such.
        self.reception = Reception(
            frames,
            together=self.timed,
            optional=() if self.timed else OFFSETS,
            timeout_s=timeout_s,
            look_after=closing.key,
        )
        self.challenge: int | None = None
        self.timeout_s = timeout_s or closing.timeout_s
        self._clock = clock
        self._fresh: Cycle | None = None
        self.last: Cycle | None = None

    def hear(self, link: Link, until: float, time_s: float | None = None) -> bool:
        """Listen until a time, or until the answer to the readings of *time_s* [s] has come.

        Parameters
        ----------
        link : Link
            The bus, open.
        until : float
            When to stop, by this object's clock [s].
        time_s : float, optional
            The machine's time of the readings [s]; without it, listen until *until*.

        Returns
        -------
        bool
            Whether that answer has come; never true without *time_s*.
        """
        wanted_s = time_s if self.timed else None
        while True:
            # Receive at least once, so that waiting frames are taken in even if it is late.
            message = link.receive(until - self._clock())
            if message is not None:
                cycle = self.reception.take(key_of(message), message.data, self._clock())
                if cycle is not None:
                    self._fresh = self.last = cycle
                    heard = cycle.values.get(CHALLENGE, nan)
                    self.challenge = self.challenge if isnan(heard) else int(heard)
                    if self.says("gateway_state") in ("starting", "ready"):
                        self.reception.renew()
                    if wanted_s is not None and self._answers(cycle, wanted_s):
                        return True
            if self._clock() >= until:
                return False

    def _answers(self, cycle: Cycle, time_s: float) -> bool:
        if self.says("gateway_state") == "ready":
            return False  # an answer to a cycle before the machine began
        return self._age_s(cycle, time_s) == 0.0

    def _age_s(self, cycle: Cycle, time_s: float) -> float:
        """Return the age of the readings that an answer belongs to, at a time [s]."""
        sent_s = self._time.carried_s(time_s)  # wraps like the time in the machine's frame
        return self._answered.since_s(cycle.heartbeat["answered_time"], sent_s)

    def taken(self, time_s: float = 0.0, oldest_s: float = inf) -> Cycle | None:
        """Return the newest answer; None if it was returned before or is stale.

        Parameters
        ----------
        time_s : float
            The machine's time [s].
        oldest_s : float
            An answer to readings older than this is stale: frames that waited in a full queue
            while the bus was blocked are intact and in sequence, but useless [s].
        """
        fresh, self._fresh = self._fresh, None
        if fresh is None or not self.timed:
            return fresh
        return fresh if self._age_s(fresh, time_s) <= oldest_s else None

    def says(self, signal: str) -> str:
        """Return a signal's value in the gateway's last heartbeat, as the DBC names it.

        Parameters
        ----------
        signal : str
            A signal of the heartbeat frame.

        Returns
        -------
        str
            The value's name; `NOT_AVAILABLE` if nothing was received or the frames lack the signal.
        """
        if self.last is None or signal not in self._words:
            return NOT_AVAILABLE
        return name_of(self._words[signal], self.last.heartbeat.get(signal, nan))


class MachineNode:
    """The control and its machine.

    Parameters
    ----------
    database : Database
        The frames.
    plant : MachinePlant or ControlPins
        The machine behind the control, started; or a real control's pins.
    link : Link
        The bus, open.
    pace : Pace
        How fast the machine runs.
    save : callable
        Called after each cycle; saves the state from time to time.
    stopped : callable
        Returns whether to end early.
    clock : callable
        Monotonic time [s].
    key : bytes or None
        The key for its proofs of freshness.
    """

    def __init__(
        self,
        database: Database,
        plant: MachinePlant | ControlPins,
        link: Link,
        pace: Pace,
        save: Callable[[], None] = lambda: None,
        stopped: Callable[[], bool] = lambda: False,
        clock: Callable[[], float] = time.monotonic,
        key: bytes | None = None,
    ) -> None:
        self._plant, self._link, self._pace = plant, link, pace
        self._save, self._stopped, self._clock = save, stopped, clock
        self._database, self._sender = database, Sender(database, MACHINE, key)
        self._probes = ProbeSender(database.events(MACHINE))
        plant.probe_with(self._probes.names)
        self._cycle_s = database.every_s or database.closing(MACHINE).cycle_s
        self._wrap_s = inf
        if database.has("machine_time"):
            self._wrap_s = CountedTime(database.signal("machine_time")).period_s
        self._lost_s = 0.0
        self.answers = AnswerReceiver(database, clock, pace.timeout_s)
        self.follower = OffsetFollower(pace.hold_s)
        self.answered = 0

    def run(self, progress: Callable[[], None] = lambda: None) -> None:
        """Run the scenario to its end, or until stopped.

        Parameters
        ----------
        progress : callable, optional
            Called after each cycle.

        Raises
        ------
        FmuError
            If the plant fails.
        """
        self._wait_for_gateway()
        begun, count = self._clock(), 0
        while True:
            time_s = self.time_s
            fresh = self.answers.taken(time_s, STALE_CYCLES * self._plant.step_s)
            self.answered += fresh is not None and fresh.usable
            offsets = self.follower.follow(fresh, self._plant.step_s)
            self._plant.record(offsets, self._heard(fresh))
            last = self._plant.done or self._stopped()
            sent_at = self._clock()
            self._link.send(self._probe())
            self._send("running", self._plant.step_s)
            if last:
                self.answers.hear(self._link, sent_at + self._cycle_s, time_s)
                break
            self._plant.step(offsets)
            count += 1
            if not self._pace.lockstep:
                count += self._left_out(self._clock() - begun - count * self._cycle_s)
            self._listen(sent_at, begun + count * self._cycle_s, time_s)
            self._save()
            progress()
        for state in ("stopping", *["off"] * FAREWELLS):
            self._send(state, 0.0)
            self.answers.hear(self._link, self._clock() + self._cycle_s)

    @property
    def time_s(self) -> float:
        """The machine's time: the plant's, plus that of skipped cycles [s]."""
        return self._plant.time_s + self._lost_s

    def _left_out(self, late_s: float) -> int:
        """Return how many cycles to skip when late by *late_s* [s].

        A machine's clock does not wait for a busy computer, so its time on the bus goes on.
        """
        cycles = max(int(late_s / self._cycle_s), 0)
        self._lost_s += cycles * self._plant.step_s
        return cycles

    def _listen(self, sent_at: float, due: float, time_s: float) -> None:
        """Wait for the answer, or until the next cycle is due."""
        if not self._pace.lockstep:
            self.answers.hear(self._link, due)
            return
        # Wait the full timeout for a gateway that has answered; for an absent one only as long as a
        # cycle takes in real time.
        patience = self.answers.timeout_s
        if self.follower.use not in ("following", "none_yet"):
            patience = self._cycle_s
        self.answers.hear(self._link, sent_at + patience, time_s)

    def _wait_for_gateway(self) -> None:
        until = self._clock() + self._pace.wait_s
        while not self._stopped() and self._clock() < until:
            self._send("starting", 0.0)
            self.answers.hear(self._link, self._clock() + self._cycle_s)
            known = self.answers.says("bus_fault") == "machine_not_running"
            if known or (self.answers.last is not None and not self.answers.timed):
                # The gateway knows our counters and finds no other fault. Its answers so far belong
                # to no cycle of ours.
                self.answers.taken()
                return

    def _probe(self) -> list[can.Message]:
        """Return the frames of a probe, if one is due or has not been taken yet."""
        heard = self.answers.last.values if self.answers.last else {}
        count = heard.get(TAKEN, nan)
        measured = self._plant.measured([heard.get(name, nan) for name in HALF_WIDTHS])
        if measured:
            named = dict(zip(self._probes.names, measured, strict=True))
            self._probes.start(named, count)
        return self._probes.messages(self.time_s % self._wrap_s, count)

    def _send(self, state: str, step_s: float) -> None:
        values = self._values(state, step_s)
        self._link.send(self._sender.messages(values, self.answers.challenge))

    def _values(self, state: str, step_s: float) -> dict[str, Value]:
        return {
            **self._plant.readings(),
            "machine_state": state,
            "machine_time": self.time_s % self._wrap_s,
            "machine_step": step_s,
            "offset_use": self.follower.use,
            "thermal_state": self._plant.thermal_state,
        }

    def unread(self) -> list[str]:
        """Return the signals that would be sent as if read: without a value, or a code for none."""
        known = {*self._values("off", 0.0), ECHO, PROOF}
        signals = (signal for _, signal in self._database.signals(MACHINE))
        return [s.name for s in signals if s.name not in known and NOT_AVAILABLE not in s.codes]

    def _heard(self, fresh: Cycle | None) -> Mapping[str, float]:
        """Return the flags and codes that the table holds in addition to the plant's signals."""
        values = self.answers.last.values if self.answers.last else {}
        names = ("valid", "status", "status_sensor", "bus_fault")
        heard = {name: values.get(name, float("nan")) for name in names}
        # Without a fresh answer nothing is valid.
        return heard if fresh is not None else {**heard, "valid": 0.0}
