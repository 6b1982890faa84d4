"""What the gateway cannot know it does not call valid: references, clocks, counts, age, rivals."""

from math import nan
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import can
import pytest

from gateway.codec import Sender
from gateway.database import COMPENSATOR, MACHINE
from gateway.node import GatewaySettings
from gateway.reception import Reception
from gateway.reference import Proof, Reference
from gateway.serving import Service
from gateway.timebase import CLOCK_DRIFT, Timebase
from tests.gateway.bench import WARM, Bench, validity

NOT_COLD = {"thermal_state": "warm"}
TOGETHER = GatewaySettings(proof=Proof(ambient="T5", band_k=1.0, time_s=60.0))

# The reference


def test_a_cold_restart_in_a_warm_up_is_never_valid(bench):
    bench.begin(NOT_COLD)
    names = ("valid", "status", "dX", "dY", "dZ", "gateway_state", "bus_fault")
    said = {tuple(answer[n] for n in names) for answer in bench.cycles(200, WARM | NOT_COLD)}
    assert said == {("invalid", "reference_unknown", 0.0, 0.0, 0.0, "running", "none")}
    assert bench.node.steps == 0


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
    bench.begin({"thermal_state": "cold"})
    bench.begin(NOT_COLD, count=700)
    assert bench.cycle(NOT_COLD)["status"] == "reference_unknown"
    assert bench.node.steps == 0


def test_temperatures_that_stand_with_the_ambient_one_prove_a_cold_machine(database, unit):
    bench = Bench(database, unit, TOGETHER)
    bench.begin(NOT_COLD)
    began = bench.now
    while bench.node.steps == 0 and bench.now - began < 100.0:
        bench.cycle({"T3": 20.4} | NOT_COLD)
    assert validity(bench.answers[:-1]) == {"invalid"}
    assert bench.now - began == pytest.approx(60.0, abs=1.0)
    assert any("within 1 K" in line for line in bench.said)


ALL_AT_20 = {f"T{n}": 20.0 for n in range(1, 12)}


@pytest.mark.parametrize(
    ("proof", "step_s", "moved"),
    [
        pytest.param(TOGETHER.proof, 0.1, lambda k: {"T1": 21.1}, id="apart"),
        pytest.param(
            TOGETHER.proof, 0.1, lambda k: dict.fromkeys(ALL_AT_20, 30 - k * 3e-3), id="cools"
        ),
        pytest.param(TOGETHER.proof, 0.1, lambda k: {"T7": nan}, id="one is missing"),
        pytest.param(TOGETHER.proof, 100.0, lambda k: {}, id="gaps in the readings"),
        pytest.param(Proof(), 10.0, lambda k: {}, id="no ambient one"),
    ],
)
def test_temperatures_that_are_apart_or_move_prove_nothing(proof, step_s, moved):
    reference = Reference(proof, list(ALL_AT_20))
    for k in range(1000):
        assert not reference.take(ALL_AT_20 | moved(k), step_s, cold=False)


# Frames of different cycles


@pytest.mark.parametrize(("behind", "place"), [(1, 1), (240, 5)])
def test_a_frame_that_is_late_for_good_is_noticed(warm, behind, place):
    kept: list[can.Message] = []

    def delay(messages: list[can.Message]) -> list[can.Message]:
        kept.append(messages[place])
        older = [kept.pop(0)] if len(kept) > behind else []
        return [*messages[:place], *older, *messages[place + 1 :]]

    first = len(warm.answers)
    for k in range(behind + 300):
        moved = 0.01 * k
        told = {"tool_length": 150.0 + moved, "T10": 20.0 + moved, "T2": 20.0 + moved}
        warm.cycle(WARM | told, delay)
    assert validity(warm.answers[first:]) == {"invalid"}
    # It is believed again as soon as it comes in time, or when the machine has started anew.
    kept.clear()
    warm.begin()
    warm.cycles(60, WARM)
    assert warm.last["valid"] == "valid"


