"""One line of advice, and which of many are told."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

MOST = 6
"""Lines of a kind, and runners-up, at most, the worst first."""


@dataclass(frozen=True)
class Advice:
    """One thing that the description may lack.

    Attributes
    ----------
    kind : str
        ``heat_balance``, ``sensors_disagree``, ``far_from_usual``, ``worse_than_no_model``,
        ``worse_than_before``, ``not_moved`` or ``off_by_a_constant``.
    place : tuple of str
        The part, sensors, parameter or channel.
    text : str
        One line for a person.
    """

    kind: str
    place: tuple[str, ...]
    text: str


def worst_first(found: Sequence[tuple[float, Advice]]) -> list[Advice]:
    """Return the worst, no more than `MOST`.

    Parameters
    ----------
    found : sequence of (float, Advice)
        How bad each is, and what is told.
    """
    return [one for _, one in sorted(found, key=lambda pair: -pair[0])][:MOST]
