"""A whole sweep: what it computes, that it goes on after a kill, and what it refuses."""

import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest

from measurement.errors import BadInput
from scenarios.cli import main
from scenarios.sweep.tables import as_text
from tests.patience import PATIENCE_S, until
from tests.scenarios.tiny_fmus import PLANT, build_tiny

SAME = ("sweep.csv", "sweep.parquet", "percentiles.csv", "summary.json", "percentiles.png")


def arguments(scenario: Path, fmus: Path, out: Path, *more: str) -> list[str]:
    return ["sweep", str(scenario), "--fmu-dir", str(fmus), "--out", str(out), *more]


def in_a_process(*words: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "scenarios.cli", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def recorded(out: Path) -> list[Path]:
    return sorted((out / "cases").glob("*.json")) if (out / "cases").is_dir() else []


def until_recorded(out: Path, count: int, process: subprocess.Popen[str]) -> None:
    def are_there() -> bool:
        assert process.poll() is None, process.communicate()
        return len(recorded(out)) >= count

    until(are_there)


@pytest.fixture
def closed(tiny_folder: Path, tmp_path: Path) -> Path:
    """A file; while it is there, a plant above 8000 r/min does not get through its step."""
    path = tmp_path / "closed"
    path.touch()
    usual = "if self.speed > 9000.0:"
    wait = f"while self.speed > 8000.0 and os.path.exists({str(path)!r}):\n"
    gated = PLANT.replace(usual, f"{wait}            time.sleep(0.01)\n        {usual}")
    (tiny_folder / "plant.fmu").write_bytes(
        build_tiny(f"import os, time\n{gated}", "GatedPlant", tmp_path / "gated").read_bytes()
    )
    return path


def test_the_table_holds_what_the_plant_does(sweep, tmp_path):
    found = sweep("out", "gain=1e-3,2e-3", "speed=1000,500")
    table = pd.read_csv(tmp_path / "out" / "sweep.csv", keep_default_na=False)
    assert len(table) == 4 * 3
    x = table[table["axis"] == "X"].set_index(["gain", "speed"])
    for (gain, speed), row in x.iterrows():
        # drift_X = 10 gain speed t over 20 s; its mean over 21 samples is half of it.
        assert row["before_max_um"] == pytest.approx(10.0 * gain * speed * 20.0)
        assert row["before_mean_um"] == pytest.approx(5.0 * gain * speed * 20.0)
        # The compensator is two steps late.
        assert row["after_max_um"] == pytest.approx(10.0 * gain * speed * 2.0)
        assert row["valid_percent"] == 100.0
    assert found["cases"] == 4
    assert found["failed"] == 0
    axis = found["variants"]["main"]["axes"]["X"]
    assert axis["percentiles"]["before_max_um"][1] == pytest.approx(200.0)
    assert axis["worst"]["values"] == {"gain": 2e-3, "speed": 1000}
    assert pd.read_parquet(tmp_path / "out" / "sweep.parquet").shape == table.shape
    last = pd.read_csv(tmp_path / "out" / "percentiles.csv").iloc[-1]
    assert last["time_s"] == 20.0
    for percentile in (5, 50, 95):
        expected = x["before_max_um"].quantile(percentile / 100)
        assert last[f"drift_X_p{percentile}_um"] == pytest.approx(expected, abs=1e-3)
    assert found["files"] == ["sweep.csv", "sweep.parquet", "percentiles.csv", "percentiles.png"]


@pytest.mark.usefixtures("drawn")
@pytest.mark.long
def test_any_number_of_workers_gives_the_same_files(sweep, tmp_path):
    for workers in (1, 2):
        sweep(str(workers), "gain=1e-3..2e-3", "tool_length=1,2", workers=workers, repeat=3)
    for name in SAME:
        one, two = ((tmp_path / str(n) / name).read_bytes() for n in (1, 2))
        assert one == two, name


def nobody_is_left(process: subprocess.Popen[str]) -> bool:
    """Return whether the group of what had a session of its own is empty."""
    try:
        os.killpg(process.pid, 0)
    except ProcessLookupError:
        return True
    return False


@pytest.mark.usefixtures("drawn")
@pytest.mark.long
def test_a_killed_sweep_ends_with_its_workers_and_goes_on_and_comes_to_the_same(
    tiny_scenario, tiny_folder, closed, tmp_path
):
    more = ["--vary", "speed=1000,2000,8500,8600", "--quiet"]
    words = arguments(tiny_scenario, tiny_folder, tmp_path / "out", "--workers", "2", *more)
    first = in_a_process(*words)
    until_recorded(tmp_path / "out", 2, first)
    first.kill()
    first.communicate()
    there = {path: path.stat().st_mtime_ns for path in recorded(tmp_path / "out")}
    assert len(there) == 2
    assert closed.exists()  # no worker gets through
    until(lambda: nobody_is_left(first))
    closed.unlink()
    assert not (tmp_path / "out" / "sweep.csv").exists()
    second = in_a_process(*words)
    assert second.communicate() == ("", "")
    assert second.returncode == 0
    assert len(recorded(tmp_path / "out")) == 4
    for path, time_ns in there.items():
        assert path.stat().st_mtime_ns == time_ns, "a case that had ended ran again"
    assert main(arguments(tiny_scenario, tiny_folder, tmp_path / "whole", *more)) == 0
    for name in SAME:
        assert (tmp_path / "out" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()


@pytest.mark.long
@pytest.mark.parametrize("workers", ["1", "2"])
def test_an_interrupted_sweep_says_how_to_go_on(
    tiny_scenario, tiny_folder, closed, tmp_path, workers
):
    more = ["--vary", "speed=1000,8500,8600", "--workers", workers]
    process = in_a_process(*arguments(tiny_scenario, tiny_folder, tmp_path / "out", *more))
    until_recorded(tmp_path / "out", 1, process)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does
    closed.unlink()  # the cases that run end
    out, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 130
    assert out == ""
    assert err == (
        f"spindle-drift: interrupted; the same command goes on from {tmp_path / 'out'}\n"
    )


def test_a_sweep_interrupted_before_a_case_has_ended_does_not_promise_to_go_on(
    tiny_scenario, tiny_folder, tmp_path, monkeypatch, capsys
):
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("scenarios.sweep.runner.on_cores", interrupt)
    words = arguments(tiny_scenario, tiny_folder, tmp_path / "out", "--vary", "speed=1000,2000")
    assert main(words) == 130
    assert capsys.readouterr().err == "spindle-drift: interrupted; no case has ended yet\n"


OTHERWISE = {
    "--repeat is 2, not 3": {"repeat": 3},
    "--seed is 1, not 5": {"seed": 5},
    '--vary is ["gain=1,2"], not ["gain=1,3"]': {"vary": ("gain=1,3",)},
    '--set is [], not [["step_s", "0.5"]]': {"overrides": (("step_s", 0.5),)},
}


def test_another_sweep_does_not_go_into_the_same_folder(sweep, tmp_path):
    sweep("out", "gain=1,2", repeat=2)
    before = {path: path.stat().st_mtime_ns for path in (tmp_path / "out").rglob("*")}
    for message, change in OTHERWISE.items():
        settings = {"vary": ("gain=1,2",), "repeat": 2} | change
        with pytest.raises(BadInput, match=re.escape(f"holds another sweep ({message}): choose")):
            sweep("out", *settings.pop("vary"), **settings)
    assert before == {path: path.stat().st_mtime_ns for path in (tmp_path / "out").rglob("*")}


def test_other_fmus_or_another_text_are_another_sweep(sweep, tiny_scenario, tiny_folder, tmp_path):
    sweep("out")
    (tiny_folder / "plant.fmu").write_bytes(
        build_tiny(PLANT, "OtherPlant", tmp_path / "other").read_bytes()
    )
    with pytest.raises(BadInput, match="its FMUs differ"):
        sweep("out")
    tiny_scenario.write_text(tiny_scenario.read_text() + "# a word\n")
    with pytest.raises(BadInput, match="the scenario's text differs"):
        sweep("out")


def test_a_folder_of_something_else_is_left_alone(sweep, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "thesis.txt").write_text("years of work")
    with pytest.raises(BadInput, match="holds files and no sweep"):
        sweep("out")
    (tmp_path / "file").write_text("")
    with pytest.raises(BadInput, match="is a file; a folder"):
        sweep("file")
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["thesis.txt"]


def test_a_damaged_case_is_run_again(sweep, tmp_path):
    sweep("out", "gain=1,2")
    case, table = tmp_path / "out" / "cases" / "000001.json", tmp_path / "out" / "sweep.csv"
    whole, rows = case.read_bytes(), table.read_bytes()
    case.write_bytes(whole[:100])
    sweep("out", "gain=1,2")
    assert case.read_bytes() == whole
    assert table.read_bytes() == rows


def test_a_case_that_fails_is_told_and_the_others_count(
    tiny_scenario, tiny_folder, tmp_path, capsys
):
    words = arguments(tiny_scenario, tiny_folder, tmp_path / "out", "--vary", "speed=1000,9500,500")
    assert main([*words, "--workers", "1", "--json"]) == 1
    said = capsys.readouterr()
    assert said.err.count("\n") == 1
    assert "1 of 3 cases failed: plant FMU at 0 s: the step failed" in said.err
    found = json.loads(said.out)
    assert (found["cases"], found["failed"]) == (3, 1)
    table = pd.read_csv(tmp_path / "out" / "sweep.csv", keep_default_na=False)
    assert table["case"].tolist() == [0, 0, 0, 1, 2, 2, 2]
    assert "bursts at 9000 r/min" in table.loc[3, "problem"]
    assert (table.drop(index=3)["problem"] == "").all()


@pytest.mark.long
def test_a_case_that_takes_its_process_down_loses_no_other(sweep, tiny_folder, tmp_path):
    stop = "if self.speed > 8000.0:\n            os._exit(9)"
    deadly = "import os\n" + PLANT.replace("if self.speed > 9000.0:", stop)
    (tiny_folder / "plant.fmu").write_bytes(
        build_tiny(deadly, "DeadlyPlant", tmp_path / "deadly").read_bytes()
    )
    found = sweep("out", "speed=1000,8500,500,2000", workers=2)
    assert (found["cases"], found["failed"]) == (4, 1)
    assert found["problems"] == ["its process ended twice without a result, the second time alone"]
    table = pd.read_csv(tmp_path / "out" / "sweep.csv")
    assert sorted(table.dropna(subset="before_max_um")["speed"].unique()) == [500, 1000, 2000]


def test_what_drives_the_error_is_named(sweep):
    found = sweep("out", "gain=1e-3..2e-3", "noise_seed=1..9:2", "speed=1000", repeat=12)
    axis = found["variants"]["main"]["axes"]["X"]
    assert axis["rank_correlation"] == {"gain": 1.0}
    assert "main     X     gain +1.00" in as_text(found)
