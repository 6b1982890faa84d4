"""What the report says of channels and of what was left out."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gap_finder.comparison import GapComparison
from gap_finder.find import GapResult
from gap_finder.five_lines import _added, _left_out, five_lines
from gap_finder.forward_backward import Hypothesis, SearchResult
from gap_finder.observations import observe
from gap_finder.report import _evidence, _runners_up
from measurement.runs import Run
from tests.gap_finder.conftest import runs_of


def hypothesis(*keys: str, left: float, moved: float = 0.0) -> Hypothesis:
    """Return additions that leave as much in each run and channel, and move the file's numbers."""
    squares = np.full((4, 3), left)
    machine = SimpleNamespace(effects={}, inputs=())
    numbers = {"numbers_moved": moved, "others_moved": 0.0, "determined": 30.0}
    calibration = SimpleNamespace(cost=float(squares.sum()), starts_cost=0.0)
    fit: Any = SimpleNamespace(
        left=squares,
        cost=float(squares.sum()),
        machine=machine,
        calibration=calibration,
        **numbers,
    )
    added: Any = tuple(SimpleNamespace(key=key, size_cost=lambda: 0.0) for key in keys)
    return Hypothesis(added, (8.0,) * len(keys), fit)


def judged_of(best: Hypothesis, nothing: Hypothesis, *others: Hypothesis) -> Any:
    step: Any = SimpleNamespace(tried=(best, *others), fall=20.0)
    return SimpleNamespace(result=GapResult(SearchResult(nothing, best, (), (step,))))


@pytest.mark.parametrize(("left", "spared"), [(1.0, False), (5.1, True)])
def test_an_answer_that_mostly_spares_the_files_numbers_says_so(left, spared):
    nothing = hypothesis(left=5.0, moved=25.0)
    said = _evidence(judged_of(hypothesis("radiation", left=left, moved=5.0), nothing))
    assert said.startswith("it explains 0%" if spared else "it explains 80%")
    assert ("numbers then need to move less" in said) == spared


def test_runners_up_have_odds_against_the_answer():
    nothing, best = hypothesis(left=5.0), hypothesis("radiation", "windage", left=1.0)
    others = (hypothesis("windage", left=1.2), hypothesis("air_gap", left=2.0))
    (told,) = _runners_up(judged_of(best, nothing, *others))
    assert told["name"] == "air_gap"
    # 12 values of 2 and a prior of 8, against 12 of 1 and two priors: in units of 1, 4 more.
    assert told["probability"] == pytest.approx(1.0 / (1.0 + np.exp(2.0)), abs=1e-6)


def test_channels_are_judged_beside_no_model(jig_borer_lumps):
    *runs, last = runs_of(jig_borer_lumps)
    frame = last.frame.drop(columns="T7_degC")
    observed = observe(jig_borer_lumps, [Run(last.name, frame)])
    table = GapComparison(jig_borer_lumps, jig_borer_lumps, observed).channels()
    assert runs
    assert "T7" not in table
    values = frame["T1_degC"].to_numpy()
    moved = float(np.sqrt(np.mean((values - values[0]) ** 2)))
    assert table["T1"]["no_model"] == pytest.approx(moved, rel=0.05)
    assert table["T1"]["after"] < 0.1 * table["T1"]["no_model"]


def test_each_broken_channel_is_told_once():
    faults = [{"run": f"r{i}", "channel": "T1", "kind": "level_jump"} for i in range(5)]
    faults += [{"run": "r1", "channel": "x", "kind": "frozen"}] * 2
    told = " Left out as broken: T1 (wrong level in r0 and 4 more); x (frozen in r1)."
    assert _left_out(faults) == told
    assert _left_out([]) == ""


def test_a_number_without_a_unit_stands_alone():
    emissivity = {"value": 0.6, "low": 0.1, "high": 1.0, "unit": "1"}
    effect = {"name": "radiation", "parameters": {"emissivity": emissivity}}
    assert _added({"effects": [effect]}) == "radiation: emissivity = 0.6 (0.1 to 1)"


def answer(**more: Any) -> dict[str, Any]:
    """Return what gap.json holds where nothing was found, with *more*."""
    table = {
        "verdict": "none_missing",
        "in_doubt": False,
        "where": [],
        "data_faults": [],
        "effects": [],
        "runners_up": [],
        "evidence": {"doubt": ""},
        "remaining": {"is_adequate": True, "where": [], "share": 0.0, "numbers_off": 1.0},
        "look_at": [],
        "channels": {},
        "machine": "machine_after.toml",
        "gap": {"holdout": {"before": 0.9, "after": 0.9, "reference": 1.7, "floor": 0.5}},
    }
    return table | more


def entry(name: str, *rivals: dict[str, Any], **more: Any) -> dict[str, Any]:
    """Return an effect of the answer."""
    told = {"name": name, "title": name, "rivals": rivals, "parameters": {}}
    usual = {"larger_than_usual": [], "evidence": "it explains 74 %"}
    return told | usual | more


