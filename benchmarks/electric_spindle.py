"""Error models on one long record of an electric spindle, fitted to its first half only.

    python -m benchmarks.electric_spindle RECORD.csv [--models mlr,arx] [--write]

Every model runs freely from the start of the record; only the second half is judged. One-step-ahead
rows are given the growth measured one sample before: they show how slowly the growth changes, not
how good a model is.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.learning import learnt
from benchmarks.results_page import as_table, parser_of, tell
from fmu_compensator.fit.columns import targets_of
from fmu_compensator.fit.contestants import PERSISTENCE, contestants, held
from measurement.errors import BadInput
from measurement.figures import figures_of_merit
from measurement.runs import Run, read_run

MODELS = "mlr,arx,bp,ga_bp,thermal_states,vac,arma"


def main() -> int:
    """Run the benchmark and print its table."""
    parser = parser_of(__doc__)
    parser.add_argument("record", type=Path)
    parser.add_argument("--models", default=MODELS)
    args = parser.parse_args()
    whole = read_run(args.record)
    cut = len(whole.frame) // 2
    first = Run(f"{whole.name}_first_part", whole.frame.iloc[:cut])
    print(f"{cut} of {len(whole.frame)} samples learnt from, the rest judged [um]")
    rows: list[list[str]] = []
    for entrant in contestants(args.models.split(",")):
        try:
            rows += _judge(entrant, first, whole, cut)
        except BadInput as refusal:
            rows.append([entrant.title, f"left out: {refusal}", "", ""])
    tell("electric_spindle", as_table(["Model", "RMSE", "max", "eta [%]"], rows), write=args.write)
    return 0


def _judge(entrant: Any, first: Run, whole: Run, cut: int) -> Iterator[list[str]]:
    rig = targets_of([whole], None)
    _, [record], fitted, chosen = learnt(entrant.recipe, [first], [whole], rig)
    rows = record.history(chosen)
    predict = partial(held, rows) if fitted is None else partial(fitted.predict, rows)
    yield _row(entrant.title, rows, predict(None), cut)
    if entrant.name == PERSISTENCE if fitted is None else fitted.uses_measured:
        yield _row(entrant.title + ", one step", rows, predict(rows.targets), cut)


def _row(title: str, rows: Any, predicted: Any, cut: int) -> list[str]:
    judged = rows.known & (np.arange(len(rows.time_s)) >= cut)
    figures = figures_of_merit(rows.targets[judged, 0], predicted[judged, 0])
    cells = (f"{figures['rmse']:.2f}", f"{figures['max_abs']:.2f}", f"{100 * figures['eta']:.1f}")
    return [title, *cells]


if __name__ == "__main__":
    raise SystemExit(main())
