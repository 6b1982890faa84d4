"""The studies' own experiment, rebuilt: learn on a spectrum of speeds, predict, compensate.

    python -m benchmarks.studies [--write] [--seeds N] [--workers N]

Three simulated machines, three protocols side by side, several seeds each, and what noise alone
leaves in every table. Every figure stands beside the study's; ``--write`` writes the same page to
docs/studies.md, and its pictures.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from concurrent.futures import as_completed
from pathlib import Path
from typing import Any

from tqdm import tqdm

from benchmarks.studies.claims import (
    convergence_claim,
    goal_claim,
    network_claim,
    printed_claims,
    tau_claim,
)
from benchmarks.studies.four_runs import MODELS, interval_rows, interval_table
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
    goal_table,
    prediction_table,
    printed_table,
)
from measurement.files import write_atomically
from measurement.workers import workers

DOCS = Path(__file__).resolve().parents[2] / "docs"
TEMPLATE = Path(__file__).with_name("page.md")
SEEDS = 6
FIVE_POINT = ("study_size", "jig_borer")


def page_of(done: list[Any], seeds: int) -> str:
    """Return docs/studies.md, made of what all jobs have given."""
    found = by_place(one for one in done if isinstance(one, Score))
    hybrids = [one for one in done if isinstance(one, Hybrid)]
    groups = [one for one in done if isinstance(one, Grouped)]
    intervals = sorted(one for one in done if isinstance(one, list))
    return page_from(
        {
            "goal": goal_table(found, FIVE_POINT),
            "grey_groups": groupings_table(groups, GREY),
            "tree_groups": groupings_table(groups, TREE),
            "groups_claim": groupings_claim(groups),
            "cells": cells_table(found, "study_size"),
            "study_size": prediction_table(found, "study_size"),
            "study_size_compensated": compensation_table(found, "study_size"),
            "jig_borer_compensated": compensation_table(found, "jig_borer"),
            "elements": prediction_table(found, "elements"),
            "convergence": convergence_table(found, "study_size"),
            "hybrid": hybrid_table(hybrids),
            "taus": tau_table(hybrids),
            "workpieces": workpiece_table(hybrids),
            "intervals": interval_table(intervals),
        },
        seeds,
    )


def page_from(tables: Mapping[str, str], seeds: int) -> str:
    """Return the page that holds some tables; what it says of them is made of their cells."""
    return TEMPLATE.read_text("utf-8").format(
        seeds=seeds,
        elements_of_studies=elements_table(),
        goal_claim=goal_claim(tables["goal"]),
        network_claim=network_claim(tables["study_size"]),
        convergence_claim=convergence_claim(tables["convergence"]),
        tau_claim=tau_claim(tables["taus"]),
        printed=printed_table(
            printed_claims(tables["study_size"], tables["study_size_compensated"]), settling_min()
        ),
        **tables,
    )


def measured(seeds: int, count: int | None) -> list[Any]:
    """Return what all jobs give: scores, groups, hybrids and rows of the last table.

    Parameters
    ----------
    seeds : int
        How many.
    count : int, optional
        Processes; by default one a core.
    """
    every_seed = range(1, seeds + 1)
    # The longest first, so that no worker ends up with one alone.
    jobs: list[tuple[Callable[..., Any], tuple[Any, ...]]] = [
        *((judge_all, (machine, seed)) for machine in TRUTHS for seed in every_seed),
        *((interval_rows, (model,)) for model in MODELS),
        *((grouped, (machine, seed)) for machine in FIVE_POINT for seed in every_seed),
        *((experiment, (machine, seed)) for machine in MACHINES for seed in every_seed),
    ]
    done = []
    with workers(count) as pool, tqdm(total=len(jobs), unit="job", disable=None) as bar:
        running = [pool.submit(job, *given) for job, given in jobs]
        for future in as_completed(running):
            done += future.result()
            bar.update()
    return done


def main() -> int:
    """Run everything and print the page."""
    parser = argparse.ArgumentParser("benchmarks.studies", description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true", help="also write docs/studies.md")
    parser.add_argument("--seeds", type=int, default=SEEDS, help=f"how many ({SEEDS})")
    parser.add_argument("--workers", type=int, help="processes (one a core)")
    args = parser.parse_args()
    page = page_of(measured(args.seeds, args.workers), args.seeds)
    print(page)
    if args.write:
        write_atomically(DOCS / "studies.md", page)
        draw_grouped("study_size", 1, DOCS / "figures" / "studies")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
