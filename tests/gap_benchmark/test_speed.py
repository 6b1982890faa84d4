"""The gap finder's shortcuts give the plain way's answers."""

from __future__ import annotations

import pytest

from benchmarks.gap import speed


def test_shortcuts_give_the_same_answers(capsys: pytest.CaptureFixture[str]) -> None:
    assert speed.main(["jig_borer_lumps", "--hours", "1", "--times", "1"]) == 0
    rows = capsys.readouterr().out.splitlines()[2:]
    assert len(rows) == 4
    for row in rows:
        ratio, off = (float(number) for number in row.split()[:2])
        assert ratio > 0.0
        assert off < 0.1  # of a sensor's tolerance
