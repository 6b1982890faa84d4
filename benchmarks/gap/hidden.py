"""Base class of the effects that a simulator can hide, and the effects common to all simulators.

Each simulator has its own laws of heat and structure, so that they share no mistakes. This module
only has the form of an effect, sensor effects, and effects that are fixed by their definition.
"""

from __future__ import annotations

import importlib
import pkgutil
import re
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

import numpy as np
import pandas as pd

from benchmarks.gap.drive import REST, Array, Drive, lagged

if TYPE_CHECKING:
    from benchmarks.gap.march import Now

SIZES = ("weak", "medium", "strong")
X, Y, E = range(3)
"""The first columns of every simulator's pose: x, y and elongation [um]."""


class Hidden:
    """Base class of everything that can be hidden; it does nothing by default.

    Attributes
    ----------
    size : float
        Its amplitude; at 0 the effect vanishes exactly.
    channel : str
        The sensor that it acts on, if any.
    """

    name: ClassVar[str]
    """Its class name in snake case."""
    unit: ClassVar[str]
    sizes: ClassVar[tuple[float, float, float]]
    """Amplitudes called weak, medium and strong."""
    channels: ClassVar[tuple[str, ...]] = ()
    catalogued: ClassVar[bool] = True
    in_other_words: ClassVar[tuple[tuple[str, tuple[str, ...]], ...]] = ()
    """Equivalent changes of the machine's file, kind and place; ``*`` is any part."""
    drawn: ClassVar[Mapping[str, tuple[float, float]]] = {}
    """Ranges of its other numbers, which are drawn uniformly."""

    def __init_subclass__(cls, *, named: bool = True) -> None:
        """Name it after its class, unless it is a base class."""
        if named:
            cls.name = re.sub(r"(?<!^)(?=[A-Z])", "_", cls.__name__).lower()

    def __init__(self, size: float, rng: np.random.Generator, channel: str = "") -> None:
        self.size, self.channel = float(size), channel
        self.more: dict[str, float] = {}
        """Its other numbers, for the answers file."""
        self.draw(rng)

    def draw(self, rng: np.random.Generator) -> None:
        """Draw all numbers except the size."""
        for name, (low, high) in self.drawn.items():
            self.more[name] = float(rng.uniform(low, high))

    def begin(self, machine: Any, drive: Drive) -> None:
        """Reset its states at the start of a run."""

    def friction(self, now: Now, viscous: Array, load: Array) -> tuple[Array, Array]:
        """Return the changed heat of every bearing or set of bearings [W]."""
        return viscous, load

    def heat(self, now: Now, out: Array) -> None:
        """Add heat [W]."""

    def scales(self, now: Now) -> dict[str, float]:
        """Return factors on groups of conductances."""
        return {}

    def boundaries(self, now: Now, values: Array) -> None:
        """Change the boundary temperatures, in place [degC]; of the jig borer only."""

    def advance(self, now: Now, step: float) -> None:
        """Step the effect's own states."""

    def move(self, machine: Any, drive: Drive, temperatures: Array, pose: Array) -> None:
        """Change the pose in place, row by row; temperatures are (rows, unknowns)."""

    def record(self, number: int, machine: Any, drive: Drive, shown: pd.DataFrame) -> None:
        """Change the sensor readings in place; *number* counts the case's runs from 0."""


Kind = TypeVar("Kind", bound=Hidden)


def found_in(path: Iterable[str], package: str) -> dict[str, type[Hidden]]:
    """Return all effects of a folder by name, defined or imported in its files."""
    effects: dict[str, type[Hidden]] = {}
    for module in sorted(entry.name for entry in pkgutil.iter_modules(path)):
        for entry in vars(importlib.import_module(f"{package}.{module}")).values():
            if isinstance(entry, type) and issubclass(entry, Hidden) and hasattr(entry, "name"):
                effects[entry.name] = entry
    return dict(sorted(effects.items()))


def make_from(
    known: Mapping[str, type[Kind]],
    name: str,
    size: str | float,
    rng: np.random.Generator,
    channel: str = "",
) -> Kind:
    """Return an effect with a size by name (weak, medium, strong, within 15 %) or in its own unit.

    Parameters
    ----------
    known : mapping of str to type
        All effects.
    name : str
    size : str or float
    rng : Generator
        For its random numbers.
    channel : str
        The sensor of an effect that acts on one; drawn if not given.
    """
    kind = known[name]
    spread = float(np.exp(rng.uniform(-0.15, 0.15)))
    if isinstance(size, str):
        size = kind.sizes[SIZES.index(size)] * spread
    drawn = str(rng.choice(kind.channels)) if kind.channels else ""
    return kind(size, rng, channel or drawn)


