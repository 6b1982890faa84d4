"""The master: co-simulates a plant FMU and a compensator FMU in closed loop.

Step order
----------
At every communication point both FMUs are at time t; then, with a step of h:

1. the plant's outputs y(t) (sensor readings) are read, sensor faults are applied, and together with
   the signals u(t) they become the compensator's inputs;
2. the signals u(t) and the offsets c(t), which the compensator gave at t, become the plant's
   inputs;
3. both FMUs step from t to t + h. The compensator's new offsets c(t + h) come from y(t).

Inputs hold during a step. Neither FMU uses what the other computes in the same step (the Jacobi
scheme), so their order does not matter and nothing is iterated.

This causes a delay of one step from a reading to the resulting offset, and one more until the
plant's outputs show it: c(t + h) from y(t) acts from t + h on and appears in y(t + 2h). A real
control has the same delay: in one cycle it reads the thermometers and computes, in the next the
axes move. Letting the plant use the new offsets in the same step (Gauss-Seidel) would save a cycle
that no control saves. With h = 1 s and drift of at most a few um per minute it is negligible.
"""

from __future__ import annotations

import contextlib
import io
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from tqdm import tqdm

from fmu_compensator.runtime.fmi_slave import HALF_WIDTHS
from measurement.drift import FROM_START
from measurement.errors import BadInput
from scenarios.faults import FaultLine
from scenarios.fmu import Port, Slave, interruptible
from scenarios.fmu_file import FmuFile
from scenarios.probe_cycle import ProbeInputs, ProbeSource
from scenarios.recording import Event, Recording, facts_of, notice
from scenarios.replay import model_of
from scenarios.scenario import Case
from scenarios.signals.base import FloatArray
from scenarios.views import columns_of, rig_of
from scenarios.wiring import (
    PROBED,
    TOOL_LENGTH,
    Variables,
    check_ranges,
    check_signals,
    shared_inputs,
    shared_starts,
    wire,
)

NOISE_SEED = "noise_seed"
STATUS, STATUS_SENSOR, STATUS_TEXT = "status", "status_sensor", "status_text"


def simulate(
    case: Case,
    plant_fmu: Path | FmuFile,
    compensator_fmu: Path | FmuFile | None,
    *,
    quiet: bool = False,
) -> Recording:
    """Run one case from start to end.

    Parameters
    ----------
    case : Case
        A variant of a scenario.
    plant_fmu : Path or FmuFile
        The plant.
    compensator_fmu : Path, FmuFile or None
        The compensator; None, or a case that does not enable it, leaves the offsets at zero.
    quiet : bool
        No progress bar and no messages.

    Returns
    -------
    Recording
        Signals, readings, offsets and drift at every communication point.

    Raises
    ------
    BadInput
        If the case does not fit the FMUs.
    FmuError
        If an FMU fails; nothing is returned then.
    """
    stderr, printed = sys.stderr, io.StringIO()

    def show(line: str) -> None:
        if not quiet:
            tqdm.write(line, file=stderr)

    # A Python FMU shares this process's standard error; its warnings come through its log.
    with contextlib.redirect_stderr(printed), contextlib.ExitStack() as stack:
        check = stack.enter_context(interruptible())
        plant = stack.enter_context(Slave(plant_fmu, "plant", show, printed))
        compensator = None
        if compensator_fmu is not None and case.settings.compensator.enabled:
            compensator = stack.enter_context(Slave(compensator_fmu, "compensator", show, printed))
        loop = _Loop(case, plant, compensator)
        if compensator is not None:
            loop.probe = _probing(case, loop, compensator)
        steps, hidden = range(case.settings.steps), quiet or None  # None: if no terminal
        bar = tqdm(steps, desc=case.name, file=stderr, disable=hidden, leave=False)
        return loop.run(bar, check)


def signals_over(
    case: Case, time_s: FloatArray, plant: Variables, compensator: Variables | None
) -> dict[str, FloatArray]:
    """Return every signal of a case over the whole run.

    Parameters
    ----------
    case : Case
    time_s : ndarray
        The communication points [s], shape (points,).
    plant, compensator : dict of str to variable
        The FMUs' variables. An input of both that no signal drives becomes a signal at the plant's
        start value; what they name differently (`shared_inputs`) is there under both names.

    Raises
    ------
    BadInput
        For a signal that neither FMU takes, whose file cannot be used, or that leaves the range of
        the plant's input.
    """
    check_signals(plant, compensator, case.signals, case.setting.source)
    signals = {
        name: signal.values(time_s, case.setting.inside(name))
        for name, signal in case.signals.items()
    }
    check_ranges(plant, signals, time_s, case.setting.source)
    unsaid = shared_starts(plant, compensator, signals)
    signals |= {name: np.full(len(time_s), value) for name, value in unsaid.items()}
    shared = shared_inputs(plant, compensator)
    return signals | {name: signals[own] for name, own in shared.items()}


