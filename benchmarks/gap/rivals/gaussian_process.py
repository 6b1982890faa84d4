"""A Gaussian process that learns the residual: it shrinks the gap and names nothing.

Its inputs are what the calibrated model says at that instant (all channels), the speed, and the
speed lagged by some time constants, so that it can tell warming from cooling. One process serves
all channels: squared exponential with white noise, hyperparameters by marginal likelihood. [1]_

.. [1] C. E. Rasmussen and C. K. I. Williams, Gaussian Processes for Machine Learning, MIT Press
   (2006), sections 2.2 and 5.4.1.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from sklearn.exceptions import ConvergenceWarning
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

from benchmarks.gap.rivals.question import Question, Told
from gap_finder.observations import Observations
from gap_finder.regimes import RunResiduals, residuals

Array = NDArray[np.float64]

TITLE = "Gaussian process on the residual"
LAGS_S = (600.0, 2400.0, 9600.0)
SAMPLES = 500
"""Samples learnt from: the cost grows with the cube of their number."""


def answer(question: Question) -> Told:
    """Learn the residual of the calibration runs and take it off the held-out one's."""
    known = [residuals(question.machine, one) for one in question.observed]
    inputs = np.concatenate([features(one) for one in known])
    outputs = np.concatenate([one.values for one in known])
    whole = np.flatnonzero(np.isfinite(outputs).all(axis=1))
    chosen = np.random.default_rng(0).permutation(whole)[:SAMPLES]
    middle, width = inputs.mean(axis=0), np.maximum(inputs.std(axis=0), 1e-9)
    process = fitted((inputs[chosen] - middle) / width, outputs[chosen])
    left = []
    for one in question.left:
        predicted = process.predict((features(one) - middle) / width)
        left.append(RunResiduals(one.observed, one.values - predicted))
    return Told([], left, {"kernel": str(process.kernel_)})


def fitted(inputs: Array, outputs: Array) -> GaussianProcessRegressor:
    """Return a process fitted to standardised inputs (N, F) and outputs (N, C)."""
    kernel = ConstantKernel(1.0, (1e-2, 1e3)) * RBF(3.0, (0.3, 100.0)) + WhiteKernel(
        0.1, (1e-4, 1.0)
    )
    process = GaussianProcessRegressor(kernel, normalize_y=True, random_state=0)
    with warnings.catch_warnings():
        # A hyperparameter at the end of its range is an answer like any other here.
        warnings.simplefilter("ignore", ConvergenceWarning)
        process.fit(inputs, outputs)
    return process


def features(one: RunResiduals) -> Array:
    """Return the inputs at every instant of a run, shape (K, F)."""
    modelled = np.nan_to_num(one.values + one.observed.values)
    speed = _speed(one.observed)
    time = one.observed.time_s
    return np.column_stack([modelled, speed, *(_lagged(time, speed, lag) for lag in LAGS_S)])


def _speed(observed: Observations) -> Array:
    frame = observed.run.frame
    return np.interp(observed.time_s, frame["time_s"], frame["speed_rpm"].ffill().bfill())


def _lagged(time_s: Array, values: Array, lag_s: float) -> Array:
    """Return a first-order lag, from rest."""
    out = np.zeros_like(values)
    steps: Sequence[float] = np.diff(time_s).tolist()
    for k, step in enumerate(steps):
        out[k + 1] = out[k] + (values[k] - out[k]) * (1.0 - np.exp(-step / lag_s))
    return out
