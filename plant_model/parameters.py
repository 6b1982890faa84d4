"""Named numbers with a unit, a range and a source, and many sets of them at once."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

FloatArray: TypeAlias = npt.NDArray[np.float64]

ROOM_DEGC = 20.0
"""The standard reference temperature, given by ISO 1 [degC]."""

NUMBERS = "numbers."
"""What the full names of named numbers begin with."""

BEYOND = "calibrated beyond"
"""What the source of a parameter says, before its range, that runs took out of that range."""


@dataclass(frozen=True)
class Parameter:
    """One number of a machine.

    Attributes
    ----------
    value, low, high : float
        The number in force, and the range in which it is expected in 95 of 100 cases [unit].
    unit : str
        Its unit as the machine file writes it, for example ``W/K``.
    source : str
        Where the value and the range come from.
    calibrate : bool
        Whether calibration may move it.
    tied : str
        Full name of the named number that it follows (``numbers.film``); empty if it stands alone.
        Its range is then the one value that the number gives it.
    factor : float
        What the named number is multiplied by.
    """

    value: float
    unit: str
    low: float
    high: float
    source: str
    calibrate: bool = False
    tied: str = ""
    factor: float = 1.0

    def following(self, number: float) -> Parameter:
        """Return the tied parameter as it is where its named number has this value.

        Parameters
        ----------
        number : float
            The named number, in its own unit.
        """
        value = number * self.factor
        return replace(self, value=value, low=value, high=value)

    def moved(self, value: float) -> Parameter:
        """Return the parameter at another value; its range reaches there, and says what it was.

        Parameters
        ----------
        value : float
            In its unit.
        """
        if self.low <= value <= self.high:
            return replace(self, value=value)
        return replace(
            self,
            value=value,
            low=min(self.low, value),
            high=max(self.high, value),
            source=f"{self.source}; {BEYOND} {self.low:.4g} to {self.high:.4g}",
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the parameter as a table of a machine file."""
        if self.tied:
            name = self.tied.removeprefix(NUMBERS)
            return {"number": name, "factor": self.factor, "unit": self.unit}
        table: dict[str, Any] = {
            "value": self.value,
            "unit": self.unit,
            "low": self.low,
            "high": self.high,
            "source": self.source,
        }
        return table | {"calibrate": True} if self.calibrate else table


class ParameterError(ValueError):
    """A parameter that does not exist, or a value outside its range."""


class Values:
    """The values of all parameters for one or many parameter sets.

    Parameters
    ----------
    parameters : mapping of str to Parameter
        Every parameter of the machine by its full name, for example ``nodes.column.capacity``.
    overrides : mapping of str to float or array, shape (sets,)
        Values to use instead. All arrays have the same length.
    bounded : bool
        Refuse a value outside the parameter's range.

    Raises
    ------
    ParameterError
        For an unknown name, arrays of different lengths, or a value that is out of range or not
        finite.
    """

    def __init__(
        self,
        parameters: Mapping[str, Parameter],
        overrides: Mapping[str, float | FloatArray | Iterable[float]] | None = None,
        *,
        bounded: bool = True,
    ) -> None:
        self._columns = {name: np.array([[p.value]]) for name, p in parameters.items()}
        self.sets = 1
        for name, given in (overrides or {}).items():
            if name not in parameters:
                raise ParameterError(f"{name}: the machine has no parameter of this name")
            if parameters[name].tied:
                raise ParameterError(f"{name}: follows {parameters[name].tied}, so move that")
            column = np.atleast_1d(np.asarray(given, dtype=np.float64))
            if column.ndim != 1:
                raise ParameterError(f"{name}: one value per parameter set is needed")
            low, high = parameters[name].low, parameters[name].high
            if bounded and not np.all((column >= low) & (column <= high)):
                worst = column[~((column >= low) & (column <= high))][0]
                unit = parameters[name].unit
                raise ParameterError(f"{name}: {worst:g} is outside {low:g}..{high:g} {unit}")
            if column.size > 1:
                if self.sets not in {1, column.size}:
                    raise ParameterError(
                        f"{name}: {column.size} values, but other parameters have {self.sets}"
                    )
                self.sets = column.size
            self._columns[name] = column[:, None]
        for name, parameter in parameters.items():
            if parameter.tied:
                self._columns[name] = self._columns[parameter.tied] * parameter.factor

    def __getitem__(self, name: str) -> FloatArray:
        """Return one parameter, shape (sets, 1), or (1, 1) where it is the same in all sets."""
        return self._columns[name]

    def widen(self, sets: int) -> None:
        """Stand for at least *sets* parameter sets, where something else differs between them.

        Parameters
        ----------
        sets : int
            With 1 nothing changes.

        Raises
        ------
        ParameterError
            When there are several sets of parameters already, and of another number.
        """
        if sets > 1 and self.sets not in {1, sets}:
            raise ParameterError(f"{sets} starts, but {self.sets} parameter sets")
        self.sets = max(self.sets, sets)

    def varying(self) -> Iterator[tuple[str, FloatArray]]:
        """Return the parameters that differ between sets: names, and arrays of shape (sets, 1)."""
        for name, column in self._columns.items():
            if len(column) > 1 and np.any(column != column[:1]):
                yield name, column

    def of_sets(self, which: npt.NDArray[np.intp]) -> Values:
        """Return the values of some parameter sets.

        Parameters
        ----------
        which : array of int, shape (n,)
            Their positions.
        """
        chosen = Values({})
        chosen._columns = {
            name: column if len(column) == 1 else column[which]
            for name, column in self._columns.items()
        }
        chosen.sets = len(which)
        return chosen

    def is_off(self, name: str, off: float) -> bool:
        """Return whether the parameter is exactly *off* in every set.

        Parameters
        ----------
        name : str
            A parameter's full name.
        off : float
            The value at which its effect vanishes.
        """
        return bool(np.all(self._columns[name] == off))
