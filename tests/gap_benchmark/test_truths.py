"""More than one truth: plans of their own, owner's files, and what their mistakes count for."""

import json
from typing import Any

import pytest

from benchmarks.gap import table
from benchmarks.gap.outcome import groups_of, outcome, outcome_of_mistake
from benchmarks.gap.plan import trials
from benchmarks.gap.records import Record
from benchmarks.gap.truths import TRUTHS
from tests.gap_benchmark.made_up import Folder, added, answer, hidden, plan

NUT = {"kind": "heat_source", "place": ["z_nut", "feed_z"]}
SOURCE, RADIATION = {"name": NUT["kind"], "place": NUT["place"]}, {"name": "radiation"}


def change(name: str, *place: str, or_else: list[Any] | None = None) -> dict[str, Any]:
    entry = {"name": name, "place": list(place), "parameters": {}}
    return entry | {"or_else": or_else or [], "other_places": []}


def test_every_truth_has_seeds_of_its_own():
    seeds = [{one.case.seed for one in plan("reported", 300, truth=name)} for name in TRUTHS]
    assert all(len(some) == 300 for some in seeds)
    assert not set.intersection(*seeds)


def test_a_plan_holds_mistakes_and_what_is_larger_than_usual():
    truth = TRUTHS["belt"]
    asked = [case[0] for case in trials("development", 200, truth="belt")]
    made = {one.case.mistake for one in asked if one.kind == "mistake"}
    assert made == set(truth.shop.mistakes)
    larger = {one.case.hidden[0][:2] for one in asked if one.kind == "beyond"}
    assert larger == set(truth.beyond.items())
    assert not any(one.case.mistake for one in asked if one.kind == "none")
    flawed = [bool(one.case.mistake) for one in asked if one.case.hidden]
    assert 0.15 < sum(flawed) / len(flawed) < 0.35


@pytest.mark.parametrize(
    ("effects", "verdict", "told"),
    [
        ([change("heat_source", "z_nut", "feed_z")], "effect", "right"),
        ([change("heat_source", "z_nut")], "effect", "right place"),
        ([change("hidden_mass", "z_nut", or_else=[SOURCE])], "one_of", "one of"),
        ([change("hidden_mass", "z_nut", or_else=[RADIATION])], "one_of", "right place"),
        ([change("heat_source", "column")], "effect", "wrong"),
        ([change("heat_source", "feed_z", "z_nut")], "effect", "right"),
        ([added("sensor_offset:PT08")], "effect", "wrong"),
        ([], "unknown", "unknown"),
        ([], "none_missing", "none"),
    ],
)
def test_a_mistake_is_right_by_kind_and_place(effects, verdict, told):
    assert outcome_of_mistake(NUT, answer(*effects) | {"verdict": verdict}) == told


def test_naming_a_mistake_that_is_there_is_not_wrong():
    said = answer(change("heat_source", "z_nut", "feed_z"), one_of=())
    assert groups_of(said) == [("heat_source:z_nut+feed_z",)]
    left = groups_of(said, [NUT])
    assert left == []
    assert outcome("none", [], left, "effect") == "none"
    assert outcome("effect", [hidden("windage")], left, "effect") == "none"
    assert outcome("none", [], groups_of(said), "effect") == "named"


def test_the_error_that_a_mistake_of_the_file_leaves_is_not_the_strength_of_an_effect():
    told = {"answer": answer(gap=(9.0, 4.0))}
    assert Record(told, 3.0, matched=False).strength == "strong"
    assert Record(told | {"mistakes": [NUT]}, 3.0, matched=False).strength == "unmeasured"
    assert Record(told | {"mistakes": [NUT]}, 3.0, matched=True).strength == "strong"


def test_the_figures_of_several_simulators_stand_side_by_side(tmp_path, capsys, monkeypatch):
    page = tmp_path / "page.md"
    page.write_text("<!-- begin simulators: x -->\nstale\n<!-- end simulators -->\n")
    monkeypatch.setattr(table, "PAGE", page)
    for name, effects in (("jig_borer", ("windage",)), ("belt", ("windage", "radiation"))):
        folder = Folder(tmp_path / name / "records")
        for number, effect in enumerate(effects):
            told = answer(added("windage"), one_of=("windage",), gap=(9.0, 4.0))
            folder.put("effect", [hidden(effect)], told, empty=3.0)
            path = folder.folder / f"{number + 1:04d}.json"
            record = json.loads(path.read_text()) | {"simulator": name}
            path.write_text(json.dumps(record))
    arguments = [str(tmp_path / "jig_borer"), "--beside", str(tmp_path / "belt"), "--docs"]
    assert table.main(arguments) == 0
    rows = capsys.readouterr().out.splitlines()
    assert page.read_text().splitlines()[2:-2] == rows
    assert rows[0] == "|  | Target | all | jig_borer | belt |"
    (strong,) = (row for row in rows if row.startswith("| Named right, strong effect"))
    shares = ("2 of 3 (67 %)", "1 of 1 (100 %)", "1 of 2 (50 %)")
    for cell, share in zip(strong.split("|")[3:6], shares, strict=True):
        assert share in cell
    assert "| Questions |  | 3 | 1 | 2 |" in rows