def test_a_further_frame_in_sequence_is_noticed(warm, database):
    other = Sender(database, MACHINE)
    for _ in range(warm.sender._encoders[5]._count + 1):
        extra = other.messages({"tool_length": 240.0, "speed": 3000.0})[5]
    answer = warm.cycle(WARM, lambda messages: [*messages[:6], extra, messages[6]])
    assert answer["valid"] == "invalid"
    assert answer["dX_tool_length"] == 150.0
    assert warm.cycle(WARM)["valid"] == "invalid"


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
        assert found[0] == "delayed"
    assert clock.judge(2_000_000, 2_000.0) is None


def test_a_proof_tells_a_clock_that_was_set_back_from_a_delay():
    clock = settled()
    found = clock.judge(5_000, 10.0, proven=True, jumped=True)
    assert found[0] == "time_jump"
    assert clock.judge(5_100, 10.1, proven=True) is None


def test_time_goes_back_without_a_fault_only_after_the_machine_has_started():
    clock = settled()
    found = clock.judge(0, 10.0, jumped=True)
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


EITHER_CLOCK = pytest.mark.parametrize("machine_clock", [False, True])


@EITHER_CLOCK
def test_a_time_that_stands_is_a_fault(database, unit, machine_clock):
    bench = Bench(database, unit, GatewaySettings(machine_clock=machine_clock))
    bench.settle(WARM)
    stands = {**WARM, "machine_time": bench.time_s, "machine_step": 0.0}
    bench.cycle(stands)
    answer = bench.cycle(stands)
    assert answer["bus_fault"] == "time_stands"
    assert answer["valid"] == "invalid"


@EITHER_CLOCK
def test_the_wrap_of_the_machines_time_is_no_fault(database, unit, machine_clock):
    bench = Bench(database, unit, GatewaySettings(machine_clock=machine_clock))
    signal = database.signal("machine_time")
    wrap_s = (signal.allowed_raw[1] + 1) * signal.scale
    bench.time_s = wrap_s - 7.0
    sent = bench.frames
    bench.frames = lambda values=None, state="running": sent(
        {**(values or {}), "machine_time": round(bench.time_s % wrap_s, 3)}, state
    )
    bench.settle(WARM)
    assert validity(bench.cycles(100, WARM)) == {"valid"}
    assert bench.time_s > wrap_s


# Age


def test_a_cycle_that_waited_to_be_read_is_not_valid(warm):
    messages = warm.frames(WARM)
    warm.now += 0.4
    for message in messages:
        warm.node.handle(message, warm.now, waited_s=0.3)
    assert warm.last["valid"] == "invalid"
    assert warm.last["bus_fault"] == "stale"


def test_an_answer_that_took_long_is_not_valid(warm):
    step = warm.unit.step

    def slow(values: object, step_s: float) -> dict[str, float]:
        warm.now += 0.3
        return step(values, step_s)

    warm.unit.step = slow
    assert warm.cycle(WARM)["valid"] == "invalid"
    assert warm.last["bus_fault"] == "stale"


# Another gateway


def test_another_gateway_is_noticed(warm, database):
    other = Sender(database, COMPENSATOR)
    warm.cycle(WARM, lambda messages: [other.messages({})[0], *messages])
    assert warm.last["valid"] == "valid"  # one may be chance
    found = warm.cycles(5, WARM, lambda messages: [*other.messages({}), *messages])
    assert validity(found) == {"invalid"}
    said = {(answer["bus_fault"], answer["bus_fault_frame"]) for answer in found}
    assert said == {("second_gateway", "CompensatorHeartbeat")}
    warm.cycles(20, WARM)
    assert warm.last["valid"] == "valid"


# What the compensator says


def test_a_status_of_the_compensator_that_is_not_known_here_passes(warm, database):
    warm.answering(status=7.0)
    answer = warm.cycle(WARM)
    assert (answer["status"], answer["valid"]) == (7, "valid")
    reception = Reception(database.of(COMPENSATOR))
    sender = Sender(database, COMPENSATOR)
    for _ in range(2):
        for message in sender.messages({"status": 7.0, "dX": 1.0, "valid": "valid"}):
            cycle = reception.take(message.arbitration_id, message.data, 0.0)
    assert cycle.usable
    assert cycle.values["valid"] == 1.0


@pytest.mark.parametrize("offset", [650.1, nan])
def test_an_offset_that_no_frame_can_carry_is_not_valid(warm, offset):
    warm.answering(dY=offset)
    assert warm.cycle(WARM)["valid"] == "invalid"
