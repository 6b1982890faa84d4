"""The options of a scenario and of what runs in it, which more than one command has."""

from __future__ import annotations

import argparse
from pathlib import Path


def add_fmu_folder(parser: argparse.ArgumentParser) -> None:
    """Declare where FMUs are looked for, and put where they have to be built."""
    parser.add_argument(
        "--fmu-dir", type=Path, default=Path("dist"), metavar="DIR", help="where FMUs are (dist)"
    )


def add_scenario_options(parser: argparse.ArgumentParser) -> None:
    """Declare a scenario, its FMUs and the keys to set in it."""
    parser.add_argument("scenario", metavar="SCENARIO", help="a name from 'list', or a TOML file")
    add_fmu_folder(parser)
    parser.add_argument("--plant", metavar="FILE", help="another plant: an FMU or a machine file")
    parser.add_argument(
        "--compensator", metavar="FILE", help="another compensator: an FMU or a compensator file"
    )
    add_settings(parser)


def add_settings(parser: argparse.ArgumentParser) -> None:
    """Declare the keys of a scenario to set."""
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="set a key of the scenario, for example duration_s=3600 or signals.speed=6000",
    )
