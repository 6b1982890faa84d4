"""The recording of a co-simulation."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import pandas as pd

from fmu_compensator.monitoring.sensors import WORTH_SHARE
from fmu_compensator.runtime.compensator import AT_ZERO, WAITING
from scenarios.fmu import Slave
from scenarios.scenario import Case


@dataclass(frozen=True)
class Event:
    """A change of the compensator's status: time [s], code, sensor concerned, text."""

    time_s: float
    code: int
    sensor: int
    text: str


def notice(
    events: list[Event], time_s: float, code: int, sensor: int, text: Callable[[], str]
) -> None:
    """Append an event if the status has changed; while it waits, keep the latest text.

    Only the text tells that the speed or the tool length, which are no sensors, is missing.

    Parameters
    ----------
    events : list of Event
        The events so far.
    time_s : float
        The time [s].
    code, sensor : int
        The status, and the sensor concerned.
    text : callable
        Returns the compensator's text on it.
    """
    if not events or (events[-1].code, events[-1].sensor) != (code, sensor):
        events.append(Event(time_s, code, sensor, text()))
    elif (code, sensor) == (WAITING, 0):
        events[-1] = replace(events[-1], text=text())


def without_offsets(name: str, frame: pd.DataFrame, events: Sequence[Event]) -> list[str]:
    """Return notes on why a run has no offsets, or none for a good part of it.

    Parameters
    ----------
    name : str
        Of the run, for the notes.
    frame : DataFrame
        With the compensator's status, ``status_1``.
    events : sequence of Event
        Changes of the status.
    """
    status = frame["status_1"].to_numpy()
    idle = (status == WAITING) | (status >= AT_ZERO)
    if idle.mean() < WORTH_SHARE:
        return []
    # The last event explains why it stopped; at a first sample it merely waits.
    said = [event for event in events if event.code == WAITING or event.code >= AT_ZERO]
    if (status == WAITING).all():
        return [f"{name}: the compensator never started: {said[-1].text}."]
    since = said[-1].time_s / 60.0
    return [
        f"{name}: no offsets in {idle.mean():.0%} of the samples, last from "
        f"{since:.0f} min on: {said[-1].text}."
    ]


@dataclass(frozen=True)
class FmuFacts:
    """Facts that identify an FMU that took part."""

    label: str
    file: str
    model: str
    guid: str
    sha256: str
    tool: str


@dataclass(frozen=True)
class Recording:
    """The recording of one case at every communication point.

    Attributes
    ----------
    case : Case
        The simulated case.
    frame : DataFrame
        ``time_s`` and one column ``name_unit`` per signal: the plant's true inputs and outputs,
        ``<sensor>_seen`` if a fault changed what the compensator saw, and the compensator's
        outputs.
    sensors : tuple of str
        Columns of the machine's thermometers and displacement sensors.
    inputs : dict of str to str
        Run-file columns of the machine's inputs, by their own.
    events : tuple of Event
        Changes of the compensator's status.
    fmus : tuple of FmuFacts
        The FMUs that took part.
    wall_s : float
        Duration of the loop [s].
    """

    case: Case
    frame: pd.DataFrame
    sensors: tuple[str, ...]
    inputs: dict[str, str]
    events: tuple[Event, ...]
    fmus: tuple[FmuFacts, ...]
    wall_s: float


def facts_of(slave: Slave) -> FmuFacts:
    """Return the facts that identify an FMU."""
    description = slave.description
    return FmuFacts(
        slave.label,
        slave.path.name,
        description.modelName,
        description.guid,
        slave.sha256,
        description.generationTool or "",
    )
