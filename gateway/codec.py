"""Encodes values into frames and decodes them, from the DBC file alone.

An unknown value (NaN) is sent as *not available*, one that the frame cannot carry as *error*, or as
*not available* without such a code. Both are decoded as NaN, and so is a raw value outside the
signal's range.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import isfinite, isnan, nan
from typing import cast

import can
from cantools.database.errors import DecodeError

from gateway.database import ERROR, MACHINE, NOT_AVAILABLE, OTHER, Database, Frame, Signal
from gateway.proof import ECHO, ECHO_BITS, PROOF, proof_of

Value = float | str
"""A number in the signal's unit, or a name from its value table."""


@dataclass(frozen=True)
class Finding:
    """A problem: the kind of fault as the DBC names it, the frame, and a text for people.

    If only one signal is affected, that signal as well.
    """

    fault: str
    frame: Frame
    text: str
    signal: str = ""


def raw_of(signal: Signal, value: Value, before: float | None = None) -> float:
    """Return the raw value to send, a special code for a value that cannot be sent.

    A signal without such a code sends its start value instead.

    Parameters
    ----------
    signal : Signal
        The signal to send.
    value : float or str
        A value, or the name of one.
    before : float, optional
        The raw value sent last, which a signal that holds sends again instead of its start value.

    Raises
    ------
    KeyError
        If a name is not in the signal's value table.
    """
    if not isinstance(value, str) and signal.numbers and isfinite(value):
        value = signal.numbers.get(round(value), OTHER)
    if isinstance(value, str) and signal.wire_name and value not in signal.codes:
        # A control's own value table need not have every name.
        value = OTHER if OTHER in signal.codes else nan
    if isinstance(value, str):
        return signal.codes[value]
    fallback = before if signal.holds and before is not None else signal.whole(signal.start)
    missing = signal.codes.get(NOT_AVAILABLE, fallback)
    if isnan(value):
        return missing
    if isfinite(value):
        raw = signal.held((value - signal.offset) / signal.scale)
        if raw is not None:
            return raw
    return signal.codes.get(ERROR, missing)


class CountedTime:
    """A time as frames count it: in steps from 0 to the largest value, then from 0 again.

    Parameters
    ----------
    signal : Signal
        The signal that carries the time.

    Attributes
    ----------
    count : int
        Number of steps, special codes excluded.
    scale : float
        Length of a step [s].
    """

    def __init__(self, signal: Signal) -> None:
        self.count, self.scale = int(signal.allowed_raw[1]) + 1, signal.scale

    @property
    def period_s(self) -> float:
        """The time after which the count starts again [s]."""
        return self.count * self.scale

    def raw(self, time_s: float) -> int:
        """Return the step of a time [s]."""
        return round(time_s / self.scale) % self.count

    def carried_s(self, time_s: float) -> float:
        """Return a time as a frame carries it [s]."""
        return self.raw(time_s) * self.scale

    def since_s(self, earlier_s: float, time_s: float) -> float:
        """Return the time from *earlier_s* to *time_s*, both as frames carry them [s]."""
        return (self.raw(time_s) - self.raw(earlier_s)) % self.count * self.scale


class Encoder:
    """Makes and counts one frame's messages.

    Parameters
    ----------
    frame : Frame
        The frame to send.
    """

    def __init__(self, frame: Frame) -> None:
        self.frame = frame
        self._count = 0
        self._raw: dict[str, float] = dict.fromkeys(frame.protection.signals, 0.0)
        self._raw |= frame.fixed
        self._sent: dict[str, float] = {}

    def message(self, values: Mapping[str, Value]) -> can.Message:
        """Return the next message of a frame with one page; see `messages`."""
        return self.messages(values)[0]

    def messages(self, values: Mapping[str, Value]) -> list[can.Message]:
        """Return the next message, or one per page; a signal without a value is missing."""
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
        The sender.
    key : bytes, optional
        The key for proofs; see `proof.proof_of`.
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
            By signal; a signal that is not in it is missing.
        challenge : int, optional
            The newest one received, for a node that proves that its cycles are fresh.
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
    """A frame's content: its cycle count, its values, and the problems with them.

    A frame with pages holds the values of the page that came.
    """

    cycle: int = 0
    values: Mapping[str, float] = field(default_factory=dict)
    problems: Sequence[Finding] = ()
    counter: int = 0
    page: int | None = None


def decode(frame: Frame, data: bytes | bytearray) -> Content:
    """Return a frame's content; a missing value is NaN.

    Parameters
    ----------
    frame : Frame
        The frame.
    data : bytes
        Its bytes, of the right number; the check value is not checked here.

    Raises
    ------
    LookupError
        If the multiplexer has a value that is not in the DBC file.
    """
    try:
        decoded = frame.message.decode(bytes(data), decode_choices=False, scaling=False)
    except DecodeError as error:
        raise LookupError(str(error)) from None
    raw = cast("dict[str, float]", decoded)  # whole numbers stay whole: a float holds 53 bits
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
    """Return the name of an enumeration's value; *not_available* for NaN."""
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
    low, high = signal.allowed_raw
    if unknown or not low <= raw <= high:
        value = raw * signal.scale + signal.offset
        allowed = f"{signal.low:g} to {signal.high:g} {signal.unit}".rstrip()
        if unknown:
            allowed = "one of its named values"
        return Finding("out_of_range", frame, f"{name} is {value:g}, allowed is {allowed}", name)
    return None
