"""The gateway's answer: the compensator's outputs, and what is sent with them."""

from __future__ import annotations

from collections.abc import Mapping
from math import nan
from typing import Protocol

from gateway.codec import Value
from gateway.database import COMPENSATOR, Database
from measurement.rig import AXES


class Unit(Protocol):
    """What the gateway needs of a compensator; `unit.CompensatorUnit` is one."""

    inputs: list[str]
    probed: list[str]
    outputs: dict[str, float]
    time_s: float

    def step(self, values: Mapping[str, float], step_s: float) -> dict[str, float]:
        """Take in a sample and advance."""

    def renew(self) -> None:
        """Forget everything: the next sample is the first."""

    def text(self) -> str:
        """Return the status in words."""


class Answered:
    """Which time of the machine is answered, as the wire carries it.

    Parameters
    ----------
    database : Database
        The frames; a machine that sends no time of its own is answered without one.
    """

    def __init__(self, database: Database) -> None:
        signals = database.closing(COMPENSATOR).signals
        timed = "answered_time" in signals and database.has("machine_time")
        self._count = 1 << signals["answered_time"].bits if timed else 1
        self._scale = database.signal("machine_time").scale if timed else 0.0

    def value(self, raw: int) -> float:
        """Return what names a raw machine time [s]."""
        return raw % self._count * self._scale


def by_tool_length(outputs: Mapping[str, float], tool_length_mm: float) -> dict[str, Value]:
    """Return per axis the offset [um], its change with the tool length [um/m], and that [mm].

    Over the tool length the offset of an axis changes by the tilt, with the opposite sign;
    1 urad is 1 um/m. Z does not depend on it, to second order.

    Parameters
    ----------
    outputs : mapping of str to float
        Those of the compensator [um, urad].
    tool_length_mm : float
        At which they hold [mm].
    """
    slopes = {"X": -outputs.get("yaw", nan), "Y": -outputs.get("pitch", nan), "Z": 0.0}
    found: dict[str, Value] = {}
    for axis in AXES:
        found[f"d{axis}_at_tool_length"] = outputs.get(f"d{axis}", nan)
        found[f"d{axis}_per_tool_length"] = slopes[axis]
        found[f"d{axis}_tool_length"] = tool_length_mm
    return found


def half_widths(outputs: Mapping[str, float], *, known: bool) -> dict[str, Value]:
    """Return the uncertainty of each axis [um]; NaN where nothing bounds it.

    Parameters
    ----------
    outputs : mapping of str to float
        Those of the compensator; it gives -1 for what it does not know [um].
    known : bool
        Whether it is known what the drift is counted from.
    """
    names = [f"d{axis}_uncertainty" for axis in AXES]
    widths = {name: outputs.get(name, nan) if known else nan for name in names}
    return {name: width if width >= 0.0 else nan for name, width in widths.items()}
