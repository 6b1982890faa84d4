"""The sum of several signals."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from scenarios.signals import build
from scenarios.signals.base import FloatArray, Setting, Signal


class Sum(Signal):
    """``kind = "sum"``: the sum of *parts*, each a signal of any kind."""

    kind: Literal["sum"]
    parts: Annotated[list[Any], Field(min_length=1, max_length=20)]

    def values(self, time_s: FloatArray, setting: Setting) -> FloatArray:
        """Return the sum at each time."""
        total = np.zeros(time_s.shape)
        for i, part in enumerate(self.parts):
            inside = setting.inside(f"parts.{i}")
            total += build(part, inside).values(time_s, inside)
        return total

    @classmethod
    def place(cls, setting: Setting, table: dict[str, Any]) -> None:
        """Check every part."""
        for i, part in enumerate(table["parts"]):
            build(part, setting.inside(f"parts.{i}"))
