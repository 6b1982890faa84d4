"""New runs into a compensator, without the old ones."""

import copy
from typing import Any

import numpy as np
import pytest

from fmu_compensator.driving import drive
from fmu_compensator.fit import gaussian as fitting
from fmu_compensator.fit.fitting import compensator_text, fit_compensator
from fmu_compensator.fit.gaussian import Gaussian
from fmu_compensator.fit.promise import left_of
from fmu_compensator.fit.spare import NOISE_K
from fmu_compensator.fit.updating import update_compensator
from fmu_compensator.monitoring import monitor
from fmu_compensator.monitoring.monitor import LEARNT
from fmu_compensator.monitoring.sensors import Agreement
from fmu_compensator.runtime.modelfile import Model, parse_model
from measurement.errors import BadInput
from measurement.runs import Run, read_run, write_run
from tests.fmu_compensator.conftest import RIG, make_run
from tests.refusing import refusal


def runs(*seeds: int) -> list[Run]:
    return [make_run(f"run{seed}", seed, hours=2.0, noise=0.1) for seed in seeds]


def model_of(given: list[Run], kind: str | None = None, **options: Any) -> Model:
    table = fit_compensator(given, RIG, kind, judge=False, **options)
    return parse_model(compensator_text(table), "m.json")


def updated(model: Model, given: list[Run]) -> Model:
    return parse_model(compensator_text(update_compensator(model, given)[0]), "u.json")


def test_one_by_one_is_all_at_once(monkeypatch):
    monkeypatch.setattr(Gaussian, "size_of", lambda self, sample: 1.0)
    monkeypatch.setattr(fitting, "LOST", 0.0)  # no direction is left out
    model = model_of(runs(0, 1), "mlr", points="T1,T4")
    at_once = updated(model, runs(2, 3, 4)).table
    whole = at_once["gaussian"]
    in_turn = model
    for run in reversed(runs(2, 3, 4)):
        in_turn = updated(in_turn, [run])
    found = in_turn.table["gaussian"]
    for name in ("weights", "noise"):
        size = np.abs(whole[name]).max()
        assert np.array(found[name]) == pytest.approx(np.array(whole[name]), abs=1e-4 * size)
    one, other = (np.array(table["seen"]) for table in (whole, found))
    assert one.T @ one == pytest.approx(other.T @ other, abs=1e-5 * max(whole["scale"]))
    assert found["rows"] == whole["rows"] > model.table["gaussian"]["rows"]
    others = [np.array(one.table["spare"]["precision"]) for one in (in_turn, model)]
    together = np.array(at_once["spare"]["precision"])
    assert others[0] == pytest.approx(together, rel=1e-6, abs=1e-6)
    assert others[1] != pytest.approx(together, rel=1e-2)
    assert {run["name"] for run in in_turn.provenance["runs"]} == {f"run{n}" for n in range(5)}


def test_an_update_forgets_nothing_that_the_old_runs_told():
    model = model_of(runs(0, 1, 2))
    short = make_run("short", 3, hours=0.5)
    before, after = (
        np.array(one.table["gaussian"]["seen"]) for one in (model, updated(model, [short]))
    )
    gained = np.linalg.eigvalsh(after.T @ after - before.T @ before)
    assert gained.min() > -1e-6 * max(model.table["gaussian"]["scale"])


def test_what_monitoring_said_of_a_thermometer_an_update_ends():
    def moved(seed: int) -> Run:
        (run,) = runs(seed)
        frame = run.frame.copy()
        frame["T4_degC"] += 3.0 * (frame["T4_degC"] - frame["T4_degC"].iloc[0])
        return Run(f"moved{seed}", frame)

    model = model_of(runs(0, 1, 2, 3))
    astray = Agreement(model).of(moved(4))
    assert astray.sensor == "T4"
    after = updated(model, [moved(5), moved(6)])
    assert Agreement(after).of(moved(4)) is None
    # It has learnt what the others say of it, and not only to believe them less.
    assert max(after.table["spare"]["growth"]) < 3.0 * max(model.table["spare"]["growth"])


def test_a_thermometer_that_another_copies_keeps_its_noise():
    exact = [make_run(f"run{seed}", seed, hours=2.0, noise=0.0) for seed in range(6)]
    model = model_of(exact[:2], points="T1,T2")
    known = updated(model, exact[2:]).table["spare"]["precision"]
    assert 1.0 / known[0][0] > NOISE_K**2


def test_what_the_old_one_left_of_the_new_runs_is_put_down():
    model, new = model_of(runs(0, 1)), runs(2, 3)
    table, before = update_compensator(model, new, created="2026-02-03")
    length = model.limits.judged_tool()
    for one, run in zip(before, new, strict=True):
        assert one == left_of(drive(model, run, run, RIG, length), run.name)
    told = table["provenance"]["figures"]["updated"]
    assert [one["run"] for one in told] == ["run2", "run3"]
    assert told[0]["axes"]["Z"]["model"] == before[0].axes["Z"].left
    assert table["created"] == "2026-02-03"
    unseen = table["provenance"]["figures"]["unseen"]
    assert unseen["like_behind"] == len(new)  # the promise comes from them
    assert 0.0 < unseen["promised"]["Z"]["model"] < unseen["promised"]["Z"]["no_model"]
    again, _ = update_compensator(parse_model(compensator_text(table), "u.json"), runs(4))
    told = again["provenance"]["figures"]["updated"]
    assert [one["run"] for one in told] == ["run2", "run3", "run4"]


