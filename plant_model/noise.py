"""Random numbers of a stepped plant's sensor noise, the same in Python and in C.

Number i of a seed's sequence does not need the numbers before it. Two 64-bit words of SplitMix64
(Steele, Lea and Flood, OOPSLA 2014, doi:10.1145/2714064.2660195), at places 2 i + 1 and 2 i + 2
after a start that is itself the mixed seed, give two uniform numbers u and v in [0, 1) of 53 bits.
Then sqrt(-2 ln(1 - u)) cos(2 pi v) is normally distributed (Box and Muller, Ann. Math. Stat. 29
(1958) 610-611, doi:10.1214/aoms/1177706645). The C twin is ``native/c/noise.c``.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from plant_model.parameters import FloatArray

WEYL_STEP, WORD = 0x9E3779B97F4A7C15, 2**64 - 1
"""Increment of the state, and mask of a 64-bit word: given by SplitMix64."""
LARGEST_SEED = 2**31 - 1
"""Largest Integer, given by FMI."""


def _mixed(z: npt.NDArray[np.uint64]) -> npt.NDArray[np.uint64]:
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return np.asarray(z ^ (z >> np.uint64(31)))


class NormalSequence:
    """Normally distributed numbers, mean 0 and standard deviation 1.

    Parameters
    ----------
    seed : int
        0 to 2^32 - 1; the same seed gives the same numbers.
    count : int
        Number of values drawn at a time.

    Attributes
    ----------
    drawn : int
        Number of values drawn so far; it may be set.
    """

    def __init__(self, seed: int, count: int) -> None:
        self.drawn = 0
        start = np.array([seed * WEYL_STEP & WORD], dtype=np.uint64)
        self._begin = int(_mixed(start)[0])
        self._places = np.arange(1, 2 * count + 1, dtype=np.uint64) * np.uint64(WEYL_STEP)
        self._count = count

    def draw(self) -> FloatArray:
        """Return the next numbers, shape (count,)."""
        at = np.uint64((self._begin + 2 * self.drawn * WEYL_STEP) & WORD)
        even = (_mixed(at + self._places) >> np.uint64(11)) * 2.0**-53
        self.drawn += self._count
        return np.asarray(
            np.sqrt(-2.0 * np.log(1.0 - even[::2])) * np.cos(2.0 * np.pi * even[1::2])
        )
