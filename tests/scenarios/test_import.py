"""The import command: what it writes, what it says, and that nothing of the user's is lost."""

import json
from collections.abc import Mapping
from pathlib import Path
from threading import Thread

import numpy as np
import pytest

from measurement.files import write_together
from measurement.importing.log import Imported, import_files
from measurement.runs import read_run, write_run
from measurement.warm import WARM_START
from scenarios import imported
from scenarios.cli import main
from scenarios.imported import write_imported
from spindle_drift import simulate
from spindle_drift.commands import import_
from tests.measurement.importing.made import HEADER, elapsed, signals, stamps, table
from tests.scenarios.conftest import names

LOCAL = table(
    stamps("%d.%m.%Y %H:%M:%S"),
    header=[*HEADER[:4], "z [µm]", "Druck [bar]"],
    values=np.column_stack([signals(), signals()[:, :1]]),
)


@pytest.fixture
def log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "log.csv"
    path.write_text(LOCAL, encoding="cp1252")
    return path


def test_it_writes_runs_and_says_what_became_of_every_column(log, capsys):
    assert main(["import", "log.csv", "-o", "runs"]) == 0
    shown = capsys.readouterr()
    assert names(Path("runs")) == ["20260302_0715.csv", "import.toml", "imported.json"]
    run = read_run("runs/20260302_0715.csv")
    assert list(run.frame)[1:] == [
        "Temp_Lager_vorn_degC", "T_hinten_degC", "Halle_degC", "speed_rpm", "z_um"
    ]  # fmt: skip
    assert "20260302_0715.csv  2026-03-02 07:15:00  0.65 h  40 rows" in shown.out
    assert shown.out.endswith("runs/import.toml; change it there and import again\n")
    (line,) = shown.err.splitlines()
    assert line.startswith("left out: Druck [bar]: its unit 'bar' is not known (known: s, min,")
    assert "keep = false" in line


def test_the_mapping_file_is_followed_kept_and_written_anew_by_force(log, capsys):
    assert main(["import", "log.csv", "-o", "runs"]) == 0
    mapping = Path("runs/import.toml")
    mended = mapping.read_text(encoding="utf-8")
    mended = mended.replace('name = "Druck", unit = ""', 'name = "Druck", keep = false')
    mended = mended.replace('name = "z", unit', 'name = "disp_z", unit')
    mapping.write_text(mended, encoding="utf-8")
    capsys.readouterr()
    assert main(["import", "log.csv", "-o", "runs"]) == 0
    shown = capsys.readouterr()
    assert shown.err == ""
    assert shown.out.splitlines()[-1] == "as runs/import.toml says"
    assert "disp_z_um" in read_run("runs/20260302_0715.csv").frame
    assert mapping.read_text(encoding="utf-8") == mended
    # Another recorder's column is read as far as it can be, and told.
    log.write_text(LOCAL.replace("Halle [°C]", "Öl [°C]"), encoding="cp1252")
    assert main(["import", "log.csv", "-o", "runs", "--force"]) == 0
    assert "note: Öl [°C] is new to the mapping file" in capsys.readouterr().err
    assert "Öl [°C]" in mapping.read_text(encoding="utf-8")
    other = Path("other.toml")
    other.write_text(mended, encoding="utf-8")
    assert main(["import", "log.csv", "-o", "else", "--mapping", "other.toml"]) == 0
    assert names(Path("else")) == ["20260302_0715.csv", "imported.json"]


def test_nothing_in_the_folder_is_written_over_but_what_an_import_made(log, refused):
    argv = ["import", "log.csv", "-o", "runs"]
    folder, target = Path("runs"), Path("runs/20260302_0715.csv")
    folder.mkdir()
    target.write_text("mine")
    (folder / "notes.txt").write_text("mine, too")
    assert "20260302_0715.csv: exists and was not imported" in refused(argv)
    assert names(folder) == ["20260302_0715.csv", "notes.txt"]
    target.unlink()
    assert main(argv) == 0
    assert main(argv) == 0
    target.write_text(target.read_text().replace("21.0", "21.5", 1))
    edited = target.read_text()
    assert "exists and was changed since it was imported" in refused(argv)
    assert target.read_text() == edited
    assert main([*argv, "--force"]) == 0
    assert target.read_text() != edited
    assert (folder / "notes.txt").read_text() == "mine, too"


def test_an_import_that_was_cut_off_can_be_repeated(log, refused, monkeypatch):
    argv, folder = ["import", "log.csv", "-o", "runs"], Path("runs")
    replace = Path.replace

    def cut_off(path: Path, target: Path) -> Path:
        if target.name == "imported.json":
            raise OSError(28, "No space left on device")
        return replace(path, target)

    monkeypatch.setattr(Path, "replace", cut_off)
    assert "imported.json: cannot be written: No space left" in refused(argv)
    assert names(folder) == ["20260302_0715.csv"]
    monkeypatch.undo()
    monkeypatch.chdir(log.parent)
    assert main(argv) == 0
    assert names(folder) == ["20260302_0715.csv", "import.toml", "imported.json"]


def test_a_log_in_its_own_folder_is_not_written_over(log, refused):
    log.write_text(table(elapsed(), clock="t [s]"), encoding="utf-8")
    before = log.read_bytes()
    assert "log.csv: is an input of this command" in refused(["import", "log.csv", "-o", "."])
    assert log.read_bytes() == before
    assert names(Path()) == ["log.csv"]


