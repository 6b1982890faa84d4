"""The OPC UA server, a separate read-only process that gets its values on standard input.

The gateway writes lines of JSON: values, or an event. This process shows them and takes nothing
from its clients: it has no writable variables or methods, and its rules refuse services that would
change anything. It ends when standard input does. For the gateway's log it prints ``ready``, or why
it cannot go on.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
import math
import os
import sys
import time
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from asyncua import Server, ua
from asyncua.common.node import Node
from asyncua.crypto.permission_rules import SimpleRoleRuleset, User, UserRole
from asyncua.crypto.truststore import TrustStore
from asyncua.crypto.validator import CertificateValidator, CertificateValidatorOptions
from asyncua.server.user_managers import UserManager

from gateway.protocols.opcua import HIGH

NAMESPACE = "https://spindle-drift.invalid/gateway"
CHANGING = (
    ua.ObjectIds.WriteRequest_Encoding_DefaultBinary,
    ua.ObjectIds.CallRequest_Encoding_DefaultBinary,
    ua.ObjectIds.HistoryUpdateRequest_Encoding_DefaultBinary,
)
POLICIES = [
    ua.SecurityPolicyType.Basic256Sha256_SignAndEncrypt,
    ua.SecurityPolicyType.Aes128Sha256RsaOaep_SignAndEncrypt,
    ua.SecurityPolicyType.Aes256Sha256RsaPss_SignAndEncrypt,
]
Value = float | int | bool | str
KINDS: dict[str, tuple[ua.VariantType, Value]] = {
    "bool": (ua.VariantType.Boolean, False),
    "int": (ua.VariantType.Int64, 0),
    "text": (ua.VariantType.String, ""),
}
"""Type and start value of variables without a unit."""


UNIT_CODES = {"degC": "CEL", "rpm": "RPM", "mm": "MMT", "um": "4H", "urad": "B97", "s": "SEC"}
"""What clients know units by: given by UNECE Recommendation 20."""
UNIT_NAMESPACE = "http://www.opcfoundation.org/UA/units/un/cefact"
NO_UNIT_ID = -1
"""Of a unit without a code: given by OPC 10000-8, as the way from a code to its id is."""


def unit_information(unit: str) -> ua.EUInformation:
    """Return a unit as clients read it."""
    shown, code = ua.LocalizedText(unit), UNIT_CODES.get(unit)
    if code is None:
        return ua.EUInformation(UnitId=NO_UNIT_ID, DisplayName=shown)
    return ua.EUInformation(UNIT_NAMESPACE, int.from_bytes(code.encode(), "big"), shown)


class Reading(SimpleRoleRuleset):
    """Lets clients read, browse and subscribe, and nothing else."""

    def __init__(self) -> None:
        super().__init__()
        self._changing = {ua.NodeId(number) for number in CHANGING}

    def check_validity(self, user: User, action_type: ua.NodeId, body: object) -> bool:
        """Return whether a service is allowed."""
        if action_type in self._changing:
            return False
        return bool(super().check_validity(user, action_type, body))


class Readers(UserManager):
    """Makes every client a reader; there are no administrators."""

    def get_user(self, *args: object, **named: object) -> User:
        """Return a reader."""
        return User(role=UserRole.User)


class Status:
    """The address space: a folder of variables, and events.

    Parameters
    ----------
    server : Server
        Initialised.
    index : int
        The namespace's number.
    """

    def __init__(self, server: Server, index: int) -> None:
        self._server, self._index = server, index
        self._nodes: dict[str, tuple[Node, ua.VariantType]] = {}
        self._heard_at = time.monotonic()
        self._stale = False

    async def make(self, title: str, variables: dict[str, dict[str, str]]) -> None:
        """Make the variables of each group.

        Parameters
        ----------
        title : str
            The folder's name.
        variables : dict
            Group, name, unit; a unit of ``bool``, ``int`` or ``text`` is a type without a unit.
        """
        # Fixed node ids: clients can store them, and no id is assigned twice.
        top = await self._server.nodes.objects.add_object(*self._named("gateway", title))
        for group, names in variables.items():
            folder = await top.add_folder(*self._named(group))
            for name, unit in names.items():
                kind, start = KINDS.get(unit, (ua.VariantType.Double, math.nan))
                code = ua.StatusCode(ua.StatusCodes.BadWaitingForInitialData)
                node = await folder.add_variable(*self._named(f"{group}.{name}"), start, kind)
                await node.write_attribute(
                    ua.AttributeIds.DisplayName,
                    ua.DataValue(ua.Variant(ua.LocalizedText(name), ua.VariantType.LocalizedText)),
                )
                if kind == ua.VariantType.Double:
                    await node.add_property(
                        ua.NodeId(f"{group}.{name}.unit", self._index),
                        ua.QualifiedName("EngineeringUnits", 0),
                        unit_information(unit),
                    )
                await node.write_value(ua.DataValue(StatusCode=code))
                self._nodes[f"{group}.{name}"] = node, kind
        self._events = await self._server.get_event_generator()

    def _named(self, name: str, shown: str = "") -> tuple[ua.NodeId, ua.QualifiedName]:
        return ua.NodeId(name, self._index), ua.QualifiedName(shown or name, self._index)

    async def show(self, values: dict[str, Value | None]) -> None:
        """Show values; None means missing."""
        self._heard_at, self._stale = time.monotonic(), False
        now = datetime.now(UTC).replace(tzinfo=None)
        for name, value in values.items():
            node, kind = self._nodes[name]
            if value is None:
                data = ua.DataValue(StatusCode=ua.StatusCode(ua.StatusCodes.BadNoData))
            else:
                data = ua.DataValue(ua.Variant(value, kind), SourceTimestamp=now)
            await node.write_value(data)

    async def event(self, text: str, severity: int) -> None:
        """Send an event to all subscribers."""
        self._events.event.Message = ua.LocalizedText(text)
        self._events.event.Severity = severity
        await self._events.trigger()

    async def watch(self, stale_s: float) -> None:
        """Mark all values as unknown if the gateway no longer updates them."""
        while True:
            await asyncio.sleep(0.5)
            if not self._stale and time.monotonic() - self._heard_at > stale_s:
                self._stale = True
                code = ua.StatusCode(ua.StatusCodes.BadNoCommunication)
                for node, _ in self._nodes.values():
                    await node.write_value(ua.DataValue(StatusCode=code))
                await self.event("the gateway no longer updates its values", HIGH)


async def serve(first: dict[str, Any]) -> None:
    """Serve until standard input ends.

    Parameters
    ----------
    first : dict
        The first line: url, title, variables, and the security files or None.
    """
    server = Server(user_manager=Readers())
    await server.init()
    server.set_endpoint(first["url"])
    server.set_server_name("spindle-drift gateway")
    server.set_identity_tokens([ua.AnonymousIdentityToken])
    await _secure(server, first["security"])
    index = await server.register_namespace(NAMESPACE)
    status = Status(server, index)
    await status.make(first["title"], first["variables"])
    async with server:
        print("ready", flush=True)
        watch = asyncio.create_task(status.watch(first["stale_s"]))
        try:
            while line := await asyncio.to_thread(sys.stdin.readline):
                news = json.loads(line)
                if "values" in news:
                    await status.show(news["values"])
                if "event" in news:
                    await status.event(news["event"], news["severity"])
        finally:
            watch.cancel()


async def _secure(server: Server, files: dict[str, str] | None) -> None:
    if files is None:
        server.set_security_policy([ua.SecurityPolicyType.NoSecurity], Reading())
        return
    server.set_security_policy(POLICIES, Reading())
    await server.load_certificate(files["certificate"])
    await server.load_private_key(files["key"])
    store = TrustStore([Path(files["trust"])], [])
    await store.load()
    options = (
        CertificateValidatorOptions.TIME_RANGE
        | CertificateValidatorOptions.TRUSTED
        | CertificateValidatorOptions.PEER_CLIENT
    )
    server.set_certificate_validator(CertificateValidator(options, store).validate)


def main() -> int:
    """Serve; on failure print a line and return 1."""
    # The gateway has priority: this process uses only spare computing time.
    with contextlib.suppress(AttributeError, OSError):
        os.nice(5)
    logging.disable(logging.CRITICAL)
    try:
        asyncio.run(serve(json.loads(sys.stdin.readline())))
    except Exception as error:  # asyncua raises many kinds of errors
        print(f"{type(error).__name__}: {' '.join(str(error).split())}", flush=True)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
