"""The finite-element spindle as an error model, identified on training runs."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from fmu_compensator.fit.error_models.base import FittedModel, Task
from fmu_compensator.fit.error_models.options import refuse_poor, whole, within
from fmu_compensator.fit.training import Array, TrainingRun
from measurement.errors import BadInput, shown
from studies.finite_elements import FiniteElementSpindle, read_description
from studies.finite_elements.films import friction_heat
from studies.finite_elements.reduce import ReducedRegime, ReducedSpindle
from studies.fit.lagged import needed, thinned

SPEEDS = (0.0, 0.06, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0)
"""Speeds of the regimes, as shares of the highest speed in training [1]: set on no data."""
FEM_ROWS_S = 120.0
"""Rows are thinned to this spacing for fitting, because closer ones are redundant [s]: set on no
data."""
PRIOR = np.array([0.4, 0.5, 0.2])
"""Prior standard deviations of the logarithms of film, jacket and capacity factors."""
FARTHEST = np.log(4.0)


class FiniteElementModel(FittedModel):
    """See its twin in the runtime for the equations.

    Parameters
    ----------
    regimes : sequence of ReducedRegime
        Modes at each speed.
    numbers : array, shape (sources, 4)
        Heat over speed of each source.
    entries : array, shape (sources, r)
        Forcing per watt.
    outside : sequence of (int, int)
        Pairs of input and boundary: air (0) or coolant (1).
    intercept, outputs : array, shape (m,) and (m, drives r)
    diagnostics : dict
        Factors found, shares of the drives.
    """

    title = "Finite-element spindle"
    history = True
    usual_form = "rise"
    usual_points = "all"

    def __init__(
        self,
        regimes: Sequence[ReducedRegime],
        numbers: Array,
        entries: Array,
        outside: Sequence[tuple[int, int]],
        intercept: Array,
        outputs: Array,
        diagnostics: dict[str, Any],
    ) -> None:
        self.regimes, self.numbers, self.entries = list(regimes), numbers, entries
        self.outside, self.intercept, self.outputs = list(outside), intercept, outputs
        self._diagnostics = diagnostics

    @classmethod
    def fit(
        cls,
        task: Task,
        *,
        description: str = "jig_borer",
        modes: int = 14,
        identify: bool = True,
        penalty: float = 1e-4,
    ) -> FiniteElementModel:
        """Return the model identified on the task's runs.

        Parameters
        ----------
        task : Task
            Runs and names. Speed is required; the only inputs used are those that the description
            names as air and coolant, and both are optional.
        description : str
            A description file (TOML), or the name of a shipped one.
        modes : int
            Number of thermal states per drive, 4 to 30.
        identify : bool
            Fit factors on films, jackets and heat capacities; otherwise use the description as is.
        penalty : float
            Weight of the squared coefficients of the drives' responses [1].

        Raises
        ------
        BadInput
            For a value that is not allowed, a bad description, too few rows, or runs without
            speed.
        """
        size = whole("fem", "modes", modes, 4, 30)
        weight = within("fem", "penalty", penalty, 1e-12, 1e3)
        top = _top_speed(task)
        if not isinstance(description, str):
            raise BadInput("fem", "description", f"{shown(description)} is not a file's name")
        form = read_description(description)
        reduced = ReducedSpindle(
            FiniteElementSpindle(form), size, [share * top for share in SPEEDS]
        )
        named = (form.inputs.air, form.inputs.coolant)
        outside = [
            (task.input_names.index(name), boundary)
            for boundary, name in enumerate(named)
            if name is not None and name in list(task.input_names)
        ]
        identification = _Identification(task, reduced, outside, weight)
        factors = identification.factors() if identify else np.zeros(len(PRIOR))
        return identification.model(cls, factors, form.name)

    def table(self) -> dict[str, Any]:
        """Return the numbers for the compensator file."""
        names = ("viscous", "threshold", "slow", "load")
        boundaries = [boundary for _, boundary in self.outside]
        return {
            "states": self.entries.shape[1],
            "outside_inputs": [index for index, _ in self.outside],
            "regimes": [
                {
                    "speed": regime.speed,
                    "rates": regime.rates.tolist(),
                    "vectors": regime.vectors.tolist(),
                    "outside": regime.boundaries[boundaries].tolist(),
                }
                for regime in self.regimes
            ],
            "sources": [
                {**dict(zip(names, numbers, strict=True)), "entry": entry}
                for numbers, entry in zip(self.numbers.tolist(), self.entries.tolist(), strict=True)
            ],
            "intercept": self.intercept.tolist(),
            "outputs": self.outputs.tolist(),
        }

    def report(self) -> dict[str, Any]:
        """Return the fitted factors and the effect of each drive."""
        return self._diagnostics


def responses(
    run: TrainingRun,
    regimes: Sequence[ReducedRegime],
    numbers: Array,
    entries: Array,
    outside: Sequence[tuple[int, int]],
) -> Array:
    """Return the coordinates of every drive at every row, shape (n, drives, r).

    The drives are the sources in order, then the outside temperatures.
    """
    boundaries = [boundary for _, boundary in outside]
    rises = run.inputs[:, [index for index, _ in outside]]
    rises = rises - rises[0]
    states = np.zeros((len(run.time_s), len(entries) + len(outside), entries.shape[1]))
    if len(states) < 2:
        return states
    steps = np.diff(run.time_s)
    speed = run.held_speed[1:]
    different, which = np.unique(speed, return_inverse=True)
    heat = [
        [friction_heat(n, (v, n0, c, w)) for v, n0, c, w in numbers] for n in different.tolist()
    ]
    power = np.array(heat).reshape(len(different), len(numbers))[which]
    mean = (rises[1:] + rises[:-1]) / 2.0
    edges = np.array([(a.speed + b.speed) / 2.0 for a, b in pairwise(regimes)])
    regime_of = np.searchsorted(edges, speed)
    bounds = [0, *(np.flatnonzero(np.diff(regime_of)) + 1).tolist(), len(steps)]
    for first, last in pairwise(bounds):
        regime, part = regimes[int(regime_of[first])], slice(first, last)
        by_source = power[part, :, None] * (entries @ regime.vectors)
        by_outside = mean[part, :, None] * (regime.boundaries[boundaries] @ regime.vectors)
        fall = -regime.rates * steps[part, None]
        gain = -np.expm1(fall) / regime.rates
        added = gain[:, None] * np.concatenate([by_source, by_outside], axis=1)
        decay, modes = np.exp(fall), states[first] @ regime.vectors
        for k in range(last - first):
            modes = added[k] = decay[k] * modes + added[k]
        states[first + 1 : last + 1] = added @ regime.vectors.T
    return states


class _Identification:
    """Factors on films, jackets and capacities by least squares; the drives' shares for each."""

    def __init__(
        self,
        task: Task,
        reduced: ReducedSpindle,
        outside: Sequence[tuple[int, int]],
        penalty: float,
    ) -> None:
        self._task, self._reduced, self._outside = task, reduced, outside
        self._penalty = penalty
        self._numbers = np.array(reduced.spindle.heat.source_numbers)
        self._constant = task.input_form == "absolute"
        # Rows in between are also left out of the stepping: steps are exact at constant speed.
        self._runs = [run.at(needed(run, FEM_ROWS_S)) for run in task.runs]
        self._rows = [thinned(run, FEM_ROWS_S) for run in self._runs]
        self._target = np.concatenate(
            [run.targets[rows] for run, rows in zip(self._runs, self._rows, strict=True)]
        )
        weights = [
            _duration(run) * np.ones(len(rows)) / max(len(rows), 1)
            for run, rows in zip(self._runs, self._rows, strict=True)
        ]
        joined = np.concatenate(weights)
        self._root = np.sqrt(joined / joined.sum())[:, None]
        self._scale = np.maximum(np.std(self._target, axis=0), 1e-9)

    def _regimes(self, factors: Array) -> tuple[list[ReducedRegime], Array]:
        air, coolant, capacity = np.exp(factors).tolist()
        regimes = self._reduced.regimes(air=air, coolant=coolant, capacity=capacity)
        return regimes, self._reduced.entries / capacity

    def _features(self, factors: Array) -> Array:
        """Return growth and mean warming of every drive at the thinned rows."""
        regimes, entries = self._regimes(factors)
        parts = []
        for run, rows in zip(self._runs, self._rows, strict=True):
            states = responses(run, regimes, self._numbers, entries, self._outside)[rows]
            both = [states @ self._reduced.growth, states @ self._reduced.body]
            parts.append(np.concatenate(both, axis=1))
        return np.concatenate(parts)

    def _solve(self, features: Array) -> tuple[Array, Array, Array]:
        """Return coefficients, intercept and weighted residuals (in standard deviations)."""
        size = np.sqrt(np.mean(features**2, axis=0))
        scaled = features / np.where(size > 0.0, size, 1.0)
        columns = [scaled, np.ones((len(scaled), 1))] if self._constant else [scaled]
        x = np.concatenate(columns, axis=1)
        ridge = np.sqrt(self._penalty) * np.eye(x.shape[1])[: scaled.shape[1]]
        y = self._target / self._scale
        left = np.concatenate([self._root * x, ridge])
        right = np.concatenate([self._root * y, np.zeros((len(ridge), y.shape[1]))])
        solution = np.linalg.lstsq(left, right, rcond=None)[0]
        residual = right - left @ solution
        coefficients = solution[: scaled.shape[1]] * self._scale
        coefficients = coefficients / np.where(size > 0.0, size, np.inf)[:, None]
        constant = solution[-1] * self._scale if self._constant else np.zeros(y.shape[1])
        return coefficients, constant, residual

    def factors(self) -> Array:
        """Return the logarithms of the factors on films, jackets and capacities."""

        def cost(logs: Array) -> Array:
            residual = self._solve(self._features(logs))[2]
            # The prior has the weight of a residual of a hundredth of the targets' spread.
            return np.concatenate([residual.ravel(), 0.01 * logs / PRIOR])

        bounds = (-FARTHEST, FARTHEST)
        minimum = least_squares(
            cost, np.zeros(len(PRIOR)), bounds=bounds, diff_step=0.02, max_nfev=12
        )
        return np.asarray(minimum.x)

    def model(
        self, kind: type[FiniteElementModel], factors: Array, name: str
    ) -> FiniteElementModel:
        """Return the model with these factors."""
        regimes, entries = self._regimes(factors)
        features = self._features(factors)
        coefficients, constant, residual = self._solve(features)
        drives = len(entries) + len(self._outside)
        by_growth, by_body = coefficients[:drives], coefficients[drives:]
        outputs = (
            by_growth.T[:, :, None] * self._reduced.growth
            + by_body.T[:, :, None] * self._reduced.body
        )
        names = [*self._reduced.spindle.heat.source_names]
        names += [self._task.input_names[index] for index, _ in self._outside]
        moved = {
            target: dict(zip(names, column, strict=True))
            for target, column in zip(
                self._task.target_names, np.round(by_growth.T, 6).tolist(), strict=True
            )
        }
        rows = len(self._target)
        diagnostics = {
            "description": name,
            "nodes": int(self._reduced.spindle.heat.basis.N),
            "factors": dict(
                zip(("films", "jackets", "capacities"), np.exp(factors).tolist(), strict=True)
            ),
            "share_of_growth": moved,
            "rms_residual": dict(
                zip(
                    self._task.target_names,
                    (np.linalg.norm(residual[:rows], axis=0) * self._scale).tolist(),
                    strict=True,
                )
            ),
        }
        flat = outputs.reshape(len(outputs), -1)
        return kind(regimes, self._numbers, entries, self._outside, constant, flat, diagnostics)


def _top_speed(task: Task) -> float:
    """Return the highest speed [r/min]; refuse runs that do not suffice for a model."""
    refuse_poor(task)
    for run in task.runs:
        if not np.isfinite(run.speed).any():
            raise BadInput(run.name, "speed_rpm", "is not known in every run: fem needs it")
    top = max(float(np.nanmax(np.abs(run.speed))) for run in task.runs)
    if top == 0.0:
        raise BadInput("training runs", "speed_rpm", "is always 0: there is nothing to identify")
    return top


def _duration(run: TrainingRun) -> float:
    return float(run.time_s[-1] - run.time_s[0])