# Sensor effects.


class SensorLag(Hidden):
    """One thermometer has bad contact and responds late; the size is the lag [min]."""

    unit: ClassVar[str] = "min"
    sizes: ClassVar[tuple[float, float, float]] = (2.0, 5.0, 12.0)

    def record(self, number: int, machine: Any, drive: Drive, shown: pd.DataFrame) -> None:
        """Delay the channel."""
        if self.size > 0.0:
            column = f"{self.channel}_degC"
            values = shown[column].to_numpy()
            shown[column] = lagged(drive.time_s, values, 60.0 * self.size)


class _Wrong(Hidden, named=False):
    """One thermometer reads too high or too low."""

    unit: ClassVar[str] = "K"

    def draw(self, rng: np.random.Generator) -> None:
        """Draw sign and first run."""
        self.more["sign"] = 1.0 if rng.random() < 0.5 else -1.0
        self.more["from_run"] = float(rng.integers(1, 4))


class SensorOffset(_Wrong):
    """A constant error from one run on; the size is the error [K]."""

    def record(self, number: int, machine: Any, drive: Drive, shown: pd.DataFrame) -> None:
        """Shift the channel."""
        if number >= self.more["from_run"]:
            shown[f"{self.channel}_degC"] += self.more["sign"] * self.size


class SensorDrift(_Wrong):
    """A reading that drifts away in every run; the size is the error after eight hours [K]."""

    def record(self, number: int, machine: Any, drive: Drive, shown: pd.DataFrame) -> None:
        """Add the drift so far."""
        grown = drive.time_s / (8.0 * 3600.0)
        shown[f"{self.channel}_degC"] += self.more["sign"] * self.size * grown


class FixtureWarming(Hidden):
    """The fixture of the radial sensors warms and moves them; the size is um per K."""

    unit: ClassVar[str] = "um/K"

    def nose(self, machine: Any, temperatures: Array) -> Array:
        """Return the temperature of the nose next to the fixture [degC], shape (rows,)."""
        return np.asarray(temperatures @ machine.thermometers["front"])

    def move(self, machine: Any, drive: Drive, temperatures: Array, pose: Array) -> None:
        """Shift the radial readings in one direction."""
        share = self.more["of_nose"]
        followed = (1.0 - share) * drive.at() + share * self.nose(machine, temperatures)
        late = lagged(drive.time_s, followed, 3600.0 * self.more["tau_h"])
        shift = self.size * (late - late[0])
        pose[:, X] += np.cos(self.more["direction_rad"]) * shift
        pose[:, Y] += np.sin(self.more["direction_rad"]) * shift


# Effects fixed by their definition.


class FrictionSpeedExponent(Hidden):
    """Friction heat follows another power of speed; at one speed it is as usual.

    The size is the difference of the exponent from the usual one.
    """

    unit: ClassVar[str] = "1"
    sizes: ClassVar[tuple[float, float, float]] = (0.12, 0.25, 0.45)
    usual_at_rpm: ClassVar[float]

    def draw(self, rng: np.random.Generator) -> None:
        """Draw whether friction rises more or less steeply."""
        self.more["sign"] = -1.0 if rng.random() < 0.4 else 1.0

    def friction(self, now: Now, viscous: Array, load: Array) -> tuple[Array, Array]:
        """Return both parts, scaled."""
        factor = (now.speed / self.usual_at_rpm) ** (self.more["sign"] * self.size)
        return viscous * factor, load * factor


class BearingRunIn(Hidden):
    """Fresh grease is churned at first: friction x (1 + a exp(-t_running / tau)) in each run.

    The size is the initial excess. The grease flows back between runs.
    """

    unit: ClassVar[str] = "1"

    def begin(self, machine: Any, drive: Drive) -> None:
        """Reset the running time."""
        self._running = 0.0

    def friction(self, now: Now, viscous: Array, load: Array) -> tuple[Array, Array]:
        """Return both parts, raised."""
        hours = self._running / 3600.0
        factor = 1.0 + self.size * np.exp(-hours / self.more["tau_h"])
        return viscous * factor, load * factor

    def advance(self, now: Now, step: float) -> None:
        """Count the time that the shaft turns."""
        if now.speed > 0.0:
            self._running += step


