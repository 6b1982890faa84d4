"""What the gap is compared with."""

import numpy as np
import pytest

from gap_finder.comparison import GapComparison
from gap_finder.observations import observe
from gap_finder.regimes import residuals
from measurement.runs import Run
from plant_model.simulate import simulate
from tests.gap_finder.conftest import inputs_of, runs_of


def test_the_floor_is_what_the_true_machine_leaves_of_noisy_displacements(jig_borer_lumps):
    runs = [run for seed in (1, 11, 21, 31) for run in runs_of(jig_borer_lumps, seed=seed)]
    compared = GapComparison(jig_borer_lumps, jig_borer_lumps, observe(jig_borer_lumps, runs))
    table = compared.channels()
    ratios = [row["after"] / row["floor"] for row in table.values() if row["unit"] == "um"]
    assert np.sqrt(np.mean(np.square(ratios))) == pytest.approx(1.0, abs=0.25)


def test_a_displacement_that_is_recorded_late_is_zeroed_there_in_the_model_too(jig_borer_lumps):
    frame = simulate(jig_borer_lumps, inputs_of("down")).run_frame()
    frame.loc[frame["time_s"] < 1800.0, "S5_um"] = np.nan
    (observed,) = observe(jig_borer_lumps, [Run("late", frame)])
    left = residuals(jig_borer_lumps, observed).values[:, observed.channels.index("S5")]
    assert np.nanmax(np.abs(left)) < 0.5
