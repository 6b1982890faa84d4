"""The tables of docs/studies.md, made of scores."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path, PurePosixPath

import numpy as np

from benchmarks.results_page import as_table
from benchmarks.studies.entrants import ENTRANTS, NO_MODEL, TRUTH
from benchmarks.studies.judge import Score
from benchmarks.studies.machines import truth
from benchmarks.studies.published import AXIAL, BEST, COMPENSATED, FIT, RESIDUAL, UNSEEN

NAMES = {"fit": "fit", "repeated": "repeated", "like": "like", "unlike": "other"}
UNSEEN_PROTOCOLS = ("repeated", "like", "unlike")
NEAR_END = 1.01
"""A training has converged where its error is within this factor of its last one [1]."""
POSED, AXIAL_ONLY = "study_size", "elements"
SEEDS_THAT_REACH = "seeds that reach it"
NETWORKS = (
    "bp_study",
    "ga_bp_study",
    "ga_bp_nodes",
    "ga_bp_nodes_training",
    "bp_four",
    "ga_bp_four",
)
ELEMENTS = Path(__file__).with_name("elements.csv")
FIT_RUN = "spindle-drift fit RUN.csv -o c.json"
"""Stands in most commands of the elements; the page says once what its ``fit`` is."""
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


def gains(scores: Sequence[Score]) -> np.ndarray:
    """Return what is better along X, Y and Z, a row a seed [%]."""
    return np.array([score.better for score in scores])


def prediction_table(scores: Scores) -> str:
    """Return the predictive ability of every model: of all poses, and of the axisymmetric spindle.

    The former on `POSED` under every protocol, the latter on `AXIAL_ONLY` under those not repeated.
    """
    columns = [(POSED, protocol) for protocol in NAMES]
    columns += [(AXIAL_ONLY, protocol) for protocol in UNSEEN_PROTOCOLS[1:]]
    rows = []
    for name, entrant in ENTRANTS.items():
        if (POSED, name, "fit") in scores:
            there = [scores.get((machine, name, protocol)) for machine, protocol in columns]
            rows.append([entrant.title, *(_cell(etas(one)) if one else "" for one in there)])
    head = [f"{truth(machine).title}: {NAMES[protocol]}" for machine, protocol in columns]
    return as_table([f"eta of {'/'.join(TARGETS)} [%]", *head], rows)


def compensation_table(scores: Scores, machines: Sequence[str]) -> str:
    """Return what compensation takes off the drift, X/Y/Z, and in how many seeds it beats `BEST`.

    The latter for models by temperature only, a number for each unseen protocol.
    """
    rows = []
    for name, entrant in ENTRANTS.items():
        there = [machine for machine in machines if (machine, name, "fit") in scores]
        if name == NO_MODEL or there != list(machines):
            continue
        found = [[gains(scores[m, name, p]) for p in UNSEEN_PROTOCOLS] for m in machines]
        cells = [_cell(figures) for here in found for figures in here]
        won = [
            "/".join(str((figures >= BEST).all(axis=1).sum()) for figures in here) for here in found
        ]
        rows.append([entrant.title, *cells, *(won if entrant.by_temperature else [""] * len(won))])
    titles = [truth(machine).title for machine in machines]
    heads = [f"{title}: {NAMES[protocol]}" for title in titles for protocol in UNSEEN_PROTOCOLS]
    wins = [f"{title}: {SEEDS_THAT_REACH}" for title in titles]
    return as_table(["X/Y/Z better by [%]", *heads, *wins], rows)


def cells_table(scores: Scores, machine: str) -> str:
    """Return every cell of the studies' tables: theirs, ours, and where and why not ours is better.

    Ours is the mean over the seeds, and in brackets the worst of them.
    """
    rows = []
    for name in FIT:
        rows.append(_cells(scores, machine, name, "fit", FIT[name], ("fit",), etas))
        rows.append(_cells(scores, machine, name, "unseen", UNSEEN[name], UNSEEN_PROTOCOLS, etas))
    for name, (study, theirs) in COMPENSATED.items():
        what = f"compensated, {study}"
        rows.append(_cells(scores, machine, name, what, theirs, UNSEEN_PROTOCOLS, gains))
    return as_table(["model", "cells", "study", "fit or like", "beaten", "why not"], rows)


def printed_table(scores: Scores, machine: str, settling: tuple[float, float]) -> str:
    """Return the studies' figures that stand in no table of theirs, beside ours."""
    rows = []
    axial = {
        name: np.mean([one.axial_um for one in scores[machine, name, "like"]], axis=0)
        for name in (*RESIDUAL, *AXIAL)
    }
    for name, study in RESIDUAL.items():
        ours = f"{axial[name][1]:.1f}"
        rows.append([ENTRANTS[name].title, "largest axial residual, unseen [um]", study, ours])
    for name, study in AXIAL.items():
        ours = "{:.1f} to {:.1f}, {:.1f} to {:.1f}".format(*axial[name])
        rows.append([ENTRANTS[name].title, "axial drift, largest and mean [um]", study, ours])
    series = ENTRANTS["arma_270"].title
    ours = _cell(etas(scores[machine, "arma_270", "like"]))
    rows.append([series, f"predictive ability, unseen, {'/'.join(TARGETS)} [%]", "94", ours])
    ours = "75 % of the largest after {:.0f}, 95 % after {:.0f}".format(*settling)
    rows.append([truth(machine).title, "axial drift settles after [min]", "385", ours])
    return as_table(["model", "figure", "study", "ours"], rows)


