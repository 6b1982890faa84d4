"""From run files and a rig to arrays: which sensors can be used, which rows are fit for use."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from fmu_compensator.fit.columns import MeasuredColumns
from fmu_compensator.fit.training import Array, TrainingRun, row_weights
from fmu_compensator.runtime.fields import is_name
from measurement.drift import counted
from measurement.errors import BadInput
from measurement.quality import look_over
from measurement.rig import Rig
from measurement.runs import Run
from measurement.units import column, split_column

FEWEST_FINITE = 0.5
"""A sensor with a smaller share of readings in some run counts as missing there [1]."""
LEVEL_JUMP_K = 10.0
"""A sensor whose level, against all others, is this far from its usual one has jumped [K]."""
STRAY_FACTOR = 3.0
"""A sensor strays in a run if it leaves the others this much further than in any other run [1]."""


@dataclass(frozen=True)
class PreparedRun:
    """One run's columns, gaps and all.

    Attributes
    ----------
    name : str
        The run's name.
    time_s : array (n,)
        Time [s].
    temperatures : array (n, k)
        Readings of all usable sensors [degC]; NaN where missing.
    inputs : array (n, k)
        The same in the input form [degC or K].
    targets : array (n, m)
        Measured targets, relative to their start in the rise form [um, urad].
    speed : array (n,)
        Spindle speed [rpm]; NaN where not recorded.
    usable : array (n,)
        False where a displacement is frozen or saturated.
    """

    name: str
    time_s: Array
    temperatures: Array
    inputs: Array
    targets: Array
    speed: Array
    usable: NDArray[np.bool_]

    def complete(self, columns: Sequence[int]) -> TrainingRun:
        """Return the rows in which the targets and some of the inputs are all there."""
        run = self.history(columns)
        return run.at(run.known)

    def history(self, columns: Sequence[int]) -> TrainingRun:
        """Return the rows in which some of the inputs are all there, with the targets or not.

        A model that remembers earlier samples needs the temperatures of a stop, too, in which the
        displacement was frozen.
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
    """All runs made ready.

    Attributes
    ----------
    runs : tuple of PreparedRun
        One per run given.
    sensors : tuple of str
        Signal names of the temperatures that every run has, in the first run's order.
    candidates : tuple of int
        Indices of those that move in every run.
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

    def without(self, index: int) -> tuple[PreparedRun, ...]:
        """Return all runs but one."""
        return self.runs[:index] + self.runs[index + 1 :]


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
        What the displacement columns mean.
    input_form : {"rise", "absolute", "level"}
        ``rise``: temperatures and targets are relative to their first valid sample in each run.
        ``level``: temperatures are as read and targets relative; a sensor whose level jumps
        between runs is not used then.
    sensors : sequence of str, optional
        Signal names of the temperatures to look at; by default all that the runs have.
    leave_out_frozen : bool
        Do not use rows in which a displacement is frozen or saturated (`measurement.quality`).

    Raises
    ------
    BadInput
        If there is no run, one is given twice, no sensor is in all of them, or a sensor's name
        cannot be the name of a signal.
    """
    if not runs:
        raise BadInput("training runs", "", "at least one run is needed")
    digests = [run.sha256 for run in runs]
    for number, run in enumerate(runs):
        first = digests.index(digests[number])
        if first < number:
            same = f"is the same run as {runs[first].name}: every run may be given once"
            raise BadInput("training runs", run.name, same)
    notes: list[str] = []
    common = _common_sensors(runs, sensors, notes)
    targets: tuple[str, ...] = ()
    prepared = []
    for run in runs:
        frame = counted(_targets(rig, run), input_form)
        targets = tuple(split_column(str(name))[0] for name in frame.columns)
        prepared.append(_prepared_run(run, frame.to_numpy(float), common, input_form))
        if leave_out_frozen:
            prepared[-1].usable[:] = _live(run, rig, notes)
    candidates = _candidates(prepared, common, notes)
    jumped = _level_jumps(prepared, common, input_form)
    notes += jumped.values()
    if input_form == "level":
        candidates = tuple(index for index in candidates if index not in jumped)
    return Prepared(tuple(prepared), common, candidates, targets, tuple(notes))


def _targets(rig: Rig | MeasuredColumns, run: Run) -> pd.DataFrame:
    try:
        return rig.targets(run)
    except BadInput as error:  # it names the rig; the user needs the run
        raise BadInput(run.path or run.name, error.place, error.problem) from None


def _common_sensors(
    runs: Sequence[Run], wanted: Sequence[str] | None, notes: list[str]
) -> tuple[str, ...]:
    sensors = []
    columns = [name for run in runs for name in run.temperatures]
    if wanted is not None:
        columns = [column(signal, "degC") for signal in wanted]
    for name in dict.fromkeys(columns):
        signal = split_column(name)[0]
        absent = [run.name for run in runs if not _mostly_there(run, name)]
        if absent:
            notes.append(f"{signal} is left out: missing in {_listed(absent)}")
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
    return bool(np.isfinite(run.frame[name].to_numpy(float)).mean() > FEWEST_FINITE)


