"""The stepper that the FMU wraps: equal to the simulation, and continued exactly."""

import json

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from plant_model.axis import AxisOffset
from plant_model.machine import Axis
from plant_model.simulate import simulate
from plant_model.stepper import PlantStepper
from tests.plant_model.conftest import with_effects

HELD = {"speed": 9000.0, "ambient": 21.0, "coolant_inlet": 22.0, "torque": 0.0}


def at(speed: float, **more: float) -> dict[str, float]:
    return HELD | {"speed": speed, "tool_length": 150.0} | more


@pytest.mark.parametrize("extra", [(), ("viscosity_temperature",)])
def test_equals_the_simulation(jig_borer_lumps, extra):
    machine = with_effects(jig_borer_lumps, *extra)
    time = np.arange(0.0, 3601.0, 10.0)
    speeds = np.where(time < 1800.0, 9000.0, 3000.0)
    inputs = pd.DataFrame({"time_s": time, "speed_rpm": speeds, "T5_degC": 21.0, "T9_degC": 22.0})
    expected = simulate(machine, inputs, tolerance=1e-6)
    stepper = PlantStepper(machine)
    stepper.reset(at(9000.0))
    for speed in speeds[:-1]:
        stepper.step(10.0, at(float(speed)))
    outputs = stepper.outputs()
    for name, series in expected.readings.items():
        assert outputs[name] == pytest.approx(series[0, -1], abs=2e-4 if extra else 1e-9), name
    tip = expected.drift(150.0)[0, -1]
    assert [outputs[f"drift_{axis}"] for axis in "XYZ"] == pytest.approx(tip.tolist(), abs=2e-3)


def test_length_of_steps_does_not_matter(jig_borer_lumps):
    ends = []
    for lengths in ([600.0], [1.0] * 600, [0.5, 99.5, 500.0]):
        stepper = PlantStepper(jig_borer_lumps)
        stepper.reset(at(12000.0))
        for length in lengths:
            stepper.step(length, at(12000.0))
        ends.append(stepper.outputs()["drift_Z"])
    assert ends[1] == pytest.approx(ends[0], abs=1e-9)
    assert ends[2] == pytest.approx(ends[0], abs=1e-9)


@pytest.mark.parametrize("extra", [(), ("viscosity_temperature", "radiation")])
def test_a_restored_state_continues_to_the_last_bit(jig_borer_lumps, extra):
    machine = with_effects(jig_borer_lumps, *extra)
    first, second = (PlantStepper(machine, noise_seed=5) for _ in range(2))
    first.reset(at(6000.0))
    for k in range(40):
        # Almost as long as the steps below: what is kept for one must not serve the other.
        first.step(5.0 + 1e-10, at(6000.0, dX=float(k), dZ=-3.0))
    second.restore(json.loads(json.dumps(first.state())))
    assert second.outputs() == first.outputs()
    for stepper in (first, second):
        for k in range(40):
            stepper.step(5.0, at((9000.0, 6000.0)[k % 2], dX=2.0))
    assert first.outputs() == second.outputs()


def test_error_is_drift_plus_offset_in_force(jig_borer_lumps):
    stepper = PlantStepper(jig_borer_lumps)
    stepper.reset(at(12000.0))
    for _ in range(600):
        drift = stepper.outputs()
        stepper.step(1.0, at(12000.0, **{f"d{axis}": -drift[f"drift_{axis}"] for axis in "XYZ"}))
    after = stepper.outputs()
    for axis in "XYZ":
        assert after[f"error_{axis}"] == after[f"drift_{axis}"] + after[f"offset_{axis}"]
        assert abs(after[f"error_{axis}"]) < 0.2
    assert abs(after["drift_Z"]) > 5.0


@pytest.mark.parametrize(
    ("step", "change", "words"),
    [
        (0.0, {}, "above 0"),
        (1.0, {"speed": 1e6}, "speed"),
        (1.0, {"ambient": float("nan")}, "ambient"),
    ],
)
def test_steps_that_cannot_be_are_refused(step, change, words, jig_borer_lumps):
    stepper = PlantStepper(jig_borer_lumps)
    stepper.reset(at(0.0))
    before = stepper.state()
    with pytest.raises(ValueError, match=words):
        stepper.step(step, at(0.0) | change)
    assert stepper.state() == before


def test_axis_slews_saturates_and_rounds():
    axis = AxisOffset(Axis(slew_um_per_s=1.0, limit_um=5.0, resolution_um=0.1))
    assert axis.step(3.0, 1.0) == pytest.approx(1.0)
    assert axis.step(3.0, 10.0) == pytest.approx(3.0)
    assert axis.step(50.0, 10.0) == pytest.approx(5.0)
    assert axis.step(float("nan"), 1.0) == pytest.approx(5.0)
    assert axis.step(4.96, 1.0) == pytest.approx(5.0)
    assert axis.step(-1.23, 10.0) == pytest.approx(-1.2)


def test_axis_stops_at_the_last_increment_within_its_limit():
    axis = AxisOffset(Axis(slew_um_per_s=1.0, limit_um=5.0, resolution_um=0.3))
    assert axis.step(50.0, 10.0) == pytest.approx(4.8)


def test_axis_slower_than_its_increment_still_moves():
    axis = AxisOffset(Axis(slew_um_per_s=0.02, limit_um=5.0, resolution_um=0.1))
    seen = [axis.step(1.0, 1.0) for _ in range(51)]
    assert seen[3] == 0.0
    assert seen[-1] == pytest.approx(1.0)


@given(
    wanted=st.lists(st.floats(allow_nan=True, allow_infinity=True), min_size=1, max_size=30),
    step=st.floats(0.01, 100.0),
)
def test_axis_never_steps_and_never_leaves_its_limits(wanted, step):
    axis = AxisOffset(Axis(slew_um_per_s=2.0, limit_um=20.0, resolution_um=0.1))
    before = 0.0
    for value in wanted:
        after = axis.step(value, step)
        assert abs(after) <= 20.0 + 1e-9
        # One increment of travel may be carried over from the step before.
        assert abs(after - before) <= 2.0 * step + 0.1 + 1e-9
        before = after
