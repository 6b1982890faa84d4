"""What functions take in place of a run or a machine."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias, Union

import pandas as pd

from measurement.runs import Run
from measurement.runs import read_run as read_run_file

if TYPE_CHECKING:
    from spindle_drift.machines import Machine

RunLike: TypeAlias = Run | pd.DataFrame | str | Path
"""A run, a frame like one, or a run file."""
MachineLike: TypeAlias = Union[str, Path, "Machine"]
"""A machine, a machine file, or the name of a shipped machine."""


def as_run(given: RunLike, name: str = "run") -> Run:
    """Return a run, whatever form it has; *name* is that of a frame."""
    if isinstance(given, Run):
        return given
    return Run(name, given) if isinstance(given, pd.DataFrame) else read_run_file(given)


def as_runs(given: RunLike | Sequence[RunLike]) -> list[Run]:
    """Return several runs; frames are called ``run_1``, ``run_2``, ..."""
    if isinstance(given, (Run, pd.DataFrame, str, Path)):
        return [as_run(given)]
    return [as_run(one, f"run_{number}") for number, one in enumerate(given, 1)]


def usual(command: str, option: str) -> Any:
    """Return what a command takes for an option that is not given."""
    parser = argparse.ArgumentParser(add_help=False)
    import_module(f"scenarios.commands.{command}").add_arguments(parser)
    return parser.get_default(option)
