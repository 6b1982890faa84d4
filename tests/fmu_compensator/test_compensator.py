"""The compensator's step: offsets, faults, states."""

from __future__ import annotations

import json
from collections.abc import Callable
from math import exp, inf, nan
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fmu_compensator.runtime.compensator import Output, RunningCompensator
from fmu_compensator.runtime.modelfile import Model, parse_model
from tests.fmu_compensator.guarded import guarded
from tests.native.made import made_model

AsModel = Callable[[dict[str, Any]], Model]
ROOM = [20.0, 20.0, 20.0, 20.0]


class Bench:
    """Steps a compensator in 1 s steps."""

    def __init__(self, model: Model) -> None:
        self.compensator = RunningCompensator(model)
        self.time = 0.0

    def step(
        self,
        temperatures: list[float] | None = None,
        tool: float = 100.0,
        count: int = 1,
        measured: list[float] | None = None,
    ) -> Output:
        for _ in range(count):
            output = self.compensator.step(
                self.time, 1.0, temperatures or self.readings(), 1000.0, tool, measured
            )
            self.time += 1.0
        return output

    def readings(self) -> list[float]:
        """Return readings near room temperature that never stand still."""
        wiggle = 0.01 * (self.time % 2)
        return [20.0 + wiggle, 21.0, 22.0, 20.0 - wiggle]


def warm(rise_1: float, rise_4: float) -> list[float]:
    return [20.0 + rise_1, 20.0, 20.0, 20.0 + rise_4]


def quick(table: dict[str, Any]) -> dict[str, Any]:
    """Return the table with a slew that never limits."""
    table["limits"]["slew_um_per_s"] = 1000.0
    return table


def free(table: dict[str, Any]) -> dict[str, Any]:
    """Return the table guarded without lags; no jump and no single reading is too much."""
    for sensor in table["sensors"]:
        sensor |= {"noise": 50.0, "trained_low": -50.0, "trained_high": 50.0}
    return guarded(quick(table), lags_s=())


def test_offsets_are_the_opposite_of_the_predicted_drift(
    five_point_table: dict[str, Any], as_model: AsModel
) -> None:
    for sensor in five_point_table["sensors"]:
        sensor["noise"] = 50.0
    bench = Bench(as_model(quick(five_point_table)))
    first = bench.step(ROOM)
    assert (first.dX, first.dY, first.dZ, first.status, first.valid) == (0.0, 0.0, 0.0, 0, True)
    output = bench.step(warm(2.0, 4.0), tool=130.0)
    # chosen is T4, T1: E = 2*4 + 1*2, yaw = 5*4, pitch = -4*2, near 0.5*4 and 0.25*2
    assert (output.elongation, output.yaw, output.pitch) == (10.0, 20.0, -8.0)
    assert output.dX == pytest.approx(-(2.0 + 0.1e6 * 20e-6), abs=1e-6)
    assert output.dY == pytest.approx(-(0.5 - 0.1e6 * 8e-6), abs=1e-6)
    assert output.dZ == pytest.approx(10.0, abs=1e-4)
    assert output.valid
    shorter = bench.step(warm(2.0, 4.0), tool=30.0)
    assert (shorter.dX, shorter.dY) == (-2.0, -0.5)


def test_the_rise_form_ignores_the_level_of_a_sensor(
    five_point_table: dict[str, Any], as_model: AsModel
) -> None:
    plain, shifted = Bench(as_model(five_point_table)), Bench(as_model(five_point_table))
    for rise in range(20):
        plain_out = plain.step([20 + 0.1 * rise, 0.0, 0.0, 20 + 0.2 * rise])
        shifted_out = shifted.step([20 + 0.1 * rise, 0.0, 0.0, 51 + 0.2 * rise])
        assert plain_out[:6] == pytest.approx(shifted_out[:6], abs=1e-9)
    assert plain_out.dZ > 5.0


def test_the_absolute_form_takes_readings_as_they_are(
    five_point_table: dict[str, Any], as_model: AsModel
) -> None:
    table = quick(five_point_table) | {"input_form": "absolute"}
    table["error_model"]["intercept"][0] = -50.0
    output = Bench(as_model(table)).step(ROOM)
    assert output.elongation == -50.0 + 3 * 20.0


