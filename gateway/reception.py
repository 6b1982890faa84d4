"""Checks the frames of the other node one by one, and assembles them.

For each frame a `Watch` checks length, check value and counter, and keeps the newest content. A
`Reception` assembles the frames of a node, by one of two policies:

- *together*: a node sends its frames once a cycle, all with the same two counts, and the closing
  one (its heartbeat) last. A cycle is usable if every frame came exactly once, in sequence and in
  time. The two counts repeat together only after 240 (60) cycles of the machine (the gateway), so a
  frame of another cycle is detected. A frame that was out of step for nearly that long could have
  the right counts again: it is not used until its cycle is proven to be fresh or its sender has
  restarted.
- *sampled*: frames come at their own pace, and the newest of each is read once a period. A frame,
  or a page of a multiplexed one, is late if it is older than allowed.

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
"""Verdicts with which a frame's content is kept."""


@dataclass(frozen=True)
class Cycle:
    """The content of one cycle of the other node, or of its newest frames.

    Attributes
    ----------
    usable : bool
        Whether every frame came as required. Single signals may still be NaN.
    values : dict of str to float
        Every signal of the node; NaN if it has no value [unit of the signal].
    finding : Finding or None
        The first problem.
    wrong : sequence of Finding
        Problems that leave the cycle usable.
    heartbeat : dict of str to float
        The same of the frames that came, even if the cycle is not usable; empty in a silence.
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
    """Watches one frame: its counter, its newest content, and the problems since the last look."""

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
        """Check one frame; return ``good`` or the fault."""
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
            self.in_step = self.in_step and self.together  # or a second sender, next to the first
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
            # Two senders alternate in being out of sequence, so one good frame proves nothing.
            self.in_step = expected
            return self._spoil("out_of_sequence", f"has the counter {counter} after {last}")
        if expected:
            return "good"
        # If frames are sampled, lost ones do not matter as long as the newest is fresh.
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
        age = f": it is {now - page.seen_at:.3f} s old"
        age = "" if self.together or page.seen_at == -inf else age
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
        """Take the usable values; return the fatal problem, if any, and the harmless ones.

        Parameters
        ----------
        now : float
            The time [s].
        closing : tuple of int, or None
            The counts of the closing frame; None in a silence, or if frames are sampled.
        values : dict
            Filled with the values.
        """
        spoilt = self._out_of_step(closing)
        if self.spoilt is not None:
            lost = self.spoilt.fault == "missing" and self.stray is not None
            spoilt = self.stray if lost else self.spoilt
        elif not self.in_step:
            spoilt = self.stray
        wrong = list[Finding]()
        # A signal on several pages is taken from the newest.
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
    """Checks and assembles the frames of one node.

    Parameters
    ----------
    frames : sequence of Frame
        All frames that the node sends in a cycle, the closing one last.
    together : bool, optional
        Whether frames come once a cycle, which the last one closes, or each at its own pace.
    optional : collection of str, optional
        Signals that may be missing, because something replaces them.
    timeout_s : float, optional
        Silence after which a frame is late; by default each frame's own, from the DBC or map [s].
    look_after : int, optional
        If frames are sampled, the key of a frame whose arrival triggers a look.

    Attributes
    ----------
    counts : Counter
        Number of good frames, and of frames with each kind of fault.
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
        """Forget all frames: the next one of each kind counts as the first."""
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
        """Check a frame that arrived at *now* [s]; return the cycle if the frame closes it."""
        watch = self._watches.get(key)
        if watch is None:
            self.counts["foreign"] += 1
            return None
        fault = watch.take(data, now)
        self.counts[fault] += 1
        return self.look(now) if key == self._closing and fault in TAKEN else None

    def renew(self) -> None:
        """Trust the frames that are in step with the closing one again."""
        closing = self._watches[self._frames[-1].key].counts
        for watch in self._watches.values():
            if watch.counts == closing:
                watch.astray = 0

    def look(self, now: float, *, silent: bool = False) -> Cycle:
        """Return the content at *now* [s]: of a closing cycle, or of the newest frames.

        Parameters
        ----------
        now : float
            The time [s].
        silent : bool, optional
            Whether the closing frame did not come or the bus is lost.
        """
        values, came = dict(self._nothing), {}
        closing = self._watches[self._frames[-1].key]
        counts = closing.counts if self.together and not silent else None
        spoilt: list[Finding] = []
        wrong: list[Finding] = []
        # The closing frame comes last, but first in a silence, which is its absence.
        watches = list(self._watches.values())
        for watch in reversed(watches) if silent else watches:
            if any(page.new for page in watch.pages.values()):
                came[watch.frame.key] = watch.data
            first, second = watch.close(now, counts, values)
            spoilt += [first] if first else []
            wrong += second
        usable = not (spoilt or silent)
        finding = next(iter([*spoilt, *wrong]), None)
        taken = values if usable else self._nothing
        return Cycle(usable, taken, finding, {} if silent else values, came, wrong)


class Substitution:
    """Replaces inputs without a value as the map requires.

    Parameters
    ----------
    substitutes : mapping of str to Substitute
        By input name.
    """

    def __init__(self, substitutes: Mapping[str, Substitute]) -> None:
        self._substitutes = substitutes
        self._last: dict[str, tuple[float, float]] = {}

    def fill(self, values: Mapping[str, float], now: float) -> dict[str, float]:
        """Return the values of a usable cycle, with missing ones replaced."""
        filled = dict(values)
        for name, substitute in self._substitutes.items():
            value = filled.get(name, nan)
            if value == value:
                self._last[name] = value, now
            elif substitute.value is not None:
                filled[name] = substitute.value
            else:
                last, at = self._last.get(name, (nan, -inf))
                filled[name] = last if now - at <= substitute.hold_s else nan
        return filled
