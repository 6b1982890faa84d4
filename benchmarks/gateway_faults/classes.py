"""The classes of faults: each takes an episode that has settled and lets something go wrong."""

from __future__ import annotations

from collections.abc import Callable

import can

from benchmarks.gateway_faults.harness import CYCLE_S, Change, Episode, Messages
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


def frame_of(frame_id: int, data: bytes) -> can.Message:
    """Return a message."""
    return can.Message(arbitration_id=frame_id, data=data, is_extended_id=False)


def with_data(message: can.Message, data: bytes) -> can.Message:
    """Return a message with other data."""
    return frame_of(message.arbitration_id, data)


def sealed(episode: Episode, at: int, data: bytes) -> can.Message:
    """Return a frame of the machine with a CRC that fits."""
    frame = episode.database.of(MACHINE)[at]
    return frame_of(frame.frame_id, frame.protection.sealed(data))


def in_cycles(name: str, *span: int) -> Callable[[Callable[[Episode], Change]], object]:
    """Register a class of faults that goes on for some cycles: what is done to each."""

    def keep(change: Callable[[Episode], Change]) -> Callable[[Episode], Change]:
        @fault(name)
        def _change(episode: Episode) -> None:
            for _ in cycles(episode, *span):
                episode.cycle(change(episode))

        return change

    return keep


def altered(at: int, new: Callable[[can.Message], can.Message]) -> Change:
    """Return what puts another frame in the place of one of a cycle."""

    def change(messages: Messages) -> Messages:
        messages[at] = new(messages[at])
        return messages

    return change


def delayed(behind: int) -> Change:
    """Return a queue of so many cycles on the way."""
    kept: list[Messages] = []

    def delay(messages: Messages) -> Messages:
        kept.append(list(messages))
        return kept.pop(0) if len(kept) > behind else []

    return delay


def recorded(episode: Episode, count: int) -> list[Messages]:
    """Run cycles and return what the machine sent."""
    kept: list[Messages] = []

    def keep(messages: Messages) -> Messages:
        kept.append(list(messages))
        return messages

    for _ in range(count):
        episode.cycle(keep)
    return kept


# One frame


@in_cycles("frame lost")
def _lost(episode: Episode) -> Change:
    at = place(episode)
    return lambda messages: [*messages[:at], *messages[at + 1 :]]


@in_cycles("frame twice")
def _twice(episode: Episode) -> Change:
    at = place(episode)
    return lambda messages: [*messages[: at + 1], *messages[at:]]


@fault("frame stuck")
def _stuck(episode: Episode) -> None:
    at, kept = place(episode), []

    def stick(message: can.Message) -> can.Message:
        kept.append(message)
        return kept[0]

    for _ in cycles(episode, 2):
        episode.cycle(altered(at, stick))