def test_a_direct_geometry_needs_no_tool_length(
    direct_table: dict[str, Any], as_model: AsModel
) -> None:
    for sensor in direct_table["sensors"]:
        sensor["noise"] = 50.0
    bench = Bench(as_model(quick(direct_table)))
    bench.step(ROOM, tool=nan)
    output = bench.step(warm(2.0, 4.0), tool=nan)
    assert (output.dX, output.dY, output.dZ) == (-4.0, 0.0, 6.0)
    assert (output.elongation, output.yaw, output.status) == (6.0, 0.0, 0)


def test_the_half_width_is_that_of_the_time_and_the_tool(
    five_point_table: dict[str, Any], as_model: AsModel
) -> None:
    bench = Bench(as_model(five_point_table))
    assert bench.step([nan] * 4)[6:9] == (-1.0, -1.0, -1.0)
    first = bench.step(tool=0.0)
    assert first[6:9] == pytest.approx((0.5, 1.0, 1.5))
    bench.step(count=3599)
    hour = bench.step(tool=100.0)
    assert hour[6:9] == pytest.approx([scale * 1.25**0.5 for scale in (1.5, 4.0, 3.0)])
    # In a fault the last good one stays, and the time goes on.
    bench.time += 1800.0
    assert bench.step([nan] * 4)[6:9] == hour[6:9]
    bench.time += 7200.0
    late = bench.step(tool=200.0)
    assert late[6:9] == pytest.approx([scale * 2.25**0.5 for scale in (2.0, 6.0, 3.0)])


def test_a_half_width_that_is_not_known_is_minus_one(
    five_point_table: dict[str, Any], direct_table: dict[str, Any], as_model: AsModel
) -> None:
    assert Bench(as_model(five_point_table | {"interval": None})).step()[6:9] == (-1.0, -1.0, -1.0)
    # A direct rig without Y; the tool does not matter.
    assert Bench(as_model(direct_table)).step(tool=nan)[6:9] == (0.5, -1.0, 1.0)


def test_a_prediction_stays_on_its_leash(
    five_point_table: dict[str, Any], as_model: AsModel
) -> None:
    bench = Bench(as_model(free(five_point_table)))
    bench.step(ROOM)
    output = bench.step(warm(4.0, 4.0), tool=130.0)
    # The error model says 12, 20, -16, 2 and 1; the careful one 4 + 0.5 * 4 = 6, give or take 4.
    assert (output.elongation, output.yaw, output.pitch) == (10.0, 10.0, 2.0)
    assert output.dX == pytest.approx(-(2.0 + 0.1e6 * 10e-6), abs=1e-6)
    assert output.dY == pytest.approx(-(2.0 + 0.1e6 * 2e-6), abs=1e-6)
    assert (output.status, output.valid) == (0, True)


def test_what_is_new_only_together_fades_and_is_named(
    five_point_table: dict[str, Any], as_model: AsModel
) -> None:
    table = free(five_point_table) | {"correction": None}
    all_known = table | {"guard": table["guard"] | {"known": 1e6}}
    bench, other = Bench(as_model(table)), Bench(as_model(all_known))
    for one in (bench, other):
        one.step(ROOM)
    output, whole = (one.step(warm(0.0, 4.0), tool=100.0) for one in (bench, other))
    beyond = 0.5 * 16.0 - 0.495 / 2.0 * 16.0 - 0.5
    # Z is between 0.5 and 1.5 at half of the longest tool; for Y the file gives no fade.
    assert output.dX == pytest.approx(whole.dX / (1.0 + beyond))
    assert output.dY == whole.dY
    assert output.dZ == pytest.approx(whole.dZ / (1.0 + beyond))
    assert output[3:6] == whole[3:6]
    assert (output.status, output.valid, output.status_sensor) == (2, True, 4)
    told = "temperatures together are outside training, novelty 8.1 times the largest known: T4"
    assert output.status_text == told
    assert (whole.status, whole.status_text) == (0, "offsets follow the model")
    apart = bench.step(warm(-3.0, 3.0))
    assert apart.status_text.endswith("novelty 18.0 times the largest known: T4, T1")
    worst = bench.step(warm(-4.0, 3.0))
    assert worst.status_text.endswith(": T1, T4")
    assert worst.status_sensor == 1
    assert bench.step(warm(4.0, 4.0)).status == 0
    # In a fault nobody speaks of training.
    assert bench.step([nan] * 4).status == 11


