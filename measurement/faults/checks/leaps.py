"""Readings that leap: away and back, to another level for good or for a while.

Real effects leap, too, near a switch of the machine: a shaft that centrifugal force widens, coolant
whose pump starts. A reading that leaves its neighbours on both sides at once is real nowhere; a
level left in one leap is not told near a switch, and the limits lie above what a floating bearing
(20 um) and a chiller's dead band (3 K) do.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

import numpy as np

from measurement.faults.checks.base import Check
from measurement.faults.fault import LEFT_OUT, Fault
from measurement.faults.series import (
    FEWEST_SAMPLES,
    LASTS,
    IntArray,
    lengths_of,
    running_median,
    scatter,
    unit_of,
    valid,
)
from measurement.faults.switches import BoolArray, near_switch, switched_after
from measurement.resampling import GAP_INTERVALS
from measurement.runs import FloatArray, Run
from measurement.units import split_column

SPIKE = {"degC": 4.0, "um": 20.0}
"""A reading that leaves the readings around it by more than this [K, um], and by more than
``TIMES`` the channel's usual scatter, is a spike."""
STEP = {"degC": 6.0, "um": 25.0}
"""A leap between two samples by more than this [K, um], and by more than ``TIMES`` the channel's
usual scatter, is a step if it lasts."""
AT_THE_ENDS = {"degC": 6.0, "um": 40.0}
"""The same for the first and the last reading, which nothing follows or precedes [K, um]: a shaft
that centrifugal force widens moves by 30 um between two samples."""
NEAR_TIMES = 2.5
"""A thermometer that leaps by so many times the limit is told near a switch, too [1]. Set on the
planted faults."""
TIMES = 12.0
"""Spikes and steps exceed this many times the channel's usual scatter [1]: a sensor that is read
every quarter of an hour rightly leaps. Set on the planted faults."""
MANY = 0.02
"""A channel with more spikes than this share of its samples is not used at all [1]: set on no
data."""


class Leaps(Check):
    """Spikes, and steps that no switch of the machine explains."""

    kinds: ClassVar = {"spikes": LEFT_OUT, "step": LEFT_OUT}
    stage = 1

    def in_run(self, run: Run) -> Iterator[Fault]:
        """Return the spikes and steps of a run's thermometers and displacements."""
        near, switched = near_switch(run), switched_after(run)
        for column in [*run.temperatures, *lengths_of(run)]:
            rows, values = valid(run, column)
            if len(values) >= 2 * FEWEST_SAMPLES:
                yield from _spikes(run, column, rows, values, switched)
                yield from _steps(run, column, rows, values, near)


def _spikes(
    run: Run, column: str, rows: IntArray, values: FloatArray, switched: BoolArray
) -> Iterator[Fault]:
    """Find readings that leap away and come back; at either end, that leave all beside them."""
    away = values - running_median(values)
    unit = split_column(column)[1]
    usual = TIMES * scatter(away)
    bad = np.abs(away) > max(SPIKE[unit], usual)
    if unit != "degC":
        bad &= ~_pulsed(rows, switched)
    for end, beside in ((0, values[1:]), (-1, values[-2::-1])):
        level = np.median(beside[:FEWEST_SAMPLES])
        gone = values[end] - level
        still = np.ptp(beside[:FEWEST_SAMPLES]) < LASTS * abs(gone)
        at = slice(rows[0], rows[1]) if end == 0 else slice(rows[-2], rows[-1])
        if abs(gone) > max(AT_THE_ENDS[unit], usual) and still and not switched[at].any():
            bad[end], away[end] = True, gone
    if not bad.any():
        return
    time = run.time_s
    worst = f"by up to {np.max(np.abs(away[bad])):.3g} {unit_of(column)}"
    if bad.sum() > max(2.0, MANY * len(values)):
        text = f"{bad.sum()} readings leap away and come back, {worst}: it is not used"
        yield Fault(run.name, column, "spikes", float(time[0]), float(time[-1]), text)
        return
    for i in np.flatnonzero(bad).tolist():
        text = f"one reading leaps away by {away[i]:+.3g} {unit_of(column)} and comes back"
        if i == 0:
            text = f"the first reading is {away[i]:+.3g} {unit_of(column)} from those after it"
        moment = float(time[rows[i]])
        yield Fault(run.name, column, "spikes", moment, moment, text)


def _pulsed(rows: IntArray, switched: BoolArray) -> BoolArray:
    """Return which readings lie between two switches: a short pulse may move them and be over."""
    count = np.r_[0, np.cumsum(switched)]
    first = rows[np.maximum(np.arange(len(rows)) - 3, 0)]
    last = rows[np.minimum(np.arange(len(rows)) + 3, len(rows) - 1)]
    return np.asarray(count[last] - count[first] >= 2)


def _steps(
    run: Run, column: str, rows: IntArray, values: FloatArray, near: BoolArray
) -> Iterator[Fault]:
    """Find leaps to another level; what comes after is bad until a leap back, if there is one."""
    time = run.time_s[rows]
    moves, intervals = np.diff(values), np.diff(time)
    unit = split_column(column)[1]
    limit = max(STEP[unit], TIMES * scatter(moves))
    watched = intervals <= GAP_INTERVALS * np.median(intervals)
    large = np.flatnonzero((np.abs(moves) > limit) & watched).tolist()
    until = -1
    for i in large:
        told = NEAR_TIMES * limit if unit == "degC" else np.inf
        if i <= until or (near[rows[i + 1]] and abs(moves[i]) < told):
            continue
        before, after = values[max(0, i - 4) : i + 1], values[i + 1 : i + 6]
        step = float(np.median(after) - np.median(before))
        if abs(step - moves[i]) > LASTS * abs(moves[i]) or min(len(before), len(after)) < 3:
            continue
        # The leap back may come at a switch: someone put the probe right.
        back = next((j for j in large if j > i and abs(moves[j] + step) < LASTS * abs(step)), None)
        until = len(values) - 1 if back is None else back
        stays = "stays there" if back is None else "comes back"
        text = f"leaps by {step:+.3g} {unit_of(column)} and {stays}, more than a switch explains"
        yield Fault(run.name, column, "step", float(time[i + 1]), float(time[until]), text)
