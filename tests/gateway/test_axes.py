"""An axis at the offset that is wanted: at the slew, through off and on, homing and restarts."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gateway.linuxcnc.axes import COUNT_UM, AxisOffset
from tests.gateway.control_axis import ControlAxis

SLEW = 10.0
STEP_S = 0.1
MOST = SLEW * STEP_S + 1e-9


def follow(offset: AxisOffset, axis: ControlAxis, wanted_um: float, steps: int) -> list[float]:
    """Go on for some steps; return where the axis was after each of them."""
    moved = []
    for _ in range(steps):
        offset.step(wanted_um, axis.seen(), STEP_S)
        axis.give(offset.counts)
        moved.append(axis.moved_um)
    return moved


def test_cleared_after_off_and_on_the_axis_is_where_it_would_be_without_offsets():
    offset, axis = AxisOffset(SLEW), ControlAxis()
    follow(offset, axis, 30.0, 40)
    axis.switch(on=False)
    follow(offset, axis, 30.0, 1)
    axis.switch(on=True)
    assert follow(offset, axis, 0.0, 40)[-1] == pytest.approx(0.0)
    assert not offset.at_zero  # the control holds an offset against what it has absorbed
    axis.go_to(5.0)
    assert follow(offset, axis, 0.0, 40)[-1] == pytest.approx(0.0)
    assert offset.at_zero


def test_a_control_that_looks_late_is_not_asked_twice():
    offset, axis = AxisOffset(SLEW), ControlAxis()
    for _ in range(5):
        offset.step(20.0, axis.seen(), STEP_S)
    axis.give(offset.counts)
    assert axis.moved_um == pytest.approx(1.0)
    assert follow(offset, axis, 20.0, 25)[-1] == pytest.approx(20.0)


def test_what_a_control_dropped_is_asked_again():
    offset, axis = AxisOffset(SLEW), ControlAxis()
    offset.step(20.0, axis.seen(), STEP_S)
    axis.counts = offset.counts
    assert follow(offset, axis, 20.0, 40)[-1] == pytest.approx(20.0)


@given(
    st.lists(
        st.one_of(
            st.floats(-60.0, 60.0).map(lambda wanted: ("want", wanted)),
            st.sampled_from([("off", 0.0), ("on", 0.0), ("unhomed", 0.0), ("homed", 0.0)]),
            st.integers(-30, 30).map(lambda place: ("go", float(place))),
        ),
        max_size=30,
    )
)
def test_no_step_is_larger_than_the_slew_whatever_happens(events):
    """Where it is not commanded to go elsewhere, and it comes to what is wanted when it may."""
    offset, axis, wanted = AxisOffset(SLEW), ControlAxis(), 0.0
    for event, value in [*events, ("homed", 0.0), ("on", 0.0), ("go", 77.0)]:
        if event == "want":
            wanted = value
        elif event in ("off", "on"):
            axis.switch(event == "on")
        elif event in ("unhomed", "homed"):
            axis.homed = event == "homed"
        elif axis.on:
            axis.go_to(value)
        before = axis.moved_um
        for moved in follow(offset, axis, wanted, 3):
            assert abs(moved - before) <= MOST + COUNT_UM
            before = moved
    assert follow(offset, axis, wanted, 130)[-1] == pytest.approx(wanted, abs=COUNT_UM)