def _cells(
    scores: Scores,
    machine: str,
    name: str,
    what: str,
    theirs: Sequence[float],
    protocols: Sequence[str],
    figures: Callable[[Sequence[Score]], np.ndarray],
) -> list[str]:
    """Return the row of one of a study's tables."""
    ours = {protocol: figures(scores[machine, name, protocol]) for protocol in protocols}
    ceilings = {protocol: figures(scores[machine, TRUTH, protocol]) for protocol in protocols}
    columns = TARGETS if figures is etas else AXES
    beaten, reasons = [], []
    for k, (column, study) in enumerate(zip(columns, theirs, strict=True)):
        won = [p for p in protocols if ours[p][:, k].min() >= study]
        if won:
            beaten.append(f"{column} {', '.join(NAMES[p] for p in won)}")
        if len(won) < len(protocols):
            reasons.append(f"{column} {_reason(ours, ceilings, k, study, won)}")
    shown = _cell(ours["fit" if "fit" in protocols else "like"])
    cells = f"{what}: {'/'.join(columns)}"
    study_row = "/".join(f"{value:g}" for value in theirs)
    return [ENTRANTS[name].title, cells, study_row, shown, "; ".join(beaten), "; ".join(reasons)]


def _reason(
    ours: Mapping[str, np.ndarray],
    ceilings: Mapping[str, np.ndarray],
    k: int,
    study: float,
    won: Sequence[str],
) -> str:
    """Return what stands between us and a study's figure, where it does not hold in every seed.

    Noise: the truth itself is below it in some seed. Surroundings, spectrum: training saw no other.
    Model: it is short of the figure on its own spectrum.
    """
    first = next(protocol for protocol in ours if protocol not in won)
    if ceilings[first][:, k].min() < study:
        return "noise"
    return {"unlike": "surroundings", "like": "spectrum"}.get(first, "model")


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
    """Return the means over the seeds of every column, and in brackets its worst seeds."""
    both = figures.mean(axis=0), figures.min(axis=0)
    means, worst = ("/".join(f"{value:.0f}" for value in row) for row in both)
    return f"{means} ({worst})"


def elements() -> list[dict[str, str]]:
    """Return every element of the studies: what it is, what is here, its command, file and test."""
    with ELEMENTS.open(encoding="utf-8", newline="") as lines:
        return list(csv.DictReader(lines))


def elements_table() -> str:
    """Return the elements of the studies, each with its command, file, test and oracle."""
    rows = []
    for one in elements():
        file, _, name = one["test"].partition("::")
        code = [f"`{cell}`" for cell in (one["command"].replace(FIT_RUN, "fit"), one["file"])]
        test = f"`{PurePosixPath(file).name}::{name}`"
        rows.append([one["study"], one["element"], one["here"], *code, test, one["oracle"]])
    head = ["study", "element", "here", "command", "file", "test", "oracle"]
    return as_table(head, rows)
