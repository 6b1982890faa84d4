"""Another signal times a factor."""

from __future__ import annotations

from typing import Any, Literal

from scenarios.signals import build
from scenarios.signals.base import FloatArray, Setting, Signal, Value


class Scaled(Signal):
    """``kind = "scaled"``: *factor* times *signal*, a signal of any kind."""

    kind: Literal["scaled"]
    signal: Any
    factor: Value

    def values(self, time_s: FloatArray, setting: Setting) -> FloatArray:
        """Return the product at each time."""
        inside = setting.inside("signal")
        return self.factor * build(self.signal, inside).values(time_s, inside)

    @classmethod
    def place(cls, setting: Setting, table: dict[str, Any]) -> None:
        """Check the signal inside."""
        build(table["signal"], setting.inside("signal"))
