"""Cooling that a part's thermometer switches: its settings are found in the rows of the runs."""

import numpy as np
import pytest

from gap_finder.candidates import with_effect
from gap_finder.linearise import modelled, simulate_at
from gap_finder.observations import Observations, observe
from gap_finder.switchings import Relay, carried_away, likely_switchings, watched
from measurement.runs import Run
from plant_model.effects import catalogue
from plant_model.machine import Machine
from plant_model.simulate import simulate
from tests.gap_finder.conftest import candidates_of, inputs_of, runs_of

KEY = "coolant_thermostat:rear_outer"
SETTING = {"on_above": 26.0, "dead_band": 3.0}


@pytest.fixture(scope="module")
def observed(jig_borer_lumps: Machine) -> list[Observations]:
    """Runs of a machine whose coolant stands until its rear bearing is warm."""
    machine = with_effect(jig_borer_lumps, KEY, {"band": 1.5} | SETTING)
    return observe(jig_borer_lumps, runs_of(machine, 60.0, seed=0))


def found(machine: Machine, observed: list[Observations]) -> list[tuple[str, float, float]]:
    simulated = [simulate_at(machine, one) for one in observed]
    pairs = list(zip(simulated, observed, strict=True))
    residuals = [one.weighted(modelled(shown, one))[0] for shown, one in pairs]
    carried = [carried_away(machine, shown, one) for shown, one in pairs]
    parts = list(catalogue()["coolant_thermostat"].drivers(machine))[1:]
    likely = likely_switchings(machine, observed, residuals, carried, parts)
    return [(one.part, one.relays[0].on_above, one.relays[0].dead_band) for one in likely]


def test_the_part_and_the_setting_are_found(jig_borer_lumps, observed):
    part, on_above, dead_band = found(jig_borer_lumps, observed)[0]
    assert part == "rear_outer"
    assert on_above == pytest.approx(26.0, abs=0.7)
    assert dead_band == pytest.approx(3.0, abs=0.7)


def test_a_part_that_one_run_does_not_read_is_left_out(jig_borer_lumps, observed):
    short = Run("short", observed[0].run.frame.drop(columns="T1_degC"))
    runs = [short, *(one.run for one in observed[1:])]
    parts = [part for part, *_ in found(jig_borer_lumps, observe(jig_borer_lumps, runs))]
    assert "rear_outer" not in parts


def test_where_nothing_switches_nothing_is_simulated(jig_borer_lumps):
    assert found(jig_borer_lumps, observe(jig_borer_lumps, runs_of(jig_borer_lumps, 60.0))) == []


def test_the_measured_part_switches_and_not_the_modelled_one(jig_borer_lumps):
    machine = with_effect(jig_borer_lumps, KEY, {"band": 1.5} | SETTING)
    run = Run("stops", simulate(machine, inputs_of("stops"), noise_seed=2).run_frame())
    (one,) = observe(jig_borer_lumps, [run])
    told = watched(jig_borer_lumps, one, "rear_outer")
    assert told is not None
    marked = Relay(told, 26.0, 3.0).marked(one, KEY)
    plain, with_it, as_seen = (
        float(np.mean(run.weighted(modelled(simulate_at(with_that, run), run))[0] ** 2))
        for with_that, run in ((jig_borer_lumps, one), (machine, one), (machine, marked))
    )
    assert as_seen < 0.1 * plain
    assert as_seen < with_it


@pytest.mark.long
def test_it_is_tried_on_its_parts(jig_borer_lumps, observed):
    tried = [
        one for one in candidates_of(jig_borer_lumps, observed, "coolant_thermostat") if one.seen
    ]
    assert tried[0].key == KEY
    grown = with_effect(jig_borer_lumps, KEY, tried[0].values)
    free = {name for name, p in grown.effects[KEY].items() if p.calibrate}
    assert free == {"band"}, "its setting is what the rows say"
    seen = tried[0].marked(0, observed[0])
    assert f"{KEY} on" in seen.drive.held
