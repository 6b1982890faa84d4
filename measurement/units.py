"""The units that signals may have, and the names of run-file columns.

A column's name is the signal's name and its unit: ``T1_degC``, ``feed_mm_min``.
`fmu_packaging.units` says what a unit is in SI base units. Standard library only, so that any room
can use it, inside an FMU too.
"""

from __future__ import annotations

from dataclasses import dataclass

UM_PER_MM, RAD_PER_URAD = 1e3, 1e-6
"""As given by the SI."""


@dataclass(frozen=True)
class Unit:
    """A unit of columns, what it measures, and what its numbers can be.

    Attributes
    ----------
    suffix : str
        How a column's name ends, without the underscore.
    quantity : str
        What it measures, in words.
    low, high : float
        A value outside is a mistake in a file, not a measurement [unit]; wide enough for any
        machine tool, narrow enough that no sum of squares overflows.
    label : str
        The unit as a plot or a table shows it.
    switches : bool
        Whether such signals jump and then stay (speed, feed, torque, tool length), so that between
        two samples the last value holds; other signals are measured and run smoothly.
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
        # The range that any sensor on a machine tool can show; beyond it lies a broken wire.
        Unit("degC", "temperature", -60.0, 400.0, label="°C"),
        Unit("um", "displacement", -1e6, 1e6, label="µm"),
        Unit("mm", "length", -1e6, 1e6, label="mm", switches=True),
        Unit("urad", "tilt", -1e6, 1e6, label="µrad"),
        Unit("1", "flag or code", -1e9, 1e9, switches=True),
    )
}


def split_column(name: str) -> tuple[str, str]:
    """Return the signal's name and its unit's suffix.

    >>> split_column("feed_mm_min")
    ('feed', 'mm_min')

    Parameters
    ----------
    name : str
        A column's name; the longest unit that fits counts.

    Returns
    -------
    signal, unit : str

    Raises
    ------
    ValueError
        If the name does not end in a known unit, or nothing stands before the unit.
    """
    # The longest suffix first, so that a longer unit is never read as its own ending.
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
