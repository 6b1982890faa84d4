"""Drift against temperature: lag and rate, from loops whose lag is known."""

import numpy as np
import pytest

from fmu_compensator.fit.loops import loop_of

STEP_S, ROWS = 60.0, 600


def rises_of(count: int) -> list[np.ndarray]:
    draw = np.random.default_rng(3)
    return [np.cumsum(np.cumsum(draw.standard_normal(ROWS)) / 100.0) for _ in range(count)]


@pytest.mark.parametrize("lag", [-40, 0, 25])
def test_a_delayed_drift_has_that_lag_and_its_rate(lag):
    rises = rises_of(3)
    drifts = [2.5 * np.roll(rise, lag) for rise in rises]
    for one in drifts:  # what was rolled over the ends is as it was before or after
        one[:lag] = one[lag] if lag > 0 else one[:lag]
        one[lag:] = one[lag - 1] if lag < 0 else one[lag:]
    found = loop_of(rises, drifts, STEP_S)
    assert found.lag_min == lag
    assert not found.is_limit
    assert found.rate == pytest.approx(2.5)
    assert found.closed == pytest.approx(0.0, abs=1e-9)
    assert found.open == pytest.approx(found.closed) if lag == 0 else found.open > 0.1


def test_a_lag_longer_than_the_runs_allow_is_told_as_a_limit():
    time = np.arange(ROWS, dtype=float)
    found = loop_of([time**2], [np.maximum(time - 300.0, 0.0) ** 2], STEP_S)
    assert found.lag_min == 150.0
    assert found.is_limit
