"""How well each missing effect explains what calibration leaves, run by run.

Everything is done on normal matrices, so that leaving out a run and recalibrating within each fold
cost no simulation.
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
    """What has an answer in every run."""

    @property
    def answers(self) -> tuple[FloatArray, ...]:
        """Weighted, each (N,)."""


@dataclass(frozen=True)
class NormalMatrices:
    """Normal matrices of every run, minimised over its nuisance parameters.

    Attributes
    ----------
    shared : array, shape (R, Q, Q)
        Between the shared columns.
    cross : array, shape (R, Q, m)
        Shared columns against candidates' answers.
    answers : array, shape (R, m)
        Squares of the answers.
    """

    shared: FloatArray
    cross: FloatArray
    answers: FloatArray

    @classmethod
    def of(cls, designs: Sequence[RunDesign], tried: Sequence[Answers]) -> NormalMatrices:
        """Gather the matrices."""
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
        """Where no other run tells a candidate's size, shape (R, m)."""
        return told_by_one_run(self.answers)


@dataclass(frozen=True)
class Residuals:
    """What is left of every run, against its design.

    Attributes
    ----------
    against_shared : array, shape (R, Q)
    against_answers : array, shape (R, m)
    squares : array, shape (R,)
    pull : array, shape (Q,)
        Where the shared unknowns stand from their prior's centre already.
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
        """Gather from the designs.

        *moved*, shape (P,), is where calibration left its parameters, in the fitting scale.
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
    """Return the candidates' answers in a run, robust-weighted, (N, b), some at a time.

    Thousands of changes of a page's description would fill the memory.

    Parameters
    ----------
    tried : sequence of Candidate
    run : int
        Its position.
    design : RunDesign
        Its own.

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
    """What each candidate gains, runs predicted from the others.

    Attributes
    ----------
    gain : array, shape (m,)
        Fall of what is left of all runs.
    prior_gain : array, shape (m,)
        Fall of the squares by which all shared unknowns are away from their priors' centres.
    scale : array, shape (m,)
        By how much the candidate's answer is scaled, all runs together.
    cost : float
        What is left of all runs without any candidate.
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
        # How the shared columns move when a candidate's answer is added.
        self.follow = cho_solve(self._factor, cross)
        squares = grams.answers[runs].sum(axis=0)
        self.left = np.maximum(squares - np.sum(cross * self.follow, axis=0), 1e-12)
        self._cross = cross

    def fit(self, data: Residuals) -> tuple[FloatArray, FloatArray]:
        """Return scale (m,) and shared solution without any candidate (Q,)."""
        solved = cho_solve(self._factor, data.against_shared[self.runs].sum(axis=0) + data.pull)
        slope = data.against_answers[self.runs].sum(axis=0) - solved @ self._cross
        scale = np.clip(-slope / self.left, LEAST_SCALE, MOST_SCALE)
        return scale, solved

    def predict(self, grams: NormalMatrices, data: Residuals, run: int) -> tuple[FloatArray, float]:
        """Return the cost of a run left out with each candidate (m,) and without."""
        scale, solved = self.fit(data)
        matrix, cross = grams.shared[run], grams.cross[run]
        own = grams.answers[run]
        right, against = data.against_shared[run], data.against_answers[run]
        base = -solved
        without = float(data.squares[run] + 2.0 * right @ base + base @ matrix @ base)
        # With the candidate scaled by s the shared columns move by -s follow.
        shift = self.follow
        linear = against + base @ cross - (right + base @ matrix) @ shift
        quadratic = own - 2.0 * np.sum(cross * shift, axis=0)
        quadratic = quadratic + np.sum(shift * (matrix @ shift), axis=0)
        # What acts in this very run alone is an unknown of its own, like a zero.
        best = np.clip(-linear / np.maximum(quadratic, 1e-12), LEAST_SCALE, MOST_SCALE)
        scale = np.where(grams.alone[run], best, scale)
        with_it = without + 2.0 * linear * scale + quadratic * scale**2
        return with_it, without
