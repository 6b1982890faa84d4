"""A probe cycle in the loop: the plant's own displacement goes to the compensator now and then."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from measurement.drift import FROM_START
from measurement.errors import BadInput
from measurement.rig import FivePointRig
from measurement.units import split_column
from scenarios.fmu import Port, Slave
from scenarios.probing import PAUSE_S
from scenarios.scenario import Probe
from scenarios.signals.base import FloatArray
from scenarios.wiring import PROBED

HALF_WIDTHS = ("dX_uncertainty", "dY_uncertainty", "dZ_uncertainty")


class ProbeCycle:
    """When a probe is due, and the compensator's measured inputs.

    Parameters
    ----------
    probe : Probe
        The scenario's setting.
    compensator : Slave
    outputs : sequence of str
        The plant's outputs, as their values come.
    rig : FivePointRig or None
        Turns the plant's displacement readings into a pose; without one, the compensator's targets
        must be outputs of the plant.
    input_form : str
        Of the compensator: what its drift counts from.
    source : str
        The scenario, for refusals.

    Raises
    ------
    BadInput
        If the compensator takes no measurement, or the plant shows nothing that could be one.
    """

    def __init__(
        self,
        probe: Probe,
        compensator: Slave,
        outputs: Sequence[str],
        rig: FivePointRig | None,
        input_form: str,
        source: str,
    ) -> None:
        self._probe, self._rig, self._from_start = probe, rig, FROM_START[input_form]
        inputs = [name for name in compensator.names("input") if name.startswith(f"{PROBED}_")]
        if not inputs:
            raise BadInput(source, "compensator.probe", "the compensator FMU takes no measurement")
        self._targets = [name.removeprefix(f"{PROBED}_") for name in inputs]
        if rig is None or not set(rig.sensors) <= set(outputs):
            self._rig = None
        wanted = self._targets if self._rig is None else list(self._rig.sensors)
        lost = [name for name in wanted if name not in outputs]
        if lost:
            problem = f"the plant FMU has no output {lost[0]} that a probe could show"
            raise BadInput(source, "compensator.probe", problem)
        self._names = wanted
        self._take = [list(outputs).index(name) for name in wanted]
        self._values = Port(compensator, inputs)
        self._flag = Port(compensator, [PROBED], "Boolean")
        self._first: FloatArray | None = None
        self._last_s = 0.0
        self._any = False

    def set(self, time_s: float, plant_values: FloatArray, half_widths: Sequence[float]) -> bool:
        """Set the compensator's measured inputs at a point; return whether a probe was taken."""
        due = self._due(time_s, half_widths)
        if due or self._first is None:
            shown = self._pose(plant_values[self._take])
            if self._first is None:
                self._first = shown if self._from_start else np.zeros_like(shown)
            if due:
                self._values.values[:] = shown - self._first
                self._values.set()
                self._last_s, self._any = time_s, True
        self._flag.values[0] = due
        self._flag.set()
        return due

    def _due(self, time_s: float, half_widths: Sequence[float]) -> bool:
        since, probe = time_s - self._last_s, self._probe
        if probe.every_s is not None and since >= probe.every_s:
            return True
        wide = probe.when_um is not None and any(value > probe.when_um for value in half_widths)
        return wide and (not self._any or since >= PAUSE_S)

    def _pose(self, readings: FloatArray) -> FloatArray:
        if self._rig is None:
            return readings.copy()
        columns = dict(zip(self._rig.columns, readings[:, None], strict=True))
        pose = self._rig.pose(pd.DataFrame(columns))
        named = {split_column(str(name))[0]: float(pose[name].iloc[0]) for name in pose.columns}
        return np.array([named[name] for name in self._targets])
