"""Every shipped scenario, shortened, with the project's own FMUs; and what the FMU finder does."""

import json
import math
import shutil
from pathlib import Path

import numpy as np
import pytest

from measurement.errors import BadInput
from plant_model.fmi_slave import MACHINE_FILE
from scenarios import build_command
from scenarios.cli import main
from scenarios.cosimulation import simulate
from scenarios.fmu_file import member
from scenarios.fmu_files import check_fmus, find_fmu
from scenarios.runner import run_scenario
from scenarios.scenario import library, read_scenario
from scenarios.signals.base import Setting

SIMULATED = [path.stem for path in library() if read_scenario(path).cases]


def in_c(folder: Path) -> list[Path]:
    return [folder / f"{kind}_native.fmu" for kind in ("plant", "compensator")]


@pytest.mark.parametrize("name", SIMULATED)
def test_every_scenario_runs(name, shipped_in_c):
    for case in read_scenario(name, [("duration_s", 300)]).cases:
        found = simulate(case, *in_c(shipped_in_c), quiet=True)
        frame = found.frame
        for axis in "XYZ":
            total = (frame[f"drift_{axis}_um"] + frame[f"offset_{axis}_um"]).to_numpy()
            assert frame[f"error_{axis}_um"].to_numpy() == pytest.approx(total, abs=1e-9)
        assert len(frame) == 301


@pytest.mark.parametrize("name", SIMULATED)
def test_every_scenario_keeps_to_what_its_machine_is_meant_for(name):
    for case in read_scenario(name).cases:
        time = np.arange(0.0, case.settings.duration_s, 10.0)
        for key, low, high in (
            ("speed", 0.0, 20_000.0),
            ("ambient", 10.0, 40.0),
            ("coolant_inlet", 10.0, 40.0),
            ("tool_length", 0.0, 260.0),
        ):
            if key in case.signals:
                setting = Setting("x", f"signals.{key}", Path(), case.settings.seed)
                values = case.signals[key].values(time, setting)
                assert low <= values.min() <= values.max() <= high, key
        for fault in case.settings.faults:
            assert fault.start_s < case.settings.duration_s


@pytest.mark.long
def test_the_main_scenario_shows_what_it_is_for(shipped_in_c, tmp_path):
    scenario = read_scenario("step_speed", [("step_s", 5)])
    table, groups, _ = run_scenario(scenario, tmp_path / "out", shipped_in_c, quiet=True)
    short, long = groups
    for group in groups:
        reference, known, blind = group.rows
        for axis in "XYZ":
            assert known.axes[axis].after_mean_um < 0.6 * reference.axes[axis].after_mean_um
        # What the tilt does to X and Y is left over by a compensator that knows no length.
        for axis in "XY":
            assert known.axes[axis].after_mean_um < blind.axes[axis].after_mean_um
    for axis in "XY":
        left = [group.rows[2].axes[axis].after_mean_um for group in (short, long)]
        assert left[1] > left[0]
    assert {row["name"] for group in table["table"] for row in group["rows"]} >= {"long_tool"}


@pytest.mark.parametrize("lost", ["speed", "tool_length"])
def test_a_compensator_that_never_starts_says_why(lost, shipped_in_c, tmp_path):
    faults = [{"sensor": lost, "kind": "missing", "start_s": 0}]
    changes = [("duration_s", 60), ("faults", faults), ("variants", [])]
    scenario = read_scenario("step_speed", changes)
    table, _, _ = run_scenario(scenario, tmp_path / "out", shipped_in_c, quiet=True)
    (note,) = table["notes"]
    assert note.endswith(f"never started: waiting for the first valid sample: {lost} is missing.")
    assert note in (tmp_path / "out/report.html").read_text()


