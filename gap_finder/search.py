"""Options of the gap finder's search."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

MOST_ADDITIONS = 4
"""Default maximum number of additions; set on no data."""


@dataclass(frozen=True)
class Search:
    """Options of the gap finder's search.

    Attributes
    ----------
    without : sequence of str
        Effects to ignore.
    most : int
        Maximum number of additions.
    described : bool
        Whether the description may also be changed.
    seed : int
        Seed of the random starting points.
    workers : int or None
        Number of processes; None for one per core.
    """

    without: Sequence[str] = ()
    most: int = MOST_ADDITIONS
    described: bool = True
    seed: int = 0
    workers: int | None = None


USUAL = Search()
