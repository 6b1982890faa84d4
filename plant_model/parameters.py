"""Named numbers with unit, range and source, and many sets of them at once."""

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
"""Prefix of the full names of named numbers."""

BEYOND = "calibrated beyond"
"""Text in the source of a parameter that calibration moved out of its range; the range follows."""


@dataclass(frozen=True)
class Parameter:
    """One number of a machine.

    Attributes
    ----------
    value, low, high : float
        The number in force, and the range that is expected to hold it in 95 of 100 cases [unit].
    unit : str
        Its unit as in the machine file, for example ``W/K``.
    source : str
        Where the value and the range come from.
    calibrate : bool
        Whether calibration may move it.
    tied : str
        Full name of the named number that it follows (``numbers.film``), or empty. The range of a
        tied parameter is its value.
    factor : float
        Factor on the named number.
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
        """Return the tied parameter for a value of its named number.

        Parameters
        ----------
        number : float
            The named number, in its own unit.
        """
        value = number * self.factor
        return replace(self, value=value, low=value, high=value)

    def moved(self, value: float) -> Parameter:
        """Return the parameter at another value; an extended range is noted in the source.

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
    """Values of all parameters for one or many parameter sets.

    Parameters
    ----------
    parameters : mapping of str to Parameter
        All parameters of the machine by full name, for example ``nodes.column.capacity``.
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
        """Return one parameter, shape (sets, 1), or (1, 1) if it is the same in all sets."""
        return self._columns[name]

    def widen(self, sets: int) -> None:
        """Represent at least *sets* parameter sets, because something else differs between them.

        Parameters
        ----------
        sets : int
            With 1 nothing changes.

        Raises
        ------
        ParameterError
            If there are already several sets, and their number differs.
        """
        if sets > 1 and self.sets not in {1, sets}:
            raise ParameterError(f"{sets} starts, but {self.sets} parameter sets")
        self.sets = max(self.sets, sets)

    def varying(self) -> Iterator[tuple[str, FloatArray]]:
        """Return the parameters that differ between sets: names, and arrays of shape (sets, 1)."""
        for name, column in self._columns.items():
            if len(column) > 1 and np.any(column != column[:1]):
                yield name, column

    def equal(self, other: Values) -> npt.NDArray[np.bool_]:
        """Return which sets have all values of the single set of *other*, shape (sets,)."""
        same = np.ones(self.sets, dtype=bool)
        for name, column in self._columns.items():
            same &= column[:, 0] == other[name][0, 0]
        return same

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
