"""What calibration and the gap finder compare: measured runs as weighted observations.

Rows are gathered into bins of two minutes, so that sampling does not decide how much a run counts:
each channel of a run weighs as many independent values as it has half hours. A bin ends where the
speed changes, because what moves at once tells most there. Readings after a change are trusted less
the longer the sampling interval, because its instant is known no better than that.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt
import pandas as pd

from measurement.errors import BadInput
from measurement.runs import Run
from plant_model.drive import SWITCH, Drive, drive_from
from plant_model.machine import Machine
from plant_model.parameters import FloatArray
from plant_model.sensors import column_of, displacement_names, noise_and_resolution

BIN_S = 120.0
"""Width of a bin, and step while fitting [s]; exact where the network is linear. Set on no data."""

INDEPENDENT_S = 1800.0
"""Time after which a misfit is new evidence [s]: misfits of lumped models last that long. Set on
no data."""

TEMPERATURE_TOLERANCE = 0.1
DISPLACEMENT_TOLERANCE = 0.5
"""What a good lumped model may be wrong by, beside noise [K, um]; set on no data."""

SPARSE_S = 90.0
"""Rows further apart than this are taken not to have been written for the switch [s]; set on no
data."""

SHARP_S = 30.0
"""Rows no further apart than this give a switch's instant well enough [s], and are taken together
where a part switches: no cooler does so as fast. Set on no data."""

MOST_SWITCHES = 0.3
"""An input that switches at more than this share of the rows is taken as a ramp [1]; set on no
data."""

RELATIVE_TOLERANCE = 0.02
"""Tolerance beside the constant one, as a share of the channel's span in the runs [1]; set on no
data."""


@dataclass(frozen=True)
class Switch:
    """A change of held inputs between two rows.

    Attributes
    ----------
    uncertain_s : float
        Standard deviation of its instant [s].
    later : Drive
        The run's inputs with this switch *later_s* later (negative: earlier).
    later_s : float
        [s]
    """

    uncertain_s: float
    later: Drive
    later_s: float


@dataclass(frozen=True)
class Observations:
    """One run's observations.

    Attributes
    ----------
    run : Run
        Its frame drives the simulation.
    time_s : array, shape (K,)
        Mean time of the rows in each bin [s].
    channels : tuple of str
        Sensor names, temperatures first.
    values : array, shape (K, C)
        Measured [degC, um]; NaN where missing. Displacements start at zero.
    weights : array, shape (K, C)
        One over the tolerance, scaled so that a channel weighs its independent values; 0 where
        there is nothing to compare.
    tolerance : array, shape (C,)
        Of each channel [K, um].
    drive : Drive
        The run's inputs on a grid that has the middle of every bin.
    absent : frozenset of str
        Keys of effects that had not begun yet in this run.
    own : dict of str to float
        Parameters, by full name, that have a value of their own in this run.
    switches : tuple of Switch
        Changes of held inputs whose instant is not known well.
    """

    run: Run
    time_s: FloatArray
    channels: tuple[str, ...]
    values: FloatArray
    weights: FloatArray
    tolerance: FloatArray
    drive: Drive
    absent: frozenset[str] = frozenset()
    own: dict[str, float] = field(default_factory=dict)
    switches: tuple[Switch, ...] = ()

    @property
    def first(self) -> FloatArray:
        """The first reading of each channel, shape (C,) [degC, um]; NaN without one."""
        rows = np.isfinite(self.values).argmax(axis=0)
        return np.asarray(self.values[rows, np.arange(len(rows))])

    @property
    def moved(self) -> FloatArray:
        """How far each channel is from its first reading, shape (K, C) [K, um]."""
        return self.values - self.first

    def weighted(self, modelled: FloatArray) -> FloatArray:
        """Return weighted model minus measurement, shape (..., K C); 0 where nothing was measured.

        Parameters
        ----------
        modelled : array, shape (..., K, C)
            What the model shows [degC, um].
        """
        difference = (modelled - np.nan_to_num(self.values)) * self.weights
        return difference.reshape(*modelled.shape[:-2], -1)

    def with_series(self, name: str, series: Callable[[Drive], FloatArray]) -> Observations:
        """Return observations whose inputs hold one more series, wherever a switch is put.

        Parameters
        ----------
        name : str
        series : callable
            From a drive to an array for its steps, shape (K,).
        """

        def with_it(drive: Drive) -> Drive:
            return replace(drive, held={**drive.held, name: series(drive)})

        switches = tuple(replace(switch, later=with_it(switch.later)) for switch in self.switches)
        return replace(self, drive=with_it(self.drive), switches=switches)


def compared_channels(machine: Machine, runs: Sequence[Run]) -> tuple[str, ...]:
    """Return the sensors that the machine has and the runs hold, boundary readings left out.

    Raises
    ------
    BadInput
        If no channel is left to compare.
    """
    columns = set().union(*(run.frame.columns for run in runs))
    driving = {entry.column for entry in machine.inputs}
    names = [sensor.name for sensor in machine.sensors] + displacement_names(machine)
    channels = tuple(name for name in names if column_of(machine, name) in columns - driving)
    if not channels:
        wanted = ", ".join(column_of(machine, name) for name in names)
        raise BadInput(
            runs[0].path or runs[0].name, "", f"has no column to compare; one of {wanted}"
        )
    return channels


def observe(
    machine: Machine,
    runs: Sequence[Run],
    bad: dict[str, list[tuple[str, float, float]]] | None = None,
    channels: tuple[str, ...] = (),
) -> list[Observations]:
    """Gather the observations of some runs.

    Parameters
    ----------
    machine : Machine
        Says which column is which sensor's.
    runs : sequence of Run
    bad : dict of run name to list of (channel, start, end), optional
        Spans to leave out [s].
    channels : tuple of str, optional
        Those of other runs that these are to be set beside, whether these hold them or not; all
        that they hold if empty.

    Returns
    -------
    list of Observations
        One for each run, in their order.

    Raises
    ------
    BadInput
        When a run has no usable rows or no channel.
    """
    channels = channels or compared_channels(machine, runs)
    binned = [_binned(machine, run, channels, (bad or {}).get(run.name, [])) for run in runs]
    together = np.concatenate([values for _, values, _ in binned])
    span = _span(together)
    lengths = np.array([name in displacement_names(machine) for name in channels])
    own = np.where(lengths, DISPLACEMENT_TOLERANCE, TEMPERATURE_TOLERANCE)
    noise = stated_noise(machine, channels)
    tolerance = np.sqrt(noise**2 + own**2 + (RELATIVE_TOLERANCE * span) ** 2)
    observed = []
    for run, (time, values, segment) in zip(runs, binned, strict=True):
        extra = _switch_uncertainty(run, time, values, segment)
        sigma = np.sqrt(tolerance**2 + extra**2)
        present = np.isfinite(values)
        weights = np.where(present, 1.0 / sigma, 0.0)
        covered = present.sum(axis=0) * _median_step(time)
        share = np.maximum(covered / INDEPENDENT_S, 1.0) / np.maximum(present.sum(axis=0), 1)
        drive, switches = _driven(machine, run)
        weights *= np.sqrt(share)
        observed.append(
            Observations(run, time, channels, values, weights, tolerance, drive, switches=switches)
        )
    return observed


def stated_noise(machine: Machine, channels: Sequence[str]) -> FloatArray:
    """Return each channel's noise as the file has it, resolution included, (C,) [K, um]."""
    table = noise_and_resolution(machine)
    return np.array([np.hypot(table[n][0], table[n][1] / np.sqrt(12.0)) for n in channels])


