"""``spindle-drift show-machine``: write a page that shows a machine and what looks wrong in it."""

from __future__ import annotations

import argparse
from dataclasses import asdict
from pathlib import Path

from plant_model.machine_file import machine_path
from scenarios.arguments import add_json, add_parameters, tell
from scenarios.outputs import PAGE, check_output
from scenarios.pages.machine_page import show_machine

NAME = "show-machine"
READS = ("machine",)
WRITES = {"output": PAGE}
HELP = "show a machine on one page: section, network, free numbers, warnings"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    output = {"flag": ("-o", "--output"), "dest": "output"}
    add_parameters(parser, show_machine, "machine", "cells", path=output)
    add_json(parser, "print JSON instead of sentences")


def run(args: argparse.Namespace) -> int:
    """Write the page and print what looks wrong."""
    path = args.output or Path(f"{machine_path(args.machine).stem}.html")
    check_output(path, PAGE)
    shown = show_machine(args.machine, path, cells=args.cells)
    sheet = shown.sheet
    table = {
        "page": str(path),
        "wrong": shown.wrong,
        "parts": [asdict(part) for part in sheet.parts],
        "time_constants": [{"hours": hours, "part": part} for hours, part in sheet.modes],
        "sources_w": sheet.sources,
        "given_off_w": sheet.given_off,
        "readings": {name: value for name, (value, _) in sheet.readings.items()},
        "drift_um": sheet.drift,
        "cells": [asdict(row) for row in shown.cells],
    }
    lines = [f"looks wrong: {line}" for line in shown.wrong]
    lines = lines or ["nothing looks wrong to these checks"]
    if shown.cells:
        lines.append(f"{'longest mm':>10}{'around':>8}{'lumps':>7}{'warm':>9}{'moved':>9}")
    lines += [
        f"{row.longest_mm:>10.0f}{row.sectors:>8}{row.nodes:>7}"
        f"{100 * row.temperature:>7.1f} %{100 * row.drift:>7.1f} %"
        for row in shown.cells
    ]
    return tell(args, table, *lines, f"wrote {path}")