def test_a_single_reading_outside_training_is_named_first(
    five_point_table: dict[str, Any], as_model: AsModel
) -> None:
    table = free(five_point_table)
    table["sensors"][3]["trained_high"] = 3.0
    bench = Bench(as_model(table))
    bench.step(ROOM)
    output = bench.step(warm(0.0, 4.0))
    assert output.status == 2
    assert output.status_text.startswith("T4 4.0 K rise is outside")


def test_where_nothing_is_known_the_text_has_an_end(
    five_point_table: dict[str, Any], as_model: AsModel
) -> None:
    table = free(five_point_table)
    table["guard"]["known"] = 0.0
    bench = Bench(as_model(table))
    assert bench.step(ROOM).status == 0
    assert "novelty 1000000.0 times the largest known: T1" in bench.step(warm(0.01, 0)).status_text


def test_the_half_width_grows_with_novelty(
    five_point_table: dict[str, Any], as_model: AsModel
) -> None:
    bench = Bench(as_model(free(five_point_table)))
    first = bench.step(ROOM)
    assert first[6:9] == pytest.approx([0.5 * scale for scale in (1.5, 4.0, 3.0)])
    novel = bench.step(warm(0.0, 4.0))
    grown = (0.25 + 1.0 / 3600.0) ** 0.5 * (1.0 + 3.0 * (0.5 - 0.495 / 2.0) * 16.0) ** 0.5
    # What was given up of the offsets is added: the interval is about what is sent.
    pose = bench.compensator.model.geometry.drift(bench.compensator._prediction._predicted, 100.0)
    given_up = [abs(abs(drift) - abs(sent)) for drift, sent in zip(pose, novel[:3], strict=True)]
    assert max(given_up) > 1.0
    widths = [grown * scale for scale in (1.5, 4.0, 3.0)]
    assert novel[6:9] == pytest.approx(
        [width + more for width, more in zip(widths, given_up, strict=True)]
    )


def test_what_is_not_known_falls_back_to_what_was_measured_last(
    five_point_table: dict[str, Any], as_model: AsModel
) -> None:
    bench = Bench(as_model(free(five_point_table)))
    bench.step(ROOM)
    bench.step(warm(0.0, 4.0), measured=[13.0, 10.0, -1.0, 2.0, 2.0])
    bench.step(warm(0.0, 4.0))
    bench.time += 1e6  # by now the measurement says nothing of the model's error
    compensator = bench.compensator
    bench.step(warm(0.0, 12.0))
    drift = compensator.model.geometry.drift
    held = drift(compensator._prediction._correction.held, 100.0)
    predicted = drift(compensator._prediction._predicted, 100.0)
    share = compensator.model.limits.tool_share(100.0)
    for axis, (wanted, last, model) in enumerate(
        zip(compensator._prediction.wanted, held, predicted, strict=True)
    ):
        part = compensator._prediction.guard.faded(
            axis, compensator._prediction.novelty, share, 1.0
        )
        assert -wanted == pytest.approx(last + part * (model - last), rel=1e-6)
        assert abs(last) > 1.0
    assert compensator._prediction.guard.faded(0, compensator._prediction.novelty, share, 1.0) < 0.3


def test_a_measurement_moves_the_prediction_and_removes_doubt(
    five_point_table: dict[str, Any], as_model: AsModel
) -> None:
    bench = Bench(as_model(free(five_point_table)))
    # What was measured before anything was predicted says nothing about the prediction.
    assert bench.step([nan] * 4, measured=[50.0] * 5).status == 1
    bench.step(ROOM)
    before = bench.step(warm(4.0, 4.0), measured=[13.0, 10.0, -1.0, 2.0, nan])
    before = bench.step(warm(4.0, 4.0), measured=[13.0, 10.0, -1.0, 2.0, 2.0])
    assert (before.elongation, before.yaw, before.pitch) == (10.0, 10.0, 2.0)
    after = bench.step(warm(4.0, 4.0))
    growth = before.dX_uncertainty / 1.5
    variance, kept = (2.0 * growth) ** 2, exp(-1.0 / 3600.0)
    gain = variance / (variance + 0.25)
    moved = (after.elongation - 10.0, after.yaw - 10.0, after.pitch - 2.0)
    assert moved == pytest.approx((3.0 * gain * kept, 0.0, -3.0 * gain * kept))
    doubt = 1.0 - gain * kept**2
    ratio = [new / old for new, old in zip(after[6:9], before[6:9], strict=True)]
    assert ratio == pytest.approx([doubt**0.5] * 3, rel=1e-3)
    bench.time += 1e6
    forgotten = bench.step(warm(4.0, 4.0))
    assert forgotten.elongation == pytest.approx(10.0)


