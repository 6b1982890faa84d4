"""Training runs kept in the compensator file, and new runs taken in beside them."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fmu_compensator.fit.fitting import compensator_text, fit_compensator
from fmu_compensator.fit.remembered import MOST_ROWS, remembered, remembered_runs
from fmu_compensator.fit.updating import update_compensator
from fmu_compensator.runtime.modelfile import Model, parse_model, without_training
from measurement.errors import BadInput
from measurement.runs import Run
from scenarios.building import compensator_recipe
from tests.fmu_compensator.conftest import RIG, make_run

NAMES = ["T1", "T2", "T3", "T4"]


def model_of(runs: list[Run], **options: Any) -> Model:
    return parse_model(compensator_text(fit_compensator(runs, RIG, "bayes", **options)), "m.json")


def runs(*seeds: int) -> list[Run]:
    return [make_run(f"run{seed}", seed) for seed in seeds]


@pytest.fixture(scope="module")
def model() -> Model:
    return model_of(runs(0, 1, 2, 3))


def test_a_file_keeps_what_the_runs_showed(model: Model) -> None:
    given = runs(0, 1, 2, 3)
    kept, rig = remembered_runs(model.table, "m.json")
    assert rig == RIG
    assert [(one.name, one.sha256) for one in kept] == [(one.name, one.sha256) for one in given]
    for one, whole in zip(kept, given, strict=True):
        assert len(one.frame) <= MOST_ROWS * 1.1 + 1
        for name in ["T1_degC", "S5_um"]:
            there = np.interp(one.time_s, whole.time_s, whole.frame[name])
            span = np.ptp(whole.frame[name])
            np.testing.assert_allclose(one.frame[name], there, atol=0.05 * span)
        assert one.frame["S5_um"][0] == pytest.approx(whole.frame["S5_um"][0], abs=0.006)


def test_keeping_what_was_kept_changes_nothing(model: Model) -> None:
    kept, rig = remembered_runs(model.table, "m.json")
    assert remembered(kept, rig, NAMES)["runs"] == model.table["training"]["runs"]


def test_missing_readings_stay_missing() -> None:
    frame = make_run("gap", 5, step_s=300.0).frame
    frame.loc[10:30, "T1_degC"] = math.nan
    table = {"training": remembered([Run("gap", frame)], RIG, NAMES)}
    [kept], _ = remembered_runs(json.loads(json.dumps(table)), "x")
    assert kept.frame["T1_degC"].isna().to_list() == frame["T1_degC"].isna().to_list()


def test_an_update_is_as_good_as_a_fit_to_all_runs(model: Model) -> None:
    whole = model_of(runs(0, 1, 2, 3, 4, 5))
    updated = parse_model(compensator_text(update_compensator(model, runs(4, 5))), "u.json")
    assert updated.chosen == whole.chosen
    assert [run["name"] for run in updated.provenance["runs"]] == [f"run{n}" for n in range(6)]
    # The old runs' rows are those of their files, not of what was kept of them.
    assert updated.provenance["runs"] == whole.provenance["runs"]
    for target in whole.targets:
        one, other = (
            model.provenance["figures"]["unseen"]["like"][target]["model"]
            for model in (whole, updated)
        )
        assert other == pytest.approx(one, rel=0.5, abs=0.1)


def test_an_update_keeps_options_and_limits() -> None:
    old = model_of(
        runs(0, 1, 2),
        points=["T1", "T4"],
        name="mine",
        tool_length_mm=(0.0, 150.0),
        limits={"hold_s": 77.0, "offset_um": 333.0},
    )
    new = update_compensator(old, runs(3), created="2026-02-03")
    assert new["chosen"] == ["T1", "T4"]
    assert (new["name"], new["created"]) == ("mine", "2026-02-03")
    assert new["limits"]["hold_s"] == 77.0
    assert new["limits"]["offset_um"] == 333.0
    assert new["limits"]["tool_length_mm"] == [0.0, 150.0]
    assert new["error_model"]["kind"] == "bayes"


def test_it_refuses_a_run_that_it_knows(model: Model) -> None:
    with pytest.raises(BadInput, match="already in the compensator, as run2"):
        update_compensator(model, runs(2))


def test_it_refuses_a_run_without_a_thermometer_in_use(model: Model) -> None:
    lost = Run("lost", make_run("lost", 9).frame.drop(columns="T4_degC"))
    with pytest.raises(BadInput, match="T4_degC: is missing"):
        update_compensator(model, [lost])


def test_a_file_that_forgot_its_runs_says_what_to_do() -> None:
    forgetful = model_of(runs(0, 1, 2), keep_runs=False)
    assert "training" not in forgetful.table
    with pytest.raises(BadInput, match="fit it anew with all of them"):
        update_compensator(forgetful, runs(3))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda kept: kept.pop("rig"), "training.rig"),
        (lambda kept: kept["rig"].update(spacing_mm=0.0), "spacing_mm"),
        (lambda kept: kept.update(runs=[]), "must be a list of runs"),
        (lambda kept: kept["runs"][0].pop("columns"), "must have a name"),
        (lambda kept: kept["runs"][1]["columns"].update(T1_degC="21 22"), "has 2 rows"),
        (lambda kept: kept["runs"][1]["columns"].update(time_s="0 x"), "'x' is not a number"),
    ],
)
def test_damaged_runs_are_refused_with_their_place(model: Model, change: Any, words: str) -> None:
    table = json.loads(json.dumps(model.table))
    change(table["training"])
    with pytest.raises(BadInput, match=words):
        remembered_runs(table, "m.json")


def test_an_fmu_carries_no_measurements(model: Model, tmp_path: Path) -> None:
    path = tmp_path / "c.json"
    path.write_text(compensator_text(model.table))
    recipe, _ = compensator_recipe(path, "compensator")
    [embedded] = recipe.data.values()
    table = json.loads(embedded)
    assert "training" not in table
    assert table == {key: model.table[key] for key in table}
    assert without_training(embedded.decode()) == embedded.decode()
