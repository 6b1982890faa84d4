"""The entry point of ``spindle-drift``: Ctrl-C ends it quietly from the first import on."""

from __future__ import annotations

import sys

from scenarios.version import PROGRAM


def main() -> int:
    """Import the command line, run it and return the exit code."""
    try:
        from scenarios.cli import main as command_line

        return command_line()
    except KeyboardInterrupt:
        return interrupted()


def interrupted() -> int:
    """Report that the program was interrupted and return the exit code, as a shell does."""
    print(f"{PROGRAM}: error: interrupted: what was not finished is removed", file=sys.stderr)
    return 130
