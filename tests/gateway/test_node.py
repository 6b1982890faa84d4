"""The safe state: whatever goes wrong, hold, ramp to zero, never a step, and say which."""

import re
from itertools import pairwise

import pytest

from gateway.database import MACHINE
from gateway.dbc import DBC
from gateway.mapping import read_database
from gateway.node import GatewaySettings
from gateway.state import Saved
from tests.gateway import faults
from tests.gateway.bench import WARM, Bench, validity, with_bytes
from tests.gateway.conftest import HOLD_S, RECOVER_S, SLEW_UM_PER_S

RESOLUTION_UM = 0.02

OF_A_FRAME = {
    faults.corrupted: "bad_crc",
    faults.dropped: "missing",
    faults.short: "wrong_length",
    faults.repeated: "repeated",
    faults.twice: "repeated",
    faults.sequence: "out_of_sequence",
}
WHOLE_CYCLE = [
    pytest.param(change(place), fault, id=f"{change.__name__}-{place}")
    for change, fault in OF_A_FRAME.items()
    for place in faults.PLACES
]
SIGNALS = [
    pytest.param(faults.raw_signal("T1", 65535), "not_available_value", id="not-available"),
    pytest.param(faults.raw_signal("T4", 65534), "error_value", id="error"),
    pytest.param(faults.raw_signal("T1", 3999), "out_of_range", id="below"),
    pytest.param(faults.raw_signal("T1", 50001), "out_of_range", id="above"),
    pytest.param(faults.raw_signal("tool_length", 2_000_001), "out_of_range", id="tool"),
    pytest.param(faults.raw_signal("tool_length", 0xFFFFFF), "not_available_value", id="no-tool"),
    pytest.param(faults.raw_signal("machine_state", 9), "out_of_range", id="state"),
    pytest.param(faults.raw_signal("machine_state", 3), "machine_not_running", id="stopping"),
    pytest.param(faults.raw_signal("machine_time", 2**32 - 1), "not_available_value", id="no-time"),
    pytest.param(faults.raw_signal("machine_time", 5), "time_jump", id="time"),
]


@pytest.mark.parametrize(
    ("change", "fault"), [WHOLE_CYCLE[0], WHOLE_CYCLE[-1], SIGNALS[0], SIGNALS[-3], SIGNALS[-1]]
)
def test_a_fault_holds_then_ramps_to_zero_and_recovery_is_ramped(warm, change, fault):
    held = warm.offsets
    assert max(map(abs, held)) > 10.0
    do = change(warm.database)
    if fault == "repeated":
        warm.cycle(WARM, do)  # the good frame at which the sender then is stuck
    first, begun = len(warm.answers), warm.now
    while warm.now - begun < HOLD_S + 6.0:
        before = len(warm.answers)
        warm.cycle(WARM, do)
        if len(warm.answers) > before:
            assert warm.last["bus_fault"] == fault or warm.now - begun > 0.4
            holds = warm.now - begun < HOLD_S
            assert not holds or (warm.last["status"], warm.offsets) == ("holding_missing", held)
    after = warm.answers[first:]
    assert validity(after) == {"invalid"}
    ways = {answer["status"] for answer in after}
    assert ways == {"holding_missing", "ramping_missing", "zero_missing"}
    assert warm.offsets == (0.0, 0.0, 0.0)
    recovered_at = warm.now
    while warm.last["valid"] == "invalid" and warm.now - recovered_at < 60.0:
        warm.cycle(WARM)
    assert warm.last["valid"] == "valid"
    assert warm.last["bus_fault"] == "none"
    assert warm.now - recovered_at >= RECOVER_S + max(map(abs, held)) / SLEW_UM_PER_S - 0.5
    assert warm.offsets == pytest.approx(held, abs=2 * RESOLUTION_UM)
    assert_no_step(warm)


def assert_no_step(bench: Bench, pause_s: float = 0.36) -> None:
    """Between two answers no offset moves further than the slew limit allows."""
    allowed = SLEW_UM_PER_S * pause_s + RESOLUTION_UM
    for axis in "XYZ":
        values = [answer[f"d{axis}"] for answer in bench.answers]
        moves = [abs(b - a) for a, b in pairwise(values)]
        assert max(moves) <= allowed


@pytest.mark.parametrize(("change", "fault"), [*WHOLE_CYCLE, *SIGNALS[:-1]])
def test_one_fault_is_enough_to_hold(warm, change, fault):
    held = warm.offsets
    do = change(warm.database)
    if fault == "repeated":
        warm.cycle(WARM, do)
    answers = [*warm.cycles(1, WARM, do), *warm.cycles(3, WARM)]
    assert fault in {str(answer["bus_fault"]) for answer in answers}
    assert answers[-1]["status"] == "holding_missing"
    assert warm.offsets == held
    warm.cycles(round(RECOVER_S / 0.1) + 5, WARM)
    assert warm.last["valid"] == "valid"


