"""Cells of one temperature and what joins them, collected part by part."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from benchmarks.gap.cells import Array, Cells, Index

AIR, HALL, INLET = range(3)
"""Boundary temperatures: air at the spindle, air at column and bed, coolant at the jackets."""
BOUNDARIES = 3


class Network(Cells):
    """A network whose conductances stand in named groups, so that a group can be scaled."""

    def __init__(self) -> None:
        super().__init__()
        self._links: dict[str, list[tuple[Index, Index, Array, bool]]] = {}
        self._outside: dict[str, list[tuple[Index, int, Array]]] = {}

    def join(self, group: str, one: ArrayLike, other: ArrayLike, conductance: ArrayLike) -> None:
        """Join cells pairwise [W/K]."""
        i, j, g = np.broadcast_arrays(one, other, conductance)
        self._links.setdefault(group, []).append((i.ravel(), j.ravel(), g.ravel(), False))

    def stream(self, group: str, path: Sequence[int] | Index, capacity_flow: float) -> None:
        """Let coolant flow from the inlet through the cells of *path* [W/K]."""
        path = np.asarray(path)
        self.boundary(group, path[:1], INLET, capacity_flow)
        flow = np.full(len(path) - 1, capacity_flow)
        self._links.setdefault(group, []).append((path[1:], path[:-1], flow, True))

    def boundary(self, group: str, cells: ArrayLike, which: int, conductance: ArrayLike) -> None:
        """Join cells to a boundary temperature [W/K]."""
        i, g = np.broadcast_arrays(cells, np.asarray(conductance, dtype=float))
        self._outside.setdefault(group, []).append((i.ravel(), which, g.ravel()))

    @property
    def groups(self) -> list[str]:
        """Names of all groups of conductances."""
        return list(dict.fromkeys([*self._links, *self._outside]))

    def surfaces(self, group: str) -> list[tuple[Index, int, Array]]:
        """Return cells, boundary and conductance of a group's outer surfaces."""
        return self._outside.get(group, [])

    def matrices(self, group: str) -> tuple[Array, Array]:
        """Return heat into every cell per kelvin of every cell and of every boundary [W/K]."""
        inner = np.zeros((self.size, self.size))
        outer = np.zeros((self.size, BOUNDARIES))
        for i, j, g, one_way in self._links.get(group, []):
            np.add.at(inner, (i, j), g)
            np.add.at(inner, (i, i), -g)
            if not one_way:
                np.add.at(inner, (j, i), g)
                np.add.at(inner, (j, j), -g)
        for i, which, g in self._outside.get(group, []):
            np.add.at(inner, (i, i), -g)
            np.add.at(outer, (i, np.full_like(i, which)), g)
        return inner, outer


def spread(starts: Array, ends: Array, low: float, high: float) -> Array:
    """Return the share of [low, high] that lies in each interval; the shares sum to 1 inside."""
    overlap = np.minimum(ends, high) - np.maximum(starts, low)
    return np.asarray(np.maximum(overlap, 0.0) / (high - low))
