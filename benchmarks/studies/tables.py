"""The tables of docs/studies.md, made of scores."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

from benchmarks.studies.entrants import ENTRANTS, TRUTH
from benchmarks.studies.judge import TOOLS_MM, Score
from benchmarks.studies.machines import truth
from benchmarks.studies.published import AXIAL, BEST, COMPENSATED, FIT, UNSEEN

NAMES = {
    "fit": "fit",
    "repeated": "spectrum repeated",
    "like": "unseen, like coolant",
    "unlike": "unseen, other coolant and hall",
}
UNSEEN_PROTOCOLS = ("repeated", "like", "unlike")
NEAR_END = 1.01
"""A training has converged where its error is within this factor of its last one [1]."""
OWN_CHOICE = "bayes"
"""What ``spindle-drift fit`` takes from a single run."""
NETWORKS = (
    "bp_study",
    "ga_bp_study",
    "ga_bp_nodes",
    "ga_bp_nodes_training",
    "bp_four",
    "ga_bp_four",
)
ELEMENTS = Path(__file__).with_name("elements.csv")
TARGETS, AXES = ("E", "yaw", "pitch"), ("X", "Y", "Z")

Scores = Mapping[tuple[str, str, str], Sequence[Score]]
"""By machine, model and protocol; one a seed."""


def by_place(scores: Iterable[Score]) -> dict[tuple[str, str, str], list[Score]]:
    """Return scores by machine, model and protocol, in the order of the seeds."""
    found: dict[tuple[str, str, str], list[Score]] = {}
    for score in sorted(scores, key=lambda one: one.seed):
        found.setdefault((score.machine, score.model, score.protocol), []).append(score)
    return found


def etas(scores: Sequence[Score]) -> np.ndarray:
    """Return predictive abilities, a row a seed [%]."""
    return np.array([score.eta for score in scores])


def gains(scores: Sequence[Score], tool_mm: float = TOOLS_MM[0]) -> np.ndarray:
    """Return what is better along X, Y and Z, a row a seed [%]."""
    return np.array([score.better[tool_mm] for score in scores])


def prediction_table(scores: Scores, machine: str) -> str:
    """Return the predictive ability of every model under every protocol: mean (worst seed)."""
    rows = []
    for name, entrant in ENTRANTS.items():
        if (machine, name, "fit") not in scores:
            continue
        cells = [
            _cell(etas(scores[machine, name, protocol])) for protocol in ("fit", *UNSEEN_PROTOCOLS)
        ]
        study = [_plain(FIT.get(name, ())), _plain(UNSEEN.get(name, ()))]
        rows.append([entrant.title, *cells, *study])
    one = next(iter(scores[machine, TRUTH, "fit"]))
    head = " / ".join(TARGETS[: len(one.eta)])
    if len(one.eta) == 1:
        rows = [row[:-2] for row in rows]
        return as_table([f"eta of {head} [%]", *NAMES.values()], rows)
    return as_table([f"eta of {head} [%]", *NAMES.values(), "study, fit", "study, unseen"], rows)


def compensation_table(scores: Scores, machine: str) -> str:
    """Return what compensation takes off the drift: mean (worst seed), X / Y / Z."""
    rows = []
    for name, entrant in ENTRANTS.items():
        if name == "no_model" or (machine, name, "fit") not in scores:
            continue
        cells = [_cell(gains(scores[machine, name, protocol])) for protocol in UNSEEN_PROTOCOLS]
        like = scores[machine, name, "like"]
        axial = np.mean([score.axial_um for score in like], axis=0)
        rows.append(
            [
                entrant.title,
                *cells,
                _plain(tuple(gains(like, TOOLS_MM[1]).mean(axis=0))),
                "{:.1f} to {:.1f}, {:.1f} to {:.1f}".format(*axial),
                _plain(COMPENSATED.get(name, ("", ()))[1]),
                AXIAL.get(name, ""),
            ]
        )
    protocols = [NAMES[protocol] for protocol in UNSEEN_PROTOCOLS]
    tool, axial_head = f"like coolant, tool {TOOLS_MM[1]:g} mm", "axial max, mean [um]"
    head = ["X / Y / Z better by [%]", *protocols, tool, f"like coolant, {axial_head}"]
    return as_table([*head, "study", f"study, {axial_head}"], rows)


def goal_table(scores: Scores, machines: Sequence[str]) -> str:
    """Return in how many seeds a temperature model beats the best of the studies in all axes."""
    rows = []
    for name, entrant in ENTRANTS.items():
        there = all((machine, name, "fit") in scores for machine in machines)
        if not entrant.by_temperature or not there:
            continue
        cells = []
        for machine in machines:
            for protocol in UNSEEN_PROTOCOLS:
                won = (gains(scores[machine, name, protocol]) >= BEST).all(axis=1)
                cells.append(f"{won.sum()} of {len(won)}")
        rows.append([entrant.title, *cells])
    heads = [f"{truth(m).title}: {NAMES[p]}" for m in machines for p in UNSEEN_PROTOCOLS]
    return as_table(["model", *heads], rows)


def cells_table(scores: Scores, machine: str) -> str:
    """Return every cell of the studies' tables: theirs, ours, the ceiling, and what stands between.

    Ours is the mean over the seeds and the worst of them in brackets.
    """
    rows = []
    for name in FIT:
        rows += _cells(scores, machine, name, "fit of", FIT[name], TARGETS, ("fit",), etas)
        rows += _cells(
            scores, machine, name, "unseen", UNSEEN[name], TARGETS, UNSEEN_PROTOCOLS, etas
        )
    for name, (study, theirs) in COMPENSATED.items():
        what = f"compensated ({study})"
        rows += _cells(scores, machine, name, what, theirs, AXES, UNSEEN_PROTOCOLS, gains)
    protocols = [NAMES[protocol] for protocol in UNSEEN_PROTOCOLS]
    head = ["model", "cell", "study", *protocols, "beaten in every seed", "why not"]
    return as_table([*head, ENTRANTS[OWN_CHOICE].title], rows)


def printed_table(rows: Iterable[Sequence[str]], settling: tuple[float, float]) -> str:
    """Return the studies' printed figures that stand in no other table, beside ours."""
    ours = "75 % of the largest after {:.0f}, 95 % after {:.0f}".format(*settling)
    more = ["Study-sized jig borer", "axial drift settles after [min]", "385", ours]
    return as_table(["model", "figure", "study", "ours"], [*rows, more])


