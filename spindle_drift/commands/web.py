"""``spindle-drift web``: write a web page in which a machine and its compensator run live."""

from __future__ import annotations

import argparse
from pathlib import Path

from scenarios.arguments import add_json, add_output, tell
from scenarios.outputs import PAGE, check_output

NAME = "web"
READS = ("machine", "compensator")
WRITES = {"output": PAGE}
HELP = "write a web page that runs a machine and its compensator live"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument("machine", metavar="MACHINE", help="page, machine file or shipped name")
    parser.add_argument("compensator", type=Path, metavar="COMPENSATOR", help="compensator file")
    add_output(parser, "page to write", default="spindle.html")
    add_json(parser, "print JSON instead of a sentence")


def run(args: argparse.Namespace) -> int:
    """Compile both and write the page."""
    from plant_model.machine_file import read_machine
    from scenarios.pages.web_page import write_web_page

    check_output(args.output, PAGE)
    sizes = write_web_page(read_machine(args.machine), args.compensator, args.output)
    size = f"{args.output.stat().st_size / 1024:.0f} KiB"
    return tell(
        args,
        {"page": str(args.output), **sizes},
        f"wrote {args.output}: {size}, open it in a browser",
    )
