r"""The Gaussian model of drift: scales from the marginal likelihood, weights by conditioning.

.. math::
    y(t) = a\,m(t) + \Phi(t) w + b(t) + e, \qquad
    w \sim N(0, g_k \Sigma), \quad b \sim \text{random walk}, \quad e \sim N(0, \Sigma)

m is the mean function (an error model, or nothing) and a its weight, between 0 and 1 for each
target, as confirmed by runs that it was not fitted to. Phi holds the rises of the thermometers and
their first-order lags. b starts at zero; its variance grows by rho^2 Sigma per hour, times a size
for each run. All targets share g, rho and the sizes, so one number describes how uncertain a sample
is, and Sigma converts it to um and urad. The rises and each lag have their own scale g_k: weights
are independent Gaussians, and the runs determine how much of the drift is delayed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import minimize

from fmu_compensator.fit.features import LAGS_S, Sample
from fmu_compensator.fit.training import Array
from measurement.errors import BadInput

DEGREES = 3.0
"""Degrees of freedom of Student's t for the size of a run's random walk [1]: set on nine splits of
the lathe's runs and fifteen simulated machines, where 90 % intervals contain 79 to 97 %. At 2 they
are too wide, at 4 those of three splits of the lathe are too narrow."""
USUAL_UM_PER_K, SPREAD_OF_USUAL = 2.2, 1.0
"""Usual drift for one kelvin of all thermometers, and the standard deviation of its logarithm
[um/K, 1]: an elongation is alpha times a length, 1 to 5 um/K, and this is the middle on a
logarithmic scale. Wide enough that the runs decide; set on no data."""
SPREAD_OF_WALK = 2.0
"""Standard deviation of the logarithm of the random walk's size over an hour in units of the noise,
about 0 [1]. Wide enough that the runs decide; set on no data."""
SMALLEST_NOISE = 0.02
"""Lower limit of the noise of a displacement [um, urad]: set on no data."""
LOST = 0.05
"""Share of the variance by which the omitted directions of the weights may widen an interval [1]:
omitting them keeps the file and a step small, and never makes intervals narrower. Set on no
data."""
FINITE = (-20.0, 20.0)
"""Logarithms of scales beyond which a covariance of doubles is not positive definite."""
ROUNDS = 6
"""Alternations between sizes of runs and scales: set on the lathe's runs, where the fourth no
longer changes a displayed digit."""


@dataclass(frozen=True)
class _Turned:
    """The rows of runs, turned in time so that the errors of all rows are independent.

    Attributes
    ----------
    features : array (N, p)
    measured, mean : array (N, m)
        Targets, and predictions of the mean function.
    growth : array (N,)
        Variance of a walk with unit variance per hour [h].
    counts : tuple of int
        Number of rows of each run.
    """

    features: Array
    measured: Array
    mean: Array
    growth: Array
    counts: tuple[int, ...]

    @classmethod
    def of(cls, samples: Sequence[Sample]) -> _Turned:
        """Turn the rows of some runs."""
        parts = []
        for sample in samples:
            # The independent directions of a walk with unit variance per hour.
            growth, turn = np.linalg.eigh(np.minimum.outer(sample.hours, sample.hours))
            three = (turn.T @ part for part in (sample.features, sample.targets, sample.mean))
            parts.append((*three, np.maximum(growth, 0.0)))
        features, measured, mean, growth = map(np.concatenate, zip(*parts, strict=True))
        return cls(features, measured, mean, growth, tuple(len(s.hours) for s in samples))

    def variance(self, walk: float, sizes: Array) -> Array:
        """Return the variance of each row's error over that of the noise, shape (N,) [1].

        Parameters
        ----------
        walk : float
            Standard deviation of the walk over an hour, in units of the noise [1/sqrt(h)].
        sizes : array, shape (runs,)
            Of each run's walk over the usual [1].
        """
        return np.asarray(1.0 + (walk * np.repeat(sizes, self.counts)) ** 2 * self.growth)


@dataclass(frozen=True)
class Gaussian:
    """The model, fitted.

    Attributes
    ----------
    weights : array (p, m)
        Posterior mean of w [um/K, urad/K].
    covariance : array (p, p)
        Posterior covariance of w over Sigma, V [1/K^2].
    scale : array (1 + lags,)
        Prior variance of w over Sigma, g, for the rises and for each lag [1/K^2].
    walk : float
        rho [1/sqrt(h)].
    spread : array (m, m)
        Sigma [um^2, um urad, urad^2].
    rows : float
        Number of rows that Sigma is based on.
    share : array (m,)
        a [1].
    """

    weights: Array
    covariance: Array
    scale: Array
    walk: float
    spread: Array
    rows: float
    share: Array

    @classmethod
    def fit(cls, samples: Sequence[Sample], share: Array | None = None) -> Gaussian:
        """Return the model of some runs' samples.

        Parameters
        ----------
        samples : sequence of Sample
        share : array (m,), optional
            a, if given; by default the most likely one.

        Raises
        ------
        BadInput
            If there is no row to learn from.
        """
        samples = [sample for sample in samples if len(sample.hours)]
        if not samples:
            raise BadInput("training runs", "", "no row has all temperatures and displacements")
        rows, sizes = _Turned.of(samples), np.ones(len(samples))
        likely, logs = np.zeros(samples[0].targets.shape[1]), np.zeros(2 + len(LAGS_S))
        for _ in range(ROUNDS):
            evidence = _Evidence(rows, sizes, likely if share is None else share)
            logs = evidence.best(logs)
            model, likely = evidence.model(logs), evidence.likely_share(logs)
            sizes = np.array([model.size_of(sample) for sample in samples])
        return model

    def averaged(self, other: Gaussian, shared: NDArray[np.bool_]) -> Gaussian:
        """Return the average of two models: of their predictions, shares and noise; as sure of what
        the weights do as this one.

        Parameters
        ----------
        other : Gaussian
            A model of some of the features.
        shared : array of bool, shape (p,)
            Which these are; the other's weights of the rest are zero.
        """
        weights = self.weights / 2.0
        weights[shared] += other.weights / 2.0
        share, spread = (self.share + other.share) / 2.0, (self.spread + other.spread) / 2.0
        return replace(self, weights=weights, share=share, spread=spread)

    def missed(self, sample: Sample) -> Array:
        """Return the residuals of mean function and weights, shape (n, m)."""
        explained = self.share * sample.mean + sample.features @ self.weights
        return np.asarray(sample.targets - explained)

    def size_of(self, sample: Sample) -> float:
        """Return the size of a run's random walk over the usual: the mode for Student's t [1]."""
        hours = sample.hours
        wanted = np.arange(0.5, hours[-1] + 0.25, 0.5)
        rows = np.unique(np.searchsorted(hours[:-1], wanted))
        left = self.missed(sample)[rows] / np.sqrt(np.diag(self.spread))
        # A step holds the noise of both of its ends; the first one, that of the reading at 0.
        variance = self.walk**2 * np.diff(hours[rows], prepend=0.0) + 2.0
        steps = (np.diff(left, axis=0, prepend=0.0) ** 2).mean(axis=1) / variance
        return float(np.sqrt((DEGREES + steps.sum()) / (DEGREES + len(rows))))

    def novelty(self, features: Array) -> Array:
        """Return each row's variance due to the weights, over that of the noise [1]."""
        return np.asarray(np.einsum("ij,jk,ik->i", features, self.covariance, features))

    def updated(self, samples: Sequence[Sample]) -> Gaussian:
        """Return the model after further runs; scales are kept, earlier runs are not needed."""
        if not samples:
            return self
        rows, sizes = _Turned.of(samples), np.ones(len(samples))
        for _ in range(ROUNDS):
            model = self._conditioned(rows, sizes)
            sizes = np.array([model.size_of(sample) for sample in samples])
        return model

    def _conditioned(self, rows: _Turned, sizes: Array) -> Gaussian:
        """Return the model after further runs whose random walks have these sizes."""
        precision = np.linalg.inv(self.covariance)
        total, inside = precision @ self.weights, precision
        floor = SMALLEST_NOISE**2 * np.eye(len(self.spread))  # in addition to what the runs show
        variance = rows.variance(self.walk, sizes)
        missed = rows.measured - self.share * rows.mean
        weighted = rows.features.T / variance
        inside, total = inside + weighted @ rows.features, total + weighted @ missed
        covariance = np.linalg.inv(inside)
        weights = covariance @ total
        squares = self.rows * (self.spread - floor) + (missed.T / variance) @ missed
        squares += self.weights.T @ precision @ self.weights - weights.T @ total
        count, covariance = self.rows + len(missed), (covariance + covariance.T) / 2.0
        spread = squares / count + floor
        return replace(self, weights=weights, covariance=covariance, spread=spread, rows=count)


