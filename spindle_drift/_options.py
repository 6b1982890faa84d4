"""The arguments for a scenario and its FMUs, which several commands share."""

from __future__ import annotations

import argparse

from scenarios.arguments import DIRECTORY, add_parameters
from spindle_drift.components import run_scenario

SETTINGS = {"flag": "--set", "action": "append", "default": [], "metavar": "KEY=VALUE"}


def add_fmu_folder(parser: argparse.ArgumentParser) -> None:
    """Declare the folder in which FMUs are looked for, and built if they are missing."""
    add_parameters(parser, run_scenario, fmu_dir=DIRECTORY)


def add_scenario(parser: argparse.ArgumentParser) -> None:
    """Declare a scenario, its FMUs and the keys to set in it."""
    add_parameters(parser, run_scenario, "scenario")
    add_fmu_folder(parser)
    add_parameters(parser, run_scenario, "plant", "compensator", settings=SETTINGS)