def plant_parameters(case: Case, plant: Variables) -> dict[str, float]:
    """Return the plant's parameters in a case, including the noise seed; 0 means no noise.

    Parameters
    ----------
    case : Case
    plant : dict of str to variable
        The plant FMU's variables.
    """
    settings = case.settings
    parameters = dict(settings.plant.parameters)
    if NOISE_SEED in plant and NOISE_SEED not in parameters:
        parameters[NOISE_SEED] = max(settings.seed, 1) if settings.plant.noise else 0
    return parameters


def _probing(case: Case, loop: _Loop, compensator: Slave) -> Callable[[float], bool] | None:
    """Return what takes a probe at a time [s] if one is due, and says so; None without probes."""
    probe, source = case.settings.compensator.probe, str(case.setting.source)
    if probe is None:
        return None
    inputs = ProbeInputs(compensator)
    if not inputs.names:
        raise BadInput(source, "compensator.probe", "the compensator FMU takes no measurement")
    targets = [name.removeprefix(f"{PROBED}_") for name in inputs.names]
    start = FROM_START[model_of(compensator.path).input_form]
    plant = loop.plant_out
    taken = ProbeSource(
        *(probe, targets, plant.names, rig_of(loop.plant.path), source), from_start=start
    )
    widths = [place for place, name in enumerate(loop.sent.names) if name in HALF_WIDTHS]

    def take(now: float) -> bool:
        return inputs.set(taken.measured(now, plant.values, loop.sent.values[widths].tolist()))

    return take


