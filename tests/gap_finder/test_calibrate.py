"""Observations, priors and calibration."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from gap_finder import calibrate as calibrating
from gap_finder.calibrate import calibrate
from gap_finder.candidates import with_effect
from gap_finder.data_faults import DataFault, without_bad_readings
from gap_finder.descent import Descent, Point
from gap_finder.likelihood import Quadratic
from gap_finder.linearise import linear_about, residuals_of
from gap_finder.observations import observe
from gap_finder.priors import Priors
from measurement.runs import Run
from plant_model.integrate import IntegrationError
from plant_model.machine_file import read_machine
from plant_model.machine_writer import write_machine
from tests.gap_finder.conftest import only_free, runs_of
from tests.refusing import refusal


def test_priors_go_to_the_fitting_scale_and_back(jig_borer_lumps):
    priors = Priors.of(jig_borer_lumps, calibrated=True)
    x = np.random.default_rng(0).uniform(np.maximum(priors.low, -2), np.minimum(priors.high, 2))
    values = {name: float(value[0]) for name, value in priors.values(x[None]).items()}
    moved = jig_borer_lumps.with_values(values, beyond=True)
    np.testing.assert_allclose(priors.position(moved), x, atol=1e-9)
    np.testing.assert_allclose(priors.position(jig_borer_lumps), 0.0, atol=1e-12)


def test_a_direction_goes_on_beyond_half_a_turn(jig_borer_lumps):
    """Nearer to its usual value on the other side, and with no wall where the turn ends."""
    machine = with_effect(only_free(jig_borer_lumps), "column_bending", {"direction": -170.0})
    usual = with_effect(only_free(jig_borer_lumps), "column_bending")
    priors = Priors.of(usual, calibrated=True)
    name = "effects.column_bending.direction"
    place = priors.names.index(name)
    x = priors.position(machine)
    assert x[place] == pytest.approx((190.0 - 45.0) / 90.0)
    assert priors.values(x[None])[name] == pytest.approx([-170.0])
    x[place] = (181.0 - 45.0) / 90.0
    assert priors.values(x[None])[name] == pytest.approx([-179.0])
    assert priors.low[place] == -np.inf
    ends = [priors.beside(x, shift * np.full(len(x), 0.1))[place] for shift in (-1.0, 0.0, 1.0)]
    assert ends == pytest.approx([-188.0, -179.0, -170.0])


def test_a_range_ends_two_deviations_out_and_is_no_wall(jig_borer_lumps):
    name = "sources.front_bearing.f0"
    f0 = replace(jig_borer_lumps.parameters[name], value=0.6, low=0.3, high=1.2)
    bearing = next(item for item in jig_borer_lumps.items if item.name == "front_bearing")
    items = tuple(
        replace(item, parameters=item.parameters | {"f0": f0}) if item is bearing else item
        for item in jig_borer_lumps.items
    )
    machine = only_free(replace(jig_borer_lumps, items=items), name)
    priors = Priors.of(machine, calibrated=True)
    values = priors.values(np.array([[-2.0], [0.0], [2.0], [4.0], [1e6], [-1e6]]))[name]
    np.testing.assert_allclose(values[:4], [0.3, 0.6, 1.2, 2.4])
    np.testing.assert_allclose(values[4:], [20.0, 0.1])  # what f0 can be at all


def test_calibration_leaves_a_range_that_the_runs_contradict_and_says_so(jig_borer_lumps, tmp_path):
    name = "sources.motor.loss"
    known = jig_borer_lumps.parameters[name]
    truth = 1.25 * known.high
    runs = runs_of(jig_borer_lumps.with_values({name: truth}, beyond=True))
    found = calibrate(jig_borer_lumps, observe(jig_borer_lumps, runs), starts=1)
    (told,) = (entry for entry in found.parameters if entry.name == name)
    assert told.value == pytest.approx(truth, rel=0.05)
    assert told.is_far
    assert told.deviations > 2.0
    assert not told.at_bound
    # What was found can be written, and the file still says what was expected.
    again = read_machine(write_machine(found.machine, "jig_borer_lumps", tmp_path / "m.toml"))
    assert again == found.machine
    assert again.parameters[name].source.endswith(
        f"calibrated beyond {known.low:.4g} to {known.high:.4g}"
    )


def test_numbers_of_effects_are_no_uncertainty_of_the_machine(jig_borer_lumps):
    fixed = Priors.of(jig_borer_lumps, calibrated=False)
    assert fixed.names
    assert not any(name.startswith("effects.") for name in fixed.names)


def test_sampling_does_not_decide_how_much_a_run_weighs(jig_borer_lumps):
    weights = [
        sum(
            float(((one.weights * one.tolerance) ** 2).sum())
            for one in observe(jig_borer_lumps, runs)
        )
        for runs in (runs_of(jig_borer_lumps, 20.0), runs_of(jig_borer_lumps, 120.0))
    ]
    assert weights[1] == pytest.approx(weights[0], rel=0.15)


def test_spans_that_are_bad_are_left_out(jig_borer_lumps):
    run = runs_of(jig_borer_lumps)[0]
    fault = DataFault(run.name, "T1", "frozen", 600.0, 1200.0, "")
    (one,) = observe(jig_borer_lumps, [without_bad_readings(jig_borer_lumps, run, [fault])])
    rows = (one.time_s > 660.0) & (one.time_s < 1140.0)
    t1 = one.channels.index("T1")
    assert np.all(one.weights[rows, t1] == 0.0)
    assert np.all(one.weights[rows, t1 + 1] > 0.0)


def test_runs_without_a_channel_to_compare_are_refused(jig_borer_lumps):
    frame = pd.DataFrame({"time_s": [0.0, 1.0, 2.0], "speed_rpm": 0.0, "T5_degC": 21.0})
    assert "no column to compare" in refusal(observe, jig_borer_lumps, [Run("empty", frame)])


def test_a_calibration_that_cannot_reach_a_cost_ends_early(jig_borer_lumps):
    truth = jig_borer_lumps.with_values({"sources.front_bearing.f0": 0.65})
    iterations: list[str] = []
    observed = observe(jig_borer_lumps, runs_of(truth))
    to_the_end = calibrate(jig_borer_lumps, observed, starts=1, progress=iterations.append)
    within = len(iterations)
    iterations.clear()
    found = calibrate(
        jig_borer_lumps, observed, starts=1, cost_limit=0.0, progress=iterations.append
    )
    assert 0 < len(iterations) < within
    assert found.expected < found.cost
    assert to_the_end.cost < found.cost


@pytest.mark.parametrize(
    ("before", "expected", "may"),
    [
        (340.0, 331.0, True),
        (331.0, 331.5, True),  # promised less than before, but enough
        (342.0, 338.0, False),
        (842.0, 353.0, True),  # from far away, more with every step
    ],
)
def test_a_descent_goes_on_while_it_may_reach_a_cost(before, expected, may):
    about = Quadratic(np.eye(1), np.zeros(1), 400.0, np.ones(1), 1.0)
    first, second = (Point(np.zeros(1), (), about, promised) for promised in (before, expected))
    descent = Descent(first)
    assert descent.may_reach(332.0)  # nothing tried yet
    descent.move(second)
    assert descent.may_reach(332.0) is may


def test_calibration_finds_what_the_runs_determine_and_leaves_the_rest(jig_borer_lumps):
    truth = {"sources.front_bearing.f0": 0.65, "sources.motor.loss": 33.0}
    observed = observe(jig_borer_lumps, runs_of(jig_borer_lumps.with_values(truth)))
    found = calibrate(jig_borer_lumps, observed, starts=1)
    by_name = {entry.name: entry for entry in found.parameters}
    for name, value in truth.items():
        entry = by_name[name]
        assert entry.prior_contraction > 0.4
        assert abs(entry.value - value) < abs(entry.prior - value) / 2.0
        assert entry.low <= value <= entry.high
    silent = by_name["links.rotor-shaft_middle.conductance"]  # of which the runs say nothing
    assert silent.prior_contraction < 0.2
    assert silent.value == pytest.approx(silent.prior, rel=0.1)
    before, after = (
        sum(float((one**2).sum()) for one in residuals_of(machine, observed, {}))
        for machine in (jig_borer_lumps, found.machine)
    )
    assert after < before / 20.0


def test_a_start_from_which_the_machine_nearly_runs_away_is_dropped(jig_borer_lumps, monkeypatch):
    """A preload that heats what heats it: derivatives too large for doubles."""
    machine = only_free(jig_borer_lumps, "sources.front_bearing.f0", "sources.motor.loss")
    observed = observe(machine, runs_of(machine.with_values({"sources.motor.loss": 33.0})))
    away = machine.with_values({"sources.front_bearing.f0": 0.9})
    sound = calibrate(machine, observed, starts=1)

    def about(machine, observed, priors, point):
        parts = linear_about(machine, observed, priors, point)
        if not np.allclose(point, priors.position(away)):
            return parts
        return [replace(p, by_parameter=np.full_like(p.by_parameter, np.nan)) for p in parts]

    monkeypatch.setattr(calibrating, "linear_about", about)
    found = calibrate(machine, observed, starts=1, start_from=[machine, away])
    assert found.cost == pytest.approx(sound.cost)
    with pytest.raises(IntegrationError, match="cannot be stepped"):
        calibrate(machine, observed, starts=1, start_from=[away])


def test_a_machine_without_free_numbers_stays_as_it_is(jig_borer_lumps):
    fixed = only_free(jig_borer_lumps)
    found = calibrate(fixed, observe(fixed, runs_of(jig_borer_lumps)))
    assert (found.machine, found.parameters) == (fixed, ())
