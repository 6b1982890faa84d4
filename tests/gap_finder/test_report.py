"""What the report says of channels and of what was left out."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from gap_finder.five_lines import _left_out, five_lines
from gap_finder.observations import observe
from gap_finder.regimes import RunResiduals
from gap_finder.report import GapComparison
from measurement.runs import Run
from plant_model.machine import Machine
from tests.gap_finder.conftest import runs_of


def test_channels_are_judged_beside_no_model(jig_borer_lumps: Machine) -> None:
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


def test_each_broken_channel_is_told_once() -> None:
    faults = [{"run": f"r{i}", "channel": "T1", "kind": "level_jump"} for i in range(5)]
    faults += [{"run": "r1", "channel": "x", "kind": "frozen"}] * 2
    told = " Left out as broken: T1 (wrong level in r0 and 4 more); x (frozen in r1)."
    assert _left_out(faults) == told
    assert _left_out([]) == ""


def answer(**more: Any) -> dict[str, Any]:
    """Return what gap.json holds where nothing was found, with *more*."""
    table = {
        "verdict": "none_missing",
        "in_doubt": False,
        "where": [],
        "data_faults": [],
        "effects": [],
        "one_of_keys": [],
        "runners_up": [],
        "evidence": {"share_explained": 0.0, "share_by_chance": 0.08},
        "remaining": {"is_reducible": False, "above_tolerance": False, "where": [], "share": 0.0},
        "machine": "machine_after.toml",
        "gap": {"holdout": {"before": 0.9, "after": 0.9, "reference": 1.7, "floor": 0.5}},
        "withdrawn": [],
    }
    return table | more


@pytest.mark.parametrize(
    ("share", "withdrawn", "said"),
    [(0.52, [], True), (0.08, [], False), (0.52, [{"name": "centrifugal_shift"}], False)],
)
def test_what_is_too_little_to_be_named_is_said_all_the_same(
    share: float, withdrawn: list[dict[str, str]], said: bool
) -> None:
    table = answer(
        runners_up=[{"name": "centrifugal_shift", "probability": 0.96}],
        evidence={"share_explained": share, "share_by_chance": 0.08},
        withdrawn=withdrawn,
    )
    _, missing, rivals, *_ = five_lines(table)
    assert missing.startswith("What is missing: nothing that these runs prove")
    assert ("centrifugal_shift explains 52% of them, chance up to 8%" in missing) == said
    assert "may act alike" not in rivals


def test_channels_keep_their_names_in_the_answer() -> None:
    remaining = {
        "is_reducible": True,
        "above_tolerance": True,
        "where": [{"channel": "PT03", "regime": "standing"}],
        "share": 0.23,
        "predicted_by": [],
    }
    missing = five_lines(answer(verdict="unknown", remaining=remaining))[1]
    assert missing.endswith(" 23% of it can be predicted from the inputs, most in PT03 standing.")
    nothing = five_lines(answer(verdict="unknown"))[1]
    assert nothing.endswith(" None of it follows from the inputs in the same way in every run.")


def test_the_setting_of_what_a_part_switches_is_told() -> None:
    band = {"value": 1.5, "low": 1.2, "high": 1.8, "unit": "K"}
    named = {
        "name": "coolant_thermostat",
        "title": "Chiller switching on and off",
        "driver": "rear_outer",
        "driver_in_words": "rear outer",
        "parameters": {"band": band},
        "switched_at": {
            "on_above": {"value": 25.5, "unit": "degC"},
            "dead_band": {"value": 2.5, "unit": "K"},
        },
        "larger_than_usual": [],
        "evidence": "explains 90 %",
    }
    table = answer(verdict="effect", effects=[named], one_of_keys=["coolant_thermostat:rear_outer"])
    added = five_lines(table)[3]
    assert "band = 1.5 (1.2 to 1.8) K, on_above = 25.5 degC, dead_band = 2.5 K ->" in added


@pytest.mark.parametrize("in_doubt", [True, False])
def test_a_name_that_leaves_more_than_the_tolerance_is_in_doubt(in_doubt: bool) -> None:
    named = {
        "name": "windage",
        "title": "Windage",
        "parameters": {},
        "larger_than_usual": [],
        "evidence": "explains 74 %",
    }
    table = answer(verdict="effect", effects=[named], one_of_keys=["windage"], in_doubt=in_doubt)
    missing = five_lines(table)[1]
    assert missing.startswith("What may be missing: Windage;") == in_doubt
    assert missing.startswith("What is missing: Windage;") != in_doubt
    assert ("In doubt: the model with it still leaves more" in missing) == in_doubt


@pytest.mark.parametrize(
    ("changes", "worse"),
    [
        ({"T8": -5.0}, False),
        ({"T8": -5.0, "S1": 0.9}, False),
        ({"T8": -50.0, "S1": 2.0}, False),
        ({"T8": -5.0, "S1": 2.0}, True),
    ],
)
def test_what_costs_another_channel_more_than_its_tolerance_makes_it_worse(
    changes: dict[str, float], worse: bool, jig_borer_lumps: Machine
) -> None:
    run = runs_of(jig_borer_lumps)[0]
    (one,) = observe(jig_borer_lumps, [run])
    comparison = GapComparison(jig_borer_lumps, jig_borer_lumps, [one])
    size = np.full_like(one.values, 8.0)
    after = size**2
    for name, change in changes.items():
        after[:, one.channels.index(name)] += change
    comparison.before = [RunResiduals(one, size * one.tolerance)]
    comparison.after = [RunResiduals(one, np.sqrt(after) * one.tolerance)]
    assert comparison.made_worse() is worse
