"""What every check of measured runs shares."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

from measurement.faults.fault import Fault, Kind
from measurement.runs import Run


@dataclass(frozen=True)
class Seen:
    """What a check looks at.

    Attributes
    ----------
    runs : sequence of Run
        As they were read; all belong together.
    left : sequence of Run
        The same without the readings that checks of earlier stages found unusable.
    faults : sequence of Fault
        What those found.
    """

    runs: Sequence[Run]
    left: Sequence[Run]
    faults: Sequence[Fault]


class Check:
    """One thing that may be wrong with runs; a subclass overrides `in_run` or `find`.

    Attributes
    ----------
    kinds : dict of str to Kind
        The kinds of faults that it finds, by name.
    stage : int
        What one check explains away, a later one must not see: what stood still catches up in a
        leap, and a leap looks like running away. 0: the record and what stands still; 1: leaps;
        2: thermometers that run away; 3: the rest.
    """

    kinds: ClassVar[dict[str, Kind]]
    stage: ClassVar[int] = 3

    def in_run(self, run: Run) -> Iterable[Fault]:
        """Return what is wrong with one run, without regard to the others."""
        return ()

    def find(self, seen: Seen) -> Iterator[Fault]:
        """Return what is wrong with the runs; a fault's place is that of its run among them."""
        for place, run in enumerate(seen.left):
            for fault in self.in_run(run):
                yield replace(fault, place=place)
