"""Regression and Gaussian process of the runs, against scikit-learn and scipy."""

import numpy as np
import pytest
from scipy.spatial.distance import cdist

from measurement.resampling import SLOW_S
from studies.fit.evidence import SAMPLES_PER_RUN, posterior
from studies.fit.gp import GaussianProcess, _features
from studies.fit.lagged import thinned
from tests.fmu_compensator.models.made import run_of, task_of

RUNS, ROWS = 3, 40
"""Fewer than so many runs as one of them could be told to be the odd one: all count alike."""


def made(seed: int = 1) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Return features and two targets of some runs."""
    random = np.random.default_rng(seed)
    features = [random.standard_normal((ROWS, 4)) for _ in range(RUNS)]
    weights = np.array([[2.0, 0.0], [0.0, -1.0], [0.5, 0.5], [0.0, 0.1]])
    targets = [x @ weights + 0.3 * random.standard_normal((ROWS, 2)) for x in features]
    return features, targets


def test_the_weights_are_those_of_scikit_learns_ridge():
    from sklearn.linear_model import Ridge

    features, targets = made()
    found = posterior(features, targets)
    ridge = Ridge(alpha=found.ratio, fit_intercept=False)
    each = np.full(RUNS * ROWS, SAMPLES_PER_RUN / ROWS)
    ridge.fit(np.concatenate(features), np.concatenate(targets), sample_weight=each)
    assert found.weights == pytest.approx(ridge.coef_.T)


def test_the_evidence_is_the_marginal_likelihood_of_the_samples():
    """With as many rows a run as it counts for, it is a multivariate t in the limit of no prior."""
    from scipy.stats import multivariate_t

    random = np.random.default_rng(2)
    count = int(SAMPLES_PER_RUN)
    features = [random.standard_normal((count, 2)) for _ in range(RUNS)]
    targets = [x @ [[1.0], [0.5]] + 0.5 * random.standard_normal((count, 1)) for x in features]
    x, y = np.concatenate(features), np.concatenate(targets)[:, 0]

    def exact(ratio: float) -> float:
        # Noise s^2 with the prior 1/s^2, integrated out: t of few degrees of freedom.
        shape, few = np.eye(len(y)) + x @ x.T / ratio, 1e-6
        return float(multivariate_t.logpdf(y, shape=shape * 1e-12 / few, df=few))

    ratios = np.logspace(-4.0, 6.0, 61)
    assert posterior(features, targets).ratio == pytest.approx(max(ratios, key=exact))


def test_the_process_is_scikit_learns_where_every_sample_has_a_bump():
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import RBF, ConstantKernel, DotProduct

    runs = []
    for turns in (1.0, 2.0, 3.0):
        x = 5.0 * np.sin(np.linspace(0.0, 2.0 * np.pi * turns, ROWS))[:, None]
        runs.append(run_of(x, x**2, step_s=SLOW_S))
    fitted = GaussianProcess.fit(task_of(runs), centres=500)
    found = fitted.report()
    rows = [_features(run, fitted.lags_s)[thinned(run, SLOW_S)] for run in runs]
    targets = [run.targets[thinned(run, SLOW_S)] for run in runs]
    everything = np.concatenate(rows)
    bump = found["bump_size"] * float(np.median(cdist(everything[::7], everything[::7])))
    kernel = DotProduct(0.0, "fixed") + ConstantKernel(bump**2, "fixed") * RBF(
        fitted.length, "fixed"
    )
    noise = np.concatenate(
        [np.full(len(x), found["noise_over_prior"] * len(x) / SAMPLES_PER_RUN) for x in rows]
    )
    oracle = GaussianProcessRegressor(kernel, alpha=noise, optimizer=None)
    oracle.fit(everything, np.concatenate(targets))
    predicted = np.concatenate([fitted.predict(run)[:, 0] for run in runs])
    wanted = oracle.predict(np.concatenate([_features(run, fitted.lags_s) for run in runs]))
    assert found["bump_size"] > 0.0
    assert predicted == pytest.approx(wanted.ravel(), abs=0.02 * np.ptp(wanted))
