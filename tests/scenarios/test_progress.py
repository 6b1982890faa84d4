"""What long work says where standard error is no terminal."""

import time

from scenarios import progress


def test_a_line_is_written_as_long_as_it_takes(monkeypatch, capsys):
    monkeypatch.setattr(progress, "SPEAKS_S", 0.05)
    with progress.spoken() as say:
        say("calibrating")
        deadline = time.monotonic() + 10.0
        written = ""
        while written.count("calibrating") < 2 and time.monotonic() < deadline:
            time.sleep(0.02)
            written += capsys.readouterr().err
        say("screening")
        while "screening" not in written and time.monotonic() < deadline:
            time.sleep(0.02)
            written += capsys.readouterr().err
    lines = written.splitlines()
    assert lines[0].endswith(" s: calibrating")
    assert lines[-1].endswith(" s: screening")
