"""Checks of the options and data given to an error model."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from inspect import signature
from typing import Any

import numpy as np

from fmu_compensator.fit.error_models.base import Task
from measurement.errors import BadInput, shown

FEWEST_ROWS = 30
"""Fewest rows to fit a model of drift to: a quarter of an hour at 30 s. Set on no data."""


def refuse_unknown(name: str, options: Iterable[str], function: Callable[..., Any]) -> None:
    """Refuse an option that a function does not have.

    Parameters
    ----------
    name : str
        What the options are of, for the message.
    options : iterable of str
        The names given.
    function : callable
        Its keyword-only parameters are the options.

    Raises
    ------
    BadInput
        Names the first one.
    """
    parameters = signature(function).parameters.values()
    known = [entry.name for entry in parameters if entry.kind is entry.KEYWORD_ONLY]
    for option in options:
        if option not in known:
            allowed = ", ".join(known) or "there is none"
            raise BadInput(name, option, f"is not a known option: {allowed}")


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
