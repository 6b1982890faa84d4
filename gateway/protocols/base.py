"""The port that a protocol plugs into.

An adapter declares its arguments of ``spindle-drift gateway``. If they ask for it, it may say which
frames the gateway uses, and it may join the gateway at work: see what is sent and heard, hold it
back while its network is not ready, and show it elsewhere. Judging frames, freshness and the
compensator are none of its business.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # the help of the command must not wait for these
    import can

    from gateway.codec import Value
    from gateway.database import Database
    from gateway.mapping import Mapping as FrameMapping
    from gateway.unit import CompensatorUnit

Say = Callable[[str], None]
Send = Callable[["Iterable[can.Message]"], object]


@dataclass(frozen=True)
class Report:
    """What the gateway does at present.

    Attributes
    ----------
    answer : mapping
        The values of the newest answer.
    given : mapping of str to float
        What was heard for it.
    outputs : mapping of str to float
        The compensator's.
    state : mapping
        The gateway's own: ``valid``, ``status_text``, ``gateway_state``, …
    """

    answer: Mapping[str, Value]
    given: Mapping[str, float]
    outputs: Mapping[str, float]
    state: Mapping[str, Value | bool]


class Participant:
    """A protocol at work beside the gateway's loop; nothing of it may wait."""

    operational = True
    """Whether frames may be used and sent."""

    def update(self, now: float, report: Callable[[], Report]) -> None:
        """Do what is due at a time [s].

        Parameters
        ----------
        now : float
            Of a steady clock [s].
        report : callable
            Returns what the gateway does.
        """

    def hear(self, line: str) -> None:
        """Take a line for people.

        Parameters
        ----------
        line : str
            As it is printed.
        """

    def close(self) -> None:
        """Leave."""

    def gated(self, send: Send) -> Send:
        """Return what sends messages while this is operational.

        Parameters
        ----------
        send : callable
            Sends them in any case.
        """
        return lambda messages: send(messages) if self.operational else None


class Adapter:
    """A protocol; this base class does nothing.

    Parameters
    ----------
    args : Namespace
        The command line.
    """

    def __init__(self, args: argparse.Namespace) -> None:
        self.args = args

    @classmethod
    def add_arguments(cls, parser: argparse.ArgumentParser) -> None:
        """Declare its arguments."""

    def check(self) -> None:
        """Refuse arguments that make no sense, before anything is loaded.

        Raises
        ------
        BadInput
            For the first that does not.
        """

    def printed(self, fmu: Path) -> str | None:
        """Return what the command only prints, if that was asked for.

        Parameters
        ----------
        fmu : Path
            The compensator.
        """
        return None

    def mapping(self, fmu: Path) -> FrameMapping | None:
        """Return the frames that the gateway is to use, if this protocol says so.

        Parameters
        ----------
        fmu : Path
            The compensator.
        """
        return None

    def join(
        self, database: Database, fmu: Path, unit: CompensatorUnit, say: Say
    ) -> Participant | None:
        """Begin to take part, if that was asked for.

        Parameters
        ----------
        database : Database
            The frames in use.
        fmu : Path
            The compensator.
        unit : CompensatorUnit
            The same, loaded.
        say : callable
            Takes a line for people.
        """
        return None
