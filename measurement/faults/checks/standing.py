"""Channels that stay exactly constant while the machine moves: frozen, dead, at end of range.

A repeated reading alone proves nothing: it also occurs on a machine at rest, with a coarse sensor,
or with slow sampling. Other channels must contradict it. A displacement is frozen if temperatures
or other displacements move meanwhile. A thermometer is frozen if it reached its value in one leap;
if it stays constant far longer than otherwise while half of the others move far more than its
resolution; or if the others, from how it followed them at other times, predict that it moved.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import ClassVar

import numpy as np

from measurement.faults.checks.base import Check, Seen
from measurement.faults.checks.leaps import BY_ITSELF
from measurement.faults.fault import LEFT_OUT, Fault
from measurement.faults.leaping import leap_odds
from measurement.faults.series import (
    FEWEST_SAMPLES,
    UNUSUALLY,
    lengths_of,
    resolution_of,
    stretches,
    unit_of,
    valid,
)
from measurement.faults.witnesses import Witnesses
from measurement.resampling import FINEST_K, GAP_INTERVALS, WARMS_K
from measurement.runs import FloatArray, Run
from measurement.units import split_column

FROZEN_S = 900.0
"""A channel that is exactly constant for longer is checked [s]. Continuing thermal drift leaves a
sensor's resolution step within a quarter of an hour. Set on the planted faults."""
MOVING_UM = 5.0
"""If another displacement changes by this much meanwhile, the machine is not at rest [um]: more
than any resolution step. A displacement that returns from a standstill this far away has moved
unseen. Set on no data."""


class Standing(Check):
    """Channels whose reading is exactly constant while the machine moves."""

    kinds: ClassVar = {"frozen": LEFT_OUT, "saturated": LEFT_OUT, "dead": LEFT_OUT}
    stage = 0

    def find(self, seen: Seen) -> Iterator[Fault]:
        """Return the thermometers and displacements that are frozen."""
        yield from _thermometers(seen.runs)
        yield from super().find(seen)

    def in_run(self, run: Run) -> Iterator[Fault]:
        """Return the displacements that stay constant while other channels move."""
        for name in lengths_of(run):
            rows, values = valid(run, name)
            for first, last in _long(run.time_s[rows], values, FEWEST_SAMPLES):
                start, end = int(rows[first]), int(rows[last])
                moved = _what_moved(run, name, start, end)
                if moved is None:
                    continue
                text = f"exactly {values[first]:g} {unit_of(name)} while {moved}"
                kind = "frozen"
                if _at_end_of_range(run, name, start, end):
                    kind = "saturated"
                    text += "; it is the channel's own extreme: the end of the sensor's range"
                yield Fault.between(run, name, kind, start, end, text)


def _thermometers(runs: Sequence[Run]) -> Iterator[Fault]:
    """Find thermometers that stay constant while the others move, unlike at other times."""
    witnesses = Witnesses(runs)
    for column in dict.fromkeys(name for run in runs for name in run.temperatures):
        having = {place: run for place, run in enumerate(runs) if column in run.frame}
        readings = np.concatenate([valid(run, column)[1] for run in having.values()])
        if not len(readings):
            continue
        resolution, span = resolution_of(list(having.values()), column), float(np.ptp(readings))
        longest = {place: _lengths(run, column).max(initial=0.0) for place, run in having.items()}
        for place, run in having.items():
            elsewhere = [longest[other] for other in having if other != place and span > 0.0]
            usual_s = float(np.median(elsewhere or [0.0]))
            # Its resolution may be coarser in this run than in the others.
            finest = max(resolution, resolution_of([run], column))
            coarse = 0.0 < span < UNUSUALLY * resolution
            asked = partial(witnesses.moved, place, column)
            for fault in _stands(run, column, finest, math.inf if coarse else usual_s, asked):
                yield replace(fault, place=place)


