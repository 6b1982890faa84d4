"""All models on the same runs."""

import json

import numpy as np
import pandas as pd
import pytest

from fmu_compensator.fit.columns import MeasuredColumns, targets_of
from fmu_compensator.fit.comparison import compare
from fmu_compensator.fit.contestants import contestants
from fmu_compensator.fit.splits import Split, leave_out
from measurement.errors import BadInput
from measurement.faults import looked_over
from measurement.figures import figures_of_merit
from measurement.runs import Run
from tests.fmu_compensator.conftest import RIG, make_run
from tests.refusing import refusal

RUNS = looked_over([make_run(name, seed, hours=2.0) for seed, name in enumerate("abcde")])


def one_split() -> Split:
    return Split("new runs", RUNS[:3], RUNS[3:])


def test_the_json_form_and_the_ranking():
    steps: list[str] = []
    entrants = contestants(["mlr", "arx"])
    found = compare([one_split()], RIG, entrants, on_step=steps.append)
    table = json.loads(json.dumps(found.to_dict(), allow_nan=False))
    assert list(table["targets"].items()) == [
        ("elongation", "um"),
        ("yaw", "urad"),
        ("pitch", "urad"),
    ]
    rows = {row["name"]: row for row in table["models"]}
    assert set(rows) == {
        "no_model", "persistence", "persistence_one_step", "mlr", "arx", "arx_one_step"
    }  # fmt: skip
    for row in rows.values():
        assert set(row["train"]) == {"elongation", "yaw", "pitch"}
        assert set(row["validate"]) == {"elongation", "yaw", "pitch", "per_run"}
        assert {"rmse", "max_abs", "mean_abs", "r2", "eta", "mape", "sse"} <= set(
            row["validate"]["yaw"]
        )
        assert [one["run"] for one in row["validate"]["per_run"]] == ["d", "e"]
    free = [row["score"] for row in table["models"] if not row["uses_displacement"]]
    assert free == sorted(free)
    assert [row["uses_displacement"] for row in table["models"]] == [False] * 4 + [True] * 2
    assert rows["no_model"]["score"] == pytest.approx(1.0)
    assert rows["mlr"]["score"] < 0.05
    assert len(steps) == len(entrants)
    # Beside what is installed stands the error model alone, and how much of it counts.
    assert ["alone" in row for row in rows.values()] == ["counts" in row for row in rows.values()]
    assert {name for name, row in rows.items() if "alone" in row} == {"mlr", "arx"}
    assert rows["mlr"]["alone"]["yaw"]["rmse"] != rows["mlr"]["validate"]["yaw"]["rmse"]
    assert all(0.0 <= share <= 1.0 for share in rows["mlr"]["counts"].values())
    assert set(rows["arx"]["counts"].values()) == {1.0}  # it takes measurements in its own way
    # One step ahead flatters whoever does it.
    one_step = rows["persistence_one_step"]["validate"]["elongation"]["rmse"]
    assert one_step < 0.05 * rows["persistence"]["validate"]["elongation"]["rmse"]


def test_the_figures_are_those_of_the_rows():
    found = compare([one_split()], RIG, contestants(["mlr"]))
    row = next(row for row in found.rows if row.name == "mlr")
    measured = np.concatenate([one.measured[:, 0] for one in row.validate])
    predicted = np.concatenate([one.predicted[:, 0] for one in row.validate])
    table = found.to_dict()["models"][[r.name for r in found.rows].index("mlr")]
    wanted = figures_of_merit(measured, predicted)
    assert table["validate"]["elongation"]["rmse"] == pytest.approx(wanted["rmse"], rel=1e-5)
    truth = pd.concat([-run.frame["S5_um"] + run.frame["S5_um"].iloc[0] for run in RUNS[3:]])
    assert measured == pytest.approx(truth.to_numpy())


