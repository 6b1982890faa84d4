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
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve, cholesky, solve_triangular
from scipy.optimize import minimize, minimize_scalar

from fmu_compensator.fit.training import Array, TrainingRun
from measurement.errors import BadInput

LAGS_S = (900.0, 3600.0, 14400.0)
"""Lags of the rises, in addition to the rises themselves [s]. Faster ones would let the model use
the slope of a thermometer's reading: set on a lathe outside this project, where that generalised
badly to other conditions."""
DEGREES = 3.0
"""Degrees of freedom of Student's t for the size of a run's random walk [1]: set on nine splits of
the lathe's runs and fifteen simulated machines, where 90 % intervals contain 79 to 97 %. At 2 they
are too wide, at 4 those of three splits of the lathe are too narrow."""
USUAL_UM_PER_K, SPREAD_OF_USUAL = 1.5, 1.0
"""A weight's usual size, and the standard deviation of its logarithm [um/K, 1]: an elongation is
alpha times a length, 1 to 5 um/K. Wide enough that the runs decide; set on no data."""
SMALLEST_NOISE = 0.02
"""Lower limit of the noise of a displacement [um, urad]: set on no data."""
MOST_ROWS = 48
"""Number of rows used per run, evenly spread over time: as errors last hours, they tell as much as
all. Set on no data; on twelve splits of the lathe's and the electric spindle's runs errors are 3 %
larger with 24 (geometric mean), and 4 % with 96."""
LOST = 0.05
"""Share of the variance by which the omitted directions of the weights may widen an interval [1]:
omitting them keeps the file and a step small, and never makes intervals narrower. Set on no
data."""
ROUNDS = 6
"""Alternations between sizes of runs and scales: set on the lathe's runs, where the fourth no
longer changes a displayed digit."""


@dataclass(frozen=True)
class Sample:
    """The rows of one run that the weights are learnt from.

    Attributes
    ----------
    hours : array (n,)
        Time since the start of the walk [h].
    features : array (n, p)
        Rises and their lags [K].
    targets : array (n, m)
        [um, urad]
    mean : array (n, m)
        Prediction of the mean function fitted to other runs [um, urad].
    """

    hours: Array
    features: Array
    targets: Array
    mean: Array

    def whitened(self, walk: float) -> tuple[Array, Array, Array, float]:
        """Return all three whitened in time, and the log determinant.

        Parameters
        ----------
        walk : float
            Standard deviation of the walk over an hour, in units of the noise [1/sqrt(h)].
        """
        covariance = walk**2 * np.minimum.outer(self.hours, self.hours)
        covariance[np.diag_indices(len(self.hours))] += 1.0
        root = cholesky(covariance, lower=True, check_finite=False)
        width, targets = self.features.shape[1], self.targets.shape[1]
        all_three = np.column_stack([self.features, self.targets, self.mean])
        white = solve_triangular(root, all_three, lower=True, check_finite=False)
        features, measured, mean = np.split(white, [width, width + targets], axis=1)
        return features, measured, mean, 2.0 * float(np.log(np.diag(root)).sum())


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
        sizes = np.ones(len(samples))
        likely = np.zeros(samples[0].targets.shape[1])
        evidence = None
        for _ in range(ROUNDS):
            evidence = _Evidence.best(samples, sizes, likely if share is None else share, evidence)
            found = evidence.model()
            likely = evidence.likely_share()
            sizes = np.array([found.size_of(sample) for sample in samples])
        return found

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
        sizes = np.ones(len(samples))
        for _ in range(ROUNDS):
            found = self._conditioned(samples, sizes)
            sizes = np.array([found.size_of(sample) for sample in samples])
        return found

    def _conditioned(self, samples: Sequence[Sample], sizes: Array) -> Gaussian:
        """Return the model after further runs whose random walks have these sizes."""
        precision = np.linalg.inv(self.covariance)
        total, inside = precision @ self.weights, precision
        floor = SMALLEST_NOISE**2 * np.eye(len(self.spread))  # in addition to what the runs show
        squares, rows = self.rows * (self.spread - floor), self.rows
        for sample, size in zip(samples, sizes, strict=True):
            features, measured, mean, _ = sample.whitened(self.walk * size)
            missed = measured - self.share * mean
            inside, total = inside + features.T @ features, total + features.T @ missed
            squares, rows = squares + missed.T @ missed, rows + len(missed)
        covariance = np.linalg.inv(inside)
        weights = covariance @ total
        squares = squares + self.weights.T @ precision @ self.weights - weights.T @ total
        covariance, spread = (covariance + covariance.T) / 2.0, squares / rows + floor
        return replace(self, weights=weights, covariance=covariance, spread=spread, rows=rows)


