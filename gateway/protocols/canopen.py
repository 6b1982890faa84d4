"""CANopen: the gateway as a node that a master starts (``--canopen``)."""

from __future__ import annotations

import argparse
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from gateway.protocols.base import Adapter, Participant, Say
from measurement.errors import BadInput

if TYPE_CHECKING:
    from gateway.database import Database
    from gateway.mapping import Mapping
    from gateway.unit import CompensatorUnit


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
        """Reject other frames next to its own, and an installation without the library."""
        if self.args.canopen is None and self.args.eds:
            raise BadInput("--eds", "", "needs --canopen: of which node")
        if self.args.canopen is not None and (self.args.map is not None or self.args.dbc):
            raise BadInput("--canopen", "", "has PDOs for frames: no --map, no --dbc")
        if self.args.canopen is not None and find_spec("canopen") is None:
            raise BadInput("--canopen", "", "needs canopen: pip install 'spindle-drift[canopen]'")

    def printed(self, fmu: Path) -> str | None:
        """Return the data sheet, if requested."""
        if not self.args.eds:
            return None
        from gateway.canopen_pdo import node_eds

        return node_eds(self.args.canopen, fmu)

    def mapping(self, fmu: Path) -> Mapping | None:
        """Return the PDOs."""
        if self.args.canopen is None:
            return None
        from gateway.canopen_pdo import node_mapping

        return node_mapping(self.args.canopen, fmu)

    def join(
        self, database: Database, fmu: Path, unit: CompensatorUnit, say: Say
    ) -> Participant | None:
        """Join the bus as a node."""
        if self.args.canopen is None:
            return None
        from gateway.canopen_node import CanOpenNode
        from gateway.canopen_pdo import node_dictionary
        from scenarios.assignments import options_of

        bus = {"interface": self.args.interface, "channel": self.args.channel}
        return CanOpenNode(
            *(self.args.canopen, node_dictionary(self.args.canopen, fmu), database),
            bus | options_of(self.args.option),
            say,
        )
