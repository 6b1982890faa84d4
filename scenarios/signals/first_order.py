"""A value that approaches another exponentially."""

from __future__ import annotations

from typing import Literal

import numpy as np

from scenarios.signals.base import Duration, FloatArray, Seconds, Setting, Signal, Value


class FirstOrder(Signal):
    """``kind = "first_order"``: from *start_s* on, *start* + (*end* - *start*) (1 - exp(-t/tau)).

    tau is *time_constant_s*: 63 % of the change is reached after one of them, 95 % after three.
    """

    kind: Literal["first_order"]
    start: Value
    end: Value
    time_constant_s: Duration
    start_s: Seconds = 0.0

    def values(self, time_s: FloatArray, setting: Setting) -> FloatArray:
        """Return the value at each time."""
        elapsed = np.maximum(time_s - self.start_s, 0.0)
        left = np.expm1(-elapsed / self.time_constant_s)
        return np.asarray(self.start - (self.end - self.start) * left)
