"""What the gateway cannot know it does not call valid: references, clocks, counts, age, rivals."""

from math import nan
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import can
import pytest

from gateway.codec import Sender, high_raw
from gateway.database import COMPENSATOR, MACHINE
from gateway.node import GatewaySettings
from gateway.reception import Reception
from gateway.reference import Proof, Reference
from gateway.serving import Service
from gateway.timebase import CLOCK_DRIFT, Timebase
from tests.gateway.bench import WARM, Bench

NOT_COLD = {"thermal_state": "warm"}
TOGETHER = GatewaySettings(proof=Proof(ambient="T5", band_k=1.0, time_s=60.0))

# The reference


def test_a_cold_restart_in_a_warm_up_is_never_valid(bench):
    for _ in range(3):
        bench.give(bench.frames(NOT_COLD, state="starting"))
    for _ in range(200):
        answer = bench.cycle(WARM | NOT_COLD)
        assert answer["valid"] == "invalid"
        assert answer["status"] == "reference_unknown"
        assert bench.offsets == (0.0, 0.0, 0.0)
    assert answer["gateway_state"] == "running"
    assert answer["bus_fault"] == "none"
    assert bench.node.steps == 0


def test_the_status_shown_elsewhere_is_that_of_the_frames(bench, database):
    codes = database.signal("status").codes
    for thermal_state, known in (("warm", False), ("cold", True)):
        for _ in range(3):
            bench.give(bench.frames({"thermal_state": thermal_state}, state="starting"))
        answer = bench.cycle({"thermal_state": thermal_state})
        assert (answer["status"] == "ok") == known
        assert bench.node.status == codes[answer["status"]]


def test_a_status_that_flickers_is_told_once_a_minute():
    said: list[str] = []
    now, unit, bus = [0.0], SimpleNamespace(outputs={}), SimpleNamespace(machine_time_s=0.0)
    parts: list[Any] = [None, Path(), unit, None, None]
    service = Service(*parts, clock=lambda: now[0], say=said.append)
    for second in range(150):
        now[0] = float(second)
        shown: Any = SimpleNamespace(status=second % 2, status_text="", stepper=bus)
        service._notice(shown)
    assert len(said) == 6


def test_a_machine_that_says_it_is_cold_is_believed_for_a_minute_only(bench):
    for _ in range(3):
        bench.give(bench.frames({"thermal_state": "cold"}, state="starting"))
    for _ in range(700):
        bench.give(bench.frames(NOT_COLD, state="starting"))
    assert bench.cycle(NOT_COLD)["status"] == "reference_unknown"
    assert bench.node.steps == 0


def test_temperatures_that_stand_with_the_ambient_one_prove_a_cold_machine(database, unit):
    bench = Bench(database, unit, TOGETHER)
    for _ in range(3):
        bench.give(bench.frames(NOT_COLD, state="starting"))
    began = bench.now
    while bench.node.steps == 0 and bench.now - began < 100.0:
        bench.cycle({"T3": 20.4} | NOT_COLD)
    assert {answer["valid"] for answer in bench.answers[:-1]} == {"invalid"}
    assert bench.now - began == pytest.approx(60.0, abs=1.0)
    assert any("within 1 K" in line for line in bench.said)


@pytest.mark.parametrize(
    "moved",
    [
        pytest.param(lambda k: {"T1": 21.1}, id="apart"),
        pytest.param(lambda k: {f"T{n}": 30 - k * 3e-3 for n in range(1, 12)}, id="cools"),
        pytest.param(lambda k: {"T7": nan}, id="one is missing"),
    ],
)
def test_temperatures_that_are_apart_or_move_prove_nothing(database, unit, moved):
    bench = Bench(database, unit, TOGETHER)
    for k in range(800):
        bench.cycle(moved(k) | NOT_COLD)
    assert bench.node.steps == 0
    assert {answer["valid"] for answer in bench.answers} == {"invalid"}


def test_temperatures_prove_nothing_without_an_ambient_one():
    reference = Reference(Proof(), ["T1", "T2"])
    for _ in range(10_000):
        assert not reference.take({"T1": 20.0, "T2": 20.0}, 1.0, cold=False)
    assert Reference(Proof(said=True), ["T1"]).take({}, 1.0, cold=False)


