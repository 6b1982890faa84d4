"""Faults of frames: each changes what the machine sends, cycle after cycle."""

from collections.abc import Callable

import can

from gateway.database import MACHINE, Database
from tests.gateway.bench import sealed, with_bytes

Messages = list[can.Message]
Change = Callable[[Database], Callable[[Messages], Messages]]
PLACES = (0, 3, 6)


def corrupted(place: int) -> Change:
    def change(database: Database) -> Callable[[Messages], Messages]:
        def do(messages: Messages) -> Messages:
            data = bytearray(messages[place].data)
            data[4] ^= 0x10
            messages[place] = with_bytes(messages[place], bytes(data))
            return messages

        return do

    return change


def dropped(place: int) -> Change:
    return lambda database: lambda messages: [*messages[:place], *messages[place + 1 :]]


def twice(place: int) -> Change:
    return lambda database: lambda messages: [*messages[: place + 1], *messages[place:]]


def short(place: int) -> Change:
    def do(messages: Messages) -> Messages:
        messages[place] = with_bytes(messages[place], bytes(messages[place].data[:7]))
        return messages

    return lambda database: do


def repeated(place: int) -> Change:
    """The sender is stuck: the frame of the first bad cycle comes again and again."""

    def change(database: Database) -> Callable[[Messages], Messages]:
        kept: Messages = []

        def do(messages: Messages) -> Messages:
            kept.append(messages[place])
            messages[place] = kept[0]
            return messages

        return do

    return change


def sequence(place: int) -> Change:
    """The counter goes back by four from each frame to the next."""

    def change(database: Database) -> Callable[[Messages], Messages]:
        frame, count = database.of(MACHINE)[place], [0]

        def do(messages: Messages) -> Messages:
            count[0] += 1
            data = bytearray(messages[place].data)
            data[1] = data[1] & 0xF0 | ((data[1] & 0x0F) - 5 * count[0]) % 15
            messages[place] = sealed(messages[place], bytes(data), frame)
            return messages

        return do

    return change


def raw_signal(name: str, raw: int) -> Change:
    """A signal with a raw value that its sender should not have sent."""

    def change(database: Database) -> Callable[[Messages], Messages]:
        frames = database.of(MACHINE)
        place = next(i for i, frame in enumerate(frames) if name in frame.signals)
        frame = frames[place]

        def do(messages: Messages) -> Messages:
            content = frame.message.decode(
                bytes(messages[place].data), decode_choices=False, scaling=False
            )
            content[name] = raw
            data = frame.message.encode(content, scaling=False, strict=False)
            messages[place] = sealed(messages[place], data, frame)
            return messages

        do.by_sender = True
        return do

    return change
