"""Calibration: parameters moved, each as far as its range makes likely, to follow measured runs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.optimize import lsq_linear
from threadpoolctl import threadpool_limits

from gap_finder.descent import ITERATIONS, Descent
from gap_finder.directions import fewer
from gap_finder.linearise import (
    Linearisation,
    bias_columns,
    linear_about,
    nuisance_columns,
    residuals_at,
)
from gap_finder.observations import Observations
from gap_finder.priors import FAR, Priors
from plant_model.integrate import IntegrationError
from plant_model.machine import Machine
from plant_model.parameters import FloatArray

ROBUST = 3.0
"""Weighted residuals beyond this many root mean squares count linearly (Huber). Set on no data."""

Progress = Callable[[str], None]


def quiet(_: str) -> None:
    """Report no progress."""


class Sensitivities(Protocol):
    """What need not be computed again of one run; see ``design.RunSensitivities``."""

    @property
    def nuisance(self) -> FloatArray:
        """Nuisance parameters of the run alone, shape (N, O)."""

    @property
    def bias(self) -> FloatArray:
        """Thermometers' errors, shape (N, C)."""


@dataclass(frozen=True)
class ParameterEstimate:
    """One parameter before and after calibration.

    Attributes
    ----------
    name, unit : str
    prior, value : float
        Before and after.
    low, high : float
        95 % interval after.
    prior_contraction : float
        1 - posterior / prior standard deviation: 0 where the runs say nothing, 1 where they say
        all [1].
    at_bound : bool
        Whether it ends where physics does, or the law of an added effect.
    deviations : float
        How far it ends from its value before, in deviations of the prior; the range is as wide as
        four [1].
    source : str
        Where value and range before come from.
    """

    name: str
    unit: str
    prior: float
    value: float
    low: float
    high: float
    prior_contraction: float
    at_bound: bool
    deviations: float = 0.0
    source: str = ""

    @property
    def is_far(self) -> bool:
        """Whether it ends farther from its value before than the range makes likely."""
        return self.at_bound or abs(self.deviations) >= FAR


@dataclass(frozen=True)
class Calibration:
    """A calibrated machine.

    Attributes
    ----------
    machine : Machine
        With the values found.
    cost : float
        Weighted squares plus prior at the end.
    starts : tuple of float
        Cost reached from each start.
    parameters : tuple of ParameterEstimate
    parts : tuple of Linearisation
        Every run about the machine.
    """

    machine: Machine
    cost: float
    starts: tuple[float, ...]
    parameters: tuple[ParameterEstimate, ...]
    parts: tuple[Linearisation, ...]


class _LeastSquares:
    """Least squares over all runs, nuisance parameters of single runs eliminated exactly.

    Several points are simulated at once: many sets of parameters cost hardly more than one.
    """

    def __init__(
        self,
        machine: Machine,
        observed: Sequence[Observations],
        priors: Priors,
        sensitivities: Sequence[Sensitivities] | None,
    ) -> None:
        self.machine, self.observed, self.priors = machine, observed, priors
        if sensitivities is None:
            self._nuisance = [fewer([nuisance_columns(machine, run)])[0] for run in observed]
            self._bias = [bias_columns(machine, run) for run in observed]
        else:
            self._nuisance = [part.nuisance for part in sensitivities]
            self._bias = [part.bias for part in sensitivities]

    def linear(self, points: FloatArray) -> list[list[Linearisation]]:
        """Return every run about every point, (S, P)."""
        return linear_about(self.machine, self.observed, self.priors, points)

    def gram(self, parts: Sequence[Linearisation]) -> tuple[FloatArray, FloatArray, float]:
        """Return normal matrix, right side and squares of parameters and biases together."""
        matrix: FloatArray | float = 0.0
        right: FloatArray | float = 0.0
        squares = 0.0
        for part, own, bias in zip(parts, self._nuisance, self._bias, strict=True):
            weight = robust_weights(part.residual)
            r = part.residual * weight
            shared = np.hstack([part.by_parameter, bias]) * weight[:, None]
            single = own * weight[:, None]
            # Minimising over the run's own unknowns is a projection of the rest.
            inner = single.T @ single + np.eye(single.shape[1])
            solved = np.linalg.solve(inner, single.T @ np.column_stack([shared, r]))
            cleaned = np.column_stack([shared, r]) - single @ solved
            full = np.column_stack([shared, r]).T @ cleaned
            matrix = matrix + full[:-1, :-1]
            right = right + full[:-1, -1]
            squares += full[-1, -1]
        return np.asarray(matrix), np.asarray(right), float(squares)

    def costs(self, points: FloatArray) -> FloatArray:
        """Return the cost at every point, (S,); NaN where the machine cannot be stepped."""
        residuals = residuals_at(self.machine, self.observed, self.priors, points)
        return np.array(
            [self.cost(x, [shown[i] for shown in residuals]) for i, x in enumerate(points)]
        )

    def cost(self, x: FloatArray, residuals: Sequence[FloatArray]) -> float:
        """Return the cost at a point, (P,), whose residuals are known, each (N,)."""
        parts = [Linearisation(shown, np.zeros((len(shown), 0))) for shown in residuals]
        matrix, right, squares = self.gram(parts)
        inner = matrix + np.eye(len(right))
        return squares - float(right @ np.linalg.solve(inner, right)) + float(x @ x)


