"""The reference of the lathe benchmark."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.lathe import PlainRidge
from tests.fmu_compensator.models.made import lag, run_of, steps


def test_plain_ridge_finds_a_map_without_memory_and_cannot_follow_one_with() -> None:
    runs, lagging = [], []
    for seed in range(4):
        random = np.random.default_rng(seed)
        rises = np.column_stack([lag(steps(seed) / 1000.0, 900.0), random.standard_normal(300)])
        noise = 0.05 * random.standard_normal(300)
        drift = rises @ np.array([3.0, -1.0]) + noise
        runs.append(run_of(rises, drift[:, None], name=f"r{seed}"))
        lagging.append(run_of(rises, lag(drift, 3600.0)[:, None], name=f"r{seed}"))
    fitted = PlainRidge(runs[:3])
    missed = fitted.predict(runs[3]) - runs[3].targets
    assert np.sqrt(np.mean(missed**2)) == pytest.approx(0.05, rel=0.3)
    behind = PlainRidge(lagging[:3]).predict(lagging[3]) - lagging[3].targets
    assert np.sqrt(np.mean(behind**2)) > 0.3 * np.std(lagging[3].targets)
