"""``spindle-drift simulate``: the run that a rig would measure in a scenario, without FMUs."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas as pd

    from plant_model.machine import Machine
    from scenarios.scenario import Case

from scenarios.outputs import RUN_FILE

NAME = "simulate"
HELP = "simulate a machine over a scenario's speeds and write the run that a rig would measure"
READS = ("scenario", "machine")
WRITES = {"output": RUN_FILE}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument("scenario", metavar="SCENARIO", help="shipped name or scenario file")
    parser.add_argument(
        "--machine",
        default="jig_borer",
        help="machine file or shipped name (default: jig_borer)",
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        required=True,
        metavar="FILE",
        help="run file to write",
    )
    parser.add_argument(
        "--every", type=float, default=10.0, metavar="SECONDS", help="time between rows"
    )
    parser.add_argument("--seed", type=int, help="seed of the sensors' noise (default: scenario's)")
    parser.add_argument("--exact", action="store_true", help="leave out noise and resolution")


def run(args: argparse.Namespace) -> int:
    """Simulate the scenario's first variant and write the run file."""
    from measurement.errors import BadInput
    from measurement.runs import write_run
    from plant_model.drive import DriveError
    from plant_model.machine_file import read_machine
    from plant_model.parameters import ParameterError
    from plant_model.simulate import simulate
    from scenarios.scenario import MOST_STEPS, read_scenario

    machine = read_machine(args.machine)
    scenario = read_scenario(args.scenario)
    if not scenario.cases:
        raise BadInput(scenario.path, "replay", "nothing is simulated in a replay")
    case = scenario.cases[0]
    settings = case.settings
    if not 0.0 < args.every <= settings.duration_s:
        raise BadInput("--every", "", f"{args.every:g} is outside 0..{settings.duration_s:g} s")
    if settings.duration_s / args.every > MOST_STEPS:
        raise BadInput("--every", "", f"{args.every:g} s makes more than {MOST_STEPS} rows")
    seed = settings.seed if args.seed is None else args.seed
    if seed < 0:
        raise BadInput("--seed", "", f"{seed} is not allowed: 0 or more")
    inputs = inputs_of(case, machine, args.every)
    try:
        result = simulate(
            machine,
            inputs,
            # The FMU quotes names that hold a hyphen, as structured naming asks; both forms serve.
            {name.replace("'", ""): v for name, v in settings.plant.parameters.items()},
            noise_seed=None if args.exact or not settings.plant.noise else seed,
        )
    except (DriveError, ParameterError) as error:
        raise BadInput(scenario.path, "", str(error)) from None
    path = write_run(result.run_frame(), args.output)
    print(
        f"wrote {path}: {len(inputs)} rows, {settings.duration_s / 3600.0:g} h of {machine.title}"
    )
    return 0


def inputs_of(case: Case, machine: Machine, every_s: float) -> pd.DataFrame:
    """Return a scenario's signals as inputs of a machine, a row every *every_s* [s].

    Parameters
    ----------
    case : Case
        The variant of the scenario whose signals count.
    machine : Machine
        Signals for which it has no input are left out.
    every_s : float
        Between rows [s].

    Returns
    -------
    DataFrame
        ``time_s`` from 0 to the scenario's duration, and a column for each signal under its
        input's name.
    """
    import numpy as np
    import pandas as pd

    from scenarios.scenario import signal_setting

    rows = int(case.settings.duration_s / every_s + 1e-9) + 1
    time = np.arange(rows) * every_s
    names = {entry.name for entry in machine.inputs}
    columns = {
        name: signal.values(time, signal_setting(case.setting, name))
        for name, signal in case.signals.items()
        if name in names
    }
    return pd.DataFrame({"time_s": time, **columns})
