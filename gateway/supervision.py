"""What arrives from the other node, judged frame by frame and cycle by cycle.

A node sends its frames once a cycle, the closing one (its heartbeat) last. A cycle is usable if
every frame came exactly once, intact, in sequence and in time.

A stray frame must not stop the loop, and a second sender must be detected. So a frame with a bad
CRC or a wrong length counts as not received: the cycle is still good if the right frame comes, too.
An intact frame that is repeated, out of sequence or late makes its cycle unusable: a second sender
knows the protection.

All frames of a cycle carry the same two counts: the alive counter of 15 values and the cycle count
of 16 (from the gateway: 4). Together they start anew only after 240 (60) cycles, so that a frame of
another cycle shows. A frame that was out of step for nearly so long could come round to the right
counts again: it is not trusted before its sender has started anew.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import nan

from gateway.codec import Problem, decode
from gateway.database import Frame
from gateway.e2e import COUNTERS, counter_of

FORWARD = COUNTERS // 2
"""A counter that is ahead by up to this means lost frames; by more, an old frame."""


@dataclass(frozen=True)
class Finding:
    """Something wrong: the kind of fault as the DBC names it, the frame, a text for people."""

    fault: str
    frame: Frame
    text: str


@dataclass(frozen=True)
class Cycle:
    """What one cycle of the other node brought.

    Attributes
    ----------
    usable : bool
        Whether every frame came as it must. Single signals may still be NaN.
    values : dict of str to float
        Every signal of the node; NaN where there is no value [unit of the signal].
    finding : Finding or None
        The first thing wrong.
    heartbeat : dict of str to float
        Signals of the closing frame, even if the cycle is not usable; empty in a silence.
    """

    usable: bool
    values: Mapping[str, float]
    finding: Finding | None
    heartbeat: Mapping[str, float]


@dataclass
class _Watch:
    """One frame: its counter, when it came last, and what this cycle knows of it."""

    frame: Frame
    timeout_s: float
    last: int | None = None
    counts: tuple[int, int] | None = None
    astray: int = 0
    seen_at: float = 0.0
    heard: bool = False
    missed: int = 0
    values: dict[str, float] | None = None
    problems: Sequence[Problem] = ()
    stray: Finding | None = None
    strict: list[Finding] = field(default_factory=list)

    def take(self, data: bytes | bytearray, now: float) -> str:
        """Judge one frame; return ``good``, or the fault."""
        size = self.frame.size
        if len(data) != size:
            return self._reject("wrong_length", f"has {len(data)} bytes instead of {size}")
        if not self.frame.protection.intact(data):
            return self._reject("bad_crc", "does not fit its CRC")
        self.heard = True
        fault = self._sequence(counter_of(data), now)
        self.missed = 0
        if fault in ("good", "late", "missing"):
            self.seen_at = now
            content = decode(self.frame, data)
            self.counts = counter_of(data), content.cycle
            self.values, self.problems = content.values, content.problems
        return fault

    def _sequence(self, counter: int, now: float) -> str:
        last, waited = self.last, now - self.seen_at
        if counter >= COUNTERS:
            return self._spoil("out_of_sequence", f"has the counter {counter}, which is never sent")
        if last is None:
            self.last, self.seen_at = counter, now
            return self._reject("startup", "was seen for the first time")
        ahead = (counter - last) % COUNTERS
        if ahead == 0 and self.missed < COUNTERS - 1:
            return self._spoil("repeated", f"came again with the counter {counter}")
        self.last = counter
        if waited > self.timeout_s:
            return self._spoil("late", f"came after {waited * 1e3:.0f} ms")
        if ahead <= self.missed + 1:
            return "good"
        if ahead <= FORWARD:
            return self._spoil("missing", f"is missing {ahead - 1} times before this one")
        self.seen_at = now
        return self._spoil("out_of_sequence", f"has the counter {counter} after {last}")

    def _reject(self, fault: str, text: str) -> str:
        self.stray = self.stray or Finding(fault, self.frame, f"{self.frame.name} {text}")
        return fault

    def _spoil(self, fault: str, text: str) -> str:
        self.strict.append(Finding(fault, self.frame, f"{self.frame.name} {text}"))
        return fault

    def _absence(self) -> Finding:
        if self.last is None:
            return Finding("startup", self.frame, f"{self.frame.name} has not been seen yet")
        return Finding("missing", self.frame, f"{self.frame.name} is missing")

    def _keep_step(self, closing: tuple[int, int] | None) -> Finding | None:
        """Compare the counts with those of the closing frame; None in a silence."""
        if closing is None:
            return None
        together = self.values is not None and self.counts == closing
        most = COUNTERS * (self.frame.cycles - 1)
        if self.astray >= most:
            text = f"was out of step for {most} cycles; its sender has to start anew"
            return Finding("delayed", self.frame, f"{self.frame.name} {text}")
        self.astray = 0 if together else self.astray + 1
        if together or self.values is None:
            return None
        return Finding("mixed_cycles", self.frame, f"{self.frame.name} belongs to another cycle")

    def closed(self, closing: tuple[int, int] | None) -> tuple[Finding | None, Finding | None]:
        """End the cycle; return what spoils it, and what is wrong with single signals.

        Parameters
        ----------
        closing : tuple of int, or None
            The counts of the closing frame; None in a silence.
        """
        spoilt = self._keep_step(closing)
        if self.strict:
            spoilt = self.strict[0]
            if spoilt.fault == "missing" and self.stray:
                spoilt = self.stray  # why it is missing
        elif self.values is None:
            spoilt = spoilt or self.stray or self._absence()
        # Only silence excuses a counter that has moved on; a stuck sender stays a fault.
        self.missed += not self.heard
        wrong: Finding | None = None
        if self.problems:
            first = self.problems[0]
            wrong = Finding(first.fault, self.frame, first.text)
        self.values, self.problems, self.stray, self.heard = None, (), None, False
        self.strict.clear()
        return spoilt, wrong


class Reception:
    """Judges the frames of one node.

    Parameters
    ----------
    frames : sequence of Frame
        All that the node sends, the closing one last.
    timeout_s : float, optional
        After which silence a frame is late; by default what the DBC says of each [s].

    Attributes
    ----------
    counts : Counter
        How many frames were good, and how many had each kind of fault.
    """

    def __init__(self, frames: Sequence[Frame], timeout_s: float | None = None) -> None:
        self._frames, self._timeout_s = tuple(frames), timeout_s
        self._closing = frames[-1].key
        self.counts: Counter[str] = Counter()
        self._nothing = dict.fromkeys((name for frame in frames for name in frame.signals), nan)
        self.reset()

    def reset(self) -> None:
        """Forget the counters: the next frame of each kind is taken as the first."""
        self._watches = {
            frame.key: _Watch(frame, self._timeout_s or frame.timeout_s) for frame in self._frames
        }

    def take(self, key: int, data: bytes | bytearray, now: float) -> Cycle | None:
        """Judge a frame that arrived at *now* [s]; return the cycle if this closes it."""
        watch = self._watches.get(key)
        if watch is None:
            self.counts["foreign"] += 1
            return None
        fault = watch.take(data, now)
        self.counts[fault] += 1
        closes = key == self._closing and fault in ("good", "late", "missing")
        return self._close(silent=False) if closes else None

    def renew(self) -> None:
        """Trust again the frames that keep step: their sender has started anew."""
        closing = self._watches[self._closing].counts
        for watch in self._watches.values():
            if watch.counts == closing:
                watch.astray = 0

    def silence(self) -> Cycle:
        """Return the cycle of a time in which the closing frame did not come."""
        return self._close(silent=True)

    def _close(self, *, silent: bool) -> Cycle:
        values = dict(self._nothing)
        for watch in self._watches.values():
            values.update(watch.values or {})
        heartbeat = {} if silent else self._watches[self._closing].values or {}
        counts = None if silent else self._watches[self._closing].counts
        spoilt: list[Finding] = []
        wrong: list[Finding] = []
        # The closing frame last, and in a silence first: it is what the silence is about.
        watches = list(self._watches.values())
        for watch in reversed(watches) if silent else watches:
            first, second = watch.closed(counts)
            spoilt += [first] if first else []
            wrong += [second] if second else []
        usable = not spoilt and not silent
        finding = next(iter([*spoilt, *wrong]), None)
        return Cycle(usable, values if usable else self._nothing, finding, heartbeat)
