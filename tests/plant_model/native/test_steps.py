"""What a step costs, whatever came before it."""

import pytest

from benchmarks.native_plant_steps import MOST_TIMES_MEDIAN, STEPS_S, machines, measured

IN_PARTS_S = 10.0
"""So long a step is split after a change of speed, where an effect depends on temperature."""


@pytest.mark.long
@pytest.mark.parametrize("label", ["24 lumps", "page of 95", "page of 95, 3 effects"])
def test_no_step_is_dearer_than_its_neighbours(label, tmp_path):
    """Through changes of speed and steps without one; each cost is the least of many runs."""
    measure = measured(tmp_path / "page", machines()[label], empty=False)
    for step_s in STEPS_S:
        if step_s < IN_PARTS_S or "effects" not in label:
            assert measure(step_s, 200).times_median <= MOST_TIMES_MEDIAN, step_s
