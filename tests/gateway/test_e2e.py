"""Protection: identifiers, counters, and a receiver that nothing breaks."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gateway.codec import Sender
from gateway.database import COMPENSATOR, MACHINE
from gateway.protection import COUNTERS
from gateway.reception import Reception

CONTENT = bytes.fromhex("0003ec2ea12f55aa")


def test_a_frame_of_another_identifier_does_not_fit(database):
    """The data id makes a frame that is routed to the wrong place one with a bad CRC."""
    for frame in database.frames:
        data = frame.protection.sealed(CONTENT)
        others = [other for other in database.frames if other is not frame]
        assert not any(other.protection.intact(data) for other in others)


@pytest.mark.parametrize("node", [MACHINE, COMPENSATOR])
def test_the_counter_runs_from_0_to_14(database, node):
    sender = Sender(database, node)
    counters = [[m.data[1] & 0x0F for m in sender.messages({})] for _ in range(31)]
    for k, row in enumerate(counters):
        assert row == [k % COUNTERS] * len(row)
    assert max(max(row) for row in counters) == 14


FRAMES = st.tuples(
    st.sampled_from([0x20F, 0x210, 0x211, 0x212, 0x213, 0x214, 0x215, 0x190, 0x7FF]),
    st.one_of(st.binary(max_size=12), st.binary(min_size=8, max_size=8)),
    st.booleans(),
    st.floats(0.0, 1.0),
)


@given(st.lists(FRAMES, max_size=60))
def test_nothing_that_arrives_breaks_the_receiver(database, frames):
    """Any bytes, also with a CRC that fits: no exception, and never a value out of its range."""
    reception = Reception(database.of(MACHINE))
    ids = {frame.frame_id: frame for frame in database.of(MACHINE)}
    signals = {signal.name: signal for _, signal in database.signals(MACHINE)}
    now = 0.0
    for frame_id, data, fitting, pause in frames:
        now += pause
        if fitting and frame_id in ids and len(data) == 8:
            data = ids[frame_id].protection.sealed(data)
        cycle = reception.take(frame_id, data, now)
        if pause > 0.9:
            cycle = cycle or reception.look(now, silent=True)
        for name, value in cycle.values.items() if cycle else ():
            assert value != value or signals[name].low <= value <= signals[name].high
            assert value != value or (cycle is not None and cycle.usable)
    assert sum(reception.counts.values()) == len(frames)


@given(st.data())
def test_a_usable_cycle_holds_what_was_sent_whatever_came_between(database, data):
    """Junk between good frames is either left out or spoils the cycle; it never changes a value."""
    reception, sender = Reception(database.of(MACHINE)), Sender(database, MACHINE)
    generator = data.draw(st.randoms(use_true_random=False))
    for k in range(6):
        sent = {f"T{n}": 20.0 + n + k for n in range(1, 12)}
        for message in sender.messages({**sent, "machine_state": "running", "speed": 1000.0 * k}):
            if generator.random() < 0.2:
                junk = bytearray(message.data)
                junk[generator.randrange(8)] ^= 1 << generator.randrange(8)
                assert reception.take(message.arbitration_id, junk, 0.1 * k) is None
            cycle = reception.take(message.arbitration_id, message.data, 0.1 * k)
        if cycle is not None and cycle.usable:
            for name, value in sent.items():
                assert cycle.values[name] == pytest.approx(value, abs=0.005)
        assert k < 2 or (cycle is not None and cycle.usable)