def test_a_gap_in_the_readings_is_no_time_together():
    reference = Reference(Proof(ambient="T1", time_s=600.0), ["T1", "T2"])
    for _ in range(20):
        assert not reference.take({"T1": 20.0, "T2": 20.5}, 100.0, cold=False)


# Frames of different cycles


@pytest.mark.parametrize(("behind", "place"), [(1, 1), (240, 5)])
def test_a_frame_that_is_late_for_good_is_noticed(bench, behind, place):
    bench.settle(WARM)
    kept: list[can.Message] = []

    def delay(messages: list[can.Message]) -> list[can.Message]:
        kept.append(messages[place])
        older = [kept.pop(0)] if len(kept) > behind else []
        return [*messages[:place], *older, *messages[place + 1 :]]

    first = len(bench.answers)
    for k in range(behind + 300):
        bench.cycle(
            {
                **WARM,
                "tool_length": 150.0 + 0.01 * k,
                "T10": 20.0 + 0.01 * k,
                "T2": 20.0 + 0.01 * k,
            },
            delay,
        )
    assert {answer["valid"] for answer in bench.answers[first:]} == {"invalid"}
    # It is believed again as soon as it comes in time, or when the machine has started anew.
    kept.clear()
    for _ in range(3):
        bench.give(bench.frames(state="starting"))
    for _ in range(60):
        bench.cycle(WARM)
    assert bench.last["valid"] == "valid"


def test_a_further_frame_in_sequence_is_noticed(bench, database):
    bench.settle(WARM)
    other = Sender(database, MACHINE)
    for _ in range(bench.sender._encoders[5]._count + 1):
        extra = other.messages({"tool_length": 240.0, "speed": 3000.0})[5]
    answer = bench.cycle(WARM, lambda messages: [*messages[:6], extra, messages[6]])
    assert answer["valid"] == "invalid"
    assert answer["dX_tool_length"] == 150.0
    assert bench.cycle(WARM)["valid"] == "invalid"


# Clocks

RAW = 2**32 - 2


def base(speed_up: float = 1.0) -> Timebase:
    return Timebase(RAW, 0.001, speed_up, 0.25)


@pytest.mark.parametrize("speed_up", [1.0, 10.0])
def test_a_machine_whose_time_fits_is_trusted_for_days_and_over_the_wrap(speed_up):
    clock = base(speed_up)
    drift = 0.4 * CLOCK_DRIFT
    for k in range(0, 3_000_000, 97):
        now = 0.1 * k * (1.0 + drift) + 0.1 * (k % 7 == 0)
        raw = (RAW - 5_000_000 + round(100 * speed_up * k)) % RAW
        assert clock.judge(raw, now) is None


@pytest.mark.parametrize("rate", [0.5, 0.98, 1.02, 50.0])
def test_a_machine_whose_time_runs_at_another_rate_is_not_trusted(rate):
    clock = base()
    found = [clock.judge(round(100 * rate * k), 0.1 * k) for k in range(6000)]
    wrong = [fault is not None for fault in found]
    assert {fault[0] for fault in found if fault} == {"delayed" if rate < 1.0 else "time_rate"}
    assert all(wrong[wrong.index(True) :])
    assert wrong.index(True) <= 3.0 / abs(rate - 1.0) + 2


def settled() -> Timebase:
    """Return a clock that has heard a hundred cycles in time."""
    clock = base()
    assert {clock.judge(100 * k, 0.1 * k) for k in range(100)} == {None}
    return clock


@pytest.mark.parametrize("says_starting", [False, True])
def test_a_cycle_that_is_late_for_good_stays_late(says_starting):
    clock = settled()
    for k in range(100, 20_000):
        if says_starting and k % 100 == 0:
            clock.restart()
        found = clock.judge(100 * k, 0.1 * k + 2.0)
        assert found is not None
        assert found[0] == "delayed"
    assert clock.judge(2_000_000, 2_000.0) is None


def test_a_proof_tells_a_clock_that_was_set_back_from_a_delay():
    clock = settled()
    found = clock.judge(5_000, 10.0, proven=True, jumped=True)
    assert found is not None
    assert found[0] == "time_jump"
    assert clock.judge(5_100, 10.1, proven=True) is None


