"""No command writes over an input, a file of somebody else's, or into a folder made in silence."""

import argparse
import json
import os
import zipfile
from pathlib import Path
from types import ModuleType

import pytest

from measurement.errors import BadInput
from scenarios import cli, outputs
from scenarios.cli import main
from scenarios.outputs import FOLDER, FOLDER_OF_RUNS, FOLDER_THAT_GOES_ON, check_output, guarding
from scenarios.results import results_folder, write_table

COMMANDS = sorted(cli.commands())
WRITERS = [
    (command, name)
    for command in COMMANDS
    for name in getattr(cli.import_module(cli.commands()[command][0]), "WRITES", {})
]
TEXT = b"time_s,T1_degC\n0,20\n"
PATHS = ("FILE", "DIR", "RUN", "LOG", "MACHINE", "COMPENSATOR", "SCENARIO", "LOG")
OPTIONS_THAT_TAKE_MORE = {"fmu_dir"}
"""Folders that are looked into, and where what ships is built."""


def module_of(command: str) -> ModuleType:
    return cli.import_module(cli.commands()[command][0])


def actions_of(command: str) -> list[argparse.Action]:
    parser = argparse.ArgumentParser()
    module_of(command).add_arguments(parser)
    return [action for action in parser._actions if action.dest != "help"]


def is_a_path(action: argparse.Action) -> bool:
    names = {"machine", "plant", "compensator", "scenario"}
    return action.type is Path or action.metavar in PATHS or action.dest in names


@pytest.mark.parametrize("command", COMMANDS)
def test_every_argument_that_is_a_path_is_registered_once(command):
    module, actions = module_of(command), actions_of(command)
    paths = {action.dest for action in actions if is_a_path(action)} - OPTIONS_THAT_TAKE_MORE
    reads, writes = set(module.READS), set(module.WRITES)
    assert paths <= reads | writes
    assert not reads & writes
    assert reads | writes <= {action.dest for action in actions}
    assert set(module.WRITES.values()) <= {
        *outputs.KINDS, FOLDER, FOLDER_OF_RUNS, FOLDER_THAT_GOES_ON
    }  # fmt: skip


def command_line(command: str, written: str, target: Path, source: Path) -> list[str]:
    """Return a command line that reads *source* wherever it can and writes to *target*."""
    line = [command]
    module = module_of(command)
    for action in actions_of(command):
        value = target if action.dest == written else source
        if action.dest in module.WRITES and action.dest != written:
            value = source.parents[1] / "another.out"
        if action.option_strings:
            given = action.dest == written or (action.dest in module.READS and action.type is Path)
            if action.required or given:
                line += [action.option_strings[-1], str(value)]
        elif action.nargs != "?":
            line.append(str(value))
    return line


