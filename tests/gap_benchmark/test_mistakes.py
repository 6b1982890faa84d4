"""The benchmark of mistakes in a machine's description."""

from __future__ import annotations

from benchmarks.gap.mistakes import Mistake, mistakes, runs_of
from gap_finder.kinds import kinds
from plant_model.machine_file import read_machine
from tests.gap_benchmark.made_up import answer


def test_saying_nothing_is_right_only_where_nothing_is_missing() -> None:
    nothing = Mistake("nothing", ())
    assert nothing.outcome(answer()) == "right"
    assert nothing.outcome(answer(verdict="unknown")) == "unknown"
    assert Mistake("heat_source", ("z_nut",)).outcome(answer()) == "none"


def test_every_kind_of_change_is_made_but_the_one_that_runs_decide() -> None:
    given = read_machine("lathe")
    made = mistakes(given)
    assert {one.kind for one in made} == {"nothing", *kinds()} - {"start_state"}
    for one in made[1:]:
        truth, told = one.machines(given)
        assert truth != told
        assert given in (truth, told)


def test_runs_move_and_begin_apart() -> None:
    runs = runs_of(read_machine("lathe"))
    assert len({run.sha256 for run in runs}) == len(runs)
    for run in runs:
        assert run.frame["PT03_degC"].max() - run.frame["PT03_degC"].iloc[0] > 2.0