def test_what_was_measured_is_no_longer_faded(
    five_point_table: dict[str, Any], as_model: AsModel
) -> None:
    bench = Bench(as_model(free(five_point_table)))
    bench.step(ROOM)
    novel = bench.step(warm(0.0, 4.0))
    pose = novel[3:6]
    for _ in range(20):  # each says that the prediction is right
        last = bench.step(warm(0.0, 4.0), measured=[8.0, 8.0, 0.0, 2.0, 0.0])
    assert last[3:6] == pytest.approx(pose, abs=1e-6)
    assert abs(novel.dZ) < 0.25 * pose[0] < 0.75 * pose[0] < abs(last.dZ) < pose[0]


@pytest.mark.parametrize(
    ("kind", "itself"),
    [("arma", True), ("arx", True), ("bayes", False), ("ridge", False), ("thermal_states", False)],
)
def test_an_error_model_that_only_adds_a_bias_leaves_that_to_the_correction(
    kind: str, itself: bool
) -> None:
    with_correction = made_model(kind, 0)
    alone = parse_model(json.dumps(with_correction.table | {"correction": None}), "alone")
    for model, takes in ((with_correction, itself), (alone, True)):
        states = []
        for measured in (None, [5.0] * len(model.targets)):
            compensator = RunningCompensator(model)
            for second in range(20):
                readings = [20.0 + 0.01 * second] * len(model.sensors)
                compensator.step(60.0 * second, 60.0, readings, 0.0, 100.0, measured)
            states.append(compensator.state()["error_model"])
        assert (states[0] != states[1]) == takes


def test_it_waits_for_the_first_complete_sample(
    five_point_table: dict[str, Any], as_model: AsModel
) -> None:
    bench = Bench(as_model(five_point_table))
    output = bench.step([20.0, nan, nan, nan])
    assert (output.status, output.valid, output.status_sensor) == (1, False, 4)
    assert output.status_text == "waiting for the first valid sample: T4 is missing"
    # T1's reference is its own first reading; missing sensors that are not chosen do not matter.
    assert bench.step([20.4, nan, nan, 20.0]).status == 0
    assert bench.step([20.4, nan, nan, 20.0]).elongation == pytest.approx(0.4)


def fault_story(bench: Bench, bad: list[float], cause: int, tool: float = 100.0) -> None:
    """Hold 20 s, ramp, zero, recover 5 s, slew back, valid: with limits of the small file."""
    held = bench.step()
    assert (held.status, held.valid) == (0, True)
    assert held.dZ == pytest.approx(10.0, abs=0.2)
    output = bench.step(bad, tool)
    assert (output.status, output.valid) == (10 + cause, False)
    for _ in range(19):
        output = bench.step(bad, tool)
        assert output.status == 10 + cause
        assert output[:3] == held[:3]
    output = bench.step(bad, tool)
    assert output.status == 20 + cause
    assert output.dZ == pytest.approx(held.dZ - 1.0)
    output = bench.step(bad, tool, count=30)
    assert (output.status, *output[:3]) == (30 + cause, 0.0, 0.0, 0.0)


def warmed_bench(table: dict[str, Any], as_model: AsModel) -> Bench:
    bench = Bench(as_model(table))
    bench.step([20.0, 21.0, 22.0, 15.0])
    for rise in range(11):
        bench.step([20.0, 21.0, 22.0, 15.0 + 0.5 * rise])
    bench.step(count=30)
    return bench


