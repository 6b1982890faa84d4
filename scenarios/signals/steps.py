"""A value that jumps at given times and is constant in between."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from measurement.resampling import past_rounding
from scenarios.signals.base import Duration, FloatArray, Seconds, Setting, Signal, Value


class Steps(Signal):
    """``kind = "steps"``: at each of *times_s* the value jumps to the matching one of *values*.

    Before the first time, the first value applies. With *repeat_s* the whole pattern repeats after
    that many seconds.
    """

    kind: Literal["steps"]
    times_s: Annotated[list[Seconds], Field(min_length=1, max_length=100_000)]
    levels: Annotated[list[Value], Field(min_length=1, max_length=100_000, alias="values")]
    repeat_s: Duration | None = None

    @model_validator(mode="after")
    def _fits(self) -> Steps:
        if len(self.times_s) != len(self.levels):
            raise ValueError(
                f"{len(self.times_s)} times_s and {len(self.levels)} values: as many are needed"
            )
        if any(b <= a for a, b in zip(self.times_s, self.times_s[1:], strict=False)):
            raise ValueError("times_s must increase")
        if self.repeat_s is not None and self.times_s[-1] >= self.repeat_s:
            raise ValueError(
                f"the last of times_s, {self.times_s[-1]:g}, must lie before "
                f"repeat_s, {self.repeat_s:g}"
            )
        return self

    def values(self, time_s: FloatArray, setting: Setting) -> FloatArray:
        """Return the level at each time."""
        moments = past_rounding(time_s)
        if self.repeat_s is not None:
            moments = np.mod(moments, self.repeat_s)
        index = np.searchsorted(np.asarray(self.times_s), moments, side="right") - 1
        return np.asarray(self.levels, dtype=float)[np.maximum(index, 0)]
