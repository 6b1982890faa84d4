"""Co-simulates the plant FMUs of a gap report on measured runs and compares them.

The finder compares machines in its own process, but the user gets an FMU. In a co-simulation,
stepped from row to row with held inputs, it must show the same gap. A test checks that; the two
differ only by how much a boundary temperature changes within a step.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from gap_finder.observations import Observations, observe
from gap_finder.regimes import RunResiduals, by_channel, gap_of
from measurement.runs import Run
from plant_model.drive import drive_from
from plant_model.fmi_slave import rise_name, start_sensors
from plant_model.machine import Machine
from plant_model.parameters import FloatArray
from plant_model.sensors import column_of, displacement_names
from plant_model.simulate import start_readings
from plant_model.trajectory import FINE_S
from scenarios.fmu import Port, alone


def cosimulate(fmu: Path, machine: Machine, run: Run) -> pd.DataFrame:
    """Drive a plant FMU with a measured run's commands and boundary temperatures.

    Parameters
    ----------
    fmu : Path
        The machine's FMU.
    machine : Machine
        Defines the input columns and the nodes' start temperatures.
    run : Run

    Returns
    -------
    DataFrame
        Readings of every sensor, by name [degC, um]; the index is the communication points [s].

    Raises
    ------
    FmuError
        If the FMU fails.
    """
    time = _points(run.time_s)
    drive = drive_from(machine, run.frame, FINE_S)
    # A command holds from its row on; a boundary temperature is taken at the middle of the step.
    at_start, at_middle = drive.inputs_at(time), drive.inputs_at((time[:-1] + time[1:]) / 2.0)
    boundary = {entry.name for entry in machine.inputs if entry.is_boundary}
    names = [entry.name for entry in machine.inputs]
    rows = np.column_stack(
        [at_middle[name] if name in boundary else at_start[name][:-1] for name in names]
    )
    first = np.array([at_start[name][0] for name in names])
    starts = start_readings(machine, run.frame)
    zero = float(at_start[next(iter(machine.boundary_index))][0])
    with alone(fmu, "plant") as (slave, check):
        for sensor in start_sensors(machine):
            rise = starts.get(sensor, zero) - zero
            slave.set_parameter(rise_name(sensor), rise, run.name, sensor)
        shown = [sensor.name for sensor in machine.sensors] + displacement_names(machine)
        inputs, outputs = Port(slave, names), Port(slave, shown)
        table = np.empty((len(time), len(shown)))
        with slave.starting(float(time[-1] - time[0])):
            inputs.values[:] = first
            inputs.set()
        outputs.get()
        table[0] = outputs.values
        for k, row in enumerate(rows):
            inputs.values[:] = row
            inputs.set()
            slave.step(float(time[k] - time[0]), float(time[k + 1] - time[k]))
            outputs.get()
            table[k + 1] = outputs.values
            check()
    return pd.DataFrame(table, time, shown)


def _points(rows: FloatArray) -> FloatArray:
    """Return the time of every row, and instants between rows that are far apart."""
    steps = np.ceil(np.diff(rows) / FINE_S - 1e-9).astype(int)
    pieces = [
        np.linspace(a, b, n, endpoint=False)
        for a, b, n in zip(rows[:-1], rows[1:], steps, strict=True)
    ]
    return np.concatenate([*pieces, rows[-1:]])


def residuals_of(simulated: pd.DataFrame, machine: Machine, observed: Observations) -> RunResiduals:
    """Return co-simulation minus measurement, both averaged over the same rows."""
    run = observed.run
    frame = run.frame.copy()
    for name, zero_s in zip(observed.channels, observed.zero_s, strict=True):
        column = column_of(machine, name)
        if column in frame.columns:
            shown = np.interp(run.time_s, simulated.index, simulated[name])
            compared = frame[column].notna() & (run.time_s >= zero_s)
            frame[column] = np.where(compared, shown, np.nan)
    (modelled,) = observe(machine, [replace(run, frame=frame)], channels=observed.channels)
    return RunResiduals(observed, modelled.values - observed.values)


def compare_fmus(
    before: tuple[Path, Machine], after: tuple[Path, Machine], observed: Sequence[Observations]
) -> dict[str, Any]:
    """Return the entry of ``gap.json`` on the co-simulation.

    Parameters
    ----------
    before, after : tuple of (Path, Machine)
        The FMU, and the machine from which it was built.
    observed : sequence of Observations
        Observations of the held-out runs.

    Returns
    -------
    dict
        ``before`` and ``after``, root mean square of residual over sensor noise; ``channels`` with
        the residual of each channel.
    """
    machine = before[1]
    left = [
        [residuals_of(cosimulate(fmu, which, seen.run), which, seen) for seen in observed]
        for fmu, which in (before, after)
    ]
    lengths = displacement_names(machine)
    first, last = (by_channel(rows) for rows in left)
    return {
        "before": gap_of(left[0]),
        "after": gap_of(left[1]),
        "channels": {
            name: {
                "before": value,
                "after": last[name],
                "unit": "um" if name in lengths else "K",
            }
            for name, value in first.items()
        },
    }