@pytest.mark.parametrize(
    ("bad", "cause", "text"),
    [
        ([20.0, 0.0, 0.0, nan], 1, "T4 is missing"),
        ([20.0, 0.0, 0.0, 99.0], 2, "T4 99.0 degC is above 80 degC"),
        ([20.0, 0.0, 0.0, 70.0], 3, "T4 70.0 degC jumped by"),
    ],
)
def test_a_fault_holds_then_ramps_to_zero(
    five_point_table: dict[str, Any], as_model: AsModel, bad: list[float], cause: int, text: str
) -> None:
    bench = warmed_bench(five_point_table, as_model)
    fault_story(bench, bad, cause)
    output = bench.step(bad)
    assert output.status_sensor == 4
    assert output.status_text.startswith("offsets are zero: " + text)


def test_recovery_waits_then_slews_and_keeps_the_reference(
    five_point_table: dict[str, Any], as_model: AsModel
) -> None:
    bench = warmed_bench(five_point_table, as_model)
    fault_story(bench, [20.0, 0.0, 0.0, nan], 1)
    waiting = [bench.step() for _ in range(4)]
    assert {output.status for output in waiting} == {31}
    assert {output.dZ for output in waiting} == {0.0}
    moving = [bench.step() for _ in range(9)]
    assert {(output.status, output.valid) for output in moving} == {(3, False)}
    assert moving[-1].dZ == pytest.approx(9.0)
    output = bench.step(count=2)
    assert (output.status, output.valid) == (0, True)
    assert output.dZ == pytest.approx(10.0, abs=0.2)


def test_a_flicker_does_not_start_a_new_hold(
    five_point_table: dict[str, Any], as_model: AsModel
) -> None:
    bench = warmed_bench(five_point_table, as_model)
    bad = [20.0, 0.0, 0.0, nan]
    seen = []
    for _ in range(15):
        seen += [bench.step(bad).status, bench.step().status]
    assert seen == [11] * 20 + [21] * 9 + [31]


def test_a_stale_sensor_is_found_though_others_move(
    five_point_table: dict[str, Any], as_model: AsModel
) -> None:
    bench = warmed_bench(five_point_table, as_model)
    for _ in range(602):
        output = bench.step([bench.readings()[0], 1.0, 2.0, 20.0])
    assert (output.status, output.status_sensor) == (14, 4)
    assert "T4 20.0 degC is unchanged for 601 s, 600 s allowed" in output.status_text


@pytest.mark.parametrize(
    ("tool", "cause", "text"),
    [(nan, 1, "tool_length is missing"), (250.0, 2, "tool_length 250 mm is not in 0 to 200 mm")],
)
def test_a_bad_tool_length_is_a_fault(
    five_point_table: dict[str, Any], as_model: AsModel, tool: float, cause: int, text: str
) -> None:
    bench = warmed_bench(five_point_table, as_model)
    output = bench.step(tool=tool)
    assert (output.status, output.status_sensor) == (10 + cause, 0)
    assert output.status_text == "holding the last good offsets: " + text


def test_outside_training_is_valid_and_said(
    five_point_table: dict[str, Any], as_model: AsModel
) -> None:
    five_point_table["sensors"][3]["trained_high"] = 3.0
    bench = warmed_bench(five_point_table, as_model)
    output = bench.step()
    assert (output.status, output.valid, output.status_sensor) == (2, True, 4)
    assert output.status_text.endswith("K rise is outside the -1.0 to 3.0 seen in training")
    assert output.status_text.startswith("T4 ")


def test_offsets_saturate(five_point_table: dict[str, Any], as_model: AsModel) -> None:
    for sensor in five_point_table["sensors"]:
        sensor["noise"] = 50.0
    bench = Bench(as_model(five_point_table))
    bench.step(ROOM)
    assert bench.step(warm(0.0, 25.0), count=100).dZ == 30.0
    assert bench.step(warm(0.0, -15.0), count=100).dZ == -30.0


