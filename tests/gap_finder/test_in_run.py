"""Where lagging laws start: an unknown of every run."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gap_finder.calibrate import _Problem, calibrate
from gap_finder.candidates import with_effect
from gap_finder.design import all_sensitivities
from gap_finder.in_run import start_responses
from gap_finder.likelihood import SWINGS, Likelihood
from gap_finder.linearise import Linearisation, modelled, simulate_at
from gap_finder.observations import Observations, observe
from gap_finder.priors import Priors
from gap_finder.regimes import residuals
from gap_finder.score import fit, scored
from measurement.runs import Run
from plant_model.machine import Machine
from plant_model.simulate import simulate
from tests.gap_finder.conftest import inputs_of, only_free

AXIAL = "S5"
FREE = "links.jacket_front-coolant_inlet.flow"
GROWTH, HOURS = 8.0, 4.0
BEHIND_K = (2.5, -1.5, 1.0)


@pytest.fixture(scope="module")
def bed(jig_borer_lumps: Machine) -> Machine:
    """The machine on a bed that grows along the axis, hours after the hall."""
    law = {"growth": GROWTH, "hours": HOURS, "direction": 0.0}
    return with_effect(jig_borer_lumps, "slow_structure", law)


@pytest.fixture(scope="module")
def observed(bed: Machine) -> list[Observations]:
    """Runs at whose start the bed is warmer or colder than its model believes."""
    frames = [inputs_of(name, 60.0) for name in ("down", "stairs", "stops")]
    for frame, phase in zip(frames, (0.0, 2.0, 4.0), strict=True):
        frame["T5_degC"] += 5.0 * np.sin(frame["time_s"] / 1500.0 + phase)
    simulated = [simulate(bed, frame, noise_seed=i).run_frame() for i, frame in enumerate(frames)]
    settled = observe(bed, [Run(f"run{i}", frame) for i, frame in enumerate(simulated)])
    runs = []
    for run, behind in zip(settled, BEHIND_K, strict=True):
        values = modelled(simulate_at(bed, run), run)[0]
        since_h = (run.time_s - run.run.time_s[0]) / 3600.0
        grown = GROWTH * behind * (1.0 - np.exp(-since_h / HOURS))
        values[:, run.channels.index(AXIAL)] -= grown  # towards -Z
        runs.append(replace(run, values=values))
    return runs


def test_a_machine_without_lagging_laws_has_no_starts(jig_borer_lumps, observed):
    responses, deviations = start_responses(jig_borer_lumps, observed[0])
    assert responses.shape == (1, 0, *observed[0].values.shape)
    assert deviations == {}


def test_a_start_is_as_unknown_as_the_lag_lets_the_law_be_behind(bed, observed):
    """Behind a daily swing by w tau / sqrt(1 + (w tau)^2), and only where the law acts."""
    ((response,),), _ = start_responses(bed, observed[0])
    lag = 2.0 * np.pi * HOURS / 24.0
    behind = 2.0 * lag / np.sqrt(1.0 + lag**2)
    hours = (observed[0].time_s - observed[0].run.time_s[0]) / 3600.0
    along = observed[0].channels.index(AXIAL)
    expected = GROWTH * behind * (1.0 - np.exp(-hours / HOURS))
    assert np.abs(response[:, along]) == pytest.approx(expected, rel=1e-9)
    assert not np.delete(response, along, axis=1).any()


def test_what_remains_of_a_run_does_not_include_where_a_law_started(bed, observed):
    for run, behind in zip(observed, BEHIND_K, strict=True):
        after = residuals(bed, run)
        assert after.behind["slow_structure"] == pytest.approx(behind, rel=0.2)
        left = after.values[:, run.channels.index(AXIAL)]
        shown = modelled(simulate_at(bed, run), run)[0] - run.values
        assert np.nanstd(left) < 0.1 * np.nanstd(shown[:, run.channels.index(AXIAL)])


@pytest.fixture(scope="module")
def wrong_bed(jig_borer_lumps: Machine) -> Machine:
    law = {"growth": 5.0, "hours": 9.0}
    return with_effect(only_free(jig_borer_lumps), "slow_structure", law)


def test_runs_that_a_law_begins_anywhere_determine_how_fast_it_moves(wrong_bed, observed):
    found = calibrate(wrong_bed, observed, starts=1).machine.parameters
    growth, hours = (found[f"effects.slow_structure.{n}"].value for n in ("growth", "hours"))
    assert growth / hours == pytest.approx(GROWTH / HOURS, rel=0.15)


def test_the_cost_has_the_gradient_that_its_differences_have(wrong_bed, observed):
    """Also where a law's size and hours change what its start explains."""
    priors = Priors.of(wrong_bed, calibrated=True)
    problem = _Problem(wrong_bed, observed, priors, None)
    x = np.zeros(len(priors.names))
    step = 1e-3 * np.eye(len(x))
    costs = problem.costs(np.concatenate([x + step, x - step])).reshape(2, -1)
    numeric = (costs[0] - costs[1]) / 4e-3
    assert problem.at(x).about.right[:2] == pytest.approx(numeric[:2], rel=0.05)


def test_a_hypothesis_pays_for_the_starts_that_it_is_free_to_choose(jig_borer_lumps, bed, observed):
    sensitivities = all_sensitivities(jig_borer_lumps, observed)
    without = only_free(jig_borer_lumps, FREE)
    nothing = scored(without, observed, calibrate(without, observed, starts=1), sensitivities)
    assert nothing.calibration.starts_cost == 0.0
    with_law = only_free(bed, FREE)
    found = fit(with_law, observed, [with_law], sensitivities)
    assert 0.0 < found.calibration.starts_cost < len(observed) * np.log(1e6)
    assert found.cost + found.calibration.starts_cost < 0.5 * nothing.cost


@pytest.mark.parametrize(("behind", "share"), [(1.5, 1.0), (0.0, 0.1)])
def test_what_a_start_costs_is_the_share_of_its_likely_prior_that_a_run_leaves(behind, share):
    """Beside a zero that looks much like it: the determinants of both and of the zero alone."""
    generator = np.random.default_rng(3)
    zero = generator.normal(size=(50, 1))
    start = 0.8 * zero + 0.3 * generator.normal(size=(50, 1))
    run: Any = SimpleNamespace(weights=np.ones((50, 1)), tolerance=np.ones(1))
    none = np.zeros((0, 50, 1))
    part = Linearisation(behind * start[:, 0], np.zeros((50, 0)), start, none)
    likelihood = Likelihood([run], [zero], [np.zeros((50, 1))])
    (swung,), about, cost = likelihood.swung([part])
    assert swung.by_start == pytest.approx(share * start)
    own = np.hstack([zero, share * start])
    both, alone = (np.linalg.det(np.eye(n) + own[:, :n].T @ own[:, :n]) for n in (2, 1))
    assert about.units == pytest.approx([1.0])
    assert cost == pytest.approx(np.log(both / alone) + 2.0 * np.log(len(SWINGS)))
