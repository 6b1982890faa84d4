"""Makes the table and the charts of a results folder from recordings."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from measurement.naming import lowered
from measurement.rig import AXES, FivePointRig, rig_from_table
from measurement.units import UNITS, split_column
from scenarios.fmu_file import member
from scenarios.pages.charts import (
    BEFORE,
    LINES,
    MANY,
    MEASURED,
    Chart,
    Line,
    Panel,
    interval,
    with_gaps,
)
from scenarios.recording import Recording
from scenarios.signals.base import FloatArray
from scenarios.table import NO_COMPENSATION, Group, group_of

MACHINES = ("resources/machine.json", "documentation/machine.json")  # in Python, in C
TOOL = "tool_length_mm"
MINUTE_S = 60.0
"""Given by arithmetic [s]."""


def grouped(recordings: Sequence[Recording]) -> list[list[Recording]]:
    """Return the recordings in groups that share the same drift, in the order of the scenario.

    One line without compensation then holds for the whole group.
    """
    groups: dict[bytes, list[Recording]] = {}
    drifts = [f"drift_{axis}_um" for axis in AXES]
    for recording in recordings:
        drift = recording.frame.reindex(columns=drifts).to_numpy() + 0.0  # -0.0 is 0.0
        groups.setdefault(drift.tobytes(), []).append(recording)
    return list(groups.values())


def group_title(group: Sequence[Recording]) -> str:
    """Return what the variants of a group share, for the table and the figures."""
    frame = group[0].frame
    if TOOL not in frame:
        return group[0].case.title if len(group) == 1 else "All variants"
    lengths = frame[TOOL].unique()
    if len(lengths) == 1:
        return f"Tool length {lengths[0]:g} mm"
    return f"Tools of {lengths.min():g} to {lengths.max():g} mm"


def table_of(recordings: Sequence[Recording]) -> list[Group]:
    """Return the headline table; a variant without compensator is the line without compensation."""
    return [
        group_of(
            group_title(group), [(entry.case.name, label_of(entry), entry.frame) for entry in group]
        ).with_only(entry.case.name for entry in group if is_compensated(entry))
        for group in grouped(recordings)
    ]


def label_of(recording: Recording) -> str:
    """Return a variant's label."""
    case = recording.case
    return "Compensated" if case.name == "main" else case.title


def full_label_of(recording: Recording) -> str:
    """Return a variant's label including its group, for use without a heading."""
    title, label = group_title([recording]), label_of(recording)
    return label if title == recording.case.title else f"{label}, {lowered(title)}"


def is_compensated(recording: Recording) -> bool:
    """Return whether a compensator took part."""
    return any(fmu.label == "compensator" for fmu in recording.fmus)


def rig_of(plant_fmu: Path) -> FivePointRig | None:
    """Return the five-point rig of the machine in a plant FMU, or None if it has none.

    Parameters
    ----------
    plant_fmu : Path
        From this project or elsewhere.
    """
    try:
        rig = rig_from_table(_machine_in(plant_fmu)["rig"], plant_fmu)
    except (KeyError, TypeError, ValueError, AttributeError):  # BadInput is a ValueError
        return None
    return rig if isinstance(rig, FivePointRig) else None


def columns_of(plant_fmu: Path) -> dict[str, str]:
    """Return the run-file columns of a plant FMU's inputs by their own; empty if not known.

    Parameters
    ----------
    plant_fmu : Path
        From this project or elsewhere.
    """
    try:
        inputs = _machine_in(plant_fmu)["inputs"]
        return {f"{entry['name']}_{entry['unit']}": entry["column"] for entry in inputs}
    except (KeyError, TypeError, ValueError):
        return {}


def _machine_in(plant_fmu: Path) -> Any:
    return json.loads(member(plant_fmu, *MACHINES) or b"{}")


def charts_of(recordings: Sequence[Recording], rig: FivePointRig | None) -> list[Chart]:
    """Return the charts of a scenario.

    Parameters
    ----------
    recordings : sequence of Recording
        At least one.
    rig : FivePointRig or None
        Converts the machine's displacement readings to the measured tilt, if known.
    """
    main = recordings[0]
    groups = grouped(recordings)
    charts = [*_commands(main), _temperatures(main)]
    for number, group in enumerate(groups):
        name = "drift" if number == 0 else f"drift_{number + 1}"
        charts.append(drift_chart(name, group_title(group), group))
    compensated = [entry for entry in recordings if is_compensated(entry)]
    charts += _tilt(compensated[0] if compensated else main, rig)
    if compensated:
        charts += _offsets(compensated[0])
    return charts


def _commands(main: Recording) -> list[Chart]:
    """Return the chart of the speed and whatever else jumps and stays, whatever its name."""
    frame = main.frame
    time_s = _floats(frame, "time_s")
    columns = [(split_column(column), column) for column in frame]
    panels = []
    for unit in (suffix for suffix, unit in UNITS.items() if unit.switches and suffix != "1"):
        for (name, its_unit), column in columns:
            # A tool that is never changed, or a torque that is always zero, shows nothing.
            if its_unit != unit or (unit != "rpm" and frame[column].nunique() < 2):
                continue
            line = Line("", time_s, frame[column].to_numpy(), LINES[0], held=True)
            label = f"{name.replace('_', ' ')} [{UNITS[unit].label}]"
            panels.append(Panel(label, (line,), from_zero=True))
    return [Chart("speed", "Spindle speed", "", tuple(panels))] if panels else []


