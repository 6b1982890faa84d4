"""Screens how well each candidate explains the residuals of calibration, run by run.

It works on normal matrices only, so that leaving out a run and recalibrating in each fold need no
simulation.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
import numpy.typing as npt
from scipy.linalg import cho_factor, cho_solve

from gap_finder.added_paths import AT_ONCE
from gap_finder.candidates import LEAST_SCALE, MOST_SCALE
from gap_finder.design import RunDesign, told_by_one_run
from plant_model.parameters import FloatArray


class Answers(Protocol):
    """Anything with a response in every run."""

    @property
    def answers(self) -> tuple[FloatArray, ...]:
        """Weighted responses, each (N,)."""


@dataclass(frozen=True)
class NormalMatrices:
    """Normal matrices of every run, minimised over its nuisance parameters.

    Attributes
    ----------
    shared : array, shape (R, Q, Q)
        Between the shared columns.
    cross : array, shape (R, Q, m)
        Between the shared columns and the candidates' responses.
    answers : array, shape (R, m)
        Squares of the responses.
    """

    shared: FloatArray
    cross: FloatArray
    answers: FloatArray

    @classmethod
    def of(cls, designs: Sequence[RunDesign], tried: Sequence[Answers]) -> NormalMatrices:
        """Compute the matrices."""
        shared, cross, answers = [], [], []
        for i, design in enumerate(designs):
            clean_shared = design.cleaned(design.shared)
            shared.append(design.shared.T @ clean_shared)
            cross.append(np.zeros((design.shared.shape[1], len(tried))))
            answers.append(np.zeros(len(tried)))
            for block, columns in answers_in_blocks(tried, i, design):
                cross[-1][:, block] = clean_shared.T @ columns
                answers[-1][block] = np.sum(columns * design.cleaned(columns), axis=0)
        return cls(np.array(shared), np.array(cross), np.array(answers))

    @cached_property
    def alone(self) -> npt.NDArray[np.bool_]:
        """Where no other run determines a candidate's size, shape (R, m)."""
        return told_by_one_run(self.answers)


@dataclass(frozen=True)
class Residuals:
    """Products of every run's residual with its shared columns, the responses and itself.

    Attributes
    ----------
    against_shared : array, shape (R, Q)
    against_answers : array, shape (R, m)
    squares : array, shape (R,)
    pull : array, shape (Q,)
        Current distance of the shared unknowns from the centre of their prior.
    """

    against_shared: FloatArray
    against_answers: FloatArray
    squares: FloatArray
    pull: FloatArray

    @classmethod
    def of(
        cls,
        designs: Sequence[RunDesign],
        tried: Sequence[Answers],
        moved: FloatArray,
    ) -> Residuals:
        """Compute them from the designs.

        *moved*, shape (P,), are the calibrated parameters in the fitting scale.
        """
        parts = []
        for i, design in enumerate(designs):
            clean = design.cleaned(design.residual[:, None])[:, 0]
            against = np.zeros(len(tried))
            for block, columns in answers_in_blocks(tried, i, design):
                against[block] = clean @ columns
            parts.append((clean @ design.shared, against, design.residual @ clean))
        shared, answers, squares = (np.array(x) for x in zip(*parts, strict=True))
        return cls(shared, answers, squares, np.pad(moved, (0, shared.shape[1] - len(moved))))


def answers_in_blocks(
    tried: Sequence[Answers], run: int, design: RunDesign
) -> Iterator[tuple[slice, FloatArray]]:
    """Yield a run's responses to the candidates, with robust weights, (N, b), block by block.

    All responses to the thousands of changes of a page would fill the memory.

    Parameters
    ----------
    tried : sequence of Candidate
    run : int
        Position of the run.
    design : RunDesign
        Of the run.

    Yields
    ------
    block : slice
        Which candidates.
    columns : array, shape (N, b)
    """
    for begin in range(0, len(tried), AT_ONCE):
        block = slice(begin, begin + AT_ONCE)
        answers = np.array([candidate.answers[run] for candidate in tried[block]])
        yield block, answers.T * design.weight[:, None]


