"""The classes of faults: each takes an episode that has settled and lets something go wrong."""

from __future__ import annotations

from collections.abc import Callable

import can

from benchmarks.gateway_faults.harness import CYCLE_S, Episode, Messages
from gateway.codec import Sender
from gateway.database import COMPENSATOR, MACHINE

Fault = Callable[[Episode], None]
FAULTS: dict[str, Fault] = {}
QUICKEST_S = 0.002
"""Seven frames take so long on a bus of 500 kbit/s [s]."""
MASQUERADE: dict[str, Fault] = {}
"""What only authentication could tell from the truth."""


def fault(name: str, into: dict[str, Fault] = FAULTS) -> Callable[[Fault], Fault]:
    """Register a class of faults."""

    def keep(function: Fault) -> Fault:
        into[name] = function
        return function

    return keep


def cycles(episode: Episode, low: int = 1, high: int = 20) -> range:
    """Return for how many cycles a fault lasts."""
    return range(int(episode.rng.integers(low, high + 1)))


def place(episode: Episode) -> int:
    """Return which frame of a cycle is hit."""
    return int(episode.rng.integers(0, len(episode.database.of(MACHINE))))


def not_last(episode: Episode) -> int:
    """Return which frame of a cycle is hit; not the heartbeat."""
    return int(episode.rng.integers(0, len(episode.database.of(MACHINE)) - 1))


def with_data(message: can.Message, data: bytes, frame_id: int | None = None) -> can.Message:
    """Return a message with other data, or another identifier."""
    return can.Message(
        arbitration_id=message.arbitration_id if frame_id is None else frame_id,
        data=data,
        is_extended_id=False,
    )


def sealed(episode: Episode, at: int, data: bytes) -> can.Message:
    """Return a frame of the machine with a CRC that fits."""
    frame = episode.database.of(MACHINE)[at]
    message = can.Message(arbitration_id=frame.frame_id, data=data, is_extended_id=False)
    return with_data(message, frame.protection.sealed(data))


# One frame


@fault("frame lost")
def _lost(episode: Episode) -> None:
    for _ in cycles(episode):
        at = place(episode)
        episode.cycle(lambda messages, at=at: [*messages[:at], *messages[at + 1 :]])


@fault("frame twice")
def _twice(episode: Episode) -> None:
    for _ in cycles(episode):
        at = place(episode)
        episode.cycle(lambda messages, at=at: [*messages[: at + 1], *messages[at:]])


@fault("frame stuck")
def _stuck(episode: Episode) -> None:
    at, kept = place(episode), []

    def stick(messages: Messages) -> Messages:
        kept.append(messages[at])
        return [*messages[:at], kept[0], *messages[at + 1 :]]

    for _ in cycles(episode, 2):
        episode.cycle(stick)


