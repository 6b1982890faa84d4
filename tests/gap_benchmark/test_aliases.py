"""Heat that practitioners know by name, put into a machine as it is described."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.gap.aliases import KNOWN, RUNS, recorded, with_heat
from plant_model.effects import catalogue
from plant_model.machine_file import read_machine
from plant_model.parameters import Values
from tests.plant_model.catalogue_machines import heat_of


@pytest.mark.parametrize(
    ("known", "expected"),
    [
        ("contact seals", {"shaft_front": 50.0, "housing_front_ym": 12.5}),
        ("rotary union", {"shaft_rear": 50.0}),
        ("standby", {"pedestal": 150.0}),
    ],
)
def test_heat_is_where_it_is_said_and_in_proportion_to_speed(
    known: str, expected: dict[str, float]
) -> None:
    truth = with_heat(read_machine("jig_borer_lumps"), KNOWN[known])
    effect = catalogue()["plain_heat"](truth, Values(truth.parameters))
    half = heat_of(effect, 10000.0)
    assert {part: half[part] for part in expected} == pytest.approx(expected)
    standing = heat_of(effect, 0.0)
    assert sum(standing.values()) == (150.0 if known == "standby" else 0.0)


def test_a_run_has_its_speeds() -> None:
    run = recorded(read_machine("jig_borer_lumps"), "stops", 1)
    speeds = run.frame["speed_rpm"].to_numpy()
    assert set(speeds) == {speed for _, speed in RUNS["stops"]}
    assert np.ptp(run.frame["T1_degC"]) > 2.0