def robust_weights(residual: FloatArray, beyond: float = ROBUST) -> FloatArray:
    """Return square-root weights of Huber's law for weighted residuals."""
    scale = beyond * max(float(np.sqrt(np.mean(residual**2))), 1e-12)
    return np.asarray(np.sqrt(np.minimum(1.0, scale / np.maximum(np.abs(residual), 1e-300))))


def calibrate(
    machine: Machine,
    observed: Sequence[Observations],
    *,
    starts: int = 2,
    seed: int = 0,
    iterations: int = ITERATIONS,
    start_from: Sequence[Machine] = (),
    go_on: Calibration | None = None,
    sensitivities: Sequence[Sensitivities] | None = None,
    progress: Progress = quiet,
) -> Calibration:
    """Move the machine's free parameters so that it follows the runs.

    Parameters
    ----------
    machine : Machine
    observed : sequence of Observations
        Of the calibration runs.
    starts : int
        Number of starting points; all but the machine as it stands are drawn.
    seed : int
        Of the further starting points.
    iterations : int
        At most, from each start.
    start_from : sequence of Machine
        Starting points instead of the machine itself; priors stay the machine's.
    go_on : Calibration, optional
        One of this machine on these runs, to start from where it ended instead.
    sensitivities : sequence of Sensitivities, optional
        How what only one run has acts, if it is known already, of a machine near by.
    progress : callable
        Told what is being done.

    Returns
    -------
    Calibration
        The machine with its free parameters moved, and how well they are known.
    """
    # The matrices are small: threads would wait for each other, at ten times the processor time.
    with threadpool_limits(1):
        priors = Priors.of(machine, calibrated=True)
        problem = _LeastSquares(machine, observed, priors, sensitivities)
        generator = np.random.default_rng(seed)
        if go_on is not None:
            x = priors.position(go_on.machine)
            begun = [_Begun(x, go_on.cost, parts=[*go_on.parts])]
        else:
            begin = [priors.position(start) for start in start_from or (machine,)]
            begin += [generator.normal(0.0, 0.7, len(priors.names)) for _ in range(starts - 1)]
            begun = _begun(problem, np.clip(np.array(begin), priors.low, priors.high))
        reached = _descend(problem, begun, iterations, progress)
        best = min(reached, key=lambda descent: descent.cost)
        values = {name: float(value[0]) for name, value in priors.values(best.x[None, :]).items()}
        return Calibration(
            machine.with_values(values, beyond=True),
            best.cost,
            tuple(descent.cost for descent in reached),
            _estimates(machine, problem, best.parts, best.x),
            tuple(best.parts),
        )


@dataclass(eq=False, kw_only=True)
class _Begun(Descent):
    """A start on its way down, with every run about where it is."""

    parts: list[Linearisation]