@pytest.mark.parametrize("in_doubt", [True, False])
def test_the_first_line_of_a_name_in_doubt_says_what_it_may_be_instead(in_doubt):
    table = answer(
        verdict="effect",
        effects=[entry("windage", title="Windage")],
        runners_up=[{"name": "motor_iron_loss", "probability": 0.2}],
        look_at=["links.film.coefficient is 9 where the file has 3: far from usual"],
        in_doubt=in_doubt,
        evidence={"doubt": "too much error remains" if in_doubt else ""},
    )
    missing = five_lines(table)[0]
    doubted = "What may be missing: Windage. In doubt: too much error remains, so the"
    assert missing.startswith(doubted) == in_doubt
    assert missing.startswith("What is missing: Windage;") != in_doubt
    assert ("may instead, or also, be motor_iron_loss, or" in missing) == in_doubt
    assert ("Check: links.film.coefficient" in missing) == in_doubt
    alone = five_lines(table | {"runners_up": []})[0]
    assert ("may instead, or also, be something not in the catalogue" in alone) == in_doubt


def test_what_the_runs_do_not_exclude_is_told_beside_each_name():
    place = {"name": "sensor_place", "place": ["T1", "head"]}
    lag = entry("sensor_lag", place, {"name": "sensor_lag", "channel": "T2"}, channel="T1")
    effects = [entry("windage"), lag]
    table = answer(verdict="one_of", effects=effects, separate_by="a second thermometer")
    missing, _, rivals, *_ = five_lines(table)
    others = "sensor_place (T1 and head), {}sensor_lag on T2"
    assert f"windage; and sensor_lag on T1, or {others.format('or ')};" in missing
    assert rivals == f"Rivals: {others.format('')}. To tell: a second thermometer."


def test_channels_that_got_worse_are_told():
    channel = {"before": 2.0, "after": 2.9, "noise": 0.3, "unit": "um"}
    assert five_lines(answer(channels={"S1": channel}))[4].endswith(
        "Worse with it: S1 (2 -> 2.9 um)."
    )
    worse = {"before": 0.9, "after": 1.2, "reference": 1.7, "floor": 0.5}
    assert "keep machine_before.toml" in five_lines(answer(gap={"holdout": worse}))[4]
    within = channel | {"after": 2.2}
    assert "Worse" not in five_lines(answer(channels={"S1": within}))[4]


def test_channels_keep_their_names_in_the_answer():
    where = [{"channel": "PT03", "regime": "standing"}]
    remaining = {"where": where, "share": 0.23, "predicted_by": [], "numbers_off": 1.0}
    missing = five_lines(answer(verdict="unknown", remaining=remaining))[0]
    assert missing.endswith(
        " 23% of the remaining error can be predicted from the inputs, mostly in PT03 standing."
    )
    nothing = five_lines(answer(verdict="unknown"))[0]
    told = " No input explains any of the remaining error in the same way in every run."
    assert nothing.endswith(told)


@pytest.mark.parametrize(("off", "told"), [(1.9, False), (2.6, True)])
def test_a_file_whose_numbers_are_generally_off_is_told(off, told):
    remaining = {"where": [], "share": 0.0, "predicted_by": [], "numbers_off": off}
    said = five_lines(answer(verdict="unknown", remaining=remaining))[0]
    assert ("The file's numbers are off by 2.6 deviations on average." in said) == told


@pytest.mark.parametrize(
    ("by", "minutes", "told"),
    [
        ("speed", 220.0, "speed with a lag of 220 min"),
        ("speed", 500.0, "speed added up since the start"),
        ("start", 500.0, "how warm the machine started"),
    ],
)
def test_what_predicts_the_rest_is_told_in_words(by, minutes, told):
    source = {"input": by, "lag_min": minutes, "share": 0.4}
    where = [{"channel": "S1", "regime": "standing"}]
    remaining = {"where": where, "share": 0.5, "predicted_by": [source], "numbers_off": 1.0}
    missing = five_lines(answer(verdict="unknown", remaining=remaining))[0]
    assert f"by {told}, mostly in S1 standing" in missing


def test_the_setting_of_what_a_part_switches_is_told():
    set_at = {
        "on_above": {"value": 25.5, "unit": "degC"},
        "dead_band": {"value": 2.5, "unit": "K"},
    }
    named = entry(
        "coolant_thermostat",
        driver="rear_outer",
        driver_in_words="rear outer",
        parameters={"band": {"value": 1.5, "low": 1.2, "high": 1.8, "unit": "K"}},
        set_at=set_at,
    )
    table = answer(verdict="effect", effects=[named])
    added = five_lines(table)[3]
    assert "band = 1.5 (1.2 to 1.8) K, on_above = 25.5 degC, dead_band = 2.5 K ->" in added


def test_the_run_that_a_law_starts_farthest_from_settled_is_told():
    hours = {"value": 4.0, "low": 2.0, "high": 8.0, "unit": "h"}
    effect = {"name": "slow_structure", "parameters": {"hours": hours}}
    effect["behind_at_start_K"] = {"monday": 0.4, "friday": -1.44}
    told = "slow_structure: hours = 4 (2 to 8) h, at most 1.4 K ahead at a start (friday)"
    assert _added({"effects": [effect]}) == told
