"""What arrives from the other node, judged frame by frame and put together.

One `Watch` a frame checks length, check value and counter, and keeps the newest content. One
`Reception` puts the frames of a node together, by one of two policies:

- *together*: a node sends its frames once a cycle, all with the same two counts, and the closing
  one (its heartbeat) last. A cycle is usable if every frame came exactly once, in sequence and in
  time. The two counts start anew together only after 240 (60) cycles, so that a frame of another
  cycle shows. A frame that was out of step for nearly so long could come round to the right counts
  again: it is not used before its cycle is proven to be fresh, or its sender has started anew.
- *sampled*: frames come at their own pace, and what is newest of each is looked at once a period.
  A frame, or a page of a multiplexed one, is late when it is older than allowed.

A stray frame must not stop the loop, and a second sender must be detected. So a frame with a bad
check value or a wrong length counts as not received; an intact one that is repeated or out of
sequence makes its cycle unusable, because a second sender knows the protection.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from math import inf, nan

from gateway.codec import Content, Finding, decode
from gateway.database import Frame, Substitute

TAKEN = ("good", "late", "missing")
"""Verdicts on a frame whose content is kept."""


@dataclass(frozen=True)
class Cycle:
    """What one cycle of the other node brought, or one look at its newest frames.

    Attributes
    ----------
    usable : bool
        Whether every frame came as it must. Single signals may still be NaN.
    values : dict of str to float
        Every signal of the node; NaN where there is no value [unit of the signal].
    finding : Finding or None
        The first thing wrong.
    wrong : sequence of Finding
        What does not spoil the cycle.
    heartbeat : dict of str to float
        Signals of the closing frame, even if the cycle is not usable; empty in a silence.
    frames : dict of int to bytes
        The bytes of the frames that came, by key.
    """

    usable: bool
    values: Mapping[str, float]
    finding: Finding | None
    heartbeat: Mapping[str, float]
    frames: Mapping[int, bytes] = field(default_factory=dict)
    wrong: Sequence[Finding] = ()


@dataclass
class _Page:
    """The newest content of a frame, or of one page of it."""

    needed: bool
    seen_at: float = -inf
    new: bool = False
    content: Content = field(default_factory=Content)


@dataclass
class Watch:
    """One frame: its counter, its newest content, and what was wrong since the last look."""

    frame: Frame
    timeout_s: float
    pages: dict[int | None, _Page]
    together: bool
    last: int | None = None
    in_step: bool = True
    seen_at: float = 0.0
    missed: int = 0
    heard: bool = False
    counts: tuple[int, int] | None = None
    astray: int = 0
    data: bytes = b""
    stray: Finding | None = None
    spoilt: Finding | None = None

    def take(self, data: bytes | bytearray, now: float) -> str:
        """Judge one frame; return ``good``, or the fault."""
        frame = self.frame
        if frame.longer:
            data = data[: frame.size]
        if len(data) != frame.size:
            text = f"has {len(data)} bytes instead of {frame.size}"
            return self._reject("wrong_length", text)
        if not frame.protection.intact(data):
            return self._reject("bad_crc", "does not fit its check value")
        try:
            content = decode(frame, data)
        except LookupError:
            return self._reject("out_of_range", "has a page that the DBC file does not know")
        self.heard = True
        fault = self._sequence(content.counter, now) if frame.protection.counter else "good"
        self.missed = 0
        page = self.pages.get(content.page)
        if fault in TAKEN and page is not None:
            self.seen_at = now
            self.counts, self.data = (content.counter, content.cycle), bytes(data)
            page.seen_at, page.new, page.content = now, True, content
        return fault

    def _sequence(self, counter: int, now: float) -> str:
        count = self.frame.protection.counters
        if counter >= count:
            return self._spoil("out_of_sequence", f"has the counter {counter}, which is never sent")
        last, waited = self.last, now - self.seen_at
        if last is None:
            self.last, self.seen_at = counter, now
            return self._reject("startup", "was seen for the first time")
        ahead = (counter - last) % count
        if ahead == 0 and self.missed < count - 1:
            return self._spoil("repeated", f"came again with the counter {counter}")
        self.last = counter
        if self.together and waited > self.timeout_s:
            self.in_step = True
            return self._spoil("late", f"came after {waited * 1e3:.0f} ms")
        expected = ahead <= self.missed + 1
        if not expected and ahead > max(count // 2, 1):
            self.in_step, self.seen_at = False, now
            return self._spoil("out_of_sequence", f"has the counter {counter} after {last}")
        if not self.in_step:
            # Two senders take turns in being out of sequence: one good frame proves nothing.
            self.in_step = expected
            return self._spoil("out_of_sequence", f"has the counter {counter} after {last}")
        if expected:
            return "good"
        # Where frames are sampled, those lost are no matter while the newest is fresh.
        if self.together:
            self._spoil("missing", f"is missing {ahead - 1} times before this one")
        return "missing"

    def _finding(self, fault: str, text: str) -> Finding:
        return Finding(fault, self.frame, f"{self.frame.name} {text}")

    def _reject(self, fault: str, text: str) -> str:
        self.stray = self.stray or self._finding(fault, text)
        return fault

    def _spoil(self, fault: str, text: str) -> str:
        if not self.together:
            return self._reject(fault, text)
        self.spoilt = self.spoilt or self._finding(fault, text)
        return fault

    def _absence(self, number: int | None, page: _Page, now: float) -> Finding:
        if self.stray is not None:
            return self.stray  # why it is missing
        what = "" if number is None else f"page {number} "
        if self.last is None and page.seen_at == -inf:
            return self._finding("startup", f"{what}has not been seen yet")
        age = "" if self.together else f": it is {now - page.seen_at:.3f} s old"
        return self._finding("missing", f"{what}is missing{age}")

    def _out_of_step(self, closing: tuple[int, int] | None) -> Finding | None:
        """Compare the counts with those of the closing frame; None in a silence."""
        if closing is None or not self.together:
            return None
        here = any(page.new for page in self.pages.values())
        together = here and self.counts == closing
        most = self.frame.protection.counters * (self.frame.cycles - 1)
        if self.astray >= most:
            return self._finding("delayed", f"was out of step for {most} cycles")
        self.astray = 0 if together else self.astray + 1
        if together or not here:
            return None
        return self._finding("mixed_cycles", "belongs to another cycle")

    def close(
        self, now: float, closing: tuple[int, int] | None, values: dict[str, float]
    ) -> tuple[Finding | None, list[Finding]]:
        """Take the values that can be used; return what spoils the cycle, and what does not.

        Parameters
        ----------
        now : float
            The time [s].
        closing : tuple of int, or None
            The counts of the closing frame; None in a silence, or where frames are sampled.
        values : dict
            Takes the values.
        """
        spoilt = self._out_of_step(closing)
        if self.spoilt is not None:
            lost = self.spoilt.fault == "missing" and self.stray is not None
            spoilt = self.stray if lost else self.spoilt
        elif not self.in_step:
            spoilt = self.stray
        wrong = list[Finding]()
        # What several pages hold is taken from the newest.
        for number, page in sorted(self.pages.items(), key=lambda item: item[1].seen_at):
            fresh = page.new if self.together else now - page.seen_at <= self.timeout_s
            if fresh and page.seen_at > -inf:
                values.update(page.content.values)
                wrong += page.content.problems
            elif page.needed and spoilt is None:
                spoilt = self._absence(number, page, now)
            page.new = False
        # Only silence excuses a counter that has moved on; a stuck sender stays a fault.
        self.missed += self.together and not self.heard
        if self.stray and not wrong:
            wrong = [self.stray]
        self.stray = self.spoilt = None
        self.heard = False
        return spoilt, wrong


class Reception:
    """Judges the frames of one node.

    Parameters
    ----------
    frames : sequence of Frame
        All that the node sends in a cycle, the closing one last.
    together : bool, optional
        They come once a cycle, and the last one closes it; otherwise each at its own pace.
    optional : collection of str, optional
        Signals that may be missing: something stands for them.
    timeout_s : float, optional
        After which silence a frame is late; by default what the DBC or the map says of each [s].
    look_after : int, optional
        Where frames are sampled, the key of one after which to look.

    Attributes
    ----------
    counts : Counter
        How many frames were good, and how many had each kind of fault.
    """

    def __init__(
        self,
        frames: Sequence[Frame],
        *,
        together: bool = True,
        optional: Collection[str] | Mapping[str, Substitute] = (),
        timeout_s: float | None = None,
        look_after: int | None = None,
    ) -> None:
        self._frames, self._timeout_s, self.together = tuple(frames), timeout_s, together
        self._optional = frozenset(optional)
        self._closing = frames[-1].key if together else look_after
        self.counts: Counter[str] = Counter()
        self._nothing = dict.fromkeys((name for frame in frames for name in frame.signals), nan)
        self.reset()

    def reset(self) -> None:
        """Forget what was heard: the next frame of each kind is taken as the first."""
        self._watches = {frame.key: self._watch(frame) for frame in self._frames}

    def _watch(self, frame: Frame) -> Watch:
        pages = {page: _Page(self._needed(frame, page)) for page in frame.pages}
        timeout_s = self._timeout_s or frame.timeout_s
        return Watch(frame, timeout_s, pages, self.together)

    def _needed(self, frame: Frame, page: int | None) -> bool:
        return self.together or any(
            signal.page == page and name not in self._optional
            for name, signal in frame.signals.items()
        )

    def take(self, key: int, data: bytes | bytearray, now: float) -> Cycle | None:
        """Judge a frame that arrived at *now* [s]; return the cycle if this closes it."""
        watch = self._watches.get(key)
        if watch is None:
            self.counts["foreign"] += 1
            return None
        fault = watch.take(data, now)
        self.counts[fault] += 1
        return self.look(now) if key == self._closing and fault in TAKEN else None

    def renew(self) -> None:
        """Trust again the frames that keep step with the closing one."""
        closing = self._watches[self._frames[-1].key].counts
        for watch in self._watches.values():
            if watch.counts == closing:
                watch.astray = 0

    def look(self, now: float, *, silent: bool = False) -> Cycle:
        """Return what there is at *now* [s]: a cycle that closes, or the newest of all frames.

        Parameters
        ----------
        now : float
            The time [s].
        silent : bool, optional
            The closing frame did not come, or the bus is lost.
        """
        values, came = dict(self._nothing), {}
        closing = self._watches[self._frames[-1].key]
        heartbeat: Mapping[str, float] = {}
        if self.together and not silent:
            heartbeat = next(iter(closing.pages.values())).content.values
        counts = closing.counts if self.together and not silent else None
        spoilt: list[Finding] = []
        wrong: list[Finding] = []
        # The closing frame last, and in a silence first: it is what the silence is about.
        watches = list(self._watches.values())
        for watch in reversed(watches) if silent else watches:
            if any(page.new for page in watch.pages.values()):
                came[watch.frame.key] = watch.data
            first, second = watch.close(now, counts, values)
            spoilt += [first] if first else []
            wrong += second
        usable = not (spoilt or silent)
        finding = next(iter([*spoilt, *wrong]), None)
        heartbeat = heartbeat if self.together else {} if silent else values
        values = values if usable else self._nothing
        return Cycle(usable, values, finding, heartbeat, came, wrong)


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
