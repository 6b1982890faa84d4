"""From runs to a compensator file."""

import re
from typing import Any

import numpy as np
import pandas as pd
import pytest

from fmu_compensator.driving import drive
from fmu_compensator.fit.data import prepare
from fmu_compensator.fit.fitting import compensator_text, fit_compensator
from fmu_compensator.fit.points import choose_points, on_grid
from fmu_compensator.runtime.modelfile import parse_model
from measurement.errors import BadInput
from measurement.faults import looked_over
from measurement.rig import DirectRig
from measurement.runs import Run, read_run
from tests.fmu_compensator.conftest import DIRECT_RIG, RIG, make_run
from tests.refusing import refusal

RUNS = looked_over([make_run(name, seed) for seed, name in enumerate("abcd")])
FINE = looked_over([make_run(name, seed, step_s=30.0) for seed, name in enumerate("abcd")])


def changed(run: Run, **columns: Any) -> Run:
    return Run(run.name, run.frame.assign(**columns))


def fitted(*given: Any, **options: Any) -> dict[str, Any]:
    """Fit a compensator that is not judged, which would fit it anew for every run left out."""
    return fit_compensator(*given, judge=False, **options)


def test_grey_points_take_one_of_each_group():
    table = fitted(RUNS, RIG, "mlr", created="2026-01-31")
    choice = table["provenance"]["figures"]["choice"]
    # T2 copies T1; T3 shows noise only; T4 is slower.
    assert choice["hardly_moving"] == ["T3"]
    assert choice["groups"] == [["T1", "T2"], ["T4"]]
    assert table["chosen"] in (["T1", "T4"], ["T2", "T4"])


@pytest.mark.parametrize("model", [None, "mlr"])
def test_what_is_promised_is_what_runs_left_out_show(model):
    table = fit_compensator(RUNS[:3], RIG, model, points="T1,T4")
    assert table["error_model"]["kind"] == (model or "gaussian")
    figures = table["provenance"]["figures"]
    for axis, row in figures["unseen"]["like"].items():
        # 0.02 K of noise in reading and reference, times a few um/K.
        assert figures["training"][axis]["model"] < row["model"] < 0.4, axis
        assert row["no_model"] > 0.9
        assert 0.5 < row["inside"] <= 1.0
    assert [row["run"] for row in figures["unseen"]["by_run"]] == list("abc")
    # The promise is that of a compensator made without the run, driven through it.
    left = fitted(RUNS[1:3], RIG, model, points="T1,T4", limits={"slew_um_per_s": 1000.0})
    driven = drive(parse_model(compensator_text(left), "left"), RUNS[0], RUNS[0], RIG, 100.0)
    miss = np.sqrt(np.nanmean((driven.error / driven.half_width) ** 2, axis=0))
    assert figures["unseen"]["by_run"][0]["miss"] == pytest.approx(miss.tolist(), rel=1e-4)


def test_sampling_does_not_change_what_a_run_counts():
    def run_of(name: str, slope: float, step_s: float) -> Run:
        made = make_run(name, 5, step_s=step_s, noise=0.0)
        rise = made.frame["T4_degC"] - 21.0
        return changed(made, disp_x_um=slope * rise, disp_z_um=rise)

    table = fitted(
        [run_of("dense", 1.0, 10.0), run_of("sparse", 3.0, 60.0)], DIRECT_RIG, "mlr", points="T4"
    )
    assert table["error_model"]["coefficients"][0][0] == pytest.approx(2.0, abs=0.02)


