"""Converts a scenario's signals to a machine's inputs."""

from __future__ import annotations

import numpy as np
import pandas as pd

from measurement.errors import BadInput
from plant_model.drive import MOST_STEPS
from plant_model.machine import Machine
from scenarios.scenario import Case


def inputs_of(case: Case, machine: Machine, every_s: float) -> pd.DataFrame:
    """Return a scenario's signals as inputs of a machine, a row every *every_s* [s].

    Parameters
    ----------
    case : Case
        The variant of the scenario.
    machine : Machine
        Signals for which it has no input are left out.
    every_s : float
        Time between rows [s].

    Returns
    -------
    DataFrame
        ``time_s`` from 0 to the scenario's duration, and a column per signal under its input's
        name.
    """
    duration_s = case.settings.duration_s
    if not 0.0 < every_s <= duration_s:
        raise BadInput("--every", "", f"{every_s:g} is outside 0..{duration_s:g} s")
    if duration_s / every_s > MOST_STEPS:
        raise BadInput("--every", "", f"{every_s:g} s makes more than {MOST_STEPS} rows")
    rows = int(duration_s / every_s + 1e-9) + 1
    time = np.arange(rows) * every_s
    names = {entry.name for entry in machine.inputs}
    columns = {
        name: signal.values(time, case.setting.inside(name))
        for name, signal in case.signals.items()
        if name in names
    }
    return pd.DataFrame({"time_s": time, **columns})
