"""Probe cycles in the loop: now and then the plant's displacement is passed to the compensator."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from measurement.errors import BadInput
from measurement.resampling import past_rounding
from measurement.rig import FivePointRig
from measurement.units import split_column
from scenarios.fmu import Port, Slave
from scenarios.probing import is_due
from scenarios.scenario import Probe
from scenarios.signals.base import FloatArray
from scenarios.wiring import PROBED


class ProbeInputs:
    """The inputs of a compensator for the result of a probe.

    Parameters
    ----------
    slave : Slave
        The compensator.

    Attributes
    ----------
    names : list of str
        Names of these inputs; empty if it takes no measurement.
    """

    def __init__(self, slave: Slave) -> None:
        self.names = [name for name in slave.names("input") if name.startswith(f"{PROBED}_")]
        self._values = Port(slave, self.names)
        self._flag = Port(slave, [PROBED] if self.names else [], "Boolean")

    def set(self, shown: Sequence[float] | FloatArray | None) -> bool:
        """Set the readings of a probe, by name [um, urad]; return whether there are any."""
        if shown is not None:
            self._values.values[:] = shown
            self._values.set()
        self._flag.values[:] = shown is not None
        self._flag.set()
        return shown is not None


class ProbeSource:
    """Decides when a probe is due, and returns its readings.

    Parameters
    ----------
    probe : Probe
        The scenario's setting.
    targets : sequence of str
        What is measured, by the compensator's names.
    outputs : sequence of str
        The plant's outputs, in the order of their values.
    rig : FivePointRig or None
        Converts the plant's displacement readings to a pose; without one, the targets must be
        outputs of the plant.
    source : str
        The scenario, for refusals.
    from_start : bool
        Whether drift counts from the first reading.

    Raises
    ------
    BadInput
        If the plant has no output that could be measured.
    """

    def __init__(
        self,
        probe: Probe,
        targets: Sequence[str],
        outputs: Sequence[str],
        rig: FivePointRig | None,
        source: str,
        *,
        from_start: bool,
    ) -> None:
        self._probe, self._from_start = probe, from_start
        self._targets = list(targets)
        self._rig = rig if rig is not None and set(rig.sensors) <= set(outputs) else None
        wanted = self._targets if self._rig is None else list(self._rig.sensors)
        lost = [name for name in wanted if name not in outputs]
        if lost:
            problem = f"the plant FMU has no output {lost[0]} that a probe could show"
            raise BadInput(source, "compensator.probe", problem)
        self._take = [list(outputs).index(name) for name in wanted]
        self._first: FloatArray | None = None
        self._last_s = 0.0
        self._any = False

    def measured(
        self, time_s: float, plant_values: FloatArray, half_widths: Sequence[float]
    ) -> FloatArray | None:
        """Return the readings of a probe, by target [um, urad]; None if no probe is due.

        Parameters
        ----------
        time_s : float
            The communication point [s].
        plant_values : array, shape (outputs,)
            The plant's outputs, in the order given to the constructor.
        half_widths : sequence of float
            The compensator's own uncertainty along X, Y and Z [um]; NaN: not known.
        """
        since_s = past_rounding(time_s) - self._last_s
        due = is_due(self._probe, since_s, half_widths, is_first=not self._any)
        if not due and self._first is not None:
            return None
        shown = self._pose(plant_values[self._take])
        if self._first is None:
            self._first = shown if self._from_start else np.zeros_like(shown)
        if not due:
            return None
        self._last_s, self._any = time_s, True
        return np.asarray(shown - self._first)

    def _pose(self, readings: FloatArray) -> FloatArray:
        if self._rig is None:
            return readings.copy()
        columns = dict(zip(self._rig.columns, readings[:, None], strict=True))
        pose = self._rig.pose(pd.DataFrame(columns))
        named = {split_column(str(name))[0]: float(pose[name].iloc[0]) for name in pose.columns}
        return np.array([named[name] for name in self._targets])
