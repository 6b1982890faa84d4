"""The units of signals, and the names of run-file columns.

A column's name is the signal's name and its unit: ``T1_degC``, ``feed_mm_min``.
`fmu_packaging.units` converts units to SI base units. This module imports the standard library
only, so that any package can use it, even inside an FMU.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

UM_PER_MM, RAD_PER_URAD = 1e3, 1e-6
"""As given by the SI."""


@dataclass(frozen=True)
class Unit:
    """A unit of columns, its quantity, and its allowed range.

    Attributes
    ----------
    suffix : str
        Ending of a column's name, without the underscore.
    quantity : str
        The quantity, in words.
    low, high : float
        A value outside is an error in the file, not a measurement [unit]; wide enough for any
        machine tool, narrow enough that no sum of squares overflows.
    label : str
        The unit in plots and tables.
    switches : bool
        Whether such signals jump and then stay (speed, feed, torque, tool length), so that the last
        value holds between samples; other signals are measured and change smoothly.
    """

    suffix: str
    quantity: str
    low: float
    high: float
    label: str = ""
    switches: bool = False


UNITS: dict[str, Unit] = {
    unit.suffix: unit
    for unit in (
        # Seconds since 1970 are allowed (1.7e9); milliseconds since 1970 are a mistake.
        Unit("s", "time", -1e10, 1e10, label="s"),
        Unit("rpm", "rotational speed", -1e6, 1e6, label="r/min", switches=True),
        Unit("mm_min", "feed speed", -1e7, 1e7, label="mm/min", switches=True),
        Unit("Nm", "torque", -1e6, 1e6, label="N m", switches=True),
        Unit("W", "power", -1e8, 1e8, label="W", switches=True),
        Unit("lpm", "volume flow", -1e6, 1e6, label="l/min", switches=True),
        # The range of any sensor on a machine tool; a value outside means a broken wire.
        Unit("degC", "temperature", -60.0, 400.0, label="°C"),
        Unit("um", "displacement", -1e6, 1e6, label="µm"),
        Unit("mm", "length", -1e6, 1e6, label="mm", switches=True),
        Unit("urad", "tilt", -1e6, 1e6, label="µrad"),
        Unit("1", "flag or code", -1e9, 1e9, switches=True),
    )
}


@cache
def split_column(name: str) -> tuple[str, str]:
    """Return the signal's name and its unit's suffix.

    >>> split_column("feed_mm_min")
    ('feed', 'mm_min')

    Parameters
    ----------
    name : str
        A column's name; the longest matching unit counts.

    Returns
    -------
    signal, unit : str

    Raises
    ------
    ValueError
        If the name does not end in a known unit, or has nothing before the unit.
    """
    # Longest suffix first, so that a unit is not mistaken for a shorter one that it ends in.
    for suffix in sorted(UNITS, key=len, reverse=True):
        if name.endswith("_" + suffix):
            signal = name[: -len(suffix) - 1]
            if not signal.strip():
                break
            return signal, suffix
    raise ValueError(
        f"{name!r} is not a column name: it must be a signal's name and one of the units "
        + ", ".join("_" + suffix for suffix in UNITS)
    )


def column(name: str, unit: str) -> str:
    """Return the column name of a signal.

    >>> column("T1", "degC")
    'T1_degC'

    Parameters
    ----------
    name : str
        The signal.
    unit : str
        A suffix of `UNITS`.

    Raises
    ------
    ValueError
        If the unit is not known.
    """
    if unit not in UNITS:
        raise ValueError(f"{unit!r} is not a known unit: {', '.join(UNITS)}")
    return f"{name}_{unit}"
