"""Time series of the drift: ADF test, differencing, standardising, ARMA(p, q) by AIC."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from fmu_compensator.fit.error_models.base import FittedModel, Task
from fmu_compensator.fit.error_models.options import (
    FEWEST_ROWS,
    refuse_poor,
    whole,
    within,
)
from fmu_compensator.fit.training import Array, TrainingRun
from measurement.errors import BadInput
from measurement.resampling import GAP_INTERVALS
from studies.fit.arx import usual_step
from studies.runtime.arma import MOST_DIFFERENCES

SIGNIFICANCE = 0.05
"""Significance level of the ADF test, the usual one: set on no data [1]."""


@dataclass(frozen=True)
class Series:
    """One target's numbers; see the twin in the runtime.

    Attributes
    ----------
    differences : int
        Order of differencing.
    mean, scale : float
        Of the differenced series.
    ar, ma : array
        phi and theta [1].
    diagnostics : dict
        ADF p-values, AIC of every order, autocorrelations of the stationary series.
    """

    differences: int
    mean: float
    scale: float
    ar: Array
    ma: Array
    diagnostics: dict[str, Any]


class AutoregressiveMovingAverage(FittedModel):
    """An ARMA model per target; it uses only past drift, no temperatures.

    Parameters
    ----------
    step_s : float
        Length of a step [s].
    series : list of Series
        One per target.
    names : list of str
        Of the targets.
    notes : tuple of str
        Which runs were left out.
    """

    title = "Time series (ARMA)"
    by_temperature = False
    history = True
    uses_measured = True

    def __init__(
        self, step_s: float, series: list[Series], names: list[str], notes: tuple[str, ...] = ()
    ) -> None:
        self.step_s, self.series, self._names, self.notes = step_s, series, names, notes

    @classmethod
    def fit(
        cls,
        task: Task,
        *,
        step_s: float | None = None,
        order: int = 2,
    ) -> AutoregressiveMovingAverage:
        """Return the series fitted to the task's runs.

        Parameters
        ----------
        task : Task
            Runs and names; the inputs are not used.
        step_s : float, optional
            Length of a step; by default the usual sampling interval [s].
        order : int
            p and q are searched from 0 to this; the study's own are missing from its text.

        Raises
        ------
        BadInput
            For a value that is not allowed, too few rows, or constant columns.
        """
        refuse_poor(task)
        step = usual_step(task) if step_s is None else within("arma", "step_s", step_s, 0.1, 1e5)
        largest = whole("arma", "order", order, 1, FEWEST_ROWS // 2)
        of_runs = [(run.name, _even(run, step)) for run in task.runs]
        pieces = [piece for _, parts in of_runs for piece in parts]
        if not pieces:
            raise BadInput("training runs", "", "no stretch of drift is long enough for a series")
        targets = range(len(task.target_names))
        series = [_fit_series([piece[:, t] for piece in pieces], largest) for t in targets]
        short = f"no {FEWEST_ROWS} steps in it without a gap of {GAP_INTERVALS * step:g} s"
        notes = tuple(
            f"{name} is left out of the time series: {short}"
            for name, parts in of_runs
            if not parts
        )
        return cls(step, series, list(task.target_names), notes)

    def table(self) -> dict[str, Any]:
        """Return the numbers for the compensator file."""
        return {
            "step_s": self.step_s,
            "series": [
                {
                    "differences": series.differences,
                    "mean": series.mean,
                    "scale": series.scale,
                    "ar": series.ar.tolist(),
                    "ma": series.ma.tolist(),
                }
                for series in self.series
            ],
        }

    def report(self) -> dict[str, Any]:
        """Return orders, ADF p-values, AIC, ACF and PACF of each target."""
        targets = {
            name: {
                "order": [len(series.ar), series.differences, len(series.ma)],
                **series.diagnostics,
            }
            for name, series in zip(self._names, self.series, strict=True)
        }
        return {"step_s": self.step_s, "targets": targets}


def _even(run: TrainingRun, step_s: float) -> list[Array]:
    """Return the run's drift on the even clock, split where it was not measured for a while."""
    time, targets = run.time_s[run.known], run.targets[run.known]
    cuts = np.flatnonzero(np.diff(time) > GAP_INTERVALS * step_s) + 1
    pieces = []
    for part, values in zip(np.split(time, cuts), np.split(targets, cuts), strict=True):
        grid = np.arange(part[0], part[-1], step_s) if len(part) else part
        if len(grid) >= FEWEST_ROWS:
            pieces.append(np.column_stack([np.interp(grid, part, column) for column in values.T]))
    return pieces


