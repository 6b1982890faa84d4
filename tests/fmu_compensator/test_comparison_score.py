"""What `compare` ranks by."""

import numpy as np
import pytest

from fmu_compensator.fit.comparison import Judged, Row


def row(left: list[float]) -> Row:
    """Return a row that leaves so much of a drift of 2, 30 um and 40 urad."""
    drift = np.array([[2.0, 30.0, 40.0]])
    judged = Judged("run", np.zeros(1), drift, drift - np.array([left]))
    return Row("model", "A model", False, validate=[judged])


def test_a_target_that_hardly_moves_does_not_decide():
    better_in_large = row([2.0, 3.0, 4.0])
    better_in_small = row([0.2, 9.0, 4.0])
    units = ["um", "um", "urad"]
    assert better_in_large.score(units) < better_in_small.score(units)


def test_each_unit_counts_the_same():
    assert row([0.0, 0.0, 40.0]).score(["um", "um", "urad"]) == pytest.approx(0.5)
    assert np.isnan(row([0.0, 0.0, 0.0]).score([]))
