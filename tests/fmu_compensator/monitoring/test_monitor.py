"""Whether a compensator still fits: each verdict, on a machine whose truth is known."""

from collections.abc import Callable

import numpy as np
import pandas as pd
import pytest

from fmu_compensator.fit.fitting import compensator_text, fit_compensator
from fmu_compensator.monitoring import monitor
from fmu_compensator.monitoring.bounds import chance_of, upper_bound
from fmu_compensator.monitoring.monitor import (
    CHANGED,
    FITS,
    LEARNT,
    NOT_MEASURED,
    OUTSIDE,
    SENSOR,
    UNUSUAL,
)
from fmu_compensator.runtime.modelfile import Model, parse_model
from measurement.errors import BadInput
from measurement.resampling import WRONG
from measurement.runs import Run
from tests.fmu_compensator.conftest import RIG, make_run

TRAINING = [make_run(f"old{seed}", seed) for seed in range(8)]
NEW = [make_run(f"new{seed}", 100 + seed) for seed in range(3)]
DISPLACEMENTS = RIG.columns


def fitted(**options: bool) -> Model:
    table = fit_compensator(TRAINING, RIG, **options)
    return parse_model(compensator_text(table), "m.json")


@pytest.fixture(scope="module")
def model() -> Model:
    return fitted()


def changed(run: Run, change: Callable[[pd.DataFrame], None]) -> Run:
    frame = run.frame.copy()
    change(frame)
    return Run(run.name, frame)


def wandering(frame: pd.DataFrame) -> None:
    frame["T1_degC"] += np.linspace(0.0, 6.0, len(frame))


def moving_more(frame: pd.DataFrame) -> None:
    for name in DISPLACEMENTS:
        frame[name] = frame[name][0] + 1.5 * (frame[name] - frame[name][0])


def warmed_from_outside(frame: pd.DataFrame) -> None:
    # A draught: the slow part warms while the spindle's does not.
    rise = np.linspace(0.0, 12.0, len(frame))
    frame["T4_degC"] += rise
    frame["T3_degC"] += rise


def test_runs_like_the_training_fit(model):
    report = monitor(model, NEW)
    assert report.verdict == FITS
    assert [one.verdict for one in report.runs] == [FITS] * 3
    assert report.gains == ()
    assert all(error.left < 0.2 * error.none for one in report.runs for error in one.errors)


def test_a_thermometer_that_wanders_is_named(model):
    report = monitor(model, [NEW[0], changed(NEW[1], wandering)])
    assert report.verdict == SENSOR
    assert [one.verdict for one in report.runs] == [FITS, SENSOR]
    assert report.runs[1].sensor == "T1"
    assert "T1" in report.runs[1].reasons[0]


def test_a_machine_that_moves_further_has_changed_and_by_how_much(model):
    report = monitor(model, [changed(run, moving_more) for run in NEW])
    assert report.verdict == CHANGED
    gains = {gain.axis: gain for gain in report.gains}
    assert gains["Z"].low < 1.5 < gains["Z"].high or gains["Z"].value == pytest.approx(1.5, abs=0.1)
    assert "half width" in report.runs[0].reasons[0]


def test_one_run_that_moves_further_may_be_chance(model):
    def moving_a_little_more(frame: pd.DataFrame) -> None:
        frame[DISPLACEMENTS] *= 1.01

    report = monitor(model, [changed(NEW[0], moving_a_little_more), *NEW[1:]])
    assert report.verdict == UNUSUAL
    assert report.runs[0].verdict == CHANGED


def test_other_conditions_are_outside(model):
    def no_displacements(frame: pd.DataFrame) -> None:
        warmed_from_outside(frame)
        frame[DISPLACEMENTS] = np.nan

    report = monitor(model, [changed(NEW[0], no_displacements)])
    assert report.verdict == OUTSIDE
    assert report.runs[0].outside > 0.25


def test_without_a_measurement_it_does_not_say_that_the_drift_fits(model):
    def only_temperatures(frame: pd.DataFrame) -> None:
        frame[DISPLACEMENTS] = np.nan

    report = monitor(model, [changed(run, only_temperatures) for run in NEW])
    assert report.verdict == NOT_MEASURED
    assert "measure" in report.advice


def test_a_few_probes_are_enough_to_see_a_change(model):
    def probed(frame: pd.DataFrame) -> None:
        moving_more(frame)
        rows = np.arange(len(frame)) % 80 != 0
        frame.loc[rows, DISPLACEMENTS] = np.nan

    assert monitor(model, [changed(run, probed) for run in NEW]).verdict == CHANGED


def test_a_broken_thermometer_is_a_fault_of_the_sensor_not_of_the_machine(model):
    def stops(frame: pd.DataFrame) -> None:
        frame.loc[len(frame) // 3 :, "T1_degC"] = np.nan

    [told] = monitor(model, [changed(NEW[0], stops)]).runs
    assert (told.verdict, told.sensor) == (SENSOR, "T1")


def test_it_says_what_a_file_without_runs_left_out_cannot_tell():
    report = monitor(fitted(judge=False), NEW, RIG)
    assert report.verdict == FITS
    assert any("runs left out of training differed" in note for note in report.notes)


def test_a_run_without_a_thermometer_in_use_is_refused(model):
    with pytest.raises(BadInput, match="T4_degC: is missing"):
        monitor(model, [Run("x", NEW[0].frame.drop(columns="T4_degC"))])


def test_the_bound_holds_for_one_more_of_the_same():
    random = np.random.default_rng(1)
    passed = [
        values[-1] > upper_bound(values[:-1].tolist())
        for values in np.exp(random.normal(0.0, 0.4, (10_000, 8)))
    ]
    assert 0.5 * WRONG < np.mean(passed) < 1.2 * WRONG  # the largest of seven is a floor: rarer
    assert upper_bound([1.0]) == float("inf")


def test_what_is_at_the_bound_has_the_chance_of_the_bound():
    values = [0.4, 0.6, 0.5, 0.9]
    assert chance_of(upper_bound(values), values) == pytest.approx(WRONG)
    assert chance_of(40.0, values) < 1e-3
    assert chance_of(40.0, [0.5]) == 1.0  # nothing is known of how they vary


def test_one_run_that_is_so_far_off_is_no_chance(model):
    def turned_round(frame: pd.DataFrame) -> None:
        frame[DISPLACEMENTS] = -frame[DISPLACEMENTS]

    assert monitor(model, [changed(NEW[0], turned_round)]).verdict == CHANGED


def test_what_it_has_learnt_from_is_no_sign_that_it_fits(model):
    report = monitor(model, [TRAINING[0], NEW[0]])
    assert report.notes[0].startswith("the compensator was trained on these: old0;")
    assert [run.verdict for run in report.runs] == [LEARNT, FITS]
    only = monitor(model, [TRAINING[0]])
    assert (only.verdict, only.inside) == (LEARNT, {})
