"""What counts as right, and the tables and figures made from it."""

from pathlib import Path

import pytest

from benchmarks.gap import sections, table
from benchmarks.gap.outcome import groups_of, outcome
from benchmarks.gap.records import read_records
from tests.gap_benchmark.made_up import THERMOMETER, Folder, added, answer, hidden

WINDAGE, RADIATION, SHIFT = added("windage"), added("radiation"), added("centrifugal_shift")


@pytest.mark.parametrize(
    ("truth", "told", "expected"),
    [
        (["windage"], answer(WINDAGE, one_of=("windage",)), "right"),
        (["windage"], answer(WINDAGE, one_of=("windage", "radiation")), "one of"),
        (["windage"], answer(RADIATION, one_of=("radiation", "windage")), "one of"),
        (["windage"], answer(RADIATION, one_of=("radiation", "copper_loss")), "wrong"),
        (["windage"], answer(RADIATION, WINDAGE, one_of=("radiation",)), "right and another"),
        (["windage"], answer(), "none"),
        (["windage"], answer(verdict="unknown"), "unknown"),
        # Which driver it is may be open: it is the same effect.
        (["windage"], answer(WINDAGE, one_of=("windage:hall", "windage:bed")), "right"),
        ([THERMOMETER], answer(added(THERMOMETER), one_of=(THERMOMETER,)), "right"),
        ([THERMOMETER], answer(added("sensor_offset:T4"), one_of=("sensor_offset:T4",)), "wrong"),
        ([THERMOMETER], answer(added("sensor_drift:T3"), one_of=("sensor_drift:T3",)), "wrong"),
    ],
)
def test_one_effect(truth, told, expected):
    hidden_effects = [hidden(key) for key in truth]
    assert outcome("effect", hidden_effects, groups_of(told), told["verdict"]) == expected


@pytest.mark.parametrize(
    ("told", "expected"),
    [
        (answer(WINDAGE, RADIATION, one_of=("windage",)), "both"),
        (answer(RADIATION, one_of=("radiation",)), "one of the two"),
        (answer(WINDAGE, SHIFT, one_of=("windage",)), "right and another"),
        (answer(SHIFT, one_of=("centrifugal_shift",)), "wrong"),
        (answer(SHIFT, one_of=("centrifugal_shift", "windage")), "one of the two"),
        (answer(verdict="unknown"), "unknown"),
    ],
)
def test_two_effects(told, expected):
    truth = [hidden("windage"), hidden("radiation")]
    assert outcome("pair", truth, groups_of(told), told["verdict"]) == expected


def test_a_sensor_may_be_left_out_as_broken():
    truth = [hidden(THERMOMETER)]
    assert outcome("effect", truth, [], "none_missing", {"T3"}) == "left out as broken"
    assert outcome("effect", truth, [], "none_missing", {"T4"}) == "none"
    assert outcome("effect", [hidden("windage")], [], "unknown", {"T3"}) == "unknown"
    assert outcome("effect", truth, [("windage",)], "effect", {"T3"}) == "wrong"


@pytest.mark.parametrize("kind", ["none", "deleted", "outside"])
def test_every_name_is_false_where_nothing_of_the_catalogue_is_missing(kind):
    truth = [] if kind == "none" else [hidden("windage")]
    told = answer(RADIATION, one_of=("radiation",))
    assert outcome(kind, truth, groups_of(told), "effect") == "named"
    assert outcome(kind, truth, [], "unknown") == "unknown"
    assert outcome(kind, truth, [], "none_missing") == "none"


@pytest.mark.parametrize(
    ("places", "told"),
    [
        ([("bed",)], "in other words"),
        ([("bed", "feed")], "named"),
        ([("column",)], "named"),
        ([("bed",), ("column",)], "named"),
        ([("motor", "air", "speed"), ("bed",)], "in other words"),
        ([("air", "speed")], "named"),
    ],
)
def test_a_change_of_the_file_may_say_what_no_catalogue_holds(places, told):
    words = [
        {"kind": "heat_source", "place": ["bed"]},
        {"kind": "heat_source", "place": ["*", "air", "speed"]},
    ]
    truth = [hidden("chip_heap") | {"in_other_words": words}]
    named = [{"name": "heat_source", "place": list(place)} for place in places]
    groups = groups_of({"effects": named, "one_of": []})
    assert outcome("outside", truth, groups, "effect") == told
    # Where the catalogue has a name for it, that is asked for.
    assert outcome("effect", truth, groups, "effect") == "wrong"


@pytest.fixture
def records(tmp_path: Path) -> Folder:
    """One record of everything that the tables tell apart."""
    folder = Folder(tmp_path / "records")
    within = added("windage", power=(80.0, 110.0, 120.0))
    right = answer(within, one_of=("windage",), gap=(9.0, 4.0))
    folder.put("effect", [hidden("windage", amplitude=100.0)], right, empty=3.0)
    weak = answer(RADIATION, one_of=("radiation",), gap=(3.2, 3.1))
    folder.put("effect", [hidden("windage", "weak")], weak, empty=3.0)
    folder.put("effect", [hidden(THERMOMETER, "medium")], answer(gap=(4.0, 4.0)), empty=2.5)
    folder.put("none", [], answer(gap=(3.0, 3.0)))
    doubtful = answer(WINDAGE, one_of=("windage",), gap=(5.0, 4.0), in_doubt=True)
    folder.put("none", [], doubtful)
    unsure = answer(verdict="unknown", gap=(8.0, 8.0))
    folder.put("deleted", [hidden("windage")], unsure, empty=4.0)
    folder.put("outside", [hidden("sun_patch")], answer(gap=(3.0, 3.0)))
    both = answer(WINDAGE, RADIATION, one_of=("windage",))
    folder.put("pair", [hidden("windage"), hidden("radiation")], both, empty=2.0)
    return folder


def test_the_figures_that_are_asked_for(records):
    shown = sections.targets(read_records(records.folder))
    cells = {row.split(" | ")[0].strip("| "): row.split(" | ")[2] for row in shown.splitlines()}
    assert cells["Falsely named, nothing missing"].startswith("1 of 2 (50 %)")
    assert cells["Falsely named, effect deleted from the catalogue"].startswith("0 of 1")
    assert cells["Named right, strong effect"].startswith("1 of 1")
    assert cells["Named wrong, weaker effect"].startswith("1 of 2")
    holding = next(value for name, value in cells.items() if name.startswith("Truth in"))
    assert holding.startswith("1 of 2 (50 %)")
    closed = next(value for name, value in cells.items() if "closed" in name)
    assert closed.strip(" |") == "83 %"
    sure = next(value for name, value in cells.items() if name.startswith("Nothing false"))
    assert sure.startswith("2 of 3 (67 %)")
    assert cells["... with a name and in doubt"].startswith("0 of 1")
    assert cells["Processor seconds a case: median"].strip(" |") == "45"


def test_the_command_writes_tables(records, tmp_path, capsys):
    assert table.main([str(tmp_path)]) == 0
    text = (tmp_path / "tables.md").read_text()
    assert capsys.readouterr().out.strip() == text.strip()
    assert "8 questions on 8 cases; 7 of them beside the same machine" in text
    assert "| Kind | Strength | Cases | both | named | none | right | unknown | wrong |" in text
    assert "| none | faint | 2 |  | 1 | 1 |  |  |  |" in text
