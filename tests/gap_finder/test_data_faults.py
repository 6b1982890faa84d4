"""What is taken out of runs before a model is compared with them."""

import numpy as np
import pytest

from gap_finder.candidates import with_effect
from gap_finder.data_faults import WHOLE_RUN, need_readings, without_faults
from gap_finder.observations import observe
from measurement.errors import BadInput
from measurement.runs import Run
from plant_model.machine import Machine
from tests.gap_finder.conftest import runs_of


def changed(run: Run, column: str, values: np.ndarray | float) -> Run:
    return Run(run.name, run.frame.assign(**{column: values}))


@pytest.fixture(scope="module")
def seldom(jig_borer_lumps: Machine) -> list[Run]:
    """Sound runs with a row every four minutes."""
    return runs_of(jig_borer_lumps, 240.0)


@pytest.mark.parametrize("every_s", [20.0, 240.0])
def test_clean_runs_stay_as_they_are(jig_borer_lumps, every_s):
    runs = runs_of(jig_borer_lumps, every_s)
    left, faults = without_faults(jig_borer_lumps, runs)
    assert faults == []
    assert all(after is before for after, before in zip(left, runs, strict=True))


@pytest.mark.long
@pytest.mark.parametrize(
    ("key", "values"),
    [
        ("sensor_offset:T7", {"error": 0.5}),
        ("sensor_offset:T7", {"error": 3.0}),
        ("sensor_drift:T7", {"rate": 0.5}),
        ("sensor_lag:T7", {"minutes": 20.0}),
        ("bearing_stick_slip", {"hold": 20.0, "share": 0.1}),
        ("centrifugal_shift", {"shift": 30.0}),
        ("coolant_thermostat", {"band": 1.5, "period": 5.0}),
        ("thermal_preload", {"gain": 0.3}),
    ],
)
def test_real_effects_are_not_swallowed(jig_borer_lumps, seldom, key, values):
    moved = runs_of(with_effect(jig_borer_lumps, key, values), 240.0)
    for runs in (moved, [*seldom[:2], *moved[2:]]):
        assert without_faults(jig_borer_lumps, runs)[1] == []


def test_only_what_the_machine_uses_is_told(jig_borer_lumps):
    runs = [
        changed(run, "X9_degC", run.frame["T7_degC"] + 31.0) for run in runs_of(jig_borer_lumps)
    ]
    assert without_faults(jig_borer_lumps, runs)[1] == []


def test_a_spike_of_the_hall_is_bridged_and_a_broken_hall_spoils_the_run(jig_borer_lumps):
    runs = runs_of(jig_borer_lumps)
    hall = runs[1].frame["T5_degC"].to_numpy().copy()
    hall[150] += 20.0
    left, (spike,) = without_faults(jig_borer_lumps, [runs[0], changed(runs[1], "T5_degC", hall)])
    assert (spike.channel, spike.kind) == ("T5", "spikes")
    assert np.flatnonzero(left[1].frame["T5_degC"].isna()).tolist() == [150]
    hall[250:] += 15.0
    left, faults = without_faults(jig_borer_lumps, [runs[0], changed(runs[1], "T5_degC", hall)])
    assert [run.name for run in left] == [runs[0].name]
    assert {fault.run for fault in faults} == {runs[1].name}


@pytest.mark.parametrize(("minutes", "used"), [(25, True), (35, False)])
def test_a_run_whose_speed_is_unknown_for_long_is_not_used(jig_borer_lumps, minutes, used):
    first, other = runs_of(jig_borer_lumps)[:2]
    speed = first.frame["speed_rpm"].where(
        ~first.frame["time_s"].between(3600, 3600 + 60 * minutes)
    )
    left, faults = without_faults(jig_borer_lumps, [changed(first, "speed_rpm", speed), other])
    assert (first.name in [run.name for run in left]) is used
    assert [(fault.channel, fault.kind) for fault in faults] == [("speed", "missing")] * (not used)


def test_a_hall_that_is_written_every_hour_is_not_missing(jig_borer_lumps):
    first, other = runs_of(jig_borer_lumps)[:2]
    hall = first.frame["T5_degC"].where(first.frame["time_s"] % 3600.0 == 0.0)
    assert without_faults(jig_borer_lumps, [changed(first, "T5_degC", hall), other])[1] == []


def test_a_joined_recording_ends_the_run(jig_borer_lumps):
    run = runs_of(jig_borer_lumps)[0]
    frame = run.frame.copy()
    frame.loc[frame["time_s"] >= 3600.0, run.temperatures] += 7.0
    (left,), (fault,) = without_faults(jig_borer_lumps, [Run(run.name, frame)])
    assert (fault.channel, fault.kind) == (WHOLE_RUN, "jump")
    assert left.time_s[-1] < 3600.0


def test_runs_without_anything_to_compare_are_refused(jig_borer_lumps):
    run = runs_of(jig_borer_lumps)[0]
    read = [name for name in run.frame if str(name).endswith(("_degC", "_um"))]
    empty = run.frame.assign(**{n: np.nan for n in read if n not in ("T5_degC", "T9_degC")})
    with pytest.raises(BadInput, match="no usable reading to compare"):
        need_readings(jig_borer_lumps, [Run("empty", empty)], "--holdout")
    need_readings(jig_borer_lumps, [run], "--holdout")


def test_a_run_that_cannot_drive_the_machine_is_refused(jig_borer_lumps):
    run = runs_of(jig_borer_lumps)[0]
    silent = Run(run.name, run.frame.drop(columns="speed_rpm"))
    with pytest.raises(BadInput, match="speed_rpm: the machine needs this column"):
        observe(jig_borer_lumps, [silent])
