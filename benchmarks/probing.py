"""How much probe cycles help: error against probes per run, on unseen runs.

    python -m benchmarks.probing DATA [--model gaussian] [--write]

DATA holds ``lathe`` and ``electric_spindle``. A compensator is fitted to some runs and driven
through the others; at a probe it is given the run's own measured drift, with 0.5 um of noise. It is
compared with no compensation, the compensator without probes, and holding the last probe without
any model. Nothing is fitted or chosen on the judged runs; a limit comes from the uncertainty in the
*training* runs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from benchmarks.results_page import as_table, parser_of, tell
from benchmarks.trust.questions import (
    NO_SLEW,
    RECORD,
    Question,
    electric_questions,
    fitted,
    lathe_questions,
)
from fmu_compensator.runtime.compensator import WAITING, RunningCompensator
from fmu_compensator.runtime.modelfile import Model
from measurement.drift import measured_drift
from measurement.faults import GROSS, cleaned, find_faults
from measurement.rig import Rig
from measurement.runs import Run
from scenarios.probing import ProbedRun, Probing

STEP_S = 60.0
"""Rows closer together than this are left out, because the step length is not judged here [s]."""
COUNTS = (1, 2, 4, 8)
WHEN = 0.65
"""Limit, relative to the mean half width in the training runs [1]."""
TITLES = {
    "August to October, from June and July": "lathe, August to October, from June and July",
    "June and July, from the rest": "lathe, June and July, from August to October",
    "the second half": "electric spindle, second half, from the first",
    "the first half": "electric spindle, first half, from the second",
}
"""The splits used, and their names on the page."""


@dataclass(frozen=True)
class Driven:
    """The result of one run.

    Attributes
    ----------
    probes : int
    widest : float
        Mean half width of the widest axis [um].
    figures : dict
        By axis: RMSE without compensation, with it, and of the last probe held [um]; share of
        samples in the interval [1].
    """

    probes: int
    widest: float
    figures: dict[str, tuple[float, float, float, float]]


def table_of(split: Question, kind: str) -> str:
    """Return a split's table in Markdown, with a line for each way to probe."""
    model = fitted(split, kind, limits=NO_SLEW)
    plain = Probing(most=0)
    judged, train = (_judgeable(runs) for runs in (split.judged, split.train))
    judged = [run for run in judged if driven(run, split.rig, model, plain)]
    shortest = min(float(run.time_s[-1] - run.time_s[0]) for run in judged)
    ways = {"no compensation": plain, "no probe": plain}
    for count in COUNTS:
        name = f"{count} at fixed intervals of {shortest / 60 / (count + 1):.0f} min"
        ways[name] = Probing(every_s=shortest / (count + 1), most=count)
    learnt = [driven(run, split.rig, model, plain) for run in train]
    usual = np.mean([one.widest if one else 0.0 for one in learnt])
    limit = float(f"{WHEN * usual:.2g}")
    ways[f"when past {limit:g} um, at most 4"] = Probing(when_um=limit, most=4)
    ways[f"when past {limit:g} um"] = Probing(when_um=limit)
    rows, axes = [], ""
    for way, probing in ways.items():
        found = [one for run in judged if (one := driven(run, split.rig, model, probing))]
        axes = "".join(found[0].figures)
        cells = [way, f"{np.mean([one.probes for one in found]):.1f}"]
        for axis in axes:
            none, error, held, inside = np.array([one.figures[axis] for one in found]).T
            bare = way == "no compensation"
            cells.append(f"{np.median(none if bare else error):.1f}")
            cells.append("" if probing is plain else f"{np.median(held):.1f}")
            cells.append("" if bare else f"{100 * np.mean(inside):.0f} %")
        rows.append(cells)
    head = ["", "probes a run"]
    head += [f"{axis}{what}" for axis in axes for what in (" [µm]", " held [µm]", " inside")]
    title = f"### {split.name[0].upper()}{split.name[1:]}"
    count = f"`{kind}`, {len(split.train)} runs learnt from, {len(split.judged)} judged."
    return f"{title}\n\n{count}\n\n{as_table(head, rows)}\n"


def _judgeable(runs: Sequence[Run]) -> list[Run]:
    """Return the runs with one row per minute, without broken displacements."""
    found = cleaned(runs, find_faults(runs), GROSS)
    thinned = []
    for shown, whole in zip(found, runs, strict=True):
        kept, last = [], -np.inf
        for row, time in enumerate(whole.time_s):
            if time - last >= STEP_S * 0.99:
                kept.append(row)
                last = time
        temperatures = {name: whole.frame[name] for name in whole.temperatures}
        frame = shown.frame.assign(**temperatures).iloc[kept].reset_index(drop=True)
        thinned.append(Run(whole.name, frame))
    return thinned


def driven(run: Run, rig: Rig, model: Model, probing: Probing) -> Driven | None:
    """Drive a compensator through a run with probes; return None if it does not start."""
    compensator, probed = RunningCompensator(model), ProbedRun(probing, model, run, rig, 0.0)
    readings = run.frame[[f"{sensor.name}_degC" for sensor in model.sensors]].to_numpy(float)
    speed = run.frame["speed_rpm"].to_numpy(float) if "speed_rpm" in run.frame else None
    offsets, widths = np.zeros((len(readings), 3)), np.full((len(readings), 3), -1.0)
    started = np.zeros(len(readings), dtype=bool)
    time_s = run.time_s
    for k in range(len(readings) - 1):
        measured = probed.targets[k].tolist() if probed.due(k, widths[k].tolist()) else None
        output = compensator.step(
            time_s[k],
            time_s[k + 1] - time_s[k],
            readings[k].tolist(),
            np.nan if speed is None else speed[k],
            0.0,
            measured,
        )
        offsets[k + 1], widths[k + 1] = output[:3], output[6:9]
        started[k + 1] = output.status != WAITING
    if not started.any():
        return None
    figures, widest = {}, 0.0
    for name, drift in measured_drift(run, rig, 0.0, model.input_form).items():
        axis = str(name)[6]
        at = "XYZ".index(axis)
        error = np.where(started, drift + offsets[:, at], np.nan)
        held = np.where(started, drift - probed.held(axis), np.nan)
        known = np.isfinite(error)
        inside = float(np.mean(np.abs(error[known]) <= widths[known, at]))
        figures[axis] = (_rms(drift.to_numpy()), _rms(error), _rms(held), inside)
        widest = max(widest, float(np.mean(widths[started, at])))
    return Driven(len(probed.rows), widest, figures)


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.nanmean(values**2)))


def main() -> int:
    """Run the benchmark, print its tables, and optionally write them into the page."""
    parser = parser_of(__doc__)
    parser.add_argument("data", type=Path)
    parser.add_argument("--model", default="gaussian")
    args = parser.parse_args()
    splits = (*lathe_questions(args.data / "lathe"), *electric_questions(args.data / RECORD))
    texts = [
        table_of(replace(one, name=TITLES[one.name]), args.model)
        for one in splits
        if one.name in TITLES
    ]
    if not texts:
        print(f"{args.data}: holds neither lathe nor electric_spindle")
        return 2
    tell("probing", "\n".join(texts), write=args.write)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
