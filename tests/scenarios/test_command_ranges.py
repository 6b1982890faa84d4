"""Options whose value no file could hold: one line, exit code 2, nothing written."""

import pytest

from scenarios.cli import main


@pytest.mark.parametrize("every", ["nan", "1e-9", "1e9"])
def test_simulate_refuses_a_spacing(every, tmp_path, capsys):
    out = tmp_path / "run.csv"
    assert main(["simulate", "step_speed", "-o", str(out), "--every", every]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "--every: " in line
    assert not out.exists()


@pytest.mark.parametrize("length", ["nan", "1e9", "-1e9"])
def test_replay_refuses_a_tool_length(length, tmp_path, capsys):
    run, out = tmp_path / "run.csv", tmp_path / "out"
    run.write_text("time_s,T1_degC,S1_um\n0,20,0\n", encoding="utf-8")
    assert main(["replay", "x.json", str(run), f"--tool-length={length}", "--out", str(out)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "--tool-length: " in line
    assert not out.exists()