def _stands(
    run: Run,
    column: str,
    finest: float,
    usual_s: float,
    told_by_others: Callable[[float, float], float],
) -> Iterator[Fault]:
    """Find where one thermometer is frozen in one run.

    Parameters
    ----------
    finest : float
        Its resolution [K].
    usual_s : float
        How long it stays constant in other runs [s]; infinite if its readings span too few steps to
        judge by that.
    told_by_others : callable
        From a span [s] to how far it must have moved [K].
    """
    enough = max(WARMS_K, UNUSUALLY * finest)
    rows, values = valid(run, column)
    time = run.time_s[rows]
    lengths = _lengths(run, column)
    for first, last in _long(time, values, 2 * FEWEST_SAMPLES):
        start, end = int(rows[first]), int(rows[last])
        length = float(time[last] - time[first])
        rest = lengths[lengths < length]
        habit = max(float(rest.max(initial=0.0)), usual_s)
        dropped = _dropped(time, values, first)
        why = ""
        if dropped:
            why = f"after a leap of {dropped:+.3g} K"
        if not why and length > UNUSUALLY * habit:
            moved = _half_moved(run, column, start, end)
            if moved >= enough:
                why = f"while half of the others moved by {moved:.1f} K or more"
        if not why and rest.size and length > UNUSUALLY * float(np.median(rest)):
            by_others = told_by_others(float(time[first]), float(time[last]))
            if by_others >= enough:
                why = f"while the others suggest that it moved by {by_others:.1f} K"
        if why:
            dead = last == len(values) - 1 and (first == 0 or dropped)
            text = f"exactly {values[first]:g} degC {why}"
            kind = "dead" if dead else "frozen"
            yield Fault.between(run, column, kind, start, end, text)


def _long(time: FloatArray, values: FloatArray, samples: int) -> Iterator[tuple[int, int]]:
    """Yield the first and last index of the stretches to check."""
    if not values.size:
        return
    firsts, lasts = stretches(values)
    long = (time[lasts] - time[firsts] > FROZEN_S) & (lasts - firsts + 1 >= samples)
    yield from zip(firsts[long].tolist(), lasts[long].tolist(), strict=True)


def _lengths(run: Run, column: str) -> FloatArray:
    """Return the duration of each stretch of two or more equal readings [s]."""
    rows, values = valid(run, column)
    if not values.size:
        return np.zeros(0)
    firsts, lasts = stretches(values)
    lengths = run.time_s[rows[lasts]] - run.time_s[rows[firsts]]
    return np.asarray(lengths[lasts > firsts])


def _dropped(time: FloatArray, values: FloatArray, first: int) -> float:
    """Return the leap [K] with which a reading became constant; 0 if it got there slowly."""
    if not first or time[first] - time[first - 1] > GAP_INTERVALS * np.median(np.diff(time)):
        return 0.0
    leap = float(values[first] - np.median(values[max(0, first - FEWEST_SAMPLES) : first]))
    # It may take two samples: one may be read while the wire breaks.
    for at in range(max(first - 1, 1), first + 1):
        odds = leap_odds(np.r_[values[:at], values[first:]], FINEST_K)
        if odds[at - 1] > 0.0 and abs(leap) > BY_ITSELF["degC"]:
            return leap
    return 0.0


def _half_moved(run: Run, column: str, start: int, end: int) -> float:
    """Return by how much half of the other thermometers moved meanwhile [K]."""
    others = [name for name in run.temperatures if name != column]
    if not others:
        return 0.0
    part = run.frame[others].to_numpy()[start : end + 1]
    spread = np.max(np.where(np.isnan(part), -np.inf, part), axis=0) - np.min(
        np.where(np.isnan(part), np.inf, part), axis=0
    )
    return float(np.median(np.maximum(spread, 0.0)))


def _what_moved(run: Run, name: str, start: int, end: int) -> str | None:
    """Return in words what moved most between two samples, or None if nothing did."""
    part = run.frame.iloc[start : end + 1]
    for others, enough, unit in (
        (run.temperatures, WARMS_K, "K"),
        ([other for other in lengths_of(run) if other != name], MOVING_UM, "um"),
    ):
        moved = {other: _spread(part[other].to_numpy()) for other in others}
        most = max(moved, key=moved.__getitem__, default=None)
        if most is not None and moved[most] >= enough:
            return f"{split_column(most)[0]} moved by {moved[most]:.1f} {unit}"
    return None


def _spread(values: FloatArray) -> float:
    """Return the range without the outermost 5 % on each side, which ignores one bad sample."""
    values = values[~np.isnan(values)]
    return float(np.subtract(*np.percentile(values, [95, 5]))) if values.size else 0.0


def _at_end_of_range(run: Run, name: str, start: int, end: int) -> bool:
    """Return whether the standstill is at the end of the sensor's range.

    That is, at the channel's own extreme, and either further from all others than these are from
    each other, or reached while the spindle was turning: a channel that freezes at a stop is at its
    extreme by chance.
    """
    values = run.frame[name].to_numpy()
    value = values[start]
    others = values[~np.isnan(values) & (values != value)]
    if not others.size or others.min() < value < others.max():
        return False
    far = float(np.abs(others - value).min()) > float(np.ptp(others)) > 0.0
    speeds = run.of_unit("rpm")
    if far or not speeds:
        return True
    turning = run.frame[speeds[0]].ffill().to_numpy()[start : end + 1] != 0.0
    return bool(turning.mean() > 0.5)
