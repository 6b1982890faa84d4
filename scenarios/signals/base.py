"""The base class of signals, and the types of their fields."""

from __future__ import annotations

import zlib
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from measurement.runs import LONGEST_S

FloatArray = NDArray[np.floating[Any]]

Value = Annotated[float, Field(ge=-1e9, le=1e9, allow_inf_nan=False)]
"""A value of a signal, in the signal's own unit."""

Seconds = Annotated[float, Field(ge=0.0, le=LONGEST_S, allow_inf_nan=False)]
"""A time or a duration [s]."""

Duration = Annotated[float, Field(gt=0.0, le=LONGEST_S, allow_inf_nan=False)]
"""A duration above 0 [s]."""


@dataclass(frozen=True)
class Setting:
    """The context of a signal: what it needs in addition to its own fields.

    Attributes
    ----------
    source : str or Path
        The scenario file, for refusals.
    place : str
        Place of the signal in it, for example ``signals.speed``.
    folder : Path
        The folder to which file names are relative.
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
            Key of the part in this signal, such as ``parts.0``.
        """
        return replace(self, place=f"{self.place}.{step}")

    def generator(self) -> np.random.Generator:
        """Return a random generator that depends only on this seed and this place.

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
        """Return the values at given times.

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
        """Check what needs the setting (parts, files); the default checks nothing.

        Parameters
        ----------
        setting : Setting
            Context of the signal.
        table : dict
            The parsed signal.
        """