class CentrifugalShift(Hidden):
    """Balls and rings move the shaft at once by k n^2; the size is the shift at top speed [um]."""

    unit: ClassVar[str] = "um"
    top_rpm: ClassVar[float]

    def move(self, machine: Any, drive: Drive, temperatures: Array, pose: Array) -> None:
        """Shift the nose along the axis."""
        shift = (drive.speed / self.top_rpm) ** 2
        pose[:, E] += self.size * (shift - shift[0])


class BearingStickSlip(Hidden, ABC):
    """The floating bearing sticks until shaft and housing have grown apart by the size [um].

    While it sticks, the strained shaft pushes the nose; when it slips, most of the push disappears.
    """

    unit: ClassVar[str] = "um"
    left: ClassVar[float]
    pushed: ClassVar[float]

    @abstractmethod
    def apart(self, machine: Any, temperatures: Array) -> Array:
        """Return the difference in growth of shaft and housing [um], shape (rows,)."""

    def move(self, machine: Any, drive: Drive, temperatures: Array, pose: Array) -> None:
        """Add the push of the strained shaft."""
        apart = self.apart(machine, temperatures)
        seat = float(apart[0])
        for k, now in enumerate(apart.tolist()):
            strain = now - seat
            if abs(strain) > self.size:
                strain *= self.left * self.size / abs(strain)
                seat = now - strain
            pose[k, E] += self.pushed * strain


class ToolHeating(Hidden, ABC):
    """A holder from the magazine takes heat from the nose, and grows.

    The size is the conductance of its seat [W/K].
    """

    unit: ClassVar[str] = "W/K"
    sizes: ClassVar[tuple[float, float, float]] = (0.8, 2.5, 7.0)

    @abstractmethod
    def seat(self, machine: Any) -> tuple[Any, Array]:
        """Return the unknowns of the nose at the seat, and the share of each."""

    def begin(self, machine: Any, drive: Drive) -> None:
        """Mount a holder at air temperature when the run begins."""
        self._mounted = drive.family != REST
        self._nose, self._share = self.seat(machine)
        self._holder = float(np.interp(drive.time_s[0], drive.grid_s, drive.outside[:, 0]))
        self._times, self._values = [float(drive.time_s[0])], [self._holder]

    def _warm(self, now: Now) -> float:
        return float(now.temperature[self._nose] @ self._share)

    def heat(self, now: Now, out: Array) -> None:
        """Take heat from the nose."""
        if self._mounted:
            out[self._nose] -= self.size * (self._warm(now) - self._holder) * self._share

    def advance(self, now: Now, step: float) -> None:
        """Warm the holder, exactly for constant temperatures of nose and air."""
        if not self._mounted:
            return
        whole, air = self.size + self.more["loss_W_K"], float(now.look()[0])
        end = (self.size * self._warm(now) + self.more["loss_W_K"] * air) / whole
        decay = float(np.exp(-step * whole / self.more["capacity_J_K"]))
        self._holder = end + decay * (self._holder - end)
        self._times.append(now.time)
        self._values.append(self._holder)

    def move(self, machine: Any, drive: Drive, temperatures: Array, pose: Array) -> None:
        """Add the holder's growth; without a conductance there is no holder."""
        if self.size > 0.0:
            warm = np.interp(drive.time_s, self._times, self._values) - self._values[0]
            pose[:, E] += machine.p["alpha_steel"] * 1e-3 * self.more["length_mm"] * warm


class Loosening(Hidden, named=False):
    """A joint suddenly loosens in every run; the size is the share of its conductance lost."""

    unit: ClassVar[str] = "1"
    sizes: ClassVar[tuple[float, float, float]] = (0.3, 0.6, 0.9)
    catalogued: ClassVar[bool] = False
    drawn: ClassVar[Mapping[str, tuple[float, float]]] = {"at_h": (1.5, 3.5)}
    joint: ClassVar[str]

    def scales(self, now: Now) -> dict[str, float]:
        """Return the joint's factor."""
        loose = now.time > 3600.0 * self.more["at_h"]
        return {self.joint: 1.0 - self.size} if loose else {}