def test_a_log_of_the_same_name_does_not_replace_the_run_of_another(log, refused):
    """Without dates a run is called after its log, and many recorders call every log the same."""
    line = ["import", "log.csv", "-o", "runs"]
    log.write_text(table(elapsed(), clock="t [s]"), encoding="utf-8")
    assert main(line) == main(line) == 0
    before = Path("runs/log.csv").read_bytes()
    log.write_text(table(elapsed(30), clock="t [s]"), encoding="utf-8")
    assert "log.csv: exists and was imported from another log" in refused(line)
    assert Path("runs/log.csv").read_bytes() == before
    assert main([*line, "--force"]) == 0


def test_a_second_log_adds_its_runs(log, prints):
    assert main(["import", "log.csv", "-o", "runs"]) == 0
    Path("next.csv").write_text(LOCAL.replace("02.03.2026", "03.03.2026"), encoding="cp1252")
    facts = json.loads(prints(["import", "next.csv", "-o", "runs", "--json"]))
    assert [run["file"] for run in facts["runs"]] == ["runs/20260303_0715.csv"]
    assert list(facts["left_out"]) == ["Druck [bar]"]
    runs = json.loads(Path("runs/imported.json").read_text())["runs"]
    assert list(runs) == ["20260302_0715.csv", "20260303_0715.csv"]
    assert runs["20260303_0715.csv"]["sources"][0]["file"] == "next.csv"


def test_two_imports_into_one_folder_at_once_list_both_runs(log, monkeypatch):
    Path("next.csv").write_text(LOCAL.replace("02.03.2026", "03.03.2026"), encoding="cp1252")

    def write(*paths: Path) -> None:
        write_imported(import_files(paths), paths, Path("runs"), with_mapping=False)

    other = Thread(target=write, args=[Path("next.csv")])

    def beside_another(files: Mapping[Path, str | bytes]) -> None:
        monkeypatch.setattr(imported, "write_together", write_together)
        other.start()
        other.join(0.3)  # it waits, or would be through by now
        write_together(files)

    monkeypatch.setattr(imported, "write_together", beside_another)
    write(log)
    other.join()
    runs = json.loads(Path("runs/imported.json").read_text())["runs"]
    assert list(runs) == ["20260302_0715.csv", "20260303_0715.csv"]


def test_what_another_import_decided_in_the_meantime_stays(log, refused, monkeypatch):
    def beside_another(*arguments: object) -> Imported:
        monkeypatch.setattr(import_, "import_files", import_files)
        assert main(line) == 0
        return import_files(*arguments)

    line = ["import", "log.csv", "-o", "runs", "--unit", "Druck [bar]=1"]
    monkeypatch.setattr(import_, "import_files", beside_another)
    said = refused(["import", "log.csv", "-o", "runs"])
    assert "runs/import.toml: has changed since this import began: import again" in said
    assert '"Druck [bar]" = {name = "Druck", unit = "1"}' in Path("runs/import.toml").read_text()
    assert main(["import", "log.csv", "-o", "runs"]) == 0


def test_commands_take_runs_with_the_mark_of_a_warm_start(log, prints):
    assert main(["import", "log.csv", "-o", "runs", "--split", "none"]) == 0
    path = Path("runs/20260302_0715.csv")
    run = read_run(path)
    marked = Path("marked")
    marked.mkdir()
    run.frame.assign(**{WARM_START: 1.0}).to_csv(marked / path.name, index=False)
    shown = []
    for file in (path, marked / path.name):
        summary = json.loads(prints(["summary", str(file), "--json"]))[0]
        fitted = json.loads(prints(["fit", str(file), "-o", f"{len(shown)}.json", "--json"]))
        shown.append((summary, fitted["figures"]))
    assert shown[0] == shown[1]


def test_what_reads_warm_restarts_leaves_them_out_or_says_so(tmp_path, capsys, prints):
    names = ("training_down", "training_random", "stop_and_go")
    runs = [simulate("jig_borer", name, every_s=120.0, noise_seed=1) for name in names]
    files = []
    for one, mark in zip(runs, (0.0, 0.0, 1.0), strict=True):
        frame = one.frame.iloc[:120].assign(**{WARM_START: mark})
        files.append(str(write_run(frame, tmp_path / f"{one.name}{len(files)}.csv")))
    warm = Path(files[2]).stem
    fit = ["--model", "mlr", "--json"]
    told = json.loads(prints(["fit", *files, "-o", str(tmp_path / "some.json"), *fit]))
    note = f"left out, since the machine was warm when they began: {warm}; use them by themselves"
    assert any(line.startswith(note) for line in told["notes"])
    assert (
        json.loads(prints(["fit", *files[:2], "-o", str(tmp_path / "cold.json"), *fit]))["figures"]
        == told["figures"]
    )
    argv = ["--train", *files[:2], "--validate", files[2], "--models", "mlr"]
    assert main(["compare", *argv]) == 0
    assert (
        f"judged like cold starts, though the machine was warm: {warm}" in capsys.readouterr().out
    )
    assert f"the machine was warm when these began: {warm}" in prints(
        ["monitor", str(tmp_path / "cold.json"), files[2], "--machine", "jig_borer"]
    )
