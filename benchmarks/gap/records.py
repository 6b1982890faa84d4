"""Records of a folder, each with the gap of the same machine and runs with nothing hidden."""

from __future__ import annotations

import json
import math
import statistics
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from benchmarks.gap.outcome import Group, groups_of, outcome, outcome_of_mistake
from benchmarks.gap.plan import EMPTY
from benchmarks.gap.truths import USUAL
from measurement.errors import BadInput

STRONG, VISIBLE = 2.0, 1.25
"""Least ratio to the gap with nothing hidden of a strong, and of a visible case [1]."""

CLASSES = ("strong", "visible", "faint", "unmeasured")
"""How strong a case is; the last if nothing tells its gap with nothing hidden."""


@dataclass(frozen=True)
class Record:
    """One question, its answer, and the truth.

    Attributes
    ----------
    table : dict
        The record as it was written.
    empty : float
        Gap after calibration on the held-out run with nothing hidden [1].
    matched : bool
        Whether that is for the same machine and runs; if not, it is the median of other cases.
    """

    table: dict[str, Any]
    empty: float
    matched: bool

    @property
    def name(self) -> str:
        """Name of the question."""
        return str(self.table["name"])

    @property
    def kind(self) -> str:
        """Kind of the question."""
        return str(self.table["kind"])

    @property
    def simulator(self) -> str:
        """Name of the simulator that made its runs."""
        return str(self.table.get("simulator", USUAL))

    @property
    def mistakes(self) -> list[dict[str, Any]]:
        """Deliberate mistakes in the machine's file: kind and place."""
        return list(self.table.get("mistakes", ()))

    @property
    def truth(self) -> list[dict[str, Any]]:
        """The hidden effects."""
        return list(self.table["truth"])

    @property
    def answer(self) -> dict[str, Any]:
        """The content of ``gap.json``."""
        return dict(self.table["answer"])

    @cached_property
    def groups(self) -> list[Group]:
        """Named effects."""
        return groups_of(self.answer, self.mistakes)

    @cached_property
    def outcome(self) -> str:
        """Right or wrong."""
        if self.kind == "mistake":
            return outcome_of_mistake(self.mistakes[0], self.answer)
        broken = {fault["channel"] for fault in self.answer.get("data_faults", ())}
        return outcome(self.kind, self.truth, self.groups, self.answer["verdict"], broken)

    @cached_property
    def in_doubt(self) -> bool:
        """Whether the answer is marked as in doubt."""
        remaining = self.answer.get("remaining", {})
        return bool(self.answer.get("in_doubt", remaining.get("above_tolerance", False)))

    @property
    def ratio(self) -> float:
        """Gap of the calibrated model, relative to that with nothing hidden [1]."""
        return float(self.answer["gap"]["holdout"]["before"]) / self.empty

    @property
    def strength(self) -> str:
        """One of `CLASSES`; what other cases leave says nothing about a file with a mistake."""
        if math.isnan(self.ratio) or (self.mistakes and not self.matched):
            return "unmeasured"
        if self.ratio >= STRONG:
            return "strong"
        return "visible" if self.ratio >= VISIBLE else "faint"

    @property
    def closed(self) -> float:
        """Share of the reducible gap on the held-out run that was closed [1].

        The reducible gap is the gap of the calibrated model minus that of the same machine and runs
        with nothing hidden.
        """
        gap = self.answer["gap"]["holdout"]
        return float((gap["before"] - gap["after"]) / (gap["before"] - self.empty))


def read_records(folder: Path) -> list[Record]:
    """Return the records of a folder, in order.

    Parameters
    ----------
    folder : Path

    Raises
    ------
    BadInput
        If there are none, or one cannot be read.
    """
    tables = _read_all(folder)
    empty = {
        table["number"]: float(table["answer"]["gap"]["holdout"]["before"])
        for table in tables
        if table["kind"] in (EMPTY, "none")
    }
    middle = statistics.median(empty.values()) if empty else float("nan")
    return [
        Record(table, empty.get(table["number"], middle), table["number"] in empty)
        for table in tables
        if table["kind"] != EMPTY
    ]


def _read_all(folder: Path) -> list[dict[str, Any]]:
    tables = [_read(path) for path in sorted(folder.glob("*.json"))]
    if not tables:
        raise BadInput(folder, "", "holds no record; benchmarks.gap.run writes them")
    return tables


def _read(path: Path) -> dict[str, Any]:
    try:
        table = json.loads(path.read_text())
        _ = table["number"], table["kind"], table["answer"]["gap"]
    except (ValueError, KeyError, TypeError) as error:
        raise BadInput(path, "", f"is not a record: {error}") from None
    return dict(table)
