"""The gateway as a CANopen node: NMT, heartbeat, EMCY and SDO beside its PDOs.

The PDOs are frames of the gateway as any others. Everything else goes through the canopen library,
on a connection of its own to the same bus. The heartbeat is sent by the gateway's own loop, not by
a thread: a gateway that hangs shall not look alive.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Mapping
from math import isfinite
from typing import Any

import can
import canopen
from canopen.nmt import NmtSlave

from gateway.canopen_pdo import FAULT, SENSOR, STATUS, VALID, layout
from gateway.codec import Value
from gateway.database import Database

OPERATIONAL = 5
GENERIC, COMMUNICATION, MANUFACTURER = 0x01, 0x10, 0x80
"""Bits of the error register."""
NO_ERROR, COMMUNICATION_ERROR, DEVICE_SPECIFIC = 0x0000, 0x8100, 0xFF00
"""Error codes by CiA 301; the compensator's status is added to the last."""
STOPPED = ("starting", "ready")
"""States of a gateway that has nothing to complain of yet."""


class _Nmt(NmtSlave):
    """Keeps the heartbeat's time; the gateway's loop sends it."""

    beat_ms = 0

    def start_heartbeat(self, heartbeat_time_ms: int) -> None:
        self.beat_ms = heartbeat_time_ms

    def stop_heartbeat(self) -> None:
        self.beat_ms = 0


class _Node(canopen.LocalNode):
    def __init__(self, node_id: int, dictionary: canopen.ObjectDictionary) -> None:
        super().__init__(node_id, dictionary)
        self.nmt = _Nmt(node_id, self)
        self._write_callbacks = [self.nmt.on_write]


class CanOpenNode:
    """What a CANopen master sees of the gateway beside its PDOs.

    Parameters
    ----------
    node_id : int
        1 to 127.
    dictionary : ObjectDictionary
        From `canopen_pdo.dictionary`.
    database : Database
        The PDOs as frames.
    bus : dict
        Interface, channel and options of python-can.
    say : callable
        Takes a line for people.
    """

    def __init__(
        self,
        node_id: int,
        dictionary: canopen.ObjectDictionary,
        database: Database,
        bus: Mapping[str, Any],
        say: Callable[[str], None] = lambda line: None,
    ) -> None:
        self._network = canopen.Network()
        self._network.connect(**bus)
        self._node = _Node(node_id, dictionary)
        self._network.add_node(self._node)
        self._node.add_read_callback(self._read)
        self._raw: dict[tuple[int, int], int] = {}
        self._places = _places(dictionary, database)
        self._say = say
        self._beaten_at = float("-inf")
        self._emergency = (NO_ERROR, 0, 0, 0)
        self._boot()

    @property
    def operational(self) -> bool:
        """Whether the master has started the node: only then PDOs are used and sent."""
        return bool(self._node.nmt._state == OPERATIONAL)

    def _boot(self) -> None:
        with contextlib.suppress(can.CanError, OSError):
            self._node.nmt.state = "INITIALISING"
            self._node.nmt.state = "PRE-OPERATIONAL"

    def _read(self, index: int, subindex: int, **more: object) -> int | None:
        return self._raw.get((index, subindex))

    def gated(
        self, send: Callable[[Iterable[can.Message]], object]
    ) -> Callable[[Iterable[can.Message]], object]:
        """Return what sends PDOs, while the node is operational.

        Parameters
        ----------
        send : callable
            Sends messages at once, in whatever state the node is.
        """
        return lambda messages: send(messages) if self.operational else None

    def update(self, now: float, told: Mapping[str, Value], given: Mapping[str, float]) -> None:
        """Show what the gateway sent and heard last; send a heartbeat or an EMCY if one is due.

        Parameters
        ----------
        now : float
            Monotonic time [s].
        told, given : mapping
            The newest answer, and what was heard for it.
        """
        for name, (place, raw_of) in self._places.items():
            value = told.get(name, given.get(name, float("nan")))
            self._raw[place] = raw_of(value)
        nmt = self._node.nmt
        with contextlib.suppress(can.CanError, OSError):
            if nmt._state == 0:  # the master asked for a reset
                self._say("CANopen: reset by the master")
                self._boot()
            if nmt.beat_ms and now - self._beaten_at >= nmt.beat_ms / 1e3:
                self._beaten_at = now
                self._network.send_message(0x700 + nmt.id, [nmt._state])
            if self.operational:
                self._complain(told)

    def _complain(self, told: Mapping[str, Value]) -> None:
        status, sensor, fault = (self._raw[index, 0] for index in (STATUS, SENSOR, FAULT))
        code, register = NO_ERROR, 0
        if not self._raw[VALID, 0] and told.get("gateway_state") not in STOPPED:
            code, register = DEVICE_SPECIFIC + status, GENERIC | MANUFACTURER
            if status == 0 and fault:
                code, register = COMMUNICATION_ERROR, GENERIC | COMMUNICATION
        emergency = (code, status, sensor, fault) if code else (NO_ERROR, 0, 0, 0)
        self._raw[0x1001, 0] = register
        if emergency != self._emergency:
            self._emergency = emergency
            self._node.emcy.send(code, register, bytes(emergency[1:]))

    def close(self) -> None:
        """Leave the bus."""
        with contextlib.suppress(can.CanError, OSError, RuntimeError):
            self._network.disconnect()


def _places(
    dictionary: canopen.ObjectDictionary, database: Database
) -> dict[str, tuple[tuple[int, int], Callable[[Value], int]]]:
    """Return where each signal of a PDO stands, and what makes its raw value."""
    from gateway.codec import raw_of

    signals = {s.name: s for frame in database.frames for s in frame.signals.values()}
    temperatures = [name for name, s in signals.items() if s.unit == "degC"]
    found: dict[str, tuple[tuple[int, int], Callable[[Value], int]]] = {}
    for pdo in layout(temperatures):
        for entry in pdo.entries:
            signal = signals[entry.name]

            def raw(value: Value, signal: Any = signal) -> int:
                if not isinstance(value, str) and not isfinite(value) and signal.is_enumeration:
                    return 0
                return int(raw_of(signal, value))

            found[entry.name] = (entry.index, entry.sub), raw
    return found
