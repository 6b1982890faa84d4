"""The compensator's step: waiting, faults, limits, states."""

import json
from math import inf, nan
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fmu_compensator.runtime.compensator import RunningCompensator
from fmu_compensator.runtime.error_models import error_models
from tests.fmu_compensator.bench import ROOM, AsModel, Bench
from tests.fmu_compensator.gaussians import learnt
from tests.native.made import made_model


def test_it_waits_for_the_first_complete_sample(five_point_table, as_model):
    bench = Bench(as_model(five_point_table))
    output = bench.step([20.0, nan, nan, nan])
    assert (output.status, output.valid, output.status_sensor) == (1, False, 4)
    assert output.status_text == "waiting for the first valid sample: T4 is missing"
    # T1's reference is its own first reading; missing sensors that are not chosen do not matter.
    assert bench.step([20.4, nan, nan, 20.0]).status == 0
    assert bench.step([20.4, nan, nan, 20.0]).elongation == pytest.approx(0.4)


def test_waiting_for_the_first_complete_sample_makes_nothing_less_certain(
    five_point_table, as_model
):
    at_once, later = (Bench(as_model(learnt(five_point_table))) for _ in range(2))
    later.step([20.0, nan, nan, nan], count=600)
    later.time += 4 * 3600.0  # without any sample
    for rise in (0.0, 2.0, 3.0):
        expected, found = (one.step([20.0, nan, nan, 20.0 + rise]) for one in (at_once, later))
        assert found[:9] == pytest.approx(expected[:9], abs=1e-9)


@pytest.mark.parametrize("kind", sorted(error_models()))
def test_time_counts_from_the_first_sample_however_long_its_step(kind):
    model = made_model(kind, 0)
    cold, warm = ([20.0 + rise] * len(model.sensors) for rise in (0.0, 2.0))
    tool = model.limits.tool_length_mm[0]
    quick, slow = (RunningCompensator(model) for _ in range(2))
    for time_s, readings in ((0.0, cold), (600.0, warm), (1200.0, warm)):
        expected, found = (
            one.step(time_s, step_s, readings, 3000.0, tool)
            for one, step_s in ((quick, 1.0), (slow, 600.0))
        )
        assert found[3:9] == expected[3:9]
    assert max(found[6:9]) > 0.0, "or nothing is predicted"


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
        ([20.0, 0.0, 0.0, 70.0], 3, "T4 70.0 degC jumped by 50.0 K, 1 K allowed"),
    ],
)
def test_a_fault_holds_then_ramps_to_zero(five_point_table, as_model, bad, cause, text):
    bench = warmed_bench(five_point_table, as_model)
    fault_story(bench, bad, cause)
    output = bench.step(bad)
    assert output.status_sensor == 4
    assert output.status_text == "offsets are zero: " + text


def test_recovery_waits_then_slews_and_keeps_the_reference(five_point_table, as_model):
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


def test_a_flicker_does_not_start_a_new_hold(five_point_table, as_model):
    bench = warmed_bench(five_point_table, as_model)
    bad = [20.0, 0.0, 0.0, nan]
    seen = []
    for _ in range(15):
        seen += [bench.step(bad).status, bench.step().status]
    assert seen == [11] * 20 + [21] * 9 + [31]


def test_a_stale_sensor_is_found_though_others_move(five_point_table, as_model):
    bench = warmed_bench(five_point_table, as_model)
    for _ in range(602):
        output = bench.step([bench.readings()[0], 1.0, 2.0, 20.0])
    assert (output.status, output.status_sensor) == (14, 4)
    assert "T4 20.0 degC is unchanged for 601 s, 600 s allowed" in output.status_text


@pytest.mark.parametrize(
    ("tool", "cause", "text"),
    [(nan, 1, "tool_length is missing"), (250.0, 2, "tool_length 250 mm is not in 0 to 200 mm")],
)
def test_a_bad_tool_length_is_a_fault(five_point_table, as_model, tool, cause, text):
    bench = warmed_bench(five_point_table, as_model)
    output = bench.step(tool=tool)
    assert (output.status, output.status_sensor) == (10 + cause, 0)
    assert output.status_text == "holding the last good offsets: " + text


READING = st.floats() | st.floats(19.0, 23.0) | st.sampled_from([nan, inf, -inf, 1e308])
TIMING = st.floats() | st.floats(0.0, 10.0) | st.sampled_from([0.0, -1.0, nan, inf, 1.0])
PROBE = st.floats() | st.floats(-50.0, 50.0)
MEASURED = st.none() | st.tuples(PROBE, PROBE, PROBE, PROBE, PROBE)
READINGS = st.tuples(READING, READING, READING, READING)
SAMPLE = st.tuples(TIMING, TIMING, READINGS, READING, READING, MEASURED)


@given(st.lists(SAMPLE, max_size=40), st.booleans())
def test_offsets_never_step_and_never_exceed_the_limit(five_point_table, as_model, samples, knows):
    five_point_table["limits"] |= {"hold_s": 3.0, "recover_s": 1.0, "offset_um": 4.0}
    table = learnt(five_point_table) if knows else five_point_table
    compensator = RunningCompensator(as_model(table))
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
        assert all(value == -1.0 or 0.0 < value < inf for value in output[6:9])
        assert "\n" not in output.status_text
        before = output[:3]


@given(st.lists(SAMPLE, max_size=30), st.integers(0, 30), st.booleans())
def test_a_restored_state_continues_bit_for_bit(five_point_table, as_model, samples, split, knows):
    five_point_table["limits"] |= {"hold_s": 3.0, "recover_s": 1.0}
    model = as_model(learnt(five_point_table) if knows else five_point_table)
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


def test_reset_starts_over(five_point_table, as_model):
    for table in (five_point_table, learnt(five_point_table)):
        bench = warmed_bench(table, as_model)
        bench.step(measured=[1.0] * 5)
        bench.step(measured=[1.0] * 5)
        bench.compensator.reset()
        assert bench.compensator.state() == RunningCompensator(bench.compensator.model).state()


def test_a_foreign_state_is_refused(five_point_table, as_model):
    plain = RunningCompensator(as_model(five_point_table))
    knowing = RunningCompensator(as_model(learnt(five_point_table)))
    for compensator, other in ((plain, knowing), (knowing, plain)):
        state, foreign = compensator.state(), other.state()
        gaussian = {"gaussian": foreign["gaussian"]}
        for damage in ({"format": 1}, {"format": 5}, {"reference": [1.0]}, gaussian):
            with pytest.raises(ValueError, match="state"):
                compensator.restore(state | damage)
        for name in ({*state} - {"gaussian"}, ()):
            with pytest.raises(ValueError, match="state"):
                compensator.restore({key: state[key] for key in name})


def test_the_number_of_temperatures_must_be_the_files(five_point_table, as_model):
    with pytest.raises(ValueError, match="3 temperatures were given, the file has 4"):
        RunningCompensator(as_model(five_point_table)).step(0.0, 1.0, [20.0] * 3)


def test_two_compensators_of_one_file_share_nothing(five_point_table, as_model):
    model = as_model(five_point_table)
    one, other = RunningCompensator(model), RunningCompensator(model)
    untouched = json.dumps(other.state())
    one.step(0.0, 1.0, ROOM, 0.0, 100.0)
    assert json.dumps(other.state()) == untouched
