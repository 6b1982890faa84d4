"""A case of the benchmark that the gap finder must get right.

The runs come from a spindle of 266 cells with other laws than the lumped model has; which effect is
hidden follows from the case's number. The figures over all cases are in ``docs/gap_benchmark.md``.
"""

from benchmarks.gap.ask import runs_of
from benchmarks.gap.truth.case import simulate_case
from gap_finder.find import Judged, find_gap
from gap_finder.observations import observe
from measurement.runs import write_run
from plant_model.machine_file import read_machine
from tests.gap_benchmark.made_up import plan


def test_a_hidden_effect_is_named_and_the_gap_shrinks(tmp_path):
    number, machine = 33, read_machine("jig_borer_lumps")
    (planned,) = [one for one in plan("development", number + 1) if one.number == number]
    for run in simulate_case(planned.case)[0]:
        write_run(run.frame, tmp_path / f"{run.name}.csv")
    runs, unseen = runs_of(tmp_path)
    found = find_gap(machine, runs)
    assert found.keys == ("windage",)
    judged = Judged.of(found, observe(machine, unseen))
    assert judged.verdict == "effect"
    gap = judged.unseen.gap()
    assert gap["after"] < 0.65 * gap["before"]
