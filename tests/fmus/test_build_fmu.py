"""build_fmu.py as a user runs it."""

import json
import os
import shutil
import sys
from pathlib import Path

import fmpy
import pytest
from fmpy.util import read_csv

import build_fmu
from fmu_packaging.units import base_unit
from gateway.dbc import DBC
from tests.fmus.models import five_point_text
from tests.running import output_of


@pytest.mark.long
def test_a_build_in_another_process_gives_the_same_bytes(shipped, tmp_path):
    command = (sys.executable, build_fmu.__file__, "--out", tmp_path)
    output_of(*command, folder=tmp_path, PYTHONHASHSEED="7", TZ="Asia/Tokyo")
    found, wanted = (
        {path.name: path.read_bytes() for path in folder.iterdir()}
        for folder in (tmp_path, shipped)
    )
    assert found.keys() == wanted.keys()
    assert [name for name in wanted if found[name] != wanted[name]] == []


def test_another_model_takes_the_place_of_the_first(compensator, tmp_path):
    dist = shutil.copytree(compensator.parent, tmp_path / "dist")
    other = tmp_path / "other.json"
    other.write_text(five_point_text(gain=2.0))
    arguments = ["--only", "compensator", "--model", str(other), "--out", str(dist)]
    assert build_fmu.main(arguments) == 0
    assert (dist / "compensator.fmu").read_bytes() != compensator.read_bytes()
    before, after = (
        read_csv(folder / "compensator_ref.csv") for folder in (compensator.parent, dist)
    )
    assert after["elongation"][-1] == pytest.approx(2 * before["elongation"][-1])


@pytest.mark.parametrize("name", ["compensator", "plant"])
def test_every_variable_says_what_it_is(shipped, name):
    description = fmpy.read_model_description(str(shipped / f"{name}.fmu"))
    units = {unit.name: unit for unit in description.unitDefinitions}
    for variable in description.modelVariables:
        assert variable.description, variable.name
        if variable.type == "Real":
            assert float(variable.min) < float(variable.max), variable.name
            assert variable.nominal is None or float(variable.nominal) > 0.0
            base = units[variable.unit].baseUnit
            expected = base_unit(variable.unit)
            assert float(base.factor or 1.0) == expected.factor
            assert float(base.offset or 0.0) == expected.offset
            if variable.start is not None:
                assert float(variable.min) <= float(variable.start) <= float(variable.max)
        if variable.type == "Integer":
            assert int(variable.min) <= int(variable.max)
    flags = description.coSimulation
    assert flags.canGetAndSetFMUstate
    assert flags.canSerializeFMUstate
    assert flags.canHandleVariableCommunicationStepSize
    assert not flags.canBeInstantiatedOnlyOncePerProcess
    assert not flags.providesDirectionalDerivative


def test_the_summary_for_machines(tmp_path, capsys):
    arguments = ["--only", "compensator", "--name", "mine", "--out", str(tmp_path), "--json"]
    assert build_fmu.main(arguments) == 0
    (entry,) = json.loads(capsys.readouterr().out)
    assert entry["name"] == "mine"
    assert entry["bytes"] == (tmp_path / "mine.fmu").stat().st_size
    description = fmpy.read_model_description(str(tmp_path / "mine.fmu"))
    assert (description.guid, description.modelName) == (entry["guid"], "mine")


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["--model", "absent.json"], "absent.json: no such file"),
        (["--model", "broken.json"], "broken.json: line 1"),
        (["--model", "wrong.json"], "wrong.json: limits.slew_um_per_s"),
        (["--machine", "absent.toml"], "absent.toml"),
        (["--machine", "no_such_machine"], "no_such_machine"),
        (["--only", "both"], "--only"),
        (["--name", "x"], "--name"),
        (["--only", "plant", "--name", "2 words"], "--name: '2 words'"),
        (["--out", "broken.json"], "--out: broken.json is not a folder"),
        (["--frobnicate"], "--frobnicate"),
        (["--arrays"], "--arrays: add --fmi 3"),
        (["--arrays", "--native"], "--arrays: add --fmi 3"),
        (["--arrays", "--can", "--fmi", "3"], "--arrays: not with --can"),
        (["--arrays", "--fmi", "3", "--model", "array.json"], "a variable temperatures already"),
        (["--can", "--model", "many.json"], "carries no signal T12"),
        (["--can", "high", "--dbc", "my-bus.dbc"], "letters, digits and underscores"),
        (["--can", "high", "--dbc", "bus.dbc"], ", T11: degrees: "),
        (["--leave-out", "sources"], "--leave-out: add --native"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(tmp_path, monkeypatch, capsys, arguments, named):
    monkeypatch.chdir(tmp_path)
    Path("broken.json").write_text("{ not JSON")
    Path("wrong.json").write_text(
        five_point_text().replace('"slew_um_per_s": 1.0', '"slew_um_per_s": -1')
    )
    Path("good.json").write_text(five_point_text())
    Path("many.json").write_text(five_point_text(sensors=12))
    Path("array.json").write_text(five_point_text().replace('"T3"', '"temperatures"'))
    for name, unit in (("my-bus.dbc", "degC"), ("bus.dbc", "degrees")):
        Path(name).write_text(DBC.read_text("utf-8").replace('"degC"', f'"{unit}"'))
    given = ["--model", "good.json", "--out", "dist", *arguments]
    try:
        code = build_fmu.main(given)
    except SystemExit as exit_:
        code = int(exit_.code or 0)
    assert code == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert named in error
    assert not Path("dist").exists()


def test_a_full_disk_is_one_line_and_leaves_no_folder(tmp_path, monkeypatch, capsys):
    def full(handle: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    out = tmp_path / "dist"
    assert build_fmu.main(["--only", "compensator", "--out", str(out)]) == 2
    assert capsys.readouterr().err == f"{out}: cannot be written: No space left on device\n"
    assert not out.exists()
