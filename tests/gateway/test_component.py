"""The component in LinuxCNC: its logic without LinuxCNC, its twin in C, and both at the control."""

import ctypes
import json
import random
import subprocess
from pathlib import Path
from typing import Any

import pytest

from benchmarks.linuxcnc import sandbox, study
from benchmarks.linuxcnc.__main__ import main
from benchmarks.linuxcnc.folder import SHIPPED, renamed, write_folder
from gateway.control import FOLLOWING, HOLDING, OffsetFollower
from gateway.database import OFFSETS
from gateway.linuxcnc import native_component
from gateway.linuxcnc.axes import AxisOffset
from gateway.linuxcnc.component import NAMES, ControlPins, sent_signals
from gateway.mapping import read_database
from measurement.errors import BadInput
from tests.gateway.control_axis import ControlAxis
from tests.running import cannot_run

CYCLE_S, SLEW = 0.1, 5.0


class Control:
    """LinuxCNC's pins and axes, at a clock of their own."""

    def __init__(self) -> None:
        self.now, self.axes = 100.0, {name: ControlAxis() for name in NAMES}
        self.pins: dict[str, Any] = dict.fromkeys(
            ("cold", "clear", "heartbeat", "running", "wait", "moved", "valid", "following"), False
        )
        self.pins |= {"alive": True, "enable": True, "coord": True, "teleop": False, "status": 0}
        self.pins |= {f"counts-{name}": 0 for name in NAMES}
        self.pins |= {f"offset-{name}": 0.0 for name in NAMES}
        self.restart()

    def restart(self) -> None:
        """Begin with a new component."""
        self.component = ControlPins(
            *(self.pins, [], CYCLE_S, CYCLE_S, SLEW), external=True, clock=lambda: self.now
        )
        self.component.follower = OffsetFollower(1.0)
        self.component.follower.use = FOLLOWING

    def cycle(self, offsets: dict[str, float], times: int = 1) -> None:
        for _ in range(times):
            self.now += CYCLE_S
            for name, axis in self.axes.items():
                self.pins[f"request-{name}"] = axis.request_um / 1e3
                self.pins[f"command-{name}"] = axis.command_mm
                self.pins |= {"on": axis.on, "homed": axis.homed}
            self.component.step(offsets)
            for name, axis in self.axes.items():
                if self.pins["running"]:
                    axis.give(self.pins[f"counts-{name}"])
                axis.counts = self.pins[f"counts-{name}"]


@pytest.fixture
def control() -> Control:
    return Control()


WANTED = dict(zip(OFFSETS, (-2.0, 3.0, 10.0), strict=True))


def test_the_feed_waits_until_an_offset_that_is_followed_is_in_force(control):
    control.cycle(WANTED, 5)
    assert control.pins["wait"]
    control.cycle(WANTED, 30)
    assert not control.pins["wait"]
    assert [axis.moved_um for axis in control.axes.values()] == pytest.approx([-2.0, 3.0, 10.0])


def test_offsets_that_fade_hold_up_nothing(control):
    control.cycle(WANTED, 40)
    control.component.follower.use = HOLDING
    control.cycle(dict.fromkeys(OFFSETS, 0.0), 5)
    assert not control.pins["wait"]
    assert control.axes["z"].moved_um == pytest.approx(10.0 - 5 * CYCLE_S * SLEW)


def test_homing_is_allowed_once_the_offsets_are_cleared(control):
    control.cycle(WANTED, 40)
    assert control.pins["moved"]
    control.pins["clear"] = True
    control.cycle(WANTED, 40)
    assert not control.pins["moved"]
    assert all(abs(axis.motor_um) < 1e-6 for axis in control.axes.values())


def test_a_component_that_waited_moves_no_axis_further_than_in_one_cycle(control):
    control.cycle(WANTED, 4)
    before = control.axes["z"].moved_um
    control.now += 0.3
    control.cycle(WANTED)
    assert 0.0 < control.axes["z"].moved_um - before <= CYCLE_S * SLEW + 1e-9


def test_a_watchdog_that_barked_may_look_again_and_nothing_moves_before(control):
    control.cycle(WANTED, 10)
    before = control.axes["z"].moved_um
    control.pins["alive"] = False
    control.cycle(WANTED)
    assert not control.pins["running"]
    assert control.axes["z"].moved_um == before
    control.pins["alive"] = True
    control.cycle(WANTED)
    assert control.pins["running"]
    assert control.axes["z"].moved_um > before


def test_a_new_component_moves_nothing_before_it_has_taken_up_what_is_in_force(control):
    control.cycle(WANTED, 40)
    # The pins of a new component begin at 0; while it does not run, the control drops the change.
    control.pins |= {f"counts-{name}": 0 for name in NAMES} | {"running": False}
    for axis in control.axes.values():
        axis.counts = 0
    control.restart()
    for _ in range(4):
        control.cycle(WANTED)
        assert control.axes["z"].moved_um == pytest.approx(10.0, abs=0.02)


def test_every_number_of_the_frames_has_a_pin_that_the_example_connects():
    text = (SHIPPED / "thermal.hal").read_text()
    assert all(f"thermal.in.{name}\n" in text for name in sent_signals(read_database()))


