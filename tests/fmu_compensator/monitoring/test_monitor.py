"""Whether a compensator still fits: each verdict, on a machine whose truth is known."""

from typing import Any

import numpy as np
import pytest

from benchmarks.broken_sensor import jig_borer
from fmu_compensator.fit.fitting import compensator_text, fit_compensator
from fmu_compensator.monitoring import monitor
from fmu_compensator.monitoring.bounds import chance_of, upper_bound
from fmu_compensator.monitoring.monitor import (
    CHANGED,
    DOUBTFUL,
    FEW,
    FITS,
    LEARNT,
    NOT_MEASURED,
    OUTSIDE,
    SENSOR,
    UNUSUAL,
    WORSE,
)
from fmu_compensator.monitoring.sensors import Agreement
from fmu_compensator.runtime.modelfile import Model, parse_model
from measurement.errors import BadInput
from measurement.faults import looked_over
from measurement.resampling import WRONG
from measurement.runs import Run
from tests.fmu_compensator.conftest import RIG, make_run

TRAINING = looked_over([make_run(f"old{seed}", seed) for seed in range(8)])
NEW = [make_run(f"new{seed}", 100 + seed) for seed in range(3)]
DISPLACEMENTS, ROWS = RIG.columns, np.arange(len(NEW[0].frame))


def fitted(**options: bool) -> Model:
    # Its speed tells a made machine too much.
    table = fit_compensator(TRAINING, RIG, use_speed=False, **options)
    return parse_model(compensator_text(table), "m.json")


@pytest.fixture(scope="module")
def model() -> Model:
    return fitted()


def changed(run: Run, **columns: Any) -> Run:
    return Run(run.name, run.frame.assign(**columns))


def further(run: Run, times: float) -> Run:
    """Return a run whose machine moves so many times as far."""
    start = run.frame[DISPLACEMENTS].iloc[0]
    return changed(run, **(start + times * (run.frame[DISPLACEMENTS] - start)))


def unmeasured(run: Run, rows: Any = slice(None)) -> Run:
    """Return a run without the displacements of some rows."""
    frame = run.frame.copy()
    frame.loc[rows, DISPLACEMENTS] = np.nan
    return Run(run.name, frame)


def warmed_from_outside(run: Run) -> Run:
    """Return a run with a draught: the slow part warms while the spindle's does not."""
    rise = np.linspace(0.0, 12.0, len(run.frame))
    return changed(run, T3_degC=run.frame["T3_degC"] + rise, T4_degC=run.frame["T4_degC"] + rise)


def test_runs_like_the_training_fit(model):
    report = monitor(model, NEW)
    assert report.verdict == FITS
    assert [one.verdict for one in report.runs] == [FITS] * 3
    assert report.gains == ()
    assert all(error.left < 0.2 * error.none for one in report.runs for error in one.errors)
    assert (report.summary, report.advice) == ("still fits", "nothing to do")


