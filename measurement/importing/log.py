"""Imports files of any recorder as runs: all steps in order."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from collections.abc import Mapping as Mapped
from dataclasses import dataclass, replace
from pathlib import Path

import pandas as pd

from measurement.doubts import Doubt, doubts
from measurement.errors import BadInput
from measurement.importing.cells import Sheet
from measurement.importing.joining import Log, joined
from measurement.importing.mapping import ColumnRule, Mapping, mapping_text
from measurement.importing.sheets import read_sheets
from measurement.importing.side_by_side import by_clock
from measurement.importing.splitting import Piece, split
from measurement.importing.tables import Table, axes_to_ask, fits, table_of
from measurement.naming import distinct
from measurement.runs import Run
from measurement.units import split_column


@dataclass(frozen=True)
class Imported:
    """The result of importing a log.

    Attributes
    ----------
    pieces : tuple of Piece
        The runs, each with how it began.
    mapping : Mapping
        The decisions made.
    hints : dict of str to str
        By header: columns that could not be identified, and how to include them.
    doubts : tuple of Doubt
        Column and what its numbers contradict.
    notes : tuple of str
        What was ignored, and notes on the tables.
    sources : dict of str to str
        Header that each column of the runs came from.
    asks : dict of str to str
        By header: displacements whose axis is unknown, and how to state it.
    """

    pieces: tuple[Piece, ...]
    mapping: Mapping
    hints: dict[str, str]
    doubts: tuple[Doubt, ...]
    notes: tuple[str, ...]
    sources: dict[str, str]
    asks: dict[str, str]

    @property
    def runs(self) -> list[Run]:
        """The runs, in order of time."""
        return [piece.run for piece in self.pieces]

    def mapping_text(self) -> str:
        """Return the mapping file's text, with hints and doubts as comments."""
        # One remark a column: why it is left out, else the first doubt, else what is asked.
        doubtful = {self.sources.get(c, ""): f"doubtful: {text}" for c, text in self.doubts[::-1]}
        return mapping_text(self.mapping, self.asks | doubtful | self.hints)


def import_files(
    paths: Iterable[Path],
    mapping: Mapping | None = None,
    units: Mapped[str, str] | None = None,
    axes: Mapped[str, str] | None = None,
) -> Imported:
    """Read logs and make runs from them.

    Parameters
    ----------
    paths : iterable of Path
        Text tables, workbooks or logs. Tables with the same columns are joined end to end, others
        side by side on one clock.
    mapping : Mapping, optional
        Decisions of an earlier import.
    units : mapping of str to str, optional
        Units by header (``*`` and ``?`` allowed), for columns whose header has none.
    axes : mapping of str to str, optional
        Axes of displacements by header (``*`` and ``?`` allowed): ``X``, ``-Z``.

    Returns
    -------
    Imported
        The runs, the decisions made, and what is doubtful.

    Raises
    ------
    BadInput
        For the first error, or if no column could be identified.
    """
    mapping, units, axes = mapping or Mapping(), units or {}, axes or {}
    sheets = [
        part
        for path in _once(paths)
        for sheet in read_sheets(path)
        for part in by_clock(sheet, mapping.time.columns)
    ]
    if not sheets:
        raise BadInput("import", "files", "none was given: at least one is needed")
    for option, patterns in (("--unit", units), ("--axis", axes)):
        for pattern in patterns:
            _need_header(sheets, option, (pattern,))
    if mapping.time.columns:
        _need_header(sheets, "time", mapping.time.columns)
    tables = [table_of(sheet, mapping, units, axes) for sheet in sheets]
    _need_signals(tables)
    logs, lonely = joined([table for table in tables if len(table.frame.columns)])
    sources = {column: header for log in logs for column, header in log.sources.items()}
    pieces: list[Piece] = []
    folders: list[str] = []
    notes = [f"{table.where}: {note}" for table in tables for note in _said(table)] + lonely
    for log in logs:
        split_off, left_out = split(log, mapping)
        pieces += split_off
        folders += len(split_off) * [log.paths[0].resolve().parent.name]
        notes += [*left_out, *_sparse(log, split_off, mapping)]
    notes += _speeds(sources)
    placed = {header for table in tables for header in table.rules.keys() - table.hints.keys()}
    hints: dict[str, str] = {}
    asks: dict[str, str] = {}
    for table in tables:
        for header, text in table.hints.items():
            if header in placed:
                notes.append(f"{table.where}: column {header} {text}")
            else:
                hints[header] = text
        rules = {name: rule for name, rule in table.rules.items() if name not in table.hints}
        for header in axes_to_ask(rules):
            says = f"--axis '{header}=X' says it (or Y, Z; -X if it rises towards -X)"
            asks[header] = f"which axis? {says}"
    names = distinct([piece.run.name for piece in pieces], folders)
    runs = [replace(piece.run, name=name) for piece, name in zip(pieces, names, strict=True)]
    return Imported(
        tuple(replace(piece, run=run) for piece, run in zip(pieces, runs, strict=True)),
        _decided(tables, mapping),
        hints,
        tuple(doubts(runs)),
        tuple(notes),
        sources,
        asks,
    )


