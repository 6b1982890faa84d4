"""What a hidden effect may do to this machine."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np
import pandas as pd
from numpy.typing import NDArray

if TYPE_CHECKING:
    from benchmarks.gap.belt.drive import Drive
    from benchmarks.gap.belt.machine import Machine
    from benchmarks.gap.belt.march import Now

Array = NDArray[np.float64]


class Hidden:
    """Base of everything that can be hidden; nothing happens by default.

    Attributes
    ----------
    size : float
        Its amplitude; at 0 the effect vanishes.
    channel : str
        The sensor that it acts on, if it acts on one.
    """

    name: ClassVar[str]
    unit: ClassVar[str]
    sizes: ClassVar[tuple[float, float, float]]
    """Amplitudes called weak, medium and strong."""
    channels: ClassVar[tuple[str, ...]] = ()
    catalogued: ClassVar[bool] = True

    def __init__(self, size: float, rng: np.random.Generator, channel: str = "") -> None:
        self.size, self.channel = float(size), channel
        self.more: dict[str, float] = {}
        """Its other numbers, for the answers file."""
        self.draw(rng)

    def draw(self, rng: np.random.Generator) -> None:
        """Choose the numbers besides the size."""

    def begin(self, machine: Machine, drive: Drive) -> None:
        """Forget the run before."""

    def friction(self, now: Now, viscous: Array, load: Array) -> tuple[Array, Array]:
        """Return the heat of the front and the rear set [W], changed."""
        return viscous, load

    def heat(self, now: Now, out: Array) -> None:
        """Add heat [W]."""

    def scales(self, now: Now) -> dict[str, float]:
        """Return factors on groups of conductances."""
        return {}

    def advance(self, now: Now, step: float) -> None:
        """Step the effect's own states."""

    def move(self, machine: Machine, drive: Drive, temperatures: Array, pose: Array) -> None:
        """Change the pose in place, shape (rows, 3); temperatures are (rows, unknowns)."""

    def record(self, number: int, machine: Machine, drive: Drive, shown: pd.DataFrame) -> None:
        """Change what the sensors show, in place; *number* counts the case's runs from 0."""
