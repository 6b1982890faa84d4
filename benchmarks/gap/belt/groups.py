"""Unknowns and what joins them: sparse conductances in named groups, so that one can be scaled."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import coo_matrix, csr_matrix

from benchmarks.gap.cells import Array, Cells, Index


class Groups(Cells):
    """Collects heat capacities and conductances."""

    def __init__(self) -> None:
        super().__init__()
        self._inner: dict[str, list[coo_matrix]] = {}
        self._outer: dict[str, list[tuple[Index, Array]]] = {}

    @property
    def names(self) -> list[str]:
        """Names of all groups."""
        return list(dict.fromkeys([*self._inner, *self._outer]))

    def solid(self, group: str, numbers: Index, matrix: csr_matrix) -> None:
        """Add a conduction matrix [W/K] (positive definite) of a part's unknowns."""
        found = matrix.tocoo()
        self._put(group, numbers[found.row], numbers[found.col], -found.data)

    def join(self, group: str, one: ArrayLike, other: ArrayLike, conductance: ArrayLike) -> None:
        """Join unknowns pairwise [W/K]."""
        i, j, g = (np.ravel(x) for x in np.broadcast_arrays(one, other, conductance))
        rows, columns = np.concatenate([i, j, i, j]), np.concatenate([j, i, i, j])
        self._put(group, rows, columns, np.concatenate([g, g, -g, -g]))

    def to_hall(self, group: str, numbers: ArrayLike, conductance: ArrayLike) -> None:
        """Join unknowns to the hall's air [W/K]."""
        i, g = (np.ravel(x) for x in np.broadcast_arrays(numbers, np.asarray(conductance, float)))
        self._put(group, i, i, -g)
        self._outer.setdefault(group, []).append((i, g))

    def _put(self, group: str, rows: Index, columns: Index, data: Array) -> None:
        self._inner.setdefault(group, []).append(coo_matrix((data, (rows, columns))))

    def matrix(self, group: str) -> csr_matrix:
        """Return heat into every unknown per kelvin of every unknown [W/K]."""
        total = csr_matrix((self.size, self.size))
        for part in self._inner.get(group, []):
            part.resize(self.size, self.size)
            total = total + part.tocsr()
        return total

    def hall(self, group: str) -> Array:
        """Return heat into every unknown per kelvin of the hall [W/K]."""
        total = np.zeros(self.size)
        for numbers, conductance in self._outer.get(group, []):
            np.add.at(total, numbers, conductance)
        return total
