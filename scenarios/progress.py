"""Shows the progress of long work from its messages."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import NamedTuple

from tqdm import tqdm


class Stage(NamedTuple):
    """A part of long work: how its messages begin, its share of the time, how many it sends."""

    words: str
    share: float
    times: int


CALIBRATE = (Stage("iteration", 1.0, 10),)
"""The messages of calibration, which rarely needs all of its iterations."""

SPEAKS_S = tqdm.monitor_interval
"""Interval of lines if standard error is not a terminal [s]: that at which tqdm renews a bar."""

_STEP = (
    Stage("screening", 6.0, 1),
    Stage("scoring", 18.0, 12),
)

FIND_GAP = (
    Stage("looking for broken", 1.0, 1),
    Stage("iteration", 15.0, 10),
    *_STEP,
    *_STEP,
    Stage("judging", 2.0, 1),
    Stage("co-simulating", 8.0, 2),
)
"""The messages of the gap finder. There is a second step only if the first named something."""


class Fraction:
    """The fraction of the work that is done, from its messages; it never decreases.

    Parameters
    ----------
    stages : sequence of Stage
        In order. Stages may be skipped; messages of no stage change nothing.
    """

    def __init__(self, stages: Sequence[Stage]) -> None:
        self._stages = stages
        self._total = sum(stage.share for stage in stages)
        self._place, self._said = 0, 0

    def after(self, text: str) -> float:
        """Return the share of the work that is done when message *text* arrives [1]."""
        for place in range(self._place, len(self._stages)):
            if text.startswith(self._stages[place].words):
                self._said = self._said + 1 if place == self._place else 1
                self._place = place
                break
        before = sum(stage.share for stage in self._stages[: self._place])
        stage = self._stages[self._place]
        within = min(max(self._said - 1, 0) / stage.times, 1.0)
        return (before + stage.share * within) / self._total


@contextmanager
def spoken(quiet: bool = False, stages: Sequence[Stage] = ()) -> Iterator[Callable[[str], None]]:
    """Show what is being done on one line of the terminal, with the elapsed time.

    With *stages* a bar shows how much of them is done, and the time left. If standard error is not
    a terminal, a line is written every `SPEAKS_S`.

    Parameters
    ----------
    quiet : bool
        Whether to show nothing.
    stages : sequence of Stage
        The stages of the work, in order.

    Yields
    ------
    callable
        Takes each message about what is being done.
    """
    if not quiet and not sys.stderr.isatty():
        with _in_lines() as say:
            yield say
        return
    bar = "{percentage:3.0f} % |{bar}| " if stages else ""
    left = "<{remaining}" if stages else ""
    with tqdm(
        total=1.0 if stages else None,
        bar_format="{desc} " + bar + "[{elapsed}" + left + "]",
        file=sys.stderr,
        disable=quiet,
        leave=False,
    ) as line:
        fraction = Fraction(stages) if stages else None

        def say(text: str) -> None:
            line.set_description_str(text, refresh=False)
            line.update(0.0 if fraction is None else max(fraction.after(text) - line.n, 0.0))
            line.refresh()

        yield say


@contextmanager
def _in_lines() -> Iterator[Callable[[str], None]]:
    """Write a line about what is being done every `SPEAKS_S`."""
    began, doing, done = time.monotonic(), [""], threading.Event()

    def speak() -> None:
        while not done.wait(SPEAKS_S):
            print(f"{time.monotonic() - began:.0f} s: {doing[0]}", file=sys.stderr, flush=True)

    speaker = threading.Thread(target=speak, daemon=True)
    speaker.start()
    try:
        yield lambda text: doing.__setitem__(0, text)
    finally:
        done.set()
        speaker.join()