def test_the_rise_form_ignores_a_level_that_jumps_between_runs():
    shifted = [*FINE[:3], changed(FINE[3], T4_degC=FINE[3].frame["T4_degC"] + 31.0)]
    plain, moved = (fitted(runs, RIG, "mlr", points="T1,T4") for runs in (FINE, shifted))
    for one, other in zip(
        plain["error_model"]["coefficients"], moved["error_model"]["coefficients"], strict=True
    ):
        assert one == pytest.approx(other, abs=1e-9)
    (note,) = moved["provenance"]["notes"]
    off = r"reads \+31 K compared with its level in the other runs; "
    assert re.match(f"d, T4_degC, .* {off}", note)
    absolute = fitted(shifted, RIG, "mlr", points="all", input_form="absolute")
    assert absolute["chosen"] == ["T1", "T2", "T3"]
    reason = "T4 is no candidate: the absolute form would carry its wrong level into the offsets"
    assert reason in absolute["provenance"]["notes"]


def test_a_sensor_that_leaves_the_others_is_left_out_from_there_on():
    readings = RUNS[1].frame["T2_degC"].to_numpy().copy()
    readings[100:] += 31.0
    table = fitted([RUNS[0], changed(RUNS[1], T2_degC=readings), *RUNS[2:]], RIG, "mlr")
    assert table["chosen"] == ["T1", "T4"]
    assert "T2 is no candidate: broken for most of b" in table["provenance"]["notes"]
    assert any(n.startswith("b, T2_degC, 100 to 240 min: ") for n in table["provenance"]["notes"])


@pytest.mark.parametrize("model", [pytest.param(None, marks=pytest.mark.long), "mlr"])
def test_a_thermometer_that_stands_still_in_a_short_run_is_used(model):
    """A run of four rows takes no thermometer from the others; one dead in most runs is told."""
    short = Run("short", make_run("short", 9).frame.iloc[:16:5].assign(T4_degC=21.0))
    runs = [changed(run, T3_degC=20.0) for run in (*RUNS, short)]
    table = fit_compensator(runs, RIG, model, points="all")
    assert table["chosen"] == ["T1", "T2", "T4"]
    assert "T3 is left out: broken in a, b, c and 1 more" in table["provenance"]["notes"]


def test_a_run_that_is_over_before_the_shortest_lag_teaches_nothing():
    two, brief = (Run(f"of_{rows}", make_run("e", 9).frame.head(rows)) for rows in (2, 15))
    table, usual = (fit_compensator(runs, RIG) for runs in ([*RUNS, two, brief], RUNS))
    notes = table["provenance"].pop("notes")
    told = "left out, since they are shorter than 900 s, the model's shortest lag: of_2, of_15"
    assert notes == [*usual["provenance"].pop("notes"), told]
    assert table == usual
    alone = "nothing can be learnt from runs shorter than 900 s, the model's shortest lag: of_2"
    assert refusal(fit_compensator, [two], RIG) == f"training runs: {alone}"


def test_a_run_left_out_as_too_short_is_doubted_if_its_seconds_are_minutes():
    frame = RUNS[1].frame
    wrong = Run("b", frame.assign(time_s=frame["time_s"] / 60.0))
    notes = fit_compensator([RUNS[0], wrong, RUNS[2]], RIG, judge=False)["provenance"]["notes"]
    assert notes[0].startswith("doubtful: time_s")
    assert notes[0].endswith("minutes taken for seconds? then its unit is min (in b)")
    assert notes[-1].endswith("the model's shortest lag: b")


def test_a_sensor_that_is_read_rarely_counts_by_straight_lines():
    # It is judged with its last reading held, as in a control: more is left than with every one.
    rare = [
        changed(run, T4_degC=np.where(np.arange(len(run.frame)) % 20, np.nan, run.frame["T4_degC"]))
        for run in RUNS[:3]
    ]
    tables = [fit_compensator(runs, RIG, "mlr", points="T1,T4") for runs in (RUNS[:3], rare)]
    unseen = [table["provenance"]["figures"]["unseen"]["like"]["Z"]["model"] for table in tables]
    assert unseen[0] < unseen[1] < 2.0 * unseen[0]
    assert [table["provenance"]["runs"][0]["rows"] for table in tables] == [len(RUNS[0].frame)] * 2


