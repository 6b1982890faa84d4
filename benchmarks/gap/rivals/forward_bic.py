"""Forward selection by the Bayesian information criterion, as model-selection tools do it.

The effects' signatures are regressors beside everything that may be wrong anyway (parameters within
their priors, thermometers' errors, starting temperatures). The one that lowers
n ln(RSS / n) + k ln n most is added, again and again, until none does. n counts the samples, k the
numbers of an effect: its amplitude and its shape parameters, which are chosen too. What is added is
then calibrated in full, as in the gap finder. [1]_

.. [1] G. Schwarz, Estimating the dimension of a model, Annals of Statistics 6 (1978) 461-464.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.gap.rivals.question import Question, Told
from gap_finder.calibrate import calibrate
from gap_finder.candidates import with_effect
from gap_finder.regimes import residuals
from plant_model.effects import catalogue
from plant_model.integrate import IntegrationError
from plant_model.machine import Machine

Array = NDArray[np.float64]

TITLE = "Forward BIC"
MOST = 5
"""Effects added at most: more are no answer to anybody."""


def answer(question: Question) -> Told:
    """Add effects until the criterion rises."""
    chosen, falls = selected(_problem(question), _numbers(question))
    keys = [question.candidates[i].key for i in chosen]
    if not keys:
        return Told(more={"falls": falls})
    machine = _calibrated(question, chosen)
    left = [residuals(machine, one) for one in question.unseen]
    return Told(keys, left, {"falls": falls})


@dataclass
class Problem:
    """Least squares in the signatures alone, everything else minimised over.

    Attributes
    ----------
    matrix : array, shape (m, m)
    slope : array, shape (m,)
        Half the derivative of the cost at no effect.
    cost : float
        Of no effect: the residual sum of squares.
    samples : int
    keys : list of str
        Of the effect that each signature belongs to.
    """

    matrix: Array
    slope: Array
    cost: float
    samples: int
    keys: list[str]


def _problem(question: Question) -> Problem:
    designs = question.before.designs
    parts = []
    for i, design in enumerate(designs):
        answers = (
            np.array([one.answers[i] for one in question.candidates]).T * design.weight[:, None]
        )
        columns = np.column_stack([design.shared, answers, design.residual])
        parts.append(columns.T @ design.cleaned(columns))
    gram = np.sum(parts, axis=0)
    shared = designs[0].shared.shape[1]
    prior = gram[:shared, :shared] + np.eye(shared)
    pulled = gram[:shared, shared:].copy()
    moved = question.before.position()
    pulled[: len(moved), -1] += moved
    rest = gram[shared:, shared:] - pulled.T @ np.linalg.solve(prior, pulled)
    samples = sum(int((one.weights > 0.0).sum()) for one in question.observed)
    keys = [one.key for one in question.candidates]
    return Problem(rest[:-1, :-1], rest[:-1, -1], float(rest[-1, -1]), samples, keys)


def _numbers(question: Question) -> Array:
    """Return how many numbers each signature stands for."""
    effects = catalogue()
    return np.array(
        [float(len(effects[one.key.partition(":")[0]].parameters)) for one in question.candidates]
    )


def selected(problem: Problem, numbers: Array) -> tuple[list[int], list[float]]:
    """Return the signatures that are added, in order, and by how much each lowers the criterion.

    A signature is only ever added with the sign that it was simulated with, and an effect once.
    """
    matrix, slope, cost = problem.matrix.copy(), problem.slope.copy(), problem.cost
    own = np.diag(matrix).copy()
    penalty = numbers * np.log(problem.samples)
    chosen: list[int] = []
    falls: list[float] = []
    open_ones = np.ones(len(own), dtype=bool)
    while len(chosen) < MOST:
        left = np.diag(matrix)
        # What others imitate almost wholly has no amplitude of its own any more.
        usable = open_ones & (left > 1e-6 * own) & (slope < 0.0)
        if not usable.any():
            break
        gain = np.where(usable, slope**2 / np.where(usable, left, 1.0), 0.0)
        rest = np.maximum(cost - gain, 1e-9 * problem.cost)
        fall = -problem.samples * np.log(rest / cost) - penalty
        best = int(np.argmax(np.where(usable, fall, -np.inf)))
        if fall[best] <= 0.0:
            break
        chosen.append(best)
        falls.append(float(fall[best]))
        cost = float(rest[best])
        column = matrix[:, best].copy()
        slope = slope - column * slope[best] / column[best]
        matrix = matrix - np.outer(column, column) / column[best]
        open_ones &= np.array([key != problem.keys[best] for key in problem.keys])
    return chosen, falls


def _calibrated(question: Question, chosen: list[int]) -> Machine:
    """Return the machine with the chosen effects, calibrated in full."""
    base, grown = question.base, question.machine
    for i in chosen:
        one = question.candidates[i]
        base, grown = with_effect(base, one.key), with_effect(grown, one.key, one.values)
    try:
        return calibrate(
            base,
            question.observed,
            starts=1,
            start_from=[grown],
            sensitivities=question.sensitivities,
        ).machine
    except IntegrationError:
        return question.machine
