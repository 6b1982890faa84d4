"""``spindle-drift points``: show which temperatures are alike and which explain most of the drift.

Prints the grey degrees, every grouping, and how much each combination of points explains.
"""

from __future__ import annotations

import argparse
import json
from functools import partial
from typing import Any

from fmu_compensator.fit.loops import Loop
from fmu_compensator.fit.survey import Survey, survey
from scenarios.arguments import add_json, add_parameters, add_results, add_runs
from scenarios.grey_options import add_grey_options, grey_options
from scenarios.outputs import FOLDER
from scenarios.pages.charts import SHOWN
from scenarios.presets import add_as, preset
from scenarios.results import write_findings
from spindle_drift._inputs import as_runs
from spindle_drift.surveys import points

NAME = "points"
HELP = "show which temperatures move alike and which explain the drift best"
READS = ("runs", "machine")
WRITES = {"out": FOLDER}
COLUMN = 14
"""Width of a column: given by its heads."""
GROUPINGS = "grey|hierarchical|fuzzy|NAME,NAME..."
HEADS = ("Pearson", "grey rel.", "lag [min]", "[{}/K]", "rms [{}]", "lagged [{}]")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    add_runs(parser)
    add_grey_options(parser)
    add_parameters(
        parser,
        survey,
        grouping={"flag": "--points", "dest": "points", "metavar": GROUPINGS},
        target={"metavar": "NAME"},
    )
    add_parameters(parser, points, machine={"metavar": "FILE"})
    add_json(parser, "print JSON instead of tables")
    add_results(parser, "write points.json, dendrogram.png, heat_map.png, loops.png")
    add_as(parser)


def run(args: argparse.Namespace) -> int:
    """Survey the runs and print.

    Raises
    ------
    BadInput
        If the runs or options cannot be used.
    """
    options = {**grey_options(args), "grouping": args.points, "target": args.target}
    runs = as_runs(args.runs)
    if args.study is not None:
        preset(args.study, runs, args.points)
    surveyed = points(runs, machine=args.machine, **options).survey
    text = json.dumps(surveyed.to_dict(), indent=1, allow_nan=False)
    lines = _report(surveyed)
    if args.out is not None:
        from scenarios.pages.points_figures import draw_points  # only here: it loads Matplotlib

        paths = write_findings(args.out, "points", text, partial(draw_points, surveyed))
        lines.append("wrote " + ", ".join(map(str, paths)))
    print(text if args.json else "\n".join(lines))
    return 0


def _report(survey: Survey) -> list[str]:
    names = survey.sensors
    width = max(6, *(len(name) + 1 for name in names))
    lines = [*survey.notes, "", "Grey comprehensive degree", " " * width + _cells(names, width)]
    for name, row in zip(names, survey.degree, strict=True):
        lines.append(f"{name:<{width}}" + _cells([f"{value:.2f}" for value in row], width))
    for title, groups in survey.groupings.items():
        shown = "; ".join(" ".join(names[i] for i in group) for group in groups)
        lines += ["", f"{title}: {len(groups)} groups", f"  {shown}"]
    heads = "".join(f"{head.format(survey.unit):>{COLUMN}}" for head in HEADS)
    lines += ["", f"To the error {survey.target} [{survey.unit}]", f"{'':<{width}}{heads}"]
    for place, (name, loop) in enumerate(zip(names, survey.loops, strict=True)):
        lines.append(
            f"{name:<{width}}{survey.pearson[place]:>{COLUMN}.3f}"
            f"{survey.relational[place]:>{COLUMN}.3f}{_lag(loop):>{COLUMN}}"
            f"{loop.rate:>{COLUMN}.3g}{loop.open:>{COLUMN}.2f}{loop.closed:>{COLUMN}.2f}"
        )
    lines += [
        "lag: how much later the error comes (*: at least, a quarter of the shortest run)",
        "rms: of the error's distance from a straight line; lagged: after the lag",
        f"[{survey.unit}/K]: the slope of that line, after the lag",
    ]
    lines += ["", f"Chosen: {', '.join(names[i] for i in survey.points)}"]
    lines += ["", f"Combinations of them, best adjusted R2 first (of {len(survey.subsets)})"]
    unseen = f"unseen [{survey.unit}]"
    lines.append(f"{'multiple R':>11}{'adj. R2':>9}{unseen:>{COLUMN}}  temperatures")
    for subset in survey.subsets[:SHOWN]:
        lines.append(_subset(survey, subset))
    if len(survey.run_names) == 1:
        return [*lines, "unseen: needs a second run, to be predicted from the first"]
    best = min(survey.subsets, key=lambda subset: (subset.held_out_rmse, len(subset.columns)))
    if best not in survey.subsets[:SHOWN]:
        lines.append(_subset(survey, best) + "  <- best on unseen runs")
    return lines


def _lag(loop: Loop) -> str:
    return f"{loop.lag_min:.0f}{'*' if loop.is_limit else ''}"


def _cells(texts: list[str], width: int) -> str:
    return "".join(f"{text:>{width}}" for text in texts)


def _subset(survey: Survey, subset: Any) -> str:
    names = " ".join(survey.sensors[survey.points[place]] for place in subset.columns)
    fit = f"{subset.multiple_r:>11.4f}{subset.r2_adjusted:>9.4f}"
    unseen = f"{subset.held_out_rmse:.3f}" if len(survey.run_names) > 1 else "-"
    return f"{fit}{unseen:>{COLUMN}}  {names}"