def _begun(problem: _LeastSquares, points: FloatArray) -> list[_Begun]:
    """Return the starts, (S, P), that the machine can be stepped from."""
    begun = []
    for x in points:
        try:
            (parts,) = problem.linear(x[None])
        except IntegrationError:
            continue
        cost = problem.cost(x, [part.residual for part in parts])
        begun.append(_Begun(x, cost, parts=parts))
    if not begun:
        raise IntegrationError("the machine cannot be stepped from where calibration starts")
    return begun


def _descend(
    problem: _LeastSquares, descents: list[_Begun], iterations: int, progress: Progress
) -> list[_Begun]:
    """Go down inside what physics allows, from every start, side by side."""
    for iteration in range(iterations):
        progress(f"iteration {iteration + 1}")
        going = [descent for descent in descents if not descent.is_done]
        if not going:
            break
        trials = [_trials(problem, descent) for descent in going]
        costs = np.split(problem.costs(np.concatenate(trials)), len(going))
        triples = zip(going, trials, costs, strict=True)
        moved = [descent for descent, *tried in triples if descent.take(*tried) is not None]
        if not moved:
            continue
        parts_of = problem.linear(np.array([descent.x for descent in moved]))
        for descent, parts in zip(moved, parts_of, strict=True):
            descent.parts = parts
    return descents


def _trials(problem: _LeastSquares, descent: _Begun) -> FloatArray:
    """Return where a descent may go, shape (T, P)."""
    priors, x = problem.priors, descent.x
    matrix, right, _ = problem.gram(descent.parts)
    matrix += np.eye(len(matrix))
    right[: len(x)] += x
    diagonal = np.diag(np.diag(matrix))
    steps = [
        _bounded_step(matrix + damping * diagonal, right, x, priors) for damping in descent.dampings
    ]
    return np.asarray(np.clip(x + np.array(steps), priors.low, priors.high))


def _bounded_step(
    matrix: FloatArray, right: FloatArray, x: FloatArray, priors: Priors
) -> FloatArray:
    """Return the step, shape (P,), that minimises the quadratic model inside the bounds."""
    count = len(x)
    factor = np.linalg.cholesky(matrix)
    free = np.full(len(right) - count, np.inf)
    # Derivatives know little of what is farther away than a range is wide to one side.
    low, high = np.maximum(priors.low - x, -FAR), np.minimum(priors.high - x, FAR)
    room = np.concatenate([low, -free]), np.concatenate([high, free])
    # Rounding must not put the present point outside its own bounds.
    bounds = np.minimum(room[0], -1e-12), np.maximum(room[1], 1e-12)
    target = -np.linalg.solve(factor, right)
    return np.asarray(lsq_linear(factor.T, target, bounds, method="bvls").x[:count])


def _estimates(
    machine: Machine, problem: _LeastSquares, parts: list[Linearisation], x: FloatArray
) -> tuple[ParameterEstimate, ...]:
    matrix, _, _ = problem.gram(parts)
    covariance = np.linalg.inv(matrix + np.eye(len(matrix)))
    spread = np.sqrt(np.diag(covariance))[: len(x)]
    return intervals(machine, problem.priors, x, spread)


def intervals(
    machine: Machine, priors: Priors, x: FloatArray, spread: FloatArray
) -> tuple[ParameterEstimate, ...]:
    """Return what is said of every parameter.

    Parameters
    ----------
    machine : Machine
        Its values are the prior's centre.
    priors : Priors
    x, spread : array, shape (P,)
        Where calibration left it and its standard deviation, in the fitting scale.
    """
    points = {
        key: priors.values((x + shift * spread)[None, :])
        for key, shift in (("low", -1.96), ("value", 0.0), ("high", 1.96))
    }
    return tuple(
        ParameterEstimate(
            name,
            machine.parameters[name].unit,
            machine.parameters[name].value,
            float(points["value"][name][0]),
            float(points["low"][name][0]),
            float(points["high"][name][0]),
            float(1.0 - min(spread[i], 1.0)),
            bool(x[i] <= priors.low[i] + 1e-9 or x[i] >= priors.high[i] - 1e-9),
            float(x[i]),
            machine.parameters[name].source,
        )
        for i, name in enumerate(priors.names)
    )
