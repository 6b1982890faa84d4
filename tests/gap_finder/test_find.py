"""From runs to a named effect, a machine file and the gap on a run that was never used."""

import base64
import json
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gap_finder.calibrate import ParameterEstimate
from gap_finder.candidates import beyond_usual_range, with_effect
from gap_finder.find import (
    ALSO_MISSING,
    GapResult,
    Judged,
    find_gap,
    is_closed_where_better,
    unusual_law,
)
from gap_finder.observations import observe
from gap_finder.search import Search
from measurement.runs import write_run
from plant_model.effects import catalogue
from plant_model.machine_file import read_machine
from plant_model.machine_writer import write_machine
from scenarios.cli import main
from scenarios.pages.report import PLOTLY
from tests.gap_finder.conftest import runs_of
from tests.plant_model.conftest import with_effects
from tests.refusing import refusal

# A few rivals suffice to show the way; the whole catalogue is for the benchmark.
RIVALS = ("friction_speed_exponent", "centrifugal_shift", "windage")
LEFT_OUT = [name for name in catalogue() if name not in RIVALS]


@pytest.mark.usefixtures("drawn")
@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "number", "size"),
    # The second depends on temperature and has two drivers, which takes a minute.
    [("friction_speed_exponent", "deviation", 0.4), ("thermal_preload", "gain", 0.3)],
)
def test_a_hidden_effect_is_named_added_and_closes_the_gap(
    name, number, size, jig_borer_lumps, tmp_path, capsys
):
    truth = with_effect(jig_borer_lumps, name, {number: size})
    paths = [str(write_run(run, tmp_path / f"{run.name}.csv")) for run in runs_of(truth)]
    out = tmp_path / "out"
    arguments = ["find-gap", "jig_borer_lumps", "--runs", *paths[:3], "--holdout", paths[3]]
    left_out = [other for other in LEFT_OUT if other != name]
    assert main([*arguments, "--out", str(out), "--without", *left_out, "--quiet"]) == 0
    table = json.loads((out / "gap.json").read_text())
    assert table["verdict"] == "effect"
    (effect,) = table["effects"]
    assert effect["name"] == name
    found = effect["parameters"][number]
    # Other numbers have soft ranges and give way to it, and of two drivers that do the same in
    # these runs it may be given the other.
    assert found["value"] == pytest.approx(size, rel=0.3)
    gap = table["gap"]["holdout"]
    assert gap["after"] < 0.2 * gap["before"]
    after = read_machine(out / "machine_after.toml")
    (key,) = (key for key in after.effects if key.partition(":")[0] == name)
    assert after.effects[key][number].value == found["value"]
    page = (out / "report.html").read_text("utf-8")
    assert base64.b64encode(PLOTLY.read_bytes()).decode() in page
    assert "Plotly.newPlot" in page
    assert len(list(out.glob("residual_*.png"))) == 2
    assert len(list(out.glob(f"signature_{name}_*.png"))) == 1
    assert len(capsys.readouterr().out.strip().splitlines()) == 6


def test_nothing_is_named_when_nothing_is_missing(jig_borer_lumps):
    runs = runs_of(jig_borer_lumps, 60.0, seed=7)
    first = find_gap(jig_borer_lumps, runs[:3], Search(LEFT_OUT))
    assert first.keys == ()
    assert Judged.of(first, observe(jig_borer_lumps, runs[3:])).verdict == "none_missing"
    assert first.after is first.before
    # The order in which runs are given changes nothing.
    second = find_gap(jig_borer_lumps, runs[2::-1], Search(LEFT_OUT, most=0))
    assert first.before.cost == second.before.cost


def test_too_few_runs_and_a_machine_at_rest_are_refused(jig_borer_lumps):
    runs = runs_of(jig_borer_lumps)
    assert "3 or more are needed" in refusal(find_gap, jig_borer_lumps, runs[:2])
    for run in runs:
        run.frame["speed_rpm"] = 0.0
    assert "stands still" in refusal(find_gap, jig_borer_lumps, runs)


def test_a_written_machine_reads_back_and_keeps_its_comments(jig_borer_lumps, tmp_path):
    moved = with_effects(jig_borer_lumps, "radiation", "sensor_offset").with_values(
        {"sources.motor.loss": 25.5, "effects.sensor_offset:T1.error": -3.0}
    )
    path = write_machine(moved, "jig_borer_lumps", tmp_path / "after.toml")
    assert read_machine(path) == moved
    assert "# Jackets: one each" in path.read_text()
    assert "not the file" in refusal(write_machine, jig_borer_lumps, path, tmp_path / "other.toml")


@pytest.mark.long
def test_a_loss_far_beyond_its_usual_range_is_named_and_said_to_be_large(jig_borer_lumps, tmp_path):
    truth = with_effect(jig_borer_lumps, "windage", {"power": 1500.0})
    runs = runs_of(truth)
    found = find_gap(jig_borer_lumps, runs[:3], Search(LEFT_OUT))
    assert found.keys == ("windage",)
    assert beyond_usual_range(found.after.machine, "windage") == ("power",)
    power = found.after.machine.parameters["effects.windage.power"]
    assert power.value == pytest.approx(1500.0, rel=0.15)
    # Beyond the catalogue's range, and read back all the same.
    path = write_machine(found.after.machine, "jig_borer_lumps", tmp_path / "after.toml")
    assert read_machine(path).effects["windage"]["power"] == power


