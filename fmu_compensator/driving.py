"""Drive a compensator through a recorded run."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from math import isnan, nan

import numpy as np
from numpy.typing import NDArray

from fmu_compensator.fit.training import GRID_S, Array
from fmu_compensator.runtime.compensator import WAITING, Output, RunningCompensator
from fmu_compensator.runtime.modelfile import Model
from measurement.drift import counted, late_by, measured_drift, predicted_drift
from measurement.errors import BadInput
from measurement.resampling import GAP_INTERVALS, past_rounding
from measurement.rig import AXES, Rig
from measurement.runs import Run


@dataclass(frozen=True)
class Driven:
    """What a compensator did in a run.

    Attributes
    ----------
    time_s : array (n,)
        Times of the rows used [s].
    outputs : list of Output
        Output after each row.
    drift : array (n, 3)
        Measured drift of the tool tip along X, Y, Z; NaN if not measured [um].
    input_form : str
        Determines the reference of the drift: see `measurement.drift.counted`.
    """

    time_s: Array
    outputs: list[Output]
    drift: Array
    input_form: str

    @property
    def status(self) -> NDArray[np.int_]:
        """Status code of each row."""
        return np.array([output.status for output in self.outputs])

    @property
    def started(self) -> NDArray[np.bool_]:
        """Whether the compensator has started, row by row."""
        return np.asarray(self.status != WAITING)

    @property
    def error(self) -> Array:
        """Remaining drift, shape (n, 3); NaN if unknown [um]."""
        return np.where(self.started[:, None], self.drift - self.predicted, np.nan)

    @property
    def predicted(self) -> Array:
        """The drift that the offsets compensate, shape (n, 3) [um]."""
        sent = np.array([output[:3] for output in self.outputs])
        return predicted_drift(sent, self.drift, self.input_form)

    @property
    def half_width(self) -> Array:
        """Half width of the interval, shape (n, 3); NaN if unknown [um]."""
        width = np.array([output[6:9] for output in self.outputs])
        return np.where(width >= 0.0, width, np.nan)


def drive(
    model: Model,
    run: Run,
    left: Run,
    rig: Rig | None,
    tool_length_mm: float,
    *,
    probe_every_s: float | None = None,
) -> Driven:
    """Return what a compensator does in a run.

    Parameters
    ----------
    model : Model
    run : Run
        With the thermometers that the model uses; it gets their raw readings.
    left : Run
        The same run without broken readings, for the measured drift.
    rig : Rig, optional
        Meaning of the displacements; without it, or without its columns in the run, the drift is
        unknown.
    tool_length_mm : float
        Tool length at which the drift is taken.
    probe_every_s : float, optional
        Pass the run's own targets this often, like a probe without noise [s].

    Raises
    ------
    BadInput
        If a thermometer or a speed that the model uses is missing.
    """
    drift = _drift(model, left, rig, tool_length_mm)
    rows = rows_used(run.time_s, drift)
    time_s = run.time_s[rows]
    probes = _probes(model, left, rig, rows, probe_every_s)
    readings, speed = inputs_of(model, run)
    inputs = zip(time_s, readings[rows], speed[rows], probes, strict=True)
    outputs = list(answers(model, inputs, tool_length_mm))
    return Driven(time_s, outputs, drift[rows], model.input_form)


def inputs_of(model: Model, run: Run) -> tuple[Array, Array]:
    """Return the inputs of a compensator from a run's rows.

    Parameters
    ----------
    model : Model
    run : Run
        Of n rows; the model has k thermometers.

    Returns
    -------
    readings : array (n, k)
        Readings of its thermometers, `held` as a control does [degC]. NaN if missing.
    speed : array (n,)
        [rpm]; NaN if not recorded.

    Raises
    ------
    BadInput
        If a thermometer or a speed that the model uses is missing.
    """
    refuse_lacking(model, run)
    nothing = np.full(len(run.time_s), np.nan)
    columns = [f"{sensor.name}_degC" for sensor in model.sensors]
    readings = [
        held(run.time_s, run.frame[name].to_numpy(float)) if name in run.frame else nothing
        for name in columns
    ]
    speed = run.frame["speed_rpm"].to_numpy(float) if "speed_rpm" in run.frame else nothing
    return np.column_stack(readings), held(run.time_s, speed)


def refuse_lacking(model: Model, run: Run) -> None:
    """Refuse a run without a thermometer or a speed that a compensator uses.

    Parameters
    ----------
    model : Model
    run : Run

    Raises
    ------
    BadInput
        Names the first missing one.
    """
    used = [model.sensors[index].name for index in model.chosen]
    lost = next((name for name in used if f"{name}_degC" not in run.frame), None)
    if lost is not None:
        there = ", ".join(run.temperatures) or "none"
        problem = (
            "is missing, and the compensator uses it; if the thermometer is broken, leave the "
            f"column empty; the run's temperatures: {there}"
        )
        raise BadInput(run.path or run.name, f"column {lost}_degC", problem)
    known = "speed_rpm" in run.frame and run.frame["speed_rpm"].notna().any()
    if model.uses_speed and not known:
        problem = "holds no speed, and the compensator uses it: fit one without (fit --no-speed)"
        raise BadInput(run.path or run.name, "column speed_rpm", problem)


def learnt_as(model: Model, run: Run) -> str | None:
    """Return the name of a run among those that a compensator learnt from; None if it is not one.

    Parameters
    ----------
    model : Model
    run : Run
    """
    names = {entry["sha256"]: str(entry["name"]) for entry in model.provenance["runs"]}
    used = [model.sensors[index].name for index in model.chosen]
    # Earlier versions stored the SHA-256 of the run's file.
    return names.get(run.fingerprint(used), names.get(run.sha256))


def held(time_s: Array, values: Array) -> Array:
    """Return a column as a control sees it: a slowly sampled sensor holds its last reading.

    It holds for at most five of its usual intervals. Missing values of a sensor that is sampled in
    most rows stay missing.

    Parameters
    ----------
    time_s : array (n,)
        Increasing [s].
    values : array (n,)
        NaN: missing.
    """
    there = np.flatnonzero(np.isfinite(values))
    if len(there) < 2:
        return values
    if np.median(np.diff(there)) < 2:  # most readings are in consecutive rows
        return values
    usual = float(np.median(np.diff(time_s[there])))
    last = np.maximum.accumulate(np.where(np.isfinite(values), np.arange(len(values)), 0))
    return np.where(time_s - time_s[last] <= GAP_INTERVALS * usual, values[last], np.nan)


def answers(
    model: Model,
    inputs: Iterable[tuple[float, Array, float, Sequence[float] | None]],
    tool_length_mm: float,
) -> Iterator[Output]:
    """Drive a compensator step by step.

    At each row the offsets move for the time since the previous row, because a control samples more
    often; at the first row they move for `GRID_S`.

    Parameters
    ----------
    model : Model
    inputs : iterable of tuple
        Time [s], readings [degC], speed [rpm], and measured targets or None [um, urad].
    tool_length_mm : float

    Returns
    -------
    iterator of Output
        Output of each step; measured targets take effect at the next one.
    """
    compensator, last = RunningCompensator(model), nan
    for time, readings, speed, probe in inputs:
        step = GRID_S if isnan(last) else float(time - last)
        last = time
        sample = readings.tolist(), float(speed), tool_length_mm
        yield compensator.step(float(time), step, *sample)
        if probe is not None:
            compensator.step(float(time), 0.0, *sample, probe)


def _probes(
    model: Model, run: Run, rig: Rig | None, rows: Sequence[int], every_s: float | None
) -> list[list[float] | None]:
    """Return the targets that a probe measures, row by row; None for rows without a probe."""
    probes: list[list[float] | None] = [None] * len(rows)
    if every_s is None or rig is None or begins_late(model, run, rig):
        return probes
    targets = counted(rig.targets(run), model.input_form).to_numpy(float)[rows]
    time_s = run.time_s[rows]
    last = float(time_s[0])
    for row in np.flatnonzero(np.isfinite(targets).all(axis=1)):
        if past_rounding(float(time_s[row])) - last >= every_s:
            probes[row], last = targets[row].tolist(), float(time_s[row])
    return probes


def begins_late(model: Model, run: Run, rig: Rig) -> bool:
    """Whether displacements begin too late to know what a probe would measure from the start."""
    measured = rig.targets(run).to_numpy(float)
    return late_by(run.time_s, measured, model.input_form) > GRID_S


def late_line(name: str, late_s: float) -> list[str]:
    """Return a line if a run's drift begins to count late, after `late_by` [s]; else none."""
    said = (
        f"{name}: displacement is first read {late_s / 60.0:.0f} min after the start: "
        "drift counts from there"
    )
    return [said] if late_s > GRID_S else []


