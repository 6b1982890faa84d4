"""``spindle-drift simulate``: simulate the run that a rig would measure, without FMUs."""

from __future__ import annotations

import argparse

from measurement.runs import write_run
from scenarios.arguments import add_output, add_parameters
from scenarios.outputs import RUN_FILE
from scenarios.scenario import read_scenario
from spindle_drift.machines import Machine, case_to_simulate, simulate

NAME = "simulate"
HELP = "simulate a machine over a scenario's speeds and write what a rig would measure"
READS = ("scenario", "machine")
WRITES = {"output": RUN_FILE}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument("scenario", metavar="SCENARIO", help="shipped name or scenario file")
    text = "machine file or shipped name (default: jig_borer)"
    parser.add_argument("--machine", default="jig_borer", help=text)
    add_output(parser, "run file to write")
    add_parameters(parser, simulate, "every_s")
    parser.add_argument("--seed", type=int, help="seed of the sensors' noise (default: scenario's)")
    parser.add_argument("--exact", action="store_true", help="leave out noise and resolution")


def run(args: argparse.Namespace) -> int:
    """Simulate the scenario's first variant and write the run file."""
    machine, scenario = Machine(args.machine), read_scenario(args.scenario)
    settings = case_to_simulate(scenario).settings
    seed = settings.seed if args.seed is None else args.seed
    simulated = simulate(
        machine,
        args.scenario,
        every_s=args.every_s,
        noise_seed=None if args.exact or not settings.plant.noise else seed,
    )
    path = write_run(simulated.frame, args.output)
    print(
        f"wrote {path}: {len(simulated.frame)} rows, {settings.duration_s / 3600.0:g} h of "
        f"{machine.model.title}"
    )
    return 0
