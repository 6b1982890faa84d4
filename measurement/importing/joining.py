"""Several tables as logs: one after the other, or side by side on one clock; no row is invented."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd

from measurement.errors import BadInput
from measurement.importing.tables import Table
from measurement.runs import TIME

SAME_S = 1e-3
"""Rows of two tables within this time are one row [s]."""


@dataclass(frozen=True)
class Log:
    """Everything that was recorded on one clock.

    Attributes
    ----------
    name : str
    frame : DataFrame
        ``time_s`` first, then the signals; NaN where a table has no row.
    absolute : bool
        Whether time counts since 1970.
    sources : dict of str to str
        For each column the header that it came from.
    paths : tuple of Path
    """

    name: str
    frame: pd.DataFrame
    absolute: bool
    sources: dict[str, str]
    paths: tuple[Path, ...]


def joined(tables: Sequence[Table]) -> list[Log]:
    """Join tables into logs.

    Tables with the same columns follow each other; where their clocks start anew in each, each is a
    log of its own. Tables with other columns stand side by side: every row of each stays, at its
    own time, and what the other tables did not record then is missing.

    Raises
    ------
    BadInput
        If tables overlap, or their clocks have nothing to do with each other.
    """
    chains: list[list[Table]] = []
    for table in tables:
        same = [chain for chain in chains if set(chain[0].frame) == set(table.frame)]
        if same:
            same[0].append(table)
        else:
            chains.append([table])
    _one_kind_of_clock(tables)
    if tables[0].clock.absolute:
        return [_beside([_after_each_other(chain) for chain in chains])]
    lengths = {len(chain) for chain in chains}
    if len(chains) > 1 and lengths != {1}:
        names = ", ".join(table.where for table in tables)
        problem = "count from a start of their own and have different columns: import those of a "
        raise BadInput(names, "", problem + "run together, each run by itself")
    if len(chains) == 1:
        return [_log(table) for table in chains[0]]
    return [_beside([_log(chain[0]) for chain in chains])]


def _one_kind_of_clock(tables: Sequence[Table]) -> None:
    first = tables[0]
    for table in tables[1:]:
        if table.clock.absolute != first.clock.absolute:
            dated, counting = (first, table) if first.clock.absolute else (table, first)
            problem = f"counts from a start that nobody knows, while {dated.where} has dates"
            raise BadInput(counting.where, "", problem + ": they cannot be put on one clock")


def _log(table: Table) -> Log:
    frame = table.frame.copy()
    frame.insert(0, TIME, table.clock.time_s)
    path = table.sheet.path
    name = f"{path.stem}_{table.sheet.title}" if table.sheet.title else path.stem
    return Log(name, frame, table.clock.absolute, dict(table.sources), (path,))


def _after_each_other(chain: Sequence[Table]) -> Log:
    """Return tables of the same columns as one, in order of time."""
    logs = sorted((_log(table) for table in chain), key=lambda log: float(log.frame[TIME].iloc[0]))
    for before, after in pairwise(logs):
        if float(after.frame[TIME].iloc[0]) <= float(before.frame[TIME].iloc[-1]):
            problem = f"overlaps {before.paths[0].name} in time, with the same columns"
            raise BadInput(after.paths[0], "", problem)
    frame = pd.concat([log.frame for log in logs], ignore_index=True)
    paths = tuple(path for log in logs for path in log.paths)
    return Log(logs[0].name, frame, logs[0].absolute, logs[0].sources, paths)


def _beside(logs: Sequence[Log]) -> Log:
    """Return logs of different columns as one, on the union of their times."""
    if len(logs) == 1:
        return logs[0]
    sources: dict[str, str] = {}
    for log in logs:
        for name, header in log.sources.items():
            if name in sources:
                problem = f"{name} is in another table, too: rename one in the mapping file"
                raise BadInput(log.paths[0], f"column {header}", problem)
            sources[name] = header
    _overlapping(logs)
    every = np.unique(np.concatenate([log.frame[TIME].to_numpy() for log in logs]))
    fresh = np.diff(every, prepend=-np.inf) > SAME_S
    times = every[fresh]
    frame = pd.DataFrame({TIME: times})
    for log in logs:
        rows = np.searchsorted(times, log.frame[TIME].to_numpy() + SAME_S / 10.0, side="right") - 1
        for name in log.sources:
            values = np.full(len(times), np.nan)
            values[rows] = log.frame[name].to_numpy()
            frame[name] = values
    paths = tuple(path for log in logs for path in log.paths)
    return Log(logs[0].name, frame, logs[0].absolute, sources, paths)


def _overlapping(logs: Sequence[Log]) -> None:
    """Refuse tables that have no time in common: their clocks are not the same."""
    spans = [(float(log.frame[TIME].iloc[0]), float(log.frame[TIME].iloc[-1])) for log in logs]
    start, end = max(first for first, _ in spans), min(last for _, last in spans)
    if start > end:
        latest = logs[[first for first, _ in spans].index(start)]
        problem = "begins after another table has ended: their clocks are not the same, it seems"
        raise BadInput(latest.paths[0], "", problem)
