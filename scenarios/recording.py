"""What a co-simulation leaves behind."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import pandas as pd

from scenarios.fmu import Slave
from scenarios.scenario import Case


@dataclass(frozen=True)
class Event:
    """A moment at which the compensator's status changed: time [s], code, sensor blamed, text."""

    time_s: float
    code: int
    sensor: int
    text: str


def notice(
    events: list[Event], time_s: float, code: int, sensor: int, text: Callable[[], str]
) -> None:
    """Keep the moment if the status has changed.

    Parameters
    ----------
    events : list of Event
        Those so far.
    time_s : float
        The moment [s].
    code, sensor : int
        The status, and the sensor that it is about.
    text : callable
        Asks the compensator what it says of it.
    """
    if not events or (events[-1].code, events[-1].sensor) != (code, sensor):
        events.append(Event(time_s, code, sensor, text()))


@dataclass(frozen=True)
class FmuFacts:
    """Which FMU took part: enough to know it again."""

    label: str
    file: str
    model: str
    guid: str
    sha256: str
    tool: str


@dataclass(frozen=True)
class Recording:
    """What happened in one case, every communication point.

    Attributes
    ----------
    case : Case
        What was simulated.
    frame : DataFrame
        ``time_s`` and one column ``name_unit`` a signal: the plant's inputs and outputs as they
        are, ``<sensor>_seen`` where a fault changed what the compensator saw, and the
        compensator's outputs.
    sensors : tuple of str
        Columns that the machine's thermometers and displacement sensors show.
    events : tuple of Event
        Changes of the compensator's status.
    fmus : tuple of FmuFacts
        Who took part.
    wall_s : float
        How long the loop took [s].
    """

    case: Case
    frame: pd.DataFrame
    sensors: tuple[str, ...]
    events: tuple[Event, ...]
    fmus: tuple[FmuFacts, ...]
    wall_s: float


def facts_of(slave: Slave) -> FmuFacts:
    """Return what tells an FMU from others."""
    description = slave.description
    return FmuFacts(
        slave.label,
        slave.path.name,
        description.modelName,
        description.guid,
        slave.sha256,
        description.generationTool or "",
    )
