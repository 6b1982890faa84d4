"""Unknowns and what joins them: sparse conductances in named groups, so that one can be scaled."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import coo_matrix, csr_matrix

Array = NDArray[np.float64]
Index = NDArray[np.intp]


class Groups:
    """Collects heat capacities and conductances.

    Attributes
    ----------
    parts : dict of str to array of int
        The unknowns of every part.
    """

    def __init__(self) -> None:
        self.parts: dict[str, Index] = {}
        self._capacity: list[Array] = []
        self._size = 0
        self._inner: dict[str, list[coo_matrix]] = {}
        self._outer: dict[str, list[tuple[Index, Array]]] = {}

    @property
    def size(self) -> int:
        """How many unknowns there are so far."""
        return self._size

    @property
    def capacity(self) -> Array:
        """Heat capacity of every unknown [J/K]."""
        return np.concatenate(self._capacity)

    @property
    def names(self) -> list[str]:
        """Names of all groups."""
        return list(dict.fromkeys([*self._inner, *self._outer]))

    def add(self, part: str, capacity: ArrayLike) -> Index:
        """Add a part's unknowns with their heat capacities [J/K]; return their numbers."""
        values = np.atleast_1d(np.asarray(capacity, dtype=float))
        numbers = np.arange(self._size, self._size + len(values))
        self._capacity.append(values)
        self._size += len(values)
        self.parts[part] = numbers
        return numbers

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
        total = csr_matrix((self._size, self._size))
        for part in self._inner.get(group, []):
            part.resize(self._size, self._size)
            total = total + part.tocsr()
        return total

    def hall(self, group: str) -> Array:
        """Return heat into every unknown per kelvin of the hall [W/K]."""
        total = np.zeros(self._size)
        for numbers, conductance in self._outer.get(group, []):
            np.add.at(total, numbers, conductance)
        return total
