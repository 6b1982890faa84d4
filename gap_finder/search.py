"""How the gap finder looks for what is missing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

MOST_EFFECTS = 2
"""Effects added at most, if the user sets no other limit: what is left of a strong effect is its
law being not quite the machine's, and looks like others."""

MOST_CHANGES = 6
"""Changes of the description made at most, if the user sets no other limit."""


@dataclass(frozen=True)
class Search:
    """How the gap finder looks for what is missing.

    Attributes
    ----------
    without : sequence of str
        Effects that are not to be considered.
    most : int
        Changes of the description made at most, one after another.
    most_effects : int
        Effects added at most, one after another; at least 1.
    seed : int
        Of starting points and of the runs drawn with nothing missing.
    workers : int or None
        Processes; None: one for each core.
    """

    without: Sequence[str] = ()
    most: int = MOST_CHANGES
    most_effects: int = MOST_EFFECTS
    seed: int = 0
    workers: int | None = None


USUAL = Search()
