"""What is grossly wrong with single channels: readings that no physics of a machine explains.

Readings that leap away and come back, a level left in one leap, a thermometer that runs away from
all others, one that stands still while the others move. The checks are blind near a switch of
speed, feed or torque, where readings may rightly leap, and their limits lie above what real effects
do: a floating bearing that slips moves the nose by 20 um at most, a chiller's dead band the coolant
by 3 K.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt

from measurement.quality import FROZEN_S, FROZEN_SAMPLES, Finding
from measurement.resampling import GAP_INTERVALS
from measurement.runs import FloatArray, Run
from measurement.units import UNITS, split_column

BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.int64]

SPIKE = {"degC": 4.0, "um": 20.0}
"""A reading that leaves the readings around it by more is a spike [K, um], if also by ..."""
STEP = {"degC": 6.0, "um": 25.0}
"""A leap between two samples that lasts is a step [K, um], if also by ..."""
TIMES = 12.0
"""... this many times the channel's usual scatter [1]."""
LASTS = 0.3
"""A leap lasts if the levels before and after it differ by it, but for this share [1]."""
MANY = 0.02
"""A channel with more spikes than this share of its samples is not used at all [1]."""

RUNAWAY_K = 10.0
"""A thermometer that moves by this much against the middle of all others [K] within ..."""
RUNAWAY_S = 1800.0
"""... this time [s], with no switch in it or ..."""
SETTLING_S = 3600.0
"""... so long before it [s], has run away."""
BEGUN = 0.1
"""It began when it had gone this share of the way [1]."""
NEAR_S = 300.0
"""Time around a switch in which readings may leap [s]."""

OTHERS_MOVED_K = 2.0
"""A thermometer that stands still is frozen only if half of the others moved by this much [K]"""
MOVED_STEPS = 8.0
"""and by this many steps of its own resolution [1],"""
STILL_SAMPLES = 10
"""for so many samples,"""
UNUSUALLY = 3.0
"""it stood still this many times longer than it does otherwise [1],"""
FEWEST_STEPS = 8
"""and its readings over all runs span at least so many steps of its resolution."""
NOISY = 0.5
"""A channel repeats its reading in a smaller share of samples if noise moves it [1]."""
WHOLE = 0.95
"""A thermometer that stands still for this share of a run is dead in it [1]."""

_NOT_READINGS = ("offset_", "error_")  # computed by a plant
_SWITCHED = ("rpm", "mm_min", "Nm", "W", "lpm")
_SWITCH_SHARE = 0.02


def broken_readings(runs: Sequence[Run]) -> list[tuple[Run, Finding]]:
    """Return what is grossly wrong with single channels, run by run.

    Parameters
    ----------
    runs : sequence of Run

    Returns
    -------
    list of (Run, Finding)
        Of the kinds ``spikes``, ``step``, ``runaway``, ``frozen``, ``saturated`` and ``dead``, the
        last three of thermometers only: `measurement.quality` looks at displacements that stand
        still.
    """
    found = []
    for run in runs:
        switched = near_switch(run)
        for column in _readings(run):
            found += [(run, one) for one in _spikes(run, column, switched)]
            found += [(run, one) for one in _steps(run, column, switched)]
        found += [(run, one) for one in _runaways(run)]
    found += list(_standing(runs))
    # A thermometer that runs away may well do so in leaps: that is told once.
    fled = {(run.name, one.column) for run, one in found if one.kind == "runaway"}
    return [
        (run, one) for run, one in found if one.kind != "step" or (run.name, one.column) not in fled
    ]


def near_switch(run: Run, before_s: float = NEAR_S, after_s: float = NEAR_S) -> BoolArray:
    """Return which rows are near a switch of speed, feed, torque, power or flow, shape (rows,)."""
    time = run.time_s
    # What was switched before the first sample is not known.
    near: BoolArray = time <= time[0] + after_s
    for unit in _SWITCHED:
        for column in run.of_unit(unit):
            values = run.frame[column].ffill().bfill().to_numpy()
            moves = np.abs(np.diff(values))
            limit = _SWITCH_SHARE * float(np.ptp(values))
            for at in np.flatnonzero((moves > limit) & (moves > 0.0)).tolist():
                near |= (time >= time[at] - before_s) & (time <= time[at + 1] + after_s)
                # Coarse sampling: the samples on both sides belong to it, however far apart.
                near[max(0, at - 1) : at + 3] = True
    return near


