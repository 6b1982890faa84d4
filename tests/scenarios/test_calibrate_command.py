"""``calibrate``: the machine file, and the page beside it."""

import json

import pytest

from measurement.runs import Run
from plant_model.machine_file import machine_path, read_machine
from scenarios.outputs import PAGE, check_output
from spindle_drift import simulate
from tests.scenarios.conftest import written

RUNS = ("training_down", "stop_and_go")


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    made = [simulate("jig_borer", name, every_s=120.0, noise_seed=1) for name in RUNS]
    # The second has no reading of one thermometer.
    frames = [made[0].frame[:90].copy(), made[1].frame[:90].drop(columns="T3_degC")]
    frames[0].loc[5, "speed_rpm"] = 21000.0
    return written(tmp_path_factory.mktemp("runs"), *map(Run, RUNS, frames))


def test_a_page_is_written_beside_the_machine_file(runs, tmp_path, prints, refused):
    out = tmp_path / "mine.toml"
    argv = ["calibrate", "jig_borer", *runs, "-o", str(out), "--starts", "1", "--json", "--quiet"]
    told = json.loads(prints(argv))
    assert told["page"] == str(tmp_path / "mine.html")
    assert {path.name for path in tmp_path.iterdir()} == {"mine.toml", "mine.html"}
    text = (tmp_path / "mine.html").read_text(encoding="utf-8")
    after = read_machine(out)
    for name, parameter in after.parameters.items():
        if parameter.calibrate:
            assert f'<td class="text">{name}' in text
    for channel in told["channels"]["before"]:
        assert f"<tr><td>{channel}</td>" in text
    assert "This does not show how well the model predicts other runs." in text
    assert [remark.partition(",")[0] for remark in told["remarks"]] == [
        "not compared: T3",
        "doubtful: training_down",
    ]
    assert "not compared: T3, its column T3_degC is not in stop_and_go" in text
    assert "doubtful: training_down, speed_rpm: 21000 at 600 s is outside 0..20000 rpm" in text
    for run in RUNS:
        assert f"Measured against model, temperatures: {run}" in text
        assert f"Measured against model, displacements: {run}" in text
    # Its own page may be replaced, another one may not.
    check_output(tmp_path / "mine.html", PAGE)
    (tmp_path / "mine.html").write_text("<html>my notes</html>", encoding="utf-8")
    before = out.read_bytes()
    line = refused(argv)
    assert "mine.html: exists and is no page that this program made" in line
    assert (tmp_path / "mine.html").read_text(encoding="utf-8") == "<html>my notes</html>"
    assert out.read_bytes() == before


def test_a_file_without_free_numbers_is_refused(runs, tmp_path, refused):
    fixed = tmp_path / "fixed.toml"
    text = machine_path("jig_borer_lumps").read_text(encoding="utf-8")
    fixed.write_text(text.replace("calibrate = true", "calibrate = false"), encoding="utf-8")
    line = refused(["calibrate", str(fixed), *runs, "-o", str(tmp_path / "mine.toml")])
    assert "nothing to calibrate: no number has calibrate = true" in line
    assert not (tmp_path / "mine.toml").exists()