@dataclass(frozen=True)
class _Posterior:
    """What some rows say about the weights, for one size of the walk and the scales.

    Attributes
    ----------
    features : array (N, p)
        [K]
    variance : array (N,)
        Of the rows' errors, over Sigma [1].
    prior : array (p,)
        Variance of the weights, over Sigma [1/K^2].
    covariance : array (p, p)
        Of the weights given the rows, over Sigma [1/K^2].
    determinant : float
        Log ratio of the determinants of prior and posterior covariance.
    """

    features: Array
    variance: Array
    prior: Array
    covariance: Array
    determinant: float

    @classmethod
    def of(cls, features: Array, variance: Array, prior: Array) -> _Posterior:
        """Return what rows say."""
        root = np.sqrt(prior)
        gram = features.T @ (features / variance[:, None])
        inside = np.eye(len(root)) + root[:, None] * gram * root
        factor = cho_factor(inside, check_finite=False)
        inverse = cho_solve(factor, np.eye(len(root)), check_finite=False)
        covariance = root[:, None] * (inverse + inverse.T) / 2.0 * root
        determinant = 2.0 * float(np.log(np.diag(factor[0])).sum())
        return cls(features, variance, prior, covariance, determinant)

    def weights(self, columns: Array) -> Array:
        """Return the weights that explain some columns, (N, c), best, shape (p, c)."""
        return np.asarray(self.covariance @ (self.features.T @ (columns / self.variance[:, None])))

    def squares(self, left: Array, weights: Array) -> Array:
        """Return the squares of what these weights leave, (N, c), and of them, shape (c, c)."""
        return np.asarray((left.T / self.variance) @ left + (weights.T / self.prior) @ weights)