def _readings(run: Run) -> list[str]:
    lengths = [name for name in run.displacements if not name.startswith(_NOT_READINGS)]
    return [*run.temperatures, *lengths]


def _valid(run: Run, column: str) -> tuple[IntArray, FloatArray]:
    """Return the rows that have a reading, and the readings."""
    values = run.frame[column].to_numpy()
    rows = np.flatnonzero(np.isfinite(values))
    return rows, values[rows]


def _unit(column: str) -> str:
    unit = split_column(column)[1]
    return "K" if unit == "degC" else UNITS[unit].suffix


def _scatter(values: FloatArray) -> float:
    """Return a standard deviation that outliers do not move."""
    return 1.4826 * float(np.median(np.abs(values - np.median(values))))


def _running_median(values: FloatArray) -> FloatArray:
    """Return the median of each value and the two on each side."""
    windows = np.lib.stride_tricks.sliding_window_view(np.pad(values, 2, mode="edge"), 5)
    return np.asarray(np.median(windows, axis=1))


def _spikes(run: Run, column: str, switched: BoolArray) -> Iterator[Finding]:
    """Find single readings that leap away and come back."""
    rows, values = _valid(run, column)
    if len(values) < 2 * FROZEN_SAMPLES:
        return
    away = values - _running_median(values)
    limit = max(SPIKE[split_column(column)[1]], TIMES * _scatter(away))
    bad = (np.abs(away) > limit) & ~switched[rows]
    if not bad.any():
        return
    time = run.time_s
    worst = f"by up to {np.max(np.abs(away[bad])):.3g} {_unit(column)}"
    if bad.sum() > MANY * len(values):
        text = f"{bad.sum()} readings leap away and come back, {worst}: it is not used"
        yield Finding("spikes", column, float(time[0]), float(time[-1]), text)
        return
    for i in rows[bad].tolist():
        text = f"one reading leaps away and comes back at {time[i] / 60:.0f} min, {worst}"
        yield Finding("spikes", column, float(time[i]), float(time[i]), text)


def _steps(run: Run, column: str, switched: BoolArray) -> Iterator[Finding]:
    """Find the first leap to another level; what comes after it is bad."""
    rows, values = _valid(run, column)
    if len(values) < 2 * FROZEN_SAMPLES:
        return
    time = run.time_s[rows]
    moves, intervals = np.diff(values), np.diff(time)
    limit = max(STEP[split_column(column)[1]], TIMES * _scatter(moves))
    leaps = (np.abs(moves) > limit) & ~switched[rows[1:]]
    leaps &= intervals <= GAP_INTERVALS * np.median(intervals)
    for i in np.flatnonzero(leaps).tolist():
        before, after = values[max(0, i - 4) : i + 1], values[i + 1 : i + 6]
        step = float(np.median(after) - np.median(before))
        # What comes back from standing still catches up; `measurement.quality` tells of it.
        stood = len(before) == 5 and np.ptp(before) == 0.0
        if abs(step - moves[i]) > LASTS * abs(moves[i]) or stood or len(after) < 3:
            continue
        text = (
            f"leaps by {step:+.3g} {_unit(column)} at {time[i + 1] / 60:.0f} min and stays there, "
            "with no switch of the machine near"
        )
        yield Finding("step", column, float(time[i + 1]), float(time[-1]), text)
        return


def _runaways(run: Run) -> Iterator[Finding]:
    """Find thermometers that leave all others while nothing was switched."""
    names, time = run.temperatures, run.time_s
    if len(names) < 3 or len(time) < 2 * FROZEN_SAMPLES:
        return
    table = run.frame[names].interpolate(limit_direction="both").to_numpy()
    known = np.isfinite(table).all(axis=0)
    moving = np.r_[0, np.cumsum(near_switch(run, after_s=SETTLING_S))]
    back = np.searchsorted(time, time - RUNAWAY_S)
    quiet = moving[1:] == moving[back]
    for place in np.flatnonzero(known).tolist():
        others = np.delete(table[:, known], int(known[:place].sum()), axis=1)
        if others.shape[1] < 2:
            return
        away = _running_median(table[:, place] - np.median(others, axis=1))
        moved = np.where(quiet, away - away[back], 0.0)
        gone = np.flatnonzero(np.abs(moved) >= RUNAWAY_K)
        if not gone.size:
            continue
        i, first = int(gone[0]), int(back[gone[0]])
        level, way = float(away[first]), float(away[i] - away[first])
        begun = first + int(np.argmax((away[first : i + 1] - level) / way > BEGUN))
        end = float(np.median(away[i:])) - level
        text = (
            f"runs away from all other thermometers from {time[begun] / 60:.0f} min on, by "
            f"{end:+.0f} K, with no switch of the machine near"
        )
        yield Finding("runaway", names[place], float(time[begun]), float(time[-1]), text)


