"""A value read from a run file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from measurement.errors import BadInput
from measurement.resampling import past_rounding
from measurement.runs import read_run
from measurement.units import UNITS, split_column
from scenarios.signals.base import FloatArray, Setting, Signal


class Table(Signal):
    """``kind = "table"``: the *column* of the run file *file*, relative to the scenario's folder.

    Time counts from its first row. Commands, for example a speed, hold until the next row;
    measured quantities are interpolated linearly. Outside the rows the nearest value holds.
    """

    kind: Literal["table"]
    file: Annotated[str, Field(min_length=1, max_length=4096)]
    column: Annotated[str, Field(min_length=1, max_length=200)]

    def values(self, time_s: FloatArray, setting: Setting) -> FloatArray:
        """Return the column at each time, counted from the run's first row."""
        path = setting.folder / Path(self.file).expanduser()
        run = read_run(path)
        if self.column not in run.frame.columns or self.column == "time_s":
            columns = ", ".join(name for name in run.frame.columns if name != "time_s")
            raise BadInput(
                setting.source,
                f"{setting.place}.column",
                f"{self.column!r} is not a column of {path}: {columns}",
            )
        values = run.frame[self.column].to_numpy(dtype=float)
        good = np.isfinite(values)
        if not good.any():
            raise BadInput(path, f"column {self.column}", "holds no value at all")
        moments, values = run.time_s[good], values[good]
        asked = run.time_s[0] + time_s
        if UNITS[split_column(self.column)[1]].switches:
            last = np.searchsorted(moments, past_rounding(asked), side="right") - 1
            return np.asarray(values[np.maximum(last, 0)])
        return np.asarray(np.interp(asked, moments, values))
