"""What `fit` and `update` show while they work, and what they print of a fit."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tqdm import tqdm

from measurement.errors import BadInput


def add_jobs(parser: argparse.ArgumentParser) -> None:
    """Declare how many processes may fit."""
    parser.add_argument(
        "--jobs",
        type=int,
        default=os.cpu_count() or 1,
        metavar="N",
        help="processes (default: one for each core)",
    )


def check_jobs(command: str, jobs: int) -> None:
    """Refuse no processes.

    Parameters
    ----------
    command : str
        Its name, for the refusal.
    jobs : int
        Processes.

    Raises
    ------
    BadInput
        If there are none.
    """
    if jobs < 1:
        raise BadInput(command, "--jobs", f"{jobs} is not allowed: 1 or more")


def kinds_of(among: str | None) -> list[str] | None:
    """Return the error models that ``--among`` names.

    Parameters
    ----------
    among : str or None
        Names with commas between; None means all of them.
    """
    return None if among is None else [name.strip() for name in among.split(",")]


@contextmanager
def bar() -> Iterator[Callable[[str, float], None]]:
    """Show a bar with the time left; give what tells it how far the work is."""
    form = "{desc}: {percentage:3.0f}%|{bar}| {elapsed}<{remaining}"
    with tqdm(total=1.0, bar_format=form, disable=None, leave=False) as bar:

        def tell(label: str, done: float) -> None:
            bar.set_description(label, refresh=False)
            bar.update(done - bar.n)

        yield tell


def report(table: dict[str, Any], path: Path) -> list[str]:
    """Return what a person wants to know of a fit, as lines.

    Parameters
    ----------
    table : dict
        The compensator file's content.
    path : Path
        Where the file was written.
    """
    provenance, figures = table["provenance"], table["provenance"]["figures"]
    lines = list(provenance["notes"])
    choice = figures["choice"]
    for number, group in enumerate(choice.get("groups", ()), 1):
        scores = [f"{name} {choice['scores'][name]:.2f}" for name in group]
        lines.append(f"group {number}, score to the drift: {', '.join(scores)}")
    if choice.get("hardly_moving"):
        lines.append(f"hardly moving: {', '.join(choice['hardly_moving'])}")
    lines.append(f"temperatures used: {', '.join(table['chosen'])}")
    fit = figures["fit"]
    if "condition_number" in fit:
        inflation = max(fit["variance_inflation"].values())
        lines.append(
            f"condition number {fit['condition_number']:.1f}, "
            f"largest variance inflation {inflation:.1f}"
        )
    lines += ["", *judgement(figures["models"]), *promise(figures)]
    return [*lines, f"wrote {path}"]


def judgement(models: list[dict[str, Any]]) -> list[str]:
    """Return the table of the models that were judged for the choice."""
    if not models or (len(models) == 1 and not models[0].get("ratio_to_none")):
        return []
    lines = [
        "Error left on runs left out, in % of no compensation; each model is kept near the careful "
        "one:",
        f"{'model':<18}{'hard half':>12}{'worst fold':>12}   which",
    ]
    for row in models:
        name = f"{row['model']}{' *' if row['chosen'] else ''}"
        if "refused" in row:
            lines.append(f"{name:<18}{'-':>12}{'-':>12}   {row['refused']}")
            continue
        ratios = row["ratio_to_none"]
        worst = max(ratios, key=ratios.__getitem__)
        cells = f"{100 * row['hard_folds']:>12.0f}{100 * row['worst_fold']:>12.0f}"
        lines.append(f"{name:<18}{cells}   {worst}")
    lines.append(f"{'no compensation':<18}{100:>12}{100:>12}")
    return [*lines, "* chosen: the simplest within one standard error of the best", ""]


def promise(figures: dict[str, Any]) -> list[str]:
    """Return what the fit may promise, and where it measured nothing."""
    unseen = figures["unseen"] or {}
    lines = [
        f"{'RMSE [um, urad]':<18}"
        + "".join(f"{name:>12}" for name in ("no model", "training", "like runs", "unlike runs"))
    ]
    for target, row in figures["training"].items():
        cells = [
            f"{unseen[kind][target]['model']:>12.2f}" if kind in unseen else f"{'-':>12}"
            for kind in ("like", "unlike")
        ]
        none, model = row["no_model"]["rmse"], row["model"]["rmse"]
        lines.append(f"{target:<18}{none:>12.2f}{model:>12.2f}{''.join(cells)}")
    if not unseen:
        return [
            *lines,
            "nothing is promised for other runs: fewer than three runs were given, so none could be"
            " left out",
        ]
    hardest = max(unseen["unlike_folds"], key=lambda one: one["ratio_to_none"], default=None)
    lines += [
        "like runs: each predicted by a model of the others; unlike: whole conditions left out",
    ]
    if hardest is not None:
        share = 100 * hardest["ratio_to_none"]
        lines.append(f"worst: {hardest['left_out']} left out, {share:.0f} % of the drift is left")
    return lines
