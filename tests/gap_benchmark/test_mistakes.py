"""The benchmark of mistakes in a machine's description."""

from benchmarks.gap.mistakes import Mistake, mistakes
from gap_finder.kinds import kinds
from plant_model.machine_file import read_machine
from tests.gap_benchmark.made_up import answer


def test_saying_nothing_is_right_only_where_nothing_is_missing():
    lathe = read_machine("lathe")
    nothing = Mistake("nothing", (), lathe, lathe)
    assert nothing.outcome(answer()) == "right"
    assert nothing.outcome(answer(verdict="unknown")) == "unknown"
    assert Mistake("heat_source", ("z_nut",), lathe, lathe).outcome(answer()) == "none"


def test_every_kind_of_change_is_made_but_the_one_that_runs_decide():
    given = read_machine("lathe")
    made = mistakes(given)
    assert {one.kind for one in made} == {"nothing", *kinds()} - {"start_state"}
    for one in made[1:]:
        assert one.truth != one.told
        assert given in (one.truth, one.told)
