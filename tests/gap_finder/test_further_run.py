"""The run that would tell explanations apart, and what it is expected to tell."""

from __future__ import annotations

import tomllib
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gap_finder import further_run as module
from gap_finder.calibrate import calibrate
from gap_finder.candidates import with_effect
from gap_finder.design import all_sensitivities, run_design, sensitivities_of
from gap_finder.further_run import FurtherRun, further_run
from gap_finder.kinds.heat_path import HeatPath
from gap_finder.observations import Observations, observe
from gap_finder.priors import Priors
from gap_finder.refit import CandidateFit, score_fit
from measurement.runs import Run
from plant_model.machine import Machine
from plant_model.machine_file import read_machine
from plant_model.simulate import simulate
from scenarios.gap_next_run import next_run_scenario
from scenarios.scenario import read_scenario
from tests.gap_finder.conftest import runs_of


@pytest.fixture(scope="module")
def fits(jig_borer_lumps: Machine) -> tuple[list[CandidateFit], list[Observations]]:
    """Return fits with windage, iron loss and a whiff of windage more, on runs of the first."""
    true = with_effect(jig_borer_lumps, "windage", {"power": 400.0})
    observed = observe(jig_borer_lumps, runs_of(true, every_s=120.0)[:3])
    found = []
    for key, values in (
        ("windage", {"power": 400.0}),
        ("tool_heating", {}),
        ("windage", {"power": 400.5}),
    ):
        base = with_effect(jig_borer_lumps, key, values)
        known = all_sensitivities(base, base, observed)
        calibration = calibrate(base, observed, starts=1, iterations=1, sensitivities=known)
        found.append(score_fit(base, (key,), observed, calibration, known))
    return found, observed


@pytest.fixture(scope="module")
def proposed(fits: tuple[list[CandidateFit], list[Observations]]) -> FurtherRun:
    """Return the run that tells the first from the second."""
    (first, second, _), observed = fits
    found = further_run([first, second], observed)
    assert found is not None
    return found


def test_proposes_a_run_in_which_the_readings_differ(
    fits: tuple[list[CandidateFit], list[Observations]], proposed: FurtherRun
) -> None:
    (first, second, _), observed = fits
    found = proposed
    inputs = module._inputs(first.machine, found.stretches, observed)
    shown = [
        simulate(one.machine, inputs, step_s=60.0, tolerance=1e-2).readings[found.channel][0]
        for one in (first, second)
    ]
    assert np.abs(shown[0] - shown[1]).max() == pytest.approx(found.difference, rel=1e-6)
    assert found.evidence > 0.0
    assert found.said().startswith(f"{found.profile}: {found.channel} would differ by up to")


def test_a_model_that_leaves_much_will_be_no_surer_of_the_next_run(
    fits: tuple[list[CandidateFit], list[Observations]], proposed: FurtherRun
) -> None:
    (first, second, _), observed = fits
    # Nine tolerances squared for every channel of every run.
    poor = replace(first, loro_cost=np.full(len(observed), 9.0 * len(observed[0].channels)))
    unsure = further_run([poor, second], observed)
    assert unsure is not None
    assert unsure.evidence == pytest.approx(proposed.evidence / 9.0)


def test_proposes_nothing_where_no_run_differs(
    fits: tuple[list[CandidateFit], list[Observations]],
) -> None:
    (first, _, twin), observed = fits
    assert further_run([first, twin], observed) is None


def test_evidence_is_what_least_squares_cannot_explain(
    fits: tuple[list[CandidateFit], list[Observations]],
) -> None:
    (best, rival, _), observed = fits
    stretches = {"speed": ((0.0, 9000.0), (3 * 3600.0, 0.0))}
    inputs = module._inputs(best.machine, stretches, observed)
    names = observed[0].channels
    known = module._told_so_far(best)
    told = module._evidence(best, rival.machine, inputs, names, known)
    # The same by one large least-squares problem: old runs, priors and the new run, row by row.
    frame = simulate(rival.machine, inputs, step_s=60.0, tolerance=1e-2).run_frame()
    (one,) = observe(best.machine, [Run("new", frame)], channels=names)
    moved = Priors.of(best.base, calibrated=True)
    fixed = Priors.of(best.machine, calibrated=False)
    *old, new = (
        run_design(best.machine, o, moved, sensitivities_of(best.machine, o, moved, fixed))
        for o in (*best.observed, one)
    )
    shared = new.shared.shape[1]
    own = [design.nuisance.shape[1] for design in (*old, new)]
    rows, right = [], []
    for i, design in enumerate((*old, new)):
        parts = [design.shared, *(np.zeros((len(design.residual), n)) for n in own)]
        parts[1 + i] = design.nuisance
        rows.append(np.hstack(parts))
        # The old runs are explained as well as they can be: they only hold the parameters.
        right.append(design.residual if design is new else np.zeros(len(design.residual)))
    size = shared + sum(own)
    matrix, wanted = np.vstack([*rows, np.eye(size)]), np.concatenate([*right, np.zeros(size)])
    moved_by = np.linalg.lstsq(matrix, -wanted, rcond=None)[0]
    assert told == pytest.approx(float(np.sum((wanted + matrix @ moved_by) ** 2)), rel=1e-6)


