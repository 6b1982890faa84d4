"""Faults that make old cycles look new, alone and two at once."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import nan

import can

from benchmarks.gateway_faults.classes import FAULTS, cycles, delayed, fault, place, recorded
from benchmarks.gateway_faults.harness import CYCLE_S, Change, Episode, Messages
from gateway.codec import Value

HOUR_S = 3600.0
ALONE = ("a second gateway", "machine's clock at another rate")
"""These are judged alone: beside another fault they are valid for a while, as the page says. The
bench counts a rival from when its frames leave, and the gateway hears them when they arrive; a
clock at another rate begins anew with each restart and gap, and shows some cycles later."""
SINGLE = {name: play for name, play in FAULTS.items() if name not in ALONE}
"""The classes that two at once are drawn from."""


def played(episode: Episode, recording: list[Messages]) -> None:
    """Play a recording at the machine's pace; the machine itself is not heard."""
    for messages in recording:
        episode.wait(CYCLE_S)
        episode.messages()  # it goes on
        episode.give(messages)


@fault("whole old cycles replayed")
def _replayed(episode: Episode) -> None:
    recording = recorded(episode, int(episode.rng.integers(20, 120)))
    for _ in cycles(episode, 0, 60):
        episode.wait(CYCLE_S)  # the recorder takes over, at once or after a while
        episode.messages()
    episode.begin()
    played(episode, recording)


@fault("whole old cycles replayed beside the machine")
def _replayed_beside(episode: Episode) -> None:
    recording = recorded(episode, int(episode.rng.integers(20, 120)))
    episode.begin()
    for messages in recording:
        episode.cycle(lambda own, messages=messages: [*own, *messages])


@fault("a recording played from the machine's start")
def _from_the_start(episode: Episode) -> None:
    recording: list[Messages] = []
    episode.time_s = 0.0
    for _ in range(3):
        episode.wait(CYCLE_S)
        recording.append(episode.messages("starting"))
        episode.give(recording[-1])
    recording += recorded(episode, int(episode.rng.integers(60, 120)))
    for _ in cycles(episode, 0, 50):
        episode.wait(CYCLE_S)
        episode.messages()
    episode.begin()
    played(episode, recording)


ODD: tuple[dict[str, Value], ...] = (
    {"machine_state": "starting"},
    {"machine_state": "off"},
    {"machine_state": nan},
    {"machine_time": nan},
    {"machine_step": nan},
    {"machine_step": 0.0},
    {"machine_time": 5.0},
)
"""What a machine sends once, and should not."""


def odd(episode: Episode) -> dict[str, Value]:
    """Return what is odd about a heartbeat."""
    return ODD[int(episode.rng.integers(0, len(ODD)))]


@fault("a lasting delay, then odd heartbeats")
def _delay_then_odd(episode: Episode) -> None:
    behind = int(episode.rng.integers(6, 150))
    episode.background = delayed(behind)
    for _ in range(int(episode.rng.integers(1, 20))):
        episode.cycle()
    for _ in cycles(episode, 1, 3):
        more = odd(episode)
        state = str(more.get("machine_state", "running"))
        if state == "running" or more.get("machine_state") is nan:
            episode.cycle(**more)
        else:
            episode.wait(CYCLE_S)
            episode.give(episode.background(episode.messages(state)))
    for _ in range(behind + 40):
        episode.cycle()
    episode.background = lambda messages: messages


@fault("odd heartbeats")
def _odd(episode: Episode) -> None:
    for _ in cycles(episode):
        episode.cycle(**(odd(episode) if episode.rng.random() < 0.5 else {}))


@fault("every cycle late since the gateway started")
def _late_from_the_start(episode: Episode) -> None:
    episode.background = delayed(int(episode.rng.integers(6, 150)))
    episode.start_gateway()
    for _ in range(200):
        episode.cycle()
    episode.background = lambda messages: messages


# Two at once


def lossy(episode: Episode) -> Change:
    """Return a bus that loses frames."""

    def lose(messages: Messages) -> Messages:
        return [m for m in messages if episode.rng.random() > 0.03]

    return lose


def haunted(episode: Episode) -> Change:
    """Return a bus on which older frames come again in the place of newer ones."""
    kept: list[Messages] = []

    def haunt(messages: Messages) -> Messages:
        kept.append(list(messages))
        again = kept[int(episode.rng.integers(0, len(kept)))]
        if len(kept) > 240 and episode.rng.random() < 0.5:
            again = kept[-241]  # of the same counts
        for at in range(min(len(messages), len(again))):
            if episode.rng.random() < 0.1:
                messages[at] = again[at]
        return messages

    return haunt


def one_late(episode: Episode) -> Change:
    """Return a bus on which one frame is late for good, until its counts are right again."""
    at, behind = place(episode), int(episode.rng.choice([1, 15, 16, 240]))
    kept: list[can.Message] = []

    def delay(messages: Messages) -> Messages:
        kept.extend(messages[at : at + 1])
        older = [kept.pop(0)] if len(kept) > behind else []
        return [*messages[:at], *older, *messages[at + 1 :]]

    return delay


BACKGROUNDS: tuple[Callable[[Episode], Change], ...] = (
    lossy,
    haunted,
    one_late,
    lambda episode: delayed(int(episode.rng.integers(1, 60))),
)


def _pairs(episode: Episode) -> Iterator[Callable[[Episode], None]]:
    names = list(SINGLE)
    for _ in range(3):
        yield SINGLE[names[int(episode.rng.integers(0, len(names)))]]


@fault("two faults at once")
def _two(episode: Episode) -> None:
    chosen = int(episode.rng.integers(0, len(BACKGROUNDS)))
    episode.background = BACKGROUNDS[chosen](episode)
    for _ in range(int(episode.rng.choice([20, 260]))):
        episode.cycle()
    for other in _pairs(episode):
        try:
            other(episode)
        except IndexError:
            continue  # what it wanted to change did not come
        if episode.rng.random() < 0.3:
            episode.start_machine(episode.time_s)
    for _ in range(20):
        episode.cycle()
    episode.background = lambda messages: messages


# Clocks


def away(episode: Episode, *, own: bool, wall: bool, machine: bool) -> None:
    """Let hours go by that only some clocks see; nobody is heard meanwhile."""
    gone_s = round(float(episode.rng.uniform(0.5, 6.0)) * HOUR_S, 1)
    if own:
        episode.now += gone_s
    episode.pass_unseen(gone_s)
    episode.wall_ahead_s += gone_s * (wall - own)
    if machine:
        episode.time_s = round(episode.time_s + gone_s, 3)
    else:
        episode.start_machine()
    for _ in range(60):
        episode.cycle()


@fault("this computer's clock stood still")
def _own_stood(episode: Episode) -> None:
    away(episode, own=False, wall=bool(episode.rng.integers(0, 2)), machine=True)


@fault("this program stood still for hours")
def _program_stood(episode: Episode) -> None:
    away(episode, own=True, wall=True, machine=True)


@fault("this computer's clock stood still, the machine's began anew")
def _own_stood_machine_anew(episode: Episode) -> None:
    away(episode, own=False, wall=True, machine=False)


@fault("the time of day was set")
def _wall_set(episode: Episode) -> None:
    episode.wall_ahead_s += float(episode.rng.choice([-1.0, 1.0]) * 10 ** episode.rng.uniform(1, 9))
    for _ in range(60):
        episode.cycle()
