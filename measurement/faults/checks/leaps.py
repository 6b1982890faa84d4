"""Readings that leap: away and back, or to another level for good or for a while.

Real effects also leap near a switch of the machine: centrifugal force widens a shaft, a coolant
pump starts. So a change of level near a switch is a fault only if it is larger than any switch
causes; the limits are above what a floating bearing (20 um) and a chiller (3 K) do by themselves.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import ClassVar

import numpy as np

from measurement.faults.checks.base import Check
from measurement.faults.fault import LEFT_OUT, Fault
from measurement.faults.leaping import BESIDE, Moves, moves_of
from measurement.faults.series import FEWEST_SAMPLES, LASTS, lengths_of, stretches, unit_of
from measurement.faults.switches import near_switch, switched_after
from measurement.resampling import WRONG
from measurement.runs import Run
from measurement.units import split_column

BY_ITSELF = {"degC": 3.0, "um": 25.0}
"""Largest leap of a sound channel while nothing is switched [K, um]: a chiller's dead band, a
bearing that slips. Set on the planted faults."""
SWITCHED = {"degC": 15.0, "um": float("inf")}
"""Largest leap of a sound channel near a switch [K, um]. Set on the planted faults."""


class Leaps(Check):
    """Spikes, and steps that no switch of the machine explains."""

    kinds: ClassVar = {"spikes": LEFT_OUT, "step": LEFT_OUT}
    stage = 1

    def in_run(self, run: Run) -> Iterator[Fault]:
        """Return the spikes and steps of a run's thermometers and displacements."""
        # Number of rows near a switch, and of switches, before each row.
        near = np.r_[0, np.cumsum(near_switch(run))].tolist()
        switched = np.r_[0, 0, np.cumsum(switched_after(run))].tolist()
        for column in [*run.temperatures, *lengths_of(run)]:
            moves = moves_of(run, column)
            if len(moves.values) >= 2 * FEWEST_SAMPLES:
                yield from _of_channel(run, column, moves, near, switched)


def _of_channel(
    run: Run, column: str, moves: Moves, near: Sequence[int], switched: Sequence[int]
) -> Iterator[Fault]:
    unit = split_column(column)[1]
    large = [k for k in moves.leaps() if abs(moves.by[k]) > BY_ITSELF[unit]]
    spikes: dict[int, float] = {}
    until = -1
    for k in large:
        if k < until:
            continue
        by = float(moves.by[k])
        back = next((j for j in large if j > k and abs(moves.by[j] + by) < LASTS * abs(by)), None)
        last = len(moves.by) if back is None else back
        leaps, away = [k] if back is None else [k, back], range(k + 1, last + 1)
        if len(away) >= BESIDE > k + 1:  # the record leaves its first level at once
            leaps, away, by = [k], range(k + 1), -by
        if len(away) < BESIDE:
            # A short pulse of speed may move a shaft and back.
            if unit == "degC" or not all(_at_switch(moves, j, switched) for j in leaps):
                spikes |= dict.fromkeys(away, by)
            until = leaps[-1] + 1
        elif abs(by) > SWITCHED[unit] or not _near_switch(moves, k, near):
            before, after = moves.values[max(0, k - 4) : k + 1], moves.values[away][:5]
            step = float(np.median(after) - np.median(before))
            if abs(step - by) <= LASTS * abs(by):
                stays = "stays there" if back is None else "comes back"
                said = f"leaps by {step:+.3g} {unit_of(column)} and {stays}"
                yield _fault(
                    run, column, "step", moves, away, f"{said}, more than a switch explains"
                )
                # The leap back may come at a switch: someone has corrected the probe.
                until = last + 1
    yield from _spikes(run, column, moves, spikes)


def _spikes(run: Run, column: str, moves: Moves, spikes: Mapping[int, float]) -> Iterator[Fault]:
    """Return one fault for each reading that leaps away, or one for all if there are many."""
    unit, count = unit_of(column), len(moves.values)
    if len(spikes) > max(2.0, WRONG * count):
        most = max(map(abs, spikes.values()))
        text = f"{len(spikes)} readings leap away and come back, by up to {most:.3g} {unit}"
        yield _fault(run, column, "spikes", moves, range(count), f"{text}: it is not used")
        return
    for at, by in spikes.items():
        text = f"one reading leaps away by {by:+.3g} {unit} and comes back"
        if at == 0:
            text = f"the first reading is off by {by:+.3g} {unit} from the next ones"
        yield _fault(run, column, "spikes", moves, range(at, at + 1), text)


def _fault(run: Run, column: str, kind: str, moves: Moves, away: range, text: str) -> Fault:
    first, last = moves.rows[[away[0], away[-1]]].tolist()
    return Fault.between(run, column, kind, first, last, text)


def _at_switch(moves: Moves, k: int, switched: Sequence[int]) -> bool:
    """Return whether something was switched in the row of a leap or an adjacent one."""
    first, last = int(moves.rows[k]), int(moves.rows[k + 1])
    return switched[min(last + 2, len(switched) - 1)] > switched[first]


def _near_switch(moves: Moves, k: int, near: Sequence[int]) -> bool:
    """Return whether a switch is near, or came since the reading before a leap first appeared."""
    begun = int(moves.rows[stretches(moves.values[: k + 1])[0][-1]])
    return near[int(moves.rows[k + 1]) + 1] > near[begun]