def _temperatures(main: Recording) -> Chart:
    frame = main.frame
    time_s = _floats(frame, "time_s")
    columns = [name for name in main.sensors if name.endswith("_degC")]
    lines = [
        Line(split_column(column)[0], time_s, seen(frame, column), MANY[i % len(MANY)], thin=True)
        for i, column in enumerate(columns)
    ]
    note = "As the compensator saw them: with sensor noise, and with faults where there are any."
    return Chart("temperatures", "Temperatures", note, (Panel("temperature [°C]", tuple(lines)),))


def seen(frame: pd.DataFrame, column: str) -> FloatArray:
    """Return a sensor's column as the machine showed it, including faults."""
    signal, _, unit = column.rpartition("_")
    disturbed = f"{signal}_seen_{unit}"
    return _floats(frame, disturbed if disturbed in frame else column)


def before_and_after(
    results: Sequence[tuple[str, pd.DataFrame]], drift: pd.DataFrame, *, thin: bool = False
) -> tuple[Panel, ...]:
    """Return the drift without compensation and the remaining error, one panel per axis.

    Parameters
    ----------
    results : sequence of (str, DataFrame)
        Remaining error ``error_X_um`` ... by label; for the first one also the interval.
    drift : DataFrame
        ``time_s`` and ``drift_X_um`` ... for the axes that are known.
    thin : bool
        Whether there are many samples.
    """
    time_s = drift["time_s"].to_numpy(dtype=np.float64) - float(drift["time_s"].iloc[0])
    panels = []
    for axis in AXES:
        if f"drift_{axis}_um" not in drift:
            continue
        measured = with_gaps(time_s, _floats(drift, f"drift_{axis}_um"))
        lines = [Line(NO_COMPENSATION, *measured, BEFORE)]
        for number, (label, frame) in enumerate(results):
            colour, rank = LINES[number % len(LINES)], len(results) - number
            error = with_gaps(time_s, _floats(frame, f"error_{axis}_um"))
            lines.append(Line(label, *error, colour, thin=thin, rank=rank))
            if number == 0 and f"d{axis}_uncertainty_um" in frame:
                of = label if len(results) > 1 else ""
                lines += interval(time_s, _floats(frame, f"d{axis}_uncertainty_um"), of)
        panels.append(Panel(f"{axis} [µm]", tuple(lines)))
    return tuple(panels)


def _floats(frame: pd.DataFrame, column: str) -> FloatArray:
    return np.asarray(frame[column], dtype=np.float64)


def drift_chart(name: str, what: str, group: Sequence[Recording]) -> Chart:
    """Return the drift of variants before and after compensation, one panel per axis."""
    after = [(label_of(entry), entry.frame) for entry in group if is_compensated(entry)]
    title = f"Drift of the tool tip before and after compensation: {lowered(what)}"
    return Chart(name, title, "", before_and_after(after, group[0].frame, thin=True))


def _tilt(recording: Recording, rig: FivePointRig | None) -> list[Chart]:
    frame = recording.frame
    time_s = _floats(frame, "time_s")
    pose = None
    if rig is not None and all(column in frame for column in rig.columns):
        pose = rig.pose(frame)
    panels = []
    for name, plane in (("yaw", "XZ"), ("pitch", "YZ")):
        column, lines = f"{name}_urad", []
        if pose is not None:
            means = minute_means(time_s, _floats(pose, column))
            lines.append(Line("Measured by the rig", *means, MEASURED, rank=2))
        if column in frame:
            label, predicted = "Predicted by the compensator", _floats(frame, column)
            lines.append(Line(label, time_s, predicted, LINES[0], thin=True))
        if lines:
            panels.append(Panel(f"{name}, {plane} [µrad]", tuple(lines)))
    note = (
        "The tilt is what makes the drift in X and Y grow with the tool's length. "
        "Measured: means of a minute."
    )
    return [Chart("tilt", "Tilt of the spindle", note, tuple(panels))] if panels else []


def _offsets(recording: Recording) -> list[Chart]:
    frame = recording.frame
    time_s = _floats(frame, "time_s")
    lines = tuple(
        Line(axis, time_s, frame[f"offset_{axis}_um"].to_numpy(), colour, thin=True)
        for axis, colour in zip(AXES, LINES, strict=False)
        if f"offset_{axis}_um" in frame
    )
    title = f"Axis offsets in force: {lowered(full_label_of(recording))}"
    note = "What the control makes of the offsets sent: slew limit, saturation, resolution."
    return [Chart("offsets", title, note, (Panel("offset [µm]", lines),))] if lines else []


def minute_means(time_s: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return times and means of each minute: a curve without the noise of single samples."""
    # The last sample, at the end of the last minute, does not start another minute.
    last = max(int(np.ceil(time_s[-1] / MINUTE_S)) - 1, 0)
    minute = np.minimum(np.floor(time_s / MINUTE_S).astype(int), last)
    there = np.isfinite(values)
    counts = np.bincount(minute[there], minlength=last + 1).astype(float)
    sums = np.bincount(minute[there], values[there], minlength=last + 1)
    # A minute without any valid sample stays a gap.
    means = np.divide(sums, counts, out=np.full(counts.shape, np.nan), where=counts > 0)
    middles = (np.arange(len(counts)) + 0.5) * MINUTE_S
    return np.minimum(middles, time_s[-1]), means
