"""A fixed few of the benchmark's cases, which the gap finder must get right.

The runs come from a spindle of 266 cells with other laws than the lumped model has; which effect is
hidden follows from the case's number. The figures over all cases are in ``docs/gap_benchmark.md``.
"""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.gap.ask import runs_of
from benchmarks.gap.truth.case import simulate_case
from gap_finder.find import Judged, find_gap
from gap_finder.observations import observe
from gap_finder.search import Search
from measurement.runs import Run, write_run
from plant_model.effects import catalogue
from plant_model.machine import Machine
from plant_model.machine_file import read_machine
from tests.gap_benchmark.made_up import plan

KNOWN = ("centrifugal_shift", "column_bending", "slow_structure", "windage", "sensor_drift")
OTHERS = [name for name in catalogue() if name not in KNOWN]


@pytest.fixture
def jig_borer_lumps() -> Machine:
    """The machine file that the cases are asked with."""
    return read_machine("jig_borer_lumps")


def _runs(number: int, folder: Path) -> tuple[list[Run], list[Run]]:
    """Return the runs of a case of the development split as files give them."""
    (planned,) = [one for one in plan("development", number + 1) if one.number == number]
    for run in simulate_case(planned.case)[0]:
        write_run(run.frame, folder / f"{run.name}.csv")
    return runs_of(folder)


@pytest.mark.long
def test_a_hidden_effect_is_named_and_the_gap_shrinks(jig_borer_lumps, tmp_path):
    runs, unseen = _runs(33, tmp_path)
    found = find_gap(jig_borer_lumps, runs)
    assert found.keys == ("windage",)
    judged = Judged.of(found, observe(jig_borer_lumps, unseen))
    assert judged.verdict == "effect"
    gap = judged.unseen.gap()
    assert gap["after"] < 0.65 * gap["before"]


@pytest.mark.long
def test_the_answer_stays_when_rows_are_dropped_and_runs_are_swapped(jig_borer_lumps, tmp_path):
    runs, _ = _runs(22, tmp_path)
    generator = np.random.default_rng(5)
    thinned = []
    for run in reversed(runs):
        kept = generator.random(len(run.frame)) > 0.1
        kept[0] = True
        thinned.append(Run(run.name, run.frame[kept].reset_index(drop=True)))
    found = find_gap(jig_borer_lumps, thinned, Search(OTHERS))
    assert found.keys == ("centrifugal_shift",)