def test_a_named_sensor_that_is_dead_in_a_run_is_refused():
    runs = [RUNS[0], changed(RUNS[1], T4_degC=0.0), *RUNS[2:]]
    with pytest.raises(BadInput, match="points: T4: has no usable reading in b"):
        fitted(runs, RIG, "mlr", points="T1,T4")


def test_a_short_warm_up_in_a_long_rest_is_seen():
    names, long = [f"T{n}_degC" for n in range(1, 5)], []
    for run in RUNS:
        rest = run.frame.iloc[np.zeros(10 * len(run.frame), dtype=int)].copy()
        rest[names] += 0.02 * np.random.default_rng(3).standard_normal((len(rest), 4))
        frame = pd.concat([rest, run.frame], ignore_index=True)
        long.append(Run(run.name, frame.assign(time_s=60.0 * np.arange(len(frame)))))
    choice = fitted(long, RIG, "mlr")["provenance"]["figures"]["choice"]
    assert choice["hardly_moving"] == ["T3"]


def test_a_spike_in_the_first_displacement_does_not_shift_the_run():
    first = FINE[0].frame["S5_um"].to_numpy().copy()
    first[0] += 50.0
    plain, spiked = (
        fit_compensator(runs, RIG, "mlr", points="T1,T4")["provenance"]
        for runs in (FINE[:3], [changed(FINE[0], S5_um=first), *FINE[1:3]])
    )
    left, wanted = (one["figures"]["training"]["Z"]["no_model"] for one in (spiked, plain))
    assert left == pytest.approx(wanted, rel=0.01)
    told = "a, S5_um, at 0 min: the first reading is off by +"
    assert any(told in note for note in spiked["notes"])


def test_constant_and_missing_sensors_are_left_out_with_a_reason():
    runs = [
        changed(RUNS[0], T1_degC=25.0),
        Run("b", RUNS[1].frame.drop(columns="T3_degC")),
        RUNS[2],
    ]
    table = fitted(runs, RIG, "mlr", points="all")
    assert table["chosen"] == ["T2", "T4"]
    assert [sensor["name"] for sensor in table["sensors"]] == ["T1", "T2", "T4"]
    assert "T3 is left out: missing in b" in table["provenance"]["notes"]
    assert "T1 is no candidate: broken for most of a" in table["provenance"]["notes"]


def test_missing_rows_are_dropped_and_counted():
    gappy = RUNS[0].frame["T1_degC"].to_numpy().copy()
    gappy[10:30] = np.nan
    table = fitted([changed(RUNS[0], T1_degC=gappy), *RUNS[1:]], RIG, "mlr", points="T1,T4")
    rows = f"{len(gappy) - 20} of {len(gappy)}"
    assert f"a: {rows} rows used, the rest lack a temperature" in table["provenance"]["notes"]
    assert table["provenance"]["runs"][0]["rows"] == len(gappy) - 20


def test_displacements_read_every_second_row_are_said_once_and_no_fault():
    rare = [changed(run, S5_um=run.frame["S5_um"].where(run.frame.index % 2 == 0)) for run in RUNS]
    notes = fitted(rare, RIG, "mlr", points="T1,T4")["provenance"]["notes"]
    rows = sum(len(run.frame) for run in RUNS)
    read = sum(len(run.frame.iloc[::2]) for run in RUNS)
    told = f"{read} of {rows} rows have all displacements: only these are learnt from"
    assert [note for note in notes if "rows" in note] == [told]


def test_frozen_displacement_is_not_learnt():
    reading = RUNS[0].frame["S5_um"].to_numpy().copy()
    reading[100:200] = reading[100]
    damaged = [changed(RUNS[0], S5_um=reading), *RUNS[1:]]
    table = fitted(damaged, RIG, "mlr", points="T1,T4")
    kept = fitted(damaged, RIG, "mlr", points="T1,T4", leave_out_frozen=False)
    note = next(note for note in table["provenance"]["notes"] if "S5_um" in note)
    assert note.startswith("a, S5_um, 100 to 199 min: exactly")
    wanted = fitted(RUNS, RIG, "mlr", points="T1,T4")["error_model"]["coefficients"][0]
    assert table["error_model"]["coefficients"][0] == pytest.approx(wanted, abs=0.05)
    assert kept["error_model"]["coefficients"][0] != pytest.approx(wanted, abs=0.05)