def test_time_goes_back_without_a_fault_only_after_the_machine_has_started():
    clock = settled()
    found = clock.judge(0, 10.0, jumped=True)
    assert found is not None
    assert found[0] == "time_jump"
    clock.restart()  # what comes late says so as well
    assert clock.judge(100, 10.1) is not None
    clock = settled()
    clock.restart()
    assert [clock.judge(100 * k, 10.0 + 0.1 * k) for k in range(9)] == [None] * 9


def test_a_burst_that_overlaps_newer_cycles_costs_only_itself():
    clock = settled()
    for k in range(15):
        assert clock.judge(10_000 + 100 * k, 12.0 + 1e-3 * k) is not None
        assert clock.judge(12_000 + 100 * k, 12.0 + 0.1 * k) is None


@pytest.mark.parametrize("machine_clock", [False, True])
def test_a_time_that_stands_is_a_fault(database, unit, machine_clock):
    bench = Bench(database, unit, GatewaySettings(machine_clock=machine_clock))
    bench.settle(WARM)
    stands = {**WARM, "machine_time": bench.time_s, "machine_step": 0.0}
    bench.cycle(stands)
    answer = bench.cycle(stands)
    assert answer["bus_fault"] == "time_stands"
    assert answer["valid"] == "invalid"


@pytest.mark.parametrize("machine_clock", [False, True])
def test_the_wrap_of_the_machines_time_is_no_fault(database, unit, machine_clock):
    bench = Bench(database, unit, GatewaySettings(machine_clock=machine_clock))
    signal = database.signal("machine_time")
    wrap_s = (high_raw(signal) + 1) * signal.scale
    bench.time_s = wrap_s - 7.0
    sent = bench.frames
    bench.frames = lambda values=None, state="running": sent(
        {**(values or {}), "machine_time": round(bench.time_s % wrap_s, 3)}, state
    )
    bench.settle(WARM)
    first = len(bench.answers)
    for _ in range(100):
        bench.cycle(WARM)
    assert bench.time_s > wrap_s
    assert {answer["valid"] for answer in bench.answers[first:]} == {"valid"}


# Age


def test_a_cycle_that_waited_to_be_read_is_not_valid(bench):
    bench.settle(WARM)
    messages = bench.frames(WARM)
    bench.now += 0.4
    for message in messages:
        bench.node.handle(message, bench.now, waited_s=0.3)
    assert bench.last["valid"] == "invalid"
    assert bench.last["bus_fault"] == "stale"


def test_an_answer_that_took_long_is_not_valid(bench):
    bench.settle(WARM)
    step = bench.unit.step

    def slow(values: object, step_s: float) -> dict[str, float]:
        bench.now += 0.3
        return step(values, step_s)

    bench.unit.step = slow
    assert bench.cycle(WARM)["valid"] == "invalid"
    assert bench.last["bus_fault"] == "stale"


# Another gateway


def test_another_gateway_is_noticed(bench, database):
    bench.settle(WARM)
    other = Sender(database, COMPENSATOR)
    bench.cycle(WARM, lambda messages: [other.messages({})[0], *messages])
    assert bench.last["valid"] == "valid"  # one may be chance
    for _ in range(5):
        bench.cycle(WARM, lambda messages: [*other.messages({}), *messages])
        assert bench.last["valid"] == "invalid"
        assert bench.last["bus_fault"] == "second_gateway"
        assert bench.last["bus_fault_frame"] == "CompensatorHeartbeat"
    for _ in range(20):
        bench.cycle(WARM)
    assert bench.last["valid"] == "valid"


# What the compensator says


def test_a_status_of_the_compensator_that_is_not_known_here_passes(bench, database):
    bench.settle(WARM)
    bench.answering(status=7.0)
    answer = bench.cycle(WARM)
    assert (answer["status"], answer["valid"]) == (7, "valid")
    reception = Reception(database.of(COMPENSATOR))
    sender = Sender(database, COMPENSATOR)
    for _ in range(2):
        for message in sender.messages({"status": 7.0, "dX": 1.0, "valid": "valid"}):
            cycle = reception.take(message.arbitration_id, message.data, 0.0)
    assert cycle is not None
    assert cycle.usable
    assert cycle.values["valid"] == 1.0


@pytest.mark.parametrize("offset", [650.1, nan])
def test_an_offset_that_no_frame_can_carry_is_not_valid(bench, offset):
    bench.settle(WARM)
    bench.answering(dY=offset)
    assert bench.cycle(WARM)["valid"] == "invalid"
