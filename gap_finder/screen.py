"""How well each missing effect explains what calibration leaves, run by run.

Everything is done on normal matrices, so that leaving out a run, recalibrating within each fold and
drawing runs in which nothing is missing cost no simulation.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from gap_finder.candidates import LEAST, MOST, Candidate
from gap_finder.design import RunDesign
from plant_model.parameters import FloatArray

BLOCK = 1000
"""Candidates whose answers are copied at once."""


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
    between : array, shape (R, m, m) or (R, 0, 0)
        Candidates' answers against each other, where they were asked for.
    """

    shared: FloatArray
    cross: FloatArray
    answers: FloatArray
    between: FloatArray

    @classmethod
    def of(
        cls, designs: Sequence[RunDesign], tried: Sequence[Candidate], *, between: bool = False
    ) -> NormalMatrices:
        """Gather the matrices, and on demand those between candidates."""
        shared, cross, answers, mutual = [], [], [], []
        for i, design in enumerate(designs):
            clean_shared = design.cleaned(design.shared)
            shared.append(design.shared.T @ clean_shared)
            cross.append(np.zeros((design.shared.shape[1], len(tried))))
            answers.append(np.zeros(len(tried)))
            mutual.append(np.zeros((len(tried),) * 2 if between else (0, 0)))
            for some, columns in answers_in_blocks(tried, i, design):
                cross[-1][:, some] = clean_shared.T @ columns
                clean = design.cleaned(columns)
                answers[-1][some] = np.sum(columns * clean, axis=0)
                for others, beside in answers_in_blocks(tried, i, design) if between else ():
                    mutual[-1][others, some] = beside.T @ clean
        return cls(np.array(shared), np.array(cross), np.array(answers), np.array(mutual))

    def beside(self, which: int) -> NormalMatrices:
        """Return the same with one candidate in force, its size a shared unknown, the last one.

        Parameters
        ----------
        which : int
            Position of the candidate. The most that it is scaled by is one standard deviation.
        """
        own = MOST * self.cross[:, :, which : which + 1]
        corner = MOST**2 * self.answers[:, which, None, None]
        shared = np.block([[self.shared, own], [np.swapaxes(own, 1, 2), corner]])
        cross = np.concatenate([self.cross, MOST * self.between[:, which : which + 1]], axis=1)
        return replace(self, shared=shared, cross=cross)


@dataclass(frozen=True)
class ResidualSets:
    """Residuals of one or many data sets against the same design.

    Attributes
    ----------
    against_shared : array, shape (D, R, Q)
    against_answers : array, shape (D, R, m)
    squares : array, shape (D, R)
    pull : array, shape (D, Q)
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
        tried: Sequence[Candidate],
        residuals: Sequence[FloatArray],
        moved: FloatArray | None = None,
    ) -> ResidualSets:
        """Gather from residuals, one array (D, N) for each run.

        *moved*, shape (P,), is where calibration left its parameters, in the fitting scale.
        """
        parts = []
        for i, (design, residual) in enumerate(zip(designs, residuals, strict=True)):
            clean = design.cleaned(residual.T)
            against = np.zeros((len(residual), len(tried)))
            for some, columns in answers_in_blocks(tried, i, design):
                against[:, some] = clean.T @ columns
            parts.append((clean.T @ design.shared, against, np.sum(residual.T * clean, axis=0)))
        shared, answers, squares = (np.stack(list(x), axis=1) for x in zip(*parts, strict=True))
        pull = np.zeros((len(squares), shared.shape[2]))
        if moved is not None:
            pull[:, : len(moved)] = moved
        return cls(shared, answers, squares, pull)

    def beside(self, which: int) -> ResidualSets:
        """Return the same for :meth:`NormalMatrices.beside`.

        Parameters
        ----------
        which : int
            Position of the candidate.
        """
        own = MOST * self.against_answers[:, :, which : which + 1]
        return replace(
            self,
            against_shared=np.concatenate([self.against_shared, own], axis=2),
            pull=np.concatenate([self.pull, np.zeros((len(self.pull), 1))], axis=1),
        )


def answers_in_blocks(
    tried: Sequence[Candidate], run: int, design: RunDesign
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
    some : slice
        Which candidates.
    columns : array, shape (N, b)
    """
    for begin in range(0, len(tried), BLOCK):
        some = slice(begin, begin + BLOCK)
        yield some, np.array([one.answers[run] for one in tried[some]]).T * design.weight[:, None]


