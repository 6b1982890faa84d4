"""Freshness: what a proof shows, what nothing else shows, and time that one clock has not seen."""

import os
from math import nan

import can
import pytest

from gateway.codec import Sender
from gateway.database import MACHINE
from gateway.node import GatewaySettings
from gateway.proof import LARGEST_ECHO, Challenges, draw, proof_of, read_key
from gateway.state import Saved
from measurement.errors import BadInput
from tests.gateway.bench import WARM, Bench, validity

HOUR_S = 3600.0
# RFC 4493, section 4, example 4: a key, 64 bytes, and their AES-CMAC.
KEY = bytes.fromhex("2b7e151628aed2a6abf7158809cf4f3c")
TEXT = bytes.fromhex(
    "6bc1bee22e409f96e93d7e117393172aae2d8a571e03ac9c9eb76fac45af8e51"
    "30c81c46a35ce411e5fbc1191a0a52eff69f2445df4f9b17ad2b417be66c3710"
)
CODE = bytes.fromhex("51f0bebf7e3b9d92fc49741779363cfe")

# The proof itself


def test_a_proof_is_the_crc_32_of_challenge_and_frames():
    """Check value of CRC-32/ISO-HDLC of the digits 1 to 9 in the catalogue: CBF43926h."""
    digits = b"123456789"
    assert proof_of(int.from_bytes(digits[:4], "little"), [digits[4:6], digits[6:]]) == 0xCBF43926


def test_with_a_key_it_is_the_beginning_of_the_aes_cmac_of_rfc_4493():
    pytest.importorskip("cryptography")
    challenge = int.from_bytes(TEXT[:4], "little")
    assert proof_of(challenge, [TEXT[4:20], TEXT[20:]], KEY).to_bytes(4, "little") == CODE[:4]


def test_a_challenge_is_hardly_ever_drawn_twice_and_has_an_echo():
    drawn = [draw() for _ in range(2000)]
    assert len(set(drawn)) > 1990
    assert max(challenge & 0xFFFF for challenge in drawn) <= LARGEST_ECHO


def test_only_a_young_challenge_proves_anything():
    numbers = iter(range(100, 200))
    challenges = Challenges(0.35, new=lambda: next(numbers))
    frames = [b"abc", b"defg"]

    def proven(challenge: int, arrived: float, content: list[bytes] = frames) -> bool:
        told = {"echo": float(challenge), "proof": float(proof_of(challenge, frames))}
        return challenges.proven(told, content, arrived)

    assert [challenges.issue(0.1 * k) for k in range(5)] == [100, 101, 102, 103, 104]
    assert [proven(challenge, 0.45) for challenge in range(99, 106)] == (
        [False, False, True, True, True, True, False]
    )
    assert not proven(104, 0.45, [b"abc", b"defh"])
    assert not proven(104, 0.45, [b"defg", b"abc"])
    assert not challenges.proven({}, frames, 0.45)


@pytest.mark.parametrize(
    ("text", "mode", "told"),
    [
        ("00" * 16, 0o644, "can be read by others"),
        ("00" * 16, 0o620, "can be read by others"),
        ("00" * 15, 0o600, "is not a key"),
        ("my secret", 0o600, "is not a key"),
        ("\x00\xff", 0o600, "is not a key"),
    ],
)
def test_a_key_is_of_hexadecimal_digits_that_only_its_owner_reads(tmp_path, text, mode, told):
    path = tmp_path / "key"
    path.write_text(text, encoding="latin-1")
    os.chmod(path, mode)
    with pytest.raises(BadInput, match=told):
        read_key(path)
    path.write_text("0f" * 32 + "\n")
    os.chmod(path, 0o600)
    assert read_key(path) == bytes([15] * 32)


# What a proof shows


@pytest.mark.parametrize("pause_s", [0.1, 1.0, 10.0])
def test_a_recording_is_never_valid(warm, pause_s):
    recording = []

    def keep(messages: list[can.Message]) -> list[can.Message]:
        recording.append(list(messages))
        return messages

    warm.cycles(100, WARM, keep)
    warm.wait(pause_s)
    first = len(warm.answers)
    for messages in recording:
        warm.give(messages)
    answers = warm.answers[first:]
    assert validity(answers) == {"invalid"}
    assert {answer["freshness"] for answer in answers} == {"not_proven"}
    assert answers[-1]["bus_fault"] == "not_fresh"
    warm.cycles(20, WARM)
    assert (warm.last["valid"], warm.last["freshness"]) == ("valid", "proven")


@pytest.mark.parametrize("odd", [{"machine_time": 5.0}, {"machine_step": float("nan")}, "starting"])
def test_a_delay_is_not_forgotten_after_an_odd_heartbeat(warm, odd):
    queue: list[list[can.Message]] = []

    def late(messages: list[can.Message]) -> list[can.Message]:
        queue.append(messages)
        return queue.pop(0) if len(queue) > 20 else []

    warm.cycles(40, WARM, late)
    first = len(warm.answers)
    if isinstance(odd, dict):
        warm.cycle({**WARM, **odd}, late)
    else:
        warm.give(late(warm.frames(WARM, str(odd))))
    warm.cycles(100, WARM, late)
    assert validity(warm.answers[first:]) == {"invalid"}
    warm.cycles(30, WARM)
    assert warm.last["valid"] == "valid"


