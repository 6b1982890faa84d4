"""The signals of a scenario as an FMU: no inputs, one output per signal.

Each value holds until the next time, as in a scenario: a master that passes outputs on between
steps gives the plant the same inputs as `spindle-drift run`.
"""

from __future__ import annotations

import csv
from bisect import bisect_right
from collections.abc import Sequence
from typing import Any

from fmu_packaging.slave import DriftSlave
from fmu_packaging.variables import Variable

SIGNALS_FILE = "signals.csv"
"""The signals in the FMU's resources: ``time_s`` and one column ``name_unit`` per signal."""


class SignalsSlave(DriftSlave):
    """Plays a table of held values."""

    def declare(self) -> Sequence[Variable]:
        """Return one output per column of the table."""
        head, *rows = csv.reader(self.resource(SIGNALS_FILE).splitlines())
        self._times = [float(row[0]) for row in rows]
        self._rows = [[float(cell) for cell in row[1:]] for row in rows]
        return [_output(column) for column in head[1:]]

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._refs = list(self.refs.values())

    def begin(self) -> None:
        """Set the outputs to the values at the start."""
        self._show(self.time_s)

    def advance(self, time_s: float, step_s: float) -> None:
        """Set the outputs to the values at the end of the step, with a tolerance for rounding."""
        self._show(time_s + step_s + self.slack(step_s))

    def _show(self, time_s: float) -> None:
        row = self._rows[max(bisect_right(self._times, time_s) - 1, 0)]
        self.outputs.update(zip(self._refs, row, strict=True))


def _output(column: str) -> Variable:
    name, _, unit = column.rpartition("_")
    words = name.replace("_", " ").capitalize()
    return Variable(
        name,
        "real",
        "output",
        f"{words}, as the scenario has it",
        unit=unit,
        low=-1e9,
        high=1e9,
        depends_at_start=(),
    )
