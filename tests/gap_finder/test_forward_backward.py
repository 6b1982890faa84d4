"""What one hypothesis must win against another."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gap_finder.forward_backward import LAW, MARGIN, Hypothesis, unit_of, units_of


def hypothesis(left: Any, calibrated: float = 0.0, prior: float = 0.0) -> Hypothesis:
    """Return one with what it leaves (R, C), the cost of its calibration, and what it costs."""
    calibration = SimpleNamespace(cost=calibrated)
    fit: Any = SimpleNamespace(left=np.asarray(left), moved_cost=0.0, calibration=calibration)
    return Hypothesis((), (prior,), fit)


def test_what_is_missing_in_one_channel_hides_nothing_in_another():
    nothing = hypothesis([[400.0, 12.0], [600.0, 8.0]])
    first = hypothesis([[2.0, 11.0], [2.0, 9.0]])
    second = hypothesis([[2.0, 1.0], [2.0, 1.0]])
    units = units_of(nothing, [first, second])
    np.testing.assert_allclose(units, [LAW * 500.0, 1.0])
    assert first.score(units) - second.score(units) == pytest.approx(18.0)
    # The unknowns count as the channels do in the mean: here half as much, for one says nearly all.
    assert unit_of(units) == pytest.approx(2.0 / (1.0 + 1.0 / 25.0))


@pytest.mark.parametrize(("won", "better"), [(0.3, False), (MARGIN - 0.1, False), (6.1, True)])
def test_what_fits_better_does_so_by_the_margin_and_what_its_prior_costs(won, better):
    before = hypothesis([[1.0]], calibrated=100.0)
    after = hypothesis([[0.1]], calibrated=100.0 - 15.9 - won, prior=15.9)
    assert after.fits_better(before) is better
