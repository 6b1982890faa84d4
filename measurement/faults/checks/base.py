"""The base class of all checks of measured runs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

from measurement.faults.fault import Fault, Kind
from measurement.runs import Run


@dataclass(frozen=True)
class Seen:
    """The input of a check.

    Attributes
    ----------
    runs : sequence of Run
        Runs of one machine, as read.
    left : sequence of Run
        The same runs without the readings that earlier stages found unusable.
    faults : sequence of Fault
        Faults that earlier stages found.
    """

    runs: Sequence[Run]
    left: Sequence[Run]
    faults: Sequence[Fault]


class Check:
    """A check for one kind of problem in runs; a subclass overrides `in_run` or `find`.

    Attributes
    ----------
    kinds : dict of str to Kind
        The kinds of faults that it finds, by name.
    stage : int
        Later stages do not see what earlier ones have explained: a frozen channel catches up in a
        leap, and a leap looks like running away. 0: the record and frozen channels; 1: leaps;
        2: thermometers that run away; 3: the rest.
    """

    kinds: ClassVar[dict[str, Kind]]
    stage: ClassVar[int] = 3

    def in_run(self, run: Run) -> Iterable[Fault]:
        """Return the faults of one run, considered alone."""
        return ()

    def find(self, seen: Seen) -> Iterator[Fault]:
        """Return the faults of the runs; a fault's place is the index of its run."""
        for place, run in enumerate(seen.left):
            for fault in self.in_run(run):
                yield replace(fault, place=place)
