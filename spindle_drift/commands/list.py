"""List the scenarios that come with the package."""

from __future__ import annotations

import argparse

from scenarios.arguments import add_json, tell

NAME = "list"
HELP = "list the scenarios"
READS = ()
WRITES: dict[str, str] = {}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    add_json(parser, "print JSON instead of a list")


def run(args: argparse.Namespace) -> int:
    """Print every scenario's name and title."""
    from scenarios.scenario import library, read_scenario

    scenarios = [read_scenario(path).settings for path in library()]
    table = [
        {
            "name": entry.name,
            "title": entry.title,
            "description": entry.description.strip(),
            "duration_s": None if entry.replay else entry.duration_s,
            "variants": [variant.name for variant in entry.variants],
        }
        for entry in scenarios
    ]
    width = max(len(entry.name) for entry in scenarios)
    return tell(args, table, *(f"{entry.name:<{width}}  {entry.title}" for entry in scenarios))
