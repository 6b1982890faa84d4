"""A naming threshold that is set on some simulators and judged on another."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from benchmarks.gap.in_turn import best_share, counted, main, table
from benchmarks.gap.records import Record
from tests.gap_benchmark.made_up import added, answer, hidden


def record(
    simulator: str, truth: str, named: str, share: float, *, kind: str = "effect"
) -> dict[str, Any]:
    told = answer(added(named)) if named else answer(verdict="unknown")
    first = {"one_of": [named] if named else [], "explained_share": share}
    return {
        "name": "0000",
        "number": 0,
        "simulator": simulator,
        "kind": kind,
        "truth": [hidden(truth)],
        "answer": told,
        "details": {"rounds": [first]},
    }


def records(*tables: dict[str, Any]) -> list[Record]:
    return [Record(table, 1.0, matched=True) for table in tables]


SURE = [record("lathe", "windage", "windage", 0.9) for _ in range(4)]
FALSE = record("lathe", "windage", "radiation", 0.22)
FALSELY = record("belt", "windage", "radiation", 0.35, kind="deleted")
FAINT = record("belt", "windage", "windage", 0.17)


def test_what_would_be_said_at_a_stricter_threshold() -> None:
    some = records(*SURE, FALSE, FALSELY, FAINT)
    assert dict(counted(some, 0.15)) == {"hit": 5, "miss": 2}
    assert dict(counted(some, 0.25)) == {"hit": 4, "miss": 1, "silent": 2}
    assert dict(counted(some, 0.6)) == {"hit": 4, "silent": 3}


def test_a_change_of_the_description_does_not_depend_on_it() -> None:
    told = record("lathe", "windage", "radiation", 0.1)
    told["details"]["rounds"][0]["one_of"] = []
    assert dict(counted(records(told), 0.6)) == {"miss": 1}


def test_the_lowest_of_equals_is_taken() -> None:
    assert best_share(records(*SURE)) == 0.15
    assert best_share(records(*SURE, FALSE)) == 0.25
    # One right name less is a lower price than one wrong name.
    assert best_share(records(*SURE, FALSELY, FAINT)) == 0.4


def test_each_is_judged_at_what_the_others_chose() -> None:
    told = table({"lathe": records(*SURE, FALSE), "belt": records(FALSELY, FAINT)}).splitlines()
    assert told[2] == "| lathe | 5 | 40% | 4 | 0 | 4 | 1 |"
    assert told[3] == "| belt | 2 | 25% | 0 | 1 | 1 | 1 |"


def test_it_reads_folders(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name, one in (("a", SURE[0]), ("b", FALSELY)):
        (tmp_path / name / "records").mkdir(parents=True)
        whole = one | {"answer": one["answer"] | {"data_faults": []}}
        (tmp_path / name / "records" / "0000.json").write_text(json.dumps(whole))
    assert main([str(tmp_path / "a"), str(tmp_path / "b")]) == 0
    assert "| lathe | 1 |" in capsys.readouterr().out
    with pytest.raises(SystemExit):
        main([str(tmp_path / "a")])
    assert "two simulators or more" in capsys.readouterr().err
