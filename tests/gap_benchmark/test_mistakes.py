"""The benchmark of mistakes in a machine's description."""

from __future__ import annotations

from typing import Any

import pytest

from benchmarks.gap.mistakes import Mistake, mistakes, outcome, runs_of
from gap_finder.kinds import kinds
from plant_model.machine_file import read_machine

NUT = Mistake("heat_source", ("z_nut",))
RIGHT = ["heat_source", ["z_nut"]]


@pytest.mark.parametrize(
    ("named", "rivals", "told"),
    [
        ([RIGHT], [], "right"),
        ([RIGHT], [["hidden_mass", ["z_nut"]]], "one of"),
        ([["hidden_mass", ["z_nut"]]], [RIGHT], "one of"),
        ([["hidden_mass", ["z_nut"]]], [], "right place"),
        ([["heat_source", ["tray"]]], [], "wrong"),
        ([["sensor_offset", "PT08"]], [], "wrong"),
        ([], [], "silent"),
    ],
)
def test_what_counts_as_right(named: list[Any], rivals: list[Any], told: str) -> None:
    assert outcome(NUT, named, rivals, "effect" if named else "unknown") == told


def test_a_path_has_no_direction() -> None:
    path = Mistake("heat_path", ("tray", "air"))
    assert outcome(path, [["heat_path", ["air", "tray"]]], [], "effect") == "right"


def test_saying_nothing_is_right_only_where_nothing_is_missing() -> None:
    assert outcome(Mistake("nothing", ()), [], [], "none_missing") == "right"
    assert outcome(Mistake("nothing", ()), [], [], "unknown") == "silent"


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