READING = st.floats() | st.floats(19.0, 23.0) | st.sampled_from([nan, inf, -inf, 1e308])
TIMING = st.floats() | st.floats(0.0, 10.0) | st.sampled_from([0.0, -1.0, nan, inf, 1.0])
PROBE = st.floats() | st.floats(-50.0, 50.0)
MEASURED = st.none() | st.tuples(PROBE, PROBE, PROBE, PROBE, PROBE)
READINGS = st.tuples(READING, READING, READING, READING)
SAMPLE = st.tuples(TIMING, TIMING, READINGS, READING, READING, MEASURED)
ONCE = settings(
    max_examples=200, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


@ONCE
@given(st.lists(SAMPLE, max_size=40), st.booleans())
def test_offsets_never_step_and_never_exceed_the_limit(
    five_point_table: dict[str, Any], as_model: AsModel, samples: list[Any], guard: bool
) -> None:
    five_point_table["limits"] |= {"hold_s": 3.0, "recover_s": 1.0, "offset_um": 4.0}
    table = guarded(five_point_table) if guard else five_point_table
    compensator = RunningCompensator(as_model(table))
    widest = 3000.0 if guard else 10.0  # novelty is that of 80 K at most
    before = (0.0, 0.0, 0.0)
    for time, step, temperatures, speed, tool, measured in samples:
        output = compensator.step(time, step, temperatures, speed, tool, measured)
        allowed = step if 0.0 < step < inf else 0.0
        for old, new in zip(before, output[:3], strict=True):
            assert abs(new) <= 4.0
            assert abs(new - old) <= allowed * 1.0 + 1e-9
        assert output.valid == (output.status in {0, 2})
        assert output.status in {0, 1, 2, 3, *range(11, 15), *range(21, 25), *range(31, 35)}
        assert all(abs(value) < inf for value in output[3:6])
        assert all(value == -1.0 or 0.0 < value < widest for value in output[6:9])
        assert "\n" not in output.status_text
        before = output[:3]


@ONCE
@given(st.lists(SAMPLE, max_size=30), st.integers(0, 30), st.booleans())
def test_a_restored_state_continues_bit_for_bit(
    five_point_table: dict[str, Any],
    as_model: AsModel,
    samples: list[Any],
    split: int,
    guard: bool,
) -> None:
    five_point_table["limits"] |= {"hold_s": 3.0, "recover_s": 1.0}
    model = as_model(guarded(five_point_table) if guard else five_point_table)
    whole, first, second = (
        RunningCompensator(model),
        RunningCompensator(model),
        RunningCompensator(model),
    )
    expected = [whole.step(*sample) for sample in samples]
    found = [first.step(*sample) for sample in samples[:split]]
    for _ in range(2):  # a past of its own, to be overwritten
        second.step(0.0, 1.0, [50.0] * 4, 0.0, 10.0, [9.0] * 5)
    second.restore(json.loads(json.dumps(first.state(), allow_nan=False)))
    found += [second.step(*sample) for sample in samples[split:]]
    assert [repr(output) for output in found] == [repr(output) for output in expected]


def test_reset_starts_over(five_point_table: dict[str, Any], as_model: AsModel) -> None:
    for table in (five_point_table, guarded(five_point_table)):
        bench = warmed_bench(table, as_model)
        bench.step(measured=[1.0] * 5)
        bench.step(measured=[1.0] * 5)
        bench.compensator.reset()
        assert bench.compensator.state() == RunningCompensator(bench.compensator.model).state()


def test_a_foreign_state_is_refused(five_point_table: dict[str, Any], as_model: AsModel) -> None:
    plain = RunningCompensator(as_model(five_point_table))
    careful = RunningCompensator(as_model(guarded(five_point_table)))
    for compensator, other in ((plain, careful), (careful, plain)):
        state, foreign = compensator.state(), other.state()
        strange = [{name: foreign[name]} for name in ("guard", "correction")]
        for damage in ({"format": 1}, {"format": 3}, {"reference": [1.0]}, *strange):
            with pytest.raises(ValueError, match="state"):
                compensator.restore(state | damage)
        for name in ({*state} - {"guard"}, ()):
            with pytest.raises(ValueError, match="state"):
                compensator.restore({key: state[key] for key in name})


def test_the_number_of_temperatures_must_be_the_files(
    five_point_table: dict[str, Any], as_model: AsModel
) -> None:
    with pytest.raises(ValueError, match="3 temperatures were given, the file has 4"):
        RunningCompensator(as_model(five_point_table)).step(0.0, 1.0, [20.0] * 3)


def test_two_compensators_of_one_file_share_nothing(
    five_point_table: dict[str, Any], as_model: AsModel
) -> None:
    model = as_model(five_point_table)
    one, other = RunningCompensator(model), RunningCompensator(model)
    untouched = json.dumps(other.state())
    one.step(0.0, 1.0, ROOM, 0.0, 100.0)
    assert json.dumps(other.state()) == untouched
