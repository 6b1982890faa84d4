"""The gateway as a CANopen node: NMT, heartbeat, EMCY and SDO in addition to its PDOs.

The gateway handles PDOs like any other frames. Everything else goes through the canopen library, on
a separate connection to the same bus. The gateway's own loop sends the heartbeat, not a thread, so
that a hanging gateway does not look alive.
"""

from __future__ import annotations

import contextlib
import time
from collections import deque
from collections.abc import Callable, Mapping
from math import isfinite
from typing import Any

import can
import canopen
from canopen.nmt import NmtSlave
from canopen.objectdictionary import ODVariable
from canopen.sdo import SdoAbortedError, SdoServer
from canopen.sdo.constants import NO_MORE_DATA, SDO_STRUCT

from gateway.canopen_pdo import FAULT, RECEIVE, SENSOR, STATUS, VALID, heartbeat_ms, layout
from gateway.codec import Value, raw_of
from gateway.database import Database, Signal
from gateway.link import ECHOING
from gateway.protocols.base import Participant, Report
from measurement.errors import BadInput

HALTED, OPERATIONAL = 4, 5
"""NMT states in a heartbeat, of which CiA 301 calls the first STOPPED: given by CiA 301."""
GENERIC, COMMUNICATION, MANUFACTURER = 0x01, 0x10, 0x80
"""Bits of the error register: given by CiA 301."""
NO_ERROR, COMMUNICATION_ERROR, DEVICE_SPECIFIC = 0x0000, 0x8100, 0xFF00
COLLISION, TOO_SHORT, TOO_LONG = 0x8150, 0x8210, 0x8220
"""Error codes: given by CiA 301; the compensator's status is added to the last."""
UNKNOWN_COMMAND, NO_SUBINDEX = 0x05040001, 0x06090011
"""SDO abort codes, for an unknown command and an unknown sub-index: given by CiA 301."""
REQUEST_BYTES = 8
"""Length of an SDO request: given by CiA 301."""
BASE_FRAMES: dict[str, Any] = {"can_filters": [{"can_id": 0, "can_mask": 0, "extended": False}]}
"""Setting of python-can: frames with identifiers of 11 bits, the only ones of CANopen."""
STOPPED = ("starting", "ready")
"""States of a gateway that has no fault to report yet."""


class _Nmt(NmtSlave):
    """Keeps the heartbeat period; the gateway's loop sends the heartbeat."""

    beat_ms = 0

    def start_heartbeat(self, heartbeat_time_ms: int) -> None:
        self.beat_ms = heartbeat_time_ms

    def stop_heartbeat(self) -> None:
        self.beat_ms = 0


class _Sdo(SdoServer):
    """Handles requests that the library's server answers without a transfer, or not at all."""

    _open = ""

    def __init__(self, rx_cobid: int, tx_cobid: int, node: canopen.LocalNode) -> None:
        super().__init__(rx_cobid, tx_cobid, node)
        self._index = self._subindex = 0

    def on_request(self, can_id: int, data: bytearray, timestamp: float) -> None:
        """Answer a request, except in the state STOPPED."""
        if len(data) == REQUEST_BYTES and self._node.nmt._state != HALTED:
            super().on_request(can_id, data, timestamp)

    def abort(self, abort_code: int = 0x08000000) -> None:
        """Abort a transfer, which then cannot go on."""
        self._open = ""
        super().abort(abort_code)

    def _begin(self, way: str, initiate: Callable[[bytes], None], request: bytes) -> None:
        self._buffer, self._open = None, ""
        initiate(request)
        if self._buffer is not None:  # the value does not fit into one frame
            self._open = way

    def init_upload(self, request: bytes) -> None:
        self._begin("upload", super().init_upload, request)

    def init_download(self, request: bytes) -> None:
        self._begin("download", super().init_download, request)

    def segmented_upload(self, command: int) -> None:
        if self._open != "upload":
            raise SdoAbortedError(UNKNOWN_COMMAND)
        super().segmented_upload(command)
        self._open = self._open if self._buffer else ""

    def segmented_download(self, command: int, request: bytes) -> None:
        if self._open != "download":
            raise SdoAbortedError(UNKNOWN_COMMAND)
        super().segmented_download(command, request)
        self._open = "" if command & NO_MORE_DATA else self._open

    def block_upload(self, data: bytes) -> None:
        """Change to a segmented transfer, if the client allows it.

        The client allows it up to the size in byte 5, the protocol switch threshold; 0 means never.
        """
        _, self._index, self._subindex = SDO_STRUCT.unpack_from(data)
        if data[0] & 0x03:
            raise SdoAbortedError(UNKNOWN_COMMAND)  # no block transfer was begun
        size = len(self._node.get_data(self._index, self._subindex, check_readable=True))
        if not 0 < size <= data[5]:
            raise SdoAbortedError(UNKNOWN_COMMAND)
        self.init_upload(data)

    def request_aborted(self, data: bytes) -> None:
        self._open = ""
        super().request_aborted(data)


