"""The error after a sensor breaks, with its likely reading substituted, and with hold and fade.

    python -m benchmarks.broken_sensor [--lathe DATA] [--write]

The jig borer: the shipped compensator, on an unseen simulated run. Each of its sensors breaks in
turn, after two hours and permanently, in three ways. The lathe: a compensator fitted to the runs of
June and July, on the later runs in which the thermometer PT10 really jumps. All errors are counted
from the fault on.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from benchmarks.results_page import as_table, parser_of, tell
from benchmarks.trust.questions import Question, fitted, lathe_runs, simulated
from fmu_compensator.driving import drive
from fmu_compensator.fit.data import prepare
from fmu_compensator.fit.training import Array
from fmu_compensator.runtime.compensator import SPARED
from fmu_compensator.runtime.modelfile import Model, load_model
from measurement.rig import Rig, default_rig, rig_from_table
from measurement.runs import Run
from plant_model.machine_file import read_machine

SHIPPED = Path(__file__).resolve().parents[1] / "fmu_compensator" / "library" / "jig_borer.json"
TOOL_MM = 100.0
BREAKS_S = 7200.0
LEARNT = "202008"
LATHE_MODEL = "gaussian"
"""The model for `fit`; it uses all sensors."""
HEAD = (
    *("Run and fault", "Axis", "None", "All good"),
    *("Going on", "Hold and fade", "Within", "Status 4"),
)
FAULTS: dict[str, Callable[[Array], Array]] = {
    "missing": lambda values: np.full(len(values), np.nan),
    "stuck": lambda values: np.full(len(values), values[0]),
    "30 K off": lambda values: values + 30.0,
}


@dataclass(frozen=True)
class Judged:
    """The remaining error of a run, from the fault on.

    Attributes
    ----------
    error, drift : array (n, axes)
        The error with and without the compensator [um].
    half_width : array (n, axes)
        Half width of the stated interval [um].
    spared : array (n,)
        Whether the status is 4.
    """

    error: Array
    drift: Array
    half_width: Array
    spared: Array

    def rmse(self, axis: int) -> float:
        """Return the root mean square error along an axis [um]."""
        return float(np.sqrt(np.mean(self.error[:, axis] ** 2)))


def without_spare(model: Model) -> Model:
    """Return the same compensator without a substitute for a broken sensor."""
    return replace(model, table={**model.table, "spare": None})


def judge(model: Model, shown: Run, run: Run, rig: Rig, counts: Array) -> Judged:
    """Return the remaining error of a run, when the compensator reads the sensors of *shown*.

    *counts* selects rows; of these, only rows with known drift are judged.
    """
    driven = drive(model, shown, run, rig, TOOL_MM)
    axes = np.isfinite(driven.drift).any(axis=0)
    use = counts[np.isin(run.time_s, driven.time_s)]
    use &= np.isfinite(driven.drift[:, axes]).all(axis=1)
    drift, error, width = (
        values[use][:, axes]
        for values in (driven.drift, driven.drift - driven.predicted, driven.half_width)
    )
    return Judged(error, drift, width, (driven.status == SPARED)[use])


def broken(run: Run, column: str, fault: str, after_s: float = BREAKS_S) -> Run:
    """Return the run with the readings of a sensor that breaks."""
    late = run.time_s >= after_s
    values = run.frame[column].to_numpy(float, copy=True)
    values[late] = FAULTS[fault](values[late])
    return Run(run.name, run.frame.assign(**{column: values}))


def jig_borer() -> tuple[Model, Run, Rig]:
    """Return the shipped compensator, an unseen run and the rig."""
    rig = rig_from_table(read_machine("jig_borer").rig, "rig")
    return load_model(SHIPPED), simulated("step_speed", of="jig_borer"), rig


def jig_borer_rows() -> Iterator[list[str]]:
    """Yield the table's rows: each sensor breaks in turn."""
    model, run, rig = jig_borer()
    plain, late = without_spare(model), run.time_s >= BREAKS_S
    good = judge(model, run, run, rig, late)
    for fault in FAULTS:
        columns = [f"{model.sensors[place].name}_degC" for place in model.chosen]
        faulty = [broken(run, column, fault) for column in columns]
        on = [judge(model, shown, run, rig, late) for shown in faulty]
        held = [judge(plain, shown, run, rig, late) for shown in faulty]
        for number, axis in enumerate("XYZ"):
            name = f"jig borer, one of {len(faulty)} {fault}"
            yield _row(name, axis, number, [good], on, held)


def lathe_rows(folder: Path) -> Iterator[list[str]]:
    """Yield the table's rows: the real fault on the lathe, in unseen runs."""
    runs = lathe_runs(folder)
    rig = default_rig(runs[0], read_machine("jig_borer").rig)
    train, judged = (
        [run for run in runs if (run.name >= LEARNT) is late] for late in (False, True)
    )
    split = Question("lathe", LATHE_MODEL, True, train, judged, rig)
    model = fitted(split, LATHE_MODEL, points="all")
    for run in judged:
        usable = prepare([run], rig).runs[0].usable
        on, held = (judge(one, run, run, rig, usable) for one in (model, without_spare(model)))
        if on.spared.any():
            for number, axis in enumerate("XZ"):
                yield _row(f"lathe, {run.name}", axis, number, [], [on], [held])


def _row(
    name: str,
    axis: str,
    number: int,
    good: Sequence[Judged],
    on: Sequence[Judged],
    held: Sequence[Judged],
) -> list[str]:
    none = float(np.sqrt(np.mean(on[0].drift[:, number] ** 2)))
    within = np.mean(
        [np.mean(np.abs(one.error[:, number]) <= one.half_width[:, number]) for one in on]
    )
    spared = np.mean([np.mean(one.spared) for one in on])
    errors = [_worst(judged, number) for judged in (good, on, held)]
    return [name, axis, f"{none:.2f}", *errors, f"{within:.0%}", f"{spared:.0%}"]


def _worst(judged: Sequence[Judged], axis: int) -> str:
    """Return the median RMSE, followed by the largest in brackets if there are several [um]."""
    errors = [one.rmse(axis) for one in judged]
    if not errors:
        return ""
    if len(errors) == 1 or math.isclose(min(errors), max(errors)):
        return f"{errors[0]:.2f}"
    return f"{np.median(errors):.2f} ({max(errors):.2f})"


def main() -> None:
    """Print the table, and optionally write it into the page."""
    parser = parser_of(__doc__)
    parser.add_argument("--lathe", type=Path, help="folder of the lathe's run files")
    args = parser.parse_args()
    rows = [*jig_borer_rows(), *(lathe_rows(args.lathe) if args.lathe else ())]
    tell("broken_sensor", as_table(HEAD, rows), write=args.write)


if __name__ == "__main__":
    main()
