"""What a calibration says of the description, in plain words."""

from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from benchmarks.gap.mistakes import runs_of
from gap_finder.advice import advice, disagreeing, not_moved, odd_runs, worse_than_none
from gap_finder.calibrate import ParameterEstimate
from gap_finder.kinds.coarse_part import CoarsePart
from gap_finder.observations import Observations, observe
from gap_finder.regimes import RunResiduals, residuals
from plant_model.machine import Machine
from plant_model.machine_file import read_machine


@pytest.fixture(scope="module")
def lathe() -> Machine:
    return read_machine("lathe")


def left_of(machine: Machine, observed: Sequence[Observations]) -> list[RunResiduals]:
    return [residuals(machine, one) for one in observed]


def test_a_machine_that_is_right_gets_no_advice(lathe):
    assert advice(lathe, left_of(lathe, observe(lathe, runs_of(lathe)[:2])), ()) == []


def test_two_thermometers_that_contradict_one_lump_are_told(lathe):
    mass = {node.name: node.capacity.value for node in lathe.nodes}
    cut = CoarsePart(("carriage",), mass["carriage"], ("PT13",), False)
    observed = observe(lathe, runs_of(cut.put_into(lathe, {"conductance": 5.0}))[:2])
    ((_, told),) = disagreeing(lathe, observed)
    assert told.place == ("PT12", "PT13")
    assert "carriage" in told.text


def test_a_channel_worse_than_no_model_is_told(lathe):
    hot = lathe.with_values({"sources.z_nut.loss": 27.0})
    items = tuple(one for one in lathe.items if one.name != "z_nut-air")
    left = [residuals(replace(hot, items=items), one) for one in observe(lathe, runs_of(lathe)[:2])]
    assert ("PT08",) in [one.place for _, one in worse_than_none(left)]


@pytest.mark.parametrize(("off", "told"), [(0.5, []), (1.5, [("disp_x",)])])
def test_a_still_channel_is_worse_only_beyond_its_noise(off, told):
    noise = 0.2
    still = SimpleNamespace(
        channels=("disp_x",),
        moved=np.full((9, 1), 0.4 * noise),
        noise=[noise],
        unit_of=lambda channel: "um",
    )
    left: Any = [SimpleNamespace(observed=still, values=np.full((9, 1), off * noise))]
    assert [one.place for _, one in worse_than_none(left)] == told


def test_a_run_that_contradicts_the_others_is_told():
    lengths = SimpleNamespace(channels=("S5",), tolerance=[0.5], unit_of=lambda channel: "um")
    left: Any = [
        SimpleNamespace(
            observed=SimpleNamespace(**vars(lengths), run=SimpleNamespace(name=name)),
            values=np.full((9, 1), off),
        )
        for name, off in (("monday", 1.0), ("tuesday", -17.0), ("friday", 2.0))
    ]
    ((_, told),) = odd_runs(left)
    assert told.place == ("S5", "tuesday")
    assert told.text.startswith("S5: off by 17 um in tuesday, by at most 2 um in the others: check")
    assert [*odd_runs([left[0], left[2]]), *odd_runs(left[:1])] == []


def test_a_displacement_that_nothing_moves_is_told(lathe):
    observed = observe(lathe, runs_of(lathe)[:2])
    named = ("holder_reach", "bed_head_height", "arm_reach", "headstock_bend")
    still = replace(lathe, items=tuple(one for one in lathe.items if one.name not in named))
    left = [residuals(still, one) for one in observed]
    told = [(one.kind, one.place) for _, one in not_moved(left)]
    assert ("not_moved", ("disp_x",)) in told
    assert ("not_moved", ("disp_z",)) not in told


def test_a_number_far_from_what_is_usual_is_told(lathe):
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
    far = "2.5 W/K, 2.4 deviations below 8 (class value: ground seats)"
    assert f"{far}, or something else acts like it" in told.text