def late_lines(model: Model, runs: Iterable[Run], rig: Rig | None) -> list[str]:
    """Return a `late_line` for each run with displacements that needs one."""
    lines = []
    for run in runs:
        if rig is not None and all(name in run.frame for name in rig.columns):
            measured = rig.targets(run).to_numpy(float)
            lines += late_line(run.name, late_by(run.time_s, measured, model.input_form))
    return lines


def rows_used(time_s: Array, drift: Array) -> list[int]:
    """Return the rows to use: those of `grid_rows`, and all measured ones if these are rare.

    Parameters
    ----------
    time_s : array (n,)
        [s].
    drift : array (n, axes)
        NaN if not measured [um].
    """
    rows, measured = grid_rows(time_s), np.flatnonzero(np.isfinite(drift).any(axis=1))
    if len(measured) < 2 or np.median(np.diff(time_s[measured])) < GRID_S:
        return rows
    return sorted({*rows, *measured.tolist()})


def grid_rows(time_s: Array) -> list[int]:
    """Return the rows to use, each at least about `GRID_S` after the previous one."""
    kept, last = [], -np.inf
    for row, time in enumerate(time_s):
        if time - last >= GRID_S * 0.99:
            kept.append(row)
            last = time
    return kept


def _drift(model: Model, run: Run, rig: Rig | None, tool_length_mm: float) -> Array:
    """Return the measured drift; NaN if there is none."""
    by_axis = np.full((len(run.time_s), 3), np.nan)
    if rig is None or any(name not in run.frame for name in rig.columns):
        return by_axis
    drift = measured_drift(run, rig, tool_length_mm, model.input_form)
    for place, axis in enumerate(AXES):
        if f"drift_{axis}_um" in drift:
            by_axis[:, place] = drift[f"drift_{axis}_um"].to_numpy(float)
    return by_axis