@pytest.mark.parametrize("coarse", [0.7, 2.0])
@pytest.mark.parametrize(
    ("missing", "left", "closed"),
    [
        (40.0, 1.0, True),  # as much as elsewhere
        (40.0, 2.5, True),  # more, but by chance in four values
        (40.0, 2.9, False),
        (80.0, 2.9, True),  # as much as a right law may leave of so much
    ],
)
def test_a_name_is_judged_where_it_acts_by_what_is_left_elsewhere(missing, left, closed, coarse):
    before, after = np.full((4, 12), coarse), np.full((4, 12), coarse)
    before[:, 2], after[:, 2] = coarse * missing, coarse * left
    assert is_closed_where_better(before, after) is closed


def test_a_name_that_acts_everywhere_alike_has_nowhere_to_be_judged_by():
    assert is_closed_where_better(np.full((4, 12), 9.0), np.full((4, 12), 2.0))


@pytest.mark.parametrize(
    ("course", "acting", "doubt"),
    [
        ((2.0, 1.9), 0.7, ""),
        ((5.0, 3.0, 2.0), 0.7, ""),
        ((2.0, 2.0), 0.7, "windage does not improve the prediction of the held-out run"),
        ((5.0, 1.5, 2.0), 0.7, "tool b does not improve the prediction of the held-out run"),
        # Over twice the regression's.
        ((5.0, 3.1), 0.7, ALSO_MISSING),
        ((5.0, 3.1), 2.03, "more error remains where it acts than elsewhere"),
        ((2.0, 1.9), 2.03, "more error remains where it acts than elsewhere"),
    ],
)
def test_a_name_is_in_doubt_for_what_it_leaves_and_for_unseen_runs(course, acting, doubt):
    gap = {"before": course[0], "after": course[-1], "reference": 1.5}
    unseen: Any = SimpleNamespace(
        gap=lambda: gap, gap_against=lambda known: gap, worst=lambda: gap["after"]
    )
    before, after = np.full((4, 12), 0.7), np.full((4, 12), 0.7)
    before[:, 2], after[:, 2] = 28.0, acting
    names = ("windage", "tool:b")[: len(course) - 1]
    found: Any = SimpleNamespace(
        keys=names,
        stages=[SimpleNamespace(keys=names[:count]) for count in range(len(course))],
        before=SimpleNamespace(left=before, left_each=before.mean()),
        after=SimpleNamespace(
            left=after, left_each=after.mean(), calibration=SimpleNamespace(parameters=())
        ),
    )
    reference: Any = SimpleNamespace(used=(), unseen=())
    judged = Judged(found, unseen, unseen, reference, course)
    assert judged.doubt == doubt
    assert judged.doubted == ((names[-1:] if "not improve" in doubt else names) if doubt else ())
    found.keys = ()
    assert Judged(found, unseen, unseen, reference, course).doubt == ""


@pytest.mark.parametrize(
    ("number", "low", "value", "high", "doubt"),
    [
        ("growth", 80.0, 90.0, 100.0, ""),  # sizes may be any
        ("hours", 4.0, 6.0, 9.0, ""),
        ("hours", 0.9, 2.6, 7.0, ""),  # may be usual
        ("hours", 0.3, 0.35, 0.9, "slow_structure bed needs hours of 0.35, outside the usual 3"),
        ("hours", 22.0, 25.0, 30.0, "slow_structure bed needs hours of 25, outside the usual 3"),
    ],
)
def test_a_law_that_needs_an_unusual_number_is_in_doubt(number, low, value, high, doubt):
    key = "slow_structure:bed"
    estimates = [
        ParameterEstimate("nodes.bed.capacity", "J/K", 1e5, 1.0, 0.5, 2.0, 0.5, False),
        ParameterEstimate(f"effects.{key}.{number}", "h", 5.0, value, low, high, 0.5, False),
    ]
    said = unusual_law(estimates, (key,))
    assert said.startswith(doubt)
    assert bool(said) == bool(doubt)
    assert unusual_law(estimates, ("windage",)) == ""


def test_a_name_that_gave_way_to_a_better_one_is_no_stage_of_the_result():
    """A path beside the missing one predicts the held-out run as well, and is then replaced."""
    paths = [(), ("heat_path:housing+slide",), ("heat_path:clamp+slide",)]
    nothing, beside, right = (SimpleNamespace(keys=keys) for keys in paths)
    taken = ((nothing, True), (beside, True), (right, False))
    steps = [SimpleNamespace(baseline=one, is_taken=was) for one, was in taken]
    search: Any = SimpleNamespace(best=right, steps=steps)
    assert GapResult(search).stages == (nothing, right)
    both = SimpleNamespace(keys=(*right.keys, "windage"))
    search = SimpleNamespace(best=both, steps=steps)
    assert GapResult(search).stages == (nothing, right, both)


@pytest.mark.parametrize(("unseen", "verdict"), [(1.9, "none_missing"), (2.1, "unknown")])
def test_a_model_that_fits_the_runs_used_is_not_adequate_if_it_fails_the_held_out_one(
    unseen, verdict
):
    here, there = (
        SimpleNamespace(
            gap_against=lambda known, gap=gap: {"after": gap, "reference": gap}, worst=lambda: 1.0
        )
        for gap in (0.8, unseen)
    )
    fit = SimpleNamespace(left_each=0.7)
    found: Any = SimpleNamespace(keys=(), before=fit, after=fit)
    reference: Any = SimpleNamespace(used=(), unseen=())
    assert Judged(found, here, there, reference, (unseen,)).verdict == verdict  # type: ignore[arg-type]
