"""From run files and a rig to arrays: which sensors and which rows can be used."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from fmu_compensator.driving import late_line
from fmu_compensator.fit.columns import MeasuredColumns
from fmu_compensator.fit.features import LAGS_S
from fmu_compensator.fit.training import GRID_S, Array, TrainingRun, row_weights
from fmu_compensator.runtime.fields import is_name
from measurement.drift import counted, late_by
from measurement.errors import BadInput
from measurement.faults import (
    GROSS,
    LEVELS,
    STANDING,
    Fault,
    by_column,
    cleaned,
    find_faults,
    group_line,
)
from measurement.resampling import GAP_INTERVALS
from measurement.rig import Rig
from measurement.runs import Run
from measurement.units import column, split_column


@dataclass(frozen=True)
class PreparedRun:
    """One run's columns, including gaps.

    Attributes
    ----------
    name : str
        The run's name.
    time_s : array (n,)
        Time [s].
    temperatures : array (n, k)
        Readings of all usable sensors [degC]; NaN if missing or broken. Readings of a sensor that
        is sampled less often than the rest are interpolated linearly.
    inputs : array (n, k)
        The same in the input form [degC or K].
    targets : array (n, m)
        Measured targets, relative to their start in the rise form [um, urad].
    speed : array (n,)
        Spindle speed [rpm]; NaN if not recorded.
    usable : array (n,)
        False where a displacement cannot be used: frozen, saturated, a spike, a step.
    readings : array (n, k)
        The temperatures without interpolation: NaN between the readings of a slow sensor.
    late_s : float
        Time from the start until its drift begins to count [s].
    lost : str
        Which displacements have fewer than two usable readings, and why; empty if none.
    """

    name: str
    time_s: Array
    temperatures: Array
    inputs: Array
    targets: Array
    speed: Array
    usable: NDArray[np.bool_]
    readings: Array
    late_s: float
    lost: str

    def complete(self, columns: Sequence[int]) -> TrainingRun:
        """Return the rows in which the targets and the given inputs are complete."""
        run = self.history(columns)
        return run.at(run.known)

    def history(self, columns: Sequence[int]) -> TrainingRun:
        """Return the rows in which the given inputs are complete, with or without targets.

        A model that remembers earlier samples also needs the temperatures of a stop during which
        the displacement was frozen.
        """
        inputs = self.inputs[:, list(columns)]
        rows = np.asarray(np.isfinite(inputs).all(axis=1))
        known = rows & self.usable & np.asarray(np.isfinite(self.targets).all(axis=1))
        weights = np.zeros(len(rows))
        weights[known] = row_weights(self.time_s[known])
        targets = np.where(known[:, None], self.targets, np.nan)
        return TrainingRun(
            self.name,
            self.time_s[rows],
            inputs[rows],
            targets[rows],
            self.speed[rows],
            weights[rows],
        )


@dataclass(frozen=True)
class Prepared:
    """All runs, prepared.

    Attributes
    ----------
    runs : tuple of PreparedRun
        One per run given.
    sensors : tuple of str
        Signal names of the temperatures that every run has, in the first run's order.
    candidates : tuple of int
        Indices of the sensors that may be chosen.
    targets : tuple of str
        Signal names of the targets.
    notes : tuple of str
        What was left out, and what looks odd: one line each.
    """

    runs: tuple[PreparedRun, ...]
    sensors: tuple[str, ...]
    candidates: tuple[int, ...]
    targets: tuple[str, ...]
    notes: tuple[str, ...]

    @property
    def speedless(self) -> list[str]:
        """Names of the runs without any speed."""
        return [run.name for run in self.runs if not np.isfinite(run.speed).any()]

    def without_speed(self) -> Prepared:
        """Return the runs as if none had a speed."""
        unknown = (replace(run, speed=np.full(len(run.speed), np.nan)) for run in self.runs)
        return replace(self, runs=tuple(unknown))

    def readable(self, chosen: list[int]) -> list[int]:
        """Return the chosen sensors after checking that each has a usable reading in every run.

        Raises
        ------
        BadInput
            Names the first sensor without one, and the run.
        """
        for index, run in product(chosen, self.runs):
            if not np.isfinite(run.temperatures[:, index]).any():
                problem = f"has no usable reading in {run.name}: leave out either of them"
                raise BadInput("fit", f"points: {self.sensors[index]}", problem)
        return chosen


def prepare(
    runs: Sequence[Run],
    rig: Rig | MeasuredColumns,
    input_form: str = "rise",
    *,
    sensors: Sequence[str] | None = None,
    leave_out_frozen: bool = True,
) -> Prepared:
    """Return the runs' temperatures and measured targets as arrays.

    Parameters
    ----------
    runs : sequence of Run
        Run files.
    rig : rig of `measurement.rig`
        Meaning of the displacement columns.
    input_form : {"rise", "absolute", "level"}
        ``rise``: temperatures and targets are relative to their first valid sample in each run.
        ``level``: temperatures are as read and targets relative. A sensor whose level is wrong
        in some run is not a candidate, except in the rise form.
    sensors : sequence of str, optional
        Signal names of the temperatures to consider; by default all that the runs have.
    leave_out_frozen : bool
        Leave out rows in which a displacement is frozen or saturated.

    Raises
    ------
    BadInput
        If there is no run, one is given twice, no sensor is in all of them, or a sensor's name
        is not a valid signal name.
    """
    if not runs:
        raise BadInput("training runs", "", "at least one run is needed")
    refuse_repeated(runs, sensors)
    faults = find_faults(runs)
    notes = [group_line(group) for group in by_column(_of_interest(faults, rig))]
    left = cleaned(runs, faults, left_out(leave_out_frozen))
    common = _common_sensors(runs, left, sensors, notes)
    targets: tuple[str, ...] = ()
    prepared = []
    for run, kept in zip(runs, left, strict=True):
        frame = counted(rig.targets(kept), input_form)
        targets = tuple(split_column(str(name))[0] for name in frame.columns)
        prepared.append(_prepared_run(run, kept, rig, frame.to_numpy(float), common, input_form))
    notes += [line for run in prepared for line in late_line(run.name, run.late_s)]
    candidates = _candidates(prepared, common, input_form, faults, notes)
    return Prepared(tuple(prepared), common, candidates, targets, tuple(notes))


def refuse_repeated(runs: Sequence[Run], sensors: Sequence[str] | None = None) -> None:
    """Refuse a run that is given twice, in whatever file.

    Parameters
    ----------
    runs : sequence of Run
    sensors : sequence of str, optional
        Signal names of the temperatures that count; by default all.

    Raises
    ------
    BadInput
        Names both.
    """
    digests = [run.fingerprint(sensors) for run in runs]
    for number, run in enumerate(runs):
        first = digests.index(digests[number])
        if first < number:
            same = runs[first].path or runs[first].name
            raise BadInput(run.path or run.name, "", f"is the same run as {same}: give it once")


def left_out(frozen: bool) -> tuple[str, ...]:
    """Return the kinds of faults whose readings are not used, with or without standing sensors."""
    return tuple(kind for kind in GROSS if frozen or kind not in STANDING)


def _of_interest(faults: Sequence[Fault], rig: Rig | MeasuredColumns) -> list[Fault]:
    """Return the faults that affect a fit."""
    return [
        fault
        for fault in faults
        if (fault.is_gross or fault.kind in LEVELS)
        and (split_column(fault.column)[1] != "um" or fault.column in rig.columns)
    ]


def _common_sensors(
    runs: Sequence[Run], left: Sequence[Run], wanted: Sequence[str] | None, notes: list[str]
) -> tuple[str, ...]:
    sensors = []
    columns = [name for run in runs for name in run.temperatures]
    if wanted is not None:
        columns = [column(signal, "degC") for signal in wanted]
    for name in dict.fromkeys(columns):
        signal = split_column(name)[0]
        absent = [run.name for run in runs if not _mostly_there(run, name)]
        broken = [run.name for run in left if name in run.frame and run.frame[name].isna().all()]
        if absent:
            notes.append(f"{signal} is left out: missing in {first_of(absent)}")
        elif 2 * len(broken) >= len(left):
            notes.append(f"{signal} is left out: broken in {first_of(broken)}")
        elif not is_name(signal):
            raise BadInput(
                runs[0].path or runs[0].name,
                f"column {name}",
                "cannot be a signal's name: it must be a letter, then letters, digits or _",
            )
        else:
            sensors.append(signal)
    if not sensors:
        none = (
            f"none of {', '.join(map(str, wanted))}" if wanted else "no temperature column (_degC)"
        )
        raise BadInput("training runs", "", f"{none} is in all runs")
    return tuple(sensors)


def _mostly_there(run: Run, name: str) -> bool:
    if name not in run.frame:
        return False
    values = bridged(run.time_s, run.frame[name].to_numpy(float))
    return bool(np.isfinite(values).mean() > 0.5)


def bridged(time_s: Array, values: Array) -> Array:
    """Interpolate readings linearly over gaps of up to five of their usual intervals.

    At either end the nearest reading holds for one usual interval, because a slowly sampled sensor
    need not have a reading in the first row.

    Parameters
    ----------
    time_s : array, shape (n,)
        Increasing [s].
    values : array, shape (n,)
        NaN: missing. With fewer than two readings they are returned unchanged.
    """
    there = np.flatnonzero(np.isfinite(values))
    if len(there) < 2:
        return values
    known = time_s[there]
    usual = float(np.median(np.diff(known)))
    after = np.clip(np.searchsorted(known, time_s), 1, len(known) - 1)
    wide = known[after] - known[after - 1] > GAP_INTERVALS * usual
    inside = (time_s >= known[0]) & (time_s <= known[-1])
    near = np.minimum(np.abs(time_s - known[0]), np.abs(time_s - known[-1])) <= usual
    allowed = np.isfinite(values) | (inside & ~wide) | (~inside & near)
    return np.where(allowed, np.interp(time_s, known, values[there]), np.nan)


def moved_by(rises: Array) -> Array:
    """Return the range of temperatures on an even grid without noise, shape (m,) [K].

    It is the range of running medians over the shortest lag of the Gaussian, so any longer warm-up
    counts, regardless of how long the machine stands before and after it.

    Parameters
    ----------
    rises : array (n, m)
        Rises, one row a minute [K].
    """
    rows = round(LAGS_S[0] / GRID_S)
    return np.asarray(np.ptp(median_filter(rises, size=(rows, 1), mode="nearest"), axis=0))


def _lost(run: Run, left: Run, rig: Rig | MeasuredColumns) -> str:
    """Return which displacements have fewer than two readings left, and why."""
    reasons = []
    for name in rig.columns:
        if left.frame[name].count() >= 2 or len(run.frame) < 2:
            continue
        readings = run.frame[name].dropna()
        if len(readings) > 1 and readings.nunique() == 1:
            reasons.append(f"{name} reads exactly {readings.iloc[0]:g} um in every row")
        else:
            reasons.append(f"{name} is broken or missing in almost every row")
    return "; ".join(reasons)


def _prepared_run(
    run: Run,
    left: Run,
    rig: Rig | MeasuredColumns,
    targets: Array,
    sensors: Sequence[str],
    input_form: str,
) -> PreparedRun:
    columns = [left.frame[column(name, "degC")].to_numpy(float) for name in sensors]
    temperatures = np.column_stack([bridged(run.time_s, values) for values in columns])
    rows = len(temperatures)
    has_speed = "speed_rpm" in left.frame
    speed = left.frame["speed_rpm"].to_numpy(float) if has_speed else np.full(rows, np.nan)
    rise = input_form == "rise"
    return PreparedRun(
        run.name,
        run.time_s,
        temperatures,
        temperatures - first_valid(temperatures) if rise else temperatures,
        targets,
        speed,
        _live(run, left, rig),
        np.column_stack(columns),
        late_by(run.time_s, targets, input_form),
        _lost(run, left, rig),
    )


def first_valid(columns: Array) -> Array:
    """Return the first finite value of each column, shape (k,); NaN if there is none.

    Parameters
    ----------
    columns : array (n, k)
    """
    first = np.argmax(np.isfinite(columns), axis=0)
    return np.asarray(columns[first, np.arange(columns.shape[1])])


def _live(run: Run, left: Run, rig: Rig | MeasuredColumns) -> NDArray[np.bool_]:
    """Return the rows in which no displacement was removed."""
    out = [left.frame[name].isna() & run.frame[name].notna() for name in rig.columns]
    return ~np.asarray(np.any(out, axis=0))


def _candidates(
    runs: Sequence[PreparedRun],
    sensors: Sequence[str],
    input_form: str,
    faults: Sequence[Fault],
    notes: list[str],
) -> tuple[int, ...]:
    """Return the sensors that may be chosen, and note why others may not."""
    wrong = {fault.column for fault in faults if fault.kind in LEVELS}
    broken = {(fault.place, fault.column) for fault in faults if fault.is_gross}
    candidates = []
    for index, name in enumerate(sensors):
        unfit: dict[str, list[str]] = {}
        for place, run in enumerate(runs):
            is_broken = (place, column(name, "degC")) in broken
            reason = _unfit(run.temperatures[:, index], is_broken, input_form)
            if reason:
                unfit.setdefault(reason, []).append(run.name)
        if not moves(runs, index):
            unfit["constant in"] = [run.name for run in runs if not moves([run], index)]
        if unfit:
            reasons = "; ".join(f"{reason} {first_of(where)}" for reason, where in unfit.items())
            notes.append(f"{name} is no candidate: {reasons}")
        elif input_form != "rise" and column(name, "degC") in wrong:
            why = f"the {input_form} form would carry its wrong level into the offsets"
            notes.append(f"{name} is no candidate: {why}")
        else:
            candidates.append(index)
    return tuple(candidates)


def moves(runs: Sequence[PreparedRun], index: int) -> bool:
    """Return whether a temperature moves in most runs, so that it also does without a fifth of
    them.
    """
    readings = [run.temperatures[:, index] for run in runs]
    return 2 * sum(len(np.unique(here[np.isfinite(here)])) > 1 for here in readings) > len(runs)


def _unfit(values: Array, is_broken: bool, input_form: str) -> str:
    """Return why one run rules a sensor out; empty if it does not."""
    there = np.isfinite(values)
    if is_broken and there.mean() <= 0.5:
        return "broken for most of"
    if is_broken and input_form == "rise" and not there[0]:
        return "broken at the start of"
    return ""


def speedless_notes(*given: Prepared) -> list[str]:
    """Return a note if some of the runs, but not all, lack a speed, so that none is used."""
    lost = [name for prepared in given for name in prepared.speedless]
    if not 0 < len(lost) < sum(len(prepared.runs) for prepared in given):
        return []
    return [f"the spindle speed is not used: none in {first_of(sorted(lost))}"]


def first_of(names: Sequence[str]) -> str:
    """Return the first three names and how many more there are, as text."""
    shown = ", ".join(names[:3])
    return shown if len(names) <= 3 else f"{shown} and {len(names) - 3} more"
