"""Simulation of a machine over a run, for one or many parameter sets at once."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
import pandas as pd

from plant_model.drive import Drive, drive_from
from plant_model.integrate import TOLERANCE
from plant_model.machine import Machine
from plant_model.network import effects_in_force, state_slices
from plant_model.parameters import FloatArray, Values
from plant_model.sensors import SensorNoise, column_of, readings
from plant_model.structure import drift_at, pose
from plant_model.trajectory import shared_trajectories

CHUNK_NUMBERS = 20_000_000
"""Most node temperatures kept at once; more parameter sets are simulated in turns: set on no data.
"""


@dataclass(frozen=True)
class Simulation:
    """The result of :func:`simulate`.

    Attributes
    ----------
    machine : Machine
    time_s : array, shape (T,)
        The rows of the inputs [s].
    inputs : dict of str to array, shape (T,)
        The inputs at these instants.
    readings : dict of str to array, shape (sets, T)
        Reading of every sensor, by name [degC or um].
    temperatures : array, shape (sets, T, nodes)
        Temperature of every node [degC].
    pose : array, shape (sets, T, 6)
        In the order of ``effects.base.POSE``.
    states : array, shape (sets, T, own states)
        Of the effects in force, in their order.
    """

    machine: Machine
    time_s: FloatArray
    inputs: dict[str, FloatArray]
    readings: dict[str, FloatArray]
    temperatures: FloatArray
    pose: FloatArray
    states: FloatArray

    def run_frame(self) -> pd.DataFrame:
        """Return the first parameter set's result as a run: inputs and readings by run column.

        Returns
        -------
        DataFrame, T rows
            ``time_s``, then inputs and readings under their run columns.
        """
        columns = {"time_s": self.time_s}
        shown = {column_of(self.machine, name): name for name in self.readings}
        for entry in self.machine.inputs:
            if entry.column not in shown:
                columns[entry.column] = self.inputs[entry.name]
        for column, name in shown.items():
            columns[column] = self.readings[name][0]
        return pd.DataFrame(columns)

    def without_first(self) -> Simulation:
        """Return the simulation without its first parameter set."""
        readings = {name: shown[1:] for name, shown in self.readings.items()}
        temperatures, pose, states = self.temperatures[1:], self.pose[1:], self.states[1:]
        return replace(self, readings=readings, temperatures=temperatures, pose=pose, states=states)

    def drift(self, tool_length_mm: float) -> FloatArray:
        """Return the drift of a tool tip [um], shape (sets, T, 3).

        Parameters
        ----------
        tool_length_mm : float
            From the gauge line to the tool tip [mm].

        Returns
        -------
        array, shape (sets, T, 3)
            Along +X, +Y and +Z [um].
        """
        return drift_at(self.pose, tool_length_mm)


def simulate(
    machine: Machine,
    inputs: pd.DataFrame,
    parameters: Mapping[str, float | FloatArray | Iterable[float]] | None = None,
    *,
    step_s: float = 10.0,
    noise_seed: int | None = None,
    tolerance: float = TOLERANCE,
    at: FloatArray | None = None,
    start: FloatArray | None = None,
    drive: Drive | None = None,
    bounded: bool = True,
) -> Simulation:
    """Simulate a machine over the rows of *inputs*.

    Parameters
    ----------
    machine : Machine
    inputs : DataFrame, T rows
        ``time_s`` and every input, by run column or input name, such as a run file's frame. Nodes
        that start at a sensor's reading take its first value there, if the frame has it.
    parameters : mapping of str to float or array, shape (sets,)
        Values to use instead of the machine's, by full name.
    step_s : float
        Longest internal step [s]. Results at rows denser than that are interpolated linearly;
        otherwise they are the model's own at each row.
    noise_seed : int, optional
        Adds each sensor's noise and resolution; without it the readings are exact.
    tolerance : float
        Local error allowed if a step is not exact [K].
    at : array, shape (T,), optional
        Instants of the results, instead of the rows [s].
    start : array, shape (sets or 1, nodes), optional
        Start temperatures, instead of those that the inputs give [degC].
    drive : Drive, optional
        The inputs on their grid, if already known; *step_s* is then ignored.
    bounded : bool
        Refuse a parameter outside its range.

    Returns
    -------
    Simulation
        At the rows, or at *at*.

    Raises
    ------
    DriveError
        If the inputs cannot drive the machine.
    ParameterError
        For an unknown parameter or a value outside its range.
    IntegrationError
        If a temperature-dependent model cannot be stepped within the tolerance.
    """
    drive = drive or drive_from(machine, inputs, step_s)
    (whole,) = simulate_all(
        machine,
        [Driven(inputs, drive, at, start)],
        parameters,
        tolerance=tolerance,
        bounded=bounded,
    )
    if noise_seed is None:
        return whole
    shape = (len(whole.readings), *whole.temperatures.shape[:2])
    normal = np.random.default_rng(noise_seed).standard_normal(shape)
    return replace(whole, readings=SensorNoise(machine).added(whole.readings, normal))


@dataclass(frozen=True)
class Driven:
    """One run to simulate.

    Attributes
    ----------
    inputs : DataFrame
        The run's frame; nodes start at its first readings.
    drive : Drive
        Its inputs on their grid.
    at : array, shape (T,), optional
        Instants of the results, instead of the rows [s].
    start : array, shape (sets or 1, nodes), optional
        Start temperatures, instead of those that the inputs give [degC].
    """

    inputs: pd.DataFrame
    drive: Drive
    at: FloatArray | None = None
    start: FloatArray | None = None


def simulate_all(
    machine: Machine,
    runs: Sequence[Driven],
    parameters: Mapping[str, float | FloatArray | Iterable[float]] | None = None,
    *,
    tolerance: float = TOLERANCE,
    bounded: bool = True,
    near: bool = False,
) -> list[Simulation]:
    """Simulate a machine over several runs, each with all parameter sets.

    If something depends on temperature, this costs hardly more than one run.

    Parameters
    ----------
    machine : Machine
    runs : sequence of Driven
        Either all with a start or all without.
    parameters, tolerance, bounded
        As for :func:`simulate`, the tolerance [K].
    near : bool
        Step all sets to first order about the first one, which is enough for derivatives. Pose and
        readings follow from the temperatures as usual.

    Returns
    -------
    list of Simulation
        One for each run.
    """
    everything = Values(machine.parameters, parameters, bounded=bounded)
    begun = [_Begun.of(machine, run) for run in runs]
    for run in begun:
        everything.widen(len(run.starts))
    same = _same(begun)
    instants = sum(len(runs[i].drive.grid) for i in set(same))
    per_turn = max(1, CHUNK_NUMBERS // (instants * len(machine.nodes)))
    turns = []
    for at_set in range(0, everything.sets, per_turn):
        sets = np.arange(at_set, min(at_set + per_turn, everything.sets))
        if near and at_set:
            sets = np.append(0, sets)
        values = everything.of_sets(sets) if everything.sets > per_turn else everything
        some = [run.of_sets(sets) for run in begun]
        simulated = _simulate_some(machine, values, some, same, tolerance, near=near)
        turns.append([run.without_first() for run in simulated] if near and at_set else simulated)
    return [_joined(parts) for parts in zip(*turns, strict=True)]


def _same(runs: Sequence[_Begun]) -> list[int]:
    """Return for each run the position of the first with the same inputs and start.

    The pieces of a long log are driven alike.
    """
    same: list[int] = []
    for run in runs:
        alike = (i for i in dict.fromkeys(same) if runs[i].is_like(run))
        same.append(next(alike, len(same)))
    return same


@dataclass(frozen=True)
class _Begun:
    """A run with its start temperatures, (sets or 1, nodes).

    It also holds the nodes, by position, that start at a sensor's reading, with that sensor.
    """

    run: Driven
    starts: FloatArray
    read: dict[int, str]

    @classmethod
    def of(cls, machine: Machine, run: Driven) -> _Begun:
        first = _first_readings(machine, run.inputs) if run.start is None else {}
        starts = _starts(machine, run.drive, first)[None] if run.start is None else run.start
        return cls(run, starts, _read_at_start(machine, run.drive, first))

    def is_like(self, other: _Begun) -> bool:
        """Whether another run has the same inputs and start."""
        same_start = np.array_equal(self.starts, other.starts, equal_nan=True)
        return same_start and self.read == other.read and self.run.drive.is_like(other.run.drive)

    def of_sets(self, sets: npt.NDArray[np.intp]) -> _Begun:
        return self if len(self.starts) == 1 else replace(self, starts=self.starts[sets])


def _joined(parts: Sequence[Simulation]) -> Simulation:
    head = parts[0]
    if len(parts) == 1:
        return head
    return Simulation(
        head.machine,
        head.time_s,
        head.inputs,
        {name: np.concatenate([p.readings[name] for p in parts]) for name in head.readings},
        np.concatenate([part.temperatures for part in parts]),
        np.concatenate([part.pose for part in parts]),
        np.concatenate([part.states for part in parts]),
    )


def start_readings(machine: Machine, inputs: pd.DataFrame) -> dict[str, float]:
    """Return the start temperature at each thermometer that nodes start at [degC], by its name.

    This is its first reading minus the error that the machine's effects add there. Thermometers
    without a reading in the frame are left out.

    Parameters
    ----------
    machine : Machine
    inputs : DataFrame
        The run's frame.

    Returns
    -------
    dict of str to float
        [degC].
    """
    effects = effects_in_force(machine, Values(machine.parameters, None))
    first = _first_readings(machine, inputs)
    for effect in effects:
        if effect.channel in first:
            first[effect.channel] -= float(effect.error_at_start()[0, 0])
    return first


def _starts(machine: Machine, drive: Drive, first: dict[str, float]) -> FloatArray:
    """Return the start temperature of each node; *first* is the sensors' first readings, by name.

    NaN for nodes that start at rest: they are found from the others.
    """
    usual = next(iter(drive.first.values()))[0]
    signals = first | {name: values[0] for name, values in drive.first.items()}
    return np.array(
        [np.nan if node.rests else node.starts_at(signals, usual) for node in machine.nodes]
    )


def _first_readings(machine: Machine, inputs: pd.DataFrame) -> dict[str, float]:
    """Return the first readings of the sensors that nodes start at, if the frame has them."""
    first = {}
    for name in {node.start for node in machine.nodes}:
        if (column := f"{name}_degC") in inputs:
            read = inputs[column].to_numpy(dtype=np.float64)
            present = np.isfinite(read)
            if present.any():
                first[name] = float(read[present.argmax()])
    return first


def _read_at_start(machine: Machine, drive: Drive, first: dict[str, float]) -> dict[int, str]:
    """Return the nodes, by position, that start at a sensor's reading, with that sensor."""
    return {
        i: node.start
        for i, node in enumerate(machine.nodes)
        if node.start not in drive.first and node.start in first
    }


