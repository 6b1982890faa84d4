"""Values to frames and back, by the DBC file alone.

A value that is not known (NaN) is sent as *not available*, one that the frame cannot carry as
*error*. Read back, both are NaN, and so is a raw value outside the signal's range.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import isfinite, nan

import can
from cantools.database.errors import DecodeError

from gateway.database import ERROR, MACHINE, NOT_AVAILABLE, OTHER, Database, Frame, Signal
from gateway.proof import ECHO, ECHO_BITS, PROOF, proof_of

Value = float | str
"""A number in the signal's unit, or a name from its value table."""
ROUNDING = {16: 2.0**-11, 32: 2.0**-24}
"""By how much of itself a number is rounded, by its bits: given by IEEE 754."""


@dataclass(frozen=True)
class Finding:
    """Something wrong: the kind of fault as the DBC names it, the frame, a text for people.

    The signal, where only that is concerned.
    """

    fault: str
    frame: Frame
    text: str
    signal: str = ""


def raw_of(signal: Signal, value: Value, before: float | None = None) -> float:
    """Return the raw value to send; a signal without special codes sends its start value then.

    Parameters
    ----------
    signal : Signal
        What is sent.
    value : float or str
        Its value, or the name of one.
    before : float, optional
        The raw value that was sent last; a signal that holds sends it again where it has no code.

    Raises
    ------
    KeyError
        For a name that is not in the signal's value table.
    """
    if not isinstance(value, str) and signal.numbers and isfinite(value):
        value = signal.numbers.get(round(value), OTHER)
    if isinstance(value, str) and signal.wire_name and value not in signal.codes:
        # A control's own table need not have a word for everything.
        value = OTHER if OTHER in signal.codes else nan
    if isinstance(value, str):
        return signal.codes[value]
    fallback = before if signal.holds and before is not None else _whole(signal, signal.start)
    if not isfinite(value):
        return signal.codes.get(NOT_AVAILABLE if value != value else ERROR, fallback)
    raw = _whole(signal, (value - signal.offset) / signal.scale)
    # Half a step outside the range still rounds to its end.
    if not low_raw(signal) <= raw <= high_raw(signal):
        return signal.codes.get(ERROR, fallback)
    return raw


def _whole(signal: Signal, raw: float) -> float:
    return raw if signal.is_float else round(raw)


def low_raw(signal: Signal) -> float:
    """Return the smallest raw value that is allowed."""
    return _ends(signal)[0]


def high_raw(signal: Signal) -> float:
    """Return the largest raw value that is allowed."""
    return _ends(signal)[1]


def _ends(signal: Signal) -> tuple[float, float]:
    low, high = sorted((end - signal.offset) / signal.scale for end in (signal.low, signal.high))
    if not signal.is_float:
        return round(low), round(high)
    # A raw value that is an end of the range may come rounded.
    rounding = ROUNDING.get(signal.bits, 0.0)
    return low - rounding * abs(low), high + rounding * abs(high)


class CountedTime:
    """A time as frames count it: in steps from 0 to the largest, and then anew.

    Parameters
    ----------
    signal : Signal
        What carries it.

    Attributes
    ----------
    count : int
        How many steps there are; special codes are none.
    scale : float
        A step [s].
    """

    def __init__(self, signal: Signal) -> None:
        self.count, self.scale = int(high_raw(signal)) + 1, signal.scale

    @property
    def period_s(self) -> float:
        """It starts anew after this time [s]."""
        return self.count * self.scale

    def raw(self, time_s: float) -> int:
        """Return the step of a time [s]."""
        return round(time_s / self.scale) % self.count

    def carried_s(self, time_s: float) -> float:
        """Return what a frame shows of a time [s]."""
        return self.raw(time_s) * self.scale

    def since_s(self, earlier_s: float, time_s: float) -> float:
        """Return how long before a time another one was, by what frames show of both [s]."""
        return (self.raw(time_s) - self.raw(earlier_s)) % self.count * self.scale


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
        self._raw: dict[str, float] = dict.fromkeys(frame.protection.signals, 0.0)
        self._raw |= frame.fixed
        self._sent: dict[str, float] = {}

    def message(self, values: Mapping[str, Value]) -> can.Message:
        """Return the next message of a frame of one page; see `messages`."""
        return self.messages(values)[0]

    def messages(self, values: Mapping[str, Value]) -> list[can.Message]:
        """Return the next message, or one for each page; a signal without value is missing."""
        for name, signal in self.frame.signals.items():
            raw = raw_of(signal, values.get(name, nan), self._sent.get(name))
            self._raw[signal.key] = self._sent[name] = raw
        return [self._message(page) for page in self.frame.pages]

    def _message(self, page: int | None) -> can.Message:
        raw, frame = self._raw, self.frame
        if frame.protection.counter:
            raw[frame.protection.counter] = self._count % frame.protection.counters
        if frame.cycle:
            raw[frame.cycle] = self._count % frame.cycles
        if page is not None:
            raw[frame.multiplexer] = page
        self._count = (self._count + 1) % (frame.protection.counters * frame.cycles)
        data = frame.message.encode(raw, scaling=False, strict=False)
        return can.Message(
            arbitration_id=frame.frame_id,
            data=frame.protection.sealed(data),
            is_extended_id=frame.extended,
            is_fd=frame.fd,
            bitrate_switch=frame.fd,
        )


