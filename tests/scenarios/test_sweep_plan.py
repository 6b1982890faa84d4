"""The cases of a sweep: names, ranges, variants, seeds."""

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from measurement.errors import BadInput
from scenarios.sweep.plan import Plan, Request, plan

VARIANTS = """
[[variants]]
name = "short"
set = { "signals.tool_length" = 100.0 }

[[variants]]
name = "long"
set = { "signals.tool_length" = 240.0, "compensator.tool_length_mm" = 0.0 }
"""


@pytest.fixture
def planned(tiny_scenario: Path, tiny_folder: Path, tmp_path: Path) -> Any:
    def make(*vary: str, **more: Any) -> Plan:
        work = tmp_path / "work"
        shutil.rmtree(work, ignore_errors=True)
        work.mkdir()
        request = Request(str(tiny_scenario), vary, **more)
        return plan(request, tiny_folder, work, "1", quiet=True)

    return make


def test_a_grid_times_draws_times_repeats(planned):
    found = planned("tool_length=100,200", "gain=1e-3..2e-3", "speed=x1,2", repeat=3)
    assert [job.number for job in found.jobs] == list(range(12))
    points = [
        (job.values["tool_length"], job.values["speed_factor"], job.repeat) for job in found.jobs
    ]
    assert points == [(t, s, r) for t in (100, 200) for s in (1, 2) for r in range(3)]
    drawn = [job.values["gain"] for job in found.jobs]
    assert len(set(drawn[:3])) == 3
    assert drawn == drawn[:3] * 4  # every point of the grid has the same draws
    for job in found.jobs:
        settings = job.case.settings
        assert settings.plant.parameters == {"gain": job.values["gain"]}
        assert settings.signals["tool_length"] == job.values["tool_length"]


def test_a_scaled_signal_is_the_scenarios_times_the_factor(planned):
    job = planned("speed=x0.5").jobs[0]
    case = job.case
    moments = np.array([0.0, 15.0])
    values = case.signals["speed"].values(moments, case.setting.inside("speed"))
    assert values.tolist() == [500.0, 1000.0]


def test_a_factor_multiplies_the_scenario_and_else_the_plant(planned):
    (job,) = planned("gain=x3", "tool_length=x0.5", overrides=(("seed", 5),)).jobs
    assert job.case.settings.plant.parameters["gain"] == pytest.approx(3e-3)
    assert job.case.settings.signals["tool_length"] == 50.0
    (job,) = planned("gain=x3", overrides=(("plant.parameters.gain", 2.0),)).jobs
    assert job.case.settings.plant.parameters["gain"] == 6.0


def test_the_first_repeat_has_the_scenarios_seed_and_the_others_their_own(planned):
    seeds = [job.case.settings.seed for job in planned(repeat=4).jobs]
    assert seeds[0] == 1
    assert len(set(seeds)) == 4
    assert seeds == [job.case.settings.seed for job in planned("gain=1,2", repeat=4).jobs][:4]
    assert [job.case.settings.seed for job in planned(seed=9).jobs] == [9]
    assert [job.case.settings.seed for job in planned("seed=3,4").jobs] == [3, 4]


def test_variants_are_all_run_or_those_that_are_named(planned, tiny_scenario):
    with tiny_scenario.open("a", encoding="utf-8") as file:
        file.write(VARIANTS)
    found = planned("gain=1,2", repeat=2)
    assert [job.variant for job in found.jobs] == ["short"] * 4 + ["long"] * 4
    assert [job.case.settings.signals["tool_length"] for job in found.jobs][::4] == [100.0, 240.0]
    found = planned("tool_length=1,2", variants=("long",))
    assert [job.case.settings.signals["tool_length"] for job in found.jobs] == [1, 2]
    assert {job.case.settings.compensator.tool_length_mm for job in found.jobs} == {0.0}
    with pytest.raises(BadInput, match="tool_length: is what the variants differ in: choose one"):
        planned("tool_length=1,2")
    with pytest.raises(BadInput, match="--variant: 'wide' is not allowed: short, long"):
        planned(variants=("wide",))


def test_a_pattern_means_every_parameter_that_it_fits(planned):
    found = planned("g*n=1..2", "noise_???d=5")
    assert [entry.label for entry in found.variations] == ["gain", "noise_seed"]


@pytest.mark.parametrize(
    ("vary", "more", "message"),
    [
        (("gian=1",), {}, "--vary: gian: no input, parameter or key of the scenario; did you"),
        (("plant.parameters.gian=1",), {}, "did you mean gain"),
        (("signals.sped=1",), {}, "did you mean speed"),
        (("xyz=1",), {}, "inputs are speed, tool_length; parameters such as gain, noise_seed"),
        (("links.*=1",), {}, "--vary: links.*: no input"),
        (("dX=1",), {}, "--vary: dX: no input"),
        (("T1=1",), {}, "--vary: T1: no input"),
        (("duration_s=1,2",), {}, "duration_s is the same in every case"),
        (("variants=1",), {}, "variants is the same in every case"),
        (("gain=1", "gain=2"), {}, "gain: varies twice"),
        (("gain=1", "plant.parameters.gain=2"), {}, "varies twice"),
        (("gain=low,high",), {}, "--vary: gain: 'low' is not allowed"),
        (("seed=-1,2",), {}, "--vary: seed: -1 is not allowed"),
        (("plant.noise=x2",), {}, "is not a number to be multiplied"),
        (("step_s=0.3",), {}, "must be a multiple of"),
        (("plant.fmu=no.fmu",), {}, "no.fmu: there is no such file"),
        (("gain=0..1:1001", "speed=0..1:1000"), {}, "1001000 cases are more than 1000000"),
        ((), {"repeat": 0}, "--repeat: 0 is not allowed"),
        ((), {"seed": -1}, "--seed: -1 is not allowed"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_refused_before_anything_runs(planned, vary, more, message):
    with pytest.raises(BadInput) as refused:
        planned(*vary, **more)
    assert message in str(refused.value)


def test_a_value_outside_the_parameters_range_is_refused(shipped_in_c, tmp_path):
    def refused(*vary: str) -> str:
        work = tmp_path / vary[0].replace("/", "_")
        work.mkdir()
        with pytest.raises(BadInput) as found:
            plan(Request("step_speed", vary, variants=("long_tool",)), shipped_in_c, work, "1")
        return str(found.value)

    joint = "links.pedestal-column.conductance"
    assert refused(f"{joint}=6,90") == (
        f"--vary: {joint}: 90 is not allowed: the plant FMU takes 3 to 40"
    )
    # The ends of a range count, whether a draw comes near them or not.
    assert "40.001 is not allowed" in refused(f"{joint}=6..40.001")
    assert "5 * 10 is not allowed: the plant FMU takes 3 to 40" in refused(f"{joint}=x0.9..5")
    assert "9 * 10 is not allowed" in refused(f"{joint}=x9+-1")
