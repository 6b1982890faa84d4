"""A new cold reference for a running gateway."""

from __future__ import annotations

import argparse
import json
import os
import signal
from pathlib import Path

NAME = "reference"
HELP = "tell a running gateway that the machine is cold now"
READS = ("state",)
WRITES: dict[str, str] = {}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument(
        "state", type=Path, metavar="STATE", help="the file that the gateway saves its state to"
    )


def run(args: argparse.Namespace) -> int:
    """Make the running gateway count the drift from now."""
    from measurement.errors import BadInput

    try:
        # A state file names the process that saved it.
        pid = int(json.loads(args.state.read_text(encoding="utf-8"))["pid"])
        command = Path(f"/proc/{pid}/cmdline").read_bytes()
    except (OSError, ValueError, KeyError, TypeError):
        raise BadInput(args.state, "", "was saved by no gateway that runs") from None
    # A killed gateway leaves its file behind, and its process number may be reused by now. Some
    # kernels show no command line.
    if command and b"gateway" not in command:
        raise BadInput(args.state, "", f"was saved by process {pid}, which is no gateway now")
    try:
        os.kill(pid, signal.SIGUSR1)
    except OSError as error:
        raise BadInput(args.state, "", f"process {pid} cannot be told: {error.strerror}") from None
    print("drift is counted from the next cycle; offsets go to zero without a ramp")
    return 0
