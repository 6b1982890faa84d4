"""What a step costs, whatever came before it."""

from __future__ import annotations

import statistics
from pathlib import Path

from benchmarks.native_plant_steps import STEPS_S, machines, measured

MOST = 3.0
"""Times the median that a step may cost."""


def test_no_step_is_dearer_than_its_neighbours(tmp_path: Path) -> None:
    """Through changes of speed and steps without one; each cost is the least of many runs."""
    measure = measured(tmp_path / "page", machines()["page of 95"], empty=False)
    for step_s in STEPS_S:
        found = measure(step_s, 200)
        assert max(found) <= MOST * statistics.median(found), step_s
