"""How well any model with these inputs could do: ridge regression on lagged inputs.

Even a perfect model only has the recorded inputs and the machine's temperature at the start of the
run. Whatever first-order lags of these predict in a run, fitted to the other runs, some model can
also predict. The part of the plant's residuals that they predict is the *reducible* gap: it can be
explained, and the input and lag that predict it show where to look. The rest does not follow from
the inputs, or not in the same way in every run.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from gap_finder.observations import Observations
from gap_finder.regimes import RunResiduals, mean_squares, regimes
from plant_model.integrate import Modes, linear_steps
from plant_model.machine import Machine
from plant_model.parameters import FloatArray

LAGS_MIN = (3.0, 8.0, 20.0, 45.0, 100.0, 220.0, 500.0)
"""Time constants of the lags [min]: from a bearing's to a machine bed's, each some 2.3 times the
one before, so that two of them approximate any lag in between. Set on no data."""

PENALTIES = tuple(0.01 * 10.0 ** (0.5 * k) for k in range(10))
"""Ridge penalties tried, per observation and for predictors of unit mean square [1]."""

START = "start"
"""Name of the predictors for the machine's temperature at the start."""

LEAST_PREDICTED = 0.1
"""Share of squared residuals that an input must predict to be reported, or that must follow a relay
for it to be simulated [1]. In development cases in which a part switches the cooler, 0.12 to 0.6
follow it, except in one that remains undetected."""


@dataclass(frozen=True)
class Predictor:
    """An input that predicts a part of the plant's residuals.

    Attributes
    ----------
    input : str
        Of the machine, or ``start``: its temperature at the start of the run.
    lag_min : float
        The single lag that predicts most by itself [min].
    share : float
        Share of the mean squares that all lags of this input together predict in left-out runs [1].
    """

    input: str
    lag_min: float
    share: float


