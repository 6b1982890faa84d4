"""A value that changes linearly."""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import model_validator

from scenarios.signals.base import Duration, FloatArray, Seconds, Setting, Signal, Value


class Ramp(Signal):
    """``kind = "ramp"``: from *start* to *end* between *start_s* and *end_s*, level outside."""

    kind: Literal["ramp"]
    start: Value
    end: Value
    start_s: Seconds = 0.0
    end_s: Duration

    @model_validator(mode="after")
    def _fits(self) -> Ramp:
        if self.end_s <= self.start_s:
            raise ValueError(f"end_s, {self.end_s:g}, must be after start_s, {self.start_s:g}")
        return self

    def values(self, time_s: FloatArray, setting: Setting) -> FloatArray:
        """Return the value at each time."""
        return np.interp(time_s, [self.start_s, self.end_s], [self.start, self.end])