@pytest.fixture
def never_run(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Let commands do nothing, and note that they were let through."""
    ran: list[str] = []
    for command in COMMANDS:
        monkeypatch.setattr(
            module_of(command), "run", lambda args, command=command: ran.append(command) or 0
        )
    return ran


@pytest.mark.parametrize(("command", "written"), WRITERS)
def test_an_input_a_foreign_file_and_a_missing_folder_are_refused_and_forced(
    command, written, tmp_path, capsys, never_run
):
    kind = module_of(command).WRITES[written]
    source = tmp_path / "in" / "q1.csv"
    foreign = tmp_path / "thesis" / "chapter.tex"
    for path in (source, foreign):
        path.parent.mkdir()
        path.write_bytes(TEXT)
    is_folder = kind in outputs.FOLDERS
    bad = [source.parent] if is_folder else [foreign, tmp_path / "new" / "out.x"]
    if not is_folder and command != "gateway":  # which reads no file that it must be given
        bad.append(source)
    if kind == FOLDER:
        bad.append(foreign.parent)
    if kind == FOLDER_OF_RUNS:  # other files in it stay: tests/scenarios/test_import.py
        bad = [foreign]
    if is_folder:
        bad.append(tmp_path / "runs.csv")
    for target in bad:
        argv = command_line(command, written, target, source)
        assert main(argv) == 2, (argv, capsys.readouterr().err)
        (line,) = capsys.readouterr().err.splitlines()
        assert str(target) in line or str(target.parent) in line
        assert main([*argv, "--force"]) == 0
    assert never_run == [command] * len(bad)
    fresh = tmp_path / "fresh.out"
    assert main(command_line(command, written, fresh, source)) == 0
    assert source.read_bytes() == foreign.read_bytes() == TEXT
    assert sorted(path.name for path in tmp_path.iterdir()) == ["in", "thesis"]


def refused(path: Path, kind: str) -> bool:
    try:
        check_output(path, kind)
    except BadInput:
        return True
    return False


def archive(path: Path, name: str, text: str) -> Path:
    with zipfile.ZipFile(path, "w") as file:
        file.writestr(name, text)
    return path


def test_what_a_former_run_made_is_known_by_its_content(tmp_path):
    ours = tmp_path / "ours"
    made = outputs.marked("format = 1\n")
    for kind, text, other in (
        (outputs.COMPENSATOR_FILE, '{"kind": "spindle-drift compensator"}', '{"kind": "x"}'),
        (outputs.STATE, '{"kind": "spindle-drift FMU state"}', "[]"),
        (outputs.MACHINE_FILE, made, made.replace("1\n", "2\n")),
        (outputs.MACHINE_FILE, outputs.marked(made), "format = 1\n"),
    ):
        ours.write_text(text, encoding="utf-8")
        assert not refused(ours, kind)
        ours.write_text(other, encoding="utf-8")
        assert refused(ours, kind)
    for kind, name in ((outputs.SSP, "SystemStructure.ssd"), (outputs.FMU, "modelDescription.xml")):
        assert not refused(archive(ours, name, '<x generationTool="spindle-drift 0.1"/>'), kind)
        assert refused(archive(ours, name, '<x generationTool="another"/>'), kind)
        assert refused(archive(ours, "other", ""), kind)
    ours.write_bytes(TEXT)
    assert all(refused(ours, kind) for kind in outputs.KINDS)


def test_an_input_behind_a_link_is_an_input(tmp_path):
    model, link = tmp_path / "c.json", tmp_path / "link.json"
    model.write_text('{"kind": "spindle-drift compensator"}')
    link.symlink_to(model)
    with guarding("fit", [model]):
        assert refused(link, outputs.COMPENSATOR_FILE)
    with guarding("fit", [tmp_path / "other.json"]):
        assert not refused(link, outputs.COMPENSATOR_FILE)


def results(
    folder: Path, command: str, *, force: bool = False, inputs: tuple[Path, ...] = ()
) -> None:
    with guarding(command, inputs, force), results_folder(folder) as new:
        (new / f"{command}.csv").write_text(command)
        write_table([], {}, new)


def test_a_folder_is_replaced_by_the_same_command_only_and_never_with_an_input(tmp_path):
    folder = tmp_path / "out"
    results(folder, "run")
    results(folder, "run")
    with pytest.raises(BadInput, match="holds results of 'run'"):
        results(folder, "replay")
    with pytest.raises(BadInput, match=r"holds run\.csv, an input"):
        results(folder, "run", inputs=(folder / "run.csv",))
    (folder / "notes.txt").write_text("mine")
    with pytest.raises(BadInput, match=r"holds notes\.txt, which is no result"):
        results(folder, "run")
    table = (folder / "table.json").read_text()
    (folder / "table.json").write_text("[[[")
    with pytest.raises(BadInput, match="holds files and no results"):
        results(folder, "run")
    (folder / "table.json").write_text(table)
    results(folder, "replay", force=True)
    assert {path.name for path in folder.iterdir()} == {
        "notes.txt", "run.csv", "replay.csv", "table.json"
    }  # fmt: skip
    assert json.loads((folder / "table.json").read_text())["made_by"] == "replay"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out"]


def test_a_pipe_as_an_input_is_refused_by_every_command_that_reads(tmp_path, capsys, never_run):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    readers = {command for command in COMMANDS if module_of(command).READS}
    for command in sorted(readers - {"machine"}):  # whose arguments are all left out here
        line = [*command_line(command, "", tmp_path / "out", pipe)]
        if command == "compare":
            line += ["--train", str(pipe)]
        assert main(line) == 2, command
        assert "pipe: is a pipe or a device" in capsys.readouterr().err
    assert never_run == []


@pytest.mark.parametrize(
    "kind", [outputs.COMPENSATOR_FILE, FOLDER, FOLDER_OF_RUNS, FOLDER_THAT_GOES_ON]
)
def test_a_place_that_takes_no_files_is_refused_before_the_work(kind):
    with pytest.raises(BadInput, match=r"^/proc/results: cannot be written: "):
        check_output(Path("/proc/results"), kind)
