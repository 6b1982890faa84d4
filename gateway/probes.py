"""Probes on the bus: the control's measurements for the compensator.

A probe is sent in separate frames just before the frames of the cycle that it belongs to. They have
the same protection as other frames, share one count, and carry the time of that cycle, so that a
delayed probe is not taken for a new one. The gateway counts the probes that it passed to the
compensator; a control repeats a probe until the count has advanced.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import inf, isfinite, isnan

import can

from gateway.codec import CountedTime, Encoder, Value, decode
from gateway.database import MAY_BE_LOST, Frame, key_of
from gateway.timebase import WORD_HOLDS_S
from scenarios.wiring import PROBED

PROBE_TIME = "probe_time"
TAKEN = "probes_taken"
COUNTED = 4
"""Number of probes after which their count starts again: given by its two bits in the frame."""
LATEST_STEPS = MAY_BE_LOST + 1.5
"""Inputs or a probe from a cycle more than this many steps ago are not used."""


class ProbeReceiver:
    """Assembles probes from their frames.

    Parameters
    ----------
    frames : sequence of Frame
        The frames that belong to no cycle.
    say : callable
        Takes a line for people.

    Attributes
    ----------
    taken : int
        Number of probes passed to the compensator.
    """

    def __init__(
        self, frames: Sequence[Frame], say: Callable[[str], None] = lambda line: None
    ) -> None:
        self._frames = {frame.key: frame for frame in frames}
        times = [f.signals[PROBE_TIME] for f in frames if PROBE_TIME in f.signals]
        self._time = CountedTime(times[0]) if times else None
        self._say = say
        self._parts: dict[int, tuple[tuple[int, int], Mapping[str, float]]] = {}
        self._counts: tuple[int, int] | None = None
        self._waiting: dict[str, float] | None = None
        self._last_s: float | None = None
        self.taken = 0

    def hear(self, message: can.Message) -> bool:
        """Return whether a message is part of a probe."""
        frame = self._frames.get(key_of(message))
        if frame is None:
            return False
        if len(message.data) != frame.size or not frame.protection.intact(message.data):
            self._say(f"a frame of a probe, {frame.name}, does not fit its CRC")
            return True
        content = decode(frame, message.data)
        counts = content.counter, content.cycle
        self._parts[frame.key] = counts, content.values
        together = {part[0] for part in self._parts.values()}
        if len(self._parts) == len(self._frames) and len(together) == 1 and counts != self._counts:
            self._counts = counts
            self._waiting = {n: v for _, values in self._parts.values() for n, v in values.items()}
            self._parts = {}
        return True

    def due(self, time_s: float, step_s: float, wanted: Sequence[str]) -> dict[str, float]:
        """Return the probe that belongs to a cycle, by the compensator's names; empty for none.

        Parameters
        ----------
        time_s : float
            The cycle's time [s].
        step_s : float
            The machine's step [s].
        wanted : sequence of str
            The compensator's inputs for a probe.
        """
        probe, self._waiting = self._waiting, None
        if probe is None or self._time is None or not wanted:
            return {}
        sent_s = probe[PROBE_TIME]
        age_s = self._time.since_s(sent_s, time_s)
        if age_s > LATEST_STEPS * step_s:
            self._say(f"a probe is not used: it is {age_s:.3f} s old")
            return {}
        if sent_s == self._last_s:
            return {}  # a repeated probe: its acknowledgement was lost
        measured = {name: probe.get(name, float("nan")) for name in wanted}
        missing = [name for name, value in measured.items() if not isfinite(value)]
        if missing:
            self._say(f"a probe is not used: {missing[0]} is missing")
            return {}
        self._last_s = sent_s
        self.taken += 1
        self._say(f"a probe is used, the {self.taken}. so far")
        return measured


class ProbeSender:
    """Sends a control's probes until the gateway takes them, or `WORD_HOLDS_S` is over.

    Parameters
    ----------
    frames : sequence of Frame
        The frames that belong to no cycle.
    """

    def __init__(self, frames: Sequence[Frame]) -> None:
        self._encoders = [Encoder(frame) for frame in frames]
        self._waiting: dict[str, float] | None = None
        self._count = float("nan")
        self._until_s = inf

    @property
    def names(self) -> list[str]:
        """The measured quantities that a probe can carry."""
        return [
            name
            for encoder in self._encoders
            for name in encoder.frame.signals
            if name.startswith(PROBED)
        ]

    def start(self, measured: Mapping[str, float], count: float) -> None:
        """Begin to send a probe.

        Parameters
        ----------
        measured : mapping of str to float
            By the compensator's names [um, urad].
        count : float
            The gateway's present count of probes; NaN if unknown.
        """
        self._waiting, self._count, self._until_s = dict(measured), count, inf

    def messages(self, time_s: float, count: float) -> list[can.Message]:
        """Return the messages to send before the frames of a cycle.

        Parameters
        ----------
        time_s : float
            The cycle's time, as its frame carries it [s].
        count : float
            The gateway's count of probes, as last received.
        """
        if isnan(self._count):
            self._count = count
        taken = not isnan(count) and count != self._count
        self._until_s = min(self._until_s, time_s + WORD_HOLDS_S)
        if self._waiting is None or taken or time_s >= self._until_s:
            self._waiting = None
            return []
        counted = CountedTime(self._encoders[-1].frame.signals[PROBE_TIME])
        values: dict[str, Value] = {**self._waiting, PROBE_TIME: counted.carried_s(time_s)}
        return [encoder.message(values) for encoder in self._encoders]
