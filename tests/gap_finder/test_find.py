"""From runs to a named effect, a machine file and the gap on a run that was never used."""

import base64
import json
from types import SimpleNamespace
from typing import Any

import pytest

from gap_finder.candidates import beyond_usual_range, with_effect
from gap_finder.find import Judged, find_gap
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
    told: list[str] = []
    alone = Search(LEFT_OUT, most=0)
    second = find_gap(jig_borer_lumps, runs[2::-1], alone, progress=told.append)
    assert first.before.cost == second.before.cost
    assert "listing what may be missing" not in told, "nothing could be added"


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


TOO_MUCH, TOO_LITTLE = "too much error remains", "a regression on the inputs closes more than twice"


@pytest.mark.parametrize(
    ("before", "after", "reference", "left", "doubt"),
    [
        (5.0, 1.9, 1.5, 0.7, ""),
        (5.0, 3.3, 1.7, 0.7, ""),  # half of what can be closed
        (5.0, 3.4, 1.71, 0.7, TOO_LITTLE),
        (2.0, 2.1, 1.5, 0.7, TOO_LITTLE),
        (5.0, 3.1, 1.5, 0.7, TOO_MUCH),  # more than twice the regression's
        (5.0, 1.9, 1.5, 2.0, TOO_MUCH),
    ],
)
def test_a_name_is_in_doubt_for_what_it_leaves(before, after, reference, left, doubt):
    gap = {"before": before, "after": after, "reference": reference}
    runs: Any = SimpleNamespace(gap_against=lambda known: gap, worst=lambda: after)
    found: Any = SimpleNamespace(
        keys=("windage",),
        before=SimpleNamespace(left_each=4.0),
        after=SimpleNamespace(left_each=left),
    )
    reference: Any = SimpleNamespace(used=(), unseen=())
    assert Judged(found, runs, runs, reference).doubt.startswith(doubt)
    assert bool(Judged(found, runs, runs, reference).doubt) == bool(doubt)
    found.keys = ()
    assert Judged(found, runs, runs, reference).doubt == ""


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
    assert Judged(found, here, there, reference).verdict == verdict  # type: ignore[arg-type]
