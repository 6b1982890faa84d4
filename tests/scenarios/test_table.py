"""The headline table."""

import math

import pandas as pd

from scenarios.table import group_of


def test_a_sample_counts_only_with_drift_and_error():
    frame = pd.DataFrame(
        {
            "time_s": [0.0, 1.0],
            "drift_Z_um": [-20.0, -30.0],
            "drift_X_um": [10.0, math.nan],
            "error_X_um": [2.0, 9.0],
            "error_Z_um": [5.0, -5.0],
            "drift_Y_um": [math.nan, math.nan],
            "error_Y_um": [1.0, 1.0],
        }
    )
    reference, row = group_of("", [("run", "Compensated", frame)]).rows
    assert list(row.axes) == ["X", "Y", "Z"]
    assert row.axes["X"].to_dict() == {
        "before_max_um": 10.0,
        "before_mean_um": 10.0,
        "after_max_um": 2.0,
        "after_mean_um": 2.0,
        "improvement_percent": 80.0,
        "samples": 1,
    }
    z = row.axes["Z"]
    assert (z.before_max_um, z.before_mean_um, z.after_max_um) == (30.0, 25.0, 5.0)
    assert z.improvement_percent == 80.0
    assert set(row.axes["Y"].to_dict().values()) == {None, 0}
    assert reference.axes["Z"].improvement_percent == 0.0
