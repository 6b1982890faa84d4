"""Runs that say that they began warm."""

import pandas as pd

from measurement.runs import Run
from measurement.warm import cold_starts


def run(name: str, mark: float | None) -> Run:
    frame = pd.DataFrame({"time_s": [0.0, 1.0], "T1_degC": [20.0, 21.0]})
    return Run(name, frame if mark is None else frame.assign(warm_start_1=mark))


def test_warm_restarts_are_left_out_where_others_are_there():
    runs = [run("a", 1.0), run("b", None), run("c", 0.0), run("d", 1.0)]
    kept, note = cold_starts(runs)
    assert [one.name for one in kept] == ["b", "c"]
    assert note == (
        "left out, since the machine was warm when they began: a, d; use them by themselves, or "
        "without the column warm_start_1"
    )
    assert cold_starts(kept) == (kept, "")
    kept, note = cold_starts([runs[0], runs[3]])
    assert [one.name for one in kept] == ["a", "d"]
    assert note == "all runs began warm: what they teach holds for warm restarts"