class _Evidence:
    """The marginal likelihood of walk and scales; weights and Sigma have closed forms.

    Parameters
    ----------
    rows : _Turned
    sizes : array (runs,)
        Of each run's walk over the usual [1].
    share : array (m,)
        Of the mean function in each target [1].
    """

    def __init__(self, rows: _Turned, sizes: Array, share: Array) -> None:
        self._rows, self._sizes, self._share = rows, sizes, share
        self._targets = rows.measured - share * rows.mean

    def best(self, start: Array) -> Array:
        """Return the most likely logarithms of walk and scales, shape (2 + lags,)."""
        # A first step along the gradient would be as long as there are rows: bounds stop it.
        near = minimize(self.cost, start, jac=True, method="L-BFGS-B", bounds=[FINITE] * len(start))
        # To the last digits, so that the file is the same on every machine.
        exact = {"gtol": 1e-6}
        return np.asarray(minimize(self.cost, near.x, jac=True, method="BFGS", options=exact).x)

    def posterior(self, logs: Array) -> _Posterior:
        """Return what the rows say about the weights with this walk and these scales."""
        features, variance = self._rows.features, self._rows.variance(np.exp(logs[0]), self._sizes)
        return _Posterior.of(features, variance, by_feature(np.exp(logs[1:]), features.shape[1]))

    def cost(self, logs: Array) -> tuple[float, Array]:
        """Return the negative log marginal likelihood with weak priors, and its gradient.

        Sigma is profiled out.
        """
        posterior, rows = self.posterior(logs), len(self._targets)
        weights = posterior.weights(self._targets)
        left = self._targets - posterior.features @ weights
        noise = np.diag(self._spread(posterior, left, weights))
        # The more thermometers share the drift, the less follows each: variances add up.
        thermometers = len(weights) // (len(logs) - 1)
        usual = USUAL_UM_PER_K / np.sqrt(thermometers)
        size = 0.5 * (logs[1:, None] + np.log(noise)) - np.log(usual)
        fit = 0.5 * len(noise) * (posterior.determinant + float(np.log(posterior.variance).sum()))
        fit += 0.5 * rows * np.log(noise).sum()
        far = logs[0] / SPREAD_OF_WALK
        cost = fit + 0.5 * np.sum((size / SPREAD_OF_USUAL) ** 2) + 0.5 * far**2
        pulls = size / SPREAD_OF_USUAL**2
        by_square = 0.5 * (rows + pulls.sum(axis=0)) / (rows * noise)
        determined = 0.5 * len(noise) * (1.0 - np.diag(posterior.covariance) / posterior.prior)
        by_weight = determined - (weights**2 / posterior.prior[:, None]) @ by_square
        by_scale = by_weight.reshape(len(logs) - 1, -1).sum(axis=1) + 0.5 * pulls.sum(axis=1)
        novelty = np.sum((posterior.features @ posterior.covariance) * posterior.features, axis=1)
        by_variance = 0.5 * len(noise) * (posterior.variance - novelty) - left**2 @ by_square
        by_walk = 2.0 * float((1.0 - 1.0 / posterior.variance) @ (by_variance / posterior.variance))
        by_walk += far / SPREAD_OF_WALK
        return float(cost), np.append(by_walk, by_scale)

    def _spread(self, posterior: _Posterior, left: Array, weights: Array) -> Array:
        """Return the most likely Sigma, from these weights and what they leave of targets."""
        squares = posterior.squares(left, weights) / len(left)
        return np.asarray(squares + SMALLEST_NOISE**2 * np.eye(len(squares)))

    def likely_share(self, logs: Array) -> Array:
        """Return the mean function's most likely share of each target, shape (m,); 0 if none."""
        both, posterior = np.hstack([self._rows.measured, self._rows.mean]), self.posterior(logs)
        weights, count = posterior.weights(both), len(self._share)
        left = posterior.squares(both - posterior.features @ weights, weights)
        of_mean = np.diag(left)[count:]
        return np.clip(np.diag(left[:count, count:]) / np.where(of_mean > 0.0, of_mean, 1.0), 0, 1)

    def model(self, logs: Array) -> Gaussian:
        """Return the model with this walk and these scales."""
        posterior, (walk, *scale) = self.posterior(logs), np.exp(logs)
        weights = posterior.weights(self._targets)
        left = self._targets - posterior.features @ weights
        spread, rows = self._spread(posterior, left, weights), float(len(left))
        return Gaussian(
            weights, posterior.covariance, np.array(scale), float(walk), spread, rows, self._share
        )


