"""The machine's end: its clock, its answers over the wrap, its memory, and a log in its place."""

from collections.abc import Iterable
from dataclasses import replace
from math import inf
from typing import Any

import can
import pytest

from fmu_packaging.variables import USUAL_TOOL_MM
from gateway.codec import decode
from gateway.database import MACHINE
from gateway.machine import AnswerReceiver, MachineNode, Pace
from gateway.mapfile import MAPS
from gateway.mapping import read_mapping
from gateway.plant import MachinePlant
from gateway.replay import replay
from scenarios.cli import main
from scenarios.scenario import read_scenario
from tests.scenarios.tiny_fmus import PLANT, build_tiny

CYCLE_S = 0.1


class Clock:
    """A clock, and a bus on which nothing comes while it goes on."""

    def __init__(self) -> None:
        self.now = 100.0
        self.sent: list[tuple[float, can.Message]] = []

    def __call__(self) -> float:
        return self.now

    def receive(self, timeout_s: float) -> None:
        self.now += max(timeout_s, 0.0)

    def send(self, messages: Iterable[can.Message]) -> bool:
        self.sent += [(self.now, message) for message in messages]
        return True


class Ear:
    """Hears a gateway at once, and listens to it to the end."""

    timeout_s = 0.5
    last: object = None

    def __init__(self, clock: Clock) -> None:
        self.clock = clock

    def hear(self, link: Any, until: float, time_s: float | None = None) -> bool:
        self.last, self.clock.now = self, max(until, self.clock.now)
        return False


class Plant:
    """A plant that keeps its computer busy now and then."""

    def __init__(self, clock: Clock, busy: dict[int, float], steps: int) -> None:
        self.clock, self.busy, self.steps = clock, busy, steps
        self.point, self.step_s, self.thermal_state = 0, CYCLE_S, "cold"

    @property
    def time_s(self) -> float:
        return self.point * self.step_s

    @property
    def done(self) -> bool:
        return self.point >= self.steps

    def readings(self) -> dict[str, float]:
        return {}

    def probe_with(self, names: Any) -> None:
        """No probes."""

    def measured(self, half_widths: Any) -> list[float]:
        return []

    def record(self, offsets: Any, extra: Any) -> None:
        """Nothing to keep."""

    def step(self, offsets: Any) -> None:
        self.clock.now += self.busy.get(self.point, 0.0)
        self.point += 1


def test_the_machines_clock_goes_on_while_its_computer_is_busy(database):
    clock = Clock()
    plant = Plant(clock, {20: 0.05, 40: 0.27, 60: 3.0}, 100)
    pace = Pace(wait_s=0.0)
    MachineNode(database, plant, clock, pace, clock=clock).run()
    closing = database.closing(MACHINE)
    beats = [
        (at, decode(closing, message.data).values)
        for at, message in clock.sent
        if message.arbitration_id == closing.frame_id
    ]
    running = [(at, beat["machine_time"]) for at, beat in beats if beat["machine_state"] == 2.0]
    assert len(running) == 101
    for at, time_s in running:
        assert -1e-6 <= at - 100.0 - time_s < CYCLE_S + 1e-6
    assert running[-1][1] == pytest.approx(13.0, abs=0.11)
    assert all(beat["machine_step"] == CYCLE_S for _, beat in beats if beat["machine_state"] == 2.0)


@pytest.mark.parametrize(("recorded", "rows"), [(False, 0), (True, 21)])
def test_a_machine_without_a_table_does_not_grow(shipped, recorded, rows):
    case = read_scenario("step_speed", [("duration_s", 20), ("record_s", 1)]).cases[0]
    plant = MachinePlant(shipped / "plant.fmu", case, recorded=recorded)
    try:
        plant.start()
        offsets = dict.fromkeys(("dX", "dY", "dZ"), 0.0)
        while True:
            plant.record(offsets, {"valid": 1.0})
            if plant.done:
                break
            plant.step(offsets)
        assert (len(plant.frame()) if recorded else len(plant._table)) == rows
    finally:
        plant.close()


def test_a_machine_tells_the_start_of_an_input_that_no_signal_drives(shipped):
    plant = MachinePlant(shipped / "plant.fmu", read_scenario("training_down").cases[0])
    try:
        plant.start()
        assert plant.readings()["tool_length"] == USUAL_TOOL_MM
    finally:
        plant.close()


def test_a_machine_tells_its_speed_whatever_its_plant_calls_it(tmp_path):
    path = build_tiny(PLANT.replace("speed", "drehzahl"), "ToldPlant", tmp_path)
    scenario = 'format = 1\nname = "a"\ntitle = "A"\nduration_s = 1\nsignals = {drehzahl = 700}'
    (tmp_path / "a.toml").write_text(scenario)
    plant = MachinePlant(path, read_scenario(tmp_path / "a.toml").cases[0])
    try:
        plant.start()
        assert plant.readings()["speed"] == 700
        plant.record(dict.fromkeys(("dX", "dY", "dZ"), 0.0), {})
        assert "speed_rpm" not in plant.frame()
    finally:
        plant.close()


def test_a_long_pause_in_a_log_is_cut_out(database, monkeypatch):
    clock = Clock()
    monkeypatch.setattr("gateway.replay.time.sleep", clock.receive)
    frames = [0.0, 0.1, 0.2, 50.2, 50.3, 1000.0, 1000.25]
    log = [can.Message(arbitration_id=0x210, data=bytes(8), timestamp=t) for t in frames]
    link: Any = clock
    ear = AnswerReceiver(database, clock)
    assert replay(log, database, link, ear, wait_s=0.0, clock=clock) == len(frames)
    at = [when - 100.0 for when, _ in clock.sent]
    assert at == pytest.approx([0.0, 0.1, 0.2, 0.2, 0.3, 0.3, 0.55], abs=1e-6)


def test_a_replay_begins_when_a_gateway_answers_though_no_file_gives_its_frames_a_period():
    database = read_mapping(MAPS / "machine_builder.toml").database
    frames = tuple(replace(frame, cycle_s=inf) for frame in database.frames)
    clock = Clock()
    ear: Any = Ear(clock)
    link: Any = clock
    log = [can.Message(arbitration_id=0x321, data=bytes(8), timestamp=0.0)]
    assert replay(log, replace(database, frames=frames), link, ear, clock=clock) == 1
    assert clock.sent[0][0] == pytest.approx(100.1)


@pytest.mark.parametrize("speed_up", ["7.5", "60", "400"])
def test_any_speed_that_the_frames_can_carry_is_taken(speed_up, capsys, shipped):
    arguments = ["--speed-up", speed_up, "--channel", "nocan7", "--wait", "0"]
    assert main(["machine", "step_speed", *arguments, "--fmu-dir", str(shipped)]) == 2
    assert "nocan7" in capsys.readouterr().err
