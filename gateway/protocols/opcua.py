"""OPC UA: inputs, outputs and status for the shop floor, read-only (``--opcua``).

The server is a separate process and cannot delay the gateway: a thread writes to it, and drops
lines that the server does not read. If the server is gone, the gateway logs a line and goes on.
"""

from __future__ import annotations

import argparse
import contextlib
import ipaddress
import json
import subprocess
import sys
import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from math import isfinite, nan
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from gateway.background import Background
from gateway.protocols.base import Adapter, Participant, Report, Say
from measurement.errors import BadInput
from measurement.stops import LOOK_S

if TYPE_CHECKING:
    from gateway.database import Database
    from gateway.unit import CompensatorUnit

DEFAULT_URL = "opc.tcp://127.0.0.1:4840/spindle-drift"
STATES: dict[str, str] = {
    "valid": "bool",
    "status": "int",
    "status_text": "text",
    "status_sensor": "int",
    "reference_known": "bool",
    "gateway_state": "text",
    "bus_fault": "text",
    "trust": "text",
    "machine_time": "s",
    "steps": "int",
    "compensator": "text",
    "compensator_sha256": "text",
}
LOW, HIGH = 1, 667
"""Severities of events at which the low and the high band begin: given by OPC 10000-5."""


@dataclass(frozen=True)
class Security:
    """The OPC UA server's certificate, and the clients that it accepts.

    Attributes
    ----------
    certificate, key : Path
        The server's own (DER or PEM).
    trust : Path
        Folder with the certificates of the clients or their signers.
    """

    certificate: Path
    key: Path
    trust: Path


def checked_url(url: str, security: Security | None) -> str:
    """Return a URL that the server may be bound to.

    Parameters
    ----------
    url : str
        ``opc.tcp://HOST:PORT``, with or without a path.
    security : Security or None
        Without it, only addresses that other computers cannot reach are allowed.

    Returns
    -------
    str
        The URL as given.

    Raises
    ------
    BadInput
        If it is not an OPC UA URL, asyncua is not installed, a file is missing, or other computers
        could read the values without a certificate.
    """
    parts = urlsplit(url)
    try:
        port = parts.port
    except ValueError:
        port = None
    if parts.scheme != "opc.tcp" or not parts.hostname or port is None:
        raise BadInput("--opcua", "", f"{url!r} is not of the form opc.tcp://HOST:PORT")
    if find_spec("asyncua") is None:
        raise BadInput("--opcua", "", "needs asyncua: pip install 'spindle-drift[opcua]'")
    if security is None and not _is_local(parts.hostname):
        problem = f"{parts.hostname} can be reached by others: give --opcua-cert, --opcua-key and "
        raise BadInput("--opcua", "", f"{problem}--opcua-trust")
    if security is not None:
        for name in ("certificate", "key"):
            path: Path = getattr(security, name)
            if not path.is_file():
                raise BadInput(path, "", f"there is no such {name}")
        if not security.trust.is_dir():
            raise BadInput(security.trust, "", "there is no such folder of certificates")
    return url


def _is_local(host: str) -> bool:
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