@in_cycles("bits flipped")
def _flipped(episode: Episode) -> Change:
    rng = episode.rng

    def flip(message: can.Message) -> can.Message:
        data = bytearray(message.data)
        for bit in rng.choice(64, size=int(rng.integers(1, 4)), replace=False):
            data[bit // 8] ^= 1 << bit % 8
        return with_data(message, bytes(data))

    return altered(place(episode), flip)


@in_cycles("wrong length")
def _length(episode: Episode) -> Change:
    at, size = place(episode), int(episode.rng.integers(0, 8))
    return altered(at, lambda message: with_data(message, bytes(message.data[:size])))


@in_cycles("wrong identifier")
def _identifier(episode: Episode) -> Change:
    at = place(episode)

    def route(messages: Messages) -> Messages:
        wrong = messages[(at + 1) % len(episode.database.of(MACHINE))].arbitration_id
        messages[at] = frame_of(wrong, bytes(messages[at].data))
        return messages

    return route


@in_cycles("counter out of sequence")
def _sequence(episode: Episode) -> Change:
    at, back = place(episode), int(episode.rng.integers(1, 15))

    def turn(message: can.Message) -> can.Message:
        data = bytearray(message.data)
        data[1] = data[1] & 0xF0 | ((data[1] & 0x0F) - back) % 15
        return sealed(episode, at, bytes(data))

    return altered(at, turn)


@in_cycles("frames out of order")
def _order(episode: Episode) -> Change:
    # The heartbeat comes before at least one other frame.
    last = len(episode.database.of(MACHINE)) - 1
    order = [last, *(int(i) for i in episode.rng.permutation(last))]
    swap = int(episode.rng.integers(0, last))
    order[0], order[swap] = order[swap], order[0]
    return lambda messages: [messages[i] for i in order]


@fault("value marked, or out of range")
def _marked(episode: Episode) -> None:
    rng = episode.rng
    for _ in cycles(episode):
        name = f"T{rng.integers(1, 12)}" if rng.random() < 0.7 else "tool_length"
        value = (float("nan"), float("inf"), 5000.0, -500.0)[int(rng.integers(0, 4))]
        episode.cycle(**{name: value})


# Frames of other cycles


def _late(episode: Episode, at: int, behind: int, then: int) -> None:
    """Let one frame be late by some cycles, until some after the first of them comes."""
    kept: list[can.Message] = []

    def delay(messages: Messages) -> Messages:
        kept.append(messages[at])
        older = [kept.pop(0)] if len(kept) > behind else []
        return [*messages[:at], *older, *messages[at + 1 :]]

    for _ in range(behind + then):
        episode.cycle(delay)


@fault("one frame late by whole cycles, for a while")
def _late_for_a_while(episode: Episode) -> None:
    _late(episode, place(episode), int(episode.rng.integers(1, 30)), 10)


@fault("one frame late by whole cycles, for good")
def _late_for_good(episode: Episode) -> None:
    rng = episode.rng
    special = (15, 16, 30, 60, 120, 225, 240, 480)
    behind = int(rng.choice(special)) if rng.random() < 0.3 else int(rng.integers(1, 300))
    _late(episode, not_last(episode), behind, 20)


@fault("an extra frame, one count ahead")
def _extra(episode: Episode) -> None:
    at = not_last(episode)
    other = Sender(episode.database, MACHINE)
    readings = {f"T{n}": 60.0 for n in range(1, 12)} | {"tool_length": 240.0, "speed": 1.0}

    def add(messages: Messages) -> Messages:
        while True:
            ahead = other.messages(readings)[at]
            if (ahead.data[1] & 0x0F) == ((messages[at].data[1] & 0x0F) + 1) % 15:
                return [*messages[:-1], ahead, messages[-1]]

    for _ in cycles(episode, 1, 5):
        episode.cycle(add)


@fault("an old cycle again, as it was")
def _old_again(episode: Episode) -> None:
    first = recorded(episode, int(episode.rng.integers(1, 100)))[0]
    for _ in cycles(episode):
        episode.cycle(lambda messages: [*first, *messages])


# Time


@in_cycles("silence", 3, 60)
def _silence(episode: Episode) -> Change:
    return lambda messages: []


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
    behind = int(episode.rng.integers(6, 300))
    queue = delayed(behind)
    for _ in range(behind + 20):
        episode.cycle(queue)


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


@in_cycles("random frames")
def _random(episode: Episode) -> Change:
    rng = episode.rng
    ids = [frame.frame_id for frame in episode.database.frames]

    def flood(messages: Messages) -> Messages:
        for _ in range(20):
            junk = frame_of(int(rng.choice(ids)), rng.bytes(int(rng.integers(0, 9))))
            messages.insert(int(rng.integers(0, len(messages) + 1)), junk)
        return messages

    return flood


# Right CRC, right counts, wrong content


@fault("a frame replaced, everything else right", MASQUERADE)
def _masquerade(episode: Episode) -> None:
    for _ in cycles(episode):
        at = not_last(episode)

        def other(message: can.Message, at: int = at) -> can.Message:
            data = bytearray(message.data)
            data[2:6] = bytes((0x10, 0x27, 0x10, 0x27))
            return sealed(episode, at, bytes(data))

        episode.cycle(altered(at, other))
