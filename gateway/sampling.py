"""Frames that come at their own pace: the newest value of each signal, and how old it is.

A control's own frames share no counts and no start of a cycle. So each is checked by itself, and
once a period the newest values of all are taken as one sample. A frame, or a page of a multiplexed
frame, is late when it is older than its map allows. If a signal of it is needed, the whole sample
is unusable. A frame with a bad check value, a wrong length, or an unchanged counter counts as not
received.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import inf, nan

from gateway.codec import Problem, decode, name_of
from gateway.database import Frame, Signal, Substitute
from gateway.judging import Verdict
from gateway.supervision import Cycle, Finding


@dataclass
class _Page:
    """The newest content of a frame, or of one page of it."""

    needed: bool
    seen_at: float = -inf
    values: dict[str, float] = field(default_factory=dict)
    problems: Sequence[Problem] = ()


@dataclass
class _Watch:
    """One frame: its counter, its pages, and what was wrong since the last look."""

    frame: Frame
    timeout_s: float
    pages: dict[int | None, _Page]
    last: int | None = None
    in_step: bool = True
    stray: Finding | None = None

    def take(self, data: bytes | bytearray, now: float) -> str:
        """Judge one frame; return ``good``, or the fault."""
        frame = self.frame
        if len(data) != frame.size:
            text = f"has {len(data)} bytes instead of {frame.size}"
            return self._reject("wrong_length", text)
        if not frame.protection.intact(data):
            return self._reject("bad_crc", "does not fit its check value")
        try:
            content = decode(frame, data)
        except LookupError:
            return self._reject("out_of_range", "has a page that the DBC file does not know")
        fault = self._sequence(content.counter) if frame.protection.counter else "good"
        page = self.pages.get(content.page)
        if fault not in ("good", "missing") or page is None:
            return fault
        page.seen_at, page.values, page.problems = now, content.values, content.problems
        return fault

    def _sequence(self, counter: int) -> str:
        count = self.frame.protection.counters
        if counter >= count:
            return self._reject("out_of_sequence", f"has the counter {counter}, never sent")
        last, self.last = self.last, counter
        if last is None:
            return self._reject("startup", "was seen for the first time")
        ahead = (counter - last) % count
        if ahead == 0:
            return self._reject("repeated", f"came again with the counter {counter}")
        if ahead > max(count // 2, 1):
            self.in_step = False
            return self._reject("out_of_sequence", f"has the counter {counter} after {last}")
        if not self.in_step:
            # Two senders take turns in being out of sequence: one good frame proves nothing.
            self.in_step = ahead == 1
            return self._reject("out_of_sequence", f"has the counter {counter} after {last}")
        return "good" if ahead == 1 else "missing"

    def _reject(self, fault: str, text: str) -> str:
        self.stray = self.stray or Finding(fault, self.frame, f"{self.frame.name} {text}")
        return fault

    def look(self, now: float, values: dict[str, float]) -> tuple[Finding | None, Finding | None]:
        """Take the values that are not late; return what spoils the look, and what does not."""
        spoilt, wrong = (None, self.stray) if self.in_step else (self.stray, None)
        # What several pages hold is taken from the newest.
        for page in sorted(self.pages.values(), key=lambda page: page.seen_at):
            age = now - page.seen_at
            if age <= self.timeout_s and age < inf:
                values.update(page.values)
                for problem in page.problems[:1]:
                    wrong = wrong or Finding(problem.fault, self.frame, problem.text)
            elif page.needed and spoilt is None:
                spoilt = self._late(age)
        self.stray = None
        return spoilt, wrong

    def _late(self, age: float) -> Finding:
        if self.stray is not None:
            return self.stray  # why it is late
        if age == inf:
            return Finding("startup", self.frame, f"{self.frame.name} has not been seen yet")
        return Finding("missing", self.frame, f"{self.frame.name} is {age:.3f} s old")


class Sampling:
    """Judges the frames of one node, each by itself.

    Parameters
    ----------
    frames : sequence of Frame
        All that the node sends.
    optional : mapping of str to object, optional
        Signals that may be missing: something stands for them.
    timeout_s : float, optional
        How old a frame may be; by default what the map says of each [s].
    closing : int, optional
        The key of the frame after which to look: where the frames do come together.

    Attributes
    ----------
    counts : Counter
        How many frames were good, and how many had each kind of fault.
    """

    def __init__(
        self,
        frames: Sequence[Frame],
        optional: Mapping[str, object] | None = None,
        timeout_s: float | None = None,
        closing: int | None = None,
    ) -> None:
        self._frames, self._timeout_s, self._closing = tuple(frames), timeout_s, closing
        self._optional = set(optional or ())
        self.counts: Counter[str] = Counter()
        self._nothing = dict.fromkeys((name for frame in frames for name in frame.signals), nan)
        self.reset()

    def reset(self) -> None:
        """Forget what was heard."""
        self._watches = {
            frame.key: _Watch(
                frame,
                self._timeout_s or frame.timeout_s,
                {page: _Page(self._needed(frame, page)) for page in frame.pages},
            )
            for frame in self._frames
        }

    def _needed(self, frame: Frame, page: int | None) -> bool:
        return any(
            signal.page == page and name not in self._optional
            for name, signal in frame.signals.items()
        )

    def renew(self) -> None:
        """Do nothing: no frame is distrusted for good."""

    def take(self, key: int, data: bytes | bytearray, now: float) -> Cycle | None:
        """Judge a frame that arrived at *now* [s]; return a look if it is the one to look after."""
        watch = self._watches.get(key)
        if watch is None:
            self.counts["foreign"] += 1
            return None
        fault = watch.take(data, now)
        self.counts[fault] += 1
        return self.look(now) if key == self._closing and fault in ("good", "missing") else None

    def look(self, now: float) -> Cycle:
        """Return what there is at *now* [s]."""
        values = dict(self._nothing)
        spoilt: list[Finding] = []
        wrong: list[Finding] = []
        for watch in self._watches.values():
            first, second = watch.look(now, values)
            spoilt += [first] if first else []
            wrong += [second] if second else []
        finding = next(iter([*spoilt, *wrong]), None)
        return Cycle(not spoilt, values if not spoilt else self._nothing, finding, values)

    def silence(self) -> Cycle:
        """Return the look at a bus that is lost."""
        return Cycle(False, self._nothing, None, {})


class StateJudge:
    """Judges a look by what the machine says that it does; there is no time of its own.

    Parameters
    ----------
    frame : Frame
        Whose signals say it, or any where nothing does.
    states : Signal or None
        What says it; None: a machine whose frames come is running.
    """

    raw = 0

    def __init__(self, frame: Frame, states: Signal | None) -> None:
        self._frame, self._states = frame, states

    def forget(self) -> None:
        """Expect nothing in particular: frames were lost."""

    def judge(self, cycle: Cycle, arrived: float, now: float, *, begun: bool) -> Verdict:
        """Judge a look; see `judging.Judge`."""
        state = "running"
        if self._states is not None:
            state = name_of(self._states, cycle.heartbeat.get("machine_state", nan))
        if not cycle.usable or state == "running":
            return Verdict(cycle.usable, cycle.finding, state)
        text = f"the machine is {state.replace('_', ' ')}"
        return Verdict(False, Finding("machine_not_running", self._frame, text), state)


class Substitution:
    """Puts what the map says in the place of inputs without a value.

    Parameters
    ----------
    substitutes : mapping of str to Substitute
        By the name of the input.
    """

    def __init__(self, substitutes: Mapping[str, Substitute]) -> None:
        self._substitutes = substitutes
        self._last: dict[str, tuple[float, float]] = {}

    def fill(self, values: Mapping[str, float], now: float) -> dict[str, float]:
        """Return the values of a cycle that can be used, with none missing that need not be."""
        found = dict(values)
        for name, substitute in self._substitutes.items():
            value = found.get(name, nan)
            if value == value:
                self._last[name] = value, now
            elif substitute.value is not None:
                found[name] = substitute.value
            else:
                last, at = self._last.get(name, (nan, -inf))
                found[name] = last if now - at <= substitute.hold_s else nan
        return found
