"""Error models on thirty measured runs of a lathe, each predicted from the other 29.

    python -m benchmarks.lathe DATA [--models mlr,thermal_states] [--jobs 2] [--write]

DATA holds the run files. Two protocols:

- *unseen run*: none of the run's displacement is known;
- *first 100 given*: the first 100 samples of the run's displacement are known, the rest is judged.

Choices within a model (points, lags, penalties) are made again for each left-out run, from the
other 29 only. Frozen and saturated displacement is left out of fitting and judging.
"""

from __future__ import annotations

from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from benchmarks.learning import learnt
from benchmarks.results_page import as_table, parser_of, tell
from benchmarks.trust.questions import lathe_runs
from fmu_compensator.fit.columns import targets_of
from fmu_compensator.fit.contestants import contestants, held
from fmu_compensator.fit.data import prepare
from fmu_compensator.fit.training import TrainingRun
from measurement.faults import faults_text, find_faults, looked_over
from measurement.resampling import SLOW_S
from measurement.runs import Run
from measurement.workers import workers
from studies.fit.by_run import Block, NormalEquations
from studies.fit.lagged import thinned

GIVEN = 100
PLAIN = "plain_ridge"
"""The reference: ridge regression on the rises of all temperatures, without memory, on the same
cleaned runs and splits."""
PENALTIES = tuple(10.0**power for power in range(-6, 1))
BASELINES = ("no_model", "persistence", PLAIN)


@cache
def runs_in(folder: Path) -> tuple[Run, ...]:
    """Return the folder's runs in the order of their names, which are dates."""
    return tuple(looked_over(lathe_runs(folder)))


def judge(folder: Path, name: str, index: int) -> dict[str, Any]:
    """Return the errors of one model on one left-out run, under both protocols [um]."""
    runs = runs_in(folder)
    recipe = contestants([name])[-1].recipe if name not in BASELINES else None
    others = runs[:index] + runs[index + 1 :]
    train, [unseen], fitted, chosen = learnt(recipe, others, [runs[index]], targets_of(runs, None))
    if name == PLAIN:
        chosen = list(train.candidates)
        fitted = PlainRidge([run.complete(chosen) for run in train.runs])
    rows = recipe.rows(unseen, chosen) if recipe else unseen.history(chosen)
    known = np.flatnonzero(rows.known)
    given = np.full_like(rows.targets, np.nan)
    given[known[:GIVEN]] = rows.targets[known[:GIVEN]]
    if fitted is None:
        free = np.zeros_like(rows.targets)
        informed = held(rows, given) if name == "persistence" else free
    else:
        free = fitted.predict(rows)
        informed = informed_prediction(fitted, rows, given, free, known)
    rest = known[GIVEN:]
    return {
        "run": runs[index].name,
        "unseen": _rmse(rows.targets[known] - free[known]),
        "first_100_given": _rmse(rows.targets[rest] - informed[rest]),
    }


def informed_prediction(fitted: Any, rows: Any, given: Any, free: Any, known: Any) -> Any:
    """Return a model's prediction given the first samples of the drift.

    A model that cannot use measurements is shifted by its mean residual at the last given samples.
    """
    if fitted.uses_measured:
        return fitted.predict(rows, given)
    last = known[: min(GIVEN, len(known))][-10:]
    return free + np.mean(rows.targets[last] - free[last], axis=0)


class PlainRidge:
    """Ridge regression on the present temperatures, with its penalty chosen on left-out runs."""

    uses_measured = False

    def __init__(self, runs: list[TrainingRun]) -> None:
        kept = [thinned(run, SLOW_S) for run in runs]
        blocks = [
            Block(run.time_s[rows] / 3600.0, run.inputs[rows], run.targets[rows])
            for run, rows in zip(runs, kept, strict=True)
        ]
        problem = NormalEquations(blocks, 0.0)
        columns = []
        for target in range(runs[0].targets.shape[1]):
            tried = [problem.solve(target, penalty, robust=False) for penalty in PENALTIES]
            columns.append(min(tried, key=lambda one: one.score).coefficients)
        self._coefficients = np.column_stack(columns)

    def predict(self, run: TrainingRun, measured: Any = None) -> Any:
        """Return the targets predicted for a run, shape (n, m) [um]."""
        return run.inputs @ self._coefficients


def _rmse(missed: Any) -> list[float]:
    return np.sqrt(np.mean(missed**2, axis=0)).tolist()


def main() -> int:
    """Run the benchmark and print its table."""
    parser = parser_of(__doc__)
    parser.add_argument("data", type=Path, help="folder of the run files")
    parser.add_argument("--models", default="mlr,arx,ne,bp,thermal_states")
    parser.add_argument("--jobs", type=int, default=2, help="processes (default: 2)")
    args = parser.parse_args()
    runs = runs_in(args.data)
    if len(runs) < 2:
        print(f"{args.data}: holds {len(runs)} runs named by date; two or more are needed")
        return 2
    print(f"{len(runs)} runs. What is wrong with them:\n{faults_text(find_faults(runs))}\n")
    names = prepare(runs[:1], targets_of(runs, None)).targets
    targets = [name.removeprefix("disp_").upper() for name in names]
    heads = [f"{name} {kind}" for name in targets for kind in ("unseen", "100 given")]
    rows = []
    with workers(args.jobs) as pool:
        for name in [*BASELINES, *args.models.split(",")]:
            work = pool.map(partial(judge, args.data, name), range(len(runs)))
            found = list(tqdm(work, total=len(runs), desc=name, disable=None, leave=False))
            rows.append(_row(name, found, len(targets)))
    print("Median RMSE over the left-out runs [um]\n")
    tell("lathe", as_table(["Model", *heads, "both, 100 given"], rows), write=args.write)
    return 0


def _row(name: str, found: list[dict[str, Any]], targets: int) -> list[str]:
    unseen = np.median([one["unseen"] for one in found], axis=0)
    given = np.array([one["first_100_given"] for one in found])
    # The competition's figure is one RMSE over both axes.
    both = float(np.median(np.sqrt(np.mean(given**2, axis=1))))
    middle = np.median(given, axis=0)
    cells = [f"{figure:.2f}" for k in range(targets) for figure in (unseen[k], middle[k])]
    return [f"`{name}`", *cells, f"{both:.2f}"]


if __name__ == "__main__":
    raise SystemExit(main())