class Sender:
    """Makes the messages of one node's cycle.

    Parameters
    ----------
    database : Database
        The frames.
    node : str
        Who sends.
    key : bytes, optional
        What a proof is made with; see `proof.proof_of`.
    """

    def __init__(self, database: Database, node: str, key: bytes | None = None) -> None:
        self._encoders = [Encoder(frame) for frame in database.of(node)]
        proving = database.proof if node == MACHINE else None
        self._proving, self._key = proving.key if proving else None, key

    def messages(
        self, values: Mapping[str, Value], challenge: int | None = None
    ) -> list[can.Message]:
        """Return the messages of a cycle, the closing one last.

        Parameters
        ----------
        values : mapping of str to float or str
            By signal; one that is not in it is missing.
        challenge : int, optional
            The newest one that was heard, for a node that proves its cycles to be fresh.
        """
        made = {
            encoder.frame.key: encoder.messages(values)
            for encoder in self._encoders
            if encoder.frame.key != self._proving
        }
        for encoder in self._encoders:
            if encoder.frame.key == self._proving:
                others = [bytes(message.data) for sent in made.values() for message in sent]
                proof_values: dict[str, Value] = {}
                if challenge is not None:
                    proof = proof_of(challenge, others, self._key)
                    proof_values = {ECHO: challenge & ECHO_BITS, PROOF: proof}
                made[encoder.frame.key] = encoder.messages({**values, **proof_values})
        return [message for encoder in self._encoders for message in made[encoder.frame.key]]


@dataclass(frozen=True)
class Content:
    """What a frame holds: its cycle count, its values, and what is wrong with them.

    A frame with pages holds the values of the one that came.
    """

    cycle: int = 0
    values: Mapping[str, float] = field(default_factory=dict)
    problems: Sequence[Finding] = ()
    counter: int = 0
    page: int | None = None


def decode(frame: Frame, data: bytes | bytearray) -> Content:
    """Return a frame's content; values are NaN where there is none.

    Parameters
    ----------
    frame : Frame
        Which frame it is.
    data : bytes
        Its bytes, as many as it must have; the check value is not looked at here.

    Raises
    ------
    LookupError
        If its multiplexer has a value that the DBC file does not know.
    """
    try:
        found = frame.message.decode(bytes(data), decode_choices=False, scaling=False)
    except DecodeError as error:
        raise LookupError(str(error)) from None
    assert isinstance(found, dict)
    raw: dict[str, float] = {name: float(value) for name, value in found.items()}  # type: ignore[arg-type]
    page = int(raw[frame.multiplexer]) if frame.multiplexer else None
    values: dict[str, float] = {}
    problems: list[Finding] = []
    for name, signal in frame.signals.items():
        if signal.page is not None and signal.page != page:
            continue
        values[name] = raw[signal.key] * signal.scale + signal.offset
        if (problem := _problem(frame, signal, raw[signal.key])) is not None:
            values[name] = nan
            problems.append(problem)
    cycle, counter = (int(raw.get(name, 0.0)) for name in (frame.cycle, frame.protection.counter))
    return Content(cycle, values, problems, counter, page if page in frame.pages else None)


def name_of(signal: Signal, value: float) -> str:
    """Return the name of a value of an enumeration; *not_available* for NaN."""
    for name, raw in signal.codes.items():
        if raw == value:
            return name
    return NOT_AVAILABLE


def _problem(frame: Frame, signal: Signal, raw: float) -> Finding | None:
    name = signal.name
    if raw == signal.codes.get(NOT_AVAILABLE) or raw != raw:
        return Finding("not_available_value", frame, f"{name} is not available", name)
    if raw == signal.codes.get(ERROR):
        return Finding("error_value", frame, f"{name} is marked as an error", name)
    unknown = signal.is_enumeration and raw not in signal.codes.values()
    if unknown or not low_raw(signal) <= raw <= high_raw(signal):
        value = raw * signal.scale + signal.offset
        allowed = f"{signal.low:g} to {signal.high:g} {signal.unit}".rstrip()
        if unknown:
            allowed = "one of its named values"
        return Finding("out_of_range", frame, f"{name} is {value:g}, allowed is {allowed}", name)
    return None
