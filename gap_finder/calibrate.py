"""Calibration: moves parameters, within what their ranges make likely, to fit measured runs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import LinAlgError, cho_factor, cho_solve
from scipy.optimize import lsq_linear

from gap_finder.descent import ITERATIONS, Descent, Point
from gap_finder.design import RunSensitivities
from gap_finder.directions import fewer
from gap_finder.likelihood import Likelihood, Quadratic
from gap_finder.linearise import (
    Linearisation,
    bias_columns,
    linear_about,
    nuisance_columns,
    points_of,
)
from gap_finder.observations import Observations
from gap_finder.priors import DETERMINED, FAR, Priors
from measurement.workers import one_thread
from plant_model.integrate import IntegrationError
from plant_model.machine import Machine
from plant_model.parameters import FloatArray

Progress = Callable[[str], None]


def quiet(_: str) -> None:
    """Report no progress."""


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
        1 - posterior / prior standard deviation: 0 if the runs say nothing about it, 1 if they
        determine it [1].
    at_bound : bool
        Whether it ends at a bound set by physics or by the law of an added effect.
    deviations : float
        Distance from its value before, in standard deviations of the prior; the range is four wide
        [1].
    source : str
        Source of the value and range before.
    range : (float, float)
        Before.
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
    range: tuple[float, float] = (-np.inf, np.inf)

    @property
    def is_far(self) -> bool:
        """Whether it ends farther from its prior value than its range makes likely."""
        return self.at_bound or abs(self.deviations) >= FAR

    @property
    def is_narrowed(self) -> bool:
        """Whether the runs narrow its range enough to count as determining it."""
        return self.prior_contraction >= DETERMINED

    @property
    def is_determined(self) -> bool:
        """Whether the runs determine it, or moved it far."""
        return self.is_narrowed or self.is_far


@dataclass(frozen=True)
class Calibration:
    """A calibrated machine.

    Attributes
    ----------
    machine : Machine
        With the calibrated values.
    cost : float
        Final -2 log likelihood plus prior.
    expected : float
        The same, as the derivatives promise where calibration ended: lower if it has not converged.
    parameters : tuple of ParameterEstimate
    parts : tuple of Linearisation
        Every run, linearised about the calibrated machine.
    units : array, shape (C,)
        Variance of each channel's errors [tolerances squared].
    starts_cost : float
        -2 log of the share of the prior of where lagging laws start that the runs leave.
    """

    machine: Machine
    cost: float
    expected: float
    parameters: tuple[ParameterEstimate, ...]
    parts: tuple[Linearisation, ...]
    units: FloatArray
    starts_cost: float


class _Problem:
    """The parameters sought, and what the runs say about them.

    Simulates several points at once, because many parameter sets cost hardly more than one.
    """

    def __init__(
        self,
        machine: Machine,
        observed: Sequence[Observations],
        priors: Priors,
        sensitivities: Sequence[RunSensitivities] | None,
    ) -> None:
        self.machine, self.observed, self.priors = machine, observed, priors
        if sensitivities is None:
            own = [fewer([nuisance_columns(machine, run)])[0] for run in observed]
        else:
            own = [part.nuisance for part in sensitivities]
        self.likelihood = Likelihood(observed, own, [bias_columns(run) for run in observed])

    def at(self, x: FloatArray) -> Point:
        """Linearise every run about a point, (P,).

        Raises
        ------
        IntegrationError
            If the machine cannot be stepped there, or nearly not.
        """
        parts = self.likelihood.about_starts(
            linear_about(self.machine, self.observed, self.priors, x)
        )
        of_runs = self.likelihood.about(parts)
        matrix, right = of_runs.matrix + np.eye(len(x)), of_runs.right + x
        about = replace(of_runs, matrix=matrix, right=right, cost=of_runs.cost + float(x @ x))
        try:
            toward = cho_solve(cho_factor(matrix), right)
        except (ValueError, LinAlgError):  # not finite, or too large for doubles
            raise IntegrationError("the machine is about to run away there") from None
        # Without limits on the step: from far away, the goal takes several steps.
        expected = about.cost - float(right @ toward)
        return Point(x, tuple(parts), about, expected)

    def trials(self, x: FloatArray, about: Quadratic, dampings: Sequence[float]) -> FloatArray:
        """Return the point that each damping leads to, (T, P)."""
        diagonal = np.diag(np.diag(about.matrix))
        steps = [
            _bounded_step(about.matrix + damping * diagonal, about.right, x, self.priors)
            for damping in dampings
        ]
        return np.asarray(np.clip(x + np.array(steps), self.priors.low, self.priors.high))

    def costs(self, points: FloatArray) -> FloatArray:
        """Return the cost at every point, (S,); NaN if the machine cannot be stepped there."""
        runs = points_of(self.machine, self.observed, self.priors, points)
        squares = np.sum(points**2, axis=1)
        costs = [self.likelihood.about(parts).cost for parts in zip(*runs, strict=True)]
        return np.asarray(costs + squares)


@one_thread()
def calibrate(
    machine: Machine,
    observed: Sequence[Observations],
    *,
    starts: int = 2,
    seed: int = 0,
    start_from: Sequence[Machine] = (),
    cost_limit: float = np.inf,
    sensitivities: Sequence[RunSensitivities] | None = None,
    progress: Progress = quiet,
) -> Calibration:
    """Calibrate the machine's free parameters to fit the runs.

    Parameters
    ----------
    machine : Machine
    observed : sequence of Observations
        Of the calibration runs.
    starts : int
        Number of starting points; the first is the machine itself, the others are random.
    seed : int
        Seed of the random starting points.
    start_from : sequence of Machine
        Starting points instead of the machine itself; the priors stay the machine's.
    cost_limit : float
        Calibration ends if it cannot be expected to reach this.
    sensitivities : sequence of RunSensitivities, optional
        Derivatives of each run about a similar machine, if already known.
    progress : callable
        Called with each step in words.

    Returns
    -------
    Calibration
        The calibrated machine, and how well its parameters are known.
    """
    priors = Priors.of(machine, calibrated=True)
    problem = _Problem(machine, observed, priors, sensitivities)
    generator = np.random.default_rng(seed)
    begin = [priors.position(start) for start in start_from or (machine,)]
    begin += [generator.normal(0.0, 0.7, len(priors.names)) for _ in range(starts - 1)]
    descents = _begun(problem, np.clip(np.array(begin), priors.low, priors.high))
    _descend(problem, descents, cost_limit, progress)
    best = min((descent.at for descent in descents), key=lambda point: point.cost)
    values = {name: float(value[0]) for name, value in priors.values(best.x[None, :]).items()}
    parts, about, starts_cost = problem.likelihood.swung(best.parts)
    # As in the score, the variance grows with the error of a run: within it, errors depend on each
    # other.
    matrix = about.matrix + np.eye(len(best.x))
    variance = np.diag(np.linalg.inv(matrix)) * max(1.0, about.each)
    spread = np.minimum(np.sqrt(variance), 1.0)
    return Calibration(
        machine.with_values(values, beyond=True),
        about.cost + float(best.x @ best.x),
        min(descent.at.expected for descent in descents),
        intervals(machine, priors, best.x, spread),
        tuple(parts),
        about.units,
        starts_cost,
    )


def _begun(problem: _Problem, points: FloatArray) -> list[Descent]:
    """Return descents from those points, (S, P), at which the machine can be stepped."""
    begun = []
    for x in points:
        with suppress(IntegrationError):
            begun.append(Descent(problem.at(x), is_done=not x.size))
    if not begun:
        raise IntegrationError("the machine cannot be stepped from where calibration starts")
    return begun


def _descend(
    problem: _Problem, descents: Sequence[Descent], cost_limit: float, progress: Progress
) -> None:
    """Descend from all starts side by side, within physical bounds."""
    for iteration in range(ITERATIONS):
        going = [descent for descent in descents if not descent.is_done]
        if not any(descent.may_reach(cost_limit) for descent in going):
            break
        progress(f"iteration {iteration + 1}")
        trials = [problem.trials(d.at.x, d.at.about, d.dampings) for d in going]
        costs = np.split(problem.costs(np.concatenate(trials)), len(going))
        for descent, tried, reached in zip(going, trials, costs, strict=True):
            if (taken := descent.best_of(reached)) is None:
                continue
            try:
                descent.move(problem.at(tried[taken]))
            except IntegrationError:
                descent.is_done = True


def _bounded_step(
    matrix: FloatArray, right: FloatArray, x: FloatArray, priors: Priors
) -> FloatArray:
    """Return the step, shape (P,), that minimises the quadratic model inside the bounds."""
    factor = np.linalg.cholesky(matrix)
    # Derivatives are unreliable farther away than half the width of a range.
    low, high = np.maximum(priors.low - x, -FAR), np.minimum(priors.high - x, FAR)
    # Rounding must not put the current point outside its bounds.
    bounds = np.minimum(low, -1e-12), np.maximum(high, 1e-12)
    target = -np.linalg.solve(factor, right)
    return np.asarray(lsq_linear(factor.T, target, bounds, method="bvls").x)


def intervals(
    machine: Machine, priors: Priors, x: FloatArray, spread: FloatArray
) -> tuple[ParameterEstimate, ...]:
    """Return the estimate of every parameter.

    Parameters
    ----------
    machine : Machine
        Its values are the centre of the prior.
    priors : Priors
    x, spread : array, shape (P,)
        Calibrated values and their standard deviations, in the fitting scale.
    """
    low, value, high = (priors.beside(x, shift * spread) for shift in (-1.96, 0.0, 1.96))
    return tuple(
        ParameterEstimate(
            name,
            machine.parameters[name].unit,
            machine.parameters[name].value,
            float(value[i]),
            float(low[i]),
            float(high[i]),
            float(1.0 - min(spread[i], 1.0)),
            bool(x[i] <= priors.low[i] + 1e-9 or x[i] >= priors.high[i] - 1e-9),
            float(x[i]),
            machine.parameters[name].source,
            (machine.parameters[name].low, machine.parameters[name].high),
        )
        for i, name in enumerate(priors.names)
    )