def test_limits_and_ranges_come_from_the_data():
    table = fitted(RUNS, RIG, "mlr", points="T1,T4", limits={"hold_s": 60.0})
    largest = max(run.frame["S5_um"].abs().max() for run in RUNS)
    assert table["limits"]["offset_um"] >= 2 * largest
    assert table["limits"]["hold_s"] == 60.0
    assert table["limits"]["tool_length_mm"] == [0.0, 260.0]
    rise = max(run.frame["T1_degC"].max() - run.frame["T1_degC"].iloc[0] for run in RUNS)
    first = table["sensors"][0]
    assert rise < first["trained_high"] < 1.1 * rise
    assert first["high"] > 21 + rise + 24
    assert first["stale_after_s"] >= 900


def test_the_geometry_comes_from_the_rig():
    table = fitted(RUNS, RIG, "mlr", geometry_form="pure_rotation", tool_length_mm=(50, 90))
    assert table["geometry"] == {
        "kind": "five_point",
        "form": "pure_rotation",
        "near_to_gauge_mm": 30.0,
        "spacing_mm": 100.0,
    }
    assert table["limits"]["tool_length_mm"] == [50, 90]
    runs = [
        changed(run, disp_x_um=run.frame["S1_um"], disp_z_um=run.frame["S5_um"]) for run in RUNS
    ]
    direct = fitted(runs, DIRECT_RIG, "mlr")
    assert direct["geometry"]["axes"]["disp_z"] == {"axis": "Z", "sign": 1}
    assert direct["error_model"]["targets"] == ["disp_x", "disp_z"]


def test_points_can_be_scored_against_one_target():
    prepared = prepare(RUNS, RIG)
    by_all, by_one = (
        choose_points(prepared.runs, prepared.candidates, target=target) for target in (None, 0)
    )
    grids = [on_grid(run, prepared.candidates) for run in prepared.runs]
    rises = np.concatenate([temperatures - temperatures[0] for temperatures, _ in grids])
    growth = np.concatenate([targets[:, 0] - targets[0, 0] for _, targets in grids])
    wanted = {
        c: abs(np.corrcoef(rises[:, k], growth)[0, 1]) for k, c in enumerate(prepared.candidates)
    }
    assert by_one.scores == pytest.approx({c: wanted[c] for c in by_one.scores})
    assert by_one.scores != pytest.approx(by_all.scores)


def test_points_are_not_chosen_in_a_run_of_two_rows():
    (run,) = prepare([Run("x", RUNS[0].frame.head(2))], RIG).runs
    assert refusal(on_grid, run, [0]) == "x: is shorter than 180 s: too short to choose from"