def test_a_machine_time_that_jumps_and_comes_back_is_time_not_seen(warm):
    reached, time_s = warm.unit.time_s, warm.time_s
    warm.cycle(WARM, faults.raw_signal("machine_time", 5)(warm.database))
    warm.cycle(WARM)
    assert warm.last["bus_fault"] == "time_jump"
    assert warm.unit.time_s - reached == pytest.approx(time_s, abs=0.5)
    warm.cycles(200, WARM)
    assert warm.last["valid"] == "valid"
    assert_no_step(warm)


@pytest.mark.parametrize("place", faults.PLACES)
def test_a_stray_frame_with_a_bad_crc_or_length_does_not_stop_the_loop(warm, place):
    for data in (bytes(8), b"", b"\x01", bytes(range(7))):

        def stray(messages: faults.Messages, data: bytes = data) -> faults.Messages:
            return [*messages[:place], with_bytes(messages[place], data), *messages[place:]]

        answer = warm.cycle(WARM, stray)
        assert answer["valid"] == "valid"
    assert warm.node.reception.counts["wrong_length"] == 3
    assert warm.node.reception.counts["bad_crc"] == 1


@pytest.mark.parametrize("timeout_s", [None, 2.0])
def test_silence_is_noticed_in_time_and_a_late_cycle_is_not_used(database, unit, timeout_s):
    bench = Bench(database, unit, GatewaySettings(timeout_s=timeout_s))
    bench.settle(WARM)
    bench.wait((timeout_s or database.closing(MACHINE).timeout_s) - 0.001)
    assert bench.last["valid"] == "valid"
    count = len(bench.answers)
    bench.wait(0.002)
    assert len(bench.answers) == count + 1
    assert bench.last["valid"] == "invalid"
    assert bench.last["bus_fault"] == "missing"
    assert bench.last["bus_fault_frame"] == "MachineHeartbeat"
    bench.wait(HOLD_S + 10.0)
    assert bench.offsets == (0.0, 0.0, 0.0)
    assert bench.last["status"] == "zero_missing"
    assert_no_step(bench, timeout_s or 0.36)
    assert bench.cycle(WARM)["bus_fault"] == "late"
    assert bench.last["valid"] == "invalid"


def test_a_sensor_that_the_model_does_not_use_may_be_missing(warm):
    answer = warm.cycle({**WARM, "T11": float("nan")})
    assert answer["valid"] == "valid"
    assert answer["bus_fault"] == "not_available_value"
    assert answer["bus_fault_frame"] == "MachineTemperatures4"


def test_nothing_is_valid_before_the_machine_runs(bench):
    bench.wait(5.0)
    assert {str(answer["gateway_state"]) for answer in bench.answers} == {"starting"}
    bench.begin(count=4)
    assert bench.last["gateway_state"] == "ready"
    assert bench.last["bus_fault"] == "machine_not_running"
    assert validity(bench.answers) == {"invalid"}
    assert {answer["status"] for answer in bench.answers} == {"waiting"}
    assert bench.node.steps == 0


def test_the_machine_may_say_what_it_does_in_any_of_its_frames(tmp_path, unit):
    text, moved = DBC.read_text("utf-8"), {"machine_step": "speed", "speed": "machine_step"}
    text = re.sub(r"\b(speed|machine_step)\b", lambda found: moved[found[1]], text)
    text = re.sub(r"(machine_step : 16\|16@1\+) .*rpm", r'\1 (0.01,0) [0|600] "s', text)
    text = re.sub(r'(speed : 48\|12@1\+) .*"s"', r'\1 (1,0) [0|4000] "rpm"', text)
    (tmp_path / "other.dbc").write_text(text, "utf-8")
    bench = Bench(read_database(tmp_path / "other.dbc"), unit)
    bench.settle(WARM)


def test_a_machine_that_does_not_come_is_a_startup_timeout(bench):
    bench.wait(10.5)
    assert bench.last["gateway_state"] == "startup_timeout"
    assert bench.last["bus_fault"] == "startup_timeout"
    assert bench.last["valid"] == "invalid"
    assert any("10 s" in line for line in bench.said)
    bench.settle(WARM)


@pytest.mark.parametrize("lost", ["bus_off", "interface_lost"])
def test_without_a_bus_offsets_are_given_up_and_the_return_is_told_and_ramped(warm, lost):
    held = warm.offsets
    for k in range(100):
        warm.now += 0.1
        warm.node.tick(warm.now, lost)
        assert warm.last["bus_fault"] == lost
        assert warm.last["gateway_state"] == "reconnecting"
        assert warm.last["valid"] == "invalid"
        if k < HOLD_S / 0.1 - 2:
            assert warm.offsets == held
    assert max(map(abs, warm.offsets)) < max(map(abs, held))
    warm.node.reconnected()
    assert warm.cycle(WARM)["bus_fault"] == lost
    assert not any("lost" in line or "bus off" in line for line in warm.said)  # the link says it
    while warm.last["valid"] == "invalid" and warm.now < 2000.0:
        warm.cycle(WARM)
    assert warm.last["bus_fault"] == "none"
    assert warm.offsets == pytest.approx(held, abs=2 * RESOLUTION_UM)
    assert_no_step(warm)


