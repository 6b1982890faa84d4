"""What swings by itself, and what begins with one run."""

import numpy as np
import pytest

from gap_finder.candidates import with_effect
from gap_finder.linearise import modelled, simulate_at
from gap_finder.observations import observe
from gap_finder.periods import PHASES, in_step, quick
from measurement.runs import Run
from plant_model.machine import Machine
from plant_model.simulate import simulate
from tests.gap_finder.conftest import SPECTRA, candidates_of, inputs_of, runs_of


@pytest.fixture(scope="module")
def swinging(jig_borer_lumps: Machine) -> list[Run]:
    """Runs with a chiller that switches every 11 minutes, each begun elsewhere in the cycle."""
    runs = []
    for i, name in enumerate(SPECTRA):
        values = {"band": 0.8, "period": 11.0, "phase": 0.15 + 0.2 * i}
        machine = with_effect(jig_borer_lumps, "coolant_thermostat", values)
        runs.append(Run(name, simulate(machine, inputs_of(name), noise_seed=i).run_frame()))
    return runs


def test_the_period_and_every_run_s_phase_are_found(jig_borer_lumps, swinging):
    observed = observe(jig_borer_lumps, swinging)
    found = candidates_of(jig_borer_lumps, observed, "coolant_thermostat")
    assert found[0].values["period"] == pytest.approx(11.0, rel=0.02)
    for i, own in enumerate(found[0].own):
        away = abs(own["phase"] - (0.15 + 0.2 * i))
        assert min(away, 1.0 - away) < 0.1
    assert found[0].marked(1, observed[1]).own == {
        "effects.coolant_thermostat.phase": found[0].own[1]["phase"]
    }


def test_a_run_that_was_not_used_is_put_in_step(jig_borer_lumps, swinging):
    values = {"band": 0.8, "period": 11.0}
    machine = with_effect(jig_borer_lumps, "coolant_thermostat", values)
    (observed,) = observe(jig_borer_lumps, swinging[2:3])
    before, after = (
        quick(one, one.weighted(modelled(simulate_at(machine, one), one))[0])
        for one in (observed, in_step(machine, observed))
    )
    assert np.sum(after**2) < 0.2 * np.sum(before**2)
    assert in_step(jig_borer_lumps, observed) is observed
    assert len(PHASES) == 24


def test_a_fault_may_begin_with_any_run(jig_borer_lumps):
    runs = runs_of(jig_borer_lumps)
    observed = observe(jig_borer_lumps, runs)
    found = candidates_of(jig_borer_lumps, observed, "sensor_offset")
    of_one = [c for c in found if c.key == "sensor_offset:T1" and c.values["error"] == 1.0]
    acts = [[bool(np.any(answer)) for answer in one.answers] for one in of_one]
    assert acts == [[False] * k + [True] * (4 - k) for k in range(4)]
    since = of_one[3]
    grown = with_effect(jig_borer_lumps, since.key, {"error": 1.0})
    channel = observed[0].channels.index("T1")
    for i, one in enumerate(observed):
        seen = since.marked(i, one)
        shown, plain = (
            modelled(simulate_at(machine, seen), seen)[0, -1, channel]
            for machine in (grown, jig_borer_lumps)
        )
        # The node starts lower by the error that its thermometer is taken to have.
        assert shown - plain == (0.0 if i < 3 else pytest.approx(1.0, abs=0.5))
