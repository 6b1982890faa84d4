"""Offsets are slow and bounded."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from fmu_compensator.runtime.limits import Limits

LIMITS = Limits(30.0, 2.0, 10.0, 5.0, (0.0, 100.0))


@given(st.floats(-30.0, 30.0), st.floats(-30.0, 30.0), st.floats(0, 100))
def test_slewing_goes_towards_the_wanted_value_and_never_past(
    offset: float, wanted: float, step: float
) -> None:
    after = LIMITS.slewed(offset, wanted, step)
    assert abs(after - offset) <= 2.0 * step * (1 + 1e-12) + 1e-9
    assert min(offset, wanted) <= after <= max(offset, wanted)
