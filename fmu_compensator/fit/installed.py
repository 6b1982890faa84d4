"""What a compensator installs: a mean function and its Gaussian, fitted to some runs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy.special import stdtrit

from fmu_compensator.fit.conditions import FOLDS
from fmu_compensator.fit.data import Prepared, PreparedRun, first_valid
from fmu_compensator.fit.error_models.base import FittedModel
from fmu_compensator.fit.features import (
    LAGS_S,
    Sample,
    rise_features,
    sample_of,
    speed_unit,
    with_lags,
    with_speed,
)
from fmu_compensator.fit.gaussian import DEGREES, Gaussian, by_feature, directions
from fmu_compensator.fit.recipe import Recipe
from fmu_compensator.fit.training import GRID_S, Array, TrainingRun
from fmu_compensator.runtime.gaussian import OF_FIXED, OF_START

COVERAGE = 0.9
"""Share of unseen drift that an interval should contain [1]: a usual level, set on no data."""
DEVIATIONS = float(stdtrit(DEGREES, 0.5 + COVERAGE / 2.0))
"""Half width of the interval in standard deviations [1]."""
RMS_OF_HALF_WIDTH = math.sqrt(DEGREES / (DEGREES - 2.0)) / DEVIATIONS
"""Root mean square of the remaining drift that an interval expects, over its half width [1]."""


class Predicted(NamedTuple):
    """The prediction for a run.

    Attributes
    ----------
    rows : TrainingRun
        Its n rows with complete inputs.
    values, half_width : array (n, m)
        [um, urad]
    mean : array (n, m)
        Prediction of the mean function alone [um, urad].
    """

    rows: TrainingRun
    values: Array
    half_width: Array
    mean: Array


@dataclass(frozen=True)
class Installed:
    """A mean function and its Gaussian.

    Attributes
    ----------
    recipe : Recipe
        How the mean function was fitted.
    chosen : list of int
        Indices of its sensors.
    choice : dict
        How the sensors were chosen, for the provenance.
    fitted : FittedModel
        The mean function.
    gaussian : Gaussian
    samples : list of Sample
        What the Gaussian was learnt from.
    usual : array (k,) or None
        Reference temperatures of rises that do not count from the start [degC].
    constant : array (m,)
        The drift at the reference [um, urad].
    settled_h : float
        Time that the random walk has run at the start of a run [h].
    unit_rpm : float or None
        The speed that counts like a rise of 1 K [rpm]; None: speed is not used.
    """

    recipe: Recipe
    chosen: list[int]
    choice: Any
    fitted: FittedModel
    gaussian: Gaussian
    samples: list[Sample]
    usual: Array | None
    constant: Array
    settled_h: float
    unit_rpm: float | None

    @classmethod
    def fit(
        cls,
        recipe: Recipe,
        prepared: Prepared,
        runs: Sequence[PreparedRun],
    ) -> Installed:
        """Return what is installed after fitting these runs.

        Parameters
        ----------
        recipe : Recipe
            Points are chosen again, because a choice based on other runs would flatter the model.
        prepared : Prepared
            Names of sensors and targets, and whether every run has a speed.
        runs : sequence of PreparedRun
            Runs to learn from.

        Raises
        ------
        BadInput
            If the runs do not suffice for the error model.
        """
        chosen, choice = recipe.choose(prepared, runs)
        # A run in which no row has all of them teaches nothing; fitting notes its lost rows.
        runs = [run for run in runs if len(run.history(chosen).time_s)]
        fitted = recipe.fit(prepared, _from_start(runs), chosen)
        rows = [run.history(chosen) for run in runs]
        # Predictions by fits to the other runs show the Gaussian how good the error model is on
        # unseen runs. One run alone cannot show that: a flexible model's interval is too narrow.
        by_others = [fitted]
        if len(runs) > 1:
            parts = [
                [run for at, run in enumerate(runs) if at % FOLDS != part]
                for part in range(min(FOLDS, len(runs)))
            ]
            by_others = [recipe.fit(prepared, _from_start(others), chosen) for others in parts]
        means = [by_others[at % FOLDS].predict(run) for at, run in enumerate(rows)]
        usual, settled_h = None, 0.0
        # As with thermometers, every run must have it, including those left out of this fit.
        unit_rpm = speed_unit(rows) if recipe.speed and not prepared.speedless else None
        level = level_of_mean = np.zeros(len(prepared.targets))
        if recipe.input_form == "absolute":
            usual = np.mean(np.vstack([run.inputs for run in rows]), axis=0)
            level = np.nanmean(np.vstack([run.targets for run in rows]), axis=0)
            level_of_mean = np.nanmean(np.vstack(means), axis=0)
            unit_rpm = None  # the drift at the reference holds at no particular speed
            settled_h = max(float(np.ptp(run.time_s)) for run in rows) / 3600.0
        samples = [
            sample_of(
                row,
                with_speed(row, rises_of(run, row, chosen, usual), unit_rpm),
                row.targets - level,
                mean - level_of_mean,
                settled_h,
            )
            for run, row, mean in zip(runs, rows, means, strict=True)
        ]
        # A model that uses measurements itself continues from them: it has full weight.
        whole = np.ones(len(level)) if fitted.uses_measured else None
        gaussian = Gaussian.fit(samples, whole)
        if unit_rpm is not None:
            # Averaged, because either travels worse: rises alone miss what no thermometer sees,
            # and what the speed tells holds on this machine only as it was.
            of_rises = rise_features(len(chosen))
            blind = [replace(one, features=one.features[:, of_rises]) for one in samples]
            gaussian = gaussian.averaged(Gaussian.fit(blind, whole), of_rises)
        return cls(
            recipe,
            chosen,
            choice,
            fitted,
            gaussian,
            samples,
            usual,
            level - gaussian.share * level_of_mean,
            settled_h,
            unit_rpm,
        )

    def predict(self, run: PreparedRun) -> Predicted:
        """Return the prediction for a run's rows with complete inputs."""
        rows = run.history(self.chosen)
        rises = rises_of(run, rows, self.chosen, self.usual)
        features = self._features(rows, rises)
        mean = self.fitted.predict(rows)
        hours = self.settled_h + (rows.time_s - rows.time_s[:1]) / 3600.0
        along = features @ self.seen.T
        prior = by_feature(self.gaussian.scale, features.shape[1])
        novelty = features**2 @ prior - (along**2).sum(axis=1)
        variance = 1.0 + self.gaussian.walk**2 * hours + np.maximum(novelty, 0.0)
        spread = np.sqrt(np.diag(self.gaussian.spread))
        half_width = DEVIATIONS * np.sqrt(variance)[:, None] * spread
        return Predicted(rows, self._on(mean, features), half_width, mean)

    def values(self, rows: TrainingRun, rises: Array) -> Array:
        """Return the prediction for rows with complete inputs, shape (n, m) [um, urad]."""
        return self._on(self.fitted.predict(rows), self._features(rows, rises))

    def _features(self, rows: TrainingRun, rises: Array) -> Array:
        return with_lags(rows.time_s, with_speed(rows, rises, self.unit_rpm))

    def _on(self, mean: Array, features: Array) -> Array:
        return self.gaussian.share * mean + self.constant + features @ self.gaussian.weights

    @cached_property
    def seen(self) -> Array:
        """Directions of the weights determined by the runs, shape (q, p) [1/K]."""
        return directions(self.gaussian, self.samples)

    def table(self) -> dict[str, Any]:
        """Return the file's table ``gaussian``."""
        model = self.gaussian
        return {
            "reference": OF_START if self.usual is None else OF_FIXED,
            **({} if self.usual is None else {"usual": listed(self.usual)}),
            **({} if self.unit_rpm is None else {"speed_rpm": listed(self.unit_rpm, digits=12)}),
            "constant": listed(self.constant),
            "mean_share": listed(model.share),
            "settled_h": self.settled_h,
            "lags_s": list(LAGS_S),
            "weights": listed(model.weights.T),
            "scale": listed(model.scale, digits=12),
            "seen": listed(self.seen, digits=12),
            "walk_per_h": listed(model.walk**2),
            "noise": listed(np.linalg.cholesky(model.spread)),
            "rows": listed(model.rows),
            "deviations": listed(DEVIATIONS),
            "coverage": COVERAGE,
        }