@pytest.mark.long
def test_missing_fmus_are_built(shipped_in_c, tmp_path, monkeypatch, capsys):
    def build(arguments: list[str]) -> int:  # as it does, but for the time that it takes
        _, kind, _, out = arguments
        Path(out).mkdir(exist_ok=True)
        for file in (f"{kind}.fmu", f"{kind}_native.fmu"):
            shutil.copy(shipped_in_c / file, out)
        print("built")
        return 0

    monkeypatch.setattr(build_command, "main", build)
    out, dist = tmp_path / "out", tmp_path / "dist"
    argv = ["run", "iso230_3", "--fmu-dir", str(dist), "--out", str(out), "--set", "duration_s=60"]
    assert main([*argv, "--json"]) == 0
    shown = capsys.readouterr()
    assert json.loads(shown.out)["scenario"]["name"] == "iso230_3"
    assert shown.err == "built\n" * 2
    monkeypatch.setattr(build_command, "main", None)
    assert main([*argv, "--quiet"]) == 0


@pytest.mark.parametrize("text", [None, "{}", "no archive"])
@pytest.mark.parametrize("command", [("run", "--out"), ("sweep", "--out"), ("ssp", "-o")])
def test_a_compensator_that_cannot_be_used_is_refused_before_a_plant_is_built(
    command, text, tmp_path, monkeypatch, refused
):
    monkeypatch.setattr(build_command, "main", None)
    name, out = command
    broken = tmp_path / ("broken.json" if text == "{}" else "broken.fmu")
    if text:
        broken.write_text(text)
    argv = [name, "iso230_3", "--fmu-dir", str(tmp_path / "dist"), out, str(tmp_path / "out")]
    problem = {None: "there is no such file", "{}": "kind: is missing"}.get(text, "is not an FMU")
    assert f"{broken}: {problem}" in refused([*argv, "--set", f"compensator.fmu={broken}"])
    assert set(tmp_path.iterdir()) <= {broken}


def test_a_live_page_without_a_compensator_is_refused_before_a_plant_is_built(
    tmp_path, monkeypatch, refused
):
    monkeypatch.setattr(build_command, "main", None)
    argv = ["run", "no_compensation", "--fmu-dir", str(tmp_path / "dist"), "--live"]
    said = refused([*argv, "--out", str(tmp_path / "out")])
    assert said.endswith("compensator: is none, so there is no live page")
    assert list(tmp_path.iterdir()) == []


def test_an_fmu_that_is_not_there_is_refused_with_the_nearest_name(tiny_folder, tmp_path):
    with pytest.raises(BadInput, match=r"did you mean plant\.fmu\?"):
        find_fmu("plannt.fmu", tiny_folder, tmp_path, tmp_path)
    with pytest.raises(BadInput, match=r"is not a path|there is no such file"):
        find_fmu("a\0b", tiny_folder, tmp_path, tmp_path)


def test_a_compensator_that_needs_what_nobody_gives_is_refused(shipped, simulated):
    with pytest.raises(BadInput, match=r"needs T2, .*T11, which is neither an output"):
        simulated(compensator=shipped / "compensator.fmu")


@pytest.mark.long
def test_a_machine_file_is_built_into_a_plant(shipped, tmp_path):
    import plant_model

    machine = Path(plant_model.__file__).parent / "machines" / "jig_borer_lumps.toml"
    argv = ["run", "iso230_3", "--fmu-dir", str(shipped), "--out", str(tmp_path / "out")]
    assert main([*argv, "--plant", str(machine), "--set", "duration_s=60", "--quiet"]) == 0
    table = json.loads((tmp_path / "out" / "table.json").read_text())
    assert math.isfinite(table["table"][0]["rows"][0]["axes"]["Z"]["before_max_um"])


def test_a_shipped_machine_is_a_plant_by_its_name(tiny_folder, tmp_path):
    check_fmus(["lathe"], (), tiny_folder, tmp_path)
    fmu = find_fmu("lathe", tiny_folder, tmp_path, tmp_path)
    assert json.loads(member(fmu, f"resources/{MACHINE_FILE}") or "{}")["name"] == "lathe"