@dataclass(frozen=True)
class _Evidence:
    """Sums over all runs for one size of the walk, from which weights and Sigma have closed forms.

    The first columns of ``cross`` and ``squares`` are for the targets, the last for the mean
    function.
    """

    walk: float
    share: Array
    gram: Array
    cross: Array
    squares: Array
    rows: int
    determinant: float
    start: Array

    @classmethod
    def best(
        cls, samples: Sequence[Sample], sizes: Array, share: Array, before: _Evidence | None
    ) -> _Evidence:
        """Return the evidence for the walk with the largest marginal likelihood.

        *before* provides scales to start from.
        """
        known: dict[float, _Evidence] = {}
        start = np.zeros(1 + len(LAGS_S)) if before is None else before.log_scales

        def cost(log_walk: float) -> float:
            found = cls.of(samples, sizes, share, float(np.exp(log_walk)), start)
            known[log_walk] = found
            return found.cost(found.log_scales)[0]

        best = minimize_scalar(cost, bounds=(-4.0, 6.0), method="bounded", options={"xatol": 0.05})
        return known[float(best.x)]

    @classmethod
    def of(
        cls, samples: Sequence[Sample], sizes: Array, share: Array, walk: float, start: Array
    ) -> _Evidence:
        """Return the sums over the whitened runs."""
        width, columns = samples[0].features.shape[1], 2 * len(share)
        gram, cross = np.zeros((width, width)), np.zeros((width, columns))
        squares, determinant = np.zeros((columns, columns)), 0.0
        for sample, size in zip(samples, sizes, strict=True):
            features, measured, mean, more = sample.whitened(walk * size)
            both = np.hstack([measured, mean])
            gram += features.T @ features
            cross += features.T @ both
            squares += both.T @ both
            determinant += more
        rows = sum(len(sample.hours) for sample in samples)
        return cls(walk, share, gram, cross, squares, rows, determinant, start)

    @cached_property
    def less_mean(self) -> Array:
        """Matrix that subtracts the mean function's share from the targets, shape (2 m, m)."""
        return np.vstack([np.eye(len(self.share)), -np.diag(self.share)])

    def posterior(self, scale: Array) -> tuple[Array, Array, float]:
        """Return the posterior of the weights.

        Returns
        -------
        covariance : array (p, p)
            Over Sigma [1/K^2].
        weights : array (p, 2 m)
            Of targets and mean function.
        determinant : float
            Log ratio of the determinants of prior and posterior covariance.
        """
        prior = np.sqrt(by_feature(scale, len(self.gram)))
        inside = np.eye(len(prior)) + prior[:, None] * self.gram * prior
        factor = cho_factor(inside, check_finite=False)
        inverse = cho_solve(factor, np.eye(len(prior)), check_finite=False)
        covariance = prior[:, None] * (inverse + inverse.T) / 2.0 * prior
        determinant = 2.0 * float(np.log(np.diag(factor[0])).sum())
        return covariance, covariance @ self.cross, determinant

    def unexplained(self, scale: Array, weights: Array) -> Array:
        """Return the residual squares of targets and mean function, shape (2 m, 2 m).

        Computed at the minimum, where errors of the weights enter only squared.
        """
        inside = self.gram + np.diag(1.0 / by_feature(scale, len(self.gram)))
        along = weights.T @ self.cross
        return np.asarray(self.squares - along - along.T + weights.T @ inside @ weights)

    def spread(self, scale: Array, weights: Array) -> Array:
        """Return the most likely Sigma for these weights."""
        found = self.less_mean.T @ self.unexplained(scale, weights) @ self.less_mean / self.rows
        return np.asarray(found + SMALLEST_NOISE**2 * np.eye(len(found)))

    def likely_share(self) -> Array:
        """Return the mean function's most likely share of each target, shape (m,); 0 if none."""
        scale = np.exp(self.log_scales)
        left, count = self.unexplained(scale, self.posterior(scale)[1]), len(self.share)
        of_mean = np.diag(left)[count:]
        return np.clip(np.diag(left[:count, count:]) / np.where(of_mean > 0.0, of_mean, 1.0), 0, 1)

    def cost(self, log_scales: Array) -> tuple[float, Array]:
        """Return the negative log marginal likelihood with the weak prior, and its gradient.

        Sigma is profiled out.
        """
        scale = np.exp(log_scales)
        prior = by_feature(scale, len(self.gram))
        covariance, told, determinant = self.posterior(scale)
        noise, weights = np.diag(self.spread(scale, told)), told @ self.less_mean
        size = 0.5 * (log_scales[:, None] + np.log(noise)) - np.log(USUAL_UM_PER_K)
        fit = 0.5 * len(noise) * (determinant + self.determinant)
        fit += 0.5 * self.rows * np.log(noise).sum()
        cost = fit + 0.5 * np.sum((size / SPREAD_OF_USUAL) ** 2)
        pulls = size / SPREAD_OF_USUAL**2
        determined = len(noise) * (1.0 - np.diag(covariance) / prior)
        by_noise = 0.5 * self.rows + 0.5 * pulls.sum(axis=0)
        explained = (weights**2 / prior[:, None]) @ (by_noise / (self.rows * noise))
        by_weight = 0.5 * determined - explained
        gradient = by_weight.reshape(len(log_scales), -1).sum(axis=1) + 0.5 * pulls.sum(axis=1)
        return float(cost), np.asarray(gradient)

    @cached_property
    def log_scales(self) -> Array:
        """The most likely prior variances of the weights."""
        bounds = [(-14.0, 18.0)] * len(self.start)
        # To the last digits, so that the file is the same on every machine.
        exact = {"ftol": 0.0, "gtol": 1e-8}
        found = minimize(
            self.cost, self.start, jac=True, method="L-BFGS-B", bounds=bounds, options=exact
        )
        return np.asarray(found.x)

    def model(self) -> Gaussian:
        """Return the model at its most likely scales."""
        scale = np.exp(self.log_scales)
        covariance, told, _ = self.posterior(scale)
        weights, spread, rows = told @ self.less_mean, self.spread(scale, told), float(self.rows)
        return Gaussian(weights, covariance, scale, self.walk, spread, rows, self.share)


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
    known = vectors * np.sqrt(np.maximum(values, 0.0))
    features = np.vstack([sample.features for sample in samples])
    hours = np.concatenate([sample.hours for sample in samples])
    # The directions that explain most of the runs come first.
    _, lengths, turned = np.linalg.svd(features @ known, full_matrices=False)
    explained = np.cumsum(lengths**2) / len(features)
    usual = 1.0 + model.walk**2 * hours.mean() + model.novelty(features).mean()
    enough = explained[-1] - explained <= LOST * usual
    both = np.vstack([before, (turned @ known.T)[: int(np.argmax(enough)) + 1]])
    return both if len(both) <= size else np.asarray(np.linalg.qr(both, mode="r"))  # same D' D


