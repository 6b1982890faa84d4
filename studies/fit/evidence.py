"""Bayesian ridge regression in which a run counts as only a few independent samples."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fmu_compensator.fit.training import Array
from studies.fit.by_run import FEWEST_TO_DISTRUST, TRUST_ROUNDS

SAMPLES_PER_RUN = 4.0
"""Rows of one run are similar: heating up, settling, cooling down and one more are its information
[1]. If every row counted, the posterior would be certain of everything seen on one day. Set on no
data."""
RATIOS = np.logspace(-4.0, 6.0, 61)
"""Candidate ratios of noise to prior variance [K^2]."""


@dataclass(frozen=True)
class Posterior:
    r"""The posterior of the weights.

    The posterior covariance of a target's weights is its noise times
    :math:`V\,\mathrm{diag}(1 / (e + \lambda))\,V^T`.

    Attributes
    ----------
    weights : array (p, m)
        Posterior mean.
    ratio : float
        lambda: noise variance over prior variance, common to all targets.
    values, vectors : array (p,), array (p, p)
        e and V: eigenvalues and vectors of the information matrix, with runs counted as samples.
    noise : array (m,)
        Variance of the residuals [um^2, urad^2].
    trust : array (runs,)
        Weight of each run, about 1 [1].
    log_evidence : float
        Of the data under the model, up to a constant; comparable for equal targets.
    """

    weights: Array
    ratio: float
    values: Array
    vectors: Array
    noise: Array
    trust: Array
    log_evidence: float


def posterior(features: Sequence[Array], targets: Sequence[Array]) -> Posterior:
    """Return the regression of some runs, with the prior's strength chosen by the evidence.

    Parameters
    ----------
    features : sequence of array (n, p)
        One per run, in units in which one prior suits all columns.
    targets : sequence of array (n, m)

    Notes
    -----
    The evidence (marginal likelihood) of each ratio is that of a Gaussian model with the noise
    profiled out, summed over targets (MacKay (1992), doi:10.1162/neco.1992.4.3.415). A run that
    the others do not explain has less weight: that of Student's t with two degrees of freedom, by
    run.
    """
    gram = np.array([x.T @ x / len(x) for x in features])
    moment = np.array([x.T @ y / len(x) for x, y in zip(features, targets, strict=True)])
    power = np.array([np.mean(y**2, axis=0) for y in targets])
    trust = np.ones(len(gram))
    rounds = TRUST_ROUNDS if len(gram) >= FEWEST_TO_DISTRUST else 1
    for last in [False] * (rounds - 1) + [True]:
        solution = _most_evident(gram, moment, power, trust)
        if last:
            break
        missed = np.array(
            [
                np.mean((y - x @ solution.weights) ** 2, axis=0)
                for x, y in zip(features, targets, strict=True)
            ]
        )
        usual = np.maximum(np.median(missed, axis=0), 1e-30)
        trust = 2.0 / (1.0 + np.mean(missed / usual, axis=1))
        trust /= trust.mean()
    return solution


def _most_evident(gram: Array, moment: Array, power: Array, trust: Array) -> Posterior:
    weights = SAMPLES_PER_RUN * trust
    count, targets = float(weights.sum()), moment.shape[2]
    values, vectors = np.linalg.eigh(np.tensordot(weights, gram, 1))
    values = np.maximum(values, 0.0)
    projected = vectors.T @ np.tensordot(weights, moment, 1)
    total = weights @ power
    best: Posterior | None = None
    for ratio in RATIOS:
        mean = projected / (values + ratio)[:, None]
        left = np.maximum(total - (projected * mean).sum(axis=0), 1e-12)
        spent = np.log1p(values / ratio).sum()
        evidence = float(-0.5 * count * np.log(left).sum() - 0.5 * targets * spent)
        if best is None or evidence > best.log_evidence:
            noise = left / count
            best = Posterior(vectors @ mean, float(ratio), values, vectors, noise, trust, evidence)
    assert best is not None
    return best
