"""Cuts a long log into runs, and finds which of them began warm."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt
import pandas as pd

from measurement.doubts.clock import rows_after
from measurement.errors import BadInput
from measurement.importing.joining import Log, padded
from measurement.importing.mapping import Mapping
from measurement.importing.stamps import DAY_S
from measurement.resampling import WARMS_K, FloatArray
from measurement.runs import HOUR_S, TIME, Run
from measurement.warm import WARM_START

FEWEST_PIECE_ROWS = 2
"""A run has a beginning and an end: given by arithmetic."""


@dataclass(frozen=True)
class Piece:
    """A run cut out of a log.

    Attributes
    ----------
    run : Run
        Its time starts at 0, unless the log is a single run that starts elsewhere.
    starts : str
        Start time by the recorder's clock; empty if unknown.
    rested_s : float
        Time from the last row of the previous run to its first; NaN for the first run [s].
    warm : bool or None
        Whether it began warm; None if unknown.
    """

    run: Run
    starts: str
    rested_s: float
    warm: bool | None


def split(log: Log, mapping: Mapping) -> tuple[list[Piece], list[str]]:
    """Cut a log into runs.

    Parameters
    ----------
    log : Log
    mapping : Mapping
        Its ``split``, ``pause_s`` and ``every_s`` are used.

    Returns
    -------
    pieces : list of Piece
        In order of time.
    notes : list of str
        What was left out.

    Raises
    ------
    BadInput
        If the log is to be cut by days and has no dates, or nothing is left.
    """
    time = log.frame[TIME].to_numpy()
    shown = _by_the_wall(log, mapping, time)
    cuts = _cuts(log, mapping, time, shown)
    parts = np.split(np.arange(len(time)), cuts)
    notes = [
        f"{log.name}: {len(part)} rows by themselves, {_at(log, shown[part[0]])}, are left out"
        for part in parts
        if len(part) < FEWEST_PIECE_ROWS
    ]
    notes += [
        f"{log.name}: the pause from {_at(log, time[cut - 1])} may be no pause: clocks were put "
        "forward by an hour then, and --timezone Europe/Berlin undoes it"
        for cut in cuts
        if log.absolute and not mapping.time.timezone and _is_put_forward(time, cut)
    ]
    # Dates tell better when clocks are put forward.
    leaps = [] if log.absolute else rows_after(Run(log.name, log.frame))
    notes += [
        f"{log.name}: the pause after {time[cut - 1]:g} s may be no pause: no temperature moves in "
        f"it. If the clock was put forward by an hour, subtract {HOUR_S:g} s from there on"
        for cut in leaps
        if cut in cuts
    ]
    kept = [part for part in parts if len(part) >= FEWEST_PIECE_ROWS]
    if not kept:
        raise BadInput(log.name, "", f"has no run of {FEWEST_PIECE_ROWS} rows or more")
    rests = [float("nan")] + [
        float(time[after[0]] - time[before[-1]]) for before, after in pairwise(kept)
    ]
    warm = warm_starts(log.frame, kept, rests, mapping.cold_after_s)
    names = _names(log, [shown[part[0]] for part in kept])
    pieces = []
    for part, name, rest, state in zip(kept, names, rests, warm, strict=True):
        frame = log.frame.iloc[part].reset_index(drop=True)
        frame[TIME] = np.round(frame[TIME].to_numpy() - time[part[0]], 6)
        if mapping.every_s:
            frame = Run(name, frame).resampled(mapping.every_s).frame
        if state is not None:
            frame = frame.assign(**{WARM_START: float(state)})
        pieces.append(Piece(Run(name, frame), _at(log, shown[part[0]]), rest, state))
    return pieces, notes


def _by_the_wall(log: Log, mapping: Mapping, time: FloatArray) -> FloatArray:
    """Return times as the clock on the wall showed them: with a known zone a log counts in UTC."""
    if not (log.absolute and mapping.time.timezone):
        return time
    there = pd.to_datetime(time, unit="s", utc=True).tz_convert(mapping.time.timezone)
    return np.asarray((there.tz_localize(None) - pd.Timestamp(0)).total_seconds())


def _cuts(log: Log, mapping: Mapping, time: FloatArray, shown: FloatArray) -> list[int]:
    if mapping.split == "none":
        return []
    cut = np.diff(time) > mapping.pause_s
    if mapping.split == "days":
        if not log.absolute:
            raise BadInput(log.name, "", "has no dates, so it cannot be split into days")
        cut |= np.diff(np.floor(shown / DAY_S)) > 0
    return [int(row) for row in np.flatnonzero(cut) + 1]


def _is_put_forward(time: FloatArray, row: int) -> bool:
    """Return whether a pause is only the hour skipped when summer time begins."""
    step = float(np.median(np.diff(time)))
    hour = pd.Timestamp(time[row - 1] + step, unit="s")
    zones = ("Europe/Berlin", "America/New_York")
    lost = any(
        hour.tz_localize(zone, nonexistent="NaT", ambiguous=True) is pd.NaT for zone in zones
    )
    return lost and abs(time[row] - time[row - 1] - step - HOUR_S) <= step


def _names(log: Log, starts: Sequence[float]) -> list[str]:
    if log.absolute:
        names = [pd.Timestamp(start, unit="s").strftime("%Y%m%d_%H%M") for start in starts]
        if len(set(names)) < len(names):
            names = [pd.Timestamp(start, unit="s").strftime("%Y%m%d_%H%M%S") for start in starts]
        return names
    stem = re.sub(r"[^\w.-]+", "_", log.name)
    if len(starts) == 1:
        return [stem]
    return padded([f"{stem}_{number}" for number in range(1, len(starts) + 1)])


def _at(log: Log, time_s: float) -> str:
    if log.absolute:
        return str(pd.Timestamp(time_s, unit="s").round("s"))
    return f"at {time_s:g} s"


def warm_starts(
    frame: pd.DataFrame,
    parts: Sequence[npt.NDArray[np.int64]],
    rests: Sequence[float],
    cold_after_s: float,
) -> list[bool | None]:
    """Return which runs of a log began warm.

    A machine that rested long enough is cold. After a shorter rest it is warm if a run since the
    last cold start has warmed it. The thermometers do not decide: at their places a spindle returns
    to the hall's temperature long before its structure does, when half of the drift may remain. How
    the first run of a log began is unknown.

    Parameters
    ----------
    frame : DataFrame
        The log's rows.
    parts : sequence of array
        The rows of each run.
    rests : sequence of float
        Rest before each run; NaN if unknown [s].
    cold_after_s : float
        Rest that is long enough [s].

    Returns
    -------
    list of bool or None
        For each run; None if unknown.
    """
    warm: list[bool | None] = []
    warmed = False
    for part, rest in zip(parts, rests, strict=True):
        if rest >= cold_after_s:
            warm.append(False)
            warmed = False
        elif not warm:
            warm.append(None)
        else:
            warm.append(True if warmed else warm[-1])
        warmed = warmed or _warms(frame.iloc[part])
    return warm


def _warms(rows: pd.DataFrame) -> bool:
    """Return whether a thermometer rises relative to the median of all: more than the hall does."""
    names = [name for name in rows.columns if str(name).endswith("_degC")]
    filled = rows[names].interpolate(limit_direction="both").to_numpy(dtype=np.float64)
    filled = filled[:, np.isfinite(filled).all(axis=0)]
    if not filled.size:
        return False
    middle = np.median(filled, axis=1, keepdims=True) if filled.shape[1] > 1 else filled[:1]
    apart = filled - middle
    return bool((apart.max(axis=0) - apart[0]).max() >= WARMS_K)