def test_an_update_keeps_options_and_limits_and_widens_what_is_plausible():
    limits = {"hold_s": 77.0, "offset_um": 333.0, "share": 0.8}
    options = {"points": ["T1", "T4"], "name": "mine", "tool_length_mm": (0.0, 150.0)}
    old = model_of(runs(0, 1, 2), "bayes", limits=limits, **options)
    cold = make_run("cold", 3, hours=2.0, start=5.0)
    new = update_compensator(old, [cold])[0]
    assert new["error_model"] == old.table["error_model"]
    for name in ("chosen", "name", "limits", "geometry"):
        assert new[name] == old.table[name]
    for now, before in zip(new["sensors"], old.table["sensors"], strict=True):
        assert now["low"] < before["low"] - 10.0


def test_a_displacement_flipped_since_training_is_put_down():
    (run,) = runs(3)
    flipped = Run("flipped", run.frame.assign(**{name: -run.frame[name] for name in RIG.columns}))
    notes = updated(model_of(runs(0, 1, 2)), [flipped]).provenance["notes"]
    assert any("Z drifts with the opposite sign" in note and "flipped" in note for note in notes)


def test_two_thermometers_swapped_since_training_are_put_down():
    (run,) = runs(3)
    read = run.frame
    swapped = Run("swapped", read.assign(T1_degC=read["T4_degC"], T4_degC=read["T1_degC"]))
    model = model_of(runs(0, 1, 2))
    (note,) = (n for n in updated(model, [swapped]).provenance["notes"] if "swapped there?" in n)
    assert "T1 behaves like T4 in training" in note
    assert not any("swapped there?" in n for n in updated(model, [run]).provenance["notes"])


def test_a_run_is_known_in_whatever_file_it_is(tmp_path):
    first, second = (write_run(run, tmp_path / f"{run.name}.csv") for run in runs(0, 1))
    known = [read_run(first), read_run(second)]
    model = model_of(known, points="T1,T4")
    frame = known[1].frame[["time_s", *reversed(known[1].frame.columns[1:])]]
    text = frame.drop(columns="T2_degC").to_csv(index=False, float_format="%.14g")
    saved = tmp_path / "saved.csv"
    saved.write_bytes(text.replace("\n", "\r\n").encode())
    again = read_run(saved)
    assert "already in the compensator, as run1" in refusal(update_compensator, model, [again])
    assert monitor(model, [again]).verdict == LEARNT
    assert "is the same run as" in refusal(fit_compensator, [*known, again], RIG, sensors=["T1"])
    assert updated(model, runs(2)).provenance["runs"][2]["rows"] > 0
    table = copy.deepcopy(model.table)
    for run, entry in zip(known, table["provenance"]["runs"], strict=True):
        entry["sha256"] = run.sha256  # as earlier versions stored it
    old = parse_model(compensator_text(table), "old.json")
    assert "as run1" in refusal(update_compensator, old, [known[1]])


def test_a_file_that_leaves_nothing_to_learn_is_refused():
    model = model_of(runs(0, 1), points="T1,T4")
    scale = model.table["gaussian"]["scale"]
    scale[:] = [0.0] * len(scale)
    assert "gaussian.scale: leaves no variance" in refusal(update_compensator, model, runs(2))


def test_it_refuses_what_it_cannot_take_in():
    model = model_of(runs(0, 1, 2))
    assert "already in the compensator, as run2" in refusal(update_compensator, model, runs(2))
    lost = Run("lost", make_run("lost", 9).frame.drop(columns="T4_degC"))
    assert "T4_degC: is missing" in refusal(update_compensator, model, [lost])
    del model.provenance["rig"]
    assert "provenance.rig: is missing: fit it anew" in refusal(update_compensator, model, runs(3))
    # A run in which a thermometer died, or nothing was measured, teaches nothing.
    model = model_of(runs(0, 1, 2), points="T1,T4")
    (new,) = runs(3)
    rows = np.arange(len(new.frame))
    died = np.where(rows < len(rows) // 4, new.frame["T4_degC"], np.nan)
    with pytest.raises(BadInput, match="T4: missing in run3, and the compensator uses it"):
        update_compensator(model, [Run("run3", new.frame.assign(T4_degC=died))])
    first = np.where(rows < 2, new.frame["S1_um"], np.nan)
    later = np.where(rows < 1, np.nan, new.frame["S2_um"])
    with pytest.raises(BadInput, match="run3: has fewer than 2 rows with all displacements"):
        update_compensator(model, [Run("run3", new.frame.assign(S1_um=first, S2_um=later))])


def test_a_run_that_was_broken_off_counts_as_a_part_of_one():
    """It drifted little, and says little of what is left in whole runs."""
    table = fit_compensator(runs(0, 1, 2, 3), RIG, points="T1,T4")
    model = parse_model(compensator_text(table), "m.json")
    (new,) = runs(4)
    start = Run("start", new.frame[new.frame["time_s"] <= 360.0])
    before, after = (m.provenance["figures"]["unseen"] for m in (model, updated(model, [start])))
    assert after["like_behind"] == pytest.approx(4.05, abs=0.01)
    assert after["unlike_behind"] == pytest.approx(3.05, abs=0.01)
    for axis, row in before["promised"].items():
        assert after["promised"][axis]["model"] == pytest.approx(row["model"], rel=0.03)
    again = Run("again", start.frame + 0.001)
    after = updated(updated(model, [start]), [again]).provenance["figures"]["unseen"]
    assert after["like_behind"] == pytest.approx(4.1, abs=0.02)  # each counts as a part
    whole = updated(model, [new]).provenance["figures"]["unseen"]
    assert (whole["like_behind"], whole["unlike_behind"]) == (5, 4)
