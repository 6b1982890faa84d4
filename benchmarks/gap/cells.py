"""Unknowns of one temperature each, collected part by part."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Index = NDArray[np.intp]


class Cells:
    """Collects heat capacities.

    Attributes
    ----------
    parts : dict of str to array of int
        The unknowns of every part, in the part's own shape.
    size : int
        How many unknowns there are so far.
    """

    def __init__(self) -> None:
        self.parts: dict[str, Index] = {}
        self.size = 0
        self._capacity: list[Array] = []

    @property
    def capacity(self) -> Array:
        """Heat capacity of every unknown [J/K]."""
        return np.concatenate(self._capacity)

    def add(self, part: str, capacity: ArrayLike) -> Index:
        """Add a part's unknowns with their heat capacities [J/K]; return their numbers."""
        values = np.atleast_1d(np.asarray(capacity, dtype=float))
        self.parts[part] = np.arange(self.size, self.size + values.size).reshape(values.shape)
        self._capacity.append(values.ravel())
        self.size += values.size
        return self.parts[part]
