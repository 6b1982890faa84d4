"""How the gap finder looks for what is missing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

MOST_ADDITIONS = 4
"""Additions at most, if the user sets no other limit; set on no data."""


@dataclass(frozen=True)
class Search:
    """How the gap finder looks for what is missing.

    Attributes
    ----------
    without : sequence of str
        Effects that are not to be considered.
    most : int
        Additions at most.
    described : bool
        Whether the description may be changed, and not only effects added.
    seed : int
        Of starting points.
    workers : int or None
        Processes; None: one for each core.
    """

    without: Sequence[str] = ()
    most: int = MOST_ADDITIONS
    described: bool = True
    seed: int = 0
    workers: int | None = None


USUAL = Search()
