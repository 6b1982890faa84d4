"""The gap finder's command: what it refuses, what it leaves out, its folder, its FMUs."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gap_finder.candidates import with_effect
from gap_finder.observations import observe
from measurement.runs import Run
from plant_model.effects import catalogue
from plant_model.machine import Machine
from plant_model.machine_file import read_machine
from plant_model.machine_writer import write_machine
from plant_model.sensors import column_of
from plant_model.simulate import simulate
from scenarios import gap_cosimulation, gap_runner
from scenarios.cli import main
from scenarios.fmu_files import build_plant
from scenarios.gap_cosimulation import compare_fmus
from tests.gap_finder.conftest import runs_of
from tests.scenarios.conftest import written

RIVALS = ("thermal_preload", "friction_speed_exponent", "centrifugal_shift")
LEFT_OUT = [name for name in catalogue() if name not in RIVALS]


@pytest.fixture(scope="module")
def machine() -> Machine:
    return read_machine("jig_borer_lumps")


@pytest.fixture(scope="module")
def tightening(machine: Machine) -> Machine:
    return with_effect(machine, "thermal_preload", {"gain": 0.3})


@pytest.fixture
def refusal(tmp_path, refused) -> Callable[..., str]:
    """What the command says of runs of which the last is held out; it leaves no folder."""

    def said(*runs: Run) -> str:
        *paths, last = written(tmp_path, *runs)
        out = tmp_path / "out"
        asked = ["find-gap", "jig_borer_lumps", "--runs", *paths, "--holdout", last]
        line = refused([*asked, "--out", str(out), "--quiet"])
        assert not out.exists()
        return line

    return said


def test_a_run_is_not_judged_on_what_it_was_fitted_to(machine, refusal):
    runs = runs_of(machine)
    assert "is the same run as" in refusal(*runs, runs[1])


def test_a_held_out_run_without_readings_is_refused(machine, refusal):
    *runs, last = runs_of(machine)
    driving = {entry.column for entry in machine.inputs} | {"time_s"}
    frame = last.frame[[name for name in last.frame if name in driving]]
    line = refusal(*runs, Run(last.name, frame))
    assert "--holdout" in line
    assert last.name in line


@pytest.mark.parametrize("command", ["find-gap", "calibrate"])
@pytest.mark.parametrize("empty", [False, True])
def test_a_run_without_what_drives_the_machine_is_refused(
    command, empty, machine, tmp_path, refused
):
    run = runs_of(machine)[0]
    frame = run.frame.drop(columns="speed_rpm")
    paths = written(tmp_path, Run(run.name, frame.assign(speed_rpm=np.nan) if empty else frame))
    options = ["--runs", *paths, "--holdout", *paths, "--out", str(tmp_path / "out")]
    if command == "calibrate":
        options = [*paths, "-o", str(tmp_path / "out")]
    if command == "find-gap":
        other = written(tmp_path, replace(run, name="other"))
        options[options.index("--holdout") + 1] = other[0]
    line = refused([command, "jig_borer_lumps", *options, "--quiet"])
    told = "column speed_rpm: has no value" if empty else "has no column speed_rpm, which"
    assert f"{paths[0]}: {told}" in line


@pytest.mark.parametrize("place", [1, 3])
def test_a_run_whose_clock_leaps_by_months_is_refused_before_the_work(place, machine, refusal):
    runs = runs_of(machine)
    time = runs[place].time_s + 3e7 * (runs[place].time_s > 5000.0)
    runs[place] = replace(runs[place], frame=runs[place].frame.assign(time_s=time))
    assert f"{runs[place].name}.csv: column time_s: 30005010.0 after 4980.0" in refusal(*runs)


def test_too_few_runs_that_can_be_used(machine, refusal):
    runs = runs_of(machine)
    hall = runs[0].frame["T5_degC"] + np.where(runs[0].time_s > 3000.0, 20.0, 0.0)
    broken = Run(runs[0].name, runs[0].frame.assign(T5_degC=hall))
    line = refusal(broken, *runs[1:])
    assert "only 2 of 3 can be used" in line
    assert "T5" in line


def test_nothing_is_left_of_a_folder_when_something_fails(machine, tmp_path, monkeypatch):
    paths = written(tmp_path, *runs_of(machine))

    def fails(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(gap_runner, "answer", fails)
    out = tmp_path / "out"
    assert (
        main(["find-gap", "jig_borer_lumps", "--runs", *paths, "--out", str(out), "--quiet"]) == 130
    )
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(
        Path(path).name for path in paths
    )


def test_an_fmu_that_shows_what_was_measured_leaves_nothing(machine):
    (observed,) = observe(machine, runs_of(machine, every_s=30.0)[:1])
    frame = observed.run.frame
    shown = {n: frame[column_of(machine, n)].to_numpy() for n in observed.channels}
    found = pd.DataFrame(shown, observed.run.time_s)
    left = gap_cosimulation.residuals_of(found, machine, observed).values
    assert np.abs(left).max() == 0.0


@pytest.mark.long
def test_the_fmus_show_the_gap_that_the_machines_show(machine, tightening, tmp_path):
    run = runs_of(tightening, every_s=60.0)[0]
    built = []
    for name, which in (("plant_before", machine), ("plant_after", tightening)):
        path = write_machine(which, "jig_borer_lumps", tmp_path / f"{name}.toml")
        built.append((build_plant(str(path), tmp_path, name), which))
    found = compare_fmus(built[0], built[1], observe(machine, [run]))
    assert found["after"] < 2.0
    assert found["before"] > 5.0 * found["after"]
    assert found["channels"]["T1"]["after"] < 0.2 < found["channels"]["T1"]["before"]
    stepped = gap_cosimulation.cosimulate(*built[1], run)
    longest = gap_cosimulation.FINE_S
    same = simulate(tightening, run.frame, step_s=longest, at=stepped.index.to_numpy()).readings
    for name, own in stepped.items():
        # Inputs are held in each step, and readings have steps of their own [K, um].
        assert np.max(np.abs(same[name][0] - own)) < 0.05, name


@pytest.mark.long
def test_broken_channels_do_not_hide_what_is_missing(tightening, tmp_path, prints):
    runs = runs_of(tightening)
    t7 = runs[1].frame["T7_degC"] + 31.0
    s3 = runs[2].frame["S3_um"] + np.where(runs[2].time_s > 5000.0, 60.0, 0.0)
    t2 = runs[3].frame["T2_degC"] + np.where(np.arange(len(runs[3].time_s)) == 250, 30.0, 0.0)
    runs[1] = Run(runs[1].name, runs[1].frame.assign(T7_degC=t7))
    runs[2] = Run(runs[2].name, runs[2].frame.assign(S3_um=s3))
    runs[3] = Run(runs[3].name, runs[3].frame.assign(T2_degC=t2))
    paths, out = written(tmp_path, *runs), tmp_path / "out"
    arguments = ["find-gap", "jig_borer_lumps", "--runs", *paths[:3], "--holdout", paths[3]]
    arguments += ["--out", str(out), "--without", *LEFT_OUT, "--quiet"]
    lines = prints(arguments).splitlines()
    assert "Left out as broken: T7 (wrong level in stairs); T2 (jumping in steady); S3" in lines[1]
    table = json.loads((out / "gap.json").read_text())
    assert [(f["run"], f["channel"], f["kind"]) for f in table["data_faults"]] == [
        ("stairs", "T7", "level_jump"),
        ("steady", "T2", "spikes"),
        ("stops", "S3", "step"),
    ]
    assert [effect["name"] for effect in table["effects"]] == ["thermal_preload"]
    both = table["cosimulation"]
    assert both["after"] < 0.2 * both["before"]
    assert both["after"] == pytest.approx(table["gap"]["holdout"]["after"], rel=0.1)
    assert "stops, S3_um, 84 to 180 min: leaps by" in (out / "report.html").read_text()
    listed = json.loads((out / "table.json").read_text())["files"]
    assert sorted(path.name for path in out.iterdir()) == sorted(listed)
    assert {"plant_before.fmu", "plant_after.fmu", "machine_before.toml"} <= set(listed)
