"""What the gap is compared with."""

import numpy as np
import pytest

from gap_finder.comparison import GapComparison
from gap_finder.observations import observe
from tests.gap_finder.conftest import runs_of


def test_the_floor_is_what_the_true_machine_leaves_of_noisy_displacements(jig_borer_lumps):
    runs = [run for seed in (1, 11, 21, 31) for run in runs_of(jig_borer_lumps, seed=seed)]
    compared = GapComparison(jig_borer_lumps, jig_borer_lumps, observe(jig_borer_lumps, runs))
    table = compared.channels()
    ratios = [row["after"] / row["floor"] for row in table.values() if row["unit"] == "um"]
    assert np.sqrt(np.mean(np.square(ratios))) == pytest.approx(1.0, abs=0.25)
