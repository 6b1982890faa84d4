"""How well any model with these inputs could do: ridge regression on lagged inputs.

A model that knew everything would still only have the recorded inputs and how warm the machine was
when the run began. What first-order lags of these predict in a run, fitted to the other runs, some
model can predict, too. What they predict of what the plant leaves is the *reducible* gap: it is
there to be explained, and which input at which lag predicts it says where to look. The rest does
not follow from the inputs, or not in the same way from run to run.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from gap_finder.observations import Observations
from gap_finder.regimes import RunResiduals, mean_squares, regimes
from plant_model.machine import Machine
from plant_model.parameters import FloatArray
from plant_model.sensors import displacement_names

LAGS_MIN = (3.0, 8.0, 20.0, 45.0, 100.0, 220.0, 500.0)
"""Time constants of the lags [min]: from a bearing's to a machine bed's, each some 2.3 times the
one before, so that a lag in between is well met by two of them. Set on no data."""

PENALTIES = tuple(0.01 * 10.0 ** (0.5 * k) for k in range(10))
"""Ridge penalties tried, per observation and for predictors of unit mean square [1]."""

START = "start"
"""What the predictors are called that say how warm the machine started."""

LEAST_PREDICTED = 0.1
"""Share of what the plant leaves that an input must predict to be told [1]; set on no data."""


@dataclass(frozen=True)
class Predictor:
    """What predicts a part of what the plant leaves.

    Attributes
    ----------
    input : str
        Of the machine, or ``start``: how warm it was when the run began.
    lag_min : float
        The one lag that predicts most by itself [min].
    share : float
        What all lags of this input together predict, of mean squares, in runs that they were not
        fitted to [1].
    """

    input: str
    lag_min: float
    share: float


@dataclass(frozen=True)
class ReducibleGap:
    """Where the reducible gap lies: a channel in a regime, over all runs with it.

    Attributes
    ----------
    channel, regime, unit : str
    rms, reference : float
        Of what the plant leaves there, and of what the reference leaves of it [unit].
    tolerances : float
        The root of the difference of their squares, in tolerances [1].
    """

    channel: str
    regime: str
    rms: float
    reference: float
    unit: str
    tolerances: float


class ReferenceModel:
    """The reference on some runs, each predicted from the others, and on runs never used.

    Parameters
    ----------
    machine : Machine
        Says what the inputs are.
    used : sequence of RunResiduals
        What the plant leaves of two runs or more.
    unseen : sequence of RunResiduals
        Of runs to be predicted from all of those.

    Attributes
    ----------
    used, unseen : list of array, each (K, C)
        What the reference leaves of each run [K, um]; NaN where nothing was measured. Of its two
        forms, on the readings and on what the plant leaves of them, each channel has the one that
        does better on the runs used, or what the plant leaves if that is least.
    reducible : float
        Mean square that can be predicted of what the plant leaves of the runs used, over all
        channels [tolerances squared].
    share : float
        The same as a share of all that it leaves [1].
    """

    def __init__(
        self, machine: Machine, used: Sequence[RunResiduals], unseen: Sequence[RunResiduals] = ()
    ) -> None:
        self._machine, self._used = machine, used
        self._predictors = _Predictors(machine, [run.observed for run in used])
        later = [self._predictors.of(run.observed) for run in unseen]
        left = [run.values for run in used]
        moved = [run.observed.moved for run in used]
        self._tolerance = used[0].observed.tolerance
        of_left = _Ridge(self._predictors.used, self._scaled(left))
        of_moved = _Ridge(self._predictors.used, self._scaled(moved))
        tried = [
            [np.zeros_like(part) for part in left],
            [part * self._tolerance for part in of_left.predicted],
            [
                own - (there - part * self._tolerance)
                for own, there, part in zip(left, moved, of_moved.predicted, strict=True)
            ],
        ]
        costs = np.array([mean_squares(_less(left, part)) for part in tried])
        choice = np.argmin(np.nan_to_num(costs, nan=np.inf), axis=0)
        self.used = _less(left, [_chosen(choice, parts) for parts in zip(*tried, strict=True)])
        self.unseen = []
        for run, x in zip(unseen, later, strict=True):
            readings = run.values - (run.observed.moved - of_moved.of(x) * self._tolerance)
            options = (np.zeros_like(run.values), of_left.of(x) * self._tolerance, readings)
            self.unseen.append(run.values - _chosen(choice, options))
        before, after = (mean_squares(part) / self._tolerance**2 for part in (left, self.used))
        self.reducible = float(np.nanmean(before - after)) if np.isfinite(before).any() else 0.0
        self.share = self.reducible / max(float(np.nanmean(before)), 1e-12)

    def _scaled(self, parts: Sequence[FloatArray]) -> list[FloatArray]:
        return [part / self._tolerance for part in parts]

    def places(self, most: int = 8) -> list[ReducibleGap]:
        """Return where the reducible gap lies, most of it first, above one tolerance."""
        groups: dict[tuple[int, str], list[tuple[FloatArray, FloatArray]]] = {}
        for run, left in zip(self._used, self.used, strict=True):
            time = run.observed.time_s
            for start, end, regime in regimes(run.observed):
                rows = (time >= start) & (time <= end)
                # Not the speed: no channel is told at every step of a spectrum.
                doing = regime.partition(", at ")[0]
                for i in range(left.shape[1]):
                    groups.setdefault((i, doing), []).append((run.values[rows, i], left[rows, i]))
        lengths = set(displacement_names(self._machine))
        names = self._used[0].observed.channels
        found: list[tuple[float, ReducibleGap]] = []
        for (i, regime), parts in groups.items():
            before, after = (np.concatenate(part) for part in zip(*parts, strict=True))
            count = int(np.isfinite(before).sum())
            if count < 3:
                continue
            rms, least = (float(np.sqrt(np.nanmean(part**2))) for part in (before, after))
            share = np.sqrt(max(rms**2 - least**2, 0.0)) / float(self._tolerance[i])
            unit = "um" if names[i] in lengths else "K"
            place = ReducibleGap(names[i], regime, rms, least, unit, float(share))
            found.append((count * place.tolerances**2, place))
        # A regime of a few minutes holds little of it, however far off it is.
        ranked = [place for _, place in sorted(found, key=lambda pair: -pair[0])]
        return [gap for gap in ranked if gap.tolerances > 1.0][:most]

    def sources(self) -> list[Predictor]:
        """Return the inputs that predict most of what the plant leaves, all channels together."""
        return self._sources(None)

    def sources_of(self, channel: str) -> list[Predictor]:
        """Return the inputs that predict most of what the plant leaves in one channel."""
        return self._sources(self._used[0].observed.channels.index(channel))

    def _sources(self, channel: int | None) -> list[Predictor]:
        chosen = slice(None) if channel is None else slice(channel, channel + 1)
        left = self._scaled([run.values[:, chosen] for run in self._used])
        predictors = []
        labels = self._predictors.labels
        for name in dict.fromkeys(name for name, _ in labels):
            lags = dict.fromkeys(lag for other, lag in labels if other == name)
            share = self._share(left, [i for i, label in enumerate(labels) if label[0] == name])
            if share < LEAST_PREDICTED:
                continue
            alone = {
                lag: self._share(
                    left, [i for i, label in enumerate(labels) if label == (name, lag)]
                )
                for lag in lags
            }
            predictors.append(Predictor(name, max(alone, key=lambda lag: alone[lag]), share))
        return sorted(predictors, key=lambda predictor: -predictor.share)

    def _share(self, left: Sequence[FloatArray], columns: Sequence[int]) -> float:
        """Return the share of *left* that some predictors alone predict."""
        ridge = _Ridge([x[:, columns] for x in self._predictors.used], left)
        before = np.nansum(mean_squares(left))
        return float(1.0 - np.nansum(mean_squares(_less(left, ridge.predicted))) / before)


def _less(left: Sequence[FloatArray], predicted: Sequence[FloatArray]) -> list[FloatArray]:
    return [values - part for values, part in zip(left, predicted, strict=True)]


def _chosen(choice: FloatArray, options: Sequence[FloatArray]) -> FloatArray:
    """Return each channel of the option chosen for it, (K, C) from several (K, C)."""
    return np.stack(options)[choice, :, np.arange(len(choice))].T


class _Predictors:
    """Lags of every input of every run, in units of their root mean square over the runs used."""

    def __init__(self, machine: Machine, observed: Sequence[Observations]) -> None:
        self._machine = machine
        tables = [_lags(machine, run) for run in observed]
        squares = np.mean(np.concatenate([table for _, table in tables]) ** 2, axis=0)
        self._moving = squares > 1e-12
        self._unit = np.sqrt(squares[self._moving])
        self.labels = [
            label for label, moving in zip(tables[0][0], self._moving, strict=True) if moving
        ]
        self.used = [table[:, self._moving] / self._unit for _, table in tables]

    def of(self, observed: Observations) -> FloatArray:
        """Return those of a further run, shape (K, P)."""
        return np.asarray(_lags(self._machine, observed)[1][:, self._moving] / self._unit)


def _lags(machine: Machine, observed: Observations) -> tuple[list[tuple[str, float]], FloatArray]:
    """Return what may predict a run: labels (input, lag [min]) and values, shape (K, P)."""
    time, rows = observed.time_s, observed.run.time_s
    labels: list[tuple[str, float]] = []
    columns: list[FloatArray] = []
    hall = np.nan
    for entry in machine.inputs:
        if entry.column in observed.run.frame.columns:
            series = observed.run.frame[entry.column].interpolate(limit_direction="both")
            raw = series.to_numpy(dtype=np.float64)
        else:
            raw = np.full(len(rows), entry.default or 0.0)
        if entry.is_boundary:
            hall = raw[0] if np.isnan(hall) else hall
            powers = [raw - raw[0]]
        else:
            powers = [raw / entry.high, (raw / entry.high) ** 2][: 2 if entry.unit == "rpm" else 1]
        for power in powers:
            for lag in LAGS_MIN:
                labels.append((entry.name, lag))
                columns.append(np.interp(time, rows, _lagged(rows, power, lag * 60.0)))
    warm = _warm_at_start(machine, observed) - np.nan_to_num(hall)
    for lag in LAGS_MIN:
        labels.append((START, lag))
        columns.append(warm * np.exp(-(time - rows[0]) / (lag * 60.0)))
    return labels, np.stack(columns, axis=1)


def _lagged(time: FloatArray, series: FloatArray, lag_s: float) -> FloatArray:
    """Return a series behind a first-order lag that starts at rest, shape (T,)."""
    stays = np.exp(-np.diff(time) / lag_s)
    out = np.zeros(len(time))
    for k, (now, later) in enumerate(pairwise(range(len(time)))):
        out[later] = out[now] * stays[k] + series[now] * (1.0 - stays[k])
    return out


def _warm_at_start(machine: Machine, observed: Observations) -> float:
    """Return the mean of the thermometers' first readings [degC]."""
    lengths = set(displacement_names(machine))
    firsts = observed.first[[name not in lengths for name in observed.channels]]
    measured = firsts[np.isfinite(firsts)]
    return float(np.mean(measured)) if measured.size else 0.0


