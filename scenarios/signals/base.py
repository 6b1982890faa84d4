"""What every kind of signal shares."""

from __future__ import annotations

import zlib
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

FloatArray = NDArray[np.floating[Any]]
MOST_STEPS = 1_000_000
"""Of a scenario, levels of a signal in it, or cases of a sweep: set on no data."""

Value = Annotated[float, Field(ge=-1e9, le=1e9, allow_inf_nan=False)]
"""A value of a signal, in the signal's own unit."""

Seconds = Annotated[float, Field(ge=0.0, le=1e8, allow_inf_nan=False)]
"""A moment or a length of time [s]."""

Duration = Annotated[float, Field(gt=0.0, le=1e8, allow_inf_nan=False)]
"""A length of time that is not nothing [s]."""


@dataclass(frozen=True)
class Setting:
    """Where a signal stands: what it needs to know beyond its own fields.

    Attributes
    ----------
    source : str or Path
        The scenario file, for refusals.
    place : str
        Where in it the signal is, for example ``signals.speed``.
    folder : Path
        The folder that file names start from.
    seed : int
        The scenario's seed.
    """

    source: str | Path
    place: str
    folder: Path
    seed: int = 0

    def inside(self, step: str) -> Setting:
        """Return the setting of a signal that is part of this one.

        Parameters
        ----------
        step : str
            From this signal to the part, such as ``parts.0``.
        """
        return replace(self, place=f"{self.place}.{step}")

    def generator(self) -> np.random.Generator:
        """Return random numbers that belong to this seed and this place alone.

        Two signals of one scenario are independent, and adding a signal changes no other.
        """
        return np.random.default_rng([self.seed, zlib.crc32(self.place.encode())])


class Signal(BaseModel, ABC):
    """A quantity over time; one file of this folder defines one kind.

    The value at a communication point holds for the step that begins there.
    """

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)

    kind: str

    @abstractmethod
    def values(self, time_s: FloatArray, setting: Setting) -> FloatArray:
        """Return the values at some instants.

        Parameters
        ----------
        time_s : array, shape (n,)
            Increasing [s].
        setting : Setting

        Returns
        -------
        array, shape (n,)
            In the unit of the input that the signal drives.

        Raises
        ------
        BadInput
            If a file that it needs cannot be used.
        """

    @classmethod
    def place(cls, setting: Setting, table: dict[str, Any]) -> None:
        """Check what only shows with the setting (parts, files); the default checks nothing.

        Parameters
        ----------
        setting : Setting
            Where the signal stands.
        table : dict
            The signal as parsed.
        """
