"""The forms in which functions accept a run or a machine."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias, Union

import pandas as pd

from fmu_compensator.leaps import leap_lines_of
from fmu_compensator.signs import opposite_columns, sign_lines
from measurement.doubts import doubts, together
from measurement.errors import BadInput
from measurement.naming import distinct
from measurement.runs import Run
from measurement.runs import read_run as read_run_file

if TYPE_CHECKING:
    from spindle_drift.machines import Machine

RunLike: TypeAlias = Run | pd.DataFrame | str | Path
"""A run, a frame like one, or a run file."""
MachineLike: TypeAlias = Union[str, Path, "Machine"]
"""A machine, a machine file, or the name of a shipped machine."""


def as_run(given: RunLike, name: str = "run") -> Run:
    """Return a run from any accepted form; a frame is called ``attrs["name"]``, else *name*."""
    if isinstance(given, Run):
        return given
    if isinstance(given, pd.DataFrame):
        return Run(str(given.attrs.get("name", name)), given)
    return read_run_file(given)


def as_runs(given: RunLike | Sequence[RunLike]) -> list[Run]:
    """Return several runs; frames are called ``run_1``, ``run_2``, ...

    Runs with the same name also get their folder's name or a number, since results go by name.
    """
    if isinstance(given, (Run, pd.DataFrame, str, Path)):
        return [as_run(given)]
    runs = [as_run(entry, f"run_{number}") for number, entry in enumerate(given, 1)]
    if not runs:
        raise BadInput("runs", "", "none was given: at least one is needed")
    folders = [run.path.resolve().parent.name if run.path else "" for run in runs]
    names = distinct([run.name for run in runs], folders)
    return [
        run if run.name == name else replace(run, name=name)
        for run, name in zip(runs, names, strict=True)
    ]


class DoubtfulData(UserWarning):
    """A run contradicts a unit, the clock, a thermometer's place or a sign, or its drift leaps."""


def warn_of_doubts(runs: Sequence[Run]) -> None:
    """Warn the caller of a function of this package about what looks wrong in runs."""
    for run_doubt in together(doubts(runs)):
        names = ", ".join(run.name for run in runs)
        warnings.warn(f"{names}: {run_doubt.column} {run_doubt.text}", DoubtfulData, stacklevel=4)


def warn_of_drift(run: Run, judged: pd.DataFrame) -> None:
    """Warn the caller of a function of this package about opposite drift, and about leaps."""
    signs = sign_lines([(run.name, opposite_columns(judged))])
    for line in [*signs, *leap_lines_of(run, judged)]:
        warnings.warn(line, DoubtfulData, stacklevel=4)
