"""The fault campaign finds nothing in the gateway, and would find something in a worse one."""

import numpy as np
import pytest

from benchmarks.gateway_faults.__main__ import Play, plays
from gateway.database import Database
from gateway.judging import Rival
from gateway.node import GatewayNode
from gateway.proof import Challenges
from gateway.reception import Watch
from gateway.reference import Reference
from gateway.timebase import Timebase

PLAYS = dict(plays())
UNHEARD = ("random frames", "odd heartbeats", "the time of day was set")
"""These need not spoil anything: a CRC fits by chance, none is odd, a clock is set back."""
pytestmark = pytest.mark.long


def outcomes(database: Database, play: Play, episodes: int) -> tuple[int, int]:
    """Return in how many episodes the fault was noticed, and how many answers were unsafe."""
    rng = np.random.default_rng(7)
    found = [play(database, rng) for _ in range(episodes)]
    assert all(outcome.answers > 0 for outcome in found)
    return sum(outcome.noticed for outcome in found), sum(outcome.unsafe for outcome in found)


@pytest.mark.parametrize("name", PLAYS)
def test_nothing_unsafe_is_called_valid(database, name):
    noticed, unsafe = outcomes(database, PLAYS[name], 2)
    assert unsafe == 0
    assert noticed == 2 or name in UNHEARD


HANDLE = GatewayNode.handle
BELIEVED = property(lambda self: "believed", lambda self, known: None)
CHECKS: dict[str, tuple[type, str, object]] = {
    "counts": (Watch, "_out_of_step", lambda self, closing: None),
    "clock": (Timebase, "judge", lambda self, raw, arrived, jumped, proven: None),
    "proof": (Challenges, "proven", lambda self, told, frames, arrived: True),
    "age": (GatewayNode, "handle", lambda self, message, now, waited: HANDLE(self, message, now)),
    "rivals": (Rival, "finding", lambda self, now: None),
    "reference": (Reference, "known", BELIEVED),
}
"""What is left out of the gateway, and what stands in its place."""


@pytest.mark.parametrize(
    ("check", "name"),
    [
        ("counts", "one frame late by whole cycles, for good"),
        ("clock", "every cycle late, for good"),
        ("clock", "machine's clock at another rate"),
        ("age", "gateway stopped, then goes on (--clock machine)"),
        ("rivals", "a second gateway"),
        ("proof", "whole old cycles replayed"),
        ("reference", "started in a warm-up, no state"),
    ],
)
def test_a_gateway_without_a_check_is_found_out(database, monkeypatch, check, name):
    owner, function, instead = CHECKS[check]
    monkeypatch.setattr(owner, function, instead, raising=False)
    # A proof would find most of it out alone.
    frames = database if check == "proof" else database.unproven()
    assert outcomes(frames, PLAYS[name], 6)[1] > 0
