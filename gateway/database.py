"""The frames and signals of the bus, as the gateway knows them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import can
from cantools.database.can import Message

from gateway.proof import PROOF
from gateway.protection import Protection

MACHINE, COMPENSATOR = "MACHINE", "COMPENSATOR"
CYCLE = "cycle"
ERROR, NOT_AVAILABLE, OTHER = "error", "not_available", "other"
MAY_BE_LOST = 1
"""Number of consecutive cycles whose loss is tolerated: set on no data."""
FAREWELLS = 1 + MAY_BE_LOST
"""How many times a node announces that it leaves."""
EXTENDED = 1 << 31
"""Marks a 29-bit identifier in a DBC file: given by its format."""
ROUNDING = {16: 2.0**-11, 32: 2.0**-24}
"""Largest relative rounding error of a number, by its length in bits: given by IEEE 754."""
OFFSETS = ("dX", "dY", "dZ")
TRUST = ("none", "partly", "protected")
"""How many of a frame's faults can be detected, from the least."""


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
    holds_raw : tuple of float
        The smallest and the largest raw value that the bits can hold; whole numbers are exact.
    codes : dict of str to int
        Raw values of the value table, by name.
    start : float
        Raw value that a receiver assumes before the first frame.
    wire_name : str
        The signal's name in the DBC file, if a map renames it.
    numbers : dict of int to str
        Names of the gateway's numeric values, if the DBC file numbers them differently.
    holds : bool
        Whether a missing value is sent as the last one, because the DBC file has no raw value for
        *missing*.
    is_float : bool
        Whether the raw value is a floating-point number.
    page : int or None
        The value of the frame's multiplexer with which the signal comes; None: always.
    """

    name: str
    unit: str
    comment: str
    scale: float
    offset: float
    low: float
    high: float
    bits: int
    holds_raw: tuple[float, float]
    codes: dict[str, int]
    start: float
    wire_name: str = ""
    numbers: dict[int, str] = field(default_factory=dict)
    holds: bool = False
    is_float: bool = False
    page: int | None = None

    @property
    def key(self) -> str:
        """The name that cantools uses."""
        return self.wire_name or self.name

    @cached_property
    def allowed_raw(self) -> tuple[float, float]:
        """The smallest and the largest allowed raw value."""
        low, high = sorted((end - self.offset) / self.scale for end in (self.low, self.high))
        if not self.is_float:
            # A range of more than 53 bits is rounded, perhaps to more than they hold.
            return max(round(low), self.holds_raw[0]), min(round(high), self.holds_raw[1])
        # A raw value at an end of the range may arrive rounded.
        rounding = ROUNDING.get(self.bits, 0.0)
        return low - rounding * abs(low), high + rounding * abs(high)

    def whole(self, raw: float) -> float:
        """Return a raw value [1], rounded unless it is a floating-point number."""
        return raw if self.is_float else round(raw)

    def held(self, raw: float) -> float | None:
        """Return a raw value [1] as the signal holds it; None outside the allowed range."""
        # A value up to half a step outside the range still rounds to its end.
        raw, (low, high) = self.whole(raw), self.allowed_raw
        # An end of more than 53 bits may be more as a float than the signal holds.
        return min(max(raw, low), high) if float(low) <= raw <= float(high) else None

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
    frame_id : int
        The identifier on the bus.
    cycle_s, timeout_s : float
        The period at which it is sent, and the silence after which it is late [s].
    signals : dict of str to Signal
        Its content by name, without CRC and counts.
    cycles : int
        Number of cycles after which the cycle count starts again.
    message : cantools Message
        Encodes and decodes it.
    protection : Protection
        Seals it and finds faults in it.
    cycle : str
        The signal with the cycle count; empty for none.
    extended : bool
        Whether the identifier has 29 bits.
    fixed : dict of str to float
        Raw values to send for the DBC file's other signals.
    multiplexer : str
        The signal that selects a frame's page of signals; empty for none.
    event : bool
        Whether it is sent on an event and belongs to no cycle.
    longer : bool
        Whether further bytes may follow, which are ignored.
    fd : bool
        Whether it is a CAN FD frame.
    """

    name: str
    sender: str
    comment: str
    frame_id: int
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
    fd: bool = False

    @property
    def key(self) -> int:
        """The identifier; a further bit marks one of 29 bits."""
        return self.frame_id | EXTENDED if self.extended else self.frame_id

    @property
    def data_id(self) -> int:
        """The data id included in the check value; 0 for none."""
        return int.from_bytes(self.protection.data_id, "little")

    @property
    def size(self) -> int:
        """Number of bytes."""
        return int(self.message.length)

    @property
    def pages(self) -> tuple[int | None, ...]:
        """The multiplexer values with which signals come; only None without a multiplexer."""
        pages = {signal.page for signal in self.signals.values() if signal.page is not None}
        return tuple(sorted(pages)) or (None,)

    @property
    def a_second(self) -> float:
        """Frames per second: a control sends one page at a time, the gateway all pages [1/s]."""
        return (len(self.pages) if self.sender == COMPENSATOR else 1) / self.cycle_s


