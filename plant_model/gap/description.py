"""What is missing can be the description itself: a part, a path or a start, and not a law."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from plant_model.gap.judge import Judged
from plant_model.gap.refit import Explained


@dataclass(frozen=True)
class Described:
    """A change of the machine's description that was named.

    Attributes
    ----------
    name, title : str
        What kind of change.
    place : tuple of str
        The parts, inputs or sensors.
    judged : Judged
        Its ``one_of`` begins with this change's key.
    more : mapping of str to object
        What else a report says of it.
    parameter : str
        Full name of its parameter, where it has one that calibration moves.
    """

    name: str
    title: str
    place: tuple[str, ...]
    judged: Judged
    more: Mapping[str, Any] = field(default_factory=dict)
    parameter: str = ""

    @property
    def key(self) -> str:
        """What it is called among what is tried."""
        return key_of(self.name, self.place)

    @property
    def rivals(self) -> list[list[str]]:
        """Other places that the data cannot tell from this one."""
        return [place_of(key) for key in self.judged.one_of if key != self.key]

    def entry(self, after: Explained) -> dict[str, Any]:
        """Return it as ``gap.json`` has it."""
        numbers = {
            one.name.rpartition(".")[2]: {
                "value": one.value,
                "low": one.low,
                "high": one.high,
                "unit": one.unit,
            }
            for one in after.calibration.parameters
            if one.name == self.parameter
        }
        best = next(i for i, one in enumerate(self.judged.tried) if one is self.judged.best)
        return {
            "name": self.name,
            "title": self.title,
            "place": list(self.place),
            "other_places": self.rivals,
            "parameters": numbers,
            "larger_than_usual": [],
            "probability": self.judged.probability[best],
            **self.more,
        }


def key_of(name: str, place: tuple[str, ...]) -> str:
    """Return what a change is called among what is tried."""
    return f"{name}:{'+'.join(place)}"


def place_of(key: str) -> list[str]:
    """Return the place that a key names."""
    return key.partition(":")[2].split("+")