def _from_start(runs: Sequence[PreparedRun]) -> Sequence[PreparedRun]:
    """Return the runs measured from their start; if there are none, all runs."""
    return [run for run in runs if run.late_s <= GRID_S] or runs


def rises_of(
    run: PreparedRun, rows: TrainingRun, chosen: Sequence[int], usual: Array | None
) -> Array:
    """Return the rises that are inputs of the Gaussian, shape (n, k) [K].

    Parameters
    ----------
    run : PreparedRun
    rows : TrainingRun
        Its ``history``.
    chosen : sequence of int
        The sensors.
    usual : array (k,) or None
        Reference temperatures [degC]; None: each sensor's first reading.
    """
    if usual is not None:
        return rows.inputs - usual
    temperatures = run.temperatures[:, list(chosen)]
    whole = np.isfinite(temperatures).all(axis=1)
    return np.asarray(temperatures[whole] - first_valid(temperatures))


def listed(values: Any, digits: int = 9) -> Any:
    """Return numbers as lists for the file.

    Parameters
    ----------
    values : array of any shape, or a number
    digits : int
        Significant digits: the variance, a small difference of large numbers, needs more.
    """
    if np.ndim(values):
        return [listed(value, digits) for value in np.asarray(values)]
    return float(f"{float(values):.{digits}g}")
