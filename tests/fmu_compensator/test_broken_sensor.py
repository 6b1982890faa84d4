"""The shipped compensator on an unseen simulated run in which a thermometer breaks."""

from collections.abc import Iterator, Sequence

import numpy as np
import pytest

from benchmarks.broken_sensor import BREAKS_S, FAULTS, broken, jig_borer, judge, without_spare
from fmu_compensator.driving import inputs_of
from fmu_compensator.runtime.compensator import OK, SPARED, Output, RunningCompensator
from measurement.runs import Run


@pytest.mark.parametrize(("place", "fault"), list(zip((0, 6, 8), FAULTS, strict=True)))
def test_going_on_leaves_less_than_giving_up(place, fault):
    model, run, rig = jig_borer()
    late = run.time_s >= BREAKS_S
    faulty = broken(run, f"{model.sensors[place].name}_degC", fault)
    good = judge(model, run, run, rig, late)
    on = judge(model, faulty, run, rig, late)
    held = judge(without_spare(model), faulty, run, rig, late)
    assert on.spared.mean() > 0.9
    assert not held.spared.any()
    assert not good.spared.any()
    for axis in range(3):
        assert on.rmse(axis) < 0.5 * held.rmse(axis)
        assert on.rmse(axis) < good.rmse(axis) + 2.0
    within, usual = (np.mean(np.abs(one.error) <= one.half_width) for one in (on, good))
    assert within > usual - 0.1


def stepped(
    compensator: RunningCompensator,
    readings: Sequence[Sequence[float]],
    speeds: Sequence[float],
) -> Iterator[tuple[Output, float]]:
    """Yield each output and how far the offsets have moved, which the slew limits [um]."""
    offset = np.zeros(3)
    for row, (values, speed) in enumerate(zip(readings, speeds, strict=False)):
        output = compensator.step(30.0 * row, 30.0, values, speed, 100.0)
        moved = float(np.abs(output[:3] - offset).max())
        assert moved <= compensator.model.limits.slew_um_per_s * 30.0
        yield output, moved
        offset = np.array(output[:3])


def test_no_offset_steps_further_than_the_slew_when_sensors_break_and_return():
    model, run, _ = jig_borer()
    readings, speeds = inputs_of(model, run)
    readings = readings[:500].copy()
    readings[200:300, 0] = readings[260:275, 2] = np.nan
    readings[240:280, 6] += 30.0
    seen, texts = set(), set()
    steps = stepped(RunningCompensator(model), readings.tolist(), speeds.tolist())
    for row, (output, moved) in enumerate(steps):
        if seen >= {OK} and output.status in (OK, SPARED) and row < 260:
            assert moved < 1.0
        seen.add(output.status)
        texts.add(output.status_text)
    assert seen == {OK, SPARED}  # three were broken for a while
    names = [model.sensors[index].name for index in (0, 2, 6)]
    assert f"going on without a sensor: {names[0]} is missing" in texts
    assert f"going on without a sensor: {names[0]} is missing; and without {names[2]}" in texts
    both = f"{names[1]}, {names[2]}"
    assert f"going on without a sensor: {names[0]} is missing; and without {both}" in texts
    assert output.status == OK


def test_it_starts_without_a_sensor_and_takes_it_in_when_it_reads():
    model, run, rig = jig_borer()
    returns = 360  # after three hours
    column = f"{model.sensors[6].name}_degC"
    frame = run.frame.copy()
    frame.loc[: returns - 1, column] = float("nan")
    faulty, late = Run(run.name, frame), run.time_s >= BREAKS_S
    good, on = (judge(model, shown, run, rig, late) for shown in (run, faulty))
    for axis in range(3):
        assert on.rmse(axis) < good.rmse(axis) + 2.0
    compensator, told = RunningCompensator(model), []
    readings, speeds = inputs_of(model, faulty)
    steps = stepped(compensator, readings[: returns + 40].tolist(), speeds.tolist())
    for row, (output, moved) in enumerate(steps):
        told.append(output.status)
        assert row <= returns - 10 or moved < 3.0  # no step when it comes back
    columns = [f"{sensor.name}_degC" for sensor in model.sensors]
    blind = Run(run.name, run.frame.assign(**dict.fromkeys(columns, np.nan)))
    nothing = inputs_of(model, blind)[0][0].tolist()
    assert RunningCompensator(model).step(0.0, 30.0, nothing, 6000.0, 100.0).status == 1
    assert told[:2] == [1, SPARED]  # `recover_s` is waited
    assert set(told[1:returns]) == {SPARED}
    assert told[-1] == OK
    state = compensator.state()
    again = RunningCompensator(model)
    again.restore(state)
    assert again.state() == state
