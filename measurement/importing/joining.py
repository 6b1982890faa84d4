"""Joins tables into logs, end to end or side by side on one clock, without inventing rows."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd

from measurement.errors import BadInput
from measurement.importing.tables import Table
from measurement.runs import TIME

SAME_S = 1e-3
"""Rows of two tables within this time are one row [s], unless a single table has rows as close: set
on no data."""


@dataclass(frozen=True)
class Log:
    """Everything recorded on one clock.

    Attributes
    ----------
    name : str
    frame : DataFrame
        ``time_s`` first, then the signals; NaN where a table has no row.
    absolute : bool
        Whether time counts from 1970.
    sources : dict of str to str
        Header that each column came from.
    paths : tuple of Path
    """

    name: str
    frame: pd.DataFrame
    absolute: bool
    sources: dict[str, str]
    paths: tuple[Path, ...]


def joined(tables: Sequence[Table]) -> tuple[list[Log], list[str]]:
    """Join tables into logs, and return notes on the tables left out.

    Tables with the same columns are joined end to end; if the clock restarts in each, each is a
    separate log. Tables with other columns are joined side by side: every row stays, at its own
    time, and what the other tables did not record then is missing. If several tables of each kind
    each count from their own start, they are matched by name (`_paired`), and so is a time of day
    with a date.

    Raises
    ------
    BadInput
        If tables overlap, or their clocks are unrelated.
    """
    chains = _on_one_clock(_chains(tables))
    if chains[0][0].clock.absolute:
        return [_beside([_after_each_other(chain) for chain in chains])], []
    if len(chains) == 1:
        logs, notes = [_log(table) for table in chains[0]], list[str]()
    elif all(len(chain) == 1 for chain in chains):
        return [_beside([_log(chain[0]) for chain in chains])], []
    else:
        logs, notes = _paired(chains)
    logs.sort(key=lambda log: natural(log.name))
    names = padded([log.name for log in logs])
    return [replace(log, name=name) for log, name in zip(logs, names, strict=True)], notes


def _paired(chains: Sequence[Sequence[Table]]) -> tuple[list[Log], list[str]]:
    """Join tables of different columns side by side if they have the same name, in any file.

    A table's name is what distinguishes it from others with its columns: ``day 3`` of
    ``temperatures.xlsx`` goes with ``day 3`` of ``probe.xlsx``, ``t_day3.csv`` with ``d_day3.csv``.
    """
    groups: dict[tuple[str | int, ...], list[Table]] = {}
    for chain in chains:
        for key, table in zip(_keys(chain), chain, strict=True):
            groups.setdefault(key, []).append(table)
    pairs = [group for group in groups.values() if len(group) == len(chains)]
    if not pairs:
        names = " and ".join(_examples(chain) for chain in chains)
        problem = "count from different starts, have different columns and no name in common: "
        raise BadInput(names, "", problem + "import each run separately, with all its tables")
    lonely = [
        table.where for group in groups.values() if len(group) < len(chains) for table in group
    ]
    notes = [f"left out: {where}: no other table has its name" for where in lonely]
    logs = []
    for group in pairs:
        first = group[0].sheet
        log = _beside([_log(table) for table in group])
        logs.append(replace(log, name=first.title or first.path.stem))
    return logs, notes


def _keys(chain: Sequence[Table]) -> list[tuple[str | int, ...]]:
    """Return what distinguishes tables: the words and numbers that not all of their names share."""
    words = [_words(f"{table.sheet.path.stem}/{table.sheet.title}") for table in chain]
    if len(chain) == 1:
        return [_words(chain[0].sheet.title or chain[0].sheet.path.stem)]
    shortest = min(len(entry) for entry in words)
    start = next((n for n in range(shortest) if len({entry[n] for entry in words}) > 1), shortest)
    most = shortest - start
    end = next((n for n in range(most) if len({entry[-1 - n] for entry in words}) > 1), most)
    return [entry[start : len(entry) - end] for entry in words]


def _words(text: str) -> tuple[str | int, ...]:
    """Return the words and numbers of a name; ``Day 03`` is ``day 3``."""
    parts = re.findall(r"\d+|[^\W\d_]+", text.casefold())
    return tuple(int(part) if part.isdigit() else part for part in parts)


def _examples(chain: Sequence[Table]) -> str:
    more = f" (and {len(chain) - 1} more)" if len(chain) > 1 else ""
    return f"{chain[0].where}{more}"


def natural(name: str) -> list[tuple[bool, int, str]]:
    """Return a sort key for natural order: Sheet2 before Sheet10.

    >>> sorted(["Sheet10", "Sheet2", "Cover"], key=natural)
    ['Cover', 'Sheet2', 'Sheet10']
    """
    parts = re.findall(r"\d+|\D+", name.casefold())
    return [(part.isdigit(), int(part) if part.isdigit() else 0, part) for part in parts]


def padded(names: Sequence[str]) -> list[str]:
    """Return names with leading zeros in numbers, so that a shell also sorts them naturally.

    >>> padded(["Sheet2", "Sheet10"])
    ['Sheet02', 'Sheet10']
    """
    shape = [re.sub(r"\d+", "0", name) for name in names]
    width: dict[tuple[str, int], int] = {}
    for name, form in zip(names, shape, strict=True):
        for place, number in enumerate(re.findall(r"\d+", name)):
            width[form, place] = max(width.get((form, place), 0), len(number))

    def filled(name: str, form: str) -> str:
        places = iter(range(len(name)))
        return re.sub(r"\d+", lambda match: match[0].zfill(width[form, next(places)]), name)

    return [filled(name, form) for name, form in zip(names, shape, strict=True)]


def _chains(tables: Sequence[Table]) -> list[list[Table]]:
    """Return the tables grouped by columns, which may differ slightly from day to day."""
    chains: list[list[Table]] = []
    for table in tables:
        alike = (chain for chain in chains if _same_columns(table.sources, chain[0].sources))
        chain = next(alike, None)
        if chain is None:
            chains.append(chain := [])
        chain.append(table)
    return chains


def _same_columns(first: Mapping[str, str], second: Mapping[str, str]) -> bool:
    """Return whether both have most of their columns in common."""
    return 2 * len(first.keys() & second.keys()) > max(len(first), len(second))


def _on_one_clock(chains: Sequence[Sequence[Table]]) -> list[list[Table]]:
    """Return tables of times of day with the dates of a dated table of the same name.

    Raises
    ------
    BadInput
        If only some of them get dates.
    """
    named = [list(zip(_keys(chain), chain, strict=True)) for chain in chains]
    dated = {key: table for pairs in named for key, table in pairs if table.clock.absolute}
    only = next(iter(dated.values())) if len(dated) == 1 else None
    joined = []
    for pairs in named:
        other = only if len(pairs) == 1 else None
        joined.append([_on_its_day(table, dated.get(key, other)) for key, table in pairs])
    counting = [table for chain in joined for table in chain if not table.clock.absolute]
    if dated and counting:
        where = next(iter(dated.values())).where
        problem = f"counts from an unknown start, while {where} has dates"
        raise BadInput(counting[0].where, "", problem + ": they cannot be put on one clock")
    return joined


def _on_its_day(table: Table, dated: Table | None) -> Table:
    # With a known zone dates are in UTC, but a time of day is not.
    if dated is None or not table.clock.of_day or dated.clock.rule.timezone:
        return table
    return replace(table, clock=table.clock.on_day_of(dated.clock))


def _log(table: Table) -> Log:
    frame = table.frame.copy()
    frame.insert(0, TIME, table.clock.time_s)
    path = table.sheet.path
    name = f"{path.stem}_{table.sheet.title}" if table.sheet.title else path.stem
    return Log(name, frame, table.clock.absolute, dict(table.sources), (path,))


def _after_each_other(chain: Sequence[Table]) -> Log:
    """Return tables of the same columns joined in order of time."""
    logs = sorted((_log(table) for table in chain), key=lambda log: float(log.frame[TIME].iloc[0]))
    for before, after in pairwise(logs):
        if float(after.frame[TIME].iloc[0]) <= float(before.frame[TIME].iloc[-1]):
            problem = f"overlaps {before.paths[0].name} in time, with the same columns"
            raise BadInput(after.paths[0], "", problem)
    return _as_one(logs, pd.concat([log.frame for log in logs], ignore_index=True))


def _beside(logs: Sequence[Log]) -> Log:
    """Return logs of different columns joined on the union of their times."""
    if len(logs) == 1:
        return logs[0]
    before = set[str]()
    for log in logs:
        for name, header in log.sources.items():
            if name in before:
                problem = f"{name} is in another table, too: rename one in the mapping file"
                raise BadInput(log.paths[0], f"column {header}", problem)
            before.add(name)
    _overlapping(logs)
    clocks = [log.frame[TIME].to_numpy() for log in logs]
    closest = min(float(np.diff(clock).min(initial=np.inf)) for clock in clocks)
    same = min(SAME_S, closest / 2.0)
    every = np.unique(np.concatenate(clocks))
    fresh = np.diff(every, prepend=-np.inf) > same
    times = every[fresh]
    frame = pd.DataFrame({TIME: times})
    for log, clock in zip(logs, clocks, strict=True):
        rows = np.searchsorted(times, clock + same / 10.0, side="right") - 1
        for name in log.sources:
            values = np.full(len(times), np.nan)
            values[rows] = log.frame[name].to_numpy()
            frame[name] = values
    return _as_one(logs, frame)


def _as_one(logs: Sequence[Log], frame: pd.DataFrame) -> Log:
    sources = {name: header for log in logs for name, header in log.sources.items()}
    paths = tuple(path for log in logs for path in log.paths)
    return replace(logs[0], frame=frame, sources=sources, paths=paths)


def _overlapping(logs: Sequence[Log]) -> None:
    """Refuse tables that do not overlap in time: their clocks differ."""
    spans = [(float(log.frame[TIME].iloc[0]), float(log.frame[TIME].iloc[-1])) for log in logs]
    start, end = max(first for first, _ in spans), min(last for _, last in spans)
    if start > end:
        latest = logs[[first for first, _ in spans].index(start)]
        problem = "begins after another table has ended: their clocks seem to differ"
        raise BadInput(latest.paths[0], "", problem)