class _Node(canopen.LocalNode):
    def __init__(self, node_id: int, dictionary: canopen.ObjectDictionary) -> None:
        super().__init__(node_id, dictionary)
        self.sdo = _Sdo(0x600 + node_id, 0x580 + node_id, self)
        self.nmt = _Nmt(node_id, self)
        self._write_callbacks = [self.nmt.on_write]

    def _find_object(self, index: int, subindex: int) -> ODVariable:
        variable: ODVariable = super()._find_object(index, subindex)
        if variable.subindex != subindex:
            raise SdoAbortedError(NO_SUBINDEX)
        return variable


class CanOpenNode(Participant):
    """What a CANopen master sees of the gateway, except its PDOs.

    Parameters
    ----------
    node_id : int
        1 to 127.
    dictionary : ObjectDictionary
        From `canopen_pdo.node_dictionary`.
    database : Database
        The PDOs as frames.
    bus : dict
        Interface, channel and options of python-can.
    say : callable
        Takes a line for people.
    listen_s : float, optional
        How long to listen for another node with this number before the first message [s].

    Raises
    ------
    BadInput
        If there is another node with this number.
    """

    def __init__(
        self,
        node_id: int,
        dictionary: canopen.ObjectDictionary,
        database: Database,
        bus: Mapping[str, Any],
        say: Callable[[str], None] = lambda line: None,
        listen_s: float | None = None,
    ) -> None:
        self._network, self._bus = canopen.Network(), {**bus, **BASE_FRAMES}
        self._network.connect(**self._bus)
        self._node = _Node(node_id, dictionary)
        self._network.add_node(self._node)
        self._node.add_read_callback(self._read)
        self._raw: dict[tuple[int, int], int] = {}
        pdos = layout([n for n, signal in database.named.items() if signal.unit == "degC"])
        self._places = {
            entry.name: ((entry.index, entry.sub), database.signal(entry.name))
            for pdo in pdos
            for entry in pdo.entries
        }
        self._say = say
        self._beaten_at = float("-inf")
        self._emergency = (NO_ERROR, 0, 0, 0)
        self._echoes = str(bus.get("interface")) in ECHOING
        self._sent = self._heard = 0
        self._collided = False
        self._wrong: dict[int, int] = {}
        self._lengths: deque[tuple[int, int]] = deque(maxlen=100)
        self._network.subscribe(0x700 + node_id, self._hear_node)
        for pdo in pdos:
            if pdo.way == RECEIVE:
                weigh = self._weigher(pdo.number, pdo.size)
                self._network.subscribe(pdo.cob_id(node_id), weigh)
        until = time.monotonic() + (2e-3 * heartbeat_ms() if listen_s is None else listen_s)
        while time.monotonic() < until and not self._heard:
            time.sleep(0.02)
        if self._heard:
            self.close()
            raise BadInput("--canopen", "", f"{node_id} is the number of another node on this bus")
        self._boot()

    def _hear_node(self, cob_id: int, data: bytearray, timestamp: float) -> None:
        self._heard += 1

    def _weigher(self, number: int, size: int) -> Callable[[int, bytearray, float], None]:
        return lambda cob_id, data, timestamp: self._lengths.append((number, len(data) - size))

    @property
    def operational(self) -> bool:  # type: ignore[override]
        """Whether the master has started the node; PDOs are used and sent only then."""
        return bool(self._node.nmt._state == OPERATIONAL) and not self._collided

    def _boot(self) -> None:
        with contextlib.suppress(can.CanError, OSError):
            self._sent += 1
            self._node.nmt.state = "INITIALISING"
            self._node.nmt.state = "PRE-OPERATIONAL"

    def _read(self, index: int, subindex: int, **more: object) -> int | None:
        return self._raw.get((index, subindex))

    def update(self, now: float, report: Callable[[], Report]) -> None:
        """Update the objects to the newest values; send a heartbeat or an EMCY if one is due."""
        reported = report()
        answer, given = reported.answer, reported.given
        for name, (place, signal) in self._places.items():
            value = answer.get(name, given.get(name, float("nan")))
            self._raw[place] = _raw(signal, value)
        nmt = self._node.nmt
        with contextlib.suppress(can.CanError, OSError):
            if reported.state["gateway_state"] != "reconnecting":
                self._reconnect()
            if nmt._state == 0:  # the master asked for a reset
                self._say("CANopen: reset by the master")
                self._node.data_store.clear()  # what the master has written
                self._boot()
            if nmt.beat_ms and now - self._beaten_at >= nmt.beat_ms / 1e3:
                self._beaten_at = now
                self._sent += 1
                self._network.send_message(0x700 + nmt.id, [nmt._state])
            self._look_around(nmt.id)
            if self.operational:
                self._complain(answer)
                self._complain_of_lengths()

    def _reconnect(self) -> None:
        """Reconnect after the bus was lost, which ended the library's thread."""
        notifier = self._network.notifier
        if notifier is not None and notifier.exception is not None:
            with contextlib.suppress(can.CanError, OSError):
                self._network.disconnect()  # raises once more what ended the thread
            self._network.connect(**self._bus)

    def _complain(self, answer: Mapping[str, Value]) -> None:
        status, sensor, fault = (self._raw[index, 0] for index in (STATUS, SENSOR, FAULT))
        code, register = NO_ERROR, 0
        if not self._raw[VALID, 0] and answer.get("gateway_state") not in STOPPED:
            code, register = DEVICE_SPECIFIC + status, GENERIC | MANUFACTURER
            if status == 0 and fault:
                code, register = COMMUNICATION_ERROR, GENERIC | COMMUNICATION
        emergency = (code, status, sensor, fault) if code else (NO_ERROR, 0, 0, 0)
        register |= GENERIC | COMMUNICATION if any(self._wrong.values()) else 0
        self._raw[0x1001, 0] = register
        if emergency != self._emergency:
            self._emergency = emergency
            self._node.emcy.send(code, register, bytes(emergency[1:]))

    def _look_around(self, node_id: int) -> None:
        """Stop if another node with the same number has joined the bus."""
        if self._heard > (self._sent if self._echoes else 0) and not self._collided:
            self._collided = True
            self._say(f"CANopen: another node {node_id} is on this bus; no PDO is used or sent")
            self._node.emcy.send(COLLISION, GENERIC | COMMUNICATION)

    def _complain_of_lengths(self) -> None:
        """Send an EMCY when an RPDO gets a wrong length, and when its length is right again."""
        while self._lengths:
            number, more = self._lengths.popleft()
            code = NO_ERROR if not more else TOO_LONG if more > 0 else TOO_SHORT
            if code == self._wrong.get(number, NO_ERROR):
                continue
            self._wrong[number] = code
            if code or not self._emergency[0]:
                register = GENERIC | COMMUNICATION if code else 0
                self._node.emcy.send(code, register, bytes((number,)))

    def close(self) -> None:
        """Leave the bus."""
        with contextlib.suppress(can.CanError, OSError, RuntimeError):
            self._network.disconnect()


def _raw(signal: Signal, value: Value) -> int:
    if not isinstance(value, str) and not isfinite(value) and signal.is_enumeration:
        return 0
    return int(raw_of(signal, value))