class _Loop:
    """The two FMUs connected, and the tables that the run fills."""

    def __init__(self, case: Case, plant: Slave, compensator: Slave | None) -> None:
        settings = case.settings
        self.case, self.plant, self.compensator = case, plant, compensator
        self.step_s = settings.step_s
        self.time_s: FloatArray = np.arange(settings.steps + 1, dtype=np.float64) * settings.step_s
        others = compensator.variables if compensator else None
        self.signals = signals_over(case, self.time_s, plant.variables, others)
        self.wiring = wire(plant.variables, others, self.signals, case.setting.source)
        self.plant_out = Port(plant, plant.names("output"))
        driven = self.wiring.driven
        self.plant_in = Port(plant, [*driven, *self.wiring.offsets])
        self.plant_rows = self._rows(driven)
        self.shown = [self.plant_out]
        slave, readings = plant, [*self.plant_out.names, *self.signals]
        if compensator:
            self._connect_compensator(compensator)
            slave, readings = compensator, [*self.seen_in.names]
        columns = [slave.column(name) for name in readings]
        self.faults = FaultLine(settings.faults, columns, case.setting.source)
        kept = [*self.shown, *([self.seen_in] if compensator else [])]
        self.tables: dict[Port, FloatArray] = {
            port: np.full((len(self.time_s), len(port.names)), np.nan) for port in kept
        }
        self.events: list[Event] = []
        self.probe: Callable[[float], bool] | None = None
        self.probed = np.zeros(len(self.time_s))

    def _rows(self, names: Sequence[str]) -> FloatArray:
        rows = np.empty((len(self.time_s), len(names)))
        for place, name in enumerate(names):
            rows[:, place] = self.signals[name]
        return rows

    def _connect_compensator(self, compensator: Slave) -> None:
        measured, driven = self.wiring.measured, self.wiring.by_signals
        self.seen_in = Port(compensator, [*measured, *driven])
        self.seen_rows = self._rows(driven)
        length = self.case.settings.compensator.tool_length_mm
        if length is not None:
            if TOOL_LENGTH not in driven:
                place = "compensator.tool_length_mm"
                raise BadInput(self.case.setting.source, place, f"there is no signal {TOOL_LENGTH}")
            self.seen_rows[:, driven.index(TOOL_LENGTH)] = length
        self.take = np.array([self.plant_out.names.index(name) for name in measured], dtype=int)
        self.sent = Port(compensator, compensator.names("output"))
        self.give = np.array(
            [self.sent.names.index(name) for name in self.wiring.offsets], dtype=int
        )
        self.codes = Port(compensator, compensator.names("output", "Integer"), "Integer")
        flags = Port(compensator, compensator.names("output", "Boolean"), "Boolean")
        self.shown += [self.sent, self.codes, flags]
        self.has_text = STATUS_TEXT in compensator.names("output", "String")

    # The run

    def run(self, steps: Iterable[int], check: Callable[[], None]) -> Recording:
        """Initialise, step to the end, and return everything."""
        self._start()
        begun = time.perf_counter()
        for k in steps:
            check()
            self._gather(k)
            now = float(self.time_s[k])
            if self.compensator:
                self.compensator.step(now, self.step_s)
            self.plant.step(now, self.step_s)
            self._read()
        self._gather(len(self.time_s) - 1, last=True)
        return self._recording(time.perf_counter() - begun)

    def _start(self) -> None:
        for name, value in plant_parameters(self.case, self.plant.variables).items():
            self.plant.set_parameter(name, value, self.case.setting.source, "plant.parameters")
        stop_s = float(self.time_s[-1])
        driven = self.plant_rows.shape[1]
        with self.plant.starting(stop_s):
            self.plant_in.values[:driven] = self.plant_rows[0]
            self.plant_in.set()
        self.plant_out.get()
        if self.compensator:
            with self.compensator.starting(stop_s):
                self._see(0)
        self._read()

    def _see(self, k: int) -> None:
        """Give the compensator what it sees at point *k*."""
        count = len(self.take)
        values = self.seen_in.values
        values[:count] = self.plant_out.values[self.take]
        values[count:] = self.seen_rows[k]
        self.faults.apply(float(self.time_s[k]), self.step_s, values)
        self.seen_in.set()

    def _gather(self, k: int, *, last: bool = False) -> None:
        """Record point *k* and set the inputs of the step that begins there."""
        driven = self.plant_rows.shape[1]
        self.plant_in.values[:driven] = self.plant_rows[k]
        if self.compensator:
            self._notice(k)
            self._see(k)
            if self.probe is not None:
                self.probed[k] = self.probe(float(self.time_s[k]))
            self.plant_in.values[driven:] = self.sent.values[self.give]
        for port, table in self.tables.items():
            table[k] = port.values
        if not last:
            self.plant_in.set()

    def _notice(self, k: int) -> None:
        slave = self.compensator

        def text() -> str:
            return slave.text(STATUS_TEXT) if slave and self.has_text else ""

        code, sensor = self._code(STATUS), self._code(STATUS_SENSOR)
        notice(self.events, float(self.time_s[k]), code, sensor, text)

    def _code(self, name: str) -> int:
        names = self.codes.names
        return int(self.codes.values[names.index(name)]) if name in names else 0

    def _read(self) -> None:
        for port in self.shown:
            port.get()

    # What remains

    def _table(self, port: Port) -> Iterator[tuple[str, FloatArray]]:
        return zip(port.names, self.tables[port].T, strict=True)

    def _recording(self, wall_s: float) -> Recording:
        columns: dict[str, FloatArray] = {"time_s": self.time_s}
        for name in self.case.signals | dict.fromkeys(self.wiring.driven):
            owner = self.plant if name in self.plant.variables else self.compensator
            assert owner is not None
            columns[owner.column(name)] = self.signals[name]
        sensors = []
        for name, values in self._table(self.plant_out):
            column = self.plant.column(name)
            columns[column] = values
            if not name.startswith(("drift_", "offset_", "error_")):
                sensors.append(column)
        if self.compensator:
            columns |= dict(self._compensator_columns(self.compensator))
        facts = [facts_of(slave) for slave in (self.plant, self.compensator) if slave]
        return Recording(
            self.case,
            pd.DataFrame(columns),
            tuple(sensors),
            columns_of(self.plant.path),
            tuple(self.events),
            tuple(facts),
            wall_s,
        )

    def _compensator_columns(self, compensator: Slave) -> Iterator[tuple[str, FloatArray]]:
        disturbed = {fault.sensor for fault in self.case.settings.faults}
        if self.case.settings.compensator.tool_length_mm is not None:
            disturbed.add(TOOL_LENGTH)
        for name, values in self._table(self.seen_in):
            if name in disturbed:
                source = self.plant if name in self.plant.variables else compensator
                signal, _, unit = source.column(name).rpartition("_")
                yield f"{signal}_seen_{unit}", values
        for port in self.shown[1:]:
            for name, values in self._table(port):
                yield compensator.column(name), values
        if self.probe is not None:
            yield f"{PROBED}_1", self.probed