def _simulate_some(
    machine: Machine,
    values: Values,
    runs: Sequence[_Begun],
    same: Sequence[int],
    tolerance: float,
    *,
    near: bool,
) -> list[Simulation]:
    effects = effects_in_force(machine, values)
    slices, nodes = state_slices(effects), len(machine.nodes)
    stepped = list(dict.fromkeys(same))
    starts = []
    for run in (runs[i] for i in stepped):
        start = np.broadcast_to(run.starts, (values.sets, nodes))
        for node, sensor in run.read.items():
            for effect in effects:
                if effect.channel == sensor:
                    start = start.copy()
                    share = machine.nodes[node].start_share
                    start[:, node] -= share * effect.error_at_start()[:, 0]
        starts.append(start)
    drives = [runs[i].run.drive for i in stepped]
    courses = shared_trajectories(machine, values, effects, drives, starts, tolerance, near=near)
    of_run = dict(zip(stepped, courses, strict=True))
    simulations = []
    for begun, which in zip(runs, same, strict=True):
        drive, on_grid, at = begun.run.drive, of_run[which], begun.run.at
        time = begun.run.inputs["time_s"].to_numpy(dtype=np.float64) if at is None else at
        inputs = drive.rows if at is None else drive.inputs_at(at)
        wanted = at_rows(drive.grid, on_grid, time)
        temperatures, states = wanted[..., :nodes], wanted[..., nodes:]
        rise = temperatures - on_grid[:, :1, :nodes]
        moved = pose(effects, slices, inputs, rise, states)
        since = time - drive.grid[0]
        shown = readings(machine, effects, slices, inputs, since, temperatures, states, moved)
        simulations.append(Simulation(machine, time, inputs, shown, temperatures, moved, states))
    return simulations


def at_rows(grid: FloatArray, values: FloatArray, time: FloatArray) -> FloatArray:
    """Return values at the rows' instants, interpolated linearly between the grid's instants.

    Parameters
    ----------
    grid : array, shape (grid,)
        Instants of the values, increasing [s].
    values : array, shape (sets, grid, size)
    time : array, shape (T,)
        The rows [s].

    Returns
    -------
    array, shape (sets, T, size)
    """
    if len(time) == len(grid) and np.array_equal(time, grid):
        return values
    step = np.clip(np.searchsorted(grid, time, side="right") - 1, 0, len(grid) - 2)
    share = (time - grid[step]) / (grid[step + 1] - grid[step])
    if np.all(share == 0.0):
        return np.asarray(values[:, step])
    before, wanted = values[:, step], values[:, step + 1]
    wanted -= before
    wanted *= share[None, :, None]
    wanted += before
    return np.asarray(wanted)
