"""The machine behind the control: the plant FMU, driven by a scenario's signals."""

from __future__ import annotations

import io
from array import array
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from gateway.database import OFFSETS
from gateway.state import Saved
from gateway.unit import StatefulSlave
from measurement.errors import BadInput
from measurement.units import column
from scenarios.cosimulation import plant_parameters, signals_over
from scenarios.faults import FaultLine
from scenarios.fmu import Port
from scenarios.probe_cycle import ProbeSource
from scenarios.scenario import Case
from scenarios.views import rig_of
from scenarios.wiring import PROBED, SPEED, TOOL_LENGTH, speed_of


class MachinePlant:
    """The plant FMU, stepped from point to point of a scenario.

    Point *k* is at ``k * step_s``. The control sends the readings at the point, with the scenario's
    faults; the step from there uses the offsets that have arrived by then. So the loop has the same
    delays as the co-simulation of `scenarios.cosimulation`.

    Parameters
    ----------
    path : Path
        The FMU.
    case : Case
        The scenario's case that drives it.
    show : callable
        Takes each warning of the FMU, as a line.
    printed : StringIO, optional
        See `Slave`.
    recorded : bool, optional
        Whether `record` keeps anything; without it a machine may run for ever.

    Raises
    ------
    BadInput
        If the case does not fit the FMU.
    """

    def __init__(
        self,
        path: Path,
        case: Case,
        show: Callable[[str], None] = lambda line: None,
        printed: io.StringIO | None = None,
        *,
        recorded: bool = True,
    ) -> None:
        self.case = case
        self.step_s, self.steps = case.settings.step_s, case.settings.steps
        self.slave = StatefulSlave(path, "plant", show, printed or io.StringIO())
        # The bus brings the offsets. The compensator must get the plant's value of an input that no
        # signal drives.
        driven = {n: variable for n, variable in self.slave.variables.items() if n not in OFFSETS}
        speed = speed_of(driven)
        told = driven | ({SPEED: driven[speed]} if speed else {})
        time_s = np.arange(self.steps + 1, dtype=np.float64) * self.step_s
        self._signals = signals_over(case, time_s, driven, told)
        self._driven = {n: rows for n, rows in self._signals.items() if n in driven}
        self._in = Port(self.slave, [*self._driven, *OFFSETS])
        self._out = Port(self.slave, self.slave.names("output"))
        lost = [name for name in OFFSETS if name not in self.slave.names("input")]
        if lost:
            raise BadInput(path, lost[0], "is not an input of this plant")
        owned = self.slave.variables
        columns = [
            self.slave.column(name) if name in owned else column(name, "rpm")  # see `told`
            for name in (*self._out.names, *self._signals)
        ]
        self._faults = FaultLine(case.settings.faults, columns, case.setting.source)
        self.path = path
        self._probe: ProbeSource | None = None
        self.point = 0
        self._recorded = recorded
        self._table = array("d")
        self._extra: tuple[str, ...] = ()

    def start(self, saved: Saved | None = None) -> None:
        """Initialise the FMU, and continue from a saved state if there is one.

        Parameters
        ----------
        saved : Saved, optional
            State and time of an earlier run of the same FMU.

        Raises
        ------
        BadInput
            If the FMU does not take a parameter of the scenario.
        FmuError
            If the FMU fails.
        """
        for name, value in plant_parameters(self.case, self.slave.variables).items():
            self.slave.set_parameter(name, value, self.case.setting.source, "plant.parameters")
        with self.slave.starting(self.steps * self.step_s):
            self._set(dict.fromkeys(OFFSETS, 0.0))
        if saved is not None:
            self.slave.restore(saved.state)
            self.point = min(round(saved.time_s / self.step_s), self.steps)
        self._out.get()

    def probe_with(self, names: Sequence[str]) -> None:
        """Measure the scenario's probes, under the compensator's names.

        Parameters
        ----------
        names : sequence of str
            The compensator's inputs for a probe; empty if no frame carries them.

        Raises
        ------
        BadInput
            If the scenario has probes, but there are no frames for them or nothing to measure.
        """
        probe, source = self.case.settings.compensator.probe, str(self.case.setting.source)
        if probe is None:
            return
        if not names:
            raise BadInput(source, "compensator.probe", "no frame of the machine carries a probe")
        targets = [name.removeprefix(f"{PROBED}_") for name in names]
        self._probe = ProbeSource(
            *(probe, targets, self._out.names, rig_of(self.path), source), from_start=True
        )

    def measured(self, half_widths: Sequence[float]) -> list[float]:
        """Return the result of a probe at this point [um, urad]; empty if none is due.

        Parameters
        ----------
        half_widths : sequence of float
            The uncertainty of each axis, received from the gateway; NaN if none [um].
        """
        if self._probe is None:
            return []
        shown = self._probe.measured(self.time_s, self._out.values, half_widths)
        return [] if shown is None else [float(value) for value in shown]

    @property
    def time_s(self) -> float:
        """The time of the current point [s]."""
        return self.point * self.step_s

    @property
    def thermal_state(self) -> str:
        """The thermal state: cold at the start, from which the plant's drift is counted."""
        return "warm" if self.point else "cold"

    @property
    def done(self) -> bool:
        """Whether the scenario has ended."""
        return self.point >= self.steps

    def readings(self) -> dict[str, float]:
        """Return the control's readings now: sensors, speed, tool length; NaN if missing."""
        values = np.array(
            [*self._out.values, *(rows[self.point] for rows in self._signals.values())]
        )
        self._faults.apply(self.time_s, self.step_s, values)
        values_by_name = dict(zip([*self._out.names, *self._signals], values.tolist(), strict=True))
        length_mm = self.case.settings.compensator.tool_length_mm
        if length_mm is not None:
            values_by_name[TOOL_LENGTH] = length_mm
        return values_by_name

    def record(self, offsets: Mapping[str, float], extra: Mapping[str, float]) -> None:
        """Record the current point for `frame`.

        Parameters
        ----------
        offsets : mapping of str to float
            dX, dY and dZ as received [um].
        extra : mapping of str to float
            More columns, in the same order at every call.
        """
        if not self._recorded:
            return
        signals = [rows[self.point] for rows in self._driven.values()]
        row = [self.time_s, *signals, *(offsets[name] for name in OFFSETS)]
        self._table.extend([*row, *self._out.values.tolist(), *extra.values()])
        self._extra = tuple(extra)

    def step(self, offsets: Mapping[str, float]) -> None:
        """Step to the next point with the offsets received [um].

        Parameters
        ----------
        offsets : mapping of str to float
            dX, dY and dZ as received [um].

        Raises
        ------
        FmuError
            If the FMU fails.
        """
        self._set(offsets)
        self.slave.step(self.time_s, self.step_s)
        self.point += 1
        self._out.get()

    def _set(self, offsets: Mapping[str, float]) -> None:
        signals = [rows[self.point] for rows in self._driven.values()]
        self._in.values[:] = [*signals, *(offsets[name] for name in OFFSETS)]
        self._in.set()

    def frame(self) -> pd.DataFrame:
        """Return the record as the table of a run file."""
        names = ["time_s", *(self.slave.column(n) for n in (*self._driven, *OFFSETS))]
        names += [self.slave.column(name) for name in self._out.names]
        names += [f"{name}_1" for name in self._extra]
        rows = np.array(self._table, dtype=np.float64).reshape(-1, len(names))
        return pd.DataFrame(rows, columns=names)

    def close(self, error: BaseException | None = None) -> None:
        """Release the FMU.

        Parameters
        ----------
        error : BaseException, optional
            The error that ended the run.
        """
        self.slave.__exit__(type(error) if error else None, error, None)
