"""Checks of the options and data given to an error model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from fmu_compensator.fit.error_models.base import Task
from measurement.errors import BadInput, shown

FEWEST_ROWS = 30
"""Fewest rows to fit a model of drift to: a quarter of an hour at 30 s. Set on no data."""


def refuse_unknown(kind: str, options: Mapping[str, Any], known: Sequence[str]) -> None:
    """Refuse an option that the model does not have.

    Parameters
    ----------
    kind : str
        Kind of the error model.
    options : mapping
        Those given that the model did not take.
    known : sequence of str
        All options of the model.

    Raises
    ------
    BadInput
        Names the first one.
    """
    if options:
        name = next(iter(options))
        raise BadInput(kind, name, f"is not a known option: {', '.join(known) or 'there is none'}")


def within(kind: str, name: str, value: Any, low: float, high: float) -> float:
    """Return a numeric option.

    Parameters
    ----------
    kind, name : str
        The error model and its option, for the message.
    value : object
        As given.
    low, high : float
        Allowed range, inclusive.

    Raises
    ------
    BadInput
        If it is not a number, or not between *low* and *high*.
    """
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        raise BadInput(kind, name, f"{shown(value)} is not allowed: {low:g} to {high:g}")
    return value


def whole(kind: str, name: str, value: Any, low: int, high: int) -> int:
    """Return an integer option; the parameters are those of `within`.

    Raises
    ------
    BadInput
        If it is not a whole number, or not between *low* and *high*.
    """
    number = within(kind, name, value, low, high)
    if number != int(number):
        raise BadInput(kind, name, f"{shown(value)} is not allowed: must be a whole number")
    return int(number)


def refuse_poor(task: Task) -> None:
    """Refuse data that no model can be fitted to: too few rows, constant inputs or targets.

    Parameters
    ----------
    task : Task
        Runs and names.

    Raises
    ------
    BadInput
        One line.
    """
    known = [run.at(run.known) for run in task.runs]
    rows = sum(len(run.time_s) for run in known)
    if rows < FEWEST_ROWS:
        problem = f"{rows} complete rows are too few: {FEWEST_ROWS} are needed"
        raise BadInput("training runs", "", problem)
    for names, column in ((task.input_names, "inputs"), (task.target_names, "targets")):
        span = np.ptp(np.concatenate([getattr(run, column) for run in known]), axis=0)
        for name, width in zip(names, span, strict=True):
            if width == 0.0:
                what = "is constant: leave it out" if column == "inputs" else "never changes"
                raise BadInput("training runs", name, what)
