"""Measured runs as weighted observations, for calibration and the gap finder.

Rows are averaged in bins of two minutes, so that a run's weight does not depend on its sampling:
each channel of a run counts as one independent value per half hour. A bin ends where the speed
changes, because immediate responses show most clearly there. Its instant is known no better than
the rows tell: an unknown of the run.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt
import pandas as pd

from measurement.errors import BadInput
from measurement.runs import TIME, Run
from plant_model.drive import Drive, DriveError, drive_from, switched
from plant_model.machine import Machine
from plant_model.parameters import FloatArray
from plant_model.sensors import column_of, displacement_names, noise_and_resolution

BIN_S = 120.0
"""Width of a bin, and step while fitting [s]; exact where the network is linear. Set on no data."""

INDEPENDENT_S = 1800.0
"""Time after which a misfit is independent evidence [s]: misfits of lumped models last that long.
Set on no data."""

TEMPERATURE_TOLERANCE = 0.1
DISPLACEMENT_TOLERANCE = 0.5
"""Error allowed to a good lumped model, in addition to noise [K, um]; set on no data."""

SHARP_S = BIN_S / 4.0
"""Rows at most this far apart give a switch's instant well enough [s]. They are averaged if a part
switches a cooler, which is never that fast."""

RELATIVE_TOLERANCE = 0.02
"""Additional tolerance, as a share of the channel's span in the runs [1]; set on no data."""


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
        One over the tolerance, scaled so that a channel counts as its number of independent values;
        0 where nothing was measured.
    tolerance : array, shape (C,)
        Of each channel [K, um].
    noise : array, shape (C,)
        Of each channel, with resolution [K, um].
    lengths : array of bool, shape (C,)
        Which channels are displacements.
    zero_s : array, shape (C,)
        When each displacement is zeroed: at its first reading [s].
    drive : Drive
        The run's inputs on a grid that contains the middle of every bin.
    absent : frozenset of str
        Keys of effects that had not begun yet in this run.
    own : dict of str to float
        Parameters, by full name, with a separate value in this run.
    earlier : tuple of Drive
        The same with one switch of a held input a standard deviation earlier, for each switch whose
        instant is unclear.
    """

    run: Run
    time_s: FloatArray
    channels: tuple[str, ...]
    values: FloatArray
    weights: FloatArray
    tolerance: FloatArray
    noise: FloatArray
    lengths: npt.NDArray[np.bool_]
    zero_s: FloatArray
    drive: Drive
    absent: frozenset[str] = frozenset()
    own: dict[str, float] = field(default_factory=dict)
    earlier: tuple[Drive, ...] = ()

    @property
    def first(self) -> FloatArray:
        """The first reading of each channel, shape (C,) [degC, um]; NaN if there is none."""
        rows = np.isfinite(self.values).argmax(axis=0)
        return np.asarray(self.values[rows, np.arange(len(rows))])

    @property
    def moved(self) -> FloatArray:
        """Change of each channel since its first reading, shape (K, C) [K, um]."""
        return self.values - self.first

    def weighted(self, modelled: FloatArray) -> FloatArray:
        """Return weighted model minus measurement, shape (..., K C); 0 where nothing was measured.

        Parameters
        ----------
        modelled : array, shape (..., K, C)
            Channels of the model [degC, um].
        """
        return self.response(modelled - np.nan_to_num(self.values))

    def response(self, changed: FloatArray) -> FloatArray:
        """Return a change of the channels times their weights, shape (..., K C) [1].

        Parameters
        ----------
        changed : array, shape (..., K, C)
            [K, um]
        """
        return np.asarray((changed * self.weights).reshape(*changed.shape[:-2], self.weights.size))

    def response_in(self, channel: int, series: FloatArray | float) -> FloatArray:
        """Return a change of one channel, (K,) [K, um], times its weights, shape (K C,) [1]."""
        changed = np.zeros_like(self.weights)
        changed[:, channel] = series
        return self.response(changed)

    def columns(self, responses: Sequence[FloatArray]) -> FloatArray:
        """Return some responses, each (K C,), as columns, shape (K C, m); there may be none."""
        return np.array(responses).reshape(len(responses), self.weights.size).T

    def unit_of(self, channel: int) -> str:
        """Return the unit of a change of a channel."""
        return "um" if self.lengths[channel] else "K"

    def with_series(self, name: str, series: Callable[[Drive], FloatArray]) -> Observations:
        """Return observations with one more input series, also in the drives with a switch earlier.

        Parameters
        ----------
        name : str
        series : callable
            Returns the series for the steps of a drive, shape (K,).
        """

        def with_it(drive: Drive) -> Drive:
            return replace(drive, held={**drive.held, name: series(drive)})

        return replace(self, drive=with_it(self.drive), earlier=tuple(map(with_it, self.earlier)))


def compared_channels(machine: Machine, runs: Sequence[Run]) -> tuple[str, ...]:
    """Return the sensors present in both the machine and the runs, without its inputs.

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
    channels: tuple[str, ...] = (),
) -> list[Observations]:
    """Return the observations of some runs.

    Parameters
    ----------
    machine : Machine
        Assigns columns to sensors.
    runs : sequence of Run
    channels : tuple of str, optional
        Channels to use even if these runs lack some, to compare them with other runs; by default
        all that they contain.

    Returns
    -------
    list of Observations
        One for each run, in their order.

    Raises
    ------
    BadInput
        If a run has fewer than three rows or cannot drive the machine, or no channel is left.
    """
    channels = channels or compared_channels(machine, runs)
    lengths = np.array([name in displacement_names(machine) for name in channels])
    binned = [_binned(machine, run, channels, lengths) for run in runs]
    together = np.concatenate([values for _, values, _ in binned])
    span = _span(together)
    own = np.where(lengths, DISPLACEMENT_TOLERANCE, TEMPERATURE_TOLERANCE)
    noise = _noise(machine, channels, lengths)
    tolerance = np.sqrt(noise**2 + own**2 + (RELATIVE_TOLERANCE * span) ** 2)
    observed = []
    for run, (time, values, zero) in zip(runs, binned, strict=True):
        present = np.isfinite(values)
        covered = present.sum(axis=0) * _median_step(time)
        share = np.maximum(covered / INDEPENDENT_S, 1.0) / np.maximum(present.sum(axis=0), 1)
        try:
            drive, earlier = _driven(machine, run, float(time[-1]))
        except DriveError as error:
            raise BadInput(run.path or run.name, "", str(error)) from None
        weights = np.where(present, np.sqrt(share) / tolerance, 0.0)
        observed.append(
            Observations(
                *(run, time, channels, values, weights, tolerance, noise, lengths, zero, drive),
                earlier=earlier,
            )
        )
    return observed


