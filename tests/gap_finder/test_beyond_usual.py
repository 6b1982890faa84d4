"""An effect many times larger than usual: other numbers have given way to it by then."""

from __future__ import annotations

import pytest

from gap_finder.calibrate import calibrate
from gap_finder.candidates import with_effect
from gap_finder.design import all_sensitivities
from gap_finder.observations import observe
from gap_finder.refit import fit_effects, refit_beyond_usual
from plant_model.machine_file import read_machine
from tests.gap_finder.test_find import runs_of as jig_borer_runs
from tests.gap_finder.test_planted_mistakes import runs_of as lathe_runs

LOSS = "motor_iron_loss"
USUAL = {"power": 300.0, "eddy_share": 0.6, "stator_share": 0.85}


@pytest.mark.parametrize("name", ["jig_borer_lumps", pytest.param("lathe", marks=pytest.mark.long)])
def test_its_size_is_found(name: str) -> None:
    machine = read_machine(name)
    runs_of = lathe_runs if name == "lathe" else jig_borer_runs
    observed = observe(machine, runs_of(with_effect(machine, LOSS, USUAL | {"power": 6000.0}))[:3])
    calibration = calibrate(machine, observed, starts=1)
    sensitivities = all_sensitivities(machine, calibration.machine, observed)
    usual = fit_effects(
        with_effect(machine, LOSS, USUAL),
        (LOSS,),
        observed,
        [with_effect(calibration.machine, LOSS, USUAL)],
        sensitivities,
    )
    assert usual.at_bounds == ("power", "eddy_share")
    found = refit_beyond_usual(usual, sensitivities)
    assert found.at_bounds == ()
    assert found.beyond_usual == ("power",)
    values = found.machine.effects[LOSS]
    assert values["power"].value == pytest.approx(6000.0, rel=0.03)
    assert values["eddy_share"].value == pytest.approx(0.6, abs=0.02)
    assert found.loro_cost.sum() < 0.5 * usual.loro_cost.sum()