def test_a_component_of_another_name_is_connected_in_the_same_way(tmp_path):
    commands = {"thermal": ["/bin/it", "{name}"], "spindle": ["a b"], "display": ["sleep", "1"]}
    write_folder(tmp_path, "own", commands)
    assert (tmp_path / "thermal.sh").read_text() == '#!/bin/sh\nexec /bin/it "$1"\n'
    text = renamed(tmp_path, "other").read_text()
    assert "loadusr -Wn other ./thermal.sh other\n" in text
    assert "thermal." not in text.replace("./thermal.sh", "")


def test_the_twin_in_c_moves_an_axis_in_the_same_way(compiler, tmp_path):
    library = tmp_path / "axes.so"
    source = native_component.SOURCES / "axes.c"
    flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC"]
    subprocess.run([*compiler, *flags, "-o", library, source, "-lm"], check=True)

    class Axis(ctypes.Structure):
        _fields_ = (
            ("slew_um_s", ctypes.c_double),
            ("in_force_um", ctypes.c_double),
            ("counts", ctypes.c_int32),
            ("before_um", ctypes.c_double),
            ("absorbed_um", ctypes.c_double),
            ("stands_at_mm", ctypes.c_double),
            ("asked", ctypes.c_int32),
            ("held_um", ctypes.c_double),
            ("taken", ctypes.c_bool),
        )

    c, number = ctypes.CDLL(str(library)), ctypes.c_double
    c.axis_begin.argtypes = (ctypes.POINTER(Axis), number, number, ctypes.c_int32)
    c.axis_step.argtypes = (*(ctypes.POINTER(Axis), number, ctypes.c_bool, number, number, number),)
    c.axis_at_zero.argtypes, c.axis_at_zero.restype = (ctypes.POINTER(Axis),), ctypes.c_bool
    twin, own, axis = Axis(), AxisOffset(SLEW, 3.0, 40), ControlAxis(request_um=3.0, counts=40)
    c.axis_begin(twin, SLEW, 3.0, 40)
    chance, wanted = random.Random(29), 0.0
    for _ in range(3000):
        event = chance.choice(("want", "off", "on", "go", *["stay"] * 8))
        wanted = chance.uniform(-30.0, 30.0) if event == "want" else wanted
        if event in ("off", "on"):
            axis.switch(event == "on")
        elif event == "go" and axis.on:
            axis.go_to(chance.uniform(-5.0, 5.0))
        seen, elapsed = axis.seen(), chance.uniform(0.02, 0.15)
        own.step(wanted, seen, elapsed)
        c.axis_step(twin, wanted, seen.takes, seen.request_um, seen.command_mm, elapsed)
        assert (twin.counts, c.axis_at_zero(twin)) == (own.counts, own.at_zero)
        if chance.random() < 0.8:  # a busy control looks later
            axis.give(own.counts)


@pytest.mark.long
def test_the_nose_of_a_real_control_is_held_through_all_faults(tmp_path):
    """Both ways at once, in namespaces; thermal time is faster, the axes are not."""
    problem = sandbox.problem()
    if not problem and not (native_component.HEADERS / "hal.h").exists():
        problem = "no LinuxCNC headers (package linuxcnc-uspace-dev)"
    if problem:
        cannot_run(problem)
    out = tmp_path / "day"
    assert main(["--part", "6", "--out", str(out)]) == 0
    summary = json.loads((out / "summary.json").read_text())
    assert sorted(summary) == ["component", "gateway"]
    names = [event["name"] for event in json.loads((out / "gateway_events.json").read_text())]
    for fault in ("E-stop", "gateway killed", "bus lost", "limited", "home", "component killed"):
        assert fault in names
    for figures in summary.values():
        assert figures["rest_rows"] > 100
        assert figures["drift_um"] > 15.0
        # A fault that is not honoured leaves the whole drift, or jumps by it. A busy computer makes
        # an outage longer, in which minutes of temperatures are missed.
        assert figures["error_um"] < 3.0 + 3.0
        # Two looks of the component at half a micrometre each, in whole counts.
        assert figures["jump_um"] < 1.02
        assert figures["left_after_clear_um"] < 0.05


def test_a_day_that_fails_ends_the_other(tmp_path, monkeypatch):
    """Else it writes on into the folder that is being removed."""
    begun = []

    def begin(folder: Path, kind: str, *_: Any) -> subprocess.Popen[bytes]:
        said = "echo no axis >&2; exit 3" if kind == "one" else "exec sleep 600"
        begun.append(subprocess.Popen(["sh", "-c", said], stderr=subprocess.PIPE))
        return begun[-1]

    monkeypatch.setattr(study, "check", lambda: None)
    monkeypatch.setattr(study, "_begin", begin)
    kinds = {"one": tmp_path, "other": tmp_path}
    with pytest.raises(BadInput, match="the day came to no end: no axis"):
        study.run_days(tmp_path, kinds, tmp_path, study.Plan(1, 1.0, 1.0, "own"))
    assert [process.returncode for process in begun] == [3, -9]
