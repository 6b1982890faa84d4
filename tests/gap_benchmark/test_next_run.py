"""One more run of a case's machine, and asking again with it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from benchmarks.gap import next_run
from benchmarks.gap.ask import runs_of
from benchmarks.gap.make import write_case
from benchmarks.gap.plan import case_of, plan
from benchmarks.gap.truth.case import simulate_case, simulate_further
from benchmarks.gap.truths import TRUTHS

STRETCHES = [[0.0, 9000.0], [10800.0, 0.0]]
SPEEDS = [(time, speed) for time, speed in STRETCHES]


def test_one_more_run_is_of_the_same_machine_at_the_speeds_asked_for() -> None:
    case = plan("development", 1, kind="effect")[0].case
    further = simulate_further(case, {"speed": SPEEDS})
    frame = further.frame
    late = frame["time_s"] > 10800.0
    assert set(frame.loc[late, "speed_rpm"]) == {0.0}
    assert set(frame.loc[~late & (frame["time_s"] < 10700.0), "speed_rpm"]) == {9000.0}
    known = [run for run in simulate_case(case)[0] if run.name != "holdout"]
    # Another day, the same instruments: noise of the same size, other values.
    first = known[0].frame["T1_degC"] - known[0].exact["T1_degC"]
    other = frame["T1_degC"] - further.exact["T1_degC"]
    assert np.std(other) == pytest.approx(np.std(first), rel=0.2)
    again = simulate_further(case, {"speed": SPEEDS})
    pd.testing.assert_frame_equal(frame, again.frame)
    assert simulate_further(case, {}).drive.family != "asked for"


@pytest.mark.parametrize(("name", "feed"), [("lathe", "feed"), ("belt", "feed_z")])
def test_the_other_simulators_make_one_more_run_too(name: str, feed: str) -> None:
    truth = TRUTHS[name]
    assert truth.further is not None
    record = {"simulator": name, "split": "development", "number": 2, "noise": 1.0}
    case = case_of(record)
    (planned,) = (one for one in plan("development", 9, truth=name) if one.number == 2)
    assert case == planned.case
    held = {"speed": [(0.0, 1500.0), (7200.0, 0.0)], feed: [(0.0, 0.0), (3600.0, 4000.0)]}
    short = replace(case, resolution=0.5)
    frame = truth.further(short, held).frame
    moved = next(frame[column] for column in frame if column.startswith("feed"))
    late = frame["time_s"] >= 7200.0
    assert set(frame.loc[late, "speed_rpm"]) == {0.0}
    assert set(frame.loc[~late, "speed_rpm"]) == {1500.0}
    assert set(moved[frame["time_s"] < 3600.0]) == {0.0}
    assert set(moved[frame["time_s"] >= 3600.0]) == {4000.0}
    assert set(frame.columns) == set(truth.simulate(replace(short, runs=("run_1",)))[0][0].frame)
    # At random it is another kind of test, on the same machine.
    assert truth.further(short, {}).drive.family != "asked for"


def test_asks_again_with_both_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (planned,) = plan("development", 1, kind="effect")
    write_case(planned, tmp_path)
    truth = json.loads((tmp_path / "answers" / f"{planned.files}.json").read_text())["effects"]
    record = {
        "name": planned.name,
        "number": planned.number,
        "split": "development",
        "kind": "effect",
        "noise": 1.0,
        "without": [],
        "truth": truth,
        "answer": {
            "verdict": "one_of",
            "effects": [{"name": truth[0]["name"], "channel": truth[0]["channel"]}],
            "one_of": [truth[0]["name"], "radiation"],
            "one_of_keys": [truth[0]["name"], "radiation"],
            "next_run": {"stretches": {"speed": STRETCHES}},
        },
    }
    records = tmp_path / "records"
    records.mkdir()
    (records / f"{planned.name}.json").write_text(json.dumps(record))
    asked: list[list[str]] = []

    def ask(folder: Path, without: list[str]) -> dict[str, Any]:
        runs, unseen = runs_of(folder)
        asked.append([run.name for run in (*runs, *unseen)])
        effect = {"name": truth[0]["name"], "channel": truth[0]["channel"]}
        return {"answer": {"verdict": "effect", "effects": [effect], "one_of": []}}

    monkeypatch.setattr(next_run, "ask", ask)
    assert next_run.main([str(tmp_path)]) == 0
    assert asked == [[*(f"run_{i}" for i in range(1, 6)), "holdout"]] * 2
    found = json.loads((tmp_path / "next_run" / f"{planned.name}.json").read_text())
    assert found["asked for"]["outcome"] == found["at random"]["outcome"] == "right"
    assert next_run.main([str(tmp_path)]) == 0
    assert len(asked) == 2
    assert "| asked for | 1 |" in next_run.table([found])


def test_what_is_said_of_a_pair_stands_in_the_table() -> None:
    found = {"asked for": {"outcome": "both"}, "at random": {"outcome": "one of the two"}}
    assert next_run.table([found]).splitlines()[-1] == "| at random | 0 | 1 |"


def test_without_a_question_that_asks_for_a_run_nothing_is_done(tmp_path: Path) -> None:
    with pytest.raises(SystemExit):
        next_run.main([str(tmp_path)])
