"""``spindle-drift control``: the compensator as a component in C for LinuxCNC."""

from __future__ import annotations

import argparse
from pathlib import Path

from scenarios.outputs import PROGRAM

NAME = "control"
HELP = "build a compensator as a component in C for LinuxCNC"
READS = ("compensator",)
WRITES = {"build": PROGRAM}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    add = parser.add_argument
    text = "a compensator file (the one that ships)"
    add("--compensator", type=Path, metavar="FILE", help=text)
    add("--build", type=Path, metavar="PROGRAM", required=True, help="the component to build")


def run(args: argparse.Namespace) -> int:
    """Build the component."""
    from gateway.linuxcnc.native_component import build_component
    from scenarios.building import DEFAULT_MODEL

    build_component(args.compensator or DEFAULT_MODEL, args.build)
    return 0
