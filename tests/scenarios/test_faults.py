"""Faults of sensors, each against readings worked out by hand."""

import math
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from scenarios.faults import FaultLine, SensorFault
from tests.refusing import refusal


def seen(fault: dict[str, Any], readings: list[float], step_s: float = 1.0) -> list[float]:
    line = FaultLine([SensorFault(sensor="T2", **fault)], ["T1_degC", "T2_degC"])
    found = []
    for k, reading in enumerate(readings):
        values = np.array([7.0, reading])
        line.apply(k * step_s, step_s, values)
        assert values[0] == 7.0
        found.append(float(values[1]))
    return found


RAMP = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]
CASES = [
    ({"kind": "missing", "start_s": 2, "end_s": 4}, [0, 1, math.nan, math.nan, 4, 5]),
    ({"kind": "frozen", "start_s": 2, "end_s": 5}, [0, 1, 2, 2, 2, 5]),
    ({"kind": "offset", "value": 10.0, "start_s": 4}, [0, 1, 2, 3, 14, 15]),
    ({"kind": "stuck-at", "value": -3.0, "start_s": 1, "end_s": 3}, [0, -3, -3, 3, 4, 5]),
    ({"kind": "drift", "value": 3600.0, "start_s": 1, "end_s": 4}, [0, 1, 3, 5, 4, 5]),
    ({"kind": "spike", "value": 10.0, "start_s": 1}, [0, 11, 2, 3, 4, 5]),
    ({"kind": "spike", "value": 10.0, "start_s": 1, "every_s": 2.0}, [0, 11, 2, 13, 4, 15]),
]


@pytest.mark.parametrize(("fault", "expected"), CASES)
def test_what_the_compensator_sees(fault, expected):
    assert seen(fault, RAMP) == pytest.approx(expected, nan_ok=True)


def test_a_spike_lasts_one_step_whatever_its_length():
    spike = {"kind": "spike", "value": 10.0, "start_s": 1.0}
    assert seen(spike, RAMP, step_s=0.5) == [0, 1, 12, 3, 4, 5]


def test_a_fault_begins_and_ends_at_the_communication_points_that_it_names():
    # 36 x 0.3 is less than 10.8, and 37 x 0.3 is 11.1.
    missing = {"kind": "missing", "start_s": 10.8, "end_s": 11.1}
    found = seen(missing, [0.0] * 40, step_s=0.3)
    assert np.flatnonzero(np.isnan(found)).tolist() == [36]


def test_spikes_repeat_at_the_communication_points_that_they_name():
    spike = {"kind": "spike", "value": 1.0, "start_s": 5.0, "every_s": 0.3}
    found = seen(spike, [0.0] * 100, step_s=0.1)
    assert np.flatnonzero(found).tolist() == list(range(50, 100, 3))


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        ({"kind": "stuck-at", "value": 401.0}, "401 is outside -60..400 degC"),
        ({"kind": "offset", "value": -461.0}, "-461 is outside -460..460 degC"),
        ({"kind": "spike", "value": 461.0}, "461 is outside -460..460 degC"),
    ],
)
def test_a_fault_that_takes_every_reading_out_of_range_is_refused(fault, said):
    assert refusal(seen, {"start_s": 1} | fault, RAMP) == f"faults, item 1, value: {said}"


def test_faults_act_one_after_the_other():
    faults = [
        SensorFault(sensor="T1", kind="offset", value=1.0, start_s=0),
        SensorFault(sensor="T1", kind="frozen", start_s=1),
    ]
    line = FaultLine(faults, ["T1_degC"])
    found = []
    for k in range(3):
        values = np.array([float(k)])
        line.apply(float(k), 1.0, values)
        found.append(float(values[0]))
    assert found == [1.0, 2.0, 2.0]


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        ({"kind": "offset", "start_s": 0}, "needs value"),
        ({"kind": "missing", "value": 1.0, "start_s": 0}, "takes no value"),
        ({"kind": "frozen", "start_s": 0, "every_s": 1.0}, "takes no every_s"),
        ({"kind": "missing", "start_s": 5, "end_s": 5}, "must be after"),
        ({"kind": "melted", "start_s": 5}, "missing"),
    ],
)
def test_faults_that_make_no_sense_are_refused(fault, message):
    with pytest.raises(ValidationError, match=message):
        SensorFault(sensor="T1", **fault)
