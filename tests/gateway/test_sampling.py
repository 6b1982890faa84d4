"""Frames that come at their own pace, and their protections."""

from dataclasses import replace
from math import inf, nan

import pytest

from gateway.codec import Encoder
from gateway.database import MACHINE, Database, Frame, Substitute
from gateway.protection import CHECKS, Protection
from gateway.reception import Reception, Substitution

COUNTS = 16
# Of the ASCII digits 1 to 9, as the catalogue of parametrised CRC algorithms lists it; the sum and
# the exclusive or are plain arithmetic.
DIGITS = b"123456789"
KNOWN = {
    "crc8_sae_j1850": 0x4B,
    "crc8_autosar": 0xDF,
    "crc8_smbus": 0xF4,
    "crc16_ccitt_false": 0x29B1,
    "e2e_profile_1": 0x37,
    "sum8": sum(DIGITS) % 256,
    "xor8": 0x31,
}


@pytest.fixture
def turning(builder: Database) -> Frame:
    """A frame of one signal with a counter and a check value."""
    frame = next(frame for frame in builder.of(MACHINE) if frame.name == "SPN_STATUS")
    protection = Protection("crc8_autosar", "OpMode", COUNTS, "check", 5, True, b"\x2a")
    signals = {"speed": frame.signals["speed"]}
    fixed = {"SpnLoad": 0, "OpMode": 0}
    return replace(frame, protection=protection, signals=signals, fixed=fixed, timeout_s=2.5)


@pytest.mark.parametrize("big", [True, False])
@pytest.mark.parametrize("name", list(CHECKS))
def test_a_check_value_is_that_of_its_catalogue(name, big):
    size = CHECKS[name][1]
    data = DIGITS[2:5] + bytes(size) + DIGITS[5:]
    protection = Protection(name, "", 1, "check", 3, big, DIGITS[:2])
    sealed = protection.sealed(data)
    order = "big" if big else "little"
    assert int.from_bytes(sealed[3 : 3 + size], order) == KNOWN[name]
    assert sealed[:3] + sealed[3 + size :] == DIGITS[2:]
    assert protection.intact(sealed)
    for place in range(len(sealed)):
        changed = bytearray(sealed)
        changed[place] ^= 0x10
        assert not protection.intact(changed)


@pytest.mark.parametrize(
    ("protection", "trust"),
    [
        (Protection(), "none"),
        (Protection("counter", "n", 4), "partly"),
        (Protection("sum8", "", 1, "s", 0), "partly"),
        (Protection("sum8", "n", 4, "s", 0), "protected"),
    ],
)
def test_trust_is_what_can_be_noticed(protection, trust):
    assert protection.trust == trust


def speeds(frame: Frame, count: int) -> list[bytes]:
    """Return so many frames, each a turn faster."""
    encoder = Encoder(frame)
    return [bytes(encoder.message({"speed": 100.0 + k}).data) for k in range(count)]


@pytest.mark.parametrize(
    ("frames", "at", "speed", "fault"),
    [
        pytest.param([(0, 0), (1, 1), (2, 2)], 2.5, 102.0, "", id="the newest is good"),
        pytest.param([(0, 0), (1, 1), (2, 2)], 5.0, nan, "missing", id="until it is late"),
        pytest.param([(0, 0), (1, 1), (2, 5)], 2.0, 105.0, "", id="some may be lost"),
        pytest.param(
            [(0, 0), *((k / 10, 1) for k in range(1, 40))], 4.0, nan, "repeated", id="stuck"
        ),
        pytest.param([(0, 0), (1, 1), (1.1, "changed")], 2.0, 101.0, "bad_crc", id="changed"),
        pytest.param([(0, 0), (1, 1), (1.1, "short")], 2.0, 101.0, "wrong_length", id="short"),
    ],
)
def test_what_a_look_gives_of_frames_that_came(turning, frames, at, speed, fault):
    """Frames by the time when they came, and their number."""
    sent = dict(enumerate(speeds(turning, 6)))
    sent |= {"changed": bytes((sent[2][0], sent[2][1] ^ 1, *sent[2][2:])), "short": sent[2][:4]}
    sampling = Reception([turning], together=False)
    for now, number in frames:
        sampling.take(turning.key, sent[number], now)
        if now == 0:
            sampling.look(now)
    cycle = sampling.look(at)
    assert cycle.values["speed"] == pytest.approx(speed, nan_ok=True)
    assert (cycle.finding.fault if cycle.finding else "") == fault


def test_two_senders_with_the_right_check_value_spoil_it(turning):
    one, other = speeds(turning, 30), speeds(turning, 40)[9:]
    sampling = Reception([turning], together=False)
    used = []
    for k, (first, second) in enumerate(zip(one, other, strict=False)):
        for data in (first, second):
            sampling.take(turning.key, data, 0.1 * k)
            used.append(sampling.look(0.1 * k).usable)
    assert not any(used[4:])


@pytest.mark.parametrize("lead", range(COUNTS))
def test_a_second_sender_leaves_nothing_to_use_however_far_it_is_ahead(turning, lead):
    sampling, sent = Reception([turning], together=False), speeds(turning, 40 + lead)
    for k in range(40):
        for data in (sent[k], sent[k + lead]):
            sampling.take(turning.key, data, 0.1 * k)
        cycle = sampling.look(0.1 * k)
    assert not cycle.usable


def test_a_frame_that_may_never_be_late_must_come_once(turning):
    turning = replace(turning, timeout_s=inf, protection=Protection())
    sampling = Reception([turning], together=False)
    assert sampling.look(0.0).finding.fault == "startup"
    sampling.take(turning.key, *speeds(turning, 1), 0.0)
    cycle = sampling.look(1e6)
    assert (cycle.values["speed"], cycle.finding) == (100.0, None)


def test_a_frame_of_optional_signals_spoils_nothing(turning):
    assert not Reception([turning], together=False).look(1.0).usable
    assert Reception([turning], together=False, optional={"speed"}).look(1.0).usable


def test_what_stands_for_a_missing_input():
    substitution = Substitution({"a": Substitute(5.0), "b": Substitute(None, 10.0)})
    assert substitution.fill({"a": 1.0, "b": 2.0, "c": nan}, 0.0)["a"] == 1.0
    later = substitution.fill({"a": nan, "b": nan, "c": nan}, 10.0)
    assert (later["a"], later["b"]) == (5.0, 2.0)
    assert later["c"] != later["c"]
    last = substitution.fill({}, 10.1)
    assert last["a"] == 5.0
    assert last["b"] != last["b"]
