"""What a calibration says of the description, in plain words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.gap.mistakes import runs_of
from gap_finder.advice import advice, disagreeing, heat_missing
from gap_finder.calibrate import ParameterEstimate
from gap_finder.channel_advice import about_channels, worse_than_none
from gap_finder.kinds.coarse_part import CoarsePart
from gap_finder.kinds.heat_source import HeatSource
from gap_finder.observations import Observations, observe
from gap_finder.regimes import RunResiduals, residuals
from measurement.runs import Run
from plant_model.machine import Machine
from plant_model.machine_file import read_machine

POWER_W = 40.0


@pytest.fixture(scope="module")
def lathe() -> Machine:
    return read_machine("lathe")


def left_of(machine: Machine, observed: Sequence[Observations]) -> list[RunResiduals]:
    return [residuals(machine, one) for one in observed]


def test_heat_that_a_part_lacks_is_told_with_its_power(lathe: Machine) -> None:
    warmed = HeatSource(("z_nut",)).put_into(lathe, {"power": POWER_W})
    observed = observe(lathe, runs_of(warmed)[:2])
    at = lathe.node_index["z_nut"]
    for one in observed:
        missing, conductance = heat_missing(lathe, one)
        assert missing["running"][at] == pytest.approx(POWER_W, rel=0.15)
        others = np.abs(missing["running"] / conductance)
        others[at] = 0.0
        assert np.nanmax(others) < 0.5
    (told,) = [
        one for one in advice(lathe, left_of(lathe, observed), ()) if one.kind == "heat_balance"
    ]
    assert told.place == ("z_nut",)
    assert "while running" in told.text


def test_a_machine_that_is_right_gets_no_advice(lathe: Machine) -> None:
    assert advice(lathe, left_of(lathe, observe(lathe, runs_of(lathe)[:2])), ()) == []


def test_two_thermometers_that_contradict_one_lump_are_told(lathe: Machine) -> None:
    mass = {node.name: node.capacity.value for node in lathe.nodes}
    cut = CoarsePart(("carriage",), mass["carriage"], ("PT13",), False)
    observed = observe(lathe, runs_of(cut.put_into(lathe, {"conductance": 5.0}))[:2])
    (told,) = disagreeing(lathe, observed)
    assert told.place == ("PT12", "PT13")
    assert "carriage" in told.text


def test_a_channel_worse_than_no_model_is_told(lathe: Machine) -> None:
    hot = lathe.with_values({"sources.z_nut.loss": 27.0})
    items = tuple(one for one in lathe.items if one.name != "z_nut-air")
    left = [residuals(replace(hot, items=items), one) for one in observe(lathe, runs_of(lathe)[:2])]
    assert ("PT08",) in [one.place for one in worse_than_none(lathe, left)]


def test_a_channel_that_calibration_made_worse_is_told(lathe: Machine) -> None:
    observed = observe(lathe, runs_of(lathe)[:2])
    hot = lathe.with_values({"sources.z_nut.loss": 27.0})
    right, wrong = ([residuals(one, seen) for seen in observed] for one in (lathe, hot))
    told = about_channels(lathe, wrong, right)
    assert ("worse_than_before", ("PT08",)) in [(one.kind, one.place) for one in told]
    assert about_channels(lathe, right, wrong) == []


def test_a_displacement_that_nothing_moves_is_told(lathe: Machine) -> None:
    observed = observe(lathe, runs_of(lathe)[:2])
    named = ("holder_reach", "bed_head_height", "arm_reach", "headstock_bend")
    still = replace(lathe, items=tuple(one for one in lathe.items if one.name not in named))
    left = [residuals(still, one) for one in observed]
    told = [(one.kind, one.place) for one in about_channels(still, left, left)]
    assert ("not_moved", ("disp_x",)) in told
    assert ("not_moved", ("disp_z",)) not in told


def test_a_thermometer_off_by_a_constant_in_one_run_is_told(lathe: Machine) -> None:
    runs = runs_of(lathe)[:2]
    frame = runs[1].frame.assign(PT12_degC=runs[1].frame["PT12_degC"] + 2.4)
    observed = observe(lathe, [runs[0], Run(runs[1].name, frame)])
    left = [residuals(lathe, one) for one in observed]
    (told,) = about_channels(lathe, left, left)
    assert (told.kind, told.place) == ("off_by_a_constant", ("PT12",))
    # Not all of the 2.4 K: the part starts warmer by its reading.
    assert told.text.startswith("PT12: shows +1.9 K beside the model throughout stop:")


def test_a_number_far_from_what_is_usual_is_told(lathe: Machine) -> None:
    source = "class value: ground seats"
    numbers = [
        ParameterEstimate(
            "links.a-b.conductance", "W/K", 8.0, 2.5, 2.0, 3.0, 0.9, False, -2.4, source
        ),
        ParameterEstimate("sources.front.f0", "1", 1.0, 1.1, 1.0, 1.2, 0.9, False, 0.4),
    ]
    observed = observe(lathe, runs_of(lathe)[:1])
    (told,) = [
        one
        for one in advice(lathe, left_of(lathe, observed), numbers)
        if one.kind == "far_from_usual"
    ]
    assert told.place == ("links.a-b.conductance",)
    assert "2.5 W/K, 2.4 deviations below 8 (class value: ground seats): look at it" in told.text