def by_feature(scale: Array, features: int) -> Array:
    """Return the scale of each feature, shape (p,): rises first, then lag by lag."""
    return np.repeat(scale, features // len(scale))


def directions(model: Gaussian, samples: Sequence[Sample], before: Array | None = None) -> Array:
    """Return D, shape (q, p): V is approximately and at most G - D' D, with G from the scales.

    D holds as many of the directions determined by the runs as `LOST` requires, in addition to
    those determined by earlier runs.

    Parameters
    ----------
    model : Gaussian
    samples : sequence of Sample
        Of runs like those in training, or like those since *before*.
    before : array (r, p), optional
        D of the earlier runs.
    """
    size = len(model.weights)
    before = np.zeros((0, size)) if before is None else before
    prior = np.diag(by_feature(model.scale, size))
    values, vectors = np.linalg.eigh(prior - before.T @ before - model.covariance)
    scaled = vectors * np.sqrt(np.maximum(values, 0.0))
    features = np.vstack([sample.features for sample in samples])
    hours = np.concatenate([sample.hours for sample in samples])
    # The directions that explain most of the runs come first.
    _, lengths, turned = np.linalg.svd(features @ scaled, full_matrices=False)
    explained = np.cumsum(lengths**2) / len(features)
    usual = 1.0 + model.walk**2 * hours.mean() + model.novelty(features).mean()
    enough = explained[-1] - explained <= LOST * usual
    both = np.vstack([before, (turned @ scaled.T)[: int(np.argmax(enough)) + 1]])
    return both if len(both) <= size else np.asarray(np.linalg.qr(both, mode="r"))  # same D' D
