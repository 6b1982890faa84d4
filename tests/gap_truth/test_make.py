"""What the plan holds, and cases written as files."""

import json

from benchmarks.gap.hidden import SIZES
from benchmarks.gap.make import case_folder, write_case
from benchmarks.gap.plan import SPLITS
from benchmarks.gap.truths import TRUTHS
from tests.gap_benchmark.made_up import plan

CATALOGUE = TRUTHS["jig_borer"].catalogue


def test_a_block_of_the_plan_holds_everything():
    cases = plan("development", 143)
    single = [one.case.hidden[0][:2] for one in cases if one.kind == "effect"]
    assert sorted(single) == sorted((name, size) for name in CATALOGUE for size in SIZES)
    kinds = {kind: sum(one.kind == kind for one in cases) for kind in {c.kind for c in cases}}
    assert min(kinds.values()) >= 12
    assert set(kinds) == {"none", "effect", "outside", "pair"}


def test_the_splits_share_nothing():
    seeds = [{one.case.seed for one in plan(split, 300)} for split in SPLITS]
    assert not seeds[0] & seeds[1]
    orders = [[one.kind for one in plan(split, 60)] for split in SPLITS]
    assert orders[0] != orders[1]


def test_cases_are_written_resumed_and_say_nothing(tmp_path):
    (planned,) = plan("development", 1, ("effect",))
    answer = write_case(planned, tmp_path)
    (effect,) = json.loads(answer.read_text())["effects"]
    folder = case_folder(planned, tmp_path)
    files = sorted(path.name for path in folder.iterdir())
    assert files == ["holdout.csv", "run_1.csv", "run_2.csv", "run_3.csv", "run_4.csv"]
    assert effect["name"] in CATALOGUE
    assert all(effect["name"] not in path.read_text() for path in folder.iterdir())
    before = (folder / "run_1.csv").read_bytes()
    (folder / "run_1.csv").write_text("kept")
    write_case(planned, tmp_path)
    assert (folder / "run_1.csv").read_text() == "kept"
    answer.unlink()
    write_case(planned, tmp_path)
    assert (folder / "run_1.csv").read_bytes() == before