class HallStatus(Participant):
    """Passes the gateway's values and events to an OPC UA server.

    Parameters
    ----------
    url : str
        From `checked_url`.
    security : Security or None
        None: without certificates, for this computer only.
    unit : CompensatorUnit
        Gives the inputs, the outputs and their units.
    say : callable
        Takes a line for people.
    """

    def __init__(
        self,
        url: str,
        security: Security | None,
        unit: CompensatorUnit,
        say: Callable[[str], None] = lambda line: None,
    ) -> None:
        from gateway.probes import LATEST_STEPS

        self._say, self._ended = say, False
        self._inputs = list(unit.inputs)
        self._outputs = [name for name in unit.output_names if name not in STATES]
        self._sent_at = float("-inf")
        self._before: tuple[object, ...] = ()
        self._valid: bool | None = None
        self._server = subprocess.Popen(
            [sys.executable, "-m", "gateway.opcua_server"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            encoding="utf-8",
            # Only the gateway handles an interrupt from the terminal.
            start_new_session=True,
        )
        self._lines = Background()
        self._listener = threading.Thread(target=self._listen, daemon=True)
        self._listener.start()
        units = {
            group: {name: unit.unit_of(name) for name in names}
            for group, names in (("inputs", self._inputs), ("outputs", self._outputs))
        }
        files = {name: str(path) for name, path in vars(security).items()} if security else None
        first = {"url": url, "title": "Gateway", "variables": units | {"state": STATES}}
        self._write({**first, "security": files, "stale_s": LATEST_STEPS * LOOK_S})
        self._url = url

    def update(self, now: float, report: Callable[[], Report]) -> None:
        """Send the gateway's values every `LOOK_S`, and changes of its state at once."""
        shown = report()
        state = shown.state
        changed = tuple(state[key] for key in ("valid", "status", "gateway_state", "bus_fault"))
        if now - self._sent_at < LOOK_S and changed == self._before:
            return
        if changed[0] != self._valid and self._valid is not None:
            text = f"offsets are {'valid' if changed[0] else 'not valid'}: {state['status_text']}"
            self.hear(text, LOW if changed[0] else HIGH)
        self._sent_at, self._before, self._valid = now, changed, bool(changed[0])
        measures = {f"inputs.{name}": shown.given.get(name, nan) for name in self._inputs}
        measures |= {f"outputs.{name}": shown.outputs.get(name, nan) for name in self._outputs}
        values = {name: value if isfinite(value) else None for name, value in measures.items()}
        self._write({"values": values | {f"state.{key}": state[key] for key in state}})

    def hear(self, line: str, severity: int = LOW) -> None:
        """Send a line for people as an event."""
        self._write({"event": line, "severity": severity})

    def _write(self, news: Mapping[str, object]) -> None:
        if not self._ended:
            text = json.dumps(news) + "\n"
            self._lines.do(lambda: self._put(text))

    def _put(self, text: str) -> None:
        assert self._server.stdin is not None
        with contextlib.suppress(OSError, ValueError):  # it is gone: the listener reports it
            self._server.stdin.write(text)
            self._server.stdin.flush()

    def _listen(self) -> None:
        assert self._server.stdout is not None
        last = "ended"
        for line in self._server.stdout:
            last = line.strip()
            if last == "ready":
                self._say(f"OPC UA at {self._url}, read-only")
        if not self._ended:
            self._ended = True
            self._say(f"OPC UA: the server is gone ({last}); the gateway goes on without it")

    def close(self) -> None:
        """End the server."""
        self._ended = True
        if not self._lines.close():
            self._server.kill()  # it does not read its input
        with contextlib.suppress(OSError, ValueError):
            assert self._server.stdin is not None
            self._server.stdin.close()
        try:
            self._server.wait(2.0)
        except subprocess.TimeoutExpired:
            self._server.kill()
            self._server.wait(2.0)
        self._listener.join(2.0)
        assert self._server.stdout is not None
        if not self._listener.is_alive():
            self._server.stdout.close()


def security_of(files: Sequence[Path | None]) -> Security | None:
    """Return the security from certificate, key and trust folder; None if none of them is given.

    Parameters
    ----------
    files : sequence of three Path or None
        Certificate, key and the folder of trusted certificates.

    Raises
    ------
    BadInput
        If only some are given.
    """
    given = [file for file in files if file]
    if len(given) == 3:
        return Security(*given)
    if given:
        problem = "needs --opcua-key and --opcua-trust, and they need --opcua-cert"
        raise BadInput("--opcua-cert", "", problem)
    return None


class OpcUa(Adapter):
    """A server in a separate process."""

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
        """Reject a server that other computers can read without a certificate."""
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
        return HallStatus(self.args.opcua, self._security, unit, say)