def key_of(message: can.Message) -> int:
    """Return the key of a message's frame."""
    number = int(message.arbitration_id)
    return number | EXTENDED if message.is_extended_id else number


@dataclass(frozen=True)
class Substitute:
    """What replaces an input that has no value.

    Attributes
    ----------
    value : float or None
        A constant; None: the last value.
    hold_s : float
        How long the last value is used [s].
    """

    value: float | None = None
    hold_s: float = 0.0


@dataclass(frozen=True)
class Database:
    """All frames, and the intended bit rate of the bus [bit/s].

    Attributes
    ----------
    every_s : float or None
        The period at which frames that come at their own pace are sampled [s]; None: each frame
        comes once a cycle, and the last one closes it.
    substitutes : dict of str to Substitute
        What replaces inputs without a value, including those that no frame carries.
    when_invalid : dict of str to float
        What is sent instead of outputs while they are invalid.
    """

    path: Path
    frames: tuple[Frame, ...]
    bit_rate: int
    every_s: float | None = None
    substitutes: dict[str, Substitute] = field(default_factory=dict)
    when_invalid: dict[str, float] = field(default_factory=dict)

    @property
    def fd(self) -> bool:
        """Whether the bus carries CAN FD."""
        return any(frame.fd for frame in self.frames)

    def of(self, sender: str) -> tuple[Frame, ...]:
        """Return a node's frames of a cycle in the order of sending, by rising identifier.

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

    @cached_property
    def named(self) -> dict[str, Signal]:
        """Every signal by the gateway's name; the first one if several frames carry it."""
        signals: dict[str, Signal] = {}
        for frame in self.frames:
            signals = signals | {n: s for n, s in frame.signals.items() if n not in signals}
        return signals

    def signal(self, name: str) -> Signal:
        """Return a signal by its name.

        Parameters
        ----------
        name : str
            As the gateway calls it.
        """
        return self.named[name]

    def has(self, name: str) -> bool:
        """Return whether a frame carries a signal.

        Parameters
        ----------
        name : str
            As the gateway calls it.
        """
        return name in self.named

    @property
    def proof(self) -> Frame | None:
        """The machine's frame that proves that a cycle is fresh, if there is one."""
        if self.every_s is not None:
            return None
        return next((frame for frame in self.of(MACHINE) if PROOF in frame.signals), None)

    def unproven(self) -> Database:
        """Return the frames for a machine that cannot prove anything."""
        return replace(self, frames=tuple(f for f in self.frames if f is not self.proof))

    @property
    def trust(self) -> str:
        """The weakest protection of the machine's frames."""
        levels = {frame.protection.trust for frame in self.of(MACHINE)}
        return next((level for level in TRUST if level in levels), TRUST[0])
