"""OPC UA: inputs, outputs and status for the hall, read-only (``--opcua``)."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from gateway.protocols.base import Adapter, Participant, Say
from measurement.errors import BadInput

if TYPE_CHECKING:
    from gateway.database import Database
    from gateway.unit import CompensatorUnit

DEFAULT_URL = "opc.tcp://127.0.0.1:4840/spindle-drift"


class OpcUa(Adapter):
    """A server in a process of its own."""

    @classmethod
    def add_arguments(cls, parser: argparse.ArgumentParser) -> None:
        """Declare its arguments."""
        add = parser.add_argument
        text = f"show inputs, outputs and status by OPC UA, read-only ({DEFAULT_URL})"
        add("--opcua", nargs="?", const=DEFAULT_URL, metavar="URL", help=text)
        add("--opcua-cert", type=Path, metavar="FILE", help="the OPC UA server's certificate")
        text = "key of the OPC UA server's certificate"
        add("--opcua-key", type=Path, metavar="FILE", help=text)
        text = "certificates of the clients that may read, or of those who signed them"
        add("--opcua-trust", type=Path, metavar="DIR", help=text)

    def check(self) -> None:
        """Refuse a server that is open to others."""
        from gateway.opcua import checked_url, security_of

        args = self.args
        self._security = security_of((args.opcua_cert, args.opcua_key, args.opcua_trust))
        if args.opcua is not None:
            checked_url(args.opcua, self._security)
        elif self._security is not None:
            raise BadInput("--opcua-cert", "", "has no meaning without --opcua")

    def join(
        self, database: Database, fmu: Path, unit: CompensatorUnit, say: Say
    ) -> Participant | None:
        """Start the server."""
        if self.args.opcua is None:
            return None
        from gateway.opcua import HallStatus

        return HallStatus(self.args.opcua, self._security, unit, say)