def _once(paths: Iterable[Path]) -> Iterator[Path]:
    """Give the files, and refuse one that is given twice."""
    before = set()
    for path in map(Path, paths):
        if path.resolve() in before:
            raise BadInput(path, "", "is given twice")
        before.add(path.resolve())
        yield path


def _need_signals(tables: Sequence[Table]) -> None:
    if not any(len(table.frame.columns) for table in tables):
        header, text = next(
            ((h, t) for table in tables for h, t in table.hints.items()), ("", "only time")
        )
        place = f"column {header}" if header else ""
        raise BadInput(tables[0].where, place, f"no column can be placed: {text}")


def _need_header(sheets: Sequence[Sheet], option: str, patterns: Sequence[str]) -> None:
    headers = {entry.text for sheet in sheets for entry in sheet.headings}
    if not any(fits(header, pattern) for header in headers for pattern in patterns):
        names, wanted = ", ".join(sorted(headers)), " or ".join(map(repr, patterns))
        raise BadInput(option, "", f"no column is called {wanted}: {names}")


def _said(table: Table) -> list[str]:
    notes = [*table.sheet.notes, *table.notes]
    if table.clock.shared:
        count = table.clock.shared
        shared = f"{count} rows share the previous row's time stamp"
        notes.append(f"{shared} and are spread over the interval")
    return notes


def _sparse(log: Log, pieces: Sequence[Piece], mapping: Mapping) -> list[str]:
    signals = (piece.run.frame.dropna(axis=1, how="all") for piece in pieces)
    share = float(pd.concat([frame.isna().any(axis=1) for frame in signals]).mean())
    if len(set(log.paths)) < 2 or share < 0.5 or mapping.every_s:
        return []
    text = f"{100 * share:.0f} % of the rows lack a value because the tables' clocks differ"
    return [f"{text}; --every SECONDS puts them on one grid"]


def _speeds(sources: Mapped[str, str]) -> list[str]:
    """Return a note that commands use none of several speeds."""
    several = [header for name, header in sources.items() if split_column(name)[1] == "rpm"]
    if len(several) < 2 or "speed_rpm" in sources:
        return []
    named = ", ".join(several)
    return [f'no speed is known: name = "speed" in the mapping file says which it is of {named}']


def _decided(tables: Sequence[Table], mapping: Mapping) -> Mapping:
    """Return the mapping with everything that was detected."""
    columns: dict[str, ColumnRule] = {}
    for table in tables:
        # A table with values for a column takes precedence over one without.
        columns |= {
            header: rule
            for header, rule in table.rules.items()
            if header not in columns or header not in table.hints
        }
    times = list(dict.fromkeys(name for table in tables for name in table.clock.rule.columns))
    same = {table.clock.rule.unit for table in tables}
    rule = tables[0].clock.rule.model_copy(
        update={"columns": times, "unit": same.pop() if len(same) == 1 else ""}
    )
    return mapping.model_copy(update={"time": rule, "columns": mapping.columns | columns})
