"""Values to frames and back, by the DBC file alone.

A value that is not known (NaN) is sent as *not available*, one that the frame cannot carry as
*error*. Read back, both are NaN, and so is a raw value outside the signal's range.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite, nan

import can

from scenarios.gateway.database import (
    COUNTER,
    CRC,
    CYCLE,
    ERROR,
    NOT_AVAILABLE,
    Database,
    Frame,
    Signal,
)
from scenarios.gateway.e2e import COUNTERS, protected

Value = float | str
"""A number in the signal's unit, or a name from its value table."""


@dataclass(frozen=True)
class Problem:
    """A signal that cannot be used: its name, the kind of fault, and a text for people."""

    signal: str
    fault: str
    text: str


def raw_of(signal: Signal, value: Value) -> int:
    """Return the raw value to send; a signal without special codes sends its start value then.

    Raises
    ------
    KeyError
        For a name that is not in the signal's value table.
    """
    if isinstance(value, str):
        return signal.codes[value]
    if not isfinite(value):
        return signal.codes.get(NOT_AVAILABLE if value != value else ERROR, int(signal.start))
    raw = round((value - signal.offset) / signal.scale)
    # Half a step outside the range still rounds to its end.
    if not low_raw(signal) <= raw <= high_raw(signal):
        return signal.codes.get(ERROR, int(signal.start))
    return raw


def low_raw(signal: Signal) -> int:
    """Return the raw value of the smallest allowed value."""
    return round((signal.low - signal.offset) / signal.scale)


def high_raw(signal: Signal) -> int:
    """Return the raw value of the largest allowed value."""
    return round((signal.high - signal.offset) / signal.scale)


class Encoder:
    """Makes one frame's messages, counting them.

    Parameters
    ----------
    frame : Frame
        What is sent.
    """

    def __init__(self, frame: Frame) -> None:
        self.frame = frame
        self._count = 0
        self._raw: dict[str, int] = {CRC: 0}

    def message(self, values: Mapping[str, Value]) -> can.Message:
        """Return the next message; a signal without a value is *not available*."""
        raw = self._raw
        raw[COUNTER], raw[CYCLE] = self._count % COUNTERS, self._count % self.frame.cycles
        for name, signal in self.frame.signals.items():
            raw[name] = raw_of(signal, values.get(name, nan))
        self._count = (self._count + 1) % (COUNTERS * self.frame.cycles)
        data = self.frame.message.encode(raw, scaling=False, strict=False)
        return can.Message(
            arbitration_id=self.frame.frame_id,
            data=protected(data, self.frame.data_id),
            is_extended_id=False,
        )


class Sender:
    """Makes the messages of one node's cycle.

    Parameters
    ----------
    database : Database
        The frames.
    node : str
        Who sends.
    """

    def __init__(self, database: Database, node: str) -> None:
        self._encoders = [Encoder(frame) for frame in database.of(node)]

    def messages(self, values: Mapping[str, Value]) -> list[can.Message]:
        """Return the messages of a cycle, the closing one last."""
        return [encoder.message(values) for encoder in self._encoders]


@dataclass(frozen=True)
class Content:
    """What a frame holds: its cycle count, its values, and what is wrong with them."""

    cycle: int
    values: dict[str, float]
    problems: Sequence[Problem]


def decode(frame: Frame, data: bytes | bytearray) -> Content:
    """Return a frame's content; values are NaN where there is none.

    Parameters
    ----------
    frame : Frame
        Which frame it is.
    data : bytes
        Its eight bytes; the CRC is not looked at here.
    """
    found = frame.message.decode(bytes(data), decode_choices=False, scaling=False)
    assert isinstance(found, dict)
    values: dict[str, float] = {}
    problems: list[Problem] = []
    for name, signal in frame.signals.items():
        raw = found[name]
        assert isinstance(raw, int)
        problem = _problem(signal, raw)
        if problem is None:
            values[name] = raw * signal.scale + signal.offset
        else:
            values[name] = nan
            problems.append(problem)
    cycle = found[CYCLE]
    assert isinstance(cycle, int)
    return Content(cycle, values, problems)


def name_of(signal: Signal, value: float) -> str:
    """Return the name of a value of an enumeration; *not_available* for NaN."""
    for name, raw in signal.codes.items():
        if raw == value:
            return name
    return NOT_AVAILABLE


def _problem(signal: Signal, raw: int) -> Problem | None:
    if raw == signal.codes.get(NOT_AVAILABLE):
        return Problem(signal.name, "not_available_value", f"{signal.name} is not available")
    if raw == signal.codes.get(ERROR):
        return Problem(signal.name, "error_value", f"{signal.name} is marked as an error")
    unknown = signal.is_enumeration and raw not in signal.codes.values()
    if unknown or not low_raw(signal) <= raw <= high_raw(signal):
        value = raw * signal.scale + signal.offset
        allowed = f"{signal.low:g} to {signal.high:g} {signal.unit}".rstrip()
        if unknown:
            allowed = "one of its named values"
        text = f"{signal.name} is {value:g}, allowed is {allowed}"
        return Problem(signal.name, "out_of_range", text)
    return None
