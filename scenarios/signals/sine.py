"""A value that oscillates."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from scenarios.signals.base import Duration, FloatArray, Setting, Signal, Value


class Sine(Signal):
    """``kind = "sine"``: mean + amplitude sin(2 pi t / period_s + phase_deg)."""

    kind: Literal["sine"]
    mean: Value = 0.0
    amplitude: Value
    period_s: Duration
    phase_deg: Annotated[float, Field(ge=-360.0, le=360.0)] = 0.0

    def values(self, time_s: FloatArray, setting: Setting) -> FloatArray:
        """Return the value at each time."""
        angle = 2.0 * np.pi * time_s / self.period_s + np.radians(self.phase_deg)
        return np.asarray(self.mean + self.amplitude * np.sin(angle))
