"""The compensator's step: offsets, and how much is known of them."""

from math import hypot, nan

import pandas as pd
import pytest

from spindle_drift import Compensator
from tests.fmu_compensator.bench import ROOM, Bench, free, leaping, quick, warm
from tests.fmu_compensator.gaussians import apart, knows_nothing


def test_offsets_are_the_opposite_of_the_predicted_drift(five_point_table, as_model):
    bench = Bench(as_model(leaping(five_point_table)))
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


def test_the_rise_form_ignores_the_level_of_a_sensor(five_point_table, as_model):
    plain, shifted = Bench(as_model(five_point_table)), Bench(as_model(five_point_table))
    for rise in range(20):
        plain_out = plain.step([20 + 0.1 * rise, 0.0, 0.0, 20 + 0.2 * rise])
        shifted_out = shifted.step([20 + 0.1 * rise, 0.0, 0.0, 51 + 0.2 * rise])
        assert plain_out[:6] == pytest.approx(shifted_out[:6], abs=1e-9)
    assert plain_out.dZ > 5.0


def test_the_absolute_form_takes_readings_as_they_are(five_point_table, as_model):
    table = quick(five_point_table) | {"input_form": "absolute"}
    table["error_model"]["intercept"][0] = -50.0
    output = Bench(as_model(table)).step(ROOM)
    assert output.elongation == -50.0 + 3 * 20.0


def test_a_direct_geometry_needs_no_tool_length(direct_table, as_model):
    bench = Bench(as_model(leaping(direct_table)))
    bench.step(ROOM, tool=nan)
    output = bench.step(warm(2.0, 4.0), tool=nan)
    assert (output.dX, output.dY, output.dZ) == (-4.0, 0.0, 6.0)
    assert (output.elongation, output.yaw, output.status) == (6.0, 0.0, 0)
    # An axis that is not measured has no half width.
    assert output[6:9] == (2.0, -1.0, 2.0)


def test_the_half_width_is_that_of_the_walk_and_the_tool(five_point_table, as_model):
    # Yaw and the near plane's X are partly one error, of opposite sign: they cancel in part.
    spread = apart([3.0, 40.0, 20.0, 0.6, 2.0])
    spread[3][1] = -0.8
    walking = {"walk_per_h": 0.25, "noise": spread}
    bench = Bench(as_model(five_point_table | {"gaussian": knows_nothing(5) | walking}))
    assert bench.step([nan] * 4)[6:9] == (-1.0, -1.0, -1.0)
    bench.step(tool=30.0, count=3599)
    hour = bench.step(tool=30.0)
    # Two deviations of the near plane's drift, and of the elongation; an hour adds a quarter.
    assert hour[6:9] == pytest.approx([2.0 * s * 1.25**0.5 for s in (1.0, 2.0, 3.0)], rel=1e-3)
    # In a fault the last good one stays, and the time goes on.
    bench.time += 1800.0
    assert bench.step([nan] * 4)[6:9] == hour[6:9]
    bench.time += 5400.0
    late = bench.step(tool=130.0)
    # 0.1 m beyond the near plane 10 urad are a micrometre.
    x, y = hypot(4.0 - 0.8, 0.6), hypot(2.0, 2.0)
    wide = [2.0 * s * 1.75**0.5 for s in (x, y, 3.0)]
    assert late[6:9] == pytest.approx(wide, rel=1e-3)


def test_the_gaussian_stands_on_the_error_model(five_point_table, as_model):
    bench = Bench(as_model(free(five_point_table)))
    bench.step(ROOM)
    output = bench.step(warm(2.0, 4.0), tool=30.0)
    # The error model says 10, 20, -8, 2 and 0.5; the Gaussian adds 4 + 0.5 * 2 to each.
    assert output[3:6] == pytest.approx((15.0, 25.0, -3.0))
    assert output[:3] == pytest.approx((-7.0, -5.5, 15.0))


