"""A DBC file of the gateway's own form, read and checked."""

from __future__ import annotations

from math import inf, isfinite
from pathlib import Path
from typing import Any

import cantools
from cantools.database.can import Database as CanDatabase
from cantools.database.can import Message
from cantools.database.can import Signal as CanSignal

from gateway.database import COMPENSATOR, CYCLE, MACHINE, OFFSETS, Database, Frame, Signal
from gateway.e2e import COUNTERS
from gateway.proof import CHALLENGE, ECHO, PROOF
from gateway.protection import PROFILE_1, Profile1
from measurement.errors import BadInput

DBC = Path(__file__).with_name("spindle_drift.dbc")
CRC, COUNTER = "crc", "counter"
PROTECTION = (CRC, COUNTER, CYCLE)
SIZE = 8
"""Bytes of every frame."""
LONGEST_TEXT = 300
EVENT = "Event"
"""The send type of frames that belong to no cycle."""
NEEDED = {
    MACHINE: ("machine_state", "machine_time", "machine_step", "thermal_state"),
    COMPENSATOR: ("valid", "gateway_state", "status", "bus_fault", "bus_fault_frame"),
}
"""The signals that the two programs themselves need, and the node that sends them."""


def read_database(path: Path = DBC) -> Database:
    """Read a DBC file.

    Parameters
    ----------
    path : Path, optional
        By default the file that ships.

    Returns
    -------
    Database
        Its frames, which make whole cycles.

    Raises
    ------
    BadInput
        If it cannot be read, or lacks what the gateway relies on.
    """
    read = load_dbc(path)
    frames = tuple(
        sorted((_frame(message, path) for message in read.messages), key=lambda f: f.frame_id)
    )
    database = Database(path, frames, int(attribute(read.dbc, "Baudrate", 500_000)))
    check(database)
    return database


def load_dbc(path: Path) -> CanDatabase:
    """Return a DBC file as cantools reads it.

    Raises
    ------
    BadInput
        If it cannot be read or holds no frame.
    """
    try:
        read = cantools.database.load_file(path, database_format="dbc", cache_dir=None)
    except OSError as error:
        raise BadInput(path, "", f"cannot be read: {error.strerror}") from None
    except Exception as error:  # cantools and its parser raise many kinds
        raise BadInput(path, "", f"is not a DBC file: {printable(str(error))}") from None
    assert isinstance(read, CanDatabase)
    if not read.messages:
        raise BadInput(path, "", "holds no frames")
    for message in read.messages:
        for signal in message.signals:
            if not (isfinite(signal.scale) and signal.scale and isfinite(signal.offset)):
                problem = f"has the factor {signal.scale:g} and the offset {signal.offset:g}"
                raise BadInput(path, f"{message.name}.{signal.name}", problem)
    return read


def printable(text: str) -> str:
    """Return a text of somebody else's in a line that a terminal can take."""
    line = " ".join("".join(c if c.isprintable() else " " for c in text).split())
    return line if len(line) <= LONGEST_TEXT else f"{line[:LONGEST_TEXT]} …"


