"""The run that find-gap proposes next, as a scenario file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import tomlkit

from gap_finder.further_run import HOURS
from gap_finder.report import MACHINE_AFTER

NEXT_RUN = "next_run.toml"


def next_run_scenario(table: Mapping[str, Any]) -> str:
    """Return the scenario file of the run that would tell the named explanations apart.

    Parameters
    ----------
    table : mapping
        Content of ``gap.json``; its ``next_run`` is not None.
    """
    run = table["next_run"]
    signals: dict[str, Any] = dict(run["held"])
    for name, stretches in run["stretches"].items():
        starts, values = zip(*stretches, strict=True)
        signals[name] = {"kind": "steps", "times_s": list(starts), "values": list(values)}
    scenario = {
        "format": 1,
        "name": "next_run",
        "title": f"The run to make next: {run['profile']}",
        "description": (
            f"Tells apart: {', '.join(table['one_of_keys'])}. {table['separate_by']}. The hall and"
            " the coolant are those of the runs so far; record what they really are. Give the"
            " recorded run to find-gap beside the others."
        ),
        "duration_s": 3600.0 * HOURS,
        "plant": {"fmu": MACHINE_AFTER},
        "signals": signals | {"tool_length": 0.0},
    }
    return tomlkit.dumps(scenario)