def test_a_machine_that_stops_within_its_step_is_not_one_whose_time_jumps(warm):
    warm.time_s = round(warm.time_s - warm.step_s, 3)  # the step that it announced last
    warm.give(warm.frames(state="stopping"))
    assert warm.last["bus_fault"] == "machine_not_running"


def test_a_restart_of_the_machine_is_survived(warm, database):
    held = warm.offsets
    warm.sender, warm.time_s, warm.began = type(warm.sender)(database, MACHINE), 0.0, None
    warm.begin(WARM, count=5)
    assert warm.last["bus_fault"] == "machine_not_running"
    assert warm.offsets == held
    warm.cycles(round((RECOVER_S + 1.0) / 0.1), WARM)
    assert warm.last["valid"] == "valid"
    assert warm.offsets == held


def test_the_tool_frames_give_the_offset_at_other_tool_lengths(warm, database, new_unit):
    other = Bench(database, new_unit())
    other.settle({**WARM, "tool_length": 250.0}, seconds=10.0)
    parts = ("at_tool_length", "per_tool_length", "tool_length")
    for axis in "XYZ":
        offset, slope, reference = (float(warm.last[f"d{axis}_{part}"]) for part in parts)
        assert reference == 150.0
        assert offset == warm.last[f"d{axis}"]
        at_250 = offset + slope * (250.0 - reference) * 1e-3
        assert at_250 == pytest.approx(other.last[f"d{axis}"], abs=2 * RESOLUTION_UM)
    assert float(warm.last["dX_per_tool_length"]) != 0.0


def test_slopes_over_the_tool_length_are_ramped_with_their_offset(warm):
    offset, slope = (float(warm.last[f"dX_{part}_tool_length"]) for part in ("at", "per"))
    begun = warm.now
    while warm.now - begun < HOLD_S + 6.0:
        warm.wait(0.1)
        left = float(warm.last["dX_at_tool_length"]) / offset
        assert float(warm.last["dX_per_tool_length"]) == pytest.approx(left * slope, abs=0.02)
    assert left == 0.0


def test_the_machine_clock_steps_by_the_machines_time(database, unit):
    bench = Bench(database, unit, GatewaySettings(machine_clock=True))
    bench.step_s = 2.5
    bench.begin()
    for n in range(1, 9):
        bench.cycle(WARM)
        assert unit.time_s == pytest.approx(2.5 * n)
    bench.cycle(WARM, faults.dropped(6)(database))
    bench.cycle(WARM)
    assert unit.time_s == pytest.approx(25.0)


@pytest.mark.parametrize("speed_up", [1.0, 10.0])
def test_the_own_clock_steps_by_the_time_gone_by(database, unit, speed_up):
    bench = Bench(database, unit, GatewaySettings(speed_up=speed_up))
    bench.give(bench.frames(state="starting"))
    bench.give(bench.frames(state="starting"))
    bench.cycle()
    reached = unit.time_s
    for after_s in (0.1, 0.12, 0.07, 0.2):
        bench.give(bench.frames(), after_s=after_s)
    assert unit.time_s - reached == pytest.approx(0.49 * speed_up)


def test_a_restart_with_the_state_goes_on_after_the_time_in_between(warm, database, new_unit):
    saved = Saved(warm.unit.time_s, warm.time_s, 1.5, warm.unit.slave.saved())
    again = Bench(database, new_unit(), warm=saved)
    again.sender, again.time_s = warm.sender, warm.time_s
    again.cycle(WARM)
    assert (again.last["valid"], again.offsets) == ("invalid", warm.offsets)
    assert again.unit.time_s == pytest.approx(saved.time_s + 1.5, abs=0.2)


@pytest.mark.parametrize("place", faults.PLACES)
def test_no_offset_is_valid_without_a_fresh_cycle_whatever_the_fmu_says(bench, place):
    bench.answering(valid=1.0, status=0.0)
    bench.wait(1.0)
    bench.begin(count=2)
    assert validity(bench.answers) == {"invalid"}
    assert bench.cycle()["valid"] == "valid"
    first = len(bench.answers)
    bench.cycle(None, faults.corrupted(place)(bench.database))
    bench.cycle()
    assert "invalid" in validity(bench.answers[first:])
    bench.cycle()
    first = len(bench.answers)
    bench.wait(2.0)
    bench.node.tick(bench.now, "interface_lost")
    assert validity(bench.answers[first:]) == {"invalid"}