def _cells(
    scores: Scores,
    machine: str,
    name: str,
    what: str,
    theirs: Sequence[float],
    columns: Sequence[str],
    protocols: Sequence[str],
    figures: Callable[[Sequence[Score]], np.ndarray],
) -> list[list[str]]:
    ours = {protocol: figures(scores[machine, name, protocol]) for protocol in protocols}
    ceilings = {protocol: figures(scores[machine, TRUTH, protocol]) for protocol in protocols}
    choice = figures(scores[machine, OWN_CHOICE, "like"])
    rows = []
    for k, (column, study) in enumerate(zip(columns, theirs, strict=True)):
        shown = [f"{_cell(ours[p][:, [k]])} of {ceilings[p][:, k].mean():.0f}" for p in protocols]
        if protocols == ("fit",):
            shown = [*shown, "", ""]
        won = [p for p in protocols if ours[p][:, k].min() >= study]
        beaten = "; ".join(NAMES[p] for p in won) or "no"
        reason = "" if len(won) == len(protocols) else _reason(ours, ceilings, k, study, won)
        title, cell = ENTRANTS[name].title, f"{what} {column}"
        own = "" if protocols == ("fit",) else _cell(choice[:, [k]])
        rows.append([title, cell, f"{study:.1f}", *shown, beaten, reason, own])
    return rows


def _reason(
    ours: Mapping[str, np.ndarray],
    ceilings: Mapping[str, np.ndarray],
    k: int,
    study: float,
    won: Sequence[str],
) -> str:
    """Return what stands between us and a study's figure, where it does not hold in every seed."""
    first = next(protocol for protocol in ours if protocol not in won)
    if ceilings[first][:, k].min() < study:
        return "noise: the truth itself is below in some seed"
    if first == "unlike":
        return "the surroundings: training saw no other"
    if first == "like":
        return "the spectrum: training saw no other"
    return "the model: short of it on its own spectrum"


def convergence_table(scores: Scores, machine: str) -> str:
    """Return how networks are trained, with weight decay and without: mean, range over seeds."""
    rows = []
    for name in NETWORKS:
        reports = [score.report for score in scores[machine, name, "fit"]]
        curves = [np.array(report["curve"]) for report in reports]
        near = [int(np.argmax(curve <= NEAR_END * curve[-1])) for curve in curves]
        rows.append(
            [
                ENTRANTS[name].title,
                _range([report["nodes"][1] for report in reports], "{:.0f}"),
                _range([curve[0] for curve in curves], "{:.2g}"),
                _range([curve[min(10, len(curve) - 1)] for curve in curves], "{:.2g}"),
                _range([curve[-1] for curve in curves], "{:.2g}"),
                _range(near, "{:.0f}"),
                _range([report["iterations"] for report in reports], "{:.0f}"),
            ]
        )
    head = ["model", "hidden nodes", "error at the start", "after 10 iterations", "at the end"]
    return as_table([*head, "iterations to within 1 % of it", "iterations"], rows)


def _range(values: Sequence[float], form: str) -> str:
    """Return the median of some values, and their range in brackets."""
    middle, low, high = (form.format(one) for one in (np.median(values), min(values), max(values)))
    return middle if low == high else f"{middle} ({low} to {high})"


def shown_range(values: Sequence[float], worst: Callable[..., float], digits: int = 2) -> str:
    """Return the mean of some values and, in brackets, the worst of them."""
    return f"{np.mean(values):.{digits}f} ({worst(values):.{digits}f})"


def _cell(figures: np.ndarray) -> str:
    """Return the mean over the seeds, with the worst of them in brackets, of every column."""
    means, worst = figures.mean(axis=0), figures.min(axis=0)
    return " / ".join(f"{a:.0f} ({b:.0f})" for a, b in zip(means, worst, strict=True))


def _plain(figures: Sequence[float]) -> str:
    return " / ".join(f"{value:.0f}" for value in figures)


def elements() -> list[dict[str, str]]:
    """Return every element of the studies: what it is, what is here, its command, file and test."""
    with ELEMENTS.open(encoding="utf-8", newline="") as lines:
        return list(csv.DictReader(lines))


def elements_table() -> str:
    """Return the elements of the studies, each with its command, file, test and oracle."""
    rows = []
    for one in elements():
        file, _, name = one["test"].partition("::")
        code = [f"`{cell}`" for cell in (one["command"], one["file"], file)]
        rows.append([one["study"], one["element"], one["here"], *code, name, one["oracle"]])
    head = ["study", "element", "here", "command", "file", "test", "its name", "its oracle"]
    return as_table(head, rows)


def as_table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(row)} |" for row in lines)