@fault("bits flipped")
def _flipped(episode: Episode) -> None:
    rng = episode.rng
    for _ in cycles(episode):
        at = place(episode)

        def flip(messages: Messages, at: int = at) -> Messages:
            data = bytearray(messages[at].data)
            for bit in rng.choice(64, size=int(rng.integers(1, 4)), replace=False):
                data[bit // 8] ^= 1 << bit % 8
            messages[at] = with_data(messages[at], bytes(data))
            return messages

        episode.cycle(flip)


@fault("wrong length")
def _length(episode: Episode) -> None:
    for _ in cycles(episode):
        at, size = place(episode), int(episode.rng.integers(0, 8))

        def cut(messages: Messages, at: int = at, size: int = size) -> Messages:
            messages[at] = with_data(messages[at], bytes(messages[at].data[:size]))
            return messages

        episode.cycle(cut)


@fault("wrong identifier")
def _identifier(episode: Episode) -> None:
    for _ in cycles(episode):
        at = place(episode)
        other = (at + 1) % len(episode.database.of(MACHINE))

        def route(messages: Messages, at: int = at, other: int = other) -> Messages:
            wrong = messages[other].arbitration_id
            messages[at] = with_data(messages[at], bytes(messages[at].data), wrong)
            return messages

        episode.cycle(route)


@fault("counter out of sequence")
def _sequence(episode: Episode) -> None:
    for _ in cycles(episode):
        at, back = place(episode), int(episode.rng.integers(1, 15))

        def turn(messages: Messages, at: int = at, back: int = back) -> Messages:
            data = bytearray(messages[at].data)
            data[1] = data[1] & 0xF0 | ((data[1] & 0x0F) - back) % 15
            messages[at] = sealed(episode, at, bytes(data))
            return messages

        episode.cycle(turn)


@fault("frames out of order")
def _order(episode: Episode) -> None:
    for _ in cycles(episode):
        # The heartbeat comes before at least one other frame.
        last = len(episode.database.of(MACHINE)) - 1
        order = [last, *(int(i) for i in episode.rng.permutation(last))]
        swap = int(episode.rng.integers(0, last))
        order[0], order[swap] = order[swap], order[0]
        episode.cycle(lambda messages, order=order: [messages[i] for i in order])


@fault("value marked, or out of range")
def _marked(episode: Episode) -> None:
    rng = episode.rng
    for _ in cycles(episode):
        name = f"T{rng.integers(1, 12)}" if rng.random() < 0.7 else "tool_length"
        value = (float("nan"), float("inf"), 5000.0, -500.0)[int(rng.integers(0, 4))]
        episode.cycle(**{name: value})


# Frames of other cycles


@fault("one frame late by whole cycles, for a while")
def _late_for_a_while(episode: Episode) -> None:
    at, behind, kept = place(episode), int(episode.rng.integers(1, 30)), []

    def delay(messages: Messages) -> Messages:
        kept.append(messages[at])
        older = [kept.pop(0)] if len(kept) > behind else []
        return [*messages[:at], *older, *messages[at + 1 :]]

    for _ in range(behind + 10):
        episode.cycle(delay)


@fault("one frame late by whole cycles, for good")
def _late_for_good(episode: Episode) -> None:
    rng = episode.rng
    special = (15, 16, 30, 60, 120, 225, 240, 480)
    behind = int(rng.choice(special)) if rng.random() < 0.3 else int(rng.integers(1, 300))
    at, kept = not_last(episode), []

    def delay(messages: Messages) -> Messages:
        kept.append(messages[at])
        older = [kept.pop(0)] if len(kept) > behind else []
        return [*messages[:at], *older, *messages[at + 1 :]]

    for _ in range(behind + 20):
        episode.cycle(delay)


@fault("an extra frame, one count ahead")
def _extra(episode: Episode) -> None:
    at = not_last(episode)
    other = Sender(episode.database, MACHINE)
    for _ in cycles(episode, 1, 5):
        readings = {f"T{n}": 60.0 for n in range(1, 12)} | {"tool_length": 240.0, "speed": 1.0}

        def add(messages: Messages, readings: dict[str, float] = readings) -> Messages:
            while True:
                ahead = other.messages(readings)[at]
                if (ahead.data[1] & 0x0F) == ((messages[at].data[1] & 0x0F) + 1) % 15:
                    return [*messages[:-1], ahead, messages[-1]]

        episode.cycle(add)


@fault("an old cycle again, as it was")
def _old_again(episode: Episode) -> None:
    kept: list[Messages] = []
    back = int(episode.rng.integers(1, 100))
    for _ in range(back):
        episode.cycle(lambda messages: kept.append(messages) or messages)  # type: ignore[func-returns-value]
    for _ in cycles(episode):
        episode.cycle(lambda messages: [*kept[0], *messages])


# Time


@fault("silence")
def _silence(episode: Episode) -> None:
    for _ in cycles(episode, 3, 60):
        episode.cycle(lambda messages: [])


@fault("every cycle late, for a while")
def _burst(episode: Episode) -> None:
    """A queue on the way fills, then empties as fast as it can."""
    kept: list[Messages] = []
    for _ in cycles(episode, 6, 60):
        episode.cycle(lambda messages: kept.append(messages) or [])  # type: ignore[func-returns-value]
    for messages in kept:
        episode.wait(QUICKEST_S)
        episode.give(messages)
    episode.wait(CYCLE_S / 2)


@fault("every cycle late, for good")
def _all_late(episode: Episode) -> None:
    """A queue on the way that never empties."""
    behind, kept = int(episode.rng.integers(6, 300)), []

    def delay(messages: Messages) -> Messages:
        kept.append(messages)
        return kept.pop(0) if len(kept) > behind else []

    for _ in range(behind + 20):
        episode.cycle(delay)


@fault("every cycle later than the one before")
def _later(episode: Episode) -> None:
    more, kept, due = float(episode.rng.uniform(0.02, 0.5)), [], 0.0
    for k in cycles(episode, 60, 120):
        kept.append(episode.messages())
        episode.wait(CYCLE_S)
        if k * CYCLE_S >= due:
            episode.give(kept.pop(0))
            due += CYCLE_S * (1.0 + more)


@fault("machine's clock at another rate")
def _rate(episode: Episode) -> None:
    rng = episode.rng
    rate = 1.0
    while abs(rate - 1.0) < 0.1:
        rate = round(float(10 ** rng.uniform(-0.9, 1.5)), 1)
    episode.rate, episode.rate_matters = rate, True
    episode.begin()
    for _ in range(200):
        episode.cycle()


@fault("machine's clock stands, step 0")
def _stands(episode: Episode) -> None:
    stood = episode.time_s
    for _ in cycles(episode):
        episode.cycle(machine_time=stood, machine_step=0.0)


@fault("machine's clock stands, step as ever")
def _stands_still(episode: Episode) -> None:
    stood = episode.time_s
    for _ in cycles(episode, 3):
        episode.cycle(machine_time=stood)


@fault("machine's clock jumps")
def _jumps(episode: Episode) -> None:
    far = float(episode.rng.choice([-1.0, 1.0]) * 10 ** episode.rng.uniform(-0.3, 4.0))
    episode.time_s = round(max(episode.time_s + far, 0.0), 1)
    episode.cycle()


@fault("gateway stopped, then goes on")
def _stopped(episode: Episode) -> None:
    """The kernel keeps what arrives meanwhile."""
    kept: list[tuple[float, Messages]] = []
    for _ in cycles(episode, 4, 60):
        episode.now += CYCLE_S
        kept.append((episode.now, episode.messages()))
    for arrived, messages in kept:
        episode.now += 0.001
        episode.give(messages, episode.now - arrived)


@fault("an answer that takes long")
def _slow(episode: Episode) -> None:
    step, more = episode.glass.step, int(episode.rng.integers(6, 30))

    def slow(values: dict[str, float], step_s: float) -> dict[str, float]:
        for _ in range(more):
            episode.now += CYCLE_S
            episode.messages()  # the machine goes on, unheard
        return step(values, step_s)

    episode.glass.step = slow  # type: ignore[method-assign,assignment]
    episode.cycle()
    del episode.glass.step


# The bus, the machine, another gateway


@fault("bus lost and back")
def _bus(episode: Episode) -> None:
    for _ in cycles(episode):
        episode.now += CYCLE_S
        episode.messages()
        episode.node.tick(episode.now, "bus_off")
    episode.node.reconnected()


@fault("machine starts anew")
def _restart(episode: Episode) -> None:
    episode.start_machine()


@fault("machine not running")
def _not_running(episode: Episode) -> None:
    state = str(episode.rng.choice(["off", "starting", "stopping"]))
    for _ in cycles(episode):
        episode.wait(CYCLE_S)
        episode.give(episode.messages(state))


@fault("a second gateway")
def _rival(episode: Episode) -> None:
    other = Sender(episode.database, COMPENSATOR)
    episode.cycle(lambda messages: [*other.messages({"valid": "valid"}), *messages])
    for _ in cycles(episode, 2):
        episode.rivals_at = episode.now
        episode.cycle(lambda messages: [*other.messages({"valid": "valid"}), *messages])
    episode.rivals_at = episode.now


@fault("random frames")
def _random(episode: Episode) -> None:
    rng = episode.rng
    ids = [frame.frame_id for frame in episode.database.frames]
    for _ in cycles(episode):

        def flood(messages: Messages) -> Messages:
            for _ in range(20):
                junk = can.Message(
                    arbitration_id=int(rng.choice(ids)),
                    data=rng.bytes(int(rng.integers(0, 9))),
                    is_extended_id=False,
                )
                messages.insert(int(rng.integers(0, len(messages) + 1)), junk)
            return messages

        episode.cycle(flood)


# Right CRC, right counts, wrong content


@fault("a frame replaced, everything else right", MASQUERADE)
def _masquerade(episode: Episode) -> None:
    for _ in cycles(episode):
        at = not_last(episode)

        def replace_one(messages: Messages, at: int = at) -> Messages:
            data = bytearray(messages[at].data)
            data[2:6] = bytes((0x10, 0x27, 0x10, 0x27))
            messages[at] = sealed(episode, at, bytes(data))
            return messages

        episode.cycle(replace_one)
