"""A scenario takes FMUs in C where they can be had, and gives the same."""

import json
import shutil
import tempfile
from pathlib import Path

import build_fmu
from scenarios import fmu_files
from scenarios.cli import main
from scenarios.fmu_files import find_fmu
from scenarios.replay import model_of
from scenarios.views import rig_of


def test_the_twin_beside_the_plant_is_taken_and_a_path_means_that_file(shipped_in_c, tmp_path):
    def found(name: str, native: bool = True) -> Path:
        return find_fmu(name, shipped_in_c, tmp_path, tmp_path, native=native)

    assert found("plant.fmu") == shipped_in_c / "plant_native.fmu"
    assert found("plant.fmu", native=False) == shipped_in_c / "plant.fmu"
    assert found(str(shipped_in_c / "plant.fmu")) == shipped_in_c / "plant.fmu"
    assert rig_of(shipped_in_c / "plant_native.fmu") == rig_of(shipped_in_c / "plant.fmu")


def test_a_compensator_has_a_twin_too(shipped_in_c, tmp_path):
    for file in ("compensator.fmu", "compensator_native.fmu"):
        shutil.copy(shipped_in_c / file, tmp_path)
    work = tmp_path / "work"
    work.mkdir()
    python, native = (
        find_fmu("compensator.fmu", tmp_path, work, work, native=asked) for asked in (False, True)
    )
    assert (python.name, native.name) == ("compensator.fmu", "compensator_native.fmu")
    assert native.parent == tmp_path
    assert model_of(native).table == model_of(python).table
    native.unlink()
    built = find_fmu("compensator.fmu", tmp_path, work, work, native=True)
    assert built == work / "compensator_native.fmu"
    assert model_of(built).table == model_of(python).table


def test_a_run_needs_a_folder_fit_for_python_for_neither(shipped_in_c, tmp_path, monkeypatch):
    (place := tmp_path / "t ü").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(place))
    command = ["run", "step_speed", "--fmu-dir", str(shipped_in_c), "--out", str(tmp_path / "out")]
    assert main([*command, "--set", "duration_s=60", "--quiet"]) == 0
    facts = json.loads((tmp_path / "out" / "table.json").read_text("utf-8"))["variants"][0]
    assert [fmu["file"] for fmu in facts["fmus"]] == ["plant_native.fmu", "compensator_native.fmu"]


def test_what_is_no_twin_is_not_taken(shipped_in_c, tmp_path):
    other, work = tmp_path / "dist", tmp_path / "work"
    work.mkdir()
    assert (
        build_fmu.main(["--only", "plant", "--machine", "jig_borer_lumps", "--out", str(other)])
        == 0
    )
    shutil.copy(shipped_in_c / "plant_native.fmu", other)
    found = find_fmu("plant.fmu", other, tmp_path, work, native=True)
    assert found == work / "plant_native.fmu"
    assert find_fmu("plant.fmu", other, tmp_path, work, native=True) == found


def test_without_a_compiler_python_does_it_with_a_word(shipped_in_c, tmp_path, monkeypatch, capsys):
    shutil.copy(shipped_in_c / "plant.fmu", tmp_path)
    monkeypatch.setenv("CC", "no-such-compiler")
    fmu_files._say_once.cache_clear()
    found = find_fmu("plant.fmu", tmp_path, tmp_path / "near", tmp_path, native=True)
    assert found == tmp_path / "plant.fmu"
    why = "no C compiler: CC names 'no-such-compiler', which cannot be found"
    assert capsys.readouterr().err == f"{found}: taken in Python: {why}\n"
