"""What the Gaussian model learns a run from: rows of its inputs, their lags and its drift."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from fmu_compensator.fit.error_models.options import FEWEST_ROWS
from fmu_compensator.fit.training import Array, TrainingRun
from fmu_compensator.runtime.gaussian import FASTEST, SPEEDS
from measurement.errors import BadInput
from measurement.runs import Run
from measurement.warm import cold_starts

LAGS_S = (900.0, 3600.0, 14400.0)
"""Lags of the rises, in addition to the rises themselves [s]. Faster ones would let the model use
the slope of a thermometer's reading: set on a lathe outside this project, where that generalised
badly to other conditions."""
MOST_ROWS = 48
"""Number of rows used per run, evenly spread over time: as errors last hours, they tell as much as
all. Set on no data; on twelve splits of the lathe's and the electric spindle's runs errors are 3 %
larger with 24 (geometric mean), and 4 % with 96."""


@dataclass(frozen=True)
class Sample:
    """The rows of one run that the weights are learnt from.

    Attributes
    ----------
    hours : array (n,)
        Time since the start of the walk [h].
    features : array (n, p)
        Inputs and their lags [K].
    targets : array (n, m)
        [um, urad]
    mean : array (n, m)
        Prediction of the mean function fitted to other runs [um, urad].
    """

    hours: Array
    features: Array
    targets: Array
    mean: Array


def learnable(runs: Sequence[Run]) -> tuple[list[Run], list[str]]:
    """Leave out runs that begin warm or are over before the shortest lag, unless all do or are.

    Parameters
    ----------
    runs : sequence of Run

    Returns
    -------
    runs : list of Run
    notes : list of str
        What was left out.

    Raises
    ------
    BadInput
        If all runs are too short and have too few rows. With more rows their clock may be wrong,
        which doubts tell.
    """
    cold, warm = cold_starts(runs)
    brief = [run for run in cold if run.time_s[-1] - run.time_s[0] < LAGS_S[0]]
    notes = [warm] * bool(warm)
    if brief:
        names = ", ".join(dict.fromkeys(run.name for run in brief))
        problem = f"shorter than {LAGS_S[0]:g} s, the model's shortest lag: {names}"
        if len(brief) == len(cold):
            if sum(len(run.time_s) for run in brief) >= FEWEST_ROWS:
                return cold, notes
            raise BadInput("training runs", "", f"nothing can be learnt from runs {problem}")
        notes.append(f"left out, since they are {problem}")
    return [run for run in cold if run not in brief], notes


def speed_unit(runs: Sequence[TrainingRun]) -> float | None:
    """Return the speed that counts like a rise of 1 K: the root mean square over some runs [rpm].

    None if a run has no speed, or the spindle never turns.
    """
    speeds = [run.held_speed for run in runs if np.isfinite(run.speed).any()]
    if not speeds or len(speeds) < len(runs):
        return None
    return float(np.sqrt(np.mean([np.mean(speed**2) for speed in speeds]))) or None


def with_speed(run: TrainingRun, rises: Array, unit_rpm: float | None) -> Array:
    """Return the inputs of the Gaussian: rises, speed over *unit_rpm* and its square [K].

    Parameters
    ----------
    run : TrainingRun
    rises : array (n, k)
        Of its thermometers [K].
    unit_rpm : float or None
        The speed that counts like 1 K [rpm]; None: speed is not used.

    Returns
    -------
    array (n, k + 2), or (n, k) without speed
    """
    if unit_rpm is None:
        return rises
    turning = pd.Series(run.held_speed / unit_rpm)
    turning = turning.where(turning <= FASTEST).ffill().fillna(0.0)  # as the runtime holds it
    return np.column_stack([rises, turning, turning**2])


def rise_features(thermometers: int) -> NDArray[np.bool_]:
    """Return which features are rises and their lags, if the speed is an input, shape (p,)."""
    of_rise = np.arange(thermometers + SPEEDS) < thermometers
    return np.tile(of_rise, 1 + len(LAGS_S))


def with_lags(time_s: Array, inputs: Array) -> Array:
    """Return the features of a run, shape (n, k * (1 + lags)): inputs, then lag by lag [K].

    Parameters
    ----------
    time_s : array (n,)
        Increasing [s].
    inputs : array (n, k)
        Rises above the first reading or above fixed temperatures, and speed [K]. The lags start at
        zero; between rows an input moves evenly.
    """
    lagged = np.zeros((len(inputs), len(LAGS_S), inputs.shape[1]))
    state = np.zeros((len(LAGS_S), inputs.shape[1]))
    # As at run time: `share` and `behind` of every step and lag.
    steps, tau = np.diff(time_s)[:, None, None], np.array(LAGS_S)[:, None]
    parts = -np.expm1(-steps / tau)
    late = tau / steps - (1.0 - parts) / parts
    seen = inputs[1:, None] - late * np.diff(inputs, axis=0)[:, None]
    for row, (part, value) in enumerate(zip(parts, seen, strict=True), start=1):
        state = state + part * (value - state)
        lagged[row] = state
    return np.hstack([inputs, lagged.reshape(len(inputs), len(LAGS_S) * inputs.shape[1])])


def spread_rows(hours: Array, known: NDArray[np.bool_]) -> NDArray[np.int_]:
    """Return up to `MOST_ROWS` of the known rows, evenly spread in time, without the first row."""
    rows = np.flatnonzero(known)
    rows = rows[rows > 0]
    if len(rows) <= MOST_ROWS:
        return rows
    wanted = np.linspace(hours[rows[0]], hours[rows[-1]], MOST_ROWS)
    return np.asarray(rows[np.unique(np.searchsorted(hours[rows], wanted).clip(0, len(rows) - 1))])


def sample_of(
    run: TrainingRun, inputs: Array, targets: Array, mean: Array, settled_h: float = 0.0
) -> Sample:
    """Return the rows of a run to learn the weights from.

    Parameters
    ----------
    run : TrainingRun
        Its rows with complete inputs.
    inputs : array (n, k)
        As `with_speed` returns them [K].
    targets, mean : array (n, m)
        Measured targets (NaN: not measured) and the mean function's prediction [um, urad].
    settled_h : float
        Time that the walk had run at the first row: 0 if targets start at zero [h].
    """
    hours = (run.time_s - run.time_s[0]) / 3600.0 if len(run.time_s) else run.time_s
    known = np.asarray(np.isfinite(targets + mean).all(axis=1))
    features = with_lags(run.time_s, inputs)
    first = int(known.argmax())
    if not settled_h and first:
        # Drift counts from the first reading, and so does everything that explains it.
        known[first] = False
        hours, features = hours - hours[first], features - features[first]
        targets, mean = targets - targets[first], mean - mean[first]
    rows = spread_rows(hours, known)
    return Sample(hours[rows] + settled_h, features[rows], targets[rows], mean[rows])