def _frame(message: Message, path: Path) -> Frame:
    senders = [name for name in message.senders if name in NEEDED]
    if len(senders) != 1:
        raise BadInput(path, message.name, f"must be sent by {MACHINE} or by {COMPENSATOR}")
    if message.length != SIZE or message.is_extended_frame or message.is_multiplexed():
        raise BadInput(path, message.name, f"must be a plain standard frame of {SIZE} bytes")
    places = [(s.name, s.start, s.length) for s in message.signals if s.name in (CRC, COUNTER)]
    if sorted(places) != [(COUNTER, 8, 4), (CRC, 0, 8)]:
        raise BadInput(path, message.name, "needs crc in byte 0 and counter in bits 8 to 11")
    counts = [signal.length for signal in message.signals if signal.name == CYCLE]
    if not counts:
        raise BadInput(
            path, message.name, f"needs a signal {CYCLE}: all frames of a cycle share it"
        )
    for signal in message.signals:
        if signal.is_float or signal.is_signed:
            raise BadInput(path, f"{message.name}.{signal.name}", "must be an unsigned integer")
        words = [str(word) for word in (signal.choices or {}).values()]
        if len(set(words)) < len(words):
            raise BadInput(path, f"{message.name}.{signal.name}", "has two values of one name")
        if signal.minimum is None or signal.maximum is None:
            raise BadInput(
                path, f"{message.name}.{signal.name}", "needs a smallest and a largest value"
            )
    cycle_ms = message.cycle_time or 0
    timeout_ms = float(attribute(message.dbc, "E2ETimeout", 0))
    event = message.send_type == EVENT
    if not 0 < cycle_ms < timeout_ms and not event:
        raise BadInput(path, message.name, "GenMsgCycleTime must be above 0 and below E2ETimeout")
    data_id = int(attribute(message.dbc, "E2EDataId", 0))
    return Frame(
        message.name,
        senders[0],
        message.comment or "",
        message.frame_id,
        data_id,
        inf if event else cycle_ms / 1e3,
        timeout_ms / 1e3,
        {s.name: _signal(s) for s in message.signals if s.name not in PROTECTION},
        1 << counts[0],
        message,
        Profile1(PROFILE_1, COUNTER, COUNTERS, CRC, data_id),
        event=event,
    )


def _signal(signal: CanSignal) -> Signal:
    assert signal.minimum is not None
    assert signal.maximum is not None
    return Signal(
        signal.name,
        signal.unit or "",
        signal.comment or "",
        float(signal.scale),
        float(signal.offset),
        float(signal.minimum),
        float(signal.maximum),
        signal.length,
        {str(name): int(raw) for raw, name in (signal.choices or {}).items()},
        float(signal.raw_initial or 0),
    )


def attribute(specifics: Any, name: str, default: float) -> float:
    """Return an attribute's value: the object's, or else the one declared as default."""
    found = specifics.attributes.get(name) if specifics is not None else None
    if found is None:
        return default
    return float(found.value)


def check(database: Database) -> None:
    """Refuse frames that cannot make cycles.

    Raises
    ------
    BadInput
        For the first reason.
    """
    sealed = (frame for frame in database.frames if isinstance(frame.protection, Profile1))
    ids = [frame.data_id for frame in sealed]
    if len(set(ids)) < len(ids):
        raise BadInput(database.path, "E2EDataId", "two frames have the same one")
    for node in NEEDED:
        _check_node(database, node)
    if "cold" not in database.signal("thermal_state").codes:
        raise BadInput(database.path, "thermal_state", "has no value named cold")
    proof = database.proof
    if proof is not None and (ECHO not in proof.signals or not database.has(CHALLENGE)):
        raise BadInput(database.path, proof.name, f"needs {ECHO} beside, and a {CHALLENGE}")
    if proof is not None and len(proof.signals) > 2:
        problem = f"must hold {ECHO} and {PROOF} alone: a proof is over all other frames"
        raise BadInput(database.path, proof.name, problem)
    for name in OFFSETS:
        if not database.has(name) and database.axes is None:
            raise BadInput(database.path, COMPENSATOR, f"sends no signal {name}")
    for node, name in ((MACHINE, "machine_time"), (COMPENSATOR, "answered_time")):
        frame = database.closing(node)
        if name not in frame.signals:
            raise BadInput(
                database.path, frame.name, f"is {node}'s last frame: it must hold {name}"
            )


def _check_node(database: Database, node: str) -> None:
    known = [signal.name for _, signal in database.signals(node)]
    for name in NEEDED[node]:
        if name not in known:
            raise BadInput(database.path, node, f"sends no signal {name}")
    for frame in database.of(node):
        if frame.cycle_s != database.closing(node).cycle_s:
            raise BadInput(database.path, frame.name, "frames of a node must share a cycle time")
        if frame.cycles != database.closing(node).cycles:
            problem = f"{CYCLE} of a node's frames must be equally long"
            raise BadInput(database.path, frame.name, problem)
