"""Converts units of DBC files to those of the compensator."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

from measurement.errors import BadInput, one_line

if TYPE_CHECKING:
    import pint

SPELLINGS = {
    # Taken literally, these are angular frequencies of another size, or something else.
    "1/min": "rpm",
    "min-1": "rpm",
    "min^-1": "rpm",
    "r/min": "rpm",
    "rev/min": "rpm",
    "U/min": "rpm",
    "Upm": "rpm",
    "deg C": "degC",
    "Grad C": "degC",
    "Cel": "degC",
}
"""Spellings in DBC files, and what they mean."""
TURNS = {"Hz": "60 rpm", "1/s": "60 rpm", "rev/s": "60 rpm", "U/s": "60 rpm"}
"""The same for spindle speeds: they count turns, not radians."""


@cache
def _registry() -> pint.UnitRegistry[float]:
    import pint  # takes as long as starting the rest of the gateway, and is often not needed

    return pint.UnitRegistry(autoconvert_offset_to_baseunit=False)


def conversion(unit: str, wanted: str) -> tuple[float, float]:
    """Return factor and offset of value in *wanted* = factor * value in *unit* + offset.

    Parameters
    ----------
    unit : str
        As a DBC file writes it, possibly with a number before it: ``0.1 um``.
    wanted : str
        As the compensator writes it.

    Raises
    ------
    BadInput
        If either is unknown or *unit* cannot be converted to *wanted*.
    """
    unit, wanted = SPELLINGS.get(unit.strip(), unit.strip()), wanted.strip()
    unit = TURNS.get(unit, unit) if wanted == "rpm" else unit
    if unit == wanted:
        return 1.0, 0.0
    try:
        number, name = _size(unit)
        registry = _registry()
        zero, one = (
            float(registry.Quantity(value, name).to(wanted).magnitude) for value in (0.0, 1.0)
        )
    except Exception as error:  # pint and the parser below it raise many kinds of errors
        problem = f"cannot be converted to {wanted}: {one_line(error)}"
        raise BadInput(unit or "no unit", "", problem) from None
    factor = number * (one - zero)
    # Rounded, so that a whole number of steps stays one.
    return float(f"{factor:.12g}"), float(f"{zero:.12g}")


def _size(unit: str) -> tuple[float, str]:
    """Return the number before a unit (1 if there is none) and the unit."""
    end = len(unit) - len(unit.lstrip("0123456789.,eE+-"))
    number = unit[:end].strip()
    return (float(number), unit[end:].strip()) if number else (1.0, unit)
