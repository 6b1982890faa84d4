"""Which readings are trusted."""

from math import inf, nan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fmu_compensator.runtime.checks import (
    ALIVE_AFTER,
    IMPLAUSIBLE,
    MISSING,
    SPAN_S,
    STALE,
    TOO_FAST,
    Sensor,
    SensorCheck,
)
from measurement.resampling import SLOW_S

SENSOR = Sensor("T4", 0.0, 80.0, 0.01, 0.5, 600.0, 0.0, 1.0)


def check_of(**changes: object) -> SensorCheck:
    fields = {name: getattr(SENSOR, name) for name in Sensor.__slots__}
    return SensorCheck(Sensor(**(fields | changes)), 4)


def causes(check: SensorCheck, readings: list[float], elapsed_s: float = 1.0) -> list[int]:
    faults = [check.look(value, elapsed_s) for value in readings]
    return [0 if fault is None else fault.cause for fault in faults]


def test_missing_and_implausible_readings_are_faults():
    readings = [20.0, nan, inf, -inf, 20.1, 90.0, -5.0, 20.0]
    wanted = [0, MISSING, MISSING, MISSING, 0, IMPLAUSIBLE, IMPLAUSIBLE, 0]
    assert causes(check_of(), readings) == wanted


def test_a_spike_is_one_bad_reading():
    assert causes(check_of(), [20.0, 20.1, 45.0, 20.1, 20.2]) == [0, 0, TOO_FAST, 0, 0]


def test_a_lasting_shift_stays_a_fault_until_it_is_where_warming_may_have_taken_it():
    check = check_of()
    shifted = causes(check, [20.0, *[51.0 + 0.1 * (k % 2) for k in range(5000)]])
    assert shifted == [0] + [TOO_FAST] * 5000
    allowed = SENSOR.noise + SENSOR.rate_per_s * SPAN_S
    assert causes(check, [20.0 + allowed + 0.1, 20.0 + allowed - 0.1]) == [TOO_FAST, 0]


def test_rates_are_taken_over_the_time_in_which_temperatures_change():
    assert SPAN_S == SLOW_S  # an FMU holds nothing of `measurement`


def test_after_a_gap_the_elapsed_time_counts():
    quick, slow = check_of(), check_of()
    assert causes(quick, [20.0, nan, 25.0], elapsed_s=10.0) == [0, MISSING, TOO_FAST]
    assert causes(slow, [20.0, nan, 25.0], elapsed_s=300.0) == [0, MISSING, 0]


@pytest.mark.parametrize("step_s", [0.001, 0.1, 1.0, 40.0])
def test_noise_and_quantisation_are_no_rate(step_s):
    random = np.random.default_rng(1)
    noisy = 20.0 + 0.05 * random.standard_normal(2000)
    coarse = np.round(20.0 + 0.001 * step_s * np.arange(2000) + noisy - 20.0, 0)
    check = check_of(noise=3.0, stale_after_s=None, high=200.0)
    assert set(causes(check_of(), noisy.tolist(), step_s)) == {0}
    assert set(causes(check, coarse.tolist(), step_s)) == {0}


def test_a_reading_that_stands_still_gets_stale_and_wakes_up():
    alive = [20.0 + 0.01 * (k % 2) for k in range(ALIVE_AFTER + 1)]
    still = [alive[-1]] * 7 + [20.02]
    # The last change starts the clock; more than 600 s later it is stale.
    found = causes(check_of(), alive + still, elapsed_s=100.0)
    assert found == [0] * (len(alive) + 6) + [STALE, 0]
    never = check_of(stale_after_s=None)
    assert causes(never, alive + still, elapsed_s=100.0) == [0] * (len(alive) + 8)


def test_the_constants_of_a_test_bench_are_not_stale():
    # Set by hand now and then: not the way a live sensor moves.
    by_hand = [20.0 + 0.1 * (k // 50) for k in range(50 * ALIVE_AFTER)]
    assert set(causes(check_of(), by_hand, elapsed_s=100.0)) == {0}


def test_being_alive_survives_a_restored_state():
    first, second = check_of(), check_of()
    for k in range(ALIVE_AFTER + 1):
        first.look(20.0 + 0.01 * (k % 2), 100.0)
    second.restore(first.state())
    assert causes(second, [20.0] * 7, elapsed_s=100.0)[-1] == STALE


@given(
    st.lists(st.floats() | st.floats(15, 25), max_size=40), st.lists(st.floats(0, 1e9), min_size=40)
)
def test_what_passes_is_plausible_and_within_the_corridor(readings, elapsed):
    check = check_of()
    good, since = None, 0.0
    for value, step in zip(readings, elapsed, strict=False):
        since += step
        if check.look(value, step) is None:
            assert SENSOR.low <= value <= SENSOR.high
            if good is not None:
                assert abs(value - good) <= SENSOR.noise + SENSOR.rate_per_s * since + 1e-9
            good, since = value, 0.0


def test_a_reading_that_jumped_beyond_what_is_plausible_must_come_back():
    sensor = Sensor("T1", 0.0, 55.0, 0.05, 0.5, None, 0.0, 50.0)
    check = SensorCheck(sensor, 1)
    assert check.look(25.0, 0.0) is None
    jumped = check.look(56.0, 60.0)
    assert jumped.cause == IMPLAUSIBLE
    for _ in range(120):  # in range again, but where no warming took it
        told = check.look(54.0, 60.0)
        assert told.cause == TOO_FAST
    assert check.look(30.0, 60.0) is None