class _Ridge:
    """Ridge regression of all channels on the same predictors.

    Parameters
    ----------
    predictors : sequence of array, each (K, P)
        Of every run.
    left : sequence of array, each (K, C)
        What is to be predicted [tolerances]; NaN where nothing was measured.

    Attributes
    ----------
    predicted : list of array, each (K, C)
        Every run from the others, each channel with the penalty that does best at that.
    """

    def __init__(self, predictors: Sequence[FloatArray], left: Sequence[FloatArray]) -> None:
        self._runs = [
            (x.T @ x, x.T @ np.nan_to_num(y), len(x)) for x, y in zip(predictors, left, strict=True)
        ]
        runs = range(len(predictors))
        costs, made = [], []
        for penalty in PENALTIES:
            weights = [self._fit([j for j in runs if j != k], penalty) for k in runs]
            made.append([x @ weight for x, weight in zip(predictors, weights, strict=True)])
            costs.append(mean_squares(_less(left, made[-1])))
        best = np.argmin(np.nan_to_num(np.array(costs), nan=np.inf), axis=0)
        self.predicted = [_chosen(best, parts) for parts in zip(*made, strict=True)]
        weights = [self._fit(runs, penalty) for penalty in PENALTIES]
        self._weight = _chosen(best, weights)

    def _fit(self, runs: Sequence[int], penalty: float) -> FloatArray:
        matrix = np.sum([self._runs[k][0] for k in runs], axis=0)
        right = np.sum([self._runs[k][1] for k in runs], axis=0)
        count = sum(self._runs[k][2] for k in runs)
        return np.asarray(np.linalg.solve(matrix + penalty * count * np.eye(len(right)), right))

    def of(self, predictors: FloatArray) -> FloatArray:
        """Return what is predicted for a further run, shape (K, C) [tolerances]."""
        return np.asarray(predictors @ self._weight)
