"""The compensator's step: offsets, and how much is known of them."""

from __future__ import annotations

import json
from math import exp, nan
from typing import Any

import pytest

from fmu_compensator.runtime.compensator import RunningCompensator
from fmu_compensator.runtime.modelfile import parse_model
from tests.fmu_compensator.bench import ROOM, AsModel, Bench, free, quick, warm
from tests.native.made import made_model


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