def _standing(runs: Sequence[Run]) -> Iterator[tuple[Run, Finding]]:
    """Find thermometers that stand still while the others move, unlike at other times."""
    names = dict.fromkeys(name for run in runs for name in run.temperatures)
    for column in names:
        having = [run for run in runs if column in run.frame]
        everything = np.concatenate([_valid(run, column)[1] for run in having])
        levels = np.unique(everything)
        resolution = float(np.diff(levels).min()) if len(levels) > 1 else 0.0
        if len(levels) > 1 and np.ptp(levels) < FEWEST_STEPS * resolution:
            continue
        ends = (levels[0], levels[-1]) if len(levels) > 1 else ()
        noisy = _repeats(having, column, ends) < NOISY
        spans = [_stood(run, column) for run in having]
        for run, (start, end, rest, value) in zip(having, spans, strict=True):
            extreme = value in ends
            elsewhere = [
                span[1] - span[0]
                for other, span in zip(having, spans, strict=True)
                # A noisy channel that stands at its extreme in several runs ends there.
                if other is not run and not (noisy and extreme and span[3] == value)
            ]
            usual = max(rest, float(np.median(elsewhere)) if len(levels) > 1 and elsewhere else 0.0)
            if end - start <= max(FROZEN_S, UNUSUALLY * usual):
                continue
            moved = _others_moved(run, column, start, end)
            if moved < max(OTHERS_MOVED_K, MOVED_STEPS * resolution):
                continue
            whole = end - start >= WHOLE * float(run.time_s[-1] - run.time_s[0])
            kind = "dead" if whole else "saturated" if extreme else "frozen"
            text = (
                f"exactly {value:g} degC for {(end - start) / 60:.0f} min from "
                f"{start / 60:.0f} min on while half of the others moved by {moved:.1f} K or more"
            )
            yield run, Finding(kind, column, start, end, text)


def _repeats(runs: Sequence[Run], column: str, ends: Sequence[float]) -> float:
    """Return how often a reading that is not at the channel's *ends* repeats the one before [1]."""
    same = count = 0
    for run in runs:
        values = _valid(run, column)[1]
        inside = ~np.isin(values[1:], ends)
        same += int(np.sum((np.diff(values) == 0.0) & inside))
        count += int(inside.sum())
    return same / max(count, 1)


def _stood(run: Run, column: str) -> tuple[float, float, float, float]:
    """Return when a channel stood still longest, how long else at most [s], and its reading.

    Start and end come first [s]; the reading is NaN if the channel never stood still.
    """
    rows, values = _valid(run, column)
    if len(values) < FROZEN_SAMPLES:
        return 0.0, 0.0, 0.0, float("nan")
    cuts = np.flatnonzero(np.diff(values) != 0.0) + 1
    firsts, lasts = np.r_[0, cuts], np.r_[cuts, len(values)] - 1
    time = run.time_s[rows]
    lengths = time[lasts] - time[firsts]
    longest = int(np.argmax(lengths))
    if lasts[longest] - firsts[longest] + 1 < STILL_SAMPLES:
        return 0.0, 0.0, 0.0, float("nan")
    rest = np.delete(lengths, longest)
    start, end = float(time[firsts[longest]]), float(time[lasts[longest]])
    return start, end, float(rest.max(initial=0.0)), float(values[firsts[longest]])


def _others_moved(run: Run, column: str, start: float, end: float) -> float:
    """Return by how much half of the other thermometers moved in the meantime [K]."""
    part = run.frame[(run.time_s >= start) & (run.time_s <= end)]
    others = part[[name for name in run.temperatures if name != column]].to_numpy()
    if not others.size:
        return 0.0
    spread = np.nan_to_num(np.nanmax(others, axis=0) - np.nanmin(others, axis=0))
    return float(np.median(spread))
