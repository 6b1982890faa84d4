"""Ridge regression with the run as the unit of noise, trust and validation.

Rows of one run are not independent samples: residuals wander slowly, and every row contains the
noise of the reference sample. So the rows are whitened with the covariance of a random walk, the
reference sample and white noise (generalised least squares). Each run has equal weight, but less if
the others do not explain it (weights of Student's t with one degree of freedom, by run). Choices
are judged on left-out runs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular

from fmu_compensator.fit.training import Array

FEWEST_TO_LEAVE_OUT, FEWEST_TO_DISTRUST = 3, 4
"""Fewest runs for leaving one out to make a choice, and for telling which one is the outlier [1],
given by arithmetic: two remain in the one case, a majority in the other. Where leaving out means
training again, the first is also the number of parts that are left out in turn."""
TRUST_ROUNDS = 3
"""Alternations between trust in the runs and solution [1]: set on no data."""
RIDGE = 1e-6
"""Weight of squared coefficients over the mean of the diagonal, given by arithmetic: only for
rounding [1]."""
FAINTEST = 1e-7
"""A direction in which all runs together are weaker than this, at unit size of the features, is
left out: given by the smallest penalty in use, which is a hundred times stronger [1]."""


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
        Values to predict.
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
        """Mean logarithm of the left-out errors, so that no single outlier decides."""
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
        Whether rises and drift count from the run's first sample. Then its noise is in every row,
        as large as the row's own noise.
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
        # Lagged temperatures are so similar that only a few directions are significant; left-out
        # runs are solved for only in these.
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
            Divisors of the features.
        """
        return np.array(self._gram), np.array(self._moment)[:, :, target], self._scale

    def solve(self, target: int, penalty: float, *, robust: bool = True) -> Solution:
        """Return the ridge regression of one target.

        Parameters
        ----------
        target : int
            Column of the target.
        penalty : float
            Weight of the squared coefficients of the features at unit size, per run [1].
        robust : bool
            Whether to give less weight to runs that the others do not explain.
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
    """Return the matrix that turns the noise of a run's rows into unit white noise."""
    covariance = np.eye(len(hours)) + shared + walk**2 * np.minimum(hours[:, None], hours[None, :])
    factor = np.linalg.cholesky(covariance)
    return np.asarray(solve_triangular(factor, np.eye(len(hours)), lower=True))
