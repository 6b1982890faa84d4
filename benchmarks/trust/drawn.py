"""Compensators on machines drawn anew: four runs learnt from, the fifth judged.

The machines are those of ``benchmarks.gap`` with nothing hidden, from a split that no rule of the
compensator was set on.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from scipy.stats import gmean
from tqdm import tqdm

from benchmarks.gap.plan import trials
from benchmarks.gap.truths import TRUTHS
from benchmarks.results_page import as_table, parser_of, tell
from benchmarks.trust.judge import CHOICE, PROTOTYPE, judge
from benchmarks.trust.questions import Question
from benchmarks.trust.tables import MUCH
from measurement.files import toml_table
from measurement.rig import default_rig
from measurement.runs import Run
from plant_model.machine_file import read_machine

SPLIT = "sixteenth"
HEAD = (
    "Machine",
    "axis",
    "of none",
    f"`{PROTOTYPE}`",
    "coverage",
    f"`{PROTOTYPE}`",
    "promise kept",
)


def drawn(truth: str, each: int) -> Iterator[Question]:
    """Yield so many machines of a simulator, each with its runs."""
    shop, jig_borer = TRUTHS[truth].shop, {"rig": read_machine("jig_borer").rig}
    for (planned,) in trials(SPLIT, each, kinds=("none",), truth=truth):
        *train, judged = [Run(run.name, run.frame) for run in shop.simulate(planned.case)[0]]
        owned = shop.file_of is not None
        machine = toml_table(shop.owners_file(planned.case), truth) if owned else jig_borer
        rig = default_rig(judged, machine["rig"])
        yield Question(truth, planned.files, True, train, [judged], rig)


def table(found: Sequence[dict[str, Any]]) -> str:
    """Return what both leave by machine and axis: geometric means over the machines."""
    rows = []
    for data, axis in dict.fromkeys((one["data"], axis) for one in found for axis in one["axes"]):
        ours, theirs = (
            [one["axes"][axis] for one in found if one["data"] == data and one["model"] == model]
            for model in (CHOICE, PROTOTYPE)
        )
        kept = sum(one["rmse"] <= MUCH * one["promised"] for one in ours)
        shares = (
            f"{gmean([one['rmse'] / one['none'] for one in some]):.1%}" for some in (ours, theirs)
        )
        inside = (f"{np.mean([one['coverage'] for one in some]):.0%}" for some in (ours, theirs))
        rows.append((data, axis, *shares, *inside, f"{kept} of {len(ours)}"))
    return as_table(HEAD, rows)


def main() -> int:
    """Draw, fit, judge and print."""
    parser = parser_of(__doc__)
    parser.add_argument("--each", type=int, default=14, help="machines of each simulator")
    args = parser.parse_args()
    asked = [question for truth in TRUTHS for question in drawn(truth, args.each)]
    both = [(question, model) for question in asked for model in (CHOICE, PROTOTYPE)]
    found = [judge(question, model) for question, model in tqdm(both, disable=None)]
    tell("drawn", table(found), write=args.write)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