def test_the_interval_that_each_promises_is_judged():
    random = np.random.default_rng(1)

    def noisy(run: Run) -> Run:
        shown = run.frame[RIG.columns]
        return Run(run.name, run.frame.assign(**(shown + random.normal(0.0, 0.05, shown.shape))))

    runs = [noisy(run) for run in RUNS]
    split = Split("new runs", runs[:3], runs[3:])
    found = compare([split], RIG, contestants(["mlr", "gaussian"]))
    rows = {row["name"]: row for row in found.to_dict()["models"]}
    for name in ("mlr", "gaussian"):
        interval = rows[name]["interval"]
        assert interval["coverage_wanted"] == 0.9
        shares = interval["coverage_measured"]
        assert set(shares) == {"elongation", "yaw", "pitch"}
        assert all(share > 0.5 for share in shares.values())
        assert rows[name]["score"] < 0.05
    assert "interval" not in rows["no_model"]


def test_any_displacement_columns_serve():
    def renamed(run: Run) -> Run:
        frame = run.frame.rename(columns={"S1_um": "probe_a_um", "S5_um": "probe_b_um"})
        return Run(run.name, frame.drop(columns=["S2_um", "S3_um", "S4_um"]))

    runs = [renamed(run) for run in RUNS]
    rig = targets_of(runs, RIG.model_dump())
    assert rig == MeasuredColumns(["probe_a_um", "probe_b_um"])
    found = compare([Split("x", runs[:3], runs[3:])], rig, contestants(["mlr"]))
    assert found.targets == ["probe_a_um", "probe_b_um"]
    assert found.units == ["um", "um"]
    assert targets_of(RUNS, RIG.model_dump()) == RIG


def test_what_a_simulation_adds_is_no_target():
    frame = RUNS[0].frame.assign(drift_X_um=1.0, error_X_um=1.0, offset_X_um=0.0)
    assert targets_of([Run("s", frame)], None).columns == [f"S{k}_um" for k in range(1, 6)]
    with pytest.raises(BadInput, match="share no displacement column"):
        targets_of([Run("t", RUNS[0].frame[["time_s", "T1_degC"]])], None)


def test_a_model_that_cannot_be_fitted_is_left_out_with_a_reason():
    runs = [Run(run.name, run.frame.drop(columns="speed_rpm")) for run in RUNS]
    split = Split("x", runs[:3], runs[3:])
    found = compare([split], RIG, contestants(["mlr", "ne"]))
    assert "ne" not in [row.name for row in found.rows]
    assert "speed_rpm" in found.left_out["ne"]
    assert found.to_dict()["left_out"][0]["name"] == "ne"
    assert "speed_rpm" in refusal(compare, [split], RIG, contestants(["ne"]))


def test_runs_of_the_same_speeds_are_left_out_together():
    def at(name: str, *speeds: float) -> Run:
        run = make_run(name, len(name), hours=1.0)
        return Run(name, run.frame.assign(speed_rpm=np.resize(speeds, len(run.frame))))

    runs = [at("a", 1000.0), at("b", 2000.0), at("c", 0.0, 1000.0), at("d", 2000.0)]
    splits = {
        split.name: [run.name for run in split.validate] for split in leave_out(runs, "speeds")
    }
    assert splits == {"1000 rpm": ["a", "c"], "2000 rpm": ["b", "d"]}
    assert "1 group" in refusal(leave_out, [runs[1], runs[3]], "speeds")


def test_a_sensor_that_the_judged_runs_lack_is_named():
    lacking = [Run(run.name, run.frame.drop(columns="T4_degC")) for run in RUNS[3:]]
    assert "T4" in refusal(compare, [Split("x", RUNS[:3], lacking)], RIG, contestants(["mlr"]))


def test_all_models_and_variants_take_part_by_default():
    entrants = {one.name: one for one in contestants(None)}
    assert {
        "no_model", "persistence", "mlr", "bp", "bp_5_5", "ga_bp", "arma", "arx", "ne", "fem",
        "vac", "vac_least_squares", "vac_adaptive", "thermal_states",
    } <= set(entrants)  # fmt: skip
    assert entrants["bp_5_5"].recipe.options == {"hidden": (5, 5)}
    assert all(one.title for one in entrants.values())
    seeded = {one.name: one for one in contestants(["ga_bp", "mlr"], seed=3)}
    assert seeded["ga_bp"].recipe.options == {"seed": 3}
    assert seeded["mlr"].recipe.options == {}


@pytest.mark.parametrize(
    ("names", "told"), [(["magic"], "'magic' is not allowed"), (["mlr", "mlr"], "given twice")]
)
def test_wrong_names_are_refused(names, told):
    assert told in refusal(contestants, names)
