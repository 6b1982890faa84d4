"""What a hidden effect may do to the truth."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np
import pandas as pd
from numpy.typing import NDArray

if TYPE_CHECKING:
    from benchmarks.gap.truth.drive import Drive
    from benchmarks.gap.truth.spindle import Spindle

Array = NDArray[np.float64]
SIZES = ("weak", "medium", "strong")


class Now:
    """The machine at one instant of a run.

    Attributes
    ----------
    time, speed, torque : float
        [s, r/min, Nm]
    temperature : array, shape (cells,)
    draft, wobble : float
        Relative disturbances of the outer films and of friction.
    """

    def __init__(self, spindle: Spindle, drive: Drive, temperature: Array) -> None:
        self.spindle, self.drive = spindle, drive
        self.time, self.temperature = float(drive.time_s[0]), temperature
        self.speed = self.torque = 0.0
        self.draft = self.wobble = 0.0
        self._outside = drive.outside
        self._begin, self._step = float(drive.grid_s[0]), float(drive.grid_s[1] - drive.grid_s[0])

    def look_up(self) -> Array:
        """Return the boundary temperatures now, and put down the disturbances."""
        place = (self.time - self._begin) / self._step
        row = min(max(int(place), 0), len(self._outside) - 2)
        share = place - row
        values = self._outside[row] + share * (self._outside[row + 1] - self._outside[row])
        self.draft, self.wobble = float(values[3]), float(values[4])
        return np.asarray(values[:3])


class Hidden:
    """Base of everything that can be hidden in the truth; nothing happens by default.

    Attributes
    ----------
    size : float
        Its amplitude; at 0 the effect vanishes exactly.
    channel : str
        The sensor that it acts on, if it acts on one.
    """

    name: ClassVar[str]
    unit: ClassVar[str]
    sizes: ClassVar[tuple[float, float, float]]
    """Amplitudes called weak, medium and strong."""
    channels: ClassVar[tuple[str, ...]] = ()
    catalogued: ClassVar[bool] = True
    in_other_words: ClassVar[tuple[tuple[str, tuple[str, ...]], ...]] = ()
    """Changes of the machine's file, kind and place, that say the same; ``*`` is any part."""
    planned: ClassVar[bool] = True
    """Whether the plan of cases asks for it; what came later has a benchmark of its own."""

    def __init__(self, size: float, rng: np.random.Generator, channel: str = "") -> None:
        self.size, self.channel = float(size), channel
        self.more: dict[str, float] = {}
        """Its other numbers, for the answers file."""
        self.draw(rng)

    def draw(self, rng: np.random.Generator) -> None:
        """Choose the numbers besides the size."""

    def begin(self, spindle: Spindle, drive: Drive) -> None:
        """Forget the run before."""

    def friction(self, now: Now, viscous: Array, load: Array) -> tuple[Array, Array]:
        """Return the heat of every bearing [W], changed; rear bearings first."""
        return viscous, load

    def heat(self, now: Now, out: Array) -> None:
        """Add heat [W] to cells."""

    def scales(self, now: Now) -> dict[str, float]:
        """Return factors on groups of conductances."""
        return {}

    def boundaries(self, now: Now, values: Array) -> None:
        """Change the boundary temperatures, in place: air, hall, coolant inlet [degC]."""

    def advance(self, now: Now, step: float) -> None:
        """Step the effect's own states."""

    def move(self, spindle: Spindle, drive: Drive, temperatures: Array, pose: Array) -> None:
        """Change the pose in place, shape (rows, 6); temperatures are (rows, cells)."""

    def record(self, number: int, drive: Drive, shown: pd.DataFrame) -> None:
        """Change what the sensors show, in place; *number* counts the case's runs from 0."""


def lagged(time_s: Array, values: Array, tau_s: float) -> Array:
    """Return a first-order lag of *values*, in equilibrium at first, exact for ramps between."""
    out = np.empty_like(values)
    out[0] = state = float(values[0])
    for k in range(1, len(values)):
        h = float(time_s[k] - time_s[k - 1])
        decay = np.exp(-h / tau_s)
        slope = float(values[k] - values[k - 1]) / h
        # Response to a ramp: the lag follows it tau behind.
        ahead = float(values[k]) - slope * tau_s
        state = ahead + decay * (state - (float(values[k - 1]) - slope * tau_s))
        out[k] = state
    return out