def test_a_path_that_a_thermometer_may_read_is_weighed_too(
    jig_borer_lumps: Machine, fits: tuple[list[CandidateFit], list[Observations]]
) -> None:
    (rival, _, _), observed = fits
    sensor = next(one for one in jig_borer_lumps.sensors if one.of in jig_borer_lumps.node_index)
    joined = {name for item in jig_borer_lumps.items for name in item.refs.get("between", ())}
    beside = {
        name
        for item in jig_borer_lumps.items
        if sensor.of in item.refs.get("between", ())
        for name in item.refs["between"]
    }
    other = sorted((joined & jig_borer_lumps.node_index.keys()) - beside)[0]
    change = HeatPath((sensor.of, other), False)
    base = change.put_into(jig_borer_lumps, {"conductance": 20.0})
    known = all_sensitivities(jig_borer_lumps, jig_borer_lumps, observed)
    calibration = calibrate(base, observed, starts=1, iterations=1, sensitivities=known)
    fit = score_fit(base, (change.key,), observed, calibration, known)
    told = module._told_so_far(fit)
    priors = [Priors.of(jig_borer_lumps, calibrated=which) for which in (True, False)]
    without = sensitivities_of(jig_borer_lumps, observed[0], *priors).other.shape[1]
    assert len(told) == len(Priors.of(base, calibrated=True).names) + without + 1
    found = further_run([fit, rival], observed)
    assert found is not None
    assert found.evidence > 0.0


def test_every_driving_input_is_tried_alone_and_with_the_others(jig_borer_lumps: Machine) -> None:
    observed = observe(jig_borer_lumps, runs_of(jig_borer_lumps))
    profiles = dict(module._profiles(jig_borer_lumps, observed))
    assert len(profiles) == len(module.PROFILES)
    top = max(float(one.run.frame["speed_rpm"].max()) for one in observed)
    assert profiles["6 h at the highest speed"]["speed"] == ((0.0, top),)


def test_the_scenario_file_is_the_run(tmp_path: Path) -> None:
    run = FurtherRun(
        "3 h at the highest speed, then 3 h without",
        {"speed": ((0.0, 9000.0), (10800.0, 0.0))},
        {"ambient": 21.5, "coolant_inlet": 22.0},
        "T8",
        1.25,
        "K",
        9.0,
    )
    table = {
        "next_run": asdict(run),
        "one_of_keys": ["windage", "motor_loss"],
        "separate_by": run.said(),
    }
    path = tmp_path / "next_run.toml"
    path.write_text(next_run_scenario(table))
    (case,) = read_scenario(path).cases
    assert case.settings.duration_s == 6 * 3600.0
    signals = tomllib.loads(path.read_text())["signals"]
    assert signals["speed"]["values"] == [9000.0, 0.0]
    assert signals["coolant_inlet"] == 22.0
    assert run.said().endswith("odds of 90 to 1")
    assert replace(run, evidence=10.3).said().endswith("odds of 170 to 1")
    faint = replace(run, evidence=1.7).said()
    assert faint.endswith("odds of 2.3 to 1, too little to tell them apart for sure")


def test_a_run_says_which_input_rests() -> None:
    lathe = read_machine("lathe")
    time = np.arange(0.0, 7200.0, 60.0)
    frame = pd.DataFrame({"time_s": time, "speed_rpm": 1000.0, "feed_mm_min": 4000.0})
    for sensor in lathe.sensors:
        frame[sensor.column] = 20.0 + 1e-4 * time
    profiles = dict(module._profiles(lathe, observe(lathe, [Run("a", frame)])))
    assert len(profiles) == 3 * len(module.PROFILES)
    assert profiles["6 h at the highest speed, no feed"]["feed"] == ((0.0, 0.0),)
    assert profiles["6 h at the highest speed and feed"]["feed"] == ((0.0, 4000.0),)