WANDERING = changed(NEW[1], T1_degC=NEW[1].frame["T1_degC"] + np.linspace(0.0, 6.0, len(ROWS)))
STOPS = changed(NEW[0], T1_degC=NEW[0].frame["T1_degC"].where(len(ROWS) // 3 > ROWS))

COMES_BACK = changed(
    NEW[0],
    T1_degC=NEW[0].frame["T1_degC"].where(abs(ROWS - len(ROWS) // 2) > len(ROWS) // 6),
    T2_degC=NEW[0].frame["T2_degC"].where(len(ROWS) - 1 > ROWS),
)


@pytest.mark.parametrize("broken", [WANDERING, STOPS, COMES_BACK])
def test_a_thermometer_is_named_and_not_the_machine(model, broken):
    report = monitor(model, [NEW[2], broken])
    assert report.verdict == SENSOR
    assert [one.verdict for one in report.runs] == [FITS, SENSOR]
    assert report.runs[1].sensor == "T1"
    assert "T1" in report.runs[1].reasons[0]


def test_a_machine_that_moves_further_has_changed_and_by_how_much(model):
    report = monitor(model, [further(run, 1.5) for run in NEW])
    assert report.verdict == CHANGED
    gains = {gain.axis: gain for gain in report.gains}
    assert gains["Z"].low < 1.5 < gains["Z"].high or gains["Z"].value == pytest.approx(1.5, abs=0.1)
    assert "half width" in report.runs[0].reasons[0]


def test_one_run_that_moves_further_may_be_chance(model):
    little = changed(NEW[0], **(1.01 * NEW[0].frame[DISPLACEMENTS]))
    report = monitor(model, [little, *NEW[1:]])
    assert report.verdict == UNUSUAL
    assert report.runs[0].verdict == CHANGED


def test_a_run_that_misses_as_one_of_training_did_is_no_good_news():
    strange = looked_over([*TRAINING[:7], further(TRAINING[7], 1.3)])
    model = parse_model(compensator_text(fit_compensator(strange, RIG)), "m.json")
    report = monitor(model, [further(NEW[0], 1.2), NEW[1]])
    assert report.verdict == FITS
    assert "more than promised remains in new0 (" in report.summary
    assert "new1" not in report.summary
    assert "measure more runs" in report.advice


def test_a_sensor_that_slips_late_is_told_though_the_run_fits(model):
    still = changed(NEW[0], speed_rpm=np.full(len(ROWS), 4000.0))
    (width,) = (one.half_width for one in monitor(model, [still]).runs[0].errors if one.axis == "Z")
    slips = still.frame[DISPLACEMENTS[-1]] + 5.0 * width * (len(ROWS) - 8 < ROWS)
    slipped = changed(still, **{DISPLACEMENTS[-1]: slips})
    warmed = unmeasured(warmed_from_outside(NEW[1]))
    for runs, verdict in (([slipped], FITS), ([slipped, warmed], OUTSIDE)):
        report = monitor(model, runs)
        assert report.verdict == verdict
        assert "the drift leaps in new0 (Z)" in report.summary
        assert "slipped" in report.advice
        assert any(reason.startswith("Z leaps by") for reason in report.runs[0].reasons)


def test_offsets_that_do_not_help_are_no_good_news(model):
    hardly = further(NEW[0], 0.0)
    noise = np.random.default_rng(0).normal(0.0, 0.05, (len(ROWS), len(DISPLACEMENTS)))
    hardly = changed(hardly, **(hardly.frame[DISPLACEMENTS] + noise))
    cold = changed(hardly, **{f"T{n}_degC": 21.0 + noise[:, n] for n in (1, 2, 4)})
    report = monitor(model, [cold, *NEW])
    assert report.verdict == FITS
    assert "the offsets do not help in new0 (" in report.summary
    assert "measure more runs" in report.advice
    mixed = monitor(model, [cold, NEW[1], unmeasured(warmed_from_outside(NEW[2]))])
    assert mixed.verdict == OUTSIDE
    assert "the offsets do not help in new0 (" in mixed.summary
    assert [WORSE in run.but for run in mixed.runs] == [True, False, False]


def test_an_interval_that_holds_too_little_is_no_good_news(model):
    (width,) = (e.half_width for e in monitor(model, NEW[:1]).runs[0].errors if e.axis == "Z")
    waves = 1.15 * width * np.sin(0.3 * ROWS)
    waving = changed(NEW[0], **{DISPLACEMENTS[-1]: NEW[0].frame[DISPLACEMENTS[-1]] + waves})
    report = monitor(model, [waving, *NEW[1:]])
    (error,) = (e for e in report.runs[0].errors if e.axis == "Z")
    assert error.miss < 1.0
    assert 0.5 < error.inside < 0.8
    assert report.summary == f"still fits, but {FEW} in new0 (Z)"
    assert "measure more runs" in report.advice


def test_a_run_given_twice_is_refused(model):
    with pytest.raises(BadInput, match="give it once"):
        monitor(model, [NEW[0], Run("again", NEW[0].frame)])


def test_two_swapped_thermometers_of_a_single_run_are_doubted_and_nothing_is_learnt(model):
    frame = NEW[0].frame
    swapped = changed(NEW[0], T1_degC=frame["T4_degC"], T4_degC=frame["T1_degC"])
    report = monitor(model, [swapped])
    (note,) = (note for note in report.notes if note.startswith("doubtful"))
    assert note.endswith(
        "T1 behaves like T4 in training, and that one like it, in new0: swapped there?"
    )
    assert "update" not in report.advice
    assert report.runs[0].verdict != SENSOR


def test_other_conditions_are_outside(model):
    report = monitor(model, [unmeasured(warmed_from_outside(NEW[0]))])
    assert report.verdict == OUTSIDE
    assert report.runs[0].outside > 0.25


def test_without_a_measurement_it_does_not_say_that_the_drift_fits(model):
    report = monitor(model, [unmeasured(run) for run in NEW])
    assert report.verdict == NOT_MEASURED
    assert "measure" in report.advice


@pytest.mark.parametrize(
    "runs",
    [
        [unmeasured(further(run, 1.5), ROWS % 80 != 0) for run in NEW],  # a few probes are enough
        [further(NEW[0], 3.0)],  # so far off is no chance
    ],
)
def test_a_change_is_seen_in_few_probes_or_in_one_run(model, runs):
    assert monitor(model, runs).verdict == CHANGED


@pytest.mark.parametrize(
    ("times", "doubt"), [(-1.0, "Z drifts with the opposite"), (1e-3, "doubt")]
)
def test_nothing_is_learnt_from_what_may_be_a_flipped_sign_or_a_wrong_unit(model, times, doubt):
    report = monitor(model, [further(NEW[0], times), NEW[1]])
    assert [run.verdict for run in report.runs] == [CHANGED, FITS]
    assert report.verdict == DOUBTFUL
    assert any(note.startswith(doubt) for note in report.notes)
    assert "no longer drifts" not in report.summary
    assert "update" not in report.advice


def test_it_says_what_a_file_without_runs_left_out_cannot_tell():
    report = monitor(fitted(judge=False), NEW, RIG)
    assert report.verdict == FITS
    assert any("runs left out of training differed" in note for note in report.notes)


def test_a_run_without_a_thermometer_in_use_is_refused(model):
    with pytest.raises(BadInput, match="T4_degC: is missing"):
        monitor(model, [Run("x", NEW[0].frame.drop(columns="T4_degC"))])


def test_a_drift_in_millimetres_is_told_and_not_just_missing():
    frame = NEW[0].frame.rename(columns=lambda name: name.replace("_um", "_mm"))
    report = monitor(fitted(judge=False), [Run("x", frame)], RIG)
    assert report.verdict == NOT_MEASURED
    assert report.notes[0].startswith(
        "a drift must be in um, not mm (spindle-drift import converts drifts): "
    )


def test_it_says_where_the_drift_counts_from(model):
    report = monitor(model, [unmeasured(NEW[0], ROWS < 60), NEW[1]])
    late = (NEW[0].time_s[60] - NEW[0].time_s[0]) / 60.0
    said = (
        f"new0: displacement is first read {late:.0f} min after the start: drift counts from there"
    )
    assert report.notes == (said,)


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


def test_what_it_has_learnt_from_is_no_sign_that_it_fits(model):
    report = monitor(model, [TRAINING[0], NEW[0]])
    assert report.notes[0].startswith("the compensator was trained on these: old0;")
    assert [run.verdict for run in report.runs] == [LEARNT, FITS]
    only = monitor(model, [TRAINING[0]])
    assert (only.verdict, only.inside) == (LEARNT, {})


@pytest.mark.parametrize(("name", "sense"), [("T2", 1.0), ("T2", -1.0), ("T10", 1.0)])
def test_a_thermometer_that_wanders_alone_is_not_called_swapped(name, sense):
    model, run, _ = jig_borer()
    agreement, wandering = Agreement(model), np.linspace(0.0, sense * 8.0, len(run.frame))
    assert agreement.of(run) is agreement.swapped(run) is None
    astray = changed(run, **{f"{name}_degC": run.frame[f"{name}_degC"] + wandering})
    assert (found := agreement.of(astray)) is not None
    assert found.sensor == name
    assert agreement.swapped(astray) is None
