"""The fault campaign finds nothing in the gateway, and would find something in a worse one."""

from collections.abc import Callable

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
Patch = Callable[[pytest.MonkeyPatch], None]


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


def without_counts(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Watch, "_out_of_step", lambda self, closing: None)


def without_clock(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Timebase, "judge", lambda self, raw, arrived, jumped, proven: None)


def without_proof(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Challenges, "proven", lambda self, told, frames, arrived: True)


def without_age(patch: pytest.MonkeyPatch) -> None:
    handle = GatewayNode.handle
    patch.setattr(
        GatewayNode, "handle", lambda self, message, now, waited: handle(self, message, now)
    )


def without_rivals(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Rival, "finding", lambda self, now: None)


def without_reference(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Reference, "take", lambda self, values, elapsed, cold: "believed")
    patch.setattr(Reference, "known", "believed", raising=False)
    patch.setattr(Reference, "__init__", lambda self, proof, temperatures: None)


@pytest.mark.parametrize(
    ("patch", "name"),
    [
        (without_counts, "one frame late by whole cycles, for good"),
        (without_clock, "every cycle late, for good"),
        (without_clock, "machine's clock at another rate"),
        (without_age, "gateway stopped, then goes on (--clock machine)"),
        (without_rivals, "a second gateway"),
        (without_proof, "whole old cycles replayed"),
        (without_reference, "started in a warm-up, no state"),
    ],
)
def test_a_gateway_without_a_check_is_found_out(database, monkeypatch, patch, name):
    patch(monkeypatch)
    # A proof would find most of it out alone.
    frames = database if patch is without_proof else database.unproven()
    assert outcomes(frames, PLAYS[name], 6)[1] > 0
