"""Offsets are slow and bounded."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fmu_compensator.runtime.limits import Limits

LIMITS = Limits(30.0, 2.0, 10.0, 5.0, (0.0, 100.0))
FINITE = st.floats(-1e6, 1e6)


@pytest.mark.parametrize(("wanted", "after"), [(10.0, 1.0), (-10.0, -1.0), (0.5, 0.5), (0.0, 0.0)])
def test_an_offset_moves_by_the_slew_limit_at_most(wanted: float, after: float) -> None:
    assert LIMITS.slewed(0.0, wanted, 0.5) == after


@given(FINITE, FINITE, st.floats(0, 100))
def test_slewing_goes_towards_the_wanted_value_and_never_past(
    offset: float, wanted: float, step: float
) -> None:
    after = LIMITS.slewed(offset, wanted, step)
    assert abs(after - offset) <= 2.0 * step * (1 + 1e-12) + 1e-9
    assert min(offset, wanted) <= after <= max(offset, wanted)


@given(st.floats(allow_nan=False))
def test_saturation(offset: float) -> None:
    found = LIMITS.saturated(offset)
    assert abs(found) <= 30.0
    assert found == offset or abs(found) == 30.0
