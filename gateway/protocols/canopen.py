"""CANopen: the gateway as a node that a master starts (``--canopen``)."""

from __future__ import annotations

import argparse
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gateway.protocols.base import Adapter, Participant, Say
from measurement.errors import BadInput

if TYPE_CHECKING:
    from gateway.database import Database
    from gateway.mapping import Mapping
    from gateway.unit import CompensatorUnit


def node_mapping(node_id: int, fmu: Path) -> Mapping:
    """Return the PDOs of a CANopen node that serves a compensator.

    Parameters
    ----------
    node_id : int
        1 to 127.
    fmu : Path
        The compensator.

    Raises
    ------
    BadInput
        If the canopen library is not installed, or the compensator does not fit.
    """
    if find_spec("canopen") is None:
        raise BadInput("--canopen", "", "needs canopen: pip install 'spindle-drift[canopen]'")
    from gateway.canopen_pdo import canopen_mapping
    from gateway.mapcheck import inputs_of

    return canopen_mapping(node_id, inputs_of(fmu))


def node_dictionary(node_id: int, fmu: Path) -> Any:
    """Return the object dictionary of such a node.

    Parameters
    ----------
    node_id : int
        1 to 127.
    fmu : Path
        The compensator.
    """
    from gateway.canopen_pdo import dictionary
    from gateway.mapcheck import inputs_of, limits_of
    from measurement.files import sha256_of

    return dictionary(node_id, inputs_of(fmu), fmu.name, sha256_of(fmu), limits_of(fmu))


def node_eds(node_id: int, fmu: Path) -> str:
    """Return the data sheet of such a node.

    Parameters
    ----------
    node_id : int
        1 to 127.
    fmu : Path
        The compensator.
    """
    from gateway.canopen_pdo import eds_text

    return eds_text(node_dictionary(node_id, fmu))


class CanOpen(Adapter):
    """A node with PDOs, SDO, NMT, heartbeat and EMCY."""

    @classmethod
    def add_arguments(cls, parser: argparse.ArgumentParser) -> None:
        """Declare its arguments."""
        text = "be the CANopen node of this number (1 to 127)"
        parser.add_argument("--canopen", type=int, metavar="ID", help=text)
        text = "print the CANopen node's data sheet, and end"
        parser.add_argument("--eds", action="store_true", help=text)

    def check(self) -> None:
        """Refuse frames beside its own."""
        if self.args.canopen is None and self.args.eds:
            raise BadInput("--eds", "", "needs --canopen: of which node")
        if self.args.canopen is not None and (self.args.map is not None or self.args.dbc):
            raise BadInput("--canopen", "", "has PDOs for frames: no --map, no --dbc")

    def printed(self, fmu: Path) -> str | None:
        """Return the data sheet, if it was asked for."""
        return node_eds(self.args.canopen, fmu) if self.args.eds else None

    def mapping(self, fmu: Path) -> Mapping | None:
        """Return the PDOs."""
        return None if self.args.canopen is None else node_mapping(self.args.canopen, fmu)

    def join(
        self, database: Database, fmu: Path, unit: CompensatorUnit, say: Say
    ) -> Participant | None:
        """Come to the bus as a node."""
        if self.args.canopen is None:
            return None
        from gateway.canopen_node import CanOpenNode
        from gateway.options import options_of

        bus = {"interface": self.args.interface, "channel": self.args.channel}
        return CanOpenNode(
            *(self.args.canopen, node_dictionary(self.args.canopen, fmu), database),
            bus | options_of(self.args.option),
            say,
        )
