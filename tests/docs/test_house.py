"""The counter of the house, on files whose counts are known."""

from __future__ import annotations

from benchmarks.house import walked
from measurement.errors import shown


def test_a_walk_counts_the_functions_of_this_project_that_run() -> None:
    assert walked(lambda: shown("text")) == (1, 1)
