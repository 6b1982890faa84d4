"""What a step costs, whatever came before it."""

from __future__ import annotations

import statistics
from pathlib import Path

from benchmarks.native_plant_steps import machines, measured

MOST = 3.0
"""Times the median that a step may cost."""


def test_no_step_is_dearer_than_its_neighbours(tmp_path: Path) -> None:
    """Through changes of speed and steps without one; each cost is the least of many runs."""
    known = machines()
    for number, label in enumerate(("24 lumps", "page of 95")):
        measure = measured(tmp_path / str(number), known[label], empty=False)
        for step_s in (0.001, 1.0, 10.0):
            found = measure(step_s, 200)
            assert max(found) <= MOST * statistics.median(found), (label, step_s)
