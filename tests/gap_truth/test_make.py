"""The command that writes cases."""

from __future__ import annotations

import json
from pathlib import Path

from benchmarks.gap.hidden import SIZES
from benchmarks.gap.make import main
from benchmarks.gap.plan import SPLITS, plan
from benchmarks.gap.truths import TRUTHS

CATALOGUE = TRUTHS["jig_borer"].catalogue


def test_a_block_of_the_plan_holds_everything() -> None:
    cases = plan("development", 143)
    single = [one.case.hidden[0][:2] for one in cases if one.kind == "effect"]
    assert sorted(single) == sorted((name, size) for name in CATALOGUE for size in SIZES)
    kinds = {kind: sum(one.kind == kind for one in cases) for kind in {c.kind for c in cases}}
    assert min(kinds.values()) >= 12
    assert set(kinds) == {"none", "effect", "outside", "pair"}


def test_the_splits_share_nothing() -> None:
    seeds = [{one.case.seed for one in plan(split, 300)} for split in SPLITS]
    assert not seeds[0] & seeds[1]
    orders = [[one.kind for one in plan(split, 60)] for split in SPLITS]
    assert orders[0] != orders[1]


def test_cases_are_written_resumed_and_say_nothing(tmp_path: Path) -> None:
    arguments = ["--split", "development", "--cases", "1", "--out", str(tmp_path)]
    arguments += ["--kind", "effect", "--workers", "1"]
    assert main(arguments) == 0
    (answer,) = (tmp_path / "answers").glob("*.json")
    table = json.loads(answer.read_text())
    folder = tmp_path / "cases" / answer.stem
    files = sorted(path.name for path in folder.iterdir())
    assert files == ["holdout.csv", "run_1.csv", "run_2.csv", "run_3.csv", "run_4.csv"]
    name = table["effects"][0]["name"]
    assert name in CATALOGUE
    assert all(name not in path.read_text() for path in folder.iterdir())
    before = (folder / "run_1.csv").read_bytes()
    (folder / "run_1.csv").write_text("kept")
    assert main(arguments) == 0
    assert (folder / "run_1.csv").read_text() == "kept"
    answer.unlink()
    assert main(arguments) == 0
    assert (folder / "run_1.csv").read_bytes() == before