@dataclass(frozen=True)
class ReducibleGap:
    """The reducible gap of a channel in a regime, over all runs with it.

    Attributes
    ----------
    channel, regime, unit : str
    rms, reference : float
        Root mean square residual of the plant there, and of the reference [unit].
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
    """The reference on some runs, each predicted from the others, and on unseen runs.

    Parameters
    ----------
    machine : Machine
        Defines the inputs.
    used : sequence of RunResiduals
        The plant's residuals of two or more runs.
    unseen : sequence of RunResiduals
        Of runs to be predicted from all of those.

    Attributes
    ----------
    used, unseen : list of RunResiduals
        Residuals of the reference for each run. They are what the regression leaves of the plant's,
        or the plant's in a channel in which these are smaller on the runs used.
    share : float
        Predictable share of the squares of the plant's residuals on the runs used, in tolerances
        and over all channels [1].
    """

    def __init__(
        self, machine: Machine, used: Sequence[RunResiduals], unseen: Sequence[RunResiduals] = ()
    ) -> None:
        self._machine, self._used = machine, used
        self._predictors = _Predictors(machine, [run.observed for run in used])
        left = [run.values for run in used]
        self._tolerance = used[0].observed.tolerance
        ridge = _Ridge(self._predictors.used, self._scaled(left))
        rest = _less(left, [part * self._tolerance for part in ridge.predicted])
        helps = mean_squares(rest) < mean_squares(left)
        best = [np.where(helps, *pair) for pair in zip(rest, left, strict=True)]
        self.used = [replace(run, values=part) for run, part in zip(used, best, strict=True)]
        unseen_of = [ridge.of(self._predictors.of(run.observed)) for run in unseen]
        self.unseen = [
            replace(run, values=run.values - np.where(helps, part * self._tolerance, 0.0))
            for run, part in zip(unseen, unseen_of, strict=True)
        ]
        before, after = (mean_squares(part) / self._tolerance**2 for part in (left, best))
        self.share = float(np.nanmean(before - after)) / max(float(np.nanmean(before)), 1e-12)

    def _scaled(self, parts: Sequence[FloatArray]) -> list[FloatArray]:
        return [part / self._tolerance for part in parts]

    def places(self, most: int = 8) -> list[ReducibleGap]:
        """Return where the reducible gap exceeds one tolerance, largest contribution first."""
        groups: dict[tuple[int, str], list[tuple[FloatArray, FloatArray]]] = {}
        for run, reference in zip(self._used, self.used, strict=True):
            time, left = run.observed.time_s, reference.values
            for start, end, regime in regimes(run.observed):
                rows = (time >= start) & (time <= end)
                # Without the speed, so that no channel is listed at every step of a spectrum.
                doing = regime.partition(", at ")[0]
                for i in range(left.shape[1]):
                    groups.setdefault((i, doing), []).append((run.values[rows, i], left[rows, i]))
        names = self._used[0].observed.channels
        gaps: list[tuple[float, ReducibleGap]] = []
        for (i, regime), parts in groups.items():
            before, after = (np.concatenate(part) for part in zip(*parts, strict=True))
            count = int(np.isfinite(before).sum())
            if count < 3:
                continue
            rms, least = (float(np.sqrt(np.nanmean(part**2))) for part in (before, after))
            share = np.sqrt(max(rms**2 - least**2, 0.0)) / float(self._tolerance[i])
            unit = self._used[0].observed.unit_of(i)
            place = ReducibleGap(names[i], regime, rms, least, unit, float(share))
            gaps.append((count * place.tolerances**2, place))
        # A regime of a few minutes contributes little, however large its error.
        ranked = [place for _, place in sorted(gaps, key=lambda pair: -pair[0])]
        return [gap for gap in ranked if gap.tolerances > 1.0][:most]

    def sources(self, channel: str = "") -> list[Predictor]:
        """Return the inputs that predict most of the residuals, of all channels or of one."""
        chosen = [not channel or name == channel for name in self._used[0].observed.channels]
        left = [part[:, chosen] for part in self._scaled([run.values for run in self._used])]
        predictors = []
        for name in dict.fromkeys(name for name, _ in self._predictors.labels):
            share = self._share(left, name, LAGS_MIN)
            if share >= LEAST_PREDICTED:
                alone = [self._share(left, name, [lag]) for lag in LAGS_MIN]
                predictors.append(Predictor(name, LAGS_MIN[int(np.argmax(alone))], share))
        return sorted(predictors, key=lambda predictor: -predictor.share)

    def _share(self, left: Sequence[FloatArray], name: str, lags_min: Sequence[float]) -> float:
        """Return the share of the squares of *left* predicted by some lags of one input."""
        labels = self._predictors.labels
        columns = [i for i, (of, lag) in enumerate(labels) if of == name and lag in lags_min]
        ridge = _Ridge([x[:, columns] for x in self._predictors.used], left)
        before = np.nansum(mean_squares(left))
        return float(1.0 - np.nansum(mean_squares(_less(left, ridge.predicted))) / before)


def _less(left: Sequence[FloatArray], predicted: Sequence[FloatArray]) -> list[FloatArray]:
    return [values - part for values, part in zip(left, predicted, strict=True)]


def _chosen(choice: FloatArray, options: Sequence[FloatArray]) -> FloatArray:
    """Return each channel from its chosen option, (K, C) from several (K, C)."""
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
        """Return the predictors of another run, shape (K, P)."""
        return np.asarray(_lags(self._machine, observed)[1][:, self._moving] / self._unit)


def _lags(machine: Machine, observed: Observations) -> tuple[list[tuple[str, float]], FloatArray]:
    """Return the predictors of a run: labels (input, lag [min]) and values, shape (K, P)."""
    time, rows = observed.time_s, observed.run.time_s
    names: list[str] = []
    driving: list[FloatArray] = []
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
        names += [entry.name] * len(powers)
        driving += powers
    held = np.array(driving)[:, :-1]
    followed = lagged(np.diff(rows), held, np.zeros(len(held)), LAGS_MIN)
    followed = np.pad(followed, ((0, 0), (1, 0), (0, 0))).swapaxes(1, 2).reshape(-1, len(rows))
    warm = _warm_at_start(observed) - np.nan_to_num(hall)
    since_min = (time - rows[0]) / 60.0
    columns = [np.interp(time, rows, series) for series in followed]
    columns += [warm * np.exp(-since_min / lag) for lag in LAGS_MIN]
    return list(product([*names, START], LAGS_MIN)), np.stack(columns, axis=1)


def lagged(
    steps: FloatArray, held: FloatArray, start: FloatArray, lags_min: Sequence[float]
) -> FloatArray:
    """Return series filtered by first-order lags, at the end of each step, (series, K, lags).

    Parameters
    ----------
    steps : array, shape (K,)
        [s]
    held : array, shape (series, K)
        Values during the steps.
    start : array, shape (series,)
        Value of every lag before.
    lags_min : sequence of float
        [min]
    """
    decay = np.broadcast_to(1.0 / (60.0 * np.array(lags_min)), (len(held), len(lags_min)))
    none = np.zeros((len(held), 0, 0))
    forcing = decay[:, None, :] * held[..., None]
    begin = np.repeat(start[:, None], len(lags_min), axis=1)
    return linear_steps(Modes(decay, none, none), begin, steps, forcing, forcing)


def _warm_at_start(observed: Observations) -> float:
    """Return the mean of the thermometers' first readings [degC]."""
    firsts = observed.first[~observed.lengths]
    measured = firsts[np.isfinite(firsts)]
    return float(np.mean(measured)) if measured.size else 0.0


class _Ridge:
    """Ridge regression of all channels on the same predictors.

    Parameters
    ----------
    predictors : sequence of array, each (K, P)
        Of every run.
    left : sequence of array, each (K, C)
        Targets [tolerances]; NaN where nothing was measured.

    Attributes
    ----------
    predicted : list of array, each (K, C)
        Every run predicted from the others, each channel with its best penalty.
    """

    def __init__(self, predictors: Sequence[FloatArray], left: Sequence[FloatArray]) -> None:
        self._runs = [_equations(x, y) for x, y in zip(predictors, left, strict=True)]
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
        matrix, right, count = (
            np.sum([self._runs[k][part] for k in runs], axis=0) for part in range(3)
        )
        # A channel without a reading has zero weights.
        pull = penalty * np.maximum(count, 1)[:, None, None] * np.eye(matrix.shape[-1])
        return np.asarray(np.linalg.solve(matrix + pull, right[:, :, None])[:, :, 0].T)

    def of(self, predictors: FloatArray) -> FloatArray:
        """Return the prediction for another run, shape (K, C) [tolerances]."""
        return np.asarray(predictors @ self._weight)


def _equations(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the normal equations of each channel on the rows in which it was measured.

    Returns
    -------
    matrix : array (C, P, P)
    right : array (C, P)
    count : array (C,)
        Rows.
    """
    measured = np.isfinite(y)
    matrix = np.stack([x[rows].T @ x[rows] for rows in measured.T])
    return matrix, np.nan_to_num(y).T @ x, measured.sum(axis=0)
