"""The interface for protocols.

An adapter declares its arguments of ``spindle-drift gateway``. If requested by these, it may choose
the frames that the gateway uses, and it may join the running gateway: read what is sent and
received, hold it back while its network is not ready, and show it elsewhere. It has no part in
checking frames and freshness, nor in the compensator.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # not imported just to print the command's help
    import can

    from gateway.codec import Value
    from gateway.database import Database
    from gateway.mapping import Mapping as FrameMapping
    from gateway.unit import CompensatorUnit

Say = Callable[[str], None]
Send = Callable[["Iterable[can.Message]"], object]


@dataclass(frozen=True)
class Report:
    """The gateway's present values and state.

    Attributes
    ----------
    answer : mapping
        The values of the newest answer.
    given : mapping of str to float
        The inputs received for it.
    outputs : mapping of str to float
        The compensator's outputs; NaN for an uncertainty that nothing bounds.
    state : mapping
        The gateway's own state: ``valid``, ``status_text``, ``gateway_state``, …
    """

    answer: Mapping[str, Value]
    given: Mapping[str, float]
    outputs: Mapping[str, float]
    state: Mapping[str, Value | bool]


class Participant:
    """A protocol that takes part in the gateway's loop; its methods must not block."""

    operational = True
    """Whether frames may be used and sent."""

    def update(self, now: float, report: Callable[[], Report]) -> None:
        """Do what is due at a time [s].

        Parameters
        ----------
        now : float
            Of a monotonic clock [s].
        report : callable
            Returns the gateway's present report.
        """

    def hear(self, line: str) -> None:
        """Take a line for people.

        Parameters
        ----------
        line : str
            The line as printed.
        """

    def close(self) -> None:
        """Stop taking part."""

    def gated(self, send: Send) -> Send:
        """Return a function that sends messages only while this is operational.

        Parameters
        ----------
        send : callable
            Sends messages in any case.
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
        """Declare the protocol's arguments."""

    def check(self) -> None:
        """Reject arguments that make no sense, before anything is loaded.

        Raises
        ------
        BadInput
            For the first bad argument.
        """

    def printed(self, fmu: Path) -> str | None:
        """Return the text to print instead of running the gateway, if requested.

        Parameters
        ----------
        fmu : Path
            The compensator.
        """
        return None

    def mapping(self, fmu: Path) -> FrameMapping | None:
        """Return the frames for the gateway, if this protocol chooses them.

        Parameters
        ----------
        fmu : Path
            The compensator.
        """
        return None

    def join(
        self, database: Database, fmu: Path, unit: CompensatorUnit, say: Say
    ) -> Participant | None:
        """Begin to take part, if requested.

        Parameters
        ----------
        database : Database
            The frames in use.
        fmu : Path
            The compensator.
        unit : CompensatorUnit
            The compensator, loaded.
        say : callable
            Takes a line for people.
        """
        return None
