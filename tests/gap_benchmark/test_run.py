"""Asking about many cases: what is asked, what is hidden, and going on where it was stopped."""

import json
from collections import Counter
from pathlib import Path
from typing import Any

import pytest

from benchmarks.gap import run
from benchmarks.gap.plan import balanced
from tests.gap_benchmark.made_up import plan

ARGUMENTS = ["--split", "development", "--workers", "1"]


def _kinds(records: Path) -> dict[str, dict[str, Any]]:
    return {path.stem: json.loads(path.read_text()) for path in sorted(records.glob("*.json"))}


@pytest.fixture
def calls(monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, tuple[str, ...]]]:
    """Stand in for the gap finder, and note what it was asked."""
    found: list[tuple[str, tuple[str, ...]]] = []

    def ask(folder: Path, without: tuple[str, ...] = ()) -> dict[str, Any]:
        assert sorted(path.name for path in folder.iterdir()) == [
            "holdout.csv",
            *(f"run_{i}.csv" for i in range(1, 5)),
        ]
        found.append((folder.name, tuple(without)))
        return {"answer": {"verdict": "none_missing"}}

    monkeypatch.setattr(run, "ask", ask)
    monkeypatch.setattr(run, "ask_empty", lambda folder: ask(folder, ("only calibrated",)))
    return found


def test_records_hold_question_truth_and_answer(tmp_path, calls):
    wanted = ["--effect", "windage", "--size", "strong", "--kind", "effect", "deleted"]
    assert run.main([*ARGUMENTS, *wanted, "--cases", "1", "--out", str(tmp_path)]) == 0
    (name,) = {folder.partition("_")[0] for folder, _ in calls}
    assert calls == [(f"{name}_empty", ("only calibrated",)), (name, ()), (name, ("windage",))]
    records = _kinds(tmp_path / "records")
    assert list(records) == [name, f"{name}_deleted", f"{name}_empty"]
    assert [one["kind"] for one in records.values()] == ["effect", "deleted", "empty"]
    assert [one["without"] for one in records.values()] == [[], ["windage"], []]
    assert [len(one["truth"]) for one in records.values()] == [1, 1, 0]
    assert records[name]["truth"][0]["name"] == "windage"
    assert records[name]["answer"] == {"verdict": "none_missing"}


def test_what_was_stopped_goes_on_and_nothing_is_asked_twice(tmp_path, calls, monkeypatch, capsys):
    arguments = [*ARGUMENTS, "--cases", "2", "--kind", "none", "--out", str(tmp_path)]
    kept = run.ask
    first, second = (one.files for one in plan("development", 2, ("none",)))

    def breaks(folder: Path, without: tuple[str, ...] = ()) -> dict[str, Any]:
        if folder.name == second:
            raise RuntimeError("a bug")
        return kept(folder, without)

    monkeypatch.setattr(run, "ask", breaks)
    assert run.main(arguments) == 1
    assert f"case {second} failed" in (error := capsys.readouterr().err)
    assert "a bug" in error
    assert list(_kinds(tmp_path / "records")) == [first]
    monkeypatch.setattr(run, "ask", kept)
    assert run.main(arguments) == 0
    assert list(_kinds(tmp_path / "records")) == [first, second]
    assert run.main(arguments) == 0
    assert [folder for folder, _ in calls] == [first, second]


def test_a_balanced_sample_has_every_kind_and_size():
    asked = [one for case in balanced("development", 2, "lathe") for one in case]
    counted = Counter(one.kind for one in asked)
    assert counted == {"none": 2, "pair": 2, "beyond": 2, "mistake": 2, "effect": 6, "deleted": 4}
    sizes = Counter(one.case.hidden[0][1] for one in asked if one.kind == "effect")
    assert sizes == {"weak": 2, "medium": 2, "strong": 2}
    assert not {one.case.seed for one in asked} & {
        one.case.seed for case in balanced("second", 2, "lathe") for one in case
    }
