"""What is missing can be the description itself: a part, a path or a start, and not a law."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from gap_finder.refit import CandidateFit
from gap_finder.selection import SelectionRound

if TYPE_CHECKING:
    from gap_finder.kinds.base import Change


@dataclass(frozen=True)
class NamedChange:
    """A change of the machine's description that was named.

    Attributes
    ----------
    change : Change
        Of its kind, and at its place.
    selection : SelectionRound
        Its ``one_of`` begins with this change's key.
    after : CandidateFit
        The machine with it and all that was added before.
    channel : str
        The one whose gap it explains, where it is not most of all.
    """

    change: Change
    selection: SelectionRound
    after: CandidateFit
    channel: str = ""

    @property
    def key(self) -> str:
        """What it is called among what is tried."""
        return self.change.key

    @property
    def rivals(self) -> list[dict[str, Any]]:
        """Other changes that the data cannot tell from this one."""
        others = [key for key in self.selection.one_of if key != self.key]
        return [{"name": key.partition(":")[0], "place": place_of(key)} for key in others]

    @property
    def or_else(self) -> list[dict[str, Any]]:
        """Changes of other kinds that the data cannot tell from this one."""
        return [one for one in self.rivals if one["name"] != self.change.name]

    def entry(self, after: CandidateFit) -> dict[str, Any]:
        """Return it as ``gap.json`` has it.

        Parameters
        ----------
        after : CandidateFit
            The machine with all changes, calibrated.
        """
        known = {one.name: one for one in after.calibration.parameters}
        change = self.change
        numbers = {
            number: {"value": one.value, "low": one.low, "high": one.high, "unit": one.unit}
            for number, name in change.parameters().items()
            if (one := known.get(name)) is not None
        }
        best = next(i for i, one in enumerate(self.selection.fits) if one is self.selection.best)
        same = [one["place"] for one in self.rivals if one["name"] == change.name]
        return {
            "name": change.name,
            "title": change.title,
            "place": list(change.place),
            "other_places": same,
            "or_else": self.or_else,
            "shows_in": self.channel,
            "parameters": numbers,
            "larger_than_usual": [],
            "probability": self.selection.probability[best],
            **change.told(after.machine),
        }


def key_of(name: str, place: tuple[str, ...]) -> str:
    """Return what a change is called among what is tried.

    Parameters
    ----------
    name : str
        The kind of change.
    place : tuple of str
        The parts, inputs, sensors or axes.
    """
    return f"{name}:{'+'.join(place)}"


def place_of(key: str) -> list[str]:
    """Return the place that a key names.

    Parameters
    ----------
    key : str
        As `key_of` gives it.
    """
    return key.partition(":")[2].split("+")
