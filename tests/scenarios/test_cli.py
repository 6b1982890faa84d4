"""The command line: exit codes, one line of error, help that is quick."""

import argparse
import contextlib
import json
import os
import signal
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import pytest

from fmu_compensator.runtime.fields import ModelFileError
from gateway.commands import gateway
from scenarios import build_command, cli
from scenarios.cli import main
from scenarios.scenario import library
from tests.patience import PATIENCE_S
from tests.running import run

PROJECT = Path(__file__).parents[2] / "pyproject.toml"


def one_line(text: str) -> str:
    lines = text.splitlines()
    assert len(lines) == 1, text
    return lines[0]


def test_help_lists_every_command_and_is_quick():
    code = "import sys; from scenarios.cli import main; main(['--help']); print(len(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert int(done.stdout.splitlines()[-1]) < 300  # modules: 151 with Python 3.11, pandas has 900
    for command in ("run", "list", "replay", "fit", "summary"):
        assert f"\n    {command} " in done.stdout


def test_the_package_is_the_command(capsys):
    done = run(sys.executable, "-m", "spindle_drift", "run", "no_such_scenario")
    assert main(["run", "no_such_scenario"]) == done.returncode == 2
    assert one_line(done.stderr) == one_line(capsys.readouterr().err)


def test_no_help_waits_for_matplotlib():
    code = """
import sys
from scenarios.cli import commands, main
for name in commands():
    main([name, "--help"])
    assert "matplotlib" not in sys.modules, name
"""
    subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)


def test_list_names_every_scenario(prints):
    lines = prints(["list"]).splitlines()
    assert [line.split()[0] for line in lines] == [path.stem for path in library()]
    found = json.loads(prints(["list", "--json"]))
    assert [entry["name"] for entry in found] == [path.stem for path in library()]


def test_run_prints_a_table_and_writes_the_folder(
    tiny_scenario, tiny_folder, tmp_path, capsys, prints
):
    out = tmp_path / "out"
    argv = ["run", str(tiny_scenario), "--fmu-dir", str(tiny_folder), "--out", str(out)]
    assert main(argv) == 0
    shown = capsys.readouterr()
    assert "No compensation" in shown.out
    assert str(out / "report.html") in shown.out
    assert shown.err == ""
    table = json.loads(prints([*argv, "--json", "--set", "duration_s=10"]))
    assert table["scenario"]["overrides"] == {"duration_s": 10}
    assert table == json.loads((out / "table.json").read_text())
    assert prints([*argv, "--quiet"]) == ""


def test_a_failing_fmu_is_one_line_and_exit_code_1(tiny_scenario, tiny_folder, tmp_path, capsys):
    out = tmp_path / "out"
    argv = ["run", str(tiny_scenario), "--fmu-dir", str(tiny_folder), "--out", str(out)]
    assert main([*argv, "--set", "signals.speed=9500"]) == 1
    assert one_line(capsys.readouterr().err) == (
        "spindle-drift: error: plant FMU at 0 s: the step failed (discard): "
        "this plant bursts at 9000 r/min"
    )
    assert not out.exists()


@pytest.mark.parametrize(
    ("error", "code", "lines"),
    [(KeyboardInterrupt(), 130, 1), (ZeroDivisionError("oops"), 1, None)],
)
def test_interruption_and_bugs(error, code, lines, monkeypatch, capsys):
    def fail(argv: list[str]) -> int:
        raise error

    monkeypatch.setattr(cli, "_run", fail)
    assert main(["list"]) == code
    said = capsys.readouterr().err
    if lines is None:
        assert "Traceback" in said
        assert "ZeroDivisionError: oops" in said
    else:
        assert len(said.splitlines()) == lines
        assert "Traceback" not in said


def test_items_in_a_compensator_file_are_counted_from_one(monkeypatch, refused):
    def fail(argv: list[str]) -> int:
        raise ModelFileError("c.json", "chosen.1", "no")

    monkeypatch.setattr(cli, "_run", fail)
    assert refused(["list"]) == "spindle-drift: error: c.json: chosen, item 2: no"


@pytest.mark.parametrize("script", [False, True])
def test_an_interruption_while_modules_are_imported_is_one_line(script):
    declared = tomllib.loads(PROJECT.read_text())["project"]["scripts"]["spindle-drift"]
    module, _, function = declared.partition(":")
    start = f"from {module} import {function}; sys.exit({function}())"
    if script:
        start = f"runpy.run_path({str(PROJECT.with_name('build_fmu.py'))!r}, run_name='__main__')"
    code = f"""if True:
        import runpy, signal, sys
        class Interrupting:
            def find_spec(self, name, *_):
                if name == "argparse":
                    signal.raise_signal(signal.SIGINT)
        sys.meta_path.insert(0, Interrupting())
        {start}"""
    done = run(sys.executable, "-c", code)
    assert done.returncode == 130
    assert one_line(done.stderr).startswith("spindle-drift: error: interrupted")


def test_an_interrupted_build_is_one_line_and_leaves_nothing(tmp_path):
    code = """if True:
        import runpy, signal, sys
        from scenarios.building import Job
        Job.run = lambda self: signal.raise_signal(signal.SIGINT)
        runpy.run_path(sys.argv.pop(1), run_name="__main__")"""
    build = PROJECT.with_name("build_fmu.py")
    done = run(sys.executable, "-c", code, build, "--only", "compensator", "--out", tmp_path)
    assert done.returncode == 130
    assert one_line(done.stderr).startswith("spindle-drift: error: interrupted")
    assert list(tmp_path.iterdir()) == []


class Deleted:
    """Gets SIGTERM while it is deleted, where no exception gets out."""

    def __del__(self) -> None:
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(0.01)


def terminated_while_deleted(argv: list[str]) -> int:
    del argv
    Deleted()
    time.sleep(PATIENCE_S)
    pytest.fail("the signal was not sent again")


def terminated_and_swallowed(argv: list[str]) -> int:
    del argv
    with contextlib.suppress(BaseException):
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(0.01)
    return 0


def terminated_swallowed_and_at_work(argv: list[str]) -> int:
    terminated_and_swallowed(argv)
    time.sleep(PATIENCE_S)
    pytest.fail("the signal was not sent again")


def terminated_again_while_cleaning_up(argv: list[str]) -> int:
    del argv
    try:
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(PATIENCE_S)
    finally:
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(0.01)
        print("cleaned up", file=sys.stderr)
    return 0


WAYS = [terminated_while_deleted, terminated_and_swallowed, terminated_swallowed_and_at_work]


@pytest.mark.parametrize("work", WAYS)
def test_a_termination_that_gets_lost_still_ends_the_program(work, monkeypatch, capsys):
    before = signal.getsignal(signal.SIGTERM), sys.unraisablehook
    monkeypatch.setattr(cli, "_run", work)
    assert main([]) == 143
    assert "terminated" in one_line(capsys.readouterr().err)
    assert (signal.getsignal(signal.SIGTERM), sys.unraisablehook) == before


def test_a_termination_does_not_cut_the_clean_up_short(monkeypatch, capsys):
    monkeypatch.setattr(cli, "_run", terminated_again_while_cleaning_up)
    assert main([]) == 143
    assert capsys.readouterr().err.startswith("cleaned up")


def test_no_command_shows_the_help(prints):
    assert "examples:" in prints([])


def test_version(prints):
    assert prints(["--version"]).startswith("spindle-drift ")


def test_fmus_are_built_where_the_gateway_looks_for_them():
    parser = argparse.ArgumentParser()
    gateway.add_arguments(parser)
    looked = parser.get_default("fmu_dir")
    assert build_command._arguments([]).out == looked
