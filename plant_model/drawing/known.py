"""Numbers with a source and a range that depends on how they are known."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from plant_model.parameters import Parameter

CLASS = "class value: "
"""Start of the source of a number that the page leaves out."""

BY_DATA_SHEET = 0.15
"""Half range of a number from a data sheet or a plate, relative to it [1]: set on no
data."""


@dataclass(frozen=True)
class Known:
    """A number, its range, and the source of both.

    Attributes
    ----------
    value, low, high : float
        [unit].
    unit : str
    source : str
    free : bool
        Whether calibration may move it.
    """

    value: float
    low: float
    high: float
    unit: str
    source: str
    free: bool = False

    def scaled(self, factor: float) -> Known:
        """Return the number with its range, multiplied by a positive factor."""
        return replace(
            self, value=self.value * factor, low=self.low * factor, high=self.high * factor
        )

    def clipped(self, low: float, high: float) -> Known:
        """Return it with its range, and if necessary its value, limited to *low* and *high*."""
        value, bottom, top = (
            min(max(number, low), high) for number in (self.value, self.low, self.high)
        )
        return replace(self, value=value, low=bottom, high=top)

    def parameter(self) -> dict[str, Any]:
        """Return it as a parameter of a machine file."""
        numbers = self.value, self.unit, self.low, self.high
        return Parameter(*numbers, self.source, self.free).to_dict()


def exact(value: float, unit: str, source: str = "page") -> Known:
    """Return a number without a range."""
    return Known(value, value, value, unit, source)


def within(share: float, value: float, unit: str, source: str) -> Known:
    """Return a number with a symmetric relative range."""
    ends = sorted((value * (1.0 - share), value * (1.0 + share)))
    return Known(value, ends[0], ends[1], unit, source)
