"""The frames and signals of the bus, read from the DBC file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from math import inf, isfinite
from pathlib import Path
from typing import Any

import can
import cantools
from cantools.database.can import Database as CanDatabase
from cantools.database.can import Message
from cantools.database.can import Signal as CanSignal

from gateway.e2e import COUNTERS
from gateway.proof import CHALLENGE, ECHO, PROOF
from gateway.protection import PROFILE_1, Profile1, Protection
from measurement.errors import BadInput

DBC = Path(__file__).with_name("spindle_drift.dbc")
MACHINE, COMPENSATOR = "MACHINE", "COMPENSATOR"
CRC, COUNTER, CYCLE = "crc", "counter", "cycle"
PROTECTION = (CRC, COUNTER, CYCLE)
ERROR, NOT_AVAILABLE, OTHER = "error", "not_available", "other"
SIZE = 8  # bytes of every frame
LONGEST_TEXT = 300
EVENT = "Event"
"""The send type of frames that belong to no cycle."""
EXTENDED = 1 << 31
OFFSETS = ("dX", "dY", "dZ")
TRUST = ("none", "partly", "protected")
"""From the least: what of the faults of a frame can be noticed."""
# The signals that the two programs themselves need, and the node that sends them.
NEEDED = {
    MACHINE: ("machine_state", "machine_time", "machine_step", "thermal_state"),
    COMPENSATOR: ("valid", "gateway_state", "status", "bus_fault", "bus_fault_frame"),
}


@dataclass(frozen=True)
class Signal:
    """One signal of a frame.

    Attributes
    ----------
    name, unit, comment : str
        As in the DBC file.
    scale, offset : float
        Value = scale * raw + offset [unit].
    low, high : float
        Allowed values [unit].
    bits : int
        Length.
    codes : dict of str to int
        Raw values of the value table, by their names.
    start : float
        Raw value that a receiver takes before the first frame.
    wire_name : str
        The signal's name in the DBC file, where a map gives it another here.
    numbers : dict of int to str
        Names of the values that the gateway has as numbers, where the DBC file numbers otherwise.
    holds : bool
        What has no value is sent as it was before: the DBC file has no raw value for *missing*.
    is_float : bool
        The raw value is a floating-point number.
    page : int or None
        The value of the frame's multiplexer with which it comes; None: always.
    """

    name: str
    unit: str
    comment: str
    scale: float
    offset: float
    low: float
    high: float
    bits: int
    codes: dict[str, int]
    start: float
    wire_name: str = ""
    numbers: dict[int, str] = field(default_factory=dict)
    holds: bool = False
    is_float: bool = False
    page: int | None = None

    @property
    def key(self) -> str:
        """The name that cantools knows it by."""
        return self.wire_name or self.name

    @property
    def named(self) -> dict[str, int]:
        """The named values that are neither *error* nor *not available*."""
        special = (ERROR, NOT_AVAILABLE)
        return {name: raw for name, raw in self.codes.items() if name not in special}

    @property
    def is_enumeration(self) -> bool:
        """Whether only named values are allowed."""
        return len(self.named) > 1


@dataclass(frozen=True)
class Frame:
    """One frame.

    Attributes
    ----------
    name, sender, comment : str
        As in the DBC file.
    frame_id, data_id : int
        The identifier on the bus, and the one that enters the CRC.
    cycle_s, timeout_s : float
        How often it is sent, and after which silence it is late [s].
    signals : dict of str to Signal
        Its content by name, without CRC and counts.
    cycles : int
        The cycle count starts anew after so many cycles.
    message : cantools Message
        What encodes and decodes it.
    protection : Protection
        What seals it and finds faults in it.
    cycle : str
        The signal with the cycle count; empty for none.
    extended : bool
        The identifier has 29 bits.
    fixed : dict of str to float
        Raw values of the DBC file's other signals, for sending.
    multiplexer : str
        The signal that says which page of signals a frame holds; empty for none.
    event : bool
        It is sent when there is something to say, and belongs to no cycle.
    longer : bool
        It may come with more bytes, which mean nothing.
    """

    name: str
    sender: str
    comment: str
    frame_id: int
    data_id: int
    cycle_s: float
    timeout_s: float
    signals: dict[str, Signal]
    cycles: int
    message: Message
    protection: Protection
    cycle: str = CYCLE
    extended: bool = False
    fixed: dict[str, float] = field(default_factory=dict)
    multiplexer: str = ""
    event: bool = False
    longer: bool = False

    @property
    def key(self) -> int:
        """The identifier, with a bit beyond it for one of 29 bits."""
        return self.frame_id | EXTENDED if self.extended else self.frame_id

    @property
    def size(self) -> int:
        """How many bytes it has."""
        return int(self.message.length)

    @property
    def pages(self) -> tuple[int | None, ...]:
        """The values of the multiplexer that bring a signal, or None alone where none is needed."""
        pages = {signal.page for signal in self.signals.values() if signal.page is not None}
        return tuple(sorted(pages)) or (None,)


def key_of(message: can.Message) -> int:
    """Return the key of a message's frame."""
    number = int(message.arbitration_id)
    return number | EXTENDED if message.is_extended_id else number


