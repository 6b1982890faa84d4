"""Simulate a scenario with plant and compensator FMU in closed loop; print and save results."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from measurement.errors import BadInput
from scenarios.arguments import DIRECTORY, add_json, add_parameters, tell
from scenarios.assignments import assignment
from scenarios.outputs import FOLDER, also_reads
from scenarios.replay_runner import run_replay
from scenarios.runner import run_scenario
from scenarios.scenario import Replay, Scenario, read_scenario
from scenarios.table import as_text
from spindle_drift import components
from spindle_drift._options import add_scenario

NAME = "run"
HELP = "simulate a scenario"
READS = ("scenario", "plant", "compensator", "settings")
WRITES = {"out": FOLDER}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    add_scenario(parser)
    add_parameters(parser, components.run_scenario, "live", out=DIRECTORY)
    add_json(parser, "print table.json instead of a table")
    parser.add_argument("--quiet", action="store_true", help="no progress bar, no table")


def run(args: argparse.Namespace) -> int:
    """Simulate, write the folder, print the table."""
    scenario = read_scenario(args.scenario, [assignment(text) for text in args.settings])
    settings = scenario.settings
    out = args.out or Path("results") / settings.name
    pace = ""
    if settings.replay is not None:
        table, groups, _ = _replay(scenario, settings.replay, args, out)
    else:
        table, groups, speed = run_scenario(
            scenario,
            out,
            args.fmu_dir,
            plant=args.plant,
            compensator=args.compensator,
            live=args.live,
            quiet=args.quiet or args.json,
        )
        pace = f"{speed:,.0f} simulated seconds a second; "
    where = f"{pace}results in {out}, report: {out / 'report.html'}"
    return tell(args, table, settings.title, "", as_text(groups), "", *table["notes"], where)


def _replay(scenario: Scenario, replay: Replay, args: argparse.Namespace, out: Path) -> Any:
    settings = scenario.settings
    near = scenario.path.resolve().parent
    also_reads([_near(near, name) for name in replay.runs])
    if not replay.runs:
        raise BadInput(
            scenario.path,
            "replay.runs",
            "names no run: --set 'replay.runs=[\"RUN.csv\"]', or use spindle-drift replay",
        )
    for option in ("plant", "live"):
        if getattr(args, option):
            raise BadInput(f"--{option}", "", "has no meaning in a replay: no plant is simulated")
    return run_replay(
        args.compensator or settings.compensator.fmu,
        [_near(near, name) for name in replay.runs],
        out,
        args.fmu_dir,
        near=near,
        tool_length_mm=replay.tool_length_mm,
        title=settings.title,
        description=settings.description,
        quiet=args.quiet or args.json,
    )


def _near(folder: Path, name: str) -> Path:
    """Return a run's path, relative to the scenario's folder or else to the working folder."""
    path = Path(name).expanduser()
    return folder / path if (folder / path).is_file() else path
