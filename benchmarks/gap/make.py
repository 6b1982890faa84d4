"""Writes cases as files.

``DIR/cases/NNNN/`` contains run_1.csv to run_4.csv, holdout.csv and, if the simulator has an owner,
the owner's machine file. What is hidden is only in ``DIR/answers/NNNN.json``. A case with an
existing answer file is not written again.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from benchmarks.gap.plan import Planned
from benchmarks.gap.truths import TRUTHS
from measurement.files import write_atomically
from measurement.runs import write_run

OWNERS_FILE = "machine.toml"


def case_folder(planned: Planned, out: Path) -> Path:
    """Return the folder of a case's runs."""
    return out / "cases" / planned.files


def write_case(planned: Planned, out: Path) -> Path:
    """Write one case's runs and its answer; return the answer's path."""
    answer = out / "answers" / f"{planned.files}.json"
    if answer.exists():
        return answer
    folder = case_folder(planned, out)
    folder.mkdir(parents=True, exist_ok=True)
    answer.parent.mkdir(parents=True, exist_ok=True)
    shop = TRUTHS[planned.truth].shop
    runs, effects = shop.simulate(planned.case)
    for run in runs:
        write_run(run.frame, folder / f"{run.name}.csv")
    if shop.file_of is not None:
        write_atomically(folder / OWNERS_FILE, shop.owners_file(planned.case))
    mistake = shop.mistakes.get(planned.case.mistake)
    table: dict[str, Any] = {
        "number": planned.number,
        "kind": planned.kind,
        "seed": planned.case.seed,
        "effects": [
            {
                "name": effect.name,
                "channel": effect.channel,
                "size": size,
                "amplitude": effect.size,
                "unit": effect.unit,
                "more": effect.more,
                "catalogued": effect.catalogued,
                "in_other_words": [
                    {"kind": kind, "place": list(place)} for kind, place in effect.in_other_words
                ],
            }
            for effect, (_, size, _) in zip(effects, planned.case.hidden, strict=True)
        ],
        "mistakes": []
        if mistake is None
        else [{"kind": mistake.kind, "place": list(mistake.place)}],
        "families": [run.drive.family for run in runs],
    }
    # The answer is written last: if it exists, the case is complete.
    return write_atomically(answer, json.dumps(table, indent=1) + "\n")
