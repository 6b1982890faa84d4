"""What a plant and a compensator must offer, and that no unpacked FMU stays behind."""

import os
import shutil
import signal
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

import pytest

from measurement.errors import BadInput
from plant_model.machine_file import read_machine
from scenarios import unpacking
from scenarios.building import Form, job_for
from scenarios.fmu import FmuError
from scenarios.unpacking import Unpacked
from tests.patience import PATIENCE_S, until
from tests.scenarios.tiny_fmus import PLANT, build_tiny


@pytest.fixture
def temporary(plain_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder that takes the place of /tmp."""
    monkeypatch.setenv("TMPDIR", str(plain_path))
    monkeypatch.setattr(tempfile, "tempdir", None)
    return plain_path


def test_a_plant_without_the_error_that_is_left_is_refused(simulated, tmp_path):
    source = PLANT.replace('("drift", "offset", "error")', '("drift", "offset")', 2)
    plant = build_tiny(source.replace("error_", "hidden_"), "BlindPlant", tmp_path / "blind")
    with pytest.raises(BadInput, match=r"is no plant: .* output error_X, error_Y, error_Z$"):
        simulated(plant=plant, compensator=None)


def test_a_good_run_and_a_failed_start_leave_nothing_unpacked(simulated, tmp_path, temporary):
    simulated(compensator=None)
    # The builder makes an instance of its own, and that one must work.
    failing = 'len("dummyInstance") / (kwargs["instance_name"] == "dummyInstance")'
    source = PLANT.replace("self.speed = 0.0\n", f"self.speed = {failing}\n", 1)
    broken = build_tiny(source, "BrokenPlant", tmp_path / "broken")
    with pytest.raises(FmuError, match="cannot be started"):
        simulated(plant=broken, compensator=None)
    assert list(temporary.iterdir()) == []


def test_a_damaged_fmu_is_refused_and_leaves_nothing_unpacked(
    simulated, tiny_plant, tmp_path, temporary
):
    damaged = tmp_path / "damaged.fmu"
    shutil.copy(tiny_plant, damaged)
    with zipfile.ZipFile(damaged) as archive:
        entry = archive.getinfo("resources/slavemodule.txt")
        place = entry.header_offset + 30 + len(entry.filename) + 2
    data = bytearray(damaged.read_bytes())
    data[place] ^= 0xFF
    damaged.write_bytes(data)
    with pytest.raises(BadInput, match="cannot be unpacked into"):
        simulated(plant=damaged, compensator=None)
    assert list(temporary.iterdir()) == []


def test_what_a_killed_process_left_is_removed_and_what_is_in_use_is_not(tiny_plant, temporary):
    code = (
        "import sys, time; from pathlib import Path; from scenarios.unpacking import Unpacked; "
        "print(Unpacked(Path(sys.argv[1])).folder, flush=True); time.sleep(3600)"
    )
    command = [sys.executable, "-c", code, str(tiny_plant)]
    process = subprocess.Popen(command, env=dict(os.environ), stdout=subprocess.PIPE, text=True)
    theirs = Path(process.stdout.readline().strip())
    try:
        mine = Unpacked(tiny_plant)
        assert (theirs / "modelDescription.xml").is_file()
        process.kill()
    finally:
        process.communicate()
    other = Unpacked(tiny_plant)
    assert set(temporary.iterdir()) == {mine.folder, other.folder}
    mine.remove()
    other.remove()
    other.remove()
    assert list(temporary.iterdir()) == []


def test_a_folder_that_an_fmu_cannot_read_from_a_uri_is_refused(tiny_plant, temporary, monkeypatch):
    folder = temporary / "ü"
    folder.mkdir()
    monkeypatch.setenv("TMPDIR", str(folder))
    monkeypatch.setattr(tempfile, "tempdir", None)
    with pytest.raises(BadInput, match="set TMPDIR to a folder whose path is plain ASCII"):
        Unpacked(tiny_plant)
    with pytest.raises(BadInput, match="set TMPDIR to a folder whose path is plain ASCII"):
        job_for(read_machine("jig_borer"), temporary / "dist", Form())
    assert list(temporary.iterdir()) == [folder]
    assert list(folder.iterdir()) == []


@pytest.mark.long
def test_a_run_that_is_terminated_leaves_nothing_unpacked(
    tiny_scenario, tiny_folder, tmp_path, temporary
):
    command = [sys.executable, "-m", "scenarios.cli", "run", str(tiny_scenario)]
    command += ["--fmu-dir", str(tiny_folder), "--out", str(tmp_path / "out")]
    command += ["--set", "duration_s=1000000", "--set", "signals.speed=0.0"]
    process = subprocess.Popen(command, env=dict(os.environ), stderr=subprocess.PIPE, text=True)

    def both_unpacked() -> bool:
        assert process.poll() is None, process.communicate()
        return len(list(temporary.glob("spindle-drift-*/modelDescription.xml"))) == 2

    until(both_unpacked)
    process.send_signal(signal.SIGTERM)
    _, said = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 143, said
    assert list(temporary.iterdir()) == []
    assert not (tmp_path / "out").exists()


def test_what_another_kernel_unpacked_is_left_alone(tiny_plant, temporary):
    mine = Unpacked(tiny_plant)
    theirs = temporary / f"{unpacking.PREFIX}another0-abc"
    theirs.mkdir()
    (theirs / unpacking.LOCK).touch()
    ours = temporary / f"{unpacking.prefix()}abc"
    ours.mkdir()
    (ours / unpacking.LOCK).touch()
    unpacking.sweep(temporary)
    assert set(temporary.iterdir()) == {mine.folder, theirs}
    mine.remove()