def _noise(machine: Machine, channels: Sequence[str], lengths: npt.NDArray[np.bool_]) -> FloatArray:
    """Return each channel's noise from the machine file, with resolution, (C,) [K, um]."""
    table = noise_and_resolution(machine)
    stated = np.array([np.hypot(table[n][0], table[n][1] / np.sqrt(12.0)) for n in channels])
    # A sensor without a stated noise is assumed to have a usual one.
    return np.where(stated > 0.0, stated, np.where(lengths, 0.2, 0.03))


def _driven(machine: Machine, run: Run, until_s: float) -> tuple[Drive, tuple[Drive, ...]]:
    """Put a run's inputs on an even grid; with uneven rows every step would be a separate case.

    Also return the drives with one of its unclear switches until the last observation earlier.

    A switch lies between the last row without it and the first with it, often at the latter,
    because many recorders write a row when something changes. It is placed there, or in the middle
    if the rows are more than a bin apart; unless they are close, its instant is unclear by the root
    mean square of a uniform law.
    """
    rows = run.time_s
    changed = np.flatnonzero(np.diff(_segments(machine, run))) + 1
    starts = np.append(rows[0], rows[changed])
    ends = np.append(rows[changed], rows[-1])
    middles = np.concatenate(
        [np.arange(a + BIN_S / 2.0, b, BIN_S) for a, b in zip(starts, ends, strict=True)]
    )

    def drive(at_s: dict[int, float]) -> Drive:
        return drive_from(machine, _switched_at(machine, run, at_s), BIN_S, middles)

    apart = {row: float(rows[row] - rows[row - 1]) for row in changed.tolist()}
    placed = {row: rows[row] - gap_s / 2.0 for row, gap_s in apart.items() if gap_s > BIN_S}
    earlier = []
    for row, gap_s in apart.items():
        if gap_s > SHARP_S and rows[row - 1] < until_s:
            unclear_s = gap_s / np.sqrt(12.0 if row in placed else 3.0)
            earlier.append(drive(placed | {row: placed.get(row, rows[row]) - unclear_s}))
    return drive(placed), tuple(earlier)


def _switched_at(machine: Machine, run: Run, at_s: dict[int, float]) -> pd.DataFrame:
    """Return a run's frame with the held inputs of some rows also at instants before them."""
    held = [e.column for e in machine.inputs if not e.is_boundary and e.column in run.frame.columns]
    extra = run.frame.iloc[list(at_s)][[TIME, *held]].assign(**{TIME: list(at_s.values())})
    return pd.concat([run.frame, extra]).sort_values(TIME, ignore_index=True) if at_s else run.frame


def _segments(machine: Machine, run: Run) -> npt.NDArray[np.int64]:
    """Return for each row how often the speed or another held input has switched so far."""
    held = {
        entry.name: run.frame[entry.column].ffill().bfill().to_numpy(dtype=np.float64)
        for entry in machine.inputs
        if not entry.is_boundary and entry.column in run.frame.columns
    }
    return np.cumsum(switched(machine, held, run.time_s, BIN_S))


def _median_step(time: FloatArray) -> float:
    return float(np.median(np.diff(time))) if len(time) > 1 else BIN_S


def _span(values: FloatArray) -> FloatArray:
    """Return the span of each channel without its extreme values; 0 if it has no values."""
    filled = np.where(np.isfinite(values).any(axis=0), values, 0.0)
    low, high = np.nanpercentile(filled, [2, 98], axis=0)
    return np.asarray(high - low)


def _binned(
    machine: Machine, run: Run, channels: tuple[str, ...], lengths: npt.NDArray[np.bool_]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return bin times, mean values (displacements from zero), and when each channel begins."""
    rows = run.time_s
    if len(rows) < 3:
        raise BadInput(run.path or run.name, "", "has fewer than three rows")
    segment = _segments(machine, run)
    start = rows[np.searchsorted(segment, segment)]
    fresh = np.diff(np.floor((rows - start) / BIN_S), prepend=-1) != 0
    fresh |= np.diff(segment, prepend=-1) != 0
    readings = run.frame.reindex(columns=[column_of(machine, name) for name in channels])
    begins = rows[readings.notna().to_numpy().argmax(axis=0)]
    readings -= readings.bfill().iloc[0].where(lengths, 0.0)
    tables = (run.frame[TIME], readings)
    time, values = (table.groupby(np.cumsum(fresh)).mean().to_numpy() for table in tables)
    read = np.isfinite(values).any(axis=1)
    read |= not read.any()
    return time[read], values[read], begins