def test_a_gateway_that_is_started_into_a_delay_is_never_valid(bench):
    queue = [bench.frames(WARM, "starting") for _ in range(20)]
    for _ in range(200):
        queue.append(bench.frames(WARM))
        bench.give(queue.pop(0))
    assert validity(bench.answers) == {"invalid"}


def test_a_machine_that_cannot_prove_it_is_served_and_marked(database, unit):
    bench = Bench(database.unproven(), unit)
    bench.settle(WARM)
    assert bench.last["freshness"] == "not_proven"
    assert len(bench.frames()) == len(database.of(MACHINE)) - 1


def test_who_has_another_key_proves_nothing(database, unit):
    pytest.importorskip("cryptography")
    bench = Bench(database, unit, GatewaySettings(key=KEY))
    bench.sender = Sender(database, MACHINE, KEY)
    bench.settle(WARM)
    for key in (None, KEY[::-1]):
        other = Sender(database, MACHINE, key)
        for _ in range(3):
            bench.give(other.messages({"machine_state": "running"}, bench.challenge))
        assert bench.last["freshness"] == "not_proven"
    assert "2b7e" not in repr(bench.settings)


# Time that one clock has not seen


@pytest.mark.parametrize("proves", [True, False])
@pytest.mark.parametrize("witness", ["machine", "wall"])
def test_hours_that_this_clock_has_not_seen_are_told_to_the_compensator(
    database, unit, witness, proves
):
    bench = Bench(database if proves else database.unproven(), unit)
    bench.settle(WARM)
    reached = unit.time_s
    if witness == "machine":
        bench.time_s += 5.0 * HOUR_S
        bench.began -= 5.0 * HOUR_S
    else:  # the machine's clock begins anew, and tells nothing
        bench.wall_ahead_s += 5.0 * HOUR_S
        bench.time_s, bench.began = 7000.0, None
        bench.give(bench.frames(state="starting"))
    bench.cycle(WARM)
    assert bench.last["valid"] == "invalid"
    assert unit.time_s - reached == pytest.approx(5.0 * HOUR_S, abs=1.0)
    bench.cycles(300, WARM)
    assert bench.last["valid"] == "valid"
    assert unit.time_s - reached == pytest.approx(5.0 * HOUR_S + 30.0, abs=1.0)


def test_a_time_of_day_that_is_set_ahead_moves_nothing_while_the_machines_clock_agrees(warm):
    before, warm.wall_ahead_s = warm.offsets, warm.wall_ahead_s + HOUR_S
    warm.cycle(WARM)
    assert (warm.last["valid"], warm.offsets) == ("valid", before)


def test_a_program_that_stood_still_tells_the_time_as_not_seen(warm):
    given: list[tuple[int, float]] = []
    step = warm.unit.step

    def watched(values: dict[str, float], step_s: float) -> dict[str, float]:
        given.append((len(values), step_s))
        return step(values, step_s)

    warm.unit.step = watched
    warm.now += 2.0 * HOUR_S
    for message in warm.frames(WARM):
        warm.node.handle(message, warm.now)
    assert given[0] == (0, pytest.approx(2.0 * HOUR_S, abs=1.0))


# How old a state is


@pytest.mark.parametrize(
    ("by_machine_s", "machine_clock", "known"),
    [(11.0, False, True), (13.0, False, False), (3000.0, True, True), (4000.0, True, False)],
)
def test_a_state_is_as_old_as_both_clocks_say_or_too_old(
    warm, database, new_unit, by_machine_s, machine_clock, known
):
    """A computer without a clock battery, or a simulation at many times real time: two seconds."""
    saved = Saved(warm.unit.time_s, warm.time_s, 2.0, warm.unit.slave.saved())
    settings = GatewaySettings(machine_clock=machine_clock)
    again = Bench(database, new_unit(), settings, saved)
    again.sender, again.time_s = warm.sender, round(warm.time_s + by_machine_s, 1)
    again.cycles(100, {**WARM, "thermal_state": "warm"})
    assert (again.last["valid"] == "valid") == known
    assert (again.last["status"] == "reference_unknown") != known


# A new reference


def test_who_says_that_the_machine_is_cold_has_the_drift_counted_from_now(warm):
    assert max(map(abs, warm.offsets)) > 10.0
    warm.node.renew_reference()
    warm.cycles(60, WARM)
    assert warm.last["valid"] == "valid"
    assert warm.offsets == (0.0, 0.0, 0.0)
    warm.cycles(60, {"T1": 26.0, "T4": 26.0})
    assert warm.offsets != (0.0, 0.0, 0.0)


# What people are told


def test_the_same_fault_is_not_said_ten_times_a_second(warm):
    before = len(warm.said)
    for k in range(400):
        warm.cycle({**WARM, "T11": nan if k % 2 else 20.0})
    assert len(warm.said) - before <= 2


def test_each_thermometer_that_goes_is_said_and_those_that_go_together_in_a_line(warm):
    before, gone = len(warm.said), dict(WARM)
    for names in (["T2"], ["T3"], ["T5", "T11"]):
        gone |= dict.fromkeys(names, nan)
        warm.cycle(gone)
        warm.cycle(gone)
    assert [line.count("not available") for line in warm.said[before:]] == [2, 2, 3]