def _fit_series(pieces: list[Array], largest: int) -> Series:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FutureWarning)  # the kind of tuple that they return
        differences, p_values = _stationary_order(pieces)
    # Differences are taken within each piece, never from one run to the next.
    w = np.concatenate([np.diff(piece, differences) for piece in pieces])
    mean, scale = float(w.mean()), float(w.std())
    if scale < 1e-9:
        empty = np.zeros(0)
        return Series(differences, mean, 1.0, empty, empty, {"adf_p": p_values, "aic": None})
    z = (w - mean) / scale
    best: tuple[float, Array, Array] | None = None
    tried: dict[str, float] = {}
    with warnings.catch_warnings():
        for kind in (FutureWarning, RuntimeWarning, UserWarning):
            warnings.simplefilter("ignore", kind)
        for p, q in product(range(largest + 1), repeat=2):
            if p + q == 0:
                continue
            fitted = _arma(z, p, q)
            if fitted is not None:
                tried[f"{p},{q}"] = round(float(fitted[0]), 3)
            if fitted is not None and (best is None or fitted[0] < best[0]):
                best = fitted
    if best is None:
        raise BadInput("training runs", "", "no ARMA model can be fitted to the differenced drift")
    aic, ar, ma = best
    diagnostics = {"adf_p": p_values, "aic": round(float(aic), 3), "aic_by_order": tried}
    return Series(differences, mean, scale, ar, ma, diagnostics | correlations(z))


def correlations(z: Array) -> dict[str, Any]:
    """Return autocorrelation and partial autocorrelation of a stationary series, from lag 0 on.

    If the former cuts off at q and the latter tails off, the series is MA(q); the other way round
    it is AR(p); if both tail off it is ARMA. ``white_noise_95`` is the bound for 95 % of the
    autocorrelations of white noise, 1.96 / sqrt(n).
    """
    from statsmodels.tsa.stattools import acf, pacf

    partial = pacf(z, method="ywm")  # as many lags as statsmodels takes
    return {
        "acf": np.round(acf(z, nlags=len(partial) - 1), 4).tolist(),
        "pacf": np.round(partial, 4).tolist(),
        "white_noise_95": round(1.96 / float(np.sqrt(len(z))), 4),
    }


def _arma(z: Array, p: int, q: int) -> tuple[float, Array, Array] | None:
    """Return AIC, phi and theta of an ARMA(p, q) by maximum likelihood; None if it fails."""
    # A likelihood may have several maxima: take the larger of those reached from two starts, that
    # of Yule and Walker and statsmodels' own, that of Hannan and Rissanen.
    reached = [_maximum(z, p, q, by_yule_walker) for by_yule_walker in (True, False)]
    return min((fitted for fitted in reached if fitted), key=lambda fitted: fitted[0], default=None)


def _maximum(z: Array, p: int, q: int, by_yule_walker: bool) -> tuple[float, Array, Array] | None:
    """Return AIC, phi and theta of the maximum reached from a start; None if it fails."""
    # Only here: it takes a second to load.
    from statsmodels.regression.linear_model import yule_walker
    from statsmodels.tsa.arima.estimators.innovations import innovations_mle

    try:
        start = None
        if by_yule_walker:
            rho = yule_walker(z, order=p, method="mle")[0] if p else np.zeros(0)
            start = np.concatenate([rho, np.zeros(q), [1.0]])
        parameters, results = innovations_mle(z, order=(p, 0, q), demean=False, start_params=start)
    except (ValueError, np.linalg.LinAlgError):
        return None
    ar, ma = np.asarray(parameters.ar_params), np.asarray(parameters.ma_params)
    likelihood = -float(results.minimize_results.fun)
    if not np.isfinite([likelihood, *ar, *ma]).all():
        return None
    return 2.0 * (p + q + 1) - 2.0 * likelihood, ar, ma


def _stationary_order(pieces: list[Array]) -> tuple[int, list[float]]:
    """Return the order of differencing, and the median ADF p-value of each order tried."""
    from statsmodels.tsa.stattools import adfuller

    p_values = []
    for differences in range(MOST_DIFFERENCES + 1):
        of_pieces = []
        for piece in sorted(pieces, key=len)[-5:]:
            w = np.diff(piece, differences)
            if np.ptp(w) > 0.0:
                of_pieces.append(float(adfuller(w, maxlag=min(10, len(w) // 4), autolag="AIC")[1]))
        p_values.append(round(float(np.median(of_pieces)), 4) if of_pieces else 0.0)
        if p_values[-1] < SIGNIFICANCE:
            break
    return len(p_values) - 1, p_values
