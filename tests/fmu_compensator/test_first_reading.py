"""A run whose displacement is first read after its start: drift counts from there everywhere."""

import numpy as np
import pytest

import spindle_drift as sd
from fmu_compensator.driving import drive
from fmu_compensator.fit.data import prepare
from fmu_compensator.fit.features import sample_of, with_lags
from fmu_compensator.fit.fitting import compensator_text, fit_compensator
from fmu_compensator.runtime.modelfile import parse_model
from measurement.drift import predicted_drift
from measurement.errors import BadInput
from measurement.runs import Run
from scenarios.probing import ProbedRun, Probing
from tests.fmu_compensator.conftest import DIRECT_RIG
from tests.fmu_compensator.test_installed import NEW, RUNS

LATE = 25


def measured_late(run: Run) -> Run:
    frame = run.frame.copy()
    frame.loc[: LATE - 1, list(DIRECT_RIG.columns)] = np.nan
    return Run(run.name, frame)


@pytest.fixture(scope="module")
def text() -> str:
    return compensator_text(fit_compensator(RUNS, DIRECT_RIG, judge=False))


def test_what_is_left_is_what_is_left_since_then(text):
    model = parse_model(text, "made")
    whole, late = (drive(model, run, run, DIRECT_RIG, 100.0) for run in (NEW, measured_late(NEW)))
    since = whole.error - whole.error[LATE]
    assert np.isnan(late.error[:LATE, [0, 2]]).all()
    np.testing.assert_allclose(late.error[LATE:], since[LATE:], atol=1e-9)
    assert np.nanmax(np.abs(whole.error[LATE])) > 0.01, "or nothing is asked"


def test_judged_as_it_is_driven(text, tmp_path):
    path = tmp_path / "made.json"
    path.write_text(text)
    table = sd.Compensator.load(path).judge(measured_late(NEW))
    driven = drive(parse_model(text, "made"), NEW, measured_late(NEW), DIRECT_RIG, 100.0)
    np.testing.assert_allclose(table["error_Z_um"], driven.error[:, 2], atol=1e-9)


def test_a_model_learns_as_much_of_what_it_is_shown():
    (run,) = prepare([measured_late(NEW)], DIRECT_RIG).runs
    rows = run.history([0, 3])
    mean = np.cumsum(np.ones_like(rows.targets), axis=0)
    sample = sample_of(rows, rows.inputs, rows.targets, mean)
    features = with_lags(rows.time_s, rows.inputs)
    place = np.flatnonzero(np.isclose(rows.time_s, 3600.0 * sample.hours[-1] + LATE * 60.0))[0]
    np.testing.assert_allclose(sample.features[-1], features[place] - features[LATE])
    np.testing.assert_allclose(sample.mean[-1], mean[place] - mean[LATE])
    np.testing.assert_allclose(sample.targets[-1], rows.targets[place])
    assert sample.hours[0] > 0.0


@pytest.mark.parametrize("kind", ["gaussian", "mlr"])
def test_fitted_to_late_runs_it_leaves_as_little(kind):
    runs = (
        [RUNS[0], *map(measured_late, RUNS[1:])] if kind == "mlr" else [*map(measured_late, RUNS)]
    )
    left = []
    for known in (RUNS, runs):
        text = compensator_text(fit_compensator(known, DIRECT_RIG, kind, judge=False))
        left.append(drive(parse_model(text, kind), NEW, NEW, DIRECT_RIG, 100.0).error[:, 2])
    first, second = (float(np.sqrt(np.nanmean(error**2))) for error in left)
    assert second < 1.5 * first + 0.1


def test_that_it_was_late_is_told():
    notes = prepare([*map(measured_late, RUNS)], DIRECT_RIG).notes
    assert (
        f"a: displacement is first read {LATE} min after the start: drift counts from there"
        in notes
    )
    assert not any("first read" in note for note in prepare(RUNS, DIRECT_RIG).notes)


def test_what_a_probe_would_show_of_it_from_the_start_is_not_made_up(text):
    model = parse_model(text, "made")
    probed = drive(model, NEW, measured_late(NEW), DIRECT_RIG, 100.0, probe_every_s=1200.0)
    alone = drive(model, NEW, measured_late(NEW), DIRECT_RIG, 100.0)
    assert probed.outputs == alone.outputs
    with pytest.raises(BadInput, match="displacement: begins so late"):
        ProbedRun(Probing(every_s=1200.0), model, measured_late(NEW), DIRECT_RIG, 100.0)


def test_an_absolute_form_counts_from_nothing():
    sent, drift = np.array([[0.0], [1.0], [2.0]]), np.array([[np.nan], [3.0], [4.0]])
    np.testing.assert_array_equal(predicted_drift(sent, drift, "absolute"), -sent)
    np.testing.assert_array_equal(predicted_drift(sent, drift, "rise"), 1.0 - sent)
    (run,) = prepare([measured_late(NEW)], DIRECT_RIG, "absolute").runs
    assert run.late_s == 0.0  # an error model in this form learns from it as from any other