@dataclass(frozen=True)
class Scores:
    """What each candidate gains, for each data set.

    Attributes
    ----------
    gain : array, shape (D, m)
        Fall of the cost over all runs, recalibrated (in sample).
    scale : array, shape (D, m)
        By how much the candidate's answer is scaled.
    loro_gain : array, shape (D, R, m)
        Fall of the leave-one-run-out cost of each run.
    cost : array, shape (D,)
        Cost that recalibration without any effect leaves.
    loro_cost : array, shape (D, R)
        Leave-one-run-out cost of each run without any effect.
    """

    gain: FloatArray
    scale: FloatArray
    loro_gain: FloatArray
    cost: FloatArray
    loro_cost: FloatArray


class Screen:
    """Scores candidates against data sets that share a design.

    Parameters
    ----------
    grams : NormalMatrices
    """

    def __init__(self, grams: NormalMatrices) -> None:
        self.grams = grams
        self.runs = len(grams.shared)

    @cached_property
    def _whole(self) -> Fold:
        return Fold(self.grams, list(range(self.runs)))

    @cached_property
    def _folds(self) -> list[Fold]:
        everything = range(self.runs)
        return [Fold(self.grams, [j for j in everything if j != k]) for k in everything]

    def fold_without(self, run: int) -> Fold:
        """Return recalibration on all runs but one."""
        return self._folds[run]

    def scores(self, data: ResidualSets) -> Scores:
        """Score every candidate on every data set."""
        gain, scale, cost, _ = self._whole.fit(data)
        loro_gain, loro_cost = [], []
        for k, fold in enumerate(self._folds):
            with_it, without = fold.predict(self.grams, data, k)
            loro_gain.append(without[:, None] - with_it)
            loro_cost.append(without)
        return Scores(gain, scale, np.stack(loro_gain, axis=1), cost, np.stack(loro_cost, axis=1))

    def last_shared(self, data: ResidualSets) -> FloatArray:
        """Return what recalibration makes of the last shared unknown with each candidate, (D, m).

        Parameters
        ----------
        data : ResidualSets
        """
        _, scale, _, solved = self._whole.fit(data)
        return np.asarray(-solved[:, -1:] - scale * self._whole.follow[-1])


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

    def fit(self, data: ResidualSets) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Return gain (D, m), scale (D, m), cost without (D,) and shared solution (D, Q)."""
        right = data.against_shared[:, self.runs].sum(axis=1) + data.pull
        solved = cho_solve(self._factor, right.T).T
        cost = data.squares[:, self.runs].sum(axis=1) - np.sum(right * solved, axis=1)
        slope = data.against_answers[:, self.runs].sum(axis=1) - solved @ self._cross
        scale = np.clip(-slope / self.left, LEAST, MOST)
        gain = -(2.0 * slope * scale + self.left * scale**2)
        return gain, scale, cost, solved

    def predict(
        self, grams: NormalMatrices, data: ResidualSets, run: int
    ) -> tuple[FloatArray, FloatArray]:
        """Return the cost of a run left out with each candidate (D, m) and without (D,)."""
        _, scale, _, solved = self.fit(data)
        matrix, cross = grams.shared[run], grams.cross[run]
        own = grams.answers[run]
        alone = (own > 0.0) & (grams.answers[self.runs].sum(axis=0) == 0.0)
        right, against = data.against_shared[:, run], data.against_answers[:, run]
        base = -solved
        without = (
            data.squares[:, run]
            + 2.0 * np.sum(right * base, axis=1)
            + np.sum((base @ matrix) * base, axis=1)
        )
        # With the candidate scaled by s the shared columns move by -s follow.
        shift = self.follow
        linear = against + base @ cross - (right + base @ matrix) @ shift
        quadratic = own - 2.0 * np.sum(cross * shift, axis=0)
        quadratic = quadratic + np.sum(shift * (matrix @ shift), axis=0)
        # What began in this very run is an unknown of its own, like a zero: nothing else tells it.
        best = np.clip(-linear / np.maximum(quadratic, 1e-12), LEAST, MOST)
        scale = np.where(alone, best, scale)
        with_it = without[:, None] + 2.0 * linear * scale + quadratic * scale**2
        return with_it, without
