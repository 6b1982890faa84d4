"""Ridge regression in which the run is the unit: of noise, of trust, and of judging.

Rows of one run are no independent samples: what a model misses there wanders slowly, and the noise
of the sample that they all count from is in each of them. So the rows are whitened with the
covariance of a random walk, that sample and white noise (generalised least squares),
each run counts as one, a run that the others do not explain counts less (the weights of Student's
t with one degree of freedom, by run), and what a choice is worth is judged on runs left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular

from fmu_compensator.fit.training import Array

FEWEST_TO_LEAVE_OUT, FEWEST_TO_DISTRUST = 3, 4
"""Runs of which one can be left out to choose by, and of which one can be told to be the odd one
[1], given by arithmetic: two are left in the one case, and a majority in the other. Where leaving
out trains something anew, as many parts of the runs take turns as the former, the fewest."""
TRUST_ROUNDS = 3
"""Of trust in the runs and solution in turn [1]: set on no data."""
RIDGE = 1e-6
"""Weight of squared coefficients, of the mean of the diagonal, given by arithmetic: for rounding
only [1]."""
FAINTEST = 1e-7
"""A direction in which all runs together are fainter than this, at unit size of the features, is
left out: the smallest penalty in use is a hundred times stronger there, and given by that [1]."""


@dataclass(frozen=True)
class Block:
    """One run's rows.

    Attributes
    ----------
    hours : array (n,)
        Time since the run's start [h].
    features : array (n, p)
        Regressors.
    targets : array (n, m)
        What is to be predicted.
    """

    hours: Array
    features: Array
    targets: Array


@dataclass(frozen=True)
class Solution:
    """A fitted ridge regression of one target.

    Attributes
    ----------
    coefficients : array (p,)
        Weights of the features.
    trust : array (runs,)
        Weight of each run, about 1 [1].
    left_out_rms : array (runs,)
        Error of each run predicted from the others; NaN with fewer than 2 runs [target's unit].
    """

    coefficients: Array
    trust: Array
    left_out_rms: Array

    @property
    def score(self) -> float:
        """Mean of the logarithm of the left-out errors: no single odd run decides."""
        return float(np.mean(np.log(np.maximum(self.left_out_rms, 1e-12))))


class NormalEquations:
    """The normal equations of every run, for one set of features and one noise model.

    Parameters
    ----------
    blocks : sequence of Block
        The runs.
    walk : float
        Standard deviation of the random walk after one hour, over that of the white noise [1].
    referenced : bool
        Whether rises and drift count from the run's first sample. Its noise is in every row then,
        as large as that of the row itself.
    """

    def __init__(self, blocks: Sequence[Block], walk: float, *, referenced: bool = False) -> None:
        self._blocks = blocks
        size = np.array([np.mean(block.features**2, axis=0) for block in blocks]).mean(axis=0)
        self._scale = np.where(size > 0, np.sqrt(size), 1.0)
        self._gram, self._moment = [], []
        for block in blocks:
            whiten = _whitener(block.hours, walk, float(referenced))
            x = whiten @ (block.features / self._scale)
            y = whiten @ block.targets
            self._gram.append(x.T @ x / len(x))
            self._moment.append(x.T @ y / len(x))
        # Lagged temperatures are so alike that few of their directions mean anything; in these
        # alone the runs left out are solved for.
        values, vectors = np.linalg.eigh(np.mean(self._gram, axis=0))
        self._basis = vectors[:, values > FAINTEST]
        self._small_gram = np.array([self._basis.T @ gram @ self._basis for gram in self._gram])
        self._small_moment = np.array([self._basis.T @ moment for moment in self._moment])
        to_rows = self._basis / self._scale[:, None]
        self._rows = [block.features @ to_rows for block in blocks]

    def normal_equations(self, target: int) -> tuple[Array, Array, Array]:
        """Return each run's X'X and X'y at unit size of the features, and that size.

        Parameters
        ----------
        target : int
            Position of the target.

        Returns
        -------
        gram : array, shape (runs, features, features)
            X'X of each run.
        moment : array, shape (runs, features)
            X'y of each run [um or urad].
        scale : array, shape (features,)
            What the features were divided by.
        """
        return np.array(self._gram), np.array(self._moment)[:, :, target], self._scale

    def solve(self, target: int, penalty: float, *, robust: bool = True) -> Solution:
        """Return the ridge regression of one target.

        Parameters
        ----------
        target : int
            Its column.
        penalty : float
            Weight of the squared coefficients of the features at unit size, per run [1].
        robust : bool
            Trust runs less that the others do not explain.
        """
        gram, moment = self._small_gram, self._small_moment[:, :, target]
        count = len(gram)
        trust, rms = np.ones(count), np.full(count, np.nan)
        ridge = penalty * np.eye(gram.shape[1])
        for last in (False,) * (TRUST_ROUNDS - 1) + (True,) if count > 1 else ():
            rms = self._left_out(target, gram, moment, trust, ridge)
            if last or not robust or count < FEWEST_TO_DISTRUST:
                break
            usual = np.median(rms) ** 2
            trust = 2.0 * usual / np.maximum(usual + rms**2, 1e-30)
        total = np.tensordot(trust, gram, 1) / trust.sum()
        b = np.linalg.solve(total + ridge, trust @ moment / trust.sum())
        return Solution(self._basis @ b / self._scale, trust, rms)

    def _left_out(
        self, target: int, gram: Array, moment: Array, trust: Array, ridge: Array
    ) -> Array:
        """Return the RMS error of every run predicted from the others."""
        whole = trust.sum() - trust
        others = (np.tensordot(trust, gram, 1) - trust[:, None, None] * gram) / whole[:, None, None]
        right = (trust @ moment - trust[:, None] * moment) / whole[:, None]
        b = np.linalg.solve(others + ridge, right[:, :, None])[:, :, 0]
        return np.array(
            [
                np.sqrt(np.mean((block.targets[:, target] - rows @ weights) ** 2))
                for block, rows, weights in zip(self._blocks, self._rows, b, strict=True)
            ]
        )


def _whitener(hours: Array, walk: float, shared: float) -> Array:
    """Return what turns the noise of a run's rows into white noise of unit size."""
    covariance = np.eye(len(hours)) + shared + walk**2 * np.minimum(hours[:, None], hours[None, :])
    factor = np.linalg.cholesky(covariance)
    return np.asarray(solve_triangular(factor, np.eye(len(hours)), lower=True))
