"""The spindle behind LinuxCNC: the plant FMU as a component, driven by the control.

The control's spindle speed and tool length drive it, and its temperatures appear at pins. The
motion of the nose is recorded in the control's own time: its thread samples the true positions of
the axes, together with the number of the plant's step.

Thermal time is faster than real time, which also magnifies the delays of a busy computer: a
compensator that is stepped late would have minutes of drift to catch up with. So the plant takes a
limited number of steps per step of the component, then waits for the next one, unless the watchdog
reports the component dead. The plant starts with the component's first step, which cannot know of
any earlier drift.
"""

from __future__ import annotations

import argparse
import csv
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from gateway.database import OFFSETS
from gateway.linuxcnc.modules import linuxcnc_module, new_component
from gateway.options import stop_flag
from gateway.plant import MachinePlant
from scenarios.scenario import read_scenario

SCENARIO = Path(__file__).with_name("day.toml")
STEPS_A_LOOK = 3
"""Largest number of the plant's steps between two of the component's: set on no data."""
SERVO_S, EVERY = 0.005, 10
"""The control's own cycle [s], given by the INI file, and the number of cycles per row; twenty rows
a second are enough."""
STEP_S = EVERY * SERVO_S
"""Real time of a step of the plant, and of a row [s]."""
SAMPLED = (
    *("motor_x", "motor_y", "motor_z", "command_x", "command_y", "command_z", "velocity"),
    *("point", "event", "homed", "valid", "wait", "clear", "limited", "heartbeat"),
)
"""The sampler's connections, in this order; the first seven are numbers."""
KINDS = "fffffffssbbbbbb"
NO_OFFSETS = dict.fromkeys(OFFSETS, 0.0)
"""The control moves the axes, so the plant gets no offsets."""


class Table:
    """Records the samples of the control's thread with the plant's readings at the time.

    Parameters
    ----------
    pins : HAL component
        The plant's component.
    file : text stream
        Takes the rows.
    """

    def __init__(self, pins: Any, file: Any) -> None:
        hal, self._pins = linuxcnc_module("hal"), pins
        self._samples = hal.stream(pins, hal.sampler_base, KINDS)
        self._rows = csv.writer(file)
        self._shown: list[dict[str, float]] = []

    def show(self, readings: dict[str, float]) -> int:
        """Store the plant's new readings; return their number."""
        if not self._shown:
            self._rows.writerow(["servo_s", *readings, *SAMPLED])
        self._shown.append(readings)
        return len(self._shown) - 1

    def write(self) -> None:
        """Write the new samples as rows, and show the control's time."""
        while self._samples.readable:
            values = self._samples.read()
            number = self._samples.sampleno
            self._pins["servo_s"] = number * SERVO_S
            if number % EVERY == 0:
                sampled = dict(zip(SAMPLED, values, strict=True))
                shown = self._shown[sampled["point"]]
                cells = [number * SERVO_S, *shown.values(), *sampled.values()]
                self._rows.writerow(float(cell) for cell in cells)


class DrivenPlant(MachinePlant):
    """The plant, driven by the control in place of a scenario's signals."""

    def drive(self, values: dict[str, float]) -> None:
        """Set signals at this point, each in its unit."""
        for name, value in values.items():
            self._signals[name][self.point] = value


class Looks:
    """Waits for the component, whose heartbeat changes at each of its steps."""

    def __init__(self, pins: Any, stopped: Callable[[], bool]) -> None:
        self._pins, self._stopped = pins, stopped
        self._beat, self._steps, self._begun = False, 0, False
        self._due = time.monotonic()

    def wait(self) -> bool:
        """Wait until the plant may take its next step; return whether it may start at all."""
        # A late plant does not hurry afterwards.
        now = time.monotonic()
        self._due = max(self._due + STEP_S, now)
        time.sleep(self._due - now)
        self._steps += 1
        while True:
            if self._pins["heartbeat"] != self._beat:
                self._beat, self._steps, self._begun = not self._beat, 0, True
            dead = self._begun and not self._pins["alive"]
            if self._steps < STEPS_A_LOOK or dead or self._stopped() or not self._begun:
                return self._begun
            time.sleep(STEP_S / 10)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the spindle until LinuxCNC ends it."""
    parser = argparse.ArgumentParser(prog="benchmarks.linuxcnc.spindle")
    parser.add_argument("--plant", type=Path, required=True)
    parser.add_argument("--speed-up", type=float, required=True)
    parser.add_argument("--duration", type=float, required=True, help="[s] of wall time, at most")
    parser.add_argument("--out", type=Path, required=True)
    args = parser.parse_args(argv)
    step_s = STEP_S * args.speed_up
    settings = {"duration_s": args.duration * args.speed_up, "step_s": step_s, "record_s": step_s}
    case = read_scenario(str(SCENARIO), list(settings.items())).cases[0]
    plant = DrivenPlant(args.plant, case, recorded=False)
    plant.start()
    temperatures = sorted(name for name in plant.readings() if name[0] == "T")
    table = {
        ("FLOAT", "IN"): ("speed", "tool_length"),
        ("BIT", "IN"): ("alive", "heartbeat"),
        ("BIT", "OUT"): ("cold",),
        ("S32", "OUT"): ("point",),
        ("FLOAT", "OUT"): ("servo_s", *temperatures),
    }
    pins = new_component("spindle-plant", table)
    # Line by line, so that nothing is lost if the component is killed.
    with args.out.open("w", buffering=1, newline="") as file, stop_flag() as stopped:
        rows, looks, cold, ready = Table(pins, file), Looks(pins, stopped), True, False
        while not stopped() and not plant.done:
            plant.drive({"speed": pins["speed"], "tool_length": pins["tool_length"]})
            readings = plant.readings()
            for name in temperatures:
                pins[name] = readings[name]
            cold = cold and pins["speed"] == 0.0
            pins["cold"] = cold
            pins["point"] = rows.show({"time_s": plant.time_s, **readings})
            if not ready:
                pins.ready()
                ready = True
            rows.write()
            if looks.wait():
                plant.step(NO_OFFSETS)
    plant.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