def test_temperatures_recorded_as_rises_are_refused_by_name_where_an_image_needs_their_level():
    rises = [
        changed(run, T2_degC=run.frame["T2_degC"] - run.frame["T2_degC"].iloc[0]) for run in RUNS
    ]
    with pytest.raises(BadInput, match=r"T2 starts at 0.*take --image interval"):
        fitted(rises, RIG, "mlr")
    table = fitted(rises, RIG, "mlr", grey={"image": "interval"})
    assert table["provenance"]["options"]["image"] == "interval"


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"model": "magic"}, "model: 'magic' is not allowed: "),
        ({"input_form": "delta"}, "rise, absolute"),
        ({"geometry_form": "bent"}, "rigid, pure_rotation"),
        ({"points": "T1,T9"}, "points: 'T9' is not allowed"),
        ({"points": ""}, "points: '' is not allowed"),
        ({"grey": {"threshold": 1.5}}, "lambda: 1.5 is not allowed"),
        ({"grey": {"score": "taste"}}, "score: 'taste' is not allowed"),
        ({"grey": {"image": "blurred"}}, "image"),
        ({"grey": {"absolute_image": "blurred"}}, "absolute image: 'blurred' is not allowed"),
        ({"grey": {"target": "roll"}}, "target: 'roll' is not allowed: elongation"),
        ({"limits": {"speed": 1.0}}, "limits: speed: is not a known limit"),
        ({"limits": {"hold_s": -1.0}}, "limits.hold_s"),
        ({"limits": {"share": 1.5}}, "limits.share"),
        ({"tool_length_mm": (100.0, 50.0)}, "tool length: 100 50 is not allowed"),
        ({"tool_length_mm": (0.0, float("nan"))}, "tool length: 0 nan is not allowed"),
        ({"created": "yesterday"}, "created"),
        ({"name": "two words"}, "name"),
        ({"sensors": ["T7"]}, "none of T7 is in all runs"),
        ({"speed_up": True}, "speed_up: is not a known option"),
    ],
)
def test_wrong_options_are_refused_in_one_line(options, told):
    assert told in refusal(fit_compensator, RUNS[:1], RIG, **{"model": "mlr", **options})


STANDING = [changed(run, S5_um=3.25) for run in RUNS]


@pytest.mark.parametrize(
    ("runs", "told"),
    [
        ([], "at least one run"),
        ([RUNS[0], RUNS[0]], "a: is the same run as a"),
        ([Run("x", RUNS[0].frame.drop(columns="S3_um"))], "x: distal_x"),
        ([Run("x", RUNS[0].frame.head(2))], "than 900 s, the model's shortest lag: x"),
        ([changed(RUNS[0], **{f"T{k}_degC": 20.0 for k in range(1, 5)})], "no temperature moves"),
        ([Run("x", RUNS[0].frame.rename(columns={"T1_degC": "T 1_degC"}))], "signal's name"),
        ([changed(RUNS[0], S1_um=np.nan)], "S1_um is broken or missing in almost every row"),
        (STANDING, "a: S5_um reads exactly 3.25 um in every row"),
    ],
)
def test_runs_that_cannot_be_used_are_refused(runs, told):
    assert told in refusal(fitted, runs, RIG, "mlr")


@pytest.mark.parametrize("model", [None, "ridge"])
def test_a_displacement_that_stands_in_every_run_is_named(model):
    said = refusal(fit_compensator, STANDING, RIG, model)
    assert "S5_um reads exactly 3.25 um in every row" in said


def test_processes_side_by_side_give_the_same_file_and_the_same_refusal():
    short = [make_run(name, seed, hours=1.0) for seed, name in enumerate("abc")]
    one, two = (
        compensator_text(fit_compensator(short, RIG, "mlr", points="T1,T4", jobs=jobs))
        for jobs in (1, 2)
    )
    assert one == two
    for jobs in (1, 2):
        assert "T9" in refusal(fit_compensator, RUNS, RIG, "mlr", points="T9", jobs=jobs)


def test_a_relational_score_chooses_too():
    prepared = prepare(RUNS, RIG)
    choice = choose_points(prepared.runs, prepared.candidates, score="relational")
    assert choice.groups == [[0, 1], [3]]
    assert all(0.3 < score <= 1 for score in choice.scores.values())


@pytest.mark.long
@pytest.mark.real_data
def test_measured_lathe_runs_unseen(lathe_runs):
    runs = [read_run(path) for path in lathe_runs]
    rig = DirectRig.model_validate({"axes": {"disp_x": {"axis": "X"}, "disp_z": {"axis": "Z"}}})
    table = fit_compensator(runs, rig, "mlr")
    notes = " ".join(table["provenance"]["notes"])
    assert "PT10 is no candidate: broken for most of 20200821" in notes
    assert "PT10" not in table["chosen"]
    unseen = table["provenance"]["figures"]["unseen"]
    for axis in ("X", "Z"):
        assert unseen["like"][axis]["model"] < 0.75 * unseen["like"][axis]["no_model"]
