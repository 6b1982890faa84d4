"""The studies' own experiment, rebuilt: learn on a spectrum of speeds, predict, compensate.

    python -m benchmarks.studies [PART ...] [--write] [--seeds N] [--workers N]

Three simulated machines, three protocols side by side, several seeds each, and what noise alone
leaves in every table. Every figure stands beside the study's; ``--write`` writes the same page to
docs/studies.md, and its pictures. What a part gives is kept in results/studies: with parts named
only these are measured anew (``judge_all:bayes`` one row of theirs), and with ``page`` none is.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import as_completed
from pathlib import Path
from typing import Any

from tqdm import tqdm

from benchmarks.results_page import parser_of
from benchmarks.studies.claims import convergence_claim, goal_claim, network_claim, tau_claim
from benchmarks.studies.groupings import (
    GREY,
    TREE,
    Grouped,
    draw_grouped,
    grouped,
    groupings_claim,
    groupings_table,
)
from benchmarks.studies.hybrid import (
    MACHINES,
    Hybrid,
    experiment,
    hybrid_table,
    tau_table,
    workpiece_table,
)
from benchmarks.studies.judge import Score, judge_all
from benchmarks.studies.machines import TRUTHS, settling_min
from benchmarks.studies.tables import (
    by_place,
    cells_table,
    compensation_table,
    convergence_table,
    elements_table,
    prediction_table,
    printed_table,
)
from measurement.files import write_atomically
from measurement.workers import workers

DOCS = Path(__file__).resolve().parents[2] / "docs"
TEMPLATE = Path(__file__).with_name("page.md")
SEEDS = 6
FIVE_POINT = ("study_size", "jig_borer")
PARTS: Mapping[str, Callable[..., list[Any]]] = {
    job.__name__: job for job in (judge_all, grouped, experiment)
}
KEPT = DOCS.parent / "results" / "studies"


def page_of(done: list[Any], seeds: int) -> str:
    """Return docs/studies.md, made of what all jobs have given."""
    found = by_place(one for one in done if isinstance(one, Score))
    hybrids = [one for one in done if isinstance(one, Hybrid)]
    groups = [one for one in done if isinstance(one, Grouped)]
    return page_from(
        {
            "compensation": compensation_table(found, FIVE_POINT),
            "cells": cells_table(found, "study_size"),
            "printed": printed_table(found, "study_size", settling_min()),
            "prediction": prediction_table(found),
            "grey_groups": groupings_table(groups, GREY),
            "tree_groups": groupings_table(groups, TREE),
            "groups_claim": groupings_claim(groups),
            "convergence": convergence_table(found, "study_size"),
            "hybrid": hybrid_table(hybrids),
            "taus": tau_table(hybrids),
            "workpieces": workpiece_table(hybrids),
        },
        seeds,
    )


def page_from(tables: Mapping[str, str], seeds: int) -> str:
    """Return the page that holds some tables; what it says of them is made of their cells."""
    return TEMPLATE.read_text("utf-8").format(
        seeds=seeds,
        elements=elements_table(),
        goal_claim=goal_claim(tables["compensation"], seeds),
        network_claim=network_claim(tables["prediction"]),
        convergence_claim=convergence_claim(tables["convergence"]),
        tau_claim=tau_claim(tables["taus"]),
        **tables,
    )


def measured(parts: Sequence[str], seeds: int, count: int | None) -> list[Any]:
    """Return what all jobs give: scores, groups and hybrids.

    Parameters
    ----------
    parts : sequence of str
        Those of `PARTS` to measure anew, ``judge_all:MODEL`` for one model's scores; none for all.
        The rest is what was measured last.
    seeds : int
        How many.
    count : int, optional
        Processes; by default one a core.
    """
    every_seed = range(1, seeds + 1)
    # The longest first, so that no worker ends up with one alone.
    given: Mapping[str, list[tuple[Any, ...]]] = {
        "judge_all": [(machine, seed) for machine in TRUTHS for seed in every_seed],
        "grouped": [(machine, seed) for machine in FIVE_POINT for seed in every_seed],
        "experiment": [(machine, seed) for machine in MACHINES for seed in every_seed],
    }
    jobs = []
    for part in parts or PARTS:
        name, _, model = part.partition(":")
        jobs += [(name, (*one, model) if model else one) for one in given.get(name, ())]
    KEPT.mkdir(parents=True, exist_ok=True)
    with workers(count) as pool, tqdm(total=len(jobs), unit="job", disable=None) as bar:
        running = {pool.submit(PARTS[name], *one): (name, one) for name, one in jobs}
        for future in as_completed(running):
            name, one = running[future]
            keep(name, one, future.result())
            bar.update()
    return [result for name in PARTS for one in given[name] for result in kept(name, one)]


def _file(name: str, given: Sequence[Any]) -> Path:
    return KEPT / f"{'_'.join(map(str, (name, *given[:2])))}.pickle"


def kept(name: str, given: Sequence[Any]) -> list[Any]:
    """Return the results of a job that were kept last."""
    return list(pickle.loads(_file(name, given).read_bytes()))


def keep(name: str, given: Sequence[Any], results: list[Any]) -> None:
    """Keep a job's results; those of one model beside those of the others."""
    for model in given[2:]:
        results += [one for one in kept(name, given) if one.model != model]
    _file(name, given).write_bytes(pickle.dumps(results))


def main() -> int:
    """Run everything and print the page."""
    parser = parser_of(__doc__, "benchmarks.studies")
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"{', '.join(PARTS)} or page")
    parser.add_argument("--seeds", type=int, default=SEEDS, help=f"how many ({SEEDS})")
    parser.add_argument("--workers", type=int, help="processes (one a core)")
    args = parser.parse_args()
    page = page_of(measured(args.parts, args.seeds, args.workers), args.seeds)
    print(page)
    if args.write:
        write_atomically(DOCS / "studies.md", page)
        draw_grouped("study_size", 1, DOCS / "figures" / "studies")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