def test_what_is_new_only_together_is_named_and_not_faded(five_point_table, as_model):
    bench = Bench(as_model(free(five_point_table)))
    bench.step(ROOM)
    together = bench.step(warm(4.0, 4.0), tool=30.0)
    assert (together.status, together.valid) == (0, True)
    apart = bench.step(warm(0.0, 4.0), tool=30.0)
    assert (apart.status, apart.valid, apart.status_sensor) == (2, True, 4)
    novelty = 0.5 * 16.0 - 0.495 / 2.0 * 16.0
    walk = (bench.time - 1.0) / 3600.0 * 0.25  # from the first sample to the last
    part = 100.0 * novelty / (novelty + 1.0 + walk)
    told = f"conditions outside training make {part:.0f} % of the uncertainty: T4"
    assert apart.status_text == told
    assert apart.dZ == pytest.approx(8.0 + 4.0)  # the posterior mean, whatever is new
    assert apart.dZ_uncertainty == pytest.approx(2.0 * (1.0 + walk + novelty) ** 0.5)
    worst = bench.step(warm(-4.0, 3.0))
    assert worst.status_text.endswith(": T1")
    assert worst.status_sensor == 1
    assert bench.step(warm(4.0, 4.0)).status == 0
    # In a fault nobody speaks of training.
    assert bench.step([nan] * 4).status == 11


@pytest.mark.parametrize(
    ("limits", "sent"),
    [
        ({"share": 0.0}, lambda offset: 0.0),
        ({"share": 0.6}, lambda offset: 0.6 * offset),
        ({"share": 1.0}, lambda offset: offset),
        ({"offset_um": 4.0}, lambda offset: min(max(offset, -4.0), 4.0)),
    ],
)
def test_the_interval_has_what_the_offset_leaves(five_point_table, as_model, limits, sent):
    table = free(five_point_table)
    whole = Bench(as_model(table))
    part = Bench(as_model(table | {"limits": table["limits"] | limits}))
    for bench in (whole, part):
        bench.step(ROOM)
    all_of_it, some = (bench.step(warm(2.0, 4.0)) for bench in (whole, part))
    wanted = all_of_it[:3]
    assert some[:3] == pytest.approx([sent(offset) for offset in wanted])
    assert some[3:6] == all_of_it[3:6]
    left = [abs(offset - sent(offset)) for offset in wanted]
    widths = [width + more for width, more in zip(all_of_it[6:9], left, strict=True)]
    assert some[6:9] == pytest.approx(widths)


def test_a_row_s_offsets_have_moved_since_the_row_before(five_point_table, as_model):
    table = free(five_point_table)
    table["limits"]["slew_um_per_s"] = 0.01
    rows = [ROOM, warm(2.0, 4.0), warm(2.0, 4.0)]
    frame = pd.DataFrame(rows, columns=[f"T{n}_degC" for n in range(1, 5)])
    frame.insert(0, "time_s", [0.0, 60.0, 1060.0])
    sent = Compensator(as_model(table)).predict(frame)
    assert sent["dZ_um"].tolist() == pytest.approx([0.0, 0.6, 10.6])


def test_the_text_names_offsets_at_their_limit(five_point_table, as_model):
    table = free(five_point_table)
    bench = Bench(as_model(table | {"limits": table["limits"] | {"offset_um": 8.0}}))
    bench.step(ROOM)
    output = bench.step(warm(4.0, 4.0))
    assert (output.valid, output.status) == (True, 0)
    at_it = "; dX is at its limit of 8 um; dZ is at its limit of 8 um"
    assert output.status_text == "offsets follow the model" + at_it


def test_a_measurement_counts_from_the_next_sample_on(five_point_table, as_model):
    bench = Bench(as_model(free(five_point_table)))
    # What was measured before anything was predicted says nothing about the prediction.
    assert bench.step([nan] * 4, measured=[50.0] * 5).status == 1
    bench.step(ROOM)
    # Where one target is not finite, nothing was measured.
    before = bench.step(warm(4.0, 4.0), measured=[13.0, 10.0, -1.0, 2.0, nan])
    assert bench.step(warm(4.0, 4.0))[3:6] == before[3:6]
    told = bench.step(warm(4.0, 4.0), measured=[19.0, 26.0, -10.0, 8.0, 7.0])
    assert told[3:6] == before[3:6]
    after = bench.step(warm(4.0, 4.0))
    # 18 um were predicted, and 19 seen; noise keeps some of the difference.
    assert before.elongation == pytest.approx(18.0)
    assert 18.0 < after.elongation < 19.0
    assert after.dZ_uncertainty < before.dZ_uncertainty