def _driven(machine: Machine, run: Run) -> tuple[Drive, tuple[Switch, ...]]:
    """Put a run's inputs on an even grid; uneven rows would make every step its own case.

    A switch lies somewhere between the last row without it and the first with it, often at the
    latter, for many recorders write a row when something changes. Where these are far apart it is
    put in the middle; in any case, how the run would look with it at another instant is kept, too.
    """
    rows = run.time_s
    changed = np.flatnonzero(np.diff(_segments(machine, run))) + 1
    starts = np.append(rows[0], rows[changed])
    ends = np.append(rows[changed], rows[-1])
    middles = np.concatenate(
        [np.arange(a + BIN_S / 2.0, b, BIN_S) for a, b in zip(starts, ends, strict=True)]
    )
    between = rows[changed] - rows[changed - 1]
    unclear = changed[between > SHARP_S]
    sparse = between[between > SHARP_S] > SPARSE_S
    instants = {
        int(row): float(rows[row - 1 : row + 1].mean() if middle else rows[row])
        for row, middle in zip(unclear, sparse, strict=True)
    }

    def drive(at: dict[int, float]) -> Drive:
        return drive_from(machine, _switched_at(machine, run, at), BIN_S, at=middles)

    switches = []
    for row in unclear.tolist():
        interval = float(rows[row] - rows[row - 1])
        later_s = -0.2 * interval
        # Standard deviation of an even law between the rows, about where the switch was put.
        off = instants[row] - float(rows[row - 1 : row + 1].mean())
        spread = float(np.sqrt(interval**2 / 12.0 + off**2))
        switches.append(Switch(spread, drive(instants | {row: instants[row] + later_s}), later_s))
    return drive(instants), tuple(switches)


