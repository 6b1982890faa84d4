"""Logs that plug-ins read: one entry point per file extension."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path

import pandas as pd

from measurement.errors import BadInput
from measurement.importing.cells import Sheet
from measurement.importing.logs import cells_of_values, sheet_of
from measurement.plugins import IMPORTERS, PlugIn, plugged_in

EXCEL = (".xlsx", ".xlsm", ".xlsb", ".xls", ".ods")
LOGS = (".tdms", ".mf4", ".mdf")
TEXTS = (".csv", ".txt", ".tsv", ".dat", ".lvm")
"""Extensions of workbooks, logs and texts that the project reads itself."""
Reader = Callable[[Path], Mapping[str, pd.DataFrame]]
"""From a file to its tables by title; columns are named as in a text table, ``Speed [rpm]``."""


@cache
def importers() -> dict[str, PlugIn[Reader]]:
    """Return the plug-ins' readers by file extension, without the dot.

    Raises
    ------
    BadInput
        For a plug-in that is not a function, or whose extension the project reads itself.
    """
    shipped = [ending.removeprefix(".") for ending in (*EXCEL, *LOGS, *TEXTS)]
    return plugged_in(
        IMPORTERS, shipped, lambda plugin: "" if callable(plugin.thing) else "is no function"
    )


def read_plugged(path: Path) -> list[Sheet] | None:
    """Return the tables of a file that a plug-in reads; None if no plug-in does.

    Raises
    ------
    BadInput
        If the plug-in fails, or returns anything but frames by title.
    """
    plugin = importers().get(path.suffix.lower().removeprefix("."))
    if plugin is None:
        return None
    try:
        tables = plugin.thing(path)
    except BadInput:
        raise
    except Exception as error:  # third-party code may raise anything
        problem = f"cannot be read by {plugin.source}: {type(error).__name__}: {error}"
        raise BadInput(path, "", problem) from None
    if not isinstance(tables, Mapping) or not all(
        isinstance(frame, pd.DataFrame) for frame in tables.values()
    ):
        raise plugin.refuse("must return a mapping of title to pandas frame")
    return [
        sheet_of(
            path,
            str(title),
            [(str(name), "", cells_of_values(values)) for name, values in frame.items()],
        )
        for title, frame in tables.items()
        if len(frame)
    ]