@dataclass(frozen=True)
class Substitute:
    """What stands for an input that has no value.

    Attributes
    ----------
    value : float or None
        A constant; None: the last value.
    hold_s : float
        For how long the last value stands [s].
    """

    value: float | None = None
    hold_s: float = 0.0


@dataclass(frozen=True)
class Database:
    """All frames, and the bit rate that the bus is meant for [bit/s].

    Attributes
    ----------
    every_s : float or None
        Frames come at their own pace and are looked at this often [s]; None: each comes once a
        cycle, and the last one closes it.
    substitutes : dict of str to Substitute
        What stands for inputs without a value; also for those that no frame carries.
    when_invalid : dict of str to float
        What is sent in place of outputs while they are not valid.
    axes : tuple of str or None
        The axes that the machine has; None: all.
    """

    path: Path
    frames: tuple[Frame, ...]
    bit_rate: int
    every_s: float | None = None
    substitutes: dict[str, Substitute] = field(default_factory=dict)
    when_invalid: dict[str, float] = field(default_factory=dict)
    axes: tuple[str, ...] | None = None

    def of(self, sender: str) -> tuple[Frame, ...]:
        """Return a node's frames of a cycle, by rising identifier: the order of sending.

        Parameters
        ----------
        sender : {"MACHINE", "COMPENSATOR"}
            The node.
        """
        return tuple(f for f in self.frames if f.sender == sender and not f.event)

    def events(self, sender: str) -> tuple[Frame, ...]:
        """Return a node's frames that belong to no cycle.

        Parameters
        ----------
        sender : {"MACHINE", "COMPENSATOR"}
            The node.
        """
        return tuple(f for f in self.frames if f.sender == sender and f.event)

    def closing(self, sender: str) -> Frame:
        """Return the frame that closes a node's cycle: its heartbeat, the last one.

        Parameters
        ----------
        sender : {"MACHINE", "COMPENSATOR"}
            The node.
        """
        return self.of(sender)[-1]

    def signals(self, sender: str) -> Iterator[tuple[Frame, Signal]]:
        """Yield every signal that a node sends in a cycle.

        Parameters
        ----------
        sender : {"MACHINE", "COMPENSATOR"}
            The node.

        Yields
        ------
        tuple of Frame and Signal
            By rising identifier.
        """
        for frame in self.of(sender):
            for signal in frame.signals.values():
                yield frame, signal

    def signal(self, name: str) -> Signal:
        """Return a signal by its name.

        Parameters
        ----------
        name : str
            As the gateway calls it.
        """
        return next(frame.signals[name] for frame in self.frames if name in frame.signals)

    def has(self, name: str) -> bool:
        """Return whether a frame carries a signal.

        Parameters
        ----------
        name : str
            As the gateway calls it.
        """
        return any(name in frame.signals for frame in self.frames)

    @property
    def proof(self) -> Frame | None:
        """The machine's frame that proves a cycle to be fresh, if there is one."""
        if self.every_s is not None:
            return None
        return next((frame for frame in self.of(MACHINE) if PROOF in frame.signals), None)

    def unproven(self) -> Database:
        """Return the frames for a machine that cannot prove anything."""
        return replace(self, frames=tuple(f for f in self.frames if f is not self.proof))

    @property
    def trust(self) -> str:
        """The least of the protections of the machine's frames."""
        levels = {frame.protection.trust for frame in self.of(MACHINE)}
        return next(level for level in TRUST if level in levels)


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
    ids = [frame.data_id for frame in database.frames]
    if len(set(ids)) < len(ids):
        raise BadInput(database.path, "E2EDataId", "two frames have the same one")
    for node in NEEDED:
        _check_node(database, node)
    if "cold" not in database.signal("thermal_state").codes:
        raise BadInput(database.path, "thermal_state", "has no value named cold")
    proof = database.proof
    if proof is not None and (ECHO not in proof.signals or not database.has(CHALLENGE)):
        raise BadInput(database.path, proof.name, f"needs {ECHO} beside, and a {CHALLENGE}")
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
