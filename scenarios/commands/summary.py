"""``spindle-drift summary``: what a run file holds, in the terms of ISO 230-3."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from tqdm import tqdm

from measurement.doubts import doubt_lines
from measurement.errors import BadInput
from measurement.faults import looked_over
from measurement.files import write_atomically
from measurement.iso230 import Summary, summarise
from measurement.overview import draw_overview, png_bytes
from measurement.rig import Rig, default_rig, rig_from_table
from measurement.runs import Run, read_run
from plant_model.machine import Machine
from plant_model.machine_file import read_machine
from scenarios.outputs import FOLDER
from scenarios.results import results_folder, write_table

NAME = "summary"
HELP = "print the ISO 230-3 style summary of runs"
READS = ("runs", "machine")
WRITES = {"out": FOLDER}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument("runs", nargs="+", type=Path, metavar="RUN", help="run file (CSV)")
    parser.add_argument(
        "--machine",
        metavar="FILE",
        help="machine file, or the name of a shipped one: its rig and its ambient column",
    )
    parser.add_argument(
        "--ambient",
        metavar="COLUMN",
        help="column of the ambient temperature, if the machine file does not say it",
    )
    parser.add_argument("--json", action="store_true", help="print JSON instead of tables")
    parser.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="also write summary.json and a figure per run here",
    )


def run(args: argparse.Namespace) -> int:
    """Summarise every run; nothing is printed or written unless all of them can be read.

    Raises
    ------
    BadInput
        For a run or a machine file that cannot be used.
    """
    machine = read_machine(args.machine) if args.machine else None
    runs = looked_over([read_run(path) for path in args.runs])
    rigs = [_rig(entry, machine) for entry in runs]
    summaries = [
        summarise(entry, rig, args.ambient or _ambient(entry, machine))
        for entry, rig in zip(runs, rigs, strict=True)
    ]
    tables = json.dumps([summary.to_dict() for summary in summaries], indent=2, allow_nan=False)
    if args.out is not None:
        with results_folder(args.out) as folder:
            _write(folder, tables, runs, summaries, rigs)
            write_table([], {"summary": "summary.json"}, folder, to_come=())
    if args.json:
        print(tables)
    else:
        print("\n\n\n".join(summary.text() for summary in summaries))
        for line in doubt_lines(runs):
            print(line)
        if args.out is not None:
            print(f"\nWrote summary.json and {len(runs)} PNG to {args.out}")
    return 0


def _rig(entry: Run, machine: Machine | None) -> Rig | None:
    """Return the machine's rig; without a machine the one that the columns' names tell, or None."""
    if machine is not None:
        return rig_from_table(machine.rig, f"machine {machine.name}")
    try:
        return default_rig(entry)
    except BadInput:
        return None


def _ambient(entry: Run, machine: Machine | None) -> str | None:
    """Return the column of the machine's input called ambient, where the run has it."""
    inputs = machine.inputs if machine is not None else ()
    column = next((item.column for item in inputs if item.name == "ambient"), None)
    return column if column in entry.frame.columns else None


def _write(
    folder: Path,
    tables: str,
    runs: list[Run],
    summaries: list[Summary],
    rigs: list[Rig | None],
) -> None:
    names = _file_names([entry.name for entry in runs])
    every = list(zip(names, runs, summaries, rigs, strict=True))
    hidden = len(every) < 4 or not sys.stderr.isatty()
    for name, entry, summary, rig in tqdm(every, desc="figures", disable=hidden):
        write_atomically(folder / name, png_bytes(draw_overview(entry, summary, rig)))
    write_atomically(folder / "summary.json", tables + "\n")


def _file_names(names: list[str]) -> list[str]:
    """Return one file name per run; runs of one name (from two folders) get numbers."""
    files: list[str] = []
    for name in names:
        file, number = f"{name}.png", 1
        while file.lower() in {other.lower() for other in files}:  # case counts on some disks only
            number += 1
            file = f"{name}-{number}.png"
        files.append(file)
    return files
