"""Cells along the axis: cut at stretches' ends, centred on thermometers, of limited length."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import ceil

SHORTEST = 1.0
"""Shortest stretch [mm], given by the format of a page. No cell is shorter: a thermometer nearer
than this to a cut reads the cell next to it."""


@dataclass(frozen=True)
class Cell:
    """A slice of shaft or housing.

    Attributes
    ----------
    name : str
        Name of its node, without the sector.
    start, end : float
        Along the axis [mm].
    part : {"shaft", "housing"}
    stretch : int
        Position, within the part, of the stretch that it is cut from.
    """

    name: str
    start: float
    end: float
    part: str
    stretch: int

    @property
    def length(self) -> float:
        """[mm]."""
        return self.end - self.start

    @property
    def middle(self) -> float:
        """[mm]."""
        return (self.start + self.end) / 2.0


def overlap(cell: Cell, start: float, end: float) -> float:
    """Return the length of a span inside a cell [mm]."""
    return max(0.0, min(cell.end, end) - max(cell.start, start))


def cuts_between(start: float, end: float, read_at: Sequence[float], longest: float) -> list[float]:
    """Return the cuts from *start* to *end* [mm], including both.

    Parameters
    ----------
    start, end : float
        [mm].
    read_at : sequence of float
        Positions of thermometers [mm]; each becomes the middle of a cell.
    longest : float
        Greatest length of a cell [mm].
    """
    inside = sorted(at for at in set(read_at) if start + SHORTEST <= at <= end - SHORTEST)
    kept: list[float] = []
    for at in inside:
        if not kept or at - kept[-1] >= 2.0 * SHORTEST:
            kept.append(at)
    cuts = [start]
    for i, at in enumerate(kept):
        room = [longest / 2.0, at - start, end - at]
        room += [abs(at - other) / 2.0 for other in kept[max(0, i - 1) : i + 2] if other != at]
        half = min(room)
        cuts += [at - half, at + half]
    cuts.append(end)
    out = [start]
    for first, last in pairwise(cuts):
        if last - first > 1e-9:
            parts = max(1, ceil((last - first) / longest - 1e-9))
            out += [first + (last - first) * (k + 1) / parts for k in range(parts)]
    out[-1] = end
    return out


def slices(
    part: str,
    stretches: Sequence[tuple[float, float]],
    read_at: Sequence[float],
    edges: Sequence[float],
    longest: float,
) -> list[Cell]:
    """Return the cells of touching stretches, numbered from the first; also cut at *edges*."""
    cells: list[Cell] = []
    for which, (start, end) in enumerate(stretches):
        inside = {edge for edge in edges if start + SHORTEST <= edge <= end - SHORTEST}
        pieces = pairwise([start, *sorted(inside), end])
        cuts = [cut for piece in pieces for cut in cuts_between(*piece, read_at, longest)]
        for first, last in pairwise(sorted(set(cuts))):
            cells.append(Cell(f"{part}_{len(cells) + 1}", first, last, part, which))
    return cells
