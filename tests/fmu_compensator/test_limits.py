"""Offsets are slow and bounded."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fmu_compensator.runtime.limits import Limits

LIMITS = Limits(30.0, 2.0, 10.0, 5.0, (0.0, 100.0))


@pytest.mark.parametrize("wanted", [float("nan"), float("inf"), float("-inf"), 1e300])
@pytest.mark.parametrize("step", [0.5, 1e6])
def test_nothing_wanted_moves_an_offset_past_its_limit(wanted, step):
    after = LIMITS.slewed(29.0, wanted, step)
    assert abs(after) <= 30.0
    if wanted != wanted:
        assert after == 29.0


@given(st.floats(-30.0, 30.0), st.floats(-30.0, 30.0), st.floats(0, 100))
def test_slewing_goes_towards_the_wanted_value_and_never_past(offset, wanted, step):
    after = LIMITS.slewed(offset, wanted, step)
    assert abs(after - offset) <= 2.0 * step * (1 + 1e-12) + 1e-9
    assert min(offset, wanted) <= after <= max(offset, wanted)