def rises_and_lags(time_s: Array, rises: Array) -> Array:
    """Return the features of a run, shape (n, k * (1 + lags)): rises, then lag by lag [K].

    Parameters
    ----------
    time_s : array (n,)
        Increasing [s].
    rises : array (n, k)
        Rises above the first reading or above fixed temperatures [K]. The lags start at zero;
        between rows a rise moves evenly.
    """
    lagged = np.zeros((len(rises), len(LAGS_S), rises.shape[1]))
    state = np.zeros((len(LAGS_S), rises.shape[1]))
    # As at run time: `share` and `behind` of every step and lag.
    steps, tau = np.diff(time_s)[:, None, None], np.array(LAGS_S)[:, None]
    parts = -np.expm1(-steps / tau)
    late = tau / steps - (1.0 - parts) / parts
    seen = rises[1:, None] - late * np.diff(rises, axis=0)[:, None]
    for row, (part, rise) in enumerate(zip(parts, seen, strict=True), start=1):
        state = state + part * (rise - state)
        lagged[row] = state
    return np.hstack([rises, lagged.reshape(len(rises), len(LAGS_S) * rises.shape[1])])


def spread_rows(hours: Array, known: NDArray[np.bool_]) -> NDArray[np.int_]:
    """Return up to `MOST_ROWS` of the known rows, evenly spread in time, without the first row."""
    rows = np.flatnonzero(known)
    rows = rows[rows > 0]
    if len(rows) <= MOST_ROWS:
        return rows
    wanted = np.linspace(hours[rows[0]], hours[rows[-1]], MOST_ROWS)
    return np.asarray(rows[np.unique(np.searchsorted(hours[rows], wanted).clip(0, len(rows) - 1))])


def sample_of(
    run: TrainingRun, rises: Array, targets: Array, mean: Array, settled_h: float = 0.0
) -> Sample:
    """Return the rows of a run to learn the weights from.

    Parameters
    ----------
    run : TrainingRun
        Its rows with complete inputs.
    rises : array (n, k)
        Of its thermometers [K].
    targets, mean : array (n, m)
        Measured targets (NaN: not measured) and the mean function's prediction [um, urad].
    settled_h : float
        Time that the walk had run at the first row: 0 if targets start at zero [h].
    """
    hours = (run.time_s - run.time_s[0]) / 3600.0 if len(run.time_s) else run.time_s
    known = np.asarray(np.isfinite(targets + mean).all(axis=1))
    features = rises_and_lags(run.time_s, rises)
    first = int(known.argmax())
    if not settled_h and first:
        # Drift counts from the first reading, and so does everything that explains it.
        known[first] = False
        hours, features = hours - hours[first], features - features[first]
        targets, mean = targets - targets[first], mean - mean[first]
    rows = spread_rows(hours, known)
    return Sample(hours[rows] + settled_h, features[rows], targets[rows], mean[rows])
