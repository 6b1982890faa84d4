"""Drivers of one law are rivals under one name: which are tried, chosen and reported."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from gap_finder.candidates import candidates, with_effect
from gap_finder.driver_choice import other_drivers
from gap_finder.effect_rounds import _shortlist
from gap_finder.find import GapResult, find_gap
from gap_finder.five_lines import five_lines
from gap_finder.held_out import _lone
from gap_finder.observations import observe
from gap_finder.refit import CandidateFit
from gap_finder.report import GapComparison, report_of
from gap_finder.search import Search
from gap_finder.selection import _of_any_sensor
from plant_model.effects import catalogue
from plant_model.machine import Machine
from plant_model.machine_file import read_machine
from tests.gap_finder.conftest import runs_of
from tests.gap_finder.test_planted_mistakes import runs_of as lathe_runs

RIVALS = ("thermal_preload", "friction_speed_exponent", "slow_structure")
LEFT_OUT = [name for name in catalogue() if name not in RIVALS]


def scored(loro_cost: float, key: str = "") -> CandidateFit:
    one = SimpleNamespace(added=(key,), loro_cost=np.array([loro_cost]))
    return cast("CandidateFit", one)


def test_effects_are_calibrated_on_the_driver_that_does_most() -> None:
    keys = ("slow_structure:column", "slow_structure", "windage", "radiation", "copper_loss", "x")
    assert _shortlist({key: 10 - i for i, key in enumerate(keys)}) == [10, 8, 7, 6]
    sensors = [f"sensor_lag:T{i}" for i in range(5)]
    assert _shortlist({key: i for i, key in enumerate(sensors)}) == [0, 1, 2, 3]


def test_theother_drivers_of_what_explains_most_are_asked_after_it() -> None:
    best = {"windage": 4, "slow_structure:column": 7, "slow_structure": 2, "slow_structure:bed": 9}
    fits = [scored(60.0, "windage"), scored(50.0, "slow_structure:column")]
    assert other_drivers(fits, scored(100.0), 0.3, best) == [2, 9]
    assert other_drivers(fits, scored(100.0), 0.6, best) == [], "chance explains as much"
    assert other_drivers([fits[0]], scored(100.0), 0.3, best) == []
    assert other_drivers([], scored(100.0), 0.3, best) == []


def test_drivers_are_no_sensors() -> None:
    assert _of_any_sensor(["sensor_lag:T1", "sensor_lag:T2", "sensor_lag:T3"])
    assert not _of_any_sensor(["slow_structure", "slow_structure:column", "slow_structure:bed"])


@pytest.mark.parametrize(
    ("one_of", "verdict"),
    [
        (("slow_structure", "slow_structure:column"), "effect"),
        (("slow_structure", "column_bending"), "one_of"),
        (("sensor_lag:T1", "sensor_lag:T2"), "one_of"),
    ],
)
def test_a_law_whose_driver_is_open_is_named_all_the_same(
    one_of: tuple[str, ...], verdict: str
) -> None:
    found = GapResult(*cast("Any", (None, None, [SimpleNamespace(named=True, one_of=one_of)])))
    assert found.verdict == verdict


def test_a_law_with_a_driver_is_no_error_of_a_sensor_in_one_run() -> None:
    gone = SimpleNamespace(key="slow_structure:column", runs=("down",))
    assert _lone(cast("Any", SimpleNamespace(withdrawn=[gone]))) == []


def test_every_driver_is_tried_and_counts_for_what_chance_does(jig_borer_lumps: Machine) -> None:
    observed = observe(jig_borer_lumps, runs_of(jig_borer_lumps)[:2])
    some = list(candidates(jig_borer_lumps, observed, catalogue()["column_bending"]))
    by_key = {key: [one for one in some if one.key == key] for key in {one.key for one in some}}
    assert set(by_key) == {"column_bending", "column_bending:hall", "column_bending:parts"}
    # The hall has no share of the carrier: a third of the shapes.
    assert len(by_key["column_bending:hall"]) * 3 == len(by_key["column_bending"])


@pytest.mark.long
def test_the_driver_that_acts_is_the_one_that_is_named(jig_borer_lumps: Machine) -> None:
    key = "thermal_preload:shaft_housing"
    runs = runs_of(with_effect(jig_borer_lumps, key, {"gain": 0.6}))
    found = find_gap(jig_borer_lumps, runs[:3], Search(LEFT_OUT))
    assert found.verdict == "effect"
    machine = found.after.machine
    unseen = GapComparison(found.before.machine, machine, observe(machine, runs[3:]))
    table = report_of(found, unseen)
    (effect,) = table["effects"]
    assert (effect["name"], effect["driver"]) == ("thermal_preload", "shaft_housing")
    assert key in machine.effects
    assert "driven by shaft against housing" in five_lines(table)[1]
    same = [*effect["other_drivers"], *(one.get("driver") for one in table["runners_up"])]
    assert "inner_outer" in same, "the other one was asked, too"


@pytest.mark.long
def test_which_air_the_spindle_stirs_is_told_from_the_runs() -> None:
    machine = read_machine("lathe")
    rivals = ("forced_convection", "windage", "friction_speed_exponent", "slow_structure")
    search = Search([name for name in catalogue() if name not in rivals])
    runs = lathe_runs(with_effect(machine, "forced_convection:air", {"gain": 3.0}))
    found = find_gap(machine, runs[:4], search)
    assert found.verdict == "effect"
    assert found.after.added == ("forced_convection:air",)
    gain = found.after.machine.parameters["effects.forced_convection:air.gain"]
    assert gain.value == pytest.approx(3.0, rel=0.3)