def _prepared_run(run: Run, targets: Array, sensors: Sequence[str], input_form: str) -> PreparedRun:
    temperatures = run.frame[[column(name, "degC") for name in sensors]].to_numpy(float)
    rows = len(temperatures)
    has_speed = "speed_rpm" in run.frame
    speed = run.frame["speed_rpm"].to_numpy(float) if has_speed else np.full(rows, np.nan)
    rise = input_form == "rise"
    return PreparedRun(
        run.name,
        run.time_s,
        temperatures,
        temperatures - _first_valid(temperatures) if rise else temperatures,
        targets,
        speed,
        np.ones(rows, dtype=bool),
    )


def _first_valid(columns: Array) -> Array:
    """Return the first finite value of each column; NaN where there is none."""
    first = np.argmax(np.isfinite(columns), axis=0)
    return np.asarray(columns[first, np.arange(columns.shape[1])])


def longest_unchanged(time_s: Array, values: Array) -> float:
    """Return for how long a series stayed exactly the same at most [s]; missing values ignored."""
    return float(unchanged_for(time_s, values).max(initial=0.0))


def unchanged_for(time_s: Array, values: Array) -> Array:
    """Return for each sample since when the series shows this very value [s]; NaN carries on."""
    there = np.flatnonzero(np.isfinite(values))
    age = np.zeros(len(values))
    if len(there):
        changes = np.concatenate([[True], np.diff(values[there]) != 0])
        start = np.maximum.accumulate(np.where(changes, np.arange(len(there)), 0))
        age[there] = time_s[there] - time_s[there[start]]
    return age


def _live(run: Run, rig: Rig | MeasuredColumns, notes: list[str]) -> NDArray[np.bool_]:
    """Return which rows show no displacement that is frozen or at the end of its range."""
    dead = np.zeros(len(run.time_s), dtype=bool)
    for finding in look_over(run):
        if finding.kind in {"frozen", "saturated"} and finding.column in rig.columns:
            dead |= (run.time_s >= finding.start_s) & (run.time_s <= finding.end_s)
            notes.append(f"{run.name}: rows left out, {finding.column} is {finding.text}")
    return ~dead


def _candidates(
    runs: Sequence[PreparedRun], sensors: Sequence[str], notes: list[str]
) -> tuple[int, ...]:
    candidates = []
    strays = _strays(runs)
    for index, name in enumerate(sensors):
        still = [
            run.name
            for run in runs
            if np.nanmin(run.temperatures[:, index]) == np.nanmax(run.temperatures[:, index])
        ]
        if still:
            notes.append(f"{name} is not used: constant in {_listed(still)}")
        elif index in strays:
            run, away = strays[index]
            notes.append(f"{name} is not used: in {run} it strayed {away:+.0f} K from all others")
        else:
            candidates.append(index)
    return tuple(candidates)


def _strays(runs: Sequence[PreparedRun]) -> dict[int, tuple[str, float]]:
    """Return the sensors that left all others within one run, the run, and how far [K].

    Grouping by likeness would choose such a sensor first: nothing is like it.
    """
    if len(runs) < 2 or runs[0].temperatures.shape[1] < 3:
        return {}
    strayed = []
    for run in runs:
        rises = run.temperatures - _first_valid(run.temperatures)
        away = rises - np.nanmedian(rises, axis=1, keepdims=True)
        furthest = np.nanargmax(np.abs(away), axis=0)
        strayed.append(away[furthest, np.arange(away.shape[1])])
    size = np.abs(np.array(strayed))
    second = np.sort(size, axis=0)[-2]
    found = np.flatnonzero(size.max(axis=0) > np.maximum(LEVEL_JUMP_K, STRAY_FACTOR * second))
    return {
        int(index): (runs[worst].name, float(strayed[worst][index]))
        for index in found
        for worst in [int(np.argmax(size[:, index]))]
    }


def _level_jumps(
    runs: Sequence[PreparedRun], sensors: Sequence[str], input_form: str
) -> dict[int, str]:
    """Return a note for each sensor whose level differs between runs as no other's does."""
    if len(sensors) < 3 or len(runs) < 2:
        return {}
    level = np.array([np.nanmedian(run.temperatures, axis=0) for run in runs])
    against_others = level - np.median(level, axis=1, keepdims=True)
    away = against_others - np.median(against_others, axis=0)
    if input_form == "rise":
        outcome = "the rise form does not feel it"
    elif input_form == "level":
        outcome = "not used, the level form would carry it into the offsets"
    else:
        outcome = "WARNING: absolute temperatures carry it into the offsets; use the rise form"
    notes = {}
    for index, name in enumerate(sensors):
        odd = [run for run in range(len(runs)) if abs(away[run, index]) > LEVEL_JUMP_K]
        if odd:
            where = _listed([runs[run].name for run in odd])
            largest = max((away[run, index] for run in odd), key=abs)
            level_text = f"{name} reads {largest:+.0f} K from its usual level in {where}"
            notes[index] = f"{level_text}: {outcome}"
    return notes


def _listed(names: Sequence[str]) -> str:
    shown = ", ".join(names[:3])
    return shown if len(names) <= 3 else f"{shown} and {len(names) - 3} more"
