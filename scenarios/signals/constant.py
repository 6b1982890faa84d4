"""A value that never changes."""

from __future__ import annotations

from typing import Literal

import numpy as np

from scenarios.signals.base import FloatArray, Setting, Signal, Value


class Constant(Signal):
    """``kind = "constant"``: always *value*. A bare number means the same."""

    kind: Literal["constant"]
    value: Value

    def values(self, time_s: FloatArray, setting: Setting) -> FloatArray:
        """Return the value, once per time."""
        return np.full(time_s.shape, float(self.value))
