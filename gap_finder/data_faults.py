"""Data that a model must not be compared with: broken sensors, joined recordings.

They are found in the data alone, before any model is fitted: no model decides what is left out.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from gap_finder.observations import INDEPENDENT_S
from gap_finder.probe_steps import probe_steps, put_back
from measurement.errors import BadInput
from measurement.faults import GROSS, LEVELS, Fault, find_faults, unusable
from measurement.resampling import GAP_INTERVALS
from measurement.runs import TIME, Run
from plant_model.drive import column_in
from plant_model.machine import Machine
from plant_model.sensors import column_of, displacement_names

WHOLE_RUN = "the whole run"
"""The channel of a fault that excludes a whole run, or the rest of it."""


@dataclass(frozen=True)
class DataFault:
    """A fault in the data, and the time that is left out because of it.

    Attributes
    ----------
    run, channel, kind : str
        The channel is a sensor of the machine, an input's name, or `WHOLE_RUN`; the kind is one of
        ``measurement.faults``, or ``probe_step``.
    start_s, end_s : float
        [s]; the same instant for ``probe_step``, which leaves nothing out.
    text : str
        One readable line.
    """

    run: str
    channel: str
    kind: str
    start_s: float
    end_s: float
    text: str


def without_faults(machine: Machine, runs: Sequence[Run]) -> tuple[list[Run], list[DataFault]]:
    """Remove gross faults from runs.

    Parameters
    ----------
    machine : Machine
        Only its sensors and inputs are checked, against all thermometers in the runs.
    runs : sequence of Run
        All runs to be compared with the machine, in any order.

    Returns
    -------
    runs : list of Run
        In the given order, without bad readings and with the zeros of slipped probes corrected;
        without unusable runs.
    faults : list of DataFault
        By run and channel.

    Raises
    ------
    BadInput
        If no run is left.
    """
    ordered = sorted(runs, key=lambda run: run.name)
    names = _names(machine)
    bad = [
        fault
        for fault in unusable(find_faults(ordered), (*GROSS, *LEVELS))
        if fault.column in names and not _is_its_own(machine, fault)
    ]
    faults = [
        DataFault(
            fault.run, names[fault.column], fault.kind, fault.start_s, fault.end_s, fault.line()
        )
        for fault in bad
    ]
    unknown = [gap for run in ordered for gap in _unknown_inputs(machine, run)]
    faults += unknown
    unusable_runs = {gap.run for gap in unknown}
    kept = []
    for run in runs:
        usable = _usable(machine, run, [fault for fault in bad if fault.run == run.name])
        if usable is not None and run.name not in unusable_runs:
            kept.append(usable)
    if not kept:
        raise BadInput("--runs", "", f"none can be used: {faults[0].text}")
    slips = list(zip(kept, probe_steps(machine, kept), strict=True))
    faults += [
        DataFault(
            run.name, step.channel, "probe_step", step.time_s, step.time_s, step.text(run.name)
        )
        for run, steps in slips
        for step in steps
    ]
    faults.sort(key=lambda fault: (fault.run, fault.channel, fault.start_s))
    return [put_back(machine, run, steps) for run, steps in slips], faults


def without_bad_readings(machine: Machine, run: Run, faults: Sequence[DataFault]) -> Run:
    """Return a run without the bad readings of its sensors.

    Parameters
    ----------
    machine : Machine
    run : Run
    faults : sequence of DataFault
        Of sensors; those of other runs are ignored.
    """
    spans = [
        (column_of(machine, fault.channel), fault.start_s, fault.end_s)
        for fault in faults
        if fault.run == run.name
    ]
    return replace(run, frame=_without(run.frame, spans)) if spans else run


def need_readings(machine: Machine, runs: Sequence[Run], option: str) -> None:
    """Refuse runs without a usable channel to compare with the machine.

    Parameters
    ----------
    machine : Machine
    runs : sequence of Run
        With broken readings already NaN.
    option : str
        Of the command line, for the error message.

    Raises
    ------
    BadInput
        Naming the first such run.
    """
    driving = {entry.column for entry in machine.inputs}
    columns = [name for name in _names(machine) if name not in driving and name != TIME]
    for run in runs:
        present = [name for name in columns if name in run.frame]
        if not any(np.isfinite(run.frame[name]).any() for name in present):
            lost = ", ".join(present) or "none of the machine's sensors is there"
            problem = f"has no usable reading to compare ({lost}); see 'spindle-drift summary'"
            raise BadInput(option, run.name, problem)


def _names(machine: Machine) -> dict[str, str]:
    """Return the channel of each column that the machine uses; of time, `WHOLE_RUN`."""
    sensors = [sensor.name for sensor in machine.sensors] + displacement_names(machine)
    named = {entry.column: entry.name for entry in machine.inputs}
    named |= {column_of(machine, name): name for name in sensors}
    return named | {TIME: WHOLE_RUN}


def _is_its_own(machine: Machine, fault: Fault) -> bool:
    """Whether a fault only says that a boundary is unlike the machine, which is allowed."""
    driving = {entry.column for entry in machine.inputs if entry.is_boundary}
    return fault.kind in ("never_right", "dead") and fault.column in driving


def _usable(machine: Machine, run: Run, bad: Sequence[Fault]) -> Run | None:
    """Return a run without its bad readings; None if too little is left to drive the machine."""
    if not bad:
        return run
    driving = {entry.column for entry in machine.inputs}
    spans, end = [], float("inf")
    for fault in bad:
        if fault.column == TIME:
            end = min(end, fault.start_s)
        elif fault.column in driving and fault.end_s - fault.start_s > INDEPENDENT_S:
            return None  # Bridging it for longer than a misfit lasts would be a guess.
        else:
            spans.append((fault.column, fault.start_s, fault.end_s))
    frame = _without(run.frame[run.time_s < end], spans)
    return replace(run, frame=frame) if len(frame) >= 3 else None


def _unknown_inputs(machine: Machine, run: Run) -> Iterator[DataFault]:
    """Yield when an input is missing for longer than a misfit lasts: bridging it would be a guess.

    A column that is written seldom may lack values for `GAP_INTERVALS` of its usual intervals.
    """
    for entry in machine.inputs:
        if (column := column_in(run.frame, entry)) is None:
            continue
        missing = run.frame[column].isna().to_numpy()
        there = run.time_s[~missing]
        usual = float(np.median(np.diff(there))) if len(there) > 1 else 0.0
        # Rows that are not there at all are a pause, in which inputs hold.
        ends = np.flatnonzero(np.diff(missing, prepend=False, append=False))
        for first, last in ends.reshape(-1, 2):
            gap = Fault.between(run, column, "missing", first, last - 1, "missing")
            if gap.end_s - gap.start_s > max(INDEPENDENT_S, GAP_INTERVALS * usual):
                text = f"{run.name}, {column}, {gap.when()}: {gap.text}; the run is not used"
                yield DataFault(run.name, entry.name, gap.kind, gap.start_s, gap.end_s, text)


def _without(frame: pd.DataFrame, spans: Sequence[tuple[str, float, float]]) -> pd.DataFrame:
    """Return a run's frame without the values of columns in spans (column, start, end) [s]."""
    frame = frame.copy()
    for column, start_s, end_s in spans:
        frame.loc[frame[TIME].between(start_s, end_s), column] = np.nan
    # A run without any reading of a channel does not have that channel.
    dead = [column for column in {name for name, *_ in spans} if frame[column].isna().all()]
    return frame.drop(columns=dead)