@dataclass(frozen=True)
class Scores:
    """Gain of each candidate, with each run predicted from the others.

    Attributes
    ----------
    gain : array, shape (m,)
        Reduction of the squared error over all runs.
    prior_gain : array, shape (m,)
        Reduction of the squared distance of all shared unknowns from their priors' centres.
    scale : array, shape (m,)
        Factor on the candidate's response, from all runs together.
    cost : float
        Squared error over all runs without any candidate.
    """

    gain: FloatArray
    prior_gain: FloatArray
    scale: FloatArray
    cost: float


class Screen:
    """Scores candidates."""

    def __init__(self, grams: NormalMatrices) -> None:
        self.grams = grams
        runs = list(range(len(grams.shared)))
        self._whole = Fold(grams, runs)
        self._folds = [Fold(grams, [j for j in runs if j != k]) for k in runs]

    def scores(self, data: Residuals) -> Scores:
        """Score every candidate."""
        scale, solved = self._whole.fit(data)
        position, follow = data.pull - solved, self._whole.follow
        prior_gain = 2.0 * scale * (position @ follow) - scale**2 * np.sum(follow**2, axis=0)
        gain, cost = np.zeros_like(scale), 0.0
        for k, fold in enumerate(self._folds):
            with_it, without = fold.predict(self.grams, data, k)
            gain += without - with_it
            cost += without
        return Scores(gain, prior_gain, scale, cost)


class Fold:
    """Recalibration on some runs, with and without each candidate."""

    def __init__(self, grams: NormalMatrices, runs: list[int]) -> None:
        self.runs = runs
        matrix = grams.shared[runs].sum(axis=0)
        self._factor = cho_factor(matrix + np.eye(len(matrix)))
        cross = grams.cross[runs].sum(axis=0)
        # How the shared unknowns move when a candidate's response is added.
        self.follow = cho_solve(self._factor, cross)
        squares = grams.answers[runs].sum(axis=0)
        self.left = np.maximum(squares - np.sum(cross * self.follow, axis=0), 1e-12)
        self._cross = cross

    def fit(self, data: Residuals) -> tuple[FloatArray, FloatArray]:
        """Return scales, (m,), and the shared solution without any candidate, (Q,)."""
        solved = cho_solve(self._factor, data.against_shared[self.runs].sum(axis=0) + data.pull)
        slope = data.against_answers[self.runs].sum(axis=0) - solved @ self._cross
        scale = np.clip(-slope / self.left, LEAST_SCALE, MOST_SCALE)
        return scale, solved

    def predict(self, grams: NormalMatrices, data: Residuals, run: int) -> tuple[FloatArray, float]:
        """Return the cost of a left-out run with each candidate, (m,), and without."""
        scale, solved = self.fit(data)
        matrix, cross = grams.shared[run], grams.cross[run]
        own = grams.answers[run]
        right, against = data.against_shared[run], data.against_answers[run]
        base = -solved
        without = float(data.squares[run] + 2.0 * right @ base + base @ matrix @ base)
        # With the candidate scaled by s, the shared unknowns move by -s follow.
        shift = self.follow
        linear = against + base @ cross - (right + base @ matrix) @ shift
        quadratic = own - 2.0 * np.sum(cross * shift, axis=0)
        quadratic = quadratic + np.sum(shift * (matrix @ shift), axis=0)
        # A candidate that acts only in this run is the run's own unknown, like a zero.
        best = np.clip(-linear / np.maximum(quadratic, 1e-12), LEAST_SCALE, MOST_SCALE)
        scale = np.where(grams.alone[run], best, scale)
        with_it = without + 2.0 * linear * scale + quadratic * scale**2
        return with_it, without
