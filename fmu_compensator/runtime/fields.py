"""Read the fields of a JSON table one by one, and report the place of each invalid one."""

from __future__ import annotations

import math
from typing import Any

LARGEST = 1e9
"""Limit of all numbers in a file, of times and of readings, so that sums and products stay finite.
Set on no data."""


class ModelFileError(ValueError):
    """A compensator file that cannot be used; one line: file, place, value, what is allowed.

    Parameters
    ----------
    source : str
        The file.
    place : str
        Place in the file, for example ``error_model.coefficients.0.2``; empty for the whole file.
    problem : str
        The value and what is allowed.
    """

    def __init__(self, source: str, place: str, problem: str) -> None:
        self.source, self.place, self.problem = source, place, problem
        parts = (source, place, problem)
        super().__init__(": ".join(" ".join(part.split()) for part in parts if part))


def shown(value: object) -> str:
    """Return *value* as shown in an error message, cut to a readable length."""
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


class Fields:
    """The fields of one table; `done` refuses fields that were not read as unknown.

    Parameters
    ----------
    table : object
        The file's content.
    source, place : str
        The file, and the table's place in it.

    Raises
    ------
    ModelFileError
        If *table* is not a table.

    Notes
    -----
    Each method that reads a field takes its name, *key*, and raises `ModelFileError`, which names
    file, place and value, if the field is missing or not allowed.
    """

    def __init__(self, table: object, source: str, place: str = "") -> None:
        self.source, self.place = source, place
        if not isinstance(table, dict):
            raise ModelFileError(source, place, f"{shown(table)} is not allowed: must be a table")
        self._table: dict[str, Any] = table
        self._asked: set[str] = set()

    def refusal(self, key: str, problem: str) -> ModelFileError:
        """Return the error for field *key*.

        Parameters
        ----------
        key : str
            The field, dotted if nested: ``layers.0``.
        problem : str
            The value and what is allowed.
        """
        return ModelFileError(self.source, f"{self.place}.{key}" if self.place else key, problem)

    def _wrong(self, key: str, value: object, allowed: str) -> ModelFileError:
        return self.refusal(key, f"{shown(value)} is not allowed: must be {allowed}")

    def raw(self, key: str) -> Any:
        """Return the field unchecked.

        Parameters
        ----------
        key : str

        Raises
        ------
        ModelFileError
            If it is missing.
        """
        self._asked.add(key)
        if key not in self._table:
            raise self.refusal(key, "is missing")
        return self._table[key]

    def has(self, key: str) -> bool:
        """Return whether the table has the field.

        Parameters
        ----------
        key : str
            This call does not count as reading it.
        """
        return key in self._table

    def number(self, key: str, low: float, high: float) -> float:
        """Return a finite number between *low* and *high*.

        Parameters
        ----------
        key : str
        low, high : float
            Both allowed.
        """
        return self._as_number(key, self.raw(key), low, high)

    def _as_number(self, key: str, value: object, low: float, high: float) -> float:
        allowed = f"a number from {low:g} to {high:g}"
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self._wrong(key, value, allowed)
        # The comparison comes before float(): an integer may be too large for it.
        if not low <= value <= high or not math.isfinite(value):
            raise self._wrong(key, value, allowed)
        return float(value)

    def integer(self, key: str, low: int, high: int) -> int:
        """Return a whole number between *low* and *high*.

        Parameters
        ----------
        key : str
        low, high : int
            Both allowed.

        Raises
        ------
        ModelFileError
            If it is missing, not whole, or out of range; 2.0 and true are not whole numbers here.
        """
        value = self.raw(key)
        if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
            raise self._wrong(key, value, f"a whole number from {low} to {high}")
        return value

    def range(self, low_key: str, high_key: str, low: float, high: float) -> tuple[float, float]:
        """Return two numbers, the second larger than the first.

        Parameters
        ----------
        low_key, high_key : str
            The two fields.
        low, high : float
            Allowed range of both.

        Returns
        -------
        first, second : float

        Raises
        ------
        ModelFileError
            If one is missing or out of range, or the second is not above the first.
        """
        first, second = self.number(low_key, low, high), self.number(high_key, low, high)
        if not first < second:
            raise self._wrong(high_key, second, f"above {low_key} ({first:g})")
        return first, second

    def text(self, key: str, longest: int = 500) -> str:
        """Return a text of one line.

        Parameters
        ----------
        key : str
        longest : int
            Maximum number of characters.

        Raises
        ------
        ModelFileError
            If it is missing, not a text, too long, or contains a non-printable character.
        """
        value = self.raw(key)
        if not isinstance(value, str) or len(value) > longest or not value.isprintable():
            raise self._wrong(key, value, f"a printable text of at most {longest} characters")
        return value

    def name(self, key: str) -> str:
        """Return a signal name: a letter, then letters, digits and underscores.

        Parameters
        ----------
        key : str

        Raises
        ------
        ModelFileError
            If it is missing or not a name; see `is_name`.
        """
        value = self.raw(key)
        if not is_name(value):
            raise self._wrong(key, value, "a name: a letter, then letters, digits or _, at most 60")
        return str(value)

    def choice(self, key: str, allowed: tuple[str, ...]) -> str:
        """Return one of the allowed texts.

        Parameters
        ----------
        key : str
        allowed : tuple of str

        Raises
        ------
        ModelFileError
            If it is missing or not one of them.
        """
        value = self.raw(key)
        if not isinstance(value, str) or value not in allowed:
            raise self._wrong(key, value, "one of " + ", ".join(allowed))
        return value

    def items(self, key: str, what: str, fewest: int = 0, most: int | None = None) -> list[Any]:
        """Return a list with *fewest* to *most* items.

        Parameters
        ----------
        key : str
        what : str
            Plural noun for the items, for the error message.
        fewest, most : int
            Both allowed; no upper limit without *most*.

        Raises
        ------
        ModelFileError
            If it is missing, not a list, or of the wrong length.
        """
        value = self.raw(key)
        count = len(value) if isinstance(value, list) else -1
        if count < fewest or (most is not None and count > most):
            number = f"{fewest} " if fewest == most else f"at least {fewest} " if fewest else ""
            raise self._wrong(key, value, f"a list of {number}{what}")
        return list(value)

    def names(self, key: str) -> list[str]:
        """Return a list of at least one name, without duplicates.

        Parameters
        ----------
        key : str

        Raises
        ------
        ModelFileError
            If it is missing, not a list of names, or contains one twice.
        """
        values, before = self.items(key, "names", 1), set()
        for index, value in enumerate(values):
            if not is_name(value):
                raise self._wrong(f"{key}.{index}", value, "a name")
            if value in before:
                raise self._wrong(f"{key}.{index}", value, "different from the names before it")
            before.add(value)
        return values

    def numbers(
        self, key: str, length: int, limit: float = LARGEST, low: float | None = None
    ) -> list[float]:
        """Return a list of *length* numbers from *low* (default: minus *limit*) to *limit*.

        Parameters
        ----------
        key : str
        length : int
            Required length.
        limit : float
            Largest absolute value.
        low : float, optional
            Smallest value.
        """
        values, low = self.items(key, "numbers", length, length), -limit if low is None else low
        return [self._as_number(f"{key}.{i}", v, low, limit) for i, v in enumerate(values)]

    def matrix(
        self, key: str, rows: int, columns: int, limit: float = LARGEST
    ) -> list[list[float]]:
        """Return *rows* lists of *columns* numbers within plus or minus *limit*.

        Parameters
        ----------
        key : str
        rows, columns : int
            Required shape.
        limit : float
            Largest absolute value.
        """
        values = self.items(key, "lists of numbers", rows, rows)
        by_row = {str(row): value for row, value in enumerate(values)}
        table = Fields(by_row, self.source, self._below(key))
        return [table.numbers(row, columns, limit) for row in by_row]

    def table(self, key: str) -> Fields:
        """Return the fields of a nested table.

        Parameters
        ----------
        key : str
        """
        return Fields(self.raw(key), self.source, self._below(key))

    def tables(self, key: str, what: str, fewest: int = 0, most: int | None = None) -> list[Fields]:
        """Return the tables of a list; the parameters are those of `items`."""
        values = self.items(key, what, fewest, most)
        place = self._below(key)
        return [Fields(value, self.source, f"{place}.{i}") for i, value in enumerate(values)]

    def keys(self) -> list[str]:
        """Return the names of all fields; each counts as read."""
        for key in self._table:
            if not is_name(key):
                raise self.refusal(shown(key), "is not allowed: must be a name")
        self._asked.update(self._table)
        return list(self._table)

    def as_table(self) -> dict[str, Any]:
        """Return the table itself."""
        return self._table

    def done(self) -> None:
        """Refuse fields that were not read."""
        for key in self._table:
            if key not in self._asked:
                raise self.refusal(shown(key), "is not a known field")

    def _below(self, key: str) -> str:
        return f"{self.place}.{key}" if self.place else key


def is_name(value: object) -> bool:
    """Return whether *value* can name a signal (an FMI variable, a CSV column without its unit).

    Parameters
    ----------
    value : object
        Any type; only a text of 1 to 60 ASCII characters can be a name.
    """
    return (
        isinstance(value, str)
        and 1 <= len(value) <= 60
        and value.isascii()
        and value.isidentifier()
        and not value.startswith("_")
    )
