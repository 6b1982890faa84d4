"""From a laboratory's untouched workbooks to a judged compensator, in three commands."""

import json
from pathlib import Path

import pytest

import spindle_drift as sd
from measurement.runs import Run, read_run, write_run
from scenarios.cli import main
from tests.measurement.lab import SHEETS, clock_s, day, workbooks

UNITS = ["--unit", "T*=degC", "--unit", "D*=um", "--unit", "Growth=um"]
KNOWN = ["--every-row", "60s", *UNITS]


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The workbooks, the runs that the first command makes, and the compensator of the second."""
    folder = tmp_path_factory.mktemp("lab")
    books = [str(path) for path in workbooks(folder)]
    runs = folder / "runs"
    assert main(["import", *books, "-o", str(runs), *KNOWN, "--axis", "Dia*=X"]) == 0
    training = [str(path) for path in sorted(runs.glob("*.csv"))[:3]]
    assert main(["fit", *training, "--model", "mlr", "-o", str(folder / "c.json")]) == 0
    return folder


def test_each_refusal_and_question_says_what_to_add(lab, tmp_path, capsys, refused, monkeypatch):
    monkeypatch.chdir(tmp_path)
    asked = ["import", *map(str, sorted(lab.glob("*.xlsx"))), "-o", "runs"]
    assert "--every-row 60s says that a row follows the last after 60 s" in refused(asked)
    assert "--unit 'Dia_Disp=" in refused([*asked, "--every-row", "60s"])
    assert not Path("runs").exists()
    assert main([*asked, *KNOWN]) == 0
    assert "asked: Dia_Disp: which axis? --axis 'Dia_Disp=X'" in capsys.readouterr().err
    # What was said stays said: the mapping file has the time and the units.
    assert main([*asked, "--axis", "Dia*=-X"]) == 0
    assert capsys.readouterr().err == ""
    _, moved = day(7)
    assert read_run("runs/Sheet07.csv").frame["Dia_Disp_x_um"].tolist() == (-moved[:, 0]).tolist()
    for wrong in (["--axis", "Dia*=U"], ["--axis", "Dia"], ["--axis", "Weg=X"]):
        assert main([*asked, *wrong]) == 2
    for wrong in ("soon", "60um", "0s"):
        assert main([*asked, "--every-row", wrong]) == 2


def test_eighteen_sheets_become_a_judged_compensator(lab, tmp_path, prints):
    runs = sorted((lab / "runs").glob("*.csv"))
    assert [run.stem for run in runs] == [f"Sheet{n:02d}" for n in range(1, SHEETS + 1)]
    for number, path in enumerate(runs, 1):
        frame, (temperatures, moved) = read_run(path).frame, day(number)
        assert frame["time_s"].tolist() == clock_s().tolist()
        assert frame["T_rear_degC"].tolist() == temperatures[:, 1].tolist()
        assert frame["Growth_um"].tolist() == moved[:, 1].tolist()
    replay = ["replay", str(lab / "c.json"), str(runs[-1]), "--out", str(tmp_path / "replay")]
    (judged,) = json.loads(prints([*replay, "--json"]))["table"][0]["rows"][1:]
    assert {"X", "Z"} == set(judged["axes"])


def test_a_run_in_wrong_units_is_doubted_wherever_it_goes(lab, tmp_path, prints):
    frame = read_run(lab / "runs" / "Sheet18.csv").frame
    frame = frame.assign(time_s=frame["time_s"] / 60.0, Growth_um=frame["Growth_um"] / 1000.0)
    compensator = str(lab / "c.json")
    wrong = str(write_run(Run("wrong", frame), tmp_path / "wrong.csv"))
    for command in (
        ["fit", wrong, "--model", "mlr", "-o", str(tmp_path / "d.json")],
        ["replay", compensator, wrong, "--out", str(tmp_path / "replay")],
        ["monitor", compensator, wrong],
        ["summary", wrong],
    ):
        told = prints(command)
        assert "doubtful: time_s" in told
        assert "minutes taken for seconds?" in told
        assert "millimetres taken for micrometres?" in told
    with pytest.warns(UserWarning, match="taken for") as caught:
        sd.Compensator.load(compensator).judge(wrong)
    assert len(caught) == 2
