"""Thermometers that stand still, and sensors that are wrong in one run alone."""

import numpy as np

from gap_finder.data_faults import without_bad_readings
from gap_finder.observations import observe
from gap_finder.standing import calibrated, standing_still
from measurement.runs import Run
from tests.gap_finder.conftest import runs_of


def in_whole_kelvin(run: Run, *columns: str) -> Run:
    return Run(run.name, run.frame.assign(**{name: run.frame[name].round() for name in columns}))


def frozen(run: Run, column: str, start_s: float, end_s: float) -> Run:
    values = run.frame[column].copy()
    rows = (run.time_s >= start_s) & (run.time_s <= end_s)
    values[rows] = values[rows].iloc[0]
    return Run(run.name, run.frame.assign(**{column: values}))


def test_a_coarse_thermometer_that_froze_is_told_from_one_that_stands(jig_borer_lumps):
    runs = [in_whole_kelvin(run, "T1_degC", "T3_degC") for run in runs_of(jig_borer_lumps)]
    assert standing_still(jig_borer_lumps, observe(jig_borer_lumps, runs)) == []
    broken = [frozen(runs[0], "T1_degC", 240.0, 9000.0), *runs[1:]]
    (fault,) = standing_still(jig_borer_lumps, observe(jig_borer_lumps, broken))
    assert (fault.run, fault.channel, fault.kind) == ("down", "T1", "frozen")
    assert fault.start_s <= 240.0 < 9000.0 <= fault.end_s
    observed = observe(
        jig_borer_lumps, [without_bad_readings(jig_borer_lumps, run, [fault]) for run in broken]
    )
    at = observed[0].channels.index("T1")
    inside = (observed[0].time_s > 400.0) & (observed[0].time_s < 8900.0)
    assert np.isnan(observed[0].values[inside, at]).all()


def test_calibration_is_done_again_without_what_stands_still(jig_borer_lumps):
    runs = [in_whole_kelvin(run, "T1_degC") for run in runs_of(jig_borer_lumps, every_s=60.0)]
    broken = [frozen(runs[0], "T1_degC", 240.0, 9000.0), *runs[1:3]]
    found, observed, faults = calibrated(jig_borer_lumps, broken, starts=1)
    assert [fault.channel for fault in faults] == ["T1"]
    assert standing_still(found.machine, observed) == [], "it is left out"
    sound, _, none = calibrated(jig_borer_lumps, runs[:3], starts=1)
    assert none == []
    moved = [
        one.value / other.value
        for one, other in zip(found.parameters, sound.parameters, strict=True)
    ]
    assert np.abs(np.log(np.abs([ratio for ratio in moved if ratio > 0.0]))).max() < 0.2
