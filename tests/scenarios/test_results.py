"""The results folder: whole or not at all, and never somebody else's."""

import json
from pathlib import Path

import pytest

from measurement.errors import BadInput
from measurement.files import write_atomically
from measurement.runs import read_run
from scenarios import runner
from scenarios.outputs import RESULTS, TABLE
from scenarios.results import results_folder
from scenarios.runner import run_scenario
from scenarios.scenario import read_scenario
from tests.scenarios.conftest import MISSING, names

ROOT = Path(__file__).resolve().parents[2]
TABLE_TEXT = json.dumps({"kind": RESULTS, "files": [TABLE, "new.txt"]})


def fill(folder: Path, text: str = "new") -> None:
    (folder / "new.txt").write_text(text)
    (folder / TABLE).write_text(TABLE_TEXT)


def write_half(target: Path) -> None:
    with results_folder(target) as folder:
        fill(folder)
        raise KeyboardInterrupt


def test_an_interruption_half_way_leaves_what_was_there(tmp_path):
    target = tmp_path / "results"
    with results_folder(target) as folder:
        fill(folder, "old")
    with pytest.raises(KeyboardInterrupt):
        write_half(target)
    assert (target / "new.txt").read_text() == "old"
    assert names(tmp_path) == ["results"]


def test_a_file_that_cannot_be_written_is_named_by_its_place_in_the_results(tmp_path):
    def write_onto_a_folder() -> None:
        with results_folder(tmp_path / "results") as folder:
            (folder / "run.csv").mkdir()
            write_atomically(folder / "run.csv", "")

    with pytest.raises(BadInput, match=f"^{tmp_path}/results/run.csv: cannot be written: "):
        write_onto_a_folder()


def test_a_scenario_leaves_everything_it_promises(tmp_path, tiny_scenario, tiny_folder):
    text = tiny_scenario.read_text() + (
        '\n[[variants]]\nname = "on"\ntitle = "On"\n'
        '[[variants]]\nname = "off"\nset = { "compensator.enabled" = false }\n'
        '[[variants]]\nname = "slow"\nset = { "plant.parameters.gain" = 1e-4 }\n'
    )
    tiny_scenario.write_text(text)
    out = tmp_path / "out"
    scenario = read_scenario(tiny_scenario, [("record_s", 5)])
    table, groups, pace = run_scenario(scenario, out, tiny_folder, quiet=True)
    assert names(out) == sorted(table["files"])
    assert {"drift.png", "speed.png", "temperatures.png", "tilt.png", "report.html"} <= {
        *table["files"]
    }
    assert json.loads((out / TABLE).read_text()) == table
    assert pace > 0

    # The drift of "on" and "off" is one and the same, that of "slow" another.
    assert [[row.name for row in group.rows] for group in groups] == [["", "on"], ["", "slow"]]
    results = read_run(out / "results.csv").frame
    assert results["time_s"].tolist() == [0, 5, 10, 15, 20]
    assert read_run(out / "results_off.csv").frame["offset_X_um"].tolist() == [0] * 5

    # Figures count every step, not every row written.
    axis = groups[0].rows[0].axes["X"]
    assert axis.samples == 21
    assert axis.before_max_um == pytest.approx(300.0)

    run = read_run(out / "run.csv").frame
    assert list(run.columns) == [
        "time_s",
        "speed_rpm",
        "T1_degC",
        *(f"S{i}_um" for i in range(1, 6)),
    ]
    assert not (out / "run_off.csv").exists()
    assert (out / "run_slow.csv").exists()
    copy = (out / "scenario.toml").read_text()
    assert copy == "# set on the command line: record_s = 5\n" + text


def test_a_failure_while_writing_leaves_no_folder(
    tmp_path, tiny_scenario, tiny_folder, monkeypatch
):
    def fail(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(runner, "write_report", fail)
    out = tmp_path / "out"
    with pytest.raises(BadInput, match="out: cannot be written: No space left on device"):
        run_scenario(read_scenario(tiny_scenario), out, tiny_folder, quiet=True)
    assert names(tmp_path) == ["fmus", "tiny.toml"]


@pytest.mark.usefixtures("drawn")
def test_the_same_scenario_gives_the_same_bytes(tmp_path, tiny_scenario, tiny_folder):
    tiny_scenario.write_text(tiny_scenario.read_text() + MISSING)
    found = []
    for name in ("a", "b"):
        run_scenario(read_scenario(tiny_scenario), tmp_path / name, tiny_folder, quiet=True)
        found.append({path.name: path.read_bytes() for path in (tmp_path / name).iterdir()})
    assert found[0] == found[1]
    # The run file shows what a faulty sensor showed.
    run = read_run(tmp_path / "a" / "run.csv").frame
    assert run.index[run["T1_degC"].isna()].tolist() == [5, 6, 7]


def test_a_machine_with_names_of_its_own_is_recorded_as_its_file_says(tmp_path):
    text = (ROOT / "docs/examples/machine.toml").read_text()
    (tmp_path / "own.toml").write_text(
        text.replace("\nspeed = {", "\nspindel = {")
        .replace('"speed"', '"spindel"')
        .replace("speed_rpm", "n_ist_rpm")
    )
    scenario = tmp_path / "warm.toml"
    scenario.write_text(
        'format = 1\nname = "warm"\ntitle = "Warm"\nduration_s = 60\nplant = { fmu = "own.toml" }\n'
        "compensator = { enabled = false }\nsignals = { spindel = 6000, ambient = 21 }\n"
    )
    table, _, _ = run_scenario(read_scenario(scenario), tmp_path / "out", tmp_path, quiet=True)
    assert "speed.png" in table["files"]
    run = read_run(tmp_path / "out/run.csv").frame
    columns = ["time_s", "n_ist_rpm", "hall_degC", "T1_degC", "T2_degC", "disp_z_um"]
    assert list(run.columns) == columns
    assert set(run["n_ist_rpm"]) == {6000}
