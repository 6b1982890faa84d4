"""``spindle-drift summary``: summarise run files in the terms of ISO 230-3."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from tqdm import tqdm

from measurement.doubts import doubt_lines
from measurement.faults import looked_over
from measurement.files import write_atomically
from measurement.iso230 import Summary
from measurement.rig import Rig
from measurement.runs import Run, read_run
from scenarios.arguments import add_json, add_parameters, add_results, add_runs
from scenarios.outputs import FOLDER
from scenarios.results import write_findings
from spindle_drift.machines import Machine
from spindle_drift.recordings import rig_for, summary

NAME = "summary"
HELP = "print the ISO 230-3 style summary of runs"
READS = ("runs", "machine")
WRITES = {"out": FOLDER}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    add_runs(parser)
    add_parameters(parser, summary, machine={"metavar": "FILE"}, ambient={"metavar": "COLUMN"})
    add_json(parser, "print JSON instead of tables")
    add_results(parser, "also write summary.json, table.json and a figure per run here")


def run(args: argparse.Namespace) -> int:
    """Summarise every run; nothing is printed or written unless all of them can be read.

    Raises
    ------
    BadInput
        If a run or a machine file cannot be used.
    """
    machine = Machine(args.machine) if args.machine else None
    runs = looked_over([read_run(path) for path in args.runs])
    rigs = [rig_for(entry, machine) for entry in runs]
    summaries = [summary(entry, machine=machine, ambient=args.ambient) for entry in runs]
    tables = json.dumps([entry.to_dict() for entry in summaries], indent=2, allow_nan=False)
    if args.out is not None:
        write_findings(
            args.out, "summary", tables, lambda folder: _draw(folder, runs, summaries, rigs)
        )
    if args.json:
        print(tables)
    else:
        print("\n\n\n".join(entry.text() for entry in summaries))
        for line in doubt_lines(runs):
            print(line)
        if args.out is not None:
            print(f"\nWrote summary.json, table.json and {len(runs)} PNG to {args.out}")
    return 0


def _draw(
    folder: Path, runs: list[Run], summaries: list[Summary], rigs: list[Rig | None]
) -> list[Path]:
    from scenarios.pages.figures import png_bytes  # only here: it loads Matplotlib
    from scenarios.pages.run_figure import draw_overview

    names = _file_names([entry.name for entry in runs])
    every = list(zip(names, runs, summaries, rigs, strict=True))
    return [
        write_atomically(folder / name, png_bytes(draw_overview(entry, table, rig)))
        for name, entry, table, rig in tqdm(every, desc="figures", disable=len(every) < 4 or None)
    ]


def _file_names(names: list[str]) -> list[str]:
    """Return one file name per run; runs with the same name (from two folders) get numbers."""
    files: list[str] = []
    for name in names:
        file, number = f"{name}.png", 1
        while file.lower() in {other.lower() for other in files}:  # some disks ignore case
            number += 1
            file = f"{name}-{number}.png"
        files.append(file)
    return files