def _switched_at(machine: Machine, run: Run, instants: dict[int, float]) -> pd.DataFrame:
    """Return a run's frame with a further row at every instant at which inputs switch already."""
    if not instants:
        return run.frame
    held = [e.column for e in machine.inputs if not e.is_boundary and e.column in run.frame.columns]
    extra = run.frame.iloc[list(instants)][["time_s", *held]].copy()
    extra["time_s"] = list(instants.values())
    both = pd.concat([run.frame, extra]).drop_duplicates("time_s")
    return both.sort_values("time_s", ignore_index=True)


def _segments(machine: Machine, run: Run) -> npt.NDArray[np.int64]:
    """Return for each row how often speed or another held input has switched so far."""
    switched = np.zeros(len(run.time_s), dtype=bool)
    for entry in machine.inputs:
        if entry.is_boundary or entry.column not in run.frame.columns:
            continue
        held = run.frame[entry.column].ffill().bfill().to_numpy(dtype=np.float64)
        jumps = np.abs(np.diff(held)) > SWITCH * (entry.high - entry.low)
        # An input that jumps all the time is a ramp or noise, and has no instants to speak of.
        if jumps.mean() <= MOST_SWITCHES:
            switched[1:] |= jumps
    return np.cumsum(switched)


def _median_step(time: FloatArray) -> float:
    return float(np.median(np.diff(time))) if len(time) > 1 else BIN_S


def _span(values: FloatArray) -> FloatArray:
    """Return how far each channel moves, without its few farthest values; 0 if it has none."""
    filled = np.where(np.isfinite(values).any(axis=0), values, 0.0)
    low, high = np.nanpercentile(filled, [2, 98], axis=0)
    return np.asarray(high - low)


def _binned(
    machine: Machine, run: Run, channels: tuple[str, ...], bad: list[tuple[str, float, float]]
) -> tuple[FloatArray, FloatArray, npt.NDArray[np.int64]]:
    """Return bin times, mean values (displacements from zero), and each bin's segment."""
    rows = run.time_s
    if len(rows) < 3:
        raise BadInput(run.path or run.name, "", "has fewer than three rows")
    segment = _segments(machine, run)
    start = rows[np.searchsorted(segment, segment)]
    fresh = np.diff(np.floor((rows - start) / BIN_S), prepend=-1) != 0
    fresh |= np.diff(segment, prepend=-1) != 0
    which = np.cumsum(fresh) - 1
    counts = np.bincount(which)
    time = np.bincount(which, rows) / counts
    values = np.full((len(time), len(channels)), np.nan)
    for i, name in enumerate(channels):
        column = column_of(machine, name)
        if column not in run.frame.columns:
            continue
        series = run.frame[column].to_numpy(dtype=np.float64).copy()
        for channel, first, last in bad:
            if channel == name:
                series[(rows >= first) & (rows <= last)] = np.nan
        good = np.isfinite(series)
        if not good.any():
            continue
        n = np.bincount(which[good], minlength=len(time))
        total = np.bincount(which[good], series[good], minlength=len(time))
        values[:, i] = np.where(n > 0, total / np.maximum(n, 1), np.nan)
        if column.endswith("_um"):
            values[:, i] -= series[good][0]
    return time, values, segment[fresh]


def _switch_uncertainty(
    run: Run, time: FloatArray, values: FloatArray, segment: npt.NDArray[np.int64]
) -> FloatArray:
    """Return how far a reading may be off because a switch's instant is not known, (K, C)."""
    extra = np.zeros_like(values)
    for k in (np.flatnonzero(np.diff(segment)) + 1).tolist():
        row = int(np.searchsorted(run.time_s, time[k] - BIN_S, side="right"))
        interval = float(np.median(np.diff(run.time_s[max(row - 3, 0) : row + 5])))
        after = slice(k, k + 3)
        if k + 1 < len(time):
            rate = np.abs(np.gradient(np.nan_to_num(values[after]), time[after], axis=0))
            extra[after] = rate * interval / 2.0
    return extra
