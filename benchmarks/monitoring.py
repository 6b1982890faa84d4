"""How often `monitor` raises a false alarm, and how often it finds simulated faults.

    python -m benchmarks.monitoring DATA [--model gaussian] [--write]

DATA is the folder with ``lathe/`` and ``electric_spindle/``; a missing one is left out. Each
compensator is fitted to the training runs of a split; the left-out runs are then its log, with one
report per split. Runs like the training test for false alarms; in copies of them a thermometer
drifts, or the machine moves by another factor. Runs unlike the training show the verdicts on other
conditions and machines.
"""

from __future__ import annotations

import zlib
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path

import numpy as np
from tqdm import tqdm

from benchmarks.results_page import as_table, parser_of, tell
from benchmarks.trust.questions import Question, fitted, questions
from fmu_compensator.fit.conditions import FOLDS
from fmu_compensator.monitoring import Report, monitor
from fmu_compensator.monitoring.monitor import DOUBTFUL, LEARNT, SENSOR, VERDICTS
from fmu_compensator.runtime.modelfile import Model
from measurement.runs import Run

WANDERS_K = (2.0, 5.0, 10.0)
MOVES = (0.7, 1.3, 1.6)
TOLD = tuple(verdict for verdict in VERDICTS if verdict not in (LEARNT, DOUBTFUL))
"""Verdicts on a left-out run."""


@dataclass(frozen=True)
class Answer:
    """A split, and the results of monitoring its log."""

    question: Question
    report: Report
    wanders: dict[float, tuple[int, int, int]]
    moves: dict[float, str]


def logs(folder: Path) -> Iterator[Question]:
    """Yield splits like the training, each run judged once, then splits unlike the training."""
    for data, some in groupby(questions(folder), key=lambda one: one.data):
        group = list(some)
        like = [one for one in group if not one.unlike]
        if data == "lathe":
            every = sorted([*like[0].train, *like[0].judged], key=lambda run: run.name)
            for first in range(FOLDS):
                judged = every[first::FOLDS]
                yield replace(
                    like[0],
                    name=f"every fifth run, from number {first + 1}",
                    judged=judged,
                    train=[run for run in every if run not in judged],
                )
        else:
            yield from like
        yield from (one for one in group if one.unlike)


def ask(question: Question, kind: str) -> Answer:
    """Fit a model and monitor the log, as it is and with simulated faults."""
    model = fitted(question, kind)
    report = monitor(model, question.judged, question.rig)
    if question.unlike:
        return Answer(question, report, {}, {})
    quiet = [
        run
        for run, told in zip(question.judged, report.runs, strict=True)
        if told.verdict != SENSOR
    ]
    return Answer(
        question,
        report,
        {size: _found(model, quiet, question, size) for size in WANDERS_K},
        {
            factor: monitor(model, [_moved(run, question, factor) for run in quiet]).verdict
            for factor in MOVES
        },
    )


def _found(
    model: Model, runs: Sequence[Run], question: Question, size: float
) -> tuple[int, int, int]:
    """Return in how many runs a drifting thermometer is found, named correctly, and misnamed."""
    names = [model.sensors[index].name for index in model.chosen]
    wandering, astray = [], []
    for run in runs:
        random = np.random.default_rng(zlib.crc32(f"{run.name} {size}".encode()))
        name = str(random.choice(names))
        frame = run.frame.copy()
        hours = (run.time_s - run.time_s[0]) / (run.time_s[-1] - run.time_s[0])
        frame[f"{name}_degC"] += size * random.choice([-1.0, 1.0]) * hours
        wandering.append(Run(run.name, frame))
        astray.append(name)
    told = monitor(model, wandering, question.rig).runs if wandering else ()
    found = [one.verdict == SENSOR for one in told]
    right = [
        one.verdict == SENSOR and one.sensor == name for one, name in zip(told, astray, strict=True)
    ]
    return sum(found), sum(right), sum(found) - sum(right)


def _moved(run: Run, question: Question, factor: float) -> Run:
    """Return the run with all displacements scaled by a factor."""
    frame = run.frame.copy()
    for name in question.rig.columns:
        first = frame[name].dropna().iloc[0]
        frame[name] = first + factor * (frame[name] - first)
    return Run(f"{run.name}, moves {factor:g} times", frame)


def page(answers: Sequence[Answer]) -> str:
    """Return the tables."""
    reports = []
    for one in answers:
        counts = Counter(run.verdict for run in one.report.runs)
        kind = "unlike" if one.question.unlike else "like"
        head = [one.question.data, one.question.name, kind, str(len(one.report.runs))]
        reports.append([*head, *(str(counts[name] or "") for name in TOLD), one.report.verdict])
    like = [one for one in answers if not one.question.unlike]
    wandered = []
    for data in dict.fromkeys(one.question.data for one in like):
        here = [one for one in like if one.question.data == data]
        count = sum(run.verdict != SENSOR for one in here for run in one.report.runs)
        for size in WANDERS_K:
            sums = np.sum([one.wanders[size] for one in here], axis=0)
            cells = [str(int(value)) for value in sums]
            wandered.append([data, f"{size:g} K", str(count), *cells])
    moved = [[one.question.data, one.question.name, *one.moves.values()] for one in like]
    return "\n\n".join(
        [
            "Reports on runs left out, one log a split; a count for each verdict on a run:",
            as_table(["Data", "Log", "", "runs", *TOLD, "the log"], reports),
            "Planted in the like runs in which no thermometer was called wrong. A thermometer in "
            "use, drawn at random, wanders evenly to so many kelvin by the run's end:",
            as_table(
                ["Data", "wanders by", "runs", "found", "the right one", "a wrong one"], wandered
            ),
            "And the machine moves so many times as far as it did, in every run of the log:",
            as_table(["Data", "Log", *(f"{factor:g} times" for factor in MOVES)], moved),
        ]
    )


def main() -> int:
    """Run the benchmark, print the tables, and optionally write them into the page."""
    parser = parser_of(__doc__)
    parser.add_argument("folder", type=Path, metavar="DATA")
    parser.add_argument("--model", default="gaussian")
    args = parser.parse_args()
    todo = list(logs(args.folder))
    answers = [ask(question, args.model) for question in tqdm(todo, disable=None)]
    tell("monitoring", page(answers), write=args.write)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
